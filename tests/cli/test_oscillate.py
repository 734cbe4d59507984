"""The commands oscillate and tap: tables, files and refusals."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import restitution as rs
from cases import case_file
from checkout import EXAMPLES
from commands import done, refused
from refusals import named
from restitution.case.oscillation import read_oscillation, read_tapping

# Row T1 and the table of the design page on cycles, scaled: E* = E (1 + 4 exp(-t/tau)) with E = 1 MPa, tau = 1 us,
# lengths of 10 nm. In shear the moduli are a quarter.
SOLID = """
bulk_modulus = "incompressible"
shear = { equilibrium_modulus = "0.25 MPa", branch_moduli = "[1] MPa", relaxation_times = "[1] us" }
"""
WAVE = 'depth = "10 nm"\namplitude = "1 nm"\nfrequency = "159.15494309189535 kHz"\n'
TAP = """
distance = "[8] nm"
spring_constant = "0.01 N/m"
quality_factor = 10
frequency = "159.15494309189535 kHz"
free_amplitude = "10 nm"
"""


def indenter(path: str, **sections: str) -> None:
    case_file(path, body=None, impact=None, profile='radius = "10 nm"', material=SOLID, **sections)


@pytest.fixture(autouse=True)
def _files(folder: Path) -> None:
    indenter("wave.toml", oscillation=WAVE)
    indenter("tap.toml", tapping=TAP)


def test_an_oscillation() -> None:
    answer = done("oscillate", "wave.toml", "--plot", "loop.png")
    lines = [" ".join(line.split()) for line in answer.stdout.splitlines()]
    assert "storage modulus E' 3 MPa" in lines
    assert "loss modulus E'' 2 MPa" in lines
    assert lines[-1] == "the steady state"
    assert Path("loop.png").stat().st_size > 10_000
    content = json.loads(done("oscillate", "wave.toml", "--json").stdout)
    assert 100.0 * content["storage_error"] == pytest.approx(-3.8, abs=0.05)
    assert 100.0 * content["loss_error"] == pytest.approx(-7.3, abs=0.05)
    assert content["status"] == "STEADY"


AXES = """
frequency = { logarithmic = ["10 kHz", "1 MHz"], n = 3 }
amplitude = "[0.5, 1] nm"
"""


def test_oscillations_over_axes() -> None:
    """Each row is a single oscillation; the modulus and the time of a standard solid follow its viscosity."""
    solid = (
        'model = "standard_solid"\nequilibrium_modulus = "0.25 MPa"\nbranch_modulus = "1 MPa"\npoisson_ratio = 0.5\n'
    )
    wave = 'depth = "10 nm"\n'
    case_file("axes.toml", body=None, impact=None, profile='radius = "10 nm"', material=solid + 'viscosity = "1 Pa s"',
              oscillation=wave, axes=AXES + 'material.viscosity = "[1, 4] Pa s"')  # fmt: skip
    content = json.loads(done("oscillate", "axes.toml", "--json", "--out", "waves.csv", "--plot", "errors.png").stdout)
    assert np.shape(content["loss_error"]) == (2, 2, 3)
    case_file("one.toml", body=None, impact=None, profile='radius = "10 nm"', material=solid + 'viscosity = "4 Pa s"',
              oscillation=wave + 'frequency = "1 MHz"\namplitude = "0.5 nm"')  # fmt: skip
    single = json.loads(done("oscillate", "one.toml", "--json").stdout)
    waves = read_oscillation("axes.toml").solve()
    assert isinstance(waves, rs.OscillationArray)
    table = waves.to_dataset()
    assert table["loss_error"].sel(viscosity=4.0, frequency=1e6, amplitude=0.5e-9) == pytest.approx(
        single["loss_error"], rel=1e-12
    )
    with Path("waves.csv").open() as file:
        rows = list(csv.reader(file))
    assert len(rows) == 13
    assert {"frequency [1/s]", "amplitude [m]", "viscosity [Pa s]"} <= set(rows[0])


@pytest.mark.parametrize(
    ("axes", "field"),
    [
        ('depth = "[1, 2] nm"', "oscillation.depth"),
        ('frequency = "[1, 2] nm"', "axes.frequency"),
        ("velocity = [1.0]", "axes.velocity"),
        ("nonsense = [1.0]", "axes.nonsense"),
        ("", "axes"),
    ],
)
def test_mistakes_of_axes(axes: str, field: str) -> None:
    indenter("wave.toml", oscillation=WAVE, axes=axes)
    assert named(lambda: read_oscillation("wave.toml"))[0] == field
    assert refused("oscillate", "wave.toml").startswith(f"wave.toml: {field}")


def test_taps() -> None:
    content = json.loads(done("tap", "tap.toml", "--json", "--out", "curve.csv", "--plot", "curve.png").stdout)
    assert content["amplitude"] == pytest.approx([9.25092312856e-9], rel=1e-8)
    with Path("curve.csv").open() as file:
        header, row = csv.reader(file)
    assert header[:2] == ["distance [m]", "amplitude [m]"]
    assert float(row[1]) == pytest.approx(9.25092312856e-9, rel=1e-8)
    assert Path("curve.png").stat().st_size > 10_000
    assert "PERIODIC" in done("tap", "tap.toml").stdout


def test_taps_that_cannot_be_solved_or_do_not_become_periodic_have_a_warning() -> None:
    """Far above its resonance a cantilever has no swing that a tap could begin with; few taps are not periodic."""
    for option, words in (('resonance_frequency = "1 mHz"', "could not be solved"), ("max_taps = 4", "not become")):
        indenter("tap.toml", tapping=TAP.replace("[8]", "[8, 7]") + option)
        (line,) = done("tap", "tap.toml").stderr.splitlines()
        assert line.startswith("warning: at 8 nm and 1 more: ")
        assert words in line


def test_taps_of_several_modes() -> None:
    """A beam, and its second mode by numbers: 6.2669 times the frequency, 39.27 times the stiffness."""
    mode = "{ spring_constant = 0.39273, frequency = 997368, quality_factor = 30 }"
    answers: list[dict[str, list[list[float]]]] = []
    for option in ("beam_quality_factors = [30]", f"modes = [{mode}]"):
        indenter("tap.toml", tapping=TAP + option)
        answers.append(json.loads(done("tap", "tap.toml", "--json").stdout))
    assert answers[0]["mode_swing"][0] == pytest.approx(answers[1]["mode_swing"][0], rel=1e-3)
    assert 1e-12 < answers[0]["mode_swing"][0][1] < 1e-9
    done("tap", "tap.toml", "--out", "modes.csv")
    with Path("modes.csv").open() as file:
        assert [row[:2] for row in csv.reader(file)][1:] == [["8e-09", "1"], ["8e-09", "2"]]


@pytest.mark.parametrize(
    ("change", "field"),
    [
        (WAVE.replace("depth", "force").replace("10 nm", "1 nN"), "oscillation.amplitude"),
        (WAVE.replace('frequency = "159.15494309189535 kHz"', ""), "oscillation.frequency"),
        (WAVE.replace("kHz", "nm"), "oscillation.frequency"),
        (WAVE + "cycles = 0", "oscillation.cycles"),
        (WAVE + "cycles = 10001", "oscillation.cycles"),
        (WAVE + 'force = "1 nN"', "oscillation"),
    ],
)
def test_mistakes_of_an_oscillation(change: str, field: str) -> None:
    indenter("wave.toml", oscillation=change)
    assert named(lambda: read_oscillation("wave.toml"))[0] == field
    assert refused("oscillate", "wave.toml").startswith("wave.toml: oscillation")


@pytest.mark.parametrize(
    ("change", "field"),
    [
        (TAP.replace("[8] nm", "8 nm"), "tapping.distance"),
        (TAP.replace("[8] nm", "[] nm"), "tapping.distance"),
        (TAP + 'drive = "1 nN"', "tapping"),
        (TAP.replace("= 10", "= 0.2"), "tapping.quality_factor"),
        (TAP.replace("N/m", "N"), "tapping.spring_constant"),
        (TAP + "beam_quality_factors = [0.1]", "tapping.beam_quality_factors[0]"),
        (TAP + "beam_quality_factors = []", "tapping.beam_quality_factors"),
        (TAP + 'modes = [{ spring_constant = 1.0, frequency = "1 Hz" }]', "tapping.modes[0].quality_factor"),
    ],
)
def test_mistakes_of_taps(change: str, field: str) -> None:
    indenter("tap.toml", tapping=change)
    assert named(lambda: read_tapping("tap.toml"))[0] == field
    assert refused("tap", "tap.toml").startswith("tap.toml: tapping")


def test_a_solver_refuses_with_the_file() -> None:
    indenter("wave.toml", oscillation=WAVE, solver="rtol = 0.5")
    assert named(lambda: read_oscillation("wave.toml").solve())[0] == "solver.rtol"


def test_the_examples() -> None:
    wave = read_oscillation(EXAMPLES / "oscillation.toml").solve()
    assert isinstance(wave, rs.Oscillation)
    # E* = 4/3 of E(t) = 200 + 800 exp(-t/0.3 s) Pa of an incompressible material.
    spring, dashpot = 200.0 / 0.75, 800.0 / 0.75
    assert wave.complex_modulus == pytest.approx(
        spring + dashpot * 0.6j * 3.141592653589793 / (1 + 0.6j * 3.141592653589793)
    )
    assert wave.storage_error < -0.05
    curve = read_tapping(EXAMPLES / "tapping.toml").solve()
    assert set(curve.status.tolist()) == {0}
    assert isinstance(curve, rs.Tapping)
