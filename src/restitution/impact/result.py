"""Result of one impact or of several."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution import checks
from restitution.axes import unnamed
from restitution.checks import Array, Numeric
from restitution.errors import InputError
from restitution.impact.batch import shaped, solve_columns
from restitution.impact.problem import require_outputs
from restitution.impact.solution import PanelMotion, Sampled, Solution
from restitution.impact.status import Status
from restitution.quantities import (
    BODY,
    BUDGET,
    DEFAULT_OUTPUTS,
    ENERGIES,
    HISTORY,
    IMPACT_OUTPUTS,
    INPUTS,
    STATUS,
    checked_outputs,
    dataset,
    derived,
    needs,
)
from restitution.result import Result, Summary, Table, draw, of_higher_layer, of_values, plain, plain_symbol
from restitution.tally import Tally
from restitution.units import MASS, VELOCITY, in_words, scaled_unit
from restitution.validity import COLUMNS, Validity, numbers, report, together

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

    from restitution.impact.bounces import Bounces
    from restitution.impact.fields import ImpactFields
    from restitution.impact.problem import Impact
    from restitution.indentation.surface import Surface


# Energy budget of an impact.


class EnergyBudget(NamedTuple):
    """Energy budget; the last four are NaN where the body does not separate.

    Attributes
    ----------
    kinetic_in, kinetic_out : float or array
        Kinetic energy before and after the impact [J].
    dissipated : float or array
        Energy that the dashpots of the foundation dissipate in contact [J].
    stored : float or array
        Energy that the elements of the foundation still store when they leave contact [J].
    radiated : float or array
        Energy [J] that a target with an impedance carries away, or that adhesive surfaces lose to waves in jumps.
    residual : float or array
        `(kinetic_out + dissipated + stored + radiated - kinetic_in - work of the external force)/kinetic_in` [-].
    """

    kinetic_in: Numeric
    kinetic_out: Numeric
    dissipated: Numeric
    stored: Numeric
    radiated: Numeric
    residual: Numeric


@dataclass(frozen=True, eq=False, repr=False)
class ImpactResult(Result):
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
        which the relaxed half-space carries the external force; infinite on a liquid. Of the element method it is the
        depth at the end of the run.
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
    began_on : Surface or None
        The surface with an imprint on which the impact began; depths count from the undeformed surface all the same.
        None for a fresh one.

    Notes
    -----
    A single impact is solved once: history, energies and fields are evaluations of the stored solution. Relative to
    their largest values, their errors stay below some 1000 rtol between the nodes of the solver, and the residual of
    the energy balance stays below 10 rtol.
    """

    _default_outputs = DEFAULT_OUTPUTS
    _numbers = ("max_semi_axes", "zero_overlap_time", "energy", "status", "method", "rtol", "warnings", "validity")

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
    began_on: Surface | None = field(default=None, repr=False)
    _solution: Solution | Sampled | PanelMotion | None = field(default=None, repr=False)
    # Solves some of the impacts in the same way.
    _again: Callable[[Impact], ImpactResult] | None = field(default=None, repr=False)

    @property
    def velocity(self) -> Numeric:
        """Impact velocity v0 [m/s], in the shape of the results."""
        return self._named(velocity=self._by_name["velocity"])[0]

    @property
    def mass(self) -> Numeric:
        """Mass m [kg], in the shape of the results."""
        return self._named(mass=self._by_name["mass"])[0]

    @property
    def rebound_velocity(self) -> Numeric:
        """Speed of the rebound e v0 [m/s]."""
        return self._named(rebound_velocity=self._by_name["rebound_velocity"])[0]

    @property
    def turning_time(self) -> float:
        """Time [s] of the largest depth of a single impact; NaN for other methods than "exact"."""
        solution = self._single("the turning time is")
        return solution.turning_time if isinstance(solution, Solution) else math.nan

    @property
    def outputs(self) -> dict[str, Numeric]:
        """All outputs of the impact by name, in SI; energies and pressures of several by further solves."""
        energies = dict(zip(BUDGET, self.energy, strict=True))
        solved = {name: np.asarray(value) for name, value in (energies | {"max_pressure": self.max_pressure}).items()}
        columns = derived(self._by_name | solved)
        names = [name for name in IMPACT_OUTPUTS if name in columns]
        return dict(zip(names, self._named(**{name: columns[name] for name in names}), strict=True))

    @cached_property
    def _by_name(self) -> dict[str, Any]:
        """Inputs of the body, stored outputs and what follows from both, by name, without names of axes."""
        outputs = {name: getattr(self, name) for name in IMPACT_OUTPUTS if name in self.__dataclass_fields__}
        if np.shape(self.status):
            outputs = {name: np.asarray(values) for name, values in outputs.items()}
        impacts = self.impact
        if isinstance(impacts, list):
            return derived(outputs | {name: np.array([getattr(impact, name) for impact in impacts]) for name in BODY})
        return derived(outputs | {name: getattr(impacts, name) for name in BODY})

    def _named(self, **columns: Any) -> list[Any]:
        """Return columns as numbers, or in the shape of the impacts with the names of the axes if there are any."""
        shape, axes = np.shape(self.status), getattr(self.impact, "axes", None)
        if not shape:
            return [float(values) for values in columns.values()]
        arrays = [np.array(np.broadcast_to(values, shape), dtype=np.float64) for values in columns.values()]
        if axes is None:
            return arrays
        attributes = ((IMPACT_OUTPUTS.get(name) or INPUTS[name]).attributes for name in columns)
        return [axes.array(*column) for column in zip(arrays, columns, attributes, strict=True)]

    @cached_property
    def validity(self) -> Validity:
        """Report on the assumptions of the theory: the worst value of each, its limit, and advice."""
        return self.validity_on()

    def validity_on(self, body_size: Numeric = math.nan) -> Validity:
        """Return the validity report with the size of the target.

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
        size, shape = checks.number("body_size", body_size, "m"), np.shape(self.status)
        checks.refuse("body_size", size, size <= 0.0, "must be > 0", "m")
        if checks.common_shape({"body_size": size.shape, "impact": shape}) != shape:
            raise InputError("body_size", rule=f"must have the shape of the impacts, {shape}, not {size.shape}")
        inputs = self._compared | {"body_size": checks.plain(size)}
        if isinstance(self.impact, list):
            compared = numbers([impact.contact for impact in self.impact], **inputs)
        elif not self.impact.is_split:
            compared = numbers(self.impact.contact, **inputs)
        else:
            columns = {name: np.broadcast_to(each, np.shape(self.status)).reshape(-1) for name, each in inputs.items()}
            compared = together(
                numbers(part.contact, **{name: column[places] for name, column in columns.items()})
                for places, part in self.impact.parts()
            )
        if not np.shape(self.status):
            return report(compared)
        tally = Tally()
        tally.add(compared)
        return tally.report()

    @property
    def _compared(self) -> dict[str, Any]:
        """Columns of the validity report."""
        return {name: self._by_name[name] for name in (*COLUMNS, "velocity", "mass", "impedance")}

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
        columns = self._by_name
        depth = np.maximum(columns["residual_indentation_depth"], 0.0)
        speed = np.asarray(columns["rebound_velocity"])
        push = 2.0 * columns["external_force"] * depth / columns["mass"]
        # The squares of extreme velocities overflow or vanish.
        with np.errstate(all="ignore"):
            arrives = np.sqrt(speed**2 - push)
            flight = np.where(speed > 0.0, 2.0 * depth / (speed + arrives), np.inf)
            time = columns["contact_time"] + np.where(speed**2 >= push, flight, np.inf)
        return self._named(contact_time=np.where(np.isnan(columns["restitution_coefficient"]), np.nan, time))[0]

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
            return self._solution.max_pressure
        peak = solve_columns(self.impact, self.rtol or 0.0, pressure=True)["max_pressure"]
        return self._named(max_pressure=shaped(peak, np.shape(self.status)))[0]

    @property
    def max_semi_axes(self) -> Array:
        """Semi-axes a >= b [m] of the largest contact area, shape (2, ...); NaN where it is no ellipse.

        With the axis ratio k of the geometry, 1 for a disc, they are ``a_max/sqrt(k)`` and ``a_max sqrt(k)``.
        """
        if not isinstance(self.impact, list):
            return self.impact.profile.semi_axes(self._by_name["max_contact_radius"])
        radii = zip(self.impact, np.atleast_1d(self.max_contact_radius), strict=True)
        return np.stack([impact.profile.semi_axes(radius) for impact, radius in radii], axis=-1)

    @cached_property
    def energy(self) -> EnergyBudget:
        """Energy budget [J] and the residual of its balance; for several impacts by a second solve."""
        solution, shape = self._solution, np.shape(self.status)
        if shape:
            columns = solve_columns(self.impact, self.rtol or 0.0, energy=True)
            return EnergyBudget(*self._named(**{name: columns[name].reshape(shape) for name in BUDGET}))
        energies = (np.nan, np.nan, np.nan)
        if isinstance(solution, Solution):
            energies = solution.energies
        elif solution is not None:
            energies = solution.dissipated, solution.stored, solution.radiated
        numbers = self._by_name | dict(zip(ENERGIES, energies, strict=True))
        if self.began_on is not None:
            # The external force works from the imprint on.
            numbers["residual_indentation_depth"] -= self.began_on.depth
        columns = derived(numbers)
        return EnergyBudget(*self._named(**{name: columns[name] for name in BUDGET}))

    @cached_property
    def _fields(self) -> ImpactFields:
        from restitution.impact.fields import ImpactFields

        if self.method != "exact":
            rule = f"must be 'exact' for pressure and surface displacement, and this result is of {self.method!r}"
            raise InputError("method", rule=rule)
        solution = self._single("pressure and surface displacement are")
        assert isinstance(solution, Solution)
        assert not isinstance(self.impact, list)
        return ImpactFields(self.impact, solution, self.rtol or 0.0)

    def _single(self, what: str) -> Solution | Sampled | PanelMotion:
        """Return the solution of one impact that ended in separation."""
        if self._solution is not None:
            return self._solution
        if not isinstance(self.status, Status):
            many = "a list" if isinstance(self.impact, list) else f"an array of shape {self.status.shape}"
            raise InputError("impact", rule=f"must be a single one: {what} of one impact, this result is of {many}")
        rule = f"must end: {what} of a contact that ends, and this contact does not ({self.status.message})"
        raise InputError("contact_time", np.inf, rule, "s")

    def surface(self, *, after: float = 0.0) -> Surface:
        """Return the surface that a single impact leaves, a time `after` [s] the separation.

        Raises
        ------
        InputError
            If the result is of several impacts or of the element method, the target has an impedance, or the body
            does not separate.

        Examples
        --------
        The same spot is harder the second time:

        >>> import restitution as rs
        >>> solid = rs.Material(rs.PronySeries(0.25, [1.0], [1.0]), bulk=float("inf"))
        >>> impact = rs.Impact(material=solid, profile=rs.Parabola(radius=1.0), mass=1.0, velocity=1.0)
        >>> first = rs.solve(impact)
        >>> second = rs.solve(impact, surface=first.surface(after=0.5))
        >>> print(f"{first.restitution_coefficient:.6f}, then {second.restitution_coefficient:.6f}")
        0.628799, then 0.696070
        """
        from restitution.impact.repeated import panels_of_impact

        if self.method == "elements":
            raise InputError("method", self.method, "must be 'exact' for the surface that an impact leaves")
        solution, impact = self._single("the surface is that"), self.impact
        assert not isinstance(impact, list)
        panels = solution.panels if isinstance(solution, PanelMotion) else None
        if panels is None:
            deepest, rtol = float(np.asarray(self.max_indentation_depth)), max(self.rtol or 0.0, 1e-11)
            panels = panels_of_impact(impact, None, deepest, rtol)
        left = panels.surface(impact.contact)
        return left.after(checks.single_nonnegative("after", after, "s"))

    @cached_property
    def history(self) -> xarray.Dataset:
        """History of depth, velocity, force, contact radius and energies at 401 times."""
        return self.sample()

    def sample(self, times: ArrayLike | None = None, *, n_points: int = 401) -> xarray.Dataset:
        """Return the history at given times, or at a number of times.

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
        return self._history(self._columns(times, n_points=n_points))

    def _history(self, columns: Mapping[str, Array]) -> xarray.Dataset:
        """Return columns over time as a Dataset."""
        described = {name: (values, HISTORY[name]) for name, values in columns.items()}
        return dataset("time", described, {"method": self.method, "rtol": self.rtol or np.nan})

    def _columns(self, times: ArrayLike | None = None, *, n_points: int = 401) -> dict[str, Array]:
        """Return the columns of `sample` by name, which are quicker than a Dataset."""
        checks.whole("n_points", n_points, 2, 10_000_000)
        solution = self._single("a history is")
        if isinstance(solution, Solution):
            trajectory = solution.at(solution.times(n_points) if times is None else times)
        else:
            trajectory = solution.at(times)
            body_velocity = trajectory.indentation_velocity + trajectory.force / self._by_name["impedance"]
            kinetic = 0.5 * self._by_name["mass"] * body_velocity**2
            trajectory = trajectory._replace(kinetic_energy=kinetic)
        return {name: values for name, values in trajectory._asdict().items() if values is not None}

    def pressure(self, r: ArrayLike, t: ArrayLike) -> Any:
        """Return the contact pressure p(r, t) [Pa].

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
        """Return the normal displacement of the surface w(r, t) [m], into the half-space, during contact and after it.

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

    def plot(self, times: ArrayLike | None = None) -> Figure:
        """Return the figure of the impact: force over time, loop, depth, contact radius, pressure, energies.

        Of several impacts e, contact time, depth and force over the velocity, or over what varies instead.

        Parameters
        ----------
        times : array_like, optional
            Times [s] within the contact, at most seven, at which the pressure is shown; by default four.
        """
        if np.shape(self.status):
            if times is not None:
                raise InputError("times", rule="must be left out for several impacts, which have no common time")
            return draw("impact.of_several", self)
        return draw("impact.overview", self, times)

    def derivatives(self, names: Iterable[str], *arguments: Any, **options: Any) -> Any:
        """Return the derivatives of the outputs by inputs of the impact, with their errors; see `rs.derivatives`.

        Parameters
        ----------
        names : sequence of str
            Names of the inputs.
        *arguments, **options
            Outputs and options of `rs.derivatives`.

        Examples
        --------
        >>> import restitution as rs
        >>> steel = rs.elastic(shear_modulus=80e9, poisson_ratio=0.3)
        >>> result = rs.solve(rs.Impact(steel, rs.Parabola(0.01), mass=0.03, velocity=0.1))
        >>> by = result.derivatives(["velocity", "mass"])
        >>> print(by.elasticities[1].round(9))  # Hertz: the contact time grows as v^(-1/5) m^(2/5)
        [-0.2  0.4]
        """
        return of_higher_layer("propagation.derivatives.derivatives", self.impact, names, *arguments, **options)

    def summary(self, title: str = "") -> Summary:
        """Table of the impact and its warnings, which `print` and notebooks show; of several impacts their ranges."""
        return of_impacts(self, title) if np.shape(self.status) else of_impact(self, title)

    @property
    def _short(self) -> str:
        if np.shape(self.status):
            return f"{np.size(self.status)} impacts"
        time, force = in_words(float(self.contact_time), "s"), in_words(float(self.max_force), "N")
        return f"e = {self.restitution_coefficient:.6g}, T = {time}, F_max = {force}"

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers by name, in SI, with the energy budget and the validity report."""
        outputs = {name: plain(np.asarray(value)) for name, value in self.outputs.items() if name not in BUDGET}
        return outputs | super().to_dict()

    def to_dataset(self, outputs: Iterable[str] | None = None) -> xarray.Dataset:
        """Return outputs and the status as a Dataset over the named axes of the impacts, or over dim_0 and so on.

        Parameters
        ----------
        outputs : sequence of str
            Names of `restitution.quantities.IMPACT_OUTPUTS`; by default the restitution, contact time, largest depth
            and force, and with friction all that it adds. Energies and pressures take a second solve of several
            impacts.

        Examples
        --------
        >>> import restitution as rs, xarray as xr
        >>> v = xr.DataArray([0.25, 0.5], dims="velocity", coords={"velocity": [0.25, 0.5]})
        >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
        >>> result = rs.solve(rs.Impact(rubber, rs.Parabola(radius=0.01), mass=0.005, velocity=v))
        >>> table = result.to_dataset(["contact_time"])
        >>> dict(table.sizes), table.contact_time.attrs["units"]
        ({'velocity': 2}, 's')
        """
        names = checked_outputs(self._default_outputs if outputs is None else outputs, IMPACT_OUTPUTS)
        require_outputs(self.impact, names)
        columns = self.outputs if needs(names, {*ENERGIES, "max_pressure"}) else self._by_name
        axes = getattr(self.impact, "axes", None) or unnamed(np.shape(self.status))
        variables = {name: (columns[name], IMPACT_OUTPUTS[name].attributes) for name in names}
        variables[STATUS] = self.status, Status.attributes()
        return axes.dataset(variables, {"method": self.method, "rtol": self.rtol or np.nan})

    def sel(self, indexers: Mapping[Any, Any] | None = None, method: str | None = None, **names: Any) -> ImpactResult:
        """Solve the impacts at some coordinates of the named axes once more; see `Impact.sel`.

        The result of a single impact has its history, its fields and its energies.

        Examples
        --------
        >>> import restitution as rs, xarray as xr
        >>> v = xr.DataArray([0.25, 0.5], dims="velocity", coords={"velocity": [0.25, 0.5]})
        >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
        >>> result = rs.solve(rs.Impact(rubber, rs.Parabola(radius=0.01), mass=0.005, velocity=v))
        >>> float(result.sel(velocity=0.4, method="nearest").history.indentation_velocity[0])
        0.5
        """
        if isinstance(self.impact, list) or self._again is None:
            raise InputError("impact", rule="must have named axes, which numbers that are DataArrays give it")
        return self._again(self.impact.sel(indexers, method, **names))


# Summaries of impacts and of bounces: the tables that results show.


# Bounces that a screen holds; of more, the first and the last are shown.
_SHOWN, _LAST = 24, 4


def of_impact(result: ImpactResult, title: str = "", *, dimensionless: bool = False) -> Summary:
    """Return the table of one impact: outputs, semi-axes, the return to the surface; method and balance below."""
    # A number below the tolerance times the largest of its kind is rounding.
    tolerance = 1e-9 if result.rtol is None else float(result.rtol)
    noise = {"m": tolerance * float(result.max_indentation_depth), "J": tolerance * float(result.energy.kinetic_in)}
    values: list[tuple[str, str, float, str]] = []
    for name, number in result.outputs.items():
        output, x = IMPACT_OUTPUTS[name], float(number)
        unit = output.unit
        if not name.endswith("_residual"):
            x = 0.0 if abs(x) < noise.get(unit, 0.0) else x
            values.append((output.words, plain_symbol(output.symbol), x, unit))
    long, short = result.max_semi_axes
    if short < long:
        words = "semi-axis of the largest contact"
        values += [(f"long {words}", "a", float(long), "m"), (f"short {words}", "b", float(short), "m")]
    values.append(("back at the undeformed surface", "t_0", float(result.zero_overlap_time), "s"))
    stated = "" if result.rtol is None else f", rtol {result.rtol:g}"
    residual = float(result.energy.residual)
    balance = f", energy residual {residual:.1e}" if math.isfinite(residual) else ""
    status = Status(int(result.status))
    return Summary(
        title
        or f"Impact of {in_words(float(result.mass), MASS.unit)} at {in_words(float(result.velocity), VELOCITY.unit)}",
        of_values(values, units=not dimensionless),
        (f"method {result.method}{stated}{balance}",),
        warnings=(*result.warnings, *([] if status == Status.SEPARATED else [status.message])),
    )


def of_impacts(result: ImpactResult, title: str = "") -> Summary:
    """Table of several impacts: the lowest and the highest of each output that is stored; their ends below."""
    statuses = np.asarray(result.status)
    rows: list[tuple[str, ...]] = []
    for name in ("velocity", *(name for name in IMPACT_OUTPUTS if name in result.__dataclass_fields__)):
        quantity = IMPACT_OUTPUTS.get(name) or INPUTS[name]
        values = np.asarray(getattr(result, name), dtype=np.float64)
        values = values[np.isfinite(values)]
        factor, prefixed = scaled_unit(values, quantity.unit)
        ends = [f"{factor * end:.6g}" for end in (values.min(), values.max())] if values.size else ["-", "-"]
        rows.append((quantity.words, plain_symbol(quantity.symbol), *ends, prefixed))
    counts = [(status, int(np.count_nonzero(statuses == status))) for status in Status]
    shape = f"a list of {statuses.size}" if isinstance(result.impact, list) else f"shape {statuses.shape}"
    stated = "" if result.rtol is None else f", rtol {result.rtol:g}"
    return Summary(
        title or f"{statuses.size} impacts, {shape}",
        Table(("quantity", "symbol", "lowest", "highest", "unit"), rows),
        (", ".join(f"{n} {status.name}" for status, n in counts if n), f"method {result.method}{stated}"),
        warnings=result.warnings,
    )


def of_bounces(bounces: Bounces, title: str = "") -> Summary:
    """Return the table with a row for each bounce; the end below."""
    heights, times = scaled_unit(bounces.drop_height, "m"), scaled_unit(bounces.contact_time, "s")
    titles = (
        "bounce", "touch at [s]", "velocity [m/s]", "restitution e", f"contact time [{times.unit}]",
        "tan delta", f"rises to [{heights.unit}]",
    )  # fmt: skip

    sliding = {
        "place [m]": "place", "v_x [m/s]": "rebound_tangential_velocity", "spin [rad/s]": "rebound_spin",
        "e_t": "tangential_restitution_coefficient",
    }  # fmt: skip
    sliding = {head: getattr(bounces, name) for head, name in sliding.items() if hasattr(bounces, name)}

    def row(n: int) -> tuple[str, ...]:
        duration = bounces.contact_time[n] * times.factor
        touch = (
            f"{bounces.touch_time[n]:.6g}",
            f"{bounces.velocity[n]:.4g}",
            f"{bounces.restitution_coefficient[n]:.6g}",
        )
        lasts = f"{duration:.4g}" if math.isfinite(duration) else "stays"
        tangent = f"{bounces.loss_tangent[n]:.4g}" if math.isfinite(bounces.loss_tangent[n]) else "-"
        more = (f"{column[n]:.4g}" for column in sliding.values())
        middle = () if sliding else (lasts, tangent)
        return str(n + 1), *touch, *middle, f"{bounces.height[n] * heights.factor:.4g}", *more

    count = bounces.n_bounces
    if sliding:
        titles = *titles[:4], titles[-1], *sliding
    rows = [row(n) for n in range(count) if count <= _SHOWN or not _SHOWN - _LAST <= n < count - _LAST]
    if count > _SHOWN:
        rows.insert(_SHOWN - _LAST, ("…",) * len(titles))
    end = f"{bounces.touch_time[-1]:.6g} s; {bounces.ended}: {bounces.ended.message}"
    return Summary(
        f"{title or 'Bounces'}, from {bounces.drop_height * heights.factor:.6g} {heights.unit}",
        Table(titles, rows),
        (f"{count} bounce{'s' * (count != 1)} in {end}",),
        warnings=bounces.warnings,
    )
