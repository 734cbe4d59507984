"""A record of what the package computes: some 340 random problems of all kinds, by its public names alone.

Write the numbers of one checkout, change the package, and compare:

    python validation/recorded.py --write before.npz
    python validation/recorded.py --compare before.npz [--allow sweep/over/nu case ...]

`--compare` prints the problems whose numbers do not have the same bits, each with the largest difference relative to
the largest magnitude of the output, and exits with 1 unless `--allow` names them: by the whole name or by its first
parts. Bits can be compared only between two checkouts on one machine, with the same libraries and the same value of
NUMBA_CPU_NAME. `--only` takes names in the same way. All problems take half a minute, and more if they must be
compiled.

The same problems are compared within tolerances by `tests/project/test_recorded.py`, on every machine. `--write-data`
writes its numbers, `tests/data/recorded.json`, and `--write-names` the list of public names,
`tests/data/public_names.txt`. Write them anew only where a change of numbers or names is wanted.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

import numpy as np
from rich.progress import track

TESTS = Path(__file__).resolve().parents[1] / "tests"
sys.path.insert(0, str(TESTS))

from recorded_problems import PROBLEMS, Values, differences, same_bits  # noqa: E402
from recorded_problems.names import public_names  # noqa: E402

DATA, NAMES = TESTS / "data" / "recorded.json", TESTS / "data" / "public_names.txt"


def among(name: str, names: list[str]) -> bool:
    """Whether a problem has one of these names, or one of them is its first parts."""
    return any(name == chosen or name.startswith(f"{chosen.rstrip('/')}/") for chosen in names)


def compute(only: list[str]) -> dict[str, Values]:
    """Numbers of all problems, or of those with the names in `only`."""
    chosen = [problem for problem in PROBLEMS.values() if not only or among(problem.name, only)]
    return {problem.name: problem.values() for problem in track(chosen, "problems", disable=not sys.stderr.isatty())}


def write(file: Path, results: dict[str, Values]) -> None:
    """Write all numbers; an archive has one array for each output."""
    arrays = {f"{name}|{output}": values for name, outputs in results.items() for output, values in outputs.items()}
    with file.open("wb") as stream:
        np.savez_compressed(stream, **arrays)


def read(file: Path) -> dict[str, Values]:
    """Read the numbers that `write` wrote."""
    results: dict[str, Values] = {}
    with np.load(file) as archive:
        for key in archive.files:
            name, _, output = key.partition("|")
            results.setdefault(name, {})[output] = archive[key]
    return results


def compare(before: dict[str, Values], after: dict[str, Values], allow: list[str]) -> int:
    """Print the problems that differ; return the number of those that are not allowed to."""
    refused = equal = 0
    for name in sorted(before.keys() | after.keys()):
        if name not in before or name not in after:
            words = "is new" if name not in before else "is absent"
        elif same_bits(after[name], before[name]):
            equal += 1
            continue
        else:
            errors = differences(after[name], before[name])
            worst = max(errors, key=lambda output: errors[output])
            words = f"{errors[worst]:.1e} of {worst}, {sum(error > 0.0 for error in errors.values())} outputs"
        allowed = among(name, allow)
        refused += not allowed
        print(f"{name}: {words}{' (allowed)' if allowed else ''}")
    print(f"{equal} of {len(before)} problems have the same bits; {refused} others are not allowed")
    return refused


def plain(value: float) -> float | int:
    """Number with eleven digits, in few characters."""
    rounded = float(f"{value:.11g}")
    return int(rounded) if rounded.is_integer() and abs(rounded) < 1e6 else rounded


def write_data(results: dict[str, Values]) -> None:
    """Write some numbers of each output for the tests, a line for each problem."""
    lines = (
        f"{json.dumps(name)}: "
        + json.dumps(
            {output: [plain(value) for value in values] for output, values in PROBLEMS[name].short(outputs).items()},
            separators=(",", ":"),
        )
        for name, outputs in results.items()
    )
    DATA.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


def main() -> int:
    """Write or compare."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", type=Path, metavar="FILE", help="write the numbers into an archive of numpy, .npz")
    parser.add_argument("--compare", type=Path, metavar="FILE", help="compare the bits with those of this file")
    parser.add_argument("--allow", nargs="+", default=[], metavar="NAME", help="problems that may differ")
    parser.add_argument("--only", nargs="+", default=[], metavar="NAME", help="problems to compute")
    parser.add_argument("--write-data", action="store_true", help=f"write {DATA.relative_to(TESTS.parent)}")
    parser.add_argument("--write-names", action="store_true", help=f"write {NAMES.relative_to(TESTS.parent)}")
    options = parser.parse_args()
    if not (options.write or options.compare or options.write_data or options.write_names):
        parser.error("nothing to do: give --write, --compare, --write-data or --write-names")
    if options.write_names:
        NAMES.write_text(public_names(), encoding="utf-8")
    if not (options.write or options.compare or options.write_data):
        return 0
    result = compute(options.only)
    if options.write:
        write(options.write, result)
    if options.write_data:
        if options.only:
            parser.error("--write-data writes all problems")
        write_data(result)
    if options.compare:
        before = {
            name: outputs for name, outputs in read(options.compare).items() if not options.only or name in result
        }
        return int(compare(before, result, options.allow) > 0)
    return 0


if __name__ == "__main__":
    sys.exit(main())
