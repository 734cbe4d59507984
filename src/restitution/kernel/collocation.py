"""Radau IIA collocation on elements with S nodes: coefficients, and algebra of the dense 8 x 8 matrices."""

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numpy.polynomial import legendre
from numpy.typing import NDArray

from restitution.checks import Array
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
    within_range,
    write,
    write8,
)
from restitution.kernel.workspace import BASIS, LENGTH, START, Work, aligned

# Coefficients of Radau IIA collocation with S nodes, accurate to rounding and computed once.


class Scheme(NamedTuple):
    """Coefficients of the S-stage Radau IIA method on the unit element."""

    c: Array  # (S + 1,): zero and the S nodes; the last node is 1
    A: Array  # (S, S): Butcher matrix, `A_ij = int_0^c_i l_j`
    columns: Array  # (S, S): the columns of A
    square: Array  # (S, S): the columns of its square
    identity: Array  # (S, S)
    weights: Array  # (S + 1,): weights of interpolation on `c`: `l_j(x) = weights_j prod_(i != j) (x - c_i)`
    # (2, S + 1): rows that map values at `c` to the Legendre coefficients of degree S - 1 and S of their interpolant
    tail: Array
    extrapolation: Array  # (S,): weights of interpolation on the S nodes without zero
    derivative: Array  # (S + 1, S + 1): maps values at `c` to the slopes of their interpolant there
    between: Array  # (S,): places between the nodes, about halfway
    at_between: Array  # (S + 1, S): columns of the interpolation from `c` to `between`
    at_between_inner: Array  # (S, S): the same from the nodes without zero
    # (2, S): weights at the nodes and at `between` of the rule on both of them less that of the method: on an
    # integrand, what the method misses
    missed: Array

    @property
    def order(self) -> int:
        """Declared order of the method at the end of an element, 2 S - 1."""
        return 2 * len(self.A) - 1

    @property
    def stage_order(self) -> int:
        """Declared order of the dense output, S + 1."""
        return len(self.A) + 1


def _nodes(stages: int) -> Array:
    """Roots of P_S - P_(S-1) on [0, 1] by Newton from the eigenvalues; the last one is 1 (Hairer & Wanner, IV.5)."""
    series = np.zeros(stages + 1)
    series[stages], series[stages - 1] = 1.0, -1.0
    x = np.sort(legendre.legroots(series).real)
    slope = legendre.legder(series)
    for _ in range(3):
        x -= legendre.legval(x, series) / legendre.legval(x, slope)
    x[-1] = 1.0
    return (x + 1.0) / 2.0


def _lagrange_weights(x: Array) -> Array:
    difference = x[:, None] - x[None, :]
    np.fill_diagonal(difference, 1.0)
    return 1.0 / difference.prod(axis=1)


def _interpolation(x: Array, places: Array) -> NDArray[np.floating[Any]]:
    """Return the columns of the matrix that maps values at x to those of their interpolant at given places."""
    degree = len(x) - 1
    basis = legendre.legvander(2.0 * x - 1.0, degree)
    return np.linalg.solve(basis.T, legendre.legvander(2.0 * places - 1.0, degree).T)


def _differentiation(x: Array, weights: Array) -> Array:
    """Return the barycentric differentiation matrix (Berrut & Trefethen, SIAM Review 46 (2004) 501, section 9.3)."""
    difference = x[:, None] - x[None, :]
    np.fill_diagonal(difference, 1.0)
    matrix = weights[None, :] / weights[:, None] / difference
    np.fill_diagonal(matrix, 0.0)
    np.fill_diagonal(matrix, -matrix.sum(axis=1))
    return matrix


def _aligned(array: NDArray[np.floating[Any]]) -> Array:
    """Copy that is aligned to the processor's cache lines, like the scratch space of the kernel."""
    copy = aligned(*array.shape)
    copy[...] = array
    return copy


@cache
def radau(stages: int) -> Scheme:
    """Return the coefficients of the Radau IIA method with S = `stages`, from 2 to 12.

    Its order is 2 S - 1 at the end of an element and S + 1 inside, and it is A-stable and stiffly accurate (E. Hairer,
    G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer 1996, IV.5).

    Examples
    --------
    >>> radau(2).A.round(4).tolist()
    [[0.4167, -0.0833], [0.75, 0.25]]
    """
    if not 2 <= stages <= 12:
        raise ValueError(f"stages = {stages}: must be in [2, 12]")
    nodes = _nodes(stages)
    # A in the Legendre basis, because the monomial basis is ill conditioned.
    values = legendre.legvander(2.0 * nodes - 1.0, stages - 1)
    integrals = np.empty_like(values)
    for degree in range(stages):
        antiderivative = legendre.legint(np.eye(stages)[degree], lbnd=-1.0) / 2.0
        integrals[:, degree] = legendre.legval(2.0 * nodes - 1.0, antiderivative)
    A = np.linalg.solve(values.T, integrals.T).T
    points = np.concatenate([[0.0], nodes])
    tail = np.linalg.inv(legendre.legvander(2.0 * points - 1.0, stages))[stages - 1 :]
    weights = _lagrange_weights(points)
    # Halfway in the angle, in which the nodes are almost equally spaced.
    angle = np.arccos(1.0 - 2.0 * points)
    between = 0.5 - 0.5 * np.cos(0.5 * (angle[1:] + angle[:-1]))
    both = np.concatenate([nodes, between])
    rule = np.linalg.solve(legendre.legvander(2.0 * both - 1.0, 2 * stages - 1).T, np.eye(2 * stages)[0])
    missed = (rule - np.append(A[-1], np.zeros(stages))).reshape(2, stages)
    arrays = [
        points, A, A.T, (A @ A).T, np.eye(stages), weights, tail, _lagrange_weights(nodes),
        _differentiation(points, weights), between, _interpolation(points, between), _interpolation(nodes, between),
        missed,
    ]  # fmt: skip
    return Scheme(*(_aligned(array) for array in arrays))


