"""Independent adhesive contacts of a unit parabola by elements of Maxwell branches.

An element has a displacement W and one load S for each branch, and W is linear over a step. Nothing of the package is
used: elements lie in the middle of cells, loads are those of the modulus, and steps have any length.

`adhesive_restitution` follows an impact. Steps become shorter until the edge moves by less than a cell, which ends
them at the folds; a jump is a step of no time. `Held` has steps of one length, and errors of some 1e-4 at its events.
"""

import math
from typing import Any, NamedTuple

import numba
import numpy as np

ANGLES = 0.5 * np.pi * (np.arange(400) + 0.5) / 400
# Shortest step over the longest, and the one below which the sign of a gap may be rounding.
SHORTEST, ROUNDED = 1e-13, 1e-6
# Steps at most, over the number of elements.
MOST = 100


class Elements(NamedTuple):
    """Places, displacements, loads of the branches, and displacements at the end of a step without load."""

    x: Any
    W: Any
    loads: Any
    B: Any


@numba.njit
def pull(stress, edge, x):
    """Load of the attraction on an element."""
    return -2.0 * stress * math.sqrt(max((edge - x) * (edge + x), 0.0))


@numba.njit
def branch(modulus, time, dt):
    """What is left of the load of a branch after a step, and what a line of W adds over its rise."""
    return (math.exp(-dt / time), -modulus * math.expm1(-dt / time) * time / dt) if dt > 0.0 else (1.0, modulus)


@numba.njit
def unloaded(material, dt, elements):
    """Write the displacements B of elements without load at the end of a step; return load over displacement."""
    equilibrium, moduli, times = material
    _, W, loads, B = elements
    stiff = equilibrium
    B[:] = 0.0
    for k in range(times.size):
        fade, gain = branch(moduli[k], times[k], dt)
        stiff += gain
        for i in range(B.size):
            B[i] += gain * W[i] - fade * loads[k, i]
    B /= stiff
    return stiff


@numba.njit
def excess(edge, depth, stiff, adhesion, elements):
    """Mean gap on the circle of the edge less the range, times pi/2; contact radius, and elements in contact.

    ``int (W - d + x^2)/sqrt(c^2 - x^2) dx`` from a to c, with B linear between elements and the rest exact.
    """
    (stress, reach), x, B = adhesion, elements.x, elements.B
    if edge > x[-2]:
        raise ValueError("the zone is wider than its room")
    if edge <= 0.0:
        top = max((9.0 * B[0] - B[1]) / 8.0 - depth, 0.0)
        return 0.5 * math.pi * (top - reach), 0.0, 1 if B[0] - depth + x[0] ** 2 <= 0.0 else 0
    count, gap, last, h = 0, 0.0, 0.0, x[1] - x[0]
    while True:
        gap = B[count] + pull(stress, edge, x[count]) / stiff - depth + x[count] ** 2
        if gap > 0.0:
            break
        count, last = count + 1, gap
    radius = x[count - 1] + h * last / (last - gap) if count > 0 else 0.0
    if radius >= edge:
        return -0.5 * math.pi * reach, radius, count
    low, angle, root = radius, math.asin(radius / edge), math.sqrt((edge - radius) * (edge + radius))
    rest = 0.5 * math.pi - angle
    total = -2.0 * stress * (edge - radius) / stiff - 0.5 * math.pi * reach
    total += 0.5 * (edge * edge * rest + radius * root) - depth * rest
    i = max(int(radius / h - 0.5), 0)
    while low < edge:
        low = min(x[i + 1], edge)
        after, root1 = math.asin(low / edge), math.sqrt((edge - low) * (edge + low))
        slope = (B[i + 1] - B[i]) / h
        total += (B[i] - slope * x[i]) * (after - angle) + slope * (root - root1)
        angle, root, i = after, root1, i + 1
    return total, radius, count


@numba.njit
def between(first, second, depth, stiff, adhesion, elements):
    """Edge at which the excess vanishes between two edges and their excess, by regula falsi."""
    (low, f_low), (high, f_high) = first, second
    edge, side = high, 0
    for n in range(80):
        edge = (low * f_high - high * f_low) / (f_high - f_low)
        if n % 12 == 11 or not min(low, high) < edge < max(low, high):
            edge = 0.5 * (low + high)
        f = excess(edge, depth, stiff, adhesion, elements)[0]
        if abs(f) < 1e-14 or abs(high - low) < 1e-15:
            break
        if (f > 0.0) == (f_high > 0.0):
            f_low *= 0.5 if side == 1 else 1.0
            high, f_high, side = edge, f, 1
        else:
            f_high *= 0.5 if side == -1 else 1.0
            low, f_low, side = edge, f, -1
    return edge


