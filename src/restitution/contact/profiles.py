"""Axisymmetric indenter profiles: the interface that all share, power laws, spheres and flat-ended tips.

The method of dimensionality reduction maps a profile f(r) onto g(x), the depth at which the contact radius is x. An
impact needs the contact radius over the depth, a(d), and its integral, the force integral.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from restitution.checks import Array, Numeric, finite, plain
from restitution.contact.geometry import Geometry, as_array
from restitution.errors import InputError
from restitution.quantities import INPUTS, NUMBER, Quantity


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
        """Return the profile f(r) [m] at radius r [m]."""

    @abstractmethod
    def transform(self, x: ArrayLike) -> Array:
        """Return the transformed profile g(x) [m]: the depth at which the contact radius is x [m]."""

    @abstractmethod
    def contact_radius(self, depth: ArrayLike) -> Array:
        """Return the contact radius a = g^-1(d) [m] of the approach at depth d >= 0 [m]; 0 where d < 0."""

    @abstractmethod
    def force_integral(self, contact_radius: ArrayLike) -> Array:
        """Return the force integral Pi(a) = int_0^a x g'(x) dx [m^2] at contact radius a [m]."""

    def stiffness_radius(self, depth: ArrayLike) -> Array:
        """Return the stiffness radius [m] at depth d [m]: the contact radius."""
        return self.contact_radius(depth)

    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Return the force integral int_0^d a dd [m^2] at depth d [m], which also a flat punch has."""
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
        """Return the profile f = r^2/(2R) [m]."""
        return as_array(r) ** 2 / (2.0 * self.radius)

    def transform(self, x: ArrayLike) -> Array:
        """Return the transformed profile g = x^2/R [m]."""
        return as_array(x) ** 2 / self.radius

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Return the contact radius a = sqrt(R d) [m]."""
        return np.sqrt(self.radius * np.maximum(as_array(depth), 0.0))

    def force_integral(self, contact_radius: ArrayLike) -> Array:
        """Return the force integral Pi = 2 a^3/(3R) [m^2]."""
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


# Cone, power law and flat punch: like the parabola, their contact radius is a power of the depth.


