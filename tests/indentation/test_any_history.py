"""Contacts over any history, as users call them: reference rows, elements followed alone, closed forms, and errors.

The rows D1 and D2 have been computed by panels of two orders and by single elements followed alone.
"""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import expm

import restitution as rs
from element_follower import followed_force, pressed_elements, program
from refusals import in_one_line
from restitution import InputError, Material, PronySeries, indent
from restitution.contact.profiles import Cone, FlatEndedParabola, FlatPunch, Parabola, PowerLaw, TruncatedCone
from restitution.indentation import panels
from restitution.kernel.driver import NOT_SOLVED

# E*(t) = 1 + 4 exp(-t).
STANDARD = PronySeries(1.0, [4.0], [1.0])
TIP = Parabola(1.0)
D1 = {"time": [0.0, 1.0, 1.3, 1.6, 2.0, 3.0, 4.2], "depth": [0.0, 1.0, 0.7, 0.9, 0.6, 1.2, 0.0]}
D2 = {"time": [0.0, 1.0, 1.5, 2.5, 3.0, 4.0, 4.5], "depth": [0.0, 1.0, 0.0, 1.0, 0.0, 1.2, 0.0]}
THREE, LIQUID = PronySeries(0.5, [1.0, 2.0, 4.0], [0.05, 0.5, 5.0]), PronySeries(0.0, [4.0, 1.0], [1.0, 0.2])
DAMPED = PronySeries(1.0, [4.0], [1.0], parallel_viscosity=0.3)
CONE, PUNCH = Cone(1.1), FlatPunch(0.4)


def half_space(series):
    """Incompressible half-space whose reduced modulus E* = 4 G is this series."""
    return Material(series.scaled(0.25), math.inf)


SOLID = half_space(STANDARD)


def test_a_program_that_grows_again_before_the_end():
    """Row D1."""
    result = indent(SOLID, TIP, rtol=1e-11, **D1)
    sample = result.sample([1.3, 1.5, 1.8, 2.0, 2.2, 2.6, 3.0, 3.4])
    forces = [1.662349638581, 2.548321650863, 1.429672940494, 0.361749342104, 1.164867465837, 2.912040537415,
              4.513766313114, 0.401520510647]  # fmt: skip
    radii = [0.7832003593, 0.9004289789, 0.8120874077, 0.5478348904, 0.7830276320, 0.9793145298, 1.0954451150,
             0.6346392368]  # fmt: skip
    assert sample.force.values == pytest.approx(forces, abs=4e-11)
    assert sample.contact_radius.values == pytest.approx(radii, abs=7e-11)
    assert result.contact_intervals == pytest.approx(np.array([[0.0, 3.505019696093]]), abs=4e-11)
    assert result.contact_end_time == result.contact_intervals[-1, 1]
    assert result.work == pytest.approx(1.790625017907, abs=2e-11)
    assert result.stored == pytest.approx(0.233964282558, abs=2e-11)
    assert result.dissipated == pytest.approx(1.790625017907 - 0.233964282558, abs=4e-11)
    # The contact turns where the depth does, or later where the material creeps.
    assert result.turning_times[:5] == pytest.approx([1.0, 1.3, 1.6, 2.0, 3.0], abs=1e-10)


def test_a_program_that_loses_contact_and_finds_it_again():
    """Row D2."""
    result = indent(SOLID, TIP, rtol=1e-11, **D2)
    forces = [1.158364205738, 0.211658202454, 1.982448536156, 4.120125626621, 0.506682810243, 0.168258636108,
              1.645754205936, 5.400711141634, 2.671475572478]  # fmt: skip
    sampled = result.sample([1.2, 1.9, 2.2, 2.5, 2.7, 3.4, 3.6, 4.0, 4.1]).force.values
    assert sampled == pytest.approx(forces, abs=6e-11)
    intervals = [[0.0, 1.320544140396], [1.824499921590, 2.763744683366], [3.350181414693, 4.258027894026]]
    assert result.contact_intervals == pytest.approx(np.array(intervals), abs=4e-11)
    assert result.work == pytest.approx(1.752994883462, abs=2e-11)
    assert result.max_force == pytest.approx(5.400711141634, abs=6e-11)
    # Between the contacts there is no force and no radius.
    between = result.sample([1.4, 1.7, 3.0, 4.4])
    assert np.all(between.force.values == 0.0)
    assert np.all(between.contact_radius.values == 0.0)


