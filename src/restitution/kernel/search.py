"""Search for the next step of a history: its length, and the event at its end.

A step is solved with one length after another, until its error is below the tolerance and no event lies within it. An
event within a step is the zero of a smooth function at its end then: the step ends there, and the zero is found by
secants. Where the front's way ends like a root of the time that is left, only a step that ends there is smooth.
"""

import math

from restitution.kernel.accuracy import step_error
from restitution.kernel.compile import compiled, inlined
from restitution.kernel.driver import (
    AIM,
    AIMED,
    AIMS,
    CHASED,
    DONE,
    ENDS,
    ERROR,
    EVENT,
    FIRST_KIND,
    FOLLOWING,
    FREE,
    GOAL,
    GOAL_KIND,
    GRAIN,
    GUESS,
    HUNTED,
    INSTANT,
    JOINT,
    JUMPS,
    KIND,
    KNOWN,
    LAST_LENGTH,
    LAST_VALUE,
    LENGTH,
    MOMENT,
    NOT_SOLVED,
    NOTHING,
    PASSED,
    PHASE,
    PLAIN,
    RATE,
    REACH,
    SHRINKS,
    SWITCHES,
    TIME,
    TIME_PASSES,
    TOO_STEEP,
    TRIES,
    TURNS,
    Piece,
    Problem,
    Room,
    Step,
    ends_by_load,
    is_force,
    is_light,
)
from restitution.kernel.events import end_of_way, event_ahead, first_event, write_event
from restitution.kernel.jumps import jump_ahead
from restitution.kernel.panels import BACKWARD, FLAT, NODES, STAGES, share
from restitution.kernel.stepper import solve_step

# Error up to which the events of a step are looked for.
_COARSE = 0.05
# Change of the length of a step to an event, over the length, that is not felt; a tenth where the front is fast.
_SAME_TIME = 1e-12
# Loads that change within a moment, over the tolerance.
MOMENTARY = 0.05
# Difference of two lengths of a step, over the length, that a secant has when only rounding is left between them.
_CLOSE = 1e-6
_MOST_TRIES, _MOST_SECANTS = 200, 40
MOST_JUMPS = 20
# Error of a step to the end of the front's way, over the tolerance, and over that of the try before, from which on
# the next try may be good enough.
_CHASED, _CLEARER = 1e5, 0.25
# Error of such a step, over the tolerance, from which on the end of the front's way is known.
_KNOWN = 1e5
# Steps of one start that are lengthened to an event behind them: not again and again, if none is smooth enough.
_MOST_AIMS = 4
# Breaks without a step between them from which on turnings are rounding.
_SETTLED = 4


@inlined
def factor_of(tolerance: float, error: float, kind: int, least: float, most: float) -> float:
    """Return the factor for the length of the next step after one with this error.

    Over z a power of the time has a higher degree, so that the error falls with a lower power of the length.
    """
    order = STAGES / min(max(abs(kind), 1.0), 4.0)
    return min(max(0.8 * (tolerance / max(error, 1e-30)) ** (1.0 / order), least), most)


@inlined
def _shortened(tolerance: float, error: float, kind: int) -> float:
    """Return the factor for the length of a step whose error is too large; infinite where it is not solved."""
    return factor_of(tolerance, error, kind, 0.1, 0.7) if error < math.inf else 0.25


@inlined
def step_of(room: Room, piece: Piece) -> Step:
    """Return the step that the search tries."""
    course = room.course
    return Step(
        room.places[PHASE], piece.passing, piece.number, course[PASSED], course[LENGTH], piece.span, room.marks[KIND]
    )


