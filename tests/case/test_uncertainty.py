"""Standard deviations in case files against powers of closed forms, and refusals that name the key."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import restitution as rs
from cases import IMPACT, SOLID, case_file, press_file
from commands import done
from refusals import in_one_line, named
from restitution.case.indentation import read_indentation
from restitution.case.sweep import read_sweep
from restitution.case.uncertainty import propagate_case
from restitution.errors import InputError
from restitution.units import MODULUS, NUMBER, TEMPERATURE, deviation_in_si, split_deviation, to_si, with_error

pytestmark = pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning")
RNG = np.random.default_rng()
ELASTIC = 'model = "elastic"\nshear_modulus = "1 MPa +- 4 %"\nbulk_modulus = "incompressible"\n'


@pytest.mark.parametrize("sign", ["+-", "+/-", "±"])
def test_a_value_is_parted_from_its_deviation(sign: str) -> None:
    for text in (f"10 {sign} 0.5 MPa", f"(10{sign}0.5) MPa", f"10 MPa {sign} 0.5 MPa", f"1e1 MPa{sign} 5 %"):
        plain, deviation = split_deviation(text)
        value = to_si(plain, MODULUS)
        assert value == 1e7
        assert deviation_in_si(deviation, value, MODULUS) == pytest.approx(5e5, rel=1e-12)


def test_temperatures_scatter_by_differences() -> None:
    plain, deviation = split_deviation("-20 ± 0.5 degC")
    value = to_si(plain, TEMPERATURE)
    assert value == pytest.approx(253.15, abs=1e-12)
    assert deviation_in_si(deviation, value, TEMPERATURE) == pytest.approx(0.5, abs=1e-12)


@pytest.mark.parametrize(
    "text",
    [
        "10 +- MPa",
        "+- 0.5 MPa",
        "10 +- 0.5 +- 0.1 MPa",
        "(10 +- 0.5 MPa",
        "a +- b",
        "0.45 +- 2 %",
        "1 +- " + "9" * 300,
    ],
)
def test_other_forms_are_refused(text: str) -> None:
    in_one_line(lambda: split_deviation(text))


@pytest.mark.parametrize("text", ["0 MPa", "-1 MPa", "inf MPa", "1 s", "1"])
def test_other_deviations_are_refused(text: str) -> None:
    in_one_line(lambda: deviation_in_si(text, 1e7, MODULUS))


def test_percent_of_a_percentage_is_one_of_the_whole() -> None:
    plain, deviation = split_deviation("(45 +- 1) %")
    assert to_si(plain, NUMBER) == 0.45
    assert deviation_in_si(deviation, 0.45, NUMBER) == 0.01


@pytest.mark.parametrize(
    ("value", "deviation", "unit", "text"),
    [
        (0.78662, 0.01234, "", "0.787 +- 0.012"),
        (0.78662, 0.0996, "", "0.79 +- 0.10"),
        (1.5e-3, 2e-4, "s", "1.50 +- 0.20 ms"),
        (123.4, 56.7, "N", "123 +- 57 N"),
        (12345.0, 5678.0, "kg/m^3", "12300 +- 5700 kg/m^3"),
        (2.0, 0.0, "", "2 +- 0"),
    ],
)
def test_two_digits_of_the_deviation_are_shown(value: float, deviation: float, unit: str, text: str) -> None:
    assert " ".join(with_error(value, deviation, unit)).rstrip() == text


def test_keys_of_any_section(tmp_path: Path) -> None:
    """T ~ (m^2/(E*^2 R v))^(1/5) with m ~ rho R^3 and v ~ sqrt(h): powers 0.4, 1, -0.4 and -0.1 of rho, R, G and h."""
    sizes = dict(zip(("density", "radius", "height"), RNG.uniform(0.5, 3.0, 3).tolist(), strict=True))
    file = tmp_path / "ball.toml"
    case_file(
        file,
        body=f'density = "1100 kg/m^3 +- {sizes["density"]} %"\nradius = "10 mm"',
        material=ELASTIC,
        impact=f'drop_height = "50 +- {0.5 * sizes["height"]} mm"',
        uncertainty=f'deviations = {{ radius = "{0.1 * sizes["radius"]} mm" }}\noutputs = ["contact_time"]',
    )
    case = rs.read_case(file)
    assert case.impact.profile.numbers["radius"] == 0.01
    result = propagate_case(case)
    parts = [0.4 * sizes["density"], 1.0 * sizes["radius"], 0.4 * 4.0, 0.1 * sizes["height"]]
    value, deviation = result["contact_time"]
    assert deviation / value == pytest.approx(0.01 * math.hypot(*parts), rel=1e-7)
    shares = dict(zip(result.inputs, result.shares[0], strict=True))
    assert shares["material.shear_modulus"] == pytest.approx(1.6**2 / sum(part**2 for part in parts), rel=1e-6)


def test_entries_of_lists(tmp_path: Path) -> None:
    """The same numbers by the door of Python."""
    file = tmp_path / "ball.toml"
    shear = 'shear = { equilibrium_modulus = "1 MPa", branch_moduli = "[4 +- 0.2, 3 +- 0.1] MPa", '
    shear += 'relaxation_times = ["0.1 ms", "2 ± 0.1 ms"] }\nbulk_modulus = "1 GPa"'
    case_file(file, material=shear)
    result = propagate_case(rs.read_case(file))
    solid = rs.Material(rs.PronySeries(1e6, [4e6, 3e6], [1e-4, 2e-3]), 1e9)
    ball = rs.Impact(solid, rs.Parabola(0.01), mass=0.005, velocity=1.0)
    names = {"branch_moduli[0]": 2e5, "branch_moduli[1]": 1e5, "relaxation_times[1]": 1e-4}
    same = rs.uncertainty(ball, names)
    assert result.covariance == pytest.approx(same.covariance, rel=1e-7)


def test_key_that_takes_no_array(tmp_path: Path) -> None:
    """The exponent of a power law splits the impacts; F = c d^(1 + 1/n) on an elastic body has T by a beta function."""
    file = tmp_path / "tip.toml"
    profile = 'type = "power_law"\nexponent = "2.5 +- 0.01"\ncoefficient = 50.0'
    case_file(file, profile=profile, material=ELASTIC.replace(" +- 4 %", ""))
    result = propagate_case(rs.read_case(file))
    ends = [rs.solve(rs.Impact(rs.elastic(shear_modulus=1e6, bulk_modulus=np.inf), rs.PowerLaw(n, 50.0), 0.005, 1.0))
            for n in (2.49, 2.51)]  # fmt: skip
    difference = 0.5 * abs(float(ends[1].contact_time) - float(ends[0].contact_time))
    # A difference over 0.8 % errs by the square of it.
    assert result["contact_time"][1] == pytest.approx(difference, rel=1e-3)


def test_the_command_prints_deviations(tmp_path: Path) -> None:
    file = tmp_path / "ball.toml"
    case_file(file, material=SOLID.replace("10 MPa", "10 +- 0.5 MPa"), impact='velocity = "1 +- 0.02 m/s"')
    shown = done("solve", str(file)).stdout
    result = propagate_case(rs.read_case(file))
    value, deviation = result["restitution_coefficient"]
    lines = [line for line in shown.splitlines() if line.startswith("e = ")]
    assert len(lines) == 1
    number, spread = (float(word) for word in lines[0].split()[2:5:2])
    # The deviation has two digits, and the value as many places.
    assert spread == pytest.approx(deviation, rel=0.05)
    assert number == pytest.approx(value, abs=0.05 * deviation)
    assert "velocity" in lines[0]
    content: Any = json.loads(done("solve", str(file), "--json").stdout)
    numbers = content["uncertainty"]
    assert numbers["standard_deviations"]["restitution_coefficient"] == pytest.approx(deviation, rel=1e-12)
    assert numbers["status"] == "LINEAR"
    assert content["restitution_coefficient"] == pytest.approx(value, rel=1e-8)


@pytest.mark.parametrize(
    "command",
    [
        ("bounce",),
        ("resilience",),
        ("surrogate", "--velocity", "0.9", "1", "--rtol", "1e-2"),
        ("export", "--to", "law.h"),
        ("export", "--to", "solid.inp"),
        ("calibrate", "--target", "liggghts", "--velocity", "0.9", "1"),
    ],
)
def test_commands_without_deviations_say_so(folder: Path, command: tuple[str, ...]) -> None:
    for solid, count in ((SOLID, 0), (SOLID.replace("10 MPa", "10 +- 0.5 MPa"), 1)):
        case_file("ball.toml", material=solid, impact='velocity = "0.1 m/s"\nweight = false')
        notes = done(command[0], "ball.toml", *command[1:]).stderr.replace("\n", " ")
        assert notes.count("takes standard deviations to the outputs") == count


def test_a_case_without_deviations_prints_none(tmp_path: Path) -> None:
    file = tmp_path / "ball.toml"
    case_file(file)
    assert "+-" not in done("solve", str(file)).stdout
    assert "uncertainty" not in json.loads(done("solve", str(file), "--json").stdout)


def test_draws_of_a_case_are_repeatable(tmp_path: Path) -> None:
    file = tmp_path / "ball.toml"
    case_file(file, impact='velocity = "1 +- 0.02 m/s"', uncertainty="draws = 50\nseed = 4")
    first, second = (propagate_case(rs.read_case(file)) for _ in range(2))
    assert first.drawn is not None
    assert second.drawn is not None
    assert first.drawn.mean == second.drawn.mean
    assert first.drawn.number == 50


@pytest.mark.parametrize(
    ("sections", "where"),
    [
        ({"impact": 'velocity = "1 +- 0.1 mm"'}, ("impact.velocity", "1 mm")),
        ({"impact": 'velocity = "1 +- 0 m/s"'}, ("impact.velocity", "0 m/s")),
        ({"impact": 'velocity = "1 +- m/s"'}, ("impact.velocity", "1 +- m/s")),
        ({"material": SOLID.replace("0.45", '"0.45 +- 2 %"')}, ("material.poisson_ratio", "0.45 +- 2 %")),
        ({"uncertainty": "draws = 50"}, ("uncertainty",)),
        ({"uncertainty": 'deviations = { speed = "1 m/s" }'}, ("uncertainty.deviations.speed",)),
        ({"uncertainty": 'deviations = { velocity = "1 s" }'}, ("uncertainty.deviations.velocity", "1 s")),
        ({"uncertainty": "deviations = { velocity = true }"}, ("uncertainty.deviations.velocity", True)),
        ({"uncertainty": 'deviations = { gravity = "1 m/s^2" }'}, ("uncertainty.deviations.gravity",)),
        (
            {"impact": 'velocity = "1 +- 0.1 m/s"', "uncertainty": "deviations = { velocity = 0.1 }"},
            ("uncertainty.deviations.velocity",),
        ),
        ({"impact": 'velocity = "1 +- 0.1 m/s"', "uncertainty": 'outputs = ["speed"]'}, ("uncertainty.outputs", ["speed"])),
        ({"impact": 'velocity = "1 +- 0.1 m/s"', "uncertainty": "draws = 1"}, ("uncertainty.draws", 1)),
        (
            {"impact": 'velocity = "1 +- 0.1 m/s"', "solver": 'method = "elements"'},
            ("solver.method", "elements"),
        ),
        ({"solver": 'rtol = "1e-9 +- 1e-10"'}, ("solver.rtol", "1e-9 +- 1e-10")),
    ],
)  # fmt: skip
def test_refused(tmp_path: Path, sections: dict[str, str], where: tuple[Any, ...]) -> None:
    file = tmp_path / "ball.toml"
    case_file(file, **sections)
    assert named(lambda: propagate_case(rs.read_case(file)))[: len(where)] == where


def test_a_fractional_material_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "ball.toml"
    material = 'model = "springpot"\ncoefficient = 1e5\nexponent = "0.3 +- 0.01"\nbulk_modulus = "incompressible"'
    case_file(file, material=material)
    assert named(lambda: propagate_case(rs.read_case(file))) == ("material.model",)


def test_other_files_have_no_deviations(tmp_path: Path) -> None:
    file = tmp_path / "press.toml"
    press_file(str(file), profile='radius = "2.5 +- 0.1 um"')
    assert named(lambda: read_indentation(file), InputError) == ("profile.radius", "2.5 +- 0.1 um")
    case_file(file, impact=IMPACT, axes="mass = [0.005, 0.01]", uncertainty="draws = 10")
    assert named(lambda: read_sweep(file)) == ("uncertainty",)