@pytest.mark.parametrize("start", [-0.5, 0.0])
def test_a_touch_at_a_knot(start):
    """Rows D1 and D2 behind an approach, or a hold on the surface, that ends at a knot."""
    for rows, ends in (
        (D1, [[0.5, 4.005019696093]]),
        (D2, [[0.5, 1.820544140396], [2.324499921590, 3.263744683366], [3.850181414693, 4.758027894026]]),
    ):
        result = indent(SOLID, TIP, time=[0.0, *np.add(rows["time"], 0.5)], depth=[start, *rows["depth"]])
        if start < 0.0:
            assert result.contact_intervals == pytest.approx(np.array(ends), abs=1e-8)
        expected = indent(SOLID, TIP, **rows)
        moments = np.linspace(0.01, 4.1, 50)
        assert result.sample(moments + 0.5).force.values == pytest.approx(
            expected.sample(moments).force.values, abs=2e-8 * expected.max_force
        )


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
def test_errors_follow_the_tolerance(rtol):
    result = indent(SOLID, TIP, rtol=rtol, **D2)
    sampled = result.sample([1.2, 2.2, 3.6, 4.0]).force.values
    expected = np.array([1.158364205738, 1.982448536156, 1.645754205936, 5.400711141634])
    assert np.abs(sampled - expected).max() <= rtol * 5.400711141634


def check_program(series, rng):
    times, depths = program(rng, int(rng.integers(4, 9)))
    result = indent(half_space(series), TIP, depth=depths, time=times)
    begin, end = result.contact_intervals[rng.integers(len(result.contact_intervals))]
    moment = float(rng.uniform(begin, min(end, times[-1])))
    force = float(result.sample([moment]).force[0])
    assert abs(force - followed_force(result, series, moment)) <= 10.0 * result.rtol * result.max_force


def check_random_program(seed):
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 4))
    series = PronySeries(
        float(rng.random() < 0.7), 10.0 ** rng.uniform(-1.0, 1.0, count), 10.0 ** rng.uniform(-1.0, 1.0, count)
    )
    check_program(series, rng)


def check_random_program_with_a_dashpot(seed):
    """Where the body turns back its rate jumps, and the front runs through elements that have just left."""
    rng = np.random.default_rng([seed, 77])
    count, viscosity = int(rng.integers(0, 4)), 10.0 ** rng.uniform(-2.5, 0.5)
    series = PronySeries(
        float(count == 0 or rng.random() < 0.7), 10.0 ** rng.uniform(-1.0, 1.0, count),
        10.0 ** rng.uniform(-1.0, 1.0, count), parallel_viscosity=viscosity,
    )  # fmt: skip
    check_program(series, rng)


@pytest.mark.parametrize("seed", range(4))
def test_random_programs_against_elements_followed_alone(seed):
    check_random_program(seed)


@pytest.mark.parametrize("seed", [3, 7, 44, 70])
def test_random_programs_on_a_dashpot_against_elements_followed_alone(seed):
    """With the force of before the front's run, 44 and 70 are refused."""
    check_random_program_with_a_dashpot(seed)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("seed", [12, 13, 25, 44, 45])
def test_a_liquid_that_left_at_one_moment_has_a_smooth_imprint(seed, rtol):
    """Elements of a liquid that has relaxed have equal loads and leave together; where the front was is rounding."""
    rng = np.random.default_rng([seed, 51])
    count = int(rng.integers(1, 3))
    equilibrium = float(rng.random() < 0.2) * 10.0 ** rng.uniform(-2.0, 0.0)
    series = PronySeries(equilibrium, 10.0 ** rng.uniform(-1.0, 1.0, count), 10.0 ** rng.uniform(-2.0, -0.5, count))
    times, depths = program(rng, int(rng.integers(4, 8)))
    result = indent(half_space(series), TIP, depth=depths, time=times, rtol=rtol)
    begin, end = result.contact_intervals[-1]
    moment = begin + 0.6 * (min(end, times[-1]) - begin)
    force = float(result.sample([moment]).force[0])
    # Errors of the imprint add to those of the step.
    assert abs(force - followed_force(result, series, moment)) <= 2.0 * rtol * result.max_force


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4, 44))
def test_more_random_programs_against_elements_followed_alone(seed):
    check_random_program(seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 120))
def test_more_random_programs_on_a_dashpot_against_elements_followed_alone(seed):
    check_random_program_with_a_dashpot(seed)


