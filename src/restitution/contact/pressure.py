"""Line functions of the foundation, and the pressure and displacement of the surface that follow from them.

The inverse transforms of the method of dimensionality reduction.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.checks import Array, single_positive
from restitution.contact.geometry import as_array
from restitution.numerics.refine import chebyshev, local, refine

_DEGREE = 10
_MAX_LEVEL = 60
_MAX_CELLS = 4000
# Cells away from x = 0 span at most this ratio, so that 1/sqrt(x^2 - r^2) is smooth over each.
_RATIO = 2.0
# Gauss nodes of a cell. A cell spans at most a ratio of two in x, over which the integrand of degree ten has its
# nearest singularity at a Bernstein parameter of 2.8: 2.8^-40 is at rounding level.
_NODES = 20
# Terms x^n, x^2n, ... of a line load at the tip of a power law, and lengths over which they are integrated.
_TIP_TERMS = 4
_PANEL = 2.0
# Largest number of values in memory at a time, some tens of megabytes.
_BLOCK = 500_000
# Relative error of the fit of a line load at an edge where it vanishes, and of its slope at x = 0 if that vanishes.
_NOISE = 1e-9


@dataclass(frozen=True, eq=False)
class LineFunction:
    """Even function of the foundation coordinate x, piecewise polynomial for |x| <= extent, zero beyond.

    Examples
    --------
    >>> load = line_function(lambda x: 1.0 - x**2, extent=1.0)
    >>> round(float(load(0.5)), 12), float(load(2.0)), round(load.integral, 12)
    (0.75, 0.0, 1.333333333333)
    """

    edges: Array  # (n_cells + 1,): ends of the cells [m], rising from 0 to the extent
    coefficients: Array  # (n_cells, degree + 1): Chebyshev coefficients over each cell, lowest first

    def __call__(self, x: ArrayLike) -> Array:
        """Return the value at x [m]."""
        x = np.abs(as_array(x))
        cell = np.clip(np.searchsorted(self.edges, x, side="right") - 1, 0, len(self.edges) - 2)
        value = chebyshev(self.coefficients[cell], self.local(x, cell))
        return np.where(x <= self.extent, value, 0.0)[()]

    @property
    def extent(self) -> float:
        """End [m] of the function, beyond which it is zero."""
        return float(self.edges[-1])

    @property
    def edge_value(self) -> float:
        """Limit at the end from inside."""
        return float(np.sum(self.coefficients[-1]))

    @cached_property
    def integral(self) -> float:
        """Integral from -extent to extent; the force [N] of a line load [N/m]."""
        # int_-1^1 T_j = 2/(1 - j^2) for even j
        even = np.arange(0, self.coefficients.shape[1], 2)
        weights = 2.0 / (1.0 - even.astype(np.float64) ** 2)
        return float(np.sum(np.diff(self.edges) * (self.coefficients[:, ::2] @ weights)))

    @cached_property
    def slope(self) -> Array:
        """Chebyshev coefficients of the derivative over each cell, shape ``(n_cells, degree)``."""
        derivative = np.polynomial.chebyshev.chebder(self.coefficients, axis=1)
        return np.asarray(derivative, dtype=np.float64) * (2.0 / np.diff(self.edges))[:, None]

    def local(self, x: Array, cell: NDArray[np.intp]) -> Array:
        """Return the coordinate in [-1, 1] of x within its cell."""
        low, high = self.edges[cell], self.edges[cell + 1]
        return np.clip(local(x, low, high), -1.0, 1.0)


def line_function(
    function: Callable[[Array], ArrayLike],
    extent: float,
    *,
    breakpoints: Iterable[float] = (),
    rtol: float = 1e-11,
    scale: float = 0.0,
) -> LineFunction:
    """Fit piecewise polynomials to an even function of the foundation coordinate x.

    Parameters
    ----------
    function : callable
        Maps x [m] in [0, extent], shape (n,), to values of this shape: the line load q(x) = dF/dx [N/m] of the
        elements in contact, or the displacement [m] of the foundation.
    extent : float
        End of the function [m], > 0: the contact radius for a line load.
    breakpoints : iterable of float
        Places x [m] where a derivative of the function jumps; left out, they cost cells. The function itself has to be
        continuous.
    rtol, scale : float
        Aim for the error over the largest value, or `scale` >= 0 if larger. A cell of the share h of the extent may
        have an error larger by h^(-1/2): close to a branch point values are less accurate, integrals are not.

    Raises
    ------
    ValueError
        If extent or rtol is not finite and > 0, the values are not finite or of another shape, or 4000 cells do not
        resolve the function.

    Examples
    --------
    >>> kinked = line_function(lambda x: abs(x - 0.3), extent=1.0, breakpoints=[0.3])
    >>> len(kinked.edges) - 1, round(kinked.integral, 12)
    (3, 0.58)
    """
    extent, rtol = single_positive("extent", extent, "m"), single_positive("rtol", rtol)
    largest = scale

    def fit(cells: Array) -> tuple[Array, Array]:
        nonlocal largest
        coefficients, peak = _fitted(function, cells)
        largest = max(largest, peak)
        width = np.diff(cells, axis=1)[:, 0]
        # The last two coefficients estimate the rest of the series; one of them may vanish by symmetry.
        tail = np.max(np.abs(coefficients[:, -2:]), axis=1)
        too_narrow = width <= 8.0 * np.spacing(cells[:, 1])
        return (tail * np.sqrt(width / extent) <= rtol * largest) | too_narrow, coefficients

    (cells, coefficients), is_cut = refine(_starting_cells(extent, breakpoints), fit, _MAX_LEVEL, _MAX_CELLS)
    if is_cut:
        raise ValueError(f"function: unresolved by {_MAX_CELLS} cells at rtol = {rtol:g}; name its breakpoints")
    order = np.argsort(cells[:, 0])
    return LineFunction(np.append(cells[order, 0], extent), coefficients[order])


def _starting_cells(extent: float, breakpoints: Iterable[float]) -> Array:
    inner = np.unique(np.array([float(b) for b in breakpoints], dtype=np.float64))
    # A break within rounding of an end is that end.
    inner = inner[(inner > 1e-14 * extent) & (inner < (1.0 - 1e-14) * extent)]
    edges = [0.0]
    for edge in [*inner, extent]:
        while edges[-1] > 0.0 and edge > _RATIO * edges[-1]:
            edges.append(_RATIO * edges[-1])
        edges.append(float(edge))
    return np.column_stack([edges[:-1], edges[1:]])


def _fitted(function: Callable[[Array], ArrayLike], cells: Array) -> tuple[Array, float]:
    # Nodes at both ends of a cell keep the fit continuous: at a jump the pressure would lose force.
    angle = np.pi * np.arange(_DEGREE, -1, -1) / _DEGREE
    x = cells[:, :1] + 0.5 * np.diff(cells, axis=1) * (1.0 + np.cos(angle))
    x[:, 0], x[:, -1] = cells.T
    values = np.asarray(function(x.ravel()), dtype=np.float64)
    if values.shape != (x.size,) or not np.all(np.isfinite(values)):
        raise ValueError(f"function: must return {x.size} finite values for as many x")
    values = values.reshape(x.shape)
    basis = np.cos(np.arange(_DEGREE + 1)[:, None] * angle) * (2.0 / _DEGREE)
    basis[:, [0, -1]] *= 0.5
    basis[[0, -1]] *= 0.5
    return values @ basis.T, float(np.max(np.abs(values)))


def pressure(line_load: LineFunction, r: ArrayLike, *, noise: float = _NOISE, tip_exponent: float = 1.0) -> Array:
    """Return the contact pressure p(r) [Pa] under a line load.

    Parameters
    ----------
    line_load : LineFunction
        Line load q(x) = dF/dx [N/m] of the foundation, whose extent is the contact radius a.
    r : array_like
        Radii [m], >= 0, of any shape.
    noise : float
        Relative error of the line load; an edge load, and a slope on the axis, below it are zero.
    tip_exponent : float
        Exponent n of the profile at its tip, > 0: next to the axis q is a series in x^n. Only for 1, a cone, q'(0) may
        differ from zero.

    Returns
    -------
    array
        Pressure [Pa], of the shape of r; 0 beyond a. Infinite at r = a if q(a) is not zero, and at r = 0 if n <= 1.

    Notes
    -----
    ``p(r) = -(1/pi) int_r^a q'(x)/sqrt(x^2 - r^2) dx + q(a)/(pi sqrt(a^2 - r^2))`` (Popov and Hess 2015; the last term
    is that of a flat punch), integrated to rounding: in closed form next to the axis, elsewhere over u with ``x^2 =
    r^2 + u^2``, where the integrand is smooth.

    Examples
    --------
    Hertz: q = E* (d - x^2/R) makes p = (2 E*/(pi R)) sqrt(a^2 - r^2).

    >>> import math
    >>> load = line_function(lambda x: 1.0 - x**2, extent=1.0)
    >>> round(float(pressure(load, 0.6)) * math.pi / 2.0, 12)
    0.8
    """
    r = _radii(r)
    flat = r.ravel()
    a = line_load.extent
    scale = float(np.max(np.abs(line_load.coefficients[:, 0])))
    result = np.zeros(flat.size)
    inside = np.flatnonzero(flat < a)
    if tip_exponent % 1.0 == 0.0:
        first_cell = partial(_first_cell, least=noise * scale if tip_exponent == 1.0 else np.inf)
    else:
        first_cell = partial(_first_cell_of_power, exponent=tip_exponent)
    rows = max(1, _BLOCK // (_NODES * len(line_load.coefficients)))
    for start in range(0, inside.size, rows):
        part = inside[start : start + rows]
        integral = _outer_cells(line_load, flat[part]) + first_cell(line_load, flat[part])
        result[part] = -integral / math.pi
    if abs(line_load.edge_value) > noise * scale:
        here = flat[inside]
        result[inside] += line_load.edge_value / (math.pi * np.sqrt((a - here) * (a + here)))
        result[flat == a] = np.copysign(np.inf, line_load.edge_value)
    return result.reshape(r.shape)[()]


def surface_displacement(line_displacement: LineFunction, r: ArrayLike) -> Array:
    """Return the normal displacement w(r) [m] of the surface, into the half-space, inside and outside the contact.

    Parameters
    ----------
    line_displacement : LineFunction
        Displacement [m] of the foundation's elements: d - g(x) in contact, zero where an element was never touched,
        and the part that has not yet relaxed where an element has left contact.
    r : array_like
        Radii [m], >= 0, of any shape.

    Returns
    -------
    array
        Displacement [m], of the shape of r. In contact it is d - f(r).

    Notes
    -----
    ``w(r) = (2/pi) int_0^r u(x)/sqrt(r^2 - x^2) dx`` (Popov and Hess 2015), integrated over the angle theta with
    ``x = r sin(theta)``, where the integrand is smooth.

    Examples
    --------
    A flat punch: u = d under the face, w = (2 d/pi) arcsin(a/r) outside it.

    >>> import math
    >>> punch = line_function(lambda x: 0.0 * x + 1.0, extent=1.0)
    >>> inside, outside = surface_displacement(punch, [0.5, 2.0])
    >>> round(float(inside), 12), round(float(outside), 12)
    (1.0, 0.333333333333)
    """
    r = _radii(r)
    flat = r.ravel()
    result = np.zeros(flat.size)
    rows = max(1, _BLOCK // (_NODES * len(line_displacement.coefficients)))
    for start in range(0, flat.size, rows):
        result[start : start + rows] = _displacement_block(line_displacement, flat[start : start + rows])
    return result.reshape(r.shape)[()]


def _radii(r: ArrayLike) -> Array:
    radii = as_array(r)
    if not np.all(radii >= 0.0):
        raise ValueError(f"r = {float(np.min(radii)):g} m: must be >= 0")
    return radii


def _outer_cells(load: LineFunction, r: Array) -> Array:
    """Return the integral of q'/sqrt(x^2 - r^2) over x > r in all cells but the first."""
    edges = load.edges[1:]
    if len(edges) < 2:
        return np.zeros_like(r)
    above = np.maximum(edges, r[:, None])
    u = np.sqrt((above - r[:, None]) * (above + r[:, None]))
    return _sum(load, load.slope, u, lambda u: np.hypot(r[:, None, None], u), over_x=True)


