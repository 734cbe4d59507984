"""Registry of material models."""

from functools import partial
from typing import Annotated

import pint
import pytest

from refusals import in_one_line
from restitution import Material, PronySeries, elastic, fractional_maxwell, standard_solid
from restitution.material import models
from restitution.material.models import constants_of, material_model, material_models
from restitution.quantities import Quantity

pytestmark = pytest.mark.plain


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
