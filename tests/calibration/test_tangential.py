"""Tangential laws of codes: their springs, their slip, and the numbers that a user types."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import restitution as rs
from refusals import in_one_line
from restitution.calibration.laws import LAWS, TypedLaw
from restitution.calibration.tangential import LAMMPS_RULES, MODELS, Case, poisson_ratio, rebounds, rigid_rebounds

RNG = np.random.default_rng(21)
RUBBER = rs.standard_solid(2e6, 5e6, 200.0, poisson_ratio=0.45, density=1100.0)
BALL = rs.Body(RUBBER, radius=0.01)
CASE = Case(0.2, 0.002, 0.005, 0.4)


def stuck(memory, rescaled, ratio, kappa):
    """e_t of an elastic Hertz contact that never slips, by SciPy: m = v0 = 1, F = d^(3/2), S_n = 3/2 sqrt(d)."""

    def motion(t, y):
        d, v, kept, u = y
        root = math.sqrt(max(d, 1e-30))
        stiffness = ratio * 1.5 * root
        shrink = 0.5 * v / max(d, 1e-30) if rescaled and v < 0.0 else 0.0
        force = kept if memory == "force" else stiffness * kept
        grown = (stiffness if memory == "force" else 1.0) * u + shrink * kept
        return v, -(root**3), grown, -(1.0 + 1.0 / kappa) * force

    def parted(t, y):
        return y[0] - 1e-9 if t > 1.0 else 1.0

    parted.terminal = True
    path = solve_ivp(motion, (0.0, 10.0), (1e-9, 1.0, 0.0, 1.0), rtol=1e-9, atol=1e-12, events=parted)
    return -path.y[3, -1]


@pytest.mark.parametrize("style", LAMMPS_RULES)
def test_springs_without_slip_are_those_of_the_documentation(style):
    """Page pair_style granular of LAMMPS: way or force, rescaled by the contact radius in unloading or not."""
    rule, ratio, kappa = LAMMPS_RULES[style], RNG.uniform(0.3, 1.0), RNG.uniform(0.3, 0.6)
    law = TypedLaw(LAWS["lammps-viscoelastic"], 1e6, 0.0, "overlap")
    e_t = rebounds(rule, law, CASE._replace(gyration=kappa), ratio, 0.0, np.array([1e-6]))
    assert e_t[0] == pytest.approx(stuck(rule.memory, rule.rescaled, ratio, kappa), abs=3e-3)


@pytest.mark.parametrize("name", [*LAMMPS_RULES, *(name for name, model in MODELS.items() if model.rule)])
def test_full_sliding_is_that_of_the_impulse(name):
    """J_t = mu (1 + e) m v0 whatever the springs."""
    rule = LAMMPS_RULES.get(name) or MODELS[name].rule
    law = TypedLaw(LAWS["mercury-bshp"], 2e6, 2e-5, "force")
    e = float(law.rebound(CASE.velocity, CASE.mass, CASE.radius)[0])
    slopes = np.array([12.0, 40.0])
    exact = -1.0 + 3.5 * (1.0 + e) / slopes
    assert rebounds(rule, law, CASE, 0.8, 1.0, slopes) == pytest.approx(exact, abs=5e-3)
    assert rigid_rebounds(e, 0.4, slopes) == pytest.approx(exact, abs=1e-12)


def test_the_ratio_of_the_stiffnesses_is_that_of_mindlin():
    """LAMMPS: k_t = 8 G/(2 (2 - nu)) of two equal bodies, if it is NULL; LIGGGHTS, Kratos and YADE have the same."""
    nu = RNG.uniform(0.0, 0.5)
    G, E_star = 1.0, 1.0 / (2.0 * (1.0 - nu) / 2.0)
    ratio = 4.0 * G / (2.0 - nu) / (2.0 * E_star)
    assert poisson_ratio(ratio) == pytest.approx(nu, abs=1e-12)


@pytest.mark.parametrize("target", ["liggghts", "kratos-dem", "yade-mindlin"])
def test_a_code_without_a_tangential_stiffness_has_a_poisson_ratio(target):
    smooth = rs.calibrate((BALL, BALL), target, (0.01, 0.1), points=3)
    rough = rs.calibrate((BALL, BALL), target, (0.01, 0.1), points=3, friction=0.3, angle=(0.2, 1.2))
    nu, typed = rough.parameters["nu"].value, rough.parameters
    assert 0.0 <= nu < 0.5
    # The normal force is the same: E/(2 (1 - nu^2)).
    E_star = typed["E"].value / (2.0 * (1.0 - nu**2))
    assert E_star == pytest.approx(smooth.law.modulus, rel=1e-9)
    assert rough.law.strength == smooth.law.strength
    assert rough.snippet != smooth.snippet
    assert rough.angles.angle[[0, -1]].tolist() == [0.2, 1.2]


def of_kratos(slope, e, ratio, steps=1500):
    """e_t over v_c/(mu v0) of DEM_D_Hertz_viscous_Coulomb, by the branches of its source; m, R, v0, mu and E* are 1.

    The normal force is (4/3) d^1.5, and both dashpots are 2 gamma sqrt(m k).
    """

    def collide(gamma, v_c, h):
        d, v, normal, before, spring, pull = 0.0, 1.0, 0.0, 0.0, 0.0, 0.0
        while True:
            v, v_c = v - 0.5 * h * normal, v_c - 1.75 * h * pull
            d += h * v
            if d <= 0.0:
                return -v, v_c
            k = 2.0 * math.sqrt(d)
            k_t, rescaled = ratio * k, math.sqrt(min(d / before, 1.0)) if before else 1.0
            normal = max(k * d / 1.5 + 2.0 * gamma * math.sqrt(k) * v, 0.0)
            spring = rescaled * spring + k_t * h * v_c
            dashpot, before = 2.0 * gamma * math.sqrt(k_t) * v_c, d
            if abs(spring + dashpot) > normal:
                opposed = spring * dashpot < 0.0
                if opposed and abs(dashpot) >= abs(spring):
                    dashpot *= (normal + abs(spring)) / abs(dashpot)
                elif opposed or abs(spring) > normal:
                    spring, dashpot = math.copysign(normal, spring), 0.0
                else:
                    dashpot = math.copysign(normal - abs(spring), dashpot)
            pull = spring + dashpot
            v, v_c = v - 0.5 * h * normal, v_c - 1.75 * h * pull

    h = 3.0 / steps
    gamma = brentq(lambda gamma: collide(gamma, 0.0, h)[0] - e, 0.0, 0.5)
    return -collide(gamma, slope, h)[1] / slope


@pytest.mark.filterwarnings("ignore::restitution.RestitutionWarning")
def test_the_dashpot_of_kratos_gives_way_before_its_spring():
    v = 0.2
    law = rs.calibrate((BALL, rs.Body(None)), "kratos-dem", v, friction=0.3, angle=(0.05, 1.2))
    e = law.parameters["e"].value
    for angle, e_t in list(zip(law.angles.angle, law.angles.calibrated, strict=True))[::8]:
        assert e_t == pytest.approx(of_kratos(math.tan(angle) / 0.3, e, law.angles.ratio), abs=2e-3)


def test_lammps_is_nearest_of_its_neighbours():
    result = rs.calibrate((BALL, BALL), "lammps-viscoelastic", 0.1, friction=0.3)
    angles, law = result.angles, result.law
    rule, case = LAMMPS_RULES["mindlin_rescale/force"], Case(0.1, *result.collisions.middle[1:], 0.4)

    def error(ratio, number):
        return np.abs(rebounds(rule, law, case, ratio, number, angles.slope) - angles.exact).max()

    best = error(angles.ratio, angles.number)
    assert best == pytest.approx(angles.largest_error, abs=1e-12)
    for a, b in ((1.05, 1.0), (0.95, 1.0), (1.0, 1.1), (1.0, 0.9)):
        assert error(a * angles.ratio, b * angles.number) > best - 1e-4
    k_t, x, mu = (result.parameters[name].value for name in ("k_t", "x_gammat", "x_mu"))
    assert k_t == pytest.approx(2.0 * angles.ratio * law.modulus)
    assert f"tangential mindlin_rescale/force {k_t:.8g} {x:.8g} 0.3 damping" in result.snippet
    assert mu == 0.3


@pytest.mark.filterwarnings("ignore::restitution.RestitutionWarning")
def test_a_law_whose_e_t_depends_on_the_step_says_by_how_much():
    """A way that begins with a dashpot over a stiffness of zero has no limit; a force has one."""
    changes = []
    for style in ("mindlin", "mindlin_rescale/force"):
        result = rs.calibrate(
            (BALL, BALL), "lammps-coeff-restitution", 0.1, friction=0.3, tangential=style, angle=(0.05, 1.2)
        )
        angles, law, rule = result.angles, result.law, LAMMPS_RULES[style]
        case, numbers = Case(0.1, *result.collisions.middle[1:], 0.4), (angles.ratio, angles.number, angles.slope)
        few, many, more = (rebounds(rule, law, case, *numbers, steps) for steps in (100, 1500, 12000))
        assert angles.of_steps == pytest.approx(np.abs(few - many).max(), abs=1e-12)
        assert f"; 100 steps in a contact change e_t by {angles.of_steps:.2g}" in str(result)
        changes.append((angles.of_steps, np.abs(more - many).max()))
    assert max(changes[0]) > 0.02
    assert changes[1][0] < 0.02
    assert changes[1][1] < 2e-3


@pytest.mark.filterwarnings("ignore::restitution.RestitutionWarning")
def test_exact_angles_are_those_of_oblique_impacts():
    result = rs.calibrate((BALL, BALL), "rebound", 0.1, friction=0.3, angle=(0.3, 1.3))
    hit = rs.collision(BALL, BALL, 0.1)
    exact = rs.solve(rs.vary(hit, {"friction": 0.3, "angle": np.linspace(0.3, 1.3, 65)}))
    assert result.angles.exact == pytest.approx(exact.tangential_restitution_coefficient, abs=1e-4)
    assert "sim.collision_resolve = collide" in result.snippet
    assert result.to_dict()["angles"]["friction"] == 0.3
    of_impact = rs.calibrate(rs.vary(hit, {"friction": 0.3}), "rebound", 0.1, angle=(0.3, 1.3))
    assert of_impact.snippet == result.snippet


@pytest.mark.filterwarnings("ignore::restitution.RestitutionWarning")
@pytest.mark.parametrize("angle", [1.35, (1.3, 1.4)])
def test_acusolve_has_the_tangential_table(angle):
    """Where all slides, v_x'/v_x = 1 - mu (1 + e)/tan(angle), which rises with the angle."""
    friction, speeds = 0.3, np.array([0.02, 0.05, 0.125])
    result = rs.calibrate((BALL, rs.Body(None)), "acusolve", (0.02, 0.125), points=3, friction=friction, angle=angle)
    e = rs.solve(rs.collision(BALL, rs.Body(None), speeds)).restitution_coefficient
    low, high = (1.0 - friction * (1.0 + e) / np.tan(each) for each in (np.min(angle), np.max(angle)))
    table = result.snippet.split("wall_et_curve_fit_values = {")[1].split("}")[0].strip().splitlines()
    typed = np.array([[float(x) for x in row.strip(";").split(",")] for row in table])
    assert typed[:, 0] == pytest.approx(speeds)
    assert typed[:, 1] == pytest.approx(0.5 * (low + high), abs=1e-5)
    assert result.angles.spread == pytest.approx(0.5 * np.max(high - low), abs=1e-5)
    # e_t of a body without spin, and what half of the spread of v_x'/v_x is in it.
    assert result.angles.calibrated == pytest.approx(3.5 * (1.0 - 0.5 * (low + high)[1]) - 1.0, abs=3.5e-5)
    assert result.angles.largest_error == pytest.approx(1.75 * (high - low)[1], abs=3.5e-5)
    assert "wall_et" not in rs.calibrate((BALL, rs.Body(None)), "acusolve", (0.02, 0.125), points=3).snippet


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"target": "lammps-tsuji", "friction": -1.0}, "friction"),
        ({"target": "lammps-tsuji", "friction": 0.0}, "friction"),
        ({"target": "lammps-tsuji", "friction": 0.3, "tangential": "hooke"}, "tangential"),
        ({"target": "liggghts", "friction": 0.3, "tangential": "mindlin"}, "tangential"),
        ({"target": "solfec", "friction": 0.3}, "friction"),
        ({"target": "drake", "friction": 0.3}, "friction"),
        ({"target": "liggghts", "friction": 0.3, "angle": (0.1, 0.2, 0.3)}, "angle"),
        ({"target": "liggghts", "friction": 0.3, "angle": 2.0}, "angle"),
        ({"target": "liggghts", "friction": 0.3, "restitution": 0.5}, "friction"),
        ({"target": "liggghts", "angle": 0.5}, "angle"),
        ({"target": "lammps-tsuji", "tangential": "mindlin"}, "tangential"),
    ],
)
def test_refusals(options, field):
    target = options.pop("target")
    assert in_one_line(lambda: rs.calibrate((BALL, BALL), target, 0.1, **options)).field == field
