"""A function of three variables as tensor Chebyshev series in boxes, built adaptively."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Progress = Callable[[int, int], None]

TERMS = 8
"""Terms of the series in each variable."""

_DEEPEST = 14
_EDGE = 1.0 - 1e-9
_ANGLES = np.pi * (np.arange(TERMS) + 0.5) / TERMS
_TO_COEFFICIENTS = 2.0 / TERMS * np.cos(np.outer(np.arange(TERMS), _ANGLES))
_TO_COEFFICIENTS[0] *= 0.5


Triple = tuple[int, int, int]
Box = tuple[Triple, Triple]


class Boxes(NamedTuple):
    """Tensor Chebyshev series in boxes, which come of halving the whole along one variable after another.

    Attributes
    ----------
    low, high : array, shape (3,)
        Corners of the whole.
    levels, places : array of int, shape (n_box, 3)
        Box n begins at `low + (high - low) places[n]/2^levels[n]` and is `(high - low)/2^levels[n]` wide.
    coefficients : array, shape (n_box, TERMS, TERMS, TERMS)
        Of products of Chebyshev polynomials in the local variables, which run from -1 to 1.
    """

    low: Array
    high: Array
    levels: Integers
    places: Integers
    coefficients: NDArray[np.float32]


def build_boxes(
    sample: Callable[[Array], Array],
    inside: Callable[[Array], NDArray[np.bool_]],
    low: Array,
    high: Array,
    tolerance: float,
    *,
    halved: tuple[int, int, int] = (0, 0, 0),
    progress: Progress | None = None,
) -> Boxes:
    """Interpolate a function of three variables in boxes, halving them until the error is met.

    Parameters
    ----------
    sample : callable
        Takes points, shape (n, 3), and returns values, shape (n,).
    inside : callable
        Takes points and says which of them matter: boxes without any are left out.
    low, high : array, shape (3,)
        Corners of the whole.
    tolerance : float
        Largest absolute error at the points where each box is tested.
    halved : tuple of int
        How often each variable is halved to begin with: the function may be discontinuous there.
    progress : callable, optional
        Called with (boxes that meet it, all boxes) after each round.

    Returns
    -------
    Boxes

    Raises
    ------
    ValueError
        If a box is missed after a variable was halved fourteen times.
    """
    nodes = np.stack(np.meshgrid(*[np.cos(_ANGLES)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    tests = _test_points()
    basis = np.cos(np.arange(TERMS)[:, None, None] * np.arccos(tests))
    open_: list[Box] = [
        (halved, (i, j, k)) for i, j, k in np.ndindex(2 ** halved[0], 2 ** halved[1], 2 ** halved[2])
    ]
    done: list[tuple[Box, NDArray[np.float32]]] = []
    while open_:
        levels, places = (np.array(part) for part in zip(*open_, strict=True))
        width = (high - low) * 0.5**levels
        corner = low + width * places
        local = 0.5 * (np.vstack([nodes, tests]) + 1.0)
        points = corner[:, None, :] + width[:, None, :] * local
        matters = inside(points.reshape(-1, 3)).reshape(points.shape[:2])
        wanted = matters.any(axis=1)
        values = sample(points[wanted].reshape(-1, 3)).reshape(-1, points.shape[1])
        cubes = values[:, : len(nodes)].reshape(-1, TERMS, TERMS, TERMS)
        M = _TO_COEFFICIENTS
        coefficients = np.einsum("ai,bj,ck,nijk->nabc", M, M, M, cubes, optimize=True).astype(np.float32)
        approximate = np.einsum("ap,bp,cp,nabc->np", *np.moveaxis(basis, 2, 0), coefficients, optimize=True)
        error = np.abs(approximate - values[:, len(nodes) :])
        error = np.where(matters[wanted][:, len(nodes) :], error, 0.0).max(axis=1)
        following: list[Box] = []
        for n, box in enumerate(np.flatnonzero(wanted)):
            level, place = open_[box]
            if error[n] <= tolerance:
                done.append(((level, place), coefficients[n]))
                continue
            axis = _slowest_decay(coefficients[n])
            if level[axis] == _DEEPEST:
                raise ValueError(f"error {error[n]:.2g} near {corner[box]}: exceeds {tolerance:g}")
            following += [_half(level, place, axis, side) for side in (0, 1)]
        open_ = following
        if progress is not None:
            progress(len(done), len(done) + len(open_))
    done.sort(key=lambda box: box[0])
    levels, places = (np.array([box[0][part] for box in done]) for part in (0, 1))
    return Boxes(low, high, levels, places, np.array([box[1] for box in done]))


def boxes_of_cells(boxes: Boxes) -> NDArray[np.int16]:
    """Return the box of each cell of the grid on which all boxes lie; -1 where there is none."""
    finest = boxes.levels.max(axis=0)
    cells = np.full(tuple(2**finest), -1, dtype=np.int16)
    for n, (level, place) in enumerate(zip(boxes.levels, boxes.places, strict=True)):
        first = place * 2 ** (finest - level)
        cells[tuple(slice(a, a + 2**b) for a, b in zip(first, finest - level, strict=True))] = n
    return cells


def _test_points() -> Array:
    """Corners, where series through Chebyshev points are worst, and random points, some of them at the faces."""
    corners = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    rng = np.random.default_rng(3)
    anywhere, faces = rng.uniform(-1.0, 1.0, (64, 3)), rng.uniform(-1.0, 1.0, (64, 3))
    faces[np.arange(64), np.arange(64) % 3] = np.where(np.arange(64) % 2, 1.0, -1.0)
    # Not beyond the faces by rounding, for another function may begin there.
    return np.clip(np.vstack([corners, anywhere, faces]), -_EDGE, _EDGE)


def _slowest_decay(coefficients: NDArray[np.float32]) -> int:
    """Variable whose last coefficients are largest."""
    tails = [np.linalg.norm(np.moveaxis(coefficients, axis, 0)[-2:]) for axis in range(3)]
    return int(np.argmax(tails))


def _half(level: Triple, place: Triple, axis: int, side: int) -> Box:
    levels, places = list(level), list(place)
    levels[axis] += 1
    places[axis] = 2 * places[axis] + side
    return (levels[0], levels[1], levels[2]), (places[0], places[1], places[2])
