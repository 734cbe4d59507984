"""Style of all figures: fonts, sizes, colours for the colour-blind; creation and saving of figures."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from string import ascii_lowercase
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from restitution.checks import Array
from restitution.errors import InputError
from restitution.quantities import Quantity
from restitution.units import scaled_unit

# Okabe and Ito (2008), https://jfly.uni-koeln.de/color: distinct under all common colour blindness.
BLACK = "#000000"
ORANGE = "#E69F00"
SKY_BLUE = "#56B4E9"
GREEN = "#009E73"
BLUE = "#0072B2"
VERMILION = "#D55E00"
PURPLE = "#CC79A7"
GREY = "#7F7F7F"

SEQUENTIAL = "YlGnBu_r"
DIVERGING = "PuOr"

COLUMN_WIDTH = 3.54
PAGE_WIDTH = 7.2
"""Widths of one and of two journal columns [inch]."""

_SETTINGS: dict[str, Any] = {
    # A concrete family, not "serif": the generic name is looked up when drawn, after the context has ended.
    "font.family": ["STIXGeneral"],
    "mathtext.fontset": "stix",
    "font.size": 9.0,
    "axes.labelsize": 10.0,
    "axes.titlesize": 10.0,
    "axes.linewidth": 0.7,
    "axes.axisbelow": True,
    "axes.formatter.use_mathtext": True,
    "axes.prop_cycle": f"cycler('color', {[BLUE, VERMILION, GREEN, ORANGE, SKY_BLUE, PURPLE, BLACK]!r})",
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "xtick.labelsize": 9.0,
    "ytick.labelsize": 9.0,
    "grid.color": "#DDDDDD",
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.3,
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "figure.constrained_layout.use": True,
    "figure.dpi": 100,
    "savefig.dpi": 300,
    # Type 42 keeps glyphs as TrueType outlines, which publishers accept and programs can edit.
    "pdf.fonttype": 42,
    "ps.fonttype": 42,
    # Element names of an SVG are random without it.
    "svg.hashsalt": "restitution",
}


@contextmanager
def context() -> Generator[None]:
    """Give every new figure inside this context the style of the package; the user's settings return afterwards."""
    from matplotlib import style

    with style.context(["default", _SETTINGS]):
        yield


def use() -> None:
    """Give every further figure the style of the package, as `context` does temporarily."""
    from matplotlib import style

    style.use(_SETTINGS)


class Picture(Figure):
    """A figure that a notebook shows when it is the value of a cell, without pyplot or any setting.

    Pyplot does not hold it, so it needs no display and no closing, even in large numbers.
    """

    def _repr_png_(self) -> bytes:
        with context(), BytesIO() as file:
            self.savefig(file, format="png", dpi=self.dpi)
            return file.getvalue()


