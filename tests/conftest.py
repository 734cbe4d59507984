import os
from pathlib import Path

import pytest

# Compiled code alone, so that no bit depends on what the cache has; the tests of plain Python take this away.
os.environ.setdefault("NUMBA_DISABLE_JIT", "0")


@pytest.fixture(scope="session")
def shared_reference() -> Path:
    """Folder of reference values beside the project; tests that need it are skipped if it is absent."""
    folder = Path(__file__).resolve().parents[2] / "shared" / "reference"
    if not folder.is_dir():
        pytest.skip("the reference folder beside the project is absent")
    return folder


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder, in which the test runs."""
    monkeypatch.chdir(tmp_path)
    return tmp_path
