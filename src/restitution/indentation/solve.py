"""Solution of an indentation under a prescribed depth or force, in SI and in dimensionless numbers."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.checks import finite, single, single_positive, within
from restitution.contact.contact import Contact, of_type
from restitution.contact.geometry import Geometry
from restitution.contact.path import path_table, scaled
from restitution.contact.profile import Profile
from restitution.errors import InputError
from restitution.indentation.evolution import (
    Reloading,
    check_recontact,
    grown_contact,
    recover_depth,
    scratch,
    shrink_contact,
)
from restitution.indentation.history import UNITS, History, contact_part, graded
from restitution.indentation.result import IndentationResult, IndentationStatus
from restitution.kernel.growing import depth_rounding
from restitution.kernel.indentation import sample, through_jump
from restitution.kernel.indentation_rows import ELEMENT_SHARE, LARGEST, SMALLEST
from restitution.kernel.memory import DEPTH, FORCE, ScaledContact, allocate
from restitution.kernel.path import Path, power_path, table_path
from restitution.material.prony import PronySeries, Retardation
from restitution.material.viscoelastic import Material

Array = NDArray[np.float64]
Prescribed = History | ArrayLike | Callable[[Any], Any]

# Number of even times of a result if no times are given.
_POINTS = 401


def indent(
    material: Material,
    profile: Geometry,
    *,
    depth: Prescribed | None = None,
    force: Prescribed | None = None,
    time: ArrayLike | None = None,
    counter_material: Material | None = None,
    rtol: float = 1e-8,
) -> IndentationResult:
    """Force under a prescribed depth, or depth under a prescribed force, of one indentation and its retraction.

    Parameters
    ----------
    material : Material
        Material of the target.
    profile : Geometry
        Profile of the indenter, or another geometry, with scalar parameters.
    depth : History, array, callable or float
        Depth d of the tip below the undeformed surface [m], negative before touch: a `History` (`ramp`, `triangle`,
        `hold`, `sine_arch`), values at `time` joined by straight lines (the same time twice is a step), a smooth
        function that maps times to depths, or one number, which is held from the first time on.
    force : History, array, callable or float
        Normal force F >= 0 [N] instead of the depth.
    time : array, optional
        Times [s] of the result, ascending: for an array of values those of the values; for a function they should
        include its kinks. About 400 times if a `History` is given alone.
    counter_material : Material, optional
        Material of the indenter; rigid by default.
    rtol : float
        Error of force, depth and contact radius over their largest value, and of times over the duration; in
        [1e-11, 1e-2].

    Returns
    -------
    IndentationResult
        The history, the end of contact, the largest force, the work.

    Raises
    ------
    InputError
        If an argument is out of its range or of another type. If the contact grows again once it has shrunk, which the
        theory excludes, the field is `time` and the value the time.

    Notes
    -----
    While the contact grows, `F = 2 int E*(t - t') dPi` (Lee and Radok 1960). While it shrinks,
    `int_t1^t E*(t - t') dd = 0` and `F = 2 int_0^t1 E*(t - t') dPi`, where the growing contact had the same radius at
    t1 (Ting 1966). Quasi-static, small strain, no adhesion, no friction.

    Examples
    --------
    A gel under an AFM tip, pressed in and pulled back at 1 um/s:

    >>> from restitution.contact.profile import Parabola
    >>> from restitution.indentation.history import triangle
    >>> from restitution.material.prony import PronySeries
    >>> gel = Material(PronySeries(200.0 / 3.0, [800.0 / 3.0], [0.3]), bulk=math.inf)
    >>> result = indent(gel, Parabola(2.5e-6), depth=triangle(1e-6, 1.0))
    >>> print(f"{result.max_force:.9g} N, contact ends at {result.contact_end_time:.6f} s")
    1.38541713e-09 N, contact ends at 1.407006 s
    """
    # The store of contacts takes hashable arguments only.
    of_type("material", material, Material)
    of_type("profile", profile, Geometry)
    if counter_material is not None:
        of_type("counter_material", counter_material, Material)
    contact = _contact(material, profile, counter_material)
    profile = contact.profile
    if np.ndim(profile.stiffness_radius(0.0)):
        raise InputError("profile", wanted="must have single numbers as parameters: an indentation has one profile")
    if (depth is None) == (force is None):
        raise InputError("depth, force", wanted="exactly one of the two must be given: depth= or force=")
    rtol = single("rtol", within("rtol", rtol, 1e-11, 1e-2))
    name = "force" if depth is None else "depth"
    prescribed = _history(name, force if depth is None else depth, time)
    solution = Solution(contact, contact.reduced_modulus, prescribed, name, rtol)
    if not profile.separable:
        contact.warn_if_approximate()
        series = profile.effective_moduli(material, np.array(solution.max_contact_radius)).row(0)
        solution = Solution(contact, series, prescribed, name, rtol)
    times = solution.times(_POINTS) if time is None else np.atleast_1d(finite("time", time, "s"))
    columns = solution.at(times)
    first = np.flatnonzero(times[1:] == times[:-1])
    if first.size:
        # A time that is given twice is before and behind the jump.
        for column, values in zip(columns, solution.at(times[first], before=True), strict=True):
            column[first] = values
    end = solution.end_time
    return IndentationResult(
        times, *columns, end, solution.turning_time,
        IndentationStatus.SEPARATED if math.isfinite(end) else IndentationStatus.IN_CONTACT,
        contact, name, prescribed, rtol, rtol + solution.units.error, solution,
    )  # fmt: skip


# A user indents one material many times, and its reduced modulus takes longer than one indentation.
@lru_cache(maxsize=32)
def _contact(material: Material, profile: Geometry, counter_material: Material | None) -> Contact:
    return Contact(material, profile, counter_material)


def _history(name: str, prescribed: Any, time: ArrayLike | None) -> History:
    if isinstance(prescribed, History):
        return prescribed
    if isinstance(prescribed, (int, float)) and not isinstance(prescribed, bool):
        return _step(name, prescribed, time)
    if time is None:
        raise InputError("time", wanted=f"must be given with {name} as an array or a function")
    if callable(prescribed):
        return History.from_function(prescribed, time, name=name)
    return History.from_points(time, prescribed, name=name)


def _step(name: str, value: float, time: ArrayLike | None) -> History:
    """One value, from the first time on."""
    value = single_positive(name, value, UNITS[name])
    if time is None:
        raise InputError("time", wanted=f"must be given with {name} as a number, which is held from first to last")
    times = np.atleast_1d(finite("time", time, "s"))
    first, last = float(times.min()), float(times.max())
    return History.from_points([first, first, last], [0.0, value, value], name=name)


class Units(NamedTuple):
    """Units of the dimensionless numbers in SI."""

    touch: float  # Time of first touch [s]
    time: float  # Duration of the history from there on [s]
    length: float  # Largest depth [m], or a bound of it
    radius: float  # Stiffness radius there [m]
    force: float  # 2 E radius length [N], with a modulus E typical of the duration
    error: float  # Error of forces by the table of the profile, over the largest one; 0 for power laws


class Solution:
    """Exact solution under a prescribed history of the `name` "depth" or "force", in SI."""

    def __init__(self, contact: Contact, series: PronySeries, history: History, name: str, rtol: float) -> None:
        self.history, self._profile = history, contact.profile
        self.by_depth = name == "depth"
        tolerance = ELEMENT_SHARE * rtol
        part = contact_part(history, name)
        if self.by_depth:
            _check_depth(part, contact.profile, series.parallel_viscosity)
        self._contact, self.units = _scaled(series, contact.profile, part, name)
        work = scratch(self._contact.moduli.size)
        past = grown_contact(self._contact, work, tolerance, contact.profile)
        rounding, moment = depth_rounding(past)
        if rounding > rtol * past.elements.depths[-1]:
            wanted = f"the {name} rises too fast there for the digits of its times at rtol = {rtol:g}; "
            wanted += "make it a step, two points at the same time"
            raise InputError("time", self._time(moment), wanted, "s")
        try:
            past, places, times = shrink_contact(self._contact, past, work, rtol)
            if self.by_depth and past.end < 1.0:
                creep = _scaled_retardation(series, self.units)
                check_recontact(self._contact, past, work, places, times, rtol, creep)
        except Reloading as error:
            raise Reloading("time", float(self._time(error.value)), error.wanted, "s") from None
        self._past = past
        self._recovery = recover_depth(self._contact, past, work, tolerance)

    @property
    def turning_time(self) -> float:
        """Time at which the contact starts to shrink [s]; the end of the history if it does not."""
        return self._moment(self._past.turning if self._contact.path.exponent != 0.0 else 1.0)

    @property
    def max_contact_radius(self) -> float:
        """Contact radius at the end of growth [m]."""
        if self._contact.path.exponent == 0.0 and isinstance(self._profile, Profile):
            return self.units.radius
        return float(self._profile.contact_radius(self.units.length * self._past.elements.depths[-1]))

    @property
    def end_time(self) -> float:
        """Time at which the contact ends [s]; infinite if it outlasts the history."""
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
        ends = [self._past.turning, last]
        starts = self._past.elements.starts, self._recovery.starts
        knots = np.unique(np.concatenate([*starts, self._contact.knots, ends]))
        return self._time(knots[knots <= last])

    @property
    def steps(self) -> list[int]:
        """Places of the steps of the history up to the end of contact."""
        knots = self._contact.knots
        return np.flatnonzero((np.diff(knots) == 0.0) & (knots[:-1] <= self._past.end)).tolist()

    def through(self, place: int, fractions: Array) -> tuple[Array, Array]:
        """Depth [m] and force [N] on the way through the step at this place, at fractions of it in [0, 1]."""
        order = np.argsort(fractions)
        columns, work = np.empty((2, fractions.size)), scratch(self._contact.moduli.size)
        through_jump(self._contact, self._past, self._recovery, work, place, fractions[order], columns)
        depth, force = columns[:, np.argsort(order)]
        return depth * self.units.length, force * self.units.force

    def at(self, times: ArrayLike, *, before: bool = False) -> tuple[Array, Array, Array, Array]:
        """Depth [m], its rate [m/s], force [N] and contact radius [m] at times [s] of the history.

        At a kink or a jump the values behind it, or those before it.
        """
        t = np.atleast_1d(np.asarray(finite("time", times, "s"), dtype=np.float64))
        start, stop = self.history.start, self.history.stop
        if t.size and (t.min() < start or t.max() > stop):
            worst = float(t.min() if t.min() < start else t.max())
            wanted = f"must be in [{start:g}, {stop:g}] s, where the history is given"
            raise InputError("time", worst, wanted, "s")
        order = np.argsort(t, kind="stable")
        t, units = t[order], self.units
        early = int(np.searchsorted(t, units.touch, side="right" if before else "left"))
        sampled = np.empty((5, t.size - early))
        inside = np.minimum((t[early:] - units.touch) / units.time, 1.0)
        if before:
            inside = np.nextafter(inside, -math.inf)
        sample(self._contact, self._past, self._recovery, scratch(self._contact.moduli.size), inside, sampled)
        sampled *= np.array([[units.length], [units.length / units.time], [units.force], [units.radius], [1.0]])
        # A force near zero may have either sign by rounding; the theory has no adhesion.
        np.maximum(sampled[2], 0.0, out=sampled[2])
        if early:
            free = np.zeros((5, early))
            if self.by_depth:
                free[0], free[1] = self.history(t[:early]), self.history.rate(t[:early])
                free[:, t[:early] == units.touch] = 0.0
            sampled = np.concatenate([free, sampled], axis=1)
        depth, rate, force, radius, place = sampled[:, np.argsort(order)]
        if not isinstance(self._profile, Profile):
            radius = np.where(radius > 0.0, self._profile.contact_radius_at(place**2 * units.length, radius), 0.0)
        return depth, rate, force, radius

    def _moment(self, scaled: float) -> float:
        """Time [s]; at a knot of the history the knot itself, without the rounding of the units."""
        knots = self.history.knots
        if scaled == math.inf:
            return math.inf
        same = np.flatnonzero((knots - self.units.touch) / self.units.time == scaled)
        return float(knots[same[0]]) if same.size else float(self._time(scaled))

    def _time(self, scaled: Any) -> Any:
        # The end of the history, without the rounding of the units.
        return np.minimum(self.units.touch + self.units.time * scaled, self.history.stop)


def _check_depth(part: History, profile: Geometry, dashpot: float) -> None:
    """Refuse a depth beyond the end of the profile, and a step on a material with a parallel dashpot."""
    most, deepest = float(part.coefficients.sum(axis=1).max()), float(np.min(profile.max_depth))
    if most > deepest:
        raise InputError("depth", most, f"must be <= {deepest:g} m, {profile.end}", "m")
    jumps = part.knots[:-1][np.diff(part.knots) == 0.0]
    if dashpot > 0.0 and jumps.size:
        wanted = f"must not jump, as at time = {jumps[0]:g} s: a dashpot in parallel makes the force infinite"
        raise InputError("depth", wanted=wanted)


def _largest_depth(series: PronySeries, profile: Geometry, force: float, duration: float) -> float:
    """Bound of the depth [m] that a force [N] held for a time [s] reaches: that of the creep compliance."""
    integral = 0.5 * force * float(series.creep_compliance(duration))
    exponent, coefficient = profile.path_exponent, profile.path_coefficient
    if exponent is not None and coefficient is not None:
        p, c = float(exponent), float(coefficient)
        return (0.5 * (p + 2.0) * integral / c) ** (2.0 / (p + 2.0))
    most = float(profile.max_depth)
    low, high = -300.0, math.log(min(most, 1e100))
    if float(profile.force_integral_at_depth(min(math.exp(high), most))) < integral:
        return most
    for _ in range(60):
        middle = 0.5 * (low + high)
        if float(profile.force_integral_at_depth(min(math.exp(middle), most))) < integral:
            low = middle
        else:
            high = middle
    return min(math.exp(high), most)


def _scaled(series: PronySeries, profile: Geometry, history: History, name: str) -> tuple[ScaledContact, Units]:
    """Dimensionless contact, and its units; the history is prescribed from first touch on."""
    by_depth = name == "depth"
    touch, duration = history.start, history.stop - history.start
    if not SMALLEST < duration < LARGEST:
        wanted = f"must last between {SMALLEST:g} and {LARGEST:g} s from first touch on"
        raise InputError("time", duration, wanted, "s")
    peak = float(history.coefficients.sum(axis=1).max())
    depth = peak if by_depth else _largest_depth(series, profile, peak, duration)
    path, radius, error = _path(profile, depth)
    moduli, times = series.branch_moduli, series.relaxation_times
    typical = series.equilibrium_modulus + float(moduli @ np.minimum(1.0, times / duration))
    typical += series.parallel_viscosity / duration
    with np.errstate(over="ignore", under="ignore"):
        force = 2.0 * typical * radius * depth
    if not all(SMALLEST < value < LARGEST for value in (depth, radius, force)):
        wanted = f"leads to a depth of {depth:.3g} m, a contact radius of {radius:.3g} m and a force of "
        wanted += f"{force:.3g} N; each must be in [{SMALLEST:g}, {LARGEST:g}]"
        raise InputError(name, peak, wanted, UNITS[name])
    units = Units(touch, duration, depth, radius, force, error)
    rates = duration / times
    glass, compliances, recoveries = 0.0, np.empty(0), np.empty(0)
    if not by_depth:
        creep = _scaled_retardation(series, units)
        glass = creep.instantaneous_compliance
        recoveries = 1.0 / creep.retardation_times
        compliances = creep.branch_compliances * recoveries
        if creep.fluidity > 0.0:
            recoveries = np.append(recoveries, 0.0)
            compliances = np.append(compliances, creep.fluidity)
        history = graded(history)
    knots = (history.knots - touch) / duration
    segments = 0 if by_depth else knots.size - 1
    contact = ScaledContact(
        DEPTH if by_depth else FORCE, knots, history.coefficients / (depth if by_depth else units.force),
        series.equilibrium_modulus / typical, moduli / typical, rates, series.parallel_viscosity / typical / duration,
        float(np.min(1.0 / rates, initial=1.0)), glass, compliances, recoveries,
        allocate(recoveries, segments), allocate(recoveries, segments), path,
    )  # fmt: skip
    return contact, units


def _scaled_retardation(series: PronySeries, units: Units) -> Retardation:
    """Creep compliance in units of length radius/force and of the duration."""
    creep = series.retardation
    modulus = 0.5 * units.force / (units.radius * units.length)
    return Retardation(
        creep.instantaneous_compliance * modulus,
        creep.fluidity * modulus * units.time,
        creep.branch_compliances * modulus,
        creep.retardation_times / units.time,
    )


def _path(profile: Geometry, depth: float) -> tuple[Path, float, float]:
    """Path in units of the depth, the stiffness radius there [m], and the error of the table."""
    radius = float(profile.stiffness_radius(depth))
    if profile.path_exponent is not None:
        return power_path(float(profile.path_exponent)), radius, 0.0
    table = path_table(profile, depth)
    return table_path(scaled(table, depth, radius)), radius, table.error