@dataclass(frozen=True, eq=False)
class Cone(Profile, case_name="cone"):
    """Cone f = r cot(alpha).

    Parameters
    ----------
    half_angle : float or array
        Half of the opening angle alpha [rad], from the axis to the flank, in (0, pi/2). Small strain needs a blunt
        cone, alpha near pi/2.

    Raises
    ------
    ValueError
        If an angle is not in (0, pi/2).

    Notes
    -----
    ``g = (pi/2) cot(alpha) x``, ``Pi = (pi/4) cot(alpha) a^2`` (Love 1939, Sneddon 1965). The angle between flank and
    surface, which others use, is pi/2 - alpha.

    Examples
    --------
    >>> import math
    >>> cone = Cone(half_angle=math.radians(70.3))
    >>> round(float(cone.contact_radius(1e-6)), 9)
    1.778e-06
    """

    sources = (("love1939", "contact of a cone"), ("sneddon1965", "transform of the profile"))

    half_angle: Annotated[Numeric, INPUTS["half_angle"]]

    @property
    def _slope(self) -> Numeric:
        with np.errstate(all="ignore"):  # an impact of a cone that is too sharp for doubles fails in the kernel
            return plain(1.0 / np.tan(self.half_angle))

    def shape(self, r: ArrayLike) -> Array:
        """Return the profile f = r cot(alpha) [m]."""
        return np.abs(as_array(r)) * self._slope

    def transform(self, x: ArrayLike) -> Array:
        """Return the transformed profile g = (pi/2) cot(alpha) x [m]."""
        return 0.5 * math.pi * np.abs(as_array(x)) * self._slope

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Return the contact radius a = (2/pi) tan(alpha) d [m]."""
        return 2.0 / math.pi * np.maximum(as_array(depth), 0.0) / self._slope

    def force_integral(self, contact_radius: ArrayLike) -> Array:
        """Return the force integral Pi = (pi/4) cot(alpha) a^2 [m^2]."""
        return 0.25 * math.pi * as_array(contact_radius) ** 2 * self._slope

    @property
    def path_exponent(self) -> Numeric:
        """Exponent of a = c s^p: 2."""
        return 2.0

    @property
    def path_coefficient(self) -> Numeric:
        """Coefficient of a = c s^p: (2/pi) tan(alpha) [-]."""
        return 2.0 / math.pi / self._slope


def transform_factor(exponent: float) -> float:
    """Return kappa_n = (sqrt(pi)/2) n Gamma(n/2)/Gamma((n+1)/2), by which r^n transforms into kappa_n x^n."""
    if exponent < 300.0:
        return math.sqrt(math.pi) * math.gamma(0.5 * exponent + 1.0) / math.gamma(0.5 * (exponent + 1.0))
    # Expansion of the quotient for large arguments; the next term is below 2e-14.
    w = 1.0 / exponent
    series = 1.0 + 0.25 * w * (1.0 + 0.125 * w * (1.0 - 1.25 * w * (1.0 + 0.2625 * w)))
    return math.sqrt(0.5 * math.pi * exponent) * series


@dataclass(frozen=True, eq=False)
class PowerLaw(Profile, case_name="power_law"):
    """Power-law profile f = A r^n.

    Parameters
    ----------
    exponent : float or array
        Exponent n [-], > 0. The theory of small slopes requires n >= 1; below, the slope and the pressure at r = 0 are
        infinite.
    coefficient : float or array
        Coefficient A [m^(1-n)], > 0.

    Raises
    ------
    ValueError
        If the exponent or the coefficient is not finite and > 0.

    Notes
    -----
    ``g = kappa_n A x^n`` with ``kappa_n = (sqrt(pi)/2) n Gamma(n/2)/Gamma((n+1)/2)`` (Galin 1946; Popov and Hess
    2015), ``Pi = kappa_n A n a^(n+1)/(n+1)``. n = 1 is a cone, n = 2 a parabola, n -> inf a flat punch.

    Examples
    --------
    >>> parabola = PowerLaw(exponent=2, coefficient=50.0)
    >>> round(float(parabola.contact_radius(1e-4)), 12), parabola.path_exponent
    (0.001, 1.0)
    """

    sources = (("galin1961", "contact of a power-law profile"), ("sneddon1965", "transform of the profile"))

    exponent: Annotated[Numeric, Quantity("exponent", NUMBER, "exponent of the power law", "$n$", 0.0, open=True)]
    coefficient: Annotated[Numeric, Quantity("coefficient", NUMBER, "coefficient in m^(1-n)", "$A$", 0.0, open=True)]
    _transformed: Numeric = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        factor = np.vectorize(transform_factor, otypes=[np.float64])(self.exponent)
        with np.errstate(over="ignore"):
            transformed = finite("coefficient", factor * self.coefficient)
        object.__setattr__(self, "_transformed", transformed)

    def shape(self, r: ArrayLike) -> Array:
        """Return the profile f = A r^n [m]."""
        return self.coefficient * np.abs(as_array(r)) ** self.exponent

    def transform(self, x: ArrayLike) -> Array:
        """Return the transformed profile g = kappa_n A x^n [m]."""
        return self._transformed * np.abs(as_array(x)) ** self.exponent

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Return the contact radius a = (d/(kappa_n A))^(1/n) [m]."""
        return (np.maximum(as_array(depth), 0.0) / self._transformed) ** (1.0 / np.asarray(self.exponent))

    def force_integral(self, contact_radius: ArrayLike) -> Array:
        """Return the force integral Pi = kappa_n A n a^(n+1)/(n+1) [m^2]."""
        n = self.exponent
        return self._transformed * n / (n + 1.0) * as_array(contact_radius) ** (n + 1.0)

    @property
    def apart(self) -> tuple[str, ...]:
        """The exponent."""
        return ("exponent",)

    @property
    def path_exponent(self) -> Numeric:
        """Exponent of a = c s^p: 2/n."""
        with np.errstate(over="ignore"):  # an impact without a finite number fails in the kernel
            return plain(2.0 / np.asarray(self.exponent))

    @property
    def path_coefficient(self) -> Numeric:
        """Coefficient of a = c s^p: (kappa_n A)^(-1/n)."""
        with np.errstate(all="ignore"):  # an impact without a finite number fails in the kernel
            return plain(np.asarray(self._transformed) ** (-1.0 / np.asarray(self.exponent)))


