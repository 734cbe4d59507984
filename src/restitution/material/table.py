"""Columns of measured tables: the quantity of each column, and its numbers in SI."""

from __future__ import annotations

import math
import re
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.checks import unit_registry
from restitution.material.sheet import FileError, Line, Sheet, read_sheet

Array = NDArray[np.float64]


class Role(NamedTuple):
    """Quantity of a column.

    Attributes
    ----------
    name
        Name of the quantity.
    dimensions
        Admissible dimensions of its unit.
    assumed
        Unit that is assumed where none is given.
    least
        Bound of its values, None for none.
    open_bound
        Whether the bound itself is excluded.
    """

    name: str
    dimensions: tuple[str, ...]
    assumed: str = ""
    least: float | None = 0.0
    open_bound: bool = True


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
_TENSION = re.compile(
    r"^(\|?e\b|\|?e[^a-z]|epp?$|estor|eloss|erelax|eprime|edouble|er$|ei$|ek$|tensile|young)"
)
_SHEAR = re.compile(r"^(\|?g\b|\|?g[^a-z]|gpp?$|gstor|gloss|grelax|gprime|gdouble|gr$|gi$|shear)")
_QUOTES = str.maketrans(dict.fromkeys("’‘′´`", "'") | dict.fromkeys('”″"', "''"))


class Unit(NamedTuple):
    """Unit of a column: SI value = factor * (value + offset)."""

    dimension: str
    factor: float
    offset: float = 0.0


# The common units, without the import of pint, which takes 0.4 s; pint would take C for coulomb.
_PLAIN = {
    **{name: Unit("time", factor) for name, factor in {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6}.items()},
    **{name: Unit("time", factor) for name, factor in {"sec": 1.0, "min": 60.0, "h": 3600.0}.items()},
    **{name: Unit("modulus", f) for name, f in {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9}.items()},
    **{name: Unit("frequency", f) for name, f in {"Hz": 1.0, "1/s": 1.0, "kHz": 1e3, "MHz": 1e6}.items()},
    "rad/s": Unit("angular frequency", 1.0),
    "K": Unit("temperature", 1.0),
    **{name: Unit("temperature", 1.0, 273.15) for name in ("°C", "degC", "C", "ºC")},
    "-": Unit("number", 1.0),
    "1": Unit("number", 1.0),
    "": Unit("number", 1.0),
    "%": Unit("number", 0.01),
}
_COMPOSED = re.compile(r"[A-Za-zµ]{1,12}(\^?[23])?([*/][A-Za-zµ]{1,12}(\^?[23])?){0,2}")


@cache
def unit(text: str) -> Unit | None:
    """Return the unit of a name, None if it is unknown or of another dimension than those of the tables.

    Examples
    --------
    >>> unit("MPa").factor, round(unit("psi").factor, 2), unit("furlong")
    (1000000.0, 6894.76, None)
    """
    name = text.strip().replace("²", "2").replace("μ", "µ")
    if name in _PLAIN:
        return _PLAIN[name]
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


class Column(NamedTuple):
    """Column of a table, in SI (angular frequencies in rad/s).

    Attributes
    ----------
    role
        Its quantity.
    label
        Its name in the file.
    deformation
        "tension", "shear" or "" where the name does not tell.
    values
        Shape (n,).
    note
        The unit that was assumed; empty where the file gives one.
    """

    role: Role
    label: str
    deformation: str
    values: Array
    note: str = ""


class Table(NamedTuple):
    """Sheet of known quantities; a column is read when it is asked for."""

    sheet: Sheet
    roles: list[Role | None]

    @property
    def lines(self) -> list[int]:
        """Number of the line of each row."""
        return self.sheet.lines

    @property
    def comments(self) -> list[Line]:
        """Comments of the file."""
        return self.sheet.comments

    def has(self, *roles: Role) -> bool:
        """Whether there is a column of each role."""
        return all(role in self.roles for role in roles)

    def column(self, role: Role) -> Column:
        """Return the column of a role, refusing two of them."""
        if self.roles.count(role) > 1:
            raise FileError(
                self.sheet.source, self.sheet.header_line, f"two columns hold a {role.name}: must be one"
            )
        return _column(self.sheet, self.roles.index(role), role)

    def notes(self, *used: Column) -> tuple[str, ...]:
        """Return the remarks on columns: units that were assumed, and columns that are not used."""
        labels = {column.label for column in used}
        left = [label for label in self.sheet.labels if label and label not in labels]
        unused = (f"columns not used: {', '.join(left)}",) if left else ()
        return (*(column.note for column in used if column.note), *unused)


def read_table(source: str, text: str) -> Table:
    r"""Return the table of moduli, times, frequencies, temperatures or shift factors in a text; without units in SI.

    Raises
    ------
    FileError
        With the name of the source and the number of the line.

    Examples
    --------
    >>> table = read_table("x", "t [ms],E [MPa]\n1,3\n2,4\n")
    >>> column = table.column(MODULUS)
    >>> column.deformation, column.values
    ('tension', array([3000000., 4000000.]))
    """
    sheet = read_sheet(
        source, text, lambda tail: unit(tail) is not None, lambda name: _role(name) is not None
    )
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


def _column(sheet: Sheet, index: int, role: Role) -> Column:
    label, given = sheet.labels[index], sheet.units[index]
    scale = unit(role.assumed if given is None else given)
    if scale is None or scale.dimension not in role.dimensions:
        known = ", ".join(name for name, one in _PLAIN.items() if one.dimension in role.dimensions and name)
        message = f"column {label!r}: unit {given!r}: must be a unit of {role.dimensions[0]}, such as {known}"
        raise FileError(sheet.source, sheet.unit_line, message)
    factor = scale.factor * (2.0 * math.pi if scale.dimension == "frequency" else 1.0)
    with np.errstate(over="ignore"):
        values = (sheet.numbers(index) + scale.offset) * factor
    good = np.isfinite(values)
    if role.least is not None:
        good &= values > role.least if role.open_bound else values >= role.least
    if not good.all():
        row = int(np.argmin(good))
        bound = "" if role.least is None else f" and {'>' if role.open_bound else '>='} {role.least:g}"
        message = f"{label} = {sheet.cells[index][row]}: must be finite{bound}"
        raise FileError(sheet.source, sheet.lines[row], message)
    plain = _plain(label).lower()
    deformation = "tension" if _TENSION.match(plain) else "shear" if _SHEAR.match(plain) else ""
    note = f"unit of {label} not given: {role.assumed} assumed" if given is None and role.assumed else ""
    return Column(role, label, deformation, values, note)
