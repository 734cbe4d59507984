"""The inputs of the explorer, from the registries of quantities, material models and profiles.

The key of an input is a key path of a case file, such as `material.viscosity`. A few keys more choose between inputs.
A state is a flat table of inputs, which is a case file and back.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from importlib.resources import files
from operator import attrgetter
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

import restitution as rs
from restitution import units
from restitution.case.profile import sections as profile_sections
from restitution.case.section import CaseError
from restitution.contact.profiles import Profile, sphere_mass
from restitution.errors import InputError, InputTypeError
from restitution.impact.scaling import viscosity_unit
from restitution.material.models import Constant, constants_of, material_models
from restitution.quantities import ADHESION_INPUTS, CONSTANTS, INPUTS, Quantity
from restitution.units import Dimension

MOST_TERMS = 50
"""Most terms of a Prony series; the time of a solve grows with them."""

# Factors over the slider up to which values may be typed: of a single number, and of the numbers of a list.
_BEYOND, _MOST = 1e6, 1e100

When = Mapping[str, Sequence[str]]
State = dict[str, Any]

_ALWAYS: Mapping[str, Any] = MappingProxyType({})
HALF_SPACE, LAYER, PLATE, BALL = "half_space", "layer", "plate", "ball"
"""What the body hits."""
RIGID, SAME, OBLIQUE = "rigid", "same", "oblique"
"""Values of further choices: the material of the other body, where the body bounces, how it comes."""
SIDES, SPOT, NEAREST = "profile.sides", "bounces.spot", "tapping.nearest"
"""Keys that are no quantities of a case file, or choices of whole numbers."""
INFINITE, SOFT = "incompressible", "target"
"""The volume that does not change, and the body that deforms unless the case states it."""
_BASES = {"bonded": "sticks to its base", "frictionless": "slides on its base"}
_STRAIGHT, _NONE, _CYCLES, _MOST_CYCLES, _DISTANCES = "straight", "none", "indentation.count", 50.0, 21
_EDGED = ("flat_punch", "flat_ended_parabola", "truncated_cone")

_OF_IMPACTS, _OF_TIPS = ("impact", "paper", "bounce"), ("indentation", "tapping")
SAMPLE, HAMAKER, MODES = "sample", "tapping.hamaker", "tapping.beam_quality_factors"
"""Keys of inputs that a case file has in another place, or leaves out."""
# Numbers of the profile whose sliders have other ranges for tips than for bodies that hit.
_PROFILE_OF_TIPS = ("radius", "thickness", "base")
_KEYS_OF_TIPS = (SAMPLE, *(f"indentation.{name}" for name in _PROFILE_OF_TIPS))
_TABS_OF = {
    "material": (*_OF_IMPACTS, *_OF_TIPS), "body": _OF_IMPACTS, "target": _OF_IMPACTS, "impact": _OF_IMPACTS,
    "bounces": ("bounce",), "indentation": ("indentation",), "tapping": ("tapping",),
}  # fmt: skip
# The group of an input is the section of its key, but for these keys and sections.
_GROUPS = {
    "entry": "material", "groups": "material", "bulk": "material", "profile": "body", "mass_from": "body",
    "counter_body": "target", "partner": "target", "profile.thickness": "target", "profile.base": "target",
    "impact.impedance": "target", "motion": "impact", "sticking": "impact", "adhesion": "impact",
    "impact.gravity": "bounces", "drop_height": "bounces",
    "prescribed": "indentation", "indentation.radius": "body",
    SAMPLE: "target", "indentation.thickness": "target", "indentation.base": "target",
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
    when: When = _ALWAYS


class Input(NamedTuple):
    """A number with a slider, a list of numbers, or a choice; shown where each key of `when` has one of its values."""

    key: str
    words: str
    when: When = _ALWAYS
    quantity: Quantity | None = None
    slider: Slider | None = None
    options: tuple[Option, ...] = ()

    @property
    def group(self) -> str:
        """Group of the page that has it."""
        section = self.key.partition(".")[0]
        return _GROUPS.get(self.key) or _GROUPS.get(section, section)

    @property
    def tabs(self) -> tuple[str, ...]:
        """Tabs of the page that have it."""
        if self.key in _KEYS_OF_TIPS:
            return _OF_TIPS
        return _TABS_OF[self.group] + (_OF_TIPS if self.key.startswith("profile.") and self.group == "body" else ())

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
        if math.isinf(self.quantity.low):
            return self.slider.low * _BEYOND, self.slider.high * _BEYOND
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
            rule = f"must be in [{low:g}, {high:g}] {self.quantity.unit}".rstrip()
            raise InputError(self.key, value, rule, self.quantity.unit)
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
    "alpha": "α", "nu": "ν", "phi": "φ", "eta": "η", "tau": "τ", "theta": "θ", "rho": "ρ", "zeta": "ζ", "omega": "ω",
    "delta": "δ", "sigma": "σ", "infty": "∞", "tan": "tan ", "bar": "", "dot": "", "mathrm": "",
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


def _number(key: str, quantity: Quantity, when: When = _ALWAYS, words: str = "") -> Input:
    slider = _BY_KEY.get(key) or _BY_DIMENSION.get(quantity.dimension.name, _BY_DIMENSION[units.NUMBER.name])
    return Input(key, words or quantity.words, when, quantity, slider)


def _choice(
    key: str, words: str, options: Mapping[str, str], when: When = _ALWAYS, only: Mapping[str, When] = _ALWAYS
) -> Input:
    """Return a choice between options with their words, some of them available `only` under a condition."""
    listed = tuple(Option(value, text, only.get(value, _ALWAYS)) for value, text in options.items())
    return Input(key, words, when, options=listed)


def _readable(name: str) -> str:
    words = name.replace("_", " ").replace("kelvin voigt", "Kelvin-Voigt").replace("maxwell", "Maxwell")
    words = words.replace("zener", "Zener").replace("dma", "DMA")
    return words[:1].upper() + words[1:]


def _named(names: Iterable[str], first: str = "") -> dict[str, str]:
    """Return readable words by name, one of the names first."""
    return {name: _readable(name) for name in sorted(names, key=lambda name: name != first)}


def _owned(constants: Mapping[str, Mapping[str, Constant]]) -> dict[str, tuple[Quantity, list[str]]]:
    """Return the quantity of each constant of models, in the words of the first model, and the models that have it."""
    owned: dict[str, tuple[Quantity, list[str]]] = {}
    for model, of_model in constants.items():
        for name, constant in of_model.items():
            owned.setdefault(name, (constant.quantity, []))[1].append(model)
    return owned


def _material_inputs() -> Iterator[Input]:
    models = {name: model.constants for name, model in material_models().items() if name not in _LEFT_OUT_MODELS}
    kinds = {name: _readable(name) for name in models} | {"library": "From the library", "prony": "Prony series"}
    only = dict.fromkeys(kinds, _CONSTANTS_ENTRY) | {"standard_solid": _ALWAYS}
    yield _choice("material.model", "material", kinds, _CONSTANTS_ENTRY, only)
    of_library, library = {"material.model": ["library"]}, rs.library.names()
    yield _choice("material.library", "library material", _named(library, "polyisobutylene"), of_library)
    shifted = [name for name in library if rs.library.get(name).shift is not None]
    yield _number("material.temperature", INPUTS["temperature"], of_library | {"material.library": shifted})
    for name, quantity in {"nu": "poisson_ratio", "p2": "p2", "p3": "p3"}.items():
        yield _number(f"groups.{name}", INPUTS[quantity], {"entry": ["groups"]})
    for name, (quantity, having) in _owned(models).items():
        if name not in (*_LEFT_OUT_CONSTANTS, *_BULK):
            fixed = _CONSTANTS_ENTRY if name in ("branch_modulus", "viscosity") else {}
            yield _number(f"material.{name}", quantity, {"material.model": having, **fixed})
    yield from _series("shear", {"material.model": ["prony"]})
    yield from _bulk_inputs(models)


def _series(part: str, when: When) -> Iterator[Input]:
    end, branches, times = (INPUTS[name] for name in ("equilibrium_modulus", "branch_moduli", "relaxation_times"))
    if part == "bulk":
        end, branches = (modulus._replace(symbol=modulus.symbol.replace("G", "K")) for modulus in (end, branches))
    yield _number(f"material.{part}.equilibrium_modulus", end, when, f"equilibrium modulus in {part}")
    for quantity, what in ((branches, "moduli"), (times, "relaxation times")):
        yield Input(f"material.{part}.{quantity.name}", f"{what} of the branches in {part}", when, quantity)
    quantity = CONSTANTS["parallel_viscosity"]
    yield _number(f"material.{part}.parallel_viscosity", quantity, when, f"{quantity.words} in {part}")


def _bulk_inputs(models: Mapping[str, Mapping[str, Constant]]) -> Iterator[Input]:
    """Yield what determines the change of volume."""
    # A liquid has no static Poisson ratio but 1/2.
    ends = {"equilibrium_modulus", "shear_modulus"}
    solids = [name for name, constants in models.items() if "poisson_ratio" in constants and ends & constants.keys()]
    having = {"poisson_ratio": [*solids, "prony"], "bulk_modulus": [*models, "prony"]}
    words = {
        "poisson_ratio": "Poisson ratio", "bulk_modulus": "bulk modulus", "incompressible": "incompressible",
        "series": "series in bulk",
    }  # fmt: skip
    only: dict[str, When] = dict.fromkeys(words, _CONSTANTS_ENTRY)
    only |= {"poisson_ratio": {"material.model": having["poisson_ratio"]}}
    only |= {"series": {"material.model": ["prony"], **_CONSTANTS_ENTRY}}
    shown = {"material.model": having["bulk_modulus"]}
    yield _choice("bulk", "volume", words, {**shown, **_CONSTANTS_ENTRY}, only)
    for name in _BULK:
        yield _number(
            f"material.{name}", INPUTS[name], {"bulk": [name], "material.model": having[name], **_CONSTANTS_ENTRY}
        )
    yield from _series("bulk", {"material.model": ["prony"], "bulk": ["series"]})
    yield _number("material.density", INPUTS["density"], shown, "density of the half-space")


def _body_inputs() -> Iterator[Input]:
    profiles = {name: section.geometry for name, section in profile_sections().items()}
    constants = {name: constants_of(profile) for name, profile in profiles.items()}
    # Tables have no sliders.
    constants = {name: row for name, row in constants.items() if not any(map(attrgetter("is_list"), row.values()))}
    only = dict.fromkeys(constants, _CONSTANTS_ENTRY) | {"parabola": _ALWAYS}
    yield _choice("profile.type", "shape", _named(constants, "parabola"), only=only)
    of_round = {"profile.type": [name for name in constants if profiles[name].body_radius]}
    yield _number("body.radius", INPUTS["radius"], of_round)
    for name in of_round["profile.type"]:
        constants[name] = {key: constant for key, constant in constants[name].items() if key != "radius"}
    for key, (quantity, having) in _owned(constants).items():
        yield _number(f"profile.{key}", quantity, {"profile.type": having})
    sides = {number: number for number in ("4", "3", "6")}
    yield _choice("profile.sides", "number of faces", sides, {"profile.type": ["pyramid"]})
    yield _choice("mass_from", "mass from", {"mass": "mass", "density": "density"}, only={"density": of_round})
    yield _number("body.mass", INPUTS["mass"], {"mass_from": ["mass"]})
    yield _number("body.density", INPUTS["density"], {"mass_from": ["density"]}, "density of the body")
    has_theory = [name for name in constants if issubclass(profiles[name], Profile)]
    yield from _target_inputs(has_theory)
    yield _number("impact.velocity", INPUTS["velocity"])
    words = {_STRAIGHT: "straight down", OBLIQUE: "at an angle, with friction"}
    unmoved = {"target": [HALF_SPACE, BALL], "profile.type": has_theory, **_CONSTANTS_ENTRY}
    yield _choice("motion", "the body comes", words, only={OBLIQUE: unmoved})
    oblique = {"motion": [OBLIQUE]}
    yield _number("impact.friction", INPUTS["friction"], oblique)
    yield _number("impact.angle", INPUTS["angle"], oblique)
    of_ball = {"profile.type": ["parabola", "sphere"], "target": [HALF_SPACE]}
    yield _number("impact.spin", INPUTS["spin"], oblique | of_ball)
    # The front of an adhesive contact has no theory at a face or an edge.
    smooth = [name for name in has_theory if name not in _EDGED]
    apart = {"motion": [_STRAIGHT], "target": [HALF_SPACE, BALL], "profile.type": smooth, **_CONSTANTS_ENTRY}
    words = {_NONE: "do not adhere", "stress": "adhere with a stress", "range": "adhere over a range"}
    yield _choice("sticking", "the surfaces", words, only={"stress": apart, "range": apart})
    yield _number("adhesion.work", ADHESION_INPUTS["work"], {"sticking": ["stress", "range"]})
    for name in ("stress", "range"):
        yield _number(f"adhesion.{name}", ADHESION_INPUTS[name], {"sticking": [name]})
    held = {"target": [HALF_SPACE, LAYER, BALL], **_CONSTANTS_ENTRY}
    yield _number("impact.external_force", INPUTS["external_force"], held)
    words = "smallest dimension of the target, 0 if unknown"
    yield _number("impact.body_size", Quantity("body_size", units.LENGTH, words, low=0.0, open=False))
    # It decides which one of the two radiates waves; the impact is the same.
    words = {"target": "the target", "body": "the body"}
    yield _choice("impact.material_of", "the material is that of", words, {"target": [HALF_SPACE, PLATE]})
    yield _number("impact.gravity", INPUTS["gravity"])
    words = {"fresh": "on a fresh surface", SAME: "on the same spot"}
    yield _choice(SPOT, "each bounce", words, only={SAME: {"motion": [_STRAIGHT]}})
    yield from _indentation_inputs(of_round, has_theory)


def _target_inputs(has_theory: Sequence[str]) -> Iterator[Input]:
    """Yield what the body hits, and the material of the other body."""
    words = {
        HALF_SPACE: "a half-space", LAYER: "a layer on a rigid base", PLATE: "a plate or rod that recedes",
        BALL: "a free ball at rest",
    }  # fmt: skip
    only: dict[str, When] = {
        LAYER: {"profile.type": has_theory, **_CONSTANTS_ENTRY}, PLATE: _CONSTANTS_ENTRY,
        BALL: {"profile.type": ["parabola"], **_CONSTANTS_ENTRY},
    }  # fmt: skip
    yield _choice("target", "the body hits", words, only=only)
    of_layer, of_ball = {"target": [LAYER]}, {"target": [BALL]}
    yield _number("profile.thickness", INPUTS["thickness"], of_layer)
    yield _choice("profile.base", "the layer", _BASES, of_layer)
    yield _number("impact.impedance", INPUTS["impedance"], {"target": [PLATE]})
    yield _number("counter_body.radius", INPUTS["radius"], of_ball, "radius of the second ball")
    yield _number("counter_body.mass", INPUTS["mass"], of_ball, "mass of the second ball")
    words = {RIGID: "rigid", SAME: "of the same material"} | _named(rs.library.names())
    only = dict.fromkeys(words, _CONSTANTS_ENTRY) | {RIGID: _ALWAYS}
    yield _choice("partner", "the other body is", words, {"target": [HALF_SPACE, PLATE, BALL]}, only)


def _indentation_inputs(of_round: When, has_theory: Sequence[str]) -> Iterator[Input]:
    yield _number("indentation.radius", INPUTS["radius"], of_round, "radius of the tip")
    words = {HALF_SPACE: "a half-space", LAYER: "a layer on a rigid base"}
    yield _choice(SAMPLE, "the tip presses on", words, only={LAYER: {"profile.type": has_theory}})
    of_layer = {SAMPLE: [LAYER]}
    yield _number("indentation.thickness", INPUTS["thickness"], of_layer)
    yield _choice("indentation.base", "the layer", _BASES, of_layer)
    shapes = ("triangle", "cycles", "hold", "ramp", "sine_arch")
    yield _choice("prescribed", "prescribed", {"depth": "depth", "force": "force"})
    words = {shape: _readable(shape) for shape in shapes}
    yield _choice("indentation.shape", "course over time", words, only={"cycles": {"prescribed": ["depth"]}})

    def number(name: str, dimension: Dimension, words: str, when: When, *, positive: bool = True) -> Input:
        return _number(f"indentation.{name}", Quantity(name, dimension, words, low=0.0, open=positive), when)

    yield number("depth", units.LENGTH, "largest depth", {"prescribed": ["depth"]})
    yield number("force", units.FORCE, "largest force", {"prescribed": ["force"]})
    triangle, lasting = {"indentation.shape": ["triangle"]}, {"indentation.shape": ["hold", "ramp", "sine_arch"]}
    cyclic, both = {"indentation.shape": ["cycles"]}, {"indentation.shape": ["triangle", "cycles"]}
    yield number("loading_time", units.TIME, "time of loading", both)
    yield number("hold_time", units.TIME, "time at the largest value", triangle, positive=False)
    yield number("unloading_time", units.TIME, "time of unloading", both)
    yield _number(_CYCLES, Quantity("count", units.NUMBER, "number of cycles", low=1.0, high=_MOST_CYCLES), cyclic)
    valley = Quantity("valley", units.NUMBER, "lowest over largest value between cycles", low=0.0, high=1.0)
    yield _number("indentation.valley", valley, cyclic)
    yield number("duration", units.TIME, "duration", lasting)
    yield number("rise_time", units.TIME, "time of the rise", {"indentation.shape": ["hold"]}, positive=False)
    yield from _tapping_inputs()


def _tapping_inputs() -> Iterator[Input]:
    for name, dimension, words in (
        ("spring_constant", units.STIFFNESS, "spring constant of the cantilever"),
        ("quality_factor", units.NUMBER, "quality factor"),
        ("frequency", units.FREQUENCY, "frequency of the drive, that of the resonance"),
        ("free_amplitude", units.LENGTH, "amplitude without a surface"),
    ):
        low = 0.5 if name == "quality_factor" else 0.0
        yield _number(f"tapping.{name}", Quantity(name, dimension, words, low=low, open=True))
    words = "smallest distance over that amplitude"
    yield _number(NEAREST, Quantity("nearest", units.NUMBER, words, low=-1.0, high=0.99))
    words = "Hamaker constant of the van der Waals force"
    # The force is that of a ball before a plane.
    round_tip = {"profile.type": ["parabola", "sphere"], SAMPLE: [HALF_SPACE]}
    yield _number(HAMAKER, Quantity("hamaker", units.ENERGY, words, "$H$", low=0.0, open=False), round_tip)
    words = "quality factors of the second mode, the third, ... of a beam"
    yield Input(MODES, words, quantity=Quantity("beam_quality_factors", units.NUMBER, words, "$Q_2$", low=0.0))


def drop_height() -> Input:
    """Return the height of the release: no key of a state, but another way to set the velocity on the page."""
    velocity, gravity = inputs()["impact.velocity"].slider, inputs()["impact.gravity"].slider
    assert velocity is not None
    assert gravity is not None
    low, high = (speed**2 / (2.0 * gravity.default) for speed in (velocity.low, velocity.high))
    quantity = Quantity("drop_height", units.LENGTH, "height of the release", "$h$", low=0.0, open=True)
    return Input("drop_height", quantity.words, _ALWAYS, quantity, Slider(low, high, low))


@cache
def inputs() -> dict[str, Input]:
    """Return all inputs by key, each after those on which it depends."""
    entry = _choice(
        "entry", "described by", {"constants": "constants of the material", "groups": "the paper's numbers"}
    )
    return {control.key: control for control in (entry, *_material_inputs(), *_body_inputs())}


_PAGE = "page."
# Choices that the paper's numbers fix; they decide where they are hidden, too.
_DECIDING = ("material.model", "bulk")


def settled(state: Mapping[str, Any]) -> State:
    """Return the checked values of all inputs that are shown in a state.

    The page's own keys are dropped, and unknown ones are refused. A choice that is not available is replaced by the
    first one that is.
    """
    checked = {key: value for key, value in state.items() if not key.startswith(_PAGE)}
    for key, value in checked.items():
        if key not in inputs():
            raise InputError(key[:100], rule="is no input of the explorer")
        checked[key] = inputs()[key].check(value)
    values: State = {}
    for key, control in inputs().items():
        value = checked.get(key, control.default)
        if control.options:
            available = [option.value for option in control.options if _holds(option.when, values)]
            values[key] = value if value in available or not available else available[0]
        elif _holds(control.when, values):
            values[key] = value
    # The conditions of a choice are those of all values, which follow in the order of the inputs.
    return {
        key: value
        for key, value in values.items()
        if key in _DECIDING or not inputs()[key].options or _holds(inputs()[key].when, values)
    }


def _holds(when: When, values: State) -> bool:
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
        table[name] = int(value) if key in (SIDES, _CYCLES) else value
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
    tables, material = nested(values), _material(values)
    content = {section: tables.get(section, {}) for section in ("body", "profile", "impact")}
    if "adhesion" in tables:
        content["adhesion"] = tables["adhesion"]
    for key in ("external_force", "body_size"):
        if not content["impact"].get(key):
            content["impact"].pop(key, None)
    if content["impact"].get("material_of") == SOFT:
        del content["impact"]["material_of"]
    partner = values.get("partner", RIGID)
    if values["target"] == BALL:
        content["counter_body"] = tables["counter_body"] | ({"rigid": True} if partner == RIGID else {})
    if partner not in (RIGID, SAME):
        content["counter_material"] = {"library": partner}
    elif partner == SAME and values["target"] != BALL:
        content["counter_material"] = material
    if values[SPOT] == SAME:
        content["bounces"] = {"same_spot": True}
    return content | {"material": material}


def indentation_content(state: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of the case file of an indentation."""
    values = settled(state)
    of_tips = {key: value for key, value in values.items() if key in _KEYS_OF_TIPS or inputs()[key].group != "target"}
    content = nested(of_tips)
    indentation, profile = content["indentation"], content["profile"]
    profile |= {name: indentation.pop(name) for name in _PROFILE_OF_TIPS if name in indentation}
    return {"profile": profile, "material": _material(values), "indentation": indentation}


def tapping_content(state: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of the case file of tapping, over distances from the free amplitude down."""
    content = indentation_content(state)
    tapping = nested(settled(state))["tapping"]
    shares = np.linspace(1.0, tapping.pop("nearest"), _DISTANCES)
    tapping["distance"] = (tapping["free_amplitude"] * shares).tolist()
    for key in (HAMAKER, MODES):
        name = key.partition(".")[2]
        if not tapping.get(name):
            tapping.pop(name, None)
    return {"profile": content["profile"], "material": content["material"], "tapping": tapping}


def _material(values: State) -> dict[str, Any]:
    """Return the section of the material."""
    section: dict[str, Any] = nested(values)["material"]
    model, bulk = section.pop("model"), values["bulk"]
    if model not in ("library", "prony"):
        section["model"] = model
    if model != "library" and bulk == INFINITE:
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


def one_line(error: InputError) -> str:
    """Return an error as one line, which is that of the first mistake."""
    first = error.mistakes[0] if isinstance(error, CaseError) else error
    return " ".join(str(CaseError(first)).split())
