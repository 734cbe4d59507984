"""Formats of the files of rheometers and fitting programs; each is known by its content and becomes sheets."""

from __future__ import annotations

import json
import re
import zipfile
from collections.abc import Callable, Iterable, Iterator
from importlib import import_module
from io import BytesIO
from itertools import pairwise
from typing import Any, NamedTuple

from restitution.material.roles import is_name, is_unit
from restitution.material.sheet import FileError, Line, Sheet, is_number, read_lines, read_sheet, split_lines

_ZERO_CELSIUS = 273.15
# Measured files are smaller; more would only cost memory.
_LARGEST = 200_000_000
_MOST_ROWS = 100_000
_MOST_CELLS = 5_000_000
_CELSIUS = re.compile(r"(?<![\w.,])(-?\d{1,4}(?:[.,]\d{1,6})?)\s?°C")


class Format(NamedTuple):
    """Format of files: whether a text has it, and the sheets of such a text."""

    name: str
    has: Callable[[str], bool]
    sheets: Callable[[str, str], list[Sheet]]


def read_sheets(source: str, text: str) -> list[Sheet]:
    """Sheets of a text in the first format that it has; `source` is its name in messages."""
    return next(one for one in FORMATS if one.has(text)).sheets(source, text)


def read_workbook(source: str, content: bytes) -> list[Sheet]:
    """Sheets of a workbook (.xlsx); those without a table are left out."""
    found: list[Sheet] = []
    refused: list[FileError] = []
    for name, text in _worksheets(source, content):
        try:
            sheets = read_sheets(source, text)
        except FileError as error:
            refused.append(error.moved(f"{source}, sheet {name!r}", "row"))
            continue
        found += [sheet._replace(source=f"{source}, sheet {name!r}", place="row", title=sheet.title or name)
                  for sheet in sheets]  # fmt: skip
    if not found:
        raise refused[0] if refused else FileError(source, 0, "holds no numbers")
    return found


def _worksheets(source: str, content: bytes) -> Iterator[tuple[str, str]]:
    """Names of the worksheets, and their cells as lines of text with tabs between them."""
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
    """Text of a value in one cell."""
    if value is None:
        return ""
    return repr(value) if isinstance(value, float) else " ".join(str(value).split())


def _celsius(text: str) -> float | None:
    """Temperature [K] that a title states in °C."""
    found = _CELSIUS.search(text[:500])
    return None if found is None else float(found[1].replace(",", ".")) + _ZERO_CELSIUS


def _is_trios_text(text: str) -> bool:
    return bool(re.search(r"^(\[step\]|Variables\t)", text, re.IGNORECASE | re.MULTILINE))


def _trios_text(source: str, text: str) -> list[Sheet]:
    """Steps of a TRIOS export to LIMS or CSV, with or without a word at the start of each line."""
    lines = split_lines(text, "\r\n ")
    starts = [i for i, line in enumerate(lines) if line.text[:200].strip("\t,; ").lower() == "[step]"]
    found: list[Sheet] = []
    for begin, end in pairwise([*starts, len(lines)] if starts else [-1, len(lines)]):
        sheet = _trios_step(source, lines[begin + 1 : end])
        found += [] if sheet is None else [sheet]
    if not found:
        raise FileError(source, lines[starts[0]].number if starts else 0, "must have a step with data points")
    return found


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
    mark = next((one for one in "\t;," if table and one in table[0].text), "")
    if len(table) < 2 or not mark:
        return None
    sheet = read_lines(source, table, is_unit, is_name, mark)
    points = keyed.get("number of points", "").strip()
    short = points.isdecimal() and points != str(len(sheet.lines))
    remarks = (f"{title}: {len(sheet.lines)} of {points} points",) if short else ()
    return sheet._replace(title=title.strip("\t,; ") or "step", temperature=_celsius(title), remarks=remarks)


def _is_trios_json(text: str) -> bool:
    return text.lstrip("\ufeff \t\r\n").startswith("{")


def _trios_json(source: str, text: str) -> list[Sheet]:
    """Steps of a TRIOS export to JSON: of its schema, with rows by name, or with lists of columns and values."""
    try:
        content = json.loads(text)
    except json.JSONDecodeError as error:
        raise FileError(source, error.lineno, f"{error.msg}: must be JSON") from None
    except (RecursionError, ValueError):  # a number of too many digits
        raise FileError(source, 0, "cannot be read: must be JSON of a rheometer") from None
    try:
        return [one for part in _json_tables(content) if (one := _json_sheet(source, *part)) is not None]
    except (AttributeError, KeyError, TypeError, IndexError):
        wanted = "must have Results with ColumnHeaders and Rows, or DataSet with columns and values"
        raise FileError(source, 0, f"is no export of TRIOS: {wanted}") from None


_JsonTable = tuple[str, list[tuple[str, str | None]], list[list[Any]]]


