"""The overview of an impact for each method."""

import matplotlib
import numpy as np
import pytest

import restitution as rs
from cases import RUBBER
from refusals import named
from restitution.plot import impact as plots
from restitution.plot import style

IMPACT = rs.Impact(RUBBER, rs.Parabola(0.01), mass=0.005, velocity=0.1)


@pytest.fixture(scope="module")
def result() -> rs.ImpactResult:
    return rs.solve(IMPACT)


@pytest.fixture(scope="module")
def figure(result):
    return result.plot()


def test_overview_has_six_panels_and_the_result_in_its_title(result, figure) -> None:
    assert [ax.get_title("left") for ax in figure.axes] == ["(a)", "(b)", "(c)", "(d)", "(e)", "(f)"]
    time = 1e3 * result.contact_time
    assert figure.get_suptitle() == f"$e = {result.restitution_coefficient:.4g}$,  contact time {time:.4g} ms"
    assert [ax.get_ylabel().split(" [")[0] for ax in figure.axes] == [
        "normal force $F$",
        "normal force $F$",
        "indentation depth $d$",
        "contact radius $a$",
        "pressure $p$",
        "energy",
    ]


@pytest.mark.slow
def test_the_pressure_is_shown_at_given_times(result) -> None:
    times = [0.3 * result.contact_time, 0.6 * result.contact_time]
    legend = result.plot(times).axes[4].get_legend()
    assert [text.get_text() for text in legend.get_texts()] == [f"{1e3 * t:.3g} ms" for t in times]


def test_energies_add_up_to_the_kinetic_energy_at_impact(figure) -> None:
    top = figure.axes[5].collections[-1].get_paths()[0].vertices[:, 1].max()
    # m v0^2/2 = 25 uJ; the quadratures have a relative error of 1e-8.
    assert top == pytest.approx(25.0, rel=1e-7)


def test_pressure_of_the_picture_carries_the_force(result, figure) -> None:
    from restitution.plot.impact import instants

    for line, t in zip(figure.axes[4].lines, instants(result), strict=True):
        r, p = line.get_xdata() * 1e-6, line.get_ydata() * 1e3
        assert figure.axes[4].get_ylabel() == "pressure $p$ [kPa]"
        force = np.trapezoid(2.0 * np.pi * r * p, r)
        # The trapezoidal rule with 241 points of an ellipse.
        assert force == pytest.approx(float(result.sample([t]).force[0]), rel=1e-3)


def test_tick_labels_keep_the_font_outside_the_context(figure) -> None:
    figure.set_size_inches(20.0, 12.0)
    figure.draw_without_rendering()
    families = {family for ax in figure.axes for tick in ax.get_xticklabels() for family in tick.get_fontfamily()}
    assert families == {"STIXGeneral"}


def test_overview_draws_into_a_given_figure_and_leaves_settings_alone(result) -> None:
    before = dict(matplotlib.rcParams)
    page = style.new_figure()
    assert plots.overview(result, figure=page) is page
    assert dict(matplotlib.rcParams) == before


def test_panels_of_elements() -> None:
    assert len(rs.solve(IMPACT, "elements", n_elements=40).plot().axes) == 5


def _lines(figure):
    return [ax.lines[0] for ax in figure.axes]


def test_several_impacts_are_drawn_over_their_velocity() -> None:
    """In the units of the labels, in the order of the velocity."""
    speeds = np.array([0.5, 0.01, 0.1])
    several = rs.solve(rs.Impact(RUBBER, rs.Parabola(0.01), mass=0.005, velocity=speeds))
    figure = several.plot()
    assert [ax.get_xlabel() for ax in figure.axes] == ["impact velocity $v_0$ [mm/s]"] * 4
    assert figure.axes[0].get_xscale() == "log"
    e, time, *_ = (line.get_ydata() for line in _lines(figure))
    np.testing.assert_allclose(_lines(figure)[0].get_xdata(), [10.0, 100.0, 500.0], rtol=1e-12)
    np.testing.assert_array_equal(e, several.restitution_coefficient[[1, 2, 0]])
    np.testing.assert_allclose(time, 1e3 * several.contact_time[[1, 2, 0]], rtol=1e-12)
    assert "[ms]" in figure.axes[1].get_ylabel()
    assert named(lambda: several.plot([1e-3])) == ("times",)


def test_several_impacts_without_a_common_order_are_points() -> None:
    masses, speeds = np.array([1e-3, 5e-3])[:, None], np.array([0.1, 0.2, 0.3])
    both = rs.solve(rs.Impact(RUBBER, rs.Parabola(0.01), mass=masses, velocity=speeds)).plot()
    assert _lines(both)[0].get_linestyle() == "None"
    assert len(_lines(both)[0].get_xdata()) == 6
    by_mass = rs.solve(rs.Impact(RUBBER, rs.Parabola(0.01), mass=masses[:, 0], velocity=0.1)).plot()
    assert "mass" in by_mass.axes[0].get_xlabel()
    listed = rs.solve([IMPACT, rs.Impact(RUBBER, rs.Parabola(0.02), mass=0.005, velocity=0.1)]).plot()
    assert listed.axes[0].get_xlabel() == "number of the impact"
