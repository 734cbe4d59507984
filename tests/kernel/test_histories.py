"""Contacts over any history: 12-digit rows, single elements followed alone, and the single cycle of `rs.indent`."""

import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.polynomial import chebyshev, legendre

import restitution as rs
from element_follower import Follower
from restitution import PronySeries
from restitution.indentation.solid import solid_of
from restitution.kernel.driver import (
    DEPTH,
    DONE,
    ENDS,
    FOLLOWING,
    FORCE,
    FREE_PANELS,
    NO_ROOM,
    RATE,
    RECORDS,
    TIME,
    TOUCHES,
    WORK,
    Driver,
    Problem,
    Room,
    Scales,
    room,
)
from restitution.kernel.panels import larger, leave, scheme, touch
from restitution.kernel.path import Path, power_path
from restitution.kernel.program import run

STANDARD = PronySeries(1.0, [4.0], [1.0])
PARABOLA = power_path(1.0)
MOST_STEPS = 20000
# Share of a tolerance for a step, as errors of steps add up.
STEP_SHARE = 0.1
# Rows of the design page on cycles, computed by panels of two orders and by a follower of single elements.
D1 = ([0.0, 1.0, 1.3, 1.6, 2.0, 3.0, 4.2], [0.0, 1.0, 0.7, 0.9, 0.6, 1.2, 0.0])
D1_TIMES = [1.3, 1.5, 1.8, 2.0, 2.2, 2.6, 3.0, 3.4]
D1_FORCES = [
    1.662349638581, 2.548321650863, 1.429672940494, 0.361749342104, 1.164867465837, 2.912040537415, 4.513766313114,
    0.401520510647,
]  # fmt: skip
D1_RADII = [
    0.7832003593, 0.9004289789, 0.8120874077, 0.5478348904, 0.7830276320, 0.9793145298, 1.0954451150, 0.6346392368,
]  # fmt: skip
D2 = ([0.0, 1.0, 1.5, 2.5, 3.0, 4.0, 4.5], [0.0, 1.0, 0.0, 1.0, 0.0, 1.2, 0.0])
D2_TIMES = [1.2, 1.9, 2.2, 2.5, 2.7, 3.4, 3.6, 4.0, 4.1]
D2_FORCES = [
    1.158364205738, 0.211658202454, 1.982448536156, 4.120125626621, 0.506682810243, 0.168258636108, 1.645754205936,
    5.400711141634, 2.671475572478,
]  # fmt: skip
D2_BREAKS = [1.320544140396, 1.824499921590, 2.763744683366, 3.350181414693, 4.258027894026]


