"""Descents against the certified values of NIST and against SciPy."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from restitution.numerics.least_squares import descend

# Misra1a of the Statistical Reference Datasets of NIST, https://www.itl.nist.gov/div898/strd/nls/data/misra1a.shtml:
# y = b1 (1 - exp(-b2 x)), both starts, the certified values and the residual sum of squares.
X = np.array([77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0])
Y = np.array([10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78])
STARTS = np.log([[500.0, 1e-4], [250.0, 5e-4]])
CERTIFIED, SQUARES = np.array([2.3894212918e02, 5.5015643181e-04]), 1.2455138894e-01
FREE = np.full((2, 2), np.inf)


def misra(points, _):
    """Residuals over the logarithms of the constants."""
    size, rate = np.exp(points[..., 0, None]), np.exp(points[..., 1, None])
    return -size * np.expm1(-rate * X) - Y


def slopes(points, _):
    """Their derivatives."""
    size, rate = np.exp(points[:, 0, None]), np.exp(points[:, 1, None])
    return np.stack([-size * np.expm1(-rate * X), size * rate * X * np.exp(-rate * X)], axis=1)


@pytest.mark.parametrize("steps", [np.full(2, 1e-6), slopes], ids=["differences", "derivatives"])
def test_both_starts_lead_to_the_certified_values(steps):
    ends = descend(misra, STARTS, -FREE, FREE, steps, FREE[0], 1e-12, 100)
    assert ends.ended.all()
    assert np.exp(ends.points) == pytest.approx(np.tile(CERTIFIED, (2, 1)), rel=1e-7)
    assert ends.costs == pytest.approx(SQUARES, rel=1e-9)


def test_derivatives_take_a_call_for_each_point():
    calls = {"values": 0, "slopes": 0}

    def counted(points, places):
        calls["values"] += points.shape[0] * points.shape[1]
        return misra(points, places)

    def derivatives(points, places):
        calls["slopes"] += points.shape[0]
        return slopes(points, places)

    # Residuals are taken at the points alone, at no neighbours: one start, and one trial in each of five rounds.
    descend(counted, STARTS[1:], -FREE[1:], FREE[1:], derivatives, FREE[0], 0.0, 5)
    assert calls["values"] == 6
    assert calls["slopes"] <= 5


@pytest.mark.parametrize("seed", range(5))
def test_bounds_of_many_linear_problems(seed):
    """The minimum of a convex problem within a box is unique; SciPy solves one at a time."""
    rng = np.random.default_rng(seed)
    matrices, targets = rng.normal(size=(6, 12, 4)), rng.normal(size=(6, 12))
    low, high = -rng.uniform(0.01, 0.3, (6, 4)), rng.uniform(0.01, 0.3, (6, 4))
    ends = descend(
        lambda points, places: np.einsum("snq,skq->skn", matrices[places], points) - targets[places, None],
        0.5 * (low + high), low, high, lambda points, places: matrices[places].swapaxes(1, 2), np.full(4, np.inf),
        1e-14, 200,
    )  # fmt: skip
    for end, matrix, target, least, most in zip(ends.points, matrices, targets, low, high, strict=True):
        assert end == pytest.approx(lsq_linear(matrix, target, (least, most), tol=1e-14).x, abs=1e-6)
