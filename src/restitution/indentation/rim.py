"""Steady oscillation of the depth: elements of the rim leave and touch once a period, the others never leave."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.checks import Array
from restitution.contact.geometry import Geometry
from restitution.errors import InputError
from restitution.kernel.panels import Solid
from restitution.numerics.quadrature import PLACES, SLOPES, WEIGHTS

# Gauss quadrature over parts of [0, 1], in a place z with the depth of an element s = s0 + (s1 - s0) (3 z^2 - 2 z^3).
_PARTS = 6
_PLACES = (PLACES[None] + np.arange(_PARTS)[:, None]).ravel() / _PARTS
# Shares of a period at which the end of a phase is looked for.
_SHARES = np.unique(np.concatenate([np.geomspace(1e-9, 0.01, 60), np.linspace(0.01, 1.0, 240)]))
_FIRST_ITERATIONS, _MOST_ITERATIONS = 40, 40
# Share of the rim, next to the elements that never leave, that counts to them.
_NEXT = 1e-4
# Rounding of loads and gaps over their scales, and the shortest contact and the shortest flight of a solution.
_BLUR, _SHORTEST = 1e-13, 1e-7


class Steady(NamedTuple):
    """Steady state of `d = mean + amplitude sin(2 pi t)` with the period 1; F is half of the force, 2 int q da."""

    coefficients: NDArray[Any]  # (n,): c_n = int F exp(-2 pi i n t) dt over a period
    innermost: float  # depth of the outermost element that never leaves, 0 without one
    depths: Array  # (m,): of elements of the rim
    leaving: Array  # (m,): when they leave
    touching: Array  # (m,): when they touch, before
    share: float  # of the period in contact


class _Rim:
    """Elements that leave in each period, in units of the period."""

    def __init__(self, solid: Solid, mean: float, amplitude: float, depths: Array) -> None:
        self.solid, self.mean, self.amplitude, self.depths = solid, mean, amplitude, depths
        omega = 2.0 * math.pi
        self.loads = amplitude * solid.moduli * (1j * omega / (1j * omega + solid.rates))
        self.stiffness = amplitude * (solid.equilibrium + 1j * omega * solid.viscosity) + self.loads.sum()

    def displacement(self, t: Array) -> Array:
        """Return u of the elements, shape of t with the elements first."""
        return self.mean - self._along(self.depths, t) + self.amplitude * np.sin(2.0 * math.pi * t)

    @staticmethod
    def _along(values: Array, t: Array) -> Array:
        return values.reshape(values.shape[:1] + (1,) * (t.ndim - 1))

    def driven(self, t: Array) -> Array:
        """Return the loads of branches that follow for ever, shape (..., K)."""
        return np.imag(self.loads * np.exp(2j * math.pi * t)[..., None])

    def load(self, t: Array, touching: Array, excess: Array) -> Array:
        """Return q at times after the touch, where the loads differ by `excess` (m, K) from those of `driven`."""
        solid, elapsed = self.solid, t - self._along(touching, t)
        q = solid.equilibrium * (self.mean - self._along(self.depths, t))
        q = q + np.imag(self.stiffness * np.exp(2j * math.pi * t))
        decay = np.exp(-elapsed[..., None] * solid.rates)
        return q + np.sum(decay * excess.reshape(excess.shape[:1] + (1,) * (t.ndim - 1) + excess.shape[1:]), axis=-1)

    def gap(self, t: Array, leaving: Array, parts: Array) -> Array:
        """Return W - u at times after leaving with the parts (m, J) of the displacement."""
        elapsed = t - self._along(leaving, t)
        decay = np.exp(-elapsed[..., None] * self.solid.recoveries)
        shaped = parts.reshape(parts.shape[:1] + (1,) * (t.ndim - 1) + parts.shape[1:])
        return np.sum(decay * shaped, axis=-1) - self.displacement(t)

    def periodic(self, leaving: Array, touching: Array) -> Array:
        """Return the parts of the displacement at the touch that repeat after a period, (m, J), for given times."""
        solid = self.solid
        recovery = np.exp(-(touching + 1.0 - leaving)[:, None] * solid.recoveries)
        decay = np.exp(-(leaving - touching)[:, None] * solid.rates)
        held = self.driven(leaving) - decay * self.driven(touching)
        target = recovery * (solid.displacement * self.displacement(leaving)[:, None] + held @ solid.loads.T)
        matrix = recovery[:, :, None] * ((solid.loads * decay[:, None, :]) @ solid.moduli_of)
        identity = np.eye(solid.recoveries.size)
        return np.linalg.solve(identity - matrix, target[:, :, None])[:, :, 0]

    def solve(self) -> tuple[Array, Array, Array]:
        """Return the times of leaving and of the touch before, and the excess of the loads at the touch."""
        solid = self.solid
        share = np.clip((self.depths - self.mean) / self.amplitude, -1.0, 1.0)
        touching = np.arcsin(share) / (2.0 * math.pi)
        parts = np.zeros((self.depths.size, solid.recoveries.size))
        leaving = touching
        blur, glass = _BLUR * (self.mean + self.amplitude), abs(self.stiffness) / self.amplitude
        for _ in range(_FIRST_ITERATIONS):
            excess = parts @ solid.moduli_of.T - self.driven(touching)
            leaving = _first_below(lambda t, w=touching, e=excess: self.load(t, w, e), touching, blur * glass)
            decay = np.exp(-(leaving - touching)[:, None] * solid.rates)
            loads = self.driven(leaving) + decay * excess
            free = solid.displacement * self.displacement(leaving)[:, None] + loads @ solid.loads.T
            touching = _first_below(lambda t, w=leaving, p=free: self.gap(t, w, p), leaving, blur) - 1.0
            parts = self.periodic(leaving, touching)
        leaving, touching = self._newton(leaving, touching)
        return leaving, touching, self.periodic(leaving, touching) @ solid.moduli_of.T - self.driven(touching)

    def _residuals(self, times: Array) -> Array:
        """Return the load at leaving and the gap at the touch, (2, m), which vanish in the steady state."""
        leaving, touching = times
        parts = self.periodic(leaving, touching)
        excess = parts @ self.solid.moduli_of.T - self.driven(touching)
        return np.stack([self.load(leaving, touching, excess), parts.sum(axis=1) - self.displacement(touching)])

    def _newton(self, leaving: Array, touching: Array) -> tuple[Array, Array]:
        """Return the times in the steady state by Newton's method; refuse an oscillation without one."""
        times, tiny = np.stack([leaving, touching]), 1e-7
        scale = abs(self.stiffness)
        for _ in range(_MOST_ITERATIONS):
            residual = self._residuals(times)
            slopes = [
                (self._residuals(times + step[:, None]) - self._residuals(times - step[:, None])) / (2.0 * tiny)
                for step in tiny * np.eye(2)
            ]
            (a, c), (b, d) = slopes
            determinant = a * d - b * c
            safe = np.where(determinant == 0.0, math.inf, determinant)
            change = np.stack([d * residual[0] - b * residual[1], a * residual[1] - c * residual[0]]) / safe
            # Neither phase may vanish.
            least = 0.5 * np.minimum(times[0] - times[1], times[1] + 1.0 - times[0])
            times = times - np.clip(change, -least, least)
            if np.abs(change).max() < 1e-11:
                break
        # Newton's method may leave for a contact, or a flight, without a length; then the iterates are kept.
        scales = np.array([[scale], [self.amplitude]])
        first = np.stack([leaving, touching])
        residual, kept = (np.max(np.abs(self._residuals(each)) / scales, axis=0) for each in (times, first))
        length = times[0] - times[1]
        better = (residual <= kept) & (length > _SHORTEST) & (length < 1.0 - _SHORTEST)
        times, residual = np.where(better, times, first), np.where(better, residual, kept)
        # Loads of a short phase are small in proportion to it, and so is what its times contribute.
        length = times[0] - times[1]
        weight = np.clip(np.minimum(length, 1.0 - length), 0.0, 1.0)
        if not np.max(residual * weight) <= 1e-9:
            raise InputError("cycles", rule="must be given: the steady state of this oscillation is not found")
        return times[0], times[1]

    def coefficients(self, leaving: Array, touching: Array, excess: Array, orders: Array) -> NDArray[Any]:
        """Return int q exp(-2 pi i n t) dt over a period, shape (m, n)."""
        solid, omega = self.solid, 2.0 * math.pi

        def integral(rate: NDArray[Any]) -> NDArray[Any]:
            """Return int exp(rate t) dt over the contact."""
            rate = np.broadcast_to(rate, (leaving.size, orders.size))
            ends = np.exp(rate * leaving[:, None]) - np.exp(rate * touching[:, None])
            zero = rate == 0.0
            return np.where(zero, (leaving - touching)[:, None], ends / np.where(zero, 1.0, rate))

        constant = solid.equilibrium * (self.mean - self.depths)
        total = constant[:, None] * integral(-1j * omega * orders)
        total = total + self.stiffness / 2j * integral(1j * omega * (1 - orders))
        total = total - np.conj(self.stiffness) / 2j * integral(-1j * omega * (1 + orders))
        for k, rate in enumerate(solid.rates):
            sums = rate + 1j * omega * orders
            fades = 1.0 - np.exp(-sums * (leaving - touching)[:, None])
            total = total + excess[:, k, None] * np.exp(-1j * omega * orders * touching[:, None]) * fades / sums
        return total


