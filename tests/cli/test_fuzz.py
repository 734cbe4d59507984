"""Damaged input: every command ends soon, with exit code 0, 2 or 3 and one line with the reason."""

import pytest

from checkout import script


# Warnings of the package are not errors on the command line.
@pytest.mark.filterwarnings("default::restitution.errors.RestitutionWarning")
@pytest.mark.parametrize("runs", [20, pytest.param(1500, marks=pytest.mark.slow)])
def test_damaged_files(runs: int) -> None:
    counts, faulty, _ = script("validation/fuzz.py").fuzz(runs, 7)
    assert [f"{end.fault}\n{text}" for _, text, end in faulty] == []
    assert sum(counts.values()) == runs
