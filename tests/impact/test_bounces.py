"""Bounces against free fall, constant e and energy conservation; how a series ends."""

import math
from dataclasses import replace

import numpy as np
import pytest

import restitution as rs
from refusals import refusal
from restitution import Bounces, FlatPunch, Material, Parabola, PronySeries, bounces, solve, standard_solid
from restitution.impact import closed_forms as cf
from restitution.impact.problem import STANDARD_GRAVITY, Body, Impact, drop

RUBBER = standard_solid(1e6, 1e6, 1e2, poisson_ratio=0.45, density=1200.0)
BALL, FLOOR = Body(RUBBER, radius=0.01), Body(None)
THROWN = drop(BALL, FLOOR, height=0.5)


def test_drop():
    impact = drop(BALL, FLOOR, height=0.5, gravity=8.0)
    assert impact.velocity == pytest.approx(math.sqrt(8.0), rel=1e-15)
    assert impact.external_force == pytest.approx(8.0 * BALL.mass, rel=1e-15)
    assert drop(BALL, FLOOR, height=0.5, with_weight=False).external_force == 0.0
    several = drop(BALL, FLOOR, height=[0.1, 0.2], gravity=[[1.6], [9.8]])
    assert several.shape == (2, 2)
    assert several.external_force.shape == (2, 1)


@pytest.mark.parametrize("with_weight", [True, False])
def test_elastic_ball_never_rests(with_weight):
    ball = Body(Material(1e8, 1e8, density=1200.0), radius=0.01)
    result = bounces(drop(ball, FLOOR, height=0.3), with_weight=with_weight, max_bounces=20)
    assert result.ended == "max bounces"
    assert result.n_bounces == 20
    assert result.height == pytest.approx(0.3, rel=1e-7)
    # A fall, then contacts and flights alternate.
    flight = 2.0 * math.sqrt(2.0 * 0.3 / STANDARD_GRAVITY)
    touches = 0.5 * flight + np.arange(20) * (flight + result.contact_time[0])
    assert result.touch_time == pytest.approx(touches, rel=1e-7)


def test_constant_restitution():
    """A flat punch on a stiff Kelvin-Voigt solid: constant e, negligible contact time and imprint."""
    damping, stiffness = 0.1, 8e12
    tau = 2.0 * damping / math.sqrt(stiffness)
    e = cf.flat_punch_kelvin_voigt_restitution(damping)
    hard = Impact(Material(PronySeries(1e12, parallel_viscosity=1e12 * tau), math.inf), FlatPunch(1.0), 1.0, 1.0)
    result = bounces(hard, height=2.0, gravity=10.0, with_weight=False, max_bounces=12, min_height=0.0)
    power = e ** np.arange(12)
    velocity = math.sqrt(40.0)
    # The effect of the imprint is g d/v^2, about g/(v omega) = 1e-6/power.
    assert result.velocity == pytest.approx(velocity * power, rel=2e-5)
    assert result.height == pytest.approx(2.0 * (e * power) ** 2, rel=1e-4)
    assert result.restitution_coefficient == pytest.approx(e, rel=1e-8)
    falls = math.sqrt(0.4) * np.concatenate([[1.0], 1.0 + 2.0 * np.cumsum(power[1:])])
    assert result.touch_time == pytest.approx(falls, rel=1e-5)
    assert result.ended == "max bounces"


def test_each_bounce_is_an_impact_and_each_flight_a_throw():
    result = bounces(drop(BALL, FLOOR, height=0.5), max_bounces=6)
    weight = STANDARD_GRAVITY * BALL.mass
    for n in range(6):
        alone = solve(Impact(RUBBER, Parabola(0.01), BALL.mass, result.velocity[n], external_force=weight))
        assert result.restitution_coefficient[n] == alone.restitution_coefficient
        assert result.residual_indentation_depth[n] == alone.residual_indentation_depth
    assert result.rebound_velocity == pytest.approx(result.velocity * result.restitution_coefficient, rel=1e-15)
    # The body rises from the depth at separation and falls to the undeformed surface.
    rise = result.rebound_velocity**2 / (2.0 * STANDARD_GRAVITY) - result.residual_indentation_depth
    assert result.height == pytest.approx(rise, rel=1e-13)
    assert result.velocity[1:] == pytest.approx(np.sqrt(2.0 * STANDARD_GRAVITY * result.height[:-1]), rel=1e-13)
    up = result.rebound_velocity[:-1] / STANDARD_GRAVITY
    down = result.velocity[1:] / STANDARD_GRAVITY
    gaps = np.diff(result.touch_time)
    assert gaps == pytest.approx(result.contact_time[:-1] + up + down, rel=1e-12)
    assert result.touch_time[0] == pytest.approx(math.sqrt(2.0 * 0.5 / STANDARD_GRAVITY), rel=1e-14)


