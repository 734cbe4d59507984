"""The tangential half of the contact law: order, Coulomb's law, energy, rolling, and refusals."""

import math
from dataclasses import replace

import numpy as np
import pytest

from refusals import in_one_line
from restitution import (
    Cone,
    Ellipsoid,
    FlatPunch,
    Impact,
    Layer,
    Material,
    Parabola,
    PronySeries,
    contact_law,
    solve,
    standard_solid,
    vary,
)
from restitution.law.slide import HEAD, SPAN, TILES, WAY, tiles_size
from restitution.law.step import step

RUBBER = Material(PronySeries(1e6, [3e6, 5e6, 2e6], [1e-5, 3e-4, 2e-3]), 2e7)
LIQUID = Material(PronySeries(0.0, [1e7], [1e-3]), PronySeries(1e7, [4e7], [1e-3]))
BALL = Impact(RUBBER, Parabola(0.01), 0.005, 1.0)


def throw(law, velocity, along, dt, *, gap=0.0, gyration=0.4):
    """One impact by velocity Verlet; e and e_t along each axis, and the work done against the tangential force."""
    mass = float(law.impact.mass)
    mobility = (1.0 + 1.0 / gyration) / mass
    state, depth, v, normal = law.start(depth=-gap), -gap, velocity, 0.0
    first = np.array(along, dtype=float)
    point, pull, work = first.copy(), np.zeros(2), [0.0]
    while normal > 0.0 or v > 0.0:
        v -= 0.5 * dt * normal / mass
        point = point - 0.5 * dt * mobility * pull
        depth, before = depth + v * dt, pull
        normal, pull = law.step(state, depth, dt, way=point * dt)
        work.append(work[-1] + 0.5 * (before + pull) @ point * dt)
        v -= 0.5 * dt * normal / mass
        point = point - 0.5 * dt * mobility * pull
    return -v / velocity, -point, np.array(work)


def unit_impact(nu: float, p2: float, p3: float) -> Impact:
    return Impact(standard_solid(1.0, 1.0 / p2, p3, poisson_ratio=nu), Parabola(1.0), mass=1.0, velocity=1.0)


def worst_error(law, exact: float, contact_time: float, velocity: float, steps: int) -> float:
    """Largest error of e_t of first touches at different places within a step."""
    dt = contact_time / steps
    throws = [throw(law, 1.0, (velocity, 0.0), dt, gap=gap * dt) for gap in (0.0, 0.3, 0.6)]
    return max(abs(point[0] / velocity - exact) for _, point, _ in throws)


# e_t of the reference values and the closed form of full sliding, section 8 and 9 of the theory.
ROWS = [(0.5, 0.1, 1.0, 1.0, 0.0817924), (0.3, 0.1, 1.0, 2.0, 0.0529265), (0.5, 0.1, 1.0, 4.0, 0.0654873)]


@pytest.mark.parametrize("row", ROWS)
def test_error_of_reference_values_falls_with_the_square_of_the_step(row):
    *solid, theta, e_t = row
    impact, friction = unit_impact(*solid), 0.3
    law, time = contact_law(impact, friction=friction, max_nodes=500), float(solve(impact).contact_time)
    counts = (25, 50, 100, 200, 400)
    errors = [worst_error(law, e_t, time, theta * friction, count) for count in counts]
    assert np.polyfit(np.log(counts), np.log(errors), 1)[0] < -1.8
    assert errors[1] < 2e-3


@pytest.mark.parametrize("profile", [Parabola(0.01), Cone(1.3), FlatPunch(0.002)], ids=lambda x: type(x).__name__)
@pytest.mark.parametrize("materials", [(RUBBER, None), (LIQUID, None), (RUBBER, LIQUID)], ids=str)
def test_small_steps_give_oblique_impacts(profile, materials):
    impact = Impact(materials[0], profile, 0.005, 1.0, counter_material=materials[1])
    exact = solve(vary(impact, {"friction": 0.3, "tangential_velocity": 0.4}))
    e_t, time = float(exact.tangential_restitution_coefficient), float(exact.contact_time)
    coarse = worst_error(contact_law(impact, friction=0.3), e_t, time, 0.4, 50)
    fine = worst_error(contact_law(impact, friction=0.3, max_nodes=300), e_t, time, 0.4, 200)
    assert coarse < 3e-3
    assert fine < max(coarse / 8.0, 1e-4)


