"""Means of the resolvent and the load of flat punches over the transform of a profile, for all contact radii.

Lengths are in units of the thickness. With ``G = int_0^a g dx`` the means are ``sigma(a) = int_0^a r g dx/G`` and
``tau(a) = int_0^a w g dx/G``. Both are smooth: an edge or a joint of the profile appears in G and hardly in them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, NamedTuple

import numpy as np

from restitution.contact.geometry import Array
from restitution.contact.layer.punch import PANELS, Punches

# Gauss nodes of a cell, the widest cell of g, and the tolerance of its series.
_NODES, _WIDEST, _TAIL = 16, 2.0, 1e-12
# Largest numbers of halvings of a cell, and of cells apart from those of joints.
_HALVINGS, _CELLS = 40, 1024
# Numbers of condensed nodes are multiples of this, so that there are few of them.
_ROUND = 12
_GAUSS, _WEIGHTS = np.polynomial.legendre.leggauss(_NODES)
_TO_LEGENDRE: Any = np.linalg.inv(np.polynomial.legendre.legvander(_GAUSS, _NODES - 1))


def power_law_series(found: Punches, exponent: float) -> tuple[Array, Array]:
    """Chebyshev coefficients of sigma and tau over each panel for g = x^n, shape (n_panel, n_radius).

    The integrals over ``v = (x/a)^2`` with the weight ``v^((n - 1)/2)`` are exact by Gauss-Jacobi nodes.
    """
    from scipy.special import roots_jacobi

    def mean(series: Array) -> Array:
        nodes, weights = roots_jacobi(series.shape[1] // 2 + 1, 0.0, 0.5 * (exponent - 1.0))
        weights = weights / np.sum(weights)
        return series @ (np.polynomial.chebyshev.chebvander(nodes, series.shape[1] - 1).T @ weights)

    parts = found.resolvent, found.load
    sigma, tau = (np.array([mean(series) for series in part]) for part in parts)
    return sigma, tau


class _Cells(NamedTuple):
    """Cells over x; in the first piece of a profile with the face b ``x = hypot(b, t)``, beyond a joint ``x = joint +
    t^2``, in which g is smooth.
    """

    joint: Array  # The joint, NaN in the first piece
    low: Array  # t at the start of the cell
    high: Array  # t at the end

    def place(self, t: Array, face: float) -> tuple[Array, Array]:
        """Return x and dx/dt, shape (n_cell, k), at t of this shape."""
        joint = self.joint[:, None]
        first = np.isnan(joint)
        x = np.where(first, np.hypot(face, t), joint + t * t)
        return x, np.where(first, t / np.where(x > 0.0, x, 1.0), 2.0 * t)

    def part(self, chosen: Any) -> _Cells:
        return _Cells(self.joint[chosen], self.low[chosen], self.high[chosen])

    def halves(self) -> _Cells:
        middle = 0.5 * (self.low + self.high)
        return _Cells(np.tile(self.joint, 2), np.append(self.low, middle), np.append(middle, self.high))


@dataclass(frozen=True, eq=False)
class Averages:
    """Means over the transform of a profile in units of the thickness.

    Parameters
    ----------
    punches : Punches
        The flat punches.
    transform : callable
        Transform g(x) of the profile, with any unit.
    face, joints, end : float, array, float
        Radius of the flat face, radii at which g is not smooth, largest radius.
    """

    punches: Punches
    transform: Callable[[Array], Array]
    face: float
    joints: Array
    end: float

    @cached_property
    def _pieces(self) -> tuple[_Cells, Array]:
        """Cells that resolve g, in the order of x, and its Legendre coefficients there."""
        starts = np.append(self.face, self.joints)
        ends = np.append(self.joints, self.end)
        first = np.arange(starts.size) == 0
        reach = np.sqrt(np.where(first, (ends - self.face) * (ends + self.face), ends - starts))
        pending = _Cells(np.where(first, np.nan, starts), np.zeros(starts.size), reach)
        done: list[tuple[_Cells, Array]] = []
        count = 0
        for rank in range(_HALVINGS + 1):
            t = pending.low[:, None] + 0.5 * (pending.high - pending.low)[:, None] * (1.0 + _GAUSS)
            x, _ = pending.place(t, self.face)
            g = self.transform(np.minimum(x, self.end))
            series = g @ _TO_LEGENDRE.T
            good = np.max(np.abs(series[:, -2:]), axis=1) <= _TAIL * np.max(np.abs(g), axis=1)
            # Contacts are at most 40 thicknesses wide.
            good &= x[:, -1] - x[:, 0] <= _WIDEST * np.maximum(1.0, x[:, 0] / PANELS[-1])
            count += pending.low.size
            good |= rank == _HALVINGS or count > _CELLS + 4 * starts.size
            done.append((pending.part(good), series[good]))
            pending = pending.part(~good).halves()
            if not pending.low.size:
                break
        cells = _Cells(*(np.concatenate(one) for one in zip(*(cells for cells, _ in done), strict=True)))
        order = np.argsort(cells.place(cells.low[:, None], self.face)[0][:, 0], kind="stable")
        return cells.part(order), np.concatenate([series for _, series in done])[order]

    def __call__(self, radius: Array) -> Array:
        """Means sigma and tau at radii of any shape."""
        flat = radius.ravel()
        moments = self.moments(flat, self.punches.terms(float(np.max(flat, initial=0.0))))
        return self.punches.means(flat, moments).reshape(2, *radius.shape)

    def moments(self, radius: Array, terms: int) -> Array:
        """Means ``int_0^a T_k(2 (x/a)^2 - 1) g dx/G`` of Chebyshev polynomials at radii, shape (n, terms)."""
        # Numba takes half a second to import.
        from restitution.contact.layer.moments import add_moments

        cells, series = self._pieces
        own = np.clip(np.searchsorted(self._starts, radius, side="right") - 1, 0, self._starts.size - 1)
        # The cell that contains the radius, up to there.
        cell = cells.part(own)
        beyond = np.isnan(cell.joint)
        reach = np.where(beyond, (radius - self.face) * (radius + self.face), radius - cell.joint)
        reach = np.clip(np.sqrt(np.maximum(reach, 0.0)), cell.low, cell.high)
        x, masses = self._weighed(cell, series[own], reach)
        nodes, before = self._condensed(_ROUND * math.ceil(terms / _ROUND))
        moments, space = np.empty((radius.size, terms)), np.empty((4, nodes.size + _NODES))
        a = np.where(radius > 0.0, radius, 1.0)
        add_moments(a, own, self._starts, nodes, before, x, masses, space, moments)
        return moments / np.where(moments[:, :1] > 0.0, moments[:, :1], 1.0)

    @cached_property
    def _starts(self) -> Array:
        """Radii x at the starts of the cells."""
        cells, _ = self._pieces
        return cells.place(cells.low[:, None], self.face)[0][:, 0]

    def _weighed(self, cells: _Cells, series: Array, reach: Array) -> tuple[Array, Array]:
        """Gauss nodes x of cells up to t = `reach`, and their masses: weights times g."""
        half = 0.5 * (reach - cells.low)[:, None]
        t = cells.low[:, None] + half * (1.0 + _GAUSS)
        x, pace = cells.place(t, self.face)
        local = 2.0 * (t - cells.low[:, None]) / (cells.high - cells.low)[:, None] - 1.0
        g = np.polynomial.legendre.legval(local, series.T[..., None], tensor=False)
        return x, half * _WEIGHTS * pace * g

    @cached_property
    def _condensed(self) -> Callable[[int], tuple[Array, Array]]:
        """Function from a number of terms to nodes x/b and masses there, shape (n_cell, n_node), b the cells' starts.

        The masses have the same moments as g in [0, b]. Polynomials over [0, b] have bounded coefficients on every
        part of it, so that errors do not grow from cell to cell.
        """
        from restitution.contact.layer.moments import condense

        cells, series = self._pieces
        x, masses = self._weighed(cells, series, cells.high)

        @cache
        def condensed(terms: int) -> tuple[Array, Array]:
            place = np.cos(np.pi * (np.arange(terms) + 0.5) / terms)
            # A function is the sum of its values at the nodes times these columns.
            weights = np.cos(np.arange(terms)[:, None] * np.arccos(place)) * (2.0 / terms)
            weights[0] *= 0.5
            nodes, found = np.sqrt(0.5 + 0.5 * place), np.zeros((x.shape[0], terms))
            condense(self._starts, nodes, x, masses, weights, np.empty((4, terms + _NODES)), found)
            return nodes, found

        return condensed
