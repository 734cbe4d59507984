"""Bounces of case files against the constant restitution of a flat punch, and refused files of bounces."""

import math
from pathlib import Path

import numpy as np
import pytest

from cases import case_file
from refusals import refuses
from restitution import Case, bounces, read_case
from restitution.impact import closed_forms as cf

DAMPING = 0.1
# The stiffness of the punch is 2 E* a = 8e12 N/m: contact time and imprint are negligible.
PUNCH = f"""
[body]
mass = 1.0
[profile]
type = "flat_punch"
radius = "1 m"
[material]
model = "kelvin_voigt"
shear_modulus = "1e12 Pa"
viscosity = {1e12 * 2.0 * DAMPING / math.sqrt(8e12)}
bulk_modulus = inf
[impact]
drop_height = "200 cm"
gravity = 10.0
weight = false
[bounces]
max_bounces = 5
min_height = 0.0
"""
SOFT = case_file(
    material='equilibrium_modulus = "1 MPa"\nbranch_modulus = "1 MPa"\nviscosity = "0.1 kPa s"\npoisson_ratio = 0.45'
)
pytestmark = pytest.mark.usefixtures("folder")


def read(text: str) -> Case:
    Path("case.toml").write_text(text, encoding="utf-8")
    return read_case("case.toml")


def test_a_punch_has_one_restitution() -> None:
    series = read(PUNCH).bounces()
    e = cf.flat_punch_kelvin_voigt_restitution(DAMPING)
    assert series.restitution_coefficient == pytest.approx(e, rel=1e-8)
    # The effect of the imprint is g d/v^2, at most 1e-6 here.
    assert series.height == pytest.approx(2.0 * e ** (2 * np.arange(1, 6)), rel=1e-5)
    assert series.touch_time[0] == pytest.approx(math.sqrt(0.4), rel=1e-15)
    assert (series.drop_height, series.gravity, series.ended) == (2.0, 10.0, "max bounces")


def test_a_file_equals_the_same_call_in_python() -> None:
    case = read(SOFT + "[bounces]\nmin_height = '1 mm'\n[solver]\nrtol = 1e-7\n")
    series = case.bounces()
    expected = bounces(case.impact, gravity=9.80665, min_height=1e-3, rtol=1e-7)
    assert series.n_bounces > 2
    np.testing.assert_array_equal(series.height, expected.height)
    assert series.drop_height == pytest.approx(0.5 / 9.80665, rel=1e-15)
    assert series.impact.external_force == pytest.approx(0.005 * 9.80665, rel=1e-15)
    assert read(SOFT + "weight = false\n").bounces().impact.external_force == 0.0


def test_a_fractional_ball_is_accurate_for_its_longest_contact() -> None:
    material = 'model = "fractional_zener"\nequilibrium_modulus = "1 MPa"\nbranch_modulus = "1 MPa"\n'
    material += 'relaxation_time = "1 ms"\nexponent = 0.5\nbulk_modulus = "1 GPa"\napproximation_rtol = 1e-3\n'
    series = read(case_file(material=material)).bounces()
    touches = series.contact_time[np.isfinite(series.contact_time)]
    low, high = series.impact.material.window
    assert touches.max() > 2.0 * touches.min()
    assert low <= 1e-5 * touches.min()
    assert high >= touches.max()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (SOFT + "external_force = 1.0\n", "case.toml: impact.external_force"),
        (SOFT + 'impedance = "500 kg/s"\n', "case.toml: impact.weight = true: must be false"),
        (
            SOFT + '[solver]\nmethod = "elements"\n',
            'case.toml: solver.method = "elements": bounces are solved by method = "exact"',
        ),
        (SOFT + "[solver]\nrtol = 1.0\n", "case.toml: solver.rtol = 1: must be in [1e-12, 0.01]"),
        (SOFT + "[bounces]\nmax_bounces = 0\n", "case.toml: bounces.max_bounces = 0: must be >= 1"),
        (SOFT + '[bounces]\nmin_height = "1 s"\n', 'case.toml: bounces.min_height = "1 s": is a time, not a length'),
        (SOFT + "[bounces]\nheight = 1\n", "case.toml: bounces.height = 1: unknown key; did you mean min_height?"),
    ],
)
def test_invalid_files_are_refused(text: str, message: str) -> None:
    refuses(lambda: read(text).bounces(), message)