@pytest.mark.parametrize(
    ("series", "profile"),
    [
        *((series, profile) for series in (STANDARD, THREE, LIQUID) for profile in (TIP, CONE, PUNCH)),
        *((DAMPED, profile) for profile in (TIP, CONE)),
    ],
)
def test_a_history_may_be_cut_where_the_body_is_free(series, profile):
    """The surface carries all that the uncut history left."""
    material, rtol = half_space(series), 1e-9
    times, depths = np.array(D2["time"]), np.array(D2["depth"]) - 0.1
    whole = indent(material, profile, depth=depths, time=times, rtol=rtol)
    first_end, second_begin = whole.contact_intervals[0, 1], whole.contact_intervals[1, 0]
    for share, wait in ((0.1, 0.0), (0.6, 0.2)):
        cut = first_end + share * (second_begin - first_end)
        on = cut + wait * (second_begin - cut)
        early, late = times < cut, times > on
        first = indent(
            material, profile, time=np.append(times[early], cut), rtol=rtol,
            depth=np.append(depths[early], np.interp(cut, times, depths)),
        )  # fmt: skip
        surface = first.surface(after=on - cut)
        second = indent(
            material, profile, time=np.append(on, times[late]), rtol=rtol, surface=surface,
            depth=np.append(np.interp(on, times, depths), depths[late]),
        )  # fmt: skip
        moments = np.linspace(on, times[-1], 101)
        expected = whole.sample(moments)
        allowed = 10.0 * rtol * whole.max_force
        assert np.abs(second.sample(moments).force.values - expected.force.values).max() <= allowed
        assert second.contact_intervals == pytest.approx(whole.contact_intervals[1:], rel=1e-7)
        assert first.work + second.work == pytest.approx(whole.work, rel=1e-7)
        assert second.stored == pytest.approx(whole.stored, rel=1e-7, abs=1e-9 * whole.work)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("series", [STANDARD, THREE, LIQUID], ids=["one term", "three terms", "liquid"])
def test_a_body_never_stores_more_than_the_work_done_on_it(series, seed):
    """Work and stored energy at the end of ever longer parts of a program: what is dissipated only grows."""
    times, depths = program(np.random.default_rng(seed), 8)
    material, last = half_space(series), 0.0
    for size in range(3, times.size + 1):
        result = indent(material, TIP, depth=depths[:size], time=times[:size])
        assert result.stored >= 0.0
        assert result.dissipated >= last - 1e-8 * result.work
        last = result.dissipated


def test_an_elastic_body_forgets_every_history():
    rng = np.random.default_rng(3)
    for _ in range(10):
        times, depths = program(rng, 9)
        result = indent(half_space(PronySeries(1.5)), TIP, depth=depths, time=times)
        moments = np.linspace(0.0, times[-1], 201)
        hertz = 4.0 / 3.0 * 1.5 * np.maximum(np.interp(moments, times, depths), 0.0) ** 1.5
        assert result.sample(moments).force.values == pytest.approx(hertz, abs=1e-8 * hertz.max())
        assert abs(result.dissipated) <= 1e-7 * result.max_force


# Force and spring


def test_a_force_on_an_elastic_body_that_rises_again():
    rng = np.random.default_rng(5)
    for _ in range(10):
        times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.1, 1.0, 7))])
        forces = np.append(0.0, rng.uniform(0.1, 1.0, 7))
        result = indent(half_space(PronySeries(1.5)), TIP, force=forces, time=times)
        moments = np.linspace(0.0, times[-1], 101)
        hertz = (0.75 * np.interp(moments, times, forces) / 1.5) ** (2.0 / 3.0)
        assert result.sample(moments).indentation_depth.values == pytest.approx(hertz, abs=1e-8 * hertz.max())


def test_a_force_that_rises_again_is_that_under_the_computed_depth():
    """Straight lines through the computed depth miss it by their width squared."""
    forces, times = [0.0, 1.0, 0.4, 0.9, 0.2, 0.7], [0.0, 1.0, 1.5, 2.5, 3.0, 4.0]
    result = indent(SOLID, TIP, force=forces, time=times, rtol=1e-10)
    moments = np.linspace(0.05, 3.95, 79)
    differences = []
    for count in (501, 1001):
        knots = np.union1d(4.0 * np.linspace(0.0, 1.0, count) ** 2, [*times, *result.turning_times])
        depth = np.append(0.0, result.sample(knots[1:]).indentation_depth.values)
        again = indent(SOLID, TIP, depth=depth, time=knots).sample(moments).force.values
        differences.append(np.abs(again - np.interp(moments, times, forces)).max())
    assert differences[1] < 0.4 * differences[0]
    assert differences[1] <= 1e-4


def test_a_spring_moves_the_tip():
    """F = k (z - d), and the depth alone gives the same force."""
    k, times, base = 2.0, np.array(D1["time"]), 2.0 * np.array(D1["depth"])
    result = indent(SOLID, TIP, depth=base, time=times, spring_constant=k, rtol=1e-10)
    assert result.prescribed == "base"
    moments = np.linspace(0.0, times[-1], 401)
    sample = result.sample(moments)
    depth, force = sample.indentation_depth.values, sample.force.values
    assert force == pytest.approx(k * (np.interp(moments, times, base) - depth), abs=1e-9 * result.max_force)
    knots = np.union1d(np.linspace(0.0, times[-1], 2001), [*times, *result.turning_times])
    alone = indent(SOLID, TIP, depth=result.sample(knots).indentation_depth.values, time=knots)
    assert alone.sample(moments).force.values == pytest.approx(force, abs=2e-4 * result.max_force)
    # A hard spring is a prescribed depth.
    hard = indent(SOLID, TIP, spring_constant=1e7, **D1).sample(moments).force.values
    stiff = indent(SOLID, TIP, **D1).sample(moments).force.values
    assert hard == pytest.approx(stiff, abs=1e-5)


