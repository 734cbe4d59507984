"""Roots of the secular equation of a Prony series, by bracketing in log time.

A relaxation function a + b delta(t) + sum E_k exp(-lambda_k t) has the Carson transform

    S(s) = a + b s + sum E_k s/(s + lambda_k),

which grows strictly between its poles, so its zeros s = -lambda are real, negative and interlace with the poles.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_EPS = float(np.finfo(np.float64).eps)
_LARGEST_LOG = 600.0
_MAX_ITERATIONS = 120


class SecularRoots(NamedTuple):
    """Roots of S(-lambda) = 0 with what residues at them need, none of it spoilt by cancellation.

    Attributes
    ----------
    rates
        Roots lambda [1/s], shape (n_root,).
    slopes
        lambda S'(-lambda), positive, in the unit of S, shape (n_root,).
    terms
        lambda/(lambda - lambda_k), the value of s/(s + lambda_k) at s = -lambda, shape (n_root, n_pole).
    """

    rates: Array
    slopes: Array
    terms: Array


def log_ratios(upper: Array, lower: Array) -> Array:
    """Logarithm of upper/lower, to full relative accuracy also where the two almost agree."""
    ratio = upper / lower
    near = np.abs(ratio - 1.0) < 0.5
    return np.where(near, np.log1p(np.where(near, (upper - lower) / lower, 0.0)), np.log(ratio))


def secular_roots(constant: float, viscosity: float, weights: Array, rates: Array) -> SecularRoots:
    """Roots lambda of a - b lambda + sum E_k lambda/(lambda - lambda_k) = 0.

    Each root is found as the offset u = ln(lambda/lambda_o) from its nearest pole lambda_o, through the unknown
    y = 1/expm1(|u|), in which the pole's own term is linear and every other one a hyperbola: LAPACK's dlaed4 in log
    time. So a root that float64 cannot tell from its pole still has an offset of full relative accuracy. One
    evaluation yields two bounds, as the function is concave in y: Newton's step from below, and from above the step
    of the model that keeps the nearest pole's weight and bends all others into one at the far end of the interval.

    Parameters
    ----------
    constant
        a, value at s = 0. May be negative (for S less a constant).
    viscosity
        b >= 0.
    weights
        E_k > 0, shape (n_pole,).
    rates
        lambda_k > 0, strictly ascending, shape (n_pole,).

    Returns
    -------
    SecularRoots
        Ascending: one root below the first pole if a > 0, one between each two neighbours, one above the last pole
        if b > 0 or a + sum E_k < 0.

    Examples
    --------
    >>> secular_roots(1.0, 0.0, np.array([3.0]), np.array([2.0])).rates
    array([0.5])
    """
    n_pole = rates.size
    if n_pole == 0:
        if constant > 0 and viscosity > 0:
            return SecularRoots(np.array([constant / viscosity]), np.array([constant]), np.empty((1, 0)))
        return SecularRoots(np.empty(0), np.empty(0), np.empty((0, 0)))

    total = float(weights.sum())
    below = constant > 0
    above = viscosity > 0 or constant + total < 0
    logs = np.clip(log_ratios(rates[None, :], rates[:, None]), -_LARGEST_LOG, _LARGEST_LOG)

    gap = np.diagonal(logs, 1)
    start = 1.0 / np.expm1(0.5 * gap)
    far = 1.0 / np.expm1(gap)
    origin = np.arange(n_pole - 1)
    side = np.ones(n_pole - 1)
    if n_pole > 1:
        decay = np.expm1(logs[:-1])
        middle = constant - viscosity * rates[:-1] * (1.0 + 1.0 / start)
        middle -= ((1.0 + start)[:, None] / (decay * start[:, None] - 1.0)) @ weights
        right = middle > 0
        origin = origin + right
        side[right] = -1.0
    ceiling = np.full(n_pole - 1, np.inf)
    if below:
        lowest = constant / (total + viscosity * rates[0])
        origin, side = np.concatenate(([0], origin)), np.concatenate(([-1.0], side))
        start, far = np.concatenate(([lowest], start)), np.concatenate(([-1.0], far))
        ceiling = np.concatenate(([constant / weights[0]], ceiling))
    if above:
        drag = viscosity * rates[-1]
        lowest = _positive_root(total, constant + total - drag, drag if viscosity > 0 else 0.0)
        highest = _positive_root(float(weights[-1]), constant + total - drag, drag if viscosity > 0 else 0.0)
        origin, side = np.concatenate((origin, [n_pole - 1])), np.concatenate((side, [1.0]))
        start = np.concatenate((start, [lowest]))
        far = np.concatenate((far, [0.0 if viscosity > 0 else -1.0]))
        ceiling = np.concatenate((ceiling, [highest]))
    if origin.size == 0:
        return SecularRoots(np.empty(0), np.empty(0), np.empty((0, n_pole)))
    return _solve(constant, viscosity, weights, rates, logs, origin, side, start, far, ceiling)


def _positive_root(square: float, linear: float, less: float) -> float:
    """Positive root of square y^2 + linear y - less = 0."""
    root = float(np.sqrt(linear * linear + 4.0 * square * less))
    return 2.0 * less / (linear + root) if linear > 0 else (root - linear) / (2.0 * square)


def _solve(
    constant: float,
    viscosity: float,
    weights: Array,
    rates: Array,
    logs: Array,
    origin: NDArray[np.int64],
    side: Array,
    start: Array,
    far: Array,
    ceiling: Array,
) -> SecularRoots:
    upward = side > 0
    theta = side[:, None] * logs[origin]
    decay = np.expm1(theta)
    growth = np.exp(theta)
    fixed = upward[:, None] * 1.0
    linear = np.where(upward[:, None], 1.0, growth)
    own = weights[origin]
    drag = viscosity * rates[origin]
    offset = side * constant
    lowest, highest, y = start, ceiling, start
    slope = denominator = np.empty(0)
    tolerance = (4.0 + weights.size) * _EPS
    for _ in range(_MAX_ITERATIONS):
        denominator = decay * y[:, None] - 1.0
        parts = ((fixed + linear * y[:, None]) / denominator) * weights
        value = offset - parts.sum(axis=1)
        size = abs(constant) + np.abs(parts).sum(axis=1)
        slope = (growth / denominator / denominator) @ weights
        if viscosity > 0:
            shifted = np.where(upward, y, 1.0 + y)
            pull = np.where(upward, -(1.0 + 1.0 / y), y / shifted) * drag
            value = value + pull
            size += np.abs(pull)
            slope = slope + drag / shifted / shifted
        reach = y - far
        lean = value + slope * reach
        root = np.sqrt(np.maximum(lean * lean - 4.0 * own * value * reach, 0.0))
        steep = lean > 0
        step = np.where(steep, -2.0 * value * reach, root - lean) / np.where(steep, lean + root, 2.0 * own)
        model = np.maximum(y + step, lowest)
        rising = value <= 0
        lowest = np.maximum(np.maximum(lowest, y - value / slope), np.where(rising, y, 0.0))
        highest = np.minimum(np.minimum(highest, model), np.where(rising, np.inf, y))
        target = np.where(highest < 4.0 * lowest, highest, np.sqrt(lowest) * np.sqrt(highest))
        done = (np.abs(value) <= tolerance * size) | (np.abs(target - y) <= 2.0 * _EPS * y)
        if done.all():
            break
        y = np.where(done, y, target)
    else:
        raise ArithmeticError("the secular equation was not solved within its bounded number of steps")
    stretch = np.where(upward, (1.0 + y) / y, y / (1.0 + y))
    terms = (-side)[:, None] * (fixed + linear * y[:, None]) / denominator
    return SecularRoots(rates[origin] * stretch, slope * y * (1.0 + y), terms)
