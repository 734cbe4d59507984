"""Reader of files of viscoelastic materials; the content decides the kind."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from restitution.errors import InputError
from restitution.files import path_of
from restitution.material.deck import PronyTerms, ViscoelasticDeck, beyond_one, read_abaqus, read_ansys
from restitution.material.fit import DynamicTable, RelaxationTable
from restitution.material.formats import read_sheets, read_workbook
from restitution.material.isotherms import Curve, Isotherms, average
from restitution.material.roles import (
    ANGULAR_FREQUENCY,
    BRANCH,
    COMPLEX,
    FREQUENCY,
    LOG_SHIFT,
    LOSS,
    MODULUS,
    RELAXATION_TIME,
    SHARE,
    SHIFT,
    STORAGE,
    SWEEP,
    TANGENT,
    TEMPERATURE,
    TIME,
    Column,
    Table,
)
from restitution.material.sheet import FileError, Sheet, is_workbook, read_bytes, read_text, unit
from restitution.material.shift import ShiftTable

Array = NDArray[np.float64]
MaterialFile = RelaxationTable | DynamicTable | Isotherms | PronyTerms | ShiftTable | ViscoelasticDeck

# Sweeps whose temperatures [K] differ by less are at one temperature.
_SAME_TEMPERATURE = 1.0
_LONGEST_COMMENT = 500
_END_MODULUS = re.compile(r"\b[EG]_?(0|inf|e|eq)\s*=\s*([-+.\deE]+)\s*([A-Za-z/0-9]*)", re.IGNORECASE)


def read_material(path: str | Path, *, name: str | None = None) -> MaterialFile:
    r"""Read a file of a viscoelastic material; the content decides the kind.

    Tables: relaxation (time, modulus), DMA (frequency, storage modulus, loss modulus or loss tangent), shift factors
    (temperature, log aT or aT), Prony terms (relaxation time, modulus or relative modulus). Exports of TRIOS (text,
    JSON), RheoCompass, RepTate and pyvisco. Decks: ANSYS with ``TB,PRON``, Abaqus with ``*VISCOELASTIC, TIME=PRONY``.

    Parameters
    ----------
    path
        The file: text in UTF-8, UTF-16 or Latin-1, or a workbook (.xlsx, with the extra ``restitution[excel]``).
    name
        Which material of a deck that has several: its NAME in Abaqus, its number in ANSYS.

    Returns
    -------
    RelaxationTable, DynamicTable, Isotherms, PronyTerms, ShiftTable or ViscoelasticDeck
        In SI. `Isotherms` are moduli at several temperatures.

    Raises
    ------
    InputError
        If the file is missing or malformed, or has several materials and none is chosen; it names file and line.

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
    path = path_of(path)
    content = read_bytes(path)
    if is_workbook(content):
        _refuse_name(str(path), name)
        return _content(str(path), read_workbook(str(path), content))
    return parse(read_text(path), str(path), name=name)


def parse(text: str, source: str = "text", *, name: str | None = None) -> MaterialFile:
    """Read a text as `read_material` reads a file; `source` is its name in messages."""
    if "\0" in text:
        raise FileError(source, 0, "cannot be read: must be text")
    for pattern, read_deck in _DECKS:
        if pattern.search(text):
            return read_deck(source, text, name)
    _refuse_name(source, name)
    return _content(source, read_sheets(source, text))


# Blanks but no ends of lines: these would cost quadratic time.
_DECKS = (
    (re.compile(r"^[ \t]*(TB[ \t]*,[ \t]*PRON|MP[ \t]*,[ \t]*EX)", re.IGNORECASE | re.MULTILINE), read_ansys),
    (re.compile(r"^[ \t]*\*[ \t]*(VISCO)?ELASTIC", re.IGNORECASE | re.MULTILINE), read_abaqus),
)


def _refuse_name(source: str, name: str | None) -> None:
    if name is not None:
        raise FileError(source, 0, f"has no material {name!r}: is no deck of a solver, whose materials have names")


def _content(source: str, sheets: list[Sheet]) -> MaterialFile:
    """Material data of sheets: that of the only one, or the sweeps of several."""
    tables = [Table.of(sheet) for sheet in sheets]
    found: list[Curve] = []
    unused: list[str] = []
    for table in tables:
        curves = _curves(table)
        found += curves
        unused += [] if curves else [table.sheet.title]
    if found:
        return _joined(source, found, unused)
    if len(tables) == 1:
        for kind in (_prony_terms, _shift_table):
            if (one := kind(tables[0])) is not None:
                return one
    if len(tables) == 1 and not unused[0]:
        sheet = tables[0].sheet
        message = f"columns {', '.join(filter(None, sheet.labels))[:200]}: must be time and relaxation modulus; "
        message += "frequency, storage and loss modulus; relaxation time and modulus; or temperature and shift factor"
        raise tables[0].error(message, sheet.header_line)
    titles = ", ".join(unused)[:200]
    wanted = "one must have several frequencies with storage and loss modulus, or times with the relaxation modulus"
    raise FileError(source, 0, f"{titles or 'no step'}: {wanted}")