@pytest.mark.parametrize("tip", [TIP, rs.Sphere(2.0)], ids=lambda tip: type(tip).__name__)
def test_a_spring_on_a_dashpot_returns_to_its_imprint(tip):
    """F = k (z - d) in and out of contact, three times, with the rates of the start and of the end of a contact."""
    rng, k = np.random.default_rng(61), 2.0
    for _ in range(5):
        times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.3, 1.0, 6))])
        base = np.column_stack([rng.uniform(-1.0, -0.5, 4), rng.uniform(0.5, 1.0, 4)]).ravel()[1:]
        base = np.append(0.0, base[:6])
        result = indent(half_space(DAMPED), tip, depth=base, time=times, spring_constant=k)
        assert len(result.contact_intervals) == 3
        moments = np.linspace(0.0, times[-1], 201)
        sample = result.sample(moments)
        spring = k * (np.interp(moments, times, base) - sample.indentation_depth.values)
        assert sample.force.values == pytest.approx(spring, abs=1e-8 * result.max_force)


@pytest.mark.parametrize("tip", [Cone(1.1), rs.Pyramid(1.2)], ids=lambda tip: type(tip).__name__)
@pytest.mark.parametrize("seed", range(3))
def test_a_cone_on_a_spring_and_a_dashpot_ends_and_begins_its_contacts(seed, tip):
    """Equal elements under the computed force have the same depth, in the first order of their number.

    The force of the spring is a difference of few digits there.
    """
    rng = np.random.default_rng([seed, 71])
    terms = rng.integers(1, 4)
    series = PronySeries(
        float(seed > 0), 10.0 ** rng.uniform(-1.0, 1.0, terms), 10.0 ** rng.uniform(-1.0, 1.0, terms),
        parallel_viscosity=rng.uniform(0.02, 0.2),
    )  # fmt: skip
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.2, 1.0, 5))])
    base = np.array([0.0, 0.9, -0.6, 1.0, -0.4, 0.8]) * rng.uniform(0.5, 1.0, 6)
    problem = {"depth": base, "time": times, "spring_constant": rng.uniform(0.5, 20.0)}
    result = indent(half_space(series), tip, rtol=1e-10, **problem)
    breaks = np.union1d(np.linspace(0.0, times[-1], 1601), [*times, *result.contact_intervals[:, 0]])
    sample = result.sample(breaks[breaks <= times[-1]])
    depth, force = sample.indentation_depth.values, sample.force.values
    alone = pressed_elements(
        series, lambda y: tip.stiffness_radius(y * y), sample.time.values, force, math.sqrt(1.02 * depth.max()), 1600
    )
    pressed = force > 1e-3 * force.max()
    assert alone[pressed] == pytest.approx(depth[pressed], abs=6e-3 * depth.max())
    loose = indent(half_space(series), tip, rtol=1e-8, **problem).sample(sample.time)
    assert loose.force.values == pytest.approx(force, abs=1e-8 * force.max())


@pytest.mark.parametrize("rtol", [1e-6, 5e-7])
def test_a_contact_on_a_dashpot_turns_at_a_kink(rtol):
    """A solution at a hundredth of rtol; one whose front stood at the kink was wrong by a hundredth of the force."""
    series = PronySeries(1.0, [0.34, 0.38], [0.157, 0.807], parallel_viscosity=0.226)
    times = [0.0, 0.255, 0.751, 1.59, 1.648, 2.442, 3.221, 3.673, 3.905, 4.192]
    base = [0.0, 0.665, 0.154, -0.231, 0.03, 0.03, 0.757, 0.796, 0.468, 0.739]
    problem = {"depth": base, "time": times, "spring_constant": 10.0}
    moments = np.linspace(0.0, times[-1], 401)
    result, strict = (
        indent(half_space(series), rs.Pyramid(1.2), rtol=accuracy, **problem).sample(moments).force.values
        for accuracy in (rtol, 1e-2 * rtol)
    )
    assert result == pytest.approx(strict, abs=rtol * strict.max())


@pytest.mark.parametrize("k", [1e-5, 1e-3])
def test_depths_on_a_soft_spring_have_the_accuracy_of_depths(k):
    """The tip moves much less than the base of the spring."""
    problem = {"depth": [0.0, 1.0, 0.2, 1.0], "time": [0.0, 0.5, 0.8, 1.5], "spring_constant": k}
    moments = np.linspace(0.0, 1.5, 101)
    depth, strict = (
        indent(half_space(DAMPED), TIP, rtol=rtol, **problem).sample(moments).indentation_depth.values
        for rtol in (1e-6, 1e-9)
    )
    assert depth == pytest.approx(strict, abs=1e-6 * strict.max())


