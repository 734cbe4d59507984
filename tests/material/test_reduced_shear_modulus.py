"""G* = (8/3)G(3K + G)/(3K + 2G) against arithmetic on the Carson transforms and closed forms; Dundurs' parameter."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from refusals import named
from restitution import (
    Material,
    PronySeries,
    dundurs_parameter,
    reduced_modulus,
    reduced_shear_modulus,
    standard_solid,
)
from strategies import materials

pytestmark = pytest.mark.plain

S = np.geomspace(1e-14, 1e14, 113)
# Sums of positive terms and products of up to a hundred factors with three roundings each.
ROUNDING = 5e-14


def direct(material, s):
    """G* by arithmetic on the Carson transforms of G and K."""
    g = material.shear.carson_transform(s)
    if material.is_incompressible:
        return 8.0 / 3.0 * g
    k = material.bulk.carson_transform(s)
    return 8.0 / 3.0 * g * ((3.0 * k + g) / (3.0 * k + 2.0 * g))


@given(materials(liquid=None, viscosity=None))
def test_any_material_by_arithmetic_on_the_transforms(material):
    series = reduced_shear_modulus(material)
    assert np.all(series.branch_moduli > 0)
    assert np.all(np.diff(series.relaxation_times) > 0)
    assert series.carson_transform(S) == pytest.approx(direct(material, S), rel=ROUNDING, abs=0)


@given(materials(), materials())
def test_compliances_of_two_bodies_add(first, second):
    g, h = direct(first, S), direct(second, S)
    series = reduced_shear_modulus(first, second)
    assert series.carson_transform(S) == pytest.approx(g * (h / (g + h)), rel=1e-13, abs=0)


@pytest.mark.parametrize("nu", [-1.0, -0.5, 0.0, 0.3, 0.45, 0.499999, 0.5])
def test_closed_form_of_the_standard_solid(nu):
    """1/G* = (3/8)[1/G + 1/(3K + G)] with a constant K: terms at tau and at tau (3K + 2G_0)/(3K + 2G_inf)."""
    g_inf, g_1, tau = 2.0, 10.0, 0.3
    solid = standard_solid(g_inf, g_1, tau * g_1, poisson_ratio=nu)
    series = reduced_shear_modulus(solid)
    g_0 = g_inf + g_1
    assert series.equilibrium_modulus == pytest.approx(4.0 * g_inf / (2.0 - nu), rel=1e-15, abs=0)
    if nu in (-1.0, 0.5):
        assert series.branch_moduli == pytest.approx([(4.0 if nu < 0 else 8.0) / 3.0 * g_1], rel=1e-15, abs=0)
        assert series.relaxation_times == pytest.approx([tau], rel=1e-15, abs=0)
        return
    k = solid.bulk.equilibrium_modulus
    stiff, soft = 3.0 * k + 2.0 * g_0, 3.0 * k + 2.0 * g_inf
    moduli = [4.0 / 3.0 * g_1, 12.0 * k * k * g_1 / (soft * stiff)]
    assert series.branch_moduli == pytest.approx(moduli, rel=4e-15, abs=0)
    assert series.relaxation_times == pytest.approx([tau, tau * stiff / soft], rel=1e-15, abs=0)


@given(st.floats(-1.0, 0.5), st.floats(0.1, 10.0))
def test_ratio_of_both_moduli_of_an_elastic_solid(nu, shear):
    """G*/E* = 2(1 - nu)/(2 - nu): 2/3 for an incompressible solid, 4/3 for nu = -1."""
    solid = Material(shear, math.inf if nu == 0.5 else 2.0 * shear * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu)))
    ratio = reduced_shear_modulus(solid).equilibrium_modulus / reduced_modulus(solid).equilibrium_modulus
    assert ratio == pytest.approx(2.0 * (1.0 - nu) / (2.0 - nu), rel=1e-14)


def test_rows_of_an_array_have_the_bits_of_single_materials():
    generator = np.random.default_rng(5)
    singles = [
        Material(PronySeries(g, weights, [1e-3, 1.0]), k)
        for g, k, weights in zip(
            generator.uniform(1, 9, 5), [0.0, 1.0, 5.0, 1e3, math.inf], generator.uniform(1, 99, (5, 2)), strict=True
        )
    ]
    several = reduced_shear_modulus(Material.stacked(singles))
    for n, single in enumerate(singles):
        assert several.row(n).simplified() == reduced_shear_modulus(single)


@pytest.mark.parametrize("static", [False, True])
def test_dundurs_parameter_by_its_definition(static):
    """beta = (3 E*/4)[1/(3 K1 + G1) - 1/(3 K2 + G2)], of random pairs; one sign changes with the order."""
    generator = np.random.default_rng(7)
    for _ in range(50):
        bodies, ends = [], []
        for _ in range(2):
            g_inf, g_1, k = generator.uniform(0.1, 10.0, 3)
            bodies.append(Material(PronySeries(g_inf, [g_1], [1.0]), k))
            ends.append((g_inf if static else g_inf + g_1, k))
        compliance = sum(0.25 / g + 0.75 / (3.0 * k + g) for g, k in ends)
        beta = 0.75 / compliance * (1.0 / (3.0 * ends[0][1] + ends[0][0]) - 1.0 / (3.0 * ends[1][1] + ends[1][0]))
        assert dundurs_parameter(*bodies, static=static) == pytest.approx(beta, rel=1e-12, abs=1e-14)
        assert dundurs_parameter(*bodies[::-1], static=static) == pytest.approx(-beta, rel=1e-12, abs=1e-14)


def test_contacts_without_coupling():
    soft, rubber = Material(PronySeries(1.0, [4.0], [1.0]), 4.0), Material(PronySeries(0.0, [4.0], [1.0]), math.inf)
    assert dundurs_parameter(soft, soft) == 0.0
    assert dundurs_parameter(rubber) == 0.0
    assert dundurs_parameter(rubber, Material(1.0, math.inf)) == 0.0
    # A nearly rigid counter body is a rigid one: (1 - 2 nu)/(2(1 - nu)) = 3G/(3K + 4G).
    assert dundurs_parameter(soft, Material(1e12, 1e12)) == pytest.approx(15.0 / 32.0, rel=1e-11)
    assert dundurs_parameter(soft, static=True) == pytest.approx(3.0 / 16.0, rel=1e-15)


def test_other_types_are_refused():
    assert named(lambda: reduced_shear_modulus(1.0)) == ("material", 1.0)
    assert named(lambda: dundurs_parameter(Material(1.0, 1.0), 2.0)) == ("counter_material", 2.0)
