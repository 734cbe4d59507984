"""Reader of files of viscoelastic materials; the content decides the kind."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.errors import InputError, InputTypeError
from restitution.material.conversion import Deformation
from restitution.material.deck import PronyTerms, ViscoelasticDeck, beyond_one, read_abaqus, read_ansys
from restitution.material.fit import DynamicTable, RelaxationTable
from restitution.material.sheet import PLAIN_UNITS, FileError, Sheet, read_sheet, read_text, unit
from restitution.material.shift import ShiftTable

Array = NDArray[np.float64]
MaterialFile = RelaxationTable | DynamicTable | PronyTerms | ShiftTable | ViscoelasticDeck

# Data that scatter by half of their size cannot be fitted.
_NOISE = 1.5
_LONGEST_COMMENT = 500
_END_MODULUS = re.compile(r"\b[EG]_?(0|inf|e|eq)\s*=\s*([-+.\deE]+)\s*([A-Za-z/0-9]*)", re.IGNORECASE)


def read_material(path: str | Path, *, name: str | None = None) -> MaterialFile:
    r"""Read a file of a viscoelastic material; the content decides the kind.

    Tables: relaxation (time, modulus), DMA (frequency, storage modulus, loss modulus or loss tangent), shift factors
    (temperature, log aT or aT), Prony terms (relaxation time, modulus or relative modulus). Decks: ANSYS with
    ``TB,PRON``, Abaqus with ``*VISCOELASTIC, TIME=PRONY``.

    Parameters
    ----------
    path
        The file: text in UTF-8, UTF-16 or Latin-1.
    name
        Which material of a deck that has several: its NAME in Abaqus, its number in ANSYS.

    Returns
    -------
    RelaxationTable, DynamicTable, PronyTerms, ShiftTable or ViscoelasticDeck
        In SI.

    Raises
    ------
    InputError
        If the file is missing or malformed, or has several materials and none is chosen; it names file and line.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder, "relaxation.csv")
    ...     _ = file.write_text("t,E\nms,MPa\n1,30\n10,20\n")
    ...     data = read_material(file)
    >>> data.time, data.modulus, data.deformation
    (array([0.001, 0.01 ]), array([30000000., 20000000.]), 'tension')
    """
    if not isinstance(path, str | Path):
        raise InputTypeError("path", path, "must be the name of a file")
    return parse(read_text(Path(path)), str(path), name=name)


def parse(text: str, source: str = "text", *, name: str | None = None) -> MaterialFile:
    """Read a text as `read_material` reads a file; `source` is its name in messages."""
    if "\0" in text:
        raise FileError(source, 0, "cannot be read: must be text")
    # Blanks but no ends of lines: these would cost quadratic time.
    if re.search(r"^[ \t]*TB[ \t]*,[ \t]*PRON", text, re.IGNORECASE | re.MULTILINE):
        return read_ansys(source, text, name)
    if re.search(r"^[ \t]*\*[ \t]*VISCOELASTIC", text, re.IGNORECASE | re.MULTILINE):
        return read_abaqus(source, text, name)
    if name is not None:
        raise FileError(source, 0, f"has no material {name!r}: is no deck of a solver, whose materials have names")
    table = _read_table(source, text)
    for kind in (_dynamic, _prony_terms, _relaxation, _shift_table):
        found = kind(table)
        if found is not None:
            return found
    message = f"columns {', '.join(filter(None, table.sheet.labels))[:200]}: must be time and relaxation modulus; "
    message += "frequency, storage and loss modulus; relaxation time and modulus; or temperature and shift factor"
    raise FileError(source, table.sheet.header_line, message)


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
    COMPLEX: "e* g* |e*| |g*| complexmodulus dynamicmodulus",
    TANGENT: "tand tandel tandelta tan(delta) tan(δ) tanδ losstangent lossfactor dampingfactor verlustfaktor",
    RELAXATION_TIME: "tau taui tauk τ reltime relaxationtime relaxationtimes",
    BRANCH: "branchmodulus branchmoduli ei ek",
    SHARE: "relmod relativemodulus relativemoduli alpha alphai gi ki",
    TEMPERATURE: "temp temperature temperatur",
    LOG_SHIFT: "logat log10at loga log10a logshift",
    SHIFT: "at a shiftfactor",
}
_ROLES = {spelling: role for role, text in _SPELLINGS.items() for spelling in text.split()}
_TENSION = re.compile(r"^(\|?e\b|\|?e[^a-z]|epp?$|estor|eloss|erelax|eprime|edouble|er$|ei$|ek$|tensile|young)")
_SHEAR = re.compile(r"^(\|?g\b|\|?g[^a-z]|gpp?$|gstor|gloss|grelax|gprime|gdouble|gr$|gi$|shear)")
_QUOTES = str.maketrans(dict.fromkeys("’‘′´`", "'") | dict.fromkeys('”″"', "''"))


class Column(NamedTuple):
    """Column of a table, in SI (angular frequencies in rad/s)."""

    role: Role
    label: str  # its name in the file
    values: Array
    note: str  # the unit that was assumed; empty where the file gives one


class Table(NamedTuple):
    """Sheet of known quantities; a column is read when it is asked for."""

    sheet: Sheet
    roles: list[Role | None]

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
            raise self.error(f"{label} = {self.sheet.cells[index][row]}: must be finite{bound}", row=row)
        note = f"unit of {label} not given: {role.assumed} assumed" if given is None and role.assumed else ""
        return Column(role, label, values, note)

    def about(self, *used: Column) -> tuple[Deformation | None, str, tuple[str, ...]]:
        """Deformation that the columns state, source, and remarks: assumed units, columns that are not used."""
        labels = [column.label for column in used]
        plain = [_plain(label).lower() for label in labels]
        tension, shear = (any(map(pattern.match, plain)) for pattern in (_TENSION, _SHEAR))
        if tension and shear:
            raise self.error("one modulus is in tension, the other in shear: must be of one kind")
        notes = [column.note for column in used if column.note]
        left = [label for label in self.sheet.labels if label and label not in labels]
        if left:
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
        return FileError(self.sheet.source, line if row is None else self.sheet.lines[row], message)


def _read_table(source: str, text: str) -> Table:
    sheet = read_sheet(source, text, lambda tail: unit(tail) is not None, lambda name: _role(name) is not None)
    roles = [_role(label) for label in sheet.labels]
    if RELAXATION_TIME in roles:
        roles = [BRANCH if role is MODULUS else role for role in roles]
    for i, role in enumerate(roles):
        given = unit(sheet.units[i] or "")
        if role is SHARE and given is not None and given.dimension == "modulus":
            roles[i] = BRANCH
    return Table(sheet, roles)


def _plain(label: str) -> str:
    return re.sub(r"[\s_.]", "", label[:100]).translate(_QUOTES)


def _role(label: str) -> Role | None:
    # Only the capital T is a temperature, and the small one a time.
    plain = _plain(label)
    return TEMPERATURE if plain == "T" else _ROLES.get(plain.lower())


def _dynamic(table: Table) -> DynamicTable | None:
    complex_first = STORAGE not in table.roles
    columns = table.columns(
        (ANGULAR_FREQUENCY, FREQUENCY), (STORAGE, COMPLEX), (TANGENT, LOSS) if complex_first else (LOSS, TANGENT)
    )
    if not columns:
        return None
    omega, first, second = columns
    order = table.order(omega)
    storage, loss = first.values, second.values
    # What overflows is refused below.
    with np.errstate(over="ignore", invalid="ignore"):
        if first.role is COMPLEX:
            # |E*| with the loss modulus or the loss tangent.
            share = loss / np.hypot(1.0, loss) if second.role is TANGENT else np.minimum(loss / storage, 1.0)
            loss = storage * share
            storage = storage * np.sqrt((1.0 - share) * (1.0 + share))
        elif second.role is TANGENT:
            loss = storage * loss
    good = np.isfinite(loss) & (storage > 0.0)
    if not good.all():
        wanted = f"{first.label}, {second.label}: must give a storage modulus > 0 and a finite loss modulus"
        raise table.error(wanted, row=int(np.argmin(good)))
    table.refuse_growth(first, 1.0 / np.maximum(storage, 1e-300), order, "rise over frequency")
    return DynamicTable(omega.values[order], storage[order], loss[order], *table.about(omega, first, second))


def _relaxation(table: Table) -> RelaxationTable | None:
    columns = table.columns((TIME,), (MODULUS,))
    if not columns:
        return None
    time, modulus = columns
    order = table.order(time)
    table.refuse_growth(modulus, modulus.values, order, "fall over time")
    return RelaxationTable(time.values[order], modulus.values[order], *table.about(time, modulus))


def _prony_terms(table: Table) -> PronyTerms | None:
    columns = table.columns((RELAXATION_TIME,), (BRANCH, SHARE))
    if not columns:
        return None
    times, terms = columns
    deformation, source, notes = table.about(times, terms)
    ends: dict[str, float] = {}
    place = 0
    for line in table.sheet.comments:
        if not (match := _END_MODULUS.search(line.text[:_LONGEST_COMMENT])):
            continue
        place, scale = line.number, unit(match[3] or "Pa")
        if scale is None or scale.dimension != "modulus":
            raise table.error(f"{match[0]!r}: must end in a unit of modulus, such as Pa, MPa", place)
        try:
            ends["high" if match[1] == "0" else "low"] = float(match[2]) * scale.factor
        except ValueError:
            raise table.error(f"{match[0]!r}: must hold a number", place) from None
        deformation = deformation or ("tension" if match[0][0] in "eE" else "shear")
    relative, moduli = terms.role is SHARE, terms.values
    if relative and (beyond := beyond_one(moduli)) is not None:
        wanted = f"the values of {terms.label} add up to {moduli.sum():.6g}: must be at most 1"
        raise table.error(wanted, row=beyond)
    found = PronyTerms(times.values, moduli, relative, deformation, ends.get("high"), ends.get("low"), source, notes)
    if ends:
        try:
            found.series()
        except InputError as error:
            raise table.error(str(error), place) from None
    return found


def _shift_table(table: Table) -> ShiftTable | None:
    columns = table.columns((TEMPERATURE,), (LOG_SHIFT, SHIFT))
    if not columns:
        return None
    temperature, shift = columns
    kelvin = temperature.values
    logs = shift.values if shift.role is LOG_SHIFT else np.log10(shift.values)
    if kelvin[0] > kelvin[-1]:
        kelvin, logs = kelvin[::-1], logs[::-1]
    try:
        return ShiftTable(kelvin, logs, notes=table.about(temperature, shift)[2])
    except InputError as error:
        raise table.error(str(error), row=0) from None
