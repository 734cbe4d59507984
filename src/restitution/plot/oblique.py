"""Pages of oblique impacts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from restitution.plot import style
from restitution.quantities import NUMBER, OBLIQUE, OBLIQUE_HISTORY, OBLIQUE_INPUTS, Quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from restitution.impact.oblique import ObliqueResult

_FORCE = OBLIQUE_HISTORY["tangential_force"]._replace(words="force", symbol=r"$F$")
_RADIUS = OBLIQUE_HISTORY["contact_radius"]._replace(words="radius", symbol="$r$")
_VELOCITY = OBLIQUE_HISTORY["contact_point_velocity"]._replace(words="velocity", symbol="$v$")
_SLOPE = Quantity("slope", NUMBER, "velocity of the contact point over", r"$\mu v_0$")
_DEGREES = 180.0 / np.pi


def overview(result: ObliqueResult) -> Figure:
    """Draw the tangential force within the limits of friction, the radii in contact and stuck, and the velocities.

    Examples
    --------
    >>> import restitution as rs
    >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
    >>> ball = rs.Impact(rubber, rs.Parabola(0.01), mass=0.005, velocity=1.0)
    >>> len(overview(rs.oblique(ball, friction=0.3, angle=0.5)).axes)
    3
    """
    history = result.history
    time = OBLIQUE_HISTORY["time"], history["time"].values
    angle, after = (_DEGREES * float(np.arctan2(along, up)) for along, up in (
        (float(result.tangential_velocity), float(result.normal.velocity)),
        (float(result.rebound_tangential_velocity), float(result.rebound_velocity)),
    ))  # fmt: skip
    title = (
        f"{angle:.3g}° to {after:.3g}° from the normal, e_t = {float(result.tangential_restitution_coefficient):.4g}"
    )
    with style.page("AB;CC", height=5.4, title=title) as (page, panels):
        forces(panels[0], result)
        radii = {"in contact": ("contact_radius", style.BLUE), "sticks": ("stick_radius", style.VERMILION)}
        for label, (name, color) in radii.items():
            style.draw(panels[1], time, (_RADIUS, history[name].values), color=color, label=label)
        panels[1].legend(loc="upper right")
        velocities = {
            "contact point": ("contact_point_velocity", style.BLUE), "slip at most": ("slip_velocity", style.VERMILION)
        }  # fmt: skip
        for label, (name, color) in velocities.items():
            style.draw(panels[2], time, (_VELOCITY, history[name].values), color=color, label=label)
        panels[2].axhline(0.0, color=style.GREY, linewidth=0.8)
        panels[2].legend(loc="upper right")
    return page


def forces(ax: Axes, result: ObliqueResult) -> Axes:
    """Draw the tangential force over time, between the limits +-mu F where friction is finite."""
    history, friction = result.history, float(result.friction)
    time = OBLIQUE_HISTORY["time"], history["time"].values
    limit = friction * history["force"].values if np.isfinite(friction) else np.full(time[1].size, np.nan)
    both = np.stack([history["tangential_force"].values, limit, -limit])
    up = style.axis(_FORCE, np.where(np.isfinite(both), both, 0.0))
    across = style.axis(*time)
    for values, look in zip(both, ("-", "--", "--"), strict=True):
        color = style.BLUE if look == "-" else style.GREY
        ax.plot(across.factor * time[1], up.factor * values, look, color=color)
    ax.lines[0].set_label("tangential")
    if np.isfinite(friction):
        ax.lines[1].set_label(r"$\pm\mu F_z$")
    ax.legend(loc="upper right")
    return style.labelled(ax, across.label, up.label)


def of_several(result: ObliqueResult) -> Figure:
    """Draw e_t over the velocity of the contact point over mu v0, and the angle of the rebound over that before."""
    shape = np.shape(result.status)
    flat = {
        name: np.broadcast_to(np.asarray(values, dtype=np.float64), shape).ravel()
        for name, values in {
            "e_t": result.tangential_restitution_coefficient, "friction": result.friction,
            "along": result.tangential_velocity, "spin": result.spin, "after": result.rebound_angle,
            "normal": result.impact.velocity, "radius": result.impact.profile.ball_radius,
        }.items()
    }  # fmt: skip
    turning = np.where(flat["spin"] == 0.0, 0.0, flat["spin"] * flat["radius"])
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.abs(flat["along"] + turning) / (flat["friction"] * flat["normal"])
    known = np.isfinite(slope) & np.isfinite(flat["e_t"])
    angle = OBLIQUE_INPUTS["angle"], np.arctan2(flat["along"], flat["normal"])
    with style.page("AB", height=3.0) as (page, panels):
        e_t = OBLIQUE["tangential_restitution_coefficient"], flat["e_t"][known]
        style.draw(panels[0], (_SLOPE, slope[known]), e_t, "o", color=style.BLUE, markersize=3)
        panels[0].set_ylim(-1.05, 1.05)
        style.draw(panels[1], angle, (OBLIQUE["rebound_angle"], flat["after"]), "o", color=style.BLUE, markersize=3)
    return page
