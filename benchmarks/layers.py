"""Time of sweeps over the thickness of a layer, over that of the same number of impacts on a half-space.

Run as `python benchmarks/layers.py`. It takes a minute and prints two tables in Markdown: processor time of all
threads in the second of two equal sweeps, and that of the first one in brackets. The first one computes the contacts
of the profile, which the second one has already. The sweeps on the half-space have their tables already.

The second table is of a parabola on bonded layers, incompressible and with a Poisson ratio that relaxes. Its first
sweep also computes the effective moduli of the material.
"""

from __future__ import annotations

import time
import warnings
from typing import Any

import numpy as np

import restitution as rs
from restitution.contact.layer.contacts import contacts
from restitution.contact.layer.layer import effective_moduli

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
# Materials, and thicknesses and velocities, of the second table.
MATERIALS = {
    "incompressible": RUBBER,
    "Poisson ratio 0.32 to 0.45": rs.standard_solid(1e6, 3e6, 2e3, poisson_ratio=0.45),
    "Poisson ratio 0.28 to 0.45, 10 terms": rs.Material(
        rs.PronySeries(1e6, np.full(10, 4e5), np.geomspace(1e-6, 1e-1, 10)), 9.67e6
    ),
}
ARRAYS = (1, 300), (300, 10)


def seconds(profile: Any, name: str, values: Any, velocities: int, material: rs.Material = RUBBER) -> float:
    """Processor time of a sweep over an axis and the velocity."""
    ball = rs.Impact(material, profile, mass=0.004, velocity=0.05)
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
    print("\n| bonded layer | " + " | ".join(f"{n} thickness{'' if n == 1 else 'es'} x {m}" for n, m in ARRAYS) + " |")
    print("|---" * (1 + len(ARRAYS)) + "|")
    profile = PROFILES["parabola"]
    for words, material in MATERIALS.items():
        cells = []
        for n, m in ARRAYS:
            mass, thickness = rs.Linear(0.0035, 0.0045, n), rs.Logarithmic(2e-3, 0.02, n)
            if n == 1:
                mass, thickness = [0.004], [0.005]
            _, *half_space = (seconds(profile, "mass", mass, m, material) for _ in range(6))
            effective_moduli.cache_clear()
            first, *again = (seconds(rs.Layer(profile, 0.01), "thickness", thickness, m, material) for _ in range(6))
            cells.append(f"{min(again) / min(half_space):.1f} ({first / min(half_space):.1f})")
        print(f"| {words} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
