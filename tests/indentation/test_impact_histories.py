"""The motion of an impact, prescribed as an indentation: both kernels give the same force and depth."""

import math

import numpy as np
import pytest

from restitution import Cone, Impact, Material, Parabola, PronySeries, TruncatedCone, indent, solve, standard_solid


@pytest.mark.slow
@pytest.mark.parametrize(
    ("material", "profile"),
    [
        (standard_solid(1.0, 10.0, 1.0, poisson_ratio=0.3), Parabola(1.0)),
        (Material(PronySeries(0.5, [1.0, 6.0, 3.0], [0.01, 0.2, 5.0]), math.inf), Cone(1.1)),
        (Material(PronySeries(0.0, [4.0, 1.0], [0.3, 3.0]), 10.0), TruncatedCone(0.3, 1.2)),
    ],
    ids=["parabola", "cone", "truncated cone"],
)
def test_force_of_the_motion_and_depth_of_the_force(material, profile):
    impact = solve(Impact(material, profile, 1.0, 1.0), rtol=1e-11)
    times = np.linspace(0.0, impact.contact_time, 41)
    motion = impact.sample(times)

    def column(name):
        def at(time):
            clipped = np.clip(np.ravel(time), 0.0, impact.contact_time)
            return impact.sample(clipped)[name].values.reshape(np.shape(time))

        return at

    pressed = indent(material, profile, depth=column("indentation_depth"), time=times, rtol=1e-9)
    np.testing.assert_allclose(pressed.force, motion.force, rtol=0.0, atol=1e-8 * impact.max_force)
    # A flat face separates all at once. Rounding decides whether it is still in contact at the last instant. All other
    # contacts shrink to a point.
    face = float(profile.contact_radius(0.0))
    radius = np.array(pressed.contact_radius)
    assert radius[-1] == pytest.approx(0.0, abs=2e-6) or radius[-1] == pytest.approx(face, abs=2e-6)
    radius[-1] = float(motion.contact_radius[-1]) if face > 0.0 else radius[-1]
    np.testing.assert_allclose(radius, motion.contact_radius, rtol=0.0, atol=2e-6 * impact.max_contact_radius)
    loaded = indent(material, profile, force=column("force"), time=times, rtol=1e-8)
    np.testing.assert_allclose(
        loaded.indentation_depth, motion.indentation_depth, rtol=0.0, atol=1e-7 * impact.max_indentation_depth
    )
