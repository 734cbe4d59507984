"""Adhesive impacts: prototype rows, closed forms, limits, energies, capture, and an independent program."""

import math
import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

import restitution as rs
from adhesive_elements import extrapolated_restitution
from checkout import ROOT, script
from refusals import in_one_line
from restitution.contact.adhesion import maugis_number, static_contact
from restitution.impact.adhesive import problem_of
from restitution.impact.dugdale import Problem, _numbers, scales, solve_adhesive
from restitution.impact.status import SolverError, Status
from restitution.indentation import attraction
from restitution.indentation.attraction import Sticky
from restitution.kernel import adhesion as kernel
from restitution.kernel.zone import PAUSED
from restitution.parallel import ended_by

# Unit balls of soft bodies exceed the limits of the theory on purpose.
pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")

# JKR: energy lost in both jumps over (w^5 R^4/E*^2)^(1/3).
JKR_LOSS = 7.0921960


def solid(moduli=(), times=(), equilibrium=1.0):
    """Material with the reduced modulus equilibrium + sum of moduli exp(-t/times)."""
    shear = rs.PronySeries(0.25 * equilibrium, 0.25 * np.asarray(moduli, dtype=float), times)
    return rs.Material(shear, bulk=math.inf)


def ball(material, work, stress, velocity, **more):
    """A unit ball of unit mass."""
    return rs.Impact(material, rs.Parabola(1.0), 1.0, velocity, adhesion=rs.Adhesion(work, stress), **more)


STANDARD = solid([4.0], [1.0])
# e and the duration of the attraction from the table of a prototype in plain NumPy with fixed steps, whose last digits
# scatter by 1e-4 (2e-4 for A2 and A8, by the difference of its finest two grids).
ROWS = [
    (STANDARD, 1e-6, 0.001, 1.0, 0.628797, 1.501, 1e-6),
    (STANDARD, 0.02, 0.1, 0.5, 0.246534, 3.652, 1e-6),
    (STANDARD, 0.02, 0.3, 0.5, 0.32045, 2.422, 1e-4),
    (STANDARD, 0.02, 0.8, 0.5, 0.2795, 2.309, 2e-4),
    (STANDARD, 0.05, 1.0, 1.0, 0.3707, 1.919, 2e-4),
    (solid(), 0.01, 0.157768, 0.1217, 0.9412, 5.771, 2e-4),
]


@pytest.mark.parametrize(("material", "work", "stress", "velocity", "e", "time", "scatter"), ROWS)
def test_rows_of_the_prototype(material, work, stress, velocity, e, time, scatter):
    result = rs.solve(ball(material, work, stress, velocity), rtol=1e-5)
    assert result.restitution_coefficient == pytest.approx(e, abs=scatter + 1e-5)
    assert result.contact_time == pytest.approx(time, abs=1e-3)
    assert abs(result.energy.residual) < 1e-4


def test_a_slow_body_sticks_and_comes_to_rest():
    result = rs.solve(ball(STANDARD, 0.05, 0.5, 0.5))
    assert result.status == Status.CAPTURED
    assert result.restitution_coefficient == 0.0
    # The static contact without load of Maugis with the equilibrium modulus.
    adhesion = rs.Adhesion(0.05, 0.5)
    profile = rs.Parabola(1.0)
    radius = brentq(lambda a: static_contact(profile, 1.0, adhesion, a).force, 0.3, 2.0)
    held = static_contact(profile, 1.0, adhesion, radius)
    assert result.residual_indentation_depth == pytest.approx(held.depth, rel=1e-9)
    assert result.history.sizes["time"] > 10


def test_no_work_of_adhesion_is_no_adhesion():
    rng = np.random.default_rng(2)
    for _ in range(3):
        material = solid(10.0 ** rng.uniform(-1, 1, 2), 10.0 ** rng.uniform(-1.5, 0.5, 2))
        impact = ball(material, 1e-10, 1e-5, float(rng.uniform(0.3, 2.0)))
        e = rs.solve(replace(impact, adhesion=None)).restitution_coefficient
        assert rs.solve(impact).restitution_coefficient == pytest.approx(e, abs=2e-6)


def test_elements_without_work_of_adhesion_have_the_rebound_of_panels():
    """Two discretisations that share no code: equal elements here, fronts and panels in `solve` without adhesion."""
    rng = np.random.default_rng(6)
    for count in (0, 1, 2, 3):
        equilibrium = float(count < 2)
        material = solid(10.0 ** rng.uniform(-1, 1, count), 10.0 ** rng.uniform(-1.5, 0.5, count), equilibrium)
        profile = [rs.Parabola(1.0), rs.PowerLaw(3.0, 0.5), rs.Sphere(5.0)][count % 3]
        impact = replace(ball(material, 1e-13, 1e-8, float(rng.uniform(0.3, 2.0))), profile=profile)
        e = rs.solve(replace(impact, adhesion=None), rtol=1e-10).restitution_coefficient
        solved = solve_adhesive(problem_of(impact), 1e-8)
        assert solved.status == Status.SEPARATED
        assert math.sqrt(solved.numbers["energy"]) == pytest.approx(e, abs=1e-8)


