"""The stiffness radius over the square root of the depth, a(s) with d = s^2, as a table for the kernel."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from functools import cached_property
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.checks import Array, single_positive
from restitution.contact.geometry import Geometry, Kinks, as_array
from restitution.numerics.refine import refine

_DEGREE = 7
_FIRST_CELLS = 4
# Nodes of a cell, and Gauss nodes and weights for comparison. Nodes at both ends make a(s) continuous and exact at 0.
_NODES = 0.5 - 0.5 * np.cos(np.pi * np.arange(_DEGREE + 1) / _DEGREE)
_GAUSS, _WEIGHTS = (0.5 * part for part in np.polynomial.legendre.leggauss(_DEGREE + 1))
_PLACES = np.append(_NODES, 0.5 + _GAUSS)
# Slopes at the Gauss nodes from values at the nodes.
_PACE: Any = np.arange(1, _DEGREE + 1) * np.vander(0.5 + _GAUSS, _DEGREE, increasing=True)
_SLOPES = _PACE @ np.linalg.inv(np.vander(_NODES, increasing=True))[1:]
# Largest number of halvings of a cell, and of cells apart from those that begin at kinks.
_MOST_HALVINGS = 36
_MAX_CELLS = 4096
# Kinks that change a(s) by less than this share of the tolerance within an eighth of their s are not resolved.
_KINK_SHARE, _KINK_REACH = 0.1, 1.0 / 8.0


class PathTable(NamedTuple):
    """Piecewise polynomials of a(s) and Pi(s) = int_0^s a 2 s' ds', on cells that end at the kinks of the profile.

    Between kinks a(s) is smooth in ``rho = sqrt(s - origin)``, with the kink at the start as origin; before the first
    kink ``rho = s``. In cell i, from ``low = rho(edges[i])`` to ``high = rho(edges[i+1])``, the coordinate is
    ``t = (rho - low)/(high - low)``, and ``a = sum_j radius[i, j] t^j``, ``Pi = sum_j force_integral[i, j] t^j``.

    Attributes
    ----------
    edges : array
        Ends of the cells [m^(1/2)], rising from 0, shape ``(n_cells + 1,)``.
    origin : array
        Origin of rho of each cell [m^(1/2)], shape ``(n_cells,)``; negative where rho = s.
    radius : array
        Coefficients of a [m], shape ``(n_cells, 8)``, lowest power first.
    force_integral : array
        Coefficients of Pi [m^2], shape ``(n_cells, 12)``: the exact integral of the polynomials of a.
    errors : array
        Verified ``int |delta a| dd / Pi`` up to the end of each cell, shape ``(n_cells,)``: a bound of the error of
        forces up to there over the largest elastic one, as they depend on a(s) through its integral over depth alone.
    radius_error : float
        Largest error of the contact radius a, relative to the largest a.
    kinks, strengths : array
        Places s of the kinks [m^(1/2)] and their strengths: ``a = smooth + strength (s - kink)^power`` beyond each.
    power : float
        Half-integer power of the kinks.

    Several tables in one have one more axis in front. Where one has fewer cells or kinks than another, cells without
    a width and kinks without a strength at its end fill its rows.
    """

    edges: Array
    origin: Array
    radius: Array
    force_integral: Array
    errors: Array
    radius_error: Any
    kinks: Array
    strengths: Array
    power: float

    def single(self, n: int) -> PathTable:
        """Return table n of several, without the cells and kinks that fill its rows."""
        edges = self.edges[n]
        cells, kinks = np.diff(edges) > 0.0, self.kinks[n] < edges[-1]
        return PathTable(
            np.append(edges[:-1][cells], edges[-1]), self.origin[n, cells], self.radius[n, cells],
            self.force_integral[n, cells], self.errors[n, cells], float(self.radius_error[n]), self.kinks[n, kinks],
            self.strengths[n, kinks], self.power,
        )  # fmt: skip

    @property
    def several(self) -> PathTable:
        """The table as one of several."""
        return PathTable._make([*(np.asarray(part)[None] for part in self[:-1]), self.power])

    @property
    def error(self) -> float:
        """Error over the whole depth."""
        return float(self.errors[-1])

    @property
    def ends(self) -> tuple[Array, Array]:
        """Coordinates rho at the start and the end of each cell."""
        if not self.kinks.size:
            return self.edges[..., :-1], self.edges[..., 1:]
        return _rho(self.edges[..., :-1], self.origin), _rho(self.edges[..., 1:], self.origin)

    def error_at(self, depth: ArrayLike) -> Array:
        """Return the largest error for depths from that of the cell that contains a depth [m] on."""
        cell = np.searchsorted(self.edges[1:-1], np.sqrt(as_array(depth)), side="right")
        return np.maximum.accumulate(self.errors[::-1])[::-1][cell]


def path_table(
    profile: Geometry, depth_max: float, rtol: float = 1e-12, *, depth_min: float | None = None
) -> PathTable:
    """Return the table of the stiffness radius a(s) over s = sqrt(depth) of a geometry, up to a largest depth.

    Parameters
    ----------
    profile : Geometry
        Geometry with scalar parameters.
    depth_max : float
        Largest indentation depth [m], > 0, of the table.
    rtol : float
        Aim for the `error` of the table. Cells are halved until it is reached; if 36 halvings or 4096 cells are not
        enough, the `error` is larger.
    depth_min : float, optional
        Smallest of the largest depths [m] for which `error_at` is to be within `rtol`; `depth_max` if left out.

    Raises
    ------
    ValueError
        If `depth_max` is not finite and > 0 or exceeds what the profile describes, or parameters are arrays.

    Examples
    --------
    >>> from restitution.contact.profiles import Sphere
    >>> table = path_table(Sphere(radius=0.01), depth_max=0.005)
    >>> table.radius.shape, table.error < 1e-12
    ((4, 8), True)
    """
    depth_max = single_positive("depth_max", depth_max, "m")
    rtol = single_positive("rtol", rtol)
    if depth_max > profile.max_depth:
        raise ValueError(f"depth_max = {depth_max:g} m: must be <= {profile.max_depth:g} m, {profile.end}")
    if np.ndim(profile.stiffness_radius(depth_max)):
        raise ValueError("profile: must have single numbers as parameters, because a path table describes one profile")
    least = depth_max if depth_min is None else min(single_positive("depth_min", depth_min, "m"), depth_max)

    kinks = significant_kinks(profile, depth_max, rtol)
    # Only over the depth itself are the places of kinks known.
    at = (Geometry if kinks.depth.size else type(profile)).curve(profile, depth_max)

    def curve(y: Array) -> tuple[Array, Array]:
        depth, radius = at(np.minimum(y * y, 1.0))
        return depth[None], radius[None]

    least_integral = as_array(profile.force_integral_at_depth(least)).reshape(1)
    table, _ = path_tables(
        curve, kinks._replace(strength=kinks.strength[None]), rtol, least_integral, first_cells(np.sqrt(kinks.depth))
    )
    return table.single(0)


def first_cells(places: Array) -> Array:
    """Return one cell beyond each kink, at places y, and some before the first one.

    The columns are the kink at which the coordinate ``sqrt(y - start)`` begins, -1 where it is y, and the left end and
    the width of the cell in this coordinate.
    """
    end = places[0] if places.size else 1.0
    # Those before the first kink are exact in binary.
    width = np.append(np.full(_FIRST_CELLS, end / _FIRST_CELLS), np.sqrt(np.diff(np.append(places, 1.0))))
    left = np.append(end * np.arange(_FIRST_CELLS) / _FIRST_CELLS, np.zeros(places.size))
    return np.column_stack([np.append(np.full(_FIRST_CELLS, -1.0), places), left, width])


def cell_nodes(cells: Array) -> Array:
    """Return values of y at the nodes of each cell, shape (n_cell, n_node)."""
    start, left, width = cells.T[..., None]
    rho = left + width * _PLACES
    return np.where(start < 0.0, rho, start + rho * rho)


def _halved(cells: Array) -> Array:
    # The width is halved, as the difference of two ends would round.
    low = cells * (1.0, 1.0, 0.5)
    return np.concatenate([low, low + low[:, 2:] * (0.0, 1.0, 0.0)])


def path_tables(
    curve: Callable[[Array], tuple[Array, Array]], kinks: Kinks, rtol: float, least_integral: Array, cells: Array
) -> tuple[PathTable, Array]:
    """Return tables of geometries whose kinks have the same places of a parameter y from 0 to 1, and their cells.

    `curve` gives depths and stiffness radii [m], shape ``(n_geometries, *y.shape)``, at y. Both are smooth over y
    between the kinks, and ``sqrt(depth)`` is nearly proportional to y there. The kinks are at depths in y^2, with
    strengths of shape ``(n_geometries, n_kinks)``, `least_integral` are force integrals at the smallest of the largest
    depths, and `cells` those to begin with, such as the first ones or those of similar tables.
    """
    # Numba takes half a second to import.
    from restitution.contact.loops import fit_cells

    places = np.sqrt(kinks.depth)
    kink_depths, radius = curve(np.append(places, 1.0))
    depth_max, radius_max = kink_depths[:, -1:].copy(), radius[:, -1]
    # The last origin is that of the cells before the first kink.
    origins = np.append(np.sqrt(kink_depths[:, :-1] / depth_max), np.full_like(depth_max, -1.0), axis=1)

    def fit(cells: Array) -> tuple[Array, ...]:
        depth, values = curve(cell_nodes(cells))
        start, left = cells[:, 0], cells[:, 1]
        kink = np.where(start < 0.0, places.size, np.searchsorted(places, start))
        origin = np.ascontiguousarray(origins[:, kink])
        # rho = sqrt(s - origin) makes 1e-8 of a rounding of the depth where a cell starts at a kink.
        at_kink = np.flatnonzero((start >= 0.0) & (left == 0.0))
        depth[:, at_kink, 0] = kink_depths[:, kink[at_kink]]
        ends, sums = np.empty((2, *origin.shape, 3))
        radius, space = np.empty((*origin.shape, _NODES.size)), np.empty(_PLACES.size)
        fit_cells(depth, values, depth_max[:, 0], origin, (_SLOPES, _WEIGHTS), space, (ends, radius, sums))
        gain, missed, largest = np.moveaxis(sums, -1, 0)
        allowed = rtol * np.maximum(gain, least_integral[:, None] / _FIRST_CELLS**2)
        columns = origin, *np.moveaxis(ends, -1, 0), radius, missed, largest
        return np.all(missed <= allowed, axis=0), *(column.swapaxes(0, 1) for column in columns)

    (cells, *columns), _ = refine(cells, fit, _MOST_HALVINGS, _MAX_CELLS + 2 * places.size, _halved)
    order = np.argsort(columns[1][:, 0])
    origin, start, low, width, radius, missed, largest = (
        np.ascontiguousarray(column[order].swapaxes(0, 1)) for column in columns
    )
    integral = _force_integral(depth_max, origin, low, width, radius)
    errors = np.cumsum(missed, axis=1) / np.sum(integral, axis=2)
    roots = np.sqrt(depth_max)
    # d - d_j = (s - s_j) (s + s_j)
    strengths = kinks.strength * (2.0 * roots * origins[:, :-1]) ** kinks.power
    table = PathTable(
        roots * np.append(start, np.ones_like(roots), axis=1), roots * origin, radius, integral, errors,
        np.max(largest, axis=1) / radius_max, roots * origins[:, :-1], strengths, kinks.power,
    )  # fmt: skip
    return table, cells[order]


def joined(tables: list[PathTable]) -> PathTable:
    """Join several tables, each of one or more, that have kinks of one power."""
    cells, kinks = (max(getattr(table, name).shape[1] for table in tables) for name in ("origin", "kinks"))

    def filled(table: PathTable) -> PathTable:
        more, further = ((0, 0), (0, cells - table.origin.shape[1])), ((0, 0), (0, kinks - table.kinks.shape[1]))
        radius, integral = (np.pad(part, (*more, (0, 0))) for part in (table.radius, table.force_integral))
        for part, whole in ((radius, table.radius), (integral, table.force_integral)):
            # The value at the end.
            part[:, whole.shape[1] :, 0] = np.sum(whole[:, -1:], axis=2)
        edges = np.pad(table.edges, more, mode="edge")
        places = np.concatenate([table.kinks, np.repeat(edges[:, -1:], further[1][1], axis=1)], axis=1)
        return PathTable(
            edges, np.pad(table.origin, more, constant_values=-1.0), radius, integral, np.pad(table.errors, more),
            table.radius_error, places, np.pad(table.strengths, further), table.power,
        )  # fmt: skip

    columns = zip(*(filled(table)[:-1] for table in tables), strict=True)
    return PathTable._make([*map(np.concatenate, columns), tables[0].power])


def evaluate(table: PathTable, s: ArrayLike) -> tuple[Array, Array, Array]:
    """Return the stiffness radius a [m], its slope da/ds [m^(1/2)] and force integral Pi [m^2] at s [m^(1/2)].

    Examples
    --------
    >>> from restitution.contact.profiles import Parabola
    >>> table = path_table(Parabola(radius=0.01), depth_max=1e-4)
    >>> a, slope, force_integral = evaluate(table, 0.005)
    >>> round(float(a), 12), round(float(slope), 12), round(float(force_integral), 15)
    (0.0005, 0.1, 8.333333e-09)
    """
    s = as_array(s)
    cell = np.searchsorted(table.edges[1:-1], s, side="right")
    origin = table.origin[cell]
    low, high = (rho[cell] for rho in table.ends)
    rho, width = _rho(s, origin), high - low
    t = (rho - low) / width
    radius = np.moveaxis(table.radius[cell], -1, 0)
    powers = np.arange(1, _DEGREE + 1).reshape((-1,) + (1,) * s.ndim)
    # At a kink the slope over rho vanishes and da/ds is finite.
    steepness = np.where(origin < 0.0, 1.0, 0.5 / np.maximum(rho, 1e-6 * width))
    slope = _polynomial(radius[1:] * powers, t) / width * steepness
    force_integral = _polynomial(np.moveaxis(table.force_integral[cell], -1, 0), t)
    return _polynomial(radius, t), slope, force_integral


def scaled(table: PathTable, length: float, radius: float) -> PathTable:
    """Return the same table with depths in units of `length` [m] and contact radii in units of `radius` [m]."""
    root = length**0.5
    return table._replace(
        edges=table.edges / root,
        origin=table.origin / root,
        radius=table.radius / radius,
        force_integral=table.force_integral / (radius * length),
        kinks=table.kinks / root,
        strengths=table.strengths * (root**table.power / radius),
    )


def _polynomial(coefficients: Array, t: Array) -> Array:
    value = coefficients[-1]
    for coefficient in coefficients[-2::-1]:
        value = value * t + coefficient
    return value


def _rho(s: Array, origin: Array) -> Array:
    """Return the coordinate rho in which a(s) is smooth."""
    return np.where(origin < 0.0, s, np.sqrt(np.maximum(s - origin, 0.0)))


def significant_kinks(profile: Geometry, depth_max: float, rtol: float) -> Kinks:
    """Return kinks that a table of this tolerance resolves, at depths over the largest one."""
    depth, strength, power = profile.kinks
    place = np.sqrt(depth / depth_max)
    # d - d_j = (s - s_j) (s + s_j)
    effect = np.abs(strength) * (2.0 * depth_max * _KINK_REACH * place * place) ** power
    apart = (place > 1e-6) & (place < 1.0 - 1e-6)
    kept = apart & (effect > _KINK_SHARE * rtol * profile.stiffness_radius(depth))
    return Kinks(depth[kept] / depth_max, strength[kept], power)


def _force_integral(depth_max: Array, origin: Array, left: Array, width: Array, radius: Array) -> Array:
    """Return coefficients of Pi in each cell: the integral of a d(s^2) = 2 a s (ds/drho) width dt."""
    straight = origin < 0.0
    # s as a polynomial in t, then ds/drho.
    s = [np.where(straight, left, origin + left**2), np.where(straight, width, 2.0 * left * width),
         np.where(straight, 0.0, width**2)]  # fmt: skip
    pace = [np.where(straight, 1.0, 2.0 * left), np.where(straight, 0.0, 2.0 * width)]
    product = np.zeros((*left.shape, 4))
    for i, x in enumerate(s):
        for j, y in enumerate(pace):
            product[..., i + j] += x * y
    force_integral = np.zeros((*left.shape, _DEGREE + 5))
    for n in range(4):
        force_integral[..., n + 1 : n + 2 + _DEGREE] += radius * product[..., n : n + 1]
    force_integral[..., 1:] *= (2.0 * depth_max * width)[..., None] / np.arange(1, _DEGREE + 5)
    force_integral[:, 1:, 0] = np.cumsum(np.sum(force_integral, axis=-1), axis=1)[:, :-1]
    return force_integral


# Matrix products on one thread.

# Multiplications for which the library starts no threads; they cost more than the product where the cores are used.
_MOST = 200_000


def product(left: Any, right: Any) -> Array:
    """Return the matrix product in blocks of rows that are small enough for one thread."""
    result = np.empty((len(left), right.shape[1]))
    rows = max(1, _MOST // max(1, right.size))
    for start in range(0, len(left), rows):
        np.matmul(left[start : start + rows], right, out=result[start : start + rows])
    return result


# Geometries of one kind, one for each row of a batch of impacts, whose tables are computed together.


class Samples(NamedTuple):
    """Logarithms of depths [m] and force integrals [m^2] of several geometries over a common parameter.

    Attributes
    ----------
    knots : array, shape (n,)
        Values of the parameter at equal distances.
    depth, integral : array, shape (n_geometry, n)
        Logarithms, rising.
    """

    knots: Array
    depth: Array
    integral: Array

    def at(self, x: Array, which: NDArray[np.intp]) -> tuple[Array, Array]:
        """Return the depth [m] and force integral [m^2] of the geometries `which` at values x."""
        if len(self.depth) == 1:
            return np.exp(np.interp(x, self.knots, self.depth[0])), np.exp(np.interp(x, self.knots, self.integral[0]))
        last = self.knots.size - 1
        place = np.clip((x - self.knots[0]) * (last / (self.knots[-1] - self.knots[0])), 0.0, last)
        cell = np.minimum(np.nan_to_num(place).astype(np.intp), last - 1)
        share = place - cell
        depth, integral = (
            np.exp((1.0 - share) * part[which, cell] + share * part[which, cell + 1])
            for part in (self.depth, self.integral)
        )
        return depth, integral


class Tables(NamedTuple):
    """Several tables in one, in units of the depth [m] and the stiffness radius [m] at their ends.

    Attributes
    ----------
    table : PathTable
        The tables.
    depth, radius : array, shape (n_table,)
        The units.
    """

    table: PathTable
    depth: Array
    radius: Array


class Rows(Geometry):
    """Geometries of the rows of a batch; depths and radii are arrays with one value for each row."""

    @property
    @abstractmethod
    def which(self) -> NDArray[np.intp]:
        """Number of the distinct geometry of each row."""

    @abstractmethod
    def raveled(self, shape: tuple[int, ...]) -> Self:
        """Return the rows broadcast to a shape and raveled."""

    @cached_property
    @abstractmethod
    def samples(self) -> Samples:
        """Depths and force integrals, at most a factor of e apart; similar geometries share them."""

    @property
    @abstractmethod
    def sampled(self) -> NDArray[np.intp]:
        """Number of the samples of each distinct geometry."""

    @abstractmethod
    def tables(self, deepest: Array, least: Array, rtol: float) -> Tables:
        """Return tables of the distinct geometries.

        They reach to the depths `deepest` [m] or further; see `restitution.contact.table.path_table` for the
        smallest of the largest depths, `least` [m], and `rtol`.
        """
