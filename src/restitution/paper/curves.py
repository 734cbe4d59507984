"""Figures 5 and 6: the restitution coefficient over p3 for several Poisson ratios, at one p2 each."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from restitution.plot import style
from restitution.plot.curves import curve_family
from restitution.plot.labels import P3, RESTITUTION

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from restitution.paper.computation import Computation

POISSON_RATIOS = (-1.0, -0.5, 0.0, 0.2, 0.3, 0.4, 0.45, 0.49, 0.499)
LOG_P2 = {5: -2.0, 6: -3.0}
LOG_P3_RANGE = (-2.0, 2.0)


def compute(computation: Computation, figure: int, n: int) -> xr.Dataset:
    """Return the restitution coefficient at n values of p3 per Poisson ratio, the last incompressible."""
    axes = {
        "poisson_ratio": np.array([*POISSON_RATIOS, 0.5]),
        "p2": np.array([10.0 ** LOG_P2[figure]]),
        "p3": np.logspace(*LOG_P3_RANGE, n),
    }
    title = f"Figure {figure}: restitution coefficient over p3 for several Poisson ratios"
    return computation.dataset(title, figure, axes)


def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure of the curves as computed by `compute`."""
    restitution = dataset["restitution_coefficient"].isel(p2=0).transpose("poisson_ratio", "p3")
    labels = [rf"$\nu = {nu:g}$" for nu in dataset["poisson_ratio"].values[:-1]]
    with style.context():
        figure = style.new_figure(6.2, 4.0)
        ax = figure.add_subplot()
        curve_family(
            ax,
            dataset["p3"].values,
            restitution.values[:-1],
            labels,
            limit=restitution.values[-1],
            limit_label="incompressible",
        )
        ax.set_xscale("log")
        ax.set_xlim(10.0 ** LOG_P3_RANGE[0], 10.0 ** LOG_P3_RANGE[1])
        ax.set_ylim(0.0, 1.0)
        ax.set_xlabel(P3)
        ax.set_ylabel(RESTITUTION)
        ax.grid(True)
        ax.set_title(rf"$\log_{{10}}\,p_2 = {np.log10(float(dataset['p2'][0])):g}$")
        figure.legend(*ax.get_legend_handles_labels(), loc="outside right center")
    return figure
