"""Numbers of some 340 random problems are those of the record, and the public names are those of the list.

If a change is wanted, `python validation/recorded.py --write-data --write-names` writes both anew. Bits are compared
by `validation/recorded.py --compare`.
"""

import ast
import json
import math
from pathlib import Path

import numpy as np
import pytest

from recorded_problems import PROBLEMS, beyond, differences, same_bits
from recorded_problems.names import public_names

TESTS = Path(__file__).resolve().parents[1]
DATA, NAMES = TESTS / "data" / "recorded.json", TESTS / "data" / "public_names.txt"
KINDS = sorted({problem.kind for problem in PROBLEMS.values()})


@pytest.fixture(scope="module")
def recorded():
    text = json.loads(DATA.read_text(encoding="utf-8"))
    return {
        name: {output: np.array(values, dtype=float) for output, values in row.items()} for name, row in text.items()
    }


def failures(chosen, recorded):
    """Outputs of problems that are not within their tolerances of the record."""
    beyonds = {
        problem.name: beyond(problem, problem.short(problem.values()), recorded[problem.name]) for problem in chosen
    }
    return {name: outputs for name, outputs in beyonds.items() if outputs}


def of_kind(kind, *, slow=False):
    return [problem for problem in PROBLEMS.values() if problem.kind == kind and problem.slow == slow]


def test_the_record_has_all_problems(recorded):
    assert list(recorded) == list(PROBLEMS)


@pytest.mark.parametrize("kind", KINDS)
def test_numbers_are_those_of_the_record(kind, recorded):
    assert failures(of_kind(kind), recorded) == {}


@pytest.mark.slow
@pytest.mark.parametrize("name", [problem.name for problem in PROBLEMS.values() if problem.slow])
def test_slow_numbers_are_those_of_the_record(name, recorded):
    assert failures([PROBLEMS[name]], recorded) == {}


NAME = "material/impact_on/3 branches"


@pytest.mark.parametrize(
    ("output", "share", "seen"),
    [
        ("single.restitution_coefficient", 3e-9, True),
        ("single.restitution_coefficient", 3e-10, False),
        ("several.max_force", 1e-7, True),
        ("several.max_force", 1e-9, False),
        ("several.status", math.inf, True),
        ("single.contact_time", math.nan, True),
    ],
)
def test_a_changed_number_is_seen(output, share, seen, recorded):
    changed = {name: values.copy() for name, values in recorded[NAME].items()}
    largest = np.argmax(np.abs(changed[output]))
    changed[output][largest] += share * max(abs(changed[output][largest]), 1.0 if math.isinf(share) else 0.0)
    faults = failures([PROBLEMS[NAME]], {NAME: changed})
    assert list(faults.get(NAME, {})) == ([output] if seen else [])


def test_absent_and_new_outputs_are_seen(recorded):
    changed = dict(recorded[NAME])
    changed["another"] = changed.pop("single.status")
    assert failures([PROBLEMS[NAME]], {NAME: changed}) == {NAME: {"another": math.inf, "single.status": math.inf}}


def test_one_changed_bit_is_seen():
    problem = PROBLEMS["fit/conversion/tension"]
    values, other = problem.values(), problem.values()
    assert same_bits(values, other)
    assert set(differences(values, other).values()) == {0.0}
    name = "creep_compliance"
    other[name][0] = np.nextafter(other[name][0], math.inf)
    assert not same_bits(values, other)
    assert [output for output, error in differences(values, other).items() if error] == [name]
    other[name] = other[name][:-1]
    assert math.isinf(differences(values, other)[name])


def test_signs_of_zero_are_bits_but_no_differences():
    zero, negative = {"a": np.array([0.0])}, {"a": np.array([-0.0])}
    assert not same_bits(zero, negative)
    assert differences(zero, negative) == {"a": 0.0}


def test_problems_use_public_names_alone():
    """They must work in any later checkout, so no internal module is imported."""
    for path in (TESTS / "recorded_problems").glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                assert not (node.module or "").startswith("restitution")
            if isinstance(node, ast.Import):
                assert all(alias.name == "restitution" for alias in node.names if alias.name.startswith("restitution"))


def test_public_names_are_those_of_the_list():
    assert public_names().splitlines() == NAMES.read_text(encoding="utf-8").splitlines()


@pytest.mark.parametrize(
    "line",
    [
        "solve(impact, method='exact', *, rtol=1e-09, surface=None, errors=None, workers=None, progress=None, n_elements=None,"
        " time_step=None)",
        "    max_pressure",
        "    storage_modulus(self, angular_frequency)",
        "    SEPARATED = 0",
    ],
)
def test_the_list_has_functions_attributes_methods_and_members(line):
    assert line in NAMES.read_text(encoding="utf-8").splitlines()


def test_a_new_default_and_a_new_attribute_are_seen(monkeypatch):
    import restitution as rs

    def solve(impact, method="exact", *, rtol=1e-8):
        """Another signature."""

    monkeypatch.setattr(rs.ImpactResult, "novelty", property(lambda self: 0), raising=False)
    monkeypatch.setattr(rs, "ramp", solve)
    lines = set(public_names().splitlines()) - set(NAMES.read_text(encoding="utf-8").splitlines())
    assert lines == {"    novelty", "ramp(impact, method='exact', *, rtol=1e-08)"}
