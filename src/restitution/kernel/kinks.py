"""Kinks of a profile: an element that spans one which matters ends there instead.

Beyond a kink `a = smooth + strength z^p` with z = s - kink and a half-integer p >= 3/2. The force has a term z^(p+1), or
z^p under a dashpot, and the velocity one of z^(p+2). An element that spans it loses its order; one that begins there is
only as good at its end as it is inside.
"""

from typing import Any

from restitution.kernel.compile import compiled, inlined
from restitution.kernel.interpolation import crossing, value
from restitution.kernel.lanes import WIDTH
from restitution.kernel.problem import Problem
from restitution.kernel.radau import Scheme
from restitution.kernel.workspace import S_, V_, Work

# Distance between nodes over the length of an element, about: as far beyond a kink an element does not see it.
SPACING = 1.0 / 6.0
# Tail of z^(p+2) over its value at the end of an element, at most.
_TAIL = 2e-5


@inlined
def kink_effect(problem: Problem, glass: float, kink: int, v: float, z: float, h: float) -> float:
    """Velocity that a kink takes until z beyond it, at velocity v and within a length h of sigma, at most."""
    path = problem.path
    s, p = path.kinks[kink], path.power
    radius = abs(path.strengths[kink]) * z**p
    force = (glass * 2.0 * s * z / (p + 1.0) + problem.viscosity * v) * radius
    return 2.0 * s * force * min(z / v, h)


@compiled
def next_kink(
    problem: Problem, glass: float, first: int, s: float, v: float, slope: float, h: float, allowed: float
) -> int:
    """First kink, from `first` on, that matters to an element of length h from s; -1 where there is none."""
    kinks = problem.path.kinks
    reach = h * v + max(0.5 * slope, 0.0) * h * h
    if slope < 0.0:
        # Where a body that brakes like this turns, and a little more.
        reach = min(reach, 0.6 * v * v / -slope)
    kink = first
    while kink < kinks.shape[0] and kinks[kink] < s + reach:
        z = min(s + reach - kinks[kink], SPACING * reach)
        if kink_effect(problem, glass, kink, v, z, h) > allowed:
            return kink
        kink += 1
    return -1


@inlined
def length_beyond(problem: Problem, glass: float, kink: int, v: float, h: float, allowed: float) -> float:
    """Length of an element that begins at a kink: at most h, and such that its tail is `allowed`, about."""
    tail = _TAIL * kink_effect(problem, glass, kink, v, h * v, h)
    p = problem.path.power
    power = 1.0 / (p + 1.0) if problem.viscosity > 0.0 else 1.0 / (p + 2.0)
    return h * min(1.0, (allowed / max(tail, 1e-300)) ** power)


@inlined
def passed(kinks: Any, first: int, s: float) -> int:
    """First kink beyond s, from `first` on."""
    kink = first
    while kink < kinks.shape[0] and kinks[kink] <= s:
        kink += 1
    return kink


@compiled
def length_correction(
    problem: Problem,
    scheme: Scheme,
    work: Work,
    table: Any,
    glass: float,
    target: int,
    h: float,
    allowed: float,
) -> float:
    """Factor of the length of a solved element with which it ends at a kink; 1 where that does not matter."""
    end = problem.path.kinks[target]
    s, v = table[S_, WIDTH], table[V_, WIDTH]
    top = 1.0
    if v <= 0.0:
        top = crossing(scheme, work, table[V_], 0.0, 1.0)
        s = value(scheme, work, table[S_], top)
        if s <= end:
            return 1.0
    if kink_effect(problem, glass, target, table[V_, 0], abs(s - end), h) <= 0.1 * allowed:
        return 1.0
    if s > end:
        return crossing(scheme, work, table[S_], end, top)
    return 1.0 + min((end - s) / (v * h), 1.0)
