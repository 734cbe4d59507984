"""Arrays of trial materials: of all kinds, with shifts of their own, and rows that a model refuses."""

import math

import numpy as np
import pytest

import restitution as rs
from refusals import named
from restitution.identification.parameters import column, parameters, rows_of
from restitution.material.fractional import FractionalMaterial

OMEGA, WINDOW = np.geomspace(1e-3, 1e7, 41), (1e-6, 1.0)


def test_materials_of_all_kinds_stand_in_one_column():
    relaxing = rs.Material(rs.PronySeries(1.0, [2.0], [1.0]), rs.PronySeries(3.0, [1.0], [0.1]))
    kinds = [rs.Material(rs.PronySeries(1.0, [2.0], [1.0]), 4.0), relaxing, rs.Material(2.0, math.inf)]
    rows = rs.reduced_modulus(column(kinds)).complex_modulus(OMEGA)
    for row, material in zip(rows, kinds, strict=True):
        np.testing.assert_array_equal(row, rs.reduced_modulus(material).complex_modulus(OMEGA))
    gels = [FractionalMaterial(rs.springpot(1e4, exponent), bulk) for exponent, bulk in ((0.2, 1e6), (0.3, math.inf))]
    assert column(gels, (1e-3, 1.0)).shape == (2, 1)
    assert column([gels[0], kinds[0]], (1e-3, 1.0)).shape == (2, 1)


def test_materials_with_unlike_shifts_keep_them():
    laws = rs.WLF(300.0, 10.0, 100.0), rs.WLF(310.0, 8.0, 90.0)
    warm = [rs.Material(rs.PronySeries(0.0, [1e9], [1.0]), 2e9, shift=law) for law in laws]
    temperatures = np.array([312.0, 325.0])
    rows = column(warm).at(temperatures).shear.relaxation_times[..., 0]
    expected = [[material.at(value).shear.relaxation_times[0] for value in temperatures] for material in warm]
    np.testing.assert_array_equal(rows, expected)


@pytest.mark.parametrize("law", [rs.WLF, rs.Arrhenius])
def test_unknown_constants_of_a_shift_are_those_of_each_row(law):
    fixed = {"poisson_ratio": 0.5, "reference_temperature": 300.0}
    space = parameters(rs.standard_solid, fixed=fixed, shift=law)
    start = {"c1": 10.0, "c2": 100.0, "activation_energy": 1e5}
    point = [parameter.inward(start.get(parameter.name, 1e6)) for parameter in space.free]
    points = np.array([point, point]) + np.array([[0.0], [0.1]])
    rows = space.materials(points, WINDOW).at(np.array([290.0, 320.0])).shear.relaxation_times[..., 0]
    for row, each in zip(rows, points, strict=True):
        single = space.material(each)
        expected = [single.at(value).shear.relaxation_times[0] for value in (290.0, 320.0)]
        np.testing.assert_allclose(row, expected, rtol=1e-12)


def test_rows_of_a_model_are_its_materials():
    for model, fixed in (
        ("generalised_maxwell", {"poisson_ratio": 0.3}), ("elastic", {"youngs_modulus": 1e6}), ("kelvin_voigt", {}),
        ("burgers", {}), (lambda g, nu: rs.standard_solid(g, 1e6, 1e3, poisson_ratio=0.4 + 0.0 * nu), {}),
    ):  # fmt: skip
        space = parameters(model, fixed=fixed)
        points = np.log(1e6) + np.linspace(0.0, 1.0, 3 * len(space.free)).reshape(3, -1)
        many = rs.reduced_modulus(space.materials(points, WINDOW))
        assert many.shape == (3, 1)
        for n, point in enumerate(points):
            single = rs.reduced_modulus(space.material(point)).complex_modulus(OMEGA)
            np.testing.assert_allclose(many.row(n, 0).complex_modulus(OMEGA), single, rtol=1e-12)


def test_refused_rows_are_nan_and_others_are_as_alone():
    """A Young's modulus above nine bulk moduli belongs to no material."""
    space = parameters("elastic", fixed={"youngs_modulus": 9.0})
    bulk = np.log(np.array([[2.0], [0.5], [3.0], [0.9], [0.1]]))

    def moduli(rows):
        return rs.reduced_modulus(space.materials(bulk[rows], WINDOW)).equilibrium_modulus

    assert named(lambda: moduli(slice(None))) == ("bulk_modulus", 0.5)
    result = rows_of(moduli, 5)
    assert np.isnan(result[:, 0]).tolist() == [False, True, False, True, True]
    assert result[[0, 2], 0].tolist() == [moduli(slice(n, n + 1))[0, 0] for n in (0, 2)]
    assert np.isnan(rows_of(lambda rows: moduli(slice(3, 5)), 2)).tolist() == [[True], [True]]
