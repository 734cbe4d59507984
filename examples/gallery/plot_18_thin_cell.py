r"""
A cell on glass under an atomic force microscope
================================================

A bead of 5 µm diameter is pressed 0.3 µm deep into a cell that sticks to glass. The thinner the cell is, the more the
glass adds to the force. A fit with Hertz's law then reports a modulus that is too large. The usual polynomial for thin
samples (Dimitriadis and others 2002) corrects a part of it. `rs.Layer` is exact at every thickness.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs

bead, deepest = rs.Parabola(radius=2.5e-6), 3e-7
time, depth = np.linspace(0.0, 1.0, 101), np.linspace(0.0, deepest, 101)


def force(material, geometry):
    """Force [N] at the times of the approach."""
    return rs.indent(material, geometry, depth=depth, time=time).force


# %%
# An elastic cell shows the bias: the modulus that the fit of a law reports, over the true one.

elastic = rs.elastic(shear_modulus=500.0, poisson_ratio=0.5)
hertz = force(elastic, bead)
dimitriadis = np.polynomial.Polynomial([1.0, 1.133, 1.283, 0.769, 0.0975])
thickness = np.geomspace(6e-7, 3e-5, 41)
forces = np.array([force(elastic, rs.Layer(bead, thickness=h)) for h in thickness])
laws = {
    "Hertz": np.tile(hertz, (thickness.size, 1)),
    "Dimitriadis 2002": hertz * dimitriadis(np.sqrt(bead.radius * depth) / thickness[:, None]),
}

# %%
# A viscoelastic cell, with noise of 2 pN: the material is identified with each geometry from the approach and the
# retraction. The points are the equilibrium modulus over the true one. With a wrong geometry it is further off than
# the elastic modulus, because the fit takes the stiffening by the glass for a lack of relaxation.

rng = np.random.default_rng(5)
cell = rs.standard_solid(300.0, 700.0, 150.0, poisson_ratio=0.5)
moments = np.linspace(0.0, 3.0, 241)
path = np.interp(moments, [0.0, 1.5, 3.0], [-2e-7, deepest, -2e-7])
fig, ax = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
for (name, law), line in zip(laws.items(), ("C0-", "C1--"), strict=True):
    ax.semilogx(1e6 * thickness, np.sum(forces * law, axis=1) / np.sum(law * law, axis=1), line, label=name)
for name, marker in (("fit with Hertz", "C0s"), ("fit with rs.Layer", "C2o")):
    ratios, errors = [], []
    for h in (1e-6, 3e-6, 1e-5):
        layer = rs.Layer(bead, thickness=h)
        measured = rs.indent(cell, layer, depth=path, time=moments).force
        measured = measured + 2e-12 * rng.standard_normal(moments.size)
        geometry = bead if "Hertz" in name else layer
        curve = rs.IndentationCurve(moments, path, measured, profile=geometry, noise=rs.Noise(force=2e-12))
        modulus = rs.identify(curve, rs.standard_solid, fixed={"poisson_ratio": 0.5}).parameters["equilibrium_modulus"]
        ratios.append(modulus.value / 300.0)
        errors.append(modulus.standard_error / 300.0)
    ax.errorbar([1.0, 3.0, 10.0], ratios, errors, fmt=marker, capsize=3, label=name)
assert all(abs(ratio - 1.0) < 4.0 * error for ratio, error in zip(ratios, errors, strict=True))
ax.axhline(1.0, color="black", linewidth=0.6)
ax.set_ylim(0.0, 8.0)
ax.set_xticks([1, 3, 10, 30], ["1", "3", "10", "30"])
ax.set_xlabel("thickness of the cell [µm]")
ax.set_ylabel("reported over true modulus")
ax.legend()

# %%
# Where :math:`\sqrt{Rd}` is half of the thickness, the exact force is 2.1562150058 times that of Hertz, from two
# discretisations that share no code with the package. The polynomial is 7.7 % low there.

half = 2.0 * math.sqrt(bead.radius * deepest)
ratio = float(force(elastic, rs.Layer(bead, thickness=half))[-1] / hertz[-1])
print(f"force over that of Hertz: {ratio:.10f}, by the polynomial {dimitriadis(0.5):.4f}")
assert abs(ratio / 2.1562150058 - 1.0) < 1e-9
