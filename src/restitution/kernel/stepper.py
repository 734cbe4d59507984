"""One step of a contact with any history: fronts, forces and memory at the nodes, and the motion that they allow.

The nodes of a step are those of Radau IIA collocation; the unknown is the depth there, or the velocity where there is
a mass or a dashpot. The memory of all increments of the depth, and of those that the growing contact feels, is

    h_k' = d' - rho_k h_k,     L_k' = E_k a d' + l_k^touch a' - rho_k L_k,
    F = Einf [(d - y^2) a + Pi(y)] + eta a d' + sum L_k

While the contact shrinks, L_k follows from the panels (docs/development/decisions/histories.md).
"""

import math
from typing import Any

from restitution.kernel.compile import compiled, inlined
from restitution.kernel.driver import (
    BELOW,
    DEPTH,
    EVENT,
    FOLLOWING,
    FORCE,
    FREE,
    FREE_PANELS,
    FRONT,
    GIVEN,
    GROWS,
    NO_FRONT_YET,
    PACE,
    PI,
    PULL,
    RATE,
    RISE,
    SHRINKS,
    TIME,
    TIME_PASSES,
    A,
    D,
    Driver,
    F,
    Problem,
    Room,
    Step,
    V,
    Y,
    ahead,
    by_increase,
    by_rate,
    ends_by_load,
    is_force,
    is_light,
    prescribed_at,
    rise_of_given,
    rounding_of_force,
    rounding_of_load,
)
from restitution.kernel.elimination import factorise, solve_factorised, solve_linear
from restitution.kernel.fronts import shared_load, write_fronts
from restitution.kernel.growth import at_nodes, differentiate, write_growing_sums
from restitution.kernel.lanes import WIDTH, broadcast, read8, write8
from restitution.kernel.lever import excess_velocity, write_response, write_swings
from restitution.kernel.panels import (
    NODES,
    STAGES,
    Scheme,
    Solid,
    gap,
    larger,
    load,
    locate,
    polynomials,
    share,
    touch,
    value_of,
    write_displacements,
    write_loads,
)
from restitution.kernel.path import Path, radius_and_integral

# Trials of a first guess at a touch.
_MOST_GUESSES = 40
# y, over that of the largest depth, below which forces by sums of loads pass into forces by loads.
_SMALL = 0.1
# Where a load vanishes, so does the slope of the force: the error is only halved then.
_MOST_ITERATIONS = 60
# Change by an iteration below which the next one has the same matrix.
_SMALL_CHANGE = 5e-3
# Change by an iteration that does not converge further, over the tolerance.
_SETTLED = 0.05
# Difference of the forces of a panel and of the step before, over the error of a step.
_SAME_FORCE = 100.0
# Roundings by which forces may differ from those prescribed.
_FEW_ROUNDINGS = 10.0
# Rounding of a depth, over the depth.
_DEPTH_ROUNDING = 1e-15


@compiled
def write_integral(rule: Scheme, room: Room) -> None:
    """Write A diag(weights), which integrates over the time of a step."""
    for i in range(STAGES):
        for j in range(STAGES):
            room.integral[i, j] = rule.A[i, j] * room.weights[j + 1]


@compiled
def write_inverses(solid: Solid, room: Room) -> None:
    """Write the inverses of I + rho_k A diag(weights), which are well conditioned, by elimination without pivots."""
    S, integral = STAGES, room.integral
    for k in range(solid.rates.shape[0]):
        X = room.inverse[k]
        for i in range(S):
            write8(X, i, 0, solid.rates[k] * read8(integral, i, 0))
            write8(X, i, WIDTH, solid.rates[k] * read8(integral, i, WIDTH))
            X[i, i] += 1.0
        for c in range(S):
            pivot = 1.0 / X[c, c]
            low, high = pivot * read8(X, c, 0), pivot * read8(X, c, WIDTH)
            for r in range(S):
                if r != c:
                    factor = X[r, c]
                    write8(X, r, 0, read8(X, r, 0) - factor * low)
                    write8(X, r, WIDTH, read8(X, r, WIDTH) - factor * high)
                    X[r, c] = -factor * pivot
            write8(X, c, 0, low)
            write8(X, c, WIDTH, high)
            X[c, c] = pivot


