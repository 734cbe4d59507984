"""
Polyisobutylene against temperature
===================================

The same rubber behaves as a spring, a damper or a glass, depending on the temperature. The time-temperature shift of
polyisobutylene (Williams, Landel and Ferry) moves its relaxation times across the contact time.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs

rubber = rs.library.get("polyisobutylene")
ball = rs.Parabola(radius=0.005)
mass = 7800.0 * 4.0 / 3.0 * math.pi * 0.005**3
celsius = np.linspace(-70.0, 90.0, 65)
impacts = [rs.Impact(rubber.at(273.15 + degree), ball, mass, velocity=1.0) for degree in celsius]
result = rs.solve(impacts)

fig, (upper, lower) = plt.subplots(2, 1, figsize=(6.4, 5.6), sharex=True, layout="constrained")
upper.plot(celsius, result.restitution_coefficient)
upper.set_ylabel("restitution coefficient $e$")
upper.set_ylim(0.0, 1.0)
omega = math.pi / result.contact_time
tangent = [impact.material.shear.loss_tangent(w) for impact, w in zip(impacts, omega, strict=True)]
lower.plot(celsius, tangent, color="C1")
lower.set_ylabel(r"loss tangent at $\omega = \pi/T$")
lower.set_xlabel("temperature [°C]")

# %%
# The rebound is weakest where the loss tangent, taken at the time scale of the contact, is largest.

cold, warm = (
    rs.solve(rs.Impact(rubber.at(273.15 + degree), ball, mass, velocity=1.0)).restitution_coefficient
    for degree in (-20.0, 20.0)
)
print(f"e = {cold:.10f} at -20 °C, {warm:.10f} at 20 °C")

# %%
# An integration by SciPy gives 0.2478864750 and 0.2775651733. It converts the shifted terms from tension to shear and
# to the reduced modulus by partial fractions (``validation/gallery_numbers.py``).

assert abs(cold - 0.2478864750) < 1e-9
assert abs(warm - 0.2775651733) < 1e-9
