"""The error of taking a compressible half-space as incompressible, over the plane of figures 3 and 4."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from restitution.plot import style
from restitution.plot.contours import contour_map
from restitution.plot.labels import LOG_P2, LOG_P3

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_ERROR_LEVELS = (-95, -90, -80, -60, -30, -10, -3, -1, 1, 3, 10, 30, 100)
_EXCESS_LEVELS = (1, 3, 10, 30, 100, 300, 1000)
_LABELS = (((-2.0, -2.0), (-2.6, 1.0)), ((-2.9, 1.5), (-1.4, 1.75)), ((-0.95, 0.45), (1.0, -1.0)))


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
    words = {
        "compressible": f"restitution coefficient, nu = {nu:g}",
        "incompressible": "restitution coefficient, incompressible",
        "relative_error": "error of the incompressible value relative to the compressible one",
        "relative_excess": "excess of the compressible value relative to the incompressible one",
    }
    for name, long_name in words.items():
        result[name].attrs = {"long_name": long_name, "units": "1"}
    return result


def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure of a comparison as made by `compare`: both relative errors, in percent."""
    from matplotlib.colors import LogNorm, TwoSlopeNorm

    nu = float(dataset["poisson_ratio"])
    x, y = np.log10(dataset["p2"].values), np.log10(dataset["p3"].values)
    error = 100.0 * dataset["relative_error"].transpose("p3", "p2").values
    excess = 100.0 * dataset["relative_excess"].transpose("p3", "p2").values
    with style.context():
        figure = style.new_figure(style.PAGE_WIDTH, 4.0)
        left, right = (figure.add_subplot(1, 2, place) for place in (1, 2))
        for ax in (left, right):
            ax.set_xlabel(LOG_P2)
            ax.set_xticks(range(-3, 2))
            ax.set_yticks(range(-2, 3))
        left.set_ylabel(LOG_P3)
        left.set_title(r"(a)  $(e_\mathrm{inc} - e)\,/\,e$")
        right.set_title(r"(b)  $(e - e_\mathrm{inc})\,/\,e_\mathrm{inc}$")
        figure.suptitle(rf"error of taking $\nu = {nu:g}$ as incompressible", fontsize=11)
        contour_map(
            left,
            x,
            y,
            error,
            _ERROR_LEVELS,
            fmt=lambda level: f"{level:g} %".replace("-", "−"),
            label_along=_LABELS,
            cmap=style.DIVERGING,
            norm=TwoSlopeNorm(0.0, vmin=-100.0, vmax=150.0),
        )
        contour_map(
            right,
            x,
            y,
            excess,
            _EXCESS_LEVELS,
            fmt="%g %%",
            label_along=_LABELS,
            cmap="YlOrBr",
            norm=LogNorm(0.1, 1e4, clip=True),
        )
        # On a logarithmic scale there is nothing to show where the incompressible value is the higher one.
        right.contourf(x, y, error, levels=[0.0, np.inf], colors="white")
        for ax in (left, right):
            ax.contour(x, y, error, levels=[0.0], colors="black", linewidths=1.6)
        right.text(-2.35, 1.6, r"$e_\mathrm{inc} > e$", ha="center", va="center")
    return figure
