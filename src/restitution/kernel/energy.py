"""Where the energy went: what the dashpots of the foundation dissipate, and what it stores as it is left.

Quadrature over the foundation from the stored halves of a solved impact, in the generalised Maxwell form of the
reduced modulus. An element at x, touched at t0(x), carries in mode k the elongation
`w_k = H_k(t) - exp(-(t - t0)/tau_k) H_k(t0)` with `H_k = int_0^t exp(-(t - t')/tau_k) d' dt'`. Over the elements
in contact, with `P_k = int_0^a exp(-(t - t0)/tau_k) H_k(t0) dx` and Q_k the same of the squares,

    int_0^a w_k^2 dx = a H_k^2 - 2 H_k P_k + Q_k.

By parts, so that da/dsigma, singular at blunt tips, does not appear: `P_k = a H_k - Y_k`, `Q_k = a H_k^2 - Z_k`,

    dH_k = -(H_k/tau_k) dt + dd,  dY_k = -(Y_k/tau_k) dt + a dd,  dZ_k = -(2 Z_k/tau_k) dt + 2 a H_k dd.

In the rebound P_k and Q_k are those of the instant t1 with the same contact radius, times X_k and X_k^2. H_k is
integrated here by itself: taken from the kernel's W_k it would lose digits for slow modes.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from restitution.kernel.compile import kernel, part, stage
from restitution.kernel.dense import invert, lagrange
from restitution.kernel.impact import Problem, interpolate, seek
from restitution.kernel.path import radius_and_integral
from restitution.kernel.radau import Scheme
from restitution.kernel.workspace import (
    BACK_LENGTH,
    BACK_START,
    BASIS,
    COUPLING,
    LENGTH,
    N_APPROACH,
    N_REBOUND,
    S_,
    SCRATCH,
    START,
    T_,
    V_,
    Work,
)

# Rows of `nodes`: contact radius, depth, stored energy per length, power, dt of the path, a source, a solution.
A, D, DENSITY, POWER, RATE, SOURCE, SOLUTION, N_ROWS = range(8)


class Ledger(NamedTuple):
    """Scratch space of the energy budget for S stages, N modes and E elements.

    Attributes
    ----------
    memory : ndarray, shape (E, S + 1, 3 N)
        H_k, Y_k, Z_k along the approach.
    nodes : ndarray, shape (7, S + 1)
    past : ndarray, shape (S, 3 N)
        The memory at the instants t1 of a rebound element's nodes.
    decay : ndarray, shape (S, N)
        X_k there.
    present : ndarray, shape (3 N,)
        H_k now, in every third place.
    """

    memory: Any
    nodes: Any
    past: Any
    decay: Any
    present: Any


def allocate_ledger(S: int, N: int, elements: int) -> Ledger:
    """Scratch space of the energy budget."""
    return Ledger(
        np.zeros((elements, S + 1, 3 * N)),
        np.zeros((N_ROWS, S + 1)),
        np.zeros((S, 3 * N)),
        np.zeros((S, N)),
        np.zeros(3 * N),
    )


@part
def _propagate(scheme: Any, work: Any, nodes: Any, rate: float, h: float, start: float) -> None:
    """Write into nodes[SOLUTION] the y of y' = -rate nodes[RATE] y + nodes[SOURCE], y(0) = start."""
    S = len(scheme.size)
    B, row, y = work.matrices[COUPLING], work.vectors[SCRATCH], nodes[SOLUTION]
    for i in range(S):
        for j in range(S):
            B[i, j] = h * rate * scheme.A[i, j] * nodes[RATE, j + 1]
        B[i, i] += 1.0
    invert(B, row, scheme.size)
    for i in range(S):
        total = start
        for j in range(S):
            total += h * scheme.A[i, j] * nodes[SOURCE, j + 1]
        row[i] = total
    for i in range(S):
        total = 0.0
        for j in range(S):
            total += B[i, j] * row[j]
        y[i + 1] = total