@compiled
def _begin(problem: Problem, room: Room, piece: Piece) -> None:
    """Choose the first length of a step, and the event at its end where that is known."""
    course, marks, scales, driver = room.course, room.marks, problem.scales, problem.driver
    phase, left = room.places[PHASE], piece.span - course[PASSED]
    length = min(course[GUESS], left)
    # A last step that is much shorter than the others costs as much as they do.
    if length > 0.6 * left:
        length = left
    # Two times that differ by less are one; within a moment loads change by less than the tolerance.
    grain = 1e-15
    if piece.passing == TIME_PASSES:
        grain = max(4e-16 * abs(room.state[TIME]), 1e-18 * piece.span)
    duration = driver.knots[driver.knots.shape[0] - 1] - driver.knots[0]
    speed = max(abs(room.state[RATE]), scales.depth / duration)
    course[GRAIN], course[INSTANT], course[PLAIN] = grain, grain, length
    course[MOMENT] = max(grain, MOMENTARY * scales.tolerance * scales.stress / (problem.solid.glass * speed))
    course[LAST_LENGTH], course[LAST_VALUE] = 0.0, -math.inf
    course[CHASED], course[AIMED] = math.inf, math.inf
    marks[KIND], marks[HUNTED] = marks[FIRST_KIND], NOTHING
    marks[TRIES], marks[JUMPS], marks[AIMS] = 0, 0, 0
    falls = piece.falls and phase == SHRINKS and marks[FIRST_KIND] == 1
    if falls and left <= min(course[REACH], 4.0 * course[GUESS]) and end_of_way(room, phase)[1] == 0:
        # The end of a force is known.
        marks[KIND], marks[HUNTED], length, course[AIM] = -problem.power, ENDS, left, piece.span
    way = course[AIM] - course[PASSED]
    marks[KNOWN] = 0
    if marks[GOAL] != NOTHING and marks[FIRST_KIND] == 1 and way <= min(course[REACH], left):
        # Where the front's way ends is known from a longer step.
        marks[KIND], marks[HUNTED], marks[KNOWN], marks[GOAL] = marks[GOAL_KIND], marks[GOAL], 1, NOTHING
        length, course[INSTANT] = way, max(grain, 1e-13 * way)
    course[LENGTH] = length


@compiled
def _pass_moment(problem: Problem, room: Room, piece: Piece) -> bool:
    """Let elements jump that leave or touch within a moment; return whether the search goes on with another length."""
    course, marks, phase = room.course, room.marks, room.places[PHASE]
    marks[JUMPS] += 1
    jumps = piece.passing == TIME_PASSES and marks[JUMPS] < MOST_JUMPS
    if not (jumps and jump_ahead(problem, room, phase, course[MOMENT])):
        course[MOMENT] = course[GRAIN]
        return False
    if phase == SHRINKS and room.places[FOLLOWING] == 0:
        # The last elements have left.
        marks[HUNTED], course[LENGTH], course[INSTANT] = ENDS, 0.0, course[GRAIN]
    else:
        marks[HUNTED], marks[KIND] = NOTHING, 1
        course[LENGTH] = min(piece.span - course[PASSED], 16.0 * course[MOMENT])
    return True


@compiled
def _event_behind(problem: Problem, room: Room, piece: Piece) -> tuple[int, float]:
    """Return the event that is soon behind a coarse step, and after how many steps."""
    course, marks, phase = room.course, room.marks, room.places[PHASE]
    error, length = course[ERROR], course[LENGTH]
    # The end of a force is known where the step up to there is not solved.
    ends = is_force(problem.driver) and phase == SHRINKS and end_of_way(room, phase)[1] == 0
    coarse = problem.scales.tolerance < error < _COARSE or (error == math.inf and ends)
    if not (coarse and course[AIMED] > length and phase != FREE):
        return NOTHING, 0.0
    event, passed = event_ahead(problem, room, phase, marks[KIND])
    marks[AIMS] += 1
    if marks[AIMS] > _MOST_AIMS or (event == ENDS and piece.fades):
        event = NOTHING
    if event != NOTHING:
        course[AIMED] = length
        if length * passed > piece.span - course[PASSED]:
            event = NOTHING
    return event, passed


