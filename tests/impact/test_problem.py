"""Input of an impact and its error messages."""

import math

import numpy as np
import pytest

import restitution as rs
from restitution import Impact, InputError, Material, Parabola, PowerLaw, PronySeries, Sphere

RUBBER = Material(PronySeries(1e6, [1e7], [1e-4]), 1e9)
BALL = Parabola(radius=0.01)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"mass": 0.0}, "mass = 0 kg: must be finite and > 0"),
        ({"mass": math.nan}, "mass = nan kg: must be finite and > 0"),
        ({"velocity": -1.0}, "velocity = -1 m/s: must be finite and > 0"),
        ({"velocity": math.inf}, "velocity = inf m/s: must be finite and > 0"),
        ({"velocity": [1.0, 0.0]}, r"velocity\[1\] = 0 m/s: must be finite and > 0"),
        ({"external_force": -1e-9}, "external_force = -1e-09 N: must be finite and >= 0"),
        (
            {"mass": [1.0, 2.0], "velocity": [1.0, 2.0, 3.0]},
            r"mass, velocity, external_force, impedance, profile: .* broadcast .* mass \(2,\), velocity \(3,\), .*",
        ),
    ],
)
def test_numbers_out_of_range_are_refused(options, message):
    with pytest.raises(ValueError, match=f"^{message}$"):
        Impact(RUBBER, BALL, **({"mass": 1.0, "velocity": 1.0} | options))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"material": 1e6}, r"^material = 1e\+06: must be a Material$"),
        ({"profile": 0.01}, r"^profile = 0\.01: must be a Geometry$"),
        ({"counter_material": "steel"}, r"^counter_material = 'steel': must be a Material$"),
        ({"mass": "1 kg"}, r"^mass = '1 kg': must be a real number"),
        ({"velocity": None}, r"^velocity = None: must be a real number"),
        ({"external_force": True}, r"^external_force = True: must be a real number"),
    ],
)
def test_wrong_types_are_refused(options, message):
    with pytest.raises(TypeError, match=message):
        Impact(**({"material": RUBBER, "profile": BALL, "mass": 1.0, "velocity": 1.0} | options))


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


def test_compliances_of_two_bodies_add():
    # Two equal incompressible springs 4 G in series.
    alone = Impact(Material(3.0, math.inf), BALL, 1.0, 1.0).reduced_modulus
    pair = Impact(Material(3.0, math.inf), BALL, 1.0, 1.0, counter_material=Material(3.0, math.inf)).reduced_modulus
    assert alone.equilibrium_modulus == 12.0
    assert pair.equilibrium_modulus == pytest.approx(6.0, rel=1e-15)


def test_a_radius_whose_inverse_overflows_is_refused():
    ball = rs.Body(rs.elastic(shear_modulus=1e6, poisson_ratio=0.3), radius=1e-320, mass=0.005)
    with pytest.raises(InputError, match="radius"):
        rs.collision(ball, rs.Body(None, radius=0.005, mass=0.005), velocity=1.0)
