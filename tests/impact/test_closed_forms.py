"""Closed forms against quoted values, numerical quadrature, and the exact solution; more of them in test_solve."""

import math

import numpy as np
import pytest

from refusals import named
from restitution import (
    Cone,
    FlatPunch,
    Impact,
    ImpactResult,
    Material,
    Parabola,
    PowerLaw,
    PronySeries,
    solve,
    standard_solid_restitution,
)
from restitution.impact import closed_forms as cf

# Bodies with a(d) = d^(exponent/2).
PROFILES = {
    0.0: FlatPunch(1.0), 0.5: PowerLaw(4.0, float(PowerLaw(4.0, 1.0).contact_radius(1.0)) ** 4), 1.0: Parabola(1.0),
    2.0: Cone(math.atan(0.5 * math.pi)),
}  # fmt: skip


def impact(modulus: float, moduli=(), times=(), *, viscosity=0.0, exponent=1.0) -> ImpactResult:
    """Impact with m = v0 = 1 and these constants of 2 E*(t), eight times those in shear."""
    series = PronySeries(modulus, moduli, times, parallel_viscosity=viscosity).scaled(0.125)
    return solve(Impact(Material(series, math.inf), PROFILES[exponent], 1.0, 1.0), rtol=1e-12)


def paper(nu: float, p2: float, p3: float) -> float:
    return standard_solid_restitution(nu, p2, p3, rtol=1e-12)


def test_constants_have_their_published_digits():
    assert pytest.approx(2.9432751843, abs=5e-11) == cf.HERTZ_TIME_FACTOR
    assert pytest.approx(1.1534488581, abs=5e-11) == cf.SMALL_LOSS_FACTOR


def test_hertz_in_si_units():
    # A steel ball on a glassy half-space, by hand from (15 m v0^2/(16 E* sqrt R))^(2/5).
    mass, radius, modulus, velocity = 4.07e-3, 5e-3, 5.2e10, 0.8
    depth = cf.elastic_max_indentation_depth(modulus, math.sqrt(radius), mass, velocity)
    assert (4 / 3) * modulus * math.sqrt(radius) * depth**2.5 * (2 / 5) == pytest.approx(mass * velocity**2 / 2)
    force = cf.elastic_max_force(depth, mass, velocity)
    assert force == pytest.approx((4 / 3) * modulus * math.sqrt(radius) * depth**1.5)


def test_flat_punch_formula_is_smooth_through_critical_damping():
    # Second differences over steps of 1e-4 are 1e-8 e'', and e'' is of order 0.1.
    e = cf.flat_punch_kelvin_voigt_restitution(1.0 + 1e-4 * np.arange(-3, 4))
    assert np.abs(np.diff(e, 2)).max() < 1e-8
    assert e[3] == pytest.approx(math.exp(-2.0), rel=1e-12)


def test_overdamped_flat_punch_on_maxwell_never_returns():
    assert [cf.flat_punch_maxwell_restitution(ratio) for ratio in (1.0, 1.5)] == [0.0, 0.0]


@pytest.mark.parametrize("exponent", PROFILES)
def test_first_order_of_kelvin_voigt(exponent):
    """The slope at zero loss, extrapolated from two small losses."""
    depth = cf.elastic_max_indentation_depth(0.5, 1.0, 1.0, 1.0, path_exponent=exponent)

    def loss_over_prediction(tau: float) -> float:
        law = cf.kelvin_voigt_first_order_restitution(tau, depth, 1.0, path_exponent=exponent)
        result = impact(1.0, viscosity=tau, exponent=exponent)
        return (1.0 - result.restitution_coefficient) / (1.0 - law)

    coarse, fine = loss_over_prediction(2e-3), loss_over_prediction(1e-3)
    assert 2.0 * fine - coarse == pytest.approx(1.0, abs=5e-6)


@pytest.mark.parametrize("exponent", PROFILES)
def test_first_order_of_slow_relaxation(exponent):
    depth = cf.elastic_max_indentation_depth(1.0, 1.0, 1.0, 1.0, path_exponent=exponent)
    time = cf.elastic_contact_time(depth, 1.0, path_exponent=exponent)

    def loss_over_prediction(slowness: float) -> float:
        moduli, times = np.array([0.3, 0.5]), slowness * np.array([1.0, 4.0])
        law = cf.hunter_restitution(0.2, moduli, times, time, path_exponent=exponent)
        result = impact(0.4, 2.0 * moduli, times, exponent=exponent)
        return (1.0 - result.restitution_coefficient) / (1.0 - law)

    coarse, fine = loss_over_prediction(500.0), loss_over_prediction(1000.0)
    assert 2.0 * fine - coarse == pytest.approx(1.0, abs=5e-6)


