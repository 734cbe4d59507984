"""The commands export and calibrate: files, tables, snippets and refusals."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import restitution as rs
from cases import BALL, FAST, case_file
from checkout import ROOT
from commands import done, refused, run
from restitution.surrogates import build

CASE = case_file(material='name = "rubber"\n' + FAST)
STEEL = """
[counter_material]
name = "steel"
model = "elastic"
youngs_modulus = "210 GPa"
poisson_ratio = 0.3
"""
RANGE = ("--velocity", "1 cm/s", "0.1")


@pytest.fixture(autouse=True)
def _ball(folder: Path) -> None:
    Path("ball.toml").write_text(CASE)


def test_exports_the_cards_of_both_materials() -> None:
    Path("ball.toml").write_text(CASE + STEEL)
    answer = done("export", "ball.toml", "--to", "ball.inp")
    assert answer.stdout == "ball.inp: 2 materials in SI units; E and nu are those after a long time\n"
    rubber = rs.read_material("ball.inp", name="rubber").material()
    assert rubber.shear.relaxation_times == pytest.approx(BALL.material.shear.relaxation_times)
    assert rubber.poisson_ratio == pytest.approx(0.45)
    assert rs.read_material("ball.inp", name="steel").material().shear.instantaneous_modulus == pytest.approx(
        210e9 / 2.6
    )
    assert run("export", "ball.toml", "--to", "ball.txt").stdout.endswith("those at the first instant\n")


def test_a_shift_that_the_cards_cannot_hold_is_named() -> None:
    Path("shift.csv").write_text("T_C,log_aT\n0,1\n20,0\n40,-2\n")
    Path("ball.toml").write_text(
        CASE.replace("poisson_ratio", 'shift = "shift.csv"\ntemperature = "30 degC"\npoisson_ratio')
    )
    answer = run("export", "ball.toml", "--to", "ball.txt")
    assert "note: the cards cannot hold a ShiftTable, and so hold at 303.15 K alone\n" in answer.stderr
    wlf = "shift = {reference_temperature = 300, c1 = 8, c2 = 100}\npoisson_ratio"
    Path("ball.toml").write_text(CASE.replace("poisson_ratio", wlf))
    assert not run("export", "ball.toml", "--to", "ball.txt").stderr
    assert rs.read_material("ball.txt").material().shift == rs.WLF(300.0, 8.0, 100.0)


def test_exports_a_table_over_the_velocity() -> None:
    done("export", "ball.toml", "--to", "ball.csv", "--velocity", "10mm/s", "1")
    header, *rows = Path("ball.csv").read_text().splitlines()
    assert header == "velocity [m/s],restitution_coefficient [1],contact_time [s],max_force [N]"
    velocity, *outcome = map(float, rows[-1].split(","))
    assert velocity == pytest.approx(1.0)
    exact = rs.solve(BALL)
    expected = exact.restitution_coefficient, exact.contact_time, exact.max_force
    np.testing.assert_allclose(outcome, list(map(float, expected)), rtol=1e-6)


@pytest.mark.parametrize("case", ["sticking_bead", "thrown_ball"])
def test_a_table_with_adhesion_or_friction_has_their_own_tolerance(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """It was refused for a tolerance that no option states. The solves, of minutes, are left out here."""

    def begun(*_: Any) -> None:
        raise rs.InputError("begun", rule="")

    monkeypatch.setattr(build, "_normal", begun)
    assert refused("export", str(ROOT / "examples" / f"{case}.toml"), "--to", "e.csv", *RANGE).startswith("begun")


def test_exports_the_contact_law_with_memory() -> None:
    law = rs.contact_law(BALL)
    assert run("export", "ball.toml", "--to", "law.h").stdout.startswith("law.h: contact law of 2 terms, ")
    law.to_c("own.h")
    # The material of the file has a name.
    text, expected = (Path(name).read_text().partition("#ifndef")[2] for name in ("law.h", "own.h"))
    assert text == expected
    done("export", "ball.toml", "--to", "law.json")
    content = json.loads(Path("law.json").read_text())
    assert content["branch_moduli"] == law.modulus.branch_moduli.tolist()
    assert content["equilibrium_modulus"] == law.modulus.equilibrium_modulus


def test_exports_a_contact_law_of_few_terms_with_its_error() -> None:
    done("export", "ball.toml", "--to", "law.json", "--terms", "1", *RANGE)
    impact = replace(BALL, velocity=np.geomspace(0.01, 0.1, 9))
    law = rs.contact_law(impact).reduced(1)
    content = json.loads(Path("law.json").read_text())
    assert content["branch_moduli"] == pytest.approx(law.modulus.branch_moduli, rel=1e-6)
    assert content["restitution_error"] == pytest.approx(law.restitution_error, rel=1e-3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--to", "a.h", "--velocity", "1", "2"], "--velocity 1 2: has no meaning for a.h"),
        (["--to", "a.inp", "--terms", "2"], "--terms 2: has no meaning for a.inp"),
        (["--to", "a.h", "--terms", "0"], "Invalid value for '--terms'"),
        (["--to", "a.h", "--terms", "2", "--velocity", "2", "2"], "velocity = (2.0, 2.0): "),
        (["--to", "a.csv"], "--to a.csv: give --velocity LOW HIGH as well"),
        (["--to", "a.inp", "--velocity", "1", "2"], "--velocity 1 2: has no meaning for a.inp"),
        (["--to", "a.foo"], "--to a.foo: must end in "),
        (["--to", "no/a.inp"], "--to no/a.inp: "),
        (["--to", "a.csv", "--velocity", "1 kg", "2"], '--velocity "1 kg": '),
        (["--to", "a.csv", "--velocity", "2", "2"], "velocity = (2.0, 2.0): "),
        ([], "Missing option '--to'"),
    ],
)
def test_exports_that_are_refused_in_one_line(arguments: list[str], message: str) -> None:
    assert refused("export", "ball.toml", *arguments).startswith(message)
    assert sorted(path.name for path in Path().iterdir()) == ["ball.toml"]


def test_a_liquid_has_no_cards_of_abaqus() -> None:
    Path("ball.toml").write_text(CASE.replace('"1 MPa"', "0").replace("0.45", "0.5"))
    assert refused("export", "ball.toml", "--to", "a.inp").startswith("shear.equilibrium_modulus = 0 Pa: ")


BEAD_LINES = 'density = "1100 kg/m3"\nradius = "10 mm"\n'
PAIR = case_file(body=BEAD_LINES, material=FAST, counter_body=BEAD_LINES)
BEAD = rs.Body(BALL.material, 0.01, 1100.0 * 4.0 / 3.0 * np.pi * 0.01**3)


def test_calibrates_two_bodies_and_prints_the_lines_to_paste() -> None:
    Path("ball.toml").write_text(PAIR)
    answer = done("calibrate", "ball.toml", "--target", "lammps-viscoelastic", *RANGE, "--plot", "law.png")
    law = rs.calibrate((BEAD, BEAD), "lammps-viscoelastic", (0.01, 0.1))
    assert answer.stdout.endswith(f"\n{law.snippet}\n")
    assert str(law).splitlines()[-1] in answer.stdout
    rows = [line.split() for line in answer.stdout.splitlines() if line.startswith("  0.0")]
    exact = rs.solve(rs.collision(BEAD, BEAD, 0.01)).restitution_coefficient
    assert rows[0][:2] == ["0.01", f"{exact:.4f}"]
    assert float(rows[0][2]) == pytest.approx(law.restitution_coefficient(0.01), abs=1e-4)
    assert Path("law.png").read_bytes().startswith(b"\x89PNG")


def test_calibrates_a_ball_and_a_wall_over_sizes_in_json() -> None:
    options = ("--target", "lammps-tsuji", *RANGE, "--radius", "5 mm", "20 mm", "--units", "cgs", "--json")
    content = json.loads(done("calibrate", "ball.toml", *options).stdout)
    law = rs.calibrate(BALL, "lammps-tsuji", (0.01, 0.1), radius=(0.005, 0.02), contact="wall", units="cgs")
    assert content["snippet"] == law.snippet
    assert content["largest_error"] == pytest.approx(law.largest_error)
    assert "wall/gran" in law.snippet


@pytest.mark.parametrize("stated", ["pair", "wall"])
def test_contact_builds_the_other_one_from_the_case(stated: str) -> None:
    """A file of two beads gives a bead on a wall of its material, and a file of one bead gives two of them."""
    Path("ball.toml").write_text(PAIR if stated == "wall" else PAIR.partition("[counter_body]")[0])
    options = ("--target", "liggghts", "--velocity", "0.1", "0.1", "--contact", stated)
    content = json.loads(done("calibrate", "ball.toml", *options, "--json").stdout)
    other = BEAD if stated == "pair" else rs.Body(BALL.material)
    exact = rs.solve(rs.collision(BEAD, other, 0.1))
    assert content["wall"] == (stated == "wall")
    assert content["table"]["restitution_coefficient"][0] == pytest.approx(exact.restitution_coefficient, rel=1e-7)
    assert content["table"]["contact_time"][0] == pytest.approx(exact.contact_time, rel=1e-7)


def test_a_ball_on_a_deformable_wall_is_no_pair() -> None:
    Path("ball.toml").write_text(CASE + STEEL)
    options = ("--target", "mercury-bshp", "--velocity", "0.1", "0.1", "--json")
    ball = rs.Body(rs.elastic(youngs_modulus=210e9, poisson_ratio=0.3), 0.01, 0.005)
    content = json.loads(done("calibrate", "ball.toml", *options).stdout)
    exact = rs.solve(rs.collision(ball, rs.Body(BALL.material), 0.1))
    assert content["wall"]
    assert content["table"]["contact_time"][0] == pytest.approx(exact.contact_time, rel=1e-7)


def test_friction_of_an_option_or_of_the_case_is_in_the_text() -> None:
    Path("ball.toml").write_text(PAIR)
    options = ("--target", "liggghts", "--velocity", "0.1", "0.1", "--angle", "10 deg", "70 deg", "--json")
    content = json.loads(done("calibrate", "ball.toml", *options, "--friction", "0.4").stdout)
    law = rs.calibrate((BEAD, BEAD), "liggghts", 0.1, friction=0.4, angle=np.radians([10.0, 70.0]))
    assert content["snippet"] == law.snippet
    assert content["angles"]["exact"] == pytest.approx(law.angles.exact)
    thrown = CASE.replace("[impact]", '[impact]\nfriction = 0.4\nangle = "30 deg"')
    Path("ball.toml").write_text(thrown)
    content = json.loads(done("calibrate", "ball.toml", *options).stdout)
    assert content["angles"]["friction"] == 0.4
    assert done("export", "ball.toml", "--to", "ball.h").stdout.startswith("ball.h: contact law of")
    assert "contact_law_slide" in Path("ball.h").read_text()
    done("export", "ball.toml", "--to", "ball.json")
    assert json.loads(Path("ball.json").read_text())["friction"] == 0.4


def test_calibrates_to_a_given_restitution() -> None:
    options = ("--target", "mujoco-solref", *RANGE, "--restitution", "0.5", "--json")
    e = json.loads(done("calibrate", "ball.toml", *options).stdout)["table"]["calibrated_restitution_coefficient"]
    assert e == pytest.approx([0.5] * len(e))


def test_calibrates_to_a_measured_table() -> None:
    Path("e.csv").write_text("v [cm/s],e,sd_e\n40,0.78,0.01\n10,0.85,0.01\n100,0.7,0.01\n")
    options = ("--target", "mercury-bshp", "--restitution", "e.csv")
    content = json.loads(done("calibrate", "ball.toml", *options, "--json").stdout)
    law = rs.calibrate(BALL, "mercury-bshp", restitution=([0.1, 0.4, 1.0], [0.85, 0.78, 0.7]))
    assert content["table"]["velocity"] == pytest.approx([0.1, 0.4, 1.0])
    assert content["snippet"] == law.snippet
    narrow = json.loads(done("calibrate", "ball.toml", *options, "--velocity", "0.2", "2 m/s", "--json").stdout)
    assert narrow["table"]["velocity"] == pytest.approx([0.4, 1.0])
    # Columns of the ball say nothing new.
    Path("e.csv").write_text("v [cm/s],e,radius [mm],mass [g]\n40,0.78,10,5\n10,0.85,10,5\n100,0.7,10,5\n")
    content = json.loads(done("calibrate", "ball.toml", *options, "--json").stdout)
    assert content["snippet"] == law.snippet


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("v [cm/s],e\n10,0.85\n40,1.78\n", "line 3: restitution_coefficient = 1.78: "),
        ("v [m/s],x\n10,0.85\n", "line 1: "),
        ("v [m/s],e,radius [mm]\n0.1,0.85,10\n0.4,0.8,5\n", "radius = 0.005 m: must be that of the ball"),
        ("v [m/s],e,mass [g]\n0.1,0.85,5\n0.4,0.8,6\n", "mass = 0.006 kg: must be that of the ball"),
        ("", ""),
        (None, ""),
    ],
)
def test_tables_of_restitution_that_are_refused_in_one_line(table: str | None, message: str) -> None:
    if table is not None:
        Path("e.csv").write_text(table)
    options = "--target", "mercury-bshp", "--restitution", "e.csv"
    assert refused("calibrate", "ball.toml", *options).startswith(f"e.csv: {message}")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["--target", "lammps", *RANGE],
            "target = 'lammps': is not known; did you mean lammps-viscoelastic, lammps-tsuji or lammps-coeff-restitution?",
        ),
        (["--target", "rebound"], "Missing option '--velocity'"),
        (["--target", "rebound", "--velocity", "1 kg", "2"], '--velocity "1 kg": '),
        (["--target", "rebound", "--velocity", "-1", "1"], "velocity"),
        (["--target", "rebound", *RANGE, "--radius", "1 s", "2"], '--radius "1 s": '),
        (["--target", "rebound", *RANGE, "--units", "cgs"], "units"),
        (["--target", "rebound", *RANGE, "--contact", "floor"], "contact"),
        (["--target", "rebound", *RANGE, "--restitution", "1.5"], "restitution"),
        (["--target", "rebound", *RANGE, "--plot", "law.doc"], "--plot law.doc: "),
    ],
)
def test_calibrations_that_are_refused_in_one_line(arguments: list[str], message: str) -> None:
    assert refused("calibrate", "ball.toml", *arguments).startswith(message)


def test_fractional_materials_hold_for_the_contacts_of_all_velocities() -> None:
    fractional = FAST.replace('viscosity = "1 kPa s"', 'relaxation_time = "1 ms"\nexponent = 0.4')
    case_file("ball.toml", material=f'model = "fractional_zener"\n{fractional}')
    content = json.loads(done("calibrate", "ball.toml", "--target", "rebound", *RANGE, "--json").stdout)
    material = rs.fractional_zener(1e6, 1e7, 1e-3, 0.4)
    for place in (0, -1):
        v = content["table"]["velocity"][place]
        impact = rs.for_contact(
            lambda window, v=v: rs.Impact(
                rs.FractionalMaterial(material, 2.9e7 / 3.0).within(window), rs.Parabola(0.01), 0.005, v
            )
        )
        e = rs.solve(impact).restitution_coefficient
        assert content["table"]["restitution_coefficient"][place] == pytest.approx(e, rel=1e-5)


def test_a_law_that_cannot_reach_the_restitution_is_refused() -> None:
    message = refused("calibrate", "ball.toml", "--target", "liggghts", *RANGE, "--restitution", "0.01")
    assert message.startswith("target = 'liggghts': ")


@pytest.mark.parametrize(
    ("options", "key"),
    [
        (("--to", "law.h"), "state_size"),
        (("--to", "law.json", "--terms", "1", *RANGE), "restitution_error"),
        (("--to", "e.csv", *RANGE), "error"),
        (("--to", "ball.inp"), "materials"),
    ],
)
def test_exports_answer_in_json(options: tuple[str, ...], key: str) -> None:
    words, content = run("export", "ball.toml", *options), run("export", "ball.toml", *options, "--json")
    numbers = json.loads(content.stdout)
    assert numbers["file"] == options[1]
    assert key in numbers
    assert content.stderr == ""
    assert [f"warning: {line}" for line in numbers["warnings"]] == words.stderr.splitlines()
    assert words.stdout.startswith(f"{options[1]}: ")


GRAINS = """
[body]
radius = "10 um"
density = 1200
[counter_body]
radius = "10 um"
density = 1200
[profile]
type = "parabola"
[material]
model = "standard_solid"
equilibrium_modulus = "1 GPa"
branch_modulus = "1 GPa"
viscosity = 20
poisson_ratio = 0.35
[impact]
velocity = "1 m/s"
[adhesion]
work = "50 mJ/m^2"
stress = "10 MPa"
"""


@pytest.mark.slow
def test_calibrates_laws_with_cohesion_of_a_case_with_adhesion() -> None:
    """The numbers are those of `rs.calibrate` with the adhesion of the file; other targets are refused in one line."""
    Path("grains.toml").write_text(GRAINS)
    options = "--target", "lammps-dmt-viscoelastic", "--velocity", "0.2", "0.5", "--json"
    answer = json.loads(done("calibrate", "grains.toml", *options).stdout)
    polymer = rs.standard_solid(1e9, 1e9, 20.0, poisson_ratio=0.35)
    grain = rs.Body(replace(polymer, density=1200.0), radius=10e-6)
    law = rs.calibrate((grain, grain), options[1], (0.2, 0.5), adhesion=rs.Adhesion(0.05, stress=1e7))
    assert answer["parameters"]["gamma"]["value"] == pytest.approx(law.parameters["gamma"].value, rel=1e-6)
    assert answer["sticking_velocity"] == pytest.approx(law.sticking_velocity)
    assert "adhesion" in refused("calibrate", "grains.toml", "--target", "lammps-tsuji", "--velocity", "0.2", "0.5")


def test_exports_the_law_of_a_case_with_adhesion() -> None:
    """The header has the range of the attraction, work over stress; a law with adhesion keeps its terms."""
    Path("grains.toml").write_text(GRAINS)
    size = rs.contact_law(rs.read_case("grains.toml").impact).state_size
    words = f"law.h: contact law of 2 terms, {size} numbers a contact\n"
    assert done("export", "grains.toml", "--to", "law.h").stdout == words
    assert "#define CONTACT_LAW_RANGE 5e-09" in Path("law.h").read_text()
    done("export", "grains.toml", "--to", "law.json")
    assert json.loads(Path("law.json").read_text())["stress"] == 1e7
    assert "adhesion" in refused("export", "grains.toml", "--to", "law.h", "--terms", "1")
    assert "adhesion" in refused("export", "grains.toml", "--to", "law.h", "--terms", "1", "--velocity", "0.1", "1")
