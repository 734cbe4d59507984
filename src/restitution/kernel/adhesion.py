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
# load, gap, cohesive load, gap without the displacement J0 q, impulse beyond that of a linear load.
G_, P_, H_, Q_, P1_, H1_, Q1_, REST_, BUMP_, N_NODES = range(10)
# Columns of `factors` of a mode over a step: decay; impulse of a load that falls, that rises, and of a constant.
DECAY_, FALL_, RISE_, MEAN_, N_FACTORS = range(5)
# Members of `now`, and columns of `motion`: time, depth, velocity, force, edge of the zone, contact radius, energies
# dissipated and lost in jumps.
T_, D_, V_, F_, C_, A_, VISCOUS_, JUMPS_, N_NOW = range(9)
# Columns of `jumps`: time, depth, edge and contact radius before and after, energy.
(AT_, DEPTH_, EDGE_, RADIUS_, EDGE1_, RADIUS1_, ENERGY_, N_JUMP) = range(8)
# Members of `counts`: elements that follow at the start and at the end of a step, elements that may have memory,
# rows of `motion`, jumps, direction of the last step of c, whether that sought a fold, elements astray from the disc.
IN_, IN1_, TOP_, STEPS_, JUMPED_, WAY_, SOUGHT_, ASTRAY_, N_COUNTS = range(9)
# Members of `ends`: sums over the modes of c_j FALL, c_j RISE, and c_j MEAN over the step; energy at the end.
S_FALL_, S_RISE_, S_MEAN_, LEFT_, N_ENDS = range(5)
SEPARATED, HELD, NO_ROOM, TOO_LONG, STUCK, NOT_DISC = range(6)

_MOST_ROOTS = 80
# Rate times step below which factors are series, and below which the rate of a mode is linear over a step.
_SERIES, _LINEAR = 2e-2, 1e-3
# Share of a history that is rounding of its times.
_ROUNDING = 1e-12
# Steps between looks at the energy, and its share of the kinetic one by which it is below zero for sure.
_OFTEN, _SURE = 16, 1e-3


class Solid(NamedTuple):
    """Inverse of the relaxation modulus, ``1/E*(p) = J0 + sum c_j/(p + r_j)``."""

    compliance: float
    weights: Any  # (K,): c_j
    rates: Any  # (K,): r_j


class Bodies(NamedTuple):
    """Numbers of the impact apart from the solid."""

    stress: float
    reach: float  # range h0 of the attraction
    mass: float
    cell: float  # distance of elements
    longest: float  # step


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


@compiled
def _element(solid: Solid, bodies: Bodies, dt: float, edge: float, depth: float, i: int, room: Room) -> None:
    """Write load and gap of one element at the end of a step."""
    nodes, ends, x = room.nodes, room.ends, i * bodies.cell
    pull = _pull(bodies.stress, edge, x)
    bump = _bump(nodes[Q_, i], pull, x, room.now[C_], edge, dt)
    rest = nodes[G_, i] - depth + ends[S_FALL_] * (nodes[Q_, i] + nodes[P_, i]) + ends[S_MEAN_] * bump
    for k in range(solid.rates.shape[0]):
        rest += solid.weights[k] * room.factors[k, DECAY_] * room.memory[k, i]
    rest += ends[S_RISE_] * pull
    soft, press, before = solid.compliance + ends[S_RISE_], 0.0, nodes[P_, i]
    gap = rest + solid.compliance * pull
    if before > 0.0:
        press = -gap / soft
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
        press = -gap / (soft - ends[S_MEAN_] * part)
        bump -= press * part
        gap = 0.0
    nodes[P1_, i], nodes[H1_, i], nodes[Q1_, i] = press, gap, pull
    nodes[REST_, i], nodes[BUMP_, i] = rest, bump


