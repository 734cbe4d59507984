"""The lock file has public addresses only and belongs to the declared dependencies."""

import re
import tomllib
from typing import Any

import pytest
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from packaging.utils import canonicalize_name

from checkout import ROOT

PUBLIC = ("https://pypi.org/simple", "https://files.pythonhosted.org/packages/")


@pytest.fixture(scope="module")
def project() -> dict[str, Any]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


@pytest.fixture(scope="module")
def lock() -> dict[str, Any]:
    return tomllib.loads((ROOT / "uv.lock").read_text())


def requirement(text: str, extra: str | None = None) -> tuple[str, str, frozenset[str], str | None]:
    parsed = Requirement(text)
    return canonicalize_name(parsed.name), str(parsed.specifier), frozenset(parsed.extras), extra


def test_addresses_are_public():
    addresses = re.findall(r"\w+://[^\"' ]+", (ROOT / "uv.lock").read_text())
    assert addresses
    assert [address for address in addresses if not address.startswith(PUBLIC)] == []


def test_packages_come_from_the_index_or_from_here(lock):
    for package in lock["package"]:
        expected = {"editable": "."} if package["name"] == "restitution" else {"registry": PUBLIC[0]}
        assert package["source"] == expected, package["name"]


def test_every_file_has_its_hash(lock):
    for package in lock["package"]:
        files = [*package.get("wheels", []), *([package["sdist"]] if "sdist" in package else [])]
        assert all(file["hash"].startswith("sha256:") for file in files), package["name"]
        assert files or package["name"] == "restitution", package["name"]


def test_lock_belongs_to_the_declared_dependencies(project, lock):
    declared = {requirement(text) for text in project["dependencies"]}
    for extra, texts in project["optional-dependencies"].items():
        declared |= {requirement(text, extra) for text in texts}
    project_entry = next(package for package in lock["package"] if package["name"] == "restitution")
    locked = set()
    for entry in project_entry["metadata"]["requires-dist"]:
        extra = re.search(r"extra == '([^']+)'", entry.get("marker", ""))
        locked.add(
            (
                canonicalize_name(entry["name"]),
                str(SpecifierSet(entry.get("specifier", ""))),
                frozenset(entry.get("extras", ())),
                extra.group(1) if extra else None,
            )
        )
    assert locked == declared
    assert lock["requires-python"] == project["requires-python"]


def test_locked_versions_satisfy_the_bounds(project, lock):
    versions: dict[str, list[str]] = {}
    for package in lock["package"]:
        # The package itself has none: it is defined in its source.
        versions.setdefault(package["name"], []).append(package.get("version", ""))
    texts = [
        *project["dependencies"],
        *(text for extra in project["optional-dependencies"].values() for text in extra),
    ]
    for parsed in map(Requirement, texts):
        for version in versions[canonicalize_name(parsed.name)]:
            assert parsed.specifier.contains(version), f"{parsed} and the locked {version}"
