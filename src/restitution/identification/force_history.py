"""Force histories: force or acceleration over time, measured during one impact."""

from __future__ import annotations

import math
import warnings
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution import checks, quantities
from restitution.contact.geometry import Geometry
from restitution.contact.profile import Parabola
from restitution.errors import InputError, InputTypeError, RestitutionWarning
from restitution.identification.observations import Curve, Noise, Nuisance, Observations
from restitution.identification.rebounds import Rebounds
from restitution.impact.batch import Batch
from restitution.material.columns import MaterialColumns
from restitution.material.fit import DynamicTable

Array = NDArray[np.float64]

_RTOL = 1e-9
# A sample above the first share of the peak belongs to the contact; a sample outside must be below the second share.
_TOUCHING, _HIGH = 0.1, 0.5
_FEWEST = 8
# Tolerance of the impulse, for noise, a coarse record and an uncertain gain.
_SLACK = 0.1
# Typical restitution coefficient of balls, for a start.
_TYPICAL_E = 0.6


class ForceHistory(Observations):
    """Force over time of one impact of a rigid body on a viscoelastic half-space.

    Parameters
    ----------
    time : array_like
        Ascending times [s], shape (n,), from any origin: the time of first touch is estimated.
    force : array_like, optional
        Measured normal force [N], positive in contact, shape (n,). The baseline is estimated.
    acceleration : array_like, optional
        Measured deceleration of the body F/m [m/s2] instead of the force.
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
    >>> record.size, [one.name for one in record.nuisances]
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
            raise InputError("force, acceleration", wanted="exactly one must be given")
        if gain is None and velocity is None:
            wanted = "must not both be unknown: the record is the same for all E sqrt(v) = const and gain v = const"
            raise InputError("gain, velocity", wanted=wanted)
        self.label = label
        self.mass = quantities.check_single("mass", mass)
        self.velocity = None if velocity is None else quantities.check_single("velocity", velocity)
        self.gain = None if gain is None else checks.single_positive("gain", gain)
        self.profile = profile_of(radius, profile)
        self.ar1 = checks.single("ar1", checks.nonnegative("ar1", ar1))
        if self.ar1 >= 1.0:
            raise InputError("ar1", self.ar1, "must be in [0, 1)")
        self.temperature = temperature
        if temperature is not None:
            self.temperature = quantities.check_single("temperature", temperature)
        name, unit = ("force", "N") if acceleration is None else ("acceleration", "m/s^2")
        self.time = rising("time", time, "s")
        values = np.atleast_1d(checks.finite(name, force if acceleration is None else acceleration, unit))
        if values.shape != self.time.shape:
            raise InputError(f"time, {name}", wanted=f"have {self.time.size} and {values.size} values")
        steps = np.diff(self.time)
        if self.ar1 and steps.max() > 1.01 * steps.min():
            raise InputError("time", wanted="must be regular with ar1", unit="s")
        self._pulse = pulse = _pulse_of(name, unit, self.time, values, self.profile)
        self._name, self._unit, self._factor = name, unit, 1.0 if acceleration is None else self.mass
        self._check_size()
        self._set_noise(Noise.given(noise), values)
        self.measured = values * self._factor
        share = float(np.median(self._deviations)) / (pulse.height * self._factor * math.sqrt(pulse.samples))
        share = 0.01 if self.scaled else share
        start, duration = pulse.first_touch, pulse.duration
        self.nuisances = (
            Nuisance("first_touch", "s", start, start - 0.5 * duration, pulse.peak_time, 0.3 * share * duration),
        )
        if self.velocity is None:
            guess, low, high = self._velocity_guess()
            self.nuisances += (Nuisance("velocity", "m/s", guess, low, high, share * guess),)

    def _check_size(self) -> None:
        """Refuse a duration or an impulse that is impossible for such an impact."""
        pulse, velocity = self._pulse, self.velocity
        radius = getattr(self.profile, "radius", None)
        if velocity is not None and radius is not None and pulse.duration * velocity > radius:
            wanted = "must be in s: the body would move by more than its radius during contact"
            raise InputError("time", wanted=f"{wanted} of {pulse.duration:.3g}", unit="s")
        if self.gain is None or velocity is None:
            return
        ratio = self._impulse / (self.mass * velocity)
        if not 1.0 - _SLACK < ratio < 2.0 * (1.0 + _SLACK):
            wanted = f"must have an impulse from m v to 2 m v, not {ratio:.3g} m v; check units, or give gain=None"
            raise InputError(self._name, wanted=wanted)

    def _velocity_guess(self) -> tuple[float, float, float]:
        """Impact velocity [m/s] that the record shows, and its bounds.

        The impulse is m v (1 + e). The depth at separation, v T less the double integral of F/m, is about
        v T (1 - e)/3.
        """
        gained = self._impulse / self.mass
        mean = gained * self._pulse.path / (self._pulse.impulse * self._pulse.duration)
        guess = min(max(3.0 * mean - gained, 0.51 * gained), 0.9 * gained)
        return guess, 0.5 * gained / (1.0 + _SLACK), gained * (1.0 + _SLACK)

    def _set_noise(self, noise: Noise, values: Array) -> None:
        for name in noise.deviations:
            if name != self._name:
                raise InputError(f"noise.{name}", wanted=f"was not measured; measured is {self._name}")
        found = noise.of(self._name, values, self._pulse.height)
        self.scaled = found is None
        deviations = np.ones(values.size) if found is None else found
        self._deviations = deviations * self._factor
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

    @property
    def _impulse(self) -> float:
        """Impulse [N s] of the record, for the given gain."""
        return self._pulse.impulse * self._factor / (self.gain or 1.0)

    @property
    def size(self) -> int:
        """Number of samples."""
        return self.time.size

    def forces(self, materials: MaterialColumns, nuisances: Array) -> Array:
        """Forces [N] at the times of the record, without gain and baseline, shape (m, n); NaN without separation."""
        velocity = nuisances[:, 1] if self.velocity is None else self.velocity
        batch = Batch.from_columns(materials.at(self.temperature).reduced, self.profile, self.mass, velocity, 0.0)
        return batch.sample_forces(self.time - nuisances[:, :1], _RTOL)

    def _whitened(self, values: Array) -> Array:
        scaled = values / self._deviations
        if not self.ar1:
            return scaled
        rest = (scaled[..., 1:] - self.ar1 * scaled[..., :-1]) / math.sqrt(1.0 - self.ar1**2)
        return np.concatenate([scaled[..., :1], rest], axis=-1)

    def _fitted(self, materials: MaterialColumns, nuisances: Array) -> tuple[Array, Array, Array, Array]:
        """Forces, gains and baselines of all rows, and the residuals."""
        forces = self.forces(materials, nuisances)
        one = self._whitened(np.ones(self.size))
        one = one / np.sqrt(one @ one)
        fitted, data = self._whitened(forces), self._whitened(self.measured)
        level, mean = fitted @ one, data @ one
        fitted, data = fitted - level[:, None] * one, data - mean * one
        gains = np.full(len(forces), self.gain or 1.0)
        if self.gain is None:
            gains = fitted @ data / (fitted * fitted).sum(axis=1)
        baselines = (mean - gains * level) / (one @ self._whitened(np.ones(self.size)))
        return forces, gains, baselines, gains[:, None] * fitted - data

    def residuals(self, materials: MaterialColumns, nuisances: Array) -> Array:
        """Residuals of the samples, whitened; NaN for a body that stays."""
        return self._fitted(materials, nuisances)[-1]

    def curves(self, materials: MaterialColumns, nuisances: Array) -> list[Curve]:
        """Measured and fitted force over time."""
        forces, gains, baselines, _ = self._fitted(materials, nuisances)
        fitted = gains[0] * forces[0] + baselines[0]
        return [Curve("force", "time", self.time, self.measured, fitted, None if self.scaled else self._deviations)]

    def linear_estimates(self, materials: MaterialColumns, nuisances: Array) -> dict[str, tuple[float, str]]:
        """Baseline, and the gain if it is unknown."""
        _, gains, baselines, _ = self._fitted(materials, nuisances)
        found = {"baseline": (float(baselines[0]) / self._factor, self._unit)}
        return found if self.gain is not None else found | {"gain": (float(gains[0]), "")}

    def window(self) -> tuple[float, float]:
        """Half and twice the angular frequency pi/T of the contact time T."""
        omega = math.pi / self._pulse.duration
        return 0.5 * omega, 2.0 * omega

    def effective_moduli(self) -> DynamicTable | None:
        """Moduli from the contact time and the impulse of a ball."""
        if not isinstance(self.profile, Parabola):
            return None
        if self.gain is None:
            e, velocity = _TYPICAL_E, float(self.velocity or 1.0)
        else:
            velocity = self.velocity or self._velocity_guess()[0]
            e = min(max(self._impulse / (self.mass * velocity) - 1.0, 0.15), 0.99)
        radius, duration = self.profile.radius, self._pulse.duration
        return Rebounds([velocity], [e], radius=radius, mass=self.mass, contact_time=[duration]).effective_moduli()


def profile_of(radius: Any, profile: Any) -> Geometry:
    """Profile of a body: a parabola of this radius [m], or the given profile."""
    if (radius is None) == (profile is None):
        raise InputError("radius, profile", wanted="exactly one must be given")
    if profile is None:
        return Parabola(quantities.check_single("radius", radius))
    if not isinstance(profile, Geometry) or profile.needs_poisson_ratio or np.ndim(profile.stiffness_radius(0.0)):
        raise InputTypeError("profile", profile, "must be a single Geometry without a Poisson ratio, no bonded layer")
    return profile


def rising(name: str, value: Any, unit: str) -> Array:
    """Return finite numbers of shape (n,); refuse numbers that are not ascending."""
    values = np.atleast_1d(checks.finite(name, value, unit))
    if values.ndim != 1:
        raise InputError(name, wanted=f"must be one column, not of shape {values.shape}")
    falls = np.flatnonzero(np.diff(values) <= 0.0)
    if falls.size:
        place = int(falls[0]) + 1
        raise InputError(name, float(values.flat[place]), "must be ascending", unit, index=(place,))
    return values


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
        raise InputError(name, wanted=f"must have at least {2 * _FEWEST} samples, not {values.size}")
    baseline = float(min(np.median(values[:3]), np.median(values[-3:])))
    peak = int(np.argmax(values))
    height = float(values[peak]) - baseline
    if height <= 0.0 or baseline - float(values.min()) > height:
        raise InputError(name, wanted="must rise from its baseline to a positive peak; check the sign")
    share = (values - baseline) / height
    _refuse_damage(name, unit, values, share, peak)
    off = np.flatnonzero(share < _TOUCHING)
    if not np.any(off > peak):
        raise InputError(name, wanted="must return to its baseline: the record has no end of the contact")
    left, right = int(np.max(off[off < peak], initial=-1)) + 1, int(np.min(off[off > peak]))
    if right - left < _FEWEST:
        wanted = f"must have at least {_FEWEST} samples in contact, not {right - left}"
        raise InputError(name, wanted=wanted)
    if np.any(share[:left] > _HIGH) or np.any(share[right:] > _HIGH):
        raise InputError(name, wanted="must have one contact: it rises above half of its peak more than once")
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
    """Time at which the flank of a peak begins, from samples in the order from its foot to the top."""
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
            wanted = f"must not be saturated: {width} samples have this same largest value"
            raise InputError(name, float(values[peak]), wanted, unit, index=(first,))
    smooth = (4.0 * (share[1:-3] + share[3:-1]) - share[:-4] - share[4:]) / 6.0
    off = np.abs(share[2:-2] - smooth)
    lone = (off > 0.25) & (np.abs(share[3:-1] - share[1:-3]) < off)
    if np.any(lone):
        place = int(np.argmax(np.where(lone, off, 0.0))) + 2
        raise InputError(name, float(values[place]), "must not jump: this sample is out of line", unit, index=(place,))
