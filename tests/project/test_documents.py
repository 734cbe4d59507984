"""Code, case files, links, versions and names in the documents."""

import math
import re
from dataclasses import replace
from pathlib import Path

import pytest

import restitution
from cases import case_file
from checkout import EXAMPLES, ROOT, blocks, run
from restitution.case.identification import read_identification

DOCUMENTS = sorted(
    [*ROOT.glob("*.md"), *(path for path in (ROOT / "docs").rglob("*.md") if "_build" not in path.parts)]
)
# Pages that are no part of the documentation, but have links.
FOLDERS = ("benchmarks", "examples", "paper", "tests/data", "validation")
LINKED = [*DOCUMENTS, *sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.md"))]
# A file named in the text; what a command makes is left out.
PLACE = re.compile(
    r"`(?!docs/_build|paper/build|benchmarks/history/VERSION)"
    r"((?:\.ci|\.github|benchmarks|docs|examples|paper|recipe|src|studies|tests|validation)/[\w./-]+)`"
)
# Markdown, its references, and HTML; the build of the documentation makes the static explorer.
LINK = re.compile(
    r"\]\(([^)\s]+)\)|^\[[^\]]+\]: (\S+)$|(?:src|href)=\"(?!static_explorer)([^\"]+)\"", flags=re.MULTILINE
)
PYTHON = ("README.md", "docs/quickstart.md")


def anchors(path: Path) -> set[str]:
    headings = re.findall(r"^#+ (.*)$", path.read_text(), flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("name", PYTHON)
def test_python_blocks_run(name, capsys):
    names = run(name)
    assert 0.0 < names["result"].restitution_coefficient < 1.0
    assert names["result"].warnings == []
    assert capsys.readouterr().out


@pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning")
@pytest.mark.parametrize(
    "name", [*(f"identification/{page}" for page in ("index", "rubber", "afm", "teacher")), "development/reading"]
)
def test_code_beside_the_data_prints_what_the_page_shows(name, capsys, monkeypatch):
    monkeypatch.chdir(EXAMPLES / "identification")
    run(f"docs/{name}.md")
    assert capsys.readouterr().out == "".join(blocks(f"docs/{name}.md", "text"))


@pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")
@pytest.mark.parametrize("name", ["docs/indentation.md", "docs/geometries.md", "docs/error_bars.md", "docs/sports.md"])
def test_code_prints_what_the_page_shows(name, capsys):
    run(name)
    assert capsys.readouterr().out == "".join(blocks(name, "text"))


SOLID = 'equilibrium_modulus = "1 MPa"\nbranch_modulus = "2 MPa"\nviscosity = "2 kPa s"\npoisson_ratio = 0.5'
REST = case_file(material=SOLID, impact='velocity = "0.1 m/s"')


@pytest.mark.parametrize(
    ("name", "rest"), [("docs/quickstart.md", ""), ("docs/error_bars.md", ""), ("docs/geometries.md", REST)]
)
def test_case_files_are_solved(name, rest, folder):
    rows = "\n".join(f"{0.01 * k},{2.0 * (0.01 * k) ** 1.5}" for k in range(41))
    Path("twin.csv").write_text(f"depth [mm],force [N]\n{rows}\n")
    assert blocks(name, "toml")
    for block in blocks(name, "toml"):
        Path("case.toml").write_text(block + rest)
        assert 0.0 < restitution.read_case("case.toml").solve().restitution_coefficient < 1.0


def test_the_case_file_of_an_identification_is_that_of_the_example(folder):
    (case,) = blocks("docs/identification/index.md", "toml")
    data = EXAMPLES / "identification"
    Path("balls.csv").write_bytes((data / "balls.csv").read_bytes())
    Path("case.toml").write_text(case)
    page, example = (read_identification(file) for file in ("case.toml", data / "balls.toml"))
    assert page.section.options == example.section.options
    assert page.data[0].size == example.data[0].size


@pytest.mark.parametrize("name", ["README.md", "docs/teaching.md"])
def test_the_first_example_prints_what_the_page_shows(name, capsys):
    exec(blocks(name, "python")[0], {})
    assert [capsys.readouterr().out] == blocks(name, "text")


def test_case_file_and_python_of_the_readme_are_the_same_impact(tmp_path):
    names: dict[str, object] = {}
    exec(blocks("README.md", "python")[0], names)
    (case,) = blocks("README.md", "toml")
    file = tmp_path / "case.toml"
    file.write_text(case)
    result = restitution.read_case(file).solve()
    assert result.restitution_coefficient == pytest.approx(names["result"].restitution_coefficient, rel=1e-12)
    assert result.contact_time == pytest.approx(names["result"].contact_time, rel=1e-12)


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_public_names_exist(document):
    named = re.findall(r"\brs\.([A-Za-z_]\w*)", document.read_text())
    assert [name for name in named if not hasattr(restitution, name)] == []


@pytest.mark.parametrize("document", LINKED, ids=lambda path: str(path.relative_to(ROOT)))
def test_relative_links_exist(document):
    for target in map("".join, LINK.findall(document.read_text(encoding="utf-8"))):
        if re.match(r"\w+:", target):
            continue
        path, _, anchor = target.partition("#")
        file = (document.parent / path).resolve() if path else document
        assert file.exists(), target
        assert not anchor or anchor in anchors(file), target


@pytest.mark.parametrize("document", LINKED, ids=lambda path: str(path.relative_to(ROOT)))
def test_files_that_are_named_exist(document):
    named = PLACE.findall(document.read_text(encoding="utf-8"))
    assert [name for name in named if not (ROOT / name).exists()] == []


def test_no_module_hides_a_public_name():
    # Python sets a module as an attribute of its package, where the public name of the same spelling would stand.
    modules = {path.stem for path in (ROOT / "src" / "restitution").iterdir()}
    assert modules & set(restitution.__all__) == set()


def test_reference_names_every_public_name():
    reference = (ROOT / "docs" / "api" / "index.md").read_text()
    words = set(re.findall(r"[\w.]+", reference))
    public = {name for name in restitution.__all__ if not name.startswith("_")}
    assert {name for name in public if name not in words and f"restitution.impact.{name}" not in words} == set()


@pytest.mark.parametrize("name", ["README.md", "docs/index.md", "docs/theory/limits.md"])
def test_headline_numbers_are_computed(name):
    """Restitution coefficients and instantaneous Poisson ratios of the two examples."""
    text = (ROOT / name).read_text()
    for nu, p2, p3 in ((0.49, 1e-3, 10.0), (0.499, 0.0045, 6.0)):
        single = restitution.standard_solid_restitution(nu, p2, p3)
        limit = restitution.standard_solid_restitution(0.5, p2, p3)
        solid = restitution.standard_solid(1.0, 1.0 / p2, p3, poisson_ratio=nu)
        glass = solid.instantaneous_poisson_ratio
        assert re.search(rf"{glass:.2f}|{glass:.3f}", text), glass
        if name == "README.md":
            assert f"{100 * single:.2g} %" in text
            assert f"{100 * limit:.2g} %" in text
        elif name == "docs/index.md":
            assert f"{single:.3f}" in text
            assert f"{limit:.3f}" in text
    if name.endswith("limits.md"):
        assert f"{single:.4f}" in text
        assert f"{limit:.4f}" in text


@pytest.mark.parametrize(("name", "temperature"), [("epoxy", None), ("polyisobutylene", 233.0)])
def test_the_influence_of_the_bulk_modulus_is_computed(name, temperature):
    text = (ROOT / "docs" / "theory" / "limits.md").read_text()
    for bulk in (2e9, 3e9, 5e9 if name == "epoxy" else 4e9, math.inf):
        material = replace(restitution.library.get(name), bulk=bulk)
        material = material.at(temperature) if temperature else material
        impact = restitution.Impact(material, restitution.Parabola(0.005), mass=0.004, velocity=1.0)
        assert f"{restitution.solve(impact).restitution_coefficient:.3f}" in text


def test_poisson_ratios_of_the_curves_of_the_paper_are_computed():
    text = (ROOT / "docs" / "theory" / "limits.md").read_text()
    for p2 in (1e-2, 1e-3):
        solids = (
            restitution.standard_solid(1.0, 1.0 / p2, 1.0, poisson_ratio=nu)
            for nu in (0, 0.2, 0.3, 0.4, 0.45, 0.49, 0.499)
        )
        assert " | ".join(f"{solid.instantaneous_poisson_ratio:.3f}" for solid in solids) in text


def test_pages_that_load_from_another_host_are_found(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "docs")
    from foreign_hosts import loading_lines

    here = (
        '<a href="https://other.example/page">a</a> <script src="_static/a.js"></script> <p>https://other.example</p>'
    )
    (tmp_path / "here.html").write_text(here)
    (tmp_path / "here.css").write_text("a { background: url(a.svg) } /* https://other.example */")
    assert loading_lines(tmp_path) == []
    there = {
        "script.html": '<script defer src="https://other.example/a.js"></script>',
        "style.html": '<link rel="stylesheet" href="//other.example/a.css">',
        "inline.html": "<style>@import 'https://other.example/a.css';</style>",
        "picture.html": '<img alt="" src="HTTP://other.example/a.png">',
        "font.css": "@font-face { src: url('https://other.example/a.woff2') }",
    }
    for name, text in there.items():
        (tmp_path / name).write_text(text)
    assert {line.partition(":")[0] for line in loading_lines(tmp_path)} == there.keys()
    assert all("other.example" in line for line in loading_lines(tmp_path))


def test_the_architecture_names_every_package_and_only_those_there_are():
    text = (ROOT / "docs" / "development" / "architecture.md").read_text()
    rooms = re.findall(r"^\| (`.*?) \|", text, flags=re.MULTILINE)
    named = [name for row in rooms for name in re.findall(r"`(\w+)`", row)]
    folder = ROOT / "src" / "restitution"
    there = [path.stem for path in folder.iterdir() if path.suffix == ".py" or (path / "__init__.py").exists()]
    assert sorted(named) == sorted(name for name in there if not name.startswith("__"))
    assert [
        path
        for path in re.findall(r"`((?:\w+/)*\w+\.py)`", text)
        if not any((start / path).exists() for start in (folder, ROOT))
    ] == []
