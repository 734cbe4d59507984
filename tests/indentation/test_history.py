"""Histories: straight lines through points, fitted functions, and refused input."""

import math

import numpy as np
import pytest

from restitution.errors import ABSENT, InputError
from restitution.indentation.history import History, cycles, from_zeros, hold, ramp, sine_arch, triangle

pytestmark = pytest.mark.plain


def test_points_are_joined_by_straight_lines():
    time, depth = [0.0, 0.5, 2.0, 3.0], [0.0, 2e-6, 1e-6, 0.0]
    history = History.from_points(time, depth)
    t = np.linspace(0.0, 3.0, 301)
    assert history(t) == pytest.approx(np.interp(t, time, depth), abs=1e-21)
    assert history.rate([0.25, 0.5, 1.0, 2.5]) == pytest.approx([4e-6, -2e-6 / 3, -2e-6 / 3, -1e-6], rel=1e-14)
    assert (history.start, history.stop) == (0.0, 3.0)


def test_points_on_a_line_are_one_piece():
    # A triangle sampled a thousand times has two pieces; a parabola sampled as often keeps all.
    t = np.linspace(0.0, 2.0, 1001)
    assert History.from_points(t, 1e-6 * (1.0 - np.abs(t - 1.0))).knots == pytest.approx([0.0, 1.0, 2.0])
    assert History.from_points(t, 1e-6 * t * (2.0 - t)).knots.size == 1001


def test_two_points_at_one_time_are_a_step():
    history = History.from_points([0.0, 1.0, 1.0, 2.0], [0.0, 0.0, 3.0, 3.0])
    assert history([0.5, 1.0, 1.5]) == pytest.approx([0.0, 3.0, 3.0])


@pytest.mark.parametrize(
    "function",
    [
        lambda t: 1e-6 * np.sin(math.pi * t / 3.0),
        lambda t: 1e-6 * math.sin(math.pi * t / 3.0),
        lambda t: 1e-9 * (1.0 - np.exp(-t / 0.05)),
        lambda t: 2e-6 * (1.0 - abs(t - 1.2) / 1.8),
    ],
    ids=["sine", "of one number", "fast", "kink"],
)
@pytest.mark.parametrize("time", [[0.0, 3.0], np.linspace(0.0, 3.0, 61), np.linspace(0.0, 3.0, 6001)])
def test_functions_are_followed_to_rounding(function, time):
    history = History.from_function(function, time)
    t = np.random.default_rng(1).uniform(0.0, 3.0, 1000)
    expected = np.array([function(x) for x in t])
    assert history(t) == pytest.approx(expected, abs=2e-12 * np.abs(expected).max())
    # The number of pieces does not depend on the number of output times.
    assert history.knots.size < 100


def test_constructors_of_histories():
    t = np.linspace(0.0, 2.0, 9)
    assert ramp(4.0, 2.0)(t) == pytest.approx(2.0 * t)
    assert hold(4.0, 2.0)(t) == pytest.approx(4.0)
    assert hold(4.0, 1.0, rise_time=1.0)(t) == pytest.approx(np.minimum(4.0 * t, 4.0))
    assert triangle(4.0, 1.0)(t) == pytest.approx(4.0 - 4.0 * np.abs(t - 1.0))
    assert triangle(4.0, 0.5, unloading_time=1.0, hold_time=0.5)(t) == pytest.approx(
        np.interp(t, [0.0, 0.5, 1.0, 2.0], [0.0, 4.0, 4.0, 0.0])
    )
    partial = cycles(4.0, 0.4, 3, unloading_time=0.2, valley=0.25)
    points = [0.0, 0.4, 0.6, 1.0, 1.2, 1.6, 1.8], [0.0, 4.0, 1.0, 4.0, 1.0, 4.0, 0.0]
    assert partial(t[:8]) == pytest.approx(np.interp(t[:8], *points))
    assert cycles(4.0, 1.0, 1).stop == 2.0
    assert sine_arch(4.0, 2.0)(t) == pytest.approx(4.0 * np.sin(0.5 * math.pi * t), abs=1e-11)


def test_knots_at_changes_of_sign_and_at_turning_points():
    cut = History.from_function(lambda t: np.sin(t) - 0.5, [0.0, 3.0]).cut()
    for place in (math.pi / 6, math.pi / 2, 5 * math.pi / 6):
        assert np.abs(cut.knots - place).min() < 1e-9
    t = np.linspace(0.0, 3.0, 100)
    assert cut(t) == pytest.approx(np.sin(t) - 0.5, abs=1e-11)


