"""Steady oscillation of the depth: elements of the rim leave and touch once a period, the others never leave."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.checks import Array
from restitution.contact.geometry import Geometry
from restitution.indentation.solid import solids_of
from restitution.kernel.record import Solids
from restitution.kernel.rim import Room, settle_rims
from restitution.material.prony import PronySeries
from restitution.numerics.quadrature import PLACES, SLOPES, WEIGHTS

# Shares of a period at which the end of a phase is looked for.
_SHARES = np.unique(np.concatenate([np.geomspace(1e-9, 0.01, 60), np.linspace(0.01, 1.0, 240)]))
# Share of the rim, next to the elements that never leave, that counts to them.
_NEXT = 1e-4
# Residual of loads and gaps, over their scales, below which an element has a steady state.
_SOLVED = 1e-9


class Steady(NamedTuple):
    """Steady states of n oscillations of the depth, `d = mean + amplitude sin(2 pi frequency t)`, in SI."""

    harmonics: NDArray[np.complex128]  # (n, count): F = F_0 + sum Im(F_n exp(2 pi i n frequency t)) [N]
    innermost: Array  # (n,): depth of the outermost element that never leaves [m], 0 without one
    share: Array  # (n,): of the period in contact
    solved: NDArray[np.bool_]  # (n,): without a steady state, as a liquid, the harmonics are NaN


def steady_states(
    profile: Geometry, series: PronySeries, mean: Array, amplitude: Array, frequency: Array, *, count: int = 2,
    parts: int = 2,
) -> Steady:  # fmt: skip
    """Return the steady states of n moduli under n depths, with the first harmonics and the mean of the force.

    Parameters
    ----------
    profile : Geometry
        Profile with scalar parameters.
    series : PronySeries
        Reduced moduli E*(t), shape (n,).
    mean, amplitude, frequency : array, shape (n,)
        Of the depth [m], [m], [Hz].
    count : int
        Number of harmonics, the mean among them.
    parts : int
        Parts of the rim, each with a Gauss rule of 16 nodes.
    """
    n = mean.size
    typical = np.abs(series.complex_modulus(2.0 * math.pi * frequency))
    with np.errstate(all="ignore"):
        scaled = PronySeries.from_checked(
            series.equilibrium_modulus / typical, series.branch_moduli / typical[:, None],
            series.relaxation_times * frequency[:, None], series.parallel_viscosity * frequency / typical,
        )  # fmt: skip
    result = Steady(np.full((n, count), np.nan, dtype=complex), np.zeros(n), np.ones(n), np.zeros(n, dtype=bool))
    # Numbers that are too large or too small have no steady state.
    with np.errstate(all="ignore"):
        for rows, solids in solids_of(scaled):
            if solids.equilibrium[0] == 0.0:
                continue
            steady = _of_group(profile, solids, mean[rows], amplitude[rows], typical[rows], count, parts)
            for column, values in zip(result, steady, strict=True):
                column[rows] = values
    result.solved[~np.isfinite(result.harmonics).all(axis=1)] = False
    result.harmonics[~result.solved] = np.nan
    return result


def _of_group(
    profile: Geometry, solids: Solids, mean: Array, amplitude: Array, typical: Array, count: int, parts: int
) -> Steady:
    """Return the steady states of solids of equal numbers of branches; moduli in units of `typical` [Pa]."""
    omega = 2.0 * math.pi
    moving = solids.moduli * (1j * omega / (1j * omega + solids.rates))
    stiffness = solids.equilibrium + 1j * omega * solids.viscosity + moving.sum(axis=1)
    inner = np.maximum(mean - np.abs(stiffness) / solids.equilibrium * amplitude, 0.0)
    always, top = inner > 0.0, mean + amplitude
    places = (PLACES[None] + np.arange(parts)[:, None]).ravel() / parts
    # From the edge inwards, even in the logarithm of the distance beyond an amplitude; square roots at both ends.
    reach = np.log1p((top - inner) / amplitude)[:, None]
    distances = np.expm1(reach * (3.0 * places**2 - 2.0 * places**3)) * amplitude[:, None]
    depths = top[:, None] - distances
    # The element at the axis is the first to touch and the last to leave.
    offsets = (mean[:, None] - np.concatenate([depths, np.zeros((mean.size, 1))], axis=1)) / amplitude[:, None]
    # Next to those that never leave, the load vanishes for a moment, which the sums do not feel.
    near = depths - inner[:, None] < _NEXT * (top - inner)[:, None]
    stays = always[:, None] & np.concatenate([near, np.ones_like(near[:, :1])], axis=1)
    last = np.maximum(np.argmax(stays, axis=1) - 1, 0)
    times, excess, residuals = _settled(
        solids, np.where(stays, np.take_along_axis(offsets, last[:, None], axis=1), offsets)
    )
    times[stays] = 0.75, -0.25
    excess[stays] = 0.0
    sums = _coefficients(solids, stiffness, offsets, times, excess, np.arange(float(count)))
    radii = np.asarray(profile.stiffness_radius(depths))
    # From the edge inwards the radii fall.
    growth = -(radii.reshape(mean.size, parts, -1) @ SLOPES.T) * WEIGHTS
    total = np.einsum("nm,nmc->nc", growth.reshape(mean.size, -1), sums[:, :-1])
    # Inside of the rim: elements that follow for ever, or a flat face.
    core = np.asarray(profile.stiffness_radius(inner))
    whole = sums[:, -1] * core[:, None]
    integral = np.asarray(profile.force_integral_at_depth(inner))
    held = solids.equilibrium * ((mean - inner) / amplitude * core + integral / amplitude)
    whole[always, 0] = held[always]
    total = total + whole
    factors = np.where(np.arange(count) > 0, 2j, 1.0)
    share = np.where(always, 1.0, times[:, -1, 0] - times[:, -1, 1])
    harmonics = 2.0 * (typical * amplitude)[:, None] * total * factors
    return Steady(harmonics, inner, share, residuals <= _SOLVED)


def _settled(solids: Solids, offsets: Array) -> tuple[Array, Array, Array]:
    """Return times of leaving and touching (n, m, 2), excess of loads (n, m, K) and residuals (n,) of elements."""
    (n, m), K, J = offsets.shape, solids.rates.shape[1], solids.recoveries.shape[1]
    room = Room(
        np.empty(3), np.empty((2, K)), np.empty(J), np.empty(K), np.empty(K), np.empty(K), np.empty((J, J + 1)),
        np.empty(2),
    )  # fmt: skip
    times, excess, residuals = np.empty((n, m, 2)), np.empty((n, m, K)), np.empty(n)
    settle_rims(solids, np.ascontiguousarray(offsets), _SHARES, room, times, excess, residuals)
    return times, excess, residuals


def _coefficients(
    solids: Solids, stiffness: NDArray[np.complex128], offsets: Array, times: Array, excess: Array, orders: Array
) -> NDArray[np.complex128]:
    """Return int q exp(-2 pi i n t) dt over a period of elements of unit amplitude, shape (rows, m, n)."""
    omega, leaving, touching = 2.0 * math.pi, times[..., 0, None], times[..., 1, None]

    def integral(order: Array) -> NDArray[np.complex128]:
        """Return int exp(2 pi i order t) dt over the contact."""
        rate = 1j * omega * order
        zero = order == 0.0
        ends = np.exp(rate * leaving) - np.exp(rate * touching)
        return np.where(zero, leaving - touching, ends / np.where(zero, 1.0, rate))

    total = (solids.equilibrium[:, None] * offsets)[..., None] * integral(-orders)
    complex_stiffness = stiffness[:, None, None]
    total = total + complex_stiffness / 2j * integral(1.0 - orders)
    total = total - np.conj(complex_stiffness) / 2j * integral(-1.0 - orders)
    waves = np.exp(-1j * omega * orders * touching)
    for k in range(solids.rates.shape[1]):
        sums = solids.rates[:, k, None, None] + 1j * omega * orders
        fades = -np.expm1(-sums * (leaving - touching))
        total = total + excess[..., k, None] * waves * fades / sums
    return total
