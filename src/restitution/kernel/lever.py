"""Oscillators that carry the body: its velocities without a force on it, and how far a force changes them.

The body hangs on one mass, or on several oscillators whose depths add up, as a tip on the modes of a cantilever:

    d = sum d_n,    m_n d_n'' + c_n d_n' + k_n d_n = f_n - F + pull,    f_0 = f(t), and f_n = 0 for the others

Collocation makes the velocities at the nodes of a step linear in the forces there. With integrals W = A diag(weights)

    v_n = u_n - R_n (F - pull),    R_n = B_n^-1 W,    u_n = B_n^-1 [m_n v_n(0) - W (k_n d_n(0) - f_n)],
    B_n = m_n + c_n W + k_n W^2

so that a step has the velocities v = sum v_n of the body as its only unknowns, whatever the number of oscillators.
"""

from restitution.kernel.compile import compiled, inlined
from restitution.kernel.driver import GIVEN, PULL, D, Driver, F, Room, V
from restitution.kernel.elimination import solve_linear
from restitution.kernel.panels import NODES, STAGES


@compiled
def solve_oscillator(
    room: Room, mass: float, damping: float, stiffness: float, depth: float, rate: float, driven: bool
) -> bool:  # fmt: skip
    """Write R_n and u_n of an oscillator into the last columns of the room of a response."""
    S, M = STAGES, room.response
    for i in range(S):
        push = 0.0
        for j in range(S):
            weight = room.integral[i, j]
            M[i, S + j] = weight
            push += weight * ((room.nodes[GIVEN, j + 1] if driven else 0.0) - stiffness * depth)
        M[i, 2 * S] = mass * rate + push
    if damping == 0.0 and stiffness == 0.0:
        # A free mass.
        for i in range(S):
            for n in range(S, 2 * S + 1):
                M[i, n] /= mass
        return True
    for i in range(S):
        for j in range(S):
            twice = 0.0
            for n in range(S):
                twice += M[i, S + n] * M[n, S + j]
            M[i, j] = damping * M[i, S + j] + stiffness * twice + (mass if i == j else 0.0)
    return solve_linear(M, S)


@compiled
def write_response(driver: Driver, room: Room) -> bool:
    """Write velocities of the body without a force, and how far a force at a node changes them."""
    S, response, modes = STAGES, room.response, driver.modes
    depth, rate = room.nodes[D, 0], room.nodes[V, 0]
    for m in range(modes.shape[0]):
        room.swings[m, 0, 0], room.swings[m, 1, 0] = room.swing[m, 0], room.swing[m, 1]
        depth -= room.swing[m, 0]
        rate -= room.swing[m, 1]
    if not solve_oscillator(room, driver.mass, driver.damping, driver.stiffness, depth, rate, True):
        return False
    for i in range(S):
        room.unloaded[i] = response[i, 2 * S]
        for j in range(S):
            room.mobility[i, j] = response[i, S + j]
    for m in range(modes.shape[0]):
        swing = room.swing[m]
        if not solve_oscillator(room, modes[m, 0], modes[m, 1], modes[m, 2], swing[0], swing[1], False):
            return False
        for i in range(S):
            # Until the force is known.
            room.swings[m, 1, i + 1] = response[i, 2 * S]
            room.unloaded[i] += response[i, 2 * S]
            for j in range(S):
                room.mobilities[m, i, j] = response[i, S + j]
                room.mobility[i, j] += response[i, S + j]
    return True


@inlined
def excess_velocity(room: Room, i: int) -> float:
    """Return how far the velocity at the node i + 1 is above that which the forces lead to."""
    nodes = room.nodes
    total = nodes[V, i + 1] - room.unloaded[i]
    for j in range(STAGES):
        total += room.mobility[i, j] * (nodes[F, j + 1] - nodes[PULL, j + 1])
    return total


@compiled
def write_swings(driver: Driver, room: Room) -> None:
    """Write depths and velocities of the higher modes at the nodes of a solved step."""
    S, nodes = STAGES, room.nodes
    for m in range(driver.modes.shape[0]):
        swings = room.swings[m]
        for i in range(S):
            for j in range(S):
                swings[1, i + 1] -= room.mobilities[m, i, j] * (nodes[F, j + 1] - nodes[PULL, j + 1])
        for i in range(S):
            swings[0, i + 1] = swings[0, 0]
            for j in range(S):
                swings[0, i + 1] += room.integral[i, j] * swings[1, j + 1]


@inlined
def acceleration(driver: Driver, room: Room, i: int, force: float, depth: float, rate: float) -> float:
    """Return d'' of the body at a node, at which a force less the pull acts on it."""
    total = 0.0
    for m in range(driver.modes.shape[0]):
        swing, pace = room.swings[m, 0, i], room.swings[m, 1, i]
        total -= (force + driver.modes[m, 1] * pace + driver.modes[m, 2] * swing) / driver.modes[m, 0]
        depth -= swing
        rate -= pace
    return total + (room.nodes[GIVEN, i] - force - driver.damping * rate - driver.stiffness * depth) / driver.mass


@inlined
def keep_swings(driver: Driver, room: Room) -> None:
    """Move the state of the higher modes to the end of a step."""
    for m in range(driver.modes.shape[0]):
        room.swing[m, 0], room.swing[m, 1] = room.swings[m, 0, NODES - 1], room.swings[m, 1, NODES - 1]
