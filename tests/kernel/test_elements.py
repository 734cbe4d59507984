"""Orders of the elements that the kernel ships, with S = 8, against Hairer & Wanner, Solving ODEs II, 2nd ed., IV.5.

The elements are marched with a constant length and compared with a march in much shorter ones. Newton's method starts from
that fine solution, because the long elements of these tests are beyond the reach of the kernel's own predictions.
"""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from restitution.kernel.approach import approach, approach_element
from restitution.kernel.compile import entry_point
from restitution.kernel.control import CHORD, CONVERGED, DIVERGED, FACTOR, newton_verdict
from restitution.kernel.interpolation import interpolate_lanes
from restitution.kernel.lanes import read8, write8
from restitution.kernel.outcome import SEPARATED
from restitution.kernel.path import power_path, radii_and_integrals
from restitution.kernel.problem import Problem
from restitution.kernel.radau import radau
from restitution.kernel.rebound import rebound_element
from restitution.kernel.workspace import (
    DELAY,
    F_,
    INTEGRAL,
    MODES_,
    N_APPROACH,
    S_,
    T_,
    UNKNOWN,
    V_,
    VALUES,
    allocate,
)  # fmt: skip

SCHEME = radau(8)
NEWTON = 1e-13


@entry_point
def _approach_step(problem, scheme, work, element, h, accept):
    return approach_element(problem, scheme, work, work.approach[element], h, accept)


@entry_point
def _past(problem, scheme, work, start, h):
    sigma = start - h * read8(scheme.c, 1)
    interpolate_lanes(scheme, work, work.approach, sigma, work.counts[N_APPROACH], work.past)
    integral = radii_and_integrals(problem.path, read8(work.past[S_], 0), work.vectors[VALUES:])[1]
    write8(work.vectors[INTEGRAL], 0, integral)


@entry_point
def _rebound_step(problem, scheme, work, element, h, delay, accept):
    return rebound_element(problem, scheme, work, work.rebound[element], h, delay, accept)


@entry_point
def _whole_approach(problem, scheme, work, tolerance, accept, first):
    return approach(problem, scheme, work, tolerance, accept, first)


def _swinging(end, count, prediction=None):
    """A body that swings under a constant force, from s = 1 on: nodes, values there, and its state at `end`."""
    problem = Problem(1.0, np.array([0.1]), np.array([1.0]), 0.0, 0.7, power_path(1.0))
    work, h = allocate(1, count + 1), end / count
    state = work.approach[0, :, 0]
    state[S_], state[V_], state[F_] = 1.0, 0.5, 2.0 / 3.0
    nodes = h * (np.arange(count)[:, None] + SCHEME.c[None, 1:])
    for n in range(count):
        start = work.approach[n, :, 0]
        x = nodes[n] - n * h
        guess = prediction(nodes[n]) if prediction else start[S_] + x * start[V_]
        work.vectors[UNKNOWN, :8] = guess
        assert _approach_step(problem, SCHEME, work, n, h, NEWTON) > 0
        work.approach[n + 1, :, 0] = work.approach[n, :, 8]
    return nodes, np.moveaxis(work.approach[:count, :, 1:], 1, 0), work.approach[count, :, 0].copy()


def _rebounding(count, prediction=None):
    """A rebound over 0.95 of the approach, which is stored much more finely: nodes, u and values there, last state."""
    problem = Problem(1.0, np.array([3.0]), np.array([0.3]), 0.0, 0.0, power_path(1.0))
    work = allocate(1, 2000)
    assert _whole_approach(problem, SCHEME, work, 1e-14, 2e-14, 0.05) == SEPARATED
    sigma_m = float(work.turning_place[0])
    work.rebound[0, :, 0] = work.turning
    work.rebound[0, V_, 0], work.rebound[0, MODES_, 0] = 0.0, 1.0
    h, delay, paces = 0.95 * sigma_m / count, 0.0, []
    nodes = h * (np.arange(count)[:, None] + SCHEME.c[None, 1:])
    for n in range(count):
        _past(problem, SCHEME, work, sigma_m - n * h, h)
        guess = prediction(nodes[n]) if prediction else 2.0 * work.past[S_] if n == 0 else paces[-1][-1]
        work.vectors[UNKNOWN, :8] = guess
        assert _rebound_step(problem, SCHEME, work, n, h, delay, NEWTON) > 0
        paces.append(work.vectors[UNKNOWN, :8].copy())
        delay = work.vectors[DELAY, 7]
        work.rebound[n + 1, :, 0] = work.rebound[n, :, 8]
    values = np.moveaxis(work.rebound[:count, :, 1:], 1, 0)
    return nodes, np.array(paces), values, work.rebound[count, :, 0].copy()


