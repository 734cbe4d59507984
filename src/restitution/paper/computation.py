"""Restitution over grids of the dimensionless groups, each point by its own random impact in SI."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from restitution.impact.solve import solve
from restitution.paper.inputs import RANGES, DimensionalInputs, draw_inputs, impacts

if TYPE_CHECKING:
    import xarray as xr

CITATION = (
    "E. Willert, J.-E. Leroy, M. Satora, Y. Scholtyssek, The Influence of Compressibility on the Restitution "
    "Coefficient for Viscoelastic Spheres in Low-Velocity Normal Impacts"
)

_BLOCK = 4096

_ATTRIBUTES: dict[str, tuple[str, str, str]] = {
    "poisson_ratio": ("static Poisson ratio of the half-space", "1", "nu"),
    "p2": ("equilibrium modulus over branch modulus", "1", "Ginf/G1"),
    "p3": ("dimensionless viscosity", "1", "eta (v0 R/(m^2 Ginf^3))^(1/5)"),
    "draw": ("number of the random draw of the dimensional inputs", "1", "-"),
    "restitution_coefficient": ("restitution coefficient", "1", "e"),
    "mass": ("mass of the sphere", "kg", "m"),
    "radius": ("radius of the sphere", "m", "R"),
    "velocity": ("impact velocity", "m s-1", "v0"),
    "equilibrium_modulus": ("shear modulus at equilibrium", "Pa", "Ginf"),
    "branch_modulus": ("shear modulus of the Maxwell branch", "Pa", "G1"),
    "viscosity": ("shear viscosity of the Maxwell branch", "Pa s", "eta"),
}


@dataclass
class Computation:
    """How the paper's points are computed, and how many of them are.

    Parameters
    ----------
    seed : int
        Seed of the random dimensional inputs; each stream of draws has its own generator.
    rtol : float
        Relative tolerance of the restitution coefficient.
    workers : int, optional
        Threads; all cores by default.
    advance : callable
        Called with the number of units of work just done.
    """

    seed: int
    rtol: float = 1e-9
    workers: int | None = None
    advance: Callable[[int], None] = field(default=lambda _: None, repr=False)

    def solve(self, poisson_ratio: Any, inputs: DimensionalInputs) -> NDArray[np.float64]:
        """Return the restitution coefficient of every set of inputs, in their shape."""
        shape = inputs.mass.shape
        ratio = np.broadcast_to(poisson_ratio, shape).ravel()
        flat = DimensionalInputs(*(column.ravel() for column in inputs))
        restitution = np.empty(ratio.size)
        # In blocks, so that an interrupt is noticed and memory stays small however fine the grid.
        for start in range(0, ratio.size, _BLOCK):
            part = slice(start, start + _BLOCK)
            block = impacts(ratio[part], DimensionalInputs(*(column[part] for column in flat)))
            result = solve(block, rtol=self.rtol, errors="raise", workers=self.workers)
            restitution[part] = result.restitution_coefficient
            self.advance(len(block))
        return restitution.reshape(shape)

    def dataset(self, title: str, stream: int, axes: dict[str, Any], poisson_ratio: Any = None) -> xr.Dataset:
        """Return restitution and its random inputs over the product of named axes.

        Parameters
        ----------
        title : str
            What it shows.
        stream : int
            Which stream of random draws.
        axes : dict
            Values along each dimension, in order: `p2`, `p3` and, if wanted, `poisson_ratio`, `draw`.
        poisson_ratio : float, optional
            Its one value, where it is not an axis.

        Returns
        -------
        xarray.Dataset
            With units, long names, version, seed and tolerance as attributes.
        """
        import xarray as xr

        dims = tuple(axes)
        coordinates = {name: np.asarray(values) for name, values in axes.items()}
        grid = dict(zip(dims, np.meshgrid(*coordinates.values(), indexing="ij"), strict=True))
        ratio = grid["poisson_ratio"] if poisson_ratio is None else poisson_ratio
        inputs = draw_inputs(grid["p2"], grid["p3"], np.random.default_rng([self.seed, stream]))
        columns = {"restitution_coefficient": self.solve(ratio, inputs), **inputs._asdict()}
        if poisson_ratio is not None:
            coordinates["poisson_ratio"] = np.asarray(float(poisson_ratio))
        dataset = xr.Dataset(
            {name: (dims, column) for name, column in columns.items()},
            coords={name: ((name,) if name in axes else (), values) for name, values in coordinates.items()},
            attrs={"title": title, **self.attributes()},
        )
        describe(dataset)
        return dataset

    def attributes(self) -> dict[str, Any]:
        """Return the attributes that say how the numbers were made."""
        drawn = ", ".join(f"{name} {low:g} to {high:g}" for name, (low, high) in RANGES.items())
        return {
            "source": f"restitution {version('restitution')}",
            "version": version("restitution"),
            "method": "exact",
            "rtol": self.rtol,
            "seed": self.seed,
            "inputs": f"drawn log-uniformly, SI: {drawn}; branch_modulus and viscosity follow from p2 and p3",
            "references": CITATION,
        }


def describe(dataset: xr.Dataset) -> None:
    """Give every known variable of `dataset` its long name, units and symbol."""
    for name in dataset.variables:
        if name in _ATTRIBUTES:
            words, unit, symbol = _ATTRIBUTES[str(name)]
            dataset[name].attrs.update({"long_name": words, "units": unit, "symbol": symbol})
