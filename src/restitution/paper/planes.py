"""Figures 3 and 4: isolines of the restitution coefficient over the plane of p2 and p3."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from restitution.plot import style
from restitution.plot.contours import contour_map
from restitution.plot.labels import LOG_P2, LOG_P3, RESTITUTION

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from restitution.paper.computation import Computation

LOG_P2_RANGE = (-3.0, 1.0)
LOG_P3_RANGE = (-2.0, 2.0)

LEVELS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.25, *(round(0.1 * i, 1) for i in range(3, 10)), 0.95, 0.98)

# Across the lower flank, the upper one, and both where they meet.
_LABELS = (((-2.1, -2.0), (-2.8, 1.3)), ((-2.6, 1.05), (-0.1, 1.85)), ((-1.6, 0.0), (0.8, -1.0)))

POISSON_RATIOS = {3: 0.45, 4: 0.5}


def compute(computation: Computation, figure: int, n: int) -> xr.Dataset:
    """Return the restitution coefficient on an n x n grid of the plane, for the figure's Poisson ratio."""
    nu = POISSON_RATIOS[figure]
    axes = {"p2": np.logspace(*LOG_P2_RANGE, n), "p3": np.logspace(*LOG_P3_RANGE, n)}
    return computation.dataset(
        f"Figure {figure}: restitution coefficient over p2 and p3, {title(nu)}", figure, axes, nu
    )


def title(poisson_ratio: float) -> str:
    """Return the words for a Poisson ratio: its value, or `incompressible`."""
    return "incompressible" if poisson_ratio == 0.5 else f"nu = {poisson_ratio:g}"


def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure of a plane as computed by `compute`."""
    from matplotlib.colors import Normalize

    nu = float(dataset["poisson_ratio"])
    with style.context():
        figure = style.new_figure(5.2, 4.6)
        ax = figure.add_subplot()
        ax.set_xlabel(LOG_P2)
        ax.set_ylabel(LOG_P3)
        ax.set_xticks(range(-3, 2))
        ax.set_yticks(range(-2, 3))
        ax.set_title(
            f"{RESTITUTION}, " + (r"incompressible ($\nu = 0.5$)" if nu == 0.5 else rf"$\nu = {nu:g}$")
        )
        contour_map(
            ax,
            np.log10(dataset["p2"].values),
            np.log10(dataset["p3"].values),
            dataset["restitution_coefficient"].transpose("p3", "p2").values,
            LEVELS,
            label_along=_LABELS,
            cmap=style.SEQUENTIAL,
            norm=Normalize(0.0, 1.0),
        )
    return figure
