"""Contour maps with labelled isolines."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from restitution.plot import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Segment = tuple[tuple[float, float], tuple[float, float]]

_SAMPLES = 2001

_LABEL_WIDTH = 26.0
_LABEL_HEIGHT = 7.0
"""Room that a label of 8 points takes [points]."""


def contour_map(
    ax: Axes,
    x: Any,
    y: Any,
    z: Any,
    levels: Sequence[float],
    *,
    fmt: str | Callable[[float], str] = "%g",
    label_along: Sequence[Segment] = (),
    cmap: Any = None,
    norm: Any = None,
) -> Axes:
    """Draw labelled isolines of z(x, y), over a shading if wanted.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    x, y : array-like, shapes (n,), (m,)
        Grid lines, ascending.
    z : array-like, shape (m, n)
        The values; no isoline crosses where they are not finite.
    levels : sequence of float
        The isolines, ascending; those that the values do not reach are left out.
    fmt : str or callable
        The isolines' labels.
    label_along : sequence of pairs of points
        Straight lines ((x0, y0), (x1, y1)) along which isolines get their labels, where these do not touch
        the frame nor, if avoidable, other labels and isolines. Without any, matplotlib finds the places.
    cmap : str or matplotlib colormap, optional
        Colours of the shading; none if absent.
    norm : matplotlib.colors.Normalize, optional
        How values map to colours.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`.

    Raises
    ------
    ValueError
        If the shapes do not fit.

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
        raise ValueError(f"z has shape {z.shape}: must be (len(y), len(x)) = ({y.size}, {x.size})")
    ax.set_xlim(x[0], x[-1])
    ax.set_ylim(y[0], y[-1])
    # Over a shading, ticks below it would be lost.
    ax.set_axisbelow(False)
    if cmap is not None:
        ax.pcolormesh(x, y, z, cmap=style.paler(cmap), norm=norm, shading="gouraud", rasterized=True)
    finite = z[np.isfinite(z)]
    reached = [level for level in levels if finite.min() < level < finite.max()]
    if not reached:
        return ax
    lines = ax.contour(x, y, z, levels=reached, colors="black", linewidths=0.8, linestyles="solid")
    # Labels are spaced and their gaps cut in the axes' final size, which the layout settles when drawn.
    figure: Any = ax.get_figure(root=True)
    figure.draw_without_rendering()
    places: Any = False
    if label_along:
        places = _label_places(ax, x, y, z, reached, label_along)
    # The gap beside a label counts in pixels.
    spacing = round(2.0 / 72.0 * figure.dpi)
    ax.clabel(lines, fmt=fmt, fontsize=8, inline=True, inline_spacing=spacing, manual=places)
    return ax


def _label_places(
    ax: Axes,
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    z: NDArray[np.float64],
    levels: Sequence[float],
    segments: Sequence[Segment],
) -> list[tuple[float, float]]:
    point = ax.get_figure(root=True).dpi / 72.0  # pyright: ignore[reportOptionalMemberAccess]
    frame = ax.get_window_extent().padded(-_LABEL_WIDTH / 2 * point)
    labels: list[tuple[float, NDArray[np.float64], NDArray[np.float64]]] = []
    passed: dict[float, list[tuple[float, NDArray[np.float64], NDArray[np.float64]]]] = {}
    for start, end in segments:
        points = np.linspace(start, end, _SAMPLES)
        along = _bilinear(x, y, z, points)
        finite = np.isfinite(along[1:] + along[:-1])
        crossings = [
            (level, points[n])
            for level in levels
            for n in np.flatnonzero(((along > level)[1:] != (along > level)[:-1]) & finite)
        ]
        shown = ax.transData.transform([place for _, place in crossings]) if crossings else np.empty((0, 2))
        for n, (level, place) in enumerate(crossings):
            gap = min(np.hypot(*(np.delete(shown, n, axis=0) - shown[n]).T), default=np.inf) / point
            others = [
                np.hypot(*(shown[n] - other)) / point - (_LABEL_WIDTH if level == same else 0.0)
                for same, _, other in labels
            ]
            if not frame.contains(*shown[n]):
                continue
            if gap > _LABEL_HEIGHT and min(others, default=np.inf) > 1.5 * _LABEL_HEIGHT:
                labels.append((level, place, shown[n]))
            else:
                passed.setdefault(level, []).append((gap, place, shown[n]))
    # An isoline that found no free place gets its least crowded one.
    for level in set(passed) - {level for level, _, _ in labels}:
        _, place, where = max(passed[level], key=lambda candidate: candidate[0])
        labels.append((level, place, where))
    return [(float(place[0]), float(place[1])) for _, place, _ in labels]


def _bilinear(
    x: NDArray[np.float64], y: NDArray[np.float64], z: NDArray[np.float64], points: NDArray[np.float64]
) -> NDArray[np.float64]:
    column = np.clip(np.searchsorted(x, points[:, 0]) - 1, 0, x.size - 2)
    row = np.clip(np.searchsorted(y, points[:, 1]) - 1, 0, y.size - 2)
    right = (points[:, 0] - x[column]) / (x[column + 1] - x[column])
    up = (points[:, 1] - y[row]) / (y[row + 1] - y[row])
    below = z[row, column] * (1.0 - right) + z[row, column + 1] * right
    above = z[row + 1, column] * (1.0 - right) + z[row + 1, column + 1] * right
    return below * (1.0 - up) + above * up
