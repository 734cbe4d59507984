"""Polynomials of a(s) in the cells of a path table, compiled."""

import math
from typing import Any

from restitution.kernel.compile import entry_point


@entry_point
def fit_cells(
    depth: Any, radius: Any, deepest: Any, origin: Any, slopes: Any, weights: Any, place: Any, ends: Any,
    coefficients: Any, sums: Any,
) -> None:  # fmt: skip
    """Fit a polynomial to each cell of several tables and compare it with the values between its nodes.

    Parameters
    ----------
    depth, radius
        Depth and stiffness radius at the n nodes of each cell, from its start to its end, and then at n Gauss nodes,
        shape (n_table, n_cell, 2 n).
    deepest, origin
        Largest depth of each table, shape (n_table,), and origin of rho, shape (n_table, n_cell).
    slopes, weights
        Slopes at the Gauss nodes from values at the nodes, shape (n, n), and weights, for a cell of width 1.
    place
        Space for 2 n numbers.
    ends
        Results of the shape (n_table, n_cell, 3): s and rho at the start, and the width in rho.
    coefficients
        Coefficients over the share of the width, shape (n_table, n_cell, n), lowest power first.
    sums
        Results of the shape (n_table, n_cell, 3): ``int a dd``, ``int |delta a| dd`` and the largest error of a.
    """
    n = weights.shape[0]
    for table in range(depth.shape[0]):
        for cell in range(depth.shape[1]):
            start = origin[table, cell]
            for i in range(2 * n):
                s = math.sqrt(depth[table, cell, i] / deepest[table])
                if i == 0:
                    ends[table, cell, 0] = s
                place[i] = s if start < 0.0 else math.sqrt(max(s - start, 0.0))
            low = place[0]
            width = place[n - 1] - low
            ends[table, cell, 1], ends[table, cell, 2] = low, width
            for i in range(2 * n):
                place[i] = (place[i] - low) / width
            # Divided differences, then powers (Bjorck and Pereyra 1970).
            for i in range(n):
                coefficients[table, cell, i] = radius[table, cell, i]
            for k in range(n - 1):
                for i in range(n - 1, k, -1):
                    rise = coefficients[table, cell, i] - coefficients[table, cell, i - 1]
                    coefficients[table, cell, i] = rise / (place[i] - place[i - k - 1])
            for k in range(n - 2, -1, -1):
                for i in range(k, n - 1):
                    coefficients[table, cell, i] -= place[k] * coefficients[table, cell, i + 1]
            gain = missed = largest = 0.0
            for j in range(n):
                value = 0.0
                pace = 0.0
                for i in range(n - 1, -1, -1):
                    value = value * place[n + j] + coefficients[table, cell, i]
                    pace += slopes[j, i] * depth[table, cell, i]
                error = abs(value - radius[table, cell, n + j])
                gain += weights[j] * pace * radius[table, cell, n + j]
                missed += weights[j] * pace * error
                largest = max(largest, error)
            sums[table, cell, 0], sums[table, cell, 1], sums[table, cell, 2] = gain, missed, largest
