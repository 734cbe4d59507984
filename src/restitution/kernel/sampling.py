"""Values of the stored halves of an impact at given times."""

from typing import Any

from restitution.kernel.compile import compiled, entry_point
from restitution.kernel.dense import crossing, value
from restitution.kernel.lanes import WIDTH
from restitution.kernel.radau import Scheme
from restitution.kernel.workspace import F_, LENGTH, N_APPROACH, N_REBOUND, START, T_, Work


@compiled
def _place(scheme: Scheme, work: Work, row: Any, level: float, end: float) -> float:
    """Place in [0, end] of an element at which an increasing row has a level, or else an end of this interval."""
    if level <= row[0]:
        return 0.0
    if level >= value(scheme, work, row, end):
        return end
    return crossing(scheme, work, row, level, end)


@entry_point
def find_rising(scheme: Scheme, work: Work, rows: Any, share: float, levels: Any, elements: Any, places: Any) -> None:
    """Write the elements, and the places in them, at which a row that increases over E elements has ascending levels.

    `rows` has the shape (E, S + 1). The part `share` of the last element belongs to the row.
    """
    last, element = rows.shape[0] - 1, 0
    for n in range(levels.shape[0]):
        while element < last and rows[element + 1, 0] <= levels[n]:
            element += 1
        elements[n] = element
        places[n] = _place(scheme, work, rows[element], levels[n], share if element == last else 1.0)


@compiled
def _sample(
    scheme: Scheme, work: Work, half: Any, last: int, share: float, end: float, times: Any, forces: Any, n: int
) -> int:
    """Write the forces of a half, from time n on, until its end; return the first time beyond."""
    element = 0
    while n < times.shape[0] and times[n] < end:
        while element < last and half[element + 1, T_, 0] <= times[n]:
            element += 1
        x = _place(scheme, work, half[element, T_], times[n], share if element == last else 1.0)
        forces[n] = max(value(scheme, work, half[element, F_], x), 0.0)
        n += 1
    return n


@entry_point
def sample_forces(scheme: Scheme, work: Work, times: Any, forces: Any) -> None:
    """Write the forces at ascending times; they are 0 before first touch and after separation."""
    n = 0
    while n < times.shape[0] and times[n] <= 0.0:
        forces[n] = 0.0
        n += 1
    last = work.counts[N_APPROACH]
    share = (work.turning_place[0] - work.places[START, last]) / work.places[LENGTH, last]
    n = _sample(scheme, work, work.approach, last, share, work.turning[T_], times, forces, n)
    last = work.counts[N_REBOUND]
    n = _sample(scheme, work, work.rebound, last, 1.0, work.rebound[last, T_, WIDTH], times, forces, n)
    forces[n:] = 0.0
