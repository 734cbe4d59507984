"""Order of the paper's element scheme: error of e for each number of elements, against the reduced equations.

Run as `python validation/elements_convergence.py`; prints a table and writes it to `elements_convergence.md`
beside this file. It takes about a minute.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

from restitution.contact.profiles import Parabola
from restitution.impact.elements import solve_elements
from restitution.impact.problem import Impact
from restitution.material.classical import standard_solid

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from scipy_oracle import solve_by_scipy

CASES = [(0.3, 0.1, 1.0), (0.45, 0.01, 3.0), (0.49, 0.001, 10.0)]
N_ELEMENTS = [100, 200, 400, 800, 1600, 3200]

INTRODUCTION = """\
# Convergence of the element scheme

Made by `validation/elements_convergence.py`. The table compares the scheme of the paper, eqs. (7) to (9), with
explicit Euler and the automatic time step, with the reduced equations by SciPy's Radau method at `rtol = 1e-11`
("exact"). The declared order is 1. The order in each line refers to the line before. The estimated error is that of
`solve_elements`, from half as many elements and twice the time step.

| nu | p2 | p3 | elements | time steps | e | relative error | estimated | order |
|---|---|---|---|---|---|---|---|---|
"""


def rows() -> list[str]:
    """One line of the table for each case and number of elements."""
    lines: list[str] = []
    for nu, p2, p3 in CASES:
        solid = standard_solid(1.0, 1.0 / p2, p3, poisson_ratio=nu)
        impact = Impact(material=solid, profile=Parabola(radius=1.0), mass=1.0, velocity=1.0)
        exact = solve_by_scipy(impact, 1e-11).restitution_coefficient
        before = math.nan
        for n in N_ELEMENTS:
            result = solve_elements(impact, n_elements=n)
            error = result.restitution_coefficient / exact - 1.0
            estimate = result.restitution_error / exact
            order = f"{math.log2(before / error):.3f}" if math.isfinite(before) else ""
            lines.append(
                f"| {nu} | {p2} | {p3} | {n} | {result.time.size - 1} | {result.restitution_coefficient:.8f} "
                f"| {error:.3e} | {estimate:.3e} | {order} |"
            )
            print(lines[-1], flush=True)
            before = error
        lines.append(f"| {nu} | {p2} | {p3} | exact | | {exact:.8f} | | | |")
        print(lines[-1], flush=True)
    return lines


if __name__ == "__main__":
    target = Path(__file__).with_suffix(".md")
    target.write_text(INTRODUCTION + "\n".join(rows()) + "\n", encoding="utf-8")
