import math

import numpy as np
import pytest

from restitution.contact.profiles import Cone, FlatEndedParabola, Parabola, TruncatedCone

# d/(b cot alpha): a/b and Pi/(b^2 cot alpha) from the root of theta = D cos(theta): mpmath, 40 digits.
ROOTS = {
    1e-6: (1.0000000000005, 1.00000000000016662e-6),
    0.3: (1.04285405283759788, 0.304367770896564567),
    40.0: (26.101566508434243, 535.072531936488088),
    1e8: (63661977.8733779067, 3183098925499884.27),
}


@pytest.mark.parametrize("depth", ROOTS)
def test_truncated_cone_against_high_precision(depth):
    face, slope = 0.002, 1 / math.tan(1.2)
    tip = TruncatedCone(radius=face, half_angle=1.2)
    radius, force_integral = ROOTS[depth]
    # A few roundings, including those of the argument.
    assert tip.contact_radius(depth * face * slope) == pytest.approx(radius * face, rel=2e-15)
    found = tip.force_integral_at_depth(depth * face * slope)
    assert found == pytest.approx(force_integral * face**2 * slope, rel=4e-15)


def test_deep_contacts_are_those_of_the_full_cone_or_parabola():
    depth = 1e6
    cone, tip = Cone(1.2), TruncatedCone(1e-6, 1.2)
    assert tip.contact_radius(depth) == pytest.approx(float(cone.contact_radius(depth)), rel=1e-11)
    parabola, worn = Parabola(2.0), FlatEndedParabola(2.0, 1e-6)
    assert worn.force_integral_at_depth(1.0) == pytest.approx(float(parabola.force_integral_at_depth(1.0)), rel=1e-12)


@pytest.mark.parametrize("tip", [TruncatedCone(0.01, 1.2), FlatEndedParabola(0.5, 0.01)])
def test_shallow_contacts_are_those_of_the_punch(tip):
    depth = np.array([1e-30, 1e-12, 1e-9])
    np.testing.assert_allclose(tip.force_integral_at_depth(depth), 0.01 * depth, rtol=1e-9)
    np.testing.assert_array_equal(tip.transform([0.0, 0.005, 0.01]), 0.0)
    np.testing.assert_array_equal(tip.shape([0.0, 0.005, 0.01]), 0.0)


def test_worn_ball_in_closed_form():
    # F = 2 E* Pi = (2/(3R)) E* (2 a^2 + b^2) sqrt(a^2 - b^2) with R = 2, b = 0.3, a = 0.5: the root is 0.4.
    worn = FlatEndedParabola(radius=2.0, face_radius=0.3)
    assert worn.transform(0.5) == pytest.approx(0.5 * 0.4 / 2.0, rel=1e-15)
    assert 2 * worn.force_integral(0.5) == pytest.approx(2 / 6 * (0.5 + 0.09) * 0.4, rel=1e-15)
