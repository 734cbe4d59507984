"""The profile of a case file: what the surface of the body is like where it touches."""

from __future__ import annotations

from abc import abstractmethod
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    BeforeValidator,
    Discriminator,
    InstanceOf,
    Tag,
    ValidationInfo,
    field_validator,
    model_validator,
)

from restitution.case.columns import read_columns
from restitution.case.quantity import ANGLE, LENGTH, LIST, NUMBER, Kind, nonnegative, positive, refuse, to_si
from restitution.case.section import Section, folder_of
from restitution.checks import positive as checked_positive
from restitution.contact.flat_ended import FlatEndedParabola, TruncatedCone
from restitution.contact.power_law import Cone, FlatPunch, PowerLaw
from restitution.contact.profile import Parabola, Profile
from restitution.contact.sphere import Sphere
from restitution.contact.tabulated import Tabulated

Length = Annotated[float, positive(LENGTH)]
Angle = Annotated[float, positive(ANGLE)]
Lengths = Annotated[list[Annotated[float, nonnegative(LENGTH)]], LIST]


class ProfileSection(Section):
    """What all profiles share."""

    @property
    def needs_body_radius(self) -> bool:
        """Whether the body has to have a radius."""
        return False

    @abstractmethod
    def build(self, body_radius: float | None) -> Profile:
        """Profile in SI."""


class ParabolaSection(ProfileSection):
    """Paraboloid, the small-strain form of a sphere; without a radius, it has that of the body."""

    type: Literal["parabola"] = "parabola"
    radius: Length | None = None

    @property
    def needs_body_radius(self) -> bool:
        """Whether the body has to have a radius."""
        return self.radius is None

    def build(self, body_radius: float | None) -> Profile:
        """Profile in SI."""
        return Parabola(self.radius or body_radius or 0.0)


class SphereSection(ProfileSection):
    """Exact circle; without a radius, it has that of the body."""

    type: Literal["sphere"]
    radius: Length | None = None

    @property
    def needs_body_radius(self) -> bool:
        """Whether the body has to have a radius."""
        return self.radius is None

    def build(self, body_radius: float | None) -> Profile:
        """Profile in SI."""
        return Sphere(self.radius or body_radius or 0.0)


class ConeSection(ProfileSection):
    """Cone, with half of its opening angle measured from the axis."""

    type: Literal["cone"]
    half_angle: Angle

    @model_validator(mode="after")
    def _check(self) -> ConeSection:
        self.build(None)
        return self

    def build(self, body_radius: float | None) -> Profile:
        """Profile in SI."""
        return Cone(self.half_angle)


class PowerLawSection(ProfileSection):
    """Power law f = A r^n, whose coefficient A has a unit that depends on n."""

    type: Literal["power_law"]
    exponent: Annotated[float, positive(NUMBER)]
    coefficient: float | str

    @model_validator(mode="after")
    def _check(self) -> PowerLawSection:
        try:
            self.build(None)
        except ValueError as error:
            message = str(error)
            refuse(
                message.partition(": ")[2] if message.startswith("coefficient") else message, "coefficient"
            )
        return self

    def build(self, body_radius: float | None) -> Profile:
        """Profile in SI."""
        value = self.coefficient
        if isinstance(value, str):
            power = 1.0 - self.exponent
            kind = Kind(f"coefficient of r^{self.exponent:g}", f"m^({power:g})", f"50 m^({power:g})")
            if power == 0.0:
                kind = NUMBER
            value = to_si(value, kind)
        return PowerLaw(self.exponent, checked_positive("coefficient", value))


class FlatPunchSection(ProfileSection):
    """Flat-ended cylinder."""

    type: Literal["flat_punch"]
    radius: Length

    def build(self, body_radius: float | None) -> Profile:
        """Profile in SI."""
        return FlatPunch(self.radius)


