"""Break kernel and contact law at random places, and list what the tests miss: `mutations.py --count 60 --seed 1`.

One operator, comparison or number is changed at a time, in a copy of the tree. The tests marked `plain` that reach the
line then run without compilation, the shortest first. Lines that none of them reaches are not drawn: their share is
stated. Ctrl-C ends the run; the same command goes on from there, while sources and tests are the same. The page keeps
other draws, and the verdicts that were written into the last column of this one.
"""

from __future__ import annotations

import argparse
import ast
import hashlib
import json
import os
import random
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from coverage import CoverageData

ROOT = Path(__file__).resolve().parents[1]
PAGE = Path(__file__).with_suffix(".md")

# Without compilation nothing of these runs: the cache, and the instructions of LLVM.
SKIPPED = {"__init__.py", "cache.py", "compile.py", "lanes.py", "c_header.py"}

SWAPPED = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.FloorDiv: ast.Mult,
    ast.Lt: ast.GtE, ast.LtE: ast.Gt, ast.Gt: ast.LtE, ast.GtE: ast.Lt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip

TESTS = ("tests/kernel", "tests/law", "tests/impact", "tests/indentation", "tests/contact")


@dataclass(frozen=True)
class Mutation:
    """A changed piece of a file: where it begins and ends in the text, and what stands there instead."""

    file: str
    line: int
    last_line: int
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
            results[start, stop] = Mutation(file, node.lineno, node.end_lineno, start, stop, text[start:stop], written)
    return list(results.values())


def copy() -> Path:
    """Copy what the tests need into a folder of these sources and tests, and return it."""
    digest = hashlib.sha256()
    for path in sorted([*(ROOT / "src").rglob("*.py"), *(ROOT / "tests").rglob("*.py")]):
        digest.update(path.read_bytes())
    folder = Path(tempfile.gettempdir()) / f"mutations-{digest.hexdigest()[:12]}"
    for name in ("src", "tests", "examples", "validation", "benchmarks", "studies", "docs"):
        ignored = shutil.ignore_patterns("__pycache__", "_build", "generated")
        shutil.copytree(ROOT / name, folder / name, ignore=ignored, dirs_exist_ok=True)
    shutil.copy(ROOT / "pyproject.toml", folder)
    return folder


def passes(folder: Path, tests: list[str], most: int, *more: str) -> bool:
    """Return whether the tests pass in a copy; those that take more than so many seconds of processor time do not."""
    switches = {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(folder / "src"), "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:xdist", "-p", "no:cacheprovider", "-m", "plain"]

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (most, most))

    options = {"cwd": folder, "env": os.environ | switches, "capture_output": True, "preexec_fn": limit}
    return subprocess.run([*command, *more, *tests], check=False, **options).returncode == 0


def durations(folder: Path) -> dict[str, float]:
    """Return the times of the tests by name; run them once with the lines that each of them reaches."""
    times = folder / "times.xml"
    if not times.exists():
        print("the tests without a change, and the lines that they reach", flush=True)
        traced = ("--cov=restitution", "--cov-context=test", "--cov-report=", f"--junit-xml={folder / 'new.xml'}")
        if not passes(folder, list(TESTS), 3600, *traced):
            sys.exit("the tests fail without any change")
        (folder / "new.xml").rename(times)
    cases = ElementTree.parse(times).iter("testcase")
    return {
        f"{case.get('classname', '').replace('.', '/')}.py::{case.get('name')}": float(case.get("time", 0))
        for case in cases
    }


def reaching(folder: Path, every: list[Mutation], times: dict[str, float]) -> dict[Mutation, list[str]]:
    """Return the tests that reach each change, the shortest first, of those changes that any test reaches."""
    data = CoverageData(str(folder / ".coverage"))
    data.read()
    lines = {file: data.contexts_by_lineno(str(folder / file)) for file in {change.file for change in every}}
    results = {}
    for change in every:
        of_lines = (lines[change.file].get(line, []) for line in range(change.line, change.last_line + 1))
        tests = {context.partition("|")[0] for contexts in of_lines for context in contexts} & times.keys()
        if tests:
            results[change] = sorted(tests, key=lambda test: times[test])
    return results


