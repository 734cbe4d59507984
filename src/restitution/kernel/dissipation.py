"""What elements with memory dissipate in a step of the attraction, with their memory at its end.

An element dissipates ``sum c_k int (q - r_k M_k)^2 dt`` over a step in which its load q is a line, or one line to each
side of the instant at which it touches or leaves. Elements in the ring, which are loaded throughout, also have their
gap from it.
"""

import math

from restitution.kernel.compile import compiled, inlined
from restitution.kernel.zone import (
    ASTRAY_,
    BASE_,
    BUMP_,
    DECAY_,
    FALL_,
    G_,
    H_,
    IN1_,
    IN_,
    KINK_,
    LOST_,
    MEAN_,
    P1_,
    P_,
    PART_,
    Q1_,
    Q_,
    REST_,
    RISE_,
    SHAPE_,
    SHARE_,
    Room,
    Solid,
    dot,
)

# Rate times step below which the rate of a mode is linear over a step.
_LINEAR = 1e-3
ROUNDED = 1e-14
"""Load or gap that is rounding, of an element that is judged twice."""


@inlined
def _spent(time: float, before: float, slope: float, decay: float, dt: float) -> float:
    """Return the integral of (q - r M)^2 over a step, from its value at the start; 1/r is the time.

    The load has this slope.
    """
    steady = slope * time
    rest = before - steady
    return steady * steady * dt + rest * (1.0 - decay) * (2.0 * steady + 0.5 * rest * (1.0 + decay)) * time


@inlined
def _spent_on_line(rate: float, before: float, slope: float, dt: float) -> tuple[float, float]:
    """Return the integral of (q - r M)^2 over a line of the load, and q - r M at its end."""
    z = rate * dt
    if z < _LINEAR:
        after = (before + slope * dt * (1.0 - 0.5 * z)) - z * (1.0 - 0.5 * z) * before
        return dt / 3.0 * (before * before + before * after + after * after), after
    decay = math.exp(-z)
    return _spent(1.0 / rate, before, slope, decay, dt), slope / rate * (1.0 - decay) + before * decay


@compiled
def _spent_in_parts(solid: Solid, dt: float, i: int, before: float, after: float, room: Room) -> float:
    """Return what an element dissipates in a step in which it touches or leaves; its load has a line to each side."""
    part, kink, spent = room.nodes[PART_, i], room.nodes[KINK_, i], 0.0
    early, late = part * dt, (1.0 - part) * dt
    for k in range(solid.rates.shape[0]):
        rate, first, second = solid.rates[k], 0.0, 0.0
        start = before - rate * room.memory[k, i]
        middle = start + kink - before
        if early > 0.0:
            first, middle = _spent_on_line(rate, start, (kink - before) / early, early)
        if late > 0.0:
            second, middle = _spent_on_line(rate, middle, (after - kink) / late, late)
        spent += solid.weights[k] * (first + second)
    return spent


@compiled
def remember(solid: Solid, dt: float, low: int, top: int, room: Room) -> float:
    """Take the memory of elements over a step; return what they dissipate."""
    nodes, per, size = room.nodes, 1.0 / dt, top - low
    load, press = nodes[Q_, low:top], nodes[P_, low:top]
    load1, press1 = nodes[Q1_, low:top], nodes[P1_, low:top]
    # Two rows that the next step writes anew.
    before, after = nodes[BASE_, low:top], nodes[REST_, low:top]
    bump, lost = nodes[BUMP_, low:top], nodes[LOST_, low:top]
    for i in range(size):
        before[i] = load[i] + press[i]
    for i in range(size):
        after[i] = load1[i] + press1[i]
    for i in range(size):
        lost[i] = 0.0
    count, count1 = room.counts[IN_] - low, room.counts[IN1_] - low
    first, last = min(count, count1), min(max(count, count1), size)
    # The ring passes an element within the step that has no cohesive load at one end of it.
    for i in range(first, last):
        if load[i] == 0.0 or load1[i] == 0.0:
            nodes[KINK_, low + i] = _spent_in_parts(solid, dt, low + i, before[i], after[i], room)
    for k in range(solid.rates.shape[0]):
        factors, memory, rate, weight = room.factors[k], room.memory[k, low:top], solid.rates[k], solid.weights[k]
        decay, fall, rise, mean = factors[DECAY_], factors[FALL_], factors[RISE_], factors[MEAN_] * per
        if rate * dt < _LINEAR:
            share = weight * dt / 3.0
            for i in range(size):
                old = memory[i]
                new = decay * old + fall * before[i] + rise * after[i] + mean * bump[i]
                memory[i] = new
                start, end = before[i] - rate * old, after[i] - rate * new
                lost[i] += share * (start * start + start * end + end * end)
        else:
            slow = 1.0 / rate
            for i in range(size):
                old = memory[i]
                new = decay * old + fall * before[i] + rise * after[i] + mean * bump[i]
                memory[i] = new
                lost[i] += weight * _spent(slow, before[i] - rate * old, (after[i] - before[i]) * per, decay, dt)
    for i in range(first, last):
        if load[i] == 0.0 or load1[i] == 0.0:
            lost[i] = nodes[KINK_, low + i]
    return dot(nodes[SHARE_, low:top], lost)


@compiled
def take_ring(solid: Solid, dt: float, depth: float, low: int, top: int, room: Room) -> float:
    """Take elements that are loaded before and after a step to its end; return what they dissipate.

    Their gap is ``g - d + J0 q + sum c_j M_j``.
    """
    nodes, per, size = room.nodes, 1.0 / dt if dt > 0.0 else 0.0, max(top - low, 0)
    before, after, shape = nodes[Q_, low:top], nodes[Q1_, low:top], nodes[SHAPE_, low:top]
    gap, lost, undeformed = nodes[H_, low:top], nodes[LOST_, low:top], nodes[G_, low:top]
    for i in range(size):
        gap[i], lost[i] = undeformed[i] - depth + solid.compliance * after[i], 0.0
    for k in range(solid.rates.shape[0]):
        factors, memory, rate, weight = room.factors[k], room.memory[k, low:top], solid.rates[k], solid.weights[k]
        decay, fall, rise, mean = factors[DECAY_], factors[FALL_], factors[RISE_], factors[MEAN_]
        if rate * dt < _LINEAR:
            share = weight * dt / 3.0
            for i in range(size):
                old = memory[i]
                new = decay * old + fall * before[i] + rise * after[i] + mean * shape[i]
                memory[i] = new
                gap[i] += weight * new
                start, end = before[i] - rate * old, after[i] - rate * new
                lost[i] += share * (start * start + start * end + end * end)
        else:
            slow = 1.0 / rate
            for i in range(size):
                old = memory[i]
                new = decay * old + fall * before[i] + rise * after[i] + mean * shape[i]
                memory[i] = new
                gap[i] += weight * new
                lost[i] += weight * _spent(slow, before[i] - rate * old, (after[i] - before[i]) * per, decay, dt)
    astray = 0
    for i in range(size):
        before[i] = after[i]
        astray += 0 if gap[i] >= -ROUNDED else 1
    room.counts[ASTRAY_] += astray
    return dot(nodes[SHARE_, low:top], lost)
