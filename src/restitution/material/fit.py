"""Measured relaxation and dynamic moduli, and the Prony series fitted to them."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from restitution.checks import Array, number, single, single_nonnegative, single_positive, truth, within
from restitution.errors import InputError, InputTypeError, RestitutionWarning
from restitution.material.conversion import Deformation, shear_and_bulk
from restitution.material.prony import EXTREME, PronySeries
from restitution.material.viscoelastic import Material
from restitution.numerics.coordinates import Coordinate
from restitution.quantities import MODULUS, Quantity
from restitution.result import draw
from restitution.units import NUMBER

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_DENSITIES = (0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 6.0)
# One per cent more misfit than that of the densest grid: far within the scatter of any data.
_SLACK = 1.01
# Larger weights make the data count for nothing.
_LARGEST_WEIGHT = 1e6
# A fit with a larger misfit gives a warning.
_POOR = 0.1
# Relaxation times reach beyond the data by this factor, as branches act half a decade away from their own times.
_BEYOND = math.sqrt(10.0)
# Relative misfit of numbers that differ by rounding alone.
_ROUNDING = 1e-9


class Columns:
    """Table whose first column has times or frequencies, and the others moduli."""

    _units: ClassVar[dict[str, str]]  # units of the columns by name
    source: str

    def __post_init__(self) -> None:
        """Set the columns as arrays in SI; refuse columns of different lengths."""
        columns = {name: np.atleast_1d(number(name, getattr(self, name), unit)) for name, unit in self._units.items()}
        if len({column.shape for column in columns.values()}) > 1 or next(iter(columns.values())).ndim != 1:
            shapes = ", ".join(f"{name} {column.shape}" for name, column in columns.items())
            raise InputError(", ".join(columns), rule=f"must be columns of one length: {shapes}", where=self.source)
        vars(self).update(columns)


@dataclass(frozen=True, eq=False)
class RelaxationTable(Columns):
    """Relaxation modulus measured over time.

    Attributes
    ----------
    time : array, shape (n,)
        Times t >= 0 [s], strictly ascending.
    modulus : array, shape (n,)
        Relaxation modulus > 0 [Pa].
    deformation : str, optional
        "tension" or "shear", None where the file does not state it.
    source : str
        Name of the file.
    notes : tuple of str
        Remarks of the reader: units that were assumed, columns that are not used.
    temperature : float, optional
        Temperature T [K], None where the file does not state it.

    Examples
    --------
    >>> RelaxationTable(np.array([0.1, 1.0]), np.array([3e6, 2e6]), "shear").modulus
    array([3000000., 2000000.])
    """

    time: Array
    modulus: Array
    deformation: Deformation | None = None
    source: str = ""
    notes: tuple[str, ...] = ()
    temperature: float | None = None
    _units: ClassVar[dict[str, str]] = {"time": "s", "modulus": "Pa"}


@dataclass(frozen=True, eq=False)
class DynamicTable(Columns):
    r"""Storage and loss modulus measured over frequency (DMA).

    Attributes
    ----------
    angular_frequency : array, shape (n,)
        $\omega > 0$ [rad/s], strictly ascending.
    storage_modulus, loss_modulus : array, shape (n,)
        Storage modulus > 0 and loss modulus >= 0 [Pa].
    deformation, source, notes, temperature
        As in `RelaxationTable`.

    Examples
    --------
    >>> DynamicTable(np.array([1.0, 10.0]), np.array([3e6, 4e6]), np.array([2e5, 3e5]), temperature=293.15).temperature
    293.15
    """

    angular_frequency: Array
    storage_modulus: Array
    loss_modulus: Array
    deformation: Deformation | None = None
    source: str = ""
    notes: tuple[str, ...] = ()
    temperature: float | None = None
    _units: ClassVar[dict[str, str]] = {"angular_frequency": "rad/s", "storage_modulus": "Pa", "loss_modulus": "Pa"}


@dataclass(frozen=True, eq=False)
class CreepTable(Columns):
    """Creep compliance measured over time: the strain under a constant stress, over this stress.

    Attributes
    ----------
    time : array, shape (n,)
        Times t >= 0 [s] since the load, strictly ascending.
    compliance : array, shape (n,)
        Creep compliance J > 0 [1/Pa].
    deformation, source, notes, temperature
        As in `RelaxationTable`.

    Examples
    --------
    >>> CreepTable(np.array([0.1, 1.0]), np.array([1e-6, 2e-6]), "shear").compliance
    array([1.e-06, 2.e-06])
    """

    time: Array
    compliance: Array
    deformation: Deformation | None = None
    source: str = ""
    notes: tuple[str, ...] = ()
    temperature: float | None = None
    _units: ClassVar[dict[str, str]] = {"time": "s", "compliance": "1/Pa"}


Measured = RelaxationTable | DynamicTable | CreepTable


def column_names(table: RelaxationTable | DynamicTable) -> list[str]:
    """Return the names of the columns, that of the times or frequencies first."""
    return list(table._units)  # pyright: ignore[reportPrivateUsage]


SHIFT_FACTOR = Quantity("shift_factor", NUMBER, "factor of all relaxation times", r"$a_T$", low=0.0, open=True)


@dataclass(frozen=True, eq=False)
class ScatteredMaterial:
    """A fitted material with the covariance of its numbers; `restitution.uncertainty` takes it as `material`.

    Attributes
    ----------
    coordinates, covariance : array, shapes (n,) and (n, n)
        Moduli [Pa] and, if it scatters, the logarithm of the factor of all relaxation times.
    free : tuple of Coordinate
        What they are: moduli scatter in SI, the factor by its logarithm.
    materials : callable
        Materials of shape (m, 1) from rows of coordinates, shape (m, n).
    """

    coordinates: Array
    covariance: Array
    free: tuple[Coordinate, ...]
    materials: Callable[[Array], Material] = field(repr=False)

    @property
    def parameters(self) -> dict[str, Coordinate]:
        """The terms by name."""
        return {term.name: term for term in self.free}

    # What an identification has in other objects.
    @property
    def problem(self) -> Self:
        """What makes the materials: the object itself."""
        return self

    @property
    def space(self) -> Self:
        """What has the terms: the object itself."""
        return self


@dataclass(frozen=True, eq=False)
class PronyFit:
    """Prony series fitted to data, and how well it does."""

    series: PronySeries  # in the deformation of the data
    misfit: float  # root mean square of the relative residuals [-]
    window: tuple[float, float]  # shortest and longest time [s] that the data cover; 1/omega for dynamic data
    residuals: NDArray[Any] = field(repr=False)  # (fit - data)/|data| [-], complex for dynamic data, shape (n,)
    data: Measured = field(repr=False)
    # Of the moduli of `names` [Pa^2], in the deformation of the data; None for compliances.
    covariance: Array | None = field(repr=False)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the moduli of the fit that are not zero, in the order of the covariance."""
        first = ("equilibrium_modulus",) if self.series.equilibrium_modulus > 0.0 else ()
        return (*first, *(f"branch_moduli[{k}]" for k in range(self.n_terms)))

    @property
    def n_terms(self) -> int:
        """Number of branches."""
        return self.series.n_branches

    def material(
        self,
        *,
        bulk_modulus: float | None = None,
        poisson_ratio: float | None = None,
        deformation: Deformation | None = None,
        density: float | None = None,
        name: str | None = None,
    ) -> Material:
        """Return the material of the fit, with the window of the data.

        Parameters
        ----------
        bulk_modulus, poisson_ratio : float
            Constant K [Pa], perhaps infinite, or constant nu [-], so that the bulk relaxes like the shear.
        deformation : str
            "tension" or "shear"; needed where the data do not state it.
        density, name
            Mass density [kg/m^3] and name of the material.

        Raises
        ------
        InputError
            If the deformation is missing or contradicts the data, or not exactly one of the two constants is given.

        Examples
        --------
        >>> t = np.geomspace(1e-3, 1e3, 61)
        >>> modulus = PronySeries(3e6, [9e6], [0.1]).relaxation_modulus(t)
        >>> fit_prony(RelaxationTable(t, modulus, "tension")).material(bulk_modulus=2e9).window
        (0.001, 1000.0)
        """
        stated = self.data.deformation
        shear, bulk = shear_and_bulk(self.series, bulk_modulus, poisson_ratio, stated, deformation)
        source = self.data.source or None
        terms = "Prony term" if self.n_terms == 1 else "Prony terms"
        assumptions = f"{self.n_terms} {terms} fitted to the data, relative misfit {self.misfit:.2g}"
        fitted = Material(shear, bulk, density=density, name=name, source=source, window=self.window)
        return replace(fitted, assumptions=assumptions, derivation="fit")

    def scattered(
        self,
        *,
        bulk_modulus: float | None = None,
        poisson_ratio: float | None = None,
        deformation: Deformation | None = None,
        log10_factor: float = 0.0,
        log10_factor_error: float = 0.0,
    ) -> ScatteredMaterial:
        """Return the material with the covariance of its moduli, for `restitution.uncertainty`.

        Parameters
        ----------
        bulk_modulus, poisson_ratio, deformation
            As in `material`.
        log10_factor, log10_factor_error : float
            Shift log10 aT from the temperature of the data to that of the impact [-], and its standard error, such as
            `MasterCurve.error_at`. All relaxation times take this factor.

        Notes
        -----
        The covariance is s^2 H^-1, with the normal equations H of the fit, which contain its smoothing, and the
        variance s^2 of the weighted residuals for the degrees of freedom that are left. It holds at the relaxation
        times of the fit, for independent scatter of the data. Errors that neighbouring data share, such as that of the
        sample's size, are not in it: they do not show in residuals. Nor is the choice of times and terms in it, so
        intervals of 95 % cover some 90 %.

        Examples
        --------
        >>> import restitution as rs
        >>> t = np.geomspace(1e-5, 1.0, 61)
        >>> scatter = 1.0 + 0.02 * np.random.default_rng(1).standard_normal(t.size)
        >>> modulus = PronySeries(1e6, [9e6], [1e-3]).relaxation_modulus(t) * scatter
        >>> fit = fit_prony(RelaxationTable(t, modulus, "shear"))
        >>> ball = rs.Impact(fit.material(bulk_modulus=2e9), rs.Parabola(0.01), mass=0.005, velocity=1.0)
        >>> e = rs.uncertainty(ball, {"material": fit.scattered(bulk_modulus=2e9)})["restitution_coefficient"]
        >>> print(f"{e.value:.2f} +- {e.standard_deviation:.3f}")
        0.73 +- 0.003
        """
        if self.covariance is None:
            rule = "must be moduli: the terms of a fit of compliances have no covariance"
            raise InputError("data", rule=rule, where=self.data.source)
        material = self.material(bulk_modulus=bulk_modulus, poisson_ratio=poisson_ratio, deformation=deformation)
        factor = 10.0 ** single("log10_factor", log10_factor)
        error = single_nonnegative("log10_factor_error", log10_factor_error)
        moduli = [self.series.equilibrium_modulus, *self.series.branch_moduli.tolist()][-len(self.names) :]
        modulus = Quantity("modulus", MODULUS, "modulus", "", low=0.0, open=True)
        terms = [Coordinate(name, modulus, "linear") for name in self.names]
        covariance, best = self.covariance, moduli
        if error > 0.0 and self.n_terms:
            terms.append(Coordinate("shift_factor", SHIFT_FACTOR, "log"))
            covariance = np.pad(covariance, (0, 1))
            covariance[-1, -1] = (math.log(10.0) * error) ** 2
            best = [*moduli, math.log(factor)]

        def materials(rows: Array) -> Material:
            columns = rows[:, None]
            branches = columns[..., len(self.names) - self.n_terms : len(self.names)]
            first = columns[..., 0] if len(self.names) > self.n_terms else np.zeros(columns.shape[:2])
            factors = np.exp(columns[..., len(self.names) :]) if len(terms) > len(self.names) else factor
            series = PronySeries(first, branches, self.series.relaxation_times * factors)
            parts = shear_and_bulk(series, bulk_modulus, poisson_ratio, self.data.deformation, deformation)
            return Material(*parts, name=material.name)

        return ScatteredMaterial(np.array(best), covariance, tuple(terms), materials)

    def plot(self) -> Figure:
        """Return a figure of the moduli over time and over frequency with the data."""
        return draw("material.overview", {self.data.deformation or "fit": self.series}, self.window, self.data)


