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

# Shares at which the first element of the approach and the last of the rebound are cut where a(s) is no polynomial.
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

    `motion` has the columns time, velocity, force and s of the contact radius; `error` is the difference between the
    last two divisions.
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
    even, exponent = np.linspace(0.0, 1.0, parts + 1), solution.units.exponent
    graded = _GRADED if solution.units.table is not None or exponent != round(exponent) else even
    for place, (start, length) in enumerate(zip(half.starts, half.lengths, strict=True)):
        shares, last = even, place == half.starts.size - 1
        if not rebound and place == 0:
            shares = np.unique(np.concatenate([graded, even]))
        if rebound and last:
            shares = np.unique(np.concatenate([1.0 - graded, even]))
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
    """Linear maps of all elements at once: E elements of S nodes, K modes; `now` is the velocity at the nodes."""

    integral: Array  # (E, S, S): of a rate over time
    radii: Array  # (E, S)
    decays: Array  # (E, K, S): what is left of a mode
    gains: Array  # (E, K, S, S): a mode from its rate
    fast: Array  # (E, K, S): the same at twice the rate
    fast_gains: Array  # (E, K, S, S)
    push: Array  # (E, S, S): force from now
    start: Array  # (E, S): now from the velocity at the start
    back: Array  # (E, S, S): now from minus the force without a velocity


def _steps(solution: Solution, spectrum: Spectrum, mobility: float, at: _Places, *, rebound: bool) -> _Steps:
    """Return the maps; the force weighs rates with the radius at their time, in the rebound with that at its own."""
    integral = at.lengths[:, None, None] * solution.scheme.A * at.pace[:, None, :]
    unit, radii = np.eye(integral.shape[-1]), solution.radius(at.roots)[:, 1:]
    rates = integral[:, None] / spectrum.times[:, None, None]
    slow = np.linalg.inv(unit + rates)
    # Squares of loads are integrated in the approach only.
    fast = slow if rebound else np.linalg.inv(unit + 2.0 * rates)
    matrix = spectrum.equilibrium * unit + np.einsum("k,ekij->eij", spectrum.moduli, slow)
    push = radii[:, :, None] * (matrix @ integral) if rebound else matrix @ (integral * radii[:, None, :])
    push = push + spectrum.viscosity * radii[:, :, None] * unit
    load = mobility * integral
    inverse = np.linalg.inv(unit + load @ push)
    gains = integral[:, None]
    return _Steps(
        integral, radii, slow.sum(axis=-1), slow @ gains, fast.sum(axis=-1), fast @ gains, push,
        inverse.sum(axis=-1), inverse @ load,
    )  # fmt: skip


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
    first = np.stack([approach.times, states.v, forces, approach.roots], axis=-1)
    motion = np.concatenate([first[0, :1], first[:, 1:].reshape(-1, 4), motion])
    return Sticking(float(motion[-1, 1]), spent + lost, stored, motion, np.inf)


def _approach(solution: Solution, spectrum: Spectrum, mobility: float, at: _Places) -> tuple[_State, Array, float]:
    """Solve the approach; return the states and forces at all points, and the energy dissipated."""
    G, tau = spectrum.moduli, spectrum.times
    (E, points), K, step = at.positions.shape, tau.size, _steps(solution, spectrum, mobility, at, rebound=False)
    v, u, W0, force = (np.zeros((E, points)) for _ in range(4))
    Z, W, Q = (np.zeros((E, points, K)) for _ in range(3))
    v[0, 0] = 1.0
    for e in range(E):
        if e:
            for rows in (v, u, W0, force, Z, W, Q):
                rows[e, 0] = rows[e - 1, -1]
        fixed = spectrum.equilibrium * W0[e, 0] + (G * W[e, 0]) @ step.decays[e]
        now = v[e, 0] * step.start[e] - step.back[e] @ fixed
        weighted = step.radii[e] * now
        v[e, 1:], force[e, 1:] = now, fixed + step.push[e] @ now
        u[e, 1:], W0[e, 1:] = u[e, 0] + step.integral[e] @ now, W0[e, 0] + step.integral[e] @ weighted
        Z[e, 1:] = (step.decays[e] * Z[e, 0][:, None] + step.gains[e] @ now).T
        W[e, 1:] = (step.decays[e] * W[e, 0][:, None] + step.gains[e] @ weighted).T
        gain = step.fast_gains[e] @ (2.0 * now * W[e, 1:].T)[..., None]
        Q[e, 1:] = (step.fast[e] * Q[e, 0][:, None] + gain[..., 0]).T
    power = Q[:, 1:] @ (G / tau) + spectrum.viscosity * step.radii * v[:, 1:] ** 2
    return _State(v, u, W0, Z, W, Q), force, float(np.einsum("ej,ej->", step.integral[:, -1], power))


def _rebound(
    solution: Solution, spectrum: Spectrum, mobility: float, halves: tuple[_Places, _State, _Places]
) -> tuple[Array, float, float]:
    """Solve the rebound; return its motion, and the energies dissipated and stored in elements that leave."""
    approach, states, at = halves
    G, tau, scheme, equilibrium = spectrum.moduli, spectrum.times, solution.scheme, spectrum.equilibrium
    shape, step = at.positions.shape, _steps(solution, spectrum, mobility, at, rebound=True)
    flat = _past(solution, approach, states, np.maximum(solution.sigma_m - at.positions.ravel(), 0.0))
    past = _Past(*(rows.reshape(*shape, *rows.shape[1:]) for rows in flat))
    X, a = np.exp(-np.maximum(at.times - past.times, 0.0)[..., None] / tau), solution.radius(at.roots)
    old = X * past.Z
    past_force = equilibrium * (past.W0 - a * past.u) + (X * past.W - a[..., None] * old) @ G
    ways, memories = np.zeros(shape), np.zeros((*shape, tau.size))
    v, forces = np.zeros(shape), np.zeros(shape)
    v[0, 0], ways[0, 0], memories[0, 0] = states.v[-1, -1], states.u[-1, -1], states.Z[-1, -1]
    for e in range(shape[0]):
        if e:
            v[e, 0], ways[e, 0], memories[e, 0] = v[e - 1, -1], ways[e - 1, -1], memories[e - 1, -1]
        fixed = past_force[e, 1:] + step.radii[e] * (equilibrium * ways[e, 0] + (G * memories[e, 0]) @ step.decays[e])
        now = v[e, 0] * step.start[e] - step.back[e] @ fixed
        v[e, 1:], forces[e, 1:] = now, fixed + step.push[e] @ now
        ways[e, 1:] = ways[e, 0] + step.integral[e] @ now
        memories[e, 1:] = (step.decays[e] * memories[e, 0][:, None] + step.gains[e] @ now).T
    left = memories - old
    squares = X * X * past.Q + 2.0 * X * left * past.W + a[..., None] * left * left
    power = squares[:, 1:] @ (G / tau) + spectrum.viscosity * step.radii * v[:, 1:] ** 2
    spent = float(np.einsum("ej,ej->", step.integral[:, -1], power))
    # Elements store - int density da = int a d(density) at separation.
    edge = equilibrium * (ways - past.u) ** 2 + (left * left) @ G
    stored = 0.5 * float(np.einsum("ej,ij,ei,i->", edge, scheme.derivative[1:], step.radii, scheme.A[-1]))
    motion = np.stack([at.times, v, forces, at.roots], axis=-1)[:, 1:].reshape(-1, 4)
    return motion, spent, stored


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
