"""
Which relaxation times a bounce sees
====================================

A relaxation modulus has many terms, and the rebound depends on few of them. The derivatives of $e$ by all moduli of a
Prony series show which: they are those of one array of impacts. With standard deviations of the inputs they give the
error bar of $e$, and the share of each input in it.
"""

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs

# %%
# An invented rubber with two terms for each decade, and a ball at two velocities. A per cent more of a modulus changes
# $e$ by so many per cent:

times = np.geomspace(1e-8, 1e2, 21)
shear = rs.PronySeries(1e6, 4e6 / (1.0 + (times / 1e-6) ** 0.4), times)
rubber = rs.Material(shear, bulk=2e9)
ball = rs.Impact(rubber, rs.Parabola(radius=0.01), mass=0.005, velocity=np.array([0.01, 1.0]))
names = [f"branch_moduli[{k}]" for k in range(times.size)]
by = rs.derivatives(ball, [*names, "equilibrium_modulus", "bulk_modulus", "velocity"])
print(by)

# All moduli act through the time scale (m^2/(E*^2 R v))^(1/5) of the contact, in which the velocity has half their
# power.
*of_moduli, of_velocity = by.elasticities[0]
assert np.allclose(sum(of_moduli), 2.0 * of_velocity, rtol=1e-6)

fig, ax = plt.subplots(figsize=(6.4, 3.4), layout="constrained")
for place, (velocity, color) in enumerate(zip(ball.velocity, ("C0", "C1"), strict=True)):
    ax.plot(times, by.elasticities[0, : times.size, place], "o-", color=color, markersize=4, label=f"{velocity:g} m/s")
    ax.axvline(by.values["contact_time"][place], color=color, linestyle=":")
ax.axhline(0.0, color="0.6", linewidth=0.8, zorder=0)
ax.set(xscale="log", xlabel="relaxation time of the term [s]", ylabel="change of $e$ over that of the modulus")
ax.legend(title="contact time dotted")

# %%
# Terms that relax within the contact lower $e$. Much slower ones are springs and raise it, much faster ones do not
# matter. A scatter of 5 % in each modulus, of 1 % in the mass, and of 2 % in the radius and in the velocity:

deviations = dict(zip(names, 0.05 * shear.branch_moduli, strict=True))
deviations |= {"mass": 5e-5, "radius": 2e-4, "velocity": 0.02}
result = rs.uncertainty(rs.vary(ball, {"velocity": 1.0}), deviations, draws=500, rng=1)
print(result)
