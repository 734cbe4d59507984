"""The command cite: BibTeX of the methods and materials of a case."""

import json
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from restitution.citation.cite import cite
from restitution.cli.main import app

CASE = """
[body]
mass = "5 g"
[profile]
type = "cone"
half_angle = "70 deg"
[material]
library = "epoxy"
[impact]
velocity = "1 m/s"
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("tip.toml").write_text(CASE, encoding="utf-8")


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, ["cite", *arguments], catch_exceptions=False)


def test_the_sources_of_a_case_are_printed() -> None:
    answer = run("tip.toml")
    assert answer.exit_code == 0
    keys = re.findall(r"^@\w+\{(\w+),", answer.stdout, flags=re.MULTILINE)
    assert {"simon2000", "love1939", "ting1966", "hairer1996"} < set(keys)
    assert len(keys) == len(set(keys))
    assert "% data of epoxy\n@article{simon2000," in answer.stdout


def test_several_cases_give_one_bibliography() -> None:
    Path("ball.toml").write_text(CASE.replace('"cone"\nhalf_angle = "70 deg"', '"sphere"\nradius = 0.01'))
    text = run("tip.toml", "ball.toml").stdout
    assert text.count("@article{ting1966,") == 1
    assert "love1939" in text
    assert "segedin1957" in text


def test_without_a_case_the_program_itself_is_cited() -> None:
    assert run().stdout == cite() + "\n"


def test_json_and_file() -> None:
    content = json.loads(run("tip.toml", "--json", "--out", "refs.bib").stdout)
    used = {item["key"]: item["used_for"] for item in content}
    assert used["love1939"] == ["contact of a cone"]
    written = Path("refs.bib").read_text(encoding="utf-8")
    assert all(item["bibtex"] in written for item in content)
    assert run("tip.toml", "--out", "more.bib").stdout == ""
    answer = run("tip.toml", "--out", "refs.txt")
    assert (answer.exit_code, answer.stderr) == (2, "error: --out refs.txt: must end in .bib\n")


def test_indentations_and_sweeps() -> None:
    material = '[material]\nlibrary = "polyisobutylene"\n'
    profile = '[profile]\ntype = "cone"\nhalf_angle = "70 deg"\n'
    shape = '[indentation]\ndepth = "1 um"\nshape = "triangle"\nloading_time = "1 s"\n'
    Path("press.toml").write_text(material + profile + shape)
    text = run("press.toml").stdout
    assert "@article{catsiff1955," in text
    assert "@article{love1939," in text
    assert "hairer1996" not in text
    axes = '[axes]\nimpact.velocity = { linear = ["0.1 m/s", "1 m/s"], n = 3 }\n'
    Path("sweep.toml").write_text(CASE.replace('[impact]\nvelocity = "1 m/s"\n', "") + axes)
    answer = run("sweep.toml")
    assert answer.exit_code == 0, answer.stderr
    assert {"simon2000", "love1939", "hairer1996"} < set(re.findall(r"^@\w+\{(\w+),", answer.stdout, flags=re.M))
