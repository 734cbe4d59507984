"""Tables of the pages beside these scripts."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def row(*cells: Any) -> str:
    """Line of a table; numbers have five digits behind the point."""
    return "| " + " | ".join(cell if isinstance(cell, str) else f"{cell:.5f}" for cell in cells) + " |"


def table(titles: list[str], rows: list[list[Any]]) -> str:
    """Table in Markdown."""
    return "\n".join([row(*titles), "|---" * len(titles) + "|", *(row(*cells) for cells in rows)]) + "\n"


def write(script: str, lines: list[str]) -> None:
    """Print the lines of a page, and write them beside the script."""
    text = "\n".join(lines) + "\n"
    print(text)
    Path(script).with_suffix(".md").write_text(text, encoding="utf-8")
