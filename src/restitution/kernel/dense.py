"""Algebra of the dense 8 x 8 matrices of one element, and interpolation on its nodes.

A matrix is an array of its columns, so that its product with lanes is a sum of columns.
"""

from typing import Any

import numpy as np
from llvmlite import ir
from numba import types

from restitution.kernel.compile import compiled, inlined
from restitution.kernel.lanes import (
    WIDTH,
    address,
    broadcast,
    constant,
    from_lane,
    operation,
    read,
    read8,
    repeated,
    shuffled,
    total,
    unit,
    write,
    write8,
)
from restitution.kernel.radau import Scheme
from restitution.kernel.workspace import BASIS, LENGTH, START, Work

# Weights of the last two Legendre coefficients of an element in its tail. The last one alone may vanish by chance.
_LAST, _SECOND_TO_LAST = 0.85, 0.09
# Search for a crossing.
_MARGIN = 0.01  # distance from the ends of the interval over its length
_ROUNDS = 100
_NO_VALUE, _NO_LENGTH = 1e-17, 1e-15  # size of the function and of the interval at the end


@inlined
def matvec(columns: Any, x: Any) -> Any:
    """Product of a matrix and lanes, as two independent sums."""
    even = read8(columns, 0, 0) * x[0]
    odd = read8(columns, 1, 0) * x[1]
    for j in range(2, WIDTH, 2):
        even = even + read8(columns, j, 0) * x[j]
        odd = odd + read8(columns, j + 1, 0) * x[j + 1]
    return even + odd


def invert(matrices: Any, first: int) -> None:
    """Replace matrices[first] by its inverse: Gauss-Jordan on blocks of two, without pivoting.

    The matrices of the collocation, `I + h A diag(x)` with x > 0, need no pivoting. Blocks of two halve the number of
    consecutive divisions. The inverse of the array of columns, read as rows, is that of the transpose.
    """
    matrices[first] = np.linalg.inv(matrices[first])


def invert_two(matrices: Any, first: int) -> None:
    """Replace matrices[first] and the next one by their inverses, with interleaved independent operations."""
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
    """Rows p and p + 1 times the inverse of their block; the inverse replaces the block."""
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
    """Write the Lagrange basis at eight places into the rows of `basis`."""
    product = broadcast(1.0)
    for j in range(points):
        write8(basis, j, 0, weights[j] * product)
        product = product * (x - nodes[j])
    product = broadcast(1.0)
    for j in range(points - 1, -1, -1):
        write8(basis, j, 0, read8(basis, j, 0) * product)
        product = product * (x - nodes[j])


@inlined
def combine(basis: Any, points: int, values: Any) -> Any:
    """Eight interpolated values: sum of the rows of `basis` times the values at the nodes."""
    even = read8(basis, 0, 0) * values[0]
    odd = read8(basis, 1, 0) * values[1]
    for j in range(2, points - 1, 2):
        even = even + read8(basis, j, 0) * values[j]
        odd = odd + read8(basis, j + 1, 0) * values[j + 1]
    if points % 2:
        even = even + read8(basis, points - 1, 0) * values[points - 1]
    return even + odd


@inlined
def product(weights: Any, row: Any) -> float:
    """Product of weights and a row, which contains the value at the start of an element and those at the nodes."""
    return weights[0] * row[0] + total(read8(weights, 1) * read8(row, 1))


@inlined
def interpolate(scheme: Scheme, work: Work, table: Any, x: float, row: Any) -> None:
    """Write the values of all rows of an element at x into `row`."""
    basis = work.vectors[BASIS]
    lagrange(scheme.c, scheme.weights, WIDTH + 1, x, basis)
    for n in range(row.shape[0]):
        row[n] = product(basis, table[n])


@inlined
def interpolate_lanes(scheme: Scheme, work: Work, tables: Any, sigma: Any, hint: int, rows: Any) -> int:
    """Write the approach at eight falling sigma into `rows`; return the element of the last.

    `tables` holds the elements of the approach. The search for the element of the first starts at `hint`.
    """
    lane = 0
    place = hint
    while lane < WIDTH:
        place = seek(work.places, place, sigma[lane])
        start, length = work.places[START, place], work.places[LENGTH, place]
        lagrange_lanes(scheme.c, scheme.weights, WIDTH + 1, (sigma - start) / length, work.basis)
        table = tables[place]
        for n in range(rows.shape[0]):
            value = combine(work.basis, WIDTH + 1, table[n])
            if lane > 0:
                value = from_lane(lane, value, read8(rows, n, 0))
            write8(rows, n, 0, value)
        lane += 1
        while lane < WIDTH and (place == 0 or sigma[lane] >= start):
            lane += 1
    return place


@inlined
def seek(places: Any, element: int, sigma: float) -> int:
    """Element of the approach that contains sigma, searched downwards from `element`."""
    while element > 0 and sigma < places[START, element]:
        element -= 1
    return element


@inlined
def interpolate_at(scheme: Scheme, work: Work, hint: int, sigma: float, row: Any) -> int:
    """Write the approach at sigma into `row`; return its element, which is searched downwards from `hint`."""
    place = seek(work.places, hint, sigma)
    x = (sigma - work.places[START, place]) / work.places[LENGTH, place]
    interpolate(scheme, work, work.approach[place], x, row)
    return place


@inlined
def tail(scheme: Scheme, row: Any) -> float:
    """Size of the last two Legendre coefficients of a row over an element, weighted."""
    return _LAST * abs(product(scheme.tail[1], row)) + _SECOND_TO_LAST * abs(product(scheme.tail[0], row))


@inlined
def value(scheme: Scheme, work: Work, row: Any, x: float) -> float:
    """Value at x of the interpolant of a row over an element."""
    basis = work.vectors[BASIS]
    lagrange(scheme.c, scheme.weights, WIDTH + 1, x, basis)
    return product(basis, row)


@compiled
def crossing(scheme: Scheme, work: Work, row: Any, level: float, end: float) -> float:
    """Place in [0, end] at which a row of an element crosses a level (bracketed secant method)."""
    low, high = 0.0, end
    f_low, f_high = row[0] - level, value(scheme, work, row, end) - level
    rising = f_high > f_low
    x = 0.5 * end
    for _ in range(_ROUNDS):
        x = low + (high - low) * f_low / (f_low - f_high)
        x = min(max(x, low + _MARGIN * (high - low)), high - _MARGIN * (high - low))
        f = value(scheme, work, row, x) - level
        if (f > 0.0) != rising:
            low, f_low = x, f
        else:
            high, f_high = x, f
        if abs(f) < _NO_VALUE or high - low < _NO_LENGTH:
            break
    return x
