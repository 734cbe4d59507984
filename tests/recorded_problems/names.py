"""Public names: functions, classes, their members, and parameters with their defaults."""

from __future__ import annotations

import enum
import inspect
import math
import re
import warnings
from collections.abc import Iterator
from types import ModuleType
from typing import Any

import numpy as np

import restitution as rs


def signature(function: Any) -> str:
    """Parameters with their defaults, without annotations, which name modules."""
    try:
        result = inspect.signature(function)
    except (TypeError, ValueError):
        return "(...)"
    public = (item for name, item in result.parameters.items() if not name.startswith("_"))
    plain = [item.replace(annotation=inspect.Parameter.empty) for item in public]
    text = str(inspect.Signature(plain))
    return re.sub(r" at 0x[0-9a-f]+|restitution(\.\w+)+(?=\.\w)\.", "", text)


def foreign(member: str, owner: type) -> bool:
    """Whether a member comes from Python or another library."""
    for item in owner.__mro__:
        if member in item.__dict__ or member in inspect.get_annotations(item):
            return not item.__module__.startswith("restitution")
    return False


def of_class(item: type, instance: Any = None) -> Iterator[str]:
    """Public members of a class, or of an instance with its own attributes."""
    if issubclass(item, enum.Enum):
        yield from (f"{member.name} = {member.value!r}" for member in item)
    names = set(dir(item))
    names |= {name for base in item.__mro__ for name in inspect.get_annotations(base)}
    names |= set(getattr(instance, "__dict__", {}))
    for name in sorted(names):
        if (
            (name.startswith("_") and name != "__call__")
            or foreign(name, item)
            or (issubclass(item, enum.Enum) and name in item.__members__)
        ):
            continue
        member = inspect.getattr_static(item, name, None)
        is_method = callable(member) or isinstance(member, classmethod | staticmethod)
        yield name + (signature(getattr(item, name)) if is_method else "")


def results() -> dict[str, Any]:
    """Results whose classes have no public name, by the way to get them."""
    solid = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.5, density=1100.0)
    hit = rs.Impact(solid, rs.Parabola(0.01), 0.005, 0.1)
    result = rs.solve(hit)
    omega = np.geomspace(1e3, 1e5, 12)
    scatter = np.exp(0.01 * np.random.default_rng(1).standard_normal(12))
    shear = solid.shear
    table = rs.DynamicTable(
        omega, shear.storage_modulus(omega) * scatter, shear.loss_modulus(omega) * scatter, "shear"
    )
    fit = rs.identify(table, rs.standard_solid, fixed={"poisson_ratio": 0.5})
    mass = 7800.0 * 4.0 / 3.0 * math.pi * 0.01**3
    rebounds = rs.Rebounds([0.1, 0.2], [0.6, 0.55], radius=0.01, mass=mass, contact_time=[1e-3, 9e-4])
    candidates = {"velocity": [0.1, 1.0], "radius": [0.003, 0.01], "density": 7800.0}
    bead = rs.Body(solid, 0.001)
    law = rs.calibrate((bead, bead), "liggghts", velocity=(0.02, 0.2), points=5)
    return {
        "calibrate().parameters[]": next(iter(law.parameters.values())),
        "design()": rs.design(fit, candidates, n=4),
        "dimensionless_groups()": rs.dimensionless_groups(hit),
        "effective_moduli()": rs.effective_moduli(rebounds),
        "fit_prony()": rs.fit_prony(table),
        "identify().parameters[]": fit.parameters["viscosity"],
        "identify().uncertainty": fit.uncertainty,
        "identify().profile()": fit.profile("viscosity"),
        "identify.compare()": rs.identify.compare(  # type: ignore[attr-defined]
            table, [rs.standard_solid], fixed={"poisson_ratio": 0.5}, profiles=False
        ),
        "implied_loss_tangent()": rs.implied_loss_tangent(60.0),
        "resilience().standard": rs.resilience(solid).standard,
        "solve().energy": result.energy,
        "solve().summary()": result.summary(),
        "solve().validity.checks[]": result.validity.checks[0],
        "springpot()": rs.springpot(1e6, 0.3),
        "Impact().contact": hit.contact,
        "Material()": solid,
        "PronySeries()": shear,
        "Rebounds()": rebounds,
        "ShiftTable()": rs.ShiftTable([280.0, 300.0], [1.0, 0.0]),
        "Layer()": rs.Layer(rs.Parabola(0.01), 0.01),
        "Tabulated()": rs.Tabulated([0.0, 0.01, 0.02], [0.0, 5e-3, 2e-2]),
    }


def public_names() -> str:
    """All public names, one in each line."""
    lines: list[str] = []
    for name in sorted(rs.__all__):
        item = getattr(rs, name)
        if isinstance(item, ModuleType):
            lines.append(f"module {name}")
            for member, part in sorted(vars(item).items()):
                is_public = callable(part) and part.__module__.startswith(item.__name__)
                if is_public and not member.startswith("_"):
                    lines.append(f"    {member}{signature(part)}")
        elif isinstance(item, type):
            lines.append(f"class {name}" + ("" if issubclass(item, enum.Enum) else signature(item)))
            lines += [f"    {member}" for member in of_class(item)]
        else:
            lines.append(f"{name}{signature(item)}")
            lines += [f"    {part}{signature(getattr(item, part))}" for part in vars(item) if not part.startswith("_")]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rs.RestitutionWarning)
        result = results()
    for name, item in sorted(result.items()):
        lines.append(f"result {name}")
        lines += [f"    {member}" for member in of_class(type(item), item)]
    return "\n".join(lines) + "\n"
