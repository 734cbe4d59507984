"""The contact of an indenter with a target: the geometry and the materials of both bodies."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import Any

from restitution.checks import Numeric, single_positive
from restitution.contact.geometry import Geometry
from restitution.errors import InputTypeError, RestitutionWarning
from restitution.material.fractional import FractionalMaterial
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, reduced_modulus

BALL_ON_TARGET = (inf, 2.0)
"""Diameters of a flat target and of a ball over the radius of the profile."""


@dataclass(frozen=True)
class Contact:
    """Frictionless contact of an indenter with a viscoelastic half-space, or another target.

    Parameters
    ----------
    material : Material
        Material of the target.
    profile : Geometry
        Profile of the indenter of a half-space, or another geometry, such as a layer; for two curved bodies that of
        the gap between them.
    counter_material : Material, optional
        Material of the indenter; rigid if left out. The compliances of both bodies add.
    body_size : float, optional
        Smallest dimension of the half-space [m], which is no half-space then; only the validity report uses it.
    diameters : tuple
        Diameters of the bodies of `material` and `counter_material` over the radius of a round profile; infinite for
        a flat target. Only the validity report uses it. By default the indenter is a ball.

    Raises
    ------
    InputError
        If a material or the profile is of another type, or the geometry does not hold for the materials.

    Examples
    --------
    >>> from restitution.contact.profile import Parabola
    >>> contact = Contact(Material(1e6, 1e9), Parabola(radius=0.01))
    >>> print(round(contact.reduced_modulus.equilibrium_modulus))
    3996005
    """

    material: Material
    profile: Geometry
    counter_material: Material | None = None
    body_size: float | None = None
    diameters: tuple[Numeric, Numeric] = BALL_ON_TARGET

    def __post_init__(self) -> None:
        of_type("material", self.material, Material)
        of_type("profile", self.profile, Geometry)
        if self.counter_material is not None:
            of_type("counter_material", self.counter_material, Material)
        object.__setattr__(self, "profile", self.profile.between(self.material, self.counter_material))
        if self.body_size is not None:
            object.__setattr__(self, "body_size", single_positive("body_size", self.body_size, "m"))

    @property
    def materials(self) -> tuple[Material, ...]:
        """Materials of the bodies that deform."""
        return (self.material,) if self.counter_material is None else (self.material, self.counter_material)

    @cached_property
    def reduced_modulus(self) -> PronySeries:
        """Reduced relaxation modulus E*(t) [Pa]; the profile has effective ones where it is not separable."""
        return reduced_modulus(self.material, self.counter_material)

    @property
    def is_exact(self) -> bool:
        """Whether the theory is exact for the materials: contacts of all sizes, or the only one, have one modulus."""
        return self.profile.separable or self.profile.path_exponent == 0.0

    def warn_if_approximate(self, kind: str = "separability") -> None:
        """Warn the caller of a function if the theory is not exact for the materials."""
        if not self.is_exact:
            text = approximation(self.material.instantaneous_poisson_ratio, self.material.poisson_ratio)
            warnings.warn(RestitutionWarning(kind, f"{kind}: {'. '.join(text)}"), stacklevel=3)

    @property
    def window(self) -> tuple[float, float] | None:
        """First and last time [s] between which the materials of both bodies are valid; None without a limit."""
        windows = [material.window for material in self.materials if material.window is not None]
        if not windows:
            return None
        return max(low for low, _ in windows), min(high for _, high in windows)


def approximation(instantaneous: float, static: float) -> tuple[str, str]:
    """Why a contact is not exact, by the Poisson ratios of its material, and what to expect of the results."""
    text = f"the Poisson ratio relaxes from {instantaneous:.3g} to {static:.3g}, and a bonded layer is approximate "
    return f"{text}then", "Expect errors of some 0.5 % of e, 4 % of the contact time and 10 % of the force."


def of_type(name: str, value: Any, kind: type) -> None:
    """Refuse what is not of the type, with the remedy for a fractional material."""
    if isinstance(value, FractionalMaterial):
        wanted = f"a fractional material holds within a window of time: {name}.within(window), or for_contact"
        raise InputTypeError(name, wanted=wanted)
    if not isinstance(value, kind):
        raise InputTypeError(name, value, f"must be a {kind.__name__}")
