"""Pictures of identifications and designs: labels with units, all panels, nothing that warns."""

from functools import partial
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import restitution as rs
from restitution.identification.observations import Curve
from restitution.plot.identification import comparison, data_and_fit, design, grid, overview
from restitution.plot.style import context, new_figure, plain_ticks, save_figure
from restitution.quantities import INPUTS


@pytest.fixture(scope="module")
def fit() -> rs.Identification:
    solid = rs.kelvin_voigt(1e6, 300.0, poisson_ratio=0.5)
    v, mass = np.tile([0.005, 0.01, 0.02], 2), np.repeat([0.01, 0.1], 3)
    exact = rs.solve(rs.Impact(solid, rs.Parabola(0.01), mass, v))
    noise = rs.Noise(restitution_coefficient=0.01, contact_time="1 %")
    balls = rs.Rebounds(
        v,
        exact.restitution_coefficient,
        radius=0.01,
        mass=mass,
        contact_time=exact.contact_time,
        noise=noise,
        label="two balls",
    )
    return rs.identify(balls, rs.kelvin_voigt, fixed={"poisson_ratio": 0.5})


def test_the_page_of_an_identification(fit: rs.Identification, tmp_path: Path) -> None:
    figure = overview(fit)
    labels = [(ax.get_xlabel(), ax.get_ylabel()) for ax in figure.axes]
    assert labels[:2] == [
        ("impact velocity $v_0$ [mm/s]", "restitution coefficient $e$"),
        ("impact velocity $v_0$ [mm/s]", "contact time $T$ [ms]"),
    ]
    assert len(labels) == 6
    assert labels[3] == ("change from the best value [%]", r"growth of $\chi^2$ (dashed: 95 %)")
    assert all("[" in x or "number" in x for x, _ in labels)
    assert save_figure(figure, tmp_path / "fit.png").stat().st_size > 10_000


def test_each_ball_has_its_own_fit(fit: rs.Identification) -> None:
    (_, curves), *_ = fit.curves
    with context():
        ax = data_and_fit(new_figure().add_subplot(), [("two balls", curves[0])])
    fits = [line for line in ax.lines if line.get_color() == "black"]
    assert len(fits) == 2
    for line, rows in zip(fits, (slice(0, 3), slice(3, 6)), strict=True):
        np.testing.assert_allclose(line.get_ydata(), curves[0].measured[rows], rtol=1e-4)


def test_only_several_sets_are_named(fit: rs.Identification) -> None:
    (_, curves), *_ = fit.curves
    with context():
        axes = [data_and_fit(new_figure().add_subplot(), [(name, curves[0]._replace()) for name in names])
                for names in (["one"], ["one", "other"])]  # fmt: skip
    words = [[text.get_text() for text in ax.get_legend().get_texts()] for ax in axes]
    names = [["10 g", "100 g", "fit"], ["fit", "one, 10 g", "one, 100 g", "other, 10 g", "other, 100 g"]]
    assert [sorted(result) for result in words] == [sorted(result) for result in names]
    alone = curves[0]._replace(bodies=())
    with context():
        ax = data_and_fit(new_figure().add_subplot(), [("one", alone)])
    assert sorted(text.get_text() for text in ax.get_legend().get_texts()) == ["fit", "measured"]


@pytest.mark.parametrize(
    ("mass", "names"),
    [
        (np.tile([0.001, 0.001, 0.002, 0.002], 2), ["10 mm", "20 mm"]),
        (np.tile([0.005, 0.01], 4), ["10 mm, 5 g", "10 mm, 10 g", "20 mm, 5 g", "20 mm, 10 g"]),
        (np.linspace(0.001, 0.008, 8), ["measured"]),  # more than a legend can list
    ],
)
def test_bodies_have_the_quantities_that_distinguish_them(mass: np.ndarray, names: list[str]) -> None:
    v, e = np.repeat([0.01, 0.02], 4), np.linspace(0.5, 0.6, 8)
    balls = rs.Rebounds(v, e, radius=np.tile([0.01, 0.01, 0.02, 0.02], 2), mass=mass)
    curve = Curve("restitution_coefficient", "velocity", v, e, e, None, balls._bodies())
    with context():
        ax = data_and_fit(new_figure().add_subplot(), [("balls", curve)])
    shown = {container.get_label(): container[0].get_ydata() for container in ax.containers}
    assert list(shown) == names
    for name, values in shown.items():
        expected = [e[n] for n in range(8) if name == "measured" or (name.startswith(f"{1e3 * balls.radius[n]:g} mm")
                  and (" g" not in name or name.endswith(f" {1e3 * mass[n]:g} g")))]  # fmt: skip
        assert values.tolist() == expected


