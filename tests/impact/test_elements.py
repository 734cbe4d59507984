"""The element method of the paper: order, closed-form limits, other materials and profiles."""

import math
import re
from functools import partial

import numpy as np
import pytest

from checkout import DATA, rows
from refusals import named, refusal
from restitution import Impact, Material, PronySeries, Status, generalised_maxwell, standard_solid
from restitution.contact.profiles import Cone, FlatPunch, Parabola, Sphere, TruncatedCone
from restitution.errors import InputError
from restitution.impact import closed_forms as cf
from restitution.impact import elements
from restitution.impact.elements import (
    MaxwellElement,
    StandardSolidElement,
    element_history,
    element_law,
    solve_elements,
)
from restitution.impact.solution import SampledSolution
from scipy_oracle import solve_by_scipy

SOLID = standard_solid(1.0, 10.0, 1.0, poisson_ratio=0.3)


def table(name: str = "standard_solid.csv") -> dict[tuple[float, float, float], dict[str, float]]:
    return {(row["nu"], row["p2"], row["p3"]): row for row in rows(DATA / name)}


def unit_impact(nu: float, p2: float, p3: float) -> Impact:
    return Impact(standard_solid(1.0, 1.0 / p2, p3, poisson_ratio=nu), Parabola(1.0), mass=1.0, velocity=1.0)


def incompressible(equilibrium: float, moduli=(), times=(), *, viscosity=0.0) -> Material:
    return Material(PronySeries(equilibrium, moduli, times, parallel_viscosity=viscosity), math.inf)


def energy_residual(impact: Impact, result: SampledSolution) -> float:
    kinetic_in, kinetic_out = 0.5 * impact.mass * np.array([impact.velocity, result.indentation_velocity[-1]]) ** 2
    work = impact.external_force * result.residual_indentation_depth
    return (kinetic_out + result.dissipated + result.stored - kinetic_in - work) / kinetic_in


@pytest.mark.parametrize(
    ("point", "n_elements"),
    [
        pytest.param((0.3, 0.1, 1.0), (200, 400, 800), marks=pytest.mark.slow),
        ((0.45, 0.01, 3.0), (100, 200, 400)),
        ((-1.0, 1.0, 0.3), (100, 200, 400)),
        pytest.param((0.49, 0.001, 10.0), (100, 200, 400), marks=pytest.mark.slow),
    ],
)
def test_restitution_converges_at_first_order(point, n_elements):
    exact = table()[point]["restitution"]
    result = [solve_elements(unit_impact(*point), n_elements=n).restitution_coefficient for n in n_elements]
    errors = np.abs(np.array(result) / exact - 1.0)
    order = -np.polyfit(np.log(n_elements), np.log(errors), 1)[0]
    assert order == pytest.approx(1.0, abs=0.15)
    # With 200 elements the error is about 1e-3.
    assert errors[-1] * n_elements[-1] < 0.2


def test_small_restitution():
    # The two sources of error nearly cancel in e here.
    result = solve_elements(unit_impact(0.5, 0.001, 10.0), n_elements=100)
    assert result.restitution_coefficient == pytest.approx(6.55285402922e-03, rel=1e-4)


def test_order_of_time_step_alone():
    impact = unit_impact(0.3, 0.1, 1.0)
    steps = np.array([4e-4, 2e-4, 1e-4])
    errors = [
        solve_elements(impact, n_elements=800, time_step=step).restitution_coefficient / 4.34356162547e-01 - 1.0
        for step in steps
    ]
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize("point", [(0.3, 0.1, 1.0), (-1.0, 1.0, 0.3), (0.5, 0.01, 0.03), (0.49, 1.0, 0.3)])
def test_estimated_error_is_the_true_error(point):
    result = solve_elements(unit_impact(*point), n_elements=200)
    error = abs(result.restitution_coefficient - table()[point]["restitution"])
    assert result.restitution_error == pytest.approx(error, rel=0.05)


def test_agrees_with_the_table_throughout():
    row = table()[0.3, 0.01, 3.0]
    result = solve_elements(unit_impact(0.3, 0.01, 3.0), n_elements=400)
    assert result.status is Status.SEPARATED
    # First-order errors with 400 elements; that of the residual depth is relative to the largest depth.
    assert result.restitution_coefficient == pytest.approx(row["restitution"], rel=6e-4)
    assert result.contact_time == pytest.approx(row["contact_time"], rel=6e-4)
    assert result.max_indentation_depth == pytest.approx(row["max_indentation"], rel=6e-4)
    assert result.max_force == pytest.approx(row["max_force"], rel=6e-4)
    assert result.residual_indentation_depth == pytest.approx(
        row["residual_indentation"], abs=6e-4 * row["max_indentation"]
    )
    assert result.max_contact_radius == pytest.approx(math.sqrt(row["max_indentation"]), rel=6e-4)


