"""The measured bench: its verdicts follow from its numbers, and its page is what its script computes."""

import re
import sys
from dataclasses import replace

import pytest

from checkout import ROOT, script

sys.path.insert(0, str(ROOT / "validation"))
bench = script("validation/bench.py")
sys.path.pop(0)

TEXT = (ROOT / "validation" / "bench.md").read_text()
LINES = re.findall(r"^\| (.+) \| (.+) \| ([\d.e-]+) \| ([\d.e-]+) \| .+ \| \*\*(\w+)\*\* \|$", TEXT, re.MULTILINE)


def test_verdicts_follow_from_the_numbers():
    assert len(LINES) >= 12
    for data, quantity, residual, error, verdict in LINES:
        # Printed with two digits: the verdict at twice the error bar itself may be either.
        ratio = float(residual) / float(error)
        if abs(ratio / 2.0 - 1.0) > 0.1:
            assert verdict == ("good" if ratio < 2.0 else "bad"), (data, quantity)


def test_each_row_has_its_source_and_licence():
    origins = dict(
        re.findall(r"^\| ([^|]+) \| ([^|]+ \| [^|]+ \| [^|]+) \|$", TEXT.partition("licence")[2], re.MULTILINE)
    )
    for data, *_ in LINES:
        assert all(part.strip() for part in origins[data].split("|")), data


def test_a_prediction_outside_of_its_error_bars_is_bad():
    row = bench.Row("", "", "", "", "", 0.19, 0.1, "")
    assert (row.verdict, replace(row, residual=0.21).verdict) == ("good", "bad")


def test_numbers_of_other_pages_are_read():
    # 15 records; (real_data.md) the largest difference is 2e-5 of 9 s, printed to a millisecond.
    assert bench.cells().residual < 1e-3
    # tapping.md: -16 to +9 %.
    assert 0.05 < bench.taps().residual < 0.16


@pytest.mark.slow
def test_the_page_is_what_the_script_computes():
    rows = bench.rows()
    assert [(row.data, row.quantity) for row in rows] == [line[:2] for line in LINES]
    for row, (_, _, residual, error, verdict) in zip(rows, LINES, strict=True):
        # Two digits are printed; a fit ends within a thousandth of its standard errors.
        assert (row.residual, row.error) == pytest.approx((float(residual), float(error)), rel=0.06)
        assert row.verdict == verdict
