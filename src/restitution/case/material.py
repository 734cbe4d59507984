"""The material of a case file: its shear and bulk relaxation, in the forms in which people have them."""

from __future__ import annotations

import math
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
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
    DENSITY,
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
from restitution.case.section import Section
from restitution.case.terms import Terms, read_terms
from restitution.material.classical import standard_solid
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, bulk_from_poisson_ratio

# How far printed relative moduli may be from their sum: four decimals, some thirty terms.
_SUM_TOLERANCE = 2e-3


def _incompressible(value: Any) -> Any:
    return math.inf if value == "incompressible" else value


Bulk = Annotated[float, within(MODULUS, 0.0, math.inf), BeforeValidator(_incompressible)]
Moduli = Annotated[list[Annotated[float, nonnegative(MODULUS)]], LIST]
Numbers = Annotated[list[Annotated[float, nonnegative(NUMBER)]], LIST]
Times = Annotated[list[Annotated[float, positive(TIME)]], LIST]


class PronySection(Section):
    """A relaxation function: one or two end moduli and the terms between them, inline or from a file.

    Relative moduli are shares of the instantaneous modulus; where both end moduli are given, they may also be
    shares of the difference of the two.
    """

    equilibrium_modulus: Annotated[float, nonnegative(MODULUS)] | None = None
    instantaneous_modulus: Annotated[float, positive(MODULUS)] | None = None
    branch_moduli: Moduli | None = None
    relative_moduli: Numbers | None = None
    relaxation_times: Times | None = None
    viscosity: Annotated[float, nonnegative(VISCOSITY)] = 0.0
    terms: InstanceOf[Terms] | None = None

    @field_validator("terms", mode="before")
    @classmethod
    def _read(cls, value: Any, info: ValidationInfo) -> Terms:
        if not isinstance(value, str):
            refuse('must be the name of a CSV file, e.g. "prony.csv"')
        try:
            return read_terms((info.context or {}).get("folder", "."), value)
        except ValueError as error:
            refuse(str(error))

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
        self._end_moduli()
        return self

    def _terms(self) -> tuple[NDArray[np.float64], NDArray[np.float64], bool]:
        if self.terms is not None:
            return self.terms
        relative = self.relative_moduli is not None
        moduli = self.relative_moduli if relative else self.branch_moduli
        return np.array(self.relaxation_times), np.array(moduli, dtype=np.float64), relative

    def _end_moduli(self) -> tuple[float, NDArray[np.float64]]:
        """Equilibrium modulus and branch moduli [Pa]."""
        _, moduli, relative = self._terms()
        total = math.fsum(moduli)
        low, high = self.equilibrium_modulus, self.instantaneous_modulus
        if not relative:
            self.one_of("equilibrium_modulus", "instantaneous_modulus")
            if low is None and high is not None:
                low = high - total
                if low < -1e-9 * high:
                    refuse(
                        f"must be at least the sum of the branch moduli, {total:g} Pa",
                        "instantaneous_modulus",
                    )
                low = max(low, 0.0)
            return float(low or 0.0), moduli
        if low is None and high is None:
            refuse("give instantaneous_modulus, equilibrium_modulus or both; none is given")
        if low is not None and high is not None:
            if low > high:
                refuse(f"must be at most the instantaneous_modulus, {high:g} Pa", "equilibrium_modulus")
            if min(abs(total - 1.0), abs(total - 1.0 + low / high)) > _SUM_TOLERANCE:
                refuse(
                    f"the relative moduli add up to {total:.6g}; with both end moduli given must add up to 1 "
                    f"(shares of the difference) or {1.0 - low / high:.6g} (shares of instantaneous_modulus)"
                )
            return low, moduli * ((high - low) / total)
        if high is not None:
            if total > 1.0 + _SUM_TOLERANCE:
                refuse(f"the relative moduli add up to {total:.6g}; must be at most 1")
            return high * max(1.0 - total, 0.0), moduli * high
        if total >= 1.0:
            refuse(f"the relative moduli add up to {total:.6g}; must be below 1")
        return float(low or 0.0), moduli * (float(low or 0.0) / (1.0 - total))

    def build(self) -> PronySeries:
        """Relaxation function in SI."""
        low, moduli = self._end_moduli()
        return PronySeries(low, moduli, self._terms()[0], viscosity=self.viscosity)


def _number_or_table(value: Any) -> str:
    return "<table>" if isinstance(value, dict | PronySection) else "<number>"


ShearRelaxation = Annotated[
    Annotated[PronySection, Tag("<table>")] | Annotated[float, positive(MODULUS), Tag("<number>")],
    Discriminator(_number_or_table),
]
BulkRelaxation = Annotated[
    Annotated[PronySection, Tag("<table>")] | Annotated[Bulk, Tag("<number>")],
    Discriminator(_number_or_table),
]
PoissonRatio = Annotated[float, within(NUMBER, -1.0, 0.5)]


class MaterialSection(Section):
    """What all forms of a material share."""

    name: str | None = None
    density: Annotated[float, positive(DENSITY)] | None = None


class StandardSolidSection(MaterialSection):
    """The three-element solid in shear with an elastic bulk."""

    equilibrium_modulus: Annotated[float, nonnegative(MODULUS)]
    branch_modulus: Annotated[float, positive(MODULUS)]
    viscosity: Annotated[float, positive(VISCOSITY)]
    poisson_ratio: PoissonRatio | None = None
    bulk_modulus: Bulk | None = None

    @model_validator(mode="after")
    def _check(self) -> StandardSolidSection:
        self.one_of("poisson_ratio", "bulk_modulus")
        self.build()
        return self

    def build(self) -> Material:
        """Material in SI."""
        return standard_solid(
            self.equilibrium_modulus,
            self.branch_modulus,
            self.viscosity,
            poisson_ratio=self.poisson_ratio,
            bulk_modulus=self.bulk_modulus,
            density=self.density,
            name=self.name,
        )


class GeneralMaterialSection(MaterialSection):
    """Any relaxation in shear (a number: elastic) and in bulk (a number: constant)."""

    shear: ShearRelaxation
    bulk: BulkRelaxation | None = None
    bulk_modulus: Bulk | None = None
    poisson_ratio: PoissonRatio | None = None

    @model_validator(mode="after")
    def _check(self) -> GeneralMaterialSection:
        self.one_of("bulk", "bulk_modulus", "poisson_ratio")
        self.build()
        return self

    def build(self) -> Material:
        """Material in SI."""
        shear = self.shear.build() if isinstance(self.shear, PronySection) else self.shear
        return Material(shear, self._bulk(shear), density=self.density, name=self.name)

    def _bulk(self, shear: PronySeries | float) -> PronySeries | float:
        if isinstance(self.bulk, PronySection):
            return self.bulk.build()
        if self.poisson_ratio is not None:
            static = shear.equilibrium_modulus if isinstance(shear, PronySeries) else shear
            return bulk_from_poisson_ratio(static, self.poisson_ratio)
        return self.bulk if self.bulk is not None else self.bulk_modulus or 0.0


def _form(value: Any) -> str:
    general = isinstance(value, GeneralMaterialSection) or (isinstance(value, dict) and "shear" in value)
    return "<general>" if general else "<standard solid>"


AnyMaterial = Annotated[
    Annotated[StandardSolidSection, Tag("<standard solid>")]
    | Annotated[GeneralMaterialSection, Tag("<general>")],
    Discriminator(_form),
]
