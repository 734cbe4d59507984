"""Polynomials through the nodes of an element: their values anywhere, the stored approach at eight places, their tails."""

from typing import Any

from restitution.kernel.compile import compiled, inlined
from restitution.kernel.dense import combine, lagrange, lagrange_lanes
from restitution.kernel.lanes import WIDTH, from_lane, read8, total, write8
from restitution.kernel.radau import Scheme
from restitution.kernel.workspace import BASIS, LENGTH, START, Work


@inlined
def product(weights: Any, row: Any) -> float:
    """Product of weights with a row: its value at the start of an element, then those at the nodes."""
    return weights[0] * row[0] + total(read8(weights, 1) * read8(row, 1))


@inlined
def interpolate(scheme: Scheme, work: Work, table: Any, x: float, row: Any) -> None:
    """Write the rows of an element at x into `row`."""
    basis = work.vectors[BASIS]
    lagrange(scheme.c, scheme.weights, WIDTH + 1, x, basis)
    for n in range(row.shape[0]):
        row[n] = product(basis, table[n])


@inlined
def interpolate_lanes(scheme: Scheme, work: Work, tables: Any, sigma: Any, hint: int, rows: Any) -> int:
    """Write the rows of the approach at eight falling sigma into `rows`; return the element of the last.

    `tables` holds the elements of the approach. The search for the element of the first starts at `hint`.
    """
    lane = 0
    place = hint
    while lane < WIDTH:
        place = seek(work.places, place, sigma[lane])
        start, length = work.places[START, place], work.places[LENGTH, place]
        lagrange_lanes(scheme.c, scheme.weights, WIDTH + 1, (sigma - start) / length, work.basis)
        table = tables[place]
        for n in range(rows.shape[0]):
            value = combine(work.basis, WIDTH + 1, table[n])
            if lane > 0:
                value = from_lane(lane, value, read8(rows[n], 0))
            write8(rows[n], 0, value)
        lane += 1
        while lane < WIDTH and (place == 0 or sigma[lane] >= start):
            lane += 1
    return place


@inlined
def seek(places: Any, element: int, sigma: float) -> int:
    """Element of the approach that holds sigma, searched from `element` down."""
    while element > 0 and sigma < places[START, element]:
        element -= 1
    return element


@inlined
def tail(scheme: Scheme, row: Any) -> float:
    """Size of the last two Legendre coefficients of a row over an element, the second to last with weight 0.05."""
    return abs(product(scheme.tail[1], row)) + 0.05 * abs(product(scheme.tail[0], row))


@inlined
def value(scheme: Scheme, work: Work, row: Any, x: float) -> float:
    """Value at x of the interpolant of a row over an element."""
    basis = work.vectors[BASIS]
    lagrange(scheme.c, scheme.weights, WIDTH + 1, x, basis)
    return product(basis, row)


@compiled
def crossing(scheme: Scheme, work: Work, row: Any, level: float, end: float) -> float:
    """Where in [0, end] a row of an element passes a level once (bracketed secant)."""
    low, high = 0.0, end
    f_low, f_high = row[0] - level, value(scheme, work, row, end) - level
    rising = f_high > f_low
    x = 0.5 * end
    for _ in range(100):
        x = low + (high - low) * f_low / (f_low - f_high)
        x = min(max(x, low + 0.01 * (high - low)), high - 0.01 * (high - low))
        f = value(scheme, work, row, x) - level
        if (f > 0.0) != rising:
            low, f_low = x, f
        else:
            high, f_high = x, f
        if abs(f) < 1e-17 or high - low < 1e-15:
            break
    return x
