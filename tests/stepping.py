"""Velocity Verlet, the scheme of most codes that step in time, with a contact law."""

from typing import NamedTuple

import numba
import numpy as np

from restitution.law.law import ContactLaw
from restitution.law.nodes import DEPTH
from restitution.law.step import step


class Collision(NamedTuple):
    restitution_coefficient: float
    max_force: float


@numba.njit
def _verlet(law, state, mass, velocity, dt, force_outside):
    depth, v, force, largest, touched = state[DEPTH], velocity, 0.0, 0.0, False
    while True:
        depth += v * dt + 0.5 * (force_outside - force) / mass * dt * dt
        before, force = force, step(law, state, depth, dt)
        v += (force_outside - 0.5 * (before + force)) / mass * dt
        largest = max(largest, force)
        touched = touched or force > 0.0
        if (touched and not force > 0.0) or np.isnan(force):
            return -v / velocity, largest


def collide(law: ContactLaw, mass: float, velocity: float, dt: float, *, gap: float = 0.0, weight: float = 0.0):
    """One approach and one rebound from a gap [m]."""
    return Collision(*_verlet(law.constants, law.start(depth=-gap), mass, velocity, dt, weight))


@numba.njit
def _forces(law, state, depths, dt):
    forces = np.empty(depths.size)
    for n in range(depths.size):
        forces[n] = step(law, state, depths[n], dt[n])
    return forces


def forces(law: ContactLaw, times, depths):
    """Forces at times [s] > 0 for depths [m] at these times, from the depth 0 at time 0."""
    return _forces(law.constants, law.start(), np.asarray(depths), np.diff(times, prepend=0.0))
