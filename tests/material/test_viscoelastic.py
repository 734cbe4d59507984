import math

import pytest

from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, bulk_from_poisson_ratio, poisson_ratio

pytestmark = pytest.mark.plain


def test_numbers_mean_elastic():
    material = Material(1.0, 2.0)
    assert material.shear == PronySeries(1.0)
    assert material.bulk == PronySeries(2.0)
    assert Material(1.0, math.inf).bulk == math.inf


@pytest.mark.parametrize(
    ("shear", "bulk", "ratio"), [(1.0, 0.0, -1.0), (3.0, 2.0, 0.0), (3.0, 5.0, 0.25), (1.0, math.inf, 0.5)]
)
def test_static_poisson_ratio(shear, bulk, ratio):
    """Eq. (3) of the paper: nu = (3 K - 2 G)/(6 K + 2 G)."""
    assert Material(shear, bulk).poisson_ratio == ratio
    assert bulk_from_poisson_ratio(shear, ratio) == bulk


def test_poisson_ratio_near_its_limit_keeps_its_distance():
    """1/2 - nu = 3G/(6K + 2G), to first order G/(2K)."""
    assert 0.5 - poisson_ratio(1.0, 1e12) == pytest.approx(0.5e-12, rel=1e-3, abs=0)


def test_static_and_instantaneous_poisson_ratio_of_a_relaxing_material():
    material = Material(PronySeries(3.0, [7.0], [1.0]), 5.0)
    assert material.poisson_ratio == 0.25
    assert material.instantaneous_poisson_ratio == pytest.approx((15.0 - 20.0) / (30.0 + 20.0))


def test_poisson_ratio_of_liquids():
    shear = PronySeries(0.0, [3.0], [1.0])
    assert Material(shear, 5.0).poisson_ratio == 0.5
    assert Material(shear, PronySeries(0.0, [5.0], [1.0])).poisson_ratio == 0.25


def test_poisson_ratio_with_dashpots():
    shear = PronySeries(3.0, parallel_viscosity=3.0)
    assert Material(shear, 5.0).instantaneous_poisson_ratio == -1.0
    assert Material(shear, PronySeries(5.0, parallel_viscosity=5.0)).instantaneous_poisson_ratio == 0.25


def test_wave_speeds():
    material = Material(PronySeries(4.0, [12.0], [1.0]), 9.0 - 16.0 / 3.0, density=1.0)
    assert material.shear_wave_speed == material.slowest_wave_speed == 2.0
    assert material.pressure_wave_speed == pytest.approx(3.0)
    assert Material(PronySeries(0.0, [16.0], [1.0]), math.inf, density=4.0).shear_wave_speed == 2.0
    assert Material(1.0, math.inf, density=1.0).pressure_wave_speed == math.inf
    assert Material(1.0, 1.0).slowest_wave_speed is None


@pytest.mark.parametrize(
    ("arguments", "keywords", "error", "message"),
    [
        ((0.0, 1.0), {}, ValueError, "shear = 0 Pa"),
        ((-1.0, 1.0), {}, ValueError, "shear = -1 Pa"),
        ((1.0, -1.0), {}, ValueError, "bulk = -1 Pa"),
        ((1.0, math.nan), {}, ValueError, "bulk = nan Pa"),
        ((math.inf, 1.0), {}, ValueError, "shear = inf Pa"),
        (("steel", 1.0), {}, TypeError, "shear = 'steel'"),
        (([1.0, 2.0], 1.0), {}, TypeError, "a PronySeries"),
        ((1.0, 1.0), {"density": 0.0}, ValueError, "density = 0 kg/m3"),
    ],
)
def test_bad_input_is_named(arguments, keywords, error, message):
    with pytest.raises(error, match=message):
        Material(*arguments, **keywords)


def test_repr_names_what_was_given():
    assert repr(Material(1.0, math.inf, name="x")) == "Material(shear=PronySeries(1.0), bulk=inf, name='x')"


def test_equal_by_value():
    assert Material(1.0, 2.0) == Material(PronySeries(1.0), PronySeries(2.0))
    assert len({Material(1.0, 2.0), Material(1.0, 2.0), Material(1.0, 3.0)}) == 2
