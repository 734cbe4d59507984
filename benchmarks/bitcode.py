"""Processor times of first calls: what they call compiled, and made from bitcode, as a wheel for one Python has it.

`python benchmarks/bitcode.py` takes some ten minutes and writes `tables/bitcode.md`. Each time is that of a whole
process with an empty cache; both ways alternate.
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from pathlib import Path

from start import SOLVE, process_times

import restitution

TABLE = Path(__file__).parent / "tables" / "bitcode.md"
BALL = (
    "import restitution as rs; rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45);"
    "rs.solve(rs.Impact(rubber, rs.Parabola(0.01), mass=0.005, velocity=1.0, {}))"
)
CALLS = {
    "an impact": SOLVE,
    "an impact with friction": BALL.format("friction=0.3, tangential_velocity=1.0"),
    "an impact with adhesion": BALL.format("adhesion=rs.Adhesion(work=0.05, range=1e-6)"),
    "an indentation with two cycles": (
        "import restitution as rs; gel = rs.Material(rs.PronySeries(60.0, [250.0], [0.3]), bulk=float('inf'));"
        "rs.indent(gel, rs.Parabola(2.5e-6), depth=rs.cycles(1e-6, 1.0, 2))"
    ),
    "all of `restitution warm-up`": (
        "from restitution.cli import warm_up; warm_up.solve(list(warm_up.PROBLEMS))"
    ),
}  # fmt: skip
ROUNDS = 3


def spent(call: str, source: Path, written: Path | None = None) -> float:
    """Processor time [s] of a process that has no machine code."""
    with tempfile.TemporaryDirectory() as empty:
        own = {"PYTHONPATH": str(source), "NUMBA_CACHE_DIR": empty, "NUMBA_DISABLE_JIT": "0"}
        if written:
            own["RESTITUTION_BITCODE"] = str(written)
        return process_times([sys.executable, "-c", call], os.environ | own)[1]


def main() -> None:
    """Write the table."""
    lines = ["| first call | compiled, s | from bitcode, s |", "|---|---|---|"]
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder)
        package, bitcode = source / "restitution", source / "restitution" / "kernel" / "bitcode"
        hidden = source / "bitcode"
        ignored = shutil.ignore_patterns("__pycache__", "bitcode")
        shutil.copytree(Path(restitution.__file__).parent, package, ignore=ignored)
        for name, call in CALLS.items():
            compiled, made = [], []
            for _ in range(1 if "warm-up" in name else ROUNDS):
                compiled.append(spent(call, source, hidden))
                hidden.rename(bitcode)
                made.append(spent(call, source))
                bitcode.rename(hidden)
            lines.append(f"| {name} | {min(compiled):.1f} | {min(made):.1f} |")
            print(lines[-1], flush=True)
    TABLE.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
