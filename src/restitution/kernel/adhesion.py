"""Impact with adhesion: a Dugdale zone on independent elements with memory.

A constant attraction acts where the gap is below its range. Element x has the load q and the displacement W of the
surface, ``W = J0 q + sum c_j M_j`` with ``M_j' = q - r_j M_j``. Its gap is ``H = W - d + g(x)``. Within the edge c of
the zone the load is ``q = -2 sigma sqrt(c^2 - x^2) + p``. Each element has either p = 0, and is loaded, or H = 0, and
follows the body with p > 0; those that follow have x < a. One equation gives c, where the gap is the range h0:

    G = int_a^c H/sqrt(c^2 - x^2) dx - pi h0/2 = 0,    dG/dc > 0.

At fixed depth the energy has the derivative 4 sigma c G over c. Where dG/dc falls to 0, the edge jumps down the
slope of the energy to the next root.

A step ends where c reaches an element, or after the longest step. The load is linear over a step in the memory, with
two corrections of its impulse: c^2 is linear, and an element that touches or leaves within the step does so where a
line and the cohesive load have the gap, or the contact load, zero. The scheme is of second order, also at the fronts.
"""

import math
from typing import Any

from restitution.kernel.compile import compiled, entry_point, inlined
from restitution.kernel.course import arrival, arrive, hurries, move, root
from restitution.kernel.dissipation import ROUNDED, remember, take_ring
from restitution.kernel.edge import excess
from restitution.kernel.waiting import carry, rest, waiting_energy
from restitution.kernel.zone import (
    A_,
    ASTRAY_,
    AT_,
    BASE_,
    BEFORE_,
    BUMP_,
    C_,
    D_,
    DEPTH1_,
    DEPTH_,
    DEPTH_NOW_,
    EDGE1_,
    EDGE_,
    ENERGY_,
    F_,
    G_,
    H1_,
    H_,
    HELD,
    IN1_,
    IN_,
    INSIDE_,
    JUMPED_,
    JUMPS_,
    LAST_,
    LEFT_,
    LINE_,
    LOW_,
    MADE_,
    N_NOW,
    NO_ROOM,
    NOT_DISC,
    P1_,
    P_,
    PAUSED,
    PLACE_,
    Q1_,
    Q_,
    RADIUS1_,
    RADIUS_,
    REST_,
    S_MEAN_,
    S_RISE_,
    SEPARATED,
    SHAPE_,
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
    TURNED_,
    V_,
    VISCOUS_,
    WAITS_,
    WAY_,
    WEIGHED_,
    Bodies,
    Room,
    Solid,
    contact_radius,
    count_near,
    normal_force,
    write_bases,
    write_element,
)

_MOST_FOLDS, _SECTIONS = 16, 20
# Share of the way to the next element within which the edge is at a fold; error of a parabola over its height.
_AT_FOLD, _PARABOLIC = 1e-3, 0.1
# G over the range that is no root, where a force leaves no contact.
_TORN = 1e-6
# G over range and depth, without attraction, that is rounding of its root.
_BEGINS = 1e-12
# Share of a step of the edge for a slope.
_ASIDE = 0.02
# Share of a history that is rounding of its times.
_ROUNDING = 1e-12
# Steps between looks at the energy, and its share of the kinetic one by which it is below its bound for sure.
_OFTEN, _SURE = 16, 1e-3
# Turns towards the surface that show a body to be held. Under a force it is also where it creeps: what it lacks to
# balance, over the force, and its kinetic energy over the work of the force.
_TURNS, _UNBALANCED, _CREEPING = 2, 1e-2, 1e-3


