"""Orders of the kernel's elements (S = 8) against Hairer & Wanner, Solving ODEs II, 2nd ed., IV.5.

Elements of constant length are compared with much shorter ones. Newton's method starts from the fine solution, because
the kernel's own predictions are too poor for the long elements of these tests.
"""

import numpy as np
import pytest
from numpy.polynomial.legendre import legvander
from scipy.interpolate import CubicSpline

from restitution.kernel.approach import approach, approach_element
from restitution.kernel.collocation import Scheme, interpolate_lanes, radau
from restitution.kernel.compile import entry_point
from restitution.kernel.element import CHORD, CONVERGED, DIVERGED, FACTOR, newton_verdict
from restitution.kernel.kinks import _missed
from restitution.kernel.lanes import read8, write8
from restitution.kernel.outcome import SEPARATED
from restitution.kernel.path import power_path, radii_and_integrals
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
    Problem,
    allocate,
)  # fmt: skip

SCHEME = radau(8)
NEWTON = 1e-14


@entry_point
def _approach_step(problem, scheme, work, element, h, accept):
    return approach_element(problem, scheme, work, work.approach[element], h, accept)


@entry_point
def _past(problem, scheme, work, start, h):
    sigma = start - h * read8(scheme.c, 1)
    interpolate_lanes(scheme, work, work.approach, sigma, work.counts[N_APPROACH], work.past)
    integral = radii_and_integrals(problem.path, read8(work.past, S_, 0), work.vectors[VALUES:])[1]
    write8(work.vectors, INTEGRAL, 0, integral)


@entry_point
def _rebound_step(problem, scheme, work, element, h, delay, accept):
    return rebound_element(problem, scheme, work, work.rebound[element], h, delay, accept)


@entry_point
def _whole_approach(problem, scheme, work, tolerance, accept, first):
    return approach(problem, scheme, work, tolerance, accept, first, False)


def _changed() -> Scheme:
    """The scheme with one coefficient changed in the sixth digit."""
    A = SCHEME.A.copy()
    A[3, 4] *= 1.0 + 3e-6
    return SCHEME._replace(A=A, columns=A.T.copy(), square=(A @ A).T.copy())


def _swinging(end, count, prediction=None, scheme=SCHEME, admittance=0.0):
    """Nodes, stored elements and state at `end` of a body that swings under a constant force from s = 1 on."""
    problem = Problem(1.0, np.array([0.1]), np.array([1.0]), 0.0, 0.7, admittance, power_path(1.0))
    work, h = allocate(1, count + 1), end / count
    state = work.approach[0, :, 0]
    state[:] = 0.0
    state[S_], state[V_], state[F_] = 1.0, 0.5, 2.0 / 3.0
    nodes = h * (np.arange(count)[:, None] + SCHEME.c[None, 1:])
    for n in range(count):
        start = work.approach[n, :, 0]
        x = nodes[n] - n * h
        guess = prediction(nodes[n]) if prediction else start[S_] + x * start[V_]
        work.vectors[UNKNOWN, :8] = guess
        assert _approach_step(problem, scheme, work, n, h, NEWTON) > 0
        work.approach[n + 1, :, 0] = work.approach[n, :, 8]
    return nodes, work.approach[:count].copy(), work.approach[count, :, 0].copy()


def _inside(tables, end, sigma):
    """Rows at sigma of elements of equal length up to `end` (barycentric interpolation)."""
    count = len(tables)
    element = np.minimum((sigma * count / end).astype(int), count - 1)
    terms = SCHEME.weights / (sigma[:, None] * count / end - element[:, None] - SCHEME.c)
    return np.einsum("ej,enj->en", terms, tables[element]) / terms.sum(axis=1)[:, None]


class _Rebound:
    """Rebound under a constant force; the reference has a fine approach and 196 short elements in the rebound."""

    def __init__(self, admittance=0.0):
        self.problem = Problem(1.0, np.array([1.0]), np.array([2.0]), 0.0, 0.4, admittance, power_path(1.0))
        self.work = allocate(1, 2000)
        assert _whole_approach(self.problem, SCHEME, self.work, 1e-14, 2e-14, 0.05) == SEPARATED
        self.sigma_m = float(self.work.turning_place[0])
        start = self.work.turning.copy()
        start[V_], start[MODES_] = 0.0, 1.0
        self.length = 0.005 * self.sigma_m
        self.prediction = None
        self.states, self.delays, nodes, paces = self.march(0, 196, 196, start, 0.0)
        self.prediction = CubicSpline(nodes.ravel(), paces.ravel())

    def march(self, first, last, count, state, delay, scheme=SCHEME):
        """States, delays, nodes and paces of `count` equal elements between the starts of two short elements."""
        work, low, h = self.work, first * self.length, (last - first) * self.length / count
        work.rebound[0, :, 0] = state
        delays, paces = [delay], []
        nodes = low + h * (np.arange(count)[:, None] + SCHEME.c[None, 1:])
        for n in range(count):
            _past(self.problem, scheme, work, self.sigma_m - low - n * h, h)
            last_pace = paces[-1][-1] if paces else 2.0 * work.past[S_]
            work.vectors[UNKNOWN, :8] = self.prediction(nodes[n]) if self.prediction else last_pace
            assert _rebound_step(self.problem, scheme, work, n, h, delays[-1], NEWTON) > 0
            paces.append(work.vectors[UNKNOWN, :8].copy())
            delays.append(work.vectors[DELAY, 7])
            work.rebound[n + 1, :, 0] = work.rebound[n, :, 8]
        return work.rebound[: count + 1, :, 0].copy(), delays, nodes, np.array(paces)

    def error(self, count, scheme=SCHEME):
        """Error of velocity and time after `count` long elements that begin behind the layer at the turning point."""
        first, last = 24, 196
        state = self.march(first, last, count, self.states[first], self.delays[first], scheme)[0][-1]
        return np.linalg.norm((state - self.states[last])[[V_, T_]])


