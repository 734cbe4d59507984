"""Tangential half of a time step of the contact law, for numba; `c_header` writes the same statements in C.

The foundation is cut into tiles of radii, one for each node of the normal half. A tile is an element of the stick-slip
foundation: it follows the body as long as its load is below friction times the normal force on it, and slips at that
limit. Loads and displacements have two components, along two axes that the caller carries with the contact.
"""

import math

from numpy.typing import NDArray

from restitution.kernel.compile import compiled, entry_point
from restitution.law.step import (
    BEND,
    BEYOND,
    BRANCH,
    BRANCHES,
    CONTACT,
    COUNT,
    DEPTH,
    EDGE,
    ELAPSED,
    EQUILIBRIUM,
    INTEGRAL,
    NODES,
    NUMBERS,
    PLACE,
    RADIUS,
    RATE,
    ROWS,
    STIFFNESS,
    TRIAL,
    radius_at,
    set_branches,
)

# Constants of friction, `grip`: coefficient, number of modes and spring of the tangential line load; then the moduli
# and the times of the modes, as those of the branches of the law.
FRICTION, MODES, SPRING, GRIPS = range(4)

# The state of a contact goes on behind the nodes of the normal half: tiles; length of the last step, 0 before the
# first one; length of step to which the numbers of the modes belong; line load for a displacement of 1 in this step;
# weight of a change of the velocity in it; ways of the body along both axes in it.
TILES, PACED, TIMED, SLOPE, TURN, WAYS = range(6)
HEAD = WAYS + 2

# Three numbers for each mode: decay, gain and bend, which depend on the length of the step alone.
FADE, LIFT, CURL, MODE = range(4)

# Rows of the tiles: radii in contact; largest force over friction; then, along each axis, displacement, its rate in
# the last step and load. The loads of the modes follow, those along the first axis before those of the second.
SPAN, LIMIT, WAY, PACE, LOAD = 0, 1, 2, 4, 6
LINES = 8

# Size below which a load is none, because processors are slow on numbers below 1e-308.
NONE = 1e-200


def grip_labels(modes: int) -> list[str]:
    """Return the meaning of each constant of friction."""
    of_modes = (
        "modulus of mode {} [Pa]; of a dashpot its viscosity [Pa s]",
        "time of mode {} [s]; of a dashpot 0",
    )
    head = ["friction coefficient", "number of modes", "equilibrium modulus of the tangential line load [Pa]"]
    return head + [text.format(k + 1) for text in of_modes for k in range(modes)]


def tiles_size(modes: int, nodes: int) -> int:
    """Return the numbers that friction adds to the state of a contact."""
    return HEAD + MODE * modes + nodes * (LINES + 2 * modes)


@compiled
def set_step(grip: NDArray, tiles: NDArray, elapsed: float, dt: float) -> None:
    """Store what the modes and all tiles share in a step; the contact exists for the time `elapsed` of it."""
    modes = int(grip[MODES])
    numbers, curl = tiles[HEAD:], tiles[HEAD + CURL * modes :]
    if elapsed != tiles[TIMED]:
        set_branches(grip[GRIPS:], grip[GRIPS + modes :], numbers, modes, elapsed, 0.0)
        tiles[TIMED] = elapsed
    tiles[TURN] = 0.0
    if tiles[PACED] > 0.0:
        tiles[TURN] = 2.0 * elapsed / (dt + tiles[PACED])
    slope = grip[SPRING]
    for k in range(modes):
        slope += tiles[HEAD + LIFT * modes + k] + tiles[TURN] * curl[k]
    tiles[SLOPE] = slope


@compiled
def merge_tiles(grip: NDArray, tiles: NDArray, nodes: NDArray, room: int, kept: int) -> None:
    """Share the states of all tiles among fewer ones, for the nodes that were kept, by the radii that they have."""
    modes = int(grip[MODES])
    rows = tiles[HEAD + MODE * modes :]
    place, integral, span = nodes[PLACE * room :], nodes[INTEGRAL * room :], rows[SPAN * room :]
    old = int(tiles[TILES])
    # Radii between which tile n, of the old ones, and tile m, of the others, lie. A state is read before it is
    # written, because m <= n.
    n = 0
    low = 0.0
    high = span[0]
    lower = 0.0
    for m in range(kept):
        upper = (integral[m + 1] - integral[m]) / (place[m + 1] - place[m])
        if m == kept - 1:
            upper = math.inf
        if n < m:
            # By rounding the last of the old tiles may end beyond the one that has taken it.
            n = m
            low = high
            high += span[n]
        width = max(min(high, upper) - max(low, lower), 0.0)
        for row in range(WAY, LINES + 2 * modes):
            rows[row * room + m] = width * rows[row * room + n]
        while n < old - 1 and high <= upper:
            n += 1
            low = high
            high += span[n]
            part = max(min(high, upper) - max(low, lower), 0.0)
            for row in range(WAY, LINES + 2 * modes):
                rows[row * room + m] += part * rows[row * room + n]
            width += part
        for row in range(WAY, LINES + 2 * modes):
            rows[row * room + m] /= max(width, NONE)
        span[m] = width
        lower = upper


