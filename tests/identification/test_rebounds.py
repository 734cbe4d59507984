"""Rebounds as observations: predictions, whitened residuals, and refused data."""

import math

import numpy as np
import pytest
from tests.identification.balls import rebounds, standard_solid

import restitution as rs
from refusals import in_one_line
from restitution.errors import InputError
from restitution.identification.parameters import column

# Many of these bodies exceed the limits of the theory.
pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")

SOLID = standard_solid(1e8, 1e9, 1e-4)
NONE = np.empty((1, 0))


def _columns(*materials):
    return column(materials)


def test_predictions_of_many_materials_are_those_of_solve():
    materials = [standard_solid(1e8, 1e9, 1e-4), standard_solid(2e8, 3e8, 1e-3, bulk_modulus=1e9)]
    velocity, radius = [0.01, 0.1, 0.05], [0.01, 0.02, 0.005]
    balls = rs.Rebounds(velocity, 0.5, radius=radius, mass=0.03, external_force=0.01)
    fit = balls.predicted(_columns(*materials))
    for n, material in enumerate(materials):
        exact = rs.solve(rs.Impact(material, rs.Parabola(radius), 0.03, velocity, external_force=0.01))
        for name, values in fit.items():
            np.testing.assert_allclose(values[n], getattr(exact, name), rtol=1e-8)


@pytest.mark.parametrize("profile", [rs.Cone(half_angle=1.2), rs.Sphere(radius=0.01)])
def test_any_profile_is_allowed(profile):
    exact = rs.solve(rs.Impact(SOLID, profile, 0.03, [0.01, 0.02]))
    balls = rs.Rebounds(
        [0.01, 0.02], exact.restitution_coefficient, profile=profile, mass=0.03, max_force=exact.max_force
    )
    np.testing.assert_allclose(balls.residuals(_columns(SOLID), NONE), 0.0, atol=1e-5)
    table = balls.effective_moduli()
    assert table is not None
    assert np.all(table.storage_modulus > 0.0)


def test_residuals_are_logarithms_for_relative_noise_and_differences_for_absolute_noise():
    exact = rs.solve(rs.Impact(SOLID, rs.Parabola(0.01), 0.03, 0.05))
    e, time = 0.9 * exact.restitution_coefficient, 1.1 * exact.contact_time
    noise = rs.Noise(restitution_coefficient=0.01, contact_time="2 %")
    balls = rs.Rebounds(0.05, e, radius=0.01, mass=0.03, contact_time=time, noise=noise)
    expected = [(exact.restitution_coefficient - e) / 0.01, -math.log(1.1) / 0.02]
    np.testing.assert_allclose(balls.residuals(_columns(SOLID), NONE)[0], expected, rtol=1e-6)


def test_error_of_the_velocity_whitens_both_quantities():
    """Residuals from a velocity that is wrong by one standard deviation have the norm 1."""
    share, sd = 0.02, 1e-4
    exact = rs.solve(rs.Impact(SOLID, rs.Parabola(0.01), 0.03, 0.05))
    rebound, wrong = exact.restitution_coefficient * 0.05, 0.05 * (1.0 + share)
    balls = rs.Rebounds(
        wrong, rebound / wrong, radius=0.01, mass=0.03, contact_time=exact.contact_time,
        noise=rs.Noise(restitution_coefficient=f"{100 * sd} %", contact_time=f"{100 * sd} %", velocity=f"{100 * share} %"),
    )  # fmt: skip
    residuals = balls.residuals(_columns(SOLID), NONE)[0]
    assert np.linalg.norm(residuals) == pytest.approx(1.0, rel=0.05)


def test_values_that_were_not_measured_are_left_out():
    balls = rs.Rebounds([0.1, 0.2], 0.5, radius=0.01, mass=0.03, contact_time=[math.nan, 1e-3])
    assert balls.size == 3
    assert np.all(np.isfinite(balls.residuals(_columns(SOLID), NONE)))


def test_a_captured_body_gives_a_row_of_nan():
    liquid = rs.Material(rs.PronySeries(0.0, [1e6], [1e-5]), math.inf)
    balls = rs.Rebounds([0.1, 0.2], 0.5, radius=0.01, mass=0.03, external_force=0.3)
    residuals = balls.residuals(_columns(SOLID, liquid), NONE)
    assert np.all(np.isfinite(residuals[0]))
    assert np.any(np.isnan(residuals[1]))


