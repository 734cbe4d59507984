"""The few units in which tables of measured moduli come."""

from __future__ import annotations

import math
from typing import NamedTuple


class Unit(NamedTuple):
    """Unit of a column: SI value = factor * (value + offset).

    Attributes
    ----------
    quantity
        "time", "modulus", "frequency", "angular frequency", "temperature" or "number".
    factor
        Factor to SI (s, Pa, Hz, rad/s, K).
    offset
        What is added before, not zero for the degree Celsius alone.
    """

    quantity: str
    factor: float
    offset: float = 0.0


UNITS = {
    "s": Unit("time", 1.0),
    "sec": Unit("time", 1.0),
    "ms": Unit("time", 1e-3),
    "us": Unit("time", 1e-6),
    "µs": Unit("time", 1e-6),
    "min": Unit("time", 60.0),
    "h": Unit("time", 3600.0),
    "Pa": Unit("modulus", 1.0),
    "kPa": Unit("modulus", 1e3),
    "MPa": Unit("modulus", 1e6),
    "GPa": Unit("modulus", 1e9),
    "N/mm2": Unit("modulus", 1e6),
    "N/m2": Unit("modulus", 1.0),
    "dyn/cm2": Unit("modulus", 0.1),
    "Hz": Unit("frequency", 1.0),
    "kHz": Unit("frequency", 1e3),
    "MHz": Unit("frequency", 1e6),
    "1/s": Unit("frequency", 1.0),
    "rad/s": Unit("angular frequency", 1.0),
    "K": Unit("temperature", 1.0),
    "C": Unit("temperature", 1.0, 273.15),
    "°C": Unit("temperature", 1.0, 273.15),
    "degC": Unit("temperature", 1.0, 273.15),
    "-": Unit("number", 1.0),
    "": Unit("number", 1.0),
}


def unit(text: str, quantities: tuple[str, ...]) -> Unit:
    """Unit of that name for one of some quantities.

    Raises
    ------
    ValueError
        If the name is unknown or belongs to another quantity; the message lists those that would do.

    Examples
    --------
    >>> unit("MPa", ("modulus",)).factor
    1000000.0
    """
    name = text.strip().replace("^", "").replace("²", "2")
    found = UNITS.get(name)
    if found is None or found.quantity not in quantities:
        known = ", ".join(key for key, value in UNITS.items() if value.quantity in quantities and key)
        raise ValueError(f"unit {text.strip()!r}: must be one of {known}")
    return found


TURN = 2.0 * math.pi
"""Radians in a turn: omega = TURN f."""
