"""Memoryless contact laws of particle and multibody codes, and the numbers that a user types for them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.calibration import oscillator
from restitution.calibration.oscillator import LINEAR, End, Shape
from restitution.calibration.units import NUMBER, PRESSURE, Powers

Array = NDArray[np.float64]


class Typed(NamedTuple):
    """A number that a user types: its value in SI, and its meaning."""

    value: float
    powers: Powers
    words: str


class Setting(NamedTuple):
    """The collision in the middle of the range, and what a user without this package has for it."""

    velocity: float  # [m/s]
    mass: float  # reduced mass [kg]
    poisson_ratio: float
    modulus: float  # storage part of E* [Pa]
    retardation_time: float  # loss tangent over frequency [s]
    restitution_coefficient: float


@dataclass(frozen=True, kw_only=True)
class Law:
    """Law F = k d^p + c d^q v of a code.

    Attributes
    ----------
    name, words, source : str
        Name of the target, code and model, and the pages that define it.
    shape : Shape
        Exponents p and q.
    dashpot : callable
        c for a strength of 1, from k, m [kg] and R [m].
    typed : callable
        What a user types, by the name in the code, from the modulus E* [Pa], the strength and the setting.
    naive : callable
        Modulus and strength of what a user without this package types.
    strengths, elastic : tuple of float, bool
        Smallest and largest strength that can be typed; whether none can be typed too.
    end, naive_end : str
        End of the contact with the snippet, and with the defaults of the code: at zero "force", or "overlap".
    pair, wall : str
        Text to paste for two balls, and for a ball and a wall; the numbers are fields.
    comment, units : str, tuple of str
        Form of a comment; unit systems.
    notes : tuple of str
        Remarks in the text; numbers may be fields.
    """

    name: str
    words: str
    source: str
    shape: Shape
    dashpot: Callable[[Any, Any, Any], Any]
    typed: Callable[[float, float, Setting], dict[str, Typed]]
    naive: Callable[[Setting], tuple[float, float]]
    pair: str
    wall: str
    strengths: tuple[float, float] = (0.0, math.inf)
    elastic: bool = True
    end: End = "force"
    naive_end: End = "force"
    comment: str = "# {}"
    units: tuple[str, ...] = ("si",)
    notes: tuple[str, ...] = ()

    def __reduce__(self) -> Any:
        return _registered, (self.name,)


def _registered(name: str) -> Law:
    """Return the law of a target, from which a pickled result is made again."""
    from restitution.calibration.codes import LAWS

    return LAWS[name]


@dataclass(frozen=True)
class TypedLaw:
    """Law with its numbers: modulus E* [Pa] of k = (4/3) E* sqrt(R), or k/m [1/s^2] of a linear spring; strength."""

    law: Law
    modulus: float
    strength: float
    end: End

    def loss(self, velocity: Any, mass: Any, radius: Any) -> Any:
        """Loss b [-] at v0 [m/s], m [kg] and R [m]."""
        stiffness = self.stiffness(mass, radius)
        damping = self.strength * self.law.dashpot(stiffness, mass, radius)
        return oscillator.loss(self.law.shape, stiffness, damping, mass, velocity)

    def rebound(self, velocity: Any, mass: Any, radius: Any) -> tuple[Array, Array]:
        """Coefficient of restitution [-] and contact time [s] at v0 [m/s], m [kg] and R [m]."""
        e, time = oscillator.rebound(self.law.shape, self.end, self.loss(velocity, mass, radius))
        _, unit = oscillator.scales(self.law.shape, self.stiffness(mass, radius), mass, velocity)
        return e, time * unit

    def stiffness(self, mass: Any, radius: Any) -> Any:
        """Stiffness k of the law at m [kg] and R [m]."""
        return self.modulus * mass if self.law.shape == LINEAR else 4.0 / 3.0 * self.modulus * np.sqrt(radius)


def elastic(modulus: float, setting: Setting) -> dict[str, Typed]:
    """Young's modulus and Poisson ratio that give the reduced modulus E*, if both bodies have them."""
    # The ratio only matters for tangential forces; codes refuse negative ones.
    nu = max(setting.poisson_ratio, 0.0)
    return {
        "E": Typed(2.0 * (1.0 - nu**2) * modulus, PRESSURE, "Young's modulus of both bodies"),
        "nu": Typed(nu, NUMBER, "Poisson ratio of both bodies"),
    }


def by_restitution(strength_of: Callable[[float], float], low: float, high: float) -> dict[str, Any]:
    """Parts of a law whose damping is typed as a coefficient of restitution from low to high, or as 1 for none."""

    def typed(modulus: float, strength: float, setting: Setting) -> dict[str, Typed]:
        e = inverse(strength_of, strength, low, high) if strength > 0.0 else 1.0
        return elastic(modulus, setting) | {"e": Typed(e, NUMBER, "coefficient of restitution, as typed")}

    def naive(setting: Setting) -> tuple[float, float]:
        return setting.modulus, strength_of(min(max(setting.restitution_coefficient, low), high))

    return {
        "dashpot": lambda stiffness, mass, radius: np.sqrt(mass * stiffness),
        "typed": typed,
        "naive": naive,
        "strengths": (strength_of(high), strength_of(low)),
    }


def inverse(function: Callable[[float], float], value: float, low: float, high: float) -> float:
    """Argument in [low, high] at which a decreasing function has a value, or the nearer end."""
    from scipy.optimize import brentq

    if value >= function(low) or value <= function(high):
        return low if value >= function(low) else high
    found: Any = brentq(lambda x: function(x) - value, low, high, xtol=1e-15)
    return float(found)
