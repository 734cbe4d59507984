"""Numbers of a relaxation modulus for the elements of `restitution.kernel.panels`."""

import numpy as np

from restitution.kernel.panels import Solid
from restitution.material.prony import PronySeries, secular_roots


def solid_of(series: PronySeries) -> Solid:
    """Return the numbers of one Prony series, and of its inverse.

    The rates of recovery r_j, with E*(-r_j) = 0, and theta_jk = r_j/(r_j - rho_k) come from the secular equation,
    without differences of close numbers.
    """
    series = series.simplified()
    moduli, times = series.branch_moduli[::-1].copy(), series.relaxation_times[::-1].copy()
    equilibrium, viscosity = float(series.equilibrium_modulus), float(series.parallel_viscosity)
    roots = secular_roots(equilibrium, viscosity, moduli, times)
    recoveries, displacement = 1.0 / roots.times, equilibrium / roots.slopes
    loads, touching = roots.terms / roots.slopes[:, None], moduli[:, None] * roots.terms.T
    if equilibrium == 0.0:
        # The root 0 of a liquid, whose part of the displacement is u - sum tau_k l_k/(flow viscosity).
        flow = viscosity + float(moduli @ times)
        recoveries, displacement = np.append(0.0, recoveries), np.append(1.0, displacement)
        loads = np.concatenate([-times[None] / flow, loads])
        touching = np.concatenate([np.zeros((times.size, 1)), touching], axis=1)
    return Solid(
        equilibrium, viscosity, moduli, 1.0 / times, equilibrium + float(moduli.sum()), recoveries, displacement,
        np.ascontiguousarray(loads), np.ascontiguousarray(touching),
    )  # fmt: skip
