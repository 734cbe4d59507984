"""Picture of a test of rebound resilience: R and the contact time over temperature, or for each base."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from restitution.display import scaled_unit
from restitution.plot import style
from restitution.plot.labels import quantity_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from restitution.rebound_resilience.result import Resilience

_ZERO_CELSIUS = 273.15
_LOOKS = {"half-space": (style.BLACK, "-"), "bonded": (style.BLUE, "--"), "frictionless": (style.VERMILION, ":")}


def overview(found: Resilience) -> Figure:
    """Return a figure of the resilience and of the contact time."""
    with style.context():
        figure, axes = style.panels("AB", height=3.0)
        _draw(axes[0], found, found.rebound_resilience, "rebound resilience $R$ [%]")
        times = np.where(np.isfinite(found.contact_time), found.contact_time, np.nan)
        factor, unit = scaled_unit(times, "s")
        _draw(axes[1], found, factor * times, quantity_label("contact_time", unit))
        axes[0].set_ylim(0.0, 100.0)
        longest = float(np.max(factor * times, initial=0.0, where=np.isfinite(times)))
        axes[1].set_ylim(0.0, 1.12 * longest or 1.0)
        return style.finish(figure, found.heading.replace(": ", "\n"))


def _draw(ax: Axes, found: Resilience, values: np.ndarray, label: str) -> None:
    """Draw a line over temperature, or a point, for each base."""
    if found.temperature is None:
        for place, (base, value) in enumerate(zip(found.base, values, strict=True)):
            ax.plot(place, value, "o", color=_LOOKS[base][0], markersize=7)
        ax.set_xticks(range(len(found.base)), found.base)
        ax.set_xlim(-0.5, len(found.base) - 0.5)
        style.labelled(ax, "base of the pad", label)
        return
    for base, column in zip(found.base, values.T, strict=True):
        colour, line = _LOOKS[base]
        ax.plot(found.temperature - _ZERO_CELSIUS, column, line, color=colour, marker="o", markersize=3, label=base)
    ax.legend()
    style.labelled(ax, "temperature [°C]", label)
