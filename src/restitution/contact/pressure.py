"""Pressure and surface displacement, by the inverse transforms of the method of dimensionality reduction."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.contact.line import LineFunction, evaluate
from restitution.contact.profile import Array, as_array

# Gauss nodes of a cell. A cell spans at most a ratio of two in x, over which the integrand of degree ten has
# its nearest singularity at a Bernstein parameter of 2.8: 2.8^-40 is at rounding level.
_NODES = 20
# Terms x^n, x^2n, ... of a line load at the tip of a power law, and lengths over which they are integrated.
_TIP_TERMS = 4
_PANEL = 2.0
# Numbers held at a time; bounds the memory at some tens of megabytes.
_BLOCK = 500_000
# What the fit of a line load leaves at an edge where it vanishes, and of a slope at x = 0 where it is even.
_NOISE = 1e-9


def pressure(line_load: LineFunction, r: ArrayLike, *, noise: float = _NOISE, tip_exponent: float = 1.0) -> Array:
    """Contact pressure p(r) [Pa] under a line load.

    Parameters
    ----------
    line_load : LineFunction
        Line load q(x) = dF/dx [N/m] of the foundation, whose extent is the contact radius a.
    r : array_like
        Radii [m], >= 0, of any shape.
    noise : float
        Relative error of the line load; an edge load, and a slope on the axis, that are smaller are taken for zero.
    tip_exponent : float
        Exponent n of the profile at its tip, > 0: next to the axis q is a series in x^n. With 1, the exponent of a
        cone, q'(0) may differ from zero.

    Returns
    -------
    array
        Pressure [Pa], of the shape of r; 0 beyond a. Infinite at r = a if q(a) is not zero, and at r = 0
        under a tip as sharp as a cone, n <= 1.

    Notes
    -----
    ``p(r) = -(1/pi) int_r^a q'(x)/sqrt(x^2 - r^2) dx + q(a)/(pi sqrt(a^2 - r^2))`` (Popov and Hess 2015, with
    the edge term of a flat punch written out). The integral over each polynomial cell is taken in closed form
    next to the axis and elsewhere with ``x^2 = r^2 + u^2``, in which the integrand is smooth; both to
    rounding. ``int_0^a p 2 pi r dr`` is the integral of q.

    Examples
    --------
    Hertz: q = E* (d - x^2/R) makes p = (2 E*/(pi R)) sqrt(a^2 - r^2).

    >>> import math
    >>> from restitution.contact.line import line_function
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
    """Normal displacement w(r) [m] of the surface, into the half-space, inside and outside the contact.

    Parameters
    ----------
    line_displacement : LineFunction
        Displacement [m] of the foundation's elements: d - g(x) in contact; zero where an element was never
        touched, and on the way back what has not yet relaxed where it has left contact.
    r : array_like
        Radii [m], >= 0, of any shape.

    Returns
    -------
    array
        Displacement [m], of the shape of r. In contact it is d - f(r).

    Notes
    -----
    ``w(r) = (2/pi) int_0^r u(x)/sqrt(r^2 - x^2) dx`` (Popov and Hess 2015), taken cell by cell over the angle
    with ``x = r sin(theta)``, in which the integrand is smooth.

    Examples
    --------
    A flat punch: u = d under the face, w = (2 d/pi) arcsin(a/r) outside it.

    >>> import math
    >>> from restitution.contact.line import line_function
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
    """Integral of q'/sqrt(x^2 - r^2) over x > r in all cells but the first."""
    edges = load.edges[1:]
    if len(edges) < 2:
        return np.zeros_like(r)
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    above = np.maximum(edges, r[:, None])
    u = np.sqrt((above - r[:, None]) * (above + r[:, None]))
    half = 0.5 * np.diff(u, axis=1)[..., None]
    x = np.hypot(r[:, None, None], u[:, :-1, None] + half * (1.0 + nodes))
    cell = np.broadcast_to(_numbers(1, len(edges))[:, None], x.shape)
    slope = evaluate(load.slope[1:, None, :], load.local(x, cell))
    return np.sum(half * weights * slope / x, axis=(1, 2))


def _first_cell(load: LineFunction, r: Array, least: float) -> Array:
    """Integral of q'/sqrt(x^2 - r^2) over x > r in the first cell, by the recursion of its moments."""
    end = float(load.edges[1])
    # Powers of x/end rather than Chebyshev polynomials: cells that are resolved have coefficients that fall
    # faster than the conversion amplifies rounding.
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
    """The same where q is a series in x^n: with x = r cosh(y), in which its terms are analytic."""
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


def _numbers(start: int, stop: int) -> NDArray[np.intp]:
    return np.arange(start, stop, dtype=np.intp)


def _displacement_block(displacement: LineFunction, r: Array) -> Array:
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    edges = displacement.edges
    below = np.minimum(edges, r[:, None])
    angle = np.arctan2(below, np.sqrt((r[:, None] - below) * (r[:, None] + below)))
    # At r = 0 the whole quarter turn lies in the first cell.
    angle[r == 0.0, 1:] = 0.5 * math.pi
    half = 0.5 * np.diff(angle, axis=1)[..., None]
    x = r[:, None, None] * np.sin(angle[:, :-1, None] + half * (1.0 + nodes))
    cell = np.broadcast_to(_numbers(0, len(edges) - 1)[:, None], x.shape)
    value = evaluate(displacement.coefficients[:, None, :], displacement.local(x, cell))
    return 2.0 / math.pi * np.sum(half * weights * value, axis=(1, 2))
