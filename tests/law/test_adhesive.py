"""The contact law with adhesion: order, closed forms, energy of random histories, capture, refusals."""

import math
from dataclasses import replace
from itertools import pairwise

import numba
import numpy as np
import pytest

import restitution as rs
from adhesive_elements import extrapolated_restitution
from refusals import in_one_line
from restitution.contact.adhesion import maugis_number, static_contact
from restitution.impact.status import SolverError, Status

RNG = np.random.default_rng(23)
# The modulus relaxes in 20 ns.
POLYMER, RELAXATION = rs.standard_solid(1e9, 1e9, 20.0, poisson_ratio=0.35), 2e-8
# Maugis' parameter of 2.5, so that the attraction jumps.
GRAIN = rs.Impact(POLYMER, rs.Parabola(5e-6), mass=2.5e-12, velocity=0.3, adhesion=rs.Adhesion(0.05, stress=1e8))


def solid(moduli=(), times=(), equilibrium=1.0):
    """Material with the reduced modulus equilibrium + sum of moduli exp(-t/times)."""
    return rs.Material(
        rs.PronySeries(0.25 * equilibrium, 0.25 * np.asarray(moduli, dtype=float), times), bulk=math.inf
    )


def thrown(law, dt, most=100_000, *, corrected=True):
    """e by velocity Verlet, 0 of a body that has not left, and its state and depths."""
    impact = law.impact
    state, force, mass = law.start(), 0.0, float(impact.mass)
    depth, velocity, depths = -float(impact.adhesion.range), float(impact.velocity), list[float]()
    for _ in range(most):
        depth += velocity * dt - 0.5 * force / mass * dt * dt
        before, force = force, law.step(state, depth, dt)
        force = force if corrected else law.read(state).force
        velocity -= 0.5 * (before + force) / mass * dt
        depths.append(depth)
        if force == 0.0 and velocity < 0.0 and law.read(state).zone_radius == 0.0:
            return -velocity / float(impact.velocity), law.read(state), depths
    return 0.0, law.read(state), depths


def test_second_order_in_the_step_and_near_the_solver():
    """e at 1/50, 1/100 and 1/200 of the contact time, though the force jumps; without the correction first order."""
    exact = rs.solve(GRAIN, rtol=1e-5)
    assert len(exact.jumps) == 2
    law = rs.contact_law(GRAIN, elements=100)
    e = [thrown(law, exact.contact_time / n)[0] for n in (50, 100, 200, 800)]
    errors = np.abs(np.array(e[:3]) - e[3])
    assert errors[1] < 0.4 * errors[0]
    assert errors[2] < 0.4 * errors[1]
    raw = thrown(law, exact.contact_time / 100, corrected=False)[0]
    assert abs(raw - e[3]) > 10.0 * errors[1]
    # Elements of second order: a quarter of the error at twice as many.
    fine = thrown(rs.contact_law(GRAIN, elements=200), exact.contact_time / 800)[0]
    assert abs(fine - exact.restitution_coefficient) < 0.4 * abs(e[3] - exact.restitution_coefficient)
    assert abs(fine - exact.restitution_coefficient) < 1e-4


@pytest.mark.slow
def test_another_program_has_the_same_rebound():
    """Maxwell branches and steps of another program (tests/adhesive_elements.py)."""
    impact = rs.Impact(solid([4.0], [1.0]), rs.Parabola(1.0), 1.0, 0.5, adhesion=rs.Adhesion(0.02, 0.1))
    law = rs.contact_law(impact)
    e, *_ = thrown(law, 0.01)
    other, *_ = extrapolated_restitution((1.0, (4.0,), (1.0,)), 0.02, 0.1, 0.5, width=1.4, elements=200)
    assert e == pytest.approx(other, abs=3e-3)


def test_an_elastic_contact_is_that_of_maugis_at_any_rate():
    """The force is that of Maugis (1992) at the depth, on the way in and out, with steps of any length."""
    impact = rs.Impact(solid(), rs.Parabola(1.0), 1.0, 0.5, adhesion=rs.Adhesion(0.02, 0.1))
    law = rs.contact_law(impact, elements=400)
    state = law.start()
    for radius in (0.2, 0.5, 0.35, 0.45, 0.15):
        static = static_contact(impact.profile, 1.0, impact.adhesion, radius)
        law.step(state, static.depth, float(np.exp(RNG.uniform(-9.0, 9.0))))
        now = law.read(state)
        assert now.force == pytest.approx(static.force, abs=1e-4)
        assert now.contact_radius == pytest.approx(radius, abs=1e-4)
        assert now.zone_radius == pytest.approx(static.edge, abs=1e-4)
    assert law.read(state).dissipated_energy == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_an_elastic_contact_keeps_nothing_of_its_way_between_the_jumps(seed):
    """Random depths that keep the contact, in steps of any length: its state is that of the depth, within rounding."""
    rng = np.random.default_rng(seed)
    adhesion = rs.Adhesion(0.02, float(np.exp(rng.uniform(-3.0, 0.0))))
    law = rs.contact_law(rs.Impact(solid(), rs.Parabola(1.0), 1.0, 0.5, adhesion=adhesion), elements=100)
    state = law.start()
    law.step(state, 0.1, 1.0)
    before, jumped = law.read(state), state.copy()
    for depth in rng.uniform(0.0, 0.25, 200).tolist():
        law.step(state, depth, float(np.exp(rng.uniform(-9.0, 9.0))))
    law.step(state, 0.1, 1.0)
    assert before.jump_energy > 0.0
    assert law.read(state) == pytest.approx(before, rel=1e-12, abs=1e-12)
    loads, expected = (each[-3 * law.max_nodes :].reshape(3, -1)[::2] for each in (state, jumped))
    assert loads == pytest.approx(expected, abs=1e-12)


