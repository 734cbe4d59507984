"""Viscoelastic materials in the input decks of ANSYS (TB,PRON) and Abaqus (*VISCOELASTIC, TIME=PRONY)."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from restitution.checks import positive
from restitution.errors import InputError
from restitution.material.conversion import Deformation, bulk_factor, tension_factor
from restitution.material.measurement import PronyTerms, beyond_one, span
from restitution.material.sheet import FileError, Line, split_lines
from restitution.material.viscoelastic import Material

_Terms = PronyTerms | None


@dataclass(frozen=True, eq=False)
class ViscoelasticDeck:
    """Material of a solver deck: Prony terms relative to the instantaneous moduli, and elastic constants.

    Attributes
    ----------
    shear, bulk
        Relative terms; None where the deck has none, which means elastic.
    youngs_modulus, poisson_ratio
        E [Pa] and nu [-], None where the deck lacks them. Decks carry no units; SI is assumed.
    long_term
        Whether E and nu are those of long times (and not instantaneous).
    density
        [kg/m3], None where the deck lacks it.
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

    def material(self, *, youngs_modulus: float | None = None, poisson_ratio: float | None = None) -> Material:
        r"""Material in shear and bulk, with the elastic constants of the deck unless given here.

        Parameters
        ----------
        youngs_modulus
            E > 0 [Pa].
        poisson_ratio
            nu in (-1, 0.5].

        Raises
        ------
        InputError
            If an elastic constant is missing, or long-time constants are given and the terms add up to one.

        Examples
        --------
        >>> text = "*ELASTIC, MODULI=INSTANTANEOUS\n 9, 0.5\n*VISCOELASTIC, TIME=PRONY\n 0.5, 0, 2\n"
        >>> read_abaqus("x.inp", text).material().shear
        PronySeries(1.5, [1.5], [2.0])
        """
        modulus = self.youngs_modulus if youngs_modulus is None else youngs_modulus
        ratio = self.poisson_ratio if poisson_ratio is None else poisson_ratio
        if modulus is None or ratio is None:
            name = "youngs_modulus" if modulus is None else "poisson_ratio"
            raise InputError(name, wanted="must be given, as the deck lacks it", where=self.source)
        shear = float(positive("youngs_modulus", modulus, "Pa")) / tension_factor(ratio)
        bulk = shear * bulk_factor(ratio)
        key = "equilibrium_modulus" if self.long_term else "instantaneous_modulus"
        return Material(
            shear if self.shear is None else self.shear.series(**{key: shear}),
            bulk if self.bulk is None or math.isinf(bulk) else self.bulk.series(**{key: bulk}),
            density=self.density,
            name=self.name,
            source=self.source or None,
            window=self.window,
        )

    @property
    def window(self) -> tuple[float, float] | None:
        """Shortest and longest relaxation time [s] of all terms, None for fewer than two."""
        parts = [one.relaxation_times for one in (self.shear, self.bulk) if one is not None]
        return span(np.unique(np.concatenate(parts))) if parts else None


class _Entry(NamedTuple):
    """Number of a deck and the line where it stands."""

    value: float
    line: int


class _Elastic(NamedTuple):
    """Elastic constants with their lines."""

    youngs_modulus: _Entry | None = None
    poisson_ratio: _Entry | None = None
    density: _Entry | None = None


def read_ansys(source: str, text: str, name: str | None = None) -> ViscoelasticDeck:
    """Material of an ANSYS deck with TB,PRON tables of relative moduli and times, for shear and bulk.

    MP,EX, MP,PRXY (or NUXY) and MP,DENS are read too; ANSYS means instantaneous constants. The deck must have one
    temperature; `name` chooses one of several materials by its number. Errors name the line.
    """
    tables: dict[tuple[str, str], tuple[_Entry, dict[int, _Entry]]] = {}
    constants: dict[tuple[str, str], _Entry] = {}
    active: tuple[str, str] | None = None
    for line in split_lines(text):
        cells = [cell.strip() for cell in line.text.split("!")[0].split(",")]
        command, cells = cells[0].upper(), [*cells[1:], *[""] * 6]
        if command == "TB":
            active = None
            if cells[0].upper().startswith("PRON"):
                kind = cells[4].upper()[:4] or "SHEA"
                if kind not in ("SHEA", "BULK"):
                    raise FileError(source, line.number, f"TB,PRON for {cells[4]!r}: must be SHEAR or BULK")
                active = cells[1] or "1", kind
                if active in tables:
                    raise FileError(source, line.number, f"second TB,PRON table for {kind}: must be one")
                if cells[2] and _number(source, line, cells[2]) != 1:
                    raise FileError(source, line.number, f"{cells[2]} temperatures: must be 1")
                count = _number(source, line, cells[3]) if cells[3] else 0
                tables[active] = _Entry(count, line.number), {}
        elif command == "TBDATA" and active is not None:
            first = int(_number(source, line, cells[0])) if cells[0] else 1
            for i, cell in enumerate(cells[1:]):
                if cell:
                    tables[active][1][first + i] = _Entry(_number(source, line, cell), line.number)
        elif command == "MP" and cells[0].upper() in ("EX", "PRXY", "NUXY", "DENS"):
            key = cells[1] or "1", cells[0].upper().replace("NUXY", "PRXY")
            constants[key] = _Entry(_number(source, line, cells[2]), line.number)
    chosen = _chosen(source, [material for material, _ in tables], name)
    own = {kind: table for (material, kind), table in tables.items() if material == chosen}
    terms = {kind: _ansys_terms(source, kind, *table) for kind, table in own.items()}
    elastic = _Elastic(*(constants.get((chosen, key)) for key in ("EX", "PRXY", "DENS")))
    return _deck(source, chosen, terms.get("SHEA"), terms.get("BULK"), elastic, long_term=False)


