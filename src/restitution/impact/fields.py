"""Pressure and surface displacement during and after an impact, from the line load of the foundation.

The element of the foundation at x is touched at t0(x). With the branches of the reduced modulus it carries

    q(x, t) = E_inf u + eta u' + sum E_k w_k,   w_k = H_k(t) - exp(-(t - t0)/tau_k) H_k(t0),   u = d - g(x),

`H_k = int_0^t exp(-(t - t')/tau_k) d' dt'`, until it leaves at t2(x). Then q = 0, and it creeps back, with the
compliances J_j and the times theta_j of the retardation spectrum (derived on the page Fields of the theory):

    u(x, t) = sum_j J_j [E_inf u + sum_k E_k w_k/(1 - theta_j/tau_k)](x, t2) exp(-(t - t2)/theta_j)
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.checks import Array, nonnegative
from restitution.contact.pressure import LineFunction, line_function, pressure, surface_displacement
from restitution.contact.profiles import as_profile
from restitution.impact.problem import Impact
from restitution.impact.solution import D_, H_, S_, T_, V_, Solution
from restitution.material.prony import secular_roots

Fit = Callable[[float], LineFunction | None]
Field = Callable[[LineFunction, Array], Array]
Kept = dict[float, LineFunction | None]

# The line load ends at this share of the contact radius before the edge. A profile so steep that q falls to zero
# within it (around a flat face, at the equator of a sphere) has the contact of a flat punch.
_EDGE = 1e-10
# Distance from the tip [m] at which only a cone has a noticeable depth.
_NEAR_TIP = 1e-200
# Limits of the error of the line load over its largest value, which is about 1000 rtol at early times.
_NOISE, _MOST_NOISE = 1e-9, 1e-3
# Number of times whose line functions are kept, so that a second call does not fit them again.
_KEPT = 64


class ImpactFields:
    """Fields over radius and time, in SI, of one impact that ended in separation, solved at the tolerance `rtol`."""

    def __init__(self, impact: Impact, solution: Solution, rtol: float) -> None:
        geometry = impact.profile
        profile = geometry.image or as_profile(geometry, "pressure and surface displacement")
        # Contact radius over stiffness radius.
        self._stretch = (
            1.0 if profile is geometry else float(geometry.contact_radius(1.0) / geometry.stiffness_radius(1.0))
        )
        self._geometry, self._solution, self._profile, series = geometry, solution, profile, impact.reduced_modulus
        self._spring, self._dashpot = series.equilibrium_modulus, series.parallel_viscosity
        self._moduli, self._times = series.branch_moduli, series.relaxation_times
        roots = secular_roots(self._spring, self._dashpot, self._moduli[::-1], self._times[::-1])
        self._retardation_times, self._compliances = roots.times, 1.0 / roots.slopes
        self._coupling = roots.terms[:, ::-1] * self._moduli
        self._flow = series.flow_viscosity if series.is_liquid else np.inf
        # Without a power law, only a table that starts like a cone has a slope g'(0).
        sharp = float(self._profile.transform(_NEAR_TIP)) > 1e-9 * _NEAR_TIP
        power = self._profile.path_exponent
        self._tip_exponent = (1.0 if sharp else 2.0) if not power else 2.0 / float(power)
        self._noise = min(max(_NOISE, 1e3 * rtol), _MOST_NOISE)
        self._loads, self._displacements = Kept(), Kept()

    def pressure(self, r: ArrayLike, t: ArrayLike) -> Array:
        """Return the contact pressure p(r, t) [Pa]; r and t broadcast, 0 outside the contact and after it."""
        field = partial(pressure, noise=self._noise, tip_exponent=self._tip_exponent)
        inside = np.asarray(nonnegative("r", r, "m")) / self._stretch
        return self._over_times(self._loads, self.line_load, field, inside, t) / self._stretch**2

    def surface_displacement(self, r: ArrayLike, t: ArrayLike) -> Array:
        """Return the displacement of the surface w(r, t) [m], into the half-space; r and t broadcast."""
        as_profile(self._geometry, "surface displacement")
        return self._over_times(self._displacements, self.line_displacement, surface_displacement, r, t)

    def line_load(self, t: float) -> LineFunction | None:
        """Return the line load q(x) [N/m] of the foundation at the time t [s]; None without contact."""
        units, time = self._solution.units, t / self._solution.units.time
        if not 0.0 < time < self._solution.end:
            return None
        state, edge, s = self._state(time)
        if edge <= 0.0:
            return None
        memory = state[H_ + 1 :] * units.length

        def load(x: Array) -> Array:
            touched, memory_then = self._touch(x)
            decay = np.exp(-np.maximum(time * units.time - touched, 0.0)[:, None] / self._times)
            u = state[D_] * units.length - self._depth(np.minimum(x, edge), s)
            branches = (memory - decay * memory_then) @ self._moduli
            return self._spring * u + self._dashpot * (state[V_] * units.length / units.time) + branches

        ends = self._solution.approach.columns[:, 0, S_]
        extent = edge if self._profile.path_exponent == 0.0 else edge * (1.0 - _EDGE)
        return line_function(load, extent, breakpoints=self._radii(ends[ends < s]))

    def line_displacement(self, t: float) -> LineFunction | None:
        """Return the displacement u(x) [m] of the foundation at the time t [s]; None before first touch."""
        stored, length = self._solution, self._solution.units.length
        time = t / stored.units.time
        if time <= 0.0:
            return None
        state, edge, s = self._state(time)
        depth = state[D_] * length

        def displacement(x: Array) -> Array:
            u = depth - self._depth(np.minimum(x, edge), s)
            left = (x > edge) | (time >= stored.end)
            u[left] = self._recovering(x[left], t)
            return u

        if t <= stored.turning_time:
            return line_function(displacement, edge, breakpoints=self._radii(np.zeros(1)))
        ends = np.concatenate([stored.approach.columns[:, 0, S_], stored.rebound.columns[:, 0, S_], [stored.deepest]])
        *breaks, extent = self._radii(ends[ends <= stored.deepest])
        # An imprint that has nearly recovered is small against its rounding.
        return line_function(displacement, extent, breakpoints=[*breaks, edge], scale=stored.deepest**2 * length)

    def _over_times(self, kept: Kept, fit: Fit, field: Field, r: Any, t: Any) -> Array:
        radius, time = np.broadcast_arrays(np.asarray(nonnegative("r", r, "m")), np.asarray(nonnegative("t", t, "s")))
        result = np.zeros(radius.shape)
        for moment in np.unique(time):
            key = float(moment)
            if key not in kept:
                if len(kept) >= _KEPT:
                    kept.pop(next(iter(kept)))
                kept[key] = fit(key)
            if (line := kept[key]) is not None:
                here = time == moment
                result[here] = field(line, radius[here])
        return result[()]

    def _state(self, time: float) -> tuple[Array, float, float]:
        """Return the columns of the motion at a scaled time, the contact radius [m] and s of the approach there."""
        stored = self._solution
        moment = np.array([min(time, stored.end)])
        half = stored.approach if time * stored.units.time <= stored.turning_time else stored.rebound
        places = stored.find(half, T_, moment)
        state = stored.interpolate(half.columns, *places)[0]
        if half is stored.approach:
            s = float(state[S_])
        elif time >= stored.end:
            return state, 0.0, 0.0
        else:
            sigma = stored.sigma_m - stored.position(half, *places)
            s = max(float(stored.approach_at(np.maximum(sigma, 0.0))[0, S_]), 0.0)
        return state, float(self._radii(np.array([s]))[-1]), s

    def _radii(self, s: Array) -> Array:
        """Return the contact radii [m] at s."""
        return np.asarray(self._profile.contact_radius(s**2 * self._solution.units.length))

    def _depth(self, x: Array, s: float) -> Array:
        """Return the depths g [m] at which the elements at x [m] are touched, at most that of s."""
        # Rounding puts deep contacts of a sphere at its equator, where g is infinite.
        return np.minimum(self._profile.transform(x), s**2 * self._solution.units.length)

    def _touch(self, x: Array) -> tuple[Array, Array]:
        """Return the times t0 [s] at which the elements at x [m] are touched, and H_k [m] there, shape (n, N)."""
        stored = self._solution
        state = stored.interpolate(stored.approach.columns, *self._touch_places(x))
        return state[:, T_] * stored.units.time, state[:, H_ + 1 :] * stored.units.length

    def _touch_places(self, x: Array) -> tuple[NDArray[np.intp], Array]:
        s = np.sqrt(self._depth(x, self._solution.deepest) / self._solution.units.length)
        return self._solution.find(self._solution.approach, S_, s)

    def _recovering(self, x: Array, t: float) -> Array:
        """Return the displacement [m] at the time t [s] of elements at x [m] that have left."""
        stored = self._solution
        time, length = stored.units.time, stored.units.length
        places = self._touch_places(x)
        then = stored.interpolate(stored.approach.columns, *places)
        way = stored.sigma_m - stored.position(stored.approach, *places)
        later = stored.interpolate(stored.rebound.columns, *stored.places(stored.rebound, np.maximum(way, 0.0)))
        left = later[:, T_] * time
        decay = np.exp(-np.maximum(left - then[:, T_] * time, 0.0)[:, None] / self._times)
        w = (later[:, H_ + 1 :] - decay * then[:, H_ + 1 :]) * length
        u = later[:, D_] * length - self._depth(x, stored.deepest)
        since = np.maximum(t - left, 0.0)[:, None]
        parts = (self._spring * u[:, None] + w @ self._coupling.T) * self._compliances
        stays = (self._dashpot * u + (u[:, None] - w) @ (self._moduli * self._times)) / self._flow
        return np.sum(parts * np.exp(-since / self._retardation_times), axis=1) + stays
