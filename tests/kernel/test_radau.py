"""Coefficients and orders of the collocation: Hairer & Wanner, Solving ODEs II, 2nd ed., IV.5, tables 5.5 and 5.6."""

import math

import numpy as np
import pytest

from restitution.kernel.collocation import radau

pytestmark = pytest.mark.plain


def test_three_stages_are_the_published_tableau():
    root = math.sqrt(6.0)
    A = [
        [(88 - 7 * root) / 360, (296 - 169 * root) / 1800, (-2 + 3 * root) / 225],
        [(296 + 169 * root) / 1800, (88 + 7 * root) / 360, (-2 - 3 * root) / 225],
        [(16 - root) / 36, (16 + root) / 36, 1 / 9],
    ]
    assert pytest.approx(np.array(A), abs=4e-16) == radau(3).A
    assert radau(3).c == pytest.approx([0, (4 - root) / 10, (4 + root) / 10, 1], abs=4e-16)


@pytest.mark.parametrize("stages", range(2, 13))
def test_collocation_integrates_the_basis_exactly(stages):
    scheme = radau(stages)
    nodes = scheme.c[1:]
    for power in range(stages):
        assert scheme.A @ nodes**power == pytest.approx(nodes ** (power + 1) / (power + 1), abs=1e-13)


def test_tail_is_the_last_legendre_coefficients():
    scheme = radau(4)
    x = 2.0 * scheme.c - 1.0
    values = 3.0 + np.polynomial.legendre.legval(x, [0, 0, 0, 0.25, -0.5])
    assert scheme.tail @ values == pytest.approx([0.25, -0.5], abs=1e-13)


def test_derivative_of_a_polynomial():
    scheme = radau(5)
    assert scheme.derivative @ scheme.c**5 == pytest.approx(5.0 * scheme.c**4, abs=1e-12)


def test_missed_is_the_error_of_the_quadrature():
    scheme = radau(6)
    # Exact up to degree 2 S - 2, where the difference of both rules vanishes, and to 2 S - 1 with twice the nodes.
    for power, error in [(0, 0.0), (5, 0.0), (10, 0.0), (11, 1 / 12 - scheme.A[-1] @ scheme.c[1:] ** 11)]:
        result = scheme.missed[0] @ scheme.c[1:] ** power + scheme.missed[1] @ scheme.between**power
        assert result == pytest.approx(error, abs=1e-15)
    assert scheme.c**6 @ scheme.at_between == pytest.approx(scheme.between**6, abs=1e-14)
    assert scheme.c[1:] ** 5 @ scheme.at_between_inner == pytest.approx(scheme.between**5, abs=1e-14)


@pytest.mark.parametrize("stages", [1, 13])
def test_stages_out_of_range(stages):
    with pytest.raises(ValueError, match=rf"^stages = {stages}: must be in \[2, 12\]"):
        radau(stages)


def _errors(stages: int, steps: int) -> tuple[float, float]:
    """Errors at the end and inside the elements for y' = y cos(3 t), y(0) = 1, exp(sin(3 t)/3), up to t = 2."""
    scheme = radau(stages)
    h = 2.0 / steps
    y0, inside, x = 1.0, 0.0, 0.37
    terms = scheme.weights / (x - scheme.c)
    for n in range(steps):
        rate = np.cos(3.0 * h * (n + scheme.c[1:]))
        y = np.linalg.solve(np.eye(stages) - h * scheme.A * rate, np.full(stages, y0))
        value = terms @ np.append(y0, y) / terms.sum()
        inside = max(inside, abs(value - math.exp(math.sin(3.0 * (n + x) * h) / 3.0)))
        y0 = y[-1]
    return abs(y0 - math.exp(math.sin(6.0) / 3.0)), inside


@pytest.mark.parametrize("stages", [2, 3, 4])
def test_declared_orders(stages):
    # The steps must be short enough for the leading term and long enough for errors above rounding.
    steps = {2: 8, 3: 8, 4: 16}[stages]
    coarse, fine = _errors(stages, steps), _errors(stages, 2 * steps)
    end, inside = (math.log2(a / b) for a, b in zip(coarse, fine, strict=True))
    assert end == pytest.approx(radau(stages).order, abs=0.15)
    assert inside == pytest.approx(radau(stages).stage_order, abs=0.15)