# Algebra of the dense 8 x 8 matrices of one element, and interpolation on its nodes.
#
# A matrix is an array of its columns, so that its product with lanes is a sum of columns.

# Weights of the last two Legendre coefficients of an element in its tail. The last one alone may vanish by chance.
_LAST, _SECOND_TO_LAST = 0.85, 0.09
# Search for a crossing.
_MARGIN = 0.01  # distance from the ends of the interval over its length
_ROUNDS = 100
# Size of the function and of the interval at the end. A body that has nearly stopped has velocities below 1e-17: there
# the function ends at its own rounding, or the turning point would lie where the body still moves.
_NO_VALUE, _NO_LENGTH, _ROUNDED = 1e-17, 1e-15, 1e-15


@inlined
def matvec(columns: Any, x: Any) -> Any:
    """Return the product of a matrix and lanes, as two independent sums."""
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
    matrices[first] = _inverse(matrices[first])


def invert_two(matrices: Any, first: int) -> None:
    """Replace matrices[first] and the next one by their inverses, with interleaved independent operations."""
    matrices[first : first + 2] = _inverse(matrices[first : first + 2])


def _inverse(matrices: Any) -> Any:
    """Return the inverse of matrices; no numbers for a singular one, as from machine code, which gives Newton up."""
    try:
        return np.linalg.inv(matrices)
    except np.linalg.LinAlgError:
        return np.full_like(matrices, np.nan)


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
    """Return the rows p and p + 1 times the inverse of their block; the inverse replaces the block."""
    upper, lower = rows[p], rows[p + 1]
    a, b, c, d = (shuffled(builder, row, [lane] * WIDTH) for row in (upper, lower) for lane in (p, p + 1))
    zero = ir.Constant(ir.IntType(32), 0)
    determinant = builder.fsub(builder.fmul(a, d), builder.fmul(b, c))
    number = builder.fdiv(ir.Constant(ir.DoubleType(), 1.0), builder.extract_element(determinant, zero))
    inverse = repeated(builder, number)
    ones = [ir.Constant(constant(0.0).type, [float(n == lane) for n in range(WIDTH)]) for lane in (p, p + 1)]
    upper, lower = (
        builder.select(unit(p, 2), diagonal, row) for diagonal, row in zip(ones, (upper, lower), strict=True)
    )
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
    """Return eight interpolated values: sum of the rows of `basis` times the values at the nodes."""
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
        # Lanes of other elements are far outside a short one.
        x = within_range((sigma - start) / length)
        lagrange_lanes(scheme.c, scheme.weights, WIDTH + 1, x, work.basis)
        table = tables[place]
        for n in range(rows.shape[0]):
            value = combine(work.basis, WIDTH + 1, table[n])
            # Keep the lanes that belong to earlier elements.
            if lane > 0:
                value = from_lane(lane, value, read8(rows, n, 0))
            write8(rows, n, 0, value)
        lane += 1
        # Nodes in the same element share its basis. Below element 0 there is none.
        while lane < WIDTH and (place == 0 or sigma[lane] >= start):
            lane += 1
    return place


@inlined
def seek(places: Any, element: int, sigma: float) -> int:
    """Return the element of the approach that contains sigma, searched downwards from `element`."""
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
    """Return the size of the last two Legendre coefficients of a row over an element, weighted."""
    return _LAST * abs(product(scheme.tail[1], row)) + _SECOND_TO_LAST * abs(product(scheme.tail[0], row))


@inlined
def value(scheme: Scheme, work: Work, row: Any, x: float) -> float:
    """Return the value at x of the interpolant of a row over an element."""
    basis = work.vectors[BASIS]
    lagrange(scheme.c, scheme.weights, WIDTH + 1, x, basis)
    return product(basis, row)


@compiled
def crossing(scheme: Scheme, work: Work, row: Any, level: float, end: float) -> float:
    """Place in [0, end] at which a row of an element crosses a level (bracketed secant method)."""
    low, high = 0.0, end
    f_low, f_high = row[0] - level, value(scheme, work, row, end) - level
    rising = f_high > f_low
    no_value = min(_NO_VALUE, _ROUNDED * (abs(f_low) + abs(f_high)))
    x = 0.5 * end
    for _ in range(_ROUNDS):
        x = low + (high - low) * f_low / (f_low - f_high)
        # The secant may stay at one end of a bent function; a margin moves both ends.
        x = min(max(x, low + _MARGIN * (high - low)), high - _MARGIN * (high - low))
        f = value(scheme, work, row, x) - level
        if (f > 0.0) != rising:
            low, f_low = x, f
        else:
            high, f_high = x, f
        if abs(f) < no_value or high - low < _NO_LENGTH:
            break
    return x