def _sum(
    function: LineFunction, series: Array, ends: Array, place: Callable[[Array], Array], *, over_x: bool = False
) -> Array:
    """Return the integral of a series, perhaps over x, over the last cells, by Gauss nodes between `ends`."""
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    half = 0.5 * np.diff(ends, axis=1)[..., None]
    x = place(ends[:, :-1, None] + half * (1.0 + nodes))
    n, first = len(series), len(series) - half.shape[1]
    cell = np.broadcast_to(np.arange(first, n, dtype=np.intp)[:, None], x.shape)
    values = half * weights * chebyshev(series[first:, None, :], function.local(x, cell))
    return np.sum(values / x if over_x else values, axis=(1, 2))


def _first_cell(load: LineFunction, r: Array, least: float) -> Array:
    """Return the integral of q'/sqrt(x^2 - r^2) over x > r in the first cell, by the recursion of its moments."""
    end = float(load.edges[1])
    # Powers of x/end: Chebyshev coefficients of a resolved cell fall faster than the conversion amplifies rounding.
    powers = np.polynomial.Chebyshev(load.slope[0] * end, domain=[0.0, 1.0]).convert(
        kind=np.polynomial.Polynomial, domain=[-1.0, 1.0], window=[-1.0, 1.0]
    )
    coefficients = np.zeros(load.slope.shape[1])
    coefficients[: len(powers.coef)] = powers.coef
    if abs(coefficients[0]) <= least:
        coefficients[0] = 0.0
    ratio = np.minimum(r / end, 1.0)
    root = np.sqrt(np.maximum((end - r) * (end + r), 0.0)) / end
    # M_n = int_ratio^1 t^n/sqrt(t^2 - ratio^2) dt; n M_n = root + (n - 1) ratio^2 M_(n-2)
    on_axis = ratio == 0.0
    before = np.where(on_axis, 0.0, np.log((1.0 + root) / np.where(on_axis, 1.0, ratio)))
    moment = root
    total = coefficients[0] * before + coefficients[1] * moment
    for n in range(2, len(coefficients)):
        before, moment = moment, (root + (n - 1) * ratio * ratio * before) / n
        total = total + coefficients[n] * moment
    if coefficients[0]:
        total[on_axis] = np.copysign(np.inf, coefficients[0])
    return total / end


