"""Pictures of bounces: flights, axes, overview."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from restitution.impact.bounces import Ending
from restitution.plot import impact as plots
from restitution.plot import style


@pytest.fixture
def series() -> Any:
    """Fall from 5 m in 1 s with g = 10 m/s2 to 10 m/s; each contact of 0.1 s halves the velocity."""
    return SimpleNamespace(
        touch_time=np.array([1.0, 2.1, 2.7]),
        velocity=np.array([10.0, 5.0, 2.5]),
        restitution_coefficient=np.array([0.5, 0.5, 0.0]),
        rebound_velocity=np.array([5.0, 2.5, 0.0]),
        contact_time=np.array([0.1, 0.1, math.inf]),
        residual_indentation_depth=np.array([0.0, 0.0, math.nan]),
        height=np.array([1.25, 0.3125, 0.0]),
        drop_height=5.0,
        gravity=10.0,
        ended=Ending.CAPTURED,
        n_bounces=3,
    )


def test_flights_are_parabolas_with_gaps_during_contact(series: Any) -> None:
    time, height = plots.flight(series)
    assert np.all(np.diff(time) >= 0.0)
    assert (time[0], height[0], time[-1]) == (0.0, 5.0, 2.7)
    at = np.interp([0.5, 1.6, 2.45], time[np.isfinite(height)], height[np.isfinite(height)])
    assert at == pytest.approx([3.75, 1.25, 0.3125], rel=2e-3)
    assert np.count_nonzero(np.isnan(height)) == 2
    assert np.nanmax(height[time > 1.0]) == pytest.approx(1.25, rel=1e-3)
    assert np.nanmin(height) == pytest.approx(0.0, abs=1e-14)


def test_axes(series: Any) -> None:
    ax = plots.height_time(style.new_figure().add_subplot(), series)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time since the release [s]", "height [m]")
    ax = plots.restitution_velocity(style.new_figure().add_subplot(), series)
    assert ax.lines[0].get_xydata().tolist() == [[10.0, 0.5], [5.0, 0.5], [2.5, 0.0]]
    ax = plots.bounce_heights(style.new_figure().add_subplot(), series)
    assert ax.lines[0].get_xydata().tolist() == [[0.0, 5.0], [1.0, 1.25], [2.0, 0.3125]]


def test_overview(series: Any) -> None:
    figure = plots.bounces_overview(series)
    assert [ax.get_title("left") for ax in figure.axes] == ["(a)", "(b)", "(c)"]
    assert figure.get_suptitle() == "3 bounces; captured: the weight holds the body in contact"
