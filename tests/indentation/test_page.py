"""The page on prescribed indentation: its code prints the output shown, and its case file gives the same result."""

import re
from pathlib import Path

import pytest

from restitution.case.indentation import read_indentation

PAGE = Path(__file__).parents[2] / "docs" / "indentation.md"


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)


def test_code_prints_the_output_of_the_page(capsys):
    code, texts = blocks("python"), blocks("text")
    assert len(code) == len(texts) == 5
    names = {}
    for block, text in zip(code, texts, strict=True):
        exec(block, names)
        assert capsys.readouterr().out == text


def test_the_case_file_is_the_first_example(tmp_path):
    file = tmp_path / "gel.toml"
    file.write_text(blocks("toml")[0], encoding="utf-8")
    # The moduli of the file have four digits.
    assert read_indentation(file).solve().max_force == pytest.approx(1.38541713e-9 * 0.08**1.5, rel=1e-3)
