"""The chunks of a sweep as tasks on a Dask cluster."""

from __future__ import annotations

import importlib.util
import logging
import os
import signal
from collections.abc import Callable, Generator, Iterable
from contextlib import contextmanager
from importlib.metadata import version
from itertools import islice
from pathlib import Path
from typing import Any

from restitution.doubts import Tally
from restitution.errors import InputError
from restitution.sweeps.grid import Index
from restitution.sweeps.plan import Plan

# Number of tasks that the scheduler has at a time: enough for it to ask for more workers.
_LEAST_KNOWN = 256
_KNOWN_PER_CORE = 4
# Retries of a task that raised, e.g. because the file system was briefly unavailable. Lost workers do not count.
_RETRIES = 2
# An idle scheduler answers at once, a busy one within seconds.
_PATIENCE = "10s"


def check_cluster(cluster: Any) -> None:
    """Refuse a text that is no address, and a missing Dask."""
    if isinstance(cluster, str) and cluster != "local" and "://" not in cluster:
        raise InputError("cluster", cluster, "must be 'local' or an address such as tcp://host:8786")
    if importlib.util.find_spec("distributed") is None:
        raise InputError("engine", "dask", "is not installed; pip install 'restitution[dask]'")


@contextmanager
def connected(cluster: Any, workers: int | None) -> Generator[Any]:
    """Yield a client of the cluster: of new processes, of the scheduler at an address, or of what is given."""
    from distributed import Client, LocalCluster

    if isinstance(cluster, Client):
        yield cluster
        return
    if cluster == "local":
        options: dict[str, Any] = {
            "n_workers": workers or os.cpu_count() or 1,
            "threads_per_worker": 1,
            # Without a host, the scheduler's web server would listen on all interfaces.
            "dashboard_address": "127.0.0.1:0",
            # Interrupted workers warn of their tasks; what matters comes through the client, in one line.
            "silence_logs": logging.CRITICAL,
        }
        with LocalCluster(**options) as local, Client(local) as client:
            client.register_plugin(_left_to_the_client())
            yield client
        return
    try:
        client = Client(cluster, timeout=_PATIENCE) if isinstance(cluster, str) else Client(cluster)
    except (OSError, ValueError) as error:
        raise InputError("cluster", cluster, f"no scheduler answers: {error}") from None
    with client:
        yield client


def run_on_dask(plan: Plan, chunks: Iterable[Index], keeper: Any, client: Any, report: Callable[[int], None]) -> None:
    """Compute chunks on a Dask cluster, a chunk a task; workers write into the store themselves."""
    from distributed import as_completed

    todo = iter(chunks)
    done = 0
    # The plan is a task, so that it is sent again if its worker dies.
    shared = client.submit(_same, plan, pure=False)
    made_by = plan.description["version"]

    def submit(indices: Iterable[Index]) -> list[Any]:
        return [
            client.submit(_compute, shared, made_by, index, keeper.path, pure=False, retries=_RETRIES)
            for index in indices
        ]

    known = max(_LEAST_KNOWN, _KNOWN_PER_CORE * sum(client.nthreads().values()))
    running = as_completed(submit(islice(todo, known)))
    pending: set[Any] = set(running.futures)
    try:
        for future in running:
            index, results, tally = future.result()
            if results is not None:
                keeper.keep(index, results, tally)
            done += plan.grid.size(index)
            report(done)
            pending.discard(future)
            fresh = submit(islice(todo, 1))
            pending.update(fresh)
            running.update(fresh)
    except BaseException:
        client.cancel(list(pending), force=True)
        raise


def _same(plan: Plan) -> Plan:
    return plan


def _compute(plan: Plan, made_by: str, index: Index, path: Path | None) -> tuple[Index, dict[str, Any] | None, Tally]:
    """Compute a chunk on a worker, and write it where there is a store."""
    if made_by != version("restitution"):
        raise RuntimeError(f"a worker has restitution {version('restitution')}, the sweep is of {made_by}")
    tally = Tally()
    results = plan.compute(index, tally=tally)
    if path is None:
        return index, results, tally
    if not path.is_dir():
        raise RuntimeError(f"a worker does not see {path}: workers and client must share the file system")
    from restitution.sweeps.store import Store

    Store(path, plan).keep(index, results, tally)
    return index, None, tally


def _left_to_the_client() -> Any:
    """Return a plugin with which workers ignore Ctrl-C in the terminal; this process ends them."""
    from distributed import WorkerPlugin

    class LeftToTheClient(WorkerPlugin):
        def setup(self, worker: Any) -> None:
            signal.signal(signal.SIGINT, signal.SIG_IGN)

    return LeftToTheClient()