def test_a_step_to_the_end_of_a_contact_is_not_the_best_where_it_was_driven_back():
    """Parabola on a spring; a longer step passes the end of the first contact, and errors follow rtol."""
    moduli = [2626152.9435, 154994.6394, 9592569.4463, 927617.1445, 2472281.5175, 818926.4703, 1182155.0849, 3994957.0883,
              368230.0868, 4919317.8516, 7788838.5509, 716084.7117, 1084105.6336, 8586116.3072, 1994102.2657]  # fmt: skip
    times = [0.001641728, 0.002709574, 0.003288999, 0.005358604, 0.008764714, 0.016943326, 0.083169458, 0.161277023,
             0.22824163, 0.471323536, 0.736283389, 1.348407991, 1.662858958, 4.176640423, 5.871057348]  # fmt: skip
    knots = [0.0, 0.73369965, 1.56508317, 1.69392122, 2.46950956, 3.4558378, 3.95394431, 4.37500663]
    base = [0.0, 79.6525394, 43.0017304, -2.42351702, -5.57553785, -5.57553785, 3.02188472, 43.7892861]
    moments, body = np.linspace(0.0, knots[-1], 501), half_space(PronySeries(1e6, moduli, times))
    force, strict = (
        indent(body, rs.Parabola(1e-2), time=knots, depth=1e-6 * np.array(base), spring_constant=1e3, rtol=rtol)
        .sample(moments).force.values for rtol in (1e-4, 1e-8)
    )  # fmt: skip
    assert force == pytest.approx(strict, abs=1e-4 * strict.max())


@pytest.mark.parametrize("equilibrium", [0.0, 1e6])
@pytest.mark.parametrize("terms", [1, 3])
@pytest.mark.parametrize("seed", [2, 7, 23, 31])
def test_forces_of_a_spring_follow_the_tolerance(seed, terms, equilibrium):
    """A contact ends and another begins in its imprint; holds and steep returns."""
    rng = np.random.default_rng([37, seed])
    tip = [Parabola(1e-2), Cone(0.5), rs.Pyramid(1.2)][seed % 3]
    moduli, times = 1e6 * 10.0 ** rng.uniform(-1.0, 0.3, terms), np.sort(10.0 ** rng.uniform(-2.5, 0.0, terms))
    knots = np.cumsum(np.append(0.0, rng.uniform(0.1, 0.5, 7)))
    base = 1e-6 * np.array([0.0, 75.0, 75.0, 25.0, 25.0, 90.0, 10.0, 60.0])
    body, moments = half_space(PronySeries(equilibrium, moduli, times)), np.linspace(0.01, knots[-1], 200)
    strict, *forces = (
        indent(body, tip, time=knots, depth=base, spring_constant=1e3, rtol=rtol).sample(moments).force.values
        for rtol in (1e-8, 1e-6, 1e-7)
    )
    for force, rtol in zip(forces, (1e-6, 1e-7), strict=True):
        assert force == pytest.approx(strict, abs=3.0 * rtol * strict.max())


def test_a_refusal_names_an_rtol_that_does(monkeypatch):
    """Steps with a tolerance below 5e-10 are not solved here."""
    solve = panels.run

    def run(problem, *rest):
        return NOT_SOLVED if problem.scales.tolerance < 5e-10 else solve(problem, *rest)

    monkeypatch.setattr(panels, "run", run)
    error = in_one_line(lambda: indent(SOLID, TIP, rtol=1e-9, **D1))
    assert "could not be solved there at rtol = 1e-09; it can be at rtol = 1e-08" in str(error)


def test_smaller_steps_are_tried_before_a_refusal(monkeypatch):
    """The first tolerance is not solved here."""
    expected, solve = float(indent(SOLID, TIP, **D1).sample([2.0]).force[0]), panels.run
    tolerances = []

    def run(problem, *rest):
        tolerances.append(problem.scales.tolerance)
        return NOT_SOLVED if len(tolerances) == 1 else solve(problem, *rest)

    monkeypatch.setattr(panels, "run", run)
    assert float(indent(SOLID, TIP, **D1).sample([2.0]).force[0]) == pytest.approx(expected, rel=1e-8)
    assert tolerances[1] < tolerances[0]


