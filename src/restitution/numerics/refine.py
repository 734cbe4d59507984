"""Chebyshev series, and intervals that are halved until a function is resolved on each."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from restitution.checks import Array

Cells = Array
"""Intervals, shape (n, 2 or more); the last two columns are their ends."""


def refine(
    cells: Cells,
    fit: Callable[[Cells], tuple[Any, ...]],
    halvings: int,
    most: float = math.inf,
    halve: Callable[[Cells], Cells] | None = None,
) -> tuple[list[Array], bool]:
    """Halve cells until all are good.

    Parameters
    ----------
    cells
        Cells to begin with.
    fit
        Function from n cells to whether each is good, shape (n,), and further arrays with a row for each.
    halvings, most
        Largest numbers of halvings of a cell, and of cells. What is not good then is kept as it is.
    halve
        Function from cells to their halves, by default those on both sides of the middle.

    Returns
    -------
    list of array, bool
        The cells in no order, and the further arrays; whether the number of cells ended the halving.

    Examples
    --------
    >>> fit = lambda cells: (np.diff(cells)[:, 0] <= 0.1 + cells[:, 0], np.diff(cells))
    >>> (cells, widths), _ = refine(np.array([[0.0, 1.0]]), fit, halvings=9)
    >>> print(np.sort(cells[:, 0]).tolist())
    [0.0, 0.0625, 0.125, 0.25, 0.5]
    """
    done: list[list[Array]] = []
    size, is_cut = 0, False
    for rank in range(halvings + 1):
        good, *columns = fit(cells)
        size += int(np.count_nonzero(good))
        is_cut = size + 2 * int(np.count_nonzero(~good)) > most and not good.all()
        kept = good | (rank == halvings) | is_cut
        done.append([column[kept] for column in (cells, *columns)])
        if kept.all():
            break
        cells = (halve or _halved)(cells[~kept])
    return [np.concatenate(parts) for parts in zip(*done, strict=True)], is_cut


def _halved(cells: Cells) -> Cells:
    low, high = cells.copy(), cells.copy()
    low[:, -1] = high[:, -2] = 0.5 * (cells[:, -2] + cells[:, -1])
    return np.concatenate([low, high])


def to_chebyshev(count: int) -> tuple[Array, Array]:
    """Return the Chebyshev nodes in (-1, 1), descending, and the matrix from values there to coefficients.

    Examples
    --------
    >>> nodes, matrix = to_chebyshev(3)
    >>> print(np.abs(matrix @ nodes**2).round(12))
    [0.5 0.  0.5]
    """
    angle = np.pi * (np.arange(count) + 0.5) / count
    matrix = np.cos(np.arange(count)[:, None] * angle) * (2.0 / count)
    matrix[0] *= 0.5
    return np.cos(angle), matrix


def local(x: Any, low: Any, high: Any) -> Any:
    """Return the place of x in [low, high], from -1 to 1."""
    return (2.0 * x - low - high) / (high - low)


def chebyshev(coefficients: Array, t: Array) -> Array:
    """Return values of Chebyshev series with coefficients of shape (..., n) at t, shape (...)."""
    return np.asarray(np.polynomial.chebyshev.chebval(t, np.moveaxis(coefficients, -1, 0), tensor=False), np.float64)
