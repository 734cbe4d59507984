"""The exact circle as a profile, up to its equator."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from restitution.checks import Numeric
from restitution.contact.profile import Array, Profile, as_array
from restitution.quantities import INPUTS


def sphere_mass(density: Any, radius: Any) -> Any:
    """Mass m = (4/3) pi rho R^3 [kg] of a solid sphere of density rho [kg/m^3] and radius R [m]."""
    # A product has the same bits for numbers and arrays; a power has not.
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
    ``g = x artanh(x/R)``, ``Pi = ((R^2 + a^2) artanh(a/R) - a R)/2`` (Segedin 1957, Sneddon 1965). The shape
    is exact, but the half-space behind it is still linear with small slopes: at a/R = 0.2 the force at equal
    depth is 0.4 % below that of the parabola, and as a -> R, d -> infinity.

    Examples
    --------
    >>> ball = Sphere(radius=0.01)
    >>> round(float(ball.transform(0.005)), 9), round(float(ball.contact_radius(0.0027465307216702744)), 9)
    (0.002746531, 0.005)
    """

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

    def _rapidity(self, depth: ArrayLike) -> Array:
        # The root of L tanh(L) = d/R: unlike a = R tanh(L), L keeps its digits as a -> R.
        ratio = np.maximum(as_array(depth), 0.0) / self.radius
        rapidity = np.sqrt(ratio * (1.0 + ratio))
        # From this start, at most 18 % off, the fifth Newton step is at rounding level for every depth.
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
