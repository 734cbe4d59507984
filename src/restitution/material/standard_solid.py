"""The reduced modulus of the compressible standard solid in closed form, for arrays."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class ReducedStandardSolid(NamedTuple):
    """Reduced moduli E*(t) of n standard solids: a two-term Prony series each.

    Attributes
    ----------
    equilibrium : array, shape (n,)
        E*inf [Pa].
    moduli, times : array, shape (n, n_branch)
        Branch moduli [Pa] and relaxation times [s], two of each; the second modulus is 0 where there is one branch.
    """

    equilibrium: Array
    moduli: Array
    times: Array


def reduced_standard_solid(
    poisson_ratio: Array, equilibrium_modulus: Array, branch_modulus: Array, relaxation_time: Array
) -> ReducedStandardSolid:
    """Reduced moduli of standard solids in shear with a constant bulk modulus.

    Parameters
    ----------
    poisson_ratio : array, shape (n,)
        Static Poisson ratio nu, in [-1, 0.5].
    equilibrium_modulus, branch_modulus : array, shape (n,)
        Ginf > 0 and G1 > 0 [Pa].
    relaxation_time : array, shape (n,)
        tau = eta/G1 > 0 [s].

    Returns
    -------
    ReducedStandardSolid
        With K the bulk modulus of nu and G0 = Ginf + G1::

            E*inf = 2 Ginf/(1 - nu)
            E1 = G1,                                                tau1 = tau
            E2 = (27 K^2/4) [1/(3K + 4 Ginf) - 1/(3K + 4 G0)],      tau2 = tau (3K + 4 G0)/(3K + 4 Ginf)

        For nu = 1/2 both branches are one, E1 = 4 G1 at tau, and for nu = -1 the second vanishes.

    Notes
    -----
    From `E* = 4 G (3K + G)/(3K + 4G)` in Carson transforms, as `G + 9K/4 - (27 K^2/4)/(3K + 4G)`.

    Examples
    --------
    >>> one = np.ones(1)
    >>> solid = reduced_standard_solid(0.5 * one, one, 10.0 * one, one)
    >>> solid.equilibrium.tolist(), solid.moduli.tolist(), solid.times.tolist()
    ([4.0], [[40.0, 0.0]], [[1.0, 1.0]])
    """
    # Ginf/K rather than K, which is infinite for nu = 1/2; K/Ginf where that is the small one.
    soft = poisson_ratio < 0.2
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        K = 2.0 * (1.0 + poisson_ratio) / (3.0 * (1.0 - 2.0 * poisson_ratio))
        ratio = branch_modulus / equilibrium_modulus
        equilibrated = np.where(soft, 3.0 * K + 4.0, 3.0 + 4.0 / K)
        glassy = np.where(soft, 3.0 * K + 4.0 * (1.0 + ratio), 3.0 + 4.0 * (1.0 + ratio) / K)
        second = np.where(soft, 27.0 * K**2, 27.0) * branch_modulus / (equilibrated * glassy)
    equilibrium = 2.0 * equilibrium_modulus / (1.0 - poisson_ratio)
    incompressible = poisson_ratio == 0.5
    first = np.where(incompressible, 4.0, 1.0) * branch_modulus
    moduli = np.column_stack([first, np.where(incompressible, 0.0, second)])
    times = np.column_stack([relaxation_time, relaxation_time * glassy / equilibrated])
    return ReducedStandardSolid(equilibrium, moduli, times)
