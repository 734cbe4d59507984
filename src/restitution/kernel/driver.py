"""What moves a body in contact, and the room in which it is followed.

A body is moved by its depth, a force, a spring, or all that acts on a mass; with f piecewise polynomial plus a cosine,

    by depth:   d = f(t)
    otherwise:  m d'' + c d' + k d = f(t) - F + pull    (a force for m = c = k = 0, a spring for m = c = 0)

A mass may carry the body together with the higher modes of a cantilever (lever.py).

Phases: FREE (no contact), GROWS (the gap closes at the front) and SHRINKS (the load vanishes at the front).
"""

import math
from threading import local
from typing import Any, NamedTuple

import numpy as np

from restitution.checks import Array
from restitution.kernel.compile import inlined
from restitution.kernel.lanes import WIDTH
from restitution.kernel.panels import NODES, STAGES, Scheme, Solid, Stack, stack
from restitution.kernel.path import Path, radius_and_integral
from restitution.kernel.references import by_reference

FREE, GROWS, SHRINKS = range(3)
# What passes in a step: time, or a jump of what is prescribed.
TIME_PASSES, VALUE_JUMPS = range(2)
# What ends a step.
NOTHING, TURNS, JOINT, ENDS, TOUCHES, BENDS = range(6)
# Outcomes of a run.
DONE, NO_ROOM, NOT_SOLVED, TOO_STEEP, APART = range(5)

# Numbers in `Room.state` and in `Room.places`, and rows of `Room.nodes`.
TIME, FRONT, DEPTH, RATE, WORK, FORCE = range(6)
PHASE, FOLLOWING, FREE_PANELS, RECORDS, NO_FRONT_YET, CROWD = range(6)
D, V, Y, A, PI, F, EVENT, GIVEN, PACE, SLOPE, PULL, BELOW, RISE = range(13)
# Numbers in `Room.course`. Of a piece of what is prescribed: the part that has passed; length to try next, and that
# before steps were shortened to an event; longest step to where the front's way ends, and that place; length and error
# of the last step without an event. Of the search for a step: its length, error, and length without the event; length
# below which the event is at the start, below which loads jump, and below which two times are one; length and value of
# the event in the trial before; error of the best step to the end of the front's way; length from which it is aimed
# at.
(
    PASSED, GUESS, STRIDE, REACH, AIM, OLD_LENGTH, OLD_ERROR, LENGTH, ERROR, PLAIN, INSTANT, MOMENT, GRAIN,
    LAST_LENGTH, LAST_VALUE, CHASED, AIMED, N_COURSE
) = range(18)  # fmt: skip
# Numbers in `Room.marks`. Of a piece: map and joint of the next step, event at `AIM` that is known from a longer step,
# its map, breaks in a row without a step. Of the search for a step: its map, the event at its end, trials, jumps,
# events that were aimed at, whether the event is the known one.
FIRST_KIND, BEHIND, GOAL, GOAL_KIND, SWITCHES, KIND, HUNTED, TRIES, JUMPS, AIMS, KNOWN, N_MARKS = range(12)

NEVER = np.zeros(0, dtype=np.bool_)
# Columns of a matrix for the nodes of a step, in two vectors of the processor.
WIDE = 2 * WIDTH
# Panels of the scratch space are a multiple of this number, so that it serves runs of several sizes.
_PANELS = 32
# Sizes of scratch space that a thread keeps.
_MOST_SPACES = 4
# Halvings of a number of panels.
HALVINGS = 64


# Force of a spring, over k times the depth, below which the difference of base and depth has too few digits.
_FEW_DIGITS = 1e-4
# A body without higher modes.
_ALONE = np.zeros((0, 3))


@by_reference
class Driver(NamedTuple):
    """What moves the body; dimensionless."""

    by_depth: bool
    knots: Any  # (m + 1,): times; two equal ones enclose a jump
    values: Any  # (m, n): coefficients of f over the share of the piece, constant first
    smooth: Any  # (m + 1,): whether f is smooth at the knot
    mass: float
    damping: float
    stiffness: float
    amplitude: float  # Of the cosine
    frequency: float
    phase: float
    once: bool = False  # whether the run ends with the first contact
    attraction: float = 0.0  # C of the pull C/(gap + cutoff)^2 by the surface on a mass
    cutoff: float = 1.0
    modes: Any = _ALONE  # (M, 3): mass, damping and stiffness of higher modes
    backward: Any = NEVER  # (m,): whether the share counts from the end of the piece, where a force is zero


