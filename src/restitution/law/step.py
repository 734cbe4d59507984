"""One time step of the contact law, for numba; `c_header` writes the same statements in C.

The statements keep to what both languages share: numbers, parts of one-dimensional arrays, loops over a range and
conditions. Comments describe the arrays `law` and `state`.
"""

import math

from numpy.typing import NDArray

from restitution.kernel.compile import compiled, entry_point

# Places of the numbers in the two arrays of the contact law: the constants of the law, and the state of a contact.
#
# `law` holds the entries below, then the moduli and the times of the branches, then the table of a profile that is no
# power law. A branch with time 0 is a dashpot, and its modulus a viscosity. The table holds the ends of its cells over
# s = sqrt(depth), the origin, start and width of each cell, and the polynomials of a and of its integral.
#
# `state` holds the entries below, then five numbers for each branch, then the rows of the nodes. A node is a place of
# the foundation. It lies where the surface was touched when the depth first reached `PLACE`.

# Constants of the law.
BRANCHES, NODES, EQUILIBRIUM, EXPONENT, COEFFICIENT, MAX_DEPTH, CELLS, CONSTANTS = range(8)

# State of a contact.
COUNT = 0  # nodes
CONTACT = 1  # nodes in contact: all up to the edge of the contact
DEPTH, RATE, STEP = 2, 3, 4  # depth, mean rate and length of the last step; length 0 before the first one
CLOCK = 5  # time
ELAPSED = 6  # length of step to which the decay, gain and bend of the branches belong
STIFFNESS = 7  # line load of all branches at the end of a step in which the displacement grows by 1
RADIUS = 8  # contact radius at the last node
# Of the cell at the edge: if its outer node was released, the growth of the contact radius over the cell; if the body
# touches the cell again, the gap at the outer node when the edge was at the inner one, with a minus sign.
EDGE = 9
NUMBERS = 10

# Five numbers for each branch: three that depend on the length of the step alone, and two of the cell at the edge.
DECAY = 0  # share of the line load that is left after the step
GAIN = 1  # line load at the end, if the displacement grows by 1 at a constant rate
BEND = 2  # further line load at the end, if the acceleration is 1 over the square of the step
BULGE = 3  # line load at the middle of the cell beyond the mean of its ends
BEYOND = 4  # line load at the outer end of the cell as if it still followed the body
BRANCH = 5

# Rows of the nodes; those of the line loads of the branches follow, and those of their inner forces: the integrals of
# the line load over x up to the node, less the line load of the node times x.
PLACE, BORN, INTEGRAL, DISPLACEMENT, TRIAL, ROWS = range(6)

# Number of coefficients of the contact radius and of its integral in each cell of a table.
RADIUS_TERMS, INTEGRAL_TERMS = 8, 12

_MEANINGS = {
    BRANCHES: "number of branches",
    NODES: "largest number of nodes",
    EQUILIBRIUM: "equilibrium modulus [Pa]",
    EXPONENT: "exponent p of the contact radius a = c s^p, s = sqrt(depth); -1 for a table",
    COEFFICIENT: "coefficient c [m^(1-p/2)]",
    MAX_DEPTH: "largest depth [m]",
    CELLS: "number of cells of the table of the profile",
}


def labels(branches: int) -> list[str]:
    """Return the meaning of each constant of a law that has no table."""
    of_branches = (
        "modulus of branch {} [Pa]; of a dashpot its viscosity [Pa s]",
        "time of branch {} [s]; of a dashpot 0",
    )
    return [*_MEANINGS.values(), *(text.format(k + 1) for text in of_branches for k in range(branches))]


def state_size(branches: int, nodes: int) -> int:
    """Return the length of the state of a contact."""
    return NUMBERS + BRANCH * branches + nodes * (ROWS + 2 * branches)


# Contact radius of the first approach over the depth, and its integral, from the constants of a law.


