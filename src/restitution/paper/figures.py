"""Figures 3 to 6 of the paper: restitution over its dimensionless groups, as data and as pictures.

Figures 3 and 4 have isolines over p2 and p3 for one Poisson ratio, figures 5 and 6 curves over p3 for several.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np

from restitution.errors import RestitutionWarning
from restitution.impact.status import SolverError, Status
from restitution.plot import style
from restitution.plot.style import contour_map, curve_family
from restitution.quantities import INPUTS, OUTPUTS, VALIDITY
from restitution.sweeps.grid import Logarithmic, LogUniform
from restitution.sweeps.run import sweep

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CITATION = (
    "E. Willert, J.-E. Leroy, M. Satora, Y. Scholtyssek, The Influence of Compressibility on the Restitution "
    "Coefficient for Viscoelastic Spheres in Low-Velocity Normal Impacts"
)
GUESSED = (
    "The text of the paper gives nu = 0.45 and the incompressible limit for figures 3 and 4, and log10 p2 = -2 and -3 "
    "for figures 5 and 6. The ranges of the axes, the isolines, the list of Poisson ratios of figures 5 and 6, and "
    "the ranges of the random inputs are chosen here."
)

LOG_P2_RANGE, LOG_P3_RANGE = (-3.0, 1.0), (-2.0, 2.0)
BODIES = {
    "mass": LogUniform(1e-6, 1.0),
    "radius": LogUniform(1e-4, 1e-1),
    "velocity": LogUniform(1e-3, 1e1),
    "equilibrium_modulus": LogUniform(1e4, 1e8),
}
"""Distributions of the random inputs m [kg], R [m], v0 [m/s] and Ginf [Pa]."""


def p2_axis(n: int) -> Logarithmic:
    """Return n values of p2 = Ginf/G1 over the range of the figures."""
    return Logarithmic(10.0 ** LOG_P2_RANGE[0], 10.0 ** LOG_P2_RANGE[1], n)


def p3_axis(n: int) -> Logarithmic:
    """Return n values of p3 = eta (v0 R/(m^2 Ginf^3))^(1/5) over the range of the figures."""
    return Logarithmic(10.0 ** LOG_P3_RANGE[0], 10.0 ** LOG_P3_RANGE[1], n)


def instantaneous_poisson_ratio(nu: Any, p2: Any) -> Any:
    """Return the instantaneous Poisson ratio nu_0 = (3 K - 2 G0)/(6 K + 2 G0) of the paper's material.

    The bulk modulus K is constant, and the static Poisson ratio nu belongs to the equilibrium modulus Ginf. A stiff
    glass, G0 = Ginf (1 + 1/p2), has another Poisson ratio, which is negative where `p2 < (1 - 2 nu)/(3 nu)`. The
    arguments nu and p2 = Ginf/G1 are numbers, arrays or DataArrays.

    Examples
    --------
    >>> print(round(instantaneous_poisson_ratio(0.49, 1e-3), 3), round(instantaneous_poisson_ratio(0.499, 4.5e-3), 3))
    -0.806 0.306
    """
    # K/Ginf = 2 (1 + nu)/(3 (1 - 2 nu)), multiplied by the factor that is zero in the incompressible limit.
    bulk = 2.0 * (1.0 + nu) / 3.0
    glass = (1.0 - 2.0 * nu) * (1.0 + 1.0 / p2)
    return (3.0 * bulk - 2.0 * glass) / (6.0 * bulk + 2.0 * glass)


@dataclass
class Computation:
    """Options of the computation: seed of the random inputs, tolerance of e, threads, report of progress.

    `advance` is called with the number of impacts solved since the last call.
    """

    seed: int
    rtol: float = 1e-9
    workers: int | None = None
    advance: Callable[[int], None] = field(default=lambda _: None, repr=False)

    def sweep(self, title: str, axes: Mapping[str, Any], base: Any = None) -> xr.Dataset:
        """Return the restitution coefficient over the axes of `rs.sweep`; every impact must be solved."""
        counted = 0

        def progress(done: int, _: int) -> None:
            nonlocal counted
            if done > counted:
                self.advance(done - counted)
                counted = done

        with warnings.catch_warnings():
            # Random bodies exceed the limits of the theory; here only solutions of its equations are compared.
            warnings.simplefilter("ignore", RestitutionWarning)
            table = sweep(
                base, axes, ["restitution_coefficient"], rtol=self.rtol, workers=self.workers, progress=progress
            )
        status = table["status"].values.ravel()
        if (failed := np.flatnonzero(status >= Status.TOO_MANY_STEPS)).size:
            raise SolverError(Status(int(status[failed[0]])), f"{title}: impact {failed[0]}")
        table = table.drop_vars("status").assign_attrs({"title": title, **self.attributes()})
        if {"poisson_ratio", "p2"} <= set(table.coords):
            table["instantaneous_poisson_ratio"] = instantaneous_poisson_ratio(table["poisson_ratio"], table["p2"])
        return described(table)

    def attributes(self) -> dict[str, Any]:
        """Return the attributes that describe how the numbers were computed."""
        return {
            "source": f"restitution {version('restitution')}",
            "method": "exact",
            "rtol": self.rtol,
            "seed": self.seed,
            "guessed": GUESSED,
            "references": CITATION,
        }


def described(dataset: xr.Dataset, **words: str) -> xr.Dataset:
    """Return a dataset whose variables have the words, units and symbols of the registry, or the words given here."""
    registry = {**INPUTS, **OUTPUTS, **VALIDITY}
    for name in map(str, dataset.variables):
        if name in words:
            dataset[name].attrs = {"long_name": words[name], "units": "1"}
        elif name in registry:
            dataset[name].attrs = registry[name].attributes
    return dataset


# Pictures.

LEVELS = (0.01, 0.02, 0.05, 0.1, 0.2, *(round(0.1 * i, 1) for i in range(3, 10)), 0.95, 0.98)

PLANES = {3: 0.45, 4: 0.5}
"""Poisson ratios of figures 3 and 4."""

# The isolines nearest to these points get their labels there.
_LABELS = {
    0.45: (
        (-2.81, 1.25), (-2.35, 0.9), (-2.3, -0.17), (-2.2, -0.35), (-2.1, -0.52), (-2.0, -0.68), (-1.9, -0.86),
        (-1.8, -1.08), (-1.7, -1.43), (-1.6, -1.75), (0.7, 0.0),
    ),
    0.5: (
        (-2.84, 0.885), (-2.6, 0.69), (-2.5, 0.41), (-2.4, 0.19), (-2.3, -0.08), (-2.2, -0.27), (-2.1, -0.43),
        (-2.0, -0.59), (-1.9, -0.75), (-1.8, -0.92), (-1.7, -1.15), (-1.6, -1.49), (-1.5, -1.8), (0.55, 0.13),
    ),
}  # fmt: skip

CURVES = {5: -2.0, 6: -3.0}
"""log10 p2 of figures 5 and 6."""

POISSON_RATIOS = (-1.0, -0.5, 0.0, 0.2, 0.3, 0.4, 0.45, 0.49, 0.499)

LOG_P2 = r"$\log_{10}\,p_2,\quad p_2 = G_\infty\,/\,G_1$"
P3 = r"$p_3 = \eta\,\left[v_0 R\,/\,(m^2 G_\infty^3)\right]^{1/5}$"
LOG_P3 = r"$\log_{10}\,p_3,\quad p_3 = \eta\,[v_0 R\,/\,(m^2 G_\infty^3)]^{1/5}$"
RESTITUTION = r"restitution coefficient $e$"


def panels(mosaic: str, width: float = style.PAGE_WIDTH, height: float = 3.4) -> tuple[Figure, list[Axes]]:
    """Return a figure with a panel for each letter, laid out at the 300 dots per inch of its files."""
    return style.panels(mosaic, width, height, dpi=300.0)


def compute_plane(computation: Computation, figure: int, n: int) -> xr.Dataset:
    """Return the restitution coefficient on an n x n grid of the plane, for the Poisson ratio of figure 3 or 4."""
    nu = PLANES[figure]
    words = "incompressible" if nu == 0.5 else f"nu = {nu:g}"
    title = f"Figure {figure}: restitution coefficient over p2 and p3, {words}"
    return computation.sweep(title, {"poisson_ratio": nu, "p2": p2_axis(n), "p3": p3_axis(n)})


def plane_axes(ax: Axes) -> None:
    """Label the axes of a plane of p2 and p3."""
    ax.set(xlabel=LOG_P2, ylabel=LOG_P3, xticks=range(-3, 2), yticks=range(-2, 3))


def mark_negative_glass(ax: Axes, nu: float) -> None:
    """Hatch the part of a plane where the instantaneous Poisson ratio is negative: p2 < (1 - 2 nu)/(3 nu)."""
    if nu == 0.5:
        return
    edge = min(float(np.log10((1.0 - 2.0 * nu) / (3.0 * nu))), LOG_P2_RANGE[1])
    low, high = LOG_P3_RANGE
    # Dots neither cover the isolines nor look like them.
    dots: Any = {"facecolor": "none", "edgecolor": "#00000028", "hatch": "..", "linewidth": 0, "zorder": 1.5}
    ax.fill_between([LOG_P2_RANGE[0], edge], low, high, **dots)
    ax.axvline(edge, color="black", linewidth=0.8, linestyle=(0, (4, 3)))
    box: Any = {"fontsize": 8, "bbox": {"facecolor": "white", "edgecolor": "none", "pad": 1.0, "alpha": 0.85}}
    ax.text(edge - 0.06, low + 0.07, r"$\nu_0 < 0$", ha="right", va="bottom", **box)
    ax.text(edge + 0.06, low + 0.07, r"$\nu_0 > 0$", ha="left", va="bottom", **box)


def draw_plane(dataset: xr.Dataset) -> Figure:
    """Return figure 3 or 4 as computed by `compute_plane`."""
    from matplotlib.colors import Normalize

    nu = float(dataset["poisson_ratio"])
    with style.context():
        figure, (ax,) = panels("A", 5.6, 4.6)
        plane_axes(ax)
        words = r"incompressible ($\nu = \nu_0 = 0.5$)" if nu == 0.5 else rf"$\nu = {nu:g}$"
        ax.set_title(f"{RESTITUTION}, {words}")
        contour_map(
            ax,
            np.log10(dataset["p2"].values),
            np.log10(dataset["p3"].values),
            dataset["restitution_coefficient"].transpose("p3", "p2").values,
            LEVELS,
            style.Shading(RESTITUTION, Normalize(0.0, 1.0)),
            labels_at=_LABELS[nu],
        )
        mark_negative_glass(ax, nu)
    return figure


def compute_curves(computation: Computation, figure: int, n: int) -> xr.Dataset:
    """Return the restitution coefficient at n values of p3 per Poisson ratio, the last one incompressible."""
    title = f"Figure {figure}: restitution coefficient over p3 for several Poisson ratios"
    axes = {"poisson_ratio": [*POISSON_RATIOS, 0.5], "p2": 10.0 ** CURVES[figure], "p3": p3_axis(n)}
    return computation.sweep(title, axes)


def curve_axes(ax: Axes) -> None:
    """Scale and label the axes of curves over p3."""
    ax.set(xscale="log", xlim=[10.0**end for end in LOG_P3_RANGE], ylim=(0.0, 1.0), xlabel=P3, ylabel=RESTITUTION)
    ax.grid(True)


def draw_curves(dataset: xr.Dataset) -> Figure:
    """Return figure 5 or 6 as computed by `compute_curves`, with thin lines where nu_0 is negative."""
    restitution = dataset["restitution_coefficient"].transpose("poisson_ratio", "p3").values
    p2, ratios = float(dataset["p2"]), dataset["poisson_ratio"].values[:-1]
    glassy = instantaneous_poisson_ratio(ratios, p2)
    labels = [rf"$\nu = {nu:g}$  ($\nu_0 = {at:.2f}$)" for nu, at in zip(ratios, glassy, strict=True)]
    with style.context():
        figure, (ax,) = panels("A", 6.8, 4.2)
        curve_axes(ax)
        curve_family(
            ax,
            dataset["p3"].values,
            restitution[:-1],
            labels,
            short=[f"{nu:g}".replace("-", "\u2212") for nu in ratios],
            limit=restitution[-1],
            limit_label=r"incompressible ($\nu_0 = 0.5$)",
        )
        for line, at in zip(ax.lines, [*glassy, 0.5], strict=False):
            line.set_linewidth(1.1 if at < 0.0 else 2.2)
        ax.set_title(rf"$\log_{{10}}\,p_2 = {np.log10(p2):g}$;  thin lines: $\nu_0 < 0$")
        handles: Any = ax.get_legend_handles_labels()
        figure.legend(*handles, loc="outside right center", fontsize=7.5)
    return figure
