"""Arrays of materials: each row has the bits of the material alone."""

import math

import numpy as np
import pytest

import restitution as rs
from refusals import in_one_line
from restitution.material.conversion import series_connection, shear_from_tension, tension_from_shear
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, reduced_modulus


def random_series(rng: np.random.Generator, dashpot: bool = True) -> PronySeries:
    """A solid or a liquid with up to six branches, two of them equal now and then."""
    count = int(rng.integers(0, 7))
    times = 10.0 ** rng.uniform(-6.0, 3.0, count)
    if count > 2 and rng.random() < 0.3:
        times[1] = times[0]
    viscosity = 10.0 ** rng.uniform(-2.0, 3.0) if dashpot and rng.random() < 0.3 else 0.0
    equilibrium = 0.0 if count and rng.random() < 0.3 else 10.0 ** rng.uniform(3.0, 7.0)
    return PronySeries(equilibrium, 10.0 ** rng.uniform(2.0, 8.0, count), times, parallel_viscosity=viscosity)


def random_material(rng: np.random.Generator) -> Material:
    """A material whose bulk is infinite, elastic or relaxes, at times of the shear now and then."""
    shear, kind = random_series(rng), rng.integers(4)
    bulk = (math.inf, 10.0 ** rng.uniform(4.0, 10.0), random_series(rng), shear.scaled(rng.uniform(0.5, 5.0)))[kind]
    return Material(shear, bulk)


def assert_rows_are(many: PronySeries, single: list[PronySeries]) -> None:
    """Each row of an array has the bits of a single series."""
    assert many.shape == (len(single),)
    for n, series in enumerate(single):
        assert many.row(n) == series


@pytest.mark.parametrize("seed", range(5))
def test_rows_of_reduced_moduli_have_the_bits_of_single_ones(seed: int):
    rng = np.random.default_rng(seed)
    materials = [random_material(rng) for _ in range(40)]
    many = Material.stacked(materials)
    assert_rows_are(reduced_modulus(many), [reduced_modulus(material) for material in materials])
    pairs = rng.permutation(materials).tolist()
    of_pairs = [reduced_modulus(material, other) for material, other in zip(materials, pairs, strict=True)]
    assert_rows_are(reduced_modulus(many, Material.stacked(pairs)), of_pairs)
    for n in rng.integers(0, 40, 5).tolist():
        assert reduced_modulus(many.row(n)) == reduced_modulus(materials[n])


def test_rows_of_conversions_have_the_bits_of_single_ones():
    rng = np.random.default_rng(6)
    series = [random_series(rng, dashpot=False) for _ in range(40)]
    many = PronySeries.stacked(series)
    bulk = np.array([part.instantaneous_modulus * rng.choice([0.12, 0.5, 10.0, math.inf]) for part in series])
    pairs = list(zip(series, bulk.tolist(), strict=True))
    shear = [shear_from_tension(item, bulk_modulus=modulus) for item, modulus in pairs]
    assert_rows_are(shear_from_tension(many, bulk_modulus=bulk), shear)
    tension = [tension_from_shear(item, bulk_modulus=modulus) for item, modulus in pairs]
    assert_rows_are(tension_from_shear(many, bulk_modulus=bulk), tension)
    assert_rows_are(many.simplified(), [part.simplified() for part in series])
    single = [series_connection(part, series[0]) for part in series]
    assert_rows_are(series_connection(many, series[0]), single)


def test_functions_of_time_and_frequency_broadcast():
    rng = np.random.default_rng(7)
    materials = [random_material(rng) for _ in range(12)]
    many, times = Material.stacked(materials).reshaped((12, 1)), np.geomspace(1e-5, 1e3, 9)
    for function in (
        lambda item: item.shear.relaxation_modulus(times),
        lambda item: item.shear.storage_modulus(times),
        lambda item: item.shear.creep_compliance(times),
        lambda item: item.relaxation_poisson_ratio(times),
    ):
        single = np.array([function(material) for material in materials])
        np.testing.assert_allclose(
            function(many), single, rtol=1e-9, atol=1e-12 * np.abs(single[np.isfinite(single)]).max()
        )
    ratios = [(material.poisson_ratio, material.instantaneous_poisson_ratio) for material in materials]
    np.testing.assert_array_equal(many.poisson_ratio[:, 0], [static for static, _ in ratios])
    np.testing.assert_array_equal(many.instantaneous_poisson_ratio[:, 0], [first for _, first in ratios])


