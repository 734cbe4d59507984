"""Tips whose contact is no circle: ellipsoids and pyramids."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from restitution.checks import Array, Numeric, between, common_shape, finite, number, plain, refuse, single
from restitution.contact.geometry import Geometry, as_array
from restitution.contact.profiles import Parabola, Profile
from restitution.errors import InputError, InputTypeError
from restitution.quantities import INPUTS
from restitution.units import ANGLE

# Ellipsoid: the elliptical contact of bodies whose curvature differs between two directions.

# Largest ratio of the radii, for which the semi-axes differ by a factor of 3000; beyond lies the line contact.
_MOST_RATIO = 1e6
# Newton's method from a start within 0.4 of ln k reaches rounding in three steps at every ratio.
_STEPS = 4


@dataclass(frozen=True, eq=False)
class Ellipsoid(Geometry, case_name="ellipsoid"):
    """Gap ``z = x^2/(2 R_1) + y^2/(2 R_2)`` of two principal radii: the elliptical contact of Hertz.

    Parameters
    ----------
    radius_1, radius_2 : float or array
        Principal radii R_1 and R_2 of the gap [m], > 0, in any order; their ratio is at most 1e6. For a rigid body on
        a flat target they are those of the body.

    Attributes
    ----------
    axis_ratio : float or array
        Short over long semi-axis of the contact, b/a, the same at all depths.
    effective_radius : float or array
        Radius R_eff [m] of the parabola with the same force at every depth.

    Raises
    ------
    InputError
        If a radius is not finite and > 0, or the ratio is larger.

    Notes
    -----
    With ``A = 1/(2 max(R_1, R_2))``, ``B = 1/(2 min(R_1, R_2))`` and k = b/a, ``B/A = R_D(0, 1, k^2)/R_D(0, k^2, 1)``
    gives k. Then ``a^2 = d D/(A K)`` and ``R_eff = (pi^2/4) D/(A K^3)``, with the complete elliptic integral K of the
    modulus ``sqrt(1 - k^2)`` and ``D = R_D(0, k^2, 1)/3`` (Hertz 1882; Johnson, Contact Mechanics, 1985, section 4.2).
    The stiffness radius is ``pi a/(2 K) = sqrt(R_eff d)``. As contacts of all depths are similar, impacts and
    indentations are exactly those of the parabola R_eff, and the pressure is that of the parabola on stretched axes.
    The contact radius is that of a disc of equal area, ``sqrt(a b)``. Valid for a much smaller than R_1, b than R_2.

    Examples
    --------
    >>> roller = Ellipsoid(0.05, 0.01)
    >>> print(round(roller.axis_ratio, 9), round(roller.effective_radius, 9))
    0.345999087 0.024820041
    >>> print(*roller.semi_axes(roller.contact_radius(1e-5)).round(8))
    0.00079092 0.00027366
    """

    sources = (("hertz1882", "elliptical contact"), ("carlson1995", "elliptic integrals of the semi-axes"))
    obstacle = "the contact is an ellipse"

    radius_1: Annotated[Numeric, INPUTS["radius_1"]]
    radius_2: Annotated[Numeric, INPUTS["radius_2"]]
    axis_ratio: Numeric = field(init=False, repr=False, compare=False)
    effective_radius: Numeric = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        from scipy.special import elliprd, elliprf

        super().__post_init__()
        common_shape({name: np.shape(getattr(self, name)) for name in ("radius_1", "radius_2")})
        first, second = np.broadcast_arrays(self.radius_1, self.radius_2)
        large, small = np.maximum(first, second), np.minimum(first, second)
        with np.errstate(over="ignore"):
            ratio = large / small
        if np.any(ratio > _MOST_RATIO):
            rule = f"must be at most {_MOST_RATIO:g}: longer contacts are those of a cylinder, which has no depth"
            raise InputError("radius_1/radius_2", float(np.max(ratio)), rule)
        k = _axis_ratio(ratio)
        first_kind, d = elliprf(0.0, k * k, 1.0), elliprd(0.0, k * k, 1.0) / 3.0
        object.__setattr__(self, "axis_ratio", plain(k))
        # A product, unlike a power, gives the same bits for numbers and arrays.
        cubed = first_kind * first_kind * first_kind
        object.__setattr__(self, "effective_radius", plain(0.5 * math.pi**2 * large * d / cubed))

    @classmethod
    def of_bodies(cls, radii_1: ArrayLike, radii_2: ArrayLike, *, angle: Any = 0.0) -> Ellipsoid:
        """Return the gap between two bodies.

        Parameters
        ----------
        radii_1, radii_2 : pair of float
            Principal radii of curvature [m] of each body at the point of contact: positive where it is convex,
            negative where it is hollow, infinite where it is straight. A ball has two equal ones, a cylinder an
            infinite one.
        angle : float
            Angle [rad] between the directions of the first radius of each body.

        Raises
        ------
        InputError
            If a radius is zero or NaN, or the bodies do not touch in a single point.

        Notes
        -----
        The curvature of the gap is the sum of those of the bodies (Johnson, Contact Mechanics, 1985, section 4.1).

        Examples
        --------
        A ball of 10 mm on a roller of 50 mm:

        >>> gap = Ellipsoid.of_bodies((0.01, 0.01), (0.05, np.inf))
        >>> print(round(gap.radius_1, 9), round(gap.radius_2, 9))
        0.01 0.008333333
        """
        turn = single("angle", finite("angle", angle, ANGLE.unit), "rad")
        curvatures = np.array([_curvatures("radii_1", radii_1), _curvatures("radii_2", radii_2)])
        (p, q), (r, s) = curvatures
        total = curvatures.sum()
        # The determinant of the sum of both tensors. As a difference of squares it would cancel for long contacts.
        product = p * q + r * s + (p * s + q * r) * math.cos(turn) ** 2 + (p * r + q * s) * math.sin(turn) ** 2
        if not (total > 0.0 and product > 0.0):
            rule = "must touch in a single point: the gap must open in every direction"
            raise InputError("radii_1, radii_2, angle", [*np.ravel(radii_1), *np.ravel(radii_2), turn], rule)
        large = 0.5 * (total + math.hypot(p - q + (r - s) * math.cos(2.0 * turn), (r - s) * math.sin(2.0 * turn)))
        return cls(large / product, 1.0 / large)

    def mean_radius(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Return the contact radius [m] of the ellipse through x [m] along its long and y [m] along its short axis.

        It is the radius for `ImpactResult.pressure`, which is constant along similar ellipses.
        """
        return np.hypot(np.sqrt(self.axis_ratio) * as_array(x), as_array(y) / np.sqrt(self.axis_ratio))

    def stiffness_radius(self, depth: ArrayLike) -> Array:
        """Return the stiffness radius sqrt(R_eff d) [m]."""
        return np.sqrt(self.effective_radius * np.maximum(as_array(depth), 0.0))

    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Return the force integral (2/3) sqrt(R_eff) d^(3/2) [m^2]."""
        return 2.0 / 3.0 * self.stiffness_radius(depth) * np.maximum(as_array(depth), 0.0)

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Return the contact radius sqrt(a b) [m], that of a disc of equal area."""
        return self._stretch * self.stiffness_radius(depth)

    @property
    def image(self) -> Profile:
        """The parabola of the radius R_eff."""
        return Parabola(self.effective_radius)

    @property
    def _stretch(self) -> Numeric:
        """Contact radius over stiffness radius."""
        from scipy.special import elliprf

        first_kind = elliprf(0.0, np.square(self.axis_ratio), 1.0)
        return plain(2.0 / math.pi * first_kind * np.sqrt(self.axis_ratio))

    @property
    def tip_radius(self) -> Numeric:
        """Radius [m] for which the contact radius over it is the strain b/R of the more curved direction."""
        return plain(np.minimum(self.radius_1, self.radius_2) / np.sqrt(self.axis_ratio))

    @property
    def ball_radius(self) -> Numeric:
        """NaN: the volume of the body does not follow from its curvature."""
        return math.nan

    @property
    def path_exponent(self) -> Numeric:
        """Exponent of a = c s^p: 1."""
        return 1.0

    @property
    def path_coefficient(self) -> Numeric:
        """Coefficient of a = c s^p: sqrt(R_eff) [m^(1/2)]."""
        return plain(np.sqrt(self.effective_radius))


