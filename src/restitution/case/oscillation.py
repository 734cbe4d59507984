"""Case files of oscillating indentations and of tapping."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, StrictInt, model_validator

from restitution.case.axes import WAVES, read_wave_axes
from restitution.case.impact import AccuracySection
from restitution.case.indentation import IndenterCase, IndenterFile, bodies_of
from restitution.case.quantity import LIST, nonnegative, positive, within
from restitution.case.section import Section, in_file, read_sections, read_toml, refuse
from restitution.impact.problem import Impact
from restitution.impact.window import window_around
from restitution.indentation.cantilever import MOST_MODES, CantileverMode, beam_modes
from restitution.indentation.history import MOST_CYCLES
from restitution.quantities import FORCE, LENGTH, NUMBER, TIME
from restitution.units import ENERGY, FREQUENCY, STIFFNESS
from restitution.variation import vary

if TYPE_CHECKING:
    from restitution.indentation.oscillation import Oscillation, OscillationArray
    from restitution.indentation.tapping import Tapping

_ANY = (-1e300, 1e300)
Frequency = Annotated[float, positive(FREQUENCY, "frequency of the drive")]


class OscillationSection(Section):
    """The mean and the amplitude of a prescribed depth or force, and the frequency."""

    depth: Annotated[float, positive(LENGTH, "mean of the depth")] | None = None
    amplitude: Annotated[float, positive(LENGTH, "amplitude of the depth")] | None = None
    force: Annotated[float, positive(FORCE, "mean of the force, in place of the depth")] | None = None
    force_amplitude: Annotated[float, positive(FORCE, "amplitude of the force")] | None = None
    frequency: Frequency
    cycles: Annotated[
        StrictInt | None,
        Field(ge=1, le=MOST_CYCLES, description="number of cycles; the last one counts; by default the steady state"),
    ] = None
    rise_time: (
        Annotated[float, positive(TIME, "duration of the ramp before the cycles; a period by default")] | None
    ) = None
    hold_time: Annotated[float, nonnegative(TIME, "time at the mean before the cycles; 0 by default")] | None = None

    @model_validator(mode="after")
    def _check(self) -> OscillationSection:
        name = self.one_of("depth", "force")
        swing, other = ("amplitude", "force_amplitude") if name == "depth" else ("force_amplitude", "amplitude")
        self.refuse_present(f"belongs to another mean than {name}, whose amplitude is {swing}", other)
        self.one_of(swing, other)
        return self

    @property
    def options(self) -> dict[str, Any]:
        """Keyword arguments of `oscillate`."""
        swing = {"amplitude": self.amplitude if self.force is None else self.force_amplitude}
        return self.values(("depth", "force", "frequency", "cycles", "rise_time", "hold_time")) | swing


class ModeSection(Section):
    """A higher mode of the cantilever."""

    spring_constant: Annotated[float, positive(STIFFNESS, "stiffness of the mode at the tip")]
    frequency: Annotated[float, positive(FREQUENCY, "undamped resonance of the mode")]
    quality_factor: Annotated[float, within(NUMBER, 0.5, 1e12, "quality factor of the mode")]


class TappingSection(Section):
    """The cantilever, its drive and the distances."""

    distance: Annotated[
        list[Annotated[float, within(LENGTH, *_ANY, "distances of the resting tip from the surface")]],
        LIST,
    ]
    spring_constant: Annotated[float, positive(STIFFNESS, "spring constant of the cantilever")]
    quality_factor: Annotated[float, within(NUMBER, 0.5, 1e12, "quality factor of the cantilever")]
    frequency: Frequency
    free_amplitude: Annotated[float, positive(LENGTH, "amplitude without a surface")] | None = None
    drive: Annotated[float, positive(FORCE, "force of the drive, in place of the free amplitude")] | None = None
    resonance_frequency: (
        Annotated[float, positive(FREQUENCY, "undamped resonance of the cantilever; that of the drive by default")]
        | None
    ) = None
    hamaker: (
        Annotated[float, positive(ENERGY, "Hamaker constant of tip and surface; no such force by default")] | None
    ) = None
    intermolecular_distance: (
        Annotated[float, positive(LENGTH, "distance of their atoms in contact; 0.165 nm by default")] | None
    ) = None
    modes: Annotated[list[ModeSection] | None, Field(description="higher modes of the cantilever, a table each")] = (
        None
    )
    beam_quality_factors: (
        Annotated[
            list[Annotated[float, within(NUMBER, 0.5, 1e12, "quality factors of the higher modes of a beam")]],
            LIST,
        ]
        | None
    ) = None
    max_taps: Annotated[StrictInt, Field(ge=4, description="largest number of taps at a distance")] = 1000

    @model_validator(mode="after")
    def _check(self) -> TappingSection:
        self.one_of("free_amplitude", "drive")
        if not self.distance:
            refuse("must have at least one distance", "distance")
        if self.modes is not None:
            self.refuse_present("belongs to a beam; leave it or modes out", "beam_quality_factors")
        if self.beam_quality_factors is not None and not 1 <= len(self.beam_quality_factors) <= MOST_MODES:
            refuse(f"must be a list of 1 to {MOST_MODES} quality factors", "beam_quality_factors")
        return self

    @property
    def options(self) -> dict[str, Any]:
        """Keyword arguments of `tap`."""
        options = self.values(name for name in type(self).model_fields if name != "beam_quality_factors")
        if self.modes is not None:
            options["modes"] = tuple(CantileverMode(**mode.model_dump()) for mode in self.modes)
        if self.beam_quality_factors is not None:
            resonance = self.frequency if self.resonance_frequency is None else self.resonance_frequency
            options["modes"] = beam_modes(
                spring_constant=self.spring_constant, frequency=resonance, quality_factors=self.beam_quality_factors
            )
        return options


class OscillationFile(IndenterFile):
    """A whole case file of an oscillating indentation."""

    oscillation: OscillationSection
    solver: AccuracySection = AccuracySection()


class TappingFile(IndenterFile):
    """A whole case file of tapping."""

    tapping: TappingSection
    solver: AccuracySection = AccuracySection()


@dataclass(frozen=True)
class OscillationCase(IndenterCase):
    """An oscillating indentation as a case file describes it, in SI."""

    options: dict[str, Any]  # keyword arguments of `oscillate`

    def solve(self) -> Oscillation | OscillationArray:
        """Solve the oscillation, or each point of its axes."""
        # The solver takes a while to import, which a faulty file need not wait for.
        from restitution.indentation.oscillation import oscillate

        with in_file(self.path, "oscillation", rtol="solver"):
            return oscillate(self.material, self.profile, counter_material=self.counter_material, **self.options)

    def over(self, axes: dict[str, Any]) -> OscillationCase:
        """Return the case over axes, DataArrays by the names of their numbers."""
        numbers = {name: values for name, values in axes.items() if name in WAVES}
        if "force_amplitude" in numbers:
            numbers["amplitude"] = numbers.pop("force_amplitude").rename(force_amplitude="amplitude")
        materials = {name: values for name, values in axes.items() if name not in WAVES}
        material = self.material
        if materials:
            # The material of an impact has numbers by name.
            impact = Impact(material, self.profile, mass=1.0, velocity=1.0, counter_material=self.counter_material)
            with in_file(self.path, "axes"):
                material = vary(impact, materials).material
        return replace(self, material=material, options=self.options | numbers)


@dataclass(frozen=True)
class TappingCase(IndenterCase):
    """Tapping as a case file describes it, in SI."""

    options: dict[str, Any]  # keyword arguments of `tap`

    def solve(self, progress: Callable[[int, int], None] | None = None) -> Tapping:
        """Solve the taps over the distances."""
        from restitution.indentation.tapping import tap

        bodies = {"counter_material": self.counter_material, "progress": progress}
        with in_file(self.path, "tapping", rtol="solver"):
            return tap(self.material, self.profile, **bodies, **self.options)


def read_oscillation(path: str | Path) -> OscillationCase:
    """Read a TOML file of oscillating indentations; a `CaseError` has a line for each mistake.

    Examples
    --------
    >>> import tempfile
    >>> text = '''
    ... [profile]
    ... radius = "2.5 um"
    ... [material]
    ... library = "polyisobutylene"
    ... [oscillation]
    ... depth = "50 nm"
    ... amplitude = "5 nm"
    ... frequency = "10 Hz"
    ... '''
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "wave.toml").write_text(text)
    ...     case = read_oscillation(Path(folder, "wave.toml"))
    >>> print(case.options["frequency"], case.options["amplitude"])
    10.0 5e-09
    """
    path = Path(path)
    content = read_toml(path)
    axes = read_wave_axes(path, content.pop("axes")) if "axes" in content else {}
    section = content.setdefault("oscillation", {})
    if isinstance(section, dict):
        with in_file(path):
            for name in filter(axes.__contains__, section):
                refuse("stands in [axes] too; leave one of the two out", f"oscillation.{name}")
        # The section is complete with one point of the axes.
        section |= {name: float(values[0]) for name, values in axes.items() if name in WAVES}
    file = read_sections(OscillationFile, path, content)
    section, period = file.oscillation, 1.0 / file.oscillation.frequency
    longest = (section.rise_time or period) + (section.hold_time or 0.0) + (section.cycles or 1) * period
    window = window_around(period)._replace(high=2.0 * longest)
    case = OscillationCase(*bodies_of(file, path, window), section.options | file.solver.options)
    return case.over(axes) if axes else case


def read_tapping(path: str | Path) -> TappingCase:
    """Read a TOML file of tapping; a `CaseError` has a line for each mistake.

    Examples
    --------
    >>> import tempfile
    >>> text = '''
    ... [profile]
    ... radius = "10 nm"
    ... [material]
    ... library = "polyisobutylene"
    ... [tapping]
    ... distance = "[300, 200] nm"
    ... spring_constant = "5.8 N/m"
    ... quality_factor = 167
    ... frequency = "45 kHz"
    ... free_amplitude = "350 nm"
    ... '''
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "tap.toml").write_text(text)
    ...     case = read_tapping(Path(folder, "tap.toml"))
    >>> print(case.options["frequency"], case.options["distance"])
    45000.0 [3e-07, 2e-07]
    """
    path = Path(path)
    file = read_sections(TappingFile, path, read_toml(path))
    section = file.tapping
    window = window_around(1.0 / section.frequency)
    options = section.options | file.solver.options
    return TappingCase(*bodies_of(file, path, window), options)