@by_reference
class Scales(NamedTuple):
    """Sizes with which errors are compared."""

    depth: float
    force: float
    stress: float
    tolerance: float  # Of a step; errors of steps add up


@by_reference
class Problem(NamedTuple):
    """What does not change in a run."""

    solid: Solid
    path: Path
    driver: Driver
    rule: Scheme
    scales: Scales
    power: int  # y grows like t^(1/power) after a touch


class Piece(NamedTuple):
    """A piece of what is prescribed."""

    number: int
    passing: int
    span: float
    falls: bool  # A force that is zero at the end
    fades: bool  # Whether the end of a contact has no exponent


class Step(NamedTuple):
    """A step, from `done` on in a piece of what is prescribed."""

    phase: int
    passing: int
    piece: int
    done: float
    length: float
    span: float  # Of the piece
    kind: int  # Map from z to the share of the step


@by_reference
class Records(NamedTuple):
    """Accepted steps: Chebyshev coefficients over z of depth, rate, force and y, and of the depths of higher modes."""

    start: Any  # (R,)
    length: Any  # (R,)
    kind: Any  # (R,): map of the step
    phase: Any  # (R,)
    event: Any  # (R,): what ends the step
    columns: Any  # (R, 4 + M, N)


@by_reference
class Room(NamedTuple):
    """State of a run, and scratch space of a step; the first of the N nodes is the start of the step."""

    following: Stack
    free: Stack
    records: Records
    state: Any  # Floats, see TIME
    places: Any  # Integers, see PHASE
    course: Any  # Floats, see PASSED
    marks: Any  # Integers, see FIRST_KIND
    memory: Any  # (K,): h_k now
    sums: Any  # (K,): L_k now
    swing: Any  # (M, 2): depths and velocities of the higher modes now
    times: Any  # (W,), padded as all rows of W numbers, so that those of the nodes are two vectors of the processor
    weights: Any  # (N,): slope of the time over z
    nodes: Any  # (13, W), see D; PACE: rate of GIVEN; RISE: its increase; SLOPE: that of load or gap over y at the
    # front; BELOW: of D, the part below the surface at the axis, which lies at EVENT, where a contact begins, or that
    # since the start of the step where rates are the unknowns
    h: Any  # (K, W)
    L: Any  # (K, W)
    loads: Any  # (K, W): l_k at the front
    displacements: Any  # (J, W): w_j at the front
    swept: Any  # (J, N): int w_j da at the front since the start of the step
    z: Any  # (W,)
    eight: Any  # (2, N, 8): polynomials and their slopes at eight nodes
    decays: Any  # (max(K, J), 8)
    radii: Any  # (2, 8)
    integral: Any  # (S, W - 1): A diag(weights)
    inverse: Any  # (K, S, W - 1): of I + rho_k A diag(weights)
    stiffness: Any  # (S, W - 1): slopes of the forces by the depths
    jacobian: Any  # (S, W - 1), and its factors
    matrix: Any  # (S, S + 1)
    vectors: Any  # (8, N)
    basis: Any  # (2, N)
    parts: Any  # (max(K, J),)
    response: Any  # (S, 2 S + 1)
    mobility: Any  # (S, S): loss of velocity by forces at the nodes
    unloaded: Any  # (S,): velocities without a force
    mobilities: Any  # (M, S, S): of the higher modes
    swings: Any  # (M, 2, N)
    spare_values: Any  # (1 + max(2 K, J), N)
    spare_parts: Any  # (max(2 K, J),)
    at: Any  # (N,): panel of the front
    pivots: Any  # (S,): rows of the factors that are exchanged
    pending: Any  # (64, 2): panels that are still to be merged
    spare_following: Any  # (2, P, 1 + 2 K, N): panels that are merged
    spare_free: Any  # (2, P, 1 + J, N)
    firsts: Any  # (P,): first of the panels that one replaces


