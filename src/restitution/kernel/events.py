"""Events of a step: zeros of smooth functions of the depth and of its memory, where the front is not smooth.

Turnings (the front stands), joints of panels, corners of the profile, the touch and the end of the contact.
"""

import math
from typing import Any

from restitution.kernel.compile import compiled, inlined
from restitution.kernel.driver import (
    BENDS,
    ENDS,
    EVENT,
    FREE,
    GIVEN,
    GROWS,
    JOINT,
    NOTHING,
    PACE,
    PULL,
    SHRINKS,
    TIME_PASSES,
    TOUCHES,
    TURNS,
    A,
    D,
    F,
    Problem,
    Room,
    V,
    Y,
    ahead,
    ends_by_load,
    is_force,
    is_light,
    rounding_of_load,
)
from restitution.kernel.fronts import shared_load
from restitution.kernel.growth import differentiate
from restitution.kernel.lever import acceleration
from restitution.kernel.panels import (
    CORNER,
    FLAT,
    NODES,
    SMOOTH,
    Scheme,
    Stack,
    gap,
    load,
    polynomials,
    to_coefficients,
    value_of,
)
from restitution.kernel.path import Path
from restitution.kernel.stepper import surface_at_axis

# Depth up to which an element, over the depth of the run, lies at the axis.
AT_AXIS = 1e-10
# Error of a step, over the tolerance, that passes joints of panels: their kinks have decayed.
_UNFELT = 0.03
# y, over that at the end of the step, of elements that have just touched.
_FIRST = 0.03
# Load, over the tolerance, below which rounding decides which way a front moves.
_TURNING = 0.05


@inlined
def end_of_way(room: Room, phase: int) -> tuple[Stack, int]:
    """Stack which the front goes through, and the panel at whose lower end it meets the next joint; -1 without one."""
    panels, place = ahead(room, phase)
    p = room.places[place] - 1
    while p > 0:
        if panels.joint[p] != SMOOTH:
            y, sign = 0.0, 1.0
            for n in range(NODES):
                y += sign * panels.coefficients[p, 0, n]
                sign = -sign
            # Next to the axis elements are too few to be felt.
            if y * y > AT_AXIS:
                break
        p -= 1
    return panels, p


@compiled
def next_corner(path: Path, y: float) -> float:
    """Return the next corner of the profile beyond y; -1 if there is none."""
    best = -1.0
    for n in range(path.kinks.shape[0]):
        corner = path.kinks[n]
        if corner > y * (1.0 + 1e-13) and (best < 0.0 or corner < best):
            best = corner
    return best


@inlined
def pace_of_load(problem: Problem, room: Room, i: int, second: float) -> float:
    """Return the rate of the load at a shrinking front, over E0, at a node.

    `second` is d'' of a prescribed depth. Otherwise it follows from the equation of motion, or, without inertia, the
    rate of the shared load from that of the force: F' = a P' - sum rho_k (L_k - E_k h_k a).
    """
    solid, driver, nodes = problem.solid, problem.driver, room.nodes
    if solid.viscosity > 0.0 and is_light(problem):
        total = nodes[PACE, i] - driver.stiffness * nodes[V, i]
        for k in range(solid.rates.shape[0]):
            total += solid.rates[k] * (room.L[k, i] - room.loads[k, i] * nodes[A, i])
        return total / (solid.glass * nodes[A, 0])
    if driver.mass > 0.0:
        second = acceleration(driver, room, i, nodes[F, i] - nodes[PULL, i], nodes[D, i], nodes[V, i])
    total = solid.glass * nodes[V, i] + solid.viscosity * second
    for k in range(solid.rates.shape[0]):
        total -= solid.rates[k] * room.loads[k, i]
    return total / solid.glass


