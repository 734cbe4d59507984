"""One time step of the contact law with adhesion, for numba; `c_header` writes the same statements in C.

The step is the march of the solver along a straight line of the depth (`restitution.kernel.adhesion`). Two arrays of
numbers describe the law and the state of a contact. Lengths, times and forces in them are over those of the law.
"""

import math
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from restitution.kernel.adhesion import step_zone
from restitution.kernel.compile import cached, compiled, entry_point
from restitution.kernel.zone import (
    A_,
    ASTRAY_,
    BEFORE_,
    BENDS_,
    C_,
    D_,
    F_,
    FALLS_,
    G_,
    H_,
    IN1_,
    IN_,
    INSIDE_,
    JUMPED_,
    JUMPS_,
    LAST_,
    LINE_,
    LOW_,
    MADE_,
    N_BRANCH,
    N_COUNTS,
    N_ENDS,
    N_FACTORS,
    N_JUMP,
    N_NODES,
    N_NOW,
    NO_ROOM,
    NOT_DISC,
    P_,
    PLACE_,
    Q_,
    REACHED_,
    SHARE_,
    SOUGHT_,
    SPEED0_,
    SPEED_,
    STEPS_,
    STUCK,
    T_,
    TOO_LONG,
    TOP_,
    TRIED_,
    V_,
    VISCOUS_,
    WAITS_,
    WAY_,
    WEIGHED_,
    Bodies,
    Room,
    Solid,
    count_below,
)

# Constants of the law. Weights and rates of the modes follow, then the undeformed gaps of the elements.
ELEMENTS, MODES, STRESS, REACH, CELL, DEEPEST, LENGTH, TIME, FORCE, CONSTANTS = range(10)

# State of a contact: depth and force at the end of the last step, edge of the attraction, contact radius, energies
# dissipated and lost in jumps; 1 once the attraction has begun; elements that follow, elements that may have memory,
# direction of the edge, steps in a row that sought a fold, length of the last one; why the last call returned NaN.
# Contact load, gap and cohesive load of the elements follow, then the memory of each mode.
(
    DEPTH, LOAD, EDGE, RADIUS, SPENT, RADIATED, BEGUN, FOLLOWING, TOUCHED, WAY, SOUGHT, LAST, FAILED, NUMBERS
) = range(14)  # fmt: skip
ROWS = 3

# Steps of the edge within one step of the law.
MOST_STEPS = 100_000
# Share of a step that is rounding of its end.
ROUNDING = 1e-12

_MEANINGS = (
    "number of elements", "number of modes", "stress of the attraction over the instantaneous modulus",
    "range of the attraction over the length", "distance of elements over the length", "largest depth [m]",
    "length [m]", "time [s]", "force [N]",
)  # fmt: skip


def labels(modes: int, elements: int) -> list[str]:
    """Return the meaning of each constant of a law."""
    of_modes = [f"{name} of mode {k + 1}" for name in ("weight", "rate") for k in range(modes)]
    return [*_MEANINGS, *of_modes, *(f"gap of element {n}" for n in range(elements))]


def state_size(modes: int, elements: int) -> int:
    """Return the length of the state of a contact."""
    return NUMBERS + elements * (ROWS + modes)


@compiled
def unpack(law: NDArray, state: NDArray, room: Room) -> None:
    """Write the elements of a contact into the room of the march."""
    nodes, counts, now, ends = room.nodes, room.counts, room.now, room.ends
    size, modes = nodes.shape[1], room.memory.shape[0]
    plain, place, share = nodes[G_], nodes[PLACE_], nodes[SHARE_]
    press, gap, pull = nodes[P_], nodes[H_], nodes[Q_]
    gaps, loads = law[CONSTANTS + 2 * modes :], state[NUMBERS:]
    cell, reach = law[CELL], law[REACH]
    for i in range(size):
        plain[i] = gaps[i]
        place[i] = i * cell
        share[i] = cell * (1.0 - 1.0 / (3.0 * (4.0 * (1.0 * i * i) - 1.0)))
    share[0] = 2.0 * cell / 3.0
    if state[BEGUN] == 0.0:
        for i in range(size):
            press[i], gap[i], pull[i] = 0.0, gaps[i] + reach, 0.0
    else:
        for i in range(size):
            press[i], gap[i], pull[i] = loads[i], loads[size + i], loads[2 * size + i]
    for k in range(modes):
        memory, kept = room.memory[k], state[NUMBERS + (ROWS + k) * size :]
        for i in range(size):
            memory[i] = kept[i]
    counts[IN_], counts[IN1_], counts[TOP_] = int(state[FOLLOWING]), 0, int(state[TOUCHED])
    counts[WAY_], counts[SOUGHT_], counts[STEPS_] = int(state[WAY]), int(state[SOUGHT]), 0
    counts[JUMPED_], counts[ASTRAY_], counts[LINE_] = 0, 0, 0
    counts[LOW_], counts[REACHED_], counts[WAITS_], counts[BENDS_], counts[WEIGHED_] = 0, 0, 0, 0, size
    counts[INSIDE_] = count_below(place, state[EDGE])
    ends[MADE_], ends[TRIED_], ends[LAST_], ends[BEFORE_] = math.nan, math.nan, state[LAST], 0.0
    ends[SPEED_], ends[SPEED0_], ends[FALLS_] = cell / state[LAST] if state[LAST] > 0.0 else math.inf, 0.0, 0.0
    now[D_], now[F_], now[C_], now[A_] = state[DEPTH], state[LOAD], state[EDGE], state[RADIUS]
    now[VISCOUS_], now[JUMPS_] = state[SPENT], state[RADIATED]


