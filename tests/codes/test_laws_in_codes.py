"""Calibrated laws and the law with memory in the codes they are for.

Without the codes they are skipped, but not in `.ci/run`, where only LIGGGHTS may be absent.
"""

import importlib.util
import math
import os
import shutil

import pytest

import restitution as rs
from checkout import script

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


@pytest.fixture(scope="module")
def codes():
    """The script validation/codes.py, which runs the codes."""
    return script("validation/codes.py")


def need(name):
    if importlib.util.find_spec(name) is None and "RESTITUTION_CODES" not in os.environ:
        pytest.skip(f"{name} is not installed; see .ci/codes.txt")


@pytest.mark.parametrize("wall", [False, True])
@pytest.mark.parametrize("target", ["lammps-viscoelastic", "lammps-tsuji", "lammps-coeff-restitution"])
def test_lammps_gives_the_promise_at_ten_velocities_as_the_step_shrinks(codes, target, wall):
    need("lammps")
    law, ball = codes.calibrated(target, wall), codes.BALL
    for v in map(float, codes.VELOCITIES):
        _, time = codes.exact(v, wall)
        coarse, fine = (
            codes.by_lammps(law.snippet, "si", ball.radius, ball.mass, v, time / n, wall)
            - law.restitution_coefficient(v)
            for n in (25, 400)
        )
        # Velocity Verlet with a lagging velocity is of first order, here 16 times finer.
        assert abs(coarse) < 5e-3
        assert abs(fine) < max(abs(coarse) / 16.0, 5e-5)


@pytest.mark.parametrize("units", ["cgs", "micro", "lj"])
def test_lammps_gives_the_same_in_every_unit_system(codes, units):
    need("lammps")
    ball, v, step = codes.BALL, 1.0, 2e-5
    mass, length, time = {
        "cgs": (1e-3, 1e-2, 1.0),
        "micro": (1e-15, 1e-6, 1e-6),
        "lj": (ball.mass, 2.0 * ball.radius, 2.0 * ball.radius / codes.VELOCITIES[-1]),
    }[units]
    scaled = ball.radius / length, ball.mass / mass, v * time / length, step / time
    in_si = codes.by_lammps(
        codes.calibrated("lammps-viscoelastic").snippet, "si", ball.radius, ball.mass, v, step, False
    )
    law = codes.calibrated("lammps-viscoelastic", units=units)
    # The snippets have eight digits.
    assert codes.by_lammps(law.snippet, units, *map(float, scaled), False) == pytest.approx(in_si, abs=1e-6)


def test_rebound_takes_the_snippet_and_a_compiled_surrogate(codes):
    need("rebound")
    import numba

    law = codes.calibrated("rebound")
    names = {"sim": type("Simulation", (), {})}
    exec(law.snippet, names)
    low, high = map(float, codes.VELOCITIES[[0, -1]])
    curve = rs.surrogate(rs.collision(codes.BALL, codes.BALL, 1.0), (low, high), rtol=1e-8).compiled()
    compiled = numba.cfunc("float64(voidptr, float64)")(lambda _, v: curve(abs(v)))
    for v in (low, 0.33, 1.7, high):
        e, _ = codes.exact(v)
        pasted = codes.by_rebound(names["sim"].coefficient_of_restitution, codes.BALL.radius, v)
        assert pasted == pytest.approx(law.restitution_coefficient(v), abs=1e-7)
        assert pasted == pytest.approx(e, abs=2e-5)
        assert codes.by_rebound(compiled.address, codes.BALL.radius, v) == pytest.approx(e, abs=2e-8)


def test_rebound_with_the_law_with_memory_converges_to_the_exact_restitution(codes):
    need("rebound")
    solid = rs.standard_solid(1e6, 5e6, 500.0, poisson_ratio=0.49, density=1100.0)
    ball, v = rs.Body(solid, codes.BALL.radius), 0.5
    hit = rs.collision(ball, ball, v)
    exact, law = rs.solve(hit), rs.contact_law(hit)
    errors = [
        codes.by_rebound_with_memory(law, ball.radius, ball.mass, v, exact.contact_time / n)
        - exact.restitution_coefficient
        for n in (50, 200)
    ]
    # Of second order.
    assert abs(errors[0]) < 1e-3
    assert abs(errors[1]) < abs(errors[0]) / 10.0


