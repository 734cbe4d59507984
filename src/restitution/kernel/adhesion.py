"""Impact with adhesion: a Dugdale zone on independent elements with memory.

A constant attraction acts where the gap is below its range. Element x has the load q and the displacement W of the
surface, ``W = J0 q + sum c_j M_j`` with ``M_j' = q - r_j M_j``. Its gap is ``H = W - d + g(x)``. Within the edge c of
the zone the load is ``q = -2 sigma sqrt(c^2 - x^2) + p``. Each element has either p = 0, and is loaded, or H = 0, and
follows the body with p > 0; those that follow have x < a. One equation gives c, where the gap is the range h0:

    G = int_a^c H/sqrt(c^2 - x^2) dx - pi h0/2 = 0,    dG/dc > 0.

At fixed depth the energy has the derivative 4 sigma c G over c. Where dG/dc falls to 0, the edge jumps down the
slope of the energy to the next root.

Elements are equally spaced. A step ends where c reaches an element, or after the longest step. The load is linear over
a step in the memory, with two corrections of its impulse: c^2 is linear, and an element that changes its state within
the step does so where p vanishes on a line. The scheme is of second order, also at the fronts.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from restitution.kernel.compile import compiled, entry_point, inlined

# Rows of `nodes`: undeformed gap g; at the start of the step contact load p, gap and cohesive load; at its end contact
# load, gap, cohesive load, gap without the displacement J0 q, impulse beyond that of a linear load; impulse of the
# cohesive load beyond a linear one over the time, gap without J0 q and without the depth, weights of the gaps at both
# ends of the cell behind the element, energy dissipated in the step.
(
    G_, P_, H_, Q_, P1_, H1_, Q1_, REST_, BUMP_, SHAPE_, BASE_, NEAR_, NEXT_, LOST_, N_NODES
) = range(15)  # fmt: skip
# Columns of `factors` of a mode over a step: decay; impulse of a load that falls, that rises, and of a constant.
DECAY_, FALL_, RISE_, MEAN_, N_FACTORS = range(5)
# Members of `now`, and columns of `motion`: time, depth, velocity, force, edge of the zone, contact radius, energies
# dissipated and lost in jumps.
T_, D_, V_, F_, C_, A_, VISCOUS_, JUMPS_, N_NOW = range(9)
# Columns of `jumps`: time, depth, edge and contact radius before and after, energy, depth after.
(AT_, DEPTH_, EDGE_, RADIUS_, EDGE1_, RADIUS1_, ENERGY_, DEPTH1_, N_JUMP) = range(9)
# Members of `counts`: elements that follow at the start and at the end of a step, elements that may have memory,
# rows of `motion`, jumps, direction of the last step of c, steps in a row that sought a fold, elements astray from the
# disc, elements with a cohesive load in `nodes`, first cell with weights, line of the program.
(
    IN_, IN1_, TOP_, STEPS_, JUMPED_, WAY_, SOUGHT_, ASTRAY_, WIDE_, WEIGHED_, LINE_, N_COUNTS
) = range(12)  # fmt: skip
# Members of `ends`: sums over the modes of c_j FALL, c_j RISE, and c_j MEAN over the step; energy at the end; edge to
# which cohesive loads and weights belong; depth and length of the last step.
S_FALL_, S_RISE_, S_MEAN_, LEFT_, MADE_, DEPTH_NOW_, LAST_, N_ENDS = range(8)
SEPARATED, HELD, NO_ROOM, TOO_LONG, STUCK, NOT_DISC, PAUSED = range(7)

_MOST_ROOTS, _MOST_DEPTHS, _MOST_FOLDS, _SECTIONS = 80, 200, 6, 20
# Share of the way to the next element within which the edge is at a fold; error of a parabola over its height.
_AT_FOLD, _PARABOLIC = 1e-3, 0.1
# Rates times step below which factors are series, and below which the rate of a mode is linear over a step.
_SERIES, _LINEAR = 2e-2, 1e-3
# Share of a history that is rounding of its times.
_ROUNDING = 1e-12
# Sine below which its angle is a series.
_SMALL_ANGLE = 0.1
# Steps between looks at the energy, and its share of the kinetic one by which it is below zero for sure.
_OFTEN, _SURE = 16, 1e-3


class Solid(NamedTuple):
    """Inverse of the relaxation modulus, ``1/E*(p) = J0 + sum c_j/(p + r_j)``."""

    compliance: float
    weights: Any  # (K,): c_j
    rates: Any  # (K,): r_j


class Bodies(NamedTuple):
    """Numbers of the contact apart from the solid.

    A body that is `sprung` has no mass: its depth d follows from ``F = load + pace t - stiffness d`` with the time t
    over the step. A spring of stiffness k has load k z with its base at z; a prescribed force has no stiffness.
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
    now: Any  # (N_NOW,)
    counts: Any  # (N_COUNTS,) of integers
    ends: Any  # (N_ENDS,)
    motion: Any  # (steps, N_NOW)
    jumps: Any  # (m, N_JUMP)


