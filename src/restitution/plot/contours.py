"""Contour maps with labelled isolines."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from restitution.plot import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def contour_map(
    ax: Axes,
    x: Any,
    y: Any,
    z: Any,
    levels: Sequence[float],
    *,
    fmt: str | Callable[[float], str] = "%g",
    fill: Sequence[float] | None = None,
    cmap: str = style.SEQUENTIAL,
    norm: Any = None,
    line_color: str = style.BLACK,
) -> Axes:
    """Draw labelled isolines of z(x, y), over a pale fill of bands if wanted.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    x, y : array-like, shapes (n,), (m,)
        Grid lines.
    z : array-like, shape (m, n)
        The values.
    levels : sequence of float
        The isolines, ascending; those that the values do not reach are left out.
    fmt : str or callable
        The isolines' labels.
    fill : sequence of float, optional
        Borders of the filled bands, ascending; no fill if absent.
    cmap, norm
        The fill's colours.
    line_color : str
        Colour of isolines and labels.

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
    if fill is not None:
        bands = ax.contourf(x, y, z, levels=list(fill), cmap=cmap, norm=norm, alpha=0.6, extend="both")
        # As vectors the bands would leave hairlines of the page between them in PDF viewers.
        bands.set_rasterized(True)
    reached = [level for level in levels if np.nanmin(z) < level < np.nanmax(z)]
    if reached:
        lines = ax.contour(x, y, z, levels=reached, colors=line_color, linewidths=0.8, linestyles="solid")
        ax.clabel(lines, fmt=fmt, fontsize=8, inline=True, inline_spacing=3)
    return ax
