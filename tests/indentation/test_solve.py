"""Indentations compared with closed forms, and refused input."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import restitution as rs
from restitution import IndentationStatus, Material, PronySeries, Tabulated, indent, reduced_modulus
from restitution.contact.profiles import Cone, FlatPunch, Parabola, PowerLaw, Sphere, TruncatedCone
from restitution.errors import ABSENT, InputError
from restitution.indentation.history import hold, ramp, sine_arch, triangle

# E(t) = 200 + 800 exp(-t/0.3) Pa in tension, incompressible.
GEL = Material(PronySeries(200.0 / 3.0, [800.0 / 3.0], [0.3]), math.inf)
TIP = Parabola(2.5e-6)
ELASTIC = Material(1.0, 2.0)
ELASTIC_MODULUS = 4.0 * 7.0 / 10.0
PROFILES = [Parabola(2.0), Cone(1.1), PowerLaw(3.3, 0.2), FlatPunch(0.4), Sphere(2.0), TruncatedCone(0.3, 1.0)]


def half_space(series):
    """Incompressible half-space whose reduced modulus E* = 4 G is this series."""
    return Material(series.scaled(0.25), math.inf)


def names(profile):
    return type(profile).__name__


@pytest.mark.plain
def test_the_gel_under_an_afm_tip():
    """Two forces to nine digits by quadrature in another program; the end of contact from its equation."""
    result = indent(GEL, TIP, depth=triangle(1e-6, 1.0), time=[1.0, 1.25])
    assert result.max_force == pytest.approx(1.38541713e-9, rel=3.6e-9)
    assert result.force == pytest.approx([1.38541713e-9, 2.32146714e-10], rel=2e-9)

    def elongation(t):
        return 200.0 * t + 800.0 * 0.3 * (1.0 - math.exp(-t / 0.3))

    # int_0^t E(t - t') d' dt' = 0
    end = brentq(lambda t: elongation(t) - 2.0 * elongation(t - 1.0), 1.1, 1.9, xtol=1e-15)
    assert end == pytest.approx(1.41, abs=0.005)
    assert result.contact_end_time == pytest.approx(end, rel=1e-13)
    assert result.status == IndentationStatus.SEPARATED
    # The same history as points, as a function and as a thousand samples.
    t = np.linspace(0.0, 2.0, 1001)
    for depth, time in (
        ([0.0, 1e-6, 0.0], [0.0, 1.0, 2.0]),
        (lambda t: 1e-6 * (1.0 - abs(t - 1.0)), t),
        (1e-6 * (1.0 - np.abs(t - 1.0)), t),
    ):
        again = indent(GEL, TIP, depth=depth, time=time)
        assert again.time.size == len(time)
        assert again.contact_end_time == pytest.approx(result.contact_end_time, rel=1e-12)
        assert again.sample([1.25]).force.item() == pytest.approx(result.force[1], rel=1e-10)


@pytest.mark.parametrize("profile", PROFILES, ids=names)
@pytest.mark.parametrize("history", [triangle(0.5, 1.0, hold_time=0.5), sine_arch(0.5, 2.0)])
def test_elastic_bodies_follow_hertz_both_ways(profile, history):
    result = indent(ELASTIC, profile, depth=history)
    force = 2.0 * ELASTIC_MODULUS * profile.force_integral_at_depth(np.maximum(result.indentation_depth, 0.0))
    assert result.force == pytest.approx(force, abs=1e-13 * force.max())
    assert result.contact_end_time == pytest.approx(history.stop, rel=1e-12)
    assert abs(result.dissipated) <= 1e-8 * force.max() * 0.5
    assert abs(result.stored) <= 1e-8 * force.max() * 0.5
    # The inverse: the depth under this force.
    peak = float(force.max())
    expected = indent(ELASTIC, profile, force=triangle(peak, 1.0), time=[0.25, 1.0, 1.6])
    forces = 2.0 * ELASTIC_MODULUS * profile.force_integral_at_depth(expected.indentation_depth)
    assert forces == pytest.approx(peak * np.array([0.25, 1.0, 0.4]), rel=1e-11)
    radii = profile.contact_radius(expected.indentation_depth)
    assert expected.contact_radius == pytest.approx(radii, rel=1e-11)


@pytest.mark.plain
@pytest.mark.parametrize("profile", PROFILES, ids=names)
def test_a_held_depth_relaxes(profile):
    series = PronySeries(1.0, [3.0, 2.0], [0.05, 4.0])
    time = np.array([0.0, 0.01, 0.4, 5.0])
    result = indent(half_space(series), profile, depth=0.5, time=time)
    assert result.force == pytest.approx(
        2.0 * series.relaxation_modulus(time) * float(profile.force_integral_at_depth(0.5)), rel=1e-11
    )
    assert result.status == IndentationStatus.IN_CONTACT
    assert math.isinf(result.contact_end_time)
    # The work of the step is elastic, and the springs of the branches relax with the rates 2/tau_k.
    elastic = result.work / series.instantaneous_modulus
    left = series.equilibrium_modulus + float(series.branch_moduli @ np.exp(-2.0 * 5.0 / series.relaxation_times))
    assert result.stored == pytest.approx(elastic * left, rel=1e-8)
    assert result.dissipated == pytest.approx(elastic * (series.instantaneous_modulus - left), rel=1e-8)
    assert math.isnan(result.residual_indentation_depth)
    assert result.max_force == pytest.approx(result.force[0], rel=1e-14)


@pytest.mark.plain
@pytest.mark.parametrize(
    "series",
    [
        PronySeries(1.0, [3.0, 2.0], [0.05, 4.0]),
        PronySeries(0.0, [3.0, 2.0], [0.05, 4.0]),
        PronySeries(1.0, [3.0], [0.05], parallel_viscosity=0.5),
        PronySeries(1.0, parallel_viscosity=0.5),
        PronySeries(0.0, [3.0], [2.0]),
        PronySeries(0.0, parallel_viscosity=2.0),
    ],
    ids=["solid", "liquid", "damped", "Kelvin-Voigt", "Maxwell", "Newton"],
)
def test_a_held_force_creeps(series):
    """a^3 = (3 R/4) F J*(t)."""
    time = np.array([0.0, 1e-3, 0.1, 3.0, 40.0])
    result = indent(half_space(series), Parabola(2.0), force=0.01, time=time)
    cubed = 0.75 * 2.0 * 0.01 * series.creep_compliance(time)
    assert result.contact_radius**3 == pytest.approx(cubed, rel=1e-11, abs=1e-16)
    assert result.indentation_depth == pytest.approx(result.contact_radius**2 / 2.0, rel=1e-12)
    assert result.force == pytest.approx(0.01, rel=1e-15)
    # A punch: d = F J*/(2 a).
    punch = indent(half_space(series), FlatPunch(0.4), force=0.01, time=time)
    assert punch.indentation_depth == pytest.approx(0.01 * series.creep_compliance(time) / 0.8, rel=1e-11, abs=1e-16)
    assert punch.contact_radius == pytest.approx(0.4, rel=1e-14)


@pytest.mark.plain
def test_a_cone_on_a_maxwell_liquid():
    """Everything in closed form: the approach, the instant of equal radius, the end."""
    tau, speed = 0.7, 0.2
    cone = Cone(1.2)
    slope = float(cone.contact_radius(1.0))
    result = indent(half_space(PronySeries(0.0, [5.0], [tau])), cone, depth=triangle(speed, 1.0))

    def approach(t):
        return 2.0 * 5.0 * slope * speed**2 * (tau * t - tau**2 * -np.expm1(-t / tau))

    end = tau * math.log(2.0 * math.exp(1.0 / tau) - 1.0)
    assert result.contact_end_time == pytest.approx(end, rel=1e-13)
    t = np.linspace(0.01, 1.0, 20)
    assert result.sample(t).force.values == pytest.approx(approach(t), rel=1e-10, abs=1e-12)
    t = np.linspace(1.001, 0.999 * end, 20)
    equal = t + tau * np.log(2.0 * np.exp(-(t - 1.0) / tau) - 1.0)
    retract = result.sample(t)
    assert retract.contact_radius.values == pytest.approx(slope * speed * equal, rel=1e-11)
    assert retract.force.values == pytest.approx(np.exp(-(t - equal) / tau) * approach(equal), rel=1e-9)


@pytest.mark.plain
def test_a_parabola_on_kelvin_voigt():
    """F = 2 (E Pi + eta a d') inward; outward E d1 = E d + eta d', F = 2 E Pi(d1)."""
    modulus, eta, speed = 3.0, 0.6, 0.2
    tip = Parabola(2.0)
    result = indent(half_space(PronySeries(modulus, parallel_viscosity=eta)), tip, depth=triangle(speed, 1.0))
    t = np.linspace(0.0, 0.999, 20)
    inward = 2.0 * (modulus * tip.force_integral_at_depth(speed * t) + eta * tip.contact_radius(speed * t) * speed)
    assert result.sample(t).force.values == pytest.approx(inward, rel=1e-12, abs=1e-14)
    assert result.contact_end_time == pytest.approx(2.0 - eta / modulus, rel=1e-14)
    t = np.linspace(1.0, 1.79, 20)
    equal = speed * (2.0 - t) - eta / modulus * speed
    outward = result.sample(t)
    assert outward.force.values == pytest.approx(2.0 * modulus * tip.force_integral_at_depth(equal), rel=1e-11)
    assert outward.contact_radius.values == pytest.approx(tip.contact_radius(equal), rel=1e-11)
    # The force falls at once as the motion turns.
    assert result.max_force == pytest.approx(
        2.0 * (modulus * float(tip.force_integral_at_depth(0.2)) + eta * math.sqrt(0.4) * speed), rel=1e-12
    )


@pytest.mark.plain
@pytest.mark.parametrize("start", [0.0, 0.3])
def test_the_velocity_at_first_touch_is_the_limit_behind_it(start):
    """F = 2 eta a d' on a Newtonian liquid: for F = f t and a cone a = A d, d' = sqrt(f/(2 eta A)) at all times.

    Under a parabola d ~ t^(4/3), and on an elastic body d ~ t^(2/3), under a cone t^(1/2).
    """
    liquid = half_space(PronySeries(0.0, parallel_viscosity=2.0))
    force = rs.History.from_points([start - 1.0, start, start + 1.0], [0.0, 0.0, 0.01])
    cone = indent(liquid, Cone(1.1), force=force).sample([start, start + 0.7])
    assert cone.indentation_velocity.values == pytest.approx(
        [math.sqrt(0.01 / (4.0 * Cone(1.1).stiffness_radius(1.0)))] * 2, rel=1e-12
    )
    for material, profile, velocity in [
        (liquid, Parabola(2.0), 0.0),
        (GEL, Parabola(2.0), math.inf),
        (GEL, Cone(1.1), math.inf),
        (GEL, Sphere(2.0), math.inf),
    ]:
        result = indent(material, profile, force=force)
        assert result.indentation_velocity[result.time == start] == [velocity]
        assert np.isfinite(result.indentation_velocity[result.time > start]).all()


@pytest.mark.parametrize(("name", "peak"), [("depth", 1e-3), ("force", 0.01)])
def test_no_instant_has_two_rows(name, peak):
    """Knots, the turning point of a fitted function, and even times differ by rounding."""
    for duration in (0.6, 1.8, 1.9):
        result = indent(GEL, Parabola(2.0), **{name: sine_arch(peak, duration)})
        assert np.diff(result.time).min() > 1e-6 * duration
        assert set(result.prescribed_history.knots) <= set(result.time)


def test_a_newtonian_liquid_separates_at_the_turning_point():
    result = indent(half_space(PronySeries(0.0, parallel_viscosity=2.0)), Parabola(2.0), depth=triangle(0.2, 1.0))
    t = np.array([0.1, 0.5, 0.999])
    assert result.sample(t).force.values == pytest.approx(2.0 * 2.0 * np.sqrt(0.4 * t) * 0.2, rel=1e-12)
    assert result.contact_end_time == pytest.approx(1.0, rel=1e-14)


@pytest.mark.plain
def test_a_punch_separates_where_its_force_vanishes():
    """F = 2 a int E* dd, with one constant contact radius."""
    series, tau = PronySeries(1.0, [4.0], [0.5]), 0.5
    result = indent(half_space(series), FlatPunch(0.4), depth=triangle(0.1, 1.0))

    def step(t):
        return t + 4.0 * tau * -np.expm1(-t / tau)

    def load(t):
        return 0.8 * 0.1 * (step(t) - 2.0 * step(np.maximum(t - 1.0, 0.0)))

    end = brentq(load, 1.0, 2.0, xtol=1e-15)
    assert result.contact_end_time == pytest.approx(end, rel=1e-13)
    t = np.linspace(0.0, 0.999 * end, 30)
    assert result.sample(t).force.values == pytest.approx(load(t), rel=1e-10, abs=1e-12)
    assert np.all(result.contact_radius[(result.time > 0.0) & (result.time < end)] == 0.4)
    assert np.all(result.force[result.time >= end] == 0.0)


@pytest.mark.plain
def test_both_bodies_may_deform():
    soft, hard = (Material(PronySeries(1.0, [2.0], [0.3]), 2.0), Material(PronySeries(3.0, [1.0], [2.0]), math.inf))
    result = indent(soft, Parabola(2.0), depth=0.1, time=[0.0, 0.5, 3.0], counter_material=hard)
    series = reduced_modulus(soft, hard)
    assert result.force == pytest.approx(
        2.0 * series.relaxation_modulus(result.time) * 2.0 / 3.0 * math.sqrt(2.0) * 0.1**1.5, rel=1e-11
    )


def test_a_tabulated_parabola():
    r = np.linspace(0.0, 2e-6, 401)
    result = indent(GEL, Tabulated(r, r**2 / 5e-6), depth=triangle(5e-7, 1.0))
    exact = indent(GEL, TIP, depth=triangle(5e-7, 1.0))
    assert result.error >= result.rtol
    # Between its points the table deviates slightly from the parabola.
    assert result.max_force == pytest.approx(exact.max_force, rel=1e-5)
    assert result.contact_end_time == pytest.approx(exact.contact_end_time, rel=1e-12)


@pytest.mark.parametrize("rtol", [1e-2, 1e-4, 1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("name", ["depth", "force"])
def test_tolerances_are_kept(rtol, name):
    peak = 0.1 if name == "depth" else 0.3
    tip, material = Parabola(1.0), half_space(PronySeries(1.0, np.full(8, 2.0), np.geomspace(1e-3, 1e2, 8)))
    t = np.linspace(0.0, 3.0, 200)
    history = {name: sine_arch(peak, 3.0) if name == "depth" else triangle(peak, 1.0, unloading_time=2.0)}
    loose, tight = (indent(material, tip, time=t, rtol=r, **history) for r in (rtol, 1e-11))
    for column in ("force", "indentation_depth", "contact_radius"):
        expected = getattr(tight, column)
        assert np.abs(getattr(loose, column) - expected).max() <= rtol * expected.max()


def test_no_force_before_touch():
    result = indent(GEL, TIP, depth=[-1e-6, 1e-6, -1e-6], time=[-1.0, 1.0, 3.0])
    same = indent(GEL, TIP, depth=triangle(1e-6, 1.0))
    assert result.contact_end_time == pytest.approx(same.contact_end_time, rel=1e-12)
    assert result.max_force == pytest.approx(same.max_force, rel=1e-12)
    early = result.sample([-1.0, -0.5])
    assert early.indentation_depth.values == pytest.approx([-1e-6, -5e-7], rel=1e-12)
    assert early.indentation_velocity.values == pytest.approx(1e-6, rel=1e-12)
    assert not early.force.values.any()
    assert not early.contact_radius.values.any()


@pytest.mark.plain
def test_the_recovering_surface_reaches_a_tip_that_waits():
    """After the contact the gel recovers as exp(-t/tau'), tau' = 1.5 s, and its surface touches a slow tip again."""
    # The tip moves back fast to a hundredth of the depth and stays there.
    fast = 0.02
    result = indent(GEL, TIP, depth=[0.0, 1e-6, 1e-8, 1e-8], time=[0.0, 1.0, 1.0 + fast, 30.0])
    speed = (1e-6 - 1e-8) / fast

    def load(t):
        def step(x):
            return 200.0 * x + 240.0 * (1.0 - math.exp(-x / 0.3))

        return 1e-6 * (step(t) - step(t - 1.0)) - speed * step(t - 1.0)

    end = brentq(load, 1.0, 1.0 + fast, xtol=1e-16)
    left = 1e-6 - speed * (end - 1.0)
    met = end + 1.5 * math.log(left / 1e-8)
    assert result.contact_intervals == pytest.approx(np.array([[0.0, end], [met, math.inf]]), rel=1e-8)
    assert result.status == IndentationStatus.IN_CONTACT


@pytest.mark.plain
def test_the_recovering_surface_reaches_a_tip_after_a_step():
    """After a step out of contact from the load L, the surface springs back by L/E0 and then recovers slowly."""
    result = indent(GEL, TIP, depth=[0.0, 1e-6, 9e-7, 1e-7, 1e-7], time=[0.0, 1.0, 1.2, 1.2, 9.0])
    lag = 1e-6 * 0.3 * (1.0 - math.exp(-1.0 / 0.3)) * math.exp(-0.2 / 0.3) - 5e-7 * 0.3 * (1.0 - math.exp(-0.2 / 0.3))
    left = 9e-7 - (200.0 * 9e-7 + 800.0 * lag) / 1000.0
    met = 1.2 + 1.5 * math.log(left / 1e-7)
    assert result.contact_intervals == pytest.approx(np.array([[0.0, 1.2], [met, math.inf]]), rel=1e-8)
    # A tip beyond the undeformed surface does not touch again.
    assert indent(GEL, TIP, depth=[0, 1e-6, 9e-7, 0, 0], time=[0, 1, 1.2, 1.2, 9]).contact_end_time == pytest.approx(
        1.2
    )


@pytest.mark.plain
def test_a_punch_may_be_loaded_again():
    """The contact radius is constant, so that superposition holds for any history."""
    series = PronySeries(1.0, [4.0], [0.5])
    time, depth = np.array([0.0, 1.0, 1.5, 2.0]), np.array([0.0, 0.1, 0.08, 0.12])
    result = indent(half_space(series), FlatPunch(0.4), depth=depth, time=time)

    def step(t):
        t = np.maximum(t, 0.0)
        return t + 4.0 * 0.5 * -np.expm1(-t / 0.5)

    t = np.linspace(0.0, 2.0, 21)
    slopes = np.diff(depth) / np.diff(time)
    expected = 0.8 * (
        slopes[0] * step(t) + (slopes[1] - slopes[0]) * step(t - 1.0) + (slopes[2] - slopes[1]) * step(t - 1.5)
    )
    assert result.sample(t).force.values == pytest.approx(expected, rel=1e-11, abs=1e-14)


@pytest.mark.plain
@pytest.mark.parametrize(
    ("arguments", "field", "value"),
    [
        ({}, "depth, force", ABSENT),
        ({"depth": ramp(1e-6, 1.0), "force": ramp(1.0, 1.0)}, "depth, force", ABSENT),
        ({"depth": [0.0, 1e-6]}, "time", ABSENT),
        ({"force": 1e-9}, "time", ABSENT),
        ({"force": -1e-9, "time": [0.0, 1.0]}, "force", -1e-9),
        ({"depth": [0.0, np.nan], "time": [0.0, 1.0]}, "depth", math.nan),
        ({"depth": [5e-9, 2e-6], "time": [0.0, 1.0]}, "depth", 5e-9),
        ({"depth": [-2e-6, -1e-6], "time": [0.0, 1.0]}, "depth", -1e-6),
        ({"force": [0.0, 1e-9, -1e-9], "time": [0.0, 1.0, 2.0]}, "force", -1e-9),
        ({"depth": [0.0, 1e-7, 1e-6, 1e-6], "time": [0.0, 1.0, 1.0 + 1e-9, 2.0]}, "time", 1.0),
        ({"depth": ramp(1e-6, 1.0), "time": [0.0, 2.0]}, "time", 2.0),
        ({"depth": ramp(1e-6, 1.0), "rtol": 1e-13}, "rtol", 1e-13),
        ({"depth": 1e300, "time": [0.0, 1.0]}, "depth", 1e300),
        ({"depth": 1e-300, "time": [0.0, 1.0]}, "depth", 1e-300),
        ({"force": 1e200, "time": [0.0, 1.0]}, "force", 1e200),
    ],
)  # fmt: skip
def test_bad_input_is_refused_in_one_line(arguments, field, value):
    with pytest.raises(InputError) as caught:
        indent(GEL, TIP, **arguments)
    assert caught.value.field == field
    assert caught.value.value is value or caught.value.value == pytest.approx(value, nan_ok=True)
    assert "\n" not in str(caught.value)


def test_a_force_that_jumps_over_a_hundred_decades_is_refused_at_once():
    force, time = [0.0, 0.02, 2e98, 0.01, 0.0], [0.0, 0.01, 10.0, 10.01, 40.0]
    material = rs.library.polyisobutylene
    with pytest.raises(InputError, match=r"^history: .*steep") as caught:
        indent(material, rs.FlatEndedParabola(5e-3, 0.2e-3), force=force, time=time, rtol=1e-6)
    assert "\n" not in str(caught.value)


@pytest.mark.plain
def test_a_depth_that_starts_below_the_surface_is_refused():
    with pytest.raises(InputError, match="contact point"):
        indent(GEL, TIP, depth=[5e-9, 1e-6, 0.0], time=[0.0, 1.0, 2.0])


@pytest.mark.parametrize("number", [np.float32(0.5), np.array(0.5), np.int64(1)], ids=["float32", "0-d", "int64"])
def test_one_number_of_any_kind_is_held(number):
    body = Material(1.0, 2.0)
    expected = indent(body, Parabola(1.0), depth=float(number), time=[0.0, 1.0]).max_force
    assert indent(body, Parabola(1.0), depth=number, time=[0.0, 1.0]).max_force == expected


def test_functions_that_return_no_numbers():
    with pytest.raises(TypeError, match=r"depth = .*must be a real number"):
        indent(GEL, TIP, depth=lambda t: "a", time=[0.0, 1.0])


@pytest.mark.plain
def test_wrong_profiles_and_materials():
    loading = {"depth": ramp(1e-6, 1.0)}
    r = np.linspace(0.0, 1e-6, 101)
    short = Tabulated(r, r**2 / 5e-6)
    deepest = f"{float(short.max_depth):g} m"
    damped = half_space(PronySeries(1.0, parallel_viscosity=1.0))
    for field, words, call in (
        ("material", "Material", lambda: indent(3, TIP, **loading)),
        (
            "material",
            "within",
            lambda: indent(rs.FractionalMaterial(rs.springpot(1.0, 0.5), math.inf), TIP, **loading),
        ),
        ("profile", "Geometry", lambda: indent(GEL, 3, **loading)),
        ("counter_material", "Material", lambda: indent(GEL, TIP, counter_material=3, **loading)),
        ("profile", "one profile", lambda: indent(GEL, Parabola([1.0, 2.0]), **loading)),
        ("profile", "one profile", lambda: indent(GEL, Parabola([1.0, 2.0]), force=ramp(1e-9, 1.0))),
        ("depth", deepest, lambda: indent(GEL, short, **loading)),
        ("force", deepest, lambda: indent(GEL, short, force=ramp(1e-9, 1.0))),
        ("depth", "dashpot", lambda: indent(damped, TIP, depth=hold(1e-6, 1.0))),
        ("time", "must last between", lambda: indent(GEL, TIP, depth=ramp(1e-6, 1e-320))),
    ):
        with pytest.raises(InputError, match=words) as caught:
            call()
        assert caught.value.field == field


def test_public_names():
    assert rs.indent is indent
    assert rs.triangle is triangle
    result = rs.indent(GEL, TIP, depth=rs.triangle(1e-6, 1.0))
    assert isinstance(result, rs.IndentationResult)
    assert result.status is rs.IndentationStatus.SEPARATED


@pytest.mark.plain
def test_fast_modes_after_a_kink_of_the_force():
    """Depth and radius just after the force stops rising, with modes ten thousand times faster than the contact."""
    series = PronySeries(0.25, [0.5, 17.0, 2.0], [2e-5, 0.3, 7.0])
    history = triangle(1.0, 1.0, unloading_time=0.8, hold_time=1.0)
    t = np.concatenate([1.0 + np.geomspace(1e-6, 1.0, 30), np.linspace(2.0, 2.8, 40)])
    expected = indent(half_space(series), Parabola(1.0), force=history, time=t, rtol=1e-11)
    # While the contact grows, a^3 = (3 R/4) int J* dF in closed form.
    creep = series.retardation
    total = creep.instantaneous_compliance * np.minimum(t, 1.0)
    for compliance, tau in zip(creep.branch_compliances, creep.retardation_times, strict=True):
        ramp_part = tau * (np.exp(-(t - 1.0) / tau) - np.exp(-t / tau))
        total += compliance * (1.0 - ramp_part)
    growing = t <= 2.0
    assert growing.sum() >= 30
    assert expected.contact_radius[growing] ** 3 == pytest.approx(0.75 * total[growing], rel=1e-11)
    for rtol in (1e-4, 1e-8):
        loose = indent(half_space(series), Parabola(1.0), force=history, time=t, rtol=rtol)
        for name in ("indentation_depth", "contact_radius"):
            exact = getattr(expected, name)
            assert np.abs(getattr(loose, name) - exact).max() <= rtol * exact.max()


@pytest.mark.parametrize("name", ["depth", "force"])
@pytest.mark.parametrize(
    ("time", "values"),
    [
        ([0.0, 0.8, 0.8, 1.6], [0.0, 0.5, 0.02, 0.0]),
        ([0.0, 0.3, 0.3, 0.9, 1.5], [0.0, 0.1, 0.4, 0.5, 0.0]),
        ([0.0, 0.0, 0.6, 1.0, 1.0, 1.4], [0.0, 0.3, 0.3, 0.2, 0.1, 0.0]),
    ],
    ids=["out at once", "further in", "in and half out"],
)
def test_a_step_is_the_limit_of_a_ramp(name, time, values):
    material, tip = half_space(PronySeries(1.0, [3.0, 6.0], [0.4, 5.0])), PowerLaw(3.0, 1.0)
    width = 1e-6
    late = np.array(time) + width * np.cumsum(np.diff(time, prepend=-1.0) == 0.0)
    step = indent(material, tip, time=time, **{name: values})
    ramped = indent(material, tip, time=late, **{name: values})
    for quantity in ("work", "max_force", "max_indentation_depth", "contact_end_time", "max_contact_radius"):
        # The difference is of the order of the width of the ramp.
        assert getattr(step, quantity) == pytest.approx(getattr(ramped, quantity), rel=2e-5, abs=2e-6), quantity
    t = np.linspace(0.05, 1.35, 14)
    steps = np.array(time)[1:][np.diff(time) == 0.0]
    behind = t + width * np.sum(t[:, None] > steps, axis=1)
    for quantity in ("force", "indentation_depth"):
        sampled, expected = step.sample(t)[quantity].values, ramped.sample(behind)[quantity].values
        assert sampled == pytest.approx(expected, abs=2e-5 * expected.max())
