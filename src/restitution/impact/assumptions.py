"""Where the assumptions of the theory are doubtful for impacts that were solved."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from restitution.contact.profile import Parabola
from restitution.contact.sphere import Sphere
from restitution.contact.validity import quasi_static, small_strain
from restitution.impact.problem import Impact

Array = NDArray[np.float64]


def doubts(impact: Impact | list[Impact], max_contact_radius: Array, max_depth: Array) -> list[str]:
    """Warnings about small strain and quasi-static motion, each once and with the worst numbers.

    Parameters
    ----------
    impact : Impact or list of Impact
        What was solved.
    max_contact_radius, max_depth : array, shape (n,)
        Largest contact radius a and depth d [m] of each impact, raveled; NaN where there is none.

    Returns
    -------
    list of str
        Round bodies (a parabola, a sphere) are judged by a/R, all others by d/a. Waves are judged where a
        material states its density, by the slowest wave of both bodies.

    Examples
    --------
    >>> import numpy as np
    >>> from restitution.material.viscoelastic import Material
    >>> impact = Impact(Material(1e6, 1e9, density=1000.0), Parabola(0.01), mass=0.005, velocity=1.0)
    >>> for warning in doubts(impact, np.array([0.003]), np.array([0.0009])):
    ...     print(warning)
    small strain: contact radius over R reaches 0.3 (> 0.2), representative strain about 6 %
    quasi-static: velocity over wave speed is 0.0316 (> 0.01), waves may carry off some 13 % of the energy
    """
    impacts = impact if isinstance(impact, list) else [impact]
    radius = np.concatenate([_flat(_radius(one), one) for one in impacts])
    velocity = np.concatenate([_flat(one.velocity, one) for one in impacts])
    wave_speed = np.concatenate([_flat(_slowest(one), one) for one in impacts])
    solved = np.isfinite(max_contact_radius) & np.isfinite(max_depth)
    round_tip = solved & np.isfinite(radius)
    other = solved & ~round_tip
    return [
        *small_strain(max_contact_radius[round_tip], max_depth[round_tip], radius[round_tip]),
        *small_strain(max_contact_radius[other], max_depth[other]),
        *quasi_static(velocity, wave_speed),
    ]


def _radius(impact: Impact) -> float | Array:
    """Radius [m] of a round body; NaN for a profile that has none."""
    profile = impact.profile
    return np.asarray(profile.radius) if isinstance(profile, (Parabola, Sphere)) else math.nan


def _slowest(impact: Impact) -> float:
    """Speed [m/s] of the slowest wave in either body; infinite where no density is known."""
    bodies = (impact.material, impact.counter_material)
    speeds = [body.slowest_wave_speed for body in bodies if body is not None]
    return min((speed for speed in speeds if speed is not None), default=math.inf)


def _flat(value: float | Array, impact: Impact) -> Array:
    return np.broadcast_to(np.asarray(value, dtype=np.float64), impact.shape).reshape(-1)
