"""Prefixes of units and labels of axes."""

import numpy as np
import pytest
import xarray as xr

from restitution.quantities import HISTORY, INPUTS, OUTPUTS, scaled
from restitution.units import scaled_unit


@pytest.mark.parametrize(
    ("values", "factor", "unit"),
    [
        ([0.0, 0.2], 1e3, "mN"),
        ([1.0], 1.0, "N"),
        ([999.9], 1.0, "N"),
        ([1000.0], 1e-3, "kN"),
        ([1e-3], 1e3, "mN"),
        ([0.999999999999e-3], 1e3, "mN"),
        ([-3e-6, 1e-9], 1e6, "µN"),
        ([0.0], 1.0, "N"),
        ([], 1.0, "N"),
        ([np.nan, 2e7, np.inf], 1e-6, "MN"),
        ([1e-20], 1e18, "aN"),
        ([1e20], 1e-12, "TN"),
    ],
)
def test_prefix_brings_the_largest_value_between_one_and_a_thousand(values, factor, unit) -> None:
    scaled = scaled_unit(values, "N")
    assert scaled.unit == unit
    assert scaled.factor == pytest.approx(factor, rel=1e-15)


@pytest.mark.parametrize(
    ("values", "unit", "expected"),
    [
        ([0.02], "kg", (1e3, "g")),
        ([3.0], "kg", (1.0, "kg")),
        ([2e-7], "kg", (1e9, "µg")),
        ([300.0], "K", (1.0, "K")),
        ([1100.0], "kg/m^3", (1.0, "kg/m^3")),
        ([0.3], "", (1.0, "")),
    ],
)
def test_units_that_take_no_prefix(values, unit, expected) -> None:
    assert scaled_unit(values, unit) == (pytest.approx(expected[0]), expected[1])


def test_words_and_symbols_are_those_of_the_registry() -> None:
    for table in (INPUTS, OUTPUTS, HISTORY):
        for quantity in table.values():
            label = quantity.label("x")
            assert quantity.words in label
            assert label.endswith(" [x]"), quantity


def test_a_prefix_over_many_decades_is_left_out() -> None:
    viscosity = xr.DataArray(np.logspace(0, 6, 5), attrs=INPUTS["viscosity"].attributes)
    assert scaled(viscosity).unit == "Pa s"
    assert scaled(viscosity[3:]).unit == "MPa s"
