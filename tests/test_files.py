import os
import signal
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from refusals import in_one_line
from restitution import Surrogate, open_sweep, read_bounces, read_case, read_material, read_observations
from restitution.errors import InputError
from restitution.files import whole_file, write_table


def test_partial_file_is_beside_the_target_and_hidden(tmp_path: Path) -> None:
    with whole_file(tmp_path / "data.nc") as partial:
        assert partial.parent == tmp_path
        assert partial.name.startswith(".")
        partial.write_text("all")
        assert not (tmp_path / "data.nc").exists()
    assert [path.name for path in tmp_path.iterdir()] == ["data.nc"]


def write_half(target: Path, error: BaseException) -> None:
    with whole_file(target) as partial:
        partial.write_text("ha")
        raise error


@pytest.mark.parametrize("error", [OSError("disk full"), KeyboardInterrupt()])
def test_failure_leaves_the_old_file(tmp_path: Path, error: BaseException) -> None:
    target = tmp_path / "data.nc"
    target.write_text("old")
    with pytest.raises(type(error)):
        write_half(target, error)
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("data.nc", "old")]


def test_a_link_at_the_target_is_replaced_and_not_followed(tmp_path: Path) -> None:
    (tmp_path / "victim").write_text("precious")
    (tmp_path / "data.nc").symlink_to(tmp_path / "victim")
    with whole_file(tmp_path / "data.nc") as partial:
        assert not partial.is_symlink()
        partial.write_text("all")
    assert (tmp_path / "victim").read_text() == "precious"
    assert not (tmp_path / "data.nc").is_symlink()


def test_names_of_partial_files_are_random(tmp_path: Path) -> None:
    with whole_file(tmp_path / "a") as first, whole_file(tmp_path / "a") as other:
        assert first.name != other.name
        assert str(os.getpid()) not in first.name.split(".")


def test_fsync_of_the_content_before_the_rename_and_of_the_folder_after_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    steps: list[str] = []
    sync, replace = os.fsync, os.replace

    def watched_sync(handle: int) -> None:
        steps.append("folder" if stat.S_ISDIR(os.fstat(handle).st_mode) else "content")
        sync(handle)

    def watched_replace(source: Path, target: Path) -> None:
        steps.append("rename")
        replace(source, target)

    monkeypatch.setattr(os, "fsync", watched_sync)
    monkeypatch.setattr(os, "replace", watched_replace)
    with whole_file(tmp_path / "a") as partial:
        partial.write_text("all")
    assert steps == ["content", "rename", "folder"]


def test_new_file_has_the_usual_permissions(tmp_path: Path) -> None:
    (tmp_path / "plain").touch()
    with whole_file(tmp_path / "whole") as partial:
        partial.touch()
    assert (tmp_path / "whole").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_killed_writer_leaves_the_old_file(tmp_path: Path) -> None:
    target = tmp_path / "data.txt"
    target.write_text("old")
    script = (
        "import sys, time\n"
        "from restitution.files import whole_file\n"
        "with whole_file(sys.argv[1]) as partial:\n"
        "    partial.write_text('ha')\n"
        "    print('writing', flush=True)\n"
        "    time.sleep(60)\n"
    )
    with subprocess.Popen([sys.executable, "-c", script, target], stdout=subprocess.PIPE) as writer:
        assert writer.stdout is not None
        writer.stdout.readline()
        os.kill(writer.pid, signal.SIGKILL)
        writer.wait()
    assert target.read_text() == "old"
    # The partial file of the killed writer does not prevent a later write.
    with whole_file(target) as partial:
        partial.write_text("new")
    assert target.read_text() == "new"


def test_errors_name_the_target(tmp_path: Path) -> None:
    target = tmp_path / "no" / "data.nc"
    with pytest.raises(FileNotFoundError) as caught, whole_file(target) as partial:
        partial.write_text("all")
    assert caught.value.filename == str(target)
    with pytest.raises(OSError, match="No space left") as caught, whole_file(tmp_path / "data.nc"):
        raise OSError(28, "No space left on device")
    assert caught.value.filename == str(tmp_path / "data.nc")


def test_tables_are_in_long_form_with_units_and_descriptions(tmp_path: Path) -> None:
    result = xr.Dataset(
        {"force": (("time", "ball"), [[1.0, 2.0], [3.0, np.nan]], {"units": "N"})},
        {"time": ("time", [0.0, 0.1], {"units": "s"}), "ball": ["a, b", "c"], "mass": ((), 5.0, {"units": "kg"})},
    )
    for suffix in (".csv", ".nc"):
        assert write_table(result, tmp_path / f"t{suffix}") == tmp_path / f"t{suffix}"
    rows = pd.read_csv(tmp_path / "t.csv")
    assert sorted(rows.columns) == ["ball", "force [N]", "mass [kg]", "time [s]"]
    assert rows["force [N]"].fillna(-1.0).tolist() == [1.0, 2.0, 3.0, -1.0]
    assert rows["ball"].tolist() == ["a, b", "c"] * 2
    xr.testing.assert_identical(xr.open_dataset(tmp_path / "t.nc").load(), result)
    write_table(result.isel(time=0, ball=0), tmp_path / "one.csv")
    assert pd.read_csv(tmp_path / "one.csv")["force [N]"].tolist() == [1.0]


@pytest.mark.parametrize("name", ["t.txt", "t", "t.zarr", "t.csv.gz"])
def test_other_kinds_of_tables_are_refused_with_the_list(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match=r"\.csv or \.nc"):
        write_table(xr.Dataset(), tmp_path / name)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("read", [read_case, read_material, read_observations, Surrogate.load, open_sweep])
@pytest.mark.parametrize("path", [None, 3, ["a.csv"], {"mass": 1.0}])
def test_what_is_no_name_of_a_file_is_refused(read: Callable[..., Any], path: Any) -> None:
    assert in_one_line(lambda: read(path), TypeError).field == "path"


@pytest.mark.parametrize("read", [open_sweep, read_bounces, read_case, read_material, read_observations])
def test_a_name_that_no_file_can_have_is_refused(read: Callable[[str], Any]) -> None:
    assert "null character" in in_one_line(lambda: read("a\0b.csv")).rule
