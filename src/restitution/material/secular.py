"""Roots s = -lambda of a Carson transform S(s) = a + b s + sum E_k s/(s + lambda_k), by bracketing in log time."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.errors import InputError

Array = NDArray[np.float64]

_EPS = float(np.finfo(np.float64).eps)
_LARGEST_LOG = 600.0
_MAX_ITERATIONS = 120


class SecularRoots(NamedTuple):
    """Roots of S(-lambda) = 0 in ascending order of lambda, and the terms of the residues, free of cancellation."""

    times: Array  # 1/lambda [s], shape (n_root,)
    slopes: Array  # lambda S'(-lambda), positive, in the unit of S, shape (n_root,)
    terms: Array  # lambda/(lambda - lambda_k), that is s/(s + lambda_k) at s = -lambda, shape (n_root, n_pole)


def log_ratios(upper: Array, lower: Array) -> Array:
    """Logarithm of upper/lower, to full relative accuracy also where the two almost agree."""
    ratio = upper / lower
    near = np.abs(ratio - 1.0) < 0.5
    logs = np.where(near, np.log1p(np.where(near, (upper - lower) / lower, 0.0)), np.log(ratio))
    return np.clip(logs, -_LARGEST_LOG, _LARGEST_LOG)


def secular_roots(constant: float, viscosity: float, weights: Array, times: Array) -> SecularRoots:
    """Roots lambda of a - b lambda + sum E_k lambda/(lambda - lambda_k) = 0, with tau_k = 1/lambda_k descending.

    There is one root below the first pole if a > 0 (a may be negative), one between each two neighbours, and one above
    the last pole if b > 0 or a + sum E_k < 0. The poles are given as times, as two neighbouring floats may have the
    same reciprocal.

    The unknown is the offset u = ln(lambda/lambda_o) from the nearest pole lambda_o, as in LAPACK's dlaed4 but in log
    time. A root that rounds to its pole still has an offset of full relative accuracy. In the variable
    y = 1/expm1(|u|) the term of that pole is linear, every other one is a hyperbola, and the sum is concave. So each
    evaluation yields two bounds: Newton's step from below, and from above the step of a model that keeps the weight of
    the nearest pole and bends all others into one at the far end of the interval.
    """
    n_pole = times.size
    found: SecularRoots | None = SecularRoots(np.empty(0), np.empty(0), np.empty((0, n_pole)))
    if n_pole == 0 and constant > 0 and viscosity > 0:
        found = SecularRoots(np.array([viscosity / constant]), np.array([constant]), np.empty((1, 0)))
    elif n_pole > 0:
        with np.errstate(all="ignore"):
            logs = log_ratios(times[:, None], times[None, :]) if n_pole > 1 else np.zeros((1, 1))
            brackets = _brackets(constant, viscosity, weights, 1.0 / times, logs)
            if brackets.size:
                found = _solve(constant, viscosity, weights, times, logs, brackets)
    if found is None or not (np.isfinite(found.times).all() and np.isfinite(found.slopes).all()):
        raise InputError("moduli", wanted="must not differ by more than a factor of about 1e200 within a material")
    return found


def _brackets(constant: float, viscosity: float, weights: Array, rates: Array, logs: Array) -> Array:
    """Index of the nearest pole of each root, the side where the root lies, bounds of y, y at the far end."""
    total, last = float(weights.sum()), rates.size - 1
    parts = [np.empty((5, 0))]
    if constant > 0:
        # Past the far end u = -inf (y = 0) every hyperbola bends at y <= -1.
        lowest, highest = constant / (total + viscosity * rates[0]), constant / weights[0]
        parts.append(np.array([[0.0], [-1.0], [lowest], [highest], [-1.0]]))
    if last > 0:
        gap = np.diagonal(logs, 1)
        middle = 1.0 / np.expm1(0.5 * gap)
        value = constant - viscosity * rates[:-1] * (1.0 + 1.0 / middle)
        value -= ((1.0 + middle)[:, None] / (np.expm1(logs[:-1]) * middle[:, None] - 1.0)) @ weights
        right = value > 0
        sides, ends = np.where(right, -1.0, 1.0), 1.0 / np.expm1(gap)
        parts.append(np.array([np.arange(last) + right, sides, middle, np.full(last, np.inf), ends]))
    if viscosity > 0 or constant + total < 0:
        drag = viscosity * rates[-1]
        level = constant + total - drag
        lowest, highest = (_positive_root(square, level, drag) for square in (total, weights[-1]))
        parts.append(np.array([[last], [1.0], [lowest], [highest], [0.0 if viscosity > 0 else -1.0]]))
    return np.hstack(parts)


def _positive_root(square: float, linear: float, less: float) -> float:
    """Positive root of square y^2 + linear y - less = 0."""
    root = math.sqrt(linear * linear + 4.0 * square * less)
    return 2.0 * less / (linear + root) if linear > 0 else (root - linear) / (2.0 * square)


def _solve(
    constant: float, viscosity: float, weights: Array, times: Array, logs: Array, brackets: Array
) -> SecularRoots | None:
    origin = brackets[0].astype(np.intp)
    side, lowest, highest, far = brackets[1:]
    upward = side > 0
    theta = side[:, None] * logs[origin]
    decay = np.expm1(theta)
    growth = np.exp(theta)
    fixed = np.where(upward, 1.0, 0.0)[:, None]
    linear = np.where(upward[:, None], 1.0, growth)
    own = weights[origin]
    drag = viscosity / times[origin]
    offset = side * constant
    y = lowest
    tolerance = 4.0 * _EPS
    for _ in range(_MAX_ITERATIONS):
        across = y[:, None]
        denominator = 1.0 - decay * across
        terms = (fixed + linear * across) / denominator
        value = offset + terms @ weights
        slope = (growth / denominator / denominator) @ weights
        size = abs(constant) + np.abs(terms) @ weights
        if viscosity > 0:
            shifted = np.where(upward, y, 1.0 + y)
            pull = np.where(upward, -(1.0 + 1.0 / y), y / shifted) * drag
            value = value + pull
            size += np.abs(pull)
            slope = slope + drag / shifted / shifted
        done = np.abs(value) <= tolerance * size
        if done.all():
            break
        reach = y - far
        lean = value + slope * reach
        root = np.sqrt(np.maximum(lean * lean - 4.0 * own * value * reach, 0.0))
        steep = lean > 0
        step = np.where(steep, -2.0 * value * reach, root - lean) / np.where(steep, lean + root, 2.0 * own)
        rising = value <= 0
        lowest = np.maximum(np.maximum(lowest, y - value / slope), np.where(rising, y, 0.0))
        highest = np.where(rising, highest, np.minimum(highest, y))
        # A model made far from the root is noisy, so its bound holds for one step only.
        target = np.minimum(highest, np.maximum(y + step, lowest))
        target = np.where(target < 4.0 * lowest, target, np.sqrt(lowest) * np.sqrt(target))
        done |= np.abs(target - y) <= 2.0 * _EPS * y
        if done.all():
            break
        y = np.where(done, y, target)
    else:
        return None
    stretch = np.where(upward, y / (1.0 + y), 1.0 + 1.0 / y)
    terms = side[:, None] * terms
    roots = times[origin] * stretch
    return SecularRoots(roots, _slopes(constant, viscosity, float(weights.sum()), roots, terms), terms)


def _slopes(constant: float, viscosity: float, total: float, roots: Array, terms: Array) -> Array:
    """Slope lambda S'(-lambda) at each root as a product over all poles and all other roots.

    The sum over the poles would be right for exact roots. Where a weak pole lies within u of a root of the rest, two
    roots straddle it. Their different rounding errors would change the sum of the residues by up to eps/u. The product
    belongs exactly to an S whose weights differ from the given ones by rounding (Gu and Eisenstat, SIAM J. Matrix
    Anal. Appl. 15 (1994) 1266).
    """
    n_root, n_pole = terms.shape
    factors = np.ones((n_root, max(n_root, n_pole)))
    factors[:, :n_pole] = terms
    if n_root > 1:
        index = np.arange(n_root)
        # Pole next to each root j on the side of root i: their differences from it have opposite signs.
        lower = index - 1 if constant > 0 else index
        between = np.where(index[None, :] > index[:, None], lower[:, None] + 1, lower[:, None])
        np.fill_diagonal(between, 0)
        inverse = 1.0 / terms
        apart = (roots[:, None] / roots) * inverse[index, between] - inverse[index[:, None], between]
        np.fill_diagonal(apart, 1.0)
        factors[:, :n_root] *= apart
    scale = viscosity / roots if viscosity > 0 else constant + total
    return np.abs(scale * factors.prod(axis=1))
