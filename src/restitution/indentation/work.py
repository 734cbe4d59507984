"""Work of an indentation over its loop of force and depth, and largest values over time."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from restitution.checks import Array

if TYPE_CHECKING:
    from restitution.indentation.adhesion import AdhesiveSolution
    from restitution.indentation.solve import Solution

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(10)
_MOST_PANELS = 4000
# Places between two breaks at which the search for a largest value starts.
_SHARES = np.linspace(0.0, 1.0, 9)


def largest(values: Callable[[Array], Array], breaks: Array) -> float:
    """Return the largest value of a function that is smooth between its breaks."""
    low, high = breaks[:-1, None], breaks[1:, None]
    times, best = np.append((low + (high - low) * _SHARES[:-1]).ravel(), breaks[-1:]), -np.inf
    for _ in range(6):
        samples = values(times)
        n = int(np.argmax(samples))
        best = max(best, float(samples[n]))
        times = np.linspace(times[max(n - 1, 0)], times[min(n + 1, times.size - 1)], 33)
    return best


def largest_of(solution: Solution | AdhesiveSolution, column: int) -> float:
    """Return the largest value of a column of `at`, up to the end of contact where the solution ends with it."""
    breaks, knots = solution.breaks, solution.history.knots
    # Values jump at kinks: also those before one.
    knots = knots[(knots > breaks[0]) & (knots <= breaks[-1])]
    before = float(np.max(solution.at(knots, before=True)[column], initial=-np.inf))
    return max(before, largest(lambda times: solution.at(times)[column], breaks))


def loop_work(solution: Solution) -> float:
    """Work int F dd [J] until the end of contact or of the history; steps are integrated separately.

    Under a prescribed force it is F d - int d dF, as the rate of the depth may be infinite at touch.
    """
    rtol, breaks, history = solution.rtol, solution.breaks, solution.history

    def power(times: Array) -> Array:
        # Rounding moves times out of a history that does not begin at zero.
        times = np.clip(times, history.start, history.stop)
        depth, rate, force, _ = solution.at(times)
        return force * rate if solution.by_depth else -depth * history.rate(times)

    steps = [_step_work(solution, place, rtol) for place in solution.steps]
    total = integral(power, breaks, rtol, sum(map(abs, steps))) + sum(steps)
    if not solution.by_depth:
        depth, _, force, _ = solution.at(np.minimum(breaks[-1:], history.stop))
        total += float(force[0] * depth[0])
    return total


def _step_work(solution: Solution, place: int, rtol: float) -> float:
    """Integral [J] over a step: of the force over the depth, or of -d over a prescribed force."""
    depth, force = solution.through(place, np.array([0.0, 1.0]))
    column = 1 if solution.by_depth else 0
    # At both ends force and depth may be powers of each other.
    fine = 0.5 * 2.0 ** -np.arange(50.0)[::-1]
    edges = np.concatenate([[0.0], fine, 1.0 - fine[-2::-1], [1.0]])
    mean = integral(lambda shares: solution.through(place, shares)[column], edges, rtol, 0.0)
    change = depth[1] - depth[0] if solution.by_depth else force[0] - force[1]
    return float(change * mean)


def integral(function: Callable[[Array], Array], edges: Array, rtol: float, scale: float) -> float:
    """Integral by Gauss panels, each halved until its halves agree with it within rtol of `scale` and all panels."""

    def panels(low: Array, high: Array) -> Array:
        half = 0.5 * (high - low)
        nodes = (low + half)[:, None] + half[:, None] * _NODES
        return half * (function(nodes.ravel()).reshape(nodes.shape) @ _WEIGHTS)

    low, high = edges[:-1], edges[1:]
    span, most = float(edges[-1] - edges[0]), _MOST_PANELS + 2 * low.size
    whole = panels(low, high)
    scale += float(np.sum(np.abs(whole)))
    total = 0.0
    while low.size and scale > 0.0:
        middle = 0.5 * (low + high)
        left, right = panels(low, middle), panels(middle, high)
        share = (high - low) / span
        good = np.abs(left + right - whole) <= 0.1 * rtol * scale * np.maximum(share, 0.01)
        # Narrower panels have only rounding between their ends; so many panels are noise, which halving does not end.
        good |= (share <= 1e-12) | (low.size > most)
        total += float(np.sum((left + right)[good]))
        bad = ~good
        whole = np.concatenate([left[bad], right[bad]])
        low, high = np.concatenate([low[bad], middle[bad]]), np.concatenate([middle[bad], high[bad]])
    return total