@compiled
def write_event(problem: Problem, room: Room, phase: int, event: int) -> float:
    """Write what passes zero from below at an event, at the nodes; return its value at the end of the step.

    TURNS: growing, the surface at the front rises faster than the body; shrinking, the load at the front rises.
    JOINT, ENDS: the front is beyond the lower end of the panel. TOUCHES: the body is below the surface.
    """
    solid, nodes, E = problem.solid, room.nodes, room.nodes[EVENT]
    basis, slopes, change = room.basis[0], room.basis[1], room.vectors[7]
    panels, p = end_of_way(room, phase)
    corner = next_corner(problem.path, nodes[Y, 0]) if event == BENDS else 0.0
    if event == TURNS and phase == SHRINKS and solid.viscosity > 0.0 and problem.driver.by_depth:
        differentiate(problem.rule, nodes[V], change)
    for i in range(1, NODES):
        t = room.times[i]
        if event == TOUCHES:
            by_force = is_force(problem.driver)
            E[i] = nodes[GIVEN, i] if by_force else nodes[D, i] - surface_at_axis(solid, room, t)
        elif event == BENDS:
            E[i] = nodes[D, i] - corner * corner
        elif event == TURNS and phase == GROWS:
            E[i] = -nodes[V, i]
            if room.at[i] >= 0:
                for j in range(solid.recoveries.shape[0]):
                    E[i] -= solid.recoveries[j] * room.displacements[j, i]
            if not nodes[A, 0] > 0.0:
                # The gap of the first elements that touch is rounding, and so may be the load of a dashpot there.
                rounding = 0.0
                if solid.viscosity > 0.0 and is_light(problem):
                    rounding = rounding_of_load(problem, room, i) * problem.scales.stress / solid.viscosity
                if nodes[Y, i] < _FIRST * nodes[Y, NODES - 1] or E[i] <= rounding:
                    E[i] = min(E[i], 0.0)
        elif event == TURNS:
            second = change[i] / room.weights[i] if problem.driver.by_depth and room.weights[i] > 0.0 else 0.0
            E[i] = pace_of_load(problem, room, i, second)
        elif event == ENDS and is_force(problem.driver):
            E[i] = -nodes[GIVEN, i]
        elif phase == GROWS:
            E[i] = -gap(solid, panels, p, 0.0, t, nodes[D, i], basis, slopes)[0]
        else:
            E[i] = -load(solid, panels, p, 0.0, t, shared_load(solid, room, i), basis, slopes)[0]
            if event == ENDS and ends_by_load(solid, problem.driver):
                # The force of a paraboloid, which is smooth; that of a cone, its square, may be so or have two zeros.
                E[i] *= math.sqrt(abs(E[i]))
    return E[NODES - 1]


@inlined
def peak_between(rule: Scheme, values: Any, i: int) -> tuple[float, float]:
    """Return the place and the value of the vertex of a parabola through a node and those beside it."""
    before, behind = rule.c[i] - rule.c[i - 1], rule.c[i + 1] - rule.c[i]
    rise, fall = (values[i] - values[i - 1]) / before, (values[i + 1] - values[i]) / behind
    slope, bend = (rise * behind + fall * before) / (before + behind), (fall - rise) / (before + behind)
    return rule.c[i] - 0.5 * slope / bend, values[i] - 0.25 * slope * slope / bend


@compiled
def crossing(rule: Scheme, room: Room, deadband: float, grazes: bool) -> float:
    """Return the smallest z in (0, 1] at which the event passes zero upwards; 2 if it does not.

    Also, if it may graze, where it passes zero twice between two nodes, as a surface that rises to the body.
    """
    values, row = room.nodes[EVENT], room.vectors[6]
    first = 0
    for i in range(NODES - 1, 0, -1):
        if values[i] > deadband:
            first = i
    peak, behind = 0.0, first if first > 0 else NODES - 1
    for i in range(behind - 1, 1, -1):
        if grazes and values[i] > values[i - 1] and values[i] > values[i + 1]:
            z, top = peak_between(rule, values, i)
            if top > deadband:
                first, peak = i, z
    if first == 0:
        return 2.0
    # At the start the last event has its zero: the value there follows from the other nodes.
    values[0] = 0.0
    for i in range(1, NODES):
        above, below = 1.0, 1.0
        for j in range(1, NODES):
            if j != i:
                above *= rule.c[j]
                below *= rule.c[j] - rule.c[i]
        values[0] += above / below * values[i]
    to_coefficients(rule, values, row)
    low, high = rule.c[first - 1], rule.c[first]
    if peak > 0.0:
        polynomials(peak, room.basis[0], room.basis[1])
        if not value_of(row, room.basis[0]) > deadband:
            return 2.0
        high = peak
    z = 0.5 * (low + high)
    for _ in range(60):
        polynomials(z, room.basis[0], room.basis[1])
        value, slope = value_of(row, room.basis[0]), value_of(row, room.basis[1])
        if value > 0.0:
            high = z
        else:
            low = z
        # Newton's method between bisections.
        target = z - value / slope if slope > 0.0 else low
        if abs(target - z) <= 1e-16 * z:
            break
        z = target if low < target < high else 0.5 * (low + high)
    return z