def run(chosen: dict[Mutation, list[str]], folder: Path, times: dict[str, float]) -> list[Mutation]:
    """Return the changes that no test sees; go on where an earlier run was ended."""
    record = folder / "results.jsonl"
    known = dict(map(json.loads, record.read_text(encoding="utf-8").splitlines())) if record.exists() else {}
    begin, started, survivors = time.monotonic(), len(known.keys() & {repr(change) for change in chosen}), []
    for number, (mutation, tests) in enumerate(chosen.items(), 1):
        path = folder / mutation.file
        text = path.read_text(encoding="utf-8")
        if repr(mutation) not in known:
            try:
                path.write_text(mutation.applied(text), encoding="utf-8")
                missed = passes(folder, tests, 30 + round(3 * sum(times[test] for test in tests)))
            finally:
                path.write_text(text, encoding="utf-8")
            known[repr(mutation)] = missed
            with record.open("a", encoding="utf-8") as file:
                file.write(json.dumps([repr(mutation), missed]) + "\n")
            left = (time.monotonic() - begin) / max(number - started, 1) * (len(chosen) - number) / 60
            print(
                f"{number} of {len(chosen)}, {len(survivors) + missed} not seen, about {left:.0f} min left", flush=True
            )
        if known[repr(mutation)]:
            survivors.append(mutation)
            print(f"{mutation.file}, {mutation.line}: {mutation.before} -> {mutation.after}", flush=True)
    return survivors


def shown(text: str) -> str:
    """Return a piece of code as one cell of a table."""
    return "`` " + " ".join(text.split()).replace("|", "\\|") + " ``"


def verdicts() -> dict[tuple[str, ...], str]:
    """Return the verdicts of the page by place, code and change."""
    rows = re.findall(r"^\| (\S+, \d+) \| (``.*?``) \| (``.*?``) \| (.*) \|$", written(), flags=re.MULTILINE)
    return {tuple(row[:3]): row[3] for row in rows}


def written() -> str:
    """Return the page as it is."""
    return PAGE.read_text(encoding="utf-8") if PAGE.exists() else ""


def with_others(section: str) -> str:
    """Return the page with a draw in place of the one of the same seed."""
    title = section.partition("\n")[0]
    parts = re.split(r"^(?=### )", written(), flags=re.MULTILINE)
    others = [part.rstrip() + "\n" for part in parts if part.strip() and part.partition("\n")[0] != title]
    return "\n".join(sorted([*others, section]))


def section_of(
    chosen: dict[Mutation, list[str]], survivors: list[Mutation], every: int, reached: int, seed: int
) -> str:
    """Return the result as a section of the page."""
    tried, missed = (Counter(mutation.file for mutation in part) for part in (chosen, survivors))
    rows = [f"| {file} | {count} | {count - missed[file]} |" for file, count in sorted(tried.items())]
    known = verdicts()
    cells = [(f"{m.file}, {m.line}", shown(m.before), shown(m.after)) for m in survivors]
    listed = [f"| {' | '.join(cell)} | {known.get(cell, '')} |" for cell in cells]
    return "\n".join(
        [
            f"### Seed {seed}",
            "",
            f"Made by `validation/mutations.py --count {len(chosen)} --seed {seed}`. The tests marked `plain` reach"
            f" {reached}",
            f"of {every} possible changes of kernel and law, {100 * reached / every:.0f} %; the others are left out.",
            f"{len(chosen)} of these were tried, {len(chosen) - len(survivors)} are seen.",
            "",
            "| file | changed | seen |",
            "|---|---|---|",
            *rows,
            f"| all | {len(chosen)} | {len(chosen) - len(survivors)} |",
            "",
            "Not seen:",
            "",
            "| place | code | instead | verdict |",
            "|---|---|---|---|",
            *listed,
            "",
        ]
    )


def main() -> None:
    """Draw changes, try them and write their section of the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    files = [
        path.relative_to(ROOT).as_posix()
        for part in ("kernel", "law")
        for path in sorted((ROOT / "src" / "restitution" / part).glob("*.py"))
        if path.name not in SKIPPED
    ]
    every = [change for file in files for change in mutations(file, (ROOT / file).read_text(encoding="utf-8"))]
    folder = copy()
    try:
        times = durations(folder)
        reached = reaching(folder, every, times)
        drawn = random.Random(options.seed).sample(list(reached), options.count)
        chosen = {change: reached[change] for change in sorted(drawn, key=lambda m: (m.file, m.line, m.start))}
        survivors = run(chosen, folder, times)
    except KeyboardInterrupt:
        sys.exit("ended; the same command goes on from here")
    section = section_of(chosen, survivors, len(every), len(reached), options.seed)
    PAGE.write_text(with_others(section), encoding="utf-8")


if __name__ == "__main__":
    main()
