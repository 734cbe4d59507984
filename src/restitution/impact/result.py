"""Result of one impact or of several."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution import checks
from restitution.checks import Numeric
from restitution.display import Shown, Summary, in_words
from restitution.doubts import Tally
from restitution.errors import InputError
from restitution.impact.batch import Batch, shaped, solve_columns
from restitution.impact.energy_budget import EnergyBudget
from restitution.impact.solution import Sampled, Solution
from restitution.impact.status import Status
from restitution.pictures import draw
from restitution.quantities import BODY, BUDGET, ENERGIES, HISTORY, OUTPUTS, dataset, derived
from restitution.validity import COLUMNS, Validity, numbers, report

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

    from restitution.impact.fields import ImpactFields
    from restitution.impact.problem import Impact


@dataclass(frozen=True, eq=False, repr=False)
class ImpactResult(Shown):
    """Result of one impact or of several, in SI units.

    Attributes
    ----------
    restitution_coefficient : float or array
        e = rebound velocity over impact velocity [-]; 0 where the body does not separate, NaN where the solve failed.
    contact_time : float or array
        Duration of contact [s]; infinite where the body does not separate.
    max_indentation_depth : float or array
        Largest indentation depth d [m]; for a captured body the static depth if that is larger than the depth of the
        first turning point.
    max_force : float or array
        Largest normal force F [N].
    max_contact_radius : float or array
        Largest contact radius a [m].
    residual_indentation_depth : float or array
        Depth d [m] at separation, an imprint that recovers. For a body that does not separate, the static depth, at
        which the relaxed half-space carries the external force; infinite on a liquid.
    status : Status, or array of int
        End of the solve.
    impact : Impact or list of Impact
        The problem.
    method : str
        The method of solution.
    rtol : float or None
        The tolerance; None for the element method, whose error follows from the number of elements.
    notes : tuple of str
        Warnings of the method.

    Notes
    -----
    A single impact is solved once: history, energies and fields are evaluations of the stored solution. Relative to
    their largest values, their errors stay below some 1000 rtol between the nodes of the solver, and the residual of
    the energy balance stays below 10 rtol.
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
    notes: tuple[str, ...] = ()
    _solution: Solution | Sampled | None = field(default=None, repr=False)

    @property
    def velocity(self) -> Numeric:
        """Impact velocity v0 [m/s], in the shape of the results."""
        return self._column("velocity")

    @property
    def mass(self) -> Numeric:
        """Mass m [kg], in the shape of the results."""
        return self._column("mass")

    @property
    def rebound_velocity(self) -> Numeric:
        """Speed of the rebound e v0 [m/s]."""
        return self._derived()["rebound_velocity"]

    @property
    def turning_time(self) -> float:
        """Time [s] of the largest depth of a single impact; NaN for other methods than "exact"."""
        solution = self._single("the turning time is")
        return solution.turning_time if isinstance(solution, Solution) else math.nan

    @property
    def outputs(self) -> dict[str, Numeric]:
        """All outputs of `restitution.quantities.OUTPUTS` by name, in SI; of several impacts by further solves."""
        energies = {name: one for name, one in zip(BUDGET, self.energy, strict=True) if name in ENERGIES}
        found = self._derived(energies | {"max_pressure": self.max_pressure})
        shape = np.shape(self.status)
        return {name: shaped(np.broadcast_to(found[name], shape), shape) for name in OUTPUTS}

    def _derived(self, energies: Mapping[str, Any] = MappingProxyType({})) -> dict[str, Any]:
        own = {name: getattr(self, name) for name in OUTPUTS if name in self.__dataclass_fields__}
        return derived(own | {name: self._column(name) for name in BODY} | dict(energies))

    @cached_property
    def validity(self) -> Validity:
        """Report on the assumptions of the theory: the worst value of each, its limit, and advice."""
        return self.validity_on()

    def validity_on(self, body_size: Numeric = math.nan) -> Validity:
        """Validity report with the size of the target.

        Parameters
        ----------
        body_size : float or array
            Smallest dimension of the target [m], such as its thickness; the `body_size` of the impact counts too.

        Examples
        --------
        >>> import restitution as rs
        >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
        >>> result = rs.solve(rs.Impact(rubber, rs.Parabola(0.01), mass=0.005, velocity=1.0))
        >>> print(result.validity_on(body_size=0.02)["half_space"].exceeded)
        True
        """
        found = {name: getattr(self, name) for name in COLUMNS}
        found |= {"velocity": self.velocity, "mass": self._column("mass"), "body_size": body_size}
        found["impedance"] = self._column("impedance")
        contact = [one.contact for one in self.impact] if isinstance(self.impact, list) else self.impact.contact
        compared = numbers(contact, **found)
        if not np.shape(self.status):
            return report(compared)
        tally = Tally()
        tally.add(compared)
        return tally.report()

    @property
    def warnings(self) -> list[str]:
        """Doubtful assumptions of the theory, with numbers, and `notes`."""
        return [*self.validity.warnings, *self.notes]

    @property
    def zero_overlap_time(self) -> Numeric:
        """Time [s] at which the body is back at the undeformed surface; infinite if it never returns.

        After separation the body flies freely, or under the constant force, from the residual depth with the rebound
        velocity. The surface may still be indented then; see `surface_displacement`.
        """
        depth = np.maximum(self.residual_indentation_depth, 0.0)
        speed = np.asarray(self.rebound_velocity)
        push = 2.0 * self._column("external_force") * depth / self._column("mass")
        # The squares of extreme velocities overflow or vanish.
        with np.errstate(all="ignore"):
            arrives = np.sqrt(speed**2 - push)
            flight = np.where(speed > 0.0, 2.0 * depth / (speed + arrives), np.inf)
            time = self.contact_time + np.where(speed**2 >= push, flight, np.inf)
        time = np.where(np.isnan(self.restitution_coefficient), np.nan, time)
        return time if time.ndim else float(time)

    @cached_property
    def max_pressure(self) -> Numeric:
        """Largest contact pressure [Pa] over the contact area and over time.

        For an elastic parabola it is that of Hertz, `3 F/(2 pi a^2)` on the axis; relaxation moves it towards the
        edge. For a captured body it is that of the approach. It is infinite under a sharp tip, at the edge of a flat
        face and with a parallel dashpot, and NaN for a body that sinks in, for other methods than "exact" and for
        geometries whose contact area is not known. The relative error is about 1e-5, and larger for a power law
        near a cone: 3e-4 with the exponent 1.05, 3e-2 with 1.02. The first use computes it in about 3 ms per impact;
        for several impacts and for a captured body by a second solve.
        """
        if self.method != "exact":
            return math.nan
        if isinstance(self._solution, Solution) and not isinstance(self.impact, list):
            batch = Batch.from_impact(self.impact)
            finite = batch.has_pressure and not batch.singular[0]
            return float(batch.pressures(self._solution.max_pressure if finite else math.nan)[0])
        found = solve_columns(self.impact, self.rtol or 0.0, pressure=True)["max_pressure"]
        return shaped(found, np.shape(self.status))

    @property
    def max_semi_axes(self) -> NDArray[np.float64]:
        """Semi-axes a >= b [m] of the largest contact area, shape (2, ...); NaN where it is no ellipse.

        With the axis ratio k of the geometry, 1 for a disc, they are ``a_max/sqrt(k)`` and ``a_max sqrt(k)``.
        """
        if not isinstance(self.impact, list):
            return self.impact.profile.semi_axes(self.max_contact_radius)
        radii = zip(self.impact, np.atleast_1d(self.max_contact_radius), strict=True)
        return np.stack([one.profile.semi_axes(radius) for one, radius in radii], axis=-1)

    @cached_property
    def energy(self) -> EnergyBudget:
        """Energy budget [J] and the residual of its balance; for several impacts by a second solve."""
        solution, shape = self._solution, np.shape(self.status)
        if shape:
            columns = solve_columns(self.impact, self.rtol or 0.0, energy=True)
        else:
            energies = (np.nan, np.nan, np.nan)
            if isinstance(solution, Solution):
                energies = (solution.energy_unit * energy for energy in solution.stored.energies)
            elif solution is not None:
                energies = solution.dissipated, solution.stored, solution.radiated
            columns = self._derived(dict(zip(ENERGIES, energies, strict=True)))
        return EnergyBudget(*(shaped(columns[name], shape) for name in BUDGET))

    @cached_property
    def _fields(self) -> ImpactFields:
        from restitution.impact.fields import ImpactFields

        if self.method != "exact":
            wanted = f"must be 'exact' for pressure and surface displacement, and this result is of {self.method!r}"
            raise InputError("method", wanted=wanted)
        solution = self._single("pressure and surface displacement are")
        assert isinstance(solution, Solution)
        assert not isinstance(self.impact, list)
        return ImpactFields(self.impact, solution, self.rtol or 0.0)

    def _single(self, what: str) -> Solution | Sampled:
        """Return the solution of one impact that ended in separation."""
        if self._solution is not None:
            return self._solution
        if not isinstance(self.status, Status):
            many = "a list" if isinstance(self.impact, list) else f"an array of shape {self.status.shape}"
            raise InputError("impact", wanted=f"must be a single one: {what} of one impact, this result is of {many}")
        wanted = f"must end: {what} of a contact that ends, and this one does not ({self.status.message})"
        raise InputError("contact_time", np.inf, wanted, "s")

    @cached_property
    def history(self) -> xarray.Dataset:
        """History of depth, velocity, force, contact radius and energies at 401 times."""
        return self.sample()

    def sample(self, times: ArrayLike | None = None, *, n_points: int = 401) -> xarray.Dataset:
        """History at given times, or at a number of times.

        Parameters
        ----------
        times : array_like, optional
            Times [s] from 0 to the contact time.
        n_points : int
            Number of times if none are given.

        Returns
        -------
        xarray.Dataset
            `indentation_depth`, `indentation_velocity`, `force`, `contact_radius` and `kinetic_energy` over `time`,
            with units. With the exact method also `dissipated_energy` and `stored_energy`, in the springs of the
            foundation and in elements when they left contact, and for a target with an impedance `radiated_energy`,
            `body_velocity` and `target_displacement`. The energies add up to the kinetic energy before the impact
            plus the work of the constant force.

        Raises
        ------
        InputError
            If a time lies outside the contact, the result is of several impacts, or the body does not separate.

        Examples
        --------
        >>> import restitution as rs
        >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
        >>> result = rs.solve(rs.Impact(rubber, rs.Parabola(radius=0.01), mass=0.005, velocity=1.0))
        >>> float(result.sample([0.0]).indentation_velocity[0])
        1.0
        """
        columns = {name: (one, HISTORY[name]) for name, one in self._columns(times, n_points=n_points).items()}
        return dataset("time", columns, {"method": self.method, "rtol": self.rtol or np.nan})

    def _columns(self, times: ArrayLike | None = None, *, n_points: int = 401) -> dict[str, NDArray[np.float64]]:
        """Columns of `sample` by name, which are quicker than a Dataset."""
        checks.whole("n_points", n_points, 2, 10_000_000)
        solution = self._single("a history is")
        if isinstance(solution, Solution):
            trajectory = solution.at(solution.times(n_points) if times is None else times)
        else:
            trajectory = solution.at(times)
            body_velocity = trajectory.indentation_velocity + trajectory.force / self._column("impedance")
            kinetic = 0.5 * self._column("mass") * body_velocity**2
            trajectory = trajectory._replace(kinetic_energy=kinetic)
        return {name: one for name, one in trajectory._asdict().items() if one is not None}

    def pressure(self, r: ArrayLike, t: ArrayLike) -> Any:
        """Contact pressure p(r, t) [Pa].

        Parameters
        ----------
        r, t : array_like
            Radii [m] and times since first touch [s], >= 0, which broadcast. In an elliptical contact r is
            `Ellipsoid.mean_radius(x, y)`.

        Returns
        -------
        float or array
            Pressure; 0 outside the contact and after it. Infinite at an edge that carries a line load (under a flat
            punch, and in the approach with a parallel dashpot) and under the tip of a cone.

        Raises
        ------
        InputError
            If the result is of several impacts, of a method other than "exact", or the body does not separate.

        Notes
        -----
        Inverse transform of the line load of the foundation, `q(x, t) = int E*(t - t') du(x, t')`, by the method of
        dimensionality reduction (Popov and Hess 2015). Its integral over the contact is the force.

        Examples
        --------
        Hertz's ellipse `p = 3 F/(2 pi a^2) sqrt(1 - r^2/a^2)` on an elastic half-space:

        >>> import restitution as rs
        >>> result = rs.solve(rs.Impact(rs.Material(1.0, 1.0), rs.Parabola(radius=1.0), mass=1.0, velocity=1.0))
        >>> a = result.max_contact_radius
        >>> hertz = 1.5 * result.max_force / (np.pi * a**2)
        >>> print(round(float(result.pressure(0.6 * a, result.turning_time)) / hertz, 8))
        0.8
        """
        return self._fields.pressure(r, t)

    def surface_displacement(self, r: ArrayLike, t: ArrayLike) -> Any:
        """Normal displacement of the surface w(r, t) [m], into the half-space, during contact and after it.

        Parameters
        ----------
        r, t : array_like
            Radii [m] and times since first touch [s], >= 0, also after separation; they broadcast.

        Returns
        -------
        float or array
            d - f(r) in contact, and the recovering imprint after separation. For two deformable bodies, the sum of
            both displacements.

        Raises
        ------
        InputError
            As `pressure`.

        Notes
        -----
        The transform of the displacements of the foundation (Popov and Hess 2015). Elements that have left contact
        carry no load and creep back with the retardation times of the reduced modulus.

        Examples
        --------
        >>> import restitution as rs
        >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
        >>> result = rs.solve(rs.Impact(rubber, rs.Parabola(radius=0.01), mass=0.005, velocity=1.0))
        >>> times = [n * result.contact_time for n in (1, 2, 3)]
        >>> imprint = result.surface_displacement(0.0, times) / result.residual_indentation_depth
        >>> print(imprint.round(6))
        [1.       0.28849  0.08392]
        """
        return self._fields.surface_displacement(r, t)

    def _column(self, name: str) -> Any:
        """Return an input of the impacts by name."""
        if isinstance(self.impact, list):
            return np.array([getattr(impact, name) for impact in self.impact], dtype=np.float64)
        return getattr(self.impact, name)

    def plot(self, times: ArrayLike | None = None) -> Figure:
        """Figure of the impact: force over time, loop, depth, contact radius, pressure, energies.

        Of several impacts e, contact time, depth and force over the velocity, or over what varies instead.

        Parameters
        ----------
        times : array_like, optional
            Times [s] within the contact, at most seven, at which the pressure is shown; by default four.
        """
        if np.shape(self.status):
            if times is not None:
                raise InputError("times", wanted="must be left out for several impacts, which have no common time")
            return draw("impact.of_several", self)
        return draw("impact.overview", self, times)

    def summary(self, title: str = "") -> Summary:
        """Table of the impact and its warnings, which `print` and notebooks show; of several impacts their ranges."""
        from restitution.impact.summary import of_impact, of_impacts

        return of_impacts(self, title) if np.shape(self.status) else of_impact(self, title)

    @property
    def _short(self) -> str:
        if np.shape(self.status):
            return f"{np.size(self.status)} impacts"
        time, force = in_words(float(self.contact_time), "s"), in_words(float(self.max_force), "N")
        return f"e = {self.restitution_coefficient:.6g}, T = {time}, F_max = {force}"

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers by name, in SI, with the energy budget and the validity report."""
        return {name: value for name, value in self.outputs.items() if name not in BUDGET} | {
            "max_semi_axes": self.max_semi_axes.tolist(),
            "zero_overlap_time": self.zero_overlap_time,
            "energy": self.energy._asdict(),
            "status": self.status,
            "method": self.method,
            "rtol": self.rtol,
            "warnings": self.warnings,
            "validity": self.validity.to_dict(),
        }
