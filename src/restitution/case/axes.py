"""The axes of a sweep file: which keys of the case vary, over which values."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from restitution.case.impact import CaseFile
from restitution.case.section import CaseError, in_file, key_path, split_list
from restitution.checks import finite, whole
from restitution.contact.geometry import Geometry
from restitution.contact.layer.layer import Layer
from restitution.errors import InputError
from restitution.material.models import constants_of, material_models
from restitution.quantities import (
    ADHESION_INPUTS,
    ALIASES,
    CONSTANTS,
    INPUTS,
    MEASURED,
    SLIDING,
    Quantity,
    advice,
    key_of,
)
from restitution.sweeps.grid import Linear, Logarithmic, LogNormal, LogUniform, Normal, Samples, Uniform
from restitution.units import to_si

# Name of the dimension of random draws.
_DRAWS = "sample"

# Keys that are clear without their section.
_SHORT = {
    **dict.fromkeys(("velocity", "drop_height", "gravity", "external_force", "impedance"), "impact."),
    **dict.fromkeys((*SLIDING, "angle", "speed"), "impact."),
    **dict.fromkeys(("mass", "density", "radius"), "body."),
    "thickness": "profile.",
    **dict.fromkeys(ADHESION_INPUTS, "adhesion."),
    **dict.fromkeys(("poisson_ratio", "bulk_modulus", "equilibrium_modulus", "branch_modulus"), "material."),
    **dict.fromkeys(("viscosity", "relaxation_time", "temperature"), "material."),
    **dict.fromkeys(("p2", "p3"), ""),
}
SHORT_NAMES = (*_SHORT, *ALIASES)
"""Keys that an axis may have without their section."""
WAVES = {
    "depth": "depth", "amplitude": "depth_amplitude", "force": "mean_force", "force_amplitude": "force_amplitude",
    "frequency": "frequency",
}  # fmt: skip
"""Quantities of the keys of `[oscillation]` that may be axes."""
_SECTIONS = ("body", "profile", "material", "counter_material", "counter_body", "impact", "adhesion")
_AXES: dict[str, Callable[..., Any]] = {kind.__name__.lower(): kind for kind in (Linear, Logarithmic)}
_KINDS = (Uniform, LogUniform, Normal, LogNormal)
_DISTRIBUTIONS: dict[str, Callable[..., Any]] = {kind.__name__.lower(): kind for kind in _KINDS}


def read_axes(path: Path, axes: Any, samples: Any) -> dict[str, Any]:
    """Return the axes of the sections [axes] and [samples] by name of the quantity, as `restitution.sweep` takes them.

    The random draws have the name of their dimension. A `CaseError` has a line for each mistake.
    """
    for section, content in (("axes", axes), ("samples", samples)):
        if content is not None and not isinstance(content, dict):
            raise CaseError(InputError(section, content, "must be a table"), where=path)
    if not axes and not samples:
        missing = "the section is missing; it lists what varies, e.g. velocity = [0.1, 1.0]"
        raise CaseError(InputError("axes", rule=missing), where=path)
    read: dict[str, Any] = {}
    mistakes: list[InputError] = []
    for keys, spec in _leaves(axes or {}, (*_AXES, "n")):
        field = key_path(["axes", *keys])
        try:
            name = quantity_name(field, keys)
            if name in read:
                raise InputError("axes", rule=f"{place_of(name)} is there twice")
            read[name] = read_axis(field, name, spec)
        except InputError as error:
            mistakes.append(error)
    if mistakes:
        raise CaseError(*mistakes, where=path)
    if samples:
        with in_file(path):
            read[_DRAWS] = _samples(dict(samples))
    return read


def read_wave_axes(path: Path, content: Any) -> dict[str, Any]:
    """Return the axes of an oscillation, DataArrays by key: of `[oscillation]`, and of numbers of the material.

    A `CaseError` has a line for each mistake.
    """
    import xarray as xr

    if not isinstance(content, dict) or not content:
        rule = "must be a table of what varies, e.g. frequency = { logarithmic = [1.0, 100.0], n = 20 }"
        raise CaseError(InputError("axes", content, rule), where=path)
    read: dict[str, Any] = {}
    mistakes: list[InputError] = []
    for keys, spec in _leaves(content, (*_AXES, "n")):
        field, key = key_path(["axes", *keys]), keys[-1]
        of_wave = key in WAVES and keys in ((key,), ("oscillation", key))
        try:
            name = WAVES[key] if of_wave else quantity_name(field, keys)
            if not of_wave and not place_of(name).startswith("material."):
                rule = f"must be a number of the material, or one of {', '.join(WAVES)}"
                raise InputError(field, rule=rule)
            values = read_axis(field, name, spec)
            numbers = values.values(0, values.size) if isinstance(values, Linear) else finite(field, values)
            quantity = quantity_of(name)
            coordinate = (key, np.atleast_1d(numbers), {} if quantity is None else quantity.attributes)
            if key in read:
                raise InputError("axes", rule=f"{key} is there twice")
            read[key if of_wave else name] = xr.DataArray(coordinate[1], {key: coordinate}, (key,))
        except InputError as error:
            mistakes.append(error)
    if mistakes:
        raise CaseError(*mistakes, where=path)
    return read


def quantity_name(field: str, keys: tuple[str, ...]) -> str:
    """Return the name of the quantity of a key: that of the key where this is clear without its section.

    Examples
    --------
    >>> quantity_name("", ("impact", "velocity")), quantity_name("", ("nu",)), quantity_name("", ("profile", "radius"))
    ('velocity', 'poisson_ratio', 'profile.radius')
    """
    *section, key = keys
    if section:
        _known(field, section[0], _SECTIONS)
        return key if _SHORT.get(key) == f"{'.'.join(section)}." else ".".join(keys)
    _known(field, key, (*SHORT_NAMES, *_SECTIONS))
    return ALIASES.get(key, key)


def place_of(name: str) -> str:
    """Return where the key of a quantity stands, given its name.

    Examples
    --------
    >>> place_of("velocity"), place_of("profile.half_angle")
    ('impact.velocity', 'profile.half_angle')
    """
    return _SHORT.get(name, "") + name


def quantity_of(name: str) -> Quantity | None:
    """Return the quantity of a key such as `material.shear.relaxation_times[2]`; None if it has none."""
    return _quantities().get(key_of(name))


def _quantities() -> dict[str, Quantity]:
    """Return the quantities by the name of their key: of all geometries and material models, and of the registry."""
    owners = (*Geometry.registered.values(), Layer, *(model.build for model in material_models().values()))
    constants = {name: each.quantity for owner in owners for name, each in constants_of(owner).items()}
    shear = CONSTANTS["shear_modulus"]
    waves = {name: MEASURED[name] for name in WAVES.values()}
    return constants | CONSTANTS | INPUTS | waves | {"bulk": INPUTS["bulk_modulus"], "shear": shear}


def value_in_si(field: str, name: str, value: Any) -> Any:
    """Return a number in SI if the key has a quantity, anything else as it stands."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        try:
            return float(value)
        except OverflowError:
            rule = "must be a number that a double can hold"
            raise InputError(field, "a number of very many digits", rule) from None
    quantity = quantity_of(name)
    if not isinstance(value, str) or quantity is None:
        return value
    if value == "incompressible":
        return math.inf if quantity.infinite and name.endswith("bulk_modulus") else value
    try:
        return to_si(value, quantity.dimension)
    except InputError as error:
        raise InputError(field, value, error.rule) from None