@inlined
def write_product(first: Any, second: Any, result: Any) -> None:
    """Write the product of two matrices with a row for each node."""
    for i in range(STAGES):
        low, high = broadcast(0.0), broadcast(0.0)
        for n in range(STAGES):
            low = low + first[i, n] * read8(second, n, 0)
            high = high + first[i, n] * read8(second, n, WIDTH)
        write8(result, i, 0, low)
        write8(result, i, WIDTH, high)


@inlined
def axis_load(solid: Solid, room: Room, i: int) -> float:
    """Return the load of the following element next to the axis at a node."""
    drive = shared_load(solid, room, i)
    return load(solid, room.following, 0, 0.0, room.times[i], drive, room.basis[0], room.basis[1])[0]


@compiled
def force_of_loads(solid: Solid, path: Path, rule: Scheme, room: Room, i: int) -> float:
    """Return the force of a shrinking contact by its loads, `int q da`.

    Other than by the sums of loads, which are known to the tolerance, it vanishes where the load at the axis does.
    """
    total, drive = 0.0, shared_load(solid, room, i)
    for p in range(room.at[i] + 1):
        end = room.z[i] if p == room.at[i] else room.following.end[p]
        for j in range(STAGES):
            _, slope, y, _ = load(
                solid, room.following, p, end * rule.c[j + 1], room.times[i], drive, room.basis[0], room.basis[1]
            )
            # By parts, as the load vanishes at the front.
            total -= rule.A[STAGES - 1, j] * end * slope * radius_and_integral(path, max(y, 0.0))[0]
    return total


@compiled
def add_force(solid: Solid, driver: Driver, path: Path, rule: Scheme, room: Room, phase: int, i: int) -> None:
    """Add all other parts of the force at a node to that by the memory."""
    nodes = room.nodes
    y, a = nodes[Y, i], nodes[A, i]
    nodes[F, i] += solid.equilibrium * ((nodes[D, i] - y * y) * a + nodes[PI, i])
    nodes[F, i] += solid.viscosity * a * nodes[V, i]
    if phase == SHRINKS and ends_by_load(solid, driver) and 0.0 < y < _SMALL:
        part = (y / _SMALL) ** 4
        nodes[F, i] = part * nodes[F, i] + (1.0 - part) * force_of_loads(solid, path, rule, room, i)


@compiled
def write_forces(solid: Solid, driver: Driver, path: Path, rule: Scheme, room: Room, phase: int) -> None:
    """Write fronts, memory and forces at the nodes from the depths and rates there."""
    nodes, source = room.nodes, room.vectors[0]
    if phase == FREE:
        # The memory of a contact begins with it.
        for i in range(1, NODES):
            nodes[F, i], nodes[Y, i] = 0.0, 0.0
        return
    for k in range(solid.rates.shape[0]):
        for i in range(1, NODES):
            source[i] = room.h[k, 0] + nodes[D, i] - nodes[D, 0]
        at_nodes(room.inverse[k], source, room.h[k])
    write_fronts(solid, driver, room, path, phase)
    if phase == GROWS:
        write_growing_sums(solid, driver, path, rule, room)
    for i in range(1, NODES):
        add_force(solid, driver, path, rule, room, phase, i)