@pytest.mark.parametrize(
    ("make", "field", "value"),
    [
        (lambda: History.from_points([0.0, 1.0], [0.0]), "time, values", ABSENT),
        (lambda: History.from_points([0.0, 2.0, 1.0], [0.0, 1.0, 0.0]), "time", 1.0),
        (lambda: History.from_points([0.0, np.nan], [0.0, 1.0]), "time", math.nan),
        (lambda: History.from_points([0.0, 1.0], [0.0, np.inf], name="depth"), "depth", math.inf),
        (lambda: History.from_points([0, 1, 1, 1, 2], [0, 0, 1, 2, 0]), "time", 1.0),
        (lambda: History.from_points([0, 1, 1], [0, 1, 2], name="depth"), "time", 1.0),
        (lambda: History.from_function(np.sin, [1.0]), "time", ABSENT),
        (lambda: History.from_function(lambda t: (t > 0.3).astype(float), [0.0, 1.0], name="force"), "force", ABSENT),
        (lambda: History.from_function(lambda t: np.sin(1e5 * t), [0.0, 1.0], name="force"), "force", ABSENT),
        (lambda: History([0.0, 1.0], [[0.0, np.nan]]), "coefficients", math.nan),
        (lambda: History([0.0, 1.0], [0.0, 1.0]), "knots, coefficients", ABSENT),
        (lambda: History([1.0, 0.0], [[0.0, 1.0]]), "knots, coefficients", ABSENT),
        (lambda: History([0.0, 1.0, 2.0], [[0.0, 1.0]]), "knots, coefficients", ABSENT),
        (lambda: ramp(-1.0, 1.0), "value", -1.0),
        (lambda: triangle(1.0, 0.0), "loading_time", 0.0),
        (lambda: cycles(1.0, 1.0, 2, valley=1.5), "valley", 1.5),
        (lambda: cycles(1.0, 1.0, 0), "count", 0),
        (lambda: hold(1.0, 1.0, rise_time=-1.0), "rise_time", -1.0),
        (lambda: ramp(1.0, 1.0)(2.0), "time", 2.0),
    ],
)  # fmt: skip
def test_invalid_histories_are_refused(make, field, value):
    with pytest.raises(InputError) as caught:
        make()
    assert caught.value.field == field
    assert caught.value.value is value or caught.value.value == pytest.approx(value, nan_ok=True)
    assert "\n" not in str(caught.value)


def values_from_zeros(history, coefficients, backward, times):
    """Values by the coefficients over the shares that they count from."""
    piece = np.clip(np.searchsorted(history.knots, times, side="right") - 1, 0, len(coefficients) - 1)
    u = (times - history.knots[piece]) / (history.knots[piece + 1] - history.knots[piece])
    u = np.where(backward[piece], 1.0 - u, u)
    return np.sum(coefficients[piece] * u[:, None] ** np.arange(coefficients.shape[1]), axis=1)


def test_a_force_is_a_power_of_the_time_where_it_vanishes():
    """A squared sine over two periods begins, touches zero, and ends like a square."""
    bell = History.from_function(lambda t: 3.0 * np.sin(math.pi * t) ** 2, [0.0, 2.0])
    parted, coefficients, backward = from_zeros(bell)
    ends = parted.knots[1:]
    assert list(ends[backward]) == pytest.approx([1.0, 2.0], abs=1e-15)
    starts = parted.knots[:-1][np.isin(parted.knots[:-1], [0.0, *ends[backward]])]
    forward = np.isin(parted.knots[:-1], starts)
    # 3 sin^2(pi x) = 3 pi^2 x^2 + ...
    for n in np.flatnonzero(backward | forward):
        width = parted.knots[n + 1] - parted.knots[n]
        assert list(coefficients[n, :2]) == [0.0, 0.0]
        assert coefficients[n, 2] == pytest.approx(3.0 * (math.pi * width) ** 2, rel=1e-10)
    times = np.linspace(0.0, 2.0, 401)
    assert values_from_zeros(parted, coefficients, backward, times) == pytest.approx(bell(times), abs=1e-11)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_rounding_of_a_force_is_no_force(sign):
    """A zero within a piece, a hold at it, and a piece between two zeros."""
    tiny = sign * 1e-14
    rows = [[0.25, -1.0, 1.0], [0.25 + tiny, -0.25, 0.0], [tiny, 0.0, 0.0], [tiny, 4.0, -4.0]]
    history = History([0.0, 1.0, 2.0, 3.0, 4.0], rows)
    parted, coefficients, backward = from_zeros(history)
    assert list(parted.knots) == pytest.approx([0.0, 0.5, 1.0, 2.0, 3.0, 3.5, 4.0], abs=1e-7)
    assert list(backward) == [True, False, True, False, False, True]
    assert not np.any(coefficients[3])
    assert not np.any(coefficients[backward, 0])
    assert list(coefficients[1, :2]) == [0.0, 0.0]
    assert coefficients[4, 0] == 0.0
    times = np.linspace(0.0, 4.0, 201)
    assert values_from_zeros(parted, coefficients, backward, times) == pytest.approx(history(times), abs=2e-12)


def test_a_force_without_zeros_stays_as_it_is():
    history = History.from_points([0.0, 1.0, 2.0], [1.0, 2.0, 0.5])
    parted, coefficients, backward = from_zeros(history)
    assert parted is history
    assert np.array_equal(coefficients, history.coefficients)
    assert not backward.any()


@pytest.mark.parametrize("cycles", [64, 512])
def test_a_function_of_many_cycles_needs_few_pieces(cycles):
    """Times far from zero have few digits left: the values differ by their rounding, which no finer piece removes."""

    def wave(t):
        return 1.0 + 0.9 * np.sin(2.0 * np.pi * t)

    offset = 100.0
    history = History.from_function(wave, offset + np.arange(4 * cycles + 1) / 4.0)
    assert history.knots.size < 20 * cycles
    times = offset + cycles * np.random.default_rng(cycles).uniform(0.0, 1.0, 1000)
    # The slope 2 pi 0.9 times the spacing of the times, 6e-14 or 1e-13, and the error of a fit.
    assert history(times) == pytest.approx(wave(times), abs=1e-12)
