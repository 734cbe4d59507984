"""Oblique impact without slip: smooth equations on the stored normal solution, by collocation with a check.

Where nothing slips, all elements in contact move with the body, and sums over them obey ordinary equations. With the
velocity v of the contact point, its way u, and for each mode `Z_k' = v - Z_k/tau_k`, `W_k' = a v - W_k/tau_k` of the
approach, index 1 for the approach at the same contact radius and `X_k = exp(-(t - t_1)/tau_k)`,

    F = Ginf W_0 + sum G_k W_k                                                                    in the approach,
    F = Ginf [W_01 + a (u - u_1)] + sum G_k [X_k W_k1 + a (Z_k - X_k Z_k1)]                       in the rebound,

and ``v' = -mobility F``. An element that leaves drops its load; what it stores is lost to the body.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from restitution.checks import Array
from restitution.impact.solution import S_, T_, Half, Solution

# Shares at which the first element of the approach and the last of the rebound are cut, where a(s) may have a root.
_GRADED = np.concatenate([[0.0], 0.25 ** np.arange(6, -1, -1.0)])
# Most parts of an element of the normal solution.
_MOST_PARTS = 16


class Spectrum(NamedTuple):
    """Scaled relaxation of the tangential load."""

    equilibrium: float
    viscosity: float
    moduli: Array
    times: Array


class Sticking(NamedTuple):
    """Motion for a velocity 1 of the contact point at first touch, scaled; energies in units of m v^2.

    `motion` has the columns time, velocity, force; `error` is the difference between the last two divisions.
    """

    velocity: float
    dissipated: float
    stored: float
    motion: Array
    error: float


class _Places(NamedTuple):
    """Collocation elements of one half: their lengths, and at S + 1 points of each what the normal solution has."""

    positions: Array  # (E, S + 1): in sigma or lambda
    lengths: Array
    times: Array  # (E, S + 1)
    pace: Array  # (E, S): dt/dsigma or dt/dlambda at the nodes
    roots: Array  # (E, S + 1): s of the contact radius


def solve_sticking(solution: Solution, spectrum: Spectrum, mobility: float, rtol: float) -> Sticking:
    """Halve the elements of the normal solution until the velocity at separation changes by less than `rtol`."""
    parts, before = 1, _march(solution, spectrum, mobility, 1)
    while True:
        parts *= 2
        now = _march(solution, spectrum, mobility, parts)
        now = now._replace(error=abs(now.velocity - before.velocity))
        if not now.error > rtol or parts >= _MOST_PARTS:
            return now
        before = now


def _places(solution: Solution, half: Half, parts: int, *, rebound: bool) -> _Places:
    """Divide the elements of a half."""
    starts, ends = list[Array](), list[Array]()
    even = np.linspace(0.0, 1.0, parts + 1)
    for place, (start, length) in enumerate(zip(half.starts, half.lengths, strict=True)):
        shares, last = even, place == half.starts.size - 1
        if not rebound and place == 0:
            shares = np.unique(np.concatenate([_GRADED, even]))
        if rebound and last:
            shares = np.unique(np.concatenate([1.0 - _GRADED, even]))
        if last:
            shares = shares * half.share
        starts.append(start + length * shares[:-1])
        ends.append(start + length * shares[1:])
    start, lengths = np.concatenate(starts), np.concatenate(ends) - np.concatenate(starts)
    positions = start[:, None] + lengths[:, None] * solution.scheme.c
    # The middle of an element belongs to one element of the normal solution.
    parent = solution.places(half, start + 0.5 * lengths)[0][:, None] + np.zeros(positions.shape, dtype=np.intp)
    inside = (positions - half.starts[parent]) / half.lengths[parent]
    columns = solution.interpolate(half.columns, parent.ravel(), inside.ravel()).reshape(*positions.shape, -1)
    roots = np.maximum(columns[..., S_], 0.0)
    if rebound:
        rates = np.einsum("ij,ej->ei", solution.scheme.derivative, half.columns[..., T_]) / half.lengths[:, None]
        pace = solution.interpolate(rates[..., None], parent.ravel(), inside.ravel()).reshape(positions.shape)
    else:
        pace = 2.0 * roots
    return _Places(positions, lengths, columns[..., T_], pace[:, 1:], roots)


class _Steps(NamedTuple):
    """Integration over one element, scaled: matrices of shape (S, S), or one for each mode."""

    integral: Array  # of a rate over time
    modes: Array  # (K, S, S): inverse of the decay
    fast: Array  # (K, S, S): the same at twice the rate


def _steps(scheme_A: Array, length: float, pace: Array, times: Array) -> _Steps:
    integral = length * scheme_A * pace
    one = np.eye(integral.shape[0])
    decay = integral / times[:, None, None]
    slow, fast = (np.asarray(np.linalg.inv(one + rate * decay), dtype=np.float64) for rate in (1.0, 2.0))
    return _Steps(integral, slow, fast)


class _State(NamedTuple):
    """Sums at the points of the elements: velocity, way, and for each mode Z, W and the integral of the squares."""

    v: Array
    u: Array
    W0: Array
    Z: Array
    W: Array
    Q: Array


def _march(solution: Solution, spectrum: Spectrum, mobility: float, parts: int) -> Sticking:
    """Solve both halves."""
    approach = _places(solution, solution.approach, parts, rebound=False)
    states, forces, spent = _approach(solution, spectrum, mobility, approach)
    rebound = _places(solution, solution.rebound, parts, rebound=True)
    motion, lost, stored = _rebound(solution, spectrum, mobility, (approach, states, rebound))
    first = np.column_stack([approach.times.ravel(), states.v.ravel(), forces.ravel()])
    motion = np.concatenate([first, motion])
    return Sticking(float(motion[-1, 1]), spent + lost, stored, motion, np.inf)


def _approach(solution: Solution, spectrum: Spectrum, mobility: float, at: _Places) -> tuple[_State, Array, float]:
    """Solve the approach; return the states and forces at all points, and the energy dissipated."""
    G, tau, drag, A = spectrum.moduli, spectrum.times, spectrum.viscosity, solution.scheme.A
    (E, points), K = at.positions.shape, tau.size
    S, spent, one = points - 1, 0.0, np.ones(points - 1)
    v, u, W0, force = (np.zeros((E, points)) for _ in range(4))
    Z, W, Q = (np.zeros((E, points, K)) for _ in range(3))
    v[0, 0] = 1.0
    for e in range(E):
        if e:
            for rows in (v, u, W0, force, Z, W, Q):
                rows[e, 0] = rows[e - 1, -1]
        step, a = _steps(A, at.lengths[e], at.pace[e], tau), solution.radius(at.roots[e, 1:])
        matrix = spectrum.equilibrium * np.eye(S) + np.einsum("k,kij->ij", G, step.modes)
        push = matrix @ (step.integral * a) + drag * np.diag(a)
        fixed = spectrum.equilibrium * W0[e, 0] * one + np.einsum("k,kij,k->i", G, step.modes, W[e, 0])
        load = mobility * step.integral
        v[e, 1:] = np.linalg.solve(np.eye(S) + load @ push, v[e, 0] * one - load @ fixed)
        now = v[e, 1:]
        u[e, 1:], W0[e, 1:] = u[e, 0] + step.integral @ now, W0[e, 0] + step.integral @ (a * now)
        Z[e, 1:] = np.einsum("kij,kj->ik", step.modes, Z[e, 0][:, None] + step.integral @ now)
        W[e, 1:] = np.einsum("kij,kj->ik", step.modes, W[e, 0][:, None] + step.integral @ (a * now))
        gain = np.einsum("ij,jk->ki", step.integral, 2.0 * now[:, None] * W[e, 1:])
        Q[e, 1:] = np.einsum("kij,kj->ik", step.fast, Q[e, 0][:, None] + gain)
        force[e, 1:] = fixed + push @ now
        spent += float(step.integral[-1] @ (Q[e, 1:] @ (G / tau) + drag * a * now * now))
    return _State(v, u, W0, Z, W, Q), force, spent


def _rebound(
    solution: Solution, spectrum: Spectrum, mobility: float, halves: tuple[_Places, _State, _Places]
) -> tuple[Array, float, float]:
    """Solve the rebound; return its motion, and the energies dissipated and stored in elements that leave."""
    approach, states, at = halves
    G, tau, drag, scheme = spectrum.moduli, spectrum.times, spectrum.viscosity, solution.scheme
    points = at.positions.shape[1]
    S, one, spent, stored = points - 1, np.ones(points - 1), 0.0, 0.0
    v, u, Z = states.v[-1, -1], states.u[-1, -1], states.Z[-1, -1]
    motion = list[Array]()
    for e in range(at.positions.shape[0]):
        past = _past(solution, approach, states, np.maximum(solution.sigma_m - at.positions[e], 0.0))
        a_all = solution.radius(at.roots[e])
        X_all = np.exp(-np.maximum(at.times[e] - past.times, 0.0)[:, None] / tau)
        step, a, X = _steps(scheme.A, at.lengths[e], at.pace[e], tau), a_all[1:], X_all[1:]
        W0, u1, Z1, W1, Q1 = (rows[1:] for rows in (past.W0, past.u, past.Z, past.W, past.Q))
        matrix = spectrum.equilibrium * np.eye(S) + np.einsum("k,kij->ij", G, step.modes)
        push = a[:, None] * (matrix @ step.integral) + drag * np.diag(a)
        old = np.einsum("kij,k->ik", step.modes, Z)
        fixed = spectrum.equilibrium * (W0 + a * (u - u1)) + (X * W1 + a[:, None] * (old - X * Z1)) @ G
        load = mobility * step.integral
        now = np.linalg.solve(np.eye(S) + load @ push, v * one - load @ fixed)
        way = u + step.integral @ now
        memory = np.einsum("kij,kj->ik", step.modes, Z[:, None] + step.integral @ now)
        left = memory - X * Z1
        squares = X * X * Q1 + 2.0 * X * left * W1 + a[:, None] * left * left
        spent += float(step.integral[-1] @ (squares @ (G / tau) + drag * a * now * now))
        # Elements store - int density da = int a d(density) at separation.
        ways, memories = np.append(u, way), np.vstack([Z, memory])
        edge = spectrum.equilibrium * (ways - past.u) ** 2 + (memories - X_all * past.Z) ** 2 @ G
        stored += float(0.5 * at.lengths[e] * (a * (scheme.derivative[1:] @ edge) / at.lengths[e]) @ scheme.A[-1])
        forces = fixed + push @ now
        motion.append(np.column_stack([at.times[e, 1:], now, forces]))
        v, u, Z = now[-1], way[-1], memory[-1]
    return np.concatenate(motion), spent, stored


class _Past(NamedTuple):
    """Approach at the places of equal contact radius."""

    times: Array
    u: Array
    W0: Array
    Z: Array
    W: Array
    Q: Array


def _past(solution: Solution, at: _Places, states: _State, sigma: Array) -> _Past:
    """Interpolate the approach."""
    starts = at.positions[:, 0]
    element = np.clip(np.searchsorted(starts, sigma, side="right") - 1, 0, starts.size - 1)
    basis = solution.basis((sigma - starts[element]) / at.lengths[element])
    singles = (np.einsum("np,np->n", basis, rows[element]) for rows in (at.times, states.u, states.W0))
    several = (np.einsum("np,npk->nk", basis, rows[element]) for rows in (states.Z, states.W, states.Q))
    return _Past(*singles, *several)
