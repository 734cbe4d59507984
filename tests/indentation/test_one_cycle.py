"""One approach and one release by panels, against Lee, Radok and Ting by the kernel of one cycle."""

import math

import numpy as np
import pytest

import restitution as rs
from restitution.indentation.panels import PanelSolution, solve_by_panels
from restitution.indentation.solve import Solution, contact_of
from restitution.kernel.driver import FREE, RECORDS

PROFILES = [
    rs.Parabola(1e-2), rs.Cone(0.5), rs.Sphere(1e-2), rs.PowerLaw(3.0, 1e-4), rs.PowerLaw(0.7, 1.0), rs.Pyramid(1.2),
    rs.TruncatedCone(0.5, 1e-5), rs.FlatPunch(1e-3),
]  # fmt: skip
PEAK = 1e-4


def material_of(rng, dashpot=0.0):
    """A solid or a liquid of up to ten terms over three decades."""
    count = int(rng.integers(1, 11))
    series = rs.PronySeries(
        1e6 * float(rng.random() < 0.75), 1e6 * 10.0 ** rng.uniform(-1.0, 1.0, count),
        np.sort(10.0 ** rng.uniform(-1.5, 1.5, count)), parallel_viscosity=1e6 * dashpot,
    )  # fmt: skip
    return rs.Material(series, math.inf)


def history_of(rng, peak, shape):
    up, down, rest = rng.uniform(0.1, 1.5, 3)
    if shape == "triangle":
        return rs.triangle(peak, up, unloading_time=down)
    if shape == "trapezoid":
        return rs.triangle(peak, up, unloading_time=down, hold_time=rest)
    if shape == "arch":
        return rs.sine_arch(peak, up)
    if shape == "bell":
        return rs.History.from_function(lambda t: peak * np.sin(math.pi * t / up) ** 2, [0.0, up])
    # One fast retraction, which leaves a tip in front of the surface.
    return rs.History.from_points([0.0, up, up + 0.05 * down, up + down], [0.0, peak, -0.2 * peak, -0.3 * peak])


def both(material, profile, history, name, rtol):
    """The solution by the kernel of one cycle, and that by panels."""
    contact = contact_of(material, profile, None)
    series = contact.reduced_modulus
    return Solution(contact, series, history, name, rtol), solve_by_panels(profile, series, history, name, rtol)


def difference(cycle, panels, column):
    """Largest difference over the largest value."""
    times = np.linspace(cycle.history.start, cycle.history.stop, 211)
    expected, result = cycle.at(times)[column], panels.at(times)[column]
    return np.abs(result - expected).max() / np.abs(expected).max()


def steps(panels: PanelSolution, phase: int | None = None) -> int:
    records, size = panels._room.records, panels._room.places[RECORDS]
    return int(size if phase is None else np.count_nonzero(records.phase[:size] == phase))


@pytest.mark.parametrize("rtol", [1e-4, 1e-8, 1e-10, 1e-11])
@pytest.mark.parametrize("seed", range(16))
def test_forces_under_a_depth(seed, rtol):
    """Both kernels promise rtol; errors of the tables of profiles are common to both."""
    rng = np.random.default_rng([41, seed])
    profile, shape = PROFILES[seed % 8], ["triangle", "trapezoid", "arch", "bell", "pull"][rng.integers(5)]
    cycle, panels = both(material_of(rng), profile, history_of(rng, PEAK, shape), "depth", rtol)
    assert difference(cycle, panels, 2) <= 2.0 * rtol
    assert panels.end_time == pytest.approx(cycle.end_time, rel=1e-9)


def test_a_front_that_is_no_polynomial_where_the_depth_is():
    """y = sqrt(d) of a ramp: what the panel has between the nodes counts when the contact shrinks."""
    # A pyramid under a trapezoid, which once had an error of 3e-7 of the force at rtol = 1e-10.
    series = rs.PronySeries(1e6, [113850.28, 193050.63, 590635.44], [0.15947463, 0.87135713, 8.10436493])
    history = rs.History.from_points([0.0, 0.2115123, 1.24564173, 1.97963609], [0.0, PEAK, PEAK, 0.0])
    cycle, panels = both(rs.Material(series.scaled(0.25), math.inf), rs.Pyramid(1.2), history, "depth", 1e-10)
    assert difference(cycle, panels, 2) <= 2e-10


@pytest.mark.parametrize("seed", range(12))
def test_smooth_depths_on_a_dashpot(seed):
    """Rates of fitted functions jump by rounding at knots, and loads of the dashpot with them."""
    rng = np.random.default_rng([43, seed])
    material = material_of(rng, 0.3 * 10.0 ** rng.uniform(-2.0, 0.0))
    profile = [rs.Parabola(1e-2), rs.Cone(0.5), rs.Sphere(1e-2)][seed % 3]
    cycle, panels = both(material, profile, history_of(rng, PEAK, ["arch", "bell"][seed % 2]), "depth", 1e-8)
    assert difference(cycle, panels, 2) <= 2e-8
    assert panels.end_time == pytest.approx(cycle.end_time, rel=1e-9)


@pytest.mark.parametrize("shape", ["triangle", "trapezoid"])
@pytest.mark.parametrize("profile", [rs.Parabola(1e-2), rs.Cone(0.5), rs.Sphere(1e-2)], ids=lambda p: type(p).__name__)
def test_a_force_that_falls_to_zero_ends_the_contact(profile, shape):
    """The depth that is left is a power of the force, and its steps do not become shorter and shorter."""
    rng = np.random.default_rng(44)
    for _ in range(5):
        history = history_of(rng, 1.0, shape)
        cycle, panels = both(material_of(rng), profile, history, "force", 1e-8)
        assert difference(cycle, panels, 0) <= 3e-8
        assert panels.end_time == history.stop
        assert steps(panels) <= 60