def _joined(source: str, curves: list[Curve], unused: list[str]) -> Curve | Isotherms:
    """The only sweep, or one at each temperature. Sweeps at one temperature are averaged."""
    kind = DynamicTable if any(isinstance(curve, DynamicTable) for curve in curves) else RelaxationTable
    alike = [curve for curve in curves if isinstance(curve, kind)]
    notes = [f"not used: {', '.join(unused)[:200]}"] if unused else []
    notes += [f"{len(curves) - len(alike)} relaxations are not used"] if len(alike) < len(curves) else []
    if len(alike) > 1 and any(curve.temperature is None for curve in alike):
        raise FileError(source, 0, f"holds {len(alike)} sweeps: the temperature of each must be stated, or one kept")
    groups: list[list[Curve]] = []
    for curve in sorted(alike, key=lambda one: one.temperature or 0.0):
        if groups and (curve.temperature or 0.0) - (groups[-1][0].temperature or 0.0) < _SAME_TEMPERATURE:
            groups[-1].append(curve)
        else:
            groups.append([curve])
    for group in groups:
        if len(group) > 1:
            notes.append(f"{len(group)} sweeps at {(group[0].temperature or 0.0) - 273.15:.1f} °C are averaged")
    tables = [average(group) if len(group) > 1 else group[0] for group in groups]
    remarks = tuple(dict.fromkeys([*(note for curve in alike for note in curve.notes), *notes]))
    if len(tables) == 1:
        return replace(tables[0], source=source, notes=remarks)
    return Isotherms(tables, source=source, notes=remarks)


def _curves(table: Table) -> list[Curve]:
    """Sweeps of one table: a single one, or one at each temperature; none if it has not the columns."""
    read, columns = _dynamic, table.columns((ANGULAR_FREQUENCY, FREQUENCY), (STORAGE, COMPLEX), (LOSS, TANGENT))
    if not columns:
        read, columns = _relaxation, table.columns((TIME,), (MODULUS,))
        # Steps of creep and flow have times and a "modulus" as well.
        title = table.sheet.title.lower()
        if not columns or (title and "relax" not in title and columns[1].label.lower() == "modulus"):
            return []
    x = columns[0].values
    if table.sheet.title and (not x.size or np.ptp(x) <= 1e-3 * x.max()):
        return []  # a sweep of amplitudes or temperatures
    rows = _sweeps(table, x)
    parts = [table] if len(rows) == 1 else [table.part(some) for some in rows]
    return [read(part, several=len(rows) > 1) for part in parts]


def _sweeps(table: Table, x: Array) -> list[NDArray[np.intp]]:
    """Rows of each sweep over frequency or time: by their number, where the order turns back, or by temperature."""
    every = [np.arange(x.size)]
    if table.sheet.scattered or x.size < 2:
        return every
    if numbers := table.columns((SWEEP,)):
        return [np.flatnonzero(numbers[0].values == one) for one in np.unique(numbers[0].values)]
    # A table of one sweep may lack units of its temperatures, which are not needed.
    if TEMPERATURE not in table.roles:
        return every
    steps = np.sign(np.diff(x))
    if abs(steps.sum()) == steps.size:
        return every
    column = table.temperature
    if column is None or np.ptp(column.values) < _SAME_TEMPERATURE:
        return every
    kelvin = column.values
    # A sweep ends where the order turns back; it begins with the next row.
    turns, direction = [0], 0.0
    for i, step in enumerate(steps.tolist(), 1):
        if direction and step != direction:
            turns.append(i)
            direction = 0.0
        else:
            direction = step
    runs = np.split(np.arange(x.size), turns[1:])
    if all(np.ptp(kelvin[run]) < _SAME_TEMPERATURE for run in runs) and 2 * len(runs) <= x.size:
        return runs
    order = np.argsort(kelvin, kind="stable")
    jumps = np.flatnonzero(np.diff(kelvin[order]) > _SAME_TEMPERATURE) + 1
    return [np.sort(rows) for rows in np.split(order, jumps)]


