"""How well random dimensional inputs collapse onto the three dimensionless groups."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from restitution.paper.planes import LOG_P2_RANGE, LOG_P3_RANGE
from restitution.plot import style
from restitution.plot.labels import P3, RESTITUTION

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from restitution.paper.computation import Computation

STREAM = 8
E_FLOOR = 1e-3
"""Below this restitution coefficient the solver's tolerance is absolute, `rtol * E_FLOOR`."""

_SPREAD_FLOOR = 1e-17
# Beside the points [decades].
_MARGIN = 0.15


def compute(computation: Computation, n: int, draws: int) -> xr.Dataset:
    """Return the restitution coefficient of several draws at each of n x n points, for nu = 0.45 and 0.5.

    `spread` is the largest difference between two draws at a point, `relative_spread` the same in units of
    the tolerance.
    """
    axes = {
        "poisson_ratio": np.array([0.45, 0.5]),
        "p2": np.logspace(*LOG_P2_RANGE, n),
        "p3": np.logspace(*LOG_P3_RANGE, n),
        "draw": np.arange(draws),
    }
    dataset = computation.dataset("Collapse of random dimensional inputs onto p1, p2 and p3", STREAM, axes)
    e = dataset["restitution_coefficient"]
    spread = e.max("draw") - e.min("draw")
    tolerance = computation.rtol * np.maximum(e.mean("draw"), E_FLOOR)
    dataset["spread"] = spread.assign_attrs(long_name="largest difference of e between two draws", units="1")
    dataset["relative_spread"] = (spread / tolerance).assign_attrs(
        long_name=f"largest difference of e between two draws over its tolerance, rtol max(e, {E_FLOOR:g})",
        units="1",
    )
    return dataset


def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure of the draws: scattered over viscosity, collapsed over p3, and their spread."""
    p2 = float(dataset["p2"].sel(p2=1e-2, method="nearest"))
    cloud: Any = dataset.sel(p2=p2).isel(poisson_ratio=0)
    e = cloud["restitution_coefficient"]
    p3 = e["p3"].broadcast_like(e).values.ravel()
    viscosity = cloud["viscosity"].transpose(*e.dims).values.ravel()
    with style.context():
        figure = style.new_figure(style.PAGE_WIDTH, 2.9)
        axes = [figure.add_subplot(1, 3, place) for place in (1, 2, 3)]
        for ax, across in zip(axes[:2], (viscosity, p3), strict=True):
            ax.semilogx(across, e.values.ravel(), ".", markersize=3.5, color=style.BLUE, markeredgewidth=0)
            ax.set_ylim(0.0, 1.0)
        axes[0].set_ylabel(RESTITUTION)
        axes[0].set_xlabel(r"viscosity $\eta$ [Pa s]")
        axes[1].set_xlabel(P3)
        # Points at the ends are to be seen whole.
        axes[1].set_xlim(10.0 ** (LOG_P3_RANGE[0] - _MARGIN), 10.0 ** (LOG_P3_RANGE[1] + _MARGIN))
        _draw_spread(axes[2], dataset)
        for ax, letter in zip(axes, "abc", strict=True):
            style.panel_label(ax, f"({letter})")
    return figure


def _draw_spread(ax: Axes, dataset: xr.Dataset) -> None:
    rtol = float(dataset.attrs["rtol"])
    spread = np.maximum(dataset["spread"].values, _SPREAD_FLOOR)
    top = int(np.ceil(np.log10(max(rtol, float(spread.max()))))) + 1
    bins = np.logspace(-17.25, top, 2 * (top + 17) + 1).tolist()
    looks = (("stepfilled", style.SKY_BLUE), ("step", "black"))
    for nu, values, (kind, color) in zip(dataset["poisson_ratio"].values, spread, looks, strict=True):
        label = "incompressible" if nu == 0.5 else rf"$\nu = {nu:g}$"
        ax.hist(values.ravel(), bins, histtype=kind, color=color, label=label)  # pyright: ignore[reportArgumentType]
    ax.axvline(rtol, color=style.VERMILION, linewidth=1.0, linestyle="--", label="tolerance")
    ax.set_xscale("log")
    ticks = range(-17, top, 4)
    ax.set_xticks(
        [10.0**power for power in ticks], ["0" if power == -17 else f"$10^{{{power}}}$" for power in ticks]
    )
    ax.minorticks_off()
    ax.set_xlim(bins[0], bins[-1])
    ax.set_xlabel("largest spread of $e$ at a point")
    ax.set_ylabel("number of points")
    # Counts grow to the left, so that the space beside the tolerance is free; headroom keeps it so.
    ax.set_ylim(top=1.35 * ax.get_ylim()[1])
    ax.legend(loc="upper left", bbox_to_anchor=(0.18, 1.0))