def test_a_history_with_two_touches_is_that_of_an_indentation():
    """Two visits before the surface has come to rest, with `indent`, whose steps are its own."""
    material, adhesion = solid([4.0, 1.0], [1.0, 10.0]), rs.Adhesion(0.02, 0.3)
    time, depth = np.array([0.0, 1.0, 2.0, 3.0, 4.5]), np.array([-0.3, 0.2, -0.5, 0.15, -0.6])
    result = rs.indent(material, rs.Parabola(1.0), depth=depth, time=time, adhesion=adhesion, rtol=1e-4)
    moments = np.linspace(0.0, 4.5, 451)
    expected = result.sample(moments[1:]).force.values
    law = rs.contact_law(rs.Impact(material, rs.Parabola(1.0), 1.0, 0.5, adhesion=adhesion), elements=200)
    state, results = law.start(depth=-0.3), list[float]()
    for before, now in pairwise(moments):
        law.step(state, float(np.interp(now, time, depth)), now - before)
        results.append(law.read(state).force)
    scale = np.abs(expected).max()
    # Beside a jump, whose instant moves with the elements.
    near = np.abs(np.array(results) - expected) < 2e-3 * scale
    assert (~near).sum() <= 4
    assert scale > 0.1


def test_random_impacts_gain_no_energy_and_agree_with_the_solver():
    count = 0
    for _ in range(12):
        static, radius, work = np.exp(RNG.uniform(np.log([1e7, 1e-6, 3e-3]), np.log([3e9, 1e-5, 0.1])))
        branch, time = static * np.exp(RNG.uniform(-2.0, 3.0)), np.exp(RNG.uniform(-20.0, -14.0))
        material = rs.standard_solid(static, branch, branch * time, poisson_ratio=0.35)
        modulus = float(rs.reduced_modulus(material).equilibrium_modulus)
        stress = np.exp(RNG.uniform(-2.0, 1.5)) / maugis_number(work, 1.0, modulus, radius)
        mass = 4e3 * radius**3
        sticks = math.sqrt(2.0 * 7.09 * (work**5 * radius**4 / modulus**2) ** (1.0 / 3.0) / mass)
        speed = sticks * math.exp(RNG.uniform(0.5, 3.0))
        impact = rs.Impact(material, rs.Parabola(radius), mass, speed, adhesion=rs.Adhesion(work, stress=stress))
        exact = rs.solve(impact, rtol=1e-3)
        if not math.isfinite(exact.contact_time):
            continue
        e, state, _ = thrown(rs.contact_law(impact, elements=60), exact.contact_time / 200)
        count += 1
        assert e == pytest.approx(exact.restitution_coefficient, abs=1e-2)
        # What is gone is dissipated, radiated or stored.
        lost = 0.5 * mass * speed**2 * (1.0 - e * e)
        assert lost > (1.0 - 1e-2) * (state.dissipated_energy + state.jump_energy) - 5e-4 * mass * speed**2
    assert count > 5


def closing_error(law, seed, longest, parts=1):
    """Losses less work over a random closed path of the depth, over the sum of all works without their signs.

    It ends far away, at rest and with nothing stored. Each of its steps is divided into equal parts.
    """
    rng, reach = np.random.default_rng(seed), GRAIN.adhesion.range
    state = law.start()
    now, work, moved, touches = law.read(state), 0.0, 0.0, 0
    for depth in np.append(rng.uniform(-30.0, 60.0, 25), -200.0) * reach:
        ends, times = np.linspace(now.depth, depth, 9), longest * np.exp(rng.uniform(-4.0, 0.0, 8))
        for (start, end), dt in zip(pairwise(ends), times.tolist(), strict=True):
            for part in np.linspace(start, end, parts + 1)[1:].tolist():
                before = now
                force, now = law.step(state, part, dt / parts), law.read(state)
                # The mean force of the step, times its way.
                done = (force - now.force + 0.5 * (before.force + now.force)) * (now.depth - before.depth)
                work, moved = work + done, moved + abs(done)
                touches += before.zone_radius == 0.0 < now.zone_radius
    law.step(state, float(now.depth), 500.0 * RELAXATION)
    end = law.read(state)
    assert end.zone_radius == 0.0
    assert touches > 1
    assert work > 0.0
    return (end.dissipated_energy + end.jump_energy - work) / moved


