"""Geometry of a contact: the stiffness radius and the force integral over the depth, from which impacts follow.

The equations of an impact depend on the shape of the bodies through the elastic stiffness alone. A profile on a
half-space is one geometry; a layer, an ellipsoid and a measured force law are others.
"""

from __future__ import annotations

import math
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self, get_type_hints

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.axes import Axes, aligned, spread_array
from restitution.checks import Array, Numeric, common_shape, number, single_positive
from restitution.errors import InputError, InputTypeError, RestitutionWarning
from restitution.material.fractional import FractionalMaterial
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, common_window, poisson_ratio_range, reduced_modulus
from restitution.quantities import Quantity
from restitution.units import LENGTH

if TYPE_CHECKING:
    from restitution.contact.profiles import Profile

# Distance of an extreme Poisson ratio from both ends, from which a message names it.
_BESIDE_ENDS = 5e-3


def as_array(values: ArrayLike) -> Array:
    """Return lengths [m] as a float64 array, 0-d for a number; those with a unit are converted."""
    # Most come from the package itself.
    if isinstance(values, float) or (type(values) is np.ndarray and values.dtype == np.float64):
        return np.asarray(values)
    return number("length", values, LENGTH.unit)


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
    geometries have None for both, and `restitution.contact.table.path_table` tabulates a(s).
    """

    registered: ClassVar[dict[str, type[Any]]] = {}
    body_radius: ClassVar[bool] = False
    axes: ClassVar[Axes | None] = None  # names of the axes of an array of geometries
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
        parts = {name: getattr(self, name) for name in _numbers(type(self))} | self._within
        parts, axes = aligned(parts)
        if axes is not None:
            vars(self).update(parts, axes=axes)
        for name, quantity in _parameters(type(self)).items():
            value = quantity.check(getattr(self, name), name)
            if quantity.unit == "m" and np.any(np.abs(value) > 1e100):
                # Squares and products of larger lengths overflow.
                raise InputError(name, getattr(self, name), "must be at most 1e+100 m", "m")
            object.__setattr__(self, name, value)

    @abstractmethod
    def stiffness_radius(self, depth: ArrayLike) -> Array:
        """Return the stiffness radius a = S/(2 E*) [m] of the approach at depth d >= 0 [m]; 0 where d < 0."""

    @abstractmethod
    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Return the force integral int_0^d a dd [m^2] at depth d [m]."""

    @abstractmethod
    def contact_radius(self, depth: ArrayLike) -> Array:
        """Return the contact radius [m] of the approach at depth d >= 0 [m]; 0 where d < 0.

        It is the radius of a disc of equal area where the contact is no disc, and NaN where it is not known.
        """

    def contact_radius_at(self, depth: ArrayLike, stiffness_radius: ArrayLike) -> Array:
        """Return the contact radius [m] at depth d [m] where the stiffness radius [m] is known; may be quicker."""
        return self.contact_radius(depth)

    def semi_axes(self, contact_radius: ArrayLike) -> Array:
        """Return semi-axes a >= b [m] of contacts whose radius [m] is sqrt(a b), stacked along the first axis."""
        radius, root = as_array(contact_radius), np.sqrt(self.axis_ratio)
        return np.stack([radius / root, radius * root])

    def curve(self, depth: float) -> Callable[[Array], tuple[Array, Array]]:
        """Return a function from y^2 in [0, 1] to depths [m] up to this one and stiffness radii [m], both smooth."""
        return lambda share: (depth * share, self.stiffness_radius(depth * share))

    @property
    def numbers(self) -> dict[str, Numeric]:
        """Numbers by name that may be arrays, those of a profile within the geometry last."""
        numbers = {name: getattr(self, name) for name in _numbers(type(self))}
        for inner in self._within.values():
            numbers |= inner.numbers
        return numbers

    @property
    def _within(self) -> dict[str, Geometry]:
        """Geometries among the parameters, such as the profile of the body on a layer."""
        parts = (
            {each.name: getattr(self, each.name) for each in fields(self) if each.init} if is_dataclass(self) else {}
        )
        return {name: part for name, part in parts.items() if isinstance(part, Geometry)}

    @cached_property
    def rows(self) -> tuple[int, ...]:
        """Shape of an array of geometries, to which their numbers broadcast; () for one."""
        return common_shape({name: np.shape(value) for name, value in self.numbers.items()})

    @property
    def apart(self) -> tuple[str, ...]:
        """Names of the numbers that rows with one table, or one power law, have in common."""
        if self.path_exponent is None and self.similar.geometry is self:
            return tuple(self.numbers)
        return tuple(name for name, several in _numbers(type(self)).items() if not several)

    def changed(self, numbers: Mapping[str, Any]) -> Self:
        """Return the geometry with other `numbers` by name."""
        parts: dict[str, Any] = {name: value for name, value in numbers.items() if name in _numbers(type(self))}
        for name, inner in self._within.items():
            if inner.numbers.keys() & numbers.keys():
                parts[name] = inner.changed(numbers)
        change: Any = replace
        return change(self, **parts) if parts else self

    def spread(self, names: tuple[Any, ...], axes: Axes | None = None) -> Self:
        """Return the geometries of an array over axes of other names; their own are `axes`."""
        target = axes or self.axes
        assert target is not None
        return self.changed(
            {name: spread_array(value, target, names, self.rows) for name, value in self.numbers.items()}
        )

    def take(self, shape: tuple[int, ...], places: NDArray[np.intp], same: Collection[str] = ()) -> Self:
        """Return rows of an array, raveled from a larger shape; numbers in `same` are equal in all of them.

        The array has the shape of the places, and a single geometry remains one.
        """
        numbers: dict[str, Any] = {}
        for name, value in self.numbers.items():
            if np.ndim(value):
                values = np.broadcast_to(value, shape).reshape(-1)[places]
                # No row has this number where there is none.
                first = values.flat[0] if values.size else 1.0
                numbers[name] = float(first) if name in same or not values.ndim else values
        return self.changed(numbers)

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
    def smooth(self) -> bool:
        """Whether tables of the stiffness radius over the root of the depth count as smooth, also at zero."""
        return False

    @property
    def separable(self) -> bool:
        """Whether contacts of all sizes have the reduced modulus of the material."""
        return True

    def effective_moduli(self, material: Material, contact_radius: Array) -> PronySeries:
        """Return a reduced modulus [Pa] for each contact up to a radius [m], of a geometry that is not `separable`."""
        return reduced_modulus(material).broadcast_to((contact_radius.size,))

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
        """Return whether both are geometries of one type with equal parameters."""
        if type(other) is not type(self):
            return NotImplemented
        return all(np.array_equal(mine, theirs) for mine, theirs in zip(_values(self), _values(other), strict=True))

    def __hash__(self) -> int:
        """Hash of the type and the parameters."""
        return self._hash

    @cached_property
    def _hash(self) -> int:
        values = (value if isinstance(value, Geometry) else np.asarray(value).tobytes() for value in _values(self))
        return hash((type(self), *values))


