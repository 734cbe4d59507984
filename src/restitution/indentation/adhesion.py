"""Adhesive contact under a prescribed depth, spring or force: snap-in, pull-off, and the force in between."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from restitution.checks import Array
from restitution.contact.adhesion import Adhesion
from restitution.contact.geometry import Contact
from restitution.errors import InputError
from restitution.indentation.attraction import (
    FILLED,
    ROOM,
    SPARE,
    WIDER,
    Jump,
    March,
    Program,
    Sticky,
    peak,
    sticky,
)
from restitution.indentation.history import History
from restitution.indentation.result import IndentationResult, IndentationStatus
from restitution.indentation.work import largest_of
from restitution.numerics.richardson import Richardson
from restitution.quantities import ADHESION, OUTPUTS

LEAST_RTOL = 1e-6
"""Smallest tolerance of the forces with adhesion."""

_TRIALS = 60
# Points over a curve in search of the first attraction.
_SAMPLES = 1000


class _Units(NamedTuple):
    """Time of the first attraction [s], and the relative error of the forces."""

    touch: float
    error: float


@dataclass(frozen=True, eq=False)
class AdhesiveSolution:
    """Motion of the finest march, in the form that an `IndentationResult` takes."""

    history: History
    units: _Units
    march: March
    pull_off_force: float
    prescribed: str

    @cached_property
    def breaks(self) -> Array:
        """Times [s] of the steps."""
        return np.unique(self.march.motion[:, 0])

    @property
    def max_contact_radius(self) -> float:
        """Largest contact radius [m]."""
        return float(self.march.motion[:, 5].max())

    @cached_property
    def contact_intervals(self) -> Array:
        """Times [s] at which attractions begin and end; the last end is infinite if it outlasts the history."""
        time, attracted = self.march.motion[:, 0], self.march.motion[:, 4] > 0.0
        changes = np.flatnonzero(np.diff(np.append(False, attracted).astype(int)))
        times = time[changes]
        return np.append(times, math.inf if times.size % 2 else []).reshape(-1, 2)

    @property
    def end_time(self) -> float:
        """Time [s] at which the last attraction ends; infinite if it outlasts the history."""
        return float(self.contact_intervals[-1, 1])

    @property
    def turning_time(self) -> float:
        """Time [s] at which the contact radius is largest."""
        return float(self.march.motion[np.argmax(self.march.motion[:, 5]), 0])

    def largest(self, column: int) -> float:
        """Return the largest value of a column of `at`."""
        return largest_of(self, column)

    @property
    def work(self) -> float:
        """Work [J] of the indenter, also in jumps, in which a spring gives way along its line."""
        time, depth, _, force, *_ = self.march.motion.T
        if self.prescribed == "force":
            force = np.asarray(self.history(time))
        return float(0.5 * (force[1:] + force[:-1]) @ np.diff(depth))

    @property
    def panels(self) -> Any:
        """Refuse: the surface is not that of panels."""
        raise InputError("adhesion", rule="must be left out for the surface of an indentation")

    def times(self, n_points: int) -> Array:
        """Return a number of even times [s] of the history, up to where a force takes the body away."""
        knots = self.history.knots
        stop = min(self.end_time, knots[-1]) if self.prescribed == "force" else knots[-1]
        return np.linspace(knots[0], stop, n_points)

    def at(self, times: ArrayLike, *, before: bool = False) -> tuple[Array, ...]:
        """Return depth, rate, force and contact radius at times [s]; at a jump the values behind it.

        The depth is NaN where a force has taken the body away.
        """
        t, motion = np.atleast_1d(np.asarray(times, dtype=np.float64)), self.march.motion
        place = np.searchsorted(motion[:, 0], t, side="left" if before else "right")
        high = np.clip(place, 1, len(motion) - 1)
        low = high - 1
        width = motion[high, 0] - motion[low, 0]
        share = np.clip(np.divide(t - motion[low, 0], width, out=np.ones_like(t), where=width > 0.0), 0.0, 1.0)
        depth, force, radius = (motion[low, n] + share * (motion[high, n] - motion[low, n]) for n in (1, 3, 5))
        ahead = t < motion[0, 0]
        force, radius = np.where(ahead, 0.0, force), np.where(ahead, 0.0, radius)
        if self.prescribed == "force":
            force = np.where(t > self.end_time, 0.0, np.asarray(self.history(t)))
            return np.where(t > self.end_time, np.nan, depth), motion[high, 2], force, radius
        value, rate = np.asarray(self.history(t)), np.asarray(self.history.rate(t))
        if self.prescribed == "depth":
            return value, rate, force, radius
        return np.where(ahead, value, depth), np.where(ahead, rate, motion[high, 2]), force, radius


@dataclass(frozen=True, eq=False, repr=False)
class AdhesiveIndentation(IndentationResult):
    """Indentation with adhesion under a prescribed depth, spring or force; SI units.

    The columns are those of `IndentationResult` at all steps from the first attraction on, with forces < 0 where the
    body is pulled. A jump has two rows of one time. Contacts begin with the first attraction and end with the last.
    A spring and a force let the body jump too. A force that takes it away ends the columns, and the energies are those
    just before.

    Attributes
    ----------
    pull_off_force : float
        Largest pull [N], extrapolated, with the relative `error` of the largest force.
    zone_radius : array, shape (n,)
        Radius [m] up to which the surfaces attract each other.
    jumps : tuple of Jump
        Jumps of the attraction: time, depth, radii of attraction and of contact before and after, and the energy that
        goes to waves, also that of the spring or of the work of the force.

    Examples
    --------
    A tip that comes and goes at 1 um/s:

    >>> import restitution as rs
    >>> gel = rs.Material(rs.PronySeries(2e5, [8e5], [0.1]), bulk=float("inf"))
    >>> depth, time = [-3e-8, 1e-7, -5e-7], [0.0, 0.13, 0.73]
    >>> sticky = rs.Adhesion(work=0.01, stress=5e5)
    >>> result = rs.indent(gel, rs.Parabola(1e-6), depth=depth, time=time, adhesion=sticky, rtol=1e-2)
    >>> print(f"{result.pull_off_force:.2g} N, {len(result.jumps)} jumps")
    1.1e-07 N, 2 jumps
    """

    _numbers = (*IndentationResult._numbers, "pull_off_force", "radiated")
    _shown = IndentationResult._shown | {
        "pull_off_force": ADHESION["pull_off_force"], "radiated": OUTPUTS["radiated_energy"]
    }  # fmt: skip

    pull_off_force: float = math.nan
    zone_radius: Array = field(default_factory=lambda: np.empty(0), repr=False)
    jumps: tuple[Jump, ...] = field(default=(), repr=False)

    @property
    def _march(self) -> March:
        assert isinstance(self._solution, AdhesiveSolution)
        return self._solution.march

    @property
    def radiated(self) -> float:
        """Energy [J] that jumps lose to waves."""
        return float(self._march.motion[-1, 7])

    @cached_property
    def stored(self) -> float:
        """Energy [J] of the surface and of the attraction at the end of the history, over that far apart."""
        return self._march.left

    @property
    def dissipated(self) -> float:
        """Energy [J] that the body has dissipated until the end of the history: work - stored - radiated."""
        return self.work - self.stored - self.radiated


def indent_with_adhesion(
    contact: Contact, adhesion: Adhesion, history: History, name: str, stiffness: float | None, rtol: float
) -> AdhesiveIndentation:
    """Return the indentation of an adhesive body under a prescribed depth, spring or force; see `indent`."""
    driven = "base" if stiffness is not None else name
    lines = _Lines(adhesion, history, name, 0.0 if name == "force" else stiffness)
    limit = max(rtol, LEAST_RTOL)
    solution = _solved(sticky(contact, adhesion), lines, driven, limit)
    time, depth, _, force, zone, radius, *_ = solution.march.motion.T
    end = solution.end_time
    status = IndentationStatus.SEPARATED if math.isfinite(end) else IndentationStatus.IN_CONTACT
    return AdhesiveIndentation(
        time, depth, solution.at(time)[1], force, radius, solution.contact_intervals,
        np.array([solution.turning_time]), end, solution.turning_time, status, contact, driven, history, limit,
        solution.units.error, solution, pull_off_force=solution.pull_off_force, zone_radius=zone,
        jumps=solution.march.jumps,
    )  # fmt: skip


class _Lines:
    """Prescribed history from the first attraction on, as straight lines: `touch` [s], and the largest value."""

    def __init__(self, adhesion: Adhesion, history: History, name: str, stiffness: float | None) -> None:
        if adhesion.shape:
            raise InputError("adhesion", rule="must be a single one for an indentation")
        knots = history.knots
        if name == "force" and knots[1] == knots[0]:
            # It is borne from the first time on.
            history = History(knots[1:], history.coefficients[1:])
            knots = history.knots
        if np.any(np.diff(knots) == 0.0):
            raise InputError(name, rule="must have no step with adhesion")
        self.history, self.stiffness, self._curved = history, stiffness, np.any(history.coefficients[:, 2:], axis=1)
        points = self._points(_SAMPLES)
        values = np.asarray(history(points))
        self.largest = float(values.max())
        self.touch = float(knots[0])
        if name == "force":
            if values[0] < 0.0:
                raise InputError(name, float(values[0]), "must begin at 0 or above with adhesion", "N")
            return
        reach = float(np.asarray(adhesion.range))
        if values[0] > -reach:
            rule = f"must begin outside of the attraction, at {-reach:.4g} m or above"
            raise InputError(name, float(values[0]), rule, "m")
        near = np.flatnonzero(values > -reach)
        if not near.size:
            raise InputError(name, rule=f"must come within the range of the attraction, {reach:.4g} m")
        n = int(near[0])
        share = (-reach - values[n - 1]) / (values[n] - values[n - 1])
        self.touch = float(points[n - 1] + share * (points[n] - points[n - 1]))
        if np.any(self._curved):
            from scipy.optimize import brentq

            touch: Any = brentq(lambda t: float(history(t)) + reach, points[n - 1], points[n], xtol=1e-300)
            self.touch = float(touch)

    def _points(self, count: int) -> Array:
        """Return the knots [s], with some `count` of points between them over curves."""
        knots = self.history.knots
        widths = np.diff(knots) / (knots[-1] - knots[0])
        parts = np.where(self._curved, np.ceil(count * widths), 1.0).astype(int)
        lines = [
            np.linspace(low, high, n, endpoint=False)
            for low, high, n in zip(knots[:-1], knots[1:], parts, strict=True)
        ]
        return np.append(np.concatenate(lines), knots[-1])

    def program(self, count: int) -> Program:
        """Return the program of a march with `count` elements, whose lines are chords of curves."""
        points = self._points(count)
        points = np.append(self.touch, points[points > self.touch])
        return Program(points, np.asarray(self.history(points)), self.stiffness)


def _solved(body: Sticky, lines: _Lines, name: str, rtol: float) -> AdhesiveSolution:
    """March with more and more elements until largest force, pull and depth are known to `rtol`."""
    from restitution.kernel.zone import HELD, NO_ROOM, SEPARATED

    profile, history = body.profile, lines.history
    width = _first_width(body, lines, name)
    fewest, most = body.counts(width, float(history.knots[-1]) - lines.touch)
    count, trials, series = fewest, 0, Richardson()
    while count <= most and trials < _TRIALS:
        march = body.follow(width, lines.program(count), count)
        ended = march.end in (HELD, SEPARATED)
        if march.end == NO_ROOM or (ended and march.widest < FILLED * width and count == fewest):
            width = WIDER * width if march.end == NO_ROOM else SPARE * march.widest
            trials += 1
            if not ROOM * width < float(np.asarray(profile.max_contact_radius)):
                field = "force" if name == "force" else "depth"
                raise InputError(field, rule=f"must not bring the attraction beyond the profile, {profile.end}")
            fewest, most = body.counts(width, float(history.knots[-1]) - lines.touch)
            count, series = fewest, Richardson()
            continue
        if not ended:
            break
        motion = march.motion
        depth, force = motion[:, 1], motion[:, 3]
        peaks = [peak(motion, each, history.knots) for each in (force, -force, depth)[: 2 if name == "depth" else 3]]
        values, errors = series.add([max(value, 0.0) for value, _ in peaks[:2]] + [value for value, _ in peaks[2:]])
        errors = np.maximum(errors, [error for _, error in peaks])
        error = float(errors[:2].max()) / max(float(values[:2].max()), 1e-300)
        if name != "depth":
            error = max(error, float(errors[2]) / float(np.abs(depth).max()))
        if error <= rtol:
            if name == "force" and march.end == SEPARATED:
                gone = march.motion[-1].copy()
                gone[3:6] = 0.0
                march = march._replace(motion=np.vstack([march.motion, gone]))
            return AdhesiveSolution(history, _Units(lines.touch, error), march, float(values[1]), name)
        count *= 2
    rule = f"has no solution within rtol = {rtol:g}; loosen it, or take a lower stress if the attracted ring is thin"
    raise InputError("adhesion", rule=rule)


def _first_width(body: Sticky, lines: _Lines, name: str) -> float:
    """Return a first radius [m] of the zone: that of the largest depth, or of the largest force without adhesion."""
    profile, reach = body.profile, float(np.asarray(body.adhesion.range))
    if name != "force":
        return float(profile.contact_radius(max(lines.largest, reach)))
    width = float(profile.contact_radius(reach))
    stiff = float(body.modulus.instantaneous_modulus)
    while stiff * float(profile.transform(width)) * width < lines.largest:
        width *= WIDER
    return width
