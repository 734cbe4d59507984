"""What `restitution benchmark` prints of measurements that are made up, and that the real ones work."""

import json
import re

import pytest
from typer.testing import CliRunner, Result

from restitution.benchmark import summary
from restitution.benchmark.timing import Speed
from restitution.cli.main import app


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, ["benchmark", *arguments], catch_exceptions=False)


@pytest.fixture
def sizes(monkeypatch: pytest.MonkeyPatch) -> list[summary.Size]:
    """Sizes that were asked for; what is measured is made up."""
    asked: list[summary.Size] = []

    def measure(size: summary.Size, progress: object) -> summary.Summary:
        asked.append(size)
        speeds = {
            ("paper's plane", 1e-8): Speed(500, 12.3e-6, 5, 11.2e-6, 33.4e-6, 1.5e-9, 0.16),
            ("Prony, 20 terms", 1e-8): Speed(50, 81.2e-6, 5, 80.1e-6, 99.9e-6, 2e-10, 0.02),
        }
        return summary.Summary(speeds, 4, 4.1e-6, 0.0615, 1e-9, 12.3e-6)

    monkeypatch.setattr(summary, "measure", measure)
    return asked


def test_table(sizes: list[summary.Size]) -> None:
    answer = run()
    assert answer.exit_code == 0
    rows = [line.split() for line in answer.stdout.splitlines()]
    assert ["paper's", "plane", "1e-08", "12.3", "11.2", "33.4", "1.5e-09", "0.16"] in rows
    assert ["Prony,", "20", "terms", "1e-08", "81.2", "80.1", "99.9", "2.0e-10", "0.02"] in rows
    assert "on 4 cores: 4.1 us an impact, 3.00 times as many" in answer.stdout
    assert "62 ms an impact for an error of 1.0e-09, 5000 times as long" in answer.stdout
    assert re.search(r"restitution \d+\.\d+.*numba \d+\.", answer.stdout)
    assert sizes == [summary.FULL]


def test_json_is_in_seconds(sizes: list[summary.Size]) -> None:
    content = json.loads(run("--json", "--quick").stdout)
    assert sizes == [summary.QUICK]
    plane, prony = content["speeds"]
    assert plane["problem"] == "paper's plane"
    assert plane["rtol"] == 1e-8
    assert (plane["mean"], plane["worst"]) == (12.3e-6, 33.4e-6)
    assert prony["share"] == 0.02
    assert content["mean_on_all_cores"] == 4.1e-6
    assert content["mean_by_scipy"] / content["mean_of_the_same"] == pytest.approx(5000.0)
    assert content["machine"]["cores"] >= 1
    assert content["version"] == content["machine"]["versions"]["restitution"]


def test_one_core_says_nothing_of_several(sizes: list[summary.Size], monkeypatch: pytest.MonkeyPatch) -> None:
    several = summary.measure(summary.QUICK, None)
    monkeypatch.setattr(summary, "measure", lambda size, progress: several._replace(cores=1))
    answer = run()
    assert answer.exit_code == 0
    assert "cores:" not in answer.stdout
    assert "SciPy" in answer.stdout


@pytest.mark.slow
def test_a_quick_measurement() -> None:
    content = json.loads(run("--quick", "--json").stdout)
    for speed in content["speeds"]:
        assert speed["share"] < 1.0
        assert 0.0 < speed["median"] <= speed["worst"]
    assert content["error_by_scipy"] < 1e-6
