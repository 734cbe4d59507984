"""The contact law with adhesion: order, closed forms, energy of random histories, capture, refusals."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import restitution as rs
from adhesive_elements import adhesive_restitution
from refusals import in_one_line
from restitution.contact.adhesion import maugis_number, static_contact
from restitution.impact.status import SolverError

RNG = np.random.default_rng(23)
POLYMER = rs.standard_solid(1e9, 1e9, 20.0, poisson_ratio=0.35)
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
    depth, velocity, depths = state.depth, float(impact.velocity), list[float]()
    for _ in range(most):
        depth += velocity * dt - 0.5 * force / mass * dt * dt
        before, force = force, law.step(state, depth, dt)
        force = force if corrected else state.force
        velocity -= 0.5 * (before + force) / mass * dt
        depths.append(depth)
        if force == 0.0 and state.zone_radius == 0.0 and velocity < 0.0:
            return -velocity / float(impact.velocity), state, depths
    return 0.0, state, depths


def test_second_order_in_the_step_and_near_the_solver():
    """e at 1/50, 1/100 and 1/200 of the contact time, though the force jumps; without the correction first order."""
    exact = rs.solve(GRAIN, rtol=1e-5)
    assert len(exact.jumps) == 2
    law = rs.adhesive_contact_law(GRAIN, elements=100)
    e = [thrown(law, exact.contact_time / n)[0] for n in (50, 100, 200, 800)]
    errors = np.abs(np.array(e[:3]) - e[3])
    assert errors[1] < 0.4 * errors[0]
    assert errors[2] < 0.4 * errors[1]
    raw = thrown(law, exact.contact_time / 100, corrected=False)[0]
    assert abs(raw - e[3]) > 10.0 * errors[1]
    # Elements of second order: a quarter of the error at twice as many.
    fine = thrown(rs.adhesive_contact_law(GRAIN, elements=200), exact.contact_time / 800)[0]
    assert abs(fine - exact.restitution_coefficient) < 0.4 * abs(e[3] - exact.restitution_coefficient)
    assert abs(fine - exact.restitution_coefficient) < 1e-4


@pytest.mark.slow
def test_another_program_has_the_same_rebound():
    """Fixed elements and steps of another program, accurate to its events (tests/adhesive_elements.py)."""
    impact = rs.Impact(solid([4.0], [1.0]), rs.Parabola(1.0), 1.0, 0.5, adhesion=rs.Adhesion(0.02, 0.1))
    law = rs.adhesive_contact_law(impact)
    e, *_ = thrown(law, 0.01)
    other = adhesive_restitution((1.0, (4.0,), (1.0,)), 0.02, 0.1, 0.5, elements=200)
    assert e == pytest.approx(other, abs=3e-3)


def test_an_elastic_contact_is_that_of_maugis_at_any_rate():
    """The force is that of Maugis (1992) at the depth, on the way in and out, with steps of any length."""
    impact = rs.Impact(solid(), rs.Parabola(1.0), 1.0, 0.5, adhesion=rs.Adhesion(0.02, 0.1))
    law = rs.adhesive_contact_law(impact, elements=400)
    state = law.start()
    for radius in (0.2, 0.5, 0.35, 0.45, 0.15):
        static = static_contact(impact.profile, 1.0, impact.adhesion, radius)
        law.step(state, static.depth, float(np.exp(RNG.uniform(-9.0, 9.0))))
        assert state.force == pytest.approx(static.force, abs=1e-4)
        assert state.contact_radius == pytest.approx(radius, abs=1e-4)
        assert state.zone_radius == pytest.approx(static.edge, abs=1e-4)
    assert state.dissipated_energy == pytest.approx(0.0, abs=1e-12)


def test_a_history_with_two_touches_is_that_of_an_indentation():
    """Two visits before the surface has come to rest, with `indent`, whose steps are its own."""
    material, adhesion = solid([4.0, 1.0], [1.0, 10.0]), rs.Adhesion(0.02, 0.3)
    time, depth = np.array([0.0, 1.0, 2.0, 3.0, 4.5]), np.array([-0.3, 0.2, -0.5, 0.15, -0.6])
    result = rs.indent(material, rs.Parabola(1.0), depth=depth, time=time, adhesion=adhesion, rtol=1e-4)
    moments = np.linspace(0.0, 4.5, 451)
    expected = result.sample(moments[1:]).force.values
    law = rs.adhesive_contact_law(rs.Impact(material, rs.Parabola(1.0), 1.0, 0.5, adhesion=adhesion), elements=200)
    state, found = law.start(depth=-0.3), list[float]()
    for before, now in pairwise(moments):
        law.step(state, float(np.interp(now, time, depth)), now - before)
        found.append(state.force)
    scale = np.abs(expected).max()
    # Beside a jump, whose instant moves with the elements.
    near = np.abs(np.array(found) - expected) < 2e-3 * scale
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
        e, state, _ = thrown(rs.adhesive_contact_law(impact, elements=60), exact.contact_time / 200)
        count += 1
        assert e == pytest.approx(exact.restitution_coefficient, abs=1e-2)
        # What is gone is dissipated, radiated or stored.
        lost = 0.5 * mass * speed**2 * (1.0 - e * e)
        assert lost > (1.0 - 1e-2) * (state.dissipated_energy + state.jump_energy) - 5e-4 * mass * speed**2
    assert count > 5


def test_a_closed_path_of_the_depth_takes_work():
    """Random lines of the depth that end far away: their work covers the losses, whatever the steps."""
    law = rs.adhesive_contact_law(GRAIN, elements=60)
    for _ in range(5):
        state, reach = law.start(), GRAIN.adhesion.range
        depths = np.append(RNG.uniform(-30.0, 60.0, 25) * reach, -200.0 * reach)
        work, moved = 0.0, 0.0
        for depth in depths:
            for part in np.linspace(state.depth, depth, 9)[1:]:
                dt, before, start = float(np.exp(RNG.uniform(-20.0, -16.0))), state.force, state.depth
                force = law.step(state, float(part), dt)
                mean = force - state.force + 0.5 * (before + state.force)
                work += mean * (part - start)
                moved += abs(mean * (part - start))
        assert state.zone_radius == 0.0
        assert work > state.dissipated_energy + state.jump_energy - 5e-3 * moved
        assert work > 0.0


def test_what_is_captured_stays():
    """Below the sticking velocity the body swings and comes to rest at the depth that the solver has for it."""
    slow = replace(GRAIN, velocity=0.05)
    exact = rs.solve(slow, rtol=1e-4)
    assert exact.restitution_coefficient == 0.0
    law = rs.adhesive_contact_law(slow)
    e, state, depths = thrown(law, 2e-9, 3000)
    assert e == 0.0
    assert state.contact_radius > 0.0
    early, late = (np.ptp(depths[part]) for part in (slice(0, 500), slice(-500, None)))
    assert late < 0.1 * early
    assert np.mean(depths[-500:]) == pytest.approx(exact.residual_indentation_depth, rel=0.02)


def test_a_copy_is_another_contact_and_a_wider_zone_finds_room():
    law = rs.adhesive_contact_law(GRAIN, elements=30)
    state = law.start()
    law.step(state, 1e-8, 1e-8)
    copy = state.copy()
    first = law.step(state, 2e-8, 1e-8)
    assert law.step(copy, 2e-8, 1e-8) == first
    law.step(copy, -1e-6, 1e-8)
    assert copy.zone_radius == 0.0
    # Much deeper than the impact of the law.
    law.step(state, 1e-6, 1e-8)
    assert state.contact_radius > 1e-6
    wide = rs.adhesive_contact_law(replace(GRAIN, velocity=5.0), elements=300)
    other = wide.start()
    for depth in (1e-8, 2e-8, 1e-6):
        wide.step(other, depth, 1e-8)
    assert state.force == pytest.approx(other.force, rel=2e-3)


def test_before_the_attraction_there_is_no_force():
    law = rs.adhesive_contact_law(GRAIN, elements=30)
    reach = GRAIN.adhesion.range
    state = law.start(depth=-3.0 * reach)
    assert law.step(state, -2.0 * reach, 1e-9) == 0.0
    # The attraction begins within the step.
    law.step(state, 2.0 * reach, 1e-9)
    other = law.start()
    law.step(other, 2.0 * reach, 0.75e-9)
    assert state.force == pytest.approx(other.force, rel=1e-12)


def test_refusals():
    law = rs.adhesive_contact_law(GRAIN, elements=30)
    state = law.start()
    for call, field in (
        (lambda: rs.adhesive_contact_law(replace(GRAIN, adhesion=None)), "impact"),
        (lambda: rs.adhesive_contact_law(replace(GRAIN, velocity=[0.1, 0.2])), "impact"),
        (lambda: rs.adhesive_contact_law(GRAIN, elements=3), "elements"),
        (lambda: law.start(depth=0.0), "depth"),
        (lambda: law.step(state, math.nan, 1e-9), "depth"),
        (lambda: law.step(state, 0.0, 0.0), "dt"),
        (lambda: law.step(np.zeros(3), 0.0, 1e-9), "state"),
        (lambda: rs.adhesive_contact_law(GRAIN, elements=30).step(state, 0.0, 1e-9), "state"),
    ):
        assert in_one_line(call).field == field
    thin = replace(GRAIN, adhesion=rs.Adhesion(0.05, stress=1e12))
    with pytest.raises(SolverError):
        rs.adhesive_contact_law(thin)
