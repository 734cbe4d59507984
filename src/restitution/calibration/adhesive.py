"""Calibration of memoryless laws with cohesion: to e over velocity, with the velocity below which a body sticks."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from restitution import validity
from restitution.calibration.adhesive_laws import (
    ADHESIVE_LAWS,
    AdhesiveLaw,
    Contact,
    TypedAdhesive,
    pull_off,
    rebound,
    stiffness,
    typed_adhesive,
    units,
)
from restitution.calibration.collisions import Collisions, Pair, reduced_radius, speeds_of
from restitution.calibration.result import Calibration, TypedParameter, snippet, system_of
from restitution.checks import Array
from restitution.contact.adhesion import Adhesion
from restitution.errors import InputError
from restitution.impact.adhesion import sticking_velocity
from restitution.impact.adhesive import marched, unresolved
from restitution.impact.status import SolverError, Status
from restitution.impact.window import compared, require_known
from restitution.quantities import STATUS, VELOCITY

# Tolerance of e, which no law without memory follows nearer, and of the sticking velocity.
_RTOL, _STICKING_RTOL = 1e-4, 1e-3
# Distance from the sticking velocity, by ratio, within which e is not compared: there it hangs on the last digit.
_NEAR = 0.01


@dataclass(frozen=True, eq=False)
class AdhesiveCollisions(Collisions):
    """Collisions of two bodies with adhesion; e is 0 and the contact time NaN of bodies that stick.

    Attributes
    ----------
    sticking_velocity : float
        Velocity [m/s] below which the bodies stick.
    contact_time : array
        Time [s] from the first to the last touch.
    """

    sticking_velocity: float = math.nan

    @property
    def rebounds(self) -> Array:
        """Velocities [m/s] with which the bodies do not stick."""
        return self.velocity[self.restitution_coefficient[:, 0] > 0.0]

    @property
    def middle(self) -> tuple[float, float, float]:
        """Velocity [m/s], mass [kg] and reduced radius [m] in the middle of the rebounds, by ratios."""
        speeds = self.rebounds
        speed = math.sqrt(float(speeds[0]) * float(speeds[-1]))
        return speed, float(self.mass[0]), float(self.reduced_radius[0])

    @property
    def contact(self) -> Contact:
        """Numbers for which a law is typed."""
        velocity, mass, radius = self.middle
        impact = self.pair.impact
        assert impact.adhesion is not None
        bounced = np.isin(self.velocity, self.rebounds)
        places = np.log(self.velocity[bounced])
        e, time = (
            float(np.interp(math.log(velocity), places, column[bounced, 0]))
            for column in (self.restitution_coefficient, self.contact_time)
        )
        omega, series = math.pi / time, impact.reduced_modulus
        storage = float(series.storage_modulus(omega))
        retardation = float(series.loss_modulus(omega)) / (storage * omega)
        work, reach = (float(np.asarray(x)) for x in (impact.adhesion.work, impact.adhesion.range))
        ratio = impact.material.poisson_ratio
        return Contact(velocity, mass, radius, ratio, work, reach, storage, retardation, e, time)


def collisions(
    pair: Pair,
    adhesion: Adhesion,
    velocity: Any,
    points: int,
    rtol: float,
    workers: int | None,
    *,
    extrapolate: bool = False,
) -> AdhesiveCollisions:
    """Return the collisions of a pair of bodies with adhesion."""
    speeds = speeds_of(velocity, points)
    # The contacts without adhesion stand for those with it.
    require_known(pair.impact, speeds[[0, -1]], extrapolate=extrapolate)
    impact = replace(pair.impact, adhesion=adhesion)
    pair = pair._replace(impact=impact)
    impacts = replace(impact, velocity=speeds)
    if cause := unresolved(impact):
        raise SolverError(Status.NOT_ACCURATE, cause=cause)
    columns, _ = marched(impacts, max(rtol, _RTOL), workers, None)
    status = columns[STATUS]
    held = status == Status.CAPTURED
    odd = ~held & (status != Status.SEPARATED)
    if odd.any():
        raise SolverError(Status(int(status[np.argmax(odd)])), f"at {speeds[np.argmax(odd)]:g} m/s")
    if held.all():
        rule = f"must reach a velocity with which the bodies do not stick; up to {speeds[-1]:g} m/s they all do"
        raise InputError("velocity", velocity, rule, VELOCITY.unit)
    # The search begins between the bodies that stick and those that do not.
    near = math.sqrt(float(speeds[held][-1] * speeds[~held][0])) if held.any() else float(speeds[0])
    sticks = float(sticking_velocity(replace(impact, velocity=near), rtol=_STICKING_RTOL))
    e = np.where(held, 0.0, columns["restitution_coefficient"])[:, None]
    time = np.where(held, np.nan, columns["touching_time"])[:, None]
    mass, radius = (np.array([value]) for value in (float(impact.mass), reduced_radius(impact)))
    of_ball, report = np.array([pair.ball_radius]), validity.report(compared(impacts, columns))
    return AdhesiveCollisions(pair, speeds, of_ball, mass, radius, e, time, report, sticks)


# The nearest law: its adhesion meets the sticking velocity at each loss, and the loss is that of the least error of e.

# Losses of the first round; later rounds lie between the neighbours of the best one.
_LOWEST, _LOSSES, _ROUNDS = 1e-3, 33, 4
# Scaled adhesion between which that of the sticking velocity is sought, parts and rounds of the search.
_ADHESION, _PARTS, _SEARCHES = (1e-4, 30.0), 16, 7
# Largest number of rounds over the length of the model where the attraction has another length.
_LENGTHS = 30


def nearest(law: AdhesiveLaw, cases: AdhesiveCollisions) -> TypedAdhesive:
    """Return the law that sticks below the same velocity, with the least largest difference of e.

    Both hang on the scaled adhesion and loss; the contact times determine the stiffness then.
    """
    contact = cases.contact
    length, _ = units(stiffness(contact.modulus, contact.radius), contact.mass, contact.velocity)
    ranged = law.outside(1.0, 1.0) > 0.0
    for _ in range(_LENGTHS if ranged else 1):
        adhesion, loss = _least(law, cases, contact, contact.reach / length)
        after = _length(law, cases, contact, (adhesion, loss, contact.reach / length))
        if not ranged or abs(after - length) < 1e-4 * length:
            return typed_adhesive(law, (after, adhesion, loss), contact)
        length = after
    raise SolverError(Status.NOT_ACCURATE, cause=f"no {law.name} found with the range of the attraction")


def _least(law: AdhesiveLaw, cases: AdhesiveCollisions, contact: Contact, reach: float) -> tuple[float, float]:
    """Return the scaled adhesion and loss of the nearest law."""
    speeds, e = cases.velocity, cases.restitution_coefficient[:, 0]
    compared = np.abs(np.log(speeds / cases.sticking_velocity)) > _NEAR
    compared &= e > 0.0
    if not compared.any():
        raise InputError("velocity", rule="must reach further from the velocity below which the bodies stick")
    scaled, goal = speeds[compared] / contact.velocity, e[compared]
    sticks = cases.sticking_velocity / contact.velocity
    losses, answer = np.concatenate([[0.0], np.geomspace(_LOWEST, law.largest_loss, _LOSSES)]), (math.nan, math.nan)
    for _ in range(_ROUNDS):
        adhesion = _sticking(law, losses, reach, sticks)
        pull = pull_off(law.form.kind, adhesion)
        e, _ = rebound(law.form, adhesion[:, None], losses[:, None], law.outside(pull, reach)[:, None], scaled)
        error = np.abs(e - goal).max(axis=1)
        error = np.where(np.isnan(error), np.inf, error)
        best = int(np.argmin(error))
        if not math.isfinite(error[best]):
            raise InputError("target", law.name, f"cannot stick below {cases.sticking_velocity:.4g} m/s")
        answer = float(adhesion[best]), float(losses[best])
        low, high = losses[max(best - 1, 0)], losses[min(best + 1, losses.size - 1)]
        losses = np.linspace(low, high, _LOSSES)
    return answer


def _sticking(law: AdhesiveLaw, losses: Array, reach: float, velocity: float) -> Array:
    """Return the scaled adhesion with which a body begins to stick at a velocity, for each loss; NaN if none does."""
    low, high = (np.full(losses.size, end) for end in _ADHESION)
    shares = np.linspace(0.0, 1.0, _PARTS + 1)
    rows, missing = np.arange(losses.size), np.zeros(losses.size, bool)
    for n in range(_SEARCHES):
        trials = low[:, None] * (high / low)[:, None] ** shares
        pull = pull_off(law.form.kind, trials)
        e, _ = rebound(law.form, trials, losses[:, None], law.outside(pull, reach), velocity)
        held = e == 0.0
        if n == 0:
            missing = held[:, 0] | ~held[:, -1]
        first = np.maximum(held.argmax(axis=1), 1)
        low, high = trials[rows, first - 1], trials[rows, first]
    return np.where(missing, np.nan, low)


def _length(
    law: AdhesiveLaw, cases: AdhesiveCollisions, contact: Contact, numbers: tuple[float, float, float]
) -> float:
    """Return the length [m] of 1 with which the times in touch are nearest to the exact ones, by ratios."""
    adhesion, loss, reach = numbers
    outside = law.outside(pull_off(law.form.kind, adhesion), reach)
    _, time = rebound(law.form, adhesion, loss, outside, cases.velocity / contact.velocity)
    ratio = np.log(cases.contact_time[:, 0] / (time / contact.velocity))
    ratio = ratio[np.isfinite(ratio)]
    return math.exp(0.5 * float(ratio.min() + ratio.max()))


def calibrated(name: str, cases: AdhesiveCollisions, units_name: str) -> AdhesiveCalibration:
    """Return the law of a code that is nearest to collisions with adhesion."""
    law = ADHESIVE_LAWS[name]
    best, system = nearest(law, cases), system_of(cases, units_name)
    naive = law.naive(best.contact)

    def numbers(law: TypedAdhesive) -> dict[str, TypedParameter]:
        return {
            key: TypedParameter(system.convert(value, dimension), system.unit(dimension), words)
            for key, (value, dimension, words) in law.law.typed(law).items()
        }

    parameters = numbers(best)
    text = snippet(best, parameters, cases, system, None)
    return AdhesiveCalibration(
        law.name, law.words, law.source, units_name, parameters, numbers(naive), text, cases, best, naive
    )


@dataclass(frozen=True, eq=False, repr=False)
class AdhesiveCalibration(Calibration):
    """A contact law with cohesion of another code, calibrated to the exact e and sticking velocity; by `calibrate`.

    Errors are differences of e, as e = 0 where the bodies stick. The contact time is that in touch.

    Attributes
    ----------
    sticking_velocity : float
        Velocity [m/s] below which the bodies stick, the exact one, which the law has too.
    pull_off_force : float
        Largest pull [N] of the law.
    """

    _numbers = (*Calibration._numbers, "sticking_velocity", "pull_off_force")
    error_words: ClassVar[str] = "difference of the calibrated coefficient from the exact one"
    error_column: ClassVar[tuple[str, float, str, str]] = ("difference", 1.0, "", "+.4f")

    @property
    def sticking_velocity(self) -> float:
        """Velocity [m/s] below which the bodies stick."""
        assert isinstance(self.collisions, AdhesiveCollisions)
        return self.collisions.sticking_velocity

    @property
    def pull_off_force(self) -> float:
        """Largest pull [N] of the law."""
        assert isinstance(self.law, TypedAdhesive)
        return self.law.pull_off_force

    def _error(self, values: Any, exact: Any) -> Any:
        return values - exact

    def _promise(self, velocity: Any, radius: float | None) -> tuple[Any, Any]:
        if radius is not None:
            raise InputError("radius", radius, "must be left out with adhesion", "m")
        return super()._promise(velocity, radius)

    @property
    def _lines(self) -> list[str]:
        """Numbers to type, the velocity and the pull at which the bodies stick, and the errors."""
        lines = super()._lines
        count = len(self.parameters)
        held, pull = f"{self.sticking_velocity:.4g} m/s", f"{self.pull_off_force:.4g} N"
        additions = [f"  sticks below {held}, as the bodies do; largest pull {pull}"]
        if "e" in self.parameters or "en" in self.parameters:
            additions.append("  the e that is typed is that of the code without cohesion, not that of the bodies")
        return [*lines[:count], *additions, *lines[count:]]
