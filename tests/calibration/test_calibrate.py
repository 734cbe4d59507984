"""Calibration of laws to the exact answer: nearness, promises, texts, errors."""

import json
import math
import pickle
import re
from dataclasses import replace

import numpy as np
import pytest

import restitution as rs
from refusals import in_one_line, named
from restitution.calibration.calibrate import nearest
from restitution.calibration.collisions import EVENTS
from restitution.calibration.laws import LAWS, TypedLaw, tsuji_strength
from restitution.errors import ABSENT

RNG = np.random.default_rng(13)
RUBBER = rs.standard_solid(2e6, 5e6, 200.0, poisson_ratio=0.45, density=1100.0)
BALL = rs.Body(RUBBER, radius=0.01)
WALL = rs.Body(None)


@pytest.mark.parametrize("target", [*LAWS, *EVENTS])
def test_exact_at_one_velocity(target):
    """At one velocity every law meets both e and the contact time (codes of events have no contact time)."""
    speed = float(np.exp(RNG.uniform(math.log(0.05), math.log(5.0))))
    calibrated = rs.calibrate((BALL, WALL), target, speed)
    exact = rs.solve(rs.collision(BALL, WALL, speed))
    assert calibrated.restitution_coefficient(speed) == pytest.approx(exact.restitution_coefficient, rel=1e-7)
    if target in LAWS:
        assert calibrated.contact_time(speed) == pytest.approx(exact.contact_time, rel=1e-8)
    assert calibrated.largest_error < 1e-7


@pytest.mark.parametrize("target", ["lammps-viscoelastic", "lammps-tsuji", "mercury-bshp"])
def test_no_nearer_law(target):
    """The largest ratio of e grows with any other strength, that of the contact time with any other modulus."""
    calibrated = rs.calibrate((BALL, BALL), target, (0.05, 5.0), points=9, radius=(0.005, 0.02))
    collisions, law = calibrated.collisions, calibrated.law
    grid = collisions.grid

    def distances(law):
        e, time = law.rebound(*grid)
        return [
            float(np.abs(np.log(a / b)).max())
            for a, b in ((e, collisions.restitution_coefficient), (time, collisions.contact_time))
        ]

    best = distances(law)
    for factor in (0.99, 1.01):
        assert distances(replace(law, strength=factor * law.strength))[0] > best[0]
        # The loss stays that of the nearest e.
        other = TypedLaw(law.law, factor * law.modulus, 1.0, law.end)
        strength = float((law.loss(*grid) / other.loss(*grid)).flat[0])
        assert distances(replace(other, strength=strength))[1] > best[1]


def test_kelvin_voigt_pair_at_small_loss_is_the_material():
    """To first order in the loss the law of Brilliantov and others is that of Kelvin-Voigt bodies, with A = eta/G."""
    eta = 0.02
    body = rs.Body(rs.kelvin_voigt(1e6, eta, poisson_ratio=0.5, density=1100.0), radius=0.005)
    calibrated = rs.calibrate((body, body), "mercury-bshp", (0.5, 1.0), points=3)
    assert calibrated.parameters["E_eff"].value == pytest.approx(2e6, rel=1e-4)
    assert calibrated.parameters["A"].value == pytest.approx(eta / 1e6, rel=2e-3)
    # eta_n0 = 2 E* A/m_eff (validation/lammps_balls.md).
    lammps = rs.calibrate((body, body), "lammps-viscoelastic", (0.5, 1.0), points=3)
    typed = lammps.parameters["eta_n0"].value * 0.5 * body.mass / (2.0 * calibrated.parameters["E_eff"].value)
    assert typed == pytest.approx(calibrated.parameters["A"].value, rel=1e-6)
    assert calibrated.naive_parameters["A"].value == pytest.approx(eta / 1e6, rel=1e-9)


def test_usual_numbers_are_those_of_the_frequency_of_the_contact():
    """Storage modulus, and loss tangent over frequency, at pi/T of the middle velocity; e typed as it is."""
    calibrated = rs.calibrate((BALL, BALL), "mercury-bshp", (0.1, 10.0), points=3)
    middle = rs.solve(rs.collision(BALL, BALL, 1.0))
    series, omega = rs.reduced_modulus(RUBBER, RUBBER), math.pi / middle.contact_time
    assert calibrated.naive_parameters["E_eff"].value == pytest.approx(series.storage_modulus(omega), rel=1e-7)
    time = series.loss_modulus(omega) / series.storage_modulus(omega) / omega
    assert calibrated.naive_parameters["A"].value == pytest.approx(time, rel=1e-7)
    lammps = rs.calibrate((BALL, BALL), "lammps-coeff-restitution", (0.1, 10.0), points=3)
    assert lammps.naive_parameters["e"].value == pytest.approx(middle.restitution_coefficient, rel=1e-7)
    # Without limit_damping, LAMMPS gives the e that is typed at every velocity.
    assert lammps.table["naive_restitution_coefficient"].values == pytest.approx(
        middle.restitution_coefficient, abs=1e-5
    )