@pytest.mark.parametrize("removed", [0, 1])
def test_a_page_has_no_empty_panel(fit: rs.Identification, removed: int) -> None:
    (data,) = fit.data
    times = {} if removed else {"contact_time": data.contact_time}
    alone = rs.Rebounds(data.velocity, data.restitution_coefficient, radius=0.01, mass=data.mass, **times)
    figure = overview(rs.identify(alone, rs.kelvin_voigt, fixed={"poisson_ratio": 0.5}))
    places = [ax.get_subplotspec() for ax in figure.axes]
    cells = {(row, column) for place in places for row in place.rowspan for column in place.colspan}
    rows, columns = places[0].get_gridspec().get_geometry()
    assert len(cells) == rows * columns


def test_a_parameter_that_is_not_determined_has_no_profile(fit: rs.Identification) -> None:
    (data,) = fit.data
    alone = rs.Rebounds(data.velocity, data.restitution_coefficient, radius=0.01, mass=data.mass,
                        noise=rs.Noise(restitution_coefficient=0.01))  # fmt: skip
    figure = overview(rs.identify(alone, rs.kelvin_voigt, fixed={"poisson_ratio": 0.5}))
    panel = figure.axes[2]
    words = [text.get_text() for text in panel.get_legend().get_texts()]
    assert words == ["shear modulus: not determined", "viscosity: not determined"]
    assert not panel.get_xticks().size


@pytest.mark.parametrize(("low", "high", "plain"), [(3.0, 200.0, True), (3.0, 400.0, False)])
def test_a_logarithmic_axis_of_at_most_two_decades_has_plain_numbers(low: float, high: float, plain: bool) -> None:
    ax = new_figure().add_subplot()
    ax.set(yscale="log", ylim=(low, high))
    plain_ticks(ax)
    ax.figure.draw_without_rendering()
    inside = [text.get_text() for text in ax.get_yticklabels() if low <= text.get_position()[1] <= high]
    assert (inside == ["5", "10", "20", "50", "100", "200"]) is plain


def test_a_design_shows_each_ball_beside_the_best_set() -> None:
    guess = partial(rs.standard_solid, 1e6, 1e7, 1e4, poisson_ratio=0.5)
    plan = rs.design(guess, {"velocity": [0.1, 1.0, 10.0], "radius": [0.003, 0.03], "density": 7800.0}, n=6)
    left, right = design(plan).axes
    assert [text.get_text() for text in left.texts] == [str(n) for n in plan.repeats]
    assert [label.get_text() for label in right.get_yticklabels()] == ["3 mm alone", "30 mm alone", "this design"]


def test_a_force_map_has_a_colour_bar_with_the_unit() -> None:
    values = np.array([[100.0, 200.0, np.nan], [150.0, 400.0, 5000.0]])
    table = xr.Dataset({"equilibrium_modulus": (("y", "x"), values, INPUTS["equilibrium_modulus"].attributes)})
    ax, bar = grid(table, "equilibrium_modulus").axes
    assert bar.get_ylabel() == r"equilibrium shear modulus $G_\infty$ [kPa]"
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("place along x", "place along y")
    with pytest.raises(rs.InputError, match="must be over two dimensions"):
        grid(table.isel(x=0), "equilibrium_modulus")


def test_compared_models_have_a_line_each(fit: rs.Identification) -> None:
    compared = rs.identify.compare(list(fit.data), [rs.kelvin_voigt, rs.elastic], fixed={"poisson_ratio": 0.5})
    left, right = comparison(compared).axes
    assert [text.get_text().partition(",")[0] for text in left.get_legend().get_texts()][1:] == [
        "kelvin voigt",
        "elastic",
    ]
    assert right.get_ylabel() == r"loss tangent $\tan\delta$"