def _first_below(function: Callable[[Array], Array], start: Array, rounding: float) -> Array:
    """Return the first time after each start, within a period, at which a function falls below zero.

    At the start it is zero within rounding, and rises. Where it does not fall, the time of its least value.
    """
    times = start[:, None] + _SHARES
    values = function(times)
    below = values < -rounding
    above = np.cumsum(values > rounding, axis=1) > 0
    hit = below & above
    found = hit.any(axis=1)
    n = np.where(found, hit.argmax(axis=1), values.argmin(axis=1))
    rows = np.arange(start.size)
    high = times[rows, n]
    low = np.where(found, times[rows, np.maximum(n - 1, 0)], high)
    for _ in range(60):
        middle = 0.5 * (low + high)
        inside = function(middle[:, None])[:, 0] < 0.0
        low, high = np.where(inside, low, middle), np.where(inside, middle, high)
    return np.where(found, high, times[rows, n])


def steady_state(
    profile: Geometry, solid: Solid, mean: float, amplitude: float, length: float, radius: float, count: int
) -> Steady:
    """Return the steady state of an oscillating depth, in units of a length [m], a radius [m] and the period."""
    omega = 2.0 * math.pi
    stiffness = solid.equilibrium + 1j * omega * solid.viscosity
    stiffness += np.sum(solid.moduli * (1j * omega / (1j * omega + solid.rates)))
    inner = mean - abs(stiffness) * amplitude / solid.equilibrium if solid.equilibrium > 0.0 else -math.inf
    inner = max(inner, 0.0)
    orders = np.arange(float(count))
    top = mean + amplitude
    depths = inner + (top - inner) * (3.0 * _PLACES**2 - 2.0 * _PLACES**3)

    def radii(s: Array) -> Array:
        return np.asarray(profile.stiffness_radius(s * length)) / radius

    always = inner > 0.0
    # Next to those that never leave, the load vanishes for a moment, which the sums do not feel.
    stays = always & (depths - inner < _NEXT * (top - inner))
    # The element at the axis is the first to touch and the last to leave.
    rim = _Rim(solid, mean, amplitude, depths[~stays] if always else np.append(depths, 0.0))
    leaving, touching, excess = rim.solve()
    parts = rim.coefficients(leaving, touching, excess, orders)
    if always:
        near = _Rim(solid, mean, amplitude, depths[stays])
        begin = np.full(near.depths.size, -0.25)
        whole = near.coefficients(begin + 1.0, begin, np.zeros((begin.size, solid.rates.size)), orders)
        parts = np.concatenate([whole, parts])
        leaving, touching = np.append(begin + 1.0, leaving), np.append(begin, touching)
    growth = (radii(depths).reshape(_PARTS, -1) @ SLOPES.T) * WEIGHTS
    total = growth.ravel() @ parts[: depths.size]
    share = 1.0
    if always:
        a = float(radii(np.array([inner]))[0])
        integral = float(np.asarray(profile.force_integral_at_depth(inner * length))) / (radius * length)
        total[0] += solid.equilibrium * ((mean - inner) * a + integral)
        if count > 1:
            total[1] += stiffness * amplitude * a / 2j
    else:
        # A flat face.
        total = total + float(radii(np.zeros(1))[0]) * parts[-1]
        share = float(leaving[-1] - touching[-1])
    m = depths.size
    return Steady(total, inner, depths, leaving[:m], touching[:m], share)
