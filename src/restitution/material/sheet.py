"""Tables in text files of instruments and spreadsheets: named columns with units."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.errors import ABSENT, InputError

_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+([eE][+-]?\d+)?")
_ARCHIVES = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")
_MARKS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16", b"\xef\xbb\xbf": "utf-8-sig"}
# Lines in which the names of the columns are searched for.
_HEADER_LINES = 300


class FileError(InputError):
    """Malformed file, with its name and the number of the line."""

    def __init__(self, source: str, line: int, message: str) -> None:
        super().__init__("", ABSENT, f"line {line}: {message}" if line else message, where=source)
        self.source, self.line, self.message = source, line, message

    def within(self, section: str = "", *, where: str = "") -> InputError:
        """Return the same error for the field that names the file."""
        return InputError(section, ABSENT, self.wanted, where=where or self.where)

    def __reduce__(self) -> tuple[type[FileError], tuple[str, int, str]]:
        return FileError, (self.source, self.line, self.message)


class Line(NamedTuple):
    """Line of a file and its number, from 1."""

    number: int
    text: str


class Sheet(NamedTuple):
    """Table of named columns.

    Attributes
    ----------
    source
        Name of the file.
    labels
        Names of the columns, without their units.
    units
        Units of the columns as written, None for none.
    header_line, unit_line
        Numbers of the lines of the names and of the units; equal where one line holds both.
    cells
        Texts of each column.
    lines
        Number of the line of each row.
    comments
        Lines that begin with #, without it.
    """

    source: str
    labels: list[str]
    units: list[str | None]
    header_line: int
    unit_line: int
    cells: list[list[str]]
    lines: list[int]
    comments: list[Line]

    def numbers(self, column: int) -> NDArray[np.float64]:
        """Return the numbers of a column.

        Raises
        ------
        FileError
            If a cell is not a number, with its line.
        """
        cells = self.cells[column]
        try:
            return np.array(list(map(float, cells)))
        except ValueError:
            row = next(i for i, cell in enumerate(cells) if not _is_number(cell))
            raise FileError(self.source, self.lines[row], f"{_short(cells[row])}: must be a number") from None


def read_text(path: Path) -> str:
    """Return the text of a file in UTF-8, UTF-16 or Latin-1.

    Raises
    ------
    FileError
        If the file is missing, cannot be read, or is no text.
    """
    try:
        content = path.read_bytes()
    except FileNotFoundError:
        raise FileError(str(path), 0, "no such file") from None
    except OSError as error:
        raise FileError(str(path), 0, f"cannot be read: {error.strerror}") from None
    if content.startswith(_ARCHIVES):
        raise FileError(str(path), 0, "cannot be read: is a workbook; save its sheet as CSV")
    encoding = next((name for mark, name in _MARKS.items() if content.startswith(mark)), None)
    if encoding is None and content[:1] != b"\0" and content[1::2].count(0) > 0.4 * len(content):
        encoding = "utf-16-le"
    for name in (encoding or "utf-8", "cp1252", "latin-1"):
        try:
            text = content.decode(name)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return text
    raise FileError(str(path), 0, "cannot be read: must be text in UTF-8, UTF-16 or Latin-1")


def split_lines(text: str) -> list[Line]:
    """Return the lines that are not blank, with their numbers."""
    lines = [Line(i, line.strip()) for i, line in enumerate(text.splitlines(), 1)]
    return [line for line in lines if line.text]


def read_sheet(
    source: str,
    text: str,
    is_unit: Callable[[str], bool],
    is_name: Callable[[str], bool] | None = None,
) -> Sheet:
    r"""Return the table of named columns in a text.

    The names stand in the first line, or in the first line with two known names, or in the last comment (#) above the
    numbers. A unit stands behind the name, in brackets or after an underscore, or in a second line of units. Columns are
    separated by commas, semicolons, tabs or blanks; all but the first allow decimal commas.

    Parameters
    ----------
    source
        Name of the text in messages.
    text
        The text.
    is_unit
        Whether the text after the last underscore of a name is a unit.
    is_name
        Whether a text is the name of a column. Lines above the first line with two names are then skipped.

    Raises
    ------
    FileError
        With the name of the source and the number of the line.

    Examples
    --------
    >>> sheet = read_sheet("x", "t [ms];E_MPa\n1;3,5\n", lambda tail: tail == "MPa")
    >>> sheet.labels, sheet.units, sheet.numbers(1)
    (['t', 'E'], ['ms', 'MPa'], array([3.5]))
    """
    lines = split_lines(text)
    comments = [Line(n, line.lstrip("#").strip()) for n, line in lines if line.startswith("#")]
    body = [line for line in lines if not line.text.startswith("#")] if comments else lines
    if not body:
        raise FileError(source, 0, "holds no numbers" if lines else "is empty")
    split = _split(is_unit, is_name)
    start = _header(body, is_name, split)
    header, separator = body[start], _separator(body[start].text)
    if all(map(_is_number, filter(None, _cells(header.text, separator)))):
        above = [line for line in comments if line.number < header.number]
        if not above:
            raise FileError(
                source, header.number, "the columns have no names: must begin with a line of names"
            )
        header, body = above[-1], body[start:]
    else:
        body = body[start + 1 :]
    labels, units = map(list, zip(*map(split, _cells(header.text, separator)), strict=True))
    unit_line = header.number
    if body and not any(map(_is_number, _cells(body[0].text, separator))):
        unit_line, below = body[0].number, _cells(body[0].text, separator)
        if len(below) != len(labels):
            raise FileError(source, unit_line, f"{len(below)} units for {len(labels)} columns")
        units, body = [cell.strip("[]() ") or None for cell in below], body[1:]
    if not body:
        raise FileError(source, header.number, "is followed by no numbers")
    rows = [_cells(line.text, separator) for line in body]
    count = len(labels)
    for line, row in zip(body, rows, strict=True):
        if len(row) != count:
            raise FileError(source, line.number, f"{len(row)} values: must be {count}, one for each column")
    columns = list(map(list, zip(*rows, strict=True)))
    return Sheet(
        source, labels, units, header.number, unit_line, columns, [line.number for line in body], comments
    )


def _header(
    body: list[Line],
    is_name: Callable[[str], bool] | None,
    split: Callable[[str], tuple[str, str | None]],
) -> int:
    """Index of the first line with two known names, else of the first line."""
    if is_name is not None:
        for i, line in enumerate(body[:_HEADER_LINES]):
            cells = _cells(line.text, _separator(line.text))[:100]
            if sum(is_name(split(cell)[0]) for cell in cells) >= 2:
                return i
    return 0


def _separator(line: str) -> str | None:
    return next((mark for mark in (";", "\t", ",") if mark in line), None)


def _cells(line: str, separator: str | None) -> list[str]:
    cells = [cell.strip() for cell in line.split(separator)]
    if '"' in line:
        cells = [cell.strip('"').strip() for cell in cells]
    if separator != "," and "," in line:
        cells = [cell.replace(",", ".") if _DECIMAL_COMMA.fullmatch(cell) else cell for cell in cells]
    return cells


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _split(
    is_unit: Callable[[str], bool], is_name: Callable[[str], bool] | None
) -> Callable[[str], tuple[str, str | None]]:
    """Function that takes the unit off a name."""

    def split(name: str) -> tuple[str, str | None]:
        # A name may itself end like a unit, such as E(t), tan(delta) and tan_d.
        whole = is_name is not None and is_name(name)
        if name.endswith((")", "]")) and not name.lower().endswith("(t)") and not whole:
            opening = max(name.rfind("("), name.rfind("["))
            if opening >= 0:
                return name[:opening].strip(), name[opening + 1 : -1].strip()
        stem, _, tail = name.rpartition("_")
        if stem and tail and not (whole and is_name and not is_name(stem)) and is_unit(tail):
            return stem, tail
        return name, None

    return split


def _short(cell: str) -> str:
    return repr(cell if len(cell) <= 40 else f"{cell[:39]}…")
