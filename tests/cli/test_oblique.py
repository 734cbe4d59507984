"""Friction and oblique motion in case files: numbers as in Python, files, sweeps, and refusals."""

import json
from pathlib import Path

import pytest
import xarray as xr

import restitution as rs
from cases import case_file
from checkout import EXAMPLES
from commands import done, refused
from refusals import named

SOFT = 'equilibrium_modulus = "1 MPa"\nbranch_modulus = "3 MPa"\nviscosity = "1 kPa s"\npoisson_ratio = 0.5\n'
THROWN = 'velocity = "1 m/s"\nfriction = 0.4\nangle = "40 deg"\nspin = "-30 rad/s"\n'


@pytest.fixture(autouse=True)
def _ball(folder: Path) -> None:
    case_file("ball.toml", material=SOFT, impact=THROWN, solver="rtol = 1e-4")


def test_the_numbers_are_those_of_python() -> None:
    result = json.loads(done("solve", "ball.toml", "--json").stdout)
    case_file("normal.toml", material=SOFT, impact='velocity = "1 m/s"')
    numbers = {"friction": 0.4, "angle": 0.6981317007977318, "spin": -30.0}
    same = rs.solve(rs.vary(rs.read_case("normal.toml").impact, numbers), rtol=1e-4)
    assert result["tangential_restitution_coefficient"] == same.tangential_restitution_coefficient
    assert result["rebound_spin"] == same.rebound_spin
    assert result["restitution_coefficient"] == same.restitution_coefficient
    assert result["status"] == "SEPARATED"


def test_table_picture_and_history(folder: Path) -> None:
    text = done("solve", "ball.toml", "--plot", "thrown.png", "--history", "thrown.csv").stdout
    assert "tangential restitution coefficient" in text
    assert (folder / "thrown.png").stat().st_size > 10_000
    heads = (folder / "thrown.csv").read_text().splitlines()[0].split(",")
    assert {"contact_point_velocity [m/s]", "tangential_force [N]", "stick_radius [m]"} <= {*heads}


def test_the_example_is_a_ball_with_topspin() -> None:
    result = rs.read_case(EXAMPLES / "thrown_ball.toml").solve()
    assert isinstance(result, rs.ObliqueResult)
    # Friction on a ball with topspin that is thrown slower than it turns drives it on.
    assert result.rebound_tangential_velocity > result.impact.tangential_velocity
    assert abs(result.rebound_spin) < abs(result.impact.spin)


def test_a_sweep_over_angle_and_friction() -> None:
    axes = 'angle = { linear = ["10 deg", "60 deg"], n = 3 }\nfriction = [0.1, 0.5]'
    outputs = 'outputs = ["tangential_restitution_coefficient"]'
    case_file("map.toml", material=SOFT, impact='speed = "1 m/s"\nspin = 5.0', axes=axes, sweep=outputs,
              solver="rtol = 1e-4")  # fmt: skip
    done("sweep", "map.toml", "--out", "map.nc")
    with xr.open_dataset("map.nc") as table:
        e_t = table.tangential_restitution_coefficient
        assert e_t.dims == ("angle", "friction")
        ball = rs.vary(rs.read_case("ball.toml").impact, {"speed": 1.0, "angle": 1.0471975511965976, "friction": 0.1})
        same = rs.solve(rs.vary(ball, {"spin": 5.0}), rtol=1e-4)
        assert float(e_t[-1, 0]) == pytest.approx(same.tangential_restitution_coefficient, abs=1e-12)


@pytest.mark.parametrize(
    ("section", "field"),
    [
        ("friction = -0.1\nangle = 0.1", "impact.friction"),
        ("angle = 0.1", "impact.angle"),
        ("spin = 0.1", "impact.spin"),
        ("friction = 0.1\nangle = 40", "impact.angle"),
        ("friction = 0.1\nangle = 0.1\ntangential_velocity = 0.1", "impact"),
        ('friction = 0.1\nangle = 0.1\nspin = "3 m"', "impact.spin"),
        ("friction = 0.1\nangle = 0.1\nslip = 1", "impact.slip"),
        ("friction = 0.1\nangle = 0.1\nspeed = 1", "impact"),
    ],
)
def test_bad_sections_are_refused(section: str, field: str) -> None:
    case_file("bad.toml", material=SOFT, impact=f'velocity = "1 m/s"\n{section}')
    assert named(lambda: rs.read_case("bad.toml").solve())[0] == field
    assert "Traceback" not in refused("solve", "bad.toml")


def test_a_speed_needs_an_angle() -> None:
    case_file("bad.toml", material=SOFT, impact="speed = 1.0\nfriction = 0.1")
    assert named(lambda: rs.read_case("bad.toml")) == ("impact.speed", 1.0)


def test_a_section_of_its_own_is_refused() -> None:
    case_file("old.toml", material=SOFT, impact="velocity = 1.0", oblique="friction = 0.4")
    assert "[impact]" in refused("solve", "old.toml")


def test_a_layer_and_another_method_are_refused() -> None:
    case_file("layer.toml", material=SOFT, impact=THROWN, profile='thickness = "1 mm"')
    assert "profile" in refused("solve", "layer.toml")
    case_file("slow.toml", material=SOFT, impact=THROWN, solver='method = "elements"')
    assert "friction" in refused("solve", "slow.toml")
