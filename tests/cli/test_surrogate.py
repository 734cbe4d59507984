"""The command surrogate: tables, files and refusals."""

import json
from pathlib import Path

import pytest
import xarray as xr
from typer.testing import CliRunner, Result

import restitution as rs
from restitution.cli.main import app

CASE = """
[body]
mass = "5 g"
radius = "10 mm"
[material]
{material}
[impact]
velocity = "1 m/s"
"""
SOLID = """
equilibrium_modulus = "1 MPa"
branch_modulus = "10 MPa"
viscosity = "1 kPa s"
poisson_ratio = 0.45
"""
FRACTIONAL = """
model = "fractional_kelvin_voigt"
equilibrium_modulus = "1 MPa"
coefficient = 1e4
exponent = 0.4
bulk_modulus = inf
"""
BALL = rs.Impact(rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45), rs.Parabola(0.01), 0.005, 1.0)


@pytest.fixture(autouse=True)
def _in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("ball.toml").write_text(CASE.format(material=SOLID))
    rs.surrogate(BALL, (0.01, 1.0)).save("saved.json")


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, ["surrogate", *arguments], catch_exceptions=False)


def test_builds_saves_draws_and_states_the_error() -> None:
    answer = run("ball.toml", "--velocity", "10mm/s", "1", "--out", "ball.json", "--plot", "ball.png")
    reach = float(rs.solve(BALL).max_contact_radius) / 0.01
    assert answer.exit_code == 0
    assert answer.stderr.startswith(f"warning: small strain: max(a/R, d/a) is {reach:.3g}, above the limit 0.2")
    assert answer.stderr.count("\n") == 1
    first, second = answer.stdout.splitlines()
    assert first.startswith("ball.json: 0.01 to 1 m/s in ")
    assert first.endswith(", rtol 1e-06")
    assert second.startswith("largest error: restitution coefficient ")
    assert Path("ball.json").read_bytes() == Path("saved.json").read_bytes()
    assert Path("ball.png").read_bytes().startswith(b"\x89PNG")


def test_values_from_a_file_and_from_a_case() -> None:
    made = rs.Surrogate.load("saved.json")
    answers = [
        json.loads(run(source, "--at", "0.5", "--at", "20 cm/s", "--json", *options).stdout)
        for source, options in (("saved.json", ()), ("ball.toml", ("--velocity", "0.01", "1")))
    ]
    assert answers[0] == answers[1]
    assert answers[0]["error"] == made.error
    for row, v in zip(answers[0]["values"], (0.5, 0.2), strict=True):
        assert row == {
            "velocity": v,
            "restitution_coefficient": made(v),
            "contact_time": made.contact_time(v),
            "max_force": made.max_force(v),
        }
    table = run("saved.json", "--at", "0.5").stdout
    assert f"{made(0.5):.8g}" in table
    assert f"{made.max_force(0.5):.8g}" in table


def test_a_fractional_material_is_accurate_for_all_contact_times() -> None:
    Path("soft.toml").write_text(CASE.format(material=FRACTIONAL))
    answer = run("soft.toml", "--velocity", "1e-3", "10", "--rtol", "1e-5", "--out", "soft.json")
    assert answer.exit_code == 0
    # A single solve with the window of its own contact.
    for v in ("1e-3", "10"):
        Path("one.toml").write_text(CASE.format(material=FRACTIONAL).replace("1 m/s", f"{v} m/s"))
        alone = rs.read_case("one.toml").solve()
        made = rs.Surrogate.load("soft.json")
        assert made(float(v)) == pytest.approx(alone.restitution_coefficient, rel=1e-4)
        assert made.contact_time(float(v)) == pytest.approx(alone.contact_time, rel=1e-4)
    assert answer.stderr.count("Prony terms stand for the fractional model") == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("absent.toml",), "absent.toml: no such file"),
        (("absent.json",), "absent.json: No such file or directory"),
        (("ball.toml", "--velocity", "1mm", "10"), '--velocity "1mm": is a length, not a velocity; write e.g. "1 m/s"'),
        (("ball.toml", "--velocity", "3", "3"), "velocity = (3.0, 3.0): must be the lowest and the highest"),
        (("ball.toml", "--rtol", "1"), "rtol = 1: must be in [1e-10, 0.01]"),
        (("ball.toml", "--out", "ball.txt"), "--out ball.txt: must end in .json"),
        (("ball.toml", "--out", "no/ball.json"), "--out no/ball.json: no such folder: no"),
        (("ball.toml", "--plot", "ball.txt"), "--plot ball.txt: must end in .png, .pdf or .svg"),
        (("ball.toml", "--velocity", "0.1", "1", "--at", "2"), "velocity = 2 m/s: must be in [0.1, 1] m/s"),
        (("saved.json", "--at", "fast"), '--at "fast": cannot be read as a number and a unit'),
        (("saved.json", "--rtol", "1e-3"), "--rtol: belongs to a case file; saved.json is a surrogate already"),
        (("saved.json", "--at", "2"), "velocity = 2 m/s: must be in [0.01, 1] m/s"),
        (("case.json",), "case.json: is not a restitution surrogate over velocity"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line(arguments: tuple[str, ...], message: str) -> None:
    Path("case.json").write_text("{}")
    answer = run(*arguments)
    assert (answer.exit_code, answer.stdout) == (2, "")
    assert answer.stderr.count("\n") == 1
    assert message in answer.stderr
    assert not Path("ball.json").exists()


def test_an_unattainable_tolerance_is_a_failed_solve(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("restitution.surrogates.build.DEEPEST", 0)
    answer = run("ball.toml", "--rtol", "1e-9", "--out", "ball.json")
    assert answer.exit_code == 3
    assert "NOT_ACCURATE" in answer.stderr
    assert "rtol = 1e-09" in answer.stderr
    assert not Path("ball.json").exists()


@pytest.mark.parametrize("suffix", [".csv", ".nc"])
def test_a_table_of_it(suffix: str) -> None:
    assert run("ball.toml", "--velocity", "10mm/s", "1", "--out", f"e{suffix}").exit_code == 0
    if suffix == ".csv":
        head, first, *_ = Path("e.csv").read_text().splitlines()
        assert head == "velocity [m/s],restitution_coefficient [1],contact_time [s],max_force [N]"
        v, e, *_ = map(float, first.split(","))
    else:
        table = xr.open_dataset("e.nc")
        v, e = float(table.velocity[0]), float(table.restitution_coefficient[0])
    assert (v, e) == (0.01, rs.Surrogate.load("saved.json")(0.01))
