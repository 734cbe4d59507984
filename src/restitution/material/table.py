"""Tables of measured moduli: what each column holds, in SI."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.material.sheet import FileError, Line, Sheet, read_sheet
from restitution.material.units import UNITS, unit

Array = NDArray[np.float64]


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


def read_table(source: str, text: str) -> Table:
    r"""Table of moduli, times, frequencies, temperatures or shift factors in a text; without units in SI.

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
    sheet = read_sheet(source, text, UNITS.__contains__)
    roles = [_role(source, label, sheet.header_line) for label in sheet.labels]
    if RELAXATION_TIME in roles:
        roles = [BRANCH if role is MODULUS else role for role in roles]
    columns = [_column(source, sheet, i, role) for i, role in enumerate(roles)]
    return Table(columns, [row.line for row in sheet.rows], sheet.comments)


def _plain(label: str) -> str:
    return re.sub(r"[\s_]", "", label)


def _role(source: str, label: str, line: int) -> Role:
    # Only the capital T is a temperature, and the small one a time.
    plain = _plain(label)
    role = TEMPERATURE if plain == "T" else _ROLES.get(plain.lower())
    if role is None:
        raise FileError(source, line, f"column {label!r}: must be a time, a frequency, a modulus, ...")
    return role


def _column(source: str, sheet: Sheet, index: int, role: Role) -> Column:
    label, given = sheet.labels[index], sheet.units[index]
    if role is SHARE and given is not None and UNITS.get(given, UNITS[""]).quantity == "modulus":
        role = BRANCH
    try:
        scale = unit(given, role.quantities) if given is not None else None
    except ValueError as error:
        raise FileError(source, sheet.unit_line, f"column {label!r}: {error}") from None
    factor, offset = (scale.factor, scale.offset) if scale is not None else (1.0, 0.0)
    if (scale.quantity if scale is not None else role.quantities[0]) == "frequency":
        factor *= 2.0 * math.pi
    values = np.empty(len(sheet.rows))
    for i, row in enumerate(sheet.rows):
        value = (row.values[index] + offset) * factor
        bound = role.least
        below = bound is not None and (value < bound or (role.open_bound and value == bound))
        if not math.isfinite(value) or below:
            wanted = "finite" if bound is None else f"finite and {'>' if role.open_bound else '>='} {bound:g}"
            raise FileError(source, row.line, f"{label} = {row.cells[index]}: must be {wanted}")
        values[i] = value
    plain = _plain(label).lower()
    deformation = "tension" if _TENSION.match(plain) else "shear" if _SHEAR.match(plain) else ""
    return Column(role, label, deformation, values)
