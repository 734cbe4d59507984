"""Chebyshev series in boxes of two variables, of known functions."""

import numpy as np
import pytest

from restitution.surrogates.boxes import OF_BOXES, NotMet, box_value, build_boxes, fill, ready

LOW, HIGH = np.array([-1.0, 2.0]), np.array([3.0, 2.5])


def look_up(boxes, x, y):
    table = ready(boxes)
    return np.array([box_value(*point, table) for point in zip(x, y, strict=True)])


def points(n, seed=3):
    return np.random.default_rng(seed).uniform(LOW, HIGH, (n, 2)).T


def test_a_polynomial_needs_one_box():
    def function(x, y):
        return x**OF_BOXES.degree * (y - 2.2) ** OF_BOXES.degree - 3.0 * x * y

    boxes, error = build_boxes(function, LOW, HIGH, 1e-6)
    assert len(boxes.levels) == 1
    assert fill(boxes)
    assert error < 1e-9
    x, y = np.concatenate([points(100), np.transpose([LOW, HIGH])], axis=1)
    assert look_up(boxes, x, y) == pytest.approx(function(x, y), abs=1e-9)


def test_boxes_are_halved_where_the_function_is_rough():
    def function(x, y):
        return np.sin(x) + np.abs(y - 2.25) ** 3 + np.exp(-20.0 * (y - 2.0) * (x + 1.0))

    reports = []
    boxes, error = build_boxes(function, LOW, HIGH, 1e-6, lambda *report: reports.append(report))
    assert fill(boxes)
    assert reports[-1] == (len(boxes.levels),) * 2
    assert 2 < len(boxes.levels) < 60
    x, y = points(2000)
    off = np.abs(look_up(boxes, x, y) - function(x, y)).max()
    assert off < error <= 1e-6


def test_a_variable_that_is_smooth_is_not_halved():
    for axis in (0, 1):
        boxes, _ = build_boxes(lambda *both, n=axis: (both[n] - LOW[n]) ** 1.5 + both[1 - n], LOW, HIGH, 1e-5)
        assert boxes.levels[:, axis].max() > 2
        assert boxes.levels[:, 1 - axis].max() == 0


@pytest.mark.parametrize("function", [lambda x, _: np.sign(x - 0.123), lambda x, _: np.where(x > 0.5, np.nan, x)])
def test_a_jump_and_nan_are_not_met_at_their_place(function):
    with pytest.raises(NotMet) as caught:
        build_boxes(function, LOW, HIGH, 1e-3)
    assert not caught.value.error <= 1e-3
    assert LOW[1] <= caught.value.place[1] <= HIGH[1]
    width = (HIGH[0] - LOW[0]) * 0.5**OF_BOXES.deepest
    assert caught.value.place[0] > 0.5 or abs(caught.value.place[0] - 0.123) < width


def test_boxes_that_overlap_or_leave_gaps_do_not_fill():
    boxes, _ = build_boxes(lambda x, y: np.exp(-30.0 * (x + 1.0)) + y, LOW, HIGH, 1e-6)
    assert fill(boxes)
    count = len(boxes.levels)
    assert count > 2
    twice = boxes._replace(
        **{name: np.concatenate([getattr(boxes, name)] * 2) for name in ("levels", "places", "coefficients")}
    )
    part = boxes._replace(levels=boxes.levels[1:], places=boxes.places[1:], coefficients=boxes.coefficients[1:])
    changes = (
        twice,
        part,
        boxes._replace(places=boxes.places + 1),
        boxes._replace(levels=boxes.levels - 1),
        boxes._replace(levels=boxes.levels + OF_BOXES.deepest),
        boxes._replace(low=boxes.high),
        boxes._replace(coefficients=boxes.coefficients[:, 1:]),
        boxes._replace(levels=boxes.levels[:, :1]),
    )
    assert not any(fill(each) for each in changes)
