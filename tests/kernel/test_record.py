"""Elements of order two under measured depths: the rows of the design page on cycles, elements followed alone, one
approach and release by `rs.indent`, panels, and springs."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

import restitution as rs
from element_follower import Follower
from kernel.test_histories import D1, D1_FORCES, D1_TIMES, D2, D2_FORCES, D2_TIMES, STANDARD, run_depth
from restitution.indentation.records import Record, RecordBlock
from restitution.kernel.program import DONE
from restitution.material.prony import PronySeries

BALL = rs.Parabola(1.0)
MATERIALS = {
    "solid": PronySeries(0.5, [1.0, 2.0, 4.0], [0.05, 0.5, 5.0]),
    "liquid": PronySeries(0.0, [4.0], [1.0]),
    "dashpot": PronySeries(1.0, [4.0], [1.0], parallel_viscosity=0.3),
    "Kelvin-Voigt": PronySeries(1.0, [], [], parallel_viscosity=0.3),
    "elastic": PronySeries(1.0),
    "fast": PronySeries(1.0, [2.0, 3.0], [1e-4, 0.7]),
    "twenty terms": PronySeries(1.0, np.ones(20), np.logspace(-6.0, 4.0, 20)),
}


def force_of(series, time, depth, profile=BALL, contact_point=0.0, compliance=0.0, refinement=1):
    block = RecordBlock(profile, [Record(time, depth, compliance)], 2.0, refinement=refinement)
    return block.forces(PronySeries.stacked([series]), np.array([contact_point]))[0][0]


def sampled(program, per_unit):
    time = np.linspace(0.0, program[0][-1], round(10 * program[0][-1]) * per_unit // 10 + 1)
    return time, np.interp(time, *program)


@pytest.mark.plain
@pytest.mark.parametrize(
    ("program", "times", "forces"), [(D1, D1_TIMES, D1_FORCES), (D2, D2_TIMES, D2_FORCES)], ids=["D1", "D2"]
)
def test_programs_that_grow_again_with_an_error_of_second_order(program, times, forces):
    errors = []
    for per_unit in (400, 800, 1600):
        time, depth = sampled(program, per_unit)
        places = np.searchsorted(time, np.array(times) - 1e-9)
        errors.append(np.abs(force_of(STANDARD, time, depth)[places] - forces).max() / max(forces))
    assert errors[0] < 2e-5
    assert np.diff(np.log2(errors)) == pytest.approx([-2.0, -2.0], abs=0.2)


@pytest.mark.plain
@pytest.mark.parametrize("steps", [200, 400])
def test_each_step_of_an_approach_keeps_its_element(steps):
    """A ball pressed in at a constant rate: F = (4/3) int E(t - u) d(u^(3/2)), with an error of second order."""
    time = np.linspace(0.0, 1.0, steps + 1)
    expected = 2.0 * quad(lambda u: 4.0 * math.exp(u - 1.0) * math.sqrt(u), 0.0, 1.0, epsabs=1e-12)[0]
    assert force_of(MATERIALS["liquid"], time, time)[-1] == pytest.approx(expected, rel=0.2 / steps**2)


@pytest.mark.parametrize(
    "profile",
    [BALL, rs.Cone(math.pi / 4.0), rs.PowerLaw(3.0, 1.0), rs.FlatPunch(1.0), rs.Sphere(2.0)],
    ids=["parabola", "cone", "r^3", "flat", "sphere"],
)
@pytest.mark.parametrize("name", MATERIALS)
def test_one_cycle_is_that_of_an_indentation(name, profile):
    """Growth by Lee and Radok, shrinkage by Ting, computed by the kernel of `rs.indent`."""
    program, series = ([0.0, 0.3, 1.0, 1.5], [0.0, 1.0, 1.0, 0.0]), MATERIALS[name]
    time = np.linspace(0.0, 1.5, 451)
    expected = rs.indent(
        rs.Material(series.scaled(0.25), math.inf), profile, depth=program[1], time=program[0], rtol=1e-10
    ).sample(time).force.values  # fmt: skip
    # The force of a dashpot jumps at the kinks.
    compared = np.ones(time.size, dtype=bool)
    if series.parallel_viscosity > 0.0:
        compared = np.abs(time[:, None] - program[0]).min(axis=1) > 1e-6
    error = np.abs(force_of(series, time, np.interp(time, *program), profile) - expected)[compared]
    assert error.max() < 5e-6 * expected.max()


def followed(series, time, depth, place, elements=100):
    """Force at a sample from loads of elements that are followed alone, by the midpoint rule over a = sqrt(s)."""
    moduli, times = series.branch_moduli, series.relaxation_times
    follower = Follower(series.equilibrium_modulus, moduli, times, time[: place + 1], depth[: place + 1])
    width = math.sqrt(depth.max()) / elements
    return 2.0 * width * sum(follower.load(s, time[place]) for s in (width * (np.arange(elements) + 0.5)) ** 2)


@pytest.mark.parametrize(
    ("seed", "places"),
    [(0, [60]), *(pytest.param(seed, [36, 46, 60], marks=pytest.mark.slow) for seed in (0, 1, 2))],
)
def test_a_noisy_record_with_a_hold_and_cycles_against_elements_followed_alone(seed, places):
    """Approach from above, hold, partial release, second approach, release; each sample is a kink."""
    rng = np.random.default_rng(seed)
    series = PronySeries(1.0, 10.0 ** rng.uniform(-1.0, 1.0, 2), 10.0 ** rng.uniform(-1.5, 1.0, 2))
    time = np.linspace(0.0, 3.0, 61)
    depth = np.interp(time, [0.0, 0.2, 1.0, 2.0, 2.4, 2.7, 3.0], [-0.2, 0.0, 1.0, 1.0, 0.5, 0.9, 0.4])
    depth += 10.0 ** rng.uniform(-3.0, -1.5) * rng.normal(size=time.size)
    force = force_of(series, time, depth, refinement=4)
    for place in places:
        # The midpoint rule at an edge has an error of some (1/100)^2 of the force.
        assert force[place] == pytest.approx(followed(series, time, depth, place), abs=2e-4 * force.max())


@pytest.mark.parametrize("places", [[46], pytest.param([41], marks=pytest.mark.slow)])
def test_a_relaxed_liquid_whose_elements_leave_within_one_step(places):
    """A hold of twenty relaxation times with noise: the load is gone, and small movements free the whole contact."""
    rng, series = np.random.default_rng(0), PronySeries(0.0, [1.33], [0.05])
    time = np.linspace(0.0, 3.0, 121)
    depth = np.interp(time, [0.0, 0.2, 0.8, 1.8, 2.2, 2.5, 3.0], [-0.2, 0.0, 1.0, 1.0, 0.5, 0.9, 0.0])
    depth += 1e-3 * rng.normal(size=time.size)
    force = force_of(series, time, depth)
    for place in places:
        assert force[place] == pytest.approx(followed(series, time, depth, place, 75), abs=5e-4 * force.max())


@pytest.mark.parametrize("name", ["solid", "elastic"])
def test_panels_give_the_same_curve_on_a_smooth_record(name):
    series, time = MATERIALS[name], np.linspace(0.0, 4.5, 1801)
    panels = run_depth(series, D2, 1e-9, 2.0)
    assert panels.outcome == DONE
    expected = 2.0 * panels.sample(time[1:], 2)
    error = np.abs(force_of(series, time, np.interp(time, *D2))[1:] - expected)
    assert error.max() < 2e-5 * expected.max()


@pytest.mark.parametrize("profile", [BALL, rs.Cone(math.pi / 4.0)], ids=["parabola", "cone"])
def test_a_dashpot_is_the_limit_of_a_fast_term(profile):
    """Its error falls with the time tau of the term; after a kink it relaxes within some tau."""
    time = np.linspace(0.0, 4.5, 1801)
    depth = np.interp(time, *D2)
    expected = force_of(MATERIALS["dashpot"], time, depth, profile)
    later = ((time[:, None] - D2[0] > 2e-3) | (time[:, None] < np.array(D2[0]) - 1e-9)).all(axis=1)
    for tau, share in ((3e-4, 3e-3), (1e-5, 1e-3)):
        fast = PronySeries(1.0, [4.0, 0.3 / tau], [1.0, tau])
        error = np.abs(force_of(fast, time, depth, profile, refinement=4) - expected)[later]
        assert error.max() < share * expected.max()


@pytest.mark.parametrize("compliance", [0.01, 0.3, 3.0])
@pytest.mark.parametrize("name", ["solid", "liquid"])
def test_the_tip_on_a_spring_is_at_the_base_less_the_deflection(name, compliance):
    """The force under the resulting depth without a spring is the same."""
    series, time = MATERIALS[name], np.linspace(0.0, 4.5, 1801)
    base = np.interp(time, *D2)
    force = force_of(series, time, base, compliance=compliance, refinement=4)
    again = force_of(series, time, base - compliance * force, refinement=4)
    inside = force > 0.0
    assert inside.sum() > 900
    assert np.abs(again - force)[inside].max() < 1e-3 * force.max()


def test_slopes_are_those_over_single_depths():
    time = np.linspace(0.0, 1.0, 201)
    depth = np.interp(time, [0.0, 0.1, 0.6, 1.0], [-0.1, 0.0, 0.8, 0.7])
    series = PronySeries.stacked([MATERIALS["solid"]])
    force, slope = RecordBlock(BALL, [Record(time, depth)], 2.0).forces(series, np.zeros(1))
    step = 1e-6
    for place in (80, 140, 200):
        moved = depth + step * (np.arange(time.size) == place)
        change = RecordBlock(BALL, [Record(time, moved)], 2.0).forces(series, np.zeros(1))[0] - force
        assert slope[0, place] == pytest.approx(change[0, place] / step, rel=0.01)


def test_forces_have_derivatives_over_the_contact_point_and_the_moduli():
    """Steps as small as those of a fit give the slope of large ones, also with noise and where elements pass."""
    rng, time = np.random.default_rng(4), np.linspace(0.0, 3.0, 1200)
    depth = np.interp(time, [0.0, 0.3, 1.0, 2.0, 2.6, 3.0], [-0.3, 0.0, 1.0, 1.0, 0.2, 0.9])
    block = RecordBlock(BALL, [Record(time, depth + 3e-4 * rng.normal(size=time.size))], 2.0)
    points = 0.05 + 1e-4 * rng.uniform(size=8)
    for place in points:
        far, near = 2e-3, 1e-5
        moves = np.array([-far, far, -near, near])
        rows = PronySeries.stacked([STANDARD] * 4)
        low, high, below, above = block.forces(rows, place + moves)[0]
        slopes = (high - low) / (2.0 * far), (above - below) / (2.0 * near)
        size = np.linalg.norm(slopes[0])
        assert np.linalg.norm(slopes[0] - slopes[1]) < 3e-3 * size
        factors = np.exp(np.array([-1e-2, 1e-2, -1e-4, 1e-4]))
        rows = PronySeries.stacked([PronySeries(1.0, [4.0 * factor], [1.0]) for factor in factors])
        low, high, below, above = block.forces(rows, np.full(4, place))[0]
        slopes = (high - low) / 2e-2, (above - below) / 2e-4
        assert np.linalg.norm(slopes[0] - slopes[1]) < 3e-3 * np.linalg.norm(slopes[0])


def test_rows_without_a_result_are_nan_and_do_not_disturb_others():
    time = np.linspace(0.0, 1.0, 50)
    rows = PronySeries.from_checked(np.array([1.0, np.nan, 0.0, 1.0, 1.0]), np.zeros((5, 0)), np.zeros((5, 0)))
    block = RecordBlock(
        rs.Tabulated(np.linspace(0.0, 1.0, 9), np.linspace(0.0, 1.0, 9) ** 2), [Record(time, time)], 2.0
    )
    forces, _ = block.forces(rows, np.array([0.5, 0.5, 0.5, -0.1, 0.5]), workers=2)
    assert np.isnan(forces).all(axis=1).tolist() == [False, True, True, True, False]
    assert np.array_equal(forces[0], forces[4])
