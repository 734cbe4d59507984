"""The contact law converges to the exact solution of an impact and of an indentation."""

import math

import numpy as np
import pytest

from checkout import DATA, rows
from restitution import Impact, Material, PronySeries, Tabulated, contact_law, indent, solve, standard_solid
from restitution.contact.profiles import Cone, FlatEndedParabola, FlatPunch, Parabola, PowerLaw, Sphere, TruncatedCone
from stepping import collide, forces

# nu, p2 and p3 of the paper.
ROWS = [(0.5, 0.1, 1.0), (0.3, 0.1, 1.0), (0.3, 0.01, 1.0), (0.45, 0.01, 0.1), (0.49, 0.001, 10.0), (0.3, 0.1, 100.0)]
# First touch at the end of a step, and within a step.
GAPS = (0.0, 0.37)


def unit_impact(nu: float, p2: float, p3: float) -> Impact:
    return Impact(standard_solid(1.0, 1.0 / p2, p3, poisson_ratio=nu), Parabola(1.0), mass=1.0, velocity=1.0)


def errors(impact: Impact, steps: int, gap: float, **options) -> tuple[float, float]:
    """Errors of e and of the largest force at a number of steps per contact; the gap is a share of a step."""
    exact, law = solve(impact), contact_law(impact, **options)
    dt = exact.contact_time / steps
    result = collide(law, impact.mass, impact.velocity, dt, gap=gap * dt * impact.velocity)
    return (
        abs(result.restitution_coefficient - exact.restitution_coefficient),
        abs(result.max_force / exact.max_force - 1.0),
    )


@pytest.mark.parametrize("row", ROWS)
@pytest.mark.parametrize("gap", GAPS)
def test_fifty_steps_suffice(row, gap):
    e_50, force_50 = errors(unit_impact(*row), 50, gap)
    e_100, force_100 = errors(unit_impact(*row), 100, gap)
    assert e_50 <= 1e-3
    assert e_100 <= 2e-4
    assert max(force_50, force_100) <= 2e-3


def test_exact_values_are_those_of_the_reference_table():
    for line in rows(DATA / "standard_solid.csv"):
        row = line["nu"], line["p2"], line["p3"]
        if row in ROWS:
            law = contact_law(unit_impact(*row), max_nodes=500)
            result = collide(law, 1.0, 1.0, line["contact_time"] / 800)
            assert result.restitution_coefficient == pytest.approx(line["restitution"], abs=2e-6)


@pytest.mark.parametrize("row", ROWS)
def test_error_falls_with_the_square_of_the_step(row):
    counts = (50, 100, 200, 400, 800)
    result = [max(errors(unit_impact(*row), n, gap, max_nodes=500)[0] for gap in (0.0, 0.3, 0.6)) for n in counts]
    assert np.polyfit(np.log(counts), np.log(result), 1)[0] < -1.8


RUBBER = Material(PronySeries(1e6, [3e6, 5e6, 2e6], [1e-5, 3e-4, 2e-3]), 2e7)
LIQUID = Material(PronySeries(0.0, [1e7], [1e-3]), PronySeries(1e7, [4e7], [1e-3]))
KELVIN = Material(PronySeries(3e6, parallel_viscosity=300.0), math.inf)
R = np.linspace(0.0, 0.01, 60)


@pytest.mark.parametrize(
    "profile",
    [
        Cone(1.3), PowerLaw(4.0, 1e5), PowerLaw(1.2, 1.0), FlatPunch(0.002), Sphere(0.01), TruncatedCone(0.001, 1.3),
        FlatEndedParabola(0.01, 0.001), Tabulated(R, R**2 / 0.02 + 20.0 * R**3),
    ],
    ids=lambda profile: type(profile).__name__,
)  # fmt: skip
@pytest.mark.parametrize(
    "materials", [(RUBBER, None), (LIQUID, None), (RUBBER, LIQUID)], ids=["rubber", "liquid", "both"]
)
def test_profiles_liquids_and_two_bodies(profile, materials):
    impact = Impact(materials[0], profile, 0.005, 1.0, counter_material=materials[1])
    for steps, e_limit, force_limit in ((50, 5e-4, 2e-3), (200, 5e-5, 2e-4)):
        e, force = errors(impact, steps, 0.37)
        assert e <= e_limit
        assert force <= force_limit


def test_dashpot():
    smooth, flat = Impact(KELVIN, Parabola(0.01), 0.005, 1.0), Impact(KELVIN, FlatPunch(0.002), 0.005, 1.0)
    assert errors(smooth, 200, 0.37)[0] < errors(smooth, 50, 0.37)[0] / 4.0 < 5e-4
    # The force of a dashpot under a flat face jumps at first touch, where Verlet is of first order.
    assert errors(flat, 400, 0.37)[0] < errors(flat, 50, 0.37)[0] / 4.0 < 5e-4


@pytest.mark.parametrize("max_nodes", [12, 32])
def test_few_nodes_cost_less_than_the_steps(max_nodes):
    for row in ROWS:
        for steps in (200, 800):
            assert errors(unit_impact(*row), steps, 0.37, max_nodes=max_nodes)[0] <= 1e-4


def test_weight():
    impact = Impact(RUBBER, Parabola(0.01), 0.005, 0.05, external_force=0.005 * 9.81)
    exact, law = solve(impact), contact_law(impact)
    result = collide(law, 0.005, 0.05, exact.contact_time / 400, weight=0.005 * 9.81)
    assert result.restitution_coefficient == pytest.approx(exact.restitution_coefficient, abs=3e-5)


@pytest.mark.parametrize("steps", ["equal", "random"])
def test_prescribed_depth_at_equal_and_at_random_steps(steps):
    rng = np.random.default_rng(3)
    widths = np.ones(200) if steps == "equal" else rng.uniform(0.3, 1.7, 200)
    times = 2e-3 * np.cumsum(widths) / widths.sum()
    depths = 1e-4 * np.sin(np.pi * times / 2e-3) ** 2
    law = contact_law(Impact(RUBBER, Parabola(0.01), 0.005, 1.0))
    result = forces(law, times, depths)
    exact = indent(
        RUBBER,
        Parabola(0.01),
        depth=lambda t: 1e-4 * np.sin(np.pi * np.asarray(t) / 2e-3) ** 2,
        time=np.concatenate([[0.0], times]),
    )
    assert np.max(np.abs(result - exact.force[1:])) <= 5e-4 * exact.force.max()


def test_an_elastic_contact_follows_hertz_at_any_step():
    rng = np.random.default_rng(5)
    times, depths = np.cumsum(rng.uniform(1e-6, 1e-3, 300)), rng.uniform(-1e-4, 1e-3, 300)
    law = contact_law(Impact(Material(1e6, 4e6), Parabola(0.01), 1.0, 1.0), max_nodes=10)
    modulus = law.modulus.equilibrium_modulus
    hertz = 4.0 / 3.0 * modulus * 0.1 * np.maximum(depths, 0.0) ** 1.5
    assert forces(law, times, depths) == pytest.approx(hertz, rel=1e-11, abs=1e-12 * hertz.max())
