"""Accuracy of a step of any history: how far depth, force, loads and front are from polynomials, over their scales.

Rounding that no shorter step removes does not count, nor a front whose place loads do not feel.
"""

from restitution.kernel.compile import compiled, inlined
from restitution.kernel.driver import (
    FREE,
    FREE_PANELS,
    GROWS,
    PULL,
    SHRINKS,
    SLOPE,
    A,
    D,
    F,
    Problem,
    Room,
    V,
    Y,
    ahead,
    is_light,
    rounding_of_front,
    rounding_of_load,
)
from restitution.kernel.fronts import shared_load
from restitution.kernel.jumps import smooth_front_at
from restitution.kernel.panels import NODES, gap, larger, load, tail
from restitution.kernel.stepper import surface_at_axis

# Weight of the error of the front: the force feels its square, as load and gap vanish there, and a panel that has been
# accepted leaves its error to the fronts that pass it.
_FRONT_SHARE = 0.1
# Error of a front, over the tolerance, from which on it matters whether loads feel it.
_NOTICED = 0.01
# Error of a free surface, over the depth of the run, with which a touch is found.
_RESOLVED = 1e-3
# Rise of a load or a gap, over the tolerance, at a front that stands.
_STRAY = 10.0
# Rounding of loads and gaps over their scales.
_BLUR = 2e-14
# Rounding of the rate where a contact begins, times the length of the step over the depth.
_ROUNDING_OF_RATE = 5e-14


@compiled
def _memory_error(problem: Problem, room: Room, scatters: bool) -> float:
    """Return the error of the sums of loads that a growing contact leaves to its panel.

    Where the front scatters and loads do not feel it, sums over elements scatter with it.
    """
    solid, scales, nodes = problem.solid, problem.scales, room.nodes
    values, worst = room.vectors[5], 0.0
    for k in range(solid.rates.shape[0]):
        common = room.loads[k, NODES - 1] - solid.moduli[k] * room.h[k, NODES - 1] if scatters else 0.0
        for i in range(NODES):
            values[i] = room.L[k, i] - (solid.moduli[k] * room.h[k, i] + common) * nodes[A, i]
        worst = larger(worst, tail(problem.rule, values) / scales.force)
    return worst


@compiled
def _front_error(problem: Problem, room: Room, y: float) -> float:
    """Return the error of the depth s = y^2 of the element at the front, over that of the run.

    `y` is that of an element which the front passes in the step.
    """
    rule, nodes, values = problem.rule, room.nodes, room.vectors[7]
    for i in range(NODES):
        values[i] = nodes[Y, i] * nodes[Y, i]
    # On virgin surface y^2 = d may be a polynomial where y is not.
    error = max(tail(rule, values), 2.0 * y * tail(rule, nodes[Y]))
    return _FRONT_SHARE / problem.scales.depth * error


@compiled
def _front_scatters(problem: Problem, room: Room, phase: int, touches: bool) -> bool:
    """Return whether loads do not feel how far the front is from a smooth one."""
    scales, nodes, steepest, worst = problem.scales, room.nodes, 0.0, 0.0
    for i in range(1, NODES):
        steepest = max(steepest, nodes[SLOPE, i])
        worst = max(worst, nodes[SLOPE, i] * abs(smooth_front_at(problem.rule, room, i) - nodes[Y, i]))
    if touches:
        worst = steepest * tail(problem.rule, nodes[Y])
    if phase == GROWS:
        worst *= problem.solid.glass
    return worst <= max(_BLUR * problem.solid.glass * scales.depth, 0.02 * scales.tolerance * scales.stress)


