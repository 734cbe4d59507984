"""Rebounds of steel balls, computed by `rs.solve`, with noise of known size."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

import restitution as rs

STANDARD_SOLIDS = {"strong": (1e6, 1e7, 1e-3), "fast": (1e6, 1e7, 3e-5), "weak": (1e6, 2e5, 1e-3)}
"""Equilibrium and branch modulus [Pa] and relaxation time [s]: cases A, B and D of the design page."""

RADII, VELOCITIES = np.repeat([0.002, 0.008, 0.03], 10), np.tile(np.geomspace(0.316, 3.16, 10), 3)


def standard_solid(equilibrium: float, branch: float, time: float, **bulk: Any) -> rs.Material:
    """Standard solid by its relaxation time, incompressible by default."""
    return rs.standard_solid(equilibrium, branch, branch * time, **(bulk or {"poisson_ratio": 0.5}))


def rebounds(
    material: rs.Material,
    radius: Any = RADII,
    velocity: Any = VELOCITIES,
    *,
    sd: float = 0.01,
    seed: int | None = None,
    measured: tuple[str, ...] = ("contact_time",),
    **options: Any,
) -> rs.Rebounds:
    """Rebounds with relative noise; exact ones without a seed."""
    rng = None if seed is None else np.random.default_rng(seed)
    mass = 7800.0 * 4.0 / 3.0 * np.pi * np.asarray(radius) ** 3
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rs.errors.RestitutionWarning)  # large strains do not matter here
        outcome = rs.solve(rs.Impact(material, rs.Parabola(radius), mass, velocity))
    names = ("restitution_coefficient", *measured)
    values = {name: np.atleast_1d(getattr(outcome, name)) for name in names}
    if rng is not None:
        values = {name: value * np.exp(sd * rng.standard_normal(value.shape)) for name, value in values.items()}
    noise = options.pop("noise", rs.Noise(**dict.fromkeys(names, f"{100.0 * sd:g} %")))
    e = np.minimum(values.pop("restitution_coefficient"), 1.0)
    return rs.Rebounds(velocity, e, radius=radius, mass=mass, noise=noise, **values, **options)
