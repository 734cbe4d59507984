"""States, calls from Python and from compiled code, and refusals of the contact law."""

import math

import numba
import numpy as np
import pytest

from refusals import in_one_line, named
from restitution import Body, Cone, Impact, Material, Parabola, PronySeries, Sphere, collision, solve
from restitution.law.contact import contact_law
from restitution.law.law import ContactLaw
from restitution.law.step import COUNT, step
from stepping import forces

RUBBER = Material(PronySeries(1e6, [3e6, 5e6], [1e-4, 2e-3]), 2e7)
BALL = Body(RUBBER, 0.01, 0.005)
IMPACT = Impact(RUBBER, Parabola(0.01), 0.005, 1.0)
TIMES = np.linspace(0.0, 4e-3, 301)[1:]


@pytest.fixture(scope="module")
def law() -> ContactLaw:
    return contact_law(IMPACT)


def waves(count: int = 1) -> np.ndarray:
    """Depths of contacts that load, unload and load again, each in its own way; shape (300, count)."""
    phase = np.arange(count) / count
    return 1e-4 * np.sin(2.0 * math.pi * (TIMES[:, None] / 2e-3 + phase)) * (1.0 + TIMES[:, None] / 4e-3)


def test_two_bodies_and_their_impact_have_one_law():
    other = Body(Material(1e6, 4e6), 0.02, 0.01)
    law, same = contact_law((BALL, other)), contact_law(collision(BALL, other, velocity=3.0))
    assert law.constants.tolist() == same.constants.tolist()
    # 1/E* of both materials, 1/R of both radii.
    modulus = contact_law(Impact(RUBBER, Parabola(1.0), 1.0, 1.0, counter_material=other.material)).modulus
    assert law.modulus.relaxation_modulus(1e-3) == modulus.relaxation_modulus(1e-3)
    assert law.impact.profile.contact_radius(1e-6) == pytest.approx(math.sqrt(1e-6 / 150.0), rel=1e-14)


def test_the_force_on_spheres_grows_with_the_root_of_the_radius(law):
    other = contact_law(Impact(RUBBER, Parabola(0.03), 0.005, 1.0))
    depths = waves()[:, 0]
    forces_of_other, forces_of_law = forces(other, TIMES, depths), forces(law, TIMES, depths)
    assert forces_of_other == pytest.approx(math.sqrt(3.0) * forces_of_law, rel=1e-9, abs=1e-12 * forces_of_law.max())


@pytest.mark.plain
def test_many_contacts_equal_single_ones(law):
    depths, state, dt = waves(7), law.start(7), TIMES[0]
    together = np.array([law.step(state, depth, dt) for depth in depths])
    assert together.shape == (300, 7)
    assert together.max() > 0.0
    for n in range(7):
        alone = law.start()
        assert [law.step(alone, depth, dt) for depth in depths[:, n]] == together[:, n].tolist()
        assert alone.tolist() == state[n].tolist()


@pytest.mark.slow
def test_steps_in_compiled_code_equal_those_in_python(law):
    depths, dt, advance, size = waves()[:, 0], TIMES[0], law.compiled, law.state_size

    # Without the runtime that counts references numba refuses to allocate.
    @numba.njit(_nrt=False)
    def march(state, depths, total):
        for n in range(depths.size):
            total[n] = advance(state, depths[n], dt)

    @numba.cfunc("float64(CPointer(float64), float64, float64)")
    def callback(state, depth, dt):
        return advance(numba.carray(state, size), depth, dt)

    state, called, expected, total = law.start(), law.start(), law.start(), np.empty(depths.size)
    python = [law.step(expected, depth, dt) for depth in depths]
    march(state, depths, total)
    assert total.tolist() == python
    assert [callback.ctypes(called.ctypes.data_as(callback.ctypes.argtypes[0]), d, dt) for d in depths] == python
    assert state.tolist() == called.tolist() == expected.tolist()


def test_a_copy_of_the_state_is_a_copy_of_the_contact(law):
    state = law.start()
    for depth in waves()[:100, 0]:
        law.step(state, depth, TIMES[0])
    branch = state.copy()
    further = [law.step(state, depth, TIMES[0]) for depth in waves()[100:, 0]]
    assert [law.step(branch, depth, TIMES[0]) for depth in waves()[100:, 0]] == further


