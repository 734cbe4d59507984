"""What the theory assumes, checked on a result: small strain, quasi-static motion, a body like a half-space.

Each check takes plain numbers or arrays, looks at the worst of them, and returns its warnings with the
numbers in them, none where the assumption holds.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

# Representative strain 0.2 a/R = 4 % (Tabor, The Hardness of Metals, 1951); an exact sphere is there 0.4 %
# softer than its parabola, by geometry alone.
STRAIN_LIMIT = 0.2
# Share of the energy that goes into elastic waves 1.04 (v/c)^(3/5) = 7 %, or 3 % of e (Hunter 1957).
SPEED_LIMIT = 0.01
# A bonded incompressible layer of thickness h is then 6 % stiffer than a half-space: 1 + 1.133 a/h + 1.283
# (a/h)^2 (Dimitriadis et al. 2002).
SIZE_LIMIT = 0.05


def small_strain(
    max_contact_radius: ArrayLike, max_depth: ArrayLike, radius: ArrayLike | None = None
) -> list[str]:
    """Warnings about large strain, measured by depth over contact radius (a/R for a parabola).

    Parameters
    ----------
    max_contact_radius : float or array
        Largest contact radius a [m].
    max_depth : float or array
        Largest indentation depth d [m]; d/a is a/R for a parabola, (pi/2) cot(alpha) for a cone, and is
        defined for a flat punch too.
    radius : float or array, optional
        Radius R [m] of a round body, then named in the message with a/R.

    Returns
    -------
    list of str
        One warning if the ratio exceeds `STRAIN_LIMIT` = 0.2, or if a/R does.

    Examples
    --------
    >>> small_strain(max_contact_radius=1e-3, max_depth=1e-4, radius=0.01)
    []
    >>> small_strain(max_contact_radius=4e-3, max_depth=1.6e-3, radius=0.01)[0]
    'small strain: contact radius over R reaches 0.4 (> 0.2), representative strain about 8 %'
    """
    name, ratio = "depth over contact radius", _worst(max_depth, max_contact_radius)
    if radius is not None:
        name, ratio = "contact radius over R", _worst(max_contact_radius, radius)
    if ratio <= STRAIN_LIMIT:
        return []
    return [
        f"small strain: {name} reaches {ratio:.3g} (> {STRAIN_LIMIT:g}), "
        f"representative strain about {20 * ratio:.2g} %"
    ]


def quasi_static(velocity: ArrayLike, wave_speed: ArrayLike) -> list[str]:
    """Warnings about waves, measured by impact velocity over the slowest wave speed.

    Parameters
    ----------
    velocity : float or array
        Impact velocity v0 [m/s].
    wave_speed : float or array
        Slowest wave speed c [m/s] of the material: sqrt(G/rho) at its equilibrium shear modulus.

    Returns
    -------
    list of str
        One warning if v0/c exceeds `SPEED_LIMIT` = 0.01; the share of the energy that waves carry away
        is then about 1.04 (v0/c)^(3/5) (Hunter 1957, an elastic half-space).

    Examples
    --------
    >>> quasi_static(velocity=1.0, wave_speed=1000.0)
    []
    >>> quasi_static(velocity=1.0, wave_speed=20.0)[0]
    'quasi-static: velocity over wave speed is 0.05 (> 0.01), waves may carry off some 17 % of the energy'
    """
    ratio = _worst(velocity, wave_speed)
    if ratio <= SPEED_LIMIT:
        return []
    # Hunter's estimate is one for small ratios; half of the energy is as much as it can say.
    share = f"some {100 * 1.04 * ratio**0.6:.2g} %" if ratio < 0.3 else "more than half"
    return [
        f"quasi-static: velocity over wave speed is {ratio:.3g} (> {SPEED_LIMIT:g}), "
        f"waves may carry off {share} of the energy"
    ]


def half_space(max_contact_radius: ArrayLike, body_size: ArrayLike) -> list[str]:
    """Warnings about a finite body, measured by contact radius over its smallest dimension.

    Parameters
    ----------
    max_contact_radius : float or array
        Largest contact radius a [m].
    body_size : float or array
        Smallest dimension h [m] of the deforming body: thickness of a layer, radius of a ball.

    Returns
    -------
    list of str
        One warning if a/h exceeds `SIZE_LIMIT` = 0.05.

    Examples
    --------
    >>> half_space(max_contact_radius=1e-3, body_size=1e-2)[0]
    'half-space: contact radius over body size is 0.1 (> 0.05), a bonded layer would be some 13 % stiffer'
    """
    ratio = _worst(max_contact_radius, body_size)
    if ratio <= SIZE_LIMIT:
        return []
    # The series of Dimitriadis et al. ends at a/h of about 1.
    excess = 100.0 * (1.133 * ratio + 1.283 * ratio**2 + 0.769 * ratio**3 + 0.0975 * ratio**4)
    stiffer = f"some {excess:.2g} %" if ratio < 1.0 else "several times"
    return [
        f"half-space: contact radius over body size is {ratio:.3g} (> {SIZE_LIMIT:g}), "
        f"a bonded layer would be {stiffer} stiffer"
    ]


def _worst(numerator: ArrayLike, denominator: ArrayLike) -> float:
    ratio = np.asarray(numerator, dtype=np.float64) / np.asarray(denominator, dtype=np.float64)
    return float(np.max(ratio, initial=0.0))
