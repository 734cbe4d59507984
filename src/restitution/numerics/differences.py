"""Derivatives from values at a point and beside it: points, weights, and the errors that nine values show."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from restitution.checks import Array

STEP = 1e-4
"""Usual step of logarithms and logits of a fit: its square is the error of central differences."""

LONG_STEP = 0.02
"""The same for nine values of solves with a tolerance of 1e-11."""

BOTH, UPWARD, DOWNWARD = 0, 1, 2
"""Sides of the point on which nine values lie: both, above alone, below alone; places in `NINE`."""

# Norm of the coefficients of the differences of order 8 and 7: noise of the size 1 gives differences of this size.
_ORDERS = {order: math.sqrt(math.comb(2 * order, order)) for order in (7, 8)}


class Stencil:
    """A point, and points at some places beside it along each of its coordinates.

    The derivative by a coordinate is that of the polynomial through the value at the point and those on its line.
    The first row of points and of values is the point itself; the points of a line follow each other.

    Attributes
    ----------
    places : array, shape (n,)
        Places beside the point, in steps.
    weights, own : array, shape (n,), and float
        Weights of the values there and at the point in the derivative per step.

    Examples
    --------
    >>> at, steps = np.array([1.0, 2.0]), np.array([1e-4, 1e-4])
    >>> points = CENTRAL.points(at, steps)
    >>> print(CENTRAL.slopes(points[:, 0] ** 2 * points[:, 1], steps).round(6))
    [4. 1.]
    """

    def __init__(self, *places: float) -> None:
        self.places = np.array(places, dtype=np.float64)
        *weights, self.own = _weights(np.append(self.places, 0.0)).tolist()
        self.weights = np.array(weights)

    def rows(self, line: int) -> slice:
        """Return the rows of the points on a line, without the point itself."""
        return slice(1 + line * self.places.size, 1 + (line + 1) * self.places.size)

    def points(self, at: Array, steps: Array) -> Array:
        """Return points of shape (..., n_row, q) about one of shape (..., q), without lines where a step is 0."""
        lines = np.kron(np.diag(steps)[steps != 0.0], self.places[:, None])
        return at[..., None, :] + np.vstack([np.zeros(steps.size), lines])

    def slopes(self, values: Array, steps: Array, *, one_sided: bool = False) -> Array:
        """Return derivatives by all coordinates, shape (q, ...), from values of shape (n_row, ...).

        They are 0 where a step is 0. With `one_sided` a value that is not finite is left out where another one on its
        line is finite.
        """
        moving, here = np.flatnonzero(steps), values[0]
        lines = values[1:].reshape(moving.size, self.places.size, *here.shape)
        paces = steps[moving].reshape(-1, *(1,) * here.ndim)
        with np.errstate(invalid="ignore", over="ignore"):
            first = (np.einsum("qk...,k->q...", lines, self.weights) + (self.own * here if self.own else 0.0)) / paces
            for k, place in enumerate(self.places if one_sided else ()):
                first = np.where(np.isfinite(first), first, (lines[:, k] - here) / (place * paces))
        slopes = np.zeros((steps.size, *here.shape))
        slopes[moving] = first
        return slopes


def _weights(places: Array) -> Array:
    """Return the weights of the derivative at zero of the polynomial through values at some places, zero included."""
    others = [places[places != place] for place in places]
    nonzero = places[places != 0.0]
    return np.array([
        -np.sum(1.0 / nonzero) if place == 0.0 else np.prod(-rest[rest != 0.0]) / np.prod(place - rest)
        for place, rest in zip(places, others, strict=True)
    ])  # fmt: skip


FORWARD, CENTRAL = Stencil(1.0), Stencil(1.0, -1.0)
"""Stencils of the steps of a fit, of first order, and of its errors, of second order."""

NINE = (
    Stencil(-4.0, -3.0, -2.0, -1.0, 1.0, 2.0, 3.0, 4.0),
    Stencil(*np.arange(1.0, 9.0)),
    Stencil(*-np.arange(1.0, 9.0)),
)
"""Stencils of order eight, for each side."""

BESIDE = np.array([stencil.places for stencil in NINE])
"""Their places, shape (3, 8)."""

_WEIGHTS = np.array([stencil.weights for stencil in NINE])
_OWN = np.array([stencil.own for stencil in NINE])
_NORMS = np.sqrt((_WEIGHTS**2).sum(axis=1) + _OWN**2)


class Slopes(NamedTuple):
    """Derivatives per step: the first, the estimate of its error, and the second."""

    first: Array
    error: Array
    second: Array


def slopes(here: Any, beside: Any, side: Any) -> Slopes:
    """Return derivatives per step with their errors, from nine values.

    Parameters
    ----------
    here, beside : array, shapes (...) and (8, ...)
        Values at the point, and at the places of `NINE` of their side.
    side : int or array, shape (...)
        `BOTH`, `UPWARD` or `DOWNWARD`.

    Returns
    -------
    Slopes
        The first derivative is that of the polynomial through all values, of order 8. Its error is estimated as twice
        that of values with noise. The size of the noise is that of their differences of order 7 and 8, which a smooth
        function hardly has (J. J. More and S. M. Wild, SIAM J. Sci. Comput. 33 (2011) 1292). They see the terms that
        the polynomial leaves out, too, as these are of higher order.

    Examples
    --------
    >>> first, error, second = slopes(1.0, np.exp(0.01 * BESIDE[BOTH]), BOTH)
    >>> print(abs(first - 0.01) < error < 1e-14, round(float(second / 1e-4), 4))
    True 1.0
    """
    y, value = np.asarray(beside, dtype=np.float64), np.asarray(here, dtype=np.float64)
    sides = np.broadcast_to(np.asarray(side), value.shape)
    line = np.where(sides == BOTH, np.insert(y, 4, value, axis=0), np.insert(y, 0, value, axis=0))
    with np.errstate(invalid="ignore"):
        first = np.einsum("...k,k...->...", _WEIGHTS[sides], y) + _OWN[sides] * value
        error = 2.0 * noise(line) * _NORMS[sides] + 4.0 * np.finfo(float).eps * np.abs(line).max(axis=0)
        near = np.where(sides == BOTH, y[3] - 2.0 * value + y[4], value - 2.0 * y[0] + y[1])
    return Slopes(first, error, near)


def noise(values: Array) -> Array:
    """Return the size of the noise of nine or more values at equal steps along the first axis."""
    sizes = [np.abs(np.diff(values, order, axis=0)).max(axis=0) / norm for order, norm in _ORDERS.items()]
    return np.maximum(*sizes)
