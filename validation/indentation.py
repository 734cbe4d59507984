"""Prescribed indentations compared with elements and with Tamaas; errors of random indentations; speed.

Install Tamaas beside this package with `pip install tamaas` (written for version 2.9.0) and run as
`python validation/indentation.py`; prints tables and writes them to `indentation.md` beside this file. Without Tamaas
its section contains a note instead of a table. It takes two minutes.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq

import restitution as rs

INTRODUCTION = """\
# Prescribed indentation

Made by `validation/indentation.py`. The tests compare further cases with closed forms and with direct quadrature of
the integral equations, to 1e-11.

## Foundation of elements

Here the body consists of N independent elements up to the largest contact radius. Each has its own memory, which is
exact for a depth that is linear within one of the 4 N steps. This method uses neither Lee and Radok's nor Ting's
equation. An element that would pull leaves the contact. The table has the largest difference of the force relative to
the largest force, and the difference of the end of contact relative to its time.

{elements}

The force converges to the exact one. In the last case it converges slowly in the first steps, in which many elements
with a dashpot come into contact at once. The end of contact has an error of up to one step.

## Tamaas

{tamaas}

## Error over tolerance

A row has {count} random indentations: solids and liquids with 1 to 12 terms, relaxation times over eight decades, and
a dashpot in parallel in a third of them; parabola, cone, sphere, and $r^n$ with $n$ = 0.7, 3.3 and 8; triangles,
trapezoids and sine arches. The error is the largest difference of force, depth and contact radius from the solution at
rtol 1e-11, relative to their largest values.

{errors}

## Speed

The time from the history to the arrays of the result, on one thread, for 1000 times at rtol 1e-8; the best of
{repeats} calls. Other work ran on the same machine.

{speed}
"""

TAMAAS = """\
Tamaas {version} (`MaxwellViscoelastic`, non-periodic, {n} x {n} points, free side {side:g}) presses a parabola (R = 1)
with a prescribed force on an incompressible standard solid (equilibrium shear modulus {equilibrium:g}, instantaneous
shear modulus {glass:g}, relaxation time {tau:g}). The table compares the root mean square radius of the pressure,
`(int p r^2 dA/F)^(1/2)`, which is `2 int E*(t - t') a^3/3 dd/F` up to t1 for this package. The last columns
extrapolate to steps of length zero, from three runs whose steps differ by factors of two.

{table}
"""


def table(head: list[str], rows: list[list[str]]) -> str:
    """Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def half_space(series: rs.PronySeries) -> rs.Material:
    """Incompressible half-space whose reduced modulus is the series."""
    return rs.Material(series.scaled(0.25), math.inf)


def by_elements(series: rs.PronySeries, profile: Any, knots: Any, depths: Any, count: int) -> tuple[Any, Any, float]:
    """Times, forces and the end of contact of a foundation of `count` elements, in 4 `count` steps."""
    radius = float(profile.contact_radius(np.max(depths)))
    dx = radius / count
    shape = np.asarray(profile.transform(dx * (np.arange(count) + 0.5)))
    times = np.unique(np.concatenate([np.linspace(knots[0], knots[-1], 4 * count + 1), knots]))
    depth = np.interp(times, knots, depths)
    memory = np.zeros((count, series.n_branches))
    gone = np.zeros(count, dtype=bool)
    forces, end, before = [0.0], math.inf, np.zeros(count)
    for n in range(1, times.size):
        now = np.where(gone, before, np.maximum(depth[n] - shape, 0.0))
        step = times[n] - times[n - 1]
        fading = np.exp(-step / series.relaxation_times)
        rate = ((now - before) / step)[:, None]
        memory = memory * fading + rate * series.relaxation_times * (1.0 - fading)
        load = (
            series.equilibrium_modulus * now + memory @ series.branch_moduli + series.parallel_viscosity * rate[:, 0]
        )
        gone |= (load < 0.0) & (now > 0.0)
        forces.append(2.0 * dx * float(np.sum(load[~gone])))
        if gone[0] and not math.isfinite(end):
            end = float(times[n])
        before = now
    return times, np.array(forces), end