@pytest.mark.parametrize("point", [(0.3, 0.1, 1.0), (0.45, 0.1, 3.0), (0.0, 0.1, 1.0)])
def test_finite_elements(point):
    row = table("finite_element.csv")[point]
    result = solve_elements(unit_impact(*point), n_elements=400)
    allowed = row["restitution_error"] + 1.2 * result.restitution_error
    assert result.restitution_coefficient == pytest.approx(row["restitution"], abs=allowed)
    assert result.max_force == pytest.approx(row["max_force"], rel=1e-3)


def test_hertz():
    modulus, mass, velocity, radius = 3.0e6, 0.02, 1.5, 0.03
    impact = Impact(incompressible(modulus / 4.0), Parabola(radius), mass, velocity)
    result = solve_elements(impact, n_elements=400)
    depth = cf.elastic_max_indentation_depth(modulus, math.sqrt(radius), mass, velocity)
    assert result.max_indentation_depth == pytest.approx(depth, rel=5e-4)
    assert result.contact_time == pytest.approx(cf.elastic_contact_time(depth, velocity), rel=5e-4)
    assert result.max_force == pytest.approx(cf.elastic_max_force(depth, mass, velocity), rel=1e-3)
    # The explicit Euler method gains a little energy.
    assert result.restitution_coefficient == pytest.approx(1.0, rel=1e-3)
    assert result.dissipated == 0.0


@pytest.mark.parametrize("damping", [0.1, pytest.param(0.9, marks=pytest.mark.slow), 2.0])
def test_flat_punch_on_kelvin_voigt(damping):
    # E* = 4, a = 1: omega0^2 = 8 with m = 1, tau = viscosity.
    impact = Impact(incompressible(1.0, viscosity=2.0 * damping / math.sqrt(8.0)), FlatPunch(1.0), 1.0, 1.0)
    result = solve_elements(impact, n_elements=400)
    assert result.restitution_coefficient == pytest.approx(cf.flat_punch_kelvin_voigt_restitution(damping), rel=1e-3)


def test_the_element_of_the_paper_has_the_reduced_modulus():
    """An element with three inner displacements equals two branches of E*, even in explicit Euler steps."""
    series, bulk = Impact(SOLID, Parabola(1.0), 1.0, 1.0).reduced_modulus, SOLID.bulk.equilibrium_modulus
    paper, maxwell = StandardSolidElement(1.0, 10.0, 1.0, bulk), MaxwellElement(series)
    rng = np.random.default_rng(1)
    u, step = np.zeros(5), 0.01
    for law in (paper, maxwell):
        law.grow(5)
    for _ in range(200):
        du = rng.normal(size=5)
        u += du
        for law in (paper, maxwell):
            law.advance(u, du, step)
        load = paper.line_load(u, 0.0)
        np.testing.assert_allclose(load, maxwell.line_load(u, 0.0), rtol=1e-9, atol=1e-9 * np.abs(load).max())
    np.testing.assert_allclose(paper.dissipation(u, 0.0), maxwell.dissipation(u, 0.0), rtol=1e-9)
    np.testing.assert_allclose(paper.energy(u), maxwell.energy(u), rtol=1e-9)


def test_element_obeys_the_equations_of_the_paper():
    ginf, g1, eta, k0 = 1.3, 7.0, 0.9, 2.1
    element = StandardSolidElement(ginf, g1, eta, k0)
    element.grow(1)
    u, step = np.zeros(1), 1e-3
    for du in (0.4, -0.1, 0.25):
        u1, u2, u3 = element.u1.copy(), element.u2.copy(), element.u3.copy()
        u += du
        element.advance(u, np.array([du]), step)
        rate1, rate2, rate3 = (element.u1 - u1) / step, (element.u2 - u2) / step, (element.u3 - u3) / step
        assert eta * (rate3 - rate2) + g1 * u3 == pytest.approx(0.0, abs=1e-9)
        assert eta / 3 * (rate1 - du / step) + g1 / 3 * (u1 - u2) == pytest.approx(0.0, abs=1e-9)
        balance = g1 * element.u3 + ginf * element.u2 + (ginf / 3 + k0) * (element.u2 - u)
        assert balance + g1 / 3 * (element.u2 - element.u1) == pytest.approx(0.0, abs=1e-12)
        assert element.line_load(u, 0.0) == pytest.approx(4.0 * (ginf * element.u2 + g1 * element.u3))


