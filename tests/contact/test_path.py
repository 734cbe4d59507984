import math

import numpy as np
import pytest

from restitution import Cone, FlatEndedParabola, FlatPunch, Parabola, PowerLaw, Sphere, Tabulated, TruncatedCone
from restitution.contact.table import evaluate, joined, path_table, scaled
from restitution.kernel.compile import entry_point
from restitution.kernel.path import radius_and_integral, single_path, table_path

RADII = np.linspace(0.0, 0.5, 21)
SMOOTH = [
    (Parabola(0.01), 1e-4),
    (Cone(1.2), 1e-3),
    (FlatPunch(0.02), 1e-3),
    (Sphere(0.01), 1e-5),
    (Sphere(0.01), 0.005),
    (Sphere(0.01), 0.05),
    (TruncatedCone(0.001, 1.3), 1e-6),
    (TruncatedCone(0.001, 1.3), 0.01),
    (FlatEndedParabola(0.01, 0.001), 1e-8),
    (FlatEndedParabola(0.01, 0.001), 0.01),
    (Tabulated(RADII, Sphere(1.0).shape(RADII)), 0.2),
]


@pytest.mark.parametrize(("profile", "depth_max"), SMOOTH)
def test_table_against_the_profile(profile, depth_max):
    table = path_table(profile, depth_max)
    assert table.error < 1e-12
    assert len(table.radius) <= 128
    s = math.sqrt(depth_max) * np.linspace(0.0, 1.0, 1237)
    depth = np.minimum(s * s, depth_max)
    a, slope, force_integral = evaluate(table, s)
    exact, exact_integral = profile.contact_radius(depth), profile.force_integral_at_depth(depth)
    # `radius_error` and `error` come from other points and may be slightly exceeded here.
    np.testing.assert_allclose(a, exact, rtol=0, atol=(3 * table.radius_error + 1e-15) * exact[-1])
    np.testing.assert_allclose(
        force_integral, exact_integral, rtol=0, atol=(3 * table.error + 1e-15) * exact_integral[-1]
    )
    assert a[0] == pytest.approx(float(profile.contact_radius(0.0)), abs=1e-15 * exact[-1])
    assert force_integral[0] == 0.0
    # da/ds by differences of a from the table: 1e-6 relative, as a step rarely crosses the edge of a cell.
    middle = 0.5 * (s[1:] + s[:-1])
    difference = np.diff(a) / np.diff(s)
    np.testing.assert_allclose(evaluate(table, middle)[1], difference, atol=1e-4 * np.max(np.abs(slope)))


def test_one_table_and_several_are_of_one_type_for_the_compiler():
    """Another type would compile the kernel a second time."""
    typeof = pytest.importorskip("numba").typeof
    first, second = (path_table(Sphere(0.01), depth) for depth in (1e-3, 5e-3))
    assert typeof(table_path(first.several)) == typeof(table_path(joined([first.several, second.several])))


def test_known_polynomials():
    # a = sqrt(R) s, Pi = (2/3) sqrt(R) s^3 with R = 4, over s in [0, 3].
    table = path_table(Parabola(4.0), 9.0)
    a, slope, force_integral = evaluate(table, np.array([0.0, 0.1, 1.5, 3.0]))
    np.testing.assert_allclose(a, [0.0, 0.2, 3.0, 6.0], rtol=1e-14)
    np.testing.assert_allclose(slope, 2.0, rtol=1e-12)
    np.testing.assert_allclose(force_integral, [0.0, 4e-3 / 3, 4.5, 36.0], rtol=1e-13)


def test_the_force_integral_is_exactly_that_of_the_polynomials():
    # d Pi/d(s^2) = a holds to rounding within every cell, even where a itself has an error of 1e-7.
    table = path_table(PowerLaw(3.0, 1.0), 1.0)
    left, width = table.edges[:-1, None], np.diff(table.edges)[:, None]
    derivative = table.force_integral[:, 1:] * np.arange(1, table.force_integral.shape[1])
    product = np.zeros_like(derivative)
    product[:, :8] = left * table.radius
    product[:, 1:9] += width * table.radius
    np.testing.assert_allclose(derivative, 2.0 * width * product, rtol=1e-12, atol=1e-20)
    ends = np.sum(table.force_integral, axis=1)
    np.testing.assert_allclose(ends[:-1], table.force_integral[1:, 0], rtol=1e-14)


def test_a_branch_point_is_resolved_by_narrow_cells():
    profile = PowerLaw(4.0, 1.0)
    table = path_table(profile, 1.0)
    assert len(table.radius) < 64
    # The cells grow with the distance from the axis; the first is very narrow.
    assert table.edges[1] < 1e-4
    s = np.geomspace(1e-7, 1.0, 40001)
    difference = np.abs(evaluate(table, s)[0] - profile.contact_radius(s * s))
    missed = np.trapezoid(difference * 2.0 * s, s) / float(profile.force_integral_at_depth(1.0))
    assert missed < table.error * 1.2
    assert table.error < 1e-12
    assert 1e-6 < table.radius_error < 1e-3


