"""Reader of files of viscoelastic materials, among them those of rheometers; the content decides the kind."""

from __future__ import annotations

import json
import math
import re
import zipfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from importlib import import_module
from io import BytesIO
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restitution.checks import Array
from restitution.errors import InputError
from restitution.files import path_of
from restitution.material.cards import PronyTerms, ViscoelasticDeck, beyond_one, read_abaqus, read_ansys
from restitution.material.fit import CreepTable, DynamicTable, RelaxationTable
from restitution.material.master_curve import Curve, Isotherms, average
from restitution.material.sheet import (
    Column,
    FileError,
    Line,
    Role,
    Sheet,
    Table,
    decoded,
    is_number,
    is_workbook,
    read_bytes,
    read_sheet,
    split_lines,
    unit,
)
from restitution.material.shift import ShiftTable
from restitution.material.temperature_ramp import TemperatureRamp
from restitution.units import MODULUS, ZERO_CELSIUS

MaterialFile = (
    RelaxationTable
    | DynamicTable
    | CreepTable
    | Isotherms
    | TemperatureRamp
    | PronyTerms
    | ShiftTable
    | ViscoelasticDeck
)

# Sweeps whose temperatures [K] differ by less are at one temperature.
_SAME_TEMPERATURE = 1.0
# Frequencies of a temperature ramp differ by less, relatively; fewer temperatures are none.
_SAME_FREQUENCY, _FEWEST = 1e-2, 4
# Measured files are smaller; more would only cost memory.
_LARGEST = 200_000_000
_MOST_ROWS = 100_000
_MOST_CELLS = 5_000_000
_LONGEST_COMMENT = 500
_CELSIUS = re.compile(r"(?<![\w.,])(-?\d{1,4}(?:[.,]\d{1,6})?)\s?°C")
_END_MODULUS = re.compile(r"\b[EG]_?(0|inf|e|eq)\s*=\s*([-+.\deE]+)\s*([A-Za-z/0-9]*)", re.IGNORECASE)
# Word that begins a line of RheoCompass.
_KEY = re.compile(r'"?([A-Za-z][^\t,;:"]{0,60}):"?(?=[\t,;]|$)')