@compiled
def _beside_contact(solid: Solid, bodies: Bodies, dt: float, depth: float, low: int, top: int, room: Room) -> int:
    """Write loads and gaps in and beside the contact at the end of a step; return how many elements are astray."""
    nodes, counts, soft = room.nodes, room.counts, solid.compliance + room.ends[S_RISE_]
    press, gap, pull = nodes[P1_, low:top], nodes[H1_, low:top], nodes[Q1_, low:top]
    base, rest = nodes[BASE_, low:top], nodes[REST_, low:top]
    bump, shape = nodes[BUMP_, low:top], nodes[SHAPE_, low:top]
    size, count = top - low, counts[IN1_] - low
    inner, outer = min(counts[IN_] - low, count), min(max(counts[IN_] - low, count), size)
    mean = room.ends[S_MEAN_]
    for i in range(inner):
        bump[i] = 0.0
    for i in range(inner, size):
        bump[i] = shape[i] * dt
    for i in range(size):
        rest[i] = base[i] - depth
    # The whole load of what follows is linear over a step.
    for i in range(inner):
        rest[i] -= mean * (shape[i] * dt)
    # Those that follow before and after, and those that are loaded before and after.
    for i in range(inner):
        press[i], gap[i] = -(rest[i] + solid.compliance * pull[i]) / soft, 0.0
    for i in range(outer, size):
        gap[i], press[i] = rest[i] + solid.compliance * pull[i], 0.0
    for i in range(inner, outer):
        write_element(solid, bodies, dt, depth, low + i, room)
    astray = 0
    for i in range(count):
        astray += 0 if press[i] > -ROUNDED else 1
    for i in range(count, size):
        astray += 0 if press[i] == 0.0 and gap[i] >= -ROUNDED else 1
    return astray


@compiled
def _accept(solid: Solid, bodies: Bodies, dt: float, edge: float, room: Room) -> None:
    """Take a step to its end: all elements, motion and energies."""
    now, counts, nodes = room.now, room.counts, room.nodes
    if room.ends[TRIED_] != dt or room.ends[MADE_] != edge:
        excess(solid, bodies, dt, edge, room)
    count, depth, low, top = counts[IN1_], room.ends[DEPTH_NOW_], counts[LOW_], counts[TOP_]
    ring = min(max(counts[IN_], count) + 1, top)
    write_bases(solid, dt, low, ring, room)
    counts[ASTRAY_] += _beside_contact(solid, bodies, dt, depth, low, ring, room)
    lost = carry(solid, dt, depth - now[D_], room) if dt > 0.0 and counts[WAITS_] > 0 else 0.0
    radius = contact_radius(solid, bodies, edge, room)
    force = normal_force(bodies, edge, radius, depth, room)
    if dt > 0.0:
        now[VISCOUS_] += 2.0 * (lost + remember(solid, dt, low, ring, room))
    for new, old in ((P1_, P_), (H1_, H_), (Q1_, Q_)):
        source, target = nodes[new], nodes[old]
        for i in range(low, ring):
            target[i] = source[i]
    now[VISCOUS_] += 2.0 * take_ring(solid, dt, depth, ring, top, room)
    if not bodies.sprung:
        now[V_] += dt * (bodies.load - 0.5 * (now[F_] + force)) / bodies.mass
    elif dt > 0.0:
        now[V_] = (depth - now[D_]) / dt
    if dt > 0.0:
        ends = room.ends
        ends[BEFORE_], ends[LAST_] = ends[LAST_] if ends[BEFORE_] >= 0.0 else 0.0, dt
        ends[SPEED0_], ends[SPEED_] = ends[SPEED_], (edge - now[C_]) / dt
    now[T_] += dt
    now[D_], now[F_], now[C_], now[A_] = depth, force, edge, min(radius, edge)
    counts[IN_] = count
    room.ends[MADE_] = math.nan
    if counts[WAITS_] > 0:
        rest(solid, bodies, room)


@compiled
def _neighbour(edge: float, way: int, near: int, places: Any) -> float:
    """Return the next element from an edge in a direction; about so many elements lie below it."""
    n = count_near(places, edge, near)
    if way > 0:
        return places[n + 1] if places[n] - edge <= 1e-9 * (places[n + 1] - places[n]) else places[n]
    if n > 1 and edge - places[n - 1] <= 1e-9 * (places[n - 1] - places[n - 2]):
        n -= 1
    return places[max(n - 1, 0)]


