"""Damaged input: every command ends soon, with exit code 0, 2 or 3 and one line with the reason."""

import pytest

from checkout import script


def faults(runs: int, seed: int) -> tuple[list[str], int]:
    fuzz = script("validation/fuzz.py")
    counts, found, _ = fuzz.fuzz(runs, seed)
    return [f"{end.fault}\n{text}" for _, text, end in found], sum(counts.values())


def test_a_few_damaged_files() -> None:
    found, runs = faults(40, seed=7)
    assert found == []
    assert runs == 40


# Warnings of the package are not errors on the command line.
@pytest.mark.filterwarnings("default::restitution.errors.RestitutionWarning")
@pytest.mark.slow
def test_many_damaged_files() -> None:
    found, _ = faults(1500, seed=11)
    assert found == []
