"""Statements on what data determine: exact invariances, flat directions, one further measurement."""

import math
import re

import numpy as np
import pytest
from tests.identification.balls import STANDARD_SOLIDS, rebounds, standard_solid

import restitution as rs
from restitution.identification.parameters import parameters
from restitution.identification.statements import knowledge, sensitivities

NU = {"poisson_ratio": 0.5}
ONE_BALL = {"radius": 0.01, "velocity": np.geomspace(0.1, 2.0, 12)}
MODULUS, BRANCH, VISCOSITY = "equilibrium_modulus", "branch_modulus", "viscosity"


def known_from(model, start, impacts, quantities, *, fixed=NU, exponent=1.0, rows=()):
    """Knowledge from exact data, with 1 % of noise."""
    space = parameters(model, fixed=fixed, start=start)
    theta = np.array([parameter.inward(space.start[parameter.name]) for parameter in space.free])

    def columns(coordinates):
        return space.materials(coordinates, (1e-7, 1.0))

    noise = rs.Noise(**dict.fromkeys(quantities, "1 %"))
    values, jacobian = sensitivities(impacts, columns, theta, noise)
    times = values["contact_time"]
    jacobian = np.vstack([jacobian.reshape(-1, theta.size), *rows])
    window = math.pi / times.max(), math.pi / times.min()
    return knowledge(space.names, jacobian, columns, theta, window, exponent=exponent, impacts=impacts), jacobian


def impacts(profile=None, radius=0.01, velocity=ONE_BALL["velocity"]):
    body = {"profile": profile} if profile is not None else {"radius": radius}
    return rs.Rebounds(velocity, np.ones(12), mass=0.033, **body)


SOLID = {MODULUS: 1e6, BRANCH: 1e7, VISCOSITY: 1e4}


def test_moduli_and_times_can_change_together_without_effect_on_restitution():
    velocities, changed = np.geomspace(0.01, 1.0, 5), 3.0
    results = [
        rs.solve(
            rs.Impact(
                rs.Material(rs.PronySeries(1e8, [1e9], [1e-4]).scaled(size**2.5, time_factor=1.0 / size), np.inf),
                rs.Parabola(0.01), mass=0.03, velocity=velocities,
            )
        )
        for size in (1.0, changed)
    ]  # fmt: skip
    first, second = results
    np.testing.assert_allclose(second.restitution_coefficient, first.restitution_coefficient, rtol=1e-8)
    np.testing.assert_allclose(second.contact_time, first.contact_time / changed, rtol=1e-8)
    np.testing.assert_allclose(second.max_force, first.max_force * changed, rtol=1e-8)


def test_a_contact_time_determines_all_parameters_with_the_stated_errors():
    (_, lines), jacobian = known_from(rs.standard_solid, SOLID, impacts(), ["restitution_coefficient"])
    predicted = re.search(r"a contact time \(to 1 %\) leaves standard errors of at most ([\d.]+) %", lines[-1])
    assert predicted is not None
    # The same data with the contact time of the middle impact.
    both = known_from(rs.standard_solid, SOLID, impacts(), ["restitution_coefficient", "contact_time"])[1]
    middle = both.reshape(12, 2, 3)[6, 1]
    information = jacobian.T @ jacobian + np.outer(middle, middle)
    error = 100.0 * np.sqrt(np.diag(np.linalg.inv(information))).max()
    assert float(predicted[1]) == pytest.approx(error, rel=0.05)


@pytest.mark.parametrize(
    ("profile", "beta"), [(rs.Parabola(0.01), 2.5), (rs.Cone(half_angle=1.3), 3.0), (rs.FlatPunch(0.002), 2.0)]
)
def test_the_power_of_the_invariance_is_that_of_the_profile(profile, beta):
    # F ~ E c d^(1 + p/2): times over L need moduli times L^(2 + p/2).
    exponent = float(profile.path_exponent)
    (directions, _), _ = known_from(
        rs.standard_solid, SOLID, impacts(profile), ["restitution_coefficient"], exponent=exponent
    )
    exact = [direction for direction in directions if direction.exact]
    # Under a flat punch the motion is linear: e is one number, the same at all velocities.
    assert len(exact) == (2 if beta == 2.0 else 1)
    assert exact[0].exponents == {MODULUS: beta, BRANCH: beta, VISCOSITY: beta - 1.0}


def test_the_power_of_a_springpot_follows_from_its_exponent():
    (directions, _), _ = known_from(
        "fractional_kelvin_voigt", {MODULUS: 1e6, "coefficient": 1e5, "exponent": 0.4}, impacts(),
        ["restitution_coefficient"],
    )  # fmt: skip
    exact = [direction for direction in directions if direction.exact]
    # V (L t)^-alpha L^(5/2)
    assert exact[0].exponents == pytest.approx({MODULUS: 2.5, "coefficient": 2.1})


def test_a_known_bulk_modulus_breaks_the_invariance():
    (directions, _), _ = known_from(
        rs.standard_solid, SOLID, impacts(), ["restitution_coefficient"], fixed={"bulk_modulus": 1e7}
    )
    assert not any(direction.exact for direction in directions)


