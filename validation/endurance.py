"""Failures, energy residuals and times of a million random inputs and of 100 000 random materials under all profiles.

It takes half an hour on two cores.

Usage: python validation/endurance.py [--inputs 1000000] [--materials 100000] [--compared 500] [--workers 2]
"""

import argparse
import math
import os
import sys
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from rich.progress import track

import restitution as rs
from restitution.contact.profiles import Profile
from restitution.impact.batch import Batch
from restitution.impact.solution import solve_scaled
from restitution.impact.status import SolverError, Status
from restitution.material.conversion import reduced_standard_solid

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from scipy_oracle import solve_by_scipy

RTOL = 1e-9
BATCH = 10_000
MOST_COMPARED = 12


def draw_inputs(seed: int, size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Parameters nu, p2, p3 over all that is admitted; a third incompressible."""
    random = np.random.default_rng([1, seed])
    nu = random.uniform(-1.0, 0.5, size)
    nu[::3] = 0.5
    return nu, 10.0 ** random.uniform(-5.0, 3.0, size), 10.0 ** random.uniform(-5.0, 5.0, size)


def paper_batch(seed: int) -> dict[str, np.ndarray]:
    """Solve a batch of the paper's problem, with the energy."""
    nu, p2, p3 = draw_inputs(seed, BATCH)
    ones = np.ones(BATCH)
    reduced = reduced_standard_solid(nu, ones, 1.0 / p2, p2 * p3)
    batch = Batch(*reduced.columns, ones, ones, 0.0 * ones, ones, 1.0)
    result = batch.solve(RTOL, workers=1, energy=True)
    work = solve_scaled(batch.scaled(), RTOL, workers=1)[:, 8]
    names = ("status", "restitution_coefficient", "energy_residual")
    return {name: result[name] for name in names} | {"work": work}


def draw_series(random: np.random.Generator, terms: int, liquid: bool, dashpot: bool) -> rs.PronySeries:
    """Prony series with times over 14 decades about the contact time, moduli over six."""
    equilibrium = 0.0 if liquid else 10.0 ** random.uniform(-3.0, 3.0)
    moduli, times = 10.0 ** random.uniform(-3.0, 3.0, terms), 10.0 ** random.uniform(-7.0, 7.0, terms)
    viscosity = 10.0 ** random.uniform(-5.0, 2.0) if dashpot else 0.0
    return rs.PronySeries(equilibrium, moduli, times, parallel_viscosity=viscosity)


def draw_profile(random: np.random.Generator, kind: int) -> Profile:
    """One of seven profiles, of a size over four decades."""
    size, angle = 10.0 ** random.uniform(-2.0, 2.0), random.uniform(0.2, 1.5)
    if kind == 0:
        return rs.Parabola(size)
    if kind == 1:
        return rs.Sphere(size)
    if kind == 2:
        return rs.Cone(angle)
    if kind == 3:
        return rs.PowerLaw(random.uniform(1.0, 8.0), size)
    if kind == 4:
        return rs.FlatPunch(size)
    if kind == 5:
        return rs.TruncatedCone(size, angle)
    return rs.FlatEndedParabola(size, 10.0 ** random.uniform(-2.0, 1.0))


def worn_tip(random: np.random.Generator, impact: rs.Impact) -> rs.Tabulated:
    """Table of 41 points of a wavy paraboloid, three times as wide as the contact of the plain one."""
    result = rs.solve(impact, rtol=1e-4)
    radii = np.linspace(0.0, 3.0 * float(result.max_contact_radius), 41)
    waves = 1.0 + random.uniform(0.0, 0.1) * np.sin(random.uniform(2.0, 8.0) * radii / radii[-1])
    return rs.Tabulated(radii, radii**2 / (2.0 * impact.profile.radius) * waves)


def draw_impact(seed: int, number: int) -> rs.Impact:
    """Impact of 1 to 30 terms in shear; the bulk modulus infinite, constant, zero or another series."""
    random = np.random.default_rng([2, seed, number])
    kind = random.integers(4)
    liquid, dashpot = random.random() < 0.05, random.random() < 0.1
    shear = draw_series(random, int(random.integers(1, 31)), liquid, dashpot)
    if kind == 0:
        bulk = math.inf
    elif kind == 1:
        bulk = 10.0 ** random.uniform(-3.0, 3.0)
    elif kind == 2:
        bulk = 0.0
    else:
        bulk = draw_series(random, int(random.integers(1, 31)), False, False)
    shape = int(random.integers(8))
    mass, velocity = 10.0 ** random.uniform(-2.0, 2.0, 2)
    material = rs.Material(shear, bulk)
    if shape == 7:
        plain = rs.Impact(material, rs.Parabola(10.0 ** random.uniform(-2.0, 2.0)), mass, velocity)
        return rs.Impact(material, worn_tip(random, plain), mass, velocity)
    return rs.Impact(material, draw_profile(random, shape), mass, velocity)


def material_batch(seed: int, size: int) -> list[tuple[str, str, float, float, float, int]]:
    """Solve a batch of random materials one by one: profile, status, e, residual, duration in seconds, terms."""
    rows = []
    for number in range(size):
        impact = draw_impact(seed, number)
        start = time.perf_counter()
        try:
            result = rs.solve(impact, rtol=RTOL)
            duration = time.perf_counter() - start
            residual = float(result.energy.residual) if result.status is Status.SEPARATED else 0.0
            status, e = Status(result.status).name, float(result.restitution_coefficient)
        except SolverError as failure:
            status, e, residual, duration = failure.status.name, math.nan, 0.0, time.perf_counter() - start
        terms = impact.reduced_modulus.n_branches
        rows.append((type(impact.profile).__name__, status, e, residual, duration, terms))
    return rows


def compared(number: int, inputs: int) -> tuple[float, float] | None:
    """Value of e by the exact method at 1e-11 and by SciPy's Radau; the first half from the paper's problem."""
    if number % 2 == 0:
        nu, p2, p3 = draw_inputs(number // 2 % max(inputs // BATCH, 1), BATCH)
        place = 7 * number % BATCH
        material = rs.standard_solid(1.0, 1.0 / p2[place], p3[place], poisson_ratio=nu[place])
        impact = rs.Impact(material, rs.Parabola(1.0), 1.0, 1.0)
    else:
        drawn = (draw_impact(number // 2, n) for n in range(100))
        impact = next(candidate for candidate in drawn if candidate.reduced_modulus.n_branches <= MOST_COMPARED)
    try:
        other = solve_by_scipy(impact, 1e-11)
    except SolverError:
        return None
    exact = rs.solve(impact, rtol=1e-11)
    return float(exact.restitution_coefficient), float(other.restitution_coefficient)


def main() -> None:
    """Write `endurance.md`."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--inputs", type=int, default=1_000_000)
    parser.add_argument("--materials", type=int, default=100_000)
    parser.add_argument("--compared", type=int, default=500)
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    options = parser.parse_args()
    page, lines = Path(__file__).with_suffix(".md"), []
    with ProcessPoolExecutor(options.workers) as pool:
        seeds = range(math.ceil(options.inputs / BATCH))
        batches = list(track(pool.map(paper_batch, seeds), "standard solids", len(seeds)))
        columns = {name: np.concatenate([batch[name] for batch in batches]) for name in batches[0]}
        e = columns["restitution_coefficient"]
        counts = Counter(Status(int(status)).name for status in columns["status"])
        lines += [
            f"**The paper's problem:** {e.size:,} random inputs, nu from -1 to 0.5 (a third 0.5), p2 from 1e-5 "
            "to 1e3, "
            f"p3 from 1e-5 to 1e5, `rtol = {RTOL:g}`.",
            "",
            "| | |",
            "|---|---|",
            *(f"| ended as {name} | {count:,} |" for name, count in counts.most_common()),
            f"| e outside (0, 1] | {int(np.sum(~((e > 0.0) & (e <= 1.0)))):,} |",
            f"| smallest and largest e | {np.nanmin(e):.3g}, {np.nanmax(e):.12f} |",
            f"| largest energy residual | {np.nanmax(np.abs(columns['residual'])):.1e} |",
            f"| energy not found | {int(np.isnan(columns['residual']).sum()):,} |",
            f"| elements solved: median, largest | {np.median(columns['work']):.0f}, {columns['work'].max():.0f} |",
            "",
        ]
        page.write_text("\n".join(lines) + "\n")
        size = 100
        seeds = range(math.ceil(options.materials / size))
        tasks = pool.map(material_batch, seeds, [size] * len(seeds))
        rows = [row for batch in track(tasks, "materials and profiles", len(seeds)) for row in batch]
        lines += [
            f"**Random materials:** {len(rows):,} impacts, 1 to 30 terms in shear over 14 decades of time and six of "
            "modulus (a tenth with a dashpot, a twentieth liquid), bulk modulus infinite, constant, zero or of "
            "1 to 30 "
            f"terms, `rtol = {RTOL:g}`. Times are those of whole calls of `rs.solve`, reduced modulus and "
            "profile table "
            "included; the slowest may have been held up by other work.",
            "",
            "| profile | solved | separated | sinks in | failed | e outside (0, 1] | largest energy residual "
            "| energy not found | median ms | slowest over median |",
            "|" + "---|" * 10,
        ]
        failures: Counter[str] = Counter()
        for name in [*sorted({row[0] for row in rows}), "all"]:
            some = [row for row in rows if name in (row[0], "all")]
            ended = Counter(row[1] for row in some)
            bad = {status: count for status, count in ended.items() if Status[status].failed}
            if name == "all":
                failures.update(bad)
            separated = [row for row in some if row[1] == "SEPARATED"]
            outside = sum(not 0.0 < row[2] <= 1.0 for row in separated)
            residuals = np.array([row[3] for row in separated])
            durations = np.array([row[4] for row in some])
            lines.append(
                f"| {name} | {len(some):,} | {ended['SEPARATED']:,} | {ended['SINKS_IN']:,} | {sum(bad.values()):,} "
                f"| {outside:,} | {np.nanmax(np.abs(residuals)):.1e} | {int(np.isnan(residuals).sum()):,} "
                f"| {np.median(durations) * 1e3:.2f} | {durations.max() / np.median(durations):.0f} |"
            )
        listed = ", ".join(f"{count:,} {status}" for status, count in failures.items()) or "none"
        lines += ["", f"Failures: {listed}.", ""]
        page.write_text("\n".join(lines) + "\n")
        numbers = range(options.compared)
        tasks = pool.map(compared, numbers, [options.inputs] * len(numbers))
        pairs = list(track(tasks, "against SciPy", len(numbers)))
        both = np.array([pair for pair in pairs if pair is not None])
        difference = np.abs(both[:, 0] - both[:, 1])
        lines += [
            f"**Against SciPy's Radau** (`tests/scipy_oracle.py`), both at `rtol = 1e-11`: {len(pairs)} of these "
            "impacts, half "
            f"of each kind, those of random materials with at most {MOST_COMPARED} terms in E*, since SciPy's "
            "cost grows "
            f"with their square. SciPy reached its tolerance in {len(both)}; largest difference of e "
            f"{difference.max():.1e}, largest over max(e, 1e-3) "
            f"{np.max(difference / np.maximum(both[:, 1], 1e-3)):.1e}, "
            f"median {np.median(difference):.1e}.",
        ]
    page.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
