"""Forces and springs on a material with a dashpot in parallel: closed forms, an ODE, and the computed depth.

Of E*(t) = E + eta delta(t) all elements in contact share the load P = E d + eta d', and `q = P - E s`. While the
contact grows, G = Pi(d) obeys `E G + eta G' = F/2`; while it shrinks, the force is that of an elastic contact of the
depth P/E.
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from restitution import Material, PronySeries, Pyramid, indent
from restitution.contact.profiles import Cone, FlatPunch, Parabola, TruncatedCone

E, ETA, R = 1.5, 0.4, 2.0
VOIGT = Material(PronySeries(E / 4.0, parallel_viscosity=ETA / 4.0), math.inf)
SOLID = PronySeries(1.0, [4.0], [1.0], parallel_viscosity=0.3)
# G of a parabola: int sqrt(R d) dd = c d^(3/2).
C = 2.0 / 3.0 * math.sqrt(R)


def half_space(series):
    return Material(series.scaled(0.25), math.inf)


@pytest.mark.plain
def test_a_force_that_jumps_downward():
    """Creep under F_1, then decay of the depth at the constant radius of an elastic contact under F_2."""
    first, second, jump = 3.0, 0.8, 0.5
    result = indent(VOIGT, Parabola(R), force=[0.0, first, first, second, second], time=[0.0, 0.0, jump, jump, 2.0])
    before, behind = np.linspace(0.01, jump, 20), np.linspace(0.501, 2.0, 20)
    growth = (first / (2.0 * E) * -np.expm1(-E / ETA * before) / C) ** (2.0 / 3.0)
    last, rest = growth[-1], (second / (2.0 * E * C)) ** (2.0 / 3.0)
    decay = rest + (last - rest) * np.exp(-E / ETA * (behind - jump))
    largest = growth.max()
    assert result.sample(before, before=True).indentation_depth.values == pytest.approx(growth, abs=1e-7 * largest)
    sample = result.sample(behind)
    assert sample.indentation_depth.values == pytest.approx(decay, abs=1e-7 * largest)
    assert sample.contact_radius.values == pytest.approx(math.sqrt(R * rest), rel=1e-7)
    assert sample.force.values == pytest.approx(second, rel=1e-7)


@pytest.mark.plain
def test_a_force_that_jumps_to_zero_lets_the_whole_contact_leave():
    """The free surface relaxes as a whole, exp(-E t/eta)."""
    result = indent(VOIGT, Parabola(R), force=[0.0, 3.0, 3.0, 0.0, 0.0], time=[0.0, 0.0, 0.5, 0.5, 2.0])
    assert result.contact_intervals == pytest.approx(np.array([[0.0, 0.5]]))
    last = (3.0 / (2.0 * E) * -math.expm1(-E / ETA * 0.5) / C) ** (2.0 / 3.0)
    for time in (0.6, 1.0, 1.9):
        assert result.imprint(time, 0.0) == pytest.approx(last * math.exp(-E / ETA * (time - 0.5)), rel=1e-6)


def spring_cycle(k, times, base):
    """Depth at the end of the contact and its time, by an ODE in each direction."""

    def pull(t, d):
        return max(k * (np.interp(t, times, base) - d), 0.0)

    def grows(t, y):
        return [(0.5 * pull(t, abs(y[0]) ** (2 / 3)) - E * C * y[0]) / (ETA * C)]

    def shrinks(t, y):
        return [(E * (pull(t, y[0]) / (2.0 * E * C)) ** (2.0 / 3.0) - E * y[0]) / ETA]

    def stands(t, y):
        return 0.5 * pull(t, abs(y[0]) ** (2 / 3)) - E * C * y[0]

    def ends(t, y):
        return k * (np.interp(t, times, base) - y[0])

    options = {"rtol": 1e-10, "atol": 1e-13, "max_step": 0.01}
    stands.terminal, stands.direction, ends.terminal = True, -1, True
    # G' = eta d^(3/2)' = 0 where the contact turns.
    first = solve_ivp(grows, (times[0], times[-1]), [1e-12], events=stands, dense_output=True, **options)
    turn, depth = first.t[-1], first.y[0, -1] ** (2 / 3)
    second = solve_ivp(shrinks, (turn, times[-1]), [depth], events=ends, dense_output=True, **options)
    return turn, depth, second


@pytest.mark.parametrize("k", [0.5, 20.0])
def test_a_spring_is_pushed_and_pulled(k):
    times, base = np.array([0.0, 1.0, 3.0]), np.array([0.0, 1.0, -1.0])
    turn, depth, second = spring_cycle(k, times, base)
    result = indent(VOIGT, Parabola(R), depth=base, time=times, spring_constant=k)
    assert result.turning_times == pytest.approx([turn], abs=1e-6)
    assert result.max_indentation_depth == pytest.approx(depth, rel=1e-6)
    assert result.contact_end_time == pytest.approx(second.t[-1], abs=1e-6)
    moments = np.linspace(turn, second.t[-1], 30)[1:-1]
    assert result.sample(moments).indentation_depth.values == pytest.approx(second.sol(moments)[0], abs=1e-6)


@pytest.mark.parametrize("profile", [Parabola(R), Cone(1.1), TruncatedCone(1.1, 0.3), FlatPunch(0.4)])
@pytest.mark.parametrize("spring", [False, True], ids=["force", "spring"])
def test_the_computed_depth_has_the_same_force(profile, spring):
    """Straight lines through the computed depth miss its rate, and so the force, by their width."""
    times = np.array([0.0, 1.0, 1.4, 2.0, 2.5, 3.0])
    values = np.array([0.0, 1.0, 0.5, 1.3, 0.3, 0.8])
    pulled = {"depth": np.append(values[:-1], -0.5), "spring_constant": 2.0}
    drive = pulled if spring else {"force": values}
    result = indent(half_space(SOLID), profile, time=times, **drive)
    stop = 0.98 * min(result.contact_end_time, times[-1])
    moments = np.linspace(0.06, stop - 0.01, 41)
    force = result.sample(moments).force.values
    differences = []
    for count in (201, 1601):
        knots = np.union1d(stop * np.linspace(0.0, 1.0, count) ** 2, [*times[times < stop], *result.turning_times])
        knots = knots[(knots <= stop) & (np.diff(knots, prepend=-1.0) > 1e-9)]
        depth = np.append(0.0, result.sample(knots[1:]).indentation_depth.values)
        again = indent(half_space(SOLID), profile, depth=depth, time=knots, rtol=1e-6)
        differences.append(np.abs(again.sample(moments).force.values - force).max())
    assert differences[1] <= 0.6 * differences[0]
    assert differences[1] <= 0.02 * force.max()


def test_a_force_that_jumps_on_a_punch():
    """A punch obeys E d + eta d' = F/(2 a)."""
    times, a = [0.0, 1.0, 1.0, 2.0], 0.4
    result = indent(VOIGT, FlatPunch(a), force=[0.0, 1.0, 0.3, 0.3], time=times)
    behind = np.linspace(1.0, 2.0, 11)
    tau = ETA / E
    last = (1.0 - tau + tau * math.exp(-1.0 / tau)) / (2.0 * a * E)
    rest = 0.3 / (2.0 * a * E)
    expected = rest + (last - rest) * np.exp(-(behind - 1.0) / tau)
    assert result.sample(behind).indentation_depth.values == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("profile", [Cone(1.0), Parabola(R), TruncatedCone(0.2, 1.2)])
