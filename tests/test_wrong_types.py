"""Wrong and unusual types in public functions: a sample of `validation/wrong_types.py`."""

import importlib.util
import sys
from pathlib import Path

import pytest


@pytest.fixture(scope="module")
def wrong_types():
    file = Path(__file__).parents[1] / "validation" / "wrong_types.py"
    spec = importlib.util.spec_from_file_location("wrong_types", file)
    module = importlib.util.module_from_spec(spec)
    sys.modules["wrong_types"] = module
    spec.loader.exec_module(module)
    return module


def test_the_good_calls_work(wrong_types, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert {
        call.name: fault for call in wrong_types.calls() if (fault := wrong_types.run(call, call.arguments)[0])
    } == {}


def test_a_sample_of_wrong_types_is_refused_in_one_line(wrong_types, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    number, faults, _ = wrong_types.bad_calls(400, seed=5)
    assert number == 400
    assert dict(faults) == {}


def test_numbers_in_other_containers_give_the_same_result(wrong_types):
    number, wrong = wrong_types.good_calls(seed=3)
    assert number > 60
    assert wrong == []


@pytest.mark.slow
def test_all_wrong_types_are_refused_in_one_line(wrong_types, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert dict(wrong_types.bad_calls(None, seed=1)[1]) == {}
