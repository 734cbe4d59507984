"""Sweeps: many impacts over named axes, in memory or in a store, on threads or on a cluster."""

from __future__ import annotations

import importlib.util
import logging
import os
import signal
from collections.abc import Callable, Generator, Iterable, Mapping
from contextlib import ExitStack, contextmanager
from copy import copy
from importlib.metadata import version
from itertools import islice
from pathlib import Path
from threading import Event, Lock
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from restitution.checks import function, instance, one_of, single, whole
from restitution.errors import InputError, InputTypeError
from restitution.files import TABLES, path_of
from restitution.impact.problem import Impact
from restitution.impact.status import Status, failures
from restitution.parallel import on_threads
from restitution.quantities import DEFAULT_OUTPUTS, SOLVER_RTOL, checked_outputs
from restitution.sweeps.grid import Index, make_grid
from restitution.sweeps.plan import (
    BuilderTemplate,
    ImpactTemplate,
    InMemory,
    Interrupted,
    Plan,
    Template,
    dimensionless_template,
)
from restitution.tally import Tally, messages
from restitution.validity import warn
from restitution.variation import HeldElastic

if TYPE_CHECKING:
    import xarray as xr

Progress = Callable[[int, int], None]
Engine = Literal["threads", "dask"]

# Number of tasks that the scheduler has at a time: enough to make it request more workers.
_LEAST_KNOWN = 256
_KNOWN_PER_CORE = 4
# Retries of a task that raised, e.g. because the file system was briefly unavailable. Lost workers do not count.
_RETRIES = 2
# An idle scheduler answers at once, a busy one within seconds.
_PATIENCE = "10s"


def sweep(
    base: Impact | Callable[..., Impact] | None,
    axes: Mapping[str, Any],
    outputs: Iterable[str] = DEFAULT_OUTPUTS,
    *,
    out: str | Path | None = None,
    chunk: int | Mapping[str, int] | None = None,
    rtol: float = 1e-9,
    held: HeldElastic = "bulk_modulus",
    engine: Engine = "threads",
    cluster: Any = "local",
    workers: int | None = None,
    progress: Progress | None = None,
    title: str = "",
) -> xr.Dataset:
    """Return the restitution coefficient, contact time, peaks and energies of many impacts over named axes.

    Parameters
    ----------
    base : Impact, callable or None
        An impact, or a function that takes values of axes by name and returns one. None: the paper's problem, which
        takes axes over `nu`, `p2` and `p3`.
    axes : dict
        By name of a quantity: `Linear`, `Logarithmic`, a sequence of numbers or objects, or one value for all
        points. By name of a dimension of your own: `Samples`. Quantities are those of the impact (`velocity`,
        `mass`, `external_force`), of its adhesion (`work`, `stress`, `range`), of its profile (`radius`,
        `half_angle`), of its material (`poisson_ratio` or `nu`,
        `bulk_modulus`, `equilibrium_modulus`, `branch_modulus`, `viscosity`, `relaxation_time`,
        `branch_moduli[0]`, `relaxation_times[0]`, `temperature`, `p2`, `p3`), the materials themselves
        (`material`, `counter_material`), and the arguments of the function.
    outputs : sequence of str
        Names of `restitution.quantities.OUTPUTS`, `OBLIQUE`, `ADHESION` or `VALIDITY`.
    out : path-like, optional
        Folder of a Zarr store, to which finished chunks are written. The same call resumes an interrupted sweep.
    chunk : int or dict of str to int, optional
        Points of a chunk, or points along each dimension. A chunk is one task; an interrupt loses unfinished chunks.
    rtol : float
        The error of e stays below `rtol max(e, 1e-3)`; with adhesion it is at least 1e-6, see `AdhesiveResult`.
    held : {"bulk_modulus", "poisson_ratio"}
        Which of the two stays constant while `equilibrium_modulus` varies.
    engine : {"threads", "dask"}
        Threads of this process, or the processes of a Dask cluster.
    cluster : str or object
        With Dask: "local", the address of a scheduler, a cluster or a client.
    workers : int, optional
        Threads, or processes of the local cluster; all cores by default. Results do not depend on it.
    progress : callable, optional
        Called with (points done, all points).
    title : str
        Title of the result.

    Returns
    -------
    xarray.Dataset
        The outputs and `status` over the axes, with units; the attributes describe the sweep. The result of a store
        is loaded piece by piece on access. Failed impacts are NaN, their status gives the reason, and a warning counts
        them. One `RestitutionWarning` for each doubtful assumption of the theory counts the impacts that exceed it;
        the attribute `validity` holds the report as JSON.

    Raises
    ------
    InputError
        If an axis or an option is out of range or of another type, the results do not fit in memory, or the store
        holds something else. An end of an axis that makes no admissible impact is refused before the sweep begins.
    OSError
        If the store cannot be written; finished chunks stay.

    Notes
    -----
    `branch_modulus` and `p2` keep the viscosity, `relaxation_time` and `viscosity` the branch modulus.
    `branch_moduli[k]` and `relaxation_times[k]` keep each other.

    Examples
    --------
    >>> import restitution as rs
    >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
    >>> ball = rs.Impact(material=rubber, profile=rs.Parabola(radius=0.01), mass=0.005, velocity=1.0)
    >>> result = rs.sweep(ball, {"velocity": rs.Logarithmic(0.01, 0.1, 5), "radius": [0.005, 0.01]})
    >>> result.restitution_coefficient.dims, result.velocity.attrs["units"]
    (('velocity', 'radius'), 'm/s')
    """
    if not (base is None or isinstance(base, Impact) or callable(base)):
        raise InputTypeError("base", base, "must be an Impact, a function that returns one, or None")
    if not isinstance(axes, Mapping) or not all(isinstance(name, str) for name in axes):
        raise InputTypeError("axes", axes, "must be a dict from names to values")
    one_of("held", held, ("bulk_modulus", "poisson_ratio"))
    single("rtol", SOLVER_RTOL.check(rtol))
    instance("title", title, str, "must be a text")
    if progress is not None:
        function("progress", progress, "must be callable with (points done, all points)", 2)
    grid = make_grid(axes, chunk, adhesive=isinstance(base, Impact) and base.adhesion is not None)
    template: Template
    if base is None:
        template = dimensionless_template(grid.names)
    else:
        template = ImpactTemplate(base, held) if isinstance(base, Impact) else BuilderTemplate(base, held)
    plan = Plan(template, grid, checked_outputs(outputs), float(rtol), title)
    return run(plan, out=out, engine=engine, cluster=cluster, workers=workers, progress=progress)


