"""Line loads of flat punches on a layer: the symmetric linear system of the integral equation, compiled.

The library routines of NumPy start threads for systems of this size, which costs up to a hundred times more than the
solution where other processes use the cores.
"""

import math
from typing import Any

from restitution.kernel.compile import entry_point, inlined


@inlined
def _kernel(cells: Any, per_unit: float, t: float) -> float:
    """Kernel m(t) from its polynomials over cells of equal width, highest power first."""
    place = t * per_unit
    cell = int(place)
    place = 2.0 * (place - cell) - 1.0
    value = cells[0, cell]
    for k in range(1, cells.shape[0]):
        value = value * place + cells[k, cell]
    return value


@entry_point
def solve_line_loads(
    cells: Any, per_unit: float, radii: Any, nodes: Any, weights: Any, matrix: Any, roots: Any, loads: Any, ends: Any
) -> None:
    """Write the resolvent r and the load w at the nodes a x_j of each radius a, and ``int w dx`` and w(a).

    Parameters
    ----------
    cells, per_unit
        Polynomials of m(t), shape (degree + 1, n_cell), and cells for each unit of t.
    radii, nodes, weights
        Radii a, and Gauss nodes and weights on [0, 1], shape (n,).
    matrix, roots
        Space for n^2 and n numbers.
    loads, ends
        Results of the shapes (n_radius, 2, n) and (n_radius, 2).
    """
    n = nodes.shape[0]
    for k in range(radii.shape[0]):
        a = radii[k]
        for i in range(n):
            roots[i] = math.sqrt(a * weights[i])
        for i in range(n):
            for j in range(i, n):
                m = _kernel(cells, per_unit, a * abs(nodes[i] - nodes[j]))
                m += _kernel(cells, per_unit, a * (nodes[i] + nodes[j]))
                matrix[i, j] = -roots[i] * roots[j] * m
            matrix[i, i] += 1.0
            m = _kernel(cells, per_unit, a * (1.0 - nodes[i])) + _kernel(cells, per_unit, a * (1.0 + nodes[i]))
            loads[k, 0, i], loads[k, 1, i] = roots[i] * m, roots[i]
        # Cholesky's factors row by row, along which the memory lies, with the substitution of both right-hand sides.
        for i in range(n):
            scale = 1.0 / math.sqrt(matrix[i, i])
            for j in range(i, n):
                matrix[i, j] *= scale
            for side in range(2):
                loads[k, side, i] *= scale
            for row in range(i + 1, n):
                factor = matrix[i, row]
                for j in range(row, n):
                    matrix[row, j] -= factor * matrix[i, j]
                for side in range(2):
                    loads[k, side, row] -= factor * loads[k, side, i]
        for side in range(2):
            for i in range(n - 1, -1, -1):
                total = loads[k, side, i]
                for j in range(i + 1, n):
                    total -= matrix[i, j] * loads[k, side, j]
                loads[k, side, i] = total / matrix[i, i]
        ends[k, 0], ends[k, 1] = 0.0, 1.0
        for i in range(n):
            m = _kernel(cells, per_unit, a * (1.0 - nodes[i])) + _kernel(cells, per_unit, a * (1.0 + nodes[i]))
            ends[k, 0] += roots[i] * loads[k, 1, i]
            ends[k, 1] += roots[i] * m * loads[k, 1, i]
            for side in range(2):
                loads[k, side, i] /= roots[i]
