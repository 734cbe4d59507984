"""Changes at one instant: panels that change hands, fronts that jump, and loads that jump on a dashpot.

A dashpot in parallel has the load eta d', so that no depth jumps. Where a force jumps, the rate of the depth does: a
larger one is borne by all elements, and a smaller one lets those leave at once whose load would be negative.
"""

import math
from typing import Any

from restitution.kernel.compile import compiled, inlined
from restitution.kernel.driver import (
    APART,
    DEPTH,
    DONE,
    ENDS,
    FOLLOWING,
    FORCE,
    FREE,
    FREE_PANELS,
    FRONT,
    GROWS,
    NO_ROOM,
    PACE,
    PHASE,
    PI,
    PULL,
    RATE,
    RECORDS,
    SHRINKS,
    TIME,
    TOUCHES,
    A,
    D,
    Problem,
    Room,
    Y,
    ahead,
    is_force,
    is_light,
    prescribed_at,
)
from restitution.kernel.fronts import shared_load
from restitution.kernel.growth import at_nodes, differentiate
from restitution.kernel.lever import acceleration
from restitution.kernel.merging import move_panel
from restitution.kernel.panels import (
    FROZEN,
    KINK,
    NODES,
    SMOOTH,
    Scheme,
    Solid,
    gap,
    leave,
    load,
    locate,
    polynomials,
    tail,
    to_coefficients,
    touch,
    value_of,
    write_displacements,
    write_loads,
)
from restitution.kernel.path import radius_and_integral
from restitution.kernel.stepper import surface_at_axis, write_start

_MOST_HALVINGS = 30
# Time since the last elements left, over that in which a panel left, below which they have just left.
_FRESH = 1e-6
# Changes that are not felt, over the tolerance.
_UNFELT = 0.05
# Load that is none, over that of the run.
_NO_LOAD = 1e-14
# Gap that is not felt, over the tolerance, and places within it, over that of its outer end, at which it is compared
# with a multiple of y^2 there; the factor by which it may differ.
_NO_GAP = 1.0
_ROUNDING_OF_GAP = 1e-15
_INNER, _DIFFERENT = (0.9, 0.7, 0.5, 0.35, 0.25, 0.15), 3.0
_MOST_BISECTIONS = 60


@inlined
def smooth_front_at(rule: Scheme, room: Room, i: int) -> float:
    """Return y at a node on the smooth polynomial next to the front."""
    y = 0.0
    for n in range(NODES):
        y += rule.smooth[i, n] * room.nodes[Y, n]
    return y


@compiled
def smooth_front(problem: Problem, room: Room, phase: int) -> None:
    """Replace a front that scatters, which loads do not feel, by a smooth one.

    Between its nodes a panel has y^2 as the square of a polynomial, and loads or displacements as others. If
    these do not resolve the front, the gaps of the panel are not those of its elements, and the next contact feels it.
    """
    solid, nodes, values = problem.solid, room.nodes, room.vectors[7]
    panels, place = ahead(room, phase)
    for i in range(NODES):
        values[i] = smooth_front_at(problem.rule, room, i)
        if phase == GROWS and room.at[i] < 0:
            # Virgin surface.
            return
    for i in range(1, NODES - 1):
        p, z, y = room.at[i], room.z[i], nodes[Y, i]
        if p < 0:
            # The axis.
            p, z = 0, 0.0
        for _ in range(_MOST_BISECTIONS):
            polynomials(z, room.basis[0], room.basis[1])
            row = panels.coefficients[p, 0]
            y, rise = value_of(row, room.basis[0]), value_of(row, room.basis[1])
            change = (values[i] - y) / rise if rise != 0.0 else 0.0
            if abs(change) <= 1e-15:
                break
            if z == panels.end[p] and change > 0.0 and p < room.places[place] - 1:
                p, z = p + 1, 0.0
            elif z == 0.0 and change < 0.0 and p > 0:
                p, z = p - 1, panels.end[p - 1]
            else:
                z = min(max(z + change, 0.0), panels.end[p])
        before = nodes[A, i]
        nodes[Y, i] = max(y, 0.0)
        nodes[A, i], nodes[PI, i] = radius_and_integral(problem.path, nodes[Y, i])
        if phase == SHRINKS:
            write_loads(
                solid, panels, p, z, room.times[i], room.h[:, i], nodes[A, i], room.loads[:, i], room.L[:, i],
                room.basis[0], room.basis[1],
            )  # fmt: skip
        else:
            write_displacements(
                solid, panels, p, z, room.times[i], room.displacements[:, i], room.basis[0], room.basis[1]
            )
            touch(solid, room.displacements[:, i], room.loads[:, i])
            for k in range(solid.rates.shape[0]):
                room.L[k, i] += room.loads[k, i] * (nodes[A, i] - before)


