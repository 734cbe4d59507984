"""Columns of a CSV file: one header line that names the quantities and their units, numbers below."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from restitution.case.quantity import Kind, to_si

T = TypeVar("T")


def read_columns(folder: str | Path, name: str, kinds: Mapping[str, Kind]) -> dict[str, NDArray[np.float64]]:
    """Read the columns of a CSV file.

    The header names each quantity once, in any order, with its unit behind an underscore or in brackets, e.g.
    ``r_um,f [nm]``, or in SI. Empty lines and lines that begin with # are passed over.

    Parameters
    ----------
    folder : str or Path
        Folder that a relative name starts from.
    name : str
        Name of the file.
    kinds : mapping
        Name and kind of each column.

    Returns
    -------
    dict
        A column in SI for each name.

    Raises
    ------
    ValueError
        If the file cannot be read or is malformed; one line, with the number of the line to blame.
    """
    path = Path(folder, name)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise ValueError(f"no such file: {path}") from None
    except OSError as error:
        raise ValueError(f"cannot be read: {error.strerror}") from None
    except ValueError:
        raise ValueError("cannot be read: not a text file in UTF-8") from None
    lines = [
        (n, line)
        for n, line in enumerate(text.splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if len(lines) < 2:
        raise ValueError("holds no numbers")
    columns = _at(lines[0], lambda header: _header(header, kinds))
    rows = [_at(line, lambda text: _row(text, columns)) for line in lines[1:]]
    return dict(zip((column for column, _ in columns), np.array(rows).T, strict=True))


def _at(line: tuple[int, str], read: Callable[[str], T]) -> T:
    number, text = line
    try:
        return read(text)
    except ValueError as error:
        raise ValueError(f"line {number}: {error}") from None


def _header(header: str, kinds: Mapping[str, Kind]) -> list[tuple[str, float]]:
    """Name of each column and the factor that takes it to SI."""
    columns = [_column(cell, kinds) for cell in next(csv.reader([header]))]
    if sorted(name for name, _ in columns) != sorted(kinds):
        raise ValueError(f"must name {len(kinds)} columns, {' and '.join(kinds)}")
    return columns


def _column(cell: str, kinds: Mapping[str, Kind]) -> tuple[str, float]:
    match = re.fullmatch(rf"\s*({'|'.join(kinds)})\s*(?:_(.+)|\[(.*)\])?\s*", cell)
    if match is None:
        raise ValueError(f"unknown column {cell.strip()!r}; known are {', '.join(kinds)}")
    kind, unit = kinds[match[1]], (match[2] or match[3] or "").strip()
    try:
        return match[1], 1.0 if unit in ("", "-", kind.unit) else to_si(f"1 {unit}", kind)
    except ValueError as error:
        raise ValueError(f"column {cell.strip()!r}: {error}") from None


def _row(line: str, columns: list[tuple[str, float]]) -> list[float]:
    cells = next(csv.reader([line]))
    if len(cells) != len(columns):
        raise ValueError(f"{len(cells)} values, {len(columns)} wanted")
    values: list[float] = []
    for cell, (name, factor) in zip(cells, columns, strict=True):
        try:
            value = float(cell) * factor
        except ValueError:
            raise ValueError(f"{name} = {cell.strip()}: must be a number") from None
        if not np.isfinite(value):
            raise ValueError(f"{name} = {cell.strip()}: must be finite")
        values.append(value)
    return values
