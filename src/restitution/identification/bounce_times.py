"""Instants at which a falling body touches the ground, for instance from the sound of a bouncing ball."""

from __future__ import annotations

import math
import warnings
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution import checks, quantities
from restitution.contact.geometry import Geometry
from restitution.errors import InputError, RestitutionWarning
from restitution.identification.force_history import profile_of, rising
from restitution.identification.observations import Curve, Noise, Nuisance, Observations
from restitution.identification.rebounds import Rebounds
from restitution.impact.batch import Batch
from restitution.impact.problem import STANDARD_GRAVITY
from restitution.impact.status import Status
from restitution.material.columns import MaterialColumns, PronyColumns
from restitution.material.fit import DynamicTable

Array = NDArray[np.float64]

_RTOL = 1e-9
_AIR = 1.2
# A first flight that is lower or higher [m] than these is refused.
_LOWEST, _HIGHEST = 1e-6, 100.0
# Assumed deviation of ln e from a parabola over ln v.
_SMOOTH = 3e-3


class Flight(NamedTuple):
    """Vertical flights from a depth below the surface to the surface; all arguments broadcast."""

    gravity: float  # g [m/s2]
    drag: float  # k of the drag k v^2 per mass [1/m]

    def landing(self, height: Any) -> Array:
        """Velocity [m/s] at the surface after a fall from rest at a height [m]."""
        if self.drag == 0.0:
            return np.sqrt(2.0 * self.gravity * np.asarray(height))
        return np.sqrt(-np.expm1(-2.0 * self.drag * np.asarray(height)) * self.gravity / self.drag)

    def fall(self, up: Array, depth: Array) -> tuple[Array, Array]:
        """Duration [s] of flights with these velocities [m/s] at the start, and velocity at the end.

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
        """Velocity [m/s] at the start of flights with this duration [s]."""
        up = 0.5 * self.gravity * duration + depth / duration
        if self.drag == 0.0:
            return up
        for _ in range(6):
            time, down = self.fall(up, depth)
            slope = (1.0 + up / np.maximum(down, 1e-3 * up)) / (self.gravity + self.drag * up * up)
            up = np.maximum(up + (duration - time) / slope, 0.1 * up)
        return up


class BounceTimes(Observations):
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
        Acceleration of free fall g [m/s2].
    air_density : float
        Density of the air [kg/m3], 1.2 at room temperature; 0 for no drag.
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

    nuisances: tuple[Nuisance, ...] = ()

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
        self.label = label
        self.mass = quantities.check_single("mass", mass)
        self.gravity = quantities.check_single("gravity", gravity)
        self.profile = profile_of(radius, profile)
        self.temperature = temperature
        if temperature is not None:
            self.temperature = quantities.check_single("temperature", temperature)
        self.drop_height = None
        if drop_height is not None:
            self.drop_height = quantities.check_single("drop_height", drop_height)
        self.time = rising("time", time, "s")
        if self.time.size < 4:
            raise InputError("time", wanted=f"must have at least 4 instants, not {self.time.size}")
        self.intervals = np.diff(self.time)
        height = self.gravity * float(self.intervals[0]) ** 2 / 8.0
        if not _LOWEST < height < _HIGHEST:
            wanted = f"must be in s: the body would rise by {height:.2g} m after the first touch"
            raise InputError("time", float(self.intervals[0]), wanted, "s", index=(1,))
        density = checks.single_nonnegative("air_density", air_density, "kg/m^3")
        coefficient = checks.single_nonnegative("drag_coefficient", drag_coefficient)
        self.flight = Flight(self.gravity, self._drag(density, coefficient, "air_density"))
        self._set_noise(Noise.given(noise))
        longer = np.diff(self.intervals)
        if np.any(longer > (0.02 * self.intervals[:-1] if self.scaled else 15.0 * self._instants[1:-1])):
            place = int(np.argmax(longer)) + 2
            wanted = (
                "must not follow a longer flight than the one before: a touch is missing, or there is one too many"
            )
            raise InputError("time", float(self.time[place]), wanted, "s", index=(place,))
        if density == 0.0 and not self.scaled:
            self._warn_of_drag(coefficient)

    def _drag(self, density: float, coefficient: float, field: str) -> float:
        """Drag per mass and squared velocity [1/m]."""
        if density == 0.0:
            return 0.0
        radius = getattr(self.profile, "radius", None)
        if radius is None or not type(self.profile).body_radius:
            raise InputError(field, density, "must be 0 for a profile without the radius of the body", "kg/m^3")
        return 0.5 * density * coefficient * math.pi * float(radius) ** 2 / self.mass

    def _set_noise(self, noise: Noise) -> None:
        for name in noise.deviations:
            if name != "time" and (name != "drop_height" or self.drop_height is None):
                raise InputError(f"noise.{name}", wanted="was not measured; measured are time and perhaps drop_height")
            if name == "drop_height" and "time" not in noise.deviations:
                raise InputError("noise.time", wanted="must be given, as that of the drop height is")
        if isinstance(noise.deviations.get("time"), (str, tuple)):
            raise InputError(
                "noise.time", noise.deviations["time"], "must be a number: times have no natural zero", "s"
            )
        found = noise.of("time", self.time)
        self.scaled = found is None
        instants = np.ones(self.time.size) if found is None else found
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

    def _solved(self, series: PronyColumns, velocities: Array) -> list[Array]:
        """Restitution coefficients, contact times and depths at separation, shape (m, n); NaN if a solve fails.

        All are 0 for a captured body, so that its prediction is wrong, but finite.
        """
        shape = velocities.shape
        places = np.repeat(np.arange(series.size), shape[1])
        rows = PronyColumns(*(part[places] for part in series))
        batch = Batch.from_columns(rows, self.profile, self.mass, velocities.ravel(), self.mass * self.gravity)
        found = batch.solve(_RTOL, workers=1)
        names = ("restitution_coefficient", "contact_time", "residual_indentation_depth")
        rest = np.where(found["status"] >= Status.TOO_MANY_STEPS, np.nan, 0.0)
        free = found["status"] == Status.SEPARATED
        return [np.where(free, found[name], rest).reshape(shape) for name in names]

    def _impacts(self, materials: MaterialColumns) -> tuple[Array, list[Array]]:
        """Velocities of impact near those of the data, shape (m, n), and the outcomes there."""
        series = materials.at(self.temperature).reduced
        rough = 0.5 * self.gravity * np.append(self.intervals[0] ** 2 / self.intervals[1], self.intervals[:-1])
        if self.drop_height is not None:
            rough[0] = float(self.flight.landing(self.drop_height))
        rough = np.broadcast_to(rough, (series.size, rough.size))
        velocities = self._velocities(rough, *self._solved(series, rough))
        return velocities, self._solved(series, velocities)

    def predicted(self, materials: MaterialColumns) -> Array:
        """All intervals [s] but the first, and with a drop height also the first, shape (m, n)."""
        velocities, (e, times, depths) = self._impacts(materials)
        found = times + self.flight.fall(e * velocities, depths)[0]
        return _carried(velocities, found, self._velocities(velocities, e, times, depths))[:, -self.size :]

    def _velocities(self, near: Array, e: Array, times: Array, depths: Array) -> Array:
        """Velocities of impact, from the intervals, and from outcomes at velocities near them."""
        velocities = near
        for _ in range(3):
            T, d = _carried(near, times, velocities), _carried(near, depths, velocities)
            up = self.flight.launch(np.maximum(self.intervals - T, 0.1 * self.intervals), d)
            down = self.flight.fall(up, d)[1]
            first = near[:, :1]
            if self.drop_height is None:
                first = up[:, :1] / np.maximum(_carried(near, e, velocities)[:, :1], 0.05)
            velocities = np.clip(np.hstack([first, down[:, :-1]]), 0.2 * near, 5.0 * near)
        return velocities

    def residuals(self, materials: MaterialColumns, nuisances: Array) -> Array:
        """Residuals of the intervals, whitened."""
        return (self.predicted(materials) - self.intervals[-self.size :]) @ self._whitening.T

    def curves(self, materials: MaterialColumns, nuisances: Array) -> list[Curve]:
        """Measured and predicted intervals over the time of their first touch."""
        measured, start = self.intervals[-self.size :], self.time[:-1][-self.size :]
        deviation = None if self.scaled else np.sqrt(self._instants[1:] ** 2 + self._instants[:-1] ** 2)[-self.size :]
        return [Curve("interval", "touch_time", start, measured, self.predicted(materials)[0], deviation)]

    def _rough_bounces(self) -> tuple[Array, Array, Array]:
        """Velocities, restitution coefficients and contact times with the smoothest e(v), shape (n,).

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
        """NaN: no contact time was measured."""
        return math.nan, math.nan

    def contact_times(self, materials: MaterialColumns) -> Array:
        """Contact times [s] of the bounces on each material, shape (m, n)."""
        times = self._impacts(materials)[1][1]
        return np.where(times > 0.0, times, np.nan)

    def effective_moduli(self) -> DynamicTable | None:
        """Moduli from the loss of the bounces and a rough guess of their contact times."""
        velocities, e, times = self._rough_bounces()
        return Rebounds(velocities, e, profile=self.profile, mass=self.mass, contact_time=times).effective_moduli()


def _slopes(intervals: Array) -> Array:
    """Slopes of each interval over the one before, from a smooth law for all intervals."""
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
