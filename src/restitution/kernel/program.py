"""Any history of a contact: step after step from break to break.

A step ends at a break: a knot of what is prescribed, a turning (the front stands), a joint of panels, a corner of the
profile, the touch or the end of the contact. `restitution.kernel.search` finds the step and its break.
"""

import math
from typing import Any

from restitution.kernel.accuracy import leaves_scatter, strays
from restitution.kernel.compile import compiled, entry_point, inlined
from restitution.kernel.driver import (
    AIM,
    APART,
    BEHIND,
    BENDS,
    CROWD,
    DEPTH,
    DONE,
    ENDS,
    ERROR,
    FIRST_KIND,
    FOLLOWING,
    FORCE,
    FREE,
    FREE_PANELS,
    FRONT,
    GIVEN,
    GOAL,
    GOAL_KIND,
    GRAIN,
    GROWS,
    GUESS,
    HUNTED,
    INSTANT,
    JOINT,
    LENGTH,
    NO_ROOM,
    NOT_SOLVED,
    NOTHING,
    OLD_ERROR,
    OLD_LENGTH,
    PACE,
    PASSED,
    PHASE,
    PULL,
    RATE,
    REACH,
    RECORDS,
    SHRINKS,
    STRIDE,
    SWITCHES,
    TIME,
    TIME_PASSES,
    TOUCHES,
    TURNS,
    VALUE_JUMPS,
    WORK,
    A,
    D,
    F,
    Piece,
    Problem,
    Room,
    Step,
    V,
    Y,
    ahead,
    fades_out,
    falls_to_zero,
    is_force,
    is_light,
    prescribed_at,
)
from restitution.kernel.events import AT_AXIS, end_of_way, pace_of_load
from restitution.kernel.growth import differentiate
from restitution.kernel.jumps import (
    begin_contact,
    drop_rate,
    end_at_zero,
    end_contact,
    finish_sweep,
    free_rate,
    is_nearly_over,
    is_unfelt,
    jump,
    jump_load,
    level_axis,
    level_edge,
    note,
    push,
    smooth_front,
    sweep,
)
from restitution.kernel.lever import keep_swings
from restitution.kernel.merging import thin_out
from restitution.kernel.panels import (
    CORNER,
    FLAT,
    FROZEN,
    KINK,
    NODES,
    SMOOTH,
    STAGES,
    polynomials,
    tail,
    to_coefficients,
    value_of,
)
from restitution.kernel.path import radius_and_integral
from restitution.kernel.search import MOMENTARY, MOST_JUMPS, factor_of, find_step, step_of
from restitution.kernel.stepper import surface_at_axis, write_start

# Change of the depth, over the tolerance, in which it is not felt which elements leave a spring first.
_BRIEF = 0.5
# Breaks without a step between them.
_MOST_SWITCHES = 60
# Largest power of the map of a touch that is p + 2 of a profile, and so may be divided.
_MOST_DIVIDED = 5
# Factor of the last coefficients of a front by which it is rougher.
_ROUGHER = 4.0
# Panels of both stacks that are merged.
_CROWDED = 64


@compiled
def _record(problem: Problem, room: Room, step: Step, event: int) -> None:
    """Record an accepted step, and add its work."""
    rule, nodes, records, n = problem.rule, room.nodes, room.records, room.places[RECORDS]
    net, slopes = room.vectors[6], room.vectors[7]
    records.start[n], records.length[n] = room.state[TIME], (step.length if step.passing == TIME_PASSES else 0.0)
    records.kind[n], records.phase[n], records.event[n] = step.kind, step.phase, event
    to_coefficients(rule, nodes[D], records.columns[n, 0])
    to_coefficients(rule, nodes[V], records.columns[n, 1])
    for i in range(NODES):
        net[i] = nodes[F, i] - nodes[PULL, i]
    to_coefficients(rule, net, records.columns[n, 2])
    to_coefficients(rule, nodes[Y], records.columns[n, 3])
    for m in range(room.swing.shape[0]):
        to_coefficients(rule, room.swings[m, 0], records.columns[n, 4 + m])
    room.places[RECORDS] = n + 1
    differentiate(rule, nodes[D], slopes)
    for i in range(1, NODES):
        room.state[WORK] += rule.A[STAGES - 1, i - 1] * net[i] * slopes[i]


