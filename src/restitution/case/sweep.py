"""Sweep files: a case file with axes, which set any of its keys."""

from __future__ import annotations

import copy
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import StrictInt, field_validator

from restitution.case.axes import DRAWS, read_axes
from restitution.case.impact import CaseFile, CounterBodySection, SolverSection
from restitution.case.material import is_fractional
from restitution.case.quantity import split_list
from restitution.case.section import Section, in_file, read_sections, read_toml, refuse
from restitution.contact.analytic import sphere_mass
from restitution.errors import InputError
from restitution.impact.problem import fall_velocity, reduced
from restitution.material.models import material_models
from restitution.quantities import DEFAULT_OUTPUTS, checked_outputs
from restitution.sweeps.grid import Linear, make_grid
from restitution.sweeps.plan import Plan, describe
from restitution.sweeps.samples import Samples
from restitution.sweeps.templates import Prepared, Template, check_columns, dimensionless_template, profile_names

_ENTRY = re.compile(r"(.+)\[(\d+)\]")

# Keys that columns of numbers set, by which a million values cost as much as one.
_OF_BODIES = {
    **{f"impact.{name}": name for name in ("velocity", "drop_height", "gravity", "external_force", "impedance")},
    **{f"body.{name}": name for name in ("mass", "density", "radius")},
    "profile.thickness": "thickness",
    **{name: name for name in ("counter_body.mass", "counter_body.density", "counter_body.radius")},
}
_OF_BULKS = {f"material.{name}": name for name in ("poisson_ratio", "bulk_modulus")}
_OF_SHIFTS = {"material.temperature": "temperature"}
_OF_STANDARD_SOLIDS = {
    **{f"material.{name}": name for name in ("equilibrium_modulus", "branch_modulus", "viscosity", "relaxation_time")},
    "p2": "p2",
    "p3": "p3",
}

_SOLID = "standard_solid"
# Axes that set a key indirectly; the file need not have this key.
_BY_WAY_OF = {"p2": "branch_modulus", "p3": "viscosity", "material.relaxation_time": "viscosity"}

# Mutually exclusive keys. An axis over one may complete a file that has none of them, or vary the one that it has.
_RIVALS = (
    ("impact.velocity", "impact.drop_height"),
    ("impact.external_force", "impact.weight"),
    ("body.mass", "body.density"),
    ("counter_body.mass", "counter_body.density"),
    ("material.poisson_ratio", "material.bulk_modulus", "material.bulk"),
)


