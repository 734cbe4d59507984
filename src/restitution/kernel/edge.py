"""Equation of the edge of a Dugdale zone: the gap there after a step, as it depends on the step and the edge.

See `restitution.kernel.adhesion` for the equations.
"""

import math

from restitution.kernel.compile import compiled
from restitution.kernel.waiting import wake
from restitution.kernel.zone import (
    BASE_,
    BENDS_,
    CUT_,
    D_,
    DEPTH_NOW_,
    F_,
    IN1_,
    IN_,
    INSIDE_,
    LOW_,
    MADE_,
    NEAR_,
    NEXT_,
    P1_,
    PLACE_,
    Q1_,
    REST_,
    S_RISE_,
    TOP_,
    TRIED_,
    V_,
    WEIGHED_,
    Bodies,
    Room,
    Solid,
    cell_weights,
    cohesive_load,
    contact_radius,
    dot,
    normal_force,
    set_factors,
    tail,
    weigh,
    write_bases,
    write_element,
    write_pulls,
    write_tail,
)

_MOST_DEPTHS = 200
# Cells between the contact and the tail, so that it stays while the contact grows a little.
_SPARE = 1
# Elements inside the contact that no longer wait where its front comes near: a small one may vanish in a step.
_AHEAD = 4
# Cells of the ring below which each is asked anew for each length of a step.
_SHORT = 16


@compiled
def _sprung(solid: Solid, bodies: Bodies, dt: float, edge: float, room: Room) -> float:
    """Return the depth at which the spring bears the force; NaN under a force that no depth bears.

    The elements of the contact are written. The force rises with the depth, and its slope does.
    """
    counts, nodes, ends = room.counts, room.nodes, room.ends
    size = nodes.shape[1]
    load, stiffness = bodies.load + dt * bodies.pace, bodies.stiffness
    done = min(max(counts[INSIDE_], counts[IN_]) + 2, size)
    wake(solid, bodies, 0, done + 1, room)
    write_bases(solid, dt, 0, done, room)
    touch = nodes[BASE_, 0] + solid.compliance * nodes[Q1_, 0]
    spare = load + math.pi * bodies.stress * edge * edge
    if stiffness * touch >= spare:
        counts[IN1_] = 0
        depth = spare / stiffness if stiffness > 0.0 else math.nan
        write_element(solid, bodies, dt, depth, 0, room)
        return depth
    depth = max(room.now[D_], touch)
    if depth == touch:
        depth += bodies.cell * bodies.cell
    last = math.inf
    for _ in range(_MOST_DEPTHS):
        count = 0
        while count < size - 2:
            if count >= done:
                wake(solid, bodies, 0, count + 2, room)
                write_bases(solid, dt, count, count + 1, room)
                done = count + 1
            write_element(solid, bodies, dt, depth, count, room)
            if not nodes[P1_, count] > 0.0:
                break
            count += 1
        counts[IN1_] = count
        radius = contact_radius(solid, bodies, edge, room)
        wide = max(radius, 0.5 * bodies.cell)
        excess = normal_force(bodies, edge, radius, depth, room) + stiffness * depth - load
        step = excess / (2.0 * wide / (solid.compliance + ends[S_RISE_]) + stiffness)
        small = 1e-15 * (bodies.reach + abs(depth))
        if abs(step) <= small or (abs(step) <= 1e3 * small and abs(step) >= last):
            break
        last = abs(step)
        after = max(depth - step, touch)
        depth = 0.5 * (depth + touch) if after == touch else after
    return depth


