"""Uncertainty of a fit: covariance, flat directions, intervals, and errors of functions of the parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from restitution.checks import Array
from restitution.identification.fit import Estimation, Fit, efficiency, minimise, moved, ranks, rescued
from restitution.identification.parameters import rows_of
from restitution.material.prony import PronySeries
from restitution.numerics.differences import CENTRAL
from restitution.numerics.least_squares import squares
from restitution.quantities import Quantity, dataset

if TYPE_CHECKING:
    import xarray

T = TypeVar("T")


# Bands: values over an axis with the ends of their intervals, and the moduli that have them.


MODULUS_NAMES = ("storage_modulus", "loss_modulus", "absolute_modulus", "loss_tangent")
"""Functions of a complex modulus, as in `restitution.quantities.MODULI`."""

FAR = math.log(1e3)
"""Distance of a logarithm from the best value beyond which nothing is known."""

# A longer band overflows.
_LONGEST = 300.0


def modulus_functions(series: PronySeries, angular_frequency: Array) -> Array:
    """Return `MODULUS_NAMES` of n materials at angular frequencies [rad/s] of shape (m,), shape (n, 4, m)."""
    moduli = series.column.complex_modulus(angular_frequency)
    return np.stack([moduli.real, moduli.imag, np.abs(moduli), moduli.imag / moduli.real], axis=1)


def quantile(level: float, freedom: float = math.inf) -> float:
    """Return the half width of an interval over the standard error: Student's t, or the normal distribution."""
    from scipy.special import ndtri, stdtrit

    share = 0.5 + 0.5 * level
    return float(ndtri(share) if math.isinf(freedom) else stdtrit(freedom, share))


def limits(values: Array, errors: Array, width: float) -> tuple[Array, Array]:
    """Return the ends of bands of positive values: `width` standard errors of their logarithms to both sides."""
    factor = np.exp(np.minimum(width * errors, _LONGEST))
    return values / factor, values * factor


def banded(
    axis: Quantity, x: Array, level: float, columns: Mapping[Quantity, tuple[Array, Array, Array]]
) -> xarray.Dataset:
    """Return a dataset of values and of the ends of their bands, `..._low` and `..._high`, over an axis."""
    columns_of: dict[str, tuple[Any, Quantity]] = {axis.name: (x, axis)}
    for quantity, (values, *ends) in columns.items():
        columns_of[quantity.name] = values, quantity
        for end, numbers in zip(("low", "high"), ends, strict=True):
            words = f"{quantity.words}, {end} end of the {100.0 * level:g} % band"
            columns_of[f"{quantity.name}_{end}"] = numbers, quantity._replace(words=words)
    return dataset(axis.name, columns_of, {"level": level})


# Profiles: the least sum of squares at each value of one unknown, and the interval from it.

_LONGEST_STEP = 0.7
_ROUNDS = 12
_CLOSE = 0.01
_TOLERANCE = 1e-5
# Five errors over the half width of an interval, and the factor of a wary quantile.
_FAR_ERRORS, _WARY = 5.0 / 1.96, 1.8
# A standard error of a logarithm above this is that of a hidden parameter.
_HIDDEN = 0.3
# Below this root of the excess, a profile counts as flat, and the steps grow by this factor.
_FLAT, _GROWTH = 0.3, 1.6


class LikelihoodProfile(NamedTuple):
    """Profile of one coordinate, the logarithm of a parameter."""

    coordinates: Array  # in ascending order, shape (n,)
    excess: Array  # least sum of squares there above the minimum, shape (n,)
    low: float  # ends of the interval; infinite where open
    high: float
    best: Fit  # the best fit found, which may be better than that of the estimation


