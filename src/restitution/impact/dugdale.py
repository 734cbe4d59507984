"""Impact of one adhesive body: marches with more and more elements until the extrapolated result is known."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from restitution.checks import Array
from restitution.contact.adhesion import Adhesion
from restitution.contact.profiles import Profile
from restitution.impact.status import Status
from restitution.indentation.solid import compliance_of
from restitution.material.prony import PronySeries

# Elements of the first march that counts, and of the finest; those of the march that finds the scales.
FEWEST, MOST, _SCALING = 100, 6400, 64
# Room beyond the largest zone, steps for each element, and jumps that are kept.
_ROOM, _STEPS, _JUMPS = 1.3, 24, 64
# Largest number of trials for the scales, and of scales, and factors of a zone and a duration that were too small.
_TRIALS, _WIDENED, _WIDER, _LONGER = 120, 8, 1.6, 4.0
# Share of the room that the largest zone takes at least.
_FILLED = 0.6
# The error of an extrapolated result is its last change, or this share of the change before.
_BEFORE = 0.25
# Marches in a row that must capture the body.
_SURE = 4
_HALVINGS = 60
# Below this e its error may be larger, as it is the root of what is computed.
_SLOW = 0.1
# Doublings of the velocity in search of one that sticks, share by which a bracket widens, width over the tolerance.
_OCTAVES, _SPREAD, _FINE = 20, 0.05, 0.05

NUMBERS = (
    "energy", "contact_time", "max_indentation_depth", "max_force", "max_contact_radius", "residual_indentation_depth",
    "dissipated_energy", "radiated_energy", "stored_energy", "pull_off_force", "touching_time",
)  # fmt: skip
"""Numbers of a march: rebound over impact energy, then those of `restitution.quantities` in SI."""


class Problem(NamedTuple):
    """Numbers of one adhesive impact in SI."""

    profile: Profile
    modulus: PronySeries
    adhesion: Adhesion
    mass: float
    velocity: float


class March(NamedTuple):
    """Result of one march: its end, `NUMBERS`, rows of the motion and of the jumps as the kernel has them."""

    end: int
    numbers: dict[str, float]
    motion: Array
    jumps: Array

    @property
    def widest(self) -> float:
        """Largest radius [m] of the zone."""
        return float(self.motion[:, 4].max(initial=0.0))

    @property
    def duration(self) -> float:
        """Time [s] from the first attraction to the end."""
        return float(self.motion[-1, 0]) if self.motion.size else 0.0


class Solved(NamedTuple):
    """Extrapolated numbers with the finest march, its number of elements, and the error of e."""

    status: Status
    numbers: dict[str, float]
    march: March
    elements: int
    error: float


def solve_adhesive(problem: Problem, rtol: float) -> Solved:
    """Return the impact with e known to `rtol`, or a status that says why not."""
    from restitution.kernel.adhesion import NO_ROOM, TOO_LONG

    width, time = scales(problem)
    for _ in range(_WIDENED):
        if not math.isfinite(width):
            break
        solved = _refined(problem, width, time, rtol)
        if solved.march.end == NO_ROOM:
            # A coarse march may hold a body that a finer one lets go deeper.
            width = _wider(problem, width)
        elif solved.march.end == TOO_LONG:
            time *= _LONGER
        else:
            return solved
    return _failed(Status.TOO_DEEP if width == math.inf else Status.TOO_MANY_STEPS, _NONE)


def _failed(status: Status, march: March) -> Solved:
    return Solved(status, dict.fromkeys(NUMBERS, math.nan), march, 0, math.inf)


def _refined(problem: Problem, width: float, time: float, rtol: float) -> Solved:
    """March with more and more elements on one scale until e is known, or a march does not end."""
    from restitution.kernel.adhesion import HELD, SEPARATED

    count, held, change = FEWEST, 0, 0.0
    last: March | None = None
    now: dict[str, float] | None = None
    while count <= MOST:
        march = run(problem, width, time, count)
        if march.end not in (HELD, SEPARATED):
            return _failed(Status.NOT_ACCURATE, march)
        held = held + 1 if march.end == HELD else 0
        if held >= _SURE:
            return Solved(Status.CAPTURED, march.numbers | {"energy": 0.0}, march, count, 0.0)
        if last is not None and march.end == last.end == SEPARATED:
            after = {name: (4.0 * march.numbers[name] - last.numbers[name]) / 3.0 for name in NUMBERS}
            moved = math.inf if now is None else abs(after["energy"] - now["energy"])
            error = _error_of_e(after["energy"], max(moved, _BEFORE * change))
            if after["energy"] > 0.0 and error <= rtol * max(1.0, _SLOW / math.sqrt(after["energy"])):
                return Solved(Status.SEPARATED, after, march, count, error)
            now, change = after, moved if math.isfinite(moved) else 0.0
        else:
            now, change = None, 0.0
        last = march
        count *= 2
    return _failed(Status.NOT_ACCURATE, _NONE)


def _widest(problem: Problem) -> float:
    """Return the largest zone [m] whose elements end before the profile does, where its slope may be infinite."""
    return 0.99 * float(np.asarray(problem.profile.max_contact_radius)) / (_ROOM + 0.1)


def _wider(problem: Problem, width: float) -> float:
    """Return the next larger zone [m]; infinite beyond the profile."""
    widest = _widest(problem)
    return math.inf if width >= widest else min(_WIDER * width, widest)


def _error_of_e(energy: float, error: float) -> float:
    """Return the error of e from that of e^2."""
    return error / (math.sqrt(max(energy, 0.0)) + math.sqrt(max(energy - error, 0.0)) + 1e-300)


def scales(problem: Problem) -> tuple[float, float]:
    """Return the largest radius [m] of the zone and the duration [s]; infinite where the profile ends before."""
    from restitution.kernel.adhesion import NO_ROOM, TOO_LONG

    width = min(_first_width(problem), _widest(problem))
    time = 4.0 * (float(problem.profile.transform(width)) + float(problem.adhesion.range or 0.0)) / problem.velocity
    for _ in range(_TRIALS):
        march = run(problem, width, time, _SCALING)
        if march.end == NO_ROOM:
            width = _wider(problem, width)
            if width == math.inf:
                return width, time
        elif march.end == TOO_LONG:
            time *= _LONGER
        elif march.widest < _FILLED * width:
            width = max(1.02 * march.widest, 0.1 * width)
            time = min(time, _LONGER * march.duration)
        else:
            return min(1.02 * march.widest, _widest(problem)), march.duration
    return math.nan, time


def _first_width(problem: Problem) -> float:
    """Return a contact radius [m] at which the elastic energy is that of the body and of the attraction."""
    stiff = float(problem.modulus.instantaneous_modulus)
    kinetic = 0.5 * problem.mass * problem.velocity**2
    low, high = 1e-12, 1e6
    for _ in range(_HALVINGS):
        middle = math.sqrt(low * high)
        depth = float(problem.profile.transform(middle))
        spent = kinetic + float(problem.adhesion.work) * math.pi * middle * middle
        low, high = (low, middle) if not stiff * depth * depth * middle < spent else (middle, high)
    return high


def run(problem: Problem, width: float, time: float, count: int) -> March:
    """March with elements `width/count` apart and steps of at most `time/count`."""
    from restitution.kernel.adhesion import G_, JUMPED_, LEFT_, STEPS_, Bodies, Solid, allocate_room, march

    stress, reach = float(problem.adhesion.stress or 0.0), float(problem.adhesion.range or 0.0)
    solid = Solid(*compliance_of(problem.modulus))
    cell = width / count
    places = cell * np.arange(int(_ROOM * count) + 8)
    room = allocate_room(places.size, solid.rates.size, _STEPS * count, _JUMPS)
    room.nodes[G_] = problem.profile.transform(places)
    end = march(solid, Bodies(stress, reach, problem.mass, cell, time / count), problem.velocity, room)
    motion, jumps = room.motion[: room.counts[STEPS_]], room.jumps[: room.counts[JUMPED_]]
    return March(int(end), _numbers(problem, motion, jumps, float(room.ends[LEFT_])), motion, jumps)


def _numbers(problem: Problem, motion: Array, jumps: Array, left: float) -> dict[str, float]:
    """Return `NUMBERS` of a march; `left` is the energy of body and surface at its end."""
    if not motion.size:
        return dict.fromkeys(NUMBERS, math.nan)
    time, depth, speed, force, _, radius, viscous, lost = motion.T
    kinetic = 0.5 * problem.mass * problem.velocity**2
    out = 0.5 * problem.mass * float(speed[-1]) ** 2
    touching = np.flatnonzero(radius > 0.0)
    touch = float(time[touching[-1]] - time[touching[0]]) if touching.size else 0.0
    turn = np.flatnonzero((speed[:-1] > 0.0) & (speed[1:] <= 0.0) & (force[:-1] > 0.0))
    peak = float(depth.max())
    if turn.size:
        n = int(turn[0])
        peak = max(peak, float(depth[n]) + 0.5 * problem.mass * float(speed[n]) ** 2 / float(force[n]))
    return {
        "energy": out / kinetic, "contact_time": float(time[-1]), "max_indentation_depth": peak,
        "max_force": max(_peak(time, force), 0.0), "max_contact_radius": _peak(time, radius),
        "residual_indentation_depth": float(depth[-1]), "dissipated_energy": float(viscous[-1]),
        "radiated_energy": float(lost[-1]), "stored_energy": left - out,
        "pull_off_force": max(_peak(time, -force), 0.0), "touching_time": touch,
    }  # fmt: skip


def _peak(time: Array, values: Array) -> float:
    """Return the largest value, from a parabola where the neighbours lie on a smooth curve."""
    n = int(np.argmax(values))
    if not 0 < n < values.size - 1:
        return float(values[n])
    before, after = time[n] - time[n - 1], time[n + 1] - time[n]
    rises, falls = values[n] - values[n - 1], values[n] - values[n + 1]
    # A jump takes no time, and differs by more than its neighbours do.
    if before <= 0.0 or after <= 0.0 or max(rises, falls) > 0.05 * abs(values[n]):
        return float(values[n])
    bend = (rises / before + falls / after) / (before + after)
    slope = (rises / before * after - falls / after * before) / (before + after)
    return float(values[n] + 0.25 * slope * slope / bend) if bend > 0.0 else float(values[n])


_NONE = March(-1, dict.fromkeys(NUMBERS, math.nan), np.empty((0, 8)), np.empty((0, 7)))


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
    count, last, now, change = FEWEST, math.nan, math.nan, math.inf
    while count <= MOST:
        while not _escapes(problem, high, width, time, count):
            high *= 1.0 + _SPREAD
        while _escapes(problem, low, width, time, count):
            low /= 1.0 + _SPREAD
        while high - low > _FINE * rtol * high:
            middle = 0.5 * (low + high)
            low, high = (low, middle) if _escapes(problem, middle, width, time, count) else (middle, high)
        after = high if math.isnan(last) else (4.0 * high - last) / 3.0
        moved = abs(after - now) / after
        if count > 2 * FEWEST and max(moved, _BEFORE * change) <= rtol:
            return after, max(moved, _BEFORE * change)
        if count > 2 * FEWEST:
            change = moved
        spread = 4.0 * abs(high - last) / high if math.isfinite(last) else _SPREAD
        last, now = high, after
        low, high = high * (1.0 - spread - rtol), high * (1.0 + spread + rtol)
        count *= 2
    return math.nan, math.inf


def _escapes(problem: Problem, velocity: float, width: float, time: float, count: int) -> bool:
    from restitution.kernel.adhesion import NO_ROOM, SEPARATED

    end = run(problem._replace(velocity=velocity), width, time, count).end
    return end in (SEPARATED, NO_ROOM)


def _bracket(problem: Problem) -> tuple[float, float]:
    """Return velocities within a tenth of each other, of which the lower one sticks; zeros if none is found."""

    def escapes(velocity: float) -> bool:
        width, time = scales(problem._replace(velocity=velocity))
        return not math.isfinite(width) or _escapes(problem, velocity, width, time, FEWEST)

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
