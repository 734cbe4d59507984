"""The commands identify, design and moduli."""

import json
import math
from pathlib import Path

import pytest

import restitution as rs
from cases import fit_file
from checkout import EXAMPLES
from commands import done, refused

CASE = fit_file(
    title="Balls [on] rubber",
    identification='model = "kelvin_voigt"\nfixed = { poisson_ratio = 0.5 }',
    data='mass = "33 g"\nnoise = { restitution_coefficient = "1 %"TIMES }',
)
MODULUS, VISCOSITY = 1e6, 300.0


@pytest.fixture(autouse=True)
def _files(folder: Path) -> None:
    solid = rs.kelvin_voigt(MODULUS, VISCOSITY, poisson_ratio=0.5)
    lines = ["velocity [m/s],restitution_coefficient,contact_time [ms]"]
    for v in (0.01, 0.02, 0.05, 0.1):
        impact = rs.solve(rs.Impact(solid, rs.Parabola(0.01), 0.033, v))
        lines.append(f"{v},{impact.restitution_coefficient},{1e3 * impact.contact_time}")
    Path("balls.csv").write_text("\n".join(lines))
    Path("e.csv").write_text("\n".join(line.rpartition(",")[0] for line in lines))
    Path("case.toml").write_text(CASE.replace("TIMES", ', contact_time = "1 %"'))
    Path("e.toml").write_text(CASE.replace("TIMES", "").replace("balls.csv", "e.csv"))


def test_the_material_is_found() -> None:
    answer = done("identify", "case.toml", "--out", "m.toml", "--plot", "fit.png")
    lines = [" ".join(line.split()) for line in answer.stdout.splitlines()]
    assert lines[0] == "Balls [on] rubber"
    assert lines[1].startswith("All parameters are determined, to ")
    assert any(line.startswith("shear_modulus 1 MPa") for line in lines)
    assert any(line.startswith("viscosity 300 Pa s") for line in lines)
    assert 'model = "kelvin_voigt"' in Path("m.toml").read_text()
    assert Path("fit.png").read_bytes().startswith(b"\x89PNG")


def test_undetermined_parameters_are_listed_first() -> None:
    # Section 1 of the design page: e stays the same if all moduli are times L^(5/2) and all times over L.
    assert done("identify", "e.toml").stdout.splitlines()[1] == "Not determined: shear_modulus, viscosity."
    content = json.loads(done("identify", "e.toml", "--json").stdout)
    assert content["parameters"]["viscosity"]["value"] is None
    assert content["flat_directions"][0]["exact"]


def test_json_has_the_numbers_in_si() -> None:
    content = json.loads(done("identify", "case.toml", "--json").stdout)
    assert content["parameters"]["shear_modulus"]["value"] == pytest.approx(MODULUS, rel=1e-5)
    low, high = content["parameters"]["viscosity"]["interval"]
    assert low < VISCOSITY < high
    # 1 - e is a few tenths, so an error of 1 % of e is a few per cent of it.
    assert math.log(high / low) < 0.2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["none.toml"], "none.toml: "),
        (["case.toml", "--plot", "fit.txt"], "--plot fit.txt: "),
        (["case.toml", "--out", "m.json"], "--out m.json: must end in .toml"),
        (["few.toml"], "few.toml: identification"),
    ],
)
def test_wrong_arguments_are_refused(arguments: list[str], message: str) -> None:
    Path("few.csv").write_text("velocity [m/s],e\n1,0.8\n")
    Path("few.toml").write_text(CASE.replace("TIMES", "").replace("balls.csv", "few.csv"))
    assert refused("identify", *arguments).startswith(message)


def test_bounces_are_points_of_a_table_of_moduli() -> None:
    answer = done("moduli", "balls.csv", "--radius", "10 mm", "--mass", "33 g", "--plot", "moduli.png")
    assert "storage modulus" in " ".join(answer.stdout.split())
    content = json.loads(done("moduli", "balls.csv", "--radius", "0.01", "--mass", "0.033", "--json").stdout)
    balls = rs.read_observations("balls.csv", radius=0.01, mass=0.033)
    assert isinstance(balls, rs.Rebounds)
    assert content["storage_modulus"] == pytest.approx(rs.effective_moduli(balls).storage_modulus.tolist())
    # E* = 4 G for an incompressible material.
    assert content["storage_modulus"][0] == pytest.approx(4.0 * MODULUS, rel=0.1)
    assert Path("moduli.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["balls.csv"], "balls.csv: mass: "),
        (["balls.csv", "--mass", "5 mm"], '--mass "5 mm": '),
        (["balls.csv", "--nu", "0.7"], "nu = 0.7: "),
        (["balls.csv", "--dma", "balls.csv"], "balls.csv: "),
        (["case.toml"], "case.toml: "),
    ],
)
def test_wrong_bounces_are_refused(arguments: list[str], message: str) -> None:
    assert refused("moduli", *arguments).startswith(message)


def test_a_design_lists_the_impacts() -> None:
    case = str(EXAMPLES / "identification" / "design.toml")
    assert "12 impacts determine equilibrium_modulus" in done("design", case, "--plot", "design.png").stdout
    content = json.loads(done("design", case, "--json").stdout)
    assert sum(content["repeats"]) == 12
    assert Path("design.png").stat().st_size > 10_000