@compiled
def write_stiffness(solid: Solid, driver: Driver, rule: Scheme, room: Room, phase: int) -> None:
    """Write the slopes of the forces at the nodes by the depths there, without a dashpot at given rates.

    dF = a (Einf + sum E_k B_k^-1) dd, as the load vanishes at a shrinking front; at a growing one over virgin surface
    a stands behind the memory, and the load there is eta (d' - W'), so that eta a' is added to Einf a.
    """
    S, nodes, M, growth = STAGES, room.nodes, room.stiffness, room.vectors[6]
    grows = phase == GROWS and solid.viscosity > 0.0
    if grows:
        differentiate(rule, nodes[A], growth)
    for i in range(S):
        low, high = broadcast(0.0), broadcast(0.0)
        for k in range(solid.rates.shape[0]):
            low = low + solid.moduli[k] * read8(room.inverse, k, i, 0)
            high = high + solid.moduli[k] * read8(room.inverse, k, i, WIDTH)
        if phase == GROWS:
            low, high = low * read8(nodes, A, 1), high * read8(nodes, A, 1 + WIDTH)
            radius = nodes[A, i + 1]
        else:
            # Where the contact is lost the load at the axis is looked for.
            radius = nodes[A, i + 1] if nodes[A, i + 1] > 0.0 or not is_force(driver) else 1.0
            low, high = radius * low, radius * high
        write8(M, i, 0, low)
        write8(M, i, WIDTH, high)
        M[i, i] += solid.equilibrium * radius
        if grows and room.weights[i + 1] > 0.0:
            M[i, i] += solid.viscosity * growth[i + 1] / room.weights[i + 1]


@compiled
def write_jacobian(solid: Solid, driver: Driver, rule: Scheme, room: Room, phase: int, moving: bool) -> None:
    """Write the slope of the residual by the depths at the nodes, or by the velocities.

    A dashpot adds eta a dd' to the slopes of the forces.
    """
    S, nodes, M, slopes = STAGES, room.nodes, room.jacobian, room.stiffness
    if phase != FREE:
        write_stiffness(solid, driver, rule, room, phase)
    else:
        for i in range(S):
            write8(slopes, i, 0, broadcast(0.0))
            write8(slopes, i, WIDTH, broadcast(0.0))
    if not moving:
        for i in range(S):
            for j in range(S):
                M[i, j] = slopes[i, j]
            M[i, i] += driver.stiffness
            if phase != FREE and solid.viscosity > 0.0 and room.weights[i + 1] > 0.0:
                for j in range(S):
                    M[i, j] += solid.viscosity * nodes[A, i + 1] * rule.derivative[i + 1, j + 1] / room.weights[i + 1]
        return
    for i in range(S):
        if driver.mass == 0.0:
            slopes[i, i] += driver.stiffness
        elif driver.attraction > 0.0 and phase == FREE:
            # 2 C/(gap + cutoff)^3
            pull = min(nodes[PULL, i + 1], driver.attraction / driver.cutoff**2)
            slopes[i, i] -= 2.0 * pull * math.sqrt(pull / driver.attraction)
    # F with d = d0 + A w v: eta a + dF/dd A w.
    write_product(slopes, room.integral, M)
    if phase != FREE and solid.viscosity > 0.0:
        for i in range(S):
            M[i, i] += solid.viscosity * nodes[A, i + 1]
    if driver.mass == 0.0:
        return
    # v - u + R F = 0.
    for i in range(S):
        write8(slopes, i, 0, read8(M, i, 0))
        write8(slopes, i, WIDTH, read8(M, i, WIDTH))
    write_product(room.mobility, slopes, M)
    for i in range(S):
        M[i, i] += 1.0


@compiled
def missing_load(solid: Solid, room: Room, i: int, force: float) -> float:
    """Return what the load at the axis lacks for a force at a node of a shrinking contact.

    It is linear in the depths, and the force is about a power of it: `F = c q^e` with e = q a/F, as F' = a q'. Without
    contact at the node the power is that at the start of the step.
    """
    nodes = room.nodes
    q = axis_load(solid, room, i)
    target = 0.0
    if force > 0.0:
        n = i if nodes[F, i] > 0.0 and nodes[Y, i] > 0.0 else 0
        expected, now = q if n > 0 else axis_load(solid, room, 0), nodes[F, n]
        power = max(expected * nodes[A, n] / now, 1.0) if now > 0.0 else 1.0
        target = expected * (force / now) ** (1.0 / power)
    return target - q


