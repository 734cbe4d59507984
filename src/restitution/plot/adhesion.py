"""Pages of adhesive impacts."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from restitution.impact.problem import Impact
from restitution.plot import sticking, style
from restitution.quantities import ADHESION, ATTRACTION_TIME, HISTORY, INPUTS, OUTPUTS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from restitution.impact.adhesion import AdhesiveResult

# Velocities that span a decade have a logarithmic axis.
_DECADE = 10.0
_RADIUS = HISTORY["contact_radius"]._replace(words="radius", symbol="$r$")


def overview(result: AdhesiveResult) -> Figure:
    """Draw force over depth with its jumps, and depth and radii over time.

    Examples
    --------
    >>> import restitution as rs
    >>> polymer = rs.standard_solid(1e9, 1e9, 10.0, poisson_ratio=0.35, density=1200.0)
    >>> bead = rs.Impact(polymer, rs.Parabola(5e-6), mass=6.3e-13, velocity=1.0, adhesion=rs.Adhesion(0.05))
    >>> len(overview(rs.solve(bead, rtol=1e-4)).axes)
    3
    """
    history = result.history
    time = ATTRACTION_TIME, history["time"].values
    with style.page("AB;AC", height=4.4, title=f"e = {float(np.asarray(result.restitution_coefficient)):.4g}") as (
        page,
        panels,
    ):
        loop(panels[0], result)
        depth = HISTORY["indentation_depth"], history["indentation_depth"].values
        style.draw(panels[1], time, depth, color=style.BLUE)
        panels[1].axhline(0.0, color=style.GREY, linewidth=0.8)
        radii = {"in contact": ("contact_radius", style.BLUE), "attracted": ("zone_radius", style.VERMILION)}
        for label, (name, color) in radii.items():
            style.draw(panels[2], time, (_RADIUS, history[name].values), color=color, label=label)
        panels[2].legend(loc="upper right")
    return page


def loop(ax: Axes, result: AdhesiveResult, *, color: str = style.BLUE, label: str | None = None) -> Axes:
    """Draw the force over the depth; jumps are dotted."""
    history = result.history
    depth, force = history["indentation_depth"].values, history["force"].values
    across, up = style.axes_of(ax, (HISTORY["indentation_depth"], depth), (HISTORY["force"], force))
    # The first jump begins without a force.
    depth, force = np.append(depth[0], depth), np.append(0.0, force)
    time = np.append(0.0, history["time"].values)
    jumps = np.flatnonzero(np.diff(time) == 0.0) + 1
    ax.axhline(0.0, color=style.GREY, linewidth=0.8)
    for part in np.split(np.arange(time.size), jumps):
        ax.plot(across.factor * depth[part], up.factor * force[part], color=color, label=label)
        label = None
    for n in jumps:
        ends = slice(n - 1, n + 1)
        ax.plot(across.factor * depth[ends], up.factor * force[ends], ":", color=color)
    return style.labelled(ax, across.label, up.label)


def of_several(result: AdhesiveResult) -> Figure:
    """Draw the restitution coefficient and the largest pull over the velocity, with the threshold of sticking.

    The points of a list, and those where more than the velocity varies, have no line and no threshold.
    """
    impact, shape = result.impact, np.shape(result.status)
    velocity, e, pull = (
        np.broadcast_to(np.asarray(values, dtype=np.float64), shape).ravel()
        for values in (result.velocity, result.restitution_coefficient, result.pull_off_force)
    )
    order = np.argsort(velocity, kind="stable")
    velocity, e, pull = velocity[order], e[order], pull[order]
    # Members of a list may differ in everything.
    alone = isinstance(impact, Impact) and replace(impact, velocity=1.0).shape == ()
    wide = velocity[-1] >= _DECADE * velocity[0]
    across = INPUTS["velocity"], velocity
    look: dict[str, Any] = style.markers(velocity.size) if alone else {"linestyle": "", "marker": "o", "markersize": 3}
    with style.page("AB", height=3.0) as (page, panels):
        places, rows = sticking.broken(velocity, e, logarithmic=wide) if alone else (velocity, e[None])
        style.draw(
            panels[0], (across[0], places), (OUTPUTS["restitution_coefficient"], rows[0]), color=style.BLUE, **look
        )
        panels[0].set_ylim(-0.03, 1.03)
        style.draw(panels[1], across, (ADHESION["pull_off_force"], pull), color=style.BLUE, **look)
        for ax in panels if wide else ():
            ax.set_xscale("log")
        if alone:
            unit = style.axis(INPUTS["velocity"], places)
            sticking.draw_threshold(panels[0], unit.factor * velocity, e, unit.unit)
    return page
