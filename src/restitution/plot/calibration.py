"""Picture of a calibrated contact law: e, its error and the contact time over the velocity."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from restitution.plot import style
from restitution.quantities import INPUTS, OUTPUTS

if TYPE_CHECKING:
    from restitution.calibration.result import Calibration

_LOOKS: dict[str, tuple[str, dict[str, Any]]] = {
    "": ("exact", {"color": style.BLACK, "linewidth": 2.2, "alpha": 0.5}),
    "calibrated_": ("calibrated", {"color": style.BLUE, "linestyle": "--"}),
    "naive_": ("as usually typed", {"color": style.VERMILION, "linestyle": ":"}),
}
_SPEED = INPUTS["velocity"].label(INPUTS["velocity"].unit)
_E, _TIME = "restitution_coefficient", "contact_time"


def overview(result: Calibration, *, ax: Axes | None = None) -> Figure:
    """Return a figure of e, its error and the contact time, or draw e on given axes; a line for each radius."""
    if ax is not None:
        _curves(ax, result, _E)
        figure: Any = ax.figure
        return figure
    timed = bool(np.any(result.table[f"calibrated_{_TIME}"].to_numpy() > 0.0))
    with style.page("ABC" if timed else "AB", height=3.0, title=result.words) as (figure, axes):
        _curves(axes[0], result, _E)
        _errors(axes[1], result)
        if timed:
            _curves(axes[2], result, _TIME)
    return figure


def _curves(ax: Axes, result: Calibration, name: str) -> None:
    """Draw exact, calibrated and naive values over the velocity."""
    table = result.table
    exact = np.concatenate([table[prefix + name].to_numpy().ravel() for prefix in ("", "calibrated_")])
    up = style.axis(OUTPUTS[name], exact)
    for prefix, (words, look) in _LOOKS.items():
        lines = _by_radius(table[prefix + name].to_numpy()) * up.factor
        first, *_ = ax.plot(table["velocity"].to_numpy(), lines, marker=_marker(result), markersize=3, **look)
        first.set_label(words)
    ax.set_xscale("log")
    if name == _E:
        ax.set_ylim(0.0, 1.05)
    ax.legend()
    style.labelled(ax, _SPEED, up.label)


def _errors(ax: Axes, result: Calibration) -> None:
    """Draw the error of e in per cent, and the levels of 1, 2 and 5 per cent."""
    table = result.table
    title, factor, *_ = result.error_column
    for level in result.within:
        ax.axhspan(-factor * level, factor * level, color=style.GREY, alpha=0.12, linewidth=0)
    lines = factor * _by_radius(table["error"].to_numpy())
    ax.plot(table["velocity"].to_numpy(), lines, color=style.BLUE, marker=_marker(result), markersize=3)
    ax.set_xscale("log")
    style.labelled(ax, _SPEED, title.replace(" ", " of $e$ ", 1) if " " in title else f"{title} of $e$")


def _by_radius(values: Any) -> Any:
    """Return values with a column for each radius."""
    return values if values.ndim == 2 else values[:, None]


def _marker(result: Calibration) -> str:
    """Return a marker where lines would have one point."""
    return "o" if result.collisions.velocity.size == 1 else ""