def profile(
    estimation: Estimation, k: int, standard_error: Array, covariance: Array, quantile: float
) -> LikelihoodProfile:
    """Profile of coordinate k, from the minimum to both sides until the excess is above the squared quantile.

    Each step is at most 0.7, more where the profile is flat, and starts from the line through the last two points. The
    secant rule in the root of the excess then finds the end. An end at a bound, or farther than a factor of 1000 from
    the flat part of the profile, is open.

    The logarithm of a modulus that is too small to be seen has no slope, so that a descent does not bring it back. A
    point therefore counts as outside only if descents from other values of such coordinates end there as well. Where
    the profile flattens beyond an end, the end is taken at 1.8 times the quantile: a small chance excess of the sum of
    squares would otherwise exclude values at many times the stated error.
    """
    best = estimation.fit
    points: list[tuple[float, float]] = [(float(best.coordinates[k]), 0.0)]
    ends: list[float] = []
    unseen = hidden(standard_error, estimation.problem.n_parameters)
    for sign in (-1.0, 1.0):
        walk = _Walk(estimation, k, sign, standard_error, covariance, best)
        end = walk.end(quantile)
        if unseen.size and math.isfinite(end):
            farther = walk.end(_WARY * quantile, _FAR_ERRORS * abs(end - points[0][0]))
            end = end if math.isnan(farther) else farther
        ends.append(end)
        points += walk.walked
        best = walk.best
    points.sort()
    z, excess = np.array(points).T
    return LikelihoodProfile(z, np.maximum(excess, 0.0), ends[0], ends[1], best)


class _Point(NamedTuple):
    """Point of one side of a profile."""

    distance: float
    root: float  # of the excess
    coordinates: Array

    def toward(self, other: _Point, distance: float) -> Array:
        """Return the change of the coordinates to a distance, along the line through another point."""
        share = (distance - self.distance) / (other.distance - self.distance)
        return share * (other.coordinates - self.coordinates)

    def step(self, before: _Point, quantile: float) -> float:
        """Return the step to a root of the excess if that is a straight line."""
        pace = (self.root - before.root) / (self.distance - before.distance)
        return min(_LONGEST_STEP, 1.05 * (quantile - self.root) / pace if pace > 0.0 else _LONGEST_STEP)


def hidden(standard_errors: Array, n_parameters: int) -> NDArray[np.intp]:
    """Return parameters whose size the data hardly show at the best fit, so that linear estimates of errors fail."""
    return np.flatnonzero(standard_errors[:n_parameters] > _HIDDEN)


class _Walk:
    """Walk along one side of a profile, which goes on from a known end."""

    def __init__(
        self, estimation: Estimation, k: int, sign: float, standard_error: Array, covariance: Array, best: Fit
    ) -> None:
        problem = estimation.problem
        self.estimation, self.k, self.sign, self.best = estimation, k, sign, best
        self.walked: list[tuple[float, float]] = []
        self.unseen = hidden(standard_error, problem.n_parameters)
        self.error, self.slope = float(standard_error[k]), sign * covariance[:, k] / covariance[k, k]
        self.start = float(estimation.fit.coordinates[k])
        self.room = 0.999 * abs(float(problem.low[k] if sign < 0 else problem.high[k]) - self.start)
        self.last = _Point(0.0, 0.0, estimation.fit.coordinates)
        self.before: _Point | None = None
        self.flat = 0.0  # distance to which the profile is flat

    def end(self, quantile: float, beyond: float = 0.0) -> float:
        """Return the end of the interval; infinite where open, NaN, without a search, if nearer than `beyond`."""
        outer = self._outside(quantile)
        if outer is None:
            return self.sign * math.inf
        if outer.distance <= beyond:
            return math.nan
        inner, self.before = self.last, self.last
        # Bracketed by two least sums: the secant rule, kept within by halving, from the line between their points.
        for n in range(_ROUNDS):
            if outer.root - quantile < _CLOSE:
                break
            share = (quantile - inner.root) / (outer.root - inner.root) if math.isfinite(outer.root) else 0.5
            share = min(max(share + 1e-3, 0.02), 0.98) if n % 4 != 3 else 0.5
            distance = inner.distance + share * (outer.distance - inner.distance)
            line = inner.toward(outer, distance) if math.isfinite(outer.root) else 0.0
            new = self._point(distance, inner.coordinates + line)
            if new.root < quantile - _CLOSE:
                inner = new
            else:
                outer = new
        self.last = outer
        return self.start + self.sign * outer.distance if outer.distance >= beyond else math.nan

    def _outside(self, quantile: float) -> _Point | None:
        """Walk to the first point whose excess is above the squared quantile; None if there is none."""
        before = self.before
        step = min(_LONGEST_STEP, quantile * self.error) if before is None else self.last.step(before, quantile)
        while self.last.distance < (furthest := min(self.flat + FAR, self.room)):
            distance = min(self.last.distance + step, furthest)
            # The line of a hidden coordinate is meaningless, so that no coordinate goes far along it.
            line = self.slope * distance if self.before is None else self.last.toward(self.before, distance)
            guess = self.last.coordinates + np.clip(line, -_LONGEST_STEP, _LONGEST_STEP)
            new = self._point(distance, guess, quantile)
            if not new.root < quantile:
                return new
            self.before, self.last, width = self.last, new, step
            if new.root < _FLAT:
                self.flat, step = new.distance, max(_GROWTH * width, 0.02)
            else:
                step = max(new.step(self.before, quantile), 0.02 * _LONGEST_STEP * min(1.0, self.error))
        return None

    def _point(self, distance: float, guess: Array, quantile: float | None = None) -> _Point:
        """Return a point of the profile; above a squared quantile also by descents from other hidden coordinates."""
        problem, loss, least = self.estimation.problem, self.estimation.loss, self.estimation.fit.cost
        guess = np.clip(guess, problem.low, problem.high)
        guess[self.k] = self.start + self.sign * distance
        fit = minimise(problem, guess, loss, self.k, _TOLERANCE)
        if quantile is not None and not fit.cost - least < quantile**2:
            fit = rescued(problem, fit, self.last.coordinates, self.unseen, loss, self.k, _TOLERANCE)
        self.best = min(self.best, fit, key=lambda fit: fit.cost)
        self.walked.append((float(guess[self.k]), fit.cost - least))
        return _Point(distance, math.sqrt(max(fit.cost - least, 0.0)), fit.coordinates)


