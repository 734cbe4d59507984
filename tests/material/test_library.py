import math

import numpy as np
import pytest

from refusals import named
from restitution import InputError, PronySeries, fit_prony, library, read_material, reduced_modulus, tension_from_shear


def test_at_least_eight_materials_with_their_source():
    assert len(library.names()) >= 8
    for name in library.names():
        material = library.get(name)
        assert material.name == name
        assert material.source
        assert material.assumptions
        assert (material.window is None) == (material.shear.is_elastic and name != "ice")
        assert 0.0 < material.instantaneous_poisson_ratio < 0.5
        assert reduced_modulus(material).instantaneous_modulus > 0
        # Between the lightest polymer and tungsten; None where the polymer itself is unknown.
        assert (material.density is None) == (name in ("dma_polymer", "relaxation_polymer"))
        assert material.density is None or 850.0 < material.density < 2e4


def test_unknown_name():
    assert named(lambda: library.get("unobtainium")) == ("material", "unobtainium")
    with pytest.raises(InputError, match=r"^material = 'steal': is not known; did you mean steel?"):
        library.get("steal")


def test_materials_are_attributes():
    assert library.epoxy is library.get("epoxy")
    assert dir(library) == sorted(["get", "names", *library.names()])
    with pytest.raises(AttributeError, match="did you mean epoxy"):
        _ = library.epoxi
    assert not hasattr(library, "__wrapped__")


@pytest.mark.parametrize("temperature", [150.0, 201.9, 400.1, 500.0])
def test_polyisobutylene_outside_the_range_of_its_shift_is_refused(temperature):
    assert named(lambda: library.get("polyisobutylene").at(temperature)) == ("temperature", temperature)


def test_ice_is_the_average_of_the_measured_crystal():
    """Gammon et al. (1983) at -16 C, units of 1e8 Pa; hexagonal crystal, Voigt-Reuss-Hill."""
    c11, c12, c13, c33, c44 = 139.29, 70.82, 57.65, 150.10, 30.14
    c66 = (c11 - c12) / 2
    c = np.diag([c11, c11, c33, c44, c44, c66])
    c[0, 1] = c[1, 0] = c12
    c[0, 2] = c[2, 0] = c[1, 2] = c[2, 1] = c13
    s = np.linalg.inv(c)
    diagonal, beside, sheared = (
        (lambda m: m[0, 0] + m[1, 1] + m[2, 2]),
        (lambda m: m[0, 1] + m[1, 2] + m[0, 2]),
        (lambda m: m[3, 3] + m[4, 4] + m[5, 5]),
    )
    bulk = ((diagonal(c) + 2 * beside(c)) / 9 + 1 / (diagonal(s) + 2 * beside(s))) / 2
    voigt = (diagonal(c) - beside(c) + 3 * sheared(c)) / 15
    reuss = 15 / (4 * (diagonal(s) - beside(s)) + 3 * sheared(s))
    ice = library.get("ice")
    assert ice.shear.equilibrium_modulus == pytest.approx((voigt + reuss) / 2 * 1e8, rel=2e-4)
    assert ice.bulk.equilibrium_modulus == pytest.approx(bulk * 1e8, rel=2e-4)


@pytest.mark.parametrize(
    ("name", "shear", "bulk"),
    [("copper", 48.3, 137.8), ("brass", 37.3, 111.8), ("tungsten", 160.6, 311.0), ("fused_silica", 31.2, 36.9)],
)
def test_four_constants_of_kaye_and_laby(name, shear, bulk):
    """Shear and bulk modulus [GPa] of the same table agree within the rounding of the other two constants."""
    material = library.get(name)
    assert material.shear.equilibrium_modulus == pytest.approx(shear * 1e9, rel=2e-3)
    assert material.bulk.equilibrium_modulus == pytest.approx(bulk * 1e9, rel=3e-3)


def test_end_moduli_of_the_epoxy():
    epoxy = library.get("epoxy")
    assert epoxy.shear.instantaneous_modulus == pytest.approx(891e6, rel=1e-12)
    assert epoxy.shear.equilibrium_modulus == 4.9e6
    assert epoxy.shear.n_branches == 24
    assert epoxy.window == pytest.approx((1e-7, 1e5))


def test_polyisobutylene_in_tension_is_as_printed(shared_reference):
    terms = read_material(shared_reference / "materials" / "polyisobutylene_prony.csv")
    tension = tension_from_shear(library.get("polyisobutylene").shear, bulk_modulus=3e9)
    t = np.geomspace(1e-11, 1e5, 60)
    printed = PronySeries(0.0, terms.moduli, terms.relaxation_times)
    assert tension.relaxation_modulus(t) == pytest.approx(printed.relaxation_modulus(t), rel=2e-6)


def test_polyisobutylene_shifts_as_in_ferry():
    """Table 11-II also gives c1 = 16.6, c2 = 104 K at the glass transition, 202 K."""
    material = library.get("polyisobutylene")
    a = material.shift.factor(202.0)
    assert math.log10(material.shift.factor(250.0) / a) == pytest.approx(-16.6 * 48 / (104 + 48), rel=1e-2)
    cold = material.at(250.0)
    ratio = cold.shear.relaxation_times / material.shear.relaxation_times
    assert ratio == pytest.approx(np.full(30, material.shift.factor(250.0)), rel=1e-12)


@pytest.mark.parametrize(
    ("name", "file", "bulk"),
    [
        ("dma_polymer", "polymer_dma_master_curve.csv", 10e9),
        ("relaxation_polymer", "polymer_relaxation_master_curve.csv", 2e9),
    ],
)
def test_fitted_polymers_are_the_fits_of_their_data(shared_reference, name, file, bulk):
    fit = fit_prony(read_material(shared_reference / "materials" / file))
    tension = tension_from_shear(library.get(name).shear, bulk_modulus=bulk)
    assert library.get(name).window == pytest.approx(fit.window, rel=1e-5)
    t = np.geomspace(*fit.window, 80)
    assert tension.relaxation_modulus(t) == pytest.approx(fit.series.relaxation_modulus(t), rel=1e-4)


def test_dma_polymer_shifts_by_its_table():
    material = library.get("dma_polymer")
    assert material.temperature == pytest.approx(268.15)
    assert material.shift.factor(298.15) == pytest.approx(10**-4.08)
