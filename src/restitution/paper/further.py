"""Figures beyond the paper: error of the incompressible value, collapse, examples, several relaxation times."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from restitution.contact.profile import Parabola
from restitution.impact.problem import Impact
from restitution.impact.solve import solve
from restitution.material.conversion import bulk_factor
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material
from restitution.paper.computation import Computation, describe, glassy_poisson_ratio
from restitution.paper.figures import (
    DPI,
    LOG_P2_RANGE,
    LOG_P3_RANGE,
    P3,
    RESTITUTION,
    curve_axes,
    mark_negative_glass,
    plane_axes,
)
from restitution.plot import style
from restitution.plot.lines import contour_map, markers

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

COLLAPSE_STREAM = 8
EXAMPLE_STREAM = 7

E_FLOOR = 1e-3
"""Below this restitution coefficient the solver's tolerance is absolute, `rtol * E_FLOOR`."""

_SPREAD_FLOOR = 1e-17
# Beside the points [decades].
_MARGIN = 0.15

EXAMPLES = ((0.49, 1e-3, 10.0), (0.499, 4.5e-3, 6.0))
"""nu, p2, p3 of the paper's example and of one whose glass is that of a polymer, nu_0 = 0.3."""

TERMS = (1, 2, 3)
"""Numbers of relaxation times that are compared."""

_SPREAD_OF_TIMES = 10.0
_TERMS_P2 = 1e-2


def compare(compressible: xr.Dataset, incompressible: xr.Dataset) -> xr.Dataset:
    """Return the relative error of the incompressible value, by either of the two values as the measure.

    Parameters
    ----------
    compressible, incompressible : xarray.Dataset
        Restitution coefficients e and e_inc over the same plane.

    Returns
    -------
    xarray.Dataset
        `relative_error` = (e_inc - e)/e cannot fall below -1; `relative_excess` = (e - e_inc)/e_inc has no
        bound above: only by this measure can an underestimate be wrong by 100 % and more.

    Examples
    --------
    >>> import xarray as xr
    >>> compressible = xr.Dataset({"restitution_coefficient": ((), 0.2)}, {"poisson_ratio": 0.45})
    >>> incompressible = xr.Dataset({"restitution_coefficient": ((), 0.1)}, {"poisson_ratio": 0.5})
    >>> result = compare(compressible, incompressible)
    >>> float(result.relative_error), float(result.relative_excess)
    (-0.5, 1.0)
    """
    import xarray as xr

    e = compressible["restitution_coefficient"].drop_vars("poisson_ratio")
    e_inc = incompressible["restitution_coefficient"].drop_vars("poisson_ratio")
    nu = float(compressible["poisson_ratio"])
    result = xr.Dataset(
        {
            "compressible": e,
            "incompressible": e_inc,
            "relative_error": (e_inc - e) / e,
            "relative_excess": (e - e_inc) / e_inc,
        },
        coords={"poisson_ratio": ((), nu)},
        attrs={**compressible.attrs, "title": f"Error of taking nu = {nu:g} as incompressible"},
    )
    result["poisson_ratio"].attrs.update(compressible["poisson_ratio"].attrs)
    if "glassy_poisson_ratio" in compressible:
        result["glassy_poisson_ratio"] = compressible["glassy_poisson_ratio"].drop_vars("poisson_ratio")
    words = {
        "compressible": f"restitution coefficient, nu = {nu:g}",
        "incompressible": "restitution coefficient, incompressible",
        "relative_error": "error of the incompressible value relative to the compressible one",
        "relative_excess": "excess of the compressible value relative to the incompressible one",
    }
    for name, long_name in words.items():
        result[name].attrs = {"long_name": long_name, "units": "1"}
    return result


