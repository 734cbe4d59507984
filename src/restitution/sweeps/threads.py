"""The chunks of a sweep on threads of this process."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from threading import Event, Lock
from typing import Any

from restitution.parallel import on_threads
from restitution.sweeps.grid import Index
from restitution.sweeps.plan import Interrupted, Plan

Keep = Callable[[Index, dict[str, Any]], None]


def run_on_threads(
    plan: Plan, chunks: Iterable[Index], keep: Keep, workers: int | None, report: Callable[[int], None]
) -> None:
    """Compute chunks on a pool of threads, one chunk a task.

    Parameters
    ----------
    plan : Plan
        The sweep.
    chunks : iterable of tuple of int
        Which chunks.
    keep : callable
        Takes the index and the results of a chunk, in any order and on any thread.
    workers : int or None
        Threads; all cores where None.
    report : callable
        Called on this thread with the number of points done so far.
    """
    lock, stop = Lock(), Event()
    counted = 0

    def tick(points: int) -> None:
        nonlocal counted
        if stop.is_set():
            raise Interrupted
        with lock:
            counted += points

    def run(index: Index) -> None:
        keep(index, plan.compute(index, tick))

    on_threads(run, chunks, workers, lambda: report(counted), stop)
