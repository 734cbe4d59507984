"""Any history of a contact: step after step from break to break.

A step ends at a break: a knot of what is prescribed, a turning (the front stands), a joint of panels, a corner of the
profile, the touch or the end of the contact. Each break is the zero of a smooth function of the depth, the event,
which is found first; then the step is solved once more up to there.
"""

import math
from typing import Any

from restitution.kernel.accuracy import leaves_scatter, step_error, strays
from restitution.kernel.compile import compiled, entry_point, inlined
from restitution.kernel.driver import (
    APART,
    BENDS,
    CROWD,
    DEPTH,
    DONE,
    ENDS,
    EVENT,
    FOLLOWING,
    FORCE,
    FREE,
    FREE_PANELS,
    FRONT,
    GIVEN,
    GROWS,
    JOINT,
    NO_ROOM,
    NOT_SOLVED,
    NOTHING,
    PACE,
    PHASE,
    PULL,
    RATE,
    RECORDS,
    SHRINKS,
    TIME,
    TIME_PASSES,
    TOO_STEEP,
    TOUCHES,
    TURNS,
    VALUE_JUMPS,
    WORK,
    A,
    D,
    F,
    Problem,
    Room,
    Step,
    V,
    Y,
    ahead,
    ends_by_load,
    fades_out,
    falls_to_zero,
    is_force,
    is_light,
    prescribed_at,
)
from restitution.kernel.events import AT_AXIS, end_of_way, event_ahead, first_event, pace_of_load, write_event
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
    jump_ahead,
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
    BACKWARD,
    CORNER,
    FLAT,
    FROZEN,
    KINK,
    NODES,
    SMOOTH,
    STAGES,
    polynomials,
    share,
    tail,
    to_coefficients,
    value_of,
)
from restitution.kernel.path import radius_and_integral
from restitution.kernel.stepper import solve_step, surface_at_axis, write_start

# Error up to which the events of a step are looked for.
_COARSE = 0.05
# Change of the length of a step to an event, over the length, that is not felt; a tenth where the front is fast.
_SAME_TIME = 1e-12
# Loads that change within a moment, over the tolerance.
_MOMENT = 0.05
# Change of the depth, over the tolerance, in which it is not felt which elements leave a spring first.
_BRIEF = 0.5
# Difference of two lengths of a step, over the length, that a secant has when only rounding is left between them.
_CLOSE = 1e-6
_MOST_TRIES = 200
# Breaks without a step between them.
_MOST_SWITCHES = 60
_MOST_JUMPS = 20
# Error of a step to the end of the front's way, over the tolerance, and over that of the try before, from which on
# the next try may be good enough.
_CHASED, _CLEARER = 1e5, 0.25
# Error of such a step, over the tolerance, from which on the end of the front's way is known.
_KNOWN = 1e5
# Largest power of the map of a touch that is p + 2 of a profile, and so may be divided.
_MOST_DIVIDED = 5
# Steps of one start that are lengthened to an event behind them: not again and again, if none is smooth enough.
_MOST_AIMS = 4
# Factor of the last coefficients of a front by which it is rougher.
_ROUGHER = 4.0
# Panels of both stacks that are merged.
_CROWDED = 64


