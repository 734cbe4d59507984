"""Relaxation functions and laws of the time-temperature shift in a case file."""

from __future__ import annotations

from abc import abstractmethod
from pathlib import Path
from typing import Annotated, Any, ClassVar

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

from restitution.case.quantity import LIST, nonnegative, of, positive
from restitution.case.section import Section, folder_of, refuse
from restitution.errors import InputError
from restitution.material.deck import PronyTerms
from restitution.material.prony import PronySeries
from restitution.material.readers import MaterialFile, read_material
from restitution.material.shift import WLF, Arrhenius, Shift, ShiftTable
from restitution.quantities import MOLAR_ENERGY, NUMBER, TEMPERATURE_DIFFERENCE

Temperature = Annotated[float, of("temperature")]
Modulus = Annotated[float, of("instantaneous_modulus")]
EndModulus = Annotated[float, of("equilibrium_modulus")]
PoissonRatio = Annotated[float, of("poisson_ratio")]
Bulk = Annotated[float, of("bulk_modulus")]


def read_file(value: Any, info: ValidationInfo, example: str, name: str | None = None) -> MaterialFile:
    """Read a file of a material beside the case file."""
    if not isinstance(value, str):
        refuse(f'must be the name of a file, e.g. "{example}"')
    try:
        return read_material(Path(folder_of(info), value), name=name)
    except InputError as error:
        refuse(error.wanted)


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

    @abstractmethod
    def build(self) -> Shift:
        """Law in SI."""

    @property
    def _range(self) -> tuple[float, float] | None:
        ends = self.temperature_range
        return None if ends is None else (ends[0], ends[1])


class WLFSection(ShiftSection):
    """Law of Williams, Landel and Ferry."""

    c1: Annotated[float, positive(NUMBER, "constant C1")]
    c2: Annotated[float, positive(TEMPERATURE_DIFFERENCE, "constant C2")]

    def build(self) -> Shift:
        """Law in SI."""
        return WLF(self.reference_temperature, self.c1, self.c2, temperature_range=self._range)


class ArrheniusSection(ShiftSection):
    """Law of Arrhenius."""

    activation_energy: Annotated[float, positive(MOLAR_ENERGY, "activation energy")]

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


class PronySection(Section):
    """A relaxation function: one or two end moduli and the terms between them, inline or from a file.

    Relative moduli are shares of the instantaneous modulus; where both end moduli are given, they may also be
    shares of the difference of the two.
    """

    elsewhere: ClassVar[dict[str, str]] = dict.fromkeys(
        ("coefficient", "exponent"),
        'fractional models stand in the section of the material, by model = "springpot" or the name of another one',
    )

    equilibrium_modulus: EndModulus | None = None
    instantaneous_modulus: Modulus | None = None
    branch_moduli: Annotated[list[Annotated[float, of("branch_moduli")]], LIST] | None = None
    relative_moduli: Annotated[list[Annotated[float, nonnegative(NUMBER, "shares of a modulus")]], LIST] | None = None
    relaxation_times: Annotated[list[Annotated[float, of("relaxation_times")]], LIST] | None = None
    parallel_viscosity: Annotated[float, of("parallel_viscosity")] = 0.0
    terms: InstanceOf[PronyTerms] | None = None

    @field_validator("terms", mode="before")
    @classmethod
    def _read(cls, value: Any, info: ValidationInfo) -> PronyTerms:
        terms = read_file(value, info, "prony.csv")
        if not isinstance(terms, PronyTerms):
            refuse("must hold Prony terms; give measured data and solver decks as material.file")
        if terms.deformation == "tension":
            refuse("holds moduli in tension; give it as material.file, which takes them to shear")
        return terms

    @model_validator(mode="after")
    def _check(self) -> PronySection:
        if self.terms is not None:
            for key in self.given("branch_moduli", "relative_moduli", "relaxation_times"):
                refuse("stands in the file of terms already; leave one of the two out", key)
        else:
            key = self.one_of("branch_moduli", "relative_moduli", "terms")
            if self.relaxation_times is None:
                refuse("is missing", "relaxation_times")
            n_moduli, n_times = len(getattr(self, key)), len(self.relaxation_times)
            if n_moduli != n_times:
                refuse(f"{n_moduli} {key} for {n_times} relaxation_times; give as many of each")
        terms = self._terms()
        if not terms.relative and terms.instantaneous_modulus is None and terms.equilibrium_modulus is None:
            self.one_of("equilibrium_modulus", "instantaneous_modulus")
        self.build()
        return self

    def _terms(self) -> PronyTerms:
        if self.terms is not None:
            return self.terms
        relative = self.relative_moduli is not None
        moduli = self.relative_moduli if relative else self.branch_moduli
        return PronyTerms(np.array(self.relaxation_times), np.array(moduli, dtype=np.float64), relative)

    def build(self) -> PronySeries:
        """Relaxation function in SI."""
        series = self._terms().series(
            instantaneous_modulus=self.instantaneous_modulus, equilibrium_modulus=self.equilibrium_modulus
        )
        return PronySeries(
            series.equilibrium_modulus,
            series.branch_moduli,
            series.relaxation_times,
            parallel_viscosity=self.parallel_viscosity,
        )


def number_or_table(value: Any) -> str:
    """Tag of a relaxation: a table, or one number."""
    return "<table>" if isinstance(value, dict | PronySection) else "<number>"
