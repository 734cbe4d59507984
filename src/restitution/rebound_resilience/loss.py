"""Loss tangent that a measured rebound resilience means, and its range over the materials that share it."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.checks import single, within
from restitution.contact.profile import Parabola
from restitution.impact.batch import Batch
from restitution.material.columns import PronyColumns

Array = NDArray[np.float64]

# Resiliences [%] that the families reach.
_LOWEST, _HIGHEST = 1.0, 99.5
# Branch over equilibrium modulus of the standard solids, close where the largest loss tangent varies with it, and the
# relaxation times of each in the time unit of the impact: the range is known to 1 %.
_RATIOS = np.concatenate([np.geomspace(2e-3, 20.0, 120), np.geomspace(30.0, 1e4, 8)])
_FAST, _SLOW, _TIMES = 3e-5, 1e3, 240
# Exponents of the power laws, and their relaxation times.
_EXPONENTS = np.concatenate([np.geomspace(1e-3, 0.05, 8), np.linspace(0.1, 0.8, 15)])
_DECADES = np.arange(-8.0, 6.0, 0.3)


class ImpliedLoss(NamedTuple):
    """Loss tangent [-] at the angular frequency pi over the contact time, from a resilience.

    Attributes
    ----------
    loss_tangent : float
        That of a power-law material, G ~ t^-n, which has the same one at all frequencies near the contact.
    low, high : float
        Range over the standard solids that have this resilience, from Kelvin-Voigt to Maxwell.
    """

    loss_tangent: float
    low: float
    high: float


def implied_loss_tangent(rebound_resilience: float) -> ImpliedLoss:
    """Loss tangent that a rebound resilience means, on a half-space.

    Parameters
    ----------
    rebound_resilience : float
        Measured R = e^2 in per cent, from 1 to 99.5.

    Returns
    -------
    ImpliedLoss
        The loss tangent at pi over the contact time, and its range over materials that share R.

    Raises
    ------
    InputError
        If R is out of this range.

    Notes
    -----
    The coefficient of restitution depends on the loss tangent at the time of the contact, and little on the rest of
    the spectrum (Willert 2020). A rigid sphere on an incompressible half-space has the same relation for all radii,
    masses, velocities and moduli. The range is that of all standard solids ``G = G_inf + G_1 exp(-t/tau)`` with
    G_1/G_inf from 0.002 to 10^4 that have this R. Nearly all of 2600 random Prony series of one to seven times lie in
    it, and the farthest is 5 % outside.

    Examples
    --------
    >>> found = implied_loss_tangent(64.0)
    >>> print(round(found.loss_tangent, 3), round(found.low, 2), round(found.high, 2))
    0.18 0.14 0.21
    """
    measured = single("rebound_resilience", within("rebound_resilience", rebound_resilience, _LOWEST, _HIGHEST, "%"))
    e = np.sqrt(measured / 100.0)
    law_e, law_tangent = _power_laws()
    solids_e, solids_tangent = _standard_solids()
    # Each step along the relaxation times in which the restitution passes the measured one.
    share = (e - solids_e[:, :-1]) / np.diff(solids_e, axis=1)
    rows, steps = np.nonzero((share >= 0.0) & (share < 1.0))
    start, end = np.log(solids_tangent[rows, steps]), np.log(solids_tangent[rows, steps + 1])
    found = np.exp(start + share[rows, steps] * (end - start))
    return ImpliedLoss(_interpolated(e, law_e, law_tangent), float(found.min()), float(found.max()))


def _interpolated(e: float, known: Array, tangent: Array) -> float:
    from scipy.interpolate import PchipInterpolator

    # The loss tangent is nearly proportional to -ln e.
    loss = -np.log(known)
    return float(PchipInterpolator(loss, tangent / loss)(-np.log(e)) * -np.log(e))


@cache
def _standard_solids() -> tuple[Array, Array]:
    """Restitution and loss tangent, shape (n_ratio, n_time)."""
    place = np.linspace(0.0, 1.0, _TIMES)
    times = (_FAST / _RATIOS[:, None]) ** (1.0 - place) * _SLOW**place
    moduli = np.broadcast_to(_RATIOS[:, None], times.shape)
    rows = times.size
    series = PronyColumns(np.ones(rows), np.zeros(rows), moduli.reshape(rows, 1), times.reshape(rows, 1))
    e, tangent = (column.reshape(times.shape) for column in _solved(series))
    return e, tangent


@cache
def _power_laws() -> tuple[Array, Array]:
    times = 10.0**_DECADES
    # The slowest term stands for all slower ones.
    moduli = times ** -_EXPONENTS[:, None]
    rows = _EXPONENTS.size
    equilibrium = moduli[:, -1] / (10.0 ** (0.3 * _EXPONENTS) - 1.0)
    return _solved(PronyColumns(equilibrium, np.zeros(rows), moduli, np.broadcast_to(times, moduli.shape)))


def _solved(series: PronyColumns) -> tuple[Array, Array]:
    """Restitution and loss tangent of impacts of unit mass, velocity and radius."""
    columns = Batch.from_columns(series, Parabola(1.0), 1.0, 1.0, 0.0).solve(1e-7)
    omega = np.pi / columns["contact_time"]
    phase = omega[:, None] * series.times
    loss_modulus = (series.moduli * phase / (1.0 + phase**2)).sum(axis=1)
    return columns["restitution_coefficient"], loss_modulus / series.storage_modulus(omega)
