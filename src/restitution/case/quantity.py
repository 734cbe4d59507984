"""Quantities with units: types of the fields of case files, and columns of CSV files."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator
from pydantic_core import core_schema

from restitution.case.section import split_list
from restitution.checks import Array
from restitution.errors import InputError
from restitution.material.models import Constant
from restitution.material.sheet import FileError, Sheet, decoded, read_bytes, read_sheet, split_lines
from restitution.quantities import CONSTANTS, INPUTS, SHIFTS, Quantity
from restitution.units import ANGLE, Dimension, to_si


@dataclass(frozen=True)
class Reader:
    """Annotation of a field that holds a quantity in SI: a number, or a text with a unit."""

    quantity: Quantity

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        return core_schema.no_info_wrap_validator_function(self._read, handler(source))

    def _read(self, value: Any, number: Callable[[Any], Any]) -> Any:
        dimension, plain = self.quantity.dimension, value
        if isinstance(value, np.ndarray):  # the axes of a sweep put arrays in SI into a case
            return self.quantity.check(value)
        if self.quantity.infinite and value == "incompressible":
            return math.inf
        if isinstance(value, str):
            plain = to_si(value, dimension)
        elif isinstance(value, int | float) and not isinstance(value, bool):
            try:
                plain = float(value)
            except OverflowError:
                plain = math.inf
        else:
            raise InputError("", rule=f"must be {dimension.article}; {dimension.advice}")
        try:
            return number(self.quantity.check(plain))
        except InputError as error:
            degrees = dimension is ANGLE and not isinstance(value, str) and 1.0 < plain <= 180.0
            hint = f'; write "{value:g} deg" for degrees' if degrees else ""
            raise InputError("", rule=error.rule + hint) from None

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> Any:
        return handler(schema) | {"unit": self.quantity.unit}


def of(name: str) -> Reader:
    """Read a registered quantity."""
    return Reader((CONSTANTS | INPUTS | SHIFTS)[name])


def positive(dimension: Dimension, words: str = "") -> Reader:
    """Read a quantity that is finite and > 0."""
    return Reader(Quantity("value", dimension, words, low=0.0, open=True))


def nonnegative(dimension: Dimension, words: str = "") -> Reader:
    """Read a quantity that is finite and >= 0."""
    return Reader(Quantity("value", dimension, words, low=0.0))


def within(dimension: Dimension, low: float, high: float, words: str = "") -> Reader:
    """Read a quantity in the closed interval [low, high]."""
    return Reader(Quantity("value", dimension, words, low=low, high=high))


LIST = BeforeValidator(split_list)


def fields_of(constants: Iterable[Constant]) -> dict[str, Any]:
    """Return fields of a section, as `pydantic.create_model` takes them, for constants of a material or profile."""
    fields: dict[str, Any] = {}
    for constant in constants:
        kind: Any = Annotated[float, Reader(constant.quantity)]
        if constant.is_list:
            kind = Annotated[list[kind], LIST]
        fields[constant.name] = (kind, ...) if constant.required else (kind | None, None)
    return fields


# Columns of numbers in CSV files, with the units of their header.

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
    folder: str | Path, name: str, composed: Collection[str] = (), symbols: Mapping[str, str] = _SYMBOLS
) -> tuple[Sheet, list[str]]:
    """Return the table of a CSV file and the names of its columns; `composed` are names that have an underscore."""
    path = Path(folder, name)
    try:
        text = decoded("", read_bytes(path))
    except FileError as error:
        raise InputError("", rule=f"{error.rule}: {path}" if folder else error.rule) from None
    # What follows a name in a longer name is no unit, as in velocity_error.
    words = {name.rpartition("_")[2] for name in composed if name.rpartition("_")[0] in composed}
    lines = split_lines(text, " ")
    sheet = read_sheet(
        "", lines, is_unit=lambda tail: tail not in words, is_name=lambda label: _plain(label, composed) in composed
    )
    labels = [_plain(label, composed) if composed else label for label in sheet.labels]
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


def _plain(label: str, names: Collection[str]) -> str:
    """Return a label as a name; words may have capitals, symbols may not."""
    plain = label.strip().replace(" ", "_")
    small = plain.lower()
    return small if small in names and min(map(len, small.split("_"))) > 2 else plain


def _forms(dimensions: Mapping[str, Dimension]) -> str:
    """Return the headers that are understood."""
    units = {name: dimension.example.split()[-1] for name, dimension in dimensions.items()}
    behind = ",".join(f"{name}_{unit}" for name, unit in units.items())
    brackets = ",".join(f"{name} [{unit}]" for name, unit in units.items())
    return f'write e.g. "{behind}", "{brackets}", or "{",".join(units)}" and the units in a second line'
