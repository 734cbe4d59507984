"""Impacts with adhesion: their results, and the velocity below which a body sticks."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from restitution import checks
from restitution.checks import Array, Numeric
from restitution.errors import InputError
from restitution.impact.adhesive import (
    LEAST_RTOL,
    attraction_numbers,
    balanced,
    marched,
    maugis_numbers,
    problem_of,
    unresolved,
)
from restitution.impact.batch import shaped
from restitution.impact.dugdale import sticking
from restitution.impact.members import of_each, shape_of, single_of
from restitution.impact.problem import Impact
from restitution.impact.result import EnergyBudget, ImpactResult
from restitution.impact.solution import Progress, within_contact
from restitution.impact.status import SolverError, Status, failures
from restitution.indentation.attraction import Jump, March
from restitution.parallel import on_threads
from restitution.quantities import (
    ADHESION,
    ATTRACTION_TIME,
    BUDGET,
    DEFAULT_OUTPUTS,
    IMPACT_OUTPUTS,
    STATUS,
)
from restitution.result import Summary, draw
from restitution.units import VELOCITY, in_words
from restitution.validity import warn

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

    from restitution.indentation.surface import Surface


@dataclass(frozen=True, eq=False, repr=False)
class AdhesiveResult(ImpactResult):
    """Result of one impact with adhesion or of several, in SI units.

    Times count from the first attraction, at the depth -h0, and the contact time ends with the last attraction.
    Depths, forces and radii are those of `ImpactResult`, with the radius a of the elements that touch. A body that
    sticks has the status CAPTURED, e = 0, and the depth at rest as its residual depth; its largest values are those
    until it is known to be held. A constant force acts from the first attraction on.

    Attributes
    ----------
    pull_off_force : float or array
        Largest pull [N] during the impact.
    touching_time : float or array
        Time [s] from the first to the last touch, within the contact time.
    zone_width : float or array
        Width c - a [m] of the attracted ring around the largest contact; NaN without touch.
    dissipated_energy, stored_energy, radiated_energy : float or array
        Energies [J] that the material dissipates, that the surface still stores at separation, and that jumps into
        contact and out of it lose to waves. NaN where the body does not separate.
    restitution_error : float or array
        Estimate of the error of e [-], also where it is above `rtol`; 0 for a body that sticks.

    Notes
    -----
    Elements of second order, extrapolated from N and 2N of them until e is known to `rtol`, or to ``0.1 rtol/e`` below
    e = 0.1, as the energy is what is computed. A body counts as captured when its energy falls below that of rest far
    apart, or the contact pulls it back twice, for which a rebound of less than some 1e-2 may be taken.
    """

    _default_outputs = (*DEFAULT_OUTPUTS, *ADHESION)
    _numbers = (*ImpactResult._numbers, "restitution_error", "maugis_numbers")

    pull_off_force: Numeric = math.nan
    touching_time: Numeric = math.nan
    zone_width: Numeric = math.nan
    dissipated_energy: Numeric = math.nan
    stored_energy: Numeric = math.nan
    radiated_energy: Numeric = math.nan
    restitution_error: Numeric = math.nan
    _march: March | None = field(default=None, repr=False)

    @cached_property
    def energy(self) -> EnergyBudget:
        """Energy budget [J] and the residual of its balance; jumps radiate what they lose."""
        columns = balanced(self.impact, self._by_name)
        return EnergyBudget(*self._named(**{name: columns[name] for name in BUDGET}))

    @property
    def maugis_numbers(self) -> tuple[Numeric, Numeric]:
        """Maugis' parameter lambda [-] with the static and with the instantaneous modulus; NaN of a body without R.

        The larger one says how thin the zone is: below 0.1 as Derjaguin, Muller and Toporov (DMT) have it, above 5
        nearly as Johnson, Kendall and Roberts (JKR) do.
        """
        static, glass = of_each(self.impact, maugis_numbers)
        return static, glass

    @property
    def _compared(self) -> dict[str, Any]:
        return super()._compared | attraction_numbers(self.impact, self._by_name)

    @property
    def jumps(self) -> tuple[Jump, ...]:
        """Jumps of a single impact, those of the finest march."""
        return self._single_march("its jumps").jumps

    def _single_march(self, what: str) -> March:
        """Return the finest march of a single impact."""
        if self._march is None:
            raise InputError("impact", rule=f"must be a single one for {what}")
        return self._march

    @cached_property
    def history(self) -> xarray.Dataset:
        """History at all steps: depth, velocity, force, radii and energies over time; a jump has two rows of one time.

        That of a captured body ends where it is known to be held.
        """
        return self._history(self._rows())

    def _columns(self, times: ArrayLike | None = None, *, n_points: int = 401) -> dict[str, Array]:
        rows = self._rows()
        checks.whole("n_points", n_points, 2, 10_000_000)
        end = float(rows["time"][-1])
        moments = np.linspace(0.0, end, n_points) if times is None else within_contact(times, end)
        return {name: np.interp(moments, rows["time"], values) for name, values in rows.items()}

    def _history(self, columns: Mapping[str, Array]) -> xarray.Dataset:
        history = super()._history(columns)
        return history.assign_coords(time=history["time"].assign_attrs(ATTRACTION_TIME.attributes))

    def _rows(self) -> dict[str, Array]:
        """Return the columns of the history."""
        time, depth, velocity, force, zone, radius, dissipated, jumps = self._single_march("a history").motion.T
        kinetic = 0.5 * np.asarray(self._by_name["mass"]) * velocity**2
        return {
            "time": time, "indentation_depth": depth, "indentation_velocity": velocity, "force": force,
            "contact_radius": radius, "zone_radius": zone, "kinetic_energy": kinetic,
            "dissipated_energy": dissipated, "jump_energy": jumps,
        }  # fmt: skip

    @property
    def turning_time(self) -> float:
        """Time [s] of the largest depth of a single impact, that of a step."""
        rows = self._rows()
        return float(rows["time"][np.argmax(rows["indentation_depth"])])

    def surface(self, *, after: float = 0.0) -> Surface:
        """Refuse: no later contact begins on the surface of an adhesive impact."""
        raise InputError("adhesion", rule="must be left out for the surface that an impact leaves")

    def plot(self, times: ArrayLike | None = None) -> Figure:
        """Return the figure: force over depth with its jumps, depth and radii over time; of several e and the pull."""
        if times is not None:
            raise InputError("times", rule="must be left out with adhesion")
        return draw("adhesion.of_several" if np.shape(self.status) else "adhesion.overview", self)

    def summary(self, title: str = "") -> Summary:
        """Return the table of outputs, the range of the attraction and warnings; of several impacts their ranges."""
        summary = super().summary(title)
        if np.shape(self.status) or not isinstance(self.impact, Impact):
            return summary
        return replace(summary, lines=(*summary.lines, _zone_in_words(self.impact)))


def _zone_in_words(impact: Impact) -> str:
    """Return the range and Maugis' parameters of a single impact."""
    assert impact.adhesion is not None
    static, glass = (float(np.asarray(value)) for value in maugis_numbers(impact))
    reach = in_words(float(np.asarray(impact.adhesion.range)), "m")
    if math.isnan(static):
        return f"range of the attraction {reach}"
    at_rest = "infinite" if math.isinf(static) else f"{static:.3g}"
    return f"range of the attraction {reach}; Maugis' lambda {at_rest} at rest, {glass:.3g} at once"


