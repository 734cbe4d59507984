"""Checks of input: units are converted or refused, and so is everything that is not a number."""

import math
import pickle
import warnings
from decimal import Decimal
from functools import partial

import numpy as np
import pint
import pytest
import unyt
import xarray as xr
from astropy import units as astropy_units

import restitution as rs
from refusals import in_one_line, named
from restitution import checks, quantities
from restitution.checks import (
    between,
    finite,
    nonnegative,
    number,
    one_of,
    positive,
    positive_or_infinite,
    whole,
    within,
)
from restitution.errors import InputError

ureg = pint.UnitRegistry()


@pytest.mark.parametrize(
    "value",
    [
        100.0 * ureg.cm / ureg.s,
        unyt.unyt_quantity(100, "cm/s"),
        100.0 * astropy_units.cm / astropy_units.s,
        xr.DataArray(100.0, attrs={"units": "cm/s"}),
        xr.DataArray(1.0, attrs={"units": "m/s"}),
        xr.DataArray(1.0),
        np.float32(1.0),
        np.array(1),
        Decimal(1),
        1,
    ],
    ids=lambda value: type(value).__module__ + "." + type(value).__name__,
)
def test_all_forms_of_one_metre_per_second(value):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert positive("velocity", value, "m/s") == pytest.approx(1.0, rel=1e-15)


def test_text_with_a_unit_is_refused_with_the_unit_of_the_plain_number():
    with pytest.raises(InputError, match="numbers in m/s; text with a unit is for case files") as refused:
        positive("velocity", "1 m/s", "m/s")
    assert (refused.value.field, refused.value.value) == ("velocity", "1 m/s")


@pytest.mark.parametrize("library", ["pint", "unyt", "astropy", "list of pint"])
def test_arrays_are_converted_as_a_whole(library):
    speeds = np.random.default_rng(7).uniform(0.1, 10.0, 17)
    value = {
        "pint": speeds * 1e3 * ureg.mm / ureg.s,
        "unyt": unyt.unyt_array(speeds * 1e3, "mm/s"),
        "astropy": speeds * 1e3 * astropy_units.mm / astropy_units.s,
        "list of pint": [speed * 3.6 * ureg.km / ureg.hour for speed in speeds],
    }[library]
    assert np.asarray(positive("velocity", value, "m/s")) == pytest.approx(speeds, rel=1e-14)


@pytest.mark.parametrize(
    "value",
    [
        1.0 * ureg.kg,
        unyt.unyt_quantity(1, "kg"),
        1.0 * astropy_units.kg,
        xr.DataArray(1.0, attrs={"units": "kg"}),
        xr.DataArray(1.0, attrs={"units": "no unit at all"}),
        [1.0 * ureg.m / ureg.s, 1.0 * ureg.kg],
        1.0 * ureg.dimensionless,
    ],
)
def test_another_dimension_is_refused(value):
    error = in_one_line(lambda: positive("velocity", value, "m/s"))
    assert error.field.startswith("velocity")
    assert "m/s" in error.rule


def test_a_plain_number_may_only_have_a_dimensionless_unit():
    assert within("poisson_ratio", 45.0 * ureg.percent, -1.0, 0.5) == pytest.approx(0.45)
    assert in_one_line(lambda: within("poisson_ratio", 0.45 * ureg.m, -1.0, 0.5)).field == "poisson_ratio"


@pytest.mark.parametrize("unit", ["Pa s", "kg/m^3", "m/s^2", "J/mol", "K", "rad"])
def test_all_unit_libraries_support_the_units_of_the_registry(unit):
    for value in (
        ureg.Quantity(2.0, unit),
        unyt.unyt_quantity(2.0, unit.replace(" ", "*").replace("^", "**")),
        astropy_units.Quantity(2.0, unit),
    ):
        assert positive("x", value, unit) == pytest.approx(2.0, rel=1e-14)


@pytest.mark.parametrize(
    "value",
    [
        None, "1 m/s", b"1", True, 1j, np.array([1 + 0j]), np.array(["1", "2"]), [1, "a"], [True, False], object(),
        np.datetime64("2024-01-01"), np.timedelta64(1, "s"), {"a": 1}, [[1], [1, 2]],
        np.ma.array([1.0, 2.0], mask=[False, True]), np.ma.masked,
    ],
)  # fmt: skip
def test_values_that_are_not_numbers_are_refused(value):
    assert in_one_line(lambda: number("velocity", value, "m/s"), TypeError).field == "velocity"


def test_a_masked_array_without_masked_values_is_accepted():
    assert np.asarray(finite("x", np.ma.array([1.0, 2.0], mask=False))).tolist() == [1.0, 2.0]


def test_an_integer_beyond_float64_is_refused_in_one_short_line():
    assert len(str(in_one_line(lambda: positive("velocity", 10**400)))) < 200


@pytest.mark.parametrize(
    ("check", "good", "bad", "rule"),
    [
        (finite, -1.0, math.inf, "finite"),
        (positive, 1e-300, 0.0, "finite and > 0"),
        (positive_or_infinite, math.inf, 0.0, "> 0"),
        (nonnegative, 0.0, -1e-300, "finite and >= 0"),
        (partial(within, low=0.0, high=1.0), 1.0, 1.0000001, "in [0, 1]"),
        (partial(between, low=0.0, high=1.0), 0.5, 1.0, "> 0 and < 1"),
    ],
)
def test_ranges(check, good, bad, rule):
    assert check("x", good) == good
    for value in (bad, math.nan):
        assert named(partial(check, "x", [good, value, good])) == ("x", 1, value)
    assert in_one_line(lambda: check("x", bad)).rule == f"must be {rule}"


