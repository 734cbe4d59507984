"""Parts of an adhesive step against quadrature and closed forms."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import restitution as rs
from restitution.indentation import attraction
from restitution.indentation.solid import branches_of, compliance_of
from restitution.kernel import dissipation, waiting, zone


def plain(function):
    """The Python function behind a compiled one."""
    return getattr(function, "py_func", function)


@pytest.mark.parametrize(("edge", "after"), [(1.0, 1.2), (1.2, 1.0), (0.9, 1.3), (1.3, 0.9), (0.5, 0.8), (1.1, 1.1)])
def test_the_impulse_of_the_pull_is_that_of_a_root(edge, after):
    stress, x, dt = 0.7, 0.95, 0.3

    def pull(t):
        square = edge**2 + (after**2 - edge**2) * t / dt - x * x
        return -2.0 * stress * math.sqrt(max(square, 0.0))

    # Where c passes the element, the root begins or ends within the step.
    kink = dt * (x * x - edge**2) / (after**2 - edge**2) if edge != after else 0.5 * dt
    parts = [0.0, *([kink] if 0.0 < kink < dt else []), dt]
    whole = sum(quad(pull, low, high, epsabs=1e-13)[0] for low, high in pairwise(parts))
    bump = plain(zone._bump)(pull(0.0), pull(dt), x, edge, after, dt)
    assert bump == pytest.approx(whole - 0.5 * dt * (pull(0.0) + pull(dt)), abs=1e-9)


def test_an_instant_within_a_step_is_the_root_of_a_line_and_of_a_root(monkeypatch):
    """By bisection and quadrature; the square falls or rises, from below zero or to it."""
    monkeypatch.setattr(zone, "_is_steady", plain(zone._is_steady))
    rng = np.random.default_rng(5)
    count = 0
    while count < 200:
        start, end = rng.uniform(-2.0, 2.0, 2)
        squares = rng.uniform(-0.5, 2.0, 2)

        def root(s, squares=squares):
            return math.sqrt(max(squares[0] + (squares[1] - squares[0]) * s, 0.0))

        def value(s, start=start, end=end, root=root):
            return start + (end - start) * s + root(s)

        # Where the square is negative there is no attraction, and a line alone has no instant here.
        kink = squares[0] / (squares[0] - squares[1])
        ends = [0.0 if squares[0] >= 0.0 else kink, 1.0 if squares[1] >= 0.0 else kink]
        if max(squares) < 0.0 or value(ends[0]) * value(ends[1]) >= 0.0:
            continue
        count += 1
        exact = brentq(value, *ends, xtol=1e-15)
        part, v = plain(zone._crossing)(start, end, *squares)
        assert part == pytest.approx(exact, abs=1e-9)
        assert v == pytest.approx(root(exact), abs=1e-7)
        before = quad(root, ends[0], exact, epsabs=1e-12)[0]
        assert plain(zone._impulse)(ends[0], part, root(ends[0]), v, *squares) == pytest.approx(before, abs=1e-8)


def test_weights_of_unequal_elements_are_those_of_lines_in_the_square():
    """Simpson's rule of each cell is exact for loads that are lines in x^2."""
    places = np.sort(np.append(0.0, np.random.default_rng(6).uniform(0.1, 2.0, 9)))
    room = zone.allocate_room(places, 0, 1, 1)
    loads = np.random.default_rng(7).uniform(-1.0, 1.0, 10)
    low, high = places[:-1], places[1:]
    middle = loads[:-1] + (loads[1:] - loads[:-1]) * ((0.5 * (low + high)) ** 2 - low**2) / (high**2 - low**2)
    exact = ((high - low) * (loads[:-1] + 4.0 * middle + loads[1:]) / 6.0).sum()
    assert room.nodes[zone.SHARE_] @ loads == pytest.approx(exact, rel=1e-12)
    for x, below in ((0.0, 0), (places[3], 3), (places[3] + 1e-12, 4), (3.0, 10)):
        assert plain(zone.count_below)(places, x) == below
        assert [plain(zone.count_near)(places, x, near) for near in (0, 3, 6, 10)] == [below] * 4


