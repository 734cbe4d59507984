"""Case files of impacts: a TOML text becomes an impact and the options of its solver."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Field, StrictBool, StrictInt, field_validator, model_validator

from restitution.case.material import AnyMaterial, FileSection
from restitution.case.profile import AnyProfile
from restitution.case.quantity import Reader, nonnegative, of, positive
from restitution.case.section import MOTIONS, Section, in_file, read_sections, read_toml, refuse, without_deviations
from restitution.checks import plain
from restitution.contact.adhesion import Adhesion
from restitution.contact.geometry import BALL_ON_TARGET
from restitution.contact.profiles import Parabola, sphere_mass
from restitution.errors import InputError
from restitution.files import path_of
from restitution.impact.problem import (
    STANDARD_GRAVITY,
    Body,
    Impact,
    collision,
    directed,
    fall_velocity,
)
from restitution.impact.window import for_contact
from restitution.material.fractional import Window
from restitution.material.viscoelastic import Material
from restitution.quantities import (
    ADHESION_INPUTS,
    DEFAULT_OUTPUTS,
    IMPACT_OUTPUTS,
    LENGTH,
    NUMBER,
    SLIDING,
    TIME,
    choice,
)

if TYPE_CHECKING:
    from restitution.impact.band import RestitutionBand
    from restitution.impact.bounces import Bounces
    from restitution.impact.result import ImpactResult

MOST_BOUNCES = 1_000_000
UNCERTAIN = ("body", "profile", "material", "counter_material", "counter_body", "impact", "adhesion")
"""Sections whose numbers may have a standard deviation."""
_SAME_SPOT = "whether each touch finds the imprint of the earlier ones, as it is then; a fresh surface otherwise"


class BodySection(Section):
    """The moving body: its mass, or its density as a solid sphere."""

    mass: Annotated[float, of("mass")] | None = None
    density: Annotated[float, of("density")] | None = None
    radius: Annotated[float, of("radius")] | None = None

    @model_validator(mode="after")
    def _check(self) -> BodySection:
        if self.one_of("mass", "density") == "density" and self.radius is None:
            refuse("is missing; a density gives the mass of a sphere of this radius", "radius")
        return self

    @property
    def kilograms(self) -> Any:
        """Mass [kg], that of a solid sphere where a density is given."""
        return self.mass if self.mass is not None else sphere_mass(self.density, self.radius)


class CounterBodySection(BodySection):
    """A second, free body at rest: with `radius` a ball, without it flat.

    Its material is that of this section, or `counter_material`, or else that of the body.
    """

    material: AnyMaterial | None = None
    rigid: Annotated[StrictBool, Field(description="whether it does not deform")] = False


class ImpactSection(Section):
    """The velocity of the body or the height of its fall, a constant external force; friction and oblique motion."""

    velocity: Annotated[float, of("velocity")] | None = None
    drop_height: Annotated[float, of("drop_height")] | None = None
    gravity: Annotated[float, of("gravity")] = STANDARD_GRAVITY
    external_force: Annotated[float, of("external_force")] | None = None
    impedance: Annotated[float, of("impedance")] | None = None
    weight: Annotated[StrictBool | None, Field(description="whether the weight acts during contact")] = None
    body_size: Annotated[float, positive(LENGTH, "smallest dimension of the target, for warnings")] | None = None
    material_of: Annotated[
        Literal["target", "body"] | None, Field(description="which body is of `[material]`, for warnings of waves")
    ] = None
    friction: Annotated[float, of("friction")] | None = None
    tangential_velocity: Annotated[float, of("tangential_velocity")] | None = None
    angle: Annotated[float, of("angle")] | None = None
    speed: Annotated[float, of("speed")] | None = None
    spin: Annotated[float, of("spin")] | None = None
    gyration: Annotated[float, of("gyration")] | None = None

    @model_validator(mode="after")
    def _check(self) -> ImpactSection:
        self.one_of("velocity", "drop_height", "speed")
        if self.speed is not None and self.angle is None:
            refuse("belongs to an angle of incidence; give angle", "speed", self.speed)
        if self.angle is not None and self.tangential_velocity is not None:
            refuse("give tangential_velocity or angle, not both")
        if self.friction is None:
            rule = "belongs to an impact with friction; give friction, 0 for a smooth contact"
            self.refuse_present(rule, "tangential_velocity", "angle", "spin", "gyration")
        if self.weight and self.external_force is not None:
            refuse("give external_force or weight = true, not both")
        return self

    @property
    def impact_velocity(self) -> Any:
        """Normal velocity at first touch [m/s]; sqrt(2 g h) after a fall."""
        if self.drop_height is not None:
            return plain(fall_velocity(self.drop_height, self.gravity))
        return self.velocity if self.speed is None else plain(directed(None, self.angle, self.speed)[0])

    @property
    def sliding(self) -> dict[str, Any]:
        """Numbers of the tangential motion; none without friction."""
        if self.friction is None:
            return {}
        along = _or(self.tangential_velocity, 0.0)
        if self.angle is not None:
            along = plain(directed(self.impact_velocity, self.angle, self.speed)[1])
        return self.values(SLIDING) | {"tangential_velocity": along}


class AdhesionSection(Section):
    """Attraction of the surfaces: its work, and the stress or the range, by default a range of 0.4 nm."""

    work: Annotated[float, Reader(ADHESION_INPUTS["work"])]
    stress: Annotated[float, Reader(ADHESION_INPUTS["stress"])] | None = None
    range: Annotated[float, Reader(ADHESION_INPUTS["range"])] | None = None

    @model_validator(mode="after")
    def _check(self) -> AdhesionSection:
        if self.stress is not None and self.range is not None:
            refuse("give stress or range, not both")
        return self

    def build(self) -> Adhesion:
        """Return the adhesion in SI."""
        return Adhesion(self.work, self.stress, self.range)


class BouncesSection(Section):
    """Surface and end of a series of bounces."""

    max_bounces: Annotated[
        StrictInt, Field(ge=1, le=MOST_BOUNCES, description="bounces after which the series ends")
    ] = 1000
    min_height: Annotated[float, nonnegative(LENGTH, "height below which a rise ends the series")] | None = None
    same_spot: Annotated[StrictBool, Field(description=_SAME_SPOT)] = False


class AccuracySection(Section):
    """Accuracy of the solver."""

    rtol: Annotated[float, positive(NUMBER, "relative tolerance of the restitution coefficient")] | None = None

    @property
    def options(self) -> dict[str, Any]:
        """Keyword arguments of the solver."""
        return self.model_dump(exclude_none=True)


class SolverSection(AccuracySection):
    """Method of the solver and its accuracy."""

    method: Literal["exact", "elements"] = "exact"
    n_elements: Annotated[StrictInt | None, Field(ge=1, le=1_000_000, description="number of elements")] = None
    time_step: Annotated[float, positive(TIME, "time step of the method of elements")] | None = None

    @model_validator(mode="after")
    def _check(self) -> SolverSection:
        if self.method != "elements":
            rule = f'is an option of method = "elements", not of method = "{self.method}"'
            self.refuse_present(rule, "n_elements", "time_step")
        return self


class UncertaintySection(Section):
    """Standard deviations of numbers of the impact, and how those of its outputs follow."""

    deviations: Annotated[
        dict[str, Any],
        Field(description="standard deviations by the names of keys, as in `[axes]`, with a unit or in per cent"),
    ] = {}  # noqa: RUF012 - pydantic copies it
    outputs: Annotated[tuple[str, ...], Field(description="outputs that have them")] = DEFAULT_OUTPUTS
    draws: Annotated[
        StrictInt | None, Field(ge=10, le=1_000_000, description="random draws that check the linear deviations")
    ] = None
    seed: Annotated[StrictInt, Field(ge=0, description="seed of the draws")] = 0

    @field_validator("outputs")
    @classmethod
    def _known(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        try:
            return tuple(choice("", name, IMPACT_OUTPUTS) for name in value)
        except InputError as error:
            refuse(error.rule)


class CaseFile(Section):
    """A whole case file."""

    elsewhere: ClassVar[dict[str, str]] = MOTIONS | {
        "oblique": "friction, tangential_velocity or angle, and spin stand in [impact]",
        "axes": "axes are for `restitution sweep`",
        "samples": "random draws are for `restitution sweep`",
    }

    title: Annotated[str | None, Field(description="what the case is; printed above the table")] = None
    body: BodySection
    profile: Annotated[AnyProfile, Field(default_factory=dict, validate_default=True)]
    material: AnyMaterial
    counter_material: AnyMaterial | None = None
    counter_body: CounterBodySection | None = None
    impact: ImpactSection
    adhesion: AdhesionSection | None = None
    bounces: BouncesSection = BouncesSection()
    solver: SolverSection = SolverSection()
    uncertainty: UncertaintySection | None = None

    @model_validator(mode="after")
    def _check(self) -> CaseFile:
        if self.profile.needs_body_radius and self.body.radius is None:
            refuse("is missing; the profile takes its radius", "body.radius")
        if self.counter_body is not None:
            if self.profile.type != "parabola":
                refuse('two bodies touch as parabolas; give type = "parabola"', "profile.type", self.profile.type)
            if self.profile.on_layer:
                refuse("two free bodies touch without a layer; leave it out", "profile.thickness")
            if self.impact.weight:
                refuse("two free bodies fall alike; leave weight out", "impact.weight", True)
            if self.impact.material_of is not None:
                rule = "two free bodies are of [material] and of their own; leave it out"
                refuse(rule, "impact.material_of", self.impact.material_of)
            if self.impact.impedance is not None:
                refuse("is that of a target; a free body has its mass", "impact.impedance", self.impact.impedance)
            bodies = (self.counter_material, self.counter_body.material, self.counter_body.rigid or None)
            if sum(body is not None for body in bodies) > 1:
                refuse("give one of counter_material, counter_body.material and rigid = true", "counter_body")
        if self.profile.on_layer and self.impact.material_of == "body":
            refuse("the layer is of [material]; leave it out", "impact.material_of", "body")
        return self

    @property
    def partner(self) -> Any:
        """Section of the partner's material; None where it is rigid."""
        if self.counter_body is None or self.counter_material is not None:
            return self.counter_material
        return None if self.counter_body.rigid else self.counter_body.material or self.material

    @property
    def needs_window(self) -> bool:
        """Whether a material is fractional, and so holds for a window of time only."""
        return any(part is not None and part.needs_window for part in (self.material, self.partner))

    def build(self, window: Window | None = None) -> Impact:
        """Return the impact in SI; fractional models hold in the window, by default that of the contact."""
        if window is None and self.needs_window:
            return for_contact(self.build)
        mass, material = self.body.kilograms, self.material.build(window)
        counter: Material | None = None if self.partner is None else self.partner.build(window)
        force = mass * self.impact.gravity if self.impact.weight else _or(self.impact.external_force, 0.0)
        bodies, size = self.bodies(material, counter), self.impact.body_size
        adhesion = self.adhesion and self.adhesion.build()
        if bodies is not None:
            first = collision(*bodies, self.impact.impact_velocity, external_force=force)
            return replace(first, body_size=size, adhesion=adhesion, **self.impact.sliding)
        options: dict[str, Any] = {"external_force": force, "impedance": _or(self.impact.impedance, math.inf)}
        if self.impact.material_of == "body":
            options["diameters"] = BALL_ON_TARGET[::-1]
        profile = self.profile.build(self.body.radius)
        options |= {"counter_material": counter, "body_size": size, "adhesion": adhesion, **self.impact.sliding}
        return Impact(material, profile, mass, self.impact.impact_velocity, **options)

    def bodies(self, material: Material, counter: Material | None) -> tuple[Body, Body] | None:
        """Return the two free bodies, of these materials; None if the second is a half-space."""
        first, second = self.body, self.counter_body
        if second is None:
            return None
        other = Body(counter, _or(second.radius, math.inf), second.kilograms)
        return Body(material, _or(first.radius, math.inf), first.kilograms), other


