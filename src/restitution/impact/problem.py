"""The problem: one body hits another, normally and without friction."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from restitution.checks import Numeric, nonnegative, positive
from restitution.contact.profile import Profile
from restitution.material.fractional import FractionalMaterial
from restitution.material.prony import PronySeries
from restitution.material.reduced_modulus import reduced_modulus
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
    ValueError
        If a number is out of its range; the message names it.
    TypeError
        If a material or a profile is something else.

    Notes
    -----
    Quasi-static, small strain, half-space: `ImpactResult.warnings` says where these are doubtful.

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
        _of_type("material", self.material, Material)
        _of_type("profile", self.profile, Profile)
        if self.counter_material is not None:
            _of_type("counter_material", self.counter_material, Material)
        object.__setattr__(self, "mass", positive("mass", self.mass, "kg"))
        object.__setattr__(self, "velocity", positive("velocity", self.velocity, "m/s"))
        object.__setattr__(self, "external_force", nonnegative("external_force", self.external_force, "N"))
        try:
            _ = self.shape
        except ValueError:
            shapes = {name: np.shape(getattr(self, name)) for name in ("mass", "velocity", "external_force")}
            raise ValueError(
                f"mass, velocity, external_force and profile: shapes {shapes} and {_profile_shape(self.profile)} "
                "must broadcast against each other"
            ) from None

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Common shape of all numbers; () for a single impact."""
        return np.broadcast_shapes(
            np.shape(self.mass),
            np.shape(self.velocity),
            np.shape(self.external_force),
            _profile_shape(self.profile),
        )

    @cached_property
    def reduced_modulus(self) -> PronySeries:
        """Reduced relaxation modulus E*(t) [Pa] of the contact."""
        return reduced_modulus(self.material, self.counter_material)


def _profile_shape(profile: Profile) -> tuple[int, ...]:
    exponent, coefficient = profile.path_exponent, profile.path_coefficient
    if exponent is None or coefficient is None:
        return ()
    return np.broadcast_shapes(np.shape(exponent), np.shape(coefficient))


def _of_type(name: str, value: Any, kind: type) -> None:
    if isinstance(value, FractionalMaterial):
        raise TypeError(
            f"{name}: a fractional one holds within a window of time, {name}.within(window); for_contact chooses it"
        )
    if not isinstance(value, kind):
        raise TypeError(f"{name} = {value!r}: must be a {kind.__name__}")
