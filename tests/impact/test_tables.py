"""Tabulated profiles against closed forms, even if the first table is too short."""

import math

import numpy as np
import pytest

from restitution import Impact, Material, Parabola, PronySeries, Status, Tabulated, solve, standard_solid
from scipy_oracle import solve_by_scipy

# Many of these bodies exceed the limits of the theory.
pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")

RADII = np.linspace(0.0, 50.0, 101)
TABLE = Tabulated(RADII, RADII**2 / 2.0)


# Under their weight these bodies creep to far greater depths than the impact alone would reach.
@pytest.mark.parametrize(
    ("series", "force", "status"),
    [
        (PronySeries(0.01, [40.0], [0.01], parallel_viscosity=5.0), 3.0, Status.CAPTURED),
        (PronySeries(0.0, parallel_viscosity=0.5), 1.0, Status.SINKS_IN),
        (PronySeries(0.0, [0.5], [0.03], parallel_viscosity=3.0), 0.1, Status.SINKS_IN),
        (PronySeries(1.0, [3.0], [0.5]), 0.3, Status.SEPARATED),
    ],
)
def test_tables_and_closed_forms_agree_under_a_weight(series, force, status):
    table, parabola = (
        solve(Impact(Material(series, math.inf), profile, 1.0, 1.0, external_force=force))
        for profile in (TABLE, Parabola(1.0))
    )
    assert table.status is parabola.status is status
    assert table.restitution_coefficient == pytest.approx(parabola.restitution_coefficient, rel=2e-8)


def rough_tip(seed: int) -> Tabulated:
    """Few points with a random slope between neighbours."""
    random = np.random.default_rng([seed, 7])
    r = np.linspace(0.0, 12.0, random.integers(6, 30))
    f = np.maximum.accumulate(0.5 * r**2 * np.exp(np.cumsum(random.normal(0.0, 0.05, r.size)))) + 1e-6 * r
    return Tabulated(r, f)


def noisy_tip(seed: int) -> Tabulated:
    """Many points of a paraboloid with noise."""
    random = np.random.default_rng([seed, 7])
    r = np.linspace(0.0, 12.0, random.integers(30, 200))
    return Tabulated(r, 0.5 * r**2 * (1.0 + 10.0 ** random.uniform(-8.0, -3.0) * random.normal(size=r.size)))


def stepped_tip(points: int, step: float) -> Tabulated:
    """Paraboloid with heights rounded to the resolution of an instrument; its contact radius jumps near the tip."""
    r = np.linspace(0.0, 12.0, points)
    return Tabulated(r, step * np.round(0.5 * r**2 / step))


# The tips with the largest errors among 600.
@pytest.mark.parametrize(
    "profile",
    [
        rough_tip(56),
        rough_tip(86),
        noisy_tip(84),
        noisy_tip(85),
        stepped_tip(66, 6.498532e-3),
        stepped_tip(491, 7.369162e-5),
    ],
)
@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-9])
def test_the_tolerance_holds_on_a_rough_surface(profile: Tabulated, rtol: float) -> None:
    depth = 10.0 ** np.linspace(-1.5, 0.2, 500)
    mass = profile.contact_radius(depth) * depth**2
    impact = Impact(standard_solid(1.0, 3.0, 1.0, poisson_ratio=0.5), profile, mass=mass, velocity=1.0)
    expected = solve(impact, rtol=1e-12).restitution_coefficient
    result = solve(impact, rtol=rtol).restitution_coefficient
    assert np.all(np.abs(result - expected) < rtol * np.maximum(expected, 1e-3))


@pytest.mark.slow
@pytest.mark.parametrize("profile", [rough_tip(56), noisy_tip(85)])
def test_a_rough_surface_without_a_table(profile: Tabulated) -> None:
    # SciPy's integrators on the profile itself, to 1e-9.
    mass = float(profile.contact_radius(1.0))
    impact = Impact(standard_solid(1.0, 3.0, 1.0, poisson_ratio=0.5), profile, mass=mass, velocity=1.0)
    expected = solve_by_scipy(impact, 1e-9).restitution_coefficient
    assert solve(impact, rtol=1e-9).restitution_coefficient == pytest.approx(expected, rel=2e-9)