@compiled
def push(problem: Problem, room: Room, phase: int, length: float, kind: int, joint: int) -> None:
    """Put the elements that changed state in a step on their stack."""
    solid, rule, nodes, K = problem.solid, problem.rule, room.nodes, problem.solid.rates.shape[0]
    values = room.vectors[6]
    panels, place = ahead(room, SHRINKS if phase == GROWS else GROWS)
    p = room.places[place]
    room.places[place] = p + 1
    panels.start[p], panels.length[p], panels.kind[p] = room.state[TIME], length, kind
    panels.end[p], panels.joint[p] = 1.0, joint
    row = panels.coefficients[p]
    to_coefficients(rule, nodes[Y], row[0])
    if phase == GROWS:
        for k in range(K):
            for i in range(NODES):
                values[i] = room.loads[k, i] - solid.moduli[k] * room.h[k, i]
            to_coefficients(rule, values, row[1 + k])
            for i in range(NODES):
                values[i] = room.L[k, i] - solid.moduli[k] * room.h[k, i] * nodes[A, i]
            to_coefficients(rule, values, row[1 + K + k])
        return
    for i in range(NODES):
        leave(solid, nodes[D, i] - nodes[Y, i] * nodes[Y, i], room.loads[:, i], room.displacements[:, i])
    for j in range(solid.recoveries.shape[0]):
        to_coefficients(rule, room.displacements[j], row[1 + j])


@inlined
def level_axis(solid: Solid, room: Room) -> None:
    """Remove the slopes over z of the displacements at the axis, where a contact has ended like a root of the time.

    There depths, and so displacements, are even functions of y. What errors of the step leave of a slope would let the
    next contact, which begins there, jump to where the gap is as they are.
    """
    rows, degree = room.free.coefficients[room.places[FREE_PANELS] - 1], NODES - 1
    for j in range(solid.recoveries.shape[0]):
        slope = 0.0
        for n in range(NODES):
            slope += 2.0 * n * n * rows[1 + j, n]
        # The polynomial with this slope, zero there, that is smallest elsewhere.
        slope /= 2.0 * degree * degree
        rows[1 + j, degree] -= slope
        rows[1 + j, 0] += slope


@inlined
def level_edge(problem: Problem, room: Room) -> None:
    """Remove the slope over z of the gap at the edge of a contact that has shrunk on a dashpot.

    Elements leave at the rate of the body, so that the gap has none; an error of it would move a front that returns.
    """
    p, n = room.places[FREE_PANELS] - 1, NODES - 1
    if p < 0 or room.free.end[p] != 1.0 or problem.solid.recoveries.shape[0] == 0:
        return
    length = room.free.length[p]
    if not abs(room.state[TIME] - room.free.start[p] - length) <= _FRESH * length:
        # They left a while ago, since when the edge has stood still.
        return
    slope = gap(
        problem.solid, room.free, p, 1.0, room.state[TIME], room.state[DEPTH], room.basis[0], room.basis[1]
    )[1]  # fmt: skip
    # The polynomial with this slope, zero there, that is smallest elsewhere.
    row = room.free.coefficients[p, 1]
    row[n] -= slope / (2.0 * n * n)
    row[0] += slope / (2.0 * n * n)