def test_young_modulus_gives_the_reduced_one():
    """E/(2 (1 - nu^2)) of two bodies of one material (page pair_style granular of LAMMPS)."""
    calibrated = rs.calibrate((BALL, BALL), "lammps-viscoelastic", 1.0)
    E, nu = (calibrated.parameters[name].value for name in ("E", "nu"))
    assert nu == pytest.approx(RUBBER.poisson_ratio)
    assert E / (2.0 * (1.0 - nu**2)) == pytest.approx(calibrated.law.modulus, rel=1e-12)


def test_impact_and_bodies_agree():
    by_bodies = rs.calibrate((BALL, BALL), "lammps-viscoelastic", (0.1, 1.0), points=5)
    by_impact = rs.calibrate(rs.collision(BALL, BALL, 3.0), "lammps-viscoelastic", (0.1, 1.0), points=5)
    assert by_impact.parameters == by_bodies.parameters
    assert not by_impact.wall
    assert rs.calibrate(rs.collision(BALL, WALL, 3.0), "mercury-bshp", 0.1).wall
    assert rs.calibrate((WALL, BALL), "mercury-bshp", 0.1).wall
    assert "fix wall all wall/gran" in rs.calibrate((BALL, WALL), "lammps-tsuji", 1.0).snippet


def test_the_other_contact_is_built_from_the_bodies():
    """Two equal balls have m/2 and R/2, a ball and a wall of its material m and R; both have E*/2 of a rigid wall."""
    radius, density, speed = np.exp(RNG.uniform(np.log([1e-3, 500.0, 0.05]), np.log([0.05, 5e3, 1.0])))
    material = replace(RUBBER, density=float(density))
    ball, wall = rs.Body(material, radius), rs.Body(material)
    mass = 4.0 / 3.0 * math.pi * radius**3 * density
    for bodies, contact, parts, others in (
        ((ball, ball), "wall", 1.0, (ball, wall)),
        ((ball, WALL), "pair", 0.5, (ball, ball)),
        ((WALL, ball), "pair", 0.5, (ball, ball)),
        ((ball, wall), "pair", 0.5, (ball, ball)),
    ):
        calibrated = rs.calibrate(bodies, "mercury-bshp", speed, contact=contact)
        assert calibrated.wall == (contact == "wall")
        assert calibrated.collisions.mass == pytest.approx(parts * mass)
        assert calibrated.collisions.reduced_radius == pytest.approx(parts * radius)
        exact = rs.solve(rs.collision(*others, speed))
        assert calibrated.restitution_coefficient(speed) == pytest.approx(exact.restitution_coefficient, rel=1e-7)
        assert calibrated.contact_time(speed) == pytest.approx(exact.contact_time, rel=1e-7)
        words = "a ball and a wall of its material" if contact == "wall" else "two equal balls"
        assert words in calibrated.snippet
        assert words in str(calibrated)


@pytest.mark.parametrize(
    ("problem", "contact"),
    [
        ((BALL, rs.Body(RUBBER, 0.011)), "wall"),
        ((BALL, rs.Body(RUBBER, 0.01, 1.0)), "wall"),
        ((BALL, rs.Body(None, 0.01, BALL.mass)), "wall"),
        ((BALL, rs.Body(rs.kelvin_voigt(1e6, 50.0, poisson_ratio=0.5), 0.01, BALL.mass)), "wall"),
        ((rs.Body(None, 0.01, 1.0), rs.Body(RUBBER)), "pair"),
        ((rs.Body(RUBBER, 0.01, math.inf), rs.Body(RUBBER, math.inf, 1.0)), "pair"),
        (rs.collision(BALL, WALL, 1.0), "pair"),
        (rs.collision(BALL, BALL, 1.0), "wall"),
    ],
)
def test_bodies_that_do_not_determine_the_other_contact_are_refused(problem, contact):
    assert named(lambda: rs.calibrate(problem, "liggghts", 0.1, contact=contact)) == ("contact", contact)