@dataclass(frozen=True, eq=False)
class FlatPunch(Profile, case_name="flat_punch"):
    """Flat-ended cylinder, whose contact radius does not depend on depth.

    Parameters
    ----------
    radius : float or array
        Radius a of the face [m], > 0.

    Raises
    ------
    ValueError
        If a radius is not finite and > 0.

    Notes
    -----
    g = 0 under the face and infinite beside it; ``int_0^d a dd = a d``, ``F = 2 E* a d`` (Boussinesq 1885).

    Examples
    --------
    >>> punch = FlatPunch(radius=0.002)
    >>> float(punch.contact_radius(1e-5)), float(punch.force_integral_at_depth(0.5))
    (0.002, 0.001)
    """

    sources = (("boussinesq1885", "contact of a flat punch"),)

    radius: Annotated[Numeric, INPUTS["radius"]]

    def shape(self, r: ArrayLike) -> Array:
        """Return the profile [m]: 0 under the face, infinite beside it."""
        return np.where(np.abs(as_array(r)) <= self.radius, 0.0, np.inf)

    def transform(self, x: ArrayLike) -> Array:
        """Return the transformed profile [m]: 0 under the face, infinite beside it."""
        return self.shape(x)

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Return the contact radius [m]: the radius of the face where d >= 0."""
        return np.where(as_array(depth) >= 0.0, self.radius, 0.0)

    def force_integral(self, contact_radius: ArrayLike) -> Array:
        """Refuse: the depth does not follow from the contact radius."""
        raise ValueError("a flat punch has the same contact radius at every depth: use force_integral_at_depth")

    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Return the force integral a d [m^2] at depth d [m]."""
        return self.radius * np.maximum(as_array(depth), 0.0)

    @property
    def path_exponent(self) -> Numeric:
        """Exponent of a = c s^p: 0."""
        return 0.0

    @property
    def path_coefficient(self) -> Numeric:
        """Coefficient of a = c s^p: the radius of the face [m]."""
        return self.radius


# Analytic profiles whose contact radius is no power of the depth: sphere and flat-ended tips.
#
# A flat face touches at depth 0, so the contact radius starts at that of the face; from there it grows with the square
# of the depth, which makes a(s) smooth.


def sphere_mass(density: Any, radius: Any) -> Any:
    """Return the mass m = (4/3) pi rho R^3 [kg] of a solid sphere of density rho [kg/m^3] and radius R [m]."""
    # A product, unlike a power, gives the same bits for numbers and arrays.
    # An impact with an infinite mass is refused, or fails with NOT_FINITE.
    with np.errstate(over="ignore"):
        return 4.0 / 3.0 * math.pi * density * radius * radius * radius


