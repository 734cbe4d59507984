"""Surrogates of impacts with friction, against closed forms and solves that were not used to build them."""

import copy
import json
import math
import pickle
from dataclasses import replace
from functools import partial

import numba
import numpy as np
import pytest

import restitution as rs
from cases import BALL
from refusals import in_one_line
from restitution.impact.batch import Batch
from restitution.impact.oblique import Sliders
from restitution.surrogates.oblique import E_T
from restitution.surrogates.velocity import content_hash

pytestmark = pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning")
THROWN = replace(BALL, friction=0.4, tangential_velocity=0.2)
RANGE = 0.1, 1.0
RTOL = 1e-3
KAPPA = 0.4


@pytest.fixture(scope="module")
def ball():
    return rs.surrogate(THROWN, RANGE, rtol=RTOL)


def drawn(n, seed=4):
    """Velocities, those of the contact point, and coefficients of friction, for slopes from 0 to 7."""
    rng = np.random.default_rng(seed)
    v = np.exp(rng.uniform(*np.log(RANGE), n)).clip(*RANGE)
    friction = np.exp(rng.uniform(math.log(0.03), math.log(3.0), n))
    return v, rng.uniform(-7.0, 7.0, n) * friction * v, friction


def test_error_is_below_the_stated_error_at_other_points(ball):
    v, along, friction = drawn(60)
    exact = rs.solve(replace(BALL, velocity=v, tangential_velocity=along, friction=friction), rtol=1e-5)
    approximate = ball.tangential_restitution_coefficient(v, along, friction=friction)
    off = np.abs(approximate - exact.tangential_restitution_coefficient)
    assert off.max() < ball.error[E_T] <= RTOL
    # In terms of the impulse errors count with the slope.
    ratio = ball.impulse_ratio(v, along, friction=friction)
    allowed = ball.error[E_T] * np.abs(along) / v
    assert np.all(np.abs(ratio - exact.impulse_ratio) < allowed)
    assert ball.error["restitution_coefficient"] <= 0.1 * RTOL
    after = ball.rebound(v, along, friction=friction)
    assert after.velocity == pytest.approx(exact.restitution_coefficient * v, rel=1e-4)
    assert after.tangential_velocity == pytest.approx(
        exact.rebound_tangential_velocity, abs=RTOL * np.abs(along).max()
    )


def test_a_rebound_keeps_the_angular_momentum_about_the_touched_point(ball):
    v, along, friction = drawn(40, seed=5)
    spin = np.random.default_rng(6).uniform(-100.0, 100.0, v.size)
    after = ball.rebound(v, along, spin, friction=friction)
    momentum = along - KAPPA * 0.01 * spin
    assert after.tangential_velocity - KAPPA * 0.01 * after.spin == pytest.approx(momentum, rel=1e-12, abs=1e-12)
    point = along + 0.01 * spin
    e_t = ball.tangential_restitution_coefficient(v, along, spin, friction=friction)
    assert e_t == pytest.approx(ball.tangential_restitution_coefficient(v, point, friction=friction), rel=1e-12)
    assert after.tangential_velocity + 0.01 * after.spin == pytest.approx(-e_t * point, abs=1e-12)


def test_full_sliding_has_its_closed_form(ball):
    v = np.geomspace(*RANGE, 20).clip(*RANGE)
    slope = ball.full_sliding(v) * np.array([[1.0 + 1e-12], [1.3], [20.0]])
    closed = -1.0 + 3.5 * (1.0 + ball(v)) / slope
    assert ball.tangential_restitution_coefficient(v, 0.4 * slope * v) == pytest.approx(closed, abs=1e-12)
    assert ball.impulse_ratio(v, -0.4 * slope * v) == pytest.approx(np.full(slope.shape, -0.4), rel=1e-12)
    smooth = ball.tangential_restitution_coefficient(v, 0.3, friction=0.0)
    assert smooth.tolist() == [-1.0] * v.size