@compiled
def _look_for_event(problem: Problem, room: Room, piece: Piece) -> bool:
    """Choose the next length of a step without a known event; return whether the present one will do."""
    course, marks, phase, tolerance = room.course, room.marks, room.places[PHASE], problem.scales.tolerance
    length, error, kind = course[LENGTH], course[ERROR], marks[KIND]
    # Behind a joint or the end a step is not smooth, but the event, which follows from the depth, is.
    event, z = NOTHING, 2.0
    if error < _COARSE:
        event, z = first_event(problem, room, phase, piece.passing, length, error, marks[SWITCHES] > _SETTLED)
    passed = share(kind, z)[0]
    if event != NOTHING and z < problem.rule.c[1] and error > tolerance and length > 64.0 * course[MOMENT]:
        # Whether an event before the first node is at the start only a shorter step can decide.
        course[LENGTH] = length * 0.25
        return False
    if event == ENDS and piece.fades:
        course[LENGTH] = length * (0.6 * passed)
        return False
    if event == NOTHING:
        event, passed = _event_behind(problem, room, piece)
    if event == NOTHING:
        if not error <= tolerance:
            course[LENGTH] = length * _shortened(tolerance, error, kind)
        return error <= tolerance
    panels, p = end_of_way(room, phase)
    backward = event == ENDS or (event == JOINT and panels.joint[p] >= FLAT)
    course[AIM] = course[PASSED] + length * passed
    if backward and length * passed > course[REACH]:
        # A step of half the way is smooth.
        course[LENGTH] = length * min(0.5 * passed, 0.7)
        return False
    if backward and marks[FIRST_KIND] != 1:
        # A step has one map: first a step that does not reach the event.
        course[LENGTH] = length * (0.5 * passed)
        return False
    marks[HUNTED], course[INSTANT] = event, max(course[GRAIN], 1e-13 * length)
    course[PLAIN] = length * factor_of(tolerance, error, kind, 0.1, 0.7)
    course[LAST_LENGTH], course[LAST_VALUE] = 0.0, -math.inf
    course[LENGTH] = length * passed
    if backward:
        # Where a force falls to zero the end is like the touch, else like a root of the time left.
        by_root = event == JOINT or not ends_by_load(problem.solid, problem.driver)
        marks[KIND] = BACKWARD if by_root else -problem.power
    return course[LENGTH] < course[INSTANT]


@compiled
def _is_clearer(problem: Problem, room: Room, piece: Piece) -> bool:
    """Choose a better length of a coarse step to the end of the front's way; return whether there is one.

    The front is not smooth while its way ends elsewhere, but where it ends becomes clearer.
    """
    course, marks, tolerance = room.course, room.marks, problem.scales.tolerance
    length, error, kind = course[LENGTH], course[ERROR], marks[KIND]
    clearer = error < min(_CLEARER * course[CHASED], _CHASED * tolerance)
    if not (piece.passing == TIME_PASSES and error < _COARSE and kind < 0 and clearer):
        return False
    course[CHASED] = error
    last, before = NODES - 1, NODES - (3 if kind < BACKWARD else 5)
    value = write_event(problem, room, room.places[PHASE], marks[HUNTED])
    slope = (value - room.nodes[EVENT, before]) / (room.times[last] - room.times[before])
    change = -value / slope if slope > 0.0 else 0.0
    if value > 0.0 and course[LAST_LENGTH] > 0.0 and length + change <= course[LAST_LENGTH] < length:
        # Not before a step that ends within the way.
        change = 0.5 * (course[LAST_LENGTH] - length)
    if not (1e-7 * length < abs(change) < 0.3 * length and length + change <= piece.span - course[PASSED]):
        return False
    course[LENGTH] = length + change
    return True


@compiled
def _aim_again(problem: Problem, room: Room, piece: Piece) -> None:
    """Choose the next length of a step to an event whose error is too large."""
    course, marks, tolerance = room.course, room.marks, problem.scales.tolerance
    if _is_clearer(problem, room, piece):
        return
    length, error, kind = course[LENGTH], course[ERROR], marks[KIND]
    if kind < 0 and error < math.inf:
        # The end of the front's way is aimed at again from where this step would do.
        course[REACH] = min(course[REACH], 1.2 * length * factor_of(tolerance, error, kind, 0.0, 1.0))
        if error < _KNOWN * tolerance:
            marks[GOAL], marks[GOAL_KIND], course[AIM] = marks[HUNTED], kind, course[PASSED] + length
        length = min(max(course[PLAIN], length * factor_of(tolerance, error, 1, 0.1, 0.5)), 0.5 * length)
        course[AIMED] = length
    else:
        length *= _shortened(tolerance, error, kind)
    course[LENGTH], marks[HUNTED], marks[KIND] = length, NOTHING, marks[FIRST_KIND]


