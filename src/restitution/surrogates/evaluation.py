"""Compiled evaluation of Chebyshev series: of one variable piece by piece, and of three variables in boxes."""

from __future__ import annotations

import math
from functools import partial
from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from restitution.checks import Array
from restitution.kernel.compile import cached

TERMS = 8
"""Terms of a series of three variables, in each of them."""


def compiled(function: Any, **flags: Any) -> Any:
    """Compile a function on its first call, and cache its machine code if possible."""
    return cached(numba.njit(nogil=True, error_model="numpy", **flags)(function), function)


class Pieces(NamedTuple):
    """Chebyshev series in a variable that runs from -1 to 1 over each piece of an interval.

    The n + 1 `edges` increase; the widths are the whole over powers of two. `coefficients` have the shape (n_function,
    n, degree + 1).
    """

    edges: Array
    coefficients: Array


class LookupTable(NamedTuple):
    """Pieces of one function of v > 0, whose logarithm is a Chebyshev series in log v on each piece.

    `cells` of equal width in log v, `per_cell` for one unit, begin at `origin` and contain the piece of each cell. A
    piece has the `middle`, and `inverse` is that of half its width. The function cannot exceed `most`.
    """

    low: float
    high: float
    origin: float
    per_cell: float
    cells: NDArray[np.int64]
    middle: Array
    inverse: Array
    coefficients: Array
    most: float


def table(pieces: Pieces, function: int, low: float, high: float, most: float) -> LookupTable:
    """Prepare one function for look-up."""
    edges = pieces.edges
    whole = edges[-1] - edges[0]
    n_cell = 2 ** round(math.log2(whole / np.diff(edges).min()))
    centres = edges[0] + whole * (np.arange(n_cell) + 0.5) / n_cell
    return LookupTable(
        low, high, float(edges[0]), float(n_cell / whole),
        np.searchsorted(edges, centres, side="right") - 1, 0.5 * (edges[1:] + edges[:-1]),
        2.0 / np.diff(edges), np.ascontiguousarray(pieces.coefficients[function]), most,
    )  # fmt: skip


@compiled
def value(
    v: float, low: float, high: float, origin: float, per_cell: float, cells: Any, middle: Any, inverse: Any,
    coefficients: Any, most: float,
) -> float:  # fmt: skip
    """Return the value of a table at v; NaN outside its range."""
    if not (low <= v <= high):
        return math.nan
    x = math.log(v)
    piece = cells[min(max(int((x - origin) * per_cell), 0), cells.size - 1)]
    t = (x - middle[piece]) * inverse[piece]
    last, before = 0.0, 0.0
    for k in range(coefficients.shape[1] - 1, 0, -1):
        last, before = (coefficients[piece, k] - before) + 2.0 * t * last, last
    return min(math.exp((coefficients[piece, 0] - before) + t * last), most)


@compiled
def values(
    v: Any, out: Any, low: float, high: float, origin: float, per_cell: float, cells: Any, middle: Any,
    inverse: Any, coefficients: Any, most: float,
) -> None:  # fmt: skip
    """Write the values of a table at an array of v."""
    for n in range(v.size):
        out[n] = value(v[n], low, high, origin, per_cell, cells, middle, inverse, coefficients, most)


def scalar_function(lookup: LookupTable) -> Any:
    """Return a compiled function of v with the table as constants, for use in other compiled code."""
    low, high, origin, per_cell, cells, middle, inverse, coefficients, most = lookup

    @numba.njit(error_model="numpy")
    def of_velocity(v: float) -> float:
        return value(v, low, high, origin, per_cell, cells, middle, inverse, coefficients, most)

    return of_velocity


class Boxes(NamedTuple):
    """Tensor Chebyshev series of three variables in boxes, ready for look-up.

    From the corner `low` on, a grid with `scale` cells per unit of each variable contains the box of each cell. A box
    has the `middle`, `inverse` is that of half its width, and `coefficients` have the shape (n_box, TERMS, TERMS**2).
    """

    low: Array
    scale: Array
    cells: NDArray[np.int16]
    middle: Array
    inverse: Array
    coefficients: NDArray[np.float32]


def ready_boxes(low: Array, high: Array, levels: Any, places: Any, coefficients: Any) -> Boxes:
    """Prepare boxes, from `low + (high - low) places/2^levels` on and `(high - low)/2^levels` wide, for look-up."""
    finest = levels.max(axis=0)
    cells = np.full(tuple(2**finest), -1, dtype=np.int16)
    for n, (level, place) in enumerate(zip(levels, places, strict=True)):
        first = place * 2 ** (finest - level)
        cells[tuple(slice(a, a + 2**b) for a, b in zip(first, finest - level, strict=True))] = n
    width = (high - low) * 0.5**levels
    return Boxes(
        low, np.array(cells.shape) / (high - low), cells, low + width * (places + 0.5), 2.0 / width,
        coefficients.reshape(-1, TERMS, TERMS * TERMS),
    )  # fmt: skip


# Multiplications and additions may be fused, because no other code must reproduce the last bit.
_FLAGS: dict[str, Any] = {"fastmath": {"contract"}, "forceinline": True}


@partial(compiled, **_FLAGS)
def _polynomials(t: float, terms: Any, variable: int) -> None:
    """Write the Chebyshev polynomials of one variable into their row; a slice would count references."""
    terms[variable, 0] = 1.0
    terms[variable, 1] = t
    for k in range(2, TERMS):
        terms[variable, k] = 2.0 * t * terms[variable, k - 1] - terms[variable, k - 2]


@partial(compiled, **_FLAGS)
def box_value(
    x: float, y: float, z: float, terms: Any, rows: Any, low: Any, scale: Any, cells: Any, middle: Any,
    inverse: Any, c: Any,
) -> float:  # fmt: skip
    """Return the value of boxes at a point; `terms` (3, TERMS) and `rows` (TERMS^2,) are scratch."""
    i = min(max(int((x - low[0]) * scale[0]), 0), cells.shape[0] - 1)
    j = min(max(int((y - low[1]) * scale[1]), 0), cells.shape[1] - 1)
    k = min(max(int((z - low[2]) * scale[2]), 0), cells.shape[2] - 1)
    box = cells[i, j, k]
    _polynomials((x - middle[box, 0]) * inverse[box, 0], terms, 0)
    _polynomials((y - middle[box, 1]) * inverse[box, 1], terms, 1)
    _polynomials((z - middle[box, 2]) * inverse[box, 2], terms, 2)
    t0, t1, t2, t3 = terms[0, 0], terms[0, 1], terms[0, 2], terms[0, 3]
    t4, t5, t6, t7 = terms[0, 4], terms[0, 5], terms[0, 6], terms[0, 7]
    # One explicit loop over a whole row uses the vector units: 70 ns instead of 210 ns.
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