def crossed_cylinders(radius_1: Any, radius_2: Any, *, angle: Any = 0.5 * math.pi) -> Ellipsoid:
    """Return the gap between two cylinders that touch in a point.

    Parameters
    ----------
    radius_1, radius_2 : float
        Radii [m] of the cylinders, > 0; a negative one is that of a hollow cylinder around the other.
    angle : float
        Angle [rad] between their axes, in (0, pi).

    Returns
    -------
    Ellipsoid
        As geometry of an `Impact`, an indentation or a contact law.

    Raises
    ------
    InputError
        If a radius is zero or NaN, the angle is out of range, or the cylinders do not touch in a single point.

    Examples
    --------
    Equal cylinders at right angles touch like a ball on a flat target:

    >>> gap = crossed_cylinders(0.01, 0.01)
    >>> print(round(gap.axis_ratio, 12), round(gap.effective_radius, 12))
    1.0 0.01
    """
    sizes = {"radius_1": radius_1, "radius_2": radius_2}
    radii = [single(name, finite(name, radius, "m"), "m") for name, radius in sizes.items()]
    turn = single("angle", between("angle", angle, 0.0, math.pi, ANGLE.unit), "rad")
    return Ellipsoid.of_bodies((radii[0], math.inf), (radii[1], math.inf), angle=turn)


