"""Records of one ball: force or acceleration over time, and instants of bounces."""

from __future__ import annotations

import math
import warnings
from typing import Any, NamedTuple

import numpy as np

from restitution import checks, quantities
from restitution.checks import Array
from restitution.contact.geometry import Geometry
from restitution.contact.profiles import Parabola
from restitution.errors import InputError, RestitutionWarning
from restitution.identification.impacts import Rebounds
from restitution.identification.observations import (
    Curve,
    ForceRecord,
    Noise,
    Nuisance,
    Observations,
    columns_over_time,
    modulus,
    noise_of,
    number_or_none,
    profile_of,
)
from restitution.identification.trial_impacts import bodies_of, impacts_of, trials
from restitution.impact.batch import Batch
from restitution.impact.problem import STANDARD_GRAVITY
from restitution.impact.status import Status
from restitution.material.fit import DynamicTable
from restitution.material.viscoelastic import Material

# Force histories: force or acceleration over time, measured during one impact.


_RTOL = 1e-9
# A sample above the first share of the peak belongs to the contact; a sample outside must be below the second share.
_TOUCHING, _HIGH = 0.1, 0.5
_FEWEST = 8
# Tolerance of the impulse, for noise, a coarse record and an uncertain gain.
_SLACK = 0.1
# Typical restitution coefficient of balls, for a start.
_TYPICAL_E = 0.6


class OneBall(Observations):
    """Records of one body, whose impacts are solved for many materials."""

    def _set_ball(
        self, radius: Any, profile: Any, mass: Any, temperature: Any, label: str, gravity: float = 0.0
    ) -> None:
        self.label, self.temperature = label, number_or_none("temperature", temperature)
        self.mass = quantities.check_single("mass", mass)
        self.profile = profile_of(number_or_none("radius", radius), profile)
        if np.ndim(self.profile.stiffness_radius(0.0)):
            raise InputError("profile", rule="must be that of one body")
        self._body = bodies_of(impacts_of(self.profile, self.mass, 1.0, self.mass * gravity))

    def _trials(self, materials: Material, velocity: Any) -> Batch:
        """Return impacts on materials of shape (m, 1) with velocities that broadcast against them."""
        return trials(self._body, modulus(materials, self.temperature), velocities=velocity)


