"""The material of a case file: a model, Prony series, a name of the library, or a file.

The section of each model follows from its constructor, so that a new model is one function in
`restitution.material.models`.
"""

from __future__ import annotations

import warnings
from abc import abstractmethod
from dataclasses import replace
from functools import cache, cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
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

from restitution.case.quantity import LIST, fields_of, nonnegative, of, positive
from restitution.case.section import FROM_FILE, IN_FILE, CaseError, Forms, Section, folder_of, refuse, toml_value
from restitution.errors import InputError, RestitutionWarning
from restitution.material import library
from restitution.material.cards import PronyTerms, ViscoelasticDeck
from restitution.material.conversion import bulk_from_poisson_ratio, shear_and_bulk
from restitution.material.fit import CreepTable, DynamicTable, Measured, PronyFit, RelaxationTable, fit_prony
from restitution.material.fractional import Window
from restitution.material.master_curve import Isotherms, MasterCurve, ShiftLaw
from restitution.material.models import MaterialModel, material_models
from restitution.material.prony import PronySeries
from restitution.material.readers import MaterialFile, read_material
from restitution.material.shift import WLF, Arrhenius, Shift, ShiftTable
from restitution.material.temperature_ramp import MEASURED_CONSTANTS, ReducedRamp, TemperatureRamp
from restitution.material.viscoelastic import Material
from restitution.quantities import NUMBER, TIME, choice
from restitution.units import FREQUENCY

Modulus = Annotated[float, of("instantaneous_modulus")]
EndModulus = Annotated[float, of("equilibrium_modulus")]
PoissonRatio = Annotated[float, of("poisson_ratio")]
Bulk = Annotated[float, of("bulk_modulus")]
Temperature = Annotated[float, of("temperature")]
_Time = Annotated[float, positive(TIME)]
_ENDS = ("equilibrium_modulus", "instantaneous_modulus")
_OF_MODULI = ("deformation", "bulk_modulus", "poisson_ratio")


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


class PronySection(Section):
    """A relaxation function: one or two end moduli and the terms between them, inline or from a file."""

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
    terms: Annotated[InstanceOf[PronyTerms], FROM_FILE] | None = None

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
            self.refuse_present(IN_FILE, "branch_moduli", "relative_moduli", "relaxation_times")
        else:
            key = self.one_of("branch_moduli", "relative_moduli", "terms")
            if self.relaxation_times is None:
                refuse("is missing", "relaxation_times")
            n_moduli, n_times = len(getattr(self, key)), len(self.relaxation_times)
            if n_moduli != n_times:
                refuse(f"{n_moduli} {key} for {n_times} relaxation_times; give as many of each")
        self.build()
        return self

    def build(self) -> PronySeries:
        """Return the relaxation function in SI."""
        terms, relative = self.terms, self.relative_moduli is not None
        if terms is None:
            moduli = self.relative_moduli if relative else self.branch_moduli
            terms = PronyTerms(np.array(self.relaxation_times), np.array(moduli, dtype=np.float64), relative)
        if not terms.relative and terms.instantaneous_modulus is None and terms.equilibrium_modulus is None:
            self.one_of("equilibrium_modulus", "instantaneous_modulus")
        return replace(terms.series(**self.values(_ENDS)), parallel_viscosity=self.parallel_viscosity)


_Series = Annotated[PronySection, Tag("<table>")]
_NUMBER_OR_TABLE = Discriminator(lambda value: "<table>" if isinstance(value, dict | PronySection) else "<number>")


