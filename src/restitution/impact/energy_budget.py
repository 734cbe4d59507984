"""Energy budget of an impact."""

from __future__ import annotations

from typing import NamedTuple

from restitution.checks import Numeric


class EnergyBudget(NamedTuple):
    """Energy budget; the last four are NaN where the body does not separate, and with method "reference".

    Attributes
    ----------
    kinetic_in, kinetic_out : float or array
        Kinetic energy before and after the impact [J].
    dissipated : float or array
        Energy that the dashpots of the foundation dissipate in contact [J].
    stored : float or array
        Energy that the elements of the foundation still store when they leave contact [J].
    radiated : float or array
        Energy that a target with an impedance carries away [J].
    residual : float or array
        `(kinetic_out + dissipated + stored + radiated - kinetic_in - work of the external force)/kinetic_in` [-].
    """

    kinetic_in: Numeric
    kinetic_out: Numeric
    dissipated: Numeric
    stored: Numeric
    radiated: Numeric
    residual: Numeric
