"""Largest values and work of an indentation, from its samples."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from restitution.indentation.exact import Solution

Array = NDArray[np.float64]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(10)
_MOST_PANELS = 4000
_SHARES = np.linspace(0.0, 1.0, 9)


def largest(solution: Solution, column: int) -> tuple[float, float]:
    """Largest value of a column of `Solution.at` up to the end of contact, and its time [s]."""
    breaks = solution.breaks
    low, high = breaks[:-1, None], breaks[1:, None]
    times = np.concatenate([(low + (high - low) * _SHARES[:-1]).ravel(), breaks[-1:]])
    best, moment = -np.inf, float(breaks[0])
    # Values jump at kinks: also what is before one.
    knots = solution.history.knots
    knots = knots[(knots > breaks[0]) & (knots <= breaks[-1])]
    if knots.size:
        values = solution.at(knots, before=True)[column]
        best, moment = float(values.max()), float(knots[np.argmax(values)])
    for _ in range(6):
        values = solution.at(times)[column]
        n = int(np.argmax(values))
        if values[n] > best:
            best, moment = float(values[n]), float(times[n])
        times = np.linspace(times[max(n - 1, 0)], times[min(n + 1, times.size - 1)], 33)
    return best, moment


def loop_work(solution: Solution, rtol: float) -> float:
    """Work [J] int F dd until the end of contact, or of the history; steps of the history are integrated by themselves."""
    breaks = solution.breaks

    def power(low: Array, high: Array) -> Array:
        half = 0.5 * (high - low)
        times = (low + half)[:, None] + half[:, None] * _NODES
        _, rate, force, _ = solution.at(times.ravel())
        return half * ((force * rate).reshape(times.shape) @ _WEIGHTS)

    steps = [_step_work(solution, place, rtol) for place in solution.steps]
    return _adaptive(power, breaks[:-1], breaks[1:], rtol, sum(map(abs, steps))) + sum(steps)


def _step_work(solution: Solution, place: int, rtol: float) -> float:
    """Work [J] of a step: over the depth under a prescribed one, else over the force by parts."""
    depth, force = solution.through(place, np.array([0.0, 1.0]))
    column = 1 if solution.by_depth else 0

    def values(low: Array, high: Array) -> Array:
        half = 0.5 * (high - low)
        shares = (low + half)[:, None] + half[:, None] * _NODES
        return half * (solution.through(place, shares.ravel())[column].reshape(shares.shape) @ _WEIGHTS)

    # At both ends force and depth may be powers of each other.
    fine = 0.5 * 2.0 ** -np.arange(50.0)[::-1]
    edges = np.concatenate([[0.0], fine, 1.0 - fine[-2::-1], [1.0]])
    mean = _adaptive(values, edges[:-1], edges[1:], rtol, 0.0)
    if solution.by_depth:
        return float((depth[1] - depth[0]) * mean)
    return float(force[1] * depth[1] - force[0] * depth[0] - (force[1] - force[0]) * mean)


def _adaptive(
    panels: Callable[[Array, Array], Array], low: Array, high: Array, rtol: float, scale: float
) -> float:
    """Integral by panels, each of which is halved until its two halves agree with it.

    Parameters
    ----------
    panels : callable
        Integrals over intervals, from their lower and upper ends.
    low, high : array, shape (n,)
        The intervals to begin with.
    rtol : float
        Error over the sum of the sizes of all.
    scale : float
        Size of what is added to the integral elsewhere.
    """
    span, most = float(high[-1] - low[0]), _MOST_PANELS + 2 * low.size
    whole = panels(low, high)
    scale += float(np.sum(np.abs(whole)))
    total = 0.0
    while low.size and scale > 0.0:
        middle = 0.5 * (low + high)
        left, right = panels(low, middle), panels(middle, high)
        share = (high - low) / span
        good = np.abs(left + right - whole) <= 0.1 * rtol * scale * np.maximum(share, 0.01)
        # Narrower ones are lost in the rounding of their ends; so many are noise, which halving does not end.
        good |= (share <= 1e-12) | (low.size > most)
        total += float(np.sum((left + right)[good]))
        bad = ~good
        low, middle, high = low[bad], middle[bad], high[bad]
        whole = np.concatenate([left[bad], right[bad]])
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
    return total
