import math

import numpy as np
import pytest
from scipy.special import erfcx, gamma, rgamma

from refusals import named
from restitution import Material, PronySeries, reduced_modulus
from restitution.material.fractional import (
    FractionalMaterial,
    FractionalModel,
    fractional_kelvin_voigt,
    fractional_maxwell,
    fractional_series,
    fractional_zener,
    springpot,
)

pytestmark = pytest.mark.plain


def test_mittag_leffler_of_one_half():
    """E_1/2(-x) = exp(x^2) erfc(x)."""
    t = np.array([0.0, *np.geomspace(1e-8, 1e8, 17)])
    value = fractional_maxwell(1.0, 1.0, 0.5).relaxation_modulus(t)
    assert value == pytest.approx(erfcx(np.sqrt(t)), rel=1e-13, abs=0)


@pytest.mark.parametrize("alpha", [0.05, 0.2, 0.4, 0.6, 0.8, 0.95, 0.99])
def test_mittag_leffler_by_its_series_and_its_asymptotics(alpha):
    """Sum (-x)^k/Gamma(alpha k + 1), and -sum (-x)^-k/Gamma(1 - alpha k); Mainardi (2010), appendix E."""
    model = fractional_maxwell(1.0, 1.0, alpha)
    x = np.array([0.01, 0.1, 0.5])
    k = np.arange(60)[:, None]
    series = ((-x) ** k / gamma(alpha * k + 1.0)).sum(axis=0)
    assert model.relaxation_modulus(x ** (1.0 / alpha)) == pytest.approx(series, rel=1e-12, abs=0)
    x = np.array([1e4, 1e5])
    k = np.arange(1, 5)[:, None]
    late = -((-x) ** -k * rgamma(1.0 - alpha * k)).sum(axis=0)
    assert model.relaxation_modulus(x ** (1.0 / alpha)) == pytest.approx(late, rel=1e-9, abs=0)


def test_springpot_in_closed_form():
    """G(t) = V t^-alpha/Gamma(1 - alpha), G' = V omega^alpha cos(pi alpha/2), tan delta = tan(pi alpha/2)."""
    model = springpot(3.0, 0.4)
    assert model.relaxation_modulus(2.0) == pytest.approx(3.0 * 2.0**-0.4 / gamma(0.6), rel=1e-15)
    assert model.relaxation_modulus(0.0) == math.inf
    assert model.storage_modulus(5.0) == pytest.approx(3.0 * 5.0**0.4 * math.cos(0.2 * math.pi), rel=1e-14)
    ratio = model.loss_modulus(5.0) / model.storage_modulus(5.0)
    assert ratio == pytest.approx(math.tan(0.2 * math.pi), rel=1e-14)


def test_an_overflowing_springpot_is_infinite_and_never_nan():
    """V omega^alpha = 1e90 * 1e308^0.99 = 1e395 exceeds the largest double."""
    model = springpot(1e90, 0.99)
    assert (model.storage_modulus(1e308), model.loss_modulus(1e308)) == (math.inf, math.inf)
    assert model.carson_transform(np.array([1e300, 1e308])).tolist() == [math.inf, math.inf]
    # A spring in series bounds the modulus.
    assert fractional_maxwell(1e90, 1e-3, 0.99).storage_modulus(1e308) == 1e90


def test_zener_limits():
    model = fractional_zener(2.0, 6.0, 0.5, 0.3)
    assert model.relaxation_modulus(0.0) == pytest.approx(8.0, rel=1e-13)
    assert model.instantaneous_modulus == 8.0
    assert model.relaxation_time == pytest.approx(0.5, rel=1e-14)
    assert model.storage_modulus([0.0]) == pytest.approx([2.0])
    # At omega tau = 1 the complex modulus is 2 + 6 z/(1 + z) with z = i^0.3, of real part 2 + 3.
    assert model.storage_modulus(2.0) == pytest.approx(5.0, rel=1e-14)


@pytest.mark.parametrize("alpha", [0.01, 0.1, 0.5, 0.7, 0.9, 0.99])
@pytest.mark.parametrize("rtol", [1e-2, 1e-4, 1e-7])
def test_prony_error_is_verified_on_other_points(alpha, rtol):
    window = (1e-5, 1e-1)
    rng = np.random.default_rng(1)
    t = 10.0 ** rng.uniform(-5, -1, 40)
    models = (springpot(5.0, alpha), fractional_kelvin_voigt(1.0, 5.0, alpha), fractional_zener(0.1, 1.0, 1e-3, alpha))
    for model in models[: 2 if alpha == 0.01 else 3]:
        series, error, span, loss_error = model.prony(window, rtol)
        assert error <= rtol
        assert span == window
        assert series.equilibrium_modulus == model.equilibrium_modulus
        assert series.parallel_viscosity == 0.0
        assert np.all(series.branch_moduli > 0)
        result = np.abs(series.relaxation_modulus(t) / model.relaxation_modulus(t) - 1).max()
        dynamic = series.carson_transform(1j / t) / model.carson_transform(1j / t) - 1
        loss = series.loss_modulus(1.0 / t) / model.loss_modulus(1.0 / t) - 1.0
        assert np.abs(loss).max() <= 1.2 * loss_error + 1e-12
        # The grid of the check may miss a peak by a few per cent.
        assert max(result, np.abs(dynamic).max()) <= 1.1 * error + 1e-13


