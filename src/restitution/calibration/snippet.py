"""Text to paste into an input file of a code."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

from restitution.calibration.collisions import Collisions
from restitution.calibration.laws import Law, TypedLaw
from restitution.calibration.units import DURATION, REDUCED, SI, Powers, UnitSystem

# With so many steps in a contact the error of e by velocity Verlet is of order 1e-4 (validation/lammps.md).
_STEPS = 100


def snippet(law: Law, parameters: Mapping[str, Any], contact: TypedLaw, wanted: Collisions, system: UnitSystem) -> str:
    """Return the text of a law with its numbers, after comments on what they hold for."""
    template = law.wall if wanted.pair.wall else law.pair
    text = template.format(**{name: f"{one.value:.8g}" for name, one in parameters.items()})
    return "\n".join([*(law.comment.format(line) for line in _remarks(law, contact, wanted, system)), text, ""])


def _remarks(law: Law, contact: TypedLaw, wanted: Collisions, system: UnitSystem) -> list[str]:
    low, high = float(wanted.velocity[0]), float(wanted.velocity[-1])
    speeds = f"{low:.4g} m/s" if low == high else f"{low:.4g} to {high:.4g} m/s"
    bodies = "a ball and a wall" if wanted.pair.wall else "two balls"
    _, times = contact.rebound(high, wanted.mass, wanted.reduced_radius)
    step = system.convert(float(times.min()) / _STEPS, DURATION)
    lines = [f"restitution {version('restitution')}: {law.words}", f"{bodies} at {speeds}"]
    if wanted.radius.size > 1:
        lines[-1] += f", radii {wanted.radius[0]:.4g} to {wanted.radius[-1]:.4g} m"
    else:
        mass, radius = Powers(mass=1), Powers(length=1)
        lines[-1] += "".join(
            f", {name} = {f'{system.convert(value, powers):.6g} {system.unit(powers)}'.rstrip()}"
            for name, value, powers in (
                ("m_eff", float(wanted.mass[0]), mass), ("R_eff", float(wanted.reduced_radius[0]), radius),
            )
        )  # fmt: skip
    lines += law.notes
    name = "SI units" if system == SI else f"units {system.name}"
    if system.name == REDUCED:
        name += f", in which {system.mass:.6g} kg, {system.length:.6g} m and {system.time:.6g} s are 1"
    return [*lines, f"{name}; time step at most {f'{step:.3g} {system.unit(DURATION)}'.rstrip()}"]
