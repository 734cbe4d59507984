"""
A bead that sticks or bounces
=============================

A polymer bead of 10 µm falls onto a hard wall with and without adhesion. Slow beads stick: the energy that the
material dissipates and that the jumps lose is more than they bring.
"""

import math
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs
from restitution.plot.adhesion import loop

# %%
# A standard solid with a relaxation time of 10 ns, a sixth of the contact. The work of adhesion of polymers on
# glass or silicon is some 50 mJ/m2, and the range of the attraction 0.4 nm.
polymer = rs.standard_solid(1e9, 1e9, 10.0, poisson_ratio=0.35, density=1200.0)
radius = 5e-6
mass = 4.0 / 3.0 * math.pi * radius**3 * 1200.0
bead = rs.Impact(polymer, rs.Parabola(radius), mass=mass, velocity=1.0, diameters=(2.0, math.inf))
sticky = replace(bead, adhesion=rs.Adhesion(work=0.05))

result = rs.solve(sticky, rtol=1e-5)
print(result.summary())
print("Maugis' parameter at rest and at once:", result.maugis_numbers)

# %%
# The velocity below which it sticks, and the restitution coefficient above it.
threshold = rs.sticking_velocity(sticky, rtol=1e-2)
print(f"sticks below {threshold:.3f} m/s")
velocities = np.append(threshold * np.array([0.5, 0.98]), np.geomspace(1.03 * threshold, 10.0, 16))
with_it = rs.solve(replace(sticky, velocity=velocities), rtol=1e-4)
without = rs.solve(replace(bead, velocity=velocities))

figure, (left, right) = plt.subplots(1, 2, figsize=(7.2, 3.0), layout="constrained")
left.plot(velocities, without.restitution_coefficient, color="0.5", label="without adhesion")
left.plot(velocities, with_it.restitution_coefficient, ".-", label="with adhesion")
left.axvline(threshold, color="0.5", linestyle=":")
left.set(xscale="log", xlabel="impact velocity [m/s]", ylabel="restitution coefficient", ylim=(-0.02, 1.0))
left.legend(loc="lower right")
loop(right, result)

# %%
# Far above the threshold both agree. The largest pull lies between the limits of hard and of soft bodies, 2 pi w R and
# 1.5 pi w R, of an elastic body, or above, as the glass at the edge is stiffer than the body at rest.
pull = result.pull_off_force / (math.pi * 0.05 * radius)
print(f"largest pull over pi w R: {pull:.3f}")
assert 1.5 < pull < 4.0
assert abs(with_it.restitution_coefficient[-1] - without.restitution_coefficient[-1]) < 0.02
assert with_it.restitution_coefficient[1] == 0.0 < with_it.restitution_coefficient[2]
