"""Richardson's extrapolation of numbers whose error falls with powers of the number of elements."""

from __future__ import annotations

import math
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
# Changes are at least of this order, and as many count: one may be small by chance.
_FALL, _KEPT = 3.0, 2


class Extrapolation:
    """Extrapolation of numbers from more and more elements, whose error is a series of powers from the second on.

    One, two or three terms are taken away, whichever has the smallest error of the first number. Terms beyond the
    first help where the numbers are smooth, and harm where switches within an element make their errors jump.

    A change of extrapolated numbers is the error of those before it, which falls with the third power of the number of
    elements. The error is `margin` times what is left of the last two changes, the larger one.

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
        self._counts: list[int] = []
        self._values: list[Array] = []
        # Of each order the last numbers, and their last changes, the latest first.
        self._last = np.empty(0)
        self._changes = np.empty(0)

    def add(self, count: int, values: ArrayLike) -> tuple[list[float], list[float]]:
        """Take the numbers from `count` elements; return the extrapolated ones and their errors, infinite at first."""
        fine = np.asarray(values, dtype=np.float64)
        self._counts.append(count)
        self._values.append(fine)
        many = len(self._values)
        if many == 1:
            shape = len(_ORDERS), fine.size
            self._last, self._changes = np.empty(shape), np.zeros((_KEPT, *shape))
            return fine.tolist(), [math.inf] * fine.size
        known = min(many - 1, len(_ORDERS))
        limits = _weights(tuple(self._counts[-known - 1 :])) @ np.array(self._values[-known - 1 :])
        # An order has a change from its second number on, and an error from two changes on.
        changed = min(many - 2, len(_ORDERS))
        self._changes[1:] = self._changes[:-1]
        np.abs(limits[:changed] - self._last[:changed], out=self._changes[0, :changed])
        self._last[:known] = limits
        before = np.array(self._counts[-2 : -2 - _KEPT : -1], dtype=np.float64)
        shares = (before / count) ** _FALL
        errors = (self._margin * (shares[:, None, None] * self._changes[: before.size]).max(axis=0)).tolist()
        best, least = known - 1, [math.inf] * fine.size
        for n in range(min(many - 3, len(_ORDERS))):
            if errors[n][0] <= least[0]:
                best, least = n, errors[n]
        return limits[best].tolist(), least


@cache
def _weights(counts: tuple[int, ...]) -> Array:
    """Return the weights of numbers in those without the terms of each order, which use the last of them."""
    rows = np.zeros((len(counts) - 1, len(counts)))
    steps = counts[-1] / np.array(counts, dtype=np.float64)
    for row, orders in zip(rows, _ORDERS, strict=False):
        used = steps[-len(orders) - 1 :]
        row[-used.size :] = np.linalg.inv(np.column_stack([used**order for order in (0, *orders)]))[0]
    return rows
