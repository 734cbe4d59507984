"""Files of viscoelastic materials, told apart by their content."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from restitution.material import table as tables
from restitution.material.deck import ViscoelasticDeck, read_abaqus, read_ansys
from restitution.material.measurement import (
    Deformation,
    DynamicTable,
    PronyTerms,
    RelaxationTable,
    beyond_one,
)
from restitution.material.sheet import FileError
from restitution.material.shift import ShiftTable
from restitution.material.table import Column, Role, Table, read_table
from restitution.material.units import unit

MaterialFile = RelaxationTable | DynamicTable | PronyTerms | ShiftTable | ViscoelasticDeck

# No data scatter by a half and can still be fitted.
_NOISE = 1.5
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
        The file: text in UTF-8.
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
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise FileError(str(path), 0, "no such file") from None
    except OSError as error:
        raise FileError(str(path), 0, f"cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise FileError(str(path), 0, "cannot be read: must be text in UTF-8") from None
    return parse(text, str(path), name=name)


def parse(text: str, source: str = "text", *, name: str | None = None) -> MaterialFile:
    r"""Read a text as `read` reads a file; `source` is what messages call it.

    Examples
    --------
    >>> parse("relaxation_time_s,relative_modulus\n1,0.5\n").relative
    True
    """
    if "\0" in text:
        raise FileError(source, 0, "cannot be read: must be text in UTF-8")
    if re.search(r"^\s*TB\s*,\s*PRON", text, re.IGNORECASE | re.MULTILINE):
        return read_ansys(source, text, name)
    if re.search(r"^\s*\*\s*VISCOELASTIC", text, re.IGNORECASE | re.MULTILINE):
        return read_abaqus(source, text, name)
    if name is not None:
        raise FileError(
            source, 0, f"has no material {name!r}: is no deck of a solver, whose materials have names"
        )
    return _from_table(source, read_table(source, text))


def _from_table(source: str, table: Table) -> MaterialFile:
    found: dict[Role, Column] = {}
    for column in table.columns:
        if column.role in found:
            raise FileError(source, 0, f"two columns hold a {column.role.name}: must be one")
        found[column.role] = column
    roles = set(found)
    frequency = found.get(tables.FREQUENCY, found.get(tables.ANGULAR_FREQUENCY))
    if roles == {tables.TIME, tables.MODULUS}:
        time, modulus = found[tables.TIME], found[tables.MODULUS]
        _ascending(source, table, time)
        _monotonic(source, table, modulus, falling=True)
        return RelaxationTable(time.values, modulus.values, _deformation(source, modulus), source)
    if frequency is not None and tables.STORAGE in roles and len(roles) == 3:
        storage = found[tables.STORAGE]
        other = found.get(tables.LOSS, found.get(tables.TANGENT))
        if other is not None:
            _ascending(source, table, frequency)
            _monotonic(source, table, storage, falling=False)
            loss = other.values * (storage.values if other.role is tables.TANGENT else 1.0)
            kind = _deformation(source, storage, other)
            return DynamicTable(frequency.values, storage.values, loss, kind, source)
    if tables.RELAXATION_TIME in roles and len(roles) == 2:
        terms = found.get(tables.BRANCH, found.get(tables.SHARE))
        if terms is not None:
            return _prony_terms(source, table, found[tables.RELAXATION_TIME], terms)
    if tables.TEMPERATURE in roles and len(roles) == 2:
        shift = found.get(tables.LOG_SHIFT, found.get(tables.SHIFT))
        if shift is not None:
            return _shift_table(source, table, found[tables.TEMPERATURE], shift)
    names = ", ".join(column.label for column in table.columns)
    raise FileError(
        source,
        0,
        f"columns {names}: must be time and relaxation modulus; frequency, storage and loss modulus; "
        "relaxation time and modulus; or temperature and shift factor",
    )


def _ascending(source: str, table: Table, column: Column) -> None:
    steps = np.diff(column.values)
    if not (steps > 0).all():
        where = int(np.argmin(steps > 0)) + 1
        what = "repeats" if steps[where - 1] == 0 else "is less than"
        raise FileError(
            source,
            table.lines[where],
            f"{column.label} {what} that of line {table.lines[where - 1]}: must be strictly ascending",
        )


def _monotonic(source: str, table: Table, column: Column, *, falling: bool) -> None:
    """Refuse a relaxation modulus that rises over time, or a storage modulus that falls over frequency."""
    values = column.values if falling else 1.0 / column.values
    least = np.minimum.accumulate(values)
    beyond = np.flatnonzero(values > _NOISE * least)
    if beyond.size:
        last = int(beyond[0])
        first = int(np.argmin(values[:last]))
        over, change = ("time", "fall") if falling else ("frequency", "rise")
        raise FileError(
            source,
            table.lines[last],
            f"{column.label} is {column.values[last]:.4g} Pa, and {column.values[first]:.4g} Pa in line "
            f"{table.lines[first]}: must {change} over {over}, but for noise",
        )


def _deformation(source: str, *columns: Column) -> Deformation | None:
    kinds = {column.deformation for column in columns} - {""}
    if len(kinds) > 1:
        raise FileError(source, 0, "one modulus is in tension, the other in shear: must be of one kind")
    return "tension" if "tension" in kinds else "shear" if "shear" in kinds else None


def _prony_terms(source: str, table: Table, times: Column, terms: Column) -> PronyTerms:
    ends: dict[str, float] = {}
    deformation, place = _deformation(source, terms), 0
    for line in table.comments:
        match = _END_MODULUS.search(line.text)
        if match:
            place = line.number
            try:
                scale = unit(match[3] or "Pa", ("modulus",)).factor
                ends["high" if match[1] == "0" else "low"] = float(match[2]) * scale
            except ValueError as error:
                raise FileError(source, place, f"{match[0]!r}: {error}") from None
            deformation = deformation or ("tension" if match[0][0] in "eE" else "shear")
    relative, moduli = terms.role is tables.SHARE, terms.values
    if relative and (beyond := beyond_one(moduli)) is not None:
        raise FileError(
            source,
            table.lines[beyond],
            f"the values of {terms.label} add up to {moduli.sum():.6g}: must be at most 1",
        )
    found = PronyTerms(times.values, moduli, relative, deformation, ends.get("high"), ends.get("low"), source)
    if ends:
        try:
            found.series()
        except ValueError as error:
            raise FileError(source, place, str(error)) from None
    return found


def _shift_table(source: str, table: Table, temperature: Column, shift: Column) -> ShiftTable:
    kelvin = temperature.values
    logs = shift.values if shift.role is tables.LOG_SHIFT else np.log10(shift.values)
    if kelvin.size > 1 and kelvin[0] > kelvin[-1]:
        kelvin, logs = kelvin[::-1], logs[::-1]
    try:
        return ShiftTable(kelvin, logs)
    except ValueError as error:
        raise FileError(source, table.lines[0], str(error)) from None
