"""Prescribed histories: a depth or a force over time, as polynomials between knots."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.polynomial.polynomial import polyder, polyroots, polyval, polyvander
from numpy.typing import ArrayLike, NDArray

from restitution import checks
from restitution.checks import Array, finite, single, single_nonnegative, single_positive, whole, within
from restitution.errors import InputError
from restitution.quantities import HISTORY

UNITS = {"depth": HISTORY["indentation_depth"].unit, "force": HISTORY["force"].unit}

# A prescribed force is zero below this share of the largest one: rounding of a return to zero.
NO_FORCE = 1e-13
_DEGREE = 9
# Error of a fitted piece over the largest value, rounding of its slope, and the most pieces, or for each given time.
_FIT, _ROUNDING = 2e-14, 1e-13
_MOST_PIECES, _MOST_PARTS = 4096, 16
# Largest error of a piece by the rounding of its times, over the largest value.
_LATE = 1e-12
_FIRST_PIECES = 12
# Jumps of the value and its first derivatives that are rounding of a fit, over the largest value, in a piece.
_SMOOTH = (1e-13, 1e-11, 1e-9)
# Share of the duration below which a piece that does not fit holds a jump.
_SHORTEST = 2e-14
_JUMP_ADVICE = "a step is two points at the same time, in arrays"
_NODES = 0.5 - 0.5 * np.cos(math.pi * np.arange(_DEGREE + 1) / _DEGREE)
_BETWEEN = 0.5 * (_NODES[:-1] + _NODES[1:])

MOST_CYCLES = 10_000
"""Largest number of cycles of an oscillation: they take some seconds, and times are known to 1e-12 of a period."""


@dataclass(frozen=True, eq=False)
class History:
    """Prescribed depth [m] or force [N] over time, polynomials between knots.

    Made by `ramp`, `triangle`, `hold` and `sine_arch`, by `from_points` or by `from_function`.

    Attributes
    ----------
    knots : array, shape (m + 1,)
        Times [s]; two equal times are a jump.
    coefficients : array, shape (m, n)
        The value between knots i and i + 1 is `sum_j coefficients[i, j] u^j`, with u from 0 to 1.

    Examples
    --------
    >>> history = History.from_points([0.0, 1.0, 3.0], [0.0, 2e-6, 0.0])
    >>> print(history(2.0), history.rate(2.0))
    1e-06 -1e-06
    """

    knots: Array
    coefficients: Array

    def __post_init__(self) -> None:
        knots, coefficients = finite("knots", self.knots, "s"), finite("coefficients", self.coefficients)
        m, n = np.shape(coefficients) if np.ndim(coefficients) == 2 else (0, 0)
        if m < 1 or n < 2 or np.shape(knots) != (m + 1,) or np.any(np.diff(knots) < 0.0):
            rule = "must be m + 1 ascending times and a row of two or more numbers for each of the m pieces"
            raise InputError("knots, coefficients", rule=rule)
        object.__setattr__(self, "knots", knots)
        object.__setattr__(self, "coefficients", coefficients)

    @classmethod
    def from_points(cls, time: ArrayLike, values: ArrayLike, *, name: str = "values") -> History:
        """Straight lines through points.

        Parameters
        ----------
        time : array, shape (n,)
            Times [s], n >= 2, ascending; twice the same time is a jump.
        values : array, shape (n,)
            Depths [m] or forces [N].
        name : str
            Name of the values in messages.

        Raises
        ------
        InputError
            If these are not two columns of equal length with ascending times.
        """
        t = np.atleast_1d(finite("time", time, "s"))
        checks.instance("name", name, str, "must be the name of the values")
        v = np.atleast_1d(finite(name, values, UNITS.get(name, "")))
        if t.ndim != 1 or t.shape != v.shape or t.size < 2:
            rule = f"must be two columns of equal length >= 2, not of shapes {t.shape}, {v.shape}"
            raise InputError(f"time, {name}", rule=rule)
        steps = np.diff(t)
        if np.any(steps < 0.0):
            n = int(np.argmax(steps < 0.0)) + 1
            raise InputError("time", float(t[n]), f"must not be before {t[n - 1]:g} s", "s", index=(n,))
        jumps = steps == 0.0
        if np.any(jumps[1:] & jumps[:-1]):
            n = int(np.argmax(jumps[1:] & jumps[:-1]))
            raise InputError("time", float(t[n]), "must not stand three times; a step has two values", "s", index=(n,))
        if jumps[-1]:
            raise InputError("time", float(t[-1]), f"must be followed by a later one, as {name} has a step there", "s")
        t, v = without_collinear(t, v)
        return cls(t, np.column_stack([v[:-1], np.diff(v)]))

    @classmethod
    def from_function(cls, function: Callable[[Array], Any], time: ArrayLike, *, name: str = "values") -> History:
        """Return the function of time, fitted piecewise to 1e-13 of its largest value.

        Parameters
        ----------
        function : callable
            Maps an array of times [s] to depths [m] or forces [N].
        time : array, shape (n,)
            Times [s], n >= 2: the ends of the history, and the kinks of the function, at which it is exact then.
        name : str
            Name of the function in messages.

        Raises
        ------
        InputError
            If the function is not finite, or not smooth between the times.
        """
        t = np.unique(np.atleast_1d(finite("time", time, "s")))
        checks.function("function", function, "must be a function of time [s]", 1)
        checks.instance("name", name, str, "must be the name of the values")
        if t.size < 2:
            raise InputError("time", rule="must hold at least two times, between which the history is given")
        try:
            takes_arrays = np.shape(function(t[:2])) == (2,)
        except (TypeError, ValueError):
            takes_arrays = False
        for_arrays = function if takes_arrays else np.vectorize(function, otypes=[object])

        def values_at(times: Array) -> Array:
            return np.asarray(finite(name, for_arrays(times.ravel()), UNITS.get(name, ""))).reshape(times.shape)

        edges, at_times = _first_pieces(t), values_at(t)
        if np.any(edges[1:] <= edges[:-1]):
            raise InputError("time", rule="must not be so close together that no number lies between them")
        lows, highs = edges[:-1], edges[1:]
        fitted: list[tuple[Array, Array]] = []
        scale, pieces = float(np.max(np.abs(at_times))), 0
        while lows.size:
            width, ends = (highs - lows)[:, None], highs[:, None]
            values, exact = (
                values_at(np.minimum(lows[:, None] + width * nodes, ends)) for nodes in (_NODES, _BETWEEN)
            )
            scale = max(scale, float(np.max(np.abs(values))), float(np.max(np.abs(exact))))
            fit: Array = np.linalg.solve(polyvander(_NODES, _DEGREE), values.T).T.astype(np.float64, copy=False)
            error = np.max(np.abs(polyval(_BETWEEN, fit.T) - exact), axis=1)
            np.maximum.at(error, *_errors_at(t, at_times, lows, highs, fit))
            # Times far from zero have few digits left, and so have the values.
            digits = 2.0 * np.spacing(np.abs(highs))[:, None] / width
            late = np.minimum(np.ptp(digits * values, axis=1), _LATE * scale)
            good = error <= np.maximum(_FIT * scale, late)
            fitted.append((lows[good], fit[good]))
            pieces += int(good.sum())
            lows, highs = lows[~good], highs[~good]
            short = highs - lows <= _SHORTEST * (t[-1] - t[0])
            if np.any(short):
                raise InputError(name, rule=f"jumps near time = {lows[short][0]:.9g} s; {_JUMP_ADVICE}")
            if pieces + 2 * lows.size > max(_MOST_PIECES, _MOST_PARTS * t.size):
                rule = f"must be smooth between the given times, not so near time = {lows[0]:g} s"
                raise InputError(name, rule=rule)
            middles = _middles(t, lows, highs)
            lows, highs = np.concatenate([lows, middles]), np.concatenate([middles, highs])
        starts = np.concatenate([piece[0] for piece in fitted])
        order = np.argsort(starts)
        coefficients = np.concatenate([piece[1] for piece in fitted])[order]
        coefficients[np.abs(coefficients) < 1e-15 * scale] = 0.0
        # A slope of rounding, at a zero, would make another touch.
        level = (coefficients[:, 0] == 0.0) & (np.abs(coefficients[:, 1]) <= _ROUNDING * scale)
        coefficients[level, 2] += coefficients[level, 1]
        coefficients[level, 1] = 0.0
        return cls(np.append(starts[order], t[-1]), coefficients)

    @property
    def start(self) -> float:
        """First time [s]."""
        return float(self.knots[0])

    @property
    def stop(self) -> float:
        """Last time [s]."""
        return float(self.knots[-1])

    def __call__(self, time: ArrayLike) -> Any:
        """Return the value at the times [s]; at a jump the value behind it."""
        piece, u, _ = self._place(time)
        return polyval(u, np.moveaxis(self.coefficients[piece], -1, 0), tensor=False)[()]

    def rate(self, time: ArrayLike) -> Any:
        """Return the rate of change at the times [s]; at a kink the rate behind it."""
        piece, u, width = self._place(time)
        slopes = polyder(np.moveaxis(self.coefficients[piece], -1, 0))
        return (polyval(u, slopes, tensor=False) / width)[()]

    def within(self, time: ArrayLike) -> Array:
        """Return times [s] as an array; refuse those outside of the history."""
        t = np.asarray(finite("time", time, "s"), dtype=np.float64)
        if np.any((t < self.start) | (t > self.stop)):
            rule = f"must be in [{self.start:g}, {self.stop:g}] s, where the history is given"
            raise InputError("time", float(t.min() if t.min() < self.start else t.max()), rule, "s")
        return t

    def _place(self, time: ArrayLike) -> tuple[NDArray[np.intp], Array, Array]:
        t = self.within(time)
        piece = np.clip(np.searchsorted(self.knots, t, side="right") - 1, 0, len(self.coefficients) - 1)
        width = self.knots[piece + 1] - self.knots[piece]
        return piece, (t - self.knots[piece]) / width, width

    @property
    def smooth_knots(self) -> NDArray[np.bool_]:
        """Whether value, slope and second derivative pass each knot without a jump, up to rounding, shape (m + 1,)."""
        smooth, widths, pieces = np.zeros(self.knots.size, dtype=np.bool_), np.diff(self.knots), self.coefficients
        if len(pieces) == 1 or pieces.shape[1] <= 2:
            return smooth
        scale, shorter = np.abs(pieces).max(), np.minimum(widths[1:], widths[:-1])
        smooth[1:-1] = shorter > 0.0
        orders = np.arange(pieces.shape[1])
        ends, power = np.ones(orders.size), np.ones(widths.size)
        for order, rounding in enumerate(_SMOOTH):
            with np.errstate(divide="ignore", invalid="ignore"):
                jump = ends[order] * pieces[1:, order] / power[1:] - (pieces @ ends)[:-1] / power[:-1]
                smooth[1:-1] &= np.abs(jump) * shorter**order <= rounding * scale
            ends, power = ends * (orders - order), power * widths
        return smooth

    def until(self, time: float) -> History:
        """Return the history up to a time [s] within it."""
        time = single("time", within("time", time, float(self.knots[0]), float(self.knots[-1]), "s"), "s")
        n = max(int(np.searchsorted(self.knots, time, side="left")) - 1, 0)
        share = (time - self.knots[n]) / (self.knots[n + 1] - self.knots[n])
        last = _restricted(self.coefficients[n], 0.0, float(share))
        return History(np.append(self.knots[: n + 1], time), np.vstack([self.coefficients[:n], last[None]]))

    def cut(self) -> History:
        """Return the same history with further knots at its changes of sign and its turns."""
        widths = np.diff(self.knots)
        slopes = polyder(self.coefficients, axis=1)
        bends = (widths > 0.0) & (_may_change_sign(self.coefficients) | _may_change_sign(slopes))
        if not np.any(bends):
            return self
        knots: list[Array] = []
        pieces: list[Array] = []
        for n, c in enumerate(self.coefficients):
            if not bends[n]:
                pieces.append(c)
                knots.append(self.knots[n : n + 1])
                continue
            zeros, turns = zeros_of(c), zeros_of(slopes[n])
            places = [0.0, *sorted(set(zeros + turns)), 1.0]
            for low, high in pairwise(places):
                piece = _restricted(c, low, high)
                # A zero of the history must not become a small value by rounding.
                if low in zeros:
                    piece[0] = 0.0
                if high in zeros:
                    piece[1] -= piece.sum()
                pieces.append(piece)
            knots.append(self.knots[n] + widths[n] * np.array(places[:-1]))
        return History(np.append(np.concatenate(knots), self.stop), np.array(pieces))


def contact_part(history: History, name: str) -> History:
    """Return the history from first touch on; refuse a history that starts in contact or never touches."""
    history = history.cut()
    ends = history.coefficients.sum(axis=1)
    # A piece has one sign, and its middle is far from the rounding of its ends.
    middles = polyval(0.5, history.coefficients.T)
    touching = np.flatnonzero(np.where(np.diff(history.knots) > 0.0, middles, ends) > 0.0)
    first = float(history.coefficients[0, 0])
    # A curve that has been computed begins at zero within rounding.
    if first > NO_FORCE * float(ends.max()):
        advice = "a curve that begins in contact needs its contact point: " if name == "depth" else ""
        rule = f"must be <= 0 at the start; {advice}subtract an offset, or begin with a step, two points at one time"
        raise InputError(name, first, rule, UNITS[name])
    if not touching.size:
        raise InputError(name, float(ends.max()), "must rise above 0; the bodies do not touch", UNITS[name])
    start = int(touching[0])
    if name == "force":
        least = np.minimum(ends, history.coefficients[:, 0])
        negative = least < -NO_FORCE * ends.max()
        if np.any(negative):
            n = int(np.argmax(negative))
            rule = f"must be >= 0, as there is no adhesion; it is not at time = {history.knots[n + 1]:g} s"
            raise InputError("force", float(least[n]), rule, "N")
    coefficients = history.coefficients[start:].copy()
    coefficients[0, 1] += coefficients[0, 0] if history.knots[start + 1] == history.knots[start] else 0.0
    coefficients[0, 0] = 0.0
    return History(history.knots[start:], coefficients)


def from_zeros(history: History) -> tuple[History, Array, NDArray[np.bool_]]:
    """Return a force [N] >= 0 with knots where it vanishes but for rounding, and its coefficients from there on.

    The pieces in front of a zero count from their end, `sum_j coefficients[i, j] (1 - u)^j`; those are marked. At a
    zero the coefficients are free of rounding, so that the force is a power of the time.
    """
    coefficients = history.coefficients
    most = 10.0 * NO_FORCE * float(np.abs(coefficients).max())
    coefficients = np.where(np.abs(coefficients).sum(axis=1, keepdims=True) <= most, 0.0, coefficients)
    # A polynomial is above the least of its Bernstein coefficients.
    least = _bernstein(coefficients).min(axis=1)
    if np.all(least > most):
        return history, coefficients, np.zeros(len(coefficients), dtype=np.bool_)
    knots: list[float] = []
    backward: list[bool] = []
    pieces: list[Array] = []
    rows: list[Array] = []
    for n, c in enumerate(coefficients):
        low, high = history.knots[n : n + 2]
        ends = [0.0, 1.0]
        if least[n] <= most and high > low and np.any(c):
            ends[1:1] = [u for u in zeros_of(polyder(c)) if polyval(u, c) <= most]
        for first, last in pairwise(ends):
            falls = least[n] <= most and bool(np.any(c)) and polyval(last, c) <= most
            rises = least[n] <= most and polyval(first, c) <= most
            middle = 0.5 * (first + last)
            for start, stop in [(first, middle), (middle, last)] if falls and rises else [(first, last)]:
                turned = falls and stop == last
                piece = c if (start, stop) == (0.0, 1.0) else _restricted(c, start, stop)
                row = _restricted(c, stop, start) if turned else piece
                knots.append(low + (high - low) * start)
                backward.append(turned)
                pieces.append(piece)
                rows.append(_without_rounding(row, most) if turned or (rises and start == first) else row)
    return History(np.append(knots, history.stop), np.array(pieces)), np.array(rows), np.array(backward)


def _without_rounding(c: Array, most: float) -> Array:
    """Return a polynomial whose first coefficients, up to one that counts, are zero instead of rounding."""
    c, n = c.copy(), 0
    while n + 1 < c.size and abs(c[n]) <= most:
        c[n + 1] += c[n]
        c[n] = 0.0
        n += 1
    return c


def graded(history: History) -> History:
    """History with more and more knots towards first touch, so that creep there keeps its relative accuracy."""
    n = 0 if history.knots[1] > history.knots[0] else 1
    low, high = history.knots[n], history.knots[n + 1]
    fractions = np.concatenate([[0.0], 10.0 ** np.arange(-18, 1)])
    pieces = [_restricted(history.coefficients[n], *ends) for ends in pairwise(fractions)]
    return History(
        np.concatenate([history.knots[:n], low + (high - low) * fractions[:-1], history.knots[n + 1 :]]),
        np.concatenate([history.coefficients[:n], pieces, history.coefficients[n + 1 :]]),
    )


def ramp(value: float, duration: float) -> History:
    """Return the linear rise from 0 to `value` [m or N] within `duration` [s].

    Examples
    --------
    >>> print(ramp(2e-6, 4.0)(1.0))
    5e-07
    """
    peak, end = single_positive("value", value), single_positive("duration", duration, "s")
    return History.from_points([0.0, end], [0.0, peak])


def hold(value: float, duration: float, *, rise_time: float = 0.0) -> History:
    """Rise from 0 to `value` [m or N] within `rise_time` [s], at once by default, then constant for `duration` [s].

    With a depth this is a relaxation test, with a force a creep test.

    Examples
    --------
    >>> print(hold(2e-6, 10.0)([0.0, 5.0]))
    [2.e-06 2.e-06]
    """
    peak, rest = single_positive("value", value), single_positive("duration", duration, "s")
    rise = single_nonnegative("rise_time", rise_time, "s")
    return History.from_points([0.0, rise, rise + rest], [0.0, peak, peak])


def triangle(
    peak: float, loading_time: float, *, unloading_time: float | None = None, hold_time: float = 0.0
) -> History:
    """Return the linear rise from 0 to `peak` [m or N] within `loading_time` [s], and linear return to 0.

    Parameters
    ----------
    peak : float
        Largest value, > 0.
    loading_time : float
        [s], > 0.
    unloading_time : float, optional
        [s], > 0; equal to the loading time by default.
    hold_time : float
        Time [s] for which the peak is held: a trapezoid.

    Examples
    --------
    >>> print(triangle(1e-6, 1.0, hold_time=2.0)([0.5, 2.0, 3.5]))
    [5.e-07 1.e-06 5.e-07]
    """
    top, up = single_positive("peak", peak), single_positive("loading_time", loading_time, "s")
    down = up if unloading_time is None else single_positive("unloading_time", unloading_time, "s")
    rest = single_nonnegative("hold_time", hold_time, "s")
    if rest == 0.0:
        return History.from_points([0.0, up, up + down], [0.0, top, 0.0])
    return History.from_points([0.0, up, up + rest, up + rest + down], [0.0, top, top, 0.0])


def cycles(
    peak: float, loading_time: float, count: int, *, unloading_time: float | None = None, valley: float = 0.0
) -> History:
    """Return `count` loadings to `peak` [m or N], with partial unloadings between them and a full one at the end.

    Parameters
    ----------
    peak : float
        Largest value, > 0.
    loading_time : float
        Time [s] of each loading, > 0.
    count : int
        Number of loadings, >= 1.
    unloading_time : float, optional
        Time [s] of each unloading, > 0; equal to the loading time by default.
    valley : float
        Lowest value between two loadings over the peak [-], in [0, 1].

    Examples
    --------
    >>> print(cycles(1e-6, 1.0, 2, valley=0.6)([0.5, 1.0, 2.0, 3.0, 4.0]))
    [5.e-07 1.e-06 6.e-07 1.e-06 0.e+00]
    """
    top, up = single_positive("peak", peak), single_positive("loading_time", loading_time, "s")
    down = up if unloading_time is None else single_positive("unloading_time", unloading_time, "s")
    low, number = single("valley", within("valley", valley, 0.0, 1.0)) * top, whole("count", count, 1, 1_000_000)
    times = np.cumsum([0.0, *(up, down) * number])
    return History.from_points(times, [0.0, top, *(low, top) * (number - 1), 0.0])


def sine_arch(peak: float, duration: float) -> History:
    """Return half a period of a sine, `peak sin(pi t/duration)` [m or N] for t from 0 to `duration` [s].

    Examples
    --------
    >>> print(round(float(sine_arch(2e-6, 6.0)(1.0)), 15))
    1e-06
    """
    top, end = single_positive("peak", peak), single_positive("duration", duration, "s")
    knots = np.linspace(0.0, end, 13)
    return History.from_function(lambda t: top * np.sin(math.pi * np.minimum(t, end - t) / end), knots)


def _first_pieces(t: Array) -> Array:
    """Return the edges of the first pieces: about `_FIRST_PIECES`, between given times."""
    if t.size > _FIRST_PIECES:
        return t[np.unique(np.linspace(0, t.size - 1, _FIRST_PIECES + 1).astype(np.intp))]
    parts = -(-_FIRST_PIECES // (t.size - 1))
    inner = t[:-1, None] + np.diff(t)[:, None] * (np.arange(parts) / parts)
    return np.append(inner.ravel(), t[-1])


def _middles(t: Array, lows: Array, highs: Array) -> Array:
    """Return the times that cut pieces: the given time nearest to the middle, a possible kink, or else the middle."""
    middles = 0.5 * (lows + highs)
    after = np.searchsorted(t, middles)
    before, behind = t[np.maximum(after - 1, 0)], t[np.minimum(after, t.size - 1)]
    nearest = np.where(middles - before < behind - middles, before, behind)
    return np.where((nearest > lows) & (nearest < highs), nearest, middles)


def _errors_at(t: Array, values: Array, lows: Array, highs: Array, fit: Array) -> tuple[NDArray[np.intp], Array]:
    """Return the piece of each of the times, and the error of its fit there."""
    order = np.argsort(lows)
    piece = order[np.clip(np.searchsorted(lows[order], t, side="right") - 1, 0, lows.size - 1)]
    inside = (t >= lows[piece]) & (t <= highs[piece])
    t, values, piece = t[inside], values[inside], piece[inside]
    u = (t - lows[piece]) / (highs[piece] - lows[piece])
    return piece, np.abs(polyval(u, fit[piece].T, tensor=False) - values)


def without_collinear(t: Array, v: Array) -> tuple[Array, Array]:
    """Points that are not on the line through their neighbours, so that a sampled straight line is one piece."""
    if t.size < 3:
        return t, v
    tolerance = 4.0 * np.finfo(np.float64).eps * np.max(np.abs(v))
    width = t[2:] - t[:-2]
    with np.errstate(divide="ignore", invalid="ignore"):
        chord = v[:-2] + (v[2:] - v[:-2]) * ((t[1:-1] - t[:-2]) / width)
    straight = (np.abs(chord - v[1:-1]) <= tolerance) & (t[1:-1] > t[:-2]) & (t[2:] > t[1:-1])
    keep = np.concatenate([[True], ~straight, [True]])
    if np.all(keep) or np.any(np.abs(np.interp(t, t[keep], v[keep]) - v)[~keep] > tolerance):
        return t, v
    return t[keep], v[keep]


def _bernstein(c: NDArray[np.floating]) -> Array:
    """Return the Bernstein coefficients of polynomials over [0, 1], which enclose their values."""
    degree = c.shape[1] - 1
    rows = [[math.comb(i, j) / math.comb(degree, j) for j in range(degree + 1)] for i in range(degree + 1)]
    return np.asarray(c @ np.array(rows).T, dtype=np.float64)


def _may_change_sign(c: NDArray[np.floating]) -> NDArray[np.bool_]:
    """Return whether polynomials over [0, 1] may change sign within: their Bernstein coefficients differ in sign."""
    bernstein = _bernstein(c)
    return (bernstein.min(axis=1) < 0.0) & (bernstein.max(axis=1) > 0.0)


def zeros_of(c: Array) -> list[float]:
    """Return the places in (0, 1) at which a polynomial changes sign."""
    if not np.any(c[1:]):
        return []
    roots = polyroots(np.trim_zeros(c, "b"))
    real = roots.real[np.abs(roots.imag) < 1e-9]
    places = np.sort(real[(real > 0.0) & (real < 1.0)])
    edges = np.concatenate([[0.0], places, [1.0]])
    signs = np.sign(polyval(0.5 * (edges[:-1] + edges[1:]), c))
    return places[signs[:-1] * signs[1:] < 0.0].tolist()


def _restricted(c: Array, u0: float, u1: float) -> Array:
    """Return the coefficients over [u0, u1] of a polynomial given over [0, 1]."""
    shifted = c.copy()
    for start in range(c.size - 1):
        for n in range(c.size - 2, start - 1, -1):
            shifted[n] += u0 * shifted[n + 1]
    return shifted * (u1 - u0) ** np.arange(c.size)