def test_an_elastic_incompressible_ball_without_slip():
    # docs/theory/oblique.md: 0.10396736; full sliding from 4 chi - 1 = 1 in terms of psi = theta/1.5, with chi = 7/6.
    elastic = rs.Impact(
        rs.elastic(shear_modulus=1e6, poisson_ratio=0.5), rs.Parabola(0.01), 0.005, 1.0, friction=math.inf
    )
    curve = rs.surrogate(elastic, (0.5, 1.0), rtol=1e-3)
    assert curve.tangential_restitution_coefficient(0.7, 0.3) == pytest.approx(0.10396736, abs=1e-6)
    assert curve.full_sliding(0.7) == pytest.approx(1.5 * (4.0 * 7.0 / 6.0 - 1.0), rel=1e-9)
    assert curve.sliding.start == pytest.approx(1.5, rel=1e-9)


def test_marches_find_the_slope_of_full_sliding():
    # Where the ratio of the moduli is constant, theta = M (1 + e) - E*/G* e, with E*/G* = 3/2.
    ball = replace(BALL, material=rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.5))
    _, solution = Batch.from_impact(ball).solve_stored(1e-9)
    slider = Sliders(ball).on(0, solution)
    e = slider.impulse - 1.0
    expected = 3.5 * (1.0 + e) - 1.5 * e
    assert slider.sliding_slope(3.5) == pytest.approx(expected, rel=1e-9)
    assert replace(slider, rises=False).sliding_slope(3.5) == pytest.approx(expected, rel=1e-5)


def test_no_error_of_the_series_breaks_coulombs_law_or_gains_energy(ball):
    wrong = [part._replace(coefficients=3.0 * part.coefficients - 1.0) for part in ball.sliding[-2:]]
    high = [part._replace(coefficients=5.0 - part.coefficients) for part in ball.sliding[-2:]]
    v, along, friction = drawn(2000, seed=8)
    for sticks, slips in (wrong, high, ball.sliding[-2:]):
        bad = replace(ball, sliding=ball.sliding._replace(sticks=sticks, slips=slips))
        assert np.abs(bad.tangential_restitution_coefficient(v, along, friction=friction)).max() <= 1.0
        ratio = np.abs(bad.impulse_ratio(v, along, friction=friction))
        assert np.all(ratio <= friction * (1.0 + 1e-12))


def test_a_compiled_function_gives_the_same(ball):
    v, along, friction = drawn(50, seed=9)
    function = ball.compiled(E_T)
    callback = numba.cfunc("float64(float64, float64, float64)")(lambda v, c, mu: function(v, c, mu))
    expected = ball.tangential_restitution_coefficient(v, along, friction=friction)
    assert [callback.ctypes(*row) for row in zip(v, along, friction, strict=True)] == expected.tolist()
    assert math.isnan(function(2.0, 0.1, 0.4))
    assert math.isnan(function(0.5, 0.1, -0.4))
    assert ball.compiled()(0.5) == ball(0.5)


