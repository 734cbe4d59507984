"""Contact over any history: it grows, shrinks, vanishes and returns; step by step, with one front.

Phases: FREE (no contact), GROWS (the gap closes at the front) and SHRINKS (the load vanishes at the front). A step has
the nodes of Radau IIA collocation; its unknown is the depth there, or the velocity where there is a mass. What drives
the body is

    depth:    d = f(t)
    motion:   m d'' + c d' + k d = f(t) - F        (a force for m = c = k = 0, a spring for m = c = 0)

with f piecewise polynomial plus a cosine. Memory variables of a step, with the fading memory of all increments,

    h_k' = d' - rho_k h_k,     L_k' = E_k a d' + l_k^touch a' - rho_k L_k   (growing; evaluated from panels otherwise)
    F = Einf [(d - y^2) a + Pi(y)] + eta a d' + sum L_k

A step ends at a break: a knot of f, a turning (the front stands), a joint of panels, a corner of the profile, the touch
or the end of the contact.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from restitution.kernel.compile import compiled, entry_point, inlined
from restitution.kernel.panels import (
    BACKWARD,
    CORNER,
    FLAT,
    FROZEN,
    KINK,
    NODES,
    SMOOTH,
    STAGES,
    Scheme,
    Solid,
    Stack,
    gap,
    leave,
    load,
    locate,
    polynomials,
    scheme,
    share,
    stack,
    to_coefficients,
    touch,
    value_of,
    write_displacements,
    write_loads,
)
from restitution.kernel.path import Path, radius_and_integral

FREE, GROWS, SHRINKS = range(3)
# Events at the end of a step.
NOTHING, TURNS, JOINT, ENDS, TOUCHES, BENDS = range(6)
# Error up to which the events of a step are looked for.
COARSE = 0.05
# Rounding of loads and gaps over their scales.
BLUR = 2e-14
# Outcomes.
DONE, NO_ROOM, STUCK, DIVERGED, STEEP = range(5)

# Places of numbers in `Room.state` and `Room.places`.
TIME, FRONT, DEPTH_NOW, RATE_NOW, WORK, FORCE_NOW = range(6)
PHASE, FOLLOWING, FREE_PANELS, RECORDS = range(4)


class Driver(NamedTuple):
    """What moves the body; dimensionless."""

    by_depth: bool
    knots: Any  # (m + 1,): times; two equal ones enclose a jump
    values: Any  # (m, n): coefficients of f over the share of the piece, constant first
    smooth: Any  # (m + 1,): whether f is smooth at the knot
    mass: float
    damping: float
    stiffness: float
    amplitude: float  # of the cosine
    frequency: float
    phase: float


class Scales(NamedTuple):
    """Sizes with which errors are compared."""

    depth: float
    force: float
    stress: float
    tolerance: float


class Records(NamedTuple):
    """Accepted steps: Chebyshev coefficients of depth, rate, force and y over z."""

    start: Any  # (R,)
    length: Any
    kind: Any
    phase: Any
    event: Any
    columns: Any  # (R, 4, N)


class Room(NamedTuple):
    """All arrays of one run."""

    following: Stack
    free: Stack
    records: Records
    state: Any  # floats, see TIME
    places: Any  # integers, see PHASE
    memory: Any  # (K,): h_k now
    sums: Any  # (K,): L_k now
    # Nodes of a step, the first is its start
    times: Any  # (N,)
    weights: Any  # (N,): slope of the time over z
    nodes: Any  # (9, N): depth, rate, y, a, Pi, force, event, given f, slope of load or gap over y at the front
    h: Any  # (K, N)
    L: Any  # (K, N)
    parts: Any  # (K, N): l_k at the front
    free_parts: Any  # (J, N): w_j at the front
    at: Any  # (N,): panel of the front
    z: Any  # (N,)
    fresh: Any  # (1,): whether the nodes have no front yet
    inverse: Any  # (K, S, S): of I + rho A diag(weights)
    matrix: Any  # (S, S + 1): Newton
    vectors: Any  # (8, N)
    basis: Any  # (2, N)
    lk: Any  # (2, K)
    wj: Any  # (J,)


D, V, Y, A_, PI, F, E, GIVEN, SLOPE = range(9)


def room(solid: Solid, panels: int, records: int) -> Room:
    """Return arrays for a number of panels and steps."""
    K, J, N = solid.rates.size, solid.recoveries.size, NODES
    whole = np.int64
    kept = Records(
        np.zeros(records), np.zeros(records), np.zeros(records, dtype=whole), np.zeros(records, dtype=whole),
        np.zeros(records, dtype=whole), np.zeros((records, 4, N)),
    )  # fmt: skip
    return Room(
        stack(panels, 1 + 2 * K), stack(panels, 1 + J), kept, np.zeros(6), np.zeros(5, dtype=whole), np.zeros(K),
        np.zeros(K), np.zeros(N), np.zeros(N), np.zeros((9, N)), np.zeros((K, N)), np.zeros((K, N)), np.zeros((K, N)),
        np.zeros((J, N)), np.zeros(N, dtype=whole), np.zeros(N),
        np.zeros(1, dtype=whole), np.zeros((K, STAGES, STAGES)),
        np.zeros((STAGES, STAGES + 1)), np.zeros((8, N)), np.zeros((2, N)), np.zeros((2, K)), np.zeros(J),
    )  # fmt: skip


@inlined
def given(driver: Driver, i: int, x: float, t: float) -> tuple[float, float, float]:
    """f in piece i at its coordinate x in [0, 1] and time t; f' over x, and over time by the cosine."""
    value, slope = 0.0, 0.0
    for n in range(driver.values.shape[1] - 1, -1, -1):
        slope = slope * x + value
        value = value * x + driver.values[i, n]
    rate = 0.0
    if driver.amplitude != 0.0:
        angle = driver.frequency * t + driver.phase
        value += driver.amplitude * math.cos(angle)
        rate = -driver.amplitude * driver.frequency * math.sin(angle)
    return value, slope, rate


@compiled
def solve_linear(matrix: Any, size: int) -> bool:
    """Solve by elimination with pivots; the right-hand side, the last column, becomes the solution."""
    for c in range(size):
        best, row = 0.0, c
        for r in range(c, size):
            if abs(matrix[r, c]) > best:
                best, row = abs(matrix[r, c]), r
        if not best > 0.0:
            return False
        if row != c:
            for n in range(c, size + 1):
                matrix[c, n], matrix[row, n] = matrix[row, n], matrix[c, n]
        for r in range(c + 1, size):
            factor = matrix[r, c] / matrix[c, c]
            if factor != 0.0:
                for n in range(c + 1, size + 1):
                    matrix[r, n] -= factor * matrix[c, n]
    for c in range(size - 1, -1, -1):
        value = matrix[c, size]
        for n in range(c + 1, size):
            value -= matrix[c, n] * matrix[n, size]
        matrix[c, size] = value / matrix[c, c]
    return True


