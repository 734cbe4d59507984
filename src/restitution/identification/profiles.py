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
        side = _side(estimation, k, sign, standard_error, covariance, quantile, best)
        points += side.walked
        ends.append(side.end)
        if unseen.size and math.isfinite(side.end):
            far, wary = _FAR_ERRORS * abs(side.end - points[0][0]), _WARY * quantile
            side = _side(estimation, k, sign, standard_error, covariance, wary, side.best, side, far)
            points += side.walked
            ends[-1] = ends[-1] if math.isnan(side.end) else side.end
        best = side.best
    points.sort()
    z, excess = np.array(points).T
    return LikelihoodProfile(z, np.maximum(excess, 0.0), ends[0], ends[1], best)


class _Point(NamedTuple):
    """Point of one side of a profile."""

    distance: float
    root: float  # of the excess
    coordinates: Array

    def toward(self, other: _Point, distance: float) -> Array:
        """Change of the coordinates to a distance, along the line through another point."""
        share = (distance - self.distance) / (other.distance - self.distance)
        return share * (other.coordinates - self.coordinates)

    def step(self, before: _Point, quantile: float) -> float:
        """Step to a root of the excess if that is a straight line."""
        pace = (self.root - before.root) / (self.distance - before.distance)
        return min(_LONGEST, 1.05 * (quantile - self.root) / pace if pace > 0.0 else _LONGEST)


class _Side(NamedTuple):
    """One side of a profile."""

    end: float  # of the interval; NaN if it is nearer than asked
    walked: list[tuple[float, float]]
    best: Fit
    last: _Point | None = None  # at the end
    before: _Point | None = None
    flat: float = 0.0  # distance to which the profile is flat


def hidden(standard_errors: Array, n_parameters: int) -> NDArray[np.intp]:
    """Parameters whose size the data hardly show at the best fit, so that linear estimates of errors fail."""
    return np.flatnonzero(standard_errors[:n_parameters] > _HIDDEN)


def _side(
    estimation: Estimation, k: int, sign: float, standard_error: Array, covariance: Array, quantile: float, best: Fit,
    known: _Side | None = None, beyond: float = 0.0,
) -> _Side:  # fmt: skip
    """End of the interval on one side, the points of the profile, and the best fit among them.

    The walk goes on from a known end. An end that is nearer than the distance `beyond` is not searched for.
    """
    problem, least = estimation.problem, estimation.fit.cost
    origin = estimation.fit.coordinates
    bound = float(problem.low[k] if sign < 0 else problem.high[k])
    open_end = sign * math.inf
    unseen = hidden(standard_error, problem.n_parameters)
    slope = sign * covariance[:, k] / covariance[k, k]
    walked: list[tuple[float, float]] = []
    last, before, flat = _Point(0.0, 0.0, origin), None, 0.0
    step = min(_LONGEST, quantile * float(standard_error[k]))
    if known is not None and known.last is not None and known.before is not None:
        last, before, flat = known.last, known.before, known.flat
        step = last.step(before, quantile)

    def at(distance: float, guess: Array, wakened: Array | None = None) -> _Point:
        """Point of the profile; if it is outside, also by descents from other hidden coordinates of some point."""
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
            return _Side(open_end, walked, best)
        distance = min(last.distance + step, flat + FAR, 0.999 * room)
        # The line of a hidden coordinate is meaningless, so that no coordinate goes far along it.
        line = slope * distance if before is None else last.toward(before, distance)
        new = at(distance, last.coordinates + np.clip(line, -_LONGEST, _LONGEST), last.coordinates)
        if not new.root < quantile:
            if distance <= beyond:
                return _Side(math.nan, walked, best)
            break
        before, last, width = last, new, step
        if last.root < _FLAT:
            flat, step = last.distance, max(_GROWTH * width, 0.02)
            continue
        step = max(last.step(before, quantile), 0.02 * _LONGEST * min(1.0, float(standard_error[k])))
    # Bracketed by two least sums: the secant rule, kept within by halving, from the line between their coordinates.
    inner, outer = last, new
    for n in range(_ROUNDS):
        if outer.root - quantile < _CLOSE:
            break
        share = (quantile - inner.root) / (outer.root - inner.root) if math.isfinite(outer.root) else 0.5
        share = min(max(share + 1e-3, 0.02), 0.98) if n % 4 != 3 else 0.5
        distance = inner.distance + share * (outer.distance - inner.distance)
        line = inner.toward(outer, distance) if math.isfinite(outer.root) else 0.0
        new = at(distance, inner.coordinates + line)
        if abs(new.root - quantile) < _CLOSE:
            outer = new
            break
        if new.root < quantile:
            inner = new
        else:
            outer = new
    end = float(origin[k] + sign * outer.distance) if outer.distance >= beyond else math.nan
    return _Side(end, walked, best, outer, last, flat)
