"""Texts with friction in the codes they are for; without the codes they are skipped, but not in `.ci/run`."""

import importlib.util
import math
import os

import numpy as np
import pytest

import restitution as rs
from checkout import script

pytestmark = [
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
    pytest.mark.filterwarnings("ignore::restitution.RestitutionWarning"),
]


@pytest.fixture(scope="module")
def codes():
    """The script validation/oblique_codes.py, which runs the codes."""
    return script("validation/oblique_codes.py")


def need(name):
    if importlib.util.find_spec(name) is None and "RESTITUTION_CODES" not in os.environ:
        pytest.skip(f"{name} is not installed; see .ci/codes.txt")


def rough(codes, target, **options):
    ends = math.radians(10.0), math.radians(70.0)
    return rs.calibrate((codes.BALL, codes.WALL), target, codes.VELOCITY, friction=0.3, angle=ends, **options)


@pytest.mark.parametrize("style", ["mindlin", "mindlin/force", "mindlin_rescale", "mindlin_rescale/force"])
def test_lammps_gives_the_promise_over_the_angle(codes, style):
    need("lammps")
    law = rough(codes, "lammps-viscoelastic", tangential=style)
    step = float(law.contact_time(codes.VELOCITY)) / 1000
    for n in (0, 8, 16):
        result = codes.by_lammps(law.snippet, codes.VELOCITY * math.tan(law.angles.angle[n]), step)
        assert result == pytest.approx(law.angles.calibrated[n], abs=5e-3)


def test_rebound_gives_the_exact_rebound_between_the_angles_of_its_table(codes):
    need("rebound")
    law = rough(codes, "rebound")
    angle = 0.4 * law.angles.angle[20] + 0.6 * law.angles.angle[21]
    result = codes.by_rebound(law.snippet, codes.VELOCITY * math.tan(angle))
    exact = np.interp(math.tan(angle) / 0.3, law.angles.slope, law.angles.exact)
    assert result == pytest.approx(exact, abs=1e-6)
    # Beyond the table all slides: -1 + (1 + 1/kappa) (1 + e) mu/tan(angle).
    along = 6.0 * codes.VELOCITY
    e = law.restitution_coefficient(codes.VELOCITY)
    assert codes.by_rebound(law.snippet, along) == pytest.approx(-1.0 + 3.5 * (1.0 + e) * 0.3 / 6.0, abs=1e-6)
