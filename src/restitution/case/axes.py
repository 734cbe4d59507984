"""The axes of a sweep file: which keys of the case vary, over which values."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from restitution.case.quantity import (
    ACCELERATION,
    DENSITY,
    FORCE,
    LENGTH,
    MASS,
    MODULUS,
    NUMBER,
    TIME,
    VELOCITY,
    VISCOSITY,
    Kind,
    to_si,
)
from restitution.case.schema import CaseFile
from restitution.case.section import CaseError, key_path, toml_value
from restitution.sweeps.axis import Linear, Logarithmic
from restitution.sweeps.distribution import LogNormal, LogUniform, Normal, Uniform
from restitution.sweeps.samples import Samples
from restitution.sweeps.schema import ALIASES

DRAWS = "sample"
"""Name of the dimension of random draws."""

_TEMPERATURE = Kind("temperature", "K", "20 degC")
_KINDS = {
    "velocity": VELOCITY, "drop_height": LENGTH, "gravity": ACCELERATION, "mass": MASS, "density": DENSITY,
    "radius": LENGTH, "external_force": FORCE, "half_angle": NUMBER, "temperature": _TEMPERATURE,
    "poisson_ratio": NUMBER, "bulk_modulus": MODULUS, "bulk": MODULUS, "shear": MODULUS,
    "equilibrium_modulus": MODULUS, "instantaneous_modulus": MODULUS, "branch_modulus": MODULUS,
    "branch_moduli": MODULUS, "viscosity": VISCOSITY, "relaxation_time": TIME, "relaxation_times": TIME,
    "p2": NUMBER, "p3": NUMBER,
}  # fmt: skip

# Keys that are clear without their section.
_SHORT = {
    **{name: f"impact.{name}" for name in ("velocity", "drop_height", "gravity", "external_force")},
    **{name: f"body.{name}" for name in ("mass", "density", "radius")},
    **{
        name: f"material.{name}"
        for name in (
            "poisson_ratio", "bulk_modulus", "equilibrium_modulus", "branch_modulus", "viscosity",
            "relaxation_time", "temperature",
        )
    },
    "p2": "p2",
    "p3": "p3",
}  # fmt: skip

_SECTIONS = ("body", "profile", "material", "counter_material", "impact")

_AXES: dict[str, Callable[..., Any]] = {"linear": Linear, "logarithmic": Logarithmic}
_DISTRIBUTIONS: dict[str, Callable[..., Any]] = {
    "uniform": Uniform, "loguniform": LogUniform, "normal": Normal, "lognormal": LogNormal,
}  # fmt: skip


def read_axes(path: Path, axes: Any, samples: Any) -> dict[str, Any]:
    """Read the sections [axes] and [samples].

    Parameters
    ----------
    path : Path
        The file, for messages.
    axes, samples : dict or None
        Their content.

    Returns
    -------
    dict
        By place of the key, such as `impact.velocity`: `Linear`, `Logarithmic`, a list, or one value. Under
        `DRAWS`: `Samples`, by places of keys too.

    Raises
    ------
    CaseError
        In one line.
    """
    for section, content in (("axes", axes), ("samples", samples)):
        if content is not None and not isinstance(content, dict):
            raise CaseError(f"{path}: {section} = {toml_value(content)}: must be a table")
    if not axes and not samples:
        raise CaseError(f"{path}: axes: the section is missing; it says what varies")
    made: dict[str, Any] = {}
    for keys, spec in _leaves(axes or {}, (*_AXES, "n")):
        where = f"{path}: {key_path(['axes', *keys])}"
        place = known_place(where, keys)
        if place in made:
            raise CaseError(f"{path}: axes: {place} is there twice")
        made[place] = read_axis(where, place, spec)
    if samples:
        made[DRAWS] = _samples(path, dict(samples))
    return made


def full_place(keys: tuple[str, ...]) -> str:
    """Return where a key stands, given its place or, if it is a common one, its name alone.

    Examples
    --------
    >>> full_place(("velocity",)), full_place(("nu",)), full_place(("profile", "radius"))
    ('impact.velocity', 'material.poisson_ratio', 'profile.radius')
    """
    if len(keys) == 1:
        return _SHORT.get(ALIASES.get(keys[0], keys[0]), keys[0])
    return ".".join(keys)


def known_place(where: str, keys: tuple[str, ...]) -> str:
    """Return where a key stands, as `full_place` does; refuse a name alone that is none.

    Raises
    ------
    CaseError
        In one line, which `where` begins.
    """
    if len(keys) == 1 and keys[0] not in (known := (*_SHORT, *ALIASES, *_SECTIONS)):
        raise CaseError(f"{where}: unknown quantity; {_advice(keys[0], known)}")
    return full_place(keys)


def value_in_si(where: str, place: str, given: Any) -> Any:
    """Return a number in SI where the quantity is known, anything else as it stands."""
    if isinstance(given, int | float) and not isinstance(given, bool):
        return float(given)
    key = place.rpartition(".")[2].partition("[")[0]
    if given == "incompressible" and key == "bulk_modulus":
        return math.inf
    kind = _KINDS.get(key)
    if isinstance(given, str) and kind is not None and given != "incompressible":
        try:
            return to_si(given, kind)
        except ValueError as error:
            raise CaseError(f"{where} = {toml_value(given)}: {error}") from None
    return given


def _leaves(
    content: Mapping[str, Any], kinds: Iterable[str], *above: str
) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield what stands at the ends of nested tables, such as `impact.velocity = {...}`."""
    for name, value in content.items():
        within = above or name in CaseFile.model_fields
        if isinstance(value, dict) and within and not set(value) & set(kinds):
            yield from _leaves(value, kinds, *above, name)
        else:
            yield (*above, name), value