def elastic_balance(work, stress, velocity, count):
    """Energy of the motion and loss in jumps at the end of an elastic impact, over that of the impact."""
    problem = Problem(Sticky(rs.Parabola(1.0), rs.PronySeries(1.0, [], []), rs.Adhesion(work, stress)), 1.0, velocity)
    march = problem.march(*scales(problem), count)
    kinetic = 0.5 * velocity**2
    return march.left / kinetic, float(march.motion[-1, 7]) / kinetic


def test_elastic_bodies_keep_their_energy_without_folds():
    """With lambda below 0.25 nothing is lost but while nothing touches, in jumps of 0 to c and back from c/2.

    Their loss has a closed form: see `test_a_hard_ball_jumps_without_touch_alone`. What is left of the kinetic energy
    has the error of the steps in time.
    """
    rng = np.random.default_rng(7)
    for _ in range(3):
        work, lam = rng.uniform(0.005, 0.02), rng.uniform(0.1, 0.25)
        stress, velocity = lam / float(maugis_number(work, 1.0, 1.0, 1.0)), float(rng.uniform(0.1, 0.3))
        loss = (1.0 / 12.0 + 1.0 / 192.0) * math.pi * stress * (8.0 * stress / math.pi) ** 4 / (0.5 * velocity**2)
        errors = []
        for count in (800, 3200):
            kept, lost = elastic_balance(work, stress, velocity, count)
            assert lost == pytest.approx(loss, abs=1e-12)
            errors.append(kept + loss - 1.0)
        assert abs(errors[1]) < 1e-8
        # Of second order, 1/16.
        assert abs(errors[1]) < 0.1 * abs(errors[0])


@pytest.mark.parametrize(("lam", "velocity"), [(0.8255, 0.1217), (3.0, 0.3)])
def test_what_elastic_bodies_lose_is_the_loss_in_jumps(lam, velocity):
    """The balance of motion and jumps closes with the square of the step."""
    stress = lam / float(maugis_number(0.01, 1.0, 1.0, 1.0))
    rough, fine = (sum(elastic_balance(0.01, stress, velocity, count)) - 1.0 for count in (800, 3200))
    assert abs(rough) < 2e-6
    assert abs(fine) < 0.1 * abs(rough)
    result = rs.solve(ball(solid(), 0.01, stress, velocity))
    lost = result.radiated_energy / result.energy.kinetic_in
    assert result.restitution_coefficient == pytest.approx(math.sqrt(1.0 - lost), abs=2e-6)
    assert result.energy.dissipated == 0.0


def test_elastic_motion_follows_maugis():
    # At all instants force and depth follow from contact radius and edge.
    work, stress = 0.01, 0.157768
    problem = Problem(Sticky(rs.Parabola(1.0), rs.PronySeries(1.0, [], []), rs.Adhesion(work, stress)), 1.0, 0.2)
    width, time = scales(problem)
    errors = []
    for count in (100, 200, 400):
        _, depth, _, force, edge, radius, *_ = problem.march(width, time, count).motion.T
        touching = radius > 0.3 * radius.max()
        a, c = radius[touching], edge[touching]
        root = np.sqrt((c - a) * (c + a))
        exact = 4.0 / 3.0 * a**3 - 2.0 * stress * (c * c * np.arccos(a / c) + a * root)
        errors.append([abs(force[touching] - exact).max(), abs(depth[touching] - a * a + 2.0 * stress * root).max()])
    # An elastic parabola has no error of the elements.
    assert np.all(np.array(errors) < 1e-13)


def test_the_loss_in_jumps_is_that_of_the_static_contact_and_tends_to_that_of_jkr(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "validation"))
    static = script("validation/adhesion.py")
    work = 0.01
    v_stick = math.sqrt(2.0 * JKR_LOSS * work ** (5.0 / 3.0))
    for lam, rtol in ((2.0, 1e-5), (4.0, 1e-5), (8.0, 1e-4), (30.0, 1e-5), (100.0, 1e-5), (1000.0, 1e-4)):
        stress = lam / float(maugis_number(work, 1.0, 1.0, 1.0))
        result = rs.solve(ball(solid(), work, stress, 1.5 * v_stick), rtol=rtol)
        e, loss = result.restitution_coefficient, result.radiated_energy / work ** (5.0 / 3.0)
        # Both are known to rtol, the loss in jumps over the energy of the impact.
        exact = static.static_loss(lam)
        assert e == pytest.approx(math.sqrt(1.0 - exact / JKR_LOSS / 1.5**2), abs=rtol)
        assert loss == pytest.approx(exact, abs=1.5**2 * JKR_LOSS * rtol)
    # The last one is nearly that of Johnson, Kendall and Roberts, with e = sqrt(1 - 1/1.5^2).
    assert e == pytest.approx(math.sqrt(1.0 - 1.0 / 1.5**2), abs=3e-4)
    # The constant has eight digits.
    assert static.extrapolated_loss() == pytest.approx(JKR_LOSS, rel=1e-7)


