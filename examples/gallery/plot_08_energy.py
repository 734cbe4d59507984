r"""
Where the energy goes
=====================

The foundation stores the kinetic energy of the body, returns a part of it and dissipates the rest. The energy that is
still stored at separation is also lost to the body.
"""

import matplotlib.pyplot as plt

import restitution as rs
from restitution.plot.history import energy_area, force_indentation

# %%
# A ball of 5 g and 10 mm radius hits the paper's solid with :math:`\nu = 0.3`, :math:`p_2 = 0.01` and
# :math:`p_3 = 3` at 1 m/s.

equilibrium, radius, mass, velocity = 1e6, 0.01, 0.005, 1.0
viscosity = 3.0 * (mass**2 * equilibrium**3 / (velocity * radius)) ** 0.2
solid = rs.standard_solid(equilibrium, 100.0 * equilibrium, viscosity, poisson_ratio=0.3)
result = rs.solve(rs.Impact(solid, rs.Parabola(radius), mass=mass, velocity=velocity))

fig, (left, right) = plt.subplots(1, 2, figsize=(8.0, 3.6), layout="constrained")
force_indentation(left, result.history)
energy_area(right, result.history)

# %%
# The area of the loop is the lost energy. The package computes it by quadrature over the foundation, not as a
# difference of kinetic energies. An independent integration with a relative tolerance of 1e-11 gives
# e = 0.222977189502 (``tests/data/standard_solid.csv``). The lost share of the kinetic energy is therefore
# :math:`1 - e^2`.

budget = result.energy
dissipated, stored = budget.dissipated / budget.kinetic_in, budget.stored / budget.kinetic_in
print(f"dissipated {dissipated:.9f}, still stored {stored:.9f}")
print(f"together {dissipated + stored:.9f}, 1 - e^2 = {1.0 - 0.222977189502**2:.9f}")
assert abs(dissipated + stored - (1.0 - 0.222977189502**2)) < 1e-8