@compiled
def write_inverses(solid: Solid, rule: Scheme, room: Room) -> None:
    """Write the inverses of I + rho_k A diag(weights), by elimination without pivots."""
    S = STAGES
    for k in range(solid.rates.shape[0]):
        rho, X = solid.rates[k], room.inverse[k]
        for i in range(S):
            for j in range(S):
                X[i, j] = rho * rule.A[i, j] * room.weights[j + 1] + (1.0 if i == j else 0.0)
        for c in range(S):
            pivot = 1.0 / X[c, c]
            X[c, c] = 1.0
            for j in range(S):
                X[c, j] *= pivot
            for r in range(S):
                if r != c:
                    factor = X[r, c]
                    X[r, c] = 0.0
                    for j in range(S):
                        X[r, j] -= factor * X[c, j]


@inlined
def times_inverse(X: Any, source: Any, result: Any) -> None:
    """Write the product of an inverse with values at the nodes 1 to S; both have N places."""
    for i in range(STAGES):
        total = 0.0
        for j in range(STAGES):
            total += X[i, j] * source[j + 1]
        result[i + 1] = total


@inlined
def integrate(rule: Scheme, values: Any, result: Any) -> None:
    """Write the integrals over z from 0 to the nodes."""
    result[0] = 0.0
    for i in range(STAGES):
        total = 0.0
        for j in range(STAGES):
            total += rule.A[i, j] * values[j + 1]
        result[i + 1] = total


@inlined
def differentiate(rule: Scheme, values: Any, result: Any) -> None:
    """Write the slopes over z at the nodes."""
    for i in range(NODES):
        total = 0.0
        for j in range(NODES):
            total += rule.derivative[i, j] * values[j]
        result[i] = total


@compiled
def write_forces(solid: Solid, path: Path, rule: Scheme, room: Room, phase: int) -> None:
    """Write front, radius, forces and memory at the nodes from the depths and rates there."""
    nodes, K = room.nodes, solid.rates.shape[0]
    basis, slopes = room.basis[0], room.basis[1]
    source, result = room.vectors[0], room.vectors[1]
    # h_k
    for k in range(K):
        for i in range(1, NODES):
            source[i] = room.h[k, 0] + nodes[D, i] - nodes[D, 0]
        times_inverse(room.inverse[k], source, room.h[k])
    if phase == FREE:
        for i in range(1, NODES):
            nodes[F, i] = 0.0
            nodes[Y, i] = 0.0
        return
    follows = phase == SHRINKS
    count = room.places[FOLLOWING] if follows else room.places[FREE_PANELS]
    for i in range(1, NODES):
        t = room.times[i]
        if follows:
            drive = solid.equilibrium * nodes[D, i] + solid.viscosity * nodes[V, i]
            for k in range(K):
                drive += solid.moduli[k] * room.h[k, i]
            p, z, y, steepness = locate(
                solid, room.following, count, True, t, drive, max(room.at[i], 0), room.z[i], basis, slopes
            )
            guess_next(room, i, p, z)
            if p < 0:
                p, z, y = 0, 0.0, 0.0
            y = max(y, 0.0)
            a, integral = radius_and_integral(path, y)
            write_loads(
                solid, room.following, p, z, t, room.h[:, i], a, room.parts[:, i], room.lk[0], basis, slopes
            )
            force = 0.0
            for k in range(K):
                room.L[k, i] = room.lk[0, k]
                force += room.lk[0, k]
        else:
            p, z, y, steepness = -1, 0.0, 0.0, 0.0
            if count > 0 and room.at[i] >= 0:
                p, z, y, steepness = locate(
                    solid, room.free, count, False, t, nodes[D, i], room.at[i], room.z[i], basis, slopes
                )
                guess_next(room, i, p, z)
            if p < 0:
                # Virgin surface.
                y = math.sqrt(max(nodes[D, i], 0.0))
                for j in range(solid.recoveries.shape[0]):
                    room.free_parts[j, i] = 0.0
                for k in range(K):
                    room.parts[k, i] = 0.0
            else:
                write_displacements(solid, room.free, p, z, t, room.free_parts[:, i], basis, slopes)
                touch(solid, room.free_parts[:, i], room.parts[:, i])
            y = max(y, 0.0)
            a, integral = radius_and_integral(path, y)
            force = 0.0
        room.at[i], room.z[i], nodes[SLOPE, i] = p, z, steepness
        nodes[Y, i], nodes[A_, i], nodes[PI, i] = y, a, integral
        nodes[F, i] = force
    room.fresh[0] = 0
    if not follows:
        grow_sums(solid, rule, room)
    for i in range(1, NODES):
        y, a = nodes[Y, i], nodes[A_, i]
        nodes[F, i] += solid.equilibrium * ((nodes[D, i] - y * y) * a + nodes[PI, i])
        nodes[F, i] += solid.viscosity * a * nodes[V, i]


@inlined
def guess_next(room: Room, i: int, p: int, z: float) -> None:
    """Let the first search for the front at the next node start where the last two nodes lead."""
    if i < NODES - 1 and room.fresh[0] == 1:
        room.at[i + 1], room.z[i + 1] = p, z
        if room.at[i - 1] == p and room.times[i] > room.times[i - 1]:
            pace = (z - room.z[i - 1]) / (room.times[i] - room.times[i - 1])
            room.z[i + 1] = min(max(z + pace * (room.times[i + 1] - room.times[i]), 0.0), 1.0)