@compiled
def table_value(law: NDArray, depth: float, terms: int, before: int) -> float:
    """Return a value of the piecewise polynomials of `terms` coefficients; those before have `before`."""
    branches = int(law[BRANCHES])
    cells = int(law[CELLS])
    ends = law[CONSTANTS + 2 * branches :]
    place = math.sqrt(depth)
    low = 0
    high = cells
    while high - low > 1:
        middle = (low + high) // 2
        if place < ends[middle]:
            high = middle
        else:
            low = middle
    cell = ends[cells + 1 + 3 * low :]
    if cell[0] >= 0.0:
        place = math.sqrt(max(place - cell[0], 0.0))
    place = (place - cell[1]) / cell[2]
    coefficients = ends[cells + 1 + (3 + before) * cells + terms * low :]
    value = 0.0
    for n in range(terms):
        value = value * place + coefficients[terms - 1 - n]
    return value


@compiled
def radius_at(law: NDArray, depth: float) -> float:
    """Return the contact radius of the first approach at a depth >= 0."""
    exponent = law[EXPONENT]
    if exponent == 1.0:
        return law[COEFFICIENT] * math.sqrt(depth)
    if exponent == 0.0:
        return law[COEFFICIENT]
    if exponent == 2.0:
        return law[COEFFICIENT] * depth
    if exponent > 0.0:
        return law[COEFFICIENT] * math.pow(depth, 0.5 * exponent)
    return table_value(law, depth, RADIUS_TERMS, 0)


@compiled
def integral_at(law: NDArray, depth: float) -> float:
    """Return the integral of the contact radius over the depth, from 0 to a depth >= 0."""
    exponent = law[EXPONENT]
    if exponent >= 0.0:
        return 2.0 / (exponent + 2.0) * depth * radius_at(law, depth)
    return table_value(law, depth, INTEGRAL_TERMS, RADIUS_TERMS)


# Share of the largest depth below which an imprint is forgotten.
FORGOTTEN = 1e-9
# Added to what decays, because processors are slow on numbers below 1e-308.
TINY = 1e-200


@compiled
def set_branches(
    moduli: NDArray, times: NDArray, numbers: NDArray, branches: int, elapsed: float, spring: float
) -> float:
    """Write decay, gain and bend of the branches for a length of step; return a spring and all gains."""
    decay, gain, bend = numbers[DECAY * branches :], numbers[GAIN * branches :], numbers[BEND * branches :]
    stiffness = spring
    for k in range(branches):
        if times[k] == 0.0:
            decay[k] = 0.0
            gain[k] = moduli[k] / elapsed
            bend[k] = 0.5 * gain[k]
        else:
            z = elapsed / times[k]
            mean = -math.expm1(-z) / z
            decay[k] = math.exp(-z)
            gain[k] = moduli[k] * mean
            if z > 0.02:
                bend[k] = moduli[k] * ((1.0 - mean) / z - 0.5 * mean)
            else:
                # The same integral as a series, without the difference of nearly equal numbers.
                series = 1.0 / 80.0 - z * (1.0 / 360.0 - z * (1.0 / 2016.0 - z / 13440.0))
                bend[k] = moduli[k] * z * (1.0 / 12.0 - z * (1.0 / 24.0 - z * series))
        stiffness += gain[k]
    return stiffness


@compiled
def set_elapsed(law: NDArray, state: NDArray, elapsed: float) -> None:
    """Store the numbers of the branches for a length of step."""
    branches = int(law[BRANCHES])
    moduli, times = law[CONSTANTS:], law[CONSTANTS + branches :]
    spring = law[EQUILIBRIUM]
    state[STIFFNESS] = set_branches(moduli, times, state[NUMBERS:], branches, elapsed, spring)
    state[ELAPSED] = elapsed


@compiled
def thin_out(law: NDArray, state: NDArray, count: int) -> int:
    """Drop nodes that are near others in depth and time, and return how many are left: at most half and two.

    In a contact that grows the force does not change, because the inner forces are those of the whole contact.
    """
    branches, room = int(law[BRANCHES]), int(law[NODES])
    nodes = state[NUMBERS + BRANCH * branches :]
    place, born = nodes[PLACE * room :], nodes[BORN * room :]
    last = count - 1
    per_depth = 0.25 * room / place[last]
    per_time = 0.25 * room / (born[last] - born[0])
    kept = 0.0
    left = 0
    for n in range(count):
        here = per_depth * place[n] + per_time * (born[n] - born[0])
        if n == 0 or n == last or here >= kept + 1.0:
            kept = here
            for row in range(ROWS + 2 * branches):
                nodes[row * room + left] = nodes[row * room + n]
            left += 1
    return left


