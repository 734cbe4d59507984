"""Lines of code (without blank lines, comments and docstrings) of each package, beside those of another revision."""

import ast
import io
import subprocess
import sys
import tokenize
from collections import Counter
from pathlib import Path

PACKAGE = "src/restitution"
SKIPPED = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}


def code_lines(text: str) -> int:
    """Lines that hold code."""
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
    """Lines of code of each package; modules that stand in none are one package, "."."""
    total: Counter[str] = Counter()
    for path, text in sources.items():
        parts = Path(path).relative_to(PACKAGE).parts
        total[parts[0] if len(parts) > 1 else "."] += code_lines(text)
    return total


def git(*arguments: str) -> str:
    """Output of a git command, empty where it fails."""
    return subprocess.run(["git", *arguments], capture_output=True, text=True, check=False).stdout


def at(revision: str) -> dict[str, str]:
    """Sources of a revision."""
    names = git("ls-tree", "-r", "--name-only", revision, PACKAGE).split()
    return {name: git("show", f"{revision}:{name}") for name in names if name.endswith(".py")}


if __name__ == "__main__":
    revision = sys.argv[1] if len(sys.argv) > 1 else git("describe", "--tags", "--abbrev=0").strip()
    now = sizes({str(path): path.read_text(encoding="utf-8") for path in Path(PACKAGE).rglob("*.py")})
    then = sizes(at(revision)) if revision else Counter[str]()
    print(f"{'package':<20}{'lines of code':>14}{revision[:12] or 'no release':>14}")
    for name in sorted(now | then):
        print(f"{name:<20}{now[name]:>14}{then[name] or '-':>14}")
    print(f"{'all':<20}{now.total():>14}{then.total() or '-':>14}")
