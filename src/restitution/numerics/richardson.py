"""Richardson's extrapolation of numbers whose error falls with powers of the number of elements."""

from __future__ import annotations

import math
from collections.abc import Iterable
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
# Changes are at least of this order, and as many count: one may be small by chance. The first error is from fewer.
_FALL, _KEPT, _FEWEST = 2.0, 3, 2


class Extrapolation:
    """Extrapolation of numbers from more and more elements, whose error is a series of powers from the second on.

    One, two or three terms are taken away, whichever has the smallest error of the first number. Terms beyond the
    first help where the numbers are smooth, and harm where switches within an element make their errors jump.

    A change of extrapolated numbers is the error of those before it, which falls with the square of the number of
    elements at least. The error is `margin` times what is left of the last three changes, the largest one.

    Parameters
    ----------
    margin : float
        Factor of the errors.

    Examples
    --------
    >>> series = Extrapolation()
    >>> for count in (10, 20, 40, 80, 120):
    ...     value, error = series.add(count, [2.0 + 3.0 / count**2 + 4.0 / count**3])
    >>> print(round(value[0], 12), error[0] < 1e-12)
    2.0 True
    """

    def __init__(self, margin: float = 3.0) -> None:
        self._margin = margin
        self._counts: tuple[int, ...] = ()
        self._values: list[ArrayLike] = []

    def add(self, count: int, values: ArrayLike) -> tuple[list[float], list[float]]:
        """Take the numbers from `count` elements; return the extrapolated ones and their errors, infinite at first."""
        return self.extend((count,), [values])

    def extend(self, counts: tuple[int, ...], values: Iterable[ArrayLike]) -> tuple[list[float], list[float]]:
        """Take the numbers from several counts of elements, as if one by one; return the last answer."""
        self._counts += counts
        self._values.extend(values)
        used = self._counts[-len(_ORDERS) - _KEPT - 1 :]
        found = _weights(used) @ np.array(self._values[-len(used) :], dtype=np.float64)
        many = len(found) // (1 + _KEPT)
        limits, changes = found[:many], np.abs(found[many:]).reshape(_KEPT, many, -1)
        errors = (self._margin * changes.max(axis=0)).tolist()
        # An order has a number from its second count on, and an error from two changes on.
        best, least = many - 1, [math.inf] * found.shape[1]
        for n in range(min(len(used) - 1 - _FEWEST, len(_ORDERS))):
            if errors[n][0] <= least[0]:
                best, least = n, errors[n]
        return limits[best].tolist(), least


@cache
def _weights(counts: tuple[int, ...]) -> Array:
    """Return the weights of numbers in those without the terms of each order, and in what is left of their changes.

    The first rows belong to the numbers, one for each order that is known, the next ones to the last change, then to
    those before it. A single number stands for itself.
    """
    many = len(counts)
    known = max(min(many - 1, len(_ORDERS)), 1)
    limits = [_limits(counts[: max(many - back, 0)], (known, many)) for back in range(_KEPT + 1)]
    rows = [limits[0]]
    for back in range(1, _KEPT + 1):
        # Of orders that have both numbers.
        both = np.arange(known)[:, None] < many - back - 1
        fall = (counts[-1 - back] / counts[-1]) ** _FALL if many > back else 0.0
        rows.append(np.where(both, fall * (limits[back - 1] - limits[back]), 0.0))
    return np.vstack(rows)


def _limits(counts: tuple[int, ...], shape: tuple[int, int]) -> Array:
    """Return the weights of numbers in those without the terms of each order, which use the last of the counts."""
    rows, many = np.zeros(shape), len(counts)
    if many == 1:
        rows[0, 0] = 1.0
    for row, orders in zip(rows[: max(many - 1, 0)], _ORDERS, strict=False):
        used = counts[-1] / np.array(counts[many - len(orders) - 1 :], dtype=np.float64)
        row[many - used.size : many] = np.linalg.inv(np.column_stack([used**order for order in (0, *orders)]))[0]
    return rows
