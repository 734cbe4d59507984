"""Coverage of the intervals of identified materials, over many kinds of data.

Each set draws a standard solid with a ratio G1/Ginf from 0.5 to 20, a relaxation time from 0.1 to 10 times the
contact time T (of an indentation: the time of the approach), noise from 0.3 to 3 %, and its data: ten rebounds of a
ball at one velocity, ten of a ball at velocities over a factor of 6, six each of three balls, or a curve of a
microscope. The noise is stated, or estimated from the scatter in every fourth set. A stated interval has at least one
closed end. An error is the distance from the best value to the end of the interval on the side of the truth, over
1.96.

Usage: python validation/interval_coverage.py [--size 800] [--seed 1] [--workers 2] [--out FILE]
"""

import argparse
import math
import warnings
from concurrent.futures import ProcessPoolExecutor
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from rich.progress import track

import restitution as rs

KINDS = ("one velocity", "one ball", "three balls", "AFM curve")
NAMES = ("equilibrium_modulus", "branch_modulus", "viscosity")
TIP, POINTS, HALF = rs.Parabola(2.5e-6), 240, 1.4
FIXED = {"poisson_ratio": 0.5}


def rebounds(kind: str, modulus: float, ratio: float, share: float, noise: float, random: Any) -> Any:
    """Rebounds with noise, and the constants of the material."""
    radii = (0.003, 0.01, 0.03) if kind == "three balls" else (0.01,)
    speeds = np.full(10, 0.1) if kind == "one velocity" else np.geomspace(0.03, 0.18, 6 if len(radii) > 1 else 10)
    velocity, radius = np.tile(speeds, len(radii)), np.repeat(radii, speeds.size)
    mass = 7800.0 * 4.0 / 3.0 * math.pi * radius**3
    stiff = rs.elastic(shear_modulus=modulus * (1.0 + ratio), **FIXED)
    time = rs.solve(rs.Impact(stiff, rs.Parabola(0.01), float(np.median(mass)), 0.0735)).contact_time
    truth = modulus, modulus * ratio, modulus * ratio * share * time
    exact = rs.solve(rs.Impact(rs.standard_solid(*truth, **FIXED), rs.Parabola(radius), mass, velocity), workers=1)
    e, contact = (column * (1.0 + noise * random.standard_normal(velocity.size))
                  for column in (exact.restitution_coefficient, exact.contact_time))  # fmt: skip
    size = f"{100.0 * noise:.12g} %"
    stated = rs.Noise(restitution_coefficient=size, contact_time=size) if random.uniform() > 0.25 else None
    data = rs.Rebounds(velocity, np.minimum(e, 1.0), radius=radius, mass=mass, contact_time=contact, noise=stated)
    return data, truth


def curve(modulus: float, ratio: float, share: float, noise: float, random: Any) -> Any:
    """Curve of a microscope with noise, and the constants of the material."""
    truth = 1e-3 * modulus, 1e-3 * modulus * ratio, 1e-3 * modulus * ratio * share * HALF
    time = np.linspace(0.0, 2.0 * HALF, POINTS)
    depth = np.interp(time, [0.0, HALF, 2.0 * HALF], [0.0, 1.4e-6, 0.0])
    contact = random.uniform(0.3e-6, 0.5e-6)
    force = rs.indent(rs.standard_solid(*truth, **FIXED), TIP, depth=depth - contact, time=time).force
    sd = noise * float(force.max())
    stated = rs.Noise(force=sd) if random.uniform() > 0.25 else None
    noisy = force + sd * random.standard_normal(POINTS)
    return rs.IndentationCurve(time, depth, noisy, profile=TIP, noise=stated), truth


