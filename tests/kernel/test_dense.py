import numba
import numpy as np
import pytest

from restitution.kernel import lanes
from restitution.kernel.collocation import (
    combine,
    interpolate_lanes,
    invert_modes,
    lagrange,
    lagrange_lanes,
    matvec,
    radau,
)
from restitution.kernel.compile import entry_point
from restitution.kernel.lanes import read8, write8
from restitution.kernel.path import power_path, radii_and_integrals, radius_and_integral, radius_slope
from restitution.kernel.workspace import LENGTH, START, aligned, allocate


def _plain(function):
    """Python function behind a compiled one."""
    return getattr(function, "py_func", function)


@entry_point
def _inverses(matrices, count):
    invert_modes(matrices, count)


@entry_point
def _product(columns, x, result):
    write8(result, 0, matvec(columns, read8(x, 0)))


@entry_point
def _interpolated(nodes, weights, points, x, basis, values, result):
    lagrange_lanes(nodes, weights, points, read8(x, 0), basis)
    write8(result, 0, combine(basis, points, values))


@entry_point
def _stored(scheme, work, sigma, rows):
    interpolate_lanes(scheme, work, work.approach, read8(sigma, 0), 1, rows)


@entry_point
def _functions(x, y, results, numbers):
    a, b = read8(x, 0), read8(y, 0)
    write8(results, 0, 0, lanes.exp(a))
    write8(results, 1, 0, lanes.log(b))
    write8(results, 2, 0, lanes.absolute(a))
    write8(results, 3, 0, lanes.at_least(a, -1.0))
    write8(results, 4, 0, lanes.where_positive(a, b))
    write8(results, 5, 0, lanes.from_lane(3, a, b))
    write8(results, 6, 0, (1.0 - a) * 2.0 / (b + 3) - b)
    write8(results, 7, 0, lanes.root(b))
    numbers[0] = lanes.total(a)
    numbers[1] = lanes.largest(a)
    numbers[2] = lanes.smallest(a)
    numbers[3] = a[5]


@entry_point
def _path(path, s, scratch, radii, integrals):
    a, integral = radii_and_integrals(path, read8(s, 0), scratch)
    write8(radii, 0, a)
    write8(integrals, 0, integral)


def _mode_matrix(z):
    return np.eye(8) + z * radau(8).A * np.linspace(0.2, 1.0, 8)


@pytest.mark.plain
@pytest.mark.parametrize("z", [1e-12, 0.3, 7.0, 1e9])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_inverses_of_mode_matrices(z, count):
    matrices = aligned(4, 8, 8)
    for k in range(4):
        matrices[k] = _mode_matrix(z * (k + 1)).T
    originals = matrices.copy()
    _inverses(matrices, count)
    for k in range(count):
        assert matrices[k] @ originals[k] == pytest.approx(np.eye(8), abs=1e-9)
    assert np.array_equal(matrices[count:], originals[count:])


@pytest.mark.plain
def test_product_with_columns():
    matrix, x, result = _mode_matrix(0.7), np.linspace(-1.0, 2.0, 8), np.zeros(8)
    _product(np.ascontiguousarray(matrix.T), x, result)
    assert result == pytest.approx(matrix @ x, rel=1e-14)


@pytest.mark.plain
def test_functions_of_lanes():
    x = np.array([-700.0, -30.5, -1.0, -1e-9, 0.0, 1e-3, 0.4, 3.7])
    y = np.array([1e-300, 2e-9, 0.5, 0.7071, 1.0, 1.4143, 3.0, 1e200])
    results, numbers = np.zeros((8, 8)), np.zeros(4)
    _functions(x, y, results, numbers)
    # NumPy's functions are accurate to one or two ulp.
    assert results[0] == pytest.approx(np.exp(x), rel=4e-16)
    assert results[1] == pytest.approx(np.log(y), rel=4e-16, abs=1e-16)
    assert np.array_equal(results[2], np.abs(x))
    assert np.array_equal(results[3], np.maximum(x, -1.0))
    assert np.array_equal(results[4], np.where(x > 0.0, y, 0.0))
    assert np.array_equal(results[5], np.concatenate([y[:3], x[3:]]))
    assert results[6] == pytest.approx((1.0 - x) * 2.0 / (y + 3) - y, rel=1e-14, abs=1e-14)
    assert np.array_equal(results[7], np.sqrt(y))
    assert numbers == pytest.approx([x.sum(), 3.7, -700.0, 1e-3], rel=1e-15)