class ForceHistory(OneBall, ForceRecord):
    """Force over time of one impact of a rigid body on a viscoelastic half-space.

    Parameters
    ----------
    time : array_like
        Ascending times [s], shape (n,), from any origin: the time of first touch is estimated.
    force : array_like, optional
        Measured normal force [N], positive in contact, shape (n,). The baseline is estimated.
    acceleration : array_like, optional
        Measured deceleration of the body F/m [m/s^2] instead of the force.
    radius : float, optional
        Radius R [m] of a ball; or give a `profile`.
    profile : Geometry, optional
        Profile of the body, instead of the radius.
    mass : float
        Mass m [kg].
    velocity : float, optional
        Impact velocity v [m/s]; estimated by default.
    gain : float or None
        Measured value over true value of the force; None to estimate an unknown gain. The data do not
        determine both gain and velocity: with E sqrt(v) and gain v, all values stay the same.
    ar1 : float
        Correlation of the noise of successive samples, in [0, 1), for example from a filter; the sampling must then be
        regular. The residuals are whitened with it.
    temperature : float, optional
        Temperature [K], for a model with a `shift`.
    noise : Noise, optional
        Standard deviation of `force` or of `acceleration`; a relative one refers to the peak of the record. Without
        it the size of the noise is estimated.
    label : str
        Name of the data in messages.

    Raises
    ------
    InputError
        If a number is out of range, or the record does not contain one whole contact: it has no end, is saturated,
        jumps, has two contacts, or its impulse is not between m v and 2 m v.

    Warns
    -----
    RestitutionWarning
        If the noise outside the contact is correlated and `ar1` is 0.

    Examples
    --------
    >>> import restitution as rs
    >>> rubber = rs.standard_solid(1e6, 1e7, 1e4, poisson_ratio=0.5)
    >>> impact = rs.Impact(rubber, rs.Parabola(0.01), mass=0.033, velocity=1.0)
    >>> history = rs.solve(impact).sample(n_points=100)
    >>> record = ForceHistory(history["time"], history["force"], radius=0.01, mass=0.033, velocity=1.0)
    >>> record.size, [nuisance.name for nuisance in record.nuisances]
    (100, ['first_touch'])
    """

    def __init__(
        self,
        time: Any,
        force: Any = None,
        *,
        acceleration: Any = None,
        radius: Any = None,
        profile: Geometry | None = None,
        mass: Any,
        velocity: Any = None,
        gain: Any = 1.0,
        ar1: Any = 0.0,
        temperature: Any = None,
        noise: Noise | None = None,
        label: str = "",
    ) -> None:
        if (force is None) == (acceleration is None):
            raise InputError("force, acceleration", rule="exactly one must be given")
        if gain is None and velocity is None:  # both change the height of the force alone
            rule = "must not both be unknown: the record is the same for all E sqrt(v) = const and gain v = const"
            raise InputError("gain, velocity", rule=rule)
        self._set_ball(radius, profile, mass, temperature, label)
        self.velocity = number_or_none("velocity", velocity)
        self.gain = None if gain is None else checks.single_positive("gain", gain)
        self.ar1 = checks.single("ar1", checks.nonnegative("ar1", ar1))
        if self.ar1 >= 1.0:
            raise InputError("ar1", self.ar1, "must be in [0, 1)")
        name = "force" if acceleration is None else "acceleration"
        unit = quantities.MEASURED[name].unit
        measured = force if acceleration is None else acceleration
        self.time, values = columns_over_time({"time": (time, "s"), name: (measured, unit)})
        steps = np.diff(self.time)
        if self.ar1 and steps.max() > 1.01 * steps.min():
            raise InputError("time", rule="must be regular with ar1", unit="s")
        self._pulse = pulse = _pulse_of(name, unit, self.time, values, self.profile)
        self._name, self._factor = name, 1.0 if acceleration is None else self.mass
        self._check_size()
        deviations = self._deviations_of(noise_of(noise, [name]), values) * self._factor
        baseline = np.full(values.size, self._factor), unit
        self._set_record(self.time, values * self._factor, deviations, self.gain, self.ar1, baseline=baseline)
        share = float(np.median(self.deviations)) / (pulse.height * self._factor * math.sqrt(pulse.samples))
        share = 0.01 if self.scaled else share
        start, duration = pulse.first_touch, pulse.duration
        self.nuisances = (
            Nuisance("first_touch", "s", start, start - 0.5 * duration, pulse.peak_time, 0.3 * share * duration),
        )
        if self.velocity is None:
            guess, low, high = self._velocity_guess()
            self.nuisances += (Nuisance("velocity", quantities.VELOCITY.unit, guess, low, high, share * guess),)

    def _check_size(self) -> None:
        """Refuse a duration or an impulse that is impossible for such an impact."""
        pulse, velocity = self._pulse, self.velocity
        radius = getattr(self.profile, "radius", None)
        if velocity is not None and radius is not None and pulse.duration * velocity > radius:
            rule = "must be in s: the body would move by more than its radius during contact"
            raise InputError("time", rule=f"{rule} of {pulse.duration:.3g}", unit="s")
        if self.gain is None or velocity is None:
            return
        ratio = self._impulse / (self.mass * velocity)
        if not 1.0 - _SLACK < ratio < 2.0 * (1.0 + _SLACK):
            rule = f"must have an impulse from m v to 2 m v, not {ratio:.3g} m v; check units, or give gain=None"
            raise InputError(self._name, rule=rule)

    def _velocity_guess(self) -> tuple[float, float, float]:
        """Return the impact velocity [m/s] that the record shows, and its bounds.

        The impulse is m v (1 + e). The depth at separation, v T less the double integral of F/m, is about
        v T (1 - e)/3.
        """
        gained = self._impulse / self.mass
        mean = gained * self._pulse.path / (self._pulse.impulse * self._pulse.duration)
        guess = min(max(3.0 * mean - gained, 0.51 * gained), 0.9 * gained)
        return guess, 0.5 * gained / (1.0 + _SLACK), gained * (1.0 + _SLACK)

    def _deviations_of(self, noise: Noise, values: Array) -> Array:
        """Return standard deviations in the unit of the record; warn of correlated noise."""
        stated = noise.of(self._name, values, self._pulse.height)
        self.scaled = stated is None
        # The first touch is only a guess.
        margin = 0.1 * self._pulse.duration
        outside = self.time - self._pulse.first_touch
        parts = [values[outside < -margin], values[outside > self._pulse.duration + margin]]
        parts = [part - part.mean() for part in parts if part.size > 5]
        count, square = sum(part.size for part in parts), sum(float(part @ part) for part in parts)
        rounding = count * (1e-9 * np.abs(values).max()) ** 2
        if self.ar1 == 0.0 and count >= 20 and square > rounding:
            correlation = sum(float(part[1:] @ part[:-1]) for part in parts) / square
            if correlation > 3.0 / math.sqrt(count):
                message = (
                    f"{self._name}: the noise outside the contact is correlated ({correlation:.2g} between "
                    f"neighbours), and errors would be too small; give ar1={correlation:.2g}"
                )
                warnings.warn(RestitutionWarning("correlated_noise", message), stacklevel=4)
        return np.ones(values.size) if stated is None else stated

    @property
    def _impulse(self) -> float:
        """Impulse [N s] of the record, for the given gain."""
        return self._pulse.impulse * self._factor / (self.gain or 1.0)

    def forces(self, materials: Material, nuisances: Array) -> Array:
        """Return forces [N] at the times of the record, without gain and baseline; NaN without separation."""
        velocity = nuisances[:, 1:2] if self.velocity is None else self.velocity
        return self._trials(materials, velocity).sample_forces(self.time - nuisances[:, :1], _RTOL)

    def window(self) -> tuple[float, float]:
        """Return half and twice the angular frequency pi/T of the contact time T."""
        omega = math.pi / self._pulse.duration
        return 0.5 * omega, 2.0 * omega

    def effective_moduli(self) -> DynamicTable | None:
        """Return moduli from the contact time and the impulse of a ball."""
        if not isinstance(self.profile, Parabola):
            return None
        if self.gain is None:
            e, velocity = _TYPICAL_E, float(self.velocity or 1.0)
        else:
            velocity = self.velocity or self._velocity_guess()[0]
            e = min(max(self._impulse / (self.mass * velocity) - 1.0, 0.15), 0.99)
        radius, duration = self.profile.radius, self._pulse.duration
        return Rebounds([velocity], [e], radius=radius, mass=self.mass, contact_time=[duration]).effective_moduli()


