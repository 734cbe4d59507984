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
