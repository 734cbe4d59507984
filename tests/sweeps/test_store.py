"""Stores of sweeps: complete chunks, the same bytes after any number of interruptions, a single writer."""

import json
import shutil
import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import restitution as rs
from cases import BALL, FAST, RUBBER, case_file
from checkout import tree
from refusals import warns
from restitution.errors import RestitutionWarning
from restitution.sweeps import plan
from restitution.sweeps import store as stores
from restitution.sweeps.store import Store, sole_writer

# Many of these bodies exceed the limits of the theory.
pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")

AXES = {
    "velocity": rs.Logarithmic(0.01, 10.0, 23),
    "draw": rs.Samples(50, {"mass": rs.LogNormal(0.005, 0.1), "viscosity": rs.Normal(1e3, 50.0)}, rng=1),
    "nu": [0.3, 0.5],
    "external_force": 0.0,
}
CHUNK = {"velocity": 4, "draw": 30}
CASE = case_file(
    title="Balls on rubber", material=FAST, impact=None, sweep="chunk = 500",
    axes="""velocity = { logarithmic = ["1 cm/s", "10 m/s"], n = %d }
    radius = { linear = ["5 mm", "20 mm"], n = 50 }""",
)  # fmt: skip


def run(out: Path, **changes: Any) -> xr.Dataset:
    return rs.sweep(BALL, AXES, out=out, **({"chunk": CHUNK} | changes))


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("undisturbed") / "result.zarr"
    run(out)
    return out


def test_the_store_equals_the_result_in_memory(undisturbed: Path) -> None:
    memory, stored = rs.sweep(BALL, AXES, chunk=CHUNK), rs.open_sweep(undisturbed)
    xr.testing.assert_identical(stored.load(), memory)


