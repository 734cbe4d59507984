r"""
A triangle under an atomic force microscope
===========================================

A tip of 2.5 µm radius is pressed into a gel at 1 µm/s for one second and pulled back at the same speed. The gel
relaxes from 1000 Pa to 200 Pa in tension, with a relaxation time of 0.3 s. The contact ends before the tip returns to
the surface, because the imprint has not recovered. The depth is beyond small strain: :math:`a/R` reaches 0.63.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs
from restitution.plot.history import force_indentation, force_time

tension = rs.PronySeries(200.0, [800.0], [0.3])
gel = rs.Material(tension.scaled(1.0 / 3.0), bulk=math.inf)  # incompressible: G = E/3
tip = rs.Parabola(radius=2.5e-6)
result = rs.indent(gel, tip, depth=rs.triangle(1e-6, 1.0))

fig, (left, right) = plt.subplots(1, 2, figsize=(8.0, 3.6), layout="constrained")
force_time(left, result.history)
force_indentation(right, result.history)

# %%
# An independent quadrature of Ting's equations gives a largest force of 1.38541713e-9 N, a force of 2.32146714e-10 N
# at 1.25 s, and an end of the contact near 1.41 s.

late = float(result.sample([1.25]).force[0])
print(f"largest force {result.max_force:.8e} N, at 1.25 s {late:.8e} N, end at {result.contact_end_time:.4f} s")
assert abs(result.max_force / 1.38541713e-9 - 1.0) < 1e-8
assert abs(late / 2.32146714e-10 - 1.0) < 1e-8
assert abs(result.contact_end_time - 1.41) < 0.005

# %%
# Under a constant force the depth creeps: :math:`a^3(t) = \tfrac34 R F J^*(t)` with the creep compliance of
# the reduced modulus (Lee and Radok 1960), here :math:`E^*(t) = \tfrac43 E(t)`.

times = np.linspace(0.0, 2.0, 201)
creep = rs.indent(gel, tip, force=1e-9, time=times)
closed_form = (0.75 * tip.radius * 1e-9 * tension.scaled(4.0 / 3.0).creep_compliance(times)) ** (1.0 / 3.0)

fig, ax = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
ax.plot(times, 1e6 * creep.contact_radius, label="computed")
ax.plot(times[::20], 1e6 * closed_form[::20], "o", markersize=4, label="closed form")
ax.set_xlabel("time [s]")
ax.set_ylabel("contact radius [µm]")
ax.legend()
assert np.allclose(creep.contact_radius, closed_form, rtol=1e-7)