def allocate_room(elements: int, modes: int, steps: int, jumps: int) -> Room:
    """Return room for a march."""
    return Room(
        np.zeros((N_NODES, elements)), np.zeros((modes, elements)), np.zeros((modes, N_FACTORS)), np.zeros(N_NOW),
        np.zeros(N_COUNTS, dtype=np.int64), np.zeros(N_ENDS), np.zeros((steps, N_NOW)), np.zeros((jumps, N_JUMP)),
    )  # fmt: skip


@compiled
def _set_factors(solid: Solid, dt: float, room: Room) -> None:
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


@inlined
def _pull(stress: float, edge: float, x: float) -> float:
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
def _angle(sine: float) -> float:
    """Return the angle of a sine."""
    if sine > _SMALL_ANGLE:
        return math.asin(min(sine, 1.0))
    z = sine * sine
    return sine * (1.0 + z * (1.0 / 6.0 + z * (3.0 / 40.0 + z * (15.0 / 336.0 + z * (105.0 / 3456.0 + z / 44.7)))))


@inlined
def _weights(edge: float, low: float, high: float) -> tuple[float, float]:
    """Return weights of the gaps at both ends of a cell in ``int H/sqrt(c^2 - x^2) dx`` within the edge.

    The gap is linear in x^2 from `low` to `high`, of which the edge may leave a part.
    """
    reach = min(high, edge)
    root = math.sqrt(max((edge - low) * (edge + low), 0.0))
    root1 = math.sqrt(max((edge - reach) * (edge + reach), 0.0))
    sum_of_both = reach * root + low * root1
    whole = _angle((reach - low) * (reach + low) / sum_of_both) if sum_of_both > 0.0 else 0.0
    way = (high - low) * (high + low)
    if not way > 1e-12 * edge * edge:
        return whole, 0.0
    bend = 0.5 * (edge * edge * whole - reach * root1 + low * root)
    part = (bend - low * low * whole) / way
    return whole - part, part


@compiled
def _prepare(bodies: Bodies, edge: float, room: Room) -> None:
    """Write the cohesive loads of a step to an edge; the weights of cells are made when they are asked for."""
    counts, nodes, h, edge0 = room.counts, room.nodes, bodies.cell, room.now[C_]
    size = nodes.shape[1]
    inner, outer = min(edge, edge0), max(edge, edge0)
    both = min(int(inner / h) + 1, size)
    while both > 0 and (both - 1) * h >= inner:
        both -= 1
    any_ = min(int(outer / h) + 1, size)
    before, after, shape, stress = nodes[Q_], nodes[Q1_], nodes[SHAPE_], bodies.stress
    for i in range(both):
        x = i * h
        pull = -2.0 * stress * math.sqrt((edge - x) * (edge + x))
        change = pull - before[i]
        after[i] = pull
        shape[i] = change * change / (6.0 * (pull + before[i]))
    for i in range(both, any_):
        x = i * h
        after[i] = _pull(stress, edge, x)
        shape[i] = _bump(before[i], after[i], x, edge0, edge, 1.0)
    for i in range(any_, counts[WIDE_]):
        after[i], shape[i] = 0.0, 0.0
    counts[WIDE_] = max(any_, counts[WIDE_])
    counts[WEIGHED_] = size
    room.ends[MADE_] = edge


