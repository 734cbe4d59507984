"""Piecewise Chebyshev interpolants of known functions."""

import math

import numpy as np
import pytest

from restitution.surrogates.boxes import OF_PIECES, NotMet, build_pieces
from restitution.surrogates.velocity import lookup_table, scalar_function, value, values


def difference(approximate, exact):
    return np.abs(approximate - exact)


def look_up(pieces, function, x):
    """Value at x from a table of the logarithm of the function over the logarithm of its argument."""
    low, high = np.exp(pieces.edges[[0, -1]])
    return math.log(value(math.exp(x), lookup_table(pieces, function, low, high, math.inf)))


@pytest.mark.plain
def test_polynomial_of_the_degree_is_one_piece_and_exact():
    # 1 + x^12 on [-2, 3]
    pieces, error = build_pieces(lambda x: (1.0 + x**OF_PIECES.degree)[None], difference, -2.0, 3.0, 1e-6)
    assert pieces.edges.tolist() == [-2.0, 3.0]
    assert error[0] < 1e-8
    small, _ = build_pieces(lambda x: (1e-3 * x**OF_PIECES.degree)[None], difference, -1.0, 1.0, 1e-6)
    for x in (-0.99, 0.0, 0.3, 1.0):
        assert look_up(small, 0, x) == pytest.approx(1e-3 * x**OF_PIECES.degree, abs=1e-15)


@pytest.mark.plain
def test_pieces_are_halved_where_the_function_is_rough():
    def sample(x):
        return np.stack([np.sin(3.0 * x), np.arctan(200.0 * (x - 0.3))])

    reports = []
    pieces, error = build_pieces(sample, difference, -1.0, 1.0, 1e-7, lambda *report: reports.append(report))
    assert np.all(error <= 1e-7)
    assert reports[-1] == (pieces.edges.size - 1, pieces.edges.size - 1)
    widths = np.diff(pieces.edges)
    finest = pieces.edges[np.argmin(widths)]
    assert abs(finest - 0.3) < 0.05
    assert widths.max() > 30.0 * widths.min()
    points = np.random.default_rng(5).uniform(-1.0, 1.0, 300)
    for function in (0, 1):
        looked_up = [look_up(pieces, function, x) for x in points]
        assert np.abs(looked_up - sample(points)[function]).max() < 1e-7


@pytest.mark.plain
def test_pieces_are_continuous():
    pieces, _ = build_pieces(lambda x: np.arctan(50.0 * x)[None], difference, -1.0, 1.0, 1e-4)
    assert pieces.edges.size > 4
    signs = (-1.0) ** np.arange(OF_PIECES.degree + 1)
    left, right = pieces.coefficients[0] @ signs, pieces.coefficients[0].sum(axis=1)
    assert left[1:] == pytest.approx(right[:-1], abs=1e-14)


@pytest.mark.plain
def test_an_unattainable_error_is_reported_with_place_and_size():
    with pytest.raises(NotMet) as caught:
        build_pieces(lambda x: np.stack([x, np.sign(x - 0.123)]), difference, -1.0, 1.0, 1e-6)
    assert caught.value.function == 1
    assert caught.value.place == pytest.approx([0.123], abs=1e-3)
    assert caught.value.error > 0.1
    asked = []

    def noise(x):
        asked.append(x.size)
        return np.random.default_rng(0).normal(size=(1, x.size))

    with pytest.raises(NotMet):
        build_pieces(noise, difference, 0.0, 1.0, 1e-6)
    # A function that is rough everywhere is given up soon.
    assert sum(asked) < 100_000
    with pytest.raises(NotMet) as caught:
        build_pieces(lambda x: np.where(x > 0.5, np.nan, x)[None], difference, -1.0, 1.0, 1e-6)
    assert caught.value.error == np.inf


@pytest.mark.plain
def test_values_out_of_range_are_nan():
    pieces, _ = build_pieces(lambda x: x[None], difference, 0.0, 1.0, 1e-6)
    table = lookup_table(pieces, 0, 1.0, math.e, math.inf)
    assert value(2.0, table) == pytest.approx(2.0)
    assert value(1.0, table) == pytest.approx(1.0)
    assert value(math.e, table) == pytest.approx(math.e)
    for v in (0.999, 2.72, -1.0, math.nan, math.inf):
        assert math.isnan(value(v, table))
    out = np.empty(3)
    values(np.array([0.5, 1.5, 9.0]), out, table)
    assert np.isnan(out).tolist() == [True, False, True]
    assert scalar_function(table)(1.5) == out[1]


@pytest.mark.plain
def test_values_do_not_exceed_their_upper_limit():
    pieces, _ = build_pieces(lambda x: (1e-3 + 0.0 * x)[None], difference, 0.0, 1.0, 1e-6)
    assert value(2.0, lookup_table(pieces, 0, 1.0, math.e, 1.0)) == 1.0
