"""
A nanoindentation with nine partial unloads
===========================================

A cone with the area of a Berkovich tip (70.3 degrees) is pressed into a glassy polymer, nine times a tenth of a
micrometre deeper, with a partial unloading after each step and a full one at the end. The contact shrinks in each
unloading and grows again over elements that have relaxed for different times.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs

polymer = rs.standard_solid(1.2e9, 0.8e9, 4e9, poisson_ratio=0.4)
tip = rs.Cone(half_angle=math.radians(70.3))

peaks = 1e-7 * np.arange(1, 10)
depth = np.concatenate([[0.0], np.column_stack([peaks, 0.7 * peaks]).ravel(), [0.0]])
time = np.concatenate([[0.0], np.cumsum([2.0, 1.0] * 9), [30.0]])
result = rs.indent(polymer, tip, depth=depth, time=time)

moments = np.linspace(0.0, time[-1], 4001)
history = result.sample(moments)
fig, (loops, radii) = plt.subplots(1, 2, figsize=(7.0, 3.0), layout="constrained")
loops.plot(history.indentation_depth * 1e9, history.force * 1e3)
loops.set(xlabel="depth [nm]", ylabel="force [mN]")
radii.plot(moments, history.contact_radius * 1e6)
radii.set(xlabel="time [s]", ylabel="contact radius [µm]")

# %%
# The slope at the start of an unloading, over the diameter of the contact, is read as a modulus (Oliver and Pharr).
# It is too large here, as the force also falls by relaxation: by 9 % in the first unloading and by 5 % in the ninth.
#
# Elements followed one by one (``tests/element_follower.py``) give 7.27100766724 mN at the ninth peak.

turns = time[[1, 17]]
before, after = result.sample(turns), result.sample(turns + 1e-4)
fall, retreat = (before[name].values - after[name].values for name in ("force", "indentation_depth"))
glass = rs.reduced_modulus(polymer).instantaneous_modulus
read = fall / retreat / (2.0 * before.contact_radius.values)
print("modulus read from the slope, over the instantaneous one:", (read / glass).round(3))
print(f"largest force {result.max_force:.9e} N")
assert abs(result.max_force / 7.27100766724e-3 - 1.0) < 1e-8
