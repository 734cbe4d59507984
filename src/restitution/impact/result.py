"""What came of an impact."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.impact.history import DenseOutput, Trajectory
from restitution.impact.status import Status
from restitution.kernel.validation import Numeric

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

    from restitution.impact.problem import Impact

VARIABLES = {
    "indentation_depth": ("m", "indentation depth d"),
    "velocity": ("m/s", "velocity v"),
    "force": ("N", "normal force F"),
    "contact_radius": ("m", "contact radius a"),
}


class EnergyBudget(NamedTuple):
    """Where the kinetic energy went.

    Attributes
    ----------
    kinetic_in, kinetic_out : float or array
        Kinetic energy before and after [J].
    dissipated : float or array
        What the dashpots of the foundation dissipated while their elements were in contact [J].
    stored : float or array
        What the foundation still stored as its elements left contact [J].
    residual : float or array
        `(kinetic_out + dissipated + stored - kinetic_in - work of the constant force)/kinetic_in` [-]: zero but for
        errors. All terms are computed on their own, none by subtraction.
    """

    kinetic_in: Numeric
    kinetic_out: Numeric
    dissipated: Numeric
    stored: Numeric
    residual: Numeric


@dataclass(frozen=True, eq=False)
class ImpactResult:
    """What came of an impact, or of an array of impacts; SI units.

    Attributes
    ----------
    restitution_coefficient : float or array
        e = rebound velocity over impact velocity [-]; 0 where the body does not come back, NaN where the solve failed.
    contact_time : float or array
        Duration of contact [s]; infinite where the body does not separate.
    max_indentation_depth : float or array
        Largest depth d [m].
    max_force : float or array
        Largest normal force F [N].
    max_contact_radius : float or array
        Largest contact radius a [m].
    residual_indentation_depth : float or array
        Depth d [m] at separation: the imprint that is left, and recovers.
    status : Status, or array of int
        How the solve ended.
    impact : Impact or list of Impact
        The problem.
    method : str
        The method that solved it.
    rtol : float or None
        Its tolerance; None for the element method, whose error the number of elements sets.
    warnings : list of str
        Where the assumptions of the theory are doubtful, with numbers.

    Notes
    -----
    `energy` and `history` are computed when asked for.
    """

    restitution_coefficient: Numeric
    contact_time: Numeric
    max_indentation_depth: Numeric
    max_force: Numeric
    max_contact_radius: Numeric
    residual_indentation_depth: Numeric
    status: Status | NDArray[np.int64]
    impact: Impact | list[Impact]
    method: str
    rtol: float | None
    warnings: list[str]
    _budget: Callable[[], EnergyBudget] = field(repr=False)
    _dense: Callable[[], DenseOutput | Trajectory] = field(repr=False)

    @property
    def velocity(self) -> Numeric:
        """Impact velocity v0 [m/s], in the shape of the results."""
        if isinstance(self.impact, list):
            return np.array([impact.velocity for impact in self.impact], dtype=np.float64)
        return self.impact.velocity

    @property
    def rebound_velocity(self) -> Numeric:
        """Speed of the rebound e v0 [m/s]."""
        return self.restitution_coefficient * self.velocity

    @cached_property
    def energy(self) -> EnergyBudget:
        """Energy budget [J], and the residual of its balance."""
        return self._budget()

    @cached_property
    def _dense_output(self) -> DenseOutput | Trajectory:
        return self._dense()

    @cached_property
    def history(self) -> xarray.Dataset:
        """History over time: indentation depth, velocity, force, contact radius; about 400 points."""
        return self.sample()

    def sample(self, times: ArrayLike | None = None, *, n_points: int = 401) -> xarray.Dataset:
        """History at given times, or at as many as wanted.

        Parameters
        ----------
        times : array_like, optional
            Times [s] from 0 to the contact time.
        n_points : int
            Number of points where no times are given.

        Returns
        -------
        xarray.Dataset
            `indentation_depth`, `velocity`, `force`, `contact_radius` over `time`, with units.

        Raises
        ------
        ValueError
            If a time lies outside the contact, or the result is of more than one impact.

        Examples
        --------
        >>> import restitution as rs
        >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
        >>> impact = rs.Impact(material=rubber, profile=rs.Parabola(radius=0.01), mass=0.005, velocity=1.0)
        >>> result = rs.solve(impact)
        >>> float(result.sample([0.0]).velocity[0])
        1.0
        """
        import xarray as xr

        if n_points < 2:
            raise ValueError(f"n_points = {n_points}: must be at least 2")
        dense = self._dense_output
        if isinstance(dense, Trajectory):
            trajectory = _interpolated(dense, times)
        else:
            trajectory = dense.at(dense.times(n_points) if times is None else times)
        data = {
            name: ("time", values, {"units": unit, "long_name": long_name})
            for (name, (unit, long_name)), values in zip(VARIABLES.items(), trajectory[1:], strict=True)
        }
        time = ("time", trajectory.time, {"units": "s", "long_name": "time since first touch t"})
        return xr.Dataset(
            data, coords={"time": time}, attrs={"method": self.method, "rtol": self.rtol or np.nan}
        )

    def plot(self) -> Figure:
        """Figure of the impact: force over time, loop, contact radius, energy."""
        from importlib import import_module

        # By name: pictures stand above this layer, which must not depend on them.
        return import_module("restitution.plot.history").overview(self)

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers by name, SI, with the energy budget."""
        names = (
            "restitution_coefficient", "rebound_velocity", "contact_time", "max_indentation_depth", "max_force",
            "max_contact_radius", "residual_indentation_depth",
        )  # fmt: skip
        return {name: getattr(self, name) for name in names} | {
            "energy": self.energy._asdict(),
            "status": self.status,
            "method": self.method,
            "rtol": self.rtol,
            "warnings": self.warnings,
        }


def _interpolated(trajectory: Trajectory, times: ArrayLike | None) -> Trajectory:
    if times is None:
        return trajectory
    t = np.atleast_1d(np.asarray(times, dtype=np.float64))
    if np.any(~((t >= 0.0) & (t <= trajectory.time[-1]))):
        bad = t[~((t >= 0.0) & (t <= trajectory.time[-1]))][0]
        raise ValueError(
            f"times = {bad:g} s: must be in [0, {trajectory.time[-1]:g}] s, the duration of contact"
        )
    return Trajectory(t, *(np.interp(t, trajectory.time, values) for values in trajectory[1:]))
