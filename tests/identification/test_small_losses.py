"""Loss of single weak branches: the kernel k(x) of 1 - e, against a double integral and closed forms."""

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq
from scipy.special import beta

from restitution.impact.batch import Batch
from restitution.impact.closed_forms import HERTZ_TIME_FACTOR

EPSILON = 1e-6


def kernel(ratios):
    """(1 - e)/epsilon of a spring of modulus 1 with a branch epsilon at tau, by contact time over tau."""
    ones = np.ones(len(ratios))
    depth = (15.0 / 16.0) ** 0.4
    times = HERTZ_TIME_FACTOR * depth / np.asarray(ratios)
    batch = Batch(ones, 0.0 * ones, EPSILON * ones[:, None], times[:, None], ones, ones, 0.0 * ones, ones, 1.0)
    return (1.0 - batch.solve(1e-12)["restitution_coefficient"]) / EPSILON


@pytest.fixture(scope="module")
def hertz():
    """Depth over largest depth of an elastic impact, over time in units of depth over velocity, and the contact time."""
    touch = lambda t, y: y[0]  # noqa: E731
    touch.terminal, touch.direction = True, -1
    motion = solve_ivp(
        lambda t, y: (y[1], -1.25 * max(y[0], 0.0) ** 1.5), (0.0, 4.0), (0.0, 1.0), events=touch, dense_output=True,
        rtol=1e-11, atol=1e-13,
    )  # fmt: skip
    return motion.sol, motion.t_events[0][0]


def double_integral(x, hertz):
    """k = (15/8) int_0^1 dy int int exp(-(t - s)/tau) z'(s) z'(t) ds dt over the contact of the element at y a_max."""
    motion, end = hertz
    tau = end / x

    def element(y):
        start = brentq(lambda t: motion(t)[0] - y * y, 0.0, 0.5 * end) if y > 0.0 else 0.0
        # Both times are in the middle of cells; the memory is exact for a constant velocity in each cell.
        edges = np.linspace(start, end - start, 4001)
        velocity, width = motion(0.5 * (edges[1:] + edges[:-1]))[1], edges[1] - edges[0]
        decay, memory, total = math.exp(-width / tau), 0.0, 0.0
        gain, mean = tau * (1.0 - decay), tau * (1.0 - tau / width * (1.0 - decay))
        for v in velocity:
            total += v * (memory * gain + v * mean * width)
            memory = memory * decay + v * gain
        return total

    nodes, weights = np.polynomial.legendre.leggauss(12)
    # y = 1 - w^2 has a fine resolution for the elements that touch last.
    w = 0.5 * (nodes + 1.0)
    return 15.0 / 8.0 * sum(a * w_ * element(1.0 - w_**2) for a, w_ in zip(weights, w, strict=True))


def test_the_hertz_motion_ends_at_the_known_time(hertz):
    assert hertz[1] == pytest.approx(HERTZ_TIME_FACTOR, rel=1e-8)


@pytest.mark.parametrize("x", [0.1, 1.0, 3.2, 10.0, 100.0])
def test_the_exact_solver_gives_the_double_integral_over_the_elements(x, hertz):
    assert kernel([x])[0] == pytest.approx(double_integral(x, hertz), rel=1e-3)


@pytest.mark.parametrize(("x", "reference"), [(0.1, 0.04284), (1.0, 0.31248), (10.0, 0.39033), (100.0, 0.05426)])
def test_values_of_the_design_page(x, reference):
    assert kernel([x])[0] == pytest.approx(reference, abs=1.5e-5)


def test_the_largest_value_is_0_519_at_3_9(hertz):
    # The design page gives 0.512 at 3.2, the largest value of its grid.
    assert kernel([3.2])[0] == pytest.approx(0.512, abs=5e-4)
    assert double_integral(3.9, hertz) == pytest.approx(0.5186, rel=1e-3)
    ratios = np.linspace(2.0, 8.0, 61)
    values = kernel(ratios)
    assert ratios[np.argmax(values)] == pytest.approx(3.9, abs=0.15)
    assert values.max() == pytest.approx(0.5186, abs=1e-4)


def test_a_slow_branch_loses_four_ninths_of_the_ratio():
    # (5/4) int z^(5/2) dt/T of the motion, less a fifth for elements that leave early: 4/9.
    motion = quad(lambda z: z**2.5 / math.sqrt(1.0 - z**2.5), 0.0, 1.0)[0]
    duration = quad(lambda z: 1.0 / math.sqrt(1.0 - z**2.5), 0.0, 1.0)[0]
    assert motion / duration == pytest.approx(4.0 / 9.0, rel=1e-6)
    assert kernel([1e-3])[0] / 1e-3 == pytest.approx(4.0 / 9.0, rel=2e-3)


def test_a_fast_branch_is_a_dashpot():
    # 4 eta sqrt(R) int sqrt(d) v dd over m v^2, which is (16/15) E sqrt(R) D^(5/2).
    limit = 1.5 * HERTZ_TIME_FACTOR * beta(0.6, 1.5)
    assert limit == pytest.approx(5.568, abs=5e-4)
    assert kernel([1e4])[0] * 1e4 == pytest.approx(limit, rel=2e-3)


def test_flat_losses_are_1_204_loss_tangents():
    # int k dln x = 1.8917, and a flat spectrum H has E'' = (pi/2) H.
    logs = np.linspace(math.log(1e-5), math.log(1e6), 400)
    integral = np.trapezoid(kernel(np.exp(logs)), logs)
    assert integral == pytest.approx(1.8917, abs=2e-3)
    assert integral / (0.5 * math.pi) == pytest.approx(1.204, abs=2e-3)
