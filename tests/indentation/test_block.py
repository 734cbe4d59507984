"""The block of indentations against one indentation after another."""

import math

import numpy as np
import pytest

import restitution as rs
from restitution import IndentationStatus, PronySeries
from restitution.identification.parameters import column
from restitution.indentation.solve import IndentationBlock

PROFILES = {
    "parabola": rs.Parabola(2.5e-6),
    "cone": rs.Cone(half_angle=1.2),
    "flat punch": rs.FlatPunch(1e-6),
    "sphere": rs.Sphere(2.5e-6),
}


def random_material(rng, terms):
    moduli, times = 10.0 ** rng.uniform(1.0, 3.0, terms), 10.0 ** rng.uniform(-3.0, 1.0, terms)
    shear = PronySeries(10.0 ** rng.uniform(1.0, 3.0), moduli, times)
    return rs.Material(shear, bulk=math.inf if rng.random() < 0.5 else 10.0 ** rng.uniform(4.0, 6.0))


def random_curve(rng):
    """Approach in lines of random slopes, a hold, a retraction; the contact point, and times of the samples."""
    up = np.cumsum(rng.uniform(0.1, 1.0, rng.integers(2, 6)))
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.1, 1.0, up.size))])
    depths = np.concatenate([[0.0], up])
    if rng.random() < 0.5:
        depths, times = np.append(depths, depths[-1]), np.append(times, times[-1] + rng.uniform(0.1, 2.0))
    depths, times = np.append(depths, 0.0), np.append(times, times[-1] + rng.uniform(0.5, 3.0))
    depths *= 1e-6 / depths.max()
    return times, depths, rng.uniform(0.01, 0.6) * 1e-6, np.sort(rng.uniform(0.0, times[-1], 40))


@pytest.mark.parametrize("profile", PROFILES.values(), ids=PROFILES)
@pytest.mark.parametrize("workers", [1, 2])
def test_rows_are_single_indentations(profile, workers):
    rng = np.random.default_rng(5)
    curves = [random_curve(rng) for _ in range(5)]
    block = IndentationBlock(profile, [(time, depth, samples) for time, depth, _, samples in curves], 1e-6)
    materials = [random_material(rng, rng.integers(0, 4)) for _ in range(70)]
    places = rng.integers(0, len(curves), len(materials))
    touches = np.array([curves[place][2] for place in places])
    reduced = rs.reduced_modulus(column(materials))
    forces, statuses = block.forces(reduced, touches, places, rtol=1e-9, workers=workers)
    for material, place, touch, force, status in zip(materials, places, touches, forces, statuses, strict=True):
        time, depth, _, samples = curves[place]
        expected = rs.indent(
            material, profile, depth=rs.History.from_points(time, depth - touch), time=samples, rtol=1e-9
        )
        assert status == expected.status
        # A table of the profile reaches to another depth.
        error = 2e-9 + expected.error
        assert np.abs(force - expected.force).max() <= error * expected.max_force


def test_steps_are_jumps():
    """A step is two points at one time; the force of the relaxation that follows is exact."""
    tip, touch = rs.Parabola(2.5e-6), 0.25e-6
    shear = PronySeries(100.0, [300.0], [0.5])
    times = np.array([1.0, 1.5, 3.0])
    step = np.array([0.0, 1.0, 1.0, 3.0]), np.array([0.0, 0.0, 1.25e-6, 1.25e-6]), times
    block = IndentationBlock(tip, [step], 1e-6)
    reduced = rs.reduced_modulus(rs.Material(shear, bulk=math.inf))
    forces, _ = block.forces(reduced, np.array([touch]))
    modulus = 4.0 * (100.0 + 300.0 * np.exp(-(times - 1.0) / 0.5))
    assert forces[0] == pytest.approx(4.0 / 3.0 * modulus * math.sqrt(2.5e-6) * 1e-6**1.5, rel=1e-9)


LINE = np.array([0.0, 1.0, 2.0]), np.array([0.0, 1e-6, 0.0]), np.linspace(0.0, 2.0, 9)
AGAIN = np.array([0.0, 1.0, 1.2, 2.0]), np.array([0.0, 1e-6, 0.9e-6, 1.1e-6]), np.array([1.0])
# A short dent, from which the surface rises while the tip waits halfway up.
DENT = np.array([0.0, 1.0, 1.1, 9.0]), np.array([0.0, 1e-6, 0.4e-6, 0.39e-6]), np.array([1.0])


@pytest.mark.parametrize(
    ("history", "touch", "modulus", "status"),
    [
        (LINE, 0.1e-6, 1e3, IndentationStatus.SEPARATED),
        (LINE, 2e-6, 1e3, IndentationStatus.NO_TOUCH),
        (LINE, -1e-9, 1e3, IndentationStatus.TOUCHES_AT_START),
        (AGAIN, 0.1e-6, 1e3, IndentationStatus.GROWS_AGAIN),
        (DENT, 0.1e-6, 1e5, IndentationStatus.TOUCHES_AGAIN),
        (LINE, 0.1e-6, 1e308, IndentationStatus.OVERFLOW),
        (LINE, 0.1e-6, math.nan, IndentationStatus.OVERFLOW),
    ],
    ids=lambda value: value.name.lower() if isinstance(value, IndentationStatus) else "",
)
def test_a_row_without_a_result_has_a_status(history, touch, modulus, status):
    block = IndentationBlock(rs.Parabola(2.5e-6), [history], 2e-6)
    reduced = rs.reduced_modulus(column([rs.Material(PronySeries(1e3, [1e3], [0.5]), bulk=math.inf)] * 2))
    moduli = np.array([[modulus], [1e3]])
    # The other row of the block is not touched by it.
    forces, statuses = block.forces(
        PronySeries.from_checked(
            reduced.equilibrium_modulus, moduli, reduced.relaxation_times, reduced.parallel_viscosity
        ),
        np.array([touch, 0.1e-6]),
    )
    assert IndentationStatus(statuses[0]) is status
    assert status.message
    assert np.isnan(forces[0]).all() == status.failed


def test_a_profile_ends():
    r = np.linspace(0.0, 0.5e-6, 30)
    block = IndentationBlock(rs.Tabulated(r, r**2 / 2e-6), [LINE], 2e-6)
    reduced = rs.reduced_modulus(rs.Material(PronySeries(1e3), bulk=math.inf))
    _, statuses = block.forces(reduced, np.array([0.1e-6]))
    assert statuses[0] == IndentationStatus.BEYOND_PROFILE
