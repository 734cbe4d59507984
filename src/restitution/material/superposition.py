"""Least squares of time-temperature superposition: the shifts that bring isotherms onto one smooth curve."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.errors import InputError
from restitution.material.shift import GAS_CONSTANT

Array = NDArray[np.float64]

# The master curve is a cubic spline in log-log axes with this spacing of its knots [decades].
_SPACING = 0.25
# Its curvature [1/decade] is of this order: 2.3 at the peak of the loss modulus of a single relaxation time.
_CURVATURE = 2.0
# Scatter [decades] that is assumed at first, and the smallest one: no data are more precise.
_SCATTER, _LEAST_SCATTER = 0.01, 1e-5
# Misfit [decades] below which two isotherms fit each other at first.
_RESOLVED = 0.003
_ROUNDS = 4
_STEPS = 100
# Larger shifts [decades] have no meaning.
_FARTHEST = 300.0
# A step that lowers half of the sum of squares by less moves no parameter by a hundredth of its standard error.
_GAIN = 1e-5
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


# Shifts of the isotherms and their derivatives, shapes (m,) and (m, p), from the parameters of a law.
Law = Callable[[Array], tuple[Array, Array]]
ShiftLaw = Literal["free", "wlf", "arrhenius"]


def superpose(
    channels: list[Channel],
    law: Law,
    start: Array,
    low: Array,
    high: Array,
    lifts: Array,
) -> Superposition:
    """Shifts of least squares; the vertical shifts [decades] of the isotherms are of the order of `lifts`, shape (m,).

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
        point, before = _minimum(problem, point, *limits), scatter
        scatter = problem.scatter_of(point)
        if np.allclose(scatter, before, rtol=1e-2):
            break
    problem.prepare(point, scatter)
    covariance = _inverse(problem.normal(point).curvature)
    vertical, errors, n = np.zeros(lifts.size), np.zeros(lifts.size), start.size
    vertical[free], errors[free] = point[n:], np.sqrt(np.diag(covariance)[n:])
    return Superposition(
        point[:n], covariance[:n, :n], law(point[:n])[0], vertical, errors, tuple(scatter.tolist()),
        problem.misfit(point),
    )  # fmt: skip


class _Normal(NamedTuple):
    """Half of the sum of squares, its gradient and its Gauss-Newton curvature."""

    cost: float
    gradient: Array
    curvature: Array


def _minimum(problem: _Problem, point: Array, low: Array, high: Array) -> Array:
    """Parameters of the least sum of squares within bounds, by the method of Levenberg and Marquardt."""
    damping, here = 1e-3, problem.normal(point)
    for _ in range(_STEPS):
        # A parameter stays at a bound beyond which it would go.
        held = ((point <= low) & (here.gradient > 0.0)) | ((point >= high) & (here.gradient < 0.0))
        moving = np.flatnonzero(~held)
        curvature = here.curvature[np.ix_(moving, moving)]
        size = np.maximum(np.diag(curvature), 1e-12)
        step = np.zeros(point.size)
        step[moving] = -np.linalg.solve(curvature + damping * np.diag(size), here.gradient[moving])
        trial = np.clip(point + step, low, high)
        there = problem.normal(trial)
        if there.cost <= here.cost:
            point, damping, gain, here = trial, max(damping / 8.0, 1e-12), here.cost - there.cost, there
            if gain < _GAIN:
                break
        elif (damping := damping * 5.0) > 1e10:
            break
    return point


def _inverse(curvature: Array) -> Array:
    """Covariance of the parameters; infinite variances where their directions leave the residuals unchanged."""
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
        """Coefficients of the normal equations."""
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
            raise InputError("tables", wanted=f"must overlap: their shifts span {span:.0f} decades")
        self.size = int((span + 2.0) / _SPACING) + 4

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

    def _changes(self, point: Array, place: int, spline: _Spline) -> Array:
        """Derivatives of the residuals at fixed coefficients."""
        channel = self.channels[place]
        slopes = self.law(point[: self.n_law])[1][channel.isotherm]
        lifted = channel.isotherm[:, None] == self.free
        return -np.hstack((spline.rise[:, None] * slopes, lifted)) / self.scatter[place]

    def normal(self, point: Array) -> _Normal:
        """Half of the sum of squares with its derivatives."""
        from scipy.sparse import csr_array

        if np.ptp(self.law(point[: self.n_law])[0]) > _FARTHEST:
            return _Normal(np.inf, np.zeros(point.size), np.eye(point.size))
        weights = np.append(np.zeros(self.n_law), self.lifts[self.free] ** -2.0)
        cost, gradient, curvature = 0.5 * float(weights @ point**2), weights * point, np.diag(weights)
        for place in range(len(self.channels)):
            spline = self._spline(point, place)
            changes = self._changes(point, place, spline)
            common = spline.basis.T @ changes
            cost += 0.5 * float(spline.residuals @ spline.residuals + spline.bends @ spline.bends)
            gradient = gradient + changes.T @ spline.residuals
            # Most of the changes are zero: each isotherm has its own shift.
            few: Any = csr_array(changes)
            curvature = curvature + (few.T @ few).toarray() - common.T @ spline.solve(common)
        return _Normal(cost, gradient, curvature)

    def scatter_of(self, point: Array) -> Array:
        """Scatter of each channel [decades] from its residuals and the degrees of freedom that are left."""
        covariance = _inverse(self.normal(point).curvature)
        covariance[~np.isfinite(covariance)] = 0.0
        found = np.empty(len(self.channels))
        for place, scatter in enumerate(self.scatter.tolist()):
            spline = self._spline(point, place)
            changes = self._changes(point, place, spline)
            changes -= spline.basis @ spline.solve(spline.basis.T @ changes)
            n = spline.residuals.size
            used = float(np.trace(spline.solve((spline.basis.T @ spline.basis).toarray())))
            used += float(np.sum((changes @ covariance) * changes))
            squares = float(spline.residuals @ spline.residuals) * scatter**2
            found[place] = np.sqrt(squares / max(n - used, 0.1 * n))
        return np.maximum(found, _LEAST_SCATTER)

    def misfit(self, point: Array) -> float:
        """Root mean square of the relative residuals of all data."""
        decades = [self._spline(point, place).residuals * size for place, size in enumerate(self.scatter.tolist())]
        return float(np.sqrt(np.mean(np.expm1(np.concatenate(decades) * np.log(10.0)) ** 2)))