@compiled
def grow_sums(solid: Solid, rule: Scheme, room: Room) -> None:
    """Write L_k of the growing contact, and add them to the forces.

    int a dd = Pi + int a dW with the surface W at the front, which is zero on virgin surface.
    """
    nodes, K = room.nodes, solid.rates.shape[0]
    source, result, a_slope, W, common = room.vectors[0], room.vectors[1], room.vectors[2], room.vectors[3], room.vectors[4]
    touched = room.places[FREE_PANELS] > 0
    if touched:
        for i in range(NODES):
            W[i] = nodes[D, i] - nodes[Y, i] * nodes[Y, i]
        differentiate(rule, W, source)
        for i in range(NODES):
            source[i] *= nodes[A_, i]
        integrate(rule, source, common)
        differentiate(rule, nodes[A_], a_slope)
    for i in range(NODES):
        common[i] = (common[i] if touched else 0.0) + nodes[PI, i] - nodes[PI, 0]
    for k in range(K):
        if touched:
            for i in range(NODES):
                source[i] = room.parts[k, i] * a_slope[i]
            integrate(rule, source, result)
        for i in range(1, NODES):
            source[i] = room.L[k, 0] + solid.moduli[k] * common[i] + (result[i] if touched else 0.0)
        times_inverse(room.inverse[k], source, room.L[k])
        for i in range(1, NODES):
            nodes[F, i] += room.L[k, i]


@compiled
def write_jacobian(solid: Solid, driver: Driver, rule: Scheme, room: Room, phase: int) -> None:
    """Write the slope of the residual by the depths (no mass) or the velocities at the nodes.

    dF = a (Einf + sum E_k B_k^-1) dd + eta a dd', as the load vanishes at the front and follows it on virgin surface.
    """
    S, nodes, M = STAGES, room.nodes, room.matrix
    dynamic = driver.mass > 0.0
    for i in range(S):
        for j in range(S):
            value = 0.0
            if phase != FREE:
                for k in range(solid.rates.shape[0]):
                    value += solid.moduli[k] * room.inverse[k, i, j]
                value += solid.equilibrium if i == j else 0.0
                # While growing the memory has the older, smaller radius; while shrinking the present one.
                value *= nodes[A_, j + 1] if phase == GROWS else nodes[A_, i + 1]
                if solid.viscosity > 0.0 and not dynamic and room.weights[i + 1] > 0.0:
                    value += solid.viscosity * nodes[A_, i + 1] * rule.derivative[i + 1, j + 1] / room.weights[i + 1]
            M[i, j] = value
    if not dynamic:
        for i in range(S):
            M[i, i] += driver.stiffness
        return
    # R = m (v - v0) + A w (c v + k d + F - f), d = d0 + A w v
    product = room.matrix
    for i in range(S):
        # row of (k + dF/dd) A w + c + eta a, in place row by row
        for j in range(S):
            total = driver.stiffness * rule.A[i, j] * room.weights[j + 1]
            for n in range(S):
                total += M[i, n] * rule.A[n, j] * room.weights[j + 1]
            room.vectors[5, j] = total
        for j in range(S):
            product[i, j] = room.vectors[5, j]
        product[i, i] += driver.damping + (solid.viscosity * nodes[A_, i + 1] if phase != FREE else 0.0)
    for j in range(S):
        for i in range(S):
            total = 0.0
            for n in range(S):
                total += rule.A[i, n] * room.weights[n + 1] * M[n, j]
            room.vectors[5, i] = total
        for i in range(S):
            M[i, j] = room.vectors[5, i]
        M[j, j] += driver.mass


@compiled
def write_residual(driver: Driver, rule: Scheme, room: Room) -> float:
    """Write minus the residual into the last column of the matrix; return its largest value."""
    S, nodes, M = STAGES, room.nodes, room.matrix
    most = 0.0
    if driver.mass > 0.0:
        for i in range(S):
            total = driver.mass * (nodes[V, i + 1] - nodes[V, 0])
            for j in range(S):
                n = j + 1
                total += (
                    rule.A[i, j]
                    * room.weights[n]
                    * (driver.damping * nodes[V, n] + driver.stiffness * nodes[D, n] + nodes[F, n] - nodes[GIVEN, n])
                )
            M[i, S] = -total
            most = max(most, abs(total))
    else:
        for i in range(S):
            n = i + 1
            M[i, S] = nodes[GIVEN, n] - nodes[F, n] - driver.stiffness * nodes[D, n]
            most = max(most, abs(M[i, S]))
    return most


@compiled
def rates_from_depths(rule: Scheme, room: Room) -> None:
    """Write the rates at the nodes as slopes of the depth; where time stands still they stay."""
    nodes = room.nodes
    for i in range(1, NODES):
        if room.weights[i] > 0.0:
            total = 0.0
            for j in range(NODES):
                total += rule.derivative[i, j] * nodes[D, j]
            nodes[V, i] = total / room.weights[i]


@compiled
def solve_step(
    solid: Solid, path: Path, driver: Driver, rule: Scheme, scales: Scales, room: Room, phase: int, frozen: bool,
    x0: float, length: float, kind: int, piece: int, span: float,
) -> bool:  # fmt: skip
    """Solve a step from share x0 of a piece on; `length` in time, or as a share of a jump. Whether it converged."""
    nodes, S = room.nodes, STAGES
    t0 = room.state[TIME]
    for i in range(NODES):
        passed, pace = share(kind, rule.c[i])
        x = x0 + length * passed / span
        if frozen:
            room.times[i], room.weights[i] = t0, 0.0
        else:
            room.times[i], room.weights[i] = t0 + length * passed, length * pace
        value, slope, rate = given(driver, piece, min(x, 1.0), room.times[i])
        nodes[GIVEN, i] = value
        if driver.by_depth and i > 0:
            nodes[D, i] = value
            nodes[V, i] = room.state[RATE_NOW] if frozen else slope / span + rate
    nodes[D, 0], nodes[V, 0], nodes[Y, 0] = room.state[DEPTH_NOW], room.state[RATE_NOW], room.state[FRONT]
    nodes[F, 0] = room.state[FORCE_NOW]
    nodes[A_, 0], nodes[PI, 0] = radius_and_integral(path, nodes[Y, 0])
    if driver.by_depth and not frozen:
        nodes[V, 0] = given(driver, piece, x0, t0)[1] / span + given(driver, piece, x0, t0)[2]
    for k in range(solid.rates.shape[0]):
        room.h[k, 0], room.L[k, 0] = room.memory[k], room.sums[k]
    start_fronts(solid, room, phase)
    write_edge(solid, room, phase)
    write_inverses(solid, rule, room)
    if driver.by_depth:
        write_forces(solid, path, rule, room, phase)
        return True
    predict(solid, path, driver, room, phase, frozen, kind)
    dynamic = driver.mass > 0.0
    if dynamic:
        depths_from_rates(rule, room)
    else:
        rates_from_depths(rule, room)
    write_forces(solid, path, rule, room, phase)
    last = math.inf
    for iteration in range(30):
        write_residual(driver, rule, room)
        write_jacobian(solid, driver, rule, room, phase)
        if not solve_linear(room.matrix, S):
            return False
        # A velocity moves the depth by its share of the step.
        reach = (length if dynamic else 1.0) / scales.depth
        change = 0.0
        for i in range(S):
            change = max(change, abs(room.matrix[i, S]) * reach)
        if not math.isfinite(change) or (iteration > 8 and change > 2.0 * last):
            return False
        for i in range(S):
            if dynamic:
                nodes[V, i + 1] += room.matrix[i, S]
            else:
                nodes[D, i + 1] += room.matrix[i, S]
        if dynamic:
            depths_from_rates(rule, room)
        else:
            rates_from_depths(rule, room)
        write_forces(solid, path, rule, room, phase)
        size = scales.depth
        for i in range(1, NODES):
            size = max(size, abs(nodes[D, i]) + (abs(nodes[V, i]) * length if dynamic else 0.0))
        rounding = 2e-15 * size / scales.depth
        if change <= max(1e-3 * scales.tolerance, rounding) or (change <= 1e-12 and change >= 0.5 * last):
            return True
        last = change
    return False


