r"""
A fractional power law
======================

Gels and tissue relax as :math:`t^{-\alpha}` over many decades. The model is a springpot, between a spring
(:math:`\alpha = 0`) and a dashpot (:math:`\alpha = 1`). It has no relaxation time. The coefficient of restitution of
a flat punch therefore depends only on the exponent, not on mass, velocity or stiffness.
"""

import math

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq
from scipy.special import rgamma

import restitution as rs


def restitution_on(exponent, profile, velocity=1.0):
    """Coefficient of restitution on a springpot of 10 kPa s^alpha."""
    gel = rs.FractionalMaterial(rs.springpot(1e4, exponent), bulk=math.inf, rtol=1e-8)
    # A Prony series approximates the power law in the window of time of the contact.
    impact = rs.for_contact(lambda window: rs.Impact(gel.within(window), profile, 0.02, velocity))
    return rs.solve(impact).restitution_coefficient


# %%
# Under a flat punch the motion is that of a fractional oscillator, :math:`m\ddot d = -K D^\alpha d`, with the
# velocity :math:`v = v_0 E_{2-\alpha,1}(-K t^{2-\alpha})`. The contact ends with the force, at the first zero of
# :math:`E_{2-\alpha,2-\alpha}`. The Mittag-Leffler function :math:`E_{\beta,\gamma}(-z)` is a power series:


def mittag_leffler(beta, gamma, z):
    """E_(beta, gamma)(-z), for z of order one."""
    k = np.arange(120)
    return np.sum((-z) ** k * rgamma(beta * k + gamma))


def closed_form(exponent):
    """Coefficient of restitution of a flat punch on a springpot."""
    beta = 2.0 - exponent
    end = brentq(lambda z: mittag_leffler(beta, beta, z), 0.5, 11.0, xtol=1e-14)
    return -mittag_leffler(beta, 1.0, end)


exponents = np.linspace(0.05, 0.7, 14)
punch = np.array([restitution_on(exponent, rs.FlatPunch(0.01)) for exponent in exponents])
sphere = np.array([restitution_on(exponent, rs.Parabola(0.01)) for exponent in exponents])
curve = np.linspace(0.02, 0.75, 60)

fig, (upper, lower) = plt.subplots(2, 1, figsize=(6.4, 5.6), height_ratios=(2, 1), sharex=True, layout="constrained")
upper.plot(curve, [closed_form(exponent) for exponent in curve], label="flat punch, closed form")
upper.plot(exponents, punch, "o", markersize=4, label="flat punch, computed")
upper.set_ylabel("restitution coefficient $e$")
upper.set_ylim(0.0, 1.0)
upper.legend()
lower.plot(exponents, sphere - punch, "s", markersize=4, color="C2")
lower.set_ylabel(r"$e_\mathrm{sphere} - e_\mathrm{punch}$")
lower.set_xlabel(r"exponent $\alpha$")

# %%
# The shape of the tip has little influence. The loss tangent :math:`\tan(\pi\alpha/2)`, which is the same at all
# times, determines the rebound. The last check compares two velocities at :math:`\alpha = 0.3`:

slow, fast = (restitution_on(0.3, rs.FlatPunch(0.01), velocity) for velocity in (0.01, 1.0))
print(f"e = {slow:.8f} and {fast:.8f}, closed form {closed_form(0.3):.8f}")
assert abs(slow - closed_form(0.3)) < 3e-8
assert abs(fast - closed_form(0.3)) < 3e-8