# Halvings of the range of depths, which is logarithmic.
_HALVINGS = 70


def depth_of_integral(geometry: Geometry, integral: ArrayLike) -> Array:
    """Return the depths [m] at which `force_integral_at_depth` has values [m^2]; infinite beyond the geometry."""
    target, exponent, coefficient = as_array(integral), geometry.path_exponent, geometry.path_coefficient
    if exponent is not None and coefficient is not None:
        power = 0.5 * float(exponent) + 1.0
        return as_array((target * power / float(coefficient)) ** (1.0 / power))
    highest = min(float(np.min(geometry.max_depth)), 1e100)
    low, high = np.full(target.shape, -300.0), np.full(target.shape, math.log(highest))
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        reaches = as_array(geometry.force_integral_at_depth(np.minimum(np.exp(middle), highest))) >= target
        low, high = np.where(reaches, low, middle), np.where(reaches, middle, high)
    ends = as_array(geometry.force_integral_at_depth(highest)) < target * (1.0 - 1e-12)
    return np.where(target > 0.0, np.where(ends, math.inf, np.minimum(np.exp(high), highest)), target)


@cache
def _parameters(kind: type[Geometry]) -> dict[str, Quantity]:
    hints = get_type_hints(kind, include_extras=True)
    return {name: hint.__metadata__[0] for name, hint in hints.items() if hasattr(hint, "__metadata__")}


@cache
def _numbers(kind: type[Geometry]) -> dict[str, bool]:
    """Return parameters that are numbers, and whether the methods take arrays of them."""
    hints = get_type_hints(kind)
    names = [each.name for each in fields(kind) if each.init] if is_dataclass(kind) else []
    return {name: hints[name] == Numeric for name in names if hints[name] in (float, Numeric)}


def _values(geometry: Any) -> list[Any]:
    return [getattr(geometry, field.name) for field in fields(geometry) if field.compare]


# The contact of an indenter with a target: the geometry and the materials of both bodies.

BALL_ON_TARGET = (math.inf, 2.0)
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
    >>> from restitution.contact.profiles import Parabola
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
        counter = {} if self.counter_material is None else {"counter_material": self.counter_material.shape}
        object.__setattr__(self, "shape", common_shape({"material": self.material.shape, **counter}))
        if not self.is_split:
            object.__setattr__(self, "profile", self.profile.between(self.material, self.counter_material))
        if self.body_size is not None:
            object.__setattr__(self, "body_size", single_positive("body_size", self.body_size, "m"))

    shape: ClassVar[tuple[int, ...]]
    """Shape of an array of materials; () for single ones."""

    @property
    def is_split(self) -> bool:
        """Whether the geometry holds for a single material alone, and there are several."""
        return bool(self.shape) and self.profile.needs_poisson_ratio

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
            ends = self.material.instantaneous_poisson_ratio, self.material.poisson_ratio
            text = approximation(*ends, *poisson_ratio_range(self.material))
            warnings.warn(RestitutionWarning(kind, f"{kind}: {'. '.join(text)}"), stacklevel=3)

    @property
    def window(self) -> tuple[float, float] | None:
        """First and last time [s] between which the materials of both bodies are valid; None without a limit."""
        return common_window(material.window for material in self.materials)


def approximation(
    instantaneous: float, static: float, lowest: float = math.nan, highest: float = math.nan
) -> tuple[str, str]:
    """Return why a contact is not exact, by the Poisson ratios of its material, and what to expect of the results.

    The lowest and the highest one over all times are named where they are not those of the two ends.
    """
    text = f"the Poisson ratio relaxes from {instantaneous:.3g} to {static:.3g}"
    beyond = [
        f"{value:.3g}"
        for value, end in ((lowest, min(instantaneous, static)), (highest, max(instantaneous, static)))
        if abs(value - end) > _BESIDE_ENDS
    ]
    text += f", by way of {' and '.join(beyond)}, " if beyond else ", "
    text += "and a bonded layer is approximate "
    return f"{text}then", "Expect errors of some 0.5 % of e, 4 % of the contact time and 10 % of the force."


def of_type(name: str, value: Any, kind: type) -> None:
    """Refuse what is not of the type, with the remedy for a fractional material."""
    if isinstance(value, FractionalMaterial):
        rule = f"a fractional material holds within a window of time: {name}.within(window), or for_contact"
        raise InputTypeError(name, rule=rule)
    if not isinstance(value, kind):
        raise InputTypeError(name, value, f"must be a {kind.__name__}")
