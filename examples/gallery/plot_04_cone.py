r"""
Cone against sphere
===================

This example shows the influence of the shape of the tip. The force on an elastic half-space is :math:`F \sim d^n`
with :math:`n = 3/2` for the sphere and 2 for the cone. For small losses, only this exponent matters.
"""

import math

import matplotlib.pyplot as plt
import numpy as np
from scipy.special import beta

import restitution as rs

modulus, mass, velocity = 1e6, 0.01, 1.0
tips = {"sphere": (rs.Parabola(0.02), 1.5), "cone": (rs.Cone(half_angle=math.radians(75.0)), 2.0)}

# %%
# The comparison uses a Maxwell material at equal ratios of the elastic contact time to the relaxation time.

ratios = np.geomspace(1e-3, 10.0, 41)
fig, ax = plt.subplots(layout="constrained")
loss = {}
for name, (tip, n) in tips.items():
    glass = rs.solve(rs.Impact(rs.elastic(shear_modulus=modulus, poisson_ratio=0.5), tip, mass, velocity))
    # Elastic contact time: T v0/d_m = 2/(n + 1) B(1/(n + 1), 1/2).
    duration = 2.0 / (n + 1.0) * beta(1.0 / (n + 1.0), 0.5) * glass.max_indentation_depth / velocity
    assert abs(glass.contact_time / duration - 1.0) < 1e-8
    materials = [rs.maxwell(modulus, modulus * duration / ratio, bulk_modulus=math.inf) for ratio in ratios]
    e = rs.solve([rs.Impact(material, tip, mass, velocity) for material in materials]).restitution_coefficient
    loss[name] = (1.0 - e[0]) / ratios[0]
    ax.semilogx(ratios, e, label=name)
ax.set_xlabel(r"elastic contact time over relaxation time $T/\tau$")
ax.set_ylabel("restitution coefficient $e$")
ax.legend()

# %%
# For small losses, :math:`1 - e = \frac{2}{n + 3}\,T/\tau`: 4/9 for the sphere (Hunter 1960), 2/5 for the cone.

print({name: round(value, 6) for name, value in loss.items()})
assert abs(loss["sphere"] - 4.0 / 9.0) < 1e-3
assert abs(loss["cone"] - 2.0 / 5.0) < 1e-3