EXACT = 3e-6
"""A direction is exact if its singular value is below this share of the largest; the error of the Jacobian is 1e-7."""
# Derivative of the logarithm of a function over that of a parameter that is zero but for the error of differences.
_NO_SLOPE = 1e-4
# Share of the sum of squares, from the error of the solver, that changes along an exact direction.
_UNSEEN = 1e-3
# A coordinate belongs to a flat direction if its component is above this.
_COMPONENT = 1e-3
# Below this standard error of the logarithm, the interval of the linearised problem is good enough.
_LINEAR = 0.05
# Share of the excess at an end by which the linearised problem may err.
_BENT = 0.1
CLOSE, UNDETERMINED = 1.3, 3.0
"""Factors between an estimate and the ends of its interval: a determined value, and one that results warn of."""
_LEVEL = 0.95
# Steps of a logarithm along a valley: the first and the largest, their growth, and the excess over that of the
# interval that ends them.
_PACE, _LONGEST_PACE, _FASTER, _LEFT = 0.12, 0.3, 1.3, 2.0
# A profile or a valley with a point this much better than the fit moves the fit there, so many times.
_BETTER, _RESTARTS = 1e-2, 3


class Estimate(NamedTuple):
    """Estimate of one unknown in SI."""

    value: float | None  # None if not determined
    standard_error: float | None
    interval: tuple[float, float]  # 95 %; an open end is that of the admissible range
    determined: bool  # whether both ends of the interval are closed
    unit: str = ""
    open_ends: tuple[bool, bool] = (False, False)  # whether the low and the high end are open

    @property
    def factor(self) -> float:
        """Larger of the factors between the estimate and the ends of its interval; infinite where one is open."""
        low, high = self.interval
        if not self.determined or self.value is None:
            return math.inf
        if low == high == self.value or not (math.isfinite(low) and math.isfinite(high)):
            return 1.0  # known without an error, or an unknown that was projected out
        if low <= 0.0:  # no factor leads from a positive value to zero
            return math.inf if self.value > 0.0 else 1.0
        return max(self.value / low, high / self.value)

    @property
    def accuracy(self) -> str:
        """How well the data determine the value: "to 12 %", "to a factor of 3", or the end that is known."""
        low, high = self.interval
        unit = f" {self.unit}" if self.unit else ""
        if self.determined:
            return to_within(self.factor)
        if self.open_ends == (True, False):
            return f"at most {high:.3g}{unit} (bounded above)"
        if self.open_ends == (False, True):
            return f"at least {low:.3g}{unit} (bounded below)"
        return "not determined by these data"

    @property
    def words(self) -> str:
        """The estimate as text; without a number unless the data determine one."""
        low, high = self.interval
        unit = f" {self.unit}" if self.unit else ""
        if self.determined:
            if self.factor > CLOSE:
                return f"{self.value:.2g}{unit}, from {low:.2g} to {high:.2g}{unit}: {to_within(self.factor)} only"
            error = "" if self.standard_error is None else f" +- {self.standard_error:.2g}"
            return f"{self.value:.4g}{error}{unit}"
        return self.accuracy


