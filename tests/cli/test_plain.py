"""Single solves without the compiler: they agree with compiled ones, are limited in time, and leave no machine code."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cases import TRIANGLE, case_file, press_file
from commands import done
from restitution.cli import plain

COMMAND = "from restitution.cli.main import main; main()"
# Of the solves in these tests.
RTOL = 1e-9


def program(*arguments: str, code: str = COMMAND, **environment: str) -> str:
    """What a process of its own prints; the compiler's switch is that of the command line."""
    variables = {key: value for key, value in os.environ.items() if key != "NUMBA_DISABLE_JIT"}
    answer = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        env=variables | environment, capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert answer.returncode == 0, answer.stderr
    return answer.stdout


def write_cases(rng: np.random.Generator) -> None:
    """Write a random ball and a random gel."""
    modulus, ratio, viscosity = rng.uniform(0.5, 5.0), rng.uniform(2.0, 30.0), rng.uniform(0.5, 20.0)
    material = (
        f'equilibrium_modulus = "{modulus!r} MPa"\nbranch_modulus = "{modulus * ratio!r} MPa"\n'
        f'viscosity = "{viscosity!r} kPa s"\npoisson_ratio = {rng.uniform(0.3, 0.5)!r}\n'
    )
    case_file("ball.toml", material=material, impact=f'velocity = "{rng.uniform(0.1, 3.0)!r} m/s"')
    case_file("bouncing.toml", material=material, impact=f'drop_height = "{rng.uniform(20.0, 60.0)!r} mm"')
    relaxing = f'branch_moduli = "[{rng.uniform(100.0, 900.0)!r}] Pa"\nrelaxation_times = "[0.3] s"'
    gel = f'bulk_modulus = "incompressible"\n[material.shear]\nequilibrium_modulus = "60 Pa"\n{relaxing}'
    press_file("gel.toml", material=gel, indentation=TRIANGLE)
    oscillation = f'depth = "80 nm"\namplitude = "8 nm"\nfrequency = "{rng.uniform(0.1, 3.0)!r} Hz"'
    press_file("shaken.toml", material=gel, indentation=None, oscillation=oscillation)


SOLID = ["--nu", "0.3", "--p2", "0.1", "--p3", "1"]
COMMANDS = {
    "solve": ["ball.toml"], "standard-solid": SOLID, "bounce": ["bouncing.toml"],
    "indent": ["gel.toml"], "oscillate": ["shaken.toml"],
}  # fmt: skip


def numbers(content: Any, name: str = "") -> dict[str, float]:
    """All numbers of a JSON document by their path."""
    if isinstance(content, dict):
        parts = [numbers(value, f"{name}.{key}") for key, value in content.items()]
    elif isinstance(content, list):
        parts = [numbers(value, f"{name}[{n}]") for n, value in enumerate(content)]
    else:
        return {name: float(content)} if isinstance(content, int | float) else {}
    return {path: number for part in parts for path, number in part.items()}


@pytest.mark.parametrize(
    "command",
    [pytest.param(name, marks=() if name in ("solve", "indent") else pytest.mark.slow) for name in plain.ENTRY_POINTS],
)
def test_the_first_command_has_the_numbers_of_compiled_code_and_compiles_nothing(folder: Path, command: str) -> None:
    write_cases(np.random.default_rng())
    answer = program(command, *COMMANDS[command], "--json", NUMBA_CACHE_DIR=str(folder / "cache"))
    assert [path.suffix for path in (folder / "cache").iterdir() if path.suffix == ".nbi"] == []
    ours, compiled = (
        numbers(json.loads(answer)),
        numbers(json.loads(done(command, *COMMANDS[command], "--json").stdout)),
    )
    assert ours.keys() == compiled.keys()
    for name, number in ours.items():
        # e has a tolerance; the others are as accurate within a factor. Residuals are differences that vanish.
        tight = name.startswith(".restitution_coefficient") and command != "bounce"
        least, relative = 1e-9 if name.endswith("residual") else 0.0, 2.0 * RTOL if tight else 100.0 * RTOL
        assert number == pytest.approx(compiled[name], rel=relative, abs=least), name


RANDOM = """
import json, sys
import numpy as np
import restitution as rs

def impacts(seed, count=12):
    rng = np.random.default_rng(seed)
    for _ in range(count):
        n = int(rng.integers(1, 6))
        shear = rs.PronySeries(rng.uniform(0.0, 2.0), rng.uniform(0.1, 9.0, n), 10.0 ** rng.uniform(-3.0, 2.0, n))
        profile = rs.PowerLaw(rng.uniform(1.5, 4.0), 1.0) if rng.random() < 0.5 else rs.Parabola(radius=1.0)
        yield rs.Impact(rs.Material(shear, bulk=rng.uniform(5.0, 50.0)), profile, mass=1.0, velocity=1.0)

print(json.dumps([rs.solve(impact).restitution_coefficient for impact in impacts(int(sys.argv[1]))]))
"""


