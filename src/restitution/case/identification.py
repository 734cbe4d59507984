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
    BeforeValidator,
    Field,
    SerializeAsAny,
    StrictInt,
    ValidationInfo,
    create_model,
    field_validator,
    model_validator,
)

from restitution.case.axes import distribution, number, read_axis
from restitution.case.material import AnyMaterial, ModelSection
from restitution.case.observations import DIMENSIONS, KINDS, read_observations
from restitution.case.profile import AnyProfile
from restitution.case.quantity import Reader, nonnegative, positive, split_list, to_si, within
from restitution.case.section import Section, in_file, read_sections, read_toml, refuse, toml_value
from restitution.errors import InputError
from restitution.identification.arguments import SPECTRUM
from restitution.identification.observations import Noise, Observations
from restitution.material.models import material_models
from restitution.material.shift import WLF, Arrhenius
from restitution.quantities import DENSITY, INPUTS, MODULI, MODULUS, NUMBER, Dimension, known
from restitution.sweeps.grid import Linear

if TYPE_CHECKING:
    from restitution.identification.comparison import Comparison
    from restitution.identification.design import Design
    from restitution.identification.result import Identification
    from restitution.identification.spectrum import Spectrum

_KNOWN = ("poisson_ratio", "bulk_modulus")
_PRIOR = '{ bulk_modulus = { lognormal = ["2 GPa", 0.2] } }'
_LOSS = "loss function of the residuals; all but the first reduce the weight of outliers"
_CRITERION = "minimise the error of the worst direction, or the volume of the error ellipsoid"
_Table = dict[str, Any] | None
_SHIFTS = {"wlf": WLF, "arrhenius": Arrhenius}
_INPUTS = ("radius", "mass", "velocity", "temperature", "external_force", "gravity", "drop_height")
_STIFFNESS = Dimension("stiffness", "N/m", "0.1 N/m")
_NUMBERS: dict[str, Any] = {
    **{name: Annotated[float, Reader(INPUTS[name])] for name in _INPUTS},
    "air_density": Annotated[float, nonnegative(DENSITY, "density of the air; 0 leaves the drag out")],
    "drag_coefficient": Annotated[float, nonnegative(NUMBER, "drag coefficient")],
    "gain": Annotated[float | Literal["unknown"], Field(description='measured over true force, or `"unknown"`')],
    "ar1": Annotated[float, within(NUMBER, 0.0, 1.0, "correlation of the noise of successive samples")],
    "spring_constant": Annotated[float, positive(_STIFFNESS, "stiffness of the cantilever")],
    "deformation": Literal["tension", "shear"],
    "profile": AnyProfile,
}
"""Keys of a set of data that are arguments of its class."""
_MEASURED = DIMENSIONS | {name: one.dimension for name, one in MODULI.items()} | {"modulus": MODULUS}


def _noise(value: Any) -> Any:
    """Standard deviations: numbers in SI, texts with a unit or in per cent, or lists of two such."""
    if not isinstance(value, dict):
        refuse('must be a table such as { restitution_coefficient = 0.005, contact_time = "1 %" }')
    found: dict[str, Any] = {}
    for name, given in cast("dict[str, Any]", value).items():
        parts = [_deviation(name, one) for one in (given if isinstance(given, list) else [given])]
        found[name] = parts[0] if len(parts) == 1 else tuple(parts)
    Noise(**found)
    return found


def _deviation(name: str, given: Any) -> Any:
    if not isinstance(given, str) or given.strip().endswith("%"):
        return given
    try:
        return to_si(given, _MEASURED.get(name, NUMBER))
    except InputError as error:
        refuse(error.wanted, name, given)


AnyNoise = Annotated[dict[str, Any], BeforeValidator(_noise)]


class DataSection(Section):
    """A set of measured data."""

    kind: str
    file: str
    noise: AnyNoise | None = None

    def read(self, folder: Path) -> Observations:
        """Observations in SI."""
        keys = type(self).model_fields.keys() - DataSection.model_fields.keys()
        given: dict[str, Any] = {key: getattr(self, key) for key in self.given(*sorted(keys))}
        if given.get("gain") == "unknown":
            given["gain"] = None
        if (profile := given.get("profile")) is not None:
            given["profile"] = profile.build(given.get("radius"))
            if profile.needs_body_radius:
                del given["radius"]
        try:
            return read_observations(Path(folder, self.file), kind=self.kind, noise=self.noise, **given)
        except InputError as error:
            if error.field:
                raise
            refuse(error.wanted, "file", self.file)


