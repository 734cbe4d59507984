"""Pages of an oscillating indentation and of tapping."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from restitution.indentation.tapping import COLUMNS, MODES
from restitution.plot import history as curves
from restitution.plot import style
from restitution.quantities import HISTORY, MEASURED, Quantity
from restitution.units import ANGLE, FORCE, LENGTH, in_words

if TYPE_CHECKING:
    from restitution.indentation.oscillation import Oscillation, OscillationArray
    from restitution.indentation.tapping import Tapping

# More curves have no label.
_MOST = 6
_DEGREES = Quantity("phase", ANGLE, "phase to the drive [deg]", r"$\phi$")


def overview(result: Oscillation, *, figure: Figure | None = None) -> Figure:
    """Draw depth and force over a period, and force over depth with the ellipse that the textbook reads.

    Examples
    --------
    >>> import restitution as rs
    >>> solid = rs.Material(rs.PronySeries(0.25, [1.0], [1.0]), bulk=float("inf"))
    >>> wave = rs.oscillate(solid, rs.Parabola(1.0), depth=1.0, amplitude=0.1, frequency=0.2)
    >>> len(overview(wave).axes)
    3
    """
    words = f"E' reads {100 * result.storage_error:+.2g} %, E'' {100 * result.loss_error:+.2g} % off"
    with style.page("AB;CC", height=5.4, figure=figure, title=words) as (page, panels):
        history = result.history
        for draw, ax in zip((curves.depth_time, curves.force_time), panels, strict=False):
            draw(ax, history)
            ax.set_xlabel(ax.get_xlabel().replace(HISTORY["time"].words, "time"))
        curves.force_indentation(panels[2], history)
        mean, first = result.force_harmonics[0].real, result.force_harmonics[1]
        depth, swing = result.depth_harmonics[0].real, result.depth_harmonics[1]
        waves = np.exp(1j * np.linspace(0.0, 2.0 * math.pi, 257))
        ellipse = history.assign(
            indentation_depth=("time", depth + np.imag(swing * waves)), force=("time", mean + np.imag(first * waves))
        )
        style.draw(
            panels[2], (HISTORY["indentation_depth"], ellipse["indentation_depth"].values),
            (HISTORY["force"], ellipse["force"].values), color=style.ORANGE, linestyle="--", label="first harmonics",
        )  # fmt: skip
        panels[2].legend(loc="upper left")
    return page


def errors(result: OscillationArray, *, figure: Figure | None = None) -> Figure:
    """Draw the moduli that the textbook reads over those of the materials, over the frequency.

    Examples
    --------
    >>> import restitution as rs
    >>> solid = rs.Material(rs.PronySeries(0.25, [1.0], [1.0]), bulk=float("inf"))
    >>> waves = rs.oscillate(solid, rs.Parabola(1.0), depth=1.0, amplitude=[[0.1], [0.2]], frequency=[0.1, 0.2, 0.5])
    >>> len(errors(waves).axes)
    2
    """
    frequency, places = result.inputs["frequency"].ravel(), np.arange(len(result.rows))
    contacts = list(dict.fromkeys(id(row.contact) for row in result.rows))
    others = [values.ravel() for name, values in result.inputs.items() if name != "frequency"]
    others.append(np.array([float(contacts.index(id(row.contact))) + 1.0 for row in result.rows]))
    kinds, which = np.unique(np.column_stack(others), axis=0, return_inverse=True)
    unit = (LENGTH if "depth" in result.inputs else FORCE).unit
    with style.page("AB", height=3.2, figure=figure, title="Readings of the textbook over the moduli") as (
        page,
        panels,
    ):
        for ax, name, label in zip(panels, ("storage_error", "loss_error"), ("$E'$", "$E''$"), strict=True):
            ratio = 1.0 + getattr(result, name).ravel()
            for n, kind in enumerate(kinds):
                run = places[which.ravel() == n]
                run = run[np.argsort(frequency[run], kind="stable")]
                words = "mean and amplitude " + ", ".join(in_words(float(value), unit) for value in kind[:2])
                words += f", material {kind[2]:.0f}" if len(contacts) > 1 else ""
                ax.plot(frequency[run], ratio[run], ".-", label=words if n < _MOST else None)
            ax.set(xscale="log")
            style.plain_ticks(style.labelled(ax, MEASURED["frequency"].label("Hz"), f"{label}, read over true"))
        panels[0].legend(fontsize=7)
    return page


def tapping_curves(result: Tapping, *, figure: Figure | None = None) -> Figure:
    """Draw amplitude, phase, largest force and loss per tap over the distance, and the ways of several modes.

    Examples
    --------
    >>> import restitution as rs
    >>> solid = rs.Material(rs.PronySeries(0.25, [1.0], [1.0]), bulk=float("inf"))
    >>> options = {"spring_constant": 1.0, "quality_factor": 10.0, "frequency": 0.16, "free_amplitude": 1.0}
    >>> len(tapping_curves(rs.tap(solid, rs.Parabola(1.0), [0.9, 0.8], **options)).axes)
    4
    """
    modes = result.mode_swing.shape[1]
    layout, height = ("AB;CD", 5.0) if modes == 1 else ("AB;CD;EE", 7.2)
    with style.page(layout, height=height, figure=figure, title="Tapping over the distance") as (page, panels):
        across = COLUMNS["distance"], result.distance
        columns = (
            (COLUMNS["amplitude"], result.amplitude), (_DEGREES, np.degrees(result.phase)),
            (COLUMNS["max_force"], result.max_force), (COLUMNS["dissipated"], result.dissipated),
        )  # fmt: skip
        for ax, column, color in zip(
            panels[:4], columns, (style.BLUE, style.GREEN, style.VERMILION, style.ORANGE), strict=True
        ):
            style.draw(ax, across, column, color=color, marker=".")
        panels[1].set_ylabel(_DEGREES.words)
        if modes > 1:
            labels = [f"mode {n + 1}" for n in range(modes)]
            style.draw(panels[4], across, (MODES["mode_swing"], result.mode_swing), marker=".", label=labels)
            panels[4].set_yscale("log")
            panels[4].legend(fontsize=7)
    return page
