"""The paper: its references exist, and its numbers are those that the script of its figures computes."""

import json
import re

import pytest

from checkout import ROOT, script

FOLDER = ROOT / "paper"
TEXT = (FOLDER / "paper.md").read_text()
NUMBERS = json.loads((FOLDER / "figures" / "numbers.json").read_text())
ENTRY = re.compile(r"^@\w+\{(\w+),\n(.*?)^\}", re.MULTILINE | re.DOTALL)


def entries(path: str) -> dict[str, dict[str, str]]:
    """Fields of the entries of a bibliography, by key."""
    result = ENTRY.findall((ROOT / path).read_text().replace('{\\"o}', "ö").replace("{\\ss}", "ß"))
    return {key: dict(re.findall(r"^\s*(\w+) = \{(.*?)\},?$", body, re.MULTILINE)) for key, body in result}


def test_every_citation_has_an_entry_and_every_entry_a_citation():
    assert set(re.findall(r"@(\w+)", TEXT.partition("# Summary")[2])) == set(entries("paper/paper.bib"))


def test_entries_are_those_of_the_package():
    ours = entries("src/restitution/citation/references.bib")
    shared = {key: fields for key, fields in entries("paper/paper.bib").items() if key in ours}
    assert len(shared) >= 5
    for key, fields in shared.items():
        assert {name: ours[key][name] for name in ("author", "title", "year")} == {
            name: fields[name] for name in ("author", "title", "year")
        }


def test_pictures_exist():
    assert [name for name in re.findall(r"\]\((figures/\S+)\)", TEXT) if not (FOLDER / name).is_file()] == []


def test_numbers_of_the_text():
    flat = " ".join(TEXT.split())
    velocity = NUMBERS["velocity"]
    laws = velocity["viscous law at 0.1 mm/s"], velocity["e at 0.1 mm/s"]
    assert "At 0.1 mm/s the viscous law has {:.2f}, the rubber {:.2f}.".format(*laws) in flat
    # Row D1 of the reference values of reloading, by another program: 3.505019696093, work 1.790625017907.
    assert f"The contact ends at {NUMBERS['reloading']['end of contact']:.6f}." in flat
    assert NUMBERS["reloading"] == pytest.approx({"end of contact": 3.505019696093, "work": 1.790625017907}, rel=1e-8)
    # The first-order law of a viscous sphere, 1 - e ~ v^(1/5), from 1 m/s to 0.1 mm/s.
    assert laws[0] == pytest.approx(1.0 - (1.0 - velocity["e at 1 m/s"]) * 1e-4**0.2, rel=1e-12)


@pytest.mark.slow
def test_the_figures_are_drawn_again(tmp_path, monkeypatch):
    figures = script("paper/figures.py")
    monkeypatch.setattr(figures, "FOLDER", tmp_path)
    figures.main()
    written = json.loads((tmp_path / "numbers.json").read_text())
    for part, numbers in NUMBERS.items():
        # Twice the tolerance of e, 1e-8.
        assert written[part] == pytest.approx(numbers, rel=2e-8)
    assert {path.name for path in tmp_path.iterdir()} == {path.name for path in (FOLDER / "figures").iterdir()}
