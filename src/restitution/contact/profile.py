"""Axisymmetric indenter profiles: the interface that all share, and the parabola.

The method of dimensionality reduction maps a profile f(r) onto g(x), the depth at which the contact radius is x. An
impact needs the contact radius over the depth, a(d), and its integral, the force integral.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from functools import cache
from typing import Annotated, Any, ClassVar, NamedTuple, get_type_hints

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.checks import Numeric
from restitution.errors import InputError
from restitution.quantities import INPUTS, Quantity

Array = NDArray[np.float64]


def as_array(values: ArrayLike) -> Array:
    """Return `values` as a float64 array, 0-d for a number."""
    return np.asarray(values, dtype=np.float64)


class Kinks(NamedTuple):
    """Depths at which a(d) is not smooth: ``a = smooth + strength (d - depth)^power`` beyond each of them.

    Attributes
    ----------
    depth : array
        Depths [m], rising, > 0.
    strength : array
        Factor [m^(1 - power)] of each.
    power : float
        Half-integer, >= 3/2.
    """

    depth: Array
    strength: Array
    power: float


class Profile(ABC):
    """Axisymmetric profile f(r) of a rigid indenter, with f(0) = 0, that never falls with r.

    All methods are vectorised, take lengths in [m] and broadcast against array parameters; f and g are even functions.

    Notes
    -----
    With the transform ``g(x) = |x| int_0^|x| f'(r)/sqrt(x^2 - r^2) dr`` (Popov and Hess, Method of Dimensionality
    Reduction in Contact Mechanics and Friction, 2015; Willert et al., eq. 4) the contact radius a of the approach
    obeys ``d = g(a)``, and the elastic force is ``F = 2 E* Pi`` with the force integral ``Pi = int_0^a x g'(x) dx =
    int_0^d a dd``.

    Over ``s = sqrt(d)`` the contact radius of a power law is ``a = path_coefficient * s**path_exponent``. Other
    profiles have None for both, and `restitution.contact.path.path_table` tabulates a(s).

    Where a body has no surface (beside a flat punch, beyond the equator of a sphere) f and g are infinite: an element
    there is never touched. docs/development/extending.md shows how to write a subclass.
    """

    registered: ClassVar[dict[str, type[Profile]]] = {}
    body_radius: ClassVar[bool] = False
    # Keys of citation/references.bib, and what each is cited for.
    sources: ClassVar[tuple[tuple[str, str], ...]] = ()

    def __init_subclass__(cls, case_name: str = "", body_radius: bool = False, **rest: Any) -> None:
        """Register the profile for case files; with `body_radius` its radius is that of the body if none is given."""
        super().__init_subclass__(**rest)
        cls.body_radius = body_radius
        if case_name:
            Profile.registered[case_name] = cls

    def __post_init__(self) -> None:
        """Check the parameters of a profile that is a dataclass, and convert them to SI."""
        for name, quantity in _parameters(type(self)).items():
            value = quantity.check(getattr(self, name), name)
            if quantity.unit == "m" and np.any(np.abs(value) > 1e100):
                # Squares and products of larger lengths overflow.
                raise InputError(name, getattr(self, name), "must be at most 1e+100 m", "m")
            object.__setattr__(self, name, value)

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

    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Force integral int_0^d a dd [m^2] at depth d [m], which also a flat punch has."""
        return self.force_integral(self.contact_radius(depth))

    @property
    def path_exponent(self) -> Numeric | None:
        """Exponent p of a = c s^p, s = sqrt(d); None where no power law holds."""
        return None

    @property
    def path_coefficient(self) -> Numeric | None:
        """Coefficient c [m^(1-p/2)] of a = c s^p, s = sqrt(d); None where no power law holds."""
        return None

    @property
    def kinks(self) -> Kinks:
        """Depths at which a(d) is not smooth; none for most profiles."""
        return Kinks(np.empty(0), np.empty(0), 1.5)

    @property
    def max_contact_radius(self) -> Numeric:
        """Largest contact radius [m] that the profile describes."""
        return math.inf

    @property
    def max_depth(self) -> Numeric:
        """Largest indentation depth [m] that the profile describes."""
        return math.inf

    def __eq__(self, other: object) -> bool:
        """Whether both are profiles of one type with equal parameters."""
        if type(other) is not type(self):
            return NotImplemented
        return all(np.array_equal(mine, theirs) for mine, theirs in zip(_values(self), _values(other), strict=True))

    def __hash__(self) -> int:
        """Hash of the type and the parameters."""
        return hash((type(self), *(np.asarray(value).tobytes() for value in _values(self))))


def plain(value: Any) -> Numeric:
    """Return a 0-d value as a float, an array as it is."""
    return float(value) if np.ndim(value) == 0 else value


@cache
def _parameters(kind: type[Profile]) -> dict[str, Quantity]:
    hints = get_type_hints(kind, include_extras=True)
    return {name: hint.__metadata__[0] for name, hint in hints.items() if hasattr(hint, "__metadata__")}


def _values(profile: Any) -> list[Any]:
    return [getattr(profile, field.name) for field in fields(profile) if field.compare]


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
    def path_exponent(self) -> Numeric:
        """Exponent of a = c s^p: 1."""
        return 1.0

    @property
    def path_coefficient(self) -> Numeric:
        """Coefficient of a = c s^p: sqrt(R) [m^(1/2)]."""
        return plain(np.sqrt(self.radius))