def test_height_and_velocity_are_equivalent():
    impact = drop(BALL, FLOOR, height=0.5, gravity=3.7)
    by_height = bounces(replace(impact, velocity=17.0), height=0.5, gravity=3.7)
    by_velocity = bounces(impact, gravity=3.7)
    assert by_height.drop_height == pytest.approx(by_velocity.drop_height, rel=1e-15)
    assert by_height.height == pytest.approx(by_velocity.height, rel=1e-7)
    assert by_velocity.gravity == 3.7


# Ends


def test_weight_finally_captures_the_body():
    result = bounces(drop(BALL, FLOOR, height=0.5))
    assert result.ended == "captured"
    assert result.restitution_coefficient[-1] == 0.0
    assert result.contact_time[-1] == math.inf
    assert result.height[-1] == 0.0
    # At rest the relaxed half-space carries the weight: m g = (4/3) E* sqrt(R) d^(3/2) (Hertz).
    modulus, weight = 2.0 * 1e6 / (1.0 - 0.45), result.impact.external_force
    hertz = (0.75 * weight / (modulus * math.sqrt(0.01))) ** (2.0 / 3.0)
    assert result.residual_indentation_depth[-1] == pytest.approx(hertz, rel=1e-12)
    assert np.all(result.restitution_coefficient[:-1] > 0.0)
    assert np.all(np.diff(result.height) < 0.0)
    # The weight matters once the bounces are as low as the static depth.
    assert result.height[-2] < 1e-4


def test_without_weight_the_minimum_height_ends_the_series():
    result = bounces(drop(BALL, FLOOR, height=0.5), with_weight=False, min_height=1e-3)
    assert result.ended == "low"
    assert result.height[-1] < 1e-3 < result.height[-2]
    relative = bounces(drop(BALL, FLOOR, height=0.5), with_weight=False)
    assert relative.ended == "low"
    assert relative.height[-1] < 5e-7 < relative.height[-2]


def test_body_that_stays_in_its_imprint():
    # Slow recovery and a large loss: e v0 is too small to rise by the residual depth.
    lossy = Material(PronySeries(1e3, [1e3], [1.0], parallel_viscosity=300.0), math.inf)
    result = bounces(Impact(lossy, Parabola(0.1), 0.5, 1.0), height=0.01, with_weight=False)
    assert result.ended == "below surface"
    assert result.height[-1] < 0.0


def test_a_body_sinks_into_a_liquid():
    liquid = Material(PronySeries(0.0, parallel_viscosity=1.0), math.inf)
    result = bounces(Impact(liquid, FlatPunch(0.1), 1.0, 1.0), height=0.1, with_weight=False)
    assert result.ended == "sunk"
    assert result.n_bounces == 1


def test_a_stopped_series_is_the_head_of_the_whole_one():
    impact = drop(BALL, FLOOR, height=0.5)
    whole, calls = bounces(impact, max_bounces=6), iter([False, False, True])
    result = bounces(impact, stop=lambda: next(calls))
    assert (result.ended, result.n_bounces) == ("stopped", 3)
    assert next(calls, None) is None
    for name in result.to_dataset().variables:
        np.testing.assert_array_equal(result.to_dataset()[name], whole.to_dataset()[name][:3])
    assert (result.warnings, result.drop_height) == (whole.warnings, whole.drop_height)


def test_a_body_that_rests_is_not_stopped():
    liquid = Material(PronySeries(0.0, parallel_viscosity=1.0), math.inf)
    sinks = bounces(Impact(liquid, FlatPunch(0.1), 1.0, 1.0), height=0.1, with_weight=False, stop=lambda: True)
    assert (sinks.ended, sinks.n_bounces) == ("sunk", 1)


# Warnings and tables


