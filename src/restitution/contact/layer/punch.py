"""Flat punches on a layer: the solutions of the integral equation of the line load for all radii.

Lengths are in units of the thickness, E* = 1. The line load of a flat punch of the radius a at the depth 1 obeys ``w -
M w = 1`` with ``M w = int_0^a (m(x - y) + m(x + y)) w(y) dy``. Its stiffness radius is ``int_0^a w dx = a kappa(a)``.
The resolvent at the edge obeys ``r - M r = m(x - a) + m(x + a)``. A body with the transform g then has the line load
``d w - omega`` with ``omega(a) = g(a) + int_0^a r g dy`` and ``int_0^a omega dx = int_0^a w g dx``.
"""

from __future__ import annotations

import hashlib
import math
from contextlib import suppress
from functools import cache, lru_cache
from importlib.resources import as_file, files
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from restitution.checks import Array
from restitution.contact.geometry import as_array
from restitution.contact.table import product
from restitution.files import user_cache, whole_file
from restitution.numerics.refine import chebyshev, local, to_chebyshev

# Compliance of an elastic layer on a rigid base, in Hankel space and as the kernel of its line load.
#
# Lengths are in units of the thickness h. A pressure p(k) in Hankel space displaces the surface of the layer by
# ``u(k) = (2/(E* k)) K(kh) p(k)``; K = 1 is the half-space. The line load q(x) of the foundation obeys ``q(x) -
# int m(x - y) q(y) dy = E* u(x)`` with ``m(t) = (1/pi) int_0^inf (1 - K(z)) cos(zt) dz``.

# The integrand is below 1e-19 beyond; nodes of a panel, and panels for each period of the fastest cosine.
_LAST, _NODES, _PANELS = 26.0, 16, 1.2
# Ends of the intervals of t on which m(t) has a Chebyshev series. Its singularities are at t = +-2i, +-4i, ...
_ENDS = np.array([0.0, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 80.0])
_DEGREE = 26
# Cells of equal width that replace the series: quick to find, and their degree is 1e-16 there.
_CELLS, _CELL_DEGREE = 8, 9


def missing_compliance(z: Array, poisson_ratio: float | None) -> Array:
    """Return the missing compliance 1 - K(z) [-] of a layer, bonded with a Poisson ratio or frictionless for None.

    Examples
    --------
    A thin layer of the Poisson ratio 0 has K = z/2.

    >>> print(1.0 - missing_compliance(np.array([1e-6]), 0.0) / 1.0)
    [5.e-07]
    """
    fast = np.exp(-2.0 * z)
    if poisson_ratio is None:
        return (
            2.0 * fast * (2.0 * z - np.expm1(-2.0 * z)) / np.where(z > 0.0, 4.0 * z * fast - np.expm1(-4.0 * z), 1.0)
        )
    n = 3.0 - 4.0 * poisson_ratio
    square = 1.0 + n * n + 4.0 * z * z
    return fast * (2.0 * n * fast + square + 4.0 * z) / (n * (1.0 + fast * fast) + square * fast)