@inlined
def start_fronts(solid: Solid, room: Room, phase: int) -> None:
    """Let the search for the front start at the top of its stack."""
    if phase == SHRINKS:
        p = room.places[FOLLOWING] - 1
        z = room.following.end[max(p, 0)]
    else:
        p = room.places[FREE_PANELS] - 1
        z = room.free.end[max(p, 0)]
    for i in range(NODES):
        room.at[i], room.z[i] = p, z
    room.fresh[0] = 1


@inlined
def depths_from_rates(rule: Scheme, room: Room) -> None:
    """Write the depths at the nodes as integrals of the rate."""
    nodes = room.nodes
    for i in range(STAGES):
        total = 0.0
        for j in range(STAGES):
            total += rule.A[i, j] * room.weights[j + 1] * nodes[V, j + 1]
        nodes[D, i + 1] = nodes[D, 0] + total


@compiled
def predict(
    solid: Solid, path: Path, driver: Driver, room: Room, phase: int, frozen: bool, kind: int
) -> None:
    """Write a first guess of depths or velocities: constant velocity, or elastic growth at a first touch."""
    nodes = room.nodes
    for i in range(1, NODES):
        nodes[V, i] = nodes[V, 0]
        nodes[D, i] = nodes[D, 0]
        if driver.mass > 0.0:
            continue
        if phase == FREE:
            nodes[D, i] = nodes[GIVEN, i] / driver.stiffness if driver.stiffness > 0.0 else nodes[D, 0]
            continue
        if nodes[A_, 0] > 0.0 and nodes[Y, 0] > 0.0:
            slope = driver.stiffness + solid.glass * nodes[A_, 0]
            nodes[D, i] += (nodes[GIVEN, i] - nodes[GIVEN, 0]) / slope
            continue
        # Pi(y) = f/E0, by bisection in y.
        modulus = solid.glass
        if solid.viscosity > 0.0:
            modulus += solid.viscosity / max(room.times[i] - room.times[0], 1e-300)
        low, high = 0.0, 1.0
        for _ in range(200):
            if modulus * radius_and_integral(path, high)[1] + driver.stiffness * high * high > nodes[GIVEN, i] - driver.stiffness * nodes[D, 0]:
                break
            low, high = high, 2.0 * high
        for _ in range(40):
            middle = 0.5 * (low + high)
            if modulus * radius_and_integral(path, middle)[1] + driver.stiffness * middle * middle > nodes[GIVEN, i] - driver.stiffness * nodes[D, 0]:
                high = middle
            else:
                low = middle
        nodes[D, i] = nodes[D, 0] + high * high


@compiled
def write_turning(solid: Solid, room: Room, phase: int) -> None:
    """Write the event at the nodes that changes sign, from below, where the front turns.

    Growing: the surface at the front rises faster than the body sinks. Shrinking: the load at the front rises.
    """
    nodes, K = room.nodes, solid.rates.shape[0]
    for i in range(NODES):
        if phase == GROWS:
            surface = 0.0
            if i > 0 and room.at[i] >= 0:
                for j in range(solid.recoveries.shape[0]):
                    surface -= solid.recoveries[j] * room.free_parts[j, i]
            nodes[E, i] = surface - nodes[V, i]
        elif phase == SHRINKS:
            lost = 0.0
            for k in range(K):
                lost += solid.rates[k] * room.parts[k, i]
            nodes[E, i] = (solid.glass * nodes[V, i] - lost) / solid.glass
    if phase != FREE:
        nodes[E, 0] = -1.0


@compiled
def write_joint(solid: Solid, room: Room, phase: int, p: int) -> None:
    """Write the event that changes sign, from below, where the front reaches the lower end of panel p."""
    nodes, K = room.nodes, solid.rates.shape[0]
    for i in range(1, NODES):
        if phase == GROWS:
            value, _, _, _ = gap(solid, room.free, p, 0.0, room.times[i], nodes[D, i], room.basis[0], room.basis[1])
            nodes[E, i] = -value
        else:
            drive = solid.equilibrium * nodes[D, i] + solid.viscosity * nodes[V, i]
            for k in range(K):
                drive += solid.moduli[k] * room.h[k, i]
            value, _, _, _ = load(solid, room.following, p, 0.0, room.times[i], drive, room.basis[0], room.basis[1])
            nodes[E, i] = -value
    nodes[E, 0] = -1.0


@compiled
def crossing(rule: Scheme, room: Room, deadband: float) -> float:
    """Smallest z in (0, 1] at which the event passes zero upwards; 2 if it does not."""
    nodes = room.nodes
    first = 0
    for i in range(1, NODES):
        if nodes[E, i] > deadband:
            first = i
            break
    if first == 0:
        return 2.0
    row = room.vectors[6]
    # The start has no value of its own: a polynomial through the nodes 1 to S would do, but it is one degree less.
    if first == 1:
        low = 0.0
    else:
        low = rule.c[first - 1]
    high = rule.c[first]
    for n in range(NODES):
        room.vectors[7, n] = nodes[E, n]
    extrapolate(rule, room.vectors[7])
    to_coefficients(rule, room.vectors[7], row)
    for _ in range(60):
        middle = 0.5 * (low + high)
        polynomials(middle, room.basis[0], room.basis[1])
        value = 0.0
        for n in range(NODES):
            value += row[n] * room.basis[0][n]
        if value > 0.0:
            high = middle
        else:
            low = middle
    return high


