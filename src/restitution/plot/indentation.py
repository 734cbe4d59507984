"""Plots of a prescribed indentation: depth, force and contact radius over time, force over depth."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from restitution.indentation.result import IndentationStatus
from restitution.plot import style
from restitution.plot.history import contact_radius_time, depth_time, force_indentation, force_time
from restitution.plot.labels import scaled_unit
from restitution.quantities import HISTORY

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from restitution.indentation.result import IndentationResult


def curve(result: IndentationResult) -> xr.Dataset:
    """History of an indentation for drawing: dense, with the limits from both sides at each kink and jump.

    Examples
    --------
    A step of the force is a vertical line, and so has two depths:

    >>> import restitution as rs
    >>> gel = rs.Material(rs.PronySeries(200.0, [800.0], [0.3]), bulk=float("inf"))
    >>> history = curve(rs.indent(gel, rs.Parabola(2.5e-6), force=[0, 1e-9, 1e-9, 0], time=[0, 1, 2, 2.5]))
    >>> print(history.sizes["time"] > 400, float(history.force.max()))
    True 1e-09
    """
    import xarray as xr

    knots = np.unique(result.history_given.knots)
    # Sorting keeps the order of points at the same time.
    return xr.concat([result.sample(knots, before=True), result.sample()], "time").sortby("time")


def overview(result: IndentationResult, *, figure: Figure | None = None) -> Figure:
    """Draw depth, force and contact radius over time and force over depth, into a new or a given empty figure."""
    history = curve(result)
    with style.context():
        page = style.new_figure(style.PAGE_WIDTH, 5.0) if figure is None else figure
        grid: Any = page.add_gridspec(2, 2)
        panels: list[Any] = [page.add_subplot(grid[row, column]) for row in (0, 1) for column in (0, 1)]
        depth_time(panels[0], history)
        force_time(panels[1], history)
        contact_radius_time(panels[2], history)
        _loop(panels[3], history, result)
        for panel in panels[:3]:
            _mark_end(panel, history, result)
            # A prescribed history may begin before the touch.
            panel.set_xlabel(panel.get_xlabel().replace(HISTORY["time"].words, "time"))
        style.panel_letters(panels)
        return style.finish(page, _title(result))


def _loop(ax: Axes, history: xr.Dataset, result: IndentationResult) -> None:
    """Draw force over depth, with its area where that is the work: the contact ends, and the history has no step."""
    force_indentation(ax, history)
    steps = np.any(np.diff(result.history_given.knots) == 0.0)
    if result.status != IndentationStatus.SEPARATED or steps:
        for area in list(ax.patches):
            area.remove()


def _mark_end(ax: Axes, history: xr.Dataset, result: IndentationResult) -> None:
    if math.isfinite(result.contact_end_time):
        scale = scaled_unit(np.asarray(history.time), "s").factor
        ax.axvline(result.contact_end_time * scale, color=style.GREY, linewidth=0.8, linestyle="--")


def _title(result: IndentationResult) -> str:
    force, depth = scaled_unit(result.max_force, "N"), scaled_unit(result.max_indentation_depth, "m")
    words = [
        f"prescribed {result.prescribed}",
        f"largest force {result.max_force * force.factor:.4g} {force.unit}",
        f"largest depth {result.max_indentation_depth * depth.factor:.4g} {depth.unit}",
    ]
    if math.isfinite(result.contact_end_time):
        end = scaled_unit(result.contact_end_time, "s")
        words.append(f"contact ends at {result.contact_end_time * end.factor:.4g} {end.unit} (dashed)")
    return ", ".join(words)
