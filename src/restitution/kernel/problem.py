"""What is to be solved, and how it ended."""

from typing import Any, NamedTuple

from restitution.kernel.path import Path

# Status codes; `restitution.impact.status` gives them names and words.
SEPARATED, SINKS_IN, CAPTURED, TOO_MANY_STEPS, STEP_TOO_SMALL, NOT_FINITE, TOO_DEEP = 0, 1, 2, 3, 4, 5, 7


class Problem(NamedTuple):
    """One impact in units in which mass and impact velocity are 1, d = s^2 and a = a(s).

    F = equilibrium Pi + viscosity a v + sum moduli_k Y_k, and v' = -(F - load).
    """

    equilibrium: float
    moduli: Any
    times: Any
    viscosity: float
    load: float
    path: Path
