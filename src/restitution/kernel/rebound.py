"""Rebound of the body (Graham, Ting): the stored approach is walked backwards in lambda, index 1 on its values.

    dt/dlambda = u,  u q + 2 s1 v1 phi = 0,  phi = E + sum E_k X_k,  X_k = exp(-(t - t1)/tau_k),
    q = E v - eta (F - w) + sum E_k [W_k + X_k (v1 - W1_k)],  F = E Pi1 + sum E_k X_k Y1_k,
    dv/dlambda = -(F - w) u,  dW_k/dlambda = -(u/tau_k) W_k + dv/dlambda.

The unknown is u at the nodes; nothing is divided by q. The first line is 0/0 at lambda = 0, where no node lies.
Stored points hold s1, v, t, F and, of each mode, X_k and W_k.
"""

import math
from typing import Any

from restitution.kernel.compile import part
from restitution.kernel.dense import invert
from restitution.kernel.workspace import (
    COUPLING,
    F_,
    FORCE,
    FORCE_SLOPE,
    INTEGRAL,
    JACOBIAN,
    LAST_TIME,
    MODES_,
    PHI,
    PHI_SLOPE,
    Q_SLOPE,
    RESIDUAL,
    S_,
    SCRATCH,
    SPEED,
    STEP,
    SUM,
    T_,
    TIME,
    UNKNOWN,
    V_,
    WEIGHTED,
    Q,
)

_MOST_ITERATIONS = 14


