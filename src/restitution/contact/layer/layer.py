"""A body on an elastic or viscoelastic layer that rests on a rigid base."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.checks import Array, Numeric, one_of
from restitution.contact.geometry import Geometry, Kinks, Similar, as_array
from restitution.contact.layer.contacts import Contacts, contacts
from restitution.contact.layer.depths import Depths, depths, face_over_thickness, largest_radius
from restitution.contact.layer.moduli import effective_moduli, effective_modulus
from restitution.contact.layer.punch import PANELS, Punches, stored_punches
from restitution.contact.profiles import FlatPunch, PowerLaw, Profile
from restitution.contact.table import PathTable, Rows, Samples, Tables, joined
from restitution.errors import InputError, InputTypeError
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, poisson_ratio_range
from restitution.quantities import INPUTS

# A profile on layers of many thicknesses, whose tables are computed together.

# Layers whose thickness differs by less than this share may represent each other for estimates.
_SIMILAR = 0.2
# Logarithm of the force integral beyond the tables, where nothing yields.
_RIGID = 300.0
# Ends of tables for each unit of the logarithm of the depth on a half-space.
_LEVELS = 3.0


@dataclass(frozen=True, eq=False)
class LayerRows(Rows):
    """A single profile that is no power law on layers of many thicknesses."""

    profile: Profile
    thickness: Array
    poisson_ratio: float | None  # None for a frictionless base

    @cached_property
    def _punches(self) -> Punches:
        return stored_punches(self.poisson_ratio)

    @cached_property
    def _distinct(self) -> tuple[Array, NDArray[np.intp]]:
        values, which = np.unique(self.thickness, return_inverse=True)
        return values, which.reshape(-1)

    @property
    def which(self) -> NDArray[np.intp]:
        """Number of the distinct thickness of each row, from the smallest one on."""
        return self._distinct[1]

    def raveled(self, shape: tuple[int, ...]) -> Self:
        """Return the rows broadcast to a shape and raveled."""
        return type(self)(self.profile, np.broadcast_to(self.thickness, shape).reshape(-1), self.poisson_ratio)

    def _each(self, name: str, depth: ArrayLike) -> Array:
        depth = np.broadcast_to(as_array(depth), self.thickness.shape)
        result = np.empty(depth.shape)
        for k, thickness in enumerate(self._distinct[0].tolist()):
            layer = depths(self.profile, thickness, self.poisson_ratio)
            rows = self.which == k
            result[rows] = getattr(layer, name)(layer.half_space_depth(np.minimum(depth[rows], layer.max_depth)))
        return result

    def stiffness_radius(self, depth: ArrayLike) -> Array:
        """Return the stiffness radius a kappa [m] at depth d [m] of each row."""
        return self._each("stiffness_radius", depth)

    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Return the force integral int_0^d a kappa dd [m^2] at depth d [m] of each row."""
        return self._each("force_integral_at_depth", depth)

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Return the contact radius a [m] at depth d [m] of each row."""
        return self._each("contact_radius", depth)

    def contact_radius_at(self, depth: ArrayLike, stiffness_radius: ArrayLike) -> Array:
        """Return the contact radius a [m] from the stiffness radius a kappa [m]."""
        return self._punches.radius(as_array(stiffness_radius) / self.thickness) * self.thickness

    @property
    def max_depth(self) -> Array:
        """Depth [m] of each row at which the tables end."""
        return self._deepest[self.which]

    @cached_property
    def _widest(self) -> Array:
        """Largest contact radius [m] on each distinct layer."""
        return np.minimum(largest_radius(self.profile), PANELS[-1] * self._distinct[0])

    @cached_property
    def _deepest(self) -> Array:
        deepest = contacts(self.profile, self.poisson_ratio, float(self._distinct[0][0]), float(self._widest[-1]))
        return deepest.own_depth(self._distinct[0], deepest.at(self.profile.transform(self._widest)))

    @cached_property
    def _similar(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """The thinnest one of each group of similar layers, and the group of each distinct layer."""
        group = np.floor(np.log(self._distinct[0]) / _SIMILAR)
        _, chosen, which = np.unique(group, return_index=True, return_inverse=True)
        return chosen, which.reshape(-1)

    @property
    def sampled(self) -> NDArray[np.intp]:
        """Number of the samples of each distinct layer; similar layers share them."""
        return self._similar[1]

    @cached_property
    def samples(self) -> Samples:
        """Depths and force integrals over the logarithm of the depth on a half-space."""
        thickness, chosen = self._distinct[0], self._similar[0]
        end = min(largest_radius(self.profile), PANELS[-1] * _power_of_two(float(thickness[-1]), math.ceil))
        # Rounded to powers of two, so that other rows of the same profile find the contacts in the cache.
        layers = self._contacts(float(thickness[0]), end)
        knots, contact, flat = layers.sampled
        # Beyond the end of the tables.
        with np.errstate(all="ignore"):
            depth, _, integral = np.log(layers.on(thickness[chosen], contact, loads=True))
        inside = contact.radius <= self._widest[chosen][:, None]
        depth = np.maximum.accumulate(np.where(inside, depth, -_RIGID), axis=1)
        integral = np.where(inside, integral, _RIGID)
        # At small depths both have constant ratios to those of the half-space.
        count = contact.radius.size
        pad = ((0, 0), (knots.size - count, 0))
        depth = np.pad(depth - knots[-count:], pad, mode="edge") + knots
        integral = np.pad(integral - flat[-count:], pad, mode="edge") + flat
        return Samples(knots, depth, integral)

    def _contacts(self, thinnest: float, end: float) -> Contacts:
        """Return contacts up to a radius [m]; similar rows share them."""
        return contacts(self.profile, self.poisson_ratio, _power_of_two(thinnest, math.floor), end)

    def tables(self, deepest: Array, least: Array, rtol: float) -> Tables:
        """Return tables of the distinct layers; those with the same largest contact radius are computed together."""
        knots = self.samples.knots
        ends, small = np.empty((2, deepest.size))
        for n, (depth, integral) in enumerate(zip(*self.samples[1:], strict=True)):
            rows = self.sampled == n
            ends[rows] = np.interp(np.log(deepest[rows]), depth, knots)
            # At a sample that is not deeper.
            place = np.searchsorted(depth, np.log(least[rows]), side="right") - 1
            small[rows] = np.exp(integral[np.maximum(place, 0)])
        # Rounded up, so that similar rows share their contacts.
        levels, level = np.unique(np.ceil(_LEVELS * ends), return_inverse=True)
        # Rounding must not exceed the end of the profile.
        radii = np.minimum(np.exp(levels / _LEVELS), self.profile.transform(self._widest[-1]))
        radii = np.minimum(self.profile.contact_radius(radii)[level.reshape(-1)], self._widest)
        groups, numbers = list[Tables](), list[NDArray[np.intp]]()
        pending = np.argsort(-radii, kind="stable")
        # Layers share a table of contacts up to one radius if all are wide enough for it.
        while pending.size:
            end = float(radii[pending[0]])
            together = self._widest[pending] >= end
            layers, pending = np.sort(pending[together]), pending[~together]
            thickness = self._distinct[0][layers]
            groups += self._contacts(float(thickness[0]), end).tables(thickness, small[layers], rtol)
            numbers.append(layers)
        if len(groups) == 1:
            return groups[0]
        # In the order of the layers.
        order = np.argsort(np.concatenate(numbers))
        table = joined([group.table for group in groups])
        depth, radius = np.hstack([group[1:] for group in groups])[:, order]
        return Tables(PathTable._make([*(column[order] for column in table[:-1]), table.power]), depth, radius)


def _power_of_two(value: float, rounded: Callable[[float], int]) -> float:
    return 2.0 ** rounded(math.log2(value))


# Change of the Poisson ratio in time that does not matter, and the value above which every change may be neglected.
CONSTANT, INCOMPRESSIBLE = 1e-9, 0.498

Base = Literal["bonded", "frictionless"]

# Place of the stiffness between the centre and the edge of the largest contact; fitted to six finite-element impacts.
_PLACE = 0.8
# Digits of the Poisson ratio after the point; thin incompressible layers need most of them.
_DIGITS = 14


@dataclass(frozen=True, eq=False)
class Layer(Geometry):
    """Rigid body on a layer of uniform thickness on a rigid base.

    Parameters
    ----------
    profile : Profile
        Profile of the body.
    thickness : float or array
        Thickness h of the layer [m], > 0.
    base : {"bonded", "frictionless"}
        Whether the layer sticks to the base or slides on it without friction.
    strict : bool
        Whether materials are refused for which the solution is an approximation.

    Raises
    ------
    InputError
        If the profile or a number is out of its range. In a contact: if the indenter deforms too, or the contact
        radius exceeds 40 h.

    Notes
    -----
    The line load q of the foundation obeys ``q(x) - int m(x - y) q(y) dy = E* (d - g(x))``, with the kernel m of the
    compliance of the layer; it vanishes at the edge of the contact. The equation is solved by Gauss nodes, and tables
    over a/h keep the depth, the stiffness radius and the force integral to about 1e-12. An infinite thickness would
    give the half-space. Valid for small strains and a layer that is wide compared with its thickness.

    The material of the contact gives the Poisson ratio of a bonded layer, that of its equilibrium. The solution is
    exact on a frictionless base for every material, and on a bonded base if the Poisson ratio does not change in time.
    Where it changes but stays above 0.498, as that of rubber, the map at equilibrium is used: in finite elements at
    0.4989 to 0.4999 this changes e by less than 1 %. Other materials on a bonded base have a separable
    approximation, with a warning: the map at equilibrium, with an effective modulus that is that of a flat punch
    of the radius 0.8 a_max; a_max is that of a first solution with E*(t). In six impacts of finite elements its
    errors are about 0.5 % of e, 4 % of the contact time and 10 % of the largest force. A flat punch is exact.

    Examples
    --------
    >>> import restitution as rs
    >>> rubber = rs.Material(rs.PronySeries(1e6, [5e6], [1e-3]), bulk=float("inf"))
    >>> pad = rs.Layer(rs.Sphere(0.0075), thickness=0.0125)
    >>> print(round(rs.solve(rs.Impact(rubber, pad, mass=0.25, velocity=0.1)).restitution_coefficient, 5))
    0.35595
    """

    sources = (("hayes1972", "stiffness of a layer on a rigid base"),)
    end = "where the profile ends or the contact radius is 40 thicknesses"
    obstacle = "the elements of a layer are coupled"

    profile: Profile
    thickness: Annotated[Numeric, INPUTS["thickness"]]
    base: Base = "bonded"
    strict: bool = False
    _poisson_ratio: float | None = field(default=None, init=False, repr=False)
    _relaxes: bool = field(default=False, init=False, repr=False)
    _confinement: float = field(default=0.0, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        one_of("base", self.base, ("bonded", "frictionless"))
        object.__setattr__(self, "needs_poisson_ratio", self.base == "bonded")
        if not isinstance(self.profile, Profile):
            raise InputTypeError("profile", self.profile, "must be a Profile, such as Parabola(radius)")

    def between(self, material: Material, counter_material: Material | None) -> Self:
        """Return the layer with the Poisson ratio of its material; refuse a second body that deforms."""
        if counter_material is not None:
            rule = "must be left out on a layer: the compliances of a layer and of another body are not proportional"
            raise InputError("counter_material", rule=rule)
        if self.base == "frictionless":
            return self
        low, high = map(float, _poisson_ratio_range(material))
        # With a constant ratio, or near 1/2, the compliance of the layer is E*(s) times a function of the radius.
        relaxes = high - low > CONSTANT and low <= INCOMPRESSIBLE
        moduli = [series for series in (material.shear, material.bulk) if isinstance(series, PronySeries)]
        # With a dashpot the transform grows without bound, and no fit by branches follows it.
        if relaxes and any(series.parallel_viscosity > 0.0 for series in moduli):
            rule = "must have no parallel dashpot on a bonded layer, unless its Poisson ratio is constant in time"
            raise InputError("material", rule=rule)
        if relaxes and self.strict and not self._is_punch:
            rule = "must have a Poisson ratio that does not change in time, or stays above "
            rule += f"{INCOMPRESSIBLE:g}, on a bonded layer; that of this one is between {low:.3g} and {high:.3g}"
            raise InputError("material", rule=rule)
        # The same material gives slightly different numbers after changes of its form, and layers are cached by them.
        poisson_ratio = round(material.poisson_ratio, _DIGITS)
        confinement = max(4.0 * high / (1.0 - 2.0 * high), 0.0) if high < 0.5 else np.inf
        details = {"_poisson_ratio": poisson_ratio, "_relaxes": relaxes, "_confinement": confinement}
        if vars(self).items() >= details.items():
            return self
        bound = replace(self)
        vars(bound).update(details)
        return bound

    @property
    def smooth(self) -> bool:
        """Whether tables count as smooth: under parabola and cone, and only where the modulus is approximate."""
        exponent = self.profile.path_exponent
        return self._relaxes and exponent is not None and bool(np.all(np.isin(exponent, (1.0, 2.0))))

    @property
    def separable(self) -> bool:
        """Whether contacts of all sizes have the reduced modulus of the material."""
        return not self._relaxes

    def effective_moduli(self, material: Material, contact_radius: Array) -> PronySeries:
        """Return reduced moduli [Pa] of contacts up to radii [m]; that of the material where there is no contact."""
        radii = np.ravel(contact_radius / self.thickness)
        if self._is_punch:
            # All contacts have the radius of the punch.
            finite_radii = radii[np.isfinite(radii)]
            series = effective_modulus(material, float(finite_radii[0]) if finite_radii.size else 0.0)
            return series.broadcast_to((radii.size,))
        return effective_moduli(material).at(np.where(np.isfinite(radii), _PLACE * radii, 0.0))

    @property
    def _ratio(self) -> float | None:
        """Poisson ratio of a bonded layer."""
        if self.base == "bonded" and self._poisson_ratio is None:
            rule = "has no Poisson ratio yet: a bonded layer takes that of the material of its Contact or Impact"
            raise InputError("profile", self, rule)
        return self._poisson_ratio

    @cached_property
    def _depths(self) -> Depths:
        unit: Any = self.similar.geometry
        return depths(unit.profile, unit.thickness, self._ratio)

    @cached_property
    def _punch(self) -> FlatPunch:
        """Flat punch on a half-space with the stiffness of the punch on the layer."""
        radius: Any = self.profile.contact_radius(0.0)
        kappa = stored_punches(self._ratio).kappa(np.asarray(face_over_thickness(radius, self.thickness)))
        return FlatPunch(radius * kappa)

    @property
    def apart(self) -> tuple[str, ...]:
        """Those of the profile; all numbers of a flat punch, whose stiffness depends on a/h."""
        return tuple(self.numbers) if self._is_punch else self.profile.apart

    def changed(self, numbers: Mapping[str, Any]) -> Self:
        """Return the layer with other `numbers` by name, and the same Poisson ratio."""
        layer = super().changed(numbers)
        vars(layer).update({name: getattr(self, name) for name in ("_poisson_ratio", "_relaxes", "_confinement")})
        return layer

    @cached_property
    def _is_split(self) -> bool:
        """Whether there are several layers without a common table."""
        return any(np.ndim(self.numbers[name]) for name in self.apart)

    @property
    def _is_several(self) -> bool:
        """Whether layers of several sizes are not similar."""
        return bool(self.rows) and not self._is_power_law

    def _each(self, name: str, depth: ArrayLike) -> Array:
        """Evaluate a method of the rows at depths that broadcast with the numbers."""
        shape = np.broadcast_shapes(np.shape(depth), self.rows)
        depths = np.broadcast_to(depth, shape).reshape(-1)
        if self._is_split:
            singles = (self.take(shape, np.array(n)) for n in range(depths.size))
            return np.array([getattr(layer, name)(d) for layer, d in zip(singles, depths, strict=True)]).reshape(shape)
        rows = self.similar.geometry
        assert isinstance(rows, LayerRows)
        return getattr(rows.raveled(shape), name)(depths).reshape(shape)

    @property
    def _is_punch(self) -> bool:
        """Whether the contact has one radius at all depths."""
        exponent = self.profile.path_exponent
        return exponent is not None and bool(np.all(np.asarray(exponent) == 0.0))

    @property
    def _is_power_law(self) -> bool:
        """Whether layers of all sizes are similar."""
        exponent = self.profile.path_exponent
        return exponent is not None and np.ndim(exponent) == 0 and bool(exponent)

    @cached_property
    def similar(self) -> Similar:
        """The layer of thickness 1 m under ``g = x^n``, for a profile that is a power law; rows for several others."""
        if self._is_several and not self._is_split:
            ones = np.ones(np.shape(self.thickness))
            return Similar(LayerRows(self.profile, as_array(self.thickness), self._ratio), ones, ones)
        if not self._is_power_law:
            return Similar(self, 1.0, 1.0)
        coefficient: Any = self.profile.path_coefficient
        exponent = float(np.asarray(self.profile.path_exponent))
        # With radii a = h xi and depths d = (h/c)^(2/p) D, every power law a = c d^(p/2) is D = xi^(2/p).
        unit = replace(self, profile=_unit_power_law(2.0 / exponent), thickness=1.0)
        vars(unit).update(_poisson_ratio=self._poisson_ratio, similar=Similar(unit, 1.0, 1.0))
        with np.errstate(all="ignore"):
            radius: Any = np.asarray(self.thickness / coefficient)[()] ** (2.0 / exponent)
        if not np.all((radius > 0.0) & (radius < math.inf)):
            rule = "must be nearer to the size of the profile, as their ratio is no number that a double can hold"
            raise InputError("thickness", self.thickness, rule, "m")
        return Similar(unit, radius if np.ndim(radius) else float(radius), self.thickness)

    def stiffness_radius(self, depth: ArrayLike) -> Array:
        """Return the stiffness radius a kappa [m] at depth d [m]."""
        return self._value("stiffness_radius", depth, self.similar.radius)

    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Return the force integral int_0^d a kappa dd [m^2] at depth d [m]."""
        return self._value("force_integral_at_depth", depth, self.similar.depth * self.similar.radius)

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Return the contact radius a [m] at depth d [m]."""
        if self._is_punch:
            shape = np.broadcast_shapes(np.shape(depth), self.rows)
            return np.broadcast_to(self.profile.contact_radius(depth), shape)[()]
        return self._value("contact_radius", depth, self.similar.radius)

    def _value(self, name: str, depth: ArrayLike, unit: Numeric) -> Array:
        """Return the value of a method at depths d [m], in a unit of the similar layer."""
        if self._is_punch:
            return getattr(self._punch, name)(depth)
        if self._is_several:
            return self._each(name, depth)
        return getattr(self._depths, name)(self._half_space_depth(depth)) * unit

    def contact_radius_at(self, depth: ArrayLike, stiffness_radius: ArrayLike) -> Array:
        """Return the contact radius a [m] from the stiffness radius a kappa [m]."""
        return stored_punches(self._ratio).radius(as_array(stiffness_radius) / self.thickness) * self.thickness

    def curve(self, depth: float) -> Callable[[Array], tuple[Array, Array]]:
        """Return a function from y^2 in [0, 1], the share of the half-space's depth, to depths and stiffness radii."""
        deepest, unit, size = self._half_space_depth(depth), self.similar.depth, self.similar.radius

        def at(share: Array) -> tuple[Array, Array]:
            place = deepest * share
            return self._depths.depth(place) * unit, self._depths.stiffness_radius(place) * size

        return at

    def _half_space_depth(self, depth: ArrayLike) -> Array:
        depth = as_array(depth)
        # Rounding of the unit may exceed the end.
        deepest = self._depths.max_depth
        place = depth / self.similar.depth
        if np.any(place > deepest * (1.0 + 1e-14)):
            rule = f"must be <= {np.min(self.max_depth):g} m, where the tables of the layer end"
            raise InputError("depth", float(np.max(depth)), rule, "m")
        return self._depths.half_space_depth(np.minimum(place, deepest))

    @property
    def path_exponent(self) -> Numeric | None:
        """Exponent of a kappa = c s^p: 0 for a flat punch, None for other profiles."""
        return 0.0 if self._is_punch else None

    @property
    def path_coefficient(self) -> Numeric | None:
        """Coefficient of a kappa = c s^p: a kappa [m] for a flat punch, None for other profiles."""
        return self._punch.radius if self._is_punch else None

    @property
    def tip_radius(self) -> Numeric:
        """Radius [m] of a round body."""
        return self.profile.tip_radius

    @property
    def target_thickness(self) -> Numeric:
        """Thickness [m] of the layer."""
        return self.thickness

    @property
    def confinement(self) -> float:
        """Number 4 nu/(1 - 2 nu) of the largest Poisson ratio in time on a bonded base; 0 if frictionless."""
        return self._confinement

    @property
    def max_depth(self) -> Numeric:
        """Depth [m] at which the tables end: a/h = 40, or the end of the profile."""
        if self._is_punch:
            return math.inf
        if self._is_split:
            singles = (self.take(self.rows, np.array(n)) for n in range(math.prod(self.rows)))
            return np.array([layer.max_depth for layer in singles]).reshape(self.rows)
        unit: Any = self.similar.geometry if self._is_several else self._depths
        return unit.max_depth * self.similar.depth

    @property
    def kinks(self) -> Kinks:
        """Depths at which a(d) is not smooth: those of the profile, to leading order."""
        return self.profile.kinks if self._is_punch else self._depths.kinks


_poisson_ratio_range = lru_cache(maxsize=64)(poisson_ratio_range)


@lru_cache(maxsize=32)
def _unit_power_law(exponent: float) -> PowerLaw:
    """Return the profile with the transform g = x^n."""
    return PowerLaw(exponent, 1.0 / float(PowerLaw(exponent, 1.0).transform(1.0)))
