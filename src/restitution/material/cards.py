"""Material cards of finite-element codes: Abaqus (*VISCOELASTIC, *TRS) and ANSYS (TB,PRON and TB,SHIFT)."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.errors import InputError, InputTypeError
from restitution.files import path_of, whole_file
from restitution.material.conversion import on_common_times, poisson_ratio, tension_factor
from restitution.material.prony import PronySeries
from restitution.material.shift import GAS_CONSTANT, WLF, Arrhenius
from restitution.material.viscoelastic import Material

Array = NDArray[np.float64]

# Characters of a number in the data lines of Abaqus.
_WIDEST = 20
# Share of the equilibrium in the glass modulus, below which the shares of double numbers do not fix it to 1e-6.
_SMALLEST_EQUILIBRIUM = 1e-10
_HEAD = "Isotropic linear-viscoelastic material, written by restitution. SI units: Pa, s, kg/m3."


def write_material(material: Material | Sequence[Material], path: str | Path) -> Path:
    """Write materials as cards of a finite-element code; the end of the name decides the code.

    Parameters
    ----------
    material
        One material or several, each a Prony series in shear and in bulk.
    path
        The file, in an existing folder. `.inp`: Abaqus. `.txt` or `.mac`: ANSYS.

    Returns
    -------
    pathlib.Path
        `path`.

    Raises
    ------
    InputError
        If a card cannot hold a material: a dashpot in parallel, a Poisson ratio of -1, in Abaqus a liquid.
    OSError
        If the file cannot be written.

    Notes
    -----
    Both codes take shares of the instantaneous moduli, g_k = G_k/G_0 and k_k = K_k/K_0. The elastic constants E and
    nu are those of long times in Abaqus (``*ELASTIC, MODULI=LONG TERM``), and instantaneous ones in ANSYS (``MP``).
    A shift with the temperature is ``*TRS`` in Abaqus and ``TB,SHIFT`` in ANSYS if it is `WLF` or `Arrhenius`; the
    relaxation times are then those at its reference. A comment names any other shift, and the card then holds at the
    temperature of the material alone.

    Units are SI, and comments in the file repeat this. Numbers have 17 digits, or as many as Abaqus takes (20
    characters). `read_material` returns the same moduli but for rounding. In Abaqus the rounding of G_0 grows with
    G_0/G_inf, because only 1 - sum g_k connects the two; that of K grows with K/G in both codes.

    Examples
    --------
    >>> import tempfile
    >>> from restitution.material.readers import read_material
    >>> rubber = Material(PronySeries(1e6, [3e6], [1e-3]), bulk=math.inf, name="rubber")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = write_material(rubber, Path(folder, "rubber.inp"))
    ...     read_material(path).material().shear
    PronySeries(1000000.0, [3000000.0], [0.001])
    """
    path = path_of(path)
    code = CARDS.get(path.suffix.lower())
    if code is None:
        raise InputError("path", str(path), f"must end in {' or '.join(CARDS)}")
    several: list[Any] = list(material) if isinstance(material, list | tuple) else [material]
    if not several or not all(isinstance(one, Material) for one in several):
        raise InputTypeError("material", material, "must be a Material or several (of a fractional model: within)")
    lines = [line for number, one in enumerate(several, 1) for line in code(_Card.of(one, number))]
    with whole_file(path) as partial:
        partial.write_bytes("".join(f"{line}\n" for line in lines).encode("ascii", "replace"))
    return path


class _Card(NamedTuple):
    """Moduli of a material in shear and bulk, merged, and its place among those of the file."""

    material: Material
    number: int  # from 1
    shear: PronySeries
    bulk: PronySeries | None  # None for an incompressible material

    @classmethod
    def of(cls, material: Material, number: int) -> _Card:
        shear, bulk = material.shear, material.bulk
        series = {"shear": shear} | ({"bulk": bulk} if isinstance(bulk, PronySeries) else {})
        for name, one in series.items():
            if one.parallel_viscosity > 0:
                wanted = (
                    "must be 0: the cards have branches but no dashpot in parallel; give it a short relaxation time"
                )
                raise InputError(f"{name}.parallel_viscosity", one.parallel_viscosity, wanted, "Pa s")
        if isinstance(material.shift, WLF | Arrhenius):
            material = material.at(material.shift.reference_temperature)
            shear, bulk = material.shear, material.bulk
        return cls(material, number, shear.simplified(), bulk.simplified() if isinstance(bulk, PronySeries) else None)

    @property
    def name(self) -> str:
        """Name of letters, digits and signs that both codes take, which begins with a letter."""
        text = re.sub(r"[^A-Za-z0-9_-]+", "-", self.material.name or "").strip("-")
        return (text if text[:1].isalpha() else f"material-{text or self.number}")[:80]

    @property
    def shift(self) -> WLF | Arrhenius | None:
        """Shift of the relaxation times, if there are any and the codes have it."""
        relaxes = any(one is not None and not one.is_elastic for one in (self.shear, self.bulk))
        return self.material.shift if relaxes and isinstance(self.material.shift, WLF | Arrhenius) else None

    def constants(self, moduli: Callable[[PronySeries], float]) -> tuple[float, float]:
        """Young's modulus [Pa] and Poisson ratio [-] of instantaneous or equilibrium moduli."""
        shear = moduli(self.shear)
        ratio = poisson_ratio(shear, math.inf if self.bulk is None else moduli(self.bulk))
        if ratio <= -1.0:
            raise InputError("poisson_ratio", ratio, "must be > -1, as the cards hold Young's modulus")
        return shear * tension_factor(ratio), ratio

    def remarks(self, which: str) -> Iterator[str]:
        """Lines of comment; `which` are the elastic constants."""
        glass, rest = (f"G = {one:.6g} Pa" for one in (_glass(self.shear), self.shear.equilibrium_modulus))
        if self.bulk is not None:
            glass, rest = (
                f"{glass}, K = {_glass(self.bulk):.6g} Pa",
                f"{rest}, K = {self.bulk.equilibrium_modulus:.6g} Pa",
            )
        yield _HEAD
        yield f"E and nu are {which}. The relative moduli are shares of the instantaneous moduli."
        yield f"At once: {glass}. After a long time: {rest}."
        if self.bulk is None:
            yield "The material is incompressible: its elements must have the pressure as an unknown (hybrid, mixed)."
        one = self.material
        if self.shift is not None:
            yield f"The relaxation times hold at {one.temperature:g} K. The model must have temperatures, in K."
            if self.shift.temperature_range is not None:
                yield "The shift holds from {:g} to {:g} K.".format(*self.shift.temperature_range)
        elif one.temperature is not None:
            yield f"The moduli hold at {one.temperature:g} K; {lost_shift(one) or 'no shift is written'}."
        if one.window is not None:
            yield f"They hold for times from {one.window[0]:.4g} to {one.window[1]:.4g} s."
        for text in (one.name, one.source, one.assumptions):
            if text:
                yield " ".join(text.split())[:200]


