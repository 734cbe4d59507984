import math

import numpy as np
import pytest
from hypothesis import given

from restitution import Material, PronySeries, reduced_modulus, standard_solid
from strategies import materials

pytestmark = pytest.mark.plain

S = np.geomspace(1e-14, 1e14, 113)
# Sums of positive terms and products of up to a hundred factors with three roundings each.
ROUNDING = 5e-14


def direct(material, s):
    """E* = 4G(3K + G)/(3K + 4G) by arithmetic on the Carson transforms."""
    g = material.shear.carson_transform(s)
    if material.is_incompressible:
        return 4.0 * g
    k = material.bulk.carson_transform(s)
    return g * ((3.0 * k + g) / (0.75 * k + g))


def check(series, expected, tolerance=ROUNDING):
    assert np.all(series.branch_moduli > 0)
    assert np.all(np.diff(series.relaxation_times) > 0)
    assert series.carson_transform(S) == pytest.approx(expected, rel=tolerance, abs=0)


@pytest.mark.parametrize("nu", [-1.0, -0.5, 0.0, 0.3, 0.45, 0.499999, 0.5])
def test_closed_form_of_the_standard_solid(nu):
    """Section 2 of the theory: two terms in E*, one for nu = 1/2, and E* = G for nu = -1."""
    g_inf, g_1, tau = 2.0, 10.0, 0.3
    series = reduced_modulus(standard_solid(g_inf, g_1, tau * g_1, poisson_ratio=nu))
    g_0 = g_inf + g_1
    assert series.equilibrium_modulus == pytest.approx(2.0 * g_inf / (1.0 - nu), rel=4e-16, abs=0)
    if nu in (-1.0, 0.5):
        assert series.branch_moduli.tolist() == [g_1 if nu < 0 else 4.0 * g_1]
        assert series.relaxation_times == pytest.approx([tau], rel=4e-16, abs=0)
        return
    k = 2.0 * g_inf * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu))
    stiff, soft = 3.0 * k + 4.0 * g_0, 3.0 * k + 4.0 * g_inf
    assert series.branch_moduli == pytest.approx([g_1, 27.0 * k * k * g_1 / (soft * stiff)], rel=1e-15, abs=0)
    assert series.relaxation_times == pytest.approx([tau, tau * stiff / soft], rel=1e-15, abs=0)


def test_closed_form_at_the_ends_of_the_parameter_plane():
    """The same closed form with G_1/G_inf = 1e5 and 1e-3 and a Poisson ratio close to its limits."""
    for nu in (-1.0 + 1e-4, 0.5 - 1e-9):
        for g_1 in (1e-3, 1e5):
            material = standard_solid(1.0, g_1, g_1, poisson_ratio=nu)
            k = material.bulk.equilibrium_modulus
            stiff, soft = 3.0 * k + 4.0 * (1.0 + g_1), 3.0 * k + 4.0
            series = reduced_modulus(material)
            # Modulus and time of the second branch from the theory; the first branch is that of the shear modulus.
            order = np.argsort([1.0, stiff / soft])
            moduli = np.array([g_1, 27.0 * k * k * g_1 / (soft * stiff)])[order]
            assert series.branch_moduli == pytest.approx(moduli, rel=1e-14, abs=0)
            assert series.relaxation_times == pytest.approx([1.0, stiff / soft], rel=1e-15, abs=0)


@given(materials(liquid=None, viscosity=None))
def test_any_material_by_arithmetic_on_the_transforms(material):
    check(reduced_modulus(material), direct(material, S))


@given(materials(liquid=None, viscosity=None, times=(1e-10, 1e10), moduli=(1e-12, 1e12), max_branches=20))
def test_twenty_decades(material):
    check(reduced_modulus(material), direct(material, S))


@given(materials(liquid=None, viscosity=None), materials(liquid=None, viscosity=None))
def test_pair_adds_compliances(first, second):
    left, right = direct(first, S), direct(second, S)
    check(reduced_modulus(first, second), left * (right / (left + right)))


@given(materials(), materials())
def test_pair_does_not_depend_on_the_order(first, second):
    left, right = reduced_modulus(first, second), reduced_modulus(second, first)
    assert left.carson_transform(S) == pytest.approx(right.carson_transform(S), rel=ROUNDING, abs=0)


@given(materials(viscosity=None))
def test_two_equal_bodies_halve_the_modulus(material):
    pair, single = reduced_modulus(material, material), reduced_modulus(material)
    assert pair.carson_transform(S) == pytest.approx(0.5 * single.carson_transform(S), rel=ROUNDING, abs=0)
    assert pair.n_branches <= single.n_branches


def test_twenty_shear_and_twenty_bulk_terms_over_twenty_decades():
    shear = PronySeries(1.0, np.geomspace(1e9, 1.0, 20), np.geomspace(1e-10, 1e10, 20))
    for shift in (1.0, 1.0 + 2.3e-16, 1.0 + 1e-12, 1.5):
        bulk = PronySeries(3.0, np.geomspace(1e10, 1e3, 20), np.geomspace(1e-10, 1e10, 20) * shift)
        material = Material(shear, bulk)
        series = reduced_modulus(material)
        check(series, direct(material, S))
        assert series.n_branches <= 60


