"""Templates of a sweep, and the impacts that they build from columns of quantities."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from difflib import get_close_matches
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from restitution.contact.profile import Parabola, Profile
from restitution.errors import InputError, InputTypeError
from restitution.impact.batch import Batch
from restitution.impact.problem import Impact
from restitution.impact.scaling import viscosity_unit
from restitution.material.classical import standard_solid
from restitution.material.conversion import bulk_factor, poisson_ratio
from restitution.quantities import BODY
from restitution.sweeps.materials import (
    MATERIAL_NAMES,
    Columns,
    HeldElastic,
    changed_impact,
    check_names,
    combinations,
    is_standard_solid,
    material_rows,
)
from restitution.validity import Numbers, numbers

Places = NDArray[np.intp]
Tick = Callable[[int], None]

_MOST_REMEMBERED = 4096
# Numbers that may be arrays on layers that are not similar.
_SIZES = ("thickness",)


@dataclass(frozen=True)
class Prepared:
    """A single impact whose other quantities are set by columns of numbers."""

    impact: Impact
    # Converts columns into those of an impact, such as a density into a mass.
    derive: Callable[[Columns], Columns] | None = None
    held: HeldElastic = "bulk_modulus"  # constant while an axis changes the equilibrium shear modulus


class Template(Protocol):
    """What a sweep varies."""

    @property
    def dimensionless(self) -> bool:
        """Whether the bodies are dimensionless, so that only the Poisson ratio can be checked."""
        ...

    def builds_with(self, names: tuple[str, ...]) -> tuple[str, ...]:
        """Return the names whose combinations need a separate impact each; refuse unknown names."""
        ...

    def prepare(self, values: dict[str, Any]) -> Prepared:
        """Return the impact for one combination of their values, or raise an `InputError`."""
        ...


@dataclass(frozen=True)
class ImpactTemplate:
    """A single impact; axes set numbers of the body, the profile and the material."""

    impact: Impact
    held: HeldElastic = "bulk_modulus"
    dimensionless: bool = False

    def __post_init__(self) -> None:
        if self.impact.shape:
            wanted = f"has shape {self.impact.shape}; must be a single impact, axes make the others"
            raise InputError("base", wanted=wanted)

    def builds_with(self, names: tuple[str, ...]) -> tuple[str, ...]:
        check_columns(self.impact, names)
        return ()

    def prepare(self, values: dict[str, Any]) -> Prepared:
        return Prepared(self.impact, held=self.held)


@dataclass(frozen=True)
class BuilderTemplate:
    """A function that builds a single impact from values of axes, by the names of its arguments."""

    build: Callable[..., Impact]
    held: HeldElastic = "bulk_modulus"
    dimensionless = False

    def builds_with(self, names: tuple[str, ...]) -> tuple[str, ...]:
        try:
            parameters = inspect.signature(self.build).parameters.values()
        except (TypeError, ValueError):  # some functions and types in C have no signature
            raise InputTypeError("base", self.build, "must be a function with named parameters") from None
        if any(one.kind is one.VAR_KEYWORD for one in parameters):
            return names
        check_names(tuple(name for name in names if all(name != one.name for one in parameters)))
        for one in parameters:
            if one.default is one.empty and one.name not in names:
                raise InputError("axes", wanted=f"must have {one.name!r}, which the function takes")
        return tuple(one.name for one in parameters if one.name in names)

    def prepare(self, values: dict[str, Any]) -> Prepared:
        impact = self.build(**values)
        if not isinstance(impact, Impact):
            raise InputTypeError("base", wanted=f"returned {impact!r}; must return an Impact")
        if impact.shape:
            wanted = f"returned an impact of shape {impact.shape}; must return a single one"
            raise InputTypeError("base", wanted=wanted)
        return Prepared(impact, held=self.held)


def dimensionless_template() -> ImpactTemplate:
    """Impact of mass, radius, velocity and equilibrium modulus 1; axes set nu, p2 and p3."""
    solid = standard_solid(1.0, 1.0, 1.0, poisson_ratio=0.5)
    return ImpactTemplate(Impact(solid, Parabola(1.0), mass=1.0, velocity=1.0), dimensionless=True)


def check_columns(impact: Impact, names: tuple[str, ...]) -> None:
    """Refuse quantities that columns cannot set, or set twice."""
    known = (*BODY, *profile_names(impact), *MATERIAL_NAMES)
    for name in names:
        if name not in known and name.partition("[")[0] not in MATERIAL_NAMES:
            close = get_close_matches(name, known, 1)
            advice = f"did you mean {close[0]}?" if close else f"known are {', '.join(known)}"
            raise InputError("axes", wanted=f"the impact has no {name!r}; {advice}")
    check_names(names)


def profile_names(impact: Impact) -> tuple[str, ...]:
    """Names of the numbers of a geometry, and of the profile within it."""
    return _names(impact.profile)


def _names(geometry: Any) -> tuple[str, ...]:
    """Names of numbers, apart from those that a column of the material sets."""
    own = (field.name for field in fields(geometry) if field.init and field.name not in MATERIAL_NAMES)
    numbers = tuple(name for name in own if isinstance(getattr(geometry, name), float))
    return (*numbers, *_names(geometry.profile)) if hasattr(geometry, "profile") else numbers


def _reshaped(geometry: Any, numbers: Columns) -> Any:
    """Return a geometry with other numbers, its own or those of the profile within it."""
    if not numbers:
        return geometry
    if hasattr(geometry, "profile"):
        inner = {name: numbers[name] for name in _names(geometry.profile) if name in numbers}
        others = {name: one for name, one in numbers.items() if name not in inner}
        return replace(geometry, profile=_reshaped(geometry.profile, inner), **others)
    return replace(geometry, **numbers)


class Assembly:
    """Builds impacts from a template and columns: values of the quantities `names` at n points."""

    def __init__(self, template: Template, names: tuple[str, ...]) -> None:
        self._template = template
        self._built = template.builds_with(names)
        self._remembered: dict[tuple[Any, ...], Prepared] = {}

    def parts(self, columns: Columns, n: int, tick: Tick, *, strict: bool = False) -> list[tuple[Places, Batch]]:
        """Return batches with the places of their impacts among the n points.

        `tick` is called from time to time with 0, and ends the work by raising. Points that are not admissible belong
        to no batch; with `strict` they raise.
        """
        found = [
            (places[inner], batch)
            for places, prepared, own in self._groups(columns, n, tick, strict=strict)
            for inner, batch in _batches(prepared, own, places.size, tick, strict=strict)
        ]
        return Batch.joined(found)

    def validity(
        self, columns: Columns, n: int, found: Columns, tick: Tick, most: int | None = None
    ) -> Iterator[tuple[Places, Numbers, bool]]:
        """Yield numbers of the validity report, with the places of the impacts, and whether the material is theirs.

        `found` has the `restitution.validity.COLUMNS` of the n impacts. More than `most` combinations of builder
        arguments or shapes are represented by an even sample. If there are more materials than that, an even sample
        comes with its own materials, and all other impacts with another one.
        """
        if self._template.dimensionless:
            known = ~np.isnan(found["contact_time"])
            yield (
                np.flatnonzero(known),
                _of_solids(columns["poisson_ratio"][known], columns["p2"][known]),
                True,
            )
            return
        for places, prepared, own in self._groups(columns, n, tick, most=most):
            for inner, impact, is_own in _impacts(prepared, own, places.size, tick, most=most):
                there = places[inner]
                outputs = {name: column[there] for name, column in found.items()}
                bodies = {"velocity": impact.velocity, "mass": impact.mass, "impedance": impact.impedance}
                yield there, numbers(impact.contact, **outputs, **bodies), is_own

    def _groups(
        self, columns: Columns, n: int, tick: Tick, *, strict: bool = False, most: int | None = None
    ) -> Iterator[tuple[Places, Prepared, Columns]]:
        """Yield the prepared impact of each combination of builder arguments, with its places and other columns."""
        groups = list(combinations({name: columns[name] for name in self._built}, n))
        for places, values in _sample(groups, most):
            tick(0)
            own = {name: column[places] for name, column in columns.items() if name not in self._built}
            try:
                prepared = self._prepare(values)
                own = own if prepared.derive is None else prepared.derive(own)
                own = _with_viscosity(prepared.impact, own)
            except ValueError:
                if strict:
                    raise
                continue
            yield places, prepared, own

    def _prepare(self, values: dict[str, Any]) -> Prepared:
        # The lists of objects exist as long as the sweep, so that an identity belongs to a single object.
        key = tuple(value if isinstance(value, float) else id(value) for value in values.values())
        if key not in self._remembered:
            if len(self._remembered) >= _MOST_REMEMBERED:
                self._remembered.clear()
            self._remembered[key] = self._template.prepare(values)
        return self._remembered[key]


def _sample(groups: list[Any], most: int | None) -> list[Any]:
    """Return at most a given number of groups, spread evenly over all."""
    if most is None or len(groups) <= most:
        return groups
    return [groups[n] for n in np.linspace(0.0, len(groups) - 1.0, most).astype(int)]


def _with_viscosity(impact: Impact, columns: Columns) -> Columns:
    """Return columns with the viscosity instead of p3, which also depends on the body."""
    if "p3" not in columns:
        return columns
    materials = columns.get("material", [impact.material])
    if (
        {"counter_material", "exponent"} & columns.keys()
        or impact.counter_material is not None
        or impact.profile.path_exponent != 1.0
        or not all(map(is_standard_solid, {id(one): one for one in materials}.values()))
    ):
        raise InputError("axes", wanted="p3 belongs to a rigid parabola on a standard solid, which this is not")
    profile: Any = impact.profile
    profile = replace(profile, **{name: columns[name] for name in profile_names(impact) if name in columns})
    mass, velocity = (columns.get(name, getattr(impact, name)) for name in ("mass", "velocity"))
    modulus = columns.get("equilibrium_modulus", np.array([one.shear.equilibrium_modulus for one in materials]))
    viscosity = columns["p3"] * viscosity_unit(modulus, mass, velocity, profile.path_coefficient**2)
    return {name: column for name, column in columns.items() if name != "p3"} | {"viscosity": viscosity}


def _impacts(
    prepared: Prepared, columns: Columns, n: int, tick: Tick, *, strict: bool = False, most: int | None = None
) -> Iterator[tuple[Places, Impact, bool]]:
    """Yield impacts of one pair of materials each, arrays of other numbers, and whether the materials are theirs."""
    impact, names = prepared.impact, profile_names(prepared.impact)
    columns = {"mass": np.full(n, impact.mass)} | columns
    arrays = _array_names(impact) if "exponent" not in columns else ()
    grouped = {k: v for k, v in columns.items() if k not in BODY and k not in arrays}
    materials = list(combinations(grouped, n))
    sample = _sample(materials, most)
    groups = [(places, values, True) for places, values in sample]
    if len(sample) < len(materials):
        rest = np.setdiff1d(np.arange(n), np.concatenate([places for places, _ in sample]))
        shapes = list(combinations({k: v[rest] for k, v in grouped.items() if k in names}, rest.size))
        groups += [(rest[places], values, False) for places, values in _sample(shapes, most)]
    for places, values, is_own in groups:
        tick(0)
        if arrays == _SIZES and "thickness" in columns:
            # Impacts of one table follow each other.
            places = places[np.argsort(columns["thickness"][places], kind="stable")]
        own = {k: v[places] for k, v in columns.items() if k in BODY or k in names} | values
        shape, bodies = ({k: own[k] for k in given if k in own} for given in (names, BODY))
        try:
            changed = changed_impact(impact, {k: v for k, v in values.items() if k not in names}, prepared.held)
            changed = replace(changed, profile=_reshaped(changed.profile, shape), **bodies)
        except ValueError:
            if strict:
                raise
            continue
        yield places, changed, is_own


def _of_solids(static_poisson_ratio: NDArray[Any], p2: NDArray[Any]) -> Numbers:
    """Numbers of standard solids without dimensions: both Poisson ratios."""
    instantaneous = np.vectorize(poisson_ratio, otypes=[float])(1.0 + 1.0 / p2, bulk_factor(static_poisson_ratio))
    known = {"poisson_ratio": static_poisson_ratio, "instantaneous_poisson_ratio": instantaneous}
    return Numbers(**dict.fromkeys(Numbers._fields, np.full(p2.shape, np.nan)) | known)


def _array_names(impact: Impact) -> tuple[str, ...]:
    """Names of the numbers of its geometry that may be arrays in one impact."""
    profile, within = impact.profile, hasattr(impact.profile, "profile")
    if profile.similar.geometry is not profile or (profile.path_exponent is not None and not within):
        return profile_names(impact)
    return _SIZES if within and profile.path_exponent is None else ()


def _batches(
    prepared: Prepared, columns: Columns, n: int, tick: Tick, *, strict: bool
) -> Iterator[tuple[Places, Batch]]:
    """Yield batches of the impacts that differ from one by columns."""
    impact, names = prepared.impact, profile_names(prepared.impact)
    exponent = impact.profile.path_exponent
    if exponent is None or not isinstance(impact.profile, Profile) or "exponent" in columns:
        for places, changed, _ in _impacts(prepared, columns, n, tick, strict=strict):
            yield places, Batch.from_impact(changed)
        return
    profile: Any = impact.profile
    profile = replace(profile, **{name: columns[name] for name in names if name in columns})
    coefficient = np.broadcast_to(np.asarray(profile.path_coefficient, dtype=np.float64), (n,))
    bodies = [columns.get(name, np.full(n, getattr(impact, name))) for name in BODY]
    material = {name: column for name, column in columns.items() if name not in (*BODY, *names)}
    for places, series in material_rows(impact, material, n, prepared.held, tick, strict=strict):
        mass, velocity, force, impedance, c = (column[places] for column in (*bodies, coefficient))
        batch = Batch(*series, mass, velocity, force, c, float(np.asarray(exponent)), impedances=impedance)
        yield places, batch
