"""The problem: one body hits another, normally and without friction."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from restitution import quantities
from restitution.checks import Numeric
from restitution.contact.contact import Contact
from restitution.contact.profile import Profile
from restitution.errors import InputError
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material

STANDARD_GRAVITY = 9.80665
"""Standard acceleration of free fall [m/s2]."""


@dataclass(frozen=True, eq=False)
class Impact:
    """Normal impact of a body on a viscoelastic half-space, in SI units.

    Numbers may be arrays that broadcast against each other, those of a power-type profile included: the results then
    are arrays of the common shape.

    Parameters
    ----------
    material : Material
        Material of the half-space.
    profile : Profile
        Profile of the indenting body, such as `Parabola(radius)`; for two curved bodies that of the gap between them.
    mass : float or array
        Mass m [kg], > 0; of two free bodies the reduced mass.
    velocity : float or array
        Impact velocity v0 [m/s], > 0; of two bodies their relative velocity.
    counter_material : Material, optional
        Material of the indenting body; rigid where left out. The compliances of both add.
    external_force : float or array
        Constant force [N] that presses the body on during contact, such as its weight m g; >= 0.

    Raises
    ------
    InputError
        If a number is out of its range, or a material or the profile of another type.

    Notes
    -----
    Quasi-static, frictionless, adhesionless, small strain, half-space; `ImpactResult.validity` compares these
    assumptions with the numbers of the impact.

    Examples
    --------
    >>> from restitution.contact.profile import Parabola
    >>> from restitution.material.classical import standard_solid
    >>> rubber = standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
    >>> Impact(material=rubber, profile=Parabola(radius=0.01), mass=0.005, velocity=[0.5, 1.0]).shape
    (2,)
    """

    material: Material
    profile: Profile
    mass: Numeric
    velocity: Numeric
    counter_material: Material | None = field(default=None, kw_only=True)
    external_force: Numeric = field(default=0.0, kw_only=True)

    def __post_init__(self) -> None:
        _ = self.contact
        for name in quantities.BODY:
            object.__setattr__(self, name, quantities.check(name, getattr(self, name)))
        try:
            _ = self.shape
        except ValueError:
            shapes = {name: np.shape(getattr(self, name)) for name in quantities.BODY}
            shapes["profile"] = _profile_shape(self.profile)
            listed = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
            raise InputError(
                ", ".join(shapes), wanted=f"have shapes that do not broadcast against each other: {listed}"
            ) from None

    @cached_property
    def contact(self) -> Contact:
        """The profile and the materials of both bodies."""
        return Contact(self.material, self.profile, self.counter_material)

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Common shape of all numbers; () for a single impact."""
        numbers = (np.shape(getattr(self, name)) for name in quantities.BODY)
        return np.broadcast_shapes(*numbers, _profile_shape(self.profile))

    @property
    def reduced_modulus(self) -> PronySeries:
        """Reduced relaxation modulus E*(t) [Pa] of the contact."""
        return self.contact.reduced_modulus


def _profile_shape(profile: Profile) -> tuple[int, ...]:
    exponent, coefficient = profile.path_exponent, profile.path_coefficient
    if exponent is None or coefficient is None:
        return ()
    return np.broadcast_shapes(np.shape(exponent), np.shape(coefficient))
