"""
Dust grains that stick
======================

Grains of silica and of water ice meet in space. Elastic grains lose energy when their surfaces jump into contact and
out of it. The limit of Johnson, Kendall and Roberts (JKR), which codes of dust use for both, is that of large and
soft grains: ice of a micron is near it, and silica of a micron loses next to nothing.
"""

import math
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs

# %%
# Surface energies, Young's moduli and Poisson ratios are those that simulations of aggregates have in common: silica
# 25 mJ/m2, 54 GPa and 0.17, ice 100 mJ/m2, 7 GPa and 0.25 (C. Dominik and A. G. G. M. Tielens, Astrophys. J. 480
# (1997) 647; K. Wada et al., Astrophys. J. 661 (2007) 320), quoted from memory. The work of adhesion of two equal
# surfaces is twice the surface energy. The range of the attraction, 0.4 nm, is an assumption: a distance of atoms.
GRAINS = {
    "silica": {"surface_energy": 0.025, "youngs_modulus": 54e9, "poisson_ratio": 0.17, "density": 2600.0},
    "water ice": {"surface_energy": 0.100, "youngs_modulus": 7e9, "poisson_ratio": 0.25, "density": 1000.0},
}


def collision(radius, surface_energy, youngs_modulus, poisson_ratio, density, branch=0.0, time=1.0):
    """Two equal grains at 1 m/s, whose modulus may relax by a share."""
    shear = youngs_modulus / (2.0 * (1.0 + poisson_ratio))
    series = rs.PronySeries(shear, [branch * shear], [time]) if branch else rs.PronySeries(shear, [], [])
    bulk = youngs_modulus / (3.0 * (1.0 - 2.0 * poisson_ratio))
    grain = rs.Body(rs.Material(series, bulk=bulk, density=density), radius=radius)
    return replace(rs.collision(grain, grain, 1.0), adhesion=rs.Adhesion(work=2.0 * surface_energy))


def jkr_velocity(impact):
    """Sticking velocity of elastic grains in the limit of JKR, from the loss 7.0922 (w^5 R^4/E*^2)^(1/3)."""
    modulus, radius = impact.reduced_modulus.equilibrium_modulus, impact.profile.radius
    loss = 7.0921960 * (impact.adhesion.work**5 * radius**4 / modulus**2) ** (1.0 / 3.0)
    return math.sqrt(2.0 * loss / impact.mass)


def hard_velocity(impact):
    """Sticking velocity of elastic grains of small lambda, which jump without touch alone.

    At the depth -h0 the attraction jumps to the radius c, and it ends from c/2 on the way out; the integrals of
    docs/theory/adhesion.md give 1/12 and 1/192 of pi sigma0 c^4/R.
    """
    modulus, radius, stress = impact.reduced_modulus.equilibrium_modulus, impact.profile.radius, impact.adhesion.stress
    edge = 8.0 * stress * radius / (math.pi * modulus)
    return math.sqrt(2.0 * math.pi * stress * edge**4 / radius * (1.0 / 12.0 + 1.0 / 192.0) / impact.mass)


# %%
# An elastic grain loses the same energy at every velocity, so that one impact has the velocity below which it sticks.
radii = np.geomspace(0.05e-6, 2e-6, 7)
figure, ax = plt.subplots(figsize=(4.6, 3.4), layout="constrained")
for (name, numbers), color in zip(GRAINS.items(), ("C0", "C1"), strict=True):
    several = [collision(radius, **numbers) for radius in radii]
    several = [replace(impact, velocity=3.0 * jkr_velocity(impact)) for impact in several]
    results = [rs.solve(impact, rtol=1e-4) for impact in several]
    losses = np.array([result.radiated_energy for result in results])
    masses = np.array([impact.mass for impact in several])
    lams = [result.maugis_numbers[0] for result in results]
    sticks = np.sqrt(2.0 * losses / masses)
    print(f"{name}: lambda from {lams[0]:.2f} to {lams[-1]:.2f}, sticks below {sticks[0]:.3g} to {sticks[-1]:.3g} m/s")
    if name == "silica":
        print(f"closed form of hard grains: {hard_velocity(several[0]):.4g} m/s")
        assert abs(sticks[0] / hard_velocity(several[0]) - 1.0) < 0.01
    ax.plot(1e6 * radii, sticks, "o-", color=color, markersize=3, label=name)
    ax.plot(1e6 * radii, [jkr_velocity(impact) for impact in several], "--", color=color, label=f"{name}, JKR")
ax.set(xscale="log", yscale="log", xlabel="radius [µm]", ylabel="sticking velocity of elastic grains [m/s]")
ax.legend(fontsize=7.5)

# %%
# Between silica grains the surfaces hardly jump, as lambda is below 1, and elastic ones would stick at some mm/s only.
# That such grains stick at up to a metre per second in the laboratory (T. Poppe, J. Blum and T. Henning, Astrophys.
# J. 533 (2000) 454, from memory) takes a loss in the solid or in its surface. The branch of the ice below, a tenth of
# its modulus with a relaxation time of 0.3 ns, is an illustration, not a measurement.
elastic = collision(0.5e-6, **GRAINS["water ice"])
lossy = collision(0.5e-6, **GRAINS["water ice"], branch=0.1, time=0.3e-9)
speeds = np.geomspace(1.0, 10.0, 25)
figure, ax = plt.subplots(figsize=(4.6, 3.4), layout="constrained")
for impact, label in ((elastic, "elastic ice"), (lossy, "ice with a loss")):
    result = rs.solve(replace(impact, velocity=speeds), rtol=1e-3)
    e = np.asarray(result.restitution_coefficient)
    rebounds = e > 0.0
    ax.plot(speeds[rebounds], e[rebounds], ".-", label=label)
limit = jkr_velocity(elastic)
above = np.geomspace(limit, 10.0, 200)
ax.plot(above, np.sqrt(1.0 - (limit / above) ** 2), "k--", linewidth=0.8, label="elastic, JKR")
ax.set(xlabel="velocity [m/s]", ylabel="restitution coefficient", ylim=(0.0, 1.02))
ax.legend(fontsize=7.5)

# %%
# The loss in jumps tends to that of JKR as lambda grows.
share = (sticks[-1] / jkr_velocity(several[-1])) ** 2
print(f"largest ice: {share:.3f} of the loss of JKR")
print(rs.solve(lossy, rtol=1e-4).validity["attraction"].message)
assert 0.8 < share < 1.0
