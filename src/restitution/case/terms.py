"""Prony terms in a CSV file: one header line that names the columns and their units, one term a line."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from restitution.case.quantity import MODULUS, NUMBER, TIME, Kind, to_si

T = TypeVar("T")

_COLUMNS = {"relaxation_time": TIME, "branch_modulus": MODULUS, "relative_modulus": NUMBER}
_HEADER = re.compile(r"\s*(relaxation_time|branch_modulus|relative_modulus)\s*(?:_(.+)|\[(.*)\])?\s*")


class Terms(NamedTuple):
    """Terms of a Prony series; `relative` tells shares of an end modulus from moduli [Pa].

    Attributes
    ----------
    relaxation_times
        [s], shape (n_branch,).
    moduli
        [Pa] or [-], shape (n_branch,).
    relative
        Whether the moduli are shares.
    """

    relaxation_times: NDArray[np.float64]
    moduli: NDArray[np.float64]
    relative: bool


def read_terms(folder: str | Path, name: str) -> Terms:
    """Read the terms of a Prony series from a CSV file.

    The header names two columns: `relaxation_time`, and `branch_modulus` or `relative_modulus`, each with its
    unit behind an underscore or in brackets, e.g. ``relaxation_time_s,branch_modulus [MPa]``, or in SI.
    Empty lines and lines that begin with # are passed over.

    Parameters
    ----------
    folder : str or Path
        Folder that a relative name starts from.
    name : str
        Name of the file.

    Returns
    -------
    Terms
        In SI, in the order of the file.

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
    if not lines:
        raise ValueError("holds no terms")
    columns = _at(lines[0], _columns)
    rows = [_at(line, lambda text: _row(text, columns)) for line in lines[1:]]
    values = np.array(rows, dtype=np.float64).reshape(len(rows), 2)
    kinds = [kind for kind, _ in columns]
    times = kinds.index(TIME)
    return Terms(values[:, times], values[:, 1 - times], NUMBER in kinds)


def _at(line: tuple[int, str], read: Callable[[str], T]) -> T:
    number, text = line
    try:
        return read(text)
    except ValueError as error:
        raise ValueError(f"line {number}: {error}") from None


def _columns(header: str) -> list[tuple[Kind, float]]:
    columns = [_column(cell) for cell in next(csv.reader([header]))]
    if {kind for kind, _ in columns} not in ({TIME, MODULUS}, {TIME, NUMBER}) or len(columns) != 2:
        raise ValueError("must name two columns, relaxation_time and branch_modulus or relative_modulus")
    return columns


def _column(cell: str) -> tuple[Kind, float]:
    """Kind of quantity in a column and the factor that takes it to SI."""
    match = _HEADER.fullmatch(cell)
    if match is None:
        raise ValueError(f"unknown column {cell.strip()!r}; known are {', '.join(_COLUMNS)}")
    kind, unit = _COLUMNS[match[1]], (match[2] or match[3] or "").strip()
    try:
        return kind, 1.0 if unit in ("", "-", kind.unit) else to_si(f"1 {unit}", kind)
    except ValueError as error:
        raise ValueError(f"column {cell.strip()!r}: {error}") from None


def _row(line: str, columns: list[tuple[Kind, float]]) -> list[float]:
    cells = next(csv.reader([line]))
    if len(cells) != len(columns):
        raise ValueError(f"{len(cells)} values, {len(columns)} wanted")
    values: list[float] = []
    for cell, (kind, factor) in zip(cells, columns, strict=True):
        name = next(name for name, known in _COLUMNS.items() if known is kind)
        try:
            value = float(cell) * factor
        except ValueError:
            raise ValueError(f"{name} = {cell.strip()}: must be a number") from None
        if not (np.isfinite(value) and (value > 0 or (value == 0 and kind is not TIME))):
            raise ValueError(f"{name} = {cell.strip()}: must be finite and {'>' if kind is TIME else '>='} 0")
        values.append(value)
    return values
