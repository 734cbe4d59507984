"""Real measurements: bouncing balls with e alone, and rubber at several temperatures.

The numbers and their sources are in `validation/real_data.py`.
"""

import math
from functools import cache

import numpy as np
import pytest

import restitution as rs
from restitution.errors import RestitutionWarning

GOLF = [2.0, 2.5, 3.0, 3.5, 4.0, 4.5], [0.888, 0.894, 0.897, 0.897, 0.893, 0.887]
TABLE_TENNIS = [1.0, 1.5, 2.0, 2.5], [0.948, 0.946, 0.935, 0.926]
NOISE = rs.Noise(restitution_coefficient=0.015)
SOFT = {"poisson_ratio": 0.5}


def golf(radius=21e-3, mass=41.5e-3):
    return rs.Rebounds(*GOLF, radius=radius, mass=mass, noise=NOISE)


@cache
def golf_fit(model):
    return rs.identify(golf(), model, fixed=SOFT)


@pytest.mark.parametrize("model", ["elastic", "kelvin_voigt", "springpot", "standard_solid"])
def test_restitution_alone_determines_no_modulus_of_a_golf_ball(model):
    fit = golf_fit(model)
    assert [name for name, estimate in fit.parameters.items() if estimate.determined] in ([], ["exponent"])
    assert any("determines no modulus and no time" in line for line in fit.statements)
    assert not [line for line in fit.warnings if "hollow" in line]


def test_a_power_law_has_the_same_restitution_at_all_velocities():
    # So that its sum of squares is that about the mean, and its error that of the mean.
    e = np.array(GOLF[1])
    fit = golf_fit("springpot")
    assert fit.chi2 == pytest.approx(((e - e.mean()) ** 2).sum() / 0.015**2, rel=1e-6)
    stated = fit.functionals["restitution_coefficient at 3.5 m/s"]
    assert stated.value == pytest.approx(e.mean(), abs=1e-6)
    assert stated.standard_error == pytest.approx(0.015 / math.sqrt(e.size), rel=1e-3)


def test_radius_and_mass_do_not_matter_for_the_restitution_of_the_same_ball():
    rng, predicted = np.random.default_rng(3), []
    for _ in range(2):
        radius, mass = np.exp(rng.uniform(np.log([5e-3, 1e-3]), np.log([0.1, 1.0])))
        fit = rs.identify(golf(radius, mass), "kelvin_voigt", fixed=SOFT)
        impact = rs.Impact(fit.material, rs.Parabola(radius), mass, 10.0)
        predicted.append((fit.chi2, float(fit.predict(impact)["restitution_coefficient"].item())))
    assert predicted[0] == pytest.approx(predicted[1], rel=1e-6)


def test_a_hollow_ball_is_doubted():
    ball = rs.Rebounds(*TABLE_TENNIS, radius=20e-3, mass=2.7e-3, noise=NOISE)
    assert any("81 kg/m^3" in line for line in rs.effective_moduli(ball).statements)
    assert any("hollow" in line for line in rs.identify(ball, "kelvin_voigt", fixed=SOFT).warnings)
    assert not any("hollow" in line for line in rs.effective_moduli(golf()).statements)


def rubber():
    """EPDM in shear at 1 and 100 Hz."""
    measured = ((-10.0, 7.25, 0.110, 11.25, 0.535), (4.0, 5.37, 0.106, 7.06, 0.177), (18.0, 4.35, 0.121, 5.87, 0.134), (25.0, 4.26, 0.118, 5.74, 0.131),
                (39.0, 3.78, 0.122, 5.17, 0.143), (53.0, 3.34, 0.126, 4.72, 0.141))  # fmt: skip
    omega = 2.0 * math.pi * np.array([1.0, 100.0])
    return rs.Isotherms(
        [
            rs.DynamicTable(
                omega, np.array([slow, fast]), np.array([slow * a, fast * b]), "shear", temperature=t + 273.15
            )
            for t, slow, a, fast, b in measured
        ]
    )


def test_the_shifts_of_a_rubber_are_those_of_a_rubber():
    # Williams, Landel and Ferry (1955), with a glass transition at -50 degC: C1 = 7.1, C2 = 127 K at 25 degC.
    with pytest.warns(RestitutionWarning, match=r"at -10\.0 °C is 0\.36 decades"):
        curve = rubber().superposed(reference_temperature=298.15, shift="wlf")
    for name, value in (("c1", 17.44 * 51.6 / 126.6), ("c2", 126.6)):
        assert abs(curve.constants[name] - value) < 2.0 * curve.constant_errors[name] < 0.5 * value


def test_isotherms_of_one_measurement_share_the_size_of_their_noise():
    fit = rs.identify(rubber(), "springpot", fixed=SOFT, shift=rs.WLF)
    factors = np.array(fit.problem.factors)
    assert np.all(factors == factors[0])
    assert fit.reduced_chi2 == pytest.approx(1.0, abs=0.02)
    # Without a common size, the isotherm that fits best would have almost no noise.
    separate = np.array([np.mean(part**2) for part in fit.residuals])
    assert separate.min() < 0.5 < 1.2 < separate.max()


@pytest.mark.slow
def test_the_spectrum_of_a_polymer_is_that_of_another_program(shared_reference):
    # Relaxation in tension and Prony terms by NREL pyvisco, over 31 decades.
    folder = shared_reference / "materials"
    measured = rs.read_material(folder / "polymer_relaxation_master_curve.csv")
    assert isinstance(measured, rs.RelaxationTable)
    few = rs.RelaxationTable(measured.time[::10], measured.modulus[::10], "tension")
    fit = rs.identify(few, "spectrum", fixed=SOFT)
    shares, times = np.loadtxt(folder / "polymer_relaxation_prony.csv", delimiter=",").T
    between = measured.time[5:-5:10]
    theirs = 1739.03e6 * (1.0 - shares.sum() + np.exp(-between[:, None] / times) @ shares)
    ours = 3.0 * fit.material.shear.relaxation_modulus(between)
    # The terms of pyvisco have one time a decade, and deviate by up to 2.2 % from the data themselves.
    assert (
        np.abs(np.log(ours / measured.modulus[5:-5:10])).max() < 0.02
    )  # a smooth curve through a tenth of the points
    assert np.abs(np.log(ours / theirs)).max() < 0.02 + 0.022