def test_what_an_element_dissipates_on_two_lines_is_an_integral(monkeypatch):
    for name in ("_spent", "_spent_on_line"):
        monkeypatch.setattr(dissipation, name, plain(getattr(dissipation, name)))
    rng = np.random.default_rng(9)
    for rate in (1e-4, 0.3, 40.0):
        solid, dt = zone.Solid(1.0, np.array([1.7]), np.array([rate])), 0.7
        room = room_of(solid, [0.0])
        before, kink, after, memory = rng.uniform(-1.0, 1.0, 4)
        part = float(rng.uniform(0.1, 0.9))
        room.nodes[zone.PART_, 0], room.nodes[zone.KINK_, 0], room.memory[0, 0] = part, kink, memory

        def drive(t, data=(before, kink, after, memory, part, rate)):
            """q - r M at a time, with M by quadrature."""
            before, kink, after, memory, part, rate = data

            def load(s):
                return np.interp(s, [0.0, part * 0.7, 0.7], [before, kink, after])

            past = quad(lambda s: math.exp(-rate * (t - s)) * load(s), 0.0, t, points=[min(part * 0.7, t)])[0]
            return load(t) - rate * (memory * math.exp(-rate * t) + past)

        exact = 1.7 * quad(lambda t, drive=drive: drive(t) ** 2, 0.0, dt, points=[part * dt], limit=200)[0]
        spent = plain(dissipation._spent_in_parts)(solid, dt, 0, before, after, room)
        # With a rate times step below 1e-3 the drive counts as linear.
        assert spent == pytest.approx(exact, rel=2e-5 if rate == 1e-4 else 1e-7)


def room_of(solid, gaps):
    """Room for elements with these undeformed gaps, and their factors over a step."""
    room = zone.allocate_room(np.arange(float(len(gaps))), solid.rates.size, 4, 4)
    room.nodes[zone.G_] = gaps
    return room


@pytest.mark.parametrize("rate", [0.0, 1e-3, 0.3, 40.0])
def test_factors_are_integrals_of_the_memory(rate):
    dt = 0.7
    room = room_of(zone.Solid(1.0, np.array([1.0]), np.array([rate])), [0.0])
    plain(zone.set_factors)(zone.Solid(1.0, np.array([1.0]), np.array([rate])), dt, room)
    loads = (lambda t: 1.0 - t / dt), (lambda t: t / dt), (lambda t: 1.0)
    exact = [quad(lambda t, load=load: math.exp(-rate * (dt - t)) * load(t), 0.0, dt)[0] for load in loads]
    assert room.factors[0, zone.FALL_ : zone.MEAN_ + 1] == pytest.approx(exact, rel=1e-10)
    assert room.factors[0, 0] == pytest.approx(math.exp(-rate * dt))


@pytest.mark.parametrize("rate", [0.0, 1e-3, 0.3, 40.0])
def test_the_energy_of_a_step_is_an_integral(rate, monkeypatch):
    for name in ("_spent", "dot"):
        monkeypatch.setattr(dissipation, name, plain(getattr(dissipation, name)))
    dt, first, slope, weight = 0.7, 0.4, -1.3, 1.7

    def drive(t):
        # q - r M of a linear load: it starts at `first` and relaxes to slope/r.
        steady = slope * t if rate == 0.0 else slope * -math.expm1(-rate * t) / rate
        return first * math.exp(-rate * t) + steady

    exact = quad(lambda t: drive(t) ** 2, 0.0, dt, epsabs=1e-13)[0]
    solid = zone.Solid(1.0, np.array([weight]), np.array([rate]))
    room = room_of(solid, [0.0, 1.0])
    plain(zone.set_factors)(solid, dt, room)
    # An element at the axis and the last one beside it, with weights that are exact for lines in x^2: 2/3 and 1/3.
    room.nodes[zone.Q_], room.nodes[zone.Q1_] = first, first + slope * dt
    result = plain(dissipation.remember)(solid, dt, 0, 2, room)
    # Below a rate times step of 1e-3 the drive counts as linear: its greatest distance from a line is r dt^2 slope/8.
    linear = 0.25 * rate * dt**3 * abs(slope) * max(first, abs(drive(dt))) if rate * dt < 1e-3 else 0.0
    whole = weight
    assert result == pytest.approx(whole * exact, abs=whole * (linear + 1e-9 * exact))


