"""Compiled evaluation of piecewise Chebyshev series: plain numbers in, plain numbers out."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from restitution.surrogates.pieces import Pieces

Array = NDArray[np.float64]


def compiled(function: Callable[..., Any], **flags: Any) -> Any:
    """Compile a function on its first call, and keep its machine code where that is possible."""
    made: Any = numba.njit(nogil=True, error_model="numpy", **flags)(function)
    # Where no folder is writable it is compiled anew in each process; where numba is switched off, not at all.
    with suppress(RuntimeError, AttributeError):
        made.enable_caching()
    return made


class Table(NamedTuple):
    """Pieces of one function of v > 0, whose logarithm is a Chebyshev series in log v on each piece.

    Attributes
    ----------
    low, high : float
        Ends of the range of v.
    origin, per_cell : float
        log v at the first cell, and cells per unit of log v.
    cells : array of int
        The piece of each cell; cells are of equal width in log v.
    middle, inverse : array, shape (n_piece,)
        Middle of each piece in log v, and the inverse of half its width.
    coefficients : array, shape (n_piece, degree + 1)
        Chebyshev coefficients.
    most : float
        What the function cannot exceed.
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


def table(pieces: Pieces, function: int, low: float, high: float, most: float) -> Table:
    """Prepare one function for look-up; the widths of the pieces are powers of two of the whole."""
    edges = pieces.edges
    whole = edges[-1] - edges[0]
    n_cell = 2 ** round(math.log2(whole / np.diff(edges).min()))
    centres = edges[0] + whole * (np.arange(n_cell) + 0.5) / n_cell
    return Table(
        low, high, float(edges[0]), float(n_cell / whole),
        np.searchsorted(edges, centres, side="right") - 1, 0.5 * (edges[1:] + edges[:-1]),
        2.0 / np.diff(edges), np.ascontiguousarray(pieces.coefficients[function]), most,
    )  # fmt: skip


@compiled
def value(
    v: float, low: float, high: float, origin: float, per_cell: float, cells: Any, middle: Any, inverse: Any,
    coefficients: Any, most: float,
) -> float:  # fmt: skip
    """Value of a table at v; NaN outside its range."""
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
    """Values of a table at an array of v."""
    for n in range(v.size):
        out[n] = value(v[n], low, high, origin, per_cell, cells, middle, inverse, coefficients, most)


def scalar_function(one: Table) -> Any:
    """Return a compiled function of v that holds the table as constants, for use in other compiled code."""
    low, high, origin, per_cell, cells, middle, inverse, coefficients, most = one

    @numba.njit(error_model="numpy")
    def of_velocity(v: float) -> float:
        return value(v, low, high, origin, per_cell, cells, middle, inverse, coefficients, most)

    return of_velocity