@compiled
def _weigh(bodies: Bodies, edge: float, low: int, room: Room) -> None:
    """Write the weights of all cells from one on that reach into the zone."""
    counts, h = room.counts, bodies.cell
    end = min(counts[WEIGHED_], room.nodes.shape[1] - 1)
    near, beyond = room.nodes[NEAR_], room.nodes[NEXT_]
    for k in range(low, end):
        if k * h >= edge:
            break
        near[k], beyond[k] = _weights(edge, k * h, (k + 1) * h)
    counts[WEIGHED_] = low


@compiled
def _bases(solid: Solid, dt: float, low: int, high: int, room: Room) -> None:
    """Write gaps without the displacement J0 q, and without the depth, of elements that do not change their state."""
    nodes, ends = room.nodes, room.ends
    base, gap, load, press, after, shape = (
        nodes[BASE_], nodes[G_], nodes[Q_], nodes[P_], nodes[Q1_], nodes[SHAPE_]
    )  # fmt: skip
    fall, rise, mean = ends[S_FALL_], ends[S_RISE_], ends[S_MEAN_] * dt
    for i in range(low, high):
        base[i] = gap[i] + fall * (load[i] + press[i]) + mean * shape[i] + rise * after[i]
    for k in range(solid.rates.shape[0]):
        part, memory = solid.weights[k] * room.factors[k, DECAY_], room.memory[k]
        for i in range(low, high):
            base[i] += part * memory[i]


@inlined
def _element(solid: Solid, dt: float, depth: float, i: int, room: Room) -> None:
    """Write load and gap of one element at the end of a step; its base is known."""
    nodes, ends = room.nodes, room.ends
    pull, rest, bump = nodes[Q1_, i], nodes[BASE_, i] - depth, nodes[SHAPE_, i] * dt
    press, before = 0.0, nodes[P_, i]
    gap = rest + solid.compliance * pull
    if before > 0.0:
        press = -gap / (solid.compliance + ends[S_RISE_])
        if press < 0.0:
            # It leaves where p vanishes.
            extra = 0.5 * before * dt * press / (before - press)
            bump += extra
            gap += ends[S_MEAN_] * extra
            rest += ends[S_MEAN_] * extra
            press = 0.0
        else:
            gap = 0.0
    elif gap < 0.0:
        start = max(nodes[H_, i], 0.0)
        part = 0.5 * dt * start / (start - gap)
        press = -gap / (solid.compliance + ends[S_RISE_] - ends[S_MEAN_] * part)
        bump -= press * part
        gap = 0.0
    nodes[P1_, i], nodes[H1_, i] = press, gap
    nodes[REST_, i], nodes[BUMP_, i] = rest, bump


@compiled
def _contact_radius(solid: Solid, bodies: Bodies, room: Room) -> float:
    """Return a from the last element that follows and the first that is loaded."""
    count, nodes, h = room.counts[IN1_], room.nodes, bodies.cell
    if count == 0:
        return 0.0
    press = nodes[P1_, count - 1]
    ahead = nodes[H1_, count] / (solid.compliance + room.ends[S_RISE_])
    inner, outer = (count - 1) * h, count * h
    square = inner * inner + (outer - inner) * (outer + inner) * press / (press + ahead)
    return math.sqrt(square)


@compiled
def _force(bodies: Bodies, edge: float, radius: float, room: Room) -> float:
    """Return the force at the end of a step; contact loads are linear in x^2 between elements."""
    count, press, h, total = room.counts[IN1_], room.nodes[P1_], bodies.cell, 0.0
    if count > 0:
        last = count - 1
        for i in range(last):
            # The weight is 1 but for the curvature of x^2, also at the axis.
            total += press[i] * (1.0 - 1.0 / (3.0 * (4.0 * i * i - 1.0)) if i > 0 else 2.0 / 3.0)
        if last > 0:
            total += press[last] * (3.0 * last - 2.0) / (3.0 * (2.0 * last - 1.0))
        total *= h
        inner = last * h
        if radius > 0.0:
            total += press[last] * (radius - inner) * (2.0 * radius + inner) / (3.0 * (radius + inner))
    return 2.0 * total - math.pi * bodies.stress * edge * edge


