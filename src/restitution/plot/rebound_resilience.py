"""Picture of a test of rebound resilience: R and the contact time over temperature, or for each base."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from restitution.plot import style
from restitution.quantities import INPUTS, OUTPUTS
from restitution.rebound_resilience import COLUMNS, Resilience
from restitution.units import ZERO_CELSIUS

_LOOKS = {"half-space": (style.BLACK, "-"), "bonded": (style.BLUE, "--"), "frictionless": (style.VERMILION, ":")}


def overview(result: Resilience) -> Figure:
    """Return a figure of the resilience and of the contact time."""
    times = np.where(np.isfinite(result.contact_time), result.contact_time, np.nan)
    up = style.axis(OUTPUTS["contact_time"], times)
    with style.page("AB", height=3.0, title=result.heading.replace(": ", "\n")) as (figure, axes):
        _draw(axes[0], result, result.rebound_resilience, COLUMNS["rebound_resilience"].label("%"))
        _draw(axes[1], result, up.factor * times, up.label)
        axes[0].set_ylim(0.0, 100.0)
        longest = float(np.max(up.factor * times, initial=0.0, where=np.isfinite(times)))
        axes[1].set_ylim(0.0, 1.12 * longest or 1.0)
    return figure


def _draw(ax: Axes, result: Resilience, values: np.ndarray, label: str) -> None:
    """Draw a line over temperature, or a point, for each base."""
    if result.temperature is None:
        for place, (base, value) in enumerate(zip(result.base, values, strict=True)):
            ax.plot(place, value, "o", color=_LOOKS[base][0], markersize=7)
        ax.set_xticks(range(len(result.base)), result.base)
        ax.set_xlim(-0.5, len(result.base) - 0.5)
        style.labelled(ax, "base of the pad", label)
        return
    for base, column in zip(result.base, values.T, strict=True):
        colour, line = _LOOKS[base]
        ax.plot(result.temperature - ZERO_CELSIUS, column, line, color=colour, marker="o", markersize=3, label=base)
    ax.legend()
    style.labelled(ax, INPUTS["temperature"]._replace(symbol="").label("°C"), label)
