"""Figures beyond the paper: error of the incompressible value, collapse, examples, several relaxation times."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from restitution.contact.profile import Parabola
from restitution.impact.problem import Impact
from restitution.impact.scaling import viscosity_unit
from restitution.material.classical import standard_solid
from restitution.material.conversion import bulk_factor
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material
from restitution.paper.computation import (
    BODIES,
    LOG_P3_RANGE,
    Computation,
    described,
    instantaneous_poisson_ratio,
    p2_axis,
    p3_axis,
)
from restitution.paper.figures import P3, RESTITUTION, curve_axes, mark_negative_glass, panels, plane_axes
from restitution.plot import style
from restitution.plot.lines import contour_map, markers
from restitution.sweeps.samples import Samples

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

E_FLOOR = 1e-3
"""Below this restitution coefficient the solver's tolerance is absolute, `rtol * E_FLOOR`."""

_SPREAD_FLOOR = 1e-17
# Beside the points [decades].
_MARGIN = 0.15

EXAMPLES = ((0.49, 1e-3, 10.0), (0.499, 4.5e-3, 6.0))
"""nu, p2, p3 of the paper's example and of one whose glass is that of a polymer, nu_0 = 0.3."""

TERMS = (1, 2, 3)
"""Numbers of relaxation times that are compared."""

_TERMS_P2 = 1e-2


def compare(compressible: xr.Dataset, incompressible: xr.Dataset) -> xr.Dataset:
    """Return the relative error of the incompressible value over a plane, by either of the two values as the measure.

    `relative_error` = (e_inc - e)/e cannot fall below -1; `relative_excess` = (e - e_inc)/e_inc has no upper bound:
    only by this measure can an underestimate be wrong by 100 % and more.

    Examples
    --------
    >>> import xarray as xr
    >>> compressible = xr.Dataset({"restitution_coefficient": ((), 0.2)}, {"poisson_ratio": 0.45})
    >>> incompressible = xr.Dataset({"restitution_coefficient": ((), 0.1)}, {"poisson_ratio": 0.5})
    >>> result = compare(compressible, incompressible)
    >>> float(result.relative_error), float(result.relative_excess)
    (-0.5, 1.0)
    """
    e = compressible["restitution_coefficient"]
    e_inc = incompressible["restitution_coefficient"].drop_vars("poisson_ratio")
    nu = float(compressible["poisson_ratio"])
    result = compressible.drop_vars("restitution_coefficient").assign(
        compressible=e, incompressible=e_inc, relative_error=(e_inc - e) / e, relative_excess=(e - e_inc) / e_inc
    )
    return described(
        result.assign_attrs(title=f"Error of the incompressible value for nu = {nu:g}"),
        compressible=f"restitution coefficient, nu = {nu:g}",
        incompressible="restitution coefficient, incompressible",
        relative_error="error of the incompressible value relative to the compressible one",
        relative_excess="excess of the compressible value relative to the incompressible one",
    )


def draw_error(dataset: xr.Dataset) -> Figure:
    """Return the figure of a comparison as made by `compare`: both relative errors, in percent."""
    from matplotlib.colors import LogNorm, TwoSlopeNorm

    nu = float(dataset["poisson_ratio"])
    x, y = np.log10(dataset["p2"].values), np.log10(dataset["p3"].values)
    error, excess = (100.0 * dataset[f"relative_{name}"].transpose("p3", "p2").values for name in ("error", "excess"))
    words = r"$(e_\mathrm{inc} - e)\,/\,e$ [%]", r"$(e - e_\mathrm{inc})\,/\,e_\mathrm{inc}$ [%]"
    signed: Any = {"cmap": style.DIVERGING, "norm": TwoSlopeNorm(0.0, vmin=-100.0, vmax=150.0), "fmt": _signed}
    above: Any = {"cmap": "YlOrBr", "norm": LogNorm(0.1, 1e4, clip=True)}
    with style.context():
        figure, (left, right) = panels("AB", height=3.6)
        figure.suptitle(rf"error of the incompressible value for $\nu = {nu:g}$", fontsize=11)
        for ax in (left, right):
            plane_axes(ax)
        right.set_ylabel("")
        contour_map(left, x, y, error, _ERROR_LEVELS, colorbar=words[0], labels_at=_ERROR_LABELS, **signed)
        contour_map(right, x, y, excess, _EXCESS_LEVELS, colorbar=words[1], labels_at=_EXCESS_LABELS, **above)
        # A logarithmic scale has no place for the region where the incompressible value is the higher one.
        right.contourf(x, y, error, levels=[0.0, np.inf], colors="white")
        for ax in (left, right):
            ax.contour(x, y, error, levels=[0.0], colors="black", linewidths=1.6)
            mark_negative_glass(ax, nu)
        right.text(-2.35, 1.6, r"$e_\mathrm{inc} > e$", ha="center", va="center")
    return figure


def _signed(level: float) -> str:
    return f"{level:g}".replace("-", "\u2212")


def compute_collapse(computation: Computation, n: int, draws: int) -> xr.Dataset:
    """Return e of several random bodies and materials at each of n x n points, for nu = 0.45 and 0.5.

    `spread` is the largest difference between two draws at a point, `relative_spread` the same over the tolerance.
    """
    ball = Impact(standard_solid(1e6, 1e6, 1e3, poisson_ratio=0.45), Parabola(0.01), mass=0.005, velocity=1.0)
    axes = {
        "poisson_ratio": [0.45, 0.5],
        "p2": p2_axis(n),
        "p3": p3_axis(n),
        "draw": Samples(draws, BODIES, seed=computation.seed),
    }
    dataset = computation.sweep("Collapse of random inputs onto p1, p2 and p3", axes, ball)
    unit = viscosity_unit(*(dataset[name] for name in ("equilibrium_modulus", "mass", "velocity", "radius")))
    e = dataset["restitution_coefficient"]
    spread = e.max("draw") - e.min("draw")
    tolerance = computation.rtol * np.maximum(e.mean("draw"), E_FLOOR)
    return described(
        dataset.assign(viscosity=dataset["p3"] * unit, spread=spread, relative_spread=spread / tolerance),
        spread="largest difference of e between two draws",
        relative_spread=f"largest difference of e between two draws over its tolerance, rtol max(e, {E_FLOOR:g})",
    )


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


def compute_terms(computation: Computation, n: int) -> xr.Dataset:
    """Return e over p3 for one, two and three relaxation times, incompressible and with nu = 0.45.

    Each further relaxation time is a tenth of the one before, and the branch moduli are equal shares of Ginf/p2. The
    viscosity in p3 is the sum of the branch moduli times the longest relaxation time. The mass of the sphere
    varies p3.
    """

    def impact(terms: float, poisson_ratio: float) -> Impact:
        shear = PronySeries(1.0, [1.0 / (_TERMS_P2 * terms)] * int(terms), 10.0 ** -np.arange(terms))
        return Impact(Material(shear, bulk_factor(poisson_ratio)), Parabola(1.0), 1.0, 1.0)

    p3 = np.logspace(*LOG_P3_RANGE, n)
    # eta = tau Ginf/p2 with tau = Ginf = R = v0 = 1, and p3 = eta m^(-2/5).
    axes = {"poisson_ratio": [0.45, 0.5], "terms": list(TERMS), "mass": (p3 * _TERMS_P2) ** -2.5}
    found = computation.sweep("Restitution coefficient over p3 for several relaxation times", axes, impact)
    found = found.assign_coords(p3=("mass", p3), p2=_TERMS_P2).swap_dims(mass="p3")
    return described(found, terms="number of relaxation times")


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
