"""Elastic bodies under a force of any history: no memory, so that all follows from the force at an instant."""

import math

import numpy as np
import pytest

import restitution as rs
from restitution import InputError, Material, PronySeries, indent
from restitution.indentation.panels import PanelSolution, solve_by_panels

# E* = 4 G = 1.
BODY = Material(PronySeries(0.25), math.inf)
# d(F) and the contact radius a(d) from F = 2 int a dd: F = 4/3 d^1.5, F = 2/pi tan(0.8) d^2 and F = 2 R d.
SLOPE = 2.0 / math.pi * math.tan(0.8)
LAWS = {
    "parabola": (rs.Parabola(1.0), lambda f: (0.75 * f) ** (2.0 / 3.0), np.sqrt, 0.4),
    "cone": (rs.Cone(0.8), lambda f: np.sqrt(f / SLOPE), lambda d: SLOPE * d, 1.0 / 3.0),
    "punch": (rs.FlatPunch(0.5), lambda f: f, lambda d: np.where(d > 0.0, 0.5, 0.0), 0.5),
}


def random_program(rng):
    """Straight lines from zero that return, vanish for a moment, stay zero for a while, and jump."""
    size = int(rng.integers(6, 12))
    time = np.concatenate([[0.0], np.cumsum(rng.uniform(0.2, 1.0, size))])
    force = rng.uniform(0.1, 1.0, size + 1) * 10.0 ** rng.uniform(-12.0, 0.0, size + 1)
    force[0], force[1] = 0.0, 1.0
    force[3], force[-3:-1] = 0.0, 0.0
    time[5] = time[4]
    return time, force


@pytest.mark.plain
@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("seed", range(4))
def test_depth_radius_and_work_follow_the_force(name, seed):
    profile, depth, radius, share = LAWS[name]
    rng = np.random.default_rng([seed, 21])
    time, force = random_program(rng)
    result = indent(BODY, profile, time=time, force=force)
    moments = np.sort(rng.uniform(0.0, time[-1], 200))
    expected = depth(np.interp(moments, time, force))
    sample = result.sample(moments)
    assert sample.indentation_depth.values == pytest.approx(expected, rel=1e-9, abs=1e-12)
    assert sample.contact_radius.values == pytest.approx(radius(expected), rel=1e-9, abs=1e-12)
    assert result.max_force == 1.0
    assert result.max_indentation_depth == pytest.approx(depth(1.0), rel=1e-12)
    # int F dd = share F d, with F ~ d^(share/(1 - share)).
    assert result.work == pytest.approx(share * force[-1] * depth(force[-1]), rel=1e-8)
    # From zero, from the zero in between, and after the long one.
    assert result.contact_intervals == pytest.approx(
        np.array([[0.0, time[3]], [time[3], time[-3]], [time[-2], math.inf]])
    )


@pytest.mark.plain
def test_a_round_tip_beside_panels():
    """A sphere, whose depth has no closed form; turning times and rates, too."""
    rng = np.random.default_rng(21)
    time, force = np.arange(8.0), np.append(0.0, rng.uniform(0.2, 1.0, 7))
    result = indent(BODY, rs.Sphere(1.5), time=time, force=force)
    panels = solve_by_panels(
        result.contact.profile, result.contact.reduced_modulus, rs.History.from_points(time, force), "force", 1e-11
    )
    assert isinstance(panels, PanelSolution)
    assert result.turning_times == pytest.approx(panels.turning_times, abs=1e-9)
    moments = np.arange(7.0)[:, None] + rng.uniform(0.01, 0.99, (7, 6))
    sample = result.sample(moments.ravel())
    depth, _, _, radius = panels.at(moments.ravel())
    assert sample.indentation_depth.values == pytest.approx(depth, rel=1e-9)
    ahead, behind = (result.sample(moments.ravel() + h).indentation_depth.values for h in (1e-5, -1e-5))
    assert sample.indentation_velocity.values == pytest.approx((ahead - behind) / 2e-5, rel=1e-4)
    assert sample.contact_radius.values == pytest.approx(radius, rel=1e-9)
    assert result.work == pytest.approx(panels.work, rel=1e-9)
    assert result.dissipated == 0.0
    assert panels.elements.stored == pytest.approx(result.work, rel=1e-8)


@pytest.mark.plain
def test_a_force_that_presses_too_deep_is_refused():
    r = np.linspace(0.0, 1.0, 101)
    with pytest.raises(InputError, match="deeper than"):
        indent(BODY, rs.Tabulated(r, r**2), time=[0.0, 1.0, 2.0, 3.0], force=[0.0, 0.1, 0.05, 1e3])