@compiled
def touch_again(
    law: NDArray, state: NDArray, count: int, contact: int, depth: float, stiffness: float, lag: float
) -> int:
    """Advance the free nodes; return the number of nodes in contact, which grows if the body touches some again."""
    branches, room = int(law[BRANCHES]), int(law[NODES])
    decay, gain = state[NUMBERS + DECAY * branches :], state[NUMBERS + GAIN * branches :]
    bulge, beyond = state[NUMBERS + BULGE * branches :], state[NUMBERS + BEYOND * branches :]
    nodes = state[NUMBERS + BRANCH * branches :]
    place, integral, displacement = nodes[PLACE * room :], nodes[INTEGRAL * room :], nodes[DISPLACEMENT * room :]
    trial, loads = nodes[TRIAL * room :], nodes[ROWS * room :]
    touched = contact
    for n in range(contact, count):
        total = law[EQUILIBRIUM] * displacement[n] + stiffness * (depth - place[n] - displacement[n])
        for k in range(branches):
            if decay[k] == 0.0:
                total -= lag * loads[k * room + n]
            else:
                total += decay[k] * loads[k * room + n]
        trial[n] = total
        if total > 0.0:
            touched = n + 1
    if depth > place[count - 1]:
        touched = count
    opened = max(state[EDGE], 0.0)
    if touched > contact:
        state[EDGE] = 0.0
        if touched < count:
            state[EDGE] = (trial[touched] - trial[touched - 1]) / stiffness
    for n in range(contact, count):
        change = depth - place[n] - displacement[n]
        if n >= touched:
            change -= trial[n] / stiffness
        displacement[n] += change
        for k in range(branches):
            before = loads[k * room + n]
            loads[k * room + n] = decay[k] * before + gain[k] * change + TINY
            if decay[k] == 0.0 and n < touched:
                # A dashpot that is touched within the step has the velocity of the body at its end.
                trial[n] += beyond[k] - (1.0 + lag) * gain[k] * change + lag * before
                loads[k * room + n] = beyond[k]
    if touched > contact:
        for k in range(branches):
            load, inner = loads[k * room :], loads[(branches + k) * room :]
            for n in range(contact, touched):
                if n == 0:
                    inner[0] = 0.0
                else:
                    radius = (integral[n] - integral[n - 1]) / (place[n] - place[n - 1])
                    inner[n] = inner[n - 1] + radius * (load[n - 1] - load[n])
                    if n == contact:
                        inner[n] += opened * bulge[k] / 1.5
    return touched


@compiled
def release(law: NDArray, state: NDArray, contact: int, depth: float, risen: float, stiffness: float) -> int:
    """Let go of the nodes at the edge that would pull; return the number of nodes in contact."""
    branches, room = int(law[BRANCHES]), int(law[NODES])
    decay, gain = state[NUMBERS + DECAY * branches :], state[NUMBERS + GAIN * branches :]
    bulge, beyond = state[NUMBERS + BULGE * branches :], state[NUMBERS + BEYOND * branches :]
    nodes = state[NUMBERS + BRANCH * branches :]
    place, integral, displacement = nodes[PLACE * room :], nodes[INTEGRAL * room :], nodes[DISPLACEMENT * room :]
    trial, loads = nodes[TRIAL * room :], nodes[ROWS * room :]
    left = contact
    while left > 0:
        n = left - 1
        total = law[EQUILIBRIUM] * (depth - place[n])
        for k in range(branches):
            total += loads[k * room + n]
        trial[n] = total
        if total > 0.0:
            return left
        radius = 0.0
        growth = 0.0
        if n > 0:
            radius = (integral[n] - integral[n - 1]) / (place[n] - place[n - 1])
            growth = radius_at(law, place[n]) - radius_at(law, place[n - 1])
        change = total / stiffness
        displacement[n] = depth - place[n] - change
        for k in range(branches):
            load, inner = loads[k * room :], loads[(branches + k) * room :]
            beyond[k] = load[n]
            bulge[k] = 0.0
            if growth > 0.0:
                bulge[k] = 1.5 * (inner[n] - inner[n - 1] - radius * (load[n - 1] - load[n])) / growth
            load[n] -= gain[k] * change
            if decay[k] == 0.0:
                load[n] = gain[k] * (risen - change)
        state[EDGE] = growth
        left = n
    return left


