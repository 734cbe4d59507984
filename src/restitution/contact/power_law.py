"""Cone, power law and flat punch: like the parabola, their contact radius is a power of the depth."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from restitution.checks import Numeric, finite
from restitution.contact.geometry import Array, as_array, plain
from restitution.contact.profile import Profile
from restitution.quantities import INPUTS, NUMBER, Quantity


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
        """Profile f = r cot(alpha) [m]."""
        return np.abs(as_array(r)) * self._slope

    def transform(self, x: ArrayLike) -> Array:
        """Transformed profile g = (pi/2) cot(alpha) x [m]."""
        return 0.5 * math.pi * np.abs(as_array(x)) * self._slope

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Contact radius a = (2/pi) tan(alpha) d [m]."""
        return 2.0 / math.pi * np.maximum(as_array(depth), 0.0) / self._slope

    def force_integral(self, contact_radius: ArrayLike) -> Array:
        """Force integral Pi = (pi/4) cot(alpha) a^2 [m^2]."""
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
    """Factor kappa_n = (sqrt(pi)/2) n Gamma(n/2)/Gamma((n+1)/2), by which r^n transforms into kappa_n x^n."""
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
        """Profile f = A r^n [m]."""
        return self.coefficient * np.abs(as_array(r)) ** self.exponent

    def transform(self, x: ArrayLike) -> Array:
        """Transformed profile g = kappa_n A x^n [m]."""
        return self._transformed * np.abs(as_array(x)) ** self.exponent

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Contact radius a = (d/(kappa_n A))^(1/n) [m]."""
        return (np.maximum(as_array(depth), 0.0) / self._transformed) ** (1.0 / np.asarray(self.exponent))

    def force_integral(self, contact_radius: ArrayLike) -> Array:
        """Force integral Pi = kappa_n A n a^(n+1)/(n+1) [m^2]."""
        n = self.exponent
        return self._transformed * n / (n + 1.0) * as_array(contact_radius) ** (n + 1.0)

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
        """Profile [m]: 0 under the face, infinite beside it."""
        return np.where(np.abs(as_array(r)) <= self.radius, 0.0, np.inf)

    def transform(self, x: ArrayLike) -> Array:
        """Transformed profile [m]: 0 under the face, infinite beside it."""
        return self.shape(x)

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Contact radius [m]: the radius of the face where d >= 0."""
        return np.where(as_array(depth) >= 0.0, self.radius, 0.0)

    def force_integral(self, contact_radius: ArrayLike) -> Array:
        """Refuse: the depth does not follow from the contact radius."""
        raise ValueError("a flat punch has the same contact radius at every depth: use force_integral_at_depth")

    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Force integral a d [m^2] at depth d [m]."""
        return self.radius * np.maximum(as_array(depth), 0.0)

    @property
    def path_exponent(self) -> Numeric:
        """Exponent of a = c s^p: 0."""
        return 0.0

    @property
    def path_coefficient(self) -> Numeric:
        """Coefficient of a = c s^p: the radius of the face [m]."""
        return self.radius
