"""Modes of any strength that are much faster than the contact: the tolerance holds."""

import math

import numpy as np
import pytest

from restitution.contact.power_law import Cone
from restitution.contact.profile import Parabola
from restitution.impact.problem import Impact
from restitution.impact.solve import solve
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material

# Many of these bodies exceed the limits of the theory.
pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")


@pytest.fixture(scope="module")
def impacts() -> list[Impact]:
    rng = np.random.default_rng(0)
    drawn: list[Impact] = []
    for n in range(500):
        count = rng.integers(1, 8)
        series = PronySeries(
            10 ** rng.uniform(-2, 1), 10 ** rng.uniform(-1, 2.5, count), 10 ** rng.uniform(-6, -1, count)
        )
        profile = Parabola(1.0) if n % 2 else Cone(1.1)
        drawn.append(Impact(Material(series, math.inf), profile, 1.0, 1.0))
    return drawn


def test_tolerance_is_kept(impacts):
    loose, fine, finest = (solve(impacts, rtol=rtol).restitution_coefficient for rtol in (1e-9, 1e-11, 1e-12))
    scale = np.maximum(finest, 1e-3)
    # If Newton's method updated the fast modes only once per step, the errors would be 4 and 8 tolerances.
    assert np.max(np.abs(loose - finest) / scale) < 1e-9
    assert np.max(np.abs(fine - finest) / scale) < 2e-11


@pytest.mark.slow
def test_against_another_integrator(impacts):
    for impact in impacts[:2]:
        wanted = solve(impact, "reference", rtol=1e-10).restitution_coefficient
        assert solve(impact).restitution_coefficient == pytest.approx(wanted, rel=2e-9)
