"""Every coordinate of a sweep enters its impact, for every profile."""

import numpy as np
import pytest

from restitution import Cone, Impact, Parabola, PowerLaw, Sphere, solve, standard_solid, sweep

# Many of these bodies exceed the limits of the theory.
pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")

RUBBER = standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
OUTPUTS = ("restitution_coefficient", "max_indentation_depth", "max_force")


@pytest.mark.parametrize(
    "profile", [Parabola(0.01), Cone(1.2), Sphere(0.01), PowerLaw(3.0, 1e4)], ids=lambda p: type(p).__name__
)
def test_each_coordinate_enters_its_impact(profile):
    axes = {"mass": [0.002, 0.02], "velocity": [0.3, 2.0], "external_force": [0.0, 0.4]}
    table = sweep(Impact(RUBBER, profile, 0.005, 1.0), axes, OUTPUTS)
    expected = solve(
        Impact(
            RUBBER,
            profile,
            np.array(axes["mass"])[:, None, None],
            np.array(axes["velocity"])[:, None],
            external_force=axes["external_force"],
        )
    )
    for name in OUTPUTS:
        np.testing.assert_allclose(table[name], getattr(expected, name), rtol=1e-9, err_msg=name)
    # All three coordinates matter.
    e = expected.restitution_coefficient
    for axis in range(3):
        assert np.all(np.abs(np.diff(e, axis=axis)) > 1e-6)
