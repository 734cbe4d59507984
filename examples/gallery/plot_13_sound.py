"""
The material of a ball from its sound
=====================================

A microphone records the instants at which a ball of rubber touches the floor. Each interval between two touches is a
contact and a flight. The times determine the loss of the rubber. In this example they also determine its stiffness,
because the contacts of a soft ball last for milliseconds.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs

rubber = rs.standard_solid(1e6, 1e7, 300.0, poisson_ratio=0.5, density=1100.0)
radius = 0.02
ball = rs.Body(rubber, radius=radius)
impact = rs.drop(ball, rs.Body(None), height=0.1)
heard = rs.bounces(impact, max_bounces=11)

# %%
# The instants have a noise of 20 µs. The simulated ball falls without air; for a real ball, give ``air_density=1.2``.

random = np.random.default_rng(1)
time = heard.touch_time + 2e-5 * random.standard_normal(heard.n_bounces)
sound = rs.BounceTimes(time, radius=radius, mass=ball.mass, drag_coefficient=0.0, noise=rs.Noise(time=2e-5))
fit = rs.identify(sound, rs.standard_solid, fixed={"poisson_ratio": 0.5})
print(fit)

# %%
# The ratio of successive intervals is often used as e. It is too large if the contacts are not short against the
# flights. The ratio without the contact times is too small, because the ball leaves while it is still compressed. The
# fit contains both effects. Outside the window of the contact times no data support the moduli.

intervals = np.diff(time)
flights = intervals - heard.contact_time[:-1]
velocity, e = heard.velocity[1:-1], heard.restitution_coefficient[1:-1]
weight = 9.80665 * ball.mass
prediction = fit.predict(rs.Impact(rubber, impact.profile, ball.mass, velocity[:-1], external_force=weight))

fig, (left, right) = plt.subplots(1, 2, figsize=(8.0, 3.6), layout="constrained")
left.plot(velocity, intervals[1:] / intervals[:-1], "s", markersize=4, label="ratio of intervals")
left.plot(velocity, flights[1:] / flights[:-1], "^", markersize=4, label="less the contact times")
left.plot(velocity[:-1], prediction["restitution_coefficient"], "-", label="fit")
left.plot(velocity, e, "k.", label="true")
left.set_xscale("log")
left.set_xlabel("impact velocity $v_0$ [m/s]")
left.set_ylabel("restitution coefficient $e$")
left.legend()


def reduced_modulus(omega):
    """Storage and loss part of E* of the incompressible rubber."""
    shear = 1e6 + 1e7 * 1j * omega * 3e-5 / (1.0 + 1j * omega * 3e-5)
    return 4.0 * shear


middle = math.pi / heard.contact_time[3]
omega = np.geomspace(0.3, 3.0, 60) * middle
bands = fit.moduli(omega)
for name, true in (("storage_modulus", reduced_modulus(omega).real), ("loss_modulus", reduced_modulus(omega).imag)):
    (line,) = right.loglog(omega, bands[name] / 1e6, label=f"{name.replace('_', ' ')}, fit")
    low, high = bands[f"{name}_low"] / 1e6, bands[f"{name}_high"] / 1e6
    right.fill_between(omega, low, high, color=line.get_color(), alpha=0.2)
    right.loglog(omega, true / 1e6, "k:", label="true" if name == "loss_modulus" else None)
right.axvspan(*fit.window, color="0.9", zorder=0)
right.set(xticks=[200, 500, 1000, 2000], yticks=[0.3, 1.0, 3.0])
for axis in (right.xaxis, right.yaxis):
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter("")
right.set_xlabel(r"angular frequency $\omega$ [rad/s]")
right.set_ylabel(r"reduced modulus $E^*$ [MPa]")
right.legend()

# %%
# The loss tangent at :math:`\pi` over the contact time is within three standard errors of that of the rubber.

there, true = fit.moduli([middle]), reduced_modulus(middle)
tangent, high = float(there["loss_tangent"][0]), float(there["loss_tangent_high"][0])
print(f"tan delta = {tangent:.4f}, true {true.imag / true.real:.4f}")
assert abs(math.log(tangent * true.real / true.imag)) < 3.0 / 1.96 * math.log(high / tangent)
assert high < 1.2 * tangent
