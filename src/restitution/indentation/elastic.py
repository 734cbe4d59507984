"""Closed form of a contact with an elastic body under a force: depth and radius follow it at each instant."""

from __future__ import annotations

import math
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial.polynomial import polyder, polyval
from numpy.typing import ArrayLike

from restitution.checks import Array
from restitution.contact.geometry import depth_of_integral
from restitution.errors import InputError
from restitution.indentation.history import NO_FORCE, History, contact_part, from_zeros, zeros_of
from restitution.indentation.panels import PanelSolution, Units, even_times, solve_by_panels
from restitution.indentation.work import integral

if TYPE_CHECKING:
    from restitution.contact.geometry import Contact
    from restitution.material.prony import PronySeries


class ElasticSolution:
    """Contact of a body that does not relax, `F = 2 E int_0^d a dd`, under a force [N] of any history.

    The surface has no memory, so that no elements are followed.
    """

    by_depth = False

    def __init__(self, contact: Contact, series: PronySeries, history: History, rtol: float) -> None:
        self.history, self.rtol = history, rtol
        self._profile, self._series, self._modulus = contact.profile, series, float(series.equilibrium_modulus)
        contact_part(history, "force")
        # Pieces without extremes, and with knots where the force vanishes.
        self._pieces = [
            (low + (high - low) * first, low + (high - low) * last, polyval(first, c), polyval(last, c))
            for low, high, c in _rows(from_zeros(history)[0])
            for first, last in pairwise([0.0, *zeros_of(np.asarray(polyder(c), dtype=np.float64)), 1.0])
        ]
        ends = np.array([piece[2:] for piece in self._pieces])
        most = float(ends.max())
        self._nothing = 10.0 * NO_FORCE * most
        self._deepest = float(self._depth(np.array([most]))[0])
        if not self._deepest <= float(np.min(self._profile.max_depth)):
            limit = float(np.min(self._profile.max_depth))
            raise InputError("force", rule=f"must not press the tip deeper than {limit:g} m, {self._profile.end}")
        self._most = most
        touch, radius = self.contact_intervals[0, 0], float(self._profile.stiffness_radius(self._deepest))
        self.units = Units(touch, history.stop - touch, self._deepest, radius, most, 0.0)

    def _depth(self, force: Array) -> Array:
        """Return the depth [m] under forces [N]; infinite where the profile ends before."""
        return depth_of_integral(self._profile, 0.5 * force / self._modulus)

    @cached_property
    def contact_intervals(self) -> Array:
        """Times [s] at which contacts begin and end, shape (n, 2); the last end is infinite if it is not reached."""
        begins, ends = list[float](), list[float]()
        for start, stop, first, last in self._pieces:
            if len(begins) == len(ends) and stop > start and max(first, last) > self._nothing:
                begins.append(start)
            if len(begins) > len(ends) and last <= self._nothing:
                ends.append(stop)
        return np.column_stack([begins, np.append(ends, np.full(len(begins) - len(ends), math.inf))])

    @cached_property
    def turning_times(self) -> Array:
        """Times [s] at which the contact changes between growth and shrinkage."""
        times, before = list[float](), 0.0
        for start, _, first, last in self._pieces:
            if first <= self._nothing:
                before = 0.0
            if before * (last - first) < 0.0:
                times.append(start)
            before = last - first or before
        return np.array(times)

    @property
    def turning_time(self) -> float:
        """Time [s] at which the contact is largest."""
        start, stop, first, last = max(self._pieces, key=lambda piece: max(piece[2:]))
        return start if first > last else stop

    @property
    def end_time(self) -> float:
        """Time [s] at which the last contact ends; infinite if it outlasts the history."""
        return float(self.contact_intervals[-1, 1])

    @property
    def max_contact_radius(self) -> float:
        """Largest contact radius [m]."""
        return float(self._profile.contact_radius(self._deepest))

    @property
    def breaks(self) -> Array:
        """Times [s] between which depth and force are smooth."""
        return np.unique([time for piece in self._pieces for time in piece[:2]])

    def largest(self, column: int) -> float:
        """Return the largest depth [m], column 0 of `at`, or force [N], column 2."""
        return self._deepest if column == 0 else self._most

    def times(self, n_points: int) -> Array:
        """Return even times [s], the knots of the history, turnings, and both ends of each contact."""
        return even_times(self.history, [*self.contact_intervals.ravel(), *self.turning_times], n_points)

    def at(self, times: ArrayLike, *, before: bool = False) -> tuple[Array, Array, Array, Array]:
        """Return the depth [m], its rate [m/s], force [N] and contact radius [m] at times [s] of the history.

        At a kink or a jump the values behind it, or those before it.
        """
        t = np.atleast_1d(self.history.within(times))
        if before:
            t = np.maximum(np.nextafter(t, -math.inf), self.history.start)
        force = np.maximum(np.asarray(self.history(t)), 0.0)
        depth, slope = self._depth(force), np.asarray(self.history.rate(t))
        with np.errstate(divide="ignore", invalid="ignore"):
            rate = slope / (2.0 * self._modulus * np.asarray(self._profile.stiffness_radius(depth)))
        # Without a force the body lies on the surface.
        rate = np.where((force > 0.0) | (slope > 0.0), rate, 0.0)
        return depth, rate, force, np.where(force > 0.0, self._profile.contact_radius(depth), 0.0)

    @property
    def work(self) -> float:
        """Work [J] that the body did until the end of the history; the material stores it all."""
        end = float(self._depth(np.array([max(self._pieces[-1][3], 0.0)]))[0])
        if self._pieces[-1][3] <= self._nothing:
            return 0.0

        def force(roots: Array) -> Array:
            return 4.0 * self._modulus * roots * np.asarray(self._profile.force_integral_at_depth(roots * roots))

        return integral(force, np.array([0.0, math.sqrt(end)]), self.rtol, 0.0)

    @property
    def panels(self) -> PanelSolution:
        """The same by panels, which have the state of the surface."""
        return solve_by_panels(self._profile, self._series, self.history, "force", self.rtol)


def _rows(history: History) -> list[tuple[float, float, Array]]:
    """Return start, end and coefficients of each piece."""
    return list(zip(history.knots[:-1].tolist(), history.knots[1:].tolist(), history.coefficients, strict=True))
