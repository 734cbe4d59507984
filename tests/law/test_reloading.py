"""Loading again before separation: the contact law against independent elements, and the energy of closed cycles."""

import math

import numpy as np
import pytest

from restitution.contact.analytic import Sphere
from restitution.contact.power_law import Cone, FlatPunch
from restitution.contact.profile import Parabola
from restitution.impact.problem import Impact
from restitution.law.law import contact_law
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material
from stepping import forces


def elements(series: PronySeries, profile, times, depths, count: int = 400):
    """Force on independent elements of equal width, each in contact or free, by the implicit Euler scheme."""
    width = float(profile.contact_radius(np.max(depths))) / count
    g = profile.transform((np.arange(count) + 0.5) * width)
    moduli, tau = series.branch_moduli[:, None], series.relaxation_times[:, None]
    u, stretch, force = np.zeros(count), np.zeros((tau.size, count)), []
    for d, dt in zip(depths, np.diff(times, prepend=0.0), strict=True):
        left = 1.0 / (1.0 + dt / tau)
        relaxed = series.equilibrium_modulus * u + np.sum(moduli * left * stretch, axis=0)
        stiffness = series.equilibrium_modulus + series.parallel_viscosity / dt + np.sum(moduli * left)
        follows = relaxed + stiffness * (d - g - u)
        # An element that the body has not touched yet is at rest, and so has no load to lose.
        du = np.where(follows > 0.0, d - g - u, -relaxed / stiffness)
        u, stretch = u + du, left * (stretch + du)
        force.append(2.0 * width * np.sum(np.maximum(follows, 0.0)))
    return np.array(force)


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


def law_of(series: PronySeries, profile, max_nodes: int, max_depth: float | None = None):
    # A reduced modulus of 4 G: an incompressible body.
    impact = Impact(Material(series.scaled(0.25), math.inf), profile, 1.0, 1.0)
    return contact_law(impact, max_nodes=max_nodes, max_depth=max_depth)


@pytest.mark.parametrize("seed", range(8))
def test_any_motion_converges_to_independent_elements(seed):
    rng = np.random.default_rng(seed)
    series, profile = random_series(rng), (Parabola(1.0), Cone(1.0), Sphere(30.0), FlatPunch(1.0))[seed % 4]
    times = np.linspace(0.0, 1.2, 6401)[1:]
    depths = random_depths(rng, np.concatenate([[0.0], times]))[1:]
    # Halved steps, extrapolated: implicit Euler is of first order.
    fine, coarse = (elements(series, profile, times[n - 1 :: n], depths[n - 1 :: n]) for n in (1, 2))
    exact, scale = 2.0 * fine[1::2] - coarse, fine.max()

    def error(steps: int, max_nodes: int) -> float:
        every = 6400 // steps
        law = law_of(series, profile, max_nodes, 2.0 * depths.max())
        found = forces(law, times[every - 1 :: every], depths[every - 1 :: every])
        return np.sqrt(np.mean((found - exact[every // 2 - 1 :: every // 2]) ** 2)) / scale

    # Twenty steps for the shortest wave. The force of a dashpot jumps where the body touches an imprint again.
    dashpot = series.parallel_viscosity > 0.0
    assert error(100, 32) < 2e-2
    assert error(400, 400) < error(100, 400) / (3.0 if dashpot else 9.0) + 1e-4
    assert error(1600, 400) < (1.5e-3 if dashpot else 1e-4)
    assert error(1600, 32) < 5e-3


@pytest.mark.parametrize("seed", range(20))
def test_a_closed_cycle_never_yields_energy(seed):
    rng = np.random.default_rng(100 + seed)
    times = np.linspace(0.0, 1.0, 2001)
    depths = random_depths(rng, times)
    law = law_of(random_series(rng), Parabola(1.0), int(rng.choice([10, 32])))
    force = np.concatenate([[0.0], forces(law, times[1:], depths[1:])])
    work = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(depths))])
    # The cycle closes where the body leaves; until then the foundation may return what it holds, but no more.
    assert work.min() >= -1e-4 * work.max()


def test_the_force_never_pulls():
    rng = np.random.default_rng(8)
    times, depths = np.cumsum(rng.uniform(1e-3, 1e-1, 2000)), rng.normal(size=2000)
    for max_nodes in (10, 32):
        force = forces(law_of(random_series(rng), Parabola(1.0), max_nodes), times, depths)
        assert np.all(np.isfinite(force))
        assert np.all(force >= 0.0)
