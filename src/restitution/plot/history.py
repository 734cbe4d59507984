"""Panels over the history of an impact or an indentation, and the page of a prescribed indentation."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from restitution.checks import Array
from restitution.errors import InputError
from restitution.indentation.result import IndentationStatus
from restitution.plot import style
from restitution.quantities import HISTORY, Quantity
from restitution.units import ENERGY, FORCE, LENGTH, TIME, in_words, scaled_unit

if TYPE_CHECKING:
    import xarray as xr

    from restitution.impact.result import EnergyBudget
    from restitution.indentation.result import IndentationResult

# Even times for each loop of force and depth, and loops for which the number of times grows.
_POINTS, _MOST_LOOPS = 401, 20
# A turning and a contact.
_ONE_LOOP = 2
_COLORS = (style.BLUE, style.ORANGE, style.GREEN, style.PURPLE)
# From the bottom of the stack to its top.
_PARTS = {
    "radiated_energy": ("radiated", style.PURPLE),
    "dissipated_energy": ("dissipated", style.ORANGE),
    "stored_energy": ("stored", style.GREEN),
    "kinetic_energy": ("kinetic", style.BLUE),
}


def _column(history: xr.Dataset, name: str) -> tuple[Quantity, Array]:
    """Return a quantity of the history with its values over time."""
    if name not in history.variables:
        raise InputError("history", list(history.data_vars), f"must have the variable {name!r}")
    column = np.asarray(history[name].values, dtype=np.float64)
    if column.ndim != 1:
        raise InputError(f"history.{name}.shape", column.shape, "must be over time alone")
    return HISTORY[name], column


def _draw(ax: Axes, history: xr.Dataset, across: str, up: str, color: str) -> Axes:
    return style.draw(ax, _column(history, across), _column(history, up), color=color)


def force_time(ax: Axes, history: xr.Dataset) -> Axes:
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
    return _draw(ax, history, "time", "force", style.BLUE)


def force_indentation(ax: Axes, history: xr.Dataset, *, area: bool = True) -> Axes:
    """Draw the force F [N] over the indentation depth d [m]; the area of the loop is the energy lost."""
    _draw(ax, history, "indentation_depth", "force", style.BLUE)
    if area:
        ax.fill(*ax.lines[-1].get_data(), color=style.BLUE, alpha=0.12, linewidth=0)
    return ax


def contact_radius_time(ax: Axes, history: xr.Dataset) -> Axes:
    """Draw the contact radius a [m] over time t [s]."""
    _draw(ax, history, "time", "contact_radius", style.GREEN)
    # The contact radius of a flat face is constant.
    ax.set_ylim(bottom=0.0)
    return ax


def depth_time(ax: Axes, history: xr.Dataset) -> Axes:
    """Draw the indentation depth d [m] over time t [s]."""
    return _draw(ax, history, "time", "indentation_depth", style.VERMILION)


def energy_area(ax: Axes, history: xr.Dataset) -> Axes:
    """Draw dissipated, stored and kinetic energy [J] over time as a stacked area, and what a target carries away.

    They add up to the kinetic energy at impact (dashed) and the work of a constant force. Only the history of the
    exact method has all of them; another one is refused.
    """
    parts = {name: look for name, look in _PARTS.items() if name in history.variables or name != "radiated_energy"}
    missing = [name for name in parts if name not in history.variables]
    if missing:
        rule = f"must have {missing[0]!r}, which only the exact method computes"
        raise InputError("history", list(history.data_vars), rule)
    quantity, time = _column(history, "time")
    across = style.axis(quantity, time)
    energies = np.stack([np.asarray(history[name].values, dtype=np.float64) for name in parts])
    total = energies.sum(axis=0)
    factor, unit = scaled_unit(total, ENERGY.unit)
    words, colors = zip(*parts.values(), strict=True)
    look: dict[str, Any] = {"colors": colors, "alpha": 0.75, "linewidth": 0.8, "edgecolor": "white"}
    ax.stackplot(time * across.factor, energies * factor, labels=words, **look)
    ax.axhline(energies[-1, 0] * factor, color="black", linewidth=0.8, linestyle="--")
    ax.set(xlim=(0.0, time[-1] * across.factor), ylim=(0.0, 1.05 * total.max() * factor))
    ax.set(xlabel=across.label, ylabel=f"energy [{unit}]")
    handles, labels = ax.get_legend_handles_labels()
    # Over the axes: within, it would hide a part.
    ax.legend(
        handles[::-1], labels[::-1], loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(parts), borderaxespad=0.2
    )
    return ax


def energy_bar(ax: Axes, energy: EnergyBudget) -> Axes:
    """Draw the energies after the impact [J] as a stacked bar: rebound, dissipated, left in the material, radiated."""
    parts = [float(part) for part in (energy.kinetic_out, energy.dissipated, energy.stored, energy.radiated)]
    # The total is above the kinetic energy before the impact where a constant force did work on the body.
    total, before = sum(parts), float(energy.kinetic_in)
    factor, unit = scaled_unit(total, ENERGY.unit)
    start = 0.0
    looks = zip(("rebound", "dissipated", "left in the material", "radiated"), _COLORS, strict=True)
    for value, (words, color) in zip(parts if parts[-1] else parts[:-1], looks, strict=False):
        label = f"{words} {100 * value / total:.1f} %"
        ax.barh(0.0, value * factor, left=start, height=0.5, color=color, label=label)
        start += value * factor
    ax.axvline(before * factor, color="black", linewidth=0.8, linestyle="--")
    ax.set(xlim=(0.0, 1.02 * max(total, before) * factor), ylim=(-0.4, 1.3), yticks=[])
    ax.set_xlabel(f"energy [{unit}] (dashed: before the impact)")
    ax.legend(loc="upper left", ncols=2)
    return ax


def curve(result: IndentationResult) -> xr.Dataset:
    """Return the dense history of an indentation, with the limits from both sides at each kink and jump.

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

    knots = np.unique(result.prescribed_history.knots)
    # Sorting keeps the order of points at the same time.
    count = _POINTS * min(1 + result.turning_times.size // 2, _MOST_LOOPS)
    return xr.concat([result.sample(knots, before=True), result.sample(n_points=count)], "time").sortby("time")


def overview(result: IndentationResult, *, figure: Figure | None = None) -> Figure:
    """Draw depth, force and contact radius over time and force over depth, into a new or a given empty figure."""
    history = curve(result)
    words = [
        f"prescribed {result.prescribed}",
        f"largest force {in_words(result.max_force, FORCE.unit)}",
        f"largest depth {in_words(result.max_indentation_depth, LENGTH.unit)}",
    ]
    ends = result.contact_intervals[:, 1]
    ends = ends[np.isfinite(ends)]
    if math.isfinite(result.contact_end_time):
        which = "last contact" if ends.size > 1 else "contact"
        words.append(f"{which} ends at {in_words(result.contact_end_time, TIME.unit)} (dashed)")
    with style.page("AB;CD", height=5.0, figure=figure, title=", ".join(words)) as (page, panels):
        for draw, ax in zip((depth_time, force_time, contact_radius_time), panels, strict=False):
            draw(ax, history)
            # A prescribed history may begin before the touch.
            ax.set_xlabel(ax.get_xlabel().replace(HISTORY["time"].words, "time"))
            for end in ends * scaled_unit(history["time"].values, TIME.unit).factor:
                ax.axvline(end, color=style.GREY, linewidth=0.8, linestyle="--")
        # The area is the lost energy if there is one loop, the contact ends and the history has no step.
        steps = np.any(np.diff(result.prescribed_history.knots) == 0.0)
        loops = result.turning_times.size + len(result.contact_intervals) > _ONE_LOOP
        closed = result.status == IndentationStatus.SEPARATED and not steps
        force_indentation(panels[3], history, area=closed and not loops)
    return page
