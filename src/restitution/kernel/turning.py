"""Blocks of approaches: depth and stiffness radius at the turning point, at a third of the cost of impacts."""

import math
from typing import Any

from restitution.kernel.approach import FIRST, ROUGH_START, approach
from restitution.kernel.collocation import Scheme
from restitution.kernel.compile import entry_point
from restitution.kernel.outcome import MAX_DEPTH, MAX_RADIUS, SEPARATED, STATUS
from restitution.kernel.path import TABLE, radius_and_integral
from restitution.kernel.workspace import S_, Problems, Work, problem_inside


@entry_point
def turning_block(
    scheme: Scheme, tolerance: float, accept: float, problems: Problems, work: Work, outcomes: Any
) -> None:
    """Solve the approaches of a block; the arguments are those of `restitution.kernel.impact.solve_block`.

    Row n of `outcomes` receives the status, and the depth and the radius if the first trial has a turning point; all
    else is NaN.
    """
    for n in range(problems.firsts.shape[0]):
        problem = problem_inside(problems, n)
        for column in range(outcomes.shape[1]):
            outcomes[n, column] = math.nan
        # The first element of a table is short, which the depth does not need.
        first = FIRST / ROUGH_START if problem.path.exponent == TABLE else FIRST
        status = approach(problem, scheme, work, tolerance, accept, first * problems.firsts[n], False)
        outcomes[n, STATUS] = status
        if status == SEPARATED:
            s = work.turning[S_]
            outcomes[n, MAX_DEPTH], outcomes[n, MAX_RADIUS] = s * s, radius_and_integral(problem.path, s)[0]
