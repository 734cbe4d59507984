"""Errors of the exact method over its tolerance for random measured tips of 20 to 2000 points.

The reference is `rtol = 1e-12`, for the first tips also SciPy (`tests/scipy_oracle.py`). A file keeps the solved tips:
it resumes an interrupted run, and a run with another `NUMBA_CPU_NAME` adds a table.

Usage: python validation/tips.py [--tips 10000] [--depths 20] [--compared 10] [--workers 2] [--rows tips.csv]
"""

import argparse
import math
import os
import sys
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from rich.progress import track

import restitution as rs
from restitution.errors import InputError

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from scipy_oracle import solve_by_scipy

KINDS = ("few points, rough", "noise", "quantised heights", "flat end, noise", "uneven spacing, waves")
RTOL = (1e-6, 1e-9)
WIDTH = 12.0
PROCESSOR = os.environ.get("NUMBA_CPU_NAME") or "this machine"


class Row(NamedTuple):
    """Errors of the impacts of one tip at one tolerance."""

    processor: str
    seed: int
    rtol: float
    impacts: int
    above: int
    failed: int
    worst: float


def draw_tip(seed: int) -> rs.Tabulated:
    """Draw a tip close to a paraboloid of radius 1, with the errors of an instrument."""
    random = np.random.default_rng([seed, 7])
    kind = seed % len(KINDS)
    count = int(10.0 ** random.uniform(np.log10(20), np.log10(2000)))
    r = np.linspace(0.0, WIDTH, int(random.integers(6, 30)) if kind == 0 else count)
    if kind == 4:
        r = np.append(0.0, np.sort(WIDTH * random.random(count)))
    f = 0.5 * r**2
    noise = random.normal(size=r.size)
    if kind == 0:
        f = f * np.exp(np.cumsum(0.05 * random.random() * noise)) + 1e-6 * r
    elif kind == 1:
        f = f * (1.0 + 10.0 ** random.uniform(-8.0, -3.0) * noise)
    elif kind == 2:
        step = 10.0 ** random.uniform(-6.0, -2.0)
        f = step * np.round(f / step)
    elif kind == 3:
        face = random.uniform(0.05, 1.0)
        f = np.maximum(f - 0.5 * face**2, 0.0) * (1.0 + 10.0 ** random.uniform(-7.0, -3.0) * noise)
    else:
        f = f * (1.0 + 10.0 ** random.uniform(-6.0, -1.0) * np.cumsum(noise) / r.size**0.5)
    f = np.maximum.accumulate(f)
    return rs.Tabulated(r, f - f[0])


def draw_impacts(seed: int, depths: int) -> rs.Impact | None:
    """Draw impacts of one tip on one standard solid, for depths over 1.7 decades; None for a refused tip."""
    try:
        tip = draw_tip(seed)
    except (InputError, ValueError):
        return None
    random = np.random.default_rng([seed, 8])
    depth = np.minimum(10.0 ** random.uniform(-1.5, 0.2, depths), 0.4 * float(tip.max_depth))
    solid = rs.standard_solid(
        1.0, 10.0 ** random.uniform(-1.0, 2.0), 10.0 ** random.uniform(-1.5, 1.0), poisson_ratio=0.5
    )
    return rs.Impact(solid, tip, mass=tip.contact_radius(depth) * depth**2, velocity=1.0)


def errors(seed: int, depths: int) -> list[Row]:
    """Errors of e of one tip at each tolerance; no rows for a refused tip."""
    impact = draw_impacts(seed, depths)
    if impact is None:
        return [Row(PROCESSOR, seed, math.nan, 0, 0, 0, 0.0)]
    expected = rs.solve(impact, rtol=1e-12, workers=1).restitution_coefficient
    rows = []
    for rtol in RTOL:
        result = rs.solve(impact, rtol=rtol, workers=1).restitution_coefficient
        ratio = np.abs(result - expected) / rtol / np.maximum(expected, 1e-3)
        failed, above = int(np.isnan(ratio).sum()), int(np.sum(ratio > 1.0))
        rows.append(Row(PROCESSOR, seed, rtol, ratio.size, above, failed, float(np.nanmax(ratio, initial=0.0))))
    return rows


def compared(seed: int) -> float | None:
    """Difference of e from SciPy's, both at 1e-9, over max(e, 1e-3)."""
    impact = draw_impacts(seed, 1)
    if impact is None:
        return None
    single = rs.Impact(impact.material, impact.profile, mass=float(np.ravel(impact.mass)[0]), velocity=1.0)
    e, other = (method(single, rtol=1e-9).restitution_coefficient for method in (rs.solve, solve_by_scipy))
    return abs(e - other) / max(other, 1e-3)


def table(rows: pd.DataFrame) -> list[str]:
    """Lines of the table of one processor."""
    solved = rows[rows["impacts"] > 0]
    refused = rows["seed"].nunique() - solved["seed"].nunique()
    lines = [
        f"**Processor of the compiler: {rows['processor'].iloc[0]}.** {rows['seed'].nunique():,} random tips, "
        f"{solved['impacts'].max()} impacts each. Refused, because g(x) falls somewhere: {refused:,} tips.",
        "",
        "| tip | solved tips | impacts | rtol | above rtol | failed | largest error over rtol max(e, 1e-3) |",
        "|" + "---|" * 7,
    ]
    for (kind, rtol), group in solved.groupby([solved["seed"] % len(KINDS), "rtol"]):
        lines.append(
            f"| {KINDS[kind]} | {len(group):,} | {group['impacts'].sum():,} | {rtol:g} | {group['above'].sum():,} "
            f"| {group['failed'].sum():,} | {group['worst'].max():.2f} |"
        )
    return [*lines, ""]


def main() -> None:
    """Write `tips.md`."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tips", type=int, default=10_000)
    parser.add_argument("--depths", type=int, default=20)
    parser.add_argument("--compared", type=int, default=10)
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    parser.add_argument("--rows", type=Path, default=Path("tips.csv"), help="solved tips, from which a run goes on")
    options = parser.parse_args()
    if not options.rows.exists():
        options.rows.write_text(",".join(Row._fields) + "\n")
    before = pd.read_csv(options.rows)
    left = sorted(set(range(options.tips)) - set(before.loc[before["processor"] == PROCESSOR, "seed"]))
    with ProcessPoolExecutor(options.workers) as pool:
        tasks = [pool.submit(errors, seed, options.depths) for seed in left]
        for task in track(as_completed(tasks), "tips", len(tasks)):
            pd.DataFrame(task.result()).to_csv(options.rows, mode="a", header=False, index=False)
        others = [x for x in pool.map(compared, range(options.compared)) if x is not None]
    rows = pd.read_csv(options.rows)
    lines = [line for _, group in rows.groupby("processor", sort=False) for line in table(group)]
    if others:
        lines += [f"Against SciPy at 1e-9, {len(others)} impacts: at most {max(others):.1e} max(e, 1e-3)."]
    Path(__file__).with_suffix(".md").write_text("\n".join(lines).rstrip() + "\n")


if __name__ == "__main__":
    main()
