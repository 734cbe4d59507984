"""Time of sweeps over the thickness of a layer, over that of the same number of impacts on a half-space.

Run as `python benchmarks/layers.py`. It takes half a minute and prints a table in Markdown: processor time of all
threads, with the tables of the layers. The sweeps on the half-space have their tables already.
"""

from __future__ import annotations

import time
import warnings
from dataclasses import replace
from typing import Any

import numpy as np

import restitution as rs

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
        ratios = []
        for n, m in SWEEPS:
            mass = rs.Linear(0.0035, 0.0045, n)
            seconds(profile, "mass", mass, m)
            half_space = seconds(profile, "mass", mass, m)
            own = replace(profile)
            ratios.append(seconds(rs.Layer(own, 0.01), "thickness", rs.Logarithmic(5e-4, 0.05, n), m) / half_space)
        print(f"| {words} | " + " | ".join(f"{ratio:.1f}" for ratio in ratios) + " |")


if __name__ == "__main__":
    main()
