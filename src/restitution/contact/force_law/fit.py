"""Smooth fit of an elastic force over the depth: Chebyshev polynomials of F/d^p in sqrt(d)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Exponents of flat-ended, round and sharp bodies, whose force is a series in sqrt(d); others are fitted.
_EXPONENTS = (1.0, 1.5, 2.0)
_LOW, _HIGH = 1.0, 4.0
# Largest degree, least number of rows for each coefficient, and largest degree beside a fitted exponent.
_MOST_DEGREE, _ROWS, _FREE_DEGREE = 24, 4, 3
# Fits whose rank differs by less from the best are nearly as likely; at most so many count.
_NEARLY, _RIVALS = 6.0, 5
# Rounding of forces over the largest; smaller residuals are no reason for another degree.
_ROUNDING = 1e-14
# Gain in twice the log-likelihood that a further coefficient must bring.
_PENALTY = 3.0
# Smallest force over the largest that has a relative error: below it the error is constant.
_LEAST_FORCE = 1e-3
# Places at which the fitted stiffness is checked, and the standard errors within which it may fall.
_PLACES, _SIGMAS, _LEVEL, _MOST_FALL = 400, 3.0, 1e-3, 0.01
# Misfit of a fit that rises over that of the likeliest one, and a misfit that does not matter.
_SLACK, _SMOOTHING = 3.0, 1e-4


@dataclass(frozen=True, eq=False)
class ForceFit:
    """Force ``F = F_1 x^(2p) sum_j c_j T_j(2x - 1)``, ``x = sqrt(d/d_1)``, largest depth d_1, force F_1 there.

    Attributes
    ----------
    depth_unit, force_unit : float
        d_1 [m] and F_1 [N].
    exponent : float
        Exponent p of the force at small depth.
    coefficients : array
        Chebyshev coefficients c_j, lowest first.
    residual : array
        Measured minus fitted force of each row over F_1, in the order of the rows.
    covariance : array
        Covariance of the coefficients, then of the exponent if it was fitted, from the residuals (HC3), without any
        assumption about how the noise depends on the depth.
    spread : float
        Largest difference of the force over F_1, at any depth, from other fits that are nearly as likely.
    """

    depth_unit: float
    force_unit: float
    exponent: float
    coefficients: Array
    residual: Array
    covariance: Array
    spread: float = 0.0

    @property
    def degree(self) -> int:
        """Degree of the polynomial."""
        return self.coefficients.size - 1

    @property
    def misfit(self) -> float:
        """Root mean square of the residuals."""
        return float(np.sqrt(np.mean(self.residual**2)))

    @property
    def error(self) -> float:
        """Standard error of the fitted force over F_1, the largest at any depth, with the spread."""
        x = _places()
        return math.hypot(np.max(self._deviation(_force_columns(x, self.exponent, self.degree), x)), self.spread)

    def force(self, x: Array) -> Array:
        """Force over F_1 at x."""
        return x ** (2.0 * self.exponent) * chebyshev.chebval(2.0 * x - 1.0, self.coefficients)

    def stiffness(self, x: Array) -> Array:
        """Stiffness dF/dd over F_1/d_1 at x."""
        series = chebyshev.chebval(2.0 * x - 1.0, self.coefficients)
        slope = chebyshev.chebval(2.0 * x - 1.0, chebyshev.chebder(self.coefficients))
        return x ** (2.0 * self.exponent - 2.0) * (self.exponent * series + x * slope)

    def falls_at(self) -> float | None:
        """Place x where the stiffness falls most, by more than its error, or is negative; None if it rises."""
        x = _places()
        stiffness = self.stiffness(x)
        columns = np.stack([self._unit(j).stiffness(x) for j in range(self.degree + 1)], axis=1)
        largest = float(stiffness.max())
        allowed = np.minimum(_SIGMAS * self._deviation(columns, x), _MOST_FALL * largest) + _LEVEL * largest
        excess = np.maximum.accumulate(np.maximum(stiffness, 0.0)) - stiffness - allowed
        return float(x[np.argmax(excess)]) if np.any((excess > 0.0) | (stiffness <= 0.0)) else None

    def _unit(self, j: int) -> ForceFit:
        unit = np.zeros(j + 1)
        unit[j] = 1.0
        return ForceFit(1.0, 1.0, self.exponent, unit, self.residual, self.covariance)

    def _deviation(self, columns: Array, x: Array) -> Array:
        """Standard deviation of a linear function of the coefficients, given by its columns."""
        if len(self.covariance) > columns.shape[1]:
            # The derivative with respect to the exponent, to leading order for the stiffness.
            free = columns @ self.coefficients * 2.0 * np.log(x)
            columns = np.column_stack([columns, free])
        return np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", columns, self.covariance, columns), 0.0))


class _Trial(NamedTuple):
    """A fit before it is chosen: minus twice its log-likelihood by cross-validation, and what defines it."""

    score: float
    size: int
    exponent: float
    degree: int
    weights: Array
    free: bool


def fit_force(depth: Array, force: Array, exponent: float | None = None) -> ForceFit:
    """Fit the force of rows in any order, whose largest depth has a positive force.

    Parameters
    ----------
    depth, force : array, shape (n,)
        Depths [m] > 0 and forces [N], n >= 10.
    exponent : float, optional
        Exponent p; found from the data if left out.

    Notes
    -----
    The exponent (1, 1.5, 2 or fitted), the degree, and whether the noise is constant or proportional to the force,
    have the largest likelihood of rows that are left out one by one; a simpler fit of nearly the same likelihood is
    preferred. Where the stiffness of the likeliest fit falls, the likeliest one that rises replaces it if it is nearly
    as close to the data.
    """
    deepest = int(np.argmax(depth))
    unit, scale = float(depth[deepest]), float(force[deepest])
    x, y = np.sqrt(depth / unit), force / scale

    def rank(trial: _Trial) -> float:
        return trial.score + _PENALTY * trial.size

    trials = sorted(_trials(x, y, exponent), key=rank)
    fits = (_solved(x, y, trial, unit, scale) for trial in trials)
    first = chosen = next(fits)
    if first.falls_at() is not None:
        rising = next((fit for fit in fits if fit.falls_at() is None), first)
        chosen = rising if rising.misfit <= max(_SLACK * first.misfit, _SMOOTHING) else first
    near = [trial for trial in trials[:_RIVALS] if rank(trial) <= rank(trials[0]) + _NEARLY]
    rivals = [_solved(x, y, trial, unit, scale) for trial in near]
    places = _places()
    spread = max(float(np.max(np.abs(chosen.force(places) - rival.force(places)))) for rival in rivals)
    return replace(chosen, spread=spread)


def _places() -> Array:
    return np.linspace(0.0, 1.0, _PLACES + 1)[1:]


def _trials(x: Array, y: Array, exponent: float | None) -> Iterator[_Trial]:
    most = max(min(_MOST_DEGREE, x.size // _ROWS - 1), 0)
    for weights in (np.ones(x.size), 1.0 / np.maximum(np.abs(y), _LEAST_FORCE)):
        for p in _EXPONENTS if exponent is None else (exponent,):
            q, _ = np.linalg.qr(weights[:, None] * _force_columns(x, p, most))
            parts = q * (q.T @ (weights * y))
            residual = (weights * y)[:, None] - np.cumsum(parts, axis=1)
            leverage = np.cumsum(q * q, axis=1)
            for degree in range(most + 1):
                score = _score(residual[:, degree], leverage[:, degree], weights)
                yield _Trial(score, degree + 1, p, degree, weights, False)
        if exponent is None:
            for degree in range(min(_FREE_DEGREE, most) + 1):
                p = _fitted_exponent(x, y, weights, degree)
                if _LOW < p < _HIGH:
                    residual, leverage = _residual(x, y, weights, p, degree, free=True)
                    yield _Trial(_score(residual, leverage, weights), degree + 2, p, degree, weights, True)


def _score(residual: Array, leverage: Array, weights: Array) -> float:
    """Minus twice the log-likelihood of rows that are left out one by one."""
    left_out = np.mean((residual / np.maximum(1.0 - leverage, 1e-3)) ** 2)
    return residual.size * math.log(max(left_out, _ROUNDING**2)) - 2.0 * float(np.sum(np.log(weights)))


def _force_columns(x: Array, exponent: float, degree: int) -> Array:
    return x[:, None] ** (2.0 * exponent) * chebyshev.chebvander(2.0 * x - 1.0, degree)


def _with_exponent(x: Array, y: Array, weights: Array, exponent: float, degree: int) -> tuple[Array, Array, Array]:
    """Weighted columns with the derivative with respect to the exponent as the last, coefficients, and residuals."""
    columns = weights[:, None] * _force_columns(x, exponent, degree)
    coefficients = np.linalg.lstsq(columns, weights * y, rcond=None)[0]
    fitted = columns @ coefficients
    residual: Array = weights * y - fitted
    return np.column_stack([columns, 2.0 * np.log(x) * fitted]), np.asarray(coefficients, np.float64), residual


def _fitted_exponent(x: Array, y: Array, weights: Array, degree: int) -> float:
    """Exponent of the least squares, by Gauss-Newton; NaN where it does not converge."""
    p, step = 1.5, math.inf
    for _ in range(50):
        columns, _, residual = _with_exponent(x, y, weights, p, degree)
        step = float(np.linalg.lstsq(columns, residual, rcond=None)[0][-1])
        p = min(max(p + step, 0.5 * _LOW), 2.0 * _HIGH)
        if abs(step) < 1e-13:
            return p
    return p if abs(step) < 1e-6 else math.nan


def _residual(x: Array, y: Array, weights: Array, p: float, degree: int, *, free: bool) -> tuple[Array, Array]:
    columns, _, residual = _with_exponent(x, y, weights, p, degree)
    q, _ = np.linalg.qr(columns if free else columns[:, :-1])
    return residual, np.sum(q * q, axis=1)


def _solved(x: Array, y: Array, trial: _Trial, unit: float, scale: float) -> ForceFit:
    columns, coefficients, residual = _with_exponent(x, y, trial.weights, trial.exponent, trial.degree)
    if not trial.free:
        columns = columns[:, :-1]
    inverse = np.linalg.pinv(columns)
    leverage = np.einsum("ij,ji->i", columns, inverse)
    spread = inverse * (residual / np.maximum(1.0 - leverage, 1e-3))
    return ForceFit(unit, scale, trial.exponent, coefficients, residual / trial.weights, spread @ spread.T)
