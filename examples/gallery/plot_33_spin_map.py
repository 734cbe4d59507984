"""
Every rebound of a spinning ball
================================

A game, a robot that plays or a simulation of grains needs rebounds by the million. A surrogate solves some
impacts with friction, spin and memory once. Then it has every rebound by a polynomial, with a stated error. Here it
draws the paths of a thrown rubber ball, and a map of forty thousand throws.
"""

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs

rubber = rs.standard_solid(2e6, 4e5, 40.0, poisson_ratio=0.5, density=930.0)
radius, friction = 0.0225, 0.3
ball = rs.vary(rs.collision(rs.Body(rubber, radius=radius), rs.Body(None), velocity=1.0), {"friction": friction})
surrogate = rs.surrogate(ball, velocity=(0.5, 6.0), rtol=1e-3)

speed, most = 5.0, 600.0
angles, spins = np.meshgrid(np.linspace(0.0, 75.0, 200), np.linspace(-most, most, 200))
normal, along = speed * np.cos(np.radians(angles)), speed * np.sin(np.radians(angles))
back = surrogate.rebound(normal, along, spins)
after = np.degrees(np.arctan2(back.tangential_velocity, back.velocity))
sliding = np.abs(along + radius * spins) / (friction * normal) / surrogate.full_sliding(normal)

fig, (top, bottom) = plt.subplots(2, 1, figsize=(7.0, 6.4), layout="constrained", height_ratios=(1.0, 1.7))
colours = bottom.pcolormesh(angles, spins, after, cmap="RdBu_r", vmin=-75.0, vmax=75.0, rasterized=True)
bottom.contour(angles, spins, after, levels=[0.0], colors="k", linewidths=1.2)
bottom.contour(angles, spins, sliding, levels=[1.0], colors="k", linewidths=0.8, linestyles="--")
bottom.set(xlabel="angle of incidence from the normal [deg]", ylabel="spin before [rad/s]")
places = {(2.0, 520.0): "slides, and comes back", (48.0, 520.0): "slides on", (20.0, -130.0): "sticks in part"}
for place, words in places.items():
    bottom.text(*place, words)
fig.colorbar(colours, ax=bottom, label="angle of the rebound [deg]")

down, over, g = speed * np.cos(np.radians(20.0)), speed * np.sin(np.radians(20.0)), 9.81
coming = np.linspace(-0.2, 0.0, 50)
top.plot(over * coming, -down * coming - 0.5 * g * coming**2, color="0.4", lw=2.5)
for spin in np.linspace(-most, most, 13):
    off = surrogate.rebound(down, over, spin)
    t = np.linspace(0.0, 2.0 * off.velocity / g, 100)
    paint = plt.get_cmap("viridis")(0.5 + 0.5 * spin / most)
    top.plot(off.tangential_velocity * t, off.velocity * t - 0.5 * g * t * t, color=paint)
top.axhline(0.0, color="k", lw=0.8)
top.set(
    xlabel="x [m]",
    ylabel="height [m]",
    title=f"thrown at 20 degrees from the normal (grey), with spins up to {most:.0f} rad/s",
)
shades = plt.cm.ScalarMappable(plt.Normalize(-most, most), "viridis")
fig.colorbar(shades, ax=top, label="spin before [rad/s]")

# %%
# Red throws go on, blue ones come back, and on the solid line the ball rises straight up. A spin above zero moves the
# touched point forward, as backspin of a ball that flies to the right does: friction then pulls it back. Between the
# dashed lines some of the contact sticks, and friction counts little; beyond them all of it slides, the change
# of momentum is that of Coulomb, and more spin changes nothing in the direction.
#
# Throws at random, solved in full, agree within the stated error.

rng = np.random.default_rng()
v, u, w = rng.uniform(0.5, 6.0, 20), rng.uniform(-5.0, 5.0, 20), rng.uniform(-600.0, 600.0, 20)
exact = rs.solve(rs.vary(ball, {"velocity": v, "tangential_velocity": u, "spin": w}), rtol=1e-5)
e_t = surrogate.tangential_restitution_coefficient(v, u, w)
stated = surrogate.error["tangential_restitution_coefficient"]
print(f"error of e_t below {stated:.1e}")
assert np.abs(e_t - exact.tangential_restitution_coefficient).max() < stated + 1e-5