@compiled
def write_residuals(solid: Solid, driver: Driver, room: Room, shrinks: bool, moving: bool) -> None:
    """Write what the equations of motion lack at the nodes into the last column of the matrix."""
    S, nodes, M = STAGES, room.nodes, room.matrix
    for i in range(S):
        n = i + 1
        if driver.mass == 0.0:
            M[i, S] = nodes[GIVEN, n] - nodes[F, n] - driver.stiffness * nodes[D, n]
            if moving and by_increase(solid, driver, room):
                M[i, S] = nodes[F, 0] + nodes[RISE, n] - nodes[F, n] - driver.stiffness * nodes[BELOW, n]
            if shrinks and is_force(driver):
                M[i, S] = missing_load(solid, room, n, nodes[GIVEN, n]) * (nodes[A, n] if nodes[A, n] > 0.0 else 1.0)
            continue
        M[i, S] = -excess_velocity(room, i)


@inlined
def write_rates(rule: Scheme, room: Room, depths: Any) -> None:
    """Write the rates at the nodes from depths there, wherever time passes."""
    slopes = room.vectors[7]
    differentiate(rule, depths, slopes)
    for i in range(1, NODES):
        if room.weights[i] > 0.0:
            room.nodes[V, i] = slopes[i] / room.weights[i]


@compiled
def apply_correction(rule: Scheme, room: Room, moving: bool, amount: float) -> None:
    """Add the correction in the last column of the matrix; the rates follow from the depths, or they from these."""
    S, nodes = STAGES, room.nodes
    for i in range(S):
        nodes[V if moving else D, i + 1] += amount * room.matrix[i, S]
    if moving:
        for i in range(S):
            total = 0.0
            for j in range(S):
                total += room.integral[i, j] * nodes[V, j + 1]
            nodes[D, i + 1], nodes[BELOW, i + 1] = nodes[D, 0] + total, total
        return
    write_rates(rule, room, nodes[D])


@compiled
def correct_touch(solid: Solid, rule: Scheme, room: Room, amount: float) -> None:
    """Add the correction in the last column of the matrix to the depths below the surface of a contact that begins.

    The rates follow from these depths and from the surface: differences of depths would be rounding where the gap is
    flat.
    """
    nodes, p = room.nodes, room.places[FREE_PANELS] - 1
    nodes[BELOW, 0] = 0.0
    for i in range(1, NODES):
        nodes[BELOW, i] += amount * room.matrix[i - 1, STAGES]
        nodes[D, i] = nodes[EVENT, i] + nodes[BELOW, i]
    write_rates(rule, room, nodes[BELOW])
    if p < 0:
        return
    for i in range(1, NODES):
        if room.weights[i] > 0.0:
            write_displacements(
                solid, room.free, p, room.free.end[p], room.times[i], room.parts, room.basis[0], room.basis[1]
            )
            for j in range(solid.recoveries.shape[0]):
                nodes[V, i] -= solid.recoveries[j] * room.parts[j]


@inlined
def is_by_logarithm(solid: Solid, driver: Driver, room: Room, phase: int) -> bool:
    """Return whether the unknowns of a step are logarithms of depths below the surface: where a contact begins.

    On a spring and a dashpot the rate of the body changes less than these depths.
    """
    touches = phase == GROWS and driver.mass == 0.0 and not room.nodes[A, 0] > 0.0
    return touches and (solid.viscosity == 0.0 or is_force(driver))


