"""The law of the time-temperature shift in a case file: constants of a law, or a file of shift factors."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator, InstanceOf, SerializeAsAny, ValidationInfo, model_validator

from restitution.case.quantity import LIST, of
from restitution.case.section import FROM_FILE, Section, folder_of, refuse
from restitution.errors import InputError
from restitution.material.readers import MaterialFile, read_material
from restitution.material.shift import WLF, Arrhenius, Shift, ShiftTable

Temperature = Annotated[float, of("temperature")]


def read_file(value: Any, info: ValidationInfo, example: str, name: str | None = None) -> MaterialFile:
    """Read a file of a material beside the case file."""
    if not isinstance(value, str):
        refuse(f'must be the name of a file, e.g. "{example}"')
    try:
        return read_material(Path(folder_of(info), value), name=name)
    except InputError as error:
        refuse(error.rule)


class ShiftSection(Section):
    """A law of the time-temperature shift."""

    law: ClassVar[type[WLF] | type[Arrhenius]]
    reference_temperature: Temperature
    temperature_range: Annotated[list[Temperature], LIST] | None = None

    @model_validator(mode="after")
    def _check(self) -> ShiftSection:
        if self.temperature_range is not None and len(self.temperature_range) != 2:
            refuse("must be two temperatures, the lowest and the highest", "temperature_range")
        self.build()
        return self

    def build(self) -> Shift:
        """Return the law in SI."""
        constants: dict[str, Any] = self.model_dump(exclude_none=True)
        if self.temperature_range is not None:
            constants["temperature_range"] = tuple(self.temperature_range)
        return self.law(**constants)


class WLFSection(ShiftSection):
    """Law of Williams, Landel and Ferry."""

    law = WLF
    c1: Annotated[float, of("c1")]
    c2: Annotated[float, of("c2")]


class ArrheniusSection(ShiftSection):
    """Law of Arrhenius."""

    law = Arrhenius
    activation_energy: Annotated[float, of("activation_energy")]


def _shift(value: Any, info: ValidationInfo) -> Any:
    """Check a table by the section of its law, or read a table of shift factors."""
    if isinstance(value, dict):
        law = ArrheniusSection if "activation_energy" in value else WLFSection
        return law.model_validate(value, context=info.context)
    table = read_file(value, info, "shift.csv")
    if not isinstance(table, ShiftTable):
        refuse("must hold temperatures and shift factors")
    return table


AnyShift = Annotated[
    SerializeAsAny[ShiftSection] | Annotated[InstanceOf[ShiftTable], FROM_FILE], BeforeValidator(_shift)
]
