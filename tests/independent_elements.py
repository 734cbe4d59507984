"""Independent elements under a prescribed depth, which the body may touch again: what the contact law converges to.

An element that would pull is free: its surface creeps back without load, and the body may touch it again. It then has
the memory of all that it went through. Independent elements are exact for every history of a rigid tip whose shape
rises outwards, on a half-space whose modulus never rises.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution import Impact
from restitution.impact.elements import MaxwellElement, StandardSolidElement, element_law

Array = NDArray[np.float64]


def release(law: MaxwellElement | StandardSolidElement, pull: Array, step: float) -> Array:
    """Let elements go that pull [N/m]: the growth [m] of u in the step, with which their line load is zero."""
    if isinstance(law, MaxwellElement):
        du = pull / (law.equilibrium + law.viscosity / step + law.moduli.sum())
        law.w[:, : du.size] += du
        return du
    stiff = law.ginf / 3.0 + law.k0 + law.g1 / 3.0
    share = 1.0 if np.isinf(stiff) else stiff / (stiff + law.g1 + law.ginf)
    du = pull / (4.0 * (law.ginf + law.g1) * share)
    for inner, part in ((law.u1, 1.0), (law.u2, share), (law.u3, share)):
        inner[: du.size] += part * du
    return du


def element_forces(impact: Impact, time: Array, depth: Array, *, n_elements: int = 800) -> Array:
    """Force [N] of the elements of `method="elements"` at ascending times after 0; the depth at time 0 is 0.

    The error is of first order in the step and in `n_elements`, the number across the contact at the largest depth.
    """
    steps, series, profile = np.diff(time, prepend=0.0), impact.reduced_modulus, impact.profile
    # Explicit Euler is unstable beyond the shortest relaxation time.
    assert 0.0 < steps.min() <= steps.max() <= series.relaxation_times.min(initial=np.inf)
    count = (n_elements + 1) // 2
    spacing = float(profile.contact_radius(max(depth.max(), 0.0))) / count
    g, u = profile.transform((np.arange(count) + 0.5) * spacing), np.zeros(count)
    law = element_law(impact.material, impact.counter_material, series)
    law.grow(count)
    force, before = np.empty(time.size), 0.0
    for n, (d, step) in enumerate(zip(depth.tolist(), steps.tolist(), strict=True)):
        growth = d - g - u
        u += growth
        law.advance(u, growth, step)
        load = law.line_load(u, growth / step)
        u += release(law, np.maximum(-load, 0.0), step)
        # A dashpot that was touched within the step has the velocity of the body at its end.
        later = series.parallel_viscosity * (d - before - growth) / step
        force[n] = 2.0 * spacing * float((load + later)[load > 0.0].sum())
        before = d
    return force


class Lever(NamedTuple):
    """Oscillator `z'' + z'/Q + z = P cos t + F` at a distance, and a pull `C/(gap + cutoff)^2` of the surface."""

    quality: float
    push: float
    distance: float
    pull: float = 0.0
    cutoff: float = 1.0
    modes: tuple[tuple[float, float, float], ...] = ()  # stiffness, frequency, quality of further oscillators

    def attraction(self, gap: float) -> float:
        """Pull at a gap, constant in contact."""
        return self.pull / (max(gap, 0.0) + self.cutoff) ** 2


def tap_elements(
    lever: Lever, equilibrium: float, moduli: Array, times: Array, *, depth: float, count: int, steps: int, taps: int
) -> Array:
    """Amplitude, phase, mean and largest force, and loss of the last tap of a lever under a parabola of radius 1.

    Equal elements up to a depth, with u linear within a step; velocity Verlet. The errors are of second order. The
    lever starts at rest with z = 1. With further modes, also the amplitude of each mode, and half of its way.
    """
    spacing, step = math.sqrt(depth) / count, 2.0 * math.pi / steps
    s = ((np.arange(count) + 0.5) * spacing) ** 2
    decay = np.exp(-step / times)
    gain = moduli * times / step * -np.expm1(-step / times)
    stiff = equilibrium + float(gain.sum())
    u, loads = np.zeros(count), np.zeros((times.size, count))
    stiffness, omega, quality = np.array([(1.0, 1.0, lever.quality), *lever.modes]).T
    mass, push = stiffness / omega**2, np.append(lever.push, np.zeros(len(lever.modes)))
    damping, force = mass * omega / quality, -lever.attraction(lever.distance + 1.0)
    heights, rates = np.append(1.0, np.zeros(len(lever.modes))), np.zeros(mass.size)
    z = 1.0
    record, parts = np.zeros((steps, 3)), np.zeros((steps, mass.size))
    for n in range(taps * steps):
        before = (push * math.cos(n * step) + force - damping * rates - stiffness * heights) / mass
        z_before, force_before = z, force
        heights = heights + step * rates + 0.5 * step * step * before
        z = float(heights.sum())
        depth_now, memory = -(lever.distance + z), decay @ loads
        load = memory + equilibrium * (depth_now - s) + (stiff - equilibrium) * (depth_now - s - u)
        touched = load > 0.0
        changed = np.where(touched, depth_now - s, ((stiff - equilibrium) * u - memory) / stiff)
        loads = decay[:, None] * loads + gain[:, None] * (changed - u)
        u = changed
        gap = 0.0 if touched[0] else float(u[0] + s[0] - depth_now)
        force = 2.0 * spacing * float(load[touched].sum()) - lever.attraction(gap)
        after = (push * math.cos((n + 1) * step) + force - stiffness * heights) / mass
        rates = (rates + 0.5 * step * (before + after)) / (1.0 + 0.5 * step * damping / mass)
        record[n % steps] = z, force, -0.5 * (force + force_before) * (z - z_before)
        parts[n % steps] = heights
    z, force, work = record.T
    waves = 2.0 / steps * np.exp(-1j * step * (np.arange(steps) + 1.0))
    harmonic, modes = waves @ z, np.abs(waves @ parts)
    numbers = [abs(harmonic), math.atan2(harmonic.imag, harmonic.real), force.mean(), force.max(), work.sum()]
    return np.array(numbers if not lever.modes else [*numbers, *modes, *(0.5 * np.ptp(parts, axis=0))])
