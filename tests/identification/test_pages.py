"""The case file of the pages "From data to material"."""

from pathlib import Path

from checkout import EXAMPLES, blocks
from restitution.case.identification import read_identification


def test_the_case_file_of_the_page_is_that_of_the_example(tmp_path: Path) -> None:
    (case,) = blocks("docs/identification/index.md", "toml")
    (tmp_path / "balls.csv").write_bytes((EXAMPLES / "identification" / "balls.csv").read_bytes())
    (tmp_path / "case.toml").write_text(case)
    page, example = (
        read_identification(file) for file in (tmp_path / "case.toml", EXAMPLES / "identification" / "balls.toml")
    )
    assert page.section.options == example.section.options
    assert page.data[0].size == example.data[0].size