def new_figure(width: float = PAGE_WIDTH, height: float = 4.4, *, dpi: float = 100.0) -> Figure:
    """Return an empty figure that pyplot does not hold, and that notebooks show.

    The size is in inches, and the resolution that on a screen. Files have 300 dots per inch; a figure that has that
    resolution already is written fastest.

    Examples
    --------
    >>> with context():
    ...     new_figure(3.5, 2.5).get_size_inches().tolist()
    [3.5, 2.5]
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure = Picture(figsize=(width, height), dpi=dpi, layout="constrained")
    # Without its own canvas, each question for the size of a text costs a rendering of the whole figure.
    FigureCanvasAgg(figure)
    return figure


def panels(
    mosaic: Any,
    width: float = PAGE_WIDTH,
    height: float = 4.4,
    *,
    dpi: float = 100.0,
    figure: Figure | None = None,
    heights: Sequence[float] | None = None,
) -> tuple[Figure, list[Axes]]:
    """Return a new or a given empty figure and its panels, with letters above them if there are several.

    The mosaic is that of matplotlib's `subplot_mosaic`, e.g. "AA;BC": one letter or name for each panel, "." for none.

    Examples
    --------
    >>> page, axes = panels("AA;BC")
    >>> [ax.get_title("left") for ax in axes]
    ['(a)', '(b)', '(c)']
    """  # fmt: skip
    page = new_figure(width, height, dpi=dpi) if figure is None else figure
    axes = list(page.subplot_mosaic(mosaic, height_ratios=heights).values())
    for ax, letter in zip(axes if len(axes) > 1 else (), ascii_lowercase, strict=False):
        ax.set_title(f"({letter})", loc="left", fontweight="bold")
    return page, axes


@contextmanager
def page(
    mosaic: Any,
    width: float = PAGE_WIDTH,
    height: float = 4.4,
    *,
    title: str = "",
    **options: Any,
) -> Generator[tuple[Figure, list[Axes]]]:
    """Yield the figure and the axes of `panels` in the style of the package; finish it at the end of the block."""
    with context():
        figure, axes = panels(mosaic, width, height, **options)
        yield figure, axes
        finish(figure, title)


class Axis(NamedTuple):
    """Factor from SI to the unit of an axis, the unit, and the label."""

    factor: float
    unit: str
    label: str


def axis(quantity: Quantity, values: Any) -> Axis:
    """Return the axis of some values of a quantity, in a suitable unit."""
    factor, unit = scaled_unit(values, quantity.unit)
    return Axis(factor, unit, quantity.label(unit))


# Quantities and axes of the last curve: curves that share axes share their units.
_LAST: WeakKeyDictionary[Axes, tuple[list[str], list[Axis]]] = WeakKeyDictionary()


def axes_of(ax: Axes, x: tuple[Quantity, Any], y: tuple[Quantity, Any]) -> list[Axis]:
    """Return the axes of two quantities: the units are those of a curve of such quantities here, or suitable ones.

    Examples
    --------
    >>> from restitution.quantities import HISTORY
    >>> ax, time = new_figure().add_subplot(), (HISTORY["time"], [0.0, 1.0])
    >>> for top in (2e-3, 0.0):
    ...     ax = draw(ax, time, (HISTORY["indentation_depth"], [0.0, top]))
    >>> ax.get_ylabel()
    'indentation depth $d$ [mm]'
    """
    units, axes = [quantity.unit for quantity, _ in (x, y)], [axis(*x), axis(*y)]
    if ax.has_data() and _LAST.get(ax, ([], []))[0] == units:
        axes = [
            old._replace(label=quantity.label(old.unit))
            for old, (quantity, _) in zip(_LAST[ax][1], (x, y), strict=True)
        ]
    _LAST[ax] = units, axes
    return axes


def draw(ax: Axes, x: tuple[Quantity, Any], y: tuple[Quantity, Any], *fmt: str, **look: Any) -> Axes:
    """Draw the values of a quantity over those of another, in suitable units; see `axes_of`.

    Examples
    --------
    >>> from restitution.quantities import HISTORY
    >>> ax = draw(new_figure().add_subplot(), (HISTORY["time"], [0.0, 1e-3]), (HISTORY["force"], [0.0, 2.0]))
    >>> ax.get_xlabel(), ax.lines[0].get_xdata().tolist()
    ('time since first touch $t$ [ms]', [0.0, 1.0])
    """
    across, up = axes_of(ax, x, y)
    ax.plot(across.factor * np.asarray(x[1]), up.factor * np.asarray(y[1]), *fmt, **look)
    return labelled(ax, across.label, up.label)


def labelled(ax: Axes, x: str, y: str) -> Axes:
    """Return axes with their labels and a grid."""
    ax.set(xlabel=x, ylabel=y)
    ax.grid(True)
    return ax


def legend(ax: Axes) -> Axes:
    """Add a legend of all that has a label; many labels stand in two columns of small letters."""
    count = len(ax.get_legend_handles_labels()[1])
    ax.legend(loc="best", ncols=2 if count > 6 else 1, fontsize=7.5 if count > 3 else None)
    return ax


def plain_ticks(ax: Axes) -> Axes:
    """Write plain numbers along logarithmic axes of at most two decades."""
    from matplotlib.ticker import LogLocator, NullFormatter

    for axis in (ax.xaxis, ax.yaxis):
        low, high = sorted(axis.get_view_interval())
        if axis.get_scale() == "log" and high <= 100.0 * low:
            axis.set_major_locator(
                LogLocator(subs=(1.0, 2.0, 5.0) if high > 10.0 * low else (1.0, 2.0, 3.0, 4.0, 6.0))
            )
            axis.set_major_formatter("{x:g}")
            axis.set_minor_formatter(NullFormatter())
    return ax


def _lay_out(figure: Figure) -> None:
    """Give the axes their final size; a layout takes less time than the drawing, which begins with it."""
    engine = figure.get_layout_engine()
    if engine is None:
        figure.draw_without_rendering()
    else:
        engine.execute(figure)


def finish(figure: Figure, title: str = "") -> Figure:
    """Set the title, and make all texts while the fonts are those of the package."""
    if title:
        figure.suptitle(title, fontsize=11 if len(title) < 80 else 9)
    figure.draw_without_rendering()
    return figure


def save_figure(figure: Figure, path: Path | str) -> Path:
    """Save a figure completely or not at all, with embedded fonts; the suffix of `path` chooses the format.

    The bytes depend only on the figure: no date is written. An existing file is replaced, unless the new one cannot
    be written (OSError). A format that matplotlib cannot write is an InputError.
    """
    from restitution.files import whole_file

    path = Path(path)
    suffix = path.suffix.lower().lstrip(".")
    formats = figure.canvas.get_supported_filetypes()
    if suffix not in formats:
        raise InputError("path", str(path), f"must end in one of .{', .'.join(sorted(formats))}")
    options: dict[str, Any] = {"dpi": 300}
    if suffix == "png":
        options["pil_kwargs"] = {"compress_level": 4}
    elif suffix == "pdf":
        # Only smooth shadings are pixels in these formats: half the resolution looks the same, in half the bytes.
        options |= {"metadata": {"CreationDate": None}, "dpi": 150}
    elif suffix in ("svg", "svgz"):
        options |= {"metadata": {"Date": None}, "dpi": 150}
    with context(), whole_file(path) as partial:
        figure.savefig(partial, format=suffix, **options)
    return path


# Families of curves with direct labels, and contour maps with labelled isolines.


_DASHES: tuple[Any, ...] = ("-", (0, (5, 1.2)), (0, (5, 1.2, 1, 1.2)))
_MARKERS = "os^vD<>pPX"

# End of the colours of a family: lighter ones are too pale on white paper.
_LIGHTEST = 0.88
# Share of white in a shading.
_WHITE = 0.35
# Curves of up to so many points have markers, and below that no line.
FEW, _SPARSE = 12, 3
# Room of a label of 7 points [points].
_LABEL_HEIGHT, _LABEL_WIDTH = 7.5, 24.0
# Labels keep apart by so many of their sizes, where the curves leave room.
_SPREAD = 2.0


def family_colors(n: int) -> list[tuple[float, ...]]:
    """Return `n` colours in the order of their lightness, without those that are too pale on white paper."""
    from matplotlib import colormaps

    return [tuple(map(float, color)) for color in colormaps["viridis"](np.linspace(0.0, _LIGHTEST, n))]


def markers(count: int, number: int = 0) -> dict[str, Any]:
    """Return the style of a curve of few points: markers, and without a line up to three points."""
    if count > FEW:
        return {}
    look: dict[str, Any] = {"marker": _MARKERS[number % len(_MARKERS)], "markersize": 4}
    return look | ({"linestyle": ""} if count <= _SPARSE else {})


def curve_family(
    ax: Axes,
    x: Any,
    curves: Any,
    labels: Sequence[str],
    *,
    short: Sequence[str] = (),
    limit: Any = None,
    limit_label: str = "limit",
) -> Axes:
    """Draw curves, the rows of `curves`, in the order of their parameter; a limiting one as a thin black line.

    The lightness follows the parameter, and the dashes repeat in threes. The short labels lie on the curves, so that
    colour is not needed to distinguish them; scales and limits of the axes must be set before.

    Examples
    --------
    >>> from restitution.plot.style import new_figure
    >>> ax = curve_family(new_figure().add_subplot(), [0, 1], [[0, 1], [1, 2]], ["a", "b"], limit=[2, 3])
    >>> [line.get_label() for line in ax.lines]
    ['a', 'b', 'limit']
    """
    x = np.asarray(x, dtype=np.float64)
    rows = np.atleast_2d(np.asarray(curves, dtype=np.float64))
    if len(labels) != len(rows):
        raise InputError("labels", len(labels), f"must have {len(rows)} entries, one for each curve")
    colors = family_colors(len(rows))
    for number, (row, label, color) in enumerate(zip(rows, labels, colors, strict=True)):
        look: dict[str, Any] = {"linestyle": _DASHES[number % len(_DASHES)], "linewidth": 1.5} | markers(
            x.size, number
        )
        ax.plot(x, row, color=color, label=label, **look)
    if limit is not None:
        rows = np.vstack([rows, limit])
        ax.plot(x, limit, color="black", linewidth=0.6, label=limit_label)
    if short:
        _label_curves(ax, x, rows, short, colors)
    return ax


def _label_curves(ax: Axes, x: Array, rows: Array, words: Sequence[str], colors: Sequence[Any]) -> None:
    """Write a label on each curve, far from other curves and labels; the curve with the least room comes first."""
    from scipy.spatial.distance import cdist

    figure: Any = ax.figure
    _lay_out(figure)
    point = figure.dpi / 72.0
    room_of_label = np.array([_LABEL_WIDTH, _LABEL_HEIGHT])
    places = np.linspace(0, x.size - 1, min(x.size, 400)).astype(int)
    shown = np.stack([ax.transData.transform(np.column_stack([x[places], row[places]])) / point for row in rows])
    frame = ax.get_window_extent()
    low, high = np.array([[frame.x0, frame.y0], [frame.x1, frame.y1]]) / point
    inside = np.all((shown > low + room_of_label) & (shown < high - room_of_label), axis=2)
    # Distance of each point of a curve from the nearest point of any other curve, in sizes of a label. Its width
    # counts half: a curve that ends at a label is less of a nuisance than a curve through it.
    sizes, near = shown / room_of_label, shown / room_of_label / [0.5, 1.0]
    away = [cdist(curve, np.delete(near, n, axis=0).reshape(-1, 2)) for n, curve in enumerate(near)]
    room = np.stack([np.nanmin(distances, axis=1, initial=3.0) for distances in away])
    room = np.where(inside, room, -np.inf)
    taken: list[Array] = []
    for n in sorted(range(len(words)), key=lambda n: float(room[n].max())):
        score = room[n].copy()
        for place in taken:
            gap = np.max(np.abs(sizes[n] - place), axis=1)
            score -= 30.0 * (gap < 1.0) + 0.3 * np.maximum(0.0, _SPREAD - gap)
        if not np.isfinite(score).any():
            continue
        best = int(np.argmax(score))
        taken.append(sizes[n, best])
        at = x[places[best]], rows[n, places[best]]
        box = {"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none"}
        ax.annotate(words[n], at, ha="center", va="center", fontsize=7, color=colors[n], bbox=box)


class Shading(NamedTuple):
    """Shading of a map: the label of its colour bar, the scale of its values, and its colours."""

    label: str
    norm: Any = None
    cmap: str = SEQUENTIAL


def contour_map(
    ax: Axes,
    x: Any,
    y: Any,
    z: Any,
    levels: Sequence[float],
    shading: Shading,
    *,
    fmt: Callable[[float], str] = "{:g}".format,
    labels_at: Sequence[tuple[float, float]] = (),
) -> Axes:
    """Draw labelled isolines of z(x, y), z[j, i] at x[i] and y[j], over a shading with its colour bar.

    The grid lines x and y and the levels ascend. Levels that the values do not reach are left out, and no isoline
    crosses values that are not finite. The ticks of the colour bar are those of the isolines. Isolines nearest to the
    points `labels_at` get their labels there; matplotlib chooses the places if there are none.

    Examples
    --------
    >>> from restitution.plot.style import new_figure
    >>> x = np.linspace(0.0, 1.0, 5)
    >>> ax = contour_map(new_figure().add_subplot(), x, x, np.add.outer(x, x), [0.5, 1.0], Shading("sum"))
    >>> [text.get_text() for text in ax.texts]
    ['0.5', '1']
    """
    x, y, z = (np.asarray(part, dtype=np.float64) for part in (x, y, z))
    if z.shape != (y.size, x.size):
        raise InputError("z.shape", z.shape, f"must be (len(y), len(x)) = ({y.size}, {x.size})")
    ax.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
    # Ticks must lie over the shading.
    ax.set_axisbelow(False)
    figure: Any = ax.figure
    cmap = _paler(shading.cmap)
    mesh = ax.pcolormesh(x, y, z, cmap=cmap, norm=shading.norm, shading="gouraud", rasterized=True)
    bar = figure.colorbar(mesh, ax=ax, label=shading.label, aspect=32, pad=0.02)
    place = ax.get_subplotspec()
    height = 72.0 * figure.get_figheight() / (place.get_gridspec().nrows if place else 1)
    ticks = _apart(levels, mesh.norm, 9.0 / height)
    bar.set_ticks(ticks, labels=[fmt(level) for level in ticks], fontsize=7.5)
    bar.ax.minorticks_off()
    finite = z[np.isfinite(z)]
    reached = [level for level in levels if finite.min() < level < finite.max()]
    if not reached:
        return ax
    lines = ax.contour(x, y, z, levels=reached, colors="black", linewidths=0.8, linestyles="solid",
                       corner_mask=False)  # fmt: skip
    # The gaps for the labels depend on the final size of the axes.
    _lay_out(figure)
    spacing = round(2.0 / 72.0 * figure.dpi)
    where: Any = list(labels_at) or False
    frame = ax.get_window_extent()
    for text in ax.clabel(lines, fmt=fmt, fontsize=8, inline=True, inline_spacing=spacing, manual=where):
        box = text.get_window_extent()
        if box.x0 < frame.x0 or box.x1 > frame.x1 or box.y0 < frame.y0 or box.y1 > frame.y1:
            # A label across the frame would be hard to read.
            text.remove()
    return ax


def _paler(cmap: str) -> Any:
    """Return a colormap mixed with white: opaque, as transparent areas show seams in PDF viewers."""
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap

    colors = colormaps[cmap](range(256))
    colors[:, :3] += _WHITE * (1.0 - colors[:, :3])
    return ListedColormap(colors.tolist()).with_extremes(bad="white")


def _apart(levels: Sequence[float], norm: Any, share: float) -> list[float]:
    """Leave out levels closer than a share of a colour bar; the one of larger magnitude stays."""
    kept: list[float] = []
    for level in sorted(levels, key=abs, reverse=True):
        place = float(norm(level))
        if all(abs(place - float(norm(other))) > share for other in kept):
            kept.append(level)
    return sorted(kept)