def solve_with_adhesion(
    impact: Impact | list[Impact], rtol: float, errors: Literal["raise", "warn"] | None, workers: int | None,
    progress: Progress | None,
) -> AdhesiveResult:  # fmt: skip
    """Solve one adhesive impact, an array or a list of them; see `solve`."""
    shape, limit = shape_of(impact), max(rtol, LEAST_RTOL)
    if isinstance(impact, Impact) and not shape and errors != "warn" and (cause := unresolved(impact)):
        raise SolverError(Status.NOT_ACCURATE, cause=cause)
    columns, march = marched(impact, limit, workers, progress)
    status = columns[STATUS]
    message = failures(np.bincount(status, minlength=len(Status)).tolist(), status.size)
    if message and (errors or ("warn" if shape else "raise")) == "raise":
        first = int(np.argmax(status >= Status.TOO_MANY_STEPS))
        place = f"impact {first} of {status.size}: " if status.size > 1 else ""
        error = columns["restitution_error"][first]
        reached = f"the error of e is {error:.1g}; " if math.isfinite(error) else ""
        raise SolverError(Status(int(status[first])), place + reached + _zone_in_words(single_of(impact, first)))
    warn({"failed": message} if message else {}, 4)
    result = _result(impact, limit, columns, march)
    if shape:
        warn({check.kind: check.warning for check in result.validity if check.exceeded}, 4)
    return result


