"""Families of curves and contour maps."""

from itertools import pairwise

import numpy as np
import pytest

from refusals import in_one_line
from restitution.errors import InputError
from restitution.plot import style
from restitution.plot.style import Shading, contour_map, curve_family

SUM = Shading("sum of both")


@pytest.fixture
def ax():
    with style.context():
        yield style.new_figure(3.0, 3.0).add_subplot()


def test_isolines_lie_where_the_function_has_their_value(ax) -> None:
    x = np.linspace(-1.0, 1.0, 201)
    contour_map(ax, x, x, np.hypot(*np.meshgrid(x, x)), [0.25, 0.5], SUM)
    (lines,) = [part for part in ax.collections if not part.get_rasterized()]
    for radius, path in zip((0.25, 0.5), lines.get_paths(), strict=True):
        # The error of the interpolation within a cell of size h is at most h^2/(8 (r - h)). The ends of the gap for a
        # label lie on a chord of length sqrt(2) h or less, whose sagitta is h^2/(4 r).
        bound = 0.01**2 * (1 / (8 * 0.24) + 1 / (4 * 0.25))
        assert np.hypot(*path.vertices.T) == pytest.approx(radius, abs=bound)


def test_levels_outside_the_data_are_left_out_and_labels_have_the_format(ax) -> None:
    x = np.linspace(0.0, 1.0, 21)
    contour_map(ax, x, x, np.add.outer(x, x), [-1.0, 0.5, 1.5, 7.0], SUM, fmt=lambda level: f"{100 * level:.0f} %")
    assert {text.get_text() for text in ax.texts} == {"50 %", "150 %"}


def test_flat_map_has_no_isolines(ax) -> None:
    contour_map(ax, [0.0, 1.0], [0.0, 1.0], np.ones((2, 2)), [0.5, 1.0], SUM)
    assert all(part.get_rasterized() for part in ax.collections)


def test_transposed_values_are_refused(ax) -> None:
    with pytest.raises(InputError, match=r"\(3, 2\).*\(2, 3\)"):
        contour_map(ax, [0, 1, 2], [0, 1], np.ones((3, 2)), [0.5], SUM)


def test_labels_lie_on_the_isolines_closest_to_the_given_points(ax) -> None:
    x = np.linspace(-1.0, 1.0, 81)
    z = np.hypot(*np.meshgrid(x, x))
    contour_map(ax, x, x, z, [0.4, 0.6, 0.8], SUM, labels_at=[(0.0, 0.41), (-0.59, 0.0), (0.0, -0.79)])
    places = {text.get_text(): np.hypot(*text.get_position()) for text in ax.texts}
    assert places == pytest.approx({"0.4": 0.4, "0.6": 0.6, "0.8": 0.8}, abs=0.02)


def test_colour_bar_has_ticks_for_the_isolines_that_fit(ax) -> None:
    x = np.linspace(0.0, 1.0, 21)
    contour_map(ax, x, x, np.add.outer(x, x), [0.5, 0.502, 1.0], SUM)
    bar = ax.figure.axes[1]
    assert bar.get_ylabel() == "sum of both"
    assert bar.get_yticks().tolist() == [0.502, 1.0]


def test_neighbours_differ_in_colour_and_dashes_and_the_limit_is_thin(ax) -> None:
    x = np.linspace(0.0, 1.0, 50)
    curve_family(ax, x, [x + shift for shift in range(4)], list("abcd"), limit=x - 1.0)
    *family, limit = ax.lines
    for first, second in pairwise(family):
        assert first.get_color() != second.get_color()
        assert first._dash_pattern != second._dash_pattern
    assert limit.get_linewidth() < family[0].get_linewidth()
    assert limit.get_label() == "limit"


def test_labels_lie_on_their_curves_and_do_not_overlap(ax) -> None:
    x = np.linspace(0.0, 1.0, 200)
    rows = [slope * x for slope in (0.1, 0.4, 0.7, 1.0)]
    ax.set_xlim(0.0, 1.0)
    ax.set_ylim(0.0, 1.0)
    curve_family(ax, x, rows, list("abcd"), short=["1", "2", "3", "4"])
    assert sorted(text.get_text() for text in ax.texts) == ["1", "2", "3", "4"]
    boxes = [text.get_window_extent() for text in ax.texts]
    for n, text in enumerate(ax.texts):
        across, up = text.xy
        assert up == pytest.approx(across * (0.1, 0.4, 0.7, 1.0)[int(text.get_text()) - 1])
        assert not any(boxes[n].overlaps(other) for other in boxes[:n])


def test_few_points_have_markers_and_two_no_line(ax) -> None:
    curve_family(ax, [0.0, 1.0], [[0.0, 1.0], [1.0, 2.0]], ["a", "b"])
    assert {line.get_linestyle() for line in ax.lines} == {"None"}
    assert len({line.get_marker() for line in ax.lines}) == 2


def test_missing_label_is_refused(ax) -> None:
    assert in_one_line(lambda: curve_family(ax, [0, 1], [[0, 1], [1, 2]], ["a"])).field == "labels"
