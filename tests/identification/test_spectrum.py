"""Smooth spectra from impacts: loss tangents and bands inside the window, statements, refused data."""

import json
import math

import numpy as np
import pytest

import restitution as rs
from restitution.errors import InputError
from restitution.identification.spectrum import spectrum

RADII, VELOCITIES = np.repeat([0.002, 0.008, 0.03], 8), np.tile(np.geomspace(0.1, 1.0, 8), 3)
MASSES = 7800.0 * 4.0 / 3.0 * math.pi * RADII**3
TIMES = np.geomspace(1e-7, 1e2, 19)
TRUTHS = {
    "many terms": rs.PronySeries(5e7, 2e7 * (TIMES / 1e-3) ** -0.05, TIMES),
    "power law": rs.springpot(3e8, 0.15).prony((1e-9, 1e3), rtol=1e-6).series,
    "fractional Zener": rs.fractional_zener(1e8, 3e8, 1e-3, 0.6).prony((1e-9, 1e3), rtol=1e-6).series,
}


def rebounds(series, seed=None, radii=RADII, velocities=VELOCITIES, masses=MASSES, **options):
    """Rebounds of steel balls with 1 % of noise; exact ones without a seed."""
    exact = rs.Rebounds(velocities, np.ones(velocities.size), radius=radii, mass=masses)
    fit = exact.predicted(rs.Material(series.scaled(0.25), math.inf).reshaped((1, 1)))
    e, times = fit["restitution_coefficient"][0], fit["contact_time"][0]
    if seed is not None:
        rng = np.random.default_rng(seed)
        e, times = (values * np.exp(0.01 * rng.standard_normal(values.size)) for values in (e, times))
    noise = rs.Noise(restitution_coefficient="1 %", contact_time="1 %")
    data = {"contact_time": times, "noise": noise} | options
    return rs.Rebounds(velocities, np.minimum(e, 1.0), radius=radii, mass=masses, **data)


def loss_tangent(series, omega):
    return series.loss_modulus(omega) / series.storage_modulus(omega)


@pytest.mark.parametrize("truth", TRUTHS)
def test_loss_tangents_of_smooth_spectra_are_right_inside_the_window(truth):
    series = TRUTHS[truth]
    fit = spectrum(rebounds(series, seed=1))
    omega = np.geomspace(*fit.window, 20)
    error = np.abs(fit.moduli(omega).loss_tangent.to_numpy() / loss_tangent(series, omega) - 1.0)
    # The design page has medians of 0.4 to 3.2 % and largest errors of 2.6 to 6.5 % for spectra of this kind.
    assert np.median(error) < 0.06
    assert error.max() < 0.15
    # chi2 of 48 data.
    assert fit.chi2 < 48.0 + 4.0 * math.sqrt(96.0)


def test_bands_contain_the_true_moduli_from_half_to_twice_the_window():
    series, inside, count = TRUTHS["power law"], 0, 0
    for seed in range(6):
        fit = spectrum(rebounds(series, seed=seed))
        omega = np.geomspace(0.51 * fit.window[0], 1.99 * fit.window[1], 4)
        moduli = fit.moduli(omega)
        true = loss_tangent(series, omega)
        inside += np.count_nonzero((moduli.loss_tangent_low < true) & (true < moduli.loss_tangent_high))
        count += omega.size
    # 24 places that are correlated within a fit; 95 % bands.
    assert inside >= 0.7 * count


def test_nothing_is_stated_outside_half_to_twice_the_window():
    fit = spectrum(rebounds(TRUTHS["power law"]))
    low, high = fit.window
    moduli = fit.moduli([0.4 * low, 0.6 * low, 1.9 * high, 2.1 * high])
    assert np.isnan(moduli.storage_modulus).to_numpy().tolist() == [True, False, False, True]
    assert moduli.storage_modulus.attrs["units"] == "Pa"
    assert "half to twice" in fit.statements[0]


def test_the_material_has_the_restitution_of_the_data():
    fit = spectrum(rebounds(TRUTHS["fractional Zener"]), poisson_ratio=0.4)
    material = fit.material
    assert material.poisson_ratio == pytest.approx(0.4)
    omega = np.geomspace(*fit.window, 5)
    reduced = rs.reduced_modulus(material)
    np.testing.assert_allclose(reduced.storage_modulus(omega), fit.reduced_modulus.storage_modulus(omega), rtol=1e-9)
    impact = rs.Impact(material, rs.Parabola(0.008), mass=MASSES[8], velocity=0.5)
    exact = rebounds(TRUTHS["fractional Zener"], radii=np.array([0.008]), velocities=np.array([0.5]), masses=MASSES[8])
    assert rs.solve(impact).restitution_coefficient == pytest.approx(exact.restitution_coefficient[0], abs=0.01)


def test_lines_are_pointed_out():
    fit = spectrum(rebounds(rs.PronySeries(1e8, [1e9], [3e-4]), seed=1))
    assert fit.reduced_chi2 > 1.5 or fit.weight < 0.1
    assert json.loads(json.dumps(fit.to_dict()))["model"] == "spectrum"
    assert str(fit).count("\n") >= 5


def test_fewer_than_eight_impacts_are_refused():
    some = slice(0, 7)
    with pytest.raises(InputError, match="at least 8 impacts"):
        spectrum(rebounds(TRUTHS["power law"], radii=RADII[some], velocities=VELOCITIES[some], masses=MASSES[some]))


def test_restitution_alone_is_refused():
    noise = rs.Noise(restitution_coefficient="1 %")
    with pytest.raises(InputError, match="contact time"):
        spectrum(rebounds(TRUTHS["power law"], contact_time=None, noise=noise))


def test_identify_makes_it():
    fit = rs.identify(rebounds(TRUTHS["power law"]), "spectrum", fixed={"poisson_ratio": 0.3})
    assert fit.poisson_ratio == 0.3
    assert fit.chi2 < 1.0


def test_a_spectrum_draws_its_data():
    fit = spectrum(rebounds(TRUTHS["power law"], 1))
    assert [ax.get_ylabel() for ax in fit.plot().axes[:3]] == [
        "restitution coefficient $e$",
        "contact time $T$ [ms]",
        "residual over its standard deviation",
    ]
    ((_, curves),) = fit.curves
    values = np.concatenate([np.log(curve.fitted / curve.measured) / 0.01 for curve in curves])
    assert values == pytest.approx(fit.residuals[0], abs=1e-5)
