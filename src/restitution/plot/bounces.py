"""Plots of a body that bounces: its height over time, restitution over velocity, the height of each bounce."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from restitution.plot import style
from restitution.plot.labels import scaled_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from restitution.impact.bounces import Bounces

_POINTS = 40


def flight(bounces: Bounces) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times [s] and heights [m] of the lowest point over the undeformed surface, from the release on.

    Between the flights, while the body touches, the height is NaN; a line through it has a gap there.

    Examples
    --------
    >>> import restitution as rs
    >>> rubber = rs.standard_solid(1e6, 1e6, 1e2, poisson_ratio=0.45, density=1200.0)
    >>> found = rs.bounces(rs.drop(rs.Body(rubber, radius=0.01), rs.Body(None), height=0.5), max_bounces=3)
    >>> time, height = flight(found)
    >>> print(height[0], bool(np.nanmin(height) < 0.0))
    0.5 True
    """
    g = bounces.gravity
    fall = np.linspace(0.0, bounces.touch_time[0], _POINTS)
    times, heights = [fall], [bounces.drop_height - 0.5 * g * fall**2]
    leaves = bounces.touch_time + bounces.contact_time
    ends = np.append(bounces.touch_time[1:], leaves[-1] + bounces.rebound_velocity[-1] / g)
    for start, end, speed, depth in zip(
        leaves, ends, bounces.rebound_velocity, bounces.residual_indentation_depth, strict=True
    ):
        if not np.isfinite(start):
            break
        since = np.linspace(0.0, end - start, _POINTS)
        times += [np.array([start]), start + since]
        heights += [np.array([np.nan]), speed * since - 0.5 * g * since**2 - depth]
    return np.concatenate(times), np.concatenate(heights)


def height_time(ax: Axes, bounces: Bounces) -> Axes:
    """Draw the height [m] over time [s]."""
    time, height = flight(bounces)
    across, up = scaled_unit(time, "s"), scaled_unit(bounces.drop_height, "m")
    ax.plot(time * across.factor, height * up.factor, color=style.BLUE)
    ax.axhline(0.0, color=style.GREY, linewidth=0.8)
    ax.set_xlim(0.0, None)
    return style.labelled(ax, f"time since the release [{across.unit}]", f"height [{up.unit}]")


def restitution_velocity(ax: Axes, bounces: Bounces) -> Axes:
    """Draw the restitution coefficient e of each bounce over its impact velocity [m/s]."""
    scale = scaled_unit(bounces.velocity, "m/s")
    velocity, e = bounces.velocity * scale.factor, bounces.restitution_coefficient
    ax.plot(velocity, e, "o", color=style.VERMILION, markersize=4)
    ax.set_xscale("log")
    ax.set_ylim(0.0, 1.0)
    return style.labelled(ax, f"impact velocity $v_0$ [{scale.unit}]", "restitution coefficient $e$")


def bounce_heights(ax: Axes, bounces: Bounces) -> Axes:
    """Draw the height [m] that each bounce reaches, where it rises out of its imprint."""
    from matplotlib.ticker import MaxNLocator

    number = np.arange(bounces.n_bounces + 1)
    heights = np.append(bounces.drop_height, bounces.height)
    scale = scaled_unit(heights, "m")
    rises = heights > 0.0
    ax.plot(number[rises], heights[rises] * scale.factor, "o", color=style.GREEN, markersize=4)
    ax.set_yscale("log")
    ax.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    ax.set_xlim(-0.5, bounces.n_bounces + 0.5)
    return style.labelled(ax, "bounce (0: the release)", f"height reached [{scale.unit}]")


def overview(bounces: Bounces) -> Figure:
    """Draw the height over time, the restitution coefficients and the heights of the result of `restitution.bounces`."""
    with style.context():
        page = style.new_figure(style.PAGE_WIDTH, 5.0)
        grid: Any = page.add_gridspec(2, 2)
        panels: list[Any] = [page.add_subplot(grid[0, :]), *(page.add_subplot(grid[1, n]) for n in (0, 1))]
        for draw, panel in zip((height_time, restitution_velocity, bounce_heights), panels, strict=True):
            draw(panel, bounces)
        style.panel_letters(panels)
        count = f"{bounces.n_bounces} bounce{'s' * (bounces.n_bounces != 1)}"
        return style.finish(page, f"{count}; {bounces.ended}: {bounces.ended.message}")
