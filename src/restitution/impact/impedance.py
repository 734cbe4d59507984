"""Mechanical impedance of targets that recede under an impact: a thin plate, and a long rod."""

from __future__ import annotations

from typing import Any

import numpy as np

from restitution.checks import Numeric, positive
from restitution.errors import InputError, InputTypeError
from restitution.material.viscoelastic import Material
from restitution.quantities import check


def plate_impedance(material: Material, thickness: Any) -> Numeric:
    r"""Return the impedance of a thin plate of infinite extent.

    Parameters
    ----------
    material : Material
        Material of the plate, with a density rho. Its instantaneous moduli count; they must be finite.
    thickness : float or array
        Thickness h [m], > 0.

    Returns
    -------
    float or array
        :math:`Z = 8 \sqrt{D \rho h}` [kg/s] with the bending stiffness :math:`D = E h^3/(12 (1 - \nu^2))`.

    Raises
    ------
    InputError
        If the material has no density or no finite instantaneous modulus, or a thickness is not above zero.

    Notes
    -----
    Under a normal force F the plate recedes with the velocity F/Z (Zener 1941). This holds while no flexural wave has
    come back from an edge, for a contact radius well below h, and for a contact that lasts much longer than a wave
    takes to cross the thickness.

    Examples
    --------
    A pane of glass of 4 mm:

    >>> import restitution as rs
    >>> glass = rs.elastic(youngs_modulus=70e9, poisson_ratio=0.22, density=2500.0)
    >>> print(round(rs.plate_impedance(glass, 4e-3), 1))
    501.1
    """
    shear, nu, density = _constants(material)
    # Z = 8 h^2 sqrt(E rho/(12 (1 - nu^2))) with E = 2 G (1 + nu), which are both 0 where nu is -1.
    size = np.asarray(check("thickness", thickness))
    with np.errstate(over="ignore", under="ignore"):
        impedance = 8.0 * (density * shear / (6.0 * (1.0 - nu))) ** 0.5 * size**2
    return check("impedance", impedance)


def rod_impedance(material: Material, area: Any) -> Numeric:
    r"""Return the impedance of a long thin rod that is hit on its end.

    Parameters
    ----------
    material : Material
        Material of the rod, with a density rho. Its instantaneous moduli count; they must be finite.
    area : float or array
        Area A of the cross-section [m2], > 0.

    Returns
    -------
    float or array
        :math:`Z = \rho c A` [kg/s] with the speed :math:`c = \sqrt{E/\rho}` of a wave in a thin rod.

    Raises
    ------
    InputError
        As `plate_impedance`.

    Notes
    -----
    The end recedes with the velocity F/Z until a wave has come back from the other end. The indentation counts as
    that of a half-space, which needs a contact radius well below that of the rod.

    Examples
    --------
    >>> import restitution as rs
    >>> steel = rs.elastic(youngs_modulus=210e9, poisson_ratio=0.3, density=7800.0)
    >>> print(round(rs.rod_impedance(steel, 1e-4), 1))
    4047.2
    """
    shear, nu, density = _constants(material)
    if np.any(np.asarray(nu) == -1.0):
        raise InputError("material", rule="must have a bulk modulus: without one Young's modulus is 0")
    return (density * 2.0 * shear * (1.0 + nu)) ** 0.5 * positive("area", area, "m^2")


def _constants(material: Any) -> tuple[Any, Any, Any]:
    """Return the instantaneous shear modulus [Pa] and Poisson ratio, and the density [kg/m^3] of a material."""
    if not isinstance(material, Material):
        raise InputTypeError("material", material, "must be a Material")
    if material.density is None:
        raise InputError("material.density", rule="must be given: the inertia of the target resists the impact")
    shear = material.shear.instantaneous_modulus
    if not np.all(np.isfinite(shear)):
        raise InputError(
            "material.shear", float(np.max(shear)), "must have a finite instantaneous modulus, no parallel dashpot"
        )
    return shear, material.instantaneous_poisson_ratio, material.density
