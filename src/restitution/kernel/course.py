"""Roots of G that end a step: how long the edge takes to an element, and where it is after the longest step.

Where the edge keeps its course, a root is near to what its speeds in the last two steps let expect, and two or three
trials find it. Elsewhere it is searched between bounds. See `restitution.kernel.adhesion` for G.
"""

import math

from restitution.kernel.compile import compiled, inlined
from restitution.kernel.edge import excess
from restitution.kernel.zone import (
    BEFORE_,
    C_,
    D_,
    FALLS_,
    LAST_,
    SPEED0_,
    SPEED_,
    Bodies,
    Room,
    Solid,
)

# G over range and depth at a root; trials of a search between bounds, and from a guess.
_ROOT, _MOST_ROOTS, _SOON = 1e-13, 80, 5
# Speed of the edge in the last step over that of the next one, below which a fold may be near.
_SHORTER = 0.75


@compiled
def root(
    solid: Solid, bodies: Bodies, in_time: bool, fixed: float, bounds: tuple[float, float, float, float], room: Room
) -> float:
    """Return the length of a step, or the edge at its end, at which G vanishes between bounds of other sign.

    The bounds are the lower one and G there, the upper one and G there. The method is that of Anderson and Bjorck.
    """
    low, f_low, high, f_high = bounds
    small = _ROOT * (bodies.reach + abs(room.now[D_]))
    x, side = low, 0
    for n in range(_MOST_ROOTS):
        x = (low * f_high - high * f_low) / (f_high - f_low)
        if n == 0 and in_time and low < room.ends[LAST_] < high:
            x = room.ends[LAST_]
        if not min(low, high) < x < max(low, high) or n % 16 == 15:
            x = 0.5 * (low + high)
        f = excess(solid, bodies, x, fixed, room) if in_time else excess(solid, bodies, fixed, x, room)
        if abs(f) <= small or abs(high - low) <= 1e-15 * abs(x):
            break
        if (f > 0.0) == (f_high > 0.0):
            if side == 1:
                share = 1.0 - f / f_high
                f_low *= share if share > 0.0 else 0.5
            high, f_high, side = x, f, 1
        else:
            if side == -1:
                share = 1.0 - f / f_low
                f_high *= share if share > 0.0 else 0.5
            low, f_low, side = x, f, -1
    return x


@inlined
def arrival(way: int, after: float, room: Room) -> float:
    """Return when the edge reaches an element, by its speeds in the last two steps; infinite if it does not."""
    ends = room.ends
    if not ends[BEFORE_] > 0.0:
        return math.inf
    gain = 2.0 * way * (ends[SPEED_] - ends[SPEED0_]) / (ends[LAST_] + ends[BEFORE_])
    speed, distance = way * ends[SPEED_] + 0.5 * gain * ends[LAST_], way * (after - room.now[C_])
    square = speed * speed + 2.0 * gain * distance
    if square < 0.0 or speed <= 0.0:
        return math.inf
    return 2.0 * distance / (speed + math.sqrt(square))


@inlined
def hurries(dt: float, after: float, room: Room) -> bool:
    """Return whether the edge would be much faster than in the last step, as it is before a fold."""
    return _SHORTER * abs(after - room.now[C_]) >= abs(room.ends[SPEED_]) * dt


@compiled
def arrive(solid: Solid, bodies: Bodies, way: int, after: float, guess: float, room: Room) -> float:
    """Return the length of a step to an edge from a guess; NaN where that does not find it soon.

    Before a fold G must have the sign of the way for a step of no time. The method is inverse interpolation.
    """
    small = _ROOT * (bodies.reach + abs(room.now[D_]))
    x, f0, f1, slope = guess, 0.0, 0.0, 0.0
    if room.ends[FALLS_] != 0.0:
        slope = way / room.ends[FALLS_]
    if slope >= 0.0 or hurries(x, after, room):
        f1 = way * excess(solid, bodies, 0.0, after, room)
        if not f1 > 0.0:
            return math.nan
        slope = 0.0
    f = way * excess(solid, bodies, x, after, room)
    if slope == 0.0:
        slope = x / (f - f1)
    step = -f * slope
    for _ in range(_SOON):
        if abs(f) <= small:
            room.ends[FALLS_] = way / slope
            return x
        # Beyond the longest step, or backwards, as G grows.
        if not 0.0 < x + step < bodies.longest or not slope < 0.0:
            break
        f0, x1, f1, x = f1, x, f, x + step
        f = way * excess(solid, bodies, x, after, room)
        before, slope = slope, (x - x1) / (f - f1)
        step = -f * slope
        if f0 != 0.0:
            step += f * f1 * (slope - before) / (f - f0)
    return math.nan


@compiled
def move(solid: Solid, bodies: Bodies, way: int, after: float, room: Room) -> float:
    """Return the edge after the longest step, before it reaches an element, by its speeds; NaN if not found soon."""
    ends, edge, dt = room.ends, room.now[C_], bodies.longest
    small = _ROOT * (bodies.reach + abs(room.now[D_]))
    if not ends[BEFORE_] > 0.0 or not way * ends[FALLS_] < 0.0:
        return math.nan
    gain = 2.0 * (ends[SPEED_] - ends[SPEED0_]) / (ends[LAST_] + ends[BEFORE_])
    x = edge + dt * (ends[SPEED_] + 0.5 * gain * (ends[LAST_] + dt))
    # Along the way of the edge G stays zero.
    slope = -(ends[SPEED_] + gain * (0.5 * ends[LAST_] + dt)) / ends[FALLS_]
    x1, f1 = x, 0.0
    for n in range(_SOON):
        if not 0.0 < way * (x - edge) < way * (after - edge) or not slope > 0.0:
            break
        f = excess(solid, bodies, dt, x, room)
        if abs(f) <= small:
            return x
        if n > 0:
            slope = (x - x1) / (f - f1)
        x1, f1, x = x, f, x - f * slope
    return math.nan
