"""Parallel dashpot, or a target that moves, in an element of the approach: both make the velocity implicit."""

from restitution.kernel.compile import compiled
from restitution.kernel.dense import invert, matvec
from restitution.kernel.lanes import WIDTH, read8, write8
from restitution.kernel.modes import write_matrix
from restitution.kernel.path import radius_slope
from restitution.kernel.radau import Scheme
from restitution.kernel.workspace import COUPLING, DASHPOT, FORCE, RADIUS, SPEED, UNKNOWN, Problem, Work


@compiled
def add_dashpot(problem: Problem, scheme: Scheme, work: Work, v0: float, start: float, h: float) -> None:
    """Add the force eta a v of a parallel dashpot to F and solve for v; store the inverse in `matrices[DASHPOT]`.

    (I + diag(z eta a) + h A diag(eta r a)) v = v0 - h A r (F - F0) - z (F - F(0)), with F without the dashpot, but
    with it in F(0) = `start`, and the admittance z.
    """
    A, vectors, M, z = scheme.columns, work.vectors, work.matrices[DASHPOT], problem.admittance
    F, a = read8(vectors, FORCE, 0), read8(vectors, RADIUS, 0)
    r = 2.0 * read8(vectors, UNKNOWN, 0)
    braking = (h * problem.viscosity) * (r * a)
    write_matrix(scheme, work.matrices, DASHPOT, braking)
    for j in range(WIDTH):
        M[j, j] += z * problem.viscosity * a[j]
    invert(work.matrices, DASHPOT)
    v = matvec(M, v0 - h * matvec(A, r * (F - problem.external_force)) - z * (F - start))
    write8(vectors, SPEED, 0, v)
    write8(vectors, FORCE, 0, F + problem.viscosity * (a * v))


@compiled
def dashpot_coupling(problem: Problem, scheme: Scheme, work: Work) -> None:
    """Write A M^-1 A, which replaces A^2, and the slope of eta a v at fixed v into `vectors[RADIUS]`."""
    A, vectors = scheme.columns, work.vectors
    inverse, coupling = work.matrices[DASHPOT], work.matrices[COUPLING]
    for j in range(WIDTH):
        write8(coupling, j, 0, matvec(A, matvec(inverse, read8(A, j, 0))))
    for i in range(WIDTH):
        slope = radius_slope(problem.path, vectors[UNKNOWN, i], vectors[RADIUS, i])
        vectors[RADIUS, i] = problem.viscosity * slope * vectors[SPEED, i]
