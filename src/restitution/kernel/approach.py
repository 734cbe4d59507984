"""Approach of the body (Lee and Radok): elements of collocation in sigma, where dt = 2 s dsigma and d = s^2.

    ds/dsigma = v,  dv/dsigma = -2 s (F - w),  dY_k/dsigma = -2 s Y_k/tau_k + dPi/dsigma,
    dW_k/dsigma = -2 s W_k/tau_k + dv/dsigma,  F = E Pi + eta a v + sum E_k Y_k.

Every right-hand side is smooth at first touch. The modes are linear and are eliminated: only s at the nodes is unknown.
Stored elements hold s, v, t, F and, of each mode, Y_k and W_k.
"""

import math
from typing import Any

from restitution.kernel.compile import part, stage
from restitution.kernel.dense import invert, invert_modes, times
from restitution.kernel.lanes import WIDTH, absolute, largest, load, smallest, spread, store
from restitution.kernel.path import radii_and_integrals, radius_and_integral, radius_slope
from restitution.kernel.workspace import (
    COUPLING,
    DASHPOT,
    F_,
    FORCE,
    JACOBIAN,
    MODES_,
    RADIUS,
    S_,
    SPEED,
    SUM,
    T_,
    UNKNOWN,
    V_,
    VALUES,
)

ROUNDING = 1e-9
# Length of an element over a relaxation time from which a mode is fast.
LAG = 0.05
_MOST_ITERATIONS = 12


@part
def approach_element(problem: Any, scheme: Any, work: Any, table: Any, h: float, accept: float) -> int:
    """Solve one element of length h from the first column of `table`; fill the others.

    `work.vectors[UNKNOWN]` holds the predicted s at the nodes. Returns the number of Newton iterations, or -1 where they
    do not converge.
    """
    A, unit = scheme.columns, scheme.identity
    N = problem.moduli.shape[0]
    vectors, B, Y, G, J = (
        work.vectors, work.inverses, work.modes[0], work.matrices[SUM], work.matrices[JACOBIAN],
    )  # fmt: skip
    eta, load_, equilibrium = problem.viscosity, problem.load, problem.equilibrium
    s0, v0 = table[S_, 0], table[V_, 0]
    Pi0 = radius_and_integral(problem.path, s0)[1]
    straight = s0 + (h * v0) * load(scheme.c, 1)
    previous = math.inf
    moved = 0.0
    factor = True
    last = False
    iterations = 0
    s = load(vectors[UNKNOWN], 0)
    v = spread(v0)
    while True:
        iterations += 1
        if iterations > _MOST_ITERATIONS or not smallest(s) > 0.0:
            return -1
        r = 2.0 * s
        a, Pi = radii_and_integrals(problem.path, s, vectors[VALUES:])
        F = equilibrium * Pi
        slope = (equilibrium * a) * r
        if factor:
            for k in range(N):
                rate = (h / problem.times[k]) * r
                for j in range(WIDTH):
                    store(B[k, j], 0, load(unit[j], 0) + load(A[j], 0) * rate[j])
            invert_modes(B, N)
            for j in range(WIDTH):
                store(G[j], 0, spread(0.0))
        for k in range(N):
            E = problem.moduli[k]
            start = Pi + (table[MODES_ + 2 * k, 0] - Pi0)
            if factor:
                Yk = times(B[k], start)
                # dY/ds: B depends on s too, and (h/tau) B^-1 A diag(r) = 1 - B^-1.
                own = E * Yk / s
                weight = (E * a) * r + own
                for j in range(WIDTH):
                    store(G[j], 0, load(G[j], 0) + load(B[k, j], 0) * weight[j])
                slope = slope - own
            else:
                Yk = load(Y[k], 0)
                # After one round fast modes lag behind s by as much as the chord step, which then says nothing.
                lags = not last and h * r[WIDTH - 1] > LAG * problem.times[k]
                for _ in range(2 if lags else 1):
                    lack = start - Yk - (h / problem.times[k]) * times(A, r * Yk)
                    Yk = Yk + times(B[k], lack)
            store(Y[k], 0, Yk)
            F = F + E * Yk
        if eta > 0.0:
            store(vectors[UNKNOWN], 0, s)
            store(vectors[FORCE], 0, F)
            store(vectors[RADIUS], 0, a)
            _add_dashpot(problem, scheme, work, v0, h)
            F, v = load(vectors[FORCE], 0), load(vectors[SPEED], 0)
        g = r * (F - load_)
        if last:
            break
        residual = s - s0 - h * times(A, v) if eta > 0.0 else s - straight + (h * h) * times(scheme.square, g)
        if factor:
            diagonal = r * slope + 2.0 * (F - load_)
            if eta > 0.0:
                _dashpot_coupling(problem, scheme, work)
                diagonal = diagonal + r * load(vectors[RADIUS], 0)
            for j in range(WIDTH):
                column = r * load(G[j], 0) + load(unit[j], 0) * diagonal[j]
                column = times(work.matrices[COUPLING] if eta > 0.0 else scheme.square, column)
                store(J[j], 0, load(unit[j], 0) + (h * h) * column)
            invert(work.matrices, JACOBIAN)
        step = times(J, residual)
        s = s - step
        size = largest(absolute(step)) / max(s0, largest(s))
        if not size < 1.0:
            return -1
        # The inverses are frozen, so that chord steps contract no faster than the unknown has moved since, which a first
        # one may hide. After a full step nothing is known but its size.
        moved = size if factor else moved
        contraction = max(size / previous, moved)
        left = size if factor else size * contraction / (1.0 - min(contraction, 0.9))
        stalled = not factor and size < ROUNDING and size > 0.25 * previous
        if left <= accept or stalled:
            # One more round refines the modes with the final s: left out, e is off by 2e-8.
            last = True
            factor = False
            continue
        # Chord steps with the frozen inverses, until they contract too slowly.
        chord = not factor
        if chord and size > 2.0 * previous and size > 1e-3:
            return -1
        factor = chord and size > 0.25 * previous
        previous = size
    v = v0 - h * times(A, g)
    store(table[S_], 1, s)
    store(table[V_], 1, v)
    store(table[T_], 1, table[T_, 0] + h * times(A, r))
    store(table[F_], 1, F)
    for k in range(N):
        start = v + (table[MODES_ + 1 + 2 * k, 0] - v0)
        Wk = times(B[k], start)
        Wk = Wk + times(B[k], start - Wk - (h / problem.times[k]) * times(A, r * Wk))
        store(table[MODES_ + 2 * k], 1, load(Y[k], 0))
        store(table[MODES_ + 1 + 2 * k], 1, Wk)
    return iterations


