"""Measured bounces of a ball: the restitution coefficient and the loss tangent of each, with their errors."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from restitution import checks
from restitution.checks import Array
from restitution.errors import InputError
from restitution.identification.bounce_moduli import LOSS, EffectiveModuli, moduli_of_rebounds
from restitution.identification.impacts import Rebounds
from restitution.identification.observations import Noise, Observations, number_or_none
from restitution.identification.records import BounceTimes, Flight
from restitution.identification.sound import Picks, Recording
from restitution.impact.problem import STANDARD_GRAVITY
from restitution.quantities import BOUNCES, INPUTS, MODULI, NUMBER, OUTPUTS, Quantity, check_single, dataset
from restitution.result import Result, Summary, Table
from restitution.units import TIME, scaled_unit

if TYPE_CHECKING:
    import xarray as xr

UNKNOWN = 1.0, 1e4
"""Radius [m] and mass [kg] of a solid ball whose size is not known."""
# Contact times on a half-space fall as this power of the velocity.
_POWER = -0.2
_COLUMNS = {
    "time": Quantity("time", TIME, "time of touch", r"$t$"),
    "time_error": Quantity("time_error", TIME, "standard error of the time of touch"),
    "signal_to_noise": Quantity("signal_to_noise", NUMBER, "signal to noise"),
    "velocity": INPUTS["velocity"],
    "height": BOUNCES["height"],
    "restitution_coefficient": OUTPUTS["restitution_coefficient"],
    "restitution_coefficient_error": Quantity("restitution_coefficient_error", NUMBER, "standard error of e"),
    "loss_tangent": MODULI["loss_tangent"],
    "loss_tangent_error": Quantity("loss_tangent_error", NUMBER, "standard error of the loss tangent"),
    "angular_frequency": MODULI["angular_frequency"],
    "storage_modulus": MODULI["storage_modulus"]._replace(words="storage modulus E*'"),
    "loss_modulus": MODULI["loss_modulus"]._replace(words="loss modulus E*''"),
}
_HEADS = {
    "time": "time", "signal_to_noise": "signal to noise", "velocity": "velocity", "height": "height",
    "restitution_coefficient": "e", "loss_tangent": "tan delta", "angular_frequency": "frequency",
    "storage_modulus": "E*'", "loss_modulus": "E*''",
}  # fmt: skip


class Ball(NamedTuple):
    """What is known of a ball besides its bounces, in SI; None if it is not known."""

    radius: float | None = None
    mass: float | None = None
    contact_time: float | None = None  # of the first bounce with a restitution coefficient
    gravity: float = STANDARD_GRAVITY
    air_density: float = 1.2
    drag_coefficient: float = 0.47

    def checked(self) -> Ball:
        """Return the same ball; refuse a number out of its range."""
        return Ball(
            number_or_none("radius", self.radius),
            number_or_none("mass", self.mass),
            None if self.contact_time is None else checks.single_positive("contact_time", self.contact_time, "s"),
            check_single("gravity", self.gravity),
            checks.single_nonnegative("air_density", self.air_density, "kg/m^3"),
            checks.single_nonnegative("drag_coefficient", self.drag_coefficient),
        )

    @property
    def flight(self) -> Flight:
        """Free flight, with the drag of air if radius and mass are known."""
        if self.radius is None or self.mass is None:
            return Flight(self.gravity, 0.0)
        drag = 0.5 * self.air_density * self.drag_coefficient * math.pi * self.radius**2 / self.mass
        return Flight(self.gravity, drag)


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredBounces(Result):
    """Measured bounces of a ball, from `read_bounces`: arrays of shape (n,), one entry for each touch, in SI.

    An entry is NaN where it was not measured: the first touch of a sound has no velocity, the first and the last one
    have no restitution coefficient, and the moduli need a mass, a radius and a contact time.

    Attributes
    ----------
    time, time_error : array
        Instants of touch [s] and their standard errors.
    signal_to_noise : array
        Peak of each touch over the standard deviation of the noise, both after the filter [-].
    velocity : array
        Impact velocity v [m/s].
    height : array
        Height [m] that the ball reaches after the bounce.
    restitution_coefficient, restitution_coefficient_error : array
        e [-] and its standard error from the measurement.
    loss_tangent, loss_tangent_error : array
        tan delta [-] at 1.13 pi over the contact time, and its standard error; see `effective_moduli`.
    angular_frequency : array
        1.13 pi over the contact time [rad/s]. From one contact time T those of the other bounces follow as v^(-1/5).
    storage_modulus, loss_modulus : array
        Parts of the reduced modulus E* [Pa], of bounces whose contact time was measured.
    statements : tuple of str
        Errors of the formulas, and what is neglected.
    recording : Recording or None
        The sound.
    observations : Observations or None
        The same data for `identify`; None if radius or mass is not known, or with less than four instants.
    """

    _numbers = (*_COLUMNS, "statements", "warnings")
    _picture = "bounces.measured"

    time: Array
    time_error: Array
    signal_to_noise: Array
    velocity: Array
    height: Array
    restitution_coefficient: Array
    restitution_coefficient_error: Array
    loss_tangent: Array
    loss_tangent_error: Array
    angular_frequency: Array
    storage_modulus: Array
    loss_modulus: Array
    statements: tuple[str, ...]
    warnings: tuple[str, ...] = ()
    recording: Recording | None = None
    observations: Observations | None = None

    def to_dataset(self) -> xr.Dataset:
        """Return a dataset over `touch`, with units; columns without a number are left out."""
        columns: dict[str, tuple[Any, Quantity]] = {
            "touch": (np.arange(1, self.velocity.size + 1), Quantity("touch", NUMBER, "number of the touch"))
        }
        columns |= {name: (values, _COLUMNS[name]) for name, values in self._known.items()}
        return dataset("touch", columns, {"statements": "\n".join(self.statements)})

    @property
    def _known(self) -> dict[str, Array]:
        columns = {name: getattr(self, name) for name in _COLUMNS}
        return {name: values for name, values in columns.items() if np.any(np.isfinite(values))}

    def summary(self, title: str = "") -> Summary:
        """Return a table of the touches, which `print` and notebooks show."""
        measured = self._known
        heads, texts = ["touch"], [[str(n + 1) for n in range(self.velocity.size)]]
        for name, values in measured.items():
            if name.endswith("_error"):
                continue
            factor, unit = scaled_unit(values[np.isfinite(values)], _COLUMNS[name].unit)
            heads.append(f"{_HEADS[name]} [{unit}]" if unit else _HEADS[name])
            errors = measured.get(f"{name}_error", np.full(values.size, np.nan))
            texts.append([_shown(x * factor, dx * factor) for x, dx in zip(values, errors, strict=True)])
        table = Table(tuple(heads), list(zip(*texts, strict=True)))
        return Summary(title or "Measured bounces", table, self.statements, warnings=self.warnings)

    @property
    def _short(self) -> str:
        e = self.restitution_coefficient[np.isfinite(self.restitution_coefficient)]
        return f"{self.velocity.size} touches, e from {e.min():.3g} to {e.max():.3g}"


def from_instants(picks: Picks, ball: Ball, recording: Recording | None = None) -> MeasuredBounces:
    """Return the bounces at instants of touch; without a contact time, the contact counts as flight.

    An interval is a contact of duration T and a flight. The body leaves from a depth of about v T (1 - e)/3, and the
    weight and the drag of air act on its way.
    """
    time, error = picks.time, picks.error
    n, flight = time.size, ball.flight
    interval = np.diff(time)
    contact, depth = np.zeros(n - 1), np.zeros(n - 1)
    up = down = e = np.empty(0)
    for _ in range(4 if ball.contact_time is not None else 1):
        free = interval - contact
        if np.any(free <= 0.3 * interval):
            rule = f"must be much shorter than the shortest interval, {interval.min():.3g} s"
            raise InputError("contact_time", ball.contact_time, rule, "s")
        up = flight.launch(free, depth)
        down = flight.fall(up, depth)[1]
        e = up[1:] / down[:-1]
        if ball.contact_time is not None:
            # The first touch has no velocity; that of the second one times e is that of the third.
            speed = np.concatenate([down[:1] / e[0], down[:-1]])
            contact = ball.contact_time * (speed / speed[1]) ** _POWER
            losses = 1.0 - np.concatenate([e[:1], e])
            depth = speed * contact * np.clip(losses, 0.0, 1.0) / 3.0
    shares = [error[2:] / interval[1:], error[1:-1] * (1.0 / interval[1:] + 1.0 / interval[:-1])]
    e_error = e * np.sqrt(shares[0] ** 2 + shares[1] ** 2 + (error[:-2] / interval[:-1]) ** 2)
    lines = list[str]()
    if ball.contact_time is None:
        shift = float(np.max(e * 1e-3 * (1.0 / interval[1:] - 1.0 / interval[:-1])))
        lines.append(
            f"The contact counts as flight: each millisecond of a contact time raises e by up to {shift:.2g}. "
            "Give a contact time."
        )
    if flight.drag == 0.0 and ball.air_density > 0.0:
        lines.append("The drag of air is neglected: it needs radius and mass.")
    whole = slice(1, n - 1)
    columns = _empty(n)
    columns |= {"time": time, "time_error": error, "signal_to_noise": picks.signal_to_noise}
    columns["velocity"][1:] = down
    columns["height"][:-1] = (np.log1p(up**2 * flight.drag / ball.gravity) / (2.0 * flight.drag) if flight.drag
                              else up**2 / (2.0 * ball.gravity)) - depth  # fmt: skip
    columns["restitution_coefficient"][whole], columns["restitution_coefficient_error"][whole] = e, e_error
    times = np.full(n - 2, np.nan)
    if ball.contact_time is not None:
        times[0] = ball.contact_time
        columns["angular_frequency"][whole] = 1.13 * math.pi / contact[1:]
    good = e <= 1.0
    if not np.any(good):
        raise InputError("time", rule="must have shorter and shorter intervals: each e would be above 1")
    durations = times[good] if np.any(np.isfinite(times[good])) else None
    # Without a size only e and the loss tangent are kept, which are the same for any ball.
    radius, mass = ball.radius or UNKNOWN[0], ball.mass or UNKNOWN[1]
    rebounds = Rebounds(down[:-1][good], e[good], radius=radius, mass=mass, contact_time=durations)
    is_known = ball.radius is not None and ball.mass is not None
    moduli = moduli_of_rebounds(rebounds)
    _take(columns, moduli, np.flatnonzero(good) + 1, sized=is_known)
    return MeasuredBounces(
        **columns, statements=(*lines, *moduli.statements), recording=recording,
        warnings=() if np.all(good) else (f"e is above 1 at touch {int(np.argmin(good)) + 2}: a touch is missing",),
        observations=_instants(picks, ball) if is_known and n >= 4 and np.all(good) else None,
    )  # fmt: skip


def _instants(picks: Picks, ball: Ball) -> BounceTimes:
    has_errors = bool(np.all(np.isfinite(picks.error)))
    return BounceTimes(
        picks.time, radius=ball.radius, mass=ball.mass, gravity=ball.gravity, air_density=ball.air_density,
        drag_coefficient=ball.drag_coefficient, noise=Noise(time=picks.error) if has_errors else None,
    )  # fmt: skip


def from_rebounds(rebounds: Rebounds, *, sized: bool) -> MeasuredBounces:
    """Return the bounces of measured rebounds; `sized` tells whether their mass and radius are known."""
    moduli = moduli_of_rebounds(rebounds)
    columns = _empty(rebounds.velocity.size)
    columns |= {"velocity": rebounds.velocity, "restitution_coefficient": rebounds.restitution_coefficient}
    error = rebounds.noise.of("restitution_coefficient", rebounds.restitution_coefficient)
    blur = rebounds.noise.of("velocity", rebounds.velocity)
    if error is not None:
        of_velocity = 0.0 if blur is None else rebounds.restitution_coefficient * blur / rebounds.velocity
        columns["restitution_coefficient_error"] = np.hypot(error, of_velocity)
    _take(columns, moduli, np.arange(rebounds.velocity.size), sized=sized)
    fields: dict[str, Any] = {**columns, "observations": rebounds if sized else None}
    return MeasuredBounces(statements=moduli.statements, **fields)


def _shown(value: float, error: float) -> str:
    """Return a number as text, with the last digits of its standard error in parentheses if that is known."""
    if not math.isfinite(value):
        return "-"
    if not (math.isfinite(error) and error > 0.0):
        return f"{value:.4g}"
    digits = max(0, 1 - math.floor(math.log10(error)))
    return f"{value:.{digits}f}({round(error * 10**digits)})"


def _empty(n: int) -> dict[str, Array]:
    return {name: np.full(n, np.nan) for name in _COLUMNS}


def _take(columns: dict[str, Array], moduli: EffectiveModuli, places: Any, *, sized: bool) -> None:
    """Put the moduli of bounces at their places; those that need radius and mass only where these are known."""
    columns["loss_tangent"][places] = moduli.loss_tangent
    columns["loss_tangent_error"] = (
        LOSS * columns["restitution_coefficient_error"] / columns["restitution_coefficient"]
    )
    there = np.isfinite(moduli.angular_frequency)
    columns["angular_frequency"][places[there]] = moduli.angular_frequency[there]
    if sized:
        columns["storage_modulus"][places], columns["loss_modulus"][places] = (
            moduli.storage_modulus,
            moduli.loss_modulus,
        )