def draw_error(dataset: xr.Dataset) -> Figure:
    """Return the figure of a comparison as made by `compare`: both relative errors, in percent."""
    from matplotlib.colors import LogNorm, TwoSlopeNorm

    nu = float(dataset["poisson_ratio"])
    x, y = np.log10(dataset["p2"].values), np.log10(dataset["p3"].values)
    error = 100.0 * dataset["relative_error"].transpose("p3", "p2").values
    excess = 100.0 * dataset["relative_excess"].transpose("p3", "p2").values
    words = r"$(e_\mathrm{inc} - e)\,/\,e$ [%]", r"$(e - e_\mathrm{inc})\,/\,e_\mathrm{inc}$ [%]"
    with style.context():
        figure = style.new_figure(style.PAGE_WIDTH, 3.6, dpi=DPI)
        left, right = (figure.add_subplot(1, 2, place) for place in (1, 2))
        for ax in (left, right):
            plane_axes(ax)
        right.set_ylabel("")
        style.panel_letters([left, right])
        figure.suptitle(rf"error of taking $\nu = {nu:g}$ as incompressible", fontsize=11)
        signed: dict[str, Any] = {
            "cmap": style.DIVERGING,
            "norm": TwoSlopeNorm(0.0, vmin=-100.0, vmax=150.0),
            "fmt": _signed,
        }
        above: dict[str, Any] = {"cmap": "YlOrBr", "norm": LogNorm(0.1, 1e4, clip=True)}
        contour_map(
            left, x, y, error, _ERROR_LEVELS, colorbar=words[0], labels_at=_ERROR_LABELS, **signed
        )  # fmt: skip
        contour_map(
            right, x, y, excess, _EXCESS_LEVELS, colorbar=words[1], labels_at=_EXCESS_LABELS, **above
        )  # fmt: skip
        # On a logarithmic scale there is nothing to show where the incompressible value is the higher one.
        right.contourf(x, y, error, levels=[0.0, np.inf], colors="white")
        for ax in (left, right):
            ax.contour(x, y, error, levels=[0.0], colors="black", linewidths=1.6)
            mark_negative_glass(ax, nu)
        right.text(-2.35, 1.6, r"$e_\mathrm{inc} > e$", ha="center", va="center")
    return figure


def _signed(level: float) -> str:
    return f"{level:g}".replace("-", "\u2212")


def compute_collapse(computation: Computation, n: int, draws: int) -> xr.Dataset:
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
    dataset = computation.dataset("Collapse of random dimensional inputs onto p1, p2 and p3", COLLAPSE_STREAM, axes)
    e = dataset["restitution_coefficient"]
    spread = e.max("draw") - e.min("draw")
    tolerance = computation.rtol * np.maximum(e.mean("draw"), E_FLOOR)
    dataset["spread"] = spread.assign_attrs(long_name="largest difference of e between two draws", units="1")
    dataset["relative_spread"] = (spread / tolerance).assign_attrs(
        long_name=f"largest difference of e between two draws over its tolerance, rtol max(e, {E_FLOOR:g})",
        units="1",
    )
    return dataset


def draw_collapse(dataset: xr.Dataset) -> Figure:
    """Return the figure of the draws: scattered over viscosity, collapsed over p3, and their spread."""
    p2 = float(dataset["p2"].sel(p2=1e-2, method="nearest"))
    cloud: Any = dataset.sel(p2=p2).isel(poisson_ratio=0)
    e = cloud["restitution_coefficient"]
    nu, draws = float(cloud["poisson_ratio"]), dataset.sizes["draw"]
    p3 = e["p3"].broadcast_like(e).values.ravel()
    viscosity = cloud["viscosity"].transpose(*e.dims).values.ravel()
    with style.context():
        figure = style.new_figure(style.PAGE_WIDTH, 3.1, dpi=DPI)
        axes = [figure.add_subplot(1, 3, place) for place in (1, 2, 3)]
        for ax, across in zip(axes[:2], (viscosity, p3), strict=True):
            ax.semilogx(across, e.values.ravel(), ".", markersize=3.5, color=style.BLUE, markeredgewidth=0)
            ax.set_ylim(0.0, 1.0)
            ax.set_title(rf"$\nu = {nu:g}$, $\log_{{10}}\,p_2 = {np.log10(p2):.3g}$", fontsize=8.5)
        axes[0].set_ylabel(RESTITUTION)
        axes[0].set_xlabel(r"viscosity $\eta$ [Pa s]")
        axes[1].set_xlabel(P3)
        # Points at the ends are to be seen whole.
        axes[1].set_xlim(10.0 ** (LOG_P3_RANGE[0] - _MARGIN), 10.0 ** (LOG_P3_RANGE[1] + _MARGIN))
        _draw_spread(axes[2], dataset)
        axes[2].set_title(f"{draws} draws at each point $(p_2, p_3)$", fontsize=8.5)
        style.panel_letters(axes)
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
    ax.set_xticks([10.0**power for power in ticks], ["0" if power == -17 else f"$10^{{{power}}}$" for power in ticks])
    ax.minorticks_off()
    ax.set_xlim(bins[0], bins[-1])
    ax.set_xlabel("largest spread of $e$ at a point")
    ax.set_ylabel("number of points")
    # Counts grow to the left, so that the space beside the tolerance is free; headroom keeps it so.
    ax.set_ylim(top=1.35 * ax.get_ylim()[1])
    ax.legend(loc="upper left", bbox_to_anchor=(0.18, 1.0))


