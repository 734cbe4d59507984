"""Every example of the gallery runs, and its number agrees with its source."""

import ast
import os
import re
import runpy
from pathlib import Path

import matplotlib
import pytest
from matplotlib import pyplot as plt

from checkout import ROOT

# Many of these bodies exceed the limits of the theory.
pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")

EXAMPLES = sorted((ROOT / "examples" / "gallery").glob("plot_*.py"))
# Each point of their curves has another material, or many balls collide, or bodies touch often, or adhere.
SLOW = (
    "plot_12_power_law", "plot_13_sound", "plot_16_force_map", "plot_17_granular_gas", "plot_22_same_spot",
    "plot_24_tapping", "plot_31_rate_and_dwell", "plot_32_viscous_jkr",
)  # fmt: skip


def test_there_are_at_least_eight_examples() -> None:
    assert len(EXAMPLES) >= 8


@pytest.mark.parametrize(
    "path",
    [pytest.param(path, id=path.stem, marks=pytest.mark.slow if path.stem in SLOW else ()) for path in EXAMPLES],
)
def test_example_runs(path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setitem(matplotlib.rcParams, "backend", "agg")
    monkeypatch.chdir(ROOT)
    before = os.listdir()
    try:
        runpy.run_path(str(path))
        assert plt.get_fignums()
    finally:
        plt.close("all")
    assert capsys.readouterr().out
    assert os.listdir() == before


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example_compares_a_number(path: Path) -> None:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    assert any(isinstance(node, ast.Assert) for node in ast.walk(tree))
    title, line = (ast.get_docstring(tree) or "").splitlines()[:2]
    assert line == "=" * len(title)


def test_numbers_from_scipy_are_those_of_their_script() -> None:
    """The examples quote every number of the table and no others."""
    table = (ROOT / "validation" / "gallery_numbers.md").read_text(encoding="utf-8")
    digits = set(re.findall(r"\| (0\.\d{10}) \|$", table, flags=re.MULTILINE))
    assert len(digits) >= 5
    quoted = set()
    for path in EXAMPLES:
        text = path.read_text(encoding="utf-8")
        if "validation/gallery_numbers.py" in text:
            quoted |= set(re.findall(r"\b0\.\d{10}\b", text))
    assert quoted == digits
