"""Lines of the documents have fewer than 120 characters."""

import re

import pytest

from checkout import ROOT

# Folders with generated pages.
MADE = ("_build", "_static", "generated", "gallery")
PAGES = sorted(
    path
    for path in (*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "examples").glob("*.md"))
    if not set(MADE) & set(path.relative_to(ROOT).parts)
)
LIMIT = 120


def long_lines(text: str) -> list[str]:
    """Lines of prose that are too long. Tables, code and lines with a link may be longer."""
    prose = re.sub(r"^(`{3,}|~{3,})(?!\{figure\}).*?^\1\s*$", "", text, flags=re.DOTALL | re.MULTILINE)
    return [
        line
        for line in prose.splitlines()
        if len(line) >= LIMIT and not line.lstrip().startswith("|") and "](" not in line
    ]


@pytest.mark.parametrize("path", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_lines_of_documents_are_short(path):
    assert long_lines(path.read_text(encoding="utf-8")) == []


def test_long_prose_is_found_but_tables_and_code_are_not():
    line = "word " * 30
    assert long_lines(f"# Title\n\n{line}\n") == [line]
    assert long_lines(f"| {line} |\n\n```python\n{line}\n```\n") == []
