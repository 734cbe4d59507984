"""A rigid ball with friction on a half-space by the package, in units in which its mass, radius and velocity are 1."""

from __future__ import annotations

import warnings
from typing import Any

import restitution as rs


def smooth(material: Any) -> rs.Impact:
    """The ball without friction on a half-space of a material."""
    return rs.Impact(material, rs.Parabola(1.0), 1.0, 1.0)


def solved(problem: rs.Impact) -> Any:
    """The result of an impact whose numbers need not be those of a body; one that fails has NaN."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rs.RestitutionWarning)
        return rs.solve(problem, errors="warn")


def rough(problem: rs.Impact, friction: float, slope: float) -> Any:
    """The result with friction, whose contact point has the velocity v_c0 = slope mu v0."""
    return solved(rs.vary(problem, {"friction": friction, "tangential_velocity": slope * friction}))
