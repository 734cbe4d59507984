"""Contacts of a profile, and their depths on layers of any thickness above a smallest one.

What depends on the profile alone is computed once: the moments of `restitution.contact.layer.depths`, and their
sums with the flat punches, which leave a series over a/h for each contact.
"""

from __future__ import annotations

import math
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np

from restitution.checks import Array
from restitution.contact.geometry import Kinks, as_array
from restitution.contact.layer.depths import Averages
from restitution.contact.layer.punch import PANELS, panel_of, stored_punches
from restitution.contact.profiles import Profile
from restitution.contact.table import (
    PathTable,
    Tables,
    cell_nodes,
    first_cells,
    path_tables,
    product,
    significant_kinks,
)

# Samples of the depth: number, distance in the logarithm, and the logarithm of the first one.
_SAMPLES, _APART, _FIRST = 40, 0.5, -300.0
# Contacts of layers whose tables are computed together, and contacts that are kept, which limit the memory.
_BLOCK, _KEPT = 500_000, 10_000
# Nodes of the interpolation over ln h, those for each unit of it over ln(a/h), and largest of its last coefficients
# over the tolerance of the tables, which are as noisy.
_NODES, _RATES, _TAIL = 12, ([-0.5, 2.0, 3.7], [4.3, 7.6, 8.5]), 3.0
# Relative step of the parameter for the slope of the depth at kinks.
_STEP = 1e-4
# Thicknesses over the smallest one whose cells are those of all others to begin with.
_TYPICAL = np.array([1.0, 4.0, 64.0])


class Contact(NamedTuple):
    """Contacts [SI]: radius a, depth D on a half-space and ``G = a D - Pi_0``, each of shape (n,), and moments of g.

    The mean of r is a series over a/h in each panel, shape (n_panel, n_radius, n).
    """

    radius: Array
    depth: Array
    gap: Array
    moments: Array
    resolvent: Array


class _Start(NamedTuple):
    """Kinks at places y, with their strengths on a half-space, cells to begin with, and known contacts by their y."""

    strength: Array
    power: float
    places: Array
    cells: Array
    stored: dict[bytes, Contact]

    @property
    def ends(self) -> Array:
        """Values of y at the kinks and at the end."""
        return np.append(self.places, 1.0)

    @property
    def around(self) -> Array:
        """Values of y on both sides of each kink."""
        return np.concatenate([self.places * (1.0 - _STEP), self.places * (1.0 + _STEP)])


