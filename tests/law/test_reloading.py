"""Loading again before separation: the contact law against independent elements, and the energy of closed cycles."""

import math

import numpy as np
import pytest

from independent_elements import element_forces
from restitution import Cone, FlatPunch, Impact, Material, Parabola, PronySeries, Sphere, standard_solid
from restitution.impact.elements import solve_elements
from restitution.law.contact import contact_law
from stepping import forces

PARABOLA = Parabola(1.0)


def random_series(rng) -> PronySeries:
    return PronySeries(
        rng.choice([0.0, 1.0]),
        10.0 ** rng.uniform(-1.0, 1.0, 2),
        10.0 ** rng.uniform(-2.5, 0.0, 2),
        parallel_viscosity=rng.choice([0.0, 0.02]),
    )


def random_depths(rng, times):
    """Smooth motion from a depth of 0, with harmonics up to a fifth of the duration."""
    phases, weights = rng.uniform(0.0, 2.0 * math.pi, 5), rng.normal(size=5) / np.arange(1, 6)
    waves = np.sin(2.0 * math.pi * np.arange(1, 6) * times[:, None] + phases) - np.sin(phases)
    depths = waves @ weights
    return depths if depths.max() > 0.5 * np.abs(depths).max() else -depths


def unit_impact(series: PronySeries, profile=PARABOLA) -> Impact:
    # A reduced modulus of 4 G: an incompressible body.
    return Impact(Material(series.scaled(0.25), math.inf), profile, 1.0, 1.0)


@pytest.mark.parametrize("seed", [pytest.param(0, marks=pytest.mark.plain), *range(1, 9)])
def test_any_motion_converges_to_independent_elements(seed):
    rng = np.random.default_rng(seed)
    impact = unit_impact(random_series(rng), (PARABOLA, Cone(1.0), Sphere(30.0), FlatPunch(1.0))[seed % 4])
    if seed == 8:
        # Four coupled displacements in each element, as in the paper.
        impact = Impact(standard_solid(1.0, 10.0, 1.0, poisson_ratio=0.3), PARABOLA, 1.0, 1.0)
    times = np.linspace(0.0, 1.2, 6401)
    depths, times = random_depths(rng, times)[1:], times[1:]
    # Halved steps, extrapolated: explicit Euler is of first order.
    fine, coarse = (element_forces(impact, times[n - 1 :: n], depths[n - 1 :: n]) for n in (1, 2))
    exact, scale = 2.0 * fine[1::2] - coarse, fine.max()

    def error(steps: int, max_nodes: int) -> float:
        every = 6400 // steps
        law = contact_law(impact, max_nodes=max_nodes, max_depth=2.0 * depths.max())
        simulated = forces(law, times[every - 1 :: every], depths[every - 1 :: every])
        return np.sqrt(np.mean((simulated - exact[every // 2 - 1 :: every // 2]) ** 2)) / scale

    # Twenty steps for the shortest wave.
    assert error(100, 32) < 2e-2
    assert error(400, 400) < error(100, 400) / 9.0 + 1e-4
    # The force of a dashpot jumps where the body touches an element again, so that of the elements is not smooth.
    assert error(1600, 400) < (3e-4 if impact.reduced_modulus.parallel_viscosity > 0.0 else 1e-4)
    assert error(1600, 32) < 5e-3


def test_elements_are_those_of_the_impact():
    # The depth of the method "elements" is driven: one approach, one rebound.
    impact = Impact(standard_solid(1.0, 10.0, 1.0, poisson_ratio=0.3), PARABOLA, 1.0, 1.0)
    sampled = solve_elements(impact, n_elements=200)
    driven = element_forces(impact, sampled.time[1:], sampled.indentation_depth[1:], n_elements=200)
    assert driven == pytest.approx(sampled.force[1:], abs=2e-2 * sampled.max_force)


@pytest.mark.plain
@pytest.mark.parametrize("seed", range(20))
def test_a_closed_cycle_never_yields_energy(seed):
    rng = np.random.default_rng(100 + seed)
    times = np.linspace(0.0, 1.0, 2001)
    depths = random_depths(rng, times)
    law = contact_law(unit_impact(random_series(rng)), max_nodes=int(rng.choice([10, 32])))
    force = np.concatenate([[0.0], forces(law, times[1:], depths[1:])])
    work = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(depths))])
    # The cycle closes where the body leaves; until then the foundation may return what it holds, but no more.
    assert work.min() >= -1e-4 * work.max()


@pytest.mark.plain
def test_the_force_never_pulls():
    rng = np.random.default_rng(8)
    times, depths = np.cumsum(rng.uniform(1e-3, 1e-1, 2000)), rng.normal(size=2000)
    for max_nodes in (10, 32):
        force = forces(contact_law(unit_impact(random_series(rng)), max_nodes=max_nodes), times, depths)
        assert np.all(np.isfinite(force))
        assert np.all(force >= 0.0)