def test_incompressible_form_is_the_limit():
    stiff = Impact(standard_solid(1.0, 10.0, 1.0, bulk_modulus=1e9), Parabola(1.0), 1.0, 1.0)
    rigid = unit_impact(0.5, 0.1, 1.0)
    result, limit = (solve_elements(impact, n_elements=100) for impact in (stiff, rigid))
    assert result.restitution_coefficient == pytest.approx(limit.restitution_coefficient, rel=1e-6)


def test_the_element_of_the_paper_is_used_for_its_material_only():
    def law(material, counter_material=None):
        impact = Impact(material, Parabola(1.0), 1.0, 1.0, counter_material=counter_material)
        return type(element_law(material, counter_material, impact.reduced_modulus))

    assert law(SOLID) is StandardSolidElement
    assert law(standard_solid(1.0, 2.0, 1.0, poisson_ratio=0.5)) is StandardSolidElement
    assert law(SOLID, SOLID) is MaxwellElement
    assert law(incompressible(1.0, [1.0, 2.0], [0.1, 0.2])) is MaxwellElement
    assert law(incompressible(1.0, [1.0], [0.1], viscosity=0.1)) is MaxwellElement
    assert law(Material(PronySeries(1.0, [1.0], [0.1]), PronySeries(1.0, [1.0], [0.2]))) is MaxwellElement


@pytest.mark.parametrize(
    "impact",
    [
        pytest.param(Impact(SOLID, Cone(0.5), 1.0, 1.0), id="cone"),
        pytest.param(Impact(SOLID, FlatPunch(1.0), 1.0, 1.0), id="flat punch"),
        pytest.param(Impact(SOLID, Sphere(1.0), 1.0, 1.0), id="sphere", marks=pytest.mark.slow),
        pytest.param(Impact(SOLID, TruncatedCone(0.3, 1.0), 1.0, 1.0), id="truncated cone"),
        pytest.param(
            Impact(SOLID, Parabola(1.0), 1.0, 1.0, counter_material=SOLID), id="pair", marks=pytest.mark.slow
        ),
        pytest.param(
            Impact(Material(PronySeries(0.0, [1.0], [1.3]), PronySeries(1.0, [2.0], [0.1])), Parabola(1.0), 1.0, 1.0),
            id="liquid with relaxing bulk",
        ),
        pytest.param(Impact(incompressible(1.0, [3.0], [0.3], viscosity=0.1), Parabola(1.0), 1.0, 1.0), id="dashpot"),
        pytest.param(Impact(SOLID, Parabola(1.0), 1.0, 1.0, external_force=0.1), id="weight"),
    ],
)
def test_any_material_and_profile(impact):
    result, exact = solve_elements(impact, n_elements=200), solve_by_scipy(impact, 1e-7)
    assert result.status is exact.status is Status.SEPARATED
    # The estimated error is within a tenth of the true one.
    allowed = 1.15 * result.restitution_error
    assert result.restitution_coefficient == pytest.approx(exact.restitution_coefficient, abs=allowed)
    assert result.restitution_error < 2e-3
    assert result.max_indentation_depth == pytest.approx(exact.max_indentation_depth, rel=1e-3)
    # The last element under a cone separates late, at a depth of the order of its width.
    assert result.contact_time == pytest.approx(exact.contact_time, rel=4e-3)
    assert abs(energy_residual(impact, result)) < 2e-3


@pytest.mark.parametrize(
    ("impact", "status"),
    [
        (Impact(incompressible(0.0, [1.0], [0.03]), Parabola(1.0), 1.0, 1.0), Status.SINKS_IN),
        (Impact(SOLID, Parabola(1.0), 1.0, 1.0, external_force=1.0), Status.CAPTURED),
        pytest.param(
            Impact(incompressible(1.0, viscosity=1.0), Parabola(1.0), 1.0, 1.0, external_force=4.0),
            Status.CAPTURED,
            marks=pytest.mark.slow,
        ),
    ],
)
def test_bodies_that_stay(impact, status):
    result, exact = solve_elements(impact, n_elements=100), solve_by_scipy(impact, 1e-7)
    assert result.status is exact.status is status
    assert result.restitution_coefficient == result.restitution_error == 0.0
    assert result.contact_time == math.inf
    assert result.max_indentation_depth == pytest.approx(exact.max_indentation_depth, rel=2e-3)


