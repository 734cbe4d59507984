"""Pyramid: sharp tips with three, four or six faces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from restitution.checks import Numeric
from restitution.contact.geometry import Array, Geometry, as_array, plain
from restitution.errors import InputError
from restitution.quantities import INPUTS


class _Constant(NamedTuple):
    """Factor c of the force, and its uncertainty."""

    value: float
    uncertainty: float


# Boundary elements on 64^2 to 512^2 cells, extrapolated; a cone has 2/pi.
_CONSTANTS = {3: _Constant(0.882413, 5e-6), 4: _Constant(0.737616, 3e-6), 6: _Constant(0.67330, 1e-5)}


@dataclass(frozen=True, eq=False)
class Pyramid(Geometry, case_name="pyramid"):
    """Regular pyramid with three, four or six faces.

    Parameters
    ----------
    face_angle : float or array
        Angle alpha [rad] from the axis to the middle of a face, in (0, pi/2). The angle to an edge is larger. A tip
        with four faces and "half opening angle 35 deg" of its faces has 35 deg.
    sides : int
        Number of faces: 3, 4 or 6.

    Attributes
    ----------
    constant, uncertainty : float
        Factor c of the force, and its uncertainty.

    Raises
    ------
    InputError
        If an angle is not in (0, pi/2), or the number of faces is another.

    Notes
    -----
    ``F = c tan(alpha) E* d^2`` with c = 0.882413(5) for three, 0.737616(3) for four and 0.67330(1) for six faces;
    a cone has 2/pi. The constants are from boundary elements on the half-space, extrapolated to fine meshes; the
    approximate 0.7453 of Bilodeau (1992) for four faces is 1.0 % above, 1/sqrt(2) of software for force microscopes
    4.1 % below. The stiffness radius is ``c tan(alpha) d``. Valid for small slopes cot(alpha) only, which the validity
    report compares: Berkovich (65.3 deg), Vickers (68 deg) and sharper tips are beyond them. The contact is no disc,
    and its radius and pressure are not known.

    Examples
    --------
    >>> import math
    >>> tip = Pyramid(face_angle=math.radians(80), sides=4)
    >>> print(tip.constant, tip.uncertainty, round(float(tip.stiffness_radius(1e-6)), 9))
    0.737616 3e-06 4.183e-06
    """

    obstacle = "the pressure under a pyramid is not known"

    face_angle: Annotated[Numeric, INPUTS["face_angle"]]
    sides: int = 4

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.sides, (int, np.integer)) or self.sides not in _CONSTANTS:
            raise InputError("sides", self.sides, "must be 3, 4 or 6")
        object.__setattr__(self, "sides", int(self.sides))

    @property
    def constant(self) -> float:
        """Factor c of the force."""
        return _CONSTANTS[self.sides].value

    @property
    def uncertainty(self) -> float:
        """Uncertainty of the factor c."""
        return _CONSTANTS[self.sides].uncertainty

    @property
    def slope(self) -> Numeric:
        """Slope cot(alpha) of the faces."""
        return plain(1.0 / np.tan(self.face_angle))

    def stiffness_radius(self, depth: ArrayLike) -> Array:
        """Stiffness radius c tan(alpha) d [m]."""
        return self.path_coefficient * np.maximum(as_array(depth), 0.0)

    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Force integral (c/2) tan(alpha) d^2 [m^2]."""
        return 0.5 * self.path_coefficient * np.maximum(as_array(depth), 0.0) ** 2

    def contact_radius(self, depth: ArrayLike) -> Array:
        """NaN: the contact radius is not known."""
        return np.full(np.broadcast(as_array(depth), self.face_angle).shape, np.nan)[()]

    @property
    def path_exponent(self) -> Numeric:
        """Exponent of a = c s^p: 2."""
        return 2.0

    @property
    def path_coefficient(self) -> Numeric:
        """Coefficient of a = c s^p: c tan(alpha) [-]."""
        return plain(self.constant * np.tan(self.face_angle))