@compiled
def _sprung(solid: Solid, bodies: Bodies, dt: float, edge: float, room: Room) -> float:
    """Return the depth at which the spring bears the force; NaN under a force that no depth bears.

    The elements of the contact are written. The force rises with the depth, and its slope does.
    """
    counts, nodes, ends = room.counts, room.nodes, room.ends
    size = nodes.shape[1]
    load, stiffness = bodies.load + dt * bodies.pace, bodies.stiffness
    done = min(max(int(edge / bodies.cell), counts[IN_]) + 2, size)
    _bases(solid, dt, 0, done, room)
    touch = nodes[BASE_, 0] + solid.compliance * nodes[Q1_, 0]
    spare = load + math.pi * bodies.stress * edge * edge
    if stiffness * touch >= spare:
        counts[IN1_] = 0
        depth = spare / stiffness if stiffness > 0.0 else math.nan
        _element(solid, dt, depth, 0, room)
        return depth
    depth = max(room.now[D_], touch)
    if depth == touch:
        depth += bodies.cell * bodies.cell
    last = math.inf
    for _ in range(_MOST_DEPTHS):
        count = 0
        while count < size - 2:
            if count >= done:
                _bases(solid, dt, count, count + 1, room)
                done = count + 1
            _element(solid, dt, depth, count, room)
            if not nodes[P1_, count] > 0.0:
                break
            count += 1
        counts[IN1_] = count
        radius = _contact_radius(solid, bodies, room)
        wide = max(radius, 0.5 * bodies.cell)
        excess = _force(bodies, edge, radius, room) + stiffness * depth - load
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
    """Return how many elements follow at a depth; those from the last of them on are written."""
    nodes, count = room.nodes, room.counts[IN_]
    size = nodes.shape[1]
    low, high = max(count - 1, 0), min(max(int(edge / bodies.cell), count) + 2, size)
    _bases(solid, dt, low, high, room)
    _element(solid, dt, depth, count, room)
    if nodes[P1_, count] > 0.0:
        while nodes[P1_, count] > 0.0 and count < size - 2:
            count += 1
            if count >= high:
                _bases(solid, dt, count, count + 1, room)
            _element(solid, dt, depth, count, room)
        return count
    while count > 0:
        if count - 1 < low:
            low = count - 1
            _bases(solid, dt, low, low + 1, room)
        _element(solid, dt, depth, count - 1, room)
        if nodes[P1_, count - 1] > 0.0:
            break
        count -= 1
    return count


@compiled
def _excess(solid: Solid, bodies: Bodies, dt: float, edge: float, room: Room) -> float:
    """Return G after a step with the zone up to `edge`; the elements from the contact to the edge are written."""
    now, counts, nodes, ends, h = room.now, room.counts, room.nodes, room.ends, bodies.cell
    size, target = nodes.shape[1], 0.5 * math.pi * bodies.reach
    if ends[MADE_] != edge:
        _prepare(bodies, edge, room)
    _set_factors(solid, dt, room)
    if bodies.sprung:
        depth = _sprung(solid, bodies, dt, edge, room)
        count = counts[IN1_]
        if math.isnan(depth):
            # A pull beyond that of the zone takes the body away.
            return target if bodies.load + dt * bodies.pace < 0.0 or edge > 0.0 else -target
    else:
        depth = now[D_] + dt * (now[V_] - 0.5 * dt * now[F_] / bodies.mass)
        count = _front(solid, bodies, dt, edge, depth, room)
    counts[IN1_] = count
    ends[DEPTH_NOW_] = depth
    if edge <= 0.0:
        _bases(solid, dt, 0, 1, room)
        return 0.5 * math.pi * (nodes[BASE_, 0] - depth) - target
    radius = _contact_radius(solid, bodies, room)
    if radius >= edge:
        return -target
    if int(edge / h) + 1 >= size:
        return math.nan
    total = -2.0 * bodies.stress * solid.compliance * (edge - radius) - target
    if count > 0:
        near, beyond = _weights(edge, radius, count * h)
        total += near * -solid.compliance * _pull(bodies.stress, edge, radius) + beyond * nodes[REST_, count]
    # Elements that leave within the step have the impulse of a broken line.
    left = min(max(counts[IN_], count), int(edge / h) + 2)
    for i in range(count, left):
        _element(solid, dt, depth, i, room)
    if count < counts[WEIGHED_]:
        _weigh(bodies, edge, count, room)
    base, rest, near_of, beyond_of = nodes[BASE_], nodes[REST_], nodes[NEAR_], nodes[NEXT_]
    for i in range(left, min(int(edge / h) + 2, size)):
        rest[i] = base[i] - depth
    k = count
    while k * h < edge:
        total += near_of[k] * rest[k] + beyond_of[k] * rest[k + 1]
        k += 1
    return total


