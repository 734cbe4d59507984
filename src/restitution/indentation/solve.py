"""Solution of an indentation under a prescribed depth or force, in SI and in dimensionless numbers."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextvars import ContextVar
from functools import lru_cache
from numbers import Number
from typing import Any

import numpy as np
from numpy.polynomial.polynomial import polyval
from numpy.typing import ArrayLike, NDArray

from restitution.checks import Array, finite, single, single_positive, within
from restitution.contact.adhesion import Adhesion
from restitution.contact.geometry import Contact, Geometry, of_type
from restitution.contact.profiles import Profile
from restitution.errors import InputError
from restitution.indentation.elastic import ElasticSolution
from restitution.indentation.history import NO_FORCE, UNITS, History, contact_part, graded
from restitution.indentation.panels import (
    PanelSolution,
    Units,
    check_depth,
    even_times,
    largest_depth,
    path_of,
    path_power,
    solve_by_panels,
)
from restitution.indentation.result import IndentationResult, IndentationStatus
from restitution.indentation.surface import Surface, check_surface
from restitution.indentation.work import largest_of, loop_work
from restitution.kernel.growing import BEYOND_PROFILE, TOO_STEEP, Elements, Past, depth_rounding, grow_contact
from restitution.kernel.indentation import (
    ELEMENT_SHARE,
    LARGEST,
    SMALLEST,
    Recovery,
    recover,
    sample,
    through_jump,
)
from restitution.kernel.memory import (
    DEPTH,
    FORCE,
    TERMS,
    ScaledContact,
    Scratch,
    Segments,
    allocate,
    quadrature,
    remember,
)
from restitution.kernel.plain import single_problem
from restitution.kernel.shrinking import (
    Checks,
    check_points,
    end_of_contact,
    innermost_load_rises,
    largest_rate,
    load_rounding,
    regrowth,
    write_depth_memory,
)
from restitution.material.prony import PronySeries, Retardation
from restitution.material.viscoelastic import Material, single_material

# Evolution of the contact: growth (Lee and Radok), shrinkage and end (Ting), recovery of the surface.


# Memory of 1 GB; a caller may allow less.
MOST_ELEMENTS = ContextVar("most_elements", default=1 << 20)


class Reloading(Exception):
    """The contact grows again, which panels solve."""


def scratch(modes: int) -> Scratch:
    """Return scratch space of a contact with this number of modes, for one call at a time."""
    return Scratch(np.empty(TERMS), np.empty(TERMS), np.empty((2, TERMS)), np.empty(modes), np.empty((2, TERMS + 1)))


def room_for(rates: Array, segments: int, elements: int) -> tuple[Segments, Past]:
    """Return the arrays for a history of `segments` and a growing contact of `elements`, with modes of these rates."""
    grown = Elements(
        np.empty(elements), np.empty(elements), np.empty(elements, dtype=np.int64), np.zeros(elements + 1),
        np.zeros(elements + 1), np.empty((elements, TERMS)), np.empty((elements, TERMS)),
    )  # fmt: skip
    depth, integral = allocate(rates, elements + segments), allocate(rates, elements)
    pieces = Segments(np.empty(segments), np.empty((segments, TERMS)), np.empty((segments, TERMS)))
    return pieces, Past(grown, 0, depth, integral, segments, 1.0, math.inf)


def grown_contact(contact: ScaledContact, work: Scratch, tolerance: float, profile: Geometry) -> Past:
    """Return the growing contact and its memory, without the end of contact.

    The tolerance of depth and force is relative to the largest; the depth is at most that of the profile.
    """
    m = contact.values.shape[0]
    room = 0
    while room < MOST_ELEMENTS.get():
        room = min(max(4 * room, 16 * m + 1008), MOST_ELEMENTS.get())
        segments, past = room_for(contact.rates, m, room)
        total, first, turning = grow_contact(contact, quadrature(), work, tolerance, segments, past)
        if total == BEYOND_PROFILE:
            deepest = float(np.min(profile.max_depth))
            rule = f"must not press the tip deeper than {deepest:g} m, {profile.end}"
            raise InputError("force", rule=rule)
        if total == TOO_STEEP:
            raise InputError("history", rule="rises too steeply for the digits of its times; smooth it")
        if total >= 0:
            elements = Elements(*(a[: total + 1] if a.shape == (room + 1,) else a[:total] for a in past.elements))
            return past._replace(elements=elements, total=total, first=first, turning=turning)
    raise InputError("history", rule=f"needs over {MOST_ELEMENTS.get()} elements; smooth or thin it, or loosen rtol")


def room_for_checks(segments: int, modes: int) -> Checks:
    """Return the arrays for the checks of a contact that shrinks over a number of segments."""
    room = segments * (9 + 2 * modes)
    return Checks(np.empty(room, dtype=np.int64), np.empty(room))


def checks_of(contact: ScaledContact, past: Past) -> Checks:
    """Return the instants at which the shrinking contact is checked."""
    room = room_for_checks(max(contact.values.shape[0] - past.first, 0), contact.rates.size)
    count = check_points(contact, past, room)
    return Checks(room.segments[:count], room.times[:count])


def end_of_force(contact: ScaledContact) -> float:
    """Return the time at which a prescribed force has fallen to zero; infinite if it does not."""
    ends = contact.values.sum(axis=1)
    falls = np.cumsum(ends < contact.values[:, 0]) > 0
    zero = np.flatnonzero(falls & (ends <= NO_FORCE * ends.max()))
    if not zero.size:
        return math.inf
    n = int(zero[0])
    if np.any(ends[n + 1 :] > NO_FORCE * ends.max()):
        raise Reloading
    return float(contact.knots[n + 1])


def shrink_contact(contact: ScaledContact, past: Past, work: Scratch, tolerance: float) -> tuple[Past, Checks]:
    """Return the contact with its end, and its checks; raise `Reloading` if it grows again before."""
    checks = checks_of(contact, past)
    if contact.control == DEPTH:
        past = past._replace(end=end_of_contact(contact, past, work, checks))
    else:
        past = past._replace(end=end_of_force(contact))
    if contact.path.exponent != 0.0 and checks.times.size:
        tolerance += 10.0 * depth_rounding(past)[0]
        if regrowth(contact, past, work, checks, tolerance, load_rounding(contact, past)) >= 0:
            raise Reloading
    return past, checks


def check_recontact(
    contact: ScaledContact, past: Past, work: Scratch, checks: Checks, tolerance: float, creep: Retardation
) -> None:
    """Raise `Reloading` if the recovering surface reaches the indenter again after the contact."""
    if not innermost_load_rises(contact, past, work, checks, tolerance, load_rounding(contact, past)):
        return
    # The rounding of the times moves a steep history.
    rounding_allowance = tolerance + 1e-15 * largest_rate(contact, past)
    share = np.linspace(0.0, 1.0, 65)
    for i in range(past.first, contact.values.shape[0]):
        low, high = max(float(contact.knots[i]), past.end), float(contact.knots[i + 1])
        if high <= low:
            continue
        moments = low + (high - low) * share
        surface = recovering_surface(contact, past, work, creep, moments)
        if np.any(_prescribed(contact, np.full(share.size, i), moments) > surface + rounding_allowance):
            raise Reloading


def _prescribed(contact: ScaledContact, places: NDArray[np.int64], times: Array) -> Array:
    width = contact.knots[places + 1] - contact.knots[places]
    u = np.divide(times - contact.knots[places], width, out=np.ones_like(times), where=width > 0.0)
    return polyval(u, contact.values[places].T, tensor=False)


def recovering_surface(contact: ScaledContact, past: Past, work: Scratch, creep: Retardation, times: Array) -> Array:
    """Return the depth of the surface under the tip after the contact, which ended under a prescribed depth.

    Without load it is a sum of exponentials at the retardation times.
    """
    n = int(np.searchsorted(contact.knots, past.end, side="left"))
    jumps = n + 1 < contact.knots.size and contact.knots[n] == contact.knots[n + 1] == past.end
    i = n if jumps else max(n - 1, past.first)
    depth = float(contact.values[i, 0] if jumps else _prescribed(contact, np.array([i]), np.array([past.end]))[0])
    write_depth_memory(contact, past, work, i, past.end)
    loads = np.append(contact.moduli * work.now, contact.equilibrium * depth)
    rates = np.append(contact.rates, 0.0)
    surface = np.full(times.size, depth if contact.equilibrium == 0.0 else 0.0)
    elapsed = times - past.end
    for compliance, time in zip(creep.branch_compliances, creep.retardation_times, strict=True):
        amplitude = compliance * float(np.sum(loads / (1.0 - rates * time)))
        surface += amplitude * np.exp(-elapsed / time)
    if creep.fluidity > 0.0:
        surface -= creep.fluidity * float(np.sum(loads[:-1] / contact.rates))
    return surface


def recover_depth(contact: ScaledContact, past: Past, work: Scratch, tolerance: float) -> Recovery:
    """Return the depth of the shrinking contact under a prescribed force; empty if the contact does not shrink."""
    count, room = 0, min(512, MOST_ELEMENTS.get())
    recovery = _room_for_recovery(0)
    if contact.control != DEPTH and past.turning < 1.0 and contact.path.exponent != 0.0:
        compliance = contact.glass + float(
            np.sum(np.where(contact.recoveries > 0.0, 1.0, 0.0) * contact.compliances
                   * -np.expm1(-contact.recoveries) / np.maximum(contact.recoveries, 1e-300))
            + np.sum(contact.compliances[contact.recoveries == 0.0])
        )  # fmt: skip
        allowed = tolerance * float(past.elements.depths[past.total]) / compliance
        allowed += (contact.equilibrium + float(contact.moduli.sum())) * depth_rounding(past)[0]
        while True:
            recovery = _room_for_recovery(room)
            count = recover(contact, past, quadrature(), work, allowed, recovery)
            if count >= 0:
                break
            room *= 4
            if room > MOST_ELEMENTS.get():
                raise InputError("force", rule="needs too many elements; smooth or thin the history, or loosen rtol")
    level = allocate(contact.recoveries, count)
    recovery = Recovery(recovery.starts[:count], recovery.lengths[:count], recovery.q[:count], level)
    remember(recovery.lengths, recovery.q, level, work.sweep)
    return recovery


def _room_for_recovery(elements: int) -> Recovery:
    """Return the arrays for a recovery of a number of elements, without its memory."""
    return Recovery(np.empty(elements), np.empty(elements), np.empty((elements, TERMS)), allocate(np.empty(0), 0))


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
    spring_constant: float | None = None,
    surface: Surface | None = None,
    counter_material: Material | None = None,
    adhesion: Adhesion | None = None,
    rtol: float = 1e-8,
) -> IndentationResult:
    """Force under a prescribed depth, depth under a prescribed force, or both under a spring, over any history.

    The contact may grow, shrink, end and begin again, over surface that has not recovered.

    Parameters
    ----------
    material : Material
        Material of the target.
    profile : Geometry
        Profile of the indenter, or another geometry, with scalar parameters.
    depth : History, array, callable or float
        Depth d of the tip below the undeformed surface [m], negative before touch: a `History` (`ramp`, `triangle`,
        `cycles`, `hold`, `sine_arch`), values at `time` joined by straight lines (the same time twice is a step), a
        smooth function that maps times to depths, or one number, which is held from the first time on.
    force : History, array, callable or float
        Normal force F >= 0 [N] instead of the depth.
    spring_constant : float, optional
        Spring constant k [N/m] of a spring that holds the indenter, such as a cantilever; `depth` is then that of its
        base, z, and the tip follows from `F = k (z - d)`.
    surface : Surface, optional
        Surface that an earlier result has left, from its `surface()`; a virgin one by default. The history begins
        above it.
    time : array, optional
        Times [s] of the result, ascending: for an array of values those of the values; for a function they should
        include its kinks. About 400 times if a `History` is given alone.
    counter_material : Material, optional
        Material of the indenter; rigid by default.
    adhesion : Adhesion, optional
        Attraction of the surfaces, under a depth that begins outside of it, or a force that begins at 0 or above and
        may be < 0 later: the result is then an `AdhesiveIndentation`, whose largest force and pull (of a spring or a
        force also the largest depth) are known to `rtol`, or 1e-6.
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
        If an argument is out of its range or of another type, or the contact cannot be solved within `rtol`.

    Notes
    -----
    Over virgin surface that grows, `F = 2 int E*(t - t') dPi` (Lee and Radok 1960); for one unloading,
    `int_t1^t E*(t - t') dd = 0` and `F = 2 int_0^t1 E*(t - t') dPi`, where the growing contact had the same radius at
    t1 (Ting 1966). For other histories the surface carries its state: the elements named by s, the depth at which the
    undeformed surface touches them, have the load `q = int E*(t - t') dW`; those in contact follow the body,
    W = d - s, the others are free, q = 0, and `F = 2 int q da(s)`. Independent elements with re-contact are the exact
    solution for every history of an indenter with g' >= 0. Quasi-static, small strain, no adhesion, no friction.

    Examples
    --------
    A gel under an AFM tip, pressed in and pulled back at 1 um/s:

    >>> from restitution.contact.profiles import Parabola
    >>> from restitution.indentation.history import triangle
    >>> from restitution.material.prony import PronySeries
    >>> gel = Material(PronySeries(200.0 / 3.0, [800.0 / 3.0], [0.3]), bulk=math.inf)
    >>> result = indent(gel, Parabola(2.5e-6), depth=triangle(1e-6, 1.0))
    >>> print(f"{result.max_force:.9g} N, contact ends at {result.contact_end_time:.6f} s")
    1.38541713e-09 N, contact ends at 1.407006 s
    """
    contact = contact_of(material, profile, counter_material)
    profile = contact.profile
    if (depth is None) == (force is None):
        raise InputError("depth, force", rule="exactly one of the two must be given: depth= or force=")
    rtol = single("rtol", within("rtol", rtol, 1e-11, 1e-2))
    name = "force" if depth is None else "depth"
    prescribed = _history(name, force if depth is None else depth, time)
    stiffness = None
    if spring_constant is not None:
        stiffness = single_positive("spring_constant", spring_constant, "N/m")
        if name == "force":
            rule = "does not go with spring_constant; give the depth of the base of the spring"
            raise InputError("force", rule=rule)
    if adhesion is not None:
        of_type("adhesion", adhesion, Adhesion)
        if surface is not None:
            raise InputError("surface", rule="must be left out with adhesion")
        from restitution.indentation.adhesion import indent_with_adhesion

        return indent_with_adhesion(contact, adhesion, prescribed, name, stiffness, rtol)
    if surface is not None:
        check_surface(surface, contact)
    solution = _solved(contact, None, prescribed, name, rtol, stiffness, surface)
    if not profile.separable:
        contact.warn_if_approximate()
        series = profile.effective_moduli(material, np.array(solution.max_contact_radius)).row(0)
        solution = _solved(contact, series, prescribed, name, rtol, stiffness, surface)
    times = solution.times(_POINTS) if time is None else np.atleast_1d(finite("time", time, "s"))
    columns = solution.at(times)
    first = np.flatnonzero(times[1:] == times[:-1])
    if first.size:
        # A repeated time is before and behind the jump.
        for column, values in zip(columns, solution.at(times[first], before=True), strict=True):
            column[first] = values
    end = solution.end_time
    return IndentationResult(
        times, *columns, solution.contact_intervals, solution.turning_times, end, solution.turning_time,
        IndentationStatus.SEPARATED if math.isfinite(end) else IndentationStatus.IN_CONTACT,
        contact, name if stiffness is None else "base", prescribed, rtol, rtol + solution.units.error, solution,
    )  # fmt: skip


@single_problem()
def _solved(
    contact: Contact, series: PronySeries | None, history: History, name: str, rtol: float, stiffness: float | None,
    surface: Surface | None,
) -> Solution | PanelSolution | ElasticSolution:  # fmt: skip
    """Return the solution: of one approach and one release by its closed form, of any other history by panels.

    The surface of an elastic body has no memory, and under a force its depth has a closed form.
    """
    series = contact.reduced_modulus if series is None else series
    if stiffness is None and surface is None:
        try:
            return Solution(contact, series, history, name, rtol)
        except Reloading:
            pass
    if series.is_elastic and name == "force" and stiffness is None:
        return ElasticSolution(contact, series, history, rtol)
    return solve_by_panels(contact.profile, series, history, name, rtol, stiffness, surface)


def contact_of(material: Material, profile: Geometry, counter_material: Material | None) -> Contact:
    """Return the contact of single materials with one profile; refuse others."""
    # The store of contacts takes hashable arguments only.
    of_type("material", material, Material)
    of_type("profile", profile, Geometry)
    single_material("material", material)
    if counter_material is not None:
        of_type("counter_material", counter_material, Material)
        single_material("counter_material", counter_material)
    contact = _contact(material, profile, counter_material)
    if np.ndim(contact.profile.stiffness_radius(0.0)):
        raise InputError("profile", rule="must have single numbers as parameters: an indentation has one profile")
    return contact


# A user indents one material many times, and its reduced modulus takes longer than one indentation.
@lru_cache(maxsize=32)
def _contact(material: Material, profile: Geometry, counter_material: Material | None) -> Contact:
    return Contact(material, profile, counter_material)


def _history(name: str, prescribed: Any, time: ArrayLike | None) -> History:
    if isinstance(prescribed, History):
        return prescribed
    if isinstance(prescribed, (Number, str)) or getattr(prescribed, "ndim", None) == 0:
        return _step(name, prescribed, time)
    if time is None:
        raise InputError("time", rule=f"must be given with {name} as an array or a function")
    if callable(prescribed):
        return History.from_function(prescribed, time, name=name)
    return History.from_points(time, prescribed, name=name)


def _step(name: str, value: Any, time: ArrayLike | None) -> History:
    """Return one value, from the first time on."""
    value = single_positive(name, value, UNITS[name])
    if time is None:
        raise InputError("time", rule=f"must be given with {name} as a number, which is held from first to last")
    times = np.atleast_1d(finite("time", time, "s"))
    first, last = float(times.min()), float(times.max())
    return History.from_points([first, first, last], [0.0, value, value], name=name)


class Solution:
    """Exact solution under a prescribed history of the `name` "depth" or "force", in SI."""

    def __init__(self, contact: Contact, series: PronySeries, history: History, name: str, rtol: float) -> None:
        self.history, self._profile, self.rtol = history, contact.profile, rtol
        self._series, self._name = series, name
        self.by_depth = name == "depth"
        tolerance = ELEMENT_SHARE * rtol
        part = contact_part(history, name)
        if self.by_depth:
            check_depth(part, contact.profile, series.parallel_viscosity)
        self._contact, self.units = _scaled(series, contact.profile, part, name)
        work = scratch(self._contact.moduli.size)
        past = grown_contact(self._contact, work, tolerance, contact.profile)
        rounding, moment = depth_rounding(past)
        if rounding > rtol * past.elements.depths[-1]:
            rule = f"the {name} rises too fast there for the digits of its times at rtol = {rtol:g}; "
            rule += "make it a step, two points at the same time"
            raise InputError("time", self._time(moment), rule, "s")
        past, checks = shrink_contact(self._contact, past, work, rtol)
        if self.by_depth and past.end < 1.0:
            creep = _scaled_retardation(series, self.units)
            check_recontact(self._contact, past, work, checks, rtol, creep)
        self._past = past
        self._recovery = recover_depth(self._contact, past, work, tolerance)
        self._first_rate = None if self.by_depth else _rate_at_touch(self._contact, contact.profile, part, self.units)

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

    @property
    def contact_intervals(self) -> Array:
        """Times [s] at which the contact begins and ends, shape (1, 2)."""
        return np.array([[self.units.touch, self.end_time]])

    @property
    def turning_times(self) -> Array:
        """Time [s] at which the contact starts to shrink, if it does."""
        return np.array([self.turning_time] if self._past.turning < min(self._past.end, 1.0) else [])

    @property
    def panels(self) -> PanelSolution:
        """The same by panels, which have the state of the surface."""
        return solve_by_panels(self._profile, self._series, self.history, self._name, self.rtol)

    def largest(self, column: int) -> float:
        """Return the largest value of a column of `at`."""
        return largest_of(self, column)

    @property
    def work(self) -> float:
        """Work [J] that the indenter did until the contact, or the history, ended."""
        return loop_work(self)

    def times(self, n_points: int) -> Array:
        """Return even times [s], the knots of the history, the turning and the end of the contact."""
        return even_times(self.history, [self.end_time, self.turning_time], n_points)

    @property
    def breaks(self) -> Array:
        """Times [s] between which force and depth are smooth, from first touch to the end of contact or history."""
        last, contact = min(self._past.end, 1.0), self._contact
        ends = [self._past.turning, last]
        starts = self._past.elements.starts, self._recovery.starts
        fastest = float(np.min(1.0 / contact.recoveries[contact.recoveries > 0.0], initial=contact.shortest))
        layers = _behind(np.unique(np.concatenate([contact.knots, ends])), fastest)
        knots = np.unique(np.concatenate([*starts, contact.knots, layers, ends]))
        return self._time(knots[knots <= last])

    @property
    def steps(self) -> list[int]:
        """Places of the steps of the history up to the end of contact."""
        knots = self._contact.knots
        return np.flatnonzero((np.diff(knots) == 0.0) & (knots[:-1] <= self._past.end)).tolist()

    @single_problem()
    def through(self, place: int, fractions: Array) -> tuple[Array, Array]:
        """Depth [m] and force [N] on the way through the step at this place, at fractions of it in [0, 1]."""
        order = np.argsort(fractions)
        columns, work = np.empty((2, fractions.size)), scratch(self._contact.moduli.size)
        through_jump(self._contact, self._past, self._recovery, work, place, fractions[order], columns)
        depth, force = columns[:, np.argsort(order)]
        return depth * self.units.length, force * self.units.force

    @single_problem()
    def at(self, times: ArrayLike, *, before: bool = False) -> tuple[Array, Array, Array, Array]:
        """Return the depth [m], its rate [m/s], force [N] and contact radius [m] at times [s] of the history.

        At a kink or a jump the values behind it, or those before it.
        """
        t = np.atleast_1d(self.history.within(times))
        order = np.argsort(t, kind="stable")
        t, units = t[order], self.units
        early = int(np.searchsorted(t, units.touch, side="right" if before else "left"))
        sampled = np.empty((5, t.size - early))
        inside = np.minimum((t[early:] - units.touch) / units.time, 1.0)
        if before:
            inside = np.nextafter(inside, -math.inf)
        sample(self._contact, self._past, self._recovery, scratch(self._contact.moduli.size), inside, sampled)
        if self._first_rate is not None and not before:
            sampled[1, t[early:] == units.touch] = self._first_rate
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
        """Return the time [s]; at a knot of the history the knot itself, without the rounding of the units."""
        knots = self.history.knots
        if scaled == math.inf:
            return math.inf
        same = np.flatnonzero((knots - self.units.touch) / self.units.time == scaled)
        return float(knots[same[0]]) if same.size else float(self._time(scaled))

    def _time(self, scaled: Any) -> Any:
        # The end of the history, without the rounding of the units.
        return np.minimum(self.units.touch + self.units.time * scaled, self.history.stop)


def _scaled(series: PronySeries, profile: Geometry, history: History, name: str) -> tuple[ScaledContact, Units]:
    """Return dimensionless contact, and its units; the history is prescribed from first touch on."""
    by_depth = name == "depth"
    touch, duration = history.start, history.stop - history.start
    if not SMALLEST < duration < LARGEST:
        rule = f"must last between {SMALLEST:g} and {LARGEST:g} s from first touch on"
        raise InputError("time", duration, rule, "s")
    peak = float(history.coefficients.sum(axis=1).max())
    depth = peak if by_depth else largest_depth(series, profile, peak, duration)
    path, radius, error = path_of(profile, depth)
    moduli, times = series.branch_moduli, series.relaxation_times
    typical = series.equilibrium_modulus + float(moduli @ np.minimum(1.0, times / duration))
    typical += series.parallel_viscosity / duration
    with np.errstate(over="ignore", under="ignore"):
        force = 2.0 * typical * radius * depth
    if not all(SMALLEST < value < LARGEST for value in (depth, radius, force)):
        rule = f"leads to a depth of {depth:.3g} m, a contact radius of {radius:.3g} m and a force of "
        rule += f"{force:.3g} N; each must be in [{SMALLEST:g}, {LARGEST:g}]"
        raise InputError(name, peak, rule, UNITS[name])
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
        # Times since first touch: others have too few digits for knots so close to it.
        history = graded(History(history.knots - touch, history.coefficients))
        touch = 0.0
    knots = (history.knots - touch) / duration
    segments = 0 if by_depth else knots.size - 1
    contact = ScaledContact(
        DEPTH if by_depth else FORCE, knots, history.coefficients / (depth if by_depth else units.force),
        series.equilibrium_modulus / typical, moduli / typical, rates, series.parallel_viscosity / typical / duration,
        float(np.min(1.0 / rates, initial=1.0)), glass, compliances, recoveries,
        allocate(recoveries, segments), allocate(recoveries, segments), path,
    )  # fmt: skip
    return contact, units


def _behind(kinks: Array, fastest: float) -> Array:
    """Return times behind each kink: fast terms relax there, in less than a quadrature sees."""
    starts, widths = kinks[:-1, None], np.diff(kinks)[:, None]
    levels = np.arange(1.0, 2.0 + max(math.log(widths.max() / fastest, 4.0), 0.0))
    layers = widths * 0.25**levels
    return (starts + layers)[layers > 0.1 * fastest]


def _rate_at_touch(contact: ScaledContact, profile: Geometry, part: History, units: Units) -> float | None:
    """Rate of the depth just after first touch under a force; None if the kernel has it, as the radius is not zero.

    With `F = f t^m` and `J = j t^n` there, n = 0 or 1, `Pi = j f t^(m + n)/(m + n)^n`. With a = A s^p and d = s^2 for
    the depth, `d = ((p + 2) Pi/(2 A))^(2/(p + 2))`: its rate is infinite, finite or zero.
    """
    width, coefficients = np.diff(part.knots[:2])[0] / units.time, part.coefficients[0] / units.force
    if width == 0.0:
        m, f = 0, coefficients.sum()
    else:
        # A fitted function has rounding in coefficients that should be zero.
        m = int(np.argmax(np.abs(coefficients) > NO_FORCE * np.abs(coefficients).max()))
        f = coefficients[m] / width**m
    n, j = (0, contact.glass) if contact.glass > 0.0 else (1, float(contact.compliances.sum()))
    order = m + n
    p, radius = path_power(profile, units.length)
    if order == 0 or p == 0.0:
        return None
    if 2.0 * order != p + 2.0:
        return math.inf if 2.0 * order < p + 2.0 else 0.0
    return float((0.5 * (p + 2.0) * j * f / order**n / (radius / units.radius)) ** (2.0 / (p + 2.0)))


def _scaled_retardation(series: PronySeries, units: Units) -> Retardation:
    """Return the creep compliance in units of length radius/force and of the duration."""
    creep = series.retardation
    modulus = 0.5 * units.force / (units.radius * units.length)
    return Retardation(
        creep.instantaneous_compliance * modulus,
        creep.fluidity * modulus * units.time,
        creep.branch_compliances * modulus,
        creep.retardation_times / units.time,
    )
