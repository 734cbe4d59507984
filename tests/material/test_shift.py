import math
from dataclasses import replace
from functools import partial

import numpy as np
import pint
import pytest

from refusals import in_one_line, named
from restitution import Material, PronySeries
from restitution.material.shift import WLF, Arrhenius, Shift, ShiftTable

pytestmark = pytest.mark.plain


def test_wlf_universal_constants():
    """Williams, Landel, Ferry: C1 = 17.44, C2 = 51.6 K at the glass transition: 12 decades within 114 K."""
    law = WLF(300.0, 17.44, 51.6)
    assert law.factor(300.0) == 1.0
    assert math.log10(law.factor(400.0)) == pytest.approx(-17.44 * 100 / 151.6, rel=1e-12)


def test_wlf_is_the_same_law_from_another_reference():
    """C2' = C2 + T0' - T0 and C1' = C1 C2/C2'; Ferry (1980), ch. 11."""
    first = WLF(298.0, 8.61, 200.4)
    c2 = 200.4 - 50.0
    second = WLF(248.0, 8.61 * 200.4 / c2, c2)
    assert first.factor(280.0) / first.factor(248.0) == pytest.approx(second.factor(280.0), rel=1e-12)


def test_wlf_ends_at_the_vogel_temperature():
    """T = 298 K - 200.4 K = 97.6 K; a_T = 1e300 at x K below 298 K, with 8.61 x = 300 (200.4 - x)."""
    law = WLF(298.0, 8.61, 200.4)
    lowest = 298.0 - 300.0 * 200.4 / 308.61
    assert math.log10(law.factor(lowest + 1e-6)) == pytest.approx(300.0, rel=1e-5)
    with pytest.raises(
        ValueError, match=r"^temperature = 90 K: must be >= 103\.191 K, where the shift factor is between"
    ):
        law.factor(90.0)
    for temperature in (97.6, 100.0, lowest - 1e-3):
        assert named(partial(law.factor, temperature)) == ("temperature", temperature)
    assert law.factor(1e4) > 10**-8.61


@pytest.mark.parametrize("law", [WLF(300.0, 400.0, 100.0), Arrhenius(300.0, 3e6)])
def test_factors_too_small_for_numbers(law):
    assert named(lambda: law.factor(1e6)) == ("temperature", 1e6)


@pytest.mark.parametrize("law", [WLF(300.0, 10.0, 100.0), Arrhenius(300.0, 1e5)])
def test_a_law_is_refused_outside_its_range(law):
    bounded = replace(law, temperature_range=(280.0, 350.0))
    assert [bounded.factor(t) for t in (280.0, 350.0)] == [law.factor(t) for t in (280.0, 350.0)]
    for temperature in (279.9, 350.1):
        assert named(partial(Material(1.0, 2.0, shift=bounded).at, temperature)) == ("temperature", temperature)
    for limits in ((310.0, 350.0), (350.0, 280.0), (300.0, 300.0)):
        with pytest.raises(ValueError, match=r"temperature_range = .* K: must ascend and hold 300 K"):
            replace(law, temperature_range=limits)
    assert named(lambda: replace(law, temperature_range=(-1.0, 350.0))) == ("temperature_range", -1.0)


def test_arrhenius():
    """Q = R T T0 ln(a)/(T0 - T) for a decade between 300 K and 310 K."""
    energy = 8.31446261815324 * 300.0 * 310.0 * math.log(10.0) / 10.0
    assert Arrhenius(300.0, energy).factor(310.0) == pytest.approx(0.1, rel=1e-12)
    assert Arrhenius(300.0, energy).factor(300.0) == 1.0


def test_table_interpolates_the_logarithm():
    table = ShiftTable([280.0, 290.0, 300.0, 310.0], [3.0, 1.0, -1.0, -2.0])
    assert table.reference_temperature == 295.0
    assert table.factor(295.0) == 1.0
    assert table.factor(285.0) == pytest.approx(100.0)
    assert table == ShiftTable([280.0, 290.0, 300.0, 310.0], [3.0, 1.0, -1.0, -2.0])
    assert hash(table) == hash(ShiftTable([280.0, 290.0, 300.0, 310.0], [3.0, 1.0, -1.0, -2.0]))
    assert named(lambda: table.factor(279.0)) == ("temperature", 279.0)


