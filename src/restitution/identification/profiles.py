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
    fit = rescued(problem, fit, best.coordinates, unseen, estimation.loss, k, _TOLERANCE)
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
    unseen = hidden(standard_error, problem.n_parameters)
    slope = sign * covariance[:, k] / covariance[k, k]
    walked: list[tuple[float, float]] = []
    last, before = _Point(0.0, 0.0, origin), None
    step, flat = min(_LONGEST, quantile * float(standard_error[k])), 0.0

    def at(distance: float, guess: Array, wakened: Array | None = None) -> _Point:
        """Point of the profile; with descents from other hidden coordinates of some point if it is outside."""
        nonlocal best
        guess = np.clip(guess, problem.low, problem.high)
        guess[k] = origin[k] + sign * distance
        fit = minimise(problem, guess, estimation.loss, k, _TOLERANCE)
        if wakened is not None and not fit.cost - least < quantile**2:
            fit = rescued(problem, fit, wakened, unseen, estimation.loss, k, _TOLERANCE)
        if fit.cost < best.cost:
            best = fit
        walked.append((float(guess[k]), fit.cost - least))
        return _Point(distance, math.sqrt(max(fit.cost - least, 0.0)), fit.coordinates)

    room = abs(bound - float(origin[k]))
    while True:
        if last.distance >= min(flat + FAR, 0.999 * room):
            return open_end, walked, best
        distance = min(last.distance + step, flat + FAR, 0.999 * room)
        # The line of a hidden coordinate is meaningless, so that no coordinate goes far along it.
        line = slope * distance if before is None else last.toward(before, distance)
        new = at(distance, last.coordinates + np.clip(line, -_LONGEST, _LONGEST), last.coordinates)
        if not new.root < quantile:
            break
        before, last, width = last, new, step
        if last.root < _FLAT:
            flat, step = last.distance, max(_GROWTH * width, 0.02)
            continue
        # The next step goes to the end if the root of the excess is a straight line.
        pace = (last.root - before.root) / (last.distance - before.distance)
        step = min(_LONGEST, 1.05 * (quantile - last.root) / pace if pace > 0.0 else _LONGEST)
        step = max(step, 0.02 * _LONGEST * min(1.0, float(standard_error[k])))
    # Bracketed: the secant rule, kept within by halving.
    inner, outer = last, new
    for n in range(_ROUNDS):
        if outer.root - quantile < _CLOSE:
            break
        share = (quantile - inner.root) / (outer.root - inner.root) if math.isfinite(outer.root) else 0.5
        share = min(max(share + 1e-3, 0.02), 0.98) if n % 4 != 3 else 0.5
        distance = inner.distance + share * (outer.distance - inner.distance)
        line = inner.toward(outer, distance) if math.isfinite(outer.root) else 0.0
        new = at(distance, inner.coordinates + line, inner.coordinates)
        if abs(new.root - quantile) < _CLOSE:
            outer = new
            break
        if new.root < quantile:
            inner = new
        else:
            outer = new
    return float(origin[k] + sign * outer.distance), walked, best


class _Point(NamedTuple):
    """Point of one side of a profile."""

    distance: float
    root: float  # of the excess
    coordinates: Array

    def toward(self, other: _Point, distance: float) -> Array:
        """Change of the coordinates to a distance, along the line through another point."""
        share = (distance - self.distance) / (other.distance - self.distance)
        return share * (other.coordinates - self.coordinates)