@compiled
def newton_step_of_touch(room: Room) -> tuple[bool, float]:
    """Correct the depths at the nodes of a contact that begins; return whether that can be done, and its part.

    The unknowns are the logarithms of the depths below the surface, which are about powers of the time: so the body
    stays in contact, where alone there is a stiffness. The surface at the axis is where an event is written later.
    """
    nodes, M, most = room.nodes, room.matrix, 0.0
    for i in range(STAGES):
        for j in range(STAGES):
            M[i, j] = room.jacobian[i, j] * nodes[BELOW, j + 1]
    if not solve_linear(M, STAGES):
        return False, 0.0
    for i in range(STAGES):
        most = max(most, abs(M[i, STAGES]))
    part = min(1.0, 1.0 / most) if most > 0.0 else 1.0
    for i in range(STAGES):
        M[i, STAGES] = nodes[BELOW, i + 1] * math.expm1(part * M[i, STAGES])
    return True, part


@compiled
def part_above_surface(room: Room, moving: bool) -> float:
    """Return the part of a correction that leaves a tenth of how far the body is below the surface at the axis.

    Without contact there is no stiffness. The surface at the axis is where an event is written later.
    """
    nodes, part = room.nodes, 1.0
    for i in range(STAGES):
        change = room.matrix[i, STAGES]
        if moving:
            change = 0.0
            for j in range(STAGES):
                change += room.integral[i, j] * room.matrix[j, STAGES]
        below = nodes[D, i + 1] - nodes[EVENT, i + 1]
        if below > 0.0 and change < -0.9 * below:
            part = min(part, -0.9 * below / change)
    return part


@compiled
def surface_at_axis(solid: Solid, room: Room, t: float) -> float:
    """Return the depth of the free surface at the axis."""
    p = room.places[FREE_PANELS] - 1
    if p < 0:
        return 0.0
    return gap(solid, room.free, p, room.free.end[p], t, 0.0, room.basis[0], room.basis[1])[0]


@compiled
def write_pull(solid: Solid, driver: Driver, room: Room, phase: int) -> None:
    """Write the pull of the surface at the nodes: by the gap at the axis, and constant in contact."""
    nodes, most = room.nodes, driver.attraction / (driver.cutoff * driver.cutoff)
    for i in range(NODES):
        nodes[PULL, i] = most
        if phase == FREE and most > 0.0:
            distance = (surface_at_axis(solid, room, room.times[i]) - nodes[D, i]) / driver.cutoff
            # A trial beyond the touch goes on along the tangent.
            nodes[PULL, i] = most / (1.0 + distance) ** 2 if distance > 0.0 else most * (1.0 - 2.0 * distance)


@compiled
def first_depth(problem: Problem, room: Room, t: float, level: float, modulus: float, force: float) -> float:
    """Return about how far a force presses a body, that just touches, below the surface at the axis.

    `E Pi(y) e/y^2 + k e = f` with the front y at the depth e, by secants of the logarithms.
    """
    e, slope, last, excess, top = 1.0, 2.0, 1.0, 0.0, room.places[FREE_PANELS] - 1
    for n in range(_MOST_GUESSES):
        y = math.sqrt(e)
        if top >= 0:
            p, _, front, _ = locate(
                problem.solid, room.free, top + 1, False, t, level + e, top, room.free.end[top], room.basis[0],
                room.basis[1],
            )  # fmt: skip
            y = max(y, front if p >= 0 else math.sqrt(max(level + e, 0.0)))
        load = modulus * radius_and_integral(problem.path, y)[1] * e / (y * y) + problem.driver.stiffness * e
        if not load > 0.0:
            break
        before, excess = excess, math.log(load / force)
        if abs(excess) < 1e-6:
            break
        if n > 0 and e != last:
            slope = min(max((excess - before) / math.log(e / last), 0.5), 4.0)
        last, e = e, e * math.exp(min(max(-excess / slope, -20.0), 20.0))
    return e


