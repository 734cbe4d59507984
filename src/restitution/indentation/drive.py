"""What moves a body in contact, in SI and in the units of a run through panels."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from restitution.checks import Array
from restitution.indentation.history import History, from_zeros
from restitution.kernel.driver import NEVER, Driver

# Largest power of the map of time after a touch, and under a force.
_MOST_POWER, _MOST_EXACT = 12, 5


class Drive(NamedTuple):
    """What moves the body: a depth, a force on it, or the base of a spring that holds it; and its inertia.

    Without `by_depth`, `m d'' + c d' + k d = f(t) + A cos(w t + phi) - F + pull`, where f is `history`. A mass feels
    the pull `C/(gap + cutoff)^2` of the surface; forces and work of the solution are those of F - pull. Depths of
    higher modes, each under F - pull alone, add to that of the mass.
    """

    history: History  # f; the depth [m] where it is given
    by_depth: bool
    peak: float  # bound of the depth [m], with which errors are compared
    mass: float = 0.0
    damping: float = 0.0
    stiffness: float = 0.0
    amplitude: float = 0.0
    frequency: float = 0.0
    phase: float = 0.0
    touch: float = 2.0  # y grows like a multiple of t^(1/touch)
    depth: float = 0.0  # at the start
    velocity: float = 0.0
    touches: bool = False  # whether the body touches the surface at the start, with the velocity
    once: bool = False  # whether only the first contact counts
    first: float = math.inf  # length of the first step to try [s]
    scale: float = 1.0  # depth over the peak, with which errors are compared
    attraction: float = 0.0  # C [N m^2]
    cutoff: float = 1.0  # [m]
    modes: Array = np.zeros((0, 3))  # mass, damping, stiffness of higher modes in series with the mass, (M, 3)
    swing: Array = np.zeros((0, 2))  # their depths [m] and velocities [m/s] at the start, (M, 2)

    @property
    def is_force(self) -> bool:
        """Whether a force is prescribed: there is neither a depth nor inertia nor a spring."""
        return not self.by_depth and self.mass == self.stiffness == 0.0

    @property
    def first_depth(self) -> float:
        """Depth [m] at the start, where the body is free."""
        if self.by_depth or (self.stiffness > 0.0 and self.mass == 0.0):
            return float(self.history.coefficients[0, 0]) / (1.0 if self.by_depth else self.stiffness)
        return self.depth


class Units(NamedTuple):
    """Units of the dimensionless numbers in SI."""

    touch: float  # Start of the history [s]
    time: float  # Duration of the history [s]
    length: float  # Bound of the depth [m]
    radius: float  # Stiffness radius there [m]
    force: float  # 2 E radius length [N], with a modulus E typical of the duration
    error: float  # Error of forces by the table of the profile, over the largest one; 0 for power laws


def touch_power(drive: Drive, exponent: float, dashpot: float) -> int:
    """Return n such that depth and radius are smooth over z with t = z^n after a touch; without one, nearly so."""
    most = _MOST_POWER if drive.touch == 2.0 else _MOST_EXACT
    for n in range(math.ceil(drive.touch), most + 1):
        root = n / drive.touch
        if abs(root - round(root)) < 1e-9 and abs(root * exponent - round(root * exponent)) < 1e-9:
            return n
    if drive.touch == 2.0:
        return most
    # High powers of z are not resolved.
    return (2 if drive.stiffness > 0.0 else 4) if dashpot > 0.0 else 5


def driver_of(drive: Drive, units: Units, dashpot: float) -> Driver:
    """Return what moves the body in dimensionless numbers; forces are halved, as F = 2 int q da."""
    history, backward = drive.history, NEVER
    coefficients = history.coefficients
    if drive.is_force:
        history, coefficients, backward = from_zeros(history)
    # On a dashpot a rate that jumps by rounding is a load that does. Otherwise a turn at a knot is best known as one.
    smooth = history.smooth_knots if dashpot > 0.0 else np.zeros(history.knots.size, dtype=np.bool_)
    smooth[1:][backward] = False
    knots = (history.knots - units.touch) / units.time
    size = units.length if drive.by_depth else units.force
    stiffness, rate = units.length / units.force, 1.0 / units.time
    return Driver(
        drive.by_depth, knots, coefficients / size, smooth,
        drive.mass * stiffness * rate * rate, drive.damping * stiffness * rate, drive.stiffness * stiffness,
        drive.amplitude / size, drive.frequency * units.time, drive.phase + drive.frequency * units.touch, drive.once,
        drive.attraction / (units.force * units.length**2), drive.cutoff / units.length,
        drive.modes * stiffness * np.array([rate * rate, rate, 1.0]), backward,
    )  # fmt: skip
