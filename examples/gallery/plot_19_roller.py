r"""
Steel rods on a rubber-coated roller
====================================

A steel rod falls on a roller with a thick rubber coat. Where the two cross, the contact is an ellipse, which is longer
the smaller the angle is. Hertz's ellipse keeps its shape while it grows and shrinks, so the impact is exactly that of
a ball with an effective radius.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs

rubber = rs.standard_solid(1e6, 2e6, 2e3, poisson_ratio=0.5, density=1100.0)
rod, roller, mass, velocity = 0.01, 0.05, 0.05, 0.2

angles = np.radians([5.0, 10.0, 20.0, 30.0, 45.0, 60.0, 75.0, 90.0])
gaps = [rs.crossed_cylinders(rod, roller, angle=angle) for angle in angles]
results = [rs.solve(rs.Impact(rubber, gap, mass, velocity)) for gap in gaps]

fig, (top, bottom) = plt.subplots(2, 1, figsize=(6.4, 5.0), height_ratios=(1, 3), layout="constrained")
turn = np.linspace(0.0, 2.0 * math.pi, 181)
for n, line in ((2, "-"), (3, "--"), (4, "-."), (7, ":")):
    a, b = 1e3 * gaps[n].semi_axes(results[n].max_contact_radius)
    top.plot(a * np.cos(turn), b * np.sin(turn), line, label=f"{math.degrees(angles[n]):.0f}°")
top.set_aspect("equal")
top.set(xlabel="largest contact [mm]", ylabel="[mm]")
top.legend(title="angle", fontsize="small", ncols=2, loc="center left", bbox_to_anchor=(1.02, 0.5))
degrees = np.degrees(angles)
bottom.plot(degrees, [result.restitution_coefficient for result in results], "o-", label="$e$")
bottom.plot(degrees, [100.0 * result.contact_time for result in results], "s-", label="contact time [10 ms]")
bottom.set_xlabel("angle between rod and roller [°]")
bottom.set_ylabel("$e$, contact time [10 ms]")
bottom.set_ylim(bottom=0.0)
bottom.legend()

# %%
# The effective radius of the rod at a right angle is that of Hertz: with curvatures of 1/10 mm and 1/50 mm, the ratio
# of the semi-axes is 0.3460 and the effective radius 1.109986 times the geometric mean of both radii. A parabola of
# this radius gives the same impact.

square, last = gaps[-1], results[-1]
print(f"ratio of the semi-axes {square.axis_ratio:.6f}, effective radius {1e3 * square.effective_radius:.4f} mm")
assert abs(square.axis_ratio - 0.345999086637) < 1e-11
assert abs(square.effective_radius / math.sqrt(rod * roller) - 1.10998599938) < 1e-10
ball = rs.solve(rs.Impact(rubber, rs.Parabola(square.effective_radius), mass, velocity))
print(f"e = {last.restitution_coefficient:.9f}, of the parabola {ball.restitution_coefficient:.9f}")
assert abs(last.restitution_coefficient - ball.restitution_coefficient) < 1e-9