@pytest.mark.parametrize("seed", [0, 86, 95, 163])
def test_a_flat_face_on_a_spring_and_a_dashpot_turns(seed):
    """Of a flat face with steep sides q = F/(2 a) is linear in d: eta d' + Einf d + E h + k d/(2 a) = k z/(2 a)."""
    rng = np.random.default_rng([seed, 63])
    radius, k, modulus = 0.5, 10.0 ** rng.uniform(-3.5, -1.0), 10.0 ** rng.uniform(-0.5, 1.0)
    tau, viscosity = rng.uniform(0.2, 2.0), 10.0 ** rng.uniform(-4.0, -2.0)
    series = PronySeries(1.0, [modulus], [tau], parallel_viscosity=viscosity)
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.3, 1.0, 4))])
    # Without a loss of contact.
    base = 1e-3 * np.array([0.0, 1.0, rng.uniform(0.85, 0.95), rng.uniform(1.0, 1.1), rng.uniform(0.9, 0.95)])
    tip = TruncatedCone(radius, 1e-5)
    result = indent(half_space(series), tip, depth=base, time=times, spring_constant=k)
    # Linear in (d, h): exponentials of a matrix with the slopes of the base as a further state.
    stiffness, expected, state = 0.5 * k / radius, [], np.zeros(2)
    for n in range(4):
        pace = (base[n + 1] - base[n]) / (times[n + 1] - times[n])
        change = np.zeros((4, 4))
        change[0] = np.array([-1.0 - stiffness, -modulus, stiffness, 0.0]) / viscosity
        change[1] = change[0] - np.array([0.0, 1.0 / tau, 0.0, 0.0])
        change[2, 3] = 1.0
        for moment in np.linspace(times[n], times[n + 1], 6)[1:]:
            after = expm(change * (moment - times[n])) @ np.append(state, [base[n], pace])
            expected.append((moment, after[0]))
        state = after[:2]
    moments, depths = np.array(expected).T
    computed = result.sample(moments).indentation_depth.values
    assert computed == pytest.approx(depths, abs=1e-8 * base.max())


# Surface


def test_the_surface_around_an_elastic_contact_is_that_of_hertz():
    radius, depth = 2.0, 0.3
    result = indent(Material(1.0, 2.0), Parabola(radius), depth=rs.ramp(depth, 1.0))
    a = math.sqrt(radius * depth)
    inside, outside = np.linspace(0.0, a, 9), a * np.geomspace(1.0 + 1e-9, 50.0, 12)
    assert result.imprint(1.0, inside) == pytest.approx(depth - inside**2 / (2.0 * radius), abs=1e-8 * depth)
    # Johnson, Contact Mechanics (1985), eq. 3.42a.
    expected = (2.0 * a**2 - outside**2) * np.arcsin(a / outside) + a * np.sqrt(outside**2 - a**2)
    assert result.imprint(1.0, outside) == pytest.approx(expected / (math.pi * radius), abs=1e-8 * depth)


@pytest.mark.parametrize("exponent", [1.2, 1.5, 2.7, 3.0, 6.0, 10.0])
def test_the_surface_around_a_tip_of_any_power(exponent):
    """In contact the surface has the shape of the tip; beside it `w = 2/pi int (d - g) dx/sqrt(r^2 - x^2)`."""
    tip = PowerLaw(exponent, 0.3)
    result = indent(SOLID, tip, depth=rs.ramp(0.4, 1.0))
    a = float(result.contact_radius[-1])
    inside, outside = a * np.array([0.0, 1e-3, 0.1, 0.5, 0.99]), a * np.array([1.001, 1.1, 3.0])
    assert result.imprint(1.0, inside) == pytest.approx(0.4 - tip.shape(inside), abs=1e-9)
    expected = [
        2.0 / math.pi * quad(lambda angle, r=r: 0.4 - tip.transform(r * math.sin(angle)), 0.0, math.asin(a / r))[0]
        for r in outside
    ]
    assert result.imprint(1.0, outside) == pytest.approx(np.array(expected), abs=1e-9)


@pytest.mark.parametrize("tip", [FlatEndedParabola(1.0, 1e-3), PowerLaw(10.0, 0.3)], ids=["worn", "steep"])
def test_surface_and_energy_of_a_nearly_elastic_body(tip):
    """The work is stored; radii rise like a root of the depth behind a small face, and a tenth power at a steep tip."""
    result = indent(
        Material(PronySeries(1.0, [1e-12], [1.0]), math.inf), tip, depth=[0.0, 0.01, 0.005], time=[0, 1, 2]
    )
    assert result.stored == pytest.approx(result.work, rel=1e-9)
    a = float(result.contact_radius[-1])
    radii = a * np.array([1e-3, 0.01, 0.3, 0.9])
    assert result.imprint(2.0, radii) == pytest.approx(0.005 - tip.shape(radii), abs=1e-10)


def test_a_contact_is_largest_behind_a_step_of_the_depth():
    """A step onto virgin surface, from which the tip retracts: a = sqrt(R d) at the step."""
    result = indent(SOLID, TIP, depth=[0.0, 0.5, -0.2, 0.2, 1.0, 0.8], time=[0.0, 1.0, 2.0, 3.0, 3.0, 5.0])
    assert result.contact_intervals.shape == (2, 2)
    assert result.max_contact_radius == pytest.approx(1.0, rel=1e-12)
    assert result.turning_time == 3.0
    assert result.max_indentation_depth == pytest.approx(1.0, rel=1e-12)


