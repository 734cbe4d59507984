"""Velocity Verlet, the scheme of most codes that step in time, with a contact law."""

from typing import NamedTuple

import numpy as np

from restitution.law.law import ContactLaw
from restitution.law.step import step


class Collision(NamedTuple):
    restitution_coefficient: float
    max_force: float


def collide(law: ContactLaw, mass: float, velocity: float, dt: float, *, gap: float = 0.0, weight: float = 0.0):
    """One approach and one rebound from a gap [m]."""
    state, depth, v, force, largest = law.start(depth=-gap), -gap, velocity, 0.0, 0.0
    while force > 0.0 or v > 0.0:
        depth += v * dt + 0.5 * (weight - force) / mass * dt * dt
        before, force = force, step(law.constants, state, depth, dt)
        v += (weight - 0.5 * (before + force)) / mass * dt
        largest = max(largest, force)
    return Collision(-v / velocity, largest)


def forces(law: ContactLaw, times, depths):
    """Forces at times [s] > 0 for depths [m] at these times, from the depth 0 at time 0."""
    state, steps = law.start(), np.diff(times, prepend=0.0)
    return np.array([step(law.constants, state, depth, dt) for depth, dt in zip(depths, steps, strict=True)])
