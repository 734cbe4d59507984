"""Least squares: Levenberg-Marquardt descents of many problems at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.checks import Array, Places
from restitution.numerics.differences import FORWARD

Residuals = Callable[[Array, Places], Array]
"""Maps k points of each of the problems at some places, shape (s, k, q), to residuals of shape (s, k, n)."""
Slopes = Callable[[Array, Places], Array]
"""Maps a point of each of the problems at some places, shape (s, q), to derivatives of shape (s, q, n)."""

_BOUND_MARGIN = 1e-9
# Within this distance of a bound a coordinate is held there if the sum of squares falls beyond the bound.
_PRESSED = 1e-8
# Damping: first value, factors after a success and a failure, its growth after another one, range, hopeless value.
_FIRST, _EASED, _RAISED, _GROWTH, _RANGE, _HOPELESS = 1e-3, 0.1, 5.0, 2.0, (1e-9, 1e9), 1e8
# Coordinates that the data hardly determine are damped like ones with this share of the largest curvature.
_LEAST = 1e-4
# From this round on, steps bend along curved valleys. The bend is measured after this share of the step.
_CURVED, _SHARE = 8, 0.1


class Descents(NamedTuple):
    """Ends of s descents."""

    points: Array  # shape (s, q)
    costs: Array  # sums of squares, infinite where the start has none
    ended: NDArray[np.bool_]  # whether no step would lower the sum of squares further


def descend(
    residuals: Residuals, points: Array, low: Array, high: Array, steps: Array | Slopes, furthest: Array,
    enough: float, rounds: int,
) -> Descents:  # fmt: skip
    """Descend from points of shape (s, q) within bounds of the same shape.

    `steps` of shape (q,) are those of forward differences, and a coordinate whose step is 0 is held; or they are a
    function that returns the derivatives. `furthest` are the largest changes in a round. A descent ends if its next
    step promises less than the share `enough` of its sum. Coordinates should be of order one: those that the residuals
    hardly depend on are damped more.

    Late steps have the second order of Transtrum and Sethna, https://arxiv.org/abs/1201.5885: without it a descent
    along a curved valley takes hundreds of rounds.
    """
    points, q = points.copy(), points.shape[1]
    moves = True if callable(steps) else steps > 0.0
    # One call for the values and the slopes of the starts: its price is that of a call rather than of its rows.
    values, slopes = _slopes(residuals, points, np.arange(len(points)), None, steps)
    costs = squares(values)
    normal, gradient = np.zeros((len(points), q, q)), 0.0 * points
    raised = np.full(len(points), _RAISED)
    damping, fresh, ended = np.full(len(points), _FIRST), np.isfinite(costs), np.zeros(len(points), dtype=np.bool_)
    active = np.flatnonzero(fresh)
    for n in range(rounds):
        if not active.size:
            break
        new = active[fresh[active]]
        if new.size:
            if n:
                slopes[new] = _slopes(residuals, points[new], new, values[new], steps)[1]
            normal[new] = slopes[new] @ slopes[new].swapaxes(1, 2)
            gradient[new] = np.einsum("sqn,sn->sq", slopes[new], values[new])
        at, pull = points[active], gradient[active]
        bound = ((at - low[active] < _PRESSED) & (pull > 0.0)) | ((high[active] - at < _PRESSED) & (pull < 0.0))
        free = ~bound & moves
        matrix = normal[active] * (free[:, :, None] & free[:, None, :])
        step, promise = _steps(matrix, pull * free, damping[active])
        step = np.clip(step, -furthest, furthest)
        if n >= _CURVED:
            ahead = residuals((at + _SHARE * step * free)[:, None], active)[:, 0] - values[active]
            bend = 2.0 / _SHARE * (ahead / _SHARE - np.einsum("sq,sqn->sn", step * free, slopes[active]))
            pull = np.einsum("sqn,sn->sq", slopes[active], np.nan_to_num(bend, posinf=0.0, neginf=0.0))
            second = 0.5 * _steps(matrix, pull * free, damping[active])[0]
            small = np.linalg.norm(second, axis=1) < 0.75 * np.linalg.norm(step, axis=1)
            step = np.where(small[:, None], np.clip(step + second, -furthest, furthest), step)
        trial = np.where(free, np.clip(at + step, low[active] + _BOUND_MARGIN, high[active] - _BOUND_MARGIN), at)
        tried = residuals(trial[:, None], active)[:, 0]
        cost = squares(tried)
        better = cost < costs[active]
        # A descent also ends if only rounding prevents an improvement.
        ended[active] = (promise < enough * costs[active]) | ((damping[active] > _HOPELESS) & ~better)
        won = active[better]
        points[won], values[won], costs[won] = trial[better], tried[better], cost[better]
        fresh[:] = False
        fresh[won] = True
        damping[active] = np.clip(damping[active] * np.where(better, _EASED, raised[active]), *_RANGE)
        raised[active] = np.where(better, _RAISED, _GROWTH * raised[active])
        active = active[~ended[active]]
    return Descents(points, costs, ended)


def _slopes(
    residuals: Residuals, points: Array, places: Places, values: Array | None, steps: Array | Slopes
) -> tuple[Array, Array]:
    """Return values, shape (s, n), and their derivatives, shape (s, q, n); 0 for steps of 0."""
    if callable(steps):
        return residuals(points[:, None], places)[:, 0] if values is None else values, steps(points, places)
    near = FORWARD.points(points, steps)
    if values is None:
        every = residuals(near, places)
    else:
        every = np.concatenate([values[:, None], residuals(near[:, 1:], places)], axis=1)
    # A start may have no result.
    slopes = np.nan_to_num(FORWARD.slopes(every.swapaxes(0, 1), steps), posinf=0.0, neginf=0.0)
    return every[:, 0], slopes.swapaxes(0, 1)


def squares(values: Array) -> Array:
    """Return sums of squares of rows; infinite where one overflows or is not a number: such a point is no minimum."""
    with np.errstate(over="ignore"):
        return np.where(np.isfinite(values).all(axis=1), (values**2).sum(axis=1), np.inf)


def _steps(normal: Array, gradient: Array, damping: Array) -> tuple[Array, Array]:
    """Return steps, and the decrease of the sum of squares that they promise."""
    scale = np.einsum("sqq->sq", normal)
    scale = np.maximum(scale, _LEAST * scale.max(axis=1, keepdims=True) + 1e-300)
    damped = normal + (damping[:, None] * scale)[:, :, None] * np.eye(normal.shape[1])
    step = -np.linalg.solve(damped, gradient[..., None])[..., 0]
    return step, -np.einsum("sq,sq->s", step, gradient)
