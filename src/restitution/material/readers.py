"""Reader of files of viscoelastic materials; the content decides the kind."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from restitution.errors import InputTypeError
from restitution.material import table as tables
from restitution.material.deck import ViscoelasticDeck, read_abaqus, read_ansys
from restitution.material.measurement import (
    Deformation,
    DynamicTable,
    PronyTerms,
    RelaxationTable,
    beyond_one,
)
from restitution.material.sheet import FileError, read_text
from restitution.material.shift import ShiftTable
from restitution.material.table import Column, Role, Table, read_table, unit

Array = NDArray[np.float64]
MaterialFile = RelaxationTable | DynamicTable | PronyTerms | ShiftTable | ViscoelasticDeck

# No data scatter by a half and can still be fitted.
_NOISE = 1.5
_LONGEST_COMMENT = 500
_END_MODULUS = re.compile(r"\b[EG]_?(0|inf|e|eq)\s*=\s*([-+.\deE]+)\s*([A-Za-z/0-9]*)", re.IGNORECASE)


def read_material(path: str | Path, *, name: str | None = None) -> MaterialFile:
    r"""Read a file of a viscoelastic material, whatever its kind.

    Kinds, told apart by content: a relaxation table (time, modulus), a DMA table (frequency, storage
    modulus, loss modulus or loss tangent), a table of shift factors (temperature, log aT or aT), a table of
    Prony terms (relaxation time, modulus or relative modulus), an ANSYS deck with ``TB,PRON``, an Abaqus
    deck with ``*VISCOELASTIC, TIME=PRONY``.

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
    ValueError
        If the file is missing, malformed, or has several materials of which none is chosen; one line with
        the file and the number of the line.

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
    r"""Read a text as `read` reads a file; `source` is what messages call it.

    Examples
    --------
    >>> parse("relaxation_time_s,relative_modulus\n1,0.5\n").relative
    True
    """
    if "\0" in text:
        raise FileError(source, 0, "cannot be read: must be text")
    # Blanks but no ends of lines: these would cost quadratic time.
    if re.search(r"^[ \t]*TB[ \t]*,[ \t]*PRON", text, re.IGNORECASE | re.MULTILINE):
        return read_ansys(source, text, name)
    if re.search(r"^[ \t]*\*[ \t]*VISCOELASTIC", text, re.IGNORECASE | re.MULTILINE):
        return read_abaqus(source, text, name)
    if name is not None:
        raise FileError(
            source, 0, f"has no material {name!r}: is no deck of a solver, whose materials have names"
        )
    return _from_table(source, read_table(source, text))


def _from_table(source: str, table: Table) -> MaterialFile:
    for kind in (_dynamic, _prony_terms, _relaxation, _shift_table):
        found = kind(source, table)
        if found is not None:
            return found
    names = ", ".join(filter(None, table.sheet.labels))
    raise FileError(
        source,
        table.sheet.header_line,
        f"columns {names[:200]}: must be time and relaxation modulus; frequency, storage and loss modulus; "
        "relaxation time and modulus; or temperature and shift factor",
    )


def _first(table: Table, *roles: Role) -> Role | None:
    return next((role for role in roles if table.has(role)), None)


def _dynamic(source: str, table: Table) -> DynamicTable | None:
    frequency = _first(table, tables.ANGULAR_FREQUENCY, tables.FREQUENCY)
    modulus = _first(table, tables.STORAGE, tables.COMPLEX)
    other = _first(table, tables.LOSS, tables.TANGENT)
    if frequency is None or modulus is None or other is None:
        return None
    if modulus is tables.COMPLEX and table.has(tables.TANGENT):
        other = tables.TANGENT
    omega, first, second = map(table.column, (frequency, modulus, other))
    order = _ascending(source, table, omega)
    storage, loss = first.values, second.values
    # What overflows is refused below.
    with np.errstate(over="ignore", invalid="ignore"):
        if modulus is tables.COMPLEX:
            # |E*| with the loss modulus or the loss tangent.
            share = loss / np.hypot(1.0, loss) if other is tables.TANGENT else np.minimum(loss / storage, 1.0)
            loss = storage * share
            storage = storage * np.sqrt((1.0 - share) * (1.0 + share))
        elif other is tables.TANGENT:
            loss = storage * loss
    good = np.isfinite(loss) & (storage > 0.0)
    if not good.all():
        row = int(np.argmin(good))
        wanted = f"{first.label}, {second.label}: must give a storage modulus > 0 and a finite loss modulus"
        raise FileError(source, table.lines[row], wanted)
    _monotonic(source, table, first, storage, order, falling=False)
    kind, notes = _deformation(source, first, second), table.notes(omega, first, second)
    return DynamicTable(omega.values[order], storage[order], loss[order], kind, source, notes)