class LineKernel:
    """Kernel m(t) of the line load for |t| <= 80, by piecewise polynomials that are exact to rounding.

    Attributes
    ----------
    cells : array
        Coefficients of polynomials over cells of equal width in t, over [-1, 1] in each, highest power first.
    per_unit : float
        Cells for each unit of t.
    """

    def __init__(self, poisson_ratio: float | None) -> None:
        nodes, weights = np.polynomial.legendre.leggauss(_NODES)
        panels = math.ceil(_LAST * _ENDS[-1] * _PANELS / (2.0 * math.pi))
        width = _LAST / panels
        z = (width * (np.arange(panels)[:, None] + 0.5 + 0.5 * nodes)).ravel()
        load = np.tile(0.5 * width / math.pi * weights, panels) * missing_compliance(z, poisson_ratio)
        places, matrix = to_chebyshev(_DEGREE + 1)
        low, high = _ENDS[:-1, None], _ENDS[1:, None]
        t = 0.5 * (low + high) + 0.5 * (high - low) * places
        # Pairwise sums: errors of m grow 1e5-fold on thin incompressible layers.
        values = np.sum(np.cos(t.ravel()[:, None] * z) * load, axis=1).reshape(t.shape)
        self.series: Array = values @ matrix.T
        place, _ = to_chebyshev(_CELL_DEGREE + 1)
        centre = (np.arange(int(_CELLS * _ENDS[-1])) + 0.5)[:, None]
        samples: Any = np.linalg.solve(
            np.vander(place, increasing=True), self.exact((centre + 0.5 * place) / _CELLS).T
        )
        self.cells: Array = np.ascontiguousarray(samples[::-1])
        self.per_unit = float(_CELLS)

    def exact(self, t: Array) -> Array:
        """Return the kernel at t in [0, 80] from its series."""
        piece = np.clip(np.searchsorted(_ENDS, t, side="right") - 1, 0, len(_ENDS) - 2)
        return chebyshev(self.series[piece], local(t, _ENDS[piece], _ENDS[piece + 1]))


PANELS = np.array([0.0, 2.0, 10.0, 40.0])
"""Ends of the ranges of a/h, each with a series of its own."""

# Radii in each range; nodes over the radius. 16 + 6 a/h nodes are enough for every Poisson ratio.
_RADII, _LEAST, _PER_RADIUS = 32, 16, 6
# Newton steps of Gauss nodes; after two the error is 1e-16.
_NEWTON = 4
# Largest coefficients over x, relative to the largest, at the end of a series that are left out: ten times the
# rounding of the linear systems, which differs between processors, so that all of them keep the same number.
_ROUNDING = 1e-14


class Punches(NamedTuple):
    """Series of the flat punches, over the radius in each of the `PANELS`.

    Attributes
    ----------
    stiffness, edge : array, shape (n_panel, n_radius)
        Chebyshev coefficients of ln kappa(a) and ln w(a).
    resolvent, load : tuple of array, shape (n_radius, n_term)
        Chebyshev coefficients of r(x) and w(x) over the radius and over ``2 (x/a)^2 - 1``.
    softness : array, shape (n_panel, n_radius)
        Chebyshev coefficients of -ln kappa over ``ln(1 + a kappa)``.
    ends : array
        Stiffness radii a kappa at the ends of the panels.
    """

    stiffness: Array
    edge: Array
    resolvent: tuple[Array, ...]
    load: tuple[Array, ...]
    softness: Array
    ends: Array

    def kappa(self, radius: Array) -> Array:
        """Return the ratio kappa [-] of the stiffness of a flat punch to that on a half-space."""
        return np.exp(over_panels(self.stiffness, radius))

    def edge_load(self, radius: Array) -> Array:
        """Return the line load w(a) at the edge, without the factor E* d; its square is d(a kappa)/da."""
        return np.exp(over_panels(self.edge, radius))

    def radius(self, stiffness_radius: Array) -> Array:
        """Return the radius a of a flat punch of the stiffness radius a kappa."""
        ends = self.ends
        panel = np.clip(np.searchsorted(ends, stiffness_radius, side="right") - 1, 0, len(PANELS) - 2)
        place = local(np.log1p(stiffness_radius), np.log1p(ends[panel]), np.log1p(ends[panel + 1]))
        return stiffness_radius * np.exp(chebyshev(self.softness[panel], np.clip(place, -1.0, 1.0)))

    def terms(self, radius: float) -> int:
        """Return the number of Chebyshev coefficients over x, apart from rounding, of line loads up to a radius."""
        panel = int(panel_of(np.array(radius)))
        basis = np.polynomial.chebyshev.chebvander(_local(panel, as_array([radius])), _RADII - 1)
        sizes = np.max([np.abs(basis @ part[panel])[0] for part in (self.resolvent, self.load)], axis=0)
        return 1 + int(np.flatnonzero(sizes > _ROUNDING * np.max(sizes))[-1])

    def means(self, radius: Array, moments: Array) -> Array:
        """Return means of r and w over a profile with the moments, shape (n, n_term), at radii, shape (n,)."""
        averages, panels = np.empty((2, radius.size)), panel_of(radius)
        for panel in np.unique(panels):
            rows = panels == panel
            basis = np.polynomial.chebyshev.chebvander(_local(panel, radius[rows]), _RADII - 1)
            for mean, part in zip(averages, (self.resolvent, self.load), strict=True):
                terms = min(part[panel].shape[1], moments.shape[1])
                series = product(basis, part[panel][:, :terms])
                mean[rows] = np.einsum("ij,ij->i", series, moments[rows, :terms])
        return averages


