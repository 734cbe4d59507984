"""Tangential motion of one impact: full sliding recognised, no slip by collocation, else elements to a tolerance."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from restitution.checks import Array
from restitution.impact.solution import V_, Solution
from restitution.material.prony import PronySeries
from restitution.numerics.richardson import Extrapolation

if TYPE_CHECKING:
    from restitution.kernel.sliding import Modes, Room

# Steps in each half of the marches: they double first, as their errors are far apart, then grow by a third or a half.
COUNTS = (32, 64, 128, 192, 256, 384, 512, 768, 1024, 1536, 3072, 4608, 6144)
# Steps in each half of a march from which the contact counts as sliding throughout if no element ever stuck, and least
# steps of the last march, as energies are extrapolated where e_t is known before.
_SURE, _LEAST = 192, 96
# Largest residual of the balance of energy over the tolerance. Up to some number of steps it is to be smaller, and the
# error of the parts of the energy over the root of the tolerance as well: both cost few more marches.
_RESIDUAL, _SMALL_RESIDUAL, _SMALL_SPLIT, _LONG = 10.0, 0.25, 0.3, 768
# Least steps in each half of the march of a history.
_HISTORY = 512
# Error of the parts of the energy over the changes of their extrapolations, whose order suits e_t. It comes from a
# comparison of 1131 random impacts with finer marches.
_SPLIT = 9.0
# Marches in the first call of the kernel: the least for an error.
_FIRST = 4
# Factor of the estimates of errors, and the same where the shortest relaxation time is below this share of the contact
# time: then errors are no powers of the step. By comparison of 1131 random impacts with finer marches.
_MARGIN, _FAST_MARGIN, _FAST = 3.0, 12.0, 3e-3
# Slopes below the first have a slipping rim so thin that e_t is linear; it is interpolated from the second on.
_THIN, _NEAR = 0.01, 0.02
# Search of the slope of full sliding: steps of the marches, relative width at its end, and how near they are.
_SEARCHED, _SAME_SLOPE, _NEAR_SLOPE = (96, 192), 1e-7, 5e-3
# Ages at which E*/G* is compared, and its fall that counts as rounding.
_AGES, _ROUNDING = 128, 1e-9
# Columns of `motion`.
MOTION = ("time", "velocity", "force", "stick_radius", "slip_velocity")
# Those that are proportional to the velocity.
_SCALED = [1, 2, 4]


class Tangential(NamedTuple):
    """Tangential half of an impact, scaled by the normal one, for a direction in which the contact point first moves.

    Velocities are over that of the contact point at first touch, energies over its energy `v^2/(2 mobility)`.
    `restitution` is e_t, `error` the estimate of its error, `split_error` that of each part of the energy.
    `motion` has the columns `MOTION`.
    """

    restitution: float
    error: float
    split_error: float
    friction: float
    viscous: float
    stored: float
    motion: Array
    gaps: float  # share of the contact time in which elements slip within the radius that sticks

    @property
    def residual(self) -> float:
        """Sum of the parts of the energy that is lost, less what the velocities say."""
        return self.friction + self.viscous + self.stored + self.restitution**2 - 1.0


@dataclass(frozen=True, eq=False)
class Slider:
    """Solver of the tangential half on the stored normal solution of one impact.

    Parameters
    ----------
    solution : Solution
        The normal impact.
    spectrum : PronySeries
        Reduced shear modulus G*(t) [Pa].
    rises : bool
        Whether E*/G* is known to rise all the time, from that of the instantaneous to that of the static moduli.
    """

    solution: Solution
    spectrum: PronySeries
    rises: bool = False

    @cached_property
    def scaled(self) -> Modes:
        """The reduced shear modulus in the units of the solution."""
        from restitution.kernel.sliding import Modes

        units, series = self.solution.units, self.spectrum
        # The scaled force of 1 Pa at depth and radius 1.
        factor = 2.0 * units.radius * units.time * (units.time / self.solution.mass)
        moduli, times = series.branch_moduli * factor, series.relaxation_times / units.time
        drag = float(series.parallel_viscosity) * factor / units.time
        return Modes(float(series.equilibrium_modulus) * factor, drag, moduli[moduli > 0.0], times[moduli > 0.0])

    @property
    def impulse(self) -> float:
        """Impulse of the normal force over m v0, with that of a constant force."""
        rebound = -float(self.solution.stored.halves.rebound[-1, V_, -1])
        return 1.0 + rebound + self.solution.units.external_force * self.solution.end

    def slides(self, slope: float, mobility: float) -> bool:
        """Return whether the whole contact slides to the end, at a slope `v_c0/(mu v0)`; False where it may not.

        In full sliding `v_c/(mu v0) = slope - mobility J` with the impulse J, and no element moves faster than
        ``mu (R_0 v + (R_inf - R_0) v0)`` with the ratio R of the moduli. Both are linear in the velocity v.
        """
        if not self.rises or self.solution.units.external_force > 0.0:
            return False
        glass, static = self.first_slope, self._static_ratio
        spread = static - glass
        e = self.impulse - 1.0
        return slope >= static and slope - mobility * (1.0 + e) >= spread - glass * e

    @property
    def first_slope(self) -> float:
        """Slope from which all of the contact slides at first touch: E*/G* of the glassy moduli."""
        units, scaled = self.solution.units, self.scaled
        if scaled.viscosity > 0.0:
            return units.viscosity / scaled.viscosity
        return (units.equilibrium + float(units.moduli.sum())) / (scaled.equilibrium + float(scaled.moduli.sum()))

    @cached_property
    def keeps(self) -> bool:
        """Whether elements that have stuck for a while slip from the edge inwards alone.

        Else elements within may slip where those around them stick, as old loads are the first to reach their limit
        where E*/G*, a function of their age, falls.
        """
        scaled, units = self.scaled, self.solution.units
        end = self.solution.end
        ages = np.append(0.0, np.geomspace(1e-2 * min([end, *scaled.times, *units.times]), end, _AGES))
        bodies = ((scaled.equilibrium, scaled.moduli, scaled.times), (units.equilibrium, units.moduli, units.times))
        # Of a dashpot and of a spring with it the dashpot counts first.
        shear, normal = (
            np.append(drag, equilibrium + np.exp(-ages[:, None] / of_modes) @ moduli)
            for drag, (equilibrium, moduli, of_modes) in zip((scaled.viscosity, units.viscosity), bodies, strict=True)
        )
        return bool(np.all(normal[1:] * shear[:-1] >= (1.0 - _ROUNDING) * normal[:-1] * shear[1:]))

    @property
    def _margin(self) -> float:
        """Factor of the estimates of errors."""
        times = np.append(self.scaled.times, self.solution.units.times)
        fast = times.size > 0 and float(times.min()) < _FAST * self.solution.end
        return _FAST_MARGIN if fast else _MARGIN

    @property
    def _static_ratio(self) -> float:
        """E*/G* of the static moduli; a liquid is incompressible in the end."""
        equilibrium = self.scaled.equilibrium
        return self.solution.units.equilibrium / equilibrium if equilibrium > 0.0 else 1.5

    def sliding_slope(self, mobility: float) -> float:
        """Return the slope from which all of the contact slides to the end, to some 1e-6 of it.

        Where the ratio of the moduli is constant, it has a closed form. Else marches with two numbers of steps say
        whether any element ever sticks; the slope at which one begins to is of second order in the steps.
        """
        first = self.first_slope
        constant = self.rises and math.isclose(first, self._static_ratio, rel_tol=1e-12)
        if constant and self.solution.units.external_force == 0.0:
            return max(first, mobility * self.impulse - first * (self.impulse - 1.0))

        def sticks(slope: float, count: int) -> bool:
            return bool(self._step(slope, mobility, count).motion[:, 3].any())

        def between(low: float, high: float, count: int) -> float:
            while high - low > _SAME_SLOPE * high:
                middle = 0.5 * (low + high)
                low, high = (middle, high) if sticks(middle, count) else (low, middle)
            return 0.5 * (low + high)

        coarse, fine = _SEARCHED
        low, high = first, 2.0 * first + mobility * self.impulse
        while sticks(high, fine):
            low, high = high, 2.0 * high
        if not sticks(low * (1.0 + _SAME_SLOPE), fine):
            return low
        guess = between(low, high, coarse)
        low, high = max(low, guess * (1.0 - _NEAR_SLOPE)), min(high, guess * (1.0 + _NEAR_SLOPE))
        return guess + (between(low, high, fine) - guess) / (1.0 - (coarse / fine) ** 2)

    def solve(self, slope: float, mobility: float, rtol: float) -> Tangential:
        """Return the motion for ``slope = v_c0/(mu v0)``, 0 without slip, infinite without friction."""
        if slope == 0.0:
            return self._stick(mobility, rtol)
        if self.slides(slope, mobility) or math.isinf(slope):
            return self._slide(slope, mobility, rtol)
        thin = self._thin(slope, mobility, rtol) if slope < _THIN else None
        return thin if thin is not None and thin.error <= rtol else self._march(slope, mobility, rtol)

    def _thin(self, slope: float, mobility: float, rtol: float) -> Tangential:
        """Interpolate between no slip and a march at a larger slope, as elements do not resolve a thin rim.

        e_t is linear in the slope there; the march at twice that slope shows how far. Parts of the energy have other
        values without slip, where elements leave with what a slipping rim loses, and are those of both marches.
        """
        rest = self._stick(mobility, rtol)
        near, far = (self._march(factor * _NEAR, mobility, rtol) for factor in (1.0, 2.0))
        first, second = ((each.restitution - rest.restitution) / (n * _NEAR) for n, each in ((1.0, near), (2.0, far)))
        error = rest.error + slope * (near.error / _NEAR + abs(second - first))
        share = slope / _NEAR - 1.0
        names = ("friction", "viscous", "stored")
        parts, changes = dict[str, float](), [0.0]
        for name in names:
            change = getattr(far, name) - getattr(near, name)
            # No part is negative, but a small one may be so within its error.
            parts[name] = max(getattr(near, name) + share * change, 0.0)
            changes.append(abs(change))
        split = near.split_error + far.split_error + max(changes)
        rim = rest._replace(restitution=rest.restitution + slope * first, error=error, gaps=near.gaps, **parts)
        # The part of the material is the largest, unless the body is elastic.
        viscous = max(rim.viscous - rim.residual, 0.0)
        return rim._replace(viscous=viscous, split_error=max(split, abs(rim.residual)))

    def _stick(self, mobility: float, rtol: float) -> Tangential:
        """Solve without slip."""
        from restitution.kernel.sticking import allocate_room, march

        scaled, halves = self.scaled, self.solution.halves
        moduli, times = np.append(scaled.equilibrium, scaled.moduli), np.append(math.inf, scaled.times)
        room = allocate_room(moduli.size, halves.turn, halves.starts.size - halves.turn)
        modes = scaled._replace(equilibrium=0.0, moduli=moduli, times=times)
        velocity, error, viscous, stored, count = march(halves, modes, mobility, 1e-3 * rtol, room)
        motion = np.zeros((count, len(MOTION)))
        motion[:, :-1] = room.motion[:, :count].T
        unit = 2.0 * mobility
        result = Tangential(-velocity, error, 0.0, 0.0, unit * viscous, unit * stored, motion, 0.0)
        return result._replace(split_error=max(abs(result.residual), 2.0 * abs(result.restitution) * result.error))

    def _slide(self, slope: float, mobility: float, rtol: float) -> Tangential:
        """Return the closed form of full sliding; the energies and the motion are those of marches."""
        if math.isinf(slope):
            motion = np.zeros((2, len(MOTION)))
            motion[:, 0], motion[:, 1], motion[:, 4] = (0.0, self.solution.end), 1.0, 1.0
            return Tangential(-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, motion, 0.0)
        return self._march(slope, mobility, rtol, slides=True)

    def _march(self, slope: float, mobility: float, rtol: float, *, slides: bool = False) -> Tangential:
        """March with more and more steps until the extrapolated e_t is known to `rtol`, and the energies add up."""
        series, closed = Extrapolation(self._margin), -1.0 + mobility * self.impulse / slope
        result, done, known = None, 0, False
        while not known and done < len(COUNTS):
            counts = COUNTS[done : done + 1] if done else COUNTS[:_FIRST]
            room, rows = self._march_all(slope, mobility, counts)
            (e_t, *parts), (error, *errors) = series.extend(counts, rows[:, :-1])
            if not rows[-1, -1]:
                e_t, error = closed, 0.0 if slides or counts[-1] >= _SURE else math.inf
            # No part is negative, but a small one may be so within its error.
            result = self._result(room, [e_t, *(max(part, 0.0) for part in parts)], error)
            result = result._replace(split_error=max(_SPLIT * max(errors), abs(result.residual)))
            known = counts[-1] >= _LEAST and error <= rtol and _is_split(result, rtol, counts[-1])
            done += len(counts)
        assert result is not None
        result.motion[:, _SCALED] /= slope
        return result

    def history(self, slope: float, mobility: float, known: Tangential) -> Array:
        """Return `known.motion` for a history: that of more steps, where it comes from a march.

        The velocity follows the force by the trapezoidal rule, as users of a history would integrate it.
        """
        if slope < _THIN or math.isinf(slope):
            return known.motion
        motion = self._step(slope, mobility, max(_HISTORY, len(known.motion) // 2)).motion
        time, force = motion[:, 0], motion[:, 2]
        impulse = np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(time))
        motion[1:, 1] = motion[0, 1] - mobility * impulse
        return motion

    def _step(self, slope: float, mobility: float, count: int) -> Tangential:
        """March with a number of steps in each half."""
        room, rows = self._march_all(slope, mobility, (count,))
        room.motion[:, _SCALED] /= slope
        return self._result(room, rows[0, :-1].tolist(), math.inf)

    def _result(self, room: Room, values: list[float], error: float) -> Tangential:
        """Return e_t and the parts of the energy with the motion of the last march."""
        from restitution.kernel.sliding import GAPS_

        e_t, friction, viscous, stored = values
        gaps = float(room.sums[GAPS_]) / self.solution.end
        return Tangential(e_t, error, math.inf, friction, viscous, stored, room.motion, gaps)

    def _march_all(self, slope: float, mobility: float, counts: tuple[int, ...]) -> tuple[Room, Array]:
        """March with rising numbers of steps in each half; return the room of the last march, and rows of results.

        They are e_t, the energies lost by friction, dissipated and stored, and 1 if any element ever stuck.
        """
        from restitution.kernel.sliding import Modes, allocate_room
        from restitution.kernel.tangential import N_RESULTS, march

        units, rows = self.solution.units, np.empty((len(counts), N_RESULTS))
        solids = self.scaled, Modes(units.equilibrium, units.viscosity, units.moduli, units.times)
        halves = self.solution.halves
        room = allocate_room(counts[-1], self.scaled.times.size, units.times.size, halves.starts.size)
        march(halves, np.array(counts), solids, mobility, slope, self.keeps, room, rows)
        rows[:, 0] /= -slope
        rows[:, 1:4] /= slope * slope / (2.0 * mobility)
        return room, rows


def _is_split(result: Tangential, rtol: float, count: int) -> bool:
    """Return whether the parts of the energy are as exact as a tolerance and a number of steps ask for."""
    residual = abs(result.residual)
    if residual > _RESIDUAL * rtol or math.isinf(result.split_error):
        return False
    small = residual <= _SMALL_RESIDUAL * rtol and result.split_error <= _SMALL_SPLIT * math.sqrt(rtol)
    return small or count >= _LONG
