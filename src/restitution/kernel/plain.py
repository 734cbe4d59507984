"""Entry points as plain Python, for the first single problems while there is no machine code.

The compiler takes ten seconds for what an interpreter does in a hundredth of one. So as long as the cache has no
machine code of an entry point, a single problem runs copies of the same functions without the compiler. After
`PATIENCE` a process compiles, and so does every process after `ALLOWANCE` of them all. A call that takes `LONGEST`
begins again, compiled, with its arrays as they were.
"""

import os
import sys
import time
from collections.abc import Callable, Generator, Iterable
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from threading import RLock, local
from types import FunctionType
from typing import Any

import numpy as np

from restitution.kernel.cache import cache_folder, has_machine_code, stamp

PATIENCE = 2.0
"""Processor time [s] without the compiler after which a process begins no other call without it."""

LONGEST = 6.0
"""Processor time [s] of one call without the compiler."""

ALLOWANCE = 10.0
"""Processor time [s] of all processes without the compiler; a small file in the cache has their sum."""

# A user who sets this switch of numba, to 0 or to 1, has decided.
_SWITCH = "NUMBA_DISABLE_JIT"


class _TooLong(Exception):
    """A call has taken the time that is left without the compiler."""


class _Thread(local):
    single: bool | None = None
    end = 0.0  # of the call that runs, in processor time of the thread


_thread = _Thread()
_lock = RLock()
_spent = 0.0
_modules: dict[str, dict[str, Any]] = {}


@contextmanager
def single_problem() -> Generator[None]:
    """Solve one problem in the block: entry points may run without the compiler, in this thread."""
    with _set(_thread.single is not False):
        yield


@contextmanager
def compiled_only() -> Generator[None]:
    """Compile what is called in the block, whatever it solves."""
    with _set(False):
        yield


@contextmanager
def _set(single: bool) -> Generator[None]:
    before, _thread.single = _thread.single, single
    try:
        yield
    finally:
        _thread.single = before


def with_plain_calls(dispatcher: Any, compile_for: Callable[..., Any]) -> Callable[..., Any]:
    """Return what numba calls where an entry point has no machine code yet: it returns the function to be called."""
    function = dispatcher.py_func
    name = f"{function.__module__.removeprefix('restitution.')}.{function.__name__}"

    def choose(*arguments: Any, **named: Any) -> Any:
        if _thread.single and is_plain(name):
            return partial(_run, dispatcher)
        return compile_for(*arguments, **named)

    return choose


def is_plain(entry_point: str) -> bool:
    """Return whether a single problem calls an entry point, such as "kernel.impact.solve_block", as plain Python."""
    if _SWITCH in os.environ or _spent >= PATIENCE or has_machine_code(entry_point):
        return False
    return spent() < ALLOWANCE


def _run(dispatcher: Any, *arguments: Any) -> Any:
    """Call an entry point as plain Python; again, compiled, if that takes too long or meets an error of arithmetic."""
    function = plain(dispatcher)
    kept = [(array, array.copy()) for array in _arrays(arguments)]
    begin = time.thread_time()
    _thread.end = begin + LONGEST
    try:
        with np.errstate(all="ignore"):
            return function(*arguments)
    except (_TooLong, ArithmeticError, ValueError):
        # Python refuses to divide by zero, where machine code goes on with an infinite number.
        for array, before in kept:
            array[...] = before
    finally:
        _spend(time.thread_time() - begin)
    with compiled_only():
        return dispatcher(*arguments)


def _arrays(arguments: Iterable[Any]) -> Generator[np.ndarray[Any, Any]]:
    for argument in arguments:
        if isinstance(argument, np.ndarray) and argument.flags.writeable:
            yield argument
        elif isinstance(argument, tuple):
            yield from _arrays(argument)


def plain(dispatcher: Any) -> Callable[..., Any]:
    """Return a compiled function as one of plain Python, which calls only such functions."""
    function, kind = dispatcher.py_func, type(dispatcher)
    with _lock:
        names = _modules.get(function.__module__)
        if names is None:
            names = _modules[function.__module__] = dict(vars(sys.modules[function.__module__]))
            names |= {name: plain(value) for name, value in names.items() if isinstance(value, kind)}
    copy = FunctionType(function.__code__, names, function.__name__, function.__defaults__)
    # Pieces that are compiled into their callers are called too often for a look at the clock.
    return copy if dispatcher.targetoptions.get("forceinline") else _limited(copy)


def _limited(function: Callable[..., Any]) -> Callable[..., Any]:
    def call(*arguments: Any) -> Any:
        if time.thread_time() > _thread.end:
            raise _TooLong
        return function(*arguments)

    return call


def note() -> Path | None:
    """Return the file with the processor time of all processes; None where nothing can be kept."""
    folder = cache_folder()
    return None if folder is None else Path(folder) / f"plain-{stamp(Path(__file__).parent)}"


def spent() -> float:
    """Return the processor time [s] that all processes have taken without the compiler."""
    file = note()
    with suppress(OSError, ValueError):
        return float(file.read_text("ascii")) if file else 0.0
    return 0.0


def _spend(seconds: float) -> None:
    global _spent
    with _lock:
        _spent += seconds
        file = note()
        with suppress(OSError):
            if file:
                file.write_text(f"{spent() + seconds:.6f}", "ascii")
