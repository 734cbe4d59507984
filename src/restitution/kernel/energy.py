"""Where the energy went: what the dashpots of the foundation dissipate, and what it still stores as it is left.

Quadrature over the foundation from the stored halves of a solved impact, in the generalised Maxwell form of the reduced
modulus. An element at x, touched at t0(x), carries in mode k the elongation `w_k = H_k(t) - exp(-(t - t0)/tau_k) H_k(t0)`
with `H_k = int_0^t exp(-(t - t')/tau_k) d' dt'`. Over the elements in contact

    int_0^a w_k^2 dx = a H_k^2 - 2 H_k P_k + Q_k,
    dP_k = -(P_k/tau_k) dt + H_k da,  dQ_k = -(2 Q_k/tau_k) dt + H_k^2 da,

during the approach; in the rebound P_k and Q_k are those of the instant t1 with the same contact radius, times X_k and
X_k^2. H_k is integrated here by itself: taken from the kernel's W_k it would lose digits for slow modes.
"""

import math
from typing import Any

import numpy as np

from restitution.kernel.compile import kernel, part
from restitution.kernel.dense import invert
from restitution.kernel.impact import (
    FIRST,
    SEPARATED,
    Problem,
    interpolate,
    seek,
    solve_one,
)
from restitution.kernel.path import Path, radius_and_integral, radius_slope
from restitution.kernel.radau import Scheme
from restitution.kernel.workspace import (
    BACK_LENGTH,
    BACK_START,
    LENGTH,
    MODES_,
    N_APPROACH,
    N_REBOUND,
    S_,
    START,
    T_,
    V_,
    Work,
)


@kernel
def _propagate(
    scheme: Any, B: Any, row: Any, rate: float, h: float, r: Any, source: Any, start: float, out: Any
) -> None:
    """Write into `out` the nodes of y' = -rate r y + source, y(0) = start, over an element of length h."""
    S = len(scheme.size)
    A = scheme.A
    for i in range(S):
        for j in range(S):
            B[i, j] = h * rate * A[i, j] * r[j]
        B[i, i] += 1.0
    invert(B, row, scheme.size)
    for i in range(S):
        total = start
        for j in range(S):
            total += h * A[i, j] * source[j]
        row[i] = total
    for i in range(S):
        total = 0.0
        for j in range(S):
            total += B[i, j] * row[j]
        out[i] = total


