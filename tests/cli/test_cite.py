"""The command cite: BibTeX of the methods and materials of a case."""

import json
import re
from pathlib import Path

import pytest

from cases import case_file
from commands import done, refused
from restitution.citation.cite import cite

CONE = 'type = "cone"\nhalf_angle = "70 deg"\n'
EPOXY = 'library = "epoxy"'
TIP = {"body": 'mass = "5 g"', "profile": CONE, "material": EPOXY}


@pytest.fixture(autouse=True)
def _tip(folder: Path) -> None:
    case_file("tip.toml", **TIP)


def keys(text: str) -> list[str]:
    return re.findall(r"^@\w+\{(\w+),", text, flags=re.MULTILINE)


def test_the_sources_of_a_case_are_printed() -> None:
    text = done("cite", "tip.toml").stdout
    assert {"simon2000", "love1939", "ting1966", "hairer1996"} < set(keys(text))
    assert len(keys(text)) == len(set(keys(text)))
    assert "% data of epoxy\n@article{simon2000," in text


def test_several_cases_give_one_bibliography() -> None:
    case_file("ball.toml", **TIP | {"profile": 'type = "sphere"\nradius = 0.01'})
    text = done("cite", "tip.toml", "ball.toml").stdout
    assert text.count("@article{ting1966,") == 1
    assert "love1939" in text
    assert "segedin1957" in text


def test_without_a_case_the_program_itself_is_cited() -> None:
    assert done("cite").stdout == cite() + "\n"


def test_json_and_file() -> None:
    content = json.loads(done("cite", "tip.toml", "--json", "--out", "refs.bib").stdout)
    used = {item["key"]: item["used_for"] for item in content}
    assert used["love1939"] == ["contact of a cone"]
    written = Path("refs.bib").read_text(encoding="utf-8")
    assert all(item["bibtex"] in written for item in content)
    assert done("cite", "tip.toml", "--out", "more.bib").stdout == ""
    assert refused("cite", "tip.toml", "--out", "refs.txt") == "--out refs.txt: must end in .bib"


def test_indentations_and_sweeps() -> None:
    shape = 'depth = "1 um"\nshape = "triangle"\nloading_time = "1 s"\n'
    case_file(
        "press.toml", body=None, material='library = "polyisobutylene"', impact=None, profile=CONE, indentation=shape
    )
    text = done("cite", "press.toml").stdout
    assert {"catsiff1955", "love1939"} < set(keys(text))
    assert "hairer1996" not in text
    axes = 'impact.velocity = { linear = ["0.1 m/s", "1 m/s"], n = 3 }\n'
    case_file("sweep.toml", **TIP, impact=None, axes=axes)
    assert {"simon2000", "love1939", "hairer1996"} < set(keys(done("cite", "sweep.toml").stdout))
