"""Coverage of the intervals of materials from whole records with noise of the depth.

A parabolic tip of 2.5 um approaches from 1.5 um above the surface, goes 0.8 to 1.2 um deep at 3 to 8 um/s, rests there
for 0.2 to 1 s, and returns; 2 kHz, 20 pN of noise, and noise of the depth of 0 to 3 nm. In half of the records it goes
back by a random part of the depth after the hold, approaches again, and returns then. Standard solids with
instantaneous moduli from 0.5 to 5 kPa, ratios E1/Einf from 0.3 to 5 and times from 0.05 to 0.5 s. The forces are those
of `restitution.indent`, which shares no step with the elements of the curves. The noise of the force is stated, or
estimated in every fourth record; that of the depth is estimated. Contact point, baseline and its slope are unknown.

Usage: python validation/identification_records.py [--size 400] [--seed 1] [--workers 2] [--out FILE]
"""

import argparse
import math
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from rich.progress import track

import restitution as rs

TIP, FIXED = rs.Parabola(2.5e-6), {"poisson_ratio": 0.5}
LEVELS = (0.0, 0.05e-9, 0.1e-9, 0.3e-9, 1e-9, 3e-9)
NAMES = ("equilibrium_modulus", "branch_modulus", "viscosity", "contact_point")
RATE, NOISE, ABOVE = 2000.0, 2e-11, 1.5e-6


def record(level: float, random: Any) -> tuple[Any, tuple[float, ...], bool]:
    """Record with noise, and the constants of the material and the contact point."""
    glass, ratio, relaxation, speed, deep, hold = np.exp(
        random.uniform(np.log([500.0, 0.3, 0.05, 3e-6, 0.8e-6, 0.2]), np.log([5e3, 5.0, 0.5, 8e-6, 1.2e-6, 1.0]))
    )
    equilibrium = glass / (1.0 + ratio) / 4.0
    truth = equilibrium, ratio * equilibrium, ratio * equilibrium * relaxation
    places = [-ABOVE, deep, deep, -ABOVE]
    if random.uniform() < 0.5:
        places[3:] = random.uniform(-0.2, 0.9) * deep, random.uniform(0.5, 1.2) * deep, -ABOVE
    lengths = np.abs(np.diff(places)) / speed
    lengths[1] = hold
    knots = np.append(0.0, np.cumsum(lengths))
    times = np.arange(0.0, knots[-1], 1.0 / RATE)
    depth = np.interp(times, knots, places)
    force = force_of(truth, knots, np.array(places), times)
    origin = random.uniform(1e-6, 3e-6)
    force = force + NOISE * random.standard_normal(times.size) + random.normal(0.0, 1e-10)
    stated = rs.Noise(force=NOISE) if random.uniform() > 0.25 else None
    depth = depth + origin + level * random.standard_normal(times.size)
    return rs.IndentationCurve(times, depth, force, profile=TIP, noise=stated), (*truth, origin), len(places) > 4


def force_of(truth: tuple[float, ...], knots: Any, places: Any, times: Any) -> Any:
    """Forces at times under straight lines of the depth, which begin above the surface."""
    return rs.indent(rs.standard_solid(*truth, **FIXED), TIP, depth=places, time=knots).sample(times).force.values


def repetition(seed: int, number: int) -> list[dict[str, Any]]:
    """Rows of one record, an unknown each."""
    random, level = np.random.default_rng([seed, number]), LEVELS[number % len(LEVELS)]
    data, truth, cycles = record(level, random)
    begin = time.process_time()
    fit = rs.identify(data, rs.standard_solid, fixed=FIXED)
    used = time.process_time() - begin
    rows = []
    for name, value in zip(NAMES, truth, strict=True):
        estimate = fit.parameters[name] if name in fit.parameters else fit.nuisances[name]
        inside, z = math.nan, math.nan
        if estimate.determined:
            low, high = estimate.interval
            inside, z = float(low <= value <= high), (estimate.value - value) / estimate.standard_error
        about = {"chi2": fit.reduced_chi2, "time": used, "samples": data.size, "stated": not data.scaled}
        rows.append(
            {"number": number, "level": level, "cycles": cycles, "name": name, "inside": inside, "z": z} | about
        )
    return rows


def table(rows: pd.DataFrame) -> list[str]:
    """Coverage by noise of the depth and by unknown."""
    groups = [("all", rows), *((name, rows[rows.name == name]) for name in NAMES)]
    groups += [(words, rows[rows.cycles == cycles]) for words, cycles in (("one approach", False), ("two", True))]
    groups += [(f"depth noise {1e9 * level:g} nm", rows[rows.level == level]) for level in LEVELS]
    lines = ["| records | intervals | hold the truth | resolved to | mean z | scatter of z | chi2/dof |"]
    lines += ["|---|---|---|---|---|---|---|"]
    for words, group in groups:
        bounded = group[~group.inside.isna()]
        half = 196.0 * math.sqrt(0.0475 / max(len(bounded), 1))
        chi2 = group[group.stated].chi2
        lines.append(f"| {words} | {len(bounded)} | {100.0 * bounded.inside.mean():.1f} % | {half:.1f} % "
                     f"| {bounded.z.mean():+.2f} | {bounded.z.std():.2f} | {chi2.mean():.3f} |")  # fmt: skip
    return lines


def main() -> None:
    """Repeat the fits and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", type=int, default=400)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path(__file__).with_suffix(".md"))
    options = parser.parse_args()
    with ProcessPoolExecutor(options.workers) as pool:
        result = pool.map(repetition, [options.seed] * options.size, range(options.size), chunksize=2)
        rows = pd.DataFrame([row for rows in track(result, "records", total=options.size) for row in rows])
    curves, open_ends = rows.drop_duplicates("number"), int(rows.inside.isna().sum())
    head = [
        f"{options.size} records, seed {options.seed}; none is refused or without a fit. Of {len(rows)} unknowns "
        f"{open_ends} are",
        "not determined. Intervals are those of 95 %; z is the error over the stated one. A fit of "
        f"{curves.samples.mean():.0f} samples takes",
        f"{curves.time.median():.2f} s of processor time (median).",
    ]
    lines = [*head, "", *table(rows)]
    options.out.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))
    print(rows[rows.inside == 0.0].assign(size=lambda rows: rows.z.abs()).sort_values("size").tail(8).to_string())


if __name__ == "__main__":
    main()