def test_a_dashpot_is_of_first_order_at_least():
    impact = Impact(Material(PronySeries(3e6, parallel_viscosity=300.0), 1e7), Parabola(0.01), 0.005, 1.0)
    exact = solve(vary(impact, {"friction": 0.3, "tangential_velocity": 0.4}))
    e_t, time = float(exact.tangential_restitution_coefficient), float(exact.contact_time)
    law = contact_law(impact, friction=0.3, max_nodes=500)
    assert worst_error(law, e_t, time, 0.4, 400) < worst_error(law, e_t, time, 0.4, 100) / 2.0 < 5e-4


def test_the_error_of_a_thinned_foundation_falls_with_the_square_of_the_nodes():
    exact = solve(vary(BALL, {"friction": 0.3, "tangential_velocity": 0.4}))
    e_t, time = float(exact.tangential_restitution_coefficient), float(exact.contact_time)
    for nodes, limit in ((16, 3e-2), (32, 4e-3), (64, 1e-3)):
        for steps in (200, 800):
            assert worst_error(contact_law(BALL, friction=0.3, max_nodes=nodes), e_t, time, 0.4, steps) < limit


@pytest.mark.parametrize("seed", range(40))
def test_a_random_oblique_impact_never_gains_energy(seed):
    rng = np.random.default_rng(seed)
    nu, gyration = rng.uniform(-0.9, 0.5), rng.uniform(0.2, 0.7)
    impact = unit_impact(nu, 10.0 ** rng.uniform(-3.0, 1.0), 10.0 ** rng.uniform(-3.0, 2.0))
    friction, theta = 10.0 ** rng.uniform(-2.0, 2.0), 10.0 ** rng.uniform(-1.3, 1.0)
    direction = rng.uniform(0.0, 2.0 * math.pi)
    along = theta * friction * np.array([math.cos(direction), math.sin(direction)])
    law = contact_law(impact, friction=friction, max_nodes=int(rng.choice([8, 32])))
    dt = float(solve(impact, rtol=1e-4).contact_time) / rng.choice([25, 50, 100])
    e, point, work = throw(law, 1.0, along, dt, gap=rng.uniform() * dt, gyration=gyration)
    assert 0.0 <= e <= 1.0
    assert np.hypot(*point) <= np.hypot(*along)
    assert work.min() >= -1e-12 * work.max()


def random_motion(rng, times):
    """Smooth motion from 0, with harmonics up to a fifth of the duration."""
    phases, weights = rng.uniform(0.0, 2.0 * math.pi, 5), rng.normal(size=5) / np.arange(1, 6)
    return (np.sin(2.0 * math.pi * np.arange(1, 6) * times[:, None] + phases) - np.sin(phases)) @ weights


@pytest.mark.parametrize("seed", range(30))
def test_any_motion_obeys_coulomb_and_never_yields_energy(seed):
    rng = np.random.default_rng(seed)
    branches = (10.0 ** rng.uniform(-1.0, 1.0, 2), 10.0 ** rng.uniform(-2.5, 0.0, 2)) if seed % 3 else ()
    series = PronySeries(1.0, *branches, parallel_viscosity=0.02 * (seed % 3 == 2))
    material = Material(series, rng.choice([math.inf, 0.5, 5.0]))
    friction, nodes = 10.0 ** rng.uniform(-1.0, 1.5), int(rng.choice([10, 32]))
    law = contact_law(Impact(material, Parabola(1.0), 1.0, 1.0), friction=friction, max_nodes=nodes)
    times = np.linspace(0.0, 1.0, 1001)
    depths = random_motion(rng, times)
    depths = depths if depths.max() > 0.5 * np.abs(depths).max() else -depths
    places = np.stack([random_motion(rng, times), random_motion(rng, times)], axis=1) * 10.0 ** rng.uniform(-2.0, 1.0)
    state, before, work = law.start(), np.zeros(2), [0.0]
    for depth, way in zip(depths[1:], np.diff(places, axis=0), strict=True):
        normal, pull = law.step(state, depth, times[1], way=way)
        assert np.hypot(*pull) <= friction * normal * (1.0 + 1e-12)
        work.append(work[-1] + 0.5 * (before + pull) @ way)
        before = pull
    assert min(work) >= -1e-12 * max(work)


def test_the_friction_of_an_impact_is_that_of_its_law():
    law = contact_law(vary(BALL, {"friction": 0.3, "tangential_velocity": 0.4}))
    assert law.friction == 0.3
    assert law.grip.tolist() == contact_law(BALL, friction=0.3).grip.tolist()
    assert contact_law(vary(BALL, {"friction": 0.3}), friction=0.2).friction == 0.2


