"""Panels of a sweep: an output over one axis, over two, or over random draws."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from restitution.plot import style
from restitution.plot.contours import contour_map
from restitution.plot.curves import curve_family, family_colors
from restitution.plot.quantity import RESTITUTION, Quantity, quantity

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

_RESTITUTION_LEVELS = (0.01, 0.02, 0.05, *(round(0.1 * n, 1) for n in range(1, 10)), 0.95, 0.98, 0.99)


def draw_curves(ax: Axes, output: xr.DataArray, x: str, family: str | None = None) -> Axes:
    """Draw an output over one axis, as a family of curves over a second one.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    output : xarray.DataArray
        Over `x` and, if given, `family`.
    x, family : str
        Names of dimensions.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`.
    """
    values = quantity(output.transpose(*([family] if family else []), x))
    _frame(ax, _along(ax, output, x), values, output.name)
    places = _places(output, x)
    if family is None:
        ax.plot(places, values.values, color=style.BLUE, marker="o" if places.size < 3 else None)
    else:
        curve_family(ax, places, values.values, _names(output, family))
        ax.legend(loc="best", ncols=2 if output.sizes[family] > 6 else 1, fontsize=7.5)
    return ax


def draw_bands(ax: Axes, output: xr.DataArray, x: str, draws: str) -> Axes:
    """Draw the median of an output over one axis, and the bands of 50 % and 90 % of the draws.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    output : xarray.DataArray
        Over `x` and `draws`.
    x, draws : str
        Names of dimensions.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`.
    """
    values = quantity(output.transpose(draws, x))
    _frame(ax, _along(ax, output, x), values, output.name)
    low, lower, median, upper, high = np.nanquantile(values.values, [0.05, 0.25, 0.5, 0.75, 0.95], axis=0)
    places = _places(output, x)
    ax.fill_between(places, low, high, color=style.BLUE, alpha=0.15, linewidth=0, label="90 % of the draws")
    ax.fill_between(places, lower, upper, color=style.BLUE, alpha=0.3, linewidth=0, label="50 %")
    ax.plot(places, median, color=style.BLUE, label="median")
    ax.legend(loc="best")
    return ax


def draw_map(ax: Axes, output: xr.DataArray, x: str, y: str) -> Axes:
    """Draw labelled isolines of an output over two axes.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    output : xarray.DataArray
        Over `x` and `y`.
    x, y : str
        Names of dimensions with numbers.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`.
    """
    from matplotlib.colors import Normalize

    across, up = quantity(output[x]), quantity(output[y])
    ax.set_xscale("log" if across.logarithmic else "linear")
    ax.set_yscale("log" if up.logarithmic else "linear")
    ax.set_xlabel(across.label)
    ax.set_ylabel(up.label)
    # Isolines want ascending axes.
    order = np.argsort(across.values), np.argsort(up.values)
    values = quantity(output.transpose(y, x))
    z = values.values[np.ix_(order[1], order[0])]
    norm = Normalize(0.0, 1.0) if output.name == RESTITUTION else None
    fmt: Any = "%g"
    if output.name == RESTITUTION:
        # Where the body stays, there is no rebound to be graded.
        z = np.where(z == 0.0, np.nan, z)
    levels = _levels(output.name, z, values.logarithmic)
    if values.logarithmic and output.name != RESTITUTION:
        z, levels, fmt = np.log10(z), np.log10(levels), _power
    ax.set_title(values.label)
    if not np.isfinite(z).any():
        return ax
    return contour_map(
        ax,
        across.values[order[0]],
        up.values[order[1]],
        z,
        list(levels),
        fmt=fmt,
        cmap=style.SEQUENTIAL,
        norm=norm,
    )


def draw_histogram(ax: Axes, output: xr.DataArray) -> Axes:
    """Draw how the draws of an output are distributed.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    output : xarray.DataArray
        Over the draws.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`.
    """
    values = quantity(output)
    finite = values.values[np.isfinite(values.values)]
    ax.hist(finite, bins=min(60, max(8, int(np.sqrt(finite.size)))), color=style.BLUE, alpha=0.6)
    for share, dashes in ((0.05, ":"), (0.5, "-"), (0.95, ":")):
        if finite.size:
            ax.axvline(float(np.quantile(finite, share)), color="black", linewidth=0.8, linestyle=dashes)
    ax.set_xlabel(values.label)
    ax.set_ylabel("draws")
    return ax


def draw_scatter(ax: Axes, output: xr.DataArray, drawn: str) -> Axes:
    """Draw an output over one of the quantities drawn, a point for each draw.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    output : xarray.DataArray
        Over the draws.
    drawn : str
        Name of the quantity.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`.
    """
    across, values = quantity(output[drawn]), quantity(output)
    ax.plot(
        across.values,
        values.values,
        ".",
        markersize=2.5,
        color=family_colors(3)[1],
        alpha=0.6,
        rasterized=True,
    )
    ax.set_xlabel(across.label)
    ax.set_ylabel(values.label)
    return ax


def is_numeric(output: xr.DataArray, dimension: str) -> bool:
    """Whether a dimension has numbers along it, rather than words or nothing."""
    return dimension in output.coords and np.issubdtype(output[dimension].dtype, np.number)


def value_name(output: xr.DataArray, dimension: str, place: int) -> str:
    """Return one of the values along a dimension in words."""
    return _names(output, dimension)[place]


def _names(output: xr.DataArray, dimension: str) -> list[str]:
    if not is_numeric(output, dimension):
        return [str(word) for word in output[dimension].values]
    along = quantity(output[dimension])
    return [along.value_label(place) for place in range(along.values.size)]


def _places(output: xr.DataArray, x: str) -> Array:
    return (
        quantity(output[x]).values if is_numeric(output, x) else np.arange(output.sizes[x], dtype=np.float64)
    )


def _along(ax: Axes, output: xr.DataArray, x: str) -> Quantity:
    """Prepare the abscissa."""
    if is_numeric(output, x):
        return quantity(output[x])
    words = [str(word) for word in output[x].values]
    ax.set_xticks(range(len(words)), words)
    label = str(output[x].attrs.get("long_name", x))
    return Quantity(np.arange(len(words), dtype=np.float64), label, label, "", logarithmic=False)


def _frame(ax: Axes, across: Quantity, values: Quantity, name: Any) -> None:
    ax.set_xscale("log" if across.logarithmic else "linear")
    ax.set_yscale("log" if values.logarithmic else "linear")
    ax.set_xlabel(across.label)
    ax.set_ylabel(values.label)
    ax.grid(True)
    if across.values.size > 1:
        ax.set_xlim(float(np.min(across.values)), float(np.max(across.values)))
    if name == RESTITUTION:
        ax.set_ylim(0.0, 1.02)


def _levels(name: Any, z: Array, logarithmic: bool) -> Array:
    """Round values for isolines, at least four of them if possible."""
    from matplotlib.ticker import MaxNLocator

    finite = z[np.isfinite(z)]
    if finite.size == 0:
        return np.empty(0)
    low, high = float(finite.min()), float(finite.max())
    candidates: list[Array] = []
    if name == RESTITUTION:
        candidates.append(np.array(_RESTITUTION_LEVELS))
    elif logarithmic:
        decades = 10.0 ** np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1.0)
        candidates += [decades, np.outer(decades, [1.0, 2.0, 5.0]).ravel()]
    for levels in candidates:
        inside = levels[(levels > low) & (levels < high)]
        if inside.size >= 4:
            return inside
    return np.asarray(MaxNLocator(8).tick_values(low, high))


def _power(exponent: float) -> str:
    return f"{10.0**exponent:.3g}"
