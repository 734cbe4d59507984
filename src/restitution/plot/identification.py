"""Pictures of identifications: data and fit, residuals, profiles, moduli with bands; comparisons; force maps."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from restitution.display import in_words, scaled_unit
from restitution.errors import InputError
from restitution.plot import style
from restitution.plot.labels import RESTITUTION, quantity_label, scaled
from restitution.quantities import HISTORY, INPUTS, MODULI, OUTPUTS

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from restitution.identification.comparison import Comparison
    from restitution.identification.design import Design
    from restitution.identification.observations import Curve
    from restitution.identification.result import Identification
    from restitution.identification.spectrum import Spectrum

Array = NDArray[np.float64]

_REGISTRY = {**INPUTS, **OUTPUTS, **HISTORY, **MODULI}
# Words and units of measured quantities that are not in the registry, or have other words there.
_MEASURED = {
    "time": ("time $t$", "s"),
    "touch_time": ("time of the touch", "s"),
    "interval": ("time to the next touch", "s"),
    "modulus": ("relaxation modulus", "Pa"),
    "depth": ("depth $d$", "m"),
    "acceleration": ("deceleration", "m/s^2"),
}
_COLORS = (style.BLUE, style.VERMILION, style.GREEN, style.ORANGE, style.SKY_BLUE, style.PURPLE, style.GREY)
_DASHES = ("-", "--", "-.", ":")
_MARKERS = "os^Dv<>"
_MOST_PANELS = 6
# More points have no error bars, and an axis over a larger ratio is logarithmic.
_FEW, _LOG_SPAN = 80, 30.0
# A profile is drawn up to this multiple of the level of its interval.
_ABOVE = 2.0


def overview(found: Identification | Spectrum) -> Figure:
    """Return a page of an identification: data and fit, residuals, profiles (not of a spectrum), moduli with bands."""
    groups: dict[tuple[str, str], list[tuple[str, Curve]]] = {}
    for label, curves in found.curves:
        for curve in curves:
            groups.setdefault((curve.name, curve.x_name), []).append((label, curve))
    problem: Any = getattr(found, "problem", None)
    draws: list[Callable[[Axes], Axes]] = [partial(data_and_fit, curves=one) for one in groups.values()][:_MOST_PANELS]
    draws.append(partial(residuals, found=found))
    if problem is not None:
        draws.append(partial(profiles, found=found))
    if all(map(math.isfinite, found.window)):
        draws += [partial(moduli, found=found), partial(loss_tangent, found=found)]
    # An odd number of panels has a wide one first.
    places = [*(["0"] if len(draws) % 2 else []), *map(str, range(len(draws)))]
    mosaic = [places[k : k + 2] for k in range(0, len(places), 2)]
    with style.context():
        figure, axes = style.panels(mosaic, height=0.5 + 2.5 * len(mosaic))
        for ax, draw in zip(axes, draws, strict=True):
            draw(ax)
        model = "spectrum" if problem is None else problem.space.model.__name__.replace("_", " ")
        count = sum(part.size for part in found.residuals)
        return style.finish(figure, rf"{model}: {count} data, $\chi^2$/dof = {found.reduced_chi2:.3g}")


def comparison(found: Comparison) -> Figure:
    """Return a picture of the moduli and loss tangents of all models that were fitted to the same data."""
    ends = np.array([one.window for one in found.results.values()])
    low, high = float(np.nanmin(ends)), float(np.nanmax(ends))
    omega = np.geomspace(0.1 * low, 10.0 * high, 120)
    tables = {name: one.moduli(omega) for name, one in found.results.items()}
    band = found.moduli(omega)
    storage = np.concatenate([table["storage_modulus"].to_numpy() for table in tables.values()])
    factor, unit = scaled_unit(storage, "Pa")
    with style.context():
        figure, (left, right) = style.panels("AB", height=3.4)
        for ax, name, by in ((left, "storage_modulus", factor), (right, "loss_tangent", 1.0)):
            below, above = (band[f"{name}_{end}"].to_numpy() * by for end in ("low", "high"))
            ax.fill_between(omega, below, above, color=style.BLUE, alpha=0.2, linewidth=0, label="95 % band")
            for n, (model, table) in enumerate(tables.items()):
                weight = found.weights[model]
                size = "weight < 0.001" if weight < 1e-3 else f"weight {weight:.2g}"
                label = model.replace("_", " ") + (f", {size}" if math.isfinite(weight) else "")
                values = table[name].to_numpy() * by
                ax.plot(omega, values, _DASHES[n % 4], color=_COLORS[n % len(_COLORS)], label=label)
        known = storage[np.isfinite(storage) & (storage > 0.0)] * factor
        left.set(yscale="log", ylim=(known.min() / 2.0, 2.0 * known.max()))
        # A model that the data exclude may leave the picture.
        plausible = [table for name, table in tables.items() if not found.weights[name] < 0.01]
        right.set_ylim(0.0, 1.4 * max(float(table["loss_tangent"].max(skipna=True)) for table in plausible))
        left.legend(fontsize=7.5)
        style.plain_ticks(_framed(left, low, high, f"storage part of $E^*$ [{unit}]"))
        _framed(right, low, high, r"loss tangent $\tan\delta$")
        return style.finish(figure)


def grid(table: xr.Dataset, name: str, *, figure: Figure | None = None) -> Figure:
    """Return a map of one variable of `identify_map` over two dimensions; curves without a value are grey."""
    from matplotlib.ticker import MaxNLocator

    values = table[name]
    if values.ndim != 2:
        raise InputError(name, values.shape, "must be over two dimensions; give shape to identify_map")
    one = scaled(values)
    with style.context():
        page, (ax,) = style.panels("A", 4.6, 3.8, figure=figure)
        ax.set_facecolor("#BBBBBB")
        image = ax.imshow(one.values, origin="lower", cmap=style.SEQUENTIAL, norm="log" if one.logarithmic else None)
        bar = page.colorbar(image, ax=ax, label=one.label, shrink=0.8)
        if one.logarithmic:
            bar.ax.yaxis.set_major_formatter("{x:g}")
            bar.ax.yaxis.set_minor_formatter("{x:g}")
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_major_locator(MaxNLocator(integer=True))
        up, across = values.dims
        ax.set(xlabel=f"place along {across}", ylabel=f"place along {up}")
        return style.finish(page)


def design(found: Design) -> Figure:
    """Return a picture of a design: the chosen impacts, and the errors with one ball and with all."""
    across, up = scaled_unit(found.velocity, "m/s"), scaled_unit(found.radius, "m")
    with style.context():
        figure, (left, right) = style.panels("AB", height=3.2)
        left.scatter(found.velocity * across.factor, found.radius * up.factor, 30.0 * found.repeats, color=style.BLUE,
                     alpha=0.5, linewidth=0)  # fmt: skip
        for v, r, n in zip(found.velocity, found.radius, found.repeats, strict=True):
            left.annotate(str(n), (v * across.factor, r * up.factor), ha="center", va="center", fontsize=7.5)
        left.set(xscale="log", yscale="log")
        left.margins(0.15)
        style.plain_ticks(left)
        style.labelled(left, quantity_label("velocity", across.unit), quantity_label("radius", up.unit))
        left.set_title("number of impacts", fontsize=9)
        bars = {f"{in_words(radius, 'm')} alone": error for radius, error in found.one_radius.items()}
        bars["this design"] = found.largest_error
        known = {name: 100.0 * error for name, error in bars.items() if math.isfinite(error)}
        colors = [style.ORANGE] * (len(known) - ("this design" in known)) + [style.BLUE]
        right.barh(list(known), list(known.values()), height=0.6, color=colors[: len(known)])
        right.set(xscale="log", xlabel="largest standard error of a parameter [%]")
        right.grid(True, axis="x")
        for n, value in enumerate(known.values()):
            right.annotate(f" {float(f'{value:.2g}'):g} %", (value, n), va="center", fontsize=8)
        low, high = right.get_xlim()
        right.set_xlim(low, high * (high / low) ** 0.25)
        return style.finish(figure, f"{found.repeats.sum()} impacts, {found.criterion}-optimal")


def data_and_fit(ax: Axes, curves: Sequence[tuple[str, Curve]]) -> Axes:
    """Draw measured values with their standard deviations, and the fit (black), of sets of data with their labels."""
    first = curves[0][1]
    (across, x_label), (up, y_label) = (
        _axis(name, np.concatenate([getattr(one, field) for _, one in curves]))
        for name, field in ((first.x_name, "x"), (first.name, "measured"))
    )
    for n, (label, one) in enumerate(curves):
        many, bodies = one.x.size > _FEW, _bodies(one)
        # Bodies have markers; they have the colours too where there is one set.
        for k, (body, rows) in enumerate(bodies):
            color = _COLORS[(n if len(curves) > 1 else k) % len(_COLORS)]
            look: dict[str, Any] = {"fmt": "." if many else _MARKERS[k], "markersize": 2 if many else 4}
            words = ", ".join(word for word in (label if len(curves) > 1 else "", body) if word)
            ax.errorbar(
                one.x[rows] * across, one.measured[rows] * up,
                None if one.deviation is None or many else one.deviation[rows] * up,
                color=color, markerfacecolor="white", elinewidth=0.8, label=words or "measured", **look,
            )  # fmt: skip
        runs = [run for _, rows in bodies for run in np.split(rows, np.flatnonzero(np.diff(one.x[rows]) <= 0.0) + 1)]
        lines = one.x.size >= 3 * len(runs)
        for run in runs if lines else [np.arange(one.x.size)]:
            ax.plot(
                one.x[run] * across, one.fitted[run] * up, "-" if lines else "+", color="black", linewidth=0.9,
                zorder=3, label="fit" if n == 0 and run is runs[0] else None,
            )  # fmt: skip
    _scale(ax, curves)
    words = ax.get_legend_handles_labels()[1]
    # Several bodies leave no room for their names among their curves.
    above: Any = {"ncols": len(words), "loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "borderpad": 0.1,
                  "columnspacing": 1.0, "handletextpad": 0.4}  # fmt: skip
    ax.legend(fontsize=7.5, **(above if len(words) > 2 and sum(map(len, words)) < 40 else {}))
    return style.plain_ticks(style.labelled(ax, x_label, y_label))


def _bodies(one: Curve) -> list[tuple[str, NDArray[np.intp]]]:
    """Name of each body, and its values in their order; a single one without a name if there are too many."""
    if one.bodies:
        kinds, which = np.unique(np.column_stack([values for _, values in one.bodies]), axis=0, return_inverse=True)
        if len(kinds) <= len(_MARKERS):
            names = [
                ", ".join(
                    in_words(value, INPUTS[name].unit) for (name, _), value in zip(one.bodies, kind, strict=True)
                )
                for kind in kinds
            ]
            return [(name, np.flatnonzero(which.ravel() == k)) for k, name in enumerate(names)]
    return [("", np.arange(one.x.size))]


def residuals(ax: Axes, found: Identification | Spectrum) -> Axes:
    """Draw the residuals over their standard deviations, in the order of the data."""
    at = 1
    for part, one, color in zip(found.residuals, found.data, _cycled(_COLORS), strict=False):
        ax.plot(np.arange(at, at + part.size), part, ".", color=color, markersize=3 if part.size > _FEW else 5,
                label=one.label)  # fmt: skip
        at += part.size
    ax.axhspan(-2.0, 2.0, color=style.GREY, alpha=0.15, linewidth=0)
    ax.axhline(0.0, color="black", linewidth=0.8)
    most = max((float(np.abs(part).max()) for part in found.residuals if part.size), default=0.0)
    ax.set_ylim(-max(3.0, 1.1 * most), max(3.0, 1.1 * most))
    if (chance := getattr(found, "runs_test", None)) is not None:
        ax.set_title(f"runs test: p = {chance:.2g}", fontsize=9)
    if len(found.data) > 1:
        ax.legend(fontsize=7.5)
    return style.labelled(ax, "number of the value", "residual over its standard deviation")


def profiles(ax: Axes, found: Any) -> Axes:
    """Draw the growth of chi2 over the value of one parameter; those that the data do not determine have none."""
    level = found.uncertainty.quantile() ** 2
    curves: dict[str, tuple[Array, Array]] = {}
    unknown: list[str] = []
    for parameter in found.problem.space.free:
        if all(found.parameters[parameter.name].open_ends):
            unknown.append(parameter.name.replace("_", " "))
            continue
        walked = found.profile(parameter.name)
        z, root = walked.coordinates, np.sqrt(walked.excess)
        best = z[int(np.argmin(root))]
        # The signed root is nearly a straight line.
        dense = np.unique(np.concatenate([z, np.linspace(z[0], z[-1], 200)]))
        height = np.interp(dense, z, np.copysign(root, z - best)) ** 2
        open_end = "" if found.parameters[parameter.name].determined else ", open"
        ratio = parameter.outward(dense) / parameter.outward(best)
        curves[parameter.name.replace("_", " ") + open_end] = ratio, height
    narrow = all(ratio[0] > 0.5 and ratio[-1] < 2.0 for ratio, _ in curves.values())
    for n, ((name, (ratio, height)), color) in enumerate(zip(curves.items(), _cycled(_COLORS), strict=False)):
        x = 100.0 * (ratio - 1.0) if narrow else ratio
        ax.plot(x, height, _DASHES[n // len(_COLORS) % 4], color=color, label=name)
    ax.axhline(level, color="black", linewidth=0.8, linestyle="--")
    ax.set(xscale="linear" if narrow else "log", ylim=(0.0, _ABOVE * level))
    for name in unknown:
        ax.plot([], [], " ", label=f"{name}: not determined")
    if not curves:
        ax.set_xticks([])
    ax.legend(fontsize=7.5, loc="upper center")
    words = "change from the best value [%]" if narrow else "value over best value"
    return style.labelled(style.plain_ticks(ax), words, r"growth of $\chi^2$ (dashed: 95 %)")


def moduli(ax: Axes, found: Identification | Spectrum) -> Axes:
    """Draw the storage and the loss part of E* with 95 % bands, from a decade below to one above the data."""
    table, (low, high) = _table(found)
    central = [table[name].to_numpy() for name in ("storage_modulus", "loss_modulus")]
    factor, unit = scaled_unit(central[0], "Pa")
    for name, words, color, dash in (
        ("storage_modulus", "storage part $E'$", style.BLUE, "-"),
        ("loss_modulus", "loss part $E''$", style.VERMILION, "--"),
    ):
        _band(ax, table, name, factor, color, dash, words)
    # A spectrum has no moduli outside its window.
    positive = np.concatenate([one[one > 0.0] for one in central]) * factor
    ax.set(yscale="log", ylim=(positive.min() / 2.0, positive.max() * 2.0))
    ax.legend(fontsize=7.5)
    return style.plain_ticks(_framed(ax, low, high, f"reduced modulus [{unit}]"))


def loss_tangent(ax: Axes, found: Identification | Spectrum) -> Axes:
    """Draw the loss tangent of E* with its 95 % band."""
    table, (low, high) = _table(found)
    _band(ax, table, "loss_tangent", 1.0, style.GREEN, "-", "")
    ax.set_ylim(0.0, 1.5 * float(table["loss_tangent"].max(skipna=True)))
    return _framed(ax, low, high, r"loss tangent $\tan\delta$")


def _table(found: Identification | Spectrum) -> tuple[xr.Dataset, tuple[float, float]]:
    low, high = found.window
    return found.moduli(np.geomspace(0.1 * low, 10.0 * high, 120)), (low, high)


def _band(ax: Axes, table: xr.Dataset, name: str, factor: float, color: str, dash: str, label: str) -> None:
    omega = table["angular_frequency"].to_numpy()
    value, low, high = (table[one].to_numpy() * factor for one in (name, f"{name}_low", f"{name}_high"))
    ax.plot(omega, value, dash, color=color, label=label)
    ax.fill_between(omega, low, np.minimum(high, 1e3 * np.nanmax(value)), color=color, alpha=0.25, linewidth=0)


def _framed(ax: Axes, low: float, high: float, words: str) -> Axes:
    ax.set(xscale="log", xlim=(0.1 * low, 10.0 * high))
    # No data support the moduli beyond the window.
    for start, end in ((0.1 * low, low), (high, 10.0 * high)):
        ax.axvspan(start, end, color=style.GREY, alpha=0.18, linewidth=0)
    return style.labelled(ax, r"angular frequency $\omega$ [rad/s] (grey: no data)", words)


def _axis(name: str, values: Array) -> tuple[float, str]:
    """Factor from SI to the unit of an axis, and its label."""
    words, unit = _MEASURED.get(name, ("", ""))
    if not words:
        known = _REGISTRY[name]
        factor, prefixed = scaled_unit(values, known.unit)
        return factor, quantity_label(name, prefixed)
    factor, prefixed = scaled_unit(values, unit)
    return factor, f"{words} [{prefixed}]"


def _scale(ax: Axes, curves: Sequence[tuple[str, Curve]]) -> None:
    """Logarithmic axes if the values have a wide range."""
    x = np.concatenate([one.x for _, one in curves])
    y = np.concatenate([one.measured for _, one in curves])
    y = y[np.isfinite(y)]
    if x.min() > 0.0 and x.max() > _LOG_SPAN * x.min():
        ax.set_xscale("log")
    if y.size and y.min() > 0.0 and y.max() > _LOG_SPAN * y.min() and curves[0][1].name != RESTITUTION:
        ax.set_yscale("log")


def _cycled(colors: Sequence[str], rounds: int = 10) -> Sequence[str]:
    return [*colors] * rounds
