"""Panels over the history of an impact or an indentation: force, depth, contact radius, loop, energies."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from restitution.errors import InputError
from restitution.plot import style
from restitution.plot.labels import quantity_label, scaled_unit
from restitution.quantities import HISTORY

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

    from restitution.impact.result import EnergyBudget

# From the bottom of the stack to its top.
_PARTS = {
    "dissipated_energy": ("dissipated", style.ORANGE),
    "stored_energy": ("stored", style.GREEN),
    "kinetic_energy": ("kinetic", style.BLUE),
}


def _draw(ax: Axes, history: xr.Dataset, across: str, up: str, color: str) -> Axes:
    values: list[Any] = []
    labels: list[str] = []
    for name in (across, up):
        if name not in history.variables:
            raise InputError("history", list(history.data_vars), f"must have the variable {name!r}")
        column = np.asarray(history[name].values, dtype=np.float64)
        if column.ndim != 1:
            raise InputError(f"history.{name}.shape", column.shape, "must be over time alone")
        scale = scaled_unit(column, HISTORY[name].unit)
        values.append(column * scale.factor)
        labels.append(quantity_label(name, scale.unit))
    ax.plot(values[0], values[1], color=color)
    return style.labelled(ax, labels[0], labels[1])


def force_time(ax: Axes, history: xr.Dataset, *, color: str = style.BLUE) -> Axes:
    """Draw the contact force F [N] over time t [s].

    The history is `ImpactResult.history` or `IndentationResult.history`, in SI. All functions here return `ax`.

    Examples
    --------
    >>> import xarray as xr
    >>> from restitution.plot.style import new_figure
    >>> history = xr.Dataset({"force": ("time", [0.0, 2.0, 0.0])}, {"time": [0.0, 1e-3, 2e-3]})
    >>> ax = force_time(new_figure().add_subplot(), history)
    >>> ax.get_xlabel(), ax.get_ylabel()
    ('time since first touch $t$ [ms]', 'normal force $F$ [N]')
    """
    return _draw(ax, history, "time", "force", color)


def force_indentation(ax: Axes, history: xr.Dataset, *, color: str = style.BLUE) -> Axes:
    """Draw the force F [N] over the indentation depth d [m]: the loop whose area is the energy lost."""
    _draw(ax, history, "indentation_depth", "force", color)
    depth = np.asarray(history["indentation_depth"].values)
    force = np.asarray(history["force"].values)
    scale = scaled_unit(depth, "m").factor, scaled_unit(force, "N").factor
    ax.fill(depth * scale[0], force * scale[1], color=color, alpha=0.12, linewidth=0)
    return ax


def contact_radius_time(ax: Axes, history: xr.Dataset, *, color: str = style.GREEN) -> Axes:
    """Draw the contact radius a [m] over time t [s]."""
    _draw(ax, history, "time", "contact_radius", color)
    # Under a flat face it does not change.
    ax.set_ylim(bottom=0.0)
    return ax


def depth_time(ax: Axes, history: xr.Dataset, *, color: str = style.VERMILION) -> Axes:
    """Draw the indentation depth d [m] over time t [s]."""
    return _draw(ax, history, "time", "indentation_depth", color)


def energy_area(ax: Axes, history: xr.Dataset) -> Axes:
    """Draw where the energy [J] is over time as a stacked area: dissipated, stored, kinetic.

    The three add up to the kinetic energy at impact (dashed) and the work of a constant force. Only the history of the
    exact method has all three; another one is refused.

    Examples
    --------
    >>> import xarray as xr
    >>> from restitution.plot.style import new_figure
    >>> parts = {"kinetic": [2.0, 0.0, 1.0], "stored": [0.0, 1.5, 0.3], "dissipated": [0.0, 0.5, 0.7]}
    >>> columns = {f"{name}_energy": ("time", values) for name, values in parts.items()}
    >>> ax = energy_area(new_figure().add_subplot(), xr.Dataset(columns, {"time": [0.0, 1e-3, 2e-3]}))
    >>> ax.get_ylabel(), ax.get_legend_handles_labels()[1]
    ('energy [J]', ['dissipated', 'stored', 'kinetic'])
    """
    missing = [name for name in _PARTS if name not in history.variables]
    if missing:
        wanted = f"must have {missing[0]!r}, which only the exact method computes"
        raise InputError("history", list(history.data_vars), wanted)
    time = np.asarray(history["time"].values, dtype=np.float64)
    parts = [np.asarray(history[name].values, dtype=np.float64) for name in _PARTS]
    total = np.sum(parts, axis=0)
    across, up = scaled_unit(time, "s"), scaled_unit(total, "J")
    ax.stackplot(
        time * across.factor,
        [part * up.factor for part in parts],
        labels=[words for words, _ in _PARTS.values()],
        colors=[color for _, color in _PARTS.values()],
        alpha=0.75,
        linewidth=0,
    )
    before = float(parts[-1][0]) * up.factor
    ax.axhline(before, color="black", linewidth=0.8, linestyle="--")
    ax.set_xlim(0.0, time[-1] * across.factor)
    ax.set_ylim(0.0, 1.05 * float(total.max()) * up.factor)
    ax.set_xlabel(quantity_label("time", across.unit))
    ax.set_ylabel(f"energy [{up.unit}]")
    handles, labels = ax.get_legend_handles_labels()
    # Over the axes: within, it would hide a part.
    ax.legend(handles[::-1], labels[::-1], loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.2)
    return ax


def energy_bar(ax: Axes, energy: EnergyBudget) -> Axes:
    """Draw where the kinetic energy of the impact [J] went, as one stacked bar of `ImpactResult.energy`.

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