@stage
def _add_dashpot(problem: Any, scheme: Any, work: Any, v0: float, h: float) -> None:
    """Add the force eta a v of a parallel dashpot, which makes v implicit; leave the inverse in `matrices[DASHPOT]`.

    (I + h A diag(eta r a)) v = v0 - h A r (F - w), F without the dashpot's own part.
    """
    A, vectors, M = scheme.columns, work.vectors, work.matrices[DASHPOT]
    F, a = load(vectors[FORCE], 0), load(vectors[RADIUS], 0)
    r = 2.0 * load(vectors[UNKNOWN], 0)
    braking = (h * problem.viscosity) * (r * a)
    for j in range(WIDTH):
        store(M[j], 0, load(scheme.identity[j], 0) + load(A[j], 0) * braking[j])
    invert(work.matrices, DASHPOT)
    v = times(M, v0 - h * times(A, r * (F - problem.load)))
    store(vectors[SPEED], 0, v)
    store(vectors[FORCE], 0, F + problem.viscosity * (a * v))


@stage
def _dashpot_coupling(problem: Any, scheme: Any, work: Any) -> None:
    """Write A M^-1 A, which takes the place of A^2, and into `vectors[RADIUS]` the slope of eta a v at fixed v."""
    A, vectors = scheme.columns, work.vectors
    inverse, coupling = work.matrices[DASHPOT], work.matrices[COUPLING]
    for j in range(WIDTH):
        store(coupling[j], 0, times(A, times(inverse, load(A[j], 0))))
    for i in range(WIDTH):
        slope = radius_slope(problem.path, vectors[UNKNOWN, i], vectors[RADIUS, i])
        vectors[RADIUS, i] = problem.viscosity * slope * vectors[SPEED, i]
