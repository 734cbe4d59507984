"""
Viscous balls that stick, and the loss at the edge
==================================================

A common model of sticky viscous balls adds a viscous force to the elastic contact of Johnson, Kendall and Roberts
(JKR). It has the loss in the bulk and in the jumps. A contact that opens against its own relaxation also loses energy
in the attracted ring at its edge, the more the narrower the ring is.
"""

import math
import warnings
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import restitution as rs
from restitution.contact.adhesion import maugis_number

# %%
# A unit ball of unit mass on E* = 1, with a work of adhesion of 0.01. The viscosity eta is the integral of the modulus
# above its equilibrium value.
WORK, ETA = 0.01, 0.01

# Without units there is no size or mass whose strain or density could be judged.
warnings.simplefilter("ignore", rs.RestitutionWarning)


def viscous_jkr(velocity, viscosity):
    """Restitution of the quasi-static model: JKR's force, and that of a viscous punch of its radius, 2 a eta v.

    N. V. Brilliantov, N. Albers, F. Spahn and T. Poeschel (Phys. Rev. E 76 (2007) 051302) have a model of this kind.
    Its viscous force is derived here from the load of an element that follows the body, q = E* W + eta dW/dt, and was
    not compared with theirs.
    """
    fold = (math.pi * WORK / 8.0) ** (1.0 / 3.0)

    def depth(a):
        return a * a - math.sqrt(2.0 * math.pi * WORK * a)

    def motion(_, state):
        a = brentq(lambda a: depth(a) - max(state[0], depth(fold)), fold, 3.0, xtol=1e-13)
        force = 4.0 / 3.0 * a**3 - math.sqrt(8.0 * math.pi * WORK * a**3) + 2.0 * a * viscosity * state[1]
        return [state[1], -force]

    def leaves(_, state):
        return state[0] - depth(fold) * (1.0 - 1e-12)

    def returns(_, state):
        return state[1]

    leaves.terminal = returns.terminal = True
    leaves.direction, returns.direction = -1.0, 1.0
    way = solve_ivp(motion, (0.0, 100.0), [0.0, velocity], rtol=1e-9, atol=1e-12, events=[leaves, returns])
    return -way.y[1, -1] / velocity if way.t_events[0].size else 0.0


# %%
# Without viscosity the model is the closed form of JKR.
loss = 7.0921960 * WORK ** (5.0 / 3.0)
assert abs(viscous_jkr(0.2, 0.0) - math.sqrt(1.0 - 2.0 * loss / 0.2**2)) < 1e-4

# %%
# The standard solid E* = 1 + exp(-t/0.01) has this viscosity; its contacts last hundreds of relaxation times. The
# larger Maugis' lambda, the narrower is the ring: the more of the modulus has not relaxed when it has passed.
solid = rs.Material(rs.PronySeries(0.25, [0.25], [ETA]), bulk=math.inf)
plain = rs.Impact(solid, rs.Parabola(1.0), 1.0, 1.0)
speeds = np.geomspace(0.1, 2.0, 20)
unit = maugis_number(WORK, 1.0, 1.0, 1.0)
model = np.array([viscous_jkr(speed, ETA) for speed in speeds])

figure, ax = plt.subplots(figsize=(5.4, 3.6), layout="constrained")
ax.plot(speeds, rs.solve(replace(plain, velocity=speeds)).restitution_coefficient, "0.5", label="without adhesion")
ax.plot(speeds, model, "k--", label="viscous JKR")
fans = {}
for lam in (1.0, 2.0, 4.0, 8.0):
    adhesion = rs.Adhesion(WORK, stress=lam / unit)
    result = rs.solve(replace(plain, velocity=speeds, adhesion=adhesion), rtol=1e-3)
    print(f"lambda = {lam:g}: the ring is {result.zone_width[-1]:.2g} wide")
    e = fans[lam] = np.asarray(result.restitution_coefficient)
    ax.plot(speeds, np.where(e > 0.0, e, np.nan), ".-", label=f"lambda = {lam:g}")
ax.set(xscale="log", xlabel="velocity, unit ball and modulus", ylabel="restitution coefficient", ylim=(0.0, 1.02))
ax.legend(fontsize=7.5)

# %%
# With a wide ring both agree where jumps matter little. With a narrow one the edge loses more than the bulk, and the
# ball sticks at higher velocities.
far = speeds > 0.3
print("largest difference of lambda = 1 above 0.3:", abs(fans[1.0] - model)[far].max().round(4))
print("sticks up to:", {lam: float(speeds[e == 0.0].max(initial=0.0).round(3)) for lam, e in fans.items()})
assert abs(fans[1.0] - model)[far].max() < 0.01
assert np.all(fans[8.0][speeds > 0.2] < fans[2.0][speeds > 0.2])
assert np.all(fans[8.0] < model)
