"""Families of curves with direct labels, and contour maps with labelled isolines."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from restitution.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

_DASHES: tuple[Any, ...] = ("-", (0, (5, 1.2)), (0, (5, 1.2, 1, 1.2)))
_MARKERS = "os^vD<>pPX"

# Curves of up to so many points have markers, and below that no line.
FEW, _SPARSE = 12, 3
# Room of a label of 7 points [points].
_LABEL_HEIGHT, _LABEL_WIDTH = 7.5, 24.0
# Labels keep apart by so many of their sizes, where the curves leave room.
_SPREAD = 2.0


def family_colors(n: int, *, cmap: str = "viridis", high: float = 0.88) -> list[tuple[float, ...]]:
    """Return `n` colours in the order of their lightness, without those that are too pale on white paper."""
    from matplotlib import colormaps

    return [tuple(map(float, color)) for color in colormaps[cmap](np.linspace(0.0, high, n))]


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
    figure.draw_without_rendering()
    point = figure.dpi / 72.0
    room_of_label = np.array([_LABEL_WIDTH, _LABEL_HEIGHT])
    places = np.linspace(0, x.size - 1, min(x.size, 400)).astype(int)
    shown = np.stack([ax.transData.transform(np.column_stack([x[places], row[places]])) / point for row in rows])
    frame = ax.get_window_extent()
    low, high = np.array([[frame.x0, frame.y0], [frame.x1, frame.y1]]) / point
    inside = np.all((shown > low + room_of_label) & (shown < high - room_of_label), axis=2)
    # Distance of each point of a curve from the nearest point of any other curve, in sizes of a label. Its width
    # counts half: a curve that ends a label is less of a nuisance than one through it.
    sizes, near = shown / room_of_label, shown / room_of_label / [0.5, 1.0]
    away = [cdist(curve, np.delete(near, n, axis=0).reshape(-1, 2)) for n, curve in enumerate(near)]
    room = np.stack([np.nanmin(one, axis=1, initial=3.0) for one in away])
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


def contour_map(
    ax: Axes,
    x: Any,
    y: Any,
    z: Any,
    levels: Sequence[float],
    *,
    fmt: str | Callable[[float], str] = "%g",
    cmap: Any = None,
    norm: Any = None,
    colorbar: str | None = None,
    labels_at: Sequence[tuple[float, float]] = (),
) -> Axes:
    """Draw labelled isolines of z(x, y), z[j, i] at x[i] and y[j], over a shading if `cmap` is given.

    The grid lines x and y and the levels ascend. Levels that the values do not reach are left out, and no isoline
    crosses values that are not finite. `colorbar` is the label of a colour bar with ticks at the isolines. Isolines
    nearest to the points `labels_at` get their labels there; matplotlib chooses the places if there are none.

    Examples
    --------
    >>> from restitution.plot.style import new_figure
    >>> x = np.linspace(0.0, 1.0, 5)
    >>> ax = contour_map(new_figure().add_subplot(), x, x, np.add.outer(x, x), [0.5, 1.0])
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
    words: Any = fmt if callable(fmt) else lambda level, _=None: fmt % level
    if cmap is not None:
        shading = ax.pcolormesh(x, y, z, cmap=_paler(cmap), norm=norm, shading="gouraud", rasterized=True)
        if colorbar is not None:
            bar = figure.colorbar(shading, ax=ax, label=colorbar, aspect=32, pad=0.02)
            place = ax.get_subplotspec()
            height = 72.0 * figure.get_figheight() / (place.get_gridspec().nrows if place else 1)
            ticks = _apart(levels, shading.norm, 9.0 / height)
            bar.set_ticks(ticks, labels=[words(level) for level in ticks], fontsize=7.5)
            bar.ax.minorticks_off()
    finite = z[np.isfinite(z)]
    reached = [level for level in levels if finite.min() < level < finite.max()]
    if not reached:
        return ax
    lines = ax.contour(x, y, z, levels=reached, colors="black", linewidths=0.8, linestyles="solid")
    # The gaps for the labels depend on the final size of the axes, which the layout sets when it is drawn.
    figure.draw_without_rendering()
    spacing = round(2.0 / 72.0 * figure.dpi)
    where: Any = list(labels_at) or False
    frame = ax.get_window_extent()
    for text in ax.clabel(lines, fmt=fmt, fontsize=8, inline=True, inline_spacing=spacing, manual=where):
        box = text.get_window_extent()
        if box.x0 < frame.x0 or box.x1 > frame.x1 or box.y0 < frame.y0 or box.y1 > frame.y1:
            # A label across the frame would be hard to read.
            text.remove()
    return ax


def _paler(cmap: str, share: float = 0.35) -> Any:
    """Return a colormap mixed with a share of white: opaque, as transparent areas show seams in PDF viewers."""
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap

    colors = colormaps[cmap](range(256))
    colors[:, :3] += share * (1.0 - colors[:, :3])
    return ListedColormap(colors.tolist()).with_extremes(bad="white")


def _apart(levels: Sequence[float], norm: Any, share: float) -> list[float]:
    """Leave out levels closer than a share of a colour bar; the one of larger magnitude stays."""
    kept: list[float] = []
    for level in sorted(levels, key=abs, reverse=True):
        place = float(norm(level))
        if all(abs(place - float(norm(other))) > share for other in kept):
            kept.append(level)
    return sorted(kept)
