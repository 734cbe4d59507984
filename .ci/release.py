"""Build the wheel and the source archive twice and require one hash of each; compare a tag with the version."""

import argparse
import hashlib
import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def version() -> str:
    """Return the version, which stands in the package alone."""
    text = (ROOT / "src" / "restitution" / "__init__.py").read_text(encoding="utf-8")
    return next(line.split('"')[1] for line in text.splitlines() if line.startswith("__version__"))


def copy_files(folder: Path) -> None:
    """Copy the files that git knows or would add."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        check=True,
    )
    for name in filter(None, listed.stdout.decode().split("\0")):
        source, target = ROOT / name, folder / name
        if source.is_file():
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(source.read_bytes())


def build(folder: Path, mask: int) -> dict[str, bytes]:
    """Build both archives in a fresh copy, under another mask of permissions; return their bytes by name."""
    before = os.umask(mask)
    try:
        copy_files(folder / "source")
        subprocess.run(
            [sys.executable, "-m", "uv", "build", "-q", "--out-dir", str(folder / "dist"), str(folder / "source")],
            check=True,
        )
    finally:
        os.umask(before)
    return {
        path.name: path.read_bytes() for path in sorted((folder / "dist").iterdir()) if path.suffix in (".whl", ".gz")
    }


def build_twice() -> dict[str, bytes]:
    """Return the archives; exit if two builds from copies of the tree differ."""
    with tempfile.TemporaryDirectory() as first, tempfile.TemporaryDirectory() as second:
        built, again = build(Path(first), 0o022), build(Path(second), 0o077)
    if built != again:
        names = sorted(name for name in built.keys() | again.keys() if built.get(name) != again.get(name))
        sys.exit(f"two builds differ in {', '.join(names)}")
    return built


def main() -> None:
    """Do what the options ask for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tag", help="a tag, which must be v and the version")
    parser.add_argument("--build", type=Path, metavar="FOLDER", help="put both archives there and print their hashes")
    options = parser.parse_args()
    if options.tag and options.tag != f"v{version()}":
        sys.exit(f"the tag is {options.tag}, the version {version()}")
    if options.build:
        options.build.mkdir(parents=True, exist_ok=True)
        for name, content in build_twice().items():
            (options.build / name).write_bytes(content)
            print(hashlib.sha256(content).hexdigest(), name)


if __name__ == "__main__":
    main()
