"""The package stays small enough to be read."""

from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[2] / "src" / "restitution"
MODULES = sorted(path.relative_to(PACKAGE) for path in PACKAGE.rglob("*.py"))


def lines(path: Path) -> int:
    return len((PACKAGE / path).read_text(encoding="utf-8").splitlines())


@pytest.mark.parametrize("path", MODULES, ids=str)
def test_no_module_is_longer_than_400_lines(path):
    assert lines(path) <= 400


# Features later than the solver, each with the most lines that it may have. A feature is a folder or a module.
LATER = {
    "geometry": 232,
    "cards": 250,
    "force_law": 500,
    "ellipsoid": 253,
    "pyramid": 120,
    "layer": 1_725,
    "rows": 90,
    "identification": 6_710,
    "law": 1_500,
    "calibration": 2_000,
    "rebound_resilience": 700,
    "impedance": 150,
    "explorer": 2_050,
}


def feature(path: Path) -> str | None:
    """Feature to which a module belongs: the first that its path names."""
    return next((name for name in LATER if name in (*path.parts, path.stem)), None)


@pytest.mark.parametrize("name", LATER)
def test_a_later_feature_has_no_more_lines_than_stated(name):
    assert sum(lines(path) for path in MODULES if feature(path) == name) <= LATER[name]


def test_the_rest_has_at_most_28_580_lines():
    # 28 000 before targets that move, bodies of any kind and many tables in one call, which the kernel, the report,
    # cases and tables take.
    assert sum(lines(path) for path in MODULES if feature(path) is None) <= 28_580