def test_an_element_that_changes_its_state_has_the_impulse_of_a_broken_line(monkeypatch):
    for name in ("_leaving", "_touching", "_crossing", "_impulse", "_is_steady"):
        monkeypatch.setattr(zone, name, plain(getattr(zone, name)))
    # Without attraction: gap or load at the start, and at the end as if the state stayed. One slow mode of weight 2.
    solid, dt = zone.Solid(0.5, np.array([2.0]), np.array([0.0])), 0.1
    bodies = zone.Bodies(0.0, 0.1, 1.0, 1.0, 1.0, False, 0.0, 0.0, 0.0)
    for nodes_before, depth in (((0.0, 0.02), 0.05), ((0.3, 0.0), -0.2)):
        room = room_of(solid, [0.0])
        room.nodes[zone.P_, 0], room.nodes[zone.H_, 0] = nodes_before
        # W = J0 q + 2 M, and the body at depth 0 - H of the start.
        room.memory[0, 0] = (0.0 - nodes_before[1] - 0.5 * nodes_before[0]) / 2.0 + 0.02
        plain(zone.set_factors)(solid, dt, room)
        plain(zone.write_bases)(solid, dt, 0, 1, room)
        plain(zone.write_element)(solid, bodies, dt, depth, 0, room)
        load, gap = room.nodes[zone.P1_, 0], room.nodes[zone.H1_, 0]
        assert (load > 0.0) == (nodes_before[0] == 0.0)
        # The load is a line from or to zero within the step: its impulse is half the load times its duration.
        impulse = 0.5 * dt * (nodes_before[0] + load) + room.nodes[zone.BUMP_, 0]
        part = impulse / (0.5 * dt * (nodes_before[0] + load))
        assert 0.0 < part < 1.0
        # Displacement at the end: J0 q + 2 (M + impulse), which is that of the body plus the gap.
        surface = 0.5 * load + 2.0 * (room.memory[0, 0] + impulse)
        assert surface == pytest.approx(depth + gap, abs=1e-14)


def relaxed(equilibrium, moduli, rates, knots, depths, gap):
    """Displacement, load and branch loads of an element that follows lines of the depth, as functions of time."""
    knots, depths = np.asarray(knots), np.asarray(depths)
    slopes = np.diff(depths) / np.diff(knots)

    def branch(k, t):
        low, high = np.minimum(knots[:-1], t), np.minimum(knots[1:], t)
        fading = np.exp(-rates[k] * (t - high)) - np.exp(-rates[k] * (t - low))
        return float(moduli[k] / rates[k] * slopes @ fading)

    def load(t):
        return equilibrium * (np.interp(t, knots, depths) - gap) + sum(branch(k, t) for k in range(moduli.size))

    return branch, load


