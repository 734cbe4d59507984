"""The door from named numbers to impacts: sweeps, maps and files change an impact by the names of its numbers."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from difflib import get_close_matches
from typing import Any, Literal, TypeGuard

import numpy as np

from restitution.axes import aligned, named
from restitution.checks import finite, instance, mapping, one_of
from restitution.contact.adhesion import Adhesion
from restitution.errors import InputError
from restitution.impact.problem import Impact, directed
from restitution.impact.scaling import viscosity_unit
from restitution.material.conversion import bulk_from_poisson_ratio
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material
from restitution.quantities import ADHESION_INPUTS, ALIASES, BODY, INPUTS, SLIDING, key_of

HeldElastic = Literal["bulk_modulus", "poisson_ratio"]

MATERIALS = ("material", "counter_material")
_OF_ONE_BRANCH = ("branch_modulus", "viscosity", "relaxation_time", "p2")
_OF_MATERIAL = ("equilibrium_modulus", *_OF_ONE_BRANCH, "poisson_ratio", "bulk_modulus", "p3")
_LISTS = ("branch_moduli", "relaxation_times")
MATERIAL_NAMES = (*MATERIALS, *_OF_MATERIAL, "temperature", *_LISTS)
"""Names of the numbers of a material; the last two have the number of the branch, as in `relaxation_times[0]`."""

_RIVALS = (
    ("branch_modulus", "branch_moduli[0]", "p2"),
    ("viscosity", "relaxation_time", "relaxation_times[0]", "p3"),
    ("poisson_ratio", "bulk_modulus"),
    ("tangential_velocity", "angle"),
    ("tangential_velocity", "speed"),
    ("velocity", "speed"),
    ("stress", "range"),
)
_DIRECTION = ("angle", "speed")
_PLACE = re.compile(r"(branch_moduli|relaxation_times)\[(0|[1-9]\d*)\]")


def vary(impact: Impact, numbers: Mapping[str, Any], *, held: HeldElastic = "bulk_modulus") -> Impact:
    """Return an impact with other numbers by name.

    Parameters
    ----------
    impact : Impact
        The impact, single or an array.
    numbers : dict of str to float, array or DataArray
        Numbers in SI by name: of the impact (`velocity`, `mass`, `external_force`, `impedance`), of its tangential
        motion (`friction`, `tangential_velocity`, `spin`, `gyration`, `angle`, `speed`), of its adhesion (`work`,
        `stress`, `range`), of its geometry (`radius`, `half_angle`, `thickness`), of its material (`poisson_ratio` or
        `nu`, `bulk_modulus`, `equilibrium_modulus`, `branch_modulus`, `viscosity`, `relaxation_time`,
        `branch_moduli[0]`, `relaxation_times[0]`, `temperature`, `p2`, `p3`), and the materials themselves
        (`material`, `counter_material`). Arrays broadcast against each other and against the impact; DataArrays by
        name.
    held : {"bulk_modulus", "poisson_ratio"}
        Which of the two stays constant where `equilibrium_modulus` changes.

    Returns
    -------
    Impact
        An array in the common shape.

    Raises
    ------
    InputError
        If a name is not known, two names set the same, or a number is out of range.

    Notes
    -----
    `branch_modulus` and `p2` keep the viscosity, `relaxation_time` and `viscosity` the branch modulus.
    `branch_moduli[k]` and `relaxation_times[k]` keep each other. `angle` keeps the normal velocity, or with `speed`
    the speed; `speed` alone keeps the angle. `stress` and `range` keep the work of adhesion, and `work` keeps the
    stress or the range that the adhesion states; it gives a range of 0.4 nm to an impact without adhesion.

    Examples
    --------
    >>> import restitution as rs
    >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
    >>> ball = rs.Impact(rubber, rs.Parabola(0.01), mass=0.005, velocity=0.1)
    >>> several = vary(ball, {"viscosity": [1e3, 2e3, 4e3], "radius": 0.02})
    >>> several.shape, several.profile.radius
    ((3,), 0.02)
    """
    instance("impact", impact, Impact, "must be an Impact")
    one_of("held", held, ("bulk_modulus", "poisson_ratio"))
    values = {ALIASES.get(name, name): value for name, value in mapping("numbers", numbers).items()}
    check_names(impact, tuple(values), "numbers")
    values, axes = aligned({"impact": impact, **values})
    impact = values.pop("impact")
    for name, value in values.items():
        if name in MATERIALS:
            instance(name, value, Material, "must be a Material")
        else:
            quantity = INPUTS.get(key_of(name))
            values[name] = finite(name, value) if quantity is None else quantity.check(value, name)
    return named(varied(impact, values, held), axes)


def check_names(impact: Impact, names: Iterable[str], field: str = "axes") -> None:
    """Refuse names that are no numbers of the impact, or that set the same one."""
    entries = (f"{name}[0]" for name in _LISTS)
    bodies = *BODY, *SLIDING, *_DIRECTION, *ADHESION_INPUTS, *numbers_of(impact)
    choices = *bodies, *MATERIALS, *_OF_MATERIAL, "temperature", *entries
    for name in names:
        if name not in choices and not _PLACE.fullmatch(name):
            close = get_close_matches(name, choices, 1)
            advice = f"did you mean {close[0]}?" if close else f"known are {', '.join(choices)}"
            raise InputError(field, rule=f"the impact has no {name!r}; {advice}")
    check_rivals(names, field)


def check_rivals(names: Iterable[str], field: str = "axes") -> None:
    """Refuse names that set the same constant of a material."""
    for rivals in _RIVALS:
        both = [name for name in names if name in rivals]
        if len(both) > 1:
            raise InputError(field, rule=f"{' and '.join(both)} set the same; leave all but one out")


def numbers_of(impact: Impact) -> tuple[str, ...]:
    """Return the names of the numbers of a geometry, apart from those that are the material's."""
    return tuple(name for name in impact.profile.numbers if name not in MATERIAL_NAMES)


