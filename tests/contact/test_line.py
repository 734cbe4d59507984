import math

import numpy as np
import pytest

from restitution.contact.pressure import line_function


def test_a_polynomial_is_one_exact_cell():
    line = line_function(lambda x: 3.0 - x**2 + 0.5 * x**7, extent=2.0)
    assert line.edges.tolist() == [0.0, 2.0]
    x = np.linspace(0.0, 2.0, 33)
    np.testing.assert_allclose(line(x), 3.0 - x**2 + 0.5 * x**7, rtol=1e-13, atol=1e-13)
    assert line(-0.7) == line(0.7)
    assert line(2.000001) == 0.0
    assert line.edge_value == pytest.approx(63.0, rel=1e-14)
    # 2 (6 - 8/3 + 16)
    assert line.integral == pytest.approx(2 * (6 - 8 / 3 + 16), rel=1e-14)


@pytest.mark.parametrize(
    ("function", "breakpoints", "integral"),
    [
        (np.exp, (), 2 * (math.e - 1)),
        (lambda x: np.exp(-x / 1e-3), (), 2e-3),
        (lambda x: np.sqrt(np.maximum(x - 0.3, 0.0)), (0.3,), 4 / 3 * 0.7**1.5),
        (lambda x: np.sqrt(x), (), 4 / 3),
        (lambda x: np.where(x < 0.25, 1.0, 0.0) + x, (0.25,), 1.5),
        (lambda x: np.abs(x - 1 / 3), (), 2 * (1 / 18 + 2 / 9)),
    ],
)
def test_integrals_of_rough_functions(function, breakpoints, integral):
    line = line_function(function, 1.0, breakpoints=breakpoints)
    assert line.integral == pytest.approx(integral, rel=1e-11)


def test_cells_away_from_the_axis_double_at_most():
    line = line_function(lambda x: 1.0 + x, 1.0, breakpoints=[1e-6, 0.4])
    ratio = line.edges[2:] / line.edges[1:-1]
    assert np.max(ratio) <= 2.0
    assert 1e-6 in line.edges
    assert 0.4 in line.edges


def test_breakpoints_outside_or_at_the_ends_are_ignored():
    line = line_function(lambda x: x, 1.0, breakpoints=[-1.0, 0.0, 1e-20, 0.5, 0.5, 1.0, 3.0])
    assert line.edges.tolist() == [0.0, 0.5, 1.0]


def test_slope():
    line = line_function(lambda x: x**3, 2.0, breakpoints=[1.0])
    # d/dx at both ends of the second cell, t = -1 and 1, from its Chebyshev coefficients.
    signs = (-1.0) ** np.arange(line.slope.shape[1])
    np.testing.assert_allclose([line.slope[1] @ signs, line.slope[1].sum()], [3.0, 12.0], rtol=1e-12)


@pytest.mark.parametrize(
    ("function", "extent", "message"),
    [
        (lambda x: x, 0.0, "extent = 0 m: must be finite and > 0"),
        (lambda x: x / np.zeros_like(x + 0.0) if False else x * np.nan, 1.0, "must return 11 finite values"),
        (lambda x: 1.0, 1.0, "must return 11 finite values"),
        (lambda x: np.sin(1e6 * x), 1.0, "unresolved by 4000 cells"),
    ],
)
def test_bad_requests(function, extent, message):
    with pytest.raises(ValueError, match=message):
        line_function(function, extent)
