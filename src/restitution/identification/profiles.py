"""Profiles: the least sum of squares at each value of one unknown, and the interval from it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.identification.bands import FAR
from restitution.identification.estimation import Estimation, Fit, minimise, rescued

Array = NDArray[np.float64]

_LONGEST = 0.7
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
        end, walked, best = _side(estimation, k, sign, standard_error, covariance, quantile, best)
        if unseen.size and math.isfinite(end) and _flattens(estimation, k, end, walked, quantile, unseen):
            end, more, best = _side(estimation, k, sign, standard_error, covariance, _WARY * quantile, best)
            walked += more
        ends.append(end)
        points += walked
    points.sort()
    z, excess = np.array(points).T
    return LikelihoodProfile(z, np.maximum(excess, 0.0), ends[0], ends[1], best)


def _flattens(
    estimation: Estimation, k: int, end: float, walked: list[tuple[float, float]], quantile: float,
    unseen: NDArray[np.intp],
) -> bool:  # fmt: skip
    """Whether the profile is low at five errors, where that of a normal distribution is at 2.6 times the quantile."""
    problem, best = estimation.problem, estimation.fit
    z = float(best.coordinates[k])
    far = float(np.clip(z + _FAR_ERRORS * (end - z), problem.low[k], problem.high[k]))
    guess = best.coordinates.copy()
    guess[k] = far
    fit = minimise(problem, guess, estimation.loss, k, _TOLERANCE)
    fit = rescued(problem, fit, unseen, estimation.loss, k, _TOLERANCE)
    walked.append((far, fit.cost - best.cost))
    return fit.cost - best.cost < (_WARY * quantile) ** 2


def hidden(standard_errors: Array, n_parameters: int) -> NDArray[np.intp]:
    """Parameters whose size the data hardly show at the best fit, so that linear estimates of errors fail."""
    return np.flatnonzero(standard_errors[:n_parameters] > _HIDDEN)


def _side(
    estimation: Estimation, k: int, sign: float, standard_error: Array, covariance: Array, quantile: float, best: Fit
) -> tuple[float, list[tuple[float, float]], Fit]:
    """End of the interval on one side, the points of the profile, and the best fit among them."""
    problem, least = estimation.problem, estimation.fit.cost
    origin = estimation.fit.coordinates
    bound = float(problem.low[k] if sign < 0 else problem.high[k])
    open_end = sign * math.inf
    slope = covariance[:, k] / covariance[k, k]
    walked: list[tuple[float, float]] = []
    # Distance, root of the excess, and coordinates of the last two points.
    last, before = (0.0, 0.0, origin), None
    step, flat = min(_LONGEST, quantile * float(standard_error[k])), 0.0

    def at(distance: float) -> tuple[float, float, Array]:
        nonlocal best
        if before is None:
            guess = origin + slope * sign * distance
        else:
            share = (distance - last[0]) / (last[0] - before[0])
            guess = last[2] + share * (last[2] - before[2])
        guess = np.clip(guess, problem.low, problem.high)
        guess[k] = origin[k] + sign * distance
        fit = minimise(problem, guess, estimation.loss, k, _TOLERANCE)
        if not math.isfinite(fit.cost) and before is not None:
            guess = last[2].copy()
            guess[k] = origin[k] + sign * distance
            fit = minimise(problem, guess, estimation.loss, k, _TOLERANCE)
        if fit.cost - least >= quantile**2:
            fit = rescued(problem, fit, hidden(standard_error, problem.n_parameters), estimation.loss, k, _TOLERANCE)
        if fit.cost < best.cost:
            best = fit
        walked.append((float(origin[k] + sign * distance), fit.cost - least))
        return distance, math.sqrt(max(fit.cost - least, 0.0)), fit.coordinates

    room = abs(bound - float(origin[k]))
    while True:
        if last[0] >= min(flat + FAR, 0.999 * room):
            return open_end, walked, best
        distance = min(last[0] + step, flat + FAR, 0.999 * room)
        new = at(distance)
        if new[1] >= quantile:
            break
        before, last, width = last, new, step
        if last[1] < _FLAT:
            flat, step = last[0], max(_GROWTH * width, 0.02)
            continue
        # The next step goes to the end if the root of the excess is a straight line.
        pace = (last[1] - before[1]) / (last[0] - before[0])
        step = min(_LONGEST, 1.05 * (quantile - last[1]) / pace if pace > 0.0 else _LONGEST)
        step = max(step, 0.02 * _LONGEST * min(1.0, float(standard_error[k])))
    # Bracketed: the secant rule, kept within by halving.
    inner, outer = last, new
    for n in range(_ROUNDS):
        if outer[1] - quantile < _CLOSE:
            return float(origin[k] + sign * outer[0]), walked, best
        share = (quantile - inner[1]) / (outer[1] - inner[1]) if math.isfinite(outer[1]) else 0.5
        share = min(max(share + 1e-3, 0.02), 0.98) if n % 4 != 3 else 0.5
        new = at(inner[0] + share * (outer[0] - inner[0]))
        if abs(new[1] - quantile) < _CLOSE:
            return float(origin[k] + sign * new[0]), walked, best
        if new[1] > quantile:
            outer = new
        else:
            inner = new
    return float(origin[k] + sign * outer[0]), walked, best
