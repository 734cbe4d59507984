"""Single problems without the compiler: they agree with compiled ones, are limited in time, and compile nothing."""

import json
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import restitution as rs
from cases import TRIANGLE, case_file, press_file
from commands import done
from restitution.kernel import plain
from restitution.kernel.impact import solve_block

# However slow the machine is, its patience does not end.
PATIENT = """
from restitution.kernel import plain
plain.PATIENCE = plain.LONGEST = plain.ALLOWANCE = float("inf")
"""
COMMAND = f"{PATIENT}from restitution.cli.main import main\nmain()"
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
    [pytest.param(name, marks=() if name in ("solve", "indent") else pytest.mark.slow) for name in COMMANDS],
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


@pytest.mark.plain
def test_random_impacts_agree_within_rtol(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng()
    impacts = list[rs.Impact]()
    for _ in range(8):
        n = int(rng.integers(1, 6))
        shear = rs.PronySeries(rng.uniform(0.0, 2.0), rng.uniform(0.1, 9.0, n), 10.0 ** rng.uniform(-3.0, 2.0, n))
        profile = rs.PowerLaw(rng.uniform(1.5, 4.0), 1.0) if rng.random() < 0.5 else rs.Parabola(radius=1.0)
        impacts.append(rs.Impact(rs.Material(shear, bulk=rng.uniform(5.0, 50.0)), profile, mass=1.0, velocity=1.0))
    compiled = np.array([rs.solve(impact, rtol=RTOL).restitution_coefficient for impact in impacts])
    if hasattr(solve_block, "py_func"):
        monkeypatch.setattr("restitution.kernel.impact.solve_block", plain.plain(solve_block))
        monkeypatch.setattr("restitution.kernel.plain._thread.end", np.inf)
    ours = np.array([rs.solve(impact, rtol=RTOL).restitution_coefficient for impact in impacts])
    # Each has an error below rtol max(e, 1e-3).
    assert np.all(np.abs(ours - compiled) <= 2.0 * RTOL * np.maximum(compiled, 1e-3)), (impacts, ours - compiled)


FIRST = f"""
{PATIENT}
import json, os, sys
from concurrent.futures import ThreadPoolExecutor
import numpy as np
import restitution as rs

def answer(_=None):
    result = rs.solve(rs.read_case("ball.toml").impact)
    history = result.history
    curve = rs.indent(rs.Material(rs.PronySeries(60.0, [250.0], [0.3]), bulk=np.inf), rs.Parabola(radius=2.5e-6),
                      depth=rs.triangle(1e-6, 1.0))
    return dict(e=result.restitution_coefficient, force=history.force.values.tolist(),
                dissipated=result.energy.dissipated, curve=curve.force.tolist(), end=curve.contact_end_time,
                stored=curve.stored)

print(json.dumps([answer(), *ThreadPoolExecutor(3).map(answer, range(3))]))
"""


@pytest.mark.slow
def test_the_first_solve_of_python_has_the_numbers_of_compiled_code_and_compiles_nothing(folder: Path) -> None:
    write_cases(np.random.default_rng())
    first, *others = json.loads(program(code=FIRST, NUMBA_CACHE_DIR=str(folder / "cache")))
    assert [path for path in (folder / "cache").iterdir() if path.suffix == ".nbi"] == []
    assert others == [first] * 3
    compiled = json.loads(program(code=FIRST, NUMBA_DISABLE_JIT="0"))[0]
    assert first["e"] == pytest.approx(compiled["e"], rel=2.0 * RTOL)
    for name, numbers in first.items():
        scale = np.max(np.abs(compiled[name]))
        assert np.max(np.abs(np.subtract(numbers, compiled[name]))) <= 1e-7 * scale, name


AGAIN = """
import sys
from restitution.kernel import plain

# Both take ten times the limit and more; shorter ones would end as plain Python, with other last digits.
LONG = "kernel.impact.solve_block", "kernel.stored.peak_pressure"
plain.has_machine_code, plain.LONGEST = lambda function: function not in LONG, float(sys.argv.pop(1))
from restitution.cli.main import main
main()
"""


@pytest.mark.slow
def test_a_long_solve_begins_again_with_the_compiler(folder: Path) -> None:
    write_cases(np.random.default_rng())
    assert program("0.001", "solve", "ball.toml", "--json", code=AGAIN) == done("solve", "ball.toml", "--json").stdout


def fake(function: Any, answer: Any) -> Any:
    """An entry point, without numba: `function` is its plain form, and `answer` what its machine code returns."""

    class Dispatcher(SimpleNamespace):
        def __call__(self, *arguments: Any) -> Any:
            return answer(*arguments)

    function.__module__ = __name__
    return Dispatcher(py_func=function, targetoptions={})


@pytest.fixture
def empty_cache(folder: Path, monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """A process that has no machine code, as far as entry points can see, and has spent no time."""
    monkeypatch.setattr(plain, "cache_folder", lambda: str(folder))
    monkeypatch.setattr(plain, "has_machine_code", lambda function: False)
    monkeypatch.setattr(plain, "_spent", 0.0)
    monkeypatch.delenv("NUMBA_DISABLE_JIT", raising=False)
    return monkeypatch


def chosen(entry_point: Any, *arguments: Any) -> Any:
    """What a call returns of an entry point that has no machine code in this process."""
    return plain.with_plain_calls(entry_point, lambda *_: entry_point)(*arguments)(*arguments)


def halve(numbers: Any) -> str:
    numbers /= 2.0
    if numbers[0] == 0.0:
        raise ZeroDivisionError
    return "plain"


@pytest.mark.usefixtures("empty_cache")
def test_only_single_problems_run_without_the_compiler() -> None:
    entry_point = fake(halve, lambda numbers: "compiled")
    assert chosen(entry_point, np.ones(2)) == "compiled"
    with plain.single_problem():
        assert chosen(entry_point, np.ones(2)) == "plain"
        with plain.compiled_only(), plain.single_problem():
            assert chosen(entry_point, np.ones(2)) == "compiled"
        assert chosen(entry_point, np.ones(2)) == "plain"
    assert chosen(entry_point, np.ones(2)) == "compiled"


@pytest.mark.usefixtures("empty_cache")
def test_an_error_of_arithmetic_begins_again_with_the_arrays_as_they_were() -> None:
    numbers, rest = np.array([0.0, 4.0]), np.array([1.0, 3.0])
    entry_point = fake(lambda pair: halve(pair[1]) + halve(pair[0]), lambda pair: (pair[0].tolist(), pair[1].tolist()))
    with plain.single_problem():
        assert chosen(entry_point, (numbers, rest)) == ([0.0, 4.0], [1.0, 3.0])


def test_a_call_that_takes_too_long_begins_again(empty_cache: pytest.MonkeyPatch) -> None:
    empty_cache.setattr(plain, "LONGEST", -1.0)
    with plain.single_problem():
        assert chosen(fake(halve, lambda numbers: numbers[0]), np.full(2, 8.0)) == 8.0


def test_time_without_the_compiler_is_limited(empty_cache: pytest.MonkeyPatch) -> None:
    assert plain.is_plain("impact.any")
    with plain.single_problem():
        chosen(fake(halve, lambda numbers: ""), np.ones(2))
    assert 0.0 < plain.spent() < plain.ALLOWANCE
    empty_cache.setattr(plain, "_spent", plain.PATIENCE)
    assert not plain.is_plain("impact.any")
    empty_cache.setattr(plain, "_spent", 0.0)
    # Another process has spent all.
    note = plain.note()
    assert note is not None
    note.write_text(str(plain.ALLOWANCE), "ascii")
    assert not plain.is_plain("impact.any")
    # A damaged note counts as none.
    note.write_bytes(b"\xff?")
    assert plain.is_plain("impact.any")
    # Where nothing can be kept, machine code cannot either.
    empty_cache.setattr(plain, "cache_folder", lambda: None)
    assert plain.is_plain("impact.any")


def test_machine_code_is_used_where_there_is_some(empty_cache: pytest.MonkeyPatch) -> None:
    empty_cache.setattr(plain, "has_machine_code", lambda function: function == "kernel.impact.solve_block")
    assert not plain.is_plain("kernel.impact.solve_block")
    assert plain.is_plain("kernel.stored.peak_pressure")


@pytest.mark.parametrize("value", ["0", "1"])
def test_the_switch_of_a_user_decides(empty_cache: pytest.MonkeyPatch, value: str) -> None:
    empty_cache.setenv("NUMBA_DISABLE_JIT", value)
    assert not plain.is_plain("kernel.impact.solve_block")