def _slope(counts, errors):
    """Order of convergence by least squares."""
    return -np.polyfit(np.log(counts), np.log(errors), 1)[0]


def swinging(**options):
    nodes, tables, state = _swinging(20.0, 160, **options)
    prediction = CubicSpline(np.r_[0.0, nodes.ravel()], np.r_[1.0, tables[:, S_, 1:].ravel()])
    return prediction, tables, state


@pytest.fixture(scope="module")
def swing():
    return swinging()


@pytest.fixture(scope="module")
def rebounding():
    return _Rebound()


def check_orders(swing, **options):
    # The leading error oscillates along the swing: slopes between neighbours scatter by several units, and a fit over
    # seven lengths by about 1. The errors, 1e-5 to 1e-12, lie well above rounding and Newton's tolerance.
    prediction, fine, state = swing
    counts = [14, 16, 20, 24, 28, 32, 40]
    ends, insides = [], []
    for n in counts:
        _, tables, end = _swinging(20.0, n, prediction, **options)
        ends.append(np.linalg.norm((end - state)[[S_, V_, T_]]))
        places = 20.0 / n * (np.arange(n) + 0.437)
        difference = _inside(tables, 20.0, places) - _inside(fine, 20.0, places)
        insides.append(np.abs(difference[:, V_]).max())
    assert min(ends) > 1e-12
    assert _slope(counts, ends) == pytest.approx(SCHEME.order, abs=1.0)
    assert _slope(counts, insides) == pytest.approx(SCHEME.stage_order, abs=1.0)


def test_orders_of_the_approach(swing):
    check_orders(swing)


@pytest.mark.slow
def test_order_of_the_rebound(rebounding):
    # Two to four elements cover nine tenths of the rebound, with errors from 5e-10 to 2e-14. The errors of shorter
    # elements are lost in rounding. A single element is too long for the leading term to dominate.
    counts = [2, 3, 4]
    errors = [rebounding.error(n) for n in counts]
    assert min(errors) > 5e-15
    assert _slope(counts, errors) == pytest.approx(SCHEME.order, abs=1.0)


def test_orders_on_a_target_that_moves():
    admittance = 0.05
    check_orders(swinging(admittance=admittance), admittance=admittance)
    rebound = _Rebound(admittance)
    # The error of four elements is close to rounding.
    assert _slope([2, 3, 4], [rebound.error(n) for n in (2, 3, 4)]) == pytest.approx(SCHEME.order, abs=1.5)


@pytest.mark.slow
def test_a_wrong_coefficient_lowers_the_orders(swing, rebounding):
    # With one of the 64 coefficients wrong in the sixth digit, the errors hardly fall.
    prediction, _, state = swing
    counts = [14, 20, 40]
    ends = [_swinging(20.0, n, prediction, _changed())[2] for n in counts]
    assert _slope(counts, [np.linalg.norm((end - state)[[S_, V_, T_]]) for end in ends]) < 6.0
    counts = [2, 3, 4]
    assert _slope(counts, [rebounding.error(n, _changed()) for n in counts]) < 3.0


def test_turning_point_of_an_elastic_body():
    # 1/2 = int F dd = int (2/3) s^3 2 s ds = (4/15) s^5
    problem = Problem(1.0, np.zeros(0), np.zeros(0), 0.0, 0.0, 0.0, power_path(1.0))
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
        # Contraction 1e-3: the remaining error is 1e-3 of the step.
        (1e-11, 1e-8, 0.0, False, False, CONVERGED),
        # The same steps after a drift of 0.1 since the inverses were computed: the remaining error is 1e-12.
        (1e-11, 1e-8, 0.1, False, False, CHORD),
        (4e-4, 1e-3, 1e-3, False, False, FACTOR),
        (3e-3, 1e-3, 1e-3, False, False, DIVERGED),
        # Steps as small as rounding that do not shrink: first new inverses, then convergence.
        (5e-10, 5e-10, 1e-9, False, False, FACTOR),
        (5e-10, 5e-10, 1e-9, False, True, CONVERGED),
    ],
)
def test_verdicts_on_steps_of_newton(size, previous, drift, full, renewed, verdict):
    judge = getattr(newton_verdict, "py_func", newton_verdict)
    assert judge(size, previous, drift, full, renewed, 1e-9, 1e-13) == verdict


@pytest.mark.plain
@pytest.mark.parametrize("degree", [0, 7, 13, 14, 15])
def test_the_estimate_for_a_rough_rate_is_the_error_of_the_rule(degree):
    """What Radau's rule misses of x f and of (1 - x) f, where f = x^degree; closed forms.

    The rule on 2 S points is exact below the degree 2 S, where it misses the integral of their node polynomial.
    """
    stages = SCHEME.c.size - 1
    nodes, both = SCHEME.c[1:], np.append(SCHEME.c[1:], SCHEME.between)
    weights = np.linalg.solve(legvander(2.0 * nodes - 1.0, stages - 1).T, np.eye(stages)[0])

    def error(power):
        beyond = np.poly1d(both, r=True).integ()(1.0) if power == 2 * stages else 0.0
        return 1.0 / (power + 1.0) - beyond - weights @ nodes**power

    later = error(degree + 1)
    expected = 0.5 * (abs(later) + abs(error(degree) - later))
    estimate = getattr(_missed, "py_func", _missed)(SCHEME, 0.5, nodes**degree, SCHEME.between**degree, 0.0)
    assert estimate == pytest.approx(expected, rel=1e-6, abs=1e-14)
