r"""
Influence of the Poisson ratio
==============================

A nearly incompressible material is often assumed to be incompressible. The picture shows the relative error of this
assumption over the static Poisson ratio, for a sphere on the standard solid. For
:math:`\tfrac12 - \nu > 7.5\cdot10^{-4}` the instantaneous Poisson ratio of this solid is negative, as of no known
polymer.
"""

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs

nu = 0.5 - np.geomspace(1e-6, 1.5, 121)
fig, ax = plt.subplots(layout="constrained")
for p3 in (0.1, 1.0, 10.0):
    e = rs.standard_solid_restitution(nu, 1e-3, p3)
    assumed = rs.standard_solid_restitution(0.5, 1e-3, p3)
    ax.loglog(0.5 - nu, np.abs(assumed / e - 1.0), label=f"$p_3 = {p3:g}$")
ax.invert_xaxis()
ax.set_xlabel(r"$\frac{1}{2} - \nu$ (incompressible to the right)")
ax.set_ylabel(r"relative error of $e$ from assuming $\nu = \frac{1}{2}$")
ax.set_title(r"$\log_{10} p_2 = -3$")
ax.legend()

# %%
# At the other end of the axis, :math:`\nu = -1`, the material has no bulk stiffness. Its reduced modulus equals that
# of an incompressible material with a quarter of the shear modulus. Hence :math:`e(-1, p_2, p_3) = e(\tfrac12, p_2,
# 4^{-2/5} p_3)`, exactly. For :math:`p_2 = 1`, :math:`p_3 = 0.3` an independent integration gives 0.705453556065
# (``tests/data/standard_solid.csv``).

left = rs.standard_solid_restitution(-1.0, 1.0, 0.3)
right = rs.standard_solid_restitution(0.5, 1.0, 0.3 * 4.0**-0.4)
print(f"e = {left:.12f} = {right:.12f}")
assert abs(left - right) < 1e-9
assert abs(left - 0.705453556065) < 1e-9
