"""
Pull-off over rate and rest
===========================

A tip rests on a soft gel and is pulled off. The pull rises with the speed of the retraction and with the time of rest
before it. A contact that has relaxed and is pulled off at once opens like a flat punch on glass: the surface keeps the
shape of the tip, and answers with its instantaneous modulus.
"""

import math

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

import restitution as rs
from restitution.contact.adhesion import static_contact

# %%
# E*(t) = 1 MPa + 4 MPa exp(-t/0.1 s); a work of adhesion of 10 mJ/m2 and a range of 20 nm, as of soft chains.
gel = rs.Material(rs.PronySeries(0.25e6, [1e6], [0.1]), bulk=math.inf)
tip, sticky = rs.Parabola(5e-6), rs.Adhesion(work=0.01, range=20e-9)
unit = math.pi * 0.01 * 5e-6
start, deepest, far, fast = -3e-8, 2e-7, -2e-6, 1e-3


def pull(approach, rest, retraction):
    """Return the tip that comes at a speed [m/s], rests for a time [s], and goes at another speed."""
    depth = [start, deepest, deepest, far]
    steps = [(deepest - start) / approach, rest, (deepest - far) / retraction]
    return rs.indent(gel, tip, depth=depth, time=np.append(0.0, np.cumsum(steps)), adhesion=sticky, rtol=1e-3)


# %%
# On the left the contact closes slowly and rests for 100 s, as its edge heals in many relaxation times; on the right
# it closes and opens at 1 mm/s.
speeds, rests = np.geomspace(1e-10, 1e-3, 8), np.geomspace(1e-3, 100.0, 11)
over_rate = [pull(1e-7, 100.0, speed) for speed in speeds]
over_rest = [pull(fast, rest, fast) for rest in rests]
by_rate, by_rest = (np.array([each.pull_off_force for each in some]) / unit for some in (over_rate, over_rest))

# %%
# The limits: elastic tips at rest (Maugis 1992) of both moduli, and the flat punch on glass of the relaxed contact
# radius a, ``sqrt(8 pi w E0 a^3)``, which an infinitely thin zone would have. With the zone as it is, the relaxed
# contact keeps its displacements, and each change of a load takes the instantaneous modulus; no memory is needed.
radii = np.geomspace(1e-7, 3e-6, 400)
soft, glass = (max(-static_contact(tip, modulus, sticky, a).force for a in radii) / unit for modulus in (1e6, 5e6))
punch = math.sqrt(8.0 * math.pi * 0.01 * 5e6 * over_rate[-1].max_contact_radius ** 3) / unit


def frozen():
    """Largest pull [N] of a relaxed contact on glass, from the loads of its elements on a grid."""
    soft_modulus, glass_modulus, stress, reach, radius = 1e6, 5e6, 0.01 / 20e-9, 20e-9, 5e-6
    at = brentq(lambda a: static_contact(tip, soft_modulus, sticky, a).depth - deepest, 5e-7, 3e-6)
    held = static_contact(tip, soft_modulus, sticky, at)

    def state(c, d):
        angle = (np.arange(4000) + 0.5) * (0.5 * math.pi / 4000)
        x = c * np.sin(angle)
        ring = -2.0 * stress * np.sqrt(np.maximum(held.edge**2 - x**2, 0.0))
        before = np.where(x < held.radius, soft_modulus * (deepest - x**2 / radius), ring)
        shape = before / soft_modulus
        follows = before + glass_modulus * (d - x**2 / radius - shape)
        load = np.maximum(follows, -2.0 * stress * c * np.cos(angle))
        gap = shape + (load - before) / glass_modulus - d + x**2 / radius
        step = 0.5 * math.pi / 4000
        return gap.sum() * step - 0.5 * math.pi * reach, 2.0 * (load * c * np.cos(angle)).sum() * step

    edges = np.linspace(0.9, 1.0, 40) * held.edge
    depths = [brentq(lambda d, c=c: state(c, d)[0], -6e-6, 6e-6) for c in edges]
    return max(-state(c, d)[1] for c, d in zip(edges, depths, strict=True))


opened = frozen() / unit
figure, (left, right) = plt.subplots(1, 2, figsize=(7.2, 3.0), layout="constrained", sharey=True)
left.plot(1e6 * speeds, by_rate, "o-", markersize=3)
right.plot(rests, by_rest, "o-", markersize=3)
for ax, label in ((left, "speed of the retraction [µm/s]"), (right, "time of rest [s]")):
    for limit, words in ((soft, "soft, glass"), (glass, ""), (opened, "frozen"), (punch, "frozen punch, thin zone")):
        ax.axhline(limit, color="0.5", linestyle=":")
        ax.text(0.02, limit, words, transform=ax.get_yaxis_transform(), va="bottom", fontsize=7)
    ax.set(xscale="log", xlabel=label)
left.set(ylabel="largest pull over pi w R", ylim=(0.0, 1.1 * punch))

print(f"soft {soft:.3f}, glass {glass:.3f}, frozen {opened:.3f}, frozen punch of a thin zone {punch:.2f}")
print("over the speed:", by_rate.round(2))
print("over the rest:", by_rest.round(2))
assert abs(by_rate[0] / soft - 1.0) < 0.05
assert np.all(np.diff(by_rate) > 0.0)
assert np.all(np.diff(by_rest) > 0.0)
assert abs(by_rest[0] / glass - 1.0) < 0.1
assert abs(by_rest[-1] / opened - 1.0) < 2e-3
assert abs(by_rate[-1] / opened - 1.0) < 2e-3