@compiled
def _close_in(problem: Problem, room: Room, piece: Piece) -> bool:
    """Take a secant step to the zero of the event at the end of a step; return whether the present length will do.

    The first slope is that over the last two nodes.
    """
    course, marks, phase = room.course, room.marks, room.places[PHASE]
    length, error, kind, left = course[LENGTH], course[ERROR], marks[KIND], piece.span - course[PASSED]
    last_length, last_value = course[LAST_LENGTH], course[LAST_VALUE]
    if kind < 0 and last_value == -math.inf:
        event, z = first_event(problem, room, phase, piece.passing, length, error, marks[SWITCHES] > _SETTLED)
        if event == TURNS and z < 1.0:
            course[LENGTH] = length * share(kind, z)[0]
            marks[HUNTED], marks[KIND] = TURNS, marks[FIRST_KIND]
            course[INSTANT] = max(course[GRAIN], 1e-13 * course[LENGTH])
            return False
    value, before = write_event(problem, room, phase, marks[HUNTED]), share(kind, problem.rule.c[NODES - 2])[0]
    apart = min(value, last_value) < 0.0 < max(value, last_value)
    rises = apart or (value - last_value) * (length - last_length) > 0.0
    if abs(value) >= abs(last_value) and not (rises and abs(length - last_length) > _CLOSE * length):
        # The event has only rounding left; the step before was the best.
        course[LENGTH], course[LAST_VALUE] = last_length, math.inf
        return False
    slope = (value - room.nodes[EVENT, NODES - 2]) / (length * (1.0 - before))
    if last_value > -math.inf and last_value < math.inf:
        slope = (value - last_value) / (length - last_length)
    change = -value / slope if slope > 0.0 else 0.0
    if marks[KNOWN] > 0 and kind < 0 and (not slope > 0.0 or abs(change) > 0.1 * length or length + change > left):
        # The front's way ends elsewhere.
        marks[HUNTED], marks[KIND], marks[KNOWN], course[LENGTH] = NOTHING, marks[FIRST_KIND], 0, course[PLAIN]
        return False
    if marks[HUNTED] == TURNS and value < 0.0 and slope <= 0.0 and last_value == -math.inf:
        # The event was one of the error of the longer step.
        marks[HUNTED] = NOTHING
        return True
    # A force or a spring follows rounding of the front, others do not.
    felt = 0.0 if is_light(problem) else 0.1 if kind < 0 else 1.0
    close, many = max(course[GRAIN], felt * _SAME_TIME * length), marks[TRIES] > _MOST_SECANTS
    if abs(change) <= close or last_value == math.inf or (many and abs(change) <= _CLOSE * length):
        return True
    if many:
        marks[HUNTED], marks[KIND], course[LENGTH] = NOTHING, marks[FIRST_KIND], 0.5 * length
        return False
    course[LAST_LENGTH], course[LAST_VALUE] = length, value
    course[LENGTH] = min(max(length + change, 0.5 * length), min(1.5 * length, left))
    return False


@compiled
def find_step(problem: Problem, room: Room, piece: Piece) -> int:
    """Find the next step, and write its nodes; return the outcome.

    `LENGTH` is that of the step and `HUNTED` the event at its end. Below the length `INSTANT` the event is at the
    start of the step.
    """
    course, marks, tolerance = room.course, room.marks, problem.scales.tolerance
    _begin(problem, room, piece)
    while True:
        marks[TRIES] += 1
        if marks[TRIES] > _MOST_TRIES:
            return NOT_SOLVED
        step = step_of(room, piece)
        course[ERROR] = math.inf
        if solve_step(problem, room, step):
            time = step.length if piece.passing == TIME_PASSES else 0.0
            course[ERROR] = step_error(problem, room, step.phase, time)
        if step.length < course[MOMENT] and step.phase != FREE and _pass_moment(problem, room, piece):
            if marks[HUNTED] == ENDS:
                return DONE
            continue
        if step.length < course[GRAIN]:
            return TOO_STEEP
        if marks[HUNTED] == NOTHING:
            if _look_for_event(problem, room, piece):
                return DONE
        elif not course[ERROR] <= tolerance:
            _aim_again(problem, room, piece)
        elif (piece.falls and marks[HUNTED] == ENDS) or _close_in(problem, room, piece):
            return DONE
