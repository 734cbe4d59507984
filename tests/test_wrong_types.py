"""Wrong and unusual types in public functions: a sample of `validation/wrong_types.py`."""

import pytest
import xarray as xr

from checkout import script
from refusals import in_one_line


@pytest.fixture(scope="module")
def wrong_types():
    return script("validation/wrong_types.py")


@pytest.mark.usefixtures("folder")
def test_the_good_calls_work(wrong_types):
    assert {
        call.name: fault for call in wrong_types.calls() if (fault := wrong_types.run(call, call.arguments)[0])
    } == {}


@pytest.mark.parametrize("count", [400, pytest.param(None, marks=pytest.mark.slow)])
@pytest.mark.usefixtures("folder")
def test_wrong_types_are_refused_in_one_line(wrong_types, count):
    number, faults, _ = wrong_types.bad_calls(count, seed=5)
    assert number >= 400
    assert dict(faults) == {}


@pytest.mark.parametrize(
    ("name", "parameter", "kind"),
    [
        ("Impact", "diameters", "None"),
        ("Impact", "diameters", "Hostile"),
        ("calibrate", "extrapolate", "array"),
        ("calibrate", "radius", "1e308"),
        ("calibrate", "radius", "5e-324"),
        ("calibrate", "restitution", "Endless"),
        ("fit_prony", "smoothing", "1e308"),
        ("resilience", "tip_radius", "1e308"),
        ("resilience", "tip_radius", "5e-324"),
        ("sine_arch", "duration", "5e-324"),
        ("surrogate", "extrapolate", "NA"),
        ("sweep", "base", "type"),
        ("History.until", "time", "array"),
        ("Identification.to_toml", "path", "array"),
        ("ImpactResult.pressure", "r", "quantity of a foreign unit"),
        ("ImpactResult.validity_on", "body_size", "-1"),
        ("ImpactResult.validity_on", "body_size", "list"),
        ("Parabola.contact_radius", "depth", "quantity of a foreign unit"),
        ("PronySeries.complex_modulus", "angular_frequency", "quantity of a foreign unit"),
        ("Validity[]", "kind", "text"),
    ],
)
def test_an_extreme_or_foreign_object_is_refused_by_an_input_error(wrong_types, name, parameter, kind):
    call = next(call for call in wrong_types.calls() if call.name == name)
    in_one_line(lambda: call.function(**call.arguments | {parameter: wrong_types.bad_objects()[kind]}))


def test_a_chunk_larger_than_any_sweep_holds_all_points(wrong_types):
    call = next(call for call in wrong_types.calls() if call.name == "sweep")
    assert wrong_types.run(call, call.arguments | {"chunk": 10**400})[0] == ""


@pytest.mark.parametrize(
    ("method", "name", "small", "unit"),
    [
        ("Ellipsoid.contact_radius", "depth", 1e-2, "mm"),
        ("ImpactResult.pressure", "r", 1e-2, "mm"),
        ("Parabola.contact_radius", "depth", 1e-2, "mm"),
        ("Parabola.shape", "r", 1e-1, "mm"),
        ("PronySeries.carson_transform", "s", 1e-3, "1/ms"),
        ("PronySeries.complex_modulus", "angular_frequency", 1e-3, "rad/ms"),
        ("Pyramid.force_integral_at_depth", "depth", 1e-2, "mm"),
    ],
)
def test_methods_convert_units(wrong_types, method, name, small, unit):
    call = next(call for call in wrong_types.calls() if call.name == method)
    plain = call.function(**call.arguments)
    assert call.function(**call.arguments | {name: wrong_types.UNITS.Quantity(small, unit)}) == pytest.approx(plain)
    assert call.function(**call.arguments | {name: xr.DataArray(small, attrs={"units": unit})}) == pytest.approx(plain)


def test_numbers_in_other_containers_give_the_same_result(wrong_types):
    number, wrong = wrong_types.good_calls(seed=3)
    assert number > 60
    assert wrong == []