@pytest.mark.parametrize("seed", range(12))
def test_no_step_of_an_elastic_contact_stores_more_than_its_work(seed):
    """The springs of the tiles hold G u^2 over their radii on both sides, which the work of each step bounds."""
    rng = np.random.default_rng(seed)
    friction, nodes = 10.0 ** rng.uniform(-0.5, 1.5), int(rng.choice([10, 40]))
    law = contact_law(Impact(Material(1.0, 2.0), Parabola(1.0), 1.0, 1.0), friction=friction, max_nodes=nodes)
    angle = np.linspace(0.0, 40.0, 2000)
    depths = np.minimum(angle, 1.0) + 10.0 ** rng.uniform(-2.0, -0.3) * np.sin(angle) * np.minimum(angle, 1.0)
    places = 10.0 ** rng.uniform(-3.0, 0.0) * np.sin(angle * rng.choice([1.0, 2.0, 3.0]) + rng.uniform(0.0, 6.0))
    state, before, stored = law.start(), 0.0, 0.0
    tiles = state[-tiles_size(0, nodes) :]
    rows = tiles[HEAD:].reshape(-1, nodes)
    assert law.shear_modulus is not None
    for depth, way in zip(depths[1:], np.diff(places), strict=True):
        _, pull = law.step(state, depth, 0.02, way=way)
        count = int(tiles[TILES])
        after = law.shear_modulus.equilibrium_modulus * rows[SPAN, :count] @ rows[WAY, :count] ** 2
        work = 0.5 * (before + pull) * way
        # Where the motion turns within the step in which a tile drops its load, the trapezoid of the work is short.
        assert after - stored <= work + 1e-3 * abs(before * way) + 1e-9 * max(after, stored)
        before, stored = pull, after


@pytest.mark.plain
def test_a_contact_that_slides_throughout_has_the_whole_friction():
    law, dt = contact_law(BALL, friction=0.3), 1e-5
    state = law.start()
    for depth in 1e-4 * np.sin(np.linspace(0.0, math.pi, 60))[1:]:
        normal, (along, across) = law.step(state, depth, dt, way=(3e-3, -4e-3))
        assert (along, across) == pytest.approx((0.18 * normal, -0.24 * normal), rel=1e-12)


def test_the_axes_may_be_turned():
    """The law knows no direction: a turned way has the turned force."""
    rng = np.random.default_rng(2)
    law, dt, turn = contact_law(BALL, friction=0.2), 2e-5, 0.7
    matrix = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    first, second = law.start(), law.start()
    for depth, way in zip(
        1e-4 * np.sin(np.linspace(0.0, 9.0, 201))[1:], rng.normal(size=(200, 2)) * 2e-6, strict=True
    ):
        _, pull = law.step(first, depth, dt, way=way)
        _, turned = law.step(second, depth, dt, way=matrix @ way)
        assert turned == pytest.approx(matrix @ pull, abs=1e-9 * max(np.hypot(*pull), 1e-3))


def test_without_a_way_there_is_no_tangential_force():
    """A ball that rolls without slip, v_x + R w = 0, feels none, and the normal force is that without friction."""
    law, plain, dt = contact_law(BALL, friction=0.5, max_nodes=32), contact_law(BALL), 1e-5
    state, other = law.start(), plain.start()
    velocity, radius = 1.3, 0.01
    spin = -velocity / radius
    for depth in 1e-4 * np.sin(np.linspace(0.0, 9.0, 200))[1:]:
        normal, pull = law.step(state, depth, dt, way=(velocity + radius * spin) * dt)
        assert pull == 0.0
        assert normal == step(plain.constants, other, depth, dt)


def test_a_sliding_ball_comes_to_roll():
    """A solid ball set down without spin rolls at 5/7 of its velocity, whatever the friction: angular momentum."""
    mass, radius, weight, start = 0.005, 0.01, 0.005 * 9.81, 0.05
    material = Material(PronySeries(1e5, [1e5], [1e-2]), math.inf)
    law = contact_law(Impact(material, Parabola(radius), mass, 1.0), friction=0.4)
    state, dt = law.start(), 2e-4
    depth, v, normal, pull, velocity, spin = 0.0, 0.0, 0.0, 0.0, start, 0.0
    for _ in range(1500):
        v += 0.5 * dt * (weight - normal) / mass
        velocity -= 0.5 * dt * pull / mass
        spin -= 0.5 * dt * pull * radius / (0.4 * mass * radius**2)
        depth += v * dt
        normal, pull = law.step(state, depth, dt, way=(velocity + radius * spin) * dt)
        v += 0.5 * dt * (weight - normal) / mass
        velocity -= 0.5 * dt * pull / mass
        spin -= 0.5 * dt * pull * radius / (0.4 * mass * radius**2)
    assert velocity == pytest.approx(5.0 / 7.0 * start, rel=1e-3)
    assert spin == pytest.approx(-velocity / radius, rel=1e-3)
    assert abs(pull) < 1e-3 * weight


