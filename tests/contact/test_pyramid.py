"""Pyramids: equivalent cones, with the constants of boundary elements."""

import math

import numpy as np
import pytest

import restitution as rs
from refusals import in_one_line

# Some of the impacts are deep.
pytestmark = pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning")
SOLID = rs.Material(rs.PronySeries(1.0, [10.0], [0.1]), math.inf)
# layers.md, section 5.
CONSTANTS = {3: (0.882413, 5e-6), 4: (0.737616, 3e-6), 6: (0.67330, 1e-5)}


@pytest.mark.parametrize("sides", CONSTANTS)
def test_pyramid_is_a_cone_of_the_same_stiffness(sides):
    angle = 1.2
    tip = rs.Pyramid(face_angle=angle, sides=sides)
    assert (tip.constant, tip.uncertainty) == CONSTANTS[sides]
    cone = rs.Cone(math.atan(0.5 * math.pi * tip.constant * math.tan(angle)))
    depth = np.array([-1.0, 0.0, 1e-6, 1.0])
    assert tip.stiffness_radius(depth) == pytest.approx(cone.contact_radius(depth), rel=1e-14)
    # F = 2 E* Pi = c tan(alpha) E* d^2
    assert 2 * tip.force_integral_at_depth(0.3) == pytest.approx(tip.constant * math.tan(angle) * 0.3**2, rel=1e-15)
    result, same = (rs.solve(rs.Impact(SOLID, item, 1.0, [0.5, 1.0])) for item in (tip, cone))
    assert result.restitution_coefficient == pytest.approx(same.restitution_coefficient, rel=1e-12)
    assert result.max_force == pytest.approx(same.max_force, rel=1e-12)


def test_impact_against_boundary_elements_in_time():
    # layers.md, section 3: E* = 4 + 40 exp(-t/0.1), tan(alpha) = 1.
    result = rs.solve(rs.Impact(SOLID, rs.Pyramid(math.pi / 4, 4), mass=1.0, velocity=1.0), rtol=1e-11)
    assert result.restitution_coefficient == pytest.approx(0.2555678197, abs=1e-10)


def test_more_faces_are_nearer_to_a_cone():
    factors = [rs.Pyramid(1.0, sides).constant for sides in (3, 4, 6)]
    assert np.all(np.diff([*factors, 2 / math.pi]) < 0)


def test_contact_area_is_unknown():
    tip = rs.Pyramid(1.4)
    result = rs.solve(rs.Impact(SOLID, tip, mass=1.0, velocity=1.0))
    assert np.isnan(tip.contact_radius([0.0, 1.0])).all()
    # Force, loop, depth and energies.
    assert len(result.plot().axes) == 4


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        ({"face_angle": 1.2, "sides": 5}, "sides"),
        ({"face_angle": 1.2, "sides": True}, "sides"),
        ({"face_angle": 1.2, "sides": "four"}, "sides"),
        ({"face_angle": 1.2, "sides": [3, 4]}, "sides"),
        ({"face_angle": 0.0}, "face_angle"),
        ({"face_angle": math.pi / 2}, "face_angle"),
        ({"face_angle": 65.3}, "face_angle"),
        ({"face_angle": math.nan}, "face_angle"),
    ],
)
def test_bad_input_is_refused(arguments, field):
    assert in_one_line(lambda: rs.Pyramid(**arguments)).field == field


@pytest.mark.parametrize(("angle", "exceeded"), [(65.3, True), (80.0, False)])
def test_validity_report_has_the_slope_of_the_faces(angle, exceeded):
    result = rs.solve(rs.Impact(SOLID, rs.Pyramid(math.radians(angle), 3), mass=1.0, velocity=1.0)).validity
    assert result["small_strain"].value == pytest.approx(1 / math.tan(math.radians(angle)))
    assert result["small_strain"].exceeded is exceeded
    assert "slope of the faces" in result["small_strain"].message
    assert result["density"].value is None
