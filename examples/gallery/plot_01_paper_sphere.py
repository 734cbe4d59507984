r"""
The paper's sphere
==================

A rigid sphere hits a half-space of the compressible standard solid. Its coefficient of restitution depends on three
numbers: the static Poisson ratio :math:`\nu`, the ratio of the moduli :math:`p_2 = G_\infty/G_1` and the
dimensionless viscosity :math:`p_3 = \eta\,[v_0 R/(m^2 G_\infty^3)]^{1/5}`.
"""

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs

p3 = np.geomspace(1e-2, 1e2, 81)
ratios = [0.0, 0.3, 0.45, 0.49, 0.499, 0.5]
e = rs.standard_solid_restitution(np.array(ratios)[:, None], 1e-3, p3)

fig, ax = plt.subplots(layout="constrained")
for nu, curve in zip(ratios, e, strict=True):
    ax.semilogx(p3, curve, label=rf"$\nu = {nu:g}$")
ax.set_xlabel("dimensionless viscosity $p_3$")
ax.set_ylabel("restitution coefficient $e$")
ax.set_title(r"$\log_{10} p_2 = -3$")
ax.legend()

# %%
# The Poisson ratio is that of the relaxed material. The instantaneous Poisson ratio is smaller, and negative for all
# curves here up to 0.499. The next lines solve one impact in SI units with the three numbers:

equilibrium, branch, radius, mass, velocity = 1e6, 1e9, 0.01, 0.03, 2.0
viscosity = 10.0 / (velocity * radius / (mass**2 * equilibrium**3)) ** 0.2
rubber = rs.standard_solid(equilibrium, branch, viscosity, poisson_ratio=0.49)
impact = rs.Impact(material=rubber, profile=rs.Parabola(radius), mass=mass, velocity=velocity)
print(rs.dimensionless_groups(impact))
print(f"instantaneous Poisson ratio {rubber.instantaneous_poisson_ratio:.2f}")
result = rs.solve(impact)
print(f"e = {result.restitution_coefficient:.9f}")

# %%
# An implicit Radau integration by another program, with a relative tolerance of 1e-11, gives 0.219706363846
# (``tests/data/standard_solid.csv``).

assert abs(result.restitution_coefficient - 0.219706363846) < 2e-10