def compute_examples(computation: Computation, n: int) -> xr.Dataset:
    """Return e over p3 at the Poisson ratio and p2 of each of the `EXAMPLES`, and of its incompressible limit."""
    import xarray as xr

    parts: list[xr.Dataset] = []
    p3 = np.logspace(*LOG_P3_RANGE, n)
    points = [point for *_, point in EXAMPLES]
    for point in points:
        # The nearest value that is not one of the points already.
        away = np.where(np.isin(p3, points), np.inf, np.abs(np.log(p3 / point)))
        p3[np.argmin(away)] = point
    p3.sort()
    for number, (nu, p2, _) in enumerate(EXAMPLES):
        axes = {
            "poisson_ratio": np.array([nu, 0.5]),
            "p2": np.array([p2]),
            "p3": p3,
        }
        part = computation.dataset("", EXAMPLE_STREAM + 100 * number, axes).isel(p2=0)
        found = xr.Dataset({"restitution_coefficient": part["restitution_coefficient"]}, attrs=part.attrs)
        found = found.assign_coords(body=("poisson_ratio", ["compressible", "incompressible"]))
        found = found.swap_dims(poisson_ratio="body").expand_dims(example=[number])
        parts.append(found.reset_coords(["poisson_ratio", "p2"]))
    dataset = xr.concat(parts, "example", data_vars="all")
    dataset["glassy_poisson_ratio"] = glassy_poisson_ratio(dataset["poisson_ratio"], dataset["p2"])
    describe(dataset)
    for name, words in {"example": "number of the example", "body": "compressible or not"}.items():
        dataset[name].attrs = {"long_name": words, "units": "1"}
    return dataset.assign_attrs(title="The paper's example, and one with the glass of a polymer")


def draw_examples(dataset: xr.Dataset) -> Figure:
    """Return the figure of the examples as computed by `compute_examples`, a panel each."""
    from matplotlib.patheffects import withStroke

    with style.context():
        figure = style.new_figure(style.PAGE_WIDTH, 3.4, dpi=DPI)
        axes = [figure.add_subplot(1, len(EXAMPLES), place + 1) for place in range(len(EXAMPLES))]
        for number, (ax, (nu, p2, p3)) in enumerate(zip(axes, EXAMPLES, strict=True)):
            one = dataset.isel(example=number)
            e, limit = one["restitution_coefficient"].transpose("body", "p3").values
            glassy = float(one["glassy_poisson_ratio"].isel(body=0))
            curve_axes(ax)
            ax.set_yscale("log")
            ax.set_ylim(3e-3, 1.0)
            x = one["p3"].values
            ax.plot(x, e, color=style.BLUE, linewidth=1.6, label=rf"$\nu = {nu:g}$, $\nu_0 = {glassy:.2f}$")
            ax.plot(x, limit, color="black", linewidth=0.9, linestyle="--", label="incompressible")
            for curve, offset in ((e, (-8, 7)), (limit, (6, -3))):
                value = float(curve[x == p3][0])
                ax.plot([p3], [value], "o", color="black", markersize=4)
                halo = [withStroke(linewidth=2.5, foreground="white")]
                text = f"{value:.4f}"
                ax.annotate(text, (p3, value), offset, textcoords="offset points", fontsize=8.5, path_effects=halo)
            ax.set_title(rf"$p_2 = {p2:g}$; points: $p_3 = {p3:g}$", fontsize=9)
            ax.legend(loc="lower left")
        axes[1].set_ylabel("")
        style.panel_letters(axes)
    return figure


