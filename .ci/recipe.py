"""Build the recipe of the conda package as a feedstock does, and run the tests that it states.

Without a channel of conda, one is made: the packages in it are this interpreter and the distributions that it sees, a
package each, in their versions. The recipe is then built for this Python, whatever lowest one it states. An unknown or
missing key of the recipe is an error, and so is a bound that no version in the channel meets.
"""

import argparse
import hashlib
import importlib.metadata
import json
import os
import platform
import sys
import sysconfig
import tarfile
import tempfile
from collections.abc import Iterator
from pathlib import Path
from zipfile import ZipFile

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from rattler_build import (
    FileEntry,
    Package,
    RenderConfig,
    Stage0Recipe,
    ToolConfiguration,
    VariantConfig,
    assemble_package,
)
from release import copy_files

# Names that a distribution does not share with its conda package.
CONDA = {"matplotlib": "matplotlib-base"}
PYTHON = f"{sys.version_info.major}.{sys.version_info.minor}"
LIBRARY = f"lib/python{PYTHON}"
# Schemes of Pythons that Debian and Fedora have changed: packed elsewhere they look for packages in other folders.
CHANGED = {"posix_local", "rpm_prefix"}
# What neither building nor running needs: half of the files of some distributions are their tests.
OMITTED = {"__pycache__", "test", "tests", "site-packages", "dist-packages", "idlelib", "tkinter", "ensurepip"}


def package(channel: Path, name: str, version: str, depends: list[str], files: list[FileEntry]) -> None:
    """Put a package into a channel."""
    subdir = RenderConfig().target_platform
    options = {"files": files, "depends": depends, "compression_level": 1}
    path = assemble_package(name, version, subdir, "0", channel / subdir, **options).path
    content, index = path.read_bytes(), channel / subdir / "repodata.json"
    records = json.loads(index.read_text()) if index.exists() else {"packages.conda": {}}
    records["packages.conda"][path.name] = {
        "name": name, "version": version, "build": "0", "build_number": 0, "depends": depends, "subdir": subdir,
        "sha256": hashlib.sha256(content).hexdigest(), "size": len(content),
    }  # fmt: skip
    index.write_text(json.dumps(records))


def conda_name(name: str) -> str:
    """Return the name of a distribution's conda package."""
    return CONDA.get(canonicalize_name(name), canonicalize_name(name))


def interpreter(channel: Path) -> None:
    """Put this Python into a channel, without what was installed for it."""
    program, library = Path(sys.executable).resolve(), Path(sysconfig.get_config_var("LDLIBRARY") or "")
    files = [FileEntry.from_paths(program, f"bin/{name}") for name in ("python", "python3", f"python{PYTHON}")]
    shared = Path(sysconfig.get_config_var("LIBDIR") or "").glob(f"{library.name}*") if library.suffix == ".so" else ()
    files += [FileEntry.from_paths(path, f"lib/{path.name}") for path in shared]
    standard = Path(sysconfig.get_path("stdlib"))
    for path in standard.rglob("*"):
        inside = path.relative_to(standard)
        if path.is_file() and not OMITTED & {*inside.parts} and not inside.parts[0].startswith("config-"):
            files.append(FileEntry.from_paths(path, f"{LIBRARY}/{inside}"))
    package(channel, "python", platform.python_version(), [], files)


def needed(names: list[str]) -> Iterator[importlib.metadata.Distribution]:
    """Yield the distributions of these names and those that they need, each once."""
    known = set()
    while names:
        name = canonicalize_name(names.pop())
        if name not in known:
            known.add(name)
            yield (distribution := importlib.metadata.distribution(name))
            names.extend(requirement.name for requirement in requirements(distribution))


def requirements(distribution: importlib.metadata.Distribution) -> list[Requirement]:
    """Return what a distribution needs in this Python, without its extras."""
    stated = map(Requirement, distribution.requires or ())
    return [entry for entry in stated if entry.marker is None or entry.marker.evaluate({"extra": ""})]


def distributions(channel: Path, names: list[str]) -> None:
    """Put distributions of this interpreter, and those that they need, into a channel."""
    for distribution in needed(names):
        depends = ["python", *(conda_name(requirement.name) for requirement in requirements(distribution))]
        files = [
            FileEntry.from_paths(str(distribution.locate_file(path)), f"{LIBRARY}/site-packages/{path}")
            for path in distribution.files or ()
            if path.parts[0] not in ("..", "bin") and not OMITTED & {*path.parts}
        ]
        package(channel, conda_name(distribution.name), distribution.version, depends, files)


def make_channel(folder: Path) -> str:
    """Make a channel of what building and running the package needs, and return its address."""
    (folder / "noarch").mkdir(parents=True)
    (folder / "noarch" / "repodata.json").write_text('{"packages.conda": {}}')
    interpreter(folder)
    runtime = [requirement.name for requirement in requirements(importlib.metadata.distribution("restitution"))]
    distributions(folder, ["pip", "hatchling", *runtime])
    return folder.as_uri()


def build(source: Path, output: Path, channel: str) -> Package:
    """Build the recipe in a copy of the tree, run its tests, and return the package."""
    (variant,) = Stage0Recipe.from_file(source / "recipe" / "recipe.yaml").render(VariantConfig())
    configuration = ToolConfiguration(test_strategy="skip", use_sharded=False)
    result = variant.run_build(configuration, output, [channel], package_format="tar.bz2")
    built = Package.from_file(result.packages[0])
    assert built.depends == [*map(str, variant.recipe.requirements.run)], built.depends
    tests = built.run_tests(channel=[channel], use_sharded=False)
    if not tests or not all(tests):
        sys.exit("\n".join(line for test in tests for line in test.output))
    print(f"{built.filename}: {len(built.files)} files, {len(tests)} tests passed, depends on", *built.depends)
    return built


def compare(built: Package, wheel: Path) -> None:
    """Exit if a package lacks a file of the wheel, its command or a licence."""
    with ZipFile(wheel) as archive:
        missing = {f"site-packages/{name}" for name in archive.namelist()} - {*built.files}
    with tarfile.open(built.path) as archive:
        missing |= {"info/licenses/LICENSE", "info/licenses/LICENSES/MIT.txt"} - {*archive.getnames()}
        commands = json.load(archive.extractfile("info/link.json"))["noarch"]["entry_points"]
    (distribution,) = importlib.metadata.distributions(path=[str(wheel)])
    stated = distribution.entry_points.select(group="console_scripts")
    if missing or commands != [f"{command.name} = {command.value}" for command in stated]:
        sys.exit(f"the package lacks {sorted(missing)}; its commands are {commands}")


def main() -> None:
    """Build the recipe against the channel that is stated, or one made here."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("wheel", type=Path, help="a wheel of the same tree, whose files the package must have")
    parser.add_argument("--channel", help="a channel of conda, in place of one made of this Python")
    options = parser.parse_args()
    if not options.channel and CHANGED & {*sysconfig.get_scheme_names()}:
        print("conda package: skipped, the Python of this distribution has folders of its own and cannot be packed")
        return
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        os.environ["RATTLER_CACHE_DIR"] = str(folder / "cache")
        copy_files(folder / "source")
        if not options.channel:
            recipe = folder / "source" / "recipe" / "recipe.yaml"
            recipe.write_text(recipe.read_text().replace('python_min: "3.11"', f'python_min: "{PYTHON}"'))
        channel = options.channel or make_channel(folder / "channel")
        compare(build(folder / "source", folder / "output", channel), options.wheel)


if __name__ == "__main__":
    main()