@compiled
def accept(problem: Problem, room: Room, step: Step, event: int, joint: int, stop: float) -> None:
    """Move the state to the end of a step, at time `stop`."""
    rule, nodes, last, K = problem.rule, room.nodes, NODES - 1, problem.solid.rates.shape[0]
    records, n, net, slopes = room.records, room.places[RECORDS], room.vectors[6], room.vectors[7]
    phase, length, kind, passes = step.phase, step.length, step.kind, step.passing == TIME_PASSES
    records.start[n], records.length[n], records.kind[n] = room.state[TIME], (length if passes else 0.0), kind
    records.phase[n], records.event[n] = phase, event
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
    falls_short, at_once, end = False, False, 0
    brief = abs(nodes[D, last] - nodes[D, 0]) <= _BRIEF * problem.scales.tolerance * problem.scales.depth
    brief = brief and is_light(problem) and not is_force(problem.driver)
    if event == JOINT:
        panels, end = end_of_way(room, phase)
        polynomials(0.0, room.basis[0], room.basis[1])
        y = max(value_of(panels.coefficients[end, 0], room.basis[0]), 0.0)
        # The front is known less well than the joint, unless elements between them would be felt in the panel.
        error = 2.0 * max(nodes[Y, 0], nodes[Y, last]) * abs(y - nodes[Y, last])
        falls_short = room.at[last] >= end and error > problem.scales.tolerance * problem.scales.depth
        if not falls_short:
            nodes[Y, last] = y
            if phase == GROWS:
                # They have no load yet.
                radius = radius_and_integral(problem.path, y)[0]
                for k in range(K):
                    room.L[k, last] += room.loads[k, last] * (radius - nodes[A, last])
                nodes[A, last] = radius
    elif event == ENDS:
        # A root of rounding else, with which the next touch would not be smooth, unless it is what is smooth.
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
    if leaves_scatter(problem, room, phase):
        smooth_front(problem, room, phase)
    if event == ENDS and brief:
        # The time has too few digits, so that no panel has the elements that leave.
        at_once = 2.0 * nodes[Y, 0] * tail(rule, nodes[Y]) > problem.scales.tolerance * problem.scales.depth
        falls_short = falls_short or at_once
    if phase != FREE and (nodes[Y, last] != nodes[Y, 0] or event == ENDS) and not at_once:
        push(problem, room, phase, length, kind if passes else FROZEN, joint)
        if event == ENDS and kind < 0 and not falls_short:
            level_axis(problem.solid, room)
        panels, place = ahead(room, phase)
        if event in (JOINT, ENDS) and not falls_short:
            room.places[place] = end
        elif room.at[last] < 0:
            room.places[place] = 0
        else:
            p, z = room.at[last], room.z[last]
            panels.end[p] = z
            room.places[place] = p + 1 if z > 0.0 else p
    room.state[TIME], room.state[DEPTH], room.state[RATE] = stop, nodes[D, last], nodes[V, last]
    room.state[FRONT], room.state[FORCE] = nodes[Y, last], nodes[F, last]
    for k in range(K):
        room.memory[k], room.sums[k] = room.h[k, last], room.L[k, last]
    keep_swings(problem.driver, room)
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
        if phase == GROWS and excess > _MOMENT * problem.scales.tolerance * problem.scales.stress:
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


@inlined
def factor_of(tolerance: float, error: float, kind: int, least: float, most: float) -> float:
    """Return the factor for the length of the next step after one with this error.

    Over z a power of the time has a higher degree, so that the error falls with a lower power of the length.
    """
    order = STAGES / min(max(abs(kind), 1.0), 4.0)
    return min(max(0.8 * (tolerance / max(error, 1e-30)) ** (1.0 / order), least), most)


