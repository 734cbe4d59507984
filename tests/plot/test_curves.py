from itertools import pairwise

import numpy as np
import pytest

from restitution.plot import style
from restitution.plot.curves import curve_family


@pytest.fixture
def ax():
    with style.context():
        yield style.new_figure(3.0, 3.0).add_subplot()


def test_neighbours_differ_in_colour_and_dashes_and_the_limit_is_thin(ax) -> None:
    x = np.linspace(0.0, 1.0, 5)
    curve_family(ax, x, [x + shift for shift in range(4)], list("abcd"), limit=x - 1.0)
    *family, limit = ax.lines
    for first, second in pairwise(family):
        assert first.get_color() != second.get_color()
        assert first._dash_pattern != second._dash_pattern
    assert limit.get_linewidth() < family[0].get_linewidth()
    assert limit.get_label() == "limit"


def test_missing_label_is_refused(ax) -> None:
    with pytest.raises(ValueError, match="labels has 1 entries: must have 2, one for each curve"):
        curve_family(ax, [0, 1], [[0, 1], [1, 2]], ["a"])
