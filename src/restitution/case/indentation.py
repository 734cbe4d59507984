"""Case files of prescribed indentations: materials, a profile, and a history of depth or force."""

from __future__ import annotations

from dataclasses import dataclass
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Discriminator, Field, StrictInt, Tag, model_validator

from restitution.case.impact import AccuracySection, AdhesionSection, notes_on
from restitution.case.material import AnyMaterial
from restitution.case.profile import AnyProfile
from restitution.case.quantity import LIST, named_columns, nonnegative, positive, read_columns, within
from restitution.case.section import IN_FILE, MOTIONS, Section, in_file, read_sections, read_toml, refuse
from restitution.contact.geometry import Geometry
from restitution.impact.window import window_around
from restitution.indentation.history import History, cycles, hold, ramp, sine_arch, triangle
from restitution.material.fractional import Window
from restitution.material.viscoelastic import Material
from restitution.quantities import FORCE, LENGTH, NUMBER, TIME
from restitution.units import STIFFNESS

if TYPE_CHECKING:
    from restitution.indentation.result import IndentationResult

MOST_POINTS = 10_000_000
Duration = Annotated[float, positive(TIME, "duration")]
_ANY = (-1e300, 1e300)
# Start of the window of a fractional material over the shortest piece of the history, and how much earlier than by
# the duration it may be: still faster terms take minutes.
_SHARE, _EARLIER = 0.1, 1e-2
_VALLEY = "lowest value between two cycles over the largest one; the default is 0"
_SPRING = "stiffness of a spring, such as a cantilever, that holds the indenter; `depth` is then that of its base"
_BASE = "goes with depth, that of the base of the spring; leave it out"
_N_POINTS = "number of equally spaced times of the table that `--history` writes"


def _number_or_list(value: Any) -> str:
    is_list = isinstance(value, list) or (isinstance(value, str) and value.lstrip().startswith("["))
    return "<list>" if is_list else "<number>"


Depth = Annotated[
    Annotated[float, positive(LENGTH), Tag("<number>")]
    | Annotated[list[Annotated[float, within(LENGTH, *_ANY)]], LIST, Tag("<list>")],
    Discriminator(_number_or_list),
]
Force = Annotated[
    Annotated[float, positive(FORCE), Tag("<number>")]
    | Annotated[list[Annotated[float, within(FORCE, *_ANY)]], LIST, Tag("<list>")],
    Discriminator(_number_or_list),
]

# Functions that make the shapes. Their parameters after the first are keys of the section.
_SHAPES = {shape.__name__: shape for shape in (triangle, cycles, ramp, hold, sine_arch)}
_SHAPE_KEYS = ("loading_time", "unloading_time", "hold_time", "count", "valley", "duration", "rise_time")


