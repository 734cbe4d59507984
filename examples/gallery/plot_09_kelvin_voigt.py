r"""
Kelvin-Voigt against a popular force law
========================================

Many particle codes use :math:`F = \rho\,(d^{3/2} + \tfrac32 A\sqrt d\,\dot d)` throughout the contact (Kuwabara and
Kono; Brilliantov and others). This law is exact for a Kelvin-Voigt half-space while the contact grows. The exact
law of the shrinking contact is different, and the two agree only for small losses.
"""

import math
import warnings

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs
from restitution.impact.closed_forms import mueller_poeschel_restitution


def sphere(p3):
    """Impact on an incompressible half-space of G = 1 and viscosity p3, in units m = R = v0 = 1."""
    solid = rs.kelvin_voigt(1.0, p3, bulk_modulus=math.inf)
    return rs.Impact(solid, rs.Parabola(radius=1.0), mass=1.0, velocity=1.0)


# Without units there is no size or mass whose strain or density could be judged.
warnings.simplefilter("ignore", rs.RestitutionWarning)

p3 = np.geomspace(1e-3, 3.0, 41)
exact = rs.solve([sphere(value) for value in p3]).restitution_coefficient
# The Pade approximant of Mueller and Poeschel (2011) for this law, with rho = (16/3) G sqrt(R), A = eta/G.
law = mueller_poeschel_restitution(np.sqrt(1.5 * (16.0 / 3.0) ** 0.4 * p3))

fig, (upper, lower) = plt.subplots(2, 1, figsize=(6.4, 5.6), sharex=True, layout="constrained")
upper.semilogx(p3, exact, label="Kelvin-Voigt half-space, exact")
upper.semilogx(p3, law, "--", label="one force law throughout")
upper.set_ylabel("restitution coefficient $e$")
upper.legend()
lower.loglog(p3, np.abs(1.0 - law / exact))
lower.set_xlabel("dimensionless viscosity $p_3$")
lower.set_ylabel("relative difference of $e$")

# %%
# The difference is of second order in the loss: a tenth of the viscosity reduces it to a hundredth.
#
# Two programs that are independent of this package give e = 0.7362166 at :math:`p_3 = 0.1`.

e = rs.solve(sphere(0.1)).restitution_coefficient
print(f"e = {e:.7f}, force law {mueller_poeschel_restitution(math.sqrt(0.15 * (16.0 / 3.0) ** 0.4)):.7f}")
assert abs(e - 0.7362166) < 1e-7
small = np.abs(1.0 - law / exact)[p3 < 0.03]
assert abs(np.polyfit(np.log(p3[p3 < 0.03]), np.log(small), 1)[0] - 2.0) < 0.1