@part
def _integral(scheme: Any, work: Any, values: Any, h: float, end: float) -> float:
    """Integral from 0 to `end` of the polynomial with these values at the nodes of an element of length h."""
    S = len(scheme.size)
    basis = work.vectors[BASIS]
    lagrange(scheme.c, scheme.weights, S + 1, end, basis)
    total = 0.0
    for i in range(S):
        for j in range(S):
            total += basis[i + 1] * scheme.A[i, j] * values[j + 1]
    return h * total


@kernel
def approach_budget(problem: Problem, scheme: Scheme, work: Work, ledger: Ledger) -> float:
    """Energy dissipated during the approach, in units of m v0^2; leaves the memory in the ledger.

    `work` holds the stored halves of an impact that ended in separation. An entry point of its own, not a part of
    `solve_block`: whoever does not ask for the energy does not wait for its compilation.
    """
    S = len(scheme.size)
    N = problem.moduli.shape[0]
    nodes, memory = ledger.nodes, ledger.memory
    dissipated = 0.0
    for element in range(work.counts[N_APPROACH] + 1):
        table = work.approach[element]
        h = work.places[LENGTH, element]
        for i in range(1, S + 1):
            s, v = table[i, S_], table[i, V_]
            a = radius_and_integral(problem.path, s)[0]
            nodes[RATE, i] = 2.0 * s
            nodes[A, i] = a
            nodes[POWER, i] = problem.viscosity * a * v * v * 2.0 * s
        for k in range(N):
            rate = 1.0 / problem.times[k]
            for n in range(3):
                memory[element, 0, 3 * k + n] = memory[element - 1, S, 3 * k + n] if element > 0 else 0.0
            for i in range(1, S + 1):
                nodes[SOURCE, i] = nodes[RATE, i] * table[i, V_]
            for n in range(3):
                # H of source dd, Y of a dd, Z of 2 a H dd, which decays at twice the rate.
                _propagate(
                    scheme, work, nodes, 2.0 * rate if n == 2 else rate, h, memory[element, 0, 3 * k + n]
                )
                for i in range(1, S + 1):
                    memory[element, i, 3 * k + n] = nodes[SOLUTION, i]
                    if n == 0:
                        nodes[SOURCE, i] *= nodes[A, i]
                    elif n == 1:
                        nodes[SOURCE, i] *= 2.0 * memory[element, i, 3 * k]
            for i in range(1, S + 1):
                H, Y, Z = (
                    memory[element, i, 3 * k],
                    memory[element, i, 3 * k + 1],
                    memory[element, i, 3 * k + 2],
                )
                square = 2.0 * H * Y - Z
                nodes[POWER, i] += problem.moduli[k] * rate * square * nodes[RATE, i]
        end = min((work.turning_place[0] - work.places[START, element]) / h, 1.0)
        dissipated += _integral(scheme, work, nodes[POWER], h, end)
    return dissipated


@stage
def _stored(
    problem: Problem, scheme: Scheme, work: Work, nodes: Any, is_last: bool, sigma: float, h: float
) -> float:
    """Energy stored by the elements that a rebound element leaves: - int density da = int a d(density).

    The second form has no singular a'(s) and includes a flat core. At separation a(s) of a blunt tip has an infinite
    slope, so the last element is divided towards its end.
    """
    S = len(scheme.size)
    basis, slope = work.vectors[BASIS], nodes[SOLUTION]
    for i in range(S + 1):
        total = 0.0
        for j in range(S + 1):
            total += scheme.derivative[i, j] * nodes[DENSITY, j]
        slope[i] = total
    stored = 0.0
    parts = 24 if is_last else 1
    low = 0.0
    for n in range(parts):
        high = 1.0 if n == parts - 1 else 0.5 * (low + 1.0)
        for i in range(S):
            x = low + (high - low) * scheme.c[i + 1]
            lagrange(scheme.c, scheme.weights, S + 1, x, basis)
            value = 0.0
            for j in range(S + 1):
                value += basis[j] * slope[j]
            a = nodes[A, i + 1]
            if is_last:
                place = max(sigma - h * x, 0.0)
                element = seek(work.places, work.counts[N_APPROACH], place)
                lagrange(
                    scheme.c, scheme.weights, S + 1,
                    (place - work.places[START, element]) / work.places[LENGTH, element], basis,
                )  # fmt: skip
                s = 0.0
                for j in range(S + 1):
                    s += basis[j] * work.approach[element, j, S_]
                a = radius_and_integral(problem.path, s)[0]
            stored += (high - low) * scheme.A[S - 1, i] * a * value
        low = high
    return stored


