"""Surrogates of bodies that stick below a velocity, against closed forms and other solves."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import restitution as rs
from refusals import in_one_line
from restitution.surrogates.velocity import NEAR, Pieces, content_hash, lookup_table, value

pytestmark = pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning")
# An elastic ball, row A6 of the prototype: it loses the same energy in its jumps at any velocity.
ELASTIC = rs.Material(rs.PronySeries(0.25, [], []), bulk=math.inf)
BALL = rs.Impact(ELASTIC, rs.Parabola(1.0), 1.0, 0.3, adhesion=rs.Adhesion(0.01, 0.157768))
RANGE = 0.02, 1.0


@pytest.fixture(scope="module")
def ball():
    return rs.surrogate(BALL, RANGE, rtol=1e-2)


def test_a_series_begins_above_the_sticking_velocity():
    # One piece over log(v - 1) from log(1e-3) to 0, whose value is exp(0.5 log(v - 1) - 1).
    edges = np.array([math.log(NEAR), 0.0])
    pieces = Pieces(edges, np.array([[[0.5 * edges.mean() - 1.0, -0.25 * edges[0]]]]))
    table = lookup_table(pieces, 0, 0.5, 2.0, 1.0, sticking=1.0, below=-3.0, power=0.25)
    assert [value(v, table) for v in (0.5, 1.0)] == [-3.0, -3.0]
    assert math.isnan(value(2.1, table))
    assert value(1.04, table) == pytest.approx(0.2 / math.e, rel=1e-12)
    # Below the series a power of the excess goes on from its first value.
    first = math.sqrt(NEAR) / math.e
    assert value(1.0 + NEAR / 16.0, table) == pytest.approx(0.5 * first, rel=1e-9)


@pytest.mark.slow
def test_an_elastic_ball_has_a_closed_form(ball):
    loss = rs.solve(BALL, rtol=1e-5).radiated_energy
    sticks = math.sqrt(2.0 * loss)
    assert ball.sticking_velocity == pytest.approx(sticks, rel=3e-4)
    v = sticks * (1.0 + np.geomspace(2.0 * NEAR, 1.0 / sticks - 1.001, 60))
    exact = np.sqrt(1.0 - (sticks / v) ** 2)
    # That of the closed form is the error of the loss, 1e-5 of e at v = 0.3.
    allowed = ball.error["restitution_coefficient"] * np.maximum(1.0, 0.1 / exact) + 2e-4 / exact
    assert np.all(abs(ball(v) - exact) < allowed)
    assert ball.error["restitution_coefficient"] < 1e-2


@pytest.mark.slow
def test_nothing_rebounds_below_the_sticking_velocity(ball):
    slow = ball.sticking_velocity * np.array([0.6, 0.999, 1.0])
    assert ball(slow).tolist() == [0.0, 0.0, 0.0]
    assert np.all(np.isinf(ball.contact_time(slow)))
    assert np.all(np.isnan(ball.max_force(slow)))
    assert ball.compiled()(slow[0]) == 0.0
    # From there e rises without a step.
    steps = ball(ball.sticking_velocity * (1.0 + NEAR * np.array([1e-6, 0.25, 1.0 - 1e-9, 1.0 + 1e-9])))
    assert steps[1] == pytest.approx(0.5 * steps[2], rel=1e-3)
    assert steps[2] == pytest.approx(steps[3], rel=1e-6)
    assert steps[0] < 1e-2 * steps[1]


@pytest.mark.slow
def test_its_table_picture_and_summary_have_the_threshold(ball):
    table = ball.sample(50)
    assert np.array_equal(table.restitution_coefficient.values == 0.0, table.velocity.values < ball.sticking_velocity)
    assert f"sticks up to {ball.sticking_velocity:.5g} m/s" in str(ball.summary())
    assert ball.to_dict()["sticking_velocity"] == ball.sticking_velocity
    labels = [text.get_text() for text in ball.plot(["restitution_coefficient"]).axes[0].get_legend().get_texts()]
    assert labels[0].startswith("threshold")


@pytest.mark.slow
def test_the_file_keeps_the_threshold(ball, tmp_path):
    path = ball.save(tmp_path / "ball.json")
    again = rs.Surrogate.load(path)
    assert again.sticking_velocity == ball.sticking_velocity
    v = np.geomspace(*RANGE, 40).clip(*RANGE)
    assert np.array_equal(again(v), ball(v))
    content = json.loads(path.read_text())
    assert content["format_version"] == 3
    # Another sticking velocity does not fit its pieces.
    content |= {"sticking_velocity": 1.01 * ball.sticking_velocity}
    del content["sha256"]
    path.write_text(json.dumps(content | {"sha256": content_hash(content)}))
    assert in_one_line(lambda: rs.Surrogate.load(path)).field == "velocity"


def test_a_tolerance_that_adhesion_does_not_reach_is_refused():
    error = in_one_line(lambda: rs.surrogate(BALL, RANGE, rtol=9e-5))
    assert (error.field, error.value) == ("rtol", 9e-5)
    assert "must be in [0.0001, 0.01] with adhesion" in str(error)


@pytest.mark.slow
def test_ranges_without_the_threshold():
    fast = rs.surrogate(BALL, (0.1, 0.2), rtol=1e-2)
    assert fast.sticking_velocity == 0.0
    single = rs.solve(replace(BALL, velocity=0.15), rtol=1e-4).restitution_coefficient
    assert fast(0.15) == pytest.approx(single, abs=fast.error["restitution_coefficient"] + 1e-4)
    slow = in_one_line(lambda: rs.surrogate(BALL, (0.01, 0.03), rtol=1e-2))
    assert slow.field == "velocity"
    assert "CAPTURED" in str(slow)


@pytest.mark.slow
def test_a_surface_that_follows_a_slow_body_needs_few_pieces():
    """Contact times that end on a step, long after the last attraction, have no series."""
    material = rs.Material(rs.PronySeries(0.25, [0.25], [0.1]), bulk=math.inf)
    impact = replace(BALL, material=material, adhesion=rs.Adhesion(0.02, 0.3))

    def few(_: int, pieces: int) -> None:
        assert pieces < 10

    curve = rs.surrogate(impact, (0.2, 0.6), progress=few)
    assert max(curve.error.values()) < 1e-4


@pytest.mark.slow
def test_error_is_below_the_stated_error_at_other_velocities():
    rng = np.random.default_rng(5)
    moduli, times = 0.25 * 10.0 ** rng.uniform(-0.5, 0.7, 2), 10.0 ** rng.uniform(-1.0, 1.0, 2)
    material = rs.Material(rs.PronySeries(0.25, moduli, times), bulk=math.inf)
    impact = replace(BALL, material=material, adhesion=rs.Adhesion(0.01, float(rng.uniform(0.1, 0.4))))
    curve = rs.surrogate(impact, (0.01, 2.0), rtol=1e-2)
    assert curve.sticking_velocity > 0.01
    v = curve.sticking_velocity * (1.0 + 10.0 ** rng.uniform(-2.5, 0.5, 12))
    exact = rs.solve(replace(impact, velocity=v), rtol=1e-5)
    e = np.asarray(exact.restitution_coefficient)
    share = np.minimum(1.0, e / 0.1)
    assert np.all(share * abs(curve(v) - e) < curve.error["restitution_coefficient"])
    for name in ("contact_time", "max_force"):
        off = getattr(curve, name)(v) / np.asarray(getattr(exact, name)) - 1.0
        assert np.all(share * abs(off) < curve.error[name])