@compiled
def _meet_joint(problem: Problem, room: Room, phase: int, end: int) -> bool:
    """Let the front end a step at a joint; return whether it falls short of it, so that elements between are felt."""
    nodes, panels, last = room.nodes, ahead(room, phase)[0], NODES - 1
    polynomials(0.0, room.basis[0], room.basis[1])
    y = max(value_of(panels.coefficients[end, 0], room.basis[0]), 0.0)
    # The front is known less well than the joint, unless elements between them would be felt in the panel.
    error = 2.0 * max(nodes[Y, 0], nodes[Y, last]) * abs(y - nodes[Y, last])
    if room.at[last] >= end and error > problem.scales.tolerance * problem.scales.depth:
        return True
    nodes[Y, last] = y
    if phase == GROWS:
        # They have no load yet.
        radius = radius_and_integral(problem.path, y)[0]
        for k in range(problem.solid.rates.shape[0]):
            room.L[k, last] += room.loads[k, last] * (radius - nodes[A, last])
        nodes[A, last] = radius
    return False


@compiled
def _meet_axis(problem: Problem, room: Room, phase: int, brief: bool) -> bool:
    """Let the front end a step at the axis; return whether it falls short of it.

    A root of rounding else, with which the next touch would not be smooth, unless it is what is smooth.
    """
    rule, nodes, last, falls_short = problem.rule, room.nodes, NODES - 1, False
    y, before = nodes[Y, last], tail(rule, nodes[Y])
    nodes[Y, last] = 0.0
    after = tail(rule, nodes[Y])
    error = 2.0 * nodes[Y, 0] * after / (problem.scales.tolerance * problem.scales.depth)
    if brief:
        falls_short = error > 1.0 and not leaves_scatter(problem, room, phase)
    elif not is_light(problem):
        falls_short = room.at[last] >= 0 and after > _ROUGHER * before and error > 1.0
    if falls_short:
        nodes[Y, last] = y
    return falls_short


@compiled
def _cut_panel(room: Room, phase: int) -> None:
    """Leave the rest of the panel in which the front is at the end of a step."""
    panels, place = ahead(room, phase)
    p = room.at[NODES - 1]
    if p < 0:
        room.places[place] = 0
        return
    z = room.z[NODES - 1]
    panels.end[p] = z
    room.places[place] = p + 1 if z > 0.0 else p


@inlined
def _keep(problem: Problem, room: Room, stop: float) -> None:
    """Move the state to the last node of a step, at time `stop`."""
    nodes, state, last = room.nodes, room.state, NODES - 1
    state[TIME], state[DEPTH], state[RATE] = stop, nodes[D, last], nodes[V, last]
    state[FRONT], state[FORCE] = nodes[Y, last], nodes[F, last]
    for k in range(problem.solid.rates.shape[0]):
        room.memory[k], room.sums[k] = room.h[k, last], room.L[k, last]
    keep_swings(problem.driver, room)


