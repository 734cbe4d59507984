"""Break the kernel and the contact law at random places, and count what the tests see: `mutations.py --seed 1`.

One operator, comparison or number is changed at a time, in a copy of the tree. The tests marked `plain` then run
without compilation: those of kernel and law first, those of impacts, indentations and contacts if these pass. A change
that no test sees is listed. Some of these are no faults at all: they change a tolerance, a size of a workspace, or the
order of equal cases.
"""

from __future__ import annotations

import argparse
import ast
import math
import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = Path(__file__).with_suffix(".md")

# Without compilation nothing of these runs: the cache, and the instructions of LLVM.
SKIPPED = {"__init__.py", "cache.py", "compile.py", "lanes.py", "c_header.py"}

SWAPPED = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.FloorDiv: ast.Mult,
    ast.Lt: ast.GtE, ast.LtE: ast.Gt, ast.Gt: ast.LtE, ast.GtE: ast.Lt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip

STAGES = (("tests/kernel", "tests/law"), ("tests/impact", "tests/indentation", "tests/contact"))


@dataclass(frozen=True)
class Mutation:
    """A changed piece of a file: where it begins and ends in the text, and what stands there instead."""

    file: str
    line: int
    start: int
    stop: int
    before: str
    after: str

    def applied(self, text: str) -> str:
        """Return the text with the change."""
        return text[: self.start] + self.after + text[self.stop :]


def changed(node: ast.AST) -> ast.AST | None:
    """Return what stands in place of a node, or None where nothing is changed."""
    match node:
        case ast.BinOp(left, operator, right) if type(operator) in SWAPPED:
            return ast.BinOp(left, SWAPPED[type(operator)](), right)
        case ast.BoolOp(operator, values):
            return ast.BoolOp(SWAPPED[type(operator)](), values)
        case ast.Compare(left, [operator], right) if type(operator) in SWAPPED:
            return ast.Compare(left, [SWAPPED[type(operator)]()], right)
        case ast.UnaryOp(ast.Not() | ast.USub(), operand):
            return operand
        case ast.Constant(bool(value)):
            return ast.Constant(not value)
        case ast.Constant(int(value)):
            return ast.Constant(value + 1)
        case ast.Constant(float(value)):
            return ast.Constant(1.5 * value if value else 1.0)
    return None


def code(tree: ast.Module) -> Iterator[ast.AST]:
    """Yield the nodes inside of functions, without decorators and annotations."""
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef):
            for statement in function.body:
                if isinstance(statement, ast.AnnAssign):
                    statement.annotation = ast.Name("object")
                yield from ast.walk(statement)


def mutations(file: str, text: str) -> list[Mutation]:
    """Return every change of a file."""
    lines = [0]
    for line in text.splitlines(keepends=True):
        lines.append(lines[-1] + len(line))
    results = {}
    for node in code(ast.parse(text)):
        after = changed(node)
        if after is not None:
            # Columns are those of bytes; the sources of kernel and law are ASCII where code stands.
            start, stop = lines[node.lineno - 1] + node.col_offset, lines[node.end_lineno - 1] + node.end_col_offset
            written = f"({ast.unparse(ast.fix_missing_locations(after))})"
            results[start, stop] = Mutation(file, node.lineno, start, stop, text[start:stop], written)
    return list(results.values())


def copy(folder: Path) -> None:
    """Copy what the tests need."""
    for name in ("src", "tests", "examples", "validation", "benchmarks", "studies", "docs"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__", "_build"))
    shutil.copy(ROOT / "pyproject.toml", folder)


def passes(folder: Path, tests: tuple[str, ...], most: int = 3600) -> bool:
    """Return whether the tests pass in a copy; those that take more than so many seconds of processor time do not."""
    switches = {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(folder / "src"), "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:xdist", "-p", "no:cacheprovider", "-m", "plain"]

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (most, most))

    options = {"cwd": folder, "env": os.environ | switches, "capture_output": True, "preexec_fn": limit}
    return subprocess.run([*command, *tests], check=False, **options).returncode == 0


def run(chosen: list[Mutation], folder: Path) -> list[Mutation]:
    """Return the changes that no test sees."""
    limits = []
    for tests in STAGES:
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        if not passes(folder, tests):
            sys.exit(f"the tests {tests} fail without any change")
        limits.append(10 + 3 * math.ceil(resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before))
    survivors = []
    for number, mutation in enumerate(chosen, 1):
        path = folder / mutation.file
        text = path.read_text(encoding="utf-8")
        path.write_text(mutation.applied(text), encoding="utf-8")
        if all(passes(folder, tests, most) for tests, most in zip(STAGES, limits, strict=True)):
            survivors.append(mutation)
            print(f"{mutation.file}, {mutation.line}: {mutation.before} -> {mutation.after}")
        path.write_text(text, encoding="utf-8")
        print(f"{number} of {len(chosen)}, {len(survivors)} not seen", flush=True)
    return survivors


def shown(text: str) -> str:
    """Return a piece of code as one cell of a table."""
    return "`` " + " ".join(text.split()).replace("|", "\\|") + " ``"


def page(chosen: list[Mutation], survivors: list[Mutation], every: int, seed: int) -> str:
    """Return the result as a page."""
    tried = Counter(mutation.file for mutation in chosen)
    missed = Counter(mutation.file for mutation in survivors)
    rows = [f"| {file} | {count} | {count - missed[file]} |" for file, count in sorted(tried.items())]
    listed = [f"| {m.file}, {m.line} | {shown(m.before)} | {shown(m.after)} |" for m in survivors]
    return "\n".join(
        [
            f"Made by `validation/mutations.py --count {len(chosen)} --seed {seed}`: {len(chosen)} of {every} possible"
            " changes;",
            f"{len(chosen) - len(survivors)} are seen by the tests marked `plain`.",
            "",
            "| file | changed | seen |",
            "|---|---|---|",
            *rows,
            f"| all | {len(chosen)} | {len(chosen) - len(survivors)} |",
            "",
            "Not seen:",
            "",
            "| place | code | instead |",
            "|---|---|---|",
            *listed,
            "",
        ]
    )


def main() -> None:
    """Draw changes, try them and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    files = [
        path.relative_to(ROOT).as_posix()
        for part in ("kernel", "law")
        for path in sorted((ROOT / "src" / "restitution" / part).glob("*.py"))
        if path.name not in SKIPPED
    ]
    every = [change for file in files for change in mutations(file, (ROOT / file).read_text(encoding="utf-8"))]
    chosen = sorted(random.Random(options.seed).sample(every, options.count), key=lambda m: (m.file, m.line, m.start))
    with tempfile.TemporaryDirectory() as folder:
        copy(Path(folder))
        survivors = run(chosen, Path(folder))
    PAGE.write_text(page(chosen, survivors, len(every), options.seed), encoding="utf-8")


if __name__ == "__main__":
    main()
