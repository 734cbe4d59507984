"""Classical and fractional models in a case file."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import model_validator

from restitution.case.material_form import MaterialSection
from restitution.case.quantity import NUMBER, VISCOSITY, nonnegative, positive, refuse, within
from restitution.case.relaxation import (
    Bulk,
    EndModulus,
    Moduli,
    Modulus,
    PoissonRatio,
    Time,
    Times,
    Viscosity,
)
from restitution.material import classical, fractional
from restitution.material.fractional import Window
from restitution.material.viscoelastic import Material, bulk_from_poisson_ratio

_COMMON = frozenset({"model", *MaterialSection.model_fields})


def numbers(section: MaterialSection) -> dict[str, Any]:
    """Keys and numbers of a section that are those of its model alone."""
    return section.model_dump(exclude=set(_COMMON))


class ElasticSection(MaterialSection):
    """Elastic: two constants."""

    model: Literal["elastic"]
    shear_modulus: Modulus | None = None
    youngs_modulus: Modulus | None = None
    poisson_ratio: PoissonRatio | None = None
    bulk_modulus: Bulk | None = None

    @model_validator(mode="after")
    def _check(self) -> ElasticSection:
        self.one_of("shear_modulus", "youngs_modulus")
        self.one_of("poisson_ratio", "bulk_modulus")
        self.build()
        return self

    def isothermal(self, window: Window | None) -> Material:
        """Material in SI."""
        return classical.elastic(**numbers(self))


class MaxwellSection(MaterialSection):
    """Maxwell liquid in shear, elastic in bulk."""

    model: Literal["maxwell"]
    shear_modulus: Modulus
    viscosity: Viscosity
    bulk_modulus: Bulk

    def isothermal(self, window: Window | None) -> Material:
        """Material in SI."""
        return classical.maxwell(**numbers(self))


class KelvinVoigtSection(MaterialSection):
    """Kelvin-Voigt solid in shear, elastic or Kelvin-Voigt in bulk."""

    model: Literal["kelvin_voigt"]
    shear_modulus: EndModulus
    viscosity: Viscosity
    poisson_ratio: PoissonRatio | None = None
    bulk_modulus: Bulk | None = None
    bulk_viscosity: Annotated[float, nonnegative(VISCOSITY)] = 0.0

    @model_validator(mode="after")
    def _check(self) -> KelvinVoigtSection:
        self.one_of("poisson_ratio", "bulk_modulus")
        self.build()
        return self

    def isothermal(self, window: Window | None) -> Material:
        """Material in SI."""
        return classical.kelvin_voigt(**numbers(self))


class StandardSolidSection(MaterialSection):
    """The three-element solid in shear with an elastic bulk."""

    model: Literal["standard_solid"] = "standard_solid"
    equilibrium_modulus: EndModulus
    branch_modulus: Modulus
    viscosity: Viscosity
    poisson_ratio: PoissonRatio | None = None
    bulk_modulus: Bulk | None = None

    @model_validator(mode="after")
    def _check(self) -> StandardSolidSection:
        self.one_of("poisson_ratio", "bulk_modulus")
        self.build()
        return self

    def isothermal(self, window: Window | None) -> Material:
        """Material in SI."""
        return classical.standard_solid(**numbers(self))


class BurgersSection(MaterialSection):
    """Burgers liquid in shear, elastic in bulk."""

    model: Literal["burgers"]
    maxwell_modulus: Modulus
    maxwell_viscosity: Viscosity
    kelvin_modulus: Modulus
    kelvin_viscosity: Viscosity
    bulk_modulus: Bulk

    def isothermal(self, window: Window | None) -> Material:
        """Material in SI."""
        return classical.burgers(**numbers(self))


class GeneralisedMaxwellSection(MaterialSection):
    """Any number of Maxwell branches beside a spring in shear, elastic in bulk."""

    model: Literal["generalised_maxwell"]
    equilibrium_modulus: EndModulus
    branch_moduli: Moduli
    relaxation_times: Times
    poisson_ratio: PoissonRatio | None = None
    bulk_modulus: Bulk | None = None

    @model_validator(mode="after")
    def _check(self) -> GeneralisedMaxwellSection:
        self.one_of("poisson_ratio", "bulk_modulus")
        n_moduli, n_times = len(self.branch_moduli), len(self.relaxation_times)
        if n_moduli != n_times:
            refuse(f"{n_moduli} branch_moduli for {n_times} relaxation_times; give as many of each")
        self.build()
        return self

    def isothermal(self, window: Window | None) -> Material:
        """Material in SI."""
        return classical.generalised_maxwell(**numbers(self))


class FractionalSection(MaterialSection):
    """A fractional model in shear, elastic in bulk; a Prony series stands for it in a window of time."""

    keys: ClassVar[dict[str, tuple[str, ...]]] = {
        "springpot": ("coefficient", "exponent"),
        "fractional_kelvin_voigt": ("equilibrium_modulus", "coefficient", "exponent"),
        "fractional_maxwell": ("branch_modulus", "relaxation_time", "exponent"),
        "fractional_zener": ("equilibrium_modulus", "branch_modulus", "relaxation_time", "exponent"),
    }

    model: Literal["springpot", "fractional_kelvin_voigt", "fractional_maxwell", "fractional_zener"]
    equilibrium_modulus: EndModulus | None = None
    branch_modulus: Modulus | None = None
    coefficient: Annotated[float, positive(NUMBER)] | None = None
    relaxation_time: Time | None = None
    exponent: Annotated[float, within(NUMBER, 0.01, 0.99)]
    poisson_ratio: PoissonRatio | None = None
    bulk_modulus: Bulk | None = None
    approximation_rtol: Annotated[float, within(NUMBER, 1e-10, 0.1)] = 1e-6

    @model_validator(mode="after")
    def _check(self) -> FractionalSection:
        wanted = self.keys[self.model]
        for key in wanted:
            if getattr(self, key) is None:
                refuse("is missing", key)
        for key in self.given("equilibrium_modulus", "branch_modulus", "coefficient", "relaxation_time"):
            if key not in wanted:
                refuse(f'is no constant of model = "{self.model}"; its are {", ".join(wanted)}', key)
        self.one_of("poisson_ratio", "bulk_modulus")
        self._bulk()
        return self

    @property
    def needs_window(self) -> bool:
        """Whether the material can only be had for a window of time: yes."""
        return True

    def _bulk(self) -> float:
        if self.poisson_ratio is not None:
            return bulk_from_poisson_ratio(self.equilibrium_modulus or 0.0, self.poisson_ratio)
        assert self.bulk_modulus is not None
        return self.bulk_modulus

    def isothermal(self, window: Window | None) -> Material:
        """Material in SI, good within the window."""
        assert window is not None
        constants = [getattr(self, key) for key in self.keys[self.model]]
        if self.model == "fractional_maxwell":
            model = fractional.fractional_maxwell(*constants)
        else:
            model = getattr(fractional, self.model)(*constants)
        return fractional.FractionalMaterial(model, self._bulk(), rtol=self.approximation_rtol).within(window)