class IndentationSection(Section):
    """The prescribed depth or force: a shape, points over time, or a file of points."""

    depth: Depth | None = None
    force: Force | None = None
    shape: Literal["triangle", "cycles", "ramp", "hold", "sine_arch"] | None = None
    loading_time: Duration | None = None
    unloading_time: Duration | None = None
    hold_time: Annotated[float, nonnegative(TIME)] | None = None
    count: Annotated[StrictInt | None, Field(ge=1, le=MOST_POINTS // 2, description="number of cycles")] = None
    valley: Annotated[float, within(NUMBER, 0.0, 1.0, _VALLEY)] | None = None
    duration: Duration | None = None
    rise_time: Annotated[float, nonnegative(TIME)] | None = None
    time: Annotated[list[Annotated[float, within(TIME, *_ANY)]], LIST] | None = None
    file: str | None = None
    spring_constant: Annotated[float, positive(STIFFNESS, _SPRING)] | None = None
    n_points: Annotated[StrictInt, Field(ge=2, le=MOST_POINTS, description=_N_POINTS)] = 401

    @model_validator(mode="after")
    def _check(self) -> IndentationSection:
        if self.file is not None:
            self.refuse_present(IN_FILE, "depth", "force", "time", "shape", *_SHAPE_KEYS)
            return self
        name = self.one_of("depth", "force")
        if name == "force":
            self.refuse_present(_BASE, "spring_constant")
        if not isinstance(getattr(self, name), list):
            self._check_shape(name)
            return self
        if self.time is None:
            refuse(f"is missing; it belongs to the list of {name}", "time")
        self.refuse_present(f"belongs to one largest {name}; {name} is a list over time", "shape", *_SHAPE_KEYS)
        return self

    def _check_shape(self, name: str) -> None:
        if self.time is not None:
            refuse(f"belongs to a list of {name}; {name} is one number", "time")
        if self.shape is None:
            names = ", ".join(f'"{shape}"' for shape in _SHAPES)
            refuse(f"is missing; one of {names}, or give lists of {name} and time", "shape")
        _, *parameters = signature(_SHAPES[self.shape]).parameters.values()
        for parameter in parameters:
            if parameter.default is parameter.empty and getattr(self, parameter.name) is None:
                refuse(f'is missing; shape = "{self.shape}" needs it', parameter.name)
        names = [parameter.name for parameter in parameters]
        rule = f'does not go with shape = "{self.shape}"; that takes {", ".join(names)}'
        self.refuse_present(rule, *(key for key in _SHAPE_KEYS if key not in names))

    def read(self, folder: Path) -> tuple[str, History]:
        """Return the name of the prescribed quantity, and its history in SI."""
        if self.file is not None:
            names = named_columns(folder, self.file)
            if {"depth", "force"} <= set(names):
                refuse("has columns of depth and of force: one of the two is prescribed; leave the other out")
            name = "force" if "force" in names else "depth"
            if name == "force" and self.spring_constant is not None:
                refuse("has a column of force; spring_constant goes with depth, that of the base of the spring")
            dimensions = {"time": TIME, name: LENGTH if name == "depth" else FORCE}
            columns = read_columns(folder, self.file, dimensions)
            return name, History.from_points(columns["time"], columns[name], name=name)
        name = self.one_of("depth", "force")
        value = getattr(self, name)
        if isinstance(value, list):
            return name, History.from_points(np.array(self.time), np.array(value), name=name)
        assert self.shape is not None
        return name, _SHAPES[self.shape](value, **self.values(_SHAPE_KEYS))


class IndenterFile(Section):
    """Title, profile and materials of a case file of an indenter."""

    elsewhere: ClassVar[dict[str, str]] = dict.fromkeys(
        ("body", "impact", "counter_body"), "an impact is for `restitution solve`"
    )

    def __init_subclass__(cls, **options: Any) -> None:
        """Name the command of another motion that the file of this motion has."""
        super().__init_subclass__(**options)
        cls.elsewhere = cls.elsewhere | {key: text for key, text in MOTIONS.items() if key not in cls.__annotations__}

    title: str | None = None
    profile: AnyProfile
    material: AnyMaterial
    counter_material: AnyMaterial | None = None

    @model_validator(mode="after")
    def _has_radius(self) -> IndenterFile:
        if self.profile.needs_body_radius:
            refuse("is missing; an indenter has no body to take it from", "profile.radius")
        return self


class IndentationFile(IndenterFile):
    """A whole case file of an indentation."""

    indentation: IndentationSection
    adhesion: AdhesionSection | None = None
    solver: AccuracySection = AccuracySection()

    @model_validator(mode="after")
    def _pulls_with_adhesion(self) -> IndentationFile:
        force = self.indentation.force
        if self.adhesion is None and isinstance(force, list):
            for n, value in enumerate(force):
                if value < 0.0:
                    refuse("must be finite and >= 0 without [adhesion]", f"indentation.force[{n}]", value)
        return self


@dataclass(frozen=True)
class IndenterCase:
    """Bodies of a case file of an indenter, in SI."""

    path: Path
    title: str | None
    material: Material  # of the half-space
    profile: Geometry  # of the contact
    counter_material: Material | None  # of the indenter, where it deforms

    def notes(self) -> list[str]:
        """Return the assumptions about the materials."""
        return notes_on(self.material, self.counter_material)


def bodies_of(
    file: IndenterFile, path: Path, window: Window
) -> tuple[Path, str | None, Material, Geometry, Material | None]:
    """Return the fields of `IndenterCase`, with materials for a window of time."""
    with in_file(path):
        counter = None if file.counter_material is None else file.counter_material.build(window)
        return path, file.title, file.material.build(window), file.profile.build(None), counter


@dataclass(frozen=True)
class IndentationCase(IndenterCase):
    """A prescribed indentation as a case file describes it, in SI."""

    prescribed: str  # "depth" or "force"
    history: History
    n_points: int  # of even times of the table that is written
    options: dict[str, Any]  # keyword arguments of `indent`

    def solve(self) -> IndentationResult:
        """Solve the indentation with the options of the file; a `CaseError` refuses a start in contact, and others."""
        # The solver takes a while to import, which a faulty file need not wait for.
        from restitution.indentation.solve import indent

        with in_file(self.path, rtol="solver", **dict.fromkeys(("depth", "force", "time"), "indentation")):
            options: dict[str, Any] = {self.prescribed: self.history} | self.options
            return indent(self.material, self.profile, counter_material=self.counter_material, **options)


def read_indentation(path: str | Path) -> IndentationCase:
    """Read a TOML file of a prescribed indentation; a `CaseError` has a line for each mistake, as in `read_case`.

    Examples
    --------
    >>> import tempfile
    >>> text = '''
    ... [profile]
    ... radius = "2.5 um"
    ... [material]
    ... model = "standard_solid"
    ... equilibrium_modulus = "70 Pa"
    ... branch_modulus = "270 Pa"
    ... viscosity = "80 Pa s"
    ... poisson_ratio = 0.5
    ... [indentation]
    ... depth = "1 um"
    ... shape = "triangle"
    ... loading_time = "1 s"
    ... '''
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "gel.toml").write_text(text)
    ...     case = read_indentation(Path(folder, "gel.toml"))
    >>> print(case.prescribed, case.history(0.5))
    depth 5e-07
    """
    path = Path(path)
    case = read_sections(IndentationFile, path, read_toml(path))
    section = case.indentation
    with in_file(path, "indentation" if section.file is None else "indentation.file"):
        name, history = section.read(path.parent)
    window = window_around(history.stop - history.start)
    # A fast ramp before a long hold is faster than the start of the window of its duration.
    pieces = np.diff(history.knots)
    fastest = max(_SHARE * float(pieces[pieces > 0.0].min()), _EARLIER * window.low)
    window = window._replace(low=min(window.low, fastest))
    options = case.solver.options | section.values(("spring_constant",))
    if case.adhesion is not None:
        with in_file(path, "adhesion"):
            options["adhesion"] = case.adhesion.build()
    return IndentationCase(*bodies_of(case, path, window), name, history, section.n_points, options)
