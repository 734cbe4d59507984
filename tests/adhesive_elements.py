"""Independent adhesive impact: equal elements and equal steps in the text-book form, without any event in a step.

Each element has one displacement and one load for each Maxwell branch, linear over a step. The gap at the edge of the
attraction comes from the midpoint rule over the angle. Errors are some 1e-4, as events end between steps.
"""

import numpy as np

ANGLES = 0.5 * np.pi * (np.arange(400) + 0.5) / 400


def adhesive_restitution(material, work, stress, velocity, *, width=1.0, elements=800, steps=2000):
    """E of a unit parabola of unit mass; `steps` for each unit of time, `width` is the room for the zone.

    `material` has the equilibrium modulus, the moduli of the branches, and their times.
    """
    equilibrium, moduli, times = material
    E, tau = np.array(moduli, dtype=float)[:, None], np.array(times, dtype=float)[:, None]
    h, dt, reach = width / elements, 1.0 / steps, work / stress
    x = h * (np.arange(elements) + 0.5)
    W, loads = np.zeros(elements), np.zeros((E.size, elements))
    fade = np.exp(-dt / tau)
    gain = E * tau * (1.0 - fade) / dt
    soft = equilibrium + gain.sum()
    d, v, force, c = -reach, velocity, 0.0, 0.0

    def surface(c, d):
        pull = -2.0 * stress * np.sqrt(np.maximum(c * c - x * x, 0.0))
        return np.maximum((pull - (fade * loads).sum(0) + gain.sum() * W) / soft, d - x * x)

    def excess(c, d):
        if c <= 0.0:
            return 0.5 * np.pi * (surface(0.0, d)[0] - d) - 0.5 * np.pi * reach
        gap = surface(c, d) - d + x * x
        return np.interp(c * np.sin(ANGLES), x, gap).mean() * 0.5 * np.pi - 0.5 * np.pi * reach

    for n in range(40 * steps):
        d += dt * v - 0.5 * dt * dt * force
        # Down the slope of the energy, to the next root.
        way = 1.0 if excess(c, d) < 0.0 else -1.0
        low = c
        while True:
            high = max(low + way * h, 0.0)
            if way * excess(high, d) >= 0.0 or high == 0.0:
                break
            low = high
        for _ in range(40):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if way * excess(middle, d) < 0.0 else (low, middle)
        c = high
        after = surface(c, d)
        loads = fade * loads + gain * (after - W)
        W = after
        new = 2.0 * h * (equilibrium * W + loads.sum(0)).sum()
        v -= 0.5 * dt * (force + new)
        force = new
        if c == 0.0 and v < 0.0 and n > 10:
            return -v / velocity
    raise RuntimeError("the body did not leave")


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