class SweepSection(Section):
    """What is computed, and in which pieces."""

    outputs: tuple[str, ...] = DEFAULT_OUTPUTS
    chunk: StrictInt | dict[str, StrictInt] | None = None

    @field_validator("outputs")
    @classmethod
    def _known(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        try:
            return checked_outputs(value)
        except InputError as error:
            refuse(error.wanted)


class _Options(Section):
    sweep: SweepSection = SweepSection()
    solver: SolverSection = SolverSection()


def read_sweep(path: str | Path) -> Plan:
    """Read a TOML file of a case with axes, to be run by `restitution.sweeps.run.run`.

    A `CaseError` has a line for each mistake.

    Examples
    --------
    >>> import tempfile
    >>> text = '''
    ... [axes]
    ... poisson_ratio = [0.3, 0.5]
    ... p2 = 0.1
    ... p3 = { logarithmic = [0.01, 100.0], n = 50 }
    ... '''
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "plane.toml").write_text(text)
    ...     plan = read_sweep(Path(folder, "plane.toml"))
    >>> plan.grid.shape
    (2, 50)
    """
    path = Path(path)
    data = read_toml(path)
    axes = read_axes(path, data.pop("axes", None), data.pop("samples", None))
    return plan_case(path, data, axes, path.read_text(encoding="utf-8-sig"))


def plan_case(
    path: Path, data: dict[str, Any], axes: Mapping[str, Any], text: str = "", *, replace: bool = False
) -> Plan:
    """Plan a sweep of a case from the content of its file without the axes, and the axes of `read_axes`.

    The plan keeps the `text` of the file. With `replace` an axis replaces a rival key of the file, for example
    `drop_height` by `velocity`; without it, such a file is refused.
    """
    options = read_sections(_Options, path, {name: data[name] for name in ("sweep", "solver") if name in data})
    with in_file(path):
        if options.solver.method != "exact":
            refuse('must be "exact" in a sweep', "solver.method", options.solver.method)
    case = {name: value for name, value in data.items() if name != "sweep"}
    dimensionless = not set(case) - {"title", "solver"}
    columns = _columns(case, axes, dimensionless)
    quantities = dict(_quantities(axes))
    template: Template
    if dimensionless:
        names = {columns.get(place, place) for place in quantities}
        missing = [name for name in ("poisson_ratio", "p2", "p3") if name not in names]
        with in_file(path, "axes"):
            if missing:
                refuse("is missing; or give body, material and impact", ", ".join(missing))
        template = dimensionless_template()
    else:
        case = copy.deepcopy(case)
        with in_file(path, "axes"):
            for rivals in _RIVALS:
                both = [place for place in quantities if place in rivals]
                if len(both) > 1:
                    refuse("set the same; leave one out", " and ".join(both))
            for place, value in quantities.items():
                _complete(case, place, value, columns, replace)
        keys = tuple(place for place in quantities if place not in columns)
        set_by_columns = tuple(columns[place] for place in quantities if place in columns)
        template = CaseTemplate(path, path.parent.absolute(), case, keys, set_by_columns)
        template.prepare({})
    with in_file(path):
        renamed = {columns.get(place, place): _renamed(axis, columns) for place, axis in axes.items()}
        grid, rtol = make_grid(renamed, options.sweep.chunk), options.solver.rtol or 1e-9
        return Plan(template, grid, options.sweep.outputs, rtol, str(data.get("title", "")), text)


def _columns(case: dict[str, Any], axes: Mapping[str, Any], dimensionless: bool) -> dict[str, str]:
    """Places of keys that columns set in this case, and the quantities that they are."""
    materials = [data.get(name) for data in (case, axes) for name in ("material", "counter_material")]
    if any(is_fractional(one) for given in materials for one in (given if isinstance(given, list) else [given])):
        # The window of its Prony series depends on the contact time.
        return {}
    material: Any = case["material"] if isinstance(case.get("material"), dict) else {}
    keys = set[str](material)
    # A material with other keys has another form.
    solid = {"model", "name", "density", *material_models()[_SOLID].constants}
    if dimensionless or (keys <= solid and material.get("model", _SOLID) == _SOLID):
        return _OF_BODIES | _OF_BULKS | _OF_STANDARD_SOLIDS
    columns = _OF_BODIES | _OF_BULKS if "shear" in keys else _OF_BODIES
    # A column of temperatures holds for both bodies.
    return columns | _OF_SHIFTS if "shift" in keys and materials[1] is None and materials[3] is None else columns


def _renamed(axis: Any, columns: Mapping[str, str]) -> Any:
    if not isinstance(axis, Samples):
        return axis
    drawn = {columns.get(place, place): one for place, one in axis.distributions.items()}
    return Samples(axis.n, drawn, axis.method, axis.seed)


def _quantities(axes: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield the place of every quantity, and one of its values."""
    for place, axis in axes.items():
        if isinstance(axis, Samples):
            for drawn, values in axis.corners(DRAWS)[0].items():
                yield drawn, float(values[0])
        elif isinstance(axis, Linear):
            yield place, float(axis.low)
        else:
            yield place, axis[0] if isinstance(axis, list) else axis


def _complete(case: dict[str, Any], place: str, value: Any, columns: Mapping[str, str], replace: bool) -> None:
    """Put a value of an axis where the file may have none."""
    if place in columns and place in _BY_WAY_OF:
        case.setdefault("material", {}).setdefault(_BY_WAY_OF[place], 1.0)
        return
    if place in ("p2", "p3"):
        refuse("belongs to a standard solid, which the material is not", place)
    for rivals in _RIVALS:
        for other in rivals if place in rivals else ():
            section, _, key = other.partition(".")
            if other != place and isinstance(case.get(section), dict) and key in case[section]:
                if replace:
                    del case[section][key]
                    continue
                refuse(f"sets the same as {other}, which the file gives; leave one of the two out", place)
    put(case, place, value)


@dataclass(frozen=True)
class CaseTemplate:
    """A case file with the first values of the axes."""

    path: Path
    folder: Path  # where relative names of files start
    data: dict[str, Any]
    keys: tuple[str, ...]  # each combination of their values has an impact of its own
    columns: tuple[str, ...]  # quantities that columns of numbers set

    dimensionless = False

    def builds_with(self, names: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(name for name in names if name in self.keys)

    def prepare(self, values: dict[str, Any]) -> Prepared:
        case = self._case(values)
        with in_file(self.path):
            impact = case.build()
            derived = Derivation(case, profile_names(impact))
            check_columns(impact, tuple(derived({name: np.ones(1) for name in self.columns})))
        held = "bulk_modulus" if getattr(case.material, "poisson_ratio", None) is None else "poisson_ratio"
        return Prepared(impact, derived, held)

    def describe(self) -> Any:
        """Return the content of the file in SI."""
        case = self._case({}).model_dump(exclude={"title", "solver"}, exclude_none=True)
        return {"case": describe(case), "keys": list(self.keys), "columns": list(self.columns)}

    def _case(self, values: dict[str, Any]) -> CaseFile:
        data = self.data
        if values:
            data = copy.deepcopy(data)
            for place, value in values.items():
                put(data, place, value)
        return read_sections(CaseFile, self.path, data, self.folder)


@dataclass(frozen=True)
class Derivation:
    """Columns of an impact from those of a case file: mass from density, velocity from height, weight."""

    case: CaseFile
    own: tuple[str, ...]  # names of the numbers of the profile

    def __call__(self, columns: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
        body, impact, counter = self.case.body, self.case.impact, self.case.counter_body
        derived: dict[str, Any] = dict(columns)
        radius = derived.get("radius", body.radius)
        if not (self.case.profile.needs_body_radius and "radius" in self.own):
            derived.pop("radius", None)
        density = derived.pop("density", body.density)
        if density is not None and "mass" not in columns and {"density", "radius"} & columns.keys():
            derived["mass"] = sphere_mass(density, np.asarray(radius))
        gravity = derived.pop("gravity", impact.gravity)
        height = derived.pop("drop_height", impact.drop_height)
        if height is not None and {"drop_height", "gravity"} & columns.keys():
            derived["velocity"] = fall_velocity(height, gravity)
        if impact.weight and ("mass" in derived or "gravity" in columns):
            derived["external_force"] = derived.get("mass", body.kilograms) * gravity
        if counter is not None:
            self._reduce(derived, columns, counter)
        return derived

    def _reduce(self, derived: dict[str, Any], columns: dict[str, NDArray[Any]], counter: CounterBodySection) -> None:
        """Replace mass and radius of two bodies by the reduced ones."""
        mass, density, radius = (
            derived.pop(f"counter_body.{name}", getattr(counter, name)) for name in ("mass", "density", "radius")
        )
        if any(name.rpartition(".")[2] in ("mass", "density", "radius") for name in columns):
            if mass is None or ("counter_body.density" in columns):
                mass = sphere_mass(density, np.asarray(radius))
            own = derived.get("radius", getattr(self.case.profile, "radius", None) or self.case.body.radius)
            derived["mass"] = reduced(derived.get("mass", self.case.body.kilograms), mass)
            derived["radius"] = reduced(own, math.inf if radius is None else radius)


def put(case: dict[str, Any], place: str, value: Any) -> None:
    """Set the value at a place, such as `material.shear.relaxation_times[2]`."""
    *tables, key = place.split(".")
    target: Any = case
    for name in tables:
        target = target.setdefault(name, {})
        if not isinstance(target, dict):
            refuse(f"{name} is no table; a range is written {{ linear = [low, high], n = 5 }}", place)
    match = _ENTRY.fullmatch(key)
    if match is None:
        target[key] = value
        return
    items, entry = split_list(target.get(match[1])), int(match[2])
    if not isinstance(items, list) or entry >= len(items):
        refuse(f"there is no such entry of {match[1]}", place)
    target[match[1]] = [*items[:entry], value, *items[entry + 1 :]]
