"""Timing of calls, insensitive to other load on the machine."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from problems import Problems

Array = NDArray[np.float64]

# Processor time of this thread: the same as time on the clock where nothing else runs. That of Windows is too coarse.
clock: Callable[[], float] = time.perf_counter if sys.platform == "win32" else time.thread_time

EXACT = 1e-11
"""Tolerance of the solves against which errors are measured."""

# The tolerance of e is relative to e, or to this where e is smaller.
_FLOOR = 1e-3


class Speed(NamedTuple):
    """Time of an impact on one thread, and the error met.

    Attributes
    ----------
    impacts : int
        Impacts of the array calls from which the mean and the error are.
    mean : float
        [s].
    alone : int
        Impacts that were timed one by one.
    median, worst : float
        Of those [s].
    error : float
        Largest absolute error of e.
    share : float
        Largest error over `rtol max(e, 1e-3)`; below 1 the tolerance is met.
    """

    impacts: int
    mean: float
    alone: int
    median: float
    worst: float
    error: float
    share: float


def best(call: Callable[[], Any], repeats: int) -> float:
    """Shortest time [s] of several calls."""
    shortest = float("inf")
    for _ in range(repeats):
        start = clock()
        call()
        shortest = min(shortest, clock() - start)
    return shortest


def one_by_one(
    problems: Problems,
    chosen: Sequence[int],
    rtol: float,
    *,
    copies: int,
    repeats: int,
    advance: Callable[[], None] = lambda: None,
) -> Array:
    """Time [s] of each of some impacts: the shortest of several calls with so many copies of it, over their number.

    The cost of a call itself, some 0.4 ms, is part of it.
    """
    times = np.empty(len(chosen))
    for place, n in enumerate(chosen):
        same = problems.copies(n, copies)
        times[place] = best(partial(same.solve, rtol), repeats) / copies
        advance()
    return times


def in_array_calls(problems: Problems, rtol: float, repeats: int) -> tuple[float, float, float]:
    """Mean time [s] of an impact, largest error of e against rtol = 1e-11, and over `rtol max(e, 1e-3)`."""
    mean = best(lambda: problems.solve(rtol), repeats) / problems.size
    exact = problems.solve(EXACT)
    error = np.abs(problems.solve(rtol) - exact)
    share = error / (rtol * np.maximum(exact, _FLOOR))
    return mean, float(error.max()), float(share.max())


def evenly(problems: Problems, count: int) -> list[int]:
    """Return so many of the impacts, the first and the last among them."""
    return np.linspace(0, problems.size - 1, count).astype(int).tolist()


def speed(
    problems: Problems,
    rtol: float,
    *,
    alone: int,
    copies: int,
    repeats: int,
    advance: Callable[[], None] = lambda: None,
) -> Speed:
    """Measure mean, median and worst time of an impact on one thread, and the error of e against rtol = 1e-11."""
    mean, error, share = in_array_calls(problems, rtol, repeats)
    advance()
    chosen = evenly(problems, alone)
    times = one_by_one(problems, chosen, rtol, copies=copies, repeats=repeats, advance=advance)
    return Speed(problems.size, mean, alone, float(np.median(times)), float(times.max()), error, share)
