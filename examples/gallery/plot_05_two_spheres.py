"""
Two unlike spheres
==================

A sphere of rubber collides with a larger sphere of polyisobutylene. Both deform and dissipate energy. Their
compliances add, each with its own relaxation. An average of two coefficients of restitution gives another result.
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
    "rubber on a rigid sphere": (small, rs.Body(None, radius=0.02, mass=large.mass)),
    "rigid sphere on polyisobutylene": (rs.Body(None, radius=0.01, mass=small.mass), large),
}
fig, ax = plt.subplots(layout="constrained")
for name, (body, other) in pairs.items():
    result = rs.solve(rs.collision(body, other, velocity))
    ax.semilogx(velocity, result.restitution_coefficient, label=name)
ax.set_xlabel("relative velocity [m/s]")
ax.set_ylabel("restitution coefficient $e$")
ax.set_ylim(0.0, 1.0)
ax.legend()

# %%
# The softer sphere deforms more and dissipates more. The contact time, and so the velocity, decides which sphere is
# softer. Above about 0.6 m/s the coefficient of restitution of the pair is larger than that of either sphere with a
# rigid one.

impact = rs.collision(small, large, velocity=1.0)
print(impact.profile, f"reduced mass {impact.mass:.6f} kg, {impact.reduced_modulus.n_branches} terms in E*")
e = rs.solve(impact).restitution_coefficient
print(f"e = {e:.10f}")

# %%
# An integration by SciPy, with its own series connection by partial fractions, gives 0.3248634287
# (``validation/gallery_numbers.py``).

assert abs(e - 0.3248634287) < 1e-9
