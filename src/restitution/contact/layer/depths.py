"""Depths of a body on a layer: from the depth on a half-space with the same contact radius, and back."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from restitution.contact.geometry import Array, Kinks
from restitution.contact.layer.averages import Averages, power_law_series
from restitution.contact.layer.punch import PANELS, Punches, over_panels
from restitution.contact.layer.store import stored_punches
from restitution.contact.profile import Profile
from restitution.errors import InputError

# Share of the radius of a profile with an equator, at which the depth is infinite, that the tables describe.
_EQUATOR = 0.99
# Radii of the first estimate of the depth: decades below the thickness, and number.
_DECADES, _STARTS = 4.0, 240
_STEPS = 30


class PowerMeans:
    """Means sigma and tau for a power law, from series over each panel of the radius."""

    def __init__(self, punches: Punches, exponent: float) -> None:
        self._sigma, self._tau = power_law_series(punches, exponent)

    def __call__(self, radius: Array) -> tuple[Array, Array]:
        """Means at radii over the thickness of any shape."""
        return over_panels(self._sigma, radius), over_panels(self._tau, radius)


class Depths:
    """Depth, contact radius and force integral of a profile on a layer, in SI.

    A contact of the radius a has the depth D = g(a) on a half-space, and ``d = (D + sigma G/h)/w`` on the layer, with
    the means of `restitution.contact.layer.averages` and ``G = a D - Pi_0``, Pi_0 the force integral on a half-space.
    The stiffness radius is ``a kappa`` and the force integral ``d a kappa - tau G``.
    """

    def __init__(self, profile: Profile, thickness: float, poisson_ratio: float | None) -> None:
        self.profile, self.thickness, self.punches = profile, thickness, stored_punches(poisson_ratio)
        face = checked_face(float(profile.contact_radius(0.0)), thickness)
        most = float(PANELS[-1])
        self.face, self.end = face, min(largest_radius(profile) / thickness, most)
        self.means: PowerMeans | Averages = self._means()
        t = np.sqrt((self.end - face) * (self.end + face))
        radii = np.hypot(face, t * 10.0 ** np.linspace(-_DECADES - math.log10(max(t, 1.0)), 0.0, _STARTS))
        radii[-1] = self.end
        start = self._transform(radii)
        # Near an equator the depth rises much faster than the radius.
        start = np.sort(np.concatenate([start, start[-1] * np.linspace(0.02, 1.0, _STARTS // 2)]))
        start = np.minimum(start, self.profile.max_depth)
        kept = np.append(np.diff(start) > 0.0, True) & (start > 0.0)
        self._start = np.log(start[kept])
        self._reached = np.log(self.depth(start[kept]))
        self._slope = np.gradient(self._reached, self._start)
        self._deepest = float(start[-1])
        self.max_depth = float(self.depth(start[-1:])[0])

    def _means(self) -> PowerMeans | Averages:
        exponent = self.profile.path_exponent
        if exponent:
            return PowerMeans(self.punches, 2.0 / float(np.asarray(exponent)))
        joints = self.profile.joints / self.thickness
        joints = joints[(joints > self.face) & (joints < self.end)]
        return Averages(self.punches, self._transform, self.face, joints, self.end)

    def _transform(self, radius: Array) -> Array:
        """Transform g [m] at radii over the thickness; rounding may put the last one beyond the profile."""
        return self.profile.transform(np.minimum(radius * self.thickness, self.profile.max_contact_radius))

    def radius(self, half_space_depth: Array) -> Array:
        """Contact radius [m] at the depth D [m] on a half-space, within the tables; 0 where D < 0."""
        return np.minimum(self.profile.contact_radius(half_space_depth), self.end * self.thickness)

    def depth(self, half_space_depth: Array) -> Array:
        """Depth d [m] on the layer where the contact radius is that of the depth D [m] on a half-space."""
        a = self.radius(half_space_depth)
        chi = a / self.thickness
        gap = (a * half_space_depth - self.profile.force_integral_at_depth(half_space_depth)) / self.thickness
        return (half_space_depth + self.means(chi)[0] * gap) / self.punches.edge_load(chi)

    def half_space_depth(self, depth: Array) -> Array:
        """Depth D [m] on a half-space with the same contact radius as the depth d [m] on the layer."""
        inside = (depth > 0.0) & (depth <= self.max_depth)
        if not np.any(inside):
            return np.where(depth > 0.0, np.nan, np.minimum(depth, 0.0))
        target = np.log(np.where(inside, depth, self.max_depth))
        x = np.interp(target, self._reached, self._start)
        x = np.where(target < self._reached[0], target + self._start[0] - self._reached[0], x)
        slope = np.interp(x, self._start, self._slope)
        before = reached = x
        for rank in range(_STEPS):
            now = np.log(self.depth(self._inside(x)))
            # The secant, from the second step on, while the steps are above rounding.
            moved = (np.abs(x - before) > 1e-9) & (rank > 0)
            slope = np.where(moved, (now - reached) / np.where(moved, x - before, 1.0), slope)
            step, before, reached = (target - now) / slope, x, now
            x = np.minimum(x + step, self._start[-1])
            if np.all(np.abs(step) <= 1e-15 * np.maximum(np.abs(x), 1.0)):
                break
        return np.where(inside, self._inside(x), np.where(depth > 0.0, np.nan, np.minimum(depth, 0.0)))

    def _inside(self, logarithm: Array) -> Array:
        """Depth D [m], which rounding must not put beyond the end of the profile."""
        return np.minimum(np.exp(logarithm), self._deepest)

    def stiffness_radius(self, half_space_depth: Array) -> Array:
        """Stiffness radius [m] at the depth D [m] on a half-space."""
        a = self.radius(half_space_depth)
        return a * self.punches.kappa(a / self.thickness)

    def force_integral(self, half_space_depth: Array) -> Array:
        """Force integral [m^2] at the depth D [m] on a half-space."""
        a = self.radius(half_space_depth)
        gap = a * half_space_depth - self.profile.force_integral_at_depth(half_space_depth)
        stiffness_radius = a * self.punches.kappa(a / self.thickness)
        return self.depth(half_space_depth) * stiffness_radius - self.means(a / self.thickness)[1] * gap

    @property
    def kinks(self) -> Kinks:
        """Depths d [m] at which the contact radius of the profile is not smooth, and the strengths of a kappa there.

        On a half-space ``a = smooth + strength (D - D_j)^p``. With d' = dd/dD the stiffness radius on the layer has
        the strength ``w strength/d'^(p + 1)``.
        """
        own = self.profile.kinks
        inside = own.depth < self._deepest
        place, strength, power = own.depth[inside], own.strength[inside], own.power
        depth = self.depth(place)
        log_slope = np.interp(np.log(place), self._start, self._slope)
        edge = self.punches.edge_load(self.radius(place) / self.thickness)
        return Kinks(depth, edge * strength / (log_slope * depth / place) ** (power + 1.0), power)


class PunchDepths:
    """The same for a flat punch, whose contact radius does not depend on the depth; D is the depth itself."""

    def __init__(self, profile: Profile, thickness: float, poisson_ratio: float | None) -> None:
        self.punches, self.max_depth, self.kinks = stored_punches(poisson_ratio), math.inf, profile.kinks
        self._radius = float(profile.contact_radius(0.0))
        checked_face(self._radius, thickness)
        self._stiffness_radius = self._radius * float(self.punches.kappa(np.array(self._radius / thickness)))

    def half_space_depth(self, depth: Array) -> Array:
        """The depth d [m] itself."""
        return depth

    depth = half_space_depth

    def radius(self, depth: Array) -> Array:
        """Contact radius [m]: that of the punch where d >= 0."""
        return np.where(depth >= 0.0, self._radius, 0.0)

    def stiffness_radius(self, depth: Array) -> Array:
        """Stiffness radius a kappa [m]."""
        return np.where(depth >= 0.0, self._stiffness_radius, 0.0)

    def force_integral(self, depth: Array) -> Array:
        """Force integral a kappa d [m^2]."""
        return self._stiffness_radius * np.maximum(depth, 0.0)


def largest_radius(profile: Profile) -> float:
    """Largest contact radius [m] that the tables describe, on a thick layer."""
    end = float(profile.max_contact_radius)
    if math.isfinite(end) and not math.isfinite(float(profile.transform(end))):
        end *= _EQUATOR
    return end


def checked_face(radius: float, thickness: float) -> float:
    """Return the radius of a flat face over the thickness, which must be within the tables."""
    if radius >= PANELS[-1] * thickness:
        wanted = (
            f"must be above {radius / PANELS[-1]:.3g} m: the tables end where the contact is {PANELS[-1]:g} h wide"
        )
        raise InputError("thickness", thickness, wanted, "m")
    return radius / thickness


@lru_cache(maxsize=64)
def depths(profile: Profile, thickness: float, poisson_ratio: float | None) -> Depths | PunchDepths:
    """Return the depths of a profile on a layer, which are computed once."""
    return (PunchDepths if profile.path_exponent == 0.0 else Depths)(profile, thickness, poisson_ratio)
