"""Matrix products on one thread."""

from __future__ import annotations

from typing import Any

import numpy as np

from restitution.contact.geometry import Array

# Multiplications for which the library starts no threads; they cost more than the product where the cores are used.
_MOST = 200_000


def product(one: Any, other: Any) -> Array:
    """Matrix product in blocks of rows that are small enough for one thread."""
    result = np.empty((len(one), other.shape[1]))
    rows = max(1, _MOST // max(1, other.size))
    for start in range(0, len(one), rows):
        np.matmul(one[start : start + rows], other, out=result[start : start + rows])
    return result