def test_table_over_velocity_and_radius():
    calibrated = rs.calibrate((BALL, BALL), "liggghts", (0.1, 1.0), radius=(0.005, 0.02), points=5)
    table = calibrated.table
    assert table["error"].dims == ("velocity", "radius")
    for i, j in ((0, 0), (4, 4), (2, 1)):
        body = rs.Body(RUBBER, radius=float(table["radius"][j]))
        exact = rs.solve(rs.collision(body, body, float(table["velocity"][i])))
        assert float(table["restitution_coefficient"][i, j]) == pytest.approx(exact.restitution_coefficient, rel=1e-8)
        assert float(table["contact_time"][i, j]) == pytest.approx(exact.contact_time, rel=1e-8)
        promise = calibrated.contact_time(float(table["velocity"][i]), float(table["radius"][j]))
        assert float(table["calibrated_contact_time"][i, j]) == pytest.approx(promise, rel=1e-12)
    assert calibrated.largest_error == float(np.abs(table["error"]).max())


def test_ranges_within_levels():
    calibrated = rs.calibrate((BALL, WALL), "lammps-coeff-restitution", (0.01, 10.0))
    table = calibrated.table
    for level, ranges in calibrated.within.items():
        inside = np.any([(table["velocity"] >= a) & (table["velocity"] <= b) for a, b in ranges], axis=0)
        np.testing.assert_array_equal(inside, np.abs(table["error"]) <= level)


def test_given_coefficient_and_measured_table():
    """The law has the coefficient, and the stiffness of the material."""
    calibrated = rs.calibrate((BALL, BALL), "lammps-tsuji", (0.1, 2.0), restitution=0.8, points=5)
    for wrong in (0.0, 1.5):
        with pytest.raises(rs.InputError, match=r"restitution = .*: must be in \(0, 1\]"):
            rs.calibrate((BALL, BALL), "lammps-tsuji", (0.1, 2.0), restitution=wrong)
    assert calibrated.restitution_coefficient([0.1, 0.7, 2.0]) == pytest.approx(0.8, rel=1e-7)
    assert np.isnan(calibrated.table["contact_time"]).all()
    static = rs.reduced_modulus(RUBBER, RUBBER).equilibrium_modulus
    assert calibrated.law.modulus == pytest.approx(static, rel=1e-8)
    # The figure of Tsuji and the pull differ from e as typed.
    assert calibrated.parameters["e"].value != pytest.approx(0.8, abs=0.02)
    speeds, values = [1.0, 0.1, 0.4], [0.7, 0.85, 0.78]
    calibrated = rs.calibrate((BALL, BALL), "mercury-bshp", restitution=(speeds, values))
    assert calibrated.table["restitution_coefficient"].values.tolist() == [0.85, 0.78, 0.7]
    assert rs.calibrate((BALL, BALL), "rebound", (0.2, 2), restitution=(speeds, values)).velocity == (0.4, 1.0)


@pytest.mark.parametrize("units", ["si", "cgs", "micro", "lj"])
def test_numbers_in_the_snippet(units):
    """The text contains the numbers of the parameters, and the time step is a hundredth of the shortest contact."""
    calibrated = rs.calibrate((BALL, BALL), "lammps-viscoelastic", (0.1, 1.0), units=units, points=5)
    line = next(line for line in calibrated.snippet.splitlines() if line.startswith("pair_coeff"))
    typed = [float(word) for word in re.findall(r"material (\S+) (\S+) (\S+) ", line)[0]]
    assert typed == pytest.approx([calibrated.parameters[name].value for name in ("E", "eta_n0", "nu")], rel=1e-7)
    step = float(re.search(r"time step at most (\S+)", calibrated.snippet)[1])
    second = {"si": 1.0, "cgs": 1.0, "micro": 1e-6, "lj": 0.02 / 1.0}[units]
    assert step * second * 100 == pytest.approx(calibrated.contact_time(1.0), rel=6e-3)


def test_lj_units_are_mass_diameter_and_highest_velocity():
    """In them the modulus is E sigma^3/(m v^2)."""
    si, lj = (rs.calibrate((BALL, BALL), "lammps-viscoelastic", (0.1, 2.0), units=u, points=3) for u in ("si", "lj"))
    factor = (2.0 * BALL.radius) ** 3 / (BALL.mass * 2.0**2)
    assert lj.parameters["E"].value == pytest.approx(si.parameters["E"].value * factor, rel=1e-12)