@kernel
def rebound_budget(problem: Problem, scheme: Scheme, work: Work, ledger: Ledger) -> tuple[float, float]:
    """Energy dissipated during the rebound, and stored by the elements as they are left; after `approach_budget`."""
    S = len(scheme.size)
    N = problem.moduli.shape[0]
    nodes, memory, past, decay, present = (
        ledger.nodes,
        ledger.memory,
        ledger.past,
        ledger.decay,
        ledger.present,
    )
    sigma_m = work.turning_place[0]
    last = work.counts[N_REBOUND]
    place = work.counts[N_APPROACH]
    x = (sigma_m - work.places[START, place]) / work.places[LENGTH, place]
    interpolate(scheme, work, memory[place], x, present)
    dissipated = 0.0
    stored = 0.0
    nodes[D, S] = work.turning[S_] ** 2
    nodes[DENSITY, S] = 0.0
    for element in range(last + 1):
        table = work.rebound[element]
        h = work.places[BACK_LENGTH, element]
        nodes[D, 0], nodes[DENSITY, 0] = nodes[D, S], nodes[DENSITY, S]
        for i in range(S):
            sigma = sigma_m - work.places[BACK_START, element] - h * scheme.c[i + 1]
            if element == last and i == S - 1:
                sigma = 0.0
            place = seek(work.places, place, sigma)
            x = (sigma - work.places[START, place]) / work.places[LENGTH, place]
            interpolate(scheme, work, work.approach[place], x, work.past[i])
            interpolate(scheme, work, memory[place], x, past[i])
            for k in range(N):
                decay[i, k] = math.exp(min((work.past[i, T_] - table[i + 1, T_]) / problem.times[k], 0.0))
            v = table[i + 1, V_]
            a = radius_and_integral(problem.path, work.past[i, S_])[0]
            nodes[A, i + 1] = a
            nodes[RATE, i + 1] = work.slopes[element, i]
            nodes[SOURCE, i + 1] = work.slopes[element, i] * v
            nodes[POWER, i + 1] = problem.viscosity * a * v * v * work.slopes[element, i]
        for i in range(S):
            total = nodes[D, 0]
            for j in range(S):
                total += h * scheme.A[i, j] * nodes[SOURCE, j + 1]
            nodes[D, i + 1] = total
            nodes[DENSITY, i + 1] = 0.5 * problem.equilibrium * (total - work.past[i, S_] ** 2) ** 2
        for k in range(N):
            rate = 1.0 / problem.times[k]
            _propagate(scheme, work, nodes, rate, h, present[3 * k])
            present[3 * k] = nodes[SOLUTION, S]
            for i in range(S):
                X, H, H1 = decay[i, k], nodes[SOLUTION, i + 1], past[i, 3 * k]
                P = nodes[A, i + 1] * H1 - past[i, 3 * k + 1]
                Q = nodes[A, i + 1] * H1 * H1 - past[i, 3 * k + 2]
                square = nodes[A, i + 1] * H * H - 2.0 * H * X * P + X * X * Q
                nodes[POWER, i + 1] += problem.moduli[k] * rate * square * nodes[RATE, i + 1]
                nodes[DENSITY, i + 1] += 0.5 * problem.moduli[k] * (H - X * H1) ** 2
        dissipated += _integral(scheme, work, nodes[POWER], h, 1.0)
        stored += _stored(
            problem, scheme, work, nodes, element == last, sigma_m - work.places[BACK_START, element], h
        )
    return dissipated, stored
