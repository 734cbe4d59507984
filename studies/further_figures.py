"""Figures beyond the paper: error of the incompressible value, collapse, examples, several relaxation times.

Each is written as PNG, PDF and NetCDF data into a folder: `python studies/further_figures.py OUT`, with `--quick` for
coarse grids. They show the data that the claims of `restitution reproduce` are judged by.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from restitution.files import write_netcdf
from restitution.paper import figures
from restitution.paper.claims import EXAMPLES, TERMS, compare, compute_collapse, compute_terms
from restitution.paper.figures import (
    LOG_P3_RANGE,
    P3,
    RESTITUTION,
    Computation,
    curve_axes,
    instantaneous_poisson_ratio,
    mark_negative_glass,
    panels,
    plane_axes,
)
from restitution.paper.reproduction import DEFAULT_SEED, FULL, QUICK, Resolution
from restitution.plot import style
from restitution.plot.style import contour_map, markers, save_figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ERROR_LEVELS = (-90, -80, -60, -30, -10, -3, -1, 3, 10, 30, 100)
_EXCESS_LEVELS = (1, 3, 10, 30, 100, 300, 1000)
_ERROR_LABELS = (
    *((-2.35, y) for y in (-1.6, -1.1, -0.48, 0.01, 0.23, 0.44, 0.66)),
    (-2.82, 1.42), (-2.45, 1.65), (-2.15, 1.72), (-1.76, 1.72),
)  # fmt: skip
_EXCESS_LABELS = tuple((-2.35, y) for y in (-1.6, -1.1, -0.54, -0.07, 0.16, 0.37, 0.69))
_SPREAD_FLOOR = 1e-17
# Beside the points [decades].
_MARGIN = 0.15


def write(out: Path | str, resolution: Resolution = FULL, seed: int = DEFAULT_SEED) -> list[Path]:
    """Compute and draw the four figures; return the files."""
    out, files = Path(out), []
    out.mkdir(parents=True, exist_ok=True)
    computation = Computation(seed)
    planes = [figures.compute_plane(computation, n, resolution.plane) for n in figures.PLANES]
    drawings = {
        "figure_incompressibility": (compare(*planes), draw_error),
        "figure_collapse": (compute_collapse(computation, resolution.collapse, resolution.draws), draw_collapse),
        "figure_examples": (compute_examples(computation, resolution.curve), draw_examples),
        "figure_relaxation_times": (compute_terms(computation, resolution.curve), draw_terms),
    }
    for name, (dataset, draw) in drawings.items():
        write_netcdf(dataset, out / f"{name}.nc")
        picture = draw(dataset)
        files += [out / f"{name}.nc", save_figure(picture, out / f"{name}.png")]
        # The page keeps the layout of the picture; a new layout takes as long as all other drawing.
        picture.set_layout_engine("none")
        files.append(save_figure(picture, out / f"{name}.pdf"))
    return files


def draw_error(dataset: xr.Dataset) -> Figure:
    """Return the figure of a comparison as made by `compare`: both relative errors, in percent."""
    from matplotlib.colors import LogNorm, TwoSlopeNorm

    nu = float(dataset["poisson_ratio"])
    x, y = np.log10(dataset["p2"].values), np.log10(dataset["p3"].values)
    error, excess = (100.0 * dataset[f"relative_{name}"].transpose("p3", "p2").values for name in ("error", "excess"))
    words = r"$(e_\mathrm{inc} - e)\,/\,e$ [%]", r"$(e - e_\mathrm{inc})\,/\,e_\mathrm{inc}$ [%]"
    signed = style.Shading(words[0], TwoSlopeNorm(0.0, vmin=-100.0, vmax=150.0), style.DIVERGING)
    above = style.Shading(words[1], LogNorm(0.1, 1e4, clip=True), "YlOrBr")
    with style.context():
        figure, (left, right) = panels("AB", height=3.6)
        figure.suptitle(rf"error of the incompressible value for $\nu = {nu:g}$", fontsize=11)
        for ax in (left, right):
            plane_axes(ax)
        right.set_ylabel("")
        contour_map(left, x, y, error, _ERROR_LEVELS, signed, fmt=_signed, labels_at=_ERROR_LABELS)
        contour_map(right, x, y, excess, _EXCESS_LEVELS, above, labels_at=_EXCESS_LABELS)
        # A logarithmic scale has no place for the region where the incompressible value is the higher one.
        right.contourf(x, y, error, levels=[0.0, np.inf], colors="white")
        for ax in (left, right):
            ax.contour(x, y, error, levels=[0.0], colors="black", linewidths=1.6)
            mark_negative_glass(ax, nu)
        right.text(-2.35, 1.6, r"$e_\mathrm{inc} > e$", ha="center", va="center")
    return figure


def _signed(level: float) -> str:
    return f"{level:g}".replace("-", "\u2212")


def draw_collapse(dataset: xr.Dataset) -> Figure:
    """Return the figure of the draws over the viscosity, over p3, and of their spread."""
    p2 = float(dataset["p2"].sel(p2=1e-2, method="nearest"))
    e = dataset["restitution_coefficient"].sel(p2=p2).isel(poisson_ratio=0).transpose("p3", "draw")
    nu, draws = float(e["poisson_ratio"]), e.sizes["draw"]
    viscosity = dataset["viscosity"].transpose("p3", "draw").values
    with style.context():
        figure, axes = panels("ABC", height=3.1)
        for ax, across in zip(
            axes[:2], (viscosity, np.broadcast_to(dataset["p3"].values[:, None], e.shape)), strict=True
        ):
            # Over p3 the draws coincide, so that a colour for each would show the last one alone.
            color: Any = {} if ax is axes[0] else {"color": "black"}
            ax.semilogx(across, e.values, ".", markersize=3.5, markeredgewidth=0, **color)
            ax.set(ylim=(0.0, 1.0))
            ax.set_title(rf"$\nu = {nu:g}$, $\log_{{10}}\,p_2 = {np.log10(p2):.3g}$", fontsize=8.5)
        axes[0].annotate(
            f"{draws} draws,\na colour each", (0.5, 0.06), xycoords="axes fraction", ha="center", fontsize=8
        )
        axes[1].annotate(
            f"{draws} draws\nin every point", (0.5, 0.06), xycoords="axes fraction", ha="center", fontsize=8
        )
        axes[0].set(xlabel=r"viscosity $\eta$ [Pa s]", ylabel=RESTITUTION)
        # The margin shows the points at the ends whole.
        axes[1].set(xlabel=P3, xlim=[10.0 ** (end + np.sign(end) * _MARGIN) for end in LOG_P3_RANGE])
        _draw_spread(axes[2], dataset)
        axes[2].set_title(f"{draws} draws at each point $(p_2, p_3)$", fontsize=8.5)
    return figure


def _draw_spread(ax: Axes, dataset: xr.Dataset) -> None:
    rtol = float(dataset.attrs["rtol"])
    spread = np.maximum(dataset["spread"].values, _SPREAD_FLOOR)
    top = int(np.ceil(np.log10(max(rtol, float(spread.max()))))) + 1
    bins: Any = np.logspace(-17.25, top, 2 * (top + 17) + 1)
    looks: Any = (("stepfilled", style.SKY_BLUE), ("step", "black"))
    for nu, values, (kind, color) in zip(dataset["poisson_ratio"].values, spread, looks, strict=True):
        label = "incompressible" if nu == 0.5 else rf"$\nu = {nu:g}$"
        ax.hist(values.ravel(), bins, histtype=kind, color=color, label=label)
    ax.axvline(rtol, color=style.VERMILION, linewidth=1.0, linestyle="--", label="tolerance")
    ax.set(xscale="log", xlabel="largest spread of $e$ at a point", ylabel="number of points")
    ticks = range(-17, top, 2 if top < -6 else 4)
    ax.set_xticks([10.0**power for power in ticks], ["0" if power == -17 else f"$10^{{{power}}}$" for power in ticks])
    ax.minorticks_off()
    # Counts grow to the left, so that the space beside the tolerance stays free.
    ax.set(xlim=(bins[0], bins[-1]), ylim=(0.0, 1.35 * ax.get_ylim()[1]))
    ax.legend(loc="upper left", bbox_to_anchor=(0.18, 1.0))


def compute_examples(computation: Computation, n: int) -> xr.Dataset:
    """Return e over n values of p3, the `EXAMPLES` among them, for their Poisson ratios, the limit and their p2."""
    ratios, p2, points = zip(*EXAMPLES, strict=True)
    p3 = np.sort([*np.logspace(*LOG_P3_RANGE, n - len(points)), *points])
    title = "The paper's example, and one with the glass of a polymer"
    return computation.sweep(title, {"poisson_ratio": [*ratios, 0.5], "p2": list(p2), "p3": p3})


def draw_examples(dataset: xr.Dataset) -> Figure:
    """Return the figure of the examples as computed by `compute_examples`, a panel each."""
    from matplotlib.patheffects import withStroke

    halo = [withStroke(linewidth=2.5, foreground="white")]
    with style.context():
        figure, axes = panels("AB")
        for ax, (nu, p2, p3) in zip(axes, EXAMPLES, strict=True):
            curve_axes(ax)
            ax.set(yscale="log", ylim=(3e-3, 1.0))
            words = rf"$\nu = {nu:g}$, $\nu_0 = {instantaneous_poisson_ratio(nu, p2):.2f}$"
            look: Any = {"color": style.BLUE, "linewidth": 1.6, "label": words}
            limit: Any = {"color": "black", "linewidth": 0.9, "linestyle": "--", "label": "incompressible"}
            for ratio, options, offset in ((nu, look, (-8, 7)), (0.5, limit, (6, -3))):
                e = dataset["restitution_coefficient"].sel(poisson_ratio=ratio, p2=p2)
                ax.plot(e["p3"].values, e.values, **options)
                value = float(e.sel(p3=p3))
                ax.plot([p3], [value], "o", color="black", markersize=4)
                label: Any = {"textcoords": "offset points", "fontsize": 8.5, "path_effects": halo}
                ax.annotate(f"{value:.4f}", (p3, value), offset, **label)
            ax.set_title(rf"$p_2 = {p2:g}$; points: $p_3 = {p3:g}$", fontsize=9)
            ax.legend(loc="lower left")
        axes[1].set_ylabel("")
    return figure


def draw_terms(dataset: xr.Dataset) -> Figure:
    """Return the figure of several relaxation times as computed by `compute_terms`."""
    with style.context():
        figure, axes = panels("AB")
        for ax, nu in zip(axes, dataset["poisson_ratio"].values, strict=True):
            curve_axes(ax)
            labels = "one relaxation time", "two relaxation times", "three relaxation times"
            looks = zip(TERMS, labels, (style.BLACK, style.BLUE, style.ORANGE), ("-", "--", "-."), strict=True)
            for terms, label, color, dashes in looks:
                e = dataset["restitution_coefficient"].sel(poisson_ratio=nu, terms=terms)
                look: Any = {"linestyle": dashes} | markers(e.size)
                ax.plot(dataset["p3"].values, e.values, color=color, label=label, **look)
            words = "incompressible" if nu == 0.5 else rf"$\nu = {nu:g}$"
            ax.set_title(rf"{words}, $\log_{{10}}\,p_2 = {np.log10(float(dataset['p2'])):g}$", fontsize=9)
        axes[1].set_ylabel("")
        axes[0].legend(loc="upper right", bbox_to_anchor=(0.97, 1.0))
    return figure


def main() -> None:
    """Write the figures into a folder."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--seed", type=int, default=DEFAULT_SEED)
    options = parser.parse_args()
    for path in write(options.out, QUICK if options.quick else FULL, options.seed):
        print(path)


if __name__ == "__main__":
    main()
