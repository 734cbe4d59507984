"""Quantities with units: a text such as "10 mm" becomes a number in SI, in case files and on the command line."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Annotated, Any

from pydantic import BeforeValidator
from pydantic_core import core_schema

from restitution.checks import refuse_millipascal, unit_registry
from restitution.errors import ABSENT, InputError
from restitution.material.models import Constant
from restitution.quantities import (
    ACCELERATION,
    ANGLE,
    CONSTANTS,
    DENSITY,
    FORCE,
    INPUTS,
    LENGTH,
    MASS,
    MODULUS,
    MOLAR_ENERGY,
    NUMBER,
    OUTPUTS,
    TEMPERATURE,
    TEMPERATURE_DIFFERENCE,
    TIME,
    VELOCITY,
    VISCOSITY,
    Dimension,
    Quantity,
)

_DIMENSIONS = (
    NUMBER,
    *(one.dimension for one in (*INPUTS.values(), *OUTPUTS.values())),
    MOLAR_ENERGY,
    # No key of a case file has these, but a person may write one by mistake.
    Dimension("frequency", "1/s"),
    Dimension("area", "m^2"),
    Dimension("volume", "m^3"),
    Dimension("power", "W"),
    Dimension("stiffness", "N/m"),
    Dimension("kinematic viscosity", "m^2/s"),
    Dimension("electric charge", "C"),
)

_PREFIXES = {"": 0, "n": -9, "u": -6, "µ": -6, "m": -3, "k": 3, "M": 6, "G": 9}
# Units that most files have, with their power of ten to SI. They need no pint, whose start takes 0.4 s.
_PLAIN = {
    LENGTH: {f"{prefix}m": power for prefix, power in _PREFIXES.items() if prefix not in ("M", "G")} | {"cm": -2},
    MASS: {f"{prefix}g": power - 3 for prefix, power in _PREFIXES.items() if prefix not in ("M", "G")},
    TIME: {f"{prefix}s": power for prefix, power in _PREFIXES.items() if power <= 0},
    FORCE: {f"{prefix}N": power for prefix, power in _PREFIXES.items()},
    MODULUS: {f"{prefix}Pa": power for prefix, power in _PREFIXES.items() if prefix != "m"},
    VISCOSITY: {f"{prefix}Pa s": power for prefix, power in _PREFIXES.items()},
    VELOCITY: {"m/s": 0, "mm/s": -3, "um/s": -6, "cm/s": -2},
    DENSITY: {"kg/m^3": 0, "kg/m3": 0, "g/cm^3": 3, "g/cm3": 3},
    ACCELERATION: {"m/s^2": 0, "m/s2": 0},
    TEMPERATURE: {"K": 0},
    TEMPERATURE_DIFFERENCE: {"K": 0},
    MOLAR_ENERGY: {"J/mol": 0, "kJ/mol": 3},
    ANGLE: {"rad": 0},
}
_CELSIUS = ("degC", "°C")

# The expressions below take quadratic time on some texts, which must therefore be short.
_LONGEST = 200
_QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[+-]?inf)(?![\d.,])\s*(.*?)\s*", re.DOTALL)
_LIST = re.compile(r"\s*\[([^\]]*)\]([^\]]*)")
_UNIT = re.compile(r"[\w%°µμΩÅ·⋅.*/^()\s²³⁻¹⁴-]*")
# "mm2" and "s-1", as people write them, which pint reads as names.
_BARE_EXPONENT = re.compile(r"\b([kcdmuµμn]?m|[mu]?s|in|ft)(-?[1-4])\b")
# A power of a power such as m^9^9^9 would keep pint's integer arithmetic busy for ever.
_TOWER = re.compile(r"(\^|\*\*)[\s(+-]*[\d.]+[\s)]*(\^|\*\*)|\d{4}")
# What people mean, of units that differ in case alone.
_COMMON = frozenset(
    ["Pa", "kPa", "MPa", "GPa", "mm", "um", "cm", "m", "kg", "g", "mg", "ms", "us", "s", "N", "mN", "kN"]
)


def to_si(text: str, dimension: Dimension) -> float:
    """Return a text such as "10 mm" as a number in the SI unit of a dimension.

    The text has at most 200 characters. Percent and degrees are units of dimensionless numbers. An `InputError` names
    an unknown unit, or the dimension that the text has.

    >>> to_si("10 mm", LENGTH)
    0.01
    >>> to_si("10 s", LENGTH)
    Traceback (most recent call last):
        ...
    restitution.errors.InputError: is a time, not a length; write e.g. "10 mm", or a plain number in m
    """
    match = _QUANTITY.fullmatch(text) if len(text) <= _LONGEST else None
    if match is None:
        raise InputError("", wanted=f"cannot be read as a number and a unit; {dimension.advice}")
    number, name = float(match[1]), match[2]
    if dimension == MODULUS:
        refuse_millipascal("", ABSENT, name)
    power = _PLAIN.get(dimension, {}).get(name)
    if power is not None:
        # Division by a power of ten rounds once; a product with its inverse twice.
        return number * 10.0**power if power >= 0 else number / 10.0**-power
    if name in _CELSIUS and dimension is TEMPERATURE:
        return number + 273.15
    if name in _CELSIUS and dimension is TEMPERATURE_DIFFERENCE:
        return number
    unit, registry = _unit(name, dimension), unit_registry()
    wanted = registry.parse_units(dimension.unit)
    if unit.dimensionality != wanted.dimensionality or (dimension is ANGLE and not name):
        if not name:
            raise InputError("", wanted=f"has no unit; {dimension.advice}")
        sought = unit.dimensionality
        found = (one.article for one in _DIMENSIONS if registry.parse_units(one.unit).dimensionality == sought)
        what = next(found, f"a quantity of dimension {sought}")
        near = _near(name, dimension)
        hint = f"did you mean {near}? " if near else ""
        raise InputError("", wanted=f"is {what}, not {dimension.article}; {hint}{dimension.advice}")
    return float(registry.Quantity(number, unit).to(wanted).magnitude)


def _unit(text: str, dimension: Dimension) -> Any:
    refused = InputError("", wanted=f"unknown unit {text!r}; {dimension.advice}")
    if not _UNIT.fullmatch(text) or _TOWER.search(text) or len(text) > 80:
        raise refused
    try:
        return unit_registry().parse_units(_BARE_EXPONENT.sub(r"\1**\2", text))
    except Exception:  # pint's parser lets errors of many unrelated types through
        near = _near(text, dimension) or " or ".join(get_close_matches(text, _usual(dimension), 1, 0.6))
        if not near:
            raise refused from None
        raise InputError("", wanted=f"unknown unit {text!r}, did you mean {near}? {dimension.advice}") from None


def _usual(dimension: Dimension) -> list[str]:
    """Units in which people give a quantity."""
    plain = [*_PLAIN.get(dimension, {}), *(_CELSIUS if dimension is TEMPERATURE else ())]
    return [name for name in plain if name in _COMMON] or plain


def _near(text: str, dimension: Dimension) -> str:
    """Usual units that differ from a text by capitals only."""
    return " or ".join(name for name in _usual(dimension) if name.lower() == text.lower())


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
        raise InputError("", wanted=f"must be {dimension.article}; {dimension.advice}")
    try:
        return float(quantity.check(number))
    except InputError as error:
        degrees = dimension is ANGLE and not isinstance(value, str) and 1.0 < number <= 180.0
        hint = f'; write "{value:g} deg" for degrees' if degrees else ""
        raise InputError("", wanted=error.wanted + hint) from None


@dataclass(frozen=True)
class Reader:
    """Annotation of a field that holds a quantity in SI."""

    quantity: Quantity

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        return core_schema.no_info_before_validator_function(lambda value: read(value, self.quantity), handler(source))

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> Any:
        return handler(schema) | {"unit": self.quantity.unit}


def of(name: str) -> Reader:
    """Read a registered quantity."""
    return Reader((CONSTANTS | INPUTS)[name])


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
        raise InputError("", wanted='must be a list; write e.g. [1, 2, 3] or "[1, 2, 3] s"')
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