@pytest.mark.parametrize("number", [705, 2417])
def test_a_body_is_held_where_its_contact_vanishes_within_a_step(number, monkeypatch):
    """Of two random impacts; the contact is attracted without touch, or has a gap that is zero but for rounding."""
    monkeypatch.syspath_prepend(str(ROOT / "validation"))
    impact = script("validation/adhesion.py").random_impact(np.random.default_rng([23, number]))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert rs.solve(impact, rtol=1e-4).status == Status.CAPTURED


@pytest.mark.parametrize("lam", [20.0, 100.0])
def test_a_thin_ring_on_a_slow_material_is_that_of_its_glass(lam, monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "validation"))
    static = script("validation/adhesion.py")
    # Relaxation of 1e6 contact times: an elastic ball with E* = 5, whose loss is in units of (w^5 R^4/E*^2)^(1/3).
    work, modulus = 0.02, 5.0
    unit = (work**5 / modulus**2) ** (1.0 / 3.0)
    stress = lam / float(maugis_number(work, 1.0, modulus, 1.0))
    velocity = 1.5 * math.sqrt(2.0 * JKR_LOSS * unit)
    result = rs.solve(ball(solid([4.0], [1e6]), work, stress, velocity), rtol=1e-5)
    assert result.restitution_coefficient == pytest.approx(
        math.sqrt(1.0 - static.static_loss(lam) / JKR_LOSS / 1.5**2), abs=2e-5
    )


def test_a_thin_ring_of_a_viscoelastic_ball_closes_its_energy():
    # Ring and relaxation times cross at the finer marches.
    stress = 50.0 / float(maugis_number(0.02, 1.0, 5.0, 1.0))
    result = rs.solve(ball(STANDARD, 0.02, stress, 0.8), rtol=1e-4)
    assert abs(result.energy.residual) < 1e-3
    finer = rs.solve(ball(STANDARD, 0.02, stress, 0.8), rtol=1e-5)
    assert result.restitution_coefficient == pytest.approx(finer.restitution_coefficient, abs=1e-4)


def test_coarse_marches_have_a_ring_thinner_than_a_cell():
    """The fine march has 1.4 elements in the ring; elements of the coarse ones wait for it, touch and leave at once."""
    impact = ball(STANDARD, 0.02, 30.0 / float(maugis_number(0.02, 1.0, 5.0, 1.0)), 0.8)
    problem = problem_of(impact)
    width, time = scales(problem)
    assert problem.body.ring < 0.05 * width / 400
    fine = rebound_of(problem, problem.march(width, time, 12800))
    for count, graded, error in ((100, True, 3e-4), (200, True, 1e-4), (400, False, 2e-4)):
        march = problem.march(width, time, count, graded=graded)
        assert rebound_of(problem, march) == pytest.approx(fine, abs=error)
    # What elements dissipate in such a step has its jump of the load, too.
    numbers = _numbers(problem, problem.march(width, time, 200, graded=True))
    kinetic = 0.5 * problem.mass * problem.velocity**2
    parts = numbers["dissipated_energy"] + numbers["radiated_energy"] + numbers["stored_energy"]
    assert numbers["energy"] + parts / kinetic == pytest.approx(1.0, abs=3e-4)


def rebound_of(problem, march):
    """e of a march."""
    return math.sqrt(_numbers(problem, march)["energy"])


def test_the_error_has_the_creep_of_a_ring_thinner_than_a_cell():
    """Marches without elements in the ring agree with each other, but not with those that have them."""
    impact = replace(ball(solid([0.5, 0.5], [9.0, 12.5]), 1.5e-4, 1.8, 0.015), profile=rs.Sphere(10.0))
    problem = problem_of(impact)
    width, time = scales(problem)
    assert problem.body.transit(width, time, 400) == pytest.approx(0.2 * problem.body.ring / width, rel=0.1)
    assert problem.body.transit(width, time, 25600) == 0.0
    fine, finer = (_numbers(problem, problem.march(width, time, count))["energy"] for count in (25600, 51200))
    exact = math.sqrt(finer + (finer - fine) / 3.0)
    assert rs.solve(impact, rtol=1e-5).restitution_coefficient == pytest.approx(exact, abs=5e-6)


def test_a_hard_ball_jumps_without_touch_alone():
    # G = pi c^2/(4 R) - 2 sigma0 c/E - pi (h0 + d)/2 while nothing touches: from 0 to its root at d = -h0, and back
    # from the fold at half of that; E_jump = 4 sigma0 |int c G dc|.
    rng = np.random.default_rng(4)
    work, lam = rng.uniform(0.005, 0.02), rng.uniform(0.1, 0.2)
    stress = lam / float(maugis_number(work, 1.0, 1.0, 1.0))
    edge = 8.0 * stress / math.pi
    inward, outward = math.pi * stress * edge**4 / 12.0, math.pi * stress * edge**4 / 192.0
    result = rs.solve(ball(solid(), work, stress, 0.02), rtol=1e-5)
    first, *_, last = result.jumps
    assert first.energy == pytest.approx(inward, rel=1e-4)
    assert result.radiated_energy == pytest.approx(inward + outward, rel=1e-3)
    assert last.zone_radius_after == 0.0


