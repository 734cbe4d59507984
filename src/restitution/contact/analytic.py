"""Analytic profiles whose contact radius is no power of the depth: sphere and flat-ended tips.

A flat face touches at depth 0, so the contact radius starts at that of the face; from there it grows with the square
of the depth, which makes a(s) smooth.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from restitution.checks import Numeric
from restitution.contact.geometry import Array, as_array, plain
from restitution.contact.profile import Profile
from restitution.quantities import INPUTS


def sphere_mass(density: Any, radius: Any) -> Any:
    """Mass m = (4/3) pi rho R^3 [kg] of a solid sphere of density rho [kg/m^3] and radius R [m]."""
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
        """Profile f = R - sqrt(R^2 - r^2) [m]; infinite beyond the equator."""
        r, radius = np.abs(as_array(r)), self.radius
        height = np.sqrt(np.maximum((radius - r) * (radius + r), 0.0))
        return np.where(r <= radius, r * (r / (radius + height)), np.inf)

    def transform(self, x: ArrayLike) -> Array:
        """Transformed profile g = x artanh(x/R) [m]; infinite from the equator on."""
        x = np.abs(as_array(x))
        inside = x < self.radius
        return np.where(inside, x * np.arctanh(np.where(inside, x / self.radius, 0.0)), np.inf)

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Contact radius a [m], the root of d = a artanh(a/R)."""
        return self.radius * np.tanh(self._rapidity(depth))

    def force_integral(self, contact_radius: ArrayLike) -> Array:
        """Force integral Pi = ((R^2 + a^2) artanh(a/R) - a R)/2 [m^2]; infinite at the equator."""
        a = as_array(contact_radius)
        inside = a < self.radius
        rapidity = np.arctanh(np.where(inside, a / self.radius, 0.0))
        return np.where(inside, self._force_integral(rapidity), np.inf)

    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Force integral int_0^d a dd [m^2] at depth d [m]."""
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
        """Profile f = max(r - b, 0) cot(alpha) [m]."""
        return np.maximum(np.abs(as_array(r)) - self.radius, 0.0) * self._slope

    def transform(self, x: ArrayLike) -> Array:
        """Transformed profile g = x cot(alpha) arccos(b/x) [m] beyond the face."""
        x = np.abs(as_array(x))
        return x * self._slope * np.arctan2(_flank_root(x, self.radius), self.radius)

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Contact radius a [m], the root of d = g(a); that of the face at d = 0."""
        _, complement = self._angles(depth)
        return np.where(as_array(depth) >= 0.0, self.radius / np.sin(complement), 0.0)

    def force_integral(self, contact_radius: ArrayLike) -> Array:
        """Force integral Pi = (cot(alpha)/2) (a^2 arccos(b/a) + b sqrt(a^2 - b^2)) [m^2]."""
        a = as_array(contact_radius)
        root = _flank_root(a, self.radius)
        return 0.5 * self._slope * (a * a * np.arctan2(root, self.radius) + self.radius * root)

    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Force integral int_0^d a dd [m^2] at depth d [m]."""
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
        """Profile f = max(r^2 - b^2, 0)/(2R) [m]."""
        return _flank_root(as_array(r), self.face_radius) ** 2 / (2.0 * self.radius)

    def transform(self, x: ArrayLike) -> Array:
        """Transformed profile g = x sqrt(x^2 - b^2)/R [m] beyond the face."""
        x = np.abs(as_array(x))
        return x * _flank_root(x, self.face_radius) / self.radius

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Contact radius a [m] with 2 a^2 = b^2 + sqrt(b^4 + 4 R^2 d^2); that of the face at d = 0."""
        return np.where(as_array(depth) >= 0.0, np.sqrt(self._squared_radius(depth)), 0.0)

    def force_integral(self, contact_radius: ArrayLike) -> Array:
        """Force integral Pi = (2 a^2 + b^2) sqrt(a^2 - b^2)/(3R) [m^2]."""
        a = as_array(contact_radius)
        root = _flank_root(a, self.face_radius)
        return (2.0 * a * a + np.asarray(self.face_radius) ** 2) * root / (3.0 * self.radius)

    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Force integral int_0^d a dd [m^2] at depth d [m]."""
        squared = self._squared_radius(depth)
        root = np.maximum(as_array(depth), 0.0) * self.radius / np.sqrt(squared)
        return (2.0 * squared + np.asarray(self.face_radius) ** 2) * root / (3.0 * self.radius)

    def _squared_radius(self, depth: ArrayLike) -> Array:
        half = 0.5 * np.asarray(self.face_radius) ** 2
        return half + np.hypot(half, self.radius * np.maximum(as_array(depth), 0.0))