def by_depth(times: Any, depths: Any) -> Driver:
    """Straight lines of the depth."""
    t, d = np.array(times, float), np.array(depths, float)
    lines = np.column_stack([d[:-1], np.diff(d)])
    return Driver(True, t, lines, np.zeros(t.size, dtype=bool), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Run(NamedTuple):
    """A program that has run."""

    outcome: int
    room: Room

    def sample(self, times: Any, column: int) -> Any:
        """Depth (0), rate (1), half of the force (2) or y (3) at times."""
        records, size = self.room.records, self.room.places[RECORDS]
        values = []
        for t in times:
            n = np.searchsorted(records.start[:size], t, side="right") - 1
            passed = min(max((t - records.start[n]) / records.length[n], 0.0), 1.0)
            kind = records.kind[n]
            z = 1.0 - (1.0 - passed) ** (-1.0 / kind) if kind < 0 else passed ** (1.0 / kind)
            values.append(chebyshev.chebval(2.0 * z - 1.0, records.columns[n, column]))
        return np.array(values)

    def breaks(self) -> Any:
        """Times at which the contact ends or begins, after the first touch."""
        records, size = self.room.records, self.room.places[RECORDS]
        at = np.isin(records.event[:size], (ENDS, TOUCHES))
        return (records.start + records.length)[:size][at]


def run_depth(
    series: PronySeries, points: Any, tolerance: float, scale: float, path: Path = PARABOLA, power: int = 2,
    panels: int = 2000,
) -> Run:  # fmt: skip
    deepest = max(points[1])
    scales = Scales(deepest, scale, scale, tolerance)
    solid = solid_of(series)
    state = room(solid, panels, MOST_STEPS)
    problem = Problem(solid, path, by_depth(*points), scheme(), scales, power)
    return Run(run(problem, state, np.array([0.0, 0.0, math.inf]), MOST_STEPS), state)


@pytest.mark.parametrize(("first", "second"), [(math.nan, 1.0), (1.0, math.nan), (math.nan, math.nan)])
def test_an_error_that_is_not_a_number_remains_the_largest(first, second):
    """No comparison with NaN is true: a step without numbers would be accepted."""
    compare = getattr(larger, "py_func", larger)
    assert math.isnan(compare(first, second))
    assert compare(2.0, 1.0) == compare(1.0, 2.0) == 2.0


def test_a_force_that_rises_and_falls_to_zero():
    """An elastic body, against `rs.indent`; a few steps, as the depth is smooth over z up to the end."""
    series = PronySeries(1.0)
    times, force = np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0, 0.0])
    expected = rs.indent(
        rs.Material(series.scaled(0.25), math.inf), rs.Parabola(1.0), force=2.0 * force, time=times, rtol=1e-11
    )
    deepest = expected.max_indentation_depth
    lines = np.column_stack([force[:-1], np.diff(force)])
    driver = Driver(False, times, lines, np.zeros(3, dtype=bool), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    solid = solid_of(series)
    state = room(solid, 500, MOST_STEPS)
    problem = Problem(solid, PARABOLA, driver, scheme(), Scales(deepest, 1.0, 1.0 / math.sqrt(deepest), 1e-9), 3)
    assert run(problem, state, np.array([0.0, 0.0, math.inf]), MOST_STEPS) == DONE
    moments = np.linspace(0.011, 1.999, 41)
    depths = Run(DONE, state).sample(moments, 0)
    assert np.abs(depths - expected.sample(moments).indentation_depth.values).max() <= 1e-9 * deepest
    assert state.places[RECORDS] <= 30


@pytest.mark.parametrize("viscosity", [0.0, 0.3], ids=["none", "dashpot"])
@pytest.mark.parametrize("equilibrium", [0.0, 2.0], ids=["liquid", "solid"])
def test_an_element_that_leaves_and_touches_at_once_keeps_its_loads(equilibrium, viscosity):
    """There and back is the identity for loads q = Einf u + sum l_k = 0, from partial fractions of E*(p)."""
    solid = solid_of(PronySeries(equilibrium, [1.0, 4.0, 0.5], [0.01, 1.0, 300.0], parallel_viscosity=viscosity))
    loads = np.array([0.3, -0.7, 0.2])
    displacement = 0.4
    if viscosity == 0.0:
        displacement = 0.4 if equilibrium == 0.0 else -loads.sum() / equilibrium
        loads -= loads.sum() / 3.0 if equilibrium == 0.0 else 0.0
    parts, again = np.empty(solid.recoveries.size), np.empty(3)
    # These functions of the kernel have no entry from Python but their source.
    getattr(leave, "py_func", leave)(solid, displacement, loads, parts)
    getattr(touch, "py_func", touch)(solid, parts, again)
    assert parts.sum() == pytest.approx(displacement, rel=1e-12)
    assert again == pytest.approx(loads, abs=1e-13)


@pytest.mark.plain
def test_a_program_that_grows_again_before_the_end():
    result = run_depth(STANDARD, D1, 1e-11, 2.0)
    assert result.outcome == DONE
    assert 2.0 * result.sample(D1_TIMES, 2) == pytest.approx(D1_FORCES, abs=1e-11)
    assert result.sample(D1_TIMES, 3) == pytest.approx(D1_RADII, abs=6e-11)
    assert 2.0 * result.room.state[WORK] == pytest.approx(1.790625017907, abs=2e-12)
    assert result.breaks() == pytest.approx([3.505019696093], abs=1e-12)


@pytest.mark.plain
def test_a_program_that_loses_contact_and_finds_it_again():
    result = run_depth(STANDARD, D2, 1e-11, 2.0)
    assert result.outcome == DONE
    assert 2.0 * result.sample(D2_TIMES, 2) == pytest.approx(D2_FORCES, abs=2e-11)
    assert 2.0 * result.room.state[WORK] == pytest.approx(1.752994883462, abs=2e-12)
    assert result.breaks() == pytest.approx(D2_BREAKS, abs=2e-12)


@pytest.mark.plain
@pytest.mark.parametrize("taken", [2, 4])
def test_a_program_ends_where_the_panels_in_contact_and_free_ones_leave_no_room(taken):
    """A step may jump over twenty panels, and each of these jumps may add one."""
    result = run_depth(STANDARD, D1, 1e-6, 2.0, panels=20 + taken)
    places = result.room.places
    assert result.outcome == NO_ROOM
    assert places[FREE_PANELS] > 0
    assert places[FOLLOWING] + places[FREE_PANELS] == taken


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-10])
def test_errors_follow_the_tolerance(tolerance):
    result = run_depth(STANDARD, D2, tolerance, 2.0)
    error = np.abs(2.0 * result.sample(D2_TIMES, 2) - D2_FORCES).max() / max(D2_FORCES)
    assert error <= tolerance