def to_within(factor: float) -> str:
    """Return the half width of an interval in words, as a share or as a factor."""
    if factor <= CLOSE:
        return f"to {100.0 * (factor - 1.0):.2g} %"
    return f"to a factor of {factor:.2g}" if factor < 1e3 else "to no useful factor"


def headline(parameters: Mapping[str, Estimate]) -> str:
    """Return a summary of how well the data determine the parameters, by the widths of their intervals."""
    rough = {name: estimate for name, estimate in parameters.items() if estimate.factor > CLOSE}
    if not rough:
        widest = max((estimate.factor for estimate in parameters.values()), default=1.0)
        return f"All parameters are determined, {to_within(widest)} or better."
    nothing = [name for name, estimate in rough.items() if all(estimate.open_ends)]
    parts = [f"{name} {estimate.accuracy}" for name, estimate in rough.items() if name not in nothing]
    lines = [f"Not determined: {', '.join(nothing)}."] if nothing else []
    return " ".join([*lines, *([f"Roughly determined: {'; '.join(parts)}."] if parts else [])])


class FlatDirection(NamedTuple):
    """Common change of the parameters with hardly any effect on the data."""

    exponents: dict[str, float]  # by parameter: each is multiplied by x to this power
    exact: bool  # whether the change has no effect at all
    standard_error: float  # of ln x


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Uncertainty of the coordinates of a fit."""

    estimation: Estimation
    _profiles: dict[tuple[int, float], LikelihoodProfile] = field(default_factory=dict)

    def quantile(self, level: float = _LEVEL) -> float:
        """Return the half width of an interval over the standard error: Student's t for noise of unknown size."""
        problem = self.estimation.problem
        freedom = problem.n_data - problem.low.size
        unknown = any(record.scaled for record in problem.data) and freedom > 0
        return quantile(level, freedom if unknown else math.inf)

    @cached_property
    def _decomposed(self) -> tuple[Array, Array]:
        """Singular values and directions, as rows, of all coordinates."""
        return principal_directions(self.estimation.jacobian)

    @cached_property
    def covariance(self) -> Array:
        """Covariance of all coordinates; huge along directions that the data do not determine."""
        s, rows = self._decomposed
        return self._efficiency[0] * (rows.T / self._least(s) ** 2) @ rows

    @cached_property
    def _efficiency(self) -> tuple[float, float]:
        """Factors of the variance, and of the excess in a profile, for the loss of the fit."""
        return efficiency(self.estimation.residuals, self.estimation.loss)

    def _least(self, singular: Array) -> Array:
        """Return singular values, not below the error of the Jacobian."""
        return np.maximum(singular, max(EXACT * float(singular[0]), 1e-150))

    @cached_property
    def standard_errors(self) -> Array:
        """Standard errors of all coordinates."""
        return np.sqrt(np.diag(self.covariance))

    @cached_property
    def flat_directions(self) -> tuple[FlatDirection, ...]:
        """Directions of the parameters along which a factor of e changes the data by less than their noise."""
        n, jacobian = self.estimation.problem.n_parameters, self.estimation.jacobian
        seen = without(jacobian[:, :n], jacobian[:, n:])
        s, rows = principal_directions(seen)
        least = EXACT * max(float(s[0]), 1e-150)
        directions: list[FlatDirection] = []
        for value, direction in zip(s, rows, strict=True):
            if value < 1.0:
                direction = direction / direction[np.argmax(np.abs(direction))]
                named = zip(self.estimation.problem.space.names, direction.tolist(), strict=True)
                exponents = {name: exponent for name, exponent in named if abs(exponent) > _COMPONENT}
                length = float(np.linalg.norm(direction))
                exact = bool(value <= EXACT * s[0]) and self.unseen(direction)
                directions.append(
                    FlatDirection(exponents, exact, math.inf if exact else 1.0 / (max(float(value), least) * length))
                )
        return tuple(directions)

    def unseen(self, direction: Array) -> bool:
        """Return whether a direction that the Jacobian does not show is exact: no logarithm of a modulus near zero.

        A single parameter is moved far, as far as its bounds permit. Directions of several parameters may be curved.
        """
        if np.count_nonzero(np.abs(direction) > _COMPONENT * np.abs(direction).max()) > 1:
            return True
        problem, best = self.estimation.problem, self.estimation.fit.coordinates
        n, moves = problem.n_parameters, np.tile(best, (2, 1))
        for row, sign in zip(moves, (1.0, -1.0), strict=True):
            move = sign * direction
            ends = np.where(move > 0.0, problem.high[:n], problem.low[:n]) - best[:n]
            shares = ends[np.abs(move) > _COMPONENT] / move[np.abs(move) > _COMPONENT]
            row[:n] += min(FAR, float(shares.min(initial=FAR))) * move
        *costs, least = squares(problem.residuals(np.concatenate([moves, best[None]])))
        return bool(np.all(np.abs(np.array(costs) - least) < _UNSEEN * max(least, 1.0)))

    def linearised(
        self, functions: Callable[[Array], Array], *, logarithms: bool = True, least_step: float = 0.0
    ) -> tuple[Array, Array]:
        """Return functions of m rows of coordinates at the best fit, and the errors of their logs or of themselves."""
        best, problem = self.estimation.fit.coordinates, self.estimation.problem
        steps = problem.steps
        steps[: problem.n_parameters] = np.maximum(steps[: problem.n_parameters], least_step)
        points = CENTRAL.points(best, steps)
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            values = rows_of(lambda rows: functions(points[rows]), len(points))
            logs = np.log(values) if logarithms else values
        # A loss that is zero at all points does not change.
        gradient = CENTRAL.slopes(np.where(np.isneginf(logs).all(axis=0), 0.0, logs), steps)
        s, rows = self._decomposed
        along = np.tensordot(rows, gradient, axes=1)
        # Along an exact direction the covariance is huge, and would enlarge the error of a derivative.
        exact = s <= EXACT * s[0]
        along[exact] = np.where(np.abs(along[exact]) < _NO_SLOPE, 0.0, along[exact])
        variance = self._efficiency[0] * np.tensordot(self._least(s) ** -2, along**2, axes=1)
        return values[0], np.sqrt(variance)

    def profile(self, k: int, level: float = _LEVEL) -> LikelihoodProfile:
        """Return the likelihood profile of one coordinate."""
        key = k, level
        if key not in self._profiles:
            reach = self.quantile(level) * math.sqrt(self._efficiency[1])
            self._profiles[key] = profile(self.estimation, k, self.standard_errors, self.covariance, reach)
        return self._profiles[key]

    @property
    def best(self) -> Fit:
        """Best fit, those along valleys and profiles included."""
        return min(
            (self.estimation.fit, *self._others, *(profile.best for profile in self._profiles.values())),
            key=lambda fit: fit.cost,
        )

    @cached_property
    def _curved(self) -> bool:
        """Whether a parameter is hidden, so that the linearised problem gives no interval of any other."""
        return hidden(self.standard_errors, self.estimation.problem.n_parameters).size > 0

    def _bent(self, k: int, level: float) -> bool:
        """Return whether the least sum of squares at an end of the linearised interval is not as predicted."""
        if not np.any(self.standard_errors[: self.estimation.problem.n_parameters] > _LINEAR):
            return False  # all logarithms change too little for the problem to be nonlinear
        problem, fit, loss = self.estimation.problem, self.estimation.fit, self.estimation.loss
        excess = self.quantile(level) ** 2 * self._efficiency[1]
        move = math.sqrt(excess / self.covariance[k, k] * self._efficiency[0]) * self.covariance[:, k]
        return any(
            abs(minimise(problem, np.clip(end, problem.low, problem.high), loss, k, 1e-3).cost - fit.cost - excess)
            > _BENT * excess
            for end in (fit.coordinates - move, fit.coordinates + move)
        )

    @property
    def unseen_adhesion(self) -> list[str]:
        """Names of the numbers of an adhesion whose size the data hardly show."""
        space = self.estimation.problem.space
        places = hidden(self.standard_errors, self.estimation.problem.n_parameters)
        return [space.names[k] for k in places if space.names[k] in space.adhesion]

    @cached_property
    def _others(self) -> tuple[Fit, ...]:
        """Other minima with adhesion, which are no parts of one valley, and fits along all rough parameters.

        A valley has many small minima, and a descent from a point beside it ends in one of them. So a walk begins at
        the farthest fit that is as good as the best one. Walks along work and stress come first.
        """
        problem = self.estimation.problem
        if not problem.space.adhesion:
            return ()
        others = [self.estimation.fit, *self.estimation.fits]
        errors, names = self.standard_errors[: problem.n_parameters], problem.space.names
        rough = sorted(np.flatnonzero(errors > _LINEAR).tolist(), key=lambda k: names[k] not in problem.space.adhesion)
        if any(names[k] in problem.space.adhesion for k in rough):
            for k in rough:
                for sign in (-1.0, 1.0):
                    start = max(self._as_good(others), key=lambda fit: sign * fit.coordinates[k])
                    others += self._valley(k, sign, start.coordinates)
        return tuple(others)

    def _valley(self, k: int, sign: float, point: Array) -> list[Fit]:
        """Return fits from a point along coordinate k, in small steps along the line of the last two."""
        problem, fit, loss = self.estimation.problem, self.estimation.fit, self.estimation.loss
        fits, line, pace = list[Fit](), sign * np.eye(point.size)[k], min(_PACE, float(self.standard_errors[k]))
        enough = fit.cost + _LEFT * self._excess()
        while abs(point[k] - fit.coordinates[k]) < FAR:
            # The line has a step of one along coordinate k.
            new = point + np.clip(pace * line, -_LONGEST_STEP, _LONGEST_STEP)
            if not problem.low[k] < new[k] < problem.high[k]:
                break
            fits.append(minimise(problem, np.clip(new, problem.low, problem.high), loss, k, 1e-3))
            if fits[-1].cost > enough:
                break
            line, point = (fits[-1].coordinates - point) / pace, fits[-1].coordinates
            pace = min(_FASTER * pace, _LONGEST_PACE)
        return fits

    def _excess(self, level: float = _LEVEL) -> float:
        """Return the excess of the sum of squares of fits that are as good as the best one."""
        return self.quantile(level) ** 2 * self._efficiency[1]

    def _as_good(self, fits: Sequence[Fit], level: float = _LEVEL) -> list[Fit]:
        """Return the fits that are as good as the best one."""
        return [fit for fit in fits if fit.cost <= self.estimation.fit.cost + self._excess(level)]

    def interval(self, k: int, level: float = _LEVEL, *, linear: bool = True) -> tuple[float, float]:
        """Return the ends of a coordinate over all fits that are as good.

        `linear` adds to each fit its own interval: what its sum of squares leaves of the excess, by the error at the
        best fit. Where the errors at the best fit hold everywhere, the union is at most 1.41 times too wide.
        """
        best, quantile = self.estimation.fit, self.quantile(level) if linear else 0.0
        fits = self._as_good((best, *self._others), level)
        values = np.array([fit.coordinates[k] for fit in fits])
        left = 1.0 - np.array([fit.cost - best.cost for fit in fits]) / self._excess(level)
        reach = quantile * self.standard_errors[k] * np.sqrt(left)
        low, high = float(np.min(values - reach)), float(np.max(values + reach))
        z, far = best.coordinates[k], FAR if k < self.estimation.problem.n_parameters else math.inf
        return low if z - low < far else -math.inf, high if high - z < far else math.inf

    def estimate(self, k: int, profiled: bool | None = None, level: float = _LEVEL) -> Estimate:
        """Return the estimate of parameter k; from its profile on request, or if its error is not small."""
        problem, parameter = self.estimation.problem, self.estimation.problem.space.free[k]
        z, error = float(self.estimation.fit.coordinates[k]), float(self.standard_errors[k])
        width = problem.high[k] - problem.low[k]
        free = any(direction.exact and parameter.name in direction.exponents for direction in self.flat_directions)
        ends = self.interval(k, level, linear=False)
        if free:
            low, high = -math.inf, math.inf
        # The linearised problem fails where an error is large, or where the least sum of squares is no parabola.
        elif profiled or (profiled is None and (error > _LINEAR or self._curved or self._bent(k, level))):
            low, high = self.profile(k, level)[2:4]
        else:
            low, high = self.interval(k, level)
        low, high = min(low, ends[0]), max(high, ends[1])
        if ends[1] > ends[0] and math.isfinite(high - low):
            error = max(error, 0.5 * (high - low) / self.quantile(level))
        # The data do not bound an estimate that lies at the end of its range.
        if z - problem.low[k] < 1e-6 * width or low < problem.low[k]:
            low = -math.inf
        if problem.high[k] - z < 1e-6 * width or high > problem.high[k]:
            high = math.inf
        opened = math.isinf(low), math.isinf(high)
        with np.errstate(over="ignore"):
            interval = float(parameter.outward(low)), float(parameter.outward(high))
        determined = not any(opened)
        value = float(parameter.outward(z)) if determined else None
        size = error * float(parameter.slope(value)) if determined else None
        return Estimate(value, size, interval, determined, parameter.quantity.unit, opened)