@compiled
def step_error(problem: Problem, room: Room, phase: int, length: float) -> float:
    """Return the error of depth, force, shared load and front over their scales.

    The front does not count where loads do not feel its scatter: where they have decayed nearly to zero, or the tip
    meets an imprint of nearly its own shape. A free body has no load, and of the surface only the touch matters, which
    is found in a resolved one and then solved for.
    """
    solid, scales, rule, nodes = problem.solid, problem.scales, problem.rule, room.nodes
    values = room.vectors[7]
    if phase == FREE:
        worst = tail(rule, nodes[D]) / scales.depth
        if room.places[FREE_PANELS] > 0:
            for i in range(NODES):
                values[i] = surface_at_axis(solid, room, room.times[i])
            worst = larger(worst, tail(rule, values) / scales.depth * scales.tolerance / _RESOLVED)
        return worst
    # A contact that begins on an imprint, whose depths below the surface may be rounding.
    touches = phase == GROWS and not nodes[A, 0] > 0.0 and is_light(problem) and room.places[FREE_PANELS] > 0
    for i in range(NODES):
        values[i] = 0.0
        for k in range(solid.rates.shape[0]):
            values[i] += solid.moduli[k] * room.h[k, i]
    worst = tail(rule, values) / scales.stress
    pull = tail(rule, nodes[PULL]) / scales.force if problem.driver.attraction > 0.0 else 0.0
    rounding = 0.0
    if phase == GROWS and solid.viscosity > 0.0 and problem.driver.by_depth:
        # Elements feel a dashpot as soon as they touch.
        for i in range(1, NODES):
            rounding = max(rounding, rounding_of_front(problem, room, i))
    for part in (tail(rule, nodes[D]) / scales.depth, (tail(rule, nodes[F]) - rounding) / scales.force, pull):
        worst = larger(worst, part)
    if solid.viscosity > 0.0 and not problem.driver.by_depth and length > 0.0 and phase != FREE:
        rounding = 0.0
        if touches:
            rounding = _ROUNDING_OF_RATE * nodes[D, NODES - 1] * solid.viscosity / (length * scales.stress)
        for i in range(NODES):
            values[i] = nodes[V, i] * room.weights[i]
            if is_light(problem) and i > 0:
                rounding += rounding_of_load(problem, room, i) * room.weights[i] / length
        worst = larger(worst, solid.viscosity / (length * scales.stress) * tail(rule, values) - rounding)
    # A contact that ends has a root of the time there, which is no reason for a shorter step.
    front = _front_error(problem, room, nodes[Y, NODES - 1])
    memory = _memory_error(problem, room, False) if phase == GROWS else 0.0
    noticed = front > _NOTICED * scales.tolerance or not memory <= scales.tolerance
    if (noticed or touches) and _front_scatters(problem, room, phase, touches):
        front = 0.0
        if phase == GROWS:
            memory = _memory_error(problem, room, True)
    return larger(larger(worst, memory), front)


@compiled
def leaves_scatter(problem: Problem, room: Room, phase: int) -> bool:
    """Return whether the front of a step is no polynomial that its panel can have, and loads do not feel it."""
    nodes = room.nodes
    if phase == FREE or not nodes[A, 0] > 0.0:
        return False
    error = _front_error(problem, room, max(nodes[Y, 0], nodes[Y, NODES - 1]))
    return error > _NOTICED * problem.scales.tolerance and _front_scatters(problem, room, phase, False)


@inlined
def _value_at_edge(problem: Problem, room: Room, phase: int, i: int) -> float:
    """Return load, over its scale, or gap at the edge of the contact at a node; 0 where the front has left it."""
    panels, place = ahead(room, phase)
    p, basis, slopes = room.places[place] - 1, room.basis[0], room.basis[1]
    end = panels.end[p]
    if room.at[i] != p or room.z[i] != end:
        return 0.0
    if phase == SHRINKS:
        drive = shared_load(problem.solid, room, i)
        return load(problem.solid, panels, p, end, room.times[i], drive, basis, slopes)[0] / problem.scales.stress
    return gap(problem.solid, panels, p, end, room.times[i], room.nodes[D, i], basis, slopes)[0] / problem.scales.depth


@compiled
def strays(problem: Problem, room: Room, phase: int) -> bool:
    """Return whether a front on a dashpot stands at the edge while load or gap rises: it should move the other way."""
    dashpot = problem.solid.viscosity > 0.0 and is_light(problem)
    if phase == FREE or not dashpot or room.places[ahead(room, phase)[1]] == 0:
        return False
    before, behind = _value_at_edge(problem, room, phase, 1), _value_at_edge(problem, room, phase, NODES - 1)
    return behind - max(before, 0.0) > _STRAY * problem.scales.tolerance
