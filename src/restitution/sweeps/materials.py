"""Materials of a sweep: what axes set of them, and the reduced moduli that come of it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.errors import InputError
from restitution.impact.problem import Impact
from restitution.impact.scaling import viscosity_unit
from restitution.material.conversion import bulk_from_poisson_ratio, poisson_ratio
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, reduced_standard_solid

Array = NDArray[Any]
HeldElastic = Literal["bulk_modulus", "poisson_ratio"]
Columns = dict[str, NDArray[Any]]

_OBJECTS = ("material", "counter_material")
_SOLID = (
    "equilibrium_modulus", "branch_modulus", "viscosity", "relaxation_time", "poisson_ratio", "bulk_modulus",
    "p2", "p3",
)  # fmt: skip
MATERIAL_NAMES = (*_OBJECTS, *_SOLID, "temperature", "branch_moduli", "relaxation_times")
"""What axes set of materials; the last two with the number of the branch, as in `relaxation_times[0]`."""

_RIVALS = (
    ("branch_modulus", "p2"),
    ("viscosity", "relaxation_time", "p3"),
    ("poisson_ratio", "bulk_modulus"),
)
_PLACE = re.compile(r"(branch_moduli|relaxation_times)\[(\d+)\]")


class SeriesRows(NamedTuple):
    """Reduced moduli of n impacts.

    Attributes
    ----------
    equilibria, viscosities : array, shape (n,)
        [Pa], [Pa s].
    moduli, times : array, shape (n, n_branch)
        [Pa], [s].
    """

    equilibria: Array
    viscosities: Array
    moduli: Array
    times: Array


class Bodies(NamedTuple):
    """What the dimensionless viscosity p3 takes beside the material.

    Attributes
    ----------
    masses, velocities : array, shape (n,)
        [kg], [m/s].
    radii : array, shape (n,), or None
        [m]; None where the profile is no parabola.
    """

    masses: Array
    velocities: Array
    radii: Array | None

    def at(self, places: NDArray[np.intp]) -> Bodies:
        """Return those of some impacts."""
        return Bodies(*(None if column is None else column[places] for column in self))  # pyright: ignore[reportArgumentType]


def check_names(names: tuple[str, ...]) -> None:
    """Refuse quantities of a material that set the same thing."""
    for rivals in _RIVALS:
        both = [name for name in names if name in rivals]
        if len(both) > 1:
            raise InputError("axes", wanted=f"{' and '.join(both)} set the same; leave all but one out")


def material_rows(
    impact: Impact,
    columns: Columns,
    held: HeldElastic,
    bodies: Bodies,
    tick: Callable[[int], None],
    *,
    strict: bool,
) -> Iterator[tuple[NDArray[np.intp], SeriesRows]]:
    """Yield the reduced moduli of impacts whose materials differ from those of one by columns.

    Parameters
    ----------
    impact : Impact
        What is varied.
    columns : dict of str to array, shape (n,)
        Quantities of the material.
    held : {"bulk_modulus", "poisson_ratio"}
        What stays where the shear modulus at equilibrium changes.
    bodies : Bodies
        The bodies of the n impacts.
    tick : callable
        Called now and then with 0; ends the work by raising.
    strict : bool
        Whether materials that are not admissible raise, rather than being left out.

    Yields
    ------
    tuple of array and SeriesRows
        Places among the n, and the moduli there.
    """
    n = bodies.masses.size
    objects = {name: column for name, column in columns.items() if name in _OBJECTS}
    if objects:
        numbers = {name: column for name, column in columns.items() if name not in _OBJECTS}
        for places, values in combinations(objects, n):
            rest = {name: column[places] for name, column in numbers.items()}
            changed = _with_materials(impact, tuple(values.items()))
            for inner, rows in material_rows(changed, rest, held, bodies.at(places), tick, strict=strict):
                yield places[inner], rows
        return
    if not columns:
        yield np.arange(n), _repeated([impact.reduced_modulus], [n])
        return
    solid = _solid_rows(impact, columns, held, bodies)
    if solid is not None:
        yield np.arange(n), solid
        return
    found: dict[int, list[tuple[NDArray[np.intp], PronySeries]]] = {}
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
        places = np.concatenate([place for place, _ in members])
        yield places, _repeated([series for _, series in members], [place.size for place, _ in members])


def changed_impact(impact: Impact, values: dict[str, Any], held: HeldElastic) -> Impact:
    """Return the impact with other materials.

    Parameters
    ----------
    impact : Impact
        A single impact.
    values : dict
        Quantities of the material, by name.
    held : {"bulk_modulus", "poisson_ratio"}
        What stays where the shear modulus at equilibrium changes.

    Returns
    -------
    Impact

    Raises
    ------
    ValueError
        If a quantity does not belong to the material, or is out of range.

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


