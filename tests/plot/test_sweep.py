"""Figures of sweeps: layout, units and values."""

import math
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
import xarray as xr

import restitution as rs
from cases import BALL
from refusals import in_one_line, named
from restitution.plot import style
from restitution.plot.style import new_figure, save_figure
from restitution.plot.sweep import Layout, choose_layout, map_levels, plot_sweep
from restitution.quantities import INPUTS, OUTPUTS, input_attributes
from restitution.quantities import scaled as quantity


def result(
    shape: dict[str, Any], outputs: tuple[str, ...] = ("restitution_coefficient",), draws: int = 0
) -> xr.Dataset:
    """Made-up result of a sweep: the product of one plus each index."""
    sizes = {name: len(values) for name, values in shape.items()} | ({"draw": draws} if draws else {})
    numbers = np.ones([*sizes.values()])
    for place, n in enumerate(sizes.values()):
        numbers = numbers * (1.0 + np.arange(n)).reshape([-1 if k == place else 1 for k in range(len(sizes))])
    coordinates: dict[str, Any] = {
        name: (name, values, input_attributes(name) | {"scale": "linear"}) for name, values in shape.items()
    }
    if draws:
        coordinates["mass"] = ("draw", np.linspace(0.001, 0.002, draws), input_attributes("mass"))
    data = {
        name: (
            tuple(sizes),
            numbers / (numbers.max() * 1.1) if name == outputs[0] else numbers,
            OUTPUTS[name].attributes,
        )
        for name in outputs
    }
    return xr.Dataset({**data, "status": (tuple(sizes), np.zeros(numbers.shape, dtype=np.int8))}, coordinates)


def panels(figure: Any) -> list[Any]:
    """Axes of the figure without those of colour bars."""
    return [ax for ax in figure.axes if ax.get_label() != "<colorbar>"]


def line(n: int) -> Any:
    return np.linspace(0.001, 0.002, n)


WORDS = np.array(["rubber", "steel"])


