"""Help, examples, velocities in any order, and files that cannot be written."""

import re
import shlex
from functools import cache
from pathlib import Path

import pytest

import restitution as rs
from cases import case_file
from checkout import ROOT
from commands import refused, run
from restitution.calibration.calibrate import TARGETS
from restitution.cli.main import app
from restitution.rebound_resilience import STANDARDS

NAMES = sorted(command.name for command in app.registered_commands)


@cache
def help_of(command: str) -> list[str]:
    """Words of the help of a command."""
    return run(command, "--help").stdout.replace("│", " ").split()


@pytest.mark.parametrize("name", NAMES)
def test_each_command_is_in_a_group_shows_its_docstring_and_has_an_example(name: str) -> None:
    command = next(each for each in app.registered_commands if each.name == name)
    panels = "Solve", "From data to a material", "For other codes", "Explore, reproduce, cite"
    assert command.rich_help_panel in panels
    example = re.search(r"Example: restitution (.*)", command.callback.__doc__.replace("\b", ""))[1]
    first, *words = shlex.split(example)
    assert first == name
    # Files of an example are those of the project, or written by another example.
    files = [word for word in words if word.startswith("examples/")]
    assert all((ROOT / each).is_file() for each in files)
    shown = help_of(name)
    # Words in brackets would be taken for styles and left out.
    assert {*command.callback.__doc__.replace("\b", "").split()} <= {*shown}
    # A flag takes no value, and the names of arguments say what they are.
    assert not [word for word in shown if word.startswith(("<bool>", "<path>", "<list"))]
    # Who gives a length must know how to write it.
    quantities = {"LENGTH", "TIME", "VELOCITY", "TEMPERATURE", "LOW", "NAME=LOW:HIGH"} & {*shown}
    assert ("A plain number is in SI." in " ".join(shown)) == bool(quantities), quantities
    options = set(re.findall(r"--[a-z0-9-]+", " ".join(shown)))
    assert {word for word in words if word.startswith("--")} <= options


def test_help_lists_the_standards_and_the_targets() -> None:
    assert all(name in " ".join(help_of("resilience")) for name in STANDARDS)
    assert all(name in " ".join(help_of("calibrate")) for name in TARGETS)


@pytest.fixture
def _ball(folder: Path) -> None:
    case_file("ball.toml", impact="velocity = 0.1")


@pytest.mark.usefixtures("_ball")
@pytest.mark.parametrize(
    "command",
    [
        ("calibrate", "ball.toml", "--target", "liggghts", "--json", "--velocity"),
        ("surrogate", "ball.toml", "--rtol", "1e-3", "--json", "--velocity"),
        ("export", "ball.toml", "--to", "table.csv", "--velocity"),
        ("export", "ball.toml", "--to", "law.json", "--terms", "1", "--velocity"),
    ],
)
def test_velocities_stand_in_any_order_and_the_case_needs_none(command: tuple[str, ...]) -> None:
    case_file("ball.toml", impact=None)
    refused("solve", "ball.toml")
    forward, backward = run(*command, "0.1", "0.3"), run(*command, "0.3", "0.1")
    assert (forward.exit_code, backward.exit_code) == (0, 0)
    assert forward.stdout == backward.stdout


@pytest.mark.usefixtures("_ball")
def test_a_picture_that_cannot_be_written_is_refused_before_the_solve(monkeypatch: pytest.MonkeyPatch) -> None:
    if not Path("/proc/self").is_dir():
        pytest.skip("no folder that refuses all files")
    monkeypatch.setattr("restitution.case.impact.Case.solve", lambda case: pytest.fail("solved"))
    message = refused("solve", "ball.toml", "--plot", "/proc/x.png")
    assert message == "--plot /proc/x.png: nothing can be written to the folder /proc"


@pytest.mark.usefixtures("_ball")
def test_the_unit_after_a_range_is_that_of_both_ends() -> None:
    """1:10 mm/s is no range from 1 m/s."""
    seen = {}

    def kept(dataset, *arguments, **options):
        seen.update({name: dataset[name].values.tolist() for name in ("velocity", "radius")})
        raise rs.InputError("seen", rule="is enough")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("restitution.plot_sweep", kept)
        run("map", "ball.toml", "--x", "velocity=1:5 mm/s", "--y", "radius=1:2mm", "--points", "2")
    assert seen["velocity"] == pytest.approx([1e-3, 5e-3])
    assert seen["radius"] == pytest.approx([1e-3, 2e-3])


@pytest.mark.usefixtures("_ball")
def test_an_unknown_standard_has_a_near_one() -> None:
    assert refused("resilience", "ball.toml", "--standard", "din53512").endswith("did you mean DIN 53512?")
