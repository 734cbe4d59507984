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
from restitution.sweeps.grid import Index
from restitution.sweeps.plan import Plan

Keep = Callable[[Index, dict[str, Any], Tally], None]

# Tasks that the scheduler knows of at a time: enough for it to see that more workers would be of use.
_LEAST_KNOWN = 256
_KNOWN_PER_CORE = 4
# Of a task that raises, as for a file system that is away for a moment; that a worker dies does not count.
_RETRIES = 2
# A scheduler that runs answers at once, a busy one within seconds.
_PATIENCE = "10s"


def check_cluster(cluster: Any) -> None:
    """Refuse what cannot work, before there is a store.

    Raises
    ------
    ValueError
        If the address is none, or Dask is not installed.
    """
    if isinstance(cluster, str) and cluster != "local" and "://" not in cluster:
        raise ValueError(f"cluster = {cluster!r}: must be 'local' or an address such as tcp://host:8786")
    if importlib.util.find_spec("distributed") is None:
        raise ValueError("engine = 'dask': is not installed; pip install 'restitution[dask]'")


@contextmanager
def connected(cluster: Any) -> Generator[Any]:
    """Give a client in place of an address; a cluster or a client as it is.

    Raises
    ------
    ValueError
        If no scheduler answers.
    """
    from distributed import Client

    if not isinstance(cluster, str) or cluster == "local":
        yield cluster
        return
    try:
        client = Client(cluster, timeout=_PATIENCE)
    except (OSError, ValueError) as error:
        raise ValueError(f"cluster = {cluster}: no scheduler answers: {error}") from None
    with client:
        yield client


def run_on_dask(
    plan: Plan,
    chunks: Iterable[Index],
    keep: Keep,
    path: Path | None,
    cluster: Any,
    workers: int | None,
    report: Callable[[int], None],
) -> None:
    """Compute chunks as tasks on a Dask cluster, one chunk a task.

    Parameters
    ----------
    plan : Plan
        The sweep.
    chunks : iterable of tuple of int
        Which chunks.
    keep : callable
        Takes the index, the results and the tally of a chunk where there is no store.
    path : Path or None
        The store, into which the workers write.
    cluster : str or object
        "local" for processes on this machine, a cluster or a client.
    workers : int or None
        Processes of the local cluster; all cores where None.
    report : callable
        Called with the number of points done so far.
    """
    from distributed import as_completed

    todo = iter(chunks)
    done = 0
    with _client(cluster, workers) as client:
        # As a task, the plan is made again where the worker that had it dies.
        shared = client.submit(_same, plan, pure=False)

        made_by = plan.description["version"]

        def submit(indices: Iterable[Index]) -> list[Any]:
            return [
                client.submit(_compute, shared, made_by, index, path, pure=False, retries=_RETRIES)
                for index in indices
            ]

        known = max(_LEAST_KNOWN, _KNOWN_PER_CORE * sum(client.nthreads().values()))
        running = as_completed(submit(islice(todo, known)))
        pending: set[Any] = set(running.futures)
        try:
            for future in running:
                index, results, own = future.result()
                if results is not None:
                    keep(index, results, own)
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
    """Plugin of workers that Ctrl-C in the terminal leaves to this process to end."""
    from distributed import WorkerPlugin

    class LeftToTheClient(WorkerPlugin):
        def setup(self, worker: Any) -> None:
            signal.signal(signal.SIGINT, signal.SIG_IGN)

    return LeftToTheClient()


@contextmanager
def _client(cluster: Any, workers: int | None) -> Generator[Any]:
    from distributed import Client, LocalCluster

    if isinstance(cluster, Client):
        yield cluster
        return
    if cluster == "local":
        processes = workers or os.cpu_count() or 1
        # Workers that an interrupt ends warn of the tasks that they had.
        options: dict[str, Any] = {
            "threads_per_worker": 1,
            # Without a host, the scheduler's web server would listen on all interfaces.
            "dashboard_address": "127.0.0.1:0",
            # What matters comes through the client, in one line.
            "silence_logs": logging.CRITICAL,
        }
        with LocalCluster(n_workers=processes, **options) as local, Client(local) as client:
            client.register_plugin(_left_to_the_client())
            yield client
        return
    with Client(cluster) as client:
        yield client