@numba.njit
def take(material, dt, edge, depth, stiff, stress, elements, contact):
    """Take displacements and loads over a step; return the force."""
    (_, moduli, times), (x, W, loads, B), (radius, count) = material, elements, contact
    h, total, last, before = x[1] - x[0], 0.0, 0.0, 0.0
    for i in range(x.size):
        load = pull(stress, edge, x[i])
        new = depth - x[i] ** 2 if i < count else B[i] + load / stiff
        if i < count:
            total, before, last = total + h * last, last, stiff * (new - B[i]) - load
        for k in range(times.size):
            fade, gain = branch(moduli[k], times[k], dt)
            loads[k, i] = fade * loads[k, i] + gain * (new - W[i])
        W[i] = new
    if count > 0:
        # Half a cell before the last element in contact, and a line to zero behind it.
        slope = (before - last) / h if count > 1 else 0.0
        total += 0.5 * h * (last + 0.25 * h * slope) + 0.5 * last * (radius - x[count - 1])
    return 2.0 * total - math.pi * stress * edge * edge


@numba.njit
def impact(material, adhesion, velocity, weight, x, longest):
    """Return e and the number of jumps of a unit parabola of unit mass and of this weight."""
    stress, reach = adhesion
    elements = Elements(x, np.zeros(x.size), np.zeros((material[2].size, x.size)), np.zeros(x.size))
    depth, speed, force, edge, jumps = -reach, velocity, 0.0, 0.0, 0
    # The attraction begins with a jump.
    dt, way, cell = 0.0, 1.0, x[1] - x[0]
    for _ in range(MOST * x.size):
        after, f, high, f_high, stiff, stays = depth, 0.0, edge, 0.0, 1.0, False
        while dt > SHORTEST * longest and not stays:
            after = depth + dt * speed + 0.5 * dt * dt * (weight - force)
            stiff = unloaded(material, dt, elements)
            f = excess(edge, after, stiff, adhesion, elements)[0]
            if dt > ROUNDED * longest:
                way = -1.0 if f > 0.0 else 1.0
            # Near a fold the edge has two roots within a cell.
            for share in (1.0, 0.1, 0.01):
                high = max(edge + share * way * cell, 0.0)
                f_high = excess(high, after, stiff, adhesion, elements)[0]
                stays = way * f_high >= 0.0
                if stays:
                    break
            dt *= 1.0 if stays else 0.5
        if stays:
            new = edge if way * f >= 0.0 else between((edge, f), (high, f_high), after, stiff, adhesion, elements)
        else:
            dt, after, jumps = 0.0, depth, jumps + 1
            stiff = unloaded(material, dt, elements)
            high, f_high, low, f = edge, -way, edge, -way
            while way * f_high < 0.0 and (high > 0.0 or high == edge):
                low, f = high, f_high
                high = max(low + way * cell, 0.0)
                f_high = excess(high, after, stiff, adhesion, elements)[0]
            new = between((low, f), (high, f_high), after, stiff, adhesion, elements) if way * f_high > 0.0 else high
        _, radius, count = excess(new, after, stiff, adhesion, elements)
        before = force
        force = take(material, dt, new, after, stiff, stress, elements, (radius, count))
        speed += dt * (weight - 0.5 * (before + force))
        moved, depth, edge = abs(new - edge), after, new
        if edge == 0.0 and speed < 0.0:
            return -speed / velocity, jumps
        if dt == 0.0:
            dt = 0.01 * longest
        elif moved < cell / 3.0:
            dt = min(2.0 * dt, longest)
    return math.nan, jumps