def test_tsuji_of_later_versions():
    """With the factor sqrt(2) of later versions of LAMMPS, e_later gives the same damping."""
    calibrated = rs.calibrate((BALL, BALL), "lammps-tsuji", 0.5)
    e, later = (calibrated.parameters[name].value for name in ("e", "e_later"))
    assert math.sqrt(2.0) * tsuji_strength(later) == pytest.approx(tsuji_strength(e), rel=1e-9)
    assert f"need e = {later:.8g}" in calibrated.snippet


def test_rebound_snippet_runs():
    """The function of the text returns the exact e at the velocities of the table."""
    calibrated = rs.calibrate((BALL, BALL), "rebound", (0.1, 1.0), points=5)

    class Simulation:
        pass

    scope = {"sim": Simulation()}
    exec(calibrated.snippet, scope)
    for sign in (1.0, -1.0):
        got = [scope["coefficient_of_restitution"](None, sign * v) for v in calibrated.collisions.velocity]
        assert got == pytest.approx(calibrated.collisions.restitution_coefficient[:, 0].tolist(), abs=1e-8)


def test_one_table_for_all_sizes():
    """At each velocity the table lies in the middle of the coefficients of all radii, by ratios."""
    calibrated = rs.calibrate((BALL, BALL), "rebound", (0.1, 1.0), radius=(0.005, 0.02), points=3)
    e = calibrated.collisions.restitution_coefficient
    ratios = calibrated.restitution_coefficient(calibrated.collisions.velocity)[:, None] / e
    np.testing.assert_allclose(ratios.max(axis=1) * ratios.min(axis=1), 1.0, rtol=1e-12)


@pytest.mark.parametrize("target", ["mercury-bshp", "yade-mindlin", "kratos-dem"])
def test_balls_of_two_sizes_are_no_worse(target):
    calibrated = rs.calibrate((BALL, BALL), target, (0.1, 1.0), radius=(0.005, 0.02), points=3)
    speeds = calibrated.collisions.velocity
    sizes = rs.Body(RUBBER, radius=0.005), rs.Body(RUBBER, radius=RNG.uniform(0.006, 0.02))
    pairs = [rs.collision(*sizes, float(speed)) for speed in speeds]
    e, _ = calibrated.law.rebound(speeds, pairs[0].mass, pairs[0].profile.radius)
    exact = [rs.solve(pair).restitution_coefficient for pair in pairs]
    assert np.abs(e / exact - 1.0).max() <= calibrated.largest_error


@pytest.mark.parametrize("target", ["lammps-tsuji", "rebound"])
def test_results_can_be_pickled(target):
    calibrated = rs.calibrate((BALL, BALL), target, (0.1, 1.0), points=3)
    assert pickle.loads(pickle.dumps(calibrated)).to_dict() == calibrated.to_dict()


def test_json_words_and_pictures(tmp_path):
    calibrated = rs.calibrate((BALL, BALL), "lammps-viscoelastic", restitution=([0.1, 1.0], [0.9, 0.8]))
    content = json.loads(calibrated.to_json(tmp_path / "law.json"))
    assert json.loads((tmp_path / "law.json").read_text()) == content
    assert content["parameters"]["E"]["value"] == calibrated.parameters["E"].value
    assert content["table"]["contact_time"] == [None, None]
    assert "eta_n0" in str(calibrated)
    assert "two balls at 0.1 to 1 m/s" in str(calibrated)
    assert len(calibrated.plot().axes) == 3
    assert len(rs.calibrate((BALL, BALL), "rebound", (0.1, 1.0), radius=(0.01, 0.02), points=3).plot().axes) == 2


@pytest.mark.parametrize(
    ("changes", "field", "words"),
    [
        ({"target": "lammps-tsui"}, "target", ""),
        ({"velocity": (2.0, 2.0)}, "velocity", ""),
        ({"velocity": None}, "velocity", "must be given"),
        ({"velocity": -1.0}, "velocity", ""),
        ({"restitution": 0.05}, "target", "reaches e from 0.26"),
        ({"restitution": 0.99999}, "target", ""),
        ({"restitution": 1.5}, "restitution", ""),
        ({"restitution": 0.0}, "restitution", ""),
        ({"restitution": ([1.0], [0.5, 0.6])}, "restitution", "two columns"),
        ({"restitution": ([10.0], [0.5])}, "velocity", "must contain a velocity"),
        ({"units": "metal"}, "units", "'lj' for lammps-tsuji"),
        ({"units": "cgs", "target": "mercury-bshp"}, "units", ""),
        ({"contact": "rope"}, "contact", ""),
        ({"radius": 0.0}, "radius", ""),
        ({"points": 1}, "points", ""),
        ({"problem": 3}, "problem", "must be an Impact or a pair of Body"),
        ({"problem": rs.Impact(RUBBER, rs.Cone(0.5), 1.0, 1.0)}, "profile", "must be a Parabola"),
        ({"problem": rs.drop(BALL, WALL, 1.0)}, "external_force", ""),
        ({"problem": rs.Impact(RUBBER, rs.Parabola(0.01), [1.0, 2.0], 1.0)}, "impact", "must be single"),
        ({"problem": (rs.Body(rs.maxwell(1e6, 1e-3, bulk_modulus=math.inf, density=1e3), 0.01), WALL)},
         "velocity", ""),
    ],
)  # fmt: skip
def test_errors_are_one_line(changes, field, words):
    arguments = {"problem": (BALL, BALL), "target": "lammps-tsuji", "velocity": (0.1, 1.0)} | changes
    error = in_one_line(lambda: rs.calibrate(**arguments))
    assert error.field == field
    if error.value is not ABSENT and field in arguments:
        assert error.value == pytest.approx(arguments[field])
    assert words in error.rule


