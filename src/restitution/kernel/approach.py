"""Approach of the body (Lee and Radok): elements of collocation in sigma, where dt = 2 s dsigma and d = s^2.

    ds/dsigma = v,  dv/dsigma = -2 s (F - w),  dY_k/dsigma = -2 s Y_k/tau_k + dPi/dsigma,
    dW_k/dsigma = -2 s W_k/tau_k + dv/dsigma,  F = E Pi + eta a v + sum E_k Y_k.

Every right-hand side is smooth at first touch. The modes are linear and are eliminated: only s at the nodes is unknown.
"""

import math
from typing import Any

from restitution.kernel.compile import kernel, part
from restitution.kernel.dense import invert
from restitution.kernel.path import radius_and_integral, radius_slope

# Columns of the path, the stored approach: s, v, t, F, then Y_k and W_k of each mode.
S_, V_, T_, F_, MODES_ = 0, 1, 2, 3, 4


@part
def approach_element(problem: Any, scheme: Any, work: Any, table: Any, h: float, accept: float) -> int:
    """Solve one element of length h from the values in row 0 of `table`; fill rows 1 to S.

    `work.x` holds the predicted s at the nodes. Returns the number of Newton iterations, or -1 where they do not converge.
    """
    S = len(scheme.size)
    A, A2, c = scheme.A, scheme.A2, scheme.c
    N = problem.moduli.shape[0]
    s, r, g, F, Pi, a, v = work.x, work.r, work.g, work.F, work.Pi, work.a, work.v
    res, B, Y, J, G, T = work.res, work.B, work.Y, work.J, work.G, work.T
    eta, load = problem.viscosity, problem.load
    s0, v0, t0 = table[0, S_], table[0, V_], table[0, T_]
    Pi0 = radius_and_integral(problem.path, s0)[1]
    full_accept = math.sqrt(accept) * 4.0
    previous = math.inf
    factor = True
    iterations = 0
    while True:
        iterations += 1
        if iterations > 12:
            return -1
        for i in range(S):
            if not s[i] > 0.0:
                return -1
            r[i] = 2.0 * s[i]
            a[i], Pi[i] = radius_and_integral(problem.path, s[i])
            F[i] = problem.equilibrium * Pi[i]
        if factor:
            for i in range(S):
                for j in range(S):
                    G[i, j] = 0.0
                G[i, i] = problem.equilibrium * a[i] * r[i]
            for k in range(N):
                z = h / problem.times[k]
                E = problem.moduli[k]
                Bk = B[k]
                for i in range(S):
                    for j in range(S):
                        Bk[i, j] = z * A[i, j] * r[j]
                    Bk[i, i] += 1.0
                invert(Bk, work.row, S)
                Yk0 = table[0, MODES_ + 2 * k] - Pi0
                for i in range(S):
                    total = 0.0
                    for j in range(S):
                        total += Bk[i, j] * (Pi[j] + Yk0)
                    Y[k, i] = total
                    F[i] += E * total
                for j in range(S):
                    res[j] = E * (a[j] * r[j] + Y[k, j] / s[j])
                for i in range(S):
                    for j in range(S):
                        G[i, j] += Bk[i, j] * res[j]
                    G[i, i] -= E * Y[k, i] / s[i]
        else:
            for k in range(N):
                _refine_force_mode(problem, scheme, work, table, k, h, Pi0)
                for i in range(S):
                    F[i] += problem.moduli[k] * Y[k, i]
        if eta > 0.0:
            _dashpot_velocity(problem, scheme, work, v0, h)
            for i in range(S):
                F[i] += eta * a[i] * v[i]
                total = 0.0
                for j in range(S):
                    total += A[i, j] * v[j]
                res[i] = s[i] - s0 - h * total
        for i in range(S):
            g[i] = r[i] * (F[i] - load)
        if eta == 0.0:
            for i in range(S):
                total = 0.0
                for j in range(S):
                    total += A2[i, j] * g[j]
                res[i] = s[i] - s0 - h * c[i + 1] * v0 + h * h * total
        if factor:
            for i in range(S):
                for j in range(S):
                    G[i, j] *= r[i]
                G[i, i] += 2.0 * (F[i] - load)
                if eta > 0.0:
                    G[i, i] += r[i] * eta * radius_slope(problem.path, s[i], a[i]) * v[i]
            if eta > 0.0:
                _dashpot_product(A, work.D, work.P)
                _dashpot_product(work.P, A, T)
                second = T
            else:
                second = A2
            for i in range(S):
                for j in range(S):
                    total = 0.0
                    for n in range(S):
                        total += second[i, n] * G[n, j]
                    J[i, j] = h * h * total
                J[i, i] += 1.0
            invert(J, work.row, S)
        size = 0.0
        for i in range(S):
            total = 0.0
            for j in range(S):
                total += J[i, j] * res[j]
            work.step[i] = total
            size = max(size, abs(total))
        scale = s0
        for i in range(S):
            s[i] -= work.step[i]
            scale = max(scale, s[i])
        size /= scale
        if not size < 1.0:
            return -1
        if size <= (full_accept if factor else accept):
            break
        # Chord steps with the frozen inverses, until they contract too slowly.
        was_factored = factor
        factor = (not was_factored) and size > 0.25 * previous
        if not was_factored and size > 2.0 * previous:
            return -1
        previous = size
    _finish(problem, scheme, work, table, h, Pi0, v0, t0)
    return iterations