def adhesive_restitution(material, work, stress, velocity, *, weight=0.0, width=1.0, elements=800):
    """E of a unit parabola of unit mass and its number of jumps, of second order in the elements and steps.

    `material` has the equilibrium modulus, the moduli of the branches, and their times; `width` is the room for the
    zone. Steps are at most twice the distance of elements long.
    """
    equilibrium, moduli, times = material
    solid = float(equilibrium), np.array(moduli, dtype=float), np.array(times, dtype=float)
    x = width / elements * (np.arange(elements) + 0.5)
    e, jumps = impact(solid, (float(stress), work / stress), float(velocity), float(weight), x, 2.0 / elements)
    return float(e), int(jumps)


def extrapolated_restitution(material, work, stress, velocity, *, weight=0.0, width=1.0, elements=800):
    """E extrapolated from N and 2N elements, and the numbers with both."""
    rough, fine = (
        adhesive_restitution(material, work, stress, velocity, weight=weight, width=width, elements=n)[0]
        for n in (elements, 2 * elements)
    )
    return (4.0 * fine - rough) / 3.0, rough, fine


class Held:
    """Elements of a unit parabola held by a spring; without stiffness under a force."""

    def __init__(self, material, work, stress, stiffness, *, width, elements, dt):
        equilibrium, moduli, times = material
        E, tau = np.array(moduli, dtype=float)[:, None], np.array(times, dtype=float)[:, None]
        self.h, self.reach, self.stress, self.stiffness = width / elements, work / stress, stress, stiffness
        self.x = self.h * (np.arange(elements) + 0.5)
        self.W, self.loads = np.zeros(elements), np.zeros((E.size, elements))
        self.fade = np.exp(-dt / tau)
        self.gain = E * tau * (1.0 - self.fade) / dt
        self.soft = float(equilibrium + self.gain.sum())

    def state(self, c, load):
        """Displacements, depth and excess with an edge; None where no depth bears the load."""
        x, h, stiffness, soft = self.x, self.h, self.stiffness, self.soft
        pull = -2.0 * self.stress * np.sqrt(np.maximum(c * c - x * x, 0.0))
        free = (pull - (self.fade * self.loads).sum(0) + self.gain.sum() * self.W) / soft
        # Force without contact, then with the elements of the lowest thresholds: piecewise linear in the depth.
        thresholds = np.sort(free + x * x)
        gap = load - 2.0 * h * pull.sum()
        if gap <= stiffness * thresholds[0]:
            if not stiffness:
                return None
            depth = gap / stiffness
        else:
            counts = np.arange(1, x.size + 1)
            depths = (gap + 2.0 * h * soft * np.cumsum(thresholds)) / (2.0 * h * soft * counts + stiffness)
            good = (depths > thresholds) & (depths <= np.append(thresholds[1:], np.inf))
            depth = depths[np.argmax(good)]
        moved = np.maximum(free, depth - x * x)
        there = moved[0] - depth if c <= 0.0 else np.interp(c * np.sin(ANGLES), x, moved - depth + x * x).mean()
        return moved, depth, there - self.reach

    def edge(self, c, load):
        """Edge down the slope of the energy from an earlier one."""

        def excess(c):
            result = self.state(c, load)
            if result is None:
                return -1.0 if c <= 0.0 and load >= 0.0 else 1.0
            return result[2]

        way = 1.0 if excess(c) < 0.0 else -1.0
        low = c
        while True:
            high = max(low + way * self.h, 0.0)
            if way * excess(high) >= 0.0 or high == 0.0:
                break
            low = high
        for _ in range(30):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if way * excess(middle) < 0.0 else (low, middle)
        return high

    def take(self, moved):
        """Take the displacements at the end of a step."""
        self.loads = self.fade * self.loads + self.gain * (moved - self.W)
        self.W = moved


def adhesive_program(held, values, times, steps):
    """Times, depths and forces until the body is away, along straight lines of the depth of the base or of the force.

    There are `steps` for each unit of time.
    """
    start = float(np.interp(-held.reach, values[:2], times[:2])) if held.stiffness else 0.0
    rows, c = [], 0.0
    for n in range(int((times[-1] - start) * steps)):
        moment = start + n / steps
        load = (held.stiffness or 1.0) * float(np.interp(moment, times, values))
        c = held.edge(c, load)
        if c == 0.0 and n > 10:
            rows.append((moment, rows[-1][1], 0.0))
            return np.array(rows).T
        moved, depth, _ = held.state(c, load)
        held.take(moved)
        rows.append((moment, depth, load - held.stiffness * depth))
    raise RuntimeError("the body did not leave")
