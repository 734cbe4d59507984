"""Picture of a calibrated contact law: e, its error and the contact time over the velocity."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from restitution.display import scaled_unit
from restitution.plot import style
from restitution.plot.labels import quantity_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from restitution.calibration.result import Calibration

_LOOKS: dict[str, tuple[str, dict[str, Any]]] = {
    "": ("exact", {"color": style.BLACK, "linewidth": 2.2, "alpha": 0.5}),
    "calibrated_": ("calibrated", {"color": style.BLUE, "linestyle": "--"}),
    "naive_": ("as usually typed", {"color": style.VERMILION, "linestyle": ":"}),
}
_E, _TIME = "restitution_coefficient", "contact_time"


def overview(found: Calibration, *, ax: Axes | None = None) -> Figure:
    """Return a figure of e, its error and the contact time, or draw e on given axes; a line for each radius."""
    if ax is not None:
        _curves(ax, found, _E)
        figure: Any = ax.figure
        return figure
    timed = bool(np.any(found.table[f"calibrated_{_TIME}"].to_numpy() > 0.0))
    with style.context():
        figure, axes = style.panels("ABC" if timed else "AB", height=3.0)
        _curves(axes[0], found, _E)
        _errors(axes[1], found)
        if timed:
            _curves(axes[2], found, _TIME)
        return style.finish(figure, found.words)


def _curves(ax: Axes, found: Calibration, name: str) -> None:
    """Draw exact, calibrated and naive values over the velocity."""
    table = found.table
    exact = np.concatenate([table[prefix + name].to_numpy().ravel() for prefix in ("", "calibrated_")])
    factor, unit = scaled_unit(exact, table[name].attrs["units"].replace("1", ""))
    for prefix, (words, look) in _LOOKS.items():
        lines = _by_radius(table[prefix + name].to_numpy()) * factor
        drawn = ax.plot(table["velocity"].to_numpy(), lines, marker=_marker(found), markersize=3, **look)
        drawn[0].set_label(words)
    ax.set_xscale("log")
    if name == _E:
        ax.set_ylim(0.0, 1.05)
    ax.legend()
    style.labelled(ax, quantity_label("velocity", "m/s"), quantity_label(name, unit))


def _errors(ax: Axes, found: Calibration) -> None:
    """Draw the error of e in per cent, and the levels of 1, 2 and 5 per cent."""
    table = found.table
    for level in found.within:
        ax.axhspan(-100 * level, 100 * level, color=style.GREY, alpha=0.12, linewidth=0)
    lines = 100.0 * _by_radius(table["error"].to_numpy())
    ax.plot(table["velocity"].to_numpy(), lines, color=style.BLUE, marker=_marker(found), markersize=3)
    ax.set_xscale("log")
    style.labelled(ax, quantity_label("velocity", "m/s"), "error of $e$ [%]")


def _by_radius(values: Any) -> Any:
    """Return values with a column for each radius."""
    return values if values.ndim == 2 else values[:, None]


def _marker(found: Calibration) -> str:
    """Return a marker where lines would have one point."""
    return "o" if found.collisions.velocity.size == 1 else ""