@compiled
def _jump(solid: Solid, bodies: Bodies, way: int, room: Room) -> int:
    """Let the edge jump to where G vanishes again, at fixed depth or base or force, and keep the energy.

    A force may take the body away. What energy it has then depends on how far it goes, so that the march ends.
    """
    now, places = room.now, room.nodes[PLACE_]
    edge, above, energy = now[C_], 0.0, 0.0
    before, start_edge, start_radius, start_depth = 0.0, edge, now[A_], now[D_]
    free = bodies.sprung and bodies.stiffness == 0.0
    if free:
        before = _surface_energy(solid, bodies, room)
    limit = places[places.shape[0] - 3]
    after = edge
    while True:
        after = _neighbour(edge, way, room.counts[INSIDE_], places)
        if after > limit:
            return NO_ROOM
        if edge == start_edge:
            above = excess(solid, bodies, 0.0, edge, room)
        middle = 0.5 * (edge + after)
        inside = excess(solid, bodies, 0.0, middle, room)
        f = excess(solid, bodies, 0.0, after, room)
        there = way * f >= 0.0
        if there and way * above < 0.0:
            after = root(solid, bodies, False, 0.0, (edge, above, after, f), room)
            f, middle = 0.0, 0.5 * (edge + after)
            inside = excess(solid, bodies, 0.0, middle, room)
        elif there:
            above = 0.0
        energy += abs(after - edge) * abs(edge * above + 4.0 * middle * inside + after * f) / 6.0
        if there:
            break
        if not bodies.sprung:
            # Elements have no memory of the way: those that it has passed need not be asked again.
            _accept(solid, bodies, 0.0, after, room)
        edge, above = after, f
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
    room.counts[SOUGHT_], room.ends[BEFORE_] = 0, -1.0
    return SEPARATED if away else -1


@compiled
def _fold(solid: Solid, bodies: Bodies, way: int, after: float, room: Room) -> float:
    """Return the edge on the way to another one at which way times G is largest, up to where the edge is held."""
    low, high = room.now[C_], after
    half = way * excess(solid, bodies, 0.0, 0.5 * (low + high), room)
    end = way * excess(solid, bodies, 0.0, high, room)
    bend, slope = 2.0 * (end - 2.0 * half), 4.0 * half - end
    if not slope > 0.0 or bend >= 0.0:
        part, most = 0.5, math.nan
    else:
        part = min(-0.5 * slope / bend, 1.0)
        most = part * (slope + part * bend)
        if part <= _AT_FOLD:
            return low
        if abs(way * excess(solid, bodies, 0.0, low + part * (high - low), room) - most) < _PARABOLIC * most:
            return low + part * (high - low)
    # A contact smaller than a cell has a cusp.
    share = 0.5 * (math.sqrt(5.0) - 1.0)
    left, right = high - share * (high - low), low + share * (high - low)
    f_left, f_right = way * excess(solid, bodies, 0.0, left, room), way * excess(solid, bodies, 0.0, right, room)
    for _ in range(_SECTIONS):
        if f_left < f_right:
            low, left, f_left = left, right, f_right
            right = low + share * (high - low)
            f_right = way * excess(solid, bodies, 0.0, right, room)
        else:
            high, right, f_right = right, left, f_left
            left = high - share * (high - low)
            f_left = way * excess(solid, bodies, 0.0, left, room)
    return 0.5 * (low + high)


@compiled
def _apart(solid: Solid, bodies: Bodies, room: Room) -> int:
    """Take one step without attraction, which ends where it begins, or the jump with which it begins."""
    dt = bodies.longest
    above = excess(solid, bodies, dt, 0.0, room)
    if above < 0.0:
        start = excess(solid, bodies, 0.0, 0.0, room)
        if start <= _BEGINS * (bodies.reach + abs(room.now[D_])):
            return _jump(solid, bodies, 1, room)
        dt = root(solid, bodies, True, 0.0, (0.0, start, dt, above), room)
    _accept(solid, bodies, dt, 0.0, room)
    return -1


@compiled
def _is_lost(solid: Solid, bodies: Bodies, way: int, dt: float, after: float, room: Room) -> bool:
    """Return whether the root of G at the end of a step is not that of the edge, but one behind a fold.

    A force may also leave no contact at that edge, where G has no root. Steps that become shorter show a fold of
    a depth; a contact that vanishes on a spring or under a force has a cusp instead.
    """
    if bodies.sprung and bodies.stiffness == 0.0:
        if abs(excess(solid, bodies, dt, after, room)) > _TORN * bodies.reach:
            return True
    elif not bodies.sprung and not hurries(dt, after, room):
        return False
    return way * excess(solid, bodies, dt, after + _ASIDE * (room.now[C_] - after), room) > 0.0


