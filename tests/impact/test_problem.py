"""Input of an impact and its error messages."""

import inspect
import math

import numpy as np
import pytest

import restitution as rs
from refusals import named
from restitution import Impact, Material, Parabola, PowerLaw, PronySeries, Sphere

RUBBER = Material(PronySeries(1e6, [1e7], [1e-4]), 1e9)
BALL = Parabola(radius=0.01)


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"mass": 0.0}, ("mass", 0.0)),
        ({"mass": math.nan}, ("mass", math.nan)),
        ({"velocity": -1.0}, ("velocity", -1.0)),
        ({"velocity": math.inf}, ("velocity", math.inf)),
        ({"velocity": [1.0, 0.0]}, ("velocity", 1, 0.0)),
        ({"external_force": -1e-9}, ("external_force", -1e-9)),
        ({"mass": [1.0, 2.0], "velocity": [1.0, 2.0, 3.0]}, ("mass, velocity, external_force, impedance, profile",)),
    ],
)
def test_numbers_out_of_range_are_refused(options, expected):
    assert named(lambda: Impact(RUBBER, BALL, **({"mass": 1.0, "velocity": 1.0} | options))) == expected


def test_all_inputs_are_described():
    lines = {line.strip() for line in inspect.getdoc(Impact).splitlines()}
    described = {name for line in lines if " : " in line for name in line.split(" : ")[0].split(", ")}
    assert set(inspect.signature(Impact).parameters) <= described


@pytest.mark.parametrize(
    "wrong",
    [
        {"material": 1e6}, {"profile": 0.01}, {"counter_material": "steel"}, {"mass": "1 kg"}, {"velocity": None},
        {"external_force": True},
    ],
)  # fmt: skip
def test_wrong_types_are_refused(wrong):
    sound = {"material": RUBBER, "profile": BALL, "mass": 1.0, "velocity": 1.0}
    assert named(lambda: Impact(**(sound | wrong)), TypeError) == next(iter(wrong.items()))


def test_all_numbers_broadcast_also_those_of_the_profile():
    several = Impact(RUBBER, Parabola(np.full((4, 1, 1), 0.01)), np.ones((3, 1)), [1.0, 2.0], external_force=0.1)
    assert several.shape == (4, 3, 2)
    assert Impact(RUBBER, PowerLaw(2.0, [1.0, 2.0]), 1.0, 1.0).shape == (2,)
    assert Impact(RUBBER, Sphere(0.01), 1, 1).shape == ()


def test_an_impact_copies_its_arrays():
    velocity = np.array([1.0, 2.0])
    impact = Impact(RUBBER, BALL, 1.0, velocity)
    velocity[0] = 7.0
    assert impact.velocity[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        impact.velocity[0] = 7.0
    with pytest.raises(AttributeError):
        impact.mass = 2.0


def test_a_radius_whose_inverse_overflows_is_refused():
    ball = rs.Body(rs.elastic(shear_modulus=1e6, poisson_ratio=0.3), radius=1e-320, mass=0.005)
    assert named(lambda: rs.collision(ball, rs.Body(None, radius=0.005, mass=0.005), velocity=1.0)) == ("radius", 0.0)
