"""Adhesive indentations: Maugis' closed forms, limits of slow and fast pulls, dwell, energy, refusals."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import restitution as rs
from refusals import in_one_line
from restitution.contact.adhesion import static_contact

TIP = rs.Parabola(1.0)


def solid(moduli=(), times=(), equilibrium=1.0):
    """Material with the reduced modulus equilibrium + sum of moduli exp(-t/times)."""
    return rs.Material(
        rs.PronySeries(0.25 * equilibrium, 0.25 * np.asarray(moduli, dtype=float), times), bulk=math.inf
    )


def pull(material, adhesion, speed, dwell=0.0, retreat=None, **options):
    """A tip that comes to a depth of 0.1, waits, and goes far away."""
    start, far, back = -0.2, -1.0, retreat or speed
    knots = np.cumsum([0.0, (0.1 - start) / speed, dwell, (0.1 - far) / back])
    depth = np.array([start, 0.1, 0.1, far])
    keep = np.append(True, np.diff(knots) > 0.0)
    return rs.indent(material, TIP, depth=depth[keep], time=knots[keep], adhesion=adhesion, **options)


def static_pull(modulus, adhesion):
    """Largest pull at rest."""
    return -minimize_scalar(
        lambda a: static_contact(TIP, modulus, adhesion, a).force, bounds=(1e-4, 0.6), method="bounded"
    ).fun


def test_an_elastic_indentation_follows_maugis():
    adhesion = rs.Adhesion(0.01, 0.157768)
    result = pull(solid(), adhesion, 1.0, rtol=1e-5)
    assert result.pull_off_force == pytest.approx(static_pull(1.0, adhesion), rel=2e-5)
    a, c = result.contact_radius, result.zone_radius
    touching = a > 0.1
    a, c = a[touching], c[touching]
    root = np.sqrt((c - a) * (c + a))
    exact = 4.0 / 3.0 * a**3 - 2.0 * 0.157768 * (c * c * np.arccos(a / c) + a * root)
    assert result.force[touching] == pytest.approx(exact, abs=1e-3 * result.max_force)
    assert result.status.name == "SEPARATED"
    # The work of one cycle is what the jumps lose.
    assert result.work == pytest.approx(result.radiated, rel=1e-3)
    assert abs(result.dissipated) < 1e-3 * result.radiated


def test_slow_and_fast_pulls_are_elastic_and_between_them_the_pull_is_larger():
    # The instants of loading and opening: both slow, both fast, and one relaxation time each.
    material, adhesion = solid([4.0], [1.0]), rs.Adhesion(0.01, 0.3)
    # The slow one relaxes within a cell of the elements, which takes finer ones than its force needs here.
    speeds = (1e-5, 1e-2), (0.05, 1e-4), (1e3, 1e-4)
    slow, middle, fast = (pull(material, adhesion, speed, rtol=rtol).pull_off_force for speed, rtol in speeds)
    assert slow == pytest.approx(static_pull(1.0, adhesion), rel=0.02)
    assert fast == pytest.approx(static_pull(5.0, adhesion), rel=0.02)
    assert middle > 1.3 * max(slow, fast)


def test_the_pull_rises_with_dwell():
    # A relaxed contact is opened at the modulus of the glass.
    material, adhesion = solid([4.0], [1.0]), rs.Adhesion(0.01, 0.3)
    pulls = [pull(material, adhesion, 10.0, dwell, rtol=1e-3).pull_off_force for dwell in (0.0, 0.3, 3.0)]
    assert 1.1 * pulls[0] < pulls[1]
    assert 1.1 * pulls[1] < pulls[2]


def test_energy_that_is_dissipated_is_that_of_the_elements():
    result = pull(solid([4.0, 2.0], [1.0, 0.1]), rs.Adhesion(0.02, 0.4), 0.1, 0.5, rtol=1e-4)
    assert result.dissipated == pytest.approx(float(result._march.motion[-1, 6]), rel=3e-3)
    assert sum(jump.energy for jump in result.jumps) == pytest.approx(result.radiated)


def test_a_contact_that_lasts_has_no_end():
    result = rs.indent(
        solid([4.0], [1.0]), TIP, depth=[-0.2, 0.1, 0.1], time=[0.0, 1.0, 3.0], adhesion=rs.Adhesion(0.01, 0.3),
        rtol=1e-3,
    )  # fmt: skip
    assert result.status.name == "IN_CONTACT"
    assert math.isinf(result.contact_end_time)
    assert float(result.sample([2.0]).indentation_depth[0]) == pytest.approx(0.1)
    assert "largest pull" in str(result.summary())
    assert result.plot().axes


def test_what_the_theory_does_not_have_is_refused():
    material, adhesion = solid([4.0], [1.0]), rs.Adhesion(0.01, 0.3)
    line = {"depth": [-0.2, 0.1], "time": [0.0, 1.0]}
    near = {"depth": [0.0, 0.1], "time": [0.0, 1.0]}
    for field, options in (
        ("depth", near),
        ("depth", {"depth": [-0.2, -0.1], "time": [0.0, 1.0]}),
        ("depth", {"depth": rs.sine_arch(0.1, 1.0)}),
        ("force", {"force": [0.0, 0.1], "time": [0.0, 1.0]}),
        ("spring_constant, surface", line | {"spring_constant": 1.0}),
        ("adhesion", line | {"adhesion": 0.05}),
        ("adhesion", line | {"adhesion": rs.Adhesion([0.01, 0.02])}),
    ):
        error = in_one_line(lambda options=options: rs.indent(material, TIP, **{"adhesion": adhesion} | options))
        assert error.field == field
    assert in_one_line(lambda: rs.indent(material, rs.Pyramid(1.2), adhesion=adhesion, **line)).field == "profile"
    result = pull(material, adhesion, 1.0, rtol=1e-3)
    assert in_one_line(result.surface).field == "adhesion"
