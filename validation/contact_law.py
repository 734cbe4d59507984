"""Errors and cost of the contact law at several numbers of steps per contact.

Run as `python validation/contact_law.py`; prints tables and writes them to `contact_law.md` beside this file. It takes
a minute. The times are those of one processor core.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numba
import numpy as np

import restitution as rs
from restitution.impact.batch import Batch
from restitution.law.step import step

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from independent_elements import element_forces

ROWS = [(0.5, 0.1, 1.0), (0.3, 0.1, 1.0), (0.3, 0.01, 1.0), (0.45, 0.01, 0.1), (0.49, 0.001, 10.0), (0.3, 0.1, 100.0)]
STEPS = [25, 50, 100, 200, 400]
# Shares of a step by which first touch comes after the end of a step.
GAPS = [0.0, 0.25, 0.5, 0.75]
# Motions that load again: their kinds and number, steps of the law, numbers of elements and their steps.
KINDS, MOTIONS = ("solid of the paper", "two branches", "two branches and a dashpot"), 20
AGAIN, ELEMENTS, STEPS_PER_ELEMENT, FINEST = [100, 200, 400, 800, 1600], [200, 400, 800, 1600], 8, 12800
COUNTS, POINTS = [50, 100, 400], 1000

TEXT = """\
Velocity Verlet, a sphere on a half-space of the paper's material. Each entry is the largest error of $e$ and the
largest relative error of the peak force, for a first touch at the end of a step and at three places within it.
The order is that of the error of $e$ over the steps. `validation/contact_law.py` makes the tables.

| $\\nu$, $p_2$, $p_3$ | $e$ | {heads} | order |
|---|---|{lines}---|
{errors}

Over {points} random points of the paper's plane ($\\nu$ from -0.9 to 0.5, $p_2$ from 0.001 to 10, $p_3$ from 0.01 to
100) the error of $e$ is

| steps | median | 95 % below | largest |
|---|---|---|---|
{plane}

In the last row the law makes 32 steps within each step of velocity Verlet: the error that is left is that of Verlet.

Loading again before separation, against independent elements that the body may touch again
(`tests/independent_elements.py`): {motions} random motions of five waves in 1.2 of the longest period for
each kind of material, under a paraboloid, a cone or a flat punch. The entries are the root mean square of the
difference of the force over its largest value, median / largest. The reference is extrapolated from {most} elements
in {finest} steps and from half as many. The elements have {per} steps for each element; their first-order error is
that of explicit Euler. Where a dashpot is loaded again, the reference itself has an error of some $10^{{-4}}$.

| material | method | {again} |
|---|---|{lines_again}
{reloading}

The columns are steps of the law; of the elements they are {elements} elements.

Time of a step with velocity Verlet, in ns, mean over one contact, on one core. A contact without memory, Hertz with a
damping force, takes {plain:.0f} ns in the same loop.

