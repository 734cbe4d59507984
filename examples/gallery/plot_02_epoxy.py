"""
Restitution of a measured epoxy over the velocity
=================================================

A steel ball hits a block of cured epoxy near its glass transition. Simon, McKenna and Sindt (2000) measured its
relaxation in shear over twelve decades of time. The bulk modulus of 3 GPa is assumed.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs

epoxy = rs.library.get("epoxy")
radius = 0.005
mass = 7800.0 * 4.0 / 3.0 * math.pi * radius**3
velocity = np.geomspace(1e-4, 10.0, 61)
result = rs.solve(rs.Impact(epoxy, rs.Parabola(radius), mass, velocity))

fig, (left, right) = plt.subplots(1, 2, figsize=(8.0, 3.4), layout="constrained")
t = np.geomspace(*epoxy.window, 200)
left.loglog(t, 1e-6 * epoxy.shear.relaxation_modulus(t))
left.axvspan(result.contact_time.min(), result.contact_time.max(), color="0.85", label="contact times")
left.set_xlabel("time [s]")
left.set_ylabel("relaxation modulus in shear [MPa]")
left.legend()
right.semilogx(velocity, result.restitution_coefficient)
right.set_xlabel("impact velocity [m/s]")
right.set_ylabel("restitution coefficient $e$")

# %%
# The contact times are far shorter than the glass transition. The losses in these contacts come from the slow
# relaxation of the glass, and depend little on the velocity.

e = rs.solve(rs.Impact(epoxy, rs.Parabola(radius), mass, velocity=1.0)).restitution_coefficient
print(f"e at 1 m/s = {e:.10f}")

# %%
# An integration by SciPy, which shares only the data with the package, gives 0.9492797415
# (``validation/gallery_numbers.py``).

assert abs(e - 0.9492797415) < 1e-9