def test_four_impacts_on_one_spot():
    """Row I1 of the same page: each impact with v0 = 1 at the surface as it then is, half a unit of time apart."""
    solid, time = solid_of(STANDARD), 0.0
    state = room(solid, 500, MOST_STEPS)
    expected = [
        (0.628798624830, 1.49786438792, 0.249903891283),
        (0.69607026067, 1.3461228716, 0.38805568029),
        (0.73383345137, 1.2882875774, 0.47508028710),
        (0.75816696328, 1.2626413373, 0.53355907131),
    ]
    for e, duration, depth in expected:
        # F = 2 int q da: half of the mass.
        driver = Driver(
            False,
            np.array([time, time + 20.0]),
            np.zeros((1, 2)),
            np.zeros(2, dtype=bool),
            0.5,
            0.0,
            0.0,
            0.0,
            0.0,
            0.0,
        )
        problem = Problem(solid, PARABOLA, driver, scheme(), Scales(1.0, 1.2, 2.0, 1e-10), 2)
        first = int(state.places[RECORDS])
        state.state[TIME], state.state[RATE] = time, 1.0
        assert run(problem, state, np.array([1.0, 0.0, math.inf]), MOST_STEPS) == DONE
        records = state.records
        last = first + int(np.argmax(records.event[first : state.places[RECORDS]] == ENDS))
        end = float(records.start[last] + records.length[last])
        assert -chebyshev.chebval(1.0, records.columns[last, 1]) == pytest.approx(e, abs=2e-10)
        assert end - time == pytest.approx(duration, abs=2e-10)
        assert chebyshev.chebval(1.0, records.columns[last, 0]) == pytest.approx(depth, abs=2e-10)
        state.places[RECORDS] = last + 1
        time = end + 0.5


def test_an_oscillation_about_a_hold():
    """Row O1 of the same page: the sixth of six periods, whose rim leaves the contact in each."""
    solid, tolerance = solid_of(STANDARD), 1e-10
    state = room(solid, 500, MOST_STEPS)
    period, hold = 2.0 * math.pi, 41.0
    wave = Driver(
        True, np.array([hold, hold + 6.0 * period]), np.array([[1.0]]), np.zeros(2, dtype=bool), 0.0, 0.0, 0.0, 0.1,
        1.0, -hold - 0.5 * math.pi,
    )  # fmt: skip
    for driver in (by_depth([0.0, 1.0, hold], [0.0, 1.0, 1.0]), wave):
        problem = Problem(solid, PARABOLA, driver, scheme(), Scales(1.1, 0.7, 2.0, tolerance), 2)
        assert run(problem, state, np.array([0.0, 0.0, math.inf]), MOST_STEPS) == DONE
    times = hold + 5.0 * period + period * np.arange(256) / 256
    force = 2.0 * Run(DONE, state).sample(times, 2)
    waves = np.sin(times - hold), np.cos(times - hold)
    assert force.mean() == pytest.approx(1.34301000185, abs=2e-10)
    assert 2.0 * (force * waves[0]).mean() == pytest.approx(0.57746212548, abs=2e-10)
    assert 2.0 * (force * waves[1]).mean() == pytest.approx(0.37074589525, abs=2e-10)


@pytest.mark.slow
def test_tapping_becomes_periodic():
    """Row T1 of the same page: m = k = 1, Q = 10, drive cos(t)/10, distance 0.8; the transient leaves exp(-40 pi/Q)."""
    solid, period = solid_of(STANDARD), 2.0 * math.pi
    state = room(solid, 1000, 60000)
    state.state[DEPTH] = -1.7
    # m d'' + c d' + k d = -k D - drive - F, in half units of force.
    driver = Driver(
        False, np.array([0.0, 40.0 * period]), np.array([[-0.4]]), np.zeros(2, dtype=bool), 0.5, 0.05, 0.5, -0.05,
        1.0, 0.0,
    )  # fmt: skip
    problem = Problem(solid, PARABOLA, driver, scheme(), Scales(0.15, 0.1, 1.0, 1e-8), 2)
    assert run(problem, state, np.array([0.0, 0.0, math.inf]), 60000) == DONE
    records, places, weights = state.records, *legendre.leggauss(24)
    harmonic = 0j
    for n in range(state.places[RECORDS]):
        start, stop = max(records.start[n], 39.0 * period), records.start[n] + records.length[n]
        if stop <= start:
            continue
        times = 0.5 * (start + stop) + 0.5 * (stop - start) * places
        z = -(Run(DONE, state).sample(times, 0) + 0.8)
        harmonic += 0.5 * (stop - start) * weights @ (z * np.exp(-1j * times)) / math.pi
    assert abs(harmonic) == pytest.approx(0.925092312856, abs=1e-5)
    assert math.degrees(np.angle(harmonic)) == pytest.approx(-70.32667892693, abs=1e-3)