@inlined
def extrapolate(rule: Scheme, values: Any) -> None:
    """Write the value at 0 of the polynomial through the other nodes."""
    total = 0.0
    for i in range(1, NODES):
        weight = 1.0
        for j in range(1, NODES):
            if j != i:
                weight *= (0.0 - rule.c[j]) / (rule.c[i] - rule.c[j])
        total += weight * values[i]
    values[0] = total


@compiled
def write_edge(solid: Solid, room: Room, phase: int) -> None:
    """Write l_k and w_j of the element at the front, at the start of a step."""
    basis, slopes = room.basis[0], room.basis[1]
    if phase == SHRINKS:
        p = room.places[FOLLOWING] - 1
        write_loads(
            solid, room.following, p, room.following.end[p], room.state[TIME], room.h[:, 0], 0.0, room.parts[:, 0],
            room.lk[0], basis, slopes,
        )  # fmt: skip
        return
    p = room.places[FREE_PANELS] - 1
    if p >= 0:
        write_displacements(
            solid, room.free, p, room.free.end[p], room.state[TIME], room.free_parts[:, 0], basis, slopes
        )
    for j in range(solid.recoveries.shape[0]):
        if p < 0:
            room.free_parts[j, 0] = 0.0
    touch(solid, room.free_parts[:, 0], room.parts[:, 0])


@compiled
def surface_at_axis(solid: Solid, room: Room, t: float) -> float:
    """Depth of the free surface at the axis."""
    p = room.places[FREE_PANELS] - 1
    if p < 0:
        return 0.0
    value, _, _, _ = gap(solid, room.free, p, room.free.end[p], t, 0.0, room.basis[0], room.basis[1])
    return value


@compiled
def step_error(rule: Scheme, scales: Scales, solid: Solid, room: Room, phase: int) -> float:
    """Size of the last two coefficients of depth, force, y^2 and shared load over their scales."""
    nodes, row, values = room.nodes, room.vectors[6], room.vectors[7]
    worst = 0.0
    for quantity in range(4):
        scale = scales.depth
        for i in range(NODES):
            if quantity == 0:
                values[i] = nodes[D, i]
            elif quantity == 1:
                values[i] = nodes[F, i]
            elif quantity == 2:
                values[i] = nodes[Y, i] * nodes[Y, i]
            else:
                values[i] = 0.0
                for k in range(solid.rates.shape[0]):
                    values[i] += solid.moduli[k] * room.h[k, i]
        if quantity == 1:
            scale = scales.force
        elif quantity == 3:
            scale = scales.stress
        to_coefficients(rule, values, row)
        error = (abs(row[NODES - 1]) + abs(row[NODES - 2])) / scale
        if quantity == 2 and error > scales.tolerance and front_is_blurred(rule, scales, room, phase):
            continue
        # Comparisons with NaN are false.
        if not error <= worst:
            worst = error
    return worst


@compiled
def front_is_blurred(rule: Scheme, scales: Scales, room: Room, phase: int) -> bool:
    """Whether the scatter of the front is that of rounding, where load or gap hardly depend on the place.

    So it is with loads that have decayed nearly to zero. The force does not feel it.
    """
    row, steepest = room.vectors[6], 0.0
    to_coefficients(rule, room.nodes[Y], row)
    for i in range(1, NODES):
        steepest = max(steepest, room.nodes[SLOPE, i])
    scatter = (abs(row[NODES - 1]) + abs(row[NODES - 2])) * steepest
    return scatter <= BLUR * (scales.stress if phase == SHRINKS else scales.depth)


@compiled
def first_event(
    solid: Solid, path: Path, rule: Scheme, scales: Scales, room: Room, driver: Driver, phase: int, frozen: bool,
    length: float, settled: bool,
) -> tuple[int, float]:  # fmt: skip
    """First event of a solved step and its z; (NOTHING, 2) if there is none."""
    event, first = NOTHING, 2.0
    nodes = room.nodes
    if phase == FREE:
        for i in range(1, NODES):
            if driver.by_depth or driver.mass > 0.0 or driver.stiffness > 0.0:
                nodes[E, i] = nodes[D, i] - surface_at_axis(solid, room, room.times[i])
            else:
                nodes[E, i] = nodes[GIVEN, i]
        z = crossing(rule, room, 0.0)
        return (TOUCHES, z) if z <= 1.0 else (NOTHING, 2.0)
    if not frozen and not settled:
        write_turning(solid, room, phase)
        z = crossing(rule, room, 1e-13 * scales.depth / length)
        if z < first:
            event, first = TURNS, z
    panels = room.free if phase == GROWS else room.following
    p = (room.places[FREE_PANELS] if phase == GROWS else room.places[FOLLOWING]) - 1
    if p >= 0:
        while p > 0 and panels.joint[p] == SMOOTH:
            p -= 1
        write_joint(solid, room, phase, p)
        z = crossing(rule, room, 0.0)
        if z < first:
            event, first = (ENDS if p == 0 and phase == SHRINKS else JOINT), z
    elif path.kinks.shape[0] > 0:
        corner = next_corner(path, nodes[Y, 0])
        if corner > 0.0:
            for i in range(1, NODES):
                nodes[E, i] = nodes[D, i] - corner * corner
            z = crossing(rule, room, 0.0)
            if z < first:
                event, first = BENDS, z
    return event, first


@compiled
def next_corner(path: Path, y: float) -> float:
    """Next corner of the profile beyond y; -1 if there is none."""
    best = -1.0
    for n in range(path.kinks.shape[0]):
        place = path.kinks[n]
        if place > y * (1.0 + 1e-13) and (best < 0.0 or place < best):
            best = place
    return best


@compiled
def event_at_end(solid: Solid, path: Path, room: Room, driver: Driver, phase: int, event: int) -> float:
    """Value of the event at the end of a step, and write it at all nodes."""
    nodes = room.nodes
    last = NODES - 1
    if event == TURNS:
        write_turning(solid, room, phase)
    elif event == TOUCHES:
        for i in range(1, NODES):
            if driver.by_depth or driver.mass > 0.0 or driver.stiffness > 0.0:
                nodes[E, i] = nodes[D, i] - surface_at_axis(solid, room, room.times[i])
            else:
                nodes[E, i] = nodes[GIVEN, i]
    elif event == BENDS:
        corner = next_corner(path, nodes[Y, 0])
        for i in range(1, NODES):
            nodes[E, i] = nodes[D, i] - corner * corner
    else:
        panels = room.free if phase == GROWS else room.following
        p = (room.places[FREE_PANELS] if phase == GROWS else room.places[FOLLOWING]) - 1
        while p > 0 and panels.joint[p] == SMOOTH:
            p -= 1
        write_joint(solid, room, phase, p)
    return nodes[E, last]