@pytest.mark.plain
@pytest.mark.parametrize("lane", range(8))
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_reductions_are_nan_if_one_lane_is_not_finite(lane, bad):
    x = np.linspace(1.0, 2.0, 8)
    x[lane] = bad
    numbers = np.zeros(4)
    with np.errstate(invalid="ignore"):
        _functions(x, np.ones(8), np.zeros((8, 8)), numbers)
    assert np.isnan(numbers[1])
    assert np.isnan(numbers[2])


@pytest.mark.plain
def test_lagrange_basis_reproduces_polynomials_and_its_nodes():
    scheme, basis = radau(8), np.zeros(9)
    for x in (0.123, 1.7, -0.4):
        _plain(lagrange)(scheme.c, scheme.weights, 9, x, basis)
        assert basis @ scheme.c**8 == pytest.approx(x**8, rel=1e-11)
    _plain(lagrange)(scheme.c, scheme.weights, 9, float(scheme.c[2]), basis)
    assert basis == pytest.approx(np.eye(9)[2], abs=1e-14)


@pytest.mark.plain
@pytest.mark.parametrize("points", [8, 9])
def test_interpolation_at_eight_points(points):
    scheme, x, result = radau(8), np.linspace(-0.2, 1.6, 8), np.zeros(8)
    nodes = scheme.c[9 - points :]
    weights = scheme.weights if points == 9 else scheme.extrapolation
    _interpolated(nodes, weights, points, x, np.zeros((9, 8)), nodes ** (points - 1), result)
    assert result == pytest.approx(x ** (points - 1), rel=1e-10, abs=1e-12)


@pytest.mark.plain
@pytest.mark.parametrize("short", [0.2, 1e-40, 1e-200])
def test_stored_elements_may_differ_in_length_by_many_decades(short):
    """The first element of a blunt tip may be this short; warnings are errors in plain Python too."""
    scheme, work = radau(8), allocate(0, 2)
    work.places[START, :2], work.places[LENGTH, :2] = [0.0, short], [short, 1.0 - short]
    polynomials = np.random.default_rng().uniform(-1.0, 1.0, (2, 4, 9))
    for n in range(2):
        work.approach[n] = np.polynomial.polynomial.polyval(scheme.c, polynomials[n].T)
    places = np.array([0.99, 0.7, 0.31, 0.25])
    sigma, rows = np.concatenate([places, np.array([0.9, 0.6, 0.1, 0.0]) * short]), np.zeros((4, 8))
    _stored(scheme, work, sigma, rows)
    upper = np.polynomial.polynomial.polyval((places - short) / (1.0 - short), polynomials[1].T)
    lower = np.polynomial.polynomial.polyval(sigma[4:] / short, polynomials[0].T)
    assert rows == pytest.approx(np.concatenate([upper, lower], axis=1), rel=1e-11, abs=1e-12)


@pytest.mark.plain
@pytest.mark.parametrize("exponent", [0.0, 0.5, 1.0, 2.0])
def test_power_path(exponent):
    # Pi = int_0^s a 2 s ds = 2 s^(p + 2)/(p + 2)
    path, s = power_path(exponent), 0.7
    a, integral = _plain(radius_and_integral)(path, s)
    assert a == pytest.approx(s**exponent, rel=1e-15)
    assert integral == pytest.approx(2.0 * s ** (exponent + 2.0) / (exponent + 2.0), rel=1e-14)
    assert _plain(radius_slope)(path, s, a) == pytest.approx(exponent * s ** (exponent - 1.0), rel=1e-14)
    many = np.array([0.0, 1e-9, 0.01, 0.3, 0.7, 1.0, 2.0, 40.0])
    radii, integrals = np.zeros(8), np.zeros(8)
    _path(path, many, np.zeros((2, 8)), radii, integrals)
    assert radii == pytest.approx(many**exponent, rel=1e-14)
    assert integrals == pytest.approx(2.0 * many ** (exponent + 2.0) / (exponent + 2.0), rel=2e-14)


def test_rows_with_gaps_are_refused():
    # The kernel addresses a row by its offset from the start of a contiguous array.
    with pytest.raises(numba.TypingError):
        _product(np.zeros((8, 8)), np.zeros(16)[::2], np.zeros(8))