def test_an_element_that_waits_has_the_memory_of_one_that_follows(monkeypatch):
    monkeypatch.setattr(waiting, "cohesive_load", plain(zone.cohesive_load))
    rng = np.random.default_rng(8)
    for equilibrium in (0.3, 0.0):
        moduli = rng.uniform(0.1, 1.0, 3)
        series = rs.PronySeries(equilibrium, moduli, 10.0 ** rng.uniform(-1.5, 1.0, 3))
        soft, weights, recoveries = compliance_of(series)
        (moduli, rates, creep), bridge = branches_of(series)
        solid = zone.Solid(soft, weights, recoveries)
        gap = rng.uniform(-0.5, 0.5)
        room = room_of(solid, [gap, 0.0])
        room.branches[:, zone.MODULUS_], room.branches[:, zone.PACE_] = moduli, rates
        room.branches[:, zone.CREEP_], room.bridge[...], room.ends[zone.FIRM_] = creep, bridge, equilibrium
        for n, row in enumerate((zone.SUM_, zone.SUM_G_, zone.SUM_GG_)):
            room.nodes[row, 1] = room.nodes[zone.SHARE_, 0] * gap**n
        # The surface is loaded from time 0 on, and waits from 0.4 to 1.5, while the depth turns at 0.9.
        knots, depths = np.array([0.0, 0.4, 0.9, 1.5]), gap + np.array([0.0, 0.2, 0.5, 0.3])
        branch, load = relaxed(equilibrium, moduli, rates, knots, depths, gap)

        def memory(j, t, load=load, recoveries=recoveries):
            points = [knot for knot in (0.4, 0.9) if knot < t]
            return quad(lambda s: math.exp(-recoveries[j] * (t - s)) * load(s), 0.0, t, points=points, limit=200)[0]

        room.now[zone.T_], room.now[zone.D_] = 0.4, gap + 0.2
        room.nodes[zone.P_, 0] = load(0.4)
        room.memory[:, 0] = [memory(j, 0.4) for j in range(3)]
        plain(waiting._let_follow)(solid, 0, room)
        room.counts[zone.LOW_], room.counts[zone.WAITS_] = 1, 1
        share, spent = room.nodes[zone.SHARE_, 0], 0.0
        for k in range(3):
            assert room.branches[k, zone.FIRST_] == pytest.approx(share * branch(k, 0.4), rel=1e-8)
        for dt, depth in ((0.5, gap + 0.5), (0.6, gap + 0.3)):
            spent += plain(waiting.carry)(solid, dt, depth - room.now[zone.D_], room)
            room.now[zone.T_] += dt
            room.now[zone.D_] = depth
        lost = sum(
            rates[k] / moduli[k] * quad(lambda t, k=k, branch=branch: branch(k, t) ** 2, 0.4, 1.5, points=[0.9])[0]
            for k in range(3)
        )
        assert spent == pytest.approx(share * lost, rel=1e-8)
        stored = equilibrium * 0.3**2 + sum(branch(k, 1.5) ** 2 / moduli[k] for k in range(3))
        assert plain(waiting.waiting_energy)(solid, room) == pytest.approx(share * stored, rel=1e-8)
        plain(waiting._wake_inside)(zone.Bodies(0.0, 0.1, 1.0, 1.0, 1.0, False, 0.0, 0.0, 0.0), 0, room)
        assert room.nodes[zone.P_, 0] == pytest.approx(load(1.5), rel=1e-8)
        assert room.memory[:, 0] == pytest.approx([memory(j, 1.5) for j in range(3)], rel=1e-7)
        assert room.branches[:, zone.FIRST_] == pytest.approx(0.0, abs=1e-14)


def test_elements_beyond_the_attraction_relax_by_themselves(monkeypatch):
    """Their modes decay, and c r M^2/2 of each is stored and dissipated, whether they wait or not."""
    for name in ("_wake_beyond", "write_pulls"):
        monkeypatch.setattr(waiting, name, plain(getattr(waiting, name)))
    rng = np.random.default_rng(3)
    solid = zone.Solid(0.5, rng.uniform(0.1, 1.0, 2), rng.uniform(0.1, 2.0, 2))
    bodies = zone.Bodies(0.4, 0.1, 1.0, 1.0, 1.0, False, 0.0, 0.0, 0.0)
    gaps = rng.uniform(1.0, 2.0, 60)
    room = room_of(solid, gaps)
    room.branches[:, zone.MODULUS_] = room.branches[:, zone.PACE_] = 1.0
    room.memory[:, :50] = first = rng.uniform(0.0, 1.0, (2, 50))
    room.counts[zone.TOP_], room.counts[zone.WAITS_] = 50, 1
    room.ends[zone.MADE_], room.now[zone.T_] = math.nan, 0.7
    plain(waiting.rest)(solid, bodies, room)
    # Three elements beside the edge at 0 do not wait.
    assert room.counts[zone.TOP_] == 3
    share, spent, time = room.nodes[zone.SHARE_, :50], 0.0, 0.0
    each = share[3:] * solid.weights[:, None] * solid.rates[:, None]
    for dt in (0.4, 1.3):
        plain(zone.set_factors)(solid, dt, room)
        spent += plain(waiting.carry)(solid, dt, 0.0, room)
        time += dt
        after = first * np.exp(-solid.rates[:, None] * time)
        assert spent == pytest.approx(0.5 * (each * (first[:, 3:] ** 2 - after[:, 3:] ** 2)).sum(), rel=1e-12)
        assert plain(waiting.waiting_energy)(solid, room) == pytest.approx((each * after[:, 3:] ** 2).sum(), rel=1e-12)
    room.now[zone.T_], room.now[zone.D_] = 0.7 + time, 0.25
    plain(waiting.wake)(solid, bodies, 0, 60, room)
    assert room.counts[zone.TOP_] == 60
    assert room.memory[:, 3:50] == pytest.approx(after[:, 3:], rel=1e-12)
    moved = np.append(solid.weights @ after, np.zeros(10))
    assert room.nodes[zone.H_, 3:] == pytest.approx((moved - 0.25 + gaps)[3:], rel=1e-12)
    assert not room.memory[:, 50:].any()
    assert room.branches[:, zone.BEYOND_] == pytest.approx(0.0, abs=1e-12)