@compiled
def push(solid: Solid, rule: Scheme, room: Room, phase: int, length: float, kind: int, joint: int) -> None:
    """Put the elements that changed state in a step on their stack."""
    nodes, K = room.nodes, solid.rates.shape[0]
    values = room.vectors[6]
    panels = room.following if phase == GROWS else room.free
    place = FOLLOWING if phase == GROWS else FREE_PANELS
    p = room.places[place]
    room.places[place] = p + 1
    panels.start[p], panels.length[p], panels.kind[p] = room.state[TIME], length, kind
    panels.end[p], panels.joint[p] = 1.0, joint
    row = panels.coefficients[p]
    to_coefficients(rule, nodes[Y], row[0])
    if phase == GROWS:
        for k in range(K):
            for i in range(NODES):
                values[i] = room.parts[k, i] - solid.moduli[k] * room.h[k, i]
            to_coefficients(rule, values, row[1 + k])
            for i in range(NODES):
                values[i] = room.L[k, i] - solid.moduli[k] * room.h[k, i] * nodes[A_, i]
            to_coefficients(rule, values, row[1 + K + k])
        return
    for i in range(NODES):
        leave(solid, nodes[D, i] - nodes[Y, i] * nodes[Y, i], room.parts[:, i], room.free_parts[:, i])
    for j in range(solid.recoveries.shape[0]):
        to_coefficients(rule, room.free_parts[j], row[1 + j])


@compiled
def accept(
    solid: Solid, path: Path, rule: Scheme, room: Room, driver: Driver, phase: int, length: float, kind: int,
    frozen: bool, event: int, joint: int, stop: float,
) -> None:  # fmt: skip
    """Move the state to the end of a step, at time `stop`."""
    nodes, last, K = room.nodes, NODES - 1, solid.rates.shape[0]
    n = room.places[RECORDS]
    kept = room.records
    kept.start[n], kept.length[n], kept.kind[n] = room.state[TIME], (0.0 if frozen else length), kind
    kept.phase[n], kept.event[n] = phase, event
    to_coefficients(rule, nodes[D], kept.columns[n, 0])
    to_coefficients(rule, nodes[V], kept.columns[n, 1])
    to_coefficients(rule, nodes[F], kept.columns[n, 2])
    to_coefficients(rule, nodes[Y], kept.columns[n, 3])
    room.places[RECORDS] = n + 1
    slopes = room.vectors[7]
    differentiate(rule, nodes[D], slopes)
    for i in range(1, NODES):
        room.state[WORK] += rule.A[STAGES - 1, i - 1] * nodes[F, i] * slopes[i]
    moved = abs(nodes[Y, last] - nodes[Y, 0]) > 0.0
    if phase != FREE and (moved or event == ENDS):
        of = FROZEN if frozen else kind
        push(solid, rule, room, phase, length, of, joint)
        swept, place = (room.free, FREE_PANELS) if phase == GROWS else (room.following, FOLLOWING)
        p, z = room.at[last], room.z[last]
        if event == JOINT:
            p = room.places[place] - 1
            while p > 0 and swept.joint[p] == SMOOTH:
                p -= 1
            p, z = p - 1, 1.0
            room.places[place] = p + 1
        elif event == ENDS or p < 0:
            room.places[place] = 0
        else:
            room.places[place] = p + 1
            swept.end[p] = z
            if z <= 0.0:
                room.places[place] = p
    room.state[TIME] = stop
    room.state[DEPTH_NOW], room.state[RATE_NOW] = nodes[D, last], nodes[V, last]
    room.state[FRONT], room.state[FORCE_NOW] = nodes[Y, last], nodes[F, last]
    for k in range(K):
        room.memory[k], room.sums[k] = room.h[k, last], room.L[k, last]
    if event == ENDS:
        end_contact(solid, room)
    if event == TOUCHES:
        begin_contact(solid, path, room)


@inlined
def end_contact(solid: Solid, room: Room) -> None:
    """Let the innermost element leave."""
    room.state[FRONT], room.state[FORCE_NOW] = 0.0, 0.0
    room.places[FOLLOWING] = 0
    for k in range(solid.rates.shape[0]):
        room.sums[k] = 0.0


@compiled
def begin_contact(solid: Solid, path: Path, room: Room) -> None:
    """Let the element at the axis touch: no following elements, but those of a flat face."""
    room.state[FRONT] = 0.0
    radius = radius_and_integral(path, 0.0)[0]
    p = room.places[FREE_PANELS] - 1
    for j in range(solid.recoveries.shape[0]):
        room.wj[j] = 0.0
    if p >= 0:
        write_displacements(
            solid, room.free, p, room.free.end[p], room.state[TIME], room.wj, room.basis[0], room.basis[1]
        )
    touch(solid, room.wj, room.lk[0])
    for k in range(solid.rates.shape[0]):
        room.memory[k] = 0.0
        room.sums[k] = room.lk[0, k] * radius


@compiled
def rate_after_kink(solid: Solid, path: Path, driver: Driver, room: Room, piece: int, x: float, span: float) -> float:
    """Rate of the depth behind a kink of what is prescribed; the share of a jump for a jump."""
    t = room.state[TIME]
    _, slope, rate = given(driver, piece, x, t)
    rate += slope / span
    if driver.by_depth:
        return rate
    if driver.mass > 0.0:
        return room.state[RATE_NOW]
    a = radius_and_integral(path, room.state[FRONT])[0]
    lost = 0.0
    for k in range(solid.rates.shape[0]):
        lost += solid.rates[k] * room.sums[k]
    stiffness = driver.stiffness + solid.glass * a
    if solid.viscosity > 0.0 or not stiffness > 0.0:
        return room.state[RATE_NOW]
    return (rate + lost) / stiffness


@compiled
def phase_after_kink(solid: Solid, room: Room, phase: int, rate: float, frozen: bool) -> int:
    """Whether the contact grows or shrinks at this rate of the depth."""
    if frozen:
        return GROWS if rate >= 0.0 else SHRINKS
    for k in range(solid.rates.shape[0]):
        room.h[k, 0] = room.memory[k]
    write_edge(solid, room, phase)
    lost = 0.0
    for k in range(solid.rates.shape[0]):
        lost += solid.rates[k] * room.parts[k, 0]
    return GROWS if solid.glass * rate >= lost else SHRINKS


