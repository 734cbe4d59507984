"""Times of histories of any kind: impacts on one spot, programs, measured records, tapping.

`python benchmarks/histories.py` takes half a minute and prints the table of docs/benchmarks.md: processor time of one
thread, the shortest of repeated calls, with a compiled kernel. All are whole calls from Python at the default
tolerance, unless the table states another.
"""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

import restitution as rs
from restitution.indentation.cantilever import cantilever, pull_of
from restitution.indentation.solve import contact_of
from restitution.indentation.tapping import Tapper

GEL = rs.standard_solid(1e3, 2e3, 2e2, poisson_ratio=0.5)
TIP = rs.Parabola(2.5e-6)
BALL = rs.Impact(rs.standard_solid(1e6, 4e6, 4e3, poisson_ratio=0.5), rs.Parabola(0.01), mass=0.005, velocity=0.5)


def seconds(call: Callable[[], Any], repeats: int = 15) -> float:
    """Shortest processor time of a call, after a first one."""
    call()
    times: list[float] = []
    for _ in range(repeats):
        start = time.process_time()
        call()
        times.append(time.process_time() - start)
    return min(times)


def impacts() -> list[tuple[str, float]]:
    """A first impact, and one on the spot that it has left."""
    surface = rs.solve(BALL, rtol=1e-8).surface(after=0.001)
    first = seconds(lambda: rs.solve(BALL, rtol=1e-8))
    again = seconds(lambda: rs.solve(BALL, rtol=1e-8, surface=surface))
    return [("impact on a virgin surface", first), ("impact on the spot of an earlier one", again)]


def ripples(count: int) -> tuple[Any, Any]:
    """Times and depths of an approach, ripples of a fifth of the depth, and a retraction, in straight lines."""
    peaks = 1e-6 * np.tile([1.0, 0.8], count)
    depths = np.concatenate([[0.0], peaks, [1e-6, -2e-7]])
    return np.arange(depths.size) / 20.0, depths


def programs() -> list[tuple[str, float]]:
    """One cycle, and 20 ripples at 480 times."""
    t, d = ripples(20)
    moments = np.linspace(0.0, t[-1], 480)
    cycle = rs.triangle(1e-6, 1.0)
    return [
        ("one cycle, 401 times", seconds(lambda: rs.indent(GEL, TIP, depth=cycle))),
        ("20 ripples, 480 times", seconds(lambda: rs.indent(GEL, TIP, depth=d, time=t).sample(moments))),
    ]


def record(size: int) -> rs.IndentationCurve:
    """Record of a rippled program with 20 pN of noise of the force, and 1 nm of the depth."""
    random = np.random.default_rng(5)
    t, d = ripples(5)
    t, d = np.concatenate([[0.0], t + 0.5]), np.concatenate([[-3e-6], d])
    moments = np.linspace(0.0, t[-1], size)
    force = rs.indent(GEL, TIP, depth=d, time=t).sample(moments).force.values
    depth = np.interp(moments, t, d) + 1e-9 * random.standard_normal(size)
    return rs.IndentationCurve(moments, depth, force + 2e-11 * random.standard_normal(size), profile=TIP)


def records() -> list[tuple[str, float]]:
    """One evaluation of a noisy record, and a whole fit."""
    curve = record(2000)
    nuisances = np.array([[0.0]])
    rows = [("fit of a standard solid to a noisy record of 2000 samples",
             seconds(lambda: rs.identify(curve, rs.standard_solid, fixed={"poisson_ratio": 0.5}), 3))]  # fmt: skip
    return [("forces of a noisy record of 2000 samples", seconds(lambda: curve.forces(GEL, nuisances))), *rows]


def tapping() -> list[tuple[str, float]]:
    """One tap, and a curve of 50 distances at Q = 100."""
    solid = rs.Material(rs.PronySeries(0.25, [1.0], [1.0]), bulk=math.inf)
    options = {"spring_constant": 1.0, "frequency": 0.5 / math.pi, "free_amplitude": 1.0}
    distances, tip = np.linspace(1.0, 0.51, 50), rs.Parabola(1.0)
    curve = rs.tap(solid, tip, distances, quality_factor=100.0, **options)
    assert curve.taps.min() >= 0
    spent = seconds(lambda: rs.tap(solid, tip, distances, quality_factor=100.0, **options), 2)
    taps = int(curve.taps.sum())
    rows = [("one tap", one_tap(solid, tip)), ("tapping at Q = 100, 50 distances", spent)]
    return [*rows, (f"one of its {taps} taps, and the search for the steady motion", spent / taps)]


def one_tap(solid: rs.Material, tip: rs.Parabola) -> float:
    """Time of the fifth tap at one distance, on the surface that the others have left."""
    contact = contact_of(solid, tip, None)
    lever = cantilever(1.0, 100.0, 0.5 / math.pi, None, 1.0, None, ())
    tapper = Tapper(contact, lever, pull_of(None, 1.65e-10, contact.profile), 1e-8)
    start = tapper.free(0.8)
    for _ in range(4):
        start = tapper.end(tapper.run(0.8, start))
    return seconds(lambda: tapper.run(0.8, start), 100)


def main() -> None:
    """Print the table."""
    warnings.simplefilter("ignore")
    print("| what | time [ms] |\n|---|---|")
    for section in (impacts, programs, records, tapping):
        for words, spent in section():
            print(f"| {words} | {1e3 * spent:.2g} |", flush=True)


if __name__ == "__main__":
    main()
