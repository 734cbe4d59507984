"""Moduli measured at several temperatures, and their master curve by time-temperature superposition."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeVar, get_args

import numpy as np
from numpy.typing import NDArray

from restitution.checks import Array, items
from restitution.errors import InputError, InputTypeError, RestitutionWarning
from restitution.material.conversion import Deformation
from restitution.material.fit import DynamicTable, RelaxationTable, column_names
from restitution.material.shift import GAS_CONSTANT, WLF, Arrhenius, ShiftTable
from restitution.numerics.least_squares import descend
from restitution.quantities import check_single
from restitution.result import draw
from restitution.units import ZERO_CELSIUS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Curve = DynamicTable | RelaxationTable
_C = TypeVar("_C", bound=DynamicTable | RelaxationTable)
# Shifts of the isotherms and their derivatives, shapes (m,) and (m, p), from the parameters of a law.
Law = Callable[[Array], tuple[Array, Array]]
ShiftLaw = Literal["free", "wlf", "arrhenius"]

# Frequencies or times that differ by less are the same one.
_SAME = 1e-6
# A larger misfit gives a warning, and so does a larger error of a shift [decades].
_POOR = 0.05
_UNCERTAIN = 0.3
# Vertical shifts [decades] are of this order at the reference, and farther off that of twice a density times T.
_LIFT = 0.01
# Starts that differ by less [decades] lead to the same shifts.
_ALIKE = 0.3
# Largest gap [decades] between isotherms over which the shift is determined.
_BRIDGE = 0.25
# The master curve is a cubic spline in log-log axes with this spacing of its knots [decades].
_SPACING = 0.25
# Its curvature [1/decade] is of this order: 2.3 at the peak of the loss modulus of a single relaxation time.
_CURVATURE = 2.0
# Scatter [decades] that is assumed at first, and the smallest one: no data are more precise.
_SCATTER, _LEAST_SCATTER = 0.01, 1e-5
# Misfit [decades] below which two isotherms fit each other at first.
_RESOLVED = 0.003
_ROUNDS = 4
# Descents: most steps, the share of its sum of squares that the next step of a finished one would gain, and the least
# distance of a start from its bounds.
_STEPS, _ENOUGH, _MARGIN = 100, 1e-10, 1e-9
# Larger shifts [decades] have no meaning.
_FARTHEST = 300.0
_BEND = _SPACING**2 * _CURVATURE


class Channel(NamedTuple):
    """Logarithms of one modulus at all temperatures."""

    abscissa: Array  # log10 of the frequency, or of the reciprocal time, shape (n,)
    ordinate: Array  # log10 of the modulus, shape (n,)
    isotherm: NDArray[np.intp]  # number of the isotherm of each datum, shape (n,)


class Superposition(NamedTuple):
    """Shifts [decades] with their covariance, and the scatter about the master curve."""

    parameters: Array  # of the law of the shift, shape (p,)
    covariance: Array  # of the parameters, infinite where the data do not determine them, shape (p, p)
    shifts: Array  # log10 aT of each isotherm, shape (m,)
    vertical: Array  # log10 of the factor by which each isotherm lies above the master curve, shape (m,)
    vertical_errors: Array  # standard errors of these, shape (m,)
    scatter: tuple[float, ...]  # standard deviation [decades] of the data of each channel
    misfit: float  # root mean square of the relative residuals [-]


def superpose(
    channels: list[Channel],
    law: Law,
    start: Array,
    low: Array,
    high: Array,
    lifts: Array,
) -> Superposition:
    """Return the shifts of least squares; vertical shifts [decades] of the isotherms are of the order of `lifts`.

    The coefficients of the spline are projected out (Golub and Pereyra), with the Jacobian of Kaufman, whose
    gradient is exact. The scatter of each channel is the residual one for its degrees of freedom.
    """
    free = np.flatnonzero(lifts > 0.0)
    point = np.append(start, np.zeros(free.size))
    limits = [np.append(end, np.full(free.size, most)) for end, most in ((low, -np.inf), (high, np.inf))]
    problem = _Problem(channels, law, start.size, lifts, free)
    scatter = np.full(len(channels), _SCATTER)
    # A modulus that does not superpose well must not drive the isotherms apart.
    problem.prepare(point, scatter)
    scatter = problem.scatter_of(point)
    for _ in range(_ROUNDS):
        problem.prepare(point, scatter)
        point, before = problem.minimum(point, *limits), scatter
        scatter = problem.scatter_of(point)
        if np.allclose(scatter, before, rtol=1e-2):
            break
    problem.prepare(point, scatter)
    covariance = _covariance(problem.slopes(point))
    vertical, errors, n = np.zeros(lifts.size), np.zeros(lifts.size), start.size
    vertical[free], errors[free] = point[n:], np.sqrt(np.diag(covariance)[n:])
    return Superposition(
        point[:n], covariance[:n, :n], law(point[:n])[0], vertical, errors, tuple(scatter.tolist()),
        problem.misfit(point),
    )  # fmt: skip


def _covariance(slopes: Array) -> Array:
    """Return the covariance of the parameters, infinite where their directions leave the residuals unchanged."""
    curvature = slopes @ slopes.T
    scale = np.sqrt(np.maximum(np.diag(curvature), 1e-300))
    sizes, vectors = np.linalg.eigh(curvature / np.outer(scale, scale))
    dead = sizes <= 1e-10
    covariance = (vectors[:, ~dead] / sizes[~dead]) @ vectors[:, ~dead].T / np.outer(scale, scale)
    undetermined = (np.abs(vectors[:, dead]) > 1e-3).any(axis=1)
    covariance[undetermined, undetermined] = np.inf
    return covariance


class _Spline(NamedTuple):
    """Spline of one channel at given shifts, fitted to its data."""

    basis: Any  # values of the B-splines at the data over the scatter, sparse, shape (n, size)
    factor: Array  # Cholesky factor of the normal equations, in bands
    rise: Array  # slope of the curve at the data, shape (n,)
    residuals: Array  # of the data, over their scatter, shape (n,)
    bends: Array  # curvatures over their order, shape (size - 2,)

    def solve(self, right: Array) -> Array:
        """Return coefficients of the normal equations."""
        from scipy.linalg import cho_solve_banded

        return cho_solve_banded((self.factor, True), right)


class _Problem:
    """Sum of squares of the channels about their splines over the parameters."""

    def __init__(self, channels: list[Channel], law: Law, n_law: int, lifts: Array, free: NDArray[np.intp]) -> None:
        self.channels, self.law, self.n_law, self.lifts, self.free = channels, law, n_law, lifts, free
        self.origin, self.size, self.scatter = 0.0, 4, np.ones(len(channels))

    def prepare(self, point: Array, scatter: Array) -> None:
        """Place the knots around the shifted data, and set the scatter of the channels."""
        self.scatter = scatter
        shifts = self.law(point[: self.n_law])[0]
        ends = np.concatenate([channel.abscissa + shifts[channel.isotherm] for channel in self.channels])
        self.origin, span = float(ends.min()) - 1.0, float(np.ptp(ends))
        if span > _FARTHEST:
            raise InputError("tables", rule=f"must overlap: their shifts span {span:.0f} decades")
        self.size = int((span + 2.0) / _SPACING) + 4

    def minimum(self, point: Array, low: Array, high: Array) -> Array:
        """Return parameters of the least sum of squares within bounds."""
        inside = np.clip(point, low + _MARGIN, high - _MARGIN)
        furthest = np.full((1, point.size), np.inf)
        return descend(
            lambda points, _: self.residuals(points[0, 0])[None, None], inside[None], low[None], high[None],
            lambda points, _: self.slopes(points[0])[None], furthest, _ENOUGH, _STEPS,
        ).points[0]  # fmt: skip

    def residuals(self, point: Array) -> Array:
        """Return the residuals of the data, the bends of the splines, and the vertical shifts over their order."""
        if np.ptp(self.law(point[: self.n_law])[0]) > _FARTHEST:
            return np.full(1, np.inf)
        splines = self._splines(point)
        parts = [part for spline in splines for part in (spline.residuals, spline.bends)]
        return np.concatenate([*parts, point[self.n_law :] / self.lifts[self.free]])

    def slopes(self, point: Array) -> Array:
        """Return derivatives of the residuals, shape (p, n), by the formula of Kaufman."""
        changes = [self._changes(point, place, spline) for place, spline in enumerate(self._splines(point))]
        priors = np.vstack((np.zeros((self.n_law, self.free.size)), np.diag(1.0 / self.lifts[self.free])))
        return np.hstack([*(part.T for pair in changes for part in pair), priors])

    def _splines(self, point: Array) -> list[_Spline]:
        return [self._spline(point, place) for place in range(len(self.channels))]

    def _spline(self, point: Array, place: int) -> _Spline:
        from scipy.linalg import cholesky_banded
        from scipy.sparse import csr_array

        channel, scatter = self.channels[place], self.scatter[place]
        shifts, vertical = self.law(point[: self.n_law])[0], np.zeros(self.lifts.size)
        vertical[self.free] = point[self.n_law :]
        steps = (channel.abscissa + shifts[channel.isotherm] - self.origin) / _SPACING
        steps = np.clip(steps, 0.0, self.size - 3 - 1e-9)
        first = steps.astype(np.intp)
        f = (steps - first)[:, None]
        values = np.hstack(((1 - f) ** 3, 4 - 6 * f**2 + 3 * f**3, 1 + 3 * f + 3 * f**2 - 3 * f**3, f**3)) / 6
        slopes = np.hstack((-((1 - f) ** 2), 3 * f**2 - 4 * f, 1 + 2 * f - 3 * f**2, f**2)) / (2 * _SPACING)
        columns = first[:, None] + np.arange(4)
        shape, starts = (steps.size, self.size), np.arange(0, 4 * steps.size + 1, 4)
        basis: Any = csr_array((values.ravel() / scatter, columns.ravel(), starts), shape=shape)
        gram = basis.T @ basis
        bands = np.array([np.pad(gram.diagonal(-k), (0, k)) for k in range(4)])
        for i, weights in enumerate(((1.0, -2.0, 1.0), (-2.0, 1.0), (1.0,))):
            for k, weight in enumerate(weights):
                bands[k, i : self.size - 2 + i] += (1.0, -2.0, 1.0)[i] * weight / _BEND**2
        target = (channel.ordinate - vertical[channel.isotherm]) / scatter
        spline = _Spline(basis, cholesky_banded(bands, lower=True), f[:, 0], target, target)
        coefficients = spline.solve(basis.T @ target)
        return spline._replace(
            rise=(slopes * coefficients[columns]).sum(axis=1),
            residuals=target - basis @ coefficients,
            bends=np.diff(coefficients, 2) / _BEND,
        )

    def _changes(self, point: Array, place: int, spline: _Spline) -> tuple[Array, Array]:
        """Return derivatives of the residuals and of the bends, the coefficients being those of the projection."""
        channel = self.channels[place]
        slopes = self.law(point[: self.n_law])[1][channel.isotherm]
        lifted = channel.isotherm[:, None] == self.free
        changes = -np.hstack((spline.rise[:, None] * slopes, lifted)) / self.scatter[place]
        coefficients = spline.solve(spline.basis.T @ changes)
        return changes - spline.basis @ coefficients, np.diff(coefficients, 2, axis=0) / _BEND

    def scatter_of(self, point: Array) -> Array:
        """Return scatter of each channel [decades] from its residuals and the degrees of freedom that are left."""
        covariance = _covariance(self.slopes(point))
        covariance[~np.isfinite(covariance)] = 0.0
        deviations = np.empty(len(self.channels))
        for place, scatter in enumerate(self.scatter.tolist()):
            spline = self._spline(point, place)
            changes = self._changes(point, place, spline)[0]
            n = spline.residuals.size
            used = float(np.trace(spline.solve((spline.basis.T @ spline.basis).toarray())))
            used += float(np.sum((changes @ covariance) * changes))
            squares = float(spline.residuals @ spline.residuals) * scatter**2
            deviations[place] = np.sqrt(squares / max(n - used, 0.1 * n))
        return np.maximum(deviations, _LEAST_SCATTER)

    def misfit(self, point: Array) -> float:
        """Return root mean square of the relative residuals of all data."""
        decades = [self._spline(point, place).residuals * size for place, size in enumerate(self.scatter.tolist())]
        return float(np.sqrt(np.mean(np.expm1(np.concatenate(decades) * np.log(10.0)) ** 2)))


def first_shifts(channels: list[Channel]) -> Array:
    """Return estimates of the shifts, of each isotherm over the one before, from the best overlap of the two."""
    count = int(max(channel.isotherm.max() for channel in channels)) + 1
    curves = [[_sorted(channel, channel.isotherm == i) for channel in channels] for i in range(count)]
    steps = [_step(cold, warm) for cold, warm in pairwise(curves)]
    return np.concatenate(((0.0,), np.cumsum(steps)))


def _sorted(channel: Channel, which: NDArray[np.bool_]) -> tuple[Array, Array]:
    order = np.argsort(channel.abscissa[which])
    return channel.abscissa[which][order], channel.ordinate[which][order]


def _step(cold: list[tuple[Array, Array]], warm: list[tuple[Array, Array]]) -> float:
    """Return the shift [decades] of an isotherm over the next colder one."""
    (low, high), (first, last) = ((x.min(), x.max()) for x in (cold[0][0], warm[0][0]))
    least = 0.2 * min(high - low, last - first)
    trials = np.arange(low - last + least, min(high - first, 0.5 + low - first) - least + 1e-9, 0.05)
    best, chosen = np.inf, 0.0
    for trial in trials.tolist():
        places = np.linspace(max(low, first + trial), min(high, last + trial), 12)
        gaps = [np.interp(places, *x) - np.interp(places - trial, *y)
                for x, y in zip(cold, warm, strict=True) if x[0].size > 1 and y[0].size > 1]  # fmt: skip
        # The likelihood for an unknown scatter of each modulus; of shifts that fit alike, the smallest.
        misfit = sum(float(np.log(np.mean(gap**2) + _RESOLVED**2)) for gap in gaps) + 1e-4 * abs(trial)
        if misfit < best:
            best, chosen = misfit, trial
    return chosen


def law_of(
    shift: ShiftLaw, kelvin: Array, reference: float, nearest: int, start: Array
) -> tuple[Law, Array, Array, Array]:
    """Return the law of the shift, first parameters, and their bounds.

    The parameters of WLF are those of `_span` times C1/C2 and 1/C2, which are less correlated than C1 and C2; that of
    Arrhenius is the shift in decades between the coldest and the warmest isotherm.
    """
    span = _span(shift, kelvin)
    rise = (kelvin - reference) / span
    if shift == "free":
        others = np.delete(np.arange(kelvin.size), nearest)
        slopes = np.eye(kelvin.size)[:, others]
        first = (start - start[nearest])[others]
        return lambda p: (slopes @ p, slopes), first, np.full(first.size, -np.inf), np.full(first.size, np.inf)
    if shift == "arrhenius":
        slope = (1.0 / kelvin - 1.0 / reference)[:, None] / span
        first = np.array([max(float(start @ slope[:, 0]) / float(slope[:, 0] @ slope[:, 0]), 1e-3)])
        return lambda p: (slope @ p, slope), first, np.zeros(1), np.full(1, np.inf)

    def wlf(p: Array) -> tuple[Array, Array]:
        below = 1.0 + p[1] * rise
        return -p[0] * rise / below, np.stack((-rise / below, p[0] * (rise / below) ** 2), axis=1)

    # The Vogel temperature must be below the lowest one measured.
    limit = 0.98 * span / max(reference - float(kelvin[0]), 1.0)
    trials = np.linspace(0.0, 0.95, 40)[1:] * min(limit, 0.1 * span)
    best, first = np.inf, np.array([0.05 * span, trials[0]])
    for trial in trials.tolist():
        shape = -rise / (1.0 + trial * rise)
        size = max(float(start @ shape) / float(shape @ shape), 1e-6 * span)
        squares = float(np.sum((start - size * shape) ** 2))
        if squares < best:
            best, first = squares, np.array([size, trial])
    return wlf, first, np.array([0.0, 1e-6 * span]), np.array([np.inf, limit])


def _span(shift: ShiftLaw, kelvin: Array) -> float:
    """Return the range of the temperatures [K], or of their reciprocals [1/K], that makes parameters of order one."""
    cold, warm = float(kelvin[0]), float(kelvin[-1])
    return 1.0 / cold - 1.0 / warm if shift == "arrhenius" else warm - cold


def constants_of(
    shift: ShiftLaw, superposition: Superposition, kelvin: Array
) -> tuple[dict[str, float], dict[str, float]]:
    """Return constants of a law, and their standard errors."""
    span = _span(shift, kelvin)
    p, covariance = superposition.parameters / span, superposition.covariance / span**2
    if shift == "free":
        return {}, {}
    if shift == "arrhenius":
        factor = GAS_CONSTANT * math.log(10.0)
        return {"activation_energy": float(p[0]) * factor}, {"activation_energy": math.sqrt(covariance[0, 0]) * factor}
    c1, c2 = float(p[0] / p[1]), float(1.0 / p[1])
    slopes = np.array([[1.0 / p[1], -p[0] / p[1] ** 2], [0.0, -1.0 / p[1] ** 2]])
    errors = np.sqrt(np.diag(slopes @ covariance @ slopes.T)) if np.isfinite(covariance).all() else np.full(2, np.inf)
    return {"c1": c1, "c2": c2}, {"c1": float(errors[0]), "c2": float(errors[1])}


def average(curves: Sequence[_C]) -> _C:
    """Return the curve of all data of some curves, in ascending order; data at one frequency or time are averaged."""
    first = curves[0]
    columns = {name: np.concatenate([getattr(curve, name) for curve in curves]) for name in column_names(first)}
    x = next(iter(columns.values()))
    order = np.argsort(x, kind="stable")
    x = x[order]
    starts = np.flatnonzero(np.concatenate(((True,), np.diff(x) > _SAME * x[1:])))
    counts = np.diff(np.append(starts, x.size))
    means: dict[str, Any] = {name: np.add.reduceat(part[order], starts) / counts for name, part in columns.items()}
    if first.temperature is not None:
        means["temperature"] = float(np.mean([curve.temperature or 0.0 for curve in curves]))
    return replace(first, **means)


@dataclass(frozen=True, eq=False, init=False)
class Isotherms:
    """Moduli over frequency or over time, measured at several temperatures.

    Parameters
    ----------
    tables
        A `DynamicTable` or a `RelaxationTable` with its temperature for each isotherm, at least two; all of one kind
        and in one deformation, at different temperatures.
    source, notes
        Name of the file, and remarks of its reader.

    Raises
    ------
    InputError
        If a temperature is missing or repeated, or the tables are of several kinds.

    Examples
    --------
    >>> omega = np.geomspace(0.1, 100.0, 13)
    >>> shifts = {290.0: 1.2, 300.0: 0.0, 310.0: -0.9}
    >>> tables = [
    ...     DynamicTable(omega, (omega * 10**s) ** 0.4, 0.7 * (omega * 10**s) ** 0.4, temperature=kelvin)
    ...     for kelvin, s in shifts.items()
    ... ]
    >>> curve = Isotherms(tables).superposed(reference_temperature=300.0)
    >>> print(curve.log10_factors.round(3))
    [ 1.2  0.  -0.9]
    """

    tables: tuple[Curve, ...]
    source: str
    notes: tuple[str, ...]

    def __init__(self, tables: Sequence[Curve], *, source: str = "", notes: Sequence[str] = ()) -> None:
        rule = "must be several DynamicTable or several RelaxationTable"
        tables = items("tables", tables, rule)
        kinds = {type(table) for table in tables}
        if len(kinds) != 1 or not kinds <= {DynamicTable, RelaxationTable} or len(tables) < 2:
            raise InputTypeError("tables", tables, rule)
        deformations = {table.deformation for table in tables}
        if len(deformations) > 1:
            rule = "must be in one deformation, tension or shear, for all tables"
            raise InputError("deformation", ", ".join(map(str, deformations)), rule, where=source)
        for place, table in enumerate(tables):
            _ = check_single("temperature", table.temperature, f"tables[{place}].temperature")
        ordered = tuple(sorted(tables, key=lambda table: table.temperature or 0.0))
        for colder, warmer in pairwise(ordered):
            if colder.temperature == warmer.temperature:
                raise InputError(
                    "temperature", colder.temperature, "must differ from table to table", "K", where=source
                )
        self.__dict__.update(tables=ordered, source=source, notes=tuple(items("notes", notes, "must be texts")))

    @property
    def temperatures(self) -> Array:
        """Temperatures [K], ascending, shape (m,)."""
        return np.array([table.temperature for table in self.tables], dtype=np.float64)

    @property
    def deformation(self) -> Deformation | None:
        """Deformation of the data, None where the file does not state it."""
        return self.tables[0].deformation

    def superposed(
        self, *, reference_temperature: Any = None, shift: ShiftLaw = "free", vertical: bool = False
    ) -> MasterCurve:
        r"""Return master curve of all isotherms, by time-temperature superposition.

        The logarithm of each modulus over that of the reduced frequency $\omega a_T$, or of the reduced time
        $t/a_T$, is a cubic spline. The shifts $\log_{10} a_T$ are those of the least sum of squares of the residuals.

        Parameters
        ----------
        reference_temperature : float
            Temperature T0 [K] of the master curve, within the measured ones; the middle one by default.
        shift : str
            "free": a shift for each isotherm. "wlf", "arrhenius": the constants of `WLF` or `Arrhenius`.
        vertical : bool
            Whether each isotherm has a factor of the modulus as well, of the order of (T/T0)^2.

        Returns
        -------
        MasterCurve
            The data at the reference temperature, for `fit_prony`, and the shift, for `Material`.

        Raises
        ------
        InputError
            If the reference temperature is outside the measured ones, or there are too few data.

        Warns
        -----
        RestitutionWarning
            Of kind "superposition": isotherms do not overlap, a shift rises or is uncertain, or the misfit is above
            0.05, as for a material that is not thermorheologically simple.

        Notes
        -----
        Ferry, *Viscoelastic Properties of Polymers*, 3rd ed. (1980), ch. 11. The standard errors hold for independent
        scatter of the data about one curve. Storage and loss modulus have separate scatter.
        """
        if shift not in get_args(ShiftLaw):
            raise InputError("shift", shift, f"must be one of {', '.join(get_args(ShiftLaw))}")
        kelvin = self.temperatures
        reference = float(kelvin[kelvin.size // 2])
        if reference_temperature is not None:
            reference = check_single("temperature", reference_temperature, "reference_temperature")
        if not kelvin[0] <= reference <= kelvin[-1]:
            rule = f"must be in [{kelvin[0]:.6g}, {kelvin[-1]:.6g}] K, the measured temperatures"
            raise InputError("reference_temperature", reference, rule, "K", where=self.source)
        channels = self._channels()
        nearest = int(np.argmin(np.abs(kelvin - reference)))
        lifts = vertical * (_LIFT + 2.0 * np.abs(np.log10(kelvin / reference)))
        lifts[nearest] = 0.0
        # Where the loss modulus does not superpose, the storage modulus alone gives the better start.
        starts = [first_shifts(channels), first_shifts(channels[:1])]
        candidates: list[tuple[Superposition, Law]] = []
        for start in starts if np.ptp(starts[1] - starts[0]) > _ALIKE else starts[:1]:
            start -= np.interp(reference, kelvin, start)
            law, first, low, high = law_of(shift, kelvin, reference, nearest, start)
            candidates.append((superpose(channels, law, first, low, high, lifts), law))

        def doubt(candidate: tuple[Superposition, Law]) -> tuple[int, float]:
            curve, sizes = candidate[0], [channel.ordinate.size for channel in channels]
            return int((_gaps(self.tables, curve.shifts) > 0.0).sum()), float(np.log(curve.scatter) @ sizes)

        return self._master_curve(*min(candidates, key=doubt), shift, reference, nearest)

    def _channels(self) -> list[Channel]:
        numbers = np.repeat(np.arange(len(self.tables)), [_abscissa(table).size for table in self.tables])
        x = np.concatenate([_abscissa(table) for table in self.tables])
        channels: list[Channel] = []
        for name in column_names(self.tables[0])[1:]:
            values = np.concatenate([getattr(table, name) for table in self.tables])
            # A loss of zero and the time zero have no logarithm.
            there = (values > 0.0) & np.isfinite(x)
            if there.sum() > 3:
                channels.append(Channel(x[there], np.log10(values[there]), numbers[there]))
        counts = np.bincount(channels[0].isotherm, minlength=len(self.tables)) if channels else np.zeros(1)
        if counts.min() < 2:
            rule = "must have at least two frequencies or times > 0"
            raise InputError(f"tables[{int(np.argmin(counts))}]", rule=rule, where=self.source)
        return channels

    def _master_curve(
        self, superposition: Superposition, law: Law, shift: ShiftLaw, reference: float, nearest: int
    ) -> MasterCurve:
        kelvin = self.temperatures
        _, slopes = law(superposition.parameters)
        shifts = superposition.shifts
        if shift == "free":
            # The shift is linear between temperatures, as in `ShiftTable`, and zero at the reference.
            at_reference = np.array([np.interp(reference, kelvin, column) for column in np.eye(kelvin.size)])
            shifts = shifts - at_reference @ shifts
            slopes = slopes - at_reference @ slopes
        covariance = superposition.covariance
        lost = np.isinf(np.diag(covariance))
        of_factors = slopes[:, ~lost] @ covariance[np.ix_(~lost, ~lost)] @ slopes[:, ~lost].T
        errors = np.sqrt(np.maximum(np.diag(of_factors), 0.0))
        errors[np.any(np.abs(slopes[:, lost]) > 0.0, axis=1)] = np.inf
        if shift == "free":
            # The smoothness of the master curve bridges small gaps alone.
            for place in np.flatnonzero(_gaps(self.tables, shifts) > _BRIDGE).tolist():
                errors[place:] = np.inf if place > nearest else errors[place:]
                errors[:place] = np.inf if place <= nearest else errors[:place]
        unknown = np.isinf(errors)
        of_factors[unknown], of_factors[:, unknown] = 0.0, 0.0
        of_factors[unknown, unknown] = np.inf
        named, errors_of = constants_of(shift, superposition, kelvin)
        factors = 10.0 ** (-superposition.vertical)
        reduced = zip(self.tables, shifts, factors, strict=True)
        tables = tuple(_reduced(table, s, b, reference) for table, s, b in reduced)
        curve = MasterCurve(
            replace(average(tables), source=self.source, notes=()), tables, self, reference, shift, shifts, errors,
            -superposition.vertical, superposition.vertical_errors, named, errors_of, superposition.misfit, of_factors,
        )  # fmt: skip
        for line in curve.doubts:
            warnings.warn(RestitutionWarning("superposition", f"{self.source or 'isotherms'}: {line}"), stacklevel=3)
        return curve

    def plot(self) -> Figure:
        """Return a figure of the isotherms."""
        return draw("material.isotherms", self)


@dataclass(frozen=True, eq=False)
class MasterCurve:
    """Moduli at one temperature that stand for those at all, and the shifts that lead there.

    Attributes
    ----------
    data : DynamicTable or RelaxationTable
        Moduli over the reduced frequency or time at the reference temperature, for `fit_prony`.
    reduced : tuple
        The data of each isotherm alone, over the reduced frequency or time.
    isotherms : Isotherms
        The measured data.
    reference_temperature : float
        T0 [K].
    law : str
        "free", "wlf" or "arrhenius".
    log10_factors, errors : array, shape (m,)
        log10 aT of each isotherm [-], and its standard error [-]; infinite where the data do not determine it.
    log10_vertical_factors, vertical_errors : array, shape (m,)
        log10 of the factor of the moduli of each isotherm [-], and its standard error [-]; zero without such a shift.
    constants, constant_errors : dict
        Constants of the law, `c1` [-] and `c2` [K] or `activation_energy` [J/mol], and their standard errors.
    misfit : float
        Root mean square of the relative residuals about the smooth master curve [-].
    covariance : array, shape (m, m)
        Covariance of `log10_factors` [-]; infinite variances, without correlations, where `errors` are infinite.
    """

    data: Curve
    reduced: tuple[Curve, ...]
    isotherms: Isotherms
    reference_temperature: float
    law: ShiftLaw
    log10_factors: Array
    errors: Array
    log10_vertical_factors: Array
    vertical_errors: Array
    constants: dict[str, float]
    constant_errors: dict[str, float]
    misfit: float
    covariance: Array

    @property
    def temperatures(self) -> Array:
        """Temperatures of the isotherms [K], ascending, shape (m,)."""
        return self.isotherms.temperatures

    @property
    def shift(self) -> ShiftTable | WLF | Arrhenius:
        """Law of the shift within the measured temperatures, for `Material`.

        Raises
        ------
        InputError
            If free shifts do not fall with the temperature.
        """
        kelvin = self.temperatures
        if self.law == "free":
            if self._rise:
                rule = f'{self._rise}: must fall with the temperature; use shift="wlf", or fewer isotherms'
                raise InputError("log10_factors", rule=rule, where=self.isotherms.source)
            return ShiftTable(kelvin, self.log10_factors)
        law = WLF if self.law == "wlf" else Arrhenius
        limits = float(kelvin[0]), float(kelvin[-1])
        return law(self.reference_temperature, **self.constants, temperature_range=limits)

    def error_at(self, temperature: float) -> float:
        """Return the standard error of log10 aT [-] at a temperature T [K], for `PronyFit.scattered`.

        The shift is linear between two isotherms here; the error is infinite if that of one of them is.

        Raises
        ------
        InputError
            If the temperature is not within the measured ones.
        """
        kelvin, at = self.temperatures, check_single("temperature", temperature)
        if not kelvin[0] <= at <= kelvin[-1]:
            rule = f"must be in [{kelvin[0]:.6g}, {kelvin[-1]:.6g}] K, the measured temperatures"
            raise InputError("temperature", at, rule, "K", where=self.isotherms.source)
        weights = np.array([np.interp(at, kelvin, column) for column in np.eye(kelvin.size)])
        there = weights > 0.0
        return math.sqrt(weights[there] @ self.covariance[np.ix_(there, there)] @ weights[there])

    @property
    def _rise(self) -> str:
        """First pair of shifts that rise with the temperature, empty if there is none."""
        kelvin, factors = self.temperatures, self.log10_factors
        rises = np.flatnonzero(np.diff(factors) >= 0.0)
        if not rises.size:
            return ""
        pairs = (
            f"{factors[place]:.3g} at {kelvin[place] - ZERO_CELSIUS:.1f} °C" for place in (rises[0], rises[0] + 1)
        )
        return ", ".join(pairs)

    @property
    def doubts(self) -> tuple[str, ...]:
        """Lines on what is doubtful: gaps between the isotherms, uncertain shifts, a large misfit."""
        kelvin, lines = self.temperatures, list[str]()
        for place in np.flatnonzero(_gaps(self.isotherms.tables, self.log10_factors) > 0.0).tolist():
            pair = f"{kelvin[place - 1] - ZERO_CELSIUS:.1f} and {kelvin[place] - ZERO_CELSIUS:.1f} °C"
            lines.append(f"the isotherms at {pair} do not overlap")
        # Beyond a gap the error is infinite, and the gap has its own line.
        errors = np.where(np.isinf(self.errors), 0.0, self.errors) if lines else self.errors
        if self._rise:
            lines.append(f"the shifts do not fall with the temperature: {self._rise}")
        worst = int(np.argmax(errors))
        if errors[worst] > _UNCERTAIN:
            error = f"{errors[worst]:.2g} decades" if math.isfinite(errors[worst]) else "infinite"
            lines.append(f"the standard error of the shift at {kelvin[worst] - ZERO_CELSIUS:.1f} °C is {error}")
        if self.misfit > _POOR:
            line = f"the misfit is {self.misfit:.2g}, above {_POOR:g}: "
            lines.append(f"{line}the material may not be thermorheologically simple, or needs vertical shifts")
        return tuple(lines)

    def plot(self) -> Figure:
        """Return a figure of the isotherms, the master curve, and the shifts with their standard errors."""
        return draw("material.superposition", self)


def _abscissa(table: Curve) -> Array:
    """Return the log10 of the frequency [rad/s], or of the reciprocal time."""
    if isinstance(table, DynamicTable):
        return np.log10(table.angular_frequency)
    with np.errstate(divide="ignore"):
        return -np.log10(table.time)


def _gaps(tables: Sequence[Curve], shifts: Array) -> Array:
    """Return the gap [decades] between each isotherm and the colder ones; negative where they overlap, shape (m,)."""
    ends = [(x.min(), x.max()) for x in (column[np.isfinite(column)] for column in map(_abscissa, tables))]
    low, high = (np.array(end) + shifts for end in zip(*ends, strict=True))
    return np.append(-np.inf, np.minimum.accumulate(low)[:-1] - high[1:])


def _reduced(table: Curve, shift: float, factor: float, reference: float) -> Curve:
    """Return the isotherm at the reduced frequencies or times of the reference temperature."""
    changes: dict[str, Any] = {name: getattr(table, name) * factor for name in column_names(table)[1:]}
    if isinstance(table, DynamicTable):
        changes["angular_frequency"] = table.angular_frequency * 10.0**shift
    else:
        changes["time"] = table.time / 10.0**shift
    return replace(table, **changes, temperature=reference)