@compiled
def write_jump(problem: Problem, room: Room, phase: int, z: float) -> None:
    """Write the elements between the front and z of the top panel of the stack before it to the nodes."""
    solid, rule, nodes, K = problem.solid, problem.rule, room.nodes, problem.solid.rates.shape[0]
    t, basis, slopes = room.state[TIME], room.basis[0], room.basis[1]
    growth, source, result = room.vectors[2], room.vectors[0], room.vectors[1]
    panels, place = ahead(room, phase)
    p = room.places[place] - 1
    end = panels.end[p]
    for i in range(NODES):
        at = end + (z - end) * rule.c[i]
        polynomials(at, basis, slopes)
        nodes[D, i], nodes[Y, i] = room.state[DEPTH], max(value_of(panels.coefficients[p, 0], basis), 0.0)
        nodes[A, i], nodes[PI, i] = radius_and_integral(problem.path, nodes[Y, i])
        for k in range(K):
            room.h[k, i] = room.memory[k]
        if phase == SHRINKS:
            write_loads(
                solid, panels, p, at, t, room.memory, nodes[A, i], room.loads[:, i], room.L[:, i], basis, slopes
            )
        else:
            write_displacements(solid, panels, p, at, t, room.displacements[:, i], basis, slopes)
            touch(solid, room.displacements[:, i], room.loads[:, i])
    if phase == GROWS:
        differentiate(rule, nodes[A], growth)
        for k in range(K):
            for i in range(NODES):
                source[i] = room.loads[k, i] * growth[i]
            at_nodes(rule.A, source, result)
            room.L[k, 0] = room.sums[k]
            for i in range(1, NODES):
                room.L[k, i] = room.L[k, 0] + result[i]


@compiled
def jump(problem: Problem, room: Room, phase: int, z: float, joint: int) -> None:
    """Let the front pass at once to z of the top panel of the stack before it, whose elements change state now."""
    write_jump(problem, room, phase, z)
    panels, place = ahead(room, phase)
    p = room.places[place] - 1
    push(problem, room, phase, 0.0, FROZEN, joint)
    panels.end[p] = z
    room.places[place] = p + 1 if z > 0.0 else p
    room.state[FRONT] = room.nodes[Y, NODES - 1]
    for k in range(problem.solid.rates.shape[0]):
        room.sums[k] = room.L[k, NODES - 1]


@compiled
def sum_loads(problem: Problem, room: Room) -> None:
    """Write the force of the contact that has this depth, rate and front."""
    solid, state = problem.solid, room.state
    a, integral = radius_and_integral(problem.path, state[FRONT])
    state[FORCE] = solid.equilibrium * ((state[DEPTH] - state[FRONT] * state[FRONT]) * a + integral)
    state[FORCE] += solid.viscosity * a * state[RATE]
    for k in range(solid.rates.shape[0]):
        state[FORCE] += room.sums[k]


@compiled
def second_rate(problem: Problem, room: Room) -> float:
    """Return d'' of a shrinking contact at the start of a step that has been tried, where it follows from forces."""
    solid, driver, nodes, state = problem.solid, problem.driver, room.nodes, room.state
    if driver.by_depth:
        return 0.0
    if driver.mass > 0.0:
        return acceleration(driver, room, 0, state[FORCE] - nodes[PULL, 0], state[DEPTH], state[RATE])
    if not (solid.viscosity > 0.0 and nodes[A, 0] > 0.0):
        return 0.0
    # F' = a (E0 d' + eta d'') - sum rho_k L_k.
    force = nodes[PACE, 0] - driver.stiffness * state[RATE]
    for k in range(solid.rates.shape[0]):
        force += solid.rates[k] * room.sums[k]
    return (force / nodes[A, 0] - solid.glass * state[RATE]) / solid.viscosity


