"""Bands of e: materials that are known beyond the data, whose fit to part of them is asked for its band."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from cases import case_file, isotherms_file
from commands import done
from refusals import named
from restitution import (
    DynamicTable,
    Impact,
    Material,
    Parabola,
    PronySeries,
    fit_prony,
    read_case,
    restitution_band,
    solve,
)
from restitution.material.extrapolation import Beyond, continued

TIMES = np.logspace(-9, 3, 37)
# Two terms a decade, a fit of 0.5 %, and glasses that end elsewhere.
CLOSE = 0.03


def impact(material: Material) -> Impact:
    return Impact(material, Parabola(0.01), mass=0.0327, velocity=0.1)


def power_law(rng: np.random.Generator) -> PronySeries:
    return PronySeries(1e6, 1e6 * (TIMES / 1e-3) ** -rng.uniform(0.1, 0.5), TIMES)


def transition(rng: np.random.Generator) -> PronySeries:
    """A glass transition whose peak is at 1 µs to 1 ms, with a glass of about 0.6 GPa."""
    decades = np.log10(TIMES) - rng.uniform(-7.0, -4.0)
    return PronySeries(1e6, (1e8 * np.exp(-0.5 * decades**2) + 2e5) * math.log(10.0) / 3.0, TIMES)


@pytest.mark.parametrize("kind", [power_law, transition])
def test_the_band_holds_a_material_of_which_only_slow_data_are_known(kind) -> None:
    rng = np.random.default_rng(41)
    for _ in range(6):
        series = kind(rng)
        exact = solve(impact(Material(series, math.inf)), rtol=1e-6)
        e, duration = float(exact.restitution_coefficient), float(exact.contact_time)
        low = duration * 10.0 ** rng.uniform(0.0, 1.5)
        omega = np.geomspace(1e-3 / low, 1.0 / low, 31)
        fit = fit_prony(DynamicTable(omega, series.storage_modulus(omega), series.loss_modulus(omega), "shear"))
        band = restitution_band(impact(fit.material(poisson_ratio=0.5)))
        assert band.low - CLOSE < e < band.high + CLOSE
        # What the fit gives without a band.
        assert band.by_assumption["if the relaxation ends with the data,"] > e + CLOSE


def test_a_power_law_goes_on_as_it_was() -> None:
    rng = np.random.default_rng(7)
    for _ in range(4):
        series = power_law(rng)
        exact = solve(impact(Material(series, math.inf)), rtol=1e-6)
        low = 10.0 * float(exact.contact_time)
        omega = np.geomspace(1e-3 / low, 1.0 / low, 31)
        fit = fit_prony(DynamicTable(omega, series.storage_modulus(omega), series.loss_modulus(omega), "shear"))
        band = restitution_band(impact(fit.material(poisson_ratio=0.5)))
        goes_on = band.by_assumption["if it goes on as in their last decade,"]
        assert goes_on == pytest.approx(float(exact.restitution_coefficient), abs=0.05)


def test_a_constant_loss_modulus_stays_so_at_both_ends() -> None:
    """Terms of equal strength over many decades have the loss modulus (pi/2) H, H = G_k/(step of ln tau)."""
    times = np.logspace(-6, 6, 25)
    height = 2e5 / (0.5 * math.log(10.0))
    # The ends of the data are half a step from the next terms.
    material = Material(PronySeries(1e7, np.full(25, 2e5), times), math.inf, window=(10.0**-2.25, 10.0**2.25))
    longer = continued(material, Beyond(3, 3), 0.0)
    omega = np.geomspace(1e-3, 1e3, 33)
    expected = np.full(33, math.pi / 2.0 * height)
    # The sum over terms of half a decade ripples by a hundredth, and ends two decades beyond these frequencies.
    np.testing.assert_allclose(longer.shear.loss_modulus(omega), expected, rtol=0.03)
    middle = np.geomspace(0.1, 10.0, 9)
    np.testing.assert_allclose(longer.shear.storage_modulus(middle), material.shear.storage_modulus(middle), rtol=0.02)
    assert longer.window is None


def test_no_modulus_becomes_that_of_more_than_a_glass_or_negative() -> None:
    series = PronySeries(1e3, [1e6, 1e7, 1e8], [1.0, 1e-1, 1e-2])
    material = Material(series, 2e9, window=(1e-2, 1.0))
    for growth in (None, 0.0, 1.0):
        stiff = continued(material, Beyond(9, 9), growth)
        assert stiff.shear.instantaneous_modulus < 1.5e9
        assert stiff.shear.equilibrium_modulus > 0.0
        assert stiff.bulk == material.bulk
        twice = continued(material, Beyond(9, 0), growth, stiffening=2.0)
        assert twice.shear.instantaneous_modulus < 2.0 * series.instantaneous_modulus
        assert twice.shear.equilibrium_modulus == series.equilibrium_modulus
    assert continued(material, Beyond(0, 0), 1.0).shear == series


def test_data_that_cover_the_contact_have_no_band() -> None:
    series = PronySeries(1e6, [1e6, 1e6], [1e-3, 1e-4])
    assert restitution_band(impact(Material(series, math.inf))) is None
    assert restitution_band(impact(Material(series, math.inf, window=(1e-7, 1e2)))) is None
    assert named(lambda: restitution_band(Impact(Material(series, 2e9), Parabola(0.01), 0.01, [1.0, 2.0]))) == (
        "impact",
    )


def test_both_bodies_go_on() -> None:
    series = PronySeries(1e6, [1e6, 1e6, 1e6], [1.0, 1e-1, 1e-2])
    material = Material(series, math.inf, window=(1e-2, 1.0))
    pair = Impact(material, Parabola(0.01), mass=0.01, velocity=0.1, counter_material=material)
    # Equal half-spaces halve the modulus, at equal times: half of both the mass and the force.
    single = Impact(material, Parabola(0.01), mass=0.02, velocity=0.1)
    first, second = restitution_band(pair), restitution_band(single)
    assert (first.low, first.high) == pytest.approx((second.low, second.high), rel=1e-4)


@pytest.mark.usefixtures("folder")
@pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning")
def test_solve_prints_the_band_of_a_contact_beyond_the_data() -> None:
    isotherms_file("iso.csv")
    material = 'file = "iso.csv"\ntemperature = "23 degC"\npoisson_ratio = 0.49'
    case_file("ball.toml", material=material)
    content = json.loads(done("solve", "ball.toml", "--json", "--extrapolate").stdout)
    (band,) = content["restitution_bands"]
    assert band["low"] < content["restitution_coefficient"] <= band["high"]
    assert "over the relaxation beyond the data" in done("solve", "ball.toml", "--extrapolate").stdout
    case_file("elastic.toml")
    assert "restitution_bands" not in json.loads(done("solve", "elastic.toml", "--json").stdout)


@pytest.mark.usefixtures("folder")
@pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning")
@pytest.mark.parametrize("second", [None, 'mass = "5 g"\nradius = "10 mm"'])
def test_an_assumed_shift_has_the_band_of_measured_constants(second: str | None) -> None:
    kelvin = np.arange(215.15, 315.0, 1.0)
    series = PronySeries(1e6, 4e7 / (1.0 + (TIMES / 0.1) ** 0.6), TIMES)
    omega = 2 * math.pi * 10.0 ** (-15.0 * (kelvin - 233.15) / (60.0 + kelvin - 233.15))
    columns = kelvin.tolist(), series.storage_modulus(omega).tolist(), series.loss_modulus(omega).tolist()
    lines = [f"{t!r},1,{a!r},{b!r}" for t, a, b in zip(*columns, strict=True)]
    Path("ramp.csv").write_text("\n".join(["T,f,G',G''", "K,Hz,Pa,Pa", *lines]))
    file = 'file = "ramp.csv"\npoisson_ratio = 0.5\ntemperature = "0 degC"\n'
    case_file("ball.toml", material=file, counter_body=second)
    case = read_case("ball.toml")
    result = case.solve()
    (band,) = case.bands(result)
    # The constants of polyisobutylene, about the same glass transition, as a law that is given.
    glass = case.sections.material.file.glass_transition
    law = f"shift = {{ reference_temperature = {glass}, c1 = 16.53, c2 = 104.4 }}"
    case_file("given.toml", material=file + law, counter_body=second)
    case = read_case("given.toml")
    expected = case.solve().restitution_coefficient
    assert band.by_assumption["of polyisobutylene"] == pytest.approx(expected, abs=0.01)
    assert band.by_assumption["with universal constants"] == pytest.approx(result.restitution_coefficient, rel=1e-5)
    assert case.bands(case.solve()) == []