def test_a_body_bounces_until_it_sticks():
    """Free flights between single impacts, on a fresh surface each; the last is below the sticking velocity alone."""
    rng = np.random.default_rng(5)
    material = rs.standard_solid(1e6, 10.0 ** rng.uniform(6.0, 6.7), 10.0 ** rng.uniform(0.0, 2.0), poisson_ratio=0.45)
    bead = rs.Impact(material, rs.Parabola(1e-5), 5e-12, 0.4, adhesion=rs.Adhesion(rng.uniform(0.03, 0.06), 4e5))
    gravity = float(rng.uniform(1.0, 10.0))
    series = rs.bounces(bead, with_weight=False, gravity=gravity, rtol=1e-4)
    assert series.ended == "stuck"
    assert series.n_bounces > 2
    assert math.isinf(series.contact_time[-1])
    impacts = [rs.solve(replace(bead, velocity=velocity), rtol=1e-4) for velocity in series.velocity]
    assert [impact.restitution_coefficient for impact in impacts] == list(series.restitution_coefficient)
    # The report has the narrowest ring of all touches.
    slopes = [impact.validity["attraction"].value for impact in impacts]
    assert len(set(slopes)) > 2
    assert series.validity["attraction"].value == max(slopes)
    away, depth = series.rebound_velocity[:-1], series.residual_indentation_depth[:-1]
    # It leaves on the neck that it has pulled out, above the undeformed surface.
    assert np.all(depth < 0.0)
    np.testing.assert_allclose(series.velocity[1:], np.sqrt(away**2 - 2.0 * gravity * depth), rtol=1e-12)
    threshold = rs.sticking_velocity(bead, rtol=1e-3)
    assert series.velocity[-1] < 1.002 * threshold
    assert np.all(series.velocity[:-1] > 0.998 * threshold)
    assert any(line.startswith("attraction") for line in map(str, series.warnings)) == (
        series.validity["attraction"].exceeded
    )


# At 0.48 the surface exchanges a hundred times the energy of such a ball.
@pytest.mark.parametrize("lam", [0.478, 4.0])
def test_an_elastic_ball_sticks_below_its_loss_in_jumps(lam):
    work = 0.01
    impact = ball(solid(), work, lam / float(maugis_number(work, 1.0, 1.0, 1.0)), 0.2)
    slow = rs.sticking_velocity(impact, rtol=1e-3)
    fast = rs.solve(replace(impact, velocity=3.0 * slow), rtol=1e-5)
    assert slow == pytest.approx(math.sqrt(2.0 * fast.radiated_energy), rel=2e-3)
    # It is pulled back by its own attraction, and swings with all the energy that it has left.
    held = rs.solve(replace(impact, velocity=np.array([0.8, 0.99, 1.01]) * slow), rtol=1e-4).status
    assert held.tolist() == [Status.CAPTURED, Status.CAPTURED, Status.SEPARATED]


def test_a_body_that_a_coarse_march_holds_leaves_just_above_the_sticking_velocity():
    impact = ball(solid(), 0.01, 0.157768, 0.3)
    # An elastic body loses the same energy in its jumps at any velocity.
    sticks = math.sqrt(2.0 * rs.solve(impact, rtol=1e-5).radiated_energy)
    velocity = sticks * (1.0 + 10.0 ** np.random.default_rng(4).uniform(-3.1, -2.0, 12))
    rebound = rs.solve(replace(impact, velocity=velocity), rtol=1e-4)
    assert np.all(rebound.status == Status.SEPARATED)
    # The tolerance is that of e^2, to which the closed form adds that of the loss.
    assert rebound.restitution_coefficient**2 == pytest.approx(1.0 - (sticks / velocity) ** 2, abs=4e-5)


# Equilibrium modulus, branch moduli and times; work, stress, velocity.
SECOND = [
    ((1.0, [4.0], [1.0]), 0.02, 0.3, 0.5),
    ((0.5, [2.0, 1.0, 0.5], [3.0, 0.3, 0.05]), 0.01, 0.25, 0.6),
    ((0.0, [3.0, 1.0], [1.0, 10.0]), 0.01, 0.3, 0.5),
    ((1.0, [], []), 0.01, 0.3, 0.3),
]


@pytest.mark.slow
@pytest.mark.parametrize(("material", "work", "stress", "velocity"), SECOND)
def test_another_program_has_the_same_rebound(material, work, stress, velocity):
    """Maxwell branches in the middle of cells, steps of their own: from 800 and 1600 elements, within 1e-7."""
    exact, rough, fine = extrapolated_restitution(material, work, stress, velocity, width=1.2, elements=800)
    assert abs(fine - rough) < 2e-5
    equilibrium, moduli, times = material
    result = rs.solve(ball(solid(moduli, times, equilibrium), work, stress, velocity))
    assert result.restitution_coefficient == pytest.approx(exact, abs=1e-6)


