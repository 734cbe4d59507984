"""Richardson's extrapolation of numbers whose error falls with powers of the number of elements."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from restitution.checks import Array

# The error of an extrapolated number is its last change, or this share of the change before: a change may be small by
# chance. By comparison of 150 random oblique impacts with finer marches.
_BEFORE = 0.25


class Richardson:
    """Extrapolation of numbers of second order, each of them from twice as many elements as the one before.

    Examples
    --------
    >>> series = Richardson()
    >>> for count in (10, 20, 40):
    ...     value, error = series.add(2.0 + 3.0 / count**2)
    >>> print(float(value), float(error) < 1e-12)
    2.0 True
    """

    def __init__(self) -> None:
        self._last: Array | None = None
        self._now: Array | None = None
        self._change: Array | float = 0.0

    def add(self, values: ArrayLike) -> tuple[Array, Array]:
        """Take the next numbers; return the extrapolated ones and their errors, infinite for the first two."""
        fine, last, now = np.asarray(values, dtype=np.float64), self._last, self._now
        self._last = fine
        if last is None:
            return fine, np.full_like(fine, np.inf)
        self._now = after = (4.0 * fine - last) / 3.0
        if now is None:
            return after, np.full_like(fine, np.inf)
        moved = np.abs(after - now)
        error, self._change = np.maximum(moved, _BEFORE * self._change), moved
        return after, error


# Orders of the terms of the error that are extrapolated away.
_ORDERS = ((2,), (2, 3), (2, 3, 4))
# The error is twice the largest of the last three changes, where each counts half of the next one: by comparison of
# 380 random oblique impacts with finer marches.
_SHARE, _MARGIN = 0.5, 2.0


class Extrapolation:
    """Extrapolation of numbers from more and more elements, whose error is a series of powers from the second on.

    One, two or three terms are taken away, whichever has the smallest error of the first number. Terms beyond the
    first help where the numbers are smooth, and harm where switches within an element make their errors jump.

    Examples
    --------
    >>> series = Extrapolation()
    >>> for count in (10, 20, 40, 80, 120):
    ...     value, error = series.add(count, [2.0 + 3.0 / count**2 + 4.0 / count**3])
    >>> print(round(float(value[0]), 12), float(error[0]) < 1e-12)
    2.0 True
    """

    def __init__(self) -> None:
        self._counts: list[int] = []
        self._values: list[Array] = []
        # Of each order the last numbers and their last three changes, in reverse order.
        self._last: list[Array] = []
        self._changes: list[list[Array]] = [[] for _ in _ORDERS]

    def add(self, count: int, values: ArrayLike) -> tuple[Array, Array]:
        """Take the numbers from `count` elements; return the extrapolated ones and their errors, infinite at first."""
        fine = np.asarray(values, dtype=np.float64)
        self._counts.append(count)
        self._values.append(fine)
        best, least = fine, np.full_like(fine, np.inf)
        for n, orders in enumerate(_ORDERS[: len(self._values) - 1]):
            need = len(orders) + 1
            limit = _weights(tuple(self._counts[-need:]), orders) @ np.array(self._values[-need:])
            if n == len(self._last):
                self._last.append(limit)
            else:
                self._changes[n] = [np.abs(limit - self._last[n]), *self._changes[n][:2]]
                self._last[n] = limit
            error = self._error(n)
            if error is None and np.isinf(least[0]):
                best = limit
            elif error is not None and error[0] <= least[0]:
                best, least = limit, error
        return best, least

    def _error(self, n: int) -> Array | None:
        """Return the error of the numbers of one order: twice the largest change, older ones counting less."""
        changes = self._changes[n]
        if len(changes) < 2:
            return None
        error = changes[0]
        for power, change in enumerate(changes[1:], 1):
            error = np.maximum(error, _SHARE**power * change)
        return _MARGIN * error


@cache
def _weights(counts: tuple[int, ...], orders: tuple[int, ...]) -> Array:
    """Return the weights of numbers in the one without terms of these orders."""
    steps = counts[-1] / np.array(counts, dtype=np.float64)
    return np.linalg.inv(np.column_stack([steps**order for order in (0, *orders)]))[0]
