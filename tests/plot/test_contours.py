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
    contour_map(ax, x, x, np.hypot(*np.meshgrid(x, x)), [0.25, 0.5], cmap=style.SEQUENTIAL)
    (lines,) = [part for part in ax.collections if not part.get_rasterized()]
    for radius, path in zip((0.25, 0.5), lines.get_paths(), strict=True):
        # Across a cell of size h the interpolation is off by h^2/(8 (r - h)) at most; the ends of a label's
        # gap lie on a chord of length sqrt(2) h at most, which sags by h^2/(4 r).
        bound = 0.01**2 * (1 / (8 * 0.24) + 1 / (4 * 0.25))
        assert np.hypot(*path.vertices.T) == pytest.approx(radius, abs=bound)


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


def cone(n: int = 81):
    x = np.linspace(-1.0, 1.0, n)
    return x, x, np.hypot(*np.meshgrid(x, x))


def test_labels_lie_where_isolines_cross_the_given_lines(ax) -> None:
    contour_map(
        ax, *cone(), [0.4, 0.6, 0.8], label_along=[((0.0, 0.0), (0.0, 1.0)), ((0.0, 0.0), (-1.0, 0.0))]
    )
    places = {(text.get_text(), *np.round(text.get_position(), 2).tolist()) for text in ax.texts}
    assert places == {(f"{r}", x * r, y * r) for r in (0.4, 0.6, 0.8) for x, y in ((0.0, 1.0), (-1.0, 0.0))}


def test_labels_stay_clear_of_each_other_and_of_the_frame(ax) -> None:
    levels = np.round(np.arange(0.02, 1.0, 0.02), 2).tolist()
    contour_map(
        ax, *cone(), [*levels[::8], 0.99], label_along=[((0.0, 0.0), (0.0, 1.0)), ((0.0, 0.0), (0.1, 1.0))]
    )
    boxes = [text.get_window_extent() for text in ax.texts]
    assert len(boxes) >= 5
    frame = ax.get_window_extent()
    for n, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[:n])
        assert frame.containsx(box.x0)
        assert frame.containsy(box.y1)


def test_crowded_isoline_still_gets_a_label(ax) -> None:
    contour_map(ax, *cone(), [0.5, 0.51, 0.52], label_along=[((0.0, 0.0), (0.0, 1.0))])
    assert {text.get_text() for text in ax.texts} == {"0.5", "0.51", "0.52"}


def test_labels_of_values_with_gaps(ax) -> None:
    x, y, z = cone()
    contour_map(
        ax, x, y, np.where(y[:, None] > 0.0, z, np.nan), [0.5], label_along=[((0.0, -1.0), (0.0, 1.0))]
    )
    ((_, y_label),) = [text.get_position() for text in ax.texts]
    assert y_label == pytest.approx(0.5, abs=0.01)


def test_labels_that_find_their_own_place_stay_within_the_frame(ax) -> None:
    # Isolines that leave through the corners, where there is no room for a label, and long ones.
    x = np.linspace(0.0, 1.0, 31)
    levels = np.round(np.arange(0.02, 2.0, 0.04), 2).tolist()
    contour_map(ax, x, x, np.add.outer(x, x), levels)
    frame = ax.get_window_extent()
    boxes = [text.get_window_extent() for text in ax.texts]
    assert len(boxes) > 25
    for box in boxes:
        assert frame.x0 < box.x0 < box.x1 < frame.x1
        assert frame.y0 < box.y0 < box.y1 < frame.y1


def test_what_the_given_lines_do_not_cross_is_labelled_too(ax) -> None:
    x = np.linspace(-2.0, 2.0, 81)
    two = np.minimum(np.hypot(*np.meshgrid(x + 1.0, x)), np.hypot(*np.meshgrid(x - 1.0, x)))
    contour_map(ax, x, x, two, [0.5], label_along=[((1.0, 0.0), (1.0, 1.0))])
    (first, second) = sorted(text.get_position()[0] for text in ax.texts)
    assert second == pytest.approx(1.0, abs=0.01)
    assert -1.5 <= first <= -0.5