@compiled
def jump_ahead(problem: Problem, room: Room, phase: int, moment: float) -> bool:
    """Let the front pass at once to where it is a moment later; False if it hardly moves.

    So it does, within rounding, where loads have decayed to nothing, or the tip meets an imprint of its own shape.
    """
    solid, state = problem.solid, room.state
    panels, place = ahead(room, phase)
    count = room.places[place]
    if count == 0:
        return False
    drive = state[DEPTH] + moment * state[RATE]
    if phase == SHRINKS:
        drive = solid.equilibrium * drive + solid.viscosity * (state[RATE] + moment * second_rate(problem, room))
        for k in range(solid.rates.shape[0]):
            decay = math.exp(-solid.rates[k] * moment)
            drive += solid.moduli[k] * (room.memory[k] * decay + state[RATE] * (1.0 - decay) / solid.rates[k])
    p, z, y, _ = locate(
        solid, panels, count, phase == SHRINKS, state[TIME] + moment, drive, count - 1, panels.end[count - 1],
        room.basis[0], room.basis[1],
    )  # fmt: skip
    if abs(y - state[FRONT]) <= 1e-13 * max(y, state[FRONT]):
        return False
    while room.places[place] > p + 1:
        jump(problem, room, phase, 0.0, KINK)
    if p >= 0 and z < panels.end[p]:
        jump(problem, room, phase, z, KINK)
    if phase == GROWS and solid.viscosity > 0.0 and state[FRONT] > 0.0:
        # The elements that touch now feel the dashpot.
        force = state[FORCE]
        sum_loads(problem, room)
        if is_light(problem):
            damping = solid.viscosity * radius_and_integral(problem.path, state[FRONT])[0]
            state[RATE] += (force - state[FORCE]) / damping
            state[FORCE] = force
    return True


@inlined
def end_contact(problem: Problem, room: Room) -> None:
    """Let the innermost element leave."""
    room.state[FRONT], room.state[FORCE] = 0.0, 0.0
    room.places[FOLLOWING] = 0
    for k in range(problem.solid.rates.shape[0]):
        room.sums[k] = 0.0


@compiled
def free_rate(solid: Solid, room: Room) -> float:
    """Rate of the depth at which the element at the front, in the first node, has no load; with a dashpot."""
    load = solid.equilibrium * (room.nodes[D, 0] - room.nodes[Y, 0] * room.nodes[Y, 0])
    for k in range(solid.rates.shape[0]):
        load += room.loads[k, 0]
    return -load / solid.viscosity


@inlined
def gap_at(problem: Problem, room: Room, p: int, z: float) -> tuple[float, float]:
    """Return the gap now between a body at the surface at the axis and z of a free panel, and y there."""
    value, _, y, _ = gap(
        problem.solid, room.free, p, z, room.state[TIME], room.state[DEPTH], room.basis[0], room.basis[1]
    )
    return value, y


@compiled
def end_of_unfelt_gap(problem: Problem, room: Room, limit: float) -> tuple[int, float]:
    """Return panel and z up to which the gap around the axis is below a limit."""
    p = room.places[FREE_PANELS] - 1
    while p > 0 and gap_at(problem, room, p, 0.0)[0] < limit:
        p -= 1
    low, high = 0.0, room.free.end[p]
    if not gap_at(problem, room, p, low)[0] > limit:
        return p, low
    for _ in range(_MOST_BISECTIONS):
        middle = 0.5 * (low + high)
        if gap_at(problem, room, p, middle)[0] > limit:
            low = middle
        else:
            high = middle
    return p, low


@compiled
def is_quadratic(problem: Problem, room: Room, first: int, start: float) -> bool:
    """Return whether the gap within z of a free panel is about a multiple of y^2."""
    top = room.places[FREE_PANELS] - 1
    most, edge = gap_at(problem, room, first, start)
    p, z = first, start
    for part in _INNER:
        while p < top and gap_at(problem, room, p, room.free.end[p])[1] > part * edge:
            p, z = p + 1, 0.0
        low, high = z, room.free.end[p]
        for _ in range(_MOST_BISECTIONS):
            z = 0.5 * (low + high)
            if gap_at(problem, room, p, z)[1] > part * edge:
                low = z
            else:
                high = z
        ratio = gap_at(problem, room, p, z)[0] / (most * part * part)
        if not 1.0 / _DIFFERENT < ratio < _DIFFERENT:
            return False
    return True


