"""Pages of oblique impacts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from restitution.checks import Array
from restitution.impact.oblique import contact_point
from restitution.plot import style
from restitution.quantities import HISTORY, INPUTS, NUMBER, OBLIQUE, Quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from restitution.impact.oblique import ObliqueResult

_FORCE = HISTORY["tangential_force"]._replace(words="force", symbol=r"$F$")
_RADIUS = HISTORY["contact_radius"]._replace(words="radius", symbol="$r$")
_VELOCITY = HISTORY["contact_point_velocity"]._replace(words="velocity", symbol="$v$")
_SLOPE = Quantity("slope", NUMBER, "velocity of the contact point over", r"$\mu v_0$")
_DEGREES = 180.0 / np.pi


def overview(result: ObliqueResult, *, title: str = "") -> Figure:
    """Draw the tangential force within the limits of friction, the radii in contact and stuck, and the velocities.

    Examples
    --------
    >>> import restitution as rs
    >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
    >>> ball = rs.Impact(rubber, rs.Parabola(0.01), mass=0.005, velocity=1.0, friction=0.3, angle=0.5)
    >>> len(overview(rs.solve(ball)).axes)
    3
    """
    history = result.history
    time = HISTORY["time"], history["time"].values
    impact = _array(result)
    angle = _DEGREES * float(np.arctan2(impact.tangential_velocity, impact.velocity))
    after, e_t = _DEGREES * float(result.rebound_angle), float(result.tangential_restitution_coefficient)
    numbers = f"{angle:.3g}° to {after:.3g}° from the normal, $e_t$ = {e_t:.4g}"
    title = f"{title}\n{numbers}" if title else numbers
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
        panels[2].legend(loc="best")
    return page


def forces(ax: Axes, result: ObliqueResult) -> Axes:
    """Draw the tangential force over time, between the limits +-mu F where friction is finite."""
    history, friction = result.history, float(_array(result).friction or 0.0)
    time = HISTORY["time"], history["time"].values
    limit = friction * history["force"].values if np.isfinite(friction) else np.full(time[1].size, np.nan)
    both = np.stack([history["tangential_force"].values, limit, -limit])
    across, up = style.axes_of(ax, time, (_FORCE, both))
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
    impacts = result.impact if isinstance(result.impact, list) else [result.impact]
    names = "friction", "tangential_velocity", "velocity"
    friction, along, normal = (_column([np.asarray(getattr(each, name)) for each in impacts], shape) for name in names)
    point = _column([np.asarray(contact_point(each)[0]) for each in impacts], shape)
    e_t = np.asarray(result.tangential_restitution_coefficient, dtype=np.float64).ravel()
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.abs(point) / (friction * normal)
    finite = np.isfinite(slope) & np.isfinite(e_t)
    before, after = np.arctan2(along, normal), np.asarray(result.rebound_angle, dtype=np.float64).ravel()
    look: dict[str, Any] = {"color": style.BLUE, "markersize": 3}
    with style.page("AB", height=3.0) as (page, panels):
        tangential = OBLIQUE["tangential_restitution_coefficient"], e_t[finite]
        style.draw(panels[0], (_SLOPE, slope[finite]), tangential, "o", **look)
        panels[0].set_ylim(-1.05, 1.05)
        style.draw(panels[1], (INPUTS["angle"], before), (OBLIQUE["rebound_angle"], after), "o", **look)
    return page


def _array(result: ObliqueResult) -> Any:
    """Return the impact of a result of a single impact."""
    return result.impact


def _column(values: list[Array], shape: tuple[int, ...]) -> Array:
    """Return numbers of each impact of an array or a list."""
    return np.broadcast_to(values[0] if len(values) == 1 else np.stack(values), shape).ravel()