def repetition(seed: int, number: int) -> list[dict[str, Any]]:
    """Rows of one set, a parameter each."""
    warnings.simplefilter("ignore")
    random, kind = np.random.default_rng([seed, number]), KINDS[number % len(KINDS)]
    ratio, share, noise = np.exp(random.uniform(np.log([0.5, 0.1, 0.003]), np.log([20.0, 10.0, 0.03])))
    modulus = float(np.exp(random.uniform(math.log(3e5), math.log(3e6))))
    row = {"number": number, "kind": kind, "ratio": ratio, "share": share, "noise": noise}
    try:
        if kind == "AFM curve":
            data, truth = curve(modulus, ratio, share, noise, random)
        else:
            data, truth = rebounds(kind, modulus, ratio, share, noise, random)
        result = rs.identify(data, rs.standard_solid, fixed=FIXED)
    except rs.errors.InputError as error:
        return [row | {"name": "", "state": f"refused: {error.field}", "inside": True, "errors": 0.0}]
    space = result.problem.space
    best = dict(zip(space.names, space.numbers(result.coordinates[None])[0], strict=True))
    rows = []
    for name, value in zip(NAMES, truth, strict=True):
        estimate, middle = result.parameters[name], float(best[name])
        low, high = estimate.interval
        state = ("closed", "one-sided", "open")[sum(estimate.open_ends)]
        # The interval is that of the best value, which may lie beyond an open end.
        end = high if value > middle else low
        errors = (
            abs(math.log(value / middle)) / max(abs(math.log(end / middle)), 1e-12) * 1.96
            if 0 < end < math.inf
            else 0.0
        )
        rows.append(row | {"name": name, "state": state, "inside": low <= value <= high, "errors": errors,
                           "value": middle, "truth": value, "low": low, "high": high})  # fmt: skip
    return rows


def table(rows: pd.DataFrame) -> list[str]:
    """Coverage by kind, time, ratio and noise."""
    stated = rows[rows.state.isin(["closed", "one-sided"])]
    groups: list[tuple[str, pd.DataFrame]] = [("all", stated)]
    groups += [(kind, stated[stated.kind == kind]) for kind in KINDS]
    groups += [(name, stated[stated.name == name]) for name in NAMES]
    groups += [(f"intervals {state}", stated[stated.state == state]) for state in ("closed", "one-sided")]
    for name, words, edges in (("share", "tau/T", (0.1, 0.5, 2.0, 10.0)), ("ratio", "G1/Ginf", (0.5, 2.0, 6.0, 20.0)),
                               ("noise", "noise", (0.003, 0.01, 0.03))):  # fmt: skip
        for low, high in pairwise(edges):
            groups.append((f"{words} {low:g} to {high:g}", stated[(stated[name] >= low) & (stated[name] < high)]))
    lines = ["| data | stated intervals | hold the truth | resolved to | above 3 errors | above 5 | largest |"]
    lines += ["|---|---|---|---|---|---|---|"]
    for words, group in groups:
        n = len(group)
        off = group.errors.where(~group.inside, 0.0)
        half = 196.0 * math.sqrt(0.0475 / max(n, 1))
        lines.append(f"| {words} | {n} | {100.0 * group.inside.mean():.1f} % | {half:.1f} % "
                     f"| {(off > 3.0).sum()} | {(off > 5.0).sum()} | {off.max():.1f} |")  # fmt: skip
    return lines


def main() -> None:
    """Repeat the fits and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", type=int, default=800)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path(__file__).with_suffix(".md"))
    options = parser.parse_args()
    with ProcessPoolExecutor(options.workers) as pool:
        result = pool.map(repetition, [options.seed] * options.size, range(options.size), chunksize=2)
        rows = pd.DataFrame([row for rows in track(result, "sets", total=options.size) for row in rows])
    counts = rows.state.value_counts()
    head = f"{options.size} sets, seed {options.seed}. " + ", ".join(f"{n} {name}" for name, n in counts.items())
    lines = [f"{head}. Open on both sides: not determined, and not counted.", "", *table(rows)]
    options.out.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))
    worst = rows[~rows.inside].sort_values("errors", ascending=False).head(25)
    print(worst.drop(columns=["inside"]).to_string())


if __name__ == "__main__":
    main()
