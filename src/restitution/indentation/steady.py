"""Steady taps: the surface that a periodic motion leaves, and extrapolation from taps before."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from restitution.checks import Array
from restitution.indentation.panels import PanelSolution
from restitution.indentation.surface import Imprint
from restitution.kernel.driver import room
from restitution.kernel.panels import FLAT, FROZEN, NODES, SMOOTH, Solid, scheme
from restitution.kernel.periodic import Bench, Motion, write_memory, write_periodic

# First division of the elements, over z with y = y_max (1 - z^2), and how often parts are halved.
_CUTS, _HALVINGS = (0.0, 0.2, 0.45, 0.7, 1.0), 4
# Error of a panel and of an element, over the tolerance.
_PANEL, _ELEMENT = 0.03, 1e-4
# Singular values of the past that are left out, over the largest.
_RANK = 1e-8

# Solutions with weights, whose sum of depths is a motion.
Mixture = Sequence[tuple[float, PanelSolution]]


class Trial(NamedTuple):
    """A tap: numbers of its start, what the tap changes of them, and its solution."""

    start: Array
    change: Array
    solution: PanelSolution


def mixed(parts: Mixture) -> Mixture:
    """Return a mixture in which each solution is once."""
    weights: dict[int, float] = {}
    for weight, solution in parts:
        weights[id(solution)] = weights.get(id(solution), 0.0) + weight
    solutions = {id(solution): solution for _, solution in parts}
    return [(weight, solutions[key]) for key, weight in weights.items() if weight]


class Past:
    """Taps from which the start of the next one is extrapolated, by Anderson's method."""

    def __init__(self, memory: int) -> None:
        self.memory = memory
        self._last: Trial | None = None
        self._pairs: list[tuple[Trial, Trial]] = []

    def forget(self) -> None:
        """Begin anew."""
        self._last, self._pairs = None, []

    def part(self) -> None:
        """Keep how starts and changes belong together, while the next tap has another distance."""
        self._last = None

    def add(self, trial: Trial) -> None:
        """Add a tap."""
        if self._last is not None and self._last.start.size == trial.start.size:
            self._pairs = [*self._pairs, (self._last, trial)][-self.memory + 1 :]
        elif self._pairs and self._pairs[0][0].start.size != trial.start.size:
            self._pairs = []
        self._last = trial

    def next_start(self) -> tuple[Array, Mixture] | None:
        """Return the start that would not change by the differences between the taps before; None at first."""
        last, pairs = self._last, self._pairs
        if last is None or len(pairs) < 2 or self.memory < 2:
            return None
        steps = np.array([b.start - a.start for a, b in pairs])
        slopes = np.array([b.change - a.change for a, b in pairs])
        weights, *_ = np.linalg.lstsq(slopes.T, last.change, rcond=_RANK)
        parts = [(1.0, last.solution)]
        for weight, (a, b) in zip(weights.tolist(), pairs, strict=True):
            parts += [(weight, a.solution), (-weight, b.solution)]
        return last.start + last.change - weights @ (steps + slopes), mixed(parts)


class Recovery:
    """Surfaces that are left where the same motion has gone on for ever, however slowly they relax.

    Parameters
    ----------
    tolerance : float
        Error of the parts of the displacement, over the unit of the depth.
    """

    def __init__(self, tolerance: float) -> None:
        self.tolerance = tolerance
        self._cuts = np.array(_CUTS)

    def surface(self, solution: PanelSolution, mixture: Mixture, error: float) -> Imprint | None:
        """Return the surface at the start of a period with the depths of a mixture; None if an element is not solved.

        The period is that of a solution with one touch, which ends without contact. `error` is that of the motion.
        """
        rule, solid, units = scheme(), solution.solid, solution.units
        starts, lengths, kinds = solution.pieces
        times = solution.node_times
        depths = np.zeros(times.shape)
        for weight, part in mixture:
            depths += weight * part.scaled_depth(times)
        coefficients = depths @ rule.coefficients.T
        peak, place, most = _largest(coefficients)
        if not most > 0.0:
            return None
        memory = np.zeros((starts.size, solid.rates.size, NODES))
        motion = Motion(starts, lengths, kinds, coefficients, memory, np.zeros_like(memory), peak, place, 1.0)
        write_memory(solid, rule, room(solid, 1, 1), motion, depths)
        rows = self._rows(solid, motion, most, error)
        if rows is None:
            return None
        rows[:, 0] *= math.sqrt(units.length)
        rows[:, 1:] *= units.length
        count = rows.shape[0]
        zeros, joints = np.zeros(count), np.full(count, SMOOTH, dtype=np.int64)
        joints[0] = FLAT
        return Imprint(rows, zeros, zeros, np.full(count, FROZEN, dtype=np.int64), np.ones(count), joints)

    def _rows(self, solid: Solid, motion: Motion, most: float, error: float) -> Array | None:
        """Return Chebyshev coefficients of y and of the parts of the displacement, (P, 1 + J, N); None if unsolved."""
        rule, K, J = scheme(), solid.rates.size, solid.recoveries.size
        bench = Bench(np.zeros(K), np.zeros(J), np.zeros((J, J + 1)), np.zeros((2, NODES)))
        for trial in range(_HALVINGS + 1):
            z = self._cuts[:-1, None] + np.diff(self._cuts)[:, None] * rule.c
            y = math.sqrt(most) * (1.0 - z * z)
            parts, s = np.zeros((y.size, J)), np.ascontiguousarray((y * y).ravel()[1:])
            # The outermost element has no displacement.
            solved = write_periodic(solid, motion, s, parts[1:], np.zeros(J), _ELEMENT * self.tolerance, bench)
            if solved < s.size:
                break
            values = np.concatenate([y[:, None], parts.reshape(*y.shape, J).swapaxes(1, 2)], axis=1)
            rows: Array = np.ascontiguousarray(values @ rule.coefficients.T)
            rough = np.abs(rows[:, 1:, -2:]).sum(axis=2).max(axis=1) > max(_PANEL * self.tolerance, error)
            if trial == _HALVINGS or not rough.any():
                return rows
            middles = 0.5 * (self._cuts[1:] + self._cuts[:-1])
            self._cuts = np.sort(np.append(self._cuts, middles[rough]))
        return None


def _largest(coefficients: Array) -> tuple[int, float, float]:
    """Return piece, place and value of the largest value of polynomials over z."""
    z = np.linspace(0.0, 1.0, 33)
    values = coefficients @ chebyshev.chebvander(2.0 * z - 1.0, NODES - 1).T
    piece, n = (int(place) for place in np.unravel_index(np.argmax(values), values.shape))
    most = float(values[piece, n])
    for _ in range(7):
        z = np.linspace(z[max(n - 1, 0)], z[min(n + 1, z.size - 1)], 33)
        depth = chebyshev.chebval(2.0 * z - 1.0, coefficients[piece])
        n, most = int(np.argmax(depth)), float(depth.max())
    return piece, float(z[n]), most
