"""The element scheme against the exact method: e of every profile for several numbers of elements.

Run as `python validation/profiles_elements.py`; prints a table and writes it to `profiles_elements.md` beside
this file. Takes about two minutes.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

import restitution as rs

N_ELEMENTS = [100, 200, 400, 800, 1600]
RADII = np.linspace(0.0, 2.0, 41)
PROFILES = {
    "Parabola(1)": rs.Parabola(1.0),
    "Sphere(1)": rs.Sphere(1.0),
    "Cone(1.2)": rs.Cone(1.2),
    "PowerLaw(0.7, 0.5)": rs.PowerLaw(0.7, 0.5),
    "PowerLaw(4, 0.5)": rs.PowerLaw(4.0, 0.5),
    "FlatPunch(0.5)": rs.FlatPunch(0.5),
    "TruncatedCone(0.3, 1.2)": rs.TruncatedCone(0.3, 1.2),
    "FlatEndedParabola(1, 0.3)": rs.FlatEndedParabola(1.0, 0.3),
    "Tabulated, round tip": rs.Tabulated(RADII, RADII**2 / 2.0 + 0.05 * RADII**4),
    "Tabulated, flat face": rs.Tabulated(np.append(0.0, RADII + 0.3), np.append(0.0, 0.5 * RADII)),
    "Tabulated, rough tip": rs.Tabulated(
        [0.0, 0.1, 0.3, 0.4, 0.7, 1.0, 1.5, 2.0], [0.0, 0.008, 0.03, 0.1, 0.25, 0.5, 1.3, 2.4]
    ),
}

INTRODUCTION = """\
# Every profile by elements

Made by `validation/profiles_elements.py`. The elements of the paper with explicit Euler use the transform g(x) of a
profile; the exact method uses the contact radius over the depth. nu = 0.3, p2 = 0.1, p3 = 1 in units of m = v0 =
Ginf = 1. The columns are the relative errors of e for each number of elements, the order between the last two, the
error after extrapolation of the first order, and the relative errors of the contact time and of the largest force
for the largest number. The last element of a sharp tip leaves late, because of its width.

"""


def line(name: str, profile: rs.Parabola) -> str:
    """One line of the table."""
    solid = rs.standard_solid(1.0, 10.0, 1.0, poisson_ratio=0.3)
    impact = rs.Impact(solid, profile, mass=1.0, velocity=1.0)
    exact = rs.solve(impact)
    results = [rs.solve(impact, method="elements", n_elements=n) for n in N_ELEMENTS]
    expected = exact.restitution_coefficient
    errors = [result.restitution_coefficient / expected - 1.0 for result in results]
    order = math.log2(errors[-2] / errors[-1])
    cells = [f"{error:.2e}" for error in errors]
    time = results[-1].contact_time / exact.contact_time - 1.0
    force = results[-1].max_force / exact.max_force - 1.0
    return (
        f"| `{name}` | {expected:.9f} | {' | '.join(cells)} | {order:.3f} | {2.0 * errors[-1] - errors[-2]:.0e} "
        f"| {time:.0e} | {force:.0e} |"
    )


def main() -> None:
    """Write `profiles_elements.md`."""
    counts = " | ".join(str(n) for n in N_ELEMENTS)
    lines = [
        f"| profile | exact e | {counts} | order | extrapolated | contact time | force |",
        "|---" * (len(N_ELEMENTS) + 6) + "|",
    ]
    for name, profile in PROFILES.items():
        lines.append(line(name, profile))
        print(lines[-1], flush=True)
    Path(__file__).with_suffix(".md").write_text(INTRODUCTION + "\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
