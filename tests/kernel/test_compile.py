"""The machine code is kept, made anew after any edit, and done without where it cannot be kept."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[2] / "src" / "restitution"
SOLVE = "import restitution as rs; print(repr(rs.standard_solid_restitution(0.3, 0.1, 1.0)))"


def _run(code: str, root: Path, **environment: str) -> str:
    variables = {key: value for key, value in os.environ.items() if not key.startswith("NUMBA_")}
    answer = subprocess.run(
        [sys.executable, "-c", code],
        env=variables | {"PYTHONPATH": str(root)} | environment,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert answer.returncode == 0, answer.stderr
    return answer.stdout


def _copy(root: Path) -> Path:
    shutil.copytree(PACKAGE, root / "restitution", ignore=shutil.ignore_patterns("__pycache__"))
    return root


def test_stamp_changes_with_every_kernel_source(tmp_path):
    from restitution.kernel.compile import source_hash

    folder = _copy(tmp_path) / "restitution" / "kernel"
    for source in sorted(folder.glob("*.py")):
        before = source_hash.__wrapped__(folder)
        source.write_text(source.read_text() + "\n")
        assert source_hash.__wrapped__(folder) != before, source.name


def test_import_loads_nothing_heavy(tmp_path):
    code = "import sys, restitution; print({'scipy', 'numba', 'xarray', 'pint', 'matplotlib'} & set(sys.modules))"
    assert _run(code, PACKAGE.parent) == "set()\n"


@pytest.mark.slow
def test_edit_of_a_callee_in_another_file_takes_effect(tmp_path):
    root = _copy(tmp_path)
    first = _run(SOLVE, root)
    code = (
        SOLVE
        + "; from restitution.kernel.impact import solve_block as s; print(sum(s.stats.cache_hits.values()))"
    )
    assert _run(code, root).split() == [first.strip(), "1"]
    path = root / "restitution" / "kernel" / "path.py"
    # Pi of the parabola, for one number and for eight.
    changed = path.read_text().replace("(2.0 / 3.0)", "1.0").replace("2.0 / (p + 2.0)", "3.0 / (p + 2.0)")
    assert changed != path.read_text()
    path.write_text(changed)
    assert _run(SOLVE, root) != first


@pytest.mark.slow
def test_nowhere_to_keep_the_code(tmp_path):
    root = _copy(tmp_path)
    blocked = tmp_path / "file"
    blocked.write_text("")
    # A path below a plain file can be written by nobody, root included.
    answer = _run(SOLVE, root, NUMBA_CACHE_DIR=str(blocked / "cache"))
    assert float(answer) == pytest.approx(0.434356162547, rel=1e-9)


ROOM = """
import sys
from numba.core import event
from restitution.kernel.compile import kernel, stage

# Words of the frames that the compiler has above it, the largest of them.
class Listener(event.Listener):
    def on_start(self, _):
        frame, largest = sys._getframe(), 0
        while frame is not None:
            largest = max(largest, frame.f_code.co_stacksize)
            frame = frame.f_back
        print(largest)
    def on_end(self, _):
        pass

@stage
def half(x):
    return 0.5 * x

@kernel
def quarter(x):
    return half(half(x))

with event.install_listener("numba:compile", Listener()):
    assert quarter(2.0) == 0.5
"""


def test_the_compiler_has_room_for_its_frames(tmp_path):
    # The piece of memory for a frame of so many words is twice as large; CPython's usual pieces have 2048 words.
    assert _run(ROOM, PACKAGE.parent, NUMBA_CACHE_DIR=str(tmp_path)).split() == ["32768", "32768"]
