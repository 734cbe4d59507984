"""The command surrogate: tables, files and refusals."""

import json
from pathlib import Path

import pytest
import xarray as xr

import restitution as rs
from cases import BALL, FAST, case_file
from commands import done, refused
from restitution.surrogates.boxes import OF_PIECES

FRACTIONAL = """
model = "fractional_kelvin_voigt"
equilibrium_modulus = "1 MPa"
coefficient = 1e4
exponent = 0.4
bulk_modulus = inf
"""


@pytest.fixture(autouse=True)
def _files(folder: Path) -> None:
    case_file("ball.toml", material=FAST)
    rs.surrogate(BALL, (0.01, 1.0)).save("saved.json")


def test_builds_saves_draws_and_states_the_error() -> None:
    options = "--velocity", "10mm/s", "1", "--out", "ball.json", "--plot", "ball.png"
    answer = done("surrogate", "ball.toml", *options)
    reach = float(rs.solve(BALL).max_contact_radius) / 0.01
    assert answer.stderr.startswith(f"warning: small strain: max(a/R, d/a) is {reach:.3g}, above the limit 0.2")
    assert answer.stderr.count("\n") == 1
    first, second = answer.stdout.splitlines()
    assert first.startswith("ball.json: 0.01 to 1 m/s in ")
    assert first.endswith(", rtol 1e-06")
    assert second.startswith("largest error: restitution coefficient ")
    assert Path("ball.json").read_bytes() == Path("saved.json").read_bytes()
    assert Path("ball.png").read_bytes().startswith(b"\x89PNG")


def test_values_from_a_file_and_from_a_case() -> None:
    curve = rs.Surrogate.load("saved.json")
    answers = [
        json.loads(done("surrogate", source, "--at", "0.5", "--at", "20 cm/s", "--json", *options).stdout)
        for source, options in (("saved.json", ()), ("ball.toml", ("--velocity", "0.01", "1")))
    ]
    assert answers[0] == answers[1]
    assert answers[0]["error"] == curve.error
    for row, v in zip(answers[0]["values"], (0.5, 0.2), strict=True):
        assert row == {
            "velocity": v,
            "restitution_coefficient": curve(v),
            "contact_time": curve.contact_time(v),
            "max_force": curve.max_force(v),
        }
    table = done("surrogate", "saved.json", "--at", "0.5").stdout
    assert f"{curve(0.5):.8g}" in table
    assert f"{curve.max_force(0.5):.8g}" in table


def test_a_fractional_material_is_accurate_for_all_contact_times() -> None:
    case_file("soft.toml", material=FRACTIONAL)
    options = "--velocity", "1e-3", "10", "--rtol", "1e-5", "--out", "soft.json"
    answer = done("surrogate", "soft.toml", *options)
    # A single solve with the window of its own contact.
    for v in ("1e-3", "10"):
        case_file("one.toml", material=FRACTIONAL, impact=f'velocity = "{v} m/s"')
        alone = rs.read_case("one.toml").solve()
        curve = rs.Surrogate.load("soft.json")
        assert curve(float(v)) == pytest.approx(alone.restitution_coefficient, rel=1e-4)
        assert curve.contact_time(float(v)) == pytest.approx(alone.contact_time, rel=1e-4)
    assert answer.stderr.count("Prony terms stand for the fractional model") == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("absent.toml",), "absent.toml: "),
        (("absent.json",), "absent.json: No such file or directory"),
        (("ball.toml", "--velocity", "1mm", "10"), '--velocity "1mm": '),
        (("ball.toml", "--velocity", "3", "3"), "velocity = (3.0, 3.0): "),
        (("ball.toml", "--rtol", "1"), "rtol = 1: "),
        (("ball.toml", "--out", "ball.txt"), "--out ball.txt: must end in .json"),
        (("ball.toml", "--out", "no/ball.json"), "--out no/ball.json: "),
        (("ball.toml", "--plot", "ball.txt"), "--plot ball.txt: "),
        (("ball.toml", "--velocity", "0.1", "1", "--at", "2"), "velocity = 2 m/s: "),
        (("saved.json", "--at", "fast"), '--at "fast": '),
        (("saved.json", "--rtol", "1e-3"), "--rtol: belongs to a case file; saved.json is a surrogate already"),
        (("saved.json", "--at", "2"), "velocity = 2 m/s: "),
        (("case.json",), "case.json: is not a restitution surrogate over velocity"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line(arguments: tuple[str, ...], message: str) -> None:
    Path("case.json").write_text("{}")
    assert message in refused("surrogate", *arguments)
    assert not Path("ball.json").exists()


def test_an_unattainable_tolerance_is_a_failed_solve(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("restitution.surrogates.boxes.OF_PIECES", OF_PIECES._replace(deepest=0))
    message = refused("surrogate", "ball.toml", "--rtol", "1e-9", "--out", "ball.json", exit_code=3)
    assert "NOT_ACCURATE" in message
    assert "rtol = 1e-09" in message
    assert not Path("ball.json").exists()


@pytest.mark.parametrize("suffix", [".csv", ".nc"])
def test_a_table_of_it(suffix: str) -> None:
    done("surrogate", "ball.toml", "--velocity", "10mm/s", "1", "--out", f"e{suffix}")
    if suffix == ".csv":
        head, first, *_ = Path("e.csv").read_text().splitlines()
        assert head == "velocity [m/s],restitution_coefficient [1],contact_time [s],max_force [N]"
        v, e, *_ = map(float, first.split(","))
    else:
        table = xr.open_dataset("e.nc")
        v, e = float(table.velocity[0]), float(table.restitution_coefficient[0])
    assert (v, e) == (0.01, rs.Surrogate.load("saved.json")(0.01))
