"""Relaxation functions over time and frequency, and data beside what was fitted to them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from restitution.material.measurement import DynamicTable, RelaxationTable
from restitution.material.prony import PronySeries
from restitution.material.shift import ShiftTable
from restitution.plot.labels import scaled_unit
from restitution.plot.style import BLUE, GREEN, GREY, ORANGE, VERMILION, context, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

_COLORS = (BLUE, VERMILION, GREEN, ORANGE)


def relaxation(
    ax: Axes,
    series: Mapping[str, PronySeries],
    window: tuple[float, float],
    data: RelaxationTable | None = None,
    unit: str = "Pa",
) -> Axes:
    """Draw relaxation moduli over a window of time [s], and the data that one was fitted to.

    Examples
    --------
    >>> ax = new_figure().add_subplot()
    >>> _ = relaxation(ax, {"shear": PronySeries(1e6, [2e6], [1.0])}, (0.01, 100.0))
    >>> ax.get_xscale(), ax.get_ylabel()
    ('log', 'relaxation modulus [MPa]')
    """
    t = np.geomspace(*window, 400)
    curves = {name: np.asarray(one.relaxation_modulus(t)) for name, one in series.items()}
    scale = scaled_unit(np.concatenate(list(curves.values())), unit)
    if data is not None:
        ax.plot(data.time, data.modulus * scale.factor, ".", color=GREY, markersize=4, label="data")
    for color, (name, curve) in zip(_COLORS, curves.items(), strict=False):
        ax.plot(t, curve * scale.factor, color=color, label=name)
    return _finished(ax, "time $t$ [s]", f"relaxation modulus [{scale.unit}]")


def dynamic(
    ax: Axes,
    series: Mapping[str, PronySeries],
    window: tuple[float, float],
    data: DynamicTable | None = None,
    unit: str = "Pa",
) -> Axes:
    """Draw storage (solid) and loss moduli (dashed) over the angular frequencies of a window of time [s].

    Examples
    --------
    >>> ax = new_figure().add_subplot()
    >>> _ = dynamic(ax, {"shear": PronySeries(1e6, [2e6], [1.0])}, (0.01, 100.0))
    >>> [line.get_label() for line in ax.lines]
    ['shear, storage', 'shear, loss']
    """
    omega = np.geomspace(1.0 / window[1], 1.0 / window[0], 400)
    storage = {name: np.asarray(one.storage_modulus(omega)) for name, one in series.items()}
    scale = scaled_unit(np.concatenate(list(storage.values())), unit)
    if data is not None:
        for values, mark in ((data.storage_modulus, "."), (data.loss_modulus, "x")):
            ax.plot(data.angular_frequency, values * scale.factor, mark, color=GREY, markersize=4)
    for color, (name, one) in zip(_COLORS, series.items(), strict=False):
        ax.plot(omega, storage[name] * scale.factor, color=color, label=f"{name}, storage")
        loss = np.asarray(one.loss_modulus(omega)) * scale.factor
        ax.plot(omega, np.where(loss > 0, loss, np.nan), "--", color=color, label=f"{name}, loss")
    return _finished(ax, r"angular frequency $\omega$ [rad/s]", f"modulus [{scale.unit}]")


def overview(
    series: Mapping[str, PronySeries],
    window: tuple[float, float],
    data: RelaxationTable | DynamicTable | None = None,
    *,
    unit: str = "Pa",
) -> Figure:
    """Return a figure of the relaxation moduli over time and the complex ones over frequency.

    Parameters
    ----------
    series
        Relaxation functions by their names, at most four.
    window
        Shortest and longest time [s].
    data
        What one of them was fitted to.

    Examples
    --------
    >>> len(overview({"shear": PronySeries(1e6, [2e6], [1.0])}, (0.01, 100.0)).axes)
    2
    """
    with context():
        figure = new_figure(height=3.2)
        left, right = figure.subplots(1, 2)
        relaxation(left, series, window, data if isinstance(data, RelaxationTable) else None, unit)
        dynamic(right, series, window, data if isinstance(data, DynamicTable) else None, unit)
    return figure


def shift_factors(table: ShiftTable) -> Figure:
    """Return a figure of shift factors over temperature.

    Examples
    --------
    >>> len(shift_factors(ShiftTable([290.0, 300.0], [1.0, 0.0])).axes)
    1
    """
    with context():
        figure = new_figure(width=3.54, height=3.0)
        ax: Any = figure.subplots()
        ax.plot(table.temperatures - 273.15, table.log10_factors, ".-", color=BLUE)
        ax.set_xlabel("temperature [°C]")
        ax.set_ylabel(r"$\log_{10} a_T$")
    return figure


def _finished(ax: Axes, x: str, y: str) -> Axes:
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    ax.legend()
    return ax
