"""The motion obeys the equations between the steps of the solver."""

import math

import numpy as np
import pytest

from refusals import named
from restitution import Cone, FlatPunch, Impact, Material, Parabola, PronySeries, Sphere, solve, standard_solid
from restitution.errors import InputError

SOLID = standard_solid(1.0, 10.0, 1.0, poisson_ratio=0.3)
MIXED = Material(PronySeries(1.0, [3.0, 2.0], [1e-4, 0.5], parallel_viscosity=0.05), 2.0)


def dense(material=SOLID, profile=None, rtol=1e-12, **options):
    result = solve(Impact(material, profile or Parabola(1.0), 1.0, 1.0, **options), rtol=rtol)
    return result, result._solution


@pytest.mark.parametrize("profile", [Parabola(1.0), Cone(1.1), FlatPunch(0.5), Sphere(2.0)])
@pytest.mark.parametrize("force", [0.0, 0.2])
def test_motion_is_newtons_law(profile, force):
    """m dv = (F0 - F) dt and dd = v dt, by Gauss quadrature between neighbouring times."""
    result, output = dense(MIXED, profile, external_force=force)
    turn = output.turning_time
    nodes, weights = np.polynomial.legendre.leggauss(12)
    # As a function of the root of time from both ends the force is smooth.
    for low, high, time in (
        (0.0, math.sqrt(turn), lambda y: y**2),
        (0.0, math.sqrt(result.contact_time - turn), lambda y: result.contact_time - y**2),
    ):
        y = np.linspace(low, high, 41)[:, None]
        inner = y[:-1] + 0.5 * np.diff(y, axis=0) * (nodes + 1.0)
        weight = 0.5 * np.diff(y, axis=0) * weights * 2.0 * inner
        if time(0.0) > 0.0:
            weight = -weight
        ends = output.at(time(y[:, 0]))
        moving = output.at(time(inner.ravel()))
        push = np.sum(weight * (force - moving.force.reshape(inner.shape)), axis=1)
        assert np.diff(ends.indentation_velocity) == pytest.approx(push, abs=2e-9)
        sunk = np.sum(weight * moving.indentation_velocity.reshape(inner.shape), axis=1)
        assert np.diff(ends.indentation_depth) == pytest.approx(sunk, abs=2e-9)


def test_ends_and_turning_point_of_the_history():
    result, output = dense(rtol=1e-9)
    start, turn, end = (output.at([t]) for t in (0.0, output.turning_time, output.contact_time))
    assert start.indentation_depth[0] == start.force[0] == start.contact_radius[0] == 0.0
    assert start.indentation_velocity[0] == 1.0
    assert turn.indentation_velocity[0] == pytest.approx(0.0, abs=1e-9)
    assert turn.indentation_depth[0] == pytest.approx(result.max_indentation_depth, rel=1e-12)
    assert turn.contact_radius[0] == pytest.approx(result.max_contact_radius, rel=1e-9)
    assert output.contact_time == result.contact_time
    assert end.indentation_velocity[0] == pytest.approx(-result.restitution_coefficient, rel=1e-12)
    assert end.indentation_depth[0] == pytest.approx(result.residual_indentation_depth, rel=1e-12)
    assert end.contact_radius[0] == end.force[0] == 0.0


def test_contact_radius_belongs_to_the_depth_in_the_approach_only():
    _, output = dense()
    coming = output.at(np.linspace(0.0, output.turning_time, 50))
    assert coming.contact_radius == pytest.approx(np.sqrt(coming.indentation_depth), abs=1e-9)
    going = output.at(np.linspace(1.1 * output.turning_time, output.contact_time, 50))
    assert np.all(going.contact_radius < np.sqrt(going.indentation_depth))
    assert np.all(np.diff(going.contact_radius) < 0.0)


def test_default_times_span_the_contact_and_resolve_a_thin_layer():
    # The layer at the turning point has the width of the short relaxation time, 1e-5 of the contact.
    result, output = dense(Material(PronySeries(1.0, [1e5], [1e-5]), math.inf))
    times = output.times(200)
    assert times[0] == 0.0
    assert times[-1] == result.contact_time
    assert np.all(np.diff(times) > 0.0)
    assert np.count_nonzero(np.abs(times - output.turning_time) < 1e-3 * result.contact_time) > 2


def test_order_and_repetition_of_times_are_kept():
    _, output = dense()
    times = np.array([0.5, 0.1, 0.5, 0.9]) * output.contact_time
    result = output.at(times)
    assert result.time.tolist() == times.tolist()
    assert result.indentation_velocity[0] == result.indentation_velocity[2]
    assert output.at(times[1]).indentation_velocity[0] == result.indentation_velocity[1]


def test_times_outside_the_contact_are_refused():
    _, output = dense()
    duration = output.contact_time
    with pytest.raises(
        InputError, match=rf"^times = .* s: must be in \[0, {duration:g}\] s, the duration of contact$"
    ):
        output.at([0.0, 1.001 * duration])
    assert named(lambda: output.at([0.0, -0.1 * duration])) == ("times", -0.1 * duration)
    assert named(lambda: output.at([0.0, math.nan])) == ("times", 1, math.nan)
