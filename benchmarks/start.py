"""Time to the first result: import, compilation, loading of compiled code."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

IMPORT = "import time, numpy; start = time.perf_counter(); import {name}; print(time.perf_counter() - start)"
ARRAY_CALL = "import restitution as rs; rs.standard_solid_restitution(0.3, 0.1, 1.0)"
SOLVE = (
    "import restitution as rs; solid = rs.standard_solid(1.0, 10.0, 1.0, poisson_ratio=0.3);"
    "rs.solve(rs.Impact(solid, rs.Parabola(1.0), mass=1.0, velocity=1.0))"
)

# Without the switch the first single problems run as plain Python.
_AT_ONCE = ", compiled at once"
COMMAND = [sys.executable, "-c", "from restitution.cli.main import main; main()"]
EXAMPLES = Path(__file__).resolve().parents[1] / "examples"

Note = Callable[[str], None]


def process_times(command: list[str], environment: dict[str, str]) -> tuple[float, float]:
    """Wall-clock time and processor time [s] of a process."""
    start, before = time.perf_counter(), os.times()
    subprocess.run(command, check=True, capture_output=True, env=environment)
    wall, after = time.perf_counter() - start, os.times()
    return wall, (after.children_user + after.children_system) - (before.children_user + before.children_system)


def imports(repeats: int) -> float:
    """Median time [s] of the import of the package beyond that of NumPy."""
    printed = [
        subprocess.run([sys.executable, "-c", IMPORT.format(name="restitution")], check=True, capture_output=True)
        for _ in range(repeats)
    ]
    return statistics.median(float(done.stdout) for done in printed)


def start(repeats: int, note: Note) -> dict[str, Any]:
    """Times [s] of whole processes with an empty and with a full cache."""
    beyond_numpy = imports(2 * repeats + 1)
    note(f"import beyond NumPy: {beyond_numpy:.3f} s")
    subjects = {
        f"`rs.standard_solid_restitution`{_AT_ONCE}": [sys.executable, "-c", ARRAY_CALL],
        f"`rs.solve`{_AT_ONCE}": [sys.executable, "-c", SOLVE],
        "`restitution standard-solid`": [*COMMAND, "standard-solid", "--nu", "0.3", "--p2", "0.1", "--p3", "1"],
        "`restitution solve`": [*COMMAND, "solve", str(EXAMPLES / "rubber_ball.toml")],
        "`restitution indent`": [*COMMAND, "indent", str(EXAMPLES / "afm_indent.toml")],
    }
    rows = []
    for name, command in subjects.items():
        with tempfile.TemporaryDirectory() as empty:
            environment = os.environ | {"NUMBA_CACHE_DIR": empty}
            if name.endswith(_AT_ONCE):
                environment["NUMBA_DISABLE_JIT"] = "0"
            else:
                environment.pop("NUMBA_DISABLE_JIT", None)
            first, processor = process_times(command, environment)
            later = min(process_times(command, environment)[0] for _ in range(repeats))
        rows.append({"subject": name, "first": first, "first_processor": processor, "later": later})
        note(f"{name}: first {first:.1f} s, of it {processor:.1f} s of processor, later {later:.2f} s")
    bare = min(process_times([sys.executable, "-c", "import numpy"], dict(os.environ))[0] for _ in range(repeats))
    return {"import": beyond_numpy, "numpy": bare, "processes": rows}