class MaterialSection(Section):
    """What all forms of a material share."""

    name: str | None = None
    density: Annotated[float, of("density")] | None = None
    shift: AnyShift | None = None
    temperature: Temperature | None = None
    window: Annotated[tuple[_Time, _Time], LIST] | None = None
    undetermined: tuple[str, ...] | None = None

    @classmethod
    def alternatives(cls) -> set[str]:
        """Return the keys of all forms of a material."""
        return {key for form in (*_FORMS.values(), *models().values()) for key in form.model_fields}

    @property
    def needs_window(self) -> bool:
        """Whether the material holds for a window of time only."""
        return False

    @model_validator(mode="after")
    def _check(self) -> Self:
        self.check_keys()
        if self.needs_window:
            self.isothermal(None)
        else:
            self.build()
        return self

    def check_keys(self) -> None:
        """Refuse keys that exclude each other."""

    @abstractmethod
    def isothermal(self, window: Window | None) -> Material:
        """Return the material in SI at the temperature of its numbers; a fractional one holds in the window."""

    def build(self, window: Window | None = None) -> Material:
        """Return the material in SI at `temperature`; a fractional model holds in the window at that temperature."""
        return self._material(window) if self.needs_window else self._windowless

    @cached_property
    def _windowless(self) -> Material:
        return self._material(None)

    def _material(self, window: Window | None) -> Material:
        shift = self.shift.build() if isinstance(self.shift, ShiftSection) else self.shift
        if window is not None and shift is not None and self.temperature is not None:
            factor = shift.factor(self.temperature)
            window = Window(window.low / factor, window.high / factor, window.rtol)
        material = self.isothermal(window)
        self._check_window(material.window)
        shared = {"name": self.name, "density": self.density, "shift": shift, "window": self.window,
                 "undetermined": self.undetermined}  # fmt: skip
        if shift is not None:
            shared["temperature"] = shift.reference_temperature
        # Names and densities that a model takes are there already.
        further = {
            key: value for key, value in shared.items() if value is not None and value is not getattr(material, key)
        }
        material = replace(material, **further) if further else material
        if self.temperature is None or (not np.ndim(self.temperature) and self.temperature == material.temperature):
            return material
        if material.shift is None:
            refuse("the material has no law of the shift; give shift as well", "temperature")
        return material.at(self.temperature)

    def _check_window(self, data: tuple[float, float] | None) -> None:
        """Refuse a window that is wider than that of the data of the material."""
        if self.window is None or data is None or self.needs_window:
            return
        # Digits of a file may be fewer than those of the data.
        if self.window[0] < data[0] * (1.0 - 1e-3) or self.window[1] > data[1] * (1.0 + 1e-3):
            rule = f"must lie within the times of the data, {data[0]:.4g} to {data[1]:.4g} s"
            refuse(f"{rule}; the option --extrapolate goes beyond", "window", list(self.window))


class GeneralSection(MaterialSection):
    """Any relaxation in shear (a number: elastic) and in bulk (a number: constant)."""

    shear: Annotated[_Series | Annotated[Modulus, Tag("<number>")], _NUMBER_OR_TABLE]
    bulk: Annotated[_Series | Annotated[Bulk, Tag("<number>")], _NUMBER_OR_TABLE] | None = None
    bulk_modulus: Bulk | None = None
    poisson_ratio: PoissonRatio | None = None

    def check_keys(self) -> None:
        self.one_of("bulk", "bulk_modulus", "poisson_ratio")

    def isothermal(self, window: Window | None) -> Material:
        shear = self.shear.build() if isinstance(self.shear, PronySection) else self.shear
        if isinstance(self.bulk, PronySection):
            return Material(shear, self.bulk.build())
        if self.poisson_ratio is not None:
            static = shear.equilibrium_modulus if isinstance(shear, PronySeries) else shear
            return Material(shear, bulk_from_poisson_ratio(static, self.poisson_ratio))
        modulus = self.bulk_modulus if self.bulk is None else self.bulk
        assert modulus is not None
        return Material(shear, modulus)


class ModelSection(MaterialSection):
    """A classical or fractional model, from its entry in the registry of models."""

    entry: ClassVar[MaterialModel]
    model: str

    @property
    def needs_window(self) -> bool:
        return self.entry.needs_window

    def check_keys(self) -> None:
        for group in self.entry.one_of:
            self.one_of(*group)

    def isothermal(self, window: Window | None) -> Material:
        # The fields are checked as the arguments of the model would be.
        build = self.entry.build if self.needs_window else self.entry.build_checked
        material: Any = build(**self.values((*self.entry.constants, "density", "name")))
        return material if window is None or not self.needs_window else material.within(window)