class _Kept(local):
    """Scratch spaces by their sizes, which a thread keeps: new memory costs as much as ten steps."""

    def __init__(self) -> None:
        self.spaces: dict[tuple[int, ...], tuple[Array, tuple[Any, ...]]] = {}


_kept = _Kept()


def _scratch(*size: int) -> tuple[Any, ...]:
    """Return scratch space for numbers of branches, rates of recovery, higher modes and panels; its floats are 0."""
    if size not in _kept.spaces:
        (K, J, M, panels), whole = size, np.int64
        N, W, S, more = NODES, 1 + WIDE, STAGES, max(K, J)
        shapes = (
            (W,), (N,), (13, W), (K, W), (K, W), (K, W), (J, W), (J, N), (W,), (2, N, WIDTH), (more, WIDTH),
            (2, WIDTH), (S, WIDE), (K, S, WIDE), (S, WIDE), (S, WIDE), (S, S + 1), (8, N), (2, N), (more,),
            (S, 2 * S + 1), (S, S), (S,), (M, S, S), (M, 2, N), (1 + max(2 * K, J), N), (max(2 * K, J),),
        )  # fmt: skip
        sizes = [math.prod(shape) for shape in shapes]
        numbers = np.zeros(sum(sizes))
        rows = np.split(numbers, np.cumsum(sizes[:-1]))
        if len(_kept.spaces) == _MOST_SPACES:
            _kept.spaces.clear()
        _kept.spaces[size] = numbers, (
            *(row.reshape(shape) for row, shape in zip(rows, shapes, strict=True)),
            np.zeros(N, dtype=whole), np.zeros(S, dtype=whole), np.zeros((HALVINGS, 2), dtype=whole),
            np.zeros((2, panels, 1 + 2 * K, N)), np.zeros((2, panels, 1 + J, N)), np.zeros(panels, dtype=whole),
        )  # fmt: skip
    numbers, scratch = _kept.spaces[size]
    numbers[:] = 0.0
    return scratch


