"""The rebound of laws without memory against closed forms."""

import math

import numpy as np
import pytest

from restitution import closed_forms
from restitution.calibration.laws import CONSTANT, LINEAR, VISCOELASTIC, loss, one_rebound, rebound, scales

RNG = np.random.default_rng(11)


@pytest.mark.parametrize("end", ["force", "overlap"])
def test_linear_spring_and_dashpot(end):
    """e and contact time of a damped oscillator (Schwager and Poeschel, Granular Matter 9 (2007) 465)."""
    ratio = RNG.uniform(0.001, 0.9, 20)
    omega = np.sqrt(1.0 - ratio**2)
    # The velocity and the force cos(wt + ...) vanish at these angles.
    angle = np.pi if end == "overlap" else np.pi - 2.0 * np.arctan(ratio / omega)
    e, time = rebound(LINEAR, end, 2.0 * ratio)
    np.testing.assert_allclose(time, angle / omega, rtol=2e-5)
    exact = np.exp(-np.pi * ratio / omega)
    if end == "force":
        exact = closed_forms.flat_punch_kelvin_voigt_restitution(ratio)
    np.testing.assert_allclose(e, exact, atol=2e-6)


@pytest.mark.parametrize("ratio", [0.05, 0.3, 0.8, 1.0, 4.0])
def test_constant_restitution_without_pull(ratio):
    """Tsuji's law is a linear oscillator in d^(5/4) (Antypov and Elliott, EPL 94 (2011) 50004)."""
    e, _ = rebound(CONSTANT, "force", math.sqrt(5.0) * 2.0 * 0.5 * ratio)
    assert e == pytest.approx(closed_forms.flat_punch_kelvin_voigt_restitution(ratio), abs=1e-10)


def test_constant_restitution_with_pull():
    ratio = RNG.uniform(0.01, 0.9, 20)
    e, _ = rebound(CONSTANT, "overlap", math.sqrt(5.0) * ratio)
    np.testing.assert_allclose(e, np.exp(-np.pi * ratio / np.sqrt(1.0 - ratio**2)), atol=2e-6)
    assert rebound(CONSTANT, "overlap", 3.0)[0] == 0.0


def test_viscoelastic_spheres():
    """The Pade approximant of Mueller and Poeschel (2011) is within 1e-6 at small losses, 7e-4 at large ones."""
    b = RNG.uniform(0.0, 0.25, 20)
    e, _ = rebound(VISCOELASTIC, "force", b)
    np.testing.assert_allclose(e, closed_forms.mueller_poeschel_restitution(np.sqrt(b)), atol=1.5e-6)
    b = RNG.uniform(0.25, 9.0, 20)
    e, _ = rebound(VISCOELASTIC, "force", b)
    np.testing.assert_allclose(e, closed_forms.mueller_poeschel_restitution(np.sqrt(b)), atol=7e-4)


@pytest.mark.parametrize("end", ["force", "overlap"])
@pytest.mark.parametrize("shape", [VISCOELASTIC, CONSTANT])
def test_elastic_spheres(shape, end):
    """Without loss the contact time is that of Hertz, and e is 1 - C1 b for viscoelastic spheres."""
    stiffness, mass, velocity = np.exp(RNG.uniform(-5.0, 5.0, 3))
    length, unit = scales(shape, stiffness, mass, velocity)
    depth = closed_forms.elastic_max_indentation_depth(0.75 * stiffness, 1.0, mass, velocity)
    time = one_rebound(shape, end, 0.0)[1] * unit
    assert time == pytest.approx(closed_forms.elastic_contact_time(depth, velocity), rel=1e-10)
    assert rebound(shape, end, 1e-9)[1] * unit == pytest.approx(time, rel=1e-8)
    b = loss(shape, stiffness, 1e-6 * stiffness * length ** (shape.spring - shape.dashpot) / velocity, mass, velocity)
    assert b == pytest.approx(1e-6)
    if shape == VISCOELASTIC:
        assert 1.0 - rebound(shape, end, b)[0] == pytest.approx(closed_forms.SMALL_LOSS_FACTOR * 1e-6, rel=1e-3)


@pytest.mark.parametrize("shape", [VISCOELASTIC, CONSTANT, LINEAR])
def test_table_against_integration(shape):
    losses = np.exp(RNG.uniform(math.log(1e-4), math.log(100.0), 12))
    e, time = rebound(shape, "force", losses)
    exact = np.array([one_rebound(shape, "force", float(b)) for b in losses])
    np.testing.assert_allclose(e, exact[:, 0], atol=1e-10)
    np.testing.assert_allclose(time, exact[:, 1], rtol=1e-6)
