"""Families of curves over one axis, ordered by a parameter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_DASHES: tuple[Any, ...] = ("-", (0, (5, 1.2)), (0, (5, 1.2, 1, 1.2)))


def family_colors(n: int, *, cmap: str = "viridis", high: float = 0.88) -> list[tuple[float, ...]]:
    """Return `n` colours in the order of their lightness; the palest end, lost on white paper, is left out.

    Examples
    --------
    >>> len(family_colors(9))
    9
    """
    from matplotlib import colormaps

    return [tuple(map(float, color)) for color in colormaps[cmap](np.linspace(0.0, high, n))]


def curve_family(
    ax: Axes, x: Any, curves: Any, labels: Sequence[str], *, limit: Any = None, limit_label: str = "limit"
) -> Axes:
    """Draw curves in the order of their parameter, and a limiting one as a thin black line.

    Colour runs with the parameter and the dashes repeat in threes: neighbours differ without colour too.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw; scales and labels of the axes are left to the caller.
    x : array-like, shape (n,)
        Abscissa of all curves.
    curves : array-like, shape (n_curve, n)
        One row each.
    labels : sequence of str
        Their legend entries.
    limit : array-like, shape (n,), optional
        The limiting curve.
    limit_label : str
        Its legend entry.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`.

    Raises
    ------
    ValueError
        If there is not one label for each curve.

    Examples
    --------
    >>> from restitution.plot.style import new_figure
    >>> ax = curve_family(new_figure().add_subplot(), [0, 1], [[0, 1], [1, 2]], ["a", "b"], limit=[2, 3])
    >>> [line.get_label() for line in ax.lines]
    ['a', 'b', 'limit']
    """
    rows = np.atleast_2d(np.asarray(curves, dtype=np.float64))
    if len(labels) != len(rows):
        raise ValueError(f"labels has {len(labels)} entries: must have {len(rows)}, one for each curve")
    for index, (row, label, color) in enumerate(zip(rows, labels, family_colors(len(rows)), strict=True)):
        ax.plot(x, row, color=color, linestyle=_DASHES[index % len(_DASHES)], linewidth=1.5, label=label)
    if limit is not None:
        ax.plot(x, limit, color="black", linewidth=0.6, label=limit_label)
    return ax
