"""Case files of identifications (measured data and a model) and of designs (a guess and possible impacts)."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, cast

import numpy as np
from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    SerializeAsAny,
    StrictBool,
    StrictInt,
    TypeAdapter,
    ValidationInfo,
    create_model,
    field_validator,
    model_validator,
)

from restitution.case.axes import distribution, number, read_axis
from restitution.case.material import AnyMaterial, MaterialSection, ModelSection
from restitution.case.observations import KINDS, read_observations
from restitution.case.profile import AnyProfile
from restitution.case.quantity import Reader, nonnegative, positive, within
from restitution.case.section import Section, in_file, read_sections, read_toml, refuse, split_list, toml_value
from restitution.errors import InputError
from restitution.identification.observations import Noise, Observations
from restitution.identification.parameters import SPECTRUM
from restitution.material.models import material_models
from restitution.material.shift import WLF, Arrhenius
from restitution.quantities import DENSITY, INPUTS, MEASURED, NUMBER, choice
from restitution.sweeps.grid import Linear
from restitution.units import STIFFNESS, to_si

if TYPE_CHECKING:
    from restitution.identification.design import Design
    from restitution.identification.identify import Comparison
    from restitution.identification.result import Identification
    from restitution.identification.spectrum import Spectrum

_KNOWN = ("poisson_ratio", "bulk_modulus")
_PRIOR = '{ bulk_modulus = { lognormal = ["2 GPa", 0.2] } }'
_LOSS = "loss function of the residuals; all but the first reduce the weight of outliers"
_CRITERION = "minimise the error of the worst direction, or the volume of the error ellipsoid"
_SHIFTS = {"wlf": WLF, "arrhenius": Arrhenius}
_INPUTS = ("radius", "mass", "velocity", "temperature", "external_force", "gravity", "drop_height")


def _partner(section: MaterialSection) -> MaterialSection:
    """Refuse a fractional model, which holds in a window of time that the data do not have yet."""
    if section.needs_window:
        refuse("must be a series of terms or a classical model: a fractional one needs a window of time")
    return section


# Not both as a union: that would have a message for each.
def _counter(value: Any, info: ValidationInfo) -> Any:
    if value == "same":
        return value
    if not isinstance(value, dict):
        refuse('must be "same" or a material, such as { shear = "80 GPa", poisson_ratio = 0.3 }')
    return _PARTNER.validate_python(value, context=info.context)


_PARTNER: TypeAdapter[MaterialSection] = TypeAdapter(Annotated[AnyMaterial, AfterValidator(_partner)])
_NUMBERS: dict[str, Any] = {
    **{name: Annotated[float, Reader(INPUTS[name])] for name in _INPUTS},
    "air_density": Annotated[float, nonnegative(DENSITY, "density of the air; 0 leaves the drag out")],
    "drag_coefficient": Annotated[float, nonnegative(NUMBER, "drag coefficient")],
    "gain": Annotated[float | Literal["unknown"], Field(description='measured over true force, or `"unknown"`')],
    "ar1": Annotated[float, within(NUMBER, 0.0, 1.0, "correlation of the noise of successive samples")],
    "spring_constant": Annotated[float, positive(STIFFNESS, "stiffness of the cantilever")],
    "deformation": Literal["tension", "shear"],
    "segment": Literal["approach"],
    "adhesion": Annotated[StrictBool, Field(description="whether the surfaces adhere")],
    "profile": AnyProfile,
    "counter_material": Annotated[Any, BeforeValidator(_counter)],
}
"""Keys of a set of data that are arguments of its class."""


def _noise(value: Any) -> Any:
    """Return the standard deviations: numbers in SI, texts with a unit or in per cent, or lists of two such."""
    if not isinstance(value, dict):
        refuse('must be a table such as { restitution_coefficient = 0.005, contact_time = "1 %" }')
    deviations: dict[str, Any] = {}
    for name, entry in cast("dict[str, Any]", value).items():
        parts = [_deviation(name, part) for part in (entry if isinstance(entry, list) else [entry])]
        deviations[name] = parts[0] if len(parts) == 1 else tuple(parts)
    Noise(**deviations)
    return deviations


def _deviation(name: str, value: Any) -> Any:
    if not isinstance(value, str) or value.strip().endswith("%"):
        return value
    try:
        return to_si(value, MEASURED[name].dimension if name in MEASURED else NUMBER)
    except InputError as error:
        refuse(error.rule, name, value)


AnyNoise = Annotated[dict[str, Any], BeforeValidator(_noise)]


class DataSection(Section):
    """A set of measured data."""

    kind: str
    file: str
    noise: AnyNoise | None = None

    def read(self, folder: Path) -> Observations:
        """Return the observations in SI."""
        keys = type(self).model_fields.keys() - DataSection.model_fields.keys()
        arguments: dict[str, Any] = self.values(sorted(keys))
        if arguments.get("gain") == "unknown":
            arguments["gain"] = None
        if (profile := arguments.get("profile")) is not None:
            if profile.needs_body_radius and "radius" not in arguments:
                raise InputError("profile.radius", rule="is missing")
            arguments["profile"] = profile.build(arguments.get("radius"))
            if profile.needs_body_radius:
                del arguments["radius"]
        if isinstance(counter := arguments.get("counter_material"), MaterialSection):
            arguments["counter_material"] = counter.build()
        try:
            return read_observations(Path(folder, self.file), kind=self.kind, noise=self.noise, **arguments)
        except InputError as error:
            if error.field:
                raise
            refuse(error.rule, "file", self.file)


@cache
def data_section(name: str) -> type[DataSection]:
    """Return the section of a kind of data, from the arguments of its class."""
    kind = KINDS[name]
    keys = [key for key in inspect.signature(kind.build).parameters if key in _NUMBERS and key not in kind.required]
    fields: dict[str, Any] = {"kind": (Literal[name], ...), **{key: (_NUMBERS[key] | None, None) for key in keys}}
    return create_model(f"{name}_section", __base__=DataSection, **fields)


def _chosen(value: Any, info: ValidationInfo) -> Any:
    if not isinstance(value, dict):
        return value
    kind = value.get("kind")
    if kind not in list(KINDS):
        rule = f"must be one of {', '.join(map(toml_value, KINDS))}"
        refuse(rule if "kind" in value else f"is missing; {rule}", "kind", value.get("kind"))
    return data_section(kind).model_validate(value, context=info.context)


AnyData = Annotated[SerializeAsAny[DataSection], BeforeValidator(_chosen)]


def _by(read: Callable[[str, Any], Any]) -> BeforeValidator:
    """Return the table of values by parameter, each read by a function of its name and the value."""

    def table(value: Any) -> dict[str, Any]:
        if not isinstance(value, dict):
            refuse("must be a table by the names of parameters")
        return {name: read(name, item) for name, item in cast("dict[str, Any]", value).items()}

    return BeforeValidator(table)


def _distribution(name: str, value: Any) -> Any:
    return distribution(name, name, value)


def _value(name: str, value: Any) -> Any:
    value = split_list(value) if isinstance(value, str) and value.lstrip().startswith("[") else value
    return [number(name, name, item) for item in value] if isinstance(value, list) else number(name, name, value)


def _ends(name: str, value: Any) -> tuple[float, float]:
    ends = _value(name, value)
    if not isinstance(ends, list) or len(cast("list[float]", ends)) != 2:
        refuse("must be a list of the two ends", name, value)
    return ends[0], ends[1]


_Values = Annotated[dict[str, Any] | None, _by(_value)]
_Bounds = Annotated[dict[str, Any] | None, _by(_ends)]
_Priors = Annotated[dict[str, Any] | None, _by(_distribution)]


class IdentificationSection(Section):
    """The model of the material, and known constants, bounds and priors."""

    model: Annotated[str, Field(description='name of a model, as in `[material]`, or `"spectrum"`')]
    terms: Annotated[StrictInt, Field(ge=1, le=50, description="number of terms of a model with lists")] = 2
    fixed: Annotated[_Values, Field(description="known constants, such as `{ poisson_ratio = 0.47 }`")] = None
    bounds: Annotated[_Bounds, Field(description="bounds of constants, such as `{ viscosity = [1, 1e6] }`")] = None
    start: Annotated[_Values, Field(description="first values of constants; the default follows from the data")] = None
    prior: Annotated[_Priors, Field(description=f"distributions, such as `{_PRIOR}`")] = None
    shift: Annotated[Literal["wlf", "arrhenius"] | None, Field(description="law of the shift to be found")] = None
    loss: Annotated[Literal["linear", "soft_l1", "huber", "cauchy"], Field(description=_LOSS)] = "linear"
    compare: Annotated[tuple[str, ...], Field(description="names of further models to compare with")] = ()

    @field_validator("model")
    @classmethod
    def _known(cls, value: str) -> str:
        return choice("", value, (*material_models(), SPECTRUM))

    @field_validator("compare")
    @classmethod
    def _all_known(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(map(cls._known, value))

    @property
    def options(self) -> dict[str, Any]:
        """Keyword arguments of `identify`."""
        options: dict[str, Any] = self.model_dump(exclude={"model", "compare", "shift"})
        return options | {"shift": None if self.shift is None else _SHIFTS[self.shift]}


class IdentificationFile(Section):
    """A whole case file of an identification."""

    elsewhere: ClassVar[dict[str, str]] = dict.fromkeys(
        ("body", "impact", "material", "indentation"), "an identification has none; its data are in [[data]]"
    )

    title: str | None = None
    identification: IdentificationSection
    data: Annotated[list[AnyData], Field(min_length=1)]


@dataclass(frozen=True)
class IdentificationCase:
    """Measured data and a model as a case file describes them, in SI."""

    path: Path
    title: str | None
    section: IdentificationSection
    data: tuple[Observations, ...]

    def solve(
        self, profiles: bool | None = None, progress: Callable[[int, int], None] | None = None
    ) -> Identification | Spectrum:
        """Identify the material with the options of the file; a `CaseError` refuses data that do not fit the model."""
        from restitution.identification.identify import identify

        with in_file(self.path, "identification"):
            options = self.section.options
            return identify(list(self.data), self.section.model, profiles=profiles, progress=progress, **options)

    def compare(self, progress: Callable[[int, int], None] | None = None) -> Comparison | None:
        """Compare the model with those of the key `compare`; None without the key."""
        if not self.section.compare:
            return None
        from restitution.identification.identify import compare

        models = list(dict.fromkeys((self.section.model, *self.section.compare)))
        with in_file(self.path, "identification"):
            return compare(list(self.data), models, progress=progress, **self.section.options)


def read_identification(path: str | Path) -> IdentificationCase:
    r"""Read a TOML file of an identification; a `CaseError` has a line for each mistake, as in `read_case`.

    Examples
    --------
    >>> import tempfile
    >>> text = '''
    ... [identification]
    ... model = "kelvin_voigt"
    ... fixed = { poisson_ratio = 0.5 }
    ... [[data]]
    ... kind = "rebounds"
    ... file = "ball.csv"
    ... radius = "10 mm"
    ... mass = "33 g"
    ... noise = { restitution_coefficient = 0.005 }
    ... '''
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "ball.csv").write_text("velocity [m/s],e\n0.5,0.82\n1.0,0.79\n2.0,0.76\n")
    ...     _ = Path(folder, "case.toml").write_text(text)
    ...     case = read_identification(Path(folder, "case.toml"))
    >>> case.data[0].size
    3
    """
    path = Path(path)
    case = read_sections(IdentificationFile, path, read_toml(path))
    data: list[Observations] = []
    for n, source in enumerate(case.data):
        with in_file(path, f"data[{n}]"):
            data.append(source.read(path.parent))
    return IdentificationCase(path, case.title, case.identification, tuple(data))


class DesignSection(Section):
    """Possible impacts for a design."""

    velocity: Annotated[Any, Field(description="impact velocities: a list or an axis, as in `[axes]`")]
    radius: Annotated[Any, Field(description="radii of the balls: a list or an axis")]
    density: Annotated[Any, Field(description="density of the balls, one number or one for each radius")] = None
    mass: Annotated[Any, Field(description="mass of the balls instead, one number or one for each radius")] = None
    n: Annotated[StrictInt, Field(ge=1, le=10_000, description="number of impacts, repeats included")] = 20
    criterion: Annotated[Literal["E", "D"], Field(description=_CRITERION)] = "E"
    fixed: Annotated[tuple[str, ...], Field(description="names of constants that are known")] = _KNOWN
    noise: AnyNoise | None = None

    @field_validator("velocity", "radius", "density", "mass", mode="before")
    @classmethod
    def _axis(cls, value: Any, info: ValidationInfo) -> Any:
        name = str(info.field_name)
        try:
            axis = read_axis(name, name, split_list(value) if isinstance(value, str) and "[" in value else value)
        except InputError as error:
            # The place of the value in the file has the name already.
            field = error.field.removeprefix(name).lstrip(".")
            raise InputError(field, error.value, error.rule, error.unit) from None
        return axis.values(0, axis.size) if isinstance(axis, Linear) else np.atleast_1d(axis)

    @model_validator(mode="after")
    def _check(self) -> DesignSection:
        self.one_of("density", "mass")
        return self


class DesignFile(Section):
    """A whole case file of a design: a guess of the material, and possible impacts."""

    title: str | None = None
    material: AnyMaterial
    design: DesignSection


@dataclass(frozen=True)
class DesignCase:
    """A guess of the material and possible impacts as a case file describes them, in SI."""

    path: Path
    title: str | None
    model: partial[Any]
    section: DesignSection

    def solve(self) -> Design:
        """Choose the impacts."""
        from restitution.identification.design import design

        section = self.section
        candidates = {
            name: getattr(section, name) for name in section.present("velocity", "radius", "density", "mass")
        }
        noise = None if section.noise is None else Noise(**section.noise)
        with in_file(self.path, "design"):
            return design(self.model, candidates, section.n, section.criterion, fixed=section.fixed, noise=noise)


def read_design(path: str | Path) -> DesignCase:
    """Read a TOML file of a design; a `CaseError` has a line for each mistake, as in `read_case`."""
    path = Path(path)
    case = read_sections(DesignFile, path, read_toml(path))
    with in_file(path, "material"):
        if not isinstance(case.material, ModelSection):
            refuse('must be a model with its constants, such as model = "standard_solid"')
    entry = case.material.entry
    constants: Mapping[str, Any] = case.material.model_dump(include=set(entry.constants), exclude_none=True)
    return DesignCase(path, case.title, partial(entry.build, **constants), case.design)