@compiled
def add_tiles(grip: NDArray, tiles: NDArray, room: int, kept: int, count: int, pace: NDArray) -> None:
    """Write tiles without load for the nodes from `kept` on; `pace` is the velocity of the body."""
    modes = int(grip[MODES])
    rows = tiles[HEAD + MODE * modes :]
    for n in range(kept, count):
        for row in range(LINES + 2 * modes):
            rows[row * room + n] = 0.0
        for axis in range(2):
            rows[(PACE + axis) * room + n] = pace[axis]
    tiles[TILES] = count


@compiled
def load_at(law: NDArray, state: NDArray, depth: float, n: int) -> float:
    """Return the normal line load of a node in contact."""
    branches, room = int(law[BRANCHES]), int(law[NODES])
    nodes = state[NUMBERS + BRANCH * branches :]
    total = law[EQUILIBRIUM] * (depth - nodes[PLACE * room + n])
    for k in range(branches):
        total += nodes[(ROWS + k) * room + n]
    return max(total, 0.0)


@compiled
def edge_of(law: NDArray, state: NDArray, count: int, contact: int) -> float:
    """Return the contact radius."""
    if contact == 0:
        return 0.0
    if contact == count:
        return state[RADIUS]
    branches, room = int(law[BRANCHES]), int(law[NODES])
    nodes, beyond = state[NUMBERS + BRANCH * branches :], state[NUMBERS + BEYOND * branches :]
    place, trial = nodes[PLACE * room :], nodes[TRIAL * room :]
    n = contact - 1
    share = 1.0
    if state[EDGE] > 0.0:
        # Between the loads of both nodes as if both still followed the body.
        inner = load_at(law, state, state[DEPTH], n)
        outer = law[EQUILIBRIUM] * (state[DEPTH] - place[n + 1])
        for k in range(branches):
            outer += beyond[k]
        share = inner / max(inner - min(outer, 0.0), NONE)
    elif state[EDGE] < 0.0:
        share = min(max(1.0 - trial[n + 1] / state[STIFFNESS] / state[EDGE], 0.0), 1.0)
    return radius_at(law, place[n] + share * (place[n + 1] - place[n]))


@compiled
def set_limits(law: NDArray, grip: NDArray, state: NDArray, tiles: NDArray, half: float) -> None:
    """Write the radii of the tiles in contact and the normal forces on them, which are the limits over friction.

    Radii that grow begin without load. The sum of the forces is `half`.
    """
    branches, room = int(law[BRANCHES]), int(law[NODES])
    count, contact, modes = int(state[COUNT]), int(state[CONTACT]), int(grip[MODES])
    nodes, rows = state[NUMBERS + BRANCH * branches :], tiles[HEAD + MODE * modes :]
    place, integral = nodes[PLACE * room :], nodes[INTEGRAL * room :]
    span, limit = rows[SPAN * room :], rows[LIMIT * room :]
    edge = edge_of(law, state, count, contact)
    lower = 0.0
    total = 0.0
    outside = 0.0
    for n in range(count):
        upper = edge
        if n < count - 1:
            upper = (integral[n + 1] - integral[n]) / (place[n + 1] - place[n])
        width = max(min(upper, edge) - lower, 0.0)
        force = outside
        outside = 0.0
        if n < contact:
            load = load_at(law, state, state[DEPTH], n)
            force = load * width
            if n == contact - 1 and contact < count:
                # The load falls along a line from the node to the edge, which may be within the next tile.
                inner = radius_at(law, place[n])
                last = max(edge - inner, 0.0)
                past = max(edge - upper, 0.0)
                if past > 0.0 and last > 0.0:
                    outside = 0.5 * load * past * past / last
                force = load * (max(inner - lower, 0.0) + 0.5 * last) - outside
        if span[n] > 0.0 and width > span[n]:
            for row in range(WAY, LINES + 2 * modes):
                if row < PACE or row >= LOAD:
                    rows[row * room + n] *= span[n] / width
        span[n] = width
        limit[n] = force
        total += force
        lower = upper
    for n in range(count):
        limit[n] *= half / max(total, NONE)


@compiled
def move_tile(grip: NDArray, tiles: NDArray, room: int, n: int, way: NDArray) -> float:
    """Move a tile with the body or let it slip at its limit; return its load over the limit, at most 1."""
    modes = int(grip[MODES])
    fade, lift, curl = tiles[HEAD + FADE * modes :], tiles[HEAD + LIFT * modes :], tiles[HEAD + CURL * modes :]
    rows = tiles[HEAD + MODE * modes :]
    elapsed, slope, turn = tiles[TIMED], tiles[SLOPE], tiles[TURN]
    size = 0.0
    for axis in range(2):
        load = grip[SPRING] * rows[(WAY + axis) * room + n] + slope * way[axis]
        for k in range(modes):
            load += fade[k] * rows[(LINES + axis * modes + k) * room + n]
            load -= turn * curl[k] * rows[(PACE + axis) * room + n] * elapsed
        rows[(LOAD + axis) * room + n] = load
        size = math.hypot(size, load)
    bound = 0.0
    if rows[SPAN * room + n] > 0.0:
        bound = grip[FRICTION] * rows[LIMIT * room + n] / rows[SPAN * room + n]
    share = 1.0
    if size > bound:
        share = bound / size
    for axis in range(2):
        load = rows[(LOAD + axis) * room + n]
        moved = way[axis] - (1.0 - share) * load / slope
        change = turn * (moved - rows[(PACE + axis) * room + n] * elapsed)
        for k in range(modes):
            here = (LINES + axis * modes + k) * room + n
            after = fade[k] * rows[here] + lift[k] * moved + curl[k] * change
            if abs(after) < NONE:
                after = 0.0
            rows[here] = after
        rows[(LOAD + axis) * room + n] = share * load
        rows[(WAY + axis) * room + n] += moved
        rows[(PACE + axis) * room + n] = moved / elapsed
    return share


