"""Surrogates: error, size and time of a query, and the time of the kernel, on one thread in one run.

`pytest benchmarks/test_surrogate.py` writes `surrogate.md`, the table of the page on surrogates.
"""

import runpy
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numba
import numpy as np
import pytest

import restitution as rs
from restitution.surrogates import standard_solid
from restitution.surrogates.velocity import OUTPUTS

POINTS = 20_000
KERNEL_POINTS = 500
RANGE = (1e-3, 10.0)
TABLE = Path(__file__).parent / "surrogate.md"
PLANE = runpy.run_path(str(Path(__file__).parents[1] / "validation" / "standard_solid_surrogate.py"))
DATA = Path(standard_solid.__file__).parent / "data" / "standard_solid.npz"

# Processor time, which depends little on other load of the machine.
pytestmark = pytest.mark.benchmark(timer=time.process_time)

BALL = rs.Impact(rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45), rs.Parabola(0.01), 0.005, 1.0)
IMPACTS = {
    "ball on a standard solid": BALL,
    "ball on epoxy, 24 terms": rs.Impact(rs.library.get("epoxy"), rs.Parabola(0.01), 0.01, 1.0),
    "truncated cone (a kink)": replace(BALL, profile=rs.TruncatedCone(1e-4, 1.2)),
}


class Subject(NamedTuple):
    """A surrogate, and the kernel for the same problem."""

    name: str
    size: int
    stated: float
    measured: float
    pieces: int
    query: Callable[[], Any]
    in_c: Callable[[], Any] | None
    kernel: Callable[[], Any]


def over_velocity(name: str, folder: Path) -> Subject:
    """Surrogate over the velocity, and the largest error of its three outputs at 5000 other velocities."""
    impact = IMPACTS[name]
    surrogate = rs.surrogate(impact, RANGE, 1e-6)
    v = np.exp(np.random.default_rng(1).uniform(*np.log(RANGE), POINTS))
    exact = rs.solve(replace(impact, velocity=v[:5000]), rtol=1e-11)
    measured = max(
        float(np.abs(getattr(surrogate, output)(v[:5000]) / getattr(exact, output) - 1.0).max()) for output in OUTPUTS
    )
    size = surrogate.save(folder / "surrogate.json").stat().st_size
    e = surrogate.compiled()
    callback = numba.cfunc("float64(float64)")(lambda x: e(x)).ctypes

    @numba.njit
    def loop(v):
        total = 0.0
        for x in v:
            total += callback(x)
        return total

    loop(v)
    some = replace(impact, velocity=v[:KERNEL_POINTS])
    return Subject(
        f"{name}, rtol 1e-6", size, max(surrogate.error.values()), measured, surrogate.pieces.edges.size - 1,
        lambda: surrogate(v), lambda: loop(v), lambda: rs.solve(some, rtol=1e-6, workers=1),
    )  # fmt: skip


def over_plane(name: str, groups: tuple[Any, Any, Any]) -> Subject:
    """Interpolant of the paper's plane at random points or on the grid of a picture."""
    points = PLANE["random_groups"](50_000, seed=21)
    exact = rs.standard_solid_restitution(*points, rtol=1e-9)
    measured = float(np.abs(rs.standard_solid_surrogate(*points) - exact).max())
    some = [part[:KERNEL_POINTS] for part in PLANE["random_groups"](POINTS, seed=2)]
    with np.load(DATA) as data:
        pieces = len(data["levels"])
    return Subject(
        name, DATA.stat().st_size, standard_solid.STATED_ERROR, measured, pieces,
        lambda: rs.standard_solid_surrogate(*groups), None,
        lambda: rs.standard_solid_restitution(*some, rtol=1e-8, workers=1),
    )  # fmt: skip


@pytest.fixture(scope="module")
def subjects(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Subject]:
    folder = tmp_path_factory.mktemp("surrogates")
    side = np.logspace(-3, 1, 150)[:, None], np.logspace(-2, 2, 150)
    rows = [over_velocity(name, folder) for name in IMPACTS]
    rows.append(over_plane("e(nu, p2, p3), random points", PLANE["random_groups"](POINTS, seed=2)))
    rows.append(over_plane("e(nu, p2, p3), a picture of 150 x 150", (0.45, *side)))
    return {subject.name: subject for subject in rows}


NAMES = [
    *(f"{name}, rtol 1e-6" for name in IMPACTS),
    "e(nu, p2, p3), random points",
    "e(nu, p2, p3), a picture of 150 x 150",
]


@pytest.fixture(scope="module")
def times(subjects: dict[str, Subject]) -> Iterator[dict[tuple[str, str], float]]:
    """Median times [s] of a query by subject and kind; the table is written when it is complete."""
    measured: dict[tuple[str, str], float] = {}
    yield measured
    if len(measured) == 2 * len(NAMES) + len(IMPACTS):
        TABLE.write_text(table(subjects, measured))


def table(subjects: dict[str, Subject], times: dict[tuple[str, str], float]) -> str:
    """Table of the page on surrogates."""
    heads = (
        *("surrogate", "pieces", "file, kB", "error, stated", "measured"),
        *("query in an array, ns", "as a C callback, ns", "kernel, µs", "ratio"),
    )
    lines = [
        "Medians of one run, processor time of one thread. Over the velocity the error is the largest relative "
        "one of the",
        "three outputs, a query is one of them and the kernel solves to 1e-6; over the plane the error of $e$ "
        "is absolute,",
        "and the kernel solves to 1e-8.",
        "",
        f"| {' | '.join(heads)} |",
        "|---" * len(heads) + "|",
    ]
    for name, subject in subjects.items():
        array, kernel = times[name, "array"], times[name, "kernel"]
        in_c = times.get((name, "c"))
        lines.append(
            f"| {name} | {subject.pieces} | {subject.size / 1e3:.0f} | {subject.stated:.1e} | {subject.measured:.1e} "
            f"| {array * 1e9:.0f} | {'' if in_c is None else f'{in_c * 1e9:.0f}'} | {kernel * 1e6:.1f} "
            f"| {kernel / array:.0f} |"
        )
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("name", NAMES)
def test_array(benchmark: Any, subjects: dict[str, Subject], times: dict[Any, float], name: str) -> None:
    subject = subjects[name]
    assert subject.measured <= 1e-6
    result = benchmark(subject.query)
    record(benchmark, times, (name, "array"), np.size(result))


@pytest.mark.parametrize("name", NAMES[: len(IMPACTS)])
def test_c(benchmark: Any, subjects: dict[str, Subject], times: dict[Any, float], name: str) -> None:
    benchmark(subjects[name].in_c)
    record(benchmark, times, (name, "c"), POINTS)


@pytest.mark.parametrize("name", NAMES)
def test_kernel(benchmark: Any, subjects: dict[str, Subject], times: dict[Any, float], name: str) -> None:
    benchmark.pedantic(subjects[name].kernel, rounds=30, warmup_rounds=1)
    record(benchmark, times, (name, "kernel"), KERNEL_POINTS)


def record(benchmark: Any, times: dict[Any, float], key: tuple[str, str], points: int) -> None:
    """Keep the median of a query, unless benchmarks are switched off."""
    if benchmark.stats is not None:
        times[key] = benchmark.stats.stats.median / points
        benchmark.extra_info["query"] = f"{times[key] * 1e9:.0f} ns"
