r"""
What e(v) does not determine
============================

A ball has the same restitution coefficient on two materials, at all velocities. One of them is about 16 times as stiff
as the other and relaxes three times as fast. No set of restitution coefficients can distinguish them, but one contact
time can.
"""

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs

velocity = np.geomspace(0.05, 0.5, 10)
radius, mass = 0.01, 0.033
equilibrium, branch, viscosity = 3e6, 3e7, 6e3


def rubber(factor):
    """Standard solid whose moduli are multiplied by factor^(5/2) and whose relaxation time is divided by factor."""
    moduli = factor**2.5
    return rs.standard_solid(moduli * equilibrium, moduli * branch, factor**1.5 * viscosity, poisson_ratio=0.5)


results = {factor: rs.solve(rs.Impact(rubber(factor), rs.Parabola(radius), mass, velocity)) for factor in (1.0, 3.0)}

# %%
# The measured values have a noise of 0.5 %. They do not determine a modulus or a time:

rng = np.random.default_rng(1)
measured = results[1.0].restitution_coefficient * (1.0 + 0.005 * rng.standard_normal(velocity.size))
noise = rs.Noise(restitution_coefficient="0.5 %")
balls = rs.Rebounds(velocity, measured, radius=radius, mass=mass, noise=noise)
fit = rs.identify(balls, rs.standard_solid, fixed={"poisson_ratio": 0.5})
for line in fit.statements:
    print(line)

# %%
# One contact time is enough. The first nine are unknown (NaN), and the last one has a noise of 1 %:

times = np.full(velocity.size, np.nan)
times[-1] = results[1.0].contact_time[-1] * 1.01
noise = rs.Noise(restitution_coefficient="0.5 %", contact_time="1 %")
balls = rs.Rebounds(velocity, measured, radius=radius, mass=mass, contact_time=times, noise=noise)
settled = rs.identify(balls, rs.standard_solid, fixed={"poisson_ratio": 0.5})
for name, estimate in settled.parameters.items():
    print(f"{name}: {estimate.words}")

fig, (left, right) = plt.subplots(1, 2, figsize=(7.2, 3.2), layout="constrained")
for (factor, result), style in zip(results.items(), ("-", "--"), strict=True):
    label = f"moduli x {factor**2.5:.3g}, times / {factor:g}"
    left.plot(velocity, result.restitution_coefficient, style, label=label)
    right.plot(velocity, 1e3 * result.contact_time, style, label=label)
left.errorbar(velocity, measured, 0.005 * measured, fmt="o", color="k", markersize=3, label="measured")
right.errorbar(velocity[-1:], 1e3 * times[-1:], 0.01e3 * times[-1:], fmt="o", color="k", markersize=3)
left.set(xlabel="velocity [m/s]", ylabel="restitution coefficient $e$")
right.set(xlabel="velocity [m/s]", ylabel="contact time [ms]", ylim=(0.0, None))
left.legend()

# %%
# The restitution coefficients of both materials agree, and the contact times differ by a factor of three.

assert np.allclose(results[1.0].restitution_coefficient, results[3.0].restitution_coefficient, rtol=1e-8)
assert np.allclose(results[1.0].contact_time, 3.0 * results[3.0].contact_time, rtol=1e-8)
assert not any(estimate.determined for estimate in fit.parameters.values())
assert any("x^2.5" in line for line in fit.statements)
branch_modulus = settled.parameters["branch_modulus"]
assert branch_modulus.determined
assert abs(np.log(branch_modulus.value / branch)) < 3.0 * branch_modulus.standard_error / branch_modulus.value
