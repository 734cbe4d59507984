"""What a sweep varies: an impact, or a function that builds one, of which axes set quantities."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass, fields
from difflib import get_close_matches
from typing import Any, Protocol

from restitution.contact.profile import Parabola
from restitution.errors import InputError
from restitution.impact.problem import Impact
from restitution.material.classical import standard_solid
from restitution.quantities import BODY
from restitution.sweeps.materials import MATERIAL_NAMES, Columns, HeldElastic, check_names


@dataclass(frozen=True)
class Prepared:
    """An impact whose remaining quantities are set by columns of numbers.

    Attributes
    ----------
    impact : Impact
        The impact.
    derive : callable, optional
        Turns columns into those of quantities that an impact has, such as a density into a mass.
    held : {"bulk_modulus", "poisson_ratio"}
        What stays where an axis changes the shear modulus at equilibrium.
    """

    impact: Impact
    derive: Callable[[Columns], Columns] | None = None
    held: HeldElastic = "bulk_modulus"


class Template(Protocol):
    """What a sweep varies."""

    @property
    def dimensionless(self) -> bool:
        """Whether its bodies have no dimensions, so that only the Poisson ratio can be checked."""
        ...

    def builds_with(self, names: tuple[str, ...]) -> tuple[str, ...]:
        """Return those of the names whose every combination needs an impact of its own.

        Raises
        ------
        ValueError
            If one of the names cannot be set.
        """
        ...

    def prepare(self, values: dict[str, Any]) -> Prepared:
        """Return the impact for one combination of these.

        Raises
        ------
        ValueError
            If it is not admissible.
        """
        ...


@dataclass(frozen=True)
class ImpactTemplate:
    """An impact, of which axes set numbers of the body, the profile and the material.

    Attributes
    ----------
    impact : Impact
        A single impact.
    held : {"bulk_modulus", "poisson_ratio"}
        What stays where an axis changes the shear modulus at equilibrium.
    dimensionless : bool
        Whether its body has no dimensions, so that only the Poisson ratio can be checked.
    """

    impact: Impact
    held: HeldElastic = "bulk_modulus"
    dimensionless: bool = False

    def __post_init__(self) -> None:
        if self.impact.shape:
            raise ValueError(f"base: has shape {self.impact.shape}; must be a single impact, axes make the others")

    def builds_with(self, names: tuple[str, ...]) -> tuple[str, ...]:
        """Return no name: columns set all."""
        check_columns(self.impact, names)
        return ()

    def prepare(self, values: dict[str, Any]) -> Prepared:
        """Return the impact."""
        return Prepared(self.impact, held=self.held)


@dataclass(frozen=True)
class BuilderTemplate:
    """A function that builds an impact from values of axes, by the names of its arguments.

    Attributes
    ----------
    build : callable
        Takes one value of each of its axes by name; returns an `Impact`.
    held : {"bulk_modulus", "poisson_ratio"}
        What stays where an axis changes the shear modulus at equilibrium.
    """

    build: Callable[..., Impact]
    held: HeldElastic = "bulk_modulus"
    dimensionless = False

    def builds_with(self, names: tuple[str, ...]) -> tuple[str, ...]:
        """Return the names of the function's arguments; all where it takes any keyword."""
        parameters = inspect.signature(self.build).parameters.values()
        if any(one.kind is one.VAR_KEYWORD for one in parameters):
            return names
        check_names(tuple(name for name in names if all(name != one.name for one in parameters)))
        for one in parameters:
            if one.default is one.empty and one.name not in names:
                raise InputError("axes", wanted=f"must have {one.name!r}, which the function takes")
        return tuple(one.name for one in parameters if one.name in names)

    def prepare(self, values: dict[str, Any]) -> Prepared:
        """Build the impact."""
        impact = self.build(**values)
        if not isinstance(impact, Impact):
            raise TypeError(f"base: returned {impact!r}; must return an Impact")
        if impact.shape:
            raise TypeError(f"base: returned an impact of shape {impact.shape}; must return a single one")
        return Prepared(impact, held=self.held)


def dimensionless_template() -> ImpactTemplate:
    """Impact of mass, radius, velocity and equilibrium modulus 1: axes set nu, p2, p3."""
    solid = standard_solid(1.0, 1.0, 1.0, poisson_ratio=0.5)
    return ImpactTemplate(Impact(solid, Parabola(1.0), mass=1.0, velocity=1.0), dimensionless=True)


def check_columns(impact: Impact, names: tuple[str, ...]) -> None:
    """Refuse quantities that columns cannot set, or set twice.

    Raises
    ------
    ValueError
        If the impact has no such quantity, or two of them set the same thing.
    """
    known = (*BODY, *profile_names(impact), *MATERIAL_NAMES)
    for name in names:
        if name not in known and name.partition("[")[0] not in MATERIAL_NAMES:
            close = get_close_matches(name, known, 1)
            advice = f"did you mean {close[0]}?" if close else f"known are {', '.join(known)}"
            raise InputError("axes", wanted=f"the impact has no {name!r}; {advice}")
    check_names(names)


def profile_names(impact: Impact) -> tuple[str, ...]:
    """Names of the numbers of a profile."""
    profile: Any = impact.profile
    return tuple(field.name for field in fields(profile) if isinstance(getattr(profile, field.name), float))