def test_constants_of_models_are_arrays():
    branch = np.logspace(6, 8, 5)
    many = rs.standard_solid(1e6, branch, 1e4, poisson_ratio=[[0.3], [0.5]])
    assert many.shape == (2, 5)
    for i, nu in enumerate((0.3, 0.5)):
        for j, modulus in enumerate(branch.tolist()):
            single = rs.standard_solid(1e6, modulus, 1e4, poisson_ratio=nu)
            assert (many.row(i, j).shear, many.row(i, j).bulk) == (single.shear, single.bulk)
    assert rs.elastic(youngs_modulus=[1e6, 2e6], poisson_ratio=0.3).shape == (2,)
    assert rs.maxwell(1e6, [1.0, 2.0], bulk_modulus=1e9).shape == (2,)
    assert rs.kelvin_voigt(1e6, [1.0, 2.0], poisson_ratio=[[0.3], [0.5]]).shape == (2, 2)
    assert rs.burgers(1e6, [1.0, 2.0], 1e6, 3.0, bulk_modulus=1e9).shape == (2,)
    assert rs.generalised_maxwell(1e6, [1e6, 2e6], [[1e-3, 1.0], [1e-2, 1.0]], poisson_ratio=0.3).shape == (2,)
    caught = in_one_line(lambda: rs.standard_solid(1e6, [1e6, -1e6], 1e4, poisson_ratio=0.3))
    assert (caught.field, caught.index) == ("branch_modulus", (1,))


def test_temperatures_are_an_axis():
    shift = rs.WLF(300.0, 10.0, 100.0)
    material = Material(PronySeries(1e6, [1e9], [1.0]), 2e9, shift=shift, window=(1e-3, 1e3))
    temperatures = np.array([290.0, 300.0, 325.0])
    many = material.at(temperatures)
    assert many.shape == (3,)
    for n, temperature in enumerate(temperatures.tolist()):
        assert many.row(n) == material.at(temperature)


@pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning")
@pytest.mark.parametrize(
    "profile", [rs.Parabola(0.01), rs.Cone(1.2), rs.Sphere(0.02), rs.Layer(rs.Parabola(0.01), [0.003, 0.005])]
)
def test_impacts_of_many_materials_have_the_bits_of_single_ones(profile):
    rng = np.random.default_rng(8)
    materials = [
        rs.standard_solid(1e6, 3e6, 1e3, poisson_ratio=0.45), Material(1e6, math.inf, density=1e3),
        rs.generalised_maxwell(1e6, 10.0 ** rng.uniform(5, 7, 5), 10.0 ** rng.uniform(-5, -1, 5), poisson_ratio=0.5),
        rs.maxwell(1e7, 1e5, bulk_modulus=1e11),
    ]  # fmt: skip
    several = Material.stacked(materials).reshaped((4, 1))
    velocity = np.array([0.05, 0.2])
    result = rs.solve(rs.Impact(several, profile, mass=0.005, velocity=velocity), errors="warn")
    assert result.restitution_coefficient.shape == (4, 2)
    for i, material in enumerate(materials):
        for j in range(2):
            first = rs.Layer(rs.Parabola(0.01), [0.003, 0.005][j]) if isinstance(profile, rs.Layer) else profile
            single = rs.solve(rs.Impact(material, first, mass=0.005, velocity=float(velocity[j])), errors="warn")
            assert result.restitution_coefficient[i, j] == single.restitution_coefficient
            assert result.contact_time[i, j] == single.contact_time
    assert result.validity["small_strain"].value > 0.0


