"""Adhesive impacts under a constant force: another program, limits, balance of energy, rest, and bounces."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

import restitution as rs
from adhesive_elements import extrapolated_restitution
from restitution.contact.adhesion import static_contact
from restitution.impact.adhesive import problem_of
from restitution.impact.dugdale import _numbers
from restitution.impact.status import Status
from restitution.indentation.attraction import March

pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")


def solid(moduli=(), times=(), equilibrium=1.0):
    """Material with the reduced modulus equilibrium + sum of moduli exp(-t/times)."""
    shear = rs.PronySeries(0.25 * equilibrium, 0.25 * np.asarray(moduli, dtype=float), times)
    return rs.Material(shear, bulk=math.inf)


def ball(material, velocity, force, work=None, stress=None):
    """A unit ball of unit mass."""
    adhesion = None if work is None else rs.Adhesion(work, stress)
    return rs.Impact(material, rs.Parabola(1.0), 1.0, velocity, external_force=force, adhesion=adhesion)


STANDARD = solid([4.0], [1.0])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("material", "work", "stress", "velocity", "force", "change", "off"),
    [
        ((1.0, [4.0], [1.0]), 0.02, 0.3, 0.5, 0.03, 1e-4, 2e-6),
        ((0.0, [3.0, 1.0], [1.0, 10.0]), 0.01, 0.3, 0.5, 0.02, 1e-4, 2e-6),
        # The body leaves more slowly than the surface may follow, and the force slows it down when it is free.
        ((1.0, [1.0], [0.1]), 0.02, 0.3, 0.386, 0.05, 5e-4, 5e-5),
    ],
)
def test_another_program_has_the_same_rebound(material, work, stress, velocity, force, change, off):
    """Maxwell branches in the middle of cells, steps of their own: from 400 and 800 elements."""
    program = material, work, stress, velocity
    exact, rough, fine = extrapolated_restitution(*program, weight=force, width=1.3, elements=400)
    assert abs(fine - rough) < change
    equilibrium, moduli, times = material
    impact = ball(solid(moduli, times, equilibrium), velocity, force, work, stress)
    e = rs.solve(impact).restitution_coefficient
    # What extrapolation leaves is of higher order than the change, and irregular.
    assert e == pytest.approx(exact, abs=off)
    # The force does change it.
    assert abs(rs.solve(replace(impact, external_force=0.0)).restitution_coefficient - e) > 1e-3


def test_without_work_of_adhesion_it_is_the_impact_without_adhesion():
    """Fronts and panels share no code with the elements; both let a body turn back that its weight holds."""
    rng = np.random.default_rng(11)
    ends = set()
    for scale in (0.01, 0.1, 1.0, 10.0):
        material = solid(10.0 ** rng.uniform(-1, 1, 2), 10.0 ** rng.uniform(-1.5, 0.5, 2))
        plain = ball(material, float(rng.uniform(0.1, 0.5)), scale * float(rng.uniform(0.2, 1.0)))
        expected, result = rs.solve(plain), rs.solve(replace(plain, adhesion=rs.Adhesion(1e-12, 1e-4)))
        assert result.status == expected.status
        assert result.restitution_coefficient == pytest.approx(expected.restitution_coefficient, abs=2e-6)
        assert result.max_force == pytest.approx(expected.max_force, rel=1e-4)
        assert result.residual_indentation_depth == pytest.approx(expected.residual_indentation_depth, abs=1e-5)
        if result.status == Status.SEPARATED:
            assert result.max_indentation_depth == pytest.approx(expected.max_indentation_depth, rel=1e-6)
        ends.add(result.status)
    assert ends == {Status.SEPARATED, Status.CAPTURED}


def test_energy_closes_with_the_work_of_the_force_from_the_first_attraction_on():
    """The range is a third of the depth, so that the work on the way through it is none of rounding."""
    rng = np.random.default_rng(12)
    count = 0
    for _ in range(6):
        moduli, times = 10.0 ** rng.uniform(-1, 0.5, 2), 10.0 ** rng.uniform(-1.5, 0.5, 2)
        force = float(10.0 ** rng.uniform(-3, -0.5))
        impact = ball(solid(moduli, times), float(rng.uniform(0.3, 1.0)), force, 0.01, float(rng.uniform(0.05, 0.3)))
        result = rs.solve(impact, rtol=1e-5)
        if result.status == Status.SEPARATED:
            count += 1
            assert abs(result.energy.residual) < 1e-4
            swept = rs.solve(replace(impact, velocity=[impact.velocity]), rtol=1e-5)
            assert swept.energy.residual[0] == pytest.approx(result.energy.residual, abs=1e-12)
            table = rs.sweep(impact, {"velocity": [impact.velocity]}, outputs=["energy_residual"], rtol=1e-5)
            assert float(table["energy_residual"][0]) == pytest.approx(result.energy.residual, abs=1e-12)
    assert count >= 3


def test_no_random_impact_under_a_force_fails():
    """Light and heavy bodies, underdamped and overdamped: all leave or are held, and none that leaves gains energy."""
    rng = np.random.default_rng(13)
    ends = []
    for _ in range(60):
        count = int(rng.integers(0, 4))
        material = solid(10.0 ** rng.uniform(-1, 1.5, count), 10.0 ** rng.uniform(-2, 2, count))
        work, velocity = 10.0 ** rng.uniform((-4, -1), (-1.5, 0.2))
        # The force times a depth is up to three times the energy of the impact.
        force = 10.0 ** rng.uniform(-4, 0.5) * 0.5 * velocity**1.2
        result = rs.solve(ball(material, velocity, force, work, 10.0 ** rng.uniform(0, 1.5) * work), rtol=1e-4)
        ends.append(result.status)
        if result.status == Status.SEPARATED:
            assert abs(result.energy.residual) < 1e-3
            assert result.energy.dissipated >= -1e-6 * result.energy.kinetic_in
    assert min(ends.count(Status.SEPARATED), ends.count(Status.CAPTURED)) > 10


@pytest.mark.parametrize("material", [STANDARD, solid([30.0, 3.0, 0.3], [0.01, 1.0, 1e4])])
@pytest.mark.parametrize("force", [1e-3, 0.3, 20.0])
def test_a_body_that_is_held_rests_as_the_static_contact_of_maugis_with_its_weight(material, force):
    """Adhesion alone, both, or nearly the weight alone holds it; the second material relaxes for 1e4 contact times."""
    result = rs.solve(ball(material, 0.2, force, 0.05, 0.5))
    assert result.status == Status.CAPTURED
    assert result.restitution_coefficient == 0.0
    adhesion, profile = rs.Adhesion(0.05, 0.5), rs.Parabola(1.0)
    radius = brentq(lambda a: static_contact(profile, 1.0, adhesion, a).force - force, 0.3, 5.0)
    assert result.residual_indentation_depth == pytest.approx(
        static_contact(profile, 1.0, adhesion, radius).depth, rel=1e-9
    )
    assert result.max_force >= force


def test_a_body_that_swings_on_its_weight_is_followed_until_it_turns_back_twice():
    """It loses some thousandths in a swing, so that its rest is far away; without adhesion it is held, too."""
    impact = ball(solid([0.002], [1.0]), 0.001, 0.3, 1e-7, 1e-3)
    assert rs.solve(replace(impact, adhesion=None)).status == Status.CAPTURED
    result = rs.solve(impact, rtol=1e-4)
    assert result.status == Status.CAPTURED
    speed = result.history.indentation_velocity.values
    assert np.count_nonzero((speed[:-1] < 0.0) & (speed[1:] >= 0.0)) == 2


def test_the_largest_depth_within_a_step_is_that_of_a_throw():
    """Under a constant net force a body with the speed u turns after m u^2/(2 (F - F0))."""
    problem = problem_of(ball(STANDARD, 1.0, 1.0, 0.02, 0.3))
    motion = np.zeros((3, 8))
    motion[:, 0], motion[:, 1], motion[:, 2], motion[:, 3] = (
        range(3),
        (0.0, 0.5, 0.45),
        (1.0, 0.4, -0.6),
        (0.0, 3.0, 3.0),
    )
    motion[:, 4] = 0.1, 0.2, 0.2
    numbers = _numbers(problem, March(0, motion, (), 0.0))
    assert numbers["max_indentation_depth"] == pytest.approx(0.5 + 0.5 * 0.4**2 / (3.0 - 1.0), rel=1e-12)


def test_a_liquid_under_its_weight_is_held():
    result = rs.solve(ball(solid([3.0], [1.0], 0.0), 0.2, 0.5, 0.01, 0.1))
    assert result.status == Status.CAPTURED
    assert math.isinf(result.residual_indentation_depth)


def test_the_sticking_velocity_rises_with_the_weight():
    """The body leaves just above it and stays just below, each by a solve of its own."""
    impact = ball(STANDARD, 0.5, 0.03, 0.02, 0.3)
    threshold = rs.sticking_velocity(impact, rtol=1e-3)
    assert threshold > 1.01 * rs.sticking_velocity(replace(impact, external_force=0.0), rtol=1e-3)
    assert rs.solve(replace(impact, velocity=1.01 * threshold), rtol=1e-4).restitution_coefficient > 0.0
    assert rs.solve(replace(impact, velocity=0.99 * threshold), rtol=1e-4).status == Status.CAPTURED


def test_bounces_under_the_weight_are_impacts_with_the_force():
    """What holds the body at the end is the attraction where it would do so alone, else the weight."""
    material = rs.standard_solid(1e6, 3e6, 30.0, poisson_ratio=0.45)
    bead = rs.Impact(material, rs.Parabola(1e-3), 5e-6, 0.4, adhesion=rs.Adhesion(0.05, 1e5))
    series = rs.bounces(bead, rtol=1e-4)
    weighed = replace(bead, external_force=5e-6 * 9.80665)
    impacts = [rs.solve(replace(weighed, velocity=velocity), rtol=1e-4) for velocity in series.velocity]
    assert [impact.restitution_coefficient for impact in impacts] == list(series.restitution_coefficient)
    assert series.n_bounces > 2
    assert series.ended == "stuck"
    assert series.residual_indentation_depth[-1] == impacts[-1].residual_indentation_depth
    feeble = rs.bounces(replace(bead, adhesion=rs.Adhesion(1e-9, 1.0)), rtol=1e-4)
    assert feeble.ended == "captured"
