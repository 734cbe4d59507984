import math
from functools import partial
from typing import Annotated

import numpy as np
import pint
import pytest

from refusals import in_one_line, named
from restitution import (
    Material,
    PronySeries,
    burgers,
    elastic,
    fractional_maxwell,
    fractional_zener,
    generalised_maxwell,
    kelvin_voigt,
    maxwell,
    standard_solid,
)
from restitution.material import models
from restitution.material.models import constants_of, material_model, material_models
from restitution.material.viscoelastic import reduced_modulus
from restitution.quantities import Quantity

pytestmark = pytest.mark.plain


@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.3, 0.5])
def test_elastic_constants_from_any_pair(nu):
    """Landau and Lifshitz, section 5: E = 9KG/(3K + G), E* = E/(1 - nu^2)."""
    material = elastic(youngs_modulus=210e9, poisson_ratio=nu)
    assert material.poisson_ratio == pytest.approx(nu, rel=1e-14, abs=1e-15)
    assert reduced_modulus(material).equilibrium_modulus == pytest.approx(210e9 / (1 - nu**2), rel=1e-14)
    g = material.shear.equilibrium_modulus
    k = math.inf if nu == 0.5 else material.bulk.equilibrium_modulus
    if nu < 0.5:
        assert 9 * k * g / (3 * k + g) == pytest.approx(210e9, rel=1e-14)
    for same in (
        elastic(youngs_modulus=210e9, bulk_modulus=k),
        elastic(shear_modulus=g, poisson_ratio=nu),
        elastic(shear_modulus=g, bulk_modulus=k),
    ):
        assert same.shear.equilibrium_modulus == pytest.approx(g, rel=1e-14)
        assert same.poisson_ratio == pytest.approx(nu, rel=1e-14, abs=1e-14)


@pytest.mark.parametrize(
    ("constants", "expected"),
    [
        ({"shear_modulus": 1.0}, ("poisson_ratio, bulk_modulus",)),
        ({"poisson_ratio": 0.3}, ("shear_modulus, youngs_modulus",)),
        ({"poisson_ratio": 0.3, "bulk_modulus": 1.0}, ("shear_modulus, youngs_modulus",)),
        ({"shear_modulus": 1.0, "youngs_modulus": 1.0, "poisson_ratio": 0.3}, ("shear_modulus, youngs_modulus",)),
        ({"shear_modulus": 1.0, "bulk_modulus": 1.0, "poisson_ratio": 0.3}, ("poisson_ratio, bulk_modulus",)),
        ({"youngs_modulus": 9.0, "bulk_modulus": 1.0}, ("bulk_modulus", 1.0)),
        ({"youngs_modulus": 9.0, "poisson_ratio": -1.0}, ("poisson_ratio", -1.0)),
        ({"shear_modulus": 0.0, "poisson_ratio": 0.3}, ("shear_modulus", 0.0)),
        ({"shear_modulus": 1.0, "poisson_ratio": 0.51}, ("poisson_ratio", 0.51)),
    ],
)
def test_elastic_refuses(constants, expected):
    assert named(lambda: elastic(**constants)) == expected


def test_maxwell_relaxes_to_zero():
    material = maxwell(2.0, 6.0, bulk_modulus=math.inf, density=1000.0, name="putty")
    assert material.shear.relaxation_modulus(3.0) == pytest.approx(2.0 / math.e)
    assert material.shear.is_liquid
    assert (material.density, material.name) == (1000.0, "putty")


def test_kelvin_voigt_in_shear_and_bulk():
    material = kelvin_voigt(3.0, 6.0, poisson_ratio=0.25, bulk_viscosity=7.0)
    assert material.shear == PronySeries(3.0, parallel_viscosity=6.0)
    assert material.bulk.equilibrium_modulus == pytest.approx(5.0)
    assert material.bulk.parallel_viscosity == 7.0
    # At high frequency both are dashpots: E* = 4 eta (3 zeta + eta)/(3 zeta + 4 eta) for the viscosities.
    assert reduced_modulus(material).parallel_viscosity == pytest.approx(24.0 * 27.0 / 45.0, rel=1e-15)
    assert kelvin_voigt(3.0, 6.0, poisson_ratio=0.5, bulk_viscosity=7.0).is_incompressible


def test_burgers_creep_is_the_sum_of_its_parts():
    t = np.linspace(0.0, 20.0, 41)
    material = burgers(2.0, 6.0, 4.0, 12.0, bulk_modulus=math.inf)
    expected = 1 / 2.0 + t / 6.0 + (1 - np.exp(-t * 4.0 / 12.0)) / 4.0
    assert material.shear.creep_compliance(t) == pytest.approx(expected, rel=1e-14, abs=0)
    assert material.shear.n_branches == 2


def test_burgers_relaxation_times_by_its_quadratic():
    """Findley, Lai, Onaran, section 5.6: 1 + p1 s + p2 s^2 with p1 = eta1/R1 + eta1/R2 + eta2/R2."""
    shear = burgers(2.0, 6.0, 4.0, 12.0, bulk_modulus=math.inf).shear
    p1, p2 = 6 / 2 + 6 / 4 + 12 / 4, 6 * 12 / (2 * 4)
    assert shear.relaxation_times == pytest.approx(np.sort(-1 / np.roots([p2, p1, 1.0])), rel=1e-14, abs=0)


