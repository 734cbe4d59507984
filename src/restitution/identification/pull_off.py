"""Forces of adhesive contacts under measured depths: few straight lines, and forces that a sample averages."""

from __future__ import annotations

import math
from copy import copy
from typing import NamedTuple

import numpy as np

from restitution.checks import Array
from restitution.contact.adhesion import Adhesion
from restitution.contact.profiles import Profile
from restitution.errors import InputError
from restitution.identification.adhesion import StickyMaterial, thick_stress
from restitution.indentation.attraction import March, Program, Sticky
from restitution.material.prony import PronySeries
from restitution.parallel import on_threads

# A line leaves the samples by at most this multiple of their noise, or this share of their range.
_APART, _SMOOTH = 4.0, 2e-3
# Radius of the attraction over that of the contact, and its growth where it is larger.
_WIDE, _WIDER, _TRIALS = 1.2, 1.3, 8
# Second differences of forces above this multiple of their noise are those of jumps; noise has 2.4 on average.
_JUMPS = 12.0
# Work of adhesion from the largest pull F = 1.5 pi w R (JKR) to 2 pi w R (DMT) of a sphere.
_BETWEEN = 1.75 * math.pi


class Lines(NamedTuple):
    """Depth [m] of straight lines between knots over time [s]."""

    time: Array
    depth: Array


def lines_of(time: Array, depth: Array, noise: float) -> Lines:
    """Return few straight lines through a noisy depth, by least squares over knots where it bends.

    Knots are added where a sample is farthest from the lines between those that are there (Douglas and Peucker), until
    none is farther than the noise explains.
    """
    enough = max(_APART * noise, _SMOOTH * float(np.ptp(depth)))
    knots, todo = {0, time.size - 1}, [(0, time.size - 1)]
    while todo:
        first, last = todo.pop()
        if last - first < 2:
            continue
        part = slice(first, last + 1)
        chord = np.interp(time[part], time[[first, last]], depth[[first, last]])
        distance = np.abs(depth[part] - chord)
        worst = int(np.argmax(distance))
        if distance[worst] > enough:
            knots.add(first + worst)
            todo += [(first, first + worst), (first + worst, last)]
    places = np.array(sorted(knots))
    at = time[places]
    # Columns of a spline of order one.
    right = np.clip(np.searchsorted(at, time, side="right"), 1, at.size - 1)
    share = (time - at[right - 1]) / (at[right] - at[right - 1])
    columns = np.zeros((time.size, at.size))
    rows = np.arange(time.size)
    columns[rows, right - 1], columns[rows, right] = 1.0 - share, share
    return Lines(at, np.asarray(np.linalg.lstsq(columns, depth, rcond=None)[0], dtype=np.float64))


