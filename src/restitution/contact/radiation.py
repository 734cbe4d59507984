"""Elastic waves that a contact sends into a deep body: their speed and the energy that they carry away."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.checks import Array
from restitution.material.prony import PronySeries

# int F'^2 dt = 4.685 F_max^2/T for a Hertz impact: (9/2) J 2.9433 with J = (2/5) B(4/5, 3/2).
_PULSE = 4.685148538378611
# Growth of this constant with y^2 and y^4, where the centroid of the force over time is at T/2 - y T: a fit.
_SKEW = (16.0, 48.0)
# No force on a body that separates is as skew.
_LARGEST_SKEWNESS = 0.4
# Lamb's integral as a polynomial of sqrt(1 - 2 nu): it is a smooth function of this root over -1 <= nu <= 1/2.
_RADIATION = (
    0.10442426452, -5.693e-08, 0.04200903881, 0.05300659872, 0.01732188709, 0.00297099324, -0.01243127032,
    0.01008481349, -0.00425309368, 0.00083755559, 3.509277e-05, -4.84898e-05, 6.64186e-06,
)  # fmt: skip


class Waves(NamedTuple):
    """Waves of a contact, NaN where no density is known.

    Attributes
    ----------
    speed : array
        Speed c [m/s] of the shear wave in the body that radiates more, or of the slowest one if both keep them.
    energy : array
        Energy [J] that the waves carry away; 0 where they return in contact.
    place : array
        0 or 1 for the body that radiates more.
    """

    speed: Array
    energy: Array
    place: Array


class Bodies(NamedTuple):
    """First or second bodies of kinds of contacts, one in each row.

    Attributes
    ----------
    shear, bulk : PronySeries
        Relaxation moduli [Pa], infinite in bulk where they are incompressible.
    density : array
        Densities [kg/m^3]; NaN if not known.
    """

    shear: PronySeries
    bulk: PronySeries
    density: Array


def radiated(
    pairs: Sequence[Bodies],
    is_single: NDArray[np.bool_],
    kind: NDArray[np.intp],
    contact_time: Array,
    max_force: Array,
    skewness: Array,
    sizes: tuple[Array, Array],
) -> Waves:
    """Return waves that contacts send into their bodies; the contacts last T [s] and reach the force F_max [N].

    `pairs` are the first and, if any, the second bodies of the kinds of contacts, and `kind` is that of each contact;
    a kind that `is_single` has one body alone. Only the body that radiates more counts. The `skewness` is y = 1/2 less
    the centroid of the force over time, divided by T. A body whose smallest dimension h [m] in `sizes` is finite keeps
    the waves that return in contact, 2 h < c T.

    Notes
    -----
    ``beta(nu)/(rho c^3) int F'^2 dt`` to first order, for a point force (Lamb 1904; Hunter 1957), with the wave speed
    ``c = sqrt(G'(omega)/rho)`` at the rate of the contact, omega = 1/T, where G'(1/T) is near G(T). The integral is
    ``4.685 F_max^2/T`` for a Hertz impact and 6 % more for a cone. It grows with the skewness of the force. The fit in
    y is within 7 % where e > 0.6, and up to 1.9 times low where e < 0.4 (`docs/theory/limits.md`).
    """
    speed, energy, body = (np.full(contact_time.shape, np.nan) for _ in range(3))
    with np.errstate(all="ignore"):
        rate = np.where(contact_time > 0.0, 1.0 / contact_time, 0.0)
        skew = np.minimum(skewness * skewness, _LARGEST_SKEWNESS**2)
        pulse = _PULSE * (1.0 + skew * (_SKEW[0] + skew * _SKEW[1])) * max_force**2 * rate
        single = is_single[kind]
        for place, bodies in enumerate(pairs):
            size = np.where(single, sizes[0], sizes[place])
            density = bodies.density[kind]
            if np.isnan(density).all():
                continue
            shear, bulk = (part.take(kind).storage_modulus(rate) for part in (bodies.shear, bodies.bulk))
            # No wave runs in a body that only flows.
            wave_speed = np.where(shear > 0.0, np.sqrt(shear / density), np.nan)
            nu = np.where(np.isinf(bulk), 0.5, (3.0 * bulk - 2.0 * shear) / (6.0 * bulk + 2.0 * shear))
            kept = 2.0 * size <= wave_speed * contact_time
            power = np.where(kept, 0.0, radiation(nu) / (density * wave_speed**3) * pulse)
            # The slower wave, where nothing leaves or nothing is known of it.
            radiates = (power > 0.0) | (energy > 0.0)
            more = np.isnan(speed) | np.where(radiates, power > energy, wave_speed < speed)
            speed, energy = np.where(more, wave_speed, speed), np.where(more, power, energy)
            body = np.where(more, np.where(single, 0.0, place), body)
    return Waves(speed, energy, body)


def radiation(poisson_ratio: ArrayLike) -> Array:
    """Return the factor beta of the power ``beta F'^2/(rho c^3)`` that a point force radiates into a half-space.

    Parameters
    ----------
    poisson_ratio : float or array
        Poisson ratio from -1 to 1/2.

    Returns
    -------
    array
        Lamb's integral over the waves in the body and the Rayleigh wave, to 1e-8; c is the shear wave speed.

    Examples
    --------
    >>> print(radiation(0.5).round(6))
    0.104424
    """
    values = np.polynomial.polynomial.polyval(np.sqrt(1.0 - 2.0 * np.asarray(poisson_ratio)), _RADIATION)
    return np.asarray(values, dtype=np.float64)