@compiled
def _root(
    solid: Solid, bodies: Bodies, in_time: bool, fixed: float, bounds: tuple[float, float, float, float], room: Room
) -> float:
    """Return the length of a step, or the edge at its end, at which G vanishes between bounds of other sign.

    The bounds are the lower one and G there, the upper one and G there. The method is that of Anderson and Bjorck.
    """
    low, f_low, high, f_high = bounds
    small = 1e-13 * (bodies.reach + abs(room.now[D_]))
    x, side = low, 0
    for n in range(_MOST_ROOTS):
        x = (low * f_high - high * f_low) / (f_high - f_low)
        if n == 0 and in_time and low < room.ends[LAST_] < high:
            x = room.ends[LAST_]
        if not min(low, high) < x < max(low, high) or n % 16 == 15:
            x = 0.5 * (low + high)
        f = _excess(solid, bodies, x, fixed, room) if in_time else _excess(solid, bodies, fixed, x, room)
        if abs(f) <= small or abs(high - low) <= 1e-15 * abs(x):
            break
        if (f > 0.0) == (f_high > 0.0):
            if side == 1:
                share = 1.0 - f / f_high
                f_low *= share if share > 0.0 else 0.5
            high, f_high, side = x, f, 1
        else:
            if side == -1:
                share = 1.0 - f / f_low
                f_high *= share if share > 0.0 else 0.5
            low, f_low, side = x, f, -1
    return x


@inlined
def _spent(rate: float, before: float, after: float, slope: float, decay: float, dt: float) -> float:
    """Return the integral of (q - r M)^2 over a step with a linear load, from its values at both ends."""
    if rate * dt < _LINEAR:
        return dt * (before * before + before * after + after * after) / 3.0
    steady = slope / rate
    rest = before - steady
    return steady * steady * dt + rest * (1.0 - decay) * (2.0 * steady + 0.5 * rest * (1.0 + decay)) / rate


@compiled
def _remember(solid: Solid, dt: float, top: int, room: Room) -> float:
    """Take the memory of elements over a step; return what they dissipate, with half the element at the axis."""
    nodes = room.nodes
    lost, load, press = nodes[LOST_], nodes[Q_], nodes[P_]
    load1, press1, bump = nodes[Q1_], nodes[P1_], nodes[BUMP_]
    for i in range(top):
        lost[i] = 0.0
    for k in range(solid.rates.shape[0]):
        factors, memory, rate, weight = room.factors[k], room.memory[k], solid.rates[k], solid.weights[k]
        decay, fall, rise, mean = factors[DECAY_], factors[FALL_], factors[RISE_], factors[MEAN_] / dt
        for i in range(top):
            before, after, old = load[i] + press[i], load1[i] + press1[i], memory[i]
            new = decay * old + fall * before + rise * after + mean * bump[i]
            memory[i] = new
            slope = (after - before) / dt
            lost[i] += weight * _spent(rate, before - rate * old, after - rate * new, slope, decay, dt)
    total = -0.5 * lost[0]
    for i in range(top):
        total += lost[i]
    return total


@compiled
def _accept(solid: Solid, bodies: Bodies, dt: float, edge: float, room: Room) -> None:
    """Take a step to its end: all elements, motion and energies."""
    now, counts, nodes, h = room.now, room.counts, room.nodes, bodies.cell
    _excess(solid, bodies, dt, edge, room)
    count, depth = counts[IN1_], room.ends[DEPTH_NOW_]
    top = max(counts[TOP_], int(max(edge, now[C_]) / h) + 2)
    counts[TOP_] = top = min(top, nodes.shape[1])
    _bases(solid, dt, 0, top, room)
    for i in range(top):
        _element(solid, dt, depth, i, room)
        if (i < count) != (nodes[P1_, i] > 0.0):
            counts[ASTRAY_] += 1
    radius = _contact_radius(solid, bodies, room)
    force = _force(bodies, edge, radius, room)
    if dt > 0.0:
        now[VISCOUS_] += 2.0 * h * _remember(solid, dt, top, room)
    for i in range(top):
        nodes[P_, i], nodes[H_, i], nodes[Q_, i] = nodes[P1_, i], nodes[H1_, i], nodes[Q1_, i]
    if not bodies.sprung:
        now[V_] -= 0.5 * dt * (now[F_] + force) / bodies.mass
    elif dt > 0.0:
        now[V_] = (depth - now[D_]) / dt
    now[T_] += dt
    now[D_], now[F_], now[C_], now[A_] = depth, force, edge, min(radius, edge)
    counts[IN_] = count
    room.ends[MADE_] = math.nan
    if dt > 0.0:
        room.ends[LAST_] = dt


