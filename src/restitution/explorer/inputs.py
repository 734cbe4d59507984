"""The inputs of the explorer, made from the registries of quantities, material models and profiles.

The key of an input is a key path of a case file, such as `material.viscosity`. A few keys more choose between inputs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from types import MappingProxyType
from typing import Any, NamedTuple

from restitution.case.profile import sections as profile_sections
from restitution.errors import InputError, InputTypeError
from restitution.material import library
from restitution.material.models import constants_of, material_models
from restitution.paper.computation import LOG_P2_RANGE, LOG_P3_RANGE
from restitution.quantities import (
    ACCELERATION,
    ANGLE,
    CONSTANTS,
    DENSITY,
    FORCE,
    INPUTS,
    LENGTH,
    MASS,
    MODULUS,
    NUMBER,
    TEMPERATURE,
    TIME,
    VELOCITY,
    VISCOSITY,
    Dimension,
    Quantity,
)

MOST_TERMS = 50
"""Most terms of a Prony series; the time of a solve grows with them."""

# Values beyond the slider may be typed up to this factor, and numbers of a list up to the second one.
_BEYOND, _MOST = 1e6, 1e100

When = Mapping[str, Sequence[str]]


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
            if str(value) not in [one.value for one in self.options]:
                raise InputError(self.key, value, f"must be one of {', '.join(one.value for one in self.options)}")
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
        about |= {"when": {key: list(values) for key, values in self.when.items()}}
        if self.options:
            options = [one._asdict() | {"when": {k: list(v) for k, v in one.when.items()}} for one in self.options]
            return about | {"options": options}
        assert self.quantity is not None
        least, most = self.ends
        about |= describe(self.quantity) | {"words": self.words, "least": least, "most": most}
        if self.slider is None:
            return about | {"most_items": MOST_TERMS}
        slider = self.slider
        return about | {"scale": slider.scale, "low": slider.low, "high": slider.high, "step": slider.step}


_LETTERS = {
    "alpha": "α", "nu": "ν", "eta": "η", "tau": "τ", "theta": "θ", "rho": "ρ", "zeta": "ζ", "omega": "ω",
    "delta": "δ", "infty": "∞", "tan": "tan ", "bar": "", "dot": "", "mathrm": "",
}  # fmt: skip


def describe(quantity: Quantity) -> dict[str, Any]:
    """Return words, plain symbol, dimension and unit of a quantity as JSON has them."""
    symbol = quantity.symbol.strip("$")
    for name, letter in _LETTERS.items():
        symbol = symbol.replace(f"\\{name}", letter)
    symbol = "".join(one for one in symbol if one not in "{}\\")
    dimension = quantity.dimension
    return {"words": quantity.words, "symbol": symbol, "dimension": dimension.name, "unit": dimension.unit}


_BY_DIMENSION: dict[Dimension, Slider] = {
    MODULUS: Slider(1e2, 1e12, 1e7),
    VISCOSITY: Slider(1e-2, 1e12, 3e3),
    TIME: Slider(1e-7, 1e4, 1e-3),
    LENGTH: Slider(1e-5, 1.0, 2e-3),
    MASS: Slider(1e-9, 1e2, 0.033),
    DENSITY: Slider(1e1, 2e4, 1100.0),
    VELOCITY: Slider(1e-3, 1e1, 0.3),
    ACCELERATION: Slider(0.1, 30.0, 9.80665, 0.1, "linear"),
    FORCE: Slider(1e-12, 1e3, 1e-8),
    ANGLE: Slider(0.1, 1.5, 1.2, 0.01, "linear"),
    TEMPERATURE: Slider(200.0, 450.0, 298.15, 1.0, "linear"),
    NUMBER: Slider(1e-3, 1e3, 1.0),
}
_BY_KEY: dict[str, Slider] = {
    "material.branch_modulus": Slider(1e2, 1e12, 1e8),
    "material.poisson_ratio": Slider(-1.0, 0.5, 0.49, 0.01, "poisson"),
    "material.bulk_modulus": Slider(1e2, 1e13, 2e9),
    "material.coefficient": Slider(1e2, 1e12, 1e6),
    "material.exponent": Slider(0.05, 0.95, 0.2, 0.01, "linear"),
    "material.shear.parallel_viscosity": Slider(1e-6, 1e12, 0.0),
    "material.bulk.parallel_viscosity": Slider(1e-6, 1e12, 0.0),
    "groups.nu": Slider(-1.0, 0.5, 0.45, 0.01, "poisson"),
    "groups.p2": Slider(10.0 ** LOG_P2_RANGE[0], 10.0 ** LOG_P2_RANGE[1], 0.1),
    "groups.p3": Slider(10.0 ** LOG_P3_RANGE[0], 10.0 ** LOG_P3_RANGE[1], 1.0),
    "body.radius": Slider(1e-5, 1.0, 1e-2),
    "body.density": Slider(1e1, 2e4, 7850.0),
    "profile.exponent": Slider(0.5, 10.0, 2.0, 0.1, "linear"),
    "profile.coefficient": Slider(1e-3, 1e9, 50.0),
    "impact.external_force": Slider(0.0, 10.0, 0.0, 0.01, "linear"),
    "indentation.radius": Slider(1e-8, 1e-2, 2.5e-6),
    "indentation.depth": Slider(1e-9, 1e-2, 5e-7),
    "impact.body_size": Slider(1e-4, 1e1, 0.0),
    "indentation.loading_time": Slider(1e-6, 1e4, 1e-4),
    "indentation.unloading_time": Slider(1e-6, 1e4, 1e-4),
    "indentation.hold_time": Slider(1e-4, 1e4, 0.0),
    "indentation.duration": Slider(1e-4, 1e4, 1.0),
    "indentation.rise_time": Slider(1e-4, 1e4, 0.1),
}

_CONSTANTS_ENTRY: When = {"entry": ["constants"]}
_BULK = ("poisson_ratio", "bulk_modulus")
# A series has these terms too. E serves as well as G, and the accuracy of a fractional model is fixed.
_LEFT_OUT_MODELS = ("generalised_maxwell",)
_LEFT_OUT_CONSTANTS = ("youngs_modulus", "approximation_rtol", "bulk_viscosity")


def _number(key: str, group: str, quantity: Quantity, when: When | None = None, words: str = "") -> Input:
    slider = _BY_KEY.get(key) or _BY_DIMENSION.get(quantity.dimension, _BY_DIMENSION[NUMBER])
    return Input(key, group, words or quantity.words, when or {}, quantity, slider)


def _readable(name: str) -> str:
    words = name.replace("_", " ").replace("kelvin voigt", "Kelvin-Voigt").replace("maxwell", "Maxwell")
    words = words.replace("zener", "Zener").replace("dma", "DMA")
    return words[:1].upper() + words[1:]


def _models() -> dict[str, Any]:
    return {name: one for name, one in material_models().items() if name not in _LEFT_OUT_MODELS}


def _material_inputs() -> Iterator[Input]:
    models = _models()
    every = [(name, one.quantity) for model in models.values() for name, one in model.constants.items()]
    constants = dict(every) | dict(reversed(every))  # the order and the words of the first model
    first = "standard_solid"
    options = [Option(name, _readable(name), {} if name == first else _CONSTANTS_ENTRY) for name in models]
    library_option = Option("library", "From the library", _CONSTANTS_ENTRY)
    options += [library_option, Option("prony", "Prony series", _CONSTANTS_ENTRY)]
    yield Input("material.model", "material", "material", _CONSTANTS_ENTRY, options=tuple(options))

    names = library.names()
    of_library = {"material.model": ["library"]}
    shifted = [name for name in names if library.get(name).shift is not None]
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
        end, branches = (one._replace(symbol=one.symbol.replace("G", "K")) for one in (end, branches))
    yield _number(f"material.{part}.equilibrium_modulus", "material", end, when, f"equilibrium modulus in {words}")
    for quantity, what in ((branches, "moduli"), (times, "relaxation times")):
        key = f"material.{part}.{quantity.name}"
        yield Input(key, "material", f"{what} of the branches in {words}", when, quantity)
    key, quantity = f"material.{part}.parallel_viscosity", CONSTANTS["parallel_viscosity"]
    yield _number(key, "material", quantity, when, f"{quantity.words} in {words}")


def _bulk_inputs(models: Mapping[str, Any]) -> Iterator[Input]:
    """What determines the change of volume."""
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
    tables = [name for name, one in profiles.items() if any(key.is_list for key in constants_of(one).values())]
    profiles = {name: one for name, one in profiles.items() if name not in tables}
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
    yield _number("impact.body_size", "impact", Quantity("body_size", LENGTH, words, low=0.0, open=False))
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

    yield number("depth", LENGTH, "largest depth", {"prescribed": ["depth"]})
    yield number("force", FORCE, "largest force", {"prescribed": ["force"]})
    triangle, lasting = {"indentation.shape": ["triangle"]}, {"indentation.shape": ["hold", "ramp", "sine_arch"]}
    yield number("loading_time", TIME, "time of loading", triangle)
    yield number("hold_time", TIME, "time at the largest value", triangle, positive=False)
    yield number("unloading_time", TIME, "time of unloading", triangle)
    yield number("duration", TIME, "duration", lasting)
    yield number("rise_time", TIME, "time of the rise", {"indentation.shape": ["hold"]}, positive=False)


@cache
def inputs() -> dict[str, Input]:
    """All inputs by key, each after those on which it depends."""
    entries = (Option("constants", "constants of the material"), Option("groups", "the paper's numbers"))
    entry = Input("entry", "material", "described by", options=entries)
    return {one.key: one for one in (entry, *_material_inputs(), *_body_inputs())}
