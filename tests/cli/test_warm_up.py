"""The command warm-up: it reaches every entry point of the kernel, and nothing is compiled after it."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import restitution as rs
from cases import case_file, press_file
from commands import done, refused
from restitution.cli import warm_up
from restitution.kernel import cache
from restitution.kernel import compile as compiler

SOURCES = Path(rs.__file__).parent


def python(code: str, *arguments: str, **environment: str) -> str:
    answer = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        env=os.environ | environment, capture_output=True, text=True, timeout=600, check=False,
    )  # fmt: skip
    assert answer.returncode == 0, answer.stderr
    return answer.stdout


CALLED = """
from restitution.kernel import compile as compiler

called = set()

def entry_point(function):
    def call(*arguments):
        called.add(f"{function.__module__}.{function.__name__}")
        return function(*arguments)
    return call

compiler.entry_point = entry_point
from restitution.cli.warm_up import PROBLEMS

for problem in PROBLEMS:
    problem()
print(*called)
"""


@pytest.mark.slow
def test_the_problems_call_every_entry_point() -> None:
    every = {
        f"restitution.{path.relative_to(SOURCES).with_suffix('').as_posix().replace('/', '.')}.{name}"
        for path in SOURCES.rglob("*.py")
        for name in re.findall(r"^@entry_point\ndef (\w+)", path.read_text(encoding="utf-8"), re.MULTILINE)
    }
    assert "restitution.kernel.impact.solve_block" in every
    assert set(python(CALLED, NUMBA_DISABLE_JIT="1").split()) == every


def test_the_command_solves_its_problems_and_names_the_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    solved: list[int] = []
    monkeypatch.setattr(warm_up, "PROBLEMS", {lambda: solved.append(1): 2, lambda: solved.append(2): 3})
    monkeypatch.setattr(warm_up.os, "cpu_count", lambda: 1)
    for module in (cache, compiler):
        monkeypatch.setattr(module, "cache_folder", lambda: str(tmp_path))
    assert done("warm-up").stdout == f"the kernel is compiled; its machine code is in {tmp_path}\n"
    assert solved == [1, 2]


def test_the_process_beside_has_ended_before_the_second_problem(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    started: list[list[str]] = []
    ended: list[bool] = []
    sleeper = "import sys, time; time.sleep(1.0); open(sys.argv[1], 'w')"

    class Beside(subprocess.Popen[bytes]):
        def __init__(self, command: list[str], **options: Any) -> None:
            started.append(command)
            super().__init__([sys.executable, "-c", sleeper, str(tmp_path / "end")], **options)

    monkeypatch.setattr(warm_up.subprocess, "Popen", Beside)
    monkeypatch.setattr(warm_up.os, "cpu_count", lambda: 2)

    def problem() -> None:
        ended.append((tmp_path / "end").exists())

    monkeypatch.setattr(warm_up, "PROBLEMS", {problem: 1, lambda: problem(): 1})
    done("warm-up")
    assert ended == [False, True]
    assert len(started) == 1


@pytest.mark.slow
def test_the_process_beside_solves_its_problems() -> None:
    # A failure of it would cost time alone, as the command then compiles all by itself.
    assert python(warm_up.CODE_BESIDE + "; print(len(warm_up.BESIDE))") == f"{len(warm_up.BESIDE)}\n"
    assert set(warm_up.BESIDE) < set(list(warm_up.PROBLEMS)[1:])


def test_machine_code_that_nothing_keeps_is_not_made(monkeypatch: pytest.MonkeyPatch) -> None:
    from numba.core import config

    with monkeypatch.context() as changed:
        changed.setattr(cache, "cache_folder", lambda: None)
        assert "no folder can keep machine code" in refused("warm-up")
    for name, value in (("DISABLE_JIT", 1), ("OPT", 0)):
        with monkeypatch.context() as changed:
            changed.setattr(config, name, value)
            assert "NUMBA_DISABLE_JIT or NUMBA_OPT = 0 is set" in refused("warm-up")


USED = """
import atexit
from numba.core import event
from restitution.kernel import compile as compiler

class Listener(event.Listener):
    def on_start(self, start):
        print("\\ncompiled", start.data["dispatcher"].py_func.__name__)
    def on_end(self, end):
        pass

event.register("numba:compile", Listener())
kept, cached = [], compiler.cached

def remembered(dispatcher, function):
    kept.append(dispatcher)
    return cached(dispatcher, function)

compiler.cached = remembered

@atexit.register
def show():
    for dispatcher in kept:
        for signature in dispatcher.signatures:
            print("\\nused", dispatcher.py_func.__module__, dispatcher.py_func.__name__, *map(str, signature))

"""
MAIN = "from restitution.cli.main import main; main()"


def used(code: str, *arguments: str, cache_folder: Path, compiles: bool = False) -> set[str]:
    """Machine code that a process calls: functions with types of their arguments."""
    lines = python(USED + code, *arguments, NUMBA_CACHE_DIR=str(cache_folder)).splitlines()
    assert compiles or not any(line.startswith("compiled") for line in lines)
    return {line for line in lines if line.startswith("used")}


@pytest.mark.slow
def test_nothing_is_compiled_after_it(folder: Path) -> None:
    # What the other tests have left saves a minute. The command itself must use all that is compared with it, so that
    # it would have compiled it.
    copy = folder / "cache"
    shutil.copytree(cache.cache_folder() or "", copy)
    kept = used(MAIN, "warm-up", cache_folder=copy, compiles=True)
    case_file("ball.toml")
    case_file("bouncing.toml", impact='drop_height = "50 mm"')
    press_file("gel.toml")
    press_file("force.toml", indentation='force = "1 nN"\nshape = "triangle"\nloading_time = "1 s"')
    for command in ("solve ball.toml --plot ball.png", "bounce bouncing.toml", "indent gel.toml", "indent force.toml"):
        names = used(MAIN, *command.split(), cache_folder=copy)
        assert names, command
        assert names <= kept, command
    solves = "rs.standard_solid_restitution([0.3, 0.4], 0.1, 1.0); rs.standard_solid_restitution(0.3, 0.1, 1.0)"
    names = used(f"import restitution as rs; {solves}", cache_folder=copy)
    assert names
    assert names <= kept