@compiled
def _end(solid: Solid, bodies: Bodies, way: int, dt: float, after: float, room: Room) -> int:
    """End a step where the edge reaches an element after a time, or at a fold before it, or jump; return -1."""
    edge, longest, tries = room.now[C_], bodies.longest, 0
    while _is_lost(solid, bodies, way, dt, after, room):
        # The edge was let go on its way.
        after = 0.5 * (edge + after) if tries > 0 else _fold(solid, bodies, way, after, room)
        start = excess(solid, bodies, 0.0, after, room)
        ahead = excess(solid, bodies, longest, after, room)
        if not (way * start > 0.0 > way * ahead) or abs(after - edge) < _AT_FOLD * bodies.cell:
            return _jump(solid, bodies, way, room)
        dt = root(solid, bodies, True, after, (0.0, start, longest, ahead), room)
        tries += 1
    _accept(solid, bodies, dt, after, room)
    return -1


@compiled
def _search(solid: Solid, bodies: Bodies, way: int, room: Room) -> int:
    """Take one step to either side, or a jump; return -1, or the reason of an end."""
    counts, places, edge, longest = room.counts, room.nodes[PLACE_], room.now[C_], bodies.longest
    stay, after, ahead = math.nan, edge, 0.0
    for attempt in range(2):
        after = _neighbour(edge, way, counts[INSIDE_], places)
        if after > places[places.shape[0] - 3]:
            return NO_ROOM
        ahead = excess(solid, bodies, longest, after, room)
        if way * ahead < 0.0:
            break
        if attempt == 0:
            stay = excess(solid, bodies, longest, edge, room)
            if way * stay > 0.0:
                way = -way
                continue
        counts[WAY_] = way
        after = root(solid, bodies, False, longest, (edge, stay, after, ahead), room) if stay != 0.0 else edge
        _accept(solid, bodies, longest, after, room)
        counts[SOUGHT_] = 0
        return -1
    counts[WAY_] = way
    start = excess(solid, bodies, 0.0, after, room)
    if way * start <= 0.0:
        if counts[SOUGHT_] >= _MOST_FOLDS:
            return _jump(solid, bodies, way, room)
        after = _fold(solid, bodies, way, after, room)
        if after == edge:
            return _jump(solid, bodies, way, room)
        start = excess(solid, bodies, 0.0, after, room)
        ahead = excess(solid, bodies, longest, after, room)
        counts[SOUGHT_] += 1
        if not (way * start > 0.0 > way * ahead):
            return _jump(solid, bodies, way, room)
    else:
        counts[SOUGHT_] = 0
    dt = root(solid, bodies, True, after, (0.0, start, longest, ahead), room)
    return _end(solid, bodies, way, dt, after, room)


@compiled
def step_zone(solid: Solid, bodies: Bodies, room: Room) -> int:
    """Take one step, or a jump; return -1, or the reason of an end."""
    edge, counts, places = room.now[C_], room.counts, room.nodes[PLACE_]
    if edge == 0.0:
        return _apart(solid, bodies, room)
    way = 1 if counts[WAY_] >= 0 else -1
    after = _neighbour(edge, way, counts[INSIDE_], places)
    if after > places[places.shape[0] - 3]:
        return NO_ROOM
    if not bodies.sprung:
        dt = arrival(way, after, room)
        if dt < bodies.longest:
            dt = arrive(solid, bodies, way, after, dt, room)
            if not math.isnan(dt):
                counts[SOUGHT_] = 0
                return _end(solid, bodies, way, dt, after, room)
        else:
            after = move(solid, bodies, way, after, room)
            if not math.isnan(after):
                counts[SOUGHT_] = 0
                _accept(solid, bodies, bodies.longest, after, room)
                return -1
    return _search(solid, bodies, way, room)


@compiled
def _surface_energy(solid: Solid, bodies: Bodies, room: Room) -> float:
    """Return the energy of surface and attraction over that far apart."""
    nodes, edge, total = room.nodes, room.now[C_], waiting_energy(solid, room)
    for i in range(room.counts[LOW_], room.counts[TOP_]):
        load = nodes[Q_, i] + nodes[P_, i]
        part = solid.compliance * load * load
        for k in range(solid.rates.shape[0]):
            part += solid.weights[k] * solid.rates[k] * room.memory[k, i] ** 2
        part -= 2.0 * nodes[Q_, i] * nodes[H_, i]
        total += nodes[SHARE_, i] * part
    return total - math.pi * bodies.stress * bodies.reach * edge * edge