@dataclass(frozen=True, eq=False)
class Sphere(Profile, case_name="sphere", body_radius=True):
    """Sphere f = R - sqrt(R^2 - r^2), the exact circle.

    Parameters
    ----------
    radius : float or array
        Radius R [m], > 0.

    Raises
    ------
    ValueError
        If a radius is not finite and > 0.

    Notes
    -----
    ``g = x artanh(x/R)``, ``Pi = ((R^2 + a^2) artanh(a/R) - a R)/2`` (Segedin 1957, Sneddon 1965). The shape is exact,
    but the half-space is still linear with small slopes: at a/R = 0.2 the force at equal depth is 0.4 % below that of
    the parabola, and as a -> R, d -> infinity.

    Examples
    --------
    >>> ball = Sphere(radius=0.01)
    >>> round(float(ball.transform(0.005)), 9), round(float(ball.contact_radius(0.0027465307216702744)), 9)
    (0.002746531, 0.005)
    """

    sources = (("segedin1957", "transform of the exact sphere"),)

    radius: Annotated[Numeric, INPUTS["radius"]]

    def shape(self, r: ArrayLike) -> Array:
        """Return the profile f = R - sqrt(R^2 - r^2) [m]; infinite beyond the equator."""
        r, radius = np.abs(as_array(r)), self.radius
        height = np.sqrt(np.maximum((radius - r) * (radius + r), 0.0))
        return np.where(r <= radius, r * (r / (radius + height)), np.inf)

    def transform(self, x: ArrayLike) -> Array:
        """Return the transformed profile g = x artanh(x/R) [m]; infinite from the equator on."""
        x = np.abs(as_array(x))
        inside = x < self.radius
        return np.where(inside, x * np.arctanh(np.where(inside, x / self.radius, 0.0)), np.inf)

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Return the contact radius a [m], the root of d = a artanh(a/R)."""
        return self.radius * np.tanh(self._rapidity(depth))

    def force_integral(self, contact_radius: ArrayLike) -> Array:
        """Return the force integral Pi = ((R^2 + a^2) artanh(a/R) - a R)/2 [m^2]; infinite at the equator."""
        a = as_array(contact_radius)
        inside = a < self.radius
        rapidity = np.arctanh(np.where(inside, a / self.radius, 0.0))
        return np.where(inside, self._force_integral(rapidity), np.inf)

    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Return the force integral int_0^d a dd [m^2] at depth d [m]."""
        return self._force_integral(self._rapidity(depth))

    @property
    def max_contact_radius(self) -> Numeric:
        """The radius R [m] of the equator, which is reached at infinite depth."""
        return self.radius

    @property
    def tip_radius(self) -> Numeric:
        """Radius R [m]."""
        return self.radius

    def _rapidity(self, depth: ArrayLike) -> Array:
        # The root of L tanh(L) = d/R: unlike a = R tanh(L), L keeps its digits as a -> R.
        ratio = np.maximum(as_array(depth), 0.0) / self.radius
        rapidity = np.sqrt(ratio * (1.0 + ratio))
        # The start is within 18 %, and five Newton steps reach rounding level at every depth.
        for _ in range(5):
            tanh = np.tanh(rapidity)
            slope = tanh + rapidity * (1.0 - tanh * tanh)
            step = (rapidity * tanh - ratio) / np.where(slope > 0.0, slope, 1.0)
            rapidity = rapidity - step
        return rapidity

    def _force_integral(self, rapidity: Array) -> Array:
        u = np.tanh(rapidity)
        closed = (1.0 + u * u) * rapidity - u
        # The closed form cancels for a << R; its series ends at 1e-17 relative below u = 0.25.
        small = np.minimum(u, 0.25)
        series = np.zeros_like(small)
        for k in range(14, 0, -1):
            series = series * small * small + 4.0 * k / (4.0 * k * k - 1.0)
        return 0.5 * np.asarray(self.radius) ** 2 * np.where(u < 0.25, series * small**3, closed)


def _flank_root(x: Array, face: Numeric) -> Array:
    """Return sqrt(x^2 - b^2) where |x| > b, else 0."""
    x = np.abs(x)
    return np.sqrt(np.maximum((x - face) * (x + face), 0.0))


@dataclass(frozen=True, eq=False)
class TruncatedCone(Profile, case_name="truncated_cone"):
    """Truncated cone: flat for r < b, f = (r - b) cot(alpha) beyond.

    Parameters
    ----------
    radius : float or array
        Radius b of the flat face [m], > 0.
    half_angle : float or array
        Half of the opening angle alpha [rad], measured from the axis to the flank, in (0, pi/2).

    Raises
    ------
    ValueError
        If the radius is not finite and > 0 or the angle not in (0, pi/2).

    Notes
    -----
    With ``a = b/cos(theta)``: ``d = b cot(alpha) theta/cos(theta)``, ``Pi = (cot(alpha)/2) b^2 (theta/cos^2(theta) +
    tan(theta))`` (Popov, Hess and Willert, Handbook of Contact Mechanics, 2019).

    Examples
    --------
    >>> import math
    >>> tip = TruncatedCone(radius=0.001, half_angle=math.radians(80))
    >>> float(tip.contact_radius(0.0)), round(float(tip.transform(0.002)), 9)
    (0.001, 0.000369298)
    """

    sources = (("popov2019", "transform of a flat-ended profile"),)

    radius: Annotated[Numeric, INPUTS["radius"]]
    half_angle: Annotated[Numeric, INPUTS["half_angle"]]

    @property
    def _slope(self) -> Numeric:
        return plain(1.0 / np.tan(self.half_angle))

    def shape(self, r: ArrayLike) -> Array:
        """Return the profile f = max(r - b, 0) cot(alpha) [m]."""
        return np.maximum(np.abs(as_array(r)) - self.radius, 0.0) * self._slope

    def transform(self, x: ArrayLike) -> Array:
        """Return the transformed profile g = x cot(alpha) arccos(b/x) [m] beyond the face."""
        x = np.abs(as_array(x))
        return x * self._slope * np.arctan2(_flank_root(x, self.radius), self.radius)

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Return the contact radius a [m], the root of d = g(a); that of the face at d = 0."""
        _, complement = self._angles(depth)
        return np.where(as_array(depth) >= 0.0, self.radius / np.sin(complement), 0.0)

    def force_integral(self, contact_radius: ArrayLike) -> Array:
        """Return the force integral Pi = (cot(alpha)/2) (a^2 arccos(b/a) + b sqrt(a^2 - b^2)) [m^2]."""
        a = as_array(contact_radius)
        root = _flank_root(a, self.radius)
        return 0.5 * self._slope * (a * a * np.arctan2(root, self.radius) + self.radius * root)

    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Return the force integral int_0^d a dd [m^2] at depth d [m]."""
        theta, complement = self._angles(depth)
        cosine = np.sin(complement)
        return 0.5 * self._slope * self.radius**2 * (theta / cosine**2 + np.sin(theta) / cosine)

    def _angles(self, depth: ArrayLike) -> tuple[Array, Array]:
        # theta = D cos(theta) keeps its digits at small depth, its complement at large depth. Both residuals are
        # convex, and Newton's method descends on them from the right without overshooting.
        ratio = np.maximum(as_array(depth), 0.0) / (self.radius * np.asarray(self._slope))
        theta = 0.5 * math.pi * ratio / (1.0 + ratio)
        for _ in range(6):
            theta = theta - (theta - ratio * np.cos(theta)) / (1.0 + ratio * np.sin(theta))
        complement = 0.5 * math.pi - theta
        for _ in range(2):
            complement = complement - (complement + ratio * np.sin(complement) - 0.5 * math.pi) / (
                1.0 + ratio * np.cos(complement)
            )
        return theta, complement


