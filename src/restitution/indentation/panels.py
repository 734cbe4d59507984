"""Solution of a contact with any history by panels of elements, in SI."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property, lru_cache, partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, NDArray

from restitution.checks import Array
from restitution.contact.geometry import depth_of_integral
from restitution.contact.table import path_table, scaled
from restitution.errors import InputError
from restitution.indentation.drive import Drive, Units, driver_of, touch_power
from restitution.indentation.history import NO_FORCE, History, contact_part
from restitution.indentation.merging import merged
from restitution.indentation.solid import in_units, solid_of
from restitution.indentation.surface import (
    Elements,
    Imprint,
    Surface,
    pace_of_step,
    panels_of,
    read_imprint,
    share_of_step,
    write_imprint,
)
from restitution.indentation.work import largest
from restitution.kernel.driver import (
    APART,
    DEPTH,
    DONE,
    ENDS,
    FOLLOWING,
    FREE,
    FREE_PANELS,
    GROWS,
    NO_ROOM,
    PHASE,
    RATE,
    RECORDS,
    TIME,
    TOO_STEEP,
    WORK,
    Problem,
    Room,
    Scales,
    room,
)
from restitution.kernel.indentation import LARGEST, SMALLEST
from restitution.kernel.panels import NODES, Solid, Stack, scheme
from restitution.kernel.path import Path, power_path, table_path
from restitution.kernel.program import run
from restitution.material.prony import PronySeries
from restitution.numerics.quadrature import PLACES, WEIGHTS

if TYPE_CHECKING:
    from restitution.contact.geometry import Contact, Geometry

# Errors of steps add up.
_STEP_SHARE = 0.1
# Errors of panels that are merged, of rtol: above that of a step, which they keep; the next one where many remain.
_MERGE_SHARES, _MANY_PANELS = (0.1, 0.3, 1.0), 32
# Room of the first run; one that is too small costs another run.
_FIRST_PANELS, _FIRST_STEPS, _STEPS_PER_KNOT = 64, 256, 16
# Tolerances of a step, over the usual one, that are tried in turn: rounding meets others differently.
_SHARES = (1.0, 0.5, 0.2, 0.1, 0.03)
# Factors of rtol that are tried for the message of a refusal, and the largest rtol.
_LOOSER, _LOOSEST = (3.0, 10.0, 100.0, 1e4), 1e-3
# Steps of a history, alone and for each knot, behind which it creeps on.
_MOST_STEPS, _MOST_STEPS_PER_KNOT = 1 << 14, 256
# Largest difference of two solutions, over the larger tolerance, where the smaller one needed smaller steps, or has a
# force on a liquid and a tolerance below this one.
_FAR_APART, _FEW_DIGITS = 30.0, 9e-10
# Places in a step at which the search for a largest value starts, and the polynomials there.
_GRID = np.linspace(0.0, 1.0, 65)
_POLYNOMIALS = chebyshev.chebvander(2.0 * _GRID - 1.0, NODES - 1)
# Distance of these places, as x = 2 z - 1, and steps of Newton's method from one of them to the largest value.
_CELL, _MOST_TOPS = 2.0 / 64.0, 8
# Rise by a step of Newton's method, over the largest value, that is the last one.
_LAST_GAIN = 1e-9
# Difference of two times over the duration, below which they are one: the turning point of a fitted function is known
# to about 1e-14.
_SAME_TIME = 1e-12


class Grip(NamedTuple):
    """Contact at the end of a run, dimensionless; another run in the same units goes on from it at time zero."""

    following: Stack
    state: Array
    memory: Array
    sums: Array
    phase: int


def _most_steps(drive: Drive) -> int:
    """Return the number of steps behind which a history creeps on."""
    return _MOST_STEPS + _MOST_STEPS_PER_KNOT * drive.history.knots.size


class PanelSolution:
    """Exact solution of a contact over any history."""

    def __init__(
        self, profile: Geometry, series: PronySeries, drive: Drive, rtol: float, imprint: Imprint | None = None,
        grip: Grip | None = None,
    ) -> None:  # fmt: skip
        self.history, self.by_depth = drive.history, drive.by_depth
        self._profile, self._series, self._drive, self._rtol, self._imprint = profile, series, drive, rtol, imprint
        start, stop = drive.history.start, drive.history.stop
        self.units, self._path, self._solid = _units(profile, series, start, stop - start, drive.peak)
        units = self.units
        exponent = self._path.exponent if self._path.exponent >= 0.0 else 1.0
        size = drive.scale
        area = float(np.asarray(profile.stiffness_radius(size * units.length))) / units.radius
        scales = Scales(size, size * area, size, _STEP_SHARE * rtol)
        power = touch_power(drive, exponent, series.parallel_viscosity)
        self._problem = Problem(
            self._solid, self._path, driver_of(drive, units, series.parallel_viscosity), scheme(), scales, power
        )
        self._room = self._run(drive, imprint, grip)
        self._records = self._passing_records()
        by_smaller = self._problem.scales.tolerance < scales.tolerance and rtol <= _LOOSEST
        has_few = drive.is_force and bool(series.is_liquid) and rtol < _FEW_DIGITS
        if drive.mass == 0.0 and (by_smaller or has_few):
            self._compare(_LOOSER[1] * rtol, has_few)

    def _compare(self, rtol: float, has_few: bool) -> None:
        """Refuse a solution that is far from one by larger steps; with few digits also where there is none.

        Where times have few digits left for the order in which elements leave, errors rise as steps get smaller.
        """
        try:
            other = PanelSolution(self._profile, self._series, self._drive, rtol, self._imprint)
        except InputError:
            if has_few:
                raise
            return
        times = self.node_times.ravel()
        rows = [solution._sample(times, False)[0][[0, 2]] for solution in (self, other)]
        sizes = np.array([[self._drive.scale], [np.abs(rows[1][1]).max()]])
        error = np.max(np.abs(rows[0] - rows[1]) / sizes, axis=0)
        if error.max() > _FAR_APART * rtol:
            raise self._refusal(float(self._time(times[np.argmax(error)])), rtol)

    def _refusal(self, moment: float, rtol: float) -> InputError:
        """Return the refusal of a history that a larger tolerance solves."""
        rule = f"leads to a contact that could not be solved there at rtol = {self._rtol:g}; "
        return InputError("time", moment, rule + f"it can be at rtol = {rtol:.3g}", "s")

    def _run(self, drive: Drive, imprint: Imprint | None, grip: Grip | None) -> Room:
        problem, scales = self._problem, self._problem.scales
        first, moment, returns, is_virgin = DONE, 0.0, False, True
        for share in _SHARES:
            self._problem = problem._replace(scales=scales._replace(tolerance=share * scales.tolerance))
            outcome, work = self._attempt(drive, imprint, grip)
            if outcome in (DONE, APART):
                return work
            if share == 1.0:
                first, moment = outcome, self.units.touch + self.units.time * float(work.state[TIME])
                is_virgin = int(work.places[FREE_PANELS]) == 0
                returns = not is_virgin and int(work.places[PHASE]) == GROWS
            if outcome == NO_ROOM:
                break
        if drive.mass == 0.0:
            # Where more rounding counts as such, there may be a solution.
            for factor in _LOOSER:
                rtol = factor * self._rtol
                self._problem = problem._replace(scales=scales._replace(tolerance=factor * scales.tolerance))
                if rtol <= _LOOSEST and self._attempt(drive, imprint, grip)[0] in (DONE, APART):
                    raise self._refusal(moment, rtol)
        if first == NO_ROOM:
            raise InputError(
                "history", rule=f"needs over {_most_steps(drive)} steps; smooth or thin it, or loosen rtol"
            )
        rule = "leads to a contact that could not be solved there"
        if problem.driver.backward.size and returns:
            rule = "leads to a contact on an imprint that could not be solved there; "
            rule += "prescribe a depth, or the base of a spring"
        elif first == TOO_STEEP and is_virgin and drive.mass == 0.0:
            rule = "rises too steeply there for the digits of its times; smooth it"
        raise InputError("time", moment, rule, "s")

    def _attempt(self, drive: Drive, imprint: Imprint | None, grip: Grip | None) -> tuple[int, Room]:
        """Return the outcome of a run, and its room, which grows until it is large enough."""
        pieces, most = drive.history.knots.size, _most_steps(drive)
        panels, steps = _FIRST_PANELS + pieces, min(_FIRST_STEPS + _STEPS_PER_KNOT * pieces, most)
        if imprint is not None:
            panels += imprint.end.size
        if grip is not None:
            panels += grip.following.end.size
        while True:
            work = room(self._solid, panels, steps, drive.swing.shape[0])
            if imprint is not None:
                write_imprint(work.free, imprint, self.units.length, self.units.time)
                work.places[FREE_PANELS] = imprint.end.size
            work.state[DEPTH] = drive.first_depth / self.units.length
            work.state[RATE] = drive.velocity * self.units.time / self.units.length
            work.swing[:] = drive.swing / self.units.length * np.array([1.0, self.units.time])
            if grip is not None:
                _write_grip(self._problem, work, grip)
            start = np.array([float(drive.touches), 0.0, drive.first / self.units.time])
            outcome = int(run(self._problem, work, start, most))
            if outcome != NO_ROOM or steps == most:
                return outcome, work
            panels, steps = 4 * panels, min(4 * steps, most)

    def _passing_records(self) -> tuple[Array, Array, NDArray[np.int64], NDArray[np.intp]]:
        """Return starts, lengths and maps of the steps that take time, and their places."""
        records, size = self._room.records, int(self._room.places[RECORDS])
        places = np.flatnonzero(records.length[:size] > 0.0)
        return records.start[places], records.length[places], records.kind[places], places

    # Steps.

    @property
    def solid(self) -> Solid:
        """Modulus of the material, dimensionless."""
        return self._solid

    @property
    def pieces(self) -> tuple[Array, Array, NDArray[np.int64]]:
        """Starts, lengths and maps of the steps, over the unit of time."""
        return self._records[:3]

    @property
    def node_times(self) -> Array:
        """Times of the nodes of the steps, over the unit of time, (R, N)."""
        starts, lengths, kinds, _ = self._records
        places = np.broadcast_to(scheme().c, (starts.size, NODES))
        times: Array = starts[:, None] + lengths[:, None] * share_of_step(kinds, places)
        return times

    def scaled_depth(self, times: Array) -> Array:
        """Return depths at times, both over their units."""
        return self._sample(times.ravel(), False)[0][0].reshape(times.shape)

    # Times and events.

    def _time(self, scaled: Array | float) -> Array:
        # The end of the history, without the rounding of the units.
        return np.minimum(self.units.touch + self.units.time * np.asarray(scaled), self.history.stop)

    @cached_property
    def contact_intervals(self) -> Array:
        """Times [s] at which contacts begin and end, shape (n, 2); the last end is infinite if it is not reached."""
        # A touch or an end at a knot belongs to no step, so that phases count beside events.
        records, size = self._room.records, int(self._room.places[RECORDS])
        touches, parts = records.phase[:size] != FREE, records.event[:size] == ENDS
        first = touches & np.append(True, ~touches[:-1] | parts[:-1])[:size]
        # So does the end of a run whose last elements left at once.
        free = self._room.places[PHASE] == FREE
        last = touches & (parts | np.append(~touches[1:], free)[:size])
        starts = records.start[:size]
        stops = np.append(starts[1:], self._room.state[TIME])[:size]
        begins, ends = self._time(starts[first]), self._time(stops[last])
        return np.column_stack([begins, np.append(ends, np.full(begins.size - ends.size, math.inf))])

    @cached_property
    def turning_times(self) -> Array:
        """Times [s] at which the contact changes between growth and shrinkage."""
        records, size = self._room.records, int(self._room.places[RECORDS])
        phase = records.phase[:size]
        turns = np.flatnonzero((phase[1:] != phase[:-1]) & (phase[1:] != FREE) & (phase[:-1] != FREE))
        return self._time(records.start[turns + 1])

    @property
    def breaks(self) -> Array:
        """Times [s] between which depth and force are smooth."""
        starts, lengths, _, _ = self._records
        return np.unique(self._time(np.append(starts, starts[-1] + lengths[-1])))

    @property
    def stop(self) -> float:
        """Time [s] at which the run ended."""
        return float(self._time(float(self._room.state[TIME])))

    @property
    def touches_at_end(self) -> bool:
        """Whether there is contact at the end of the run."""
        return int(self._room.places[PHASE]) != FREE

    @property
    def end_time(self) -> float:
        """Time [s] at which the last contact ends; infinite if it outlasts the history."""
        return float(self.contact_intervals[-1, 1])

    def _ends_of_steps(self, row: int) -> Array:
        """Return a row of the records at the end of each step, jumps as well; 0 without contact."""
        records, size = self._room.records, int(self._room.places[RECORDS])
        return np.where(records.phase[:size] != FREE, records.columns[:size, row] @ np.ones(NODES), 0.0)

    @property
    def turning_time(self) -> float:
        """Time [s] at which the contact is largest."""
        records, n = self._room.records, int(np.argmax(self._ends_of_steps(3)))
        return float(self._time(records.start[n] + records.length[n]))

    @property
    def max_contact_radius(self) -> float:
        """Largest contact radius [m], which is that at the end of a step."""
        y = float(np.max(self._ends_of_steps(3)))
        return float(self._profile.contact_radius(y * y * self.units.length)) if self.contact_intervals.size else 0.0

    @property
    def max_depth(self) -> float:
        """Largest depth [m] in contact at the end of a step."""
        return float(np.max(self._ends_of_steps(0), initial=0.0)) * self.units.length

    def largest(self, column: int) -> float:
        """Return the largest depth [m], column 0 of `at`, or force [N], column 2; both are polynomials in a step."""
        rows = self._room.records.columns[self._records[3], column]
        values = rows @ _POLYNOMIALS.T
        step, place = divmod(int(np.argmax(values)), _GRID.size)
        best = _top(rows[step], values[step], place)
        # The largest value near an end of a step may be in the step beside it.
        if place == _GRID.size - 1 and step + 1 < rows.shape[0]:
            best = max(best, _top(rows[step + 1], values[step + 1], 0))
        if place == 0 and step > 0:
            best = max(best, _top(rows[step - 1], values[step - 1], _GRID.size - 1))
        return best * (self.units.length if column == 0 else self.units.force)

    def times(self, n_points: int) -> Array:
        """Return even times [s], the knots of the history, turnings, and both ends of each contact."""
        return even_times(self.history, [*self.contact_intervals.ravel(), *self.turning_times], n_points)

    # Values over time.

    def at(self, times: ArrayLike, *, before: bool = False) -> tuple[Array, Array, Array, Array]:
        """Return the depth [m], its rate [m/s], force [N] and contact radius [m] at times [s] of the history.

        At a kink or a jump the values behind it, or those before it.
        """
        t = np.atleast_1d(self.history.within(times))
        units = self.units
        (depth, rate, force, y, *_), touches = self._sample((t - units.touch) / units.time, before)
        radius = np.where(touches, self._profile.contact_radius(y**2 * units.length), 0.0)
        if self._drive.attraction == 0.0:
            # A force near zero may have either sign by rounding; the theory has no adhesion.
            force = np.maximum(force, 0.0)
        return depth * units.length, rate * units.length / units.time, force * units.force, radius

    def _sample(self, times: Array, before: bool) -> tuple[Array, NDArray[np.bool_]]:
        """Return scaled depth, rate, force, y and depths of higher modes, (4 + M, n), and whether there is contact."""
        records = self._room.records
        starts, lengths, kinds, places = self._records
        side = "left" if before else "right"
        n = np.clip(np.searchsorted(starts, times, side=side) - 1, 0, starts.size - 1)
        passed, kind = np.clip((times - starts[n]) / lengths[n], 0.0, 1.0), kinds[n]
        power = 1.0 / np.abs(kind)
        z = np.where(kind > 0, passed**power, 1.0 - (1.0 - passed) ** power)
        basis = chebyshev.chebvander(2.0 * z - 1.0, NODES - 1)
        values = np.einsum("nqk,nk->qn", records.columns[places[n]], basis)
        return values, records.phase[places[n]] != FREE

    def quadrature(self) -> tuple[Array, Array, Array]:
        """Return times [s], weights [s], and depth [m], rate [m/s], force [N], shape (3, n), for integrals.

        Further rows are the depths of higher modes.
        """
        starts, lengths, kinds, places = self._records
        z = PLACES[None]
        basis = chebyshev.chebvander(2.0 * PLACES - 1.0, NODES - 1)
        units = self.units
        count = self._room.swing.shape[0]
        sizes = np.array([units.length, units.length / units.time, units.force, *[units.length] * count])
        rows = [0, 1, 2, *range(4, 4 + count)]
        columns = self._room.records.columns[places][:, rows] @ basis.T * sizes[:, None]
        times = units.touch + units.time * (starts[:, None] + lengths[:, None] * share_of_step(kinds, z))
        weights = units.time * lengths[:, None] * pace_of_step(kinds, z) * WEIGHTS
        return times.ravel(), weights.ravel(), np.moveaxis(columns, 1, 0).reshape(len(rows), -1)

    # Energy and surface at the end.

    @property
    def end_state(self) -> tuple[float, float]:
        """Depth [m] and its rate [m/s] at the end of the history."""
        state, units = self._room.state, self.units
        return float(state[DEPTH]) * units.length, float(state[RATE]) * units.length / units.time

    @property
    def swing(self) -> Array:
        """Depths [m] and velocities [m/s] of higher modes at the end of the history, shape (M, 2)."""
        return self._room.swing * self.units.length / np.array([1.0, self.units.time])

    @property
    def swings(self) -> Array:
        """Half of the way [m] of the mass and of each higher mode between their ends."""

        def way(mode: int, sign: float, times: Array) -> Array:
            depth, higher = (rows := self._sample(times, False)[0])[0], rows[4:]
            return sign * (higher[mode - 1] if mode > 0 else depth - higher.sum(axis=0))

        starts, lengths, _, _ = self._records
        breaks, modes = np.append(starts, starts[-1] + lengths[-1]), range(1 + self._room.swing.shape[0])
        ways = [sum(largest(partial(way, mode, sign), breaks) for sign in (-1.0, 1.0)) for mode in modes]
        return 0.5 * np.array(ways) * self.units.length

    @property
    def work(self) -> float:
        """Work [J] that the body did on the surface until the end of the history."""
        return float(self._room.state[WORK]) * self.units.force * self.units.length

    @cached_property
    def elements(self) -> Elements:
        """All elements at the end of the history."""
        work, units = self._room, self.units
        following = panels_of(work.following, int(work.places[FOLLOWING]), True)
        free = panels_of(work.free, int(work.places[FREE_PANELS]), False)
        return Elements(
            self._profile, self._solid, following, free, units.length, units.radius,
            units.force * units.length, float(work.state[TIME]), float(work.state[DEPTH]), work.memory,
        )  # fmt: skip

    def surface(self, contact: Contact) -> Surface:
        """Return the surface at the end of the history; refuse one in contact."""
        if self._room.places[FOLLOWING] > 0:
            rule = "must end without contact for a surface; let the body retract, or prescribe a force of zero"
            raise InputError("history", rule=rule)
        return Surface(contact, 0.0, self._series, self.imprint)

    @property
    def imprint(self) -> Imprint:
        """Free surface at the end of the history, around a contact or not."""
        work, units = self._room, self.units
        now, count = float(work.state[TIME]), int(work.places[FREE_PANELS])
        marks = read_imprint(work.free, count, now, units.length, units.time)
        if work.places[FOLLOWING] > 0:
            # At the edge of a contact the gap has a double zero, which a merged panel would move.
            count = int(np.count_nonzero(work.free.start[:count] < 0.0))
        scale = self._rtol * self._drive.scale * units.length
        fewer, rest = marks, marks.end.size - count
        # Steps leave errors of fronts, which no smooth panel has: many panels are merged with a larger tolerance.
        for share in _MERGE_SHARES:
            if fewer is not marks and fewer.end.size - rest <= _MANY_PANELS:
                break
            fewer = merged(marks, count, self._solid.recoveries / units.time, share * scale)
        return fewer

    @property
    def grip(self) -> Grip | None:
        """Contact at the end of the history; None without one."""
        work = self._room
        count = int(work.places[FOLLOWING])
        if count == 0:
            return None
        following = Stack(*(part[:count].copy() for part in work.following))
        state = work.state.copy()
        following.start[:] -= state[TIME]
        state[[TIME, WORK]] = 0.0
        return Grip(following, state, work.memory.copy(), work.sums.copy(), int(work.places[PHASE]))

    def until(self, time: float) -> PanelSolution:
        """Return the solution of the same history up to a time [s]."""
        start, stop = self.history.start, self.history.stop
        if not start < time <= stop:
            raise InputError("time", time, f"must be in ({start:g}, {stop:g}] s, where the history is given", "s")
        if time == stop:
            return self
        drive = self._drive._replace(history=self.history.until(time))
        return PanelSolution(self._profile, self._series, drive, self._rtol, self._imprint)

    @property
    def panels(self) -> PanelSolution:
        """The solution itself, which is by panels."""
        return self


def _top(row: Array, values: Array, place: int) -> float:
    """Return the largest value next to a place of the grid of a polynomial, of Chebyshev coefficients, by Newton."""
    coefficients, best = row.tolist(), float(values[place])
    low, high = max(place - 1, 0), min(place + 1, _GRID.size - 1)
    before, here, behind = (float(values[n]) for n in (low, place, high))
    # Of a parabola through three values.
    bend = before - 2.0 * here + behind
    x = 2.0 * float(_GRID[place]) - 1.0
    low, high = max(x - _CELL, -1.0), min(x + _CELL, 1.0)
    if low < x - 0.5 * _CELL and x + 0.5 * _CELL < high and bend < 0.0:
        x += 0.5 * _CELL * (before - behind) / bend
    for _ in range(_MOST_TOPS):
        T, slopes, bends = (1.0, x), (0.0, 1.0), (0.0, 0.0)
        value, slope, bend = coefficients[0] + coefficients[1] * x, coefficients[1], 0.0
        for c in coefficients[2:]:
            bends = bends[1], 2.0 * x * bends[1] - bends[0] + 4.0 * slopes[1]
            slopes = slopes[1], 2.0 * x * slopes[1] - slopes[0] + 2.0 * T[1]
            T = T[1], 2.0 * x * T[1] - T[0]
            value, slope, bend = value + c * T[1], slope + c * slopes[1], bend + c * bends[1]
        best = max(best, value)
        gain = -0.5 * slope * slope / bend if bend < 0.0 else 0.0
        target = x - slope / bend if bend < 0.0 else x
        if gain <= _LAST_GAIN * abs(value):
            # What a further step would leave is smaller by the same factor.
            return max(best, value + gain) if low <= target <= high else best
        if value + gain <= best:
            break
        x = min(max(target, low), high)
    return best


def _write_grip(problem: Problem, work: Room, grip: Grip) -> None:
    """Let a run go on from a contact, as at a smooth knot."""
    problem.driver.smooth[0] = True
    count = grip.following.end.size
    for part, values in zip(work.following, grip.following, strict=True):
        part[:count] = values
    work.state[:], work.memory[:], work.sums[:] = grip.state, grip.memory, grip.sums
    work.places[FOLLOWING], work.places[PHASE] = count, grip.phase


def solve_by_panels(
    profile: Geometry, series: PronySeries, history: History, name: str, rtol: float, stiffness: float | None = None,
    surface: Surface | None = None,
) -> PanelSolution:  # fmt: skip
    """Return the solution under a depth, a force, or the depth of the base of a spring [N/m]."""
    deepest = float(np.min(profile.max_depth))
    peak, field = float(history.coefficients.sum(axis=1).max()), name
    level = 0.0 if surface is None else surface.depth
    if name == "force":
        contact_part(history, name)
        bound = largest_depth(series, profile, peak, history.stop - history.start) + level
        drive = Drive(history, False, bound, touch=path_power(profile, bound)[0] + 2.0, depth=level)
    else:
        first = float(history.coefficients[0, 0])
        if first - level > NO_FORCE * peak:
            rule = f"must be <= {level:g} m at the start, where the surface is: a history begins without contact"
            raise InputError("depth", first, rule, "m")
        if peak <= level:
            raise InputError("depth", peak, f"must rise above {level:g} m; the bodies do not touch", "m")
        drive = Drive(history, True, peak)
        if stiffness is None:
            check_depth(history, profile, series.parallel_viscosity)
        else:
            pull = History(history.knots, history.coefficients * stiffness)
            # A soft spring does not press the tip as deep as it moves.
            most = largest_depth(series, profile, stiffness * peak, history.stop - history.start) + level
            bound = min(peak, deepest, most)
            touch = path_power(profile, bound)[0] + 2.0 if series.parallel_viscosity > 0.0 else 2.0
            drive = Drive(pull, False, bound, stiffness=stiffness, touch=touch)
    solution = PanelSolution(profile, series, drive, rtol, None if surface is None else surface.marks)
    if not solution.contact_intervals.size:
        raise InputError(field, rule="does not bring the bodies into contact")
    if solution.max_depth > deepest:
        raise InputError(field, rule=f"must not press the tip deeper than {deepest:g} m, {profile.end}")
    return solution


def check_depth(part: History, profile: Geometry, dashpot: float) -> None:
    """Refuse a depth beyond the end of the profile, and a step in contact with a parallel dashpot."""
    most, deepest = float(part.coefficients.sum(axis=1).max()), float(np.min(profile.max_depth))
    if most > deepest:
        raise InputError("depth", most, f"must be <= {deepest:g} m, {profile.end}", "m")
    # No surface is above the undeformed one.
    lower = (part.coefficients[:, 0] <= 0.0) & (part.coefficients.sum(axis=1) <= 0.0)
    jumps = part.knots[:-1][(np.diff(part.knots) == 0.0) & ~lower]
    if dashpot > 0.0 and jumps.size:
        rule = f"must not jump, as at time = {jumps[0]:g} s: a dashpot in parallel makes the force infinite"
        raise InputError("depth", rule=rule)


def largest_depth(series: PronySeries, profile: Geometry, force: float, duration: float) -> float:
    """Bound of the depth [m] that a force [N] held for a time [s] reaches: that of the creep compliance."""
    depth = float(depth_of_integral(profile, 0.5 * force * series.creep_compliance(duration)))
    # An elastic body reaches the bound, with its own rounding.
    return depth if profile.path_exponent is not None else min((1.0 + 1e-12) * depth, float(profile.max_depth))


def path_power(profile: Geometry, depth: float) -> tuple[float, float]:
    """Return p and A [m] of a = A (d/depth)^(p/2) near first touch."""
    radii = np.asarray(profile.stiffness_radius(depth * np.array([1e-16, 4e-16])))
    p = round(float(np.log2(radii[1] / radii[0])), 3)
    return p, float(radii[0]) / 1e-8**p


def path_of(profile: Geometry, depth: float) -> tuple[Path, float, float]:
    """Return the path in units of the depth, the stiffness radius there [m], and the error of the table."""
    radius = float(profile.stiffness_radius(depth))
    if profile.path_exponent is not None:
        return power_path(float(profile.path_exponent)), radius, 0.0
    table = path_table(profile, depth)
    return table_path(scaled(table, depth, radius)), radius, table.error


def even_times(history: History, further: Sequence[float], n_points: int) -> Array:
    """Return even times [s], the knots of a history, and further times, without those that differ by rounding."""
    start, stop = history.start, history.stop
    times = np.unique(history.knots)
    same = max(_SAME_TIME * (stop - start), 4.0 * float(np.spacing(max(abs(start), abs(stop)))))
    inner = np.array([time for time in further if start <= time <= stop])
    for more in (inner, np.linspace(start, stop, n_points)):
        place = np.searchsorted(times, more)
        before, behind = times[np.maximum(place - 1, 0)], times[np.minimum(place, times.size - 1)]
        alone = np.minimum(np.abs(more - before), np.abs(behind - more)) > same
        times = np.unique(np.concatenate([times, more[alone]]))
    return times


# Taps are many short histories of one duration.
@lru_cache(maxsize=32)
def _units(
    profile: Geometry, series: PronySeries, start: float, duration: float, peak: float
) -> tuple[Units, Path, Solid]:  # fmt: skip
    """Return the units of a contact, and its path and its modulus in them."""
    if not SMALLEST < duration < LARGEST:
        raise InputError("time", duration, f"must last between {SMALLEST:g} and {LARGEST:g} s", "s")
    solid = solid_of(series)
    typical = solid.equilibrium + float(solid.moduli @ np.minimum(1.0, 1.0 / (solid.rates * duration)))
    typical += solid.viscosity / duration
    path, radius, error = path_of(profile, peak)
    with np.errstate(over="ignore", under="ignore"):
        force = 2.0 * typical * radius * peak
    if not all(SMALLEST < value < LARGEST for value in (peak, radius, force)):
        rule = f"leads to a depth of {peak:.3g} m, a contact radius of {radius:.3g} m and a force of "
        raise InputError("history", rule=rule + f"{force:.3g} N; each must be in [{SMALLEST:g}, {LARGEST:g}]")
    return Units(start, duration, peak, radius, force, error), path, in_units(solid, typical, duration)
