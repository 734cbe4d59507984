import numpy as np
import pytest

from restitution.contact.profile import Parabola
from restitution.contact.sphere import Sphere
from restitution.contact.validity import (
    SIZE_LIMIT,
    SPEED_LIMIT,
    STRAIN_LIMIT,
    half_space,
    quasi_static,
    small_strain,
)


def test_no_warning_at_the_limits():
    assert small_strain(STRAIN_LIMIT, 0.01, radius=1.0) == []
    assert small_strain(1.0, STRAIN_LIMIT) == []
    assert quasi_static(SPEED_LIMIT, 1.0) == []
    assert half_space(SIZE_LIMIT, 1.0) == []


@pytest.mark.parametrize(
    ("warnings", "parts"),
    [
        (small_strain(0.21, 0.05, radius=1.0), ("contact radius over R reaches 0.21", "about 4.2 %")),
        (small_strain(1.0, 0.5), ("depth over contact radius reaches 0.5", "about 10 %")),
        # 1.04 * 0.02^0.6 = 0.0995
        (quasi_static(2.0, 100.0), ("velocity over wave speed is 0.02", "some 9.9 % of the energy")),
        (quasi_static(100.0, 100.0), ("velocity over wave speed is 1 ", "more than half of the energy")),
        # 0.2266 + 0.05132 + 0.006152 + 0.000156 = 0.284
        (half_space(0.2, 1.0), ("contact radius over body size is 0.2", "some 28 % stiffer")),
        (half_space(3.0, 1.0), ("contact radius over body size is 3 ", "several times stiffer")),
    ],
)
def test_warnings_carry_their_numbers(warnings, parts):
    assert len(warnings) == 1
    for part in parts:
        assert part in warnings[0]


def test_the_worst_of_an_array_is_reported():
    velocities = np.array([1e-3, 5.0, 0.5])
    assert "is 0.05 " in quasi_static(velocities, 100.0)[0]
    assert quasi_static(np.empty(0), 100.0) == []


def test_depth_over_contact_radius_is_a_over_r_for_a_parabola():
    ball = Parabola(0.02)
    assert ball.transform(3e-3) / 3e-3 == pytest.approx(3e-3 / 0.02)


def test_the_softness_of_the_exact_sphere_at_the_limit():
    # The 0.4 % that the strain limit is argued with.
    depth = STRAIN_LIMIT**2
    ratio = Sphere(1.0).force_integral_at_depth(depth) / Parabola(1.0).force_integral_at_depth(depth)
    assert 1 - ratio == pytest.approx(0.004, abs=1e-4)