@compiled
def accept(problem: Problem, room: Room, step: Step, event: int, joint: int, stop: float) -> None:
    """Move the state to the end of a step, at time `stop`."""
    rule, nodes, last, phase, kind = problem.rule, room.nodes, NODES - 1, step.phase, step.kind
    felt = problem.scales.tolerance * problem.scales.depth
    _record(problem, room, step, event)
    brief = abs(nodes[D, last] - nodes[D, 0]) <= _BRIEF * problem.scales.tolerance * problem.scales.depth
    brief = brief and is_light(problem) and not is_force(problem.driver)
    falls_short, at_once, end = False, False, 0
    if event == JOINT:
        end = end_of_way(room, phase)[1]
        falls_short = _meet_joint(problem, room, phase, end)
    elif event == ENDS:
        falls_short = _meet_axis(problem, room, phase, brief)
    if leaves_scatter(problem, room, phase):
        smooth_front(problem, room, phase)
    if event == ENDS and brief:
        # The time has too few digits, so that no panel has the elements that leave.
        at_once = 2.0 * nodes[Y, 0] * tail(rule, nodes[Y]) > felt
        falls_short = falls_short or at_once
    if phase != FREE and (nodes[Y, last] != nodes[Y, 0] or event == ENDS) and not at_once:
        push(problem, room, phase, step.length, kind if step.passing == TIME_PASSES else FROZEN, joint)
        if event == ENDS and kind < 0 and not falls_short:
            level_axis(problem.solid, room)
        if event in (JOINT, ENDS) and not falls_short:
            room.places[ahead(room, phase)[1]] = end
        else:
            _cut_panel(room, phase)
    _keep(problem, room, stop)
    if falls_short:
        # They change state at once.
        while room.places[ahead(room, phase)[1]] > end:
            jump(problem, room, phase, 0.0, KINK)
    if event == ENDS:
        end_contact(problem, room)
    if event == TOUCHES:
        begin_contact(problem, room)


@compiled
def rate_behind_knot(problem: Problem, room: Room, piece: int, span: float) -> float:
    """Return the rate of the depth behind a knot of what is prescribed; without a time span the size of the jump."""
    driver, solid = problem.driver, problem.solid
    if span == 0.0:
        return prescribed_at(driver, piece, 1.0, 0.0)[0] - prescribed_at(driver, piece, 0.0, 0.0)[0]
    _, slope, rate = prescribed_at(driver, piece, 0.0, room.state[TIME])
    rate += slope / span
    if driver.by_depth:
        return rate
    a = radius_and_integral(problem.path, room.state[FRONT])[0]
    stiffness = driver.stiffness + solid.glass * a
    if driver.mass > 0.0 or solid.viscosity > 0.0 or not stiffness > 0.0:
        return room.state[RATE]
    # k d' = f' - F' with F' = E0 a d' - sum rho_k L_k, as the load vanishes at the front.
    for k in range(solid.rates.shape[0]):
        rate += solid.rates[k] * room.sums[k]
    return rate / stiffness


@compiled
def phase_behind_knot(problem: Problem, room: Room, piece: int, span: float, rate: float) -> int:
    """Return whether the contact grows or shrinks at this rate: whether the body is faster than the free surface."""
    solid, phase = problem.solid, room.places[PHASE]
    write_start(solid, problem.path, room, phase)
    if solid.viscosity > 0.0:
        if problem.driver.by_depth:
            return GROWS if rate >= free_rate(solid, room) else SHRINKS
        # The rate does not jump.
        excess = solid.viscosity * (rate - free_rate(solid, room))
        if phase == GROWS and excess > MOMENTARY * problem.scales.tolerance * problem.scales.stress:
            return GROWS
        value, slope, pace = prescribed_at(problem.driver, piece, 0.0, room.state[TIME])
        room.nodes[GIVEN, 0], room.nodes[PACE, 0] = value, slope / span + pace
        return GROWS if pace_of_load(problem, room, 0, 0.0) >= 0.0 else SHRINKS
    lost = 0.0
    for k in range(solid.rates.shape[0]):
        lost += solid.rates[k] * room.loads[k, 0]
    return GROWS if rate >= lost / solid.glass else SHRINKS


@inlined
def kind_behind_joint(room: Room, phase: int) -> int:
    """Return the map of the step that enters the panel below a joint.

    A panel that ends like a root of the time holds loads, or displacements, that are functions of the root of the
    distance from its end.
    """
    panels, place = ahead(room, phase)
    p = room.places[place] - 1
    return 2 if p >= 0 and panels.kind[p] < 0 and panels.end[p] == 1.0 else 1


@compiled
def _let_go(problem: Problem, room: Room, stop: float) -> int:
    """Let all elements leave at once where the rest of a force is not felt; return the outcome."""
    room.state[TIME], room.marks[FIRST_KIND], room.marks[BEHIND] = stop, 1, KINK
    if not sweep(problem, room, -1, 0.0):
        return NO_ROOM
    return finish_sweep(problem, room)


