"""Rebound of the body (Graham, Ting): the stored approach is walked backwards in lambda, index 1 on its values.

    dt/dlambda = u,  u q + 2 s1 v1 phi = 0,  phi = E + sum E_k X_k,  X_k = exp(-(t - t1)/tau_k),
    q = E v - eta (F - w) + sum E_k [W_k + X_k (v1 - W1_k)],  F = E Pi1 + sum E_k X_k Y1_k,
    dv/dlambda = -(F - w) u,  dW_k/dlambda = -(u/tau_k) W_k + dv/dlambda.

The unknown is u at the nodes; nothing is divided by q. The first line is 0/0 at lambda = 0, where no node lies.
"""

import math
from typing import Any

from restitution.kernel.approach import MODES_, S_, T_, V_
from restitution.kernel.compile import part
from restitution.kernel.dense import invert
from restitution.kernel.path import radius_and_integral


@part
def interpolate_path(
    scheme: Any, path: Any, starts: Any, lengths: Any, element: int, sigma: float, row: Any
) -> int:
    """Write the stored approach at sigma into `row`; return the element that holds it, searched from `element` down."""
    while element > 0 and sigma < starts[element]:
        element -= 1
    points = len(scheme.size) + 1
    columns = row.shape[0]
    x = (sigma - starts[element]) / lengths[element]
    table = path[element]
    total = 0.0
    for n in range(columns):
        row[n] = 0.0
    for j in range(points):
        distance = x - scheme.c[j]
        if abs(distance) < 1e-14:
            for n in range(columns):
                row[n] = table[j, n]
            return element
        weight = scheme.weights[j] / distance
        total += weight
        for n in range(columns):
            row[n] += weight * table[j, n]
    inverse = 1.0 / total
    for n in range(columns):
        row[n] *= inverse
    return element


