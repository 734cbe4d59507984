"""Derivatives from values at nine equal steps, of order eight, with an estimate of their errors."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from restitution.checks import Array

CENTRAL, UPWARD, DOWNWARD = 0, 1, 2
"""Sides of the point on which the values lie: both, above alone, below alone."""

PLACES = np.array([np.arange(-4.0, 5.0), np.arange(9.0), -np.arange(9.0)])
"""Places of the values in steps from the point, for each side, shape (3, 9)."""

# Norm of the coefficients of the differences of order 8 and 7: noise of the size 1 gives differences of this size.
_ORDERS = {order: math.sqrt(math.comb(2 * order, order)) for order in (7, 8)}


class Slopes(NamedTuple):
    """Derivatives per step: the first, the estimate of its error, and the second."""

    first: Array
    error: Array
    second: Array


def slopes(values: Any, side: Any) -> Slopes:
    """Return derivatives per step at the point from values at `PLACES`.

    Parameters
    ----------
    values : array, shape (9, ...)
        Values at the places of their side.
    side : int or array, shape (...)
        `CENTRAL`, `UPWARD` or `DOWNWARD`.

    Returns
    -------
    Slopes
        The first derivative is that of the polynomial through all values, of order 8. Its error is estimated as twice
        that of values with noise. The size of the noise is that of their differences of order 7 and 8, which a smooth
        function hardly has (J. J. More and S. M. Wild, SIAM J. Sci. Comput. 33 (2011) 1292). They see the terms that
        the polynomial leaves out, too, as these are of higher order.

    Examples
    --------
    >>> first, error, second = slopes(np.exp(0.01 * PLACES[CENTRAL]), CENTRAL)
    >>> print(abs(first - 0.01) < error < 1e-14, round(float(second / 1e-4), 4))
    True 1.0
    """
    y = np.asarray(values, dtype=np.float64)
    sides = np.broadcast_to(np.asarray(side), y.shape[1:])
    with np.errstate(invalid="ignore"):
        first = np.einsum("...k,k...->...", _WEIGHTS[sides], y)
        error = 2.0 * noise(y) * _NORMS[sides] + 4.0 * np.finfo(float).eps * np.abs(y).max(axis=0)
        near = np.where(sides == CENTRAL, y[3] - 2.0 * y[4] + y[5], y[0] - 2.0 * y[1] + y[2])
    return Slopes(first, error, near)


def noise(values: Array) -> Array:
    """Return the size of the noise of nine or more values at equal steps along the first axis."""
    sizes = [np.abs(np.diff(values, order, axis=0)).max(axis=0) / norm for order, norm in _ORDERS.items()]
    return np.maximum(*sizes)


def _weights(places: Array) -> Array:
    """Return the weights of the derivative at zero of the polynomial through values at some places, zero included."""
    others = [places[places != place] for place in places]
    nonzero = places[places != 0.0]
    return np.array([
        -np.sum(1.0 / nonzero) if place == 0.0 else np.prod(-rest[rest != 0.0]) / np.prod(place - rest)
        for place, rest in zip(places, others, strict=True)
    ])  # fmt: skip


_WEIGHTS = np.array([_weights(places) for places in PLACES])
_NORMS = np.sqrt((_WEIGHTS**2).sum(axis=1))
