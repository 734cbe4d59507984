"""Systems of units for display: the unit of each dimension and its factor from SI."""

from __future__ import annotations

import math
from typing import Any

# The base units of a system follow from those of length, mass and time; their names are spelt out here.
_SAME = {
    "dimensionless number": ("", 1.0),
    "density": ("kg/m³", 1.0),
    "angle": ("°", 180.0 / math.pi),
    "temperature": ("°C", 1.0),
}
_SYSTEMS: dict[str, dict[str, tuple[str, float]]] = {
    "SI": {
        "length": ("m", 1.0), "mass": ("kg", 1.0), "time": ("s", 1.0), "velocity": ("m/s", 1.0),
        "acceleration": ("m/s²", 1.0), "force": ("N", 1.0), "energy": ("J", 1.0), "modulus": ("Pa", 1.0),
        "viscosity": ("Pa s", 1.0), "angular frequency": ("rad/s", 1.0),
    },
    "mm-g-ms": {
        "length": ("mm", 1e3), "mass": ("g", 1e3), "time": ("ms", 1e3), "velocity": ("m/s", 1.0),
        "acceleration": ("mm/ms²", 1e-3), "force": ("N", 1.0), "energy": ("mJ", 1e3), "modulus": ("MPa", 1e-6),
        "viscosity": ("kPa s", 1e-3), "angular frequency": ("rad/ms", 1e-3),
    },
    "AFM": {
        "length": ("µm", 1e6), "mass": ("g", 1e3), "time": ("s", 1.0), "velocity": ("µm/s", 1e6),
        "acceleration": ("µm/s²", 1e6), "force": ("nN", 1e9), "energy": ("fJ", 1e15), "modulus": ("kPa", 1e-3),
        "viscosity": ("kPa s", 1e-3), "angular frequency": ("rad/s", 1.0),
    },
}  # fmt: skip
_ZERO_CELSIUS = 273.15


def systems() -> dict[str, dict[str, Any]]:
    """Return the unit, factor and offset of each dimension by system: shown = factor x SI + offset.

    >>> systems()["AFM"]["force"]
    {'unit': 'nN', 'factor': 1000000000.0, 'offset': 0.0}
    """
    found: dict[str, dict[str, Any]] = {}
    for name, own in _SYSTEMS.items():
        units = _SAME | own
        units["pressure"] = units["modulus"]
        offset = {"temperature": -_ZERO_CELSIUS}
        found[name] = {
            dimension: {"unit": unit, "factor": factor, "offset": offset.get(dimension, 0.0)}
            for dimension, (unit, factor) in units.items()
        }
    return found
