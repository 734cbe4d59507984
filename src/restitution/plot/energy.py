"""Plots of where the energy of an impact goes: over time, and in the end."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from restitution.plot import style
from restitution.plot.labels import quantity_label, scaled_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

    from restitution.impact.result import EnergyBudget

# From the bottom of the stack: what is lost for good, what may come back, what is motion.
_PARTS = {
    "dissipated_energy": ("dissipated", style.ORANGE),
    "stored_energy": ("stored", style.GREEN),
    "kinetic_energy": ("kinetic", style.BLUE),
}


def energy_area(ax: Axes, history: xr.Dataset) -> Axes:
    """Draw where the energy [J] is over time as a stacked area: dissipated, stored, kinetic.

    The three add up to the kinetic energy at impact (dashed), and the work of a constant force.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    history : xarray.Dataset
        `ImpactResult.history` of one impact solved by the exact method, in SI.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`.

    Raises
    ------
    ValueError
        If the history lacks one of the energies, as that of another method does.

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
        raise ValueError(f"history has no variable '{missing[0]}': only the exact method tells it")
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
    ax.legend(
        handles[::-1], labels[::-1], loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.2
    )
    return ax


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
