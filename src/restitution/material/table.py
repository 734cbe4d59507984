"""Text tables with named columns and units, as instruments and spreadsheets write them."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.material.units import UNITS, unit

Array = NDArray[np.float64]


class FileError(ValueError):
    """Malformed file, with its name and the number of the line to blame."""

    def __init__(self, source: str, line: int, message: str) -> None:
        super().__init__(f"{source}: line {line}: {message}" if line else f"{source}: {message}")


class Role(NamedTuple):
    """What a column holds.

    Attributes
    ----------
    name
        Name of the quantity.
    quantities
        Admissible quantities of its unit; the first one is meant where no unit is given.
    least
        Bound of its values, None for none.
    open_bound
        Whether the bound itself is excluded.
    """

    name: str
    quantities: tuple[str, ...]
    least: float | None = 0.0
    open_bound: bool = True


TIME = Role("time", ("time",), open_bound=False)
FREQUENCY = Role("frequency", ("frequency", "angular frequency"))
ANGULAR_FREQUENCY = Role("angular frequency", ("angular frequency", "frequency"))
MODULUS = Role("relaxation modulus", ("modulus",))
STORAGE = Role("storage modulus", ("modulus",))
LOSS = Role("loss modulus", ("modulus",), open_bound=False)
TANGENT = Role("loss tangent", ("number",), open_bound=False)
RELAXATION_TIME = Role("relaxation time", ("time",))
BRANCH = Role("branch modulus", ("modulus",), open_bound=False)
SHARE = Role("relative modulus", ("number",), open_bound=False)
TEMPERATURE = Role("temperature", ("temperature",))
LOG_SHIFT = Role("log10 of the shift factor", ("number",), least=None)
SHIFT = Role("shift factor", ("number",))

_SPELLINGS: dict[Role, str] = {
    TIME: "t time",
    FREQUENCY: "f freq frequency",
    ANGULAR_FREQUENCY: "w omega ω angfreq angularfrequency",
    MODULUS: "e g er gr erelax grelax e(t) g(t) modulus relaxationmodulus tensilemodulus shearmodulus "
    "tensilerelaxationmodulus shearrelaxationmodulus youngsmodulus",
    STORAGE: "e' g' estor gstor estorage gstorage eprime gprime storage storagemodulus",
    LOSS: "e'' g'' eloss gloss edoubleprime gdoubleprime loss lossmodulus",
    TANGENT: "tandel tandelta tanδ losstangent lossfactor",
    RELAXATION_TIME: "tau taui tauk τ reltime relaxationtime relaxationtimes",
    BRANCH: "branchmodulus branchmoduli ei ek",
    SHARE: "relmod relativemodulus relativemoduli alpha alphai gi ki",
    TEMPERATURE: "temp temperature",
    LOG_SHIFT: "logat log10at loga log10a logshift",
    SHIFT: "at a shiftfactor",
}
_ROLES = {spelling: role for role, text in _SPELLINGS.items() for spelling in text.split()}
_TENSION = re.compile(r"^(e\b|e[^a-z]|estor|eloss|erelax|eprime|edouble|er$|ei$|ek$|tensile|young)")
_SHEAR = re.compile(r"^(g\b|g[^a-z]|gstor|gloss|grelax|gprime|gdouble|gr$|gi$|shear)")
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+([eE][+-]?\d+)?")
_UNIT_IN_BRACKETS = re.compile(r"^(.*?)\s*[\[(]([^\])]*)[\])]$")


class Line(NamedTuple):
    """Line of a file and its number, from 1."""

    number: int
    text: str


class Column(NamedTuple):
    """Column of a table, in SI (angular frequencies in rad/s).

    Attributes
    ----------
    role
        What it holds.
    label
        Its name in the file.
    deformation
        "tension", "shear" or "" where the name does not tell.
    values
        Shape (n,).
    """

    role: Role
    label: str
    deformation: str
    values: Array


class Table(NamedTuple):
    """Columns of a table, the line of each row, and the comments above."""

    columns: list[Column]
    lines: list[int]
    comments: list[Line]


def split_lines(text: str) -> list[Line]:
    """Lines that hold something, with their numbers."""
    lines = [Line(i, line.strip()) for i, line in enumerate(text.splitlines(), 1)]
    return [line for line in lines if line.text]


def read_table(source: str, text: str) -> Table:
    r"""Table of named columns in a text.

    The names stand in the first line, or in the last comment (#) above the numbers. A unit stands behind
    the name, in brackets or after an underscore, or in a second line of units; without one the column is in
    SI. Columns are separated by commas, semicolons (then with decimal points or commas), tabs or blanks.

    Raises
    ------
    ValueError
        With the name of the source and the number of the line.

    Examples
    --------
    >>> table = read_table("x", "t [ms],E [MPa]\n1,3\n2,4\n")
    >>> [(column.role.name, column.deformation) for column in table.columns]
    [('time', ''), ('relaxation modulus', 'tension')]
    >>> table.columns[1].values
    array([3000000., 4000000.])
    """
    lines = split_lines(text)
    comments = [Line(n, line.lstrip("#").strip()) for n, line in lines if line.startswith("#")]
    body = [line for line in lines if not line.text.startswith("#")]
    if not body:
        raise FileError(source, 0, "holds no numbers" if lines else "is empty")
    separator = _separator(body[0].text)
    if _is_numeric(_cells(body[0].text, separator)):
        above = [line for line in comments if line.number < body[0].number]
        if not above:
            raise FileError(
                source, body[0].number, "the columns have no names: must begin with a line of names"
            )
        header = above[-1]
    else:
        header, body = body[0], body[1:]
    names = _cells(header.text, separator)
    units: list[str] | None = None
    if body and not _is_numeric(_cells(body[0].text, separator), some=True):
        units = _cells(body[0].text, separator)
        if len(units) != len(names):
            raise FileError(source, body[0].number, f"{len(units)} units for {len(names)} columns")
        unit_line, body = body[0].number, body[1:]
    else:
        unit_line = header.number
    if not body:
        raise FileError(source, header.number, "is followed by no numbers")
    columns: list[Column] = []
    rows = [_row(source, line, separator, len(names)) for line in body]
    labels = [_label_and_unit(name) for name in names]
    roles = [_role(source, label, header.number) for label, _ in labels]
    if RELAXATION_TIME in roles:
        roles = [BRANCH if role is MODULUS else role for role in roles]
    for i, ((label, given), role) in enumerate(zip(labels, roles, strict=True)):
        given = units[i] if units is not None else given
        columns.append(_column(source, label, role, given, unit_line, rows, i))
    return Table(columns, [line.number for line in body], comments)


def _separator(line: str) -> str | None:
    return next((mark for mark in (";", "\t", ",") if mark in line), None)


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


def _is_numeric(cells: list[str], some: bool = False) -> bool:
    # A dash may stand in a line of units.
    numbers = [_is_number(cell) for cell in cells if cell not in UNITS]
    return any(numbers) if some else bool(numbers) and all(numbers)


def _label_and_unit(name: str) -> tuple[str, str | None]:
    match = _UNIT_IN_BRACKETS.match(name)
    if match and match[2].strip() not in ("t",):
        return match[1], match[2]
    stem, mark, tail = name.rpartition("_")
    if mark and tail in UNITS and tail:
        return stem, tail
    return name, None


def _row(source: str, line: Line, separator: str | None, count: int) -> tuple[int, list[float], list[str]]:
    cells = _cells(line.text, separator)
    if len(cells) != count:
        raise FileError(source, line.number, f"{len(cells)} values: must be {count}, one for each column")
    values: list[float] = []
    for cell in cells:
        if not _is_number(cell):
            raise FileError(source, line.number, f"{cell!r}: must be a number")
        values.append(float(cell))
    return line.number, values, cells


def _plain(label: str) -> str:
    return re.sub(r"[\s_]", "", label)


def _role(source: str, label: str, line: int) -> Role:
    # Only the capital T is a temperature, and the small one a time.
    plain = _plain(label)
    role = TEMPERATURE if plain == "T" else _ROLES.get(plain.lower())
    if role is None:
        raise FileError(source, line, f"column {label!r}: must be a time, a frequency, a modulus, ...")
    return role


def _column(
    source: str,
    label: str,
    role: Role,
    given: str | None,
    unit_line: int,
    rows: list[tuple[int, list[float], list[str]]],
    index: int,
) -> Column:
    if role is SHARE and given is not None and UNITS.get(given, UNITS[""]).quantity == "modulus":
        role = BRANCH
    try:
        scale = unit(given, role.quantities) if given is not None else None
    except ValueError as error:
        raise FileError(source, unit_line, f"column {label!r}: {error}") from None
    factor, offset = (scale.factor, scale.offset) if scale is not None else (1.0, 0.0)
    if (scale.quantity if scale is not None else role.quantities[0]) == "frequency":
        factor *= 2.0 * math.pi
    values = np.empty(len(rows))
    for i, (number, row, cells) in enumerate(rows):
        value = (row[index] + offset) * factor
        bound = role.least
        below = bound is not None and (value < bound or (role.open_bound and value == bound))
        if not math.isfinite(value) or below:
            wanted = "finite" if bound is None else f"finite and {'>' if role.open_bound else '>='} {bound:g}"
            raise FileError(source, number, f"{label} = {cells[index]}: must be {wanted}")
        values[i] = value
    plain = _plain(label).lower()
    deformation = "tension" if _TENSION.match(plain) else "shear" if _SHEAR.match(plain) else ""
    return Column(role, label, deformation, values)