@pytest.mark.parametrize("rtol", [1e-4, 1e-8])
@pytest.mark.parametrize("tau", [0.1, 0.01, 1e-3, 1e-4])
def test_elements_of_a_relaxed_liquid_leave_at_one_moment(tau, rtol):
    """A Maxwell liquid under a cone: exp(-x) = 1/2 + O(exp(-1/tau)) at the end, x after the turning over tau."""
    material = rs.Material(rs.PronySeries(0.0, [1.0], [tau]), math.inf)
    cycle, panels = both(material, rs.Cone(1.0), rs.triangle(1.0, 1.0), "depth", rtol)
    # The load at the axis changes by its own size within tau.
    assert panels.end_time == pytest.approx(1.0 + tau * math.log(2.0 - math.exp(-1.0 / tau)), abs=rtol * tau)
    assert difference(cycle, panels, 2) <= rtol
    times = 1.0 + (cycle.end_time - 1.0) * np.linspace(0.0, 1.0, 101)[:-1]
    assert np.abs(cycle.at(times)[2] - panels.at(times)[2]).max() <= rtol * cycle.at([1.0])[2][0]


def test_a_free_body_flies_in_few_steps():
    """Loads of a contact that has ended, and of one that has not begun, do not count."""
    series = rs.PronySeries(1e6, [3e6, 2e6], [1e-3, 0.1])
    history = rs.History.from_points([0.0, 5.0, 6.0, 6.5, 20.0], [-5 * PEAK, -PEAK, PEAK, -PEAK, -3 * PEAK])
    _, panels = both(rs.Material(series, math.inf), rs.Parabola(1e-2), history, "depth", 1e-8)
    assert steps(panels, FREE) <= 10


def test_a_function_that_begins_flat_has_no_slope_of_rounding():
    for duration in (0.3, 1.0, 1.7):
        history = rs.History.from_function(lambda t, T=duration: PEAK * np.sin(math.pi * t / T) ** 2, [0.0, duration])
        assert history.coefficients[0, 0] == 0.0
        assert history.coefficients[0, 1] == 0.0
        times = np.linspace(0.0, duration, 101)
        assert history(times) == pytest.approx(PEAK * np.sin(math.pi * times / duration) ** 2, abs=1e-13 * PEAK)


def test_knots_of_a_fit_are_smooth_and_those_of_its_kinks_are_not():
    kinked = rs.History.from_function(lambda t: PEAK * (t + np.abs(t - 0.5)), [0.0, 0.5, 1.0])
    assert list(kinked.knots[1:-1][~kinked.smooth_knots[1:-1]]) == [0.5]
    # The slope is the same on both sides, the second derivative is not.
    bent = rs.History.from_function(lambda t: PEAK * np.where(t < 0.5, 0.0, (t - 0.5) ** 2), [0.0, 0.5, 1.0])
    assert list(bent.knots[1:-1][~bent.smooth_knots[1:-1]]) == [0.5]
    arch = rs.sine_arch(PEAK, 2.0)
    assert arch.smooth_knots[1:-1].all()
    assert not arch.smooth_knots[[0, -1]].any()
    assert not rs.triangle(PEAK, 1.0).smooth_knots.any()
    jump = rs.History.from_points([0.0, 1.0, 1.0, 2.0], [0.0, PEAK, 2.0 * PEAK, 0.0])
    assert not jump.smooth_knots.any()


@pytest.mark.parametrize("dashpot", [0.0, 0.3], ids=["solid", "dashpot"])
@pytest.mark.parametrize("shape", ["triangle", "trapezoid", "arch", "bell"])
def test_forces_that_leave_zero_and_fall_to_it_like_powers_of_the_time(shape, dashpot):
    """F ~ t and F ~ t^2, where y ~ t^(m/(p + 2)), and against a dashpot y ~ t^((m + 1)/(p + 2))."""
    rng = np.random.default_rng([45, len(shape), dashpot > 0.0])
    for profile in [rs.Parabola(1e-2), rs.Cone(0.5), rs.Sphere(1e-2), rs.TruncatedCone(0.5, 1e-5), rs.Pyramid(1.2)]:
        material = material_of(rng, dashpot * 10.0 ** rng.uniform(-2.0, 0.0))
        cycle, panels = both(material, profile, history_of(rng, 1.0, shape), "force", 1e-8)
        assert difference(cycle, panels, 0) <= 3e-8
        assert panels.end_time == panels.history.stop


@pytest.mark.parametrize("tau", [0.02, 0.01])
@pytest.mark.parametrize("profile", [rs.Parabola(1e-2), rs.Pyramid(1.2)], ids=lambda profile: type(profile).__name__)
def test_a_relaxed_liquid_under_a_force_that_falls_to_zero(profile, tau):
    """Loads are nearly the same everywhere, so that the whole contact leaves as the force ends."""
    material = rs.Material(rs.PronySeries(0.0, [1e6], [tau]), math.inf)
    cycle, panels = both(material, profile, rs.triangle(1.0, 0.7, unloading_time=0.6), "force", 1e-8)
    assert difference(cycle, panels, 0) <= 3e-8
    assert panels.end_time == panels.history.stop
