"""Axisymmetric indenter profiles: the interface that all share, and the parabola.

The method of dimensionality reduction maps a profile f(r) onto g(x), the depth at which the contact radius is x. An
impact needs the contact radius over the depth, a(d), and its integral, the force integral.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from restitution.checks import Numeric
from restitution.contact.geometry import Array, Geometry, as_array, plain
from restitution.errors import InputError
from restitution.quantities import INPUTS


class Profile(Geometry):
    """Axisymmetric profile f(r) of a rigid indenter of a half-space, with f(0) = 0, that never falls with r.

    All methods are vectorised, take lengths in [m] and broadcast against array parameters; f and g are even functions.

    Notes
    -----
    With the transform ``g(x) = |x| int_0^|x| f'(r)/sqrt(x^2 - r^2) dr`` (Popov and Hess, Method of Dimensionality
    Reduction in Contact Mechanics and Friction, 2015; Willert et al., eq. 4) the contact radius a of the approach
    obeys ``d = g(a)``, and the elastic force is ``F = 2 E* Pi`` with the force integral ``Pi = int_0^a x g'(x) dx =
    int_0^d a dd``. The contact radius is the stiffness radius.

    Where a body has no surface (beside a flat punch, beyond the equator of a sphere) f and g are infinite: an element
    there is never touched. docs/development/extending.md shows how to write a subclass.
    """

    @abstractmethod
    def shape(self, r: ArrayLike) -> Array:
        """Profile f(r) [m] at radius r [m]."""

    @abstractmethod
    def transform(self, x: ArrayLike) -> Array:
        """Transformed profile g(x) [m]: the depth at which the contact radius is x [m]."""

    @abstractmethod
    def contact_radius(self, depth: ArrayLike) -> Array:
        """Contact radius a = g^-1(d) [m] of the approach at depth d >= 0 [m]; 0 where d < 0."""

    @abstractmethod
    def force_integral(self, contact_radius: ArrayLike) -> Array:
        """Force integral Pi(a) = int_0^a x g'(x) dx [m^2] at contact radius a [m]."""

    def stiffness_radius(self, depth: ArrayLike) -> Array:
        """Stiffness radius [m] at depth d [m]: the contact radius."""
        return self.contact_radius(depth)

    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Force integral int_0^d a dd [m^2] at depth d [m], which also a flat punch has."""
        return self.force_integral(self.contact_radius(depth))

    @property
    def image(self) -> Profile:
        """The profile itself."""
        return self

    @property
    def max_contact_radius(self) -> Numeric:
        """Largest contact radius [m] that the profile describes."""
        return math.inf

    @property
    def joints(self) -> Array:
        """Radii [m] beyond a flat face at which a derivative of f jumps; none for most profiles."""
        return np.empty(0)


def as_profile(geometry: Geometry, wanting: str) -> Profile:
    """Return the geometry if it is a profile on a half-space, which `wanting` needs; refuse others with the reason."""
    if isinstance(geometry, Profile):
        return geometry
    raise InputError("profile", geometry, f"must be a Profile on a half-space for {wanting}: {geometry.obstacle}")


@dataclass(frozen=True, eq=False)
class Parabola(Profile, case_name="parabola", body_radius=True):
    """Paraboloid f = r^2/(2R), the small-strain form of a sphere.

    Parameters
    ----------
    radius : float or array
        Radius of curvature R at the tip [m], > 0.

    Raises
    ------
    ValueError
        If a radius is not finite and > 0.

    Notes
    -----
    ``g = x^2/R``, ``Pi = 2 a^3/(3R)``, ``a = sqrt(R d)`` (Willert et al., eqs. 5 and 6). Valid for a << R.

    Examples
    --------
    >>> ball = Parabola(radius=0.01)
    >>> float(ball.contact_radius(1e-4))
    0.001
    >>> round(float(ball.transform(0.001)), 15), ball.path_exponent
    (0.0001, 1.0)
    """

    sources = (("hertz1882", "contact of round bodies as paraboloids"),)

    radius: Annotated[Numeric, INPUTS["radius"]]

    def shape(self, r: ArrayLike) -> Array:
        """Profile f = r^2/(2R) [m]."""
        return as_array(r) ** 2 / (2.0 * self.radius)

    def transform(self, x: ArrayLike) -> Array:
        """Transformed profile g = x^2/R [m]."""
        return as_array(x) ** 2 / self.radius

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Contact radius a = sqrt(R d) [m]."""
        return np.sqrt(self.radius * np.maximum(as_array(depth), 0.0))

    def force_integral(self, contact_radius: ArrayLike) -> Array:
        """Force integral Pi = 2 a^3/(3R) [m^2]."""
        return 2.0 * as_array(contact_radius) ** 3 / (3.0 * self.radius)

    @property
    def tip_radius(self) -> Numeric:
        """Radius R [m]."""
        return self.radius

    @property
    def path_exponent(self) -> Numeric:
        """Exponent of a = c s^p: 1."""
        return 1.0

    @property
    def path_coefficient(self) -> Numeric:
        """Coefficient of a = c s^p: sqrt(R) [m^(1/2)]."""
        return plain(np.sqrt(self.radius))
