"""A line function on the foundation, such as its line load q(x), as piecewise polynomials on [0, extent]."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.checks import positive
from restitution.contact.profile import Array, as_array

_DEGREE = 10
_MAX_LEVEL = 60
_MAX_CELLS = 4000
# Cells away from x = 0 span at most this ratio, so that 1/sqrt(x^2 - r^2) is smooth over each.
_RATIO = 2.0


@dataclass(frozen=True, eq=False)
class LineFunction:
    """Even function of the foundation coordinate x, piecewise polynomial for |x| <= extent, zero beyond.

    Made by `line_function`.

    Parameters
    ----------
    edges : array
        Ends of the cells [m], shape ``(n_cells + 1,)``, rising from 0 to the extent.
    coefficients : array
        Chebyshev coefficients over each cell, lowest first, shape ``(n_cells, degree + 1)``, in the unit of
        the function.

    Examples
    --------
    >>> load = line_function(lambda x: 1.0 - x**2, extent=1.0)
    >>> round(float(load(0.5)), 12), float(load(2.0)), round(load.integral, 12)
    (0.75, 0.0, 1.333333333333)
    """

    edges: Array
    coefficients: Array

    def __call__(self, x: ArrayLike) -> Array:
        """Value at x [m]."""
        x = np.abs(as_array(x))
        cell = np.clip(np.searchsorted(self.edges, x, side="right") - 1, 0, len(self.edges) - 2)
        value = evaluate(self.coefficients[cell], self.local(x, cell))
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
        return np.clip((2.0 * x - low - high) / (high - low), -1.0, 1.0)


def line_function(
    function: Callable[[Array], ArrayLike],
    extent: float,
    *,
    breakpoints: Iterable[float] = (),
    rtol: float = 1e-11,
) -> LineFunction:
    """Fit piecewise polynomials to an even function of the foundation coordinate x.

    Parameters
    ----------
    function : callable
        Takes x [m], shape (n,), with 0 <= x <= extent, and returns the values, shape (n,); for instance the
        line load q(x) = dF/dx [N/m] of the elements in contact, or the displacement [m] of the foundation.
    extent : float
        End of the function [m], > 0: the contact radius for a line load.
    breakpoints : iterable of float
        Radii [m] where a derivative of the function jumps: the edge of a flat face, the ends of a solver's
        steps, the contact radius within a displacement. Left out, they cost cells. The function itself
        has to be continuous; the fit is.
    rtol : float
        Error to aim at, relative to the largest value. A cell of the share h of the extent may have an error
        larger by h^(-1/2): close to a branch point values are less accurate, integrals are not.

    Raises
    ------
    ValueError
        If extent or rtol is not finite and > 0, the function returns values that are not finite or of another
        shape, or it is so rough that 4000 cells do not resolve it.

    Examples
    --------
    >>> kinked = line_function(lambda x: abs(x - 0.3), extent=1.0, breakpoints=[0.3])
    >>> len(kinked.edges) - 1, round(kinked.integral, 12)
    (3, 0.58)
    """
    extent = float(positive("extent", extent, "m"))
    rtol = float(positive("rtol", rtol))
    pending = _starting_cells(extent, breakpoints)
    largest = 0.0
    done: list[tuple[Array, Array]] = []
    n_cells = 0
    for level in range(_MAX_LEVEL + 1):
        coefficients, peak = _fitted(function, pending)
        largest = max(largest, peak)
        # The last two coefficients stand for what is left out; both, as a parity may hide one.
        tail = np.max(np.abs(coefficients[:, -2:]), axis=1)
        share = np.diff(pending, axis=1)[:, 0] / extent
        too_narrow = np.diff(pending, axis=1)[:, 0] <= 8.0 * np.spacing(pending[:, 1])
        good = (tail * np.sqrt(share) <= rtol * largest) | too_narrow | (level == _MAX_LEVEL)
        done.append((pending[good], coefficients[good]))
        n_cells += int(np.count_nonzero(good))
        left = pending[~good]
        if not len(left):
            break
        if n_cells + 2 * len(left) > _MAX_CELLS:
            raise ValueError(f"function: unresolved by {_MAX_CELLS} cells at rtol = {rtol:g}; name its breakpoints")
        middle = np.mean(left, axis=1)
        pending = np.concatenate([np.column_stack([left[:, 0], middle]), np.column_stack([middle, left[:, 1]])])
    cells = np.concatenate([cell for cell, _ in done])
    order = np.argsort(cells[:, 0])
    edges = np.append(cells[order, 0], extent)
    return LineFunction(edges, np.concatenate([fit for _, fit in done])[order])


def evaluate(coefficients: Array, t: Array) -> Array:
    """Chebyshev series with coefficients of shape (..., n) at local coordinates t, shape (...)."""
    return np.asarray(np.polynomial.chebyshev.chebval(t, np.moveaxis(coefficients, -1, 0), tensor=False), np.float64)


def _starting_cells(extent: float, breakpoints: Iterable[float]) -> Array:
    inner = np.unique(np.array([float(b) for b in breakpoints], dtype=np.float64))
    # Closer to an end than rounding, a break is that end.
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
