"""Collision of two bodies as one impact: reduced radius, reduced mass, symmetric pairs."""

import math

import numpy as np
import pytest

from refusals import named, refusal
from restitution import Body, Impact, Material, Parabola, PronySeries, collision, solve, standard_solid

# Many of these bodies exceed the limits of the theory.
pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")

RUBBER = standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45, density=1200.0)
STEEL = Material(8e10, 1.6e11, density=7800.0)
SOFT = Material(PronySeries(2e5, [1e6, 3e6], [1e-4, 1e-2]), 1e9)


def test_full_sphere_of_known_density():
    assert Body(RUBBER, radius=0.01).mass == pytest.approx(1200.0 * 4.0 / 3.0 * math.pi * 1e-6, rel=1e-14)
    assert Body(RUBBER, radius=0.01, mass=0.3).mass == 0.3
    assert Body(RUBBER).mass == math.inf
    assert Body(None).radius == math.inf
    assert Body(RUBBER, radius=[0.01, 0.02]).mass[1] == Body(RUBBER, radius=0.02).mass


def test_reduced_radius_and_mass():
    # 1/(1/2 + 1/3) = 1.2, 1/(1/4 + 1/6) = 2.4
    impact = collision(Body(SOFT, radius=2.0, mass=4.0), Body(STEEL, radius=3.0, mass=6.0), velocity=0.7)
    assert impact.profile.radius == pytest.approx(1.2, rel=1e-15)
    assert impact.mass == pytest.approx(2.4, rel=1e-15)
    assert impact.velocity == 0.7
    assert (impact.material, impact.counter_material) == (SOFT, STEEL)


def test_ball_on_rigid_wall_is_an_impact_on_a_half_space():
    impact = collision(Body(RUBBER, radius=0.01), Body(None), velocity=1.3, external_force=0.1)
    plain = Impact(RUBBER, Parabola(0.01), Body(RUBBER, radius=0.01).mass, 1.3, external_force=0.1)
    assert solve(impact).restitution_coefficient == solve(plain).restitution_coefficient
    assert impact.counter_material is None


def test_the_bodies_may_be_exchanged():
    first, other = Body(RUBBER, radius=0.01), Body(SOFT, radius=0.03, mass=0.02)
    forth, back = (solve(collision(*pair, velocity=1.0)) for pair in ((first, other), (other, first)))
    assert forth.restitution_coefficient == pytest.approx(back.restitution_coefficient, rel=2e-9)
    assert forth.max_force == pytest.approx(back.max_force, rel=1e-9)


def test_rubber_on_steel_is_rubber_on_a_rigid_body():
    rubber, steel, rigid = Body(RUBBER, radius=0.01), Body(STEEL), Body(None)
    on_steel, on_rigid = (solve(collision(rubber, wall, velocity=1.0)) for wall in (steel, rigid))
    # The ratio of the compliances is 1e-5.
    assert on_steel.restitution_coefficient == pytest.approx(on_rigid.restitution_coefficient, rel=1e-4)
    assert on_steel.restitution_coefficient != on_rigid.restitution_coefficient
    both_elastic = solve(collision(Body(STEEL, radius=0.01), steel, velocity=1.0))
    assert both_elastic.restitution_coefficient == pytest.approx(1.0, abs=1e-9)


def test_hertz_of_two_elastic_spheres():
    # Each body has E* = 4 G (3 K + G)/(3 K + 4 G); their compliances add.
    glass = Material(3e10, 4e10)

    def plane(body):
        shear, bulk = body.shear.equilibrium_modulus, body.bulk.equilibrium_modulus
        return 4.0 * shear * (3.0 * bulk + shear) / (3.0 * bulk + 4.0 * shear)

    modulus = 1.0 / (1.0 / plane(STEEL) + 1.0 / plane(glass))
    result = solve(collision(Body(STEEL, 0.01, 0.03), Body(glass, 0.02, 0.06), velocity=0.1))
    depth = (15.0 * 0.02 * 0.01 / (16.0 * modulus * math.sqrt(0.02 / 3.0))) ** 0.4
    assert result.max_indentation_depth == pytest.approx(depth, rel=1e-9)


def test_sizes_and_velocities_broadcast():
    impact = collision(Body(RUBBER, radius=[[0.01], [0.02]]), Body(None), velocity=[0.5, 1.0, 2.0])
    assert impact.shape == (2, 3)
    result = solve(impact).restitution_coefficient
    alone = solve(collision(Body(RUBBER, radius=0.02), Body(None), velocity=1.0))
    assert result[1, 1] == alone.restitution_coefficient
    held = Body(None, radius=0.02, mass=math.inf)
    walls = collision(Body(RUBBER, radius=[0.01, math.inf], mass=1.0), held, velocity=1.0)
    assert walls.profile.radius == pytest.approx([0.02 / 3.0, 0.02], rel=1e-15)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Body(SOFT, radius=0.1), "mass: must be given for a ball whose material has no density"),
        (lambda: Body(RUBBER, radius=[0.1, math.inf]), "mass: must be given where some of the bodies are walls"),
        (
            lambda: collision(Body(RUBBER, mass=1.0), Body(None), 1.0),
            "radius = inf m: both bodies are flat, but one must be curved",
        ),
        (lambda: collision(Body(RUBBER, 0.1, math.inf), Body(None), 1.0), "mass = inf kg: both bodies are immovable"),
        (
            lambda: collision(Body(None, 0.1, 1.0), Body(None), 1.0),
            "material: both bodies are rigid, but one must deform",
        ),
        (lambda: Body("rubber"), "material = 'rubber': must be a Material, or None for a rigid body"),
        (lambda: collision(Body(RUBBER, radius=0.01), None, 1.0), "body_2 = None: must be a Body"),
    ],
)
def test_invalid_pairs_are_refused(make, message):
    assert str(refusal(make)) == message


@pytest.mark.parametrize(
    ("make", "expected"),
    [
        (lambda: Body(RUBBER, radius=0.0), ("radius", 0.0)),
        (lambda: Body(RUBBER, radius=-math.inf, mass=1.0), ("radius", -math.inf)),
        (lambda: Body(RUBBER, radius=[math.inf, -1.0], mass=1.0), ("radius", 1, -1.0)),
        (lambda: Body(RUBBER, radius=0.1, mass=math.nan), ("mass", math.nan)),
        (lambda: Body(None, radius=0.1), ("mass",)),
        (lambda: Body(RUBBER, radius="big"), ("radius", "big")),
        (lambda: collision(Body(RUBBER, 0.1), Body(None), 0.0), ("velocity", 0.0)),
    ],
)
def test_invalid_numbers_are_named(make, expected):
    assert named(make) == expected


def test_bodies_copy_their_arrays():
    radius = np.array([0.01, math.inf])
    body = Body(RUBBER, radius=radius, mass=1.0)
    radius[0] = 7.0
    assert body.radius[0] == 0.01
    with pytest.raises(ValueError, match="read-only"):
        body.radius[0] = 7.0