@compiled
def grow(law: NDArray, state: NDArray, count: int, depth: float, growth: float) -> float:
    """Put a node at the edge of a contact that grows; return half of the force."""
    branches, room = int(law[BRANCHES]), int(law[NODES])
    bend, nodes = state[NUMBERS + BEND * branches :], state[NUMBERS + BRANCH * branches :]
    place, integral, loads = nodes[PLACE * room :], nodes[INTEGRAL * room :], nodes[ROWS * room :]
    last = count - 1
    edge = radius_at(law, depth)
    total = integral_at(law, depth)
    radius = (total - integral[last]) / (depth - place[last])
    for row in range(ROWS + 2 * branches):
        nodes[row * room + count] = 0.0
    place[count] = depth
    integral[count] = total
    nodes[BORN * room + count] = state[CLOCK]
    force = law[EQUILIBRIUM] * total
    for k in range(branches):
        inner = loads[(branches + k) * room :]
        inner[count] = inner[last] + radius * loads[k * room + last] + (edge - state[RADIUS]) * growth * bend[k]
        force += inner[count]
    state[RADIUS] = edge
    return force


@compiled
def force_within(
    law: NDArray, state: NDArray, count: int, contact: int, depth: float, growth: float, stiffness: float
) -> float:
    """Return half of the force of a contact within its largest extent.

    The edge lies in the cell behind the last node in contact. There q is a parabola, with which the cell has the force
    that it had before its outer node was released.
    """
    branches, room = int(law[BRANCHES]), int(law[NODES])
    bend, bulge = state[NUMBERS + BEND * branches :], state[NUMBERS + BULGE * branches :]
    beyond, nodes = state[NUMBERS + BEYOND * branches :], state[NUMBERS + BRANCH * branches :]
    place, integral, trial = nodes[PLACE * room :], nodes[INTEGRAL * room :], nodes[TRIAL * room :]
    loads = nodes[ROWS * room :]
    n = contact - 1
    force = law[EQUILIBRIUM] * integral[n]
    for k in range(branches):
        force += loads[(branches + k) * room + n]
    if contact == count:
        return force + trial[n] * state[RADIUS]
    width = place[n + 1] - place[n]
    if state[EDGE] <= 0.0:
        # The body touches the cell again, which it has covered as far as the gap at the outer node has closed.
        share = 1.0
        if state[EDGE] < 0.0:
            share = min(max(1.0 - trial[n + 1] / stiffness / state[EDGE], 1e-9), 1.0)
        gained = 0.0
        for k in range(branches):
            gained += bend[k]
        edge = place[n] + share * width
        force += trial[n] / (share * width) * (integral_at(law, edge) - integral[n])
        return force + (radius_at(law, edge) - radius_at(law, place[n])) * gained * max(growth, 0.0)
    curve = 0.0
    outer = law[EQUILIBRIUM] * (depth - place[n + 1])
    for k in range(branches):
        outer += beyond[k]
        curve += 4.0 * bulge[k]
    outer = min(outer, 0.0)
    # Over the share s of the cell q = trial[n] + slope s - curve s^2, up to its root.
    slope = outer - trial[n] + curve
    share = 2.0 * trial[n] / (math.sqrt(max(slope * slope + 4.0 * curve * trial[n], 0.0)) - slope)
    share = min(share, 1.0)
    total = integral_at(law, place[n] + share * width) - integral[n]
    return force + (curve * share - slope) / width * total + curve / 6.0 * state[EDGE] * share * share * share


