"""The pages "From data to material": their code prints the output shown."""

import re
import warnings
from pathlib import Path

import pytest

from restitution.case.identification import read_identification
from restitution.errors import RestitutionWarning

ROOT = Path(__file__).parents[2]
PAGES = ROOT / "docs" / "identification"


def blocks(page: str, language: str) -> list[str]:
    text = (PAGES / f"{page}.md").read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)


@pytest.mark.parametrize("page", ["index", "rubber", "afm", "teacher"])
def test_code_prints_the_output_of_the_page(
    page: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT / "examples" / "identification")
    code, texts = blocks(page, "python"), blocks(page, "text")
    assert len(code) == len(texts) > 0
    names: dict[str, object] = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RestitutionWarning)
        for block, text in zip(code, texts, strict=True):
            exec(block, names)
            assert capsys.readouterr().out == text


def test_the_case_file_of_the_page_is_that_of_the_example(tmp_path: Path) -> None:
    (case,) = blocks("index", "toml")
    (tmp_path / "balls.csv").write_bytes((ROOT / "examples" / "identification" / "balls.csv").read_bytes())
    (tmp_path / "case.toml").write_text(case)
    page, example = (
        read_identification(file) for file in (tmp_path / "case.toml", ROOT / "examples/identification/balls.toml")
    )
    assert page.section.options == example.section.options
    assert page.data[0].size == example.data[0].size
