"""Rebound of the body (Graham, Ting): the stored approach is walked backwards in lambda, index 1 on its values.

    dt/dlambda = u,  u q + 2 s1 v1 phi = 0,  phi = E + sum E_k X_k,  X_k = exp(-(t - t1)/tau_k),
    q = E v - eta (F - w) + sum E_k [W_k + X_k (v1 - W1_k)],  F = E Pi1 + sum E_k X_k Y1_k,
    dv/dlambda = -(F - w) u,  dW_k/dlambda = -(u/tau_k) W_k + dv/dlambda.

The unknown is u at the nodes; nothing is divided by q. The first line is 0/0 at lambda = 0, where no node lies.
Stored elements hold s1, v, t, F and, of each mode, X_k and W_k.
"""

import math
from typing import Any

from restitution.kernel.approach import LAG
from restitution.kernel.compile import part
from restitution.kernel.dense import invert, invert_modes, times
from restitution.kernel.lanes import WIDTH, absolute, at_least, exp, largest, load, spread, store
from restitution.kernel.workspace import (
    DELAY,
    F_,
    INTEGRAL,
    JACOBIAN,
    MODES_,
    S_,
    SUM,
    T_,
    UNKNOWN,
    V_,
    WEIGHTED,
)

# Size of a step below which it may be rounding: at most, and over the velocity of the approach, of which little is left
# at the turning point.
ROUNDING, NOISE = 1e-9, 1e-14
_MOST_ITERATIONS = 14


@part
def rebound_element(
    problem: Any, scheme: Any, work: Any, table: Any, h: float, delay: float, accept: float
) -> int:
    """Solve one element of length h from the first column of `table` and t - t1 = `delay`; fill the others.

    `work.vectors[UNKNOWN]` holds the predicted u at the nodes, `work.past` the stored approach there and
    `work.vectors[INTEGRAL]` its Pi; `work.vectors[DELAY]` receives t - t1. Returns the number of Newton iterations, or -1
    where they do not converge.
    """
    A, unit = scheme.columns, scheme.identity
    N = problem.moduli.shape[0]
    B, X, W, past = work.inverses, work.modes[0], work.modes[1], work.past
    J, G, M = work.matrices[JACOBIAN], work.matrices[SUM], work.matrices[WEIGHTED]
    v0 = table[V_, 0]
    eta, load_, equilibrium = problem.viscosity, problem.load, problem.equilibrium
    v1, r1 = load(past[V_], 0), 2.0 * load(past[S_], 0)
    driving = r1 * v1
    # Integrated by itself: as a difference of times it would lose the digits that fast modes feel.
    elapsed = delay + h * times(A, r1)
    Pi = load(work.vectors[INTEGRAL], 0)
    u = load(work.vectors[UNKNOWN], 0)
    rounding = ROUNDING + NOISE / max(v1[WIDTH - 1], 1e-12)
    previous = math.inf
    largest_u = 0.0
    moved = 0.0
    factor = True
    last = False
    iterations = 0
    while True:
        iterations += 1
        if iterations > _MOST_ITERATIONS:
            return -1
        duration = h * times(A, u)
        F = equilibrium * Pi
        phi = spread(equilibrium)
        remembered = spread(0.0)
        phi_t = spread(0.0)
        F_t = spread(0.0)
        q_t = spread(0.0)
        for k in range(N):
            inverse = 1.0 / problem.times[k]
            x = exp(at_least((elapsed + duration) * -inverse, -700.0))
            store(X[k], 0, x)
            x = problem.moduli[k] * x
            force = x * load(past[MODES_ + 2 * k], 0)
            share = x * (v1 - load(past[MODES_ + 1 + 2 * k], 0))
            F = F + force
            phi = phi + x
            remembered = remembered + share
            if factor:
                F_t = F_t - force * inverse
                phi_t = phi_t - x * inverse
                q_t = q_t - share * inverse
        v = v0 - h * times(A, (F - load_) * u)
        q = equilibrium * v - eta * (F - load_) + remembered
        own = spread(0.0)
        if factor:
            for k in range(N):
                rate = (h / problem.times[k]) * u
                for j in range(WIDTH):
                    store(B[k, j], 0, load(unit[j], 0) + load(A[j], 0) * rate[j])
            invert_modes(B, N)
            for j in range(WIDTH):
                store(G[j], 0, equilibrium * load(unit[j], 0))
                store(M[j], 0, spread(0.0))
        for k in range(N):
            E = problem.moduli[k]
            start = v + (table[MODES_ + 1 + 2 * k, 0] - v0)
            if factor:
                Wk = times(B[k], start)
                weight = E * Wk / u
                for j in range(WIDTH):
                    column = load(B[k, j], 0)
                    store(G[j], 0, load(G[j], 0) + E * column)
                    store(M[j], 0, load(M[j], 0) + column * weight[j])
                own = own + weight
            else:
                Wk = load(W[k], 0)
                # After one round fast modes lag behind u by as much as the chord step, which then says nothing.
                lags = not last and h * largest_u > LAG * problem.times[k]
                for _ in range(2 if lags else 1):
                    lack = start - Wk - (h / problem.times[k]) * times(A, u * Wk)
                    Wk = Wk + times(B[k], lack)
            store(W[k], 0, Wk)
            q = q + E * Wk
        if last:
            break
        residual = u * q + driving * phi
        if factor:
            # C = dv/du; the modes' share of q follows v through their inverses, G, and u itself, M.
            row = (h * u) * F_t
            net = F - load_
            direct = h * (u * (q_t - eta * F_t) + driving * phi_t)
            for j in range(WIDTH):
                column = load(A[j], 0)
                change = -h * (column * net[j] + times(A, row * column))
                change = times(G, change) + load(M[j], 0) - load(unit[j], 0) * own[j]
                store(J[j], 0, u * change + direct * column + load(unit[j], 0) * q[j])
            invert(work.matrices, JACOBIAN)
        step = times(J, residual)
        largest_u = largest(absolute(u - step))
        u = at_least(u - step, 1e-9 * largest_u)
        size = largest(absolute(step)) / largest_u
        if not size < 1e3:
            return -1
        # The inverses are frozen, so that chord steps contract no faster than the unknown has moved since, which a first
        # one may hide. After a full step nothing is known but its size.
        moved = size if factor else moved
        contraction = max(size / previous, moved)
        left = size if factor else size * contraction / (1.0 - min(contraction, 0.9))
        stalled = not factor and size < rounding and size > 0.25 * previous
        if left <= accept or stalled:
            last = True
            factor = False
            continue
        chord = not factor
        if chord and size > 2.0 * previous and size > 1e-3:
            return -1
        factor = chord and size > 0.25 * previous
        previous = size
    store(work.vectors[UNKNOWN], 0, u)
    store(table[S_], 1, load(past[S_], 0))
    store(table[V_], 1, v)
    store(table[T_], 1, table[T_, 0] + duration)
    store(work.vectors[DELAY], 0, elapsed + duration)
    store(table[F_], 1, F)
    for k in range(N):
        store(table[MODES_ + 2 * k], 1, load(X[k], 0))
        store(table[MODES_ + 1 + 2 * k], 1, load(W[k], 0))
    return iterations
