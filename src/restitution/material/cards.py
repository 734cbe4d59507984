"""Prony terms of files, and the material cards of finite-element codes, read and written.

The cards are those of ANSYS (TB,PRON and TB,SHIFT) and Abaqus (*VISCOELASTIC and *TRS).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from restitution.checks import Array
from restitution.errors import InputError, InputTypeError
from restitution.files import path_of, whole_file
from restitution.material.conversion import Deformation, bulk_factor, on_common_times, poisson_ratio, tension_factor
from restitution.material.prony import PronySeries
from restitution.material.sheet import FileError, Line, split_lines
from restitution.material.shift import GAS_CONSTANT, WLF, Arrhenius
from restitution.material.viscoelastic import Material, single_material
from restitution.quantities import check_single

# Printed relative moduli add up to one apart from rounding: four decimals, some thirty terms.
_SUM_TOLERANCE = 2e-3
_EPS = float(np.finfo(np.float64).eps)
# Characters of a number in the data lines of Abaqus.
_WIDEST = 20
# Share of the equilibrium in the glass modulus, below which the shares of double numbers do not fix it to 1e-6.
_SMALLEST_EQUILIBRIUM = 1e-10
_HEAD = "Isotropic linear-viscoelastic material, written by restitution. SI units: Pa, s, kg/m^3."


@dataclass(frozen=True, eq=False)
class PronyTerms:
    """Terms of a Prony series, absolute or relative to the instantaneous modulus."""

    relaxation_times: Array  # tau_k [s], shape (n_branch,)
    moduli: Array  # R_k [Pa], or R_k/R_0 [-] if `relative`, shape (n_branch,)
    relative: bool  # whether the moduli are shares of the instantaneous modulus
    deformation: Deformation | None = None  # None where the file does not state it
    instantaneous_modulus: float | None = None  # R_0 [Pa], None where the file does not state it
    equilibrium_modulus: float | None = None  # R_inf [Pa], None where the file does not state it
    source: str = ""  # name of the file
    notes: tuple[str, ...] = ()  # remarks of the reader: units that were assumed, columns that are not used

    @property
    def window(self) -> tuple[float, float] | None:
        """Shortest and longest relaxation time [s], None for a single one."""
        return _span(self.relaxation_times)

    def series(
        self, *, instantaneous_modulus: float | None = None, equilibrium_modulus: float | None = None
    ) -> PronySeries:
        """Return the Prony series, with the end modulus from the file unless R_0 or R_inf [Pa] is given here.

        Absolute terms need no end modulus; without one they are those of a liquid. Relative terms are shares of the
        instantaneous modulus, or of the difference where both end moduli are given. If they add up to one, they are
        those of a liquid. An end modulus that is missing or contradicts the terms is refused.

        Examples
        --------
        >>> terms = PronyTerms(np.array([1.0, 10.0]), np.array([0.5, 0.25]), relative=True)
        >>> terms.series(instantaneous_modulus=8.0)
        PronySeries(2.0, [4.0, 2.0], [1.0, 10.0])
        """
        high, low = instantaneous_modulus, equilibrium_modulus
        if high is None and low is None:
            high, low = self.instantaneous_modulus, self.equilibrium_modulus
        high = None if high is None else check_single("instantaneous_modulus", high)
        low = None if low is None else check_single("equilibrium_modulus", low)
        if self.relative:
            low, moduli = self._from_shares(high, low)
            return PronySeries(low, moduli, self.relaxation_times)
        total = float(self.moduli.sum())
        if high is not None and low is not None and abs(high - low - total) > _SUM_TOLERANCE * high:
            raise InputError("instantaneous_modulus", high, f"must be {low + total:g} Pa, the sum of all", "Pa")
        if low is None:
            low = 0.0 if high is None else high - total
            if low < -_SUM_TOLERANCE * total:
                raise InputError("instantaneous_modulus", high, f"must be >= {total:g} Pa, the sum of the terms", "Pa")
        return PronySeries(max(low, 0.0), self.moduli, self.relaxation_times)

    def _from_shares(self, high: float | None, low: float | None) -> tuple[float, Array]:
        """Return the equilibrium modulus and branch moduli of relative terms."""
        total = float(self.moduli.sum())
        rule = ""
        if total > 1.0 + _SUM_TOLERANCE:
            rule = "must be at most 1"
        elif high is not None:
            if low is None:
                # Shares that add up to one but for rounding are those of a liquid.
                rest = 1.0 - total
                return high * rest if rest > _EPS * self.moduli.size else 0.0, self.moduli * high
            if low > high:
                raise InputError("equilibrium_modulus", low, f"must be <= {high:g} Pa, the instantaneous", "Pa")
            share = 1.0 - low / high
            if min(abs(total - 1.0), abs(total - share)) <= _SUM_TOLERANCE:
                return low, self.moduli * ((high - low) / total)
            rule = f"must be 1 (shares of the difference) or {share:.6g} (shares of the instantaneous modulus)"
        elif low is not None:
            if total < 1.0 - 1e-12:
                return low, self.moduli * (low / (1.0 - total))
            rule = "must be below 1"
        else:
            names = "instantaneous_modulus or equilibrium_modulus"
            raise InputError(names, rule="one must be given, as the terms are relative")
        raise InputError("moduli", rule=f"the relative moduli add up to {total:.6g}: {rule}")


def beyond_one(shares: Array) -> int | None:
    """Return the index of the relative modulus with which their sum passes one, None where it does not."""
    beyond = np.flatnonzero(shares.cumsum() > 1.0 + _SUM_TOLERANCE)
    return int(beyond[0]) if beyond.size else None


def _span(times: Array) -> tuple[float, float] | None:
    return (float(times.min()), float(times.max())) if times.size > 1 else None


@dataclass(frozen=True, eq=False)
class ViscoelasticDeck:
    """Material of a solver deck, in SI: relative Prony terms and elastic constants; what it lacks is None."""

    shear: PronyTerms | None
    bulk: PronyTerms | None
    youngs_modulus: float | None  # E [Pa]
    poisson_ratio: float | None  # nu [-]
    long_term: bool  # whether E and nu are those of long times (and not instantaneous)
    density: float | None  # [kg/m^3]
    name: str | None  # name of the material in the deck
    source: str = ""  # name of the file
    shift: WLF | Arrhenius | None = None  # time-temperature shift

    def material(self, *, youngs_modulus: float | None = None, poisson_ratio: float | None = None) -> Material:
        """Return the material in shear and bulk, with E > 0 [Pa] and nu in (-1, 0.5] of the deck unless given here.

        A missing constant is refused, and so are constants of long times where the terms add up to one.

        Examples
        --------
        >>> terms = PronyTerms(np.array([2.0]), np.array([0.5]), relative=True)
        >>> ViscoelasticDeck(terms, None, 9.0, 0.5, long_term=False, density=None, name=None).material().shear
        PronySeries(1.5, [1.5], [2.0])
        """
        modulus = self.youngs_modulus if youngs_modulus is None else youngs_modulus
        ratio = self.poisson_ratio if poisson_ratio is None else poisson_ratio
        if modulus is None or ratio is None:
            name = "youngs_modulus" if modulus is None else "poisson_ratio"
            raise InputError(name, rule="must be given, as the deck lacks it", where=self.source)
        shear = check_single("youngs_modulus", modulus) / tension_factor(ratio)
        with np.errstate(over="ignore"):
            bulk = shear * bulk_factor(ratio)
        if math.isinf(bulk) and ratio < 0.5:
            rule = f"must be smaller: the bulk modulus overflows with a Poisson ratio of {ratio:g}"
            raise InputError("youngs_modulus", modulus, rule, "Pa", where=self.source)
        key = "equilibrium_modulus" if self.long_term else "instantaneous_modulus"
        times = [terms.relaxation_times for terms in (self.shear, self.bulk) if terms is not None]
        return Material(
            shear if self.shear is None else self.shear.series(**{key: shear}),
            bulk if self.bulk is None or math.isinf(bulk) else self.bulk.series(**{key: bulk}),
            density=self.density,
            name=self.name,
            source=self.source or None,
            shift=self.shift,
            window=_span(np.unique(np.concatenate(times))) if times else None,
        )


class _Entry(NamedTuple):
    """Number of a deck and the line where it stands."""

    value: float
    line: int


_Constants = dict[str, _Entry]
_PROPERTIES = {"EX": "youngs_modulus", "PRXY": "poisson_ratio", "NUXY": "poisson_ratio", "DENS": "density"}
_SHIFTS = {"WLF", "TN"}  # of ANSYS
_KINDS: dict[str, Deformation] = {"SHEA": "shear", "": "shear", "BULK": "bulk"}


def read_ansys(source: str, text: str, name: str | None = None) -> ViscoelasticDeck:
    """Return the material of an ANSYS deck: TB,PRON in shear and bulk, MP,EX, PRXY or NUXY (instantaneous), and DENS.

    TB,SHIFT of the kinds WLF and TN are read too, with the offset of TOFFST.
    """
    tables: dict[tuple[str, str], tuple[_Entry, dict[int, _Entry]]] = {}
    constants: dict[str, _Constants] = {}
    active: tuple[str, str] | None = None
    offset = 0.0
    for line in split_lines(text):
        cells = [cell.strip() for cell in line.text.split("!")[0].split(",")]
        command, cells = cells[0].upper(), [*cells[1:], *[""] * 6]
        if command == "TB":
            active = None
            if cells[0].upper().startswith("PRON"):
                kind = _KINDS.get(cells[4].upper()[:4])
                if kind is None:
                    raise FileError(source, line.number, f"TB,PRON for {cells[4]!r}: must be SHEAR or BULK")
                active = cells[1] or "1", kind
                if active in tables:
                    raise FileError(source, line.number, f"second TB,PRON table in {kind}: must be one")
                if cells[2] and _number(source, line, cells[2]) != 1:
                    raise FileError(source, line.number, f"{cells[2]} temperatures: must be 1")
                count = _number(source, line, cells[3]) if cells[3] else 0
                tables[active] = _Entry(count, line.number), {}
            elif cells[0].upper() == "SHIFT" and cells[4].upper() in _SHIFTS:
                active = cells[1] or "1", cells[4].upper()
                tables[active] = _Entry(0, line.number), {}
        elif command == "TOFFST":
            offset = _number(source, line, cells[0])
        elif command == "TBDATA" and active is not None:
            place = _number(source, line, cells[0]) if cells[0] else 1.0
            if place < 1.0 or place % 1.0:
                raise FileError(source, line.number, f"TBDATA from place {cells[0]}: must be a whole number >= 1")
            first = int(place)
            for i, cell in enumerate(cells[1:]):
                if cell:
                    tables[active][1][first + i] = _Entry(_number(source, line, cell), line.number)
        elif command == "MP" and cells[0].upper() in _PROPERTIES:
            entry = _Entry(_number(source, line, cells[2]), line.number)
            constants.setdefault(cells[1] or "1", {})[_PROPERTIES[cells[0].upper()]] = entry
    # Without a name, elastic materials beside a viscoelastic one are its surroundings.
    relaxing = [material for material, kind in tables if kind not in _SHIFTS]
    chosen = _chosen(source, relaxing if relaxing and name is None else [*relaxing, *constants], name)
    chosen_tables = {kind: table for (material, kind), table in tables.items() if material == chosen}
    terms = {
        kind: _ansys_terms(source, kind, *chosen_tables[kind]) for kind in _KINDS.values() if kind in chosen_tables
    }
    deck = _deck(source, chosen, terms, constants.get(chosen, {}), long_term=False)
    for kind in _SHIFTS & chosen_tables.keys():
        values = [entry.value for _, entry in sorted(chosen_tables[kind][1].items())]
        deck = replace(deck, shift=_shift(source, kind, chosen_tables[kind][0].line, values, -offset))
    return deck


def _ansys_terms(source: str, kind: Deformation, count: _Entry, data: dict[int, _Entry]) -> PronyTerms:
    needed = 2 * (int(count.value) or len(data) // 2)
    if len(data) != needed or sorted(data) != list(range(1, needed + 1)):
        last = max((entry.line for entry in data.values()), default=count.line)
        should = f"must be {needed}, numbered from 1, for {needed // 2} terms (line {count.line})"
        raise FileError(source, last, f"{len(data)} constants in TBDATA: {should}")
    entries = [data[i] for i in range(1, needed + 1)]
    return _terms(source, kind, entries[0::2], entries[1::2])


def _shift(source: str, kind: str, line: int, values: Sequence[float], zero: float) -> WLF | Arrhenius:
    """Return the shift of a kind of the two codes; `zero` is the temperature of absolute zero in the deck."""
    needed = 3 if kind == "WLF" else 2
    if len(values) != needed:
        raise FileError(source, line, f"{len(values)} constants of the shift: must be {needed}")
    try:
        if kind == "WLF":
            return WLF(values[0] - zero, values[1], values[2])
        return Arrhenius(values[0] - zero, values[1] * (GAS_CONSTANT if kind == "TN" else 1.0))
    except InputError as error:
        raise FileError(source, line, str(error)) from None


class _Block(NamedTuple):
    """Keyword of an Abaqus deck, its options, its line, and the lines of data below."""

    keyword: str
    options: dict[str, str]
    line: int
    data: list[Line]


def read_abaqus(source: str, text: str, name: str | None = None) -> ViscoelasticDeck:
    """Return the material of an Abaqus deck: *VISCOELASTIC, TIME=PRONY (g_i, k_i, tau_i), *ELASTIC and *DENSITY.

    E and nu are those of long times unless *ELASTIC has the option MODULI=INSTANTANEOUS. *TRS is read too, with the
    ABSOLUTE ZERO of *PHYSICAL CONSTANTS, unless a user subroutine defines it.
    """
    materials: dict[str, list[_Block]] = {"": []}
    current, zero, shift = "", 0.0, None
    for block in _abaqus_blocks(source, text):
        if block.keyword == "*PHYSICAL CONSTANTS" and "ABSOLUTE ZERO" in block.options:
            zero = _number(source, Line(block.line, ""), block.options["ABSOLUTE ZERO"])
        if block.keyword == "*MATERIAL":
            current = block.options.get("NAME", "").strip('"')
            if any(earlier.keyword == "*MATERIAL" for earlier in materials.setdefault(current, [])):
                what = f"of the name {current}" if current else "without a name"
                raise FileError(source, block.line, f"second *MATERIAL {what}: must be one")
        materials[current].append(block)
    named = [key for key in materials if key]
    chosen = _chosen(source, named, name) if named or name is not None else ""
    constants: _Constants = {}
    terms: dict[str, PronyTerms] = {}
    long_term = True
    for keyword, options, line, data in materials[chosen]:
        if keyword in ("*ELASTIC", "*DENSITY"):
            if len(data) != 1:
                raise FileError(source, line, f"{len(data)} lines of data: must be 1, for one temperature")
            names = ("youngs_modulus", "poisson_ratio") if keyword == "*ELASTIC" else ("density",)
            constants |= zip(names, _row(source, data[0], len(names)), strict=True)
            if keyword == "*ELASTIC":
                long_term = not options.get("MODULI", "").upper().startswith("INST")
        elif keyword == "*VISCOELASTIC":
            if options.get("TIME", "").upper() != "PRONY":
                raise FileError(source, line, "*VISCOELASTIC: must have TIME=PRONY")
            if not data:
                raise FileError(source, line, "*VISCOELASTIC is followed by no terms")
            g, k, tau = zip(*(_row(source, row, 3) for row in data), strict=True)
            both: dict[Deformation, tuple[_Entry, ...]] = {"shear": g, "bulk": k}
            terms = {x: _terms(source, x, shares, tau) for x, shares in both.items() if any(e.value for e in shares)}
        elif keyword == "*TRS" and (kind := options.get("DEFINITION", "WLF").upper()) in ("WLF", "ARRHENIUS"):
            row = _row(source, data[0], 3 if kind == "WLF" else 2) if data else []
            shift = _shift(source, kind, line, [entry.value for entry in row], zero)
    deck = _deck(source, chosen or None, terms, constants, long_term=long_term)
    return deck if shift is None else replace(deck, shift=shift)


def _abaqus_blocks(source: str, text: str) -> list[_Block]:
    blocks: list[_Block] = []
    goes_on = False
    for line in split_lines(text):
        if line.text.startswith("**"):
            continue
        if line.text.startswith("*") or goes_on:
            cells = [cell.strip() for cell in line.text.split(",")]
            if not goes_on:
                blocks.append(_Block(re.sub(r"\s+", " ", cells.pop(0)).upper(), {}, line.number, []))
            for cell in filter(None, cells):
                key, _, value = cell.partition("=")
                blocks[-1].options[key.strip().upper()] = value.strip()
            goes_on = line.text.endswith(",")
        elif blocks:
            blocks[-1].data.append(line)
        else:
            raise FileError(source, line.number, f"{line.text!r}: must stand below a keyword")
    return blocks


def _row(source: str, line: Line, count: int) -> list[_Entry]:
    cells = [cell.strip() for cell in line.text.rstrip(",").split(",")]
    if len(cells) < count:
        raise FileError(source, line.number, f"{len(cells)} values: must be {count}")
    return [_Entry(_number(source, line, cell) if cell else 0.0, line.number) for cell in cells[:count]]


def _number(source: str, line: Line, cell: str) -> float:
    try:
        # Fortran's exponent, which decks may have.
        value = float(cell.replace("D", "E").replace("d", "e"))
    except ValueError:
        raise FileError(source, line.number, f"{cell!r}: must be a number") from None
    if not math.isfinite(value):
        raise FileError(source, line.number, f"{cell!r}: must be finite")
    return value


def _chosen(source: str, names: list[str], name: str | None) -> str:
    """Return the name of the only material, or of the chosen one."""
    choices = list(dict.fromkeys(names))
    if name is None and len(choices) == 1:
        return choices[0]
    matches = [choice for choice in choices if name is not None and choice.upper() == name.strip().upper()]
    if not matches:
        what = f"has {len(choices)} materials" if name is None else f"has no material {name!r}"
        advice = f"choose one by its name, {' or '.join(choices)}" if choices else "its material has no name"
        raise FileError(source, 0, f"{what}: {advice}")
    return matches[0]


def _terms(source: str, kind: Deformation, moduli: Sequence[_Entry], times: Sequence[_Entry]) -> PronyTerms:
    for modulus, time in zip(moduli, times, strict=True):
        if modulus.value < 0:
            raise FileError(source, modulus.line, f"relative modulus in {kind} = {modulus.value:g}: must be >= 0")
        if time.value <= 0:
            raise FileError(source, time.line, f"relaxation time in {kind} = {time.value:g}: must be > 0")
    shares = np.array([entry.value for entry in moduli])
    if (beyond := beyond_one(shares)) is not None:
        message = f"relative moduli in {kind} add up to {shares.sum():.6g}: must be at most 1"
        raise FileError(source, moduli[beyond].line, message)
    return PronyTerms(np.array([entry.value for entry in times]), shares, True, kind, source=source)


def _deck(
    source: str, name: str | None, terms: dict[str, PronyTerms], constants: _Constants, *, long_term: bool
) -> ViscoelasticDeck:
    for key, (value, line) in constants.items():
        try:
            _ = tension_factor(value) if key == "poisson_ratio" else check_single(key, value)
        except InputError as error:
            raise FileError(source, line, str(error)) from None
    numbers = {key: entry.value for key, entry in constants.items()}
    modulus, ratio, density = map(numbers.get, ("youngs_modulus", "poisson_ratio", "density"))
    return ViscoelasticDeck(terms.get("shear"), terms.get("bulk"), modulus, ratio, long_term, density, name, source)


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
    if not several or not all(isinstance(item, Material) for item in several):
        raise InputTypeError("material", material, "must be a Material or several (of a fractional model: within)")
    for place, item in enumerate(several):
        single_material(f"material[{place}]" if len(several) > 1 else "material", item)
    lines = [line for number, item in enumerate(several, 1) for line in code(_Card.of(item, number))]
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
        for name, part in series.items():
            if part.parallel_viscosity > 0:
                rule = "must be 0: the cards have branches but no dashpot in parallel; give it a short relaxation time"
                raise InputError(f"{name}.parallel_viscosity", part.parallel_viscosity, rule, "Pa s")
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
        relaxes = any(part is not None and not part.is_elastic for part in (self.shear, self.bulk))
        return self.material.shift if relaxes and isinstance(self.material.shift, WLF | Arrhenius) else None

    def constants(self, moduli: Callable[[PronySeries], float]) -> tuple[float, float]:
        """Return Young's modulus [Pa] and Poisson ratio [-] of instantaneous or equilibrium moduli."""
        shear = moduli(self.shear)
        ratio = poisson_ratio(shear, math.inf if self.bulk is None else moduli(self.bulk))
        if ratio <= -1.0:
            raise InputError("poisson_ratio", ratio, "must be > -1, as the cards hold Young's modulus")
        return shear * tension_factor(ratio), ratio

    def remarks(self, which: str) -> Iterator[str]:
        """Return lines of comment; `which` are the elastic constants."""
        glass, rest = (f"G = {modulus:.6g} Pa" for modulus in (_glass(self.shear), self.shear.equilibrium_modulus))
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
        material = self.material
        if self.shift is not None:
            yield f"The relaxation times hold at {material.temperature:g} K. The model must have temperatures, in K."
            if self.shift.temperature_range is not None:
                yield "The shift holds from {:g} to {:g} K.".format(*self.shift.temperature_range)
        elif material.temperature is not None:
            yield f"The moduli hold at {material.temperature:g} K; {lost_shift(material) or 'no shift is written'}."
        if material.window is not None:
            yield f"They hold for times from {material.window[0]:.4g} to {material.window[1]:.4g} s."
        for text in (material.name, material.source, material.assumptions):
            if text:
                yield " ".join(text.split())[:200]


