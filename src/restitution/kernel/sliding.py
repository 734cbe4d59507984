"""Elements of a contact that sticks and slips: their state, and the core of those that have stuck for a while.

The core reaches from the axis on. Its elements all move as the body does, so that sums over them are enough: how far
they are from each other only decays.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from restitution.kernel.collocation import invert, lagrange, matvec, product
from restitution.kernel.compile import compiled, inlined
from restitution.kernel.element import write_matrix
from restitution.kernel.lanes import WIDTH, absolute, at_least, broadcast, exp, largest, read8, total, write8
from restitution.kernel.references import by_reference
from restitution.kernel.workspace import S_

# Rows of `nodes`: displacement, its rate in the last step, load, load without a displacement in this step, limit of
# the load, weight of the quadrature over x, the same while the element is in contact and else 0, slip that ends in
# this step, 1 where the element slips and less the longer it sticks, time at which it joined the core, radius, depth
# of its touch, rate of slip in the step before the last one.
(
    U_, RATE_, LOAD_, TRIAL_, LIMIT_, WEIGHT_, ACTIVE_, ENDED_SLIP_, SLIDES_, JOINED_, RADIUS_, TOUCHED_, SLIPPED_,
    N_NODES,
) = range(14)  # fmt: skip
# Columns of `factors` of a mode: decay over the step, load of a constant rate and of a change of the rate.
DECAY_, STEADY_, CHANGE_, N_FACTORS = range(4)
# Columns of `losses` of a mode: 1 - decay over the longest part of a step, over the step, and over another part.
OF_PART_, OF_STEP_, OF_OTHER_, N_LOSSES = range(4)
# Steps of sticking from which elements join the core: a power of two, so that their count is exact.
AGE = 8
# Longest part of the first step of an element over the step.
LONGEST_PART = 0.125
# Members of `sums`: energies lost by friction, dissipated in the material, and stored in elements when they leave;
# time in which elements slip within the radius that sticks.
FRICTION_, VISCOUS_, STORED_, GAPS_, N_SUMS = range(5)
# Columns of `motion`: time, velocity of the contact point, force, radius that sticks, largest velocity of slip.
T_, V_, F_, STICK_, SLIP_, N_MOTION = range(6)
# Members of `touch`: load of an element after its first step, mean load of the ages up to it, displacement, energy
# lost by friction and work that moves the surface.
FIRST_, MEAN_, WAY_, RUBBED_, WORK_, N_TOUCH = range(6)

# Rows of `part`: normal load in the first step; decay and gain of all elements over a step.
PRESSED_, PRESS_DECAY_, PRESS_GAIN_, N_PART = range(4)
# Rows of `leaving`, of elements in their last step: displacement, its rate in the step before, load and its limit,
# velocity of the body at both ends, lengths of the step before and of this one, weight.
LAST_WAY_, LAST_RATE_, LAST_LOAD_, LAST_LIMIT_, START_, END_, BEFORE_, LENGTH_, SHARE_, N_LEAVING = range(10)
# Further rows of `fading`, after the factors over a part of their step: CHANGE_ in the first part, load of the mode.
FIRST_CHANGE_, FADING_, N_FADING = N_FACTORS, N_FACTORS + 1, N_FACTORS + 2
# Members of `core`: sum of the weights, of weights times displacements, displacement of a point that always follows
# the body. Columns of `lump`: sum over the core of weights times loads, load of that point.
WEIGHTS_, WAYS_, ALONG_, N_CORE = range(4)
LOADS_, ALONE_, N_LUMP = range(3)
# Members of `crease`: the last element that sticks, and 1 if the kink beyond it is known; the element before the cell
# in which the front turned, -1 where it did not; what the trapezoidal rule misses of the displacement in both cells,
# and adds to the impulse of elements that come to rest.
FRONT_, KNOWN_, TURNED_, FRONT_WAY_, TURNED_WAY_, IMPULSE_, N_CREASE = range(7)
# Columns of `missed`: the same of the load of a mode in both cells.
FRONT_LOAD_, TURNED_LOAD_, N_MISSED = range(3)

# Rows of the normal solution: s, v, t, force, depth and memory of the modes.
NORMAL_V_, NORMAL_T_, NORMAL_F_, NORMAL_D_, NORMAL_H_ = 1, 2, 3, 4, 5

# Least argument of the exponential of eight numbers.
_SMALLEST = -700.0
# Numbers in a page of memory, and those by which rows are shifted against each other.
_ROW, _SHIFT = 512, 40


@by_reference
class Modes(NamedTuple):
    """Scaled relaxation of the line load in one direction."""

    equilibrium: float
    viscosity: float
    moduli: Any
    times: Any


@by_reference
class Halves(NamedTuple):
    """Normal solution as polynomials over elements, those of the approach first, then those of the rebound."""

    c: Any  # of the scheme of collocation, as the next three
    weights: Any
    columns: Any
    identity: Any
    starts: Any  # (E,): in sigma or lambda
    lengths: Any  # (E,)
    rows: Any  # (E, n, S + 1): s, v, t and others
    paces: Any  # (E, S): dt/dsigma or dt/dlambda at the nodes
    turn: int  # first element of the rebound
    length: float  # of each half in sigma or lambda
    path: Any


@by_reference
class Room(NamedTuple):
    """State and results of marches with at most N steps in each half."""

    samples: Any  # (NORMAL_H_ + modes of the normal load, 2N + 1)
    basis: Any  # (2 WIDTH,): of an interpolation
    matrices: Any  # (1, S, S)
    memory: Any  # (E, 1 + modes of the normal load, S + 1): depth and H_k along the halves

    nodes: Any  # (N_NODES, N + 1)
    tangential: Any  # (modes, N + 1): p_k
    normal: Any  # (modes, N + 1): the same of the normal load
    part: Any  # (N_PART, modes of the normal load)
    young: Any  # (modes,): p_k of an element in its first step
    losses: Any  # (modes, N_LOSSES)
    pressing_losses: Any  # (modes of the normal load, N_LOSSES)
    factors: Any  # (modes, N_FACTORS)
    part_factors: Any  # (modes, N_FACTORS): those of a part of a step
    touch: Any  # (N_TOUCH,)
    leaving: Any  # (N_LEAVING, WIDTH)
    fading: Any  # (modes, N_FADING, WIDTH)
    core: Any  # (N_CORE,)
    lump: Any  # (modes, N_LUMP)
    crease: Any  # (N_CREASE,)
    missed: Any  # (modes, N_MISSED)
    motion: Any  # (2N + 1, N_MOTION)
    sums: Any  # (N_SUMS,)


def allocate_room(steps: int, tangential: int, normal: int, elements: int) -> Room:
    """Return room for marches on a normal solution of a number of elements."""
    # Rows start at different places of a page: loads and stores at equal places would wait for each other.
    columns = _ROW * math.ceil(max(steps + 1 + WIDTH - _SHIFT, 0) / _ROW) + _SHIFT
    factors = np.zeros((2, tangential, N_FACTORS))
    return Room(
        np.empty((NORMAL_H_ + normal, 2 * steps + 1)), np.zeros(2 * WIDTH), np.zeros((1, WIDTH, WIDTH)),
        np.empty((elements, 1 + normal, WIDTH + 1)),
        np.zeros((N_NODES, columns)), np.zeros((tangential, columns)), np.zeros((normal, columns)),
        np.zeros((N_PART, normal)), np.zeros(tangential), np.zeros((tangential, N_LOSSES)),
        np.zeros((normal, N_LOSSES)), factors[0], factors[1], np.zeros(N_TOUCH),
        np.zeros((N_LEAVING, WIDTH)), np.zeros((tangential, N_FADING, WIDTH)), np.zeros(N_CORE),
        np.zeros((tangential, N_LUMP)), np.zeros(N_CREASE), np.zeros((tangential, N_MISSED)),
        np.zeros((2 * steps + 1, N_MOTION)), np.zeros(N_SUMS),
    )  # fmt: skip


@compiled
def remember(halves: Halves, times: Any, room: Room) -> None:
    """Write the memory along both halves: the depth, then H_k of the modes, with `dH_k = -(H_k/tau_k) dt + dd`."""
    memory, starts, lengths = room.memory, halves.starts, halves.lengths
    for element in range(starts.shape[0]):
        h, pace, turns = lengths[element], read8(halves.paces, element, 0), element == halves.turn
        change = h * matvec(halves.columns, pace * read8(halves.rows, element, NORMAL_V_, 1))
        if turns:
            x = (halves.length - starts[element - 1]) / lengths[element - 1]
            lagrange(halves.c, halves.weights, WIDTH + 1, min(x, 1.0), room.basis)
        for k in range(memory.shape[1]):
            first = memory[element - 1, k, WIDTH] if element > 0 else 0.0
            if turns:
                first = product(room.basis, memory[element - 1, k]) if k > 0 else halves.rows[element, S_, 0] ** 2
            memory[element, k, 0] = first
            rate = 1.0 / times[k - 1] if k > 0 else 0.0
            write_matrix(halves, room.matrices, 0, (h * rate) * pace)
            invert(room.matrices, 0)
            write8(memory, element, k, 1, matvec(room.matrices[0], first + change))


@compiled
def sample(halves: Halves, steps: int, room: Room) -> None:
    """Write the normal solution at the ends of equal steps of both halves."""
    samples, ends, starts, element = room.samples, 2 * steps + 1, halves.starts, 0
    for m in range(ends):
        last, place = halves.turn - 1, m * (halves.length / steps)
        # The turning point stands once, at the end of the approach.
        if m > steps:
            element, last = max(element, halves.turn), starts.shape[0] - 1
            place = (m - steps) * (halves.length / steps)
        while element < last and starts[element + 1] <= place:
            element += 1
        x = (place - starts[element]) / halves.lengths[element]
        lagrange(halves.c, halves.weights, WIDTH + 1, x, room.basis)
        for n in range(NORMAL_D_):
            samples[n, m] = product(room.basis, halves.rows[element, n])
        for k in range(room.memory.shape[1]):
            samples[NORMAL_D_ + k, m] = product(room.basis, room.memory[element, k])
    # First touch is exact, and times do not fall.
    for n in range(samples.shape[0]):
        samples[n, 0] = 1.0 if n == NORMAL_V_ else 0.0
    for m in range(1, ends):
        samples[NORMAL_T_, m] = max(samples[NORMAL_T_, m], samples[NORMAL_T_, m - 1])


@compiled
def set_losses(modes: Modes, dt: float, losses: Any) -> None:
    """Write 1 - decay of the modes over a part of a step and over the step."""
    for k in range(modes.times.shape[0]):
        loss = -math.expm1(-LONGEST_PART * dt / modes.times[k])
        losses[k, OF_PART_] = loss
        # Eight parts by three doublings, which keep the digits of slow modes.
        loss *= 2.0 - loss
        loss *= 2.0 - loss
        losses[k, OF_STEP_] = loss * (2.0 - loss)


@compiled
def set_factors(modes: Modes, dt: float, before: float, losses: Any, kind: int, factors: Any) -> tuple[float, float]:
    """Write the factors of the modes over a step; return the slope of the load over the way, and over the last rate.

    A rate that is linear over this step and the one before, of length `before`, adds `J slope` to the memory of a
    mode, with `J = int_0^dt exp(-(dt - t)/tau) (t - dt/2) dt`. With `before` = 0 the rate is constant. The column
    `kind` of the losses belongs to the step.
    """
    share = 2.0 / ((dt + before) * dt) if before > 0.0 else 0.0
    slope, lag = (
        modes.equilibrium + modes.viscosity * (1.0 / dt + 0.5 * dt * share),
        0.5 * modes.viscosity * dt * share,
    )
    rate = 1.0 / dt
    for k in range(modes.times.shape[0]):
        tau, loss = modes.times[k], losses[k, kind]
        # The difference of nearly equal terms, for slow modes.
        change = tau * (dt - 0.5 * dt * loss - tau * loss) if dt > 1e-3 * tau else dt * dt * dt / (12.0 * tau)
        factors[k, DECAY_] = 1.0 - loss
        factors[k, STEADY_], factors[k, CHANGE_] = (
            modes.moduli[k] * tau * loss * rate,
            modes.moduli[k] * change * share,
        )
        slope += factors[k, STEADY_] + factors[k, CHANGE_]
        lag += factors[k, CHANGE_]
    return slope, lag * dt


@inlined
def advance_core(tangential: Modes, way: float, pace: float, dt: float, room: Room) -> None:
    """Advance the sums over the core, whose elements all follow the body."""
    core, lump = room.core, room.lump
    core[WAYS_] += core[WEIGHTS_] * way
    core[ALONG_] += way
    for k in range(tangential.times.shape[0]):
        decay = room.factors[k, DECAY_]
        gain = room.factors[k, STEADY_] * way + room.factors[k, CHANGE_] * (way - pace * dt)
        lump[k, LOADS_] = decay * lump[k, LOADS_] + core[WEIGHTS_] * gain
        lump[k, ALONE_] = decay * lump[k, ALONE_] + gain


@compiled
def join(first: int, end: int, time: float, pace: float, room: Room) -> int:
    """Take whole lanes into the core that have followed the body for a while; return the first element outside.

    The core stays below `end`. Its elements keep how far they are from a point that always follows the body; this only
    decays.
    """
    nodes, core, lump = room.nodes, room.core, room.lump
    while first + WIDTH <= end:
        moves = read8(nodes, RATE_, first) - pace
        if largest(absolute(moves)) != 0.0 or largest(read8(nodes, SLIDES_, first)) > 0.0:
            return first
        weight, way = read8(nodes, WEIGHT_, first), read8(nodes, U_, first)
        core[WEIGHTS_] += total(weight)
        core[WAYS_] += total(weight * way)
        write8(nodes, U_, first, way - core[ALONG_])
        write8(nodes, JOINED_, first, broadcast(time))
        for k in range(lump.shape[0]):
            load = read8(room.tangential, k, first)
            lump[k, LOADS_] += total(weight * load)
            write8(room.tangential, k, first, load - lump[k, ALONE_])
        first += WIDTH
    return first


@compiled
def release(solids: tuple[Modes, Modes], n: int, span: tuple[int, int], paces: tuple[float, float], room: Room) -> int:
    """Let the outermost lanes go from the core, with their state at the start of a step; return their first element.

    `paces` are the mean velocity of the body in the last step, and that at its end.
    """
    (tangential, pressing), (first, end), time = solids, span, room.samples[NORMAL_T_, n]
    nodes, core, lump, nothing = room.nodes, room.core, room.lump, broadcast(0.0)
    for i in range(first, end, WIDTH):
        weight, age = read8(nodes, WEIGHT_, i), time - read8(nodes, JOINED_, i)
        way = read8(nodes, U_, i) + core[ALONG_]
        write8(nodes, U_, i, way)
        write8(nodes, SLIDES_, i, nothing)
        write8(nodes, ENDED_SLIP_, i, nothing)
        write8(nodes, RATE_, i, broadcast(paces[0]))
        whole = tangential.equilibrium * way + tangential.viscosity * paces[1]
        for k in range(lump.shape[0]):
            rest = exp(at_least((-1.0 / tangential.times[k]) * age, _SMALLEST)) * read8(room.tangential, k, i)
            load = rest + lump[k, ALONE_]
            write8(room.tangential, k, i, load)
            lump[k, LOADS_] -= total(weight * load)
            whole = whole + load
        write8(nodes, LOAD_, i, whole)
        core[WEIGHTS_] -= total(weight)
        core[WAYS_] -= total(weight * way)
        since = read8(room.samples, NORMAL_T_, i) - time
        for k in range(pressing.times.shape[0]):
            decay = exp(at_least((1.0 / pressing.times[k]) * since, _SMALLEST))
            pressed = room.samples[NORMAL_H_ + k, n] - decay * read8(room.samples, NORMAL_H_ + k, i)
            write8(room.normal, k, i, pressing.moduli[k] * pressed)
    return first


@inlined
def core_force(tangential: Modes, lag: float, slope: float, room: Room) -> tuple[float, float]:
    """Return the force of the core without a displacement in this step, and its slope over the way of the body."""
    width = room.core[WEIGHTS_]
    force = tangential.equilibrium * room.core[WAYS_] - lag * width
    for k in range(tangential.times.shape[0]):
        force += room.factors[k, DECAY_] * room.lump[k, LOADS_]
    return force, slope * width


@inlined
def core_load(tangential: Modes, velocity: float, room: Room) -> float:
    """Return the force of the core at a velocity of the body."""
    force = tangential.equilibrium * room.core[WAYS_] + tangential.viscosity * velocity * room.core[WEIGHTS_]
    for k in range(tangential.times.shape[0]):
        force += room.lump[k, LOADS_]
    return force


@inlined
def whole_lanes(count: int) -> int:
    """Return the elements in whole lanes of a number of them."""
    return max(count, 0) // WIDTH * WIDTH


@inlined
def is_stuck(nodes: Any, i: int, slope: float, way: float) -> bool:
    """Return whether an element sticks for a way of the body."""
    return abs(nodes[TRIAL_, i] + slope * way) <= nodes[LIMIT_, i]
