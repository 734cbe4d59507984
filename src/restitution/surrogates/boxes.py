"""Chebyshev series of one or two variables on pieces of an interval or in boxes of a rectangle.

Either is halved until the error of its series is small.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial.chebyshev import chebpts1, chebpts2, chebvander
from numpy.typing import NDArray

from restitution.checks import Array
from restitution.surrogates.standard_solid import cell_grid, compiled

IntArray = NDArray[np.int64]


class Limits(NamedTuple):
    """Degree of the series in each variable, most boxes, and most halvings of a box in one variable.

    Random points in each box measure the error, besides those half-way between nodes; `seed` chooses them.
    """

    degree: int
    most: int
    deepest: int
    random: int
    seed: int


OF_PIECES = Limits(12, 512, 12, 16, 20)
OF_BOXES = Limits(8, 256, 10, 24, 22)

# Factor for the error between the points that measure it.
_BETWEEN_POINTS = 2.0


class Pieces(NamedTuple):
    """Chebyshev series in a variable that runs from -1 to 1 over each piece of an interval.

    The n + 1 `edges` increase; the widths are the whole over powers of two. `coefficients` have the shape (n_function,
    n, degree + 1).
    """

    edges: Array
    coefficients: Array


class Boxes(NamedTuple):
    """Boxes of a rectangle of x and y.

    A box begins at `low + (high - low) places/2^levels` and is `(high - low)/2^levels` wide; `levels` and `places`
    have the shape (n_box, 2). `coefficients` have the shape (n_box, degree + 1, degree + 1), those of x first.
    """

    low: Array
    high: Array
    levels: IntArray
    places: IntArray
    coefficients: Array


class NotMet(Exception):
    """Error above the tolerance in the smallest box, or with the most boxes: function, place and error."""

    def __init__(self, function: int, place: list[float], error: float) -> None:
        super().__init__(f"error {error:.2g} of function {function} at {place}")
        self.function, self.place, self.error = function, place, error


def build_pieces(
    sample: Callable[[Array], Array],
    deviation: Callable[[Array, Array], Array],
    low: float,
    high: float,
    tolerance: float,
    report: Callable[[int, int], None] | None = None,
) -> tuple[Pieces, Array]:
    """Interpolate functions on pieces of an interval, halved until the error is at most the tolerance.

    `sample` returns values, shape (n_function, n), at n points, and `deviation` the error of each from approximate and
    exact values. The second result is twice the largest error of each function at points that are no nodes.
    """
    ends = np.array([low]), np.array([high])
    levels, places, series, error = _halved(sample, deviation, *ends, tolerance, OF_PIECES, report)
    lefts = low + (high - low) * places[:, 0] * 0.5 ** levels[:, 0]
    order = np.argsort(lefts)
    return Pieces(np.array([*lefts[order], high]), np.swapaxes(series[order], 0, 1)), error


def build_boxes(
    sample: Callable[[Array, Array], Array], low: Array, high: Array, tolerance: float,
    report: Callable[[int, int], None] | None = None,
) -> tuple[Boxes, float]:  # fmt: skip
    """Interpolate a function of x and y in boxes, halved until the absolute error is at most the tolerance.

    `sample` returns its values at n points. A box is halved in the variable whose series ends with the larger terms.
    The second result is twice the largest error at points that are no nodes.
    """

    def row(x: Array, y: Array) -> Array:
        return sample(x, y)[None]

    def difference(approximate: Array, exact: Array) -> Array:
        return np.abs(approximate - exact)

    levels, places, series, error = _halved(row, difference, low, high, tolerance, OF_BOXES, report)
    return Boxes(low, high, levels, places, series[:, 0]), float(error[0])


def _halved(
    sample: Callable[..., Array], deviation: Callable[[Array, Array], Array], low: Array, high: Array,
    tolerance: float, limits: Limits, report: Callable[[int, int], None] | None,
) -> tuple[IntArray, IntArray, Array, Array]:  # fmt: skip
    """Return levels, places and coefficients of accurate boxes, and the largest error of each function.

    `low` and `high` have an entry for each variable, and `sample` and `deviation` a row for each function.
    """
    rng = np.random.default_rng(limits.seed)
    degree, variables = limits.degree, low.size
    # The ends are nodes, so that neighbouring pieces join. The error is largest half-way between the nodes.
    # Every second place is enough for the first of two variables.
    nodes, between = chebpts2(degree + 1), chebpts1(degree)
    to_coefficients = np.linalg.inv(chebvander(nodes, degree))
    fixed = np.concatenate([_grid(*[nodes] * variables), _grid(*[between[::2]] * (variables - 1), between)])
    tested = slice(nodes.size**variables, None)
    open_ = [((0,) * variables, (0,) * variables)]
    accurate: list[tuple[Any, Any, Array, Array]] = []
    while open_:
        levels, places = (np.array(part) for part in zip(*open_, strict=True))
        width = (high - low) * 0.5**levels
        local = np.concatenate([
            np.broadcast_to(fixed, (len(open_), *fixed.shape)),
            rng.uniform(-1.0, 1.0, (len(open_), limits.random, variables)),
        ], axis=1)  # fmt: skip
        # Rounding must not move a point out of the range.
        points = np.clip((low + width * places)[:, None] + 0.5 * width[:, None] * (local + 1.0), low, high)
        values = sample(*points.reshape(-1, variables).T)
        values = values.reshape(-1, *points.shape[:2])
        series = values[:, :, : tested.start].reshape(*values.shape[:2], *[nodes.size] * variables)
        if variables == 2:
            series = to_coefficients @ series
        series = series @ to_coefficients.T
        following = list[Any]()
        for n, (level, place) in enumerate(open_):
            here, exact = series[:, n], values[:, n, tested]
            approximate = _values(here, local[n, tested], degree)
            error = _BETWEEN_POINTS * np.nan_to_num(deviation(approximate, exact), nan=np.inf)
            if np.all(error <= tolerance):
                accurate.append((level, place, here, error.max(axis=1)))
                continue
            axis = _roughest(here)
            if level[axis] == limits.deepest or len(accurate) + len(following) > limits.most:
                function, worst = np.unravel_index(np.argmax(error), error.shape)
                raise NotMet(int(function), points[n, tested][worst].tolist(), float(error[function, worst]))
            following += [_half(level, place, axis, side) for side in (0, 1)]
        open_ = following
        if report is not None:
            report(len(accurate), len(accurate) + len(open_))
    levels, places, coefficients, errors = (np.array(part) for part in zip(*accurate, strict=True))
    return levels, places, coefficients, errors.max(axis=0)


def _grid(*axes: Array) -> Array:
    """Return all combinations of numbers of arrays, shape (n, n_variable)."""
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))


def _values(series: Array, x: Array, degree: int) -> Array:
    """Return the values of series at places, shape (n, n_variable), in one box."""
    axes = range(2, 2 + x.shape[1])
    operands: list[Any] = [series, [0, *axes]]
    for axis in axes:
        operands += [chebvander(x[:, axis - 2], degree), [1, axis]]
    return np.asarray(np.einsum(*operands, [0, 1]))


def _roughest(series: Array) -> int:
    """Return the variable whose last two orders are largest in all functions."""
    last = [np.abs(np.take(series, [-2, -1], axis)).sum() for axis in range(1, series.ndim)]
    return int(np.argmax(last))


def _half(level: tuple[int, ...], place: tuple[int, ...], axis: int, side: int) -> Any:
    """Return the level and the place of half of a box."""
    finer, at = list(level), list(place)
    finer[axis] += 1
    at[axis] = 2 * at[axis] + side
    return tuple(finer), tuple(at)


def fill(boxes: Boxes) -> bool:
    """Return whether boxes are halves of halves of their rectangle, and fill it once."""
    low, high, levels, places, coefficients = boxes
    count, terms = len(levels), OF_BOXES.degree + 1
    if not (low.shape == high.shape == (2,) and coefficients.shape == (count, terms, terms)):
        return False
    if not (0 < count <= OF_BOXES.most + 1 and levels.shape == places.shape == (count, 2) and np.all(low < high)):
        return False
    if np.any(levels < 0) or np.any(levels > OF_BOXES.deepest) or np.any(places < 0) or np.any(places >= 2**levels):
        return False
    # The areas are powers of two.
    return float(np.sum(0.5 ** levels.sum(axis=1))) == 1.0 and bool(np.all(cell_grid(levels, places) >= 0))


def ready(boxes: Boxes) -> tuple[Any, ...]:
    """Prepare boxes for `box_value`, as a plain tuple."""
    low, high, levels, places, coefficients = boxes
    cells = cell_grid(levels, places)
    width = (high - low) * 0.5**levels
    scale = np.array(cells.shape) / (high - low)
    return low, scale, cells, low + width * (places + 0.5), 2.0 / width, np.ascontiguousarray(coefficients)


@compiled
def box_value(x: float, y: float, boxes: Any) -> float:
    """Return the value of boxes at a point; a point outside of the rectangle belongs to the box beside it."""
    low, scale, cells, middle, inverse, coefficients = boxes
    i = min(max(int((x - low[0]) * scale[0]), 0), cells.shape[0] - 1)
    j = min(max(int((y - low[1]) * scale[1]), 0), cells.shape[1] - 1)
    box = cells[i, j]
    s = (x - middle[box, 0]) * inverse[box, 0]
    t = (y - middle[box, 1]) * inverse[box, 1]
    last, before = 0.0, 0.0
    for a in range(coefficients.shape[1] - 1, -1, -1):
        inner, earlier = 0.0, 0.0
        for b in range(coefficients.shape[2] - 1, 0, -1):
            inner, earlier = (coefficients[box, a, b] - earlier) + 2.0 * t * inner, inner
        over_y = (coefficients[box, a, 0] - earlier) + t * inner
        if a == 0:
            return (over_y - before) + s * last
        last, before = (over_y - before) + 2.0 * s * last, last
    return 0.0