@compiled
def clear_gap(problem: Problem, room: Room) -> None:
    """Let the gap around the axis rise with y^2 where it is less than is felt.

    Where a tip lies in an imprint of its own shape, or a dashpot has let all elements leave at one rate, the gap has
    no digits there, and a force that returns would not know where its contact begins. The displacements change by less
    than the tolerance.
    """
    solid, free, nodes, places = problem.solid, room.free, room.nodes, room.places
    limit = _NO_GAP * problem.scales.tolerance * problem.scales.depth
    while True:
        first, start = end_of_unfelt_gap(problem, room, limit)
        most, edge = gap_at(problem, room, first, start)
        if not (most > 0.0 and edge > 0.0) or limit < _ROUNDING_OF_GAP * problem.scales.depth:
            return
        if not is_quadratic(problem, room, first, start):
            break
        # Errors of the steps may show further inside.
        limit *= _INNER[-1] ** 2
    if start > 0.0:
        # The outer part of the panel stays.
        for n in range(places[FREE_PANELS], first + 1, -1):
            move_panel(free, n - 1, n)
        places[FREE_PANELS] += 1
        move_panel(free, first, first + 1)
        free.end[first] = start
        first += 1
    for p in range(first, places[FREE_PANELS]):
        low = start if p == first else 0.0
        for i in range(NODES):
            z = low + (free.end[p] - low) * problem.rule.c[i]
            value, nodes[Y, i] = gap_at(problem, room, p, z)
            write_displacements(
                solid, free, p, z, room.state[TIME], room.displacements[:, i], room.basis[0], room.basis[1]
            )
            # The slowest part does not change loads by much.
            room.displacements[0, i] += most * (nodes[Y, i] / edge) ** 2 - value
        free.start[p], free.length[p], free.kind[p], free.end[p] = room.state[TIME], 0.0, FROZEN, 1.0
        if p == first and start > 0.0:
            # Its kink is not felt.
            free.joint[p] = SMOOTH
        to_coefficients(problem.rule, nodes[Y], free.coefficients[p, 0])
        for j in range(solid.recoveries.shape[0]):
            to_coefficients(problem.rule, room.displacements[j], free.coefficients[p, 1 + j])


@compiled
def begin_contact(problem: Problem, room: Room) -> None:
    """Let the element at the axis touch, and with it those of a flat face."""
    solid, state = problem.solid, room.state
    if is_light(problem) and room.places[FREE_PANELS] > 0 and solid.recoveries.shape[0] > 0:
        clear_gap(problem, room)
    state[FRONT], state[FORCE] = 0.0, 0.0
    write_start(solid, problem.path, room, GROWS)
    for k in range(solid.rates.shape[0]):
        room.memory[k] = 0.0
        room.sums[k] = room.loads[k, 0] * room.nodes[A, 0]
    if solid.viscosity > 0.0:
        if is_light(problem):
            # No force jumps; the body is as fast as the surface.
            state[RATE] = free_rate(solid, room)
        # A flat face feels the dashpot at once.
        state[FORCE] = solid.viscosity * room.nodes[A, 0] * (state[RATE] - free_rate(solid, room))


@compiled
def note(room: Room, phase: int, event: int) -> None:
    """Record an event at which no time passes."""
    records, n = room.records, room.places[RECORDS]
    records.start[n], records.length[n], records.kind[n] = room.state[TIME], 0.0, 1
    records.phase[n], records.event[n] = phase, event
    for q in range(4):
        for i in range(NODES):
            records.columns[n, q, i] = 0.0
    records.columns[n, 0, 0], records.columns[n, 1, 0] = room.state[DEPTH], room.state[RATE]
    records.columns[n, 2, 0], records.columns[n, 3, 0] = room.state[FORCE], room.state[FRONT]
    room.places[RECORDS] = n + 1


