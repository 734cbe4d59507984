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

from typing import Any, NamedTuple

import numpy as np

from restitution.kernel.compile import kernel, part, stage
from restitution.kernel.dense import combine, invert, lagrange, lagrange_lanes, times
from restitution.kernel.interpolation import interpolate, interpolate_lanes, product
from restitution.kernel.lanes import WIDTH, at_least, load, store, total
from restitution.kernel.path import radii_and_integrals
from restitution.kernel.problem import Problem
from restitution.kernel.radau import Scheme
from restitution.kernel.workspace import (
    BACK_LENGTH,
    BACK_START,
    BASIS,
    COUPLING,
    LENGTH,
    MODES_,
    N_APPROACH,
    N_REBOUND,
    S_,
    START,
    V_,
    VALUES,
    Work,
)

# Rows of `nodes`: depth, stored energy per length of an element that leaves, its slope.
D, DENSITY, SLOPE, N_ROWS = range(4)


class Ledger(NamedTuple):
    """Scratch space of the energy budget for N modes and E elements of S = 8 stages.

    Attributes
    ----------
    memory : ndarray, shape (E, 3 N, S + 1)
        H_k, Y_k, Z_k along the approach.
    history : ndarray, shape (N, S + 1)
        H_k along an element of the rebound.
    nodes : ndarray, shape (3, S + 1)
    past : ndarray, shape (3 N, S)
        The memory at the instants t1 of a rebound element's nodes.
    present : ndarray, shape (3 N,)
        The memory at the turning point.
    """

    memory: Any
    history: Any
    nodes: Any
    past: Any
    present: Any


def allocate_ledger(N: int, elements: int) -> Ledger:
    """Scratch space of the energy budget."""
    return Ledger(
        np.zeros((elements, 3 * N, WIDTH + 1)),
        np.zeros((N, WIDTH + 1)),
        np.zeros((N_ROWS, WIDTH + 1)),
        np.zeros((3 * N, WIDTH)),
        np.zeros(3 * N),
    )


@part
def _decay_matrix(scheme: Any, work: Any, pace: Any, rate: float, h: float) -> None:
    """Leave in `matrices[COUPLING]` what solves y' = -rate pace y + source over an element."""
    B = work.matrices[COUPLING]
    step = (h * rate) * pace
    for j in range(WIDTH):
        store(B[j], 0, load(scheme.identity[j], 0) + load(scheme.columns[j], 0) * step[j])
    invert(work.matrices, COUPLING)


@part
def _propagated(scheme: Any, work: Any, source: Any, h: float, start: float) -> Any:
    """Solution at the nodes, from `start`, with the matrix left by `_decay_matrix`."""
    return times(work.matrices[COUPLING], start + h * times(scheme.columns, source))


@part
def _integral(scheme: Any, work: Any, values: Any, h: float, end: float) -> float:
    """Integral from 0 to `end` of the polynomial with these values at the nodes of an element of length h."""
    basis = work.vectors[BASIS]
    lagrange(scheme.c, scheme.weights, WIDTH + 1, end, basis)
    return h * total(load(basis, 1) * times(scheme.columns, values))


@stage
def _approach(problem: Problem, scheme: Scheme, work: Work, ledger: Ledger) -> float:
    """Energy dissipated during the approach; leaves the memory in the ledger."""
    memory = ledger.memory
    dissipated = 0.0
    for element in range(work.counts[N_APPROACH] + 1):
        table = work.approach[element]
        h = work.places[LENGTH, element]
        s, v = load(table[S_], 1), load(table[V_], 1)
        a = radii_and_integrals(problem.path, s, work.vectors[VALUES:])[0]
        pace = 2.0 * s
        power = problem.viscosity * (a * v * v * pace)
        for k in range(problem.moduli.shape[0]):
            rows = memory[element, 3 * k : 3 * k + 3]
            for n in range(3):
                rows[n, 0] = memory[element - 1, 3 * k + n, WIDTH] if element > 0 else 0.0
            # H of source dd, Y of a dd, Z of 2 a H dd, which decays at twice the rate.
            rate = 1.0 / problem.times[k]
            source = pace * v
            _decay_matrix(scheme, work, pace, rate, h)
            H = _propagated(scheme, work, source, h, rows[0, 0])
            Y = _propagated(scheme, work, source * a, h, rows[1, 0])
            _decay_matrix(scheme, work, pace, 2.0 * rate, h)
            Z = _propagated(scheme, work, 2.0 * (source * a * H), h, rows[2, 0])
            store(rows[0], 1, H)
            store(rows[1], 1, Y)
            store(rows[2], 1, Z)
            power = power + (problem.moduli[k] * rate) * ((2.0 * (H * Y) - Z) * pace)
        end = min((work.turning_place[0] - work.places[START, element]) / h, 1.0)
        dissipated += _integral(scheme, work, power, h, end)
    return dissipated


@part
def _slope_of_density(scheme: Scheme, nodes: Any) -> None:
    """Write d(density)/dlambda over the length of the element into `nodes[SLOPE]`."""
    density = nodes[DENSITY]
    for i in range(WIDTH + 1):
        nodes[SLOPE, i] = product(scheme.derivative[i], density)