@compiled
def is_forgotten(law: NDArray, state: NDArray, count: int) -> bool:
    """Return whether the nodes, all of them free, have returned to where they were before the contact."""
    branches, room = int(law[BRANCHES]), int(law[NODES])
    nodes = state[NUMBERS + BRANCH * branches :]
    limit = FORGOTTEN * nodes[PLACE * room + count - 1]
    for n in range(count):
        if abs(nodes[DISPLACEMENT * room + n]) > limit:
            return False
        for k in range(branches):
            if abs(nodes[(ROWS + k) * room + n]) > limit * state[STIFFNESS]:
                return False
    return True


@entry_point
def step(law: NDArray, state: NDArray, depth: float, dt: float) -> float:
    """Advance a contact by a time step to a depth; return its force, NaN beyond the largest depth of the law."""
    if not depth <= law[MAX_DEPTH]:
        return math.nan
    branches, room = int(law[BRANCHES]), int(law[NODES])
    nodes = state[NUMBERS + BRANCH * branches :]
    count = int(state[COUNT])
    before = int(state[CONTACT])
    elapsed = dt
    growth = depth - state[DEPTH]
    rate = growth / dt
    acceleration = 0.0
    lag = 0.0
    if state[STEP] > 0.0:
        lag = dt / (dt + state[STEP])
        acceleration = 2.0 * (rate - state[RATE]) / (dt + state[STEP])
    if count == 0 and depth > 0.0:
        if state[DEPTH] < 0.0:
            # First touch is within this step.
            elapsed = dt * depth / growth
            growth = depth
        for row in range(ROWS + 2 * branches):
            nodes[row * room] = 0.0
        nodes[BORN * room] = state[CLOCK]
        state[RADIUS] = radius_at(law, 0.0)
        state[EDGE] = 0.0
        count = 1
        before = 1
    state[DEPTH] = depth
    state[RATE] = rate
    state[STEP] = dt
    state[CLOCK] += dt
    if count == 0:
        return 0.0
    if elapsed != state[ELAPSED]:
        set_elapsed(law, state, elapsed)
    decay, gain = state[NUMBERS + DECAY * branches :], state[NUMBERS + GAIN * branches :]
    bend, bulge = state[NUMBERS + BEND * branches :], state[NUMBERS + BULGE * branches :]
    beyond = state[NUMBERS + BEYOND * branches :]
    # A free dashpot has the velocity that follows from the mean ones of this step and of the last one.
    stiffness = state[STIFFNESS]
    for k in range(branches):
        if decay[k] == 0.0:
            stiffness += lag * gain[k]
        left = decay[k]
        gained = gain[k] * growth + bend[k] * acceleration * elapsed * elapsed + TINY
        load, inner = nodes[(ROWS + k) * room :], nodes[(ROWS + branches + k) * room :]
        bulge[k] = left * bulge[k] + TINY
        beyond[k] = left * beyond[k] + gained
        for n in range(before):
            load[n] = left * load[n] + gained
        for n in range(before):
            inner[n] = left * inner[n] + TINY
    contact = before
    if before < count:
        contact = touch_again(law, state, count, before, depth, stiffness, lag)
    force = 0.0
    if depth > nodes[PLACE * room + count - 1]:
        if count == room:
            count = thin_out(law, state, count)
        force = grow(law, state, count, depth, growth)
        count += 1
        contact = count
    else:
        if contact == before:
            contact = release(law, state, contact, depth, growth, stiffness)
        if contact > 0:
            force = force_within(law, state, count, contact, depth, growth, stiffness)
        elif depth < 0.0 and is_forgotten(law, state, count):
            count = 0
    state[COUNT] = count
    state[CONTACT] = contact
    return max(2.0 * force, 0.0)


@entry_point
def step_all(law: NDArray, states: NDArray, depths: NDArray, dt: float, forces: NDArray) -> None:
    """Advance many contacts by a time step to their depths, and write their forces."""
    for n in range(depths.size):
        forces[n] = step(law, states[n], depths[n], dt)
