"""The profile of a case file: what the surface of the body is like where it touches."""

from __future__ import annotations

from typing import Annotated, Literal

from restitution.case.quantity import LENGTH, positive
from restitution.case.section import Section
from restitution.contact.profile import Parabola, Profile


class ParabolaSection(Section):
    """Paraboloid, the small-strain form of a sphere; without a radius, it has that of the body."""

    type: Literal["parabola"] = "parabola"
    radius: Annotated[float, positive(LENGTH)] | None = None

    @property
    def needs_body_radius(self) -> bool:
        """Whether the body has to have a radius."""
        return self.radius is None

    def build(self, body_radius: float | None) -> Profile:
        """Profile in SI."""
        return Parabola(self.radius or body_radius or 0.0)