def test_warning_about_incomplete_recovery():
    # The retardation time is 2 s; the flights take 0.1 to 0.6 s.
    slow = Material(PronySeries(1e6, [1e6], [1.0]), math.inf)
    result = bounces(Impact(slow, Parabola(0.01), 0.005, 1.0), height=0.1, max_bounces=5)
    flights = np.diff(result.touch_time) - result.contact_time[:-1]
    (warning,) = [words for words in result.warnings if words.startswith("recovery")]
    assert f"lasts {flights.min() / 2.0:.2g} of the longest retardation time" in warning
    # J(t) = (1 - exp(-t/theta)/2)/Einf: half of the creep is delayed.
    assert f"up to {50.0 * math.exp(-flights.min() / 2.0):.2g} %" in warning
    fast = Material(PronySeries(1e6, [1e6], [1e-4]), math.inf)
    quick = bounces(Impact(fast, Parabola(0.01), 0.005, 1.0), height=0.1, max_bounces=5)
    assert not [words for words in quick.warnings if words.startswith("recovery")]


def test_warning_about_imprints_in_a_liquid():
    liquid = Material(PronySeries(0.0, [1e7], [1.0]), math.inf)
    result = bounces(Impact(liquid, Parabola(0.01), 0.005, 1.0), height=0.1, max_bounces=3)
    assert result.n_bounces == 3
    assert any(words.startswith("recovery: the surface of a liquid") for words in result.warnings)


def test_assumptions_are_those_of_the_first_bounce():
    impact = drop(BALL, FLOOR, height=0.5)
    assert bounces(impact, max_bounces=2).warnings == solve(impact).warnings


def test_table():
    result = bounces(drop(BALL, FLOOR, height=0.5), max_bounces=4)
    table = result.to_dataset()
    assert table.bounce.values.tolist() == [1, 2, 3, 4]
    assert set(table.data_vars) == {
        "touch_time", "velocity", "restitution_coefficient", "rebound_velocity", "contact_time",
        "residual_indentation_depth", "height", "loss_tangent",
    }  # fmt: skip
    assert table.height.attrs["units"] == "m"
    assert table.height.values.tolist() == result.height.tolist()
    assert table.attrs == {"drop_height": result.drop_height, "gravity": STANDARD_GRAVITY, "ended": "max bounces"}
    assert isinstance(result, Bounces)


def test_the_loss_tangent_is_that_of_the_own_contact_time():
    # Of a standard solid of constant bulk: with x = omega tau, G1 x/(Ginf (1 + x^2) + G1 x^2).
    solid = standard_solid(1e6, 1e7, 1e4, poisson_ratio=0.5)
    result = bounces(Impact(solid, Parabola(0.01), 0.03, 0.5))
    lasts = result.contact_time[:-1]
    x = math.pi / lasts * 1e-3
    assert result.ended == "captured"
    assert result.loss_tangent[:-1] == pytest.approx(10.0 * x / (1.0 + x * x + 10.0 * x * x), rel=1e-9)
    assert math.isnan(result.loss_tangent[-1])


# Input


@pytest.mark.parametrize(
    ("call", "field", "value", "rule"),
    [
        (lambda: bounces(THROWN, height=0.0), "height", 0.0, ""),
        (lambda: bounces(THROWN, gravity=-9.81), "gravity", -9.81, ""),
        (lambda: bounces(THROWN, max_bounces=0), "max_bounces", 0, ""),
        (lambda: bounces(THROWN, max_bounces=2.5), "max_bounces", 2.5, ""),
        (lambda: bounces(THROWN, min_height=-1.0), "min_height", -1.0, ""),
        (lambda: bounces(THROWN, rtol=1.0), "rtol", 1.0, ""),
        (lambda: drop(FLOOR, BALL, height=1.0), "body.mass", math.inf, "must be finite for a body that falls"),
        (lambda: drop(BALL, Body(RUBBER, mass=1.0), height=1.0), "ground.mass", 1.0, "must be infinite for ground"),
        (lambda: drop(3, FLOOR, height=1.0), "body", 3, "must be a Body"),
        (lambda: bounces(BALL), "impact", BALL, "must be an Impact"),
        (lambda: bounces(replace(THROWN, external_force=0.0, impedance=5.0)), "with_weight", True, ""),
        (lambda: bounces(replace(THROWN, velocity=1e155)), "velocity", 1e155, "must be that of a fall from a finite"),
    ],
)
def test_bad_options_and_bodies(call, field, value, rule):
    error = refusal(call)
    assert (error.field, error.value) == (field, value)
    assert error.rule.startswith(rule)


