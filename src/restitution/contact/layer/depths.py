"""Depths of a body on a layer: from the depth on a half-space with the same contact radius, and back."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from typing import Any

import numpy as np

from restitution.checks import Array, Numeric, refuse
from restitution.contact.geometry import Kinks
from restitution.contact.layer.punch import PANELS, Punches, over_panels, stored_punches
from restitution.contact.profiles import Profile
from restitution.numerics.refine import refine

# Means of the resolvent and the load of flat punches over the transform of a profile, for all contact radii.
#
# Lengths are in units of the thickness. With ``G = int_0^a g dx`` the means are ``sigma(a) = int_0^a r g dx/G`` and
# ``tau(a) = int_0^a w g dx/G``. Both are smooth: an edge or a joint of the profile appears in G and hardly in them.

# Gauss nodes of a cell, the widest cell of g, and the tolerance of its series.
_NODES, _WIDEST, _TAIL = 16, 2.0, 1e-12
# Largest numbers of halvings of a cell, and of cells apart from those of joints.
_HALVINGS, _CELLS = 40, 1024
# Numbers of condensed nodes are multiples of this, so that there are few of them.
_ROUND = 12
_GAUSS, _WEIGHTS = np.polynomial.legendre.leggauss(_NODES)
_TO_LEGENDRE: Any = np.linalg.inv(np.polynomial.legendre.legvander(_GAUSS, _NODES - 1))


def power_law_series(punches: Punches, exponent: float) -> tuple[Array, Array]:
    """Return Chebyshev coefficients of sigma and tau over each panel for g = x^n, shape (n_panel, n_radius).

    The integrals over ``v = (x/a)^2`` with the weight ``v^((n - 1)/2)`` are exact by Gauss-Jacobi nodes.
    """
    from scipy.special import roots_jacobi

    def mean(series: Array) -> Array:
        nodes, weights = roots_jacobi(series.shape[1] // 2 + 1, 0.0, 0.5 * (exponent - 1.0))
        weights = weights / np.sum(weights)
        return series @ (np.polynomial.chebyshev.chebvander(nodes, series.shape[1] - 1).T @ weights)

    parts = punches.resolvent, punches.load
    sigma, tau = (np.array([mean(series) for series in part]) for part in parts)
    return sigma, tau


@dataclass(frozen=True, eq=False)
class Averages:
    """Means over the transform g(x) of a profile, of any unit, whose lengths are in units of the thickness."""

    punches: Punches
    transform: Callable[[Array], Array]
    face: float
    joints: Array  # radii at which g is not smooth
    end: float

    @cached_property
    def _pieces(self) -> tuple[Array, Array]:
        """Cells that resolve g, in the order of x, and its Legendre coefficients there.

        The columns of the cells are the joint where they begin, NaN in the first piece, and their ends in t. In the
        first piece of a profile with the face b ``x = hypot(b, t)``, beyond a joint ``x = joint + t^2``: g is smooth
        over t.
        """
        starts, ends = np.append(self.face, self.joints), np.append(self.joints, self.end)
        first = np.arange(starts.size) == 0
        reach = np.sqrt(np.where(first, (ends - self.face) * (ends + self.face), ends - starts))

        def fit(cells: Array) -> tuple[Array, Array]:
            _, low, high = cells.T[..., None]
            x, _ = self._place(cells, low + 0.5 * (high - low) * (1.0 + _GAUSS))
            g = self.transform(np.minimum(x, self.end))
            series = g @ _TO_LEGENDRE.T
            good = np.max(np.abs(series[:, -2:]), axis=1) <= _TAIL * np.max(np.abs(g), axis=1)
            # Contacts are at most 40 thicknesses wide.
            return good & (x[:, -1] - x[:, 0] <= _WIDEST * np.maximum(1.0, x[:, 0] / PANELS[-1])), series

        cells = np.column_stack([np.where(first, np.nan, starts), np.zeros(starts.size), reach])
        (cells, series), _ = refine(cells, fit, _HALVINGS, _CELLS + 4 * starts.size)
        order = np.argsort(self._place(cells, cells[:, 1:2])[0][:, 0], kind="stable")
        return cells[order], series[order]

    def _place(self, cells: Array, t: Array) -> tuple[Array, Array]:
        """Return x and dx/dt, shape (n_cell, k), at t of this shape."""
        joint = cells[:, :1]
        first = np.isnan(joint)
        x = np.where(first, np.hypot(self.face, t), joint + t * t)
        return x, np.where(first, t / np.where(x > 0.0, x, 1.0), 2.0 * t)

    def __call__(self, radius: Array) -> Array:
        """Return the means sigma and tau at radii of any shape."""
        flat = radius.ravel()
        moments = self.moments(flat, self.punches.terms(float(np.max(flat, initial=0.0))))
        return self.punches.means(flat, moments).reshape(2, *radius.shape)

    def moments(self, radius: Array, terms: int) -> Array:
        """Return means ``int_0^a T_k(2 (x/a)^2 - 1) g dx/G`` of Chebyshev polynomials at radii, shape (n, terms)."""
        # Numba takes half a second to import.
        from restitution.contact.loops import add_moments

        cells, series = self._pieces
        interval = np.clip(np.searchsorted(self._starts, radius, side="right") - 1, 0, self._starts.size - 1)
        # The cell that contains the radius, up to there.
        joint, low, high = cells[interval].T
        reach = np.where(np.isnan(joint), (radius - self.face) * (radius + self.face), radius - joint)
        reach = np.clip(np.sqrt(np.maximum(reach, 0.0)), low, high)
        x, masses = self._weighed(cells[interval], series[interval], reach)
        nodes, before = self._condensed(_ROUND * math.ceil(terms / _ROUND))
        moments, space = np.empty((radius.size, terms)), np.empty((4, nodes.size + _NODES))
        # Without a contact all masses are zero, and so are the means.
        a = np.where(radius > 0.0, radius, 1.0)
        add_moments(a, interval, (self._starts, nodes, before), x, masses, space, moments)
        return moments / np.where(moments[:, :1] > 0.0, moments[:, :1], 1.0)

    @cached_property
    def _starts(self) -> Array:
        """Radii x at the starts of the cells."""
        cells, _ = self._pieces
        return self._place(cells, cells[:, 1:2])[0][:, 0]

    def _weighed(self, cells: Array, series: Array, reach: Array) -> tuple[Array, Array]:
        """Return Gauss nodes x of cells up to t = `reach`, and their masses: weights times g."""
        _, low, high = cells.T[..., None]
        half = 0.5 * (reach[:, None] - low)
        t = low + half * (1.0 + _GAUSS)
        x, pace = self._place(cells, t)
        place = 2.0 * (t - low) / (high - low) - 1.0
        g = np.polynomial.legendre.legval(place, series.T[..., None], tensor=False)
        return x, half * _WEIGHTS * pace * g

    @cached_property
    def _condensed(self) -> Callable[[int], tuple[Array, Array]]:
        """Function from a number of terms to nodes x/b and masses there, shape (n_cell, n_node), b the cells' starts.

        The masses have the same moments as g in [0, b]. Polynomials over [0, b] have bounded coefficients on every
        part of it, so that errors do not grow from cell to cell.
        """
        from restitution.contact.loops import condense

        cells, series = self._pieces
        x, masses = self._weighed(cells, series, cells[:, 2])

        @cache
        def condensed(terms: int) -> tuple[Array, Array]:
            place = np.cos(np.pi * (np.arange(terms) + 0.5) / terms)
            # A function is the sum of its values at the nodes times these columns.
            weights = np.cos(np.arange(terms)[:, None] * np.arccos(place)) * (2.0 / terms)
            weights[0] *= 0.5
            nodes, sums = np.sqrt(0.5 + 0.5 * place), np.zeros((x.shape[0], terms))
            condense(self._starts, nodes, x, masses, weights, np.empty((4, terms + _NODES)), sums)
            return nodes, sums

        return condensed


# Share of the radius of a profile with an equator, at which the depth is infinite, that the tables describe.
_EQUATOR = 0.99
# Radii of the first estimate of the depth: decades below the thickness, and number.
_DECADES, _STARTS = 4.0, 240
_STEPS = 30


class PowerMeans:
    """Means sigma and tau for a power law, from series over each panel of the radius."""

    def __init__(self, punches: Punches, exponent: float) -> None:
        self._sigma, self._tau = power_law_series(punches, exponent)

    def __call__(self, radius: Array) -> tuple[Array, Array]:
        """Return the means at radii over the thickness of any shape."""
        return over_panels(self._sigma, radius), over_panels(self._tau, radius)


class Depths:
    """Depth, contact radius and force integral of a profile on a layer, in SI.

    A contact of the radius a has the depth D = g(a) on a half-space, and ``d = (D + sigma G/h)/w`` on the layer, with
    the means of `restitution.contact.layer.depths` and ``G = a D - Pi_0``, Pi_0 the force integral on a half-space.
    The stiffness radius is ``a kappa`` and the force integral ``d a kappa - tau G``.
    """

    def __init__(self, profile: Profile, thickness: float, poisson_ratio: float | None) -> None:
        self.profile, self.thickness, self.punches = profile, thickness, stored_punches(poisson_ratio)
        face = face_over_thickness(float(profile.contact_radius(0.0)), thickness)
        most = float(PANELS[-1])
        self.face, self.end = face, min(largest_radius(profile) / thickness, most)
        self.means: PowerMeans | Averages = self._means()
        # Samples of D whose contacts have radii on a logarithmic scale beyond the face.
        t = np.sqrt((self.end - face) * (self.end + face))
        radii = np.hypot(face, t * 10.0 ** np.linspace(-_DECADES - math.log10(max(t, 1.0)), 0.0, _STARTS))
        radii[-1] = self.end
        start = self._transform(radii)
        # Near an equator the depth rises much faster than the radius.
        start = np.sort(np.concatenate([start, start[-1] * np.linspace(0.02, 1.0, _STARTS // 2)]))
        start = np.minimum(start, self.profile.max_depth)
        # The inverse d -> D interpolates in logarithms, so that the samples must rise.
        kept = np.append(np.diff(start) > 0.0, True) & (start > 0.0)
        self._start = np.log(start[kept])
        self._reached = np.log(self.depth(start[kept]))
        self._slope = np.gradient(self._reached, self._start)
        self._deepest = float(start[-1])
        self.max_depth = float(self.depth(start[-1:])[0])

    def _means(self) -> PowerMeans | Averages:
        exponent = self.profile.path_exponent
        # A power law a ~ D^(p/2) has g = x^(2/p), whose means are exact; all other profiles need a quadrature of g.
        if exponent:
            return PowerMeans(self.punches, 2.0 / float(np.asarray(exponent)))
        joints = self.profile.joints / self.thickness
        joints = joints[(joints > self.face) & (joints < self.end)]
        return Averages(self.punches, self._transform, self.face, joints, self.end)

    def _transform(self, radius: Array) -> Array:
        """Return the transform g [m] at radii over the thickness; rounding may put the last one beyond the profile."""
        return self.profile.transform(np.minimum(radius * self.thickness, self.profile.max_contact_radius))

    def contact_radius(self, half_space_depth: Array) -> Array:
        """Return the contact radius [m] at the depth D [m] on a half-space, within the tables; 0 where D < 0."""
        return np.minimum(self.profile.contact_radius(half_space_depth), self.end * self.thickness)

    def depth(self, half_space_depth: Array) -> Array:
        """Return the depth d [m] on the layer where the contact radius is that of the depth D [m] on a half-space."""
        chi, gap = self._contact(half_space_depth)
        return (half_space_depth + self.means(chi)[0] * (gap / self.thickness)) / self.punches.edge_load(chi)

    def _contact(self, half_space_depth: Array) -> tuple[Array, Array]:
        """Return the radius a over the thickness, and G = a D - Pi_0 [m^2]."""
        a = self.contact_radius(half_space_depth)
        return a / self.thickness, a * half_space_depth - self.profile.force_integral_at_depth(half_space_depth)

    def half_space_depth(self, depth: Array) -> Array:
        """Return the depth D [m] on a half-space with the same contact radius as the depth d [m] on the layer."""
        inside = (depth > 0.0) & (depth <= self.max_depth)
        if not np.any(inside):
            return np.where(depth > 0.0, np.nan, np.minimum(depth, 0.0))
        target = np.log(np.where(inside, depth, self.max_depth))
        x = np.interp(target, self._reached, self._start)
        # Below the samples the layer is a half-space, where d is proportional to D.
        x = np.where(target < self._reached[0], target + self._start[0] - self._reached[0], x)
        slope = np.interp(x, self._start, self._slope)
        before = reached = x
        for rank in range(_STEPS):
            now = np.log(self.depth(self._inside(x)))
            # The secant, from the second step on, while the steps are above rounding.
            moved = (np.abs(x - before) > 1e-9) & (rank > 0)
            slope = np.where(moved, (now - reached) / np.where(moved, x - before, 1.0), slope)
            step, before, reached = (target - now) / slope, x, now
            # Beyond the last sample there is no profile.
            x = np.minimum(x + step, self._start[-1])
            if np.all(np.abs(step) <= 1e-15 * np.maximum(np.abs(x), 1.0)):
                break
        return np.where(inside, self._inside(x), np.where(depth > 0.0, np.nan, np.minimum(depth, 0.0)))

    def _inside(self, logarithm: Array) -> Array:
        """Return the depth D [m], which rounding must not put beyond the end of the profile."""
        return np.minimum(np.exp(logarithm), self._deepest)

    def stiffness_radius(self, half_space_depth: Array) -> Array:
        """Return the stiffness radius [m] at the depth D [m] on a half-space."""
        a = self.contact_radius(half_space_depth)
        return a * self.punches.kappa(a / self.thickness)

    def force_integral_at_depth(self, half_space_depth: Array) -> Array:
        """Return the force integral [m^2] at the depth D [m] on a half-space."""
        chi, gap = self._contact(half_space_depth)
        stiffness_radius = self.stiffness_radius(half_space_depth)
        return self.depth(half_space_depth) * stiffness_radius - self.means(chi)[1] * gap

    @property
    def kinks(self) -> Kinks:
        """Depths d [m] at which the contact radius of the profile is not smooth, and the strengths of a kappa there.

        On a half-space ``a = smooth + strength (D - D_j)^p``. With d' = dd/dD the stiffness radius on the layer has
        the strength ``w strength/d'^(p + 1)``.
        """
        profile_kinks = self.profile.kinks
        inside = profile_kinks.depth < self._deepest
        place, strength, power = profile_kinks.depth[inside], profile_kinks.strength[inside], profile_kinks.power
        depth = self.depth(place)
        # d' = d(ln d)/d(ln D) d/D
        log_slope = np.interp(np.log(place), self._start, self._slope)
        edge = self.punches.edge_load(self.contact_radius(place) / self.thickness)
        return Kinks(depth, edge * strength / (log_slope * depth / place) ** (power + 1.0), power)


def largest_radius(profile: Profile) -> float:
    """Return the largest contact radius [m] that the tables describe, on a thick layer."""
    end = float(profile.max_contact_radius)
    # g of a sphere has a logarithmic singularity at its equator, which no table resolves.
    if math.isfinite(end) and not math.isfinite(float(profile.transform(end))):
        end *= _EQUATOR
    return end


def face_over_thickness(radius: Numeric, thickness: Numeric) -> Any:
    """Return the radius of a flat face over the thickness, which must be within the tables."""
    bad = np.asarray(radius >= PANELS[-1] * thickness)
    if bad.any():
        least = np.max(np.broadcast_to(radius, bad.shape)[bad]) / PANELS[-1]
        rule = f"must be above {least:.3g} m: the tables end where the contact is {PANELS[-1]:g} h wide"
        refuse("thickness", np.broadcast_to(thickness, bad.shape), bad, rule, "m")
    return radius / thickness


depths = lru_cache(maxsize=64)(Depths)
"""The depths of a profile on a layer of a thickness, which are computed once."""
