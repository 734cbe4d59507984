"""Figures of a sweep: curves, contour maps, slices or distributions, chosen from its axes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from restitution.checks import Array, instance, items, mapping
from restitution.errors import InputError, InputTypeError
from restitution.plot import sticking, style
from restitution.plot.rebounds import draw_points, require_points
from restitution.quantities import ALIASES, RESTITUTION, Values, choice, scaled
from restitution.units import VELOCITY, scaled_unit

if TYPE_CHECKING:
    import xarray as xr

    from restitution.case.observations import ReboundPoints


# Panels of a sweep: an output over one axis, over two, or over random draws.


_RESTITUTION_LEVELS = (0.01, 0.02, 0.05, *(round(0.1 * n, 1) for n in range(1, 10)), 0.95, 0.98, 0.99)


def draw_curves(ax: Axes, output: xr.DataArray, x: str, family: str | None = None) -> Axes:
    """Draw an output over one axis, as a family of curves over a second axis."""
    values = scaled(output.transpose(*([family] if family else []), x))
    across = _along(ax, output, x)
    _frame(ax, across, values, output.name)
    places, rows = across.values, values.values
    if output.name == RESTITUTION:
        places, rows = sticking.broken(places, rows, logarithmic=across.logarithmic)
    if family is None:
        ax.plot(places, np.ravel(rows), color=style.BLUE, **style.markers(across.values.size))
        if output.name == RESTITUTION and is_numeric(output, x):
            sticking.draw_threshold(ax, across.values, values.values, across.unit)
        return ax
    finite = values.values[np.isfinite(values.values)]
    if finite.size and output.name != RESTITUTION:
        low, high = float(finite.min()), float(finite.max())
        margin = 0.05 * (high - low or abs(high) or 1.0)
        ax.set_ylim((low / 1.1, 1.1 * high) if values.logarithmic else (low - margin, high + margin))
    names = value_names(output, family)
    # The label on a curve is the value alone; the legend has the symbol and the unit.
    short = [name.rpartition(" = ")[2].split(" ")[0] for name in names]
    style.curve_family(ax, places, rows, names, short=short if across.values.size > 3 else ())
    return style.legend(ax)


def draw_bands(ax: Axes, output: xr.DataArray, x: str, draws: str) -> Axes:
    """Draw the median of an output over one axis, and the bands of 50 % and 90 % of the draws."""
    values = scaled(output.transpose(draws, x))
    across = _along(ax, output, x)
    _frame(ax, across, values, output.name)
    low, lower, median, upper, high = np.nanquantile(values.values, [0.05, 0.25, 0.5, 0.75, 0.95], axis=0)
    places, look = across.values, style.markers(across.values.size)
    bands = ((low, high, 0.15, 1.0, "90 % of the draws"), (lower, upper, 0.3, 3.0, "50 %"))
    for bottom, top, alpha, width, words in bands:
        if "linestyle" in look:
            # Few points get bars and no bands, because nothing is computed between them.
            ax.vlines(places, bottom, top, color=style.BLUE, linewidth=width, label=words)
        else:
            ax.fill_between(places, bottom, top, color=style.BLUE, alpha=alpha, linewidth=0, label=words)
    ax.plot(places, median, color=style.BLUE, label="median", **look)
    return style.legend(ax)


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


def draw_map(ax: Axes, output: xr.DataArray, x: str, y: str, shown: MapLevels) -> Axes:
    """Draw labelled isolines of an output over two axes, with a colour bar."""
    from matplotlib.colors import Normalize

    across, up = scaled(output[x]), scaled(output[y])
    ax.set(xscale=across.scale, yscale=up.scale, xlabel=across.label, ylabel=up.label)
    # Isolines need ascending axes.
    order = np.argsort(across.values), np.argsort(up.values)
    z = np.asarray(output.transpose(y, x).values, dtype=np.float64)[np.ix_(order[1], order[0])] * shown.factor
    z = np.where(np.isfinite(z), z, np.nan)
    if output.name == RESTITUTION:
        sticking.draw_area(ax, across.values[order[0]], up.values[order[1]], z)
        z = np.where(z == 0.0, np.nan, z)
    if not np.isfinite(z).any():
        ax.set_title(shown.label)
        return ax
    shading = style.Shading(shown.label, Normalize(shown.low, shown.high))
    values, fmt = (np.log10(z), _power) if shown.logarithmic else (z, "{:g}".format)
    grid = across.values[order[0]], up.values[order[1]]
    return style.contour_map(ax, *grid, values, list(shown.levels), shading, fmt=fmt)


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
    look: dict[str, Any] = {"markersize": 2.5, "color": style.family_colors(3)[1], "alpha": 0.6, "rasterized": True}
    ax.plot(across.values, values.values, ".", **look)
    return style.labelled(ax, across.label, values.label)


def is_numeric(output: xr.DataArray, dimension: str) -> bool:
    """Return whether a dimension has numbers along it."""
    return dimension in output.coords and np.issubdtype(output[dimension].dtype, np.number)


def value_names(output: xr.DataArray, dimension: str) -> list[str]:
    """Return the values along a dimension, with symbol and unit."""
    if not is_numeric(output, dimension):
        return [str(word) for word in output[dimension].values]
    along = scaled(output[dimension])
    return [along.value_label(place) for place in range(along.values.size)]


def _along(ax: Axes, output: xr.DataArray, x: str) -> Values:
    """Return the values along the abscissa; words are one unit apart."""
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
    if across.values.size > style.FEW:
        ax.set_xlim(float(np.min(across.values)), float(np.max(across.values)))
    if name == RESTITUTION:
        ax.set_ylim(0.0, 1.02)


def _levels(name: Any, finite: Array, logarithmic: bool) -> Array:
    """Return round values for isolines, at least four of them if possible."""
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


# An axis of up to so many values makes a family of curves, a longer axis a map.
_MOST_CURVES = 10
_MOST_PANELS = 6
# A figure cannot show more points.
_MOST_POINTS = {"curves": 2000, "map": 300, "draws": 20000}
# Users round the ends of axes.
_ROUNDED = 1e-6

# Width of a symbol with its value and unit in a title [inch].
_WIDTH_OF_VALUE = 1.3


class Layout(NamedTuple):
    """Kind of a picture ("curves", "map", "bands" or "draws") and the dimension of the sweep for each role.

    y is the ordinate of a map, or the parameter of a family of curves. Each panel shows one value of `slices`. Only
    the middle value of a dimension in `rest` is shown.
    """

    kind: str
    x: str | None
    y: str | None
    slices: str | None
    draws: str | None
    rest: tuple[str, ...]


def plot_sweep(
    dataset: xr.Dataset,
    outputs: Sequence[str] = (),
    *,
    x: str | None = None,
    y: str | None = None,
    at: Mapping[str, Any] | None = None,
    points: ReboundPoints | None = None,
    ax: Axes | None = None,
) -> Figure:
    """Return the figure of the result of a sweep.

    One axis makes a curve. Two axes make a map, or a family of curves if one of them has few values. A third axis
    makes panels, and any other is shown at its middle value. Random draws make bands, or histograms.

    Parameters
    ----------
    dataset : xarray.Dataset
        Result of `restitution.sweep` or `restitution.open_sweep`.
    outputs : sequence of str
        The outputs to draw; by default all, or the first if there are slices or `ax` is given.
    x : str, optional
        Dimension along the abscissa.
    y : str, optional
        Dimension along the ordinate of a map.
    at : dict, optional
        By name of a dimension, the value to show, in SI units; the nearest one is taken.
    points : ReboundPoints, optional
        Measured points of e over velocity, as `read_points` returns them, for the panels of e over velocity.
    ax : matplotlib.axes.Axes, optional
        Where to draw, if there is one panel only; by default a new figure.

    Returns
    -------
    matplotlib.figure.Figure
        The new figure, or that of `ax`. A notebook shows it; `figure.savefig` writes it.

    Raises
    ------
    InputError
        If a name is unknown, a value outside its axis, there is nothing to show, or more than fits into `ax`.

    Examples
    --------
    >>> import restitution as rs
    >>> result = rs.sweep(None, {"nu": [0.45, 0.5], "p2": 0.1, "p3": rs.Logarithmic(0.01, 100.0, 9)})
    >>> figure = plot_sweep(result, ["restitution_coefficient"])
    >>> len(figure.axes), len(figure.axes[0].lines)
    (1, 2)
    """
    if not hasattr(dataset, "data_vars"):
        raise InputTypeError("dataset", dataset, "must be a Dataset, as sweep and open_sweep return")
    dataset = _selected(dataset, mapping("at", at))
    for name, axis in (("x", x), ("y", y)):
        if axis is not None:
            instance(name, axis, str, "must be the name of an axis")
    if ax is not None and not hasattr(ax, "get_figure"):
        raise InputTypeError("ax", ax, "must be axes of Matplotlib")
    require_points(points)
    outputs = items("outputs", outputs, "must be names of outputs")
    dataset = dataset.isel({name: 0 for name, size in dataset.sizes.items() if size == 1})
    there = [str(name) for name in dataset.data_vars if name != "status"]
    for name in outputs:
        choice("outputs", name, there)
    layout = choose_layout(dataset, x, y)
    if layout.x is None and layout.draws is None:
        raise InputError("dataset", rule="must have an axis with more than one value, over which it is drawn")
    for dimension in layout.rest:
        dataset = dataset.isel({dimension: dataset.sizes[dimension] // 2})
    names = list(outputs) or (there[:1] if layout.slices or ax is not None else there)
    dataset = _thinned(_finite(dataset[names], layout), layout)
    if points is not None and (RESTITUTION not in names or layout.x != "velocity" or layout.kind == "map"):
        raise InputError("points", rule="need curves of the restitution coefficient over the velocity")
    with style.context():
        if layout.kind == "draws" and ax is None:
            figure = _draws_figure(dataset, names, layout)
        else:
            figure = _figure(dataset, names, layout, ax, points)
        if words := _title(dataset, figure.get_figwidth()) if ax is None else "":
            figure.suptitle(words, fontsize=9)
        figure.draw_without_rendering()
    return figure


def choose_layout(dataset: xr.Dataset, x: str | None = None, y: str | None = None) -> Layout:
    """Choose the role of each dimension of a sweep, given the dimensions that the user wants along x and y."""
    probe = dataset[next(iter(dataset.data_vars))]
    sizes = {str(name): size for name, size in probe.sizes.items() if size > 1}
    x, y = (ALIASES.get(name, name) if name else name for name in (x, y))
    for field, name in (("x", x), ("y", y)):
        if name is not None:
            choice(field, name, sizes)
    if x is not None and x == y:
        raise InputError("y", y, "must be another axis than x")
    draws = next((name for name in sizes if name not in dataset.coords), None)
    free = [name for name in sizes if name != draws]
    numeric = [name for name in free if is_numeric(probe, name)]
    if not free:
        return Layout("draws", None, None, None, draws, ())
    if x is None:
        ranked = sorted((name for name in numeric if name != y), key=lambda name: -sizes[name])
        x = ranked[0] if ranked else next(name for name in free if name != y)
        # The first of two long axes goes along the abscissa.
        if y is None and len(ranked) > 1 and sizes[ranked[1]] > _MOST_CURVES:
            x = next(name for name in numeric if name in ranked[:2])
    others = sorted((name for name in free if name != x), key=lambda name: (name not in numeric, -sizes[name]))
    kind = "curves"
    if draws is not None:
        kind, y = "bands", None
    elif y is not None or (others and {others[0], x} <= {*numeric} and sizes[others[0]] > _MOST_CURVES):
        kind, y = "map", y or others[0]
    elif others and sizes[others[-1]] <= _MOST_CURVES:
        y = others[-1]
    slices, *rest = [name for name in others if name != y] or [None]
    return Layout(kind, x, y, slices, draws, tuple(map(str, rest)))


def _selected(dataset: xr.Dataset, at: Mapping[str, Any]) -> xr.Dataset:
    for axis, value in at.items():
        name = ALIASES.get(axis, axis)
        choice("at", name, [str(dimension) for dimension in dataset.dims if dimension in dataset.coords])
        if np.issubdtype(dataset[name].dtype, np.number):
            place = _nearest(dataset[name], value)
        else:
            words = [str(word) for word in dataset[name].values]
            if str(value) not in words:
                raise InputError(f"at {name}", str(value), f"must be one of {', '.join(words)}")
            place = words.index(str(value))
        dataset = dataset.isel({name: place})
    return dataset


def _nearest(axis: xr.DataArray, value: Any) -> int:
    """Return the place of the nearest value along an axis; a value beyond its ends is refused."""
    if isinstance(value, bool) or not isinstance(value, (int, float, np.number)):
        raise InputTypeError(f"at {axis.name}", value, "must be a number")
    values = np.asarray(axis.values, dtype=np.float64)
    low, high = float(values.min()), float(values.max())
    unit = "" if axis.attrs.get("units", "1") == "1" else axis.attrs["units"]
    slack = _ROUNDED * max(abs(low), abs(high)) if np.isfinite(high) else 0.0
    if not low - slack <= float(value) <= high + slack:
        raise InputError(f"at {axis.name}", float(value), f"must lie on the axis, from {low:.6g} to {high:.6g}", unit)
    with np.errstate(invalid="ignore"):
        away = np.abs(values - float(value))
    return int(np.argmin(np.where(values == value, 0.0, away)))


def _finite(dataset: xr.Dataset, layout: Layout) -> xr.Dataset:
    """Leave out places at infinity, such as that of an incompressible material on an axis of bulk moduli."""
    for name in (layout.x, layout.y if layout.kind == "map" else None):
        if name is not None and np.issubdtype(dataset[name].dtype, np.number):
            dataset = dataset.isel({name: np.isfinite(dataset[name].values)})
            if dataset.sizes[name] < (2 if layout.kind == "map" else 1):
                raise InputError(name, "axis", "has too few finite values to draw over")
    return dataset


def _thinned(dataset: xr.Dataset, layout: Layout) -> xr.Dataset:
    """Leave out points that no figure could show."""
    most = {layout.x: _MOST_POINTS["curves"], layout.draws: _MOST_POINTS["draws"]}
    if layout.kind == "map":
        most |= {layout.x: _MOST_POINTS["map"], layout.y: _MOST_POINTS["map"]}
    if layout.slices:
        most[layout.slices] = _MOST_PANELS
    for name, count in most.items():
        if name is not None and dataset.sizes[name] > count:
            places = np.unique(np.linspace(0, dataset.sizes[name] - 1, count).round().astype(int))
            dataset = dataset.isel({name: places})
    return dataset


def _figure(
    dataset: xr.Dataset, names: list[str], layout: Layout, ax: Axes | None, points: ReboundPoints | None
) -> Figure:
    panels: list[tuple[xr.DataArray, str]] = []
    for name in names:
        output = dataset[name]
        if layout.slices is None:
            panels.append((output, ""))
            continue
        words = value_names(output, layout.slices)
        panels.extend((output.isel({layout.slices: place}), text) for place, text in enumerate(words))
    n = len(panels)
    columns = 1 if n == 1 else 2 if n in (2, 4) else min(3, n)
    rows = -(-n // columns)
    if ax is None:
        width = 5.2 if columns == 1 else style.PAGE_WIDTH * (1.0 if columns == 2 else 1.35)
        places = [*map(str, range(n)), *"." * (rows * columns - n)]
        mosaic = [places[columns * row : columns * (row + 1)] for row in range(rows)]
        figure, axes = style.panels(mosaic, width, max(3.4, (4.2 if columns == 1 else 3.0) * rows))
    elif n == 1 and layout.kind != "draws":
        figure, axes = cast("Figure", ax.get_figure(root=True)), [ax]
    else:
        raise InputError("ax", "one panel", f"is too few for this picture, which has {n}")
    assert layout.x is not None
    for panel, (output, words) in zip(axes, panels, strict=True):
        if layout.kind == "map":
            assert layout.y is not None
            # One scale for all slices of an output makes them comparable.
            draw_map(panel, output, layout.x, layout.y, map_levels(dataset[output.name]))
        elif layout.kind == "bands":
            assert layout.draws is not None
            draw_bands(panel, output, layout.x, layout.draws)
        else:
            draw_curves(panel, output, layout.x, layout.y)
        if points is not None and output.name == RESTITUTION:
            draw_points(panel, points, scaled_unit(output["velocity"].values, VELOCITY.unit).factor)
        if words:
            panel.set_title(words, fontsize=9)
    return figure


def _draws_figure(dataset: xr.Dataset, names: list[str], layout: Layout) -> Figure:
    drawn = [str(name) for name, coordinate in dataset.coords.items() if coordinate.dims == (layout.draws,)]
    # Both rows are equally wide, whatever the number of their panels.
    mosaic = [[name for name in names for _ in drawn or names[:1]], [f"over {name}" for name in drawn for _ in names]]
    width = max(style.COLUMN_WIDTH, 2.6 * max(len(names), len(drawn)))
    figure, axes = style.panels(mosaic[: 1 + bool(drawn)], width, 5.4)
    for ax, name in zip(axes, names, strict=False):
        draw_histogram(ax, dataset[name])
    for ax, name in zip(axes[len(names) :], drawn, strict=True):
        draw_scatter(ax, dataset[names[0]], name)
    return figure


def _title(dataset: xr.Dataset, width: float) -> str:
    """Return the title, and below it the values that all points share, in lines that fit the width [inch]."""
    lines = [str(dataset.attrs.get("title", ""))]
    shared = [_held(coordinate) for coordinate in dataset.coords.values() if not coordinate.dims]
    each = max(1, int(width / _WIDTH_OF_VALUE))
    lines += [", ".join(shared[start : start + each]) for start in range(0, len(shared), each)]
    return "\n".join(line for line in lines if line)


def _held(coordinate: xr.DataArray) -> str:
    if not np.issubdtype(coordinate.dtype, np.number):
        return str(coordinate.values)
    return scaled(coordinate.expand_dims("point")).value_label(0)