@compiled
def predict(problem: Problem, room: Room, phase: int) -> None:
    """Write a first guess of depths or velocities: under a constant force, or elastic growth."""
    solid, driver, nodes = problem.solid, problem.driver, room.nodes
    force = nodes[F, 0] if phase != FREE else 0.0
    for i in range(1, NODES):
        nodes[V, i], nodes[D, i] = nodes[V, 0], nodes[D, 0]
        if driver.mass > 0.0:
            nodes[V, i] = room.unloaded[i - 1]
            for j in range(STAGES):
                nodes[V, i] -= room.mobility[i - 1, j] * force
            continue
        rise = nodes[GIVEN, i] - nodes[F, 0] - driver.stiffness * nodes[D, 0]
        if phase == SHRINKS and is_force(driver):
            rise = missing_load(solid, room, 0, nodes[GIVEN, i]) * nodes[A, 0]
        if phase == FREE:
            if driver.stiffness > 0.0:
                nodes[D, i] = nodes[GIVEN, i] / driver.stiffness
        elif nodes[A, 0] > 0.0:
            # Against a dashpot the rate is constant.
            if solid.viscosity == 0.0:
                nodes[D, i] += rise / (driver.stiffness + solid.glass * nodes[A, 0])
        else:
            level = surface_at_axis(solid, room, room.times[i])
            force = nodes[GIVEN, i] - driver.stiffness * level
            modulus = solid.glass
            if solid.viscosity > 0.0:
                modulus += solid.viscosity / max(room.times[i] - room.times[0], 1e-300)
            nodes[EVENT, i], nodes[BELOW, i] = level, 0.0
            if force > 0.0:
                below = first_depth(problem, room, room.times[i], level, modulus, force)
                nodes[BELOW, i] = max(below, _DEPTH_ROUNDING * abs(level))
            nodes[D, i] = level + nodes[BELOW, i]
    if solid.viscosity > 0.0 and phase != FREE and driver.mass == 0.0 and not nodes[A, 0] > 0.0:
        write_rates(problem.rule, room, nodes[D])


@compiled
def write_start(solid: Solid, path: Path, room: Room, phase: int) -> None:
    """Write the state at the start of a step into its first node, and let the search for the front start there."""
    nodes, state, places = room.nodes, room.state, room.places
    basis, slopes = room.basis[0], room.basis[1]
    nodes[D, 0], nodes[V, 0], nodes[Y, 0], nodes[F, 0] = state[DEPTH], state[RATE], state[FRONT], state[FORCE]
    for k in range(solid.rates.shape[0]):
        room.h[k, 0], room.L[k, 0] = room.memory[k], room.sums[k]
    panels, place = ahead(room, phase)
    p = places[place] - 1
    z = panels.end[max(p, 0)]
    if p >= 0 and phase != FREE:
        # Where the front is fast, its place at a joint is known less well than the joint.
        polynomials(z, basis, slopes)
        nodes[Y, 0] = max(value_of(panels.coefficients[p, 0], basis), 0.0) if state[FRONT] > 0.0 else 0.0
    nodes[A, 0], nodes[PI, 0] = radius_and_integral(path, nodes[Y, 0])
    places[NO_FRONT_YET] = 1
    for i in range(NODES):
        room.at[i], room.z[i] = p, z
    if phase == SHRINKS:
        write_loads(
            solid, panels, p, z, state[TIME], room.h[:, 0], nodes[A, 0], room.loads[:, 0], room.L[:, 0], basis, slopes
        )  # fmt: skip
        return
    room.displacements[:, 0] = 0.0
    if p >= 0:
        write_displacements(solid, room.free, p, z, state[TIME], room.displacements[:, 0], basis, slopes)
    touch(solid, room.displacements[:, 0], room.loads[:, 0])