def _or(value: Any, default: float) -> Any:
    return default if value is None else value


@dataclass(frozen=True)
class Case:
    """An impact as a case file describes it, in SI; `read_case` returns it.

    `options` are the keyword arguments of `solve`, `sections` the checked content of the file, `content` the one that
    it has. `deviations` are the standard deviations that stand behind values, as texts by the places of their keys.
    """

    path: Path
    title: str | None
    impact: Impact
    options: dict[str, Any]
    sections: CaseFile = field(repr=False)
    deviations: dict[str, str] = field(default_factory=dict[str, str], repr=False)
    content: dict[str, Any] = field(default_factory=dict[str, Any], repr=False)

    @property
    def states_deviations(self) -> bool:
        """Whether the file has standard deviations, behind values or in a section."""
        return bool(self.deviations) or self.sections.uncertainty is not None

    @property
    def arrangement(self) -> str:
        """The bodies in words."""
        profile, counter, second = self.sections.profile, self.impact.counter_material, self.sections.counter_body
        name = "the same material" if counter == self.impact.material else counter and counter.name
        partner = "rigid" if counter is None else f"of {name or 'another material'}"
        if second is not None:
            return f"two free bodies, the second {'a ball' if second.radius else 'flat'}, {partner}"
        target = "layer" if profile.on_layer else "half-space" if math.isinf(self.impact.impedance) else "plate or rod"
        target = "target with a force law" if profile.type == "force_law" else target
        soft = "target" if profile.on_layer else self.sections.impact.material_of
        if counter is None and soft is not None:
            return f"a rigid body on a {target}" if soft == "target" else f"a body on a rigid {target}"
        return f"a body on a {target}, {'one of the two rigid' if counter is None else f'the other one {partner}'}"

    def over(self, velocity: tuple[float, float]) -> Impact:
        """Return the impact, with fractional materials that hold for the contacts in a range of velocities [m/s]."""
        if not self.sections.needs_window:
            return self.impact
        return for_contact(lambda window: replace(self.sections.build(window), velocity=list(velocity)))

    def bodies(self, impact: Impact) -> tuple[Body, Body] | None:
        """Return the two bodies of an impact: balls, or a ball and a wall; None if they are something else.

        If only one of the ball and the wall deforms, it is the ball: the solution is the same.
        """
        material, counter = impact.material, impact.counter_material
        if self.sections.counter_body is not None:
            return self.sections.bodies(material, counter)
        if not isinstance(impact.profile, Parabola) or impact.external_force or math.isfinite(impact.impedance):
            return None
        ball, wall = (material, None) if counter is None else (counter, material)
        return Body(ball, impact.profile.radius, impact.mass), Body(wall)

    def solve(self) -> ImpactResult:
        """Solve the impact with the options of the file.

        A `CaseError` refuses an option of the file; a `SolverError` reports a solver that fails.
        """
        # The solver takes 0.3 s to import, which a faulty file need not wait for.
        from restitution.impact.solve import solve

        with in_file(self.path, **dict.fromkeys(self.options, "solver")):
            return solve(self.impact, **self.options)

    def bounces(self) -> Bounces:
        """Return the bounces of the body until it rests, under the gravity of the file.

        Its weight acts during contact too unless the file has `weight = false`. A velocity in the file is that of
        the first touch. A `CaseError` refuses a force other than the weight, a second body, or another method than
        "exact"; a `SolverError` reports a solver that fails.
        """
        from restitution.impact.bounces import bounces

        sections, motion = self.sections, self.sections.impact
        with in_file(self.path):
            if motion.external_force is not None:
                rule = "a body that bounces has its weight alone; give weight"
                refuse(rule, "impact.external_force", motion.external_force)
            if sections.counter_body is not None:
                refuse("a body bounces on a half-space; leave the section out", "counter_body")
            if sections.solver.method != "exact":
                refuse('bounces are solved by method = "exact"', "solver.method", sections.solver.method)
            if motion.weight is not False and motion.impedance is not None:
                rule = "must be false: the weight would drive a target with an impedance for ever"
                refuse(rule, "impact.weight", True)
        impact = self.impact
        if sections.needs_window:
            # What a touch leaves has the time of a flight to recover.
            impact = for_contact(sections.build, longest=2.0 * motion.impact_velocity / motion.gravity)
        options: dict[str, Any] = {} if sections.solver.rtol is None else {"rtol": sections.solver.rtol}
        with in_file(self.path, rtol="solver", min_height="bounces", height="impact"):
            return bounces(
                impact,
                height=motion.drop_height,
                gravity=motion.gravity,
                with_weight=motion.weight is not False,
                max_bounces=sections.bounces.max_bounces,
                min_height=sections.bounces.min_height,
                same_spot=sections.bounces.same_spot,
                **options,
            )

    def bands(self, result: ImpactResult) -> list[RestitutionBand]:
        """Return the bands of e of a result: over the relaxation beyond the data, over an assumed law of the shift."""
        from restitution.impact.band import band_of, restitution_band

        bands: list[RestitutionBand] = []
        if self.impact.adhesion is not None:
            return bands
        checks = [check for check in result.validity if check.kind == "window" and check.exceeded]
        if checks and (beyond := restitution_band(self.impact)) is not None:
            bands.append(beyond)
        if isinstance(self.sections.material, FileSection) and (materials := self.sections.material.by_constants()):
            # A partner of the same section is of the same material.
            alike = self.sections.partner is self.sections.material
            impacts = {"with universal constants": self.impact}
            for name, material in materials.items():
                counter = material if alike else self.impact.counter_material
                impacts[f"of {name}"] = replace(self.impact, material=material, counter_material=counter)
            bands.append(band_of(impacts, "over the constants of the shift"))
        return bands

    def notes(self, impact: Any, *, scattered: bool = False) -> list[str]:
        """Return remarks on the files of the materials, and assumptions about the materials of a solved impact.

        The last one is that standard deviations are left out, unless the outputs are `scattered` as well.
        """
        parts = (self.sections.material, self.sections.partner)
        remarks = [note for part in parts for note in getattr(part, "remarks", ())]
        left_out = [_LEFT_OUT] if self.states_deviations and not scattered else []
        return [*dict.fromkeys(remarks), *notes_on(impact.material, impact.counter_material), *left_out]


