"""What is to be solved."""

from typing import Any, NamedTuple

from restitution.kernel.path import Path


class Problem(NamedTuple):
    """One impact in units in which mass and impact velocity are 1, d = s^2 and a = a(s).

    F = equilibrium Pi + viscosity a v + sum moduli_k Y_k, and v' = -(F - external_force).
    """

    equilibrium: float
    moduli: Any
    times: Any
    viscosity: float
    external_force: float
    path: Path
