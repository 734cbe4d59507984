"""A profile on layers of many thicknesses, whose tables are made together."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.contact.geometry import Array, as_array
from restitution.contact.layer.contacts import Contacts, contacts
from restitution.contact.layer.depths import Depths, depths, largest_radius
from restitution.contact.layer.punch import PANELS, Punches
from restitution.contact.layer.store import stored_punches
from restitution.contact.path import PathTable, joined
from restitution.contact.profile import Profile
from restitution.contact.rows import Rows, Samples, Tables

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

    def _each(self, function: Callable[[Depths, Array], Array], depth: ArrayLike) -> Array:
        depth = np.broadcast_to(as_array(depth), self.thickness.shape)
        result = np.empty(depth.shape)
        for k, thickness in enumerate(self._distinct[0].tolist()):
            one: Any = depths(self.profile, thickness, self.poisson_ratio)
            rows = self.which == k
            result[rows] = function(one, one.half_space_depth(np.minimum(depth[rows], one.max_depth)))
        return result

    def stiffness_radius(self, depth: ArrayLike) -> Array:
        """Stiffness radius a kappa [m] at depth d [m] of each row."""
        return self._each(Depths.stiffness_radius, depth)

    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Force integral int_0^d a kappa dd [m^2] at depth d [m] of each row."""
        return self._each(Depths.force_integral, depth)

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Contact radius a [m] at depth d [m] of each row."""
        return self._each(Depths.radius, depth)

    def contact_radius_at(self, depth: ArrayLike, stiffness_radius: ArrayLike) -> Array:
        """Contact radius a [m] from the stiffness radius a kappa [m]."""
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
        made = contacts(self.profile, self.poisson_ratio, float(self._distinct[0][0]), float(self._widest[-1]))
        return made.own_depth(self._distinct[0], made.at(self.profile.transform(self._widest)))

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
        made = self._contacts(float(thickness[0]), end)
        knots, contact, flat = made.sampled
        # Beyond the end of the tables.
        with np.errstate(all="ignore"):
            depth, _, integral = np.log(made.on(thickness[chosen], contact, loads=True))
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
        """Contacts up to a radius [m]; similar rows share them."""
        return contacts(self.profile, self.poisson_ratio, _power_of_two(thinnest, math.floor), end)

    def tables(self, deepest: Array, least: Array, rtol: float) -> Tables:
        """Tables of the distinct layers; those with tables of the same largest contact radius are made together."""
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
        wanted = np.minimum(np.exp(levels / _LEVELS), self.profile.transform(self._widest[-1]))
        wanted = np.minimum(self.profile.contact_radius(wanted)[level.reshape(-1)], self._widest)
        found, numbers = list[Tables](), list[NDArray[np.intp]]()
        pending = np.argsort(-wanted, kind="stable")
        while pending.size:
            end = float(wanted[pending[0]])
            together = self._widest[pending] >= end
            layers, pending = np.sort(pending[together]), pending[~together]
            thickness = self._distinct[0][layers]
            found += self._contacts(float(thickness[0]), end).tables(thickness, small[layers], rtol)
            numbers.append(layers)
        if len(found) == 1:
            return found[0]
        # In the order of the layers.
        order = np.argsort(np.concatenate(numbers))
        table = joined([one.table for one in found])
        depth, radius = np.hstack([one[1:] for one in found])[:, order]
        return Tables(PathTable._make([*(one[order] for one in table[:-1]), table.power]), depth, radius)


def _power_of_two(value: float, rounded: Callable[[float], int]) -> float:
    return 2.0 ** rounded(math.log2(value))