def read_material(path: str | Path, *, name: str | None = None) -> MaterialFile:
    r"""Read a file of a viscoelastic material; the content decides the kind.

    Tables: relaxation (time, modulus), DMA (frequency, storage or complex modulus, loss modulus, loss tangent or loss
    angle; or temperature and these moduli at one frequency), creep (time, compliance), shift factors (temperature,
    log aT or aT), Prony terms (relaxation time, modulus or relative modulus). Exports of TRIOS (text, JSON),
    RheoCompass, RepTate and pyvisco. Decks: ANSYS with ``TB,PRON``, Abaqus with ``*VISCOELASTIC, TIME=PRONY``.

    Parameters
    ----------
    path
        The file: text in UTF-8, UTF-16 or Latin-1, or a workbook (.xlsx, with the extra ``restitution[excel]``).
    name
        Which material of a deck that has several: its NAME in Abaqus, its number in ANSYS.

    Returns
    -------
    RelaxationTable, DynamicTable, CreepTable, Isotherms, TemperatureRamp, PronyTerms, ShiftTable or ViscoelasticDeck
        In SI. `Isotherms` are moduli at several temperatures, a `TemperatureRamp` has one frequency alone.

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
    return parse(decoded(str(path), content), str(path), name=name)


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


def read_sheets(source: str, text: str) -> list[Sheet]:
    """Return sheets of a text in the first format that it has; `source` is its name in messages."""
    return next(sheets for has, sheets in FORMATS if has(text))(source, text)


def read_workbook(source: str, content: bytes) -> list[Sheet]:
    """Return sheets of a workbook (.xlsx); those without a table are left out."""
    tables: list[Sheet] = []
    refused: list[FileError] = []
    for name, text in _worksheets(source, content):
        try:
            sheets = read_sheets(source, text)
        except FileError as error:
            refused.append(error.moved(f"{source}, sheet {name!r}", "row"))
            continue
        where = f"{source}, sheet {name!r}"
        tables += [replace(sheet, source=where, place="row", title=sheet.title or name) for sheet in sheets]
    if not tables:
        raise refused[0] if refused else FileError(source, 0, "holds no numbers")
    return tables


def _worksheets(source: str, content: bytes) -> Iterator[tuple[str, str]]:
    """Return names of the worksheets, and their cells as lines of text with tabs between them."""
    if not content.startswith(b"PK"):
        raise FileError(source, 0, "cannot be read: is a workbook of the old kind (.xls); save it as .xlsx or CSV")
    try:
        excel: Any = import_module("openpyxl")
    except ImportError:
        advice = 'save its sheet as CSV, or install openpyxl by pip install "restitution[excel]"'
        raise FileError(source, 0, f"cannot be read: is a workbook; {advice}") from None
    try:
        with zipfile.ZipFile(BytesIO(content)) as archive:
            if sum(part.file_size for part in archive.infolist()) > _LARGEST:
                raise FileError(source, 0, f"cannot be read: must hold at most {_LARGEST // 1_000_000} MB")
        book = excel.load_workbook(BytesIO(content), read_only=True, data_only=True)
        for sheet in book.worksheets:
            # The stated size may be wrong.
            sheet.reset_dimensions()
            rows = [[*map(_cell, row)] for row in sheet.iter_rows(max_row=_MOST_ROWS, values_only=True)]
            width = max(map(len, rows), default=0)
            if width * len(rows) > _MOST_CELLS:
                raise FileError(source, 0, f"sheet {sheet.title!r}: must hold at most {_MOST_CELLS} cells")
            # An empty row stays a line, so that the numbers of lines are those of rows.
            yield sheet.title, "\n".join("\t".join(row + [""] * (width - len(row))) for row in rows)
    except FileError:
        raise
    except Exception as error:  # a damaged workbook raises errors of many unrelated types
        raise FileError(source, 0, f"is a damaged workbook ({type(error).__name__}): save its sheet as CSV") from None


def _cell(value: Any) -> str:
    """Return the text of a value in one cell."""
    if value is None:
        return ""
    return repr(value) if isinstance(value, float) else " ".join(str(value).split())


def _celsius(text: str) -> float | None:
    """Return the temperature [K] that a title states in °C."""
    match = _CELSIUS.search(text[:500])
    return None if match is None else float(match[1].replace(",", ".")) + ZERO_CELSIUS


def _trios_text(source: str, text: str) -> list[Sheet]:
    """Return steps of a TRIOS export to LIMS or CSV, with or without a word at the start of each line."""
    lines = split_lines(text, " ")
    starts = [i for i, line in enumerate(lines) if line.text[:200].strip("\t,; ").lower() == "[step]"]
    sheets: list[Sheet] = []
    for begin, end in pairwise([*starts, len(lines)] if starts else [-1, len(lines)]):
        sheet = _trios_step(source, lines[begin + 1 : end])
        sheets += [] if sheet is None else [sheet]
    if not sheets:
        raise FileError(source, lines[starts[0]].number if starts else 0, "must have a step with data points")
    return sheets


def _trios_step(source: str, lines: list[Line]) -> Sheet | None:
    names = next((i for i, line in enumerate(lines) if line.text[:10].lower() == "variables\t"), None)
    # Another section, such as an analysis, may follow.
    last = next((i for i, line in enumerate(lines) if line.text.startswith("[") and i > (names or 0)), len(lines))
    heads = (line.text.partition("\t") for line in lines[: 12 if names is None else names])
    keyed = {key.strip().lower(): value for key, _, value in heads}
    if names is None:
        title, table = lines[0].text if lines else "", lines[1:last]
    else:
        title = keyed.get("step name", "")
        table = [Line(n, line.partition("\t")[2]) for n, line in lines[names:last]]
    mark = next((sign for sign in "\t;," if table and sign in table[0].text), "")
    if len(table) < 2 or not mark:
        return None
    sheet = replace(read_sheet(source, table, mark=mark), temperature=_celsius(title))
    return _titled(sheet, title.strip("\t,; ") or "step", keyed.get("number of points", "").strip())


def _titled(sheet: Sheet, title: str, points: str) -> Sheet:
    """Return the sheet of a step, with a remark if its file states another number of points."""
    rows = str(len(sheet.rows))
    remarks = (f"{title}: {rows} of {points} points",) if points.isdecimal() and points != rows else ()
    return replace(sheet, title=title, remarks=remarks)


def _trios_json(source: str, text: str) -> list[Sheet]:
    """Return steps of a TRIOS export to JSON: of its schema, with rows by name, or with lists of values."""
    try:
        content = json.loads(text)
    except json.JSONDecodeError as error:
        raise FileError(source, error.lineno, f"{error.msg}: must be JSON") from None
    except (RecursionError, ValueError):  # a number of too many digits
        raise FileError(source, 0, "cannot be read: must be JSON of a rheometer") from None
    try:
        return [sheet for part in _json_tables(content) if (sheet := _json_sheet(source, *part)) is not None]
    except (AttributeError, KeyError, TypeError, IndexError):
        rule = "must have Results with ColumnHeaders and Rows, or DataSet with columns and values"
        raise FileError(source, 0, f"is no export of TRIOS: {rule}") from None


_JsonTable = tuple[str, list[tuple[str, str | None]], list[list[Any]]]


def _json_tables(content: Any) -> Iterator[_JsonTable]:
    """Return the title, names and units of the columns, and rows of each step."""
    results = content.get("Experiment", content)["Results"]
    if isinstance(results, list):
        for result in results:
            for part in result["DataSet"]:
                columns = [(str(each["name"]), each.get("unit") or None) for each in part["Data"]["columns"]]
                title = (result.get("Properties") or {}).get("Name") or "step"
                yield str(title), columns, part["Data"]["values"]
        return
    data = results.get("Processed") or next(iter(results.values()))
    headers = data["ColumnHeaders"]
    columns = [(str(header["DisplayName"]), (header.get("Unit") or {}).get("Name")) for header in headers.values()]
    titles = {step["Id"]: str(step["Name"]) for step in data.get("ResultsSteps", [])}
    steps: dict[Any, list[list[Any]]] = {}
    for row in data["Rows"]:
        steps.setdefault(row.get("Results Step Id"), []).append([row.get(key) for key in headers])
    for step, rows in steps.items():
        yield titles.get(step) or "step", columns, rows


def _json_sheet(source: str, title: str, columns: list[tuple[str, str | None]], rows: list[list[Any]]) -> Sheet | None:
    if not rows:
        return None
    if any(len(row) != len(columns) for row in rows):
        raise FileError(source, 0, f"{title}: each row must have {len(columns)} values")
    labels, units = [name for name, _ in columns], [unit and str(unit) for _, unit in columns]
    lines = [Line(n, "\t".join(map(_cell, row))) for n, row in enumerate(rows, 1)]
    return Sheet(
        f"{source}, {title}", labels, units, 0, 0, lines, "\t", title=title, temperature=_celsius(title), place="row"
    )


def _rheocompass(source: str, text: str) -> list[Sheet]:
    """Return intervals of an export of RheoCompass, in English or German.

    What lines with other keys state holds for the intervals below.
    """
    lines = [line for line in split_lines(text, " ") if line.text.strip(",;\t ")]
    keys = [(i, key) for i, line in enumerate(lines) if (key := _KEY.match(line.text))]
    sheets: list[Sheet] = []
    title, kelvin, points = "", None, list[str]()
    ends = [*(i for i, _ in keys), len(lines)][1:]
    for (i, key), end in zip(keys, ends, strict=True):
        rest = lines[i].text[key.end() :]
        match key[1].lower():
            case "interval data" | "intervalldaten" if end > i + 1:
                mark = rest[:1] or "\t"
                rows = [Line(n, row.removeprefix(mark)) for n, row in lines[i + 1 : end]]
                sheet = read_sheet(source, [Line(lines[i].number, rest[1:]), *rows], mark=mark)
                number, count = points or (str(len(sheets) + 1), "")
                sheets.append(_titled(replace(sheet, temperature=kelvin), f"{title or 'interval'} {number}", count))
            case "result" | "ergebnis":
                title, kelvin = rest[1:].strip('\t,; "'), _celsius(rest)
            case "project" | "projekt" | "test" | "versuch":
                title, kelvin = "", _celsius(rest)
            case "temperature" | "temperatur":
                kelvin = _celsius(rest)
            case "interval and data points" | "intervall und datenpunkte":
                points = [*(cell.strip(' "') for cell in re.split(r"[\t,;]", rest[1:])), ""][:2]
            case _:
                pass
    if not sheets:
        raise FileError(source, 0, "must have an interval with data")
    return sheets


def _is_reptate(text: str) -> bool:
    first = text.lstrip().partition("\n")[0].strip()
    parts = [part for part in first[:2000].split(";") if part.strip()]
    return ";" in first and all(re.match(r"\s*[A-Za-z]\w*\s*=", part) for part in parts) and bool(parts)


def _reptate(source: str, text: str) -> list[Sheet]:
    """Return the table of RepTate: parameters, perhaps names and units, then rows of omega, G', G'' or of t, G."""
    header, *lines = split_lines(text)
    parameters = {key.strip(): value.strip() for key, _, value in (p.partition("=") for p in header.text.split(";"))}
    rows = [(line.number, line.text.split()) for line in lines if not line.text.startswith("#")]
    units: list[str | None] = ["rad/s", "Pa", "Pa"]
    while rows and not is_number(rows[0][1][0]):
        # A column without a unit is a blank between tabs, but not among the first three.
        if len(rows[0][1]) > 2 and None not in map(unit, rows[0][1][:2]):
            units = [*rows[0][1][:3]]
        rows = rows[1:]
    if not rows:
        raise FileError(source, header.number, "is followed by no numbers")
    relaxation = source.lower().endswith(".gt") or len(rows[0][1]) == 2
    labels = ["t", "G(t)"] if relaxation else ["omega", "G'", "G''"]
    if relaxation:
        units = [None if name == "rad/s" else name for name in units[:2]]
    for number, cells in rows:
        if len(cells) < len(labels):
            raise FileError(source, number, f"{len(cells)} values: must be {len(labels)}, {', '.join(labels)}")
    kelvin = None
    if "T" in parameters:
        if not is_number(parameters["T"]):
            raise FileError(source, header.number, f"T = {parameters['T'][:40]!r}: must be a temperature in °C")
        kelvin = float(parameters["T"].replace(",", ".")) + ZERO_CELSIUS
    lines = [Line(number, "\t".join(cells[: len(labels)])) for number, cells in rows]
    line = header.number
    return [Sheet(source, labels, units, line, line, lines, "\t", temperature=kelvin, scattered=True)]