@compiled
def _change_at_once(problem: Problem, room: Room) -> int:
    """Let the event happen at the start of a step, without one; return the outcome."""
    marks, phase = room.marks, room.places[PHASE]
    marks[SWITCHES] += 1
    if marks[SWITCHES] > _MOST_SWITCHES:
        return NOT_SOLVED
    if marks[HUNTED] == TOUCHES:
        begin_contact(problem, room)
    elif marks[HUNTED] in (JOINT, ENDS):
        _, p = end_of_way(room, phase)
        while room.places[ahead(room, phase)[1]] > max(p, 0):
            jump(problem, room, phase, 0.0, KINK)
        if marks[HUNTED] == ENDS:
            end_contact(problem, room)
    return DONE


@inlined
def _guess_next(room: Room, tolerance: float) -> None:
    """Choose the length to try behind a step."""
    course, length, error = room.course, room.course[LENGTH], room.course[ERROR]
    if room.marks[HUNTED] != NOTHING:
        course[GUESS] = max(length, 0.5 * course[STRIDE])
        course[STRIDE] = course[GUESS]
        return
    # The error of the step before tells how fast the solution becomes smoother.
    trend = length / course[OLD_LENGTH] * (course[OLD_ERROR] / max(error, 1e-30)) ** (1.0 / STAGES)
    trend = min(max(trend, 0.7), 2.0) if course[OLD_LENGTH] < math.inf else 1.0
    course[OLD_LENGTH], course[OLD_ERROR] = length, error
    guess = length * factor_of(tolerance, error, 1, 0.3, 4.0) * trend
    course[STRIDE] = max(course[STRIDE], guess) if course[REACH] < math.inf else guess
    way = course[AIM] - course[PASSED]
    course[GUESS] = min(guess, 0.5 * way) if way > course[REACH] else guess


@compiled
def _take_step(problem: Problem, room: Room, piece: Piece, most: int) -> int:
    """Take the step that was found; return the outcome."""
    course, marks, phase = room.course, room.marks, room.places[PHASE]
    length, left, passes = course[LENGTH], piece.span - course[PASSED], piece.passing == TIME_PASSES
    marks[SWITCHES] = 0
    size = room.places[FOLLOWING] + room.places[FREE_PANELS] + MOST_JUMPS
    if room.places[RECORDS] >= min(most, room.records.start.shape[0]) or size >= room.free.start.shape[0]:
        return NO_ROOM
    if passes and strays(problem, room, phase):
        return NOT_SOLVED
    step, knots = step_of(room, piece), problem.driver.knots
    ends = left - length <= max(4.0 * course[GRAIN], 1e-15 * piece.span)
    course[PASSED] = piece.span if ends else course[PASSED] + length
    stop = room.state[TIME]
    if passes:
        stop = knots[piece.number + 1] if ends else knots[piece.number] + course[PASSED]
    accept(problem, room, step, marks[HUNTED], marks[BEHIND], stop)
    _guess_next(room, problem.scales.tolerance)
    over = piece.fades and phase == SHRINKS and marks[HUNTED] in (NOTHING, JOINT)
    if over and is_nearly_over(problem, room, length) and not sweep(problem, room, -1, 0.0):
        return NO_ROOM
    return DONE