def varied(impact: Impact, values: Mapping[str, Any], held: HeldElastic = "bulk_modulus") -> Impact:
    """Return an impact with other numbers in SI by name, which are not checked but for their ranges; see `vary`."""
    parts: dict[str, Any] = {name: values[name] for name in (*MATERIALS, *BODY, *SLIDING) if name in values}
    if direction := {name: values[name] for name in _DIRECTION if name in values}:
        normal = parts.get("velocity", impact.velocity)
        angle = direction.get("angle", np.arctan2(impact.tangential_velocity, impact.velocity))
        parts["velocity"], parts["tangential_velocity"] = directed(normal, angle, direction.get("speed"))
    if attraction := {name: values[name] for name in ADHESION_INPUTS if name in values}:
        parts["adhesion"] = _attracted(impact.adhesion, attraction)
    geometry = {name: values[name] for name in numbers_of(impact) if name in values}
    parts["profile"] = profile = impact.profile.changed(geometry) if geometry else impact.profile
    material, counter = parts.get("material", impact.material), parts.get("counter_material", impact.counter_material)
    done = {*parts, *geometry, *direction, *attraction}
    numbers = {name: value for name, value in values.items() if name not in done}
    if "p3" in numbers:
        if counter is not None or np.any(profile.path_exponent != 1.0) or not is_standard_solid(material):
            raise InputError("axes", rule="p3 belongs to a rigid parabola on a standard solid, which this is not")
        modulus = numbers.get("equilibrium_modulus", material.shear.equilibrium_modulus)
        mass, velocity = (parts.get(name, getattr(impact, name)) for name in ("mass", "velocity"))
        radius: Any = np.asarray(profile.path_coefficient) ** 2
        numbers["viscosity"] = numbers.pop("p3") * viscosity_unit(modulus, mass, velocity, radius[()])
    temperature = numbers.pop("temperature", None)
    if numbers:
        material = _changed(material, numbers, held)
    if temperature is not None:
        alone = counter is None or counter.shift is None
        counter = counter if counter is None or alone else counter.at(temperature)
        material = material.at(temperature) if alone or material.shift is not None else material
    return replace(impact, **parts | {"material": material, "counter_material": counter})