def random_impact(rng):
    """A body of any material and any profile, near and above its sticking velocity."""
    count = int(rng.integers(0, 4))
    moduli = 10.0 ** rng.uniform(-1, 1.5, count)
    work, lam = 10.0 ** rng.uniform((-4, -1), (-1, 0.5))
    glass = 1.0 + moduli.sum()
    velocity = math.sqrt(2.0 * JKR_LOSS * work ** (5.0 / 3.0)) * 10.0 ** rng.uniform(0.0, 1.2)
    times = 3.0 * velocity**-0.2 * glass**-0.4 * 10.0 ** rng.uniform(-2, 1.5, count)
    profile = [rs.Parabola(1.0), rs.Sphere(10.0), rs.PowerLaw(3.0, 0.5)][int(rng.integers(3))]
    stress = lam / float(maugis_number(work, 1.0, 1.0, 1.0))
    material = solid(moduli, times, equilibrium=float(count == 0 or rng.random() < 0.8))
    return rs.Impact(material, profile, 1.0, velocity, adhesion=rs.Adhesion(work, stress))


def test_an_elastic_body_without_jumps_gains_nothing_by_the_error_of_its_energy():
    """The extrapolated energy of some of these is above that before, by a millionth."""
    velocity = 0.00716 * np.geomspace(0.9, 1.1, 20)
    impact = rs.Impact(solid(), rs.Parabola(1.0), 1.0, velocity, adhesion=rs.Adhesion(1.498e-4, 3.434e-3))
    e = rs.solve(impact, rtol=1e-4).restitution_coefficient
    assert e.max() == 1.0
    assert e.min() > 1.0 - 1e-4


@pytest.mark.slow
def test_energy_closes_in_random_impacts():
    rng = np.random.default_rng(11)
    ends = []
    for _ in range(100):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            result = rs.solve(random_impact(rng), rtol=1e-4, errors="warn")
        ends.append(result.status)
        if result.status != Status.SEPARATED:
            continue
        energy = result.energy
        assert abs(energy.residual) < 1e-3
        assert min(energy.dissipated, energy.radiated, energy.stored) >= -1e-6 * energy.kinetic_in
        assert result.restitution_coefficient <= 1.0
    assert ends.count(Status.SEPARATED) > 50
    assert not any(status.failed for status in ends)


@pytest.mark.slow
def test_a_fractional_material_has_the_impact_of_its_prony_series_to_their_error():
    """Two series of one model, of other windows and errors, have one rebound within the larger error, 1e-3."""
    rng = np.random.default_rng(3)
    model = rs.fractional_zener(0.25, rng.uniform(0.5, 2.0), rng.uniform(0.3, 3.0), rng.uniform(0.4, 0.6))
    rough, fine = (rs.FractionalMaterial(model, math.inf, rtol=rtol) for rtol in (1e-3, 1e-5))
    speed = rng.uniform(0.5, 1.0)
    e = [
        rs.solve(ball(material, 0.02, 0.3, speed), rtol=1e-4).restitution_coefficient
        for material in (rough.within((1e-3, 30.0)), fine.within((1e-4, 300.0)))
    ]
    assert 0.2 < e[1] < 0.95
    assert e[0] == pytest.approx(e[1], abs=1e-3)
    # The window is found also where an impact has adhesion, and where it sticks.
    for velocity in (speed, 0.05):
        results = rs.for_contact(lambda window, v=velocity: ball(rough.within(window), 0.02, 0.3, v))
        result = rs.solve(results, rtol=1e-4)
        assert results.material.window[0] < 1e-3
        expected = e[1] if velocity == speed else 0.0
        assert result.restitution_coefficient == pytest.approx(expected, abs=1e-3)


def test_units_drop_out():
    # The same groups for a dust grain, a boulder, and at random: energies scale with the unit of energy.
    unit = rs.solve(ball(STANDARD, 0.02, 0.3, 0.5), rtol=1e-5)
    rng = np.random.default_rng(8)
    for length, mass, modulus in ((1e-8, 1e-20, 1e10), (1e2, 1e8, 1e6), 10.0 ** rng.uniform((-6, -9, 4), (1, 3, 11))):
        time = math.sqrt(mass / (modulus * length))
        material = rs.Material(rs.PronySeries(0.25 * modulus, [modulus], [time]), bulk=math.inf)
        adhesion = rs.Adhesion(0.02 * modulus * length, 0.3 * modulus)
        impact = rs.Impact(material, rs.Parabola(length), mass, 0.5 * length / time, adhesion=adhesion)
        other = rs.solve(impact, rtol=1e-5)
        assert other.restitution_coefficient == pytest.approx(unit.restitution_coefficient, rel=1e-8)
        assert other.pull_off_force == pytest.approx(unit.pull_off_force * modulus * length**2, rel=1e-7)
        assert other.radiated_energy == pytest.approx(unit.radiated_energy * modulus * length**3, rel=1e-6)


