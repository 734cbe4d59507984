"""One impact on a page."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from restitution.plot import style
from restitution.plot.energy import energy_area, energy_bar
from restitution.plot.history import contact_radius_time, depth_time, force_indentation, force_time
from restitution.plot.labels import scaled_unit
from restitution.plot.pressure import pressure_radius

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from restitution.impact.result import ImpactResult


def overview(result: ImpactResult, times: ArrayLike | None = None, *, figure: Figure | None = None) -> Figure:
    """Draw one impact on a page: force, loop, depth, contact radius, pressure at some instants, energies.

    Only the exact method tells pressure and energy over time. With the element method a bar shows where the
    energy went in the end.

    Parameters
    ----------
    result : ImpactResult
        The result of one impact, not of an array of them.
    times : array_like, optional
        Times [s] at which to show the pressure, at most seven; four where left out.
    figure : matplotlib.figure.Figure, optional
        An empty figure to draw into, e.g. `matplotlib.pyplot.figure()`; by default a new one, which needs no
        display.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, to be saved with `figure.savefig(...)` or `restitution.plot.style.save_figure`.
    """
    history = result.history
    exact = result.method == "exact"
    budget = not exact and isfinite(result.energy.dissipated)
    heights = [1.0, 1.0, *([1.0] if exact else [0.62] if budget else [])]
    with style.context():
        page = style.new_figure(style.PAGE_WIDTH, 0.3 + 2.4 * sum(heights)) if figure is None else figure
        grid: Any = page.add_gridspec(len(heights), 2, height_ratios=heights)
        panels: list[Any] = [page.add_subplot(grid[row, column]) for row in (0, 1) for column in (0, 1)]
        force_time(panels[0], history)
        force_indentation(panels[1], history)
        depth_time(panels[2], history)
        contact_radius_time(panels[3], history)
        if exact:
            panels += [page.add_subplot(grid[2, column]) for column in (0, 1)]
            pressure_radius(panels[4], result, times)
            energy_area(panels[5], history)
        elif budget:
            panels.append(page.add_subplot(grid[2, :]))
            energy_bar(panels[4], result.energy)
        for panel, letter in zip(panels, "abcdef", strict=False):
            style.panel_label(panel, f"({letter})")
        _title(page, result)
        # Tick labels are made when drawn: make them now, while the fonts are those of the package.
        page.draw_without_rendering()
    return page


def _title(page: Figure, result: ImpactResult) -> None:
    duration = scaled_unit(result.contact_time, "s")
    page.suptitle(
        rf"$e = {float(result.restitution_coefficient):.4g}$,  "
        rf"contact time {float(result.contact_time) * duration.factor:.4g} {duration.unit}",
        fontsize=11,
    )
