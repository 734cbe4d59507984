"""The version, the bounds and the licences that several files state agree, and a build can be repeated."""

import hashlib
import importlib.metadata
import importlib.util
import json
import linecache
import re
import subprocess
import sys
import tomllib
import zipfile
from typing import Any

import pytest

import restitution
from checkout import ROOT
from restitution.errors import RestitutionWarning, deprecated

CONDA = {"matplotlib": "matplotlib-base"}


@pytest.fixture(scope="module")
def project() -> dict[str, Any]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def bounds(project: dict[str, Any]) -> dict[str, str]:
    """Lower bound of each dependency, and of Python."""
    result = dict(re.fullmatch(r"([\w-]+)>=([\d.]+)", text).groups() for text in project["dependencies"])
    return result | {"python": project["requires-python"].removeprefix(">=")}


def only_match(pattern: str, name: str) -> str:
    """The only match of a pattern in a file."""
    (result,) = re.findall(pattern, (ROOT / name).read_text(), flags=re.MULTILINE)
    return result


def test_all_versions_agree(project):
    assert project["dynamic"] == ["version"]
    assert {
        only_match(r'^__version__ = "(.+)"$', "src/restitution/__init__.py"),
        restitution.__version__,
        importlib.metadata.version("restitution"),
        only_match(r"^version: (\S+)$", "CITATION.cff"),
        json.loads((ROOT / "codemeta.json").read_text())["version"],
        only_match(r"^  version: (\S+)$", "recipe/recipe.yaml"),
    } == {restitution.__version__}


def test_other_files_state_the_same_project(project):
    meta = json.loads((ROOT / "codemeta.json").read_text())
    assert meta["description"] == project["description"]
    assert meta["keywords"] == project["keywords"]
    assert meta["runtimePlatform"] == f"Python {project['requires-python'].replace('>=', '>= ')}"
    assert {*meta["softwareRequirements"], "python"} == set(bounds(project))
    assert f"license: {project['license']}\n" in (ROOT / "recipe" / "recipe.yaml").read_text()
    assert only_match(r"^license: (\S+)$", "CITATION.cff") == meta["license"].rpartition("/")[2]
    assert project["license"].split(" AND ")[0] == meta["license"].rpartition("/")[2]


def test_the_recipe_has_the_bounds(project):
    text = (ROOT / "recipe" / "recipe.yaml").read_text().partition("  run:\n")[2].partition("\n\n")[0]
    stated = dict(
        re.findall(
            r"- (\S+) >=(\S+)",
            text.replace("${{ python_min }}", only_match(r'python_min: "(.+)"', "recipe/recipe.yaml")),
        )
    )
    assert stated == {CONDA.get(name, name): bound for name, bound in bounds(project).items()}


def test_the_page_has_the_bounds(project):
    rows = re.findall(
        r"^\| (\w+) \| ([\d.]+) \|", (ROOT / "docs" / "development" / "releases.md").read_text(), re.MULTILINE
    )
    assert len(rows) == 6
    assert dict(rows).items() <= bounds(project).items()


def test_every_licence_of_a_file_is_in_the_wheel(project):
    named = set(re.findall(r'SPDX-License-Identifier = "(.+)"', (ROOT / "REUSE.toml").read_text()))
    assert named == set(project["license"].split(" AND ")) == {path.stem for path in (ROOT / "LICENSES").iterdir()}
    for path in re.findall(r'"(src/\S+)"', (ROOT / "REUSE.toml").read_text()):
        assert (ROOT / path).is_file(), path


def test_actions_are_pinned_to_commits():
    used = [
        line.split("uses:")[1].strip()
        for path in (ROOT / ".github" / "workflows").glob("*.yml")
        for line in path.read_text().splitlines()
        if "uses:" in line
    ]
    assert used
    assert [action for action in used if not re.fullmatch(r"[\w./-]+@[0-9a-f]{40} # v[\d.]+", action)] == []


def test_a_tag_must_be_the_version():
    command = [sys.executable, ROOT / ".ci" / "release.py", "--tag"]
    assert subprocess.run([*command, f"v{restitution.__version__}"], check=False).returncode == 0
    wrong = subprocess.run([*command, "v99.0.0"], capture_output=True, text=True, check=False)
    assert wrong.returncode == 1
    assert wrong.stderr == f"the tag is v99.0.0, the version {restitution.__version__}\n"


def test_a_deprecation_names_what_takes_its_place_where_it_is_used():
    def public(old=None):
        if old is not None:
            deprecated("old", "new", "9.9")

    with pytest.warns(
        RestitutionWarning, match=r"^old: is deprecated and will be removed in version 9.9; use new$"
    ) as caught:
        public(old=1)
    assert (caught[0].message.kind, caught[0].filename) == ("deprecated", __file__)
    assert "public(old=1)" in linecache.getline(__file__, caught[0].lineno)


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("uv") is None, reason="uv builds the archives")
@pytest.mark.skipif(not (ROOT / ".git").exists(), reason="the files are those that git knows")
def test_two_builds_have_one_hash(tmp_path):
    printed = subprocess.run(
        [sys.executable, ROOT / ".ci" / "release.py", "--build", tmp_path], capture_output=True, text=True, check=True
    ).stdout
    for digest, name in (line.split() for line in printed.splitlines()):
        assert hashlib.sha256((tmp_path / name).read_bytes()).hexdigest() == digest
    (wheel,) = tmp_path.glob("*.whl")
    names = {name.partition("/")[2] for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/licenses" in name}
    assert names == {"licenses/LICENSE", "licenses/LICENSES/BSD-3-Clause.txt", "licenses/LICENSES/MIT.txt"}
