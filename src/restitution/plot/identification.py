"""Pictures of identifications: data and fit, residuals, profiles, moduli with bands; comparisons; force maps."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from restitution.checks import Array
from restitution.errors import InputError
from restitution.plot import style
from restitution.quantities import INPUTS, MEASURED, MODULI, RESTITUTION, Quantity, scaled
from restitution.units import LENGTH, MODULUS, in_words

if TYPE_CHECKING:
    import xarray as xr

    from restitution.identification.design import Design
    from restitution.identification.identify import Comparison
    from restitution.identification.observations import Curve
    from restitution.identification.result import Identification
    from restitution.identification.spectrum import Spectrum


_STORAGE, _TANGENT = Quantity("storage", MODULUS, "storage part of $E^*$"), MODULI["loss_tangent"].label("")
_FREQUENCY = f"{MODULI['angular_frequency'].label('rad/s')} (grey: no data)"
_COLORS = (style.BLUE, style.VERMILION, style.GREEN, style.ORANGE, style.SKY_BLUE, style.PURPLE, style.GREY)
_DASHES = ("-", "--", "-.", ":")
_MARKERS = "os^Dv<>"
_MOST_PANELS = 6
# More points have no error bars, and an axis over a larger ratio is logarithmic.
_FEW, _LOG_SPAN = 80, 30.0
# A profile is drawn up to this multiple of the level of its interval.
_ABOVE = 2.0


def overview(result: Identification | Spectrum) -> Figure:
    """Return a page of an identification: data and fit, residuals, profiles (not of a spectrum), moduli with bands."""
    groups: dict[tuple[str, str], list[tuple[str, Curve]]] = {}
    for label, curves in result.curves:
        for curve in curves:
            groups.setdefault((curve.name, curve.x_name), []).append((label, curve))
    # A spectrum has no parameters.
    profiled = hasattr(result, "profile")
    draws: list[Callable[[Axes], Axes]] = [partial(data_and_fit, curves=group) for group in groups.values()][
        :_MOST_PANELS
    ]
    draws.append(partial(residuals, result=result))
    if profiled:
        draws.append(partial(profiles, result=result))
    if all(map(math.isfinite, result.window)):
        draws += [partial(moduli, result=result), partial(loss_tangent, result=result)]
    # An odd number of panels has a wide one first.
    places = [*(["0"] if len(draws) % 2 else []), *map(str, range(len(draws)))]
    mosaic = [places[k : k + 2] for k in range(0, len(places), 2)]
    model = result.problem.space.model.__name__.replace("_", " ") if profiled else "spectrum"
    count = sum(part.size for part in result.residuals)
    title = rf"{model}: {count} data, $\chi^2$/dof = {result.reduced_chi2:.3g}"
    with style.page(mosaic, height=0.5 + 2.5 * len(mosaic), title=title) as (figure, axes):
        for ax, draw in zip(axes, draws, strict=True):
            draw(ax)
    return figure


def comparison(result: Comparison) -> Figure:
    """Return a picture of the moduli and loss tangents of all models that were fitted to the same data."""
    ends = np.array([fit.window for fit in result.results.values()])
    low, high = float(np.nanmin(ends)), float(np.nanmax(ends))
    omega = np.geomspace(0.1 * low, 10.0 * high, 120)
    tables = {name: fit.moduli(omega) for name, fit in result.results.items()}
    band = result.moduli(omega)
    storage = np.concatenate([table["storage_modulus"].to_numpy() for table in tables.values()])
    up = style.axis(_STORAGE, storage)
    with style.page("AB", height=3.4) as (figure, (left, right)):
        for ax, name, by in ((left, "storage_modulus", up.factor), (right, "loss_tangent", 1.0)):
            below, above = (band[f"{name}_{end}"].to_numpy() * by for end in ("low", "high"))
            ax.fill_between(omega, below, above, color=style.BLUE, alpha=0.2, linewidth=0, label="95 % band")
            for n, (model, table) in enumerate(tables.items()):
                weight = result.weights[model]
                size = "weight < 0.001" if weight < 1e-3 else f"weight {weight:.2g}"
                label = model.replace("_", " ") + (f", {size}" if math.isfinite(weight) else "")
                values = table[name].to_numpy() * by
                ax.plot(omega, values, _DASHES[n % 4], color=_COLORS[n % len(_COLORS)], label=label)
        positive = storage[np.isfinite(storage) & (storage > 0.0)] * up.factor
        left.set(yscale="log", ylim=(positive.min() / 2.0, 2.0 * positive.max()))
        # A model that the data exclude may leave the picture.
        plausible = [table for name, table in tables.items() if not result.weights[name] < 0.01]
        right.set_ylim(0.0, 1.4 * max(float(table["loss_tangent"].max(skipna=True)) for table in plausible))
        left.legend(fontsize=7.5)
        style.plain_ticks(_framed(left, low, high, up.label))
        _framed(right, low, high, _TANGENT)
    return figure


def grid(table: xr.Dataset, name: str, *, figure: Figure | None = None) -> Figure:
    """Return a map of one variable of `identify_map` over two dimensions; curves without a value are grey."""
    from matplotlib.ticker import MaxNLocator

    values = table[name]
    if values.ndim != 2:
        raise InputError(name, values.shape, "must be over two dimensions; give shape to identify_map")
    cells = scaled(values)
    with style.page("A", 4.6, 3.8, figure=figure) as (page, (ax,)):
        ax.set_facecolor("#BBBBBB")
        norm = "log" if cells.logarithmic else None
        image = ax.imshow(cells.values, origin="lower", cmap=style.SEQUENTIAL, norm=norm)
        bar = page.colorbar(image, ax=ax, label=cells.label, shrink=0.8)
        if cells.logarithmic:
            bar.ax.yaxis.set_major_formatter("{x:g}")
            bar.ax.yaxis.set_minor_formatter("{x:g}")
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_major_locator(MaxNLocator(integer=True))
        up, across = values.dims
        ax.set(xlabel=f"place along {across}", ylabel=f"place along {up}")
    return page


def design(plan: Design) -> Figure:
    """Return a picture of a design: the chosen impacts, and the errors with one ball and with all."""
    across, up = (style.axis(INPUTS[name], getattr(plan, name)) for name in ("velocity", "radius"))
    title = f"{plan.repeats.sum()} impacts, {plan.criterion}-optimal"
    with style.page("AB", height=3.2, title=title) as (figure, (left, right)):
        left.scatter(plan.velocity * across.factor, plan.radius * up.factor, 30.0 * plan.repeats, color=style.BLUE,
                     alpha=0.5, linewidth=0)  # fmt: skip
        for v, r, n in zip(plan.velocity, plan.radius, plan.repeats, strict=True):
            left.annotate(str(n), (v * across.factor, r * up.factor), ha="center", va="center", fontsize=7.5)
        left.set(xscale="log", yscale="log")
        left.margins(0.15)
        style.plain_ticks(left)
        style.labelled(left, across.label, up.label)
        left.set_title("number of impacts", fontsize=9)
        bars = {f"{in_words(radius, LENGTH.unit)} alone": error for radius, error in plan.one_radius.items()}
        bars["this design"] = plan.largest_error
        finite = {name: 100.0 * error for name, error in bars.items() if math.isfinite(error)}
        colors = [style.ORANGE] * (len(finite) - ("this design" in finite)) + [style.BLUE]
        right.barh(list(finite), list(finite.values()), height=0.6, color=colors[: len(finite)])
        right.set(xscale="log", xlabel="largest standard error of a parameter [%]")
        right.grid(True, axis="x")
        for n, value in enumerate(finite.values()):
            right.annotate(f" {float(f'{value:.2g}'):g} %", (value, n), va="center", fontsize=8)
        low, high = right.get_xlim()
        right.set_xlim(low, high * (high / low) ** 0.25)
    return figure


def data_and_fit(ax: Axes, curves: Sequence[tuple[str, Curve]]) -> Axes:
    """Draw measured values with their standard deviations, and the fit (black), of sets of data with their labels."""
    first = curves[0][1]
    across, up = (
        style.axis(MEASURED[name], np.concatenate([getattr(curve, field) for _, curve in curves]))
        for name, field in ((first.x_name, "x"), (first.name, "measured"))
    )
    for n, (label, curve) in enumerate(curves):
        many, bodies = curve.x.size > _FEW, _bodies(curve)
        # Bodies have markers; they have the colours too where there is one set.
        for k, (body, rows) in enumerate(bodies):
            color = _COLORS[(n if len(curves) > 1 else k) % len(_COLORS)]
            look: dict[str, Any] = {"fmt": "." if many else _MARKERS[k], "markersize": 2 if many else 4}
            words = ", ".join(word for word in (label if len(curves) > 1 else "", body) if word)
            ax.errorbar(
                curve.x[rows] * across.factor, curve.measured[rows] * up.factor,
                None if curve.deviation is None or many else curve.deviation[rows] * up.factor,
                color=color, markerfacecolor="white", elinewidth=0.8, label=words or "measured", **look,
            )  # fmt: skip
        runs = [run for _, rows in bodies for run in np.split(rows, np.flatnonzero(np.diff(curve.x[rows]) <= 0.0) + 1)]
        lines = curve.x.size >= 3 * len(runs)
        for run in runs if lines else [np.arange(curve.x.size)]:
            ax.plot(
                curve.x[run] * across.factor, curve.fitted[run] * up.factor, "-" if lines else "+", color="black",
                linewidth=0.9, zorder=3, label="fit" if n == 0 and run is runs[0] else None,
            )  # fmt: skip
    _scale(ax, curves)
    words = ax.get_legend_handles_labels()[1]
    # Several bodies leave no room for their names among their curves.
    above: Any = {"ncols": len(words), "loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "borderpad": 0.1,
                  "columnspacing": 1.0, "handletextpad": 0.4}  # fmt: skip
    ax.legend(fontsize=7.5, **(above if len(words) > 2 and sum(map(len, words)) < 40 else {}))
    return style.plain_ticks(style.labelled(ax, across.label, up.label))


def _bodies(curve: Curve) -> list[tuple[str, NDArray[np.intp]]]:
    """Name of each body, and its values in their order; a single one without a name if there are too many."""
    if curve.bodies:
        kinds, which = np.unique(np.column_stack([values for _, values in curve.bodies]), axis=0, return_inverse=True)
        if len(kinds) <= len(_MARKERS):
            units = [MEASURED[name].unit for name, _ in curve.bodies]
            names = [", ".join(map(in_words, kind, units)) for kind in kinds]
            return [(name, np.flatnonzero(which.ravel() == k)) for k, name in enumerate(names)]
    return [("", np.arange(curve.x.size))]


def residuals(ax: Axes, result: Identification | Spectrum) -> Axes:
    """Draw the residuals over their standard deviations, in the order of the data."""
    at = 1
    for part, data, color in zip(result.residuals, result.data, _cycled(_COLORS), strict=False):
        ax.plot(np.arange(at, at + part.size), part, ".", color=color, markersize=3 if part.size > _FEW else 5,
                label=data.label)  # fmt: skip
        at += part.size
    ax.axhspan(-2.0, 2.0, color=style.GREY, alpha=0.15, linewidth=0)
    ax.axhline(0.0, color="black", linewidth=0.8)
    most = max((float(np.abs(part).max()) for part in result.residuals if part.size), default=0.0)
    ax.set_ylim(-max(3.0, 1.1 * most), max(3.0, 1.1 * most))
    if (chance := getattr(result, "runs_test", None)) is not None:
        ax.set_title(f"runs test: p = {chance:.2g}", fontsize=9)
    if len(result.data) > 1:
        ax.legend(fontsize=7.5)
    return style.labelled(ax, "number of the value", "residual over its standard deviation")


def profiles(ax: Axes, result: Any) -> Axes:
    """Draw the growth of chi2 over the value of one parameter; those that the data do not determine have none."""
    level = result.uncertainty.quantile() ** 2
    curves: dict[str, tuple[Array, Array]] = {}
    unknown: list[str] = []
    for parameter in result.problem.space.free:
        if all(result.parameters[parameter.name].open_ends):
            unknown.append(parameter.name.replace("_", " "))
            continue
        walked = result.profile(parameter.name)
        z, root = walked.coordinates, np.sqrt(walked.excess)
        best = z[int(np.argmin(root))]
        # The signed root is nearly a straight line.
        dense = np.unique(np.concatenate([z, np.linspace(z[0], z[-1], 200)]))
        height = np.interp(dense, z, np.copysign(root, z - best)) ** 2
        open_end = "" if result.parameters[parameter.name].determined else ", open"
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


def moduli(ax: Axes, result: Identification | Spectrum) -> Axes:
    """Draw the storage and the loss part of E* with 95 % bands, from a decade below to one above the data."""
    table, (low, high) = _table(result)
    central = [table[name].to_numpy() for name in ("storage_modulus", "loss_modulus")]
    up = style.axis(Quantity("modulus", MODULUS, "reduced modulus"), central[0])
    for name, words, color, dash in (
        ("storage_modulus", "storage part $E'$", style.BLUE, "-"),
        ("loss_modulus", "loss part $E''$", style.VERMILION, "--"),
    ):
        _band(ax, table, name, up.factor, color, dash, words)
    # A spectrum has no moduli outside its window.
    positive = np.concatenate([part[part > 0.0] for part in central]) * up.factor
    ax.set(yscale="log", ylim=(positive.min() / 2.0, positive.max() * 2.0))
    ax.legend(fontsize=7.5)
    return style.plain_ticks(_framed(ax, low, high, up.label))


def loss_tangent(ax: Axes, result: Identification | Spectrum) -> Axes:
    """Draw the loss tangent of E* with its 95 % band."""
    table, (low, high) = _table(result)
    _band(ax, table, "loss_tangent", 1.0, style.GREEN, "-", "")
    ax.set_ylim(0.0, 1.5 * float(table["loss_tangent"].max(skipna=True)))
    return _framed(ax, low, high, _TANGENT)


def _table(result: Identification | Spectrum) -> tuple[xr.Dataset, tuple[float, float]]:
    low, high = result.window
    return result.moduli(np.geomspace(0.1 * low, 10.0 * high, 120)), (low, high)


def _band(ax: Axes, table: xr.Dataset, name: str, factor: float, color: str, dash: str, label: str) -> None:
    omega = table["angular_frequency"].to_numpy()
    value, low, high = (table[column].to_numpy() * factor for column in (name, f"{name}_low", f"{name}_high"))
    ax.plot(omega, value, dash, color=color, label=label)
    ax.fill_between(omega, low, np.minimum(high, 1e3 * np.nanmax(value)), color=color, alpha=0.25, linewidth=0)


def _framed(ax: Axes, low: float, high: float, words: str) -> Axes:
    ax.set(xscale="log", xlim=(0.1 * low, 10.0 * high))
    # No data support the moduli beyond the window.
    for start, end in ((0.1 * low, low), (high, 10.0 * high)):
        ax.axvspan(start, end, color=style.GREY, alpha=0.18, linewidth=0)
    return style.labelled(ax, _FREQUENCY, words)


def _scale(ax: Axes, curves: Sequence[tuple[str, Curve]]) -> None:
    """Make axes logarithmic if their values have a wide range."""
    x = np.concatenate([curve.x for _, curve in curves])
    y = np.concatenate([curve.measured for _, curve in curves])
    y = y[np.isfinite(y)]
    if x.min() > 0.0 and x.max() > _LOG_SPAN * x.min():
        ax.set_xscale("log")
    if y.size and y.min() > 0.0 and y.max() > _LOG_SPAN * y.min() and curves[0][1].name != RESTITUTION:
        ax.set_yscale("log")


def _cycled(colors: Sequence[str], rounds: int = 10) -> Sequence[str]:
    return [*colors] * rounds
