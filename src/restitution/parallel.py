"""Tasks on a pool of threads, and how long work ends early: by an interrupt, or by a limit of its caller."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from contextlib import contextmanager
from contextvars import ContextVar, copy_context
from threading import Event, Lock
from typing import Any

# Threads that more `workers` than processors may ask for.
_MOST = 1024

_CHECKS: ContextVar[tuple[Callable[[], None], ...]] = ContextVar("checks", default=())


@contextmanager
def ended_by(check: Callable[[], None]) -> Generator[None]:
    """End the work inside, also on its threads, at the next checkpoint where the function raises.

    It must raise what no solver catches: after an `InputError` some try other steps.
    """
    token = _CHECKS.set((*_CHECKS.get(), check))
    try:
        yield
    finally:
        _CHECKS.reset(token)


def checkpoint() -> None:
    """Raise where the work has to end. Long work calls this between pieces of less than a second."""
    for check in _CHECKS.get():
        check()


def on_threads(
    run: Callable[[Any], None],
    tasks: Iterable[Any],
    workers: int | None,
    report: Callable[[], None],
    stop: Event | None = None,
) -> None:
    """Run tasks on threads until all are done, one raises, or the caller is interrupted.

    There are as many threads as cores unless `workers` is given. `report` is called on this thread every tenth of a
    second and whenever a thread ends. The event `stop` is set when the work has to end; `checkpoint` looks at it.
    """
    todo, lock, stop = iter(tasks), Lock(), stop or Event()

    def interrupt() -> None:
        if stop.is_set():
            raise KeyboardInterrupt

    def work() -> None:
        with ended_by(interrupt):
            while not stop.is_set():
                with lock:
                    task = next(todo, None)
                if task is None:
                    return
                run(task)

    workers = min(workers or os.cpu_count() or 1, _MOST)
    with ThreadPoolExecutor(workers) as pool:
        try:
            # A future for each thread, not for each task: an interrupt while `wait` holds the locks of thousands of
            # futures would leave some locked for ever.
            pending = {pool.submit(copy_context().run, work) for _ in range(workers)}
            while pending:
                finished, pending = wait(pending, timeout=0.1, return_when=FIRST_COMPLETED)
                for future in finished:
                    future.result()
                report()
        finally:
            stop.set()