@part
def rebound_element(problem: Any, scheme: Any, work: Any, table: Any, h: float, accept: float) -> int:
    """Solve one element of length h from the values in row 0 of `table`; fill rows 1 to S.

    `work.vectors[UNKNOWN]` holds the predicted u at the nodes, `work.past` the stored approach there and
    `work.vectors[INTEGRAL]` its Pi. Returns the number of Newton iterations, or -1 where they do not converge.
    """
    S = len(scheme.size)
    A = scheme.A
    N = problem.moduli.shape[0]
    vectors, past = work.vectors, work.past
    u, t, q, F, Pi, phi, v = (
        vectors[UNKNOWN], vectors[TIME], vectors[Q], vectors[FORCE], vectors[INTEGRAL], vectors[PHI], vectors[SPEED],
    )  # fmt: skip
    res, row, step = vectors[RESIDUAL], vectors[SCRATCH], vectors[STEP]
    last_t = vectors[LAST_TIME]
    phi_t, F_t, q_t = vectors[PHI_SLOPE], vectors[FORCE_SLOPE], vectors[Q_SLOPE]
    B, X, W = work.inverses, work.modes[0], work.modes[1]
    J, G, M, C = work.matrices[JACOBIAN], work.matrices[SUM], work.matrices[WEIGHTED], work.matrices[COUPLING]
    v0, t0 = table[0, V_], table[0, T_]
    eta, load, equilibrium = problem.viscosity, problem.load, problem.equilibrium
    full_accept = 4.0 * math.sqrt(accept)
    previous = math.inf
    factor = True
    last = False
    iterations = 0
    while True:
        iterations += 1
        if iterations > _MOST_ITERATIONS:
            return -1
        for i in range(S):
            total = 0.0
            for j in range(S):
                total += A[i, j] * u[j]
            last_t[i] = t[i]
            t[i] = t0 + h * total
            F[i] = equilibrium * Pi[i]
            phi[i] = equilibrium
            phi_t[i] = 0.0
            F_t[i] = 0.0
            q_t[i] = 0.0
        for k in range(N):
            inverse = 1.0 / problem.times[k]
            E = problem.moduli[k]
            for i in range(S):
                y = (last_t[i] - t[i]) * inverse
                if iterations > 1 and abs(y) < 1e-2:
                    # A chord step moves t little: six terms from the last value are exact to rounding.
                    x = X[k, i] * (
                        1.0 + y * (1.0 + y / 2.0 * (1.0 + y / 3.0 * (1.0 + y / 4.0 * (1.0 + y / 5.0))))
                    )
                else:
                    x = math.exp(min((past[i, T_] - t[i]) * inverse, 0.0))
                X[k, i] = x
                x *= E
                force = x * past[i, MODES_ + 2 * k]
                F[i] += force
                F_t[i] -= force * inverse
                phi[i] += x
                phi_t[i] -= x * inverse
                q_t[i] -= x * inverse * (past[i, V_] - past[i, MODES_ + 1 + 2 * k])
        for i in range(S):
            row[i] = (F[i] - load) * u[i]
        for i in range(S):
            total = 0.0
            for j in range(S):
                total += A[i, j] * row[j]
            v[i] = v0 - h * total
            q[i] = equilibrium * v[i] - eta * (F[i] - load)
        if factor:
            for i in range(S):
                for j in range(S):
                    G[i, j] = 0.0
                    M[i, j] = 0.0
                G[i, i] = equilibrium
        for k in range(N):
            E = problem.moduli[k]
            z = h / problem.times[k]
            Bk, Wk = B[k], W[k]
            start = table[0, MODES_ + 1 + 2 * k] - v0
            if factor:
                for i in range(S):
                    for j in range(S):
                        Bk[i, j] = z * A[i, j] * u[j]
                    Bk[i, i] += 1.0
                invert(Bk, row, scheme.size)
                for i in range(S):
                    total = 0.0
                    for j in range(S):
                        total += Bk[i, j] * (v[j] + start)
                    Wk[i] = total
                for j in range(S):
                    row[j] = E * Wk[j] / u[j]
                for i in range(S):
                    for j in range(S):
                        G[i, j] += E * Bk[i, j]
                        M[i, j] += Bk[i, j] * row[j]
                    M[i, i] -= row[i]
            else:
                for j in range(S):
                    row[j] = u[j] * Wk[j]
                for i in range(S):
                    total = 0.0
                    for j in range(S):
                        total += A[i, j] * row[j]
                    res[i] = v[i] + start - Wk[i] - z * total
                for i in range(S):
                    total = 0.0
                    for j in range(S):
                        total += Bk[i, j] * res[j]
                    Wk[i] += total
            for i in range(S):
                q[i] += E * (Wk[i] + X[k, i] * (past[i, V_] - past[i, MODES_ + 1 + 2 * k]))
        if last:
            break
        for i in range(S):
            res[i] = u[i] * q[i] + 2.0 * past[i, S_] * past[i, V_] * phi[i]
        if factor:
            # C = dv/du; the modes' share of q follows v through their inverses, G, and u itself, M.
            for n in range(S):
                row[n] = h * u[n] * F_t[n]
            for i in range(S):
                for j in range(S):
                    total = A[i, j] * (F[j] - load)
                    for n in range(S):
                        total += A[i, n] * row[n] * A[n, j]
                    C[i, j] = -h * total
            for i in range(S):
                direct = h * (u[i] * (q_t[i] - eta * F_t[i]) + 2.0 * past[i, S_] * past[i, V_] * phi_t[i])
                for j in range(S):
                    total = M[i, j]
                    for n in range(S):
                        total += G[i, n] * C[n, j]
                    J[i, j] = u[i] * total + direct * A[i, j]
                J[i, i] += q[i]
            invert(J, row, scheme.size)
        size = 0.0
        largest = 0.0
        for i in range(S):
            total = 0.0
            for j in range(S):
                total += J[i, j] * res[j]
            step[i] = total
            size = max(size, abs(total))
            largest = max(largest, abs(u[i] - total))
        for i in range(S):
            u[i] = max(u[i] - step[i], 1e-9 * largest)
        size /= largest
        if not size < 1e3:
            return -1
        # A full step converges quadratically; what chord steps still lack follows from their contraction.
        rate = size / previous
        left = size * rate / (1.0 - min(rate, 0.9))
        if (factor and size <= full_accept) or (not factor and left <= accept):
            last = True
            factor = False
            continue
        chord = not factor
        if chord and size > 2.0 * previous:
            return -1
        factor = chord and size > 0.25 * previous
        previous = size
    for i in range(S):
        table[i + 1, S_] = past[i, S_]
        table[i + 1, V_] = v[i]
        table[i + 1, T_] = t[i]
        table[i + 1, F_] = F[i]
        for k in range(N):
            table[i + 1, MODES_ + 2 * k] = X[k, i]
            table[i + 1, MODES_ + 1 + 2 * k] = W[k, i]
    return iterations
