"""The inputs of the explorer, made from the registries of quantities, material models and profiles.

The key of an input is a key path of a case file, such as `material.viscosity`. A few keys more choose between inputs.
A state is a flat table of inputs, which is a case file and back.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

import restitution as rs
from restitution import units
from restitution.case.indentation import IndentationCase, IndentationFile, read_indentation
from restitution.case.profile import sections as profile_sections
from restitution.case.section import CaseError, read_sections, read_toml
from restitution.contact.geometry import BALL_ON_TARGET, Geometry
from restitution.contact.profiles import sphere_mass
from restitution.errors import InputError, InputTypeError
from restitution.impact.scaling import viscosity_unit
from restitution.material.models import constants_of, material_models
from restitution.quantities import CONSTANTS, INPUTS, Quantity
from restitution.units import Dimension

MOST_TERMS = 50
"""Most terms of a Prony series; the time of a solve grows with them."""

# Values beyond the slider may be typed up to this factor, and numbers of a list up to the second one.
_BEYOND, _MOST = 1e6, 1e100

When = Mapping[str, Sequence[str]]
State = dict[str, Any]

_OF_IMPACTS = ("impact", "paper", "bounce")
_TABS_OF = {
    "material": (*_OF_IMPACTS, "indentation"), "body": _OF_IMPACTS, "impact": _OF_IMPACTS, "bounces": ("bounce",),
    "indentation": ("indentation",),
}  # fmt: skip


class Slider(NamedTuple):
    """Range of a slider; its step is in decades on a logarithmic scale, else in the unit of the quantity.

    The scale of the Poisson ratio, "poisson", is linear up to 0.4 and logarithmic in 0.5 - nu from there on, as a
    nearly incompressible material depends on 0.5 - nu.
    """

    low: float
    high: float
    default: float
    step: float = 0.02
    scale: str = "log"

    @property
    def logarithmic(self) -> bool:
        """Whether the scale has decades."""
        return self.scale == "log"


class Option(NamedTuple):
    """One value of a choice, available where each key of `when` has one of its values."""

    value: str
    words: str
    when: When = MappingProxyType({})


@dataclass(frozen=True)
class Input:
    """A number with a slider, a list of numbers, or a choice; shown where each key of `when` has one of its values."""

    key: str
    group: str
    words: str
    when: When = field(default_factory=dict)
    quantity: Quantity | None = None
    slider: Slider | None = None
    options: tuple[Option, ...] = ()

    @property
    def tabs(self) -> tuple[str, ...]:
        """Tabs of the page that have it."""
        further = ("indentation",) if self.key.startswith("profile.") else ()
        return _TABS_OF[self.group] + further

    @property
    def default(self) -> Any:
        """Value at the start."""
        if self.options:
            return self.options[0].value
        return self.slider.default if self.slider else []

    @property
    def ends(self) -> tuple[float, float]:
        """Least and greatest number that is accepted: far beyond the slider, within the range of the quantity."""
        assert self.quantity is not None
        if self.slider is None:
            return 0.0, _MOST
        if math.isinf(self.quantity.high):
            # Zero has no place on a logarithmic scale, and may be typed where the quantity has it.
            least = 0.0 if self.quantity.low == 0.0 and not self.quantity.open else self.slider.low / _BEYOND
            return least, self.slider.high * _BEYOND
        return max(self.quantity.low, self.slider.low), min(self.quantity.high, self.slider.high)

    def check(self, value: Any) -> Any:
        """Return a value of a state; refuse one of another type or out of range."""
        if self.options:
            names = [option.value for option in self.options]
            if str(value) not in names:
                raise InputError(self.key, value, f"must be one of {', '.join(names)}")
            return str(value)
        if self.slider is not None:
            return self._number(value)
        if not isinstance(value, list) or len(value) > MOST_TERMS:
            raise InputTypeError(self.key, value, f"must be a list of at most {MOST_TERMS} numbers")
        return [self._number(item) for item in value]

    def _number(self, value: Any) -> float:
        assert self.quantity is not None
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputTypeError(self.key, value, "must be a number", self.quantity.unit)
        low, high = self.ends
        # An integer may be too large for a float.
        if not low <= value <= high:
            raise InputError(self.key, value, f"must be in [{low:g}, {high:g}]", self.quantity.unit)
        return float(value)

    def describe(self) -> dict[str, Any]:
        """Return the input as JSON has it."""
        kind = "choice" if self.options else "number" if self.slider else "list"
        about = {"key": self.key, "type": kind, "words": self.words, "group": self.group, "default": self.default}
        about |= {"tabs": self.tabs, "when": dict(self.when)}
        if self.options:
            return about | {"options": [option._asdict() | {"when": dict(option.when)} for option in self.options]}
        assert self.quantity is not None
        about |= describe(self.quantity) | {"words": self.words}
        if self.slider is None:
            return about
        # Below a logarithmic slider there may be a place for zero.
        return about | self.slider._asdict() | {"least": self.ends[0], "default": self.default}


_LETTERS = {
    "alpha": "α", "nu": "ν", "eta": "η", "tau": "τ", "theta": "θ", "rho": "ρ", "zeta": "ζ", "omega": "ω",
    "delta": "δ", "infty": "∞", "tan": "tan ", "bar": "", "dot": "", "mathrm": "",
}  # fmt: skip


def describe(quantity: Quantity) -> dict[str, Any]:
    """Return words, plain symbol, dimension and unit of a quantity as JSON has them."""
    symbol = quantity.symbol.strip("$")
    for name, letter in _LETTERS.items():
        symbol = symbol.replace(f"\\{name}", letter)
    symbol = "".join(character for character in symbol if character not in "{}\\")
    dimension = quantity.dimension
    return {"words": quantity.words, "symbol": symbol, "dimension": dimension.name, "unit": dimension.unit}


_DATA: dict[str, Any] = tomllib.loads(files("restitution.explorer").joinpath("sliders.toml").read_text("utf-8"))
_BY_DIMENSION = {name: Slider(*row) for name, row in _DATA["dimensions"].items()}
_BY_KEY = {key: Slider(*row) for key, row in _DATA["inputs"].items()}
PRESETS: dict[str, tuple[str, State]] = {
    name: (preset["words"], preset["state"]) for name, preset in _DATA["presets"].items()
}
"""Words and state of each by name; the first is that of the defaults."""

_CONSTANTS_ENTRY: When = {"entry": ["constants"]}
_BULK = ("poisson_ratio", "bulk_modulus")
# A series has these terms too. E serves as well as G, and the accuracy of a fractional model is fixed.
_LEFT_OUT_MODELS = ("generalised_maxwell",)
_LEFT_OUT_CONSTANTS = ("youngs_modulus", "approximation_rtol", "bulk_viscosity")


def _number(key: str, group: str, quantity: Quantity, when: When | None = None, words: str = "") -> Input:
    slider = _BY_KEY.get(key) or _BY_DIMENSION.get(quantity.dimension.name, _BY_DIMENSION[units.NUMBER.name])
    return Input(key, group, words or quantity.words, when or {}, quantity, slider)


def _readable(name: str) -> str:
    words = name.replace("_", " ").replace("kelvin voigt", "Kelvin-Voigt").replace("maxwell", "Maxwell")
    words = words.replace("zener", "Zener").replace("dma", "DMA")
    return words[:1].upper() + words[1:]


def _models() -> dict[str, Any]:
    return {name: model for name, model in material_models().items() if name not in _LEFT_OUT_MODELS}


def _material_inputs() -> Iterator[Input]:
    models = _models()
    every = [(name, constant.quantity) for model in models.values() for name, constant in model.constants.items()]
    constants = dict(every) | dict(reversed(every))  # the order and the words of the first model
    first = "standard_solid"
    options = [Option(name, _readable(name), {} if name == first else _CONSTANTS_ENTRY) for name in models]
    library_option = Option("library", "From the library", _CONSTANTS_ENTRY)
    options += [library_option, Option("prony", "Prony series", _CONSTANTS_ENTRY)]
    yield Input("material.model", "material", "material", _CONSTANTS_ENTRY, options=tuple(options))

    names = rs.library.names()
    of_library = {"material.model": ["library"]}
    shifted = [name for name in names if rs.library.get(name).shift is not None]
    options = [Option(name, _readable(name)) for name in sorted(names, key=lambda name: name != "polyisobutylene")]
    yield Input("material.library", "material", "library material", of_library, options=tuple(options))
    yield _number(
        "material.temperature", "material", INPUTS["temperature"], of_library | {"material.library": shifted}
    )

    yield from _groups()
    for name, quantity in constants.items():
        if name in _LEFT_OUT_CONSTANTS or name in _BULK:
            continue
        having = [model.name for model in models.values() if name in model.constants]
        when: dict[str, Sequence[str]] = {"material.model": having}
        if name in ("branch_modulus", "viscosity"):
            when |= _CONSTANTS_ENTRY
        yield _number(f"material.{name}", "material", quantity, when)
    yield from _series("shear", "shear", {"material.model": ["prony"]})
    yield from _bulk_inputs(models)


def _groups() -> Iterator[Input]:
    quantities = {"nu": INPUTS["poisson_ratio"], "p2": INPUTS["p2"], "p3": INPUTS["p3"]}
    for name, quantity in quantities.items():
        yield _number(f"groups.{name}", "material", quantity, {"entry": ["groups"]})


def _series(part: str, words: str, when: When) -> Iterator[Input]:
    end, branches, times = (INPUTS[name] for name in ("equilibrium_modulus", "branch_moduli", "relaxation_times"))
    if part == "bulk":
        end, branches = (modulus._replace(symbol=modulus.symbol.replace("G", "K")) for modulus in (end, branches))
    yield _number(f"material.{part}.equilibrium_modulus", "material", end, when, f"equilibrium modulus in {words}")
    for quantity, what in ((branches, "moduli"), (times, "relaxation times")):
        key = f"material.{part}.{quantity.name}"
        yield Input(key, "material", f"{what} of the branches in {words}", when, quantity)
    key, quantity = f"material.{part}.parallel_viscosity", CONSTANTS["parallel_viscosity"]
    yield _number(key, "material", quantity, when, f"{quantity.words} in {words}")


def _bulk_inputs(models: Mapping[str, Any]) -> Iterator[Input]:
    """Yield what determines the change of volume."""
    # A liquid has no static Poisson ratio but 1/2.
    ends = {"equilibrium_modulus", "shear_modulus"}
    having = [model for model in models.values() if "poisson_ratio" in model.constants]
    solids = [*(model.name for model in having if ends & model.constants.keys()), "prony"]
    shown = [*models, "prony"]
    options = (
        Option("poisson_ratio", "Poisson ratio", {"material.model": solids}),
        Option("bulk_modulus", "bulk modulus", _CONSTANTS_ENTRY),
        Option("incompressible", "incompressible", _CONSTANTS_ENTRY),
        Option("series", "series in bulk", {"material.model": ["prony"], **_CONSTANTS_ENTRY}),
    )
    yield Input("bulk", "material", "volume", {"material.model": shown, **_CONSTANTS_ENTRY}, options=options)
    for name in _BULK:
        having = solids if name == "poisson_ratio" else shown
        when = {"bulk": [name], "material.model": having, **_CONSTANTS_ENTRY}
        yield _number(f"material.{name}", "material", INPUTS[name], when)
    yield from _series("bulk", "bulk", {"material.model": ["prony"], "bulk": ["series"]})
    words = "density of the half-space"
    yield _number("material.density", "material", INPUTS["density"], {"material.model": shown}, words)


def _body_inputs() -> Iterator[Input]:
    profiles = {name: section.geometry for name, section in profile_sections().items()}
    # Tables have no sliders.
    profiles = {
        name: profile
        for name, profile in profiles.items()
        if not any(constant.is_list for constant in constants_of(profile).values())
    }
    names = sorted(profiles, key=lambda name: name != "parabola")
    options = [Option(name, _readable(name), {} if name == "parabola" else _CONSTANTS_ENTRY) for name in names]
    round_bodies = [name for name, profile in profiles.items() if profile.body_radius]
    yield Input("profile.type", "body", "shape", options=tuple(options))
    constants: dict[str, Quantity] = {}
    having: dict[str, list[str]] = {}
    for name, profile in profiles.items():
        for key, constant in constants_of(profile).items():
            if key == "radius" and profile.body_radius:
                continue
            constants.setdefault(key, constant.quantity)
            having.setdefault(key, []).append(name)
    yield _number("body.radius", "body", INPUTS["radius"], {"profile.type": round_bodies})
    for key, quantity in constants.items():
        yield _number(f"profile.{key}", "body", quantity, {"profile.type": having[key]})
    sides = tuple(Option(number, number) for number in ("4", "3", "6"))
    yield Input("profile.sides", "body", "number of faces", {"profile.type": ["pyramid"]}, options=sides)
    options = [Option("mass", "mass"), Option("density", "density", {"profile.type": round_bodies})]
    yield Input("mass_from", "body", "mass from", options=tuple(options))
    yield _number("body.mass", "body", INPUTS["mass"], {"mass_from": ["mass"]})
    words = "density of the body"
    yield _number("body.density", "body", INPUTS["density"], {"mass_from": ["density"]}, words)
    yield _number("impact.velocity", "impact", INPUTS["velocity"])
    yield _number("impact.external_force", "impact", INPUTS["external_force"], _CONSTANTS_ENTRY)
    words = "smallest dimension of the target, 0 if unknown"
    yield _number("impact.body_size", "impact", Quantity("body_size", units.LENGTH, words, low=0.0, open=False))
    # It decides which one of the two radiates waves; the impact is the same.
    options = [Option("target", "the target"), Option("body", "the body")]
    yield Input("impact.material_of", "impact", "what deforms", options=tuple(options))
    yield _number("impact.gravity", "bounces", INPUTS["gravity"])
    yield from _indentation_inputs(round_bodies)


def _indentation_inputs(round_bodies: list[str]) -> Iterator[Input]:
    group = "indentation"
    words = "radius of the indenter"
    yield _number("indentation.radius", group, INPUTS["radius"], {"profile.type": round_bodies}, words)
    shapes = ("triangle", "hold", "ramp", "sine_arch")
    options = tuple(Option(name, _readable(name)) for name in shapes)
    yield Input("indentation.shape", group, "course over time", options=options)
    options = (Option("depth", "depth"), Option("force", "force"))
    yield Input("prescribed", group, "prescribed", options=options)

    def number(name: str, dimension: Dimension, words: str, when: When, *, positive: bool = True) -> Input:
        return _number(f"indentation.{name}", group, Quantity(name, dimension, words, low=0.0, open=positive), when)

    yield number("depth", units.LENGTH, "largest depth", {"prescribed": ["depth"]})
    yield number("force", units.FORCE, "largest force", {"prescribed": ["force"]})
    triangle, lasting = {"indentation.shape": ["triangle"]}, {"indentation.shape": ["hold", "ramp", "sine_arch"]}
    yield number("loading_time", units.TIME, "time of loading", triangle)
    yield number("hold_time", units.TIME, "time at the largest value", triangle, positive=False)
    yield number("unloading_time", units.TIME, "time of unloading", triangle)
    yield number("duration", units.TIME, "duration", lasting)
    yield number("rise_time", units.TIME, "time of the rise", {"indentation.shape": ["hold"]}, positive=False)


def drop_height() -> Input:
    """Return the height of the release: no key of a state, but another way to set the velocity on the page."""
    velocity, gravity = inputs()["impact.velocity"].slider, inputs()["impact.gravity"].slider
    assert velocity is not None
    assert gravity is not None
    low, high = (speed**2 / (2.0 * gravity.default) for speed in (velocity.low, velocity.high))
    quantity = Quantity("drop_height", units.LENGTH, "height of the release", "$h$", low=0.0, open=True)
    return Input("drop_height", "bounces", quantity.words, {}, quantity, Slider(low, high, low))


@cache
def inputs() -> dict[str, Input]:
    """Return all inputs by key, each after those on which it depends."""
    entries = (Option("constants", "constants of the material"), Option("groups", "the paper's numbers"))
    entry = Input("entry", "material", "described by", options=entries)
    return {control.key: control for control in (entry, *_material_inputs(), *_body_inputs())}


_PAGE, _SIDES, _INFINITE = "page.", "profile.sides", "incompressible"
# The body that deforms unless the case states it.
_SOFT = "target"
_NO_OTHER = "is not shown by the explorer, which has a rigid body on a half-space"


def checked(state: Mapping[str, Any]) -> State:
    """Return the checked values of a state; the page's own keys are dropped, and unknown ones are refused."""
    all_inputs, values = inputs(), {}
    for key, value in state.items():
        if key.startswith(_PAGE):
            continue
        if key not in all_inputs:
            raise InputError(key[:100], rule="is no input of the explorer")
        values[key] = all_inputs[key].check(value)
    return values


