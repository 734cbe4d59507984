"""Time of sweeps over the thickness of a layer, over that of the same number of impacts on a half-space.

Run as `python benchmarks/layers.py`. It takes half a minute and prints a table in Markdown: processor time of all
threads in the second of two equal sweeps, and that of the first one in brackets. The first one computes the contacts
of the profile, which the second one has already. The sweeps on the half-space have their tables already.
"""

from __future__ import annotations

import time
import warnings
from typing import Any

import numpy as np

import restitution as rs
from restitution.contact.layer.contacts import contacts

# Thicknesses and velocities of a sweep.
SWEEPS = (3000, 1), (300, 10), (300, 40)
RADIUS = 0.005
R = np.linspace(0.0, 0.004, 41)
ROUGH = 1.0 + 0.005 * np.random.default_rng(1).random(R.size)
PROFILES = {
    "parabola": rs.Parabola(RADIUS),
    "sphere": rs.Sphere(RADIUS),
    "flat-ended parabola": rs.FlatEndedParabola(RADIUS, 3e-4),
    "truncated cone": rs.TruncatedCone(3e-4, 1.3),
    "smooth table of 41 points": rs.Tabulated(R, R**2 / (2.0 * RADIUS) + R**4 / (8.0 * RADIUS**3)),
    "rough table of 41 points": rs.Tabulated(R, R**2 / (2.0 * RADIUS) * ROUGH),
}
OUTPUTS = ["restitution_coefficient", "contact_time", "max_force"]
RUBBER = rs.standard_solid(1e6, 3e6, 2e3, poisson_ratio=0.5)


def seconds(profile: Any, name: str, values: Any, velocities: int) -> float:
    """Processor time of a sweep over an axis and the velocity."""
    ball = rs.Impact(RUBBER, profile, mass=0.004, velocity=0.05)
    start = time.process_time()
    rs.sweep(ball, {name: values, "velocity": rs.Linear(0.01, 0.2, velocities)}, OUTPUTS, workers=1)
    return time.process_time() - start


def main() -> None:
    """Print the table."""
    warnings.simplefilter("ignore")
    for profile in (rs.Cone(1.3), rs.Sphere(0.006)):
        seconds(rs.Layer(profile, 0.01), "thickness", rs.Logarithmic(5e-4, 0.05, 10), 1)
    print("| profile | " + " | ".join(f"{n} thicknesses x {m}" for n, m in SWEEPS) + " |")
    print("|---" * (1 + len(SWEEPS)) + "|")
    for words, profile in PROFILES.items():
        cells = []
        for n, m in SWEEPS:
            mass, thickness = rs.Linear(0.0035, 0.0045, n), rs.Logarithmic(5e-4, 0.05, n)
            _, *half_space = (seconds(profile, "mass", mass, m) for _ in range(4))
            contacts.cache_clear()
            first, *again = (seconds(rs.Layer(profile, 0.01), "thickness", thickness, m) for _ in range(4))
            cells.append(f"{min(again) / min(half_space):.1f} ({first / min(half_space):.1f})")
        print(f"| {words} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
