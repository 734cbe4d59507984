"""Elastic waves that a contact sends into a deep body: their speed and the energy that they carry away."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.material.columns import PronyColumns, bulk_columns
from restitution.material.viscoelastic import Material

Array = NDArray[np.float64]

# int F'^2 dt = 4.685 F_max^2/T for a Hertz impact: (9/2) J 2.9433 with J = (2/5) B(4/5, 3/2).
_PULSE = 4.685148538378611
# A fit of Lamb's integral over -1 <= nu <= 1/2, to 1 %.
_RADIATION = (0.21379863, -0.2969058, 0.12651742, 0.04364896, 0.01676971)


class Waves(NamedTuple):
    """Waves of a contact, NaN where no density is known.

    Attributes
    ----------
    speed : array
        Speed c [m/s] of the slowest shear wave.
    energy : array
        Energy [J] that the waves carry away.
    """

    speed: Array
    energy: Array


def radiated(
    pairs: Sequence[tuple[Material, ...]], kind: NDArray[np.intp], contact_time: Array, max_force: Array
) -> Waves:
    """Waves of contacts that last T and reach the force F_max, with the history of a Hertz impact.

    Parameters
    ----------
    pairs : sequence of tuple of Material
        The one or two bodies of each kind of contact. Only the body that would radiate more counts: the other is a
        ball, which keeps its waves.
    kind : array of int, shape (n,) or (1,)
        Place of each contact's bodies in `pairs`, or that of all.
    contact_time, max_force : array, shape (n,)
        T [s] and F_max [N].

    Notes
    -----
    ``4.685 beta(nu) F_max^2/(rho c^3 T)`` to first order, for a point force (Lamb 1904; Hunter 1957), with the wave
    speed ``c = sqrt(G'(omega)/rho)`` at the rate of the contact, omega = 1/T, where G'(1/T) is near G(T).
    """
    speed, energy = np.full(contact_time.shape, np.nan), np.full(contact_time.shape, np.nan)
    with np.errstate(all="ignore"):
        rate = np.where(contact_time > 0.0, 1.0 / contact_time, 0.0)
        # A body without a counter-body counts twice, which changes no extreme.
        for place in (0, -1)[: max(map(len, pairs))]:
            bodies = [pair[place] for pair in pairs]
            density = np.array([body.density for body in bodies], dtype=np.float64)[kind]
            if np.isnan(density).all():
                continue
            shear = PronyColumns.stacked([body.shear for body in bodies]).take(kind).storage_modulus(rate)
            bulk = bulk_columns(bodies).take(kind).storage_modulus(rate)
            # No wave runs in a body that only flows.
            own = np.where(shear > 0.0, np.sqrt(shear / density), np.nan)
            nu = np.where(np.isinf(bulk), 0.5, (3.0 * bulk - 2.0 * shear) / (6.0 * bulk + 2.0 * shear))
            speed = np.fmin(speed, own)
            power = radiation(nu) / (density * own**3)
            energy = np.fmax(energy, power * _PULSE * max_force**2 / contact_time)
    return Waves(speed, energy)


def radiation(poisson_ratio: ArrayLike) -> Array:
    """Factor beta of the power ``beta F'^2/(rho c^3)`` that a normal point force radiates into a half-space.

    Parameters
    ----------
    poisson_ratio : float or array
        Poisson ratio from -1 to 1/2.

    Returns
    -------
    array
        Lamb's integral over the waves in the body and the Rayleigh wave, to 1 %; c is the shear wave speed.

    Examples
    --------
    >>> print(radiation(0.5).round(4))
    0.1035
    """
    values = np.polynomial.polynomial.polyval(np.asarray(poisson_ratio), _RADIATION)
    return np.asarray(values, dtype=np.float64)