def settled(state: Mapping[str, Any]) -> State:
    """Return the values of all inputs that are shown in a state.

    A choice that is not available is replaced by the first one that is.
    """
    state_values, values = checked(state), {}
    for key, control in inputs().items():
        value = state_values.get(key, control.default)
        if control.options:
            available = [option.value for option in control.options if _holds(option.when, values)]
            value = value if value in available else available[0] if available else value
        # A choice that is hidden decides as well.
        if control.options or _holds(control.when, values):
            values[key] = value
    hidden = [key for key, control in inputs().items() if control.options and not _holds(control.when, values)]
    return {key: value for key, value in values.items() if key not in hidden or key in _DECIDING}


# Choices that the paper's numbers fix.
_DECIDING = ("material.model", "bulk")


def _holds(when: Mapping[str, Any], values: State) -> bool:
    return all(values.get(key) in choices for key, choices in when.items())


def nested(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table of key paths as tables within tables.

    >>> nested({"body.mass": 1.0, "body.radius": 2.0})
    {'body': {'mass': 1.0, 'radius': 2.0}}
    """
    content: dict[str, Any] = {}
    for key, value in values.items():
        *sections, name = key.split(".")
        table = content
        for section in sections:
            table = table.setdefault(section, {})
        table[name] = int(value) if key == _SIDES else value
    return content


def flat(content: Mapping[str, Any], prefix: str = "") -> State:
    """Return tables within tables as one table of key paths."""
    values: State = {}
    for key, value in content.items():
        values |= flat(value, f"{prefix}{key}.") if isinstance(value, Mapping) else {f"{prefix}{key}": value}
    return values


def case_content(state: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of the case file of an impact."""
    values = settled(state)
    content = {section: nested(values).get(section, {}) for section in ("body", "profile", "impact")}
    for key in ("external_force", "body_size"):
        if not content["impact"].get(key):
            content["impact"].pop(key, None)
    if content["impact"]["material_of"] == _SOFT:
        del content["impact"]["material_of"]
    return content | {"material": _material(values)}


def indentation_content(state: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of the case file of an indentation."""
    values = settled(state)
    content = nested(values)
    indentation, profile = content["indentation"], content["profile"]
    if "radius" in indentation:
        profile["radius"] = indentation.pop("radius")
    return {"profile": profile, "material": _material(values), "indentation": indentation}


def _material(values: State) -> dict[str, Any]:
    """Return the section of the material."""
    section: dict[str, Any] = nested(values)["material"]
    model, bulk = section.pop("model"), values["bulk"]
    if model not in ("library", "prony"):
        section["model"] = model
    if model != "library" and bulk == _INFINITE:
        section["bulk_modulus"] = math.inf
    if values["entry"] == "groups":
        section |= _from_groups(values)
    return section


def _from_groups(values: State) -> dict[str, float]:
    """Return the constants of the standard solid that the paper's three numbers determine."""
    modulus, radius = values["material.equilibrium_modulus"], values["body.radius"]
    mass = values["body.mass"] if "body.mass" in values else sphere_mass(values["body.density"], radius)
    unit = viscosity_unit(modulus, mass, values["impact.velocity"], radius)
    return {
        "branch_modulus": modulus / values["groups.p2"],
        "viscosity": values["groups.p3"] * float(unit),
        "poisson_ratio": values["groups.nu"],
    }


def of_file(path: Path) -> tuple[State, str | None]:
    """Return the state and the title of a case file of an impact or of an indentation."""
    content = read_toml(path)
    if "indentation" in content:
        sections = read_sections(IndentationFile, path, content)
        return of_indentation(read_indentation(path), sections), sections.title
    case = rs.read_case(path)
    return of_case(case), case.title


def of_case(case: rs.Case) -> State:
    """Return the state of a case file; refuse one that the page cannot show."""
    sections = case.sections
    extra = {key: getattr(sections, key) is not None for key in ("counter_material", "counter_body")}
    extra |= {"profile.thickness": sections.profile.on_layer, "impact.impedance": math.isfinite(case.impact.impedance)}
    for key in filter(extra.get, extra):
        raise InputError(key, rule=f"{_NO_OTHER}; leave it out")
    written: dict[str, Any] = sections.model_dump(include={"body", "profile", "material"}, exclude_none=True)
    values: State = {"impact.velocity": float(case.impact.velocity), "impact.gravity": sections.impact.gravity}
    values |= flat({"profile": written["profile"], "body": written["body"]})
    values["mass_from"] = "density" if "body.density" in values else "mass"
    values["impact.external_force"] = float(case.impact.external_force)
    values["impact.body_size"] = float(case.impact.body_size or 0.0)
    values["impact.material_of"] = sections.impact.material_of or _SOFT
    return values | _of_section(written["material"], lambda: case.impact.material)


def of_indentation(case: IndentationCase, sections: IndentationFile) -> State:
    """Return the state of the case file of an indentation; refuse one that the page cannot show."""
    indentation = sections.indentation
    extra = {
        "counter_material": case.counter_material is not None,
        "profile.thickness": sections.profile.on_layer,
        "indentation": indentation.shape is None,
    }
    rules = {"indentation": "must have a shape over time: the page shows no list of points"}
    for key in filter(extra.get, extra):
        raise InputError(key, rule=rules.get(key, f"{_NO_OTHER}; leave it out"))
    written: dict[str, Any] = sections.model_dump(include={"profile", "material", "indentation"}, exclude_none=True)
    profile, course = written["profile"], written["indentation"]
    course.pop("n_points", None)
    values = flat({"profile": profile, "indentation": course})
    if "profile.radius" in values and Geometry.registered[profile["type"]].body_radius:
        values["indentation.radius"] = values.pop("profile.radius")
    if indentation.shape == "triangle":
        values = {"indentation.unloading_time": course["loading_time"], "indentation.hold_time": 0.0} | values
    if indentation.shape == "hold":
        values.setdefault("indentation.rise_time", 0.0)
    values["prescribed"] = case.prescribed
    return values | _of_section(written["material"], lambda: case.material) | {"page.tab": "indentation"}


def _of_section(section: Mapping[str, Any], built: Callable[[], rs.Material]) -> State:
    """Return the state of the section of a material, or of the material if the page has not all of its keys."""
    material = flat({"material": section})
    infinite = material.get("material.bulk_modulus") == math.inf
    if infinite:
        del material["material.bulk_modulus"]
    material.pop("material.name", None)
    bulk = "bulk_modulus" if "material.bulk_modulus" in material else "poisson_ratio"
    form = "library" if "material.library" in material else material.get("material.model")
    state = material | {"material.model": form, "bulk": _INFINITE if infinite else bulk}
    if form is None or not material.keys() <= inputs().keys() or not material.keys() <= settled(state).keys():
        return of_material(built())
    return state


def of_impact(impact: rs.Impact) -> State:
    """Return the state of an impact; refuse one that the page cannot show."""
    if not isinstance(impact, rs.Impact):
        raise InputError("impact", rule="must be an Impact or the name of a case file")
    if impact.shape:
        raise InputError("impact", rule=f"must be a single impact, but has shape {impact.shape}")
    if impact.counter_material is not None or not math.isinf(impact.impedance):
        raise InputError("impact", rule=_NO_OTHER)
    names = {profile: name for name, profile in Geometry.registered.items()}
    kind = type(impact.profile)
    if kind not in names or names[kind] not in {option.value for option in inputs()["profile.type"].options}:
        raise InputError("impact", rule=f"has a profile that the explorer does not show: {kind.__name__}")
    values: State = {"profile.type": names[kind], "mass_from": "mass"}
    for name in constants_of(kind):
        key = "body.radius" if name == "radius" and kind.body_radius else f"profile.{name}"
        values[key] = float(getattr(impact.profile, name))
    if isinstance(impact.profile, rs.Pyramid):
        values[_SIDES] = impact.profile.sides
    for name in ("velocity", "external_force"):
        values[f"impact.{name}"] = float(getattr(impact, name))
    values["impact.body_size"] = float(impact.body_size or 0.0)
    values["impact.material_of"] = "body" if impact.diameters == BALL_ON_TARGET[::-1] else _SOFT
    return values | {"body.mass": float(impact.mass)} | of_material(impact.material)


def of_material(material: rs.Material) -> State:
    """Return the state of a material as a standard solid, or else as Prony series in shear and in bulk."""
    shear, bulk = material.shear, material.bulk
    solid = shear.n_branches == 1 and shear.equilibrium_modulus > 0.0 and shear.parallel_viscosity == 0.0
    if solid and (not isinstance(bulk, rs.PronySeries) or bulk.is_elastic):
        branch, duration = float(shear.branch_moduli[0]), float(shear.relaxation_times[0])
        constants = {"equilibrium_modulus": shear.equilibrium_modulus, "branch_modulus": branch}
        values: State = {f"material.{name}": value for name, value in constants.items()}
        values |= {"material.model": "standard_solid", "material.viscosity": branch * duration}
    else:
        values = {"material.model": "prony"} | _of_series("shear", shear)
    if material.density is not None:
        values["material.density"] = material.density
    if not isinstance(bulk, rs.PronySeries):
        return values | {"bulk": _INFINITE}
    if bulk.is_elastic:
        return values | {"bulk": "bulk_modulus", "material.bulk_modulus": bulk.equilibrium_modulus}
    return values | {"bulk": "series"} | _of_series("bulk", bulk)


def _of_series(part: str, series: rs.PronySeries) -> State:
    names = ("equilibrium_modulus", "branch_moduli", "relaxation_times", "parallel_viscosity")
    return {f"material.{part}.{name}": np.asarray(getattr(series, name)).tolist() for name in names}


def one_line(error: InputError) -> str:
    """Return an error as one line, the first one of several mistakes."""
    first = error.mistakes[0] if isinstance(error, CaseError) else error
    return " ".join(str(CaseError(first)).split())
