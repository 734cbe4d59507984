"""Force histories: recovered materials and their errors, the impulse, and damaged records."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from least_squares import CASES, MASS, RADIUS, columns, covariance, fit, residuals, solid
from refusals import in_one_line, named, warns
from restitution import (
    Arrhenius,
    ForceHistory,
    Impact,
    Noise,
    Parabola,
    Sphere,
    identify,
    reduced_modulus,
    solve,
    standard_solid,
)
from restitution.errors import InputError
from restitution.material.shift import GAS_CONSTANT


def history(case="D", n=240, profile=None):
    """Times and forces of an impact at 1 m/s that begins at 0.3 and ends at 1.3 contact times."""
    result = solve(Impact(solid(case), profile or Parabola(RADIUS), MASS, 1.0))
    t = np.linspace(0.0, 1.6, n) * result.contact_time
    first = 0.3 * result.contact_time
    touching = (t >= first) & (t <= first + result.contact_time)
    force = np.zeros(n)
    force[touching] = result.sample(t[touching] - first)["force"]
    return t, force, first, result


def record(t, force, **options):
    """Observation of a ball at 1 m/s."""
    return ForceHistory(t, force, **{"radius": RADIUS, "mass": MASS, "velocity": 1.0} | options)


@pytest.mark.parametrize("profile", [Parabola(RADIUS), Sphere(RADIUS)])
def test_forces_of_many_materials_are_those_of_single_impacts(profile):
    t, force, first, _ = history("A", profile=profile)
    data = ForceHistory(t, force, profile=profile, mass=MASS, velocity=1.0)
    logs = np.log([CASES["D"], CASES["A"], CASES["B"]])
    result = data.forces(columns(logs), np.full((3, 1), first))
    assert result[1] == pytest.approx(force, abs=1e-8 * force.max())
    other = solve(Impact(solid("D"), profile, MASS, 1.0)).sample(t[t >= first] - first)["force"]
    assert result[0, t >= first] == pytest.approx(np.asarray(other), abs=1e-8 * force.max())


def test_impulse_is_the_change_of_momentum():
    t, force, _, result = history(n=2000)
    data = record(t, force)
    impulse = MASS * (1.0 + result.restitution_coefficient)
    assert data._impulse == pytest.approx(impulse, rel=1e-4)
    for factor in (0.4, 1.3, 1e3):
        with pytest.raises(InputError, match="impulse"):
            record(t, factor * force)
    # With a gain, known or unknown, the same record is accepted; also with an unknown velocity.
    assert record(t, 5.0 * force, gain=5.0)._impulse == pytest.approx(impulse, rel=1e-4)
    assert record(t, 5.0 * force, gain=None).size == t.size
    free = record(t, force, velocity=None).nuisances[1]
    assert free.low < 1.0 < free.high < 2.5 * free.low


# Strong noise, but the problem of this material stays linear.
@pytest.mark.parametrize(("case", "noise"), [("A", 0.01), ("D", 0.002)])
def test_material_is_recovered_and_its_errors_are_the_least_possible(case, noise):
    t, force, first, _ = history(case)
    sd = noise * force.max()
    noisy = force + 0.3 * force.max() + sd * np.random.default_rng(3).standard_normal(t.size)
    data = record(t, noisy, noise=Noise(force=sd))
    truth = np.append(np.log(CASES[case]), first)
    bound = np.sqrt(np.diag(covariance(data, truth)))
    result = fit(data, truth[:3] + np.array([0.5, -0.5, 0.5]))
    assert np.all(np.abs(result.estimate - truth) < 3.0 * result.errors)
    assert np.all((result.errors[1:] > 0.8 * bound[1:]) & (result.errors[1:] < 1.3 * bound[1:]))
    assert abs(result.chi2 - (t.size - 5)) < 4.0 * math.sqrt(2.0 * t.size)
    point = columns(result.estimate[:3]), result.estimate[None, 3:]
    assert data.linear_estimates(*point)["baseline"][0] == pytest.approx(0.3 * force.max(), abs=5.0 * sd / 8.0)


def test_an_unknown_gain_makes_the_material_ten_times_less_certain():
    t, force, first, _ = history("D")
    truth = np.append(np.log(CASES["D"]), first)
    reference = covariance(record(t, force, noise=Noise(force="1 %")), truth)
    data = record(t, force, gain=None, noise=Noise(force="1 %"))
    unknown = covariance(data, truth)
    ratio = np.sqrt(np.diag(unknown) / np.diag(reference))[:3]
    assert np.all((ratio > 5.0) & (ratio < 30.0))
    assert data.linear_estimates(columns(truth[:3]), truth[None, 3:])["gain"] == (pytest.approx(1.0, abs=1e-9), "")


def test_identify_finds_material_first_touch_baseline_and_gain():
    t, force, first, _ = history("A")
    sd = 0.002 * force.max()
    volts = 2.5 * (force + 4.0 + sd * np.random.default_rng(8).standard_normal(t.size))
    data = record(t, volts, gain=None, noise=Noise(force=2.5 * sd))
    result = identify(data, standard_solid, fixed={"poisson_ratio": 0.5}, profiles=False)
    truth = np.log([CASES["A"][0], CASES["A"][1], CASES["A"][1] * CASES["A"][2]])
    assert np.all(np.abs(result.coordinates[:3] - truth) < 3.0 * np.sqrt(np.diag(result.covariance)))
    touch = result.nuisances["first_touch"]
    assert abs(touch.value - first) < 3.0 * touch.standard_error
    assert result.nuisances["gain"].value == pytest.approx(2.5, rel=0.1)
    assert result.nuisances["baseline"].value == pytest.approx(10.0, abs=0.01 * volts.max())
    assert 0.8 < result.reduced_chi2 < 1.25


def test_gain_and_velocity_together_have_a_flat_direction_and_are_refused():
    t, force, first, _ = history("D")
    assert named(lambda: record(t, force, gain=None, velocity=None)) == ("gain, velocity",)
    # The reason for the refusal: the force is the same if E sqrt(v) is constant and the gain cancels v.
    data = record(t, force, gain=None)
    data.velocity = None
    logs = np.log(CASES["D"])
    slower = logs + np.array([math.log(2.0), math.log(2.0), 0.0])
    result = residuals(data, [[*logs, first, 1.0], [*slower, first, 0.25]])
    assert np.abs(result).max() < 1e-7 * force.max()


def test_acceleration_is_the_force_over_the_mass():
    t, force, first, _ = history("A")
    by_force = record(t, force, noise=Noise(force="1 %"))
    by_acceleration = record(t, None, acceleration=force / MASS, noise=Noise(acceleration="1 %"))
    point = np.append(np.log(CASES["D"]), first)
    assert residuals(by_acceleration, point) == pytest.approx(residuals(by_force, point), rel=1e-9, abs=1e-9)
    assert by_acceleration.linear_estimates(columns(point[:3]), point[None, 3:])["baseline"][1] == "m/s^2"


def test_units_do_not_matter():
    from pint import get_application_registry

    unit = get_application_registry()
    t, force, first, _ = history("A")
    point = np.append(np.log(CASES["D"]), first)
    data = record(
        1e3 * t * unit.ms, 1e-3 * force * unit.kN, radius=10.0 * unit.mm, mass=1e3 * MASS * unit.g,
        velocity=100.0 * unit.cm / unit.s,
    )  # fmt: skip
    assert residuals(data, point) == pytest.approx(residuals(record(t, force), point), rel=1e-9, abs=1e-9)


def test_correlated_noise_is_reported_and_whitened():
    t, force, first, _ = history("A")
    rng, correlation, sd = np.random.default_rng(4), 0.7, 0.01 * force.max()
    noise = np.empty(t.size)
    noise[0] = rng.standard_normal()
    for n in range(1, t.size):
        noise[n] = correlation * noise[n - 1] + math.sqrt(1.0 - correlation**2) * rng.standard_normal()
    with warns("correlated_noise"):
        plain = record(t, force + sd * noise, noise=Noise(force=sd))
    data = record(t, force + sd * noise, ar1=correlation, noise=Noise(force=sd))
    truth = np.append(np.log(CASES["A"]), first)
    r = residuals(data, truth)[0]
    assert abs(r[1:] @ r[:-1]) / (r @ r) < 3.0 / math.sqrt(t.size)
    assert abs(r @ r - t.size) < 4.0 * math.sqrt(2.0 * t.size)
    # Slow deviations resemble changes of the material, so errors for white noise are too small.
    assert np.all(np.diag(covariance(data, truth))[1:] > 2.0 * np.diag(covariance(plain, truth))[1:])
    with pytest.raises(InputError, match="regular"):
        record(np.append(t[:-1], 1.1 * t[-1]), force, ar1=0.5)
    assert named(lambda: record(t, force, ar1=1.0)) == ("ar1", 1.0)


def test_temperature_shifts_the_times():
    t, force, first, _ = history("A")
    shifted = record(t, force, temperature=300.0)
    # An activation energy that doubles the times at 300 K.
    law = Arrhenius(320.0, math.log(2.0) * GAS_CONSTANT / (1.0 / 300.0 - 1.0 / 320.0))
    material = replace(columns(np.log(CASES["A"])), shift=law, temperature=320.0)
    expected = residuals(record(t, force), [*(np.log(CASES["A"]) + np.array([0.0, 0.0, math.log(2.0)])), first])
    assert shifted.residuals(material, np.array([[first]])) == pytest.approx(expected, abs=1e-6 * force.max())


def test_a_material_that_holds_the_body_gives_nan():
    t, force, first, _ = history("A")
    points = np.array([[math.log(1e6), math.log(1e7), math.log(1e-3), first], [*np.log(CASES["D"]), first]])
    material = columns(points[:, :3])
    reduced_modulus(material).equilibrium_modulus[0] = math.nan
    result = record(t, force).residuals(material, points[:, 3:])
    assert np.all(np.isnan(result[0]))
    assert np.all(np.isfinite(result[1]))


def quantised(force, levels):
    step = force.max() / levels
    return step * np.round(force / step)


def test_records_of_real_instruments_are_accepted():
    t, force, _, _ = history("A")
    noisy = force + 0.02 * force.max() * np.random.default_rng(1).standard_normal(t.size)
    for values in (force, noisy, quantised(force, 60), quantised(noisy, 250), force + 3.0 * force.max()):
        assert record(t, values).size == t.size
    # A trigger may start the record late.
    late = t > t[np.argmax(force > 0.08 * force.max())]
    start = record(t[late], force[late]).nuisances[0].start
    assert abs(start - 0.3 / 1.6 * t[-1]) < 0.1 / 1.6 * t[-1]


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (lambda t, f: (t[:130], f[:130]), "no end"),
        (lambda t, f: (t, np.minimum(f, 0.8 * f.max())), "saturated"),
        (lambda t, f: (t, quantised(np.minimum(f, 0.8 * f.max()), 250)), "saturated"),
        (lambda t, f: (t, np.where(np.arange(t.size) == 90, 0.0, f)), "jump"),
        (lambda t, f: (t, np.where(np.arange(t.size) == 220, 0.4 * f.max(), f)), "jump"),
        (lambda t, f: (np.append(t, t + 1.1 * t[-1]), np.append(f, 0.9 * f)), "one contact"),
        (lambda t, f: (t, -f), "sign"),
        (lambda t, f: (t, 0.0 * f + 3.0), "baseline"),
        (lambda t, f: (t[::-1], f), "ascending"),
        (lambda t, f: (t[::20], f[::20]), "samples"),
        (lambda t, f: (t[::2], f), "equal length"),
        (lambda t, f: (1e3 * t, f), "radius"),
        (lambda t, f: (t, np.where(np.arange(t.size) == 90, np.nan, f)), "force[90]"),
    ],
)  # fmt: skip
def test_damaged_records_are_refused_in_one_line(damage, words):
    t, force, _, _ = history("A")
    assert words in str(in_one_line(lambda: record(*damage(t, force))))


def test_incomplete_arguments_are_refused():
    t, force, _, _ = history("A")
    for field, options in (
        ("radius, profile", {"radius": None}), ("radius, profile", {"profile": Parabola(1.0)}),
        ("force, acceleration", {"acceleration": force}), ("mass", {"mass": -1.0}),
        ("noise.acceleration", {"noise": Noise(acceleration=1.0)}), ("noise.force", {"noise": Noise(force=[1.0, 2.0])}),
    ):  # fmt: skip
        assert in_one_line(partial(record, t, force, **options)).field == field
