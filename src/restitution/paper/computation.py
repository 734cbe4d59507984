"""Restitution over grids of the dimensionless groups, with random dimensional inputs in SI behind each point."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.impact.batch import Batch
from restitution.impact.status import SolverError, Status
from restitution.material.viscoelastic import reduced_standard_solid
from restitution.quantities import INPUTS, OUTPUTS

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

CITATION = (
    "E. Willert, J.-E. Leroy, M. Satora, Y. Scholtyssek, The Influence of Compressibility on the Restitution "
    "Coefficient for Viscoelastic Spheres in Low-Velocity Normal Impacts"
)

GUESSED = (
    "The text of the paper gives nu = 0.45 and the incompressible limit for figures 3 and 4, and log10 p2 = -2 and -3 "
    "for figures 5 and 6. The ranges of the axes, the isolines, the list of Poisson ratios of figures 5 and 6, and the "
    "ranges of the random inputs are chosen here."
)

RANGES: dict[str, tuple[float, float]] = {
    "mass": (1e-6, 1.0),
    "radius": (1e-4, 1e-1),
    "velocity": (1e-3, 1e1),
    "equilibrium_modulus": (1e4, 1e8),
}
"""Bounds of the log-uniform draws: m [kg], R [m], v0 [m/s], Ginf [Pa]."""

_BLOCK = 8192


class DimensionalInputs(NamedTuple):
    """Inputs in SI of many impacts, arrays of one common shape."""

    mass: Array
    radius: Array
    velocity: Array
    equilibrium_modulus: Array
    branch_modulus: Array
    viscosity: Array


def draw_inputs(p2: Any, p3: Any, generator: np.random.Generator) -> DimensionalInputs:
    """Return random dimensional inputs that have the given dimensionless groups.

    Mass m, radius R, velocity v0 and equilibrium modulus Ginf are drawn log-uniformly within `RANGES`. The
    other two follow from the paper's eq. (11): `G1 = Ginf/p2`, `eta = p3 (m^2 Ginf^3/(v0 R))^(1/5)`.

    Parameters
    ----------
    p2 : array-like
        Ginf/G1.
    p3 : array-like
        eta (v0 R/(m^2 Ginf^3))^(1/5); broadcasts with `p2`.
    generator : numpy.random.Generator
        Source of the draws.

    Returns
    -------
    DimensionalInputs
        In SI, of the common shape of `p2` and `p3`.

    Examples
    --------
    >>> inputs = draw_inputs(0.1, [0.5, 2.0], np.random.default_rng(1))
    >>> inputs.equilibrium_modulus / inputs.branch_modulus
    array([0.1, 0.1])
    """
    p2, p3 = np.broadcast_arrays(np.asarray(p2, dtype=np.float64), np.asarray(p3, dtype=np.float64))
    mass, radius, velocity, modulus = (
        np.exp(generator.uniform(np.log(low), np.log(high), p2.shape)) for low, high in RANGES.values()
    )
    viscosity = p3 * (mass**2 * modulus**3 / (velocity * radius)) ** 0.2
    return DimensionalInputs(mass, radius, velocity, modulus, modulus / p2, viscosity)


def glassy_poisson_ratio(nu: Any, p2: Any) -> Any:
    """Return the instantaneous Poisson ratio nu_0 = (3 K - 2 G0)/(6 K + 2 G0) of the paper's material.

    The bulk modulus K is constant, and the static Poisson ratio nu belongs to the equilibrium modulus Ginf. A stiff
    glass, G0 = Ginf (1 + 1/p2), therefore has another one, which is negative where `p2 < (1 - 2 nu)/(3 nu)`.

    Parameters
    ----------
    nu : float, array or DataArray
        Static Poisson ratio, in [-1, 0.5].
    p2 : float, array or DataArray
        Ginf/G1.

    Examples
    --------
    >>> print(round(glassy_poisson_ratio(0.49, 1e-3), 3), round(glassy_poisson_ratio(0.499, 4.5e-3), 3))
    -0.806 0.306
    """
    # K/Ginf = 2 (1 + nu)/(3 (1 - 2 nu)), multiplied by the factor that is zero in the incompressible limit.
    bulk = 2.0 * (1.0 + nu) / 3.0
    glass = (1.0 - 2.0 * nu) * (1.0 + 1.0 / p2)
    return (3.0 * bulk - 2.0 * glass) / (6.0 * bulk + 2.0 * glass)


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

    def solve(self, poisson_ratio: Any, inputs: DimensionalInputs) -> Array:
        """Return the restitution coefficient of every set of inputs, in their shape."""
        shape = inputs.mass.shape
        ratio = np.broadcast_to(np.asarray(poisson_ratio, dtype=np.float64), shape).ravel()
        flat = DimensionalInputs(*(column.ravel() for column in inputs))
        restitution = np.empty(ratio.size)
        # In blocks, so that an interrupt is noticed and memory stays small however fine the grid.
        for start in range(0, ratio.size, _BLOCK):
            part = slice(start, start + _BLOCK)
            given = DimensionalInputs(*(column[part] for column in flat))
            time = given.viscosity / given.branch_modulus
            reduced = reduced_standard_solid(ratio[part], given.equilibrium_modulus, given.branch_modulus, time)
            none = np.zeros(time.size)
            # The contact radius of a paraboloid is sqrt(R d).
            batch = Batch(
                reduced.equilibrium, none, reduced.moduli, reduced.times, given.mass, given.velocity, none,
                np.sqrt(given.radius), 1.0,
            )  # fmt: skip
            found = batch.solve(self.rtol, workers=self.workers)
            failed = np.flatnonzero(found["status"] >= Status.TOO_MANY_STEPS)
            if failed.size:
                raise SolverError(Status(int(found["status"][failed[0]])), f"impact {start + failed[0]}")
            restitution[part] = found["restitution_coefficient"]
            self.advance(time.size)
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
            With units, long names, version, seed, tolerance and what was guessed as attributes.
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
        dataset["glassy_poisson_ratio"] = glassy_poisson_ratio(dataset["poisson_ratio"], dataset["p2"])
        describe(dataset)
        return dataset

    def attributes(self) -> dict[str, Any]:
        """Return the attributes that describe how the numbers were computed."""
        drawn = ", ".join(f"{name} {low:g} to {high:g}" for name, (low, high) in RANGES.items())
        return {
            "source": f"restitution {version('restitution')}",
            "version": version("restitution"),
            "method": "exact",
            "rtol": self.rtol,
            "seed": self.seed,
            "inputs": f"drawn log-uniformly, SI: {drawn}; branch_modulus and viscosity follow from p2 and p3",
            "guessed": GUESSED,
            "references": CITATION,
        }


_OWN = {
    "draw": {"long_name": "number of the random draw of the dimensional inputs", "units": "1"},
    "glassy_poisson_ratio": {"long_name": "instantaneous Poisson ratio", "units": "1", "symbol": r"$\nu_0$"},
}


def describe(dataset: xr.Dataset) -> None:
    """Give every known variable of `dataset` its long name, unit and symbol."""
    for name in dataset.variables:
        known = {**INPUTS, **OUTPUTS}.get(str(name))
        dataset[name].attrs.update(known.attributes if known else _OWN.get(str(name), {}))