class _Pulse(NamedTuple):
    """The one contact of a record, in the unit of the record."""

    baseline: float
    height: float  # of the peak above the baseline
    samples: int  # number of samples in contact
    first_touch: float  # [s]
    peak_time: float  # [s]
    duration: float  # [s]
    impulse: float  # integral of the force over time
    path: float  # the same of the impulse


def _pulse_of(name: str, unit: str, time: Array, values: Array, profile: Geometry) -> _Pulse:
    """Find the contact of a record; refuse a record without exactly one contact, whole and undamaged."""
    if values.size < 2 * _FEWEST:
        raise InputError(name, rule=f"must have at least {2 * _FEWEST} samples, not {values.size}")
    baseline = float(min(np.median(values[:3]), np.median(values[-3:])))
    peak = int(np.argmax(values))
    height = float(values[peak]) - baseline
    if height <= 0.0 or baseline - float(values.min()) > height:
        raise InputError(name, rule="must rise from its baseline to a positive peak; check the sign")
    share = (values - baseline) / height
    _refuse_damage(name, unit, values, share, peak)
    off = np.flatnonzero(share < _TOUCHING)
    if not np.any(off > peak):
        raise InputError(name, rule="must return to its baseline: the record has no end of the contact")
    left, right = int(np.max(off[off < peak], initial=-1)) + 1, int(np.min(off[off > peak]))
    if right - left < _FEWEST:
        rule = f"must have at least {_FEWEST} samples in contact, not {right - left}"
        raise InputError(name, rule=rule)
    if np.any(share[:left] > _HIGH) or np.any(share[right:] > _HIGH):
        raise InputError(name, rule="must have one contact: it rises above half of its peak more than once")
    # The force begins, and roughly ends, as depth^(1 + p/2).
    exponent = profile.path_exponent
    power = 1.0 / (1.0 + 0.5 * (1.0 if exponent is None else float(np.asarray(exponent))))
    before = min(_root(time[left : peak + 1], share[left : peak + 1], power), float(time[left]))
    end = max(_root(time[right - 1 : peak - 1 : -1], share[right - 1 : peak - 1 : -1], power), float(time[right - 1]))
    span = float(time[right] - time[left])
    first, end = max(before, float(time[left]) - 0.5 * span), min(end, float(time[right]) + 0.5 * span)
    # Samples beyond a margin on both sides are outside the contact.
    margin = (right - left) // 4
    before, after = max(left - margin, 0), right + margin
    outside = np.concatenate([values[:before], values[after:]])
    if outside.size >= 5:
        baseline = float(np.median(outside))
    force, moments = values[before:after] - baseline, time[before:after]
    impulse = float(np.trapezoid(force, moments))
    path = float(np.trapezoid(force * (end - moments), moments))
    return _Pulse(
        baseline, float(values[peak]) - baseline, right - left, first, float(time[peak]), end - first, impulse, path,
    )  # fmt: skip