@part
def rebound_element(problem: Any, scheme: Any, work: Any, table: Any, h: float, accept: float) -> int:
    """Solve one element of length h from the values in row 0 of `table`; fill rows 1 to S.

    `work.x` holds the predicted u at the nodes and `work.past` the stored approach there. Columns of `table`: the stored
    s1, then v, t, F, and W_k in place of the approach's. Returns the number of Newton iterations, or -1 on failure.
    """
    S = len(scheme.size)
    A = scheme.A
    N = problem.moduli.shape[0]
    u, t, v, F, q = work.x, work.r, work.v, work.F, work.g
    past, B, W, X, J, G, C = work.past, work.B, work.W, work.Y, work.J, work.G, work.T
    phi, phi_t, F_t, q_t, res = work.a, work.phi_t, work.F_t, work.q_t, work.res
    v0, t0 = table[0, V_], table[0, T_]
    eta, load, equilibrium = problem.viscosity, problem.load, problem.equilibrium
    full_accept = math.sqrt(accept) * 4.0
    previous = math.inf
    factor = True
    last = False
    iterations = 0
    while True:
        iterations += 1
        if iterations > 14:
            return -1
        for i in range(S):
            total = 0.0
            for j in range(S):
                total += A[i, j] * u[j]
            t[i] = t0 + h * total
            F[i] = equilibrium * work.Pi[i]
            phi[i] = equilibrium
            phi_t[i] = 0.0
            F_t[i] = 0.0
            q_t[i] = 0.0
        for k in range(N):
            rate = 1.0 / problem.times[k]
            E = problem.moduli[k]
            for i in range(S):
                x = math.exp(min((past[i, T_] - t[i]) * rate, 0.0))
                X[k, i] = x
                x *= E
                force = x * past[i, MODES_ + 2 * k]
                F[i] += force
                F_t[i] -= force * rate
                phi[i] += x
                phi_t[i] -= x * rate
                q_t[i] -= x * rate * (past[i, V_] - past[i, MODES_ + 1 + 2 * k])
        for i in range(S):
            total = 0.0
            for j in range(S):
                total += A[i, j] * (F[j] - load) * u[j]
            v[i] = v0 - h * total
            q[i] = equilibrium * v[i] - eta * (F[i] - load)
        if factor:
            # C = h dv/du: the modes' share of q follows v through the inverses.
            for j in range(S):
                work.row[j] = u[j] * F_t[j]
            for i in range(S):
                for j in range(S):
                    total = 0.0
                    for n in range(S):
                        total += A[i, n] * work.row[n] * A[n, j]
                    C[i, j] = -h * (A[i, j] * (F[j] - load) + h * total)
                    G[i, j] = 0.0
                    J[i, j] = 0.0
                G[i, i] = equilibrium
        for k in range(N):
            E = problem.moduli[k]
            if factor:
                z = h / problem.times[k]
                Bk = B[k]
                Wk0 = table[0, MODES_ + 1 + 2 * k] - v0
                for i in range(S):
                    for j in range(S):
                        Bk[i, j] = z * A[i, j] * u[j]
                    Bk[i, i] += 1.0
                invert(Bk, work.row, S)
                for i in range(S):
                    total = 0.0
                    for j in range(S):
                        total += Bk[i, j] * (v[j] + Wk0)
                    W[k, i] = total
                for j in range(S):
                    work.row[j] = E * W[k, j] / u[j]
                for i in range(S):
                    for j in range(S):
                        G[i, j] += E * Bk[i, j]
                        J[i, j] += Bk[i, j] * work.row[j]
                    J[i, i] -= work.row[i]
            else:
                _refine_displacement_mode(problem, scheme, work, table, k, h)
            for i in range(S):
                q[i] += E * (W[k, i] + X[k, i] * (past[i, V_] - past[i, MODES_ + 1 + 2 * k]))
        if last:
            break
        for i in range(S):
            res[i] = u[i] * q[i] + 2.0 * past[i, S_] * past[i, V_] * phi[i]
        if factor:
            for i in range(S):
                row = 2.0 * past[i, S_] * past[i, V_] * phi_t[i]
                for j in range(S):
                    total = J[i, j]
                    for n in range(S):
                        total += G[i, n] * C[n, j]
                    total += h * A[i, j] * (q_t[i] - eta * F_t[i])
                    work.P[i, j] = u[i] * total + row * h * A[i, j]
                work.P[i, i] += q[i]
            invert(work.P, work.row, S)
        size = 0.0
        largest = 0.0
        for i in range(S):
            total = 0.0
            for j in range(S):
                total += work.P[i, j] * res[j]
            work.step[i] = total
            size = max(size, abs(total))
            largest = max(largest, abs(u[i] - total))
        for i in range(S):
            u[i] = max(u[i] - work.step[i], 1e-9 * largest)
        size /= largest
        if not size < 1e3:
            return -1
        if size <= (full_accept if factor else accept):
            last = True
            factor = False
            continue
        was_factored = factor
        factor = (not was_factored) and size > 0.25 * previous
        if not was_factored and size > 2.0 * previous:
            return -1
        previous = size
    for i in range(S):
        table[i + 1, S_] = past[i, S_]
        table[i + 1, V_] = v[i]
        table[i + 1, T_] = t[i]
        table[i + 1, MODES_ - 1] = F[i]
        for k in range(N):
            table[i + 1, MODES_ + 2 * k] = X[k, i]
            table[i + 1, MODES_ + 1 + 2 * k] = W[k, i]
    return iterations


@part
def _refine_displacement_mode(problem: Any, scheme: Any, work: Any, table: Any, k: int, h: float) -> None:
    """One residual correction of W_k: B(u) W = v + W_k0 - v_0 with the frozen inverse of B."""
    S = len(scheme.size)
    A, u, res, v = scheme.A, work.x, work.res, work.v
    Bk, Wk = work.B[k], work.W[k]
    z = h / problem.times[k]
    Wk0 = table[0, MODES_ + 1 + 2 * k] - table[0, V_]
    for i in range(S):
        work.row[i] = u[i] * Wk[i]
    for i in range(S):
        total = 0.0
        for j in range(S):
            total += A[i, j] * work.row[j]
        res[i] = v[i] + Wk0 - Wk[i] - z * total
    for i in range(S):
        total = 0.0
        for j in range(S):
            total += Bk[i, j] * res[j]
        Wk[i] += total