| terms | {counts} |
|---|{lines_cost}
{cost}
"""


@numba.njit
def verlet(law: np.ndarray, state: np.ndarray, depth: float, dt: float) -> tuple[float, float, int]:
    """Restitution, largest force and number of steps of a body of unit mass and velocity."""
    v, force, largest, n, touched = 1.0, 0.0, 0.0, 0, False
    while force > 0.0 or not touched:
        depth += v * dt - 0.5 * force * dt * dt
        before, force = force, step(law, state, depth, dt)
        v -= 0.5 * (before + force) * dt
        largest, n, touched = max(largest, force), n + 1, touched or force > 0.0
    return -v, largest, n


@numba.njit
def verlet_alone(law: np.ndarray, state: np.ndarray, depth: float, dt: float) -> float:
    """Restitution by the same steps with a force that is nearly exact: that of 32 steps of the law within each."""
    v, force, touched = 1.0, 0.0, False
    while force > 0.0 or not touched:
        start, before = depth, force
        for k in range(1, 33):
            t = k / 32.0 * dt
            depth = start + v * t - 0.5 * before * t * t
            force = step(law, state, depth, dt / 32.0)
        v -= 0.5 * (before + force) * dt
        touched = touched or force > 0.0
    return -v


@numba.njit
def plain_law(damping: float, dt: float) -> int:
    """Count the steps of a contact with the force d^1.5 + damping d^0.5 v."""
    depth, v, force, n = 0.0, 1.0, 0.0, 0
    while force > 0.0 or n == 0:
        depth += v * dt - 0.5 * force * dt * dt
        before, root = force, math.sqrt(max(depth, 0.0))
        force = max(root * (depth + damping * v), 0.0)
        v -= 0.5 * (before + force) * dt
        n += 1
    return n


def unit_impact(material: rs.Material) -> rs.Impact:
    return rs.Impact(material, rs.Parabola(1.0), mass=1.0, velocity=1.0)


def error_lines() -> list[str]:
    """Errors of each row of the table at each number of steps."""
    lines: list[str] = []
    for nu, p2, p3 in ROWS:
        impact = unit_impact(rs.standard_solid(1.0, 1.0 / p2, p3, poisson_ratio=nu))
        exact, law = Batch.from_impact(impact).solve(1e-10), rs.contact_law(impact)
        e, contact_time, peak = (
            float(exact[name][0]) for name in ("restitution_coefficient", "contact_time", "max_force")
        )
        errors: list[float] = []
        cells: list[str] = []
        for steps in STEPS:
            dt = contact_time / steps
            results = [verlet(law.constants, law.start(depth=-gap * dt), -gap * dt, dt) for gap in GAPS]
            errors.append(max(abs(value - e) for value, _, _ in results))
            cells.append(f"{errors[-1]:.0e} / {max(abs(largest / peak - 1.0) for _, largest, _ in results):.0e}")
        order = -np.polyfit(np.log(STEPS), np.log(errors), 1)[0]
        lines.append(f"| {nu}, {p2}, {p3:g} | {e:.6f} | {' | '.join(cells)} | {order:.1f} |")
        print(lines[-1], flush=True)
    return lines


def plane_lines() -> list[str]:
    """Median and largest errors of e over random points, with first touch at random places within a step."""
    rng, errors = np.random.default_rng(1), []
    for _ in range(POINTS):
        nu, p2, p3, gap = rng.uniform(-0.9, 0.5), 10 ** rng.uniform(-3, 1), 10 ** rng.uniform(-2, 2), rng.uniform()
        impact = unit_impact(rs.standard_solid(1.0, 1.0 / p2, p3, poisson_ratio=nu))
        exact, law = Batch.from_impact(impact).solve(1e-10), rs.contact_law(impact)
        widths = float(exact["contact_time"][0]) / np.array(COUNTS)
        results = [verlet(law.constants, law.start(depth=-gap * dt), -gap * dt, dt)[0] for dt in widths]
        fine = rs.contact_law(impact, max_nodes=10_000)
        results.append(verlet_alone(fine.constants, fine.start(depth=-gap * widths[0]), -gap * widths[0], widths[0]))
        errors.append(np.abs(results - exact["restitution_coefficient"]))
    table = np.quantile(errors, [0.5, 0.95, 1.0], axis=0).T
    heads = [*map(str, COUNTS), f"{COUNTS[0]}, nearly exact force"]
    return [f"| {n} | " + " | ".join(f"{x:.1e}" for x in row) + " |" for n, row in zip(heads, table, strict=True)]


@numba.njit
def law_forces(law: np.ndarray, state: np.ndarray, depths: np.ndarray, dt: float) -> np.ndarray:
    forces = np.empty(depths.size)
    for n in range(depths.size):
        forces[n] = step(law, state, depths[n], dt)
    return forces


def random_depths(rng: np.random.Generator, times: np.ndarray) -> np.ndarray:
    """Depths of a motion from first touch, with five waves of random sizes and phases."""
    phases, weights = rng.uniform(0.0, 2.0 * math.pi, 5), rng.normal(size=5) / np.arange(1, 6)
    waves = np.sin(2.0 * math.pi * np.arange(1, 6) * times[:, None] + phases) - np.sin(phases)
    depths = waves @ weights
    return depths if depths.max() > 0.5 * np.abs(depths).max() else -depths


def random_impact(rng: np.random.Generator, kind: str) -> rs.Impact:
    profile = (rs.Parabola(1.0), rs.Cone(1.0), rs.FlatPunch(1.0))[rng.integers(3)]
    if kind == "solid of the paper":
        nu, branch, tau = rng.uniform(-0.5, 0.5), 10.0 ** rng.uniform(-1.0, 1.5), 10.0 ** rng.uniform(-2.5, 0.0)
        return rs.Impact(rs.standard_solid(1.0, branch, tau * branch, poisson_ratio=nu), profile, 1.0, 1.0)
    series = rs.PronySeries(
        rng.choice([0.0, 1.0]), 10.0 ** rng.uniform(-1.0, 1.0, 2), 10.0 ** rng.uniform(-2.0, 0.0, 2),
        parallel_viscosity=0.02 * (kind != "two branches"),
    )  # fmt: skip
    return rs.Impact(rs.Material(series.scaled(0.25), math.inf), profile, 1.0, 1.0)


def reloading_lines() -> list[str]:
    """Differences between the law and the elements over random motions that load again; median and largest."""
    lines: list[str] = []
    times = np.linspace(0.0, 1.2, FINEST + 1)
    for kind in KINDS:
        rng, result = np.random.default_rng(7), []
        for _ in range(MOTIONS):
            impact, depths = random_impact(rng, kind), random_depths(rng, times)

            def seen(forces: np.ndarray) -> np.ndarray:
                """Forces at the times that all of the runs have."""
                return forces[forces.size // AGAIN[0] - 1 :: forces.size // AGAIN[0]]

            runs = [
                seen(element_forces(impact, times[k::k], depths[k::k], n_elements=n))
                for n, k in ((n, FINEST // (STEPS_PER_ELEMENT * n)) for n in ELEMENTS)
            ]
            exact, scale = 2.0 * runs[-1] - runs[-2], float(np.max(runs[-1]))
            for nodes in (2000, 32):
                law = rs.contact_law(impact, max_nodes=nodes)
                runs += [
                    seen(law_forces(law.constants, law.start(), depths[k::k], times[k]))
                    for k in (FINEST // n for n in AGAIN)
                ]
            result.append([float(np.sqrt(np.mean((run - exact) ** 2))) / scale for run in runs])
        middle, most = np.median(result, axis=0), np.max(result, axis=0)
        cells = [f"{x:.0e} / {y:.0e}" for x, y in zip(middle, most, strict=True)]
        e, n = len(ELEMENTS), len(AGAIN)
        rows = [
            ["elements", *cells[:e], *[""] * (n - e)], ["law", *cells[e : e + n]], ["law, 32 nodes", *cells[e + n :]]
        ]  # fmt: skip
        lines += [f"| {kind} | {' | '.join(row)} |" for row in rows]
        print(*lines[-3:], sep="\n", flush=True)
    return lines


def cost_lines() -> tuple[list[str], float]:
    """Time of a step [ns] for each number of terms and of steps, and that of a law without memory."""
    lines: list[str] = []
    for terms in (1, 2, 4, 8):
        series = rs.PronySeries(1.0, np.full(terms, 4.0 / terms), np.geomspace(0.01, 1.0, terms))
        impact = unit_impact(rs.Material(series, math.inf))
        contact_time = float(Batch.from_impact(impact).solve(1e-6)["contact_time"][0])
        law, cells = rs.contact_law(impact), []
        for steps in COUNTS:
            state = law.start()
            cells.append(f"{nanoseconds(lambda: _steps_of_contact(law, state, contact_time / steps)):.0f}")  # noqa: B023
        lines.append(f"| {terms} | {' | '.join(cells)} |")
        print(lines[-1], flush=True)
    return lines, nanoseconds(lambda: plain_law(0.1, 0.05))


def _steps_of_contact(law: rs.ContactLaw, state: np.ndarray, dt: float) -> int:
    state[:] = 0.0
    return verlet(law.constants, state, 0.0, dt)[2]


def nanoseconds(contact: Callable[[], int]) -> float:
    """Shortest mean time of a step over seven rounds, less the call from Python."""
    best = math.inf
    for _ in range(7):
        start, steps = time.process_time(), 0
        for _ in range(1000):
            steps += contact()
        best = min(best, (time.process_time() - start) / steps)
    return 1e9 * best


def main() -> None:
    costs, plain = cost_lines()
    text = TEXT.format(
        heads=" | ".join(f"{n} steps" for n in STEPS), lines="---|" * len(STEPS), errors="\n".join(error_lines()),
        points=POINTS, plane="\n".join(plane_lines()),
        motions=MOTIONS, most=ELEMENTS[-1], finest=FINEST, per=STEPS_PER_ELEMENT,
        again=" | ".join(map(str, AGAIN)), lines_again="---|" * len(AGAIN), reloading="\n".join(reloading_lines()),
        elements=", ".join(map(str, ELEMENTS)), plain=plain, cost="\n".join(costs),
        counts=" | ".join(f"{n} steps a contact" for n in COUNTS), lines_cost="---|" * len(COUNTS),
    )  # fmt: skip
    Path(__file__).with_suffix(".md").write_text(text)


if __name__ == "__main__":
    main()
