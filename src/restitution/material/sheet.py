"""Tables in text files of instruments and spreadsheets: named columns with units, and what each of them holds."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.checks import Array
from restitution.errors import ABSENT, InputError
from restitution.material.conversion import Deformation
from restitution.units import PLAIN_UNITS, unit

_Test = Callable[[str], bool]

_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+([eE][+-]?\d+)?")
_BLANKS = re.compile(r"(?<=[\])])\s+|\s+(?![\[(\s])")
_ARCHIVES = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")
# The names of the columns must stand within this number of lines.
_HEADER_LINES = 300
# Longest file [byte] and line. A cell of a table takes about ten times its length in memory.
_LARGEST, _LONGEST_LINE = 20_000_000, 1_000_000
# Data that scatter by half of their size cannot be fitted.
_NOISE = 1.5


class FileError(InputError):
    """Malformed file, with its name and the number of the line."""

    def __init__(self, source: str, line: int, message: str, place: str = "line") -> None:
        super().__init__("", ABSENT, f"{place} {line}: {message}" if line else message, where=source)
        self._given = source, line, message, place

    def within(self, section: str = "", *, where: str = "") -> InputError:
        """Return the same error for the field that names the file."""
        return InputError(section, ABSENT, self.rule, where=where or self.where)

    def moved(self, source: str, place: str) -> FileError:
        """Return the same error for another name of the file, and another word for its lines."""
        return FileError(source, self._given[1], self._given[2], place)

    def __reduce__(self) -> tuple[type[FileError], tuple[str, int, str, str]]:
        return FileError, self._given


class Line(NamedTuple):
    """Line of a file and its number, from 1."""

    number: int
    text: str


class Sheet(NamedTuple):
    """Table of named columns."""

    source: str  # name of the file
    labels: list[str]  # names of the columns, without their units
    units: list[str | None]  # units of the columns as written, None for none
    header_line: int  # number of the line of the names
    unit_line: int  # number of the line of the units, which may be that of the names
    cells: list[list[str]]  # texts of each column
    lines: list[int]  # number of the line of each row
    comments: list[Line]  # lines that begin with #, without it
    title: str = ""  # name that an instrument gave to its step or interval
    temperature: float | None = None  # temperature [K] that stands outside the columns
    remarks: tuple[str, ...] = ()
    place: str = "line"  # what the numbers of lines count
    scattered: bool = False  # whether the rows are in any order, such as those of a master curve

    def numbers(self, column: int) -> Array:
        """Numbers of a column; other cells are refused."""
        cells = self.cells[column]
        try:
            return np.array(list(map(float, cells)))
        except ValueError:
            self.require(np.array(list(map(is_number, cells))), column, "must be a number")
            raise

    def require(self, good: NDArray[np.bool_], column: int, rule: str, name: str = "") -> None:
        """Refuse the first cell of a column that is not good, with its line; `name` is that of its quantity."""
        if not good.all():
            row = int(np.argmin(good))
            cell = self.cells[column][row]
            shown = cell if len(cell) <= 40 else f"{cell[:39]}…"
            shown = shown if is_number(cell) else repr(shown)
            raise self.error(f"{name or self.labels[column]} = {shown}: {rule}", self.lines[row])

    def error(self, message: str, line: int = 0) -> FileError:
        """Error for one of its lines."""
        return FileError(self.source, line, message, self.place)

    def part(self, rows: Sequence[int] | NDArray[np.intp]) -> Sheet:
        """Sheet of some of its rows."""
        cells = [[column[row] for row in rows] for column in self.cells]
        return self._replace(cells=cells, lines=[self.lines[row] for row in rows])


def read_bytes(path: Path) -> bytes:
    """Content of a file, which is refused by its size before all of it is read."""
    try:
        with path.open("rb") as file:
            content = file.read(_LARGEST + 1)
    except FileNotFoundError:
        raise FileError(str(path), 0, "no such file") from None
    except OSError as error:
        raise FileError(str(path), 0, f"cannot be read: {error.strerror}") from None
    if len(content) > _LARGEST:
        raise FileError(str(path), 0, f"is too long: must have at most {_LARGEST // 1_000_000} MB")
    return content


def is_workbook(content: bytes) -> bool:
    """Whether the content is that of a workbook of Excel."""
    return content.startswith(_ARCHIVES)


def decoded(source: str, content: bytes) -> str:
    """Text of a content in UTF-8, UTF-16 or Latin-1; `source` is the name of its file in messages."""
    if is_workbook(content):
        raise FileError(source, 0, "cannot be read: is a workbook; save its sheet as CSV")
    # Without a mark, the zeros of most letters are the second byte of each pair, or the first one.
    low, high = content[1::2].count(0), content[::2].count(0)
    encoding = "utf-8-sig"
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        encoding = "utf-16"
    elif max(low, high) > 0.4 * len(content) and min(low, high) < 0.1 * len(content):
        encoding = "utf-16-le" if low > high else "utf-16-be"
    for name in (encoding, "cp1252", "latin-1"):
        try:
            text = content.decode(name)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return text
    raise FileError(source, 0, "cannot be read: must be text in UTF-8, UTF-16 or Latin-1")


def split_lines(text: str, ends: str | None = None) -> list[Line]:
    """Lines that are not blank, with their numbers, without some characters at both ends (all blanks by default)."""
    lines = enumerate(text.splitlines(), 1)
    return [Line(i, line.strip(ends)) for i, line in lines if line and not line.isspace()]


def read_sheet(
    source: str,
    lines: Sequence[Line],
    *,
    is_unit: _Test = lambda text: unit(text) is not None,
    is_name: _Test = lambda text: role_of(text) is not None,
    mark: str = "",
) -> Sheet:
    """Table of named columns in some lines; `source` is the name of their file in messages.

    The names are in the first line with two names for which `is_name` holds, or else in the first line, or in the last
    comment (#) above the numbers. A unit is in brackets behind the name, or after an underscore if `is_unit` holds, or
    in a second line of units. The `mark` separates the cells; without it the line of the names shows which one does.
    """
    for n, line in lines:
        if len(line) > _LONGEST_LINE:
            raise FileError(source, n, f"has {len(line)} characters: must have at most {_LONGEST_LINE}")
    comments = [Line(n, line.lstrip("#").strip()) for n, line in lines if line.startswith("#")]
    body = [line for line in lines if not line.text.startswith("#")]
    if not body:
        raise FileError(source, 0, "holds no numbers" if lines else "is empty")
    start = _header(body, is_unit, is_name)
    header, separator = body[start], mark or _separator(body[start].text)
    if all(map(is_number, filter(None, _cells(header.text, separator)))):
        above = [line for line in comments if line.number < header.number]
        if not above:
            raise FileError(source, header.number, "the columns have no names: must begin with a line of names")
        header, body = above[-1], body[start:]
    else:
        body = body[start + 1 :]
    first, *rows = (_cells(line.text, separator) for line in (header, *body))
    if any(len(row) != len(first) for row in rows):
        # Tabs at both ends separate empty cells only where all lines have them.
        first, *rows = (_cells(line.text.strip(), separator) for line in (header, *body))
    names = [_name_and_unit(cell, is_unit, is_name) for cell in first]
    labels, units, unit_line = [name for name, _ in names], [unit for _, unit in names], header.number
    if rows and not any(map(is_number, rows[0])):
        unit_line, below = body[0].number, rows[0]
        # The last columns of instruments may have no units, such as the number of a step.
        below += [""] * ((len(labels) - len(below)) * bool(mark))
        if len(below) != len(labels):
            raise FileError(source, unit_line, f"{len(below)} units for {len(labels)} columns")
        units, body, rows = [cell.strip("[]() ") or None for cell in below], body[1:], rows[1:]
    if not rows:
        raise FileError(source, header.number, "is followed by no numbers")
    for line, row in zip(body, rows, strict=True):
        if len(row) != len(labels):
            raise FileError(source, line.number, f"{len(row)} values: must be {len(labels)}, one for each column")
    columns = list(map(list, zip(*rows, strict=True)))
    return Sheet(source, labels, units, header.number, unit_line, columns, [line.number for line in body], comments)


def _header(body: list[Line], is_unit: _Test, is_name: _Test) -> int:
    """Index of the first line with two known names, else of the first line."""
    for i, line in enumerate(body[:_HEADER_LINES]):
        cells = _cells(line.text, _separator(line.text))[:100]
        if sum(is_name(_name_and_unit(cell, is_unit, is_name)[0]) for cell in cells) >= 2:
            return i
    return 0


def _separator(line: str) -> str | None:
    return next((mark for mark in (";", "\t", ",") if mark in line), None)


def _cells(line: str, separator: str | None) -> list[str]:
    # Between a name and its unit in brackets a blank separates nothing.
    parts = _BLANKS.split(line.strip()) if separator is None else line.split(separator)
    cells = [cell.strip() for cell in parts]
    if '"' in line:
        cells = [cell.strip('"').strip() for cell in cells]
    if separator != "," and "," in line:
        cells = [cell.replace(",", ".") if _DECIMAL_COMMA.fullmatch(cell) else cell for cell in cells]
    return cells


def is_number(cell: str) -> bool:
    """Whether a cell holds a number, perhaps nan or inf."""
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _name_and_unit(cell: str, is_unit: _Test, is_name: _Test) -> tuple[str, str | None]:
    # A name may itself end like a unit, such as E(t), tan(delta) and tan_d.
    whole = is_name(cell)
    if cell.endswith((")", "]")) and not cell.lower().endswith("(t)") and not whole:
        opening = max(cell.rfind("("), cell.rfind("["))
        if opening >= 0:
            return cell[:opening].strip(), cell[opening + 1 : -1].strip()
    stem, _, tail = cell.rpartition("_")
    if stem and tail and (not whole or is_name(stem)) and is_unit(tail):
        return stem, tail
    return cell, None


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
            column_unit = unit(sheet.units[i] or "")
            if role is SHARE and column_unit is not None and column_unit.dimension == "modulus":
                roles[i] = BRANCH
        if sheet.title:
            kept = [
                (cells, role)
                for cells, role in zip(sheet.cells, roles, strict=True)
                if role is not None and role in _MEASURED
            ]
            good = [all(_measured(cells[row], role) for cells, role in kept) for row in range(len(sheet.lines))]
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
        column_unit = self.sheet.units[self.roles.index(TEMPERATURE)]
        # The letter T may also name a torque.
        if column_unit is not None and getattr(unit(column_unit), "dimension", "") != "temperature":
            return None
        return self._column(TEMPERATURE)

    def part(self, rows: NDArray[np.intp]) -> Table:
        """Table of some of its rows."""
        return Table(self.sheet.part(rows), self.roles)

    def columns(self, *choices: tuple[Role, ...]) -> list[Column]:
        """Column of the first known role of each choice; empty if a choice has none."""
        present = [next((role for role in choice if role in self.roles), None) for choice in choices]
        return [] if None in present else [self._column(role) for role in present if role is not None]

    def _column(self, role: Role) -> Column:
        if self.roles.count(role) > 1:
            raise self.error(f"two columns hold a {role.name}: must be one", self.sheet.header_line)
        index = self.roles.index(role)
        label, column_unit = self.sheet.labels[index], self.sheet.units[index]
        scale = unit(role.assumed if column_unit is None else column_unit)
        if scale is None or scale.dimension not in role.dimensions:
            usual = (name for name, one in PLAIN_UNITS.items() if one.dimension in role.dimensions and name)
            rule = f"must be a unit of {role.dimensions[0]}, such as {', '.join(usual)}"
            raise self.error(f"column {label!r}: unit {column_unit!r}: {rule}", self.sheet.unit_line)
        factor = scale.factor * (2.0 * math.pi if scale.dimension == "frequency" else 1.0)
        with np.errstate(over="ignore"):
            values = (self.sheet.numbers(index) + scale.offset) * factor
        good, bound = np.isfinite(values), ""
        if role.least is not None:
            good &= values > role.least if role.open_bound else values >= role.least
            bound = f" and {'>' if role.open_bound else '>='} {role.least:g}"
        assumed = f" {role.assumed}, as no unit is given" if column_unit is None and role is TEMPERATURE else ""
        self.sheet.require(good, index, f"must be finite{bound}{assumed}")
        note = f"unit of {label} not given: {role.assumed} assumed" if column_unit is None and role.assumed else ""
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
            rule = "must be strictly ascending or descending"
            raise self.error(f"{column.label} {what} that of line {self.sheet.lines[row - 1]}: {rule}", row=row)
        return slice(None)

    def refuse_growth(self, column: Column, values: Array, order: slice, rule: str) -> None:
        """Refuse values that grow by more than noise; of a storage modulus, its inverse."""
        values, moduli, lines = values[order], column.values[order], self.sheet.lines[order]
        beyond = np.flatnonzero(values > _NOISE * np.minimum.accumulate(values))
        if beyond.size:
            last = int(beyond[0])
            first = int(np.argmin(values[:last]))
            message = f"{column.label} is {moduli[last]:.4g} Pa, and {moduli[first]:.4g} Pa in line {lines[first]}"
            raise self.error(f"{message}: must {rule}, apart from noise", lines[last])

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


def _plain(label: str) -> str:
    return re.sub(r"[\s_.]", "", label[:100]).translate(_QUOTES)


def role_of(label: str) -> Role | None:
    """Role of a column of this name, None where it is unknown."""
    # Only the capital T is a temperature, and the small one a time.
    plain = _plain(label)
    return TEMPERATURE if plain == "T" else _ROLES.get(plain.lower())
