from types import SimpleNamespace

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
            "velocity": ("time", np.cos(np.pi * t / 2e-3)),
            "force": ("time", 2.5e3 * bump**1.5),
            "contact_radius": ("time", 5e-6 * np.sqrt(bump)),
        },
        {"time": t},
    )


@pytest.fixture
def result(history):
    energy = SimpleNamespace(kinetic_in=2e-3, kinetic_out=1e-3, dissipated=6e-4, stored=4e-4, residual=1e-12)
    return SimpleNamespace(history=history, energy=energy, restitution_coefficient=0.7071, contact_time=2e-3)


@pytest.mark.parametrize(
    ("draw", "x", "y"),
    [
        (plots.force_time, "time $t$ [ms]", "force $F$ [kN]"),
        (plots.force_indentation, "indentation depth $d$ [µm]", "force $F$ [kN]"),
        (plots.contact_radius_time, "time $t$ [ms]", "contact radius $a$ [µm]"),
        (plots.depth_time, "time $t$ [ms]", "indentation depth $d$ [µm]"),
    ],
)
def test_axes_name_quantity_symbol_and_unit(history, draw, x, y) -> None:
    ax = style.new_figure().add_subplot()
    assert draw(ax, history) is ax
    assert (ax.get_xlabel(), ax.get_ylabel()) == (x, y)


def test_line_holds_the_history_in_the_units_of_the_labels(history) -> None:
    line = plots.force_indentation(style.new_figure().add_subplot(), history).lines[0]
    assert line.get_xdata() == pytest.approx(1e6 * history.indentation_depth.values, rel=1e-15)
    assert line.get_ydata() == pytest.approx(1e-3 * history.force.values, rel=1e-15)


def test_missing_variable_is_named(history) -> None:
    with pytest.raises(
        ValueError, match="history has no variable 'force': must have time, indentation_depth"
    ):
        plots.force_time(style.new_figure().add_subplot(), history.drop_vars("force"))


def test_histories_of_several_impacts_are_refused(history) -> None:
    several = xr.concat([history, history], "impact")
    with pytest.raises(
        ValueError, match=r"history variable 'force' has shape \(2, 50\): must be over time alone"
    ):
        plots.force_time(style.new_figure().add_subplot(), several)


def test_energy_bars_fill_the_kinetic_energy_before(result) -> None:
    ax = plots.energy_bar(style.new_figure().add_subplot(), result.energy)
    edges = [(bar.get_x(), bar.get_x() + bar.get_width()) for bar in ax.patches]
    assert np.ravel(edges) == pytest.approx([0.0, 1.0, 1.0, 1.6, 1.6, 2.0], abs=1e-12)
    assert ax.get_xlabel() == "energy [mJ] (dashed: before the impact)"


def test_overview_has_five_panels_and_says_the_result(result) -> None:
    figure = plots.overview(result)
    assert len(figure.axes) == 5
    assert figure.get_suptitle() == "$e = 0.7071$,  contact time 2 ms"
    assert [ax.get_title("left") for ax in figure.axes] == ["(a)", "(b)", "(c)", "(d)", "(e)"]


def test_overview_draws_into_a_given_figure_and_leaves_settings_alone(result) -> None:
    import matplotlib

    before = dict(matplotlib.rcParams)
    page = style.new_figure()
    assert plots.overview(result, figure=page) is page
    assert dict(matplotlib.rcParams) == before


def test_tick_labels_keep_the_packages_font_outside_the_context(result) -> None:
    figure = plots.overview(result)
    figure.set_size_inches(20.0, 12.0)
    figure.draw_without_rendering()
    families = {
        family for ax in figure.axes for tick in ax.get_xticklabels() for family in tick.get_fontfamily()
    }
    assert families == {"STIXGeneral"}
