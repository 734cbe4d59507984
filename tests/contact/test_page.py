"""The case files of the page about other bodies."""

from pathlib import Path

import numpy as np

from cases import case_file
from checkout import blocks
from restitution.case.impact import read_case

PAGE = "docs/geometries.md"
SOLID = 'equilibrium_modulus = "1 MPa"\nbranch_modulus = "2 MPa"\nviscosity = "2 kPa s"\npoisson_ratio = 0.5'
REST = case_file(material=SOLID, impact='velocity = "0.1 m/s"')


def test_its_case_files_are_solved(tmp_path: Path) -> None:
    d = np.linspace(0.0, 0.4, 41)
    rows = "\n".join(f"{x!r},{2.0 * x**1.5!r}" for x in d.tolist())
    (tmp_path / "twin.csv").write_text(f"depth [mm],force [N]\n{rows}\n", encoding="utf-8")
    assert blocks(PAGE, "toml")
    for block in blocks(PAGE, "toml"):
        file = tmp_path / "case.toml"
        file.write_text(block + REST, encoding="utf-8")
        assert 0.0 < read_case(file).solve().restitution_coefficient < 1.0
