"""Sweeps on Dask: the same bytes as on threads; the chunk of a killed worker is computed again."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import distributed
import numpy as np
import pytest
import xarray as xr

import restitution as rs
from cases import BALL, FAST, RUBBER, case_file
from checkout import tree
from restitution.sweeps import run

pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")]

AXES = {"velocity": rs.Logarithmic(0.01, 10.0, 200), "radius": rs.Linear(0.005, 0.02, 100)}


@pytest.fixture(scope="module")
def client() -> Any:
    options: dict[str, Any] = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": "127.0.0.1:0"}
    with distributed.LocalCluster(**options) as local, distributed.Client(local) as connected:
        yield connected


def test_dask_and_threads_write_the_same_bytes(client: Any, tmp_path: Path) -> None:
    rs.sweep(BALL, AXES, chunk=1000, out=tmp_path / "threads.zarr")
    seen: list[tuple[int, int]] = []
    rs.sweep(
        BALL,
        AXES,
        chunk=1000,
        out=tmp_path / "dask.zarr",
        engine="dask",
        cluster=client,
        progress=lambda done, total: seen.append((done, total)),
    )
    assert tree(tmp_path / "dask.zarr") == tree(tmp_path / "threads.zarr")
    assert seen[-1] == (20_000, 20_000)
    assert [done for done, _ in seen] == sorted(done for done, _ in seen)


def test_results_in_memory(client: Any) -> None:
    axes = {"velocity": AXES["velocity"], "material": [RUBBER, rs.standard_solid(1e5, 1e6, 1e3, poisson_ratio=0.5)]}
    memory = rs.sweep(BALL, axes, chunk=100)
    xr.testing.assert_identical(rs.sweep(BALL, axes, chunk=100, engine="dask", cluster=client), memory)


def test_stored_chunks_are_not_computed_again(client: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "out.zarr"
    rs.sweep(BALL, AXES, chunk=1000, out=out)
    before = tree(out)
    for place in ("3/0", "5/2"):
        (out / "status" / "c" / place).unlink()
    indices, submit_all = list[Any](), run._run_on_dask

    def watched(plan: Any, chunks: Any, *rest: Any) -> None:
        indices.extend(chunks := list(chunks))
        submit_all(plan, chunks, *rest)

    monkeypatch.setattr(run, "_run_on_dask", watched)
    rs.sweep(BALL, AXES, chunk=1000, out=out, engine="dask", cluster=client)
    assert indices == [(3, 0), (5, 2)]
    assert tree(out) == before


def test_more_tasks_than_the_scheduler_gets_at_once(client: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "_LEAST_KNOWN", 3)
    monkeypatch.setattr(run, "_KNOWN_PER_CORE", 1)
    result = rs.sweep(BALL, {"velocity": AXES["velocity"]}, chunk=10, engine="dask", cluster=client)
    np.testing.assert_array_equal(result.status, 0)


def test_a_worker_that_is_killed_costs_a_retry(tmp_path: Path) -> None:
    rs.sweep(BALL, AXES, chunk=500, out=tmp_path / "threads.zarr")
    options: dict[str, Any] = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": "127.0.0.1:0"}
    with distributed.LocalCluster(**options) as local, distributed.Client(local) as client:
        pids = list(client.run(os.getpid).values())
        victims: list[int] = []

        def kill_one(done: int, total: int) -> None:
            if not victims and done >= total // 4:
                victims.append(pids[0])
                os.kill(pids[0], signal.SIGKILL)

        result = rs.sweep(
            BALL, AXES, chunk=500, out=tmp_path / "dask.zarr", engine="dask", cluster=client, progress=kill_one
        )
    assert victims
    assert int((result.status == 0).sum()) == 20_000
    assert tree(tmp_path / "dask.zarr") == tree(tmp_path / "threads.zarr")


def test_errors_of_a_function_on_a_worker_are_raised(client: Any) -> None:
    def build(radius: float) -> rs.Impact:
        if radius > 0.01:
            raise RuntimeError("the wheel has come off")
        return BALL

    with pytest.raises(RuntimeError, match="the wheel has come off"):
        rs.sweep(build, {"radius": [0.01, 0.015, 0.01]}, engine="dask", cluster=client, chunk=1)


def test_a_worker_of_another_version_is_refused(client: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    from restitution.sweeps import plan

    monkeypatch.setattr(plan, "version", lambda _: "9.9")
    with pytest.raises(RuntimeError, match=rf"a worker has restitution {rs.__version__}, the sweep is of 9\.9"):
        rs.sweep(BALL, {"velocity": [1.0]}, engine="dask", cluster=client)


def test_a_missing_scheduler_is_reported_before_a_store_is_made(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(run, "_PATIENCE", "1s")
    address = "tcp://127.0.0.1:9"
    with pytest.raises(ValueError, match=rf"^cluster = '{address}': no scheduler answers: .* after 1 s$"):
        rs.sweep(BALL, {"velocity": [1.0]}, out=tmp_path / "r.zarr", engine="dask", cluster=address)
    assert not list(tmp_path.iterdir())


def test_a_missing_dask_is_reported_with_the_command_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(ValueError, match=r"engine = 'dask': is not installed; pip install 'restitution\[dask\]'"):
        rs.sweep(BALL, {"velocity": [1.0]}, engine="dask")


CASE = case_file(
    material=FAST, impact=None, sweep="chunk = 500",
    axes="""velocity = { logarithmic = ["1 cm/s", "10 m/s"], n = 400 }
    radius = { linear = ["5 mm", "20 mm"], n = 50 }""",
)  # fmt: skip


def test_the_command_runs_and_resumes_on_a_local_cluster(tmp_path: Path) -> None:
    (tmp_path / "sweep.toml").write_text(CASE)
    command = [sys.executable, "-c", "from restitution.cli.main import main; main()"]
    for arguments in (("--out", "threads.zarr"), ("--out", "dask.zarr", "--dask", "local", "--workers", "2")):
        if "--dask" in arguments:
            with subprocess.Popen([*command, "sweep", "sweep.toml", *arguments], cwd=tmp_path) as first:
                deadline = time.monotonic() + 600.0
                while not (tmp_path / "dask.zarr" / "status" / "c").is_dir() and first.poll() is None:
                    assert time.monotonic() < deadline
                    time.sleep(0.02)
                first.send_signal(signal.SIGKILL)
        answer = subprocess.run(
            [*command, "sweep", "sweep.toml", *arguments], cwd=tmp_path, capture_output=True, text=True, timeout=600
        )
        assert answer.returncode == 0, answer.stderr
        assert "error" not in answer.stderr
        assert answer.stdout.startswith("20000 impacts in ")
    assert tree(tmp_path / "dask.zarr") == tree(tmp_path / "threads.zarr")


@pytest.mark.slow
def test_ctrl_c_ends_the_command_with_two_lines(tmp_path: Path) -> None:
    (tmp_path / "sweep.toml").write_text(CASE.replace("n = 50", "n = 2000"))
    # As from a terminal, the workers receive the signal, too. The shell of pytest may make its children ignore it.
    interruptible = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
    command = [
        *(sys.executable, "-c", interruptible + "from restitution.cli.main import main; main()"),
        *("sweep", "sweep.toml", "--out", "o.zarr", "--dask", "local", "--workers", "2"),
    ]
    with subprocess.Popen(
        command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as process:
        deadline = time.monotonic() + 600.0
        while not (tmp_path / "o.zarr" / "status" / "c").is_dir() and process.poll() is None:
            assert time.monotonic() < deadline
            time.sleep(0.02)
        os.killpg(process.pid, signal.SIGINT)
        out, err = process.communicate(timeout=600)
    assert (out, err) == (
        "",
        "note: o.zarr: the same command resumes\nerror: interrupted; every file written is whole\n",
    )


def test_the_local_cluster_listens_on_this_machine_only() -> None:
    import psutil

    addresses: set[str] = set()

    def look(*_: int) -> None:
        me = psutil.Process()
        for process in (me, *me.children(recursive=True)):
            for connection in process.net_connections(kind="inet"):
                if connection.status == psutil.CONN_LISTEN:
                    addresses.add(connection.laddr.ip)

    rs.sweep(BALL, {"velocity": AXES["velocity"]}, chunk=50, engine="dask", workers=1, progress=look)
    assert addresses
    assert addresses <= {"127.0.0.1", "::1"}
