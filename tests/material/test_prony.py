import math

import numpy as np
import pytest
from hypothesis import given

from refusals import in_one_line, named
from restitution import Material, PronySeries, burgers, fractional_zener, reduced_modulus, springpot
from strategies import prony_series

pytestmark = pytest.mark.plain


def test_relaxation_of_two_branches_by_hand():
    series = PronySeries(1.0, [2.0, 4.0], [1.0, 10.0])
    t = np.array([[0.0, 1.0], [10.0, 1e9]])
    expected = [[7.0, 1 + 2 / math.e + 4 * math.exp(-0.1)], [1 + 2 * math.exp(-10) + 4 / math.e, 1.0]]
    assert series.relaxation_modulus(t) == pytest.approx(np.array(expected), rel=1e-15, abs=0)


@given(prony_series(liquid=None, viscosity=None))
def test_dynamic_moduli_are_the_carson_transform_on_the_imaginary_axis(series):
    omega = np.geomspace(1e-8, 1e8, 33)
    value = series.carson_transform(1j * omega)
    assert series.storage_modulus(omega) == pytest.approx(value.real, rel=1e-13, abs=0)
    assert series.loss_modulus(omega) == pytest.approx(value.imag, rel=1e-13, abs=0)
    with np.errstate(divide="ignore"):
        assert series.loss_tangent(omega) == pytest.approx(value.imag / value.real, rel=1e-13, abs=0)


def test_standard_solid_storage_and_loss_at_the_peak():
    """Ferry (1980), ch. 3, one term at omega tau = 1: R_inf + R_1/2 and R_1/2."""
    series = PronySeries(2.0, [6.0], [0.25])
    assert (series.storage_modulus(4.0), series.loss_modulus(4.0)) == (5.0, 3.0)


def test_creep_of_the_standard_solid():
    """J = 1/R_inf - (1/R_inf - 1/R_0) exp(-t R_inf/(R_0 tau)) (Christensen, ch. 1)."""
    equilibrium, branch, tau = 2.0, 6.0, 0.25
    t = np.linspace(0.0, 5.0, 21)
    slow, fast = 1 / equilibrium, 1 / (equilibrium + branch)
    expected = slow - (slow - fast) * np.exp(-t * equilibrium / ((equilibrium + branch) * tau))
    assert PronySeries(equilibrium, [branch], [tau]).creep_compliance(t) == pytest.approx(expected, rel=1e-15, abs=0)


def test_creep_of_kelvin_voigt_and_maxwell():
    t = np.linspace(0.0, 5.0, 11)
    voigt = PronySeries(2.0, parallel_viscosity=6.0).creep_compliance(t)
    assert voigt == pytest.approx(0.5 * (1 - np.exp(-t / 3.0)), rel=1e-15, abs=0)
    assert PronySeries(0.0, [2.0], [3.0]).creep_compliance(t) == pytest.approx(0.5 + t / 6.0, rel=1e-15, abs=0)


@given(prony_series(liquid=None, viscosity=None))
def test_compliance_inverts_the_modulus(series):
    """J(s) R(s) = 1 for the Carson transforms, J from the retardation spectrum."""
    s = np.geomspace(1e-9, 1e9, 37)
    glass, fluidity, compliances, times = series.retardation
    assert np.all(compliances > 0)
    compliance = glass + fluidity / s + (1.0 / (1.0 + s[:, None] * times)) @ compliances
    assert compliance * series.carson_transform(s) == pytest.approx(np.ones(37), rel=1e-12, abs=0)


@given(prony_series(liquid=None, viscosity=None))
def test_simplified_is_the_same_function(series):
    short = series.simplified()
    assert np.all(np.diff(short.relaxation_times) > 0)
    assert np.all(short.branch_moduli > 0)
    t = np.geomspace(1e-9, 1e9, 37)
    assert short.relaxation_modulus(t) == pytest.approx(series.relaxation_modulus(t), rel=1e-12, abs=0)


def test_instantaneous_and_flow():
    assert PronySeries(1.0, [2.0, 3.0], [1.0, 2.0]).instantaneous_modulus == 6.0
    assert PronySeries(1.0, [2.0], [1.0], parallel_viscosity=1.0).instantaneous_modulus == math.inf
    assert PronySeries(0.0, [2.0, 3.0], [1.0, 2.0], parallel_viscosity=1.0).flow_viscosity == 9.0
    assert PronySeries(0.0, parallel_viscosity=1.0).relaxation_modulus([0.0, 1.0]).tolist() == [math.inf, 0.0]


def test_equality_and_hash_by_value():
    first, second = PronySeries(1.0, [2.0], [3.0]), PronySeries(1.0, np.array([2.0]), np.array([3.0]))
    assert first == second
    assert hash(first) == hash(second)
    assert first != PronySeries(1.0, [2.0], [3.0], parallel_viscosity=1.0)
    assert first != PronySeries(1.0, [2.0], [4.0])
    assert first != 1.0


def test_arrays_are_copied_and_read_only():
    moduli = np.array([2.0])
    series = PronySeries(1.0, moduli, [3.0])
    moduli[0] = 7.0
    assert series.branch_moduli[0] == 2.0
    with pytest.raises(ValueError, match="read-only"):
        series.branch_moduli[0] = 1.0
    with pytest.raises(AttributeError):
        series.parallel_viscosity = 1.0  # type: ignore[misc]