def marches(series, count, *, waits):
    """An impact and a history with two visits, in which elements wait or not."""
    body = attraction.Sticky(rs.Parabola(1.0), series, rs.Adhesion(0.02, 1.5))
    begin = attraction._Scaled.begin

    def choosing(*arguments):
        bodies, room = begin(*arguments)
        room.counts[zone.WAITS_] = int(waits)
        return bodies, room

    program = attraction.Program(
        np.array([0.0, 1.0, 1.5, 2.0, 4.0, 5.0, 7.0]), np.array([-0.1, 0.4, 0.2, 0.3, -1.0, 0.3, -1.2])
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(attraction._Scaled, "begin", choosing)
        return body.march(0.9, 2.5, count, mass=1.0, velocity=0.8), body.follow(0.9, program, count)


@pytest.mark.parametrize(
    "series",
    [rs.PronySeries(3.0, [], []), rs.PronySeries(1.0, [1.5, 0.5], [3e7, 1e8]), rs.PronySeries(0.0, [3.0], [1e8])],
    ids=["elastic", "slow", "slow liquid"],
)
def test_elastic_elements_that_wait_are_those_of_the_march_of_all(series):
    """Loads and displacements of what does not relax are both lines, so that rounding and the relaxation are left."""
    relaxed = 20.0 * 7.0 / float(series.relaxation_times.min(initial=math.inf))
    for lazy, other in zip(*(marches(series, 200, waits=waits) for waits in (True, False)), strict=True):
        assert lazy.end == other.end
        assert len(lazy.jumps) == len(other.jumps) > 1
        assert lazy.motion.shape == other.motion.shape
        assert lazy.motion == pytest.approx(other.motion, abs=1e-10 + relaxed)
        assert lazy.left == pytest.approx(other.left, abs=1e-10 + relaxed)


@pytest.mark.parametrize("equilibrium", [1.0, 0.0])
def test_a_march_in_which_elements_wait_is_that_of_all_elements(equilibrium):
    series = rs.PronySeries(equilibrium, [3.0, 2.0, 1.0], [2.0, 0.3, 0.01])
    distances = []
    for count in (150, 600):
        pairs = zip(*(marches(series, count, waits=waits) for waits in (True, False)), strict=True)
        for lazy, other in pairs:
            assert lazy.end == other.end
            assert len(lazy.jumps) == len(other.jumps)
            ends = lazy.motion[-1] - other.motion[-1]
            tops = lazy.motion.max(axis=0) - other.motion.max(axis=0)
            pulls = lazy.motion.min(axis=0) - other.motion.min(axis=0)
            distances.append([*np.abs(ends[6:]), *np.abs(tops[[1, 3]]), np.abs(pulls[3]), abs(lazy.left - other.left)])
    coarse, fine = np.reshape(distances, (2, 2, -1))
    # Loads of one are lines over a step, displacements of the other: both of second order, 1/16 here.
    assert coarse.max() < 1e-3
    assert np.all(np.linalg.norm(fine, axis=1) < 0.2 * np.linalg.norm(coarse, axis=1))


def test_sums_over_the_elements_before_one_have_its_weights_and_gaps():
    body = attraction.Sticky(rs.Parabola(1.0), rs.PronySeries(1.0, [], []), rs.Adhesion(0.02, 1.5))
    _, room = attraction._Scaled(body, 0.9, 2.5).begin(20, 1.0, 4)
    places = 0.9 * np.arange(room.nodes.shape[1]) / 20
    for n, row in enumerate((zone.SUM_, zone.SUM_G_, zone.SUM_GG_)):
        parts = room.nodes[zone.SHARE_] * (places**2 / 0.9) ** n
        assert room.nodes[row] == pytest.approx([parts[:k].sum() for k in range(parts.size)], rel=1e-12)


def test_the_first_elements_resolve_the_ring_of_the_glass_where_relaxation_is_faster_than_a_step():
    """A ring of pi w E0/(8 sigma0^2) = 9.8e-5 takes a quarter of an element of 1/2546, and so 100 times 32."""
    for time, first in ((1e-6, 3200), (1.0, 100)):
        body = attraction.Sticky(rs.Parabola(1.0), rs.PronySeries(1.0, [4.0], [time]), rs.Adhesion(0.02, 20.0))
        assert body.counts(1.0, 1.0) == (first, 51200)


@pytest.mark.parametrize("place", [0.0, 0.3, 0.9])
def test_a_gap_that_bends_at_the_edge_is_integrated_exactly(place, monkeypatch):
    """With ``u = c^2 - x^2`` the integral of ``u^(n/2)/sqrt(u)`` over x from x0 to c is that of ``u^((n - 1)/2)``."""
    for name in (
        "cohesive_load", "_bump", "cell_weights", "_small_angle", "dot", "_dot_of_cubes", "_moment", "_bend",
        "count_near",
    ):  # fmt: skip
        monkeypatch.setattr(zone, name, plain(getattr(zone, name)))
    cells, first = 40, 12
    room = zone.allocate_room(np.arange(cells + 8) / cells, 0, 1, 1)
    edge = (30.0 + place) / cells
    x = room.nodes[zone.PLACE_]
    u = np.maximum(edge**2 - x**2, 0.0)
    bodies = zone.Bodies(0.4, 0.1, 1.0, 1.0 / cells, 1.0, False, 0.0, 0.0, 0.0)
    solid = zone.Solid(1.0, np.zeros(0), np.zeros(0))
    room.counts[zone.TOP_], room.counts[zone.WEIGHED_] = cells + 8, cells + 8
    plain(zone.write_pulls)(bodies, edge, 0, cells + 8, room)
    plain(zone.weigh)(bodies, edge, first, room)
    coefficients = 0.7, -1.3, 2.1
    powers = (0, 2, 3)
    # Beyond the edge the gap has another form, which does not count.
    gap = sum(a * u ** (n / 2) for a, n in zip(coefficients, powers, strict=True))
    room.nodes[zone.G_] = np.where(x > edge, 5.0, gap)
    # By y = c sin(t).
    start = math.asin(x[first] / edge)
    exact = sum(
        a * quad(lambda t, n=n: (edge * math.cos(t)) ** n, start, 0.5 * math.pi, epsabs=1e-14)[0]
        for a, n in zip(coefficients, powers, strict=True)
    )
    last = 30 if place == 0.0 else 31
    errors = []
    for bends in (0, 1):
        room.counts[zone.BENDS_] = bends
        plain(zone.write_tail)(solid, bodies, edge, first, last, room)
        errors.append(abs(plain(zone.tail)(solid, 0.0, 0.0, room) - exact))
    # A gap linear in u within cells would be off.
    assert errors[0] > 1e-5
    assert errors[1] < 1e-12