def first_shifts(channels: list[Channel]) -> Array:
    """Estimates of the shifts, of each isotherm over the one before, from the best overlap of the two."""
    count = int(max(channel.isotherm.max() for channel in channels)) + 1
    curves = [[_sorted(one, one.isotherm == i) for one in channels] for i in range(count)]
    steps = [_step(cold, warm) for cold, warm in pairwise(curves)]
    return np.concatenate(((0.0,), np.cumsum(steps)))


def _sorted(channel: Channel, which: NDArray[np.bool_]) -> tuple[Array, Array]:
    order = np.argsort(channel.abscissa[which])
    return channel.abscissa[which][order], channel.ordinate[which][order]


def _step(cold: list[tuple[Array, Array]], warm: list[tuple[Array, Array]]) -> float:
    """Shift [decades] of an isotherm over the next colder one."""
    (low, high), (first, last) = ((x.min(), x.max()) for x in (cold[0][0], warm[0][0]))
    least = 0.2 * min(high - low, last - first)
    trials = np.arange(low - last + least, min(high - first, 0.5 + low - first) - least + 1e-9, 0.05)
    best, chosen = np.inf, 0.0
    for trial in trials.tolist():
        places = np.linspace(max(low, first + trial), min(high, last + trial), 12)
        gaps = [np.interp(places, *one) - np.interp(places - trial, *other)
                for one, other in zip(cold, warm, strict=True) if one[0].size > 1 and other[0].size > 1]  # fmt: skip
        # The likelihood for an unknown scatter of each modulus; of shifts that fit alike, the smallest.
        misfit = sum(float(np.log(np.mean(gap**2) + _RESOLVED**2)) for gap in gaps) + 1e-4 * abs(trial)
        if misfit < best:
            best, chosen = misfit, trial
    return chosen


def law_of(
    shift: ShiftLaw, kelvin: Array, reference: float, nearest: int, start: Array
) -> tuple[Law, Array, Array, Array]:
    """Law of the shift, first parameters, and their bounds.

    The parameters of WLF are C1/C2 and 1/C2, which are less correlated than C1 and C2; that of Arrhenius is Q/R in
    decades.
    """
    rise = kelvin - reference
    if shift == "free":
        others = np.delete(np.arange(kelvin.size), nearest)
        slopes = np.eye(kelvin.size)[:, others]
        first = (start - start[nearest])[others]
        return lambda p: (slopes @ p, slopes), first, np.full(first.size, -np.inf), np.full(first.size, np.inf)
    if shift == "arrhenius":
        slope = (1.0 / kelvin - 1.0 / reference)[:, None]
        first = np.array([max(float(start @ slope[:, 0]) / float(slope[:, 0] @ slope[:, 0]), 1.0)])
        return lambda p: (slope @ p, slope), first, np.zeros(1), np.full(1, np.inf)

    def wlf(p: Array) -> tuple[Array, Array]:
        below = 1.0 + p[1] * rise
        return -p[0] * rise / below, np.stack((-rise / below, p[0] * (rise / below) ** 2), axis=1)

    # The Vogel temperature must be below the lowest one measured.
    limit = 0.98 / max(reference - float(kelvin[0]), 1.0)
    trials = np.linspace(0.0, 0.95, 40)[1:] * min(limit, 0.1)
    best, first = np.inf, np.array([0.05, trials[0]])
    for trial in trials.tolist():
        shape = -rise / (1.0 + trial * rise)
        size = max(float(start @ shape) / float(shape @ shape), 1e-6)
        squares = float(np.sum((start - size * shape) ** 2))
        if squares < best:
            best, first = squares, np.array([size, trial])
    return wlf, first, np.array([0.0, 1e-6]), np.array([np.inf, limit])


def constants_of(shift: ShiftLaw, found: Superposition, reference: float) -> tuple[dict[str, float], dict[str, float]]:
    """Constants of a law, and their standard errors."""
    p, covariance = found.parameters, found.covariance
    if shift == "free":
        return {}, {}
    if shift == "arrhenius":
        factor = GAS_CONSTANT * math.log(10.0)
        return {"activation_energy": float(p[0]) * factor}, {"activation_energy": math.sqrt(covariance[0, 0]) * factor}
    c1, c2 = float(p[0] / p[1]), float(1.0 / p[1])
    slopes = np.array([[1.0 / p[1], -p[0] / p[1] ** 2], [0.0, -1.0 / p[1] ** 2]])
    errors = np.sqrt(np.diag(slopes @ covariance @ slopes.T)) if np.isfinite(covariance).all() else np.full(2, np.inf)
    return {"c1": c1, "c2": c2}, {"c1": float(errors[0]), "c2": float(errors[1])}
