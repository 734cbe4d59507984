"""Damaged input: every command ends soon, with exit code 0, 2 or 3 and one line with the reason."""

import pytest

from checkout import script


def faults(runs: int, seed: int) -> tuple[list[str], int]:
    fuzz = script("validation/fuzz.py")
    counts, faulty, _ = fuzz.fuzz(runs, seed)
    return [f"{end.fault}\n{text}" for _, text, end in faulty], sum(counts.values())


def test_a_few_damaged_files() -> None:
    faulty, runs = faults(40, seed=7)
    assert faulty == []
    assert runs == 40


# Warnings of the package are not errors on the command line.
@pytest.mark.filterwarnings("default::restitution.errors.RestitutionWarning")
@pytest.mark.slow
def test_many_damaged_files() -> None:
    faulty, _ = faults(1500, seed=11)
    assert faulty == []
