"""Roots that end a step, for an edge whose way is known."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from restitution.kernel import course, zone

SOLID = zone.Solid(1.0, np.zeros(0), np.zeros(0))
LONGEST = 0.1
BODIES = zone.Bodies(0.4, 0.1, 1.0, 1.0, LONGEST, False, 0.0, 0.0, 0.0)
# Step before the last one, and last one.
BEFORE, LAST = 0.08, 0.06


def plain(function):
    """The Python function behind a compiled one."""
    return getattr(function, "py_func", function)


class Way:
    """An edge with a speed and an acceleration; G vanishes on its way, and is no line beside it."""

    def __init__(self, speed: float, gain: float, monkeypatch: pytest.MonkeyPatch) -> None:
        self.speed, self.gain, self.calls = speed, gain, 0
        self.room = zone.allocate_room(np.linspace(0.0, 2.0, 21), 0, 1, 1)
        now, ends = self.room.now, self.room.ends
        now[zone.C_], now[zone.D_] = self.at(0.0), 0.2
        ends[zone.BEFORE_], ends[zone.LAST_] = BEFORE, LAST
        ends[zone.SPEED_] = (self.at(0.0) - self.at(-LAST)) / LAST
        ends[zone.SPEED0_] = (self.at(-LAST) - self.at(-LAST - BEFORE)) / BEFORE
        monkeypatch.setattr(course, "excess", self.excess)
        monkeypatch.setattr(course, "hurries", plain(course.hurries))

    def at(self, t: float) -> float:
        return 1.0 + self.speed * t + 0.5 * self.gain * t * t

    def excess(self, solid, bodies, dt: float, edge: float, room) -> float:
        self.calls += 1
        ahead = edge - self.at(dt)
        return ahead * (1.0 + 0.3 * dt + 0.2 * ahead)


@pytest.mark.parametrize(("speed", "gain"), [(0.9, 0.7), (0.9, -0.7), (-0.9, 0.7), (-0.9, -0.7)])
@pytest.mark.parametrize("part", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("known", [True, False])
def test_the_edge_arrives_where_its_way_crosses_an_element(speed, gain, part, known, monkeypatch):
    way = Way(speed, gain, monkeypatch)
    side, after = (1 if speed > 0.0 else -1), way.at(part * LONGEST)
    # A slope of the last step, 3 % off.
    way.room.ends[zone.FALLS_] = -1.03 * speed if known else 0.0
    # Speeds of two steps are exact for a constant acceleration.
    guess = plain(course.arrival)(side, after, way.room)
    assert guess == pytest.approx(part * LONGEST, rel=1e-9)
    exact = brentq(lambda t: way.at(t) - after, 0.0, LONGEST, xtol=1e-15)
    for first in (0.99 * guess, 1.01 * guess):
        way.calls = 0
        assert plain(course.arrive)(SOLID, BODIES, side, after, first, way.room) == pytest.approx(exact, abs=1e-12)
        assert way.calls <= 5


@pytest.mark.parametrize(("speed", "gain"), [(0.9, 0.7), (-0.9, -0.7), (-0.9, 0.7)])
def test_the_edge_moves_along_its_way_for_the_longest_step(speed, gain, monkeypatch):
    way = Way(speed, gain, monkeypatch)
    side = 1 if speed > 0.0 else -1
    way.room.ends[zone.FALLS_] = -0.97 * speed
    beyond, before = way.at(1.2 * LONGEST), way.at(0.8 * LONGEST)
    assert plain(course.move)(SOLID, BODIES, side, beyond, way.room) == pytest.approx(way.at(LONGEST), abs=1e-12)
    assert way.calls <= 2
    # An element on the way ends the step, and speeds or a slope of the other side tell nothing.
    assert math.isnan(plain(course.move)(SOLID, BODIES, side, before, way.room))
    way.room.ends[zone.FALLS_] *= -1.0
    assert math.isnan(plain(course.move)(SOLID, BODIES, side, beyond, way.room))


def test_an_edge_that_does_not_arrive_is_left_to_the_search(monkeypatch):
    way = Way(0.9, -0.7, monkeypatch)
    way.room.ends[zone.FALLS_] = -0.9
    # Within the longest step it does not come so far.
    after = way.at(1.1 * LONGEST)
    assert math.isnan(plain(course.arrive)(SOLID, BODIES, 1, after, 0.9 * LONGEST, way.room))
    # It turns back before it.
    assert plain(course.arrival)(1, way.at(0.9 / 0.7) + 1e-3, way.room) == math.inf
    # Behind a fold: without time G has the other sign, rises and falls. A fast edge makes this likely.
    monkeypatch.setattr(course, "excess", lambda solid, bodies, dt, edge, room: (dt - 0.02) * (0.03 - dt))
    after = way.at(0.5 * LONGEST)
    assert plain(course.hurries)(0.029, after, way.room)
    assert math.isnan(plain(course.arrive)(SOLID, BODIES, 1, after, 0.029, way.room))
    # After a jump no speeds are known.
    way.room.ends[zone.BEFORE_] = -1.0
    assert plain(course.arrival)(1, after, way.room) == math.inf
