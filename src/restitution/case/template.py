"""A case file of which axes set keys, as the template of a sweep."""

from __future__ import annotations

import copy
import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from restitution.case.quantity import LIST
from restitution.case.schema import CaseFile
from restitution.case.section import CaseError, explain
from restitution.sweeps.description import describe
from restitution.sweeps.template import Prepared, check_columns, profile_names

_ENTRY = re.compile(r"(.+)\[(\d+)\]")


@dataclass(frozen=True)
class CaseTemplate:
    """A case file of which axes set keys.

    Attributes
    ----------
    path : Path
        The file, for messages.
    folder : Path
        The folder that names of further files start from.
    data : dict
        Its content, complete with the first values of the axes.
    keys : tuple of str
        Places of the keys of which every combination of values takes an impact of its own.
    columns : tuple of str
        Quantities that columns of numbers set.
    """

    path: Path
    folder: Path
    data: dict[str, Any]
    keys: tuple[str, ...]
    columns: tuple[str, ...]

    def builds_with(self, names: tuple[str, ...]) -> tuple[str, ...]:
        """Return the names whose every combination needs an impact of its own."""
        return tuple(name for name in names if name in self.keys)

    def prepare(self, values: dict[str, Any]) -> Prepared:
        """Build the impact of the file with these values."""
        case = self._case(values)
        try:
            impact = case.build()
            derived = Derivation(case, profile_names(impact))
            check_columns(impact, tuple(derived({name: np.ones(1) for name in self.columns})))
        except ValueError as error:
            raise CaseError(f"{self.path}: {error}") from None
        held = "bulk_modulus" if getattr(case.material, "poisson_ratio", None) is None else "poisson_ratio"
        return Prepared(impact, derived, held)

    def describe(self) -> Any:
        """What the file says, in SI."""
        case = self._case({}).model_dump(exclude={"title", "solver"}, exclude_none=True)
        return {"case": describe(case), "keys": list(self.keys), "columns": list(self.columns)}

    def _case(self, values: dict[str, Any]) -> CaseFile:
        data = self.data
        if values:
            data = copy.deepcopy(data)
            for place, value in values.items():
                put(data, place, value)
        try:
            return CaseFile.model_validate(data, context={"folder": self.folder})
        except ValidationError as error:
            raise CaseError(explain(self.path, data, error)) from None


@dataclass(frozen=True)
class Derivation:
    """From what a case file has to what an impact has: mass from density, velocity from height, weight.

    Attributes
    ----------
    case : CaseFile
        The file.
    own : tuple of str
        Numbers of the profile.
    """

    case: CaseFile
    own: tuple[str, ...]

    def __call__(self, columns: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
        """Derive columns."""
        body, impact = self.case.body, self.case.impact
        derived: dict[str, Any] = dict(columns)
        radius = derived.get("radius", body.radius)
        if not (self.case.profile.needs_body_radius and "radius" in self.own):
            derived.pop("radius", None)
        density = derived.pop("density", body.density)
        if density is not None and "mass" not in columns and {"density", "radius"} & columns.keys():
            derived["mass"] = density * (4.0 / 3.0 * math.pi) * np.asarray(radius) ** 3
        gravity = derived.pop("gravity", impact.gravity)
        height = derived.pop("drop_height", impact.drop_height)
        if height is not None and {"drop_height", "gravity"} & columns.keys():
            derived["velocity"] = np.sqrt(2.0 * gravity * height)
        if impact.weight and ("mass" in derived or "gravity" in columns):
            derived["external_force"] = derived.get("mass", body.kilograms) * gravity
        return derived


def put(case: dict[str, Any], place: str, value: Any) -> None:
    """Set the value at a place, such as `material.shear.relaxation_times[2]`."""
    *tables, key = place.split(".")
    target: Any = case
    for name in tables:
        target = target.setdefault(name, {})
        if not isinstance(target, dict):
            raise ValueError(f"{name} is no table")
    match = _ENTRY.fullmatch(key)
    if match is None:
        target[key] = value
        return
    items, entry = LIST.func(target.get(match[1])), int(match[2])  # pyright: ignore[reportCallIssue]
    if not isinstance(items, list) or entry >= len(items):
        raise ValueError(f"there is no such entry of {match[1]}")
    target[match[1]] = [*items[:entry], value, *items[entry + 1 :]]
