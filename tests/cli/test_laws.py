"""The commands export and calibrate: files, tables, snippets and refusals."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import restitution as rs
from restitution.cli.main import app

CASE = """
[body]
mass = "5 g"
radius = "10 mm"
[material]
name = "rubber"
equilibrium_modulus = "1 MPa"
branch_modulus = "10 MPa"
viscosity = "1 kPa s"
poisson_ratio = 0.45
[impact]
velocity = "1 m/s"
"""
STEEL = """
[counter_material]
name = "steel"
model = "elastic"
youngs_modulus = "210 GPa"
poisson_ratio = 0.3
"""
BALL = rs.Impact(rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45), rs.Parabola(0.01), 0.005, 1.0)


@pytest.fixture(autouse=True)
def _in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("ball.toml").write_text(CASE)


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, arguments, catch_exceptions=False)


def test_exports_the_cards_of_both_materials() -> None:
    Path("ball.toml").write_text(CASE + STEEL)
    answer = run("export", "ball.toml", "--to", "ball.inp")
    assert answer.exit_code == 0
    assert answer.stdout == "ball.inp: 2 materials in SI units; E and nu are those after a long time\n"
    rubber = rs.read_material("ball.inp", name="rubber").material()
    assert rubber.shear.relaxation_times == pytest.approx(BALL.material.shear.relaxation_times)
    assert rubber.poisson_ratio == pytest.approx(0.45)
    assert rs.read_material("ball.inp", name="steel").material().shear.instantaneous_modulus == pytest.approx(
        210e9 / 2.6
    )
    assert run("export", "ball.toml", "--to", "ball.txt").stdout.endswith("those at the first instant\n")


def test_exports_a_table_over_the_velocity() -> None:
    answer = run("export", "ball.toml", "--to", "ball.csv", "--velocity", "10mm/s", "1")
    assert answer.exit_code == 0
    header, *rows = Path("ball.csv").read_text().splitlines()
    assert header == "velocity [m/s],restitution_coefficient [1],contact_time [s],max_force [N]"
    velocity, *outcome = map(float, rows[-1].split(","))
    assert velocity == pytest.approx(1.0)
    exact = rs.solve(BALL)
    found = exact.restitution_coefficient, exact.contact_time, exact.max_force
    np.testing.assert_allclose(outcome, [float(one) for one in found], rtol=1e-6)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--to", "a.csv"], "--to a.csv: give --velocity LOW HIGH as well"),
        (["--to", "a.inp", "--velocity", "1", "2"], "--velocity 1 2: has no meaning for a.inp"),
        (["--to", "a.foo"], "--to a.foo: must end in "),
        (["--to", "no/a.inp"], "--to no/a.inp: no such folder"),
        (["--to", "a.csv", "--velocity", "1 kg", "2"], '--velocity "1 kg": is a mass'),
        (["--to", "a.csv", "--velocity", "2", "1"], "velocity = (2.0, 1.0): must be the lowest and the highest"),
        ([], "Missing option '--to'"),
    ],
)
def test_exports_that_are_refused_in_one_line(arguments: list[str], message: str) -> None:
    answer = run("export", "ball.toml", *arguments)
    assert answer.exit_code == 2
    assert answer.stderr.startswith(f"error: {message}")
    assert answer.stderr.count("\n") == 1
    assert sorted(path.name for path in Path().iterdir()) == ["ball.toml"]


def test_a_liquid_has_no_cards_of_abaqus() -> None:
    Path("ball.toml").write_text(CASE.replace('"1 MPa"', "0").replace("0.45", "0.5"))
    answer = run("export", "ball.toml", "--to", "a.inp")
    assert (answer.exit_code, answer.stderr.count("\n")) == (2, 1)
    assert "holds no liquid" in answer.stderr
