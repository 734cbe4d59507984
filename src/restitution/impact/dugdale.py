"""Impact of one adhesive body: marches with more and more elements until the extrapolated result is known."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from restitution.impact.status import Status
from restitution.indentation.attraction import FILLED, ROOM, SPARE, UNLOADED, WIDER, Load, March, Sticky, peak
from restitution.numerics.richardson import Richardson

# Elements of the march that finds the scales.
_SCALING = 64
# Tolerance from which the first march may have half as many elements.
_LOOSE = 1e-4
# Tolerance below which errors are these multiples of the change of the extrapolated numbers: of the first one alone,
# which may be small by chance, and of later ones. By comparison of 155 random impacts with finer marches.
_STRICT, _OF_FIRST, _OF_LATER = 1e-5, 2.0, 0.5
# Largest number of trials for the scales, and of scales, and factor of a duration that was too short.
_TRIALS, _WIDENED, _LONGER = 120, 8, 4.0
# Marches in a row that must capture the body, or not end, before this is believed: a coarse one may hold a body that
# a finer one lets go.
_SURE = 4
# Error of e over the creep of an unresolved ring and the loss in jumps, by comparison with finer marches.
_CREEP = 5.0
# Below this e its error may be larger, as it is the root of what is computed.
_SLOW = 0.1
# Doublings of the velocity in search of one that sticks, share by which a bracket widens and how often it may, width
# over the tolerance.
_OCTAVES, _SPREAD, _SPREADS, _FINE = 20, 0.05, 100, 0.05

NUMBERS: tuple[str, ...] = (
    "energy", "contact_time", "max_indentation_depth", "max_force", "max_contact_radius", "residual_indentation_depth",
    "dissipated_energy", "radiated_energy", "stored_energy", "pull_off_force", "touching_time",
)  # fmt: skip
"""Numbers of a march: rebound over impact energy, then those of `restitution.quantities` in SI."""


class Problem(NamedTuple):
    """One adhesive impact in SI."""

    body: Sticky
    mass: float
    velocity: float
    load: Load = UNLOADED

    def march(self, width: float, time: float, count: int, *, bends: bool = False, graded: bool = False) -> March:
        """March with elements `width/count` apart and steps of at most `time/count`, up to the last attraction.

        See `Sticky.march`, which goes on until the body is faster than the surface may follow.
        """
        march = self.body.march(
            width, time, count, mass=self.mass, velocity=self.velocity, load=self.load, bends=bends, graded=graded
        )
        attracted = np.flatnonzero(march.motion[:, 4] > 0.0)
        free = march.motion[attracted[-1] + 1 :] if attracted.size else march.motion[:0]
        if len(free) < 2:
            return march
        _, _, speed, *_, viscous, _ = free.T
        left = march.left + float(viscous[-1] - viscous[0] + 0.5 * self.mass * (speed[0] ** 2 - speed[-1] ** 2))
        return march._replace(motion=march.motion[: 1 - len(free)], left=left)


class Solved(NamedTuple):
    """Extrapolated numbers with the finest march, and the error of e, also where it is above the tolerance."""

    status: Status
    numbers: dict[str, float]
    march: March | None
    error: float


def solve_adhesive(problem: Problem, rtol: float) -> Solved:
    """Return the impact with e, and the loss in jumps over the energy of the impact, known to `rtol`, or a status."""
    from restitution.kernel.zone import NO_ROOM, TOO_LONG

    width, time = scales(problem)
    for _ in range(_WIDENED):
        if not math.isfinite(width):
            break
        solved = _refined(problem, width, time, rtol)
        end = None if solved.march is None else solved.march.end
        if end == NO_ROOM:
            # A coarse march may hold a body that a finer one lets go deeper.
            width = _wider(problem, width)
        elif end == TOO_LONG:
            time *= _LONGER
        else:
            return solved
    return _failed(Status.TOO_DEEP if width == math.inf else Status.TOO_MANY_STEPS)


def _failed(status: Status, march: March | None = None, error: float = math.nan) -> Solved:
    return Solved(status, dict.fromkeys(NUMBERS, math.nan), march, error)


def _refined(problem: Problem, width: float, time: float, rtol: float) -> Solved:
    """March with more and more elements on one scale until e is known, or a march does not end."""
    from restitution.kernel.zone import HELD, SEPARATED, TOO_LONG

    count, most = problem.body.counts(width, time)
    most = max(most, problem.body.affordable(width))
    if rtol >= _LOOSE:
        count //= 2
    bends = problem.body.resolves(width, count)
    held, endless, done, series, reached = 0, 0, 0, Richardson(), math.nan
    kinetic, before = 0.5 * problem.mass * problem.velocity**2, None
    while count <= most:
        march = problem.march(width, time, count, bends=bends, graded=True)
        endless = endless + 1 if march.end == TOO_LONG else 0
        if endless >= _SURE or (endless and 2 * count > most) or march.end not in (HELD, SEPARATED, TOO_LONG):
            return _failed(Status.NOT_ACCURATE, march)
        if march.end != SEPARATED:
            held, done, series, reached = held + (march.end == HELD), 0, Richardson(), math.nan
            if held >= _SURE:
                numbers = _numbers(problem, march)
                numbers["energy"] = 0.0
                return Solved(Status.CAPTURED, numbers, march, 0.0)
        else:
            held, done = 0, done + 1
            (energy, radiated), errors = (each.tolist() for each in series.add(_energies(problem, march)))
            if rtol < _STRICT:
                errors = [part * (_OF_LATER if done > 3 else _OF_FIRST) for part in errors]
            error = _error_of_e(energy, errors[0])
            # The loss in jumps has an error of its own, which that of e does not show.
            lost = errors[1] / kinetic
            # Creep of an unresolved ring acts as another work of adhesion, and jumps have the scale of its effect.
            share = radiated / (2.0 * kinetic * math.sqrt(max(energy, _SLOW**2)))
            error = max(error, _CREEP * share * problem.body.transit(width, time, count))
            reached = max(error, lost)
            if energy > 0.0 and error <= rtol * max(1.0, _SLOW / math.sqrt(energy)) and lost <= rtol:
                return Solved(Status.SEPARATED, _extrapolated(problem, before or march, march), march, error)
        before = march
        count *= 2
    return _failed(Status.NOT_ACCURATE, error=reached)


def _extrapolated(problem: Problem, rough: March, fine: March) -> dict[str, float]:
    """Return `NUMBERS` extrapolated from two marches, the second with twice as many elements."""
    first, second = _numbers(problem, rough), _numbers(problem, fine)
    return {name: (4.0 * second[name] - first[name]) / 3.0 for name in NUMBERS}


def _widest(problem: Problem) -> float:
    """Return the largest zone [m] whose elements end before the profile does, where its slope may be infinite."""
    return 0.99 * float(np.asarray(problem.body.profile.max_contact_radius)) / (ROOM + 0.1)


def _wider(problem: Problem, width: float) -> float:
    """Return the next larger zone [m]; infinite beyond the profile."""
    widest = _widest(problem)
    return math.inf if width >= widest else min(WIDER * width, widest)


def _error_of_e(energy: float, error: float) -> float:
    """Return the error of e from that of e^2."""
    return error / (math.sqrt(max(energy, 0.0)) + math.sqrt(max(energy - error, 0.0)) + 1e-300)


def scales(problem: Problem) -> tuple[float, float]:
    """Return the largest radius [m] of the zone and the duration [s]; infinite where the profile ends before."""
    from restitution.kernel.zone import NO_ROOM, TOO_LONG

    width = min(first_width(problem), _widest(problem))
    body = problem.body
    way = float(body.profile.transform(width) + np.asarray(body.adhesion.range))
    time = 4.0 * way / math.hypot(problem.velocity, math.sqrt(2.0 * problem.load.force * way / problem.mass))
    for _ in range(_TRIALS):
        march = problem.march(width, time, _SCALING)
        if march.end == NO_ROOM:
            width = _wider(problem, width)
            if width == math.inf:
                return width, time
        elif march.end == TOO_LONG:
            time *= _LONGER
        elif march.widest < FILLED * width:
            width = max(SPARE * march.widest, 0.1 * width)
            time = min(time, _LONGER * march.duration or time)
        else:
            # A body may be held at the instant of its jump into contact.
            return min(SPARE * march.widest, _widest(problem)), march.duration or time
    return math.nan, time


def first_width(problem: Problem) -> float:
    """Return a contact radius [m] at which the elastic energy is that of the body and of the attraction."""
    body = problem.body
    stiff, work = float(body.modulus.instantaneous_modulus), float(np.asarray(body.adhesion.work))
    kinetic, force = 0.5 * problem.mass * problem.velocity**2, problem.load.force
    reach = float(np.asarray(body.adhesion.range))

    def holds(width: float) -> bool:
        depth = float(body.profile.transform(width))
        return stiff * depth**2 * width < kinetic + work * math.pi * width**2 + force * (depth + reach)

    width = reach
    while not holds(width):
        width /= WIDER
    while holds(width):
        width *= WIDER
    return width


def _energies(problem: Problem, march: March) -> tuple[float, float]:
    """Return rebound over impact energy of a march, and its loss in jumps."""
    return float(march.motion[-1, 2] / problem.velocity) ** 2, float(march.motion[-1, 7])


def _numbers(problem: Problem, march: March) -> dict[str, float]:
    """Return `NUMBERS` of a march."""
    time, depth, speed, force, _, radius, viscous, lost = march.motion.T
    kinetic = 0.5 * problem.mass * problem.velocity**2
    out = 0.5 * problem.mass * float(speed[-1]) ** 2
    touching = np.flatnonzero(radius > 0.0)
    touch = float(time[touching[-1]] - time[touching[0]]) if touching.size else 0.0
    net = force - problem.load.force
    turn = np.flatnonzero((speed[:-1] > 0.0) & (speed[1:] <= 0.0) & (net[:-1] > 0.0))
    deepest = float(depth.max())
    if turn.size:
        n = int(turn[0])
        deepest = max(deepest, float(depth[n]) + 0.5 * problem.mass * float(speed[n]) ** 2 / float(net[n]))
    return {
        "energy": out / kinetic, "contact_time": float(time[-1]), "max_indentation_depth": deepest,
        "max_force": max(peak(march.motion, force)[0], 0.0), "max_contact_radius": peak(march.motion, radius)[0],
        "residual_indentation_depth": float(depth[-1]), "dissipated_energy": float(viscous[-1]),
        "radiated_energy": float(lost[-1]), "stored_energy": march.left - out,
        "pull_off_force": max(peak(march.motion, -force)[0], 0.0), "touching_time": touch,
    }  # fmt: skip


def sticking(problem: Problem, rtol: float) -> tuple[float, float]:
    """Return the velocity [m/s] at which bodies begin to stick, and its error over it; NaN if none is found.

    The bracket of capture and rebound nearest to the velocity of the problem is halved with N elements, then with 2N
    and so on, and the velocity is extrapolated.
    """
    low, high = _bracket(problem)
    if not high > 0.0:
        return math.nan, math.inf
    width, time = scales(problem._replace(velocity=high))
    if not math.isfinite(width):
        return math.nan, math.inf
    fewest, most = problem.body.counts(width, time)
    count, last, series = fewest, math.nan, Richardson()
    while count <= most:
        escapes = partial(_escapes, problem, width=width, time=time, count=count)
        low, high = _widened(escapes, low, high)
        if math.isnan(high):
            break
        while high - low > _FINE * rtol * high:
            middle = 0.5 * (low + high)
            low, high = (low, middle) if escapes(middle) else (middle, high)
        after, error = (float(each) for each in series.add(high))
        # One change may be small by chance, and a bracket has an error of its own.
        if count > 4 * fewest and error <= rtol * after:
            return after, error / after
        spread = 4.0 * abs(high - last) / high if math.isfinite(last) else _SPREAD
        last = high
        low, high = high * (1.0 - spread - rtol), high * (1.0 + spread + rtol)
        count *= 2
    return math.nan, math.inf


def _widened(escapes: Callable[[float], bool], low: float, high: float) -> tuple[float, float]:
    """Return a bracket whose lower velocity sticks and whose upper one does not, NaN if there is none near."""
    for _ in range(_SPREADS):
        up, down = escapes(high), escapes(low)
        if up and not down:
            return low, high
        low, high = low / (1.0 + _SPREAD) if down else low, high if up else high * (1.0 + _SPREAD)
    return math.nan, math.nan


def _escapes(problem: Problem, velocity: float, width: float, time: float, count: int) -> bool:
    from restitution.kernel.zone import NO_ROOM, SEPARATED

    end = problem._replace(velocity=velocity).march(width, time, count).end
    return end in (SEPARATED, NO_ROOM)


def _bracket(problem: Problem) -> tuple[float, float]:
    """Return velocities within a tenth of each other; the lower one sticks. Zeros if none is found."""

    def escapes(velocity: float) -> bool:
        width, time = scales(problem._replace(velocity=velocity))
        if not math.isfinite(width):
            return True
        return _escapes(problem, velocity, width, time, problem.body.counts(width, time)[0])

    start = problem.velocity
    up = not escapes(start)
    low = high = start
    for _ in range(_OCTAVES):
        if up:
            low, high = high, 2.0 * high
            if escapes(high):
                break
        else:
            low, high = 0.5 * low, low
            if not escapes(low):
                break
    else:
        return 0.0, 0.0
    while high > 1.1 * low:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if escapes(middle) else (middle, high)
    return low, high
