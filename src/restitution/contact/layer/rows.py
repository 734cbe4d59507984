"""A profile on layers of many thicknesses, whose tables are made together.

The moments of the profile over Chebyshev polynomials of ``2 (x/a)^2 - 1`` do not depend on the thickness, and the
means of `restitution.contact.layer.averages` are their sums with the coefficients of the flat punches.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.contact.geometry import Array, Kinks, as_array
from restitution.contact.layer.averages import Averages
from restitution.contact.layer.depths import Depths, depths, largest_radius
from restitution.contact.layer.punch import PANELS, Punches
from restitution.contact.layer.store import stored_punches
from restitution.contact.matrix import product
from restitution.contact.path import PathTable, path_tables, scaled, significant_kinks
from restitution.contact.profile import Profile
from restitution.contact.rows import Rows, Samples

# Samples of the depth: number, distance in the logarithm, and the logarithm of the first one.
_SAMPLES, _APART, _FIRST = 40, 0.5, -300.0
# Layers whose thickness differs by less than this share may represent each other for estimates.
_SIMILAR = 0.2
# Nodes of the interpolation over ln h, those for each unit of it over ln(a/h), and largest of its last coefficients.
_NODES, _RATES, _TAIL = 12, ([-0.5, 2.0, 3.7], [4.3, 7.6, 8.5]), 1e-11
# Relative step of the parameter for the slope of the depth at kinks.
_STEP = 1e-4


# A table, and the units of its depth [m] and its stiffness radius [m].
_Sized = tuple[PathTable, float, float]


class _Contacts(NamedTuple):
    """Contacts of a profile [SI]: radius a, depth D on a half-space, ``G = a D - Pi_0``, and moments, (n, n_term)."""

    radius: Array
    depth: Array
    gap: Array
    moments: Array


@dataclass(frozen=True, eq=False)
class LayerRows(Rows):
    """A single profile that is no power law on layers of many thicknesses."""

    profile: Profile
    thickness: Array
    poisson_ratio: float | None  # None for a frictionless base

    @cached_property
    def _punches(self) -> Punches:
        return stored_punches(self.poisson_ratio)

    @cached_property
    def _distinct(self) -> tuple[Array, NDArray[np.intp]]:
        values, which = np.unique(self.thickness, return_inverse=True)
        return values, which.reshape(-1)

    @property
    def which(self) -> NDArray[np.intp]:
        """Number of the distinct thickness of each row, from the smallest one on."""
        return self._distinct[1]

    def raveled(self, shape: tuple[int, ...]) -> Self:
        """Return the rows broadcast to a shape and raveled."""
        return type(self)(self.profile, np.broadcast_to(self.thickness, shape).reshape(-1), self.poisson_ratio)

    def _each(self, function: Callable[[Depths, Array], Array], depth: ArrayLike) -> Array:
        depth = np.broadcast_to(as_array(depth), self.thickness.shape)
        result = np.empty(depth.shape)
        for k, thickness in enumerate(self._distinct[0].tolist()):
            one: Any = depths(self.profile, thickness, self.poisson_ratio)
            rows = self.which == k
            result[rows] = function(one, one.half_space_depth(np.minimum(depth[rows], one.max_depth)))
        return result

    def stiffness_radius(self, depth: ArrayLike) -> Array:
        """Stiffness radius a kappa [m] at depth d [m] of each row."""
        return self._each(Depths.stiffness_radius, depth)

    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Force integral int_0^d a kappa dd [m^2] at depth d [m] of each row."""
        return self._each(Depths.force_integral, depth)

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Contact radius a [m] at depth d [m] of each row."""
        return self._each(Depths.radius, depth)

    def contact_radius_at(self, depth: ArrayLike, stiffness_radius: ArrayLike) -> Array:
        """Contact radius a [m] from the stiffness radius a kappa [m]."""
        return self._punches.radius(as_array(stiffness_radius) / self.thickness) * self.thickness

    @property
    def max_depth(self) -> Array:
        """Depth [m] of each row at which the tables end."""
        return self._deepest[self.which]

    @cached_property
    def _widest(self) -> Array:
        """Largest contact radius [m] on each distinct layer."""
        return np.minimum(largest_radius(self.profile), PANELS[-1] * self._distinct[0])

    @cached_property
    def _deepest(self) -> Array:
        contacts = self._contacts(self.profile.transform(self._widest), self._averages(float(self._widest[-1])))
        own = np.arange(self._widest.size)
        return self._evaluated(contacts, own, own)[0]

    def _averages(self, end: float) -> Averages:
        """Means up to a largest radius [m]; the cells of the quadrature are fine enough for the thinnest layer."""
        face, joints, unit = float(self.profile.contact_radius(0.0)), self.profile.joints, float(self._distinct[0][0])
        inside = joints[(joints > face) & (joints < end)] / unit
        return Averages(self._punches, self._transform, face / unit, inside, end / unit)

    def _contacts(self, depth: Array, averages: Averages) -> _Contacts:
        """Contacts at depths on a half-space, shape (n,), within the range of the means."""
        profile, unit = self.profile, float(self._distinct[0][0])
        radius = np.minimum(profile.contact_radius(depth), averages.end * unit)
        most = np.minimum(radius / unit, PANELS[-1])
        moments = np.zeros((radius.size, self._punches.terms(float(np.max(most)))))
        # Small contacts need few terms.
        sizes = np.ceil(0.5 * np.log2(np.maximum(most, 1.0)))
        for size in np.unique(sizes):
            rows = np.flatnonzero(sizes == size)
            terms = self._punches.terms(float(np.max(most[rows])))
            moments[rows, :terms] = averages.moments(radius[rows] / unit, terms)
        return _Contacts(radius, depth, radius * depth - profile.force_integral(radius), moments)

    def _transform(self, radius: Array) -> Array:
        unit = float(self._distinct[0][0])
        return self.profile.transform(np.minimum(radius * unit, self.profile.max_contact_radius))

    def _evaluated(
        self, contacts: _Contacts, layer: NDArray[np.intp], contact: NDArray[np.intp], loads: bool = False
    ) -> list[Array]:
        """Depth, stiffness radius and, with `loads`, force integral [SI] of contacts on layers, by their numbers."""
        thickness, radius, gap = self._distinct[0][layer], contacts.radius[contact], contacts.gap[contact]
        kappa, edge, sigma, *tau = self._punches.means(radius / thickness, contacts.moments, contact, loads)
        depth = (contacts.depth[contact] + sigma * gap / thickness) / edge
        return [depth, radius * kappa, *(depth * radius * kappa - one * gap for one in tau)]

    @cached_property
    def samples(self) -> Samples:
        """Depths and force integrals of the distinct layers over the logarithm of the depth on a half-space."""
        end = float(self._widest[-1])
        deepest = float(self.profile.transform(end))
        last = math.log(deepest)
        count = max(_SAMPLES, math.ceil((last - _FIRST) / _APART))
        knots = as_array(last - _APART * np.arange(count)[::-1])
        # Rounding must not exceed the end of the profile.
        half_space = np.minimum(np.exp(knots), deepest)
        contacts = self._contacts(half_space[-_SAMPLES:], self._averages(end))
        # The thinnest of similar layers represents the others.
        _, chosen, group = np.unique(
            np.floor(np.log(self._distinct[0]) / _SIMILAR), return_index=True, return_inverse=True
        )
        inside = contacts.radius <= self._widest[chosen][:, None]
        layer, contact = np.nonzero(inside)
        # Beyond the end of the tables nothing yields.
        depth, integral = np.full((2, *inside.shape), -_FIRST)
        depth[inside], _, integral[inside] = np.log(self._evaluated(contacts, chosen[layer], contact, loads=True))
        depth = np.where(inside, depth, np.max(np.where(inside, depth, _FIRST), axis=1)[:, None])
        # At small depths both have constant ratios to those of the half-space.
        flat = np.log(np.maximum(self.profile.force_integral_at_depth(half_space), 1e-300))
        pad = ((0, 0), (count - _SAMPLES, 0))
        depth = np.pad(depth - knots[-_SAMPLES:], pad, mode="edge") + knots
        integral = np.pad(integral - flat[-_SAMPLES:], pad, mode="edge") + flat
        return Samples(knots, as_array(depth)[group.reshape(-1)], as_array(integral)[group.reshape(-1)])

    def tables(self, deepest: Array, least: Array, rtol: float) -> list[_Sized]:
        """Tables of the distinct layers; those with tables of the same largest contact radius are made together."""
        knots, depth, integral = self.samples
        ends = [np.interp(np.log(d), row, knots) for d, row in zip(deepest, depth, strict=True)]
        wanted = self.profile.contact_radius(np.minimum(np.exp(ends), math.exp(knots[-1]) * (1.0 - 1e-15)))
        wanted = np.minimum(wanted, self._widest)
        # At a sample that is not deeper.
        place = np.maximum(np.sum(depth <= np.log(least)[:, None], axis=1) - 1, 0)
        small = np.exp(integral[np.arange(place.size), place])
        found: dict[int, _Sized] = {}
        pending = np.argsort(-wanted, kind="stable")
        while pending.size:
            end = float(wanted[pending[0]])
            together = self._widest[pending] >= end
            layers, pending = np.sort(pending[together]), pending[~together]
            made = self._interpolated(layers, end, small[layers], rtol)
            found |= zip(layers.tolist(), made, strict=True)
        return [found[k] for k in range(len(found))]

    def _interpolated(self, layers: NDArray[np.intp], end: float, least: Array, rtol: float) -> list[_Sized]:
        """Tables of some layers up to one contact radius, interpolated over ln h where this is less work."""
        logs = np.log(self._distinct[0][layers])
        half = 0.5 * (logs[-1] - logs[0])
        rate = np.interp(math.log(end) - logs[0], *_RATES)
        count = math.ceil(_NODES + rate * 2.0 * half)
        if layers.size <= count:
            return self._made(layers, end, least, rtol)
        x = -np.cos(np.pi * (np.arange(count) + 0.5) / count)
        places = logs[0] + half * (1.0 + x)
        lowest = np.exp(np.interp(places, logs, np.log(least)))
        nodes = type(self)(self.profile, np.exp(places), self.poisson_ratio)
        made = nodes._made(np.arange(count), end, lowest, rtol)
        found, tail = _between(made, x, np.clip((logs - logs[0]) / half - 1.0, -1.0, 1.0))
        return found if tail <= _TAIL else self._made(layers, end, least, rtol)

    def _made(self, layers: NDArray[np.intp], end: float, least: Array, rtol: float) -> list[_Sized]:
        """Tables of some layers up to one contact radius."""
        deepest, averages = float(self.profile.transform(end)), self._averages(end)

        def curve(y: Array) -> tuple[Array, Array]:
            contacts = self._contacts(np.minimum(deepest * y * y, deepest).ravel(), averages)
            layer = np.repeat(layers, y.size)
            depth, radius = self._evaluated(contacts, layer, np.tile(np.arange(y.size), layers.size))
            return depth.reshape(layers.size, *y.shape), radius.reshape(layers.size, *y.shape)

        kinks = significant_kinks(self.profile, deepest, rtol)
        strengths = np.zeros((layers.size, 0))
        if kinks.depth.size:
            # As for a single layer.
            place = np.sqrt(kinks.depth)
            around = curve(np.concatenate([place * (1.0 - _STEP), place * (1.0 + _STEP)]))[0]
            slope = (around[:, place.size :] - around[:, : place.size]) / (4.0 * _STEP * kinks.depth * deepest)
            radius = self.profile.contact_radius(kinks.depth * deepest) / self._distinct[0][layers][:, None]
            strengths = self._punches.edge_load(radius) * kinks.strength / slope ** (kinks.power + 1.0)
        tables = path_tables(curve, Kinks(kinks.depth, strengths, kinks.power), rtol, least)
        sizes = [(float(table.edges[-1]) ** 2, float(np.sum(table.radius[-1]))) for table in tables]
        return [(scaled(table, *size), *size) for table, size in zip(tables, sizes, strict=True)]


def _between(made: list[_Sized], x: Array, wanted: Array) -> tuple[list[_Sized], float]:
    """Tables at the places `wanted` in [-1, 1] from those at Chebyshev nodes x, and the tail of the series."""
    count = x.size
    to_series: Any = np.linalg.inv(np.polynomial.chebyshev.chebvander(x, count - 1))
    matrix = np.polynomial.chebyshev.chebvander(wanted, count - 1) @ to_series
    tables = [table for table, _, _ in made]
    sizes = np.log([size for _, *size in made])
    edges, origin, radius, integral, kinks, strengths = (
        np.stack([getattr(table, name) for table in tables])
        for name in ("edges", "origin", "radius", "force_integral", "kinks", "strengths")
    )
    # Coefficients of polynomials have errors that their values have not.
    powers = np.linspace(0.0, 1.0, 5) ** np.arange(integral.shape[2])[:, None]
    values = (radius @ powers[: radius.shape[2]], integral @ powers)
    checked = [
        (edges[:, 1:], edges[0, 1:]),
        (sizes, 1.0),
        *((one, np.max(one, axis=(0, 2))[:, None]) for one in values),
    ]
    tail = max(float(np.max(np.abs(np.tensordot(to_series[-2:], one, axes=1)) / scale)) for one, scale in checked)
    errors = np.max([table.errors for table in tables], axis=0) + tail
    radius_error = max(table.radius_error for table in tables)
    edges, origin, radius, integral, kinks, strengths = (
        product(matrix, one.reshape(count, int(np.prod(one.shape[1:])))).reshape(wanted.size, *one.shape[1:])
        for one in (edges, origin, radius, integral, kinks, strengths)
    )
    ends = np.exp(matrix @ sizes).tolist()

    def table(n: int) -> PathTable:
        cells = edges[n], origin[n], radius[n], integral[n]
        return PathTable(*cells, errors, radius_error, kinks[n], strengths[n], tables[0].power)

    return [(table(n), depth, size) for n, (depth, size) in enumerate(ends)], tail
