"""Plots of one impact: force, depth and contact radius over time, the force-indentation loop, the energy."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from restitution.plot import style
from restitution.plot.labels import quantity_label, scaled_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from restitution.impact.result import EnergyBudget, ImpactResult

_UNITS = {
    "time": "s",
    "indentation_depth": "m",
    "velocity": "m/s",
    "force": "N",
    "contact_radius": "m",
}


def _draw(ax: Axes, history: xr.Dataset, across: str, up: str, color: str) -> Axes:
    values: list[Any] = []
    labels: list[str] = []
    for name in (across, up):
        if name not in history.variables:
            raise ValueError(f"history has no variable '{name}': must have {', '.join(_UNITS)}")
        column = np.asarray(history[name].values, dtype=np.float64)
        if column.ndim != 1:
            raise ValueError(f"history variable '{name}' has shape {column.shape}: must be over time alone")
        scale = scaled_unit(column, _UNITS[name])
        values.append(column * scale.factor)
        labels.append(quantity_label(name, scale.unit))
    ax.plot(values[0], values[1], color=color)
    ax.set_xlabel(labels[0])
    ax.set_ylabel(labels[1])
    ax.grid(True)
    return ax


def force_time(ax: Axes, history: xr.Dataset, *, color: str = style.BLUE) -> Axes:
    """Draw the contact force F [N] over time t [s].

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    history : xarray.Dataset
        `ImpactResult.history` of one impact, in SI.
    color : str
        The line's colour.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`.

    Examples
    --------
    >>> import xarray as xr
    >>> from restitution.plot.style import new_figure
    >>> history = xr.Dataset({"force": ("time", [0.0, 2.0, 0.0])}, {"time": [0.0, 1e-3, 2e-3]})
    >>> ax = force_time(new_figure().add_subplot(), history)
    >>> ax.get_xlabel(), ax.get_ylabel()
    ('time $t$ [ms]', 'force $F$ [N]')
    """
    return _draw(ax, history, "time", "force", color)


def force_indentation(ax: Axes, history: xr.Dataset, *, color: str = style.BLUE) -> Axes:
    """Draw the force F [N] over the indentation depth d [m]: the loop whose area is the energy lost.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    history : xarray.Dataset
        `ImpactResult.history` of one impact, in SI.
    color : str
        The line's colour.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`.

    Examples
    --------
    >>> import xarray as xr
    >>> from restitution.plot.style import new_figure
    >>> history = xr.Dataset({name: ("time", [0.0, 2e-3, 0.0]) for name in ("force", "indentation_depth")})
    >>> force_indentation(new_figure().add_subplot(), history).get_xlabel()
    'indentation depth $d$ [mm]'
    """
    _draw(ax, history, "indentation_depth", "force", color)
    depth = np.asarray(history["indentation_depth"].values)
    force = np.asarray(history["force"].values)
    scale = scaled_unit(depth, "m").factor, scaled_unit(force, "N").factor
    ax.fill(depth * scale[0], force * scale[1], color=color, alpha=0.12, linewidth=0)
    return ax


def contact_radius_time(ax: Axes, history: xr.Dataset, *, color: str = style.GREEN) -> Axes:
    """Draw the contact radius a [m] over time t [s].

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    history : xarray.Dataset
        `ImpactResult.history` of one impact, in SI.
    color : str
        The line's colour.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`.

    Examples
    --------
    >>> import xarray as xr
    >>> from restitution.plot.style import new_figure
    >>> history = xr.Dataset({"contact_radius": ("time", [0.0, 4e-6, 0.0])}, {"time": [0.0, 1.0, 2.0]})
    >>> contact_radius_time(new_figure().add_subplot(), history).get_ylabel()
    'contact radius $a$ [µm]'
    """
    return _draw(ax, history, "time", "contact_radius", color)


def depth_time(ax: Axes, history: xr.Dataset, *, color: str = style.VERMILION) -> Axes:
    """Draw the indentation depth d [m] over time t [s].

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    history : xarray.Dataset
        `ImpactResult.history` of one impact, in SI.
    color : str
        The line's colour.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`.

    Examples
    --------
    >>> import xarray as xr
    >>> from restitution.plot.style import new_figure
    >>> history = xr.Dataset({"indentation_depth": ("time", [0.0, 0.4, 0.1])}, {"time": [0.0, 1.0, 2.0]})
    >>> depth_time(new_figure().add_subplot(), history).get_ylabel()
    'indentation depth $d$ [mm]'
    """
    return _draw(ax, history, "time", "indentation_depth", color)


def energy_bar(ax: Axes, energy: EnergyBudget) -> Axes:
    """Draw where the kinetic energy of the impact [J] went, as one stacked bar with its shares.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    energy : EnergyBudget
        `ImpactResult.energy`: kinetic energy before and after, dissipated, still stored [J].

    Returns
    -------
    matplotlib.axes.Axes
        `ax`.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> from restitution.plot.style import new_figure
    >>> energy = SimpleNamespace(kinetic_in=1e-3, kinetic_out=4e-4, dissipated=5e-4, stored=1e-4)
    >>> ax = energy_bar(new_figure().add_subplot(), energy)
    >>> ax.get_legend_handles_labels()[1]
    ['rebound 40.0 %', 'dissipated 50.0 %', 'left in the material 10.0 %']
    """
    before = float(energy.kinetic_in)
    # More than before where a constant force did work on the body.
    total = float(energy.kinetic_out) + float(energy.dissipated) + float(energy.stored)
    scale = scaled_unit(total, "J")
    start = 0.0
    parts = (
        ("rebound", float(energy.kinetic_out), style.BLUE),
        ("dissipated", float(energy.dissipated), style.ORANGE),
        ("left in the material", float(energy.stored), style.GREEN),
    )
    for words, value, color in parts:
        share = value * scale.factor
        ax.barh(0.0, share, left=start, height=0.5, color=color, label=f"{words} {100 * value / total:.1f} %")
        start += share
    ax.axvline(before * scale.factor, color="black", linewidth=0.8, linestyle="--")
    ax.set_xlim(0.0, 1.02 * max(total, before) * scale.factor)
    ax.set_ylim(-0.4, 1.3)
    ax.set_yticks([])
    ax.set_xlabel(f"energy [{scale.unit}] (dashed: before the impact)")
    ax.legend(loc="upper left", ncols=1)
    return ax


def overview(result: ImpactResult, *, figure: Figure | None = None) -> Figure:
    """Draw one impact on a page: force, depth, contact radius, the force-indentation loop and the energy.

    Parameters
    ----------
    result : ImpactResult
        The result of one impact, not of an array of them.
    figure : matplotlib.figure.Figure, optional
        An empty figure to draw into, e.g. `matplotlib.pyplot.figure()`; by default a new one, which needs no
        display.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, to be saved with `figure.savefig(...)` or `restitution.plot.style.save_figure`.
    """
    history = result.history
    energy = result.energy
    with style.context():
        page = style.new_figure(style.PAGE_WIDTH, 6.6) if figure is None else figure
        grid: Any = page.add_gridspec(3, 2, height_ratios=(1.0, 1.0, 0.62))
        panels: list[Any] = [page.add_subplot(grid[row, column]) for row in (0, 1) for column in (0, 1)]
        panels.append(page.add_subplot(grid[2, :]))
        force_time(panels[0], history)
        force_indentation(panels[1], history)
        depth_time(panels[2], history)
        contact_radius_time(panels[3], history)
        energy_bar(panels[4], energy)
        for panel, letter in zip(panels, "abcde", strict=True):
            style.panel_label(panel, f"({letter})")
        _title(page, result)
        # Tick labels are made when drawn: make them now, while the fonts are those of the package.
        page.draw_without_rendering()
    return page


def _title(page: Figure, result: ImpactResult) -> None:
    duration = scaled_unit(result.contact_time, "s")
    page.suptitle(
        rf"$e = {float(result.restitution_coefficient):.4g}$,  "
        rf"contact time {float(result.contact_time) * duration.factor:.4g} {duration.unit}",
        fontsize=11,
    )
