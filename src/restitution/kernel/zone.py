"""Elements with a Dugdale zone: their loads and gaps over one step, and the equation of its edge.

See `restitution.kernel.adhesion` for the equations.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from restitution.kernel.compile import compiled, inlined

# Rows of `nodes`: undeformed gap g; at the start of the step contact load p, gap and cohesive load; at its end contact
# load, gap, cohesive load, gap without the displacement J0 q, impulse beyond that of a linear load; impulse of the
# cohesive load beyond a linear one over the time, gap without J0 q and without the depth, weights of the gaps at both
# ends of the cell behind the element, energy dissipated in the step, or weight of the gap in the tail; place x, weight
# in integrals over x; of elements that wait the time since when; sums of the weight, and of the weight with g and g^2,
# over all elements before; part of the step at which an element touches or leaves, and its load there, or what it
# dissipates.
(
    G_, P_, H_, Q_, P1_, H1_, Q1_, REST_, BUMP_, SHAPE_, BASE_, NEAR_, NEXT_, LOST_, PLACE_, SHARE_, SINCE_, SUM_,
    SUM_G_, SUM_GG_, PART_, KINK_, N_NODES
) = range(23)  # fmt: skip
# Columns of `factors` of a mode over a step: decay; impulse of a load that falls, that rises, and of a constant; sum
# of its memory over the tail.
DECAY_, FALL_, RISE_, MEAN_, TAIL_, N_FACTORS = range(6)
# Columns of `branches`: modulus and rate of a branch; sum of E_k/(s_k - r_j) over the branches, for mode j; load of
# the branch along the depth; sums of loads and of their squares over elements that wait and follow; sum of M_j^2 over
# those that wait beyond the edge; load of the branch in one element.
MODULUS_, PACE_, CREEP_, COMMON_, FIRST_, SECOND_, BEYOND_, KEPT_, N_BRANCH = range(9)
# Members of `now`, and columns of `motion`: time, depth, velocity, force, edge of the zone, contact radius, energies
# dissipated and lost in jumps.
T_, D_, V_, F_, C_, A_, VISCOUS_, JUMPS_, N_NOW = range(9)
# Columns of `jumps`: time, depth, edge and contact radius before and after, energy, depth after.
(AT_, DEPTH_, EDGE_, RADIUS_, EDGE1_, RADIUS1_, ENERGY_, DEPTH1_, N_JUMP) = range(9)
# Members of `counts`: elements that follow at the start and at the end of a step, first element that does not wait,
# and the first one behind it that waits, elements that may have memory, 1 if elements may wait, 1 if gaps have the
# form of `_bend`, rows of `motion`, jumps, direction of the last step of c, steps in a row that sought a fold,
# elements astray from the disc, first cell with weights, first cell of the tail, line of the program, turns of the
# body towards the surface, elements below the edge that was asked last.
(
    IN_, IN1_, LOW_, TOP_, REACHED_, WAITS_, BENDS_, STEPS_, JUMPED_, WAY_, SOUGHT_, ASTRAY_, WEIGHED_, CUT_, LINE_,
    TURNED_, INSIDE_, N_COUNTS
) = range(18)  # fmt: skip
# Members of `ends`: sums over the modes of c_j FALL, c_j RISE, and c_j MEAN over the step; energy at the end; edge to
# which cohesive loads and weights belong; depth at the end and length of the step that was tried last; last step;
# equilibrium modulus; over the tail, sums of the weight, and of the weight with undeformed gap, cohesive load at the
# start, impulse beyond a linear one, cohesive load at the end; step before the last one, 0 if there is none, and -1
# behind a jump; speeds of the edge in the last step and before; slope of G over the time.
(
    S_FALL_, S_RISE_, S_MEAN_, LEFT_, MADE_, DEPTH_NOW_, TRIED_, LAST_, FIRM_, ALL_, ALL_G_, ALL_Q_, ALL_SHAPE_,
    ALL_Q1_, BEFORE_, SPEED_, SPEED0_, FALLS_, N_ENDS
) = range(19)  # fmt: skip
SEPARATED, HELD, NO_ROOM, TOO_LONG, STUCK, NOT_DISC, PAUSED = range(7)

# Rate times step below which factors are series.
_SERIES = 2e-2
# Sine below which its angle is a series.
_SMALL_ANGLE = 0.1


class Solid(NamedTuple):
    """Inverse of the relaxation modulus, ``1/E*(p) = J0 + sum c_j/(p + r_j)``."""

    compliance: float
    weights: Any  # (K,): c_j
    rates: Any  # (K,): r_j


class Bodies(NamedTuple):
    """Numbers of the contact apart from the solid.

    A body that is `sprung` has no mass: its depth d follows from ``F = load + pace t - stiffness d`` with the time t
    over the step. A spring of stiffness k has load k z with its base at z; a prescribed force has no stiffness. A body
    with a mass has the load as a constant force towards the surface.
    """

    stress: float
    reach: float  # range h0 of the attraction
    mass: float
    cell: float  # distance of elements
    longest: float  # step
    sprung: bool
    stiffness: float
    load: float
    pace: float


class Room(NamedTuple):
    """State and results of one march over n elements."""

    nodes: Any  # (N_NODES, n)
    memory: Any  # (K, n): M_j
    factors: Any  # (K, N_FACTORS)
    branches: Any  # (K, N_BRANCH)
    bridge: Any  # (K, K): 1/(s_k - r_j) in row j
    now: Any  # (N_NOW,)
    counts: Any  # (N_COUNTS,) of integers
    ends: Any  # (N_ENDS,)
    motion: Any  # (steps, N_NOW)
    jumps: Any  # (m, N_JUMP)


def allocate_room(places: Any, modes: int, steps: int, jumps: int) -> Room:
    """Return room for a march with elements at these places."""
    nodes = np.zeros((N_NODES, places.size))
    nodes[PLACE_] = places
    # Loads are linear in x^2 between elements.
    low, high = places[:-1], places[1:]
    per = (high - low) / (3.0 * (high + low))
    nodes[SHARE_, :-1] += per * (2.0 * high + low)
    nodes[SHARE_, 1:] += per * (high + 2.0 * low)
    return Room(
        nodes, np.zeros((modes, places.size)), np.zeros((modes, N_FACTORS)), np.zeros((modes, N_BRANCH)),
        np.zeros((modes, modes)), np.zeros(N_NOW), np.zeros(N_COUNTS, dtype=np.int64), np.zeros(N_ENDS),
        np.zeros((steps, N_NOW)), np.zeros((jumps, N_JUMP)),
    )  # fmt: skip


@compiled
def set_factors(solid: Solid, dt: float, room: Room) -> None:
    """Write the factors of the modes over a step."""
    fall, rise, mean = 0.0, 0.0, 0.0
    for k in range(solid.rates.shape[0]):
        z, factors = solid.rates[k] * dt, room.factors[k]
        decay, loss = math.exp(-z), -math.expm1(-z)
        if z < _SERIES:
            constant = 1.0 - z * (0.5 - z * (1.0 / 6.0 - z * (1.0 / 24.0 - z / 120.0)))
            last = 0.5 - z * (1.0 / 6.0 - z * (1.0 / 24.0 - z * (1.0 / 120.0 - z / 720.0)))
        else:
            constant = loss / z
            last = (1.0 - constant) / z
        factors[DECAY_], factors[MEAN_] = decay, dt * constant
        factors[RISE_], factors[FALL_] = dt * last, dt * (constant - last)
        fall += solid.weights[k] * factors[FALL_]
        rise += solid.weights[k] * factors[RISE_]
        mean += solid.weights[k] * constant
    room.ends[S_FALL_], room.ends[S_RISE_], room.ends[S_MEAN_] = fall, rise, mean


@compiled
def count_below(places: Any, x: float) -> int:
    """Return how many elements lie below a place."""
    low, high = 0, places.shape[0]
    while low < high:
        middle = (low + high) // 2
        if places[middle] < x:
            low = middle + 1
        else:
            high = middle
    return low


@inlined
def count_near(places: Any, x: float, near: int) -> int:
    """Return how many elements lie below a place, where it is near a number."""
    while near < places.shape[0] and places[near] < x:
        near += 1
    while near > 0 and places[near - 1] >= x:
        near -= 1
    return near


@inlined
def cohesive_load(stress: float, edge: float, x: float) -> float:
    """Return the cohesive load of an element."""
    inside = (edge - x) * (edge + x)
    return -2.0 * stress * math.sqrt(inside) if inside > 0.0 else 0.0


@inlined
def _bump(before: float, after: float, x: float, edge: float, edge1: float, dt: float) -> float:
    """Return the impulse of the cohesive load over a step beyond the linear one, with c^2 linear over the time."""
    if before == 0.0 and after == 0.0:
        return 0.0
    if before != 0.0 and after != 0.0:
        change = after - before
        return dt * change * change / (6.0 * (before + after))
    low, high = min(edge, edge1), max(edge, edge1)
    part = (high - x) * (high + x) / ((high - low) * (high + low))
    return dt * (before + after) * (2.0 * part / 3.0 - 0.5)


@inlined
def _small_angle(sine: float) -> float:
    """Return the angle of a sine below 0.1."""
    z = sine * sine
    return sine * (1.0 + z * (1.0 / 6.0 + z * (3.0 / 40.0 + z * (15.0 / 336.0 + z * (105.0 / 3456.0 + z / 44.7)))))


@inlined
def dot(weights: Any, values: Any) -> float:
    """Return the sum of products; four sums run side by side."""
    first, second, third, fourth = 0.0, 0.0, 0.0, 0.0
    count = weights.shape[0]
    for n in range(count // 4):
        k = 4 * n
        first += weights[k] * values[k]
        second += weights[k + 1] * values[k + 1]
        third += weights[k + 2] * values[k + 2]
        fourth += weights[k + 3] * values[k + 3]
    for k in range(count - count % 4, count):
        first += weights[k] * values[k]
    return (first + second) + (third + fourth)


@inlined
def cell_weights(edge: float, low: float, high: float) -> tuple[float, float]:
    """Return weights of the gaps at both ends of a cell in ``int H/sqrt(c^2 - x^2) dx`` within the edge.

    The gap is linear in x^2 from `low` to `high`, and the edge may lie between them.
    """
    reach = min(high, edge)
    root = math.sqrt(max((edge - low) * (edge + low), 0.0))
    root1 = math.sqrt(max((edge - reach) * (edge + reach), 0.0))
    sum_of_both = reach * root + low * root1
    sine = (reach - low) * (reach + low) / sum_of_both if sum_of_both > 0.0 else 0.0
    whole = math.asin(min(sine, 1.0)) if sine > _SMALL_ANGLE else _small_angle(sine)
    way = (high - low) * (high + low)
    if not way > 1e-12 * edge * edge:
        return whole, 0.0
    bend = 0.5 * (edge * edge * whole - reach * root1 + low * root)
    part = (bend - low * low * whole) / way
    return whole - part, part


@compiled
def write_pulls(bodies: Bodies, edge: float, low: int, high: int, room: Room) -> None:
    """Write the cohesive loads of elements over a step to an edge."""
    nodes, edge0 = room.nodes, room.now[C_]
    inside = count_near(nodes[PLACE_], edge, room.counts[INSIDE_])
    inside0 = count_near(nodes[PLACE_], edge0, inside)
    room.counts[INSIDE_] = inside
    both = max(min(min(inside, inside0), high), low)
    any_ = max(min(max(inside, inside0), high), both)
    stress, place = bodies.stress, nodes[PLACE_, low:both]
    before, after, shape = nodes[Q_, low:both], nodes[Q1_, low:both], nodes[SHAPE_, low:both]
    for k in range(both - low):
        x = place[k]
        pull = -2.0 * stress * math.sqrt((edge - x) * (edge + x))
        change = pull - before[k]
        after[k] = pull
        shape[k] = change * change / (6.0 * (pull + before[k]))
    for i in range(both, any_):
        x = nodes[PLACE_, i]
        pull = cohesive_load(stress, edge, x)
        nodes[Q1_, i] = pull
        nodes[SHAPE_, i] = _bump(nodes[Q_, i], pull, x, edge0, edge, 1.0)
    for i in range(any_, high):
        nodes[Q1_, i], nodes[SHAPE_, i] = 0.0, 0.0


@compiled
def weigh(bodies: Bodies, edge: float, low: int, room: Room) -> None:
    """Write the weights of all cells from one on that reach into the zone."""
    counts = room.counts
    end = min(counts[WEIGHED_], room.nodes.shape[1] - 1)
    near, beyond, place = room.nodes[NEAR_], room.nodes[NEXT_], room.nodes[PLACE_]
    # Cells whose angles are small for sure, all of them within the zone.
    square, apart = edge * edge, bodies.cell / _SMALL_ANGLE
    inner = count_near(place, math.sqrt(max((edge - apart) * (edge + apart), 0.0)), counts[INSIDE_]) - 2
    inner = min(max(inner, low), end)
    low_of, high_of, first, second = place[low:inner], place[low + 1 : inner + 1], near[low:inner], beyond[low:inner]
    # The root of c^2 - x^2 is known from the cohesive load.
    pull, pull1, scale = room.nodes[Q1_, low:inner], room.nodes[Q1_, low + 1 : inner + 1], -0.5 / bodies.stress
    for k in range(inner - low):
        x, x1, root, root1 = low_of[k], high_of[k], scale * pull[k], scale * pull1[k]
        way, both = (x1 - x) * (x1 + x), x1 * root + x * root1
        per = 1.0 / (way * both)
        whole = _small_angle(way * way * per)
        part = (0.5 * (square * whole - x1 * root1 + x * root) - x * x * whole) * both * per
        first[k], second[k] = whole - part, part
    for k in range(inner, end):
        if place[k] >= edge:
            break
        near[k], beyond[k] = cell_weights(edge, place[k], place[k + 1])
    counts[WEIGHED_] = low


@inlined
def _dot_of_cubes(weights: Any, values: Any) -> float:
    """Return the sum of products with third powers; four sums run side by side."""
    first, second, third, fourth = 0.0, 0.0, 0.0, 0.0
    count = weights.shape[0]
    for n in range(count // 4):
        k = 4 * n
        first += weights[k] * (values[k] * values[k] * values[k])
        second += weights[k + 1] * (values[k + 1] * values[k + 1] * values[k + 1])
        third += weights[k + 2] * (values[k + 2] * values[k + 2] * values[k + 2])
        fourth += weights[k + 3] * (values[k + 3] * values[k + 3] * values[k + 3])
    for k in range(count - count % 4, count):
        first += weights[k] * (values[k] * values[k] * values[k])
    return (first + second) + (third + fourth)


@inlined
def _moment(edge: float, x: float) -> float:
    """Return the integral of ``c^2 - y^2`` from x to c."""
    return (edge - x) * (edge - x) * (2.0 * edge + x) / 3.0


@compiled
def _bend(stress: float, edge: float, first: int, end: int, room: Room) -> None:
    """Let the weights of the tail be those of gaps ``a + b u + B u^(3/2)`` with ``u = c^2 - x^2``.

    While the edge passes elements, their memory has this form beside it. B follows from the last three elements within
    the edge, and what an interpolation linear in u leaves of ``B u^(3/2)`` is added in all cells. The cell in which
    the edge lies has the form of these three alone, as the gap has a kink where the edge has turned.
    """
    nodes, scale = room.nodes, -0.5 / stress
    weight, near = nodes[LOST_, first : end + 1], nodes[NEAR_]
    place, root = nodes[PLACE_, first : end + 1], nodes[Q1_, first : end + 1]
    last = end - first
    inside = last > 0 and place[last] - edge > 1e-9 * (place[last] - place[last - 1])
    if inside:
        last -= 1
    if last < 2:
        return
    s, s1, s2 = scale * root[last], scale * root[last - 1], scale * root[last - 2]
    u, u1, u2 = s * s, s1 * s1, s2 * s2
    cubes = _dot_of_cubes(nodes[LOST_, first : first + last + 1], nodes[Q1_, first : first + last + 1])
    bend = _moment(edge, place[0]) - scale * scale * scale * cubes
    slope = 0.0
    if inside:
        beyond = nodes[NEXT_, first + last]
        whole = near[first + last] + beyond
        weight[last] += beyond
        weight[last + 1] -= beyond
        # The weight of the last element has the part within its last cell.
        slope = 0.5 * (edge * edge * whole - place[last] * s) - u * whole
        bend += near[first + last] * u * s - u * s * whole
    else:
        bend -= _moment(edge, place[last])
    d1, d2, g1, g2 = u1 - u, u2 - u, u1 * s1 - u * s, u2 * s2 - u * s
    both = d1 * g2 - d2 * g1
    part1, part2 = (slope * g2 - bend * d2) / both, (bend * d1 - slope * g1) / both
    weight[last - 1] += part1
    weight[last - 2] += part2
    weight[last] -= part1 + part2


@compiled
def write_tail(solid: Solid, bodies: Bodies, edge: float, first: int, end: int, room: Room) -> None:
    """Write the sums over the cells from one to another in which no element is near the contact.

    The gaps there without J0 q are linear in few numbers of a step, whatever its length, and so is their integral.
    """
    nodes, ends = room.nodes, room.ends
    weight, near, beyond = nodes[LOST_, first : end + 1], nodes[NEAR_, first:end], nodes[NEXT_, first:end]
    count = end - first
    weight[count] = 0.0
    for k in range(count):
        weight[k] = near[k]
    for k in range(count):
        weight[k + 1] += beyond[k]
    if room.counts[BENDS_] > 0:
        _bend(bodies.stress, edge, first, end, room)
    place = nodes[PLACE_, first]
    ends[ALL_] = math.atan2(math.sqrt(max((edge - place) * (edge + place), 0.0)), place)
    ends[ALL_G_], ends[ALL_Q_] = dot(weight, nodes[G_, first : end + 1]), dot(weight, nodes[Q_, first : end + 1])
    ends[ALL_SHAPE_] = dot(weight, nodes[SHAPE_, first : end + 1])
    ends[ALL_Q1_] = dot(weight, nodes[Q1_, first : end + 1])
    for k in range(solid.rates.shape[0]):
        room.factors[k, TAIL_] = dot(weight, room.memory[k, first : end + 1])


@compiled
def tail(solid: Solid, dt: float, depth: float, room: Room) -> float:
    """Return the integral of the gaps in the tail, without J0 q, after a step."""
    ends = room.ends
    total = ends[ALL_G_] - depth * ends[ALL_] + ends[S_FALL_] * ends[ALL_Q_]
    total += ends[S_MEAN_] * dt * ends[ALL_SHAPE_] + ends[S_RISE_] * ends[ALL_Q1_]
    for k in range(solid.rates.shape[0]):
        total += solid.weights[k] * room.factors[k, DECAY_] * room.factors[k, TAIL_]
    return total


@compiled
def write_bases(solid: Solid, dt: float, low: int, high: int, room: Room) -> None:
    """Write gaps without the displacement J0 q, and without the depth, of elements that do not change their state."""
    # Loops from 0 on over views are those that compilers make of several elements at once.
    ends, nodes = room.ends, room.nodes
    base, gap, load = nodes[BASE_, low:high], nodes[G_, low:high], nodes[Q_, low:high]
    press, after, shape = nodes[P_, low:high], nodes[Q1_, low:high], nodes[SHAPE_, low:high]
    fall, rise, mean = ends[S_FALL_], ends[S_RISE_], ends[S_MEAN_] * dt
    count = max(high - low, 0)
    for i in range(count):
        base[i] = gap[i] + fall * (load[i] + press[i]) + mean * shape[i] + rise * after[i]
    for k in range(solid.rates.shape[0]):
        part, memory = solid.weights[k] * room.factors[k, DECAY_], room.memory[k, low:high]
        for i in range(count):
            base[i] += part * memory[i]


@inlined
def _is_steady(square0: float, square1: float) -> bool:
    """Return whether the square of a cohesive load does not change over a step, or is that of no load at all."""
    highest = max(square0, square1)
    return highest <= 0.0 or abs(square1 - square0) <= 1e-9 * highest


@inlined
def _crossing(start: float, end: float, square0: float, square1: float) -> tuple[float, float]:
    """Return the part of a step at which a line plus v vanishes, and v; v^2 is linear over the step where positive.

    Start and end are those of the line alone.
    """
    slope, rise = end - start, square1 - square0
    v0, v1 = math.sqrt(max(square0, 0.0)), math.sqrt(max(square1, 0.0))
    if _is_steady(square0, square1):
        f0, f1 = start + v0, end + v1
        part = f0 / (f0 - f1)
        return part, v0 + part * (v1 - v0)
    # slope (v^2 - square0) + rise (start + v) = 0
    c = start * rise - slope * square0
    root = math.sqrt(max(rise * rise - 4.0 * slope * c, 0.0))
    q = -0.5 * (rise + root if rise > 0.0 else rise - root)
    low, high = min(v0, v1), max(v0, v1)
    v, other = c / q, q / slope if slope != 0.0 else math.inf
    if abs(other - 0.5 * (low + high)) < abs(v - 0.5 * (low + high)):
        v = other
    v = min(max(v, low), high)
    return min(max((v * v - square0) / rise, 0.0), 1.0), v


@inlined
def _impulse(part0: float, part1: float, v0: float, v1: float, square0: float, square1: float) -> float:
    """Return the integral of v between two parts of a step."""
    if _is_steady(square0, square1):
        return 0.5 * (v0 + v1) * (part1 - part0)
    return 2.0 * (v1 * v1 * v1 - v0 * v0 * v0) / (3.0 * (square1 - square0))


@inlined
def _leaving(load: float, after: float, square0: float, square1: float, i: int, room: Room) -> float:
    """Return the impulse of an element that leaves beyond that of a line, over the step, and write its instant.

    Its load is a line, to `after` if it stayed, until it is the cohesive one.
    """
    nodes = room.nodes
    part, v = _crossing(load, after, square0, square1)
    nodes[PART_, i], nodes[KINK_, i] = part, -v
    last = math.sqrt(max(square1, 0.0))
    impulse = 0.5 * part * (load - v) - _impulse(part, 1.0, v, last, square0, square1)
    return impulse - 0.5 * (load + nodes[Q1_, i])


@inlined
def _touching(start: float, end: float, square0: float, square1: float, i: int, room: Room) -> float:
    """Return the impulse of an element that touches beyond that of a line, over the step, and write its instant.

    `start` and `end` are the gaps over J0, as if it did not touch: a line and the cohesive load. From the touch on the
    load is a line to the cohesive one; that of the contact at the end comes on top.
    """
    nodes, pull0, pull = room.nodes, room.nodes[Q_, i], room.nodes[Q1_, i]
    part, v = _crossing(pull0 - start, pull - end, square0, square1)
    nodes[PART_, i], nodes[KINK_, i] = part, -v
    first = math.sqrt(max(square0, 0.0))
    impulse = 0.5 * (1.0 - part) * (pull - v) - _impulse(0.0, part, first, v, square0, square1)
    return impulse - 0.5 * (pull0 + pull)


@inlined
def write_element(solid: Solid, bodies: Bodies, dt: float, depth: float, i: int, room: Room) -> None:
    """Write load and gap of one element at the end of a step; its base is known."""
    nodes, edge0, edge = room.nodes, room.now[C_], room.ends[MADE_]
    pull, before, x = nodes[Q1_, i], nodes[P_, i], nodes[PLACE_, i]
    soft, mean = solid.compliance + room.ends[S_RISE_], room.ends[S_MEAN_]
    press, bump = 0.0, nodes[SHAPE_, i] * dt
    # Without the impulse beyond that of a line.
    plain = nodes[BASE_, i] - depth - mean * bump
    gap = plain + mean * bump + solid.compliance * pull
    # Of the cohesive load, whose square is linear over the step.
    four = 4.0 * bodies.stress * bodies.stress
    square0, square1 = four * (edge0 - x) * (edge0 + x), four * (edge - x) * (edge + x)
    if before > 0.0:
        press, gap, bump = -(plain + solid.compliance * pull) / soft, 0.0, 0.0
        if press < 0.0:
            bump = dt * _leaving(nodes[Q_, i] + before, pull + press, square0, square1, i, room)
            press, gap = 0.0, plain + mean * bump + solid.compliance * pull
    elif gap < 0.0:
        open0, per = max(nodes[H_, i], 0.0), 1.0 / solid.compliance
        bump = dt * _touching(open0 * per, gap * per, square0, square1, i, room)
        late = 0.5 * nodes[PART_, i] * dt
        press = -(plain + mean * bump + solid.compliance * pull) / (soft - mean * late)
        gap, bump = 0.0, bump - press * late
    nodes[P1_, i], nodes[H1_, i] = press, gap
    nodes[REST_, i], nodes[BUMP_, i] = plain + mean * bump, bump


@compiled
def contact_radius(solid: Solid, bodies: Bodies, edge: float, room: Room) -> float:
    """Return a, where the load of what follows falls to the cohesive one.

    Between the last element that follows and the first that is loaded it is linear in x^2.
    """
    count, nodes = room.counts[IN1_], room.nodes
    if count == 0:
        return 0.0
    press = nodes[P1_, count - 1]
    ahead = nodes[H1_, count] / solid.compliance
    inner, outer = nodes[PLACE_, count - 1], nodes[PLACE_, count]
    whole = (outer - inner) * (outer + inner)
    if edge <= inner:
        return math.sqrt(inner * inner + whole * press / (press + ahead))
    load = press + nodes[Q1_, count - 1]
    slope = (nodes[Q1_, count] - ahead - load) / whole
    # The root u of load + 2 sigma u at x^2 = c^2 - u^2.
    missing = -load - slope * (edge - inner) * (edge + inner)
    root = bodies.stress * bodies.stress - slope * missing
    if missing <= 0.0 or root < 0.0:
        return edge
    u = missing / (bodies.stress + math.sqrt(root))
    return math.sqrt(min(max((edge - u) * (edge + u), inner * inner), outer * outer))


@compiled
def normal_force(bodies: Bodies, edge: float, radius: float, depth: float, room: Room) -> float:
    """Return the force at the end of a step; loads of the contact are linear in x^2 between elements.

    The sums of elements that wait are those at the end.
    """
    count, low, nodes, total = room.counts[IN1_], room.counts[LOW_], room.nodes, 0.0
    ring = 0.0
    if edge > 0.0:
        away = math.sqrt(max((edge - radius) * (edge + radius), 0.0))
        angle = math.asin(min(away / edge, 1.0))
        ring = bodies.stress * (edge * edge * angle - radius * away)
    if count > 0:
        last = count - 1
        if low > 0:
            total = room.ends[FIRM_] * (depth * nodes[SUM_, low] - nodes[SUM_G_, low])
            for k in range(room.branches.shape[0]):
                total += room.branches[k, FIRST_]
        share = nodes[SHARE_, low:last]
        total += dot(share, nodes[P1_, low:last]) + dot(share, nodes[Q1_, low:last])
        load = nodes[P1_, last] + nodes[Q1_, last]
        inner = nodes[PLACE_, last]
        if last > 0:
            before = nodes[PLACE_, last - 1]
            total += load * (inner - before) * (inner + 2.0 * before) / (3.0 * (inner + before))
        if radius > 0.0:
            both = load * (2.0 * radius + inner)
            both += cohesive_load(bodies.stress, edge, radius) * (radius + 2.0 * inner)
            total += (radius - inner) * both / (3.0 * (radius + inner))
    return 2.0 * (total - ring)