def elements_table(counts: list[int]) -> str:
    """Table of the differences between the foundation of elements and the exact solution."""
    solid = rs.PronySeries(1.0, [4.0, 2.0], [0.05, 0.6])
    liquid = rs.PronySeries(0.0, [3.0, 1.0], [0.1, 2.0])
    damped = rs.PronySeries(1.0, [2.0], [0.5], parallel_viscosity=0.05)
    cases = [
        ("parabola, solid, triangle", solid, rs.Parabola(1.0), [0.0, 1.0, 2.0], [0.0, 0.1, 0.0]),
        ("cone, liquid, trapezoid", liquid, rs.Cone(1.2), [0.0, 0.5, 1.0, 1.5], [0.0, 0.1, 0.1, 0.0]),
        ("r^4, dashpot in parallel, two slopes", damped, rs.PowerLaw(4.0, 2.0),
         [0.0, 0.6, 1.0, 2.0], [0.0, 0.02, 0.1, 0.0]),
    ]  # fmt: skip
    rows: list[list[str]] = []
    for words, series, profile, knots, depths in cases:
        result = rs.indent(half_space(series), profile, depth=depths, time=knots)
        for count in counts:
            times, forces, end = by_elements(series, profile, knots, depths, count)
            # Where a dashpot makes the force jump, the elements give the force before the jump.
            expected = result.sample(times, before=True).force.values
            worst = float(np.abs(forces - expected).max()) / result.max_force
            late = abs(end - result.contact_end_time) / result.contact_end_time
            rows.append([words, str(count), f"{worst:.1e}", f"{late:.1e}"])
    return table(["case", "elements", "force", "end of contact"], rows)


N_POINTS, SIDE, FORCE, TAU = 64, 0.3, 0.02, 0.5
EQUILIBRIUM, BRANCH = 1.0, 4.0
STEPS = (0.05, 0.025, 0.0125)
MOMENTS = (0.2, 0.6, 1.0, 1.4, 1.8)


def by_tamaas(force: Callable[[float], float], step: float) -> Any:
    """Root mean square radius of the pressure at `MOMENTS`."""
    import tamaas as tm

    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [SIDE, SIDE], [N_POINTS, N_POINTS])
    model.nu, model.E = 0.5, 3.0 * EQUILIBRIUM
    x = (np.arange(N_POINTS) + 0.5) * SIDE / N_POINTS - SIDE / 2
    square = np.add.outer(x**2, x**2)
    solver = tm.MaxwellViscoelastic(model, np.ascontiguousarray(-square / 2.0), 1e-9, step, [BRANCH], [TAU])
    tm.ModelFactory.registerNonPeriodic(model, "dcfft")
    solver.setIntegralOperator("dcfft")
    results: dict[float, float] = {}
    for n in range(1, round(MOMENTS[-1] / step) + 1):
        solver.solve(force(n * step) / SIDE**2)
        for moment in MOMENTS:
            if abs(n * step - moment) < 1e-9:
                results[moment] = math.sqrt(float((model.traction * square).sum() / model.traction.sum()))
    return np.array([results[moment] for moment in MOMENTS])


