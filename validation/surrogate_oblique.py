"""Stated error of surrogates of impacts with friction, against solves at other velocities and slopes.

Run as `python validation/surrogate_oblique.py`; prints a table and writes it to `surrogate_oblique.md` beside this
file. It takes some minutes.
"""

from __future__ import annotations

import math
import time
import warnings
from pathlib import Path

import numpy as np

import restitution as rs

RANGE = (0.05, 2.0)
POINTS = 1000
E_T = "tangential_restitution_coefficient"

HEAD = f"""\
{POINTS} random points of each surrogate of e_t over {RANGE[0]:g} to {RANGE[1]:g} m/s: velocities at equal chances of
their logarithm, slopes v_c/(mu v0) from 0 to 7, solves at rtol = 1e-6. The ratio is the largest error over the stated
one; one is the limit. Boxes are those below and above the slope at which the glassy contact slides. The time is that
of the processor for the build.

| ball | rtol | boxes | stated | largest error | ratio | s |
|---|---|---|---|---|---|---|
"""


def balls() -> dict[str, rs.Impact]:
    """Return the impacts by name."""
    rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
    ball = rs.Impact(rubber, rs.Parabola(0.01), mass=0.005, velocity=1.0, friction=0.3)
    return {
        "rubber": ball,
        "incompressible": rs.vary(ball, {"poisson_ratio": 0.5}),
        "auxetic": rs.vary(ball, {"poisson_ratio": -0.5}),
        "elastic": rs.vary(ball, {"material": rs.elastic(shear_modulus=1e6, poisson_ratio=0.3)}),
        "Kelvin-Voigt": rs.vary(ball, {"material": rs.kelvin_voigt(1e6, 1e3, poisson_ratio=0.4)}),
        "epoxy": rs.vary(ball, {"material": rs.library.get("epoxy")}),
        "two materials": rs.vary(ball, {"counter_material": rs.standard_solid(3e6, 1e8, 1e4, poisson_ratio=0.2)}),
        "cone": rs.Impact(rubber, rs.Cone(1.2), mass=0.005, velocity=1.0, friction=0.3),
        "truncated cone": rs.Impact(rubber, rs.TruncatedCone(1e-4, 1.2), mass=0.005, velocity=1.0, friction=0.3),
        "shell, kappa = 2/3": rs.vary(ball, {"gyration": 2.0 / 3.0}),
        "kappa = 10": rs.vary(ball, {"gyration": 10.0}),
        "constant force": rs.vary(ball, {"external_force": 0.01}),
    }


def row(name: str, ball: rs.Impact, rtol: float, rng: np.random.Generator) -> str:
    """Build, measure, and return a row of the table."""
    start = time.process_time()
    curve = rs.surrogate(ball, RANGE, rtol)
    assert isinstance(curve, rs.ObliqueSurrogate)
    spent = time.process_time() - start
    v = np.exp(rng.uniform(math.log(RANGE[0]), math.log(RANGE[1]), POINTS)).clip(*RANGE)
    along = rng.uniform(0.0, 7.0, POINTS) * 0.3 * v
    exact = rs.solve(rs.vary(ball, {"velocity": v, "tangential_velocity": along}), rtol=1e-6)
    error = np.abs(curve.tangential_restitution_coefficient(v, along) - getattr(exact, E_T)).max()
    boxes = " + ".join(str(len(part.levels)) for part in (curve.sliding.sticks, curve.sliding.slips))
    cells = (name, f"{rtol:.0e}", boxes, f"{curve.error[E_T]:.1e}", f"{error:.1e}", f"{error / curve.error[E_T]:.2f}",
             f"{spent:.1f}")  # fmt: skip
    return "| " + " | ".join(cells) + " |"


def main() -> None:
    """Measure all, write the table."""
    warnings.simplefilter("ignore", rs.RestitutionWarning)
    rng = np.random.default_rng(2026)
    # The first build compiles.
    rs.surrogate(balls()["rubber"], (1.0, 1.1), 1e-2)
    rows = list[str]()
    for name, ball in balls().items():
        for rtol in (1e-3, 1e-5) if name == "rubber" else (1e-4,):
            rows.append(row(name, ball, rtol, rng))
            print(rows[-1], flush=True)
    Path(__file__).with_suffix(".md").write_text(HEAD + "\n".join(rows) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