def test_xarray_reads_the_store(undisturbed: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        plain = xr.open_zarr(undisturbed, chunks=None)
    assert {"mass", "viscosity", "external_force"} <= set(plain.coords)
    assert plain.restitution_coefficient.attrs["units"] == "1"
    metadata = [json.loads(path.read_text()) for path in undisturbed.rglob("zarr.json")]
    assert {content["zarr_format"] for content in metadata} == {3}


def test_one_chunk_is_one_file_of_each_output(undisturbed: Path) -> None:
    for name in ("restitution_coefficient", "contact_time", "status"):
        files = [path for path in (undisturbed / name / "c").rglob("*") if path.is_file()]
        assert len(files) == 6 * 2


def test_labels_are_stored(tmp_path: Path) -> None:
    soft = rs.standard_solid(1e5, 1e6, 1e3, poisson_ratio=0.45, name="soft rubber")
    result = rs.sweep(BALL, {"material": [RUBBER, soft], "velocity": [1.0]}, out=tmp_path / "out.zarr")
    assert result.material.values.tolist() == ["material 1", "soft rubber"]
    assert float(result.max_force.sel(material="soft rubber")[0]) < float(result.max_force[0, 0])


def test_a_single_point_is_stored(tmp_path: Path) -> None:
    for _ in range(2):
        single = rs.sweep(BALL, {"velocity": 0.5}, out=tmp_path / "one.zarr")
        assert float(single.contact_time) == rs.solve(rs.Impact(RUBBER, BALL.profile, 0.005, 0.5)).contact_time


class Cut(Exception):
    pass


def cut_after(chunks: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Interrupt every run after this number of chunks."""
    keep = Store.keep

    def limited(self: Store, index: Any, results: Any, tally: Any) -> None:
        self.kept = getattr(self, "kept", 0) + 1  # type: ignore[attr-defined]
        if self.kept > chunks:  # type: ignore[attr-defined]
            raise Cut
        keep(self, index, results, tally)

    monkeypatch.setattr(Store, "keep", limited)


@pytest.mark.parametrize("workers", [1, 3])
def test_an_interrupted_sweep_is_resumed(
    undisturbed: Path, tmp_path: Path, workers: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    computed: list[Any] = []
    compute = plan.Plan.compute

    def watched(self: Any, index: Any, *rest: Any) -> Any:
        computed.append(index)
        return compute(self, index, *rest)

    monkeypatch.setattr(plan.Plan, "compute", watched)
    cut_after(3, monkeypatch)
    out = tmp_path / "result.zarr"
    first_reports: list[int] = []
    for cuts in range(10):  # noqa: B007
        reports: list[int] = []
        try:
            run(out, workers=workers, progress=lambda done, _, reports=reports: reports.append(done))
            break
        except Cut:
            first_reports.append(reports[0])
    # Three of twelve chunks per run: the fourth run completes the store.
    assert cuts == 3
    assert first_reports[0] == 0
    assert first_reports == sorted(set(first_reports))
    assert reports[-1] == 2300
    assert set(computed) == set(np.ndindex(6, 2, 1))
    assert len(computed) <= 12 + 3 * workers
    assert tree(out) == tree(undisturbed)
    run(out)
    assert len(computed) <= 12 + 3 * workers


def test_an_unfinished_store_gives_a_warning(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "result.zarr"
    cut_after(5, monkeypatch)
    with pytest.raises(Cut):
        run(out, workers=1)
    with pytest.warns(RestitutionWarning, match="7 of 12 chunks are not computed yet"):
        part = rs.open_sweep(out)
    missing = part.status.values == -1
    assert 0 < missing.sum() < missing.size
    np.testing.assert_array_equal(np.isnan(part.contact_time.values), missing)


def test_the_status_of_a_chunk_is_written_last(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written: list[str] = []
    write = stores._write

    def watched(path: Path, content: bytes) -> None:
        if path.is_relative_to(tmp_path):
            written.append(str(path.relative_to(tmp_path / "a.zarr")))
        write(path, content)

    monkeypatch.setattr(stores, "_write", watched)
    outputs = ["contact_time", "restitution_coefficient"]
    rs.sweep(BALL, {"velocity": [0.1, 0.2]}, outputs, out=tmp_path / "a.zarr", chunk=1, workers=1)
    for place in ("0", "1"):
        mine = [name for name in written if name.endswith((f"/c/{place}", f"/c-{place}")) and "velocity" not in name]
        assert mine[-1] == f"status/c/{place}"
        assert sorted(mine) == sorted([f"validity/c-{place}", *(f"{name}/c/{place}" for name in (*outputs, "status"))])


@pytest.mark.parametrize(
    ("changes", "differing"),
    [({"rtol": 1e-8}, "rtol"), ({"outputs": ["contact_time"]}, "outputs"), ({"chunk": 100}, "chunk")],
)
def test_another_sweeps_store_is_refused(undisturbed: Path, changes: dict[str, Any], differing: str) -> None:
    before = tree(undisturbed)
    with pytest.raises(ValueError, match=rf"result\.zarr: holds a sweep already, another one in {differing}; choose"):
        run(undisturbed, **changes)
    other = rs.Impact(RUBBER, rs.Parabola(radius=0.02), mass=0.005, velocity=1.0)
    with pytest.raises(ValueError, match="another one in base, axes; choose"):
        rs.sweep(other, {**AXES, "nu": [0.2, 0.5]}, out=undisturbed, chunk=CHUNK)
    assert tree(undisturbed) == before


def test_another_versions_store_is_refused(undisturbed: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plan, "version", lambda _: "9.9")
    with pytest.raises(ValueError, match=rf"holds a sweep already, of version {rs.__version__}, not 9\.9; choose"):
        run(undisturbed)


def test_other_stores_are_refused(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "letter.txt").write_text("dear")
    (tmp_path / "file").write_text("x")
    xr.Dataset({"a": ("x", [1.0])}).to_zarr(tmp_path / "foreign.zarr", zarr_format=3, consolidated=False)
    for name in ("folder", "file", "foreign.zarr"):
        with pytest.raises(ValueError, match=f"{name}: is there already and holds no sweep; choose another name"):
            run(tmp_path / name)
        with pytest.raises(ValueError, match="holds no sweep"):
            rs.open_sweep(tmp_path / name)
    assert (tmp_path / "folder" / "letter.txt").read_text() == "dear"
    with pytest.raises(ValueError, match="no such folder: "):
        run(tmp_path / "nowhere" / "out.zarr")
    with pytest.raises(ValueError, match="nothing: no such folder"):
        rs.open_sweep(tmp_path / "nothing")


def test_a_second_writer_is_refused(undisturbed: Path) -> None:
    with sole_writer(undisturbed), pytest.raises(ValueError, match=r"result\.zarr: another process is writing it$"):
        run(undisturbed)
    run(undisturbed)


def test_partial_files_of_killed_writers_are_removed(undisturbed: Path, tmp_path: Path) -> None:
    out = tmp_path / "result.zarr"
    shutil.copytree(undisturbed, out)
    (out / "status" / "c" / "0" / "0" / "0").unlink()
    (out / "status" / "c" / "0" / "0" / ".0.4711.part").write_text("half")
    run(out)
    assert tree(out) == tree(undisturbed)
    (tmp_path / "again").mkdir()
    (tmp_path / "again" / ".4711.part").write_text("half")
    run(tmp_path / "again")
    assert tree(tmp_path / "again") == tree(undisturbed)


def test_a_full_disk_is_reported_in_one_line_and_the_store_resumes(
    undisturbed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from restitution.sweeps import store

    out, written = tmp_path / "result.zarr", 0
    write = store._write

    def limited(path: Path, content: bytes) -> None:
        nonlocal written
        if "/c/" in str(path) and "velocity" not in str(path):
            written += 1
        if written > 30:
            raise OSError(28, "No space left on device", str(path))
        write(path, content)

    monkeypatch.setattr(store, "_write", limited)
    with pytest.raises(OSError, match=r"device; [1-9] of 12 chunks are stored, and the same") as caught:
        run(out)
    assert caught.value.filename == str(out)
    monkeypatch.setattr(store, "_write", write)
    run(out)
    assert tree(out) == tree(undisturbed)


def test_a_store_that_cannot_be_made_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from restitution.sweeps import store

    def refuse(path: Path, _: bytes) -> None:
        raise OSError(30, "Read-only file system", str(path))

    monkeypatch.setattr(store, "_write", refuse)
    with pytest.raises(OSError, match="Read-only file system"):
        run(tmp_path / "out.zarr")
    assert list(tmp_path.iterdir()) == []


KILLER = """
import os, random, signal, sys, time
from pathlib import Path
import xarray, zarr
import restitution as rs
from restitution.sweeps import store

rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
ball = rs.Impact(rubber, rs.Parabola(radius=0.01), mass=0.005, velocity=1.0)
rs.standard_solid_restitution(0.3, 0.1, 1.0)

def start(out):
    # No thread runs in this process, so that it may fork; the kernel is compiled.
    child = os.fork()
    if child == 0:
        axes = {"velocity": rs.Logarithmic(0.01, 10.0, 200), "radius": rs.Linear(0.005, 0.02, 50)}
        rs.sweep(ball, axes, out=out, chunk={"velocity": 4}, workers=2)
        os._exit(0)
    return child

folder = Path(sys.argv[1])
begin = time.monotonic()
assert os.waitpid(start(folder / "undisturbed.zarr"), 0)[1] == 0
duration = time.monotonic() - begin
kills, moments = 0, random.Random(int(sys.argv[2]))
while kills < int(sys.argv[3]):
    child = start(folder / "killed.zarr")
    time.sleep(moments.uniform(0.0, 0.15 * duration))
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    if len(list((folder / "killed.zarr" / "status" / "c").glob("*/0"))) == 50:
        break
    # Only kills before the end of the sweep count.
    kills += 1
assert os.waitpid(start(folder / "killed.zarr"), 0)[1] == 0
print("kills", kills)
"""


@pytest.mark.slow
def test_killed_at_random_moments_it_ends_with_the_same_bytes(tmp_path: Path) -> None:
    kills, seed = 0, 0
    while kills < 12:
        folder = tmp_path / str(seed)
        folder.mkdir()
        output = subprocess.run(
            [sys.executable, "-c", KILLER, folder, str(seed), "12"], capture_output=True, text=True, timeout=900
        )
        assert output.returncode == 0, output.stderr
        kills += int(output.stdout.split()[-1])
        seed += 1
        assert tree(folder / "killed.zarr") == tree(folder / "undisturbed.zarr")
        assert sorted(path.name for path in folder.iterdir()) == ["killed.zarr", "undisturbed.zarr"]


def command(*arguments: Any) -> list[str]:
    # A shell that starts the tests in the background makes its children ignore the signal.
    interruptible = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
    run = "from restitution.cli.main import main; main()"
    return [sys.executable, "-c", interruptible + run, *map(str, arguments)]


@pytest.mark.slow
def test_ctrl_c_is_prompt_and_the_same_command_resumes(tmp_path: Path) -> None:
    (tmp_path / "sweep.toml").write_text(CASE % 40000)
    with subprocess.Popen(
        command("sweep", "sweep.toml", "--out", "out.zarr"), cwd=tmp_path, stderr=subprocess.PIPE, text=True
    ) as process:
        deadline = time.monotonic() + 600.0
        while not (tmp_path / "out.zarr" / "status" / "c").is_dir():
            assert time.monotonic() < deadline
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=600) == -signal.SIGINT
        assert process.stderr is not None
        assert process.stderr.read() == (
            "note: out.zarr: the same command resumes\nerror: interrupted; every file written is whole\n"
        )
    with warns("unfinished"):
        part = rs.open_sweep(tmp_path / "out.zarr")
    # The signal comes after the first chunks, and few follow it.
    assert 0 < int((part.status == 0).sum()) < 0.5 * part.status.size


MOUNT = """
set -e
mount -t tmpfs -o size=%s tmpfs "$1"
cd "$1"
cp ../sweep.toml .
set +e
"$2" -c "from restitution.cli.main import main; main()" sweep sweep.toml --out out.zarr
echo "exit $?" >&2
mount -o remount,rw,size=20m tmpfs "$1"
"$2" -c "from restitution.cli.main import main; main()" sweep sweep.toml --out out.zarr || exit 9
cp -r out.zarr ..
"""


def in_small_file_system(script: str, folder: Path) -> subprocess.CompletedProcess[str]:
    probe = subprocess.run(["unshare", "-rm", "true"], capture_output=True) if shutil.which("unshare") else None
    if probe is None or probe.returncode != 0:
        pytest.skip("no file systems can be mounted here")
    (folder / "small").mkdir()
    return subprocess.run(
        ["unshare", "-rm", "sh", "-c", script, "sh", folder / "small", sys.executable],
        capture_output=True,
        text=True,
        timeout=600,
    )


@pytest.mark.slow
def test_a_full_disk(tmp_path: Path) -> None:
    (tmp_path / "sweep.toml").write_text(CASE % 400)
    answer = in_small_file_system(MOUNT % "400k", tmp_path)
    lines = answer.stderr.splitlines()
    assert lines[0].startswith("error: out.zarr: No space left on device; "), answer.stderr
    assert lines[1] == "exit 2"
    assert answer.returncode == 0
    undisturbed = subprocess.run(
        command("sweep", "sweep.toml", "--out", "other.zarr"), cwd=tmp_path, capture_output=True, text=True
    )
    assert undisturbed.returncode == 0
    assert tree(tmp_path / "out.zarr") == tree(tmp_path / "other.zarr")
    chunks = sum(path.is_file() for path in (tmp_path / "other.zarr" / "status" / "c").rglob("*"))
    assert lines[0].endswith(f" of {chunks} chunks are stored, and the same command resumes")


@pytest.mark.slow
def test_a_read_only_folder(tmp_path: Path) -> None:
    (tmp_path / "sweep.toml").write_text(CASE % 10)
    script = MOUNT.replace("set +e", 'mount -o remount,ro tmpfs "$1"\nset +e') % "1m"
    answer = in_small_file_system(script, tmp_path)
    assert answer.stderr.splitlines()[:2] == ["error: out.zarr: Read-only file system", "exit 2"]
    assert answer.returncode == 0


LARGE = """
import resource, sys
import restitution as rs

rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
ball = rs.Impact(rubber, rs.Parabola(radius=0.01), mass=0.005, velocity=1.0)
rs.sweep(ball, {"velocity": [1.0]}, out=sys.argv[1] + "/first.zarr")
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

def stop(done, total):
    assert total == 10**8
    if done > 20_000:
        raise KeyboardInterrupt

try:
    axes = {"velocity": rs.Logarithmic(0.01, 10.0, 10_000), "radius": rs.Linear(0.005, 0.02, 10_000)}
    rs.sweep(ball, axes, out=sys.argv[1] + "/large.zarr", chunk=10_000, workers=2, progress=stop)
except KeyboardInterrupt:
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""


@pytest.mark.slow
def test_a_hundred_million_points_need_no_memory(tmp_path: Path) -> None:
    answer = subprocess.run([sys.executable, "-c", LARGE, tmp_path], capture_output=True, text=True, timeout=600)
    assert answer.returncode == 0, answer.stderr
    # A single output of all points would take 800 MB; the number is in kB.
    assert int(answer.stdout) < 60_000
