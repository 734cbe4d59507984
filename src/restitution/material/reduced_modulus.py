"""Reduced relaxation modulus E*(t) of a material or of two; a contact depends on no other modulus."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.material.conversion import NOTHING, connect, on_common_times, series_connection
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material

Array = NDArray[np.float64]


def reduced_modulus(material: Material, counter_material: Material | None = None) -> PronySeries:
    """Reduced relaxation modulus E*(t) [Pa] of a material, or of two bodies in contact.

    By the correspondence principle the Carson transforms obey

        E* = 4G(3K + G)/(3K + 4G),    1/E* = 1/E1* + 1/E2* for two bodies.

    Each is a series connection (of 4G and 4K + 4G/3, or of the two bodies) and so again a Prony series.

    Parameters
    ----------
    material
        Material of the half-space.
    counter_material
        Material of the other body; None if it is rigid.

    Returns
    -------
    PronySeries
        Simplified: no zero branches, times ascending.

    Notes
    -----
    Lee and Radok, J. Appl. Mech. 27 (1960) 438. Valid for small strains, frictionless contact, half-spaces.

    Examples
    --------
    A standard solid with a constant bulk modulus has two branches in E*, the first one that of G:

    >>> material = Material(PronySeries(1.0, [4.0], [1.0]), bulk=4.0)
    >>> series = reduced_modulus(material)
    >>> print(series.relaxation_times, series.branch_moduli)
    [1. 2.] [4.    3.375]
    """
    own = _single(material)
    if counter_material is None:
        return own
    return series_connection(own, _single(counter_material))


def _single(material: Material) -> PronySeries:
    shear = material.shear.simplified()
    if not isinstance(material.bulk, PronySeries):
        return shear.scaled(4.0)
    times, g, k = on_common_times(shear, material.bulk.simplified())
    first = NOTHING.plus(g, 4.0)
    second = NOTHING.plus(g, 4.0 / 3.0).plus(k, 4.0)
    # Where 4G + 4K + 4G/3 = 0, also 4G = -3K, which is exact where G itself cancels.
    return connect(times, first, second, NOTHING.plus(k, 3.0))


class ReducedStandardSolid(NamedTuple):
    """Reduced moduli E*(t) of n standard solids: a Prony series of two terms each."""

    equilibrium: Array  # E*inf [Pa], shape (n,)
    moduli: Array  # branch moduli [Pa], shape (n, 2); the second is 0 where there is one branch
    times: Array  # relaxation times [s], shape (n, 2)


def reduced_standard_solid(
    poisson_ratio: Array, equilibrium_modulus: Array, branch_modulus: Array, relaxation_time: Array
) -> ReducedStandardSolid:
    """Reduced moduli of standard solids in shear with a constant bulk modulus.

    With K the bulk modulus of nu and G0 = Ginf + G1::

        E*inf = 2 Ginf/(1 - nu)
        E1 = G1,                                                tau1 = tau
        E2 = (27 K^2/4) [1/(3K + 4 Ginf) - 1/(3K + 4 G0)],      tau2 = tau (3K + 4 G0)/(3K + 4 Ginf)

    For nu = 1/2 both branches are one, E1 = 4 G1 at tau, and for nu = -1 the second vanishes.

    Parameters
    ----------
    poisson_ratio
        Static Poisson ratio nu, in [-1, 0.5], shape (n,).
    equilibrium_modulus, branch_modulus
        Ginf > 0 and G1 > 0 [Pa], shape (n,).
    relaxation_time
        tau = eta/G1 > 0 [s], shape (n,).

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
    # Ginf/K rather than K, which is infinite for nu = 1/2; K/Ginf where it is the small one.
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