def test_the_velocity_of_an_impact_does_not_matter():
    assert rs.calibrate(rs.collision(BALL, WALL, [1.0, 2.0]), "lammps-tsuji", (0.1, 1.0), points=3).wall


def test_velocities_outside_the_window_of_the_material():
    """The message names the velocities whose contacts lie within the window."""
    measured = rs.Material(RUBBER.shear, RUBBER.bulk, density=1100.0, window=(1e-4, 1e-2))
    body = rs.Body(measured, radius=0.01)
    error = in_one_line(lambda: rs.calibrate((body, body), "mercury-bshp", (1e-3, 100.0)))
    low, high = (float(x) for x in re.search(r"in \[(\S+), (\S+)\] m/s", error.rule).groups())
    rs.calibrate((body, body), "mercury-bshp", (low, high))
    assert rs.calibrate((body, body), "mercury-bshp", (1e-3, 100.0), extrapolate=True).warnings


def test_elastic_balls_have_no_damping():
    steel = rs.Body(rs.elastic(youngs_modulus=2e11, poisson_ratio=0.3, density=7800.0), radius=0.01)
    calibrated = rs.calibrate((steel, steel), "lammps-viscoelastic", (0.1, 1.0), points=3)
    assert calibrated.parameters["eta_n0"].value == 0.0
    assert calibrated.parameters["E"].value == pytest.approx(2e11, rel=1e-4)
    assert nearest(calibrated.law.law, calibrated.collisions) == calibrated.law


@pytest.mark.parametrize("target", ["acusolve", "solfec", "rebound"])
def test_a_table_has_e_at_all_velocities(target):
    calibrated = rs.calibrate((BALL, WALL), target, (0.01, 0.4), points=7)
    numbers = set(re.findall(r"\d+\.\d+(?:e-?\d+)?", calibrated.snippet))
    exact = rs.solve(rs.collision(BALL, WALL, np.geomspace(0.01, 0.4, 7)), rtol=1e-9).restitution_coefficient
    typed = [float(number) for number in numbers]
    assert all(np.min(np.abs(np.array(typed) - e)) < 2e-8 for e in exact)
    assert calibrated.largest_error < 1e-7


@pytest.mark.parametrize("target", ["box2d", "bullet", "physx"])
def test_a_single_e_is_the_middle_and_no_bounce_is_swallowed(target):
    calibrated = rs.calibrate((BALL, WALL), target, (0.01, 0.4), points=9)
    e = rs.solve(rs.collision(BALL, WALL, np.geomspace(0.01, 0.4, 9)), rtol=1e-9).restitution_coefficient
    typed = calibrated.parameters["restitution"].value
    assert typed / e.min() == pytest.approx(e.max() / typed, rel=1e-7)
    assert calibrated.parameters["threshold"].value == pytest.approx(0.005)
    assert f"{typed:.8g}f" in calibrated.snippet
    assert "0.005f" in calibrated.snippet


def test_drake_types_two_geometries_in_series():
    """k = k1 k2/(k1 + k2) of two equal geometries is half of each (documentation of Drake)."""
    calibrated = rs.calibrate((BALL, WALL), "drake", (0.05, 0.5), points=5)
    assert calibrated.parameters["point_contact_stiffness"].value == pytest.approx(2.0 * calibrated.law.modulus)
    d = calibrated.parameters["hunt_crossley_dissipation"].value
    assert f"less than 1/d, here 1/({d:.8g} s/m)" in calibrated.snippet
    assert 0.5 * calibrated.restitution_coefficient(0.5) < 1.0 / d
