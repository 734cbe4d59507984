"""Largest values and work of an indentation, from its samples."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from restitution.indentation.exact import Solution

Array = NDArray[np.float64]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(10)
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
    """Work [J] int F dd until the end of contact, or of the history.

    Adaptive Gauss quadrature in time: an interval is halved until its two halves agree with it; jumps of the depth are
    integrated by themselves.
    """
    breaks = solution.breaks
    low, high = breaks[:-1], breaks[1:]
    whole = _panels(solution, low, high)
    scale = float(np.sum(np.abs(whole)))
    total = _jump_work(solution)
    scale += abs(total)
    for _ in range(60):
        if not low.size or scale == 0.0:
            break
        middle = 0.5 * (low + high)
        left, right = _panels(solution, low, middle), _panels(solution, middle, high)
        good = np.abs(left + right - whole) <= 0.1 * rtol * scale * np.maximum(1.0 / low.size, 1e-3)
        total += float(np.sum((left + right)[good]))
        bad = ~good
        low, middle, high = low[bad], middle[bad], high[bad]
        whole = np.concatenate([left[bad], right[bad]])
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
    else:
        total += float(np.sum(whole))
    return total


def _panels(solution: Solution, low: Array, high: Array) -> Array:
    half = 0.5 * (high - low)
    times = (low + half)[:, None] + half[:, None] * _NODES
    _, rate, force, _ = solution.at(times.ravel())
    return half * ((force * rate).reshape(times.shape) @ _WEIGHTS)


def _jump_work(solution: Solution) -> float:
    """Work [J] of the jumps, on panels that shrink towards both ends, where force and depth are powers of each other."""
    fine = 0.5 * 2.0 ** -np.arange(50.0)[::-1]
    edges = np.concatenate([[0.0], fine, 1.0 - fine[-2::-1], [1.0]])
    half = 0.5 * np.diff(edges)
    inner = (edges[:-1] + half)[:, None] + half[:, None] * _NODES
    shares = np.concatenate([[0.0], inner.ravel(), [1.0]])
    weights = (half[:, None] * _WEIGHTS).ravel()
    total = 0.0
    for depth, force in solution.jumps(shares):
        if solution.by_depth:
            total += (depth[-1] - depth[0]) * float(weights @ force[1:-1])
        else:
            total += force[-1] * depth[-1] - force[0] * depth[0]
            total -= (force[-1] - force[0]) * float(weights @ depth[1:-1])
    return float(total)
