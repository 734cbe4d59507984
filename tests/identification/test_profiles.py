"""Profiles against a brute scan, and tables of moduli as observations."""

import math

import numpy as np
import pytest
from tests.identification.balls import STANDARD_SOLIDS, rebounds, standard_solid

import restitution as rs
from refusals import in_one_line, named
from restitution import DynamicTable, RelaxationTable
from restitution.identification.fit import minimise
from restitution.identification.observations import Moduli

FIXED = {"poisson_ratio": 0.5}


def _scan(result, k, end):
    """Root of the least excess at 10 even places from the best fit to an end, each fit from the one before."""
    start, roots = result.coordinates, []
    for z in np.linspace(result.coordinates[k], end, 11)[1:]:
        start = start.copy()
        start[k] = z
        fit = minimise(result.problem, start, held=k, tolerance=1e-7)
        start = fit.coordinates
        roots.append(math.sqrt(max(fit.cost - result.estimation.fit.cost, 0.0)))
    return np.array(roots)


@pytest.mark.slow
def test_ends_of_profiles_agree_with_a_brute_scan():
    """The ends are where the least sum of squares over the other parameters exceeds the minimum by 1.96^2.

    Where the root of the excess is below 1.8 times 1.96 at five errors, in place of 5, the end is at 1.8 times 1.96.
    """
    one_ball = np.full(12, 0.01), np.geomspace(0.3, 3.0, 12)
    fit = rs.identify(rebounds(standard_solid(*STANDARD_SOLIDS["weak"]), *one_ball, sd=0.01, seed=3),
                        rs.standard_solid, fixed=FIXED)  # fmt: skip
    level, flat = fit.uncertainty.quantile(), 0
    assert level == pytest.approx(1.959964, rel=1e-6)
    for k, name in enumerate(fit.parameters):
        profile, best = fit.profile(name), fit.coordinates[k]
        for side, end in (("low", profile.low), ("high", profile.high)):
            if math.isinf(end):
                continue
            roots = _scan(fit, k, end)
            first = best + (end - best) * np.interp(level, [0.0, *roots], np.linspace(0.0, 1.0, 11))
            flattens = _scan(fit, k, best + 5.0 / level * (first - best))[-1] < 1.8 * level
            assert roots[-1] == pytest.approx((1.8 if flattens else 1.0) * level, abs=0.03), (name, side)
            assert np.all(roots[:-1] < roots[-1]), (name, side)
            flat += flattens
    assert flat == 3


def test_profile_of_a_well_determined_parameter_is_a_parabola():
    fit = rs.identify(rebounds(standard_solid(*STANDARD_SOLIDS["strong"]), seed=1), rs.standard_solid, fixed=FIXED)
    errors = np.sqrt(np.diag(fit.covariance))
    for k, (name, (low, high)) in enumerate(fit.interval(0.68).items()):
        reach = fit.uncertainty.quantile(0.68) * errors[k]
        np.testing.assert_allclose(
            np.log([low, high]), fit.coordinates[k] + np.array([-reach, reach]), atol=0.05 * reach
        )
        assert fit.profile(name, 0.68).excess.min() == 0.0


def test_data_that_hold_no_information_leave_ends_open():
    """Slow relaxation, C of the design page: one ball over one decade shows abs(E*) alone."""
    balls = rebounds(standard_solid(1e6, 1e7, 3e-2), np.full(10, 0.01), np.geomspace(0.3, 3.0, 10), sd=0.01, seed=1)
    fit = rs.identify(balls, rs.standard_solid, fixed=FIXED)
    assert fit.parameters["equilibrium_modulus"].value is None
    modulus = next(result for name, result in fit.functionals.items() if name.startswith("absolute_modulus"))
    assert modulus.determined
    truth = rs.reduced_modulus(standard_solid(1e6, 1e7, 3e-2))
    omega = math.sqrt(math.prod(fit.window))
    exact = math.hypot(truth.storage_modulus(omega), truth.loss_modulus(omega))
    assert abs(modulus.value - exact) < 3.5 * modulus.standard_error


def test_tables_are_observations_with_relative_noise():
    omega = np.array([1.0, 10.0, 100.0])
    table = DynamicTable(omega, np.full(3, 3e6), np.full(3, 4e6), "shear", "dma.csv")
    data = Moduli(table, noise=rs.Noise(storage_modulus="1 %", loss_modulus="2 %"))
    assert data.size == 6
    assert data.window() == (1.0, 100.0)
    assert data.label == "dma.csv"
    elastic = rs.identify([data], rs.elastic, fixed=FIXED, profiles=False)
    # The loss part is relative to the magnitude, 5 MPa.
    np.testing.assert_allclose(elastic.residuals[0][3:], -4e6 / (0.02 * 5e6))
    assert Moduli(table).scaled
    curves = elastic.curves[0][1]
    assert [curve.name for curve in curves] == ["storage_modulus", "loss_modulus"]


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"deformation": "bulk"}, "deformation"),
        ({"noise": rs.Noise(modulus="x")}, "noise.modulus"),
        ({"noise": rs.Noise(storage_modulus="1 %")}, "noise.storage_modulus"),
    ],
)
def test_wrong_options_of_tables_are_refused(options, field):
    table = RelaxationTable(np.array([0.1, 1.0]), np.array([2.0, 1.0]), "shear")
    assert in_one_line(lambda: Moduli(table, **options)).field == field


def test_tables_without_a_deformation_are_refused():
    table = RelaxationTable([0.1, 1.0], [2.0, 1.0])
    assert named(lambda: rs.identify(table, rs.standard_solid, fixed=FIXED)) == ("deformation",)
