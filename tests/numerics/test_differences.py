"""Derivatives from nine values: exact for polynomials, with errors that cover what noise and curvature do."""

import math
from typing import Any

import numpy as np
import pytest

from restitution.numerics.differences import BESIDE, CENTRAL, FORWARD, NINE, STEP, Stencil, slopes

RNG = np.random.default_rng()


@pytest.mark.parametrize("side", range(3))
def test_polynomials_of_degree_eight_are_exact(side: int) -> None:
    coefficients = RNG.uniform(-1.0, 1.0, (9, 50))
    x = 0.1 * BESIDE[side]
    values = np.einsum("kn,kp->pn", coefficients, x ** np.arange(9)[:, None])
    slope = slopes(coefficients[0], values, side)
    # Weights of at most 70 times rounding errors of values of at most 9, over a slope per step of 0.1.
    assert np.abs(slope.first - 0.1 * coefficients[1]).max() < 1e-11


@pytest.mark.parametrize("side", range(3))
def test_errors_cover_sines_of_any_pace(side: int) -> None:
    """The derivative of sin(k p + c) by p at 0 is k cos(c)."""
    pace, phase = 10.0 ** RNG.uniform(-3.0, -0.3, 2000), RNG.uniform(0.0, 2.0 * math.pi, 2000)
    slope = slopes(np.sin(phase), np.sin(BESIDE[side][:, None] * pace + phase), side)
    missed = np.abs(slope.first - pace * np.cos(phase)) > slope.error
    # The eighth difference is far above the error of order 8; for slow sines, whose values have rounding errors alone,
    # the estimate has the chances of the test of noise below.
    assert missed.mean() < 0.1
    assert np.median(slope.error) < 1e-5


@pytest.mark.parametrize("side", range(3))
def test_errors_cover_noise(side: int) -> None:
    noise = 1e-9 * RNG.standard_normal((9, 5000))
    slope = slopes(1.0 + noise[0], np.exp(0.02 * BESIDE[side])[:, None] + noise[1:], side)
    missed = np.abs(slope.first - 0.02) > slope.error
    # Twice the noise in the slope, whose size comes from two differences only; 95 per cent for a known size.
    assert missed.mean() < 0.2
    assert np.median(slope.error) < 30.0 * np.std(slope.first)


def test_sides_by_element() -> None:
    x = np.stack([BESIDE[0], BESIDE[2]], axis=1)
    slope = slopes(np.ones(2), np.exp(0.01 * x), np.array([0, 2]))
    assert np.allclose(slope.first, 0.01, rtol=1e-11, atol=0.0)
    # Of first order to one side.
    assert np.allclose(slope.second, 1e-4, rtol=0.02, atol=0.0)


@pytest.mark.parametrize("stencil", [FORWARD, CENTRAL, *NINE])
def test_stencils_are_exact_for_polynomials_of_their_order(stencil: Stencil) -> None:
    """Products of polynomials in three coordinates, whose degree is the number of places, at four random points."""
    n = stencil.places.size
    coefficients = RNG.uniform(-1.0, 1.0, (3, n + 1))
    at, steps = RNG.uniform(-1.0, 1.0, (4, 3)), np.array([0.1, 0.0, 0.3])
    factors = [np.polynomial.Polynomial(each) for each in coefficients]

    def function(x: Any) -> Any:
        return np.prod([each(x[..., k]) for k, each in enumerate(factors)], axis=0)

    points = stencil.points(at, steps)
    assert points.shape == (4, 1 + 2 * n, 3)
    slopes = stencil.slopes(function(points).T, steps)
    exact = [function(at) / factors[k](at[:, k]) * factors[k].deriv()(at[:, k]) for k in range(3)]
    # Rounding errors of products of polynomials below 9 (1 + 0.3 n)^n, with weights of at most 70, over 0.1.
    atol = 1e-15 * 9.0**3 * (1.0 + 0.3 * n) ** n * np.abs(stencil.weights).sum() / 0.1
    assert np.allclose(slopes[[0, 2]], [exact[0], exact[2]], rtol=0.0, atol=atol)
    assert np.all(slopes[1] == 0.0)


def test_a_side_without_a_value_is_left_out() -> None:
    """The derivative of ln x at x = h/2: there is no value at x - h."""
    steps = np.array([0.1])
    with np.errstate(invalid="ignore"):
        values = np.log(CENTRAL.points(np.array([0.05]), steps)[:, 0])
    assert np.isnan(CENTRAL.slopes(values, steps)).all()
    assert CENTRAL.slopes(values, steps, one_sided=True) == pytest.approx(math.log(3.0) / 0.1, rel=1e-12)


def test_steps_of_a_fit_balance_curvature_and_rounding() -> None:
    """Central differences of exp(x) at 0 are sinh(h)/h, so that their error is h^2/6 and rounding."""
    steps = np.array([STEP])
    slope = CENTRAL.slopes(np.exp(CENTRAL.points(np.zeros(1), steps)[:, 0]), steps)
    assert abs(slope[0] - 1.0) < STEP**2 / 6.0 + 2.0 * np.finfo(float).eps / STEP
