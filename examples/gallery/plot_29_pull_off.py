"""
Pull-off over the rate
======================

A tip comes to a soft gel and is pulled off at the same speed. Slow and fast pulls are elastic. In between the contact
closes on a relaxed body and opens against the glass at its edge, and the pull is largest.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs
from restitution.contact.adhesion import static_contact

# %%
# E*(t) = 1 MPa + 4 MPa exp(-t/0.1 s); a work of adhesion of 10 mJ/m2 and a range of 20 nm, as of soft chains.
gel = rs.Material(rs.PronySeries(0.25e6, [1e6], [0.1]), bulk=math.inf)
tip, sticky = rs.Parabola(5e-6), rs.Adhesion(work=0.01, range=20e-9)
unit = math.pi * 0.01 * 5e-6
deepest, far = 2e-7, -2e-6


def pull(speed):
    """Return the tip that comes to the depth and goes at a speed [m/s]."""
    depth = np.array([-3e-8, deepest, far])
    time = np.append(0.0, np.cumsum(abs(np.diff(depth)))) / speed
    return rs.indent(gel, tip, depth=depth, time=time, adhesion=sticky, rtol=1e-3)


speeds = np.geomspace(1e-8, 1e-3, 16)
results = [pull(speed) for speed in speeds]
pulls = np.array([result.pull_off_force for result in results]) / unit

# %%
# The limits are the largest pulls of elastic bodies at rest (Maugis 1992).
radii = np.geomspace(1e-7, 3e-6, 400)
slow, fast = (max(-static_contact(tip, modulus, sticky, a).force for a in radii) / unit for modulus in (1e6, 5e6))

figure, (left, right) = plt.subplots(1, 2, figsize=(7.2, 3.0), layout="constrained")
for n in (5, 9, 15):
    left.plot(1e9 * results[n].indentation_depth, 1e9 * results[n].force, label=f"{1e6 * speeds[n]:.3g} µm/s")
left.set(xlabel="depth [nm]", ylabel="force [nN]", xlim=(-300.0, 220.0))
left.legend()
right.plot(1e6 * speeds, pulls, ".-")
for limit in (slow, fast):
    right.axhline(limit, color="0.5", linestyle=":")
right.set(xscale="log", xlabel="speed [µm/s]", ylabel="largest pull over pi w R")

print(f"slow {slow:.3f}, largest {pulls.max():.3f}, fast {fast:.3f}")
assert abs(pulls[-1] / fast - 1.0) < 0.03
assert pulls.max() > 1.5 * max(slow, fast)