@inlined
def end_joint(room: Room, phase: int) -> int:
    """Kind of the joint which the front meets next."""
    panels, p = room.following, room.places[FOLLOWING] - 1
    if phase == GROWS:
        panels, p = room.free, room.places[FREE_PANELS] - 1
    while p > 0 and panels.joint[p] == SMOOTH:
        p -= 1
    return panels.joint[p]


@compiled
def jump(solid: Solid, path: Path, rule: Scheme, room: Room, phase: int, z: float, joint: int) -> None:
    """Let the front pass at once to z of the top panel of the stack before it, whose elements change state now.

    So it does, within rounding, where loads have decayed to nothing, or the tip meets an imprint of its own shape.
    """
    nodes, K, last = room.nodes, solid.rates.shape[0], NODES - 1
    t, basis, slopes = room.state[TIME], room.basis[0], room.basis[1]
    panels, place = room.following, FOLLOWING
    if phase == GROWS:
        panels, place = room.free, FREE_PANELS
    p = room.places[place] - 1
    end = panels.end[p]
    for k in range(K):
        room.L[k, 0] = room.sums[k]
        for i in range(NODES):
            room.h[k, i] = room.memory[k]
    for i in range(NODES):
        at = end + (z - end) * rule.c[i]
        polynomials(at, basis, slopes)
        y = max(value_of(panels.coefficients[p, 0], basis), 0.0)
        nodes[D, i], nodes[Y, i] = room.state[DEPTH_NOW], y
        nodes[A_, i], nodes[PI, i] = radius_and_integral(path, y)
        if phase == SHRINKS:
            write_loads(
                solid, panels, p, at, t, room.memory, nodes[A_, i], room.parts[:, i], room.lk[0], basis, slopes
            )
            for k in range(K):
                room.L[k, i] = room.lk[0, k]
        else:
            write_displacements(solid, panels, p, at, t, room.free_parts[:, i], basis, slopes)
            touch(solid, room.free_parts[:, i], room.parts[:, i])
    if phase == GROWS:
        a_slope, source, result = room.vectors[2], room.vectors[0], room.vectors[1]
        differentiate(rule, nodes[A_], a_slope)
        for k in range(K):
            for i in range(NODES):
                source[i] = room.parts[k, i] * a_slope[i]
            integrate(rule, source, result)
            for i in range(1, NODES):
                room.L[k, i] = room.L[k, 0] + result[i]
    push(solid, rule, room, phase, 0.0, FROZEN, joint)
    panels.end[p] = z
    room.places[place] = p + 1 if z > 0.0 else p
    room.state[FRONT] = nodes[Y, last]
    for k in range(K):
        room.sums[k] = room.L[k, last]


@compiled
def jump_to_joint(solid: Solid, path: Path, rule: Scheme, room: Room, phase: int) -> None:
    """Let the front pass at once to the next joint."""
    panels, place = room.following, FOLLOWING
    if phase == GROWS:
        panels, place = room.free, FREE_PANELS
    p = room.places[place] - 1
    while p > 0 and panels.joint[p] == SMOOTH:
        p -= 1
    while room.places[place] > max(p, 0):
        jump(solid, path, rule, room, phase, 0.0, KINK)


@compiled
def jump_ahead(solid: Solid, path: Path, rule: Scheme, room: Room, phase: int, moment: float, depth: float) -> bool:
    """Let the front pass at once to where it is a moment later, at this depth; False if it hardly moves."""
    panels, place, follows = room.following, FOLLOWING, True
    drive = solid.equilibrium * depth + solid.viscosity * room.state[RATE_NOW]
    rate = (depth - room.state[DEPTH_NOW]) / moment
    for k in range(solid.rates.shape[0]):
        decay = math.exp(-solid.rates[k] * moment)
        drive += solid.moduli[k] * (room.memory[k] * decay + rate * (1.0 - decay) / solid.rates[k])
    if phase == GROWS:
        panels, place, follows, drive = room.free, FREE_PANELS, False, depth
    count = room.places[place]
    if count == 0:
        return False
    p, z, y, _ = locate(
        solid, panels, count, follows, room.state[TIME] + moment, drive, count - 1, panels.end[count - 1],
        room.basis[0], room.basis[1],
    )  # fmt: skip
    if abs(y - room.state[FRONT]) <= 1e-13 * max(y, room.state[FRONT]):
        return False
    joint = KINK
    while room.places[place] > p + 1:
        jump(solid, path, rule, room, phase, 0.0, joint)
        joint = SMOOTH if panels.joint[room.places[place]] == SMOOTH else KINK
    if p >= 0 and z < panels.end[p]:
        jump(solid, path, rule, room, phase, z, joint)
    return True


@compiled
def event_ahead(solid: Solid, room: Room, rule: Scheme, phase: int, kind: int) -> tuple[bool, int, float]:
    """Whether the front meets an end of its way soon after the step, which one, and after how many steps."""
    panels, p = room.following, room.places[FOLLOWING] - 1
    if phase == GROWS:
        panels, p = room.free, room.places[FREE_PANELS] - 1
    while p > 0 and panels.joint[p] == SMOOTH:
        p -= 1
    event = ENDS if p == 0 and phase == SHRINKS else JOINT
    if p < 0 or kind != 1 or (event == JOINT and panels.joint[p] < FLAT):
        return False, NOTHING, 0.0
    write_joint(solid, room, phase, p)
    n = NODES - 1
    value, before, half = room.nodes[E, n], room.nodes[E, n - 2], room.nodes[E, n - 5]
    x1, x2 = rule.c[n - 2], rule.c[n - 5]
    first, second = (value - before) / (1.0 - x1), (before - half) / (x1 - x2)
    curvature = (first - second) / (1.0 - x2)
    slope = first + curvature * (1.0 - x1)
    if not slope > 0.0:
        return False, NOTHING, 0.0
    further = -value / slope
    if not further < 2.0:
        return False, NOTHING, 0.0
    return True, event, 1.0 + further


@inlined
def shorter(ratio: float) -> float:
    """Factor of a step whose error is too large by 1/ratio."""
    return min(max(0.8 * ratio ** (1.0 / STAGES), 0.1), 0.7) if ratio > 0.0 else 0.25