@pytest.mark.slow
def test_random_impacts_agree_within_rtol() -> None:
    seed = str(np.random.default_rng().integers(1 << 30))
    compiled, ours = (
        np.array(json.loads(program(seed, code=RANDOM, NUMBA_DISABLE_JIT=switch))) for switch in ("0", "1")
    )
    # Each has an error below rtol max(e, 1e-3).
    assert np.all(np.abs(ours - compiled) <= 2.0 * RTOL * np.maximum(compiled, 1e-3)), (seed, ours - compiled)


CALLED = """
import os, sys
os.environ["NUMBA_DISABLE_JIT"] = "1"
from restitution.kernel import compile as compiler

called = set()

def entry_point(function):
    def call(*arguments):
        called.add(f"{function.__module__.removeprefix('restitution.')}.{function.__name__}")
        return function(*arguments)
    return call

compiler.entry_point = entry_point
from restitution.cli.main import app

for line in sys.argv[1:]:
    called.clear()
    try:
        app(line.split())
    except SystemExit:
        print("called", *called)
"""


@pytest.mark.slow
def test_commands_call_the_entry_points_of_their_lists(folder: Path) -> None:
    write_cases(np.random.default_rng())
    commands = [" ".join([command, *COMMANDS[command]]) for command in plain.ENTRY_POINTS]
    lines = [line.split() for line in program(*commands, code=CALLED).splitlines()]
    called = [set(line[1:]) for line in lines if line[:1] == ["called"]]
    for command, names in zip(plain.ENTRY_POINTS, called, strict=True):
        assert set(plain.ENTRY_POINTS[command]) <= names, command


AGAIN = """
import atexit, sys
from restitution.cli import plain
from restitution.cli.main import main

plain.has_machine_code, plain.PATIENCE = lambda *functions: False, 0.05
atexit.register(lambda: print(f"switch {sys.modules['numba'].config.DISABLE_JIT}"))
main()
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs a clock of processor time that interrupts")
def test_a_long_solve_begins_again_with_the_compiler_and_prints_once(folder: Path) -> None:
    write_cases(np.random.default_rng())
    lines = program("solve", "ball.toml", code=AGAIN).splitlines()
    assert lines == [*done("solve", "ball.toml").stdout.splitlines(), "switch 0"]


@pytest.fixture
def own_process(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """A process of the command line that has not loaded numba, as far as `is_plain` can see; its cache is empty."""
    monkeypatch.setattr(plain, "_processes", True)
    monkeypatch.setattr(plain, "cache_folder", lambda: str(folder))
    monkeypatch.setattr(plain, "has_machine_code", lambda *functions: False)
    monkeypatch.delitem(sys.modules, "numba", raising=False)
    monkeypatch.delenv("NUMBA_DISABLE_JIT", raising=False)
    return monkeypatch.setattr


def test_commands_share_a_limited_time_without_the_compiler(own_process: Callable[..., None]) -> None:
    assert plain.is_plain("solve")
    plain.write_spent("solve", plain.PATIENCE - 0.01)
    assert plain.is_plain("solve")
    plain.write_spent("solve", plain.PATIENCE)
    assert not plain.is_plain("solve")
    assert plain.is_plain("indent")
    # Where nothing can be kept, machine code cannot either.
    own_process(plain, "cache_folder", lambda: None)
    assert plain.is_plain("solve")


def test_a_damaged_note_counts_as_none(own_process: Callable[..., None]) -> None:
    note = plain.note_of("solve")
    assert note is not None
    note.write_bytes(b"\xff?")
    assert plain.is_plain("solve")


def test_machine_code_is_used_where_there_is_some(own_process: Callable[..., None]) -> None:
    asked: list[str] = []
    own_process(plain, "has_machine_code", lambda *functions: bool(asked.extend(functions)) or True)
    assert not plain.is_plain("solve")
    assert asked == list(plain.ENTRY_POINTS["solve"])


@pytest.mark.parametrize("value", ["0", "1"])
def test_the_switch_of_a_user_decides(
    own_process: Callable[..., None], monkeypatch: pytest.MonkeyPatch, value: str
) -> None:
    monkeypatch.setenv("NUMBA_DISABLE_JIT", value)
    assert not plain.is_plain("solve")


def test_a_process_that_goes_on_is_left_alone(own_process: Callable[..., None]) -> None:
    own_process(plain, "_processes", False)
    assert not plain.is_plain("solve")


def test_the_list_has_entry_points_of_the_kernel() -> None:
    for function in {function for functions in plain.ENTRY_POINTS.values() for function in functions}:
        module, name = function.rsplit(".", 1)
        assert callable(getattr(import_module(f"restitution.{module}"), name))
