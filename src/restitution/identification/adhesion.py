"""Adhesion in a fit: its numbers as unknowns, impacts that may stick, and the velocity at which they begin to."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.checks import Array
from restitution.contact.adhesion import Adhesion, maugis_number
from restitution.contact.profiles import Profile
from restitution.errors import InputError
from restitution.impact.dugdale import Problem
from restitution.indentation.attraction import March, Sticky
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material
from restitution.parallel import on_threads

# A fit marches with one number of elements and with scales that are smooth functions of its unknowns, so that
# differences of results are derivatives. Errors that matter less than noise need no more elements.

STEP = 1e-2
"""Step of the logarithms for differences: marches have kinks of some 1e-5 where an element is reached or not."""

ERROR = 0.2
"""Share of the noise below which an error by few elements does not count."""

MOST = 400
"""Most elements of a fit."""

# Largest lambda at the instantaneous modulus over the root of the number of elements; some seven of them are then in
# the zone. Beyond it results hardly change.
_THINNEST, _FEWEST = 0.38, 50
# Error of e with 100 elements, and the share of the noise that it may be.
_ERROR, _SHARE = 2.5e-4, 0.1
# Radius of the attraction over that of the Hertzian contact at the largest depth, and its growth where it is larger.
_WIDE, _WIDER, _LONGER, _TRIALS = 1.2, 1.3, 4.0, 8
# Relative width of the bracket of the sticking velocity, factor of its search, and how often it is applied.
_BRACKET, _FACTOR, _MOST_FACTORS = 2e-5, 1.4, 40
# A body escapes for sure so many deviations above the sticking velocity.
_FAR = 4.0
# Width of the neighbourhood of a velocity, and its least spread, as logarithms.
_NEAR, _ALONE = 0.2, 0.05
# Work of jumps of an elastic sphere over (w^5 R^4/E*^2)^(1/3) in the limit of Johnson, Kendall and Roberts.
_JKR_WORK = 7.0921960


@dataclass(frozen=True, init=False, repr=False, eq=False)
class StickyMaterial(Material):
    """Materials of a fit, shape (m, 1), with the work [J/m^2] and the stress [Pa] of their adhesion, shape (m, 1)."""

    work: Array
    stress: Array

    def __init__(self, *moduli: Any, work: Array, stress: Array, **options: Any) -> None:
        super().__init__(*moduli, **options)
        self.__dict__.update(work=work, stress=stress)


def elements_for(deviation: float) -> int:
    """Return the number of elements whose error of e is small beside its noise."""
    return int(np.clip(100.0 * math.sqrt(_ERROR / (_SHARE * deviation)), _FEWEST, MOST))


def thick_stress(profile: Profile, modulus: PronySeries, adhesion: tuple[float, float], count: int) -> float:
    """Return the stress [Pa] of an adhesion, or that of the thinnest zone which so many elements resolve.

    `adhesion` has the work [J/m^2] and the stress. Only a parabola has such a limit.
    """
    work, stress = adhesion
    if profile.path_exponent != 1.0:
        return stress
    radius = float(np.asarray(profile.path_coefficient)) ** 2
    thinnest = _THINNEST * math.sqrt(count)
    return min(stress, thinnest / float(maugis_number(work, 1.0, float(modulus.instantaneous_modulus), radius)))


def doubts_of(share: float, profiles: Sequence[Profile], reduced: PronySeries, materials: StickyMaterial,
              count: int) -> list[str]:  # fmt: skip
    """Return doubts about a fit, in words: the error of few elements over the noise, and zones that are too thin.

    The reduced moduli are those of the profiles, shape (1, n).
    """
    lines = list[str]()
    if share > ERROR:
        lines.append(f"few elements of the attraction have an error of {share:.2g} of the noise: state a larger noise")
    adhesion = float(materials.work[0, 0]), float(materials.stress[0, 0])
    taken = [thick_stress(profile, reduced.row(0, n), adhesion, count) for n, profile in enumerate(profiles)]
    if min(taken) < adhesion[1]:
        lines.append(
            f"the attraction is nearly that of Johnson, Kendall and Roberts: a stress above {min(taken):.2g} Pa is "
            "taken as this one, for which Maugis' lambda is as large as the elements permit"
        )
    return lines


class _Number(NamedTuple):
    """Numbers of one impact: e, contact time [s], peak force [N]; NaN of one that fails."""

    escapes: bool
    values: tuple[float, float, float]


class Collision:
    """One body on one material, at any velocity, with a fixed number of elements."""

    def __init__(self, body: Sticky, mass: float, count: int) -> None:
        self.body, self.mass, self.count = body, mass, count
        series = body.modulus
        self._relaxation = float(series.equilibrium_modulus), series.branch_moduli, 1.0 / series.relaxation_times

    def _scales(self, velocity: float) -> tuple[float, float]:
        """Return radius [m] and duration [s] of an elastic impact with adhesion, smooth functions of all numbers."""
        body, kinetic = self.body, 0.5 * self.mass * velocity * velocity
        work, reach = float(np.asarray(body.adhesion.work)), float(np.asarray(body.adhesion.range))
        static, moduli, rates = self._relaxation

        def excess(radius: float) -> tuple[float, float]:
            depth = float(body.profile.transform(radius))
            time = 3.0 * (depth + reach) / velocity
            stiff = static + float(moduli @ np.exp(-rates * time))
            elastic = 8.0 / 15.0 * stiff * radius * depth * depth
            return math.log(elastic / (kinetic + work * math.pi * radius * radius)), time

        # Newton's method in the logarithm, with the slope of a parabola without attraction.
        radius = float(body.profile.contact_radius(reach))
        for _ in range(60):
            step = excess(radius)[0] / 5.0
            radius *= math.exp(-min(max(step, -2.0), 2.0))
            if abs(step) < 1e-9:
                break
        depth = float(body.profile.transform(radius))
        return _WIDE * float(body.profile.contact_radius(depth + reach)), excess(radius)[1]

    def at(self, velocity: float) -> _Number:
        """Return the numbers of the impact at a velocity [m/s]."""
        from restitution.kernel.zone import HELD, NO_ROOM, SEPARATED, TOO_LONG

        width, time = self._scales(velocity)
        problem = Problem(self.body, self.mass, velocity)
        march = problem.march(width, time, self.count)
        for _ in range(_TRIALS):
            if march.end not in (NO_ROOM, TOO_LONG):
                break
            width, time = (_WIDER * width, time) if march.end == NO_ROOM else (width, _LONGER * time)
            march = problem.march(width, time, self.count)
        if march.end == SEPARATED:
            return _Number(True, _values(march, velocity))
        nothing = 0.0 if march.end == HELD else math.nan
        return _Number(False, (nothing, math.nan, math.nan))

    def threshold(self, low: float, high: float, bodies: Bodies) -> tuple[float, _Number]:
        """Return the velocity between one that sticks and one that does not at which bodies begin to stick."""
        end = self.at(high)
        while high > low * (1.0 + _BRACKET) and not bodies.agree(low, high):
            middle = math.sqrt(low * high)
            trial = self.at(middle)
            if trial.escapes:
                high, end = middle, trial
            else:
                low = middle
        return high, end


def _values(march: March, velocity: float) -> tuple[float, float, float]:
    """Return e, contact time [s] and peak force [N] of a body that leaves."""
    time, force = march.motion[:, 0], march.motion[:, 3]
    n = int(np.argmax(force))
    peak = float(force[n])
    if 0 < n < force.size - 1 and time[n - 1] < time[n] < time[n + 1]:
        # The parabola through three points.
        before, after = time[n] - time[n - 1], time[n + 1] - time[n]
        rise, fall = (peak - force[n - 1]) / before, (peak - force[n + 1]) / after
        bend = (rise + fall) / (before + after)
        if bend > 0.0:
            slope = (rise * after - fall * before) / (before + after)
            peak += float(0.25 * slope * slope / bend)
    return abs(float(march.motion[-1, 2])) / velocity, float(time[-1]), peak


class Bodies(NamedTuple):
    """Impacts of equal bodies at one temperature."""

    profile: Profile
    mass: float
    places: NDArray[np.intp]  # of the impacts among all
    velocities: Array
    deviations: Array  # of the velocities
    stuck: NDArray[np.bool_]  # whether they stuck

    def agree(self, low: float, high: float) -> bool:
        """Return whether a sticking velocity between these is too far from all velocities to matter, as measured."""
        reach = _FAR * self.deviations
        below = self.velocities + np.where(self.stuck, reach, -reach)
        return bool(np.all(np.where(self.stuck, below < low, below > high)))


class Outcomes(NamedTuple):
    """Impacts of m materials.

    `values` has e, contact time and peak force, shape (3, m, n), of bodies that stick those at the sticking velocity.
    `sticks` is whether they stick. `thresholds` are the sticking velocities of the bodies, shape (m, n_bodies), known
    so far as they matter; 0 where they are too low.
    """

    values: Array
    sticks: NDArray[np.bool_]
    thresholds: Array


def collide(groups: Sequence[Bodies], reduced: PronySeries, adhesion: StickyMaterial, count: int) -> Outcomes:
    """Return the impacts of all bodies on the reduced moduli of m materials, of shape (m, n)."""
    if np.any(reduced.parallel_viscosity > 0.0):
        raise InputError("model", rule="must have no parallel dashpot with adhesion, as jumps would take time")
    m, n = reduced.shape
    values, thresholds = np.full((3, m, n), np.nan), np.full((m, len(groups)), np.nan)
    outcomes = Outcomes(values, np.zeros((m, n), dtype=np.bool_), thresholds)

    def run(task: tuple[int, int]) -> None:
        row, which = task
        bodies = groups[which]
        modulus = reduced.row(row, int(bodies.places[0]))
        work, stress = float(adhesion.work[row, 0]), float(adhesion.stress[row, 0])
        if not (math.isfinite(work) and math.isfinite(stress) and math.isfinite(modulus.instantaneous_modulus)):
            return
        taken = Adhesion(work, thick_stress(bodies.profile, modulus, (work, stress), count))
        collision = Collision(Sticky(bodies.profile, modulus, taken), bodies.mass, count)
        numbers = [collision.at(float(v)) for v in bodies.velocities]
        threshold, end = _threshold(collision, bodies, numbers)
        outcomes.thresholds[row, which] = threshold
        for place, number in zip(bodies.places.tolist(), numbers, strict=True):
            held = not number.escapes and number.values[0] == 0.0
            outcomes.sticks[row, place] = held
            outcomes.values[:, row, place] = end.values if held else number.values

    tasks = [(row, which) for row in range(m) for which in range(len(groups))]
    if len(tasks) == 1:
        run(tasks[0])
    else:
        on_threads(run, tasks, None, lambda: None)
    return outcomes


def _threshold(collision: Collision, bodies: Bodies, numbers: list[_Number]) -> tuple[float, _Number]:
    """Return the sticking velocity [m/s], 0 if it is too low and NaN if too high, and the numbers just above it."""
    nothing = _Number(False, (math.nan, math.nan, math.nan))
    held = bodies.velocities[[not number.escapes for number in numbers]]
    free = bodies.velocities[[number.escapes for number in numbers]]
    low = float(held.max()) if held.size else 0.0
    above = free[free > low]
    high = float(above.min()) if above.size else low
    if not held.size:
        # Bodies that stuck show how much too low it is.
        n = _MOST_FACTORS if np.any(bodies.stuck) else 1
        low = high * (1.0 - _FAR * float((bodies.deviations / bodies.velocities).max()))
        for _ in range(n):
            if not collision.at(low).escapes:
                break
            high, low = low, low / _FACTOR
        else:
            return 0.0, nothing
    if not above.size:
        for _ in range(_MOST_FACTORS):
            low, high = high, high * _FACTOR
            if collision.at(high).escapes:
                break
        else:
            return math.nan, nothing
    return collision.threshold(low, high, bodies)


def surprise(groups: Sequence[Bodies], thresholds: Array) -> Array:
    """Return residuals of what stuck, and of what did not, by sticking velocities of shape (m, n_bodies).

    A body with a velocity v that is known to s sticks with the probability ``Phi((v_s - v)/s)``. The square of a
    residual is -2 times the logarithm of the probability of all that stuck, or of all that did not.
    """
    from scipy.special import log_ndtr

    columns = list[Array]()
    for n, bodies in enumerate(groups):
        distance = (thresholds[:, n : n + 1] - bodies.velocities) / bodies.deviations
        for part, sign in ((bodies.stuck, 1.0), (~bodies.stuck, -1.0)):
            if np.any(part):
                columns.append(np.sqrt(-2.0 * log_ndtr(sign * distance[:, part]).sum(axis=1)))
    return np.stack(columns, axis=1)


def slopes_over(bodies: Bodies, values: Array) -> Array:
    """Return slopes of measured values over the logarithm of the velocity, by lines through neighbours; 0 if stuck.

    The noise of the velocity enters the deviations of the residuals by them. Those of a trial would let a fit choose
    them.
    """
    x, free = np.log(bodies.velocities), ~bodies.stuck & np.isfinite(values)
    values = np.where(free, values, 0.0)
    weights = np.exp(-0.5 * ((x[:, None] - x) / _NEAR) ** 2) * free
    total = np.maximum(weights.sum(axis=1), 1e-300)
    x_mean, mean = weights @ x / total, weights @ values / total
    spread = weights @ (x * x) / total - x_mean**2
    slopes = (weights @ (x * values) / total - x_mean * mean) / np.maximum(spread, _ALONE**2)
    return np.where(free, slopes, 0.0)


def count_of_surprises(groups: Sequence[Bodies]) -> int:
    """Return the number of residuals of `surprise`."""
    return sum(int(np.any(bodies.stuck)) + int(np.any(~bodies.stuck)) for bodies in groups)


def work_of_sticking(radius: float, mass: float, velocity: float, modulus: float) -> float:
    """Return the work of adhesion [J/m^2] of an elastic sphere in the limit of Johnson, Kendall and Roberts."""
    lost = 0.5 * mass * velocity * velocity / _JKR_WORK
    return (lost**3 * modulus**2 / radius**4) ** 0.2
