"""Contour maps with labelled isolines."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.plot import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
Segment = tuple[tuple[float, float], tuple[float, float]]

_SAMPLES = 2001

_LABEL_WIDTH = 26.0
_LABEL_HEIGHT = 7.0
_CHARACTER_WIDTH = 4.0
_GAP = 4.0
"""Room that a label of 8 points takes [points]."""

_STEP = 2.0
"""Distance of the places on an isoline that may take its label [points]."""

# Of a noisy map no reader wants them all.
_MOST_LABELS = 60


class _Label(NamedTuple):
    """Where a label goes: in the numbers of the axes, and on the page [pixels]."""

    level: float
    place: Array
    shown: Array


class _Curve(NamedTuple):
    """A connected part of an isoline on the page [pixels]."""

    level: float
    word: str
    points: Array
    length: float


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
        the frame nor, if avoidable, other labels and isolines. What they do not cross is labelled where it
        is straight and there is room, if it is long enough.
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
    labels = _label_places(ax, x, y, z, reached, label_along)
    words = [fmt % level if isinstance(fmt, str) else fmt(level) for level in reached]
    labels += _free_places(ax, lines.allsegs, reached, words, labels)
    # The gap beside a label counts in pixels.
    spacing = round(0.5 * _GAP / 72.0 * figure.dpi)
    places: Any = [(float(label.place[0]), float(label.place[1])) for label in labels]
    ax.clabel(lines, fmt=fmt, fontsize=8, inline=True, inline_spacing=spacing, manual=places)
    return ax


def _label_places(
    ax: Axes,
    x: Array,
    y: Array,
    z: Array,
    levels: Sequence[float],
    segments: Sequence[Segment],
) -> list[_Label]:
    """Places on given lines."""
    point = ax.get_figure(root=True).dpi / 72.0  # pyright: ignore[reportOptionalMemberAccess]
    frame = ax.get_window_extent().padded(-_LABEL_WIDTH / 2 * point)
    labels: list[_Label] = []
    passed: dict[float, list[tuple[float, _Label]]] = {}
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
                np.hypot(*(shown[n] - other.shown)) / point - (_LABEL_WIDTH if level == other.level else 0.0)
                for other in labels
            ]
            if not frame.contains(*shown[n]):
                continue
            if gap > _LABEL_HEIGHT and min(others, default=np.inf) > 1.5 * _LABEL_HEIGHT:
                labels.append(_Label(level, place, shown[n]))
            else:
                passed.setdefault(level, []).append((gap, _Label(level, place, shown[n])))
    # An isoline that found no free place gets its least crowded one.
    left = sorted(set(passed) - {label.level for label in labels})
    return labels + [max(passed[level], key=lambda candidate: candidate[0])[1] for level in left]


def _free_places(
    ax: Axes,
    segments: Any,
    levels: Sequence[float],
    words: Sequence[str],
    labels: Sequence[_Label],
) -> list[_Label]:
    """Places on lines that have no label yet: inside the frame, straight, away from other lines and labels."""
    from scipy.spatial import KDTree

    point = ax.get_figure(root=True).dpi / 72.0  # pyright: ignore[reportOptionalMemberAccess]
    curves = [
        _Curve(level, word, *_resampled(ax.transData.transform(segment), _STEP * point))
        for level, word, parts in zip(levels, words, segments, strict=True)
        for segment in parts
        if len(segment) > 1
    ]
    labelled = {
        min(
            (n for n, curve in enumerate(curves) if curve.level == label.level),
            key=lambda n: float(np.hypot(*(curves[n].points - label.shown).T).min()),
        )
        for label in labels
    }
    found: list[_Label] = []
    longest = sorted(range(len(curves)), key=lambda n: -curves[n].length)[:_MOST_LABELS]
    for n in longest:
        curve = curves[n]
        half = 0.5 * (_CHARACTER_WIDTH * len(curve.word) + _GAP) * point
        frame = ax.get_window_extent().padded(-half)
        free = np.array([frame.contains(*one) for one in curve.points])
        if n in labelled or curve.length < 4.0 * half or not free.any():
            continue
        others = [other.points for m, other in enumerate(curves) if m != n]
        taken = [label.shown for label in (*labels, *found)]
        reach = round(half / (_STEP * point))
        ends = np.clip(np.arange(len(free))[:, None] + [-reach, reach], 0, len(free) - 1)
        chord = np.hypot(*(curve.points[ends[:, 1]] - curve.points[ends[:, 0]]).T) / (2.0 * half)
        score = 4.0 * np.minimum(chord, 1.0) - np.abs(np.linspace(-0.5, 0.5, len(free)))
        for obstacles, room in ((others, 1.5 * _LABEL_HEIGHT * point), (taken, 3.0 * half)):
            if obstacles:
                away, _ = KDTree(np.vstack(obstacles)).query(curve.points, distance_upper_bound=room)
                score += np.minimum(away, room) / room
        best = curve.points[int(np.argmax(np.where(free, score, -np.inf)))]
        found.append(_Label(curve.level, ax.transData.inverted().transform(best), best))
    return sorted(found, key=lambda label: label.level)


def _resampled(points: Array, step: float) -> tuple[Array, float]:
    """Points at equal distances along a broken line, and its length."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    places = np.linspace(0.0, along[-1], max(2, int(along[-1] / step) + 1))
    return np.column_stack([np.interp(places, along, column) for column in points.T]), float(along[-1])


def _bilinear(x: Array, y: Array, z: Array, points: Array) -> Array:
    column = np.clip(np.searchsorted(x, points[:, 0]) - 1, 0, x.size - 2)
    row = np.clip(np.searchsorted(y, points[:, 1]) - 1, 0, y.size - 2)
    right = (points[:, 0] - x[column]) / (x[column + 1] - x[column])
    up = (points[:, 1] - y[row]) / (y[row + 1] - y[row])
    below = z[row, column] * (1.0 - right) + z[row, column + 1] * right
    above = z[row + 1, column] * (1.0 - right) + z[row + 1, column + 1] * right
    return below * (1.0 - up) + above * up