def punches(poisson_ratio: float | None) -> Punches:
    """Solve the flat punches on a bonded layer of a Poisson ratio, or on a frictionless base for None.

    Examples
    --------
    >>> table = punches(0.5)
    >>> print(table.kappa(np.array([0.0, 1.0])).round(8))
    [1.         3.61873585]
    """
    # Numba takes half a second to import.
    from restitution.contact.loops import solve_line_loads

    kernel = LineKernel(poisson_ratio)
    places, transform = to_chebyshev(_RADII)
    stiffness, edge, resolvent, load = [], [], [], []
    for low, high in pairwise(PANELS):
        count = int(_LEAST + _PER_RADIUS * high)
        nodes, weights = _half_gauss(2 * count)
        radii = 0.5 * (low + high) + 0.5 * (high - low) * places
        lines, ends = np.empty((_RADII, 2, count)), np.empty((_RADII, 2))
        space = np.empty((count, count)), np.empty(count)
        solve_line_loads(kernel.cells, kernel.per_unit, radii, nodes, weights, space, lines, ends)
        fit = np.linalg.inv(np.polynomial.chebyshev.chebvander(2.0 * nodes * nodes - 1.0, count - 1))
        series = np.einsum("ij,jkl,ml->ikm", transform, lines, fit, optimize=True)
        stiffness.append(transform @ np.log(ends[:, 0] / radii))
        edge.append(transform @ np.log(ends[:, 1]))
        sizes = np.max(np.abs(series) / np.max(np.abs(series), axis=(0, 2), keepdims=True), axis=(0, 1))
        kept = 1 + int(np.flatnonzero(sizes > _ROUNDING)[-1])
        resolvent.append(series[:, 0, :kept])
        load.append(series[:, 1, :kept])
    table = Punches(np.array(stiffness), np.array(edge), tuple(resolvent), tuple(load), np.empty(0), np.empty(0))
    table = table._replace(ends=PANELS * table.kappa(PANELS))
    return table._replace(softness=_softness(table, places) @ transform.T)


def _softness(table: Punches, place: Array) -> Array:
    """Return values of -ln kappa at places in [-1, 1] between the ends of each panel, by Newton's method."""
    low, high = np.log1p(table.ends[:-1, None]), np.log1p(table.ends[1:, None])
    target = np.expm1(0.5 * (low + high) + 0.5 * (high - low) * place)
    a = np.interp(target, table.ends, PANELS)
    # d(a kappa)/da = w(a)^2, so that each step costs one evaluation of both series.
    for _ in range(60):
        step = (target - a * table.kappa(a)) / table.edge_load(a) ** 2
        a = np.clip(a + step, 0.0, PANELS[-1])
    return np.log(a / target)


