"""Panels of a sweep: an output over one axis, over two, or over random draws."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.plot import style
from restitution.plot.labels import RESTITUTION, Values, scaled
from restitution.plot.lines import FEW, contour_map, curve_family, family_colors, markers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

_RESTITUTION_LEVELS = (0.01, 0.02, 0.05, *(round(0.1 * n, 1) for n in range(1, 10)), 0.95, 0.98, 0.99)


def draw_curves(ax: Axes, output: xr.DataArray, x: str, family: str | None = None) -> Axes:
    """Draw an output over one axis, as a family of curves over a second one."""
    values = scaled(output.transpose(*([family] if family else []), x))
    across = _along(ax, output, x)
    _frame(ax, across, values, output.name)
    if family is None:
        ax.plot(across.values, values.values, color=style.BLUE, **markers(across.values.size))
        return ax
    finite = values.values[np.isfinite(values.values)]
    if finite.size and output.name != RESTITUTION:
        low, high = float(finite.min()), float(finite.max())
        margin = 0.05 * (high - low or abs(high) or 1.0)
        ax.set_ylim((low / 1.1, 1.1 * high) if values.logarithmic else (low - margin, high + margin))
    names = _names(output, family)
    # The label on a curve is the value alone; the legend has the symbol and the unit.
    short = [name.rpartition(" = ")[2].split(" ")[0] for name in names]
    curve_family(ax, across.values, values.values, names, short=short if across.values.size > 3 else ())
    ax.legend(loc="best", ncols=2 if output.sizes[family] > 6 else 1, fontsize=7.5)
    return ax


def draw_bands(ax: Axes, output: xr.DataArray, x: str, draws: str) -> Axes:
    """Draw the median of an output over one axis, and the bands of 50 % and 90 % of the draws."""
    values = scaled(output.transpose(draws, x))
    across = _along(ax, output, x)
    _frame(ax, across, values, output.name)
    low, lower, median, upper, high = np.nanquantile(values.values, [0.05, 0.25, 0.5, 0.75, 0.95], axis=0)
    places, look = across.values, markers(across.values.size)
    bands = ((low, high, 0.15, 1.0, "90 % of the draws"), (lower, upper, 0.3, 3.0, "50 %"))
    for bottom, top, alpha, width, words in bands:
        if "linestyle" in look:
            # Few points get bars and no bands, because nothing is computed between them.
            ax.vlines(places, bottom, top, color=style.BLUE, linewidth=width, label=words)
        else:
            ax.fill_between(places, bottom, top, color=style.BLUE, alpha=alpha, linewidth=0, label=words)
    ax.plot(places, median, color=style.BLUE, label="median", **look)
    ax.legend(loc="best")
    return ax


class MapLevels(NamedTuple):
    """Isolines and shading of an output, the same for all its panels.

    The isolines and the ends of the shading are in the unit of the label, that is, SI values times the factor; where
    `logarithmic`, they are decadic logarithms.
    """

    levels: Array
    low: float
    high: float
    factor: float
    label: str
    logarithmic: bool


def map_levels(output: xr.DataArray) -> MapLevels:
    """Choose isolines and shading for all values of an output, whatever its dimensions."""
    values = scaled(output)
    raw = np.asarray(output.values, dtype=np.float64)
    sure = np.isfinite(raw) & (raw != 0.0)
    factor = float((values.values[sure] / raw[sure]).flat[0]) if sure.any() else 1.0
    finite = values.values[np.isfinite(values.values)]
    if output.name == RESTITUTION:
        finite = finite[finite > 0.0]
    logarithmic = values.logarithmic and output.name != RESTITUTION
    if finite.size == 0:
        return MapLevels(np.empty(0), 0.0, 1.0, factor, values.label, logarithmic)
    levels = _levels(output.name, finite, logarithmic)
    low, high = float(finite.min()), float(finite.max())
    if logarithmic:
        levels, low, high = np.log10(levels), float(np.log10(low)), float(np.log10(high))
    return MapLevels(levels, low, high, factor, values.label, logarithmic)


def draw_map(ax: Axes, output: xr.DataArray, x: str, y: str, levels: MapLevels | None = None) -> Axes:
    """Draw labelled isolines of an output over two axes, with a colour bar."""
    from matplotlib.colors import Normalize

    across, up = scaled(output[x]), scaled(output[y])
    ax.set(xscale=across.scale, yscale=up.scale, xlabel=across.label, ylabel=up.label)
    # Isolines need ascending axes.
    order = np.argsort(across.values), np.argsort(up.values)
    shown = map_levels(output) if levels is None else levels
    z = np.asarray(output.transpose(y, x).values, dtype=np.float64)[np.ix_(order[1], order[0])] * shown.factor
    z = np.where(np.isfinite(z), z, np.nan)
    if output.name == RESTITUTION:
        # A captured body has no rebound.
        z = np.where(z == 0.0, np.nan, z)
    if not np.isfinite(z).any():
        ax.set_title(shown.label)
        return ax
    return contour_map(
        ax, across.values[order[0]], up.values[order[1]], np.log10(z) if shown.logarithmic else z,
        list(shown.levels), fmt=_power if shown.logarithmic else "%g", cmap=style.SEQUENTIAL,
        norm=Normalize(shown.low, shown.high), colorbar=shown.label,
    )  # fmt: skip


def draw_histogram(ax: Axes, output: xr.DataArray) -> Axes:
    """Draw the distribution of an output over the draws."""
    values = scaled(output)
    finite = values.values[np.isfinite(values.values)]
    ax.hist(finite, bins=min(60, max(8, int(np.sqrt(finite.size)))), color=style.BLUE, alpha=0.6)
    for share, dashes in ((0.05, ":"), (0.5, "-"), (0.95, ":")):
        if finite.size:
            ax.axvline(float(np.quantile(finite, share)), color="black", linewidth=0.8, linestyle=dashes)
    ax.set(xlabel=values.label, ylabel="draws")
    return ax


def draw_scatter(ax: Axes, output: xr.DataArray, drawn: str) -> Axes:
    """Draw an output over one of the random quantities, a point for each draw."""
    across, values = scaled(output[drawn]), scaled(output)
    look: dict[str, Any] = {"markersize": 2.5, "color": family_colors(3)[1], "alpha": 0.6, "rasterized": True}
    ax.plot(across.values, values.values, ".", **look)
    return style.labelled(ax, across.label, values.label)


def is_numeric(output: xr.DataArray, dimension: str) -> bool:
    """Whether a dimension has numbers along it."""
    return dimension in output.coords and np.issubdtype(output[dimension].dtype, np.number)


def value_name(output: xr.DataArray, dimension: str, place: int) -> str:
    """Return one of the values along a dimension, with symbol and unit."""
    return _names(output, dimension)[place]


def _names(output: xr.DataArray, dimension: str) -> list[str]:
    if not is_numeric(output, dimension):
        return [str(word) for word in output[dimension].values]
    along = scaled(output[dimension])
    return [along.value_label(place) for place in range(along.values.size)]


def _along(ax: Axes, output: xr.DataArray, x: str) -> Values:
    """Values along the abscissa; words are one unit apart."""
    if is_numeric(output, x):
        return scaled(output[x])
    words = [str(word) for word in output[x].values]
    ax.set_xticks(range(len(words)), words)
    label = str(output[x].attrs.get("long_name", x))
    return Values(np.arange(len(words), dtype=np.float64), label, label, "", logarithmic=False)


def _frame(ax: Axes, across: Values, values: Values, name: Any) -> None:
    from matplotlib.ticker import NullFormatter

    ax.set(xscale=across.scale, yscale=values.scale)
    if across.logarithmic and np.nanmax(across.values) >= 9.9 * np.nanmin(across.values):
        # Labels between decades would overlap.
        ax.xaxis.set_minor_formatter(NullFormatter())
    style.labelled(ax, across.label, values.label)
    # Markers at the ends need room.
    if across.values.size > FEW:
        ax.set_xlim(float(np.min(across.values)), float(np.max(across.values)))
    if name == RESTITUTION:
        ax.set_ylim(0.0, 1.02)


def _levels(name: Any, finite: Array, logarithmic: bool) -> Array:
    """Round values for isolines, at least four of them if possible."""
    from matplotlib.ticker import MaxNLocator

    low, high = float(finite.min()), float(finite.max())
    candidates: list[Array] = []
    if name == RESTITUTION:
        candidates.append(np.array(_RESTITUTION_LEVELS))
    elif logarithmic:
        decades = 10.0 ** np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1.0)
        candidates += [decades, np.outer(decades, [1.0, 2.0, 5.0]).ravel()]
    candidates.append(np.asarray(MaxNLocator(8).tick_values(low, high)))
    inside = [levels[(levels > low) & (levels < high)] for levels in candidates]
    return next((levels for levels in inside if levels.size >= 4), inside[-1])


def _power(exponent: float) -> str:
    return f"{10.0**exponent:.3g}"
