"""From columns of quantities to impacts that can be solved together."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restitution.impact.batch import Batch
from restitution.impact.problem import Impact
from restitution.impact.scaling import viscosity_unit
from restitution.quantities import BODY
from restitution.sweeps.materials import Bodies, Columns, changed_impact, combinations, material_rows
from restitution.sweeps.varied import Prepared, Template, profile_names
from restitution.validity import Numbers, numbers, of_standard_solid

Array = NDArray[Any]
Places = NDArray[np.intp]
Part = tuple[Places, Batch]
Tick = Callable[[int], None]

_MOST_REMEMBERED = 4096


class Assembly:
    """Makes impacts of a template and of values along axes.

    Parameters
    ----------
    template : Template
        What is varied.
    names : tuple of str
        The quantities that axes set.

    Raises
    ------
    ValueError
        If the template has no such quantity.
    """

    def __init__(self, template: Template, names: tuple[str, ...]) -> None:
        self._template = template
        self._built = template.builds_with(names)
        self._remembered: dict[tuple[Any, ...], Prepared] = {}

    def parts(self, columns: Columns, n: int, tick: Tick, *, strict: bool = False) -> Iterator[Part]:
        """Turn columns of quantities into what can be solved.

        Parameters
        ----------
        columns : dict of str to array, shape (n,)
            Values of all quantities.
        n : int
            Number of points.
        tick : callable
            Called now and then with 0; ends the work by raising.
        strict : bool
            Whether points that are not admissible raise, rather than belonging to no part.

        Yields
        ------
        tuple of array and Batch
            Places among the n points, and the impacts there.
        """
        found: list[Part] = []
        for places, values in combinations({name: columns[name] for name in self._built}, n):
            tick(0)
            try:
                prepared = self._prepare(values)
                own = {name: column[places] for name, column in columns.items() if name not in self._built}
                if prepared.derive is not None:
                    own = prepared.derive(own)
            except ValueError:
                if strict:
                    raise
                continue
            for inner, part in _parts(prepared, own, places.size, tick, strict=strict):
                found.append((places[inner], part))
        yield from Batch.joined(found)

    def validity(
        self, columns: Columns, n: int, found: Columns, tick: Tick, most: int | None = None
    ) -> Iterator[tuple[Places, Numbers, bool]]:
        """Yield the numbers of the validity report, with the places of the impacts, and whether the material is theirs.

        Parameters
        ----------
        columns : dict of str to array, shape (n,)
            Values of all quantities.
        n : int
            Number of points.
        found : dict of str to array, shape (n,)
            `restitution.validity.COLUMNS` of the impacts there.
        tick : callable
            Called now and then with 0; ends the work by raising.
        most : int, optional
            Of more combinations of builder arguments or shapes, an even sample of this many is yielded. Of more
            materials, an even sample comes with its own materials and all other impacts with another one.
        """
        if self._template.dimensionless:
            known = ~np.isnan(found["contact_time"])
            yield np.flatnonzero(known), of_standard_solid(columns["poisson_ratio"][known], columns["p2"][known]), True
            return
        groups = list(combinations({name: columns[name] for name in self._built}, n))
        for places, values in _sample(groups, most):
            try:
                prepared = self._prepare(values)
                own = {name: column[places] for name, column in columns.items() if name not in self._built}
                own = own if prepared.derive is None else prepared.derive(own)
            except ValueError:
                continue
            for inner, impact, is_own in _impacts(prepared, own, places.size, tick, most):
                there = places[inner]
                outputs = {name: column[there] for name, column in found.items()}
                report = numbers(impact.contact, **outputs, velocity=impact.velocity, mass=impact.mass)
                yield there, report, is_own

    def _prepare(self, values: dict[str, Any]) -> Prepared:
        # Objects come from lists that live as long as the sweep: their identity is theirs alone.
        key = tuple(value if isinstance(value, float) else id(value) for value in values.values())
        known = self._remembered.get(key)
        if known is None:
            known = self._template.prepare(values)
            if len(self._remembered) >= _MOST_REMEMBERED:
                self._remembered.clear()
            self._remembered[key] = known
        return known


def _sample(groups: list[Any], most: int | None) -> list[Any]:
    """Return at most so many groups, spread evenly over all."""
    if most is None or len(groups) <= most:
        return groups
    return [groups[n] for n in np.linspace(0.0, len(groups) - 1.0, most).astype(int)]


def _impacts(
    prepared: Prepared, columns: Columns, n: int, tick: Tick, most: int | None
) -> Iterator[tuple[Places, Impact, bool]]:
    """Impacts of one pair of materials each, with arrays of all other numbers, and whether the materials are theirs."""
    impact, names = prepared.impact, profile_names(prepared.impact)
    columns = _without_p3(impact, columns, names)
    arrays = {*BODY, *(names if impact.profile.path_exponent is not None else ())}
    materials = list(combinations({k: v for k, v in columns.items() if k not in arrays}, n))
    sample = _sample(materials, most)
    groups = [(places, values, True) for places, values in sample]
    if len(sample) < len(materials):
        rest = np.setdiff1d(np.arange(n), np.concatenate([places for places, _ in sample]))
        shapes = combinations({k: v[rest] for k, v in columns.items() if k in names and k not in arrays}, rest.size)
        groups += [(rest[places], values, False) for places, values in _sample(list(shapes), most)]
    for places, values, is_own in groups:
        tick(0)
        own = {name: column[places] for name, column in columns.items() if name in arrays} | {
            name: value for name, value in values.items() if name in names
        }
        try:
            material = {name: value for name, value in values.items() if name not in names}
            changed = changed_impact(impact, material, prepared.held)
            shape = {name: own.pop(name) for name in names if name in own}
            profile: Any = changed.profile
            yield places, replace(changed, profile=replace(profile, **shape), **own), is_own
        except ValueError:
            continue


def _without_p3(impact: Impact, columns: Columns, names: tuple[str, ...]) -> Columns:
    """Columns with the viscosity of the branch in place of p3, which depends on the body; as given for no parabola."""
    if "p3" not in columns or impact.profile.path_exponent != 1.0 or "exponent" in columns:
        return columns
    profile: Any = impact.profile
    profile = replace(profile, **{name: columns[name] for name in names if name in columns})
    mass, velocity = (columns.get(name, getattr(impact, name)) for name in ("mass", "velocity"))
    modulus = columns.get("equilibrium_modulus", impact.material.shear.equilibrium_modulus)
    if "equilibrium_modulus" not in columns and "material" in columns:
        modulus = np.array([material.shear.equilibrium_modulus for material in columns["material"]])
    unit = viscosity_unit(modulus, mass, velocity, profile.path_coefficient**2)
    return {name: column for name, column in columns.items() if name != "p3"} | {"viscosity": columns["p3"] * unit}


def _parts(prepared: Prepared, columns: Columns, n: int, tick: Tick, *, strict: bool) -> Iterator[Part]:
    """Parts of the impacts that differ from one by columns."""
    impact = prepared.impact
    plain: Any = impact.profile
    mass, velocity, force = (columns[name] if name in columns else np.full(n, getattr(impact, name)) for name in BODY)
    own = profile_names(impact)
    shape = {name: column for name, column in columns.items() if name in own}
    material = {name: column for name, column in columns.items() if name not in (*BODY, *own)}
    exponent = impact.profile.path_exponent
    if exponent is None or "exponent" in shape:
        for places, values in combinations({**shape, **material}, n):
            tick(0)
            try:
                profile: Any = replace(plain, **{name: values[name] for name in shape})
                changed = changed_impact(impact, {name: values[name] for name in material}, prepared.held)
            except ValueError:
                if strict:
                    raise
                continue
            numbers = {"mass": mass[places], "velocity": velocity[places], "external_force": force[places]}
            yield places, Batch.from_impact(replace(changed, profile=profile, **numbers))
        return
    profile = replace(plain, **shape) if shape else plain
    coefficient = np.broadcast_to(np.asarray(profile.path_coefficient, dtype=np.float64), (n,))
    bodies = Bodies(mass, velocity, coefficient**2 if exponent == 1.0 else None)
    for places, series in material_rows(impact, material, prepared.held, bodies, tick, strict=strict):
        bodies_there = mass[places], velocity[places], force[places]
        yield places, Batch(*series, *bodies_there, coefficient[places], float(exponent))  # pyright: ignore[reportArgumentType]