@compiled
def _contact_radius(solid: Solid, bodies: Bodies, edge: float, room: Room) -> float:
    """Return a from the last element that follows and the first that is loaded."""
    count, nodes, h = room.counts[IN1_], room.nodes, bodies.cell
    if count == 0:
        return 0.0
    press = nodes[P1_, count - 1]
    ahead = nodes[H1_, count] / (solid.compliance + room.ends[S_RISE_])
    inner, outer = (count - 1) * h, count * h
    square = inner * inner + (outer - inner) * (outer + inner) * press / (press + ahead)
    return min(math.sqrt(square), edge)


@compiled
def _excess(solid: Solid, bodies: Bodies, dt: float, edge: float, room: Room) -> float:
    """Return G after a step with the zone up to `edge`; the elements from the contact to the edge are written."""
    now, counts, nodes, h = room.now, room.counts, room.nodes, bodies.cell
    _set_factors(solid, dt, room)
    depth = now[D_] + dt * (now[V_] - 0.5 * dt * now[F_] / bodies.mass)
    size, count = nodes.shape[1], counts[IN_]
    _element(solid, bodies, dt, edge, depth, count, room)
    if nodes[P1_, count] > 0.0:
        while nodes[P1_, count] > 0.0 and count < size - 2:
            count += 1
            _element(solid, bodies, dt, edge, depth, count, room)
    else:
        while count > 0:
            _element(solid, bodies, dt, edge, depth, count - 1, room)
            if nodes[P1_, count - 1] > 0.0:
                break
            count -= 1
    counts[IN1_] = count
    target = 0.5 * math.pi * bodies.reach
    if edge <= 0.0:
        return 0.5 * math.pi * nodes[REST_, 0] - target
    radius = _contact_radius(solid, bodies, edge, room)
    if radius >= edge:
        return -target
    total = -2.0 * bodies.stress * solid.compliance * (edge - radius) - target
    low, value = radius, -solid.compliance * _pull(bodies.stress, edge, radius)
    k, square = count, edge * edge
    if count == 0:
        value = nodes[REST_, 0]
        k = 1
    root = math.sqrt((edge - low) * (edge + low))
    angle = math.atan2(low, root)
    bend = 0.5 * (square * angle - low * root)
    while low < edge:
        if k != count or count == 0:
            _element(solid, bodies, dt, edge, depth, k, room)
        high, end = k * h, nodes[REST_, k]
        reach = min(high, edge)
        root = math.sqrt(max((edge - reach) * (edge + reach), 0.0))
        angle1 = math.atan2(reach, root)
        bend1 = 0.5 * (square * angle1 - reach * root)
        way = (high - low) * (high + low)
        slope = (end - value) / way if way > 1e-12 * square else 0.0
        total += (value - slope * low * low) * (angle1 - angle) + slope * (bend1 - bend)
        low, value, angle, bend = high, end, angle1, bend1
        k += 1
        if k >= size:
            return math.nan
    return total


