"""Largest contact pressure over the contact and over time.

At the time t of the approach, at the radius r = a(t_r), in units of m v0^2/(2 pi L a_1^2),

    p(r, t) = int_(t_r)^t E(t - t') dd(t')/sqrt(a(t')^2 - r^2),   E(t) = equilibrium + sum moduli_k exp(-t/times_k).

In the rebound the pressure only falls, because the depth falls and the modulus relaxes. Places in sigma represent time
and radius. The pressure is finite without a parallel dashpot if the profile has neither a sharp tip nor a sharp edge.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from restitution.kernel.compile import compiled, entry_point
from restitution.kernel.dense import interpolate_at
from restitution.kernel.path import radius_and_integral
from restitution.kernel.radau import Scheme
from restitution.kernel.workspace import N_APPROACH, S_, T_, V_, Problem, Work

# Quadrature rule.
_FIRST_EDGES = (0.0, 1 / 256, 1 / 64, 1 / 16, 1 / 4, 0.5, 0.65)  # ends of the first cells
_CELL_RATIO = 0.25  # ratio of the last cells; the integrand is an inverse root at their end
_LAST_CELLS = 12  # the smallest cell is 6e-8
_POWER = 8  # of the places
# Search for the largest pressure.
_EARLIEST = math.log(1e-4)  # smallest sigma over that at the turning point
_YOUNGEST = math.log(1e-12)  # smallest age over the square of sigma at the turning point
_GRID = 18  # points of the first grid in each direction
_GRADING = 2  # power of the grid, which is denser towards the turning point and the axis
_RIDGE = 2.0  # additional range of ages over that of times: a ridge may be inclined
_ROUNDS = 11  # of each search around the best point of the grid
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


class Rule(NamedTuple):
    """A quadrature rule on [0, 1], from the end to the start, and scratch space for the motion at a node."""

    places: Any
    weights: Any
    row: Any


def graded_rule(n: int) -> Rule:
    """Rule with n nodes per cell and shorter cells towards both ends.

    For power laws close to a cone, with an exponent m -> 1, the integrand on the axis rises as sigma^(1 - 2/m) towards
    0: hence the power there.
    """
    nodes, weights = np.polynomial.legendre.leggauss(n)
    edges = np.concatenate([_FIRST_EDGES, 1.0 - _CELL_RATIO ** np.arange(1.0, _LAST_CELLS + 1.0), [1.0]])
    half = 0.5 * np.diff(edges)[:, None]
    y = (edges[:-1, None] + half * (1.0 + nodes)).ravel()[::-1]
    return Rule(y**_POWER, (half * weights).ravel()[::-1] * _POWER * y ** (_POWER - 1), np.empty(3))


@compiled
def _pressure(problem: Problem, scheme: Scheme, work: Work, rule: Rule, time: float, age: float) -> float:
    """Pressure at the logarithms of sigma and of the age of the contact at the radius, a difference of sigma^2.

    A peak close to the edge has a constant age as the contact grows. An age above that of the contact means the axis.
    """
    now = work.turning_place[0] * math.exp(time)
    touch = math.sqrt(max(now * now - work.turning_place[0] ** 2 * math.exp(age), 0.0))
    row = rule.row
    element = interpolate_at(scheme, work, work.counts[N_APPROACH], now, row)
    t = row[T_]
    interpolate_at(scheme, work, element, touch, row)
    r = radius_and_integral(problem.path, max(row[S_], 0.0))[0]
    total = 0.0
    for n in range(rule.places.shape[0]):
        sigma = touch + (now - touch) * rule.places[n]
        element = interpolate_at(scheme, work, element, sigma, row)
        a = radius_and_integral(problem.path, max(row[S_], 0.0))[0]
        if a > r:
            since = max(t - row[T_], 0.0)
            modulus = problem.equilibrium
            for k in range(problem.moduli.shape[0]):
                modulus += problem.moduli[k] * math.exp(-since / problem.times[k])
            total += rule.weights[n] * modulus * row[S_] * row[V_] / math.sqrt((a - r) * (a + r))
    return 2.0 * (now - touch) * total


@compiled
def _over_ages(problem: Problem, scheme: Scheme, work: Work, rule: Rule, time: float, window: Any) -> float:
    """Largest pressure at a time over a window of ages, by golden-section search."""
    low, high = window
    left, right = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    of_left = _pressure(problem, scheme, work, rule, min(time, 0.0), left)
    of_right = _pressure(problem, scheme, work, rule, min(time, 0.0), right)
    for _ in range(_ROUNDS):
        if of_left > of_right:
            high, right, of_right = right, left, of_left
            left = high - _GOLDEN * (high - low)
            of_left = _pressure(problem, scheme, work, rule, min(time, 0.0), left)
        else:
            low, left, of_left = left, right, of_right
            right = low + _GOLDEN * (high - low)
            of_right = _pressure(problem, scheme, work, rule, min(time, 0.0), right)
    return max(of_left, of_right)


@entry_point
def peak_pressure(problem: Problem, scheme: Scheme, work: Work, coarse: Rule, fine: Rule) -> float:
    """Return the largest pressure of an impact from its stored approach.

    A grid, dense towards the turning point and the axis, locates the maximum, and a search around its best point
    gives the value.
    """
    largest, time, age = 0.0, 0.0, 0.0
    i_best, j_best = 0, 0
    for i in range(_GRID):
        for j in range(_GRID):
            here = _EARLIEST * (i / (_GRID - 1.0)) ** _GRADING, _YOUNGEST * (j / (_GRID - 1.0)) ** _GRADING
            found = _pressure(problem, scheme, work, coarse, here[0], here[1])
            if found > largest:
                largest, time, age, i_best, j_best = found, here[0], here[1], i, j
    step_time = _EARLIEST * (i_best**_GRADING - (i_best + 1.0) ** _GRADING) / (_GRID - 1.0) ** _GRADING
    step_age = _YOUNGEST * (j_best**_GRADING - (j_best + 1.0) ** _GRADING) / (_GRID - 1.0) ** _GRADING
    # The maximum may lie on a narrow ridge: search for the best age at each time.
    window = age - step_age - _RIDGE * step_time, age + step_age + _RIDGE * step_time
    low, high = time - step_time, time + step_time
    left, right = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    of_left = _over_ages(problem, scheme, work, fine, left, window)
    of_right = _over_ages(problem, scheme, work, fine, right, window)
    for _ in range(_ROUNDS):
        if of_left > of_right:
            high, right, of_right = right, left, of_left
            left = high - _GOLDEN * (high - low)
            of_left = _over_ages(problem, scheme, work, fine, left, window)
        else:
            low, left, of_left = left, right, of_right
            right = low + _GOLDEN * (high - low)
            of_right = _over_ages(problem, scheme, work, fine, right, window)
    return max(of_left, of_right)