def _plain(source: str, text: str) -> list[Sheet]:
    """Return the table of named columns."""
    return [read_sheet(source, split_lines(text, " "))]


FORMATS: Sequence[tuple[Callable[[str], Any], Callable[[str, str], list[Sheet]]]] = (
    (re.compile(r"[\ufeff \t\r\n]*\{").match, _trios_json),
    (re.compile(r"^(\[step\]|Variables\t)", re.IGNORECASE | re.MULTILINE).search, _trios_text),
    (re.compile(r"^\W?(Interval data|Intervalldaten):", re.IGNORECASE | re.MULTILINE).search, _rheocompass),
    (_is_reptate, _reptate),
    (lambda text: True, _plain),
)
"""Whether a text has a format, and the sheets of such a text."""


def _content(source: str, sheets: list[Sheet]) -> MaterialFile:
    """Return the material data of sheets: that of the only one, or the sweeps of several."""
    tables = [Table.of(sheet) for sheet in sheets]
    curves_read: list[Curve] = []
    unused: list[str] = []
    for table in tables:
        curves = _curves(table)
        curves_read += curves
        unused += [] if curves else [table.sheet.title]
    if curves_read:
        return _joined(source, curves_read, unused)
    for read_one in (_creep, _ramp):
        if (only := read_one(source, tables)) is not None:
            return only
    if len(tables) == 1:
        for kind in (_prony_terms, _shift_table):
            if (content := kind(tables[0])) is not None:
                return content
    if len(tables) == 1 and not unused[0]:
        sheet = tables[0].sheet
        message = f"columns {', '.join(filter(None, sheet.labels))[:200]}: must be time and relaxation modulus; "
        message += "frequency, storage and loss modulus; time and creep compliance; relaxation time and modulus; or "
        message += "temperature and shift factor"
        raise tables[0].error(message, sheet.header_line)
    titles = ", ".join(unused)[:200]
    rule = "one must have several frequencies with storage and loss modulus, or times with the relaxation modulus"
    raise FileError(source, 0, f"{titles or 'no step'}: {rule}")


