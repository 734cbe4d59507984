"""The section in which the page draws a contact: the body, and the surface under it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, cast

import numpy as np

from restitution.contact.ellipsoid import Ellipsoid
from restitution.contact.geometry import Array
from restitution.contact.power_law import Cone
from restitution.contact.profile import Parabola, Profile
from restitution.contact.pyramid import Pyramid
from restitution.impact.result import ImpactResult

# Points of the body and of the surface, and flat punches that compose the surface around an ellipse.
_BODY, _SURFACE, _PUNCHES = 61, 25, 200


def body(result: ImpactResult) -> dict[str, Any] | None:
    """Return the lower surface of the body along the long semi-axis, and this over the contact radius if known."""
    own: Any = cast("Any", result.impact).profile
    profile, semi_axis, most = own, 1.0, float(result.max_contact_radius)
    if isinstance(own, Ellipsoid):
        profile, semi_axis = Parabola(max(own.radius_1, own.radius_2)), float(own.semi_axes(1.0)[0])
        most *= semi_axis
    elif isinstance(own, Pyramid):
        # Across two faces: at a right angle to both, or, of three faces, at 60 deg.
        slope = own.slope * (math.sin(math.pi / 3.0) if own.sides == 3 else 1.0)
        profile, semi_axis, most = Cone(math.atan(1.0 / slope)), None, float(result.max_indentation_depth) / slope
    if not isinstance(profile, Profile):
        return None
    radius = np.linspace(0.0, 3.0 * most if 0.0 < most < math.inf else 1.0, _BODY)
    with np.errstate(all="ignore"):
        return {"radius": radius, "height": np.asarray(profile.shape(radius)), "semi_axis": semi_axis}


def surface(result: ImpactResult) -> tuple[Array, Callable[[float], Array]] | None:
    """Return distances [m] from the axis and the displacement of the surface [m] there over the time [s]."""
    own, found = cast("Any", result.impact).profile, body(result)
    if found is None or found["semi_axis"] is None:
        return None
    radius = np.linspace(0.0, found["radius"][-1], _SURFACE)
    if isinstance(own, Profile):
        return radius, lambda t: result.surface_displacement(radius, t)
    from scipy.special import elliprf

    # The depths u(x) of the foundation are those of nested flat punches. A punch with the semi-axes a and k a moves
    # the surface at p a on its long axis by R_F(p^2 - 1, p^2, p^2 - 1 + k^2)/R_F(0, 1, k^2) of its own depth.
    ends = np.linspace(0.0, float(own.stiffness_radius(result.max_indentation_depth)), _PUNCHES + 1)
    axis = own.semi_axes(own.contact_radius(1.0) / own.stiffness_radius(1.0))[0] * 0.5 * (ends[1:] + ends[:-1])
    p, k = np.maximum(radius[:, None] / axis, 1.0) ** 2, own.axis_ratio**2
    share = elliprf(p - 1.0, p, p - 1.0 + k) / elliprf(0.0, 1.0, k)

    def displacement(t: float) -> Array:
        line = cast("Any", result)._fields.line_displacement(t)
        return np.zeros(_SURFACE) if line is None else share @ -np.diff(np.append(line(ends[:-1]), 0.0))

    return radius, displacement
