"""Random oblique impacts of all materials, profiles and pairs that the theory covers: none fails, none gains energy."""

import math
import warnings

import numpy as np
import pytest

import restitution as rs


def series(generator, *, liquid=False, viscous=False):
    count = generator.integers(0, 9)
    moduli, times = 10 ** generator.uniform(3, 8, count), 10 ** generator.uniform(-7, 0, count)
    drag = 10 ** generator.uniform(0, 3) if viscous else 0.0
    equilibrium = 0.0 if liquid and count else 10 ** generator.uniform(4, 7)
    return rs.PronySeries(equilibrium, moduli, times, parallel_viscosity=drag)


def material(generator):
    shear = series(generator, liquid=generator.random() < 0.1, viscous=generator.random() < 0.15)
    kind = generator.integers(0, 4)
    if kind == 0:
        return rs.Material(shear, math.inf)
    if kind == 1:
        return rs.Material(shear, 10 ** generator.uniform(5, 9.5))
    return rs.Material(shear, series(generator) if kind == 2 else shear.scaled(10 ** generator.uniform(-2, 2)))


def profile(generator):
    choices = (
        lambda: rs.Parabola(0.01), lambda: rs.Sphere(0.01), lambda: rs.Cone(1.2), lambda: rs.TruncatedCone(1.2, 1e-3),
        lambda: rs.PowerLaw(generator.uniform(1.2, 4.0), 1.0), lambda: rs.FlatEndedParabola(0.01, 1e-3),
        lambda: rs.FlatPunch(1e-3),
    )  # fmt: skip
    return choices[generator.integers(0, len(choices))]()


def check(seed, count):
    """Solve impacts with slopes from 0.05 to 10, one of ten without slip."""
    generator, solved = np.random.default_rng(seed), 0
    for _ in range(count):
        counter = material(generator) if generator.random() < 0.3 else None
        impact = rs.Impact(
            material(generator), profile(generator), mass=10 ** generator.uniform(-5, 0),
            velocity=10 ** generator.uniform(-1.5, 1), counter_material=counter,
        )  # fmt: skip
        friction = math.inf if generator.random() < 0.1 else 10 ** generator.uniform(-1.5, 0.5)
        slope = 10 ** generator.uniform(-1.3, 1) * (1.0 if math.isinf(friction) else friction)
        options = {"tangential_velocity": slope * impact.velocity, "gyration": generator.uniform(0.1, 0.67)}
        result = rs.solve(rs.vary(impact, options | {"friction": friction}), rtol=1e-4)
        if result.status is not rs.Status.SEPARATED:
            assert result.status is rs.Status.SINKS_IN
            continue
        solved += 1
        assert abs(result.tangential_restitution_coefficient) <= 1.0
        parts = result.friction_energy, result.tangential_dissipated_energy, result.tangential_stored_energy
        assert min(parts) >= -1e-6 * result.tangential_energy_in
        # Ten times the tolerance; without slip the energies have that of e_t.
        assert abs(result.tangential_energy_residual) < (1e-7 if math.isinf(friction) else 1e-3)
        assert result.impulse_ratio <= friction * (1.0 + 1e-6)
    return solved


@pytest.fixture(autouse=True)
def _unphysical_numbers_are_meant():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rs.RestitutionWarning)
        yield


def test_random_oblique_impacts():
    assert check(1, 40) > 35


@pytest.mark.slow
def test_a_thousand_random_oblique_impacts():
    assert check(2, 1000) > 950
