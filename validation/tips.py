"""Random measured tips of 20 to 2000 points under the exact method: does its tolerance hold, and what does an impact cost?

The error is that against `rtol = 1e-12`, and of the first tips against SciPy (`method="reference"`).

Usage: python validation/tips.py [--tips 10000] [--depths 20] [--compared 10] [--workers 2]
"""

import argparse
import os
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from rich.progress import track

import restitution as rs
from restitution.errors import InputError

KINDS = ("few points, rough", "noise", "quantised heights", "flat end, noise", "uneven spacing, waves")
RTOL = (1e-6, 1e-9)
WIDTH = 12.0


def draw_tip(seed: int) -> rs.Tabulated:
    """Draw a tip close to a paraboloid of radius 1, as an instrument would see it."""
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
    """Draw impacts of one tip on one standard solid, for depths over 1.7 decades; None for a tip that is refused."""
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


def errors(seed: int, depths: int) -> list[np.ndarray] | None:
    """Error of e over `rtol max(e, 1e-3)` at each tolerance; NaN where a solve failed."""
    impact = draw_impacts(seed, depths)
    if impact is None:
        return None
    wanted = rs.solve(impact, rtol=1e-12, workers=1).restitution_coefficient
    found = [rs.solve(impact, rtol=rtol, workers=1).restitution_coefficient for rtol in RTOL]
    return [np.abs(e - wanted) / rtol / np.maximum(wanted, 1e-3) for e, rtol in zip(found, RTOL, strict=True)]


def compared(seed: int) -> float | None:
    """Difference of e from SciPy's, both at 1e-9, over max(e, 1e-3)."""
    impact = draw_impacts(seed, 1)
    if impact is None:
        return None
    one = rs.Impact(impact.material, impact.profile, mass=float(np.ravel(impact.mass)[0]), velocity=1.0)
    e, other = (rs.solve(one, method, rtol=1e-9).restitution_coefficient for method in ("exact", "reference"))
    return abs(e - other) / max(other, 1e-3)


def main() -> None:
    """Write `tips.md`."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tips", type=int, default=10_000)
    parser.add_argument("--depths", type=int, default=20)
    parser.add_argument("--compared", type=int, default=10)
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    options = parser.parse_args()
    with ProcessPoolExecutor(options.workers) as pool:
        tasks = pool.map(errors, range(options.tips), [options.depths] * options.tips)
        rows = list(track(tasks, "tips", options.tips))
        others = [x for x in pool.map(compared, range(options.compared)) if x is not None]
    lines = [
        f"{options.tips:,} random tips, {options.depths} impacts each; processor of the compiler: "
        f"{os.environ.get('NUMBA_CPU_NAME') or 'this machine'}.",
        "",
        "| tip | solved tips | impacts | rtol | above rtol | failed | largest error over rtol max(e, 1e-3) |",
        "|" + "---|" * 7,
    ]
    for kind, name in enumerate(KINDS):
        own = [row for row in rows[kind :: len(KINDS)] if row is not None]
        for n, rtol in enumerate(RTOL):
            ratio = np.concatenate([row[n] for row in own]) if own else np.empty(0)
            lines.append(
                f"| {name} | {len(own):,} | {ratio.size:,} | {rtol:g} | {np.sum(ratio > 1.0):,} "
                f"| {np.sum(np.isnan(ratio)):,} | {np.nanmax(ratio, initial=0.0):.2f} |"
            )
    refused = sum(row is None for row in rows)
    lines += ["", f"Refused, because g(x) falls somewhere: {refused:,} tips."]
    if others:
        lines += [
            "",
            f"Against SciPy at 1e-9, {len(others)} impacts: at most {max(others):.1e} max(e, 1e-3).",
        ]
    Path(__file__).with_suffix(".md").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
