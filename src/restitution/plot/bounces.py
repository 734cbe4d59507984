"""Measured bounces: the sound with its touches, and e and the loss tangent of each bounce."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from restitution.checks import Array
from restitution.identification.bounce_series import MeasuredBounces
from restitution.identification.sound import Recording
from restitution.plot import style
from restitution.quantities import INPUTS, MEASURED, MODULI, OUTPUTS

# Parts of the drawn sound; more are not told apart.
_PARTS = 3000


def measured(bounces: MeasuredBounces) -> Figure:
    """Draw the touches in the sound, and the restitution coefficients and loss tangents over the velocity."""
    timed = bool(np.any(np.isfinite(bounces.time)))
    with style.page("AA;BC" if timed else "BC", height=5.0 if timed else 3.0) as (figure, axes):
        if timed:
            touches(axes[0], bounces)
        for ax, name, quantity in (
            (axes[-2], "restitution_coefficient", OUTPUTS["restitution_coefficient"]),
            (axes[-1], "loss_tangent", MODULI["loss_tangent"]),
        ):
            values = getattr(bounces, name)
            there = np.isfinite(values) & np.isfinite(bounces.velocity)
            error = np.nan_to_num(getattr(bounces, f"{name}_error")[there])
            x = style.axis(INPUTS["velocity"], bounces.velocity[there])
            ax.errorbar(
                bounces.velocity[there] * x.factor, values[there], error, fmt="o", color=style.BLUE, markersize=4
            )
            style.labelled(ax, x.label, quantity.label(""))
    return figure


def touches(ax: Axes, bounces: MeasuredBounces) -> Axes:
    """Draw the sound about the bounces, with a line at each touch."""
    time = bounces.time
    margin = 0.15 * float(time[-1] - time[0])
    first, last = float(time[0]) - margin, float(time[-1]) + margin
    if bounces.recording is not None:
        at, low, high = _outline(bounces.recording, first, last)
        ax.fill_between(at, low, high, color=style.GREY, linewidth=0.3)
    ax.vlines(time, 0.0, 0.93, color=style.VERMILION, linewidth=0.5, transform=ax.get_xaxis_transform(), zorder=0)
    place = ax.get_xaxis_transform()
    ax.plot(time, np.full(time.size, 0.95), "v", color=style.VERMILION, markersize=4, transform=place, label="touches")
    ax.set_xlim(max(first, 0.0) if bounces.recording is not None else first, last)
    ax.legend(loc="lower right")
    return style.labelled(ax, MEASURED["time"].label("s"), "sound, share of full scale" if bounces.recording else "")


def _outline(recording: Recording, first: float, last: float) -> tuple[Array, Array, Array]:
    """Return times, and the lowest and highest sample in each short part of a sound."""
    begin, end = max(int(first * recording.rate), 0), min(int(last * recording.rate) + 1, recording.samples.size)
    size = max(1, (end - begin) // _PARTS)
    count = (end - begin) // size
    parts = recording.samples[begin : begin + count * size].reshape(count, size)
    return (begin + size * (np.arange(count) + 0.5)) / recording.rate, parts.min(axis=1), parts.max(axis=1)