@dataclass(frozen=True, eq=False)
class FlatEndedParabola(Profile, case_name="flat_ended_parabola", body_radius=True):
    """Paraboloid with a flat worn face: flat for r < b, f = (r^2 - b^2)/(2R) beyond.

    Parameters
    ----------
    radius : float or array
        Radius of curvature R of the paraboloid [m], > 0.
    face_radius : float or array
        Radius b of the flat face [m], > 0.

    Raises
    ------
    ValueError
        If a radius is not finite and > 0.

    Notes
    -----
    ``g = x sqrt(x^2 - b^2)/R``, ``Pi = (2 a^2 + b^2) sqrt(a^2 - b^2)/(3R)`` (Popov, Hess and Willert, Handbook of
    Contact Mechanics, 2019).

    Examples
    --------
    >>> worn = FlatEndedParabola(radius=0.01, face_radius=0.001)
    >>> float(worn.contact_radius(0.0)), round(float(worn.transform(0.002)), 9)
    (0.001, 0.00034641)
    """

    sources = (("popov2019", "transform of a flat-ended profile"),)

    radius: Annotated[Numeric, INPUTS["radius"]]
    face_radius: Annotated[Numeric, INPUTS["face_radius"]]

    def shape(self, r: ArrayLike) -> Array:
        """Return the profile f = max(r^2 - b^2, 0)/(2R) [m]."""
        return _flank_root(as_array(r), self.face_radius) ** 2 / (2.0 * self.radius)

    def transform(self, x: ArrayLike) -> Array:
        """Return the transformed profile g = x sqrt(x^2 - b^2)/R [m] beyond the face."""
        x = np.abs(as_array(x))
        return x * _flank_root(x, self.face_radius) / self.radius

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Return the contact radius a [m] with 2 a^2 = b^2 + sqrt(b^4 + 4 R^2 d^2); that of the face at d = 0."""
        return np.where(as_array(depth) >= 0.0, np.sqrt(self._squared_radius(depth)), 0.0)

    def force_integral(self, contact_radius: ArrayLike) -> Array:
        """Return the force integral Pi = (2 a^2 + b^2) sqrt(a^2 - b^2)/(3R) [m^2]."""
        a = as_array(contact_radius)
        root = _flank_root(a, self.face_radius)
        return (2.0 * a * a + np.asarray(self.face_radius) ** 2) * root / (3.0 * self.radius)

    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Return the force integral int_0^d a dd [m^2] at depth d [m]."""
        squared = self._squared_radius(depth)
        root = np.maximum(as_array(depth), 0.0) * self.radius / np.sqrt(squared)
        return (2.0 * squared + np.asarray(self.face_radius) ** 2) * root / (3.0 * self.radius)

    def _squared_radius(self, depth: ArrayLike) -> Array:
        half = 0.5 * np.asarray(self.face_radius) ** 2
        return half + np.hypot(half, self.radius * np.maximum(as_array(depth), 0.0))
