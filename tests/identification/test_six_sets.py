"""Six sets of data of known materials: estimates, stated errors, contact points, and undetermined parameters.

The least possible errors (Cramer and Rao) follow from differences of `rs.solve`, `rs.indent` and `rs.bounces`.
"""

import math

import numpy as np
import pytest

import restitution as rs

STEEL = 7800.0
SD = 0.01
NU = {"poisson_ratio": 0.5}


def mass_of(radius):
    return STEEL * 4.0 / 3.0 * math.pi * radius**3


def least_errors(simulate, truth, steps, sd):
    """Least standard errors of all unknowns of a simulation whose values have the standard deviations `sd`."""
    slopes = np.stack([(simulate(truth + step) - simulate(truth - step)) / (2.0 * step.max()) / sd
                       for step in np.diag(steps)], axis=1)  # fmt: skip
    scale = np.linalg.norm(slopes, axis=0)
    covariance = np.linalg.inv((slopes / scale).T @ (slopes / scale)) / np.outer(scale, scale)
    return np.sqrt(np.diag(covariance))


def check(fit, names, truth, least):
    """Each parameter is within three standard errors, and its error within 0.8 to 1.3 of the least one."""
    for name, value, bound in zip(names, np.exp(truth), least, strict=False):
        estimate = fit.parameters[name]
        error = estimate.standard_error / estimate.value
        assert abs(math.log(estimate.value / value)) < 3.0 * error, name
        assert 0.8 < error / bound < 1.3, name


def standard_solid(logs):
    equilibrium, branch, viscosity = np.exp(logs[:3])
    return rs.standard_solid(equilibrium, branch, viscosity, **NU)


def two_terms(logs):
    equilibrium, first, second, fast, slow = np.exp(logs[:5])
    return rs.generalised_maxwell(equilibrium, [first, second], [fast, slow], **NU)


RADII = np.repeat([0.002, 0.008, 0.03], 12)
VELOCITIES = np.tile(np.geomspace(0.02, 0.2, 12), 3)
SOLID = "equilibrium_modulus", "branch_modulus", "viscosity"
TERMS = (
    "equilibrium_modulus", "branch_moduli[0]", "branch_moduli[1]", "relaxation_times[0]", "relaxation_times[1]",
)  # fmt: skip


@pytest.mark.parametrize(
    ("make", "model", "names", "truth"),
    [
        (standard_solid, rs.standard_solid, SOLID, np.log([1e6, 1e7, 1e4])),
        (two_terms, rs.generalised_maxwell, TERMS, np.log([1e6, 5e6, 2e6, 1e-4, 5e-3])),
    ],
    ids=["one term", "two terms"],
)
def test_balls(make, model, names, truth):
    def simulate(logs):
        fit = rs.solve(rs.Impact(make(logs), rs.Parabola(RADII), mass_of(RADII), VELOCITIES))
        return np.log(np.concatenate([fit.restitution_coefficient, fit.contact_time]))

    least = least_errors(simulate, truth, np.full(truth.size, 1e-4), SD)
    values = np.exp(simulate(truth) + SD * np.random.default_rng(1).standard_normal(2 * RADII.size))
    e, time = np.split(values, 2)
    noise = rs.Noise(restitution_coefficient="1 %", contact_time="1 %")
    balls = rs.Rebounds(VELOCITIES, e, radius=RADII, mass=mass_of(RADII), contact_time=time, noise=noise)
    check(rs.identify(balls, model, fixed=NU), names, truth, least)
    noise = rs.Noise(restitution_coefficient="1 %")
    without_times = rs.Rebounds(VELOCITIES, e, radius=RADII, mass=mass_of(RADII), noise=noise)
    fit = rs.identify(without_times, model, fixed=NU)
    assert all(fit.parameters[name].value is None for name in names)
    assert any(direction.exact for direction in fit.flat_directions)
    assert "not determined by these data" in str(fit)


def test_force_history():
    radius, velocity, truth = 0.01, 0.1, np.log([1e6, 1e7, 1e4])
    mass = mass_of(radius)
    exact = rs.solve(rs.Impact(standard_solid(truth), rs.Parabola(radius), mass, velocity))
    time = np.linspace(0.0, 1.5 * exact.contact_time, 240)
    peak, touch = exact.max_force, 0.2137 * exact.contact_time

    def simulate(unknowns):
        balls = rs.solve(rs.Impact(standard_solid(unknowns), rs.Parabola(radius), mass, velocity))
        force = np.zeros(time.size)
        since = time - touch - unknowns[3] * exact.contact_time
        inside = (since > 0.0) & (since < balls.contact_time)
        force[inside] = balls.sample(since[inside])["force"]
        return force / peak + unknowns[4]

    unknowns = np.append(truth, [0.0, 0.0])
    least = least_errors(simulate, unknowns, np.array([1e-4, 1e-4, 1e-4, 1e-5, 1e-4]), SD)
    force = peak * (simulate(unknowns) + 0.03 + SD * np.random.default_rng(2).standard_normal(time.size))
    record = rs.ForceHistory(time, force, radius=radius, mass=mass, velocity=velocity, noise=rs.Noise(force="1 %"))
    fit = rs.identify(record, rs.standard_solid, fixed=NU)
    check(fit, SOLID, truth, least)
    start = fit.nuisances["first_touch"]
    assert abs(start.value - touch) < 3.0 * start.standard_error
    assert 0.8 < start.standard_error / (exact.contact_time * least[3]) < 1.3