@cache
def data_section(name: str) -> type[DataSection]:
    """Section of a kind of data, from the arguments of its class."""
    kind = KINDS[name]
    keys = [key for key in inspect.signature(kind.build).parameters if key in _NUMBERS and key not in kind.required]
    fields: dict[str, Any] = {"kind": (Literal[name], ...), **{key: (_NUMBERS[key] | None, None) for key in keys}}
    return create_model(f"{name}_section", __base__=DataSection, **fields)


def _chosen(value: Any, info: ValidationInfo) -> Any:
    if not isinstance(value, dict):
        return value
    kind = value.get("kind")
    if kind not in list(KINDS):
        wanted = f"must be one of {', '.join(map(toml_value, KINDS))}"
        refuse(wanted if "kind" in value else f"is missing; {wanted}", "kind", value.get("kind"))
    return data_section(kind).model_validate(value, context=info.context)


AnyData = Annotated[SerializeAsAny[DataSection], BeforeValidator(_chosen)]


def _values(field: str, value: Any, read: Any) -> dict[str, Any]:
    """Table of values by parameter, each read by a function of its place and the value."""
    if not isinstance(value, dict):
        refuse("must be a table by the names of parameters")
    return {name: read(name, one) for name, one in cast("dict[str, Any]", value).items()}


def _value(name: str, given: Any) -> Any:
    given = split_list(given) if isinstance(given, str) and given.lstrip().startswith("[") else given
    return [number(name, name, one) for one in given] if isinstance(given, list) else number(name, name, given)


def _ends(name: str, given: Any) -> tuple[float, float]:
    ends = _value(name, given)
    if not isinstance(ends, list) or len(cast("list[float]", ends)) != 2:
        refuse("must be a list of the two ends", name, given)
    return ends[0], ends[1]


class IdentificationSection(Section):
    """The model of the material, and known constants, bounds and priors."""

    model: Annotated[str, Field(description='name of a model, as in `[material]`, or `"spectrum"`')]
    terms: Annotated[StrictInt, Field(ge=1, le=50, description="number of terms of a model with lists")] = 2
    fixed: Annotated[_Table, Field(description="known constants, such as `{ poisson_ratio = 0.47 }`")] = None
    bounds: Annotated[_Table, Field(description="bounds of constants, such as `{ viscosity = [1, 1e6] }`")] = None
    start: Annotated[_Table, Field(description="first values of constants; the default follows from the data")] = None
    prior: Annotated[_Table, Field(description=f"distributions, such as `{_PRIOR}`")] = None
    shift: Annotated[Literal["wlf", "arrhenius"] | None, Field(description="law of the shift to be found")] = None
    loss: Annotated[Literal["linear", "soft_l1", "huber", "cauchy"], Field(description=_LOSS)] = "linear"
    compare: Annotated[tuple[str, ...], Field(description="names of further models to compare with")] = ()

    @field_validator("model")
    @classmethod
    def _known(cls, value: str) -> str:
        return known("", value, (*material_models(), SPECTRUM))

    @field_validator("compare")
    @classmethod
    def _all_known(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(cls._known(one) for one in value)

    @field_validator("fixed", "start", mode="before")
    @classmethod
    def _numbers(cls, value: Any) -> Any:
        return _values("", value, _value)

    @field_validator("bounds", mode="before")
    @classmethod
    def _pairs(cls, value: Any) -> Any:
        return _values("", value, _ends)

    @field_validator("prior", mode="before")
    @classmethod
    def _distributions(cls, value: Any) -> Any:
        return _values("", value, lambda name, one: distribution(name, name, one))

    @property
    def options(self) -> dict[str, Any]:
        """Keyword arguments of `identify`."""
        given: dict[str, Any] = self.model_dump(exclude={"model", "compare", "shift"})
        return given | {"shift": None if self.shift is None else _SHIFTS[self.shift]}


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
        from restitution.identification.comparison import compare

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
    for n, one in enumerate(case.data):
        with in_file(path, f"data[{n}]"):
            data.append(one.read(path.parent))
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
            raise InputError(field, error.value, error.wanted, error.unit) from None
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

        one = self.section
        candidates = {name: getattr(one, name) for name in one.given("velocity", "radius", "density", "mass")}
        noise = None if one.noise is None else Noise(**one.noise)
        with in_file(self.path, "design"):
            return design(self.model, candidates, one.n, one.criterion, fixed=one.fixed, noise=noise)


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
