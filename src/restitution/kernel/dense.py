"""Dense algebra on the 8 x 8 matrices of one element, and interpolation on its nodes.

A matrix is an array of its columns, so that its product with lanes is a sum of columns.
"""

from typing import Any

import numpy as np
from llvmlite import ir
from numba import types

from restitution.kernel.compile import inlined
from restitution.kernel.lanes import (
    WIDTH,
    address,
    broadcast,
    constant,
    operation,
    read,
    read8,
    repeated,
    shuffled,
    unit,
    write,
    write8,
)


@inlined
def matvec(columns: Any, x: Any) -> Any:
    """Product of a matrix and lanes; in two sums, of which each waits for its own last term only."""
    even = read8(columns[0], 0) * x[0]
    odd = read8(columns[1], 0) * x[1]
    for j in range(2, WIDTH, 2):
        even = even + read8(columns[j], 0) * x[j]
        odd = odd + read8(columns[j + 1], 0) * x[j + 1]
    return even + odd


def invert(matrices: Any, first: int) -> None:
    """Replace matrices[first] by its inverse: Gauss-Jordan on blocks of two, without pivoting.

    The matrices of the collocation, `I + h A diag(x)` with x > 0, need no pivoting. Blocks of two halve the number of
    divisions that wait for each other. The inverse of the array of columns, read as rows, is that of the transpose.
    """
    matrices[first] = np.linalg.inv(matrices[first])


def invert_two(matrices: Any, first: int) -> None:
    """Replace matrices[first] and the next by their inverses, side by side: while one waits, the other goes on."""
    matrices[first : first + 2] = np.linalg.inv(matrices[first : first + 2])


def _inverter(function: Any, count: int) -> None:
    @operation(function, types.void, types.Array, types.Integer)
    def _(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        first = context.cast(builder, arguments[1], signature.args[1], types.intp)
        start = builder.mul(first, ir.Constant(first.type, WIDTH * WIDTH))
        places = [
            [
                address(
                    context, builder, signature.args[0], arguments[0],
                    builder.add(start, ir.Constant(first.type, (n * WIDTH + i) * WIDTH)),
                )
                for i in range(WIDTH)
            ]
            for n in range(count)
        ]  # fmt: skip
        matrices = [[read(builder, place) for place in rows] for rows in places]
        for p in range(0, WIDTH, 2):
            pivots = [_pivot_rows(builder, rows, p) for rows in matrices]
            for rows, (upper, lower) in zip(matrices, pivots, strict=True):
                for i in range(WIDTH):
                    if i not in (p, p + 1):
                        first_part = builder.fmul(shuffled(builder, rows[i], [p] * WIDTH), upper)
                        second_part = builder.fmul(shuffled(builder, rows[i], [p + 1] * WIDTH), lower)
                        row = builder.select(unit(p, 2), constant(0.0), rows[i])
                        rows[i] = builder.fsub(builder.fsub(row, first_part), second_part)
                rows[p], rows[p + 1] = upper, lower
        for rows, addresses in zip(matrices, places, strict=True):
            for row, place in zip(rows, addresses, strict=True):
                write(builder, row, place)
        return context.get_dummy_value()


def _pivot_rows(builder: Any, rows: list[Any], p: int) -> tuple[Any, Any]:
    """Rows p and p + 1 times the inverse of their own block, which takes the place of the block."""
    upper, lower = rows[p], rows[p + 1]
    a, b, c, d = (shuffled(builder, row, [lane] * WIDTH) for row in (upper, lower) for lane in (p, p + 1))
    zero = ir.Constant(ir.IntType(32), 0)
    determinant = builder.fsub(builder.fmul(a, d), builder.fmul(b, c))
    number = builder.fdiv(ir.Constant(ir.DoubleType(), 1.0), builder.extract_element(determinant, zero))
    inverse = repeated(builder, number)
    ones = [ir.Constant(constant(0.0).type, [float(n == lane) for n in range(WIDTH)]) for lane in (p, p + 1)]
    upper, lower = (builder.select(unit(p, 2), one, row) for one, row in zip(ones, (upper, lower), strict=True))
    first = builder.fsub(builder.fmul(d, upper), builder.fmul(b, lower))
    second = builder.fsub(builder.fmul(a, lower), builder.fmul(c, upper))
    return builder.fmul(first, inverse), builder.fmul(second, inverse)


_inverter(invert, 1)
_inverter(invert_two, 2)


@inlined
def invert_modes(matrices: Any, count: int) -> None:
    """Replace the first `count` matrices by their inverses."""
    for k in range(0, count - 1, 2):
        invert_two(matrices, k)
    if count % 2:
        invert(matrices, count - 1)


@inlined
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


@inlined
def lagrange_lanes(nodes: Any, weights: Any, points: int, x: Any, basis: Any) -> None:
    """Write the same at eight places into the rows of `basis`."""
    product = broadcast(1.0)
    for j in range(points):
        write8(basis[j], 0, weights[j] * product)
        product = product * (x - nodes[j])
    product = broadcast(1.0)
    for j in range(points - 1, -1, -1):
        write8(basis[j], 0, read8(basis[j], 0) * product)
        product = product * (x - nodes[j])


@inlined
def combine(basis: Any, points: int, values: Any) -> Any:
    """Eight interpolated values: rows of `basis` weighted with the values at the nodes."""
    even = read8(basis[0], 0) * values[0]
    odd = read8(basis[1], 0) * values[1]
    for j in range(2, points - 1, 2):
        even = even + read8(basis[j], 0) * values[j]
        odd = odd + read8(basis[j + 1], 0) * values[j + 1]
    if points % 2:
        even = even + read8(basis[points - 1], 0) * values[points - 1]
    return even + odd
