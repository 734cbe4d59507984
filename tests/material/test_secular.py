from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from restitution.material.prony import secular_roots
from restitution.material.secular import log_ratio
from strategies import logarithmic

pytestmark = pytest.mark.plain


def exact(constant, viscosity, weights, times, point):
    """S(-point) in rational arithmetic."""
    total = Fraction(constant) - Fraction(viscosity) * point
    for weight, time in zip(weights.tolist(), times.tolist(), strict=True):
        total += Fraction(weight) * point / (point - 1 / Fraction(time))
    return total


@st.composite
def equations(draw):
    times = sorted(set(draw(st.lists(logarithmic(1e-10, 1e10), max_size=12))), reverse=True)
    weights = draw(st.lists(logarithmic(1e-12, 1e12), min_size=len(times), max_size=len(times)))
    constant = draw(st.sampled_from((0.0, 1.0)) | logarithmic(1e-12, 1e12))
    viscosity = draw(st.sampled_from((0.0, 1.0)) | logarithmic(1e-12, 1e12))
    return constant, viscosity, np.array(weights), np.array(times)


@given(equations())
def test_roots_interlace_and_exact_arithmetic_changes_sign_at_each(equation):
    constant, viscosity, _, times = equation
    roots = secular_roots(*equation)
    expected = max(times.size - 1, 0) + (constant > 0) + (viscosity > 0) - (times.size == 0)
    assert roots.times.size == max(expected, 0)
    poles = [1 / Fraction(time) for time in times.tolist()]
    for time in roots.times.tolist():
        low, high = (1 / (Fraction(time) * (1 + sign * Fraction(1, 10**13))) for sign in (1, -1))
        if any(low <= pole <= high for pole in poles):
            continue
        # S(-lambda) falls with lambda between two poles.
        assert exact(*equation, low) > 0 > exact(*equation, high)


@given(equations())
def test_slope_is_that_of_the_terms(equation):
    """lambda S'(-lambda) = b lambda + sum E_k T_k (T_k - 1), T_k = lambda/(lambda - lambda_k)."""
    _, viscosity, weights, _ = equation
    roots = secular_roots(*equation)
    t = roots.terms
    if weights.size:
        expected = viscosity / roots.times + (t * (t - 1.0)) @ weights
        # The relative error of the sum is that of the offsets from the poles.
        size = np.abs(t).max(axis=1)
        assert np.all(np.abs(roots.slopes / expected - 1.0) <= 1e-13 + 1e-14 * size)


@pytest.mark.parametrize("weight", [float(f"1e{n}") for n in range(-22, 0)])
def test_residues_of_two_roots_beside_a_weak_pole(weight):
    """1/S at s > 0 from its residues, with a weak third pole at a root of the other two."""
    alone = secular_roots(1.0, 0.0, np.array([1.0, 1.0]), np.array([1.0, 0.25])).times
    for time in alone:
        times = np.sort([1.0, 0.25, time])[::-1]
        weights = np.where(times == time, weight, 1.0)
        roots = secular_roots(1.0, 0.0, weights, times)
        for s in (1e-3, 1.0, 5.0, 1e3):
            expected = 1.0 / (1.0 + (weights * s * times / (1.0 + s * times)).sum())
            inverse = 1.0 / (1.0 + weights.sum()) + (1.0 / roots.slopes / (1.0 + s * roots.times)).sum()
            assert inverse == pytest.approx(expected, rel=3e-15)


def test_offset_is_accurate_where_the_root_rounds_to_its_pole():
    """S = 1 + w/(1 - lambda_1/lambda) has its root at lambda_1/(1 + w), the residue's slope at (1 + w)/w."""
    for weight in (1e-3, 1e-16, 1e-30, 1e-200):
        roots = secular_roots(1.0, 0.0, np.array([weight]), np.array([3.0]))
        assert roots.times == pytest.approx([3.0 * (1.0 + weight)], rel=4e-16, abs=0)
        assert roots.terms == pytest.approx(np.array([[-1.0 / weight]]), rel=1e-15, abs=0)
        assert roots.slopes == pytest.approx([(1.0 + weight) / weight], rel=1e-15, abs=0)


def test_quadratic_with_two_poles():
    """1 + L/(L-1) + L/(L-4) = 0 gives 3L^2 - 10L + 4 = 0."""
    roots = secular_roots(1.0, 0.0, np.array([1.0, 1.0]), np.array([1.0, 0.25]))
    assert 1.0 / roots.times == pytest.approx(np.sort(np.roots([3.0, -10.0, 4.0])), rel=1e-15, abs=0)


def test_negative_constant_moves_the_last_root_above_the_poles():
    """-3 + L/(L-1) = 0 at L = 3/2; -3 + L/(L-1) + L/(L-4) = 0 gives L^2 - 10L + 12 = 0."""
    assert secular_roots(-3.0, 0.0, np.array([1.0]), np.array([1.0])).times == pytest.approx(
        [1.0 / 1.5], rel=1e-15, abs=0
    )
    roots = secular_roots(-3.0, 0.0, np.array([1.0, 1.0]), np.array([1.0, 0.25]))
    assert 1.0 / roots.times == pytest.approx(np.sort(np.roots([1.0, -10.0, 12.0])), rel=1e-14, abs=0)


def test_no_roots_of_a_single_maxwell_branch():
    assert secular_roots(0.0, 0.0, np.array([1.0]), np.array([1.0])).times.size == 0


def test_log_ratio_of_neighbouring_floats():
    plain = getattr(log_ratio, "py_func", log_ratio)
    assert plain(np.nextafter(1.0, 2.0), 1.0) == pytest.approx(np.spacing(1.0), rel=1e-15, abs=0)