class LibrarySection(MaterialSection):
    """A material of the library by its name."""

    library: str

    @field_validator("library")
    @classmethod
    def _known(cls, value: str) -> str:
        return choice("", value, library.names())

    def isothermal(self, window: Window | None) -> Material:
        return library.get(self.library)


class FileSection(MaterialSection):
    """A material in a file: measured data, which are fitted, Prony terms, or the deck of a solver."""

    # Before the file, whose reading needs it.
    material_name: str | None = None
    file: Annotated[
        InstanceOf[RelaxationTable]
        | InstanceOf[DynamicTable]
        | InstanceOf[CreepTable]
        | InstanceOf[Isotherms]
        | InstanceOf[TemperatureRamp]
        | InstanceOf[PronyTerms]
        | InstanceOf[ViscoelasticDeck],
        FROM_FILE,
    ]
    reference_temperature: Temperature | None = None
    superposition: ShiftLaw | None = None
    frequency: Annotated[float, positive(FREQUENCY, "frequency of a temperature ramp")] | None = None
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

    def check_keys(self) -> None:
        what, keys = "Prony terms", (*_OF_MODULI, *_ENDS)
        if isinstance(self.file, ViscoelasticDeck):
            what, keys = "the deck of a solver", ("material_name", "youngs_modulus", "poisson_ratio")
        elif not isinstance(self.file, PronyTerms):
            what, keys = "measured data", ("misfit", "liquid", *_OF_MODULI)
        if isinstance(self.file, Isotherms):
            what, keys = "several temperatures", ("reference_temperature", "superposition", *keys)
            if self.shift is not None:
                refuse("has no meaning for several temperatures, whose shift is fitted", "shift")
        if isinstance(self.file, TemperatureRamp):
            what, keys = "a temperature ramp", ("frequency", *keys)
        others = (key for key in type(self).model_fields if key not in ("file", *keys, *MaterialSection.model_fields))
        self.refuse_present(f"has no meaning for {what}; known are {', '.join(keys)}", *others)
        if missing := [] if isinstance(self.file, ViscoelasticDeck) else self._missing(self.file.deformation):
            raise CaseError(*missing)
        try:
            _ = self.fit
            _ = self.curve and self.curve.shift
        except InputError as error:
            is_key = error.field in type(self).model_fields
            refuse(error.rule, error.field if is_key or not error.where else "file")

    def _missing(self, stated: str | None) -> list[InputError]:
        """Return an error for each number that data of this deformation lack."""
        mistakes: list[InputError] = []
        try:
            self.one_of("bulk_modulus", "poisson_ratio")
        except InputError as error:
            mistakes.append(error)
        if stated is None and self.deformation is None:
            rule = 'must be "tension" or "shear", as the data do not state it'
            mistakes.append(InputError("deformation", rule=rule))
        if isinstance(self.file, TemperatureRamp):
            if self.file.angular_frequency is None and self.frequency is None:
                rule = 'must be given, e.g. "1 Hz", as the data do not state it'
                mistakes.append(InputError("frequency", rule=rule))
            if self.temperature is None:
                mistakes.append(InputError("temperature", rule="is missing; the data are of many temperatures"))
        return mistakes

    @cached_property
    def curve(self) -> MasterCurve | None:
        """Master curve of several temperatures."""
        if not isinstance(self.file, Isotherms):
            return None
        law = self.superposition or "free"
        return self.file.superposed(reference_temperature=self.reference_temperature, shift=law)

    @cached_property
    def reduced_ramp(self) -> ReducedRamp | None:
        """Moduli of a temperature ramp over the reduced frequency, by the law of the shift that is given, or WLF."""
        if not isinstance(self.file, TemperatureRamp):
            return None
        omega = None if self.frequency is None else 2.0 * np.pi * self.frequency
        law: Any = self.shift.build() if isinstance(self.shift, ShiftSection) else self.shift
        return self.file.reduced(law, angular_frequency=omega)

    def by_constants(self) -> dict[str, Material]:
        """Return the material with WLF constants of some polymers, where universal ones are assumed; else none."""
        if not isinstance(self.file, TemperatureRamp) or self.shift is not None:
            return {}
        values: dict[str, Any] = {name: getattr(self, name) for name in self.model_fields_set}
        materials: dict[str, Material] = {}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RestitutionWarning)
            for name, constants in MEASURED_CONSTANTS.items():
                values["shift"] = self.file.universal_shift(*constants)
                materials[name] = type(self).model_construct(**values).build()
        return materials

    @property
    def remarks(self) -> tuple[str, ...]:
        """Remarks of the reader of the file."""
        return getattr(self.file if self.reduced_ramp is None else self.reduced_ramp.data, "notes", ())

    @cached_property
    def fit(self) -> PronyFit | None:
        """Fit to measured data."""
        reduced = self.curve or self.reduced_ramp
        data = self.file if reduced is None else reduced.data
        if not isinstance(data, Measured):
            return None
        return fit_prony(data, **self.values(("misfit", "liquid")))

    def isothermal(self, window: Window | None) -> Material:
        if isinstance(self.file, ViscoelasticDeck):
            return self.file.material(youngs_modulus=self.youngs_modulus, poisson_ratio=self.poisson_ratio)
        if self.fit is not None:
            material, reduced = self.fit.material(**self.values(_OF_MODULI)), self.curve or self.reduced_ramp
            if reduced is None:
                return material
            return replace(material, shift=reduced.shift, temperature=reduced.reference_temperature)
        terms = self.file
        assert isinstance(terms, PronyTerms)
        elastic, series = (self.bulk_modulus, self.poisson_ratio), terms.series(**self.values(_ENDS))
        moduli = shear_and_bulk(series, *elastic, terms.deformation, self.deformation)
        return Material(*moduli, source=terms.source, window=terms.window)


