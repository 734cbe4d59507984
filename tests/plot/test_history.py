"""Panels of the history of a contact."""

import numpy as np
import pytest
import xarray as xr

from restitution.plot import history as plots
from restitution.plot import style


@pytest.fixture
def history() -> xr.Dataset:
    t = np.linspace(0.0, 2e-3, 50)
    bump = np.sin(np.pi * t / 2e-3)
    return xr.Dataset(
        {
            "indentation_depth": ("time", 4e-4 * bump),
            "indentation_velocity": ("time", np.cos(np.pi * t / 2e-3)),
            "force": ("time", 2.5e3 * bump**1.5),
            "contact_radius": ("time", 5e-6 * np.sqrt(bump)),
        },
        {"time": t},
    )


@pytest.mark.parametrize(
    ("draw", "x", "y"),
    [
        (plots.force_time, "time since first touch $t$ [ms]", "normal force $F$ [kN]"),
        (plots.force_indentation, "indentation depth $d$ [µm]", "normal force $F$ [kN]"),
        (plots.contact_radius_time, "time since first touch $t$ [ms]", "contact radius $a$ [µm]"),
        (plots.depth_time, "time since first touch $t$ [ms]", "indentation depth $d$ [µm]"),
    ],
)
def test_axes_name_quantity_symbol_and_unit(history, draw, x, y) -> None:
    ax = style.new_figure().add_subplot()
    assert draw(ax, history) is ax
    assert (ax.get_xlabel(), ax.get_ylabel()) == (x, y)


def test_line_has_the_history_in_the_units_of_the_labels(history) -> None:
    line = plots.force_indentation(style.new_figure().add_subplot(), history).lines[0]
    assert line.get_xdata() == pytest.approx(1e6 * history.indentation_depth.values, rel=1e-15)
    assert line.get_ydata() == pytest.approx(1e-3 * history.force.values, rel=1e-15)


def test_a_missing_variable_is_refused(history) -> None:
    with pytest.raises(ValueError, match="force"):
        plots.force_time(style.new_figure().add_subplot(), history.drop_vars("force"))


def test_histories_of_several_impacts_are_refused(history) -> None:
    several = xr.concat([history, history], "impact")
    with pytest.raises(ValueError, match=r"force.*\(2, 50\).*over time alone"):
        plots.force_time(style.new_figure().add_subplot(), several)


def test_contact_radius_starts_at_zero(history) -> None:
    flat = history.assign(contact_radius=("time", np.full(50, 1e-2)))
    ax = plots.contact_radius_time(style.new_figure().add_subplot(), flat)
    assert ax.get_ylim()[0] == 0.0
    assert ax.get_ylim()[1] > 10.0