def _samples(path: Path, content: dict[str, Any]) -> Samples:
    options = {name: content.pop(name) for name in ("n", "method", "seed") if name in content}
    if "n" not in options:
        raise CaseError(f"{path}: samples.n: is missing; it is the number of draws")
    drawn: dict[str, Any] = {}
    for keys, spec in _leaves(content, _DISTRIBUTIONS):
        where = f"{path}: {key_path(['samples', *keys])}"
        place = known_place(where, keys)
        kind = next((name for name in _DISTRIBUTIONS if isinstance(spec, dict) and name in spec), None)
        if kind is None or len(spec) != 1:
            raise CaseError(f"{where}: must be a table with one of {', '.join(_DISTRIBUTIONS)}")
        first, second = _pair(where, kind, spec[kind])
        # The scatter of a logarithm has no unit.
        other = "p2" if kind == "lognormal" else place
        drawn[place] = _made(
            where, _DISTRIBUTIONS[kind], _number(where, place, first), _number(where, other, second)
        )
    return _made(f"{path}: samples", Samples, options.pop("n"), drawn, **options)


def read_axis(where: str, place: str, spec: Any) -> Any:
    """Read one axis.

    Parameters
    ----------
    where : str
        What messages begin with.
    place : str
        Place of the key that varies.
    spec : object
        What is given: a value, a list, or a table.

    Returns
    -------
    object
        `Linear`, `Logarithmic`, a list, or one value.

    Raises
    ------
    CaseError
        In one line.
    """
    if isinstance(spec, list):
        if not spec:
            raise CaseError(f"{where}: must hold at least one value")
        return [value_in_si(where, place, item) for item in spec]
    if not isinstance(spec, dict):
        return value_in_si(where, place, spec)
    keys = (*_AXES, "n")
    if (unknown := next((key for key in spec if key not in keys), None)) is not None:
        raise CaseError(f"{where}.{unknown}: unknown key; {_advice(unknown, keys)}")
    kind = next((name for name in _AXES if name in spec), None)
    if kind is None or set(spec) != {kind, "n"}:
        raise CaseError(f"{where}: must be a value, a list, or a table with n and one of {', '.join(_AXES)}")
    low, high = (_number(where, place, end) for end in _pair(where, kind, spec[kind]))
    return _made(where, _AXES[kind], low, high, spec["n"])


def _made(where: str, kind: Callable[..., Any], *numbers: Any, **options: Any) -> Any:
    try:
        return kind(*numbers, **options)
    except (ValueError, TypeError) as error:
        raise CaseError(f"{where}: {error}") from None


def _pair(where: str, kind: str, given: Any) -> tuple[Any, Any]:
    if not isinstance(given, list) or len(given) != 2:
        raise CaseError(f"{where}.{kind} = {toml_value(given)}: must be a list of two values")
    return given[0], given[1]


def _number(where: str, place: str, given: Any) -> float:
    value = value_in_si(where, place, given)
    if not isinstance(value, float):
        key = place.rpartition(".")[2]
        if isinstance(given, str) and (close := get_close_matches(key, _KINDS, 1)) and key not in _KINDS:
            raise CaseError(f"{where}: unknown quantity; did you mean {close[0]}?")
        raise CaseError(f"{where} = {toml_value(given)}: must be a number in SI")
    return value


def _advice(name: str, known: Iterable[str]) -> str:
    close = get_close_matches(name, known, 1)
    return f"did you mean {close[0]}?" if close else f"known are {', '.join(known)}"
