"""Profiles from a table end as the closed form does, also where the first table turns out too short."""

import math

import numpy as np
import pytest

from restitution.contact.profile import Parabola
from restitution.contact.tabulated import Tabulated
from restitution.impact.problem import Impact
from restitution.impact.solve import solve
from restitution.impact.status import Status
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material

RADII = np.linspace(0.0, 50.0, 101)
TABLE = Tabulated(RADII, RADII**2 / 2.0)


# Creep under the weight takes these far beyond the depth that the impact alone would reach.
@pytest.mark.parametrize(
    ("series", "force", "status"),
    [
        (PronySeries(0.01, [40.0], [0.01], viscosity=5.0), 3.0, Status.CAPTURED),
        (PronySeries(0.0, viscosity=0.5), 1.0, Status.SINKS_IN),
        (PronySeries(0.0, [0.5], [0.03], viscosity=3.0), 0.1, Status.SINKS_IN),
        (PronySeries(1.0, [3.0], [0.5]), 0.3, Status.SEPARATED),
    ],
)
def test_same_ending_under_a_weight(series, force, status):
    table, parabola = (
        solve(Impact(Material(series, math.inf), profile, 1.0, 1.0, force=force))
        for profile in (TABLE, Parabola(1.0))
    )
    assert table.status is parabola.status is status
    assert table.restitution_coefficient == pytest.approx(parabola.restitution_coefficient, rel=2e-8)