def test_a_force_that_falls_behind_a_jump(profile):
    """A jump is the limit of a steep rise, whatever the rounding of the force of no contact."""
    rng = np.random.default_rng(8)
    for _ in range(12):
        solid = half_space(PronySeries(1.0, [rng.uniform(1.0, 5.0)], [rng.uniform(0.05, 0.5)], parallel_viscosity=0.5))
        start, first = rng.uniform(0.0, 1.0), rng.uniform(0.2, 0.8)
        force, times = [0.0, first, rng.uniform(0.3, 0.9) * first], start + np.array([0.0, 0.0, 0.5])
        jumps = indent(solid, profile, force=force, time=times)
        rises = indent(solid, profile, force=force, time=times + np.array([0.0, 1e-7, 0.0]))
        moments = start + np.linspace(0.05, 0.5, 10)
        expected = rises.sample(moments).indentation_depth.values
        assert expected.min() > 0.0
        assert jumps.sample(moments).indentation_depth.values == pytest.approx(expected, rel=1e-5)
        assert jumps.dissipated > 0.0


@pytest.mark.parametrize("rtol", [1e-7, 1e-9])
def test_a_surface_that_grazes_the_body_is_found(rtol):
    """A surface that recovers overtakes the receding body for a fiftieth of a second, within one step of free flight.

    The body is never below the free surface: its depth then is that of the surface which the contact before has left.
    """
    series = PronySeries(1e6, [255251.75580527520], [2.2324780996953835], parallel_viscosity=199955.54434669978)
    time = np.array([0.0, 0.5494856, 0.87799026, 1.33668096, 2.30987804, 2.68838297])
    depth = 1e-6 * np.array([-6.32720208, 69.19571557, 66.21713646, 12.89683387, -16.93855571, 38.73582751])
    body, tip = Material(series.scaled(0.25), math.inf), Parabola(1e-2)
    result = indent(body, tip, time=time, depth=depth, rtol=rtol)
    end = float(result.contact_intervals[0, 1])
    before = np.append(time[time < end], end)
    surface = indent(body, tip, time=before, depth=np.interp(before, time, depth), rtol=rtol).surface()
    free = np.linspace(end, 2.3, 2001)[1:]
    below = np.interp(free, time, depth) - np.array([surface.depth_after(float(t - end)) for t in free])
    grazes = free[below > 1e-6 * depth.max()]
    begin, stop = result.contact_intervals[1]
    # The contact ends earlier than a surface without one would be below the body.
    assert 1.44 < grazes[0] < grazes[-1] < 1.5
    assert grazes[0] == pytest.approx(begin, abs=free[1] - free[0])
    assert begin < stop < grazes[-1]