def test_the_repr_evaluates_to_the_series():
    series = PronySeries(1.0, [2.0, 0.1], [3.0, 1e-9], parallel_viscosity=5.0)
    assert eval(repr(series)) == series


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ((-1.0,), ("equilibrium_modulus", -1.0)),
        ((math.nan,), ("equilibrium_modulus", math.nan)),
        (([1.0, -2.0],), ("equilibrium_modulus", 1, -2.0)),
        ((1.0, [1.0, -2.0], [1.0, 2.0]), ("branch_moduli", 1, -2.0)),
        ((1.0, [1.0], [0.0]), ("relaxation_times", 0, 0.0)),
    ],
)
def test_bad_input_is_refused(arguments, expected):
    assert named(lambda: PronySeries(*arguments)) == expected


def test_shapes_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match="must be of equal length"):
        PronySeries(1.0, [1.0, 2.0], [1.0])
    with pytest.raises(ValueError, match="broadcast"):
        PronySeries([1.0, 2.0, 3.0], [[1.0], [2.0]], [1.0])


def test_zero_series_has_no_compliance():
    assert named(lambda: PronySeries(0.0).retardation) == ("equilibrium_modulus", 0.0)


def test_extreme_frequencies_do_not_overflow():
    series = PronySeries(1.0, [2.0], [1e100])
    assert series.storage_modulus([0.0, 1e-300, 1e100]).tolist() == [1.0, 1.0, 3.0]
    assert series.loss_modulus([0.0, 1e100]) == pytest.approx([0.0, 0.0], abs=1e-199)


def test_a_negligible_branch_is_dropped():
    """A branch of 1e-300 Pa beside 1 MPa changes nothing, but a single branch of 1e-300 Pa carries the load."""
    material = Material(PronySeries(1e6, [1e6, 1e-300], [1e-3, 1e-2]), 1e9)
    assert reduced_modulus(material) == reduced_modulus(Material(PronySeries(1e6, [1e6], [1e-3]), 1e9))
    slow = PronySeries(0.0, [1e6, 1e-70], [1e-3, 1e90])
    assert slow.simplified().n_branches == 2
    assert slow.relaxation_modulus(1.0) == 1e-70


@pytest.mark.parametrize(
    ("call", "field"),
    [
        (lambda: PronySeries(1e200), "equilibrium_modulus + sum of branch_moduli"),
        (lambda: PronySeries(0.0, [1e-200], [1.0]), "equilibrium_modulus + sum of branch_moduli"),
        (lambda: PronySeries(1.0, [1.0], [1e300]), "relaxation_times"),
        (lambda: PronySeries(1.0, [1.0], [5e-324]), "relaxation_times"),
        (lambda: PronySeries(1.0, parallel_viscosity=1e300), "parallel_viscosity"),
        (lambda: PronySeries(1.0, np.ones(1001), np.ones(1001)), "branch_moduli"),
        (lambda: PronySeries(1.0, [1.0], [1.0]).scaled(1e300), "equilibrium_modulus + sum of branch_moduli"),
        (lambda: burgers(1e6, 1e-300, 1e6, 1e3, bulk_modulus=1e9), "relaxation_times"),
        (lambda: fractional_zener(1.0, 1.0, 1e300, 0.5), "coefficient"),
        (lambda: fractional_zener(1.0, 1.0, 1e101, 0.01), "relaxation_time"),
        (lambda: springpot(1.0, 0.5).prony((1e-300, 1.0)), "window"),
    ],
)
def test_numbers_whose_products_overflow_are_refused(call, field):
    assert in_one_line(call).field == field


def test_functions_at_extreme_times_give_no_warning():
    """The values are the limits. Warnings are errors in the tests."""
    series = PronySeries(1.0, [2.0], [1e-3], parallel_viscosity=0.5)
    extreme = [1e-300, 1e308]
    assert series.relaxation_modulus(extreme).tolist() == [3.0, 1.0]
    assert series.storage_modulus(extreme) == pytest.approx([1.0, 3.0])
    assert series.creep_compliance(extreme) == pytest.approx([0.0, 1.0])
    assert PronySeries(0.0, [2.0], [1e-3]).creep_compliance([1e308])[0] == math.inf
    zener = fractional_zener(1.0, 2.0, 1e-3, 0.5)
    assert zener.relaxation_modulus(extreme) == pytest.approx([3.0, 1.0])
    assert zener.storage_modulus([0.0, *extreme]) == pytest.approx([1.0, 1.0, 3.0])
    assert springpot(1e10, 0.9).storage_modulus([1e300])[0] == pytest.approx(1e280 * math.cos(0.45 * math.pi))


def test_moduli_at_the_ends_of_the_range_of_times():
    """A branch with an infinite time is a spring, one with the time 0 is absent."""
    omega = np.geomspace(1e-3, 1e7, 41)
    columns = PronySeries.from_checked(np.ones(2), np.full((2, 1), 3.0), np.array([[np.inf], [0.0]]))
    assert columns.column.complex_modulus(omega).tolist() == [[4.0 + 0.0j] * omega.size, [1.0 + 0.0j] * omega.size]
    assert columns.storage_modulus(np.ones(2)).tolist() == [4.0, 1.0]
