"""Loss tangent from a resilience: against materials whose loss tangent is known."""

import math

import numpy as np
import pytest

import restitution as rs
from refusals import in_one_line
from restitution.impact.batch import solve_columns
from restitution.impact.status import Status


def of_materials(materials, mass=0.25, velocity=1.98, radius=0.0075):
    """Resiliences in per cent and loss tangents at pi over the contact time."""
    impacts = [rs.Impact(material, rs.Parabola(radius), mass, velocity) for material in materials]
    columns = solve_columns(impacts, 1e-8)
    there = columns["status"] == Status.SEPARATED
    e, time = columns["restitution_coefficient"], columns["contact_time"]
    tangents = [
        material.shear.loss_tangent(math.pi / t) if ok else math.nan
        for material, t, ok in zip(materials, time, there, strict=True)
    ]
    return 100.0 * e**2, np.array(tangents)


def solids(count, seed, terms):
    rng = np.random.default_rng(seed)
    for _ in range(count):
        n = int(rng.integers(terms[0], terms[1] + 1))
        series = rs.PronySeries(rng.choice([0.0, 1e6]), 10 ** rng.uniform(4, 9, n), 10 ** rng.uniform(-7, 0, n))
        yield rs.Material(series, math.inf)


@pytest.mark.parametrize("exponent", [0.02, 0.1, 0.25, 0.4, 0.6])
def test_loss_tangent_of_a_power_law(exponent):
    # tan(pi n/2) at all frequencies. The relation does not depend on mass, velocity, radius and modulus.
    gel = rs.FractionalMaterial(rs.springpot(3e5, exponent), bulk=math.inf)
    result = rs.solve(rs.for_contact(lambda window: rs.Impact(gel.within(window), rs.Parabola(0.02), 0.01, 0.3)))
    implied = rs.implied_loss_tangent(float(100.0 * result.restitution_coefficient**2))
    assert implied.loss_tangent == pytest.approx(math.tan(0.5 * math.pi * exponent), rel=2e-3)
    assert implied.low < implied.loss_tangent < implied.high


@pytest.mark.parametrize(("thickness", "ratio", "low"), [(0.0081, 0.5, 0.005), (0.0019, 2.0, 0.0105)])
def test_the_relation_hardly_changes_on_a_pad(thickness, ratio, low):
    gel, pad = rs.FractionalMaterial(rs.springpot(3e5, 0.2), bulk=math.inf), rs.Layer(rs.Parabola(0.0075), thickness)
    result = rs.solve(rs.for_contact(lambda window: rs.Impact(gel.within(window), pad, 0.25, 0.5)))
    assert result.max_contact_radius / thickness == pytest.approx(ratio, rel=0.04)
    implied = rs.implied_loss_tangent(float(100.0 * result.restitution_coefficient**2))
    assert implied.loss_tangent == pytest.approx((1.0 - low) * math.tan(0.1 * math.pi), rel=1e-3)


@pytest.mark.parametrize(("terms", "outside"), [((1, 1), 0.01), ((2, 7), 0.06)])
def test_range_over_prony_series(terms, outside):
    resilience, tangent = of_materials(list(solids(400, 5, terms)))
    inside = (resilience > 1.0) & (resilience < 99.5)
    assert inside.sum() > 150
    ranges = np.array([rs.implied_loss_tangent(percent)[1:] for percent in resilience[inside]])
    assert np.all(tangent[inside] > (1.0 - outside) * ranges[:, 0])
    assert np.all(tangent[inside] < (1.0 + outside) * ranges[:, 1])


@pytest.mark.parametrize("viscosity", [20.0, 100.0, 300.0])
def test_kelvin_voigt_has_the_lowest_loss_tangent(viscosity):
    resilience, tangent = of_materials([rs.kelvin_voigt(1e6, viscosity, poisson_ratio=0.5)])
    assert 40.0 < resilience[0] < 99.0
    assert tangent[0] == pytest.approx(rs.implied_loss_tangent(resilience[0]).low, rel=5e-3)


@pytest.mark.parametrize("ratio", [0.05, 0.3, 2.0, 8.0])
def test_the_weakest_branch_has_nearly_the_highest_loss_tangent(ratio):
    # No weaker branch reaches so low a resilience at any relaxation time.
    times = np.geomspace(3e-5, 3e-2, 200)
    resilience, tangent = of_materials([rs.Material(rs.PronySeries(1e6, [ratio * 1e6], [t]), math.inf) for t in times])
    lowest = int(np.argmin(resilience))
    assert 0.93 < tangent[lowest] / rs.implied_loss_tangent(resilience[lowest]).high < 1.01


def test_formula_of_single_bounces():
    # tan delta = -0.815 ln e to 3 % for a power law.
    for e in np.linspace(0.35, 0.99, 9):
        implied = rs.implied_loss_tangent(100.0 * e**2)
        assert implied.loss_tangent == pytest.approx(-0.815 * math.log(e), rel=0.035)


def test_loss_tangent_falls_with_the_resilience():
    implied = np.array([rs.implied_loss_tangent(percent) for percent in np.linspace(1.0, 99.5, 80)])
    assert np.all(np.diff(implied, axis=0) < 0.0)
    assert np.all(implied[:, 1] < implied[:, 0])
    assert np.all(implied[:, 0] < implied[:, 2])


@pytest.mark.parametrize("rebound", [120.0, 0.0, -3.0, 100.0, math.nan, [50.0, 60.0], "much"])
def test_impossible_resiliences_are_refused(rebound):
    assert in_one_line(lambda: rs.implied_loss_tangent(rebound)).field == "rebound_resilience"
