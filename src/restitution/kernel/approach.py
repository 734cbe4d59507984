"""Approach of the body (Lee and Radok): elements of collocation in sigma, where dt = 2 s dsigma and d = s^2.

    ds/dsigma = v,  dv/dsigma = -2 s (F - w),  dY_k/dsigma = -2 s Y_k/tau_k + dPi/dsigma,
    dW_k/dsigma = -2 s W_k/tau_k + dv/dsigma,  F = E Pi + eta a v + sum E_k Y_k.

Every right-hand side is smooth at first touch. The modes are linear and are eliminated: only s at the nodes is unknown.
Stored points hold s, v, t, F and, of each mode, Y_k and W_k.
"""

import math
from typing import Any

from restitution.kernel.compile import part, stage
from restitution.kernel.dense import invert
from restitution.kernel.path import radius_and_integral, radius_slope
from restitution.kernel.workspace import (
    COUPLING,
    DASHPOT,
    F_,
    FORCE,
    INTEGRAL,
    JACOBIAN,
    MODES_,
    RADIUS,
    RATE,
    RESIDUAL,
    S_,
    SCRATCH,
    SLOPE,
    SPEED,
    STEP,
    SUM,
    T_,
    UNKNOWN,
    V_,
    WEIGHTED,
)

_MOST_ITERATIONS = 12


@part
def approach_element(problem: Any, scheme: Any, work: Any, table: Any, h: float, accept: float) -> int:
    """Solve one element of length h from the values in row 0 of `table`; fill rows 1 to S.

    `work.vectors[UNKNOWN]` holds the predicted s at the nodes. Returns the number of Newton iterations, or -1 where they
    do not converge.
    """
    S = len(scheme.size)
    A, A2, c = scheme.A, scheme.A2, scheme.c
    N = problem.moduli.shape[0]
    vectors, B, Y = work.vectors, work.inverses, work.modes[0]
    s, r, g, F, Pi, a, v = (
        vectors[UNKNOWN], vectors[RATE], vectors[SLOPE], vectors[FORCE], vectors[INTEGRAL], vectors[RADIUS],
        vectors[SPEED],
    )  # fmt: skip
    res, row, step = vectors[RESIDUAL], vectors[SCRATCH], vectors[STEP]
    J, G = work.matrices[JACOBIAN], work.matrices[SUM]
    eta, load, equilibrium = problem.viscosity, problem.load, problem.equilibrium
    s0, v0 = table[0, S_], table[0, V_]
    Pi0 = radius_and_integral(problem.path, s0)[1]
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
            if not s[i] > 0.0:
                return -1
            r[i] = 2.0 * s[i]
            a[i], Pi[i] = radius_and_integral(problem.path, s[i])
            F[i] = equilibrium * Pi[i]
        if factor:
            for i in range(S):
                for j in range(S):
                    G[i, j] = 0.0
                G[i, i] = equilibrium * a[i] * r[i]
        for k in range(N):
            z = h / problem.times[k]
            E = problem.moduli[k]
            Bk, Yk = B[k], Y[k]
            start = table[0, MODES_ + 2 * k] - Pi0
            if factor:
                for i in range(S):
                    for j in range(S):
                        Bk[i, j] = z * A[i, j] * r[j]
                    Bk[i, i] += 1.0
                invert(Bk, row, scheme.size)
                for i in range(S):
                    total = 0.0
                    for j in range(S):
                        total += Bk[i, j] * (Pi[j] + start)
                    Yk[i] = total
                # dY/ds: B depends on s too, and (h/tau) B^-1 A diag(r) = 1 - B^-1.
                for j in range(S):
                    row[j] = E * (a[j] * r[j] + Yk[j] / s[j])
                for i in range(S):
                    for j in range(S):
                        G[i, j] += Bk[i, j] * row[j]
                    G[i, i] -= E * Yk[i] / s[i]
            else:
                for j in range(S):
                    row[j] = r[j] * Yk[j]
                for i in range(S):
                    total = 0.0
                    for j in range(S):
                        total += A[i, j] * row[j]
                    res[i] = Pi[i] + start - Yk[i] - z * total
                for i in range(S):
                    total = 0.0
                    for j in range(S):
                        total += Bk[i, j] * res[j]
                    Yk[i] += total
            for i in range(S):
                F[i] += E * Yk[i]
        if eta > 0.0:
            _add_dashpot(problem, scheme, work, v0, h)
        for i in range(S):
            g[i] = r[i] * (F[i] - load)
        if last:
            break
        if eta > 0.0:
            for i in range(S):
                total = 0.0
                for j in range(S):
                    total += A[i, j] * v[j]
                res[i] = s[i] - s0 - h * total
        else:
            for i in range(S):
                total = 0.0
                for j in range(S):
                    total += A2[i, j] * g[j]
                res[i] = s[i] - s0 - h * c[i + 1] * v0 + h * h * total
        if factor:
            second = A2
            if eta > 0.0:
                _dashpot_coupling(problem, scheme, work)
                second = work.matrices[COUPLING]
            for i in range(S):
                for j in range(S):
                    G[i, j] *= r[i]
                G[i, i] += 2.0 * (F[i] - load)
            for i in range(S):
                for j in range(S):
                    total = 0.0
                    for n in range(S):
                        total += second[i, n] * G[n, j]
                    J[i, j] = h * h * total
                J[i, i] += 1.0
            invert(J, row, scheme.size)
        size = 0.0
        for i in range(S):
            total = 0.0
            for j in range(S):
                total += J[i, j] * res[j]
            step[i] = total
            size = max(size, abs(total))
        scale = s0
        for i in range(S):
            s[i] -= step[i]
            scale = max(scale, s[i])
        size /= scale
        if not size < 1.0:
            return -1
        # A full step converges quadratically; what chord steps still lack follows from their contraction.
        rate = size / previous
        left = size * rate / (1.0 - min(rate, 0.9))
        if (factor and size <= full_accept) or (not factor and left <= accept):
            # One more round refines the modes with the final s: left out, e is off by 2e-8.
            last = True
            factor = False
            continue
        # Chord steps with the frozen inverses, until they contract too slowly.
        chord = not factor
        if chord and size > 2.0 * previous:
            return -1
        factor = chord and size > 0.25 * previous
        previous = size
    _store(problem, scheme, work, table, h)
    return iterations


