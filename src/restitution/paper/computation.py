"""Restitution over the dimensionless groups of the paper, as sweeps with the attributes of the reproduction."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np

from restitution.errors import RestitutionWarning
from restitution.impact.status import SolverError, Status
from restitution.quantities import INPUTS, OUTPUTS, VALIDITY
from restitution.sweeps.axes import Logarithmic, LogUniform
from restitution.sweeps.run import sweep

if TYPE_CHECKING:
    import xarray as xr

CITATION = (
    "E. Willert, J.-E. Leroy, M. Satora, Y. Scholtyssek, The Influence of Compressibility on the Restitution "
    "Coefficient for Viscoelastic Spheres in Low-Velocity Normal Impacts"
)
GUESSED = (
    "The text of the paper gives nu = 0.45 and the incompressible limit for figures 3 and 4, and log10 p2 = -2 and -3 "
    "for figures 5 and 6. The ranges of the axes, the isolines, the list of Poisson ratios of figures 5 and 6, "
    "and the "
    "ranges of the random inputs are chosen here."
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
