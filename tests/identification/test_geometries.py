"""Materials from contacts that are no profile on a half-space."""

import math
from itertools import product
from typing import Any

import numpy as np
import pytest

import restitution as rs
from refusals import named

GEL = rs.standard_solid(70.0, 270.0, 80.0, poisson_ratio=0.5)
DEPTH = np.linspace(1e-8, 3e-6, 60)
TIPS = {
    "pyramid": rs.Pyramid(math.radians(75), sides=4),
    "ellipsoid": rs.Ellipsoid(5e-6, 2e-6),
    "bonded layer": rs.Layer(rs.Parabola(2.5e-6), thickness=2e-6),
    "layer on a frictionless base": rs.Layer(rs.Cone(1.3), thickness=3e-6, base="frictionless"),
    "force law": rs.ForceLaw(
        DEPTH, 8.0 * rs.Parabola(2.5e-6).force_integral_at_depth(DEPTH), modulus=3.0, poisson_ratio=0.5
    ),
}


TIME = np.linspace(0.0, 2.8, 200)
HEIGHT = np.interp(TIME, [0.0, 1.4, 2.8], [0.0, 1.4e-6, 0.0])
THIN = TIPS["bonded layer"]


def curve_under(tip, scatter=0.0):
    force = rs.indent(GEL, tip, depth=HEIGHT - 0.4e-6, time=TIME).force
    noise = 0.01 * force.max()
    force = force + scatter * noise * np.random.default_rng(4).standard_normal(TIME.size)
    return rs.IndentationCurve(TIME, HEIGHT, force, profile=tip, noise=rs.Noise(force=noise))


@pytest.mark.parametrize("tip", TIPS)
def test_indentation_gives_the_moduli_of_its_material(tip):
    estimates = rs.identify(curve_under(TIPS[tip]), rs.standard_solid, fixed={"poisson_ratio": 0.5}).parameters
    assert [estimate.value for estimate in estimates.values()] == pytest.approx([70.0, 270.0, 80.0], rel=1e-3)


def test_noise_on_a_thin_layer_moves_the_moduli_by_their_errors():
    curve = curve_under(THIN, scatter=1.0)
    estimate = rs.identify(curve, rs.standard_solid, fixed={"poisson_ratio": 0.5}).parameters["equilibrium_modulus"]
    # A fit on a half-space is far off.
    half = rs.IndentationCurve(TIME, HEIGHT, curve.force, profile=THIN.profile)
    wrong = rs.identify(half, rs.standard_solid, fixed={"poisson_ratio": 0.5}).parameters["equilibrium_modulus"]
    assert abs(estimate.value - 70.0) < 4.0 * estimate.standard_error < 20.0
    assert wrong.value > 140.0


def test_a_bonded_layer_needs_an_incompressible_model():
    with pytest.raises(rs.InputError, match=r"^profile: is a bonded layer"):
        rs.identify(curve_under(THIN), rs.standard_solid, fixed={"poisson_ratio": 0.45})


def test_rebounds_and_force_histories_of_other_geometries():
    body = rs.Ellipsoid(0.02, 0.005)
    solid = rs.standard_solid(1e6, 1e7, 1e4, poisson_ratio=0.5)
    exact = rs.solve(rs.Impact(solid, body, 0.033, np.array([0.02, 0.1])))
    same = rs.solve(rs.Impact(solid, rs.Parabola(body.effective_radius), 0.033, np.array([0.02, 0.1])))
    noise = rs.Noise(restitution_coefficient="1 %", contact_time="1 %")
    options = {"mass": 0.033, "contact_time": exact.contact_time, "noise": noise}
    for geometry in (body, rs.Parabola(body.effective_radius)):
        balls = rs.Rebounds(exact.velocity, exact.restitution_coefficient, profile=geometry, **options)
        moduli = balls.effective_moduli().storage_modulus
        assert moduli == pytest.approx(rs.Rebounds(
            exact.velocity, same.restitution_coefficient, radius=body.effective_radius, **options
        ).effective_moduli().storage_modulus, rel=1e-9)  # fmt: skip
    history = rs.solve(rs.Impact(solid, body, 0.033, 0.1)).history
    measured = rs.ForceHistory(history.time.values, history.force.values, mass=0.033, velocity=0.1, profile=body)
    assert measured.profile is body
    assert named(lambda: rs.Rebounds([0.1], [0.5], profile=0.01, mass=0.033)) == ("profile", 0.01)


def test_a_bonded_layer_is_refused_where_the_model_does_not_give_its_poisson_ratio():
    layer = rs.Layer(rs.Parabola(0.01), thickness=2e-3)
    # The layer of an impact has the Poisson ratio of the material there, which the models need not have.
    of_impact = rs.Impact(rs.elastic(youngs_modulus=1e6, poisson_ratio=0.45), layer, 0.033, 1.0).profile
    records: list[tuple[Any, ...]] = [
        (rs.Rebounds, [0.5, 1.0], [0.5, 0.45]), (rs.ForceHistory, [0.0, 1e-3, 2e-3], [0.0, 1.0, 0.0]),
        (rs.BounceTimes, [0.1, 0.5, 0.8]),
    ]  # fmt: skip
    for (kind, *columns), profile in product(records, (layer, of_impact)):
        with pytest.raises(TypeError, match=r"^profile = Layer.*no bonded layer$"):
            kind(*columns, mass=0.033, profile=profile)
    sliding = rs.Layer(rs.Parabola(0.01), thickness=2e-3, base="frictionless")
    assert rs.Rebounds([0.5, 1.0], [0.5, 0.45], mass=0.033, profile=sliding).profile == sliding