@compiled
def adopt_panel(problem: Problem, room: Room) -> None:
    """Start from the force that the panels of a shrinking contact have, where errors of the steps differ from it.

    Else it would jump at the first node, and no step would be smooth enough. A force on a spring and a dashpot follows
    from the depth, and the rate from it.
    """
    solid, scales, nodes = problem.solid, problem.scales, room.nodes
    force, damping = nodes[F, 0], solid.viscosity * nodes[A, 0]
    nodes[F, 0] = 0.0
    for k in range(solid.rates.shape[0]):
        nodes[F, 0] += room.L[k, 0]
    add_force(solid, problem.driver, problem.path, problem.rule, room, SHRINKS, 0)
    change = nodes[F, 0] - force
    excess = abs(change) / (scales.tolerance * scales.force)
    if is_light(problem) and damping > 0.0:
        nodes[F, 0] = force
        if excess <= _SAME_FORCE:
            nodes[V, 0] -= change / damping
    elif not 1.0 < excess <= _SAME_FORCE:
        nodes[F, 0] = force


@compiled
def write_given(problem: Problem, room: Room, step: Step) -> None:
    """Write times and what is prescribed at the nodes of a step."""
    nodes, state, driver = room.nodes, room.state, problem.driver
    t0 = state[TIME]
    for i in range(NODES):
        passed, pace = share(step.kind, problem.rule.c[i])
        x = (step.done + step.length * passed) / step.span
        room.times[i], room.weights[i] = t0, 0.0
        if step.passing == TIME_PASSES:
            room.times[i], room.weights[i] = t0 + step.length * passed, step.length * pace
        value, slope, rate = prescribed_at(driver, step.piece, min(x, 1.0), room.times[i])
        nodes[GIVEN, i], nodes[PACE, i] = value, slope / step.span + rate
        if driver.stiffness > 0.0 and problem.solid.viscosity > 0.0:
            x, dx = step.done / step.span, step.length * passed / step.span
            nodes[RISE, i] = rise_of_given(driver, step.piece, x, dx, t0, step.length * passed)
        if driver.by_depth:
            if i > 0:
                nodes[D, i] = value
            nodes[V, i] = nodes[PACE, i] if step.passing == TIME_PASSES else state[RATE]


@compiled
def solve_step(problem: Problem, room: Room, step: Step) -> bool:
    """Solve a step; whether there is a solution, and Newton's method converged."""
    solid, path, driver, rule = problem.solid, problem.path, problem.driver, problem.rule
    nodes, phase = room.nodes, step.phase
    if phase == SHRINKS and room.places[FOLLOWING] == 0:
        # There is no front.
        return False
    write_start(solid, path, room, phase)
    write_given(problem, room, step)
    write_integral(rule, room)
    if phase == SHRINKS:
        adopt_panel(problem, room)
    if phase != FREE:
        write_inverses(solid, room)
    if driver.by_depth:
        write_forces(solid, driver, path, rule, room, phase)
        return True
    if phase == FREE and is_force(driver):
        # Without a force the body lies on the surface.
        for i in range(1, NODES):
            nodes[D, i] = surface_at_axis(solid, room, room.times[i])
        write_forces(solid, driver, path, rule, room, phase)
        return True
    moving = by_rate(solid, driver, phase) and not is_by_logarithm(solid, driver, room, phase)
    if driver.mass > 0.0 and not write_response(driver, room):
        return False
    predict(problem, room, phase)
    # A step that failed may have left no numbers.
    room.matrix[:, STAGES] = 0.0
    if is_by_logarithm(solid, driver, room, phase):
        correct_touch(solid, rule, room, 0.0)
    else:
        apply_correction(rule, room, moving, 0.0)
    write_forces(solid, driver, path, rule, room, phase)
    write_pull(solid, driver, room, phase)
    # Without a force the first guess is the solution.
    is_alone = driver.mass > 0.0 and phase == FREE and driver.attraction == 0.0
    if not (is_alone or converges(problem, room, step, moving)):
        return False
    if driver.mass > 0.0:
        write_swings(driver, room)
    return True