def _result(
    impact: Impact | list[Impact], rtol: float, columns: Mapping[str, Array], march: March | None
) -> AdhesiveResult:
    """Return the result of the columns of all impacts."""
    shape, axes = shape_of(impact), None if isinstance(impact, list) else impact.axes
    numbers: dict[str, Any] = {name: shaped(column, shape) for name, column in columns.items() if name != STATUS}
    status = columns[STATUS]
    codes: Any = status.astype(np.int64).reshape(shape) if shape else Status(int(status[0]))
    if axes is not None:
        numbers = {
            name: axes.array(column, name, IMPACT_OUTPUTS[name].attributes if name in IMPACT_OUTPUTS else {})
            for name, column in numbers.items()
        }
        codes = axes.array(codes, STATUS, Status.attributes())
    again = None if axes is None else partial(_again, rtol=rtol)
    return AdhesiveResult(
        **numbers, status=codes, impact=impact, method="adhesion", rtol=rtol, _march=march, _again=again
    )


def _again(impact: Impact, rtol: float) -> AdhesiveResult:
    return solve_with_adhesion(impact, rtol, None, None, None)


def sticking_velocity(impact: Impact, *, rtol: float = 1e-4) -> Any:
    """Return the velocity [m/s] below which a body sticks to the surface, also under its weight.

    Parameters
    ----------
    impact : Impact
        One impact with adhesion, or an array of them. The search begins at its velocity.
    rtol : float
        Relative error, in [1e-5, 1e-2].

    Returns
    -------
    float or array
        The velocity nearest to that of the impact at which capture and rebound meet.

    Raises
    ------
    InputError
        If the impact has no adhesion.
    SolverError
        If no velocity within six decades sticks, as of an elastic body without jumps, or none rebounds, or the
        tolerance is not reached.

    Notes
    -----
    An elastic ball in the limit of Johnson, Kendall and Roberts sticks below ``sqrt(2 W_s/m)`` with
    ``W_s = 7.092 (w^5 R^4/E*^2)^(1/3)``.

    Examples
    --------
    >>> import restitution as rs
    >>> polymer = rs.standard_solid(1e9, 1e9, 10.0, poisson_ratio=0.35, density=1200.0)
    >>> bead = rs.Impact(polymer, rs.Parabola(5e-6), mass=6.3e-13, velocity=1.0, adhesion=rs.Adhesion(0.05))
    >>> print(f"{rs.sticking_velocity(bead, rtol=1e-2):.2g} m/s")
    0.24 m/s
    """
    if not isinstance(impact, Impact) or impact.adhesion is None:
        raise InputError("impact", rule="must be an Impact with adhesion")
    limit = float(checks.single("rtol", checks.within("rtol", rtol, 1e-5, 1e-2)))
    count = math.prod(impact.shape)
    velocities = np.full(count, np.nan)

    def run(place: int) -> None:
        single = single_of(impact, place)
        if cause := unresolved(single):
            raise SolverError(Status.NOT_ACCURATE, cause=cause)
        velocities[place] = sticking(problem_of(single), limit)[0]

    run(0)
    on_threads(run, range(1, count), None, lambda: None)
    missing = np.flatnonzero(np.isnan(velocities))
    if missing.size:
        which = f"impact {missing[0]} of {count}: " if count > 1 else ""
        raise SolverError(Status.NOT_ACCURATE, cause=f"{which}no velocity found at which capture and rebound meet")
    values = shaped(velocities, impact.shape)
    return values if impact.axes is None else impact.axes.array(values, "sticking_velocity", {"units": VELOCITY.unit})
