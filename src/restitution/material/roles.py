"""Roles of the columns of a table: which quantity each holds, from its name and unit."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.material.conversion import Deformation
from restitution.material.sheet import PLAIN_UNITS, FileError, Sheet, unit

Array = NDArray[np.float64]

# Data that scatter by half of their size cannot be fitted.
_NOISE = 1.5


class Role(NamedTuple):
    """Quantity of a column."""

    name: str
    dimensions: tuple[str, ...]  # admissible dimensions of its unit
    assumed: str = ""  # unit that is assumed where none is given
    least: float | None = 0.0  # bound of its values, None for none
    open_bound: bool = True  # whether the bound itself is excluded


TIME = Role("time", ("time",), "s", open_bound=False)
FREQUENCY = Role("frequency", ("frequency", "angular frequency"), "Hz")
ANGULAR_FREQUENCY = Role("angular frequency", ("angular frequency", "frequency"), "rad/s")
MODULUS = Role("relaxation modulus", ("modulus",), "Pa")
STORAGE = Role("storage modulus", ("modulus",), "Pa")
LOSS = Role("loss modulus", ("modulus",), "Pa", open_bound=False)
COMPLEX = Role("magnitude of the complex modulus", ("modulus",), "Pa")
TANGENT = Role("loss tangent", ("number",), open_bound=False)
RELAXATION_TIME = Role("relaxation time", ("time",), "s")
BRANCH = Role("branch modulus", ("modulus",), "Pa", open_bound=False)
SHARE = Role("relative modulus", ("number",), open_bound=False)
TEMPERATURE = Role("temperature", ("temperature",), "K")
LOG_SHIFT = Role("log10 of the shift factor", ("number",), least=None)
SHIFT = Role("shift factor", ("number",))
SWEEP = Role("number of the sweep", ("number",), least=None)

_SPELLINGS: dict[Role, str] = {
    TIME: "t time zeit",
    FREQUENCY: "f freq frequency frequenz",
    ANGULAR_FREQUENCY: "w omega ω angfreq angularfrequency angfrequency kreisfrequenz",
    MODULUS: "e g er gr erelax grelax e(t) g(t) modulus relaxationmodulus tensilemodulus shearmodulus "
    "tensilerelaxationmodulus shearrelaxationmodulus youngsmodulus relaxationsmodul",
    STORAGE: "e' g' ep gp estor gstor estorage gstorage eprime gprime storage storagemodulus "
    "tensilestoragemodulus shearstoragemodulus speichermodul",
    LOSS: "e'' g'' epp gpp eloss gloss edoubleprime gdoubleprime loss lossmodulus "
    "tensilelossmodulus shearlossmodulus verlustmodul",
    COMPLEX: "e* g* |e*| |g*| complexmodulus complexshearmodulus dynamicmodulus",
    TANGENT: "tand tandel tandelta tan(delta) tan(δ) tanδ losstangent lossfactor dampingfactor verlustfaktor",
    RELAXATION_TIME: "tau taui tauk τ reltime relaxationtime relaxationtimes",
    BRANCH: "branchmodulus branchmoduli ei ek",
    SHARE: "relmod relativemodulus relativemoduli alpha alphai gi ki",
    TEMPERATURE: "temp temperature temperatur",
    LOG_SHIFT: "logat log10at loga log10a logshift",
    SHIFT: "at a shiftfactor",
    SWEEP: "set",
}
_ROLES = {spelling: role for role, text in _SPELLINGS.items() for spelling in text.split()}
_TENSION = re.compile(r"^(\|?e\b|\|?e[^a-z]|epp?$|estor|eloss|erelax|eprime|edouble|er$|ei$|ek$|tensile|young)")
_SHEAR = re.compile(r"^(\|?g\b|\|?g[^a-z]|gpp?$|gstor|gloss|grelax|gprime|gdouble|gr$|gi$|shear)")
_MEASURED = (FREQUENCY, ANGULAR_FREQUENCY, STORAGE, LOSS, COMPLEX, TANGENT, TIME, MODULUS)
_QUOTES = str.maketrans(dict.fromkeys("’‘′´`", "'") | dict.fromkeys('”″"', "''"))


class Column(NamedTuple):
    """Column of a table, in SI (angular frequencies in rad/s)."""

    role: Role
    label: str  # its name in the file
    values: Array
    note: str  # the unit that was assumed; empty where the file gives one


class Table(NamedTuple):
    """Sheet of known quantities; its columns are read on demand."""

    sheet: Sheet
    roles: list[Role | None]

    @classmethod
    def of(cls, sheet: Sheet) -> Table:
        """Table of a sheet.

        Instruments leave cells empty, and measure negative losses of glasses; such rows of theirs are left out.
        """
        roles = [role_of(label) for label in sheet.labels]
        if RELAXATION_TIME in roles:
            roles = [BRANCH if role is MODULUS else role for role in roles]
        for i, role in enumerate(roles):
            given = unit(sheet.units[i] or "")
            if role is SHARE and given is not None and given.dimension == "modulus":
                roles[i] = BRANCH
        if sheet.title:
            known = [
                (cells, role)
                for cells, role in zip(sheet.cells, roles, strict=True)
                if role is not None and role in _MEASURED
            ]
            good = [all(_measured(cells[row], role) for cells, role in known) for row in range(len(sheet.lines))]
            if not all(good):
                first = f"the first is {sheet.place} {sheet.lines[good.index(False)]}"
                remark = f"{sheet.title}: {good.count(False)} rows without positive values are not used; {first}"
                sheet = sheet.part(np.flatnonzero(good))._replace(remarks=(*sheet.remarks, remark))
        return cls(sheet, roles)

    @property
    def temperature(self) -> Column | None:
        """Temperatures of the rows, None where no column holds them."""
        if self.roles.count(TEMPERATURE) != 1:
            return None
        given = self.sheet.units[self.roles.index(TEMPERATURE)]
        # The letter T may also name a torque.
        if given is not None and getattr(unit(given), "dimension", "") != "temperature":
            return None
        return self._column(TEMPERATURE)

    def part(self, rows: NDArray[np.intp]) -> Table:
        """Table of some of its rows."""
        return Table(self.sheet.part(rows), self.roles)

    def columns(self, *choices: tuple[Role, ...]) -> list[Column]:
        """Column of the first known role of each choice; empty if a choice has none."""
        found = [next((role for role in choice if role in self.roles), None) for choice in choices]
        return [] if None in found else [self._column(role) for role in found if role is not None]

    def _column(self, role: Role) -> Column:
        if self.roles.count(role) > 1:
            raise self.error(f"two columns hold a {role.name}: must be one", self.sheet.header_line)
        index = self.roles.index(role)
        label, given = self.sheet.labels[index], self.sheet.units[index]
        scale = unit(role.assumed if given is None else given)
        if scale is None or scale.dimension not in role.dimensions:
            usual = (name for name, one in PLAIN_UNITS.items() if one.dimension in role.dimensions and name)
            wanted = f"must be a unit of {role.dimensions[0]}, such as {', '.join(usual)}"
            raise self.error(f"column {label!r}: unit {given!r}: {wanted}", self.sheet.unit_line)
        factor = scale.factor * (2.0 * math.pi if scale.dimension == "frequency" else 1.0)
        with np.errstate(over="ignore"):
            values = (self.sheet.numbers(index) + scale.offset) * factor
        good = np.isfinite(values)
        if role.least is not None:
            good &= values > role.least if role.open_bound else values >= role.least
        if not good.all():
            row = int(np.argmin(good))
            bound = "" if role.least is None else f" and {'>' if role.open_bound else '>='} {role.least:g}"
            assumed = f" {role.assumed}, as no unit is given" if given is None and role is TEMPERATURE else ""
            raise self.error(f"{label} = {self.sheet.cells[index][row]}: must be finite{bound}{assumed}", row=row)
        note = f"unit of {label} not given: {role.assumed} assumed" if given is None and role.assumed else ""
        return Column(role, label, values, note)

    def about(self, *used: Column) -> tuple[Deformation | None, str, tuple[str, ...]]:
        """Deformation that the columns state, source, and remarks: assumed units, columns that are not used."""
        labels = [column.label for column in used]
        plain = [_plain(label).lower() for label in labels]
        tension, shear = (any(map(pattern.match, plain)) for pattern in (_TENSION, _SHEAR))
        if tension and shear:
            raise self.error("one modulus is in tension, the other in shear: must be of one kind")
        notes = [*self.sheet.remarks, *(column.note for column in used if column.note)]
        left = [label for label in self.sheet.labels if label and label not in labels]
        # An instrument writes dozens of them.
        if left and not self.sheet.title:
            notes.append(f"columns not used: {', '.join(left)}")
        return "tension" if tension else "shear" if shear else None, self.sheet.source, tuple(notes)

    def order(self, column: Column) -> slice:
        """Order in which a column ascends; the file may list it in descending order."""
        steps = np.diff(column.values)
        if steps.size and (steps < 0).all():
            return slice(None, None, -1)
        if not (steps > 0).all():
            row = int(np.argmin(steps > 0)) + 1
            what = "repeats" if steps[row - 1] == 0 else "is less than"
            wanted = "must be strictly ascending or descending"
            raise self.error(f"{column.label} {what} that of line {self.sheet.lines[row - 1]}: {wanted}", row=row)
        return slice(None)

    def refuse_growth(self, column: Column, values: Array, order: slice, wanted: str) -> None:
        """Refuse values that grow by more than noise; of a storage modulus, its inverse."""
        values, moduli, lines = values[order], column.values[order], self.sheet.lines[order]
        beyond = np.flatnonzero(values > _NOISE * np.minimum.accumulate(values))
        if beyond.size:
            last = int(beyond[0])
            first = int(np.argmin(values[:last]))
            message = f"{column.label} is {moduli[last]:.4g} Pa, and {moduli[first]:.4g} Pa in line {lines[first]}"
            raise self.error(f"{message}: must {wanted}, apart from noise", lines[last])

    def error(self, message: str, line: int = 0, *, row: int | None = None) -> FileError:
        """Error for a line of the file, or for a row of the table."""
        return self.sheet.error(message, line if row is None else self.sheet.lines[row])


def _measured(cell: str, role: Role) -> bool:
    """Whether a cell holds an admissible value, or something that is to be refused."""
    try:
        value = float(cell)
    except ValueError:
        return bool(cell)
    return not (value <= 0.0 if role.open_bound else value < 0.0)


def is_unit(text: str) -> bool:
    """Whether a text is the name of a unit of these tables."""
    return unit(text) is not None


def is_name(text: str) -> bool:
    """Whether a text is the name of a known quantity."""
    return role_of(text) is not None


def _plain(label: str) -> str:
    return re.sub(r"[\s_.]", "", label[:100]).translate(_QUOTES)


def role_of(label: str) -> Role | None:
    """Role of a column of this name, None where it is unknown."""
    # Only the capital T is a temperature, and the small one a time.
    plain = _plain(label)
    return TEMPERATURE if plain == "T" else _ROLES.get(plain.lower())
