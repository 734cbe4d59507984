import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from refusals import named
from restitution import PronySeries, shear_from_tension, tension_from_shear
from restitution.material.conversion import series_connection
from strategies import logarithmic, prony_series

pytestmark = pytest.mark.plain

S = np.geomspace(1e-9, 1e9, 61)


@given(prony_series(liquid=None), logarithmic(1e-3, 1e6))
def test_shear_by_arithmetic_on_the_transforms(tension, room):
    """1/(3G) = 1/E - 1/(9K) for the Carson transforms."""
    bulk = tension.instantaneous_modulus / 9.0 * (1.0 + room)
    shear = shear_from_tension(tension, bulk_modulus=bulk)
    e = tension.carson_transform(S)
    # The difference suffers from cancellation as the instantaneous Poisson ratio approaches -1.
    tolerance = 1e-14 * (1.0 + 1.0 / room)
    assert shear.carson_transform(S) == pytest.approx(3 * bulk * e / (9 * bulk - e), rel=tolerance, abs=0)
    assert np.all(shear.branch_moduli > 0)
    assert shear.is_liquid == tension.is_liquid


@given(prony_series(liquid=None, viscosity=None), prony_series(liquid=None, viscosity=None))
def test_tension_with_a_relaxing_bulk(shear, bulk):
    g, k = shear.carson_transform(S), bulk.carson_transform(S)
    tension = tension_from_shear(shear, bulk_modulus=bulk)
    assert tension.carson_transform(S) == pytest.approx(9 * k * (g / (3 * k + g)), rel=1e-13, abs=0)


@given(prony_series(liquid=None, near_equal=False), logarithmic(1e-1, 1e3))
def test_conversion_and_back(shear, ratio):
    assume(shear.n_branches > 0)
    bulk = ratio * shear.instantaneous_modulus
    back = shear_from_tension(tension_from_shear(shear, bulk_modulus=bulk), bulk_modulus=bulk)
    t = np.geomspace(1e-8, 1e8, 33)
    assert back.carson_transform(S) == pytest.approx(shear.carson_transform(S), rel=1e-11, abs=0)
    assert back.relaxation_modulus(t) == pytest.approx(
        shear.relaxation_modulus(t), rel=1e-10, abs=1e-10 * shear.instantaneous_modulus
    )


def test_two_branches_by_the_quadratic():
    """E = 1 + s/(s+1) + s/(s+4) = 9 leads to 6 s^2 + 35 s + 32 = 0."""
    shear = shear_from_tension(PronySeries(1.0, [1.0, 1.0], [1.0, 0.25]), bulk_modulus=1.0)
    assert shear.relaxation_times == pytest.approx(np.sort(-1 / np.roots([6.0, 35.0, 32.0])), rel=1e-14)
    assert shear.equilibrium_modulus == pytest.approx(3.0 / 8.0, rel=1e-15)


def test_the_quotient_in_time_is_wrong():
    tension = PronySeries(9.0, [27.0], [1.0])
    e, bulk = tension.relaxation_modulus(0.5), 5.0
    exact = shear_from_tension(tension, bulk_modulus=bulk).relaxation_modulus(0.5)
    assert abs(3 * bulk * e / (9 * bulk - e) / exact - 1) > 0.1


@given(prony_series(), st.floats(-0.9, 0.5))
def test_constant_poisson_ratio_only_scales(tension, ratio):
    shear = shear_from_tension(tension, poisson_ratio=ratio)
    t = np.geomspace(1e-6, 1e6, 25)
    expected = tension.relaxation_modulus(t) / (2 * (1 + ratio))
    # Numbers below 2.2e-308 have fewer digits.
    assert shear.relaxation_modulus(t) == pytest.approx(expected, rel=1e-13, abs=1e-300)
    assert tension_from_shear(shear, poisson_ratio=ratio).relaxation_modulus(t) == pytest.approx(
        tension.relaxation_modulus(t), rel=1e-13, abs=0
    )


def test_incompressible_is_a_third():
    for constant in ({"bulk_modulus": math.inf}, {"poisson_ratio": 0.5}):
        shear = shear_from_tension(PronySeries(3.0, [6.0], [1.0]), **constant)
        assert shear.relaxation_modulus([0.0, 1e9]) == pytest.approx([3.0, 1.0], rel=1e-15, abs=0)
        assert tension_from_shear(shear, **constant).relaxation_modulus(0.0) == pytest.approx(9.0, rel=1e-15)


@pytest.mark.parametrize(
    ("keywords", "expected"),
    [
        ({}, ("bulk_modulus, poisson_ratio",)),
        ({"bulk_modulus": 1.0, "poisson_ratio": 0.3}, ("bulk_modulus, poisson_ratio",)),
        ({"bulk_modulus": -1.0}, ("bulk_modulus", -1.0)),
        ({"poisson_ratio": math.nan}, ("poisson_ratio", math.nan)),
    ],
)
def test_refuses(keywords, expected):
    assert named(lambda: shear_from_tension(PronySeries(3.0, [6.0], [1.0]), **keywords)) == expected


def test_limits_of_the_conversion():
    with pytest.raises(
        ValueError, match=r"^bulk_modulus = 1 Pa: must be > 1 Pa, a ninth of the instantaneous modulus"
    ):
        shear_from_tension(PronySeries(3.0, [6.0], [1.0]), bulk_modulus=1.0)
    with pytest.raises(ValueError, match=r"^poisson_ratio = -1: must be in \(-1, 0\.5\]$"):
        shear_from_tension(PronySeries(3.0, [6.0], [1.0]), poisson_ratio=-1.0)


def test_dashpot_in_tension_needs_an_infinite_bulk_modulus():
    series = PronySeries(3.0, parallel_viscosity=1.0)
    assert named(lambda: shear_from_tension(series, bulk_modulus=1.0)) == ("bulk_modulus", 1.0)
    assert shear_from_tension(series, bulk_modulus=math.inf).parallel_viscosity == pytest.approx(1.0 / 3.0)


def test_two_liquids_and_a_liquid_on_a_solid_stay_liquid():
    liquid, other = PronySeries(0.0, [1.0], [1.0]), PronySeries(0.0, [2.0], [5.0])
    assert series_connection(liquid, other).is_liquid
    assert series_connection(liquid, PronySeries(1.0, [1.0], [2.0])).is_liquid
    # Fluidities add: 1/eta = 1/(1*1) + 1/(2*5).
    assert series_connection(liquid, other).flow_viscosity == pytest.approx(10.0 / 11.0, rel=1e-15, abs=0)


def test_springs_and_dashpots():
    assert series_connection(PronySeries(3.0), PronySeries(6.0)) == PronySeries(2.0)
    two = series_connection(PronySeries(0.0, parallel_viscosity=3.0), PronySeries(0.0, parallel_viscosity=6.0))
    assert two == PronySeries(0.0, parallel_viscosity=2.0)
    assert series_connection(PronySeries(3.0), PronySeries(0.0)) == PronySeries(0.0)


@given(prony_series(max_branches=8), prony_series(max_branches=8))
def test_creep_compliances_add(first, second):
    t = np.geomspace(1e-8, 1e8, 33)
    total = first.creep_compliance(t) + second.creep_compliance(t)
    connected = series_connection(first, second)
    assert connected.creep_compliance(t) == pytest.approx(total, rel=1e-12, abs=0)


@given(prony_series(liquid=None, viscosity=None), prony_series(liquid=None, viscosity=None))
def test_no_more_branches_than_roots(first, second):
    connected = series_connection(first, second)
    assert connected.n_branches <= first.n_branches + second.n_branches + 1