def _json_tables(content: Any) -> Iterator[_JsonTable]:
    """Title, names and units of the columns, and rows of each step."""
    results = content.get("Experiment", content)["Results"]
    if isinstance(results, list):
        for result in results:
            for one in result["DataSet"]:
                columns = [(str(each["name"]), each.get("unit") or None) for each in one["Data"]["columns"]]
                title = (result.get("Properties") or {}).get("Name") or "step"
                yield str(title), columns, one["Data"]["values"]
        return
    data = results.get("Processed") or next(iter(results.values()))
    headers = data["ColumnHeaders"]
    columns = [(str(one["DisplayName"]), (one.get("Unit") or {}).get("Name")) for one in headers.values()]
    titles = {one["Id"]: str(one["Name"]) for one in data.get("ResultsSteps", [])}
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
    cells = [[_cell(row[i]) for row in rows] for i in range(len(columns))]
    labels, units = [name for name, _ in columns], [None if one is None else str(one) for _, one in columns]
    numbers = list(range(1, len(rows) + 1))
    return Sheet(f"{source}, {title}", labels, units, 0, 0, cells, numbers, [], title, _celsius(title), place="row")


_INTERVAL = re.compile(r"^\W?Interval data:", re.IGNORECASE | re.MULTILINE)


def _rheocompass(source: str, text: str) -> list[Sheet]:
    """Intervals of an export of RheoCompass."""
    found: list[Sheet] = []
    title, kelvin, points, table = "", None, "", list[Line]()

    def finish() -> None:
        if len(table) > 1:
            sheet = read_lines(source, table, is_unit, is_name, mark)
            interval = f"{title or 'interval'} {points[0] if points else len(found) + 1}"
            short = len(points) > 1 and points[1].isdecimal() and points[1] != str(len(sheet.lines))
            remarks = (f"{interval}: {len(sheet.lines)} of {points[1]} points",) if short else ()
            found.append(sheet._replace(title=interval, temperature=kelvin, remarks=remarks))
        table.clear()

    mark = ""
    for line in split_lines(text, "\r\n "):
        if not line.text.strip(",;\t "):
            continue
        first = re.match(r'"?([A-Za-z][^\t,;:"]{0,60}):"?(?=[\t,;]|$)', line.text)
        if first is None:
            if table:
                table.append(Line(line.number, line.text.removeprefix(mark)))
            continue
        key, rest = first[1].lower(), line.text[first.end() :]
        if key == "interval data":
            finish()
            mark = rest[:1] or "\t"
            table.append(Line(line.number, rest[1:]))
            continue
        finish()
        cells = [cell.strip(' "') for cell in re.split(r"[\t,;]", rest[1:])]
        if key in ("project", "test", "result"):
            title, kelvin = rest[1:].strip('\t,; "') if key == "result" else "", _celsius(rest)
        elif key == "temperature":
            kelvin = _celsius(rest)
        elif key == "interval and data points":
            points = cells
    finish()
    if not found:
        raise FileError(source, 0, "must have an interval with data")
    return found


def _is_reptate(text: str) -> bool:
    first = text.lstrip().partition("\n")[0].strip()
    parts = [part for part in first[:2000].split(";") if part.strip()]
    return ";" in first and all(re.match(r"\s*[A-Za-z]\w*\s*=", part) for part in parts) and bool(parts)


def _reptate(source: str, text: str) -> list[Sheet]:
    """Table of RepTate: a line of parameters, perhaps names and units, then rows of omega, G', G'' or of t, G."""
    header, *lines = split_lines(text)
    parameters = {key.strip(): value.strip() for key, _, value in (p.partition("=") for p in header.text.split(";"))}
    rows = [(line.number, line.text.split()) for line in lines if not line.text.startswith("#")]
    units: list[str | None] = ["rad/s", "Pa", "Pa"]
    while rows and not is_number(rows[0][1][0]):
        # A column without a unit is a blank between tabs, but not among the first three.
        if len(rows[0][1]) > 2 and all(map(is_unit, rows[0][1][:2])):
            units = [*rows[0][1][:3]]
        rows = rows[1:]
    if not rows:
        raise FileError(source, header.number, "is followed by no numbers")
    relaxation = source.lower().endswith(".gt") or len(rows[0][1]) == 2
    labels = ["t", "G(t)"] if relaxation else ["omega", "G'", "G''"]
    if relaxation:
        units = [None if unit == "rad/s" else unit for unit in units[:2]]
    for number, cells in rows:
        if len(cells) < len(labels):
            raise FileError(source, number, f"{len(cells)} values: must be {len(labels)}, {', '.join(labels)}")
    cells = [[row[i] for _, row in rows] for i in range(len(labels))]
    kelvin = None
    if "T" in parameters:
        if not is_number(parameters["T"]):
            raise FileError(source, header.number, f"T = {parameters['T'][:40]!r}: must be a temperature in °C")
        kelvin = float(parameters["T"]) + _ZERO_CELSIUS
    numbers = [number for number, _ in rows]
    return [Sheet(source, labels, units, header.number, header.number, cells, numbers, [], temperature=kelvin,
                  scattered=True)]  # fmt: skip


def _plain(source: str, text: str) -> list[Sheet]:
    return [read_sheet(source, text, is_unit, is_name)]


FORMATS: Iterable[Format] = (
    Format("TRIOS, JSON", _is_trios_json, _trios_json),
    Format("TRIOS, text", _is_trios_text, _trios_text),
    Format("RheoCompass", lambda text: bool(_INTERVAL.search(text)), _rheocompass),
    Format("RepTate", _is_reptate, _reptate),
    Format("table of named columns", lambda text: True, _plain),
)
