"""Designs of experiments: predicted errors, the table of the design page, criteria, refusals."""

import json
import math
from functools import partial

import numpy as np
import pytest
from tests.identification.balls import STANDARD_SOLIDS, rebounds, standard_solid

import restitution as rs
from refusals import in_one_line, named
from restitution import Noise, Rebounds, design

# Balls of the design page go deeper than small strains allow.
pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")

VELOCITIES = np.geomspace(0.03, 10.0, 12)
STEEL = 7800.0


def solid(equilibrium, branch, time):
    return rs.standard_solid(equilibrium, branch, branch * time, poisson_ratio=0.5)


def two_terms(equilibrium, first, first_time, second, second_time):
    return rs.generalised_maxwell(equilibrium, [first, second], [first_time, second_time], poisson_ratio=0.5)


CASES = {
    "A": partial(solid, 1e6, 1e7, 1e-3),
    "B": partial(solid, 1e6, 1e7, 3e-5),
    "C": partial(solid, 1e6, 1e7, 3e-2),
    "D": partial(solid, 1e6, 2e5, 1e-3),
    "two terms": partial(two_terms, 1e6, 5e6, 1e-4, 2e6, 5e-3),
}
# Section 7 of the design page: largest standard errors in per cent, velocities alone and with three radii.
KNOWN = {"A": (4.0, 0.68), "B": (45.0, 3.2), "C": (6e3, 645.0), "D": (6.9, 5.4), "two terms": (42.0, 2.6)}


def plan(model, radius, **options):
    return design(model, {"velocity": VELOCITIES, "radius": radius, "density": STEEL}, **options)


@pytest.mark.parametrize("case", CASES)
def test_largest_errors_are_those_of_the_design_page(case):
    for radius, reference in zip(([0.01], [0.003, 0.01, 0.03]), KNOWN[case], strict=True):
        # Values of a table with two digits; its velocities may be different.
        assert 100.0 * plan(CASES[case], radius).largest_error == pytest.approx(reference, rel=0.1)


def test_several_radii_are_better_than_velocities_by_the_stated_gain():
    result = plan(CASES["A"], [0.003, 0.01, 0.03])
    assert result.gains[0.01] > 4.0
    assert result.one_radius[0.01] == pytest.approx(plan(CASES["A"], [0.01]).largest_error)
    assert any(f"R = 10 mm ({result.gains[0.01]:.2g} times as large)" in line for line in result.statements)


def test_predicted_errors_follow_from_the_jacobian_of_the_chosen_impacts():
    result = plan(CASES["A"], [0.003, 0.03], n=7)
    assert result.repeats.sum() == 7
    balls = Rebounds(
        np.repeat(result.velocity, result.repeats), np.ones(7), radius=np.repeat(result.radius, result.repeats),
        mass=np.repeat(result.mass, result.repeats),
    )  # fmt: skip
    guess = np.array([1e6, 1e7, 1e-3])

    def logs(values):
        impact = rs.Impact(solid(*values), rs.Parabola(balls.radius), mass=balls.mass, velocity=balls.velocity)
        result = rs.solve(impact, rtol=1e-11)
        return np.log(np.concatenate([result.restitution_coefficient, result.contact_time])) / 0.01

    step = 1e-3
    jacobian = np.stack(
        [(logs(guess * np.exp(step * e)) - logs(guess * np.exp(-step * e))) / (2.0 * step) for e in np.eye(3)], axis=1
    )
    errors = np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)))
    np.testing.assert_allclose(list(result.standard_errors.values()), errors, rtol=1e-3)


@pytest.mark.parametrize("criterion", ["E", "D"])
def test_a_design_is_better_than_random_choices(criterion):
    result = plan(CASES["D"], [0.003, 0.01, 0.03], n=10, criterion=criterion)
    rng = np.random.default_rng(1)
    for _ in range(5):
        some = np.sort(rng.choice(VELOCITIES, 10))
        other = design(CASES["D"], {"velocity": some[:1], "radius": [0.003, 0.01, 0.03], "density": STEEL}, n=10)
        assert result.largest_error < other.largest_error


