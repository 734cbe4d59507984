"""The page on surrogates: its code runs, and its table equals that of the benchmark."""

from pathlib import Path

import numpy as np
import pytest

from checkout import ROOT, run


def test_code_of_the_page_runs(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    names = run("docs/surrogates.md")
    first, last = (1.0 + 0.2) / 2, names["restitution"](0.8) * 0.8 / 2
    # Momentum is conserved, and the relative velocity is multiplied by -e.
    assert names["velocities"] == pytest.approx([first - last, first + last])
    assert np.shape(names["picture"]) == (300, 300)
    assert capsys.readouterr().out


def test_table_of_the_page_is_within_the_stated_error() -> None:
    lines = (ROOT / "benchmarks" / "surrogate.md").read_text().splitlines()
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines if line.startswith("| ")]
    heads, rows = rows[0], rows[1:]
    assert len(rows) == 5
    for row in rows:
        value = dict(zip(heads, row, strict=True))
        assert float(value["measured"]) <= 2.0 * float(value["error, stated"]) <= 2e-6
        assert float(value["file, kB"]) < 2000
        assert float(value["ratio"]) > 20
