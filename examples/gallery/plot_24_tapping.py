"""
Tapping over a standard solid
=============================

A cantilever taps on a polymer while its rest position approaches the surface. Amplitude, phase, force and loss follow
from the exact contact, with all that the surface keeps from the taps before. All numbers are dimensionless:
E*(t) = 1 + 4 exp(-t), and the radius of the tip, the mass of the cantilever and its spring constant are 1.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs

material = rs.Material(rs.PronySeries(0.25, [1.0], [1.0]), bulk=math.inf)
distance = np.linspace(1.0, 0.5, 26)
tapping = {"spring_constant": 1.0, "quality_factor": 10.0, "frequency": 0.5 / math.pi, "free_amplitude": 1.0}
curve = rs.tap(material, rs.Parabola(radius=1.0), distance, **tapping)

fig, axes = plt.subplots(1, 3, figsize=(9.0, 3.0), layout="constrained")
axes[0].plot(curve.distance, curve.amplitude)
axes[0].plot(curve.distance, curve.distance, ":", label="A = D")
axes[0].set(xlabel="distance D", ylabel="amplitude A")
axes[0].legend()
axes[1].plot(curve.distance, np.degrees(curve.phase))
axes[1].set(xlabel="distance D", ylabel="phase [deg]")
axes[2].plot(curve.distance, curve.dissipated, label="exact")
# What the drive gives and the air does not take: force 1/Q, damping 1/Q.
axes[2].plot(curve.distance, 0.1 * math.pi * curve.amplitude * (np.sin(-curve.phase) - curve.amplitude), ":",
             label="read off")  # fmt: skip
axes[2].set(xlabel="distance D", ylabel="loss per tap")
axes[2].legend()

# %%
# The amplitude stays above the distance: the tip is in contact for an eighth of the period and dents the surface. The
# loss that experimenters read off amplitude and phase takes the motion for a pure sine. It is a little too large here,
# as the air also brakes the higher harmonics.
#
# At D = 0.8 panels of two orders, and plain elements with a small step, give A = 0.925092312856 and a phase of
# -70.32667892693 degrees.

row = rs.tap(material, rs.Parabola(radius=1.0), 0.8, **tapping)
print(f"A = {row.amplitude[0]:.9f}, phase = {math.degrees(row.phase[0]):.6f} deg")
assert abs(row.amplitude[0] - 0.925092312856) < 1e-8
assert abs(math.degrees(row.phase[0]) + 70.32667892693) < 1e-5
