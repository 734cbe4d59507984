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

    @property
    def all_moduli(self) -> Array:
        """Moduli, that of equilibrium first."""
        return np.append(self.equilibrium, self.moduli)

    @property
    def rates(self) -> Array:
        """Rates of decay, that of the equilibrium modulus first, 0."""
        return np.append(0.0, 1.0 / self.times)


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
    even, exponent, count = np.linspace(0.0, 1.0, parts + 1), solution.units.exponent, half.starts.size
    shares = [even] * count
    if solution.units.table is not None or exponent != round(exponent):
        place, graded = (-1, 1.0 - _GRADED) if rebound else (0, _GRADED)
        shares[place] = np.unique(np.concatenate([graded, even]))
    shares[-1] = shares[-1] * half.share
    # Elements of the normal solution, and the parts of them.
    parent = np.repeat(np.arange(count), [each.size - 1 for each in shares])
    low, high = (np.concatenate([each[cut] for each in shares]) for cut in (slice(-1), slice(1, None)))
    start, lengths = half.starts[parent] + half.lengths[parent] * low, half.lengths[parent] * (high - low)
    positions = start[:, None] + lengths[:, None] * solution.scheme.c
    inside = low[:, None] + (high - low)[:, None] * solution.scheme.c
    columns = half.columns[..., [S_, T_]]
    if rebound:
        rates = solution.scheme.derivative @ columns[..., 1:] / half.lengths[:, None, None]
        columns = np.concatenate([columns, rates], axis=-1)
    columns = solution.interpolate(columns, np.repeat(parent, inside.shape[1]), inside.ravel())
    columns = columns.reshape(*positions.shape, -1)
    roots = np.maximum(columns[..., 0], 0.0)
    pace = columns[..., 2] if rebound else 2.0 * roots
    return _Places(positions, lengths, columns[..., 1], pace[:, 1:], roots)


class _Steps(NamedTuple):
    """Linear maps of all elements at once: E elements of S nodes, and 1 + K sums, as in `_State`."""

    radii: Array  # (E, S)
    decays: Array  # (E, 1 + K, S): what is left of a sum
    gains: Array  # (E, 1 + K, S, S): a sum from its rate
    fast: Array  # (E, K, S): the same of the modes at twice the rate
    fast_gains: Array  # (E, K, S, S)
    push: Array  # (E, S, S): force from the velocity
    start: Array  # (E, S): velocity from that at the start
    back: Array  # (E, S, S): velocity from minus the force without a velocity


def _steps(solution: Solution, spectrum: Spectrum, mobility: float, at: _Places, *, rebound: bool) -> _Steps:
    """Return the maps; the force weighs rates with the radius at their time, in the rebound with that at its own."""
    integral = at.lengths[:, None, None] * solution.scheme.A * at.pace[:, None, :]
    unit, radii, gains = np.eye(integral.shape[-1]), solution.radius(at.roots)[:, 1:], integral[:, None]
    rates = gains / spectrum.times[:, None, None]
    relaxing = np.linalg.inv(unit + rates)
    slow = np.concatenate([np.broadcast_to(unit, gains.shape), relaxing], axis=1)
    # Squares of loads are integrated in the approach only.
    fast = relaxing if rebound else np.linalg.inv(unit + 2.0 * rates)
    matrix = np.einsum("k,ekij->eij", spectrum.all_moduli, slow)
    push = radii[:, :, None] * (matrix @ integral) if rebound else matrix @ (integral * radii[:, None, :])
    push = push + spectrum.viscosity * radii[:, :, None] * unit
    load = mobility * integral
    inverse = np.linalg.inv(unit + load @ push)
    return _Steps(
        radii, slow.sum(axis=-1), slow @ gains, fast.sum(axis=-1), fast @ gains, push, inverse.sum(axis=-1),
        inverse @ load,
    )  # fmt: skip


def _velocities(
    spectrum: Spectrum, step: _Steps, weights: tuple[Array, Array], source: Array, first: Array
) -> tuple[Array, Array]:
    """Return the velocity and the force at the nodes of the elements.

    The body has the velocity `first[0]` at the start, and the sums `first[1:]`. The weights are those of the sums in
    the force and of the velocity in their rates; `source` is the force of what happened before. A matrix leads from
    the start of an element to that of the next.
    """
    loads = spectrum.all_moduli[:, None] * step.decays * weights[0][:, None]
    # Velocity at the nodes for each number at the start of an element, and without any.
    answer = np.concatenate([step.start[:, None], -loads @ np.swapaxes(step.back, 1, 2)], axis=1)
    rest = -np.einsum("eij,ej->ei", step.back, source)
    last, sums = np.swapaxes(step.gains[:, :, -1], 1, 2), np.arange(1, first.size)
    matrix = np.concatenate([answer[:, :, -1:], (weights[1][:, None] * answer) @ last], axis=2)
    matrix[:, sums, sums] += step.decays[:, :, -1]
    shift = np.concatenate([rest[:, -1:], np.einsum("ej,ejn->en", weights[1] * rest, last)], axis=1)
    starts, now = np.empty(shift.shape), first
    for e in range(len(starts)):
        starts[e] = now
        now = now @ matrix[e] + shift[e]
    velocity = np.einsum("en,enj->ej", starts, answer) + rest
    force = source + np.einsum("en,enj->ej", starts[:, 1:], loads) + np.einsum("eij,ej->ei", step.push, velocity)
    return velocity, force