def _curvatures(name: str, radii: ArrayLike) -> Array:
    values = number(name, radii, "m")
    if values.shape != (2,):
        raise InputTypeError(name, radii, "must be a pair of principal radii", "m")
    good = np.isinf(values) | ((np.abs(values) >= 1e-100) & (np.abs(values) <= 1e100))
    rule = "must be of a size in [1e-100, 1e+100] m, or infinite where the body is straight"
    refuse(name, values, ~good, rule, "m")
    return 1.0 / values


def _axis_ratio(ratio: Array) -> Array:
    """Solve B/A = R_D(0, 1, k^2)/R_D(0, k^2, 1) for k by Newton's method in the logarithms of both sides."""
    from scipy.special import elliprd

    logarithm = np.log(ratio)
    log_k = -logarithm / 1.5 * (1.0 - 0.25 * logarithm / (logarithm + 6.0))
    for _ in range(_STEPS):
        squared = np.exp(2.0 * log_k)
        quotient = elliprd(0.0, 1.0, squared) / elliprd(0.0, squared, 1.0)
        # The slope is between 1.5, at a circle, where its closed form is 0/0, and 2.
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = np.fmax(1.5, np.fmin(2.0 + (1.0 / quotient - squared * quotient) / (1.0 - squared), 2.0))
        log_k = log_k + (np.log(quotient) - logarithm) / slope
    return np.exp(log_k)


# Pyramid: sharp tips with three, four or six faces.


class _Constant(NamedTuple):
    """Factor c of the force, and its uncertainty."""

    value: float
    uncertainty: float


# Boundary elements on 64^2 to 512^2 cells, extrapolated; a cone has 2/pi.
_CONSTANTS = {3: _Constant(0.882413, 5e-6), 4: _Constant(0.737616, 3e-6), 6: _Constant(0.67330, 1e-5)}


@dataclass(frozen=True, eq=False)
class Pyramid(Geometry, case_name="pyramid"):
    """Regular pyramid with three, four or six faces.

    Parameters
    ----------
    face_angle : float or array
        Angle alpha [rad] from the axis to the middle of a face, in (0, pi/2). The angle to an edge is larger. A tip
        with four faces and "half opening angle 35 deg" of its faces has 35 deg.
    sides : int
        Number of faces: 3, 4 or 6.

    Attributes
    ----------
    constant, uncertainty : float
        Factor c of the force, and its uncertainty.

    Raises
    ------
    InputError
        If an angle is not in (0, pi/2), or the number of faces is another.

    Notes
    -----
    ``F = c tan(alpha) E* d^2`` with c = 0.882413(5) for three, 0.737616(3) for four and 0.67330(1) for six faces;
    a cone has 2/pi. The constants are from boundary elements on the half-space, extrapolated to fine meshes; the
    approximate 0.7453 of Bilodeau (1992) for four faces is 1.0 % above, 1/sqrt(2) of software for force microscopes
    4.1 % below. The stiffness radius is ``c tan(alpha) d``. Valid for small slopes cot(alpha) only, which the validity
    report compares: Berkovich (65.3 deg), Vickers (68 deg) and sharper tips are beyond them. The contact is no disc,
    and its radius and pressure are not known.

    Examples
    --------
    >>> import math
    >>> tip = Pyramid(face_angle=math.radians(80), sides=4)
    >>> print(tip.constant, tip.uncertainty, round(float(tip.stiffness_radius(1e-6)), 9))
    0.737616 3e-06 4.183e-06
    """

    obstacle = "the pressure under a pyramid is not known"

    face_angle: Annotated[Numeric, INPUTS["face_angle"]]
    sides: int = 4

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.sides, (int, np.integer)) or self.sides not in _CONSTANTS:
            raise InputError("sides", self.sides, "must be 3, 4 or 6")
        object.__setattr__(self, "sides", int(self.sides))

    @property
    def constant(self) -> float:
        """Factor c of the force."""
        return _CONSTANTS[self.sides].value

    @property
    def uncertainty(self) -> float:
        """Uncertainty of the factor c."""
        return _CONSTANTS[self.sides].uncertainty

    @property
    def slope(self) -> Numeric:
        """Slope cot(alpha) of the faces."""
        return plain(1.0 / np.tan(self.face_angle))

    def stiffness_radius(self, depth: ArrayLike) -> Array:
        """Return the stiffness radius c tan(alpha) d [m]."""
        return self.path_coefficient * np.maximum(as_array(depth), 0.0)

    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Return the force integral (c/2) tan(alpha) d^2 [m^2]."""
        return 0.5 * self.path_coefficient * np.maximum(as_array(depth), 0.0) ** 2

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Return NaN: the contact radius is not known."""
        return np.full(np.broadcast(as_array(depth), self.face_angle).shape, np.nan)[()]

    @property
    def path_exponent(self) -> Numeric:
        """Exponent of a = c s^p: 2."""
        return 2.0

    @property
    def path_coefficient(self) -> Numeric:
        """Coefficient of a = c s^p: c tan(alpha) [-]."""
        return plain(self.constant * np.tan(self.face_angle))