def followed_force(result: Run, follower: Follower, time: float) -> float:
    """Half of the force by Gauss quadrature over the panels of the contact, with loads of elements followed alone."""
    places, weights = legendre.leggauss(12)
    total = 0.0
    panels = result.room.following
    for p in range(result.room.places[FOLLOWING]):
        z = 0.5 * (places + 1.0) * panels.end[p]
        row = panels.coefficients[p, 0]
        y, slope = (
            chebyshev.chebval(2.0 * z - 1.0, row),
            2.0 * chebyshev.chebval(2.0 * z - 1.0, chebyshev.chebder(row)),
        )
        loads = [follower.load(s, time) for s in y * y]
        total += 0.5 * panels.end[p] * float(weights @ (loads * slope))
    return total


def random_program(rng: np.random.Generator) -> tuple[PronySeries, Any, Any]:
    """A solid or a liquid of one to three terms, and a program of straight lines with holds, which begins in contact."""
    count, size = rng.integers(1, 4), rng.integers(4, 12)
    series = PronySeries(
        float(rng.random() < 0.7), 10.0 ** rng.uniform(-1.0, 1.0, count), 10.0 ** rng.uniform(-1.0, 1.0, count)
    )
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.1, 1.0, size))])
    depths = np.concatenate([[0.0, rng.uniform(0.5, 1.0)], rng.uniform(-0.3, 1.0, size - 1)])
    holds = 2 + np.flatnonzero(rng.random(size - 2) < 0.2)
    for n in holds:
        depths[n] = depths[n - 1]
    # It ends in contact mostly, where the force is compared.
    depths[-1] = rng.uniform(0.5, 1.0)
    return series, times, depths


def check_random_program(seed: int, rtol: float) -> None:
    series, times, depths = random_program(np.random.default_rng(seed))
    duration = times[-1]
    typical = series.equilibrium_modulus + series.branch_moduli @ np.minimum(1.0, series.relaxation_times / duration)
    result = run_depth(series, (times, depths), STEP_SHARE * rtol, float(typical))
    assert result.outcome == DONE
    records, size = result.room.records, result.room.places[RECORDS]
    largest = np.abs(records.columns[:size, 2]).sum(axis=1).max()
    follower = Follower(series.equilibrium_modulus, series.branch_moduli, series.relaxation_times, times, depths)
    expected = followed_force(result, follower, duration)
    # Gauss quadrature over few panels of a loose run is exact to some 1e-10.
    assert abs(result.room.state[FORCE] - expected) <= (10.0 * rtol + 1e-10) * largest
    assert result.room.state[WORK] >= -1e-12


@pytest.mark.parametrize("seed", [0, 1, 5, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (2, 3, 4))])
def test_random_programs_against_elements_followed_alone(seed):
    check_random_program(seed, 1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6, 106))
def test_more_random_programs_against_elements_followed_alone(seed):
    check_random_program(seed, 1e-8)


@pytest.mark.parametrize(
    ("profile", "exponent", "power"),
    [(rs.Parabola(1.0), 1.0, 2), (rs.Cone(math.pi / 4.0), 2.0, 2), (rs.PowerLaw(3.0, 1.0), 2.0 / 3.0, 6)],
    ids=["parabola", "cone", "r^3"],
)
@pytest.mark.parametrize(
    "series",
    [
        PronySeries(0.5, [1.0, 2.0, 4.0], [0.05, 0.5, 5.0]),
        PronySeries(0.0, [4.0], [1.0]),
        pytest.param(PronySeries(1.0, [4.0], [1.0], parallel_viscosity=0.3), marks=pytest.mark.plain),
        PronySeries(1.0),
        PronySeries(1.0, [2.0, 3.0], [1e-4, 0.7]),
        PronySeries(1.0, np.ones(20), np.logspace(-6.0, 4.0, 20)),
    ],
    ids=["solid", "liquid", "dashpot", "elastic", "fast", "twenty terms"],
)
def test_one_cycle_is_that_of_an_indentation(series, profile, exponent, power):
    """Growth by Lee and Radok, shrinkage by Ting, computed by the kernel of `rs.indent`."""
    times, depths, tolerance = [0.0, 0.3, 1.0, 1.5], [0.0, 1.0, 1.0, 0.0], 1e-9
    expected = rs.indent(rs.Material(series.scaled(0.25), math.inf), profile, depth=depths, time=times, rtol=1e-11)
    unit = 2.0 * float(profile.path_coefficient)
    largest = expected.max_force / unit
    result = run_depth(series, (times, depths), tolerance, largest, power_path(exponent), power)
    assert result.outcome == DONE
    assert result.breaks() == pytest.approx([expected.contact_end_time], rel=1e-10)
    moments = np.linspace(0.011, 1.499, 41)
    error = np.abs(result.sample(moments, 2) - expected.sample(moments).force.values / unit)
    assert error.max() <= 3.0 * tolerance * largest