@part
def _refine_force_mode(problem: Any, scheme: Any, work: Any, table: Any, k: int, h: float, Pi0: float) -> None:
    """One residual correction of Y_k: B(s) Y = Pi - Pi_0 + Y_k0 with the frozen inverse of B."""
    S = len(scheme.size)
    A, r, res, Pi = scheme.A, work.r, work.res, work.Pi
    Bk, Yk = work.B[k], work.Y[k]
    z = h / problem.times[k]
    Yk0 = table[0, MODES_ + 2 * k] - Pi0
    for i in range(S):
        work.row[i] = r[i] * Yk[i]
    for i in range(S):
        total = 0.0
        for j in range(S):
            total += A[i, j] * work.row[j]
        res[i] = Pi[i] + Yk0 - Yk[i] - z * total
    for i in range(S):
        total = 0.0
        for j in range(S):
            total += Bk[i, j] * res[j]
        Yk[i] += total


@kernel
def _dashpot_velocity(problem: Any, scheme: Any, work: Any, v0: float, h: float) -> None:
    """Velocity at the nodes where a parallel dashpot makes it implicit; leaves the inverse in `work.D`.

    (I + h A diag(eta r a)) v = v0 - h A r (F - w), F without the dashpot's own part.
    """
    S = len(scheme.size)
    A, F, r, a, v, res, M = scheme.A, work.F, work.r, work.a, work.v, work.res, work.D
    for i in range(S):
        total = 0.0
        for j in range(S):
            M[i, j] = h * A[i, j] * problem.viscosity * r[j] * a[j]
            total += A[i, j] * r[j] * (F[j] - problem.load)
        M[i, i] += 1.0
        res[i] = v0 - h * total
    invert(M, work.row, S)
    for i in range(S):
        total = 0.0
        for j in range(S):
            total += M[i, j] * res[j]
        v[i] = total


@kernel
def _dashpot_product(X: Any, Y: Any, Z: Any) -> None:
    S = X.shape[0]
    for i in range(S):
        for j in range(S):
            total = 0.0
            for n in range(S):
                total += X[i, n] * Y[n, j]
            Z[i, j] = total


@part
def _finish(
    problem: Any, scheme: Any, work: Any, table: Any, h: float, Pi0: float, v0: float, t0: float
) -> None:
    """Fill the element's rows from the converged s; the modes refined once with it (left out, e is off by 2e-8)."""
    S = len(scheme.size)
    A = scheme.A
    N = problem.moduli.shape[0]
    s, r, F, v, res = work.x, work.r, work.F, work.v, work.res
    for i in range(S):
        r[i] = 2.0 * s[i]
        work.a[i], work.Pi[i] = radius_and_integral(problem.path, s[i])
        F[i] = problem.equilibrium * work.Pi[i]
    for k in range(N):
        _refine_force_mode(problem, scheme, work, table, k, h, Pi0)
        for i in range(S):
            F[i] += problem.moduli[k] * work.Y[k, i]
            table[i + 1, MODES_ + 2 * k] = work.Y[k, i]
    if problem.viscosity > 0.0:
        _dashpot_velocity(problem, scheme, work, v0, h)
        for i in range(S):
            F[i] += problem.viscosity * work.a[i] * v[i]
    else:
        for i in range(S):
            total = 0.0
            for j in range(S):
                total += A[i, j] * r[j] * (F[j] - problem.load)
            v[i] = v0 - h * total
    for i in range(S):
        total = 0.0
        for j in range(S):
            total += A[i, j] * r[j]
        table[i + 1, S_] = s[i]
        table[i + 1, V_] = v[i]
        table[i + 1, T_] = t0 + h * total
        table[i + 1, F_] = F[i]
    for k in range(N):
        z = h / problem.times[k]
        Wk0 = table[0, MODES_ + 1 + 2 * k] - v0
        Bk = work.B[k]
        W = work.W[k]
        for i in range(S):
            total = 0.0
            for j in range(S):
                total += Bk[i, j] * (v[j] + Wk0)
            W[i] = total
        for i in range(S):
            total = 0.0
            for j in range(S):
                total += A[i, j] * r[j] * W[j]
            res[i] = v[i] + Wk0 - W[i] - z * total
        for i in range(S):
            total = 0.0
            for j in range(S):
                total += Bk[i, j] * res[j]
            table[i + 1, MODES_ + 1 + 2 * k] = W[i] + total
