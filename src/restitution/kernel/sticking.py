"""Oblique impact without slip: smooth equations on the stored normal solution, by collocation with a check.

Where nothing slips, all elements in contact move with the body, and sums over them obey ordinary equations. With the
velocity v of the contact point, and for each mode `Z_k' = v - Z_k/tau_k`, `W_k' = a v - W_k/tau_k` of the approach,
index 1 for the approach at the same contact radius and `X_k = exp(-(t - t_1)/tau_k)`,

    F = sum G_k W_k                                      in the approach,
    F = sum G_k [X_k W_k1 + a (Z_k - X_k Z_k1)]          in the rebound,

and ``v' = -mobility F``. Mode 0 is the equilibrium modulus, which never relaxes; its Z is the way. Over all elements
the squares of the loads are Q_k, with `Q_k' = 2 v W_k - 2 Q_k/tau_k`, in the approach and

    X_k^2 Q_k1 + 2 X_k W_k1 (Z_k - X_k Z_k1) + a (Z_k - X_k Z_k1)^2

in the rebound. An element that leaves drops its load; what it stores is lost to the body.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from restitution.kernel.collocation import combine, interpolate_lanes, invert, lagrange_lanes, matvec
from restitution.kernel.compile import compiled, entry_point, inlined
from restitution.kernel.element import factor_modes
from restitution.kernel.lanes import WIDTH, at_least, broadcast, exp, read8, write8
from restitution.kernel.path import radii_and_integrals, radius_and_integral
from restitution.kernel.references import by_reference
from restitution.kernel.sliding import Halves, Modes
from restitution.kernel.workspace import LENGTH, S_, START, T_

# Most parts of an element of the normal solution. Where a(s) is no polynomial, the first one of the approach and the
# last one of the rebound have further parts, which grow from this share.
_MOST_PARTS, _FURTHER, _LEAST_SHARE = 16, 6, 0.25**6
# Members of `matrices`: sum of the modes, inverses of the equations of the velocity and of the matrix of the scheme.
_SUM, _JACOBIAN, _SLOPES, _N_MATRICES = range(4)
# Rows of a part of the approach: time, then Z, W and Q of each mode.
_TIME, _Z, _W, _Q, _N_SUMS = 0, 1, 2, 3, 3
# Rows of `motion`: time, velocity of the contact point, force, radius.
N_MOTION = 4
# Least argument of the exponential of eight numbers.
_SMALLEST = -700.0


@by_reference
class Room(NamedTuple):
    """Matrices of an element, and both halves."""

    matrices: Any  # (3, S, S)
    inverses: Any  # (modes, S, S)
    basis: Any  # (S + 1, S)
    scratch: Any  # (2, S)
    places: Any  # (2, P): start and length of the parts of the approach in sigma
    tables: Any  # (P, 1 + 3 modes, S + 1)
    past: Any  # (1 + 3 modes, S): the approach at the nodes of a part of the rebound
    ways: Any  # (modes,): Z at the start of a part of the rebound
    motion: Any  # (N_MOTION, 1 + S parts)


def allocate_room(modes: int, approach: int, rebound: int) -> Room:
    """Return room for marches on a normal solution with elements in both halves."""
    most, rows = _MOST_PARTS * approach + _FURTHER, 1 + _N_SUMS * modes
    both = most + _MOST_PARTS * rebound + _FURTHER
    return Room(
        np.empty((_N_MATRICES, WIDTH, WIDTH)), np.empty((modes, WIDTH, WIDTH)), np.empty((WIDTH + 1, WIDTH)),
        np.empty((2, WIDTH)), np.empty((2, most)), np.empty((most, rows, WIDTH + 1)), np.empty((rows, WIDTH)),
        np.empty(modes), np.empty((N_MOTION, 1 + WIDTH * both)),
    )  # fmt: skip


@inlined
def _end_of_part(low: float, parts: int, grows: bool, shrinks: bool) -> float:
    """Return the share of an element at which the part from `low` ends; parts may grow from it, or shrink towards it.

    Equal parts are cut at powers of a quarter from one end, too. All shares are exact.
    """
    end, cut = (math.floor(low * parts) + 1.0) / parts, 1.0
    if grows:
        cut = _LEAST_SHARE
        while cut <= low:
            cut *= 4.0
    if shrinks:
        while cut >= 1.0 - low:
            cut *= 0.25
        cut = 1.0 - cut if cut >= _LEAST_SHARE else 1.0
    return min(end, cut)


@inlined
def _factor(
    modes: Modes, halves: Halves, mobility: float, h: float, pace: Any, weights: tuple[Any, Any], room: Room
) -> None:
    """Write the inverses of the modes, and that of the equations of the velocity.

    Rates are weighed with the first of the weights, forces with the second.
    """
    A, matrices, (inner, outer) = halves.columns, room.matrices, weights
    factor_modes(modes, halves, room, pace, h)
    for j in range(WIDTH):
        column = broadcast(0.0)
        for k in range(modes.moduli.shape[0]):
            column = column + modes.moduli[k] * read8(room.inverses, k, j, 0)
        write8(matrices, _SUM, j, 0, column)
    gain, drag = h * (pace * inner), modes.viscosity * (inner * outer)
    for j in range(WIDTH):
        unit = read8(halves.identity, j, 0)
        push = outer * (gain[j] * matvec(matrices[_SUM], read8(A, j, 0))) + drag[j] * unit
        write8(matrices, _JACOBIAN, j, 0, unit + (mobility * h) * matvec(A, pace * push))
    invert(matrices, _JACOBIAN)


@inlined
def _write(moves: Any, point: int, motion: Any) -> None:
    """Write time, velocity, force and radius at the nodes of a part."""
    for m in range(N_MOTION):
        write8(motion, m, point, moves[m])


@inlined
def _approach_part(
    halves: Halves, modes: Modes, mobility: float, h: float, normal: Any, first: float, table: Any, room: Room
) -> Any:
    """Fill a table from its first column; return the motion, and the energy dissipated.

    `normal` are s, the time, and the radius at the nodes, `first` is the velocity at the start.
    """
    A, count, unit, (s, t, a) = halves.columns, modes.moduli.shape[0], broadcast(1.0), normal
    pace = 2.0 * s
    _factor(modes, halves, mobility, h, pace, (a, unit), room)
    rest = broadcast(0.0)
    for k in range(count):
        start = broadcast(table[_W + _N_SUMS * k, 0])
        rest = rest + modes.moduli[k] * matvec(room.inverses[k], start)
    v = matvec(room.matrices[_JACOBIAN], first - (mobility * h) * matvec(A, pace * rest))
    way, push = h * matvec(A, pace * v), h * matvec(A, pace * (a * v))
    F = modes.viscosity * (a * v)
    power = F * v
    for k in range(count):
        row = _N_SUMS * k
        W = matvec(room.inverses[k], table[_W + row, 0] + push)
        write8(table, _Z + row, 1, matvec(room.inverses[k], table[_Z + row, 0] + way))
        write8(table, _W + row, 1, W)
        F = F + modes.moduli[k] * W
    # Squares relax twice as fast.
    factor_modes(modes, halves, room, pace, 2.0 * h)
    for k in range(count):
        row = _N_SUMS * k
        source = h * matvec(A, pace * (2.0 * (v * read8(table, _W + row, 1))))
        Q = matvec(room.inverses[k], table[_Q + row, 0] + source)
        write8(table, _Q + row, 1, Q)
        power = power + (modes.moduli[k] / modes.times[k]) * Q
    return (t, v, F, a), h * matvec(A, pace * power)[WIDTH - 1]


@inlined
def _rebound_part(
    halves: Halves, modes: Modes, mobility: float, h: float, normal: Any, first: float, room: Room
) -> Any:
    """Advance `ways`; return the motion, the squares of the loads at the edge, and the energy dissipated.

    `normal` are the time, its slope, and the radius at the nodes, `first` is the velocity at the start.
    """
    A, past, count, unit, (t, pace, a) = halves.columns, room.past, modes.moduli.shape[0], broadcast(1.0), normal
    delay = at_least(t - read8(past, _TIME, 0), 0.0)
    _factor(modes, halves, mobility, h, pace, (unit, a), room)
    rest = broadcast(0.0)
    for k in range(count):
        row = _N_SUMS * k
        X = exp(at_least((-1.0 / modes.times[k]) * delay, _SMALLEST))
        left, pushed = X * read8(past, _Z + row, 0), X * read8(past, _W + row, 0)
        write8(past, _Z + row, 0, left)
        write8(past, _W + row, 0, pushed)
        write8(past, _Q + row, 0, X * X * read8(past, _Q + row, 0))
        way = matvec(room.inverses[k], broadcast(room.ways[k]))
        rest = rest + modes.moduli[k] * (pushed + a * (way - left))
    v = matvec(room.matrices[_JACOBIAN], first - (mobility * h) * matvec(A, pace * rest))
    way, F, edge = h * matvec(A, pace * v), modes.viscosity * (a * v), broadcast(0.0)
    power = F * v
    for k in range(count):
        row = _N_SUMS * k
        Z, pushed = matvec(room.inverses[k], room.ways[k] + way), read8(past, _W + row, 0)
        room.ways[k] = Z[WIDTH - 1]
        left = Z - read8(past, _Z + row, 0)
        F = F + modes.moduli[k] * (pushed + a * left)
        edge = edge + modes.moduli[k] * (left * left)
        squares = read8(past, _Q + row, 0) + left * (2.0 * pushed + a * left)
        power = power + (modes.moduli[k] / modes.times[k]) * squares
    return (t, v, F, a), edge, h * matvec(A, pace * power)[WIDTH - 1]


@inlined
def _normal(halves: Halves, element: int, x: Any, room: Room) -> Any:
    """Return s, the time and the contact radius of the normal solution at eight places of an element."""
    lagrange_lanes(halves.c, halves.weights, WIDTH + 1, x, room.basis)
    s = at_least(combine(room.basis, WIDTH + 1, halves.rows[element, S_]), 0.0)
    t = combine(room.basis, WIDTH + 1, halves.rows[element, T_])
    return s, t, radii_and_integrals(halves.path, s, room.scratch)[0]


@compiled
def _approach(
    halves: Halves, modes: Modes, mobility: float, parts: int, graded: bool, room: Room
) -> tuple[int, float, float]:
    """Solve the approach; return the number of its parts, the velocity at its end and the energy dissipated."""
    places, tables, motion = room.places, room.tables, room.motion
    n, velocity, spent = 0, 1.0, 0.0
    motion[0, 0], motion[1, 0], motion[2, 0] = 0.0, velocity, 0.0
    motion[3, 0] = radius_and_integral(halves.path, 0.0)[0]
    for element in range(halves.turn):
        start, length, low = halves.starts[element], halves.lengths[element], 0.0
        # The last element extends past the turning point.
        share = (halves.length - start) / length if element == halves.turn - 1 else 1.0
        while low < 1.0:
            high = _end_of_part(low, parts, graded and element == 0, False)
            begin, size, table = low * share, (high - low) * share, tables[n]
            normal = _normal(halves, element, begin + size * read8(halves.c, 1), room)
            for m in range(table.shape[0]):
                table[m, 0] = tables[n - 1, m, WIDTH] if n > 0 else 0.0
            write8(table, _TIME, 1, normal[1])
            places[START, n], places[LENGTH, n] = start + length * begin, length * size
            moves, lost = _approach_part(halves, modes, mobility, length * size, normal, velocity, table, room)
            _write(moves, 1 + WIDTH * n, motion)
            n, low, velocity, spent = n + 1, high, moves[1][WIDTH - 1], spent + lost
    return n, velocity, spent


@compiled
def _rebound(
    halves: Halves, modes: Modes, mobility: float, parts: int, graded: bool, first: int, velocity: float, room: Room
) -> tuple[int, float, float, float]:
    """Solve the rebound after the parts of the approach; return the number of all parts, the velocity and energies.

    The energies are those dissipated, and stored in elements when they leave.
    """
    A, last, hint, n = halves.columns, halves.starts.shape[0] - 1, first - 1, first
    spent, stored, edge_before, time = 0.0, 0.0, 0.0, halves.rows[halves.turn, T_, 0]
    for k in range(modes.moduli.shape[0]):
        room.ways[k] = room.tables[first - 1, _Z + _N_SUMS * k, WIDTH]
    for element in range(halves.turn, last + 1):
        start, length, low = halves.starts[element], halves.lengths[element], 0.0
        while low < 1.0:
            high = _end_of_part(low, parts, False, graded and element == last)
            x, h = low + (high - low) * read8(halves.c, 1), length * (high - low)
            _, t, a = _normal(halves, element, x, room)
            pace = (1.0 / h) * matvec(room.matrices[_SLOPES], t - time)
            sigma = at_least(halves.length - (start + length * x), 0.0)
            hint = interpolate_lanes(halves, room, room.tables, sigma, hint, room.past)
            moves, edge, lost = _rebound_part(halves, modes, mobility, h, (t, pace, a), velocity, room)
            # Elements store - int density da = int a d(density) at separation.
            stored += 0.5 * matvec(A, a * matvec(room.matrices[_SLOPES], edge - edge_before))[WIDTH - 1]
            _write(moves, 1 + WIDTH * n, room.motion)
            n, low, velocity, spent = n + 1, high, moves[1][WIDTH - 1], spent + lost
            edge_before, time = edge[WIDTH - 1], t[WIDTH - 1]
    return n, velocity, spent, stored


@entry_point
def march(
    halves: Halves, modes: Modes, mobility: float, rtol: float, room: Room
) -> tuple[float, float, float, float, int]:
    """Follow the contact point, which has the velocity 1 at first touch, without slip.

    The elements of the normal solution are halved until the velocity at separation changes by less than `rtol`. The
    first mode never relaxes: its time is infinite. Returns the velocity at separation, its last change, the energies
    dissipated and stored in units of m v^2, and the number of points in `motion`.
    """
    for j in range(WIDTH):
        write8(room.matrices, _SLOPES, j, 0, read8(halves.columns, j, 0))
    invert(room.matrices, _SLOPES)
    exponent = halves.path.exponent
    graded, parts, before = exponent < 0.0 or exponent != math.floor(exponent), 1, math.inf
    while True:
        first, turning, lost = _approach(halves, modes, mobility, parts, graded, room)
        count, end, spent, stored = _rebound(halves, modes, mobility, parts, graded, first, turning, room)
        error, before = abs(end - before), end
        if not error > rtol or parts == _MOST_PARTS:
            return end, error, lost + spent, stored, 1 + WIDTH * count
        parts *= 2
