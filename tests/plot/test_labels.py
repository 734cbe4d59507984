import numpy as np
import pytest

from restitution.plot.labels import quantity_label, scaled_unit


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


def test_label_of_a_quantity_without_symbol() -> None:
    assert quantity_label("temperature", "K") == "temperature [K]"