@pytest.fixture
def unlaid(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pages without their layout, which takes most of their time and moves no text to another panel."""
    monkeypatch.setattr(style, "_lay_out", lambda figure: None)
    monkeypatch.setattr(style.Picture, "draw_without_rendering", lambda figure: None)


LAYOUTS: list[tuple[dict[str, Any], int, dict[str, str], Layout]] = [
    ({"velocity": line(50)}, 0, {}, Layout("curves", "velocity", None, None, None, ())),
    ({"velocity": line(50), "radius": line(3)}, 0, {}, Layout("curves", "velocity", "radius", None, None, ())),
    ({"radius": line(3), "velocity": line(50)}, 0, {}, Layout("curves", "velocity", "radius", None, None, ())),
    ({"velocity": line(50), "material": WORDS}, 0, {}, Layout("curves", "velocity", "material", None, None, ())),
    ({"material": WORDS}, 0, {}, Layout("curves", "material", None, None, None, ())),
    ({"velocity": line(20), "radius": line(30)}, 0, {}, Layout("map", "velocity", "radius", None, None, ())),
    (
        {"velocity": line(20), "radius": line(30)}, 0, {"x": "radius", "y": "velocity"},
        Layout("map", "radius", "velocity", None, None, ()),
    ),
    (
        {"velocity": line(20), "radius": line(3)}, 0, {"x": "radius", "y": "velocity"},
        Layout("map", "radius", "velocity", None, None, ()),
    ),
    (
        {"poisson_ratio": line(4), "p2": line(20), "p3": line(30)}, 0, {},
        Layout("map", "p2", "p3", "poisson_ratio", None, ()),
    ),
    (
        {"poisson_ratio": line(4), "p2": line(5), "p3": line(30)}, 0, {},
        Layout("curves", "p3", "poisson_ratio", "p2", None, ()),
    ),
    (
        {"material": WORDS, "poisson_ratio": line(4), "p2": line(20), "p3": line(30)}, 0, {},
        Layout("map", "p2", "p3", "poisson_ratio", None, ("material",)),
    ),
    ({}, 40, {}, Layout("draws", None, None, None, "draw", ())),
    ({"velocity": line(20)}, 40, {}, Layout("bands", "velocity", None, None, "draw", ())),
    ({"velocity": line(20), "radius": line(3)}, 40, {}, Layout("bands", "velocity", None, "radius", "draw", ())),
    ({"velocity": line(50), "radius": line(1)}, 0, {}, Layout("curves", "velocity", None, None, None, ())),
]  # fmt: skip


@pytest.mark.parametrize(("shape", "draws", "options", "layout"), LAYOUTS)
def test_layout(shape: dict[str, Any], draws: int, options: dict[str, str], layout: Layout) -> None:
    assert choose_layout(result(shape, draws=draws), **options) == layout


# One of each kind.
@pytest.mark.parametrize(("shape", "draws", "options", "layout"), [LAYOUTS[n] for n in (1, 5, 8, 9, 11, 12, 13)])
@pytest.mark.usefixtures("unlaid")
def test_panels(shape: dict[str, Any], draws: int, options: dict[str, str], layout: Layout) -> None:
    figure = plot_sweep(result(shape, draws=draws), **options)
    slices = {"poisson_ratio": 4, "p2": 5, "radius": 3}
    assert len(panels(figure)) == (2 if layout.kind == "draws" else slices.get(layout.slices or "", 1))


def test_curves_have_the_numbers_in_units_that_suit_them() -> None:
    dataset = result({"velocity": line(50), "radius": line(3)}, ("restitution_coefficient", "contact_time"))
    dataset["contact_time"] = dataset.contact_time * 1e-6
    dataset["contact_time"].attrs = OUTPUTS["contact_time"].attributes
    figure = plot_sweep(dataset)
    first, second = figure.axes
    np.testing.assert_allclose(first.lines[1].get_xdata(), 1e3 * line(50))
    np.testing.assert_allclose(first.lines[1].get_ydata(), dataset.restitution_coefficient[:, 1])
    np.testing.assert_allclose(second.lines[2].get_ydata(), 1e6 * dataset.contact_time[:, 2])
    assert (first.get_xlabel(), first.get_ylabel()) == ("impact velocity $v_0$ [mm/s]", "restitution coefficient $e$")
    assert second.get_ylabel() == "contact time $T$ [µs]"
    legend = first.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["$R$ = 1 mm", "$R$ = 1.5 mm", "$R$ = 2 mm"]
    assert second.get_yscale() == "log"
    assert first.get_yscale() == "linear"


def test_one_value_of_an_axis_can_be_chosen() -> None:
    dataset = result({"velocity": line(50), "radius": line(11), "material": WORDS})
    figure = plot_sweep(dataset, at={"radius": 0.00152, "material": "steel"})
    np.testing.assert_allclose(figure.axes[0].lines[0].get_ydata(), dataset.restitution_coefficient[:, 5, 1])


def test_no_two_quantities_share_a_symbol() -> None:
    symbols = [entry.symbol for entry in INPUTS.values()] + [entry.symbol for entry in OUTPUTS.values()]
    assert len(set(symbols)) == len(symbols)


@pytest.mark.usefixtures("unlaid")
def test_further_axes_are_shown_at_their_middle_value_given_in_the_title() -> None:
    shape = {"material": WORDS, "poisson_ratio": line(4), "p2": line(20), "p3": line(30)}
    figure = plot_sweep(result(shape))
    title = figure.get_suptitle()
    assert title == "steel"
    assert figure.axes[2].get_title() == r"$\nu$ = 0.001667"
    figure = plot_sweep(result(shape), at={"p2": 0.0011, "nu": 0.001, "material": "rubber"})
    assert figure.get_suptitle() == "rubber, $\\nu$ = 0.001, $p_2$ = 0.001105"


def test_the_title_gives_the_common_values_in_lines_that_fit() -> None:
    dataset = result({"velocity": line(50)}).assign_attrs(title="Rubber balls")
    shared = ("mass", "radius", "external_force", "p2", "p3")
    dataset = dataset.assign_coords({name: ((), 0.001, input_attributes(name)) for name in shared})
    figure = plot_sweep(dataset)
    head, first, second = figure.get_suptitle().split("\n")
    assert (head, first) == ("Rubber balls", "$m$ = 1 g, $R$ = 1 mm, $F_0$ = 1 mN, $p_2$ = 0.001")
    assert second == "$p_3$ = 0.001"


@pytest.mark.usefixtures("unlaid")
def test_slices_lie_on_the_axis() -> None:
    dataset = result({"velocity": line(50), "bulk_modulus": [1e6, 2e6, np.inf], "radius": line(3)})
    assert plot_sweep(dataset, at={"velocity": 0.002 * (1 + 1e-9), "bulk_modulus": np.inf}) is not None
    for choice in ({}, {"x": "bulk_modulus"}, {"x": "velocity", "y": "radius", "at": {"bulk_modulus": np.inf}}):
        plot_sweep(dataset, **choice)  # type: ignore[arg-type]
    assert plot_sweep(dataset, at={"bulk_modulus": np.inf}).get_suptitle() == "$K$ = $\\infty$"
    ax = plot_sweep(dataset, x="bulk_modulus", at={"velocity": 0.001, "radius": 0.001}).axes[0]
    assert np.asarray(ax.lines[0].get_xdata()).tolist() == [1.0, 2.0]
    with pytest.raises(ValueError, match=r"bulk_modulus.*too few finite values"):
        plot_sweep(dataset.isel(bulk_modulus=[0, 2]), x="velocity", y="bulk_modulus")
    for value in (0.0009, 0.0021, math.nan, math.inf):
        with pytest.raises(ValueError, match=r"at velocity = .* from 0.001 to 0.002"):
            plot_sweep(dataset, at={"velocity": value})
    assert named(lambda: plot_sweep(dataset, at={"velocity": "abc"}), TypeError) == ("at velocity", "abc")


def test_a_map_is_not_transposed() -> None:
    dataset = result({"velocity": line(20), "radius": line(30)})
    ax = plot_sweep(dataset).axes[0]
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("impact velocity $v_0$ [mm/s]", "radius $R$ [mm]")
    # e = (1 + i)(1 + j)/660 on its isolines
    (lines,) = [part for part in ax.collections if type(part).__name__ == "QuadContourSet"]
    for level, path in zip(lines.levels, lines.get_paths(), strict=True):
        if len(path.vertices) == 0:
            continue
        x, y = path.vertices[len(path.vertices) // 2]
        product = (1.0 + (x - 1.0) * 19.0) * (1.0 + (y - 1.0) * 29.0)
        # Between points of the grid a straight line approximates a hyperbola.
        assert product / 660.0 == pytest.approx(level, rel=0.05)


def test_bands_are_quantiles_of_the_draws() -> None:
    dataset = result({"velocity": line(20)}, draws=101)
    ax = plot_sweep(dataset).axes[0]
    np.testing.assert_allclose(ax.lines[0].get_ydata(), dataset.restitution_coefficient.quantile(0.5, "draw"))
    low, high = (
        ax.collections[0].get_paths()[0].vertices[:, 1].min(),
        ax.collections[0].get_paths()[0].vertices[:, 1].max(),
    )
    assert low == pytest.approx(float(dataset.restitution_coefficient.quantile(0.05, "draw").min()))
    assert high == pytest.approx(float(dataset.restitution_coefficient.quantile(0.95, "draw").max()))


def test_draws_are_counted_and_scattered() -> None:
    dataset = result({}, draws=64)
    histogram, scatter = plot_sweep(dataset).axes
    assert sum(patch.get_height() for patch in histogram.patches) == 64
    np.testing.assert_allclose(scatter.lines[0].get_xdata(), np.linspace(1.0, 2.0, 64))
    np.testing.assert_allclose(scatter.lines[0].get_ydata(), dataset.restitution_coefficient)
    assert scatter.get_xlabel() == "mass $m$ [g]"


@pytest.mark.usefixtures("unlaid")
def test_missing_and_infinite_values_are_left_out(tmp_path: Path) -> None:
    dataset = result({"velocity": line(20), "radius": line(30)}, ("restitution_coefficient", "contact_time"))
    dataset.restitution_coefficient[:4] = np.nan
    dataset.contact_time[:4] = np.inf
    save_figure(plot_sweep(dataset), tmp_path / "part.png")
    dataset.restitution_coefficient[:] = np.nan
    dataset.contact_time[:] = np.nan
    for choice in ({}, {"at": {"radius": 0.001}}):
        save_figure(plot_sweep(dataset, **choice), tmp_path / "nothing.png")  # type: ignore[arg-type]


def test_large_sweeps_are_thinned() -> None:
    ax = plot_sweep(result({"velocity": np.linspace(1.0, 2.0, 50_000)})).axes[0]
    points = np.asarray(ax.lines[0].get_xdata())
    assert points.size <= 2000
    assert (points[0], points[-1]) == (1.0, 2.0)


@pytest.mark.parametrize(
    ("values", "attributes", "label", "first"),
    [
        ([0.02], {"units": "kg", "long_name": "mass"}, "mass [g]", 20.0),
        ([3.0], {"units": "kg", "long_name": "mass"}, "mass [kg]", 3.0),
        ([2e6], {"units": "Pa", "long_name": "modulus"}, "modulus [MPa]", 2.0),
        ([1100.0], {"units": "kg/m^3", "long_name": "density"}, "density [kg/m$^{3}$]", 1100.0),
        ([300.0], {"units": "K", "long_name": "temperature", "symbol": "$T$"}, "temperature $T$ [K]", 300.0),
        ([0.3], {"units": "1", "long_name": "ratio"}, "ratio", 0.3),
        ([0.3], {}, "thing", 0.3),
    ],
)
def test_units(values: list[float], attributes: dict[str, str], label: str, first: float) -> None:
    column = quantity(xr.DataArray(values, attrs=attributes, name="thing"))
    assert (column.label, column.values[0]) == (label, pytest.approx(first))


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"outputs": ["max_force"]}, "outputs"),
        ({"x": "mass"}, "x"),
        ({"x": "velocity", "y": "velocity"}, "y"),
        ({"at": {"mass": 1}}, "at"),
        ({"at": {"velocity": 0.001, "radius": 0.001}}, "dataset"),
    ],
)
def test_invalid_options_are_refused(options: dict[str, Any], field: str) -> None:
    assert in_one_line(lambda: plot_sweep(result({"velocity": line(5), "radius": line(5)}), **options)).field == field


def test_what_is_no_result_of_a_sweep_is_refused() -> None:
    assert in_one_line(lambda: plot_sweep(cast(xr.Dataset, [0.7, 0.8]))).field == "dataset"


def test_given_axes_take_a_single_panel() -> None:
    dataset = result({"velocity": line(20)}, ("restitution_coefficient", "contact_time"))
    figure = new_figure()
    ax = figure.add_subplot()
    assert plot_sweep(dataset, ax=ax) is figure
    assert len(ax.lines) == 1
    assert in_one_line(lambda: plot_sweep(dataset, ["restitution_coefficient", "contact_time"], ax=ax)).field == "ax"


@pytest.mark.usefixtures("unlaid")
def test_slices_share_their_levels_and_their_shading() -> None:
    dataset = result({"poisson_ratio": line(3), "velocity": line(20), "radius": line(30)}, ("contact_time",))
    figure = plot_sweep(dataset)
    shown = [ax.collections[0] for ax in panels(figure)]
    assert len({(mesh.norm.vmin, mesh.norm.vmax) for mesh in shown}) == 1
    bars = [ax for ax in figure.axes if ax.get_label() == "<colorbar>"]
    assert len({tuple(bar.get_yticks()) for bar in bars}) == 1


def test_draws_at_two_points_give_bars_and_no_bands() -> None:
    ax = plot_sweep(result({"velocity": line(2)}, draws=50)).axes[0]
    assert ax.lines[0].get_linestyle() == "None"
    assert {type(part).__name__ for part in ax.collections} == {"LineCollection"}


@pytest.mark.usefixtures("unlaid")
def test_a_real_sweep(tmp_path: Path) -> None:
    out = tmp_path / "result.zarr"
    rs.sweep(BALL, {"velocity": rs.Logarithmic(0.01, 0.1, 12), "radius": rs.Linear(0.01, 0.02, 11)}, out=out)
    figure = plot_sweep(rs.open_sweep(out))
    assert len(panels(figure)) == 4
    assert {ax.get_xscale() for ax in panels(figure)} == {"log"}
    save_figure(figure, tmp_path / "picture.png")


def test_the_colours_of_a_map_span_its_values() -> None:
    """Values from 0.40 to 0.53 are no single blue."""
    e = xr.DataArray(np.linspace(0.40, 0.53, 12).reshape(3, 4), dims=("y", "x"), name="restitution_coefficient")
    levels = map_levels(e)
    assert (levels.low, levels.high) == (pytest.approx(0.40), pytest.approx(0.53))
