"""
A dropped ball that bounces to rest
===================================

A ball of hard rubber falls on a rigid floor. Its weight also acts during contact. The last rebounds are too weak to
lift the ball, and it stays on the floor. The command is ``restitution bounce examples/dropped_ball.toml --plot
bounces.png``.
"""

import matplotlib.pyplot as plt

import restitution as rs
from restitution.plot.impact import bounce_heights, height_time, restitution_velocity

rubber = rs.standard_solid(25e6, 25e6, 2.5e3, poisson_ratio=0.48, density=1100.0)
impact = rs.drop(rs.Body(rubber, radius=0.02), rs.Body(None), height=0.1, gravity=9.81)
bounces = rs.bounces(impact, gravity=9.81, min_height=1e-8)
print(f"{bounces.n_bounces} bounces in {bounces.touch_time[-1]:.3f} s: {bounces.ended.message}")

fig = plt.figure(figsize=(7.0, 5.0), layout="constrained")
grid = fig.add_gridspec(2, 2)
height_time(fig.add_subplot(grid[0, :]), bounces)
restitution_velocity(fig.add_subplot(grid[1, 0]), bounces)
bounce_heights(fig.add_subplot(grid[1, 1]), bounces)

# %%
# At high velocities the loss decreases as the ball becomes slower, because the material relaxes within the contact. At
# the lowest velocities the weight dominates.
#
# An integration of the first contact by SciPy, with the weight, gives e = 0.7218493706
# (``validation/gallery_numbers.py``).

print(f"e of the first bounce = {bounces.restitution_coefficient[0]:.10f}")
assert abs(bounces.restitution_coefficient[0] - 0.7218493706) < 1e-9
assert bounces.ended == "captured"
