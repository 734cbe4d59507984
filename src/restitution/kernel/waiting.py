"""Elements that wait between two fronts: those that follow the body, and those beyond the attraction.

An element that follows has the displacement d - g. By the branches E_k of its modulus, with rates s_k, its load is
``q = E W + sum S_k`` with ``S_k' = E_k W' - s_k S_k``, and W' is that of the depth. From a time t0 on it has therefore

    S_k(t) = exp(-s_k (t - t0)) (S_k(t0) - D_k(t0)) + D_k(t),    D_k' = E_k d' - s_k D_k,

with one D_k for all. What force and energies need of them are sums of S_k and S_k^2. Beyond the attraction
``M_j' = -r_j M_j``. Such an element is left alone until a front comes near, and a step costs what lies between the
fronts. An element has either form:

    S_k = E_k (J0 q - sum_j c_j r_j M_j/(s_k - r_j)),    M_j = W sum_k E_k/(s_k - r_j) - sum_k S_k/(s_k - r_j).
"""

import math

from restitution.kernel.compile import compiled, inlined
from restitution.kernel.zone import (
    ASTRAY_,
    BEYOND_,
    C_,
    COMMON_,
    CREEP_,
    D_,
    DECAY_,
    FIRM_,
    FIRST_,
    G_,
    H_,
    IN_,
    INSIDE_,
    KEPT_,
    LOW_,
    MADE_,
    MODULUS_,
    P_,
    PACE_,
    PLACE_,
    Q_,
    REACHED_,
    SECOND_,
    SHARE_,
    SINCE_,
    SUM_,
    SUM_G_,
    SUM_GG_,
    T_,
    TOP_,
    WAITS_,
    Bodies,
    Room,
    Solid,
    cohesive_load,
    write_pulls,
)

# Elements beside a front that do not wait, and how many of them begin or end to do so at once.
_NEAR, _MANY = 6, 16
# Rate times step below which the load of a branch is linear over a step.
_LINEAR = 1e-3


@compiled
def _wake_inside(bodies: Bodies, i: int, room: Room) -> None:
    """Bring an element that follows up to date."""
    nodes, branches, bridge, memory, now = room.nodes, room.branches, room.bridge, room.memory, room.now
    waited, share, moved = now[T_] - nodes[SINCE_, i], nodes[SHARE_, i], now[D_] - nodes[G_, i]
    load = room.ends[FIRM_] * moved
    for k in range(branches.shape[0]):
        part = branches[k, COMMON_] + math.exp(-branches[k, PACE_] * waited) * memory[k, i]
        branches[k, KEPT_] = part
        branches[k, FIRST_] -= share * part
        branches[k, SECOND_] -= share * part * part
        load += part
    for j in range(branches.shape[0]):
        total = branches[j, CREEP_] * moved
        for k in range(branches.shape[0]):
            total -= bridge[j, k] * branches[k, KEPT_]
        memory[j, i] = total
    pull = cohesive_load(bodies.stress, now[C_], nodes[PLACE_, i])
    nodes[Q_, i], nodes[P_, i], nodes[H_, i] = pull, load - pull, 0.0
    if load <= pull:
        room.counts[ASTRAY_] += 1


@compiled
def _wake_beyond(solid: Solid, i: int, room: Room) -> None:
    """Bring an element beyond the attraction up to date."""
    nodes, memory, now = room.nodes, room.memory, room.now
    moved, waited = 0.0, now[T_] - nodes[SINCE_, i]
    if i < room.counts[REACHED_]:
        for k in range(solid.rates.shape[0]):
            memory[k, i] *= math.exp(-solid.rates[k] * waited)
            room.branches[k, BEYOND_] -= nodes[SHARE_, i] * memory[k, i] ** 2
    for k in range(solid.rates.shape[0]):
        moved += solid.weights[k] * memory[k, i]
    nodes[Q_, i], nodes[P_, i], nodes[H_, i] = 0.0, 0.0, moved - now[D_] + nodes[G_, i]


