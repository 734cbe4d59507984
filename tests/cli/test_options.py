"""The command solve without a case file: what it asks for, and that its case is that of a file."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import restitution as rs
from cases import case_file, isotherms_file
from commands import done, refused, run
from refusals import refusal

pytestmark = pytest.mark.usefixtures("folder")

BALL = ("--radius", "10mm", "--density", "1100", "--velocity", "20 mm/s")


def numbers(*arguments: str) -> Any:
    return json.loads(done("solve", *arguments, "--json", "--extrapolate").stdout)


def relaxation_file(name: str, label: str = "E") -> None:
    t = np.geomspace(1e-6, 1e3, 91)
    series = rs.PronySeries(3e6, [4e6, 9e6], [1e-3, 1.0])
    rows = "\n".join(f"{a!r},{b!r}" for a, b in zip(t.tolist(), series.relaxation_modulus(t).tolist(), strict=True))
    Path(name).write_text(f"t,{label}\ns,Pa\n{rows}\n", encoding="utf-8")


def test_the_case_of_options_is_that_of_a_file_written_by_hand() -> None:
    isotherms_file("iso.csv")
    body = 'radius = "10 mm"\ndensity = "1100 kg/m^3"'
    material = 'file = "iso.csv"\ntemperature = "23 degC"\npoisson_ratio = 0.49'
    case_file("by_hand.toml", body=body, material=material, impact='velocity = "20 mm/s"')
    expected = numbers("by_hand.toml")
    options = ("--material", "iso.csv", "--temperature", "23degC", "--poisson-ratio", "0.49", *BALL)
    answer = numbers(*options, "--save", "saved.toml", "--plot", "p.png")
    for content in (answer, numbers("saved.toml")):
        assert content["restitution_coefficient"] == expected["restitution_coefficient"]
        assert content["contact_time"] == expected["contact_time"]
    assert Path("p.png").read_bytes().startswith(b"\x89PNG")
    saved, by_hand = (rs.read_case(name).impact for name in ("saved.toml", "by_hand.toml"))
    assert (saved.material, saved.mass, saved.velocity) == (by_hand.material, by_hand.mass, by_hand.velocity)


def test_a_saved_case_finds_the_file_of_the_material_from_its_own_folder() -> None:
    relaxation_file("data.csv")
    Path("cases").mkdir()
    done("solve", "--material", "data.csv", "--bulk-modulus", "2 GPa", *BALL, "--save", "cases/ball.toml")
    assert rs.read_case("cases/ball.toml").content["material"]["file"] == "../data.csv"
    assert 0.0 < numbers("cases/ball.toml")["restitution_coefficient"] < 1.0


def test_all_that_is_missing_is_asked_for_at_once() -> None:
    isotherms_file("iso.csv")
    relaxation_file("data.csv", "modulus")
    Path("shares.csv").write_text("tau,alpha\ns,\n0.001,0.5\n")
    message = refused("solve", "--material", "iso.csv")
    for option in (
        "--radius",
        "--mass",
        "--density",
        "--velocity",
        "--drop-height",
        "--poisson-ratio",
        "--temperature",
    ):
        assert option in message
    assert "from 10 to 40 °C" in message
    assert "--tension" not in message
    assert refused("solve", "--radius", "1 cm") == (
        "missing: --mass, or --density of a solid ball; --velocity or --drop-height; --material FILE, or a name of "
        "the library"
    )
    message = refused("solve", "--material", "data.csv", "--temperature", "23degC", *BALL)
    assert "--poisson-ratio" in message
    assert message.endswith("--shift or --wlf for --temperature, as data.csv has moduli at one alone")
    message = refused("solve", "--material", "data.csv", "--poisson-ratio", "0.5", *BALL)
    assert message == "missing: --tension or --shear, as data.csv does not state which moduli it has"
    message = refused("solve", "--material", "shares.csv", *BALL, "--shear", "--poisson-ratio", "0.5")
    assert message == "missing: --instantaneous-modulus or --equilibrium-modulus"


def test_mistakes_have_the_names_of_the_options() -> None:
    relaxation_file("data.csv")
    answer = run("solve", "--material", "data.csv", "--radius", "1 kg", "--mass", "-1", "--drop-height", "1m",
                 "--poisson-ratio", "0.6")  # fmt: skip
    assert answer.exit_code == 2
    assert {line.split()[1] for line in answer.stderr.splitlines()} == {"--radius", "--mass", "--poisson-ratio"}
    for options, named in (
        (["--shear", "--tension"], "--tension, --shear"),
        (["--temperature", "23degC"], "--temperature"),  # no law of the shift
        (["--shear"], "tension"),  # contradicts the file
    ):
        assert named in refused("solve", "--material", "data.csv", "--poisson-ratio", "0.5", *BALL, *options)


def test_a_case_file_and_options_exclude_each_other() -> None:
    case_file("ball.toml")
    assert refused("solve", "ball.toml", "--radius", "1 cm").startswith("--radius: ball.toml")
    assert refused("solve", "ball.toml", "--save", "b.toml").startswith("--save: ball.toml")
    assert "--material" in refused("solve")
    assert "give it alone" in refused("solve", "--material", "ball.toml")
    assert "did you mean epoxy" in refused("solve", "--material", "epoxi", *BALL)


def test_moduli_in_shear_and_in_tension_differ_by_a_factor_of_three() -> None:
    relaxation_file("tension.csv")
    relaxation_file("open.csv", "modulus")
    stated = numbers("--material", "tension.csv", "--poisson-ratio", "0.5", *BALL)
    told = numbers("--material", "open.csv", "--tension", "--poisson-ratio", "0.5", *BALL)
    sheared = numbers("--material", "open.csv", "--shear", "--poisson-ratio", "0.5", *BALL)
    assert told["max_force"] == stated["max_force"] < sheared["max_force"]
    # A layer of the same material is stiffer than a half-space of it.
    layer = numbers(
        "--material", "tension.csv", "--poisson-ratio", "0.45", *BALL, "--thickness", "2mm", "--base", "bonded"
    )
    assert layer["max_force"] > stated["max_force"]


def test_a_table_needs_no_shift_at_its_own_temperature() -> None:
    omega = np.geomspace(1e-2, 1e5, 40)
    series = rs.PronySeries(3e6, [4e6], [1e-3])
    rows = [f"{w!r},{a!r},{b!r},23.2" for w, a, b in zip(
        omega.tolist(), series.storage_modulus(omega).tolist(), series.loss_modulus(omega).tolist(), strict=True)]  # fmt: skip
    Path("one.csv").write_text("\n".join(["omega,G',G'',T", "rad/s,Pa,Pa,°C", *rows]))
    common = ("--material", "one.csv", "--poisson-ratio", "0.5", *BALL)
    assert numbers(*common, "--temperature", "23 degC") | {"version": 0} == numbers(*common) | {"version": 0}
    assert "shift" in refused("solve", *common, "--temperature", "40 degC")


def test_values_with_standard_deviations_reach_the_outputs() -> None:
    options = ("--material", "epoxy", "--radius", "10 +- 0.1 mm", "--mass", "5 g", "--velocity", "1 m/s")
    deviations = numbers(*options)["uncertainty"]
    done("solve", *options, "--save", "saved.toml")
    assert deviations == numbers("saved.toml")["uncertainty"]


def test_a_material_of_the_library_has_its_own_constants() -> None:
    mass = 4 / 3 * np.pi * 0.01**3 * 7800
    impact = rs.Impact(rs.library.get("epoxy"), rs.Parabola(0.01), mass=mass, velocity=0.02)
    answer = numbers("--material", "epoxy", "--radius", "10 mm", "--density", "7800", "--velocity", "0.02")
    expected = float(rs.solve(impact).restitution_coefficient)
    assert answer["restitution_coefficient"] == pytest.approx(expected, rel=1e-12)


def test_a_file_section_states_all_that_it_lacks() -> None:
    relaxation_file("data.csv", "modulus")
    case_file("ball.toml", material='file = "data.csv"')
    error = refusal(lambda: rs.read_case("ball.toml"))
    assert [mistake.field for mistake in error.mistakes] == ["material", "material.deformation"]
