"""Relaxation functions over time and frequency, with the data to which one was fitted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from restitution.display import scaled_unit
from restitution.errors import InputError
from restitution.material.fit import DynamicTable, RelaxationTable
from restitution.material.isotherms import Curve, Isotherms, MasterCurve
from restitution.material.prony import PronySeries
from restitution.material.shift import ShiftTable
from restitution.material.viscoelastic import Material, reduced_modulus
from restitution.plot import style
from restitution.quantities import MODULI

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

_COLORS = (style.BLUE, style.VERMILION, style.GREEN, style.ORANGE)


def relaxation(
    ax: Axes,
    series: Mapping[str, PronySeries],
    window: tuple[float, float],
    data: RelaxationTable | None = None,
    *,
    unit: str = "Pa",
) -> Axes:
    """Draw relaxation moduli over a window of time [s], and the data to which one was fitted.

    The unit is empty for moduli that are shares of the instantaneous one.
    """
    t = np.geomspace(*window, 400)
    curves = {name: np.asarray(one.relaxation_modulus(t)) for name, one in series.items()}
    factor, prefixed = scaled_unit(np.concatenate(list(curves.values())), unit)
    if data is not None:
        ax.plot(data.time, data.modulus * factor, ".", color=style.GREY, markersize=4, label="data")
    for color, (name, curve) in zip(_COLORS, curves.items(), strict=False):
        ax.plot(t, curve * factor, color=color, label=name if unit or len(series) > 1 else None)
    return _finished(ax, "time $t$ [s]", "relaxation modulus", prefixed)


def dynamic(
    ax: Axes,
    series: Mapping[str, PronySeries],
    window: tuple[float, float],
    data: DynamicTable | None = None,
    *,
    unit: str = "Pa",
) -> Axes:
    """Draw storage (solid) and loss moduli (dashed) over the angular frequencies of a window of time [s].

    Examples
    --------
    >>> ax = style.new_figure().add_subplot()
    >>> _ = dynamic(ax, {"shear": PronySeries(1e6, [2e6], [1.0])}, (0.01, 100.0))
    >>> [line.get_label() for line in ax.lines]
    ['shear, storage', 'shear, loss']
    """
    omega = np.geomspace(1.0 / window[1], 1.0 / window[0], 400)
    storage = {name: np.asarray(one.storage_modulus(omega)) for name, one in series.items()}
    factor, prefixed = scaled_unit(np.concatenate(list(storage.values())), unit)
    if data is not None:
        for values, mark in ((data.storage_modulus, "."), (data.loss_modulus, "x")):
            ax.plot(data.angular_frequency, values * factor, mark, color=style.GREY, markersize=4)
    for color, (name, one) in zip(_COLORS, series.items(), strict=False):
        # The label of the axis names a single series of shares.
        words = f"{name}, " if unit or len(series) > 1 else ""
        ax.plot(omega, storage[name] * factor, color=color, label=f"{words}storage")
        loss = np.asarray(one.loss_modulus(omega)) * factor
        ax.plot(omega, np.where(loss > 0, loss, np.nan), "--", color=color, label=f"{words}loss")
    return _finished(ax, r"angular frequency $\omega$ [rad/s]", "modulus", prefixed)


def overview(
    series: Mapping[str, PronySeries],
    window: tuple[float, float] | None = None,
    data: RelaxationTable | DynamicTable | None = None,
    *,
    unit: str = "Pa",
) -> Figure:
    """Return a figure of the relaxation moduli over time and the complex ones over frequency, of at most four series.

    The window of times [s] reaches a decade beyond all relaxation times by default. The unit is empty for shares of
    the instantaneous modulus.
    """
    if window is None:
        times = np.concatenate([one.relaxation_times for one in series.values()] or [np.empty(0)])
        window = (0.1 * float(times.min()), 10.0 * float(times.max())) if times.size else (1e-6, 1.0)
    with style.context():
        figure, (left, right) = style.panels("AB", height=3.2)
        relaxation(left, series, window, data if isinstance(data, RelaxationTable) else None, unit=unit)
        dynamic(right, series, window, data if isinstance(data, DynamicTable) else None, unit=unit)
        return style.finish(figure)


def shift_factors(table: ShiftTable) -> Figure:
    """Return a figure of shift factors over temperature."""
    with style.context():
        figure, (ax,) = style.panels("A", style.COLUMN_WIDTH, 3.0)
        ax.plot(table.temperatures - 273.15, table.log10_factors, ".-", color=style.BLUE)
        ax.set(xlabel="temperature [°C]", ylabel=r"$\log_{10} a_T$")
        return style.finish(figure)


def bounce_moduli(table: Any, data: DynamicTable | Material | None = None, poisson_ratio: float = 0.5) -> Figure:
    """Return a figure of the effective moduli of bounces, on top of the reduced modulus of a DMA table or a material.

    The moduli of a table in shear or tension are converted with a constant Poisson ratio.
    """
    known = np.isfinite(table.storage_modulus)
    if not np.any(known):
        wanted = "need a contact time or a peak force: without, the loss tangents have no frequency"
        raise InputError("rebounds", wanted=wanted)
    omega, storage, loss = (getattr(table, name)[known] for name in ("angular_frequency", *_PARTS))
    tangent = table.loss_tangent[known]
    curve = None if data is None else _reduced(data, omega, poisson_ratio)
    factor, unit = scaled_unit(storage, "Pa")
    with style.context():
        figure, (left, right) = style.panels("AB", height=3.2)
        if curve is not None:
            points, moduli = curve
            style_of = "-" if isinstance(data, Material) else ".-"
            for values, color, label in ((moduli.real, style.BLUE, "storage"), (moduli.imag, style.VERMILION, "loss")):
                left.plot(points, values * factor, style_of, color=color, markersize=3, linewidth=0.8, label=label)
            right.plot(points, moduli.imag / moduli.real, style_of, color=style.GREEN, markersize=3, linewidth=0.8)
        for ax, values, name, color in (
            (left, storage * factor, "storage_modulus", style.BLUE),
            (left, loss * factor, "loss_modulus", style.VERMILION),
            (right, tangent, "loss_tangent", style.GREEN),
        ):
            scale = 1.0 if ax is right else factor
            error = np.nan_to_num(getattr(table, f"{name}_error")[known]) * scale
            label = f"{MODULI[name].words}, bounces"
            ax.errorbar(omega, values, error, fmt="o", color=color, markersize=4, markerfacecolor="white", label=label)
        left.set(yscale="log")
        for ax, words in ((left, f"reduced modulus $E^*$ [{unit}]"), (right, r"loss tangent $\tan\delta$")):
            ax.set(xscale="log")
            ax.legend()
            style.plain_ticks(style.labelled(ax, r"angular frequency $\omega$ [rad/s]", words))
        right.set_ylim(bottom=0.0)
        return style.finish(figure)


_PARTS = ("storage_modulus", "loss_modulus")


def _reduced(
    data: DynamicTable | Material, omega: Array, poisson_ratio: float
) -> tuple[Array, NDArray[np.complex128]]:
    """Frequencies and reduced moduli of a table, or of a material a factor of ten about the frequencies."""
    if isinstance(data, Material):
        points, series = np.geomspace(0.1 * omega.min(), 10.0 * omega.max(), 200), reduced_modulus(data)
        return points, np.asarray(series.storage_modulus(points) + 1j * series.loss_modulus(points))
    factors = {"shear": 2.0 / (1.0 - poisson_ratio), "tension": 1.0 / (1.0 - poisson_ratio**2), None: 1.0}
    return data.angular_frequency, factors[data.deformation] * (data.storage_modulus + 1j * data.loss_modulus)


def isotherms(measured: Isotherms) -> Figure:
    """Return a figure of the moduli at each temperature."""
    with style.context():
        figure, (ax,) = style.panels("A", style.COLUMN_WIDTH, 3.2)
        _curves(ax, measured.tables, measured.temperatures)
        return style.finish(figure)


def superposition(curve: MasterCurve) -> Figure:
    """Return a figure of the isotherms, of the master curve, and of the shifts with their standard errors."""
    kelvin = curve.temperatures
    with style.context():
        figure, (left, middle, right) = style.panels("ABC", height=3.0)
        _curves(left, curve.isotherms.tables, kelvin)
        _curves(middle, curve.reduced, kelvin, reduced=True)
        middle.set_title(f"at {curve.reference_temperature - 273.15:.4g} °C", fontsize=9)
        known = np.isfinite(curve.errors)
        celsius = kelvin - 273.15
        errors = np.where(known, curve.errors, 0.0)
        right.errorbar(celsius, curve.log10_factors, errors, fmt=".", color=style.BLUE, capsize=2, label="shift")
        if not known.all():
            right.plot(celsius[~known], curve.log10_factors[~known], "o", mfc="none", color=style.VERMILION,
                       label="not determined")  # fmt: skip
        if curve.law != "free":
            law, fine = curve.shift, np.linspace(kelvin[0], kelvin[-1], 200)
            factors = [law.factor(one) for one in fine.tolist()]
            right.plot(fine - 273.15, np.log10(factors), color=style.BLUE, linewidth=0.8)
        if np.any(curve.vertical_errors > 0.0):
            right.errorbar(celsius, curve.log10_vertical_factors, curve.vertical_errors, fmt="x",
                           color=style.GREEN, markersize=3, label="vertical")  # fmt: skip
        if len(right.get_legend_handles_labels()[0]) > 1:
            right.legend()
        style.labelled(right, "temperature [°C]", r"$\log_{10} a_T$")
        return style.finish(figure)


def _curves(ax: Axes, tables: Sequence[Curve], kelvin: Array, *, reduced: bool = False) -> None:
    """Draw moduli at each temperature: storage or relaxation modulus as dots, loss modulus as crosses."""
    from matplotlib import colormaps

    colors = colormaps["plasma"](0.85 * (kelvin - kelvin[0]) / (kelvin[-1] - kelvin[0]))
    dynamic_ = isinstance(tables[0], DynamicTable)
    first = [one.storage_modulus if isinstance(one, DynamicTable) else one.modulus for one in tables]
    factor, prefixed = scaled_unit(np.concatenate(first), "Pa")
    for place, (table, color) in enumerate(zip(tables, colors, strict=True)):
        # The colour bar would take the room of a panel.
        label = f"{kelvin[place] - 273.15:.4g} °C" if place in (0, len(tables) - 1) else None
        x = table.angular_frequency if isinstance(table, DynamicTable) else table.time
        ax.plot(x, first[place] * factor, ".", color=color, markersize=3, label=label)
        if isinstance(table, DynamicTable):
            loss = np.where(table.loss_modulus > 0.0, table.loss_modulus, np.nan)
            ax.plot(x, loss * factor, "x", color=color, markersize=2.5, markeredgewidth=0.6)
    words = "storage (dots) and loss modulus (crosses)" if dynamic_ else "relaxation modulus"
    frequency = r"$\omega a_T$ [rad/s]" if reduced else r"angular frequency $\omega$ [rad/s]"
    time = "$t/a_T$ [s]" if reduced else "time $t$ [s]"
    ax.set(xscale="log", yscale="log")
    ax.legend(handletextpad=0.2)
    style.labelled(ax, frequency if dynamic_ else time, f"{words} [{prefixed}]")


def _finished(ax: Axes, x: str, words: str, unit: str) -> Axes:
    ax.set(xscale="log", yscale="log")
    if ax.get_legend_handles_labels()[0]:
        ax.legend()
    style.plain_ticks(ax)
    return style.labelled(ax, x, f"{words} [{unit}]" if unit else f"{words} over the instantaneous one")