def _relaxation(source: str, table: Table) -> RelaxationTable | None:
    if not table.has(tables.TIME, tables.MODULUS):
        return None
    time, modulus = table.column(tables.TIME), table.column(tables.MODULUS)
    order = _ascending(source, table, time)
    _monotonic(source, table, modulus, modulus.values, order, falling=True)
    kind, notes = _deformation(source, modulus), table.notes(time, modulus)
    return RelaxationTable(time.values[order], modulus.values[order], kind, source, notes)


def _ascending(source: str, table: Table, column: Column) -> slice:
    """Order in which a column ascends; the numbers may stand in descending order."""
    steps = np.diff(column.values)
    if steps.size and (steps < 0).all():
        return slice(None, None, -1)
    if not (steps > 0).all():
        where = int(np.argmin(steps > 0)) + 1
        what = "repeats" if steps[where - 1] == 0 else "is less than"
        before, line = table.lines[where - 1], table.lines[where]
        wanted = f"{column.label} {what} that of line {before}: must be strictly ascending or descending"
        raise FileError(source, line, wanted)
    return slice(None)


def _monotonic(
    source: str, table: Table, column: Column, moduli: Array, order: slice, *, falling: bool
) -> None:
    """Refuse a relaxation modulus that rises over time, or a storage modulus that falls over frequency."""
    moduli, lines = moduli[order], table.lines[order]
    values = moduli if falling else 1.0 / np.maximum(moduli, 1e-300)
    beyond = np.flatnonzero(values > _NOISE * np.minimum.accumulate(values))
    if beyond.size:
        last = int(beyond[0])
        first = int(np.argmin(values[:last]))
        over, change = ("time", "fall") if falling else ("frequency", "rise")
        wanted = (
            f"{column.label} is {moduli[last]:.4g} Pa, and {moduli[first]:.4g} Pa in line {lines[first]}: "
            f"must {change} over {over}, apart from noise"
        )
        raise FileError(source, lines[last], wanted)


def _deformation(source: str, *columns: Column) -> Deformation | None:
    kinds = {column.deformation for column in columns} - {""}
    if len(kinds) > 1:
        raise FileError(source, 0, "one modulus is in tension, the other in shear: must be of one kind")
    return "tension" if "tension" in kinds else "shear" if "shear" in kinds else None


def _prony_terms(source: str, table: Table) -> PronyTerms | None:
    role = _first(table, tables.BRANCH, tables.SHARE)
    if role is None or not table.has(tables.RELAXATION_TIME):
        return None
    times, terms = table.column(tables.RELAXATION_TIME), table.column(role)
    ends: dict[str, float] = {}
    deformation, place = _deformation(source, terms), 0
    for line in table.comments:
        match = _END_MODULUS.search(line.text[:_LONGEST_COMMENT])
        if match:
            place = line.number
            scale = unit(match[3] or "Pa")
            try:
                if scale is None or scale.dimension != "modulus":
                    raise FileError(
                        source, place, f"{match[0]!r}: must end in a unit of modulus, such as Pa, MPa"
                    )
                ends["high" if match[1] == "0" else "low"] = float(match[2]) * scale.factor
            except FileError:
                raise
            except ValueError:
                raise FileError(source, place, f"{match[0]!r}: must hold a number") from None
            deformation = deformation or ("tension" if match[0][0] in "eE" else "shear")
    relative, moduli = role is tables.SHARE, terms.values
    if relative and (beyond := beyond_one(moduli)) is not None:
        wanted = f"the values of {terms.label} add up to {moduli.sum():.6g}: must be at most 1"
        raise FileError(source, table.lines[beyond], wanted)
    notes = table.notes(times, terms)
    high, low = ends.get("high"), ends.get("low")
    found = PronyTerms(times.values, moduli, relative, deformation, high, low, source, notes)
    if ends:
        try:
            found.series()
        except ValueError as error:
            raise FileError(source, place, str(error)) from None
    return found


def _shift_table(source: str, table: Table) -> ShiftTable | None:
    role = _first(table, tables.LOG_SHIFT, tables.SHIFT)
    if role is None or not table.has(tables.TEMPERATURE):
        return None
    temperature, shift = table.column(tables.TEMPERATURE), table.column(role)
    kelvin = temperature.values
    logs = shift.values if role is tables.LOG_SHIFT else np.log10(shift.values)
    if kelvin.size > 1 and kelvin[0] > kelvin[-1]:
        kelvin, logs = kelvin[::-1], logs[::-1]
    try:
        return ShiftTable(kelvin, logs)
    except ValueError as error:
        raise FileError(source, table.lines[0], str(error)) from None