@compiled
def sweep(problem: Problem, room: Room, last: int, z: float) -> bool:
    """Let all elements beyond z of a following panel leave at once; False without room for their panels.

    The sum of many decays is smooth over a part of a panel.
    """
    solid, scales, places = problem.solid, problem.scales, room.places
    joint = KINK
    while places[FOLLOWING] > max(last, 0):
        p = places[FOLLOWING] - 1
        end, below = room.following.end[p], room.following.joint[p]
        target = z if p == last else 0.0
        if p < last or target >= end:
            break
        if places[FREE_PANELS] + 2 > room.free.start.shape[0]:
            return False
        part = target
        for _ in range(_MOST_HALVINGS):
            write_jump(problem, room, SHRINKS, part)
            worst = 0.0
            for i in range(NODES):
                u = room.nodes[D, i] - room.nodes[Y, i] * room.nodes[Y, i]
                leave(solid, u, room.loads[:, i], room.displacements[:, i])
            for j in range(solid.recoveries.shape[0]):
                worst = max(worst, tail(problem.rule, room.displacements[j]))
            if worst <= scales.tolerance * scales.depth:
                break
            part = 0.5 * (part + end)
        jump(problem, room, SHRINKS, part, joint)
        joint = SMOOTH if part > target else below
    return True


@compiled
def is_nearly_over(problem: Problem, room: Room, length: float) -> bool:
    """Return whether the elements of a shrinking contact may leave at once behind a step of this length.

    That is, whether neither the force nor the displacement `int q dt/eta`, by which they would differ later, is felt.
    """
    solid, scales, state, last = problem.solid, problem.scales, room.state, NODES - 1
    if room.places[FOLLOWING] == 0 or state[FORCE] > _UNFELT * scales.tolerance * scales.force:
        return False
    before, now = room.nodes[Y, 0] * room.nodes[Y, 0], state[FRONT] * state[FRONT]
    if not now < before:
        return False
    left = length * now / (before - now)
    drive = shared_load(solid, room, last)
    q = load(solid, room.following, 0, 0.0, state[TIME], drive, room.basis[0], room.basis[1])[0]
    return q * left <= _UNFELT * solid.viscosity * scales.tolerance * scales.depth


@compiled
def is_unfelt(problem: Problem, room: Room, left: float) -> bool:
    """Return whether neither the force nor the depth feels it if all elements leave at once, a time before the end."""
    solid, scales, state = problem.solid, problem.scales, room.state
    small = _UNFELT * scales.tolerance
    if room.places[FOLLOWING] == 0 or state[FORCE] > small * scales.force:
        return False
    drive = solid.equilibrium * state[DEPTH] + solid.viscosity * state[RATE]
    for k in range(solid.rates.shape[0]):
        drive += solid.moduli[k] * room.memory[k]
    q = load(solid, room.following, 0, 0.0, state[TIME], drive, room.basis[0], room.basis[1])[0]
    if solid.viscosity > 0.0:
        return q * left <= small * solid.viscosity * scales.depth
    return q <= small * solid.glass * scales.depth


@compiled
def finish_sweep(problem: Problem, room: Room) -> int:
    """End the contact if a sweep has left nothing of it; return the outcome."""
    if room.places[FOLLOWING] > 0:
        return DONE
    if room.places[RECORDS] >= room.records.start.shape[0]:
        return NO_ROOM
    end_contact(problem, room)
    note(room, SHRINKS, ENDS)
    room.places[PHASE] = FREE
    return APART if problem.driver.once else DONE


@compiled
def end_at_zero(problem: Problem, room: Room, piece: int) -> int:
    """End a contact whose force has fallen to zero at a knot but for rounding; return the outcome."""
    driver, state, places = problem.driver, room.state, room.places
    nothing = _NO_LOAD * problem.scales.force
    if not is_force(driver) or places[PHASE] == FREE or places[FOLLOWING] == 0 or abs(state[FORCE]) > nothing:
        return DONE
    if prescribed_at(driver, piece, 0.0, state[TIME])[0] > nothing:
        return DONE
    if not sweep(problem, room, -1, 0.0):
        return NO_ROOM
    return finish_sweep(problem, room)


