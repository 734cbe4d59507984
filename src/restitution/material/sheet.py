"""Text tables as instruments and spreadsheets write them: named columns, units, numbers, whatever they mean."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import NamedTuple

_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+([eE][+-]?\d+)?")
_UNIT_IN_BRACKETS = re.compile(r"^(.*?)\s*[\[(]([^\])]*)[\])]$")


class FileError(ValueError):
    """Malformed file, with its name and the number of the line to blame."""

    def __init__(self, source: str, line: int, message: str) -> None:
        place = ": ".join(filter(None, (source, f"line {line}" if line else "")))
        super().__init__(f"{place}: {message}" if place else message)


class Line(NamedTuple):
    """Line of a file and its number, from 1."""

    number: int
    text: str


class Row(NamedTuple):
    """Numbers of one line, and how they are written."""

    line: int
    values: list[float]
    cells: list[str]


class Sheet(NamedTuple):
    """Table of numbers under named columns.

    Attributes
    ----------
    labels
        Names of the columns, without their units.
    units
        Their units as they are written, None for none.
    header_line, unit_line
        Numbers of the lines in which the names and the units stand; the same where one holds both.
    rows
        The numbers.
    comments
        Lines that begin with #, without it.
    """

    labels: list[str]
    units: list[str | None]
    header_line: int
    unit_line: int
    rows: list[Row]
    comments: list[Line]


def split_lines(text: str) -> list[Line]:
    """Lines that hold something, with their numbers."""
    lines = [Line(i, line.strip()) for i, line in enumerate(text.splitlines(), 1)]
    return [line for line in lines if line.text]


def read_sheet(source: str, text: str, is_unit: Callable[[str], bool]) -> Sheet:
    r"""Table of named columns in a text.

    The names stand in the first line, or in the last comment (#) above the numbers. A unit stands behind
    the name, in brackets or after an underscore, or in a second line of units. Columns are separated by
    commas, semicolons (then with decimal points or commas), tabs or blanks.

    Parameters
    ----------
    source
        Name of the text in messages.
    text
        What is read.
    is_unit
        Whether what follows the last underscore of a name is a unit.

    Raises
    ------
    ValueError
        With the name of the source and the number of the line.

    Examples
    --------
    >>> sheet = read_sheet("x", "t [ms];E_MPa\n1;3,5\n", lambda tail: tail == "MPa")
    >>> sheet.labels, sheet.units, sheet.rows[0].values
    (['t', 'E'], ['ms', 'MPa'], [1.0, 3.5])
    """
    lines = split_lines(text)
    comments = [Line(n, line.lstrip("#").strip()) for n, line in lines if line.startswith("#")]
    body = [line for line in lines if not line.text.startswith("#")]
    if not body:
        raise FileError(source, 0, "holds no numbers" if lines else "is empty")
    separator = next((mark for mark in (";", "\t", ",") if mark in body[0].text), None)
    if all(map(_is_number, _cells(body[0].text, separator))):
        above = [line for line in comments if line.number < body[0].number]
        if not above:
            raise FileError(
                source, body[0].number, "the columns have no names: must begin with a line of names"
            )
        header = above[-1]
    else:
        header, body = body[0], body[1:]
    labels, units = _labels_and_units(_cells(header.text, separator), is_unit)
    unit_line = header.number
    if body and not any(map(_is_number, _cells(body[0].text, separator))):
        unit_line, below = body[0].number, _cells(body[0].text, separator)
        if len(below) != len(labels):
            raise FileError(source, unit_line, f"{len(below)} units for {len(labels)} columns")
        units, body = list[str | None](below), body[1:]
    if not body:
        raise FileError(source, header.number, "is followed by no numbers")
    rows = [_row(source, line, separator, len(labels)) for line in body]
    return Sheet(labels, units, header.number, unit_line, rows, comments)


def _cells(line: str, separator: str | None) -> list[str]:
    cells = [cell.strip().strip('"') for cell in line.split(separator)]
    if separator == ";":
        cells = [cell.replace(",", ".") if _DECIMAL_COMMA.fullmatch(cell) else cell for cell in cells]
    return cells


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _labels_and_units(names: list[str], is_unit: Callable[[str], bool]) -> tuple[list[str], list[str | None]]:
    labels: list[str] = []
    units: list[str | None] = []
    for name in names:
        label, unit = name, None
        match = _UNIT_IN_BRACKETS.match(name)
        stem, _, tail = name.rpartition("_")
        # The t of E(t) is no unit.
        if match and match[2].strip() != "t":
            label, unit = match[1], match[2]
        elif stem and tail and is_unit(tail):
            label, unit = stem, tail
        labels.append(label)
        units.append(unit)
    return labels, units


def _row(source: str, line: Line, separator: str | None, count: int) -> Row:
    cells = _cells(line.text, separator)
    if len(cells) != count:
        raise FileError(source, line.number, f"{len(cells)} values: must be {count}, one for each column")
    for cell in cells:
        if not _is_number(cell):
            raise FileError(source, line.number, f"{cell!r}: must be a number")
    return Row(line.number, [float(cell) for cell in cells], cells)
