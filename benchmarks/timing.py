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

# Processor time of this thread, which equals the wall-clock time on an idle machine. It is too coarse on Windows.
clock: Callable[[], float] = time.perf_counter if sys.platform == "win32" else time.thread_time

EXACT = 1e-11
"""Tolerance of the reference solves."""

# The tolerance of e is relative to e, or to this where e is smaller.
_FLOOR = 1e-3


class Speed(NamedTuple):
    """Time of an impact on one thread, and its error.

    Attributes
    ----------
    impacts : int
        Number of impacts in the array calls, which give the mean and the error.
    mean : float
        [s].
    alone : int
        Number of impacts that were timed one by one.
    median, worst : float
        Times of single impacts [s].
    error : float
        Largest absolute error of e.
    share : float
        Largest error over `rtol max(e, 1e-3)`; values below 1 are within the tolerance.
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
    """Time [s] of single impacts: the shortest call with many copies of an impact, over their number.

    It includes a share of the cost of the call itself, about 0.4 ms.
    """
    times = np.empty(len(chosen))
    for place, n in enumerate(chosen):
        same = problems.copies(n, copies)
        times[place] = best(partial(same.solve, rtol), repeats) / copies
        advance()
    return times


def in_array_calls(problems: Problems, rtol: float, repeats: int) -> tuple[float, float, float]:
    """Mean time [s] of an impact, and the largest error of e against rtol = 1e-11, also over `rtol max(e, 1e-3)`."""
    mean = best(lambda: problems.solve(rtol), repeats) / problems.size
    exact = problems.solve(EXACT)
    error = np.abs(problems.solve(rtol) - exact)
    share = error / (rtol * np.maximum(exact, _FLOOR))
    return mean, float(error.max()), float(share.max())


def evenly(problems: Problems, count: int) -> list[int]:
    """Return a number of evenly spaced impacts, including the first and the last."""
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