def test_generalised_maxwell():
    material = generalised_maxwell(3.0, [1.0, 2.0], [1.0, 10.0], poisson_ratio=0.25)
    assert material.shear == PronySeries(3.0, [1.0, 2.0], [1.0, 10.0])
    assert material.bulk == PronySeries(5.0)


def test_standard_solid_needs_exactly_one_bulk_constant():
    with pytest.raises(ValueError, match=r"^poisson_ratio, bulk_modulus: exactly one must be given; none is given$"):
        standard_solid(1.0, 1.0, 1.0)
    with pytest.raises(ValueError, match=r"; poisson_ratio and bulk_modulus are given$"):
        standard_solid(1.0, 1.0, 1.0, poisson_ratio=0.3, bulk_modulus=1.0)
    with pytest.raises(ValueError, match="liquid"):
        standard_solid(0.0, 1.0, 1.0, poisson_ratio=0.3)
    assert named(lambda: standard_solid(1.0, 1.0, 1.0, poisson_ratio=0.6)) == ("poisson_ratio", 0.6)
    assert standard_solid(0.0, 1.0, 1.0, poisson_ratio=0.5).is_incompressible


def test_constants_come_from_the_signature(monkeypatch):
    monkeypatch.setattr(models, "_MODELS", dict(models._MODELS))
    stiffness = Quantity("stiffness", models.CONSTANTS["shear_modulus"].dimension, "stiffness", "", 0.0, open=True)

    @material_model(("a", "b"))
    def rubber(
        a: Annotated[float, stiffness] | None = None,
        b: Annotated[float, stiffness] | None = None,
        *,
        bulk_modulus: models.BulkModulus = 2e9,
        density: models.Density | None = None,
        name: str | None = None,
    ) -> Material:
        shear = a if a is not None else b
        assert shear is not None
        return Material(shear, bulk_modulus, density=density, name=name)

    model = material_models()["rubber"]
    assert (list(model.constants), model.one_of, model.needs_window) == (
        ["a", "b", "bulk_modulus"],
        (("a", "b"),),
        False,
    )
    assert model.constants["a"] == models.Constant("a", stiffness, False, False)
    assert model.build(a=3.0, density=1000.0).shear == PronySeries(3.0)
    for wrong, field in (({}, "a, b"), ({"a": 1.0, "b": 1.0}, "a, b"), ({"a": -1.0}, "a"), ({"b": [1.0, -2.0]}, "b")):
        assert in_one_line(partial(rubber, **wrong)).field == field


def test_every_model_is_built_from_its_constants():
    ratio = {"poisson_ratio": 0.5}
    for name, model in material_models().items():
        arguments = {
            key: [1.0] if item.is_list else 0.5 if key == "exponent" else 1.0
            for key, item in model.constants.items()
            if item.required
        }
        for group in model.one_of:
            arguments |= ratio if "poisson_ratio" in group else {group[0]: 1.0}
        result = model.build(**arguments, density=900.0, name="x")
        material = result.within((1e-3, 1.0)) if model.needs_window else result
        assert (material.density, material.name) == (900.0, "x"), name
        assert material.is_incompressible or name in ("maxwell", "burgers")


def test_constants_carry_units():
    unit = pint.UnitRegistry()
    assert elastic(youngs_modulus=3 * unit.kPa, poisson_ratio=0.5).shear == PronySeries(1000.0)
    assert fractional_maxwell(2 * unit.kPa, 1 * unit.ms, 0.5).instantaneous_modulus == 2000.0
    assert in_one_line(lambda: standard_solid(1 * unit.m, 1.0, 1.0, poisson_ratio=0.3)).field == "equilibrium_modulus"


def test_constants_are_numbers_or_lists():
    constants = constants_of(material_models()["generalised_maxwell"].build)
    assert [constant.is_list for constant in constants.values()][:3] == [False, True, True]


@pytest.mark.parametrize(
    ("moduli", "times"), [([2.0, 3.0], [0.1]), (np.ones((3, 2)), np.ones((2, 2))), (np.ones(5000), np.ones(5000))]
)
def test_branches_that_do_not_fit_each_other_are_refused(moduli, times):
    assert "branch_moduli" in in_one_line(lambda: generalised_maxwell(1.0, moduli, times, bulk_modulus=1e9)).field


def test_a_wrong_argument_is_named_with_those_of_the_model():
    with pytest.raises(TypeError, match=r"standard_solid\(\) .*'poison_ratio'; its arguments are .*, poisson_ratio, "):
        standard_solid(1e6, 1e7, 1e3, poison_ratio=0.4)
    with pytest.raises(TypeError, match=r"fractional_zener\(\) missing .*'exponent'; its arguments are "):
        fractional_zener(1e6, 1e7, 1e-3)
