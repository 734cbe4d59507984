"""What laws without memory cannot do: their largest error of e over a decade of velocity, for three real materials.

Run as `python validation/memoryless.py`; prints a table and writes it to `memoryless.md` beside this file.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import restitution as rs

RADIUS = 0.005
DECADES = ((0.01, 0.1), (0.1, 1.0), (0.01, 1.0))
# Name in the library, temperature [K], and density [kg/m^3] where the source has none.
MATERIALS = (
    ("epoxy", None, None),
    ("dma_polymer", 268.15, 1200.0),
    ("polyisobutylene", 298.0, None),
    ("polyisobutylene", 318.0, None),
)
TARGETS = {"lammps-viscoelastic": "F = k (d^(3/2) + (3/2) A d^(1/2) v)", "lammps-coeff-restitution": "constant e"}

TEXT = """\
# Laws without memory: what they cannot do

Made by `validation/memoryless.py`.

<!-- table -->

Two equal balls (R = 5 mm) of materials of the library collide head on. For each range of velocities `rs.calibrate`
finds the law that is nearest to the exact e. The last two columns are the largest relative errors of e that remain in
the range. The density of the `dma_polymer` is assumed (1200 kg/m^3).

"""


def main() -> None:
    """Write `memoryless.md`."""
    lines = [
        "| material | velocities [m/s] | exact e | " + " | ".join(TARGETS.values()) + " |",
        "|---" * (3 + len(TARGETS)) + "|",
    ]
    for name, temperature, density in MATERIALS:
        material = rs.library.get(name)
        material = material if temperature is None else material.at(temperature)
        ball = rs.Body(replace(material, density=material.density or density), radius=RADIUS)
        words = name if temperature is None else f"{name}, {temperature - 273.15:.0f} °C"
        for velocity in DECADES:
            laws = [rs.calibrate((ball, ball), target, velocity) for target in TARGETS]
            e = laws[0].table["restitution_coefficient"].values
            cells = " | ".join(f"{100.0 * law.largest_error:.1f} %" for law in laws)
            lines.append(f"| {words} | {velocity[0]:g} to {velocity[1]:g} | {e[0]:.3f} to {e[-1]:.3f} | {cells} |")
            print(lines[-1], flush=True)
    Path(__file__).with_suffix(".md").write_text(TEXT + "\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
