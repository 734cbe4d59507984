"""Bodies that do not rebound in pictures: curves that end there, the band of the threshold, areas of maps."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.colors import ListedColormap

from restitution.checks import Array
from restitution.plot import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Colour of what does not rebound.
SHADE = "0.8"


def broken(x: Any, rows: Any, *, logarithmic: bool = False) -> tuple[Array, Array]:
    """Return the places and the rows of curves of e with a gap wherever a body begins to rebound, or ceases to.

    Where one of the rows has a gap there is a further place, at which the others keep their straight line.

    Examples
    --------
    >>> broken([1.0, 2.0, 3.0], [[0.0, 0.0, 0.4]])[1].tolist()
    [[0.0, 0.0, nan, 0.4]]
    """
    places, e = np.asarray(x, dtype=np.float64), np.atleast_2d(np.asarray(rows, dtype=np.float64))
    changes = np.diff(e == 0.0, axis=1) & np.isfinite(e[:, 1:]) & np.isfinite(e[:, :-1])
    at = np.flatnonzero(changes.any(axis=0))
    low, high = places[at], places[at + 1]
    middle = np.sqrt(low * high) if logarithmic else 0.5 * (low + high)
    between = np.where(changes[:, at], np.nan, 0.5 * (e[:, at] + e[:, at + 1]))
    return np.insert(places, at + 1, middle), np.insert(e, at + 1, between, axis=1)


def threshold(x: Any, e: Any) -> tuple[float, float] | None:
    """Return neighbouring places where one body sticks and the next rebounds; None if there is no single pair.

    Examples
    --------
    >>> threshold([3.0, 1.0, 2.0], [0.4, 0.0, 0.0])
    (2.0, 3.0)
    """
    places, values = np.asarray(x, dtype=np.float64), np.asarray(e, dtype=np.float64)
    order = np.argsort(places, kind="stable")
    order = order[np.isfinite(values[order])]
    changes = np.flatnonzero(np.diff(values[order] == 0.0))
    if changes.size != 1:
        return None
    low, high = places[order][changes[0] : changes[0] + 2].tolist()
    return low, high


def draw_threshold(ax: Axes, x: Any, e: Any, unit: str) -> Axes:
    """Draw the band between the last body that sticks and the first that rebounds, with its ends in the legend."""
    ends = threshold(x, e)
    if ends is None:
        return ax
    low, high = ends
    words = f"threshold: {low:.3g} to {high:.3g} {unit}".rstrip()
    ax.axvspan(low, high, color=SHADE, linewidth=0, label=words)
    return style.legend(ax)


def draw_area(ax: Axes, x: Any, y: Any, e: Any) -> Axes:
    """Shade where bodies do not rebound, up to the grid lines where they do, over ascending grid lines x and y."""
    stays = np.asarray(e) == 0.0
    if not stays.any() or min(stays.shape) < 2:
        return ax
    # The cells that a shading of finite values leaves free.
    cells = stays[1:, 1:] | stays[:-1, 1:] | stays[1:, :-1] | stays[:-1, :-1]
    ax.pcolormesh(x, y, np.where(cells, 1.0, np.nan), cmap=ListedColormap([SHADE]), rasterized=True)
    rows, columns = np.nonzero(stays)
    # The place of the name: the point nearest to the middle of all, on the scales of the grid.
    nearest = int(np.argmin(np.hypot(rows - rows.mean(), columns - columns.mean())))
    place = float(np.asarray(x)[columns[nearest]]), float(np.asarray(y)[rows[nearest]])
    ax.annotate("no rebound", place, ha="center", va="center", fontsize=8, annotation_clip=True)
    return ax
