"""Columns of numbers in CSV files, with the units of their header."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path

import numpy as np

from restitution.checks import Array
from restitution.errors import InputError
from restitution.material.sheet import FileError, Sheet, decoded, read_bytes, read_sheet, split_lines
from restitution.quantities import Dimension
from restitution.units import to_si

# Symbols that stand for the names of columns.
_SYMBOLS = {"t": "time", "d": "depth", "F": "force"}


def read_columns(folder: str | Path, name: str, dimensions: Mapping[str, Dimension]) -> dict[str, Array]:
    """Read columns of a CSV file and return them in SI by name.

    The header names each quantity once, in any order, by its name or its symbol. Units stand behind an underscore or
    in brackets, as in ``r_um,f [nm]``, or in a second line, ``um,nm``. The rest is as in tables of materials.
    """
    sheet, names = open_sheet(folder, name)
    for label, column in zip(sheet.labels, names, strict=True):
        if column not in dimensions:
            raise FileError("", sheet.header_line, f"unknown column {label!r}; {_forms(dimensions)}")
    if sorted(names) != sorted(dimensions):
        raise FileError("", sheet.header_line, f"must name {len(dimensions)} columns; {_forms(dimensions)}")
    return {column: in_si(sheet, i, column, dimensions[column]) for i, column in enumerate(names)}


def named_columns(folder: str | Path, name: str) -> list[str]:
    """Return the names of the columns of a CSV file."""
    return open_sheet(folder, name)[1]


def open_sheet(
    folder: str | Path, name: str, known: Collection[str] = (), symbols: Mapping[str, str] = _SYMBOLS
) -> tuple[Sheet, list[str]]:
    """Return the table of a CSV file, and the names of its columns; `known` are names that contain an underscore."""
    path = Path(folder, name)
    try:
        text = decoded("", read_bytes(path))
    except FileError as error:
        raise InputError("", rule=f"{error.rule}: {path}" if folder else error.rule) from None
    lines = split_lines(text, " ")
    sheet = read_sheet("", lines, is_unit=lambda tail: True, is_name=lambda label: _plain(label) in known)
    labels = [_plain(label) if known else label for label in sheet.labels]
    return sheet, [symbols.get(label, label) for label in labels]


def in_si(sheet: Sheet, index: int, name: str, dimension: Dimension) -> Array:
    """Return the numbers of a column in SI; a number that is not finite is refused with its line."""
    unit = (sheet.units[index] or "").strip()
    zero, factor = 0.0, 1.0
    if unit not in ("", "-", dimension.unit):
        try:
            # Zero on the scale of degrees Celsius is not zero in SI.
            zero = to_si(f"0 {unit}", dimension)
            factor = to_si(f"1 {unit}", dimension) - zero
        except InputError as error:
            raise FileError("", sheet.unit_line, f"unit {unit!r} of {name}: {error}") from None
    with np.errstate(over="ignore"):
        values = sheet.numbers(index) * factor + zero
    sheet.require(np.isfinite(values), index, "must be finite", name)
    return values


def _plain(label: str) -> str:
    return label.strip().replace(" ", "_")


def _forms(dimensions: Mapping[str, Dimension]) -> str:
    """Return the headers that are understood."""
    units = {name: dimension.example.split()[-1] for name, dimension in dimensions.items()}
    behind = ",".join(f"{name}_{unit}" for name, unit in units.items())
    brackets = ",".join(f"{name} [{unit}]" for name, unit in units.items())
    return f'write e.g. "{behind}", "{brackets}", or "{",".join(units)}" and the units in a second line'