@compiled
def _root(
    solid: Solid, bodies: Bodies, in_time: bool, fixed: float, bounds: tuple[float, float, float, float], room: Room
) -> float:
    """Return the length of a step, or the edge at its end, at which G vanishes between bounds of other sign.

    The bounds are the lower one and G there, the upper one and G there.
    """
    low, f_low, high, f_high = bounds
    small = 1e-13 * (bodies.reach + abs(room.now[D_]))
    x, side = low, 0
    for _ in range(_MOST_ROOTS):
        x = (low * f_high - high * f_low) / (f_high - f_low)
        if not min(low, high) < x < max(low, high):
            x = 0.5 * (low + high)
        f = _excess(solid, bodies, x, fixed, room) if in_time else _excess(solid, bodies, fixed, x, room)
        if abs(f) <= small or abs(high - low) <= 1e-15 * abs(x):
            break
        if (f > 0.0) == (f_high > 0.0):
            high, f_high = x, f
            if side == 1:
                f_low *= 0.5
            side = 1
        else:
            low, f_low = x, f
            if side == -1:
                f_high *= 0.5
            side = -1
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
def _accept(solid: Solid, bodies: Bodies, dt: float, edge: float, room: Room) -> None:
    """Take a step to its end: all elements, motion and energies."""
    now, counts, nodes, h = room.now, room.counts, room.nodes, bodies.cell
    _excess(solid, bodies, dt, edge, room)
    count = counts[IN1_]
    depth = now[D_] + dt * (now[V_] - 0.5 * dt * now[F_] / bodies.mass)
    top = max(counts[TOP_], int(max(edge, now[C_]) / h) + 2)
    counts[TOP_] = top = min(top, nodes.shape[1])
    radius = _contact_radius(solid, bodies, edge, room)
    spent, press = 0.0, 0.0
    for i in range(top):
        _element(solid, bodies, dt, edge, depth, i, room)
        before, after = nodes[Q_, i] + nodes[P_, i], nodes[Q1_, i] + nodes[P1_, i]
        lost = 0.0
        for k in range(solid.rates.shape[0]):
            old, factors, rate = room.memory[k, i], room.factors[k], solid.rates[k]
            new = factors[DECAY_] * old + factors[FALL_] * before + factors[RISE_] * after
            new += factors[MEAN_] / dt * nodes[BUMP_, i] if dt > 0.0 else 0.0
            room.memory[k, i] = new
            if dt > 0.0:
                slope = (after - before) / dt
                lost += solid.weights[k] * _spent(
                    rate, before - rate * old, after - rate * new, slope, factors[DECAY_], dt
                )
        spent += (0.5 if i == 0 else 1.0) * lost
        nodes[P_, i], nodes[H_, i], nodes[Q_, i] = nodes[P1_, i], nodes[H1_, i], nodes[Q1_, i]
        if i < count:
            press += (0.5 if i == 0 else 1.0) * nodes[P_, i]
        if (i < count) != (nodes[P_, i] > 0.0):
            counts[ASTRAY_] += 1
    total = h * press
    if count > 0:
        last, inner = nodes[P_, count - 1], (count - 1) * h
        total -= 0.5 * h * last
        total += last * (radius - inner) * (2.0 * radius + inner) / (3.0 * (radius + inner)) if radius > 0.0 else 0.0
    force = 2.0 * total - math.pi * bodies.stress * edge * edge
    now[V_] -= 0.5 * dt * (now[F_] + force) / bodies.mass
    now[T_] += dt
    now[D_], now[F_], now[C_], now[A_] = depth, force, edge, radius
    now[VISCOUS_] += 2.0 * h * spent
    counts[IN_] = count


@compiled
def _neighbour(edge: float, way: int, h: float) -> float:
    """Return the next element from an edge in a direction."""
    place = edge / h
    if way > 0:
        return (math.floor(place + 1e-9) + 1.0) * h
    return max(math.ceil(place - 1e-9) - 1.0, 0.0) * h


@compiled
def _jump(solid: Solid, bodies: Bodies, way: int, room: Room) -> int:
    """Let the edge jump at fixed depth to where G vanishes again, and keep the energy."""
    now, h = room.now, bodies.cell
    edge, excess, energy = now[C_], 0.0, 0.0
    start, start_radius = edge, now[A_]
    limit = (room.nodes.shape[1] - 3) * h
    after = edge
    while True:
        after = _neighbour(edge, way, h)
        if after > limit:
            return NO_ROOM
        f = _excess(solid, bodies, 0.0, after, room)
        if way * f >= 0.0:
            if edge == start:
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
    _accept(solid, bodies, 0.0, after, room)
    now[JUMPS_] += 4.0 * bodies.stress * energy
    n = room.counts[JUMPED_]
    if n < room.jumps.shape[0]:
        row = room.jumps[n]
        row[AT_], row[DEPTH_], row[EDGE_], row[RADIUS_] = now[T_], now[D_], start, start_radius
        row[EDGE1_], row[RADIUS1_], row[ENERGY_] = now[C_], now[A_], 4.0 * bodies.stress * energy
    room.counts[JUMPED_] = n + 1
    room.counts[SOUGHT_] = 0
    return -1


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
        if counts[SOUGHT_] == 1:
            return _jump(solid, bodies, way, room)
        middle = 0.5 * (edge + after)
        half = way * _excess(solid, bodies, 0.0, middle, room)
        end = way * start
        bend = 2.0 * (end - 2.0 * half)
        part = -(4.0 * half - end) / (2.0 * bend) if bend < 0.0 else 0.0
        if not 1e-3 < part < 1.0:
            return _jump(solid, bodies, way, room)
        after = edge + part * (after - edge)
        start = _excess(solid, bodies, 0.0, after, room)
        ahead = _excess(solid, bodies, longest, after, room)
        counts[SOUGHT_] = 1
        if not (way * start > 0.0 > way * ahead):
            return _jump(solid, bodies, way, room)
    else:
        counts[SOUGHT_] = 0
    dt = _root(solid, bodies, True, after, (0.0, start, longest, ahead), room)
    _accept(solid, bodies, dt, after, room)
    return -1


