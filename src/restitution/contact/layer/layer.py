"""A body on an elastic or viscoelastic layer that rests on a rigid base."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from restitution.checks import Numeric, one_of, single
from restitution.contact.geometry import Array, Geometry, Kinks, Similar, as_array
from restitution.contact.layer.depths import Depths, PunchDepths, depths
from restitution.contact.layer.rows import LayerRows
from restitution.contact.layer.separable import effective_moduli, effective_modulus
from restitution.contact.layer.store import stored_punches
from restitution.contact.power_law import PowerLaw
from restitution.contact.profile import Profile
from restitution.errors import InputError, InputTypeError
from restitution.material.columns import PronyColumns
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material
from restitution.quantities import INPUTS

# Change of the Poisson ratio in time that does not matter, and the value above which every change may be neglected.
CONSTANT, INCOMPRESSIBLE = 1e-9, 0.498

Base = Literal["bonded", "frictionless"]

# Place of the stiffness between the centre and the edge of the largest contact; fitted to six finite-element impacts.
_PLACE = 0.8
# Digits of the Poisson ratio after the point; thin incompressible layers need most of them.
_DIGITS = 14
# Times at which the Poisson ratio is compared.
_MOMENTS = 200


@dataclass(frozen=True, eq=False)
class Layer(Geometry):
    """Rigid body on a layer of uniform thickness on a rigid base.

    Parameters
    ----------
    profile : Profile
        Profile of the body. Its parameters may be arrays if it is a power law.
    thickness : float or array
        Thickness h of the layer [m], > 0; single under a flat punch.
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
        if self.profile.path_exponent == 0.0:
            single("thickness", self.thickness, "m")
        if not self._is_power_law and np.ndim(self.profile.contact_radius(0.0)):
            raise InputError("profile", self.profile, "must have single numbers as parameters on a layer")

    def between(self, material: Material, counter_material: Material | None) -> Self:
        """Return the layer with the Poisson ratio of its material; refuse a second body that deforms."""
        if counter_material is not None:
            wanted = "must be left out on a layer: the compliances of a layer and of another body are not proportional"
            raise InputError("counter_material", wanted=wanted)
        if self.base == "frictionless":
            return self
        low, high = poisson_ratios(material)
        relaxes = high - low > CONSTANT and low <= INCOMPRESSIBLE
        moduli = [one for one in (material.shear, material.bulk) if isinstance(one, PronySeries)]
        if relaxes and any(one.parallel_viscosity > 0.0 for one in moduli):
            wanted = "must have no parallel dashpot on a bonded layer, unless its Poisson ratio is constant in time"
            raise InputError("material", wanted=wanted)
        if relaxes and self.strict and self.path_exponent != 0.0:
            wanted = "must have a Poisson ratio that does not change in time, or stays above "
            wanted += f"{INCOMPRESSIBLE:g}, on a bonded layer; that of this one is between {low:.3g} and {high:.3g}"
            raise InputError("material", wanted=wanted)
        # The same material gives slightly different numbers after changes of its form.
        poisson_ratio = round(material.poisson_ratio, _DIGITS)
        confinement = max(4.0 * high / (1.0 - 2.0 * high), 0.0) if high < 0.5 else np.inf
        known = {"_poisson_ratio": poisson_ratio, "_relaxes": relaxes, "_confinement": confinement}
        if vars(self).items() >= known.items():
            return self
        bound = replace(self)
        vars(bound).update(known)
        return bound

    @property
    def separable(self) -> bool:
        """Whether contacts of all sizes have the reduced modulus of the material."""
        return not self._relaxes

    def effective_moduli(self, material: Material, contact_radius: Array) -> PronyColumns:
        """Reduced moduli [Pa] of contacts up to radii [m]; that of the material where there is no contact."""
        radii = np.ravel(contact_radius / self.thickness)
        if self.path_exponent == 0.0:
            # All contacts have the radius of the punch.
            known = radii[np.isfinite(radii)]
            series = effective_modulus(material, float(known[0]) if known.size else 0.0)
            return PronyColumns.stacked([series]).repeated(radii.size)
        return effective_moduli(material).at(np.where(np.isfinite(radii), _PLACE * radii, 0.0))

    @property
    def _ratio(self) -> float | None:
        """Poisson ratio of a bonded layer."""
        if self.base == "bonded" and self._poisson_ratio is None:
            wanted = "has no Poisson ratio yet: a bonded layer takes that of the material of its Contact or Impact"
            raise InputError("profile", self, wanted)
        return self._poisson_ratio

    @cached_property
    def _depths(self) -> Depths | PunchDepths:
        unit: Any = self.similar.geometry
        return depths(unit.profile, unit.thickness, self._ratio)

    @property
    def _is_several(self) -> bool:
        """Whether layers of several sizes are not similar."""
        return bool(np.ndim(self.thickness)) and not self._is_power_law

    def _each(self, name: str, depth: ArrayLike) -> Array:
        """Evaluate a method of the rows at depths that broadcast with the thickness."""
        rows, shape = self.similar.geometry, np.broadcast_shapes(np.shape(depth), np.shape(self.thickness))
        assert isinstance(rows, LayerRows)
        return getattr(rows.raveled(shape), name)(np.broadcast_to(depth, shape).reshape(-1)).reshape(shape)

    @property
    def _is_power_law(self) -> bool:
        """Whether layers of all sizes are similar."""
        exponent = self.profile.path_exponent
        return exponent is not None and np.ndim(exponent) == 0 and bool(exponent)

    @cached_property
    def similar(self) -> Similar:
        """The layer of thickness 1 m under ``g = x^n``, for a profile that is a power law; rows for several others."""
        if self._is_several:
            ones = np.ones(np.shape(self.thickness))
            return Similar(LayerRows(self.profile, as_array(self.thickness), self._ratio), ones, ones)
        if not self._is_power_law:
            return Similar(self, 1.0, 1.0)
        coefficient: Any = self.profile.path_coefficient
        exponent = float(np.asarray(self.profile.path_exponent))
        unit = replace(self, profile=_unit_power_law(2.0 / exponent), thickness=1.0)
        vars(unit).update(_poisson_ratio=self._poisson_ratio, similar=Similar(unit, 1.0, 1.0))
        with np.errstate(all="ignore"):
            radius: Any = np.asarray(self.thickness / coefficient)[()] ** (2.0 / exponent)
        if not np.all((radius > 0.0) & (radius < math.inf)):
            wanted = "must be nearer to the size of the profile, as their ratio is no number that a double can hold"
            raise InputError("thickness", self.thickness, wanted, "m")
        return Similar(unit, radius if np.ndim(radius) else float(radius), self.thickness)

    def stiffness_radius(self, depth: ArrayLike) -> Array:
        """Stiffness radius a kappa [m] at depth d [m]."""
        if self._is_several:
            return self._each("stiffness_radius", depth)
        return self._depths.stiffness_radius(self._half_space_depth(depth)) * self.similar.radius

    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Force integral int_0^d a kappa dd [m^2] at depth d [m]."""
        if self._is_several:
            return self._each("force_integral_at_depth", depth)
        _, depth_unit, radius_unit = self.similar
        return self._depths.force_integral(self._half_space_depth(depth)) * (depth_unit * radius_unit)

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Contact radius a [m] at depth d [m]."""
        if self._is_several:
            return self._each("contact_radius", depth)
        return self._depths.radius(self._half_space_depth(depth)) * self.similar.radius

    def contact_radius_at(self, depth: ArrayLike, stiffness_radius: ArrayLike) -> Array:
        """Contact radius a [m] from the stiffness radius a kappa [m]."""
        return stored_punches(self._ratio).radius(as_array(stiffness_radius) / self.thickness) * self.thickness

    def curve(self, depth: float) -> Callable[[Array], tuple[Array, Array]]:
        """Function from y^2 in [0, 1], the share of the depth on a half-space, to depths [m] and stiffness radii."""
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
            wanted = f"must be <= {np.min(self.max_depth):g} m, where the tables of the layer end"
            raise InputError("depth", float(np.max(depth)), wanted, "m")
        return self._depths.half_space_depth(np.minimum(place, deepest))

    @property
    def path_exponent(self) -> Numeric | None:
        """Exponent of a kappa = c s^p: 0 for a flat punch, None for other profiles."""
        return 0.0 if self.profile.path_exponent == 0.0 else None

    @property
    def path_coefficient(self) -> Numeric | None:
        """Coefficient of a kappa = c s^p: a kappa [m] for a flat punch, None for other profiles."""
        return float(self.stiffness_radius(0.0)) if self.path_exponent == 0.0 else None

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
        unit: Any = self.similar.geometry if self._is_several else self._depths
        return unit.max_depth * self.similar.depth

    @property
    def kinks(self) -> Kinks:
        """Depths at which a(d) is not smooth: those of the profile, to leading order."""
        return self._depths.kinks


@lru_cache(maxsize=64)
def poisson_ratios(material: Material) -> tuple[float, float]:
    """Smallest and largest Poisson ratio over all times."""
    if material.is_incompressible:
        return 0.5, 0.5
    times = [series.relaxation_times for series in (material.shear, material.bulk) if isinstance(series, PronySeries)]
    known = np.concatenate([*times, [1.0] * all(one.size == 0 for one in times)])
    moments = np.geomspace(0.01 * known.min(), 100.0 * known.max(), _MOMENTS)
    values = material.relaxation_poisson_ratio(moments)
    ends = material.poisson_ratio, material.instantaneous_poisson_ratio
    return float(min(*ends, values.min())), float(max(*ends, values.max()))


@lru_cache(maxsize=32)
def _unit_power_law(exponent: float) -> PowerLaw:
    """Profile with the transform g = x^n."""
    return PowerLaw(exponent, 1.0 / float(PowerLaw(exponent, 1.0).transform(1.0)))
