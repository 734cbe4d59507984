"""The two bodies of a problem: a ball of a radius and a mass, and another ball or a wall."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple, cast

import numpy as np

from restitution.contact.profile import Parabola
from restitution.errors import InputError, InputTypeError
from restitution.impact.problem import Body, Impact, collision, two_bodies

PAIR, WALL = "pair", "wall"
"""Kinds of contact: two balls, or a ball and a wall."""

_WORDS = {PAIR: "two balls", WALL: "a ball and a wall"}


class Pair(NamedTuple):
    """A single impact, the radius [m] and the mass [kg] of its first ball, whether it is on a wall, and in words."""

    impact: Impact
    ball_radius: float
    ball_mass: float
    wall: bool
    words: str


def pair(problem: Any, contact: str | None) -> Pair:
    """Return the bodies of an impact, whose parabola counts as the ball, or of a pair of bodies.

    A `contact` of the other kind than that of the bodies is built from them where they determine it.
    """
    if isinstance(problem, Impact):
        impact = _single(problem)
        kind = WALL if impact.counter_material is None else PAIR
        if contact not in (None, kind):
            wanted = f"must be {kind!r} for this impact; the other contact needs both bodies: give a pair of Body"
            raise InputError("contact", contact, wanted)
        return Pair(impact, reduced_radius(impact), float(impact.mass), kind == WALL, _WORDS[kind])
    first, second = two_bodies(problem)
    _single(collision(first, second, velocity=1.0))
    ball, other = (second, first) if math.isinf(float(first.radius)) else (first, second)
    kind = WALL if math.isinf(float(other.radius)) else PAIR
    words = _WORDS[kind]
    if contact == PAIR != kind:
        (ball, other), words = _two_equal(ball), "two equal balls"
    elif contact == WALL != kind:
        (ball, other), words = _on_wall(ball, other), "a ball and a wall of its material"
    impact, mass = _single(collision(ball, other, velocity=1.0)), float(cast("float", ball.mass))
    # A ball that is held has no mass of its own.
    mass = mass if math.isfinite(mass) else float(impact.mass)
    return Pair(impact, float(ball.radius), mass, (contact or kind) == WALL, words)


def _two_equal(ball: Body) -> tuple[Body, Body]:
    """Return a ball of a wall twice."""
    if ball.material is None:
        raise InputError("contact", PAIR, "must be 'wall' for a rigid ball, as two of them would both be rigid")
    if not math.isfinite(float(cast("float", ball.mass))):
        raise InputError("contact", PAIR, "must be 'wall' for a ball that is held, as two of them would not move")
    return ball, ball


def _on_wall(ball: Body, other: Body) -> tuple[Body, Body]:
    """Return one of two equal balls, and a wall of its material."""
    numbers = [(float(one.radius), float(cast("float", one.mass))) for one in (ball, other)]
    # Masses of one density and one radius may differ by rounding.
    if ball.material != other.material or not np.allclose(*numbers, rtol=1e-9, atol=0.0):
        raise InputError("contact", WALL, "must be 'pair' for two balls that differ; give one of them and the wall")
    return ball, Body(ball.material)


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
