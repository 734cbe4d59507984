"""Stated error of surrogates over the velocity, against the exact method at 10 000 other velocities.

Run as `python validation/surrogate_error.py`; prints a table and writes it to `surrogate_error.md` beside this file.
It takes a minute.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

import restitution as rs
from restitution.surrogates.velocity import OUTPUTS

RANGE = (1e-3, 10.0)
MATERIALS, VELOCITIES = 30, 10_000

HEAD = f"""\
# Error of surrogates

Made by `validation/surrogate_error.py`: {MATERIALS} random materials (1 to 5 branches, relaxation times over five
decades, moduli over four) under a parabola, a cone or a sphere, tolerances of 1e-8 to 1e-4, velocities of
{RANGE[0]:g} to {RANGE[1]:g} m/s. The last columns are the largest error at {VELOCITIES} random velocities over the
stated one; one is the limit. The exact solves have a tolerance of rtol/10^6, but not below 1e-12. One piece takes
41 solves; a piece that was halved counts too.

| profile | branches | rtol | pieces | stated for e | e | contact time | largest force |
|---|---|---|---|---|---|---|---|
"""


def random_impact(rng: np.random.Generator) -> tuple[rs.Impact, float]:
    """Draw an impact and a tolerance."""
    n = int(rng.integers(1, 6))
    series = rs.PronySeries(
        10.0 ** rng.uniform(4.0, 7.0), 10.0 ** rng.uniform(4.0, 8.0, n), 10.0 ** rng.uniform(-6.0, -1.0, n)
    )
    material = rs.Material(series, bulk=10.0 ** rng.uniform(7.0, 10.0))
    profile = (rs.Parabola(0.01), rs.Cone(1.2), rs.Sphere(0.01))[rng.choice(3, p=[0.7, 0.2, 0.1])]
    impact = rs.Impact(material, profile, mass=10.0 ** rng.uniform(-3.0, -1.0), velocity=1.0)
    return impact, 10.0 ** rng.uniform(-8.0, -4.0)


def ratios(impact: rs.Impact, surrogate: rs.Surrogate, rng: np.random.Generator) -> list[float]:
    """Largest error of each output at random velocities, over the stated one."""
    v = np.clip(np.exp(rng.uniform(*np.log(RANGE), VELOCITIES)), *RANGE)
    exact = rs.solve(replace(impact, velocity=v), rtol=max(1e-6 * surrogate.rtol, 1e-12))
    results: list[float] = []
    for name in OUTPUTS:
        truth = getattr(exact, name)
        least = 1e-3 if name == "restitution_coefficient" else 0.0
        error = np.abs(getattr(surrogate, name)(v) - truth) / np.maximum(truth, least)
        results.append(float(error.max() / surrogate.error[name]))
    return results


def main() -> None:
    """Draw, measure, write the table."""
    rng = np.random.default_rng(2026)
    rows: list[str] = []
    worst = np.zeros(len(OUTPUTS))
    while len(rows) < MATERIALS:
        impact, rtol = random_impact(rng)
        surrogate = rs.surrogate(impact, RANGE, rtol)
        shares = ratios(impact, surrogate, rng)
        worst = np.maximum(worst, shares)
        pieces = surrogate.pieces.edges.size - 1
        cells = (
            type(impact.profile).__name__, impact.material.shear.n_branches, f"{rtol:.1e}", pieces,
            f"{surrogate.error['restitution_coefficient']:.1e}", *(f"{ratio:.2f}" for ratio in shares),
        )  # fmt: skip
        rows.append("| " + " | ".join(map(str, cells)) + " |")
        print(rows[-1], flush=True)
    foot = "\n\nThe worst of each output: " + ", ".join(f"{ratio:.2f}" for ratio in worst) + ".\n"
    Path(__file__).with_suffix(".md").write_text(HEAD + "\n".join(rows) + foot, encoding="utf-8")
    print(foot)


if __name__ == "__main__":
    main()
