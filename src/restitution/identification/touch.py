"""First touch of a measured indentation, and straight lines that replace its depth."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.errors import InputError
from restitution.indentation.history import without_collinear

Array = NDArray[np.float64]

# Search for first touch: smallest and largest number of points of the approach, rounds, and depths in each of them.
_FEWEST, _MOST, _ROUNDS, _PLACES = 12, 160, 3, 40
# Powers of the force over the depth from touch, relative to an elastic contact; relaxation lowers the power.
_POWERS = (1.0, 0.9, 0.8, 0.65)
# The later rounds use this share of the approach beyond touch.
_NEAR = 0.4
# A slope of the baseline counts if it exceeds this multiple of its standard error.
_DRIFT = 4.0
# A depth of at most so many straight lines is exact. Otherwise: number of first lines, and of rounds of halving.
_FEW, _LINES, _HALVINGS = 64, 24, 6
# A line is halved if the bend in its middle exceeds this multiple of its standard error.
_BEND = 3.0
# Harmless error of a depth over the range of the depth.
_HARMLESS = 5e-5


class Touch(NamedTuple):
    """First touch."""

    depth: float
    noise: float  # standard deviation of the force about the fit


def first_touch(time: Array, depth: Array, force: Array, exponent: float) -> Touch:
    """Depth at first touch from the approach: F = b0 + b1 t + A (d - c)^q, least squares over a grid of c and q.

    The exponent is that of F over d of an elastic contact.
    """
    # The force relaxes while the depth rests at its largest value.
    last = int(np.argmax(depth >= depth.max() - 0.02 * np.ptp(depth))) + 1
    first = int(np.argmin(depth[:last]))
    points = np.arange(first, last)
    if points.size < _FEWEST:
        raise InputError("depth", points.size, f"has too few points in the approach; it needs at least {_FEWEST}")
    powers = exponent * np.array(_POWERS)
    peak = float(depth[last - 1])
    lowest, highest = float(depth[min(first + 5, last - 1)]), peak - 0.03 * (peak - float(depth[first]))
    low, high, found = lowest, highest, Touch(lowest, 0.0)
    for _ in range(_ROUNDS):
        used = points[:: max(1, points.size // _MOST)]
        places = np.linspace(low, high, _PLACES)
        found = _best(time[used], depth[used], force[used], places, powers)
        # Near touch the material has hardly relaxed, and the force is a power of the depth.
        size, spacing = peak - found.depth, float(places[1] - places[0])
        near = first + np.flatnonzero(np.abs(depth[first:last] - found.depth + 0.5 * size) < (0.5 + _NEAR) * size)
        points = near if near.size >= _FEWEST else points
        low = max(lowest, found.depth - max(0.3 * size, 1.5 * spacing))
        high = min(highest, found.depth + max(0.2 * size, 1.5 * spacing))
    return found


def _best(t: Array, d: Array, f: Array, places: Array, powers: Array) -> Touch:
    """Touch with the smallest sum of squares."""
    lines, _ = np.linalg.qr(np.stack([np.ones(t.size), t - t[0]], axis=1))
    rise = np.maximum(d - places[:, None], 0.0) / (d[-1] - d[0])
    shapes = np.concatenate([rise**power for power in powers])
    within, own = shapes @ lines, f @ lines
    along = shapes @ f - within @ own
    size = np.einsum("cn,cn->c", shapes, shapes) - np.einsum("cj,cj->c", within, within)
    gain = np.where(along > 0.0, along**2 / np.maximum(size, 1e-12 * size.max()), -np.inf)
    best = int(np.argmax(gain))
    if not np.isfinite(gain[best]):
        raise InputError("force", wanted="does not rise with the depth of the approach; is a push positive?")
    rest = f @ f - own @ own - gain[best]
    return Touch(float(places[best % places.size]), float(np.sqrt(max(rest, 0.0) / max(t.size - 5, 1))))


def baseline(time: Array, force: Array, free: NDArray[np.bool_]) -> Array:
    """Baseline of the force from the points without contact: a constant, and a slope that is beyond its error."""
    if np.count_nonzero(free) < 2:  # the curve is refused after its first touch is known
        return np.full(force.shape, force[0])
    t, f = time[free] - time[free].mean(), force[free]
    spread = float(t @ t)
    slope = float(t @ f) / spread
    error = float(np.std(f - slope * t)) / math.sqrt(spread)
    return f.mean() + (slope if abs(slope) > _DRIFT * error else 0.0) * (time - time[free].mean())


class Lines(NamedTuple):
    """Points joined by straight lines that stand for a measured depth."""

    time: Array
    depth: Array
    noise: float  # standard deviation of the depth about them; 0 where they are exact


def straight_lines(time: Array, depth: Array, kinks: Array) -> Lines:
    """Straight lines for a measured depth.

    Lines between some of the points where there is hardly any noise. Else those of least squares, which are halved
    until none of them hides a bend that is larger than its standard error; `kinks` are times at which some end.
    """
    exact = without_collinear(time, depth)
    if exact[0].size <= _FEW:
        return Lines(*exact, 0.0)
    share = (time[1:-1] - time[:-2]) / (time[2:] - time[:-2])
    beside = depth[1:-1] - depth[:-2] - share * (depth[2:] - depth[:-2])
    noise = float(np.median(np.abs(beside) / np.sqrt(1.0 + share**2 + (1.0 - share) ** 2))) / 0.6745
    harmless = _HARMLESS * float(np.ptp(depth))
    if noise <= harmless:
        places = _corners(time, depth, harmless)
        return Lines(time[places], depth[places], harmless)
    smooth = np.convolve(depth, np.full(5, 0.2), mode="same")[2:-2]
    top = time[2 + int(np.argmax(smooth))]
    knots = np.unique(np.concatenate([np.linspace(time[0], time[-1], _LINES + 1), kinks, [top]]))
    knots = _occupied(knots, time)
    values = _fit(knots, time, depth)
    for _ in range(_HALVINGS):
        place = np.clip(np.searchsorted(knots, time, side="right") - 1, 0, knots.size - 2)
        share = (time - knots[place]) / (knots[place + 1] - knots[place])
        bump = 1.0 - np.abs(2.0 * share - 1.0)
        off = depth - np.interp(time, knots, values)
        bends = np.bincount(place, bump * off, knots.size - 1)
        errors = noise * np.sqrt(np.bincount(place, bump * bump, knots.size - 1))
        bent = np.flatnonzero(np.abs(bends) > _BEND * np.maximum(errors, 1e-300))
        finer = _occupied(np.sort(np.append(knots, 0.5 * (knots[bent] + knots[bent + 1]))), time)
        if finer.size == knots.size:
            break
        knots, values = finer, _fit(finer, time, depth)
    off = depth - np.interp(time, knots, values)
    return Lines(knots, values, float(np.sqrt(np.mean(off**2))))


def rising_and_falling(lines: Lines, touch: float) -> Lines:
    """The same lines, where the depth rises to its peak and falls from there on, without reversals by noise.

    Before touch the depth may have any course; a second approach is refused.
    """
    from scipy.optimize import isotonic_regression

    time, depth = lines.time, lines.depth
    peak = int(np.argmax(depth))
    outside = np.flatnonzero(depth[: peak + 1] < touch)
    first = int(outside[-1]) if outside.size else 0
    found = depth.copy()
    found[first : peak + 1] = isotonic_regression(depth[first : peak + 1]).x
    found[peak:] = isotonic_regression(depth[peak:], increasing=False).x
    allowed = max(5.0 * lines.noise, 20.0 * _HARMLESS * float(np.ptp(depth)))
    off = np.where(np.maximum(found, depth) > touch, np.abs(found - depth), 0.0)
    if off.max() > allowed:
        wanted = "has more than one approach; cut the record so that it holds one approach and one retraction"
        raise InputError("depth", wanted=f"{wanted}, near time = {time[int(np.argmax(off))]:.6g} s")
    above = (found <= touch) & (depth <= touch)
    return Lines(time, np.where(above, depth, found), lines.noise)


def _corners(time: Array, depth: Array, allowed: float) -> NDArray[np.intp]:
    """Places of points whose straight lines are nowhere further than this from the others."""
    places = np.array([0, time.size - 1])
    while True:
        off = np.abs(depth - np.interp(time, time[places], depth[places]))
        worst = [low + int(np.argmax(off[low : high + 1])) for low, high in pairwise(places)]
        more = [place for place in worst if off[place] > allowed]
        if not more:
            return places
        places = np.sort(np.append(places, more))


def _occupied(knots: Array, time: Array) -> Array:
    """Knots without those that leave fewer than three points on a line."""
    kept = [0]
    places = np.searchsorted(time, knots)
    for n in range(1, knots.size - 1):
        if places[n] - places[kept[-1]] >= 3 and places[-1] - places[n] >= 3:
            kept.append(n)
    return knots[[*kept, knots.size - 1]]


def _fit(knots: Array, time: Array, depth: Array) -> Array:
    """Values at the knots of the straight lines of least squares."""
    from scipy.linalg import solveh_banded

    place = np.clip(np.searchsorted(knots, time, side="right") - 1, 0, knots.size - 2)
    share = (time - knots[place]) / (knots[place + 1] - knots[place])
    bands = np.zeros((2, knots.size))
    right = np.zeros(knots.size)
    for offset, weight in ((0, 1.0 - share), (1, share)):
        bands[1] += np.bincount(place + offset, weight * weight, knots.size)
        right += np.bincount(place + offset, weight * depth, knots.size)
    bands[0, 1:] = np.bincount(place, share * (1.0 - share), knots.size - 1)
    bands[1] += 1e-9 * bands[1].max()
    return solveh_banded(bands, right + 1e-9 * bands[1].max() * np.interp(knots, time, depth))
