"""Tables in text files of instruments and spreadsheets: named columns with units."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.checks import unit_registry
from restitution.errors import ABSENT, InputError

_Test = Callable[[str], bool]

_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+([eE][+-]?\d+)?")
_BLANKS = re.compile(r"(?<=[\])])\s+|\s+(?![\[(\s])")
_ARCHIVES = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")
_MARKS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16", b"\xef\xbb\xbf": "utf-8-sig"}
# The names of the columns must stand within this number of lines.
_HEADER_LINES = 300
# Longest file [byte] and line. A cell of a table takes about ten times its length in memory.
_LARGEST, _LONGEST_LINE = 20_000_000, 1_000_000


class FileError(InputError):
    """Malformed file, with its name and the number of the line."""

    def __init__(self, source: str, line: int, message: str, place: str = "line") -> None:
        super().__init__("", ABSENT, f"{place} {line}: {message}" if line else message, where=source)
        self._given = source, line, message, place

    def within(self, section: str = "", *, where: str = "") -> InputError:
        """Return the same error for the field that names the file."""
        return InputError(section, ABSENT, self.wanted, where=where or self.where)

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

    def numbers(self, column: int) -> NDArray[np.float64]:
        """Numbers of a column; other cells are refused."""
        cells = self.cells[column]
        try:
            return np.array(list(map(float, cells)))
        except ValueError:
            row = next(i for i, cell in enumerate(cells) if not is_number(cell))
            shown = cells[row] if len(cells[row]) <= 40 else f"{cells[row][:39]}…"
            raise self.error(f"{shown!r}: must be a number", self.lines[row]) from None

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
        wanted = f"is too long: must have at most {_LARGEST // 1_000_000} MB"
        raise FileError(str(path), 0, wanted)
    return content


def is_workbook(content: bytes) -> bool:
    """Whether the content is that of a workbook of Excel."""
    return content.startswith(_ARCHIVES)


def read_text(path: Path) -> str:
    """Text of a file in UTF-8, UTF-16 or Latin-1."""
    content = read_bytes(path)
    if is_workbook(content):
        raise FileError(str(path), 0, "cannot be read: is a workbook; save its sheet as CSV")
    encoding = next((name for mark, name in _MARKS.items() if content.startswith(mark)), "utf-8")
    if encoding == "utf-8":
        # The zeros of most letters are the second byte of each pair, or the first one.
        low, high = content[1::2].count(0), content[::2].count(0)
        if max(low, high) > 0.4 * len(content) and min(low, high) < 0.1 * len(content):
            encoding = "utf-16-le" if low > high else "utf-16-be"
    for name in (encoding, "cp1252", "latin-1"):
        try:
            text = content.decode(name)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return text
    raise FileError(str(path), 0, "cannot be read: must be text in UTF-8, UTF-16 or Latin-1")


def split_lines(text: str, ends: str | None = None) -> list[Line]:
    """Lines that are not blank, with their numbers, without some characters at both ends (all blanks by default)."""
    lines = enumerate(text.splitlines(), 1)
    return [Line(i, line.strip(ends)) for i, line in lines if line and not line.isspace()]


def read_sheet(source: str, text: str, is_unit: _Test, is_name: _Test = lambda name: False) -> Sheet:
    """Table of named columns in a text; `source` is its name in messages.

    The names are in the first line with two names for which `is_name` holds, or else in the first line, or in the last
    comment (#) above the numbers. A unit is in brackets behind the name, or after an underscore if `is_unit` holds, or
    in a second line of units.
    """
    return read_lines(source, split_lines(text, " "), is_unit, is_name)


def read_lines(source: str, lines: Sequence[Line], is_unit: _Test, is_name: _Test, mark: str = "") -> Sheet:
    """Table of named columns in some lines, as `read_sheet` finds it; an instrument's has a known separator."""
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


class Unit(NamedTuple):
    """Unit of a column: SI value = factor * (value + offset)."""

    dimension: str
    factor: float
    offset: float = 0.0


# The common units, without the import of pint, which takes 0.4 s; pint would take C for coulomb.
PLAIN_UNITS = {
    **{name: Unit("time", factor) for name, factor in {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6}.items()},
    **{name: Unit("time", factor) for name, factor in {"sec": 1.0, "min": 60.0, "h": 3600.0}.items()},
    **{name: Unit("modulus", factor) for name, factor in {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9}.items()},
    **{name: Unit("frequency", factor) for name, factor in {"Hz": 1.0, "1/s": 1.0, "kHz": 1e3, "MHz": 1e6}.items()},
    **{name: Unit("temperature", 1.0, 273.15) for name in ("°C", "degC", "C", "ºC")},
    **{name: Unit("number", factor) for name, factor in {"-": 1.0, "1": 1.0, "": 1.0, "%": 0.01}.items()},
    "rad/s": Unit("angular frequency", 1.0),
    "K": Unit("temperature", 1.0),
}
_COMPOSED = re.compile(r"[A-Za-zµ]{1,12}(\^?[23])?([*/][A-Za-zµ]{1,12}(\^?[23])?){0,2}")


@cache
def unit(text: str) -> Unit | None:
    """Unit of a name; None if it is unknown or has another dimension than the quantities of the tables."""
    name = text.strip().replace("²", "2").replace("μ", "µ")
    if name in PLAIN_UNITS:
        return PLAIN_UNITS[name]
    if not _COMPOSED.fullmatch(name) or name in ("rpm", "deg"):
        return None
    registry = unit_registry()
    try:
        found = registry.Quantity(1.0, re.sub(r"(?<=[A-Za-z])([23])", r"^\1", name))
        for dimension, si in (("time", "s"), ("modulus", "Pa")):
            if found.check(registry.Unit(si).dimensionality):
                return Unit(dimension, float(found.to(si).magnitude))
    except Exception:  # errors of pint's parser have no common class
        return None
    return None
