"""Sweep files: a case file with axes, which set any of its keys."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pydantic import StrictInt, ValidationError, field_validator

from restitution.case.axes import DRAWS, read_axes
from restitution.case.classical import FractionalSection
from restitution.case.file import read_toml
from restitution.case.quantity import refuse
from restitution.case.schema import SolverSection
from restitution.case.section import CaseError, Section, explain
from restitution.case.template import CaseTemplate, put
from restitution.sweeps.axis import Linear
from restitution.sweeps.grid import make_grid
from restitution.sweeps.plan import Plan
from restitution.sweeps.samples import Samples
from restitution.sweeps.schema import DEFAULT_OUTPUTS, checked_outputs
from restitution.sweeps.template import (
    Template,
    dimensionless_template,
)

# Keys that columns of numbers set, by which a million values cost as much as one.
_OF_BODIES = {
    **{f"impact.{name}": name for name in ("velocity", "drop_height", "gravity", "external_force")},
    **{f"body.{name}": name for name in ("mass", "density", "radius")},
}
_OF_BULKS = {f"material.{name}": name for name in ("poisson_ratio", "bulk_modulus")}
_OF_SHIFTS = {"material.temperature": "temperature"}
_OF_STANDARD_SOLIDS = {
    **{
        f"material.{name}": name
        for name in ("equilibrium_modulus", "branch_modulus", "viscosity", "relaxation_time")
    },
    "p2": "p2",
    "p3": "p3",
}

# What a standard solid is given by; a material with other keys has another form.
_STANDARD_SOLID = {
    "model", "equilibrium_modulus", "branch_modulus", "viscosity", "poisson_ratio", "bulk_modulus", "density",
    "name",
}  # fmt: skip
_SOLID_MODEL = "standard_solid"
# What axes set by way of a key, which the file then need not have.
_BY_WAY_OF = {
    "p2": "branch_modulus",
    "p3": "viscosity",
    "material.relaxation_time": "viscosity",
}

# Of these a case file has one: an axis over the one takes the place of the others.
_RIVALS = (
    ("impact.velocity", "impact.drop_height"),
    ("impact.external_force", "impact.weight"),
    ("body.mass", "body.density"),
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
        except ValueError as error:
            refuse(str(error).partition(": ")[2])


class _Options(Section):
    sweep: SweepSection = SweepSection()
    solver: SolverSection = SolverSection()


def read_sweep(path: str | Path) -> Plan:
    """Read a sweep file: a case file with axes.

    Parameters
    ----------
    path : str or Path
        A TOML file.

    Returns
    -------
    Plan
        To be run by `restitution.sweeps.run.run`.

    Raises
    ------
    CaseError
        If the file cannot be read or describes no sweep, in one line.

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


def plan_case(path: Path, data: dict[str, Any], axes: Mapping[str, Any], text: str = "") -> Plan:
    """Plan a sweep of a case.

    Parameters
    ----------
    path : Path
        The file, for messages and for names of files within it.
    data : dict
        Its content without the axes.
    axes : dict
        As `restitution.case.axes.read_axes` returns them.
    text : str
        The file as it stands, for the record.

    Returns
    -------
    Plan

    Raises
    ------
    CaseError
        In one line.
    """
    own = {name: data[name] for name in ("sweep", "solver") if name in data}
    try:
        options = _Options.model_validate(own)
    except ValidationError as error:
        raise CaseError(explain(path, own, error)) from None
    if options.solver.method != "exact":
        raise CaseError(f'{path}: solver.method = "{options.solver.method}": must be "exact" in a sweep')
    case = {name: value for name, value in data.items() if name != "sweep"}
    dimensionless = not set(case) - {"title", "solver"}
    columns = _columns(case, axes, dimensionless)
    quantities = dict(_quantities(axes))
    template: Template
    if dimensionless:
        names = {columns.get(place, place) for place in quantities}
        if missing := sorted({"poisson_ratio", "p2", "p3"} - names):
            raise CaseError(
                f"{path}: axes: {', '.join(missing)}: is missing; or give body, material and impact"
            )
        template = dimensionless_template()
    else:
        for rivals in _RIVALS:
            both = [place for place in quantities if place in rivals]
            if len(both) > 1:
                raise CaseError(f"{path}: axes: {' and '.join(both)} set the same; leave one out")
        case = copy.deepcopy(case)
        for place, value in quantities.items():
            try:
                _complete(case, place, value, columns)
            except ValueError as error:
                raise CaseError(f"{path}: axes.{place}: {error}") from None
        keys = tuple(place for place in quantities if place not in columns)
        set_by_columns = tuple(columns[place] for place in quantities if place in columns)
        template = CaseTemplate(path, path.parent.absolute(), case, keys, set_by_columns)
        template.prepare({})
    try:
        grid = make_grid(
            {columns.get(place, place): _renamed(axis, columns) for place, axis in axes.items()},
            options.sweep.chunk,
        )
        rtol = options.solver.rtol or 1e-9
        return Plan(template, grid, options.sweep.outputs, rtol, str(data.get("title", "")), text)
    except (ValueError, TypeError) as error:
        raise CaseError(f"{path}: {error}") from None


def _columns(case: dict[str, Any], axes: Mapping[str, Any], dimensionless: bool) -> dict[str, str]:
    """Places of keys that columns set in this case, and the quantities that they are."""
    materials = [data.get(name) for data in (case, axes) for name in ("material", "counter_material")]
    if any(
        _is_fractional(one) for given in materials for one in (given if isinstance(given, list) else [given])
    ):
        # The Prony series that stands for it holds in a window that goes with the contact time.
        return {}
    material: Any = case["material"] if isinstance(case.get("material"), dict) else {}
    keys = set[str](material)
    if dimensionless or (keys <= _STANDARD_SOLID and material.get("model", _SOLID_MODEL) == _SOLID_MODEL):
        return _OF_BODIES | _OF_BULKS | _OF_STANDARD_SOLIDS
    columns = _OF_BODIES | _OF_BULKS if "shear" in keys else _OF_BODIES
    # A column of temperatures would be that of both bodies.
    return (
        columns | _OF_SHIFTS if "shift" in keys and materials[1] is None and materials[3] is None else columns
    )


def _is_fractional(material: Any) -> bool:
    return isinstance(material, dict) and material.get("model") in FractionalSection.keys


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


def _complete(case: dict[str, Any], place: str, value: Any, columns: Mapping[str, str]) -> None:
    """Put a value of an axis where the file may have none."""
    if place in columns and place in _BY_WAY_OF:
        case.setdefault("material", {}).setdefault(_BY_WAY_OF[place], 1.0)
        return
    if place in ("p2", "p3"):
        raise ValueError("belongs to a standard solid, which the material is not")
    for rivals in _RIVALS:
        for other in rivals if place in rivals else ():
            section, _, key = other.partition(".")
            if isinstance(case.get(section), dict):
                case[section].pop(key, None)
    put(case, place, value)