@compiled
def _pass_event(problem: Problem, room: Room, piece: Piece, phase: int) -> None:
    """Choose phase, map, joint and length of the step behind an event, from the phase before it."""
    course, marks, event = room.course, room.marks, room.marks[HUNTED]
    began = marks[FIRST_KIND]
    marks[BEHIND], marks[FIRST_KIND] = SMOOTH, 1
    if event != NOTHING:
        course[REACH], marks[GOAL] = math.inf, NOTHING
    if event == TURNS:
        phase, marks[BEHIND] = (SHRINKS if phase == GROWS else GROWS), FLAT
        if phase == SHRINKS and problem.solid.viscosity > 0.0:
            # The front leaves at once, through elements that it reached like a root of the time.
            marks[FIRST_KIND] = 2
    elif event == TOUCHES:
        phase, marks[FIRST_KIND], course[GUESS] = GROWS, problem.power, piece.span - course[PASSED]
    elif event == ENDS:
        phase, course[GUESS] = FREE, math.inf
    elif event == JOINT:
        marks[BEHIND], marks[FIRST_KIND] = KINK, kind_behind_joint(room, phase)
        if marks[SWITCHES] > 0 and room.state[FRONT] * room.state[FRONT] < AT_AXIS:
            # A contact that has just begun grows on like a root.
            marks[FIRST_KIND] = began
    elif event == BENDS:
        marks[BEHIND], marks[FIRST_KIND] = CORNER, 2
    room.places[PHASE] = phase


@compiled
def _move_on(problem: Problem, room: Room, piece: Piece, most: int) -> int:
    """Find and take one step, or let its event happen at once; return the outcome."""
    course, marks, driver, phase = room.course, room.marks, problem.driver, room.places[PHASE]
    outcome = find_step(problem, room, piece)
    if outcome != DONE:
        return outcome
    if marks[HUNTED] != NOTHING and course[LENGTH] < course[INSTANT]:
        outcome = _change_at_once(problem, room)
    else:
        outcome = _take_step(problem, room, piece, most)
    if outcome != DONE:
        return outcome
    if marks[HUNTED] != ENDS and phase == SHRINKS and room.places[FOLLOWING] == 0:
        # The innermost elements left within rounding.
        marks[HUNTED] = ENDS
        room.records.event[room.places[RECORDS] - 1] = ENDS
        end_contact(problem, room)
    if marks[HUNTED] == ENDS and driver.stiffness > 0.0 and is_light(problem):
        # Without a force.
        part = course[PASSED] / piece.span
        room.state[DEPTH] = prescribed_at(driver, piece.number, part, room.state[TIME])[0] / driver.stiffness
    _pass_event(problem, room, piece, phase)
    return APART if marks[HUNTED] == ENDS and driver.once else DONE


@compiled
def follow(problem: Problem, room: Room, number: int, passing: int, start: Any, most: int) -> int:
    """Follow the body through a piece of what is prescribed; `start` has how the next step starts, and its length.

    The numbers of `start`: map of the first step, joint, length.
    """
    driver, course, marks, places = problem.driver, room.course, room.marks, room.places
    span = driver.knots[number + 1] - driver.knots[number] if passing == TIME_PASSES else 1.0
    falls = is_force(driver) and falls_to_zero(driver, number)
    piece = Piece(number, passing, span, falls, fades_out(problem))
    marks[FIRST_KIND], marks[BEHIND], marks[SWITCHES] = int(start[0]), int(start[1]), 0
    marks[GOAL], marks[GOAL_KIND] = NOTHING, 1
    course[PASSED], course[GUESS], course[STRIDE] = 0.0, min(start[2], span), min(start[2], span)
    course[REACH], course[AIM], course[OLD_LENGTH], course[OLD_ERROR] = math.inf, 0.0, math.inf, 0.0
    while course[PASSED] < span:
        size = places[FOLLOWING] + places[FREE_PANELS]
        if size > max(places[CROWD], _CROWDED) and problem.path.kinks.shape[0] == 0:
            thin_out(problem, room)
            # Not again and again, where nothing is to be merged.
            places[CROWD] = 3 * (places[FOLLOWING] + places[FREE_PANELS]) // 2
        over = falls and places[PHASE] == SHRINKS and is_unfelt(problem, room, span - course[PASSED])
        end = driver.knots[number + 1]
        outcome = _let_go(problem, room, end) if over else _move_on(problem, room, piece, most)
        if outcome != DONE:
            return outcome
        if over:
            break
    start[0], start[1] = marks[FIRST_KIND], marks[BEHIND]
    if passing == TIME_PASSES:
        start[2] = course[GUESS]
    return DONE