def room(solid: Solid, panels: int, records: int, modes: int = 0) -> Room:
    """Return a body above virgin surface, with room for a number of panels and steps.

    Its scratch space serves the next room of this thread as well.
    """
    K, J, M, N = solid.rates.size, solid.recoveries.size, modes, NODES
    whole = np.int64
    kept = Records(
        np.zeros(records), np.zeros(records), np.zeros(records, dtype=whole), np.zeros(records, dtype=whole),
        np.zeros(records, dtype=whole), np.zeros((records, 4 + M, N)),
    )  # fmt: skip
    return Room(
        stack(panels, 1 + 2 * K), stack(panels, 1 + J), kept, np.zeros(6), np.zeros(6, dtype=whole),
        np.zeros(N_COURSE), np.zeros(N_MARKS, dtype=whole), np.zeros(K), np.zeros(K), np.zeros((M, 2)),
        *_scratch(K, J, M, -(-panels // _PANELS) * _PANELS),
    )  # fmt: skip


@inlined
def ahead(room: Room, phase: int) -> tuple[Stack, int]:
    """Return the stack which the front goes through, and the place of its size."""
    if phase == GROWS:
        return room.free, FREE_PANELS
    return room.following, FOLLOWING


@inlined
def is_force(driver: Driver) -> bool:
    """Return whether a force is prescribed: a driver without mass and stiffness."""
    return not (driver.by_depth or driver.mass > 0.0 or driver.stiffness > 0.0)


@inlined
def is_light(problem: Problem) -> bool:
    """Return whether the force on the contact follows from what is prescribed and the depth: without inertia."""
    return not (problem.driver.by_depth or problem.driver.mass > 0.0)


@inlined
def ends_by_load(solid: Solid, driver: Driver) -> bool:
    """Return whether what is prescribed tells where the force vanishes, while loads may be like a root of the time."""
    return is_force(driver) or (solid.viscosity > 0.0 and not (driver.by_depth or driver.mass > 0.0))


@inlined
def fades_out(problem: Problem) -> bool:
    """Return whether the end of a contact has no exponent: of a cone on a spring and a dashpot.

    Of the force F ~ y^4 and its rate k (z' - d') both may vanish first.
    """
    if is_force(problem.driver) or not ends_by_load(problem.solid, problem.driver):
        return False
    near, far = radius_and_integral(problem.path, 1e-6)[0], radius_and_integral(problem.path, 2e-6)[0]
    return far > 3.5 * near


@inlined
def by_rate(solid: Solid, driver: Driver, phase: int) -> bool:
    """Return whether the unknowns of a step are velocities."""
    return driver.mass > 0.0 or (solid.viscosity > 0.0 and phase != FREE)


@inlined
def falls_to_zero(driver: Driver, piece: int) -> bool:
    """Return whether a prescribed force falls to zero at the end of a piece."""
    return piece < driver.backward.shape[0] and driver.backward[piece]


@inlined
def prescribed_at(driver: Driver, piece: int, x: float, t: float) -> tuple[float, float, float]:
    """Return the value of f at share x of a piece and time t, its slope over x, and the rate of the cosine."""
    value, slope, rate, turned = 0.0, 0.0, 0.0, falls_to_zero(driver, piece)
    place = 1.0 - x if turned else x
    for n in range(driver.values.shape[1] - 1, -1, -1):
        slope = slope * place + value
        value = value * place + driver.values[piece, n]
    slope = -slope if turned else slope
    if driver.amplitude != 0.0:
        angle = driver.frequency * t + driver.phase
        value += driver.amplitude * math.cos(angle)
        rate = -driver.amplitude * driver.frequency * math.sin(angle)
    return value, slope, rate


@inlined
def rise_of_given(driver: Driver, piece: int, x: float, dx: float, t: float, dt: float) -> float:
    """Return the increase of f from share x of a piece and time t on, with no rounding by the size of f."""
    value, rise, turned = 0.0, 0.0, falls_to_zero(driver, piece)
    first, change = (1.0 - x, -dx) if turned else (x, dx)
    for n in range(driver.values.shape[1] - 1, 0, -1):
        value = value * first + driver.values[piece, n]
        rise = rise * (first + change) + value
    rise *= change
    if driver.amplitude != 0.0:
        angle, half = driver.frequency * t + driver.phase, 0.5 * driver.frequency * dt
        rise -= 2.0 * driver.amplitude * math.sin(angle + half) * math.sin(half)
    return rise


@inlined
def by_increase(solid: Solid, driver: Driver, room: Room) -> bool:
    """Return whether the force of a spring follows from its increase in a step: where few elements load a dashpot.

    The difference of base and depth has few digits there, and the rate follows from the force over the radius.
    Elsewhere errors of the steps would add up.
    """
    nodes = room.nodes
    against = driver.stiffness > 0.0 and driver.mass == 0.0 and solid.viscosity > 0.0
    return against and nodes[A, 0] > 0.0 and abs(nodes[F, 0]) < _FEW_DIGITS * driver.stiffness * abs(nodes[D, 0])


@inlined
def rounding_of_front(problem: Problem, room: Room, i: int) -> float:
    """Return the rounding of the force at a node by that of the front, which is known no better than the depth.

    The force is about a power of the radius; of a flat face only a part of it depends on the front. It is known to its
    size at worst, and so differs from one that is prescribed.
    """
    nodes = room.nodes
    if not nodes[SLOPE, i] > 0.0:
        return 0.0
    part = 1.0 - radius_and_integral(problem.path, 0.0)[0] / max(nodes[A, i], 1e-300)
    rounding = 4e-16 * problem.scales.depth / max(nodes[SLOPE, i] * nodes[Y, i], 1e-300)
    return part * min(rounding, 1.0) * abs(nodes[F, i])


@inlined
def rounding_of_force(problem: Problem, room: Room, i: int) -> float:
    """Return the rounding of the force at a node, and of what is prescribed there."""
    nodes = room.nodes
    force = abs(nodes[GIVEN, i])
    if by_increase(problem.solid, problem.driver, room):
        force = abs(nodes[F, 0]) + abs(nodes[RISE, i]) + problem.driver.stiffness * abs(nodes[BELOW, i])
    return 4e-16 * force + rounding_of_front(problem, room, i)


@inlined
def rounding_of_load(problem: Problem, room: Room, i: int) -> float:
    """Return the rounding of the shared load at a node, over its scale, where it follows from a force."""
    return rounding_of_force(problem, room, i) / max(problem.scales.stress * room.nodes[A, i], 1e-300)
