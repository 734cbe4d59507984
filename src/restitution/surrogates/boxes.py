"""Chebyshev series of two variables in boxes, which are halved until the error is small."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial.chebyshev import chebpts1, chebpts2, chebvander
from numpy.typing import NDArray

from restitution.checks import Array
from restitution.surrogates.standard_solid import cell_grid, compiled

DEGREE = 8
MOST, DEEPEST = 256, 10
"""Degree of the series in both variables, the most boxes, and the most halvings of a box in one variable."""

# Points in each box for the measurement of the error: half-way between nodes, some at random, and a factor for the
# error between them.
_FRESH = 24
_BETWEEN_POINTS = 2.0
_NODES = chebpts2(DEGREE + 1)
_TO_COEFFICIENTS = np.linalg.inv(chebvander(_NODES, DEGREE))
_BETWEEN = chebpts1(DEGREE)

IntArray = NDArray[np.int64]


class Boxes(NamedTuple):
    """Boxes of a rectangle of x and y.

    A box begins at `low + (high - low) places/2^levels` and is `(high - low)/2^levels` wide; `levels` and `places`
    have the shape (n_box, 2). `coefficients` have the shape (n_box, DEGREE + 1, DEGREE + 1), those of x first.
    """

    low: Array
    high: Array
    levels: IntArray
    places: IntArray
    coefficients: Array


def fill(boxes: Boxes) -> bool:
    """Return whether boxes are halves of halves of their rectangle, and fill it once."""
    low, high, levels, places, coefficients = boxes
    count = len(levels)
    if not (low.shape == high.shape == (2,) and coefficients.shape == (count, DEGREE + 1, DEGREE + 1)):
        return False
    if not (0 < count <= MOST + 1 and levels.shape == places.shape == (count, 2) and np.all(low < high)):
        return False
    if np.any(levels < 0) or np.any(levels > DEEPEST) or np.any(places < 0) or np.any(places >= 2**levels):
        return False
    # The areas are powers of two.
    return float(np.sum(0.5 ** levels.sum(axis=1))) == 1.0 and bool(np.all(cell_grid(levels, places) >= 0))


class NotMet(Exception):
    """Error above the tolerance in the smallest box, or with the most boxes: place and error."""

    def __init__(self, x: float, y: float, error: float) -> None:
        super().__init__(f"error {error:.2g} at {x:g}, {y:g}")
        self.x, self.y, self.error = x, y, error


def build_boxes(
    sample: Callable[[Array, Array], Array], low: Array, high: Array, tolerance: float,
    report: Callable[[int, int], None] | None = None,
) -> tuple[Boxes, float]:  # fmt: skip
    """Interpolate a function of x and y in boxes, halved until the absolute error is at most the tolerance.

    `sample` returns its values at n points. A box is halved in the variable whose series ends with the larger terms.
    The second result is twice the largest error at points that are no nodes.
    """
    rng = np.random.default_rng(22)
    nodes, between = _grid(_NODES, _NODES), _grid(_BETWEEN[::2], _BETWEEN)
    open_ = [((0, 0), (0, 0))]
    accurate: list[tuple[Any, Any, Array, float]] = []
    while open_:
        levels, places = (np.array(part) for part in zip(*open_, strict=True))
        width = (high - low) * 0.5**levels
        local = np.concatenate([
            np.broadcast_to(np.concatenate([nodes, between]), (len(open_), len(nodes) + len(between), 2)),
            rng.uniform(-1.0, 1.0, (len(open_), _FRESH, 2)),
        ], axis=1)  # fmt: skip
        # Rounding must not move a point out of the rectangle.
        points = np.clip((low + width * places)[:, None] + 0.5 * width[:, None] * (local + 1.0), low, high)
        exact = sample(*points.reshape(-1, 2).T).reshape(len(open_), -1)
        following = list[Any]()
        for n, (level, place) in enumerate(open_):
            values = exact[n, : len(nodes)].reshape(_NODES.size, _NODES.size)
            series = _TO_COEFFICIENTS @ values @ _TO_COEFFICIENTS.T
            u, v = (chebvander(local[n, len(nodes) :, axis], DEGREE) for axis in (0, 1))
            errors = np.abs(np.einsum("pa,ab,pb->p", u, series, v) - exact[n, len(nodes) :])
            worst = int(np.argmax(np.nan_to_num(errors, nan=np.inf)))
            error = _BETWEEN_POINTS * float(errors[worst])
            if error <= tolerance:
                accurate.append((level, place, series, error))
                continue
            axis = _rougher(series)
            if level[axis] == DEEPEST or len(accurate) + len(following) > MOST:
                x, y = points[n, len(nodes) + worst].tolist()
                raise NotMet(x, y, error)
            following += [_half(level, place, axis, side) for side in (0, 1)]
        open_ = following
        if report is not None:
            report(len(accurate), len(accurate) + len(open_))
    levels, places, coefficients, errors = (np.array(part) for part in zip(*accurate, strict=True))
    return Boxes(low, high, levels, places, coefficients), float(errors.max())


def _grid(x: Array, y: Array) -> Array:
    """Return all pairs of two arrays, shape (n, 2)."""
    return np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)


def _rougher(series: Array) -> int:
    """Return the variable whose last two orders are larger."""
    return int(np.abs(series[:, -2:]).sum() > np.abs(series[-2:]).sum())


def _half(level: tuple[int, int], place: tuple[int, int], axis: int, side: int) -> Any:
    """Return the level and the place of half of a box."""
    finer, at = list(level), list(place)
    finer[axis] += 1
    at[axis] = 2 * at[axis] + side
    return tuple(finer), tuple(at)


def ready(boxes: Boxes) -> tuple[Any, ...]:
    """Prepare boxes for `box_value`, as a plain tuple."""
    low, high, levels, places, coefficients = boxes
    cells = cell_grid(levels, places)
    width = (high - low) * 0.5**levels
    scale = np.array(cells.shape) / (high - low)
    return low, scale, cells, low + width * (places + 0.5), 2.0 / width, np.ascontiguousarray(coefficients)


@compiled
def box_value(x: float, y: float, boxes: Any) -> float:
    """Return the value of boxes at a point; one outside of the rectangle belongs to the box beside it."""
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
