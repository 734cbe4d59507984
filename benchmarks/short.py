"""Speed of this machine: `python benchmarks/short.py`, with `--quick` for a first look.

It prints mean, median and worst time over the paper's plane and for a long Prony series (processor time of one
thread), the mean on all cores, and the time of SciPy. The errors refer to solves at rtol 1e-11.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from machine import describe
from problems import Problems, StandardSolids, even_prony, plane
from timing import EXACT, Speed, clock, one_by_one, speed

from restitution import Impact, Parabola, standard_solid

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from scipy_oracle import solve_by_scipy

Progress = Callable[[int, int], None]

DEFAULT_RTOL = 1e-9
RTOL = 1e-8
# Tolerance of SciPy's integrator, for the same accuracy of e as the exact method at 1e-8.
SCIPY_RTOL = 1e-7
TERMS = 20


class Size(NamedTuple):
    """Extent of the measurement: impacts in array calls, single impacts, repeats, solves by SciPy.

    For Prony series, which take longer, the first two are a tenth and a quarter of these.
    """

    impacts: int
    alone: int
    repeats: int
    reference: int


FULL = Size(20_000, 300, 3, 6)
QUICK = Size(4_000, 50, 2, 2)


class Summary(NamedTuple):
    """Speed by problem and tolerance, time on all cores, time of SciPy.

    Attributes
    ----------
    speeds : dict of (str, float) to Speed
        By problem and rtol.
    cores : int
        Number of threads on all cores.
    parallel : float
        Mean wall-clock time [s] of an impact of the plane on all cores at rtol 1e-8.
    reference : float
        Mean time [s] of an impact of the plane by SciPy's implicit Radau method at its rtol 1e-7.
    reference_error : float
        Largest error of these e.
    reference_same : float
        Mean time [s] of the same impacts by the exact method at rtol 1e-8, each in a call of many copies.
    """

    speeds: dict[tuple[str, float], Speed]
    cores: int
    parallel: float
    reference: float
    reference_error: float
    reference_same: float


def measure(size: Size, progress: Progress = lambda done, total: None) -> Summary:
    """Measure all entries of the table."""
    points = plane(size.impacts)
    long_series = even_prony(TERMS, size.impacts // 10)
    cases: dict[tuple[str, float], tuple[Problems, int]] = {
        ("paper's plane", RTOL): (points, size.alone),
        ("paper's plane", DEFAULT_RTOL): (points, size.alone),
        (f"Prony, {TERMS} terms", RTOL): (long_series, size.alone // 4),
    }
    # In units of one impact in an array call, SciPy takes some ten thousand and a single impact some hundred.
    weight = 30
    total = sum(alone + 1 for _, alone in cases.values()) + size.repeats + weight * size.reference
    done = 0

    def advance(steps: int = 1) -> None:
        nonlocal done
        done += steps
        progress(done, total)

    # The kernel must be loaded or compiled before any timing.
    plane(1).solve(RTOL)
    progress(0, total)
    speeds = {
        (name, rtol): speed(problems, rtol, alone=alone, copies=128, repeats=size.repeats, advance=advance)
        for (name, rtol), (problems, alone) in cases.items()
    }
    cores = os.cpu_count() or 1
    parallel = _on_the_wall(points, cores, size.repeats, advance)
    by_scipy = _by_scipy(plane(size.reference, seed=7), lambda: advance(weight))
    return Summary(speeds, cores, parallel, *by_scipy)


def _on_the_wall(points: StandardSolids, workers: int, repeats: int, advance: Callable[[], None]) -> float:
    """Mean time [s] of an impact, by the clock on the wall."""
    shortest = float("inf")
    for _ in range(repeats):
        start = time.perf_counter()
        points.solve(RTOL, workers)
        shortest = min(shortest, time.perf_counter() - start)
        advance()
    return shortest / points.size


def _by_scipy(points: StandardSolids, advance: Callable[[], None]) -> tuple[float, float, float]:
    """Mean time [s] of an impact by SciPy, the largest error of e, and the mean time [s] by the exact method."""
    exact = points.solve(EXACT)
    seconds, errors = [], []
    for n in range(points.size):
        nu, p2, p3 = (float(column[n]) for column in (points.nu, points.p2, points.p3))
        impact = Impact(standard_solid(1.0, 1.0 / p2, p3, poisson_ratio=nu), Parabola(1.0), mass=1.0, velocity=1.0)
        start = clock()
        e = solve_by_scipy(impact, SCIPY_RTOL).restitution_coefficient
        seconds.append(clock() - start)
        errors.append(abs(e - exact[n]))
        advance()
    same = one_by_one(points, range(points.size), RTOL, copies=256, repeats=3)
    return sum(seconds) / points.size, float(max(errors)), float(same.mean())


def table(summary: Summary) -> str:
    """Return the table as text."""
    rows = [("problem", "rtol", "mean [us]", "median [us]", "worst [us]", "error of e", "error/tolerance")]
    for (name, rtol), pace in summary.speeds.items():
        times = (f"{1e6 * seconds:.1f}" for seconds in (pace.mean, pace.median, pace.worst))
        rows.append((name, f"{rtol:g}", *times, f"{pace.error:.1e}", f"{pace.share:.2f}"))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ["  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]
    (first, *_) = summary.speeds.values()
    if summary.cores > 1:
        lines.append(
            f"paper's plane on {summary.cores} cores: {1e6 * summary.parallel:.1f} us an impact, "
            f"{first.mean / summary.parallel:.2f} times as fast as on one"
        )
    lines.append(
        f"the same equations by SciPy's solve_ivp, Radau: {1e3 * summary.reference:.0f} ms an impact for an error of "
        f"{summary.reference_error:.1e}, {summary.reference / summary.reference_same:.0f} times as long"
    )
    return "\n".join(lines)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer impacts, for a first look")
    size = QUICK if parser.parse_args().quick else FULL
    shown = sys.stderr.isatty()

    def progress(done: int, total: int) -> None:
        if shown:
            print(f"\rmeasuring {100 * done // total:3d} %", end="" if done < total else "\n", file=sys.stderr)

    result = measure(size, progress)
    print("\n".join(describe().lines()))
    print(table(result))


if __name__ == "__main__":
    main()