def models() -> dict[str, type[ModelSection]]:
    """Return the section of each registered material model by its name."""
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
    """Return whether the table of a material describes a fractional model."""
    name = content.get("model") if isinstance(content, dict) else None
    entry = material_models().get(name) if isinstance(name, str) else None
    return entry is not None and entry.needs_window


def _chosen(value: Any, info: ValidationInfo) -> Any:
    """Check a table by the section of its form; without a form it is a standard solid."""
    if not isinstance(value, dict):
        return value
    sections = models()
    if "model" in value and value["model"] not in list(sections):
        refuse(f"must be one of {', '.join(map(toml_value, sections))}", "model", value["model"])
    forms = [key for key in (*_FORMS, "model") if key in value]
    if len(forms) > 1:
        refuse(f"give one of library, file, model and shear; {' and '.join(forms)} are given")
    if not forms:
        _without_model(value, sections)
    form = _FORMS[forms[0]] if set(forms) & _FORMS.keys() else sections[value.get("model", _DEFAULT)]
    return form.model_validate(value, context=info.context)


def _without_model(value: dict[str, Any], sections: dict[str, type[ModelSection]]) -> None:
    """Point from constants of other models than the standard solid, which needs no name, to those models."""
    keys_of = {name: set(section.model_fields) - _COMMON for name, section in sections.items()}
    constants = set[str]().union(*keys_of.values()) & set(value)
    for key in value:
        if key in constants and key not in keys_of[_DEFAULT]:
            having = [name for name, keys in keys_of.items() if key in keys]
            names = " or ".join(map(toml_value, [name for name in having if constants <= keys_of[name]] or having))
            refuse(f"is a constant of another model than the standard solid; give model = {names}", key)


AnyMaterial = Annotated[
    SerializeAsAny[InstanceOf[MaterialSection]],
    BeforeValidator(_chosen),
    Forms(lambda: (*models().values(), *_FORMS.values())),
]