def _joined(source: str, curves: list[Curve], unused: list[str]) -> Curve | Isotherms:
    """Return the only sweep, or one at each temperature. Sweeps at one temperature are averaged."""
    kind = DynamicTable if any(isinstance(curve, DynamicTable) for curve in curves) else RelaxationTable
    alike = [curve for curve in curves if isinstance(curve, kind)]
    notes = [f"not used: {', '.join(unused)[:200]}"] if unused else []
    notes += [f"{len(curves) - len(alike)} relaxations are not used"] if len(alike) < len(curves) else []
    if len(alike) > 1 and any(curve.temperature is None for curve in alike):
        raise FileError(source, 0, f"holds {len(alike)} sweeps: the temperature of each must be stated, or one kept")
    groups: list[list[Curve]] = []
    for curve in sorted(alike, key=lambda curve: curve.temperature or 0.0):
        if groups and (curve.temperature or 0.0) - (groups[-1][0].temperature or 0.0) < _SAME_TEMPERATURE:
            groups[-1].append(curve)
        else:
            groups.append([curve])
    for group in groups:
        if len(group) > 1:
            notes.append(f"{len(group)} sweeps at {(group[0].temperature or 0.0) - ZERO_CELSIUS:.1f} °C are averaged")
    tables = [average(group) if len(group) > 1 else group[0] for group in groups]
    remarks = tuple(dict.fromkeys([*(note for curve in alike for note in curve.notes), *notes]))
    if len(tables) == 1:
        return replace(tables[0], source=source, notes=remarks)
    return Isotherms(tables, source=source, notes=remarks)


