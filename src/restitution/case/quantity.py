"""Quantities with units as types of the fields of case files."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator
from pydantic_core import core_schema

from restitution.errors import InputError
from restitution.material.models import Constant
from restitution.quantities import CONSTANTS, INPUTS, SHIFTS, Quantity
from restitution.units import ANGLE, Dimension, to_si

_LIST = re.compile(r"\s*\[([^\]]*)\]([^\]]*)")


def read(value: Any, quantity: Quantity) -> float:
    """Return a number, or a text with a unit, in SI; refuse values outside the range of the quantity."""
    dimension = quantity.dimension
    if quantity.infinite and value == "incompressible":
        return math.inf
    if isinstance(value, str):
        number = to_si(value, dimension)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
    else:
        raise InputError("", rule=f"must be {dimension.article}; {dimension.advice}")
    try:
        return float(quantity.check(number))
    except InputError as error:
        degrees = dimension is ANGLE and not isinstance(value, str) and 1.0 < number <= 180.0
        hint = f'; write "{value:g} deg" for degrees' if degrees else ""
        raise InputError("", rule=error.rule + hint) from None


@dataclass(frozen=True)
class Reader:
    """Annotation of a field that holds a quantity in SI."""

    quantity: Quantity

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        return core_schema.no_info_wrap_validator_function(self._read, handler(source))

    def _read(self, value: Any, number: Callable[[Any], Any]) -> Any:
        # The axes of a sweep put arrays in SI into a case.
        return self.quantity.check(value) if isinstance(value, np.ndarray) else number(read(value, self.quantity))

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


def split_list(value: Any) -> Any:
    """Turn "[1, 2, 3] s" into a list of texts with the unit of each; return anything else as it is."""
    if not isinstance(value, str):
        return value
    match = _LIST.fullmatch(value)
    if match is None:
        raise InputError("", rule='must be a list; write e.g. [1, 2, 3] or "[1, 2, 3] s"')
    items, unit = match[1].strip(), match[2].strip()
    return [f"{item.strip()} {unit}".strip() for item in items.split(",")] if items else []


LIST = BeforeValidator(split_list)


def fields_of(constants: Iterable[Constant]) -> dict[str, Any]:
    """Fields of a section, as `pydantic.create_model` takes them, for the constants of a material or a profile."""
    fields: dict[str, Any] = {}
    for constant in constants:
        kind: Any = Annotated[float, Reader(constant.quantity)]
        if constant.is_list:
            kind = Annotated[list[kind], LIST]
        fields[constant.name] = (kind, ...) if constant.required else (kind | None, None)
    return fields
