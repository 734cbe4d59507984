"""Energies over the time of contact, by quadrature over the foundation from the stored impact.

The element touched at t0(x) has in branch k the elongation `w_k = H_k(t) - exp(-(t - t0)/tau_k) H_k(t0)`.
With

    H_k = int_0^t exp(-(t - t')/tau_k) d' dt',     Y_k = int_0^t exp(-(t - t')/tau_k) a d' dt',
    Z_k = int_0^t exp(-2 (t - t')/tau_k) H_k a d' dt'

the integral over the contact is

    int_0^a w_k^2 dx = 2 (H_k Y_k - Z_k)                                    in the approach,
    int_0^a w_k^2 dx = a (H_k - X_k H1_k)^2 + 2 X_k (H_k Y1_k - X_k Z1_k)   in the rebound,

index 1 for the instant t1 of the approach with the same contact radius and `X_k = exp(-(t - t1)/tau_k)`.
Rate 0, for which H is the depth d, is the spring in parallel.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.impact.stored import H_, S_, T_, V_, StoredImpact

Array = NDArray[np.float64]


class _Past(NamedTuple):
    """The approach where the contact radius is that of the rebound: a, t, H, Y, Z."""

    radius: Array
    time: Array
    memory: Array
    force: Array
    square: Array


class EnergyHistory:
    """Energy stored in the foundation and dissipated in it, as functions of time.

    Parameters
    ----------
    stored : StoredImpact
        The impact.
    """

    def __init__(self, stored: StoredImpact) -> None:
        self._stored = stored
        rates, scheme = stored.rates, stored.scheme
        half = stored.approach
        nodes = half.columns[:, 1:]
        radius = stored.radius(nodes[..., S_])
        flow = half.pace * radius * nodes[..., V_]
        zero = np.zeros(rates.size)
        force = stored.propagate(half.lengths, half.pace, rates, flow, zero)
        source = flow[..., None] * nodes[..., H_:]
        square = stored.propagate(half.lengths, half.pace, 2.0 * rates, source, zero)
        self._force, self._square = force, square
        squares = 2.0 * (nodes[..., H_:] * force[:, 1:] - square[:, 1:])
        power = self._power(squares, radius, nodes[..., V_])
        self._lost = self._cumulated(half.lengths, half.pace * power, 0.0)
        turning = stored.places(half, np.array([stored.sigma_m]))
        lost = float(stored.interpolate(self._lost[..., None], *turning)[0, 0])

        half = stored.rebound
        nodes = half.columns[:, 1:]
        sigma = stored.sigma_m - half.starts[:, None] - half.lengths[:, None] * scheme.c[1:]
        sigma[-1, -1] = 0.0
        flat = nodes.reshape(-1, nodes.shape[-1])
        squares, density, radius = self._rebound_state(flat, sigma.ravel())
        power = self._power(squares, radius, flat[:, V_]).reshape(sigma.shape)
        self._lost_later = self._cumulated(half.lengths, half.pace * power, lost)
        # What leaves is - int density da = int a d(density) - a density, which has no singular da.
        points = np.zeros(half.columns.shape[:2])
        points[:, 1:] = density.reshape(sigma.shape)
        points[1:, 0] = points[:-1, -1]
        slope = points @ scheme.derivative[1:].T / half.lengths[:, None]
        self._released = self._cumulated(half.lengths, radius.reshape(sigma.shape) * slope, 0.0)

    def at(self, time: Array) -> tuple[Array, Array]:
        """Energies at the times t, shape (n,), scaled, from first touch to separation.

        Returns
        -------
        stored, dissipated : array, shape (n,)
            In units of m v0^2: energy in the springs of the foundation, that of elements which have left as
            it was then; energy that the dashpots of elements in contact have taken.
        """
        whole = self._stored
        time = np.minimum(time, whole.end)
        kept, lost = np.empty(time.size), np.empty(time.size)
        coming = time <= whole.turning_time
        places = whole.find(whole.approach, T_, time[coming])
        state = whole.interpolate(whole.approach.columns, *places)
        memory = whole.interpolate(np.dstack([self._force, self._square]), *places)
        force, square = np.split(memory, 2, axis=1)
        # At the first touch nothing but rounding is left of the difference.
        kept[coming] = np.maximum((state[:, H_:] * force - square) @ whole.moduli, 0.0)
        lost[coming] = whole.interpolate(self._lost[..., None], *places)[:, 0]
        places = whole.find(whole.rebound, T_, time[~coming])
        state = whole.interpolate(whole.rebound.columns, *places)
        sigma = np.maximum(whole.sigma_m - whole.position(whole.rebound, *places), 0.0)
        squares, density, radius = self._rebound_state(state, sigma)
        released = whole.interpolate(self._released[..., None], *places)[:, 0] - radius * density
        kept[~coming] = 0.5 * squares @ whole.moduli + released
        lost[~coming] = whole.interpolate(self._lost_later[..., None], *places)[:, 0]
        return kept, lost

    def _rebound_state(self, state: Array, sigma: Array) -> tuple[Array, Array, Array]:
        """Integrals of w_k^2, energy per length at the edge, and a, where the approach was at sigma."""
        past = self._past(sigma)
        whole = self._stored
        decay = np.exp(np.minimum((past.time - state[:, T_])[:, None] * whole.rates, 0.0))
        edge = state[:, H_:] - decay * past.memory
        squares = past.radius[:, None] * edge**2
        squares += 2.0 * decay * (state[:, H_:] * past.force - decay * past.square)
        return squares, 0.5 * edge**2 @ whole.moduli, past.radius

    def _past(self, sigma: Array) -> _Past:
        whole = self._stored
        places = whole.places(whole.approach, sigma)
        columns = np.dstack([whole.approach.columns, self._force, self._square])
        state = whole.interpolate(columns, *places)
        count = whole.rates.size
        return _Past(
            whole.radius(state[:, S_]), state[:, T_], state[:, H_ : H_ + count],
            state[:, H_ + count : H_ + 2 * count], state[:, H_ + 2 * count :],
        )  # fmt: skip

    def _power(self, squares: Array, radius: Array, velocity: Array) -> Array:
        """Power of all dashpots."""
        whole = self._stored
        return squares @ (whole.moduli * whole.rates) + whole.problem.viscosity * radius * velocity**2

    def _cumulated(self, lengths: Array, source: Array, start: float) -> Array:
        """Points of the integral of a source at the nodes, over all elements, shape (E, S + 1)."""
        inner = lengths[:, None] * (source @ self._stored.scheme.A.T)
        first = start + np.concatenate([[0.0], np.cumsum(inner[:, -1])[:-1]])
        return np.column_stack([first, first[:, None] + inner])