def test_a_held_shear_relaxes_to_the_equilibrium_modulus():
    """A stuck contact has the force 2 G* a way (Mindlin); the edge, without normal load, does not stick."""
    law, dt, way = contact_law(BALL, friction=1e3, max_nodes=200), 1e-5, 1e-7
    state, depths = law.start(), np.linspace(0.0, 1e-4, 151)[1:]
    for depth in depths:
        law.step(state, depth, dt, way=0.0)
    law.step(state, depths[-1], dt, way=way)
    held = [law.step(state, depths[-1], 1e-4, way=0.0)[1] for _ in range(3000)]
    assert law.shear_modulus is not None
    mindlin = 2.0 * law.shear_modulus.equilibrium_modulus * math.sqrt(0.01 * 1e-4) * way
    assert held[-1] == pytest.approx(mindlin, rel=1.0 / 150)


def test_many_contacts_equal_single_ones():
    rng, law, dt = np.random.default_rng(4), contact_law(BALL, friction=0.3), 2e-5
    depths = 1e-4 * np.sin(np.linspace(0.0, 6.0, 100)[1:, None] + rng.uniform(0.0, 0.2, 5)) - 1e-5
    ways = rng.normal(size=(99, 5)) * 1e-6
    together, alone = law.start(5), [law.start() for _ in range(5)]
    for depth, way in zip(depths, ways, strict=True):
        normal, pull = law.step(together, depth, dt, way=way)
        singles = [law.step(alone[n], depth[n], dt, way=way[n]) for n in range(5)]
        assert [(float(a), float(b)) for a, b in zip(normal, pull, strict=True)] == singles
    normal, pull = law.step(together, depths[0], dt, way=np.zeros((5, 2)))
    assert pull.shape == (5, 2)


@pytest.mark.slow
def test_compiled_code_gives_the_same():
    import numba

    law, dt = contact_law(BALL, friction=0.3), 2e-5
    press, drag = law.compiled, law.compiled_slide

    @numba.njit
    def march(state, depths, ways, pulls):
        for n in range(depths.size):
            drag(state, press(state, depths[n], dt), ways[n], dt, pulls[n])

    depths, ways = 1e-4 * np.sin(np.linspace(0.0, 6.0, 100)[1:]), np.random.default_rng(1).normal(size=(99, 2)) * 1e-6
    pulls, state = np.zeros((99, 2)), law.start()
    march(law.start(), depths, ways, pulls)
    expected = [law.step(state, depth, dt, way=way)[1].tolist() for depth, way in zip(depths, ways, strict=True)]
    assert pulls.tolist() == expected


@pytest.mark.parametrize(
    ("call", "field"),
    [
        (lambda: contact_law(BALL, friction=-0.1), "friction"),
        (lambda: contact_law(BALL, friction=math.inf), "friction"),
        (lambda: contact_law(BALL, friction=[0.1, 0.2]), "friction"),
        (
            lambda: contact_law(replace(BALL, profile=Layer(BALL.profile, 0.01, base="frictionless")), friction=0.3),
            "profile",
        ),
        (lambda: contact_law(replace(BALL, profile=Ellipsoid(0.01, 0.02)), friction=0.3), "profile"),
        (lambda: contact_law(BALL, friction=0.3).reduced(1), "friction"),
        (lambda: contact_law(BALL).compiled_slide, "friction"),
        (lambda: (law := contact_law(BALL)).step(law.start(), 1e-5, 1e-5, way=0.0), "way"),
        (lambda: (law := contact_law(BALL, friction=0.3)).step(law.start(), 1e-5, 1e-5), "way"),
        (lambda: (law := contact_law(BALL, friction=0.3)).step(law.start(), 1e-5, 1e-5, way=math.nan), "way"),
        (lambda: (law := contact_law(BALL, friction=0.3)).step(law.start(), 1e-5, 1e-5, way=[0.0] * 3), "way.shape"),
    ],
)
def test_refusals(call, field):
    assert in_one_line(call).field == field
