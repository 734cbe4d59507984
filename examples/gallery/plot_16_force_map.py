r"""
A force map
===========

An atomic force microscope presses its tip into a gel at 8 x 8 places. In the middle lies a stiff inclusion. Each curve
has a contact point of its own and noise of 10 pN. `rs.identify_map` fits all curves with a standard solid.
"""

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs
from restitution.plot.identification import grid

rng = np.random.default_rng(3)
tip, n = rs.Parabola(2.5e-6), 8
time = np.linspace(0.0, 2.8, 161)
depth = np.interp(time, [0.0, 1.4, 2.8], [0.0, 1.4e-6, 0.0])
y, x = np.mgrid[0:n, 0:n] - 3.5
truth = 270.0 * (1.0 + 3.0 * np.exp(-(x**2 + y**2) / 4.0))  # branch modulus [Pa]

curves = []
for modulus in truth.ravel():
    gel = rs.standard_solid(0.25 * modulus, modulus, 0.3 * modulus, poisson_ratio=0.5)
    contact = 4e-7 + 5e-8 * rng.standard_normal()
    force = rs.indent(gel, tip, depth=depth - contact, time=time).force + 1e-11 * rng.standard_normal(time.size)
    curves.append(rs.IndentationCurve(time, depth, force, profile=tip, noise=rs.Noise(force=1e-11)))

maps = rs.identify_map(curves, rs.standard_solid, fixed={"poisson_ratio": 0.5}, shape=(n, n), progress=False)
grid(maps, "branch_modulus", figure=plt.figure())

# %%
# The standard errors are those of the noise: the deviations from the true modulus have a spread of one of them.

deviation = (maps["branch_modulus"].values - truth) / maps["branch_modulus_standard_error"].values
print(f"{n * n} curves, spread {deviation.std():.2f} standard errors, mean {deviation.mean():+.2f}")
assert np.all(maps["status"].values == 0)
# 64 draws of a normal distribution have a spread of 1 to 9 %.
assert 0.7 < deviation.std() < 1.3
