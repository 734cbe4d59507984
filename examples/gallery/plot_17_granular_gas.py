"""
Cooling of a granular gas
=========================

Balls that collide at random lose energy at each collision. Haff (1983) found how such a gas cools if the coefficient
of restitution is the same at all velocities. It is not: collisions become slower, and the material decides whether
slow collisions lose more or less.
"""

import math

import matplotlib.pyplot as plt
import numba
import numpy as np

import restitution as rs

speed, balls, duration = 0.5, 4_000, 5_000.0
materials = {
    "Kelvin-Voigt": rs.kelvin_voigt(1e6, 40.0, poisson_ratio=0.5, density=1100.0),
    "standard solid": rs.standard_solid(1e6, 3e6, 800.0, poisson_ratio=0.49, density=1100.0),
}


@numba.njit
def cool(velocities, e, low, constant, duration, rng):
    """Temperature over time; in units of the first one, and of the first mean time between collisions of a ball."""
    count = len(velocities)
    first = np.sum(velocities**2) / (3.0 * count)
    mean = math.sqrt(4.0 * first / math.pi)  # of the normal velocity of two balls
    times, temperatures = [0.0], [1.0]
    while times[-1] < duration:
        # No pair is faster than this, but for one in 10^8.
        fastest = 9.0 * math.sqrt(2.0 * first * temperatures[-1])
        for _ in range(count):
            i, j = rng.integers(0, count), rng.integers(0, count)
            direction = rng.normal(0.0, 1.0, 3)
            direction /= math.sqrt(np.sum(direction**2))
            normal = np.sum((velocities[i] - velocities[j]) * direction)
            if i == j or abs(normal) < fastest * rng.random():
                continue
            rebound = constant if constant > 0.0 else e(max(abs(normal), low))
            kick = 0.5 * (1.0 + rebound) * normal * direction
            velocities[i] -= kick
            velocities[j] += kick
        times.append(times[-1] + 2.0 * mean / fastest)
        temperatures.append(np.sum(velocities**2) / (3.0 * count * first))
    return np.array(times), np.array(temperatures)


rng = np.random.default_rng(17)
start = rng.normal(0.0, speed, (balls, 3))
start -= start.mean(axis=0)  # The motion of all together does not cool.
fig, (left, right) = plt.subplots(1, 2, figsize=(8.0, 3.6), layout="constrained")
last = {}
for n, (name, material) in enumerate(materials.items()):
    ball = rs.Body(material, radius=0.005)
    low = 1e-4 * speed
    curve = rs.surrogate(rs.collision(ball, ball, speed), velocity=(low, 15.0 * speed), rtol=1e-4)
    typical = float(curve(math.sqrt(2.0) * speed))
    v = np.geomspace(low, 15.0 * speed, 200)
    left.semilogx(v, curve(v), color=f"C{n}", label=name)
    left.axhline(typical, color=f"C{n}", ls="--", lw=0.8)
    for constant, style in ((0.0, "-"), (typical, "--")):
        t, temperature = cool(start.copy(), curve.compiled(), low, constant, duration, rng)
        words = f"{name}, {'constant e' if constant else 'exact e(v)'}"
        right.loglog(t[1:], temperature[1:], color=f"C{n}", ls=style, label=words)
        last[name, constant > 0.0] = temperature[-1], typical, t[-1]
left.set_xlabel("impact velocity [m/s]")
left.set_ylabel("restitution coefficient $e$")
left.legend()
right.set_xlabel("time over the first time between collisions")
right.set_ylabel("temperature over the first one")
right.legend(fontsize="small")

# %%
# The Kelvin-Voigt gas stays warmer than with a constant coefficient, because slow collisions lose less. The standard
# solid is the other way round here: slow contacts last as long as its relaxation time.

for name in materials:
    exact, constant = last[name, False][0], last[name, True][0]
    print(f"{name}: after {duration:g} times the temperature is {exact:.3g}, with a constant e {constant:.3g}")

# %%
# With a constant coefficient, the temperature is that of Haff's law,
# :math:`T = T_0/(1 + (1 - e^2)\,t/6)^2`, but for the noise and the shape of the distribution of velocities.

for name in materials:
    temperature, e, t = last[name, True]
    haff = 1.0 / (1.0 + (1.0 - e**2) * t / 6.0) ** 2
    print(f"{name}: {temperature:.4g}, Haff {haff:.4g}")
    assert abs(temperature / haff - 1.0) < 0.08