@compiled
def kind_of_touch(problem: Problem, piece: int) -> int:
    """Return the map of the step in which a contact begins under a force that leaves zero like a power of the time.

    `F ~ t^m` and `F ~ eta a d'` give y ~ t^(m/power) and y ~ t^((m + 1)/power).
    """
    order = 1
    while order < problem.driver.values.shape[1] - 1 and problem.driver.values[piece, order] == 0.0:
        order += 1
    if problem.solid.viscosity > 0.0:
        order += 1
    for divisor in range(problem.power, 1, -1):
        if problem.power <= _MOST_DIVIDED and order % divisor == 0 and problem.power % divisor == 0:
            return problem.power // divisor
    return problem.power


@compiled
def pass_kink(problem: Problem, room: Room, piece: int, span: float, start: Any) -> int:
    """Let a body in contact pass a knot of what is prescribed, at which its rate may jump; return the outcome."""
    state, places = room.state, room.places
    rate = rate_behind_knot(problem, room, piece, span)
    if span == 0.0:
        places[PHASE] = GROWS if rate >= 0.0 else SHRINKS
        return DONE
    phase = places[PHASE]
    places[PHASE] = phase_behind_knot(problem, room, piece, span, rate)
    if problem.solid.viscosity > 0.0 and problem.driver.by_depth:
        if places[PHASE] == SHRINKS:
            return drop_rate(problem, room, rate)
        state[FORCE] += problem.solid.viscosity * room.nodes[A, 0] * (rate - state[RATE])
        if phase == SHRINKS:
            # Free elements begin to part from the body at its own rate: their gap is quadratic near the edge.
            start[0] = 2
    elif problem.solid.viscosity > 0.0 and phase == SHRINKS and places[PHASE] == GROWS:
        level_edge(problem, room)
    state[RATE] = rate
    return DONE


@entry_point
def run(problem: Problem, room: Room, start: Any, most: int) -> int:
    """Follow the body through all that is prescribed; return the outcome.

    `start` are three numbers of room: whether the body touches the surface, as it then is, at the axis, with the rate
    of its state; a number for the run; and the length of the first step to try.
    """
    driver, state, places = problem.driver, room.state, room.places
    if start[0] > 0.0:
        state[DEPTH], places[PHASE] = surface_at_axis(problem.solid, room, state[TIME]), GROWS
        begin_contact(problem, room)
    begins = places[PHASE] == GROWS and places[FOLLOWING] == 0
    start[0], start[1] = (problem.power if begins else 1), KINK
    for piece in range(driver.knots.shape[0] - 1):
        span = driver.knots[piece + 1] - driver.knots[piece]
        if not driver.smooth[piece]:
            start[1] = KINK
            if span == 0.0 and problem.solid.viscosity > 0.0 and is_light(problem):
                outcome = jump_load(problem, room, piece, start)
                if outcome != DONE:
                    return outcome
                continue
            outcome = end_at_zero(problem, room, piece)
            if outcome != DONE:
                return outcome
            if places[PHASE] != FREE and places[FOLLOWING] > 0:
                outcome = pass_kink(problem, room, piece, span, start)
                if outcome != DONE:
                    return outcome
            elif driver.by_depth and span > 0.0:
                # A flat face feels the dashpot from the touch on.
                state[RATE] = rate_behind_knot(problem, room, piece, span)
        if is_force(driver) and places[PHASE] == FREE and prescribed_at(driver, piece, 0.5, 0.0)[0] > 0.0:
            # The force leaves zero at a knot.
            if places[RECORDS] >= room.records.start.shape[0]:
                return NO_ROOM
            state[DEPTH] = surface_at_axis(problem.solid, room, state[TIME])
            begin_contact(problem, room)
            note(room, FREE, TOUCHES)
            places[PHASE], start[0], start[1], start[2] = GROWS, kind_of_touch(problem, piece), KINK, math.inf
        outcome = follow(problem, room, piece, VALUE_JUMPS if span == 0.0 else TIME_PASSES, start, most)
        if outcome != DONE:
            return outcome
    return DONE
