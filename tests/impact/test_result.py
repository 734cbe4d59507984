"""Results: quantities, history with energies, energy budget, picture."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cases import BALL, RUBBER
from refusals import named
from restitution import Impact, Material, PronySeries, SolverError, Status, solve
from restitution.contact.profiles import Cone, FlatPunch, Parabola, Sphere, TruncatedCone
from restitution.quantities import HISTORY
from scipy_oracle import solve_by_scipy

# Many of these bodies exceed the limits of the theory.
pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")

MIXED = Material(PronySeries(1e6, [3e6, 2e6, 1e6], [1e-6, 1e-3, 1.0], parallel_viscosity=30.0), 2e7)


def test_quantities_are_consistent():
    result = solve(BALL)
    assert result.rebound_velocity == result.restitution_coefficient * 1.0
    assert result.velocity == 1.0
    assert result.max_contact_radius == pytest.approx(math.sqrt(0.01 * result.max_indentation_depth), rel=1e-12)
    assert 0.0 < result.residual_indentation_depth < result.max_indentation_depth
    assert result.impact is BALL
    assert (result.method, result.rtol) == ("exact", 1e-9)
    assert result.status is Status.SEPARATED


def test_dictionary_holds_plain_numbers():
    result = solve(BALL)
    numbers = result.to_dict()
    assert numbers["restitution_coefficient"] == result.restitution_coefficient
    assert numbers["energy"]["dissipated"] == result.energy.dissipated
    assert set(numbers["energy"]) == {"kinetic_in", "kinetic_out", "dissipated", "stored", "radiated", "residual"}
    assert numbers["status"] is Status.SEPARATED
    assert numbers["warnings"] == result.warnings
    floats = [value for value in numbers.values() if isinstance(value, float)]
    assert len(floats) == 10


@pytest.mark.parametrize("method", ["exact", "elements"])
def test_energy_adds_up(method):
    heavy = Impact(RUBBER, Parabola(0.01), 0.005, 1.0, external_force=0.05)
    energy = solve(heavy, method).energy
    assert energy.kinetic_in == 0.0025
    total = energy.kinetic_out + energy.dissipated + energy.stored
    work = (
        0.05
        * solve(BALL.__class__(RUBBER, Parabola(0.01), 0.005, 1.0, external_force=0.05)).residual_indentation_depth
    )
    # Elements: first order.
    tolerance = {"exact": 1e-8, "elements": 5e-3}[method]
    assert total == pytest.approx(energy.kinetic_in + work, rel=tolerance)
    assert energy.residual == pytest.approx(0.0, abs=tolerance)


# History


def test_history_has_units_and_the_ends():
    history, moving = solve(BALL).history, solve(replace(BALL, impedance=10.0)).history
    rough = solve(replace(BALL, friction=0.3, tangential_velocity=0.1)).history
    of_target = {"radiated_energy", "body_velocity", "target_displacement"}
    of_friction = {"contact_point_velocity", "tangential_force", "stick_radius", "slip_velocity"}
    of_adhesion = {"zone_radius", "jump_energy"}
    others = {"time", *of_adhesion}
    assert set(moving.data_vars) == set(HISTORY) - others - of_friction
    assert set(rough.data_vars) == set(HISTORY) - others - of_target
    assert set(history.data_vars) == set(HISTORY) - others - of_target - of_friction
    both = dict(moving.data_vars) | dict(rough.data_vars) | dict(moving.coords)
    shown = HISTORY.keys() - of_adhesion
    assert all(both[name].attrs["units"] == HISTORY[name].unit for name in shown)
    assert all(both[name].attrs["long_name"] for name in shown)
    assert history.time.attrs["units"] == "s"
    assert history.sizes["time"] == 401
    assert history.attrs == {"method": "exact", "rtol": 1e-9}
    result = solve(BALL)
    assert float(history.time[-1]) == result.contact_time
    assert float(history.indentation_velocity[-1]) == -result.rebound_velocity
    assert float(history.force.max()) == pytest.approx(result.max_force, rel=1e-4)


def test_number_of_points_or_given_times():
    result = solve(BALL)
    assert result.sample(n_points=7).sizes["time"] == 7
    times = result.contact_time * np.array([0.3, 0.1])
    assert result.sample(times).time.values.tolist() == times.tolist()
    assert result.sample(times[0]).sizes["time"] == 1
    assert named(lambda: result.sample(n_points=1)) == ("n_points", 1)
    assert named(lambda: result.sample([-1.0])) == ("times", -1.0)


@pytest.mark.parametrize(
    "impact",
    [
        BALL,
        Impact(MIXED, Cone(1.3), 0.005, 1.0),
        Impact(MIXED, FlatPunch(0.002), 0.005, 1.0, external_force=0.05),
        Impact(MIXED, Sphere(0.01), 0.005, 1.0, counter_material=RUBBER),
        Impact(MIXED, TruncatedCone(0.002, 1.3), 0.005, 1.0),
        Impact(Material(PronySeries(0.0, [1e7], [1e-3]), math.inf), Parabola(0.01), 0.005, 1.0),
    ],
    ids=["parabola", "cone", "flat punch with weight", "two bodies", "truncated cone", "liquid"],
)
def test_energies_add_up_at_all_times(impact):
    result = solve(impact)
    history = result.sample(n_points=301)
    assert np.all(np.diff(history.dissipated_energy.values) >= 0.0)
    # A liquid stores almost no energy at the end.
    assert np.all(history.stored_energy.values >= -1e-12 * result.energy.kinetic_in)
    total = history.kinetic_energy + history.stored_energy + history.dissipated_energy
    expected = result.energy.kinetic_in + impact.external_force * history.indentation_depth
    # The interpolated history is some orders of magnitude less accurate than the result.
    assert total.values == pytest.approx(expected.values, abs=1e-7 * result.energy.kinetic_in)
    fine = solve(impact, rtol=1e-12)
    total, energy = fine.sample([0.0, fine.contact_time]), fine.energy
    assert total.kinetic_energy.values == pytest.approx([energy.kinetic_in, energy.kinetic_out], rel=1e-11)
    scale = 1e-9 * energy.kinetic_in
    assert total.stored_energy.values == pytest.approx([0.0, energy.stored], abs=scale)
    assert total.dissipated_energy.values == pytest.approx([0.0, energy.dissipated], abs=scale)


def test_energies_of_a_damped_oscillator():
    """A flat punch on a spring and a dashpot, F = k d + c v, stores k d^2/2 and dissipates the rest."""
    result = solve(
        Impact(Material(PronySeries(1.0, parallel_viscosity=0.1), math.inf), FlatPunch(1.0), 1.0, 1.0), rtol=1e-12
    )
    history = result.sample(n_points=401)
    # k = 8, c = 0.8; at the end the energy stored at separation is counted separately.
    assert history.stored_energy.values[:-1] == pytest.approx(
        4.0 * history.indentation_depth.values[:-1] ** 2, abs=1e-9 * 0.5
    )
    omega, damping = math.sqrt(8.0), 0.4 / math.sqrt(8.0)
    pace = omega * math.sqrt(1.0 - damping**2)
    t = history.time.values
    depth = np.exp(-damping * omega * t) * np.sin(pace * t) / pace
    assert history.indentation_depth.values == pytest.approx(depth, abs=1e-10)


def test_the_history_is_that_of_scipy():
    exact, other = solve(BALL), solve_by_scipy(BALL)
    times = np.linspace(0.05, 0.95, 19) * exact.contact_time
    for name in ("indentation_depth", "indentation_velocity", "force", "contact_radius"):
        expected = exact.sample(times)[name].values
        # Linear interpolation between the steps of SciPy.
        interpolated = np.interp(times, other.time, getattr(other, name))
        assert interpolated == pytest.approx(expected, abs=1e-4 * np.abs(expected).max())


def test_histories_of_elements():
    exact, other = solve(BALL), solve(BALL, "elements", n_elements=200)
    history = other.history
    assert "kinetic_energy" in history
    assert "stored_energy" not in history
    times = np.linspace(0.05, 0.95, 19) * exact.contact_time
    for name in ("indentation_depth", "indentation_velocity", "force"):
        expected = exact.sample(times)[name].values
        assert other.sample(times)[name].values == pytest.approx(expected, abs=1e-2 * np.abs(expected).max())
    assert named(lambda: other.sample([2.0 * exact.contact_time])) == ("times", 2.0 * exact.contact_time)


def test_no_history_of_several_impacts_or_of_a_body_that_stays():
    several = solve(Impact(RUBBER, Parabola(0.01), 0.005, [1.0, 2.0]))
    assert named(lambda: several.history) == ("impact",)
    assert named(lambda: solve([BALL]).history) == ("impact",)
    stays = solve(Impact(Material(PronySeries(0.0, parallel_viscosity=1.0), math.inf), FlatPunch(1.0), 1.0, 1.0))
    with pytest.raises(ValueError, match=r"^contact_time = inf s: must end: .* sinks in"):
        _ = stays.history


def test_picture():
    figure = solve(BALL).plot()
    assert len(figure.axes) == 6


def test_messages_of_statuses_and_failures():
    assert [status.failed for status in Status][:4] == [False, False, False, True]
    assert all(status.message for status in Status)
    error = SolverError(Status.NOT_FINITE, "impact 3 of 7")
    assert error.status is Status.NOT_FINITE
    assert str(error) == f"NOT_FINITE: {Status.NOT_FINITE.message} (impact 3 of 7)"
