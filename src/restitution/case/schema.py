"""The sections of a case file that describe an impact."""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, Literal

from pydantic import StrictBool, StrictInt, model_validator

from restitution.case.bounces import BouncesSection
from restitution.case.material import AnyMaterial
from restitution.case.profile import AnyProfile, ParabolaSection
from restitution.case.quantity import (
    ACCELERATION,
    DENSITY,
    FORCE,
    LENGTH,
    MASS,
    NUMBER,
    TIME,
    VELOCITY,
    nonnegative,
    positive,
    refuse,
)
from restitution.case.section import Section
from restitution.impact.problem import STANDARD_GRAVITY, Impact
from restitution.impact.window import for_contact
from restitution.material.fractional import Window


class BodySection(Section):
    """The body that hits: its mass, or its density as a solid sphere."""

    mass: Annotated[float, positive(MASS)] | None = None
    density: Annotated[float, positive(DENSITY)] | None = None
    radius: Annotated[float, positive(LENGTH)] | None = None

    @model_validator(mode="after")
    def _check(self) -> BodySection:
        if self.one_of("mass", "density") == "density" and self.radius is None:
            refuse("is missing; a mass from the density takes the radius of the sphere", "radius")
        return self

    @property
    def kilograms(self) -> float:
        """Mass [kg], that of a solid sphere where a density is given."""
        if self.mass is not None:
            return self.mass
        return (self.density or 0.0) * 4.0 / 3.0 * math.pi * (self.radius or 0.0) ** 3


class ImpactSection(Section):
    """How the body hits: its velocity or the height of its fall, and a force that keeps pressing it on."""

    velocity: Annotated[float, positive(VELOCITY)] | None = None
    drop_height: Annotated[float, positive(LENGTH)] | None = None
    gravity: Annotated[float, positive(ACCELERATION)] = STANDARD_GRAVITY
    external_force: Annotated[float, nonnegative(FORCE)] | None = None
    weight: StrictBool | None = None

    @model_validator(mode="after")
    def _check(self) -> ImpactSection:
        self.one_of("velocity", "drop_height")
        if self.weight and self.external_force is not None:
            refuse("give external_force or weight = true, not both")
        return self

    @property
    def impact_velocity(self) -> float:
        """Velocity at first touch [m/s]; sqrt(2 g h) after a fall."""
        return self.velocity or math.sqrt(2.0 * self.gravity * (self.drop_height or 0.0))

    def pressing_force(self, mass: float) -> float:
        """Constant force on the body during the impact [N]."""
        return mass * self.gravity if self.weight else self.external_force or 0.0


class SolverSection(Section):
    """How the problem is solved, and how accurately."""

    method: Literal["exact", "elements", "reference"] = "exact"
    rtol: Annotated[float, positive(NUMBER)] | None = None
    n_elements: StrictInt | None = None
    time_step: Annotated[float, positive(TIME)] | None = None

    @model_validator(mode="after")
    def _check(self) -> SolverSection:
        for key in self.given("n_elements", "time_step"):
            if self.method != "elements":
                refuse(f'is an option of method = "elements", not of method = "{self.method}"', key)
        if self.n_elements is not None and self.n_elements < 1:
            refuse("must be >= 1", "n_elements")
        return self

    @property
    def options(self) -> dict[str, Any]:
        """Keyword arguments of `solve`."""
        return self.model_dump(exclude_none=True)


class CaseFile(Section):
    """A whole case file."""

    elsewhere: ClassVar[dict[str, str]] = {
        "indentation": "a prescribed indentation is for `restitution indent`",
        "axes": "axes are for `restitution sweep`",
    }

    title: str | None = None
    body: BodySection
    profile: AnyProfile = ParabolaSection()
    material: AnyMaterial
    counter_material: AnyMaterial | None = None
    impact: ImpactSection
    bounces: BouncesSection = BouncesSection()
    solver: SolverSection = SolverSection()

    @model_validator(mode="after")
    def _check(self) -> CaseFile:
        if self.profile.needs_body_radius and self.body.radius is None:
            refuse("is missing; the profile takes its radius", "body", "radius")
        return self

    @property
    def needs_window(self) -> bool:
        """Whether a material is fractional, and so can only be had for a window of time."""
        return any(part is not None and part.needs_window for part in (self.material, self.counter_material))

    def build(self, window: Window | None = None) -> Impact:
        """Impact in SI.

        Parameters
        ----------
        window
            Where fractional models have to hold; that of the contact if left out.
        """
        if window is None and self.needs_window:
            return for_contact(self.build)
        mass = self.body.kilograms
        return Impact(
            material=self.material.build(window),
            profile=self.profile.build(self.body.radius),
            mass=mass,
            velocity=self.impact.impact_velocity,
            counter_material=None if self.counter_material is None else self.counter_material.build(window),
            external_force=self.impact.pressing_force(mass),
        )
