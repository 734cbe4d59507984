"""Errors and cost of the contact law at several numbers of steps per contact.

Run as `python validation/contact_law.py`; prints tables and writes them to `contact_law.md` beside this file. It takes
half a minute. The times are those of one processor core.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path

import numba
import numpy as np

import restitution as rs
from restitution.impact.batch import Batch
from restitution.law.step import step

ROWS = [(0.5, 0.1, 1.0), (0.3, 0.1, 1.0), (0.3, 0.01, 1.0), (0.45, 0.01, 0.1), (0.49, 0.001, 10.0), (0.3, 0.1, 100.0)]
STEPS = [25, 50, 100, 200, 400]
# Shares of a step by which first touch comes after the end of a step.
GAPS = [0.0, 0.25, 0.5, 0.75]
FINE, AGAIN = 12800, [100, 200, 400, 1600]
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

Loading again before separation: root mean square of the error of the force over its largest value, for a motion of
five waves in 1.2 of the longest period, against 1500 independent elements in {fine} steps. The numbers in the heading
are the steps.

| material | nodes | {again} |
|---|---|{lines_again}
{reloading}

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
            found = [verlet(law.constants, law.start(depth=-gap * dt), -gap * dt, dt) for gap in GAPS]
            errors.append(max(abs(value - e) for value, _, _ in found))
            cells.append(f"{errors[-1]:.0e} / {max(abs(largest / peak - 1.0) for _, largest, _ in found):.0e}")
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
        found = [verlet(law.constants, law.start(depth=-gap * dt), -gap * dt, dt)[0] for dt in widths]
        errors.append(np.abs(found - exact["restitution_coefficient"]))
    table = np.quantile(errors, [0.5, 0.95, 1.0], axis=0).T
    return [f"| {n} | " + " | ".join(f"{x:.0e}" for x in row) + " |" for n, row in zip(COUNTS, table, strict=True)]


@numba.njit
def elements(
    series: tuple[float, np.ndarray, np.ndarray, float], g: np.ndarray, width: float, depths: np.ndarray, dt: float
) -> np.ndarray:
    """Force on independent elements, each in contact or free, by the implicit Euler scheme."""
    spring, moduli, times, viscosity = series
    left = 1.0 / (1.0 + dt / times)
    stiffness = spring + viscosity / dt + np.sum(moduli * left)
    u, stretch, forces = np.zeros(g.size), np.zeros((g.size, times.size)), np.zeros(depths.size)
    for n in range(depths.size):
        for i in range(g.size):
            relaxed = spring * u[i] + np.sum(moduli * left * stretch[i])
            follows = relaxed + stiffness * (depths[n] - g[i] - u[i])
            change = depths[n] - g[i] - u[i] if follows > 0.0 else -relaxed / stiffness
            u[i] += change
            stretch[i] = left * (stretch[i] + change)
            forces[n] += 2.0 * width * max(follows, 0.0)
    return forces


@numba.njit
def law_forces(law: np.ndarray, state: np.ndarray, depths: np.ndarray, dt: float) -> np.ndarray:
    forces = np.empty(depths.size)
    for n in range(depths.size):
        forces[n] = step(law, state, depths[n], dt)
    return forces


def reloading_lines() -> list[str]:
    """Errors of a motion that loads, unloads and loads again, for a solid and for one with a dashpot."""
    lines: list[str] = []
    times = np.linspace(0.0, 1.2, FINE + 1)[1:]
    phases, weights = np.array([0.5, 2.0, 4.0, 1.0, 3.0]), np.array([1.0, -0.7, 0.5, 0.4, -0.3])
    waves = np.sin(2.0 * math.pi * np.arange(1, 6) * times[:, None] + phases) - np.sin(phases)
    depths = waves @ weights
    radius = math.sqrt(depths.max())
    g = (radius * (np.arange(1500) + 0.5) / 1500) ** 2
    for words, viscosity in (("two branches", 0.0), ("two branches and a dashpot", 0.02)):
        series = rs.PronySeries(1.0, [4.0, 2.0], [0.1, 0.005], parallel_viscosity=viscosity)
        numbers = (1.0, series.branch_moduli, series.relaxation_times, viscosity)
        # Two numbers of steps, extrapolated: implicit Euler is of first order.
        fine, coarse = (elements(numbers, g, radius / 1500, depths[n - 1 :: n], times[n - 1]) for n in (1, 2))
        exact = 2.0 * fine[1::2] - coarse
        impact = unit_impact(rs.Material(series.scaled(0.25), math.inf))
        for nodes in (32, 1000):
            law = rs.contact_law(impact, max_nodes=nodes)
            cells: list[str] = []
            for steps in AGAIN:
                every = FINE // steps
                found = law_forces(law.constants, law.start(), depths[every - 1 :: every], times[every - 1])
                difference = found - exact[every // 2 - 1 :: every // 2]
                cells.append(f"{np.sqrt(np.mean(difference**2)) / fine.max():.0e}")
            lines.append(f"| {words} | {nodes} | {' | '.join(cells)} |")
            print(lines[-1], flush=True)
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
            cells.append(f"{nanoseconds(lambda: _one(law, state, contact_time / steps)):.0f}")  # noqa: B023
        lines.append(f"| {terms} | {' | '.join(cells)} |")
        print(lines[-1], flush=True)
    return lines, nanoseconds(lambda: plain_law(0.1, 0.05))


def _one(law: rs.ContactLaw, state: np.ndarray, dt: float) -> int:
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
        fine=FINE, again=" | ".join(map(str, AGAIN)), lines_again="---|" * len(AGAIN),
        reloading="\n".join(reloading_lines()), plain=plain, cost="\n".join(costs),
        counts=" | ".join(f"{n} steps a contact" for n in COUNTS), lines_cost="---|" * len(COUNTS),
    )  # fmt: skip
    Path(__file__).with_suffix(".md").write_text(text)


if __name__ == "__main__":
    main()
