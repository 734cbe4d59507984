"""Files of this checkout: tables, scripts, and the code of the pages."""

import csv
import importlib.util
import re
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT / "tests" / "data"
EXAMPLES = ROOT / "examples"


def rows(path: Path) -> list[dict[str, float]]:
    """Rows of a table of numbers."""
    with path.open() as file:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]


def script(path: str) -> ModuleType:
    """A script as a module."""
    spec = importlib.util.spec_from_file_location(f"script_{Path(path).stem}", ROOT / path)
    assert spec is not None
    assert spec.loader is not None
    module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def blocks(page: str, language: str) -> list[str]:
    """Blocks of a language on a page."""
    text = (ROOT / page).read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)


def run(page: str) -> dict[str, Any]:
    """Run the Python blocks of a page, one after the other; return their names."""
    names: dict[str, Any] = {}
    code = blocks(page, "python")
    assert code
    for block in code:
        exec(compile(block, Path(page).name, "exec"), names)
    return names


def tree(folder: Path) -> dict[str, bytes]:
    """Files of a folder by their paths."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