def _root(time: Array, share: Array, power: float) -> float:
    """Return the time at which the flank of a peak begins, from samples in the order from its foot to the top."""
    flank = share < 0.7
    if np.count_nonzero(flank) < 2:
        return float(time[0])
    slope, level = np.polyfit(time[flank] - time[-1], share[flank] ** power, 1)
    return float(time[-1] - level / slope) if slope else float(time[0])


def _refuse_damage(name: str, unit: str, values: Array, share: Array, peak: int) -> None:
    """Refuse a record with a cut-off peak or with single samples out of line."""
    top = values == values[peak]
    first, last = int(np.argmax(top)), top.size - 1 - int(np.argmax(top[::-1]))
    width = last - first + 1
    if width >= 4 and int(top.sum()) > 0.8 * width:
        # A rounded peak falls by about four steps of the rounding within its width.
        step = np.diff(np.unique(values)).min()
        reach = width // 2 + 1
        beside = values[[max(first - reach, 0), min(last + reach, values.size - 1)]]
        if float(values[peak] - beside.max()) > 8.0 * step:
            rule = f"must not be saturated: {width} samples have this same largest value"
            raise InputError(name, float(values[peak]), rule, unit, index=(first,))
    smooth = (4.0 * (share[1:-3] + share[3:-1]) - share[:-4] - share[4:]) / 6.0
    # A damaged sample is farther from the cubic through its neighbours than its neighbours are from each other.
    off = np.abs(share[2:-2] - smooth)
    lone = (off > 0.25) & (np.abs(share[3:-1] - share[1:-3]) < off)
    if np.any(lone):
        place = int(np.argmax(np.where(lone, off, 0.0))) + 2
        raise InputError(name, float(values[place]), "must not jump: this sample is out of line", unit, index=(place,))


# Instants at which a falling body touches the ground, for instance from the sound of a bouncing ball.