def test_the_error_of_a_coarse_table_is_stated():
    profile = PowerLaw(4.0, 1.0)
    table = path_table(profile, 1.0, rtol=1e-4)
    s = np.geomspace(1e-7, 1.0, 40001)
    difference = np.abs(evaluate(table, s)[0] - profile.contact_radius(s * s))
    missed = np.trapezoid(difference * 2.0 * s, s) / float(profile.force_integral_at_depth(1.0))
    assert 1e-7 < table.error < 1e-4
    assert table.error == pytest.approx(missed, rel=0.2)


ROUGH = Tabulated([0.0, 0.1, 0.3, 0.4, 0.7, 1.0, 1.5, 2.0], [0.0, 0.008, 0.03, 0.1, 0.25, 0.5, 1.3, 2.4])


@pytest.mark.parametrize("shallow", [None, 1e-3])
def test_the_kinks_of_a_rough_tip_are_resolved(shallow):
    table = path_table(ROUGH, 2.0, depth_min=shallow)
    assert len(table.radius) < 400
    assert table.error_at(2.0) < 2e-12
    if shallow:
        assert table.error_at(shallow) < 2e-12
    depth = np.linspace(0.0, 2.0, 3001)[1:]
    force_integral = evaluate(table, np.sqrt(depth))[2]
    np.testing.assert_allclose(force_integral, ROUGH.force_integral_at_depth(depth), rtol=0, atol=1e-10)


@entry_point
def _looked_up(path, places, rows):
    for n in range(places.shape[0]):
        rows[0, n], rows[1, n] = radius_and_integral(path, places[n])


def test_the_kernel_finds_the_cell():
    table = path_table(ROUGH, 2.0)
    path = table_path(table)
    inside = 0.5 * (table.edges[1:] + table.edges[:-1])
    s = np.concatenate([table.edges, inside, np.linspace(0.0, table.edges[-1], 500), [1.01 * table.edges[-1]]])
    result = np.empty((2, s.size))
    _looked_up(path, s, result)
    a, _, integral = evaluate(table, s)
    np.testing.assert_allclose(result, [a, integral], rtol=1e-12)


def test_several_tables_in_one():
    # The kernel finds every table where one has fewer cells and kinks than another.
    alone = [
        scaled(path_table(ROUGH, depth, rtol), depth, 1.0) for depth, rtol in ((2.0, 1e-6), (0.05, 1e-9), (0.8, 1e-11))
    ]
    together = joined([table.several for table in alone])
    assert len({table.edges.size for table in alone}) == len({table.kinks.size for table in alone}) == 3
    paths = table_path(together)
    rng = np.random.default_rng(7)
    for n, table in enumerate(alone):
        for item, other in zip(together.single(n), table, strict=True):
            assert np.array_equal(item, other)
        s = np.concatenate([table.edges, rng.uniform(0.0, 1.0, 300)])
        result = np.empty((2, s.size))
        _looked_up(single_path(paths, n), s, result)
        np.testing.assert_allclose(result, evaluate(table, s)[::2], rtol=1e-12)


def test_coarser_on_request():
    profile = Sphere(1.0)
    coarse, fine = path_table(profile, 20.0, rtol=1e-4), path_table(profile, 20.0)
    assert len(coarse.radius) < len(fine.radius)
    assert coarse.error < 1e-4


def test_scaled_table():
    table = path_table(Sphere(0.01), 0.002)
    other = scaled(table, length=0.002, radius=0.01)
    assert other.edges[-1] == pytest.approx(1.0)
    assert other.error == table.error
    a, slope, force_integral = evaluate(other, np.array([0.3, 0.9]))
    direct = evaluate(table, np.array([0.3, 0.9]) * math.sqrt(0.002))
    np.testing.assert_allclose(a, direct[0] / 0.01, rtol=1e-14)
    np.testing.assert_allclose(slope, direct[1] / 0.01 * math.sqrt(0.002), rtol=1e-13)
    np.testing.assert_allclose(force_integral, direct[2] / (0.01 * 0.002), rtol=1e-14)


def test_arrays_for_the_kernel():
    table = path_table(Sphere(1.0), 0.3)
    for array in (table.radius, table.force_integral):
        assert array.dtype == np.float64
        assert array.flags.c_contiguous
    assert table.force_integral.shape[1] == table.radius.shape[1] + 4


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: path_table(Sphere(1.0), 0.0), "depth_max = 0 m"),
        (lambda: path_table(Sphere(1.0), math.inf), "depth_max = inf m"),
        (lambda: path_table(Tabulated([0, 1], [0, 1]), 3.0), "depth_max = 3 m: must be <= 1.5708 m"),
        (lambda: path_table(Sphere([1.0, 2.0]), 0.1), "single numbers"),
        (lambda: path_table(TruncatedCone([1.0, 2.0], 1.0), 0.1), "single numbers"),
    ],
)
def test_bad_requests(call, message):
    with pytest.raises(ValueError, match=message):
        call()