@pytest.mark.parametrize("weak", [float(f"1e{n}") for n in range(-20, 0)])
def test_weak_bulk_branch_at_a_time_of_the_reduced_modulus(weak):
    """Two roots lie on both sides of its pole, as close as 1e-8."""
    shear = PronySeries(1.0, [4.0, 3.0], [1.0, 30.0])
    for time in reduced_modulus(Material(shear, 4.0)).relaxation_times:
        for shift in (0.0, 1e-15, 1e-9):
            material = Material(shear, PronySeries(4.0, [weak], [time * (1.0 + shift)]))
            check(reduced_modulus(material), direct(material, S), 3e-15)


def test_complex_frequencies():
    """The complex modulus is accurate to rounding of its magnitude, although terms of both signs are summed."""
    shear = PronySeries(1.0, np.geomspace(1e3, 1.0, 10), np.geomspace(1e-5, 1e5, 10))
    bulk = PronySeries(30.0, np.geomspace(1e4, 1e3, 7), np.geomspace(1e-4, 1e4, 7))
    s = 1j * np.geomspace(1e-8, 1e8, 81)
    g, k = shear.carson_transform(s), bulk.carson_transform(s)
    expected = 4.0 * g * (3.0 * k + g) / (3.0 * k + 4.0 * g)
    error = np.abs(reduced_modulus(Material(shear, bulk)).carson_transform(s) / expected - 1.0)
    assert error.max() < 1e-14


def test_proportional_bulk_is_a_constant_poisson_ratio():
    """K = 5G/3 at all times means nu = 1/4 and E* = 2G/(1 - nu) = (8/3) G, with the times of G."""
    shear = PronySeries(2.0, [3.0, 5.0, 7.0], [1e-3, 1.0, 1e3])
    series = reduced_modulus(Material(shear, shear.scaled(5.0 / 3.0)))
    assert series.n_branches == 3
    assert series.relaxation_times.tolist() == shear.relaxation_times.tolist()
    assert series.branch_moduli == pytest.approx(shear.branch_moduli * 8.0 / 3.0, rel=1e-15, abs=0)


def test_proportional_kelvin_voigt_in_shear_and_bulk_needs_no_branch():
    """K = G at all times: E* = 4G(3K + G)/(3K + 4G) = 16 G/7, a spring and a dashpot."""
    series = PronySeries(10.0, parallel_viscosity=1.0)
    reduced = reduced_modulus(Material(series, series))
    assert reduced.n_branches == 0
    assert reduced.equilibrium_modulus == pytest.approx(160.0 / 7.0, rel=1e-15)
    assert reduced.parallel_viscosity == pytest.approx(16.0 / 7.0, rel=1e-15)


def test_elastic():
    series = reduced_modulus(Material(3.0, 5.0))
    assert series == PronySeries(8.0)
    # Steel on glass: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2, Johnson, Contact Mechanics, eq. (4.17b).
    steel, glass = Material(80e9, 400e9 / 3.0), Material(28e9, 140e9 / 3.0)
    young = [9 * k * g / (3 * k + g) for g, k in ((80e9, 400e9 / 3.0), (28e9, 140e9 / 3.0))]
    expected = 1.0 / sum((1 - 0.25**2) / e for e in young)
    assert reduced_modulus(steel, glass).equilibrium_modulus == pytest.approx(expected, rel=1e-15, abs=0)


def test_kelvin_voigt_in_shear_is_a_dashpot_and_one_term():
    """G = 1 + s, K = 4: E* = G + 9K/4 - (27K^2/4)/(3K + 4G) = 10 + s - 108/(16 + 4s), in closed form."""
    series = reduced_modulus(Material(PronySeries(1.0, parallel_viscosity=1.0), 4.0))
    assert series.parallel_viscosity == 1.0
    assert series.equilibrium_modulus == pytest.approx(10.0 - 108.0 / 16.0, rel=1e-15, abs=0)
    assert series.branch_moduli == pytest.approx([108.0 / 16.0], rel=1e-15, abs=0)
    assert series.relaxation_times == pytest.approx([0.25], rel=1e-15, abs=0)


def test_incompressible_kelvin_voigt():
    series = reduced_modulus(Material(PronySeries(1.0, parallel_viscosity=1.0), math.inf))
    assert series == PronySeries(4.0, parallel_viscosity=4.0)


def test_dashpot_against_elastic_wall_is_a_maxwell_body():
    series = reduced_modulus(Material(PronySeries(0.0, parallel_viscosity=3.0), math.inf), Material(2.0, math.inf))
    assert series.equilibrium_modulus == 0.0
    assert series.parallel_viscosity == 0.0
    assert series.branch_moduli == pytest.approx([8.0], rel=1e-15, abs=0)
    assert series.relaxation_times == pytest.approx([1.5], rel=1e-15, abs=0)