@pytest.mark.parametrize(
    ("temperatures", "logs", "message"),
    [
        ([300.0], [0.0], "at least 2"),
        ([300.0, 310.0], [0.0], "equal length"),
        ([310.0, 300.0], [0.0, -1.0], "temperatures[1] = 300 K: must be strictly ascending"),
        ([300.0, 310.0], [0.0, 1.0], "log10_factors[1] = 1: must be strictly descending"),
        ([300.0, 310.0], [3.0, 1.0], "must pass through 0"),
        ([-1.0, 310.0], [1.0, -1.0], "temperatures[0] = -1 K"),
        ([300.0, 310.0], [0.0, math.nan], "log10_factors[1] = nan"),
        ([300.0, 310.0], [301.0, 0.0], "log10_factors[0] = 301"),
    ],
)
def test_table_refuses(temperatures, logs, message):
    assert message in str(in_one_line(lambda: ShiftTable(temperatures, logs)))


@pytest.mark.parametrize("law", [WLF(300.0, 10.0, 100.0), Arrhenius(300.0, 1e5), ShiftTable([290, 310], [1, -1])])
def test_material_at_a_temperature(law):
    assert isinstance(law, Shift)
    shear = PronySeries(1.0, [2.0, 3.0], [1e-3, 1.0], parallel_viscosity=0.5)
    bulk = PronySeries(10.0, [5.0], [2.0])
    material = Material(shear, bulk, shift=law, density=1000.0, name="x", window=(1e-3, 1e3))
    assert material.temperature == pytest.approx(300.0)
    a = law.factor(305.0)
    warm = material.at(305.0)
    assert warm.shear.relaxation_times == pytest.approx(a * shear.relaxation_times, rel=1e-14)
    assert warm.shear.branch_moduli.tolist() == [2.0, 3.0]
    assert warm.shear.parallel_viscosity == pytest.approx(0.5 * a, rel=1e-14)
    assert warm.bulk.relaxation_times == pytest.approx([2.0 * a], rel=1e-14)
    assert warm.window == pytest.approx((1e-3 * a, 1e3 * a))
    assert (warm.density, warm.name, warm.temperature) == (1000.0, "x", 305.0)
    # Two shifts and the shift back restore the material.
    again = warm.at(295.0).at(material.temperature)
    assert again.shear.relaxation_times == pytest.approx(shear.relaxation_times, rel=1e-13)
    omega = np.array([0.1, 10.0])
    assert warm.shear.storage_modulus(omega) == pytest.approx(shear.storage_modulus(omega * a), rel=1e-12)


def test_material_without_a_law_refuses():
    with pytest.raises(ValueError, match=r"^temperature = 300 K: must not be given without a time-temperature shift$"):
        Material(1.0, 2.0).at(300.0)


def test_window_is_checked():
    with pytest.raises(ValueError, match="must ascend"):
        Material(1.0, 2.0, window=(1.0, 1.0))


def test_elastic_material_does_not_change():
    material = Material(1.0, math.inf, shift=Arrhenius(300.0, 1e5))
    assert material.at(310.0).shear == material.shear


def test_units_are_converted_and_arrays_of_constants_refused():
    units = pint.UnitRegistry()
    law = WLF(
        units.Quantity(25.0, "degC"), 8.6, 200.0 * units.K, temperature_range=[units.Quantity(0.0, "degC"), 400.0]
    )
    assert law == WLF(298.15, 8.6, 200.0, temperature_range=(273.15, 400.0))
    assert Arrhenius(300.0, 100.0 * units.kJ / units.mol) == Arrhenius(300.0, 1e5)
    assert Material(1.0, 2.0, density=1.1 * units.g / units.cm**3).density == pytest.approx(1100.0)
    assert law.factor([300.0, 310.0]).tolist() == [law.factor(300.0), law.factor(310.0)]
    assert in_one_line(lambda: WLF([300.0, 310.0], 8.6, 200.0), TypeError).field == "reference_temperature"