def test_a_step_above_the_surface_is_not_felt_by_a_dashpot():
    damped = half_space(DAMPED)
    time, depth = [0.0, 1.0, 2.0, 2.0, 3.0, 4.0], [-1.0, 1.0, -0.3, -0.8, 1.0, 0.5]
    step = indent(damped, TIP, time=time, depth=depth)
    steep = indent(damped, TIP, time=[*time[:3], 2.0 + 1e-9, *time[4:]], depth=depth)
    moments = np.linspace(0.0, 4.0, 81)
    assert step.sample(moments).force.values == pytest.approx(steep.sample(moments).force.values, abs=1e-7)
    assert step.stored == pytest.approx(steep.stored, rel=1e-7)
    with pytest.raises(InputError, match="must not jump, as at time = 2 s"):
        indent(damped, TIP, time=time, depth=[-1.0, 1.0, 0.3, -0.8, 1.0, 0.5])


def test_the_surface_has_the_shape_of_the_tip_at_all_radii():
    """Also at radii next to the ends of steps, where the surface beyond a radius must not be taken for all of it."""
    result = indent(SOLID, TIP, **D1)
    a = float(result.sample([2.8]).contact_radius[0])
    radii = np.linspace(0.0, a, 400)
    depth = float(result.sample([2.8]).indentation_depth[0])
    assert result.imprint(2.8, radii) == pytest.approx(depth - TIP.shape(radii), abs=1e-8)


def test_an_imprint_decays_with_the_retardation_time():
    """E*(t) = 1 + 4 exp(-t) has one retardation time, 5."""
    result = indent(
        SOLID, TIP, rtol=1e-10, depth=[0.0, 1.0, 0.7, 0.9, -0.5, -0.5], time=[0.0, 1.0, 1.3, 1.6, 2.5, 8.0]
    )
    end = result.contact_end_time
    assert result.imprint(end, 0.0) == pytest.approx(result.residual_indentation_depth, rel=1e-8)
    radii = np.array([0.0, 0.3, 0.8, 1.5, 4.0])
    for time in (3.0, 6.5, 8.0):
        decayed = result.imprint(2.6, radii) * math.exp(-(time - 2.6) / 5.0)
        assert result.imprint(time, radii) == pytest.approx(decayed, rel=1e-7)
    surface = result.surface(after=2.0)
    assert surface.imprint(radii) == pytest.approx(result.imprint(8.0, radii) * math.exp(-2.0 / 5.0), rel=1e-7)
    assert surface.depth == pytest.approx(surface.imprint(0.0), rel=1e-9)
    assert surface.time == 2.0
    # Elastic energy of a displacement that decays as a whole.
    assert surface.stored == pytest.approx(result.stored * math.exp(-2.0 * 2.0 / 5.0), rel=1e-7)


def test_a_liquid_keeps_its_imprint():
    maxwell = half_space(PronySeries(0.0, [4.0], [1.0]))
    result = indent(maxwell, TIP, depth=[0.0, 1.0, 0.2, 0.6, -0.5, -0.5], time=[0.0, 1.0, 1.4, 2.0, 3.0, 9.0])
    radii = np.array([0.0, 0.4, 1.2])
    assert result.imprint(9.0, radii) == pytest.approx(result.imprint(3.0, radii), rel=1e-8)
    assert result.surface(after=100.0).depth == pytest.approx(float(result.imprint(9.0, 0.0)), rel=1e-8)


# Errors


def refused(field, call, value=None):
    with pytest.raises(InputError) as caught:
        call()
    assert caught.value.field == field
    assert "\n" not in str(caught.value)
    if value is not None:
        assert caught.value.value == value


def test_bad_springs_are_refused():
    for bad in (0.0, -1.0, math.nan):
        refused("spring_constant", lambda bad=bad: indent(SOLID, TIP, spring_constant=bad, **D1))
    pulled = {"force": [0.0, 1.0], "time": [0.0, 1.0]}
    refused("force", lambda: indent(SOLID, TIP, spring_constant=1.0, **pulled))


def test_surfaces_that_do_not_fit_are_refused():
    first = indent(SOLID, TIP, **D1)
    surface = first.surface()
    assert surface.depth > 0.0
    refused("surface", lambda: indent(half_space(THREE), TIP, surface=surface, **D1))
    refused("surface", lambda: indent(SOLID, Parabola(1.1), surface=surface, **D1))
    refused("surface", lambda: indent(SOLID, TIP, counter_material=SOLID, surface=surface, **D1))
    with pytest.raises(TypeError, match="surface"):
        indent(SOLID, TIP, surface=first, **D1)
    # A history begins without contact, and reaches the surface.
    deep = {"depth": [surface.depth + 0.1, 1.0], "time": [0.0, 1.0]}
    refused("depth", lambda: indent(SOLID, TIP, surface=surface, **deep), surface.depth + 0.1)
    shallow = {"depth": [0.0, 0.5 * surface.depth], "time": [0.0, 1.0]}
    refused("depth", lambda: indent(SOLID, TIP, surface=surface, **shallow))
    refused("after", lambda: first.surface(after=-1.0), -1.0)


