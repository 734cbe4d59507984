"""The case file of the page on prescribed indentation gives the result of its Python."""

import pytest

from checkout import blocks
from restitution.case.indentation import read_indentation


def test_the_case_file_is_the_first_example(tmp_path):
    file = tmp_path / "gel.toml"
    file.write_text(blocks("docs/indentation.md", "toml")[0], encoding="utf-8")
    # The moduli of the file have four digits.
    assert read_indentation(file).solve().max_force == pytest.approx(1.38541713e-9 * 0.08**1.5, rel=1e-3)
