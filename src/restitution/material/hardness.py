"""Young's modulus from a Shore hardness: a starting point, with the scatter between its sources."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import NamedTuple

from restitution.checks import one_of, single, within

# A reading is taken to be good to so many points.
_READING = 5.0
_TEXT = (
    re.compile(r"\s*(?P<number>\d+(\.\d+)?)\s*[°º]?\s*(sh(ore)?\s*)?(?P<scale>[ad])\s*", re.IGNORECASE),
    re.compile(r"\s*sh(ore)?\s*(?P<scale>[ad])\s*(?P<number>\d+(\.\d+)?)\s*", re.IGNORECASE),
)


def _gent(hardness: float) -> float:
    return 1e6 * 0.0981 * (56.0 + 7.62336 * hardness) / (0.137505 * (254.0 - 2.54 * hardness))


def _qi(hardness: float) -> float:
    return 1e6 * 10.0 ** (0.0235 * hardness - 0.6403)


def _cone(hardness: float) -> float:
    # The spring of ASTM D2240 and its cone of 30 degrees, on an incompressible half-space.
    force, depth = 0.4445 * hardness, 2.54e-3 * (1.0 - hardness / 100.0)
    return 0.75 * math.pi * force / (2.0 * depth**2 * math.tan(math.radians(15.0)))


SOURCES = {
    "gent_1958": "Gent, Trans. Inst. Rubber Ind. 34 (1958) 46: linear theory of the blunt cone",
    "qi_2003": "Qi, Joyce and Boyce, Rubber Chem. Technol. 76 (2003) 419: finite elements at large strain",
    "sneddon_1965": "Sneddon, Int. J. Eng. Sci. 3 (1965) 47: linear theory of the sharp cone, spring of ASTM D2240",
}
SCALES: dict[str, tuple[float, float, dict[str, Callable[[float], float]]]] = {
    "A": (20.0, 80.0, {"gent_1958": _gent, "qi_2003": _qi}),
    "D": (30.0, 85.0, {"sneddon_1965": _cone, "qi_2003": lambda hardness: _qi(hardness + 50.0)}),
}
"""Lowest and highest hardness of each scale, and Young's modulus [Pa] by its sources."""


class HardnessModulus(NamedTuple):
    """Young's modulus from a Shore hardness.

    Attributes
    ----------
    youngs_modulus : float
        Geometric mean of the sources [Pa].
    low, high : float
        Lowest and highest Young's modulus [Pa] of the sources for a reading that is 5 points lower or higher.
    by_source : dict
        Young's modulus [Pa] by source, whose full names are in `SOURCES`.
    """

    youngs_modulus: float
    low: float
    high: float
    by_source: dict[str, float]

    @property
    def shear_modulus(self) -> float:
        """Shear modulus E/3 [Pa] of an incompressible rubber."""
        return self.youngs_modulus / 3.0

    @property
    def log_deviation(self) -> float:
        """Half of the logarithm of `high` over `low` [-], for a lognormal prior."""
        return 0.5 * math.log(self.high / self.low)


def shore_modulus(hardness: float, scale: str = "A") -> HardnessModulus:
    """Return Young's modulus from a Shore hardness, with its scatter.

    A durometer presses for some seconds, so that this is a modulus of long times. It says nothing of the loss: a body
    of this modulus alone would rebound with e = 1. Use it as a start or as a prior of `rs.identify`.

    Parameters
    ----------
    hardness
        Reading, 20 to 80 on scale A, 30 to 85 on scale D.
    scale
        "A" or "D".

    Returns
    -------
    HardnessModulus
        Mean and range of two sources: for A the linear theory of the blunt cone (Gent 1958), for D that of the sharp
        one (Sneddon 1965), for both the finite elements of Qi, Joyce and Boyce (2003) for large strains.

    Raises
    ------
    InputError
        If the scale is unknown or the reading is outside its range.

    Examples
    --------
    >>> found = shore_modulus(60.0)
    >>> print(*(f"{modulus / 1e6:.3g}" for modulus in found[:3]), "MPa")
    4.61 2.97 7.71 MPa
    """
    low, high, sources = SCALES[one_of("scale", scale, tuple(SCALES))]
    number = single("hardness", within("hardness", hardness, low, high))
    by_source = {name: modulus(number) for name, modulus in sources.items()}
    mean = math.exp(sum(map(math.log, by_source.values())) / len(by_source))
    ends = [[modulus(number + shift) for modulus in sources.values()] for shift in (-_READING, _READING)]
    return HardnessModulus(mean, min(ends[0]), max(ends[1]), by_source)


def read_hardness(text: str) -> tuple[float, str] | None:
    """Return number and scale of a text such as "60 Shore A"; None if it is no hardness.

    >>> read_hardness("60 Shore A"), read_hardness("ShD 45"), read_hardness("60A"), read_hardness("epoxy")
    ((60.0, 'A'), (45.0, 'D'), (60.0, 'A'), None)
    """
    match = next((match for pattern in _TEXT if (match := pattern.fullmatch(text))), None)
    return None if match is None else (float(match["number"]), match["scale"].upper())
