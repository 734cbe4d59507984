"""The free dimensional inputs behind the dimensionless groups, drawn at random."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.contact.profile import Parabola
from restitution.impact.problem import Impact
from restitution.material.classical import standard_solid

RANGES: dict[str, tuple[float, float]] = {
    "mass": (1e-6, 1.0),
    "radius": (1e-4, 1e-1),
    "velocity": (1e-3, 1e1),
    "equilibrium_modulus": (1e4, 1e8),
}
"""Bounds of the log-uniform draws: m [kg], R [m], v0 [m/s], Ginf [Pa]."""


class DimensionalInputs(NamedTuple):
    """Inputs in SI of many impacts, arrays of one common shape."""

    mass: NDArray[np.float64]
    radius: NDArray[np.float64]
    velocity: NDArray[np.float64]
    equilibrium_modulus: NDArray[np.float64]
    branch_modulus: NDArray[np.float64]
    viscosity: NDArray[np.float64]


def draw_inputs(p2: Any, p3: Any, generator: np.random.Generator) -> DimensionalInputs:
    """Return random dimensional inputs that have the given dimensionless groups.

    Mass m, radius R, velocity v0 and equilibrium modulus Ginf are drawn log-uniformly within `RANGES`; the
    other two follow from the paper's eq. (11): `G1 = Ginf/p2`, `eta = p3 (m^2 Ginf^3/(v0 R))^(1/5)`.

    Parameters
    ----------
    p2 : array-like
        Ginf/G1.
    p3 : array-like
        eta (v0 R/(m^2 Ginf^3))^(1/5); broadcasts with `p2`.
    generator : numpy.random.Generator
        Source of the draws.

    Returns
    -------
    DimensionalInputs
        In SI, of the common shape of `p2` and `p3`.

    Examples
    --------
    >>> inputs = draw_inputs(0.1, [0.5, 2.0], np.random.default_rng(1))
    >>> inputs.equilibrium_modulus / inputs.branch_modulus
    array([0.1, 0.1])
    """
    p2, p3 = np.broadcast_arrays(np.asarray(p2, dtype=np.float64), np.asarray(p3, dtype=np.float64))
    mass, radius, velocity, modulus = (
        np.exp(generator.uniform(np.log(low), np.log(high), p2.shape)) for low, high in RANGES.values()
    )
    viscosity = p3 * (mass**2 * modulus**3 / (velocity * radius)) ** 0.2
    return DimensionalInputs(mass, radius, velocity, modulus, modulus / p2, viscosity)


def impacts(poisson_ratio: Any, inputs: DimensionalInputs) -> list[Impact]:
    """Return one impact of a rigid paraboloid on a standard solid for each set of inputs, in C order.

    Parameters
    ----------
    poisson_ratio : array-like
        Static Poisson ratio nu in [-1, 0.5]; broadcasts to the shape of the inputs.
    inputs : DimensionalInputs
        The inputs in SI.

    Returns
    -------
    list of Impact
        As many as the inputs' size.

    Examples
    --------
    >>> inputs = draw_inputs(0.1, [0.5, 2.0], np.random.default_rng(1))
    >>> len(impacts(0.45, inputs))
    2
    """
    columns = (np.broadcast_to(poisson_ratio, inputs.mass.shape), *inputs)
    rows = zip(*(np.ravel(column).tolist() for column in columns), strict=True)
    return [
        Impact(
            material=standard_solid(modulus, branch, viscosity, poisson_ratio=nu),
            profile=Parabola(radius=radius),
            mass=mass,
            velocity=velocity,
        )
        for nu, mass, radius, velocity, modulus, branch, viscosity in rows
    ]