def _sums(decays: Array, gains: Array, rates: Array, first: Array | float) -> Array:
    """Return sums at all points of the elements, shape (E, S + 1, n), from their rates at the nodes.

    The shapes are (E, n, S), (E, n, S, S), and (E, n, S) or (E, 1, S) for equal rates.
    """
    sums = np.empty((*decays.shape[:2], decays.shape[2] + 1))
    sums[:, :, 1:] = (gains @ rates[..., None])[..., 0]
    now = first
    for e, decay in enumerate(decays[:, :, -1]):
        sums[e, :, 0] = now
        now = decay * now + sums[e, :, -1]
    sums[:, :, 1:] += decays * sums[:, :, :1]
    return np.moveaxis(sums, 1, 2)


def _points(nodes: Array, first: float) -> Array:
    """Return numbers at all points of the elements from those at the nodes."""
    return np.column_stack([np.append(first, nodes[:-1, -1]), nodes])


class _State(NamedTuple):
    """Approach at the points of the elements: Z and W of all sums, (E, S + 1, 1 + K), Q of the modes.

    The first Z is the way, the first W is that of the equilibrium modulus; Q are integrals of squares.
    """

    velocity: float  # at the end
    Z: Array
    W: Array
    Q: Array


def _march(solution: Solution, spectrum: Spectrum, mobility: float, parts: int) -> Sticking:
    """Solve both halves."""
    approach = _places(solution, solution.approach, parts, rebound=False)
    states, first, spent = _approach(solution, spectrum, mobility, approach)
    rebound = _places(solution, solution.rebound, parts, rebound=True)
    motion, lost, stored = _rebound(solution, spectrum, mobility, (approach, states, rebound))
    motion = np.concatenate([first[0, :1], first[:, 1:].reshape(-1, 4), motion])
    return Sticking(float(motion[-1, 1]), spent + lost, stored, motion, np.inf)


def _approach(solution: Solution, spectrum: Spectrum, mobility: float, at: _Places) -> tuple[_State, Array, float]:
    """Solve the approach; return the sums and the motion at all points, and the energy dissipated."""
    step = _steps(solution, spectrum, mobility, at, rebound=False)
    radii, ones, first = step.radii, np.ones(step.radii.shape), np.append(1.0, np.zeros(spectrum.rates.size))
    v, force = _velocities(spectrum, step, (ones, radii), 0.0 * radii, first)
    Z, W = (_sums(step.decays, step.gains, rates[:, None], 0.0) for rates in (v, radii * v))
    squares = 2.0 * v[:, None] * np.moveaxis(W[:, 1:, 1:], 1, 2)
    Q = _sums(step.fast, step.fast_gains, squares, 0.0)
    power = Q[:, 1:] @ (spectrum.moduli / spectrum.times) + spectrum.viscosity * radii * v**2
    motion = np.stack([at.times, _points(v, 1.0), _points(force, 0.0), at.roots], axis=-1)
    return _State(float(v[-1, -1]), Z, W, Q), motion, float(np.einsum("ej,ej->", step.gains[:, 0, -1], power))


def _rebound(
    solution: Solution, spectrum: Spectrum, mobility: float, halves: tuple[_Places, _State, _Places]
) -> tuple[Array, float, float]:
    """Solve the rebound; return its motion, and the energies dissipated and stored in elements that leave."""
    approach, states, at = halves
    scheme, step = solution.scheme, _steps(solution, spectrum, mobility, at, rebound=True)
    past = _past(solution, approach, states, np.maximum(solution.sigma_m - at.positions, 0.0))
    X, a = np.exp(-np.maximum(at.times - past.times, 0.0)[..., None] * spectrum.rates), solution.radius(at.roots)
    old = X * past.Z
    source = ((X * past.W - a[..., None] * old) @ spectrum.all_moduli)[:, 1:]
    first = np.append(states.velocity, states.Z[-1, -1])
    v, force = _velocities(spectrum, step, (step.radii, np.ones(step.radii.shape)), source, first)
    left = _sums(step.decays, step.gains, v[:, None], first[1:]) - old
    squares = (X * X)[..., 1:] * past.Q + (2.0 * X * left * past.W + a[..., None] * left * left)[..., 1:]
    power = squares[:, 1:] @ (spectrum.moduli / spectrum.times) + spectrum.viscosity * step.radii * v**2
    spent = float(np.einsum("ej,ej->", step.gains[:, 0, -1], power))
    # Elements store - int density da = int a d(density) at separation.
    edge = (left * left) @ spectrum.all_moduli
    stored = 0.5 * float(np.einsum("ej,ij,ei,i->", edge, scheme.derivative[1:], step.radii, scheme.A[-1]))
    motion = np.stack([at.times[:, 1:], v, force, at.roots[:, 1:]], axis=-1).reshape(-1, 4)
    return motion, spent, stored


class _Past(NamedTuple):
    """Approach at the places of equal contact radius."""

    times: Array
    Z: Array
    W: Array
    Q: Array


def _past(solution: Solution, at: _Places, states: _State, sigma: Array) -> _Past:
    """Interpolate the approach."""
    starts, flat = at.positions[:, 0], sigma.ravel()
    element = np.clip(np.searchsorted(starts, flat, side="right") - 1, 0, starts.size - 1)
    basis = solution.basis((flat - starts[element]) / at.lengths[element])
    rows = np.concatenate([at.times[..., None], states.Z, states.W, states.Q], axis=-1)
    columns = (basis[:, None] @ rows[element])[:, 0].reshape(*sigma.shape, -1)
    K = states.Q.shape[-1]
    return _Past(columns[..., 0], *np.split(columns[..., 1:], [K + 1, 2 * K + 2], axis=-1))