@compiled
def _neighbour(edge: float, way: int, h: float) -> float:
    """Return the next element from an edge in a direction."""
    place = edge / h
    if way > 0:
        return (math.floor(place + 1e-9) + 1.0) * h
    return max(math.ceil(place - 1e-9) - 1.0, 0.0) * h


@compiled
def _jump(solid: Solid, bodies: Bodies, way: int, room: Room) -> int:
    """Let the edge jump to where G vanishes again, at fixed depth or base or force, and keep the energy.

    A force may take the body away. What energy it has then depends on how far it goes, so that the march ends.
    """
    now, h = room.now, bodies.cell
    edge, excess, energy = now[C_], 0.0, 0.0
    before, start_edge, start_radius, start_depth = 0.0, edge, now[A_], now[D_]
    free = bodies.sprung and bodies.stiffness == 0.0
    if free:
        before = _surface_energy(solid, bodies, room)
    limit = (room.nodes.shape[1] - 3) * h
    after = edge
    while True:
        after = _neighbour(edge, way, h)
        if after > limit:
            return NO_ROOM
        f = _excess(solid, bodies, 0.0, after, room)
        if way * f >= 0.0:
            if edge == start_edge:
                excess = _excess(solid, bodies, 0.0, edge, room)
            if way * excess < 0.0:
                after = _root(solid, bodies, False, 0.0, (edge, excess, after, f), room)
                f = 0.0
            energy += 0.5 * abs(after - edge) * abs(edge * excess + after * f)
            break
        energy += 0.5 * abs(after - edge) * abs(edge * excess + after * f)
        edge, excess = after, f
        if edge == 0.0:
            break
    energy *= 4.0 * bodies.stress
    away = free and after == 0.0
    if not away:
        _accept(solid, bodies, 0.0, after, room)
        if free:
            # Not all edges on the way have a depth that bears the force.
            energy = before - _surface_energy(solid, bodies, room) + bodies.load * (now[D_] - start_depth)
        now[JUMPS_] += energy
    n = room.counts[JUMPED_]
    if n < room.jumps.shape[0]:
        row = room.jumps[n]
        row[AT_], row[DEPTH_], row[EDGE_], row[RADIUS_] = now[T_], start_depth, start_edge, start_radius
        row[EDGE1_], row[RADIUS1_], row[ENERGY_], row[DEPTH1_] = now[C_], now[A_], energy, now[D_]
        if away:
            row[EDGE1_], row[RADIUS1_], row[ENERGY_], row[DEPTH1_] = 0.0, 0.0, math.nan, -math.inf
    room.counts[JUMPED_] = n + 1
    room.counts[SOUGHT_] = 0
    return SEPARATED if away else -1


@compiled
def _fold(solid: Solid, bodies: Bodies, way: int, after: float, room: Room) -> float:
    """Return the edge on the way to another one at which way times G is largest, up to where the edge is held."""
    low, high = room.now[C_], after
    half = way * _excess(solid, bodies, 0.0, 0.5 * (low + high), room)
    end = way * _excess(solid, bodies, 0.0, high, room)
    bend, slope = 2.0 * (end - 2.0 * half), 4.0 * half - end
    if not slope > 0.0 or bend >= 0.0:
        part, most = 0.5, math.nan
    else:
        part = min(-0.5 * slope / bend, 1.0)
        most = part * (slope + part * bend)
        if part <= _AT_FOLD:
            return low
        if abs(way * _excess(solid, bodies, 0.0, low + part * (high - low), room) - most) < _PARABOLIC * most:
            return low + part * (high - low)
    # A contact smaller than a cell has a cusp.
    share = 0.5 * (math.sqrt(5.0) - 1.0)
    one, two = high - share * (high - low), low + share * (high - low)
    f_one, f_two = way * _excess(solid, bodies, 0.0, one, room), way * _excess(solid, bodies, 0.0, two, room)
    for _ in range(_SECTIONS):
        if f_one < f_two:
            low, one, f_one = one, two, f_two
            two = low + share * (high - low)
            f_two = way * _excess(solid, bodies, 0.0, two, room)
        else:
            high, two, f_two = two, one, f_one
            one = high - share * (high - low)
            f_one = way * _excess(solid, bodies, 0.0, one, room)
    return 0.5 * (low + high)


