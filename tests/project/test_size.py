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


def test_the_solver_has_at_most_26_500_lines_and_the_identification_4_500():
    own = sum(lines(path) for path in MODULES if "identification" in path.parts)
    assert own <= 4_500
    assert sum(map(lines, MODULES)) - own <= 26_500
