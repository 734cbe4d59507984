"""Make the data of `restitution.standard_solid_surrogate` and measure their error.

Run as `python validation/standard_solid_surrogate.py [FILE]`. It takes half a minute. It writes the data to FILE, by
default to the file of the package, unless the error at 200 000 random points is larger than stated.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution import standard_solid_restitution
from restitution.files import whole_file
from restitution.surrogates import standard_solid
from restitution.surrogates.standard_solid import P2, P3, STATED_ERROR, TERMS, corners, groups, ready_boxes

Array = NDArray[np.float64]
Progress = Callable[[int, int], None]
Triple = tuple[int, int, int]
Box = tuple[Triple, Triple]

DATA = Path(standard_solid.__file__).parent / "data" / "standard_solid.npz"
TOLERANCE = 5e-7
"""Tolerance of the boxes at their test points. The stated error is measured at many more points."""

RTOL = 1e-9
POINTS = 200_000
SEED = 11
HALVED = (1, 0, 0)
"""Initial number of halvings of each variable; the coordinates change at the middle of x."""

# A box that only touches the plane belongs to it.
_MARGIN = 1e-6
_DEEPEST = 14
_EDGE = 1.0 - 1e-9
_ANGLES = np.pi * (np.arange(TERMS) + 0.5) / TERMS
_TO_COEFFICIENTS = 2.0 / TERMS * np.cos(np.outer(np.arange(TERMS), _ANGLES))
_TO_COEFFICIENTS[0] *= 0.5


class Series(NamedTuple):
    """Tensor Chebyshev series in boxes; see `restitution.surrogates.standard_solid.ready_boxes`."""

    levels: NDArray[np.int64]
    places: NDArray[np.int64]
    coefficients: NDArray[np.float32]


def make_boxes(tolerance: float = TOLERANCE, progress: Progress | None = None) -> Series:
    """Interpolate e over the plane, halving boxes until the error is below the tolerance where it is tested."""
    low, high = corners()
    nodes = np.stack(np.meshgrid(*[np.cos(_ANGLES)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    tests = _test_points()
    basis = np.cos(np.arange(TERMS)[:, None, None] * np.arccos(tests))
    open_: list[Box] = [(HALVED, (i, j, k)) for i, j, k in np.ndindex(*(2**n for n in HALVED))]
    done: list[tuple[Box, NDArray[np.float32]]] = []
    while open_:
        levels, places = (np.array(part) for part in zip(*open_, strict=True))
        width = (high - low) * 0.5**levels
        corner = low + width * places
        points = corner[:, None, :] + width[:, None, :] * (0.5 * (np.vstack([nodes, tests]) + 1.0))
        matters = _in_the_plane(points.reshape(-1, 3)).reshape(points.shape[:2])
        expected = matters.any(axis=1)
        exact = standard_solid_restitution(*groups(points[expected].reshape(-1, 3)), rtol=RTOL, errors="raise")
        values = exact.reshape(-1, points.shape[1])
        cubes = values[:, : len(nodes)].reshape(-1, TERMS, TERMS, TERMS)
        M = _TO_COEFFICIENTS
        coefficients = np.einsum("ai,bj,ck,nijk->nabc", M, M, M, cubes, optimize=True).astype(np.float32)
        approximate = np.einsum("ap,bp,cp,nabc->np", *np.moveaxis(basis, 2, 0), coefficients, optimize=True)
        error = np.abs(approximate - values[:, len(nodes) :])
        error = np.where(matters[expected][:, len(nodes) :], error, 0.0).max(axis=1)
        following: list[Box] = []
        for n, box in enumerate(np.flatnonzero(expected)):
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
    return Series(levels, places, np.array([box[1] for box in done]))


def _in_the_plane(points: Array) -> NDArray[np.bool_]:
    log_p3 = np.log10(groups(points)[2])
    return np.abs(log_p3 - np.mean(np.log10(P3))) <= 0.5 * np.ptp(np.log10(P3)) + _MARGIN


def _test_points() -> Array:
    """Test points: corners, where interpolation in Chebyshev points is worst, and random points, also on the faces."""
    at_corners = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    rng = np.random.default_rng(3)
    anywhere, faces = rng.uniform(-1.0, 1.0, (64, 3)), rng.uniform(-1.0, 1.0, (64, 3))
    faces[np.arange(64), np.arange(64) % 3] = np.where(np.arange(64) % 2, 1.0, -1.0)
    # Rounding must not move a point beyond a face, because another function may begin there.
    return np.clip(np.vstack([at_corners, anywhere, faces]), -_EDGE, _EDGE)


def _slowest_decay(coefficients: NDArray[np.float32]) -> int:
    """Variable whose last coefficients are largest."""
    tails = [np.linalg.norm(np.moveaxis(coefficients, axis, 0)[-2:]) for axis in range(3)]
    return int(np.argmax(tails))


def _half(level: Triple, place: Triple, axis: int, side: int) -> Box:
    levels, places = list(level), list(place)
    levels[axis] += 1
    places[axis] = 2 * places[axis] + side
    return (levels[0], levels[1], levels[2]), (places[0], places[1], places[2])


def random_groups(n: int, seed: int) -> tuple[Array, Array, Array]:
    """Draw nu, p2, p3 in the plane: nu is uniform, close to 1/2, or uniform in x for a third of the points each."""
    rng = np.random.default_rng(seed)
    p2, p3 = (10.0 ** rng.uniform(np.log10(ends[0]), np.log10(ends[1]), n) for ends in (P2, P3))
    close = 0.5 - 0.5 * 10.0 ** rng.uniform(-7.0, 0.0, n)
    spread = groups(np.column_stack([rng.uniform(0.0, 1.0, n), np.log10(p2), np.zeros(n)]))[0]
    kind = rng.integers(0, 3, n)
    return np.choose(kind, [rng.uniform(-1.0, 0.5, n), close, spread]), p2, p3


def measured_error(series: Series, n: int, seed: int) -> float:
    """Largest error of e at random points of the plane."""
    nu, p2, p3 = random_groups(n, seed)
    e = np.empty(n)
    standard_solid.restitution(nu, p2, p3, ready_boxes(*series), e)
    return float(np.abs(e - standard_solid_restitution(nu, p2, p3, rtol=RTOL, errors="raise")).max())


def write_file(path: Path, series: Series, error: float) -> None:
    """Write the data in one step; the bytes depend on the numbers only."""
    content: dict[str, Any] = {
        "levels": series.levels.astype(np.int8),
        "places": series.places.astype(np.int16),
        "coefficients": series.coefficients,
    }
    with whole_file(path) as partial, partial.open("wb") as file:
        np.savez_compressed(file, error=error, **content)


def main(arguments: list[str]) -> None:
    """Make the data and write them."""
    path = Path(arguments[0]) if arguments else DATA

    def progress(done: int, total: int) -> None:
        print(f"{done} of {total} boxes are within {TOLERANCE:g}", flush=True)

    series = make_boxes(progress=progress)
    error = measured_error(series, POINTS, SEED)
    print(f"largest error at {POINTS} random points: {error:.2g}, stated: {STATED_ERROR:g}")
    if error > STATED_ERROR:
        raise SystemExit("nothing is written: more than stated")
    write_file(path, series, error)
    print(f"{path}: {len(series.levels)} boxes, {path.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main(sys.argv[1:])