def lost_shift(material: Material) -> str:
    """Return words on a shift that the codes do not have; empty if the material has none of that kind."""
    if isinstance(material.shift, WLF | Arrhenius | None):
        return ""
    return f"the cards cannot hold a {type(material.shift).__name__}, and so hold at {material.temperature:g} K alone"


def _glass(series: PronySeries) -> float:
    return series.instantaneous_modulus


def _abaqus(card: _Card) -> Iterator[str]:
    for name, series in (("shear", card.shear), ("bulk", card.bulk)):
        if series is not None and series.equilibrium_modulus < _SMALLEST_EQUILIBRIUM * _glass(series):
            rule = f"must be >= {_SMALLEST_EQUILIBRIUM:g} of the instantaneous modulus: a card with MODULI=LONG TERM "
            raise InputError(f"{name}.equilibrium_modulus", series.equilibrium_modulus, f"{rule}holds no liquid", "Pa")
    yield f"*MATERIAL, NAME={card.name}"
    yield from (f"** {line}" for line in card.remarks("those of long times (MODULI=LONG TERM)"))
    if card.material.density is not None:
        yield from ("*DENSITY", f"{_text(card.material.density)},")
    young, ratio = card.constants(lambda series: series.equilibrium_modulus)
    yield from ("*ELASTIC, MODULI=LONG TERM", f"{_text(young)}, {_text(ratio)}")
    ((_, (times,), shear, bulk),) = on_common_times(card.shear, card.bulk or PronySeries(1.0))
    if times.size:
        yield from ("*VISCOELASTIC, TIME=PRONY", "** g_i [-], k_i [-], tau_i [s]")
    # Short times first.
    shares = (
        shear.weights[0] / _glass(card.shear),
        bulk.weights[0] / (1.0 if card.bulk is None else _glass(card.bulk)),
        times,
    )
    yield from (", ".join(map(_text, row)) for row in zip(*(column[::-1] for column in shares), strict=True))
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
    """Return the shortest text of a number that is read back exactly, or as many of its digits as Abaqus takes."""
    texts = (repr(float(value)), *(f"{value:.{digits}g}" for digits in (16, 15, 14)))
    short = (re.sub(r"e([+-])0*", r"E\1", text).replace("E+", "E") for text in texts)
    return next(text for text in short if len(text) <= _WIDEST)


CARDS: dict[str, Callable[[_Card], Iterator[str]]] = {".inp": _abaqus, ".txt": _ansys, ".mac": _ansys}
"""Writer of the cards by the end of the name of their file."""
