"""Target that moves, in an element of the approach: the Jacobian of s."""

from restitution.kernel.compile import compiled
from restitution.kernel.dense import matvec
from restitution.kernel.lanes import WIDTH, read8, write8
from restitution.kernel.radau import Scheme
from restitution.kernel.workspace import (
    DASHPOT,
    DIAGONAL,
    JACOBIAN,
    RADIUS,
    SLOPE,
    SUM,
    UNKNOWN,
    Problem,
    Work,
)  # fmt: skip


@compiled
def target_jacobian(problem: Problem, scheme: Scheme, work: Work, h: float) -> None:
    """Write the Jacobian on a target that moves, I + h A M^-1 (h A dg + z dF), with g = r (F - F0).

    dF is `matrices[SUM]` and, on the diagonal, `vectors[SLOPE]` with the slope of the dashpot in `vectors[RADIUS]`;
    `vectors[DIAGONAL]` is the diagonal of dg.
    """
    A, vectors, matrices = scheme.columns, work.vectors, work.matrices
    r, diagonal = 2.0 * read8(vectors, UNKNOWN, 0), read8(vectors, DIAGONAL, 0)
    slope = read8(vectors, SLOPE, 0) + read8(vectors, RADIUS, 0)
    for j in range(WIDTH):
        unit, coupling = read8(scheme.identity, j, 0), read8(matrices, SUM, j, 0)
        column = h * matvec(A, r * coupling + unit * diagonal[j])
        column = column + problem.admittance * (coupling + unit * slope[j])
        write8(matrices, JACOBIAN, j, 0, unit + h * matvec(A, matvec(matrices[DASHPOT], column)))