@pytest.mark.parametrize("point", [(0.3, 0.1, 1.0), pytest.param((0.5, 0.001, 10.0), marks=pytest.mark.slow)])
def test_energy_balance_closes_at_first_order(point):
    impact = unit_impact(*point)
    coarse, fine = (energy_residual(impact, solve_elements(impact, n_elements=n)) for n in (100, 200))
    assert math.log2(coarse / fine) == pytest.approx(1.0, abs=0.15)
    assert abs(fine) < 2e-3


def test_result_is_independent_of_units():
    base = solve_elements(unit_impact(0.45, 0.01, 3.0), n_elements=100)
    # p3 = eta (v0 R/(m^2 Ginf^3))^(1/5) = 3
    ginf, mass, velocity, radius = 2.0e6, 0.03, 4.0, 0.005
    eta = 3.0 / (velocity * radius / (mass**2 * ginf**3)) ** 0.2
    solid = standard_solid(ginf, 100.0 * ginf, eta, poisson_ratio=0.45)
    result = solve_elements(Impact(solid, Parabola(radius), mass, velocity), n_elements=100)
    assert result.restitution_coefficient == pytest.approx(base.restitution_coefficient, rel=1e-9)


def test_history():
    result = solve_elements(unit_impact(0.3, 0.1, 1.0), n_elements=200)
    assert np.diff(result.time) == pytest.approx(result.time_step)
    assert result.time[-1] == result.contact_time
    assert result.indentation_velocity[0] == 1.0
    assert result.force[0] == result.force[-1] == result.contact_radius[0] == result.contact_radius[-1] == 0.0
    assert np.all(result.force >= 0.0)
    # dx = a_max/100
    assert result.contact_radius.max() == pytest.approx(result.max_contact_radius, rel=0.01)


def test_n_elements_is_the_number_in_contact():
    result = solve_elements(unit_impact(0.5, 0.001, 10.0), n_elements=200)
    widths = np.unique(np.abs(np.diff(result.contact_radius[result.contact_radius > 0.0])))
    dx = widths[widths > 1e-9 * result.max_contact_radius].min()
    assert 2.0 * result.contact_radius.max() / dx == pytest.approx(200.0, abs=2.0)


def test_stiff_cases_are_refused_with_the_remedy():
    # tau = 1e-8
    with pytest.raises(ValueError, match="explicit Euler needs time_step <= 1e-08 s"):
        solve_elements(unit_impact(0.5, 1e-4, 1e-4))


def test_refusal_names_a_time_step_that_works(monkeypatch):
    monkeypatch.setattr(elements, "MAX_STEPS", 5000)
    impact = unit_impact(0.3, 0.1, 1.0)
    error = refusal(lambda: solve_elements(impact, n_elements=100, time_step=1e-6))
    assert (error.field, error.value) == ("n_elements, time_step", (100, 1e-6))
    # The message gives the bounds to three digits.
    least, most = (float(x) for x in re.search(r"take time_step in \[(.*), (.*)\] s$", error.rule).groups())
    assert solve_elements(impact, n_elements=100, time_step=1.01 * least).status is Status.SEPARATED
    assert solve_elements(impact, n_elements=100, time_step=0.99 * most).status is Status.SEPARATED


def test_refusal_names_a_number_of_elements_that_works(monkeypatch):
    monkeypatch.setattr(elements, "MAX_STEPS", 5000)
    impact = unit_impact(0.3, 0.1, 1.0)
    most = int(re.search(r"n_elements <= (\d+)", str(refusal(lambda: solve_elements(impact)))).group(1))
    assert solve_elements(impact, n_elements=most).status is Status.SEPARATED


def test_long_time_step_is_refused():
    # tau = 0.1, but the accuracy with 16 elements demands an even shorter step.
    error = refusal(lambda: solve_elements(unit_impact(0.3, 0.1, 1.0), time_step=0.5))
    assert (error.field, error.value) == ("time_step", 0.5)
    assert error.rule.endswith("s here, for explicit Euler")