def _ansys_terms(source: str, kind: str, count: _Entry, data: dict[int, _Entry]) -> PronyTerms:
    wanted = 2 * (int(count.value) or len(data) // 2)
    if len(data) != wanted or max(data) > wanted:
        last = max((entry.line for entry in data.values()), default=count.line)
        should = f"must be {wanted}, for {wanted // 2} terms (line {count.line})"
        raise FileError(source, last, f"{len(data)} constants in TBDATA: {should}")
    entries = [data[i] for i in range(1, wanted + 1)]
    return _terms(source, "shear" if kind == "SHEA" else "bulk", entries[0::2], entries[1::2])


def read_abaqus(source: str, text: str, name: str | None = None) -> ViscoelasticDeck:
    """Material of an Abaqus deck with *VISCOELASTIC, TIME=PRONY (g_i, k_i, tau_i) and *ELASTIC (E, nu).

    The constants are those of long times unless *ELASTIC has the option MODULI=INSTANTANEOUS. *DENSITY is read too.
    The deck must have one temperature; `name` chooses one of several materials. Errors name the line.
    """
    materials: dict[str, list[_Block]] = {"": []}
    current = ""
    for block in _abaqus_blocks(source, text):
        if block.keyword == "*MATERIAL":
            current = block.options.get("NAME", "").strip('"')
            if any(earlier.keyword == "*MATERIAL" for earlier in materials.setdefault(current, [])):
                what = f"of the name {current}" if current else "without a name"
                raise FileError(source, block.line, f"second *MATERIAL {what}: must be one")
        materials[current].append(block)
    named = [key for key in materials if key]
    chosen = _chosen(source, named, name) if named or name is not None else ""
    elastic, long_term = _Elastic(), True
    shear = bulk = None
    for keyword, options, line, data in materials[chosen]:
        if keyword == "*ELASTIC":
            long_term = not options.get("MODULI", "").upper().startswith("INST")
            row = _abaqus_row(source, data, line, 2)
            elastic = elastic._replace(youngs_modulus=row[0], poisson_ratio=row[1])
        elif keyword == "*DENSITY":
            elastic = elastic._replace(density=_abaqus_row(source, data, line, 1)[0])
        elif keyword == "*VISCOELASTIC":
            if options.get("TIME", "").upper() != "PRONY":
                raise FileError(source, line, "*VISCOELASTIC: must have TIME=PRONY")
            if not data:
                raise FileError(source, line, "*VISCOELASTIC is followed by no terms")
            g, k, tau = zip(*(_row(source, row, 3) for row in data), strict=True)
            shear = _terms(source, "shear", g, tau) if any(entry.value for entry in g) else None
            bulk = _terms(source, "bulk", k, tau) if any(entry.value for entry in k) else None
    return _deck(source, chosen or None, shear, bulk, elastic, long_term=long_term)


def _chosen(source: str, names: list[str], name: str | None) -> str:
    """Name of the only material, or of the chosen one."""
    known = list(dict.fromkeys(names))
    if name is None and len(known) == 1:
        return known[0]
    found = [one for one in known if name is not None and one.upper() == name.strip().upper()]
    if not found:
        what = f"has {len(known)} materials" if name is None else f"has no material {name!r}"
        advice = f"choose one by its name, {' or '.join(known)}" if known else "its material has no name"
        raise FileError(source, 0, f"{what}: {advice}")
    return found[0]


def _deck(
    source: str, name: str | None, shear: _Terms, bulk: _Terms, elastic: _Elastic, *, long_term: bool
) -> ViscoelasticDeck:
    modulus, ratio, density = elastic
    for label, entry in (("Young's modulus", modulus), ("density", density)):
        if entry is not None and entry.value <= 0:
            raise FileError(source, entry.line, f"{label} = {entry.value:g}: must be > 0")
    if ratio is not None and not -1.0 < ratio.value <= 0.5:
        raise FileError(source, ratio.line, f"Poisson ratio = {ratio.value:g}: must be in (-1, 0.5]")
    numbers = [None if entry is None else entry.value for entry in elastic]
    return ViscoelasticDeck(shear, bulk, numbers[0], numbers[1], long_term, numbers[2], name, source)


class _Block(NamedTuple):
    """Keyword of an Abaqus deck, its options, its line, and the lines of data below."""

    keyword: str
    options: dict[str, str]
    line: int
    data: list[Line]


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


def _abaqus_row(source: str, data: list[Line], line: int, count: int) -> list[_Entry]:
    if len(data) != 1:
        raise FileError(source, line, f"{len(data)} lines of data: must be 1, for one temperature")
    return _row(source, data[0], count)


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


def _terms(source: str, kind: Deformation, moduli: Sequence[_Entry], times: Sequence[_Entry]) -> PronyTerms:
    for modulus, time in zip(moduli, times, strict=True):
        if modulus.value < 0:
            message = f"relative modulus in {kind} = {modulus.value:g}: must be >= 0"
            raise FileError(source, modulus.line, message)
        if time.value <= 0:
            raise FileError(source, time.line, f"relaxation time in {kind} = {time.value:g}: must be > 0")
    shares = np.array([entry.value for entry in moduli])
    if (beyond := beyond_one(shares)) is not None:
        message = f"relative moduli in {kind} add up to {shares.sum():.6g}: must be at most 1"
        raise FileError(source, moduli[beyond].line, message)
    return PronyTerms(np.array([entry.value for entry in times]), shares, True, kind, source=source)