@compiled
def _energy(solid: Solid, bodies: Bodies, room: Room) -> float:
    """Return the energy of body, surface and attraction over that of rest far apart."""
    now, nodes, h = room.now, room.nodes, bodies.cell
    edge, total = now[C_], 0.0
    for i in range(room.counts[TOP_]):
        load = nodes[Q_, i] + nodes[P_, i]
        part = solid.compliance * load * load
        for k in range(solid.rates.shape[0]):
            part += solid.weights[k] * solid.rates[k] * room.memory[k, i] ** 2
        part -= 2.0 * nodes[Q_, i] * nodes[H_, i]
        total += (0.5 if i == 0 else 1.0) * part
    total = h * total - math.pi * bodies.stress * bodies.reach * edge * edge
    return total + 0.5 * bodies.mass * now[V_] * now[V_]


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
    room.now[D_] = -bodies.reach
    for i in range(room.nodes.shape[1]):
        room.nodes[H_, i] = room.nodes[G_, i] + bodies.reach


@entry_point
def march(solid: Solid, bodies: Bodies, velocity: float, room: Room) -> int:
    """Follow the body from the first attraction, at the depth -h0, until it has left or is held.

    Energy only falls, and a body that has left has its kinetic energy at least: with less than none it is held.
    """
    now, counts, ends = room.now, room.counts, room.ends
    now[V_] = velocity
    _begin(bodies, room)
    least = -_SURE * 0.5 * bodies.mass * velocity * velocity
    status = _jump(solid, bodies, 1, room)
    while status < 0:
        n = counts[STEPS_]
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
def follow(solid: Solid, bodies: Bodies, knots: Any, rates: Any, room: Room) -> int:
    """Follow a prescribed depth from the first attraction on, at constant rates between knots.

    The mass of the body is infinite. HELD means that the surfaces attract each other at the end.
    """
    now, counts, ends = room.now, room.counts, room.ends
    _begin(bodies, room)
    now[T_] = knots[0]
    small = _ROUNDING * (knots[-1] - knots[0])
    for k in range(rates.shape[0]):
        now[V_] = rates[k]
        while knots[k + 1] - now[T_] > small:
            if not _record(room):
                return TOO_LONG
            longest = min(bodies.longest, knots[k + 1] - now[T_])
            part = Bodies(bodies.stress, bodies.reach, bodies.mass, bodies.cell, longest)
            status = _step(solid, part, room)
            if status >= 0:
                return status
            if not math.isfinite(now[F_]):
                return STUCK
            if counts[ASTRAY_] > 0:
                return NOT_DISC
    ends[LEFT_] = _energy(solid, Bodies(bodies.stress, bodies.reach, 0.0, bodies.cell, 0.0), room)
    if not _record(room):
        return TOO_LONG
    return SEPARATED if now[C_] == 0.0 else HELD