def pressure_radius(result: rs.IndentationResult, series: rs.PronySeries, t: float) -> float:
    """Root mean square radius of the pressure of an exact solution under a force, by quadrature of its history."""
    until = t
    if t > result.turning_time and result.turning_time < result.prescribed_history.stop:
        radius = result.sample([t]).contact_radius.item()
        until = brentq(
            lambda x: result.sample([x]).contact_radius.item() - radius, 0.0, result.turning_time, xtol=1e-14
        )
    nodes, weights = np.polynomial.legendre.leggauss(20)
    half = 0.5 * 2.0 ** -np.arange(40.0)[::-1]
    edges = np.concatenate([[0.0], half, 1.0 - half[-2::-1], [1.0]])
    # A force that begins with a step: the integral of a^3 dd over the step is (2/5) a^5 with d = a^2.
    first = result.sample([0.0]).contact_radius.item()
    total = float(series.relaxation_modulus(t)) * 2.0 / 15.0 * first**5
    for low, high in ((0.0, min(1.0, until)), (1.0, until)):
        if high > low:
            places = low + (high - low) * edges
            width = 0.5 * np.diff(places)
            x = (places[:-1, None] + width[:, None] * (1.0 + nodes)).ravel()
            sample = result.sample(x)
            rates = (
                series.relaxation_modulus(t - x)
                * sample.contact_radius.values**3
                / 3.0
                * sample.indentation_velocity.values
            )
            total += float(np.sum((width[:, None] * weights).ravel() * rates))
    return math.sqrt(4.0 * total / result.sample([t]).force.item())


def tamaas_section() -> str:
    """Table of the differences from Tamaas, or a note if Tamaas is absent."""
    try:
        import tamaas as tm
    except ImportError as error:
        return f"Not run: {error}; `pip install tamaas`."
    tm.set_log_level(tm.LogLevel.error)
    tm.initialize(1)
    material = rs.Material(rs.PronySeries(EQUILIBRIUM, [BRANCH], [TAU]), math.inf)
    series = rs.reduced_modulus(material)
    cases: list[tuple[str, Callable[[float], float], rs.History]] = [
        ("held force", lambda t: FORCE, rs.hold(FORCE, 2.0)),
        ("triangle", lambda t: FORCE * min(t, 2.0 - t), rs.triangle(FORCE, 1.0)),
    ]
    rows: list[list[str]] = []
    for words, force, history in cases:
        result = rs.indent(material, rs.Parabola(1.0), force=history, time=MOMENTS, rtol=1e-10)
        exact = np.array([pressure_radius(result, series, t) for t in MOMENTS])
        runs = [by_tamaas(force, step) for step in STEPS]
        once = [2.0 * finer - coarser for coarser, finer in pairwise(runs)]
        limit = (4.0 * once[1] - once[0]) / 3.0
        for n, t in enumerate(MOMENTS):
            rows.append([
                words, f"{t:g}", f"{result.contact_radius[n]:.6f}", f"{exact[n]:.6f}", f"{limit[n]:.6f}",
                f"{runs[-1][n] / exact[n] - 1.0:+.1e}", f"{limit[n] / exact[n] - 1.0:+.1e}",
            ])  # fmt: skip
    head = ["case", "t", "contact radius", "radius of the pressure", "Tamaas, extrapolated",
            f"difference at step {STEPS[-1]:g}", "extrapolated"]  # fmt: skip
    return TAMAAS.format(
        version=tm.__version__, n=N_POINTS, side=SIDE, equilibrium=EQUILIBRIUM, glass=EQUILIBRIUM + BRANCH,
        tau=TAU, table=table(head, rows),
    )  # fmt: skip


def drawn(rng: np.random.Generator) -> tuple[rs.Material, Any, rs.History]:
    """A random material, profile and history."""
    count = int(rng.integers(1, 13))
    series = rs.PronySeries(
        float(rng.choice([0.0, 1.0])), 10.0 ** rng.uniform(-2, 2, count), 10.0 ** rng.uniform(-5, 3, count),
        parallel_viscosity=float(10.0 ** rng.uniform(-2, 1)) if rng.random() < 0.3 else 0.0,
    )  # fmt: skip
    profile = [
        rs.Parabola(1.0), rs.Cone(1.2), rs.PowerLaw(float(rng.choice([0.7, 3.3, 8.0])), 1.0), rs.Sphere(20.0),
    ][rng.integers(4)]  # fmt: skip
    down = float(10.0 ** rng.uniform(-1, 1))
    history = [
        rs.triangle(1.0, 1.0, unloading_time=down),
        rs.triangle(1.0, 1.0, unloading_time=down, hold_time=1.0),
        rs.sine_arch(1.0, 2.0),
    ][rng.integers(3)]
    return half_space(series), profile, history