class PullOff:
    """Contacts of one indenter under measured depths, from materials with adhesion to forces at the samples.

    Parameters
    ----------
    profile : Profile
        Profile of the indenter.
    time : array, shape (n,)
        Times of the samples [s].
    lines : Lines
        Depths of the tip [m], or of the base of a spring.
    deepest : float
        Largest depth of the tip [m].
    stiffness : float, optional
        Stiffness of the spring [N/m].
    count : int
        Number of elements.
    """

    def __init__(
        self, profile: Profile, time: Array, lines: Lines, deepest: float, stiffness: float | None, count: int
    ) -> None:
        self.profile, self.time, self.lines, self.count = profile, time, lines, count
        self._deepest, self._stiffness = deepest, stiffness
        steps = np.diff(time)
        # Speed [m/s] of the approach, also before the record: that of its first line, or the mean one if it is faster.
        places = np.array([1, max(int(np.argmax(lines.depth)), 1)])
        self._pace = float(((lines.depth[places] - lines.depth[0]) / (lines.time[places] - lines.time[0])).max())
        # A sample is the mean over its time: so a jump between two samples changes both continuously.
        self._starts = time - 0.5 * np.append(steps[0], steps)
        self._ends = time + 0.5 * np.append(steps, steps[-1])

    def with_elements(self, factor: int) -> PullOff:
        """Return the same contacts with so many times the elements."""
        finer = copy(self)
        finer.count = factor * self.count
        return finer

    def forces(self, reduced: PronySeries, touches: Array, materials: StickyMaterial, finer: int = 1) -> Array:
        """Return forces [N] of materials of shape (m, 1) with first touch at depths [m], shape (m, n)."""
        if np.any(reduced.parallel_viscosity > 0.0):
            raise InputError("model", rule="must have no parallel dashpot with adhesion, as jumps would take time")
        m = touches.size
        forces = np.full((m, self.time.size), np.nan)

        def run(row: int) -> None:
            modulus, work, stress = reduced.row(row, 0), float(materials.work[row, 0]), float(materials.stress[row, 0])
            if math.isfinite(work) and math.isfinite(stress) and math.isfinite(modulus.instantaneous_modulus):
                count = finer * self.count
                adhesion = Adhesion(work, thick_stress(self.profile, modulus, (work, stress), count))
                forces[row] = self._force(Sticky(self.profile, modulus, adhesion), float(touches[row]), count)

        if m == 1:
            run(0)
        else:
            on_threads(run, range(m), None, lambda: None)
        return forces

    def _force(self, body: Sticky, touch: float, count: int) -> Array:
        """Return the forces of one contact; NaN where it has none."""
        from restitution.kernel.zone import HELD, NO_ROOM, SEPARATED

        depth, time, reach = self.lines.depth - touch, self.lines.time, float(np.asarray(body.adhesion.range))
        if depth[0] > -reach and self._pace > 0.0:
            # The attraction has begun before the record.
            time = np.append(time[0] - (depth[0] + reach) / self._pace, time)
            depth = np.append(-reach, depth)
        near = np.flatnonzero(depth > -reach)
        if depth[0] > -reach or not near.size:
            return np.full(self.time.size, np.nan)
        n = int(near[0])
        start = time[n - 1] + (time[n] - time[n - 1]) * (-reach - depth[n - 1]) / (depth[n] - depth[n - 1])
        width = self._width(body, self._deepest - touch, float(time[-1] - start))
        program = Program(np.append(start, time[n:]), np.append(-reach, depth[n:]), self._stiffness)
        march = body.follow(width, program, count)
        for _ in range(_TRIALS):
            if march.end != NO_ROOM:
                break
            width *= _WIDER
            march = body.follow(width, program, count)
        if march.end not in (HELD, SEPARATED):
            return np.full(self.time.size, np.nan)
        return _means(march, self._starts, self._ends)

    def _width(self, body: Sticky, deepest: float, duration: float) -> float:
        """Return a radius [m] of the attraction, a smooth function of all numbers.

        The contact at the largest depth d is that of Johnson, Kendall and Roberts, ``d = g(a) - sqrt(2 pi a w/E*)``.
        """
        work, reach = float(np.asarray(body.adhesion.work)), float(np.asarray(body.adhesion.range))
        soft = 2.0 * math.pi * work / float(body.modulus.relaxation_modulus(duration))
        level = deepest = max(deepest, 1e-3 * reach)
        for _ in range(30):
            further = deepest + math.sqrt(soft * float(body.profile.contact_radius(level)))
            if abs(further - level) < 1e-9 * further:
                break
            level = further
        return _WIDE * float(body.profile.contact_radius(level + reach))


def _means(march: March, starts: Array, ends: Array) -> Array:
    """Return means of the force between times [s]; the force is linear in a step, and 0 outside of the march."""
    time, force = march.motion[:, 0], march.motion[:, 3]
    steps = np.diff(time)
    impulse = np.append(0.0, np.cumsum(0.5 * (force[1:] + force[:-1]) * steps))

    def until(t: Array) -> Array:
        place = np.clip(np.searchsorted(time, t, side="right") - 1, 0, time.size - 2)
        width = np.maximum(steps[place], 1e-300)
        share = np.clip((t - time[place]) / width, 0.0, 1.0)
        mean = force[place] + 0.5 * share * (force[place + 1] - force[place])
        return impulse[place] + share * steps[place] * mean

    return (until(ends) - until(starts)) / (ends - starts)


def work_of_pull(radius: float, pull: float) -> float:
    """Return the work of adhesion [J/m^2] of a sphere from its largest pull [N], between both limits."""
    return pull / (_BETWEEN * radius)


def deviations_at_jumps(force: Array, deviations: Array) -> Array:
    """Return standard deviations of forces [N], larger beside a jump, whose time is known to a sample only."""
    bend = np.zeros(force.size)
    bend[1:-1] = np.abs(force[2:] - 2.0 * force[1:-1] + force[:-2])
    # A record may begin or end with a jump.
    bend[0], bend[-1] = bend[1], bend[-2]
    return np.where(bend > _JUMPS * deviations, np.hypot(deviations, 0.5 * bend), deviations)
