"""Exact interconversion of tension and shear on Prony series, by the secular equation."""

from __future__ import annotations

import math

import numpy as np

from restitution import quantities
from restitution.checks import finite, positive
from restitution.errors import InputError
from restitution.material.connection import series_connection
from restitution.material.models import exactly_one
from restitution.material.prony import PronySeries
from restitution.material.secular import secular_roots
from restitution.material.viscoelastic import bulk_factor


def shear_from_tension(
    tension: PronySeries, *, bulk_modulus: float | None = None, poisson_ratio: float | None = None
) -> PronySeries:
    """Relaxation modulus in shear G(t) [Pa] from that in tension E(t).

    With a constant bulk modulus the Carson transforms obey 1/(3G) = 1/E - 1/(9K), so G = 3KE/(9K - E): a
    Prony series, whose rates lambda are the roots of E(-lambda) = 9K, one above each rate of E, and whose
    moduli are 27 K^2/(lambda E'(-lambda)). Not the quotient 3KE(t)/(9K - E(t)) in time. With a constant
    Poisson ratio G = E/(2(1 + nu)).

    Parameters
    ----------
    tension
        E(t) [Pa].
    bulk_modulus
        Constant K [Pa], above a ninth of the instantaneous E; may be infinite. Exactly one of this and
        `poisson_ratio`.
    poisson_ratio
        Constant nu in (-1, 0.5] [-].

    Returns
    -------
    PronySeries
        G(t) [Pa], simplified.

    Raises
    ------
    ValueError
        If E leaves no room for a positive G, or if not exactly one of the two is given.

    Notes
    -----
    The elastic relation of the moduli, carried over by the correspondence principle.

    Examples
    --------
    >>> shear_from_tension(PronySeries(9.0, [27.0], [1.0]), bulk_modulus=5.0)
    PronySeries(3.75, [56.25], [0.25])
    """
    if _one_of(bulk_modulus, poisson_ratio):
        return tension.scaled(0.5 / (1.0 + _poisson_ratio(poisson_ratio))).simplified()
    bulk = _bulk_modulus(bulk_modulus)
    if math.isinf(bulk):
        return tension.scaled(1.0 / 3.0).simplified()
    own = tension.simplified()
    highest = own.instantaneous_modulus
    if not highest < 9.0 * bulk:
        wanted = f"must be > {highest / 9.0:g} Pa, a ninth of the instantaneous modulus in tension"
        raise InputError("bulk_modulus", bulk, wanted, "Pa")
    equilibrium = own.equilibrium_modulus
    roots = secular_roots(equilibrium - 9.0 * bulk, 0.0, own.branch_moduli[::-1], own.relaxation_times[::-1])
    moduli = 27.0 * bulk * (bulk / roots.slopes)
    return PronySeries(
        3.0 * bulk * equilibrium / (9.0 * bulk - equilibrium), moduli[::-1], roots.times[::-1]
    ).simplified()


def tension_from_shear(
    shear: PronySeries, *, bulk_modulus: PronySeries | float | None = None, poisson_ratio: float | None = None
) -> PronySeries:
    """Relaxation modulus in tension E(t) [Pa] from that in shear, 1/E = 1/(3G) + 1/(9K) in Carson transforms.

    Parameters
    ----------
    shear
        G(t) [Pa].
    bulk_modulus
        K [Pa]: constant, infinite or relaxing. Exactly one of this and `poisson_ratio`.
    poisson_ratio
        Constant nu in (-1, 0.5] [-], then E = 2(1 + nu) G.

    Returns
    -------
    PronySeries
        E(t) [Pa], simplified.

    Examples
    --------
    >>> tension_from_shear(PronySeries(3.75, [56.25], [0.25]), bulk_modulus=5.0)
    PronySeries(9.0, [27.0], [1.0])
    """
    if _one_of(bulk_modulus, poisson_ratio):
        return shear.scaled(2.0 * (1.0 + _poisson_ratio(poisson_ratio))).simplified()
    if isinstance(bulk_modulus, PronySeries):
        return series_connection(shear.scaled(3.0), bulk_modulus.scaled(9.0))
    bulk = _bulk_modulus(bulk_modulus)
    if math.isinf(bulk):
        return shear.scaled(3.0).simplified()
    return series_connection(shear.scaled(3.0), PronySeries(9.0 * bulk))


def shear_and_bulk(
    series: PronySeries, deformation: str, bulk_modulus: float | None, poisson_ratio: float | None
) -> tuple[PronySeries, PronySeries | float]:
    """Return the relaxation in shear and in bulk of a series measured in "tension" or "shear".

    The bulk modulus is constant, or follows the shear at a constant Poisson ratio.
    """
    exactly_one(bulk_modulus=bulk_modulus, poisson_ratio=poisson_ratio)
    shear = series
    if deformation == "tension":
        shear = shear_from_tension(series, bulk_modulus=bulk_modulus, poisson_ratio=poisson_ratio)
    if poisson_ratio is None:
        return shear, _bulk_modulus(bulk_modulus)
    factor = bulk_factor(float(quantities.check("poisson_ratio", poisson_ratio)))
    return shear, math.inf if math.isinf(factor) else shear.scaled(factor)


def _one_of(bulk_modulus: PronySeries | float | None, poisson_ratio: float | None) -> bool:
    """Whether it is the Poisson ratio that was given."""
    exactly_one(bulk_modulus=bulk_modulus, poisson_ratio=poisson_ratio)
    return poisson_ratio is not None


def _poisson_ratio(value: float | None) -> float:
    number = float(finite("poisson_ratio", value))
    if not -1.0 < number <= 0.5:
        raise InputError("poisson_ratio", number, "must be in (-1, 0.5]")
    return number


def _bulk_modulus(value: float | None) -> float:
    if isinstance(value, float) and np.isposinf(value):
        return value
    return float(positive("bulk_modulus", value, "Pa"))