class Contacts:
    """Contacts of a profile up to a largest radius [m] on layers of at least a thickness [m]."""

    def __init__(self, profile: Profile, poisson_ratio: float | None, thinnest: float, end: float) -> None:
        self.profile, self.punches, self.end = profile, stored_punches(poisson_ratio), end
        self.deepest = float(profile.transform(end))
        self._unit, self._face = thinnest, float(profile.contact_radius(0.0))
        self._reach = math.sqrt((end - self._face) * (end + self._face))
        self._known: dict[float, _Start] = {}
        # Panels of a/h in which the contacts lie.
        self._count = int(panel_of(np.array(end / thinnest))) + 1

    @cached_property
    def _averages(self) -> Averages:
        """Means over the profile; the cells of their quadrature are fine enough for the thinnest layer."""
        unit, profile, end = self._unit, self.profile, self.end
        face, joints = self._face, profile.joints
        inside = joints[(joints > face) & (joints < end)] / unit
        most = profile.max_contact_radius
        return Averages(
            self.punches, lambda x: profile.transform(np.minimum(x * unit, most)), face / unit, inside, end / unit
        )

    @cached_property
    def sampled(self) -> tuple[Array, Contact, Array]:
        """Logarithms of depths on a half-space, the last contacts there, and logarithms of all force integrals."""
        last = math.log(self.deepest)
        count = max(_SAMPLES, math.ceil((last - _FIRST) / _APART))
        knots = last - _APART * np.arange(count)[::-1]
        # Rounding must not exceed the end of the profile.
        depth = np.minimum(np.exp(knots), self.deepest)
        integral = np.log(np.maximum(self.profile.force_integral_at_depth(depth), 1e-300))
        return as_array(knots), self.at(depth[-_SAMPLES:]), integral

    def at(self, depth: Array) -> Contact:
        """Return contacts at depths [m] on a half-space, shape (n,)."""
        return self._contact(np.minimum(self.profile.contact_radius(depth), self.end), depth)

    def _contact(self, radius: Array, depth: Array) -> Contact:
        most = np.minimum(radius / self._unit, PANELS[-1])
        moments = np.zeros((radius.size, self.punches.terms(float(np.max(most)))))
        # Small contacts need few terms.
        sizes = np.ceil(0.5 * np.log2(np.maximum(most, 1.0)))
        for size in np.unique(sizes):
            rows = np.flatnonzero(sizes == size)
            terms = self.punches.terms(float(np.max(most[rows])))
            moments[rows, :terms] = self._averages.moments(radius[rows] / self._unit, terms)
        gap = radius * depth - self.profile.force_integral(radius)
        return Contact(radius, depth, gap, moments, series(self.punches.resolvent[: self._count], moments))

    def on(self, thickness: Array, contact: Contact, loads: bool = False) -> list[Array]:
        """Return the depth, stiffness radius and, with `loads`, force integral [SI] on layers, shape (n_layer, n)."""
        kappa, edge, sigma = self._means(thickness, contact.radius, contact.resolvent)
        # d = (D + sigma G/h)/w(a), a kappa, and Pi = d a kappa - tau G; see `restitution.contact.layer.depths`.
        depth = (contact.depth + sigma * (contact.gap / thickness[:, None])) / np.exp(edge)
        radius = contact.radius * np.exp(kappa)
        if not loads:
            return [depth, radius]
        load = series(self.punches.load[: self._count], contact.moments)
        tau = self._means(thickness, contact.radius, load)[2]
        return [depth, radius, depth * radius - tau * contact.gap]

    def own_depth(self, thickness: Array, contact: Contact) -> Array:
        """Return the depth [m] of each contact, each on its own layer, shape (n,)."""
        radius = contact.radius / thickness
        sigma, _ = self.punches.means(radius, contact.moments)
        return (contact.depth + sigma * contact.gap / thickness) / self.punches.edge_load(radius)

    def _means(self, thickness: Array, radius: Array, series: Array) -> Array:
        # Numba takes half a second to import.
        from restitution.contact.loops import MOST, on_layers

        means = np.empty((3, thickness.size, radius.size))
        panels = PANELS[: self._count + 1]
        on_layers(
            thickness, radius, panels, self.punches.stiffness, self.punches.edge, series, np.empty((6, MOST)), means
        )
        return means

    def tables(self, thickness: Array, least: Array, rtol: float) -> list[Tables]:
        """Return tables of rising thicknesses up to the largest radius; `least` is as for `path_tables`."""
        start = self._start(rtol)
        interpolated = self._interpolated(thickness, start, least, rtol)
        if interpolated is not None:
            return [interpolated]
        block = max(1, _BLOCK // cell_nodes(start.cells).size)
        parts = (slice(first, first + block) for first in range(0, thickness.size, block))
        return [self._tables(thickness[part], start, least[part], rtol)[0] for part in parts]

    def _interpolated(self, thickness: Array, start: _Start, least: Array, rtol: float) -> Tables | None:
        """Return tables that are interpolated over ln h; None where this is more work or not accurate."""
        logs = np.log(thickness)
        # Chebyshev nodes over ln h: so many that the series over them has the tolerance of the tables, as a rule.
        half = 0.5 * (logs[-1] - logs[0])
        count = math.ceil(_NODES + np.interp(math.log(self.end) - logs[0], *_RATES) * 2.0 * half)
        if thickness.size <= count:
            return None
        x = -np.cos(np.pi * (np.arange(count) + 0.5) / count)
        places = logs[0] + half * (1.0 + x)
        lowest = np.exp(np.interp(places, logs, np.log(least)))
        # Tables that are computed together have the same cells, so that all coefficients are smooth functions of ln h.
        nodes, _ = self._tables(np.exp(places), start, lowest, rtol)
        between, tail = _between(nodes.table, x, np.clip((logs - logs[0]) / half - 1.0, -1.0, 1.0))
        return Tables(between, *self._ends(thickness, start)) if tail <= _TAIL * rtol else None

    def _start(self, rtol: float) -> _Start:
        """Return what the tables of all layers have in common."""
        if rtol not in self._known:
            kinks = significant_kinks(self.profile, self.deepest, rtol)
            radius = self.profile.contact_radius(kinks.depth * self.deepest)
            places = np.sqrt((radius - self._face) * (radius + self._face)) / self._reach
            start = _Start(kinks.strength, kinks.power, places, first_cells(places), {})
            typical = max(self._unit, self.end / PANELS[-1]) * _TYPICAL
            _, cells = self._tables(typical, start, np.zeros(typical.size), rtol)
            often = (start.ends, start.around, cell_nodes(cells))
            series = start._replace(cells=cells, stored={y.tobytes(): self._at_place(y) for y in often if y.size})
            # More contacts would take too much memory.
            if cell_nodes(cells).size > _KEPT:
                return series
            self._known[rtol] = series
        return self._known[rtol]

    def _at_place(self, y: Array) -> Contact:
        """Return contacts at shares y of ``sqrt(a^2 - b^2)``, in which g is smooth at the radius b of a flat face."""
        radius = np.minimum(np.hypot(self._face, self._reach * y.ravel()), self.end)
        return self._contact(radius, self.profile.transform(radius))

    def _known_at(self, start: _Start, y: Array) -> Contact:
        contact = start.stored.get(y.tobytes())
        return self._at_place(y) if contact is None else contact

    def _ends(self, thickness: Array, start: _Start) -> Array:
        """Return the depth and stiffness radius [m] at the end of the table of each layer."""
        return np.array(self.on(thickness, self._known_at(start, start.ends)))[:, :, -1]

    def _tables(self, thickness: Array, start: _Start, least: Array, rtol: float) -> tuple[Tables, Array]:
        """Return tables of layers, and their cells."""
        depth_max, radius_max = self._ends(thickness, start)
        units = np.stack([depth_max, radius_max])[..., None]

        def curve(y: Array) -> tuple[Array, Array]:
            depth, radius = np.array(self.on(thickness, self._known_at(start, y))) / units
            return depth.reshape(-1, *y.shape), radius.reshape(-1, *y.shape)

        strengths = np.zeros((thickness.size, start.places.size))
        # a kappa = smooth + w strength (d - d_j)^p/(dd/dD)^(p + 1), with dd/dD by differences around the kink.
        if start.places.size:
            # As for a single layer.
            around = self._known_at(start, start.around)
            below, above = np.split(self.on(thickness, around)[0] / units[0], 2, axis=1)
            radius, rise = np.split(around.radius, 2)[1], np.subtract(*np.split(around.depth, 2))
            slope = (below - above) / rise
            edge = self.punches.edge_load(radius / thickness[:, None])
            strengths = edge * start.strength / (units[0] * units[1] * slope ** (start.power + 1.0))
        kinks = Kinks(start.places**2, strengths, start.power)
        table, cells = path_tables(curve, kinks, rtol, least / (depth_max * radius_max), start.cells)
        return Tables(table, depth_max, radius_max), cells


def series(panels: tuple[Array, ...], moments: Array) -> Array:
    """Return series of means over a/h in some panels from the moments of contacts, shape (n_panel, n_term, n)."""
    chebyshev = np.empty((len(panels), len(panels[0]), len(moments)))
    for coefficients, panel in zip(chebyshev, panels, strict=True):
        terms = min(panel.shape[1], moments.shape[1])
        coefficients[:] = product(panel[:, :terms], moments[:, :terms].T)
    return chebyshev


def _between(table: PathTable, x: Array, places: Array) -> tuple[PathTable, float]:
    """Return tables at places in [-1, 1] from those at the Chebyshev nodes x, and the tail of their series."""
    last = x.size - 1
    to_series: Any = np.linalg.inv(np.polynomial.chebyshev.chebvander(x, last))
    matrix = np.polynomial.chebyshev.chebvander(places, last) @ to_series
    # Coefficients of polynomials have errors that their values have not.
    powers = np.linspace(0.0, 1.0, 5) ** np.arange(table.force_integral.shape[2])[:, None]
    # Forces depend on the radius through its integral, in which narrow cells hardly count.
    radii = 0.1 * (table.radius @ powers[: table.radius.shape[2]])
    checked = table.edges, radii, table.force_integral @ powers
    tail = max(float(np.max(np.abs(np.tensordot(to_series[-2:], part, axes=1)))) for part in checked)
    edges, origin, radius, integral, kinks, strengths = (
        product(matrix, part.reshape(x.size, -1)).reshape(places.size, *part.shape[1:])
        for part in (*table[:4], table.kinks, table.strengths)
    )
    # Where a cell starts at a kink, rho = sqrt(s - origin) makes 1e-8 of a rounding of its start.
    starts = np.all(table.origin == table.edges[:, :-1], axis=0)
    origin[:, starts] = edges[:, :-1][:, starts]
    errors, error = (np.repeat(np.max(part, axis=0)[None], places.size, axis=0) for part in table[4:6])
    return PathTable(edges, origin, radius, integral, errors + tail, error, kinks, strengths, table.power), tail


@lru_cache(maxsize=32)
def contacts(profile: Profile, poisson_ratio: float | None, thinnest: float, end: float) -> Contacts:
    """Return the contacts of a profile, which are computed once."""
    return Contacts(profile, poisson_ratio, thinnest, end)
