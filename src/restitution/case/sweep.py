"""Sweep files: a case file with axes, which set any of its keys."""

from __future__ import annotations

import copy
import dataclasses
import re
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import StrictInt, field_validator

from restitution.case.axes import place_of, read_axes
from restitution.case.impact import CaseFile, SolverSection
from restitution.case.material import is_fractional
from restitution.case.section import Section, in_file, read_sections, read_toml, refuse, split_list
from restitution.errors import InputError
from restitution.impact.problem import Impact
from restitution.material.models import material_models
from restitution.quantities import ADHESION_INPUTS, BODY, DEFAULT_OUTPUTS, SLIDING, checked_outputs
from restitution.sweeps.grid import Values, make_grid
from restitution.sweeps.plan import Plan, Template, Vary, describe, dimensionless_template
from restitution.variation import MATERIALS, check_rivals, varied

ENTRY = re.compile(r"(.+)\[(\d+)\]")

_SOLID = "standard_solid"
# Axes that set a constant of a standard solid by way of another key, which the file need not have.
_BY_WAY_OF = {"p2": "branch_modulus", "p3": "viscosity", "relaxation_time": "viscosity"}

# Mutually exclusive keys. An axis over one may complete a file that has none of them, or vary the one that it has.
_RIVALS = (
    ("impact.velocity", "impact.drop_height", "impact.speed"),
    ("impact.tangential_velocity", "impact.angle"),
    ("impact.external_force", "impact.weight"),
    ("body.mass", "body.density"),
    ("counter_body.mass", "counter_body.density"),
    ("adhesion.stress", "adhesion.range"),
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
            refuse(error.rule)


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
    if "uncertainty" in data:
        with in_file(path):
            refuse(
                "belongs to a single impact, for `restitution solve`; [samples] draws random impacts", "uncertainty"
            )
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
        grid = make_grid(axes, options.sweep.chunk, adhesive="adhesion" in data)
    first = next(grid.corners())
    case = {name: value for name, value in data.items() if name != "sweep"}
    template: Template
    if set(case) - {"title", "solver"}:
        template = _template(path, copy.deepcopy(case), axes, first, replace)
    else:
        with in_file(path):
            template = dimensionless_template(grid.names)
    return Plan(template, grid, options.sweep.outputs, options.solver.rtol or 1e-9, str(data.get("title", "")), text)


def _template(path: Path, case: dict[str, Any], axes: Mapping[str, Any], first: Values, replace: bool) -> CaseTemplate:
    """Return the template of a case; `first` has the first value of each quantity that the axes set."""
    materials = [data.get(name) for data in (case, axes) for name in ("material", "counter_material")]
    fractional = any(
        is_fractional(each) for values in materials for each in (values if isinstance(values, list) else [values])
    )
    by_way = _by_way(case) if not fractional else {}
    with in_file(path, "axes"):
        for rivals in _RIVALS:
            both = [place for place in map(place_of, first) if place in rivals]
            if len(both) > 1:
                refuse("set the same; leave one out", " and ".join(both))
        for name, value in first.items():
            _complete(case, name, value, by_way, replace)
    template = CaseTemplate(path, path.parent.absolute(), case, tuple(by_way), tuple(first))
    vary = template.prepare({})
    if fractional:
        # The window of a Prony series depends on the contact time.
        return template
    with in_file(path):
        check_rivals(tuple(first) if by_way else ())
    apart = tuple(name for name, value in first.items() if not _takes_arrays(vary, name, value))
    return dataclasses.replace(template, apart=apart)


def _by_way(case: dict[str, Any]) -> dict[str, str]:
    """Return quantities of a standard solid that no key of the file has, and the keys that stand for them."""
    material: Any = case["material"] if isinstance(case.get("material"), dict) else {}
    keys = {"model", "name", "density", *material_models()[_SOLID].constants}
    return dict(_BY_WAY_OF) if set(material) <= keys and material.get("model", _SOLID) == _SOLID else {}


def _takes_arrays(vary: Vary, name: str, value: Any) -> bool:
    """Return whether a key takes arrays: whether each of two equal numbers makes the impact of the number itself."""
    if not isinstance(value, float):
        return False
    # A model of the user may put its numbers into lists, where another axis would be that of the branches.
    shape = (2, 1, 1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            several = vary({name: np.full(shape, value)})
            single, row = vary({name: value}), several.take(np.array(0))
        except (ValueError, TypeError):
            return False
    parts = (*MATERIALS, "profile", *BODY, *SLIDING)
    alike = several.shape == shape and all(getattr(row, part) == getattr(single, part) for part in parts)
    return alike and _attraction(row) == _attraction(single)


def _attraction(impact: Impact) -> list[Any]:
    """Return the numbers of the adhesion of a single impact."""
    return [getattr(impact.adhesion, name) for name in ADHESION_INPUTS] if impact.adhesion else []


def _complete(case: dict[str, Any], name: str, value: Any, by_way: Mapping[str, str], replace: bool) -> None:
    """Put a value of an axis where the file may have none."""
    if name in by_way:
        case.setdefault("material", {}).setdefault(by_way[name], 1.0)
        return
    if name in ("p2", "p3"):
        refuse("belongs to a standard solid, which the material is not", name)
    place = place_of(name)
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
    by_way: tuple[str, ...]  # names of constants of a standard solid that no key has
    apart: tuple[str, ...]  # names whose combinations have an impact of their own each

    dimensionless = False

    def builds_with(self, names: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(name for name in names if name in self.apart)

    def prepare(self, values: Values) -> Vary:
        data = copy.deepcopy(self.data)
        for name, value in values.items():
            put(data, place_of(name), value)
        vary = partial(self._varied, data, self._read(data))
        vary({})
        return vary

    def _read(self, data: dict[str, Any]) -> CaseFile:
        return read_sections(CaseFile, self.path, data, self.folder)

    def _varied(self, data: dict[str, Any], case: CaseFile, values: Values) -> Impact:
        """Return the impact of a case with other numbers in SI, which broadcast."""
        by_way = {name: value for name, value in values.items() if name in self.by_way}
        changed = {place_of(name): value for name, value in values.items() if name not in by_way}
        if changed:
            # Sections without a change are not read again, as files and fits take their time.
            again = {place.partition(".")[0] for place in changed}
            data = {
                name: copy.deepcopy(part) if name in again else getattr(case, name)
                for name, part in data.items()
                if name != "sweep"
            }
            for place, value in changed.items():
                put(data, place, value)
            case = self._read(data)
        with in_file(self.path):
            return varied(case.build(), by_way, "bulk_modulus")

    def describe(self) -> Any:
        """Return the content of the file in SI."""
        content = self._read(self.data).model_dump(exclude={"title", "solver"}, exclude_none=True)
        return {"case": describe(content), "apart": list(self.apart)}


def put(case: dict[str, Any], place: str, value: Any) -> None:
    """Set the value at a place, such as `material.shear.relaxation_times[2]`."""
    *tables, key = place.split(".")
    target: Any = case
    for name in tables:
        target = target.setdefault(name, {})
        if not isinstance(target, dict):
            refuse(f"{name} is no table; a range is written {{ linear = [low, high], n = 5 }}", place)
    match = ENTRY.fullmatch(key)
    if match is None:
        target[key] = value
        return
    items, entry = split_list(target.get(match[1])), int(match[2])
    if not isinstance(items, list) or entry >= len(items):
        refuse(f"there is no such entry of {match[1]}", place)
    target[match[1]] = [*items[:entry], value, *items[entry + 1 :]]