def test_a_force_that_rises_behind_a_hold():
    """Depths follow rtol, as they must where the edge of the contact has stood still before it moves on.

    What the elements beside it have recovered meanwhile was lost in half of these programs, by rounding: depths were
    off by up to 3e-5 at any tolerance.
    """
    rng = np.random.default_rng()
    for tip in (Parabola(1e-2), Cone(0.5), Pyramid(1.2)) * 4:
        series = PronySeries(
            1e6, [1e6 * 10.0 ** rng.uniform(-1.0, 0.3)], [10.0 ** rng.uniform(-2.5, -1.5)],
            parallel_viscosity=1e6 * 10.0 ** rng.uniform(-1.5, -0.5),
        )  # fmt: skip
        time = np.append(0.0, np.cumsum(rng.uniform(0.1, 0.5, 5)))
        force = np.array([0.0, 7.5, 7.5, 2.5, 2.5, 9.0])
        moments = np.linspace(0.01, time[-1], 200)
        strict, *depths = (
            indent(half_space(series), tip, force=force, time=time, rtol=rtol).sample(moments).indentation_depth.values
            for rtol in (1e-9, 1e-6, 1e-7, 1e-8)
        )
        for depth, rtol in zip(depths, (1e-6, 1e-7, 1e-8), strict=True):
            assert depth == pytest.approx(strict, abs=10.0 * rtol * strict.max()), (tip, series, time, rtol)
