"""Derivatives from nine values: exact for polynomials, with errors that cover what noise and curvature do."""

import math

import numpy as np
import pytest

from restitution.numerics.differences import PLACES, slopes

RNG = np.random.default_rng()


@pytest.mark.parametrize("side", range(3))
def test_polynomials_of_degree_eight_are_exact(side: int) -> None:
    coefficients = RNG.uniform(-1.0, 1.0, (9, 50))
    x = 0.1 * PLACES[side]
    values = np.einsum("kn,kp->pn", coefficients, x ** np.arange(9)[:, None])
    slope = slopes(values, side)
    # Weights of at most 70 times rounding errors of values of at most 9, over a slope per step of 0.1.
    assert np.abs(slope.first - 0.1 * coefficients[1]).max() < 1e-11


@pytest.mark.parametrize("side", range(3))
def test_errors_cover_sines_of_any_pace(side: int) -> None:
    """The derivative of sin(k p + c) by p at 0 is k cos(c)."""
    pace, phase = 10.0 ** RNG.uniform(-3.0, -0.3, 2000), RNG.uniform(0.0, 2.0 * math.pi, 2000)
    slope = slopes(np.sin(PLACES[side][:, None] * pace + phase), side)
    missed = np.abs(slope.first - pace * np.cos(phase)) > slope.error
    # The eighth difference is far above the error of order 8; for slow sines, whose values have rounding errors alone,
    # the estimate has the chances of the test of noise below.
    assert missed.mean() < 0.1
    assert np.median(slope.error) < 1e-5


@pytest.mark.parametrize("side", range(3))
def test_errors_cover_noise(side: int) -> None:
    noise = 1e-9 * RNG.standard_normal((9, 5000))
    slope = slopes(np.exp(0.02 * PLACES[side])[:, None] + noise, side)
    missed = np.abs(slope.first - 0.02) > slope.error
    # Twice the noise in the slope, whose size comes from two differences only; 95 per cent for a known size.
    assert missed.mean() < 0.2
    assert np.median(slope.error) < 30.0 * np.std(slope.first)


def test_sides_by_element() -> None:
    x = np.stack([PLACES[0], PLACES[2]], axis=1)
    slope = slopes(np.exp(0.01 * x), np.array([0, 2]))
    assert np.allclose(slope.first, 0.01, rtol=1e-11, atol=0.0)
    # Of first order to one side.
    assert np.allclose(slope.second, 1e-4, rtol=0.02, atol=0.0)
