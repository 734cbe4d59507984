"""The exact solution under a prescribed history, to be sampled at any time."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.checks import finite
from restitution.contact.profile import Profile
from restitution.indentation.growth import grow_contact, scratch
from restitution.indentation.history import History
from restitution.indentation.scaling import contact_part, scaled_contact
from restitution.indentation.shrinkage import (
    Reloading,
    check_recontact,
    depth_rounding,
    recover_depth,
    shrink_contact,
)
from restitution.material.prony import PronySeries

Array = NDArray[np.float64]


class Solution:
    """Exact solution under a prescribed history, in SI.

    Parameters
    ----------
    series : PronySeries
        Reduced modulus E*.
    profile : Profile
        Profile of the indenter.
    history : History
        What is prescribed.
    name : str
        Which quantity: "depth" or "force".
    rtol : float
        Error of force, depth and contact radius over the largest, and of the end of contact over the duration.

    Raises
    ------
    ValueError
        If the history is outside the theory: the message names the time.
    """

    def __init__(
        self, series: PronySeries, profile: Profile, history: History, name: str, rtol: float
    ) -> None:
        self.history, self._profile = history, profile
        self.by_depth = name == "depth"
        tolerance = 0.05 * rtol
        part = contact_part(history, name)
        if self.by_depth:
            _check_reach(part, profile)
            if series.parallel_viscosity > 0.0:
                _check_jumps(part)
        self._contact, self.units = scaled_contact(series, profile, part, name)
        work = scratch(self._contact)
        past = grow_contact(self._contact, work, tolerance, float(np.min(profile.max_depth)))
        rounding, moment = depth_rounding(past)
        if rounding > rtol * past.elements.depths[-1]:
            raise ValueError(
                f"{name} at time = {self._time(moment):g} s: rises too fast for the digits of its times at rtol = {rtol:g}; "
                "make it a step, two points at the same time"
            )
        try:
            past, places, times = shrink_contact(self._contact, past, work, rtol)
            if self.by_depth and past.end < 1.0:
                check_recontact(self._contact, past, work, places, times, rtol, series, self.units)
        except Reloading as problem:
            time = self._time(problem.time)
            raise Reloading(f"{name} at time = {time:g} s: {problem}", time) from None
        self._past = past
        self._recovery = recover_depth(self._contact, past, work, tolerance)

    @property
    def path_error(self) -> float:
        """Error of forces, over the largest, that the table of the profile leaves."""
        return self.units.error

    @property
    def turning_time(self) -> float:
        """Time at which the contact starts to shrink [s]; the end of the history where it does not."""
        return self._moment(self._past.turning if self._contact.path.exponent != 0.0 else 1.0)

    @property
    def max_contact_radius(self) -> float:
        """Contact radius as the contact ceases to grow [m]."""
        if self._contact.path.exponent == 0.0:
            return self.units.radius
        return float(self._profile.contact_radius(self.units.length * self._past.elements.depths[-1]))

    @property
    def end_time(self) -> float:
        """Time at which the contact ends [s]; infinite where it outlasts the history."""
        return self._moment(self._past.end)

    def times(self, n_points: int) -> Array:
        """Even times [s], and the knots of the history, the turning and the end of the contact."""
        start, stop = self.history.start, self.history.stop
        special = np.array([self.turning_time, self.end_time])
        even = np.linspace(start, stop, n_points)
        return np.unique(np.concatenate([even, self.history.knots, special[special <= stop]]))

    @property
    def breaks(self) -> Array:
        """Times [s] between which force and depth are smooth, from first touch to the end of contact or history."""
        last = min(self._past.end, 1.0)
        parts = [
            self._past.elements.starts,
            self._contact.knots,
            [self._past.turning, last],
            self._recovery.starts,
        ]
        knots = np.unique(np.concatenate(parts))
        return self._time(knots[knots <= last])

    @property
    def steps(self) -> list[int]:
        """Places of the steps of the history up to the end of contact."""
        knots = self._contact.knots
        return np.flatnonzero((np.diff(knots) == 0.0) & (knots[:-1] <= self._past.end)).tolist()

    def through(self, place: int, shares: Array) -> tuple[Array, Array]:
        """Depth [m] and force [N] on the way through the step at this place, at shares of it in [0, 1]."""
        from restitution.kernel.indentation import through_jump

        columns = np.empty((2, shares.size))
        order = np.argsort(shares)
        sorted_columns = np.empty((2, shares.size))
        through_jump(
            self._contact,
            self._past,
            self._recovery,
            scratch(self._contact),
            place,
            shares[order],
            sorted_columns,
        )
        columns[:, order] = sorted_columns
        return columns[0] * self.units.length, columns[1] * self.units.force

    def at(self, times: ArrayLike, *, before: bool = False) -> tuple[Array, Array, Array, Array]:
        """Depth [m], its rate [m/s], force [N] and contact radius [m] at times [s] of the history.

        At a kink or a jump what is behind it, or what is before.
        """
        from restitution.kernel.indentation import sample

        t = np.atleast_1d(np.asarray(finite("time", times, "s"), dtype=np.float64))
        start, stop = self.history.start, self.history.stop
        if t.size and (t.min() < start or t.max() > stop):
            raise ValueError(f"time: must be in [{start:g}, {stop:g}] s, where the history is given")
        order = np.argsort(t, kind="stable") if np.any(t[1:] < t[:-1]) else None
        if order is not None:
            t = t[order]
        units = self.units
        early = int(np.searchsorted(t, units.touch, side="right" if before else "left"))
        sampled = np.empty((4, t.size - early))
        inside = np.minimum((t[early:] - units.touch) / units.time, 1.0)
        if before:
            inside = np.nextafter(inside, -math.inf)
        sample(self._contact, self._past, self._recovery, scratch(self._contact), inside, sampled)
        sampled *= np.array([[units.length], [units.length / units.time], [units.force], [units.radius]])
        # Next to nothing is a small number of either sign; there is no adhesion.
        np.maximum(sampled[2], 0.0, out=sampled[2])
        if early:
            free = np.zeros((4, early))
            if self.by_depth:
                free[0], free[1] = self.history(t[:early]), self.history.rate(t[:early])
                free[:, t[:early] == units.touch] = 0.0
            sampled = np.concatenate([free, sampled], axis=1)
        if order is not None:
            unsorted = np.empty_like(sampled)
            unsorted[:, order] = sampled
            sampled = unsorted
        return sampled[0], sampled[1], sampled[2], sampled[3]

    def _moment(self, scaled: float) -> float:
        """Time [s]; at a knot of the history the knot itself, without the rounding of the units."""
        knots = self.history.knots
        same = np.flatnonzero((knots - self.units.touch) / self.units.time == scaled)
        return float(knots[same[0]]) if same.size else float(self._time(scaled))

    def _time(self, scaled: Any) -> Any:
        return self.units.touch + self.units.time * scaled


def _check_reach(part: History, profile: Profile) -> None:
    deepest = float(part.coefficients.sum(axis=1).max())
    most = float(np.min(profile.max_depth))
    if deepest > most:
        raise ValueError(f"depth = {deepest:g} m: must be <= {most:g} m, where the profile ends")


def _check_jumps(part: History) -> None:
    jumps = part.knots[:-1][np.diff(part.knots) == 0.0]
    if jumps.size:
        raise ValueError(
            f"depth jumps at time = {jumps[0]:g} s: takes an infinite force, as the material has a dashpot in parallel"
        )
