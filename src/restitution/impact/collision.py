"""Two bodies that hit each other as one impact: relative motion, gap, sum of the compliances."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from restitution.checks import Numeric, positive
from restitution.contact.profile import Parabola
from restitution.impact.problem import Impact
from restitution.material.viscoelastic import Material


@dataclass(frozen=True, eq=False)
class Body:
    """Body of a collision: a ball, or a wall.

    Parameters
    ----------
    material : Material or None
        What it is made of; None if it is rigid.
    radius : float or array
        Radius R [m] of its surface where it is hit, > 0; infinite (the default) for a wall or a half-space.
    mass : float or array, optional
        Mass [kg], > 0, may be infinite. Left out, it is that of a full sphere if there is a radius and the
        material states its density, and infinite for a wall.

    Raises
    ------
    ValueError
        If a number is out of its range, or the mass of a ball is neither given nor known.
    TypeError
        If the material is something else.

    Notes
    -----
    The contact sees each body as a half-space: valid where the contact is small against it.

    Examples
    --------
    >>> ball = Body(Material(1e6, 1e9, density=1200.0), radius=0.01)
    >>> round(ball.mass, 9)
    0.005026548
    """

    material: Material | None
    radius: Numeric = math.inf
    mass: Numeric | None = None

    def __post_init__(self) -> None:
        if self.material is not None and not isinstance(self.material, Material):
            raise TypeError(f"material = {self.material!r}: must be a Material, or None for a rigid body")
        radius = _positive_or_infinite("radius", self.radius, "m")
        object.__setattr__(self, "radius", radius)
        mass = self.mass
        if mass is None and not np.all(np.isfinite(radius)):
            if np.ndim(radius):
                raise ValueError("mass: must be given for bodies of which some are walls")
            mass = math.inf
        elif mass is None:
            if self.material is None or self.material.density is None:
                raise ValueError("mass: must be given for a ball whose material states no density")
            # A product has the same bits for numbers and arrays, a power has not.
            mass = 4.0 / 3.0 * math.pi * self.material.density * radius * radius * radius
        object.__setattr__(self, "mass", _positive_or_infinite("mass", mass, "kg"))


def collision(body_1: Body, body_2: Body, velocity: Any, *, external_force: Any = 0.0) -> Impact:
    """Impact of two bodies that meet centrally, to be solved like any other.

    Parameters
    ----------
    body_1, body_2 : Body
        The bodies, in any order: balls of one or two materials, or a ball and a wall.
    velocity : float or array
        Relative velocity [m/s], > 0.
    external_force : float or array
        Constant force [N] that presses them together during contact, >= 0. On a wall that cannot move it is
        the weight of the ball; for free bodies that both fall it is zero.

    Returns
    -------
    Impact
        With 1/R = 1/R1 + 1/R2, 1/m = 1/m1 + 1/m2, and both materials, whose compliances add.

    Raises
    ------
    ValueError
        If both bodies are rigid, flat, or immovable.
    TypeError
        If a body is something else.

    Notes
    -----
    Exact for the parabolic gap between two spheres (Hertz 1882) and by the correspondence principle for any
    two materials (Lee and Radok 1960). The result's velocities are relative ones, its depth is the approach
    of the centres.

    Examples
    --------
    >>> import restitution as rs
    >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45, density=1200.0)
    >>> ball, wall = rs.Body(rubber, radius=0.01), rs.Body(None)
    >>> print(round(rs.solve(rs.collision(ball, wall, velocity=1.0)).restitution_coefficient, 6))
    0.333914
    """
    for name, body in (("body_1", body_1), ("body_2", body_2)):
        if not isinstance(body, Body):
            raise TypeError(f"{name} = {body!r}: must be a Body")
    radius = _harmonic("radius", "m", "both bodies are flat: a curved one is needed", body_1.radius, body_2.radius)
    mass = _harmonic("mass", "kg", "both bodies are immovable", body_1.mass, body_2.mass)
    materials = [body.material for body in (body_1, body_2) if body.material is not None]
    if not materials:
        raise ValueError("material: both bodies are rigid; at least one must deform")
    counter = materials[1] if len(materials) > 1 else None
    return Impact(
        materials[0],
        Parabola(radius),
        mass,
        velocity,
        counter_material=counter,
        external_force=external_force,
    )


def _harmonic(name: str, unit: str, problem: str, first: Any, second: Any) -> Any:
    """Number x of 1/x = 1/first + 1/second, either of which may be infinite."""
    total = 1.0 / np.asarray(first) + 1.0 / np.asarray(second)
    if not np.all(total > 0.0):
        raise ValueError(f"{name} = inf {unit}: {problem}")
    combined = 1.0 / total
    return combined if combined.ndim else float(combined)


def _positive_or_infinite(name: str, value: Any, unit: str) -> Numeric:
    """Return a float or array, refusing all that is not above zero."""
    try:
        numbers = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        numbers = None
    if numbers is None or not np.any(np.isposinf(numbers)):
        return positive(name, value, unit)
    positive(name, np.where(np.isposinf(numbers), 1.0, numbers), unit)
    if numbers.ndim == 0:
        return math.inf
    numbers = numbers.copy()
    numbers.setflags(write=False)
    return numbers