@stage
def _last_element(
    problem: Problem, scheme: Scheme, work: Work, ledger: Ledger, sigma: float, h: float
) -> tuple[float, float]:
    """Energy dissipated and stored along the last element, which begins at `sigma`.

    It ends where a(s) of a blunt tip has an infinite slope and is divided towards there: what is smooth, H_k, X_k, the
    velocity and the density, comes from the nodes, the contact radius and what belongs to it from its own place.
    """
    N = problem.moduli.shape[0]
    past, history, nodes = ledger.past, ledger.history, ledger.nodes
    element = work.counts[N_REBOUND]
    table, slopes = work.rebound[element], work.slopes[element]
    weights = load(scheme.A[WIDTH - 1], 0)
    dissipated = 0.0
    stored = 0.0
    low = 0.0
    place = work.counts[N_APPROACH]
    parts = 24
    for n in range(parts):
        high = 1.0 if n == parts - 1 else 0.5 * (low + 1.0)
        x = low + (high - low) * load(scheme.c, 1)
        there = at_least(sigma - h * x, 0.0)
        interpolate_lanes(scheme, work, ledger.memory, there, place, past)
        place = interpolate_lanes(scheme, work, work.approach, there, place, work.past)
        a = radii_and_integrals(problem.path, load(work.past[S_], 0), work.vectors[VALUES:])[0]
        lagrange_lanes(scheme.c[1:], scheme.extrapolation, WIDTH, x, work.basis)
        pace = combine(work.basis, WIDTH, slopes)
        lagrange_lanes(scheme.c, scheme.weights, WIDTH + 1, x, work.basis)
        v = combine(work.basis, WIDTH + 1, table[V_])
        power = problem.viscosity * (a * v * v)
        for k in range(N):
            H = combine(work.basis, WIDTH + 1, history[k])
            X = combine(work.basis, WIDTH + 1, table[MODES_ + 2 * k])
            power = power + (problem.moduli[k] / problem.times[k]) * _squares(past, k, a, H, X)
        dissipated += h * (high - low) * total(weights * power * pace)
        stored += (high - low) * total(weights * a * combine(work.basis, WIDTH + 1, nodes[SLOPE]))
        low = high
    return dissipated, stored


@part
def _squares(past: Any, k: int, a: Any, H: Any, X: Any) -> Any:
    """Integral of w_k^2 over the elements in contact."""
    H1 = load(past[3 * k], 0)
    P = a * H1 - load(past[3 * k + 1], 0)
    Q = a * (H1 * H1) - load(past[3 * k + 2], 0)
    return a * (H * H) - 2.0 * (H * X * P) + X * X * Q


@stage
def _rebound(problem: Problem, scheme: Scheme, work: Work, ledger: Ledger) -> tuple[float, float]:
    """Energy dissipated during the rebound, and stored by the elements as they are left; after `_approach`."""
    N = problem.moduli.shape[0]
    nodes, memory, past, present = ledger.nodes, ledger.memory, ledger.past, ledger.present
    sigma_m = work.turning_place[0]
    last = work.counts[N_REBOUND]
    place = work.counts[N_APPROACH]
    x = (sigma_m - work.places[START, place]) / work.places[LENGTH, place]
    interpolate(scheme, work, memory[place], x, present)
    for k in range(N):
        ledger.history[k, WIDTH] = present[3 * k]
    weights = load(scheme.A[WIDTH - 1], 0)
    dissipated = 0.0
    stored = 0.0
    nodes[D, WIDTH] = work.turning[S_] ** 2
    nodes[DENSITY, WIDTH] = 0.0
    for element in range(last + 1):
        table = work.rebound[element]
        h = work.places[BACK_LENGTH, element]
        nodes[D, 0], nodes[DENSITY, 0] = nodes[D, WIDTH], nodes[DENSITY, WIDTH]
        start = sigma_m - work.places[BACK_START, element]
        sigma = start - h * load(scheme.c, 1)
        if element == last:
            sigma = at_least(sigma, 0.0)
        interpolate_lanes(scheme, work, memory, sigma, place, past)
        place = interpolate_lanes(scheme, work, work.approach, sigma, place, work.past)
        s1, v, pace = load(work.past[S_], 0), load(table[V_], 1), load(work.slopes[element], 0)
        a = radii_and_integrals(problem.path, s1, work.vectors[VALUES:])[0]
        source = pace * v
        power = problem.viscosity * (a * v * v)
        d = nodes[D, 0] + h * times(scheme.columns, source)
        density = (0.5 * problem.equilibrium) * ((d - s1 * s1) * (d - s1 * s1))
        for k in range(N):
            rate = 1.0 / problem.times[k]
            history = ledger.history[k]
            history[0] = history[WIDTH]
            _decay_matrix(scheme, work, pace, rate, h)
            H = _propagated(scheme, work, source, h, history[0])
            store(history, 1, H)
            X = load(table[MODES_ + 2 * k], 1)
            power = power + (problem.moduli[k] * rate) * _squares(past, k, a, H, X)
            left = H - X * load(past[3 * k], 0)
            density = density + (0.5 * problem.moduli[k]) * (left * left)
        store(nodes[D], 1, d)
        store(nodes[DENSITY], 1, density)
        _slope_of_density(scheme, nodes)
        # Leaving elements store - int density da = int a d(density): no singular a'(s), and with a flat core.
        if element < last:
            dissipated += h * total(weights * power * pace)
            stored += total(weights * a * load(nodes[SLOPE], 1))
        else:
            end = _last_element(problem, scheme, work, ledger, start, h)
            dissipated += end[0]
            stored += end[1]
    return dissipated, stored


@kernel
def energy_budget(problem: Problem, scheme: Scheme, work: Work, ledger: Ledger) -> tuple[float, float]:
    """Energy dissipated during an impact and stored at its end, in units of m v0^2.

    `work` holds the stored halves of an impact that ended in separation. An entry point of its own, not a part of
    `solve_block`: whoever does not ask for the energy does not wait for its compilation.
    """
    before = _approach(problem, scheme, work, ledger)
    after, stored = _rebound(problem, scheme, work, ledger)
    return before + after, stored