def _first_cell_of_power(load: LineFunction, r: Array, exponent: float) -> Array:
    """Return the same integral for a series q in x^n, over y with x = r cosh(y), in which the terms are analytic."""
    end = float(load.edges[1])
    t = 0.5 - 0.5 * np.cos(np.pi * np.arange(1, load.coefficients.shape[1]) / (load.coefficients.shape[1] - 1))
    powers = exponent * np.arange(1, _TIP_TERMS + 1)
    values = load(end * t) - load(0.0)
    terms = np.linalg.lstsq(t[:, None] ** powers, values, rcond=None)[0] * powers
    on_axis = np.sum(terms / (powers - 1.0)) if exponent > 1.0 else np.copysign(np.inf, terms[0])
    total = np.where(r == 0.0, on_axis, 0.0)
    near = np.flatnonzero((r > 0.0) & (r < end))
    if near.size:
        ratio = r[near] / end
        reach = np.arccosh(1.0 / ratio)
        panels = math.ceil(float(np.max(reach)) / _PANEL)
        nodes, weights = np.polynomial.legendre.leggauss(_NODES)
        y = reach[:, None] * ((np.arange(panels)[:, None] + 0.5 + 0.5 * nodes).ravel() / panels)
        logarithm = np.log(ratio)[:, None] + np.logaddexp(y, -y) - math.log(2.0)
        integrand = sum(term * np.exp((power - 1.0) * logarithm) for term, power in zip(terms, powers, strict=True))
        total[near] = integrand @ np.tile(weights, panels) * reach * (0.5 / panels)
    return total / end


def _displacement_block(displacement: LineFunction, r: Array) -> Array:
    below = np.minimum(displacement.edges, r[:, None])
    angle = np.arctan2(below, np.sqrt((r[:, None] - below) * (r[:, None] + below)))
    # At r = 0 the whole quarter turn lies in the first cell.
    angle[r == 0.0, 1:] = 0.5 * math.pi
    turned = _sum(displacement, displacement.coefficients, angle, lambda angle: r[:, None, None] * np.sin(angle))
    return 2.0 / math.pi * turned