def test_two_equal_bodies_are_one_of_half_the_modulus():
    soft = rs.Material(rs.PronySeries(0.125, [0.5], [1.0]), bulk=math.inf)
    both = rs.solve(ball(STANDARD, 0.02, 0.3, 0.5, counter_material=STANDARD), rtol=1e-5)
    single = rs.solve(ball(soft, 0.02, 0.3, 0.5), rtol=1e-5)
    assert both.restitution_coefficient == pytest.approx(single.restitution_coefficient, abs=1e-8)


def test_arrays_of_numbers_and_of_adhesion():
    impacts = replace(ball(STANDARD, 0.02, 0.3, 0.5), velocity=[[0.5], [1.0]], adhesion=rs.Adhesion([0.01, 0.02], 0.3))
    result = rs.solve(impacts, rtol=1e-4)
    assert result.restitution_coefficient.shape == (2, 2)
    single = rs.solve(ball(STANDARD, 0.02, 0.3, 1.0), rtol=1e-4)
    assert result.restitution_coefficient[1, 1] == single.restitution_coefficient
    assert result.energy.radiated[1, 1] == single.energy.radiated
    assert result.to_dataset(["restitution_coefficient", "pull_off_force"]).pull_off_force.shape == (2, 2)


def test_a_list_has_the_results_of_its_impacts():
    other = rs.Impact(solid([2.0], [0.3]), rs.PowerLaw(3.0, 0.5), 2.0, 1.0, adhesion=rs.Adhesion(0.01, 0.2))
    impacts = [ball(STANDARD, 0.02, 0.3, 0.5), ball(STANDARD, 0.05, 0.5, 0.5), other]
    together, apart = rs.solve(impacts, rtol=1e-4), [rs.solve(each, rtol=1e-4) for each in impacts]
    names = ("restitution_coefficient", "status", "pull_off_force", "contact_time", "zone_width", "restitution_error")
    for name in names:
        assert getattr(together, name).tolist() == [getattr(each, name) for each in apart]
    assert together.energy.kinetic_out.tolist() == [each.energy.kinetic_out for each in apart]
    numbers = np.transpose(together.maugis_numbers)
    assert np.array_equal(numbers, [each.maugis_numbers for each in apart], equal_nan=True)
    for n, check in enumerate(together.validity):
        worst = [each.validity[check.kind].value for each in apart]
        assert check.value is None or check.value in worst, n
    assert len(together.plot().axes) == 2


def test_a_list_raises_for_the_impact_that_fails():
    impacts = [ball(STANDARD, 0.02, 0.3, 0.5), ball(solid(), 0.01, 5e4, 0.5)]
    with pytest.raises(SolverError, match="impact 1 of 2"):
        rs.solve(impacts, rtol=1e-3, errors="raise")


def test_names_of_axes_stay():
    import xarray as xr

    works = xr.DataArray([0.01, 0.02], dims="work", coords={"work": [0.01, 0.02]})
    result = rs.solve(replace(ball(STANDARD, 0.02, 0.3, 1.0), adhesion=rs.Adhesion(works, 0.3)), rtol=1e-4)
    assert result.pull_off_force.dims == ("work",)
    assert float(result.sel(work=0.02).pull_off_force) == float(result.pull_off_force.sel(work=0.02))
    assert float(result.restitution_coefficient.sel(work=0.01)) > float(result.restitution_coefficient.sel(work=0.02))


def test_history_has_its_jumps():
    result = rs.solve(ball(STANDARD, 0.02, 0.8, 0.5), rtol=1e-4)
    history = result.history
    first, last = result.jumps[0], result.jumps[-1]
    assert first.inward
    assert not last.inward
    # The surface bulges at once by the instantaneous compliance: c = 8 sigma0 R/(pi E0) where nothing touches yet.
    assert first.indentation_depth == pytest.approx(-0.02 / 0.8)
    assert last.zone_radius_after == 0.0
    assert float(history.zone_radius[-1]) == 0.0
    assert np.all(history.zone_radius >= history.contact_radius)
    assert float(history.jump_energy[-1]) == pytest.approx(sum(jump.energy for jump in result.jumps))
    assert float(result.sample([0.0]).indentation_velocity[0]) == pytest.approx(0.5)


@pytest.mark.parametrize("force", [0.0, 0.05])
def test_a_body_that_leaves_slowly_is_free_after_the_last_jump(force):
    """The surface relaxes faster than the body leaves, so that the march goes on without attraction."""
    slow = ball(solid([1.0], [0.1]), 0.02, 0.3, 0.4, external_force=force)
    velocity = rs.sticking_velocity(slow, rtol=1e-3) * float(np.random.default_rng(8).uniform(1.005, 1.02))
    result = rs.solve(replace(slow, velocity=velocity), rtol=1e-5)
    last = result.jumps[-1]
    assert last.zone_radius_after == 0.0
    # Both are of one march, the first ones extrapolated from two.
    assert result.contact_time == pytest.approx(last.time, rel=1e-4)
    assert result.residual_indentation_depth == pytest.approx(last.indentation_depth, rel=1e-3)
    assert result.history.time[-1] == last.time
    assert abs(result.energy.residual) < 2e-4


