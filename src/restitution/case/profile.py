"""The profile of a case file: the shape of the body's surface where it touches, on a half-space or on a layer.

The section of each type follows from the constructor of the geometry, so that a new geometry is one class.
"""

from __future__ import annotations

from functools import cache, cached_property
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import (
    BeforeValidator,
    Field,
    InstanceOf,
    SerializeAsAny,
    ValidationInfo,
    create_model,
    field_validator,
    model_validator,
)

from restitution.case.quantity import Reader, fields_of, read_columns
from restitution.case.section import FROM_FILE, IN_FILE, Forms, Section, folder_of, refuse, toml_value

# Importing a profile registers it.
from restitution.contact import (  # noqa: F401
    force_law,  # pyright: ignore[reportUnusedImport]
    tabulated,  # pyright: ignore[reportUnusedImport]
    tips,  # pyright: ignore[reportUnusedImport]
)
from restitution.contact.geometry import Geometry
from restitution.contact.layer.layer import Layer
from restitution.contact.profiles import PowerLaw, Profile
from restitution.errors import InputError
from restitution.material.models import constants_of
from restitution.quantities import FORCE, INPUTS, LENGTH, NUMBER, Dimension
from restitution.units import to_si

_TABLE = ("file", "r", "f")
_COLUMNS = ("r", "f", "depth", "force")
_THICKNESS: Any = Annotated[float, Reader(INPUTS["thickness"])]
LAYER: dict[str, Any] = {
    "thickness": (_THICKNESS | None, None),
    "base": (Literal["bonded", "frictionless"] | None, None),
    "strict": (bool | None, Field(None, strict=True)),
}
"""Fields of a profile whose target is a layer."""


class ProfileSection(Section):
    """Surface of the body at the contact. A type without a radius has that of the body."""

    geometry: ClassVar[type[Geometry]]
    type: str

    @property
    def needs_body_radius(self) -> bool:
        """Whether the radius is that of the body."""
        return self.geometry.body_radius and getattr(self, "radius", None) is None

    @property
    def on_layer(self) -> bool:
        """Whether the target is a layer."""
        return getattr(self, "thickness", None) is not None

    @model_validator(mode="after")
    def _check(self) -> ProfileSection:
        # Pydantic checks twice: the section, and once more as the field of a case.
        _ = self._of_unit_radius
        return self

    @cached_property
    def _of_unit_radius(self) -> Geometry:
        return self._geometry(1.0)

    def build(self, body_radius: float | None) -> Geometry:
        """Return the geometry in SI."""
        return self._geometry(body_radius) if self.needs_body_radius else self._of_unit_radius

    def _geometry(self, body_radius: float | None) -> Geometry:
        body, options = self.body(body_radius), self.values(LAYER)
        if self.on_layer:
            return Layer(body, **options)
        for key, value in options.items():
            refuse("belongs to a layer; give its thickness", key, value)
        return body

    def body(self, body_radius: float | None) -> Any:
        """Return the geometry of the body on a half-space, in SI."""
        numbers = self.values(key for key in type(self).model_fields if key not in ("type", *LAYER))
        if self.needs_body_radius:
            numbers["radius"] = body_radius
        return self.geometry(**numbers)


class PowerLawSection(ProfileSection):
    """Power law f = A r^n, whose coefficient A has a unit that depends on n."""

    coefficient: float | str

    def body(self, body_radius: float | None) -> PowerLaw:
        exponent, value = float(vars(self)["exponent"]), self.coefficient
        if isinstance(value, str):
            power = 1.0 - exponent
            unit = Dimension(f"coefficient of r^{exponent:g}", f"m^({power:g})", f"50 m^({power:g})")
            try:
                value = to_si(value, unit if power else NUMBER)
            except InputError as error:
                refuse(error.rule, "coefficient", self.coefficient)
        return PowerLaw(exponent, value)


class PyramidSection(ProfileSection):
    """Sharp tip with some faces."""

    sides: Annotated[Literal[3, 4, 6], Field(description="number of faces")] = 4


class TableSection(ProfileSection):
    """Geometry given by two columns, inline or in a CSV file."""

    columns: ClassVar[dict[str, Dimension]]
    file: Annotated[InstanceOf[dict[str, Any]], FROM_FILE] | None = None

    @field_validator("file", mode="before")
    @classmethod
    def _read(cls, value: Any, info: ValidationInfo) -> dict[str, Any]:
        if not isinstance(value, str):
            refuse('must be the name of a CSV file, e.g. "tip.csv"')
        return read_columns(folder_of(info), value, cls.columns)

    def body(self, body_radius: float | None) -> Geometry:
        others = self.model_dump(exclude={"type", "file", *self.columns, *LAYER}, exclude_none=True)
        if self.file is not None:
            self.refuse_present(IN_FILE, *self.columns)
            try:
                return self.geometry(**self.file, **others)
            except ValueError as error:
                refuse(str(error), "file")
        if len(self.present(*self.columns)) < len(self.columns):
            refuse(f"give file, or {' and '.join(self.columns)}")
        return self.geometry(**{key: np.array(column) for key, column in self.values(self.columns).items()}, **others)


class TabulatedSection(TableSection):
    """Measured profile: radii and heights."""

    columns: ClassVar[dict[str, Dimension]] = {"r": LENGTH, "f": LENGTH}


class ForceLawSection(TableSection):
    """Elastic force over the depth."""

    columns: ClassVar[dict[str, Dimension]] = {"depth": LENGTH, "force": FORCE}


_SPECIAL: dict[str, type[ProfileSection]] = {
    "power_law": PowerLawSection, "pyramid": PyramidSection, "tabulated": TabulatedSection,
    "force_law": ForceLawSection,
}  # fmt: skip


def sections() -> dict[str, type[ProfileSection]]:
    """Return the section of each registered geometry by its type."""
    return {name: _section(name, geometry) for name, geometry in Geometry.registered.items()}


@cache
def _section(name: str, geometry: type[Geometry]) -> type[ProfileSection]:
    base = _SPECIAL.get(name, ProfileSection)
    default = name if name in ("parabola", "tabulated") else ...
    keys: dict[str, Any] = {"type": (Literal[name], default), **fields_of(constants_of(geometry).values())}
    keys = {key: field for key, field in keys.items() if key == "type" or key not in base.model_fields}
    for key in keys:
        if key in _COLUMNS or (key == "radius" and geometry.body_radius):
            keys[key] = (keys[key][0] | None, None)
    if issubclass(geometry, Profile):
        keys |= LAYER
    first_line = (geometry.__doc__ or "").partition("\n")[0]
    section = create_model(f"{geometry.__name__}Section", __base__=base, __doc__=first_line, **keys)
    section.geometry = geometry
    return section


def _chosen(value: Any, info: ValidationInfo) -> Any:
    """Check a table by the section of its type: a table of points where one is given, a parabola by default."""
    if not isinstance(value, dict):
        return value
    kinds = sections()
    name = value.get("type", "tabulated" if any(key in value for key in _TABLE) else "parabola")
    if name not in list(kinds):
        refuse(f"must be one of {', '.join(map(toml_value, kinds))}", "type", value["type"])
    for key in () if "type" in value else value:
        forms = [toml_value(other) for other, form in kinds.items() if key in form.model_fields]
        if key not in kinds[name].model_fields and forms:
            refuse(f"belongs to another type; give type = {' or '.join(forms)}", key)
    return kinds[name].model_validate(value, context=info.context)


AnyProfile = Annotated[SerializeAsAny[ProfileSection], BeforeValidator(_chosen), Forms(lambda: sections().values())]