def series_of_times(terms: int, p2: float) -> PronySeries:
    """Return shear moduli of one sum, Ginf/p2 with Ginf = 1, spread evenly over relaxation times from 1 s down.

    Each further relaxation time is a tenth of the one before.
    """
    times = _SPREAD_OF_TIMES ** -np.arange(float(terms))
    return PronySeries(1.0, np.full(terms, 1.0 / (p2 * terms)), times)


def compute_terms(computation: Computation, n: int) -> xr.Dataset:
    """Return e over p3 for one, two and three relaxation times, incompressible and with nu = 0.45.

    The viscosity in p3 is that of one term, the sum of the branch moduli times the longest relaxation time. The mass
    of the sphere varies p3.
    """
    import xarray as xr

    p3 = np.logspace(*LOG_P3_RANGE, n)
    ratios = np.array([0.45, 0.5])
    # eta = tau Ginf/p2 with tau = Ginf = R = v0 = 1, and p3 = eta m^(-2/5).
    mass = (p3 * _TERMS_P2) ** -2.5
    e = np.empty((ratios.size, len(TERMS), n))
    for row, nu in enumerate(ratios):
        bulk = bulk_factor(nu)
        for column, terms in enumerate(TERMS):
            material = Material(series_of_times(terms, _TERMS_P2), bulk)
            impact = Impact(material, Parabola(1.0), mass=mass, velocity=1.0)
            found = solve(impact, rtol=computation.rtol, errors="raise", workers=computation.workers)
            e[row, column] = found.restitution_coefficient
            computation.advance(n)
    dataset = xr.Dataset(
        {"restitution_coefficient": (("poisson_ratio", "terms", "p3"), e)},
        {"poisson_ratio": ratios, "terms": np.array(TERMS), "p3": p3, "p2": _TERMS_P2},
        {"title": "Restitution coefficient over p3 for several relaxation times", **computation.attributes()},
    )
    describe(dataset)
    dataset["terms"].attrs = {"long_name": "number of relaxation times", "units": "1"}
    return dataset


def draw_terms(dataset: xr.Dataset) -> Figure:
    """Return the figure of several relaxation times as computed by `compute_terms`."""
    colors = (style.BLACK, style.BLUE, style.ORANGE)
    with style.context():
        figure = style.new_figure(style.PAGE_WIDTH, 3.4, dpi=DPI)
        axes = [figure.add_subplot(1, 2, place) for place in (1, 2)]
        for ax, nu in zip(axes, dataset["poisson_ratio"].values, strict=True):
            curve_axes(ax)
            for terms, color, dashes in zip(dataset["terms"].values, colors, ("-", "--", "-."), strict=True):
                curve = dataset["restitution_coefficient"].sel(poisson_ratio=nu, terms=terms)
                label = "one relaxation time" if terms == 1 else f"{terms} relaxation times"
                look: dict[str, Any] = {"linestyle": dashes} | markers(curve.size)
                ax.plot(dataset["p3"].values, curve.values, color=color, label=label, **look)
            words = "incompressible" if nu == 0.5 else rf"$\nu = {nu:g}$"
            ax.set_title(rf"{words}, $\log_{{10}}\,p_2 = {np.log10(float(dataset['p2'])):g}$", fontsize=9)
        axes[1].set_ylabel("")
        axes[0].legend(loc="upper right", bbox_to_anchor=(0.97, 1.0))
        style.panel_letters(axes)
    return figure