def test_both_criteria_agree_within_a_quarter():
    errors = [plan(CASES["two terms"], [0.003, 0.01, 0.03], criterion=criterion).largest_error for criterion in "ED"]
    assert max(errors) < 1.3 * min(errors)


def test_more_impacts_lower_the_error_by_the_root_of_their_number():
    few, many = (plan(CASES["A"], [0.003, 0.03], n=n).largest_error for n in (20, 80))
    assert few / many == pytest.approx(2.0, rel=0.1)


def test_the_restitution_coefficient_alone_determines_no_parameter():
    result = plan(CASES["A"], [0.003, 0.01, 0.03], noise=Noise(restitution_coefficient=0.005))
    assert all(math.isinf(error) for error in result.standard_errors.values())
    assert "No choice" in result.statements[-1]


def test_parameters_that_are_known_are_left_out():
    guess = partial(rs.standard_solid, 1e6, 1e7, 1e4, poisson_ratio=0.47)
    assert list(plan(guess, [0.01], n=5).standard_errors) == ["equilibrium_modulus", "branch_modulus", "viscosity"]
    free = plan(guess, [0.01], n=5, fixed=())
    assert list(free.standard_errors) == ["equilibrium_modulus", "branch_modulus", "viscosity", "poisson_ratio"]
    assert free.largest_error > plan(guess, [0.01], n=5).largest_error


def test_fractional_models_have_designs():
    guess = partial(rs.fractional_zener, 1e6, 1e7, 1e-3, 0.5, poisson_ratio=0.5)
    result = plan(guess, [0.003, 0.03], n=8)
    assert 0.0 < result.largest_error < 1.0


def test_a_design_continues_an_identification():
    balls = rebounds(standard_solid(*STANDARD_SOLIDS["strong"]), 0.01, np.geomspace(0.3, 3.0, 20), seed=1)
    result = rs.identify(balls, rs.standard_solid, fixed={"poisson_ratio": 0.5})
    more = plan(result, [0.003, 0.03], n=10)
    before = {
        name: estimate.standard_error / estimate.value
        for name, estimate in result.parameters.items()
        if estimate.determined
    }
    assert before
    for name, error in before.items():
        assert more.standard_errors[name] < error
    # Twice the data of the same kind: a factor of the root of 2.
    same = design(result, {"velocity": balls.velocity, "radius": 0.01, "mass": balls.mass[0]}, n=20)
    assert same.largest_error < max(before.values()) / 1.3


def test_results_are_plain_numbers_tables_and_pictures():
    result = plan(CASES["A"], [0.003, 0.03], n=6)
    assert json.loads(json.dumps(result.to_dict()))["criterion"] == "E"
    table = result.to_dataset()
    assert table.velocity.attrs["units"] == "m/s"
    assert int(table.repeats.sum()) == 6
    assert str(result).count("\n") > result.velocity.size


@pytest.mark.parametrize(
    ("candidates", "field"),
    [
        ({"velocity": [1.0], "density": STEEL}, "candidates.radius"),
        ({"velocity": [1.0], "radius": [0.01]}, "candidates.mass, candidates.density"),
        ({"velocity": [-1.0], "radius": [0.01], "density": STEEL}, "candidates.velocity"),
        ({"velocity": [1.0], "radius": [0.01], "mass": [0.1, 0.2]}, "candidates.mass"),
        ({"speed": [1.0]}, "candidates"),
    ],
)
def test_bad_candidates_are_refused_in_one_line(candidates, field):
    assert in_one_line(lambda: design(CASES["A"], candidates)).field == field


def test_a_model_without_numbers_is_refused():
    balls = {"velocity": [1.0], "radius": [0.01], "density": STEEL}
    assert in_one_line(lambda: design(rs.standard_solid, balls)).field == "model_at_guess"
    assert named(lambda: design(partial(solid, 1e6), balls)) == ("model_at_guess.branch",)
