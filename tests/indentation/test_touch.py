"""Histories that begin before touch, against the same histories from touch on, at random contact points."""

import math

import numpy as np
import pytest

from restitution import History, Material, Parabola, PronySeries, indent

TIP = Parabola(2.5e-6)
MATERIALS = {
    "elastic": Material(PronySeries(1.0), math.inf),
    "standard solid": Material(PronySeries(200.0 / 3.0, [800.0 / 3.0], [0.3]), math.inf),
}
# Contact points of a straight approach of 1.4 um at which rounding of the cut once gave wrong forces.
MISSED = [4.74815072755433e-07, 4.7384074107310223e-07]


def assert_same(material, whole, touch, from_touch, *, atol=1e-9):
    """Compare the forces of a history that begins before touch with those of the same history from touch on."""
    name, values, time = whole
    _, values_touch, time_touch = from_touch
    # The first and last times of the two differ by rounding.
    inside = np.linspace(1e-9, 1.0 - 1e-9, 30) * (time_touch[-1] - time_touch[0]) + time_touch[0]
    make = History.from_function if callable(values) else lambda values, time: History.from_points(time, values)
    expected = indent(material, TIP, **{name: make(values_touch, time_touch)}, time=inside)
    sampled = indent(material, TIP, **{name: make(values, time)}, time=inside + touch)
    for quantity in ("force", "contact_radius"):
        size = getattr(expected, "max_" + quantity)
        there, here = getattr(expected, quantity), getattr(sampled, quantity)
        # The radius is a root of the depth, which amplifies the rounding of the times.
        allowed = atol if quantity == "force" else math.sqrt(1e-14) + atol
        assert np.abs(here - there).max() <= allowed * size
    assert sampled.contact_end_time == pytest.approx(touch + expected.contact_end_time, rel=1e-11)


@pytest.mark.parametrize("material", MATERIALS.values(), ids=MATERIALS)
def test_a_straight_approach(material):
    rng = np.random.default_rng(11)
    for contact_point in [*MISSED, *rng.uniform(0.0, 1.35e-6, 150)]:
        values = np.array([0.0, 1.4e-6, 0.0]) - contact_point
        touch = contact_point / 1e-6
        assert_same(
            material,
            ("depth", values, np.array([0.0, 1.4, 2.8])),
            touch,
            ("depth", [0.0, *values[1:]], np.array([0.0, 1.4 - touch, 2.8 - touch])),
        )


@pytest.mark.parametrize("material", MATERIALS.values(), ids=MATERIALS)
def test_an_approach_in_several_pieces(material):
    """Pieces of random slope and length; the height before touch spans ten decades."""
    rng = np.random.default_rng(12)
    for _ in range(250):
        n = rng.integers(1, 5)
        rise = np.cumsum(rng.uniform(0.1, 1.0, n + 1) * 10.0 ** rng.uniform(-6.0, 0.0))
        up = np.cumsum(rng.uniform(0.2, 1.0, n + 1))
        height = 10.0 ** rng.uniform(-8.0, 2.0) * rise[-1]
        where = rng.uniform(0.0, 0.9) * (rise[-1] - rise[0])
        values = np.concatenate([[-height], rise - rise[0], [-rise[-1]]]) - where
        time = np.concatenate([[0.0], up, [up[-1] + rng.uniform(0.1, 1.0)]])
        place = int(np.argmax(values > 0.0))
        low, high = values[place - 1], values[place]
        touch = time[place - 1] - low * (time[place] - time[place - 1]) / (high - low)
        assert_same(
            material,
            ("depth", values, time),
            touch,
            ("depth", [0.0, *values[place:]], np.array([0.0, *(time[place:] - touch)])),
            # The slope at touch suffers from cancellation where the approach is high.
            atol=1e-9 + 1e-14 * height / values.max(),
        )


@pytest.mark.parametrize("material", MATERIALS.values(), ids=MATERIALS)
def test_an_approach_given_as_a_function(material):
    rng = np.random.default_rng(13)
    for _ in range(60):
        height, stop = rng.uniform(0.0, 0.95), 10.0 ** rng.uniform(-3.0, 3.0)
        touch = math.asin(height) / math.pi * stop

        def depth(t, height=height, stop=stop):
            return 1e-6 * (np.sin(math.pi * t / stop) - height)

        end = np.array([touch, stop])
        assert_same(
            material,
            ("depth", depth, np.array([0.0, stop])),
            touch,
            ("depth", lambda t, touch=touch: depth(t + touch), end - touch),
        )


@pytest.mark.parametrize("material", MATERIALS.values(), ids=MATERIALS)
def test_a_wait_without_force(material):
    rng = np.random.default_rng(14)
    for wait in 10.0 ** rng.uniform(-6.0, 2.0, 100):
        values, time = np.array([0.0, 1e-9, 1e-9, 0.0]), np.cumsum([0.0, *rng.uniform(0.1, 1.0, 3)])
        assert_same(
            material, ("force", [0.0, *values], np.array([0.0, *(time + wait)])), wait, ("force", values, time)
        )


def test_a_cut_history_is_exactly_zero_at_the_crossings():
    rng = np.random.default_rng(15)
    for _ in range(1000):
        low, high = rng.uniform(0.1, 1.0, 2) * 10.0 ** rng.uniform(-9.0, 0.0, 2)
        cut = History.from_points([0.0, 1.0, 2.0], [-low, high, -low]).cut()
        assert cut.knots.size == 5
        assert list(cut.coefficients.sum(axis=1)[[0, 2]]) == [0.0, 0.0]
        assert list(cut.coefficients[[1, 3], 0]) == [0.0, 0.0]
