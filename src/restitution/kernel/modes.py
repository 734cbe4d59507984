"""Modes of an element: linear in the unknown, and eliminated.

With a pace u, `dt = u dsigma`, a mode obeys `dy/dsigma = -u y/tau + source`. At the nodes of an element of length h
`(I + h/tau A diag(u)) y = start`, where start is the value at the beginning plus the integral of the source.
"""

from typing import Any

from restitution.kernel.compile import inlined
from restitution.kernel.dense import invert_modes, matvec
from restitution.kernel.lanes import WIDTH, read8, write8
from restitution.kernel.radau import Scheme
from restitution.kernel.workspace import Problem, Work

# Length of an element over a relaxation time from which a mode is fast: after one round with old inverses it lags
# behind the unknown by as much as the chord step, which is no measure then.
LAG = 0.05


@inlined
def write_matrix(scheme: Scheme, matrices: Any, place: int, step: Any) -> None:
    """Write I + A diag(step) to matrices[place]."""
    for j in range(WIDTH):
        write8(matrices, place, j, 0, read8(scheme.identity, j, 0) + read8(scheme.columns, j, 0) * step[j])


@inlined
def factor_modes(problem: Problem, scheme: Scheme, work: Work, pace: Any, h: float) -> None:
    """Leave the inverses of all modes at this pace in `work.inverses`."""
    count = problem.moduli.shape[0]
    for k in range(count):
        write_matrix(scheme, work.inverses, k, (h / problem.times[k]) * pace)
    invert_modes(work.inverses, count)


@inlined
def refined(problem: Problem, scheme: Scheme, work: Work, k: int, start: Any, y: Any, pace: Any, h: float) -> Any:
    """Mode k at the nodes, from an approximation y, by one round with the inverse of another pace."""
    defect = start - y - (h / problem.times[k]) * matvec(scheme.columns, pace * y)
    return y + matvec(work.inverses[k], defect)