@compiled
def rim_of(law: NDArray, state: NDArray, growth: float) -> float:
    """Return the normal force of the newest radii, of the width `growth`, beyond loads along a line.

    Each of them was touched at its own instant within the step.
    """
    branches = int(law[BRANCHES])
    bend = state[NUMBERS + BEND * branches :]
    total = 0.0
    for k in range(branches):
        total += bend[k]
    return max(total * growth * state[RATE] * state[ELAPSED], 0.0)


@compiled
def pull_rim(
    grip: NDArray, tiles: NDArray, room: int, growth: float, bound: float, share: float, pull: NDArray
) -> None:
    """Add the force of the newest radii beyond loads along a line; `bound` is its limit.

    `share` is below 1 where the tile beside them slips, the last one that has moved.
    """
    modes = int(grip[MODES])
    rows = tiles[HEAD + MODE * modes :]
    n = int(tiles[TILES]) - 2
    stiffness = 0.0
    for k in range(modes):
        stiffness += tiles[HEAD + CURL * modes + k]
    stiffness *= growth * tiles[TIMED]
    pace = math.hypot(rows[PACE * room + n], rows[(PACE + 1) * room + n])
    load = math.hypot(rows[LOAD * room + n], rows[(LOAD + 1) * room + n])
    for axis in range(2):
        if share < 1.0:
            pull[axis] += bound * rows[(LOAD + axis) * room + n] / max(load, NONE)
        elif pace > 0.0:
            pull[axis] += min(stiffness * pace, bound) / pace * rows[(PACE + axis) * room + n]


@entry_point
def slide(law: NDArray, grip: NDArray, state: NDArray, force: float, way: NDArray, dt: float, pull: NDArray) -> None:
    """Advance the tangential half of a contact by the step that has led to a normal force; write the pull.

    `way` and `pull` have two numbers, along both axes: displacement of the contact points past each other in the
    step, and force that resists it.
    """
    pull[0] = 0.0
    pull[1] = 0.0
    if math.isnan(force):
        pull[0] = force
        pull[1] = force
        return
    branches, room = int(law[BRANCHES]), int(law[NODES])
    count, modes = int(state[COUNT]), int(grip[MODES])
    nodes = state[NUMBERS + BRANCH * branches :]
    tiles = nodes[(ROWS + 2 * branches) * room :]
    rows, way_of = tiles[HEAD + MODE * modes :], tiles[WAYS:]
    if count == 0:
        tiles[TILES] = 0.0
        tiles[PACED] = 0.0
        return
    set_step(grip, tiles, state[ELAPSED], dt)
    pull[0] = way[0] / dt
    pull[1] = way[1] / dt
    for axis in range(2):
        way_of[axis] = pull[axis] * state[ELAPSED]
    kept = int(tiles[TILES])
    if kept > count:
        # Nodes were dropped before the last one was set.
        kept = count - 1
        merge_tiles(grip, tiles, nodes, room, kept)
    add_tiles(grip, tiles, room, kept, count, pull)
    growth = 0.0
    rest = 0.0
    if max(kept, 1) < count:
        growth = state[RADIUS] - radius_at(law, nodes[PLACE * room + count - 2])
        rest = min(rim_of(law, state, growth), 0.5 * force)
    set_limits(law, grip, state, tiles, 0.5 * force - rest)
    pull[0] = 0.0
    pull[1] = 0.0
    # A tile whose node was set in this step is touched at its end.
    share = 1.0
    for n in range(max(kept, 1)):
        share = move_tile(grip, tiles, room, n, way_of)
        for axis in range(2):
            pull[axis] += rows[SPAN * room + n] * rows[(LOAD + axis) * room + n]
    if growth > 0.0:
        pull_rim(grip, tiles, room, growth, grip[FRICTION] * rest, share, pull)
    for axis in range(2):
        pull[axis] *= 2.0
    tiles[PACED] = dt


@entry_point
def slide_all(
    law: NDArray, grip: NDArray, states: NDArray, forces: NDArray, ways: NDArray, dt: float, pulls: NDArray
) -> None:
    """Advance the tangential halves of many contacts, and write their pulls."""
    for n in range(forces.size):
        slide(law, grip, states[n], forces[n], ways[n], dt, pulls[n])