def _curves(table: Table) -> list[Curve]:
    """Return sweeps of one table: a single one, or one at each temperature; none if it has not the columns."""
    read, columns = _dynamic, table.columns((Role.ANGULAR_FREQUENCY, Role.FREQUENCY), *_moduli(table))
    if columns and _is_ramp(table, columns[0].values):
        return []
    if not columns:
        read, columns = _relaxation, table.columns((Role.TIME,), (Role.MODULUS,))
        # Steps of creep and flow have times and a "modulus" as well.
        title = table.sheet.title.lower()
        if not columns or (title and "relax" not in title and columns[1].label.lower() == "modulus"):
            return []
    x = columns[0].values
    if table.sheet.title and (not x.size or np.ptp(x) <= 1e-3 * x.max()):
        return []  # a sweep of amplitudes or temperatures
    sweeps = _sweeps(table, x)
    if len(sweeps) == 1:
        return [read(table, columns, several=False)]
    return [
        read(table.part(rows), [column._replace(values=column.values[rows]) for column in columns], several=True)
        for rows in sweeps
    ]


def _moduli(table: Table) -> tuple[tuple[Role, ...], tuple[Role, ...]]:
    """Return the columns that may hold the complex modulus."""
    loss = (Role.LOSS, Role.TANGENT) if Role.STORAGE in table.roles else (Role.TANGENT, Role.LOSS)
    return (Role.STORAGE, Role.COMPLEX), (*loss, Role.ANGLE)