def _attracted(adhesion: Adhesion | None, numbers: Mapping[str, Any]) -> Adhesion:
    """Return an adhesion with other numbers; a work makes one where there is none."""
    if adhesion is not None:
        return adhesion.changed(numbers)
    if "work" not in numbers:
        raise InputError("axes", rule=f"{min(numbers)} belongs to an impact with adhesion; give work too")
    return Adhesion(**numbers)


def numbers_by_name(impact: Impact, names: Iterable[str], field: str = "names") -> dict[str, Any]:
    """Return the numbers of an impact by the names that `vary` takes, in the order of the names.

    Raises
    ------
    InputError
        If a name is not known or is that of a material, two names set the same, or the material has no such number.

    Examples
    --------
    >>> import restitution as rs
    >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
    >>> ball = rs.Impact(rubber, rs.Parabola(0.01), mass=0.005, velocity=0.1)
    >>> print(*numbers_by_name(ball, ["radius", "viscosity"]).values())
    0.01 1000.0
    """
    chosen = [ALIASES.get(name, name) for name in names]
    check_names(impact, chosen, field)
    for name in chosen:
        if name in (*MATERIALS, *_LISTS):
            raise InputError(field, name, "must be the name of a number, such as velocity or branch_moduli[0]")
    return {name: _number(impact, name) for name in chosen}


def _number(impact: Impact, name: str) -> Any:
    """Return one number of an impact by its name."""
    if name in (*BODY, *SLIDING):
        if (value := getattr(impact, name)) is None:
            raise InputError("names", name, "must be known: the impact has none")
        return value
    if name in ADHESION_INPUTS:
        if impact.adhesion is None:
            raise InputError("names", name, "must be known: the impact has no adhesion")
        return getattr(impact.adhesion, name)
    if name in _DIRECTION:
        both = impact.tangential_velocity, impact.velocity
        return np.arctan2(*both) if name == "angle" else np.hypot(*both)
    if name in (geometry := impact.profile.numbers) and name not in MATERIAL_NAMES:
        return geometry[name]
    material, shear = impact.material, impact.material.shear
    if name in ("equilibrium_modulus", "poisson_ratio", "temperature"):
        value = getattr(shear if name == "equilibrium_modulus" else material, name)
        if value is None:
            raise InputError("names", name, "must be known: the material has none")
        return value
    if name == "bulk_modulus":
        return material.bulk.equilibrium_modulus if isinstance(material.bulk, PronySeries) else material.bulk
    if match := _PLACE.fullmatch(name):
        values: Any = getattr(shear, match[1])
        if int(match[2]) >= shear.n_branches:
            raise InputError("names", name, f"must be one of {shear.n_branches} branches of the material")
        return values[..., int(match[2])][()]
    if shear.n_branches != 1:
        rule = f"must be of one branch, here there are {shear.n_branches}; use branch_moduli[0] and so on"
        raise InputError("names", name, rule)
    modulus, time = shear.branch_moduli[..., 0], shear.relaxation_times[..., 0]
    branch: dict[str, Any] = {"branch_modulus": modulus, "relaxation_time": time, "viscosity": modulus * time}
    if name == "p3":
        radius: Any = np.asarray(impact.profile.path_coefficient) ** 2
        unit = viscosity_unit(shear.equilibrium_modulus, impact.mass, impact.velocity, radius[()])
        return (branch["viscosity"] / unit)[()]
    return branch[name][()] if name in branch else (shear.equilibrium_modulus / modulus)[()]


