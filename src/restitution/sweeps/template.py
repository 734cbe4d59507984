"""What a sweep varies: an impact, a function that builds impacts, or the paper's problem without dimensions."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from restitution.contact.profiles import Parabola
from restitution.errors import InputError, InputTypeError
from restitution.impact.problem import Impact
from restitution.material.classical import standard_solid
from restitution.variation import HeldElastic, check_names, check_rivals, varied


class Prepared(Protocol):
    """A single impact whose numbers may become arrays."""

    @property
    def impact(self) -> Impact:
        """The impact itself."""
        ...

    def varied(self, values: dict[str, Any]) -> Impact:
        """Return the impact with other numbers in SI, which broadcast."""
        ...


@dataclass(frozen=True)
class PreparedImpact:
    """An impact, and what stays constant while an axis changes the equilibrium shear modulus."""

    impact: Impact
    held: HeldElastic

    def varied(self, values: dict[str, Any]) -> Impact:
        return varied(self.impact, values, self.held)


class Template(Protocol):
    """What a sweep varies."""

    @property
    def dimensionless(self) -> bool:
        """Whether the bodies are dimensionless, so that only the Poisson ratio can be checked."""
        ...

    def builds_with(self, names: tuple[str, ...]) -> tuple[str, ...]:
        """Return the names whose combinations need a separate impact each; refuse unknown names."""
        ...

    def prepare(self, values: dict[str, Any]) -> Prepared:
        """Return the impact for one combination of their values, or raise an `InputError`."""
        ...


@dataclass(frozen=True)
class ImpactTemplate:
    """A single impact; axes set numbers of the body, the profile and the material."""

    impact: Impact
    held: HeldElastic = "bulk_modulus"
    dimensionless: bool = False

    def __post_init__(self) -> None:
        if self.impact.shape:
            rule = f"has shape {self.impact.shape}; must be a single impact, axes make the others"
            raise InputError("base", rule=rule)

    def builds_with(self, names: tuple[str, ...]) -> tuple[str, ...]:
        check_names(self.impact, names)
        return ()

    def prepare(self, values: dict[str, Any]) -> Prepared:
        return PreparedImpact(self.impact, self.held)


@dataclass(frozen=True)
class BuilderTemplate:
    """A function that builds a single impact from values of axes, by the names of its arguments."""

    build: Callable[..., Impact]
    held: HeldElastic = "bulk_modulus"
    dimensionless = False

    def builds_with(self, names: tuple[str, ...]) -> tuple[str, ...]:
        try:
            parameters = inspect.signature(self.build).parameters.values()
        except (TypeError, ValueError):  # some functions and types in C have no signature
            raise InputTypeError("base", self.build, "must be a function with named parameters") from None
        if any(each.kind is each.VAR_KEYWORD for each in parameters):
            return names
        check_rivals(tuple(name for name in names if all(name != each.name for each in parameters)))
        for each in parameters:
            if each.default is each.empty and each.name not in names:
                raise InputError("axes", rule=f"must have {each.name!r}, which the function takes")
        return tuple(each.name for each in parameters if each.name in names)

    def prepare(self, values: dict[str, Any]) -> Prepared:
        impact = self.build(**values)
        if not isinstance(impact, Impact):
            raise InputTypeError("base", rule=f"returned {impact!r}; must return an Impact")
        if impact.shape:
            rule = f"returned an impact of shape {impact.shape}; must return a single one"
            raise InputTypeError("base", rule=rule)
        return PreparedImpact(impact, self.held)


def dimensionless_template() -> ImpactTemplate:
    """Impact of mass, radius, velocity and equilibrium modulus 1; axes set nu, p2 and p3."""
    solid = standard_solid(1.0, 1.0, 1.0, poisson_ratio=0.5)
    return ImpactTemplate(Impact(solid, Parabola(1.0), mass=1.0, velocity=1.0), dimensionless=True)