@compiled
def is_balanced(problem: Problem, room: Room, phase: int) -> bool:
    """Return whether forces against a dashpot are those prescribed, within the tolerance of loads or rounding.

    A node without elements has no stiffness, and so no correction.
    """
    solid, scales = problem.solid, problem.scales
    write_residuals(solid, problem.driver, room, phase == SHRINKS, True)
    for i in range(STAGES):
        felt = scales.tolerance * scales.stress * room.nodes[A, i + 1]
        if abs(room.matrix[i, STAGES]) > felt + _FEW_ROUNDINGS * rounding_of_force(problem, room, i + 1):
            return False
    return True


@compiled
def converges(problem: Problem, room: Room, step: Step, moving: bool) -> bool:
    """Correct a first guess of depths or velocities by Newton's method; whether it converges."""
    solid, path, driver, rule, scales = problem.solid, problem.path, problem.driver, problem.rule, problem.scales
    nodes, phase = room.nodes, step.phase
    touches = phase == GROWS and driver.mass == 0.0 and not nodes[A, 0] > 0.0
    by_logarithm = is_by_logarithm(solid, driver, room, phase)
    last, change, ratio = math.inf, math.inf, 1.0
    reach = (step.length if moving else 1.0) / scales.depth
    light = moving and driver.mass == 0.0
    if light:
        reach = max(reach, solid.viscosity / scales.stress)
    for iteration in range(_MOST_ITERATIONS):
        write_residuals(solid, driver, room, phase == SHRINKS, moving)
        amount = 1.0
        if by_logarithm:
            write_jacobian(solid, driver, rule, room, phase, moving)
            solved, amount = newton_step_of_touch(room)
        else:
            # What is left by old factors is about the square of the last change.
            solved = driver.mass > 0.0 and change < _SMALL_CHANGE
            if not solved:
                write_jacobian(solid, driver, rule, room, phase, moving)
                solved = factorise(room.jacobian, room.pivots)
            if solved:
                solve_factorised(room.jacobian, room.pivots, room.matrix)
        if not solved:
            return False
        last, change, size = change, 0.0, 1.0
        for i in range(STAGES):
            part = abs(room.matrix[i, STAGES]) * reach
            felt = abs(room.matrix[i, STAGES]) > _DEPTH_ROUNDING * abs(nodes[D, i + 1])
            if by_logarithm and felt and nodes[BELOW, i + 1] > 0.0:
                # The rate, which loads a dashpot, is about a multiple of the depth below the surface.
                pace = abs(nodes[V, i + 1]) * solid.viscosity / scales.stress
                part = max(part, abs(room.matrix[i, STAGES]) * pace / nodes[BELOW, i + 1])
            # Rounding of forces that few elements share.
            if not (light and part <= rounding_of_load(problem, room, i + 1)):
                change = larger(change, part)
            size = max(size, abs(nodes[D, i + 1]) / scales.depth, abs(nodes[V, i + 1]) * reach)
        ratio = change / last if last > 0.0 else 0.0
        if not change < math.inf or (iteration > 8 and ratio > 2.0):
            return False
        if touches and moving:
            amount = part_above_surface(room, moving)
        if by_logarithm:
            correct_touch(solid, rule, room, 1.0)
        else:
            apply_correction(rule, room, moving, amount)
        write_forces(solid, driver, path, rule, room, phase)
        write_pull(solid, driver, room, phase)
        left = change * ratio / (1.0 - ratio) if iteration > 0 and ratio < 0.5 else change
        # Panels meet within the tolerance, so that a front next to a joint may not settle.
        settles = ratio >= 0.5 and change <= max(1e-12, _SETTLED * scales.tolerance)
        if amount == 1.0 and (settles or left <= max(1e-3 * scales.tolerance, 2e-15 * size)):
            return not light or is_balanced(problem, room, phase)
    return False