def test_a_contact_has_no_free_surface():
    pressed = indent(SOLID, TIP, depth=rs.ramp(1.0, 1.0))
    refused("history", pressed.surface)
    refused("time", lambda: pressed.imprint(2.0, 0.0), 2.0)
    refused("radius", lambda: pressed.imprint(1.0, -0.1), -0.1)
    pyramid = indent(SOLID, rs.Pyramid(1.2, 4), depth=rs.ramp(1.0, 1.0))
    refused("profile", lambda: pyramid.imprint(1.0, 0.1))


@pytest.mark.parametrize("name", ["force", "depth"])
def test_the_work_of_a_step_does_not_depend_on_the_start_of_the_time(name):
    rng = np.random.default_rng(5)
    for start in rng.choice([0.1, 0.5, 1.0 / 3.0, 1e3, -7.3], 40):
        times, values = np.array([0.0, 0.0, rng.uniform(0.1, 1.0)]), [0.0, 0.5, rng.uniform(0.1, 0.6)]
        expected = indent(SOLID, TIP, time=times, **{name: values}).work
        # The duration has the rounding of the times.
        assert indent(SOLID, TIP, time=start + times, **{name: values}).work == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("profile", [FlatEndedParabola, TruncatedCone])
def test_a_force_reaches_the_end_of_its_table(profile):
    """The force on an elastic half-space is 2 E* Pi(d), which the profile has in closed form."""
    rng = np.random.default_rng(3)
    for size in 10.0 ** rng.uniform(-6.0, 0.0, 60):
        tip = profile(size, 0.2 * size) if profile is FlatEndedParabola else profile(0.2 * size, 1.2)
        peak = rng.uniform(0.1, 1.0) * size**2
        result = indent(half_space(PronySeries(1.0)), tip, time=[0.0, 0.3, 1.0], force=[0.0, peak, 0.2 * peak])
        depth = float(result.sample([0.3]).indentation_depth[0])
        assert 2.0 * tip.force_integral_at_depth(depth) == pytest.approx(peak, rel=1e-8)


def test_a_history_of_too_many_steps_is_refused(monkeypatch):
    """Each of its six lines takes a step at least."""
    monkeypatch.setattr(panels, "_MOST_STEPS", 5)
    monkeypatch.setattr(panels, "_MOST_STEPS_PER_KNOT", 0)
    error = in_one_line(lambda: indent(SOLID, TIP, **D1))
    assert error.field == "history"
    assert "needs over 5 steps" in str(error)


@pytest.mark.plain
def test_a_depth_that_jumps_down_in_a_contact_that_shrinks_and_then_grows():
    """Elements followed alone along a line so steep that it changes the force by less than the tolerance."""
    series = PronySeries(1.0, [4.0, 4.0], [1.0, 0.1])
    times, depths, brief = [0.0, 0.8, 1.5, 1.5, 2.0], [0.0, 0.4, 0.26, 0.23, 0.42], 1e-8
    result = indent(half_space(series), TIP, time=times, depth=depths)
    steep = indent(half_space(series), TIP, time=[0.0, 0.8, 1.5, 1.5 + brief, 2.0], depth=depths)
    expected = followed_force(steep, series, 1.55)
    assert float(result.sample([1.55]).force[0]) == pytest.approx(expected, abs=1e-6 * result.max_force)


def test_a_way_that_ends_elsewhere():
    """A step to the end of the contact, where a longer step had expected it, ends while the body still goes deeper.

    Taken as the end, the contact would end with a radius; the stricter solution is at other steps.
    """
    series = PronySeries(
        0.0,
        [8090058.593, 6175668.955, 3006678.010, 132269.895, 738450.407, 6784917.446, 2852812.696, 348290.189, 648197.728,
         296938.696, 6561707.310],
        [0.10011, 0.12049, 0.13945, 0.14485, 0.45831, 0.51226, 1.1549, 2.5778, 4.9036, 8.3495, 10.002],
    )  # fmt: skip
    time = [0.0, 0.0874207, 0.7632063, 1.2082355, 1.6308208, 2.4321606, 3.1858906, 3.2819367, 4.0071564]
    depth = 1e-6 * np.array([-42.794, 66.479, 64.658, 64.658, 64.658, 39.612, 91.167, 93.519, 12.734])
    material, moments = Material(series.scaled(0.25), math.inf), np.linspace(0.05, 4.0, 200)
    strict, force = (
        indent(material, Parabola(1e-2), depth=depth, time=time, rtol=rtol).sample(moments).force.values
        for rtol in (1e-10, 1e-8)
    )
    assert force == pytest.approx(strict, abs=1e-8 * strict.max())
