"""Linear systems of few unknowns, by elimination with pivots: at once, or by factors that are kept."""

from typing import Any

from restitution.kernel.compile import compiled
from restitution.kernel.lanes import WIDTH, from_lane, read8, write8
from restitution.kernel.panels import STAGES


@compiled
def solve_linear(matrix: Any, S: int) -> bool:
    """Solve S equations by elimination with pivots; the right-hand sides, the last columns, become the solutions."""
    size = matrix.shape[1]
    for c in range(S):
        row = c
        for r in range(c, S):
            if abs(matrix[r, c]) > abs(matrix[row, c]):
                row = r
        if not abs(matrix[row, c]) > 0.0:
            return False
        if row != c:
            for n in range(c, size):
                matrix[c, n], matrix[row, n] = matrix[row, n], matrix[c, n]
        for r in range(c + 1, S):
            factor = matrix[r, c] / matrix[c, c]
            for n in range(c + 1, size):
                matrix[r, n] -= factor * matrix[c, n]
    for side in range(S, size):
        for c in range(S - 1, -1, -1):
            value = matrix[c, side]
            for n in range(c + 1, S):
                value -= matrix[c, n] * matrix[n, side]
            matrix[c, side] = value / matrix[c, c]
    return True


@compiled
def factorise(matrix: Any, pivots: Any) -> bool:
    """Put the factors of a padded matrix in its place, by elimination with pivots."""
    S = STAGES
    for c in range(S):
        row = c
        for r in range(c + 1, S):
            if abs(matrix[r, c]) > abs(matrix[row, c]):
                row = r
        if not abs(matrix[row, c]) > 0.0:
            return False
        pivots[c] = row
        low, high = read8(matrix, row, 0), read8(matrix, row, WIDTH)
        if row != c:
            write8(matrix, row, 0, read8(matrix, c, 0))
            write8(matrix, row, WIDTH, read8(matrix, c, WIDTH))
            write8(matrix, c, 0, low)
            write8(matrix, c, WIDTH, high)
        pivot = 1.0 / low[c] if c < WIDTH else 1.0 / high[c - WIDTH]
        for r in range(c + 1, S):
            factor = matrix[r, c] * pivot
            first, second = read8(matrix, r, 0), read8(matrix, r, WIDTH)
            write8(matrix, r, 0, from_lane(c + 1, first - factor * low, first))
            write8(matrix, r, WIDTH, from_lane(c + 1 - WIDTH, second - factor * high, second))
            matrix[r, c] = factor
    return True


@compiled
def solve_factorised(factors: Any, pivots: Any, matrix: Any) -> None:
    """Solve with the factors of a matrix; the right-hand side, the last column of another one, is replaced."""
    S = STAGES
    for c in range(S):
        row = pivots[c]
        matrix[c, S], matrix[row, S] = matrix[row, S], matrix[c, S]
    for r in range(1, S):
        for n in range(r):
            matrix[r, S] -= factors[r, n] * matrix[n, S]
    for r in range(S - 1, -1, -1):
        for n in range(r + 1, S):
            matrix[r, S] -= factors[r, n] * matrix[n, S]
        matrix[r, S] /= factors[r, r]