def _slope(counts, errors):
    """Order by least squares; errors between 1e-4 and 1e-12 stand clear of rounding and of Newton's tolerance."""
    assert max(errors) < 1e-4
    assert min(errors) > 1e-12
    return -np.polyfit(np.log(counts), np.log(errors), 1)[0]


def test_order_of_approach_at_the_end_of_elements():
    # Slopes between neighbours scatter by several units, for the leading error oscillates along the swing; the fit over seven
    # lengths is good to about 1.
    end = 20.0
    nodes, values, fine = _swinging(end, 160)
    prediction = CubicSpline(np.r_[0.0, nodes.ravel()], np.r_[1.0, values[S_].ravel()])
    counts = [14, 16, 20, 24, 28, 32, 40]
    errors = [np.linalg.norm((_swinging(end, n, prediction)[2] - fine)[[S_, V_, T_]]) for n in counts]
    assert _slope(counts, errors) == pytest.approx(SCHEME.order, abs=1.0)


def test_order_of_rebound_at_the_end_of_elements():
    # Rounding is reached before the elements are short beside the layer at the turning point. The slope, which still grows
    # towards 2 S - 1 = 15, must be well above the order S + 1 = 9 that holds inside elements, and not above 15.
    nodes, paces, _, fine = _rebounding(100)
    prediction = CubicSpline(nodes.ravel(), paces.ravel())
    counts = [4, 5, 6, 7]
    errors = [np.linalg.norm((_rebounding(n, prediction)[3] - fine)[[V_, T_]]) for n in counts]
    slope = _slope(counts, errors)
    assert SCHEME.stage_order + 0.7 < slope < SCHEME.order


def test_turning_point_of_an_elastic_body():
    # 1/2 = int F dd = int (2/3) s^3 2 s ds = (4/15) s^5
    problem = Problem(1.0, np.zeros(0), np.zeros(0), 0.0, 0.0, power_path(1.0))
    work = allocate(0, 200)
    assert _whole_approach(problem, SCHEME, work, 1e-13, 2e-14, 0.3) == SEPARATED
    assert work.turning[S_] == pytest.approx((15.0 / 8.0) ** 0.2, rel=1e-13)
    assert abs(work.turning[V_]) < 1e-13


@pytest.mark.plain
@pytest.mark.parametrize(
    ("size", "previous", "drift", "full", "renewed", "verdict"),
    [
        (1e-16, np.inf, 0.0, True, False, CONVERGED),
        (1e-3, np.inf, 0.0, True, False, CHORD),
        # Contraction 1e-3: what remains is 1e-3 of the step.
        (1e-11, 1e-8, 0.0, False, False, CONVERGED),
        # The same steps after a drift of 0.1 since the inverses were made: what remains is 1e-12.
        (1e-11, 1e-8, 0.1, False, False, CHORD),
        (4e-4, 1e-3, 1e-3, False, False, FACTOR),
        (3e-3, 1e-3, 1e-3, False, False, DIVERGED),
        # Steps of the size of rounding that do not shrink: first new inverses, then the end.
        (5e-10, 5e-10, 1e-9, False, False, FACTOR),
        (5e-10, 5e-10, 1e-9, False, True, CONVERGED),
    ],
)
def test_verdicts_on_steps_of_newton(size, previous, drift, full, renewed, verdict):
    judge = getattr(newton_verdict, "py_func", newton_verdict)
    assert judge(size, previous, drift, full, renewed, 1e-9, 1e-13) == verdict