def read_axis(field: str, name: str, spec: Any) -> Any:
    """Return the axis of a key, or its list or single value; `field` names it in messages."""
    spec = _listed(spec)
    if isinstance(spec, list):
        if not spec:
            raise InputError(field, rule="must hold at least one value")
        return [_admissible(f"{field}[{i}]", name, value_in_si(field, name, value)) for i, value in enumerate(spec)]
    if not isinstance(spec, dict):
        return _admissible(field, name, value_in_si(field, name, spec))
    for key in spec:
        _known(f"{field}.{key}", key, (*_AXES, "n"), "unknown key")
    kind = next((name for name in _AXES if name in spec), None)
    if kind is None or set(spec) != {kind, "n"}:
        raise InputError(field, rule=f"must be a value, a list, or a table with n and one of {', '.join(_AXES)}")
    low, high = (_admissible(field, name, number(field, name, end)) for end in _pair(field, kind, spec[kind]))
    return _new(field, _AXES[kind], low, high, spec["n"])


def _admissible(field: str, name: str, value: Any) -> Any:
    """Return a value of an axis, refusing a number outside the range of its quantity."""
    quantity = INPUTS.get(key_of(name))
    return quantity.check(value, field) if quantity is not None and isinstance(value, float) else value


def _leaves(content: Mapping[str, Any], kinds: Iterable[str], *above: str) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield the keys and values of nested tables, such as `impact.velocity = {...}`."""
    for name, value in content.items():
        within = above or name in CaseFile.model_fields or name == "oscillation"
        if isinstance(value, dict) and within and not set(value) & set(kinds):
            yield from _leaves(value, kinds, *above, name)
        else:
            yield (*above, name), value


def _samples(content: dict[str, Any]) -> Samples:
    options = {name: content.pop(name) for name in ("n", "method", "seed") if name in content}
    if "n" not in options:
        raise InputError("samples.n", rule="is missing; it is the number of draws")
    drawn: dict[str, Any] = {}
    for keys, spec in _leaves(content, _DISTRIBUTIONS):
        field = key_path(["samples", *keys])
        name = quantity_name(field, keys)
        drawn[name] = distribution(field, name, spec)
    rng = _new("samples", whole, "seed", options.pop("seed", 0), 0)
    return _new("samples", Samples, options.pop("n"), drawn, rng=rng, **options)


def distribution(field: str, name: str, spec: Any) -> Any:
    """Return the distribution of a table such as `{ normal = ["5 g", "0.1 g"] }`."""
    kind = next((name for name in _DISTRIBUTIONS if isinstance(spec, dict) and name in spec), None)
    if kind is None or len(spec) != 1:
        raise InputError(field, rule=f"must be a table with one of {', '.join(_DISTRIBUTIONS)}")
    first, second = _pair(field, kind, spec[kind])
    # The scatter of a logarithm has no unit.
    other = "p2" if kind == "lognormal" else name
    return _new(field, _DISTRIBUTIONS[kind], number(field, name, first), number(field, other, second))


def _new(field: str, kind: Callable[..., Any], *numbers: Any, **options: Any) -> Any:
    try:
        return kind(*numbers, **options)
    except InputError as error:
        raise error.within(field) from None


def _listed(spec: Any) -> Any:
    return split_list(spec) if isinstance(spec, str) and spec.lstrip().startswith("[") else spec


def _pair(field: str, kind: str, pair: Any) -> tuple[Any, Any]:
    pair = _listed(pair)
    if not isinstance(pair, list) or len(pair) != 2:
        raise InputError(f"{field}.{kind}", pair, "must be a list of two values")
    return pair[0], pair[1]


def number(field: str, name: str, entry: Any) -> float:
    """Return a number in SI from a number, or from a text with a unit of the key's quantity."""
    value = value_in_si(field, name, entry)
    if not isinstance(value, float):
        if isinstance(entry, str) and quantity_of(name) is None:
            _known(field, name.rpartition(".")[2], _quantities())
        raise InputError(field, entry, "must be a number in SI")
    return value


def _known(field: str, name: str, choices: Iterable[str], what: str = "unknown quantity") -> None:
    if name not in (names := list(choices)):
        raise InputError(field, rule=f"{what}; {advice(name, names)}")
