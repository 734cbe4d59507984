"""
A thrown ball: friction, spin and memory
========================================

A ball of rubber is thrown on a rigid plate without spin. At small angles the contact sticks, and the ball leaves with
spin; at large angles all of it slides. The command for one impact is ``restitution solve examples/thrown_ball.toml
--plot thrown.png``.
"""

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs
from restitution.plot.oblique import forces

rubber = rs.standard_solid(2e6, 20e6, 1e3, poisson_ratio=0.5, density=1100.0)
impact = rs.collision(rs.Body(rubber, radius=0.015), rs.Body(None), velocity=1.0)
angles = np.radians(np.arange(2.0, 80.0, 2.0))
frictions = (0.1, 0.3, 1.0)
thrown = [rs.solve(rs.vary(impact, {"friction": mu, "angle": angles}), rtol=1e-4) for mu in frictions]

fig, (left, right) = plt.subplots(1, 2, figsize=(7.0, 3.2), layout="constrained")
for mu, result in zip(frictions, thrown, strict=True):
    left.plot(np.degrees(angles), result.tangential_restitution_coefficient, label=f"$\\mu$ = {mu:g}")
    right.plot(np.degrees(angles), result.rebound_spin)
left.set(xlabel="angle of incidence [deg]", ylabel="tangential restitution $e_t$", ylim=(-1.0, 0.5))
right.set(xlabel="angle of incidence [deg]", ylabel="spin after [rad/s]")
left.legend()

# %%
# The spin is negative, as that of a ball that rolls along: friction turns its surface against the motion. While the
# contact sticks e_t hardly depends on friction. In full sliding friction gives the change of momentum alone,
# ``e_t = -1 + (7/2)(1 + e) mu v0/v_x`` for a solid ball, which is independent of the solver for the tangential motion.

last = thrown[0]
e_t, e = last.tangential_restitution_coefficient[-1], last.restitution_coefficient[-1]
expected = -1.0 + 3.5 * (1.0 + e) * 0.1 / np.tan(angles[-1])
print(f"e_t = {e_t:.9f} at {np.degrees(angles[-1]):.0f} degrees, and {expected:.9f} by the momentum")
assert abs(e_t - expected) < 1e-8
assert last.stick_time[-1] == 0.0

# %%
# One of these impacts in detail: where the tangential force reaches the limits of friction all of the contact slides;
# between them a disc in the middle sticks.

result = rs.solve(rs.vary(impact, {"friction": 0.3, "angle": np.radians(40.0)}))
motion = result.history
fig, (left, right) = plt.subplots(1, 2, figsize=(7.0, 3.2), layout="constrained")
forces(left, result)
right.plot(1e3 * motion.time, 1e3 * motion.contact_radius, label="in contact")
right.plot(1e3 * motion.time, 1e3 * motion.stick_radius, label="sticks")
right.set(xlabel="time since first touch [ms]", ylabel="radius [mm]")
right.legend()
