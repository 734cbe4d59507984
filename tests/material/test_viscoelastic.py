import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from refusals import named
from restitution import Material, PronySeries, library
from restitution.errors import InputError
from restitution.material.conversion import bulk_from_poisson_ratio, poisson_ratio, tension_from_shear
from restitution.material.viscoelastic import poisson_ratio_range
from strategies import materials

pytestmark = pytest.mark.plain


def test_numbers_as_elastic_moduli():
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


def test_poisson_ratio_close_to_one_half():
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


def test_poisson_ratio_over_time_for_a_constant_bulk():
    """nu(t) = 1/2 - E(t)/(6K): the transforms obey nu = 1/2 - E/(6K)."""
    shear = PronySeries(3.0, [7.0, 2.0], [1.0, 1e-3])
    t = np.array([0.0, 1e-4, 0.1, 1.0, 1e3])
    tension = tension_from_shear(shear, bulk_modulus=5.0)
    result = Material(shear, 5.0).relaxation_poisson_ratio(t)
    assert result == pytest.approx(0.5 - tension.relaxation_modulus(t) / 30.0, rel=1e-13)
    assert Material(shear, math.inf).relaxation_poisson_ratio(t).tolist() == [0.5] * 5


@given(materials(liquid=None, viscosity=None), st.floats(-3.0, 3.0))
def test_poisson_ratio_over_time_by_its_laplace_transform(material, exponent):
    """The transform of nu(t) at s is (3K - 2G)/(6K + 2G)/s; it lies between the ends where it is monotonic."""
    if material.is_incompressible:
        return
    s = 10.0**exponent / float(material.shear.relaxation_times.max(initial=1.0))
    g, k = (float(series.carson_transform(s)) for series in (material.shear, material.bulk))
    x, w = np.polynomial.legendre.leggauss(40)
    edges = np.linspace(-60.0, math.log(50.0), 41)
    u = (edges[:-1, None] + edges[1:, None]) / 2 + (edges[1:, None] - edges[:-1, None]) / 2 * x
    weights = (edges[1:, None] - edges[:-1, None]) / 2 * w
    nu = material.relaxation_poisson_ratio(np.exp(u) / s)
    result = float((weights * np.exp(u - np.exp(u)) * nu).sum())
    assert result == pytest.approx((3 * k - 2 * g) / (6 * k + 2 * g), abs=1e-7)


def test_limits_of_the_poisson_ratio_over_time():
    for shear, bulk in (
        (PronySeries(3.0, [7.0], [1.0]), PronySeries(5.0, [4.0], [1.0])),
        (PronySeries(0.0, [7.0], [1.0]), PronySeries(0.0, [5.0], [2.0])),
        (PronySeries(3.0, [7.0], [1.0], parallel_viscosity=0.1), PronySeries(5.0, parallel_viscosity=0.3)),
    ):
        material = Material(shear, bulk)
        ends = material.relaxation_poisson_ratio([0.0, 1e-13, 1e4])
        assert ends[0] == material.instantaneous_poisson_ratio
        assert ends[1:] == pytest.approx([material.instantaneous_poisson_ratio, material.poisson_ratio], abs=1e-10)


def test_wave_speed_at_the_contact_time():
    material = Material(PronySeries(4.0, [12.0], [1.0]), 2.0, density=1.0)
    assert material.wave_speed([0.0, 1e3]).tolist() == [4.0, 2.0]
    # Polyisobutylene in a contact of 1.9 ms: 22 m/s and not the 1100 m/s of the glass.
    liquid = library.get("polyisobutylene").at(293.0)
    assert replace(liquid, density=920.0).wave_speed(1.9e-3) == pytest.approx(22.0, rel=0.02)
    assert Material(1.0, 1.0).wave_speed(1.0) is None


@pytest.mark.parametrize(
    ("shear", "bulk", "density", "expected"),
    [
        (0.0, 1.0, 1.0, ("shear", 0.0)),
        (-1.0, 1.0, 1.0, ("shear", -1.0)),
        (1.0, -1.0, 1.0, ("bulk", -1.0)),
        (1.0, math.nan, 1.0, ("bulk", math.nan)),
        (math.inf, 1.0, 1.0, ("shear", math.inf)),
        ("steel", 1.0, 1.0, ("shear", "steel")),
        ([1.0, 2.0], [1.0, 2.0, 3.0], 1.0, ("shear, bulk, density, temperature",)),
        (1.0, 1.0, 0.0, ("density", 0.0)),
    ],
)
def test_bad_input_is_refused(shear, bulk, density, expected):
    kind = TypeError if isinstance(shear, str) else InputError
    assert named(lambda: Material(shear, bulk, density=density), kind) == expected


def test_repr_shows_the_given_arguments():
    assert repr(Material(1.0, math.inf, name="x")) == "Material(shear=PronySeries(1.0), bulk=inf, name='x')"


def test_equal_by_value():
    assert Material(1.0, 2.0) == Material(PronySeries(1.0), PronySeries(2.0))
    assert len({Material(1.0, 2.0), Material(1.0, 2.0), Material(1.0, 3.0)}) == 2


@given(materials(liquid=None, viscosity=None), st.lists(st.floats(-14.0, 14.0), min_size=1, max_size=5))
def test_the_range_of_the_poisson_ratio_holds_it_at_all_times(material, decades):
    low, high = poisson_ratio_range(material)
    assert -1.0 - 1e-12 <= low <= high <= 0.5
    s = 10.0 ** np.array(decades)
    bulk = material.bulk.carson_transform(s) if isinstance(material.bulk, PronySeries) else np.inf
    ratios = poisson_ratio(material.shear.carson_transform(s), bulk)
    # Eight points a decade, over which the ratio of two moduli that relax changes by some per cent of its range.
    assert np.all(ratios >= low - 0.02)
    assert np.all(ratios <= high + 0.02)


def test_the_range_of_the_poisson_ratio_of_several_materials_is_that_of_each():
    bulk = PronySeries(3.0, [27.0], [1.0])
    late, early = PronySeries(1.0, [9.0], [1e6]), PronySeries(1.0, [9.0], [1e-6])
    each = [Material(late, bulk), Material(early, bulk), Material(late, math.inf), Material(early, 3.0)]
    low, high = poisson_ratio_range(Material.stacked(each))
    for place, one in enumerate(each):
        # The points at which the ratio is sought are those of all rows.
        assert (low[place], high[place]) == pytest.approx(poisson_ratio_range(one), abs=5e-3)
    # Between 1 s and 1e6 s K = 3 and G = 10; between 1e-6 s and 1 s K = 30 and G = 1.
    assert low[0] == pytest.approx((9.0 - 20.0) / (18.0 + 20.0), abs=5e-3)
    assert high[1] == pytest.approx((90.0 - 2.0) / (180.0 + 2.0), abs=5e-3)
