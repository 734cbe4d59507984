"""Numbers of a relaxation modulus for the elements of `restitution.kernel.panels`."""

from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from restitution.checks import Array
from restitution.kernel.panels import Solid
from restitution.kernel.record import Solids
from restitution.material.prony import PronySeries, secular_roots


# Many histories of one material follow each other, and its roots take longer than a short one.
@lru_cache(maxsize=32)
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


@lru_cache(maxsize=32)
def compliance_of(series: PronySeries) -> tuple[float, Array, Array]:
    """Return J0 and c_j, r_j of ``1/E*(p) = J0 + sum c_j/(p + r_j)`` of a solid without a parallel dashpot."""
    series = series.simplified()
    equilibrium, moduli = float(series.equilibrium_modulus), series.branch_moduli[::-1].copy()
    times = series.relaxation_times[::-1].copy()
    roots = secular_roots(equilibrium, 0.0, moduli, times)
    rates = 1.0 / roots.times
    weights = rates / roots.slopes
    if equilibrium == 0.0:
        # A liquid flows for ever.
        rates, weights = np.append(0.0, rates), np.append(1.0 / float(moduli @ times), weights)
    return 1.0 / (equilibrium + float(moduli.sum())), np.ascontiguousarray(weights), np.ascontiguousarray(rates)


@lru_cache(maxsize=32)
def branches_of(series: PronySeries) -> tuple[tuple[Array, Array, Array], Array]:
    """Return E_k, s_k of the branches and sum_k E_k/(s_k - r_j), and 1/(s_k - r_j), with r_j of `compliance_of`."""
    series = series.simplified()
    equilibrium, moduli = float(series.equilibrium_modulus), series.branch_moduli[::-1].copy()
    times = series.relaxation_times[::-1].copy()
    roots = secular_roots(equilibrium, 0.0, moduli, times)
    bridge, creep = -roots.terms * roots.times[:, None], equilibrium * roots.times
    if equilibrium == 0.0:
        bridge, creep = np.concatenate([times[None], bridge]), np.append(float(moduli @ times), creep)
    return (moduli, 1.0 / times, creep), np.ascontiguousarray(bridge)


def in_units(solid: Solid, modulus: float, time: float) -> Solid:
    """Return the same numbers in units of a modulus [Pa] and a time [s]."""
    return Solid(
        solid.equilibrium / modulus, solid.viscosity / modulus / time, solid.moduli / modulus, solid.rates * time,
        solid.glass / modulus, solid.recoveries * time, solid.displacement, solid.loads * modulus,
        solid.moduli_of / modulus,
    )  # fmt: skip


def solids_of(series: PronySeries) -> Iterator[tuple[NDArray[np.intp], Solids]]:
    """Yield the same numbers of many series, in groups of equal numbers of branches, and the places of each group.

    A series without a modulus, or with one that is not finite, is left out.
    """
    short = series.simplified()
    for rows, group in short.groups():
        equilibrium, viscosity, moduli, times = group.columns
        total = equilibrium + viscosity + moduli.sum(axis=1)
        kept = np.isfinite(total) & (total > 0.0) & np.isfinite(times).all(axis=1)
        for liquid in (False, True):
            part = np.flatnonzero(kept & ((equilibrium == 0.0) == liquid))
            if part.size:
                parts = equilibrium[part], viscosity[part], moduli[part, ::-1], times[part, ::-1]
                yield rows[part], _solids(*map(np.ascontiguousarray, parts))


def _solids(equilibrium: Array, viscosity: Array, moduli: Array, times: Array) -> Solids:
    """Return the numbers of solids, or of liquids; times descending."""
    roots = secular_roots(equilibrium, viscosity, moduli, times)
    recoveries, displacement = 1.0 / roots.times, equilibrium[:, None] / roots.slopes
    loads, touching = roots.terms / roots.slopes[:, :, None], moduli[:, :, None] * roots.terms.swapaxes(1, 2)
    if equilibrium[0] == 0.0:
        flow = viscosity + (moduli * times).sum(axis=1)
        n, none = flow.size, np.zeros((flow.size, 1))
        recoveries = np.concatenate([none, recoveries], axis=1)
        displacement = np.concatenate([np.ones((n, 1)), displacement], axis=1)
        loads = np.concatenate([-times[:, None] / flow[:, None, None], loads], axis=1)
        touching = np.concatenate([np.zeros((n, times.shape[1], 1)), touching], axis=2)
    parts = moduli, 1.0 / times, recoveries, displacement, loads, touching
    return Solids(equilibrium, viscosity, *map(np.ascontiguousarray, parts))