@compiled
def _step(solid: Solid, bodies: Bodies, room: Room) -> int:
    """Take one step, or a jump; return -1, or the reason of an end."""
    now, counts, h = room.now, room.counts, bodies.cell
    edge, longest = now[C_], bodies.longest
    if edge == 0.0:
        excess = _excess(solid, bodies, longest, 0.0, room)
        if excess >= 0.0:
            _accept(solid, bodies, longest, 0.0, room)
            return -1
        start = _excess(solid, bodies, 0.0, 0.0, room)
        if start > 0.0:
            dt = _root(solid, bodies, True, 0.0, (0.0, start, longest, excess), room)
            _accept(solid, bodies, dt, 0.0, room)
        return _jump(solid, bodies, 1, room)
    way = 1 if counts[WAY_] >= 0 else -1
    stay, after, ahead = math.nan, edge, 0.0
    for attempt in range(2):
        after = _neighbour(edge, way, h)
        if after > (room.nodes.shape[1] - 3) * h:
            return NO_ROOM
        ahead = _excess(solid, bodies, longest, after, room)
        if way * ahead < 0.0:
            break
        if attempt == 0:
            stay = _excess(solid, bodies, longest, edge, room)
            if way * stay > 0.0:
                way = -way
                continue
        counts[WAY_] = way
        after = _root(solid, bodies, False, longest, (edge, stay, after, ahead), room) if stay != 0.0 else edge
        _accept(solid, bodies, longest, after, room)
        counts[SOUGHT_] = 0
        return -1
    counts[WAY_] = way
    start = _excess(solid, bodies, 0.0, after, room)
    if way * start <= 0.0:
        if counts[SOUGHT_] >= _MOST_FOLDS:
            return _jump(solid, bodies, way, room)
        after = _fold(solid, bodies, way, after, room)
        if after == edge:
            return _jump(solid, bodies, way, room)
        start = _excess(solid, bodies, 0.0, after, room)
        ahead = _excess(solid, bodies, longest, after, room)
        counts[SOUGHT_] += 1
        if not (way * start > 0.0 > way * ahead):
            return _jump(solid, bodies, way, room)
    else:
        counts[SOUGHT_] = 0
    dt = _root(solid, bodies, True, after, (0.0, start, longest, ahead), room)
    _accept(solid, bodies, dt, after, room)
    return -1


@compiled
def _surface_energy(solid: Solid, bodies: Bodies, room: Room) -> float:
    """Return the energy of surface and attraction over that far apart."""
    nodes, h, edge, total = room.nodes, bodies.cell, room.now[C_], 0.0
    for i in range(room.counts[TOP_]):
        load = nodes[Q_, i] + nodes[P_, i]
        part = solid.compliance * load * load
        for k in range(solid.rates.shape[0]):
            part += solid.weights[k] * solid.rates[k] * room.memory[k, i] ** 2
        part -= 2.0 * nodes[Q_, i] * nodes[H_, i]
        total += (0.5 if i == 0 else 1.0) * part
    return h * total - math.pi * bodies.stress * bodies.reach * edge * edge


@inlined
def _energy(solid: Solid, bodies: Bodies, room: Room) -> float:
    """Return the energy of body, surface and attraction over that of rest far apart."""
    return _surface_energy(solid, bodies, room) + 0.5 * bodies.mass * room.now[V_] * room.now[V_]


@inlined
def _is_apart(solid: Solid, room: Room) -> bool:
    """Return whether the body leaves faster than the surface may follow."""
    speed = 0.0
    for k in range(solid.rates.shape[0]):
        speed += abs(solid.weights[k] * solid.rates[k] * room.memory[k, 0])
    return room.now[C_] == 0.0 and -room.now[V_] > speed


