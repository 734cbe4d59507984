"""
The same spot hit four times
============================

A ball hits a slow polymer four times at the same speed, half a unit of time after each separation. On fresh spots the
coefficient of restitution would always be the same. On the same spot each impact begins on the imprint of the earlier
ones. All numbers are dimensionless: E*(t) = 1 + 4 exp(-t), and mass, radius and speed are 1.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs

material = rs.Material(rs.PronySeries(0.25, [1.0], [1.0]), bulk=math.inf)
impact = rs.Impact(material, rs.Parabola(radius=1.0), mass=1.0, velocity=1.0)

results = [rs.solve(impact)]
for _ in range(3):
    results.append(rs.solve(impact, surface=results[-1].surface(after=0.5)))

radius = np.linspace(0.0, 2.0, 201)
fig, (loops, imprints) = plt.subplots(1, 2, figsize=(7.0, 3.0), layout="constrained")
for number, result in enumerate(results, 1):
    history = result.history
    label = f"{number}: e = {result.restitution_coefficient:.3f}"
    loops.plot(history.indentation_depth, history.force, label=label)
    imprints.plot(radius, -result.surface().imprint(radius))
loops.set(xlabel="depth d", ylabel="force F")
loops.legend()
imprints.set(xlabel="distance from the axis r", ylabel="height of the surface at separation")

# %%
# The same spot gets harder. The ball lies in an imprint of its own shape, so its contact grows faster than on a flat
# surface, and the material that has not relaxed has less left to dissipate.
#
# Panels of two orders, and elements followed one by one, give e = 0.628798625, 0.696070261, 0.733833451, 0.758166963.

e = [float(result.restitution_coefficient) for result in results]
print("e =", ", ".join(f"{value:.6f}" for value in e))
assert np.abs(np.array(e) - [0.628798624830, 0.69607026067, 0.73383345137, 0.75816696328]).max() < 1e-8
