"""Reduced relaxation modulus E*(t): all that a contact sees of a material or of a pair."""

from __future__ import annotations

from restitution.material.connection import NOTHING, connect, on_common_times, series_connection
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material


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
        Material of the other body; None if that one is rigid.

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
    # Where 4G + 4K + 4G/3 = 0, 4G equals -3K too, which is exact where G itself cancels.
    third = NOTHING.plus(k, 3.0)
    return connect(times, first, second, third)