def test_arrays_are_refused():
    error = refusal(lambda: bounces(drop(BALL, FLOOR, height=[0.1, 0.2])))
    assert (error.field, error.rule) == ("impact", "must be a single impact, not an array of shape (2,)")
    assert refusal(lambda: bounces(THROWN, height=[1.0, 2.0])).field == "height"


# Friction and spin

SUPERBALL = rs.vary(
    drop(Body(standard_solid(1e6, 1e6, 1e2, poisson_ratio=0.5), radius=0.02, mass=0.05), FLOOR, height=0.05),
    {"friction": 0.6, "tangential_velocity": 0.3, "spin": 25.0, "gyration": 0.45},
)


def test_angular_momentum_about_the_floor_is_kept():
    """v_x - kappa R w is that about the touched point over m; each bounce starts where the last one ended."""
    series = rs.bounces(SUPERBALL, max_bounces=5, rtol=1e-6)
    kept = [series.tangential_velocity - 0.45 * 0.02 * series.spin,
            series.rebound_tangential_velocity - 0.45 * 0.02 * series.rebound_spin]  # fmt: skip
    assert np.array(kept) == pytest.approx(0.3 - 0.45 * 0.02 * 25.0, abs=1e-12)
    assert series.spin[1:].tolist() == series.rebound_spin[:-1].tolist()
    third = rs.vary(SUPERBALL, {
        "velocity": series.velocity[2], "spin": series.spin[2], "tangential_velocity": series.tangential_velocity[2],
    })  # fmt: skip
    alone = rs.solve(third, rtol=1e-6)
    assert series.rebound_spin[2] == pytest.approx(alone.rebound_spin, rel=1e-12)
    assert series.height[2] == pytest.approx(bounces(replace(third, friction=None, tangential_velocity=0.0, spin=0.0),
                                                     max_bounces=1, rtol=1e-6).height[0], rel=1e-5)  # fmt: skip


def test_place_follows_the_momentum():
    """Between touches the centre moves with what the tangential force has left of its velocity."""
    series = rs.bounces(SUPERBALL, max_bounces=2, rtol=1e-6)
    history = rs.solve(rs.vary(SUPERBALL, {"velocity": series.velocity[0]}), rtol=1e-6).history
    time, force = history.time.values, history.tangential_force.values
    speed = 0.3 - np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(time))]) / 0.05
    flight = series.touch_time[1] - series.touch_time[0] - series.contact_time[0]
    expected = 0.3 * series.touch_time[0] + np.trapezoid(speed, time) + series.rebound_tangential_velocity[0] * flight
    # The motion is that of the finest march, which is off by up to 1e-5 of the velocity of the contact point.
    assert speed[-1] == pytest.approx(series.rebound_tangential_velocity[0], abs=1e-5)
    assert series.place == pytest.approx([0.3 * series.touch_time[0], expected], abs=1e-5 * series.contact_time[0])
    smooth = rs.bounces(rs.vary(SUPERBALL, {"friction": 0.0}), max_bounces=3)
    assert smooth.place == pytest.approx(0.3 * smooth.touch_time, rel=1e-12)
    assert smooth.rebound_spin.tolist() == [25.0] * 3


def test_bounces_with_spin_have_a_table_and_a_picture():
    series = rs.bounces(SUPERBALL, max_bounces=2, rtol=1e-4)
    assert len(series.plot().axes) == 3
    assert "spin" in str(series)
    assert series.to_dataset().place.attrs["units"] == "m"
    assert "travel" in {check.kind for check in series.validity}
    plain = bounces(THROWN, max_bounces=2)
    assert "spin" not in str(plain)


def test_friction_needs_a_fresh_surface_and_a_ball():
    assert refusal(lambda: bounces(SUPERBALL, same_spot=True)).field == "same_spot"
    cone = Impact(RUBBER, rs.Cone(1.2), mass=0.01, velocity=1.0, friction=0.1, tangential_velocity=0.1)
    assert refusal(lambda: bounces(cone)).field == "friction"
