"""Viscoelastic materials in the input decks of ANSYS (TB,PRON) and Abaqus (*VISCOELASTIC, TIME=PRONY)."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np

from restitution.kernel.validation import positive
from restitution.material.measurement import PronyTerms
from restitution.material.table import FileError, Line, split_lines
from restitution.material.viscoelastic import Material


@dataclass(frozen=True, eq=False)
class ViscoelasticDeck:
    """Material of a solver deck: Prony terms relative to the instantaneous moduli, and elastic constants.

    Attributes
    ----------
    shear, bulk
        Relative terms; None where the deck has none, which means elastic.
    youngs_modulus, poisson_ratio
        E [Pa] and nu [-], None where the deck does not say. Decks carry no units: SI is taken.
    long_term
        Whether E and nu are those of long times (and not instantaneous).
    density
        [kg/m3], None where the deck does not say.
    name
        Name of the material in the deck.
    source
        Name of the file.
    """

    shear: PronyTerms | None
    bulk: PronyTerms | None
    youngs_modulus: float | None
    poisson_ratio: float | None
    long_term: bool
    density: float | None
    name: str | None
    source: str = ""

    def material(
        self, *, youngs_modulus: float | None = None, poisson_ratio: float | None = None
    ) -> Material:
        r"""Material in shear and bulk, with the elastic constants of the deck unless given here.

        Parameters
        ----------
        youngs_modulus
            E > 0 [Pa].
        poisson_ratio
            nu in (-1, 0.5].

        Raises
        ------
        ValueError
            If an elastic constant is missing, or the terms leave nothing at long times to scale.

        Examples
        --------
        >>> text = "*ELASTIC, MODULI=INSTANTANEOUS\n 9, 0.5\n*VISCOELASTIC, TIME=PRONY\n 0.5, 0, 2\n"
        >>> read_abaqus("x.inp", text).material().shear
        PronySeries(1.5, [1.5], [2.0])
        """
        modulus = self.youngs_modulus if youngs_modulus is None else youngs_modulus
        ratio = self.poisson_ratio if poisson_ratio is None else poisson_ratio
        if modulus is None or ratio is None:
            missing = "youngs_modulus" if modulus is None else "poisson_ratio"
            raise ValueError(f"{missing}: must be given, as {self.source or 'the deck'} does not say it")
        e = float(positive("youngs_modulus", modulus, "Pa"))
        if not -1.0 < ratio <= 0.5:
            raise ValueError(f"poisson_ratio = {ratio:g}: must be in (-1, 0.5]")
        shear, bulk = e / (2.0 * (1.0 + ratio)), math.inf if ratio == 0.5 else e / (3.0 * (1.0 - 2.0 * ratio))
        key = "equilibrium_modulus" if self.long_term else "instantaneous_modulus"
        return Material(
            shear if self.shear is None else self.shear.series(**{key: shear}),
            bulk if self.bulk is None or math.isinf(bulk) else self.bulk.series(**{key: bulk}),
            density=self.density,
            name=self.name,
            source=self.source or None,
        )


def read_ansys(source: str, text: str) -> ViscoelasticDeck:
    """Material of an ANSYS deck with TB,PRON tables of relative moduli and times, for shear and bulk.

    MP,EX, MP,PRXY (or NUXY) and MP,DENS are taken as well; ANSYS means instantaneous constants. One
    material and one temperature.

    Raises
    ------
    ValueError
        With the name of the source and the number of the line.
    """
    tables: dict[str, tuple[int, int, dict[int, float]]] = {}
    constants: dict[str, float] = {}
    names: set[str] = set()
    active: str | None = None
    for line in split_lines(text):
        cells = [cell.strip() for cell in line.text.split("!")[0].split(",")]
        command, cells = cells[0].upper(), [*cells[1:], *[""] * 6]
        if command == "TB":
            active = None
            if cells[0].upper().startswith("PRON"):
                kind = cells[4].upper()[:4] or "SHEA"
                if kind not in ("SHEA", "BULK"):
                    raise FileError(source, line.number, f"TB,PRON for {cells[4]!r}: must be SHEAR or BULK")
                if kind in tables:
                    raise FileError(source, line.number, f"second TB,PRON table for {kind}: must be one")
                if cells[2] and _number(source, line, cells[2]) != 1:
                    raise FileError(source, line.number, f"{cells[2]} temperatures: must be 1")
                names.add(cells[1])
                count = int(_number(source, line, cells[3])) if cells[3] else 0
                active = kind
                tables[kind] = (line.number, count, {})
        elif command == "TBDATA" and active is not None:
            first = int(_number(source, line, cells[0])) if cells[0] else 1
            for i, cell in enumerate(cells[1:]):
                if cell:
                    tables[active][2][first + i] = _number(source, line, cell)
        elif command == "MP" and cells[0].upper() in ("EX", "PRXY", "NUXY", "DENS"):
            constants[cells[0].upper().replace("NUXY", "PRXY")] = _number(source, line, cells[2])
    if not tables:
        raise FileError(source, 0, "has no TB,PRON table")
    if len(names) > 1:
        raise FileError(source, 0, f"has tables of {len(names)} materials: must be one")
    terms = {kind: _ansys_terms(source, kind, *table) for kind, table in tables.items()}
    return ViscoelasticDeck(
        terms.get("SHEA"),
        terms.get("BULK"),
        constants.get("EX"),
        constants.get("PRXY"),
        False,
        constants.get("DENS"),
        names.pop() or None,
        source,
    )


def _ansys_terms(source: str, kind: str, line: int, count: int, data: dict[int, float]) -> PronyTerms:
    count = count or len(data) // 2
    if sorted(data) != list(range(1, 2 * count + 1)):
        raise FileError(
            source, line, f"{len(data)} constants in TBDATA: must be {2 * count}, for {count} terms"
        )
    values = np.array([data[i] for i in range(1, 2 * count + 1)])
    return _terms(source, line, values[0::2], values[1::2], "shear" if kind == "SHEA" else "bulk")


def read_abaqus(source: str, text: str) -> ViscoelasticDeck:
    """Material of an Abaqus deck with *VISCOELASTIC, TIME=PRONY (g_i, k_i, tau_i) and *ELASTIC (E, nu).

    The constants are those of long times unless *ELASTIC says MODULI=INSTANTANEOUS. *DENSITY is taken as
    well. One material and one temperature.

    Raises
    ------
    ValueError
        With the name of the source and the number of the line.
    """
    blocks = _abaqus_blocks(source, text)
    if len([None for keyword, _, _, _ in blocks if keyword == "*MATERIAL"]) > 1:
        raise FileError(source, 0, "has more than one *MATERIAL: must be one")
    name: str | None = None
    rows: list[list[float]] = []
    constants: list[float | None] = [None, None]
    density: float | None = None
    long_term, start = True, 0
    for keyword, options, line, data in blocks:
        if keyword == "*MATERIAL":
            name = options.get("NAME")
        elif keyword == "*ELASTIC":
            long_term = not options.get("MODULI", "").upper().startswith("INST")
            constants = list(_abaqus_row(source, data, line, 2))
        elif keyword == "*DENSITY":
            density = _abaqus_row(source, data, line, 1)[0]
        elif keyword == "*VISCOELASTIC":
            if options.get("TIME", "").upper() != "PRONY":
                raise FileError(source, line, "*VISCOELASTIC: must have TIME=PRONY")
            start = line
            rows = [_row(source, row, 3) for row in data]
    if not rows:
        raise FileError(source, start, "*VISCOELASTIC is followed by no terms")
    shear, bulk, times = np.array(rows).T
    return ViscoelasticDeck(
        _terms(source, start, shear, times, "shear") if shear.any() else None,
        _terms(source, start, bulk, times, "bulk") if bulk.any() else None,
        constants[0],
        constants[1],
        long_term,
        density,
        name,
        source,
    )


def _abaqus_blocks(source: str, text: str) -> list[tuple[str, dict[str, str], int, list[Line]]]:
    """Keyword, options, line and data lines of each block."""
    blocks: list[tuple[str, dict[str, str], int, list[Line]]] = []
    goes_on = False
    for line in split_lines(text):
        if line.text.startswith("**"):
            continue
        if line.text.startswith("*") or goes_on:
            cells = [cell.strip() for cell in line.text.split(",")]
            if not goes_on:
                blocks.append((re.sub(r"\s+", " ", cells.pop(0)).upper(), {}, line.number, []))
            for cell in filter(None, cells):
                key, _, value = cell.partition("=")
                blocks[-1][1][key.strip().upper()] = value.strip()
            goes_on = line.text.endswith(",")
        elif blocks:
            blocks[-1][3].append(line)
        else:
            raise FileError(source, line.number, f"{line.text!r}: must stand below a keyword")
    return blocks


def _abaqus_row(source: str, data: list[Line], line: int, count: int) -> list[float]:
    if len(data) != 1:
        raise FileError(source, line, f"{len(data)} lines of data: must be 1, for one temperature")
    return _row(source, data[0], count)[:count]


def _row(source: str, line: Line, count: int) -> list[float]:
    cells = [cell.strip() for cell in line.text.rstrip(",").split(",")]
    if len(cells) < count:
        raise FileError(source, line.number, f"{len(cells)} values: must be {count}")
    return [_number(source, line, cell) if cell else 0.0 for cell in cells[:count]]


def _number(source: str, line: Line, cell: str) -> float:
    try:
        # Fortran's exponent, which decks may have.
        value = float(cell.replace("D", "E").replace("d", "e"))
    except ValueError:
        raise FileError(source, line.number, f"{cell!r}: must be a number") from None
    if not math.isfinite(value):
        raise FileError(source, line.number, f"{cell!r}: must be finite")
    return value


def _terms(source: str, line: int, moduli: np.ndarray, times: np.ndarray, kind: str) -> PronyTerms:
    if (moduli < 0).any() or (times <= 0).any():
        raise FileError(source, line, f"terms in {kind}: the moduli must be >= 0 and the times > 0")
    if moduli.sum() > 1.002:
        raise FileError(source, line, f"terms in {kind} add up to {moduli.sum():.6g}: must be at most 1")
    return PronyTerms(times, moduli, True, "shear" if kind == "shear" else "bulk", source=source)
