"""Quantities with units at the boundary: text such as "10 mm" becomes a number in SI."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache, partial
from typing import Any, Never

from pydantic import BeforeValidator
from pydantic_core import PydanticCustomError

from restitution import checks as validation


@dataclass(frozen=True)
class Kind:
    """A kind of quantity: its name, its SI unit and an example of how a person writes it."""

    name: str
    unit: str
    example: str = ""

    @property
    def article(self) -> str:
        """The name with its indefinite article."""
        return f"{'an' if self.name[0] in 'aeiou' else 'a'} {self.name}"

    @property
    def advice(self) -> str:
        """How to write one."""
        return (
            f'write e.g. "{self.example}", or a plain number in {self.unit}'
            if self.unit
            else "write a plain number"
        )


NUMBER = Kind("dimensionless number", "")
LENGTH = Kind("length", "m", "10 mm")
MASS = Kind("mass", "kg", "5 g")
TIME = Kind("time", "s", "1 ms")
DENSITY = Kind("density", "kg/m^3", "1100 kg/m^3")
VELOCITY = Kind("velocity", "m/s", "1 m/s")
ACCELERATION = Kind("acceleration", "m/s^2", "9.81 m/s^2")
FORCE = Kind("force", "N", "50 mN")
MODULUS = Kind("modulus", "Pa", "2 MPa")
VISCOSITY = Kind("viscosity", "Pa s", "1 kPa s")
ANGLE = Kind("angle", "rad", "80 deg")
TEMPERATURE = Kind("temperature", "K", "20 degC")
TEMPERATURE_DIFFERENCE = Kind("difference of temperatures", "K", "50 K")
MOLAR_ENERGY = Kind("energy per amount of substance", "J/mol", "80 kJ/mol")

# Kinds that no key of a case file takes, but that a person may write by mistake.
_OTHERS = (
    Kind("frequency", "1/s"),
    Kind("area", "m^2"),
    Kind("volume", "m^3"),
    Kind("energy", "J"),
    Kind("power", "W"),
    Kind("stiffness", "N/m"),
    Kind("kinematic viscosity", "m^2/s"),
    Kind("electric charge", "C"),
)
_KINDS = (
    *(NUMBER, LENGTH, MASS, TIME, DENSITY, VELOCITY, ACCELERATION, FORCE, MODULUS, VISCOSITY, TEMPERATURE),
    *(MOLAR_ENERGY, *_OTHERS),
)

_PREFIXES = {"": 0, "n": -9, "u": -6, "µ": -6, "m": -3, "k": 3, "M": 6, "G": 9}
# Units that most files have, by kind, with their power of ten to SI: they need no pint.
_PLAIN = {
    LENGTH: {f"{prefix}m": power for prefix, power in _PREFIXES.items() if prefix not in ("M", "G")}
    | {"cm": -2},
    MASS: {f"{prefix}g": power - 3 for prefix, power in _PREFIXES.items() if prefix not in ("M", "G")},
    TIME: {f"{prefix}s": power for prefix, power in _PREFIXES.items() if power <= 0},
    FORCE: {f"{prefix}N": power for prefix, power in _PREFIXES.items()},
    MODULUS: {f"{prefix}Pa": power for prefix, power in _PREFIXES.items()},
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

_QUANTITY = re.compile(
    r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[+-]?inf)(?![\d.,])\s*(.*?)\s*", re.DOTALL
)
_UNIT = re.compile(r"[\w%°µμΩÅ·⋅.*/^()\s²³⁻¹⁴-]*")
# "mm2" and "s-1", as people write them, which pint reads as names.
_BARE_EXPONENT = re.compile(r"\b([kcdmuµμn]?m|[mu]?s|in|ft)(-?[1-4])\b")
_TOWER = re.compile(r"(\^|\*\*)[\s(+-]*[\d.]+[\s)]*(\^|\*\*)|\d{4}")
# What people mean, of units that differ in case alone.
_COMMON = frozenset(
    {"Pa", "kPa", "MPa", "GPa", "mm", "um", "cm", "m", "kg", "g", "mg", "ms", "us", "s", "N", "mN", "kN"}
)


@cache
def _registry() -> Any:
    # Pint takes 0.4 s to import and to set up, which a case of plain numbers and `--help` need not pay.
    from pint import UnitRegistry

    return UnitRegistry()


def _unit(text: str, kind: Kind) -> Any:
    refused = ValueError(f"unknown unit {text!r}; {kind.advice}")
    # A power of a power such as m^9^9^9 would keep pint's integer arithmetic busy for ever.
    if not _UNIT.fullmatch(text) or _TOWER.search(text) or len(text) > 80:
        raise refused
    try:
        return _registry().parse_units(_BARE_EXPONENT.sub(r"\1**\2", text))
    except Exception:  # pint's parser lets errors of many unrelated types through
        plain = [*_PLAIN.get(kind, {}), *(_CELSIUS if kind is TEMPERATURE else ())]
        names = [name for name in plain if name in _COMMON] or plain
        close = [name for name in names if name.lower() == text.lower()]
        close = close or get_close_matches(text, names, 1, 0.6)
        if not close:
            raise refused from None
        raise ValueError(f"unknown unit {text!r}, did you mean {' or '.join(close)}? {kind.advice}") from None


def to_si(text: str, kind: Kind) -> float:
    """Return the number in SI units that a text such as "10 mm" stands for.

    Parameters
    ----------
    text : str
        A number and a unit; percent and degrees count as units of dimensionless numbers.
    kind : Kind
        The kind of quantity that is wanted.

    Returns
    -------
    float
        The number in `kind.unit`.

    Raises
    ------
    ValueError
        In one line: no number, an unknown unit, or a unit of another dimension.

    Examples
    --------
    >>> to_si("10 mm", LENGTH)
    0.01
    >>> to_si("10 s", LENGTH)
    Traceback (most recent call last):
        ...
    ValueError: is a time, not a length; write e.g. "10 mm", or a plain number in m
    """
    match = _QUANTITY.fullmatch(text)
    if match is None:
        raise ValueError(f"cannot be read as a number and a unit; {kind.advice}")
    number, name = float(match[1]), match[2]
    power = _PLAIN.get(kind, {}).get(name)
    if power is not None:
        # Division by a power of ten rounds once; a product with its inverse twice.
        return number * 10.0**power if power >= 0 else number / 10.0**-power
    if name in _CELSIUS:
        if kind is TEMPERATURE:
            return number + 273.15
        if kind is TEMPERATURE_DIFFERENCE:
            return number
    unit = _unit(name, kind)
    wanted = _registry().parse_units(kind.unit)
    if unit.dimensionality != wanted.dimensionality or (kind is ANGLE and not name):
        found = next(
            (k for k in _KINDS if _registry().parse_units(k.unit).dimensionality == unit.dimensionality), None
        )
        if not name:
            raise ValueError(f"has no unit; {kind.advice}")
        what = found.article if found else f"a quantity of dimension {unit.dimensionality}"
        raise ValueError(f"is {what}, not {kind.article}; {kind.advice}")
    return float(_registry().Quantity(number, unit).to(wanted).magnitude)


def refuse(why: str, *keys: str) -> Never:
    """Raise what pydantic collects; `keys` lead from the section checked to the value to blame."""
    raise PydanticCustomError("case", "{why}", {"why": why, "keys": keys})


def _read(value: Any, kind: Kind, check: Callable[..., Any]) -> float:
    try:
        if isinstance(value, str):
            number = to_si(value, kind)
        elif isinstance(value, int | float) and not isinstance(value, bool):
            number = float(value)
        else:
            raise ValueError(f"must be {kind.article}; {kind.advice}")
    except OverflowError:
        number = float("inf")
    except ValueError as error:
        refuse(str(error))
    try:
        return float(check("value", number, kind.unit))
    except ValueError as error:
        refuse(str(error).partition(": ")[2])


def _split(value: Any) -> Any:
    """Turn "[1, 2, 3] s" into a list of texts with the unit of each."""
    if not isinstance(value, str):
        return value
    match = re.fullmatch(r"\s*\[(.*)\]\s*(.*?)\s*", value, re.DOTALL)
    if match is None:
        refuse('must be a list; write e.g. [1, 2, 3] or "[1, 2, 3] s"')
    return [f"{item.strip()} {match[2]}".strip() for item in match[1].split(",")] if match[1].strip() else []


def positive(kind: Kind) -> BeforeValidator:
    """Read a quantity that is finite and > 0."""
    return BeforeValidator(partial(_read, kind=kind, check=validation.positive))


def nonnegative(kind: Kind) -> BeforeValidator:
    """Read a quantity that is finite and >= 0."""
    return BeforeValidator(partial(_read, kind=kind, check=validation.nonnegative))


def within(kind: Kind, low: float, high: float) -> BeforeValidator:
    """Read a quantity in the closed interval [low, high], whose ends may be infinite."""

    def check(name: str, value: float, unit: str) -> Any:
        return validation.within(name, value, low, high, unit)

    return BeforeValidator(partial(_read, kind=kind, check=check))


LIST = BeforeValidator(_split)
