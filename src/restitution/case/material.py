"""The material of a case file, in the forms in which people have them."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, Discriminator, Tag, model_validator

from restitution.case.classical import (
    BurgersSection,
    ElasticSection,
    FractionalSection,
    GeneralisedMaxwellSection,
    KelvinVoigtSection,
    MaxwellSection,
    StandardSolidSection,
)
from restitution.case.material_file import FileSection, LibrarySection
from restitution.case.material_form import MaterialSection
from restitution.case.quantity import refuse
from restitution.case.relaxation import Bulk, BulkRelaxation, PoissonRatio, PronySection, ShearRelaxation
from restitution.material.fractional import Window
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, bulk_from_poisson_ratio


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

    def isothermal(self, window: Window | None) -> Material:
        """Material in SI."""
        shear = self.shear.build() if isinstance(self.shear, PronySection) else self.shear
        return Material(shear, self._bulk(shear))

    def _bulk(self, shear: PronySeries | float) -> PronySeries | float:
        if isinstance(self.bulk, PronySection):
            return self.bulk.build()
        if self.poisson_ratio is not None:
            static = shear.equilibrium_modulus if isinstance(shear, PronySeries) else shear
            return bulk_from_poisson_ratio(static, self.poisson_ratio)
        return self.bulk if self.bulk is not None else self.bulk_modulus or 0.0


_COMMON = frozenset({"model", "poisson_ratio", "bulk_modulus", *MaterialSection.model_fields})
_MODELS: dict[str, tuple[str, ...]] = {
    name: tuple(key for key in section.model_fields if key not in _COMMON)
    for name, section in {
        "elastic": ElasticSection,
        "maxwell": MaxwellSection,
        "kelvin_voigt": KelvinVoigtSection,
        "standard_solid": StandardSolidSection,
        "burgers": BurgersSection,
        "generalised_maxwell": GeneralisedMaxwellSection,
    }.items()
} | FractionalSection.keys


def _known_model(value: Any) -> Any:
    if isinstance(value, dict):
        if value.get("model", "elastic") not in _MODELS:
            names = ", ".join(f'"{name}"' for name in _MODELS)
            refuse(f"must be one of {names}", "model")
        forms = [key for key in ("library", "file", "model", "shear") if key in value]
        if len(forms) > 1:
            refuse(f"give one of library, file, model and shear; {' and '.join(forms)} are given")
        if not forms:
            _without_model(value)
    return value


def _without_model(value: dict[str, Any]) -> None:
    """Point from constants of other models than the standard solid, which needs no name, to those models."""
    constants = {key for keys in _MODELS.values() for key in keys} & set(value)
    for key in value:
        if key in constants and key not in _MODELS["standard_solid"]:
            having = [name for name, keys in _MODELS.items() if key in keys]
            models = [name for name in having if constants <= set(_MODELS[name])] or having
            names = " or ".join(f'"{name}"' for name in models)
            refuse(f"is a constant of another model than the standard solid; give model = {names}", key)


def _form(value: Any) -> str:
    keys = value if isinstance(value, dict) else type(value).model_fields
    for key in ("library", "file", "shear"):
        if key in keys:
            return f"<{key}>"
    model = value.get("model", "standard_solid") if isinstance(value, dict) else value.model
    return "<fractional>" if model in FractionalSection.keys else f"<{model}>"


AnyMaterial = Annotated[
    Annotated[StandardSolidSection, Tag("<standard_solid>")]
    | Annotated[GeneralMaterialSection, Tag("<shear>")]
    | Annotated[LibrarySection, Tag("<library>")]
    | Annotated[FileSection, Tag("<file>")]
    | Annotated[ElasticSection, Tag("<elastic>")]
    | Annotated[MaxwellSection, Tag("<maxwell>")]
    | Annotated[KelvinVoigtSection, Tag("<kelvin_voigt>")]
    | Annotated[BurgersSection, Tag("<burgers>")]
    | Annotated[GeneralisedMaxwellSection, Tag("<generalised_maxwell>")]
    | Annotated[FractionalSection, Tag("<fractional>")],
    Discriminator(_form),
    BeforeValidator(_known_model),
]