def settled(uncertainty: Uncertainty, results: Callable[[Uncertainty], T]) -> tuple[Uncertainty, T]:
    """Return an uncertainty and results from it, at the best minimum that these come across.

    A profile or a valley may lead to a better minimum, which is taken unless it is less plausible.
    """
    outcome = results(uncertainty)
    for _ in range(_RESTARTS):
        estimation, better = uncertainty.estimation, uncertainty.best
        rank, other = ranks(estimation.problem, (estimation.fit, better))
        if other > rank - _BETTER:
            break
        best = minimise(estimation.problem, better.coordinates, estimation.loss)
        uncertainty = Uncertainty(moved(estimation.problem, estimation.loss, best, estimation.fits))
        outcome = results(uncertainty)
    return uncertainty, outcome


def nuisance_estimates(uncertainty: Uncertainty) -> dict[str, Estimate]:
    """Return unknowns of the measurements: those of the fit, with errors, then those that were projected out."""
    problem, fit = uncertainty.estimation.problem, uncertainty.estimation.fit
    point, estimates, at = fit.coordinates[None], dict[str, Estimate](), problem.n_parameters
    materials, quantile = problem.materials(point), uncertainty.quantile()
    for n, (record, values) in enumerate(zip(problem.data, problem.nuisances(point), strict=True)):
        prefix = f"{record.label or n}: " if len(problem.data) > 1 else ""
        for k, nuisance in enumerate(record.nuisances):
            low, high = (nuisance.step * end for end in uncertainty.interval(at))
            at += 1
            estimates[prefix + nuisance.name] = Estimate(
                float(values[0, k]), 0.5 * (high - low) / quantile, (low, high), True, nuisance.unit
            )
        for name, (value, unit) in record.linear_estimates(materials, values).items():
            estimates[prefix + name] = Estimate(value, None, (-math.inf, math.inf), True, unit)
    return estimates


def without(jacobian: Array, other: Array) -> Array:
    """Return columns without the part that other columns explain."""
    if not other.shape[1]:
        return jacobian
    basis, sizes, _ = np.linalg.svd(other / np.maximum(np.linalg.norm(other, axis=0), 1e-300), full_matrices=False)
    basis = basis[:, sizes > 1e-6]
    return jacobian - basis @ (basis.T @ jacobian)


def principal_directions(jacobian: Array) -> tuple[Array, Array]:
    """Return all singular values, those of missing rows as zeros, and directions as rows."""
    n = jacobian.shape[1]
    _, s, v = np.linalg.svd(np.vstack([jacobian, np.zeros((max(n - len(jacobian), 0), n))]), full_matrices=False)
    return s, v
