"""Relaxation functions over time and frequency, with the data to which one was fitted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from restitution.checks import Array
from restitution.errors import InputError
from restitution.material.fit import CreepTable, DynamicTable, Measured, RelaxationTable
from restitution.material.master_curve import Curve, Isotherms, MasterCurve
from restitution.material.prony import PronySeries
from restitution.material.shift import ShiftTable
from restitution.material.viscoelastic import Material, reduced_modulus
from restitution.plot import style
from restitution.quantities import INPUTS, MEASURED, MODULI, Quantity
from restitution.units import MODULUS, ZERO_CELSIUS, scaled_unit

_TIME, _FREQUENCY = (quantity.label(quantity.unit) for quantity in (MEASURED["time"], MODULI["angular_frequency"]))
_TEMPERATURE, _SHIFT = INPUTS["temperature"]._replace(symbol="").label("°C"), r"$\log_{10} a_T$"
_REDUCED = Quantity("reduced_modulus", MODULUS, "reduced modulus", "$E^*$")
_COLORS = (style.BLUE, style.VERMILION, style.GREEN, style.ORANGE)


def relaxation(
    ax: Axes,
    series: Mapping[str, PronySeries],
    window: tuple[float, float],
    data: RelaxationTable | None = None,
    *,
    unit: str = MODULUS.unit,
) -> Axes:
    """Draw relaxation moduli over a window of time [s], and the data to which one was fitted.

    The unit is empty for moduli that are shares of the instantaneous one.
    """
    t = np.geomspace(*window, 400)
    curves = {name: np.asarray(part.relaxation_modulus(t)) for name, part in series.items()}
    factor, prefixed = scaled_unit(np.concatenate(list(curves.values())), unit)
    if data is not None:
        ax.plot(data.time, data.modulus * factor, ".", color=style.GREY, markersize=4, label="data")
    for color, (name, curve) in zip(_COLORS, curves.items(), strict=False):
        ax.plot(t, curve * factor, color=color, label=name if unit or len(series) > 1 else None)
    return _finished(ax, _TIME, "relaxation modulus", prefixed)


def dynamic(
    ax: Axes,
    series: Mapping[str, PronySeries],
    window: tuple[float, float],
    data: DynamicTable | None = None,
    *,
    unit: str = MODULUS.unit,
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
    storage = {name: np.asarray(part.storage_modulus(omega)) for name, part in series.items()}
    factor, prefixed = scaled_unit(np.concatenate(list(storage.values())), unit)
    if data is not None:
        for values, mark in ((data.storage_modulus, "."), (data.loss_modulus, "x")):
            ax.plot(data.angular_frequency, values * factor, mark, color=style.GREY, markersize=4)
    for color, (name, part) in zip(_COLORS, series.items(), strict=False):
        # The label of the axis names a single series of shares.
        words = f"{name}, " if unit or len(series) > 1 else ""
        ax.plot(omega, storage[name] * factor, color=color, label=f"{words}storage")
        loss = np.asarray(part.loss_modulus(omega)) * factor
        ax.plot(omega, np.where(loss > 0, loss, np.nan), "--", color=color, label=f"{words}loss")
    return _finished(ax, _FREQUENCY, "modulus", prefixed)


def creep(
    ax: Axes, series: Mapping[str, PronySeries], window: tuple[float, float], data: CreepTable | None = None
) -> Axes:
    """Draw creep compliances over a window of time [s], and the data to which one was fitted."""
    t = np.geomspace(*window, 400)
    curves = {name: np.asarray(part.creep_compliance(t)) for name, part in series.items()}
    # A compliance has the reciprocal unit of a modulus.
    factor, prefixed = scaled_unit([1.0 / curve[-1] for curve in curves.values()], MODULUS.unit)
    if data is not None:
        ax.plot(data.time, data.compliance / factor, ".", color=style.GREY, markersize=4, label="data")
    for color, (name, curve) in zip(_COLORS, curves.items(), strict=False):
        ax.plot(t, curve / factor, color=color, label=name)
    return _finished(ax, _TIME, "creep compliance", f"1/{prefixed}")


def overview(
    series: Mapping[str, PronySeries],
    window: tuple[float, float] | None = None,
    data: Measured | None = None,
    *,
    unit: str = MODULUS.unit,
) -> Figure:
    """Return a figure of the relaxation moduli over time and the complex ones over frequency, of at most four series.

    Where the data are of creep, the compliances take the place of the relaxation moduli.

    The window of times [s] reaches a decade beyond all relaxation times by default. The unit is empty for shares of
    the instantaneous modulus.
    """
    if window is None:
        times = np.concatenate([part.relaxation_times for part in series.values()] or [np.empty(0)])
        window = (0.1 * float(times.min()), 10.0 * float(times.max())) if times.size else (1e-6, 1.0)
    with style.page("AB", height=3.2) as (figure, (left, right)):
        if isinstance(data, CreepTable):
            creep(left, series, window, data)
        else:
            relaxation(left, series, window, data if isinstance(data, RelaxationTable) else None, unit=unit)
        dynamic(right, series, window, data if isinstance(data, DynamicTable) else None, unit=unit)
    return figure


def shift_factors(table: ShiftTable) -> Figure:
    """Return a figure of shift factors over temperature."""
    with style.page("A", style.COLUMN_WIDTH, 3.0) as (figure, (ax,)):
        ax.plot(table.temperatures - ZERO_CELSIUS, table.log10_factors, ".-", color=style.BLUE)
        ax.set(xlabel=_TEMPERATURE, ylabel=_SHIFT)
    return figure


def bounce_moduli(table: Any, data: DynamicTable | Material | None = None, poisson_ratio: float = 0.5) -> Figure:
    """Return a figure of the moduli of bounces or oscillations, on top of those of a DMA table or a material.

    The moduli of a table in shear or tension are converted with a constant Poisson ratio.
    """
    measured = np.isfinite(table.storage_modulus)
    if not np.any(measured):
        rule = "need a contact time or a peak force: without, the loss tangents have no frequency"
        raise InputError("rebounds", rule=rule)
    omega, storage = table.angular_frequency[measured], table.storage_modulus[measured]
    curve = None if data is None else _reduced(data, omega, poisson_ratio)
    factor, _, up = style.axis(_REDUCED, storage)
    with style.page("AB", height=3.2) as (figure, (left, right)):
        if curve is not None:
            points, moduli = curve
            style_of = "-" if isinstance(data, Material) else ".-"
            for values, color, label in ((moduli.real, style.BLUE, "storage"), (moduli.imag, style.VERMILION, "loss")):
                left.plot(points, values * factor, style_of, color=color, markersize=3, linewidth=0.8, label=label)
            right.plot(points, moduli.imag / moduli.real, style_of, color=style.GREEN, markersize=3, linewidth=0.8)
        for ax, name, color in (
            (left, "storage_modulus", style.BLUE),
            (left, "loss_modulus", style.VERMILION),
            (right, "loss_tangent", style.GREEN),
        ):
            scale = 1.0 if ax is right else factor
            values = getattr(table, name)[measured] * scale
            error = np.nan_to_num(getattr(table, f"{name}_error")[measured]) * scale
            label = f"{MODULI[name].words}, {table.points}"
            ax.errorbar(omega, values, error, fmt="o", color=color, markersize=4, markerfacecolor="white", label=label)
        left.set(yscale="log")
        for ax, words in ((left, up), (right, MODULI["loss_tangent"].label(""))):
            ax.set(xscale="log")
            ax.legend()
            style.plain_ticks(style.labelled(ax, _FREQUENCY, words))
        right.set_ylim(bottom=0.0)
    return figure


def _reduced(
    data: DynamicTable | Material, omega: Array, poisson_ratio: float
) -> tuple[Array, NDArray[np.complex128]]:
    """Return the frequencies and reduced moduli of a table, or of a material a factor of ten about the frequencies."""
    if isinstance(data, Material):
        points, series = np.geomspace(0.1 * omega.min(), 10.0 * omega.max(), 200), reduced_modulus(data)
        return points, np.asarray(series.storage_modulus(points) + 1j * series.loss_modulus(points))
    factors = {"shear": 2.0 / (1.0 - poisson_ratio), "tension": 1.0 / (1.0 - poisson_ratio**2), None: 1.0}
    return data.angular_frequency, factors[data.deformation] * (data.storage_modulus + 1j * data.loss_modulus)


def isotherms(measured: Isotherms) -> Figure:
    """Return a figure of the moduli at each temperature."""
    with style.page("A", style.COLUMN_WIDTH, 3.2) as (figure, (ax,)):
        _curves(ax, measured.tables, measured.temperatures)
    return figure


def superposition(curve: MasterCurve) -> Figure:
    """Return a figure of the isotherms, of the master curve, and of the shifts with their standard errors."""
    kelvin = curve.temperatures
    with style.page("ABC", height=3.0) as (figure, (left, middle, right)):
        _curves(left, curve.isotherms.tables, kelvin)
        _curves(middle, curve.reduced, kelvin, reduced=True)
        middle.set_title(f"at {curve.reference_temperature - ZERO_CELSIUS:.4g} °C", fontsize=9)
        determined = np.isfinite(curve.errors)
        celsius = kelvin - ZERO_CELSIUS
        errors = np.where(determined, curve.errors, 0.0)
        right.errorbar(celsius, curve.log10_factors, errors, fmt=".", color=style.BLUE, capsize=2, label="shift")
        if not determined.all():
            right.plot(celsius[~determined], curve.log10_factors[~determined], "o", mfc="none", color=style.VERMILION,
                       label="not determined")  # fmt: skip
        if curve.law != "free":
            law, fine = curve.shift, np.linspace(kelvin[0], kelvin[-1], 200)
            factors = [law.factor(temperature) for temperature in fine.tolist()]
            right.plot(fine - ZERO_CELSIUS, np.log10(factors), color=style.BLUE, linewidth=0.8)
        if np.any(curve.vertical_errors > 0.0):
            right.errorbar(celsius, curve.log10_vertical_factors, curve.vertical_errors, fmt="x",
                           color=style.GREEN, markersize=3, label="vertical")  # fmt: skip
        if len(right.get_legend_handles_labels()[0]) > 1:
            right.legend()
        style.labelled(right, _TEMPERATURE, _SHIFT)
    return figure


def _curves(ax: Axes, tables: Sequence[Curve], kelvin: Array, *, reduced: bool = False) -> None:
    """Draw moduli at each temperature: storage or relaxation modulus as dots, loss modulus as crosses."""
    from matplotlib import colormaps

    colors = colormaps["plasma"](0.85 * (kelvin - kelvin[0]) / (kelvin[-1] - kelvin[0]))
    dynamic_ = isinstance(tables[0], DynamicTable)
    first = [table.storage_modulus if isinstance(table, DynamicTable) else table.modulus for table in tables]
    factor, prefixed = scaled_unit(np.concatenate(first), MODULUS.unit)
    for place, (table, color) in enumerate(zip(tables, colors, strict=True)):
        # The colour bar would take the room of a panel.
        label = f"{kelvin[place] - ZERO_CELSIUS:.4g} °C" if place in (0, len(tables) - 1) else None
        x = table.angular_frequency if isinstance(table, DynamicTable) else table.time
        ax.plot(x, first[place] * factor, ".", color=color, markersize=3, label=label)
        if isinstance(table, DynamicTable):
            loss = np.where(table.loss_modulus > 0.0, table.loss_modulus, np.nan)
            ax.plot(x, loss * factor, "x", color=color, markersize=2.5, markeredgewidth=0.6)
    words = "storage (dots) and loss modulus (crosses)" if dynamic_ else "relaxation modulus"
    frequency = r"$\omega a_T$ [rad/s]" if reduced else _FREQUENCY
    time = "$t/a_T$ [s]" if reduced else _TIME
    ax.set(xscale="log", yscale="log")
    ax.legend(handletextpad=0.2)
    style.labelled(ax, frequency if dynamic_ else time, f"{words} [{prefixed}]")


def _finished(ax: Axes, x: str, words: str, unit: str) -> Axes:
    ax.set(xscale="log", yscale="log")
    if ax.get_legend_handles_labels()[0]:
        ax.legend()
    style.plain_ticks(ax)
    return style.labelled(ax, x, f"{words} [{unit}]" if unit else f"{words} over the instantaneous one")
