"""Make the data of `standard_solid_surrogate`: `python -m restitution.surrogates.make [FILE]`, half a minute."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from restitution.impact.solve import standard_solid_restitution
from restitution.surrogates.boxes import Boxes, Progress, build_boxes
from restitution.surrogates.plane import HALVED, P2, P3, Grid, corners, groups, ready, restitution
from restitution.surrogates.standard_solid import STATED_ERROR

Array = NDArray[np.float64]

TOLERANCE = 5e-7
"""Of boxes, at the points where they are tested; what is stated is seen at many more."""

_RTOL = 1e-9
_POINTS = 200_000
_SEED = 11
# A box that only touches the plane belongs to it.
_MARGIN = 1e-6


def make_boxes(tolerance: float = TOLERANCE, progress: Progress | None = None) -> Boxes:
    """Interpolate e over the plane.

    Parameters
    ----------
    tolerance : float
        Largest error of e allowed where boxes are tested.
    progress : callable, optional
        See `restitution.surrogates.boxes.build_boxes`.
    """

    def sample(points: Array) -> Array:
        return standard_solid_restitution(*groups(points), rtol=_RTOL, errors="raise")

    def inside(points: Array) -> NDArray[np.bool_]:
        log_p3 = np.log10(groups(points)[2])
        return np.abs(log_p3 - np.mean(np.log10(P3))) <= 0.5 * np.ptp(np.log10(P3)) + _MARGIN

    return build_boxes(sample, inside, *corners(), tolerance, halved=HALVED, progress=progress)


def random_groups(n: int, seed: int) -> tuple[Array, Array, Array]:
    """Draw nu, p2, p3 in the plane: a third of nu uniform, a third close to 1/2, a third spread in x."""
    rng = np.random.default_rng(seed)
    p2, p3 = (10.0 ** rng.uniform(np.log10(ends[0]), np.log10(ends[1]), n) for ends in (P2, P3))
    close = 0.5 - 0.5 * 10.0 ** rng.uniform(-7.0, 0.0, n)
    spread = groups(np.column_stack([rng.uniform(0.0, 1.0, n), np.log10(p2), np.zeros(n)]))[0]
    kind = rng.integers(0, 3, n)
    return np.choose(kind, [rng.uniform(-1.0, 0.5, n), close, spread]), p2, p3


def measured_error(grid: Grid, n: int, seed: int) -> float:
    """Largest error of e at random points of the plane."""
    nu, p2, p3 = random_groups(n, seed)
    e = np.empty(n)
    restitution(nu, p2, p3, *grid, e)
    return float(np.abs(e - standard_solid_restitution(nu, p2, p3, rtol=_RTOL, errors="raise")).max())


def write_file(path: Path, boxes: Boxes, error: float) -> None:
    """Write the data, whole or not at all; the bytes depend on the numbers alone."""
    from restitution.files import whole_file

    with whole_file(path) as partial, partial.open("wb") as file:
        np.savez_compressed(
            file, error=error, levels=boxes.levels.astype(np.int8), places=boxes.places.astype(np.int16),
            coefficients=boxes.coefficients,
        )  # fmt: skip


def main(arguments: list[str]) -> None:
    """Make the data and write them where the package has them, or to the file that is named."""
    path = Path(arguments[0]) if arguments else Path(__file__).parent / "data" / "standard_solid.npz"

    def progress(done: int, total: int) -> None:
        print(f"{done} of {total} boxes are within {TOLERANCE:g}", flush=True)

    boxes = make_boxes(progress=progress)
    error = measured_error(ready(boxes), _POINTS, _SEED)
    print(f"largest error at {_POINTS} random points: {error:.2g}, stated: {STATED_ERROR:g}")
    if error > STATED_ERROR:
        raise SystemExit("nothing is written: more than stated")
    write_file(path, boxes, error)
    print(f"{path}: {len(boxes.levels)} boxes, {path.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main(sys.argv[1:])
