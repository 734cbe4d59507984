"""The profile of a case file: the shape of the body's surface where it touches.

The section of each type follows from the constructor of the profile, so that a new profile is one class.
"""

from __future__ import annotations

from functools import cache
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import (
    BeforeValidator,
    InstanceOf,
    SerializeAsAny,
    ValidationInfo,
    create_model,
    field_validator,
    model_validator,
)

from restitution.case.columns import read_columns
from restitution.case.quantity import fields_of, to_si
from restitution.case.section import FROM_FILE, Forms, Section, folder_of, refuse, toml_value

# Importing a profile registers it.
from restitution.contact import analytic, power_law, tabulated  # noqa: F401  # pyright: ignore[reportUnusedImport]
from restitution.contact.power_law import PowerLaw
from restitution.contact.profile import Profile
from restitution.contact.tabulated import Tabulated
from restitution.errors import InputError
from restitution.material.models import constants_of
from restitution.quantities import LENGTH, NUMBER, Dimension

_TABLE = ("file", "r", "f")


class ProfileSection(Section):
    """Surface of the body at the contact. A type without a radius of its own has that of the body."""

    profile: ClassVar[type[Profile]]
    type: str

    def number(self, key: str) -> Any:
        """Return the value of a key of the constructor."""
        return getattr(self, key)

    @property
    def needs_body_radius(self) -> bool:
        """Whether the radius is that of the body."""
        return self.profile.body_radius and self.number("radius") is None

    @model_validator(mode="after")
    def _check(self) -> ProfileSection:
        self.build(1.0)
        return self

    def build(self, body_radius: float | None) -> Profile:
        """Profile in SI."""
        given = self.model_dump(exclude={"type"}, exclude_none=True)
        if self.needs_body_radius:
            given["radius"] = body_radius
        return self.profile(**given)


class PowerLawSection(ProfileSection):
    """Power law f = A r^n, whose coefficient A has a unit that depends on n."""

    coefficient: float | str

    def build(self, body_radius: float | None) -> Profile:
        exponent, value = float(self.number("exponent")), self.coefficient
        if isinstance(value, str):
            power = 1.0 - exponent
            unit = Dimension(f"coefficient of r^{exponent:g}", f"m^({power:g})", f"50 m^({power:g})")
            try:
                value = to_si(value, unit if power else NUMBER)
            except InputError as error:
                refuse(error.wanted, "coefficient", self.coefficient)
        return PowerLaw(exponent, value)


class TabulatedSection(ProfileSection):
    """Measured profile: radii and heights, inline or in a CSV file with the columns r and f."""

    file: Annotated[InstanceOf[Tabulated], FROM_FILE] | None = None

    @field_validator("file", mode="before")
    @classmethod
    def _read(cls, value: Any, info: ValidationInfo) -> Tabulated:
        if not isinstance(value, str):
            refuse('must be the name of a CSV file, e.g. "tip.csv"')
        columns = read_columns(folder_of(info), value, {"r": LENGTH, "f": LENGTH})
        return Tabulated(columns["r"], columns["f"])

    def build(self, body_radius: float | None) -> Profile:
        r, f = self.number("r"), self.number("f")
        if self.file is not None:
            for key in self.given("r", "f"):
                refuse("stands in the file already; leave one of the two out", key)
            return self.file
        if r is None or f is None:
            refuse("give file, or r and f")
        return Tabulated(np.array(r), np.array(f))


_SPECIAL: dict[str, type[ProfileSection]] = {"power_law": PowerLawSection, "tabulated": TabulatedSection}


def sections() -> dict[str, type[ProfileSection]]:
    """Section of each registered profile by its type."""
    return {name: _section(name, profile) for name, profile in Profile.registered.items()}


@cache
def _section(name: str, profile: type[Profile]) -> type[ProfileSection]:
    base = _SPECIAL.get(name, ProfileSection)
    default = name if name in ("parabola", "tabulated") else ...
    keys: dict[str, Any] = {"type": (Literal[name], default), **fields_of(constants_of(profile).values())}
    if "coefficient" in base.model_fields:
        del keys["coefficient"]
    for key in keys:
        if key in _TABLE or (key == "radius" and profile.body_radius):
            keys[key] = (keys[key][0] | None, None)
    first_line = (profile.__doc__ or "").partition("\n")[0]
    section = create_model(f"{profile.__name__}Section", __base__=base, __doc__=first_line, **keys)
    section.profile = profile
    return section


def _chosen(value: Any, info: ValidationInfo) -> Any:
    """Check a table by the section of its type: a table of points where one is given, a parabola by default."""
    if not isinstance(value, dict):
        return value
    known = sections()
    name = value.get("type", "tabulated" if any(key in value for key in _TABLE) else "parabola")
    if name not in list(known):
        refuse(f"must be one of {', '.join(map(toml_value, known))}", "type", value["type"])
    for key in () if "type" in value else value:
        forms = [toml_value(other) for other, form in known.items() if key in form.model_fields]
        if key not in known[name].model_fields and forms:
            refuse(f"belongs to another type; give type = {' or '.join(forms)}", key)
    return known[name].model_validate(value, context=info.context)


AnyProfile = Annotated[SerializeAsAny[ProfileSection], BeforeValidator(_chosen), Forms(lambda: sections().values())]
