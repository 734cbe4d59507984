"""The paper's element method, compiled: equations (7) to (9) in plain loops, in units m = R = v0 = Ginf = 1.

`restitution.impact.elements` is the same in NumPy. These compiled loops make the benchmarks compare the methods, not
their implementations.
"""

import math

import numba
import numpy as np

STEPS_PER_ELEMENT = 25
"""Steps for each element in contact: the time step is 3 d_m/(25 v0 n), as in `restitution.impact.elements`."""


@numba.njit(fastmath={"contract"}, error_model="numpy")
def restitution(nu: float, p2: float, p3: float, depth: float, n: int, most: int) -> tuple[float, int]:
    """Restitution coefficient and number of steps with n elements up to a given depth; NaN beyond `most` steps."""
    g1, eta = 1.0 / p2, p3
    incompressible = nu == 0.5
    k0 = 0.0 if incompressible else 2.0 * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu))
    side = 1.0 / 3.0 + k0
    stiffness = g1 + 1.0 + side + g1 / 3.0
    # The shorter of the two relaxation times is eta/G1.
    step = min(3.0 * depth / (STEPS_PER_ELEMENT * n), 0.5 * eta / g1)
    if 3.0 * depth / step > most:
        return math.nan, 0
    spacing = 2.0 * math.sqrt(depth) / n
    rate = step * g1 / eta
    half = n
    g = ((np.arange(half) + 0.5) * spacing) ** 2
    u, u1, u2, u3 = np.zeros((4, half))
    touching = np.zeros(half, dtype=np.bool_)
    d, v, deepest, born, steps = 0.0, 1.0, 0.0, 0, 0
    while True:
        if d >= deepest:
            deepest = d
            while born < half and g[born] <= d:
                touching[born] = True
                born += 1
        force, left = 0.0, 0
        for i in range(born):
            if not touching[i]:
                continue
            displacement = d - g[i]
            growth = displacement - u[i]
            u[i] = displacement
            lag = u3[i] - u2[i] - rate * u3[i]
            u1[i] += growth - rate * (u1[i] - u2[i])
            u2[i] = displacement if incompressible else (side * displacement + g1 / 3.0 * u1[i] - g1 * lag) / stiffness
            u3[i] = u2[i] + lag
            load = u2[i] + g1 * u3[i]
            if load < 0.0:
                touching[i] = False
            else:
                force += load
                left += 1
        steps += 1
        if steps > 1 and left == 0 and born > 0:
            return -v, steps
        if steps > most:
            return math.nan, steps
        d, v = d + step * v, v - step * 8.0 * spacing * force