@compiled
def _front(solid: Solid, bodies: Bodies, dt: float, edge: float, depth: float, room: Room) -> int:
    """Return how many elements follow at a depth; those beside the contact are written."""
    nodes, count = room.nodes, room.counts[IN_]
    size = nodes.shape[1]
    low, high = max(count - 1, 0), count + 1
    wake(solid, bodies, max(low - _AHEAD, 0), min(max(room.counts[INSIDE_], count) + 2, size) + 1, room)
    write_bases(solid, dt, low, high, room)
    write_element(solid, bodies, dt, depth, count, room)
    if nodes[P1_, count] > 0.0:
        while nodes[P1_, count] > 0.0 and count < size - 2:
            count += 1
            if count >= high:
                wake(solid, bodies, low, count + 2, room)
                write_bases(solid, dt, count, count + 1, room)
            write_element(solid, bodies, dt, depth, count, room)
        return count
    while count > 0:
        if count - 1 < low:
            low = count - 1
            wake(solid, bodies, max(low - _AHEAD, 0), 0, room)
            write_bases(solid, dt, low, low + 1, room)
        write_element(solid, bodies, dt, depth, count - 1, room)
        if nodes[P1_, count - 1] > 0.0:
            break
        count -= 1
    return count


@compiled
def excess(solid: Solid, bodies: Bodies, dt: float, edge: float, room: Room) -> float:
    """Return G after a step with the zone up to `edge`; the elements from the contact to the edge are written."""
    now, counts, nodes, ends = room.now, room.counts, room.nodes, room.ends
    size, target = nodes.shape[1], 0.5 * math.pi * bodies.reach
    if ends[MADE_] != edge:
        write_pulls(bodies, edge, counts[LOW_], counts[TOP_], room)
        counts[WEIGHED_], counts[CUT_], ends[MADE_] = size, size, edge
    set_factors(solid, dt, room)
    ends[TRIED_] = dt
    if bodies.sprung:
        depth = _sprung(solid, bodies, dt, edge, room)
        count = counts[IN1_]
        if math.isnan(depth):
            # A pull beyond that of the zone takes the body away.
            return target if bodies.load + dt * bodies.pace < 0.0 or edge > 0.0 else -target
    else:
        depth = now[D_] + dt * (now[V_] + 0.5 * dt * (bodies.load - now[F_]) / bodies.mass)
        count = _front(solid, bodies, dt, edge, depth, room)
    counts[IN1_] = count
    ends[DEPTH_NOW_] = depth
    if edge <= 0.0:
        wake(solid, bodies, 0, 0, room)
        write_bases(solid, dt, 0, 1, room)
        return 0.5 * math.pi * (nodes[BASE_, 0] - depth) - target
    radius = contact_radius(solid, bodies, edge, room)
    if radius >= edge:
        return -target
    end = counts[INSIDE_]
    if end + 1 >= size:
        return math.nan
    total = -2.0 * bodies.stress * solid.compliance * (edge - radius) - target
    if count > 0:
        near, beyond = cell_weights(edge, radius, nodes[PLACE_, count])
        total += near * -solid.compliance * cohesive_load(bodies.stress, edge, radius) + beyond * nodes[REST_, count]
    # Elements that leave within the step have the impulse of a broken line.
    left = min(max(counts[IN_], count), end + 1)
    for i in range(count, left):
        write_element(solid, bodies, dt, depth, i, room)
    if count < counts[WEIGHED_]:
        weigh(bodies, edge, count, room)
    end = max(end, count)
    cut = counts[CUT_]
    if left > cut or cut > end:
        cut = end if end - left < _SHORT and counts[BENDS_] == 0 else min(max(left, count) + _SPARE, end)
        counts[CUT_] = cut
        if cut < end:
            write_tail(solid, bodies, edge, cut, end, room)
    write_bases(solid, dt, left, cut + 1, room)
    base, rest, near_of, beyond_of = nodes[BASE_], nodes[REST_], nodes[NEAR_], nodes[NEXT_]
    for i in range(left, cut + 1):
        rest[i] = base[i] - depth
    if cut < end:
        total += tail(solid, dt, depth, room)
    return total + dot(near_of[count:cut], rest[count:cut]) + dot(beyond_of[count:cut], rest[count + 1 : cut + 1])
