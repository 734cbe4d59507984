"""Unit and range of a quantity are stated once, in the registry."""

import ast
import re
from pathlib import Path

import pytest

import restitution as rs
from restitution.contact.geometry import Geometry
from restitution.material.models import constants_of
from restitution.quantities import CONSTANTS, INPUTS
from restitution.sweeps.plan import input_attributes

PACKAGE = Path(__file__).resolve().parents[2] / "src" / "restitution"
QUANTITIES = INPUTS | CONSTANTS
MODULES = sorted(PACKAGE.rglob("*.py"))
CHECKS = {"finite", "positive", "nonnegative", "single_positive", "single_nonnegative", "within", "between"}
# Few modules have such calls with a text first, and only these need be parsed.
CALL = re.compile(rf"\b(?:{'|'.join(CHECKS)})\(\s*[rubRUB]*[\"']")


def restated(text: str) -> list[str]:
    """Calls that check a registered quantity against a unit of their own."""
    if not CALL.search(text):
        return []
    calls = (node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call) and len(node.args) > 2)
    return [
        ast.unparse(call)
        for call in calls
        if getattr(call.func, "attr", getattr(call.func, "id", "")) in CHECKS
        and isinstance(call.args[0], ast.Constant)
        and (quantity := QUANTITIES.get(str(call.args[0].value)))
        and isinstance(call.args[-1], ast.Constant)
        and call.args[-1].value in (quantity.unit, quantity.high)
    ]


def test_registered_quantities_are_checked_by_the_registry():
    units_of = {path.relative_to(PACKAGE): restated(path.read_text(encoding="utf-8")) for path in MODULES}
    assert {path: calls for path, calls in units_of.items() if calls} == {}


def test_a_restated_unit_is_found():
    assert restated('positive("velocity", v, "m/s")') == ["positive('velocity', v, 'm/s')"]
    assert restated('check("velocity", v), positive("contact_time", t, "s")') == []


@pytest.mark.parametrize("name", ["Parabola", "TruncatedCone", "FlatEndedParabola", "Ellipsoid", "Pyramid", "Layer"])
def test_the_numbers_of_geometries_have_units_as_axes(name: str) -> None:
    kind: type[Geometry] = getattr(rs, name)
    units = {constant.name: constant.quantity.unit for constant in constants_of(kind).values()}
    assert units
    assert {key: input_attributes(key)["units"] for key in units} == units
