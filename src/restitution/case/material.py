"""The material of a case file: a model, Prony series, a name of the library, or a file.

The section of each model follows from its constructor, so that a new model is one function in
`restitution.material.models`.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace
from functools import cache, cached_property
from typing import Annotated, Any, ClassVar, Literal

from pydantic import (
    BeforeValidator,
    Discriminator,
    InstanceOf,
    SerializeAsAny,
    Tag,
    ValidationInfo,
    create_model,
    field_validator,
    model_validator,
)

from restitution.case.quantity import fields_of, of, positive
from restitution.case.relaxation import (
    AnyShift,
    Bulk,
    EndModulus,
    Modulus,
    PoissonRatio,
    PronySection,
    ShiftSection,
    Temperature,
    number_or_table,
    read_file,
)
from restitution.case.section import Section, quoted, refuse
from restitution.errors import InputError
from restitution.material import library
from restitution.material.conversion import bulk_from_poisson_ratio, shear_and_bulk
from restitution.material.deck import PronyTerms, ViscoelasticDeck
from restitution.material.fit import DynamicTable, PronyFit, RelaxationTable, fit_prony
from restitution.material.fractional import Window
from restitution.material.models import MaterialModel, material_models
from restitution.material.prony import PronySeries
from restitution.material.shift import ShiftTable
from restitution.material.viscoelastic import Material
from restitution.quantities import NUMBER, known


class MaterialSection(Section):
    """What all forms of a material share."""

    name: str | None = None
    density: Annotated[float, of("density")] | None = None
    shift: AnyShift | None = None
    temperature: Temperature | None = None

    @classmethod
    def alternatives(cls) -> set[str]:
        """Keys of all forms of a material."""
        return {key for form in (*_FORMS.values(), *models().values()) for key in form.model_fields}

    @property
    def needs_window(self) -> bool:
        """Whether the material holds for a window of time only."""
        return False

    @abstractmethod
    def isothermal(self, window: Window | None) -> Material:
        """Material in SI at the temperature of its numbers."""

    def build(self, window: Window | None = None) -> Material:
        """Material in SI at `temperature`; a fractional model holds in the window at that temperature."""
        shift, factor = self.shift, 1.0
        if isinstance(shift, ShiftSection):
            shift = shift.build()
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
            refuse("the material has no law of the shift; give shift as well", "temperature")
        return material.at(self.temperature)


class GeneralSection(MaterialSection):
    """Any relaxation in shear (a number: elastic) and in bulk (a number: constant)."""

    shear: Annotated[
        Annotated[PronySection, Tag("<table>")] | Annotated[Modulus, Tag("<number>")],
        Discriminator(number_or_table),
    ]
    bulk: (
        Annotated[
            Annotated[PronySection, Tag("<table>")] | Annotated[Bulk, Tag("<number>")],
            Discriminator(number_or_table),
        ]
        | None
    ) = None
    bulk_modulus: Bulk | None = None
    poisson_ratio: PoissonRatio | None = None

    @model_validator(mode="after")
    def _check(self) -> GeneralSection:
        self.one_of("bulk", "bulk_modulus", "poisson_ratio")
        self.build()
        return self

    def isothermal(self, window: Window | None) -> Material:
        """Material in SI."""
        shear = self.shear.build() if isinstance(self.shear, PronySection) else self.shear
        if isinstance(self.bulk, PronySection):
            return Material(shear, self.bulk.build())
        if self.poisson_ratio is not None:
            static = shear.equilibrium_modulus if isinstance(shear, PronySeries) else shear
            return Material(shear, bulk_from_poisson_ratio(static, self.poisson_ratio))
        return Material(shear, self.bulk if self.bulk is not None else self.bulk_modulus or 0.0)


class ModelSection(MaterialSection):
    """A classical or fractional model, from its entry in the registry of models."""

    entry: ClassVar[MaterialModel]
    model: str

    @property
    def needs_window(self) -> bool:
        """Whether a Prony series stands for the model, in a window of time."""
        return self.entry.needs_window

    @model_validator(mode="after")
    def _check(self) -> ModelSection:
        for group in self.entry.one_of:
            self.one_of(*group)
        self._made()
        return self

    def _made(self) -> Any:
        given = self.model_dump(include=set(self.entry.constants), exclude_none=True)
        return self.entry.build(**given)

    def isothermal(self, window: Window | None) -> Material:
        """Material in SI; a fractional one is good within the window."""
        made = self._made()
        if not self.needs_window:
            return made
        assert window is not None
        return made.within(window)


class LibrarySection(MaterialSection):
    """A material of the library by its name."""

    library: str

    @field_validator("library")
    @classmethod
    def _known(cls, value: str) -> str:
        try:
            return known("", value, library.names())
        except InputError as error:
            refuse(error.wanted)

    @model_validator(mode="after")
    def _check(self) -> LibrarySection:
        self.build()
        return self

    def isothermal(self, window: Window | None) -> Material:
        """Material in SI."""
        return library.get(self.library)


class FileSection(MaterialSection):
    """A material in a file: measured data, which are fitted, Prony terms, or the deck of a solver."""

    # Before the file, whose reading needs it.
    material_name: str | None = None
    file: (
        InstanceOf[RelaxationTable] | InstanceOf[DynamicTable] | InstanceOf[PronyTerms] | InstanceOf[ViscoelasticDeck]
    )
    deformation: Literal["tension", "shear"] | None = None
    bulk_modulus: Bulk | None = None
    youngs_modulus: Annotated[float, of("youngs_modulus")] | None = None
    poisson_ratio: PoissonRatio | None = None
    equilibrium_modulus: EndModulus | None = None
    instantaneous_modulus: Modulus | None = None
    misfit: Annotated[float, positive(NUMBER, "relative misfit that a fit may have")] | None = None
    liquid: bool | None = None

    @field_validator("file", mode="before")
    @classmethod
    def _read(cls, value: Any, info: ValidationInfo) -> Any:
        content = read_file(value, info, "dma.csv", info.data.get("material_name"))
        if isinstance(content, ShiftTable):
            refuse("holds shift factors and no moduli; give it as shift")
        return content

    @model_validator(mode="after")
    def _check(self) -> FileSection:
        deck = isinstance(self.file, ViscoelasticDeck)
        fitted = isinstance(self.file, RelaxationTable | DynamicTable)
        if deck:
            self._only("the deck of a solver", "material_name", "youngs_modulus", "poisson_ratio")
        else:
            own = ("misfit", "liquid") if fitted else ("equilibrium_modulus", "instantaneous_modulus")
            shared = ("deformation", "bulk_modulus", "poisson_ratio")
            self._only("measured data" if fitted else "Prony terms", *own, *shared)
            self.one_of("bulk_modulus", "poisson_ratio")
            found = getattr(self.file, "deformation", None)
            if found is None and self.deformation is None:
                refuse('is missing: the file does not say whether it is "tension" or "shear"', "deformation")
            if found is not None and self.deformation not in (None, found):
                refuse(f'contradicts the file, which holds moduli in "{found}"', "deformation")
        try:
            _ = self.fit
        except InputError as error:
            refuse(error.wanted, "file" if error.where else error.field)
        self.build()
        return self

    def _only(self, what: str, *keys: str) -> None:
        others = [key for key in type(self).model_fields if key not in ("file", *MaterialSection.model_fields)]
        for key in self.given(*others):
            if key not in keys:
                refuse(f"has no meaning for {what}; known are {', '.join(keys)}", key)

    @cached_property
    def fit(self) -> PronyFit | None:
        """Fit to measured data."""
        if not isinstance(self.file, RelaxationTable | DynamicTable):
            return None
        options = {key: getattr(self, key) for key in self.given("misfit", "liquid")}
        return fit_prony(self.file, **options)

    def isothermal(self, window: Window | None) -> Material:
        """Material in SI."""
        if isinstance(self.file, ViscoelasticDeck):
            return self.file.material(youngs_modulus=self.youngs_modulus, poisson_ratio=self.poisson_ratio)
        if self.fit is not None:
            bulk_constants = {"bulk_modulus": self.bulk_modulus, "poisson_ratio": self.poisson_ratio}
            return self.fit.material(**bulk_constants, deformation=self.deformation)
        terms = self.file
        assert isinstance(terms, PronyTerms)
        ends = {key: getattr(self, key) for key in ("instantaneous_modulus", "equilibrium_modulus")}
        shear, bulk = shear_and_bulk(
            terms.series(**ends), self.bulk_modulus, self.poisson_ratio, terms.deformation, self.deformation
        )
        return Material(shear, bulk, source=terms.source, window=terms.window)


def models() -> dict[str, type[ModelSection]]:
    """Section of each registered material model by its name."""
    return {name: _model_section(name, entry.build) for name, entry in material_models().items()}


@cache
def _model_section(name: str, _build: Any) -> type[ModelSection]:
    entry = material_models()[name]
    default = name if name == _DEFAULT else ...
    fields: dict[str, Any] = {"model": (Literal[name], default), **fields_of(entry.constants.values())}
    section = create_model(f"{name}_section", __base__=ModelSection, **fields)
    section.entry = entry
    return section


_DEFAULT = "standard_solid"
_FORMS: dict[str, type[MaterialSection]] = {
    "library": LibrarySection, "file": FileSection, "shear": GeneralSection
}  # fmt: skip
_COMMON = {"model", "poisson_ratio", "bulk_modulus", "approximation_rtol", *MaterialSection.model_fields}


def is_fractional(content: Any) -> bool:
    """Whether the table of a material describes a fractional model."""
    name = content.get("model") if isinstance(content, dict) else None
    entry = material_models().get(name) if isinstance(name, str) else None
    return entry is not None and entry.needs_window


def _chosen(value: Any, info: ValidationInfo) -> Any:
    """Check a table by the section of its form; without a form it is a standard solid."""
    if not isinstance(value, dict):
        return value
    known = models()
    if "model" in value and value["model"] not in list(known):
        refuse(f"must be one of {', '.join(map(quoted, known))}", "model", value["model"])
    forms = [key for key in (*_FORMS, "model") if key in value]
    if len(forms) > 1:
        refuse(f"give one of library, file, model and shear; {' and '.join(forms)} are given")
    if not forms:
        _without_model(value, known)
    form = _FORMS[forms[0]] if set(forms) & _FORMS.keys() else known[value.get("model", _DEFAULT)]
    return form.model_validate(value, context=info.context)


def _without_model(value: dict[str, Any], known: dict[str, type[ModelSection]]) -> None:
    """Point from constants of other models than the standard solid, which needs no name, to those models."""
    own = {name: set(section.model_fields) - _COMMON for name, section in known.items()}
    constants = set[str]().union(*own.values()) & set(value)
    for key in value:
        if key in constants and key not in own[_DEFAULT]:
            having = [name for name, keys in own.items() if key in keys]
            names = " or ".join(map(quoted, [name for name in having if constants <= own[name]] or having))
            refuse(f"is a constant of another model than the standard solid; give model = {names}", key)


AnyMaterial = Annotated[SerializeAsAny[MaterialSection], BeforeValidator(_chosen)]
