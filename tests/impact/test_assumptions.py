"""Warnings of a result: which number is judged, and that each comes once with the worst one."""

import math

import numpy as np
import pytest

from restitution.contact.flat_ended import FlatEndedParabola
from restitution.contact.power_law import Cone, FlatPunch
from restitution.contact.profile import Parabola
from restitution.contact.sphere import Sphere
from restitution.impact.problem import Impact
from restitution.impact.solve import solve
from restitution.impact.status import Status
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material

SOFT = Material(1e6, math.inf)
HARD = Material(1e9, math.inf)


def test_nothing_to_say():
    assert solve(Impact(HARD, Parabola(0.01), 0.005, 0.1)).warnings == []


@pytest.mark.parametrize("profile", [Parabola, Sphere])
def test_round_bodies_are_judged_by_contact_radius_over_radius(profile):
    result = solve(Impact(SOFT, profile(0.01), 0.005, 5.0))
    ratio = result.max_contact_radius / 0.01
    assert ratio > 0.2
    assert result.warnings == [
        f"small strain: contact radius over R reaches {ratio:.3g} (> 0.2), "
        f"representative strain about {20 * ratio:.2g} %"
    ]


@pytest.mark.parametrize("profile", [Cone(1.2), FlatPunch(1e-3), FlatEndedParabola(0.01, 1e-3)])
def test_other_bodies_are_judged_by_depth_over_contact_radius(profile):
    result = solve(Impact(SOFT, profile, 0.005, 1.0))
    ratio = result.max_indentation_depth / result.max_contact_radius
    assert ratio > 0.2
    (warning,) = result.warnings
    assert f"depth over contact radius reaches {ratio:.3g} (> 0.2)" in warning


def test_worst_of_an_array_and_of_radii():
    result = solve(Impact(SOFT, Parabola([[0.01], [0.02]]), 0.005, [0.1, 5.0]))
    worst = np.max(result.max_contact_radius / [[0.01], [0.02]])
    assert [f"{worst:.3g} (> 0.2)" in warning for warning in result.warnings] == [True]


def test_slowest_wave_of_both_bodies():
    # sqrt(1e6/1000) = 31.6 m/s against sqrt(1e9/1000) = 1000 m/s
    light, heavy = (Material(modulus, math.inf, density=1000.0) for modulus in (1e6, 1e9))
    for pair in ((light, heavy), (heavy, light)):
        result = solve(Impact(pair[0], Parabola(0.1), 1e-3, 0.5, counter_material=pair[1]))
        (warning,) = result.warnings
        assert warning.startswith("quasi-static: velocity over wave speed is 0.0158 (> 0.01)")
    assert solve(Impact(heavy, Parabola(0.1), 1e-3, 0.5, counter_material=HARD)).warnings == []


def test_a_list_is_warned_about_once_for_each_measure():
    waves = Material(1e6, math.inf, density=1000.0)
    impacts = [
        Impact(HARD, Parabola(0.01), 0.005, 0.1),
        Impact(SOFT, Parabola(0.01), 0.005, 5.0),
        Impact(SOFT, Parabola(0.01), 0.005, 7.0),
        Impact(SOFT, Cone(1.2), 0.005, 1.0),
        Impact(waves, Parabola(0.1), 1e-3, 0.5),
    ]
    result = solve(impacts)
    radius, depth, waves_found = result.warnings
    assert f"{result.max_contact_radius[2] / 0.01:.3g} (> 0.2)" in radius
    assert f"{result.max_indentation_depth[3] / result.max_contact_radius[3]:.3g} (> 0.2)" in depth
    assert "0.0158" in waves_found


def test_bodies_that_sink_in_have_no_depth_to_judge():
    result = solve(
        Impact(Material(PronySeries(0.0, parallel_viscosity=1.0), math.inf), FlatPunch(1.0), 1.0, 1.0)
    )
    assert result.status is Status.SINKS_IN
    assert result.warnings == []


@pytest.mark.parametrize("method", ["elements", "reference"])
def test_other_methods_warn_as_well(method):
    result = solve(Impact(SOFT, Parabola(0.01), 0.005, 5.0), method)
    assert [line for line in result.warnings if line.startswith("small strain: ")]
    assert len(result.warnings) == (2 if method == "reference" else 1)
    if method == "reference":
        assert result.warnings[1].startswith("energy: ")
        assert math.isnan(result.energy.residual)