class TruncatedConeSection(ProfileSection):
    """Cone with a flat face, of which `radius` is the radius."""

    type: Literal["truncated_cone"]
    radius: Length
    half_angle: Angle

    @model_validator(mode="after")
    def _check(self) -> TruncatedConeSection:
        self.build(None)
        return self

    def build(self, body_radius: float | None) -> Profile:
        """Profile in SI."""
        return TruncatedCone(self.radius, self.half_angle)


class FlatEndedParabolaSection(ProfileSection):
    """Paraboloid with a worn face; without a radius of curvature, it has that of the body."""

    type: Literal["flat_ended_parabola"]
    radius: Length | None = None
    face_radius: Length

    @property
    def needs_body_radius(self) -> bool:
        """Whether the body has to have a radius."""
        return self.radius is None

    def build(self, body_radius: float | None) -> Profile:
        """Profile in SI."""
        return FlatEndedParabola(self.radius or body_radius or 0.0, self.face_radius)


class TabulatedSection(ProfileSection):
    """Measured profile: radii and heights, inline or in a CSV file with the columns r and f."""

    type: Literal["tabulated"] = "tabulated"
    file: InstanceOf[Tabulated] | None = None
    r: Lengths | None = None
    f: Lengths | None = None

    @field_validator("file", mode="before")
    @classmethod
    def _read(cls, value: Any, info: ValidationInfo) -> Tabulated:
        if not isinstance(value, str):
            refuse('must be the name of a CSV file, e.g. "tip.csv"')
        try:
            columns = read_columns(folder_of(info), value, {"r": LENGTH, "f": LENGTH})
            return Tabulated(columns["r"], columns["f"])
        except ValueError as error:
            refuse(str(error))

    @model_validator(mode="after")
    def _check(self) -> TabulatedSection:
        if self.file is not None:
            for key in self.given("r", "f"):
                refuse("stands in the file already; leave one of the two out", key)
        elif self.r is None or self.f is None:
            refuse("give file, or r and f")
        self.build(None)
        return self

    def build(self, body_radius: float | None) -> Profile:
        """Profile in SI."""
        return self.file or Tabulated(np.array(self.r), np.array(self.f))


_FORMS: dict[str, type[ProfileSection]] = {
    "parabola": ParabolaSection,
    "sphere": SphereSection,
    "cone": ConeSection,
    "power_law": PowerLawSection,
    "flat_punch": FlatPunchSection,
    "truncated_cone": TruncatedConeSection,
    "flat_ended_parabola": FlatEndedParabolaSection,
    "tabulated": TabulatedSection,
}


def _known_type(value: Any) -> Any:
    if isinstance(value, dict):
        if _type(value) not in _FORMS:
            names = ", ".join(f'"{name}"' for name in _FORMS)
            refuse(f"must be one of {names}", "type")
        if "type" not in value:
            own = _FORMS[_type(value)].model_fields
            for key in value:
                forms = [f'"{name}"' for name, form in _FORMS.items() if key in form.model_fields]
                if key not in own and forms:
                    refuse(f"belongs to another type; give type = {' or '.join(forms)}", key)
    return value


def _type(value: Any) -> Any:
    """Type of a profile: a table where one is given, a parabola where nothing is said."""
    if not isinstance(value, dict):
        return getattr(value, "type", "parabola")
    table = any(key in value for key in ("file", "r", "f"))
    return value.get("type", "tabulated" if table else "parabola")


AnyProfile = Annotated[
    Annotated[ParabolaSection, Tag("parabola")]
    | Annotated[SphereSection, Tag("sphere")]
    | Annotated[ConeSection, Tag("cone")]
    | Annotated[PowerLawSection, Tag("power_law")]
    | Annotated[FlatPunchSection, Tag("flat_punch")]
    | Annotated[TruncatedConeSection, Tag("truncated_cone")]
    | Annotated[FlatEndedParabolaSection, Tag("flat_ended_parabola")]
    | Annotated[TabulatedSection, Tag("tabulated")],
    Discriminator(_type),
    BeforeValidator(_known_type),
]