@compiled
def follow(problem: Problem, room: Room, piece: int, passing: int, start: Any, most: int) -> int:
    """Follow the body through a piece of what is prescribed; `start` has how the next step starts, and its length.

    The numbers of `start`: map of the first step, joint, length.
    """
    driver, rule, scales, tolerance = problem.driver, problem.rule, problem.scales, problem.scales.tolerance
    span = driver.knots[piece + 1] - driver.knots[piece] if passing == TIME_PASSES else 1.0
    duration = driver.knots[driver.knots.shape[0] - 1] - driver.knots[0]
    falls = is_force(driver) and falls_to_zero(driver, piece)
    phase, done, switches, fades = room.places[PHASE], 0.0, 0, fades_out(problem)
    first_kind, joint, guess, reach = int(start[0]), int(start[1]), min(start[2], span), math.inf
    aim, old_length, old_error = 0.0, math.inf, 0.0
    stride, goal, goal_kind = guess, NOTHING, 1
    while done < span:
        size = room.places[FOLLOWING] + room.places[FREE_PANELS]
        if size > max(room.places[CROWD], _CROWDED) and problem.path.kinks.shape[0] == 0:
            thin_out(problem, room)
            # Not again and again, where nothing is to be merged.
            room.places[CROWD] = 3 * (room.places[FOLLOWING] + room.places[FREE_PANELS]) // 2
        left = span - done
        length = min(guess, left)
        # A last step that is much shorter than the others costs as much as they do.
        if length > 0.6 * left:
            length = left
        # Two times that differ by less are one; within a moment loads change by less than the tolerance.
        grain = 1e-15 if passing != TIME_PASSES else max(4e-16 * abs(room.state[TIME]), 1e-18 * span)
        instant, jumps = grain, 0
        speed = max(abs(room.state[RATE]), scales.depth / duration)
        moment = max(grain, _MOMENT * tolerance * scales.stress / (problem.solid.glass * speed))
        kind, hunted, tries, chased, aims, aimed = first_kind, NOTHING, 0, math.inf, 0, math.inf
        plain = length
        if falls and phase == SHRINKS:
            if is_unfelt(problem, room, left):
                room.state[TIME], first_kind, joint = driver.knots[piece + 1], 1, KINK
                if not sweep(problem, room, -1, 0.0):
                    return NO_ROOM
                outcome = finish_sweep(problem, room)
                if outcome != DONE:
                    return outcome
                break
            if first_kind == 1 and left <= min(reach, 4.0 * guess) and end_of_way(room, phase)[1] == 0:
                # The end of a force is known.
                kind, hunted, length, aim = -problem.power, ENDS, left, span
        is_known = goal != NOTHING and first_kind == 1 and aim - done <= min(reach, left)
        if is_known:
            # Where the front's way ends is known from a longer step.
            kind, hunted, length, instant = goal_kind, goal, aim - done, max(grain, 1e-13 * (aim - done))
            goal = NOTHING
        last_length, last_value, error = 0.0, -math.inf, math.inf
        while True:
            tries += 1
            if tries > _MOST_TRIES:
                return NOT_SOLVED
            error = math.inf
            step = Step(phase, passing, piece, done, length, span, kind)
            if solve_step(problem, room, step):
                error = step_error(problem, room, phase, length if passing == TIME_PASSES else 0.0)
            if length < moment and phase != FREE:
                jumps += 1
                if passing == TIME_PASSES and jumps < _MOST_JUMPS and jump_ahead(problem, room, phase, moment):
                    if phase == SHRINKS and room.places[FOLLOWING] == 0:
                        # The last elements have left.
                        hunted, length, instant = ENDS, 0.0, grain
                        break
                    hunted, kind, length = NOTHING, 1, min(left, 16.0 * moment)
                    continue
                moment = grain
            if length < grain:
                return TOO_STEEP
            if hunted == NOTHING:
                # Behind a joint or the end a step is not smooth, but the event, which follows from the depth, is.
                event, z = NOTHING, 2.0
                if error < _COARSE:
                    event, z = first_event(problem, room, phase, passing, length, error, switches > 4)
                passed = share(kind, z)[0]
                if event != NOTHING and z < rule.c[1] and error > tolerance and length > 64.0 * moment:
                    # Whether an event before the first node is at the start only a shorter step can decide.
                    length *= 0.25
                    continue
                if event == ENDS and fades:
                    length *= 0.6 * passed
                    continue
                # The end of a force is known where the step up to there is not solved.
                ends = is_force(driver) and phase == SHRINKS and end_of_way(room, phase)[1] == 0
                coarse = tolerance < error < _COARSE or (error == math.inf and ends)
                if event == NOTHING and coarse and aimed > length and phase != FREE:
                    event, passed = event_ahead(problem, room, phase, kind)
                    aims += 1
                    if aims > _MOST_AIMS or (event == ENDS and fades):
                        event = NOTHING
                    if event != NOTHING:
                        aimed = length
                        if length * passed > left:
                            event = NOTHING
                if event == NOTHING:
                    if error <= tolerance:
                        break
                    length *= factor_of(tolerance, error, kind, 0.1, 0.7) if error < math.inf else 0.25
                    continue
                panels, p = end_of_way(room, phase)
                backward = event == ENDS or (event == JOINT and panels.joint[p] >= FLAT)
                aim = done + length * passed
                if backward and length * passed > reach:
                    # A step of half the way is smooth.
                    length *= min(0.5 * passed, 0.7)
                    continue
                if backward and first_kind != 1:
                    # A step has one map: first a step that does not reach the event.
                    length *= 0.5 * passed
                    continue
                hunted, instant = event, max(grain, 1e-13 * length)
                plain = length * factor_of(tolerance, error, kind, 0.1, 0.7)
                last_length, last_value = 0.0, -math.inf
                length *= passed
                if backward:
                    # Where a force falls to zero the end is like the touch, else like a root of the time left.
                    kind = BACKWARD if event == JOINT or not ends_by_load(problem.solid, driver) else -problem.power
                if length < instant:
                    break
                continue
            if not error <= tolerance:
                clearer = error < min(_CLEARER * chased, _CHASED * tolerance)
                if passing == TIME_PASSES and error < _COARSE and kind < 0 and clearer:
                    # The front is not smooth while its way ends elsewhere, but where it ends becomes clearer.
                    chased = error
                    last, before = NODES - 1, NODES - (3 if kind < BACKWARD else 5)
                    value = write_event(problem, room, phase, hunted)
                    slope = (value - room.nodes[EVENT, before]) / (room.times[last] - room.times[before])
                    change = -value / slope if slope > 0.0 else 0.0
                    if value > 0.0 and last_length > 0.0 and length + change <= last_length < length:
                        # Not before a step that ends within the way.
                        change = 0.5 * (last_length - length)
                    if 1e-7 * length < abs(change) < 0.3 * length and length + change <= left:
                        length += change
                        continue
                if kind < 0 and error < math.inf:
                    # The end of the front's way is aimed at again from where this step would do.
                    reach = min(reach, 1.2 * length * factor_of(tolerance, error, kind, 0.0, 1.0))
                    if error < _KNOWN * tolerance:
                        goal, goal_kind, aim = hunted, kind, done + length
                    length = min(max(plain, length * factor_of(tolerance, error, 1, 0.1, 0.5)), 0.5 * length)
                    aimed = length
                else:
                    length *= factor_of(tolerance, error, kind, 0.1, 0.7) if error < math.inf else 0.25
                hunted, kind = NOTHING, first_kind
                continue
            if falls and hunted == ENDS:
                break
            if kind < 0 and last_value == -math.inf:
                event, z = first_event(problem, room, phase, passing, length, error, switches > 4)
                if event == TURNS and z < 1.0:
                    length *= share(kind, z)[0]
                    hunted, kind, instant = TURNS, first_kind, max(grain, 1e-13 * length)
                    continue
            # Secant steps to the zero of the event at the end; the first slope is that over the last two nodes.
            value, before = write_event(problem, room, phase, hunted), share(kind, rule.c[NODES - 2])[0]
            apart = min(value, last_value) < 0.0 < max(value, last_value)
            rises = apart or (value - last_value) * (length - last_length) > 0.0
            if abs(value) >= abs(last_value) and not (rises and abs(length - last_length) > _CLOSE * length):
                # The event has only rounding left; the step before was the best.
                length, last_value = last_length, math.inf
                continue
            slope = (value - room.nodes[EVENT, NODES - 2]) / (length * (1.0 - before))
            if last_value > -math.inf and last_value < math.inf:
                slope = (value - last_value) / (length - last_length)
            change = -value / slope if slope > 0.0 else 0.0
            if is_known and kind < 0 and (not slope > 0.0 or abs(change) > 0.1 * length or length + change > left):
                # The front's way ends elsewhere.
                hunted, kind, length, is_known = NOTHING, first_kind, plain, False
                continue
            if hunted == TURNS and value < 0.0 and slope <= 0.0 and last_value == -math.inf:
                # The event was one of the error of the longer step.
                hunted = NOTHING
                break
            # A force or a spring follows rounding of the front, others do not.
            felt = 0.0 if is_light(problem) else 0.1 if kind < 0 else 1.0
            close = max(grain, felt * _SAME_TIME * length)
            if abs(change) <= close or last_value == math.inf or (tries > 40 and abs(change) <= _CLOSE * length):
                break
            if tries > 40:
                hunted, kind, length = NOTHING, first_kind, 0.5 * length
                continue
            last_length, last_value = length, value
            length = min(max(length + change, 0.5 * length), min(1.5 * length, left))
        if hunted != NOTHING and length < instant:
            # The event is at the start.
            switches += 1
            if switches > _MOST_SWITCHES:
                return NOT_SOLVED
            if hunted == TOUCHES:
                begin_contact(problem, room)
            elif hunted in (JOINT, ENDS):
                _, p = end_of_way(room, phase)
                while room.places[ahead(room, phase)[1]] > max(p, 0):
                    jump(problem, room, phase, 0.0, KINK)
                if hunted == ENDS:
                    end_contact(problem, room)
        else:
            switches = 0
            size = room.places[FOLLOWING] + room.places[FREE_PANELS] + _MOST_JUMPS
            if room.places[RECORDS] >= min(most, room.records.start.shape[0]) or size >= room.free.start.shape[0]:
                return NO_ROOM
            if passing == TIME_PASSES and strays(problem, room, phase):
                return NOT_SOLVED
            done = span if left - length <= max(4.0 * grain, 1e-15 * span) else done + length
            stop = room.state[TIME]
            if passing == TIME_PASSES:
                stop = driver.knots[piece + 1] if done == span else driver.knots[piece] + done
            accept(problem, room, step, hunted, joint, stop)
            guess = max(length, 0.5 * stride)
            if hunted == NOTHING:
                # The error of the step before tells how fast the solution becomes smoother.
                trend = length / old_length * (old_error / max(error, 1e-30)) ** (1.0 / STAGES)
                trend = min(max(trend, 0.7), 2.0) if old_length < math.inf else 1.0
                old_length, old_error = length, error
                guess = length * factor_of(tolerance, error, 1, 0.3, 4.0) * trend
                stride = max(stride, guess) if reach < math.inf else guess
                if aim - done > reach:
                    guess = min(guess, 0.5 * (aim - done))
            else:
                stride = guess
            over = fades and phase == SHRINKS and hunted in (NOTHING, JOINT) and is_nearly_over(problem, room, length)
            if over and not sweep(problem, room, -1, 0.0):
                return NO_ROOM
        if hunted != ENDS and phase == SHRINKS and room.places[FOLLOWING] == 0:
            # The innermost elements left within rounding.
            hunted = ENDS
            room.records.event[room.places[RECORDS] - 1] = ENDS
            end_contact(problem, room)
        if hunted == ENDS and driver.stiffness > 0.0 and is_light(problem):
            # Without a force.
            room.state[DEPTH] = prescribed_at(driver, piece, done / span, room.state[TIME])[0] / driver.stiffness
        began, joint, first_kind = first_kind, SMOOTH, 1
        if hunted != NOTHING:
            reach, goal = math.inf, NOTHING
        if hunted == TURNS:
            phase, joint = (SHRINKS if phase == GROWS else GROWS), FLAT
            if phase == SHRINKS and problem.solid.viscosity > 0.0:
                # The front leaves at once, through elements that it reached like a root of the time.
                first_kind = 2
        elif hunted == TOUCHES:
            phase, first_kind, guess = GROWS, problem.power, left
        elif hunted == ENDS:
            phase, guess = FREE, math.inf
        elif hunted == JOINT:
            joint, first_kind = KINK, kind_behind_joint(room, phase)
            if switches > 0 and room.state[FRONT] * room.state[FRONT] < AT_AXIS:
                # A contact that has just begun grows on like a root.
                first_kind = began
        elif hunted == BENDS:
            joint, first_kind = CORNER, 2
        room.places[PHASE] = phase
        if hunted == ENDS and driver.once:
            return APART
    start[0], start[1] = first_kind, joint
    if passing == TIME_PASSES:
        start[2] = guess
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