_AIR = 1.2
# A first flight that is lower or higher [m] than these is refused.
_LOWEST, _HIGHEST = 1e-6, 100.0
# Assumed deviation of ln e from a parabola over ln v.
_SMOOTH = 3e-3


class Flight(NamedTuple):
    """Vertical flights from a depth below the surface to the surface; all arguments broadcast."""

    gravity: float  # g [m/s^2]
    drag: float  # k of the drag k v^2 per mass [1/m]

    def landing(self, height: Any) -> Array:
        """Return the velocity [m/s] at the surface after a fall from rest at a height [m]."""
        if self.drag == 0.0:
            return np.sqrt(2.0 * self.gravity * np.asarray(height))
        return np.sqrt(-np.expm1(-2.0 * self.drag * np.asarray(height)) * self.gravity / self.drag)

    def fall(self, up: Array, depth: Array) -> tuple[Array, Array]:
        """Return the duration [s] of flights with these velocities [m/s] at the start, and velocity at the end.

        A flight that does not reach the surface ends at its highest point.
        """
        g, k = self.gravity, self.drag
        if k == 0.0:
            down = self.landing(np.maximum(0.5 * up * up / g - depth, 0.0))
            return (up + down) / g, down
        down = self.landing(np.maximum(0.5 * np.log1p(up * up * k / g) / k - depth, 0.0))
        root = math.sqrt(k / g)
        with np.errstate(divide="ignore", invalid="ignore"):  # a landing at the terminal velocity takes for ever
            return (np.arctan(up * root) + np.arctanh(down * root)) / math.sqrt(g * k), down

    def launch(self, duration: Array, depth: Array) -> Array:
        """Return the velocity [m/s] at the start of flights with this duration [s]."""
        up = 0.5 * self.gravity * duration + depth / duration
        if self.drag == 0.0:
            return up
        for _ in range(6):
            time, down = self.fall(up, depth)
            slope = (1.0 + up / np.maximum(down, 1e-3 * up)) / (self.gravity + self.drag * up * up)
            up = np.maximum(up + (duration - time) / slope, 0.1 * up)
        return up


