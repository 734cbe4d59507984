"""
Five bounces and a DMA curve
============================

A bounce with a contact time T is one point of a table of dynamic moduli, at a frequency of about 1/(2 T). Five balls
of different size measure the moduli of a rubber over more than a decade, at frequencies beyond the range of most
rheometers.
"""

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs

# %%
# The rubber has a broad relaxation spectrum, so the loss tangent changes slowly with frequency. The steel balls fall
# from 1 cm.

times = np.geomspace(1e-7, 1e1, 17)
shear = rs.PronySeries(1e7, 4e6 * (times / 1e-3) ** -0.08, times)
rubber = rs.Material(shear, bulk=np.inf)
radius = np.array([0.5e-3, 1e-3, 2e-3, 5e-3, 10e-3])
mass = 7800.0 * 4.0 / 3.0 * np.pi * radius**3
velocity = np.sqrt(2.0 * 9.81 * 0.01)
exact = rs.solve(rs.Impact(rubber, rs.Parabola(radius), mass, velocity))

# %%
# Restitution coefficients and contact times have a noise of 1 %:

rng = np.random.default_rng(7)
e, contact_time = (
    values * (1.0 + 0.01 * rng.standard_normal(radius.size))
    for values in (exact.restitution_coefficient, exact.contact_time)
)
noise = rs.Noise(restitution_coefficient="1 %", contact_time="1 %")
balls = rs.Rebounds(velocity, e, radius=radius, mass=mass, contact_time=contact_time, noise=noise)
moduli = rs.effective_moduli(balls)
print(moduli)

# %%
# The curves are the moduli of the rubber, and the bars show the noise. ``moduli.plot(rubber)`` draws a similar
# picture.

reduced = rs.reduced_modulus(rubber)
curve = np.geomspace(0.3 * moduli.angular_frequency.min(), 3.0 * moduli.angular_frequency.max(), 100)
storage_curve, loss_curve = reduced.storage_modulus(curve), reduced.loss_modulus(curve)

fig, (left, right) = plt.subplots(1, 2, figsize=(7.2, 3.2), layout="constrained")
for name, values, color in (("storage", storage_curve, "C0"), ("loss", loss_curve, "C1")):
    left.plot(curve, values / 1e6, color=color, label=name)
    points, errors = getattr(moduli, f"{name}_modulus"), getattr(moduli, f"{name}_modulus_error")
    left.errorbar(moduli.angular_frequency, points / 1e6, errors / 1e6, fmt="o", markersize=4, color=color)
right.plot(curve, loss_curve / storage_curve, color="C2")
right.errorbar(
    moduli.angular_frequency, moduli.loss_tangent, moduli.loss_tangent_error, fmt="o", markersize=4, color="C2"
)
left.set(xscale="log", yscale="log", xlabel=r"angular frequency $\omega$ [rad/s]", ylabel="reduced modulus [MPa]")
left.set_ylim(10.0, 1000.0)
right.set(
    xscale="log", xlabel=r"angular frequency $\omega$ [rad/s]", ylabel=r"loss tangent $\tan\delta$", ylim=(0.0, None)
)
left.legend()

# %%
# Each point lies within three standard errors and the error of the formulas, which is 2.5 % for the loss tangent of a
# broad spectrum and 0.5 % for its storage modulus.

omega = moduli.angular_frequency
storage, loss = reduced.storage_modulus(omega), reduced.loss_modulus(omega)
assert np.all(np.abs(moduli.storage_modulus - storage) < 3.0 * moduli.storage_modulus_error + 0.005 * storage)
tangent = loss / storage
assert np.all(np.abs(moduli.loss_tangent - tangent) < 3.0 * moduli.loss_tangent_error + 0.025 * tangent)