_LEFT_OUT = "the numbers are those of the values; `restitution solve` takes standard deviations to the outputs"


def notes_on(material: Material, counter: Material | None) -> list[str]:
    """Return what was assumed about materials, one line each."""
    pair = (material, counter) if counter != material else (material,)
    return [f"{each.name or 'material'}: {each.assumptions}" for each in pair if each and each.assumptions]


def read_case(path: str | Path, *, any_velocity: bool = False) -> Case:
    """Read a case file, in TOML: a quantity is a plain number in SI or a text with a unit such as "10 mm".

    Numbers of the impact may have a standard deviation, as in "10 +- 0.5 mm", which `restitution solve` takes to the
    outputs. With `any_velocity` the file may lack the velocity, which does not matter then.

    Raises
    ------
    CaseError
        If the file cannot be read or describes no impact: a line for each mistake, with the file, the key, its
        value and the rule.

    Examples
    --------
    >>> import tempfile
    >>> text = '''
    ... [body]
    ... mass = "5 g"
    ... radius = "10 mm"
    ... [material]
    ... equilibrium_modulus = "1 MPa"
    ... branch_modulus = "10 MPa"
    ... viscosity = "10 kPa s"
    ... poisson_ratio = 0.45
    ... [impact]
    ... velocity = "1 m/s"
    ... '''
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "ball.toml").write_text(text)
    ...     case = read_case(Path(folder, "ball.toml"))
    >>> case.impact.mass
    0.005
    """
    path = path_of(path)
    return case_of(read_toml(path), path, any_velocity=any_velocity)


def case_of(content: dict[str, Any], path: Path, *, any_velocity: bool = False) -> Case:
    """Return the case of the content of a file; other files that it names start in the folder of the path."""
    motion: Any = content.setdefault("impact", {}) if any_velocity else None
    if isinstance(motion, dict) and not {"velocity", "drop_height", "speed"} & set(motion):
        motion["velocity"] = 1.0
    plain = copy.deepcopy(content)
    with in_file(path):
        deviations = without_deviations(plain, UNCERTAIN)
    sections = read_sections(CaseFile, path, plain)
    with in_file(path):
        impact = sections.build()
    return Case(path, sections.title, impact, sections.solver.options, sections, deviations, content)
