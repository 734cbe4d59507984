"""Damaged input: every command ends soon, with exit code 0, 2 or 3 and one line with the reason."""

import importlib.util
from pathlib import Path

import pytest


def faults(runs: int, seed: int) -> tuple[list[str], int]:
    file = Path(__file__).parents[2] / "validation" / "fuzz.py"
    spec = importlib.util.spec_from_file_location("fuzz", file)
    assert spec is not None
    assert spec.loader is not None
    fuzz = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(fuzz)
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
