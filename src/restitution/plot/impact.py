"""One impact on a page, and its contact pressure over the radius."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from restitution.errors import InputError
from restitution.plot import style
from restitution.plot.history import (
    contact_radius_time,
    depth_time,
    energy_area,
    energy_bar,
    force_indentation,
    force_time,
)
from restitution.plot.labels import scaled_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from restitution.impact.result import ImpactResult

_POINTS = 241
# Pressures are unbounded at the edge of a flat face and under the tip of a cone; so close to either, they do not set
# the scale.
_RIM = 0.03
# Where an edge carries a load, the pressure beyond this share of the radius is infinite, or zero by rounding.
_LAST = 1.0 - 1e-6
_COLORS = (style.SKY_BLUE, style.BLUE, style.VERMILION, style.ORANGE, style.GREEN, style.PURPLE, style.BLACK)


def overview(
    result: ImpactResult, times: ArrayLike | None = None, *, title: str = "", figure: Figure | None = None
) -> Figure:
    """Draw one impact on a page: force, loop, depth, contact radius, pressure at some instants, energies.

    Only the exact method has the pressure and the energies over time. A bar shows the final energies of the element
    method.

    Parameters
    ----------
    result : ImpactResult
        The result of one impact, not of an array of them.
    times : array_like, optional
        Times [s] at which to show the pressure, at most seven; four where left out.
    title : str
        A line above the restitution coefficient and the contact time.
    figure : matplotlib.figure.Figure, optional
        An empty figure to draw into, e.g. `matplotlib.pyplot.figure()`; a new one if left out.

    Returns
    -------
    matplotlib.figure.Figure
        A notebook shows it; `figure.savefig(...)` writes it.
    """
    history = result.history
    exact = result.method == "exact"
    budget = not exact and isfinite(result.energy.dissipated)
    heights = [1.0, 1.0, *([1.0] if exact else [0.62] if budget else [])]
    with style.context():
        page = style.new_figure(style.PAGE_WIDTH, 0.3 + 2.4 * sum(heights)) if figure is None else figure
        grid: Any = page.add_gridspec(len(heights), 2, height_ratios=heights)
        panels: list[Any] = [page.add_subplot(grid[row, column]) for row in (0, 1) for column in (0, 1)]
        force_time(panels[0], history)
        force_indentation(panels[1], history)
        depth_time(panels[2], history)
        contact_radius_time(panels[3], history)
        if exact:
            panels += [page.add_subplot(grid[2, column]) for column in (0, 1)]
            pressure_radius(panels[4], result, times)
            energy_area(panels[5], history)
        elif budget:
            panels.append(page.add_subplot(grid[2, :]))
            energy_bar(panels[4], result.energy)
        style.panel_letters(panels)
        duration = scaled_unit(result.contact_time, "s")
        numbers = (
            rf"$e = {float(result.restitution_coefficient):.4g}$,  "
            rf"contact time {float(result.contact_time) * duration.factor:.4g} {duration.unit}"
        )
        return style.finish(page, f"{title}\n{numbers}" if title else numbers)


def turning_time(result: ImpactResult) -> float:
    """Time [s] of the greatest depth, to about a thousandth."""
    history = result.history
    return float(np.interp(0.0, -history["indentation_velocity"].values, history["time"].values))


def instants(result: ImpactResult) -> np.ndarray[Any, Any]:
    """Four instants [s] that show a contact: half way in, deepest, a third and two thirds of the way out."""
    turning = turning_time(result)
    out = float(result.contact_time) - turning
    return np.array([0.5 * turning, turning, turning + out / 3.0, turning + 2.0 * out / 3.0])


def pressure_radius(ax: Axes, result: ImpactResult, times: ArrayLike | None = None) -> Axes:
    """Draw the contact pressure p [Pa] over the radius r [m] at some times; dashed after the turning point.

    The result is that of one impact, solved by the exact method. The times [s], at most seven, lie within the contact;
    `instants` chooses them where left out.

    Examples
    --------
    >>> import restitution as rs
    >>> from restitution.plot.style import new_figure
    >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
    >>> result = rs.solve(rs.Impact(rubber, rs.Parabola(radius=0.01), mass=0.005, velocity=0.1))
    >>> ax = pressure_radius(new_figure().add_subplot(), result)
    >>> len(ax.lines), ax.get_xlabel()
    (4, 'radius $r$ [µm]')
    """
    moments = np.atleast_1d(np.asarray(instants(result) if times is None else times, dtype=np.float64))
    if moments.size > len(_COLORS):
        raise InputError("times", moments.size, f"must be at most {len(_COLORS)} times, to keep the curves distinct")
    if not np.all((moments > 0.0) & (moments < float(result.contact_time))):
        bad = moments[~((moments > 0.0) & (moments < float(result.contact_time)))][0]
        lasts = float(result.contact_time)
        raise InputError("times", float(bad), f"must be within the contact, which lasts {lasts:g} s", "s")
    extents = np.asarray(result.sample(moments)["contact_radius"].values)
    turning = turning_time(result)
    # Close to the edge, where the pressure falls or rises fast, the points are dense.
    share = _LAST * np.sin(np.linspace(0.0, 0.5 * np.pi, _POINTS))
    inner = (share >= _RIM) & (share <= 1.0 - _RIM)
    curves = [np.asarray(result.pressure(share * a, t)) for a, t in zip(extents, moments, strict=True)]
    top = max(float(curve[inner].max()) for curve in curves)
    across, up = scaled_unit(extents, "m"), scaled_unit(top, "Pa")
    clock = scaled_unit(moments, "s")
    for a, t, curve, color in zip(extents, moments, curves, _COLORS, strict=False):
        ax.plot(
            share * a * across.factor,
            np.where(np.isfinite(curve), curve, np.nan) * up.factor,
            color=color,
            linestyle="--" if t > 1.002 * turning else "-",
            label=f"{t * clock.factor:.3g} {clock.unit}",
        )
    finite = max(float(curve[np.isfinite(curve)].max()) for curve in curves)
    ax.set_ylim(0.0, 1.05 * min(finite, 1.1 * top) * up.factor)
    # Beyond the contact there is room for the legend.
    ax.set_xlim(0.0, 1.45 * float(extents.max()) * across.factor)
    ax.legend(title="$t$", loc="upper right")
    return style.labelled(ax, f"radius $r$ [{across.unit}]", f"pressure $p$ [{up.unit}]")