def test_validity_takes_the_worst_of_many_materials():
    materials = [rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=nu, density=1e3) for nu in (0.45, 0.2)]
    impacts = [rs.Impact(material, rs.Parabola(0.01), mass=0.005, velocity=1.0) for material in materials]
    many = rs.Impact(Material.stacked(materials), rs.Parabola(0.01), mass=0.005, velocity=1.0)
    with pytest.warns(rs.RestitutionWarning):
        array, listed = rs.solve(many), rs.solve(impacts)
    assert array.validity.to_dict() == listed.validity.to_dict()


MANY = rs.standard_solid(1e6, [1e7, 2e7], 1e3, poisson_ratio=0.45, density=1200.0)
IMPACTS = rs.Impact(MANY, rs.Parabola(0.01), mass=0.005, velocity=1.0)


@pytest.mark.parametrize(
    ("field", "refused"),
    [
        ("material", lambda: rs.indent(MANY, rs.Parabola(0.01), time=[0.0, 1.0, 2.0], depth=[0.0, 1e-4, 0.0])),
        ("material", lambda: rs.contact_law(IMPACTS)),
        ("material", lambda: rs.resilience(MANY)),
        ("material", lambda: rs.write_material(MANY, "many.inp")),
        ("material", lambda: MANY.plot()),
        ("series", lambda: MANY.shear.plot()),
        ("impact.material", lambda: rs.dimensionless_groups(IMPACTS)),
        ("counter_material", lambda: rs.Rebounds([1.0], [0.5], radius=0.01, mass=0.005, counter_material=MANY)),
        ("materials[0]", lambda: Material.stacked([MANY])),
        ("materials", lambda: Material.stacked([])),
        ("coefficient", lambda: rs.springpot([1e4, 1e5], 0.2)),
        ("equilibrium_modulus, branch_modulus, viscosity, poisson_ratio",
         lambda: rs.standard_solid(1e6, [1e7, 2e7], [1e3, 2e3, 3e3], poisson_ratio=0.4)),
    ],
)  # fmt: skip
def test_what_takes_a_single_material_refuses_an_array(field, refused):
    assert in_one_line(refused).field == field


def test_arrays_of_materials_cite_and_resist_as_one():
    assert "Willert" in rs.cite(IMPACTS)
    steel = rs.elastic(youngs_modulus=[2e11, 1e11], poisson_ratio=0.3, density=7800.0)
    single = [rs.plate_impedance(steel.row(n), 0.01) for n in range(2)]
    assert rs.plate_impedance(steel, 0.01).tolist() == single


def test_one_spring_in_bulk_beside_many_dashpots():
    viscosities = np.array([1e2, 2e2])
    solids = rs.kelvin_voigt(1e6, 1e3, bulk_modulus=1e9, bulk_viscosity=viscosities)
    assert solids.bulk.equilibrium_modulus.tolist() == [1e9, 1e9]
    assert solids.bulk.parallel_viscosity.tolist() == viscosities.tolist()


@pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning")
def test_materials_of_fewer_terms_beside_those_of_many_keep_their_bits():
    # Sums of eight and more numbers may be added in another order where zeros stand behind them.
    rng = np.random.default_rng(2)
    materials = [
        Material(PronySeries(1e6, 10.0 ** rng.uniform(5, 7, n), 10.0 ** rng.uniform(-6, 2, n)), math.inf)
        for n in rng.choice([1, 5, 9, 12, 20], 60).tolist()
    ]
    several = rs.solve(rs.Impact(Material.stacked(materials), rs.Parabola(0.01), mass=0.004, velocity=1.0))
    for material, e in zip(materials, several.restitution_coefficient.tolist(), strict=True):
        single = rs.solve(rs.Impact(material, rs.Parabola(0.01), mass=0.004, velocity=1.0))
        assert single.restitution_coefficient == e
