"""Standards of rebound resilience: the indentor, its mass and velocity, the pad, and the source of each number."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from restitution.impact.problem import STANDARD_GRAVITY, fall_velocity


@dataclass(frozen=True)
class Standard:
    """A test of rebound resilience.

    Attributes
    ----------
    name, words : str
        Name of the standard, and the test in words.
    radius, mass : float or None
        Radius [m] of the rigid spherical indentor and its mass [kg]; None where no reliable source was found.
    velocity : float
        Impact velocity [m/s].
    thickness : float
        Thickness of the pad [m].
    sources : dict of str
        Source of each number: a key of `citation/references.bib`, and its words there.
    falls : bool
        Whether the weight acts along the motion.
    """

    name: str
    words: str
    radius: float | None
    mass: float | None
    velocity: float
    thickness: float
    sources: Mapping[str, str]
    falls: bool = False

    @property
    def keys(self) -> list[str]:
        """Keys of the sources in `citation/references.bib`."""
        return list(dict.fromkeys(text.partition(":")[0] for text in self.sources.values()))


_SCHOB = (
    "Schob pendulum",
    0.0075,
    0.25,
    1.98,
    0.0125,
    MappingProxyType({
        "radius": "schob: hemisphere of 15 mm diameter",
        "mass": "schob: 0.5 J at 1.98 m/s, to two digits",
        "velocity": "schob: released at 90 degrees with a length of 200 mm, 1.98 m/s",
        "thickness": "gbt1681: pad of ISO 4662, to whose pendulums that of Schob belongs, 12.5 mm",
    }),
)  # fmt: skip


def _fall(height: float) -> float:
    return float(fall_velocity(height, STANDARD_GRAVITY))


STANDARDS = {
    one.name: one
    for one in (
        Standard(
            "ISO 4662", "pendulum with the nominal numbers", 0.00625, 0.35, 1.4, 0.0125,
            {
                "radius": "gbt1681: 12.5 mm, the diameter D within 12.45 to 15.05 mm for which m v^2/(D d^2) has its "
                "nominal 351 kJ/m3",
                "mass": "gbt1681: 0.35 kg (nominal)",
                "velocity": "gbt1681: 1.4 m/s (nominal)",
                "thickness": "gbt1681: 12.5 mm +- 0.5 mm",
            },
        ),
        Standard("DIN 53512", *_SCHOB),
        Standard("ASTM D7121", *_SCHOB),
        Standard(
            "ASTM D2632", "plunger that falls", None, None, _fall(0.4), 0.0125,
            {
                "velocity": "verticalrebound: scale of 100 divisions of 4 mm, a fall of 400 mm",
                "thickness": "verticalrebound: test piece of 12.5 mm",
            },
            falls=True,
        ),
        Standard(
            "ISO 8307", "ball that falls on foam", 0.008, 0.0168, _fall(0.5), 0.05,
            {
                "radius": "iso8307: ball of 16 mm +- 0.5 mm diameter",
                "mass": "iso8307: 16.8 g +- 1.5 g",
                "velocity": "iso8307: fall of 500 mm",
                "thickness": "iso8307: at least 50 mm",
            },
            falls=True,
        ),
        Standard(
            "ASTM D3574", "ball that falls on foam (test H)", 0.008, 0.0163, _fall(0.5), 0.05,
            {
                "radius": "ballrebound: ball of 16 mm diameter",
                "mass": "ballrebound: 16.3 g",
                "velocity": "ballrebound: fall of 500 mm",
                "thickness": "ballrebound: test piece of 50 mm",
            },
            falls=True,
        ),
    )
}  # fmt: skip
"""Standards by name. The tripsometer of ISO 4662 and ASTM D1054 are left out: no source had their numbers."""