def fit_prony(
    data: Measured,
    *,
    misfit: float = 2e-3,
    liquid: bool = False,
    loss_weight: float = 0.8,
    smoothing: float = 1e-3,
) -> PronyFit:
    """Return prony series with few terms that fits relaxation, dynamic or creep data.

    Non-negative least squares of the relative residuals with a penalty on jumps of the spectrum. The relaxation
    times are evenly spaced in log time; they reach half a decade beyond the data at both ends. The densest grid (6 a
    decade) gives the smallest misfit. The coarsest grid within one per cent of it, or below `misfit`, is chosen, and
    terms are dropped, the least important first, as long as the misfit allows.

    Parameters
    ----------
    data
        Measured moduli or compliances.
    misfit
        Relative misfit that is good enough [-]; for dynamic data of a small loss tangent, ten times that of it.
    liquid
        Whether to leave out the equilibrium modulus; for creep data, whether the material flows in the end.
    loss_weight
        Weight of the loss modulus against the storage modulus, below 1 as it scatters more; at most 1e6.
    smoothing
        Weight of the jumps of the spectrum (branch modulus per unit of log time) over the modulus at that time [-],
        at most 1e6.

    Returns
    -------
    PronyFit
        The series holds in the window of the data alone; `PronyFit.material` keeps that window.

    Raises
    ------
    InputError
        If there are fewer than four data or they cover less than half a decade.

    Warns
    -----
    RestitutionWarning
        Of kind "fit", if the misfit is above a tenth, or if the data do not relax: a series without terms.

    Notes
    -----
    Lawson and Hanson, *Solving Least Squares Problems* (1974), ch. 23. The misfit is ``|fit - data|/|data|``.

    Creep data are fitted by J(t) = J_0 + sum J_k (1 - exp(-t/lambda_k)) + t/eta. The Carson transforms of compliance
    and relaxation obey J R = 1 (Ferry, *Viscoelastic Properties of Polymers*, 3rd ed. (1980), ch. 3), which turns the
    fit into a Prony series exactly, by partial fractions.

    Examples
    --------
    >>> t = np.geomspace(1e-3, 1e3, 61)
    >>> fit = fit_prony(RelaxationTable(t, PronySeries(1.0, [2.0, 5.0], [0.1, 10.0]).relaxation_modulus(t)))
    >>> fit.misfit < 2e-3, fit.n_terms <= 8
    (True, True)
    """
    if not isinstance(data, Measured):
        rule = "must be a RelaxationTable, a DynamicTable or a CreepTable, as read_material returns"
        raise InputTypeError("data", data, rule)
    allowed = single_positive("misfit", misfit)
    weights = single_positive("loss_weight", loss_weight), single_nonnegative("smoothing", smoothing)
    for name, weight in zip(("loss_weight", "smoothing"), weights, strict=True):
        within(name, weight, 0.0, _LARGEST_WEIGHT)
    problem = _Problem(data, truth("liquid", liquid), *weights)
    *coarser, times = map(problem.grid, _DENSITIES)
    moduli = problem.solve(times)
    if problem.dynamic:  # a small loss must be fitted too
        allowed *= min(10.0 * float(np.median(problem.target.imag)), 1.0)
    allowed = max(allowed, _SLACK * problem.misfit(times, moduli))
    for grid in coarser:
        solution = problem.solve(grid)
        if problem.misfit(grid, solution) <= allowed:
            times, moduli = grid, solution
            break
    times, moduli = problem.reduced(times, moduli, allowed)
    series = problem.series(times, moduli).known_within(problem.window)
    residuals = problem.residuals(times, moduli)
    covariance = None if problem.creep else problem.covariance(times, moduli)
    fit = PronyFit(series, problem.misfit(times, moduli), problem.window, residuals, data, covariance)
    for doubtful, line in (
        (fit.series.is_elastic, "no relaxation is seen in the data; the fit is a constant"),
        (fit.misfit > _POOR, f"the relative misfit of the fit is {fit.misfit:.3g}, above {_POOR:g}"),
    ):
        if doubtful:
            warnings.warn(RestitutionWarning("fit", f"{data.source or 'data'}: {line}"), stacklevel=2)
    return fit