TIP = rs.Parabola(2.5e-6)
FORCE_NOISE = 1e-11


def curve_of(make, depth, time, contact):
    """Force under a tip, with a baseline and a slope in time."""

    def simulate(unknowns):
        moved = depth - contact - unknowns[-3] * 1e-6
        force = rs.indent(make(unknowns), TIP, depth=moved, time=time).force
        return force + FORCE_NOISE * (unknowns[-2] + unknowns[-1] * time)

    return simulate


@pytest.mark.parametrize("contact", [0.4e-6, 4.74815072755433e-07], ids=["round", "at random"])
def test_curve_of_a_standard_solid(contact):
    time = np.linspace(0.0, 2.8, 480)
    depth = np.interp(time, [0.0, 1.4, 2.8], [0.0, 1.4e-6, 0.0])
    truth = np.log([200.0 / 3.0, 800.0 / 3.0, 80.0])
    unknowns = np.append(truth, np.zeros(3))
    simulate = curve_of(standard_solid, depth, time, contact)
    least = least_errors(simulate, unknowns, np.array([1e-4, 1e-4, 1e-4, 1e-4, 1.0, 1.0]), FORCE_NOISE)
    force = simulate(unknowns) + FORCE_NOISE * (3.0 - 2.0 * time)
    force += FORCE_NOISE * np.random.default_rng(3).standard_normal(time.size)
    curve = rs.IndentationCurve(time, depth, force, profile=TIP, noise=rs.Noise(force=FORCE_NOISE))
    fit = rs.identify(curve, rs.standard_solid, fixed=NU)
    check(fit, SOLID, truth, least)
    point = fit.nuisances["contact_point"]
    assert abs(point.value - contact) < 3.0 * point.standard_error
    assert 0.8 < point.standard_error / (1e-6 * least[3]) < 1.3


@pytest.mark.slow
def test_curve_of_a_power_law_with_a_hold():
    time = np.linspace(0.0, 4.8, 480)
    depth = np.interp(time, [0.0, 1.4, 3.4, 4.8], [0.0, 1.4e-6, 1.4e-6, 0.0])
    contact, exponent = 0.4321e-6, 0.2

    def power_law(unknowns):
        shear = rs.springpot(math.exp(unknowns[0]), 1.0 / (1.0 + math.exp(-unknowns[1])))
        return rs.FractionalMaterial(shear, math.inf).within((1e-4, 1e2))

    truth = np.array([math.log(150.0), math.log(exponent / (1.0 - exponent))])
    unknowns = np.append(truth, np.zeros(3))
    simulate = curve_of(power_law, depth, time, contact)
    # The number of Prony terms may change with the exponent: the difference is wider than its error.
    least = least_errors(simulate, unknowns, np.array([1e-3, 1e-2, 1e-4, 1.0, 1.0]), FORCE_NOISE)
    force = simulate(unknowns) + FORCE_NOISE * np.random.default_rng(4).standard_normal(time.size)
    curve = rs.IndentationCurve(time, depth, force, profile=TIP, noise=rs.Noise(force=FORCE_NOISE))
    fit = rs.identify(curve, "springpot", fixed=NU)
    check(fit, ("coefficient",), truth, least)
    estimate = fit.parameters["exponent"]
    assert abs(estimate.value - exponent) < 3.0 * estimate.standard_error
    assert 0.8 < estimate.standard_error / (exponent * (1.0 - exponent) * least[1]) < 1.3
    point = fit.nuisances["contact_point"]
    assert abs(point.value - contact) < 3.0 * point.standard_error


@pytest.mark.parametrize(("viscosity", "count"), [
    pytest.param(1e4, 6, id="determined"),
    pytest.param(300.0, 9, id="a short relaxation", marks=pytest.mark.slow),
])  # fmt: skip
def test_bounce_times(viscosity, count):
    radius, truth, sd = 0.01, np.log([1e6, 1e7, viscosity]), 1e-5
    body = rs.Body(None, radius=radius, mass=mass_of(radius))

    def simulate(unknowns):
        impact = rs.drop(body, rs.Body(standard_solid(unknowns)), height=0.3 * math.exp(unknowns[3]))
        return rs.bounces(impact, max_bounces=count, min_height=0.0).touch_time + unknowns[4]

    unknowns = np.append(truth, [0.0, 0.0])
    least = least_errors(simulate, unknowns, np.full(5, 1e-4), sd)
    time = simulate(unknowns) + 0.77 + sd * np.random.default_rng(5).standard_normal(count)
    sound = rs.BounceTimes(time, radius=radius, mass=mass_of(radius), drag_coefficient=0.0, noise=rs.Noise(time=sd))
    fit = rs.identify(sound, rs.standard_solid, fixed=NU)
    determined = [name for name in SOLID if fit.parameters[name].determined]
    places = [SOLID.index(name) for name in determined]
    check(fit, determined, truth[places], least[places])
    assert len(determined) == 3 or viscosity == 300.0
    for name, value, bound in zip(SOLID, np.exp(truth), least, strict=False):
        if name not in determined:
            low, high = fit.parameters[name].interval
            assert bound > 0.5
            assert low <= value <= high
    tangent = next(estimate for name, estimate in fit.functionals.items() if name.startswith("loss_tangent"))
    assert tangent.determined
