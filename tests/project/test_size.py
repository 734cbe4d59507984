"""The package stays small enough to be read."""

from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[2] / "src" / "restitution"
MODULES = sorted(PACKAGE.rglob("*.py"))


def lines(path: Path) -> int:
    return len(path.read_text(encoding="utf-8").splitlines())


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_no_module_is_longer_than_400_lines(path):
    assert lines(path) <= 400


def test_identification_has_at_most_6_700_lines_and_the_rest_28_000():
    own = sum(lines(path) for path in MODULES if "identification" in (*path.parts, path.stem))
    assert own <= 6_700
    assert sum(map(lines, MODULES)) - own <= 28_000
