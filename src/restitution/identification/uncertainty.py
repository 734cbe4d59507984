"""Uncertainty of a fit: covariance, flat directions, intervals, and errors of functions of the parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.identification.bands import FAR, quantile
from restitution.identification.descent import squares
from restitution.identification.estimation import Estimation, Fit, efficiency, minimise
from restitution.identification.profiles import LikelihoodProfile, hidden, profile

Array = NDArray[np.float64]

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
_STEP = 1e-4
CLOSE, UNDETERMINED = 1.3, 3.0
"""Factors between an estimate and the ends of its interval: a determined value, and one that results warn of."""
_LEVEL = 0.95


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
        if low <= 0.0:
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
    """Half width of an interval in words, as a share or as a factor."""
    if factor <= CLOSE:
        return f"to {100.0 * (factor - 1.0):.2g} %"
    return f"to a factor of {factor:.2g}" if factor < 1e3 else "to no useful factor"


def headline(parameters: Mapping[str, Estimate]) -> str:
    """Summary of how well the data determine the parameters, by the widths of their intervals."""
    rough = {name: one for name, one in parameters.items() if one.factor > CLOSE}
    if not rough:
        widest = max((one.factor for one in parameters.values()), default=1.0)
        return f"All parameters are determined, {to_within(widest)} or better."
    nothing = [name for name, one in rough.items() if all(one.open_ends)]
    parts = [f"{name} {one.accuracy}" for name, one in rough.items() if name not in nothing]
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
        """Half width of an interval over the standard error: Student's t if the size of the noise is unknown."""
        problem = self.estimation.problem
        freedom = problem.n_data - problem.low.size
        unknown = any(one.scaled for one in problem.data) and freedom > 0
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
        estimation = self.estimation
        return efficiency(estimation.problem.residuals(estimation.fit.coordinates[None])[0], estimation.loss)

    def _least(self, singular: Array) -> Array:
        """Singular values, not below the error of the Jacobian."""
        return np.maximum(singular, max(EXACT * float(singular[0]), 1e-150))

    @cached_property
    def standard_errors(self) -> Array:
        """Standard errors of all coordinates."""
        return np.sqrt(np.diag(self.covariance))

    @cached_property
    def flat_directions(self) -> tuple[FlatDirection, ...]:
        """Directions of the parameters along which a factor of e changes the data by less than their noise."""
        n, jacobian = self.estimation.problem.n_parameters, self.estimation.jacobian
        own = without(jacobian[:, :n], jacobian[:, n:])
        s, rows = principal_directions(own)
        found: list[FlatDirection] = []
        for value, direction in zip(s, rows, strict=True):
            if value < 1.0:
                direction = direction / direction[np.argmax(np.abs(direction))]
                named = zip(self.estimation.problem.space.names, direction.tolist(), strict=True)
                exponents = {name: one for name, one in named if abs(one) > _COMPONENT}
                length = float(np.linalg.norm(direction))
                exact = bool(value <= EXACT * s[0]) and self.unseen(direction)
                found.append(FlatDirection(exponents, exact, math.inf if exact else 1.0 / (float(value) * length)))
        return tuple(found)

    def unseen(self, direction: Array) -> bool:
        """Whether a direction that the Jacobian does not show is exact, and not the logarithm of a modulus near zero.

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

    def linearised(self, functions: Callable[[Array], Array]) -> tuple[Array, Array]:
        """Positive functions of m rows of coordinates, shape (m, ...), at the best fit, and errors of their logs."""
        best = self.estimation.fit.coordinates
        steps = np.diag(self.estimation.problem.steps)
        n = best.size
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            found = functions(np.concatenate([best[None], best + steps, best - steps]))
            logs = np.log(found[1:])
            rise = logs[:n] - logs[n:]
        # A loss that is zero at all points does not change.
        rise[np.isneginf(logs[:n]) & np.isneginf(logs[n:])] = 0.0
        gradient = rise / (2.0 * self.estimation.problem.steps.reshape(-1, *(1,) * (logs.ndim - 1)))
        s, rows = self._decomposed
        along = np.tensordot(rows, gradient, axes=1)
        # Along an exact direction the covariance is huge, and would enlarge the error of a derivative.
        exact = s <= EXACT * s[0]
        along[exact] = np.where(np.abs(along[exact]) < _NO_SLOPE, 0.0, along[exact])
        variance = self._efficiency[0] * np.tensordot(self._least(s) ** -2, along**2, axes=1)
        return found[0], np.sqrt(variance)

    def profile(self, k: int, level: float = _LEVEL) -> LikelihoodProfile:
        """Likelihood profile of one coordinate."""
        key = k, level
        if key not in self._profiles:
            reach = self.quantile(level) * math.sqrt(self._efficiency[1])
            self._profiles[key] = profile(self.estimation, k, self.standard_errors, self.covariance, reach)
        return self._profiles[key]

    @property
    def best(self) -> Fit:
        """Best fit, profiles included."""
        return min((self.estimation.fit, *(one.best for one in self._profiles.values())), key=lambda fit: fit.cost)

    @cached_property
    def _curved(self) -> bool:
        """Whether a parameter is hidden, so that the linearised problem gives no interval of any other."""
        return hidden(self.standard_errors, self.estimation.problem.n_parameters).size > 0

    def _bent(self, k: int, level: float) -> bool:
        """Whether the least sum of squares at an end of the interval of the linearised problem is not as predicted."""
        if not np.any(self.standard_errors[: self.estimation.problem.n_parameters] > _LINEAR):
            return False
        problem, fit, loss = self.estimation.problem, self.estimation.fit, self.estimation.loss
        excess = self.quantile(level) ** 2 * self._efficiency[1]
        move = math.sqrt(excess / self.covariance[k, k] * self._efficiency[0]) * self.covariance[:, k]
        return any(
            abs(minimise(problem, np.clip(end, problem.low, problem.high), loss, k, 1e-3).cost - fit.cost - excess)
            > _BENT * excess
            for end in (fit.coordinates - move, fit.coordinates + move)
        )

    def estimate(self, k: int, profiled: bool | None = None, level: float = _LEVEL) -> Estimate:
        """Estimate of parameter k; from its profile on request, or if its error is not small."""
        problem, parameter = self.estimation.problem, self.estimation.problem.space.free[k]
        z, error = float(self.estimation.fit.coordinates[k]), float(self.standard_errors[k])
        width = problem.high[k] - problem.low[k]
        free = any(one.exact and parameter.name in one.exponents for one in self.flat_directions)
        if free:
            low, high = -math.inf, math.inf
        elif profiled or (profiled is None and (error > _LINEAR or self._curved or self._bent(k, level))):
            low, high = self.profile(k, level)[2:4]
        else:
            reach = self.quantile(level) * error
            low, high = (z - reach, z + reach) if reach < FAR else (-math.inf, math.inf)
        if z - problem.low[k] < 1e-6 * width or low < problem.low[k]:
            low = -math.inf
        if problem.high[k] - z < 1e-6 * width or high > problem.high[k]:
            high = math.inf
        ends = math.isinf(low), math.isinf(high)
        with np.errstate(over="ignore"):
            interval = float(parameter.outward(low)), float(parameter.outward(high))
        determined = not any(ends)
        step = 1e-6
        slope = float(parameter.outward(z + step) - parameter.outward(z - step)) / (2.0 * step)
        value = float(parameter.outward(z)) if determined else None
        size = error * slope if determined else None
        return Estimate(value, size, interval, determined, parameter.quantity.unit, ends)


def without(jacobian: Array, other: Array) -> Array:
    """Columns without the part that other columns explain."""
    if not other.shape[1]:
        return jacobian
    basis, sizes, _ = np.linalg.svd(other / np.maximum(np.linalg.norm(other, axis=0), 1e-300), full_matrices=False)
    basis = basis[:, sizes > 1e-6]
    return jacobian - basis @ (basis.T @ jacobian)


def principal_directions(jacobian: Array) -> tuple[Array, Array]:
    """All singular values, those of missing rows as zeros, and directions as rows."""
    n = jacobian.shape[1]
    _, s, v = np.linalg.svd(np.vstack([jacobian, np.zeros((max(n - len(jacobian), 0), n))]), full_matrices=False)
    return s, v
