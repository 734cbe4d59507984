"""Geometry of a contact: the stiffness radius and the force integral over the depth, from which impacts follow.

The equations of an impact depend on the shape of the bodies through the elastic stiffness alone. A profile on a
half-space is one geometry; a layer, an ellipsoid and a measured force law are others.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import fields
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self, get_type_hints

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.checks import Numeric
from restitution.errors import InputError
from restitution.material.columns import PronyColumns
from restitution.material.viscoelastic import reduced_modulus
from restitution.quantities import Quantity

if TYPE_CHECKING:
    from restitution.contact.profile import Profile
    from restitution.material.viscoelastic import Material

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


class Similar(NamedTuple):
    """A geometry of unit size with the shape of another, whose stiffness radius is ``radius a_1(d/depth)``.

    Attributes
    ----------
    geometry : Geometry
        The geometry of unit size, with the stiffness radius a_1.
    depth, radius : float or array
        Depth and radius [m] that are 1 there.
    """

    geometry: Geometry
    depth: Numeric
    radius: Numeric


class Geometry(ABC):
    """Shape of a rigid indenter and its target, whose contact grows with the depth.

    All methods are vectorised, take lengths in [m] and broadcast against array parameters.

    Notes
    -----
    With the elastic stiffness ``S = dF/dd`` of the contact at the depth d, the stiffness radius is ``a = S/(2 E*)``
    and the force integral ``Pi = int_0^d a dd = F/(2 E*)``. Both do not depend on the modulus. The approach and the
    rebound of a viscoelastic impact follow from them if each contact area contains all earlier ones of the approach.
    On a half-space the stiffness radius of an axisymmetric body is its contact radius.

    Over ``s = sqrt(d)`` the stiffness radius of a power law is ``a = path_coefficient * s**path_exponent``. Other
    geometries have None for both, and `restitution.contact.path.path_table` tabulates a(s).
    """

    registered: ClassVar[dict[str, type[Any]]] = {}
    body_radius: ClassVar[bool] = False
    needs_poisson_ratio: bool = False  # whether `between` takes the Poisson ratio from the material
    axis_ratio: Numeric = 1.0  # short over long semi-axis of the contact
    # Keys of citation/references.bib, and what each is cited for.
    sources: ClassVar[tuple[tuple[str, str], ...]] = ()
    end: ClassVar[str] = "where the profile ends"  # where `max_depth` is
    # Why pressure, surface displacement and elements cannot follow from the stiffness radius.
    obstacle: ClassVar[str] = "it is no axisymmetric profile on a half-space"

    def __init_subclass__(cls, case_name: str = "", body_radius: bool = False, **rest: Any) -> None:
        """Register the geometry for case files; with `body_radius` its radius is that of the body if none is given."""
        super().__init_subclass__(**rest)
        cls.body_radius = body_radius
        if case_name:
            cls.registered[case_name] = cls

    def __post_init__(self) -> None:
        """Check the parameters of a geometry that is a dataclass, and convert them to SI."""
        for name, quantity in _parameters(type(self)).items():
            value = quantity.check(getattr(self, name), name)
            if quantity.unit == "m" and np.any(np.abs(value) > 1e100):
                # Squares and products of larger lengths overflow.
                raise InputError(name, getattr(self, name), "must be at most 1e+100 m", "m")
            object.__setattr__(self, name, value)

    @abstractmethod
    def stiffness_radius(self, depth: ArrayLike) -> Array:
        """Stiffness radius a = S/(2 E*) [m] of the approach at depth d >= 0 [m]; 0 where d < 0."""

    @abstractmethod
    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Force integral int_0^d a dd [m^2] at depth d [m]."""

    @abstractmethod
    def contact_radius(self, depth: ArrayLike) -> Array:
        """Contact radius [m] of the approach at depth d >= 0 [m]; 0 where d < 0.

        It is the radius of a disc of equal area where the contact is no disc, and NaN where it is not known.
        """

    def contact_radius_at(self, depth: ArrayLike, stiffness_radius: ArrayLike) -> Array:
        """Contact radius [m] at depth d [m] where the stiffness radius [m] is known too, which may be quicker."""
        return self.contact_radius(depth)

    def semi_axes(self, contact_radius: ArrayLike) -> Array:
        """Semi-axes a >= b [m] of contacts whose radius [m] is sqrt(a b), stacked along the first axis."""
        radius, root = as_array(contact_radius), np.sqrt(self.axis_ratio)
        return np.stack([radius / root, radius * root])

    def curve(self, depth: float) -> Callable[[Array], tuple[Array, Array]]:
        """Function from y^2 in [0, 1] to depths [m] up to the one given and their stiffness radii [m], both smooth."""
        return lambda share: (depth * share, self.stiffness_radius(depth * share))

    def between(self, material: Material, counter_material: Material | None) -> Self:
        """Return the geometry of a contact of these materials; refuse materials for which it does not hold."""
        return self

    @property
    def image(self) -> Profile | None:
        """Profile of the same stiffness radius, with the pressure of the contact but for a stretch; or None."""
        return None

    @cached_property
    def similar(self) -> Similar:
        """A geometry of unit size that is similar, whose tables serve all sizes; most have none but themselves."""
        return Similar(self, 1.0, 1.0)

    @property
    def tip_radius(self) -> Numeric:
        """Radius [m] of a round body, to which strains refer; NaN for other bodies."""
        return math.nan

    @property
    def ball_radius(self) -> Numeric:
        """Radius [m] of a ball, to which densities refer; NaN for other bodies."""
        return self.tip_radius

    @property
    def slope(self) -> Numeric:
        """Slope of the faces of a sharp body whose contact radius is not known; NaN for other bodies."""
        return math.nan

    @property
    def separable(self) -> bool:
        """Whether contacts of all sizes have the reduced modulus of the material."""
        return True

    def effective_moduli(self, material: Material, contact_radius: Array) -> PronyColumns:
        """Reduced moduli [Pa] of contacts up to radii [m], one for each, of a geometry that is not `separable`."""
        return PronyColumns.stacked([reduced_modulus(material)]).repeated(contact_radius.size)

    @property
    def target_thickness(self) -> Numeric:
        """Thickness [m] of the target where the geometry contains it; NaN for a half-space."""
        return math.nan

    @property
    def confinement(self) -> float:
        """Number 4 nu/(1 - 2 nu) of a layer that must flow sideways; 0 where its surfaces slide, or of others."""
        return 0.0

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
        """Depths at which a(d) is not smooth; none for most geometries."""
        return Kinks(np.empty(0), np.empty(0), 1.5)

    @property
    def max_depth(self) -> Numeric:
        """Largest indentation depth [m] that the geometry describes."""
        return math.inf

    def __eq__(self, other: object) -> bool:
        """Whether both are geometries of one type with equal parameters."""
        if type(other) is not type(self):
            return NotImplemented
        return all(np.array_equal(mine, theirs) for mine, theirs in zip(_values(self), _values(other), strict=True))

    def __hash__(self) -> int:
        """Hash of the type and the parameters."""
        return self._hash

    @cached_property
    def _hash(self) -> int:
        values = (one if isinstance(one, Geometry) else np.asarray(one).tobytes() for one in _values(self))
        return hash((type(self), *values))


def plain(value: Any) -> Numeric:
    """Return a 0-d value as a float, an array as it is."""
    return float(value) if np.ndim(value) == 0 else value


@cache
def _parameters(kind: type[Geometry]) -> dict[str, Quantity]:
    hints = get_type_hints(kind, include_extras=True)
    return {name: hint.__metadata__[0] for name, hint in hints.items() if hasattr(hint, "__metadata__")}


def _values(geometry: Any) -> list[Any]:
    return [getattr(geometry, field.name) for field in fields(geometry) if field.compare]
