import numpy as np
import pytest

from restitution.plot import style
from restitution.plot.contours import contour_map


@pytest.fixture
def ax():
    with style.context():
        yield style.new_figure(3.0, 3.0).add_subplot()


def test_isolines_lie_where_the_function_has_their_value(ax) -> None:
    x = np.linspace(-1.0, 1.0, 201)
    contour_map(ax, x, x, np.hypot(*np.meshgrid(x, x)), [0.25, 0.5], fill=[0.0, 0.25, 0.5, 1.5])
    (lines,) = [part for part in ax.collections if not part.get_rasterized()]
    for radius, path in zip((0.25, 0.5), lines.get_paths(), strict=True):
        # Linear interpolation on a grid of spacing h is off by h^2/(8 r) at most.
        assert np.hypot(*path.vertices.T) == pytest.approx(radius, abs=0.01**2 / (8 * 0.24))


def test_levels_out_of_reach_are_left_out_and_labels_follow_the_format(ax) -> None:
    x = np.linspace(0.0, 1.0, 21)
    contour_map(ax, x, x, np.add.outer(x, x), [-1.0, 0.5, 1.5, 7.0], fmt=lambda level: f"{100 * level:.0f} %")
    assert {text.get_text() for text in ax.texts} == {"50 %", "150 %"}


def test_flat_map_has_no_isolines(ax) -> None:
    contour_map(ax, [0.0, 1.0], [0.0, 1.0], np.ones((2, 2)), [0.5, 1.0])
    assert len(ax.collections) == 0


def test_transposed_values_are_refused(ax) -> None:
    with pytest.raises(ValueError, match=r"z has shape \(3, 2\): must be \(len\(y\), len\(x\)\) = \(2, 3\)"):
        contour_map(ax, [0, 1, 2], [0, 1], np.ones((3, 2)), [0.5])
