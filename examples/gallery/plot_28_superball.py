"""
A superball goes to and fro
===========================

A ball of hard rubber falls on a rough floor, thrown forward with backspin. Each bounce is an oblique impact: it turns
the contact point back, and with it the ball. The loss in its material and the slip at the rim decide how much. A ball
that keeps its kinetic energy would go on for ever.
"""

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs
from restitution.plot.impact import path, spins

rubber = rs.standard_solid(2e6, 4e5, 40.0, poisson_ratio=0.5, density=930.0)
fall = rs.drop(rs.Body(rubber, radius=0.0225), rs.Body(None), height=0.3)
thrown = rs.vary(fall, {"friction": 1.2, "tangential_velocity": 2.7, "spin": 300.0})
series = rs.bounces(thrown, max_bounces=5)

fig, axes = plt.subplots(2, 1, figsize=(7.0, 4.6), layout="constrained", height_ratios=(2, 1))
path(axes[0], series)
spins(axes[1], series)

# %%
# The force of the floor has no moment about the touched point. So the sum of the moment of the momentum and of the
# spin there, ``m R v_x - I w`` with ``I = (2/5) m R^2`` of a solid ball, is that of the release after every bounce.
# Here it is zero: velocity and spin change their sign together.

kept = series.rebound_tangential_velocity - 0.4 * 0.0225 * series.rebound_spin
print(f"v_x - (2/5) R w = {kept[-1]:.1e} m/s after {series.n_bounces} bounces")
assert np.abs(kept).max() < 1e-12
assert np.array_equal(np.sign(series.rebound_tangential_velocity), [-1.0, 1.0, -1.0, 1.0, -1.0])