@inlined
def _record(room: Room) -> bool:
    """Write a row of the motion; return whether there was room for it."""
    n = room.counts[STEPS_]
    if n >= room.motion.shape[0]:
        return False
    for m in range(N_NOW):
        room.motion[n, m] = room.now[m]
    room.counts[STEPS_] = n + 1
    return True


@inlined
def _begin(bodies: Bodies, room: Room) -> None:
    """Write the state at the first attraction."""
    room.now[D_], room.ends[MADE_] = -bodies.reach, math.nan
    room.counts[WEIGHED_] = room.nodes.shape[1]
    for i in range(room.nodes.shape[1]):
        room.nodes[H_, i] = room.nodes[G_, i] + bodies.reach


@inlined
def _with_line(bodies: Bodies, knots: Any, values: Any, now: float, k: int) -> Bodies:
    """Return the bodies with the load of a line from a time on, and no step beyond its end."""
    pace = (values[k + 1] - values[k]) / (knots[k + 1] - knots[k])
    return Bodies(
        bodies.stress, bodies.reach, bodies.mass, bodies.cell, min(bodies.longest, knots[k + 1] - now), bodies.sprung,
        bodies.stiffness, values[k] + pace * (now - knots[k]), pace,
    )  # fmt: skip


@entry_point
def march(solid: Solid, bodies: Bodies, velocity: float, most: int, room: Room) -> int:
    """Follow the body from the first attraction, at the depth -h0, until it has left or is held.

    After a number of steps the status is PAUSED, and the next call goes on. Energy only falls, and a body that has
    left has its kinetic energy at least: with less than none it is held.
    """
    now, counts, ends = room.now, room.counts, room.ends
    least = -_SURE * 0.5 * bodies.mass * velocity * velocity
    status = -1
    if counts[STEPS_] == 0:
        now[V_] = velocity
        _begin(bodies, room)
        status = _jump(solid, bodies, 1, room)
    stop = counts[STEPS_] + most
    while status < 0:
        n = counts[STEPS_]
        if n >= stop:
            return PAUSED
        if not _record(room):
            status = TOO_LONG
            break
        if not math.isfinite(now[F_]):
            status = STUCK
        elif counts[ASTRAY_] > 0:
            status = NOT_DISC
        elif _is_apart(solid, room):
            status = SEPARATED
        elif n % _OFTEN == 0 and _energy(solid, bodies, room) < least:
            status = HELD
        else:
            status = _step(solid, bodies, room)
    ends[LEFT_] = _energy(solid, bodies, room)
    return HELD if status == TOO_LONG and ends[LEFT_] < 0.0 else status


@entry_point
def follow(solid: Solid, bodies: Bodies, knots: Any, values: Any, most: int, room: Room) -> int:
    """Follow a program from the first attraction on, of straight lines between knots: of a depth, or of a load.

    After a number of steps the status is PAUSED, and the next call goes on. HELD means that the surfaces attract each
    other at the end. A force that takes the body away ends the program.
    """
    now, counts, ends = room.now, room.counts, room.ends
    status, last = -1, knots.shape[0] - 1
    by_force = bodies.sprung and bodies.stiffness == 0.0
    if counts[STEPS_] == 0:
        _begin(bodies, room)
        now[T_] = knots[0]
        _record(room)
        if by_force:
            status = _jump(solid, _with_line(bodies, knots, values, now[T_], 0), 1, room)
            _record(room)
    small = _ROUNDING * (knots[last] - knots[0])
    stop = counts[STEPS_] + most
    while status < 0 and counts[LINE_] < last:
        k = counts[LINE_]
        if not knots[k + 1] - now[T_] > small:
            counts[LINE_] += 1
            continue
        if counts[STEPS_] >= stop:
            return PAUSED
        if not bodies.sprung:
            now[V_] = (values[k + 1] - values[k]) / (knots[k + 1] - knots[k])
        status = _step(solid, _with_line(bodies, knots, values, now[T_], k), room)
        if status >= 0:
            break
        if not _record(room):
            status = TOO_LONG
        elif not math.isfinite(now[F_]):
            status = STUCK
        elif counts[ASTRAY_] > 0:
            status = NOT_DISC
    ends[LEFT_] = _surface_energy(solid, bodies, room)
    if status >= 0:
        return status
    return SEPARATED if now[C_] == 0.0 else HELD