class _Problem:
    """Linear problem whose unknowns are the equilibrium modulus and the moduli at given times.

    For creep they are the glassy compliance, that of the flow at the last time, and compliances at given times.
    """

    def __init__(self, data: Measured, liquid: bool, loss_weight: float, smoothing: float) -> None:
        self.dynamic, self.creep, self.liquid = isinstance(data, DynamicTable), isinstance(data, CreepTable), liquid
        # Unknowns that belong to no time.
        self.heads = 2 if self.creep and liquid else 1
        self.loss_weight, self.smoothing = loss_weight, smoothing
        values: NDArray[Any]
        if isinstance(data, DynamicTable):
            what, unit = "frequencies", "rad/s"
            self.points, values = data.angular_frequency, data.storage_modulus + 1j * data.loss_modulus
        else:
            what, unit = "times", "s"
            self.points, values = data.time, data.compliance if isinstance(data, CreepTable) else data.modulus
        if not np.all(np.diff(self.points) > 0.0):
            raise InputError(what, rule="must be strictly ascending", where=data.source)
        if not np.all(np.isfinite(values) & (np.real(values) > 0.0)):
            name, si = ("compliance", "1/Pa") if self.creep else ("modulus", "Pa")
            raise InputError(name, rule=f"must be finite and > 0 {si} in each row", where=data.source)
        self.size = np.abs(values)
        self.target = values / self.size
        inside = self.points > 0
        points = self.points[inside]
        if self.points.size < 4 or points[-1] < points[0] * math.sqrt(10.0):
            rule = f"must be at least 4 {what} over half a decade or more"
            raise InputError(what, self.points.size, rule, where=data.source)
        low, high = float(points[0]), float(points[-1])
        if low < 1.0 / EXTREME or high > EXTREME:
            rule = f"must be in [{1.0 / EXTREME:g}, {EXTREME:g}] {unit}"
            raise InputError(what, low if high <= EXTREME else high, rule, unit, where=data.source)
        self.window = (1.0 / high, 1.0 / low) if self.dynamic else (low, high)
        # Magnitude of the modulus over the logarithm of time.
        logs, size = np.log(points), self.size[inside]
        self.level = (-logs[::-1], size[::-1]) if self.dynamic else (logs, size)

    def grid(self, density: float) -> Array:
        """Return relaxation times, so many a decade."""
        low, high = self.window[0] / _BEYOND, self.window[1] * _BEYOND
        return np.geomspace(low, high, max(math.ceil(density * math.log10(high / low)), 1) + 1)

    def columns(self, times: Array) -> NDArray[Any]:
        """Return relative share of a unit equilibrium modulus and of unit branches, shape (n, 1 + n_branch)."""
        if self.dynamic:
            x = 1j * self.points[:, None] * times
            branches = x / (1.0 + x)
        elif self.creep:
            branches = -np.expm1(-self.points[:, None] / times)
        else:
            branches = np.exp(-self.points[:, None] / times)
        heads = np.full((self.points.size, self.heads), 0.0 if self.liquid and not self.creep else 1.0)
        heads[:, 1:] = self.points[:, None] / self.points[-1]
        return np.hstack((heads, branches)) / self.size[:, None]

    def series(self, times: Array, moduli: Array) -> PronySeries:
        """Return the relaxation function of a solution."""
        if not self.creep:
            return PronySeries(float(moduli[0]), moduli[1:], times)
        # With p J(p) = fluidity + J_0 p + sum J_k p/(1 + p lambda_k), itself the transform of a Prony series, the
        # partial fractions of its inverse are those of the relaxation R(p) = p/(p J(p)).
        unit = float(np.median(self.size))
        glass, flow, compliances = np.split(moduli / unit, (1, self.heads))
        fluidity = float(flow.sum()) / float(self.points[-1])
        # Rounding is no spring in series with a dashpot.
        spring = float(glass[0]) if glass[0] * unit > _ROUNDING * self.size.min() else 0.0
        dual = PronySeries(fluidity, compliances / times, times, parallel_viscosity=spring)
        dashpot, equilibrium, branches, taus = dual.retardation
        viscosity = float(dashpot) / unit
        return PronySeries(float(equilibrium) / unit, branches / taus / unit, taus, parallel_viscosity=viscosity)

    def _weighted(self, times: Array) -> tuple[Any, Any, int]:
        """Return the matrix and the target of the least squares, and how many of their rows are of data."""
        matrix: Any = self.columns(times)
        target: Any = self.target
        if self.dynamic:
            matrix = np.vstack((matrix.real, self.loss_weight * matrix.imag))
            target = np.concatenate((target.real, self.loss_weight * target.imag))
        count = target.size
        if self.smoothing > 0 and times.size > 1:
            logs = np.log(times)
            spectrum = np.diag(1.0 / np.gradient(logs))
            jumps = (spectrum[1:] - spectrum[:-1]) / np.interp(logs, *self.level)[1:, None]
            jumps *= self.smoothing * math.sqrt(target.size / times.size)
            matrix = np.vstack((matrix, np.hstack((np.zeros((times.size - 1, self.heads)), jumps))))
            target = np.concatenate((target, np.zeros(times.size - 1)))
        return matrix, target, count

    def solve(self, times: Array) -> Array:
        """Return non-negative moduli of least weighted relative residuals, the equilibrium modulus first."""
        from scipy.optimize import nnls

        matrix, target, _ = self._weighted(times)
        # Powers of two keep the squares of extreme numbers finite, and all digits.
        _, power = np.frexp(np.abs(matrix).max(axis=0))
        scale = np.ldexp(np.sqrt((np.ldexp(matrix, -power) ** 2).sum(axis=0)), power)
        scale[scale == 0] = 1.0
        solution, _ = nnls(matrix / scale, target, maxiter=100 * scale.size)
        return solution / scale

    def covariance(self, times: Array, moduli: Array) -> Array:
        """Return the covariance of the moduli that are not zero, those at zero being held there."""
        matrix, target, count = self._weighted(times)
        there = moduli > 0.0
        # Relative changes of the moduli, which are of very different size.
        scaled = matrix[:, there] * moduli[there]
        inverse = np.linalg.pinv(np.linalg.qr(scaled, mode="r"))
        used = float(np.sum((scaled[:count] @ inverse) ** 2))
        residuals = matrix[:count] @ moduli - target[:count]
        variance = float(residuals @ residuals) / max(count - used, 0.1 * count)
        return variance * (inverse @ inverse.T) * moduli[there] * moduli[there][:, None]

    def residuals(self, times: Array, moduli: Array) -> NDArray[Any]:
        """Return relative residuals."""
        return self.columns(times) @ moduli - self.target

    def misfit(self, times: Array, moduli: Array) -> float:
        """Return root mean square of the relative residuals."""
        return float(np.sqrt(np.mean(np.abs(self.residuals(times, moduli)) ** 2)))

    def reduced(self, times: Array, moduli: Array, allowed: float) -> tuple[Array, Array]:
        """Return times and moduli with as few terms as the misfit allows."""
        heads = self.heads
        keep = moduli[heads:] > 0
        times, moduli = times[keep], np.concatenate((moduli[:heads], moduli[heads:][keep]))
        while times.size > 1:
            # The term with the smallest influence anywhere is tried first.
            influence = np.abs(self.columns(times)[:, heads:] * moduli[heads:]).max(axis=0)
            fewer = np.delete(times, int(np.argmin(influence)))
            solution = self.solve(fewer)
            if self.misfit(fewer, solution) > allowed:
                break
            keep = solution[heads:] > 0
            times, moduli = fewer[keep], np.concatenate((solution[:heads], solution[heads:][keep]))
        none = times[:0]
        constant = self.solve(none)
        # Two more parameters lower the sum of squares of pure noise by the share 2/n on average. Dynamic data show
        # even a small relaxation in their loss modulus.
        slack = 1.0 if self.dynamic else math.sqrt(1.0 + 20.0 / self.points.size)
        if self.misfit(none, constant) <= slack * self.misfit(times, moduli) + _ROUNDING:
            return none, constant
        return times, moduli