def lost_shift(material: Material) -> str:
    """Words on a shift that the codes do not have; empty if the material has none of that kind."""
    if isinstance(material.shift, WLF | Arrhenius | None):
        return ""
    return f"the cards cannot hold a {type(material.shift).__name__}, and so hold at {material.temperature:g} K alone"


def _glass(series: PronySeries) -> float:
    return series.instantaneous_modulus


def _abaqus(card: _Card) -> Iterator[str]:
    for name, series in (("shear", card.shear), ("bulk", card.bulk)):
        if series is not None and series.equilibrium_modulus < _SMALLEST_EQUILIBRIUM * _glass(series):
            wanted = (
                f"must be >= {_SMALLEST_EQUILIBRIUM:g} of the instantaneous modulus: a card with MODULI=LONG TERM "
            )
            raise InputError(
                f"{name}.equilibrium_modulus", series.equilibrium_modulus, f"{wanted}holds no liquid", "Pa"
            )
    yield f"*MATERIAL, NAME={card.name}"
    yield from (f"** {line}" for line in card.remarks("those of long times (MODULI=LONG TERM)"))
    if card.material.density is not None:
        yield from ("*DENSITY", f"{_text(card.material.density)},")
    young, ratio = card.constants(lambda series: series.equilibrium_modulus)
    yield from ("*ELASTIC, MODULI=LONG TERM", f"{_text(young)}, {_text(ratio)}")
    times, shear, bulk = on_common_times(card.shear, card.bulk or PronySeries(1.0))
    if times.size:
        yield from ("*VISCOELASTIC, TIME=PRONY", "** g_i [-], k_i [-], tau_i [s]")
    # Short times first.
    shares = (
        shear.weights / _glass(card.shear),
        bulk.weights / (1.0 if card.bulk is None else _glass(card.bulk)),
        times,
    )
    yield from (", ".join(map(_text, row)) for row in zip(*(one[::-1] for one in shares), strict=True))
    match card.shift:
        case WLF(T0, C1, C2):
            yield from ("*TRS, DEFINITION=WLF", ", ".join(map(_text, (T0, C1, C2))))
        case Arrhenius(T0, energy):
            gas = f"the universal gas constant {GAS_CONSTANT} J/(mol K)"
            yield f"** The model needs *PHYSICAL CONSTANTS with ABSOLUTE ZERO=0 and {gas}."
            yield from ("*TRS, DEFINITION=ARRHENIUS", ", ".join(map(_text, (T0, energy))))
        case _:
            pass