@part
def _store(problem: Any, scheme: Any, work: Any, table: Any, h: float) -> None:
    """Fill the element's rows from the converged s and the modes that belong to it."""
    S = len(scheme.size)
    A = scheme.A
    vectors = work.vectors
    s, r, g, F, v = vectors[UNKNOWN], vectors[RATE], vectors[SLOPE], vectors[FORCE], vectors[SPEED]
    res, row = vectors[RESIDUAL], vectors[SCRATCH]
    v0, t0 = table[0, V_], table[0, T_]
    for i in range(S):
        total = 0.0
        duration = 0.0
        for j in range(S):
            total += A[i, j] * g[j]
            duration += A[i, j] * r[j]
        v[i] = v0 - h * total
        table[i + 1, S_] = s[i]
        table[i + 1, V_] = v[i]
        table[i + 1, T_] = t0 + h * duration
        table[i + 1, F_] = F[i]
    for k in range(problem.moduli.shape[0]):
        z = h / problem.times[k]
        Bk, Wk = work.inverses[k], work.modes[1, k]
        start = table[0, MODES_ + 1 + 2 * k] - v0
        for i in range(S):
            total = 0.0
            for j in range(S):
                total += Bk[i, j] * (v[j] + start)
            Wk[i] = total
            row[i] = r[i] * total
        for i in range(S):
            total = 0.0
            for j in range(S):
                total += A[i, j] * row[j]
            res[i] = v[i] + start - Wk[i] - z * total
        for i in range(S):
            total = 0.0
            for j in range(S):
                total += Bk[i, j] * res[j]
            table[i + 1, MODES_ + 2 * k] = work.modes[0, k, i]
            table[i + 1, MODES_ + 1 + 2 * k] = Wk[i] + total


@stage
def _add_dashpot(problem: Any, scheme: Any, work: Any, v0: float, h: float) -> None:
    """Add the force eta a v of a parallel dashpot, which makes v implicit; leave the inverse in `matrices[DASHPOT]`.

    (I + h A diag(eta r a)) v = v0 - h A r (F - w), F without the dashpot's own part.
    """
    S = len(scheme.size)
    A, vectors, M = scheme.A, work.vectors, work.matrices[DASHPOT]
    F, r, a, v, res = vectors[FORCE], vectors[RATE], vectors[RADIUS], vectors[SPEED], vectors[RESIDUAL]
    for i in range(S):
        total = 0.0
        for j in range(S):
            M[i, j] = h * A[i, j] * problem.viscosity * r[j] * a[j]
            total += A[i, j] * r[j] * (F[j] - problem.load)
        M[i, i] += 1.0
        res[i] = v0 - h * total
    invert(M, vectors[SCRATCH], scheme.size)
    for i in range(S):
        total = 0.0
        for j in range(S):
            total += M[i, j] * res[j]
        v[i] = total
    for i in range(S):
        F[i] += problem.viscosity * a[i] * v[i]


@stage
def _dashpot_coupling(problem: Any, scheme: Any, work: Any) -> None:
    """Write A M^-1 A, which takes the place of A^2, and add the slope of eta a v at fixed v to the modes' sum."""
    S = len(scheme.size)
    A, vectors = scheme.A, work.vectors
    inverse, product, coupling = work.matrices[DASHPOT], work.matrices[WEIGHTED], work.matrices[COUPLING]
    for i in range(S):
        for j in range(S):
            total = 0.0
            for n in range(S):
                total += A[i, n] * inverse[n, j]
            product[i, j] = total
    for i in range(S):
        for j in range(S):
            total = 0.0
            for n in range(S):
                total += product[i, n] * A[n, j]
            coupling[i, j] = total
        slope = radius_slope(problem.path, vectors[UNKNOWN, i], vectors[RADIUS, i])
        work.matrices[SUM, i, i] += problem.viscosity * slope * vectors[SPEED, i]
