"""The command oblique: numbers as in Python, files, and refusals."""

import json
from pathlib import Path

import pytest

import restitution as rs
from cases import case_file
from checkout import EXAMPLES
from commands import done, refused
from refusals import named
from restitution.case.oblique import read_oblique

SOFT = 'equilibrium_modulus = "1 MPa"\nbranch_modulus = "3 MPa"\nviscosity = "1 kPa s"\npoisson_ratio = 0.5\n'
THROWN = 'friction = 0.4\nangle = "40 deg"\nspin = "-30 rad/s"\n'


@pytest.fixture(autouse=True)
def _ball(folder: Path) -> None:
    case_file("ball.toml", material=SOFT, impact='velocity = "1 m/s"', oblique=THROWN, solver="rtol = 1e-4")


def test_the_numbers_are_those_of_python() -> None:
    found = json.loads(done("oblique", "ball.toml", "--json").stdout)
    impact = read_oblique("ball.toml").case.impact
    same = rs.oblique(impact, friction=0.4, angle=0.6981317007977318, spin=-30.0, rtol=1e-4)
    assert found["tangential_restitution_coefficient"] == same.tangential_restitution_coefficient
    assert found["rebound_spin"] == same.rebound_spin
    assert found["normal"]["restitution_coefficient"] == same.restitution_coefficient
    assert found["status"] == "SEPARATED"


def test_table_picture_and_history(folder: Path) -> None:
    text = done("oblique", "ball.toml", "--plot", "thrown.png", "--history", "thrown.csv").stdout
    assert "tangential restitution coefficient" in text
    assert (folder / "thrown.png").stat().st_size > 10_000
    assert (folder / "thrown.csv").read_text().startswith("time [s],contact_point_velocity [m/s],tangential_force [N]")


def test_the_example_is_a_ball_with_topspin() -> None:
    case = read_oblique(EXAMPLES / "thrown_ball.toml")
    result = case.solve()
    # Friction on a ball with topspin that is thrown slower than it turns drives it on.
    assert result.rebound_tangential_velocity > result.tangential_velocity
    assert abs(result.rebound_spin) < abs(result.spin)


@pytest.mark.parametrize(
    ("section", "field"),
    [
        ("friction = -0.1\nangle = 0.1", "oblique.friction"),
        ("angle = 0.1", "oblique.friction"),
        ("friction = 0.1", "oblique"),
        ("friction = 0.1\nangle = 40", "oblique.angle"),
        ('friction = 0.1\nangle = 0.1\nspin = "3 m"', "oblique.spin"),
        ("friction = 0.1\nangle = 0.1\nslip = 1", "oblique.slip"),
    ],
)
def test_bad_sections_are_refused(section: str, field: str) -> None:
    case_file("bad.toml", material=SOFT, impact='velocity = "1 m/s"', oblique=section)
    assert named(lambda: read_oblique("bad.toml").solve())[0].startswith(field)
    assert "Traceback" not in refused("oblique", "bad.toml")


def test_other_commands_name_this_one() -> None:
    assert "restitution oblique" in refused("solve", "ball.toml")


def test_a_layer_and_another_method_are_refused() -> None:
    case_file("layer.toml", material=SOFT, impact="velocity = 1", oblique=THROWN, profile='thickness = "1 mm"')
    assert "profile" in refused("oblique", "layer.toml")
    case_file("slow.toml", material=SOFT, impact="velocity = 1", oblique=THROWN, solver='method = "elements"')
    assert "solver.method" in refused("oblique", "slow.toml")