def test_time_and_force_give_the_same_window():
    exact = rs.solve(rs.Impact(standard_solid(1e8, 1e5, 1e-4), rs.Parabola(0.01), 0.03, [0.01, 0.1]))
    bodies = {"radius": 0.01, "mass": 0.03}
    e = exact.restitution_coefficient
    by_time = rs.Rebounds([0.01, 0.1], e, contact_time=exact.contact_time, **bodies)
    by_force = rs.Rebounds([0.01, 0.1], e, max_force=exact.max_force, **bodies)
    np.testing.assert_allclose(by_force.window(), by_time.window(), rtol=1e-3)
    alone = rs.Rebounds([0.01, 0.1], e, **bodies)
    assert alone.effective_moduli() is None
    assert not alone.fixes_time
    assert math.isnan(alone.window()[0])


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"restitution_coefficient": 1.2}, "restitution_coefficient"),
        ({"restitution_coefficient": [0.5, 0.0]}, "restitution_coefficient"),
        ({"restitution_coefficient": math.nan}, "restitution_coefficient"),
        ({"contact_time": 0.0}, "contact_time"),
        ({"contact_time": [math.nan, math.nan]}, "contact_time"),
        ({"contact_time": 1.8}, "contact_time"),  # ms taken for s
        ({"max_force": -1.0}, "max_force"),
        ({"velocity": [0.1, -0.2]}, "velocity"),
        ({"velocity": [0.1, 0.2, 0.3]}, "velocity, mass, external_force, radius, restitution_coefficient"),
        ({"mass": 0.0}, "mass"),
        ({"radius": None}, "radius, profile"),
        ({"profile": rs.Parabola(0.01)}, "radius, profile"),
        ({"radius": None, "profile": "ball"}, "profile"),
        ({"noise": rs.Noise(contact_time="1 %"), "contact_time": 1e-3}, "noise.restitution_coefficient"),
        ({"noise": rs.Noise(max_force="1 %")}, "noise.max_force"),
        ({"noise": rs.Noise(restitution_coefficient="-1 %")}, "noise.restitution_coefficient"),
        ({"temperature": -5.0}, "temperature"),
    ],
)
def test_wrong_data_are_refused_in_one_line(change, field):
    columns = {"velocity": [0.1, 0.2], "restitution_coefficient": [0.5, 0.6], "radius": 0.01, "mass": 0.03} | change
    assert in_one_line(lambda: rs.Rebounds(**columns)).field == field


def test_numbers_with_units_are_converted():
    from restitution.units import unit_registry

    unit = unit_registry()
    balls = rs.Rebounds(
        [10.0] * unit("cm/s"), 0.5, radius=10.0 * unit.mm, mass=30.0 * unit.g, contact_time=1.0 * unit.ms
    )
    assert balls.velocity[0] == pytest.approx(0.1)
    assert balls.contact_time[0] == pytest.approx(1e-3)


def test_contact_times_collapse_on_kappa():
    """R = 10 mm at 1 m/s and R = 5 mm at 1/32 m/s have the same kappa = sqrt(R v)/m of balls of one density, so e."""
    balls = rebounds(standard_solid(1e8, 1e9, 1e-4), np.array([0.01, 0.005]), np.array([1.0, 1.0 / 32.0]))
    assert balls.restitution_coefficient[0] == pytest.approx(balls.restitution_coefficient[1], rel=1e-8)


STIFF = rs.elastic(shear_modulus=3e8, poisson_ratio=0.3)
LOSSY = standard_solid(2e8, 5e8, 3e-4)
BOTH = ("same", STIFF, LOSSY)


def _pair(material, counter, **options):
    """Exact rebounds of two balls of 10 and 20 mm, and the impact."""
    partner = material if counter == "same" else counter
    radii, masses = np.array([[0.01], [0.02]]), np.array([[0.004], [0.03]])
    radius, mass = (float(np.prod(pair) / pair.sum()) for pair in (radii, masses))
    velocity = np.geomspace(0.001, 0.3, 10)
    exact = rs.solve(rs.Impact(material, rs.Parabola(radius), mass, velocity, counter_material=partner))
    return exact, rs.Rebounds(
        velocity, exact.restitution_coefficient, radius=radius, mass=mass, counter_material=counter,
        **{name: getattr(exact, name) if value is True else value for name, value in options.items()},
    )  # fmt: skip


@pytest.mark.parametrize("counter", BOTH, ids=["same", "elastic", "lossy"])
@pytest.mark.parametrize("material", [SOLID, rs.kelvin_voigt(1e8, 1e4, poisson_ratio=0.4)], ids=["solid", "kelvin"])
def test_two_bodies_are_those_of_solve(material, counter):
    exact, balls = _pair(material, counter)
    fit = balls.predicted(_columns(material, LOSSY))
    for name, values in fit.items():
        np.testing.assert_allclose(values[0], getattr(exact, name), rtol=1e-8)


@pytest.mark.parametrize("counter", BOTH, ids=["same", "elastic", "lossy"])
def test_the_material_of_one_of_two_bodies_is_found(counter):
    noise = rs.Noise(restitution_coefficient="0.1 %", contact_time="0.1 %")
    _, balls = _pair(SOLID, counter, contact_time=True, noise=noise)
    fit = rs.identify(balls, "standard_solid", fixed={"poisson_ratio": 0.5}, profiles=False)
    values = [estimate.value for estimate in fit.parameters.values()]
    np.testing.assert_allclose(values, [1e8, 1e9, 1e5], rtol=1e-5)
    with pytest.raises(InputError, match="counter_material: must be rigid"):
        rs.effective_moduli(balls)


@pytest.mark.parametrize(
    ("model", "counter", "determined"),
    [("standard_solid", "same", False), ("standard_solid", STIFF, False), ("kelvin_voigt", STIFF, True)],
)
def test_restitution_with_a_known_body_determines_a_model_that_a_spring_in_series_changes(model, counter, determined):
    # A standard solid in series with a spring is a standard solid, a Kelvin-Voigt solid is not one of its kind.
    material = SOLID if model == "standard_solid" else rs.kelvin_voigt(2e7, 3e4, poisson_ratio=0.5)
    _, balls = _pair(material, counter, noise=rs.Noise(restitution_coefficient="0.1 %"))
    fit = rs.identify(balls, model, fixed={"poisson_ratio": 0.5}, profiles=False)
    assert any(estimate.exact for estimate in fit.flat_directions) is not determined
    if determined:
        np.testing.assert_allclose([estimate.value for estimate in fit.parameters.values()], [2e7, 3e4], rtol=1e-4)
