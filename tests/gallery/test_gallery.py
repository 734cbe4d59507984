"""Every example of the gallery runs, and its number agrees with its source."""

import ast
import os
import re
from pathlib import Path
from typing import Any

import matplotlib
import pytest
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from checkout import ROOT

# Many of these bodies exceed the limits of the theory.
pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")

EXAMPLES = sorted((ROOT / "examples" / "gallery").glob("plot_*.py"))
# Each point of their curves has another material, or many balls collide, or bodies touch often, or adhere.
SLOW = (
    "plot_12_power_law", "plot_13_sound", "plot_16_force_map", "plot_17_granular_gas", "plot_22_same_spot",
    "plot_24_tapping", "plot_31_rate_and_dwell", "plot_32_viscous_jkr",
)  # fmt: skip


def run_as_pages_do(path: Path) -> list[Figure]:
    """Run the blocks of an example; the pictures of each are taken behind it, and none may lack a curve or be missed."""
    shown: list[Figure] = []
    text = path.read_text(encoding="utf-8")
    namespace: dict[str, Any] = {"__name__": "__main__"}
    for block in re.finditer(r"(?:\A|^# %%$).*?(?=^# %%$|\Z)", text, flags=re.MULTILINE | re.DOTALL):
        # Lines of an error are those of the file.
        exec(compile("\n" * text.count("\n", 0, block.start()) + block[0], str(path), "exec"), namespace)
        figures = [plt.figure(number) for number in plt.get_fignums()]
        assert all(ax.has_data() for figure in figures for ax in figure.axes)
        plt.close("all")
        shown += figures
    assert all(value in shown for value in namespace.values() if isinstance(value, Figure))
    return shown


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
        shown = run_as_pages_do(path)
    finally:
        plt.close("all")
    assert shown
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
