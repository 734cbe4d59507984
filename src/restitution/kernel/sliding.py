"""Elements of a contact that sticks and slips: their state, and the core of those that have stuck for a while.

The core reaches from the axis on. Its elements all move as the body does, so that sums over them are enough: how far
they are from each other only decays.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from restitution.kernel.compile import compiled, inlined
from restitution.kernel.lanes import WIDTH
from restitution.kernel.references import by_reference

# Rows of `nodes`: displacement, its rate in the last step, load, load without a displacement in this step, limit of
# the load, weight of the quadrature over x, the same while the element is in contact and else 0, slip that ends in
# this step, 1 where the element slips and less the longer it sticks, time at which it joined the core, depth of its
# touch.
(
    U_, RATE_, LOAD_, TRIAL_, LIMIT_, WEIGHT_, ACTIVE_, ENDED_SLIP_, SLIDES_, JOINED_, TOUCHED_, N_NODES,
) = range(12)  # fmt: skip
# Columns of `factors` of a mode: decay over the step, 1 - decay, load of a constant rate and of a change of the rate.
DECAY_, LOSS_, STEADY_, CHANGE_, N_FACTORS = range(5)
# Members of `sums`: energies lost by friction, dissipated in the material, and stored in elements when they leave;
# impulse; time in which elements slip within the radius that sticks; whether any element ever stuck.
FRICTION_, VISCOUS_, STORED_, IMPULSE_, GAPS_, STUCK_, N_SUMS = range(7)
# Columns of `motion`: time, velocity of the contact point, force, radius that sticks, largest velocity of slip.
T_, V_, F_, STICK_, SLIP_, N_MOTION = range(6)
# Members of `touch`: load of an element after its first step, mean load of the ages up to it, displacement, energy
# lost by friction and work that moves the surface.
FIRST_, MEAN_, WAY_, RUBBED_, WORK_, N_TOUCH = range(6)

# Rows of `part`: normal load and 1 - decay over a part of the first step; decay and gain of all elements over a step.
PRESSED_, PART_LOSS_, PRESS_DECAY_, PRESS_GAIN_, N_PART = range(5)
# Members of `core`: sum of the weights, of weights times displacements, displacement of a point that always follows
# the body. Columns of `lump`: sum over the core of weights times loads, load of that point.
WEIGHTS_, WAYS_, ALONG_, N_CORE = range(4)
LOADS_, ALONE_, N_LUMP = range(3)

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
class Normal(NamedTuple):
    """Normal solution at the 2N + 1 times of the steps, and the places of the N + 1 elements."""

    times: Any
    velocities: Any
    depths: Any
    memory: Any  # (K, 2N + 1): H_k
    radii: Any  # (N + 1,)
    touched: Any  # (N + 1,): depths at which the elements are touched


@by_reference
class Room(NamedTuple):
    """State and results of one march with N steps in each half."""

    nodes: Any  # (N_NODES, N + 1)
    tangential: Any  # (modes, N + 1): p_k
    normal: Any  # (modes, N + 1): the same of the normal load
    part: Any  # (N_PART, modes of the normal load)
    young: Any  # (modes,): p_k of an element in its first step
    factors: Any  # (modes, N_FACTORS)
    part_factors: Any  # (modes, N_FACTORS): those of a part of a step
    touch: Any  # (N_TOUCH,)
    core: Any  # (N_CORE,)
    lump: Any  # (modes, N_LUMP)
    motion: Any  # (2N + 1, N_MOTION)
    sums: Any  # (N_SUMS,)


def allocate_room(steps: int, tangential: int, normal: int) -> Room:
    """Return room for a march."""
    # Rows start at different places of a page: loads and stores at equal places would wait for each other.
    columns = _ROW * math.ceil(max(steps + 1 + WIDTH - _SHIFT, 0) / _ROW) + _SHIFT
    factors = np.zeros((2, tangential, N_FACTORS))
    return Room(
        np.zeros((N_NODES, columns)), np.zeros((tangential, columns)), np.zeros((normal, columns)),
        np.zeros((N_PART, normal)), np.zeros(tangential), factors[0], factors[1], np.zeros(N_TOUCH), np.zeros(N_CORE),
        np.zeros((tangential, N_LUMP)), np.zeros((2 * steps + 1, N_MOTION)), np.zeros(N_SUMS),
    )  # fmt: skip


@compiled
def set_factors(modes: Modes, dt: float, before: float, factors: Any) -> tuple[float, float]:
    """Write the factors of the modes over a step; return the slope of the load over the way, and over the last rate.

    A rate that is linear over this step and the one before, of length `before`, adds `J slope` to the memory of a
    mode, with `J = int_0^dt exp(-(dt - t)/tau) (t - dt/2) dt`. With `before` = 0 the rate is constant.
    """
    share = 2.0 / ((dt + before) * dt) if before > 0.0 else 0.0
    slope, lag = (
        modes.equilibrium + modes.viscosity * (1.0 / dt + 0.5 * dt * share),
        0.5 * modes.viscosity * dt * share,
    )
    for k in range(modes.times.shape[0]):
        tau = modes.times[k]
        loss = -math.expm1(-dt / tau)
        # The difference of nearly equal terms, for slow modes.
        change = tau * (dt - 0.5 * dt * loss - tau * loss) if dt > 1e-3 * tau else dt * dt * dt / (12.0 * tau)
        factors[k, DECAY_], factors[k, LOSS_] = 1.0 - loss, loss
        factors[k, STEADY_], factors[k, CHANGE_] = modes.moduli[k] * tau * loss / dt, modes.moduli[k] * change * share
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
        for i in range(first, first + WIDTH):
            if nodes[SLIDES_, i] > 0.0 or nodes[RATE_, i] != pace:
                return first
        for i in range(first, first + WIDTH):
            weight = nodes[WEIGHT_, i]
            core[WEIGHTS_] += weight
            core[WAYS_] += weight * nodes[U_, i]
            nodes[U_, i] -= core[ALONG_]
            nodes[JOINED_, i] = time
            for k in range(lump.shape[0]):
                load = room.tangential[k, i]
                lump[k, LOADS_] += weight * load
                room.tangential[k, i] = load - lump[k, ALONE_]
        first += WIDTH
    return first


@compiled
def release(
    solids: tuple[Modes, Modes], normal: Normal, n: int, span: tuple[int, int], paces: tuple[float, float], room: Room
) -> int:
    """Let the outermost elements go from the core, with their state at the start of a step; return the first of them.

    `paces` are the mean velocity of the body in the last step, and that at its end.
    """
    (tangential, pressing), (first, end), time = solids, span, normal.times[n]
    nodes, core, lump = room.nodes, room.core, room.lump
    for i in range(first, end):
        weight, age = nodes[WEIGHT_, i], time - nodes[JOINED_, i]
        nodes[U_, i] += core[ALONG_]
        nodes[SLIDES_, i], nodes[ENDED_SLIP_, i], nodes[RATE_, i] = 0.0, 0.0, paces[0]
        total = tangential.equilibrium * nodes[U_, i] + tangential.viscosity * paces[1]
        for k in range(lump.shape[0]):
            load = lump[k, ALONE_] + math.exp(-age / tangential.times[k]) * room.tangential[k, i]
            room.tangential[k, i] = load
            lump[k, LOADS_] -= weight * load
            total += load
        nodes[LOAD_, i] = total
        core[WEIGHTS_] -= weight
        core[WAYS_] -= weight * nodes[U_, i]
        for k in range(pressing.times.shape[0]):
            decay = math.exp((normal.times[i] - time) / pressing.times[k])
            room.normal[k, i] = pressing.moduli[k] * (normal.memory[k, n] - decay * normal.memory[k, i])
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
