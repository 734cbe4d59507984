"""Independent elements under a prescribed depth, which the body may touch again: what the contact law converges to.

An element that would pull is free: its surface creeps back without load, and the body may touch it again. It then has
the memory of all that it went through. Independent elements are exact for every history of a rigid tip whose shape
rises outwards, on a half-space whose modulus never rises.
"""

from __future__ import annotations

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
