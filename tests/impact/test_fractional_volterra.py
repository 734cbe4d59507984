"""Fractional materials against direct quadrature of the hereditary contact equations, without Prony series."""

import math

import pytest

from checkout import script
from restitution import Cone, Impact, Parabola, for_contact, solve
from restitution.material.fractional import (
    FractionalMaterial,
    fractional_kelvin_voigt,
    fractional_maxwell,
    fractional_zener,
    springpot,
)

volterra = script("validation/fractional_volterra.py")
# Contact radius a = d.
CONE = Cone(math.atan(0.5 * math.pi))


def test_the_quadrature_with_an_elastic_body():
    """E* = 1 gives e = 1 and the contact time of Hertz."""
    elastic = volterra.Kernel(lambda t: 1.0 + 0.0 * t, lambda t: 1.0 * t, 2.0)
    e, time = volterra.extrapolated(elastic, volterra.parabola, 0.005)
    assert e == pytest.approx(1.0, abs=2e-6)
    # 2.94328 d_m/v0, d_m = (15/16)^(2/5)
    assert time == pytest.approx(2.9432751843 * (15.0 / 16.0) ** 0.4, rel=2e-6)


@pytest.mark.parametrize(
    ("model", "kernel", "profile", "force_integral"),
    [
        (springpot(1.0, 0.3), volterra.springpot_kernel(1.0, 0.3), Parabola(1.0), volterra.parabola),
        (
            fractional_kelvin_voigt(1.0, 0.5, 0.7), volterra.springpot_kernel(0.5, 0.7, 1.0),
            Parabola(1.0), volterra.parabola,
        ),
        (fractional_zener(1.0, 5.0, 0.5, 0.5), volterra.zener_kernel(1.0, 5.0, 0.5), Parabola(1.0), volterra.parabola),
        (fractional_maxwell(5.0, 0.5, 0.5), volterra.zener_kernel(0.0, 5.0, 0.5), CONE, volterra.cone),
    ],
    ids=["springpot", "Kelvin-Voigt", "Zener", "Maxwell on a cone"],
)  # fmt: skip
def test_prony_series_of_fractional_models_have_the_stated_error(model, kernel, profile, force_integral):
    fractional, step = FractionalMaterial(model, math.inf), 2e-3
    e, time = volterra.extrapolated(kernel, force_integral, step)
    for rtol in (1e-2, 1e-4, 1e-6):
        material, error, _ = fractional.approximation((1e-4, 10.0), rtol)
        result = solve(Impact(material, profile, 1.0, 1.0))
        assert error <= rtol
        # The error of the quadrature with 700 time steps is 1e-6, and 2e-6 for the singular kernel of exponent 0.7.
        assert result.restitution_coefficient == pytest.approx(e, rel=error + 2e-6)
        assert result.contact_time == pytest.approx(time, rel=error + 2e-6)
    # Window and series as the package chooses them, for a relative error of 1e-6.
    chosen = for_contact(lambda window: Impact(fractional.within(window), profile, 1.0, 1.0))
    assert solve(chosen).restitution_coefficient == pytest.approx(e, rel=3e-6)
