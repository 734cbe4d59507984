"""The page about other bodies: its Python code and its case files."""

import re
from pathlib import Path

import numpy as np
import pytest

from restitution.case.impact import read_case

PAGE = (Path(__file__).parents[2] / "docs" / "geometries.md").read_text(encoding="utf-8")
REST = """
[body]
mass = "5 g"
radius = "10 mm"
[material]
equilibrium_modulus = "1 MPa"
branch_modulus = "2 MPa"
viscosity = "2 kPa s"
poisson_ratio = 0.5
[impact]
velocity = "0.1 m/s"
"""


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGE, flags=re.DOTALL | re.MULTILINE)


def test_its_python_prints_what_it_shows(capsys: pytest.CaptureFixture[str]) -> None:
    names: dict[str, object] = {}
    for block in blocks("python"):
        exec(compile(block, "geometries.md", "exec"), names)
    assert capsys.readouterr().out == "".join(blocks("text"))


def test_its_case_files_are_solved(tmp_path: Path) -> None:
    d = np.linspace(0.0, 0.4, 41)
    rows = "\n".join(f"{x!r},{2.0 * x**1.5!r}" for x in d.tolist())
    (tmp_path / "twin.csv").write_text(f"depth [mm],force [N]\n{rows}\n", encoding="utf-8")
    assert blocks("toml")
    for block in blocks("toml"):
        file = tmp_path / "case.toml"
        file.write_text(block + REST, encoding="utf-8")
        assert 0.0 < read_case(file).solve().restitution_coefficient < 1.0
