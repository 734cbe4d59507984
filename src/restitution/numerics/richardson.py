"""Richardson's extrapolation of numbers whose error falls with the square of the number of elements."""

from __future__ import annotations

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