def test_file_copy_and_pickle_give_the_same(ball, tmp_path):
    v, along, friction = drawn(50, seed=10)
    path = ball.save(tmp_path / "thrown.json")
    assert json.loads(path.read_text())["format_version"] == 4
    for again in (rs.Surrogate.load(path), copy.deepcopy(ball), pickle.loads(pickle.dumps(ball))):
        assert isinstance(again, rs.ObliqueSurrogate)
        assert again.to_dict() == ball.to_dict()
        for name in ("tangential_restitution_coefficient", "impulse_ratio"):
            results = (getattr(each, name)(v, along, friction=friction) for each in (again, ball))
            assert np.array_equal(*results)
        assert np.array_equal(again.rebound(0.5, 0.1, 3.0), ball.rebound(0.5, 0.1, 3.0))


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"friction": -1.0}, "friction"),
        ({"gyration": 0.0}, "gyration"),
        ({"sliding": {"start": -1.0}}, "sliding.start"),
        ({"sliding": {"pull": "1e999"}}, "sliding.pull"),
        ({"sliding": {"log_velocity_edges": [-1.0, 0.0]}}, "sliding"),
        ({"sliding": {"slips": {"places": [[1, 0]]}}}, "sliding.slips"),
        ({"sliding": {"sticks": {"low": [-1.0, 0.0]}}}, "sliding"),
        ({"sliding": {"sticks": {"low": [-3.0, 0.1]}}}, "sliding"),
    ],
)
def test_other_files_are_refused_in_one_line(ball, tmp_path, change, field):
    path = ball.save(tmp_path / "thrown.json")
    content = json.loads(path.read_text())
    _merge(content, change)
    del content["sha256"]
    path.write_text(json.dumps(content | {"sha256": content_hash(content)}))
    error = in_one_line(lambda: rs.Surrogate.load(path))
    assert (error.field, error.where) == (field, str(path))


def _merge(content, change):
    for name, part in change.items():
        if isinstance(part, dict):
            _merge(content[name], part)
        else:
            content[name] = part


def test_bad_arguments_are_refused_in_one_line(ball):
    e_t = ball.tangential_restitution_coefficient
    for call, field in (
        (partial(e_t, 2.0, 0.1), "velocity"),
        (partial(e_t, 0.5, math.nan), "tangential_velocity"),
        (partial(e_t, 0.5, 0.1, math.inf), "spin"),
        (partial(e_t, 0.5, 0.1, friction=-0.1), "friction"),
        (partial(e_t, [0.5, 0.6], [0.1, 0.2, 0.3]), "velocity, tangential_velocity, friction"),
        (partial(ball.compiled, "spin"), "output"),
        (partial(replace(ball, radius=math.nan).rebound, 0.5, 0.1, 3.0), "spin"),
        (partial(rs.surrogate, replace(THROWN, friction=[0.1, 0.2]), RANGE), "impact"),
    ):
        assert in_one_line(call).field == field


def test_its_table_has_both_ends_of_sliding(ball):
    text = " ".join(str(ball.summary()).split())
    assert f"{ball.tangential_restitution_coefficient(RANGE[1], 0.0):.8g}" in text
    assert f"{ball.full_sliding(RANGE[0]):.8g}" in text
    assert "tangential restitution coefficient" in text
    # The friction of the impact is small beside Dundurs' parameter.
    assert any(line.startswith("coupling") for line in ball.warnings)


def test_a_tolerance_that_e_t_does_not_reach_is_refused():
    error = in_one_line(lambda: rs.surrogate(THROWN, RANGE, rtol=9e-6))
    assert error.field == "rtol"
    assert "must be in [1e-05, 0.01] with friction" in str(error)


@pytest.mark.slow
def test_other_bodies_and_a_constant_force():
    polymer = rs.standard_solid(3e6, 1e8, 1e4, poisson_ratio=0.2)
    for impact in (
        replace(THROWN, counter_material=polymer),
        replace(THROWN, external_force=0.02),
        replace(THROWN, profile=rs.Cone(1.2), gyration=10.0),
    ):
        curve = rs.surrogate(impact, (0.3, 1.0), rtol=RTOL)
        v, along, friction = drawn(30, seed=11)
        v = v.clip(0.3)
        exact = rs.solve(replace(impact, velocity=v, tangential_velocity=along, friction=friction), rtol=1e-5)
        approximate = curve.tangential_restitution_coefficient(v, along, friction=friction)
        assert np.abs(approximate - exact.tangential_restitution_coefficient).max() < curve.error[E_T] <= RTOL
        ratio = curve.impulse_ratio(v, along, friction=friction)
        assert np.all(np.abs(ratio - exact.impulse_ratio) < 2.0 * RTOL * np.abs(along) / v)
