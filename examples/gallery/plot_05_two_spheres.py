"""
Two unlike spheres
==================

A sphere of rubber and one of polyisobutylene, of different sizes, meet at a relative velocity. Both deform, both lose
energy: their compliances add, each with its own relaxation, and no average of two coefficients of restitution would
say the same.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs

rubber = rs.Material(rs.PronySeries(2e6, [20e6], [50e-6]), bulk=2e9, density=1100.0, name="rubber")
polyisobutylene = replace(rs.library.get("polyisobutylene").at(293.15), density=920.0)
small, large = rs.Body(rubber, radius=0.01), rs.Body(polyisobutylene, radius=0.02)

velocity = np.geomspace(1e-2, 3.0, 41)
pairs = {
    "rubber on polyisobutylene": (small, large),
    "rubber on rigid": (small, rs.Body(None, radius=0.02, mass=large.mass)),
    "rigid on polyisobutylene": (rs.Body(None, radius=0.01, mass=small.mass), large),
}
fig, ax = plt.subplots(layout="constrained")
for name, (one, other) in pairs.items():
    result = rs.solve(rs.collision(one, other, velocity))
    ax.semilogx(velocity, result.restitution_coefficient, label=name)
ax.set_xlabel("relative velocity [m/s]")
ax.set_ylabel("restitution coefficient $e$")
ax.set_ylim(0.0, 1.0)
ax.legend()

# %%
# The softer partner takes more of the deformation, and with it more of the loss. Which one is softer depends on the
# duration of the contact, and so on the velocity. Above some 0.6 m/s the pair rebounds better than either of the two
# on a rigid sphere.

impact = rs.collision(small, large, velocity=1.0)
print(impact.profile, f"reduced mass {impact.mass:.6f} kg, {impact.reduced_modulus.n_branches} terms in E*")
e = rs.solve(impact).restitution_coefficient
print(f"e = {e:.10f}")

# %%
# An integration by SciPy, with a series connection by partial fractions of its own, found 0.3248634287
# (``validation/gallery_numbers.py``).

assert abs(e - 0.3248634287) < 1e-9
