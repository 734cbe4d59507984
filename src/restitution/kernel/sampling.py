"""Values of the stored halves of an impact at given times."""

from typing import Any

from restitution.kernel.compile import compiled, entry_point, inlined
from restitution.kernel.dense import lagrange, product, value
from restitution.kernel.lanes import WIDTH
from restitution.kernel.radau import Scheme
from restitution.kernel.workspace import BASIS, F_, LENGTH, N_APPROACH, N_REBOUND, START, T_, VALUES, Work

# Newton steps at most, and the last one at which the place counts as found.
_ROUNDS, _STEP = 80, 1e-15


@inlined
def _differentiate(scheme: Scheme, work: Work, row: Any) -> None:
    """Leave the slopes of a row at the nodes in `vectors[VALUES]`."""
    for i in range(WIDTH + 1):
        work.vectors[VALUES, i] = product(scheme.derivative[i], row)


@compiled
def _place(scheme: Scheme, work: Work, row: Any, level: float, end: float) -> float:
    """Place in [0, end] of an element at which an increasing row has a level, or else an end; by Newton."""
    basis, slopes = work.vectors[BASIS], work.vectors[VALUES]
    low, high = 0.0, end
    if level <= row[0]:
        return low
    # The start is the same whatever the other levels are, and so are the bits of the place.
    x = 0.5 * end
    if end == 1.0:  # a row may fall beyond a smaller end
        if level >= row[WIDTH]:
            return end
        x = (level - row[0]) / (row[WIDTH] - row[0])
    for _ in range(_ROUNDS):
        lagrange(scheme.c, scheme.weights, WIDTH + 1, x, basis)
        excess = product(basis, row) - level
        if excess > 0.0:
            high = x
        else:
            low = x
        slope = product(basis, slopes)
        step = excess / slope if slope > 0.0 else 2.0
        if abs(step) < _STEP or high - low < _STEP:
            break
        x -= step
        if not low <= x <= high:
            x = 0.5 * (low + high)
    return min(x, end)


@entry_point
def find_rising(scheme: Scheme, work: Work, rows: Any, share: float, levels: Any, elements: Any, places: Any) -> None:
    """Write the elements, and the places in them, at which a row that increases over E elements has ascending levels.

    `rows` has the shape (E, S + 1). The part `share` of the last element belongs to the row.
    """
    last, element = rows.shape[0] - 1, 0
    _differentiate(scheme, work, rows[0])
    for n in range(levels.shape[0]):
        while element < last and rows[element + 1, 0] <= levels[n]:
            element += 1
            _differentiate(scheme, work, rows[element])
        x = _place(scheme, work, rows[element], levels[n], share if element == last else 1.0)
        elements[n], places[n] = element, x


@compiled
def _sample(
    scheme: Scheme, work: Work, half: Any, last: int, share: float, end: float, times: Any, forces: Any, n: int
) -> int:
    """Write the forces of a half, from time n on, until its end; return the first time beyond."""
    element = 0
    _differentiate(scheme, work, half[0, T_])
    while n < times.shape[0] and times[n] < end:
        while element < last and half[element + 1, T_, 0] <= times[n]:
            element += 1
            _differentiate(scheme, work, half[element, T_])
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