def run(
    plan: Plan,
    *,
    out: str | Path | None = None,
    engine: Engine = "threads",
    cluster: Any = "local",
    workers: int | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Run a planned sweep; see `sweep` for the options."""
    one_of("engine", engine, ("threads", "dask"))
    if workers is not None:
        whole("workers", workers, 1)
    if out is not None and path_of(out, "out").suffix.lower() in TABLES:
        rule = "must be the folder of a Zarr store; write_table writes the result as a table"
        raise InputError("out", str(out), rule)
    if engine == "dask":
        if isinstance(cluster, str) and cluster != "local" and "://" not in cluster:
            raise InputError("cluster", cluster, "must be 'local' or an address such as tcp://host:8786")
        if importlib.util.find_spec("distributed") is None:
            raise InputError("engine", "dask", "is not installed; pip install 'restitution[dask]'")
    plan.check()
    grid = plan.grid
    with ExitStack() as stack:
        # The client is connected first: without a scheduler no store must be left behind.
        client = stack.enter_context(_connected(cluster, workers)) if engine == "dask" else None
        if out is None:
            keeper: Any = InMemory(plan)
            done: set[Index] = set()
        else:
            # Zarr takes half a second to import, which a sweep in memory does not need.
            from restitution.sweeps.store import opened

            try:
                keeper = stack.enter_context(opened(Path(out), plan))
                done = keeper.done()
            except OSError as error:
                raise OSError(error.errno, error.strerror, str(out)) from error
        before = sum(grid.size(index) for index in done)
        chunks = (index for index in grid.chunks() if index not in done)

        def report(points: int) -> None:
            if progress is not None:
                progress(before + points, grid.n_points)

        report(0)
        try:
            if len(done) == grid.n_chunks:
                pass
            elif client is None:
                _run_on_threads(plan, chunks, keeper.keep, workers, report)
            else:
                _run_on_dask(plan, chunks, keeper, client, report)
        except OSError as error:
            if out is None or error.strerror is None:
                raise
            stored = f"{len(keeper.done())} of {grid.n_chunks} chunks are stored, and the same command resumes"
            raise OSError(error.errno, f"{error.strerror}; {stored}", str(out)) from error
        _count_failures(keeper, grid.n_points)
        dataset = keeper.dataset()
        warn(messages(dataset.attrs), stacklevel=3)
        return dataset


def _count_failures(keeper: Any, n_points: int) -> None:
    counts = np.zeros(len(Status), dtype=np.int64)
    for statuses in keeper.statuses():
        counts += np.bincount(statuses.ravel(), minlength=len(Status))
    message = failures(counts.tolist(), n_points)
    warn({"failed": message} if message else {}, stacklevel=3)


def _run_on_threads(
    plan: Plan,
    chunks: Iterable[Index],
    keep: Callable[[Index, dict[str, Any], Tally], None],
    workers: int | None,
    report: Callable[[int], None],
) -> None:
    """Compute chunks as tasks on a pool of threads; `keep` is called in any order and on any thread."""
    lock, stop = Lock(), Event()
    counted = 0

    def tick(points: int) -> None:
        nonlocal counted
        if stop.is_set():
            raise Interrupted
        with lock:
            counted += points

    def run(index: Index) -> None:
        tally = Tally()
        keep(index, plan.compute(index, tick, tally), tally)

    on_threads(run, chunks, workers, lambda: report(counted), stop)


@contextmanager
def _connected(cluster: Any, workers: int | None) -> Generator[Any]:
    """Yield a client of a new local cluster, of the scheduler at an address, or of a cluster; or a client itself."""
    from distributed import Client, LocalCluster

    with ExitStack() as stack:
        if cluster == "local":
            options: dict[str, Any] = {
                "n_workers": workers or os.cpu_count() or 1,
                "threads_per_worker": 1,
                # Without a host, the scheduler's web server would listen on all interfaces.
                "dashboard_address": "127.0.0.1:0",
                # Interrupted workers warn of their tasks; what matters comes through the client, in one line.
                "silence_logs": logging.CRITICAL,
            }
            client = stack.enter_context(Client(stack.enter_context(LocalCluster(**options))))
            client.run(_leave_ctrl_c_to_the_client)
        elif isinstance(cluster, Client):
            client = cluster
        else:
            try:
                client = stack.enter_context(Client(cluster, timeout=_PATIENCE))
            except (OSError, ValueError) as error:
                raise InputError("cluster", cluster, f"no scheduler answers: {error}") from None
        yield client


def _leave_ctrl_c_to_the_client() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _run_on_dask(plan: Plan, chunks: Iterable[Index], keeper: Any, client: Any, report: Callable[[int], None]) -> None:
    """Compute chunks as tasks on a Dask cluster; workers write into the store."""
    from distributed import as_completed

    # The plan is a task, so that it is sent again if its worker is lost.
    shared = client.submit(copy, plan, pure=False)
    release = plan.description["version"]
    tasks = (
        client.submit(_compute, shared, release, index, keeper.path, pure=False, retries=_RETRIES) for index in chunks
    )
    window = max(_LEAST_KNOWN, _KNOWN_PER_CORE * sum(client.nthreads().values()))
    pending = set(islice(tasks, window))
    running, done = as_completed(pending.copy()), 0
    try:
        for future in running:
            index, results, tally = future.result()
            if results is not None:
                keeper.keep(index, results, tally)
            done += plan.grid.size(index)
            report(done)
            pending.discard(future)
            fresh = list(islice(tasks, 1))
            pending.update(fresh)
            running.update(fresh)
    except BaseException:
        client.cancel(list(pending), force=True)
        raise


def _compute(plan: Plan, release: str, index: Index, path: Path | None) -> tuple[Index, dict[str, Any] | None, Tally]:
    """Compute a chunk on a worker, and write it if there is a store."""
    if release != version("restitution"):
        raise RuntimeError(f"a worker has restitution {version('restitution')}, the sweep is of {release}")
    tally = Tally()
    results = plan.compute(index, tally=tally)
    if path is None:
        return index, results, tally
    if not path.is_dir():
        raise RuntimeError(f"a worker does not see {path}: workers and client must share the file system")
    from restitution.sweeps.store import Store

    Store(path, plan).keep(index, results, tally)
    return index, None, tally