@pytest.mark.parametrize("alpha", [0.2, 0.8, 0.97])
def test_number_of_terms_grows_with_digits_and_decades(alpha):
    """The trapezoidal rule needs ln(10) digits/pi^2 terms per factor e of time."""
    model = fractional_zener(0.0, 1.0, 1.0, alpha)
    for digits in (3, 6, 9):
        for decades in (3, 6):
            series = model.prony((10.0 ** (-decades / 2), 10.0 ** (decades / 2)), 10.0**-digits).series
            assert series.n_branches <= 8 + 1.2 * digits * (decades + 2.5) * 2.3026**2 / math.pi**2 + 4 * digits


def test_the_loss_of_a_nearly_elastic_springpot_is_less_accurate():
    """E''/|E*| = sin(pi alpha/2) = 0.031, and the relative error of the loss is larger by this factor."""
    result = springpot(1.0, 0.02).prony((1e-5, 1e-1), 1e-3)
    assert result.error <= 1e-3 < result.loss_error < 40.0 * result.error


@pytest.mark.parametrize("time", [1e-27, 1e15, 1e27])
def test_a_relaxation_time_far_from_the_window(time):
    """G = G_inf + G_1 - V t^alpha/Gamma(1 + alpha) + ... long before its relaxation time, G_inf plus a tail after."""
    model = fractional_zener(1e6, 1e8, time, 0.5)
    result = model.prony((1e-9, 1e-3))
    assert result.error <= 1e-6
    omega = np.geomspace(1e3, 1e9, 9)
    y = (1j * omega * time) ** 0.5
    loss = (1e8 * (y / (1.0 + y) if time < 1.0 else -1.0 / y)).imag
    assert result.series.loss_modulus(omega) == pytest.approx(loss, rel=max(1e-3, 3.0 / abs(y).min() * (time > 1)))


def test_number_of_terms_of_a_springpot():
    assert springpot(1.0, 0.5).prony((1e-3, 1.0), 1e-6).series.n_branches <= 25


def test_a_liquid_stays_a_liquid():
    assert springpot(1.0, 0.5).prony((1e-3, 1.0), 1e-3).series.is_liquid


def test_fractional_material():
    shear = fractional_zener(1e6, 1e8, 1e-3, 0.5)
    material, error, _ = FractionalMaterial(shear, 2e9, density=1000.0, name="x").approximation((1e-5, 1e-2), 1e-6)
    assert isinstance(material, Material)
    assert (material.density, material.name, material.window) == (1000.0, "x", (1e-5, 1e-2))
    assert 0 < error <= 1e-6
    s = np.geomspace(1e2, 1e5, 20)
    g, k = shear.carson_transform(s), 2e9
    expected = 4 * g * (3 * k + g) / (3 * k + 4 * g)
    assert reduced_modulus(material).carson_transform(s) == pytest.approx(expected, rel=1e-6, abs=0)


def test_fractional_bulk_with_the_same_model_is_a_constant_poisson_ratio():
    model = springpot(3.0, 0.5)
    twice = FractionalModel(0.0, 5.0, 0.5)
    material, _, _ = FractionalMaterial(model, twice).approximation((1e-3, 1.0), 1e-6)
    assert isinstance(material.bulk, PronySeries)
    # nu = 1/4: E* = 2G/(1 - nu).
    assert reduced_modulus(material).carson_transform(30.0) == pytest.approx(
        8.0 / 3.0 * model.carson_transform(30.0), rel=2e-6
    )


@pytest.mark.parametrize(
    ("call", "expected"),
    [
        (lambda: springpot(0.0, 0.5), ("coefficient", 0.0)),
        (lambda: springpot(1.0, 1.0), ("exponent", 1.0)),
        (lambda: fractional_kelvin_voigt(-1.0, 1.0, 0.5), ("equilibrium_modulus", -1.0)),
        (lambda: fractional_zener(1.0, 0.0, 1.0, 0.5), ("branch_modulus", 0.0)),
        (lambda: fractional_zener(1.0, 1.0, 0.0, 0.5), ("relaxation_time", 0.0)),
        (lambda: springpot(1.0, 0.5).prony((1.0, 1.0)), ("window", "(1, 1)")),
        (lambda: springpot(1.0, 0.5).prony((0.1, 1.0), 1e-12), ("rtol", 1e-12)),
        (lambda: springpot(1.0, 0.5).relaxation_modulus(-1.0), ("time", -1.0)),
    ],
)
def test_bad_input_is_refused(call, expected):
    assert named(call) == expected


@pytest.mark.parametrize("exponent", [0.05, 0.3, 0.6, 0.9])
def test_fractional_models_are_valid_within_their_window(exponent):
    window = 1e-4, 1e-2
    time = np.geomspace(*window, 30)
    for model in (springpot(1e6, exponent), fractional_zener(1e6, 1e8, 1e-3, exponent)):
        columns = fractional_series([model], window)
        np.testing.assert_allclose(
            columns.column.relaxation_modulus(time)[0], model.relaxation_modulus(time), rtol=1e-6
        )
        exact = model.carson_transform(1j / time)
        np.testing.assert_allclose(columns.column.complex_modulus(1.0 / time)[0].imag, exact.imag, rtol=2e-6)


def test_fractional_rows_are_smooth_functions_of_the_exponent():
    """All rows have the same times except at the ends, so differences are derivatives."""
    time, step = np.geomspace(1e-4, 1e-2, 9), 1e-5
    rows = [springpot(1e6, 0.3 + k * step) for k in (-1, 0, 1)]
    result = np.log(fractional_series(rows, (1e-4, 1e-2)).column.relaxation_modulus(time))
    exact = np.log([row.relaxation_modulus(time) for row in rows])
    np.testing.assert_allclose(result[2] - result[0], exact[2] - exact[0], rtol=1e-5)