def test_the_first_jump_without_touch_has_a_closed_form():
    # c^2/2 = (4 sigma0/(pi E0)) c for a parabola, R = 1: int_0^c H/sqrt(c^2 - x^2) dx = pi h0/2 at d = -h0.
    result = rs.solve(ball(STANDARD, 0.02, 0.1, 0.5), rtol=1e-4)
    assert result.jumps[0].zone_radius_after == pytest.approx(8.0 * 0.1 / (math.pi * 5.0), rel=1e-9)
    assert result.jumps[0].contact_radius_after == 0.0


def test_what_the_theory_does_not_have_is_refused():
    impact = ball(STANDARD, 0.02, 0.3, 0.5)
    assert in_one_line(lambda: replace(impact, impedance=1.0)).field == "impedance"
    assert in_one_line(lambda: replace(impact, profile=rs.Pyramid(1.2))).field == "profile"
    assert in_one_line(lambda: replace(impact, profile=rs.FlatPunch(1.0))).field == "profile"
    assert in_one_line(lambda: replace(impact, adhesion=0.05), rs.InputError).field == "adhesion"
    dashpot = rs.Material(rs.PronySeries(1.0, [1.0], [1.0], parallel_viscosity=0.1), bulk=math.inf)
    assert in_one_line(lambda: rs.solve(replace(impact, material=dashpot))).field == "material"
    assert in_one_line(lambda: rs.solve(impact, "elements")).field == "method"
    far = in_one_line(lambda: replace(impact, profile=rs.Sphere([1.0, 1e-3]), adhesion=rs.Adhesion(1.0, 1.0)))
    assert (far.field, far.index) == ("adhesion.range", (1,))
    assert "work over the stress" in far.rule
    assert in_one_line(lambda: rs.solve([impact, replace(impact, adhesion=None)])).field == "impact"
    assert in_one_line(lambda: rs.solve([impact], "elements")).field == "method"
    assert in_one_line(lambda: replace(impact, friction=0.5, tangential_velocity=1.0)).field == "friction"
    assert in_one_line(lambda: rs.bounces(impact, same_spot=True)).field == "same_spot"
    plain = rs.solve(replace(impact, adhesion=None))
    assert in_one_line(lambda: plain.to_dataset(["pull_off_force"])).field == "outputs"
    assert in_one_line(lambda: rs.element_history(impact)).field == "adhesion"
    assert in_one_line(lambda: rs.dimensionless_groups(impact)).field == "impact"
    assert in_one_line(lambda: rs.calibrate(impact, "lammps-tsuji", velocity=(0.1, 1.0))).field == "target"
    assert in_one_line(lambda: rs.sticking_velocity(replace(impact, adhesion=None))).field == "impact"


def test_a_zone_that_is_too_thin_is_refused():
    impact = ball(solid(), 0.01, 500.0, 0.5)
    with pytest.raises(SolverError, match="lambda = 5") as caught:
        rs.solve(impact)
    assert caught.value.status == Status.NOT_ACCURATE
    # Another stress is the remedy, no other tolerance.
    assert "rtol" not in str(caught.value)


def test_a_range_that_hides_the_depth_is_refused():
    impact = replace(ball(STANDARD, 1.0, 1.0, 0.5), profile=rs.Cone(0.8), adhesion=rs.Adhesion(1.0, 1e-30))
    with pytest.raises(SolverError, match="lost in its rounding; take a larger stress") as caught:
        rs.solve(impact)
    assert "rtol" not in str(caught.value)
    with pytest.warns(UserWarning, match="1 of 2"):
        result = rs.solve(replace(impact, adhesion=rs.Adhesion(1.0, [1.0, 1e-30])))
    assert list(result.status) == [Status.CAPTURED, Status.NOT_ACCURATE]


def test_the_least_work_of_adhesion_is_none():
    """The square of its stress vanishes in floating point."""
    e = rs.solve(ball(STANDARD, 1e-300, 1e-291, 0.5)).restitution_coefficient
    assert e == pytest.approx(
        rs.solve(replace(ball(STANDARD, 1.0, 1.0, 0.5), adhesion=None)).restitution_coefficient, abs=1e-5
    )


def wide_spectrum():
    """A rubber of 12 terms over eleven decades, whose fastest ones are far below the time of a contact."""
    times = np.logspace(-9.0, 2.0, 12)
    rubber = rs.Material(rs.PronySeries(1e6, 1e8 * (times / 1e-9) ** -0.3, times), bulk=math.inf)
    return rs.Impact(rubber, rs.Sphere(1e-3), mass=5e-6, velocity=0.5, adhesion=rs.Adhesion(work=0.1, stress=1e7))