def test_the_work_of_a_closed_path_of_the_depth_is_what_is_lost():
    """With steps of up to five relaxation times in two parts, of up to 0.7 in one, and of second order."""
    law, seeds = rs.contact_law(GRAIN, elements=60), range(20)
    assert max(abs(closing_error(law, seed, 5.0 * RELAXATION, 2)) for seed in seeds) < 3e-3
    errors = [[abs(closing_error(law, seed, 0.7 * RELAXATION, parts)) for seed in seeds] for parts in (1, 2)]
    assert max(errors[0]) < 5e-4
    # A quarter, were it not for elements, whose number stays.
    assert np.linalg.norm(errors[1]) < 0.4 * np.linalg.norm(errors[0])


def test_what_is_captured_stays():
    """Below the sticking velocity the body swings and comes to rest at the depth that the solver has for it."""
    slow = replace(GRAIN, velocity=0.05)
    exact = rs.solve(slow, rtol=1e-4)
    assert exact.restitution_coefficient == 0.0
    law = rs.contact_law(slow)
    e, state, depths = thrown(law, 2e-9, 3000)
    assert e == 0.0
    assert state.contact_radius > 0.0
    early, late = (np.ptp(depths[part]) for part in (slice(0, 500), slice(-500, None)))
    assert late < 0.1 * early
    assert np.mean(depths[-500:]) == pytest.approx(exact.residual_indentation_depth, rel=0.02)


def test_a_law_has_room_for_what_sticks():
    """A grain that its wall pulls in far below the sticking velocity overshoots its depth at rest, which is static."""
    for stress, speed in ((1e7, 0.05), (1e8, 0.05), (2e8, 0.01)):
        slow = replace(GRAIN, velocity=speed, adhesion=rs.Adhesion(0.05, stress=stress))
        exact = rs.solve(slow, rtol=1e-3)
        assert exact.restitution_coefficient == 0.0
        law = rs.contact_law(slow, elements=40)
        _, state, depths = thrown(law, 2e-9, 1000)
        assert max(depths) > 1.05 * exact.residual_indentation_depth
        assert 0.0 < state.contact_radius < state.zone_radius


def test_a_copy_is_another_contact_and_a_deeper_law_has_room():
    law = rs.contact_law(GRAIN, elements=30, max_depth=1.2e-6)
    state = law.start()
    law.step(state, 1e-8, 1e-8)
    copy = state.copy()
    first = law.step(state, 2e-8, 1e-8)
    assert law.step(copy, 2e-8, 1e-8) == first
    law.step(copy, -1e-6, 1e-8)
    assert law.read(copy).zone_radius == 0.0
    # Much deeper than the impact of the law.
    law.step(state, 1e-6, 1e-8)
    assert law.read(state).contact_radius > 1e-6
    wide = rs.contact_law(replace(GRAIN, velocity=5.0), elements=300, max_depth=1.2e-6)
    other = wide.start()
    for depth in (1e-8, 2e-8, 1e-6):
        wide.step(other, depth, 1e-8)
    assert law.read(state).force == pytest.approx(wide.read(other).force, rel=2e-3)


@pytest.mark.slow
def test_the_step_for_numba_and_many_contacts_have_the_bits_of_one_step():
    law = rs.contact_law(GRAIN, elements=20)
    advance, reach, most = law.compiled, GRAIN.adhesion.range, law.max_depth
    times = np.exp(RNG.uniform(-20.0, -16.0, 60))
    depths = RNG.uniform(-20.0 * reach, most, (60, 3))
    single, many, loop = law.start(depth=-2.0 * reach), law.start(3, depth=-2.0 * reach), law.start(depth=-2.0 * reach)

    @numba.njit
    def followed(state, depths, times):
        forces = np.empty(depths.size)
        for n in range(depths.size):
            forces[n] = advance(state, depths[n], times[n])
        return forces

    forces = np.array([law.step(many, row, dt) for row, dt in zip(depths, times, strict=True)])
    alone = [law.step(single, depth, dt) for depth, dt in zip(depths[:, 1], times, strict=True)]
    assert np.array_equal(forces[:, 1], alone)
    assert np.array_equal(followed(loop, depths[:, 1].copy(), times), alone)
    assert np.array_equal(loop, single)
    assert np.array_equal(many[1], single)
    assert min(alone) < 0.0 < max(alone)
    # Beyond the law it has no force.
    assert math.isnan(advance(loop, 1.01 * most, 1e-9))
    assert law.read(loop) == law.read(single)


