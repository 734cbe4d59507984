"""The chunks of a sweep on threads of this process."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from threading import Event, Lock
from typing import Any

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
    todo, lock, stop = iter(chunks), Lock(), Event()
    counted = 0

    def tick(points: int) -> None:
        nonlocal counted
        if stop.is_set():
            raise Interrupted
        with lock:
            counted += points

    def work() -> None:
        while not stop.is_set():
            with lock:
                index = next(todo, None)
            if index is None:
                return
            keep(index, plan.compute(index, tick))

    workers = workers or os.cpu_count() or 1
    with ThreadPoolExecutor(workers) as pool:
        try:
            pending = {pool.submit(work) for _ in range(workers)}
            while pending:
                finished, pending = wait(pending, timeout=0.1, return_when=FIRST_COMPLETED)
                for future in finished:
                    future.result()
                report(counted)
        finally:
            stop.set()