@kernel
def energy_budget(problem: Problem, scheme: Scheme, work: Work) -> tuple[float, float]:
    """Energy dissipated and energy still stored at separation, in units of m v0^2.

    `work` holds the stored halves of an impact that ended in separation.
    """
    S = len(scheme.size)
    A = scheme.A
    N = problem.moduli.shape[0]
    points = S + 1
    elements = work.counts[N_APPROACH] + 1
    # Columns per mode: H, P, Q.
    memory = np.zeros((elements, points, 3 * N))
    B = np.zeros((S, S))
    row, r, source, y = np.zeros(S), np.zeros(S), np.zeros(S), np.zeros(S)
    slope, a = np.zeros(S), np.zeros(S)
    power = np.zeros(points)
    dissipated = 0.0
    sigma_m = work.turning_place[0]
    for element in range(elements):
        table = work.approach[element]
        h = work.places[LENGTH, element]
        for i in range(S):
            s = table[i + 1, S_]
            r[i] = 2.0 * s
            a[i] = radius_and_integral(problem.path, s)[0]
            slope[i] = radius_slope(problem.path, s, a[i]) * table[i + 1, V_]
            power[i + 1] = problem.viscosity * a[i] * table[i + 1, V_] ** 2 * r[i]
        for k in range(N):
            rate = 1.0 / problem.times[k]
            if element > 0:
                for n in range(3):
                    memory[element, 0, 3 * k + n] = memory[element - 1, S, 3 * k + n]
            H0, P0, Q0 = (
                memory[element, 0, 3 * k],
                memory[element, 0, 3 * k + 1],
                memory[element, 0, 3 * k + 2],
            )
            for i in range(S):
                source[i] = r[i] * table[i + 1, V_]
            _propagate(scheme, B, row, rate, h, r, source, H0, y)
            for i in range(S):
                memory[element, i + 1, 3 * k] = y[i]
                source[i] = y[i] * slope[i]
            _propagate(scheme, B, row, rate, h, r, source, P0, y)
            for i in range(S):
                memory[element, i + 1, 3 * k + 1] = y[i]
                source[i] *= memory[element, i + 1, 3 * k]
            _propagate(scheme, B, row, 2.0 * rate, h, r, source, Q0, y)
            for i in range(S):
                H = memory[element, i + 1, 3 * k]
                square = a[i] * H * H - 2.0 * H * memory[element, i + 1, 3 * k + 1] + y[i]
                memory[element, i + 1, 3 * k + 2] = y[i]
                power[i + 1] += problem.moduli[k] * rate * square * r[i]
        end = min((sigma_m - work.places[START, element]) / h, 1.0)
        dissipated += _integral(scheme, power, h, end)
    stored = 0.0
    H_now = np.zeros(N)
    now = np.zeros(MODES_ + 2 * N)
    memory_now = np.zeros(3 * N)
    hint = elements - 1
    x = (sigma_m - work.places[START, hint]) / work.places[LENGTH, hint]
    interpolate(scheme, work, memory[hint], x, memory_now)
    for k in range(N):
        H_now[k] = memory_now[3 * k]
    d0 = work.turning[S_] ** 2
    density = np.zeros(points)
    radius = np.zeros(points)
    radius[S] = radius_and_integral(problem.path, work.turning[S_])[0]
    elongation = np.zeros((points, N))
    u = np.zeros(S)
    v = np.zeros(S)
    past = np.zeros((S, 3 * N))
    d = np.zeros(points)
    s1 = np.zeros(points)
    s1[S] = work.turning[S_]
    d[S] = d0
    for element in range(work.counts[N_REBOUND] + 1):
        table = work.rebound[element]
        h = work.places[BACK_LENGTH, element]
        radius[0], s1[0], d[0], density[0] = radius[S], s1[S], d[S], density[S]
        place = hint
        for i in range(S):
            sigma = sigma_m - work.places[BACK_START, element] - h * scheme.c[i + 1]
            if element == work.counts[N_REBOUND] and i == S - 1:
                sigma = 0.0
            place = seek(work.places, place, sigma)
            x = (sigma - work.places[START, place]) / work.places[LENGTH, place]
            interpolate(scheme, work, work.approach[place], x, now)
            s1[i + 1] = now[S_]
            past_t = now[T_]
            for k in range(N):
                # The kernel's own X_k are at these nodes as well; this way nothing but t is taken over.
                elongation[i + 1, k] = math.exp(min((past_t - table[i + 1, T_]) / problem.times[k], 0.0))
            interpolate(scheme, work, memory[place], x, past[i])
            radius[i + 1] = radius_and_integral(problem.path, now[S_])[0]
            u[i] = work.slopes[element, i]
            v[i] = table[i + 1, V_]
            power[i + 1] = problem.viscosity * radius[i + 1] * v[i] ** 2 * u[i]
        hint = place
        for i in range(S):
            total = d[0]
            for j in range(S):
                total += h * A[i, j] * u[j] * v[j]
            d[i + 1] = total
            density[i + 1] = 0.5 * problem.equilibrium * (total - s1[i + 1] ** 2) ** 2
            source[i] = u[i] * v[i]
        for k in range(N):
            rate = 1.0 / problem.times[k]
            _propagate(scheme, B, row, rate, h, u, source, H_now[k], y)
            H_now[k] = y[S - 1]
            for i in range(S):
                X = elongation[i + 1, k]
                H = y[i]
                square = radius[i + 1] * H * H - 2.0 * H * X * past[i, 3 * k + 1] + X * X * past[i, 3 * k + 2]
                power[i + 1] += problem.moduli[k] * rate * square * u[i]
                density[i + 1] += 0.5 * problem.moduli[k] * (H - X * past[i, 3 * k]) ** 2
        dissipated += _integral(scheme, power, h, 1.0)
        # Stored energy: - int density da = int a d(density), which has no singular a'(s) and includes a flat core.
        for i in range(S):
            total = 0.0
            for j in range(points):
                total += scheme.derivative[i + 1, j] * density[j]
            stored += A[S - 1, i] * radius[i + 1] * total
    return dissipated, stored


@part
def _integral(scheme: Any, values: Any, h: float, end: float) -> float:
    """Integral from 0 to `end` of the polynomial with these values at the nodes 1 to S of an element of length h."""
    S = len(scheme.size)
    if end == 1.0:
        total = 0.0
        for j in range(S):
            total += scheme.A[S - 1, j] * values[j + 1]
        return h * total
    top = 0.0
    bottom = 0.0
    for i in range(S + 1):
        value = 0.0
        if i > 0:
            for j in range(S):
                value += scheme.A[i - 1, j] * values[j + 1]
        distance = end - scheme.c[i]
        if abs(distance) < 1e-14:
            return h * value
        weight = scheme.weights[i] / distance
        top += weight * value
        bottom += weight
    return h * top / bottom


@kernel
def budget_block(
    scheme: Scheme,
    tolerance: float,
    accept: float,
    firsts: Any,
    equilibria: Any,
    viscosities: Any,
    loads: Any,
    offsets: Any,
    moduli: Any,
    times: Any,
    path: Path,
    work: Work,
    outcomes: Any,
) -> None:
    """Solve a block as `solve_block` does; two more columns of `outcomes` take the energy dissipated and stored."""
    columns = outcomes.shape[1]
    for n in range(offsets.shape[0] - 1):
        low, high = offsets[n], offsets[n + 1]
        problem = Problem(equilibria[n], moduli[low:high], times[low:high], viscosities[n], loads[n], path)
        solve_one(problem, scheme, work, tolerance, accept, FIRST * firsts[n], outcomes[n])
        if outcomes[n, columns - 4] == SEPARATED:
            outcomes[n, columns - 2], outcomes[n, columns - 1] = energy_budget(problem, scheme, work)
