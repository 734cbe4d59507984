"""An element of the approach: its modes, its dashpot or moving target, and the control of its length."""

import math
from typing import Any, NamedTuple

from restitution.kernel.collocation import Scheme, invert, invert_modes, matvec
from restitution.kernel.compile import compiled, inlined
from restitution.kernel.lanes import WIDTH, read8, write8
from restitution.kernel.path import radius_slope
from restitution.kernel.workspace import (
    COUPLING,
    DASHPOT,
    DIAGONAL,
    FORCE,
    JACOBIAN,
    RADIUS,
    SLOPE,
    SPEED,
    SUM,
    UNKNOWN,
    Problem,
    Work,
)  # fmt: skip

# Modes of an element: linear in the unknown, and eliminated.
#
# With a pace u, `dt = u dsigma`, a mode obeys `dy/dsigma = -u y/tau + source`. At the nodes of an element of length h
# `(I + h/tau A diag(u)) y = start`, where start is the value at the beginning plus the integral of the source.

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
    """Return the mode k at the nodes, from an approximation y, by one round with the inverse of another pace."""
    defect = start - y - (h / problem.times[k]) * matvec(scheme.columns, pace * y)
    return y + matvec(work.inverses[k], defect)


# Control of Newton's method and of the length of elements, for approach and rebound.

# Verdict on a step of Newton's method: next a chord step, next a step with new inverses, or the end.
CHORD, FACTOR, CONVERGED, DIVERGED = range(4)

_SLOW = 0.25  # contraction from which new inverses cost less than more chord steps
_MOST_CHORDS = 6.0  # chord steps ahead from which new inverses cost less
_WORST = 0.9  # largest contraction for the estimate of the remaining error
# A chord step diverges if it is longer than the last by the first factor and larger than the second number.
_GROWTH, _LARGE = 2.0, 1e-3
_SAFETY = 0.75  # factor on the length according to the tail
_MOST, _LEAST = 6.0, 0.1  # largest and smallest change of the length at once
_NO_ERROR = 1e-30
ON_FAILURE = 0.3  # factor of the length if Newton's method fails


@inlined
def newton_verdict(
    size: float, previous: float, drift: float, full_step: bool, renewed: bool, rounding: float, accept: float
) -> int:
    """Judge a step of relative size `size` after one of size `previous`.

    Chord steps with old inverses contract no faster than the drift of the unknown since the inverses were computed,
    which the first step may hide. After a full step only its size is available. New inverses cost less than many chord
    steps that contract slowly. Steps below `rounding` that do not
    shrink with renewed inverses are rounding.
    """
    contraction = max(size / previous, drift)
    # The steps to come are a geometric series with this ratio.
    remaining = size if full_step else size * contraction / (1.0 - min(contraction, _WORST))
    slow = size > _SLOW * previous
    if remaining <= accept or (slow and renewed and size < rounding):
        return CONVERGED
    # One chord step costs little and shows the contraction, which a full step does not.
    if full_step:
        return CHORD
    # A step that grows but is small is still close to the root: new inverses are enough.
    if size > _GROWTH * previous and size > _LARGE:
        return DIVERGED
    many = size * (size / previous) ** _MOST_CHORDS > accept
    return FACTOR if slow or many else CHORD


class Newton(NamedTuple):
    """Newton's method after a step: what the next round is, and what it must know of the steps before."""

    verdict: int
    previous: float  # Size of the last step
    drift: float  # Size of the last full step, by which the unknown has left the inverses
    renewed: bool  # Whether inverses were renewed after a step below the rounding


@inlined
def first_round() -> Newton:
    """Return the state before the first round, which is a full step."""
    return Newton(FACTOR, math.inf, 0.0, False)


@inlined
def next_round(newton: Newton, size: float, rounding: float, accept: float) -> Newton:
    """Return the state after a step of relative size `size`; see `newton_verdict`."""
    full_step = newton.verdict == FACTOR
    drift = size if full_step else newton.drift
    verdict = newton_verdict(size, newton.previous, drift, full_step, newton.renewed, rounding, accept)
    renewed = newton.renewed or (verdict == FACTOR and size < rounding)
    return Newton(verdict, size, drift, renewed)


@inlined
def shrunk(error: float, exponent: float) -> float:
    """Return the factor of the length of an element whose error over the tolerance is above 1 or not a number."""
    # The error of the polynomial falls with the power S + 1 of the length.
    return max(_LEAST, _SAFETY * error**exponent) if error < math.inf else _LEAST


@inlined
def grown(error: float, exponent: float) -> float:
    """Return the factor of the length from an accepted element to the next."""
    return min(_MOST, _SAFETY * max(error, _NO_ERROR) ** exponent)


# Parallel dashpot, or a target that moves, in an element of the approach: both make the velocity implicit.


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
    # The force of the dashpot moves the target at once: v + z eta a v on the left-hand side.
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


# Target that moves, in an element of the approach: the Jacobian of s.


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
