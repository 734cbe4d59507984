r"""
Pressure at four instants
=========================

While the contact grows, the material at the edge is newly loaded and stiffer than the relaxed material in the middle.
While it shrinks, the pressure at the edge is zero and an imprint remains outside.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import quad

import restitution as rs
from restitution.plot.impact import instants, pressure_radius

rubber = rs.standard_solid(2e6, 20e6, 2e3, poisson_ratio=0.45)
result = rs.solve(rs.Impact(rubber, rs.Parabola(0.015), mass=0.0156, velocity=0.5))

fig, (left, right) = plt.subplots(1, 2, figsize=(8.0, 3.6), layout="constrained")
pressure_radius(left, result)
r = np.linspace(0.0, 2.0 * result.max_contact_radius, 200)
for line, t in zip(left.lines, instants(result), strict=True):
    style = {"color": line.get_color(), "linestyle": line.get_linestyle()}
    right.plot(1e3 * r, -1e3 * result.surface_displacement(r, t), **style)
right.set_xlabel("radius $r$ [mm]")
right.set_ylabel("height of the surface [mm]")

# %%
# The integral of the pressure over the contact must equal the force, which follows from the equations of motion. The
# check uses SciPy's quadrature with :math:`r = a\sin\theta`:

for t in instants(result):
    motion = result.sample([t])
    a, force = float(motion.contact_radius[0]), float(motion.force[0])
    integral = quad(
        lambda angle, a=a, t=t: (
            2.0 * np.pi * a**2 * np.sin(angle) * np.cos(angle) * result.pressure(a * np.sin(angle), t)
        ),
        0.0,
        0.5 * np.pi,
        epsabs=0.0,
        epsrel=1e-9,
        limit=200,
    )[0]
    print(f"t = {1e3 * t:.3f} ms: force {force:.9f} N, integral of the pressure {integral:.9f} N")
    assert abs(integral / force - 1.0) < 1e-8