@compiled
def drop_rate(problem: Problem, room: Room, rate: float) -> int:
    """Let the depth pass on at a rate at which elements near the front have no load; return the outcome."""
    solid, state, places = problem.solid, room.state, room.places
    drive = solid.equilibrium * state[DEPTH] + solid.viscosity * rate
    for k in range(solid.rates.shape[0]):
        drive += solid.moduli[k] * room.memory[k]
    top = places[FOLLOWING] - 1
    p, z, _, _ = locate(
        solid, room.following, top + 1, True, state[TIME], drive, top, room.following.end[top], room.basis[0],
        room.basis[1],
    )  # fmt: skip
    if not sweep(problem, room, p, z):
        return NO_ROOM
    state[RATE], places[PHASE] = rate, SHRINKS
    sum_loads(problem, room)
    return finish_sweep(problem, room)


@compiled
def rate_of_load(problem: Problem, room: Room, force: float, most: float) -> float:
    """Return the rate of the depth at which a shrinking contact bears a force, less than that at a rate `most`.

    The force is convex over the rate, so that Newton's method stays on one side.
    """
    solid, state, top = problem.solid, room.state, room.places[FOLLOWING] - 1
    common, rate = solid.equilibrium * state[DEPTH], most
    for k in range(solid.rates.shape[0]):
        common += solid.moduli[k] * room.memory[k]
    for _ in range(100):
        p, z, y, _ = locate(
            solid, room.following, top + 1, True, state[TIME], common + solid.viscosity * rate, top,
            room.following.end[top], room.basis[0], room.basis[1],
        )  # fmt: skip
        a, integral = radius_and_integral(problem.path, max(y, 0.0) if p >= 0 else 0.0)
        if not a > 0.0:
            break
        write_loads(
            solid, room.following, p, z, state[TIME], room.memory, a, room.loads[:, 0], room.L[:, 0], room.basis[0],
            room.basis[1],
        )  # fmt: skip
        value = solid.equilibrium * ((state[DEPTH] - y * y) * a + integral) + solid.viscosity * a * rate
        for k in range(solid.rates.shape[0]):
            value += room.L[k, 0]
        change = (value - force) / (solid.viscosity * a)
        rate -= change
        if abs(value - force) <= 1e-15 * max(value, force) or abs(change) <= 1e-15 * abs(rate):
            break
    return rate


@compiled
def jump_load(problem: Problem, room: Room, piece: int, start: Any) -> int:
    """Let what is prescribed jump on a material with a dashpot; return the outcome.

    Without inertia. `start` has how the next step starts.
    """
    solid, driver, state, places = problem.solid, problem.driver, room.state, room.places
    value = prescribed_at(driver, piece, 1.0, state[TIME])[0]
    if places[PHASE] == FREE:
        level = surface_at_axis(solid, room, state[TIME])
        touches = value > 0.0 if is_force(driver) else value > driver.stiffness * level
        state[DEPTH] = level if touches or is_force(driver) else value / driver.stiffness
        if not touches:
            return DONE
        if places[RECORDS] >= room.records.start.shape[0]:
            return NO_ROOM
        begin_contact(problem, room)
        note(room, FREE, TOUCHES)
        places[PHASE], start[0] = GROWS, problem.power
    force = value - driver.stiffness * state[DEPTH]
    write_start(solid, problem.path, room, places[PHASE])
    a, slowest = room.nodes[A, 0], free_rate(solid, room)
    if not a > 0.0:
        # The rate is infinite for a moment.
        state[FORCE] = force
        return DONE
    damping = solid.viscosity * a
    if force >= state[FORCE] + damping * (slowest - state[RATE]):
        if places[PHASE] == SHRINKS:
            # Free elements begin to part from the body at its own rate: their gap is quadratic near the edge.
            places[PHASE], start[0] = GROWS, 2
        state[RATE] += (force - state[FORCE]) / damping
        state[FORCE] = force
        return DONE
    start[0] = 1
    if force <= _NO_LOAD * problem.scales.force or places[FOLLOWING] == 0:
        if not sweep(problem, room, -1, 0.0):
            return NO_ROOM
        if driver.stiffness > 0.0:
            state[DEPTH] = value / driver.stiffness
        return finish_sweep(problem, room)
    outcome = drop_rate(problem, room, rate_of_load(problem, room, force, slowest))
    if places[PHASE] != FREE:
        state[FORCE] = force
    return outcome