@pytest.mark.parametrize("n_elements", [15, 20001, -1, 100.0, True, "100"])
def test_number_of_elements_out_of_range_or_of_wrong_type(n_elements):
    kind = InputError if type(n_elements) is int else TypeError
    call = partial(solve_elements, unit_impact(0.3, 0.1, 1.0), n_elements=n_elements)
    assert named(call, kind) == ("n_elements", n_elements)


def test_arrays_are_refused():
    error = refusal(lambda: solve_elements(Impact(SOLID, Parabola(1.0), 1.0, [1.0, 2.0])))
    assert (error.field, error.value) == ("impact.shape", (2,))
    assert error.rule.endswith("a single impact")


def test_history_of_the_elements_obeys_the_equations_of_the_paper() -> None:
    """Equations (7) and (8) of the paper hold for the recorded displacements and forces."""
    ginf, g1, eta, nu = 1.0, 10.0, 1.0, 0.3
    k0 = 2.0 * ginf * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu))
    impact = Impact(standard_solid(ginf, g1, eta, poisson_ratio=nu), Parabola(1.0), mass=1.0, velocity=1.0)
    # Every step is kept.
    solution = element_history(impact, n_elements=40, n_times=10**6)
    result = solve_elements(impact, n_elements=40)
    assert solution.time.values == pytest.approx(result.time, abs=1e-12)
    u, u1, u2, u3 = (solution[name].values for name in ("displacement", "u1", "u2", "u3"))
    inside = np.isfinite(u)
    # (7): u = d - g(x), g = x^2/R.
    depth = result.indentation_depth[:, None] - solution.position.values**2
    assert u[inside] == pytest.approx(depth[inside], abs=1e-12)
    # (8), third line, at each instant.
    balance = g1 * u3 + ginf * u2 + (ginf / 3.0 + k0) * (u2 - u) + g1 / 3.0 * (u2 - u1)
    assert np.abs(balance[inside]).max() < 1e-12
    # (8), first and second line, with the rates of an explicit Euler step.
    step = solution.attrs["time_step"]
    both = inside[1:] & inside[:-1]
    first = eta * (np.diff(u3, axis=0) - np.diff(u2, axis=0)) / step + g1 * u3[:-1]
    second = eta * (np.diff(u1, axis=0) - np.diff(u, axis=0)) / step + g1 * (u1 - u2)[:-1]
    assert np.abs(first[both]).max() < 1e-9
    assert np.abs(second[both]).max() < 1e-9
    # (8), last line, and the sum (9); each element also represents its mirror image.
    force = solution.force.values
    expected = 4.0 * solution.attrs["spacing"] * (ginf * u2 + g1 * u3)
    assert force[inside] == pytest.approx(expected[inside], abs=1e-12)
    assert not force[~inside].any()
    assert 2.0 * force.sum(axis=1) == pytest.approx(result.force, abs=1e-9)


def test_history_of_the_elements_is_thinned_and_has_units() -> None:
    impact = Impact(generalised_maxwell(1e6, [1e6, 1e6], [1e-3, 1e-4], bulk_modulus=1e9), Parabola(0.01), 0.005, 1.0)
    result = element_history(impact, n_elements=40, n_times=50)
    assert 40 <= result.sizes["time"] <= 80
    assert set(result.data_vars) == {"displacement", "force"}
    assert (result.force.attrs["units"], result.displacement.attrs["units"]) == ("N", "m")


@pytest.mark.parametrize(
    ("equilibrium", "impedance", "status"),
    [(0.0, math.inf, Status.SINKS_IN), (1.0, 1.0, Status.CAPTURED), (1.0, math.inf, Status.SEPARATED)],
    ids=["liquid", "target", "neither"],
)
def test_a_body_that_gives_back_less_than_counts_is_held(monkeypatch, equilibrium, impedance, status):
    # The limit of 1e-6 needs too many steps: with a limit of 1, each body gives back less.
    monkeypatch.setattr(elements, "LEAST_RESTITUTION", 1.0)
    material = Material(PronySeries(equilibrium, [10.0], [0.1]), math.inf)
    result = solve_elements(Impact(material, Parabola(1.0), 1.0, 1.0, impedance=impedance), n_elements=50)
    assert result.status is status
    held = status is not Status.SEPARATED
    assert (result.restitution_coefficient == 0.0) is held
    assert math.isinf(result.contact_time) is held