class BounceTimes(OneBall):
    """Instants of touch of a body that falls and bounces on a viscoelastic half-space.

    Parameters
    ----------
    time : array_like
        Instants [s] of touch in ascending order, at least 4, without a missing bounce.
    radius : float, optional
        Radius R [m] of a ball; or give a `profile`.
    profile : Geometry, optional
        Profile of the body, instead of the radius.
    mass : float
        Mass m [kg]. Its weight m g also acts during contact.
    gravity : float
        Acceleration of free fall g [m/s^2].
    air_density : float
        Density of the air [kg/m^3], 1.2 at room temperature; 0 for no drag.
    drag_coefficient : float
        Coefficient c of the drag c rho A v^2/2 on the area A = pi R^2: 0.47 for a smooth sphere at Reynolds numbers
        from 1e3 to 2e5 (Hoerner, Fluid-Dynamic Drag, 1965).
    drop_height : float, optional
        Height [m] of the release from rest over the undeformed surface, if known.
    temperature : float, optional
        Temperature [K], for a model with a `shift`.
    noise : Noise, optional
        Standard deviation of `time`, the same for all instants or one for each, and of `drop_height`. Without a noise
        of `time` its size is estimated.
    label : str
        Name of the data in messages.

    Raises
    ------
    InputError
        If a number is out of range, the instants are not ascending, or a flight is longer than the one before.

    Warns
    -----
    RestitutionWarning
        If the drag is neglected, but changes the data by more than their noise.

    Notes
    -----
    An interval between two touches is a contact of duration T and a free flight of duration F, from the depth d at
    separation to the surface. With T and d of the trial material, the velocities at the start and at the end of the
    flight are ``g F/2 + d/F`` and ``g F/2 - d/F``, or those of a flight with quadratic drag. The second velocity is
    that of the next impact, and the material predicts the next interval from it. Neighbouring predictions have
    correlated errors; the Cholesky factor of their covariance whitens the residuals. The data determine the loss well,
    but a stiffness only if the contacts are long.

    Examples
    --------
    >>> sound = BounceTimes([0.0, 0.400, 0.722, 0.982, 1.192], radius=0.01, mass=0.033)
    >>> sound.size
    3
    """

    def __init__(
        self,
        time: Any,
        *,
        radius: Any = None,
        profile: Geometry | None = None,
        mass: Any,
        gravity: Any = STANDARD_GRAVITY,
        air_density: Any = 0.0,
        drag_coefficient: Any = 0.47,
        drop_height: Any = None,
        temperature: Any = None,
        noise: Noise | None = None,
        label: str = "",
    ) -> None:
        self.gravity = quantities.check_single("gravity", gravity)
        self._set_ball(radius, profile, mass, temperature, label, self.gravity)
        self.drop_height = number_or_none("drop_height", drop_height)
        (self.time,) = columns_over_time({"time": (time, "s")})
        if self.time.size < 4:
            raise InputError("time", rule=f"must have at least 4 instants, not {self.time.size}")
        self.intervals = np.diff(self.time)
        height = self.gravity * float(self.intervals[0]) ** 2 / 8.0
        if not _LOWEST < height < _HIGHEST:
            rule = f"must be in s: the body would rise by {height:.2g} m after the first touch"
            raise InputError("time", float(self.intervals[0]), rule, "s", index=(1,))
        density = checks.single_nonnegative("air_density", air_density, "kg/m^3")
        coefficient = checks.single_nonnegative("drag_coefficient", drag_coefficient)
        self.flight = Flight(self.gravity, self._drag(density, coefficient, "air_density"))
        self._set_noise(noise_of(noise, ["time"], [] if self.drop_height is None else ["drop_height"]))
        longer = np.diff(self.intervals)
        if np.any(longer > (0.02 * self.intervals[:-1] if self.scaled else 15.0 * self._instants[1:-1])):
            place = int(np.argmax(longer)) + 2
            rule = "must not follow a longer flight than the one before: a touch is missing, or there is one too many"
            raise InputError("time", float(self.time[place]), rule, "s", index=(place,))
        if density == 0.0 and not self.scaled:
            self._warn_of_drag(coefficient)

    def __repr__(self) -> str:
        return f"BounceTimes({self.time.size} touches)"

    def _drag(self, density: float, coefficient: float, field: str) -> float:
        """Return the drag per mass and squared velocity [1/m]."""
        if density == 0.0:
            return 0.0
        radius = getattr(self.profile, "radius", None)
        if radius is None or not type(self.profile).body_radius:
            raise InputError(field, density, "must be 0 for a profile without the radius of the body", "kg/m^3")
        return 0.5 * density * coefficient * math.pi * float(radius) ** 2 / self.mass

    def _set_noise(self, noise: Noise) -> None:
        if "drop_height" in noise.deviations and "time" not in noise.deviations:
            raise InputError("noise.time", rule="must be given, as that of the drop height is")
        if isinstance(noise.deviations.get("time"), (str, tuple)):
            raise InputError(
                "noise.time", noise.deviations["time"], "must be a number: times have no natural zero", "s"
            )
        stated = noise.of("time", self.time)
        self.scaled = stated is None
        instants = np.ones(self.time.size) if stated is None else stated
        slopes = _slopes(self.intervals)
        n = self.intervals.size
        rows = np.zeros((n, n + 1))
        places = np.arange(1, n)
        rows[places, places - 1], rows[places, places] = -slopes, 1.0 + slopes
        rows[0, 0] = 1.0
        rows[np.arange(n), np.arange(n) + 1] = -1.0
        covariance = rows * instants**2 @ rows.T
        if self.drop_height is None:
            covariance = covariance[1:, 1:]
        else:
            sd = noise.of("drop_height", np.array(self.drop_height))
            # The first interval grows with the square root of the height.
            share = 0.0 if sd is None else 0.5 * float(self.intervals[0]) * float(sd) / self.drop_height
            covariance[0, 0] += share**2
        self._whitening = np.linalg.inv(np.linalg.cholesky(covariance))
        self._instants = instants

    def _warn_of_drag(self, coefficient: float) -> None:
        """Warn if the neglected drag of air changes the data by more than their noise."""
        if not type(self.profile).body_radius or coefficient == 0.0:
            return
        flight, depth = self.flight._replace(drag=self._drag(_AIR, coefficient, "")), np.zeros(1)
        with np.errstate(all="ignore"):  # a hollow ball would not fly so long
            up = flight.launch(self.intervals, depth)
            lost = 1.0 - flight.fall(up, depth)[1] / up
        worst = float(np.max(lost[:-1] * self.intervals[1:] / self._instants[1:-1]))
        if worst > 1.0:
            message = (
                f"drag: the air shortens an interval by {worst:.2g} standard deviations of an instant; give "
                f"air_density={_AIR}"
            )
            warnings.warn(RestitutionWarning("drag", message), stacklevel=4)

    @property
    def size(self) -> int:
        """Number of predicted intervals; the first one needs a drop height."""
        return self.intervals.size - (self.drop_height is None)

    def _solved(self, materials: Material, velocities: Array) -> list[Array]:
        """Return restitution coefficients, contact times and depths at separation, shape (m, n); NaN if a solve fails.

        All are 0 for a captured body, so that its prediction is wrong, but finite.
        """
        outcomes = self._trials(materials, velocities).solve(_RTOL, workers=1)
        names = ("restitution_coefficient", "contact_time", "residual_indentation_depth")
        rest = np.where(outcomes["status"] >= Status.TOO_MANY_STEPS, np.nan, 0.0)
        free = outcomes["status"] == Status.SEPARATED
        return [np.where(free, outcomes[name], rest).reshape(velocities.shape) for name in names]

    def _impacts(self, materials: Material) -> tuple[Array, list[Array]]:
        """Return velocities of impact near those of the data, shape (m, n), and the outcomes there."""
        rough = 0.5 * self.gravity * np.append(self.intervals[0] ** 2 / self.intervals[1], self.intervals[:-1])
        if self.drop_height is not None:
            rough[0] = float(self.flight.landing(self.drop_height))
        rough = np.broadcast_to(rough, (materials.shape[0], rough.size))
        velocities = self._velocities(rough, *self._solved(materials, rough))
        return velocities, self._solved(materials, velocities)

    def predicted(self, materials: Material) -> Array:
        """Return all intervals [s] but the first, and with a drop height also the first, shape (m, n)."""
        velocities, (e, times, depths) = self._impacts(materials)
        intervals = times + self.flight.fall(e * velocities, depths)[0]
        return _carried(velocities, intervals, self._velocities(velocities, e, times, depths))[:, -self.size :]

    def _velocities(self, near: Array, e: Array, times: Array, depths: Array) -> Array:
        """Return velocities of impact, from the intervals, and from outcomes at velocities near them."""
        velocities = near
        # A fixed point: the outcomes change slowly with the velocity.
        for _ in range(3):
            T, d = _carried(near, times, velocities), _carried(near, depths, velocities)
            up = self.flight.launch(np.maximum(self.intervals - T, 0.1 * self.intervals), d)
            down = self.flight.fall(up, d)[1]
            first = near[:, :1]
            if self.drop_height is None:
                first = up[:, :1] / np.maximum(_carried(near, e, velocities)[:, :1], 0.05)
            velocities = np.clip(np.hstack([first, down[:, :-1]]), 0.2 * near, 5.0 * near)
        return velocities

    def residuals(self, materials: Material, nuisances: Array) -> Array:
        """Return residuals of the intervals, whitened."""
        return (self.predicted(materials) - self.intervals[-self.size :]) @ self._whitening.T

    def curves(self, materials: Material, nuisances: Array) -> list[Curve]:
        """Return measured and predicted intervals over the time of their first touch."""
        measured, start = self.intervals[-self.size :], self.time[:-1][-self.size :]
        deviation = None if self.scaled else np.sqrt(self._instants[1:] ** 2 + self._instants[:-1] ** 2)[-self.size :]
        return [Curve("interval", "touch_time", start, measured, self.predicted(materials)[0], deviation)]

    def _rough_bounces(self) -> tuple[Array, Array, Array]:
        """Return velocities, restitution coefficients and contact times with the smoothest e(v), shape (n,).

        The depth at separation is about v T (1 - e)/3, and the contact time falls as v^(-1/5).
        """
        intervals = self.intervals
        share = intervals / intervals[0]
        shortest = float(intervals.min())
        trials = np.geomspace(1e-4, 0.3, 60)[:, None] * shortest
        times = trials * share**-0.2
        flights = intervals - np.minimum(times, 0.5 * intervals)
        e = np.minimum(share[1:] / share[:-1], 0.99)
        depths = 0.5 * self.gravity * flights * times * (1.0 - np.append(e[0], e)) / 3.0
        up = self.flight.launch(flights, depths)
        down = self.flight.fall(up, depths)[1]
        with np.errstate(invalid="ignore", divide="ignore"):
            e = up[:, 1:] / down[:, :-1]
            noise = 0.0 if self.scaled else self._instants[1:-1] / intervals[1:]
            logs, weights = np.log(e), np.broadcast_to(1.0 / np.sqrt(noise**2 + _SMOOTH**2), e.shape[1:])
        basis = np.vander(np.log(share[:-1]), max(1, min(3, e.shape[1] - 1))) * weights[:, None]
        projector = np.eye(e.shape[1]) - basis @ np.linalg.pinv(basis)
        misfit = ((logs * weights @ projector) ** 2).sum(axis=1)
        # The contact time may be unknown from the bounces.
        misfit += np.log(trials[:, 0] / (0.05 * shortest)) ** 2
        best = int(np.nanargmin(misfit))
        return down[best, :-1], np.clip(e[best], 0.05, 0.999), times[best, 1:]

    def window(self) -> tuple[float, float]:
        """Return NaN: no contact time was measured."""
        return math.nan, math.nan

    def contact_times(self, materials: Material) -> Array:
        """Return contact times [s] of the bounces on each material, shape (m, n)."""
        times = self._impacts(materials)[1][1]
        return np.where(times > 0.0, times, np.nan)

    def effective_moduli(self) -> DynamicTable | None:
        """Return moduli from the loss of the bounces and a rough guess of their contact times."""
        velocities, e, times = self._rough_bounces()
        return Rebounds(velocities, e, profile=self.profile, mass=self.mass, contact_time=times).effective_moduli()


def _slopes(intervals: Array) -> Array:
    """Return slopes of each interval over the one before, from a smooth law for all intervals."""
    x, y = np.log(intervals[:-1]), np.log(intervals[1:])
    law = np.polynomial.Polynomial.fit(x, y - x, min(3, (x.size - 1) // 2)) if np.ptp(x) > 0.0 else None
    bend = np.zeros(x.size) if law is None else law.deriv()(x)
    return np.clip((1.0 + bend) * np.exp(y - x), 0.0, 1.5)


def _carried(places: Array, values: Array, to: Array) -> Array:
    """Extrapolate values, shape (m, n), to nearby places by local power laws."""
    with np.errstate(divide="ignore", invalid="ignore"):
        x, y = np.log(places), np.log(values)
        slopes = np.diff(y, axis=1) / np.diff(x, axis=1)
        inner = (y[:, 2:] - y[:, :-2]) / (x[:, 2:] - x[:, :-2])
        slopes = np.hstack([slopes[:, :1], inner, slopes[:, -1:]])
        slopes = np.clip(np.where(np.isfinite(slopes), slopes, 0.0), -3.0, 3.0)
        return values * np.exp(slopes * np.log(to / places))
