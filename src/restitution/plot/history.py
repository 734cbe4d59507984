"""Plots of one impact: force, depth and contact radius over time, the force-indentation loop."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from restitution.plot import style
from restitution.plot.labels import quantity_label, scaled_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

_UNITS = {
    "time": "s",
    "indentation_depth": "m",
    "indentation_velocity": "m/s",
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
    _draw(ax, history, "time", "contact_radius", color)
    # Under a flat face it does not change.
    ax.set_ylim(bottom=0.0)
    return ax


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