def test_a_reduced_modulus_determines_no_poisson_ratio():
    def model(equilibrium_modulus, branch_modulus, viscosity, poisson_ratio):
        shear = rs.PronySeries(equilibrium_modulus, [branch_modulus], [viscosity / branch_modulus])
        return rs.Material(shear, shear.scaled(2.0 * (1.0 + poisson_ratio) / (3.0 * (1.0 - 2.0 * poisson_ratio))))

    quantities = ["restitution_coefficient", "contact_time", "max_force"]
    (directions, lines), _ = known_from(model, SOLID | {"poisson_ratio": 0.3}, impacts(), quantities, fixed={})
    (flat,) = directions
    assert flat.exact
    assert "poisson_ratio" in flat.exponents
    assert "reduced modulus E*" in flat.words
    assert "abs(E*) to" in lines[0]


def test_the_kelvin_voigt_limit_is_flat_along_the_branch():
    fast = {MODULUS: 1e6, BRANCH: 1e9, VISCOSITY: 300.0}
    (directions, _), _ = known_from(rs.standard_solid, fast, impacts(), ["restitution_coefficient", "contact_time"])
    (flat,) = directions
    # With the viscosity as a parameter only the branch modulus is free.
    assert flat.exponents == {BRANCH: 1.0}
    assert not flat.exact
    assert "higher frequencies" in flat.words.lower()


def test_slow_relaxation_is_flat_along_the_equilibrium_modulus():
    slow = {MODULUS: 1e6, BRANCH: 1e7, VISCOSITY: 1e6}
    (directions, _), _ = known_from(rs.standard_solid, slow, impacts(), ["restitution_coefficient", "contact_time"])
    assert any(max(direction.exponents, key=direction.exponents.get) == MODULUS for direction in directions)
    assert any("lower frequencies" in direction.words.lower() for direction in directions)


def test_a_gain_and_a_velocity_that_are_both_unknown_leave_a_flat_direction():
    # E sqrt(v) = const: an unknown velocity has the same effect on the forces as moduli and a gain.
    names = (MODULUS, BRANCH, VISCOSITY, "velocity", "gain")
    rng = np.random.default_rng(1)
    data = rng.normal(size=(40, 3))
    joint = data @ np.array([1.0, 1.0, 1.0])
    jacobian = np.column_stack([data, 0.5 * joint, rng.normal(size=40)])
    space = parameters(rs.standard_solid, fixed=NU, start=SOLID)
    theta = np.array([parameter.inward(space.start[parameter.name]) for parameter in space.free])
    directions, _ = knowledge(names, 100.0 * jacobian, lambda z: space.materials(z, (1e-7, 1.0)), theta, (1e2, 1e4))
    (flat,) = directions
    assert flat.exact
    assert flat.exponents == {MODULUS: 1.0, BRANCH: 1.0, VISCOSITY: 1.0}
    assert flat.words.endswith("Give velocity.")


def test_determined_parameters_have_no_flat_direction():
    balls = rebounds(standard_solid(*STANDARD_SOLIDS["strong"]), seed=1)
    lines = rs.identify(balls, rs.standard_solid, fixed=NU).statements
    assert len(lines) == 1
    assert lines[0].startswith("At pi over the contact time")


def test_errors_of_combinations_are_those_of_repeated_fits():
    material = standard_solid(*STANDARD_SOLIDS["strong"])
    (_, lines), _ = known_from(rs.standard_solid, SOLID, impacts(), ["restitution_coefficient"])
    stated = re.search(r"viscosity/equilibrium_modulus\^0.6 to ([\d.]+) %", "\n".join(lines))
    assert stated is not None
    fit = [
        rs.identify(rebounds(material, seed=seed, measured=(), **ONE_BALL), rs.standard_solid, fixed=NU)
        for seed in range(12)
    ]
    sums = [result.coordinates[result.names.index(VISCOSITY)] - 0.6 * result.coordinates[result.names.index(MODULUS)]
            for result in fit]  # fmt: skip
    # The standard deviation of 12 draws scatters by 21 %.
    assert 100.0 * np.std(sums, ddof=1) == pytest.approx(float(stated[1]), rel=0.7)


@pytest.mark.slow
def test_restitution_at_several_temperatures_determines_the_shift_but_no_modulus():
    shift, velocity = rs.WLF(293.0, 4.0, 100.0), np.geomspace(0.05, 0.5, 6)
    cold = rs.Material(rs.PronySeries(1e8, [1e9], [1e-4]), np.inf, shift=shift, temperature=293.0)
    temperatures = (273.0, 293.0, 313.0, 333.0)
    e = [
        rs.solve(rs.Impact(cold.at(temperature), rs.Parabola(0.01), 0.033, velocity)).restitution_coefficient
        for temperature in temperatures
    ]
    balls = rs.Rebounds(
        np.tile(velocity, 4), np.concatenate(e), radius=0.01, mass=0.033, temperature=np.repeat(temperatures, 6),
        noise=rs.Noise(restitution_coefficient="0.3 %"),
    )  # fmt: skip
    fit = rs.identify(balls, rs.standard_solid, fixed=NU | {"reference_temperature": 293.0}, shift=rs.WLF)
    assert [name for name, estimate in fit.parameters.items() if estimate.determined] == ["c1", "c2"]
    assert fit.parameters["c1"].value == pytest.approx(4.0, rel=0.02)
    exact = [line for line in fit.statements if "x^2.5" in line]
    assert len(exact) == 1
    assert "c1" not in exact[0]