def errors_table(count: int) -> str:
    """Largest error over the tolerance."""
    rows: list[list[str]] = []
    for prescribed in ("depth", "force"):
        for rtol in (1e-4, 1e-6, 1e-8, 1e-10):
            rng = np.random.default_rng(7)
            worst, failed = 0.0, 0
            for _ in range(count):
                material, profile, history = drawn(rng)
                times = np.linspace(0.0, history.stop, 200)
                try:
                    tight, loose = (
                        rs.indent(material, profile, time=times, rtol=r, **{prescribed: history})
                        for r in (1e-11, rtol)
                    )
                except ValueError:
                    failed += 1
                    continue
                for name in ("force", "indentation_depth", "contact_radius"):
                    expected = getattr(tight, name)
                    worst = max(worst, float(np.abs(getattr(loose, name) - expected).max() / expected.max()) / rtol)
            rows.append([prescribed, f"{rtol:g}", f"{worst:.2g}", str(failed)])
    return table(["prescribed", "rtol", "largest error over tolerance", "refused"], rows)


REPEATS = 50


def best(call: Callable[[], Any]) -> float:
    """Shortest time [ms] of several calls."""
    shortest = math.inf
    for _ in range(REPEATS):
        begin = time.perf_counter()
        call()
        shortest = min(shortest, time.perf_counter() - begin)
    return 1e3 * shortest


def speed_table() -> str:
    """Table of the times of whole calls."""
    t = np.linspace(0.0, 2.0, 1000)
    triangle = 1e-6 * (1.0 - np.abs(t - 1.0))
    tip = rs.Parabola(2.5e-6)

    def gel(terms: int) -> rs.Material:
        moduli, times = np.full(terms, 800.0 / terms), np.geomspace(1e-3, 10.0, terms)
        return rs.Material(rs.PronySeries(200.0, moduli, times), math.inf)

    sine = 1e-6 * np.sin(0.5 * math.pi * t)
    sine[-1] = 0.0
    single, ten, thirty = gel(1), gel(10), gel(30)
    up_and_down, arch, pushed = rs.triangle(1e-6, 1.0), rs.sine_arch(1e-6, 2.0), rs.triangle(1e-9, 1.0)
    points = "triangle of the depth as 1000 points"
    calls: list[tuple[str, Callable[[], Any]]] = [
        (f"{points}, 1 term", lambda: rs.indent(single, tip, depth=triangle, time=t)),
        (f"{points}, 10 terms", lambda: rs.indent(ten, tip, depth=triangle, time=t)),
        (f"{points}, 30 terms", lambda: rs.indent(thirty, tip, depth=triangle, time=t)),
        ("the same as `rs.triangle`, 10 terms", lambda: rs.indent(ten, tip, depth=up_and_down, time=t)),
        (
            "the same with a sphere, 10 terms",
            lambda: rs.indent(ten, rs.Sphere(2.5e-6), depth=up_and_down, time=t),
        ),
        ("`rs.sine_arch`, 10 terms", lambda: rs.indent(ten, tip, depth=arch, time=t)),
        ("sine arch as 999 straight lines, 10 terms", lambda: rs.indent(ten, tip, depth=sine, time=t)),
        ("held force, 10 terms", lambda: rs.indent(ten, tip, force=1e-9, time=t)),
        ("triangle of the force, 10 terms", lambda: rs.indent(ten, tip, force=pushed, time=t)),
    ]
    return table(["indentation", "ms"], [[words, f"{best(call):.2f}"] for words, call in calls])


def main() -> None:
    """Print the tables and write them beside this file."""
    counts, count = [50, 100, 200, 400], 100
    text = INTRODUCTION.format(
        elements=elements_table(counts), tamaas=tamaas_section(), count=count,
        errors=errors_table(count), repeats=REPEATS, speed=speed_table(),
    )  # fmt: skip
    print(text)
    Path(__file__).with_suffix(".md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