def _ansys(card: _Card) -> Iterator[str]:
    number = card.number
    yield from (f"! {line}" for line in (f"Material {number}: {card.name}", *card.remarks("the instantaneous ones")))
    young, ratio = card.constants(_glass)
    yield from (f"MP,EX,{number},{_text(young)}", f"MP,PRXY,{number},{_text(ratio)}")
    if card.material.density is not None:
        yield f"MP,DENS,{number},{_text(card.material.density)}"
    for kind, series in (("SHEAR", card.shear), ("BULK", card.bulk)):
        if series is None or series.is_elastic:
            continue
        yield f"TB,PRON,{number},1,{series.n_branches},{kind} ! relative modulus [-], relaxation time [s]"
        shares = (series.branch_moduli / _glass(series)).tolist()
        for place, pair in enumerate(zip(shares, series.relaxation_times.tolist(), strict=True)):
            yield f"TBDATA,{2 * place + 1},{','.join(map(_text, pair))}"
    match card.shift:
        case WLF(T0, C1, C2):
            yield from (f"TB,SHIFT,{number},1,3,WLF", f"TBDATA,1,{','.join(map(_text, (T0, C1, C2)))}")
        case Arrhenius(T0, energy):
            yield f"TB,SHIFT,{number},1,2,TN ! reference [K], activation energy over the gas constant [K]"
            yield f"TBDATA,1,{_text(T0)},{_text(energy / GAS_CONSTANT)}"
        case _:
            pass


def _text(value: float) -> str:
    """Shortest text of a number that is read back exactly, or as many of its digits as Abaqus takes."""
    texts = (repr(float(value)), *(f"{value:.{digits}g}" for digits in (16, 15, 14)))
    short = (re.sub(r"e([+-])0*", r"E\1", text).replace("E+", "E") for text in texts)
    return next(text for text in short if len(text) <= _WIDEST)


CARDS: dict[str, Callable[[_Card], Iterator[str]]] = {".inp": _abaqus, ".txt": _ansys, ".mac": _ansys}
"""Writer of the cards by the end of the name of their file."""