@compiled
def wake(solid: Solid, bodies: Bodies, low: int, high: int, room: Room) -> None:
    """Let no element wait from a first to a last one."""
    counts, edge = room.counts, room.ends[MADE_]
    first, last = counts[LOW_], counts[TOP_]
    if low < first:
        low = max(low - _NEAR, 0)
        for i in range(low, first):
            _wake_inside(bodies, i, room)
        counts[LOW_] = low
        if low == 0:
            # No rounding is left.
            for k in range(room.branches.shape[0]):
                room.branches[k, FIRST_], room.branches[k, SECOND_] = 0.0, 0.0
        if not math.isnan(edge):
            write_pulls(bodies, edge, low, first, room)
    high = min(high, room.nodes.shape[1])
    if high > last:
        for i in range(last, high):
            _wake_beyond(solid, i, room)
        counts[TOP_] = high
        if not math.isnan(edge):
            write_pulls(bodies, edge, last, high, room)


@inlined
def _let_follow(solid: Solid, i: int, room: Room) -> None:
    """Let an element that follows wait."""
    nodes, branches, bridge, memory = room.nodes, room.branches, room.bridge, room.memory
    load, share = nodes[Q_, i] + nodes[P_, i], nodes[SHARE_, i]
    for k in range(branches.shape[0]):
        part = solid.compliance * load
        for j in range(branches.shape[0]):
            part -= solid.weights[j] * solid.rates[j] * bridge[j, k] * memory[j, i]
        part *= branches[k, MODULUS_]
        branches[k, KEPT_] = part
        branches[k, FIRST_] += share * part
        branches[k, SECOND_] += share * part * part
    for k in range(branches.shape[0]):
        memory[k, i] = branches[k, KEPT_] - branches[k, COMMON_]
    nodes[SINCE_, i] = room.now[T_]


@compiled
def rest(solid: Solid, bodies: Bodies, room: Room) -> None:
    """Let elements wait that are far enough from both fronts."""
    counts, nodes = room.counts, room.nodes
    inside, beyond = counts[IN_] - _NEAR, counts[INSIDE_] + 3
    if inside >= counts[LOW_] + _MANY:
        for i in range(counts[LOW_], inside):
            _let_follow(solid, i, room)
        counts[LOW_] = inside
    if counts[TOP_] > beyond + _MANY:
        for i in range(beyond, counts[TOP_]):
            nodes[SINCE_, i] = room.now[T_]
            for k in range(solid.rates.shape[0]):
                room.branches[k, BEYOND_] += nodes[SHARE_, i] * room.memory[k, i] ** 2
        counts[REACHED_] = max(counts[REACHED_], counts[TOP_])
        counts[TOP_] = beyond


@compiled
def carry(solid: Solid, dt: float, change: float, room: Room) -> float:
    """Take the sums of elements that wait over a step that changes the depth; return what they dissipate."""
    number, spent = room.nodes[SUM_, room.counts[LOW_]], 0.0
    for k in range(room.branches.shape[0]):
        row = room.branches[k]
        z, modulus, pace = row[PACE_] * dt, row[MODULUS_], row[PACE_]
        decay, loss = math.exp(-z), -math.expm1(-z)
        gain = modulus * change * loss / z
        first, second = row[FIRST_], row[SECOND_]
        both, after = decay * second + gain * first, decay * first + gain * number
        last = decay * both + gain * after
        if z < _LINEAR:
            part = dt * (second + both + last) / 3.0
        else:
            steady = modulus * change / z
            off = first - steady * number
            square = second - steady * (first + off)
            part = (2.0 * steady * off * loss + 0.5 * square * loss * (1.0 + decay)) / pace
            part += steady * steady * number * dt
        spent += part * pace / modulus
        row[FIRST_], row[SECOND_], row[COMMON_] = after, last, decay * row[COMMON_] + gain
        left = room.factors[k, DECAY_] ** 2
        spent += 0.5 * solid.weights[k] * solid.rates[k] * row[BEYOND_] * (1.0 - left)
        row[BEYOND_] *= left
    return spent


@compiled
def waiting_energy(solid: Solid, room: Room) -> float:
    """Return twice the energy stored in elements that wait, over the distance of elements."""
    nodes, depth, low = room.nodes, room.now[D_], room.counts[LOW_]
    total = 0.0
    if room.counts[WAITS_] == 0:
        return total
    if low > 0:
        total = depth * (depth * nodes[SUM_, low] - 2.0 * nodes[SUM_G_, low]) + nodes[SUM_GG_, low]
        total *= room.ends[FIRM_]
    for k in range(room.branches.shape[0]):
        row = room.branches[k]
        if low > 0:
            total += row[SECOND_] / row[MODULUS_]
        total += solid.weights[k] * solid.rates[k] * row[BEYOND_]
    return total
