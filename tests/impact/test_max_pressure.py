"""The largest contact pressure against Hertz, closed forms and quadratures of the history."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize

import restitution as rs
from restitution import quantities
from restitution.kernel import stored as kernel

# Many of these bodies exceed the limits of the theory.
pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")

ELASTIC = rs.Material(1.0, 1.0)


def hertz(result):
    """3 F/(2 pi a^2) for the largest force."""
    return 1.5 * result.max_force / (math.pi * result.max_contact_radius**2)


def test_hertz():
    rng = np.random.default_rng(5)
    for _ in range(3):
        radius, mass, velocity = 10.0 ** rng.uniform(-3, 1, 3)
        result = rs.solve(rs.Impact(rs.Material(1e6, 1e9), rs.Parabola(radius), mass, velocity))
        assert result.max_pressure == pytest.approx(hertz(result), rel=1e-6)


def test_a_steel_ball_on_steel_at_one_metre_per_second():
    # K. L. Johnson, Contact Mechanics (1985), section 11.4: p0 = (3/(2 pi)) (4 E*/(3 R^0.75))^0.8 (5 m v0^2/4)^0.2.
    E, nu, R = 210e9, 0.3, 0.01
    steel = rs.Material(E / 2 / (1 + nu), bulk=E / 3 / (1 - 2 * nu), density=7800.0)
    ball, wall = rs.Body(steel, radius=R), rs.Body(steel)
    reduced = E / 2 / (1 - nu**2)
    expected = 1.5 / math.pi * (4 * reduced / (3 * R**0.75)) ** 0.8 * (1.25 * ball.mass) ** 0.2
    result = rs.solve(rs.collision(ball, wall, velocity=1.0))
    assert result.max_pressure == pytest.approx(expected, rel=1e-6)
    assert result.max_pressure == pytest.approx(3.56e9, rel=0.005)


@pytest.mark.parametrize(("exponent", "rel"), [(1.02, 5e-2), (1.05, 3e-4), (1.1, 1e-5), (1.5, 1e-6), (2.0, 1e-7)])
def test_on_the_axis_of_an_elastic_power_law(exponent, rel):
    # p(0) = (1/pi) int_0^a E* g'(x)/x dx with g = d (x/a)^n.
    result = rs.solve(rs.Impact(ELASTIC, rs.PowerLaw(exponent, 0.3), mass=1.0, velocity=0.1))
    E = float(result.impact.reduced_modulus.equilibrium_modulus)
    expected = exponent / (exponent - 1) * E * result.max_indentation_depth / math.pi / result.max_contact_radius
    assert result.max_pressure == pytest.approx(expected, rel=rel)
    assert result.pressure(0.0, 0.5 * result.contact_time) == pytest.approx(expected, rel=1e-7)


def test_off_the_axis_of_a_blunt_elastic_punch():
    # g = d (x/a)^4: p = (4 E* d/(pi a)) (r^2 u + u^3/3) with u^2 = 1 - r^2 over a, largest at r^2 = 1/2.
    result = rs.solve(rs.Impact(ELASTIC, rs.PowerLaw(4.0, 0.3), mass=1.0, velocity=0.1))
    E = float(result.impact.reduced_modulus.equilibrium_modulus)
    u = math.sqrt(0.5)
    unit = 4 * E * result.max_indentation_depth / (math.pi * result.max_contact_radius)
    assert result.max_pressure == pytest.approx(unit * (0.5 * u + u**3 / 3), rel=1e-6)


@pytest.mark.parametrize(
    ("p2", "p3"),
    [
        (0.1, 1.0),
        (1e-3, 1.0),
        pytest.param(10.0, 0.1, marks=pytest.mark.slow),
        pytest.param(1e-3, 10.0, marks=pytest.mark.slow),
    ],
)
def test_relaxation_against_quadrature_and_a_search(p2, p3):
    solid = rs.standard_solid(1.0, 1.0 / p2, p3, poisson_ratio=0.3)
    result = rs.solve(rs.Impact(solid, rs.Parabola(1.0), mass=1.0, velocity=1.0), rtol=1e-10)
    modulus = result.impact.reduced_modulus
    moment = 0.3 * result.contact_time

    def rate(t):
        now = result.sample([t])
        relaxed = modulus.branch_moduli * np.exp(-(moment - t) / modulus.relaxation_times)
        return (
            (modulus.equilibrium_modulus + relaxed.sum())
            * float(now.indentation_velocity[0])
            / float(now.contact_radius[0])
        )

    # a = sqrt(R v0 t) at the start, a root of time.
    ends = (0.0, math.sqrt(moment))
    on_axis = quad(lambda y: 2 * y * rate(y * y), *ends, epsrel=1e-7, limit=200)[0] / math.pi
    assert float(result.pressure(0.0, moment)) == pytest.approx(on_axis, rel=2e-6)
    assert result.max_pressure >= on_axis * (1.0 - 2e-6)

    def pressure(place):
        time, edge = result.contact_time * math.exp(min(place[0], 0.0)), math.exp(min(place[1], 0.0))
        return float(result.pressure(float(result.sample([time]).contact_radius[0]) * (1.0 - edge), time))

    starts = [(math.log(t), math.log(w)) for t in (2e-3, 0.05, 0.45) for w in (1.0, 0.4)]
    start = max(starts, key=pressure)
    solution = minimize(lambda x: -pressure(x), start, method="Nelder-Mead", options={"xatol": 1e-4, "fatol": 1e-9})
    assert result.max_pressure == pytest.approx(-solution.fun, rel=1e-5)


@pytest.mark.parametrize(
    "profile",
    [
        rs.FlatPunch(1.0),
        rs.Cone(1.0),
        rs.TruncatedCone(1.0, 1.0),
        rs.FlatEndedParabola(1.0, 0.1),
        rs.PowerLaw(1.0, 0.3),
    ],
)
def test_infinite_at_sharp_edges_and_tips(profile):
    assert rs.solve(rs.Impact(ELASTIC, profile, mass=1.0, velocity=0.1)).max_pressure == math.inf


def test_infinite_under_a_dashpot():
    material = rs.Material(rs.PronySeries(1.0, parallel_viscosity=0.1), bulk=math.inf)
    assert rs.solve(rs.Impact(material, rs.Parabola(1.0), mass=1.0, velocity=1.0)).max_pressure == math.inf


def test_a_sphere_as_a_table_of_points():
    x = np.linspace(0.0, 1.0, 40)
    solid = rs.standard_solid(1.0, 10.0, 1.0, poisson_ratio=0.3)
    table, ball = (
        rs.solve(rs.Impact(solid, profile, mass=1.0, velocity=0.1)).max_pressure
        for profile in (rs.Tabulated(x, x**2 / 2), rs.Parabola(1.0))
    )
    assert table == pytest.approx(ball, rel=1e-6)


def test_arrays_and_impacts_without_a_largest_pressure():
    solid = rs.standard_solid(1.0, 10.0, 1.0, poisson_ratio=0.3)
    many = rs.Impact(solid, rs.Parabola(1.0), mass=1.0, velocity=[[0.1], [1.0]])
    alone = [rs.Impact(solid, rs.Parabola(1.0), mass=1.0, velocity=v) for v in (0.1, 1.0)]
    values = [rs.solve(impact).max_pressure for impact in alone]
    assert rs.solve(many).max_pressure.tolist() == [[value] for value in values]
    result = rs.solve([*alone, rs.Impact(solid, rs.Cone(1.0), mass=1.0, velocity=1.0)])
    assert result.max_pressure.tolist() == [*values, math.inf]
    held = rs.solve(rs.Impact(solid, rs.Parabola(1.0), 1.0, 0.1, external_force=50.0))
    assert held.status.name == "CAPTURED"
    assert 0.0 < held.max_pressure < math.inf
    assert math.isnan(rs.solve(alone[0], method="elements", n_elements=50).max_pressure)
    assert rs.solve(alone[0]).to_dict()["max_pressure"] == values[0]


def test_as_an_output_of_a_sweep():
    solid = rs.standard_solid(1.0, 10.0, 1.0, poisson_ratio=0.3)
    impact = rs.Impact(solid, rs.Parabola(1.0), mass=1.0, velocity=0.5)
    result = rs.sweep(impact, {"velocity": [0.1, 0.5]}, outputs=["max_pressure"])
    assert float(result.max_pressure[1]) == rs.solve(impact).max_pressure
    assert result.max_pressure.units == "Pa"


def test_a_sweep_searches_only_on_demand(monkeypatch):
    solid = rs.standard_solid(1.0, 10.0, 1.0, poisson_ratio=0.3)
    impact = rs.Impact(solid, rs.Parabola(1.0), mass=1.0, velocity=0.5)
    calls = []
    search = kernel.peak_pressure
    monkeypatch.setattr(kernel, "peak_pressure", lambda *options: calls.append(1) or search(*options))
    rs.sweep(impact, {"velocity": [0.1, 0.5]}, outputs=["max_force", "dissipated_energy"])
    assert not calls
    rs.sweep(impact, {"velocity": [0.1, 0.5]}, outputs=["max_pressure"])
    assert len(calls) == 2


def test_an_output_derived_from_it():
    double = quantities.Quantity(
        "twice", quantities.PRESSURE, "twice the pressure", derive=lambda max_pressure: 2.0 * max_pressure
    )
    impact = rs.Impact(ELASTIC, rs.Parabola(1.0), mass=1.0, velocity=0.5)
    quantities.register_output(double)
    try:
        solution = rs.sweep(impact, {"velocity": [0.5]}, outputs=["twice"])
        result = rs.solve(impact)
        assert float(solution.twice[0]) == 2.0 * result.max_pressure == result.outputs["twice"]
    finally:
        del quantities.OUTPUTS["twice"]
