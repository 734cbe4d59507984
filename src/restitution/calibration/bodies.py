"""The two bodies of a problem: a ball of a radius and a mass, and another ball or a wall."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple, cast

from restitution.contact.profile import Parabola
from restitution.errors import InputError, InputTypeError
from restitution.impact.problem import Impact, collision, two_bodies


class Pair(NamedTuple):
    """A single impact, the radius [m] and the mass [kg] of its first ball, and whether the other body is a wall."""

    impact: Impact
    ball_radius: float
    ball_mass: float
    wall: bool


def pair(problem: Any, contact: str | None) -> Pair:
    """Return the bodies of an impact, whose parabola counts as the ball, or of a pair of bodies."""
    if isinstance(problem, Impact):
        impact = _single(problem)
        radius, mass, wall = reduced_radius(impact), float(impact.mass), impact.counter_material is None
    else:
        first, second = two_bodies(problem)
        impact = _single(collision(first, second, velocity=1.0))
        ball, other = (second, first) if math.isinf(float(first.radius)) else (first, second)
        radius, wall = float(ball.radius), math.isinf(float(other.radius))
        mass = float(cast("float", ball.mass))
        # A ball that is held has no mass of its own.
        mass = mass if math.isfinite(mass) else float(impact.mass)
    return Pair(impact, radius, mass, wall if contact is None else contact == "wall")


def reduced_radius(impact: Impact) -> float:
    """Radius [m] of the parabola of an impact."""
    return float(cast("Parabola", impact.profile).radius)


def _single(impact: Impact) -> Impact:
    """Return an impact at 1 m/s, refusing those that no code of spheres could have."""
    if not isinstance(impact.profile, Parabola):
        raise InputTypeError("profile", impact.profile, "must be a Parabola: the codes have spheres")
    impact = replace(impact, velocity=1.0)
    if impact.shape:
        raise InputError("impact", wanted=f"must be single, but has shape {impact.shape} beside its velocity")
    if impact.external_force != 0.0:
        wanted = "must be 0, as the codes add the weight themselves; see with_weight of drop"
        raise InputError("external_force", impact.external_force, wanted, "N")
    if impact.impedance != math.inf:
        wanted = "must be infinite, as the codes move the bodies themselves"
        raise InputError("impedance", impact.impedance, wanted, "kg/s")
    return impact