def _is_ramp(table: Table, omega: Array) -> bool:
    """Return whether the temperature changes from row to row at one frequency."""
    if omega.size < 2 or np.ptp(omega) > _SAME_FREQUENCY * omega.max() or Role.TEMPERATURE not in table.roles:
        return False
    column = table.temperature
    return column is not None and float(np.ptp(column.values)) > _SAME_TEMPERATURE


def _ramp(source: str, tables: Sequence[Table]) -> TemperatureRamp | None:
    """Return the only temperature ramp; None without one."""
    ramps: list[tuple[Table, list[Column]]] = []
    for table in tables:
        if table.temperature is None or not (columns := table.columns((Role.TEMPERATURE,), *_moduli(table))):
            continue
        frequency = table.columns((Role.ANGULAR_FREQUENCY, Role.FREQUENCY))
        if not frequency or _is_ramp(table, frequency[0].values):
            ramps.append((table, [*columns, *frequency]))
    if len(ramps) > 1:
        raise FileError(source, 0, "holds several temperature ramps: must have one")
    if not ramps:
        return None
    table, (kelvin, first, second, *frequency) = ramps[0]
    storage, loss = _complex_modulus(table, first, second)
    omega = float(frequency[0].values.mean()) if frequency else None
    deformation, where, notes = table.about(kelvin, first, second, *frequency)
    # Rows of one temperature, and a furnace that overshoots, are no steps of the ramp.
    order = np.unique(kelvin.values, return_index=True)[1]
    if order.size < _FEWEST:
        raise table.error(f"{kelvin.label}: must have at least {_FEWEST} temperatures", table.sheet.header_line)
    columns = (kelvin.values[order], storage[order], loss[order])
    return TemperatureRamp(*columns, omega, deformation, where, notes)


def _creep(source: str, tables: Sequence[Table]) -> CreepTable | None:
    """Return the only creep test; None without one."""
    tests = [(table, columns) for table in tables if (columns := table.columns((Role.TIME,), (Role.COMPLIANCE,)))]
    tests = [(table, columns) for table, columns in tests if "recover" not in table.sheet.title.lower()]
    if not tests:
        return None
    if len(tests) > 1 or len(_sweeps(tests[0][0], tests[0][1][0].values)) > 1:
        raise FileError(source, 0, "holds several creep tests: must have one")
    table, columns = tests[0]
    compliance = columns[1].values
    creep: Any = _curve(CreepTable, table, columns, (compliance,), 1.0 / compliance, "rise over time", several=False)
    return creep


def _sweeps(table: Table, x: Array) -> list[NDArray[np.intp]]:
    """Return the rows of each sweep over frequency or time: by number, by turns of the order, or by temperature."""
    every = [np.arange(x.size)]
    if table.sheet.scattered or x.size < 2:
        return every
    if numbers := table.columns((Role.SWEEP,)):
        return [np.flatnonzero(numbers[0].values == number) for number in np.unique(numbers[0].values)]
    # A table of one sweep may lack units of its temperatures, which are not needed.
    if Role.TEMPERATURE not in table.roles:
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
    """Return the mean temperature [K] of a sweep, and the columns that it needs."""
    stated = Role.TEMPERATURE in table.roles and table.sheet.units[table.roles.index(Role.TEMPERATURE)] is not None
    column = table.temperature if stated or several else None
    numbers = table.columns((Role.SWEEP,)) if several else []
    if column is None:
        return table.sheet.temperature, numbers
    return float(column.values.mean()), [column, *numbers]


def _dynamic(table: Table, columns: list[Column], *, several: bool) -> Curve:
    _, first, second = columns
    storage, loss = _complex_modulus(table, first, second)
    softness = 1.0 / np.maximum(storage, 1e-300)
    return _curve(DynamicTable, table, columns, (storage, loss), softness, "rise over frequency", several)


