import math

import numpy as np
import pytest

from restitution import Impact, Material, PronySeries, solve
from restitution.contact.profiles import Parabola, Sphere, sphere_mass

# L, the root of L tanh(L) = d, for R = 1, and ((1 + u^2) L - u)/2 with u = tanh(L): mpmath, 40 digits.
ROOTS = {
    1e-14: (1.00000000000000167e-7, 6.66666666666665999e-22),
    1e-6: (0.0010000001666666972, 6.66666599999999161e-10),
    0.01: (0.100166972559055508, 0.000665999921121290966),
    0.3: (0.576662216545076424, 0.106248778292466807),
    1.0: (1.19967864025773383, 0.599839320128866917),
    3.0: (3.01448277603377281, 2.50243698968065569),
    20.0: (20.0000000000000002, 19.5),
}


@pytest.mark.parametrize("depth", ROOTS)
def test_against_high_precision(depth):
    rapidity, force_integral = ROOTS[depth]
    ball = Sphere(radius=1.0)
    assert ball.contact_radius(depth) == pytest.approx(math.tanh(rapidity), rel=4e-16)
    assert ball.force_integral_at_depth(depth) == pytest.approx(force_integral, rel=2e-15)
    scaled = Sphere(radius=3.0)
    assert scaled.contact_radius(3.0 * depth) == pytest.approx(3.0 * math.tanh(rapidity), rel=6e-16)
    assert scaled.force_integral_at_depth(3.0 * depth) == pytest.approx(9.0 * force_integral, rel=2e-15)


def test_small_contacts_are_those_of_the_parabola():
    ball, parabola = Sphere(0.01), Parabola(0.01)
    a = 1e-6
    # g = (x^2/R)(1 + u^2/3 + ...) and Pi = (2 a^3/(3R))(1 + 2 u^2/5 + ...), u = a/R = 1e-4
    assert ball.transform(a) / parabola.transform(a) == pytest.approx(1 + 1e-8 / 3, rel=1e-15)
    assert ball.force_integral(a) / parabola.force_integral(a) == pytest.approx(1 + 4e-9, rel=1e-15)
    assert ball.shape(1e-9) == pytest.approx(0.5e-16, rel=1e-13)


def test_force_integral_is_smooth_where_the_series_ends():
    below, above = Sphere(1.0).force_integral(np.array([0.25 - 1e-9, 0.25 + 1e-9]))
    # dPi/da = a g'(a) with g' = artanh(a) + a/(1 - a^2).
    slope = 0.25 * (math.atanh(0.25) + 0.25 / (1.0 - 0.25**2))
    assert (above - below) / 2e-9 == pytest.approx(slope, rel=1e-6)


def test_equator():
    ball = Sphere(radius=2.0)
    assert ball.shape(2.0) == 2.0
    assert ball.max_contact_radius == 2.0
    for method in (ball.transform, ball.force_integral):
        np.testing.assert_array_equal(method([2.0, 3.0]), [math.inf, math.inf])
    assert ball.shape(2.1) == math.inf
    assert ball.contact_radius(1e4) == 2.0


def test_force_below_that_of_the_parabola():
    # The docstring states 0.4 % at a depth of 0.04 R, where the parabola has a/R = 0.2.
    ratio = Sphere(1.0).force_integral_at_depth(0.04) / Parabola(1.0).force_integral_at_depth(0.04)
    assert ratio == pytest.approx(0.996, abs=1e-4)


@pytest.mark.parametrize("depth", [30.0, 300.0, 3000.0])
def test_deep_spheres_are_solved_to_the_tolerance(depth):
    """Beyond a few radii a sphere acts as a cylinder with a rounded edge, whose full width acts on fast modes."""
    random = np.random.default_rng(int(depth))
    for _ in range(5):
        terms = random.integers(1, 8)
        moduli, times = 10.0 ** random.uniform(-3.0, 3.0, terms), depth * 10.0 ** random.uniform(-6.0, 2.0, terms)
        series = PronySeries(1.0, moduli, times)
        # The energy of a cylinder of radius 1 pressed in to this depth, with the modulus after this time.
        mass = 8.0 * float(series.relaxation_modulus(depth)) * depth**2
        impact = Impact(Material(series, np.inf), Sphere(1.0), mass, 1.0)
        fine, e = solve(impact, rtol=1e-12), solve(impact, rtol=1e-9).restitution_coefficient
        assert fine.max_indentation_depth > 0.1 * depth
        assert abs(e - fine.restitution_coefficient) < 1e-9 * max(e, 1e-3)


def test_a_mass_beyond_the_range_of_numbers_is_infinite():
    assert sphere_mass(1e3, np.array([1e103])).tolist() == [np.inf]