@inlined
def _energy(solid: Solid, bodies: Bodies, room: Room) -> float:
    """Return the energy of body, surface and attraction over that of rest far apart, without that of the load."""
    return _surface_energy(solid, bodies, room) + 0.5 * bodies.mass * room.now[V_] * room.now[V_]


@inlined
def _is_held(solid: Solid, bodies: Bodies, kinetic: float, floor: float, room: Room) -> bool:
    """Return whether the body cannot leave: it was pulled back, creeps under a force, or has too little energy.

    An elastic body that is pulled back swings for ever, with more energy than it needs far apart.
    """
    n, now = room.counts[STEPS_] - 1, room.now
    if n > 0 and now[C_] > 0.0:
        if room.motion[n - 1, V_] < 0.0 <= now[V_]:
            room.counts[TURNED_] += 1
        balanced = abs(now[F_] - bodies.load) < _UNBALANCED * bodies.load
        work = bodies.load * (now[D_] + bodies.reach)
        if room.counts[TURNED_] >= _TURNS or (balanced and 0.5 * bodies.mass * now[V_] ** 2 < _CREEPING * work):
            return True
    return n % _OFTEN == 0 and _is_short(solid, bodies, kinetic, floor, room)


@inlined
def _is_short(solid: Solid, bodies: Bodies, kinetic: float, floor: float, room: Room) -> bool:
    """Return whether the energy is below a bound, by what was lost since the start and by the state of the surface.

    The surface may exchange a hundred times the energy of the body, so that its share has errors of that size.
    """
    now = room.now
    if not kinetic - now[VISCOUS_] - now[JUMPS_] < floor:
        return False
    return _energy(solid, bodies, room) - bodies.load * (now[D_] + bodies.reach) < floor


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
def _record_or_fail(room: Room) -> int:
    """Record a step; return the status of a march that cannot go on from it, or -1."""
    if not _record(room):
        return TOO_LONG
    if not math.isfinite(room.now[F_]):
        return STUCK
    return NOT_DISC if room.counts[ASTRAY_] > 0 else -1


@inlined
def _begin(bodies: Bodies, room: Room) -> None:
    """Write the state at the first attraction."""
    room.now[D_], room.ends[MADE_], room.ends[SPEED_] = -bodies.reach, math.nan, math.inf
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
def march(solid: Solid, bodies: Bodies, velocity: float, floor: float, most: int, room: Room) -> int:
    """Follow the body from the first attraction, at the depth -h0, until it has left or is held.

    After a number of steps the status is PAUSED, and the next call goes on. Energy only falls. `floor` is the least
    that a body which leaves may have, with that of the load from the start on; with less it is held.
    """
    now, counts, ends = room.now, room.counts, room.ends
    kinetic = 0.5 * bodies.mass * velocity * velocity
    least = floor - _SURE * kinetic
    status = -1
    if counts[STEPS_] == 0:
        now[V_] = velocity
        _begin(bodies, room)
        status = _jump(solid, bodies, 1, room)
    stop = counts[STEPS_] + most
    while status < 0:
        if counts[STEPS_] >= stop:
            return PAUSED
        status = _record_or_fail(room)
        if status >= 0:
            break
        if _is_apart(solid, room):
            status = SEPARATED
        elif _is_held(solid, bodies, kinetic, least, room):
            status = HELD
        else:
            status = step_zone(solid, bodies, room)
    ends[LEFT_] = _energy(solid, bodies, room)
    if status == TOO_LONG and _is_short(solid, bodies, kinetic, floor, room):
        return HELD
    return status


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
        status = step_zone(solid, _with_line(bodies, knots, values, now[T_], k), room)
        if status >= 0:
            break
        status = _record_or_fail(room)
    ends[LEFT_] = _surface_energy(solid, bodies, room)
    if status >= 0:
        return status
    return SEPARATED if now[C_] == 0.0 else HELD
