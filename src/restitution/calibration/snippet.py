"""Text to paste into an input file of a code."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

from restitution.calibration.collisions import Collisions
from restitution.calibration.laws import TypedLaw
from restitution.calibration.units import DURATION, REDUCED, SI, Powers, UnitSystem

# With so many steps in a contact the error of e by velocity Verlet is of order 1e-4 (validation/lammps.md).
_STEPS = 100


def snippet(found: TypedLaw, parameters: Mapping[str, Any], wanted: Collisions, system: UnitSystem) -> str:
    """Return the text of a law with its numbers, after comments on what they hold for."""
    law, numbers = found.law, {name: f"{one.value:.8g}" for name, one in parameters.items()}
    remarks = [*heading(law.words, wanted, system), *(note.format(**numbers) for note in law.notes)]
    _, times = found.rebound(float(wanted.velocity[-1]), wanted.mass, wanted.reduced_radius)
    remarks.append(f"time step at most {_amount(float(times.min()) / _STEPS, DURATION, system)}")
    text = (law.wall if wanted.pair.wall else law.pair).format(**numbers)
    return "\n".join([*(law.comment.format(line) for line in remarks), text, ""])


def heading(words: str, wanted: Collisions, system: UnitSystem) -> list[str]:
    """Return lines on the code, the bodies, their velocities and the units."""
    low, high = float(wanted.velocity[0]), float(wanted.velocity[-1])
    speeds = f"{low:.4g} m/s" if low == high else f"{low:.4g} to {high:.4g} m/s"
    line = f"{wanted.pair.words} at {speeds}"
    if wanted.radius.size > 1:
        line += f", radii {wanted.radius[0]:.4g} to {wanted.radius[-1]:.4g} m"
    else:
        mass, radius = float(wanted.mass[0]), float(wanted.reduced_radius[0])
        line += (
            f", m_eff = {_amount(mass, Powers(mass=1), system)}, R_eff = {_amount(radius, Powers(length=1), system)}"
        )
    units = "SI units" if system == SI else f"units {system.name}"
    if system.name == REDUCED:
        units += f", in which {system.mass:.6g} kg, {system.length:.6g} m and {system.time:.6g} s are 1"
    return [f"restitution {version('restitution')}: {words}", line, units]


def _amount(value: float, powers: Powers, system: UnitSystem) -> str:
    return f"{system.convert(value, powers):.6g} {system.unit(powers)}".rstrip()
