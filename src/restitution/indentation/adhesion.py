"""Adhesive contact under a prescribed depth: snap-in, pull-off, and the force in between."""

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
from restitution.indentation.attraction import FEWEST, FILLED, MOST, ROOM, WIDER, Jump, March, Sticky, sticky
from restitution.indentation.history import History
from restitution.indentation.result import IndentationResult, IndentationStatus
from restitution.numerics.richardson import Richardson
from restitution.quantities import ADHESION, OUTPUTS

LEAST_RTOL = 1e-6
"""Smallest tolerance of the forces with adhesion."""

_TRIALS = 60


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

    @property
    def work(self) -> float:
        """Work [J] of the indenter."""
        depth, force = self.march.motion[:, 1], self.march.motion[:, 3]
        return float(0.5 * (force[1:] + force[:-1]) @ np.diff(depth))

    @property
    def panels(self) -> Any:
        """Refuse: the surface is not that of panels."""
        raise InputError("adhesion", rule="must be left out for the surface of an indentation")

    def times(self, n_points: int) -> Array:
        """Return a number of even times of the history [s]."""
        return np.linspace(self.history.knots[0], self.history.knots[-1], n_points)

    def at(self, times: ArrayLike, *, before: bool = False) -> tuple[Array, ...]:
        """Return depth, rate, force and contact radius at times [s]; at a jump the values behind it."""
        t, motion = np.atleast_1d(np.asarray(times, dtype=np.float64)), self.march.motion
        place = np.searchsorted(motion[:, 0], t, side="left" if before else "right")
        high = np.clip(place, 1, len(motion) - 1)
        low = high - 1
        width = motion[high, 0] - motion[low, 0]
        share = np.clip(np.divide(t - motion[low, 0], width, out=np.ones_like(t), where=width > 0.0), 0.0, 1.0)
        force, radius = (motion[low, n] + share * (motion[high, n] - motion[low, n]) for n in (3, 5))
        ahead = t < motion[0, 0]
        depth, rate = self.history(t), self.history.rate(t)
        return np.asarray(depth), np.asarray(rate), np.where(ahead, 0.0, force), np.where(ahead, 0.0, radius)


@dataclass(frozen=True, eq=False, repr=False)
class AdhesiveIndentation(IndentationResult):
    """Indentation with adhesion under a prescribed depth; SI units.

    The columns are those of `IndentationResult` at all steps from the first attraction on, with forces < 0 where the
    body is pulled. A jump has two rows of one time. Contacts begin with the first attraction and end with the last.

    Attributes
    ----------
    pull_off_force : float
        Largest pull [N], extrapolated, with the relative `error` of the largest force.
    zone_radius : array, shape (n,)
        Radius [m] up to which the surfaces attract each other.
    jumps : tuple of Jump
        Jumps of the attraction: time, depth, radii of attraction and of contact before and after, and the energy that
        goes to waves.

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
    contact: Contact, adhesion: Adhesion, history: History, name: str, rtol: float
) -> AdhesiveIndentation:
    """Return the indentation of an adhesive body under a prescribed depth; see `indent`."""
    knots, rates, deepest = _program(adhesion, history, name)
    limit = max(rtol, LEAST_RTOL)
    solution = _solved(sticky(contact, adhesion), history, (knots, rates, deepest), limit)
    time, depth, _, force, zone, radius, *_ = solution.march.motion.T
    end = solution.end_time
    status = IndentationStatus.SEPARATED if math.isfinite(end) else IndentationStatus.IN_CONTACT
    return AdhesiveIndentation(
        time, depth, solution.at(time)[1], force, radius, solution.contact_intervals,
        np.array([solution.turning_time]), end, solution.turning_time, status, contact, name, history, limit,
        solution.units.error, solution, pull_off_force=solution.pull_off_force, zone_radius=zone,
        jumps=solution.march.jumps,
    )  # fmt: skip


def _program(adhesion: Adhesion, history: History, name: str) -> tuple[Array, Array, float]:
    """Return knots [s] from the first attraction on, rates [m/s] between them, and the largest depth [m]."""
    if adhesion.shape:
        raise InputError("adhesion", rule="must be a single one for an indentation")
    reach = float(np.asarray(adhesion.range))
    widths = np.diff(history.knots)
    if name != "depth":
        raise InputError(name, rule="must be a depth with adhesion")
    if np.any(history.coefficients[:, 2:]) or np.any(widths == 0.0):
        raise InputError("depth", rule="must be of straight lines without steps with adhesion: an array over time")
    starts, ends = history.coefficients[:, 0], history.coefficients.sum(axis=1)
    if starts[0] > -reach:
        rule = f"must begin outside of the attraction, at {-reach:.4g} m or above"
        raise InputError("depth", float(starts[0]), rule, "m")
    near = np.flatnonzero(ends > -reach)
    if not near.size:
        raise InputError("depth", rule=f"must come within the range of the attraction, {reach:.4g} m")
    first = int(near[0])
    rates = (ends - starts)[first:] / widths[first:]
    touch = history.knots[first] + (-reach - starts[first]) / rates[0]
    return np.append(touch, history.knots[first + 1 :]), rates, float(ends.max())


def _solved(body: Sticky, history: History, program: tuple[Array, Array, float], rtol: float) -> AdhesiveSolution:
    """March with more and more elements until the largest force and the largest pull are known to `rtol`."""
    from restitution.kernel.adhesion import HELD, NO_ROOM, SEPARATED

    knots, rates, deepest = program
    profile = body.profile
    width = float(profile.contact_radius(max(deepest, float(np.asarray(body.adhesion.range)))))
    count, trials, series = FEWEST, 0, Richardson()
    while count <= MOST and trials < _TRIALS:
        march = body.follow(width, knots, rates, count)
        ended = march.end in (HELD, SEPARATED)
        if march.end == NO_ROOM or (ended and march.widest < FILLED * width and count == FEWEST):
            width = WIDER * width if march.end == NO_ROOM else 1.02 * march.widest
            trials += 1
            if not ROOM * width < float(np.asarray(profile.max_contact_radius)):
                raise InputError("depth", rule=f"must not bring the attraction beyond the profile, {profile.end}")
            count, series = FEWEST, Richardson()
            continue
        if not ended:
            break
        forces = march.motion[:, 3]
        (largest, pull), errors = series.add([forces.max(initial=0.0), -forces.min(initial=0.0)])
        error = float(errors.max()) / max(largest, pull)
        if error <= rtol:
            return AdhesiveSolution(history, _Units(float(knots[0]), error), march, float(pull))
        count *= 2
    rule = f"has no solution within rtol = {rtol:g}; loosen it, or take a lower stress if the attracted ring is thin"
    raise InputError("adhesion", rule=rule)
