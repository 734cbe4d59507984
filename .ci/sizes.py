"""Print the lines of code of each package, beside those of another revision.

Blank lines, comments and docstrings do not count. The other revision is the argument, or the last release, or
`REFERENCE` while there is no release.
"""

import ast
import io
import subprocess
import sys
import tokenize
from collections import Counter
from pathlib import Path

PACKAGE = "src/restitution"
REFERENCE = "bd859e8"
SKIPPED = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}


def code_lines(text: str) -> int:
    """Return the number of lines that hold code."""
    rows = {
        row
        for token in tokenize.generate_tokens(io.StringIO(text).readline)
        if token.type not in SKIPPED
        for row in range(token.start[0], token.end[0] + 1)
    }
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, documented) and ast.get_docstring(node, clean=False) is not None:
            first = node.body[0]
            rows -= set(range(first.lineno, (first.end_lineno or first.lineno) + 1))
    return len(rows)


def sizes(sources: dict[str, str]) -> Counter[str]:
    """Return the lines of code of each package; modules outside every package count as "."."""
    total: Counter[str] = Counter()
    for path, text in sources.items():
        parts = Path(path).relative_to(PACKAGE).parts
        total[parts[0] if len(parts) > 1 else "."] += code_lines(text)
    return total


def git(*arguments: str) -> str:
    """Return the output of a git command, or an empty text if it fails."""
    return subprocess.run(["git", *arguments], capture_output=True, text=True, check=False).stdout


def at(revision: str) -> dict[str, str]:
    """Return the sources of a revision."""
    names = git("ls-tree", "-r", "--name-only", revision, PACKAGE).split()
    return {name: git("show", f"{revision}:{name}") for name in names if name.endswith(".py")}


if __name__ == "__main__":
    revision = sys.argv[1] if len(sys.argv) > 1 else git("describe", "--tags", "--abbrev=0").strip() or REFERENCE
    now = sizes({str(path): path.read_text(encoding="utf-8") for path in Path(PACKAGE).rglob("*.py")})
    then = sizes(at(revision))
    rows = [(name, now[name], then[name]) for name in sorted(now | then)]
    print(f"{'package':<20}{'lines of code':>14}{revision:>14}")
    for name, lines, before in [*rows, ("all", now.total(), then.total())]:
        print(f"{name:<20}{lines or '-':>14}{before or '-':>14}")