def _temperature(table: Table, several: bool) -> tuple[float | None, list[Column]]:
    """Mean temperature [K] of a sweep, and the columns that it needs."""
    stated = TEMPERATURE in table.roles and table.sheet.units[table.roles.index(TEMPERATURE)] is not None
    column = table.temperature if stated or several else None
    numbers = table.columns((SWEEP,)) if several else []
    if column is None:
        return table.sheet.temperature, numbers
    return float(column.values.mean()), [column, *numbers]


def _dynamic(table: Table, *, several: bool = False) -> DynamicTable:
    complex_first = STORAGE not in table.roles
    columns = table.columns(
        (ANGULAR_FREQUENCY, FREQUENCY), (STORAGE, COMPLEX), (TANGENT, LOSS) if complex_first else (LOSS, TANGENT)
    )
    omega, first, second = columns
    order = slice(None) if table.sheet.scattered else table.order(omega)
    storage, loss = first.values, second.values
    # What overflows is refused below.
    with np.errstate(over="ignore", invalid="ignore"):
        if first.role is COMPLEX:
            # |E*| with the loss modulus or the loss tangent.
            share = loss / np.hypot(1.0, loss) if second.role is TANGENT else np.minimum(loss / storage, 1.0)
            loss = storage * share
            storage = storage * np.sqrt((1.0 - share) * (1.0 + share))
        elif second.role is TANGENT:
            loss = storage * loss
    good = np.isfinite(loss) & (storage > 0.0)
    if not good.all():
        wanted = f"{first.label}, {second.label}: must give a storage modulus > 0 and a finite loss modulus"
        raise table.error(wanted, row=int(np.argmin(good)))
    if not table.sheet.scattered:
        table.refuse_growth(first, 1.0 / np.maximum(storage, 1e-300), order, "rise over frequency")
    kelvin, others = _temperature(table, several)
    about = table.about(omega, first, second, *others)
    found = DynamicTable(omega.values[order], storage[order], loss[order], *about, temperature=kelvin)
    return average([found]) if table.sheet.scattered else found


def _relaxation(table: Table, *, several: bool = False) -> RelaxationTable:
    time, modulus = table.columns((TIME,), (MODULUS,))
    order = slice(None) if table.sheet.scattered else table.order(time)
    if not table.sheet.scattered:
        table.refuse_growth(modulus, modulus.values, order, "fall over time")
    kelvin, others = _temperature(table, several)
    about = table.about(time, modulus, *others)
    found = RelaxationTable(time.values[order], modulus.values[order], *about, temperature=kelvin)
    return average([found]) if table.sheet.scattered else found


def _prony_terms(table: Table) -> PronyTerms | None:
    columns = table.columns((RELAXATION_TIME,), (BRANCH, SHARE))
    if not columns:
        return None
    times, terms = columns
    deformation, source, notes = table.about(times, terms)
    ends: dict[str, float] = {}
    place = 0
    for line in table.sheet.comments:
        if not (match := _END_MODULUS.search(line.text[:_LONGEST_COMMENT])):
            continue
        place, scale = line.number, unit(match[3] or "Pa")
        if scale is None or scale.dimension != "modulus":
            raise table.error(f"{match[0]!r}: must end in a unit of modulus, such as Pa, MPa", place)
        try:
            ends["high" if match[1] == "0" else "low"] = float(match[2]) * scale.factor
        except ValueError:
            raise table.error(f"{match[0]!r}: must hold a number", place) from None
        deformation = deformation or ("tension" if match[0][0] in "eE" else "shear")
    relative, moduli = terms.role is SHARE, terms.values
    if relative and (beyond := beyond_one(moduli)) is not None:
        wanted = f"the values of {terms.label} add up to {moduli.sum():.6g}: must be at most 1"
        raise table.error(wanted, row=beyond)
    found = PronyTerms(times.values, moduli, relative, deformation, ends.get("high"), ends.get("low"), source, notes)
    if ends:
        try:
            found.series()
        except InputError as error:
            raise table.error(str(error), place) from None
    return found


def _shift_table(table: Table) -> ShiftTable | None:
    columns = table.columns((TEMPERATURE,), (LOG_SHIFT, SHIFT))
    if not columns:
        return None
    temperature, shift = columns
    kelvin = temperature.values
    logs = shift.values if shift.role is LOG_SHIFT else np.log10(shift.values)
    if kelvin[0] > kelvin[-1]:
        kelvin, logs = kelvin[::-1], logs[::-1]
    try:
        return ShiftTable(kelvin, logs, notes=table.about(temperature, shift)[2])
    except InputError as error:
        raise table.error(str(error), row=0) from None
