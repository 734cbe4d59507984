"""Columns of materials: the conversions of many rows agree with those of single materials."""

import math

import numpy as np
import pytest

from restitution.errors import InputError
from restitution.material.columns import MaterialColumns, PronyColumns
from restitution.material.conversion import bulk_factor, tension_from_shear
from restitution.material.fractional import FractionalMaterial, fractional_zener, springpot
from restitution.material.prony import PronySeries
from restitution.material.shift import WLF
from restitution.material.viscoelastic import Material, reduced_modulus

OMEGA = np.geomspace(1e-3, 1e7, 41)


def _random_columns(n_branch: int, seed: int) -> tuple[PronyColumns, np.ndarray]:
    """Moduli over 5 decades, times over 8, and Poisson ratios from -1 to 0.5, the ends included."""
    rng, n = np.random.default_rng(seed), 60
    equilibria = 10.0 ** rng.uniform(3.0, 8.0, n)
    moduli, times = 10.0 ** rng.uniform(3.0, 8.0, (n, n_branch)), 10.0 ** rng.uniform(-6.0, 2.0, (n, n_branch))
    ratio = np.concatenate([[-1.0, 0.5, 0.4999999, 0.0], rng.uniform(-1.0, 0.5, n - 4)])
    return PronyColumns(equilibria, np.zeros(n), moduli, times), equilibria * bulk_factor(ratio)


@pytest.mark.parametrize("n_branch", [1, 2, 5, 20])
def test_reduced_modulus_and_tension_of_all_rows_agree_with_those_of_each(n_branch):
    shear, bulk = _random_columns(n_branch, n_branch)
    found = MaterialColumns.from_shear(shear, bulk)
    reduced, tension = (one.complex_modulus(OMEGA) for one in (found.reduced, found.modulus("tension")))
    for n, modulus in enumerate(bulk):
        one = reduced_modulus(Material(shear.row(n), float(modulus)))
        np.testing.assert_allclose(reduced[n].real, one.storage_modulus(OMEGA), rtol=1e-12)
        np.testing.assert_allclose(reduced[n].imag, one.loss_modulus(OMEGA), rtol=1e-9)
        if modulus > 0.0:
            one = tension_from_shear(shear.row(n), bulk_modulus=float(modulus))
            np.testing.assert_allclose(tension[n].real, one.storage_modulus(OMEGA), rtol=1e-12)


def test_equal_times_and_absent_branches_are_allowed():
    shear = PronyColumns(
        np.ones(2), np.zeros(2), np.array([[2.0, 3.0], [2.0, 0.0]]), np.array([[1.0, 1.0], [1.0, 5.0]])
    )
    found = MaterialColumns.from_shear(shear, np.array([4.0, 4.0])).reduced.complex_modulus(OMEGA)
    for n, series in enumerate((PronySeries(1.0, [5.0], [1.0]), PronySeries(1.0, [2.0], [1.0]))):
        np.testing.assert_allclose(
            found[n].real, reduced_modulus(Material(series, 4.0)).storage_modulus(OMEGA), rtol=1e-9
        )


def test_dashpot_in_parallel_gives_one_branch():
    shear = PronyColumns(np.ones(2), np.full(2, 3.0), np.empty((2, 0)), np.empty((2, 0)))
    found = MaterialColumns.from_shear(shear, np.array([4.0, np.inf])).reduced.complex_modulus(OMEGA)
    for n, bulk in enumerate((4.0, math.inf)):
        one = reduced_modulus(Material(PronySeries(1.0, parallel_viscosity=3.0), bulk))
        np.testing.assert_allclose(found[n].real, one.storage_modulus(OMEGA), rtol=1e-12)
        np.testing.assert_allclose(found[n].imag, one.loss_modulus(OMEGA), rtol=1e-12)


def test_rows_with_a_dashpot_stand_beside_rows_with_branches():
    kelvin = Material(PronySeries(1e8, parallel_viscosity=1e4), bulk=5e8)
    solid = Material(PronySeries(1e8, [1e9], [1e-4]), bulk=5e8)
    columns, omega = MaterialColumns.from_materials([kelvin, solid]), np.geomspace(1e2, 1e6, 9)
    for n, one in enumerate((kelvin, solid)):
        exact = reduced_modulus(one)
        found = columns.reduced.complex_modulus(omega)[n]
        np.testing.assert_allclose(found, exact.storage_modulus(omega) + 1j * exact.loss_modulus(omega), rtol=1e-12)


@pytest.mark.parametrize("exponent", [0.05, 0.3, 0.6, 0.9])
def test_fractional_models_are_valid_within_their_window(exponent):
    window = 1e-4, 1e-2
    time = np.geomspace(*window, 30)
    for model in (springpot(1e6, exponent), fractional_zener(1e6, 1e8, 1e-3, exponent)):
        columns = PronyColumns.from_fractional([model], window)
        np.testing.assert_allclose(columns.relaxation_modulus(time)[0], model.relaxation_modulus(time), rtol=1e-6)
        exact = model.carson_transform(1j / time)
        np.testing.assert_allclose(columns.complex_modulus(1.0 / time)[0].imag, exact.imag, rtol=2e-6)


def test_fractional_rows_are_smooth_functions_of_the_exponent():
    """All rows have the same times except at the ends, so differences are derivatives."""
    time, step = np.geomspace(1e-4, 1e-2, 9), 1e-5
    rows = [springpot(1e6, 0.3 + k * step) for k in (-1, 0, 1)]
    found = np.log(PronyColumns.from_fractional(rows, (1e-4, 1e-2)).relaxation_modulus(time))
    exact = np.log([row.relaxation_modulus(time) for row in rows])
    np.testing.assert_allclose(found[2] - found[0], exact[2] - exact[0], rtol=1e-5)


def test_materials_of_all_kinds_become_columns():
    relaxing = Material(PronySeries(1.0, [2.0], [1.0]), PronySeries(3.0, [1.0], [0.1]))
    mixed = [Material(PronySeries(1.0, [2.0], [1.0]), 4.0), relaxing, Material(2.0, math.inf)]
    found = MaterialColumns.from_materials(mixed).reduced.complex_modulus(OMEGA)
    for n, one in enumerate(mixed):
        np.testing.assert_allclose(found[n].real, reduced_modulus(one).storage_modulus(OMEGA), rtol=1e-12)
    gel = [FractionalMaterial(springpot(1e4, exponent), bulk) for exponent, bulk in ((0.2, 1e6), (0.3, math.inf))]
    assert MaterialColumns.from_materials(gel, (1e-3, 1.0)).size == 2


def test_temperature_scales_all_times():
    warm = Material(PronySeries(0.0, [1e9], [1.0]), 2e9, shift=WLF(300.0, 10.0, 100.0))
    found = MaterialColumns.from_materials([warm]).at(325.0)
    assert found.shear.times[0, 0] == pytest.approx(0.01)
    with pytest.raises(InputError, match="temperature"):
        found.at(330.0)


def test_moduli_at_the_ends_of_the_range_of_times():
    """A branch with an infinite time is a spring, one with the time 0 is absent."""
    columns = PronyColumns(np.ones(2), np.zeros(2), np.full((2, 1), 3.0), np.array([[np.inf], [0.0]]))
    assert columns.complex_modulus(OMEGA).tolist() == [[4.0 + 0.0j] * OMEGA.size, [1.0 + 0.0j] * OMEGA.size]
    assert columns.storage_modulus(np.ones(2)).tolist() == [4.0, 1.0]