@pytest.mark.skipif(shutil.which("liggghts") is None, reason="needs LIGGGHTS")
@pytest.mark.parametrize("wall", [False, True])
def test_liggghts_gives_the_promise(codes, wall):
    law, ball, v = codes.calibrated("liggghts", wall), codes.BALL, 0.5
    _, time = codes.exact(v, wall)
    e, _ = codes.by_liggghts(law.snippet, ball.radius, ball.material.density, v, time / 200.0, 3.0 * time, wall)
    assert e == pytest.approx(law.restitution_coefficient(v), abs=3e-4)


@pytest.mark.skipif(shutil.which("liggghts") is None, reason="needs LIGGGHTS")
def test_liggghts_with_cohesion_gives_the_promise(codes):
    """The cohesion sjkr, at two times after the contact: grains that stick swing together, others keep their speed."""
    polymer = rs.standard_solid(1e9, 1e9, 20.0, poisson_ratio=0.35, density=1200.0)
    grain = rs.Body(polymer, radius=10e-6)
    sticky = rs.Adhesion(work=0.05, stress=1e7)
    law = rs.calibrate((grain, grain), "liggghts-sjkr", velocity=(0.1, 5.0), adhesion=sticky, points=4)
    # The cohesion of LIGGGHTS has another area of contact, which errs by d/(4 R).
    for share, tolerance in ((1.03, 3e-3), (1.3, 1e-3), (3.0, 1e-3), (20.0, 1e-3)):
        v = share * law.sticking_velocity
        time = float(law.contact_time(v))
        e, _ = codes.by_liggghts(law.snippet, grain.radius, polymer.density, v, time / 800.0, 4.0 * time, False)
        assert e == pytest.approx(law.restitution_coefficient(v), abs=tolerance)
    v, time = 0.8 * law.sticking_velocity, float(law.contact_time(1.3 * law.sticking_velocity))
    assert law.restitution_coefficient(v) == 0.0
    ends = [
        codes.by_liggghts(law.snippet, grain.radius, polymer.density, v, time / 400.0, n * time, False)[0]
        for n in (4.0, 4.3, 4.6)
    ]
    assert max(ends) - min(ends) > 0.02


def test_mujoco_gives_the_promised_restitution_and_contact_time(codes):
    need("mujoco")
    law, ball = codes.calibrated("mujoco-solref", wall=True), codes.BALL
    for v in (0.1, 0.5, 3.0):
        promise, time = law.restitution_coefficient(v), law.contact_time(v)
        (coarse, _), (fine, span) = (
            codes.by_mujoco(law.snippet, ball.radius, ball.mass, v, time / n) for n in (100, 1600)
        )
        # Of first order.
        assert abs(fine - promise) < 2e-4
        assert abs(fine - promise) < abs(coarse - promise) / 8.0
        assert span == pytest.approx(time, rel=2e-2)


def test_kratos_gives_the_promise(codes):
    need("KratosMultiphysics")
    law, ball, v = codes.calibrated("kratos-dem", wall=True), codes.BALL, 0.5
    _, time = codes.exact(v, wall=True)
    e, _ = codes.by_kratos(law.snippet, ball.radius, ball.material.density, v, time / 200.0, 3.0 * time)
    assert e == pytest.approx(law.restitution_coefficient(v), abs=3e-4)


@pytest.mark.parametrize("degrees", [8.0, 37.0])
def test_kratos_gives_the_promised_tangential_restitution(codes, degrees):
    need("KratosMultiphysics")
    # Kratos has the spring at the deformed radius R - d; d/R is 2e-4 here.
    ball, v, angle = codes.BALL, 1e-3, math.radians(degrees)
    law = rs.calibrate((ball, rs.Body(None)), "kratos-dem", v, friction=0.3, angle=(0.9 * angle, angle))
    _, time = codes.exact(v, wall=True)
    density, along = float(ball.material.density), v * math.tan(angle)
    _, e_t = codes.by_kratos(law.snippet, ball.radius, density, v, time / 400.0, 1.3 * time, along)
    # Of first order in the step.
    assert e_t == pytest.approx(law.angles.calibrated[-1], abs=6e-3)
