"""Bodies that do not rebound, in pictures of e: gaps of curves, the band of the threshold, areas of maps."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.collections import QuadMesh
from matplotlib.patches import Rectangle

import restitution as rs
from commands import done
from restitution.plot.rebounds import plot_restitution
from restitution.plot.sticking import broken, draw_area, threshold
from restitution.plot.style import new_figure
from restitution.sweeps.run import run

pytestmark = pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning")
# An elastic ball, row A6 of the prototype.
ELASTIC = rs.Material(rs.PronySeries(0.25, [], []), bulk=np.inf)
BALL = rs.Impact(ELASTIC, rs.Parabola(1.0), 1.0, 0.1, adhesion=rs.Adhesion(0.01, 0.157768))
SPEEDS = np.geomspace(0.02, 0.3, 9)


def band(ax):
    """Ends of the band of an axes."""
    (patch,) = [each for each in ax.patches if isinstance(each, Rectangle)]
    return patch.get_x(), patch.get_x() + patch.get_width()


def test_curves_have_a_gap_where_bodies_begin_to_rebound():
    places, rows = broken([1.0, 4.0, 9.0, 16.0], [[0.0, 0.0, 0.4, 0.6], [0.2, 0.4, 0.6, 0.8]], logarithmic=True)
    assert places.tolist() == [1.0, 4.0, 6.0, 9.0, 16.0]
    assert rows[0, [0, 1, 3, 4]].tolist() == [0.0, 0.0, 0.4, 0.6]
    assert np.isnan(rows[0, 2])
    # The other curve keeps its line.
    assert rows[1].tolist() == [0.2, 0.4, 0.5, 0.6, 0.8]
    # A failed solve makes no gap of its own.
    assert broken([1.0, 2.0], [[np.nan, 0.4]])[0].tolist() == [1.0, 2.0]


def test_the_threshold_lies_between_neighbours():
    assert threshold([1.0, 2.0, 3.0, 4.0], [0.0, np.nan, 0.3, 0.4]) == (1.0, 3.0)
    assert threshold([1.0, 2.0], [0.1, 0.2]) is None
    assert threshold([1.0, 2.0, 3.0], [0.0, 0.2, 0.0]) is None


def test_pictures_of_velocities_have_the_sticking_velocity():
    # An elastic ball sticks below the energy that a fast one loses in its jumps.
    sticks = np.sqrt(2.0 * rs.solve(replace(BALL, velocity=0.3), rtol=1e-4).radiated_energy)
    result = rs.solve(replace(BALL, velocity=SPEEDS), rtol=1e-3)
    swept = rs.sweep(BALL, {"velocity": rs.Logarithmic(0.02, 0.3, 9)}, ["restitution_coefficient"], rtol=1e-3)
    figures = result.plot(), rs.plot_sweep(swept), plot_restitution(BALL, velocity=SPEEDS)
    for figure in figures:
        ax = figure.axes[0]
        low, high = band(ax)
        # The first axis of each may have a prefix.
        factor = 1e3 if "mm/s" in ax.get_xlabel() else 1.0
        assert low < factor * sticks < high
        assert low / high == pytest.approx(SPEEDS[0] / SPEEDS[1], rel=1e-9)
        assert any(text.get_text().startswith("threshold") for text in ax.get_legend().get_texts())
        assert np.isnan(ax.lines[0].get_ydata()).sum() == 1


def test_points_of_more_than_the_velocity_have_no_band():
    result = rs.solve(rs.vary(BALL, {"velocity": SPEEDS[::4], "work": [[0.005], [0.01]]}), rtol=1e-3)
    figure = result.plot()
    assert not figure.axes[0].patches
    assert figure.axes[0].lines[0].get_linestyle() == "None"


def test_a_map_shades_where_bodies_stick():
    axes = {"velocity": rs.Logarithmic(0.02, 0.3, 5), "work": rs.Linear(0.002, 0.02, 4)}
    swept = rs.sweep(BALL, axes, ["restitution_coefficient"], rtol=1e-3)
    figure = rs.plot_sweep(swept, y="work")
    stays = swept.status.transpose("work", "velocity").values == rs.Status.CAPTURED
    assert stays.any()
    assert not stays.all()
    cells = [np.any(stays[row : row + 2, n : n + 2]) for row in range(3) for n in range(4)]
    shaded = figure.axes[0].collections[0]
    assert isinstance(shaded, QuadMesh)
    assert np.ma.getmaskarray(shaded.get_array()).ravel().tolist() == [not cell for cell in cells]
    assert "no rebound" in [text.get_text() for text in figure.axes[0].texts]


def test_one_body_that_sticks_shades_all_cells_around_it():
    e = np.full((3, 4), 0.5)
    e[1, 1] = 0.0
    ax = draw_area(new_figure().add_subplot(), [1.0, 2.0, 3.0, 4.0], [1.0, 2.0, 3.0], e)
    shaded = ~np.ma.getmaskarray(ax.collections[0].get_array()).reshape(2, 3)
    assert shaded.tolist() == [[True, True, False], [True, True, False]]
    assert ax.texts[0].xy == (2.0, 2.0)


def test_a_map_of_a_case_needs_no_tolerance(tmp_path, monkeypatch):
    case = tmp_path / "grain.toml"
    case.write_text("""
    [body]
    density = "2 g/cm^3"
    radius = "1 um"
    [material]
    model = "elastic"
    youngs_modulus = "1 GPa"
    poisson_ratio = 0.3
    [adhesion]
    work = "50 mJ/m^2"
    [impact]
    velocity = 1
    material_of = "body"
    """)
    picture = tmp_path / "map.png"
    options = ["--x", "velocity=0.03:3", "--y", "radius=0.5um:5um", "--points", "3", "--out", str(picture)]
    tolerances = []

    def watched(plan, **more):
        tolerances.append(plan.rtol)
        return run(plan, **more)

    monkeypatch.setattr("restitution.sweeps.run.run", watched)
    done("map", str(case), *options)
    assert tolerances == [1e-3]
    assert picture.stat().st_size > 0