@pytest.mark.parametrize(
    ("nu", "slope"), [(0.0, 1.70760), (0.3, 2.22267), (0.45, 2.96746), (0.5, 3.37979), (-1.0, None)]
)
def test_small_p3_slope(nu, slope):
    result = cf.standard_solid_small_p3_slope(nu)
    # Slopes from the theory; at nu = -1 from the identity with the incompressible case.
    expected = slope or cf.equivalent_incompressible_p3(3.37979)
    assert result == pytest.approx(expected, abs=5.1e-6)
    coarse, fine = ((1.0 - paper(nu, 0.5, p3)) / p3 / result for p3 in (1e-3, 5e-4))
    assert 2.0 * fine - coarse == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize(("nu", "p2"), [(-1.0, 0.1), (-0.3, 1e-3), (0.0, 1.0), (0.3, 0.01), (0.45, 1.0), (0.5, 0.1)])
def test_large_p3_slope(nu, p2):
    result = cf.standard_solid_large_p3_slope(nu, p2)
    coarse, fine = ((1.0 - paper(nu, p2, p3)) * p3 / result for p3 in (1e3 / p2, 2e3 / p2))
    assert 2.0 * fine - coarse == pytest.approx(1.0, abs=2e-5)


@pytest.mark.parametrize(("x", "tolerance"), [(0.1, 1e-6), (0.5, 1e-6), (1.0, 7e-4), (3.0, 7e-4)])
def test_pade_of_mueller_and_poeschel(x, tolerance):
    """Against the equation of motion with rho = m = v0 = 1, until the force vanishes."""
    from scipy.integrate import solve_ivp

    a = x**2 / 1.5

    def motion(_, y):
        root = math.sqrt(max(y[0], 0.0))
        return [y[1], -root * (y[0] + 1.5 * a * y[1])]

    def leaves(t, y):
        return y[0] + 1.5 * a * y[1] if t > 0.0 else 1.0

    leaves.terminal, leaves.direction = True, -1
    result = solve_ivp(motion, (0.0, 1e3), [0.0, 1.0], rtol=1e-10, atol=1e-13, method="DOP853", events=leaves)
    assert cf.mueller_poeschel_restitution(x) == pytest.approx(-result.y[1, -1], abs=tolerance)


def test_exact_and_approximate_rebound_agree_to_first_order_only():
    """Kelvin-Voigt: the exact rebound and the force law of Mueller and Poeschel."""

    def difference(p3: float) -> float:
        b = 1.5 * (16.0 / 3.0) ** 0.4 * p3
        exact = impact(8.0, viscosity=8.0 * p3).restitution_coefficient
        return cf.mueller_poeschel_restitution(math.sqrt(b)) - exact

    # The difference is quadratic in p3 for small p3, and about 0.01 at p3 = 0.1.
    assert difference(1e-2) / difference(1e-3) == pytest.approx(100.0, rel=0.2)
    assert difference(0.1) < -8e-3


def test_arrays_broadcast():
    depth = cf.elastic_max_indentation_depth([[1.0], [2.0]], 1.0, [1.0, 2.0, 3.0], 1.0)
    assert np.shape(depth) == (2, 3)
    assert isinstance(cf.elastic_contact_time(1.0, 1.0), float)
    e = cf.flat_punch_kelvin_voigt_restitution(np.array([0.5, 1.0, 2.0]))
    assert e[0] == cf.flat_punch_kelvin_voigt_restitution(0.5)
    assert e[2] == cf.flat_punch_kelvin_voigt_restitution(2.0)


@pytest.mark.parametrize(
    ("call", "expected"),
    [
        (lambda: cf.elastic_max_indentation_depth(1.0, 1.0, 0.0, 1.0), ("mass", 0.0)),
        (lambda: cf.elastic_contact_time(1.0, -1.0), ("velocity", -1.0)),
        (lambda: cf.standard_solid_small_p3_slope(0.6), ("nu", 0.6)),
        (lambda: cf.flat_punch_maxwell_restitution(-0.1), ("damping_ratio", -0.1)),
    ],
)
def test_bad_input(call, expected):
    assert named(call) == expected