@pytest.mark.plain
def test_first_touch_within_a_step_continues_the_gap(law):
    # The same ramp, with steps that end at first touch and with steps that do not.
    speed, dt = 1.0, 1e-6
    late = law.start(depth=-0.4 * dt)
    after = [law.step(late, (n + 0.6) * speed * dt, dt) for n in range(20)]
    times = np.concatenate([[0.6], np.arange(1.6, 20.0)]) * dt
    assert after[-1] == pytest.approx(forces(law, times, speed * times)[-1], rel=1e-12)


def test_an_imprint_is_forgotten_when_it_has_vanished(law):
    state = law.start()
    forces_before = [law.step(state, depth, 1e-5) for depth in (5e-5, 1e-4, 5e-5, -1e-4)]
    assert forces_before[-1] == 0.0
    assert state[COUNT] > 0.0
    for _ in range(200):
        law.step(state, -1e-4, 1e-2)
    assert state[COUNT] == 0.0
    first = law.start(depth=-1e-4)
    law.step(first, -1e-4, 1e-2)
    assert law.step(state, 1e-4, 1e-5) == law.step(first, 1e-4, 1e-5) > 0.0


def test_a_long_hold_relaxes_to_the_equilibrium_modulus(law):
    state = law.start()
    law.step(state, 1e-4, 1e-5)
    held = [law.step(state, 1e-4, 1e-4) for _ in range(3000)]
    hertz = 4.0 / 3.0 * law.modulus.equilibrium_modulus * 0.1 * 1e-4**1.5
    assert held[-1] == pytest.approx(hertz, rel=1e-9)


def test_largest_depth():
    deep = contact_law(Impact(RUBBER, Sphere(0.01), 0.005, [0.5, 1.0]))
    largest = solve(Impact(RUBBER, Sphere(0.01), 0.005, 1.0)).max_indentation_depth
    assert deep.max_depth == pytest.approx(4.0 * largest, rel=1e-5)
    state = deep.start()
    assert math.isnan(step(deep.constants, state, 1.01 * deep.max_depth, 1e-5))
    assert not state.any()
    assert contact_law(IMPACT, max_depth=1e-3).max_depth == 1e-3
    assert contact_law(IMPACT).max_depth == math.inf


@pytest.mark.parametrize(
    ("call", "field"),
    [
        (lambda law: contact_law(RUBBER), "problem"),
        (lambda law: contact_law((BALL, RUBBER)), "problem"),
        (lambda law: contact_law((BALL, BALL, BALL)), "problem"),
        (lambda law: contact_law((Body(RUBBER), Body(RUBBER))), "radius"),
        (lambda law: contact_law(IMPACT, max_nodes=7), "max_nodes"),
        (lambda law: contact_law(IMPACT, max_depth=0.0), "max_depth"),
        (lambda law: contact_law(Impact(RUBBER, Cone([1.2, 1.3]), 0.005, 1.0)), "profile"),
        (lambda law: law.start(0), "contacts"),
        (lambda law: law.start(3, depth=1e-6), "depth"),
        (lambda law: law.start(3, depth=[-1.0, -1.0]), "depth.shape"),
        (lambda law: law.step([0.0], 0.0, 1.0), "state"),
        (lambda law: law.step(law.start()[:-1], 0.0, 1.0), "state.shape"),
        (lambda law: law.step(law.start(2)[:, :-1], 0.0, 1.0), "state"),
        (lambda law: law.step(law.start(2), [0.0, 0.0, 0.0], 1.0), "depth.shape"),
        (lambda law: law.step(law.start(), math.nan, 1.0), "depth"),
        (lambda law: law.step(law.start(), 0.0, 0.0), "dt"),
        (lambda law: law.step(law.start(), 0.0, [1.0, 1.0]), "dt"),
        (lambda law: contact_law(IMPACT, max_depth=1e-3).step(law.start(), 2e-3, 1e-5), "depth"),
    ],
)
def test_refusals(law, call, field):
    assert in_one_line(lambda: call(law)).field == field


def test_a_fractional_material_is_refused_with_a_remedy():
    from restitution.material.fractional import FractionalMaterial, springpot

    gel = FractionalMaterial(springpot(1e4, 0.2), bulk=2e9)
    assert named(lambda: contact_law(Impact(gel, Parabola(0.01), 0.005, 1.0))) == ("material",)
