"""Adhesive indentations: Maugis' closed forms, limits of slow and fast pulls, dwell, energy, refusals."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

import restitution as rs
from adhesive_elements import Held, adhesive_program
from refusals import in_one_line
from restitution.contact.adhesion import maugis_number, static_contact
from restitution.indentation.attraction import peak

TIP = rs.Parabola(1.0)


def solid(moduli=(), times=(), equilibrium=1.0):
    """Material with the reduced modulus equilibrium + sum of moduli exp(-t/times)."""
    return rs.Material(
        rs.PronySeries(0.25 * equilibrium, 0.25 * np.asarray(moduli, dtype=float), times), bulk=math.inf
    )


def pull(material, adhesion, speed, dwell=0.0, retreat=None, **options):
    """A tip that comes to a depth of 0.1, waits, and goes far away."""
    start, far, back = -0.2, -1.0, retreat or speed
    knots = np.cumsum([0.0, (0.1 - start) / speed, dwell, (0.1 - far) / back])
    depth = np.array([start, 0.1, 0.1, far])
    keep = np.append(True, np.diff(knots) > 0.0)
    return rs.indent(material, TIP, depth=depth[keep], time=knots[keep], adhesion=adhesion, **options)


def static_pull(modulus, adhesion):
    """Largest pull at rest."""
    return -minimize_scalar(
        lambda a: static_contact(TIP, modulus, adhesion, a).force, bounds=(1e-6, 0.6), method="bounded",
        options={"xatol": 1e-10},
    ).fun  # fmt: skip


@pytest.mark.parametrize("seed", range(20))
def test_the_largest_value_at_a_corner_lies_within_its_error(seed):
    """A line meets one that bends down, where the radius leaves zero; odd seeds reverse the time."""
    rng = np.random.default_rng(seed)
    time = np.sort(rng.uniform(0.0, 1.0, 60))
    corner, bend = rng.uniform(0.2, 0.8), rng.uniform(0.0, 9.0)
    rise, fall = rng.uniform(0.1, 3.0, 2)
    behind = np.maximum(time - corner, 0.0)
    values = 1.0 + rise * np.minimum(time - corner, 0.0) - fall * behind - bend * behind**2
    motion = np.zeros((time.size, 8))
    motion[:, 0], motion[:, 4], motion[:, 5] = time, 2.0, np.sqrt(behind)
    if seed % 2:
        motion[:, 0] = 1.0 - time
        motion, values = motion[::-1], values[::-1]
    value, error = peak(motion, values)
    assert abs(value - 1.0) <= error * (1.0 + 1e-9) + 1e-15
    assert error <= 0.5 * (rise + fall + bend) * np.diff(time).max()


@pytest.mark.parametrize("lam", [30.0, 1000.0])
def test_the_pull_of_an_elastic_body_tends_to_that_of_jkr(lam):
    adhesion = rs.Adhesion(0.01, lam / float(maugis_number(0.01, 1.0, 1.0, 1.0)))
    result = pull(solid(), adhesion, 1.0, rtol=1e-4)
    assert result.pull_off_force == pytest.approx(static_pull(1.0, adhesion), rel=1e-4)
    assert result.pull_off_force == pytest.approx(1.5 * math.pi * 0.01, rel=1e-4 + 0.2 / lam**2)


def test_an_elastic_indentation_follows_maugis():
    adhesion = rs.Adhesion(0.01, 0.157768)
    result = pull(solid(), adhesion, 1.0, rtol=1e-5)
    assert result.pull_off_force == pytest.approx(static_pull(1.0, adhesion), rel=2e-5)
    a, c = result.contact_radius, result.zone_radius
    touching = a > 0.1
    a, c = a[touching], c[touching]
    root = np.sqrt((c - a) * (c + a))
    exact = 4.0 / 3.0 * a**3 - 2.0 * 0.157768 * (c * c * np.arccos(a / c) + a * root)
    assert result.force[touching] == pytest.approx(exact, abs=1e-3 * result.max_force)
    assert result.status.name == "SEPARATED"
    # The work of one cycle is what the jumps lose.
    assert result.work == pytest.approx(result.radiated, rel=1e-3)
    assert abs(result.dissipated) < 1e-3 * result.radiated


def test_slow_and_fast_pulls_are_elastic_and_between_them_the_pull_is_larger():
    # The instants of loading and opening: both slow, both fast, and one relaxation time each.
    material, adhesion = solid([4.0], [1.0]), rs.Adhesion(0.01, 0.3)
    # The slow one relaxes within a cell of the elements, which takes finer ones than its force needs here.
    speeds = (1e-5, 1e-2), (0.05, 1e-4), (1e3, 1e-4)
    slow, middle, fast = (pull(material, adhesion, speed, rtol=rtol).pull_off_force for speed, rtol in speeds)
    assert slow == pytest.approx(static_pull(1.0, adhesion), rel=0.02)
    assert fast == pytest.approx(static_pull(5.0, adhesion), rel=0.02)
    assert middle > 1.3 * max(slow, fast)


def test_the_pull_rises_with_dwell():
    # A relaxed contact is opened at the modulus of the glass.
    material, adhesion = solid([4.0], [1.0]), rs.Adhesion(0.01, 0.3)
    pulls = [pull(material, adhesion, 10.0, dwell, rtol=1e-3).pull_off_force for dwell in (0.0, 0.3, 3.0)]
    assert 1.1 * pulls[0] < pulls[1]
    assert 1.1 * pulls[1] < pulls[2]


def test_energy_that_is_dissipated_is_that_of_the_elements():
    result = pull(solid([4.0, 2.0], [1.0, 0.1]), rs.Adhesion(0.02, 0.4), 0.1, 0.5, rtol=1e-4)
    assert result.dissipated == pytest.approx(float(result._march.motion[-1, 6]), rel=3e-3)
    assert sum(jump.energy for jump in result.jumps) == pytest.approx(result.radiated)


def test_a_second_visit_has_no_force_before_it_jumps():
    """The work of both visits is what elements dissipate, what jumps lose and what is stored."""
    result = rs.indent(
        solid([4.0, 1.0], [1.0, 10.0]), TIP, depth=[-0.3, 0.2, -0.5, 0.15, -0.6], time=[0.0, 1.0, 2.0, 3.0, 4.5],
        adhesion=rs.Adhesion(0.02, 0.3), rtol=1e-4,
    )  # fmt: skip
    _, out, again, _ = result.jumps
    assert again.inward
    assert not result.sample(np.linspace(out.time, again.time, 7)[1:-1]).force.values.any()
    assert result.dissipated == pytest.approx(float(result._march.motion[-1, 6]), rel=2e-4)


def test_a_contact_that_lasts_has_no_end():
    result = rs.indent(
        solid([4.0], [1.0]), TIP, depth=[-0.2, 0.1, 0.1], time=[0.0, 1.0, 3.0], adhesion=rs.Adhesion(0.01, 0.3),
        rtol=1e-3,
    )  # fmt: skip
    assert result.status.name == "IN_CONTACT"
    assert math.isinf(result.contact_end_time)
    assert float(result.sample([2.0]).indentation_depth[0]) == pytest.approx(0.1)
    assert "largest pull" in str(result.summary())
    assert result.plot().axes


def at_rest(modulus, adhesion, of, value, low, high):
    """Static contact in which a function of depth and force has a value, between two contact radii."""

    def distance(a):
        state = static_contact(TIP, modulus, adhesion, a)
        return of(state.depth, state.force) - value

    return static_contact(TIP, modulus, adhesion, brentq(distance, low, high, xtol=1e-14))


@pytest.mark.parametrize("stress", [0.008, 0.03, 0.157768, 0.5])
def test_an_elastic_body_under_a_force_jumps_in_and_is_pulled_off_as_maugis_has_it(stress):
    adhesion = rs.Adhesion(0.01, stress)
    pull = static_pull(1.0, adhesion)
    result = rs.indent(solid(), TIP, force=[0.0, 0.02, -0.08], time=[0.0, 1.0, 2.0], adhesion=adhesion, rtol=1e-5)
    assert result.pull_off_force == pytest.approx(pull, rel=2e-5)
    assert result.contact_end_time == pytest.approx(1.0 + (0.02 + pull) / 0.1, abs=2e-5)
    first, last = result.jumps
    # It jumps into the contact that bears no load, and loses the energy that the contact has below none.
    free = at_rest(1.0, adhesion, lambda d, f: f, 0.0, 0.1, 0.6)
    assert first.indentation_depth_after == pytest.approx(free.depth, abs=1e-4)
    assert first.contact_radius_after == pytest.approx(free.radius, abs=1e-3)
    assert math.isinf(last.indentation_depth_after)
    loaded = at_rest(1.0, adhesion, lambda d, f: f, 0.02, 0.1, 0.6)
    assert result.max_indentation_depth == pytest.approx(loaded.depth, rel=2e-5)
    # The work until then is elastic, after the energy of the jump.
    assert result.dissipated == pytest.approx(0.0, abs=1e-3 * result.radiated)
    assert result.work - result.stored == pytest.approx(result.radiated, rel=1e-3)
    assert math.isnan(float(result.sample([1.99]).indentation_depth[0]))
    assert result.plot().axes


@pytest.mark.parametrize("stiffness", [0.05, 0.3, 2.0])
@pytest.mark.parametrize("stress", [0.157768, 0.4])
def test_a_spring_snaps_where_the_static_contact_has_no_neighbour(stiffness, stress):
    adhesion = rs.Adhesion(0.01, stress)
    result = rs.indent(
        solid(), TIP, depth=[-0.5, 0.3, -2.0], time=[0.0, 0.8, 3.1], spring_constant=stiffness, adhesion=adhesion,
        rtol=1e-5,
    )  # fmt: skip

    def base(d, f):
        return d + f / stiffness

    # The base moves back until its place in the static contact is least: there dF/dd = -k.
    def place(a):
        state = static_contact(TIP, 1.0, adhesion, a)
        return base(state.depth, state.force)

    least = minimize_scalar(place, bounds=(0.05, 0.5), method="bounded", options={"xatol": 1e-10})
    out = static_contact(TIP, 1.0, adhesion, least.x)
    first, last = result.jumps[0], result.jumps[-1]
    assert last.time == pytest.approx(0.8 + 0.3 - least.fun, abs=2e-4)
    assert last.zone_radius_after == 0.0
    assert base(last.indentation_depth_after, 0.0) == pytest.approx(least.fun, abs=2e-4)
    # At a fold the depth moves like the root of the time.
    assert last.indentation_depth == pytest.approx(out.depth, abs=0.02)
    # The attraction begins with the base at -h0 and brings the contact to where it is at rest.
    assert first.indentation_depth == pytest.approx(-adhesion.range)
    if place(0.2) > -adhesion.range > least.fun and len(result.jumps) == 2:
        snapped = at_rest(1.0, adhesion, base, -adhesion.range, least.x, 0.7)
        assert first.indentation_depth_after == pytest.approx(snapped.depth, abs=1e-4)
    assert result.work == pytest.approx(result.radiated, rel=1e-4)
    assert abs(result.dissipated) < 1e-4 * result.radiated
    assert result.prescribed == "base"


@pytest.mark.parametrize(
    ("stiffness", "values"),
    [
        (0.0, [0.0, 0.02, -0.4]),
        pytest.param(0.3, [-0.4, 0.3, -2.0], marks=pytest.mark.slow),
        (3.0, [-0.4, 0.1, -1.0]),
    ],
)
def test_elements_of_another_program_follow_the_same_forces_and_springs(stiffness, values):
    material, adhesion, time = solid([4.0], [1.0]), rs.Adhesion(0.01, 0.3), [0.0, 1.0, 3.0]
    drive = {"depth": values, "spring_constant": stiffness} if stiffness else {"force": values}
    result = rs.indent(material, TIP, time=time, adhesion=adhesion, rtol=1e-4, **drive)
    held = Held((1.0, (4.0,), (1.0,)), 0.01, 0.3, stiffness, width=0.6, elements=300, dt=1.0 / 600)
    moment, depth, force = adhesive_program(held, values, time, 600)
    # Its events end between steps, and its elements are cells.
    assert result.pull_off_force == pytest.approx(-force.min(), rel=1e-2)
    assert result.contact_end_time == pytest.approx(moment[-1], abs=5e-3)
    times = np.array([0.95, 1.05, 1.2])
    results = result.sample(times)
    scale = np.abs(force).max()
    assert results.force.values == pytest.approx(np.interp(times, moment, force), abs=1e-2 * scale)
    assert results.indentation_depth.values == pytest.approx(np.interp(times, moment, depth), abs=2e-3)


def test_energy_under_a_spring_and_a_force_is_that_of_the_elements():
    material, adhesion, time = solid([4.0, 2.0], [1.0, 0.1]), rs.Adhesion(0.02, 0.4), [0.0, 1.0, 3.0]
    for drive in ({"depth": [-0.5, 0.2, -3.0], "spring_constant": 0.5}, {"force": [0.0, 0.05, -1.0]}):
        result = rs.indent(material, TIP, time=time, adhesion=adhesion, rtol=1e-4, **drive)
        assert result.dissipated > 0.0
        assert result.dissipated == pytest.approx(float(result._march.motion[-1, 6]), rel=3e-3)


def test_a_held_force_lets_the_contact_creep():
    result = rs.indent(
        solid([4.0], [1.0]), TIP, force=0.02, time=[0.0, 200.0], adhesion=rs.Adhesion(0.01, 0.3), rtol=1e-3
    )
    loaded = at_rest(1.0, rs.Adhesion(0.01, 0.3), lambda d, f: f, 0.02, 0.1, 0.6)
    assert result.status.name == "IN_CONTACT"
    # The retardation time is 5. The edge is loaded later than the middle, so that the contact is slower.
    assert float(result.indentation_depth[-1]) == pytest.approx(loaded.depth, rel=3e-3)
    assert float(result.sample([2.0]).indentation_depth[0]) < 0.8 * loaded.depth


def test_a_force_that_is_held_from_the_start_does_work_in_the_jump():
    adhesion = rs.Adhesion(0.01, 0.157768)
    result = rs.indent(solid(), TIP, force=0.02, time=[0.0, 1.0], adhesion=adhesion, rtol=1e-5)
    loaded = at_rest(1.0, adhesion, lambda d, f: f, 0.02, 0.1, 0.6)
    # From the depth -h0 on. What it does not leave in the elastic body goes to waves.
    assert result.work == pytest.approx(0.02 * (loaded.depth + adhesion.range), rel=1e-4)
    assert result.radiated > 0.0
    assert result.dissipated == pytest.approx(0.0, abs=1e-4 * result.radiated)


@pytest.mark.parametrize(
    ("stress", "stiffness"),
    [
        (0.00515, None),
        pytest.param(0.00515, 0.05, marks=pytest.mark.slow),
        (0.0085, None),
        (0.011, 0.05),
        (0.014, 0.05),
        (0.015, 0.05),
    ],
)
def test_hard_bodies_let_go_at_the_largest_pull_at_rest(stress, stiffness):
    # The static contact stays stable until its radius is zero, where the attraction without touch is not. The pull is
    # largest just before, where the force falls like the root of the time.
    adhesion = rs.Adhesion(0.01, stress)
    drive = {"force": [0.0, 0.02, -0.08]}
    if stiffness is not None:
        drive = {"depth": [-0.8 - 0.01 / stress, 0.3, -2.0 - 0.01 / stress], "spring_constant": stiffness}
    result = rs.indent(solid(), TIP, time=[0.0, 1.0, 2.0], adhesion=adhesion, rtol=1e-4, **drive)
    assert result.pull_off_force == pytest.approx(static_pull(1.0, adhesion), rel=1e-4)


def test_a_curved_depth_is_that_of_its_instants():
    adhesion = rs.Adhesion(0.01, 0.157768)
    result = rs.indent(
        solid(), TIP, depth=lambda t: 0.1 - 0.3 * math.cos(math.pi * t), time=[0.0, 2.0], adhesion=adhesion, rtol=1e-5
    )
    for t in (0.7, 1.0, 1.4):
        depth = 0.1 - 0.3 * math.cos(math.pi * t)
        state = at_rest(1.0, adhesion, lambda d, f: d, depth, 0.2, 0.8)
        assert float(result.sample([t]).force[0]) == pytest.approx(state.force, abs=3e-5 * result.max_force)
    assert result.pull_off_force == pytest.approx(static_pull(1.0, adhesion), abs=2e-5 * result.max_force)


def test_rounding_does_not_end_a_march_beyond_its_history():
    """The march takes its times from the first attraction on: one of a hundred histories then seemed to be longer."""
    rng, adhesion = np.random.default_rng(3), rs.Adhesion(0.01, range=0.05)
    pairs = ((rng.uniform(0.1, 1.0), rng.uniform(1.0, 3.0)) for _ in range(10_000))
    start, end = next((start, end) for start, end in pairs if (end - start) + start > end)
    line = {"depth": [-0.05, 0.1, -1.0], "time": [start, 0.5 * (start + end), end]}
    result = rs.indent(solid([4.0], [1.0]), TIP, adhesion=adhesion, rtol=0.01, **line)
    assert result.time[-1] == end


def test_what_the_theory_does_not_have_is_refused():
    material, adhesion = solid([4.0], [1.0]), rs.Adhesion(0.01, 0.3)
    line = {"depth": [-0.2, 0.1], "time": [0.0, 1.0]}
    near = {"depth": [0.0, 0.1], "time": [0.0, 1.0]}
    for field, options in (
        ("depth", near),
        ("depth", {"depth": [-0.2, -0.1], "time": [0.0, 1.0]}),
        ("depth", {"depth": rs.sine_arch(0.1, 1.0)}),
        ("depth", near | {"spring_constant": 1.0}),
        ("depth", {"depth": [-0.2, -0.1, 0.1, 0.2], "time": [0.0, 0.5, 0.5, 1.0]}),
        ("force", {"force": [-0.01, 0.1], "time": [0.0, 1.0]}),
        ("force", {"force": [0.0, 0.1, 0.2, 0.2], "time": [0.0, 1.0, 1.0, 2.0]}),
        ("force", {"force": [0.0, 0.1], "time": [0.0, 1.0], "spring_constant": 1.0}),
        ("surface", line | {"surface": object()}),
        ("adhesion", line | {"adhesion": 0.05}),
        ("adhesion", line | {"adhesion": rs.Adhesion([0.01, 0.02])}),
    ):
        error = in_one_line(lambda options=options: rs.indent(material, TIP, **{"adhesion": adhesion} | options))
        assert error.field == field
    assert in_one_line(lambda: rs.indent(material, rs.Pyramid(1.2), adhesion=adhesion, **line)).field == "profile"
    result = pull(material, adhesion, 1.0, rtol=1e-3)
    assert in_one_line(result.surface).field == "adhesion"


@pytest.mark.slow
@pytest.mark.parametrize(
    "drive",
    [
        {"force": [0.0, 20e-9, -200e-9]},
        {"depth": [-100e-9, 400e-9, -1800e-9], "spring_constant": 0.1},
    ],
    ids=["force", "spring"],
)
def test_an_atomic_force_microscope_is_solved_at_the_default_tolerance(drive):
    gel = rs.standard_solid(1e5, 3e5, 3e4, poisson_ratio=0.5)
    work, radius = 0.01, 1e-6
    adhesion = rs.Adhesion(work, stress=5e5)
    result = rs.indent(gel, rs.Parabola(radius), time=[0.0, 1.0, 3.0], adhesion=adhesion, **drive)
    # A fast pull on a contact that has crept exceeds that of elastic bodies, of JKR or DMT (2 pi w R).
    assert result.pull_off_force > 2.0 * math.pi * work * radius