@pytest.mark.slow
def test_a_wide_spectrum_is_solved_within_rtol():
    impact = wide_spectrum()
    fine = rs.solve(impact, rtol=4e-5)
    for rtol in (1e-3, 1e-4):
        rough = rs.solve(impact, rtol=rtol)
        assert rough.restitution_error <= rtol
        error = rough.restitution_error + fine.restitution_error
        assert abs(rough.restitution_coefficient - fine.restitution_coefficient) <= error


def test_a_missed_tolerance_has_the_error_that_was_reached(monkeypatch):
    impact = wide_spectrum()
    monkeypatch.setattr(attraction, "MOST", 800)
    monkeypatch.setattr(attraction, "_WORK", 0.0)
    monkeypatch.setattr(attraction, "_FINEST", 1)
    with pytest.raises(SolverError, match=r"the error of e is [0-9.e-]+; range") as caught:
        rs.solve(impact, rtol=1e-5)
    assert caught.value.status == Status.NOT_ACCURATE
    with pytest.warns(rs.RestitutionWarning, match="NOT_ACCURATE|not reached"):
        result = rs.solve(impact, rtol=1e-5, errors="warn")
    assert math.isnan(result.restitution_coefficient)
    assert 1e-5 < result.restitution_error < 0.1


def test_marches_in_pieces_are_the_same_and_end_with_the_work(monkeypatch):
    problem = Problem(Sticky(rs.Parabola(1.0), rs.PronySeries(1.0, [4.0], [1.0]), rs.Adhesion(0.02, 0.3)), 1.0, 0.5)
    width, duration = scales(problem)
    whole = problem.march(width, duration, 100)
    monkeypatch.setattr(attraction, "_PIECE", 1000)
    pieces = problem.march(width, duration, 100)
    assert pieces.end == whole.end
    assert np.array_equal(pieces.motion, whole.motion)
    assert pieces.jumps == whole.jumps
    # The kernel returns after a thousand changes of elements, and sees that the work is over.

    def end():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), ended_by(end):
        problem.march(width, duration, 100)


def test_an_interrupt_ends_a_long_march(monkeypatch):
    monkeypatch.setattr(attraction, "_PIECE", 1000)
    calls = []

    def interrupted(*_):
        calls.append(1)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return PAUSED

    monkeypatch.setattr(kernel, "march", interrupted)
    with pytest.raises(KeyboardInterrupt):
        rs.solve(ball(STANDARD, 0.02, 0.3, 0.5))
    assert len(calls) == 3


def test_a_case_file_has_a_section(tmp_path):
    text = """
    [body]
    mass = 1
    radius = 1
    [material]
    shear = {equilibrium_modulus = 0.25, branch_moduli = [1], relaxation_times = [1]}
    bulk_modulus = "incompressible"
    [impact]
    velocity = 0.5
    [adhesion]
    work = "20 mJ/m^2"
    stress = 0.3
    [solver]
    rtol = 1e-4
    """
    path = tmp_path / "ball.toml"
    path.write_text(text)
    result = rs.read_case(path).solve()
    assert (
        result.restitution_coefficient == rs.solve(ball(STANDARD, 0.02, 0.3, 0.5), rtol=1e-4).restitution_coefficient
    )
    path.write_text(text.replace("velocity = 0.5", "velocity = 0.5\nweight = true\ngravity = 0.01"))
    series = rs.read_case(path).bounces()
    weighed = rs.solve(ball(STANDARD, 0.02, 0.3, 0.5, external_force=0.01), rtol=1e-4)
    assert series.restitution_coefficient[0] == weighed.restitution_coefficient != result.restitution_coefficient
    assert rs.read_case(path).solve().restitution_coefficient == weighed.restitution_coefficient
    assert series.ended == "stuck"
    path.write_text(text.replace("stress = 0.3", 'stress = 0.3\nrange = "1 nm"'))
    assert "adhesion" in str(in_one_line(lambda: rs.read_case(path)))


def test_results_tell_their_numbers():
    result = rs.solve(ball(STANDARD, 0.02, 0.3, 0.5), rtol=1e-4)
    static, glass = result.maugis_numbers
    assert static == pytest.approx(0.3 * (9.0 / (2.0 * math.pi * 0.02)) ** (1.0 / 3.0))
    assert static / glass == pytest.approx(5.0 ** (2.0 / 3.0))
    text = str(result.summary())
    assert "range of the attraction 66.67 mm" in text
    assert f"lambda {static:.3g} at rest" in text
    assert result.to_dict()["pull_off_force"] == result.pull_off_force
    assert result.outputs["radiated_energy"] == result.energy.radiated
    # The force is largest near the largest depth, and the body turns there.
    assert result.sample([result.turning_time]).indentation_depth[0] == pytest.approx(
        result.max_indentation_depth, rel=1e-3
    )
    assert result.history.time.attrs["long_name"] == "time since the first attraction"
