"""The plane of the paper's figures, in coordinates in which its restitution coefficient is smooth; look-up there.

The reduced modulus of the compressible standard solid relaxes at tau and at tau r, with r from 1 (incompressible) to
q = 1 + 1/p2, the glassy over the equilibrium shear modulus (nu = -1). The coordinates are::

    x = log r/log q                             from 0 to 1 as nu goes from 1/2 to -1
    y = log10 p2
    z = log10(p2 p3) + (2/5 + c x) log10 q

Here p2 p3 is tau over a time scale of the impact at the equilibrium modulus, and q^(2/5) turns that into one at the
glassy modulus. Where p2 is small, e has all but a kink at a certain value of that ratio, and q^(c x) follows it as x
changes: c = 1/2, half-way from tau to tau r, for x < 1/2; beyond, where the other branch makes the kink, c = 0.07.
"""

from __future__ import annotations

import math
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.surrogates.boxes import TERMS, Boxes, boxes_of_cells
from restitution.surrogates.lookup import compiled

Array = NDArray[np.float64]

P2 = (1e-3, 10.0)
P3 = (1e-2, 100.0)
"""Ends of the plane."""

HALVED = (1, 0, 0)
"""c changes where x has been halved once."""

_SLOPES = (0.5, 0.07)
_INVERSE_LN10 = 1.0 / math.log(10.0)


def corners() -> tuple[Array, Array]:
    """Lowest and highest x, y, z."""
    (y_low, y_high), (z_low, z_high) = np.log10([P2, P3])
    x = np.array([0.0, 0.5 - 1e-12, 0.5, 1.0])
    low, high = np.array([0.0, y_low, z_low]), np.array([1.0, y_high, z_high])
    # z grows with y and, in each half, with x.
    low[2] += _shift(x, y_low).min()
    high[2] += _shift(x, y_high).max()
    return low, high


def groups(points: Array) -> tuple[Array, Array, Array]:
    """Return nu, p2, p3 at points x, y, z, shape (n, 3)."""
    x, y, z = points.T
    q = 1.0 + 10.0**-y
    r = q**x
    # r = ((1 + nu) + 2 q (1 - 2 nu))/(3 (1 - nu)), solved for nu.
    nu = (1.0 + 2.0 * q - 3.0 * r) / (4.0 * q - 1.0 - 3.0 * r)
    return np.clip(nu, -1.0, 0.5), 10.0**y, 10.0 ** (z - _shift(x, y))


def _shift(x: Any, y: Any) -> Any:
    """Return z - log10 p3."""
    return y + (0.4 + np.where(x < 0.5, *_SLOPES) * x) * np.log10(1.0 + 10.0**-y)


class Grid(NamedTuple):
    """Boxes, ready for look-up.

    Attributes
    ----------
    low, scale : array, shape (3,)
        Corner, and boxes of the finest grid per unit.
    cells : array of int
        The box of each cell of the finest grid.
    middle, inverse : array, shape (n_box, 3)
        Middle of each box, and the inverse of half its width.
    coefficients : array, shape (n_box, TERMS, TERMS * TERMS)
        Tensor Chebyshev coefficients.
    """

    low: Array
    scale: Array
    cells: NDArray[np.int16]
    middle: Array
    inverse: Array
    coefficients: NDArray[np.float32]


def ready(boxes: Boxes) -> Grid:
    """Prepare boxes for look-up."""
    cells = boxes_of_cells(boxes)
    extent = boxes.high - boxes.low
    width = extent * 0.5**boxes.levels
    return Grid(
        boxes.low, np.array(cells.shape) / extent, cells, boxes.low + width * (boxes.places + 0.5), 2.0 / width,
        boxes.coefficients.reshape(-1, TERMS, TERMS * TERMS),
    )  # fmt: skip


# Multiplications and additions may be fused: nothing else has to repeat them to the last bit.
_FLAGS: dict[str, Any] = {"fastmath": {"contract"}, "forceinline": True}


@partial(compiled, **_FLAGS)
def _chebyshev(t: float, terms: Any, variable: int) -> None:
    """Write the polynomials of one variable into their row; a slice for it would be counted as a reference."""
    terms[variable, 0] = 1.0
    terms[variable, 1] = t
    for k in range(2, TERMS):
        terms[variable, k] = 2.0 * t * terms[variable, k - 1] - terms[variable, k - 2]


@partial(compiled, fastmath={"contract"})
def restitution(
    nu: Any, p2: Any, p3: Any, low: Any, scale: Any, cells: Any, middle: Any, inverse: Any, c: Any, out: Any
) -> None:
    """Restitution coefficient at arrays of nu, p2, p3 within the plane; of a grid, its arrays."""
    terms, rows = np.empty((3, TERMS)), np.empty(TERMS * TERMS)
    for n in range(out.size):
        q = 1.0 + 1.0 / p2[n]
        log_q = math.log(q)
        r = ((1.0 + nu[n]) + 2.0 * q * (1.0 - 2.0 * nu[n])) / (3.0 * (1.0 - nu[n]))
        x = math.log(r) / log_q
        y = math.log(p2[n]) * _INVERSE_LN10
        slope = _SLOPES[0] if x < 0.5 else _SLOPES[1]
        z = (math.log(p2[n] * p3[n]) + (0.4 + slope * x) * log_q) * _INVERSE_LN10
        i = min(max(int((x - low[0]) * scale[0]), 0), cells.shape[0] - 1)
        j = min(max(int((y - low[1]) * scale[1]), 0), cells.shape[1] - 1)
        k = min(max(int((z - low[2]) * scale[2]), 0), cells.shape[2] - 1)
        box = cells[i, j, k]
        _chebyshev((x - middle[box, 0]) * inverse[box, 0], terms, 0)
        _chebyshev((y - middle[box, 1]) * inverse[box, 1], terms, 1)
        _chebyshev((z - middle[box, 2]) * inverse[box, 2], terms, 2)
        out[n] = _series(c, box, terms, rows)


@partial(compiled, **_FLAGS)
def _series(c: Any, box: int, terms: Any, rows: Any) -> float:
    """Value of the tensor series of a box; `terms` are the polynomials, `rows` is scratch."""
    t0, t1, t2, t3 = terms[0, 0], terms[0, 1], terms[0, 2], terms[0, 3]
    t4, t5, t6, t7 = terms[0, 4], terms[0, 5], terms[0, 6], terms[0, 7]
    # Written out, one loop over a whole row keeps the vector units busy: 70 ns in place of 210.
    for m in range(TERMS * TERMS):
        rows[m] = (
            c[box, 0, m] * t0 + c[box, 1, m] * t1 + c[box, 2, m] * t2 + c[box, 3, m] * t3
            + c[box, 4, m] * t4 + c[box, 5, m] * t5 + c[box, 6, m] * t6 + c[box, 7, m] * t7
        )  # fmt: skip
    total = 0.0
    for b in range(TERMS):
        over_z = 0.0
        for m in range(TERMS):
            over_z += rows[TERMS * b + m] * terms[2, m]
        total += over_z * terms[1, b]
    return total