def _half_gauss(count: int) -> tuple[Array, Array]:
    """Return positive Gauss nodes of an even count, and their weights by a sum that keeps all digits near the end.

    Errors of weights grow 1e5-fold on thin incompressible layers.
    """
    place = np.arange(count // 2, 0, -1)
    x = np.cos(math.pi * (4.0 * place - 1.0) / (4.0 * count + 2.0)) * (1.0 - (count - 1.0) / (8.0 * count**3))
    total = before = value = x
    for _ in range(_NEWTON):
        before, value = np.ones_like(x), x
        total = 0.5 + 1.5 * x * x
        for k in range(1, count):
            before, value = value, ((2 * k + 1) * x * value - k * before) / (k + 1)
            total = total + (k + 1.5) * value * value
        x = x - value * (x * x - 1.0) / (count * (x * value - before))
    return x, 1.0 / (total - (count + 0.5) * value * value)


def panel_of(radius: Array) -> Any:
    """Return the index of the panel of each radius."""
    return np.clip(np.searchsorted(PANELS, radius, side="right") - 1, 0, len(PANELS) - 2)


def _local(panel: Any, radius: Array) -> Array:
    """Place of a radius in a panel, from -1 to 1."""
    return local(radius, PANELS[panel], PANELS[panel + 1])


def over_panels(series: Array, radius: Array) -> Array:
    """Return series of each panel at radii of any shape."""
    panel = panel_of(radius)
    return chebyshev(series[panel], _local(panel, radius))


# Flat punches on layers: shipped, or computed once and kept in memory and in the user's cache.

# A file has some 70 kB. Older files are removed.
_MOST_FILES = 64
_FIELDS = ("stiffness", "edge", "softness", "ends")

SHIPPED = {None: "frictionless.npz", 0.5: "incompressible.npz"}
"""Files of the package by the Poisson ratio; `validation/flat_punches.py` writes them."""


@lru_cache(maxsize=32)
def stored_punches(poisson_ratio: float | None) -> Punches:
    """Return flat punches on a bonded layer of a Poisson ratio, or on a frictionless base for None.

    Those of a frictionless or a bonded incompressible layer come with the package. Others are read from the user's
    cache. Where there is none, or its content is damaged, they are computed and, if possible, written. The name of a
    file contains the inputs and a hash of the sources.
    """
    if poisson_ratio in SHIPPED:
        with as_file(files("restitution.contact.layer") / "data" / SHIPPED[poisson_ratio]) as path:
            shipped = _read(path)
        if shipped is not None:
            return shipped
    folder = user_cache()
    if folder is None:
        return punches(poisson_ratio)
    name = "frictionless" if poisson_ratio is None else float(poisson_ratio).hex().replace("-", "m")
    path = folder / "layers" / f"{name}-{_source_hash()}.npz"
    table = _read(path)
    if table is None:
        table = punches(poisson_ratio)
        with suppress(OSError):
            path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            write(path, table)
            every = sorted(path.parent.glob("*.npz"), key=lambda file: file.stat().st_mtime, reverse=True)
            for old in every[_MOST_FILES:]:
                old.unlink(missing_ok=True)
    return table


@cache
def _source_hash() -> str:
    digest = hashlib.sha256()
    for source in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def _read(path: Path) -> Punches | None:
    """Return the content of a file; None if there is none or it is damaged, which its check sums show."""
    # Damaged archives raise errors of many kinds.
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
            n = len(file["ends"]) - 1
            resolvent, load = (tuple(file[f"{name}{i}"] for i in range(n)) for name in ("resolvent", "load"))
            return Punches(file["stiffness"], file["edge"], resolvent, load, file["softness"], file["ends"])
    except Exception:
        return None


def write(path: Path, table: Punches) -> None:
    """Write a file in one step; its bytes depend on the numbers only."""
    arrays = {name: getattr(table, name) for name in _FIELDS}
    for name, panels in (("resolvent", table.resolvent), ("load", table.load)):
        arrays |= {f"{name}{i}": panel for i, panel in enumerate(panels)}
    with whole_file(path) as partial, partial.open("wb") as file:
        np.savez(file, **arrays)
