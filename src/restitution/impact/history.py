"""The whole history of one impact, from the solver's own dense output."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.checks import finite
from restitution.contact.path import evaluate

if TYPE_CHECKING:
    from restitution.impact.scaling import ScaledImpact
    from restitution.kernel.radau import Scheme
    from restitution.kernel.workspace import Work

Array = NDArray[np.float64]


class Trajectory(NamedTuple):
    """Motion from first touch to separation, arrays of shape (n,).

    Attributes
    ----------
    time : array
        t [s]; the last entry is the instant of separation.
    indentation_depth : array
        d [m].
    indentation_velocity : array
        v = d' [m/s], negative on the way back.
    force : array
        Normal force F [N].
    contact_radius : array
        a [m].
    """

    time: Array
    indentation_depth: Array
    indentation_velocity: Array
    force: Array
    contact_radius: Array


def contact_radius(scaled: ScaledImpact, s: Array) -> Array:
    """Scaled contact radius at s, the square root of the scaled depth, any shape."""
    if scaled.table is None:
        return np.maximum(s, 0.0) ** scaled.exponent
    return evaluate(scaled.table, s * scaled.length**0.5)[0] / scaled.radius


class DenseOutput:
    """Dense output of the exact method for one impact that ended in separation, in SI.

    Parameters
    ----------
    scaled : ScaledImpact
        The impact and its units.
    scheme, work
        With which scheme the kernel solved it, and its stored halves.
    mass, velocity : float
        [kg], [m/s].
    """

    def __init__(
        self, scaled: ScaledImpact, scheme: Scheme, work: Work, mass: float, velocity: float
    ) -> None:
        self._units = (scaled.time, scaled.length, velocity, mass * velocity / scaled.time, scaled.radius)
        self._scheme = scheme
        self._scaled = scaled
        n_approach, n_rebound = int(work.counts[0]) + 1, int(work.counts[1]) + 1
        self._sigma_m = float(work.turning_place[0])
        self._starts = work.places[0, :n_approach].copy()
        self._lengths = work.places[1, :n_approach].copy()
        # Columns s, v, t, F; the rebound's first column is s1, to which d is added as a fifth.
        self._approach = np.moveaxis(work.approach[:n_approach, :4], 1, 2).copy()
        back = np.moveaxis(work.rebound[:n_rebound, :4], 1, 2)
        self._back_starts = work.places[2, :n_rebound].copy()
        self._back_lengths = work.places[3, :n_rebound].copy()
        depth = np.empty(back.shape[:2])
        start = float(work.turning[0]) ** 2
        for element in range(n_rebound):
            depth[element, 0] = start
            rate = work.slopes[element] * back[element, 1:, 1]
            depth[element, 1:] = start + self._back_lengths[element] * (scheme.A @ rate)
            start = depth[element, -1]
        self._rebound = np.concatenate([back, depth[:, :, None]], axis=2)
        self._turning_time = float(work.turning[2])
        self._end = float(back[-1, -1, 2])

    @property
    def contact_time(self) -> float:
        """Contact time [s]."""
        return self._end * self._units[0]

    @property
    def turning_time(self) -> float:
        """Time [s] at which the indentation is deepest."""
        return self._turning_time * self._units[0]

    def times(self, n_points: int) -> Array:
        """Return `n_points` times [s] from first touch to separation, as dense as the solver's own steps."""
        share = np.linspace(0.0, 1.0, n_points)
        knots = np.concatenate([self._approach[:, 0, 2], self._rebound[:, 0, 2], [self._end]])
        knots = np.unique(np.clip(knots, 0.0, self._end))
        # Half of the points evenly over time, half over steps: thin layers and long creep are both seen.
        passed = 0.5 * (np.linspace(0.0, 1.0, knots.size) + knots / self._end)
        times = np.interp(share, passed, knots) * self._units[0]
        times[-1] = self.contact_time
        return times

    def at(self, times: ArrayLike) -> Trajectory:
        """Motion at the given times.

        Parameters
        ----------
        times : array_like, shape (n,)
            t [s], from 0 to the contact time.

        Returns
        -------
        Trajectory
            Depth, velocity, force, contact radius at these times.

        Raises
        ------
        ValueError
            If a time lies outside the contact.
        """
        moments = np.atleast_1d(np.asarray(finite("times", times, "s"), dtype=np.float64))
        if np.any(moments < 0.0) or np.any(moments > self.contact_time * (1.0 + 1e-12)):
            bad = moments[(moments < 0.0) | (moments > self.contact_time * (1.0 + 1e-12))][0]
            raise ValueError(
                f"times = {bad:g} s: must be in [0, {self.contact_time:g}] s, the duration of contact"
            )
        t = np.minimum(moments / self._units[0], self._end)
        columns = np.empty((t.size, 4))
        coming = t <= self._turning_time
        s, v, _, force = self._locate(self._approach, t[coming])[2].T[:4]
        columns[coming] = np.column_stack([s**2, v, force, s])
        element, x, values = self._locate(self._rebound, t[~coming])
        position = self._back_starts[element] + x * self._back_lengths[element]
        s1 = self._path_s(np.where(t[~coming] < self._end, np.maximum(self._sigma_m - position, 0.0), 0.0))
        columns[~coming] = np.column_stack([values[:, 4], values[:, 1], values[:, 3], s1])
        _, length, velocity, force_unit, radius = self._units
        a = contact_radius(self._scaled, columns[:, 3])
        return Trajectory(
            np.minimum(moments, self.contact_time), columns[:, 0] * length, columns[:, 1] * velocity,
            np.maximum(columns[:, 2], 0.0) * force_unit, a * radius,
        )  # fmt: skip

    def _basis(self, x: Array) -> Array:
        """Lagrange basis at x, shape (n, S + 1)."""
        distance = x[:, None] - self._scheme.c[None, :]
        hit = np.abs(distance) < 1e-14
        terms = self._scheme.weights / np.where(hit, 1.0, distance)
        basis = terms / terms.sum(axis=1, keepdims=True)
        rows = hit.any(axis=1)
        basis[rows] = hit[rows]
        return basis

    def _locate(self, tables: Array, t: Array) -> tuple[NDArray[np.intp], Array, Array]:
        """Find the element and the place in it at which the time is t, and all columns there."""
        element = np.clip(np.searchsorted(tables[:, 0, 2], t, side="right") - 1, 0, len(tables) - 1)
        low, high = np.zeros(t.size), np.ones(t.size)
        column = tables[element, :, 2]
        for _ in range(52):
            middle = 0.5 * (low + high)
            late = np.einsum("nj,nj->n", self._basis(middle), column) > t
            high = np.where(late, middle, high)
            low = np.where(late, low, middle)
        x = np.where(t <= column[:, 0], 0.0, np.where(t >= column[:, -1], 1.0, 0.5 * (low + high)))
        return element, x, np.einsum("nj,njc->nc", self._basis(x), tables[element])

    def _path_s(self, sigma: Array) -> Array:
        """Depth coordinate s of the approach at sigma."""
        element = np.clip(np.searchsorted(self._starts, sigma, side="right") - 1, 0, self._starts.size - 1)
        x = (sigma - self._starts[element]) / self._lengths[element]
        return np.einsum("nj,nj->n", self._basis(x), self._approach[element, :, 0])