def is_standard_solid(material: Material) -> bool:
    """Return whether materials have one branch, no dashpot in parallel, and a constant bulk modulus."""
    shear = material.shear
    return shear.n_branches == 1 and not np.any(shear.parallel_viscosity) and not _relaxes(material.bulk)


def _relaxes(bulk: PronySeries | float) -> TypeGuard[PronySeries]:
    return isinstance(bulk, PronySeries) and bool(bulk.branch_moduli.any() or np.any(bulk.parallel_viscosity))


def _changed(material: Material, values: dict[str, Any], held: HeldElastic) -> Material:
    """Return a material with other constants."""
    shear, bulk = material.shear, material.bulk
    equilibrium: Any = values.get("equilibrium_modulus", shear.equilibrium_modulus)
    bulk_modulus = values.get("bulk_modulus")
    if "poisson_ratio" in values:
        bulk_modulus = bulk_from_poisson_ratio(equilibrium, values["poisson_ratio"])
    elif held == "poisson_ratio" and bulk_modulus is None and "equilibrium_modulus" in values:
        bulk_modulus = bulk_from_poisson_ratio(equilibrium, material.poisson_ratio)
    moduli, times = _branches(shear, values, equilibrium)
    return replace(
        material,
        shear=PronySeries(equilibrium, moduli, times, parallel_viscosity=shear.parallel_viscosity),
        bulk=bulk if bulk_modulus is None else _scaled_bulk(bulk, bulk_modulus),
    )


def _branches(shear: PronySeries, values: dict[str, Any], equilibrium: Any) -> tuple[Any, Any]:
    """Return the moduli and the relaxation times of the branches, which are along the last axis."""
    count = shear.n_branches
    moduli: list[Any] = [shear.branch_moduli[..., n] for n in range(count)]
    times: list[Any] = [shear.relaxation_times[..., n] for n in range(count)]
    if any(name in values for name in _OF_ONE_BRANCH):
        if count != 1:
            why = f"branch_modulus, viscosity, relaxation_time and p2 are of one branch, here there are {count}"
            raise InputError("axes", rule=f"{why}; use branch_moduli[0], relaxation_times[0] and so on")
        # The series refuses numbers that overflow.
        with np.errstate(all="ignore"):
            viscosity = values.get("viscosity", moduli[0] * times[0])
            moduli[0] = values.get("branch_modulus", equilibrium / values["p2"] if "p2" in values else moduli[0])
            times[0] = values.get("relaxation_time", viscosity / moduli[0])
    for name, value in values.items():
        if match := _PLACE.fullmatch(name):
            target, place = (moduli if match[1] == "branch_moduli" else times), int(match[2])
            if place >= count:
                raise InputError("axes", rule=f"there is no {name}; the material has {count} branches")
            target[place] = value
    if not count:
        return (), ()
    columns = np.stack(np.broadcast_arrays(*moduli, *times), axis=-1)
    return columns[..., :count], columns[..., count:]


def _scaled_bulk(bulk: PronySeries | float, modulus: Any) -> Any:
    """Return the bulk relaxation with another equilibrium modulus and the same normalised relaxation."""
    rigid = np.isinf(modulus)
    if not _relaxes(bulk) or rigid.all():
        return modulus
    if np.any(bulk.equilibrium_modulus == 0.0):
        why = "bulk_modulus and poisson_ratio need a bulk modulus at equilibrium, which is 0 Pa"
        raise InputError("axes", rule=why)
    soft = bulk.scaled(np.where(rigid, 1.0, modulus)[()] / bulk.equilibrium_modulus)
    if not rigid.any():
        return soft
    springs, dashpots = (
        np.where(rigid, np.inf, soft.equilibrium_modulus),
        np.where(rigid, 0.0, soft.parallel_viscosity),
    )
    moduli = np.where(rigid[..., None], 0.0, soft.branch_moduli)
    return PronySeries.from_checked(springs, moduli, soft.relaxation_times, dashpots)
