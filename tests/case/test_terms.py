import re
from pathlib import Path

import numpy as np
import pytest

from restitution.case.terms import read_terms


def write(folder: Path, text: str) -> str:
    (folder / "terms.csv").write_text(text, encoding="utf-8")
    return "terms.csv"


@pytest.mark.parametrize(
    ("text", "moduli", "relative"),
    [
        ("relaxation_time_s,relative_modulus\n1e-3,0.5\n0.1,0.25\n", [0.5, 0.25], True),
        ("# a comment\n\nrelaxation_time_s,branch_modulus_Pa\n1e-3,5e6\n\n0.1,2e6\n", [5e6, 2e6], False),
        ("relaxation_time [ms], branch_modulus [MPa]\n1,5\n100,2\n", [5e6, 2e6], False),
        ("branch_modulus,relaxation_time\n5e6,1e-3\n2e6,0.1\n", [5e6, 2e6], False),
        ("\ufeffrelative_modulus_%,relaxation_time\r\n50,1e-3\r\n25,0.1\r\n", [0.5, 0.25], True),
    ],
)
def test_columns_in_any_order_and_unit(
    tmp_path: Path, text: str, moduli: list[float], relative: bool
) -> None:
    terms = read_terms(tmp_path, write(tmp_path, text))
    np.testing.assert_allclose(terms.relaxation_times, [1e-3, 0.1], rtol=4e-16)
    np.testing.assert_allclose(terms.moduli, moduli, rtol=4e-16)
    assert terms.relative is relative


HEADER = "relaxation_time_s,relative_modulus\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "holds no terms"),
        (
            "1e-3,0.5\n",
            "line 1: unknown column '1e-3'; known are relaxation_time, branch_modulus, relative_modulus",
        ),
        (
            "relaxation_time_s\n1\n",
            "line 1: must name two columns, relaxation_time and branch_modulus or relative_modulus",
        ),
        (
            "relaxation_time_Hz,relative_modulus\n",
            "line 1: column 'relaxation_time_Hz': is a frequency, not a time; write e.g. \"1 ms\", "
            "or a plain number in s",
        ),
        (HEADER + "1,0.5\n2,0.5,3\n", "line 3: 3 values, 2 wanted"),
        (HEADER + "1,0.5\n\n2,half\n", "line 4: relative_modulus = half: must be a number"),
        (HEADER + "0,0.5\n", "line 2: relaxation_time = 0: must be finite and > 0"),
        (HEADER + "1,-0.5\n", "line 2: relative_modulus = -0.5: must be finite and >= 0"),
        (HEADER + "1,nan\n", "line 2: relative_modulus = nan: must be finite and >= 0"),
    ],
)
def test_malformed_files_are_refused_with_the_line(tmp_path: Path, text: str, message: str) -> None:
    name = write(tmp_path, text)
    with pytest.raises(ValueError, match=rf"^{re.escape(message)}\Z"):
        read_terms(tmp_path, name)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"^no such file: .*none\.csv$"):
        read_terms(tmp_path, "none.csv")
    with pytest.raises(ValueError, match=r"^cannot be read: Is a directory$"):
        read_terms(tmp_path, ".")
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ValueError, match=r"^cannot be read: not a text file in UTF-8$"):
        read_terms(tmp_path, "binary.csv")