# An inner axis of the material comes back with every value of the outer ones.
@lru_cache(maxsize=4096)
def _reduced(impact: Impact, items: tuple[tuple[str, float], ...], held: HeldElastic) -> PronySeries:
    material = impact.material
    temperatures = [value for name, value in items if name == "temperature"]
    if temperatures and impact.counter_material is None and material.shift is not None:
        # All relaxation times of one material shift together, and those of its reduced modulus with them.
        rest = tuple((name, value) for name, value in items if name != "temperature")
        series = _reduced(impact, rest, held) if rest else impact.reduced_modulus
        reference = material.temperature or material.shift.reference_temperature
        factor = material.shift.factor(temperatures[0]) / material.shift.factor(reference)
        return series.scaled(1.0, time_factor=factor)
    return changed_impact(impact, dict(items), held).reduced_modulus


def _repeated(series: list[PronySeries], counts: list[int]) -> SeriesRows:
    columns = (
        [one.equilibrium_modulus for one in series],
        [one.parallel_viscosity for one in series],
        [one.branch_moduli for one in series],
        [one.relaxation_times for one in series],
    )
    return SeriesRows(*(np.repeat(np.array(column), counts, axis=0) for column in columns))


def _changed(material: Material, values: dict[str, float], held: HeldElastic) -> Material:
    shear, bulk = material.shear, material.bulk
    equilibrium = values.get("equilibrium_modulus", shear.equilibrium_modulus)
    moduli, times = np.array(shear.branch_moduli), np.array(shear.relaxation_times)
    if "p3" in values:
        raise InputError("axes", wanted="p3 belongs to a rigid parabola on a standard solid, which this is not")
    if any(name in values for name in ("branch_modulus", "viscosity", "relaxation_time", "p2")):
        if moduli.size != 1:
            raise InputError(
                "axes",
                wanted=f"branch_modulus, viscosity, relaxation_time and p2 are of one branch, here there are "
                f"{moduli.size}; use branch_moduli[0], relaxation_times[0] and so on",
            )
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
    """Bulk relaxation with another modulus at equilibrium, its course over time being kept."""
    relaxes = isinstance(bulk, PronySeries) and (bulk.branch_moduli.any() or bulk.parallel_viscosity > 0.0)
    if not relaxes or np.isinf(modulus):
        return modulus
    assert isinstance(bulk, PronySeries)
    if bulk.equilibrium_modulus == 0.0:
        raise InputError(
            "axes", wanted="bulk_modulus and poisson_ratio need a bulk modulus at equilibrium, which is 0 Pa"
        )
    return bulk.scaled(modulus / bulk.equilibrium_modulus)


def _solid_rows(impact: Impact, columns: Columns, held: HeldElastic, bodies: Bodies) -> SeriesRows | None:
    """Reduced moduli of standard solids in closed form; None where it does not apply."""
    material, shear, bulk = impact.material, impact.material.shear, impact.material.bulk
    relaxes = isinstance(bulk, PronySeries) and (bulk.branch_moduli.any() or bulk.parallel_viscosity > 0.0)
    others = set(columns) - set(_SOLID)
    if (
        impact.counter_material is not None
        or relaxes
        or others
        or shear.n_branches != 1
        or shear.parallel_viscosity > 0.0
    ):
        return None
    one = np.ones(bodies.masses.size)
    equilibrium = columns.get("equilibrium_modulus", shear.equilibrium_modulus * one)
    if not np.all(equilibrium > 0.0) or ("p3" in columns and bodies.radii is None):
        return None
    eta = float(shear.branch_moduli[0] * shear.relaxation_times[0]) * one
    branch = columns.get("branch_modulus", float(shear.branch_moduli[0]) * one)
    if "p2" in columns:
        branch = equilibrium / columns["p2"]
    if "p3" in columns:
        assert bodies.radii is not None
        eta = columns["p3"] * viscosity_unit(equilibrium, bodies.masses, bodies.velocities, bodies.radii)
    time = columns.get("relaxation_time", columns.get("viscosity", eta) / branch)
    if "poisson_ratio" in columns:
        ratio = columns["poisson_ratio"]
    elif "bulk_modulus" in columns or ("equilibrium_modulus" in columns and held == "bulk_modulus"):
        constant = bulk.equilibrium_modulus if isinstance(bulk, PronySeries) else np.inf
        ratio = np.vectorize(poisson_ratio)(equilibrium, columns.get("bulk_modulus", constant * one))
    else:
        ratio = material.poisson_ratio * one
    reduced = reduced_standard_solid(ratio, equilibrium, branch, time)
    return SeriesRows(reduced.equilibrium, 0.0 * one, reduced.moduli, reduced.times)


def combinations(columns: Columns, n: int) -> Iterator[tuple[NDArray[np.intp], dict[str, Any]]]:
    """Yield every combination of values that occurs, with the places where it does.

    Parameters
    ----------
    columns : dict of str to array, shape (n,)
        Numbers, or objects, which are told apart by identity.
    n : int
        Number of places.

    Yields
    ------
    tuple of array and dict
        Places in ascending order; values by name.

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
        # Renumbered after each column, so that the product of many does not overflow.
        keys = np.unique(keys * (int(codes.max()) + 1) + codes, return_inverse=True)[1]
    order = np.argsort(keys, kind="stable")
    starts = np.flatnonzero(np.diff(keys[order], prepend=-1))
    for places in np.split(order, starts[1:]):
        yield places, {name: _plain(column[places[0]]) for name, column in columns.items()}


def _plain(value: Any) -> Any:
    return float(value) if isinstance(value, np.floating) else value
