"""Relaxation functions of a case file: numbers, or Prony series inline or from a file."""

from __future__ import annotations

import math
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

from restitution.case.quantity import (
    LIST,
    MODULUS,
    NUMBER,
    TIME,
    VISCOSITY,
    nonnegative,
    positive,
    refuse,
    within,
)
from restitution.case.section import Section, folder_of
from restitution.material.measurement import PronyTerms
from restitution.material.prony import PronySeries
from restitution.material.readers import MaterialFile, read_material


def _incompressible(value: Any) -> Any:
    return math.inf if value == "incompressible" else value


Modulus = Annotated[float, positive(MODULUS)]
EndModulus = Annotated[float, nonnegative(MODULUS)]
Viscosity = Annotated[float, positive(VISCOSITY)]
Time = Annotated[float, positive(TIME)]
PoissonRatio = Annotated[float, within(NUMBER, -1.0, 0.5)]
Bulk = Annotated[float, within(MODULUS, 0.0, math.inf), BeforeValidator(_incompressible)]
Moduli = Annotated[list[Annotated[float, nonnegative(MODULUS)]], LIST]
Numbers = Annotated[list[Annotated[float, nonnegative(NUMBER)]], LIST]
Times = Annotated[list[Time], LIST]


def read_file(value: Any, info: ValidationInfo, example: str, name: str | None = None) -> MaterialFile:
    """Read a file of a material beside the case file."""
    if not isinstance(value, str):
        refuse(f'must be the name of a file, e.g. "{example}"')
    path = Path(folder_of(info), value)
    try:
        return read_material(path, name=name)
    except ValueError as error:
        refuse(str(error).removeprefix(f"{path}: "))


class PronySection(Section):
    """A relaxation function: one or two end moduli and the terms between them, inline or from a file.

    Relative moduli are shares of the instantaneous modulus; where both end moduli are given, they may also be
    shares of the difference of the two.
    """

    elsewhere: ClassVar[dict[str, str]] = dict.fromkeys(
        ("coefficient", "exponent"),
        'fractional models stand in the section of the material, by model = "springpot" or '
        "the name of another one",
    )

    equilibrium_modulus: EndModulus | None = None
    instantaneous_modulus: Modulus | None = None
    branch_moduli: Moduli | None = None
    relative_moduli: Numbers | None = None
    relaxation_times: Times | None = None
    parallel_viscosity: Annotated[float, nonnegative(VISCOSITY)] = 0.0
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


def _number_or_table(value: Any) -> str:
    return "<table>" if isinstance(value, dict | PronySection) else "<number>"


ShearRelaxation = Annotated[
    Annotated[PronySection, Tag("<table>")] | Annotated[Modulus, Tag("<number>")],
    Discriminator(_number_or_table),
]
BulkRelaxation = Annotated[
    Annotated[PronySection, Tag("<table>")] | Annotated[Bulk, Tag("<number>")],
    Discriminator(_number_or_table),
]
