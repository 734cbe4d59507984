"""Dense algebra on the small matrices of one element, and interpolation on its nodes."""

from typing import Any

from restitution.kernel.compile import part


@part
def invert(M: Any, row: Any, size: Any) -> None:
    """Replace the S x S matrix M by its inverse: Gauss-Jordan without pivoting, S = len(size).

    `row` is scratch space of length S. Each step moves the matrix up and to the left by one, so that the pivot
    is always M[0, 0] and every index is fixed. The matrices of the collocation, `I + h A diag(x)` with x > 0,
    need no pivoting.
    """
    S = len(size)
    for _ in range(S):
        pivot = 1.0 / M[0, 0]
        for j in range(1, S):
            row[j] = M[0, j] * pivot
        for i in range(1, S):
            factor = M[i, 0]
            for j in range(1, S):
                M[i - 1, j - 1] = M[i, j] - factor * row[j]
            M[i - 1, S - 1] = -factor * pivot
        for j in range(1, S):
            M[S - 1, j - 1] = row[j]
        M[S - 1, S - 1] = pivot


@part
def lagrange(nodes: Any, weights: Any, points: int, x: float, basis: Any) -> None:
    """Write the Lagrange basis of the first `points` nodes at x: products only, exact at a node, no division."""
    product = 1.0
    for j in range(points):
        basis[j] = weights[j] * product
        product *= x - nodes[j]
    product = 1.0
    for j in range(points - 1, -1, -1):
        basis[j] *= product
        product *= x - nodes[j]
