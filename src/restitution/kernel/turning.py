"""Blocks of approaches: depth and stiffness radius at the turning point, at less than half the cost of impacts."""

import math
from typing import Any

from restitution.kernel.approach import FIRST, approach
from restitution.kernel.compile import entry_point
from restitution.kernel.outcome import MAX_DEPTH, MAX_RADIUS, SEPARATED, STATUS
from restitution.kernel.path import Path, path_inside, radius_and_integral
from restitution.kernel.radau import Scheme
from restitution.kernel.workspace import S_, Problem, Work


@entry_point
def turning_block(
    scheme: Scheme,
    tolerance: float,
    accept: float,
    firsts: Any,
    equilibria: Any,
    viscosities: Any,
    external_forces: Any,
    admittances: Any,
    offsets: Any,
    moduli: Any,
    times: Any,
    paths: Path,
    which: Any,
    work: Work,
    outcomes: Any,
) -> None:
    """Solve the approaches of a block; the arguments are those of `restitution.kernel.impact.solve_block`.

    Row n of `outcomes` receives the status, and the depth and the radius if the first trial has a turning point; all
    else is NaN.
    """
    for n in range(offsets.shape[0] - 1):
        low, high = offsets[n], offsets[n + 1]
        path = path_inside(paths, which[n])
        viscosity, force, admittance = viscosities[n], external_forces[n], admittances[n]
        problem = Problem(equilibria[n], moduli[low:high], times[low:high], viscosity, force, admittance, path)
        for column in range(outcomes.shape[1]):
            outcomes[n, column] = math.nan
        status = approach(problem, scheme, work, tolerance, accept, FIRST * firsts[n], False)
        outcomes[n, STATUS] = status
        if status == SEPARATED:
            s = work.turning[S_]
            outcomes[n, MAX_DEPTH], outcomes[n, MAX_RADIUS] = s * s, radius_and_integral(path, s)[0]
