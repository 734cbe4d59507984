"""Result of a prescribed indentation, its largest values and its work."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from restitution.checks import Array, finite, nonnegative, single, single_nonnegative, truth, whole
from restitution.contact.geometry import Contact, Geometry
from restitution.errors import InputError
from restitution.kernel import outcome
from restitution.kernel.plain import single_problem
from restitution.material.viscoelastic import Material
from restitution.quantities import HISTORY, INDENTATION, Quantity, dataset
from restitution.result import Outcome, Result, Summary, of_values, plain_symbol
from restitution.units import LENGTH, in_words
from restitution.validity import Validity, validity

if TYPE_CHECKING:
    import xarray

    from restitution.indentation.adhesion import AdhesiveSolution
    from restitution.indentation.elastic import ElasticSolution
    from restitution.indentation.history import History
    from restitution.indentation.panels import PanelSolution
    from restitution.indentation.solve import Solution
    from restitution.indentation.surface import Surface


COLUMNS = ("indentation_depth", "indentation_velocity", "force", "contact_radius")


class IndentationStatus(Outcome):
    """How an indentation ended, with a `message` for each member."""

    SEPARATED = outcome.SEPARATED, "the contact ended within the prescribed history"
    IN_CONTACT = outcome.IN_CONTACT, "the bodies were still in contact when the prescribed history ended"


@dataclass(frozen=True, eq=False, repr=False)
class IndentationResult(Result):
    """Indentation under a prescribed depth or force; SI units.

    `plot` shows force, depth and contact radius over time, and force over depth.

    Attributes
    ----------
    time : array, shape (n,)
        Times t [s] at which the columns below are given.
    indentation_depth, indentation_velocity, force, contact_radius : array, shape (n,)
        Depth d of the tip below the undeformed surface [m], its rate [m/s], normal force F [N], contact radius a [m].
        At a jump or a kink of the history: the values behind it. After the contact F = a = 0; under a prescribed force
        d is then the depth of the recovering imprint. The first velocity under a force may be infinite.
    contact_intervals : array, shape (n, 2)
        Times [s] at which contacts begin and end; the last end is infinite if it outlasts the history.
    turning_times : array, shape (m,)
        Times [s] at which the contact changes between growth and shrinkage.
    contact_end_time : float
        Time [s] at which the last contact ends; infinite if it outlasts the history.
    turning_time : float
        Time [s] at which the contact radius has become largest.
    status : IndentationStatus
        Whether the contact ended.
    contact : Contact
        Materials and profile; `material`, `profile` and `counter_material` are short for its parts.
    prescribed, prescribed_history
        "depth", "force" or "base" (the depth of the base of a spring), and its `History`.
    rtol : float
        Tolerance of depth, force and contact radius, over their largest value.
    error : float
        Stated error of the same: the tolerance, and the error of the table of the profile if it needs one.
    """

    _numbers = (
        "contact_end_time", "turning_time", "contact_intervals", "turning_times", "max_force", "max_indentation_depth",
        "max_contact_radius", "residual_indentation_depth", "work", "dissipated", "stored", "status", "prescribed",
        "rtol", "error", "warnings", "validity",
    )  # fmt: skip
    _picture = "history.overview"
    _shown: ClassVar[dict[str, Quantity]] = INDENTATION

    time: Array = field(repr=False)
    indentation_depth: Array = field(repr=False)
    indentation_velocity: Array = field(repr=False)
    force: Array = field(repr=False)
    contact_radius: Array = field(repr=False)
    contact_intervals: Array = field(repr=False)
    turning_times: Array = field(repr=False)
    contact_end_time: float
    turning_time: float
    status: IndentationStatus
    contact: Contact
    prescribed: str
    prescribed_history: History = field(repr=False)
    rtol: float
    error: float
    _solution: Solution | PanelSolution | ElasticSolution | AdhesiveSolution = field(repr=False)

    @property
    def material(self) -> Material:
        """Material of the target."""
        return self.contact.material

    @property
    def counter_material(self) -> Material | None:
        """Material of the indenter; None where it is rigid."""
        return self.contact.counter_material

    @property
    def profile(self) -> Geometry:
        """Profile of the indenter, or another geometry."""
        return self.contact.profile

    @cached_property
    def history(self) -> xarray.Dataset:
        """History over `time`: indentation depth and velocity, force, contact radius, with units."""
        return self._dataset(self.time, tuple(getattr(self, name) for name in COLUMNS))

    def sample(self, times: ArrayLike | None = None, *, n_points: int = 401, before: bool = False) -> xarray.Dataset:
        """Return the history at other times.

        Parameters
        ----------
        times : array_like, optional
            Times [s] within the prescribed history.
        n_points : int
            Number of even times if none are given; the knots of the history, the turning and the end are added.
        before : bool
            Whether a kink or a jump gives the values before it, not those behind it.

        Raises
        ------
        InputError
            If a time lies outside the prescribed history.

        Examples
        --------
        >>> import restitution as rs
        >>> gel = rs.Material(rs.PronySeries(200.0, [800.0], [0.3]), bulk=float("inf"))
        >>> result = rs.indent(gel, rs.Parabola(2.5e-6), depth=rs.triangle(1e-6, 1.0))
        >>> print(float(result.sample([0.5]).indentation_depth[0]))
        5e-07
        """
        whole("n_points", n_points, 2)
        moments = (
            self._solution.times(n_points) if times is None else np.atleast_1d(finite("time", times, "s")).ravel()
        )
        return self._dataset(moments, self._solution.at(moments, before=truth("before", before)))

    @cached_property
    def max_force(self) -> float:
        """Largest normal force [N], which may lie between the times."""
        return self._solution.largest(2)

    @cached_property
    def max_indentation_depth(self) -> float:
        """Largest depth during contact [m]."""
        return self._solution.largest(0)

    @property
    def max_contact_radius(self) -> float:
        """Largest contact radius [m]."""
        return self._solution.max_contact_radius

    @cached_property
    def residual_indentation_depth(self) -> float:
        """Depth [m] at which the contact ends, that is, of the imprint, which recovers; NaN if it does not end."""
        if not math.isfinite(self.contact_end_time):
            return math.nan
        return float(self._solution.at([self.contact_end_time])[0][0])

    @cached_property
    def work(self) -> float:
        """Work [J] that the indenter did on the body until the end of the history."""
        return self._solution.work

    @cached_property
    @single_problem()
    def _panels(self) -> PanelSolution:
        return self._solution.panels

    @cached_property
    @single_problem()
    def stored(self) -> float:
        """Energy [J] that is left in the springs of the material at the end of the history.

        It dissipates while an imprint recovers. NaN where panels do not resolve the history, such as that of some
        forces on a material with a dashpot in parallel.
        """
        if self.contact.reduced_modulus.is_elastic:
            return self.work
        try:
            return self._panels.elements.stored
        except InputError:
            return math.nan

    @property
    def dissipated(self) -> float:
        """Energy [J] that the body has dissipated until the end of the history: work - stored."""
        return self.work - self.stored

    @single_problem()
    def imprint(self, time: ArrayLike, radius: ArrayLike) -> Array:
        """Return the displacement [m] of the surface at a time [s] at radii [m] from the axis, positive into the body.

        Raises
        ------
        InputError
            If the time is outside of the history, or the body is not axisymmetric.
        """
        moment = single("time", finite("time", time, "s"), "s")
        r = np.asarray(nonnegative("radius", radius, LENGTH.unit))
        return self._panels.until(moment).elements.displacement(r)[()]

    @single_problem()
    def surface(self, *, after: float = 0.0) -> Surface:
        """Return the surface that the contact leaves, a time `after` [s] the end of the history.

        Raises
        ------
        InputError
            If the bodies are in contact at the end.

        Examples
        --------
        >>> import restitution as rs
        >>> gel = rs.Material(rs.PronySeries(200.0, [800.0], [0.3]), bulk=float("inf"))
        >>> first = rs.indent(gel, rs.Parabola(2.5e-6), depth=rs.triangle(1e-6, 1.0))
        >>> again = rs.indent(gel, rs.Parabola(2.5e-6), depth=rs.triangle(1e-6, 1.0), surface=first.surface(after=0.1))
        >>> print(f"{first.max_force:.4e} N, then {again.max_force:.4e} N")
        4.1563e-09 N, then 3.9099e-09 N
        """
        return self._panels.surface(self.contact).after(single_nonnegative("after", after, "s"))

    @cached_property
    def validity(self) -> Validity:
        """Assumptions of the theory, each with its number, its limit and advice.

        The contact lasts from first touch to its end, or to the end of the history.
        """
        speeds = np.abs(self.indentation_velocity)
        stop = min(self.contact_end_time, self.prescribed_history.stop)
        return validity(
            self.contact,
            max_contact_radius=self.max_contact_radius,
            max_indentation_depth=self.max_indentation_depth,
            velocity=np.max(speeds, initial=0.0, where=np.isfinite(speeds)),
            contact_time=stop - self._solution.units.touch,
        )

    @property
    def warnings(self) -> list[str]:
        """Messages of the assumptions that are doubtful."""
        return self.validity.warnings

    def summary(self, title: str = "") -> Summary:
        """Return the table of the indentation and its warnings, which `print` and notebooks show."""
        values: list[tuple[str, str, float, str]] = []
        for name, quantity in self._shown.items():
            value = float(getattr(self, name))
            value = value if math.isfinite(value) else math.nan
            values.append((quantity.words, plain_symbol(quantity.symbol), value, quantity.unit))
        lines = (f"prescribed {self.prescribed}, {self.status.message}, rtol {self.rtol:g}",)
        return Summary(title or "Indentation", of_values(values), lines, warnings=self.warnings)

    @property
    def _short(self) -> str:
        depth = in_words(self.max_indentation_depth, "m")
        return f"F_max = {in_words(self.max_force, 'N')}, d_max = {depth}, {self.status.name}"

    def _dataset(self, times: Array, columns: tuple[Array, ...]) -> xarray.Dataset:
        values = {"time": times} | dict(zip(COLUMNS, columns, strict=True))
        history = dataset(
            "time", {name: (column, HISTORY[name]) for name, column in values.items()},
            {"prescribed": self.prescribed, "rtol": self.rtol},
        )  # fmt: skip
        history["time"].attrs["long_name"] = "time"
        return history