def _complex_modulus(table: Table, first: Column, second: Column) -> tuple[Array, Array]:
    """Return storage and loss modulus [Pa] of two columns."""
    storage, loss = first.values, second.values
    # What overflows is refused below, and so is an angle beyond 90 degrees.
    with np.errstate(over="ignore", invalid="ignore"):
        tangent = np.tan(loss) if second.role is Role.ANGLE else loss
        is_ratio = second.role in (Role.ANGLE, Role.TANGENT)
        if first.role is Role.COMPLEX:
            share = tangent / np.hypot(1.0, tangent) if is_ratio else np.minimum(loss / storage, 1.0)
            loss = storage * share
            storage = storage * np.sqrt((1.0 - share) * (1.0 + share))
        elif is_ratio:
            loss = storage * tangent
    good = np.isfinite(loss) & (loss >= 0.0) & (storage > 0.0)
    if second.role is Role.ANGLE:
        good &= second.values < 0.5 * math.pi
    if not good.all():
        rule = f"{first.label}, {second.label}: must give a storage modulus > 0 and a finite loss modulus >= 0"
        raise table.error(rule, row=int(np.argmin(good)))
    return storage, loss


def _relaxation(table: Table, columns: list[Column], *, several: bool) -> Curve:
    modulus = columns[1].values
    return _curve(RelaxationTable, table, columns, (modulus,), modulus, "fall over time", several)


def _curve(
    kind: type[Any], table: Table, columns: list[Column], moduli: Sequence[Array], falling: Array, rule: str,
    several: bool,
) -> Curve:  # fmt: skip
    """Return the sweep of a kind in ascending order; its second column must not let `falling` grow."""
    order = slice(None)
    if not table.sheet.scattered:
        order = table.order(columns[0])
        table.refuse_growth(columns[1], falling, order, rule)
    kelvin, others = _temperature(table, several)
    about = table.about(*columns, *others)
    values = (column[order] for column in (columns[0].values, *moduli))
    curve: Any = kind(*values, *about, temperature=kelvin)
    return average([curve]) if table.sheet.scattered else curve


def _prony_terms(table: Table) -> PronyTerms | None:
    columns = table.columns((Role.RELAXATION_TIME,), (Role.BRANCH, Role.SHARE))
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
        if scale is None or scale.dimension != MODULUS:
            raise table.error(f"{match[0]!r}: must end in a unit of modulus, such as Pa, MPa", place)
        try:
            ends["high" if match[1] == "0" else "low"] = scale.si(float(match[2]))
        except ValueError:
            raise table.error(f"{match[0]!r}: must hold a number", place) from None
        deformation = deformation or ("tension" if match[0][0] in "eE" else "shear")
    relative, moduli = terms.role is Role.SHARE, terms.values
    if relative and (beyond := beyond_one(moduli)) is not None:
        rule = f"the values of {terms.label} add up to {moduli.sum():.6g}: must be at most 1"
        raise table.error(rule, row=beyond)
    prony = PronyTerms(times.values, moduli, relative, deformation, ends.get("high"), ends.get("low"), source, notes)
    if ends:
        try:
            prony.series()
        except InputError as error:
            raise table.error(str(error), place) from None
    return prony


def _shift_table(table: Table) -> ShiftTable | None:
    columns = table.columns((Role.TEMPERATURE,), (Role.LOG_SHIFT, Role.SHIFT))
    if not columns:
        return None
    temperature, shift = columns
    kelvin = temperature.values
    logs = shift.values if shift.role is Role.LOG_SHIFT else np.log10(shift.values)
    if kelvin[0] > kelvin[-1]:
        kelvin, logs = kelvin[::-1], logs[::-1]
    try:
        return ShiftTable(kelvin, logs, notes=table.about(temperature, shift)[2])
    except InputError as error:
        raise table.error(str(error), row=0) from None