@compiled
def pack(state: NDArray, room: Room) -> None:
    """Write the elements of a march into the state of a contact."""
    nodes, counts, now = room.nodes, room.counts, room.now
    size, modes = nodes.shape[1], room.memory.shape[0]
    press, gap, pull, loads = nodes[P_], nodes[H_], nodes[Q_], state[NUMBERS:]
    for i in range(size):
        loads[i], loads[size + i], loads[2 * size + i] = press[i], gap[i], pull[i]
    for k in range(modes):
        memory, kept = room.memory[k], state[NUMBERS + (ROWS + k) * size :]
        for i in range(size):
            kept[i] = memory[i]
    state[FOLLOWING], state[TOUCHED] = 1.0 * counts[IN_], 1.0 * counts[TOP_]
    state[WAY], state[SOUGHT], state[LAST] = 1.0 * counts[WAY_], 1.0 * counts[SOUGHT_], room.ends[LAST_]
    state[LOAD], state[EDGE], state[RADIUS] = now[F_], now[C_], now[A_]
    state[SPENT], state[RADIATED] = now[VISCOUS_], now[JUMPS_]
    state[BEGUN] = 1.0


@entry_point
def advance(law: NDArray, state: NDArray, depth: float, dt: float, room: Room) -> float:
    """Advance a contact by a time step to a depth; return its force, NaN where the law ends, with the state as it was.

    The force is that at the end of the step, corrected so that the scheme of Verlet has the impulse of the contact.
    """
    now, counts, modes, reach = room.now, room.counts, room.memory.shape[0], law[REACH]
    start, end, begin, span = state[DEPTH], depth / law[LENGTH], 0.0, dt / law[TIME]
    state[FAILED] = 1.0 * NO_ROOM
    if not depth <= law[DEEPEST]:
        return math.nan
    if state[BEGUN] == 0.0:
        if end <= -reach:
            state[DEPTH], state[FAILED] = end, 0.0
            return 0.0
        begin = span * (-reach - start) / (end - start)
        start = -reach
    unpack(law, state, room)
    solid = Solid(1.0, law[CONSTANTS : CONSTANTS + modes], law[CONSTANTS + modes : CONSTANTS + 2 * modes])
    now[T_], now[D_], now[V_] = begin, start, (end - start) / (span - begin)
    before, impulse, status, steps = now[F_], 0.0, -1, 0
    while status < 0 and span - now[T_] > ROUNDING * span:
        time, force = now[T_], now[F_]
        bodies = Bodies(law[STRESS], reach, math.inf, law[CELL], span - time, False, 0.0, 0.0, 0.0)
        status = step_zone(solid, bodies, room)
        impulse += 0.5 * (now[T_] - time) * (force + now[F_])
        steps += 1
        if status < 0 and not math.isfinite(now[F_]):
            status = STUCK
        elif status < 0 and counts[ASTRAY_] > 0:
            status = NOT_DISC
        elif status < 0 and steps > MOST_STEPS:
            status = TOO_LONG
    if status >= 0:
        state[FAILED] = 1.0 * status
        return math.nan
    pack(state, room)
    state[DEPTH], state[FAILED] = end, 0.0
    return law[FORCE] * (now[F_] + impulse / span - 0.5 * (before + now[F_]))


def make_room(size: int, modes: int) -> Room:
    """Return room for the march of one step, which keeps nothing for the next one."""
    return Room(
        np.empty((N_NODES, size)), np.empty((modes, size)), np.empty((modes, N_FACTORS)), np.empty((0, N_BRANCH)),
        np.empty((0, 0)), np.empty(N_NOW), np.empty(N_COUNTS, np.int64), np.empty(N_ENDS), np.empty((0, N_NOW)),
        np.empty((0, N_JUMP)),
    )  # fmt: skip


# Room is allocated for a call, so that threads share none.
_make_room = numba.njit(make_room)


def _step(law: Any, state: Any, depth: float, dt: float) -> float:
    return advance(law, state, depth, dt, _make_room(int(law[ELEMENTS]), int(law[MODES])))


step = cached(numba.njit(nogil=True, error_model="numpy")(_step), _step)


def _step_all(law: Any, states: Any, depths: Any, dt: float, forces: Any) -> None:
    room = _make_room(int(law[ELEMENTS]), int(law[MODES]))
    for n in range(depths.size):
        forces[n] = advance(law, states[n], depths[n], dt, room)


step_all = cached(numba.njit(nogil=True, error_model="numpy")(_step_all), _step_all)
