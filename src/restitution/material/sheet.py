"""Tables in text files of instruments and spreadsheets: named columns with units, and what each of them holds."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution import units
from restitution.checks import Array
from restitution.errors import ABSENT, InputError
from restitution.material.conversion import Deformation
from restitution.units import unit, usual_units

_Test = Callable[[str], bool]

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
        self._arguments = source, line, message, place

    def within(self, section: str = "", *, where: str = "") -> InputError:
        """Return the same error for the field that names the file."""
        return InputError(section, ABSENT, self.rule, where=where or self.where)

    def moved(self, source: str, place: str) -> FileError:
        """Return the same error for another name of the file, and another word for its lines."""
        return FileError(source, self._arguments[1], self._arguments[2], place)

    def __reduce__(self) -> tuple[type[FileError], tuple[str, int, str, str]]:
        return FileError, self._arguments


class Line(NamedTuple):
    """Line of a file and its number, from 1."""

    number: int
    text: str


@dataclass(frozen=True)
class Sheet:
    """Table of named columns, whose cells are read on demand."""

    source: str  # name of the file
    labels: list[str]  # names of the columns, without their units
    units: list[str | None]  # units of the columns as written, None for none
    header_line: int  # number of the line of the names
    unit_line: int  # number of the line of the units, which may be that of the names
    rows: list[Line]
    mark: str | None  # what separates the cells; None for blanks
    comments: Sequence[Line] = ()  # lines that begin with #, without it
    title: str = ""  # name that an instrument gave to its step or interval
    temperature: float | None = None  # temperature [K] that stands outside the columns
    remarks: tuple[str, ...] = ()
    place: str = "line"  # what the numbers of lines count
    scattered: bool = False  # whether the rows are in any order, such as those of a master curve

    def line(self, row: int) -> int:
        """Return the number of the line of a row."""
        return self.rows[row].number

    def numbers(self, column: int) -> Array:
        """Return numbers of a column; other cells are refused."""
        values = self.values(column)
        if values is None:
            self.require(np.array([*map(is_number, self.cells(column))]), column, "must be a number")
            # Python's numbers may have underscores, and digits of other scripts.
            return np.array([*map(_number, self.cells(column))])
        return values

    def values(self, column: int) -> Array | None:
        """Return numbers of a column; None if a cell holds none."""
        if column not in self._numbers:
            self._numbers.update(self._parsed([column]))
        return self._numbers.get(column)

    @cached_property
    def _numbers(self) -> dict[int, Array]:
        """Columns that hold numbers in the first row, which are read at once."""
        if not self.rows:
            return dict.fromkeys(range(len(self.labels)), np.empty(0))
        return self._parsed([i for i, cell in enumerate(_cells(self.rows[0].text, self.mark)) if is_number(cell)])

    def _parsed(self, columns: list[int]) -> dict[int, Array]:
        """Return numbers of columns; none if a cell holds something else."""
        texts = [row.text for row in self.rows]
        if self.mark != ",":
            texts = [text.replace(",", ".") for text in texts]
        try:
            numbers = np.loadtxt(texts, delimiter=self.mark, comments=None, quotechar='"', usecols=columns, ndmin=2)
        except ValueError:
            return {}
        # A quotation mark that stands alone joins lines.
        return dict(zip(columns, numbers.T, strict=True)) if len(numbers) == len(self.rows) else {}

    def cells(self, column: int) -> list[str]:
        """Return texts of a column."""
        return [row[column] for row in self._cells]

    @cached_property
    def _cells(self) -> list[list[str]]:
        return [_cells(row.text, self.mark) for row in self.rows]

    def require(self, good: NDArray[np.bool_], column: int, rule: str, name: str = "") -> None:
        """Refuse the first cell of a column that is not good, with its line; `name` is that of its quantity."""
        if not good.all():
            row = int(np.argmin(good))
            cell = _cells(self.rows[row].text, self.mark)[column]
            shown = cell if len(cell) <= 40 else f"{cell[:39]}…"
            shown = shown if is_number(cell) else repr(shown)
            raise self.error(f"{name or self.labels[column]} = {shown}: {rule}", self.line(row))

    def error(self, message: str, line: int = 0) -> FileError:
        """Return the error for one of its lines."""
        return FileError(self.source, line, message, self.place)

    def part(self, rows: Sequence[int] | NDArray[np.intp]) -> Sheet:
        """Return the sheet of some of its rows."""
        return replace(self, rows=[self.rows[row] for row in rows])


def read_bytes(path: Path) -> bytes:
    """Return the content of a file, which is refused by its size before all of it is read."""
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
    """Return whether the content is that of a workbook of Excel."""
    return content.startswith(_ARCHIVES)


def decoded(source: str, content: bytes) -> str:
    """Return the text of a content in UTF-8, UTF-16 or Latin-1; `source` is the name of its file in messages."""
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
    """Return lines that are not blank, with their numbers, without characters at both ends (blanks by default)."""
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
    """Return the table of named columns in some lines; `source` is the name of their file in messages.

    The names are in the first line with two names for which `is_name` holds, or else in the first line, or in the last
    comment (#) above the numbers. A unit is in brackets behind the name, or after a slash or an underscore if
    `is_unit` holds, or in a second line of units. The `mark` separates the cells; without it the line of the names
    shows which one does.
    """
    comments: list[Line] = []
    body: list[Line] = []
    for line in lines:
        if len(line.text) > _LONGEST_LINE:
            raise FileError(source, line.number, f"has {len(line.text)} characters: must have at most {_LONGEST_LINE}")
        (comments if line.text.startswith("#") else body).append(line)
    comments = [Line(n, text.lstrip("#").strip()) for n, text in comments]
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
    width = _count(header.text, separator)
    is_ragged = any(_count(line.text, separator) != width for line in body)
    if is_ragged:
        # Tabs at both ends separate empty cells only where all lines have them.
        header, *body = (Line(n, line.strip()) for n, line in (header, *body))
    names = [_name_and_unit(cell, is_unit, is_name) for cell in _cells(header.text, separator)]
    labels, units, unit_line = [name for name, _ in names], [unit for _, unit in names], header.number
    below = _cells(body[0].text, separator) if body else ["0"]
    if not any(map(is_number, below)):
        unit_line, body = body[0].number, body[1:]
        # The last columns of instruments may have no units, such as the number of a step.
        below += [""] * ((len(labels) - len(below)) * bool(mark))
        if len(below) != len(labels):
            raise FileError(source, unit_line, f"{len(below)} units for {len(labels)} columns")
        units = [cell.strip("[]() ") or None for cell in below]
    if not body:
        raise FileError(source, header.number, "is followed by no numbers")
    for n, line in body if is_ragged else ():
        if (count := _count(line, separator)) != len(labels):
            raise FileError(source, n, f"{count} values: must be {len(labels)}, one for each column")
    return Sheet(source, labels, units, header.number, unit_line, body, separator, comments)


def _header(body: list[Line], is_unit: _Test, is_name: _Test) -> int:
    """Return the index of the first line with two known names, else of the first line."""
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
    return [cell.strip().strip('"').strip() for cell in parts]


def _count(line: str, separator: str | None) -> int:
    return len(_cells(line, separator)) if separator is None else line.count(separator) + 1


def _number(cell: str) -> float:
    """Return the number in a cell, which may have a decimal comma."""
    return float(cell.replace(",", "."))


def is_number(cell: str) -> bool:
    """Return whether a cell holds a number, perhaps nan or inf."""
    try:
        _number(cell)
    except ValueError:
        return False
    return True


def _name_and_unit(cell: str, is_unit: _Test, is_name: _Test) -> tuple[str, str | None]:
    # A name may itself end like a unit, such as E(t), tan(delta) and tan_d.
    whole = is_name(cell)
    if cell.endswith((")", "]")) and not cell.lower().endswith("(t)") and not whole:
        opening = max(cell.rfind("("), cell.rfind("["))
        if opening >= 0:
            return cell[:opening].rstrip(" /"), cell[opening + 1 : -1].strip()
    # Quantity over unit, as in ISO 80000: E'/MPa, but not velocity_m/s.
    quotient, _, tail = map(str.strip, cell.partition("/"))
    if tail and not whole and is_unit(tail) and ("_" not in quotient or is_name(quotient)):
        return quotient, tail
    stem, _, tail = cell.rpartition("_")
    if stem and tail and (not whole or is_name(stem)) and is_unit(tail):
        return stem, tail
    return cell, None


class Role(Enum):
    """Quantity of a column: words, dimensions of its unit, unit assumed if none is given, and names in files.

    In the names ? stands for e or g, and "tensile" or "shear" may come before.
    """

    TIME = "time", (units.TIME,), "s", "t time zeit"
    FREQUENCY = "frequency", (units.FREQUENCY, units.ANGULAR_FREQUENCY), "Hz", "f freq frequency frequenz"
    ANGULAR_FREQUENCY = "angular frequency", (units.ANGULAR_FREQUENCY, units.FREQUENCY), "rad/s", (
        "w omega ω angfreq angularfrequency angfrequency kreisfrequenz"
    )  # fmt: skip
    MODULUS = "relaxation modulus", (units.MODULUS,), "Pa", (
        "? ?r ?relax ?(t) modulus relaxationmodulus youngsmodulus relaxationsmodul"
    )  # fmt: skip
    STORAGE = "storage modulus", (units.MODULUS,), "Pa", (
        "?' ?p ?stor ?storage ?prime storage storagemodulus speichermodul"
    )  # fmt: skip
    LOSS = "loss modulus", (units.MODULUS,), "Pa", "?'' ?pp ?loss ?doubleprime loss lossmodulus verlustmodul"
    COMPLEX = "magnitude of the complex modulus", (units.MODULUS,), "Pa", (
        "?* |?*| complexmodulus complexshearmodulus dynamicmodulus"
    )  # fmt: skip
    TANGENT = "loss tangent", (units.NUMBER,), "", (
        "tand tandel tandelta tan(delta) tan(δ) tanδ losstangent lossfactor dampingfactor verlustfaktor"
    )  # fmt: skip
    ANGLE = "loss angle", (units.ANGLE,), "deg", "delta δ phase phaseangle lossangle phasenwinkel verlustwinkel"
    COMPLIANCE = "creep compliance", (units.COMPLIANCE,), "1/Pa", (
        "j j(t) d(t) compliance creepcompliance nachgiebigkeit kriechnachgiebigkeit"
    )  # fmt: skip
    RELAXATION_TIME = "relaxation time", (units.TIME,), "s", "tau taui tauk τ reltime relaxationtime relaxationtimes"
    BRANCH = "branch modulus", (units.MODULUS,), "Pa", "branchmodulus branchmoduli ei ek"
    SHARE = "relative modulus", (units.NUMBER,), "", "relmod relativemodulus relativemoduli alpha alphai gi ki"
    TEMPERATURE = "temperature", (units.TEMPERATURE,), "K", "temp temperature temperatur"
    LOG_SHIFT = "log10 of the shift factor", (units.NUMBER,), "", "logat log10at loga log10a logshift"
    SHIFT = "shift factor", (units.NUMBER,), "", "at a shiftfactor"
    SWEEP = "number of the sweep", (units.NUMBER,), "", "set"

    def __init__(self, words: str, dimensions: tuple[units.Dimension, ...], assumed: str, spellings: str) -> None:
        self.words, self.dimensions, self.assumed, self.spellings = words, dimensions, assumed, spellings.split()

    @property
    def bound(self) -> str:
        """Bound of the values: "", "> 0" or ">= 0"."""
        if self in (Role.LOG_SHIFT, Role.SWEEP):
            return ""
        of_zero = Role.TIME, Role.LOSS, Role.TANGENT, Role.ANGLE, Role.BRANCH, Role.SHARE
        return ">= 0" if self in of_zero else "> 0"

    def admits(self, values: Array) -> NDArray[np.bool_]:
        """Return whether values are within the bound."""
        return (values > 0.0) | (values == 0.0) & (self.bound != "> 0") | (self.bound == "")


_ROLES = {name.replace("?", letter): role for role in Role for name in role.spellings for letter in "eg"}
_TENSION = re.compile(r"^(\|?e\b|\|?e[^a-z]|epp?$|estor|eloss|erelax|eprime|edouble|er$|ei$|ek$|tensile|young|d\(t\))")
_SHEAR = re.compile(r"^(\|?g\b|\|?g[^a-z]|gpp?$|gstor|gloss|grelax|gprime|gdouble|gr$|gi$|shear|j$|j\(t\))")
_MEASURED = (
    Role.FREQUENCY, Role.ANGULAR_FREQUENCY, Role.STORAGE, Role.LOSS, Role.COMPLEX, Role.TANGENT, Role.ANGLE,
    Role.TIME, Role.MODULUS, Role.COMPLIANCE,
)  # fmt: skip
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
        """Return the table of a sheet.

        Instruments leave cells empty, and measure negative losses of glasses; such rows of theirs are left out.
        """
        roles = [role_of(label) for label in sheet.labels]
        if Role.RELAXATION_TIME in roles:
            roles = [Role.BRANCH if role is Role.MODULUS else role for role in roles]
        for i, role in enumerate(roles):
            column_unit = unit(sheet.units[i] or "")
            if role is Role.SHARE and column_unit is not None and column_unit.dimension == units.MODULUS:
                roles[i] = Role.BRANCH
        if sheet.title:
            measured = [(i, role) for i, role in enumerate(roles) if role is not None and role in _MEASURED]
            kept = [_measured(sheet, i, role) for i, role in measured]
            good = np.all(kept, axis=0) if kept else np.ones(len(sheet.rows), dtype=bool)
            if not good.all():
                first = f"the first is {sheet.place} {sheet.line(int(np.argmin(good)))}"
                remark = f"{sheet.title}: {np.sum(~good)} rows without positive values are not used; {first}"
                sheet = replace(sheet.part(np.flatnonzero(good)), remarks=(*sheet.remarks, remark))
        return cls(sheet, roles)

    @property
    def temperature(self) -> Column | None:
        """Temperatures of the rows, None where no column holds them."""
        if self.roles.count(Role.TEMPERATURE) != 1:
            return None
        column_unit = self.sheet.units[self.roles.index(Role.TEMPERATURE)]
        # The letter T may also name a torque.
        if column_unit is not None and getattr(unit(column_unit), "dimension", None) != units.TEMPERATURE:
            return None
        return self._column(Role.TEMPERATURE)

    def part(self, rows: NDArray[np.intp]) -> Table:
        """Return the table of some of its rows."""
        return Table(self.sheet.part(rows), self.roles)

    def columns(self, *choices: tuple[Role, ...]) -> list[Column]:
        """Return the column of the first known role of each choice; empty if a choice has none."""
        present = [next((role for role in choice if role in self.roles), None) for choice in choices]
        return [] if None in present else [self._column(role) for role in present if role is not None]

    def _column(self, role: Role) -> Column:
        if self.roles.count(role) > 1:
            raise self.error(f"two columns hold a {role.words}: must be one", self.sheet.header_line)
        index = self.roles.index(role)
        label, column_unit = self.sheet.labels[index], self.sheet.units[index]
        scale = unit(role.assumed if column_unit is None else column_unit)
        if scale is None or scale.dimension not in role.dimensions:
            usual = ", ".join(usual_units(*role.dimensions))
            rule = f"must be a unit of {role.dimensions[0].name}, such as {usual}"
            raise self.error(f"column {label!r}: unit {column_unit!r}: {rule}", self.sheet.unit_line)
        with np.errstate(over="ignore"):
            values = scale.si(self.sheet.numbers(index))
            if scale.dimension == units.FREQUENCY:
                values = 2.0 * math.pi * values
        bound = f" and {role.bound}" if role.bound else ""
        assumed = f" {role.assumed}, as no unit is given" if column_unit is None and role is Role.TEMPERATURE else ""
        self.sheet.require(np.isfinite(values) & role.admits(values), index, f"must be finite{bound}{assumed}")
        note = f"unit of {label} not given: {role.assumed} assumed" if column_unit is None and role.assumed else ""
        return Column(role, label, values, note)

    def about(self, *used: Column) -> tuple[Deformation | None, str, tuple[str, ...]]:
        """Return the deformation that the columns state, the source, and remarks: assumed units, unused columns."""
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
        """Return the order in which a column ascends; the file may list it in descending order."""
        steps = np.diff(column.values)
        if steps.size and (steps < 0).all():
            return slice(None, None, -1)
        if not (steps > 0).all():
            row = int(np.argmin(steps > 0)) + 1
            what = "repeats" if steps[row - 1] == 0 else "is less than"
            rule = "must be strictly ascending or descending"
            raise self.error(f"{column.label} {what} that of line {self.sheet.line(row - 1)}: {rule}", row=row)
        return slice(None)

    def refuse_growth(self, column: Column, values: Array, order: slice, rule: str) -> None:
        """Refuse values that grow by more than noise; of a storage modulus or a compliance, its inverse."""
        values, moduli, rows = values[order], column.values[order], self.sheet.rows[order]
        beyond = np.flatnonzero(values > _NOISE * np.minimum.accumulate(values))
        if beyond.size:
            last = int(beyond[0])
            first = int(np.argmin(values[:last]))
            si = column.role.dimensions[0].unit
            message = (
                f"{column.label} is {moduli[last]:.4g} {si}, and {moduli[first]:.4g} {si} in line {rows[first].number}"
            )
            raise self.error(f"{message}: must {rule}, apart from noise", rows[last].number)

    def error(self, message: str, line: int = 0, *, row: int | None = None) -> FileError:
        """Return the error for a line of the file, or for a row of the table."""
        return self.sheet.error(message, line if row is None else self.sheet.line(row))


def _measured(sheet: Sheet, column: int, role: Role) -> NDArray[np.bool_]:
    """Return whether cells hold admissible values, or something that is to be refused."""
    values = sheet.values(column)
    if values is None:
        # Words are refused as they are; empty cells are not.
        cells = sheet.cells(column)
        values = np.array([_number(cell) if is_number(cell) else math.nan if cell else -1.0 for cell in cells])
    return role.admits(values) | np.isnan(values)


def _plain(label: str) -> str:
    return re.sub(r"[\s_.]", "", label[:100]).translate(_QUOTES)


def role_of(label: str) -> Role | None:
    """Return the role of a column of this name, None where it is unknown."""
    plain = _plain(label)
    # Only the capital T is a temperature, and the small one a time.
    if plain == "T":
        return Role.TEMPERATURE
    name = plain.lower()
    return _ROLES.get(name) or _ROLES.get(name.removeprefix("tensile").removeprefix("shear"))
