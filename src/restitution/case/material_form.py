"""What all forms of a material in a case file share: its name, its density, its temperature."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace
from typing import Annotated, Any

from pydantic import BeforeValidator, Discriminator, InstanceOf, Tag, ValidationInfo, model_validator

from restitution.case.quantity import (
    DENSITY,
    LIST,
    MOLAR_ENERGY,
    NUMBER,
    TEMPERATURE,
    TEMPERATURE_DIFFERENCE,
    positive,
    refuse,
)
from restitution.case.relaxation import read_file
from restitution.case.section import Section
from restitution.material.fractional import Window
from restitution.material.shift import WLF, Arrhenius, Shift, ShiftTable
from restitution.material.viscoelastic import Material

Temperature = Annotated[float, positive(TEMPERATURE)]


class ShiftSection(Section):
    """What the laws of the time-temperature shift share."""

    reference_temperature: Temperature
    temperature_range: Annotated[list[Temperature], LIST] | None = None

    @model_validator(mode="after")
    def _check(self) -> ShiftSection:
        if self.temperature_range is not None and len(self.temperature_range) != 2:
            refuse("must be two temperatures, the lowest and the highest", "temperature_range")
        self.build()
        return self

    @property
    def _range(self) -> tuple[float, float] | None:
        return (
            None if self.temperature_range is None else (self.temperature_range[0], self.temperature_range[1])
        )

    @abstractmethod
    def build(self) -> Shift:
        """Law in SI."""


class WLFSection(ShiftSection):
    """Law of Williams, Landel and Ferry."""

    c1: Annotated[float, positive(NUMBER)]
    c2: Annotated[float, positive(TEMPERATURE_DIFFERENCE)]

    def build(self) -> Shift:
        """Law in SI."""
        return WLF(self.reference_temperature, self.c1, self.c2, temperature_range=self._range)


class ArrheniusSection(ShiftSection):
    """Law of Arrhenius."""

    activation_energy: Annotated[float, positive(MOLAR_ENERGY)]

    def build(self) -> Shift:
        """Law in SI."""
        return Arrhenius(self.reference_temperature, self.activation_energy, temperature_range=self._range)


def _table_file(value: Any, info: ValidationInfo) -> Any:
    if isinstance(value, dict | Section | ShiftTable):
        return value
    table = read_file(value, info, "shift.csv")
    if not isinstance(table, ShiftTable):
        refuse("must hold temperatures and shift factors")
    return table


def _law(value: Any) -> str:
    if isinstance(value, ShiftTable):
        return "<file>"
    keys = value if isinstance(value, dict) else type(value).model_fields
    return "<Arrhenius>" if "activation_energy" in keys else "<WLF>"


AnyShift = Annotated[
    Annotated[WLFSection, Tag("<WLF>")]
    | Annotated[ArrheniusSection, Tag("<Arrhenius>")]
    | Annotated[InstanceOf[ShiftTable], Tag("<file>")],
    Discriminator(_law),
    BeforeValidator(_table_file),
]


class MaterialSection(Section):
    """What all forms of a material share."""

    name: str | None = None
    density: Annotated[float, positive(DENSITY)] | None = None
    shift: AnyShift | None = None
    temperature: Temperature | None = None

    @property
    def needs_window(self) -> bool:
        """Whether the material can only be had for a window of time."""
        return False

    @abstractmethod
    def isothermal(self, window: Window | None) -> Material:
        """Material in SI at the temperature of its numbers."""

    def build(self, window: Window | None = None) -> Material:
        """Material in SI at the temperature wanted.

        Parameters
        ----------
        window
            Where a fractional model has to hold, at that temperature.
        """
        law, factor = self.shift, 1.0
        shift = law.build() if isinstance(law, WLFSection | ArrheniusSection) else law
        if shift is not None and self.temperature is not None:
            factor = shift.factor(self.temperature)
        if window is not None:
            window = Window(window.low / factor, window.high / factor, window.rtol)
        material = self.isothermal(window)
        given = {"name": self.name, "density": self.density, "shift": shift}
        if shift is not None:
            given["temperature"] = shift.reference_temperature
        material = replace(material, **{key: value for key, value in given.items() if value is not None})
        if self.temperature is None or self.temperature == material.temperature:
            return material
        if material.shift is None:
            raise ValueError("temperature: the material has no law of the shift; give shift as well")
        return material.at(self.temperature)