@entry_point
def run(
    solid: Solid, path: Path, driver: Driver, rule: Scheme, scales: Scales, room: Room, first_power: int, most: int
) -> int:
    """Follow the body through all pieces of what is prescribed; return the outcome."""
    phase, guess = room.places[PHASE], math.inf
    start_kind = first_power if phase == GROWS and room.places[FOLLOWING] == 0 else 1
    joint = KINK
    panels = room.following.start.shape[0]
    for piece in range(driver.knots.shape[0] - 1):
        span = driver.knots[piece + 1] - driver.knots[piece]
        frozen = span == 0.0
        whole = 1.0 if frozen else span
        done = 0.0
        if not driver.smooth[piece]:
            if phase != FREE:
                if frozen:
                    rate = given(driver, piece, 1.0, 0.0)[0] - given(driver, piece, 0.0, 0.0)[0]
                else:
                    rate = rate_after_kink(solid, path, driver, room, piece, 0.0, span)
                    room.state[RATE_NOW] = rate
                if room.state[FRONT] > 0.0 or room.places[FOLLOWING] > 0:
                    phase = phase_after_kink(solid, room, phase, rate, frozen)
            joint = KINK
        guess = min(guess, whole) if not frozen else whole
        switches = 0
        while done < whole:
            left = whole - done
            # Two times that differ by less are one.
            grain = 1e-15 if frozen else max(4e-16 * abs(room.state[TIME]), 1e-18 * whole)
            instant, jumps = grain, 0
            speed = max(abs(room.state[RATE_NOW]), scales.depth / max(driver.knots[-1] - driver.knots[0], 1e-300))
            moment = max(grain, 0.01 * scales.tolerance * scales.stress / (solid.glass * speed))
            length = min(guess, left)
            # A last piece that is much shorter than the others costs as much as they do.
            if length > 0.6 * left:
                length = left
            kind, hunted, tries, aimed = start_kind, NOTHING, 0, math.inf
            last_length, last_value = 0.0, 0.0
            settled = switches > 4
            while True:
                tries += 1
                if tries > 200:
                    return STUCK
                x0 = done if frozen else done / span
                fine = solve_step(
                    solid, path, driver, rule, scales, room, phase, frozen, x0, length, kind, piece, whole
                )
                error = step_error(rule, scales, solid, room, phase) if fine else math.inf
                if length < moment:
                    # Loads change by less than the tolerance meanwhile: the front jumps.
                    depth = room.state[DEPTH_NOW] + moment * room.state[RATE_NOW]
                    jumps += 1
                    if frozen or phase == FREE or jumps > 20 or not jump_ahead(
                        solid, path, rule, room, phase, moment, depth
                    ):
                        if length < grain:
                            return STEEP
                        moment = grain
                        continue
                    hunted, kind, length = NOTHING, 1, min(left, 16.0 * moment)
                    continue
                if hunted != NOTHING and not error <= scales.tolerance:
                    hunted, kind = NOTHING, start_kind
                    length *= shorter(scales.tolerance / error)
                    continue
                if hunted == NOTHING:
                    # Behind a joint or the end a step is not smooth, but the event, which follows from the depth, is.
                    event, z = NOTHING, 2.0
                    if error < COARSE:
                        event, z = first_event(
                            solid, path, rule, scales, room, driver, phase, frozen, length, settled
                        )
                    passed, ahead = share(kind, z)[0], False
                    if event == NOTHING and not error <= scales.tolerance and error < COARSE and aimed > length:
                        # Close to an end of the front's way a step that ends there is smooth, a shorter one is not.
                        ahead, event, passed = event_ahead(solid, room, rule, phase, kind)
                        if ahead:
                            aimed = length
                            if length * passed > left:
                                ahead, event = False, NOTHING
                    if not error <= scales.tolerance and event == NOTHING:
                        length *= shorter(scales.tolerance / error)
                        continue
                    if event == NOTHING:
                        break
                    backward = event == ENDS or (event == JOINT and end_joint(room, phase) >= FLAT)
                    if backward and start_kind != 1:
                        # One step has one map: first a step that does not reach the event.
                        length *= 0.5 * passed
                        continue
                    hunted = event
                    instant = max(grain, 1e-13 * length)
                    last_length, last_value = 0.0, -math.inf
                    length *= passed
                    if backward:
                        kind = BACKWARD
                    if length < instant:
                        break
                    continue
                value = event_at_end(solid, path, room, driver, phase, hunted)
                if last_value == -math.inf:
                    # Slope of the event over time from the last two nodes.
                    n = NODES - 1
                    before = share(kind, rule.c[n - 1])[0]
                    slope = (value - room.nodes[E, n - 1]) / (length * (1.0 - before))
                else:
                    slope = (value - last_value) / (length - last_length)
                change = -value / slope if slope > 0.0 else 0.0
                if abs(change) <= grain or tries > 40:
                    break
                if last_value != -math.inf and abs(value) >= abs(last_value):
                    break
                last_length, last_value = length, value
                length = min(max(length + change, 0.5 * length), min(1.5 * length, left))
            event = hunted
            tiny = event != NOTHING and length < instant
            if not tiny:
                if room.places[RECORDS] == room.records.start.shape[0] or max(
                    room.places[FOLLOWING], room.places[FREE_PANELS]
                ) >= panels - 1:
                    room.places[PHASE] = phase
                    return NO_ROOM
                ends = left - length <= max(4.0 * grain, 1e-15 * whole)
                done = whole if ends else done + length
                stop = room.state[TIME]
                if not frozen:
                    stop = driver.knots[piece + 1] if ends else driver.knots[piece] + done
                accept(solid, path, rule, room, driver, phase, length, kind, frozen, event, joint, stop)
                switches = 0
                if event == NOTHING:
                    factor = 0.8 * (scales.tolerance / max(error, 1e-30)) ** (1.0 / STAGES)
                    guess = length * min(max(factor, 0.3), 4.0)
                else:
                    guess = max(length, 0.5 * guess)
            else:
                switches += 1
                if event == TOUCHES:
                    begin_contact(solid, path, room)
                elif event == JOINT or event == ENDS:
                    jump_to_joint(solid, path, rule, room, phase)
                    if event == ENDS:
                        end_contact(solid, room)
            joint, start_kind = SMOOTH, 1
            if event == TURNS:
                phase = SHRINKS if phase == GROWS else GROWS
                joint = FLAT
            elif event == TOUCHES:
                phase, start_kind = GROWS, first_power
                guess = left
            elif event == ENDS:
                phase = FREE
                guess = math.inf
            elif event == JOINT:
                joint = KINK
            elif event == BENDS:
                joint, start_kind = CORNER, 2
            guess = min(guess, max(whole - done, 0.0)) if whole > done else guess
            if room.places[RECORDS] > most:
                return NO_ROOM
    room.places[PHASE] = phase
    return DONE