def test_beyond_the_law_the_contact_stays_where_it_was():
    law = rs.contact_law(GRAIN, elements=20)
    state = law.start()
    law.step(state, 0.5 * law.max_depth, 1e-9)
    before, same = law.read(state), state.copy()
    # With fewer elements than such a depth has.
    narrow = replace(law, max_depth=1.0)
    with pytest.raises(SolverError, match="larger max_depth") as caught:
        narrow.step(state, 5.0 * law.max_depth, 1e-9)
    assert caught.value.status == Status.TOO_DEEP
    assert law.read(state) == before
    assert law.step(state, 0.4 * law.max_depth, 1e-9) == law.step(same, 0.4 * law.max_depth, 1e-9)


def test_without_work_of_adhesion_it_is_the_law_without():
    """Random histories that load, part and load again; over a step the depth is a line here, a parabola there.

    The force that a step returns carries the impulse of the step, also where the contact ends within it.
    """
    plain = rs.contact_law(replace(GRAIN, adhesion=None), max_nodes=400)
    law = rs.contact_law(replace(GRAIN, adhesion=rs.Adhesion(1e-12, stress=1e-2)), elements=200)
    reach, most = 1e-10, law.max_depth
    rng, times, parts = np.random.default_rng(23), np.linspace(0.0, 1.0, 401)[1:], list[np.ndarray]()
    while len(parts) < 3:
        waves = np.sin(2.0 * np.pi * times[:, None] * rng.uniform(1.0, 4.0, 3) + rng.uniform(0.0, 6.0, 3)).sum(axis=1)
        # Some begin at their top, and never touch.
        if waves.max() > waves[0] + 0.5:
            parts.append((waves - waves[0]) * np.minimum(1.0, 10.0 * times))
    for part in parts:
        state, other = law.start(depth=-5.0 * reach), plain.start(depth=-5.0 * reach)
        depths = 0.15 * most * part
        forces = np.array(
            [[law.step(state, d, 1e-9), law.read(state).force, plain.step(other, d, 1e-9)] for d in depths.tolist()]
        )
        returned, at_end, expected = forces.T
        largest = expected.max()
        assert largest > 0.0
        # Of second order in the step: 4e-4 here, 1e-5 at a quarter of it.
        assert np.abs(at_end - expected).max() < 1e-3 * largest
        # In the step that begins or ends a contact the force is no line over time.
        assert np.abs(returned - expected).max() < 1e-2 * largest
        assert abs(np.mean(returned - expected)) < 2e-4 * largest


def test_before_the_attraction_there_is_no_force():
    law = rs.contact_law(GRAIN, elements=30)
    reach = GRAIN.adhesion.range
    state = law.start(depth=-3.0 * reach)
    assert law.step(state, -2.0 * reach, 1e-9) == 0.0
    # The attraction begins within the step.
    law.step(state, 2.0 * reach, 1e-9)
    other = law.start()
    law.step(other, 2.0 * reach, 0.75e-9)
    assert law.read(state).force == pytest.approx(law.read(other).force, rel=1e-12)


def test_refusals():
    law = rs.contact_law(GRAIN, elements=30)
    state = law.start()
    for call, field in (
        (lambda: rs.contact_law(replace(GRAIN, adhesion=None), elements=100), "elements"),
        (lambda: rs.contact_law(replace(GRAIN, velocity=[0.1, 0.2])), "impact"),
        (lambda: rs.contact_law(GRAIN, elements=3), "elements"),
        (lambda: rs.contact_law(GRAIN, friction=0.3), "friction"),
        (lambda: rs.contact_law(GRAIN, max_nodes=30), "max_nodes"),
        (lambda: rs.contact_law(GRAIN, max_depth=-1e-6), "max_depth"),
        (lambda: law.start(depth=0.0), "depth"),
        (lambda: law.start(0), "contacts"),
        (lambda: law.step(state, math.nan, 1e-9), "depth"),
        (lambda: law.step(state, 2.0 * law.max_depth, 1e-9), "depth"),
        (lambda: law.step(state, 0.0, 0.0), "dt"),
        (lambda: law.step(state, 0.0, 1e-9, way=0.0), "way"),
        (lambda: law.step(np.zeros(3), 0.0, 1e-9), "state.shape"),
        (lambda: law.reduced(1), "adhesion"),
    ):
        assert in_one_line(call).field == field
    thin = replace(GRAIN, adhesion=rs.Adhesion(0.05, stress=1e12))
    with pytest.raises(SolverError):
        rs.contact_law(thin)
