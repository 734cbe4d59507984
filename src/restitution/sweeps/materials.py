"""Materials of a sweep: the quantities that axes set, and the reduced moduli that follow."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Any, Literal, TypeGuard

import numpy as np
from numpy.typing import NDArray

from restitution.errors import InputError
from restitution.impact.problem import Impact
from restitution.material.columns import PronyColumns, reduced_standard_solid
from restitution.material.conversion import bulk_from_poisson_ratio, poisson_ratio
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material

HeldElastic = Literal["bulk_modulus", "poisson_ratio"]
Columns = dict[str, NDArray[Any]]
Places = NDArray[np.intp]

_OBJECTS = ("material", "counter_material")
_SOLID = (
    "equilibrium_modulus", "branch_modulus", "viscosity", "relaxation_time", "poisson_ratio", "bulk_modulus",
    "p2", "p3",
)  # fmt: skip
MATERIAL_NAMES = (*_OBJECTS, *_SOLID, "temperature", "branch_moduli", "relaxation_times")
"""Quantities of materials that axes set; the last two have the number of the branch, as in `relaxation_times[0]`."""

_RIVALS = (("branch_modulus", "p2"), ("viscosity", "relaxation_time", "p3"), ("poisson_ratio", "bulk_modulus"))
_PLACE = re.compile(r"(branch_moduli|relaxation_times)\[(\d+)\]")


def check_names(names: tuple[str, ...]) -> None:
    """Refuse quantities that set the same constant of a material."""
    for rivals in _RIVALS:
        both = [name for name in names if name in rivals]
        if len(both) > 1:
            raise InputError("axes", wanted=f"{' and '.join(both)} set the same; leave all but one out")


def is_standard_solid(material: Material) -> bool:
    """Whether a material has one branch, no dashpot in parallel, and a constant bulk modulus."""
    return material.shear.n_branches == 1 and material.shear.parallel_viscosity == 0.0 and not _relaxes(material.bulk)


def _relaxes(bulk: PronySeries | float) -> TypeGuard[PronySeries]:
    return isinstance(bulk, PronySeries) and bool(bulk.branch_moduli.any() or bulk.parallel_viscosity > 0.0)


def material_rows(
    impact: Impact, columns: Columns, n: int, held: HeldElastic, tick: Callable[[int], None], *, strict: bool
) -> Iterator[tuple[Places, PronyColumns]]:
    """Yield the reduced moduli of n impacts whose materials differ from those of one by columns, with their places.

    `held` stays constant while the equilibrium shear modulus changes. `tick` is called now and then with 0, and ends
    the work by raising. Materials that are not admissible are left out; with `strict` they raise.
    """
    objects = {name: column for name, column in columns.items() if name in _OBJECTS}
    if objects:
        for places, values in combinations(objects, n):
            rest = {name: column[places] for name, column in columns.items() if name not in _OBJECTS}
            changed = _with_materials(impact, tuple(values.items()))
            for inner, rows in material_rows(changed, rest, places.size, held, tick, strict=strict):
                yield places[inner], rows
        return
    solid = _solid_rows(impact, columns, n, held)
    if solid is not None:
        yield np.arange(n), solid
        return
    found: dict[int, list[tuple[Places, PronySeries]]] = {}
    for places, values in combinations(columns, n):
        tick(0)
        try:
            series = _reduced(impact, tuple(values.items()), held)
        except ValueError:
            if strict:
                raise
            continue
        found.setdefault(series.n_branches, []).append((places, series))
    for members in found.values():
        distinct = PronyColumns.stacked([series for _, series in members])
        rows = np.repeat(np.arange(len(members)), [places.size for places, _ in members])
        yield np.concatenate([places for places, _ in members]), distinct.take(rows)


def changed_impact(impact: Impact, values: dict[str, Any], held: HeldElastic) -> Impact:
    """Return a single impact with other materials, from quantities of the material by name.

    Examples
    --------
    >>> import restitution as rs
    >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
    >>> ball = rs.Impact(rubber, rs.Parabola(0.01), mass=0.005, velocity=1.0)
    >>> stiff = changed_impact(ball, {"equilibrium_modulus": 2e6}, "poisson_ratio").material
    >>> print(stiff.shear.equilibrium_modulus, round(stiff.poisson_ratio, 12))
    2000000.0 0.45
    """
    objects = {name: values[name] for name in values if name in _OBJECTS}
    numbers = {name: values[name] for name in values if name not in _OBJECTS and name != "temperature"}
    impact = replace(impact, **objects) if objects else impact
    material, counter = impact.material, impact.counter_material
    if numbers:
        material = _changed(material, numbers, held)
    if "temperature" in values:
        if counter is not None and counter.shift is not None:
            counter = counter.at(values["temperature"])
        if counter is impact.counter_material or material.shift is not None:
            material = material.at(values["temperature"])
    return replace(impact, material=material, counter_material=counter)


@lru_cache(maxsize=4096)
def _with_materials(impact: Impact, items: tuple[tuple[str, Material], ...]) -> Impact:
    return changed_impact(impact, dict(items), "bulk_modulus")


# An inner axis of the material is repeated for every value of the outer axes.
@lru_cache(maxsize=4096)
def _reduced(impact: Impact, items: tuple[tuple[str, float], ...], held: HeldElastic) -> PronySeries:
    material = impact.material
    temperatures = [value for name, value in items if name == "temperature"]
    if temperatures and impact.counter_material is None and material.shift is not None:
        # All relaxation times of one material shift together, and those of its reduced modulus with them.
        rest = tuple((name, value) for name, value in items if name != "temperature")
        series = _reduced(impact, rest, held) if rest else impact.contact.reduced_modulus
        reference = material.temperature or material.shift.reference_temperature
        factor = material.shift.factor(temperatures[0]) / material.shift.factor(reference)
        return series.scaled(1.0, time_factor=factor)
    return changed_impact(impact, dict(items), held).contact.reduced_modulus


def _changed(material: Material, values: dict[str, float], held: HeldElastic) -> Material:
    shear, bulk = material.shear, material.bulk
    equilibrium = values.get("equilibrium_modulus", shear.equilibrium_modulus)
    moduli, times = np.array(shear.branch_moduli), np.array(shear.relaxation_times)
    if any(name in values for name in ("branch_modulus", "viscosity", "relaxation_time", "p2")):
        if moduli.size != 1:
            why = f"branch_modulus, viscosity, relaxation_time and p2 are of one branch, here there are {moduli.size}"
            raise InputError("axes", wanted=f"{why}; use branch_moduli[0], relaxation_times[0] and so on")
        eta = values.get("viscosity", moduli[0] * times[0])
        moduli[0] = values.get("branch_modulus", equilibrium / values["p2"] if "p2" in values else moduli[0])
        times[0] = values.get("relaxation_time", eta / moduli[0])
    for name, value in values.items():
        if match := _PLACE.fullmatch(name):
            target, place = (moduli if match[1] == "branch_moduli" else times), int(match[2])
            if place >= target.size:
                raise InputError("axes", wanted=f"there is no {name}; the material has {target.size} branches")
            target[place] = value
    bulk_modulus: float | None = values.get("bulk_modulus")
    if "poisson_ratio" in values:
        bulk_modulus = bulk_from_poisson_ratio(equilibrium, values["poisson_ratio"])
    elif held == "poisson_ratio" and bulk_modulus is None and "equilibrium_modulus" in values:
        bulk_modulus = bulk_from_poisson_ratio(equilibrium, material.poisson_ratio)
    return replace(
        material,
        shear=PronySeries(equilibrium, moduli, times, parallel_viscosity=shear.parallel_viscosity),
        bulk=bulk if bulk_modulus is None else _scaled_bulk(bulk, bulk_modulus),
    )


def _scaled_bulk(bulk: PronySeries | float, modulus: float) -> PronySeries | float:
    """Bulk relaxation with another equilibrium modulus and the same normalised relaxation."""
    if not _relaxes(bulk) or np.isinf(modulus):
        return modulus
    if bulk.equilibrium_modulus == 0.0:
        why = "bulk_modulus and poisson_ratio need a bulk modulus at equilibrium, which is 0 Pa"
        raise InputError("axes", wanted=why)
    return bulk.scaled(modulus / bulk.equilibrium_modulus)


def _solid_rows(impact: Impact, columns: Columns, n: int, held: HeldElastic) -> PronyColumns | None:
    """Reduced moduli of standard solids in closed form; None where it does not apply."""
    material, shear, bulk = impact.material, impact.material.shear, impact.material.bulk
    if impact.counter_material is not None or not is_standard_solid(material):
        return None
    if not columns or not columns.keys() <= set(_SOLID):
        return None
    one = np.ones(n)
    equilibrium = columns.get("equilibrium_modulus", shear.equilibrium_modulus * one)
    if not np.all(equilibrium > 0.0):
        return None
    eta = float(shear.branch_moduli[0] * shear.relaxation_times[0]) * one
    branch = columns.get("branch_modulus", float(shear.branch_moduli[0]) * one)
    # An impact whose numbers overflow fails with NOT_FINITE.
    with np.errstate(over="ignore", divide="ignore"):
        if "p2" in columns:
            branch = equilibrium / columns["p2"]
        time = columns.get("relaxation_time", columns.get("viscosity", eta) / branch)
    if "poisson_ratio" in columns:
        ratio = columns["poisson_ratio"]
    elif "bulk_modulus" in columns or ("equilibrium_modulus" in columns and held == "bulk_modulus"):
        constant = bulk.equilibrium_modulus if isinstance(bulk, PronySeries) else np.inf
        ratio = np.vectorize(poisson_ratio)(equilibrium, columns.get("bulk_modulus", constant * one))
    else:
        ratio = material.poisson_ratio * one
    return reduced_standard_solid(ratio, equilibrium, branch, time)


def combinations(columns: Columns, n: int) -> Iterator[tuple[NDArray[np.intp], dict[str, Any]]]:
    """Yield the places of every combination of values that occurs in n rows, and the values by name.

    Objects are distinguished by identity. Places ascend.

    Examples
    --------
    >>> columns = {"a": np.array([1.0, 2.0, 1.0]), "b": np.array([5.0, 5.0, 5.0])}
    >>> for places, values in combinations(columns, 3):
    ...     print(places, values)
    [0 2] {'a': 1.0, 'b': 5.0}
    [1] {'a': 2.0, 'b': 5.0}
    """
    if not columns:
        yield np.arange(n), {}
        return
    keys = np.zeros(n, dtype=np.intp)
    for column in columns.values():
        if column.dtype == object:
            numbers: dict[int, int] = {}
            codes = np.array([numbers.setdefault(id(item), len(numbers)) for item in column], dtype=np.intp)
        else:
            codes = np.unique(column, return_inverse=True)[1]
        # Groups are numbered again after each column, so that the product of many does not overflow.
        keys = np.unique(keys * (int(codes.max()) + 1) + codes, return_inverse=True)[1]
    order = np.argsort(keys, kind="stable")
    starts = np.flatnonzero(np.diff(keys[order], prepend=-1))
    for places in np.split(order, starts[1:]):
        yield places, {name: _plain(column[places[0]]) for name, column in columns.items()}


def _plain(value: Any) -> Any:
    return float(value) if isinstance(value, np.floating) else value
