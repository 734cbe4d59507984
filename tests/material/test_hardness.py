"""Shore hardness: numbers of the sources, and the mechanics of a durometer."""

import json
import math
from pathlib import Path

import pytest

from commands import done, refused
from refusals import named
from restitution import shore_modulus
from restitution.material.hardness import read_hardness

pytestmark = pytest.mark.usefixtures("folder")


@pytest.mark.parametrize("hardness", [20.0, 41.5, 60.0, 80.0])
def test_scale_a(hardness: float) -> None:
    result = shore_modulus(hardness)
    # log10(E/MPa) = 0.0235 S - 0.6403, of the abstract of Qi, Joyce and Boyce.
    assert result.by_source["qi_2003"] == pytest.approx(1e6 * 10 ** (0.0235 * hardness - 0.6403))
    # A flat punch of the mean radius of the blunt cone, with the spring and the way of a durometer: E = 0.75 F/(2 R d).
    # Gent's constant 0.137505 stands for 2 R 0.1/(0.75 mm): R = 0.5156 mm, between 0.395 mm and the radius further up.
    force, depth = 9.81e-3 * (56.0 + 7.66 * hardness), 2.54e-3 * (1.0 - hardness / 100.0)
    assert result.by_source["gent_1958"] == pytest.approx(0.75 * force / (2.0 * 0.5156e-3 * depth), rel=5e-3)
    assert (
        result.low
        < min(result.by_source.values())
        < result.youngs_modulus
        < max(result.by_source.values())
        < result.high
    )


@pytest.mark.parametrize("hardness", [30.0, 52.0, 85.0])
def test_scale_d(hardness: float) -> None:
    result = shore_modulus(hardness, "D")
    # The relation of a cone of 15 degrees as it is usually printed, with E in MPa and rounded constants.
    modulus = result.by_source["sneddon_1965"] / 1e6
    reading = 100.0 - 20.0 * (-78.188 + math.sqrt(6113.36 + 781.88 * modulus)) / modulus
    assert reading == pytest.approx(hardness, abs=0.6)
    assert result.by_source["qi_2003"] == pytest.approx(1e6 * 10 ** (0.0235 * (hardness + 50.0) - 0.6403))
    assert result.shear_modulus == result.youngs_modulus / 3.0


def test_readings_outside_of_the_scales_are_refused() -> None:
    assert named(lambda: shore_modulus(81.0)) == ("hardness", 81.0)
    assert named(lambda: shore_modulus(20.0, "D")) == ("hardness", 20.0)
    assert named(lambda: shore_modulus(50.0, "OO")) == ("scale", "OO")


@pytest.mark.parametrize("text", ["60 Shore A", "60A", "shore a 60", "60 ShA", "Sh A 60.0", "60 a"])
def test_texts_are_read(text: str) -> None:
    assert read_hardness(text) == (60.0, "A")


def test_the_command_shows_a_start_with_its_scatter() -> None:
    content = json.loads(done("material", "60 Shore A", "--json").stdout)
    result = shore_modulus(60.0)
    assert (content["lowest_youngs_modulus_Pa"], content["gent_1958_Pa"]) == (
        result.low,
        result.by_source["gent_1958"],
    )
    assert f'lognormal = ["1.54 MPa", {0.5 * math.log(result.high / result.low):.2g}]' in content["notes"][0]
    assert "e = 1" in refused("solve", "--material", "60 Shore A")
    # A file of this name is a file.
    Path("60A").write_text("t,E\ns,MPa\n1,2\n2,1.5\n3,1.2\n10,1\n")
    assert "hardness" not in done("material", "60A").stdout
