"""Cost of an impact: a fault in the control of the elements may leave the errors small and the solver slow."""

import re
from pathlib import Path

import numpy as np
import pytest

from restitution.impact.batch import Batch
from restitution.impact.solution import solve_scaled
from restitution.kernel.outcome import FACTORISATIONS
from restitution.material.conversion import reduced_standard_solid

PAGE = Path(__file__).resolve().parents[2] / "docs" / "theory" / "collocation.md"
ROWS = re.findall(r"^\| \$10\^\{(-\d+)\}\$ \| ([\d.]+) \|$", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE)
N = 2000


@pytest.mark.parametrize(("exponent", "stated"), ROWS)
def test_mean_number_of_factorisations_is_the_stated_one(exponent, stated):
    random = np.random.default_rng(int(exponent) + 100)
    nu, p2, p3 = random.uniform(-0.9, 0.5, N), 10.0 ** random.uniform(-3, 1, N), 10.0 ** random.uniform(-2, 2, N)
    ones = np.ones(N)
    batch = Batch(*reduced_standard_solid(nu, ones, 1.0 / p2, p2 * p3).columns, ones, ones, 0.0 * ones, ones, 1.0)
    counts = solve_scaled(batch.scaled(), 10.0 ** int(exponent))[:, FACTORISATIONS]
    # The mean of the sample has a standard error of 1.2 %.
    assert counts.mean() == pytest.approx(float(stated), rel=0.05)


def test_the_page_states_four_tolerances():
    assert len(ROWS) == 4