def test_whole_numbers_and_choices():
    assert whole("n", np.int64(3)) == 3
    for bad in (0, 1.0, True, "1"):
        assert named(partial(whole, "n", bad)) == ("n", bad)
    assert in_one_line(lambda: whole("n", 0)).rule == "must be a whole number >= 1"
    assert in_one_line(lambda: whole("n", 0, 1, 9)).rule == "must be a whole number in [1, 9]"
    assert one_of("errors", "warn", ("raise", "warn")) == "warn"
    assert str(in_one_line(lambda: one_of("errors", "stop", ("raise", "warn")))) == (
        "errors = 'stop': must be 'raise' or 'warn'"
    )
    rule = in_one_line(lambda: checks.common_shape({"a": (2,), "b": (3,)})).rule
    assert rule == "have shapes that do not broadcast against each other: a (2,), b (3,)"


def test_errors_keep_their_attributes_when_pickled():
    error = InputError("velocity", -1.0, "must be finite and > 0", "m/s", index=(2,)).within("impact", where="a.toml")
    twin = pickle.loads(pickle.dumps(error))
    assert str(twin) == str(error) == "a.toml: impact.velocity[2] = -1 m/s: must be finite and > 0"
    assert (twin.field, twin.value, twin.unit, twin.where) == ("impact.velocity", -1.0, "m/s", "a.toml")


@pytest.mark.parametrize("quantity", quantities.INPUTS.values(), ids=lambda quantity: quantity.name)
def test_every_quantity_refuses_what_lies_outside_its_range(quantity):
    low, high = max(quantity.low, -1.0), min(quantity.high, 10.0)
    inside = min(low + 0.25, 0.5 * (low + high))
    assert quantity.check(inside) == inside
    assert quantity.check(inside * ureg.Quantity(1.0, quantity.unit or "1")) == pytest.approx(inside)
    outside = [quantity.low - 1.0, np.nan]
    outside += [quantity.low] if quantity.open else []
    outside += [] if quantity.infinite else [quantity.high + 1.0 if np.isfinite(quantity.high) else np.inf]
    for value in outside:
        assert in_one_line(partial(quantity.check, value)).field == quantity.name


class Hostile:
    """Object whose conversions raise anything."""

    def __array__(self, *_, **__):
        raise RuntimeError("no array")

    def __repr__(self):
        raise RuntimeError("no text")

    def __eq__(self, other):
        raise RuntimeError("no comparison")

    def __iter__(self):
        raise RuntimeError("no iteration")

    __hash__ = None


@pytest.mark.parametrize(
    "value", [np.array([1, 2]), [1.0, 2.0], Hostile(), {"a": 1}, None, np.timedelta64(1, "s"), float("nan")]
)
@pytest.mark.parametrize(
    "check",
    [
        lambda value: one_of("x", value, ("raise", "warn")),
        lambda value: whole("x", value),
        lambda value: checks.truth("x", value),
        lambda value: checks.function("x", value, "must be a function", 1),
        lambda value: checks.instance("x", value, rs.Material, "must be a Material"),
        lambda value: checks.pair("x", value, "must be a pair of texts") and checks.whole("x", value),
        lambda value: checks.single_positive("x", value),
        lambda value: quantities.choice("x", value, ("a", "b")),
    ],
)
def test_other_types_are_refused_in_one_line(check, value):
    assert in_one_line(lambda: check(value)).field == "x"


def test_a_function_takes_the_stated_number_of_arguments():
    assert checks.function("f", len, "must be a function", 1) is len
    assert in_one_line(lambda: checks.function("f", lambda: 1, "must be a function", 1)).field == "f"


def test_a_public_name_with_a_slip_is_advised():
    with pytest.raises(AttributeError, match="did you mean solve"):
        _ = rs.solv


@pytest.mark.parametrize(
    "modulus",
    [
        ureg.Quantity(1.0, "mPa"),
        ureg.Quantity([1.0, 2.0], "millipascal"),
        [ureg.Quantity(1.0, "MPa"), ureg.Quantity(1.0, "mPa")],
        1.0 * astropy_units.mPa,
        unyt.unyt_quantity(1.0, "mPa"),
        xr.DataArray([1.0], attrs={"units": "mPa"}),
    ],
    ids=["pint", "pint array", "list of pint", "astropy", "unyt", "xarray"],
)
def test_a_modulus_in_millipascal_is_refused(modulus):
    assert in_one_line(lambda: quantities.check("branch_moduli", modulus)).field.startswith("branch_moduli")


@pytest.mark.parametrize("modulus", [1e-3, ureg.Quantity(1e-3, "Pa"), ureg.Quantity(1e-9, "MPa")])
def test_soft_moduli_in_other_units_are_accepted(modulus):
    assert quantities.check("branch_modulus", modulus) == pytest.approx(1e-3, rel=1e-15)


def test_a_viscosity_in_millipascal_seconds_is_accepted():
    assert quantities.check("viscosity", ureg.Quantity(1.0, "mPa s")) == pytest.approx(1e-3, rel=1e-15)