@inlined
def is_passed(panels: Stack, p: int, last: int) -> bool:
    """Return whether a smooth step that ends in panel `last` may pass the joint at the lower end of panel p.

    It does not if it reaches virgin surface or the end of the contact, or passes a corner of the profile.
    """
    while p > last >= 0 and panels.joint[p] != CORNER:
        p -= 1
    return p == last


@compiled
def first_event(
    problem: Problem, room: Room, phase: int, passing: int, length: float, error: float, settled: bool
) -> tuple[int, float]:
    """Return the first event of a step with this error and its z; (NOTHING, 2) if there is none."""
    event, first = NOTHING, 2.0
    panels, p = end_of_way(room, phase)
    to_end = phase == SHRINKS and p == 0
    # Before the end of the contact the front is like a root of the time: the last panel begins with a step.
    passes = p >= 0 and not (phase == SHRINKS and room.at[NODES - 1] == 0)
    passes = passes and error <= _UNFELT * problem.scales.tolerance
    passes = passes and is_passed(panels, p, room.at[NODES - 1])
    for candidate in (TURNS, ENDS if to_end else JOINT, TOUCHES, BENDS):
        deadband = 0.0
        if candidate == TURNS:
            if phase == FREE or passing != TIME_PASSES or settled:
                continue
            # A body that stands still turns by rounding.
            deadband = 1e-13 * problem.scales.depth / length
            if phase == GROWS and problem.solid.viscosity > 0.0 and is_light(problem):
                # The load at the front is that of the dashpot alone.
                deadband += _TURNING * problem.scales.tolerance * problem.scales.stress / problem.solid.viscosity
        elif candidate in (JOINT, ENDS):
            if phase == FREE or p < 0 or passes:
                continue
        elif candidate == TOUCHES:
            if phase != FREE:
                continue
        elif phase != GROWS or p >= 0 or next_corner(problem.path, room.nodes[Y, 0]) < 0.0:
            continue
        write_event(problem, room, phase, candidate)
        z = crossing(problem.rule, room, deadband, candidate == TOUCHES)
        if z < first:
            event, first = candidate, z
    return event, first


@compiled
def event_ahead(problem: Problem, room: Room, phase: int, kind: int) -> tuple[int, float]:
    """End of the front's way that it meets soon after the step, and after how many steps.

    Before such an end the front is like a root of the time that is left: a step that ends there is smooth, a shorter
    one is not.
    """
    panels, p = end_of_way(room, phase)
    event = ENDS if p == 0 and phase == SHRINKS else JOINT
    if p < 0 or kind != 1 or (event == JOINT and panels.joint[p] < FLAT):
        return NOTHING, 0.0
    value, E, c = write_event(problem, room, phase, event), room.nodes[EVENT], problem.rule.c
    n, m = NODES - 3, NODES - 6
    first, second = (value - E[n]) / (1.0 - c[n]), (E[n] - E[m]) / (c[n] - c[m])
    slope = first + (first - second) / (1.0 - c[m]) * (1.0 - c[n])
    if not (slope > 0.0 and -value < 2.0 * slope):
        return NOTHING, 0.0
    return event, 1.0 - value / slope
